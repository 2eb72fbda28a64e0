"""A free smooth correction without any physics, beside which a named effect has to prove itself."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from gearfem.definition.setup import GearPair
from gearfem.diagnosis.modelling.mesh_lines import resolved
from gearfem.diagnosis.reading.measurement import Measurement
from gearfem.diagnosis.reading.noise import Noise
from gearfem.foundation import Array, Record

# Lines of the mesh, as far as rows show them, and of each shaft.
MESH, SHAFT = 8, 2


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Smooth(Record):
    """A correction fitted to the records of one quantity.

    Parameters
    ----------
    quantity : str
        Which.
    pair : GearPair
        The gears, whose turns it follows.
    lines : int
        Of the mesh.
    angle_offset : float
        True pinion angle less the recorded one [rad].
    torque, speed : float
        Largest ones of the fitted records [N m], [rad/s], to which its parts are referred.
    coefficients : ndarray, shape (k,)
        Of the columns [SI unit of the quantity].
    """

    quantity: str
    pair: GearPair
    lines: int
    angle_offset: float
    torque: float
    speed: float
    coefficients: Array

    def at(self, record: Measurement) -> Array:
        """Return the correction at the rows of a record of its quantity, shape (n,)."""
        return np.asarray(_columns(record, self.pair, self.lines, self.angle_offset, self.torque, self.speed) @ self.coefficients)


def fit_smooth(
    records: tuple[Measurement, ...], noises: tuple[Noise, ...], left: tuple[Array, ...], pair: GearPair, angle_offset: float
) -> dict[str, Smooth]:
    """Fit one correction to each quantity over the pinion angle.

    Parameters
    ----------
    records : tuple of Measurement
        Records to fit.
    noises : tuple of Noise
        Their noise, which weighs them.
    left : tuple of ndarray, shapes (n,)
        What the nuisances leave of each, constant included.
    pair : GearPair
        The gears.
    angle_offset : float
        Fitted with the nuisances [rad].

    Returns
    -------
    dict of str to Smooth

    Notes
    -----
    Eight lines of the mesh, or as many as the rows of every record show, and two of each shaft, and a constant where records have none of
    their own, each with a part that does not depend on the torque and one in proportion to it, at speed also one in proportion to that;
    least squares of the whitened rows, the least solution where the records cannot tell the parts apart.
    """
    found = {}
    for name in {record.quantity.name for record in records if record.quantity.axis == "angle"}:
        own = [i for i, record in enumerate(records) if record.quantity.name == name]
        torque = max(records[i].pinion_torque for i in own)
        speed = max(records[i].pinion_speed for i in own)
        lines = min(MESH, *(resolved(records[i].axis, pair.pinion.pitch_angle) for i in own))
        rows, values = [], []
        for place, i in enumerate(own):
            columns = _columns(records[i], pair, lines, angle_offset, torque, speed)
            constant = np.zeros((len(columns), len(own)))
            constant[:, place] = float(records[i].quantity.free_constant)
            rows.append(noises[i].whitener.apply(np.concatenate([columns, constant], axis=1)))
            values.append(noises[i].whitener.apply(left[i]))
        solved = np.linalg.lstsq(np.concatenate(rows), np.concatenate(values), rcond=1e-9)[0]
        found[name] = Smooth(
            quantity=name,
            pair=pair,
            lines=lines,
            angle_offset=angle_offset,
            torque=torque,
            speed=speed,
            coefficients=solved[: len(solved) - len(own)],
        )
    return found


def _columns(record: Measurement, pair: GearPair, lines: int, offset: float, torque: float, speed: float) -> Array:
    """Return the waves times their parts, shape (n, k)."""
    angle = record.axis + offset
    orders = [float(pair.pinion.teeth * line) for line in range(int(record.quantity.free_constant), lines + 1)]
    orders += [line * shaft for line in range(1, SHAFT + 1) for shaft in (1.0, 1.0 / pair.ratio)]
    turned = np.outer(angle, orders)
    waves = np.concatenate([np.cos(turned), np.sin(turned)], axis=1)
    parts = [1.0, record.pinion_torque / torque, *([record.pinion_speed / speed] if record.quantity.moving else [])]
    return np.concatenate([part * waves for part in parts], axis=1) / math.sqrt(len(parts))
