"""Gear pairs that many tests share, built in SI without any file."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from gearfem.definition.setup import Gear, GearPair, Material, Operation, Rack, Setup
from gearfem.dynamics import DriveTrain
from gearfem.engagement.record import MeshForce
from gearfem.flank import Flanks
from gearfem.placement import Placement

# Most trusted first: a wrong formula is to fail where it is proved, not where it is pinned.
TRUST = ("truth", "invariance", "convergence", "limits", "published", "contract", "recovery", "unit", "studies", "pinned", "house")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Run the tests in the order of trust, doctests of the package last."""

    def rank(item: pytest.Item) -> int:
        folder = item.path.parent.name
        return TRUST.index(folder) if folder in TRUST else len(TRUST)

    items.sort(key=rank)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Print what the tests against published numbers deviate by, also when they pass."""
    reports = [report for report in terminalreporter.stats.get("passed", []) if "published/" in report.nodeid and report.capstdout]
    if reports:
        terminalreporter.section("published numbers")
    for report in reports:
        terminalreporter.write_line(report.capstdout.strip())


def make_gear(teeth: int, module: float, tip_radius: float, profile_shift: float = 0.0, **changes: object) -> Gear:
    """Return a steel gear of the standard rack; radii in metres."""
    rack = changes.pop("rack", Rack())
    reference = module * teeth / 2.0
    root = reference + profile_shift * module - rack.dedendum * module
    values: dict[str, object] = {
        "teeth": teeth,
        "module": module,
        "pressure_angle": math.radians(20.0),
        "profile_shift": profile_shift,
        "flank_thinning": 0.0,
        "root_radius": root,
        "tip_radius": tip_radius,
        "tip_edge_radius": 0.02 * module,
        "bore_radius": root / 2.0,
        "rack": rack,
        "material": Material(),
    }
    return Gear(**{**values, **changes})


@pytest.fixture(scope="session")
def gear_factory():
    """The function that makes gears, for tests that vary them."""
    return make_gear


@pytest.fixture(scope="session")
def coal_combine() -> Setup:
    """Table 1 of Wojnarowski & Onishchenko (2003)."""
    thin = 0.055e-3
    pair = GearPair(
        pinion=make_gear(16, 8e-3, 76.17e-3, 0.8, flank_thinning=thin, bore_radius=30e-3),
        wheel=make_gear(51, 8e-3, 219.17e-3, 1.175, flank_thinning=thin, bore_radius=60e-3),
        centre_distance=281.57e-3,
        face_width=75e-3,
        normal_backlash=0.22e-3,
    )
    operation = Operation(
        pinion_torque=1605.0,
        wheel_torque=4911.0,
        efficiency=0.96,
        pinion_speed=53.0,
        pinion_inertia=10.16,
        wheel_inertia=6.72,
        friction_coefficient=0.10,
        damping_ratio=0.18,
    )
    return Setup(name="coal combine", pair=pair, operation=operation)


@pytest.fixture(scope="session")
def small_pair() -> Setup:
    """An unshifted 20/30 pair of module 2 mm whose contact ratio is 1.6."""
    pair = GearPair(
        pinion=make_gear(20, 2e-3, 22e-3),
        wheel=make_gear(30, 2e-3, 32e-3),
        centre_distance=50e-3,
        face_width=20e-3,
        normal_backlash=0.0,
    )
    operation = Operation(
        pinion_torque=50.0,
        wheel_torque=75.0,
        efficiency=1.0,
        pinion_speed=100.0,
        pinion_inertia=pair.pinion.disc_inertia(20e-3),
        wheel_inertia=pair.wheel.disc_inertia(20e-3),
        friction_coefficient=0.0,
        damping_ratio=0.06,
    )
    return Setup(name="20/30", pair=pair, operation=operation)


def make_mesh(teeth: int, radii: tuple[float, float], stiffness: Callable[[np.ndarray], np.ndarray], **changes: object) -> MeshForce:
    """Return analytic tables: P = C(phi) (e - e_u(phi)) on constant arms; friction arms h1, h2 by `friction(phi)`."""
    period = 2.0 * math.pi / teeth
    count = changes.pop("angles", 256)
    angle = period * (np.arange(count) + changes.pop("offset", 0.0)) / count
    columns = changes.pop("columns", np.linspace(0.0, 60e-6, 25))
    unloaded = changes.pop("unloaded", np.zeros_like)(angle)
    force = stiffness(angle)[:, None] * np.maximum(columns - unloaded[:, None], 0.0)
    arm1, arm2 = changes.pop("friction", lambda phi: (0.0 * phi, 0.0 * phi))(angle)
    values: dict[str, object] = {
        "pinion_angle": angle,
        "period": period,
        "deflection": columns,
        "normal_force": force,
        "pinion_moment": radii[0] * force,
        "wheel_moment": radii[1] * force,
        "pinion_friction": arm1[:, None] * force,
        "wheel_friction": arm2[:, None] * force,
        "unloaded_error": unloaded,
        "sliding_reversals": np.empty(0),
        "base_radius1": radii[0],
        "base_radius2": radii[1],
        "normal_backlash": 1.0,
        "mean_stiffness": float(stiffness(angle).mean()),
    }
    return MeshForce(**{**values, **changes})


@pytest.fixture(scope="session")
def mesh_factory():
    """The function that makes analytic force tables for the dynamics."""
    return make_mesh


@pytest.fixture(scope="session")
def coal_drive() -> DriveTrain:
    """Drive of the coal combine pair, without tooth friction."""
    return DriveTrain(
        pinion_inertia=10.16,
        wheel_inertia=6.72,
        pinion_torque=1605.0,
        wheel_torque=4911.0,
        efficiency=0.96,
        pinion_speed=53.0,
        friction_coefficient=0.0,
        damping_ratio=0.18,
    )


def first_by_brute_force(flanks: Flanks, placement: Placement, angle: float) -> float:
    """Return the gap at which dense polylines of both teeth touch: each point of one against the segments of the other."""
    pair, u = placement.pair, np.concatenate([np.linspace(2.0, 3.0, 6001), np.linspace(3.0, 4.0, 4001)[1:]])
    axis1 = angle + placement.pinion_start
    (x1, y1), (x2, y2) = flanks.pinion.point(u).T, flanks.wheel.point(u).T
    x, y = x1 * math.cos(axis1) - y1 * math.sin(axis1), x1 * math.sin(axis1) + y1 * math.cos(axis1)
    radius, seen = np.hypot(placement.centre_distance - x, y), np.arctan2(-y, placement.centre_distance - x)
    radius2, polar2 = np.hypot(x2, y2), np.arctan2(y2, x2)
    inside = (radius >= radius2[0]) & (radius <= radius2[-1])
    order = np.argsort(radius)
    first = (seen - np.interp(radius, radius2, polar2))[inside].min()
    second = (np.interp(radius2, radius[order], seen[order], left=np.inf, right=np.inf) - polar2).min()
    wheel_angle = -min(first, second) - placement.wheel_start
    return (angle / pair.ratio - wheel_angle) * pair.wheel.base_radius


@pytest.fixture(scope="session")
def dense_gap():
    """The function that finds where two teeth touch by brute force."""
    return first_by_brute_force
