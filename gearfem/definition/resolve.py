"""From a validated model in file units to a `Setup` in SI: every default is resolved here and said in a sentence."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

from gearfem.definition.geometry_checks import check_centre_distance, check_gear, check_inertia, check_pair, check_rack, zero_backlash
from gearfem.definition.resolve_calibration import resolve_calibration
from gearfem.definition.resolve_drive import resolve_chain, resolve_support
from gearfem.definition.resolve_flanks import resolve_flanks
from gearfem.definition.schema import GearTable, MaterialTable, Model, RackTable
from gearfem.definition.setup import Gear, GearPair, Material, Member, Operation, Rack, Setup
from gearfem.definition.tip_edge import with_tip_edges
from gearfem.definition.validate import canonical
from gearfem.foundation import Record, digest
from gearfem.foundation.units import DEG, MM, MPA, RPM

TIP_EDGE_MODULES = 0.02
MEMBERS: tuple[Member, Member] = ("pinion", "wheel")
MATERIAL_WORDS = {
    "youngs_modulus_MPa": ("Young's modulus", " MPa"),
    "poissons_ratio": ("Poisson's ratio", ""),
    "density_kg_per_m3": ("density", " kg/m3"),
    "yield_strength_MPa": ("yield strength", " MPa"),
}


# Effects act on the records of later stages, so that what reads them is handed down.
EffectReader: TypeAlias = Callable[[Sequence[Mapping[str, Any]], Setup], tuple[Record, ...]]


def resolve(model: Model, folder: Path, effects: EffectReader) -> Setup:
    """Return the definition of a calculation, with every default resolved and named.

    Parameters
    ----------
    model : Model
        Validated tables of a model file.
    folder : Path
        Folder of that file, from which the files it names are counted.
    effects : callable
        Makes the effects of the tables [[effect]] for the pair.

    Returns
    -------
    Setup
        In SI; `assumptions` holds one sentence per value that was left open, `source` the canonical JSON of the model.

    Raises
    ------
    InputError
        If the geometry is impossible, with the dotted key that decides it, or a file of measured points cannot be used.

    Notes
    -----
    Root circles r_f = r + x m - h_f m, the backlash not taken from them. Tip circles
    r_a = min(r + x m + h_a m, a - r_f(mate) - c) with c = (h_f - h_a) m: shortened to keep the clearance of the
    rack, never lengthened. Symbols of ISO 21771.
    """
    notes: list[str] = []
    check_rack(model)
    pair = with_tip_edges(model, _pair(model, notes), notes)
    given = resolve_flanks(model, pair, folder, notes)
    setup = Setup(
        name=model.name,
        pair=pair,
        operation=_operation(model, pair, notes),
        flanks_given=given,
        calibration=resolve_calibration(model.calibration, (pair.pinion.teeth, pair.wheel.teeth)),
        assumptions=tuple(notes),
    )
    acting = effects(model.effect, setup)
    # The points count, not only the name of their file.
    return dataclasses.replace(setup, effects=acting, source=canonical(model) + (digest(given) if given else ""))


def _pair(model: Model, notes: list[str]) -> GearPair:
    if not model.pair.given("pressure_angle_deg"):
        notes.append(f"Pressure angle of the rack not given: {model.pair.pressure_angle_deg:g} deg.")
    if not model.pair.given("normal_backlash_mm"):
        notes.append(f"Normal backlash not given: {model.pair.normal_backlash_mm:g} mm of thinning.")
    rack, materials = _rack(model.rack, notes), _materials(model, notes)
    pinion, wheel = (_draft(model, member, rack, material, notes) for member, material in zip(MEMBERS, materials, strict=True))
    distance = _centre_distance(model, pinion, wheel, notes)
    tips = [_tip_radius(model, member, gear, mate, distance, notes) for member, gear, mate in _each(pinion, wheel)]
    pair = GearPair(
        pinion=dataclasses.replace(pinion, tip_radius=tips[0]),
        wheel=dataclasses.replace(wheel, tip_radius=tips[1]),
        centre_distance=distance,
        face_width=model.pair.face_width_mm * MM,
        normal_backlash=model.pair.normal_backlash_mm * MM,
    )
    check_pair(model, pair)
    return pair


def _each(pinion: Gear, wheel: Gear) -> tuple[tuple[Member, Gear, Gear], tuple[Member, Gear, Gear]]:
    return ("pinion", pinion, wheel), ("wheel", wheel, pinion)


def _table(model: Model, member: Member) -> GearTable:
    return model.pinion if member == "pinion" else model.wheel


def _rack(table: RackTable, notes: list[str]) -> Rack:
    rack = Rack(addendum=table.addendum, dedendum=table.dedendum, tip_radius=table.tip_radius)
    keys = ("addendum", "dedendum", "tip_radius")
    left = [f"{key.replace('_', ' ')} {getattr(rack, key):g}" for key in keys if not table.given(key)]
    if left:
        notes.append(f"Basic rack not given in full: {', '.join(left)} modules.")
    return rack


def _draft(model: Model, member: Member, rack: Rack, material: Material, notes: list[str]) -> Gear:
    """Return a gear with the whole tip of the rack; the tip is shortened once the centre distance is known."""
    table, module = _table(model, member), model.pair.module_mm * MM
    datum = module * table.teeth / 2.0 + table.profile_shift * module
    root = table.root_radius_mm * MM if table.root_radius_mm is not None else datum - rack.dedendum * module
    if not table.given("profile_shift"):
        notes.append(f"Profile shift of the {member} not given: 0.")
    if table.root_radius_mm is None:
        notes.append(f"Root radius of the {member} not given: {root / MM:.4f} mm, from the rack.")
    bore, edge = table.bore_radius_mm, table.tip_edge_radius_mm
    if bore is None:
        notes.append(f"Bore radius of the {member} not given: half the root radius, {root / 2.0 / MM:.4f} mm; the body is held there.")
    if edge is None and material.surface_yield_pressure is None:
        notes.append(f"Tip edge radius of the {member} not given: {TIP_EDGE_MODULES:g} module, {TIP_EDGE_MODULES * module / MM:g} mm.")
    gear = Gear(
        teeth=table.teeth,
        module=module,
        pressure_angle=model.pair.pressure_angle_deg * DEG,
        profile_shift=table.profile_shift,
        flank_thinning=model.pair.normal_backlash_mm * MM / 4.0,
        root_radius=root,
        tip_radius=datum + rack.addendum * module,
        tip_edge_radius=TIP_EDGE_MODULES * module if edge is None else edge * MM,
        bore_radius=root / 2.0 if bore is None else bore * MM,
        rack=rack,
        material=material,
    )
    check_gear(model, member, gear)
    return gear


def _materials(model: Model, notes: list[str]) -> tuple[Material, Material]:
    """Return the materials of both gears: the common table, overridden key by key, on top of steel."""
    tables, left = [], []
    for member in MEMBERS:
        given = model.material.model_dump(exclude_unset=True) | _table(model, member).material.model_dump(exclude_unset=True)
        table = MaterialTable(**given)
        tables.append(table)
        left.append(
            ", ".join(f"{words} {getattr(table, key):g}{unit}" for key, (words, unit) in MATERIAL_WORDS.items() if key not in given)
        )
    owners = ("both gears",) if left[0] == left[1] else tuple(f"the {member}" for member in MEMBERS)
    notes += [f"Material of {owner} not given in full, steel assumed: {text}." for owner, text in zip(owners, left, strict=False) if text]
    pinion, wheel = (
        Material(
            youngs_modulus=table.youngs_modulus_MPa * MPA,
            poissons_ratio=table.poissons_ratio,
            density=table.density_kg_per_m3,
            yield_strength=table.yield_strength_MPa * MPA,
            surface_yield_pressure=None if table.surface_yield_pressure_MPa is None else table.surface_yield_pressure_MPa * MPA,
        )
        for table in tables
    )
    return pinion, wheel


def _centre_distance(model: Model, pinion: Gear, wheel: Gear, notes: list[str]) -> float:
    distance = zero_backlash(pinion, wheel)
    if model.pair.centre_distance_mm is None:
        notes.append(f"Centre distance not given: {distance / MM:.4f} mm, at which the two shifts mesh without backlash.")
        return distance
    given = model.pair.centre_distance_mm * MM
    sentence = check_centre_distance(given, pinion, wheel, model.pair.normal_backlash_mm * MM)
    if sentence:
        notes.append(sentence)
    return given


def _tip_radius(model: Model, member: Member, gear: Gear, mate: Gear, distance: float, notes: list[str]) -> float:
    given = _table(model, member).tip_radius_mm
    if given is not None:
        return given * MM
    whole = gear.tip_radius
    clearance = (gear.rack.dedendum - gear.rack.addendum) * gear.module
    tip = min(whole, distance - mate.root_radius - clearance)
    # Less than a billionth of the module is the rounding of a sum, not a shortening.
    shortened = whole - tip > 1e-9 * gear.module
    cut = f"shortened by {(whole - tip) / MM:.4f} mm to keep the clearance of {clearance / MM:g} mm" if shortened else "not shortened"
    notes.append(f"Tip radius of the {member} not given: {tip / MM:.4f} mm, from the rack, {cut}.")
    return tip


def _operation(model: Model, pair: GearPair, notes: list[str]) -> Operation:
    table = model.operation
    defaults = (("efficiency", "Efficiency"), ("friction_coefficient", "Coefficient of friction"), ("damping_ratio", "Damping ratio"))
    notes += [f"{words} not given: {getattr(table, key):g}." for key, words in defaults if not table.given(key)]
    wheel_torque = table.wheel_torque_Nm
    if wheel_torque is None:
        wheel_torque = table.pinion_torque_Nm * table.efficiency * pair.ratio
        notes.append(f"Torque of the wheel not given: {wheel_torque:.6g} N m, which balances at the efficiency of {table.efficiency:g}.")
    return Operation(
        pinion_torque=table.pinion_torque_Nm,
        wheel_torque=wheel_torque,
        efficiency=table.efficiency,
        pinion_speed=table.pinion_speed_rpm * RPM,
        pinion_inertia=_inertia(table.pinion_inertia_kg_m2, "pinion", pair.pinion, pair.face_width, notes),
        wheel_inertia=_inertia(table.wheel_inertia_kg_m2, "wheel", pair.wheel, pair.face_width, notes),
        friction_coefficient=table.friction_coefficient,
        damping_ratio=table.damping_ratio,
        pinion_chain=resolve_chain(model, "pinion", notes),
        wheel_chain=resolve_chain(model, "wheel", notes),
        pinion_support=resolve_support(model, "pinion", pair.pinion, pair.face_width, notes),
        wheel_support=resolve_support(model, "wheel", pair.wheel, pair.face_width, notes),
    )


def _inertia(given: float | None, member: Member, gear: Gear, face_width: float, notes: list[str]) -> float:
    if given is not None:
        check_inertia(given, member, gear, face_width)
        return given
    inertia = gear.disc_inertia(face_width)
    notes.append(f"Inertia of the {member} not given: a solid disc of its material between bore and reference circle, {inertia:.4g} kg m2.")
    return inertia
