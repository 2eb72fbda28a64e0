"""A law of contact that yields a multiple of another one."""

from __future__ import annotations

import dataclasses
from typing import TypeAlias

from numpy.typing import ArrayLike

from gearfem.contact.edge import EdgedLine, Line
from gearfem.foundation import Array, InputError, Record


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class ScaledLaw(Record):
    """A law whose approach is a multiple of another law's, at every load.

    Parameters
    ----------
    law : EdgedLine or ScaledLaw
        The other law.
    scale : float
        Multiple, positive; 1 gives every value back bit for bit.

    Raises
    ------
    InputError
        If the scale is not positive.
    """

    law: Law
    scale: float

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0.0 < self.scale < float("inf"):
            raise InputError("scale", self.scale, "a positive number; 1 leaves the contact as it is")

    def respond(self, force_per_width: ArrayLike, line: Line) -> tuple[Array, Array]:
        """Return approach and compliance together; arguments and errors as `EdgedLine.respond`."""
        approach, compliance = self.law.respond(force_per_width, line)
        return self.scale * approach, self.scale * compliance

    def beside(self, force_per_width: ArrayLike, distance: ArrayLike, line: Line) -> Array:
        """Return the approach beside a contact, per load on it [m per N/m]; arguments and errors as `EdgedLine.beside`."""
        return self.scale * self.law.beside(force_per_width, distance, line)


Law: TypeAlias = EdgedLine | ScaledLaw
