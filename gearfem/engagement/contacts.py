"""Where teeth touch: unworn ones on the line of action and with their corners, worn ones where a search finds them."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearfem.definition.setup import Member
from gearfem.engagement.corners import FOLLOWED, Touch, bounded, nearest_edge, pinion_corner, wheel_corner, within
from gearfem.engagement.record import Contacts
from gearfem.engagement.search import search_beside, search_contacts
from gearfem.flank import Flanks, Outline
from gearfem.foundation import Array
from gearfem.placement import Placement, runout_gap

# Gap in modules, beyond the depths of wear, up to which contacts are followed; `engage` refuses loads that could close it.
REACH = 0.2
# Angles that differ by less are one contact to the search: 1e-14 m and less on the line of action.
ONE_ANGLE = 1e-13
# Lag in modules behind the first touch up to which a pair's second one is followed: as far as `engage` lets teeth move.
SECOND = 0.05


def find_contacts(flanks: Flanks, placement: Placement, pinion_angle: Array, pairs: tuple[int, ...]) -> Contacts:
    """Return the contact of each pair at each angle, as if it touched alone and rigid.

    Parameters
    ----------
    flanks : Flanks
        Outlines of both gears.
    placement : Placement
        Where the teeth stand.
    pinion_angle : ndarray, shape (n,)
        Angles of the pinion [rad].
    pairs : tuple of int
        Pairs to look at; pair k is pinion tooth k mod z1 with wheel tooth k mod z2.

    Returns
    -------
    Contacts

    Raises
    ------
    SolveError
        If the wheel's angle of a corner contact, or a contact point of worn flanks, does not converge.

    Notes
    -----
    Two kinds of contact exist for unworn teeth, both in closed form: involute on involute, on the straight line of
    action, and a tip round on the involute of the other tooth, before and behind it. Worn teeth, and undercut ones off
    the line of action, go to `search_contacts`. A late tooth is an exact shift: the
    pinion's turns its pair back by e1/r_b1, and both add to the gap. Runout is added to the gaps of all pairs in first
    order (`runout_gap`).
    """
    return _found(flanks, placement, pinion_angle, pairs, _touches)


def find_second_contacts(flanks: Flanks, placement: Placement, pinion_angle: Array, pairs: tuple[int, ...]) -> Contacts:
    """Return where worn pairs touch next, beside their first touch; arguments and errors as `find_contacts`.

    Returns
    -------
    Contacts
        Second touches, then shelves (`search_beside`), of the pairs that have any at one of the angles, perhaps of none.

    Notes
    -----
    The two sides of a hollow come into contact one after the other, and carry together while the load presses the teeth by more than
    lies between them. Unworn flanks have one contact beside which tip rounds lie out of reach.
    """
    found = _found(flanks, placement, pinion_angle, pairs, _second_touches, kinds=2)
    those = np.flatnonzero(found.reach.any(axis=0))
    fields = {name: values if name == "pinion_angle" else values[:, those] for name, values in _arrays(found).items()}
    return Contacts(**fields, pairs=tuple(found.pairs[column] for column in those))


def _arrays(contacts: Contacts) -> dict[str, Any]:
    return {field.name: getattr(contacts, field.name) for field in dataclasses.fields(contacts) if field.name != "pairs"}


def join(first: Contacts, second: Contacts) -> Contacts:
    """Return contacts side by side; pairs that touch twice stand there twice."""
    if not second.pairs:
        return first
    one, other = _arrays(first), _arrays(second)
    both = {name: np.concatenate([one[name], other[name]], axis=1) for name in one if name != "pinion_angle"}
    return Contacts(**both, pinion_angle=first.pinion_angle, pairs=first.pairs + second.pairs)


Touches = Callable[[Flanks, Placement, Array], tuple[Touch, Array]]


def _found(flanks: Flanks, placement: Placement, pinion_angle: Array, pairs: tuple[int, ...], touches: Touches, kinds: int = 1) -> Contacts:
    """Return the contacts of pairs that a function finds for pairs of the same two outlines, side by side those of several kinds."""
    pinion_angle, gear1, gear2 = np.asarray(pinion_angle, float), placement.pair.pinion, placement.pair.wheel
    late1 = placement.pinion_late[np.asarray(pairs) % gear1.teeth]
    late2 = placement.wheel_late[np.asarray(pairs) % gear2.teeth]
    angle = pinion_angle[:, None] - np.asarray(pairs)[None, :] * gear1.pitch_angle - late1 / gear1.base_radius
    alike: dict[tuple[int, int], tuple[Flanks, list[int]]] = {}
    for column, pair in enumerate(pairs):
        teeth = Flanks(pinion=_tooth(flanks, "pinion", pair % gear1.teeth), wheel=_tooth(flanks, "wheel", pair % gear2.teeth))
        alike.setdefault((id(teeth.pinion), id(teeth.wheel)), (teeth, []))[1].append(column)
    found, columns = [], []
    for teeth, those in alike.values():
        found.append(touches(teeth, placement, angle[:, those]))
        columns += [kind * len(pairs) + column for kind in range(kinds) for column in those]
    order = np.argsort(columns)
    parts: list[Any] = [np.concatenate(values, axis=1)[:, order] for values in zip(*(touch for touch, _ in found), strict=True)]
    touch, gap = Touch(*parts), np.concatenate([gaps for _, gaps in found], axis=1)[:, order]
    late = np.tile(late1 + late2, kinds)
    return _contacts(placement, pinion_angle, pairs * kinds, touch, gap + late + runout_gap(placement, pinion_angle)[0][:, None])


def _tooth(flanks: Flanks, member: Member, number: int) -> Outline:
    return flanks.odd(member).get(number, flanks.of(member))


def _touches(flanks: Flanks, placement: Placement, angle: Array) -> tuple[Touch, Array]:
    """Return the first touch of pairs of the same two outlines, and their gaps before index errors and runout."""
    path = _on_path(flanks, placement, angle)
    module, base2 = placement.pair.wheel.module, placement.pair.wheel.base_radius
    ideal = angle / placement.pair.ratio
    if flanks.pinion.worn or flanks.wheel.worn:
        kinds = _searched(flanks, placement, angle, path, _first_alone)
    elif flanks.pinion.undercut or flanks.wheel.undercut:
        kinds = [path, *_searched(flanks, placement, angle, path, _first_alone)]
    else:
        kinds = [path, pinion_corner(flanks, placement, angle), wheel_corner(flanks, placement, angle)]
    # The first touch is the smallest lag of the wheel; a pair out of reach gets a lag of one module.
    lags = np.stack([np.where(kind.reach, (ideal - kind.wheel_angle) * base2, module) for kind in kinds])
    if kinds[0] is path:
        lags[:, path.reach] = np.where(np.arange(len(kinds)) == 0, 0.0, module)[:, None]
    limit = REACH * module + flanks.pinion.deepest + flanks.wheel.deepest
    lags[lags > limit] = module
    first = np.argmin(lags, axis=0)
    chosen = Touch(*(_choose(first, [kind[field] for kind in kinds]) for field in range(len(Touch._fields))))
    gap: Array = np.min(lags, axis=0)
    return chosen._replace(reach=chosen.reach & (gap <= limit)), gap


def _second_touches(flanks: Flanks, placement: Placement, angle: Array) -> tuple[Touch, Array]:
    """Return second touches of pairs of the same two outlines and, beside them, their shelves; and the gaps of both."""
    module, base2 = placement.pair.wheel.module, placement.pair.wheel.base_radius
    limit = REACH * module + flanks.pinion.deepest + flanks.wheel.deepest
    path = _on_path(flanks, placement, angle)
    kinds = [path._replace(reach=np.zeros(angle.shape, bool))] * 2
    if flanks.pinion.worn or flanks.wheel.worn:
        kinds = _searched(flanks, placement, angle, path, functools.partial(search_beside, within=SECOND * module / base2))
    lags = [np.where(kind.reach, (angle / placement.pair.ratio - kind.wheel_angle) * base2, module) for kind in kinds]
    kinds = [kind._replace(reach=kind.reach & (lag <= limit)) for kind, lag in zip(kinds, lags, strict=True)]
    parts: list[Any] = [np.concatenate(values, axis=1) for values in zip(*kinds, strict=True)]
    return Touch(*parts), np.concatenate([np.where(lag <= limit, lag, module) for lag in lags], axis=1)


Search = Callable[[Outline, Outline, Placement, Array], tuple[Touch, ...]]


def _searched(flanks: Flanks, placement: Placement, angle: Array, path: Touch, search: Search) -> list[Touch]:
    """Return the touches of worn teeth that a search finds; where there is none, `path` fills the row."""
    pinion, wheel, pitch = flanks.pinion, flanks.wheel, placement.pair.pinion.pitch_angle
    slope = math.tan(placement.working_pressure_angle)
    last = pinion.flank_end / pinion.gear.base_radius - slope + FOLLOWED * pitch
    first = (wheel.gear.base_radius * slope - wheel.flank_end) / pinion.gear.base_radius - FOLLOWED * pitch
    near = (angle > first) & (angle < last)
    _, once, again = np.unique(np.round(angle[near] / ONE_ANGLE), return_index=True, return_inverse=True)
    here = angle[near][once]
    # Angles that count as one keep their own distance from the wheel's angle.
    aside = (angle[near] - here[again]) / placement.pair.ratio
    spread = []
    for found in search(pinion, wheel, placement, here):
        touched = found.reach[again]
        rows = np.zeros(angle.shape, bool)
        rows[near] = touched
        filled: dict[str, Any] = {name: np.array(values) for name, values in path._asdict().items()}
        for name, values in found._asdict().items():
            filled[name][rows] = values[again][touched]
        filled["wheel_angle"][rows] += aside[touched]
        spread.append(Touch(**{**filled, "reach": rows}))
    return spread


def _first_alone(pinion: Outline, wheel: Outline, placement: Placement, angle: Array) -> tuple[Touch]:
    return (search_contacts(pinion, wheel, placement, angle),)


def _choose(first: NDArray[np.intp], options: list[Any]) -> Any:
    """Take from each position the option of the number `first` holds there."""
    stacked = np.stack(options)
    index = first if stacked.ndim == first.ndim + 1 else np.repeat(first[..., None], stacked.shape[-1], axis=-1)
    return np.take_along_axis(stacked, index[None], axis=0)[0]


def _contacts(placement: Placement, pinion_angle: Array, pairs: tuple[int, ...], touch: Touch, gap: Array) -> Contacts:
    x, y = touch.point[..., 0], touch.point[..., 1]
    fx, fy = np.cos(touch.direction), np.sin(touch.direction)
    beyond = placement.centre_distance - x
    return Contacts(
        pinion_angle=pinion_angle,
        pairs=pairs,
        reach=touch.reach,
        gap=gap,
        u1=touch.u1,
        u2=touch.u2,
        point=touch.point,
        pressure_angle=np.pi / 2.0 - touch.direction,
        arm1=x * fy - y * fx,
        arm2=beyond * fy + y * fx,
        friction_arm1=x * fx + y * fy,
        friction_arm2=beyond * fx - y * fy,
        equivalent_radius=1.0 / touch.curvature,
        flank_radius=1.0 / touch.flank_curvature,
        edge=touch.edge,
        edge_radius=touch.edge_radius,
        rolling_velocity1=touch.rolling1,
        rolling_velocity2=touch.rolling2,
        sliding_velocity=touch.rolling1 - touch.rolling2,
    )


def _on_path(flanks: Flanks, placement: Placement, angle: Array) -> Touch:
    """Involute on involute: the contact lies r_b1 phi from the pitch point on the line of action."""
    pinion, wheel = flanks.pinion, flanks.wheel
    slope = math.tan(placement.working_pressure_angle)
    base1, base2 = pinion.gear.base_radius, wheel.gear.base_radius
    along = base1 * angle
    roll1, roll2 = base1 * slope + along, base2 * slope - along
    reach = within(pinion, roll1) & within(wheel, roll2)
    roll1, roll2 = bounded(pinion, roll1), bounded(wheel, roll2)
    direction = np.full_like(angle, np.pi / 2.0 - placement.working_pressure_angle)
    edge1, edge2 = nearest_edge(pinion, roll1), nearest_edge(wheel, roll2)
    pitch_radius = placement.centre_distance / (1.0 + placement.pair.ratio)
    point = np.stack([pitch_radius + along * np.cos(direction), along * np.sin(direction)], axis=-1)
    return Touch(
        reach=reach,
        wheel_angle=angle / placement.pair.ratio,
        u1=pinion.parameter(roll1),
        u2=wheel.parameter(roll2),
        direction=direction,
        point=point,
        curvature=1.0 / roll1 + 1.0 / roll2,
        flank_curvature=1.0 / roll1 + 1.0 / roll2,
        edge=np.minimum(edge1, edge2),
        edge_radius=np.where(edge1 <= edge2, pinion.gear.tip_edge_radius, wheel.gear.tip_edge_radius),
        rolling1=base1 * slope + along,
        rolling2=(base2 * slope - along) / placement.pair.ratio,
    )
