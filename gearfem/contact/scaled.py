"""Laws of contact that differ from another one: by a multiple of it, or over tip edges."""

from __future__ import annotations

import dataclasses
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from gearfem.contact.edge import EdgedLine, Line
from gearfem.foundation import Array, InputError, Record

# Arc to an edge that no band of contact reaches [m].
FAR = 1.0


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class ScaledLaw(Record):
    """A law whose approach is a multiple of another law's, at every load.

    Parameters
    ----------
    law : EdgedLine, ScaledLaw or EvenLaw
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


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class EvenLaw(Record):
    """A law that yields over tip edges as between them and flanks that go on past them.

    Parameters
    ----------
    law : EdgedLine, ScaledLaw or EvenLaw
        The other law.
    evenness : float
        Share of the flanks; 0 gives every value of the other law back, 1 knows no edges. Where these touch stays. A little beyond either
        contact over edges yields more than by their rounds, or less than on the flanks.

    Raises
    ------
    InputError
        If the evenness is not from -0.5 to 1.5.
    """

    law: Law
    evenness: float

    def __post_init__(self) -> None:
        super().__post_init__()
        if not -0.5 <= self.evenness <= 1.5:
            raise InputError("evenness", self.evenness, "a number from -0.5 to 1.5; 0 leaves edges as they are, 1 knows none")

    def respond(self, force_per_width: ArrayLike, line: Line) -> tuple[Array, Array]:
        """Return approach and compliance together; arguments and errors as `EdgedLine.respond`."""
        far = line._replace(edge=np.full_like(line.edge, FAR))
        edged, even = self.law.respond(force_per_width, line), self.law.respond(force_per_width, far)
        approach, compliance = (own + self.evenness * (flank - own) for own, flank in zip(edged, even, strict=True))
        return approach, compliance

    def beside(self, force_per_width: ArrayLike, distance: ArrayLike, line: Line) -> Array:
        """Return the approach beside a contact, per load on it [m per N/m]; arguments and errors as `EdgedLine.beside`."""
        return self.law.beside(force_per_width, distance, line)


Law: TypeAlias = EdgedLine | ScaledLaw | EvenLaw


def on_flanks(law: Any) -> Any:
    """Return the simplest law that is the same as another one where no tip edge is near."""
    if isinstance(law, EvenLaw):
        return on_flanks(law.law)
    return dataclasses.replace(law, law=on_flanks(law.law)) if isinstance(law, ScaledLaw) else law


def evened(law: Law, evenness: float) -> Law:
    """Return a law evened out over tip edges, see `EvenLaw`; itself if it is not."""
    return EvenLaw(law=law, evenness=evenness) if evenness else law
