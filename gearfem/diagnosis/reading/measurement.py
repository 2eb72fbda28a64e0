"""One measured series of a campaign, in SI."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearfem.definition.setup import Member
from gearfem.diagnosis.reading.quantities import QUANTITIES, Quantity
from gearfem.diagnosis.reading.roles import Role
from gearfem.foundation import Array, Record
from gearfem.sensing import Request, requests


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Measurement(Record):
    """One measured series in SI.

    Parameters
    ----------
    file : str
        As named in the campaign; the name of the record.
    quantity : Quantity
        What was measured over what.
    axis, value : ndarray, shape (n,)
        Pinion angle [rad], pinion speed [rad/s], roll length [m] or tooth number; the measured value in SI.
    line : ndarray of int, shape (n,)
        Line of the file behind each row.
    keep : ndarray of bool, shape (n,)
        False for rows that a repairable fault masks.
    pinion_torque, pinion_speed : float
        [N m], [rad/s]; 0 where the quantity has none.
    gear : {"pinion", "wheel"} or None
        Gear of a record of one gear.
    tooth : int or None
        Tooth of a flank.
    tooth_known : bool
        Whether the number of the first tooth is known.
    noise_std : float or None
        Stated standard deviation of the instrument, in SI.
    role : {"fit", "holdout"}
        What the record is for.
    role_given : bool
        Whether the campaign says so itself.
    kick : (float, float)
        How its motion begins, see `gearfem.dynamics.turns.march_turns`: nobody noted it, and several motions may be steady.
    erratic : bool
        Whether the model foretells no such motion, see `gearfem.diagnosis.comparing.erratic`: its mean counts for nothing.
    """

    file: str
    quantity: Quantity
    axis: Array
    value: Array
    line: NDArray[Any]
    keep: NDArray[Any]
    pinion_torque: float = 0.0
    pinion_speed: float = 0.0
    gear: Member | None = None
    tooth: int | None = None
    tooth_known: bool = True
    noise_std: float | None = None
    role: Role = "fit"
    role_given: bool = False
    kick: tuple[float, float] = (0.0, 0.0)
    erratic: bool = False

    @property
    def to_file(self) -> float:
        """Factor from SI to the unit of the file's measured column."""
        return 1.0 / self.quantity.factors[1]

    @property
    def proves(self) -> bool:
        """Whether it speaks for or against a name: held out, and no erratic motion."""
        return self.role == "holdout" and not self.erratic

    def request(self, first_tooth: int = 0, **otherwise: Any) -> Request:
        """Return what a model is asked for to foretell the record, see `gearfem.sensing.observe`; of teeth, that it begins with one."""
        stated: dict[str, Any] = {
            "axis": self.axis + first_tooth,
            "pinion_torque": self.pinion_torque,
            "pinion_speed": self.pinion_speed,
            "gear": self.gear or "pinion",
            "tooth": self.tooth or 0,
            "file": self.file,
            "kick": self.kick,
        }
        return requests()[self.quantity.name](**stated | otherwise)

    def rms(self, series: Array) -> float:
        """Return the root mean square of a series in its rows, shape (n,), over those that are used."""
        return float(np.sqrt(np.mean(series[self.keep] ** 2)))

    def over(self, axis: Array) -> Measurement:
        """Return a record of the same conditions over another axis, shape (n,), without values."""
        return dataclasses.replace(self, axis=axis, value=np.zeros(len(axis)), **_whole(axis))


def make_record(name: str, axis: Array, value: Array | None = None, **stated: Any) -> Measurement:
    """Return a record of which every row counts, from arrays.

    Parameters
    ----------
    name : str
        Of its quantity, and of the record where `file` is not stated.
    axis, value : ndarray, shape (n,)
        As of `Measurement`; no value for a record that is only planned.
    **stated
        The other fields of `Measurement`.
    """
    value = np.zeros(len(axis)) if value is None else value
    return Measurement(**{"file": name, **_whole(axis), **stated}, quantity=QUANTITIES[name], axis=axis, value=value)


def _whole(axis: Array) -> dict[str, Any]:
    return {"line": np.arange(len(axis)), "keep": np.ones(len(axis), bool)}
