"""The engagement over all tooth combinations of a pair whose teeth differ: table and picture."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from gearfem.definition.setup import Setup
from gearfem.engagement.engage import Mesh
from gearfem.engagement.turns import StaticTurns, Turns, static
from gearfem.foundation import Array
from gearfem.foundation.files import write_csv
from gearfem.foundation.units import N_PER_UM, UM
from gearfem.report import style

# Angles to the pitch: the transition from two pairs to one takes about a twentieth of it.
PER_PITCH = 60


def combinations(mesh: Mesh) -> int:
    """Return the number of pitches after which the same teeth meet again, as far as teeth differ.

    Parameters
    ----------
    mesh : Mesh
        Flanks, placement and compliance of the pair.

    Returns
    -------
    int
        1 where all teeth are alike, z1 or z2 where those of one gear differ, the hunting period lcm(z1, z2) where both do.

    Notes
    -----
    Teeth differ by flank, compliance or index error, and all of a gear by its runout.
    """
    place = mesh.placement
    kinds = Turns(mesh=mesh).kinds
    parts = ((kinds[0], place.pinion_late, place.pinion_runout), (kinds[1], place.wheel_late, place.wheel_runout))
    return math.lcm(*(len(kind) if len(set(kind)) > 1 or np.ptp(late) > 0.0 or any(runout) else 1 for kind, late, runout in parts))


def over_combinations(mesh: Mesh, torque: float) -> StaticTurns:
    """Return the slow engagement, without tooth friction, over all tooth combinations.

    Parameters
    ----------
    mesh : Mesh
        Flanks, placement and compliance of the pair.
    torque : float
        On the pinion [N m].

    Returns
    -------
    StaticTurns
        At 60 angles to the pitch, from pinion angle 0 on.
    """
    angle = np.arange(combinations(mesh) * PER_PITCH + 1) / PER_PITCH * mesh.placement.pair.pinion.pitch_angle
    return static(Turns(mesh=mesh), angle, torque)


def write_hunting(setup: Setup, mesh: Mesh, torque: float, out: Path) -> tuple[Path, Path]:
    """Write hunting.csv and hunting.png: the engagement over all tooth combinations at one torque.

    Parameters
    ----------
    setup : Setup
        Definition of the pair.
    mesh : Mesh
        What its engagement is computed from.
    torque : float
        On the pinion [N m].
    out : Path
        Folder.

    Returns
    -------
    (Path, Path)
        The two files.
    """
    turns = over_combinations(mesh, torque)
    total = turns.force.sum(axis=1)
    table = Path(out) / "hunting.csv"
    write_csv(
        table,
        {
            "pinion_angle_rad": turns.pinion_angle,
            "first_pair": turns.first,
            "transmission_error_um": turns.transmission_error / UM,
            "mesh_stiffness_N_per_um": turns.mesh_stiffness / N_PER_UM,
            "gear_ratio": _ratio(turns, setup),
            "pairs_in_contact": np.count_nonzero(turns.force > 0.0, axis=1),
            **{f"load_share_{slot}": turns.force[:, slot] / total for slot in range(turns.force.shape[1])},
        },
        (f"{setup.name}, pinion torque {torque:g} N m; load_share_k is that of pair first_pair + k",),
    )
    return table, style.save(_plot(setup, turns, torque), Path(out) / "hunting.png")


def _ratio(turns: StaticTurns, setup: Setup) -> Array:
    """Return dphi1/dphi2 under the torque, by central differences over two steps."""
    change = np.gradient(turns.transmission_error, turns.pinion_angle)
    return np.asarray(1.0 / (1.0 / setup.pair.ratio - change / setup.pair.wheel.base_radius))


@style.styled
def _plot(setup: Setup, turns: StaticTurns, torque: float) -> Figure:
    figure = style.make_figure((7.2, 5.0))[0]
    figure.clear()
    whole, near = figure.subplots(2, 1)
    pitches = turns.pinion_angle / setup.pair.pinion.pitch_angle
    error = turns.transmission_error / UM
    whole.plot(pitches, error, color=style.BLUE, linewidth=0.7)
    whole.set_title(f"All tooth combinations, {pitches[-1]:.0f} pitches, at {torque:g} N m")
    # Below, eight pitches about the place where the error swings most.
    middle = float(np.clip(pitches[int(np.argmax(np.abs(error - np.median(error))))], 4.0, max(pitches[-1] - 4.0, 4.0)))
    part = np.abs(pitches - middle) <= 4.0
    near.plot(pitches[part], error[part], color=style.VERMILION)
    near.set_title("Where it departs farthest from its median")
    for axes in (whole, near):
        axes.set_ylabel("transmission error, µm")
        axes.set_xlabel("pinion angle, pitches")
    return figure
