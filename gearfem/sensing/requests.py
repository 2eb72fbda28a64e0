"""What can be asked of a system: one class for each quantity that a campaign may hold, all in SI."""

from __future__ import annotations

import abc
import dataclasses
import functools
import os
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from types import MappingProxyType
from typing import ClassVar

import numpy as np

from gearfem.definition.setup import Member
from gearfem.dynamics.turns_plan import STRIDE
from gearfem.foundation import Array, Record
from gearfem.placement import runout_gap
from gearfem.sensing.motion import Channel, at_speed, least_acceleration, slope, slowly
from gearfem.sensing.system import System


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Request(Record, abc.ABC):
    """A series that an instrument is asked for.

    Parameters
    ----------
    axis : ndarray, shape (n,)
        Pinion angles [rad], pinion speeds [rad/s], roll lengths [m] or numbers of teeth, as the quantity has it; angles are those of
        the record, so that a fitted angle zero acts on them.
    pinion_torque, pinion_speed : float
        As the record states them [N m], [rad/s]; 0 where the quantity has none.
    gear : {"pinion", "wheel"}
        Gear of a record of one gear.
    tooth : int
        Tooth of a flank.
    file : str
        Name of the record, under which a fitted constant is looked up.
    stride : float
        Longest step of motions, see `march_turns`.
    kick : (float, float)
        How a motion begins, see `march_turns`; by default as a fit has found.
    """

    quantity: ClassVar[str]

    axis: Array
    pinion_torque: float = 0.0
    pinion_speed: float = 0.0
    gear: Member = "pinion"
    tooth: int = 0
    file: str = ""
    stride: float = STRIDE
    kick: tuple[float, float] | None = None

    @abc.abstractmethod
    def of(self, system: System) -> Array:
        """Return the values over the axis [SI], shape (n,)."""


class StaticError(Request):
    """Transmission error of the slowly turning gears [m] over the pinion angle."""

    quantity = "static_transmission_error"

    def of(self, system: System) -> Array:
        """Return the wheel's lag along the line of action [m]."""
        error = slowly(system, self.axis, self.pinion_torque).transmission_error
        return system.instrument.read_slow(error) + system.setup.calibration.offset(self.file)


def _motion(system: System, channel: Channel, asked: Request) -> Array:
    """Return what is asked for of a motion at speed."""
    kick = system.setup.calibration.kick(asked.file) if asked.kick is None else asked.kick
    return at_speed(system, channel, asked.axis, asked.pinion_torque, asked.pinion_speed, asked.stride, kick)


class DynamicError(Request):
    """Transmission error of the gears at speed [m] over the pinion angle."""

    quantity = "dynamic_transmission_error"

    def of(self, system: System) -> Array:
        """Return the wheel's lag along the line of action [m]."""
        error = _motion(system, "transmission_error", self)
        return error + system.setup.calibration.offset(self.file)


class Acceleration(Request):
    """Angular acceleration of the pinion [rad/s2] over its angle."""

    quantity = "pinion_angular_acceleration"

    def of(self, system: System) -> Array:
        """Return psi1'' [rad/s2]."""
        return _motion(system, "pinion_acceleration", self)


class DynamicFactor(Request):
    """Largest Kw = 1 - J1 psi1''/T1 over one turn of the pinion, at each speed of the axis, from the acceleration as it is read."""

    quantity = "dynamic_factor"

    def of(self, system: System) -> Array:
        """Return the largest dynamic factors."""
        share = system.drive.pinion_inertia / system.torque(self.pinion_torque)

        def largest(speed: float) -> float:
            return 1.0 - share * least_acceleration(system, self.pinion_torque, speed, self.stride)

        # The first one makes the tables, which threads would make twice.
        first = [largest(float(speed)) for speed in self.axis[:1]]
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            return np.array([*first, *pool.map(largest, self.axis[1:].tolist())])


class MeshStiffness(Request):
    """Slope of force against deflection on the line of action [N/m] over the pinion angle."""

    quantity = "mesh_stiffness"

    def of(self, system: System) -> Array:
        """Return the mesh stiffness over the whole face width [N/m]."""
        return system.instrument.read_slow(slope(system, self.axis, self.pinion_torque))


class FlankProfile(Request):
    """Metal missing from one flank along the normal [m] over the roll length."""

    quantity = "flank_profile"

    def of(self, system: System) -> Array:
        """Return the depth [m], positive into the tooth."""
        outline = system.flanks.odd(self.gear).get(self.tooth, system.flanks.of(self.gear))
        return np.zeros_like(self.axis) if outline.deviation is None else outline.deviation.at(self.axis)


class RadialRunout(Request):
    """Reading of a fixed radial indicator at each tooth of a mounted gear [m]."""

    quantity = "radial_runout"

    def of(self, system: System) -> Array:
        """Return the reading [m], largest at the tooth that stands out farthest."""
        placement, pair = system.placement, system.setup.pair
        gear, (towards, along) = (pair.pinion, placement.pinion_runout) if self.gear == "pinion" else (pair.wheel, placement.wheel_runout)
        place = (self.axis + system.setup.calibration.first_tooth(self.file)) * gear.pitch_angle
        return towards * np.cos(place) + along * np.sin(place) + system.setup.calibration.offset(self.file)


class PitchDeviation(Request):
    """Index deviation of each tooth of a mounted gear [m], positive late."""

    quantity = "pitch_deviation"

    def of(self, system: System) -> Array:
        """Return the index deviations along the line of action [m], runout included as it shows at the pitch point."""
        none = {"wheel_runout": (0.0, 0.0)} if self.gear == "pinion" else {"pinion_runout": (0.0, 0.0)}
        placement = dataclasses.replace(system.placement, **none)  # type: ignore[arg-type]
        late = placement.pinion_late if self.gear == "pinion" else placement.wheel_late
        tooth = self.axis + system.setup.calibration.first_tooth(self.file)
        gap, _ = runout_gap(placement, tooth * placement.pair.pinion.pitch_angle)
        number = np.round(tooth).astype(int) % len(late)
        return np.asarray(late[number] + gap + system.setup.calibration.offset(self.file))


@functools.cache
def requests() -> Mapping[str, type[Request]]:
    """Return the kinds of request by the quantity's name in campaigns."""
    kinds: dict[str, type[Request]] = {kind.quantity: kind for kind in Request.__subclasses__()}
    return MappingProxyType(kinds)


def observe(system: System, request: Request) -> Array:
    """Predict what an instrument reads.

    Parameters
    ----------
    system : System
        The gears with all their effects, from `gearfem.assembly.assemble`.
    request : Request
        What was measured, where and under which torque and speed.

    Returns
    -------
    ndarray, shape (n,)
        Values over the axis of the request, in SI.

    Raises
    ------
    InputError, SolveError
        As the engagement and the dynamics do.
    """
    return request.of(system)
