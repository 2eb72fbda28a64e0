"""The band of contact over a tip edge against a direct solution of the contact of half planes."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gearfem.contact import EdgedLine, HertzLine, Line
from gearfem.contact.band import edge_band
from gearfem.contact.peak import largest_pressure
from gearfem.contact.scaled import EvenLaw, ScaledLaw, on_flanks
from gearfem.definition.setup import Material
from gearfem.foundation import InputError

STEEL = EdgedLine(pinion=Material(), wheel=Material())
MODULUS = STEEL.hertz.contact_modulus
ROUND_END = math.radians(65.0)


def log_moment(distance, power):
    """Return the integral of y^power ln|y| from 0, power 0 or 1."""
    length = np.abs(distance)
    log = np.log(np.where(length > 0.0, length, 1.0))
    return distance * (log - 1.0) if power == 0 else distance**2 * (log / 2.0 - 0.25)


def influence(x):
    """Return the surface displacements at the nodes under pressures that are linear between them, E* = 1."""
    at, left, right = x[:, None], x[:-1], x[1:]
    plain = log_moment(at - left, 0) - log_moment(at - right, 0)
    first = at * plain - log_moment(at - left, 1) + log_moment(at - right, 1)
    matrix = np.zeros((len(x), len(x)))
    matrix[:, 1:] += (first - left * plain) / (right - left)
    matrix[:, :-1] += (right * plain - first) / (right - left)
    return -2.0 / np.pi * matrix


def press(x, gap, force):
    """Return D and the nodal pressures of a contact with a gap under a line load, E* = 1: an active set.

    -2/pi int p ln|x - s| ds = D - gap where p > 0, no penetration elsewhere, int p = force.
    """
    matrix, weight = influence(x), np.zeros_like(x)
    weight[1:] += np.diff(x) / 2.0
    weight[:-1] += np.diff(x) / 2.0
    touching = np.ones(len(x), bool)
    touching[[0, -1]] = False
    for _ in range(200):
        inside = np.flatnonzero(touching)
        system = np.block([[matrix[np.ix_(inside, inside)], -np.ones((len(inside), 1))], [weight[None, inside], np.zeros((1, 1))]])
        solution = np.linalg.solve(system, np.append(-gap[inside], force))
        pressure = np.zeros_like(x)
        pressure[inside] = solution[:-1]
        apart = gap + matrix @ pressure - solution[-1]
        following = (touching & (pressure > 0.0)) | (~touching & (apart < -1e-13 * gap.max()))
        following[[0, -1]] = False
        if (following == touching).all():
            return solution[-1], pressure
        touching = following
    raise AssertionError("the active set did not settle")


def rounded(s, rho, end):
    """Return how far a true circle, and its tangent after the angle `end`, falls away behind the edge at s = 0."""
    stop = rho * math.sin(end)
    inner = rho - np.sqrt(rho**2 - np.clip(s, 0.0, stop) ** 2)
    return inner + np.maximum(s - stop, 0.0) * math.tan(end)


def true_gap(x, edge, radius, rho, end=ROUND_END):
    """Return the gap of a flank with a circular round; the round ends in a steep plane at `end`."""
    if edge >= 0.0:
        return x**2 / (2.0 * radius) + rounded(x - edge, rho, end)
    tilt = -edge / rho
    outer = rounded(np.maximum(x, 0.0), rho, end - tilt)
    return x**2 / (2.0 * radius) + outer + rounded(np.maximum(-x, 0.0), rho, tilt)


def parabolic_gap(x, edge, radius, rho):
    """Return the gap for small slopes, as a sum of curvatures; the rigid contact stays at x = 0."""
    past = min(edge, 0.0)
    return x**2 / (2.0 * radius) + (np.maximum(x - edge, 0.0) ** 2 + 2.0 * past * x - past**2) / (2.0 * rho)


def band_grid(middle, half_width, edge, count=600):
    """Return nodes dense at both ends of the band and at the edge; the band's ends need not be nodes."""
    ends = middle - 1.05 * half_width * np.cos(np.linspace(0.0, np.pi, count))
    near = edge + half_width * np.concatenate([-np.geomspace(0.5, 1e-4, 60), [0.0], np.geomspace(1e-4, 0.5, 60)])
    return np.unique(np.concatenate([ends, near[(near > ends[0]) & (near < ends[-1])]]))


def half_width_of(level, force):
    """Return a of the Hertz contact whose D is `level`: pi D/(2 F) = ln(2/a) + 1/2 with E* = 1."""
    return 2.0 * math.exp(0.5 - math.pi * level / (2.0 * force))


def solved(t, sharpness, force, gap):
    """Return band and its lengths' unit a, with grid, level D and pressures of the direct solution; rho = 1, E* = 1."""
    unit = math.sqrt(4.0 * force * sharpness / math.pi)
    band = [float(values[0]) for values in edge_band(np.array([t]), np.array([sharpness]))]
    x = band_grid(band[1] * unit, band[0] * unit, t * unit)
    level, pressure = press(x, gap(x, t * unit, sharpness, 1.0), force)
    return band, unit, x, level, pressure


def test_direct_solution_of_a_cylinder():
    """Second order: piecewise linear pressure. Nodes beyond the band make the order erratic, so they end there."""
    errors = []
    for count in (100, 200, 400):
        x = -np.cos(np.linspace(0.0, np.pi, count + 1))
        level, pressure = press(x, x**2 / 2.0, math.pi / 4.0)
        errors.append(abs(half_width_of(level, math.pi / 4.0) - 1.0))
        assert np.abs(pressure - 0.5 * np.sqrt(1.0 - x**2)).max() < 1e-2
    order = -np.polyfit(np.log([100, 200, 400]), np.log(errors), 1)[0]
    assert errors[-1] < 1e-4
    assert 1.8 < order < 3.2


def test_direct_solution_of_the_rounded_flat_punch():
    """Flat between -b and b, then circles R: 4 F R/(E* a^2) = pi - 2 phi - sin 2 phi, sin phi = b/a.

    M. Ciavarella, D. A. Hills, G. Monno, Proc. Inst. Mech. Eng. C 212 (1998) 319-328. The level follows from it, since
    dD/dF = 2/(pi E*) ln(2/a): the band of a convex punch grows with the load.
    """
    flat = 0.6
    wide = np.linspace(flat, 1.0, 4001)
    phi = np.arcsin(flat / wide)
    load = wide**2 / 4.0 * (math.pi - 2.0 * phi - np.sin(2.0 * phi))
    rise = np.sum(np.diff(load) * (np.log(2.0 / wide[1:]) + np.log(2.0 / wide[:-1])) / 2.0) * 2.0 / math.pi
    x = np.unique(np.concatenate([band_grid(0.0, 1.0, flat), -band_grid(0.0, 1.0, flat)]))
    level, pressure = press(x, np.maximum(np.abs(x) - flat, 0.0) ** 2 / 2.0, load[-1])
    touching = x[pressure > 0.0]
    spacing = np.diff(x).max()
    assert abs(touching[-1] - 1.0) < spacing
    assert abs(touching[0] + 1.0) < spacing
    # A flat punch under no load has D = 0. Grid and rule are good to 1e-5 of it.
    assert level == pytest.approx(rise, rel=1e-4, abs=0.0)


RNG = np.random.default_rng(20)
POINTS = [
    (float(t if t > 0.0 else -t / math.sqrt(1.0 + k)), float(k), float(f))
    for t, k, f in zip(RNG.uniform(-1.0, 1.0, 24), 10.0 ** RNG.uniform(0.0, 2.7, 24), 10.0 ** RNG.uniform(-8.0, -1.0, 24), strict=True)
]


@pytest.mark.parametrize(("t", "sharpness", "force"), [*POINTS, (0.0, 180.0, 0.02), (-0.02, 180.0, 0.02), (-0.03, 500.0, 1e-3)])
def test_closed_form_is_the_direct_solution(t, sharpness, force):
    """Half width of the equivalent Hertz contact, band and centre of pressure, small slopes; error of the grid 1e-5."""
    band, unit, x, level, pressure = solved(t, sharpness, force, parabolic_gap)
    width, middle, centre, radius, _ = band
    assert half_width_of(level, force) / unit == pytest.approx(math.sqrt(radius), rel=2e-5, abs=0.0)
    assert np.trapezoid(pressure * x, x) / force / unit == pytest.approx(centre, abs=1e-5)
    touching, spacing = x[pressure > 0.0] / unit, np.diff(x).max() / unit
    assert abs(touching[0] - (middle - width)) < 2.0 * spacing
    assert abs(touching[-1] - (middle + width)) < 2.0 * spacing


@pytest.mark.parametrize(("t", "sharpness", "force"), [*POINTS, (0.0, 180.0, 0.02), (-0.02, 180.0, 0.02)])
def test_largest_pressure_is_that_of_the_direct_solution(t, sharpness, force):
    """In steel, with lengths in units of the round: forces and pressures count in E*."""
    _, unit, _, _, pressure = solved(t, sharpness, force, parabolic_gap)
    line = Line(*map(np.array, (sharpness, 1.0, 1.0, t * unit, 1.0)))
    ours = float(largest_pressure(STEEL, force * MODULUS, line)) / MODULUS
    # The nodes of the direct solution miss the top, which is sharp beside a sharp edge, by as much as ours do.
    assert ours == pytest.approx(pressure.max(), rel=1e-3, abs=0.0)


@pytest.mark.parametrize("force", [1e-3, 0.02, 0.1])
@pytest.mark.parametrize("t", [-0.06, -0.03, 0.0, 0.1, 0.5])
def test_true_circle_in_place_of_the_parabola(t, force):
    """The error stated for ln(a_e): (a/(3.3 rho))^2 = 3 a^2/(32 rho^2) on the round, far less before the edge."""
    band, unit, _, level, _ = solved(t, 180.0, force, true_gap)
    error = math.log(math.sqrt(band[3]) * unit / half_width_of(level, force))
    on_round = 3.0 / 32.0 * unit**2 / 181.0
    # The next term of the circle is smaller by (a/rho)^2 < 0.13; the grid adds 1e-5.
    assert -1e-5 < error < (1.15 * on_round if t < 0.0 else 0.012 * on_round) + 1e-5


@pytest.mark.parametrize("t", [-0.074, -0.03, 0.0, 0.3])
def test_end_of_the_round_is_not_reached(t):
    """At four times the load of the coal combine a round that ends after 50 degrees gives the same contact."""
    levels = [solved(t, 180.0, 0.1, lambda *a, end=end: true_gap(*a, end=math.radians(end)))[3] for end in (50.0, 80.0)]
    assert levels[0] == levels[1]


def depth_bracket(x, pressure, force, depth, material):
    """Return the approach of a body to a depth below x = 0, from the pressure: Flamant's line loads in plane strain.

    u_z = F (1 - nu^2)/(pi E) [-ln r^2 + z^2/((1 - nu) r^2)], at the surface the common level instead; unit F = pi E/(1 - nu^2).
    """
    square = depth**2 + x**2
    kernel = -np.log(square) + depth**2 / ((1.0 - material.poissons_ratio) * square)
    return np.trapezoid(pressure * kernel, x) / force


@pytest.mark.parametrize("t", [-0.03, 0.0, 0.2, 0.6])
@pytest.mark.parametrize("ratio", [5.0, 10.0, 20.0])
def test_approach_to_a_depth(t, ratio):
    """Against the displacement below the true pressure: each bracket is short by 1.2 (mean x^2 - a_e^2/4)/d^2."""
    force = 0.02
    band, unit, x, level, pressure = solved(t, 180.0, force, parabolic_gap)
    depth = ratio * unit
    scale = MODULUS * 0.16e-3
    line = Line(*map(np.array, (180.0 * 0.16e-3, depth * 0.16e-3, depth * 0.16e-3, t * unit * 0.16e-3, 0.16e-3)))
    law = float(STEEL.approach(force * scale, line)) / 0.16e-3
    # E* = 1 holds for two equal bodies with (1 - nu^2)/E = 1/2 each.
    truth = level - 2.0 * force * 0.5 / math.pi * depth_bracket(x, pressure, force, depth, Material())
    spread = np.trapezoid(pressure * x**2, x) / force - band[3] * unit**2 / 4.0
    factor = (1.0 + 1.0 / (1.0 - Material().poissons_ratio)) / 2.0
    short = factor * spread / depth**2 * 2.0 * force / math.pi
    # Next term of the expansion in 1/d: at most (x/d)^2 of this one times 4; the grid adds 1e-5.
    assert truth - law == pytest.approx(short, rel=4.0 / ratio**2, abs=1e-5 * law)
    # Stated in the law: 0.3 % of the approach at d = 5 a, 0.1 % at 10 a.
    assert abs(truth - law) < (3e-3 if ratio == 5.0 else 1e-3) * law


@pytest.mark.parametrize("edge", [-2e-4, -4e-5, -1e-5, -1e-6, 0.0, 1e-6, 5e-5, 2e-4, 3e-4, 1e-3])
def test_compliance_is_the_slope_of_the_approach(edge):
    force = np.geomspace(1e2, 2e6, 300)
    line = Line(*map(np.array, (0.029, 3e-3, 2e-3, edge, 0.16e-3)))
    slope = (STEEL.approach(force * (1.0 + 1e-5), line) - STEEL.approach(force * (1.0 - 1e-5), line)) / (2e-5 * force)
    # Rounding 1e-16/1e-5, and 1e-10 of the third derivative.
    np.testing.assert_allclose(STEEL.compliance(force, line), slope, rtol=2e-9)


def test_compliance_is_that_of_a_flat_punch_as_wide_as_the_band():
    """Deep below the band, dD/dF = 2/(pi E*) ln(2/w), whatever the gap: the band only grows."""
    force, deep = 3.56e5, 1e3
    for edge in (-1e-5, 0.0, 5e-5, 2e-4):
        line = Line(*map(np.array, (0.029, deep, deep, edge, 0.16e-3)))
        unit = float(STEEL.hertz.half_width(force, 0.029))
        band = edge_band(np.array([edge / unit]), np.array([0.029 / 0.16e-3]))
        nu = Material().poissons_ratio
        bracket = 2.0 * math.log(2.0 * deep / (float(band.half_width[0]) * unit)) - 1.0 / (1.0 - nu)
        assert float(STEEL.compliance(force, line)) == pytest.approx(bracket / (math.pi * MODULUS), rel=1e-12, abs=0.0)


def test_hertz_law_is_shared():
    assert STEEL.hertz.contact_modulus == HertzLine(pinion=Material(), wheel=Material()).contact_modulus


def test_contact_evened_out_lies_between_edges_and_flanks():
    """Without any edge at 1, in proportion between, and on the flank itself as it was; one on another leaves what both leave."""
    law = EdgedLine(pinion=Material(), wheel=Material())
    line = Line(*map(np.array, (0.029, 3e-3, 3e-3, [1e-3, 1e-4, 0.0, -1e-5, -1e-4], 0.16e-3)))
    edged, flank = law.respond(3e5, line), law.hertz.respond(3e5, 0.029, 3e-3, 3e-3)
    for evenness in (0.0, 0.3, 1.0):
        even = EvenLaw(law=law, evenness=evenness).respond(3e5, line)
        for got, own, far in zip(even, edged, flank, strict=True):
            np.testing.assert_allclose(got, own + evenness * (far - own), rtol=1e-14)
            assert got[0] == pytest.approx(far, rel=1e-12)
    twice = EvenLaw(law=EvenLaw(law=law, evenness=0.3), evenness=0.5).respond(3e5, line)
    np.testing.assert_allclose(twice, EvenLaw(law=law, evenness=0.65).respond(3e5, line), rtol=1e-13)
    with pytest.raises(InputError, match=r"from -0\.5 to 1\.5"):
        EvenLaw(law=law, evenness=1.6)


def test_far_from_edges_the_simplest_law_is_the_same():
    force, law = np.geomspace(1.0, 3e5, 40), EvenLaw(law=ScaledLaw(law=EvenLaw(law=STEEL, evenness=0.4), scale=1.7), evenness=0.8)
    plain, line = on_flanks(law), Line(*map(np.array, (0.029, 3e-3, 2e-3, 5e-3, 0.16e-3)))
    assert (plain.law, plain.scale) == (STEEL, 1.7)
    np.testing.assert_allclose(plain.respond(force, line), law.respond(force, line), rtol=1e-14)
    # Beside one contact over an edge all are computed as such.
    some = line._replace(edge=np.append(np.full(39, 5e-3), 0.0))
    np.testing.assert_array_equal(STEEL.respond(force, line)[0][:-1], STEEL.respond(force, some)[0][:-1])
