"""Laws of contact: Hertz lines with their approach to a depth, lines over a tip edge, and Coulomb friction."""

from gearfem.contact.edge import EdgedLine, Line
from gearfem.contact.friction import Coulomb
from gearfem.contact.hertz import SMALLEST_LINE_LOAD, HertzLine

__all__ = ["SMALLEST_LINE_LOAD", "Coulomb", "EdgedLine", "HertzLine", "Line"]
