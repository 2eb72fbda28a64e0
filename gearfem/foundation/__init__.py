"""What every other package stands on: records, errors, units, guards and atomic files."""

from gearfem.foundation.errors import InputError, SolveError
from gearfem.foundation.record import Array, Record, digest

__all__ = ["Array", "InputError", "Record", "SolveError", "digest"]
