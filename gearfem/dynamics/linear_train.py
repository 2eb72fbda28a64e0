"""The linear part of a drive train as seen from the teeth: accelerations of their lag and of the stretches of shafts and supports."""

from __future__ import annotations

import dataclasses

import numpy as np

from gearfem.dynamics.record import DriveTrain
from gearfem.dynamics.shafting import Shafting
from gearfem.foundation import Array, Record


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class LinearTrain(Record):
    """Coordinates y (n,): the lag r_b1 psi1 - r_b2 psi2 [m], then k = n - 1 stretches of shafts [rad] and supports [m].

    Parameters
    ----------
    by_load : ndarray, shape (n + 1, 5)
        Accelerations of y and, in the last row, of psi1, per T1, M1, T2, M2 and normal force, see `Shafting`.
    by_place, by_rate : ndarray, shape (n + 1, n)
        The same per y and its rate.
    touch : ndarray, shape (n,)
        Approach of the flanks per y: the lag less what the supports yield.
    shafting : Shafting
        What it was made from.
    """

    by_load: Array
    by_place: Array
    by_rate: Array
    touch: Array
    shafting: Shafting

    def rates(self, stiffness: float, damper: float, base1: float, base2: float) -> tuple[float, float]:
        """Return slowest decay and fastest rate [1/s] of the train, its teeth in contact with a mean stiffness and a damper.

        Parameters
        ----------
        stiffness, damper : float
            Along the line of action [N/m], [N s/m].
        base1, base2 : float
            Base radii [m].

        Returns
        -------
        tuple of float
            Least decay of all modes, and largest magnitude of the eigenvalues.
        """
        count = self.touch.size
        pushed = np.outer(self.by_load[:count] @ [0.0, base1, 0.0, base2, 1.0], self.touch)
        system = np.zeros((2 * count, 2 * count))
        system[:count, count:] = np.eye(count)
        system[count:, :count] = self.by_place[:count] + stiffness * pushed
        system[count:, count:] = self.by_rate[:count] + damper * pushed
        values = np.linalg.eigvals(system)
        return float(-values.real.max()), float(np.abs(values).max())

    def start(self, pinion_torque: float, ratio: float, base1: float, error: float, rate: float) -> Array:
        """Return coordinates and rates, shape (2, n), under steady torques at a lag [m] of the rigidly held gears and its rate."""
        stretch = self.shafting.static_stretches(pinion_torque, pinion_torque * ratio, pinion_torque / base1)
        lag = error - float(self.touch[1:] @ stretch)
        return np.array([[lag, *stretch], [rate, *np.zeros_like(stretch)]])


def linear_train(drive: DriveTrain, base1: float, base2: float) -> LinearTrain:
    """Return the linear part of a drive train.

    Parameters
    ----------
    drive : DriveTrain
        Inertias, shafts and supports.
    base1, base2 : float
        Base radii [m].

    Returns
    -------
    LinearTrain

    Examples
    --------
    >>> drive = DriveTrain(pinion_inertia=0.5, wheel_inertia=4.0, pinion_torque=10.0, wheel_torque=20.0,
    ...     efficiency=1.0, pinion_speed=50.0, friction_coefficient=0.0, damping_ratio=0.1)
    >>> linear_train(drive, 0.1, 0.2).by_load.tolist()
    [[0.2, -0.2, 0.05, -0.05, 0.0], [2.0, -2.0, 0.0, 0.0, 0.0]]
    """
    train = Shafting(drive)
    rows = np.zeros((2 + train.springs.size, train.masses.size))
    rows[0, 0], rows[0, train.wheel], rows[-1, 0] = base1, -base2, 1.0
    rows[1:-1] = train.stretches
    per_force = rows / train.masses
    none = np.zeros((len(rows), 1))
    return LinearTrain(
        by_load=per_force @ train.loads,
        by_place=np.hstack([none, -per_force @ (train.stretches.T * train.springs)]),
        by_rate=np.hstack([none, -per_force @ (train.stretches.T * train.dampers)]),
        touch=np.array([1.0, *-train.supports.astype(float)]),
        shafting=train,
    )
