"""What every other package stands on: records, errors, units, guards and atomic files."""

from gearfem.foundation.errors import UNCOMPUTABLE, EffectError, InputError, SolveError
from gearfem.foundation.record import Array, Record, digest

__all__ = ["UNCOMPUTABLE", "Array", "EffectError", "InputError", "Record", "SolveError", "digest"]
