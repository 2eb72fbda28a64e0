"""python -m gearfem."""

from gearfem.cli import main

main(prog_name="gearfem")
