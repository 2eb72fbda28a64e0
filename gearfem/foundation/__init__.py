"""What every other package stands on: records, errors, units, guards and atomic files."""

from gearfem.foundation.errors import UNCOMPUTABLE, InputError, SolveError
from gearfem.foundation.record import Array, Record, digest

__all__ = ["UNCOMPUTABLE", "Array", "InputError", "Record", "SolveError", "digest"]
