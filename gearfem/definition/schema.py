"""The tables of a model file, in the units of the file: names, types, ranges and defaults that need no geometry."""

from __future__ import annotations

import typing
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from gearfem.definition.calibration import COUPLING_SCALE, TIP_EDGE_SCALE

# The upper bound only keeps products of given numbers finite; no gear comes near it in any of the units used.
Positive = Annotated[float, Field(gt=0.0, lt=1e9)]
Stiff = Annotated[float, Field(gt=0.0, lt=1e15)]
NotNegative = Annotated[float, Field(ge=0.0, lt=1e9)]
Teeth = Annotated[int, Field(ge=5, le=1000)]
Shift = Annotated[float, Field(ge=-3.0, le=3.0)]
Late = Annotated[float, Field(ge=-1e4, le=1e4)]
Title = Annotated[str, Field(min_length=1, max_length=200, pattern=r"^[^\x00-\x1f\x7f]+$")]

REASONS = {
    "teeth": "fewer than 5 teeth leave no involute flank that meshes on, and above 1000 a gear is next to a rack",
    "pressure_angle_deg": "racks outside it leave no tooth of full depth",
    "profile_shift": "in modules; beyond it no tooth is left",
    "module_mm": "outside it the elastic half-spaces and the factors of ISO 6336 mean nothing",
    "poissons_ratio": "at 0.5 the material cannot be compressed and plane strain is singular",
    "pinion_speed_rpm": "the dynamics need a speed; take a low one for a slow test",
    "name": "one line of text",
}


class Table(BaseModel):
    """A table of a model file: unknown keys, wrong types, NaN and infinity are refused; an integer may stand for a number."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)

    def given(self, key: str) -> bool:
        """Return whether the user wrote this key."""
        return key in self.model_fields_set and getattr(self, key) is not None


class PairTable(Table):
    """[pair]: what both gears share."""

    module_mm: Annotated[float, Field(ge=0.01, le=1000.0)]
    pressure_angle_deg: Annotated[float, Field(ge=10.0, le=40.0)] = 20.0
    centre_distance_mm: Positive | None = None
    face_width_mm: Positive
    normal_backlash_mm: NotNegative = 0.0


class RackTable(Table):
    """[rack]: basic rack tooth profile, in modules."""

    addendum: Annotated[float, Field(gt=0.0, le=3.0)] = 1.0
    dedendum: Annotated[float, Field(gt=0.0, le=3.0)] = 1.25
    tip_radius: Annotated[float, Field(gt=0.0, le=3.0)] = 0.3


class MaterialTable(Table):
    """[material]: steel unless said otherwise."""

    youngs_modulus_MPa: Positive = 206000.0
    poissons_ratio: Annotated[float, Field(gt=-1.0, lt=0.5)] = 0.3
    density_kg_per_m3: Positive = 7850.0
    yield_strength_MPa: Positive = 1200.0
    surface_yield_pressure_MPa: Positive | None = None


class FlankTable(Table):
    """[[pinion.flank]] and [[wheel.flank]]: a measured working flank of all teeth or of one."""

    file: Title
    tooth: Annotated[int, Field(ge=0, le=999)] | None = None


class GearTable(Table):
    """[pinion] and [wheel]."""

    teeth: Teeth
    profile_shift: Shift = 0.0
    bore_radius_mm: Positive | None = None
    tip_radius_mm: Positive | None = None
    root_radius_mm: Positive | None = None
    tip_edge_radius_mm: Positive | None = None
    material: MaterialTable = MaterialTable()
    flank: list[FlankTable] = []


class OperationTable(Table):
    """[operation]: load, speed and drive."""

    pinion_torque_Nm: Positive
    wheel_torque_Nm: Positive | None = None
    efficiency: Annotated[float, Field(gt=0.0, le=1.0)] = 1.0
    pinion_speed_rpm: Positive
    pinion_inertia_kg_m2: Positive | None = None
    wheel_inertia_kg_m2: Positive | None = None
    friction_coefficient: Annotated[float, Field(ge=0.0, lt=1.0)] = 0.0
    damping_ratio: Annotated[float, Field(ge=0.0, lt=1.0)] = 0.06


class InertiaTable(Table):
    """[[drive.inertia]]: an inertia and the shaft that joins it to its neighbour nearer the gear; each side from the gear outward."""

    name: Title
    side: Literal["pinion", "wheel"]
    inertia_kg_m2: Positive
    shaft_stiffness_Nm_per_rad: Stiff
    shaft_damping_Nms_per_rad: NotNegative = 0.0


class SupportTable(Table):
    """[drive.support]: shafts and bearings along the line of action; 0 is rigid."""

    pinion_um_per_kN: NotNegative = 0.0
    wheel_um_per_kN: NotNegative = 0.0
    pinion_mass_kg: Positive | None = None
    wheel_mass_kg: Positive | None = None
    pinion_damping_Ns_per_m: NotNegative = 0.0
    wheel_damping_Ns_per_m: NotNegative = 0.0


class DriveTable(Table):
    """[drive]: what is joined to the two gears by elastic shafts and supports."""

    inertia: list[InertiaTable] = []
    support: SupportTable = SupportTable()


class RecordOffsetTable(Table):
    """[[calibration.record]]: the constant of one record, the tooth that one over teeth begins with, how one of a motion begins."""

    file: Title
    offset_um: Annotated[float, Field(ge=-1e15, le=1e15)]
    first_tooth: Annotated[int, Field(ge=0, le=100_000)] = 0
    kick: Annotated[list[Annotated[float, Field(ge=-100.0, le=100.0)]], Field(min_length=2, max_length=2)] = [0.0, 0.0]


class CalibrationTable(Table):
    """[calibration]: nuisances that a diagnosis fitted."""

    stiffness_scale: Annotated[float, Field(ge=0.1, le=10.0)] = 1.0
    torque_scale: Annotated[float, Field(ge=0.1, le=10.0)] = 1.0
    inertia_scale: Annotated[float, Field(ge=0.1, le=10.0)] = 1.0
    damping_scale: Annotated[float, Field(ge=0.01, le=100.0)] = 1.0
    gain: Annotated[float, Field(ge=0.1, le=10.0)] = 1.0
    series_compliance_um_per_N: Annotated[float, Field(ge=-1.0, le=1.0)] = 0.0
    coupling_scale: Annotated[float, Field(ge=COUPLING_SCALE[0], le=COUPLING_SCALE[1])] = 1.0
    tip_edge_scale: Annotated[float, Field(ge=TIP_EDGE_SCALE[0], le=TIP_EDGE_SCALE[1])] = 1.0
    contact_compliance_scale: Annotated[float, Field(ge=0.01, le=100.0)] = 1.0
    body_compliance_scale: Annotated[float, Field(ge=0.01, le=100.0)] = 1.0
    contact_depth_scale: Annotated[float, Field(ge=0.01, le=100.0)] = 1.0
    contact_evenness: Annotated[float, Field(ge=-0.5, le=1.5)] = 0.0
    friction_coefficient: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0
    misalignment_um: Annotated[float, Field(ge=-1e3, le=1e3)] = 0.0
    centre_distance_um: Annotated[float, Field(ge=-1e3, le=1e3)] = 0.0
    angle_offset_rad: Annotated[float, Field(ge=-10.0, le=10.0)] = 0.0
    pinion_index_error_um: list[Late] = []
    wheel_index_error_um: list[Late] = []
    record: list[RecordOffsetTable] = []


class Model(Table):
    """A whole model file; what [[effect]] may hold is for the catalogue of effects to say."""

    name: Title = "gear pair"
    pair: PairTable
    pinion: GearTable
    wheel: GearTable
    rack: RackTable = RackTable()
    material: MaterialTable = MaterialTable()
    operation: OperationTable
    drive: DriveTable = DriveTable()
    effect: list[dict[str, Any]] = []
    calibration: CalibrationTable = CalibrationTable()


def table_of(annotation: Any) -> type[BaseModel] | None:
    """Return the table that a key holds, one or a list of them; None for a plain value."""
    inner = typing.get_args(annotation)[0] if typing.get_origin(annotation) is list else annotation
    return inner if isinstance(inner, type) and issubclass(inner, BaseModel) else None


def valid_names(table: type[BaseModel] = Model, prefix: str = "") -> dict[str, tuple[str, ...]]:
    """Return the valid keys of every table, by the table's dotted name ("" is the top of the file)."""
    names = {prefix: tuple(table.model_fields)}
    for key, field in table.model_fields.items():
        inner = table_of(field.annotation)
        if inner is not None:
            names |= valid_names(inner, f"{prefix}.{key}".lstrip("."))
    return names


def field_of(path: tuple[str, ...]) -> Any:
    """Return pydantic's description of a key given by its path, places in lists left out; the path must be valid."""
    table: type[BaseModel] = Model
    for key in path[:-1]:
        inner = table_of(table.model_fields[key].annotation)
        assert inner is not None
        table = inner
    return table.model_fields[path[-1]]
