"""Solid teeth under a uniform load as one more method of compliance curves, with an estimate of its error."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import ArrayLike

from gearfem.compliance.finite_elements import COARSER, changed
from gearfem.compliance.record import ComplianceCurve
from gearfem.compliance.solid import SolidElements
from gearfem.flank import Outline
from gearfem.foundation import Array, InputError, Record
from gearfem.foundation.cache import remembered

# Load positions of a solid curve, from above the foot of the flank to its tip: each costs as much as a whole plane curve.
LOWEST, POSITIONS = 2.2, 9
# Resolution at which two teeth held at their roots take seconds, 0.15 % off at the foot of the flank, less above it.
QUICK = 1.0


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class SolidCurve(Record):
    """Compliance of `SolidElements` on a given face width, width average under a uniform load.

    Parameters
    ----------
    method : SolidElements
        Elements, support and resolution.
    face_width : float
        Face width [m].

    Examples
    --------
    >>> import math
    >>> from gearfem.definition.setup import Gear, Material, Rack
    >>> from gearfem.compliance import Root
    >>> gear = Gear(teeth=17, module=1e-3, pressure_angle=math.radians(20), profile_shift=0.0, flank_thinning=0.0,
    ...             root_radius=7.25e-3, tip_radius=9.5e-3, tip_edge_radius=2e-5, bore_radius=4e-3, rack=Rack(),
    ...             material=Material())
    >>> method = SolidCurve(method=SolidElements(support=Root(), resolution=0.75, layers=4), face_width=0.01)
    >>> bool(method.error(Outline(gear=gear), [2.5, 2.8]).max() < 0.01)
    True
    """

    method: SolidElements
    face_width: float

    @property
    def name(self) -> str:
        """Name in files, ``fe_3d``."""
        return self.method.name

    def positions(self) -> Array:
        """Return load positions that show the curve, as parameters u of the outline."""
        return np.linspace(LOWEST, 3.0, POSITIONS)

    def curve(self, outline: Outline, u: ArrayLike) -> ComplianceCurve:
        """Return the compliance over load positions, as `SolidElements.curve` does.

        Parameters
        ----------
        outline : Outline
            Outline of the tooth, and through it the gear.
        u : array_like, shape (n,)
            Increasing positions in [2, 4).

        Returns
        -------
        ComplianceCurve

        Raises
        ------
        InputError, SolveError
            As `SolidElements.curve` does.
        """
        return _curve(self.method, outline, np.atleast_1d(np.asarray(u, dtype=float)), self.face_width)

    def error(self, outline: Outline, u: ArrayLike) -> Array:
        """Estimate the relative error of `curve` at each of its positions.

        Parameters
        ----------
        outline, u
            As for `curve`.

        Returns
        -------
        ndarray, shape (n,)
            Positive estimates, of the positions that `curve` keeps.

        Raises
        ------
        InputError
            If resolution or layers leave no coarser mesh, besides the reasons of `curve`.

        Notes
        -----
        As `FiniteElements.error`, with section and layers coarser by 1.5 at once. The observed order of both is above the 2 that is
        taken; in the layers it is that of the width average with the root held, whose share of the error is the smaller one.
        """
        resolution, layers = self.method.resolution / COARSER, round(self.method.layers / COARSER)
        if resolution < 0.5 or layers < 2:
            found = f"resolution {self.method.resolution:g} with {self.method.layers} layers"
            raise InputError("solid elements", found, "at least 0.75 and 3 for an estimate of the error from a coarser mesh")
        coarse = dataclasses.replace(self, method=dataclasses.replace(self.method, resolution=resolution, layers=layers))
        return changed(self.curve(outline, u).deflection, coarse.curve(outline, u).deflection)


@remembered
def _curve(method: SolidElements, outline: Outline, u: Array, face_width: float) -> ComplianceCurve:
    return method.curve(outline, u, face_width)
