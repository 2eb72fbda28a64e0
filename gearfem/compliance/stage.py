"""The stage that turns the flanks of both gears into their compliance."""

from __future__ import annotations

import dataclasses
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from gearfem.compliance.finite_elements import FiniteElements
from gearfem.compliance.record import Compliance, ComplianceCurve, ToothCompliance
from gearfem.compliance.section_mesh import unworn
from gearfem.compliance.worn import odd_tooth, worn_tooth
from gearfem.definition.setup import Member
from gearfem.flank import Flanks, Outline
from gearfem.foundation import Array
from gearfem.foundation.progress import Progress, quiet

MEMBERS: tuple[Member, ...] = ("pinion", "wheel")
# Positions on the first half of the tip round, where a bent tooth touches before and after its path of contact.
ON_ROUND = 4


class CurveMethod(Protocol):
    """A way to compute a compliance curve and to estimate its error."""

    def curve(self, outline: Outline, u: ArrayLike) -> ComplianceCurve:
        """Return the compliance over load positions."""

    def error(self, outline: Outline, u: ArrayLike) -> Array:
        """Return the estimated relative error of `curve`, of the positions it keeps."""


Curve = TypeVar("Curve", bound=ComplianceCurve)


def with_error(method: CurveMethod, outline: Outline, curve: Curve) -> Curve:
    """Return a curve with the estimate of its error beside it.

    Parameters
    ----------
    method : CurveMethod
        Method that computed the curve.
    outline : Outline
        Outline of the tooth.
    curve : ComplianceCurve
        The curve; one with the coupling of neighbours keeps it.

    Returns
    -------
    ComplianceCurve
        The same with `error`.
    """
    return dataclasses.replace(curve, error=method.error(outline, curve.u))


def load_positions(outline: Outline, count: int = 40) -> Array:
    """Return load positions that resolve a compliance curve: on the whole flank and on half of the tip round.

    Parameters
    ----------
    outline : Outline
        Outline of the tooth.
    count : int
        Number of positions, at least 10.

    Returns
    -------
    ndarray, shape (count,)
        Parameters u: Chebyshev-Lobatto points of the roll length on the flank, ends included, and equal steps from 3 to 3.5,
        or to where the normal has turned by 60 degrees if that comes first.

    Examples
    --------
    >>> from gearfem.definition.setup import Gear, Material, Rack
    >>> gear = Gear(teeth=17, module=1e-3, pressure_angle=0.349, profile_shift=0.0, flank_thinning=0.0, root_radius=7.25e-3,
    ...             tip_radius=9.5e-3, tip_edge_radius=2e-5, bore_radius=4e-3, rack=Rack(), material=Material())
    >>> u = load_positions(Outline(gear=gear), 20)
    >>> len(u), float(u[0]), float(u[-1])
    (20, 2.0, 3.5)
    """
    on_flank = count - ON_ROUND
    if on_flank < 6:
        raise ValueError(f"at least {6 + ON_ROUND} load positions are needed, not {count}")
    flank = 2.5 - 0.5 * np.cos(np.pi * np.arange(on_flank) / (on_flank - 1))
    start, end = (np.arctan2(*outline.normal(np.array(u))[::-1]) for u in (3.0, np.nextafter(4.0, 3.0)))
    reach = min(0.5, np.radians(60.0) / (start - end))
    return np.concatenate([flank, 3.0 + reach * np.arange(1, ON_ROUND + 1) / ON_ROUND])


def make_compliance(flanks: Flanks, method: FiniteElements | None = None, positions: int = 40, progress: Progress = quiet) -> Compliance:
    """Compute the compliance of both gears, whole, each held at its bore, worn and odd teeth included.

    Parameters
    ----------
    flanks : Flanks
        Outlines of both gears.
    method : FiniteElements
        By default in plane strain.
    positions : int
        Load positions on each tooth.
    progress : Progress
        Told after each gear.

    Returns
    -------
    Compliance

    Raises
    ------
    SolveError, InputError
        As the method does.

    Notes
    -----
    What little metal is missing from a flank costs no finite elements of its own: `gearfem.compliance.worn`.
    """
    method = method or FiniteElements()
    teeth, odd = [], []
    for done, member in enumerate(MEMBERS):
        progress("tooth compliance", done, 2)
        outline = flanks.of(member)
        usual, several = _on_same_positions(method, flanks, member, load_positions(unworn(outline), positions))
        teeth.append(usual)
        odd.append(several)
    progress("tooth compliance", 2, 2)
    return Compliance(pinion=teeth[0], wheel=teeth[1], pinion_odd=odd[0], wheel_odd=odd[1])


def _on_same_positions(
    method: FiniteElements, flanks: Flanks, member: Member, u: Array
) -> tuple[ToothCompliance, tuple[tuple[int, ToothCompliance], ...]]:
    """Return the tooth of a gear and its odd ones; positions that one of them cannot carry are left out for all."""
    outline = flanks.of(member)
    while True:
        usual = worn_tooth(method, outline, u)
        several = tuple((number, odd_tooth(method, one, outline, usual.u)) for number, one in sorted(flanks.odd(member).items()))
        least = min((tooth.u for tooth in (usual, *(tooth for _, tooth in several))), key=len)
        if least.size == usual.u.size:
            return usual, several
        u = least
