"""One tooth alone, held at its root."""

from __future__ import annotations

from typing import Any

import numpy as np

from gearfem.compliance.ring import factorise
from gearfem.compliance.section_mesh import SectionMesh
from gearfem.foundation import Array


class Alone:
    """One tooth, held at its root: the counterpart of `Ring` without neighbours.

    Parameters
    ----------
    section : SectionMesh
        The tooth.
    stiffness : csc_matrix, shape (2 n, 2 n)
        Its stiffness matrix [Pa].
    """

    def __init__(self, section: SectionMesh, stiffness: Any) -> None:
        nodes = section.mesh.doflocs.shape[1]
        free = np.setdiff1d(np.arange(nodes), section.held)
        self._free = np.concatenate([free, free + nodes])
        self._factors = factorise(stiffness[self._free][:, self._free])

    def deflection(self, load: Array, reading: Array) -> Array:
        """Return what each reading shows under the load of the same column, shape (k,)."""
        shown: Array = np.einsum("ij,ij->j", reading, self.displacements(load, (0,))[0])
        return shown

    def displacements(self, load: Array, offsets: tuple[int, ...]) -> Array:
        """Return the nodal displacements, shape (1, 2 n, k); there is no other sector than 0."""
        if offsets != (0,):
            raise ValueError(f"a tooth held at its root has no neighbours {offsets}")
        result = np.zeros_like(load)
        result[self._free] = self._factors.solve(np.ascontiguousarray(load[self._free]))
        return result[None]
