"""Two loads on one tooth: what it yields at one of them under the other."""

from __future__ import annotations

import numpy as np

from gearfem.compliance.finite_elements import FiniteElements
from gearfem.compliance.record import ToothCompliance
from gearfem.compliance.section_mesh import unworn
from gearfem.flank import Outline
from gearfem.foundation import Array
from gearfem.foundation.cache import remembered
from gearfem.foundation.threads import one_thread


def likeness(tooth: ToothCompliance) -> Array:
    """Return how alike loads at two places of a tooth move it.

    Parameters
    ----------
    tooth : ToothCompliance
        Compliance over load positions.

    Returns
    -------
    ndarray, shape (n, n)
        M_ij / sqrt(M_ii M_jj), 1 on the diagonal: M_ij is the displacement along load line i, where it crosses the centreline, under a
        load at j. Dimensionless.

    Notes
    -----
    Plane strain finite elements of the sound tooth on its whole gear. Wear, cracks and bodies that yield more change M_ii, which
    the caller has; the likeness, 0.96 to 0.99 for places a quarter of a module apart, is taken not to change with them.
    The table is made symmetric: readings lie on the centreline and loads on the flank, which makes up to 9 % between root and tip.
    """
    return _likeness(unworn(tooth.outline), tooth.u)


@remembered
def _likeness(outline: Outline, u: Array) -> Array:
    with one_thread():
        loads, structure = FiniteElements()._loaded(outline, u)
        shown = loads.reading.T @ structure.displacements(loads.load, (0,))[0]
    scale = np.sqrt(np.diag(shown))
    table: Array = (shown + shown.T) / (2.0 * scale[:, None] * scale[None, :])
    return table
