"""The life of a pair: flanks that wear, contacts that follow them, step by step."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable

import numpy as np

from gearfem.assembly import assemble
from gearfem.definition.setup import Gear, Member, Setup
from gearfem.effects.effect import Effect
from gearfem.engagement.engage import Loads, Mesh, contact_pressure, loads
from gearfem.flank import Deviation
from gearfem.foundation import Array, InputError, Record, SolveError
from gearfem.foundation.progress import Progress, quiet
from gearfem.foundation.units import MM
from gearfem.placement import evenly_spaced
from gearfem.wear.archard import FINEST, Archard, wear_rates
from gearfem.wear.volume import removed_volume
from gearfem.wear.worn import Worn

MEMBERS: tuple[Member, Member] = ("pinion", "wheel")
# Error of a step (rms over the flank), as a part of the deflection under the load, which decides how pairs share it.
TOLERANCE = 0.01
# Teeth bend as before until so many modules are worn; the transmission error is then off by 0.4 % (studies/worn_compliance.py).
BENDS = 0.01
GROWTH, SHRINK, SAFETY = 2.0, 0.2, 0.9
ANGLES, SHORTEST = 120, 1e-9
# In modules, on average over a flank: deeper outlines are refused anyway.
DEEPEST = 0.25
UNEVEN = "Wear over the life is that of teeth all alike and evenly spaced, and was taken from all teeth, those that differ too."
ALIGNED = "The misalignment of the calibration was left out: wear is not followed over the face width."
Depths = dict[Member, Array]


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Life(Record):
    """What wear does to a pair over turns of its pinion; rows are steps of the computation, the first one before any wear.

    Parameters
    ----------
    setup : Setup
        The pair before.
    law : Archard
        By which it wears.
    turns : ndarray, shape (n,)
        Turns of the pinion.
    pinion_depth, wheel_depth : ndarray, shape (n, k)
        Depth worn off since the beginning at the roll lengths of `Deviation.none(gear).roll` [m].
    pinion_volume, wheel_volume : ndarray, shape (n,)
        Metal missing from one flank over the face width, what was missing before included [m3].
    transmission_error : ndarray, shape (n,)
        From peak to peak, under the operation torque [m].
    contact_pressure : ndarray, shape (n,)
        Largest pressure of all contacts [Pa].
    remarks : tuple of str
        What was left out, and why the life ended before its time if it did.
    """

    setup: Setup
    law: Archard
    turns: Array
    pinion_depth: Array
    wheel_depth: Array
    pinion_volume: Array
    wheel_volume: Array
    transmission_error: Array
    contact_pressure: Array
    remarks: tuple[str, ...] = ()

    @property
    def hours(self) -> Array:
        """Time at the operation's speed [h]."""
        return self.turns * _hours(self.setup)

    def depth(self, member: Member) -> Array:
        """Return the depths of a gear [m], shape (n, k)."""
        return self.pinion_depth if member == "pinion" else self.wheel_depth

    def effects(self, row: int = -1) -> tuple[Worn, Worn]:
        """Return the wear at a row as effects on both gears."""
        return Worn(gear="pinion", depth=self.pinion_depth[row]), Worn(gear="wheel", depth=self.wheel_depth[row])


@dataclasses.dataclass(frozen=True, eq=False)
class _Bench:
    """The pair whose flanks are worn: teeth, bodies and contacts, brought up to date when they have changed enough."""

    setup: Setup
    law: Archard
    angles: Array
    effects: tuple[Effect, ...]
    finest: float
    at: Depths
    mesh: Mesh

    def brought_up(self, depths: Depths) -> _Bench:
        """Return the bench with the compliance of worn teeth, where they have worn enough since."""
        moved = max(float(np.abs(depths[member] - self.at[member]).max()) for member in MEMBERS)
        if moved < BENDS * self.setup.pair.pinion.module:
            return self
        worn = [Worn(gear=member, depth=depths[member]) for member in MEMBERS]
        return dataclasses.replace(self, at=depths, mesh=_alike(assemble(self.setup, [*self.effects, *worn]).mesh))

    def loaded(self, depths: Depths, torque: float) -> tuple[Mesh, Loads]:
        """Return contacts and forces of flanks worn by these depths."""
        flanks = self.mesh.flanks
        for member in MEMBERS:
            flanks = Worn(gear=member, depth=depths[member] - self.at[member]).act(flanks, self.setup)
        mesh = dataclasses.replace(self.mesh, flanks=flanks)
        return mesh, loads(mesh, self.angles, torque)

    def rates(self, loaded: tuple[Mesh, Loads]) -> Depths:
        """Return the depth per turn of the pinion [m]."""
        return wear_rates(*loaded, self.law, self.finest)


def wear_over(
    setup: Setup,
    law: Archard,
    turns: float,
    *,
    effects: Iterable[Effect] = (),
    tolerance: float = TOLERANCE,
    angles: int = ANGLES,
    finest: float = FINEST,
    progress: Progress = quiet,
) -> Life:
    """Let the flanks of a pair wear by Archard's law.

    Parameters
    ----------
    setup : Setup
        Pair and operation; the flanks as they are at the beginning.
    law : Archard
        Coefficients of wear.
    turns : float
        Turns of the pinion.
    effects : iterable of Effect
        Beside those that the setup names.
    tolerance : float
        Error of the depth in a step, root mean square over the flank, as a part of the mean deflection along the line of action.
    angles : int
        Pinion angles over one pitch.
    finest : float
        As for `wear_rates`.
    progress : Progress
        Told how much of the life is done, in thousandths.

    Returns
    -------
    Life
        It ends early, and says so, where teeth are worn so far that no flank or no load sharing can be computed.

    Raises
    ------
    InputError
        If flanks are not parallel, the turns are not positive, or so many that a quarter of a module would wear off on average: the most
        that any flank here loses.
    SolveError
        If the load sharing of the flanks before any wear does not converge.

    Notes
    -----
    Heun's method: the depth grows by the mean of the rates before and after a step; half their difference is the error, in the
    root mean square over the flank, that decides the next step (adaptive, second order). The rates follow from contacts and load
    sharing of the worn flanks, quasi-static under the operation torque: a point that wears gives its load to others, within
    the deflection of the teeth, which bounds the step. The compliance is that of the worn teeth, computed anew whenever a hundredth
    of a module is worn. Where teeth differ, in shape or place, the wear is that of all others, evenly spaced; it is taken from every
    tooth. The dynamic load, lubrication, heat and the end of a hardened layer are not in it.
    """
    if not (math.isfinite(turns) and turns > 0.0):
        raise InputError("turns", f"{turns:g}", "more than 0")
    fitted = setup.calibration
    aligned = dataclasses.replace(setup, calibration=dataclasses.replace(fitted, misalignment=0.0))
    system = assemble(aligned, effects)
    mesh, torque = system.mesh, system.drive.pinion_torque
    remarks: tuple[str, ...] = (*((UNEVEN,) if _differ(mesh) else ()), *((ALIGNED,) if fitted.misalignment else ()))
    pitch = (np.arange(angles) + 0.5) / angles * setup.pair.pinion.pitch_angle
    none: Depths = {member: np.zeros_like(Deviation.none(gear).roll) for member, gear in _gears(setup)}
    bench = _Bench(aligned, law, pitch, tuple(effects), finest, none, _alike(mesh))
    done, step, depths = 0.0, 0.0, none
    loaded = bench.loaded(depths, torque)
    rates = bench.rates(loaded)
    _refuse_long(bench, rates, turns)
    rows = [_row(done, depths, loaded)]
    while done < turns:
        progress("wear", int(1000.0 * done / turns), 1000)
        allowed = tolerance * float(loaded[1].deflection.mean())
        step = step or allowed / max(float(rates[member].max()) for member in MEMBERS)
        try:
            depths, step, following = _advanced(bench, depths, rates, min(step, turns - done), allowed, torque)
            bench = bench.brought_up(depths)
            loaded = bench.loaded(depths, torque)
            rates = bench.rates(loaded)
        except (InputError, SolveError) as error:
            remarks += (f"The life ends after {done:.4g} turns of the pinion, {done / turns:.0%} of those asked for: {error}.",)
            break
        done = turns if done + step >= turns * (1.0 - SHORTEST) else done + step
        step = following
        rows.append(_row(done, depths, loaded))
    progress("wear", 1000, 1000)
    return _life(setup, law, rows, remarks)


def _hours(setup: Setup) -> float:
    """Return the hours that a turn of the pinion takes."""
    return 2.0 * math.pi / setup.operation.pinion_speed / 3600.0


def _gears(setup: Setup) -> tuple[tuple[Member, Gear], tuple[Member, Gear]]:
    return (("pinion", setup.pair.pinion), ("wheel", setup.pair.wheel))


def _advanced(bench: _Bench, depths: Depths, rates: Depths, step: float, allowed: float, torque: float) -> tuple[Depths, float, float]:
    """Return the depths after a step that keeps its error, the step itself [turns], and the next one to try."""
    first = step
    while step > SHORTEST * first:
        guess = {member: depths[member] + step * rates[member] for member in MEMBERS}
        after = bench.rates(bench.loaded(guess, torque))
        error = max(0.5 * step * float(np.sqrt(np.mean((after[member] - rates[member]) ** 2))) for member in MEMBERS)
        following = step * min(max(SAFETY * math.sqrt(allowed / max(error, 1e-30)), SHRINK), GROWTH)
        if error <= allowed:
            return {member: depths[member] + 0.5 * step * (rates[member] + after[member]) for member in MEMBERS}, step, following
        step = following
    raise SolveError("a step of wear did not keep its error: a lower coefficient or a shorter life gets no further either")


def _row(done: float, depths: Depths, loaded: tuple[Mesh, Loads]) -> tuple[object, ...]:
    mesh, carried = loaded
    width = mesh.placement.pair.face_width
    volumes = (removed_volume(mesh.flanks.of(member), width) for member in MEMBERS)
    largest = float(contact_pressure(mesh, carried.contacts, carried.force).max())
    return (done, *(depths[member] for member in MEMBERS), *volumes, float(np.ptp(carried.transmission_error)), largest)


def _life(setup: Setup, law: Archard, rows: list[tuple[object, ...]], remarks: tuple[str, ...]) -> Life:
    names = ("turns", "pinion_depth", "wheel_depth", "pinion_volume", "wheel_volume", "transmission_error", "contact_pressure")
    columns = (np.array(column) for column in zip(*rows, strict=True))
    return Life(setup=setup, law=law, remarks=remarks, **dict(zip(names, columns, strict=True)))


def _alike(mesh: Mesh) -> Mesh:
    """Return a mesh whose teeth are all as the common one and evenly spaced; flanks that are not parallel are refused."""
    flanks, placement, compliance = mesh.flanks, mesh.placement, mesh.compliance
    if not flanks.lead.uniform:
        raise InputError(
            "model", "flanks that are not parallel over the face width", "parallel ones: wear is not followed over the face width"
        )
    return dataclasses.replace(
        mesh,
        flanks=dataclasses.replace(flanks, pinion_odd=(), wheel_odd=()),
        compliance=dataclasses.replace(compliance, pinion_odd=(), wheel_odd=()),
        placement=evenly_spaced(placement),
    )


def _differ(mesh: Mesh) -> bool:
    """Whether teeth differ, in shape or place."""
    flanks, placement, compliance = mesh.flanks, mesh.placement, mesh.compliance
    odd = (flanks.pinion_odd, flanks.wheel_odd, compliance.pinion_odd, compliance.wheel_odd)
    late = np.ptp(placement.pinion_late) + np.ptp(placement.wheel_late)
    return bool(any(odd) or late > 0.0 or any(placement.pinion_runout) or any(placement.wheel_runout))


def _refuse_long(bench: _Bench, rates: Depths, turns: float) -> None:
    """Refuse a life in which a flank would lose more than the deepest wear on average, at the rate with which it begins."""
    limit = DEEPEST * bench.setup.pair.pinion.module
    for member, gear in _gears(bench.setup):
        outline, roll = bench.mesh.flanks.of(member), Deviation.none(gear).roll
        flank = (roll >= outline.flank_start) & (roll <= outline.flank_end)
        mean = float(np.average(rates[member][flank], weights=roll[flank]))
        if mean * turns > limit:
            found = f"{turns:.4g} turns of the pinion, in which the {member} would lose {mean * turns / MM:.3g} mm of its flanks on average"
            most = f"up to {limit / mean:.3g} turns ({limit / mean * _hours(bench.setup):.3g} h)"
            raise InputError("turns of the pinion", found, f"{most}, a quarter of a module; teeth may be worn out before")
