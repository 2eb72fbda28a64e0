"""The command line. Only click is imported until a command runs."""

from gearfem.cli import further_commands
from gearfem.cli.commands import main

__all__ = ["further_commands", "main"]
