"""Full contact by finite elements, frictionless and in plane strain, beside the loaded engagement of gearfem.

Both whole gears are meshed with their exact outlines, bores held, 4 and 8 elements in half a band of contact. Loads on the
pinion's edges are multipliers: in the mean over an edge no gap may be negative, and no load may pull. The gap is that of the exact
outlines with the wheel turned back by its lag, which is solved for the torque, plus the displacements of both. Hertz's law only
says where to refine; no local depth and no reading on a centreline enters. Small displacements: loads keep the normals that the
pinion has before it bends.

    python studies/contact_fe.py studies/coal_combine/model.toml --out results [--small]
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from common import HERE, print_table, write_rows

from gearfem import load_model
from gearfem.compliance import Bore, PlaneStrain, make_compliance
from gearfem.compliance.elasticity import stiffness
from gearfem.compliance.load_lines import LoadLines, forces
from gearfem.compliance.section_mesh import SectionMesh, sector_mesh
from gearfem.contact import EdgedLine, Line
from gearfem.definition.setup import Setup
from gearfem.engagement.engage import Mesh, engage
from gearfem.engagement.record import Engagement
from gearfem.flank import Outline, make_flanks
from gearfem.foundation import SolveError
from gearfem.foundation.threads import one_thread
from gearfem.placement import make_placement

Level: TypeAlias = tuple[float, float]
# Edges in half a band of contact, and resolution of the mesh elsewhere.
FULL: tuple[Level, ...] = ((4.0, 1.5), (8.0, 2.5))
SMALL: tuple[Level, ...] = ((4.0, 1.5), (5.0, 2.0))
COLUMNS = (
    "te_um, contact_te_um: transmission error of the engagement and of full contact",
    "contact_te_change_pct, contact_share_change: from the coarser to the finer mesh of full contact",
    "contact_share: largest load share; share_difference: largest of all pairs",
    "times_faster: one angle of full contact, mesh and factors included, over one of many angles of the engagement",
)
# Angles over which the engagement is timed.
TIMED = 200
OFFSETS = (-3, -2, -1, 1, 2, 3)
# Edges of contact reach so many half widths to both sides of the band that is expected, and keep their length there.
REACH = 2.5
GAUSS, WEIGHT = np.polynomial.legendre.leggauss(3)


class Spot(NamedTuple):
    """Where a pair is expected to touch: parameters of both outlines, half width of the band and reach of the edges [m]."""

    u1: float
    u2: float
    width: float
    reach: float


class Cells(NamedTuple):
    """Edges of the pinion that may touch, c of them: unit loads on both gears, and the contact as it stands."""

    pair: np.ndarray
    load1: np.ndarray
    load2: np.ndarray
    gap: np.ndarray
    arm: np.ndarray


class Pose(NamedTuple):
    """Where the teeth of one pair stand: angles of their axes about their centres, in the sense of rotation of each."""

    axis1: float
    axis2: float
    distance: float


def turn(vectors: np.ndarray, angle: float) -> np.ndarray:
    cosine, sine = np.cos(angle), np.sin(angle)
    return vectors @ np.array([[cosine, sine], [-sine, cosine]])


def opposite(outline: Outline, place: np.ndarray, ahead: np.ndarray, start: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the parameters at which rays from places meet an outline, and how far that is."""
    aside = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)
    u, step = np.full(len(place), start), 1e-6
    for _ in range(60):
        off = ((outline.point(u) - place) * aside).sum(axis=1)
        slope = ((outline.point(u + step) - outline.point(u - step)) * aside).sum(axis=1) / (2.0 * step)
        move = np.clip(-off / slope, -0.02, 0.02)
        u = np.clip(u + move, 2.0, 4.9)
        if np.abs(move).max() < 1e-11:
            break
    return u, ((outline.point(u) - place) * ahead).sum(axis=1)


def edges_near(section: SectionMesh, outline: Outline, place: float, reach: float) -> np.ndarray:
    """Return the parameters of the ends of edges within reach of a place, shape (e, 2)."""
    ends = section.outline_u[::2]
    ends = np.stack([ends[:-1], ends[1:]], axis=1)
    away = np.hypot(*(outline.point(ends.mean(axis=1)) - outline.point(place)).T)
    return ends[(away < reach) & (ends[:, 0] > 2.0 - 1e-9) & (ends[:, 1] < 4.0 + 1e-9)]


def lines_at(outline: Outline, u: np.ndarray, direction: np.ndarray) -> LoadLines:
    return LoadLines(u=u, point=outline.point(u), direction=direction, depth=np.ones_like(u))


class ContactModel:
    """Both gears at one pinion angle, meshed around the contacts of some pairs."""

    def __init__(self, mesh: Mesh, angle: float, pairs: dict[int, Spot], parts: float, resolution: float) -> None:
        self.mesh, self.angle, self.pairs = mesh, angle, pairs
        self.outlines = mesh.flanks.pinion, mesh.flanks.wheel
        self.sections = tuple(
            sector_mesh(outline, resolution, tuple((spot[side], spot.width / parts, spot.reach) for spot in pairs.values()))
            for side, outline in enumerate(self.outlines)
        )
        self.size = tuple(2 * section.mesh.doflocs.shape[1] for section in self.sections)

    def cells(self, error: float) -> Cells:
        """Return the contact with the wheel lagging by an error along the line of action [m]."""
        place, pair = self.mesh.placement, self.mesh.placement.pair
        parts = []
        for number, spot in self.pairs.items():
            angle = self.angle - number * pair.pinion.pitch_angle
            lag = error / pair.wheel.base_radius
            pose = Pose(angle + place.pinion_start, -(angle / pair.ratio - lag + place.wheel_start), place.centre_distance)
            parts.append(self._pair(number, pose, spot))
        return Cells(*(np.concatenate([p[i] for p in parts], axis=1 if i in (1, 2) else 0) for i in range(5)))

    def _pair(self, number: int, pose: Pose, spot: Spot) -> Cells:
        pinion, wheel = self.outlines
        ends = edges_near(self.sections[0], pinion, spot.u1, spot.reach)
        u = (ends[:, :1] + (0.5 + 0.5 * GAUSS) * (ends[:, 1:] - ends[:, :1])).ravel()
        speed = np.hypot(*(pinion.point(u + 1e-6) - pinion.point(u - 1e-6)).T) / 2e-6
        share = (speed.reshape(-1, 3) * WEIGHT).ravel()
        share = (share.reshape(-1, 3) / share.reshape(-1, 3).sum(axis=1, keepdims=True)).ravel()
        normal = pinion.normal(u)
        point, ahead = turn(pinion.point(u), pose.axis1), turn(normal, pose.axis1)
        seen = turn(np.array([pose.distance, 0.0]) - point, -pose.axis2)
        ray = turn(-ahead, -pose.axis2)
        met, gap = opposite(wheel, seen, ray, spot.u2)
        arm = point[:, 0] * ahead[:, 1] - point[:, 1] * ahead[:, 0]

        def means(values: np.ndarray) -> np.ndarray:
            return (values * share).reshape(*values.shape[:-1], -1, 3).sum(axis=-1)

        load1 = means(forces(self.sections[0], lines_at(pinion, u, -normal)))
        load2 = means(forces(self.sections[1], lines_at(wheel, met, ray)))
        return Cells(np.full(len(ends), number), load1, load2, means(gap), means(arm))

    def compliance(self, cells: Cells) -> np.ndarray:
        """Return the approach of every edge under a unit load on every other, both whole gears, shape (c, c)."""
        total = np.zeros((len(cells.pair), len(cells.pair)))
        apart = cells.pair[:, None] - cells.pair[None, :]
        for outline, section, load, sense in zip(self.outlines, self.sections, (cells.load1, cells.load2), (-1, 1), strict=True):
            with one_thread():
                used = np.flatnonzero(np.any(load != 0.0, axis=1).reshape(2, -1).any(axis=0))
                ring = Bore().structure(section, stiffness(section.mesh, PlaneStrain(), outline.gear.material), outline.gear.teeth, used)
                tables = dict(zip(OFFSETS, ring.coupling(load, OFFSETS), strict=True))
                tables[0] = load.T @ ring.displacements(load, (0,))[0]
            for offset in np.unique(sense * apart):
                total = np.where(sense * apart == offset, total + tables[int(offset)], total)
        return 0.5 * (total + total.T)


def press(compliance: np.ndarray, gap: np.ndarray) -> np.ndarray:
    """Return the loads that keep gaps from closing and pull nowhere, by active sets."""
    active = gap < 0.0
    for _ in range(100):
        force = np.zeros_like(gap)
        force[active] = np.linalg.solve(compliance[np.ix_(active, active)], -gap[active])
        left = gap + compliance @ force
        wanted = np.where(active, force > 0.0, left < 0.0)
        if (wanted == active).all():
            return force
        active = wanted
    raise SolveError("the active set of the contact did not settle")


def spots(mesh: Mesh, guess: Engagement, stretch: float) -> dict[int, Spot]:
    """Return where pairs may touch at one angle; pairs that hardly do are given a tenth of the largest load."""
    contacts, law = guess.contacts, EdgedLine(pinion=mesh.law.pinion, wheel=mesh.law.wheel)
    found = {}
    for j, number in enumerate(contacts.pairs):
        if contacts.reach[0, j] and contacts.gap[0, j] < 1.1 * guess.transmission_error[0]:
            load = max(float(guess.force[0, j]), 0.1 * float(guess.force.max())) / mesh.placement.pair.face_width
            line = Line(contacts.flank_radius[0, j], np.array(1.0), np.array(1.0), contacts.edge[0, j], contacts.edge_radius[0, j])
            width = float(law.hertz.half_width(load, law.effective_radius(load, line)))
            reach = stretch * (REACH * width + abs(float(law.centre(load, line))))
            found[number] = Spot(float(contacts.u1[0, j]), float(contacts.u2[0, j]), width, reach)
    return found


def solve(mesh: Mesh, angle: float, torque: float, parts: float, resolution: float) -> tuple[float, dict[int, float]]:
    """Return the transmission error [m] and the load shares of the pairs at one angle, by full contact.

    `parts` is the number of edges in half a band, `resolution` that of the mesh away from the contacts.
    """
    guess = engage(mesh, np.array([angle]), torque)
    for stretch in (1.0, 1.6, 2.5):
        model = ContactModel(mesh, angle, spots(mesh, guess, stretch), parts, resolution)
        error, force, cells = carry(model, float(guess.transmission_error[0]), torque)
        own = [force[cells.pair == number] for number in model.pairs]
        if not any(part[0] > 0.0 or part[-1] > 0.0 for part in own):
            return error, {number: float(part.sum() / force.sum()) for number, part in zip(model.pairs, own, strict=True)}
    raise SolveError("a band of contact runs beyond the edges foreseen for it")


def carry(model: ContactModel, start: float, torque: float) -> tuple[float, np.ndarray, Cells]:
    """Return the transmission error [m] under a torque, with the loads on the edges, by the secant method."""
    table = model.compliance(model.cells(start))
    width = model.mesh.placement.pair.face_width

    def missing(error: float) -> tuple[float, np.ndarray, Cells]:
        cells = model.cells(error)
        force = press(table, cells.gap)
        return float(force @ cells.arm) * width - torque, force, cells

    last, error = start, 1.01 * start
    before = missing(last)[0]
    for _ in range(30):
        now, force, cells = missing(error)
        if abs(now) < 1e-9 * torque:
            return error, force, cells
        last, before, error = error, now, error - now * (error - last) / (now - before)
    raise SolveError("the lag of the wheel did not converge")


# ---- the study ------------------------------------------------------------------------------------------


def angles(setup: Setup) -> dict[str, float]:
    """Return pinion angles over one pitch: where pair 0 is about to begin, begins, is alone and has just ended."""
    pair = setup.pair
    pitch, begin, end = (
        pair.pinion.pitch_angle,
        -pair.approach_length / pair.pinion.base_radius,
        pair.recess_length / pair.pinion.base_radius,
    )
    both, alone = end - pitch, begin + pitch
    return {
        "corner, before the path": begin - 0.02 * pitch,
        "corner, just before": begin - 0.008 * pitch,
        "tip edge, just begun": begin + 0.01 * pitch,
        "two pairs, middle": 0.5 * (begin + both),
        "one pair, early": both + 0.15 * (alone - both),
        "one pair, middle": 0.5 * (both + alone),
        "one pair, late": alone - 0.15 * (alone - both),
        "corner, just after": end + 0.008 * pitch,
        "corner, after the path": end + 0.02 * pitch,
    }


def make_mesh(setup: Setup) -> Mesh:
    flanks, pair = make_flanks(setup), setup.pair
    law = EdgedLine(pinion=pair.pinion.material, wheel=pair.wheel.material)
    return Mesh(flanks=flanks, placement=make_placement(setup), compliance=make_compliance(flanks), law=law)


def compare(setup: Setup, levels: tuple[Level, ...], every: int = 1) -> list[dict[str, Any]]:
    """Return one row for each angle: the engagement, full contact on each mesh, and their differences."""
    mesh, torque = make_mesh(setup), setup.operation.pinion_torque
    return [_row(mesh, setup.name, place, angle, torque, levels) for place, angle in list(angles(setup).items())[::every]]


def _row(mesh: Mesh, gears: str, place: str, angle: float, torque: float, levels: tuple[Level, ...]) -> dict[str, Any]:
    began = time.perf_counter()
    ours = engage(mesh, np.full(TIMED, angle), torque)
    took = (time.perf_counter() - began) / TIMED
    began = time.perf_counter()
    results = [solve(mesh, angle, torque, *level) for level in levels]
    error, shares = results[-1]
    first = results[0][0]
    own = dict(zip(ours.contacts.pairs, ours.load_share[0], strict=True))
    largest = max(abs(own.get(number, 0.0) - shares.get(number, 0.0)) for number in {*own, *shares})
    change = max(abs(results[0][1][number] - shares[number]) for number in shares)
    te = float(ours.transmission_error[0])
    return {
        "gears": gears,
        "place": place,
        "pitches": angle / mesh.placement.pair.pinion.pitch_angle,
        "te_um": te * 1e6,
        "contact_te_um": error * 1e6,
        "te_difference_pct": 100.0 * (te / error - 1.0),
        "contact_te_change_pct": 100.0 * (first / error - 1.0),
        "contact_share": max(shares.values()),
        "share_difference": float(largest),
        "contact_share_change": change,
        "times_faster": (time.perf_counter() - began) / took / len(levels),
    }


def main(arguments: list[str] | None = None) -> list[dict[str, Any]]:
    """Run the study, write its table, print it and return its rows."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("model", nargs="*", type=Path, default=[HERE / "coal_combine" / "model.toml"], help="model files (TOML)")
    parser.add_argument("--out", type=Path, required=True, help="folder for the table")
    parser.add_argument("--small", action="store_true", help="every other angle, on coarse meshes")
    options = parser.parse_args(arguments)
    levels = SMALL if options.small else FULL
    rows = [row for model in options.model for row in compare(load_model(model), levels, 2 if options.small else 1)]
    write_rows(options.out / "contact_fe.csv", rows, COLUMNS)
    print_table("Loaded engagement against full contact by finite elements", rows)
    print("  " + "\n  ".join(COLUMNS))
    inside = [row for row in rows if not row["place"].startswith("corner")]
    corner = [row for row in rows if row["place"].startswith("corner")]
    for name, part in (("inside the path of contact", inside), ("in corner contact", corner)):
        te, share = (max(abs(row[key]) for row in part) for key in ("te_difference_pct", "share_difference"))
        print(f"{name}: transmission error within {te:.2f} %, load shares within {share:.4f}")
    return rows


if __name__ == "__main__":
    main()
