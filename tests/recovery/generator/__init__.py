"""Blind test campaigns of spur gear pairs with known causes.

Written from the governing equations and the exchanged file formats alone, without a look at the package under test, and
frozen before the first score. It shares nothing with that package: neither code nor tooth compliance nor contact law nor
time integrator. Teeth are variable-section beams on Sainsot's foundation, contacts follow a power or a logarithmic law of
their own, corners are met outside the path by exact geometry, quasi-static load sharing is a semi-smooth Newton iteration
over all angles at once, and motion is integrated by an exponential (exact linear part) scheme.

`make_case(seed, kind)` returns one campaign with its label; `python -m tests.recovery.generator --help` writes many.
SI and radians inside; millimetres and micrometres only in what is written.
"""

from .campaign import Case, make_case
from .write import write_case

__all__ = ["Case", "make_case", "write_case"]
