"""The elastic model does not depend on its tolerance, its tables' angle step, or on the side of a sample at a reversal."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gearfem.dynamics import elastic_motion, uniform_transport
from gearfem.dynamics.cycle import integrate_cycle
from gearfem.dynamics.flank_force import flank_force
from gearfem.dynamics.relative import RelativeMotion

RADII = (60.14e-3, 191.7e-3)
TEETH = 16
PERIOD = 2.0 * math.pi / TEETH


def varying(angle):
    return 1.4e9 * (1.0 + 0.15 * np.cos(TEETH * angle))


def smooth_arms(angle):
    """Return friction arms that jump at 0.3 of the period only, by 2 h on either gear, periodic and curved."""
    turn = (angle / PERIOD - 0.3) % 1.0
    wave = 1.0 + 0.2 * np.sin(TEETH * angle)
    return (0.06 * (0.5 - turn) + 0.01) * wave, (0.2 * (0.5 - turn) - 0.02) * wave


def test_error_falls_with_the_tolerance(mesh_factory, coal_drive):
    """The state after one cycle against an explicit method of order 8 at 1e-13; each 100th costs two digits or nearly."""
    mesh = mesh_factory(TEETH, RADII, varying)
    system = RelativeMotion(mesh, coal_drive, uniform_transport(mesh, coal_drive))
    start = np.array([1.4, 0.3, 0.0, 0.0])
    change = solve_ivp(
        lambda time, y: system.change(time, y, 1.0, 1, 0.1), (0.0, system.length), start, method="DOP853", rtol=1e-13, atol=1e-13
    )
    tolerances = np.array([1e-5, 1e-7, 1e-9, 1e-11])
    errors = [np.abs(integrate_cycle(system, start, 1.0, t).end - change.y[:, -1]).max() for t in tolerances]
    print("error after one cycle:", dict(zip(tolerances.tolist(), errors, strict=True)))
    # A method of order p keeps error ~ tolerance^(p/(p+1)); p runs up to 5 and lower after the start.
    slope = np.polyfit(np.log10(tolerances), np.log10(errors), 1)[0]
    assert slope > 0.75
    assert errors[-1] < 1e-8


def test_kw_is_settled_at_the_default_tolerance(mesh_factory, coal_drive):
    mesh = mesh_factory(TEETH, RADII, varying)
    transport = uniform_transport(mesh, coal_drive)
    loose, tight = (elastic_motion(mesh, coal_drive, transport, tolerance=t).dynamic_factor for t in (1e-8, 1e-11))
    # Closed to 100 times 1e-8 of the mean deflection.
    assert np.abs(loose - tight).max() < 2e-6


def exact(angle, depth):
    return np.array([varying(angle) * depth, *smooth_arms(angle)])


@pytest.mark.parametrize("offset", [0.0, 0.5])
def test_tables_converge_with_the_angle_step_beside_a_jump(mesh_factory, offset):
    """Force and friction arms between the samples: fourth and third order, the jump at its place, sample on it or not."""
    angle = np.linspace(0.0, PERIOD, 1001)[:-1] + 1.234e-5
    depth = np.full_like(angle, 13.3e-6)
    truth = exact(angle, depth)
    errors = []
    for count in (40, 80, 160, 320):
        mesh = mesh_factory(
            TEETH, RADII, varying, angles=count, offset=offset, friction=smooth_arms, sliding_reversals=np.array([0.3 * PERIOD])
        )
        values, _ = flank_force(mesh)(angle, depth, angle, True)
        errors.append([np.abs(values[:, 0] / truth[0] - 1.0).max(), *np.abs(values[:, 3:].T - truth[1:]).max(axis=1)])
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    print("orders of force and both friction arms:", orders.round(2).tolist())
    assert orders[1:, 0].min() > 3.7
    assert orders[1:, 1:].min() > 2.6


def test_moved_tables_converge_with_the_columns(mesh_factory):
    """Where the unloaded error varies, rows move by parts of a column: second order in its width for a curved law."""
    angle = np.linspace(0.0, PERIOD, 301)
    depth = np.full_like(angle, 17.7e-6)
    errors = []
    for count in (13, 25, 49, 97):
        columns = np.linspace(0.0, 60e-6, count)
        mesh = mesh_factory(TEETH, RADII, varying, columns=columns, unloaded=lambda phi: 4e-6 * (1.0 + np.sin(TEETH * phi)))
        own = np.maximum(columns - mesh.unloaded_error[:, None], 0.0)
        force = varying(mesh.pinion_angle)[:, None] * own * (1.0 + own / 60e-6)
        none = np.zeros_like(force)
        curved = dataclasses.replace(mesh, normal_force=force, pinion_moment=RADII[0] * force, wheel_moment=RADII[1] * force)
        curved = dataclasses.replace(curved, pinion_friction=none, wheel_friction=none)
        values, _ = flank_force(curved)(angle, depth, angle, False)
        errors.append(np.abs(values[:, 0] / (varying(angle) * depth * (1.0 + depth / 60e-6)) - 1.0).max())
        assert np.allclose(values[:, 1], RADII[0], rtol=1e-12)
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    print("orders in the column width:", orders.round(2).tolist())
    assert orders.mean() > 1.8
