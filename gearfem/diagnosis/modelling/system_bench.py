"""The bench of a whole system: every record predicted by the same stages as everywhere else."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable
from functools import cached_property, lru_cache

import numpy as np

from gearfem.assembly import assemble
from gearfem.contact.scaled import evened
from gearfem.definition.setup import GearPair, Member
from gearfem.diagnosis.modelling.bench import Oscillator, Peaks, Settings, Swing, Weights
from gearfem.diagnosis.reading.campaign import Campaign
from gearfem.diagnosis.reading.measurement import Measurement
from gearfem.dynamics.turns import kw_places, march_turns
from gearfem.dynamics.turns_plan import make_plan
from gearfem.effects.effect import Effect
from gearfem.engagement.engage import standard_angles
from gearfem.engagement.grid import COARSE
from gearfem.engagement.turns import Turns, static
from gearfem.foundation import Array, Record
from gearfem.sensing import System
from gearfem.sensing.motion import at_speed
from gearfem.sensing.requests import observe
from gearfem.variants import VARIANTS, Variant, varied

# Part of the mean load below which the flanks of a motion count as apart.
LEAST_LOAD = 0.02
# Part of the torque under which one pair of flanks touches and next to nothing yields.
UNLOADED = 0.01
# Places of the path of contact at which the depth of a flank is averaged.
DEPTHS = 101
# Systems of other coupling, tip edges and errors that stay in memory: those of the trials of a step.
BUILT = 8
# Longest step of motions by 1/omega_n: an error far below what a motion is expected to be predicted to (see `march_turns`).
STRIDE = 0.7


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class SystemBench(Record):
    """A system, with or without effects, on the bench of the diagnosis.

    Parameters
    ----------
    system : System
        From `gearfem.assembly.assemble`.
    errors : tuple of Variant, optional
        How this model may be wrong, see `Settings`; none for a rough fit.

    Notes
    -----
    A pair stiffer by s under the torque T moves as one of the model's stiffness under T/s with inertias over s, since every compliance,
    the contact's included, depends on force over Young's modulus alone: a stiffness scale costs no new tables. Kw and
    accelerations are the same in both, mesh stiffness is s times the other's; ripples of the torque go over s too, and supports,
    which are no gears, yield s times as much.
    """

    system: System
    errors: tuple[Variant, ...] = VARIANTS

    @property
    def pair(self) -> GearPair:
        """The gears."""
        return self.system.setup.pair

    @property
    def gain(self) -> float:
        """Reading of the instrument over the true value."""
        return self.system.instrument.gain

    @property
    def delay(self) -> float:
        """Time by which the instrument reads late [s]."""
        return self.system.instrument.delay

    def turned(self, axis: Array, settings: Settings) -> Array:
        """Return true pinion angles [rad] from recorded ones: by the zero that the model's calibration has, and by that of settings."""
        return np.asarray(axis + self._zero(settings))

    def _zero(self, settings: Settings) -> float:
        return self.system.setup.calibration.angle_offset + settings.angle_offset

    def depth(self, gear: Member) -> float:
        """Return the root mean square of what is missing from the flanks of a gear over the path of contact [m]; odd teeth do not count.

        Less what is missing all over: that has no form, and a record whose constant is free does not feel it.
        """
        deviation, pair = self.system.flanks.of(gear).deviation, self.pair
        if deviation is None:
            return 0.0
        path = np.linspace(-pair.approach_length, pair.recess_length, DEPTHS)
        base, sign = (pair.wheel.base_radius, -1.0) if gear == "wheel" else (pair.pinion.base_radius, 1.0)
        depth = deviation.at(base * math.tan(pair.working_pressure_angle) + sign * path)
        return float(np.sqrt(np.mean((depth - depth.min()) ** 2)))

    def predict(self, record: Measurement, settings: Settings) -> Array:
        """Return what the record would read [SI], shape (n,)."""
        name, angles = record.quantity.name, record.quantity.axis == "angle"
        torque = record.pinion_torque * settings.torque_scale / settings.stiffness_scale
        request = record.request(pinion_torque=torque, stride=STRIDE)
        value = observe(self._system(settings), request)
        if name == "mesh_stiffness":
            return settings.gain * settings.stiffness_scale * value
        if name == "dynamic_factor":
            return 1.0 + settings.gain * (value - 1.0)
        return settings.gain * value if angles else value

    def weights(self, angle: Array, torque: float, settings: Settings) -> Weights:
        """Return the weights of the teeth in the slow transmission error at true pinion angles [rad] and a stated torque [N m]."""
        turns = static(Turns(mesh=self._system(settings).mesh), angle, self._torque(torque, settings))
        return Weights(pairs=turns.pairs, pinion=turns.pinion_weight, wheel=turns.wheel_weight)

    def unloaded(self, angle: Array, torque: float, settings: Settings) -> Array:
        """Return the transmission error [m] at true pinion angles [rad] under a hundredth of a stated torque [N m], without ripple."""
        return static(Turns(mesh=self._system(settings).mesh), angle, UNLOADED * self._torque(torque, settings)).transmission_error

    def oscillator(self, torque: float, settings: Settings) -> Oscillator:
        """Return the oscillator of the mesh at a stated torque [N m]."""
        system, drive = self.system, self.system.drive
        angle = standard_angles(system.placement)[:-1]
        load = self._torque(torque, settings)
        stiffness = static(Turns(mesh=system.mesh), angle, load).mesh_stiffness.mean()
        moving = self._system(settings)
        plan = make_plan(Turns(mesh=moving.mesh), moving.drive, self.system.drive.pinion_speed, load)
        slowest, fastest = plan.rates()
        masses = (drive.pinion_inertia / self.pair.pinion.base_radius**2, drive.wheel_inertia / self.pair.wheel.base_radius**2)
        reduced = masses[0] * masses[1] / (masses[0] + masses[1]) * settings.inertia_scale
        return Oscillator(
            frequency=math.sqrt(settings.stiffness_scale * float(stiffness) / reduced),
            ratio=drive.damping_ratio * settings.damping_scale,
            fastest=fastest,
            slowest=slowest,
            acceleration=masses[1] / (masses[0] + masses[1]) / self.pair.pinion.base_radius,
        )

    def swing(self, angle: Array, torque: float, speed: float, settings: Settings, kick: tuple[float, float] = (0.0, 0.0)) -> Swing:
        """Return the motion at true pinion angles [rad], a stated torque [N m] and a speed [rad/s], begun with a kick (`march_turns`).

        Weights and stiffness are those of the slow engagement under the force that the motion has at each angle, the damper's left out.
        Where the flanks are apart no tooth weighs anything, though the damper stays; that errors move when they part and meet is left out.
        """
        system = self._system(settings)
        turns, drive, base = Turns(mesh=system.mesh), system.drive, self.pair.pinion.base_radius
        load = self._torque(torque, settings)
        force = march_turns(turns, drive, angle, speed=speed, torque=load, stride=STRIDE, kick=kick).elastic_force * base
        parted = force <= LEAST_LOAD * load
        held = static(turns, angle, np.where(parted, load, force))
        plan = make_plan(turns, drive, speed, load)
        # Supports on which the gears move with their masses are the train's.
        stiffness = 1.0 / (held.slope * base - (system.placement.support - plan.placement.support))
        touching = ~parted[:, None]
        share = touching * held.force / held.force.sum(axis=1)[:, None]
        return Swing(
            weights=Weights(pairs=held.pairs, pinion=touching * held.pinion_weight, wheel=touching * held.wheel_weight),
            shares=Weights(pairs=held.pairs, pinion=share, wheel=share),
            stiffness=np.where(parted, 0.0, stiffness),
            damping=plan.damper,
            train=plan.train,
            base1=base,
            base2=self.pair.wheel.base_radius,
        )

    def peaks(self, torque: float, speed: float, settings: Settings) -> Peaks:
        """Return the largest Kw of a turn and of each of its pitches at a stated torque [N m] and a speed [rad/s]."""
        system, load = self._system(settings), torque * settings.torque_scale / settings.stiffness_scale
        angle = kw_places(self.pair.pinion.teeth) * self.pair.pinion.pitch_angle
        acceleration = at_speed(system, "pinion_acceleration", angle, load, speed, STRIDE)
        share = -system.drive.pinion_inertia / system.torque(load)
        factors = 1.0 + settings.gain * share * acceleration
        return Peaks(angle=float(angle[np.argmax(factors)]), share=share, factors=factors.reshape(self.pair.pinion.teeth, -1).max(axis=1))

    def read(self, motion: Array, step: float) -> Array:
        """Return what the instrument's resonances make of motions at equal steps of time [s], shape (n, k)."""
        instrument = self.system.instrument
        if not instrument.resonances:
            return motion
        # The series counts as repeating: its mirror image before it keeps the ends from ringing.
        whole = np.concatenate([motion[::-1], motion])
        return motion + np.column_stack([instrument.ringing(column, step)[len(motion) :] for column in whole.T])

    def _torque(self, stated: float, settings: Settings) -> float:
        return self.system.torque(stated) * settings.torque_scale / settings.stiffness_scale

    def _system(self, settings: Settings) -> System:
        """Return the system with angle zero, index errors, inertias and damping of these settings."""
        built = self._build(settings.coupling_scale, settings.tip_edge_scale, settings.evenness, settings.errors)
        setup, placement, drive = built.setup, built.placement, built.drive
        inertia = settings.inertia_scale / settings.stiffness_scale
        return dataclasses.replace(
            built,
            setup=dataclasses.replace(setup, calibration=dataclasses.replace(setup.calibration, angle_offset=self._zero(settings))),
            placement=dataclasses.replace(
                placement,
                pinion_late=placement.pinion_late + settings.pinion_late,
                wheel_late=placement.wheel_late + settings.wheel_late,
                series=(placement.series + settings.series_compliance) * settings.stiffness_scale,
                pinion_support=placement.pinion_support * settings.stiffness_scale,
                wheel_support=placement.wheel_support * settings.stiffness_scale,
            ),
            drive=dataclasses.replace(
                drive.over(settings.stiffness_scale),
                pinion_inertia=drive.pinion_inertia * inertia,
                wheel_inertia=drive.wheel_inertia * inertia,
                damping_ratio=drive.damping_ratio * settings.damping_scale,
            ),
        )

    @cached_property
    def _build(self) -> Callable[[float, float, float, tuple[float, ...]], System]:
        """What makes the system with multiples of the coupling of neighbour teeth and of the radius of tip edges, evenness, and errors.

        The latest are kept.
        """
        # It holds the system, not the bench: what holds itself stays in memory until circles are looked for.
        system, errors = self.system, self.errors

        def build(coupling: float, edges: float, evenness: float, moved: tuple[float, ...]) -> System:
            wrong = varied(system, ((variant, variant.value(far)) for variant, far in zip(errors, moved, strict=False)))
            return dataclasses.replace(
                wrong,
                flanks=wrong.flanks.edged(edges),
                compliance=wrong.compliance.coupled(coupling),
                law=evened(wrong.law, evenness),
            )

        return lru_cache(BUILT)(build)


def bench_of(campaign: Campaign, effects: Iterable[Effect] = ()) -> SystemBench:
    """Return the campaign's model, with or without further effects, ready to predict records over the grid that fits take.

    Parameters
    ----------
    campaign : Campaign
        Whose model it is.
    effects : iterable of Effect
        Further effects.

    Returns
    -------
    SystemBench
        Of the deviation of a slow transmission error it misses 1e-4 of what `gearfem.sensing.observe` has, see `gearfem.engagement.grid`.

    Raises
    ------
    InputError, SolveError
        If an effect is beyond its bounds, or the model cannot be computed.
    """
    return SystemBench(system=dataclasses.replace(assemble(campaign.setup, tuple(effects)), grid=COARSE))
