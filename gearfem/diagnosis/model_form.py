"""How our own model may be wrong: variants of it, and what they would do to the records of a campaign."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from gearfem.compliance.body import scale_body
from gearfem.contact.scaled import ScaledLaw
from gearfem.diagnosis.bench import Settings
from gearfem.diagnosis.campaign import Measurement
from gearfem.diagnosis.system_bench import SystemBench
from gearfem.diagnosis.teeth import Scatter, tooth_columns
from gearfem.flank import Outline
from gearfem.foundation import Array
from gearfem.foundation.units import UM
from gearfem.sensing import System


@dataclasses.dataclass(frozen=True, kw_only=True)
class Variant:
    """A way in which the model may be wrong, at one standard deviation.

    Parameters
    ----------
    words : str
        For reports.
    change : callable
        Takes a System and returns the variant.
    """

    words: str
    change: Callable[[System], System]


def _contact(scale: float) -> Callable[[System], System]:
    return lambda system: dataclasses.replace(system, law=ScaledLaw(law=system.law, scale=scale))


def _body(scale: float) -> Callable[[System], System]:
    return lambda system: dataclasses.replace(system, compliance=scale_body(system.compliance, scale))


def _friction(coefficient: float) -> Callable[[System], System]:
    def change(system: System) -> System:
        drive = system.drive
        return dataclasses.replace(system, drive=dataclasses.replace(drive, friction_coefficient=drive.friction_coefficient + coefficient))

    return change


def _half_space(system: System) -> System:
    return dataclasses.replace(system, compliance=system.compliance.on_half_space())


def _sharp_edges(system: System) -> System:
    flanks = system.flanks

    def sharper(outline: Outline) -> Outline:
        return dataclasses.replace(outline, gear=dataclasses.replace(outline.gear, tip_edge_radius=0.25 * outline.gear.tip_edge_radius))

    # The compliance stays: its table counts from form circle to round, whose beginning moves by a hundredth of the flank.
    flanks = dataclasses.replace(
        flanks,
        pinion=sharper(flanks.pinion),
        wheel=sharper(flanks.wheel),
        pinion_odd=tuple((number, sharper(outline)) for number, outline in flanks.pinion_odd),
        wheel_odd=tuple((number, sharper(outline)) for number, outline in flanks.wheel_odd),
    )
    return dataclasses.replace(system, flanks=flanks)


# Sizes: what independent ways of computing each part differ by (Hertz depth rules, body formulae), and friction that nobody measured.
VARIANTS = (
    Variant(words="contact law, 20 %", change=_contact(1.20)),
    Variant(words="gear bodies, 20 %", change=_body(1.20)),
    Variant(words="depth of the contact", change=_half_space),
    Variant(words="tooth friction, 0.02", change=_friction(0.02)),
    Variant(words="tip edges, from 0.02 to 0.005 modules", change=_sharp_edges),
)
# Form errors that all teeth of a gear share, beside the waviness of each.
COMMON_FORM = 0.1 * UM


def model_form(
    records: tuple[Measurement, ...], bench: SystemBench, settings: Settings, predicted: tuple[Array, ...], scatter: Scatter
) -> tuple[Array, ...]:
    """Return what our own errors would do to each record, at one standard deviation.

    Parameters
    ----------
    records : tuple of Measurement
        Of one campaign.
    bench : SystemBench
        The model.
    settings : Settings
        Where it stands.
    predicted : tuple of ndarray
        What it predicts there.
    scatter : Scatter
        Terms of the form of a flank.

    Returns
    -------
    tuple of ndarray, shapes (n, v)
        One column for each variant of the model, then the form errors that all teeth of the pinion, and of the wheel, share.
    """
    others = [SystemBench(system=variant.change(bench.system)) for variant in VARIANTS]
    out = []
    for record, own in zip(records, predicted, strict=True):
        columns = [other.predict(record, settings) - own for other in others]
        out.append(np.column_stack([*columns, _common(record, bench, settings, scatter)]))
    return tuple(out)


def _common(record: Measurement, bench: SystemBench, settings: Settings, scatter: Scatter) -> Array:
    """Return the columns of form errors common to all teeth of either gear, shape (n, 2 terms)."""
    teeth = tooth_columns(record, bench, settings, scatter).reshape(len(record.axis), -1, scatter.terms + 1)[:, :, 1:]
    z1 = bench.pair.pinion.teeth
    sizes = COMMON_FORM * np.sqrt((2.0 * np.arange(1, scatter.terms + 1) + 1.0) / scatter.terms)
    return np.concatenate([teeth[:, :z1].sum(axis=1) * sizes, teeth[:, z1:].sum(axis=1) * sizes], axis=1)
