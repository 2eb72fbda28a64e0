"""The linear part of a drive train: its inertias, shafts and supports, without the teeth."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gearfem.dynamics.record import DriveTrain
from gearfem.foundation import Array

# Loads that act on the shafting, in this order: T1, moment of the teeth on the pinion, T2, moment on the wheel, normal force.
LOADS = 5


class Shafting:
    """Inertias joined by shafts and supports, as matrices.

    Coordinates w: psi1 and the inertias of its chain, psi2 and those of its chain (each turning as its gear does) [rad],
    then the displacements of the gears away from each other along the line of action [m], where supports yield.

    Parameters
    ----------
    drive : DriveTrain
        What is joined, and how.

    Notes
    -----
    m w'' = E L - Z^T (k Z w + d Z w'), with L = (T1, M1, T2, M2, P): the teeth brake the pinion by M1, drive the wheel by M2 and
    push both gears apart by P; T1 and T2 act at the ends of the chains. Rows of the stretches Z: outer less inner angle on
    the pinion's side, inner less outer on the wheel's (positive twist carries the working load), and the displacements.
    Friction, across the line of action, does not push the supports.
    """

    def __init__(self, drive: DriveTrain) -> None:
        chains, supports = (drive.pinion_chain, drive.wheel_chain), [drive.pinion_support, drive.wheel_support]
        held = [support for support in supports if support is not None]
        parts = [*chains[0], *chains[1]]
        self.wheel = 1 + len(chains[0])
        one, two = (
            (drive.pinion_inertia, *(part.inertia for part in chains[0])),
            (
                drive.wheel_inertia,
                *(part.inertia for part in chains[1]),
            ),
        )
        self.masses: Array = np.array([*one, *two, *(support.mass for support in held)])
        self.springs: Array = np.array([*(part.stiffness for part in parts), *(1.0 / support.compliance for support in held)])
        self.dampers: Array = np.array([*(part.damping for part in parts), *(support.damping for support in held)])
        self.supports: NDArray[np.bool_] = np.arange(self.springs.size) >= len(parts)
        gears = [gear for gear, support in zip(("pinion", "wheel"), supports, strict=True) if support is not None]
        self.stretch_names = (*(f"shaft of {part.name}" for part in parts), *(f"support of the {gear}" for gear in gears))
        self.names = (
            "pinion",
            *(part.name for part in chains[0]),
            "wheel",
            *(part.name for part in chains[1]),
            *(f"support of the {gear}" for gear in gears),
        )
        self._join(len(chains[0]), len(chains[1]))

    def _join(self, before: int, after: int) -> None:
        """Lay out stretches (n, n + 2) and loads (n + 2, 5) for chains of these lengths."""
        count = self.springs.size
        self.stretches = np.zeros((count, count + 2))
        self.loads = np.zeros((count + 2, LOADS))
        for row in range(before):
            self.stretches[row, [row, row + 1]] = -1.0, 1.0
        for row in range(before, before + after):
            self.stretches[row, [row + 1, row + 2]] = 1.0, -1.0
        for row in range(before + after, count):
            self.stretches[row, row + 2] = self.loads[row + 2, 4] = 1.0
        self.loads[before, 0], self.loads[0, 1] = 1.0, -1.0
        self.loads[self.wheel + after, 2], self.loads[self.wheel, 3] = -1.0, 1.0

    def depth_row(self, radius1: float, radius2: float) -> Array:
        """Return how the approach of the flanks follows from the coordinates: r_b1 psi1 - r_b2 psi2 less the displacements."""
        row = np.zeros(self.masses.size)
        row[0], row[self.wheel] = radius1, -radius2
        row[2:][self.supports] -= 1.0
        return row

    def static_stretches(self, pinion_torque: float, wheel_torque: float, normal_force: float) -> Array:
        """Return the stretches under steady loads, shape (n,)."""
        carried = np.where(np.arange(self.springs.size) < self.wheel - 1, pinion_torque, wheel_torque)
        return np.where(self.supports, normal_force, carried) / self.springs
