"""The stage that turns a definition into the flanks of both gears."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from functools import partial

import numpy as np

from gearfem.definition.setup import GearPair, Member, Setup
from gearfem.flank.lead import Lead
from gearfem.flank.measured import fitted_flanks
from gearfem.flank.outline import FLANK, Outline
from gearfem.flank.run_out import with_run_out
from gearfem.foundation import InputError, Record
from gearfem.foundation.units import MM


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Flanks(Record):
    """Outlines of the teeth of both gears.

    Parameters
    ----------
    pinion, wheel : Outline
        Working side of a tooth of each gear; the idle side is its unworn mirror image.
    pinion_odd, wheel_odd : tuple of (int, Outline)
        Teeth whose working flank differs from that of the others, by number.
    lead : Lead
        Gap along the face width, common to all pairs.
    """

    pinion: Outline
    wheel: Outline
    pinion_odd: tuple[tuple[int, Outline], ...] = ()
    wheel_odd: tuple[tuple[int, Outline], ...] = ()
    lead: Lead = dataclasses.field(default_factory=Lead)

    def of(self, member: Member) -> Outline:
        """Return the outline that most teeth of a gear have."""
        return self.pinion if member == "pinion" else self.wheel

    def odd(self, member: Member) -> dict[int, Outline]:
        """Return the outlines that differ, by tooth."""
        return dict(self.pinion_odd if member == "pinion" else self.wheel_odd)

    def edged(self, scale: float) -> Flanks:
        """Return the same flanks with tip edges of a multiple of their radius, which must leave a tip; 1 changes no bit."""

        def edged(outline: Outline) -> Outline:
            radius = scale * outline.gear.tip_edge_radius
            return dataclasses.replace(outline, gear=dataclasses.replace(outline.gear, tip_edge_radius=radius))

        return dataclasses.replace(
            self,
            pinion=edged(self.pinion),
            wheel=edged(self.wheel),
            pinion_odd=tuple((number, edged(outline)) for number, outline in self.pinion_odd),
            wheel_odd=tuple((number, edged(outline)) for number, outline in self.wheel_odd),
        )


def make_flanks(setup: Setup) -> Flanks:
    """Return the flanks of a gear pair, measured ones where they are given, and refuse a pair whose flanks interfere.

    Parameters
    ----------
    setup : Setup
        Definition of the pair.

    Returns
    -------
    Flanks

    Raises
    ------
    InputError
        If an outline is impossible, measured points cannot be used, a tip cuts into the fillet of its mate, or undercut leaves
        a contact ratio below 1.

    Notes
    -----
    The tip of the mate reaches down to the roll length a sin(alpha_w) - s_tip on a flank (ISO 21771). Where that
    lies below the form circle, the tip round is followed through the space: it may pass an undercut fillet freely,
    and the path of contact then begins at the form circle.
    """
    pair = setup.pair
    pinion, pinion_odd = _outlines(setup, "pinion")
    wheel, wheel_odd = _outlines(setup, "wheel")
    flanks = Flanks(pinion=pinion, wheel=wheel, pinion_odd=pinion_odd, wheel_odd=wheel_odd)
    _refuse_interference("pinion", flanks.pinion, flanks.wheel, pair)
    _refuse_interference("wheel", flanks.wheel, flanks.pinion, pair)
    _refuse_short_path(flanks, pair)
    return flanks


def _outlines(setup: Setup, member: Member) -> tuple[Outline, tuple[tuple[int, Outline], ...]]:
    """Return the outline of most teeth of a gear, and those of single teeth that were measured."""
    gear = setup.pair.gear(member)
    surface = "material.surface_yield_pressure_MPa" if gear.tip_run_out > 0.0 else ""
    whole = _named(member, surface, lambda: with_run_out(gear))
    odd: dict[int, Outline] = {}
    for flank in fitted_flanks(setup):
        if flank.points.member == member:
            outline = _named(member, f"flank ({flank.points.file})", partial(Outline, gear=gear, deviation=flank.deviation))
            if flank.points.tooth is None:
                whole = outline
            else:
                odd[flank.points.tooth] = outline
    return whole, tuple(sorted(odd.items()))


def _named(member: Member, key: str, make: Callable[[], Outline]) -> Outline:
    """Let the refusal of an outline name the gear, and the key that brought the deviation where one did."""
    try:
        return make()
    except InputError as error:
        where = error.where if error.where.startswith("rack") else f"{member}.{error.where}"
        if key and error.where in ("deviation", "tip_edge_radius_mm"):
            where = f"{member}.{key}"
        raise InputError(where, error.found, error.allowed) from None


def path_of_contact(flanks: Flanks, pair: GearPair) -> tuple[float, float]:
    """Return the lengths of approach and recess on the line of action [m], cut off where undercut took the flank away.

    Parameters
    ----------
    flanks : Flanks
        Outlines of both gears.
    pair : GearPair
        The gears as mounted.

    Returns
    -------
    (float, float)
        From the pitch point, both positive; their sum over the base pitch is the contact ratio.
    """
    slope = math.tan(pair.working_pressure_angle)
    lowest1 = pair.pinion.base_radius * slope - flanks.pinion.flank_start
    lowest2 = pair.wheel.base_radius * slope - flanks.wheel.flank_start
    return min(pair.approach_length, lowest1), min(pair.recess_length, lowest2)


def _refuse_short_path(flanks: Flanks, pair: GearPair) -> None:
    ratio = sum(path_of_contact(flanks, pair)) / pair.base_pitch
    if ratio < 1.0:
        member = "pinion" if flanks.pinion.undercut else "wheel"
        gear = flanks.pinion.gear if member == "pinion" else flanks.wheel.gear
        found = f"{gear.profile_shift:g}, with which undercut shortens the path to a contact ratio of {ratio:.4f}"
        raise InputError(f"{member}.profile_shift", found, "a contact ratio of at least 1: raise this shift")


def _refuse_interference(member: Member, outline: Outline, mate: Outline, pair: GearPair) -> None:
    """Refuse a pair if the mate's tip round, on its way through the space, reaches into the fillet."""
    gear, other = outline.gear, mate.gear
    share = pair.centre_distance / (gear.teeth + other.teeth)
    turned = np.linspace(-1.5, 1.5, 601) * gear.pitch_angle
    lead, radius = mate.round_centre
    polar = lead - turned * gear.teeth / other.teeth - other.half_angle(share * other.teeth)
    centre = np.stack([pair.centre_distance - radius * np.cos(polar), -radius * np.sin(polar)], axis=-1)
    axis = turned - gear.half_angle(share * gear.teeth)
    x = centre[:, 0] * np.cos(axis) + centre[:, 1] * np.sin(axis)
    y = centre[:, 1] * np.cos(axis) - centre[:, 0] * np.sin(axis)
    fillet = outline.point(np.linspace(0.0, FLANK, 801))
    nearest = np.hypot(x[:, None] - fillet[:, 0], y[:, None] - fillet[:, 1]).min()
    depth = other.tip_edge_radius - float(nearest)
    # Points of fillet and path stand some hundredths of the module apart; what they miss is below this.
    if depth > 2e-4 * gear.module:
        lowest = pair.centre_distance * math.sin(pair.working_pressure_angle) - mate.flank_end
        contact = math.hypot(gear.base_radius, lowest) if lowest > 0.0 else gear.base_radius
        raise InputError(
            f"{member}.profile_shift",
            f"{gear.profile_shift:g}, with which the mate's tip cuts {depth / MM:.4f} mm into the fillet of the {member} "
            f"(lowest contact at {contact / MM:.4f} mm, form circle {outline.form_radius / MM:.4f} mm)",
            "a pair without interference: raise this shift, or lower the tip radius of the mate",
        )
