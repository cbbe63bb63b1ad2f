"""Friction of one elliptical contact against quadrature, its limits, derivatives, symmetries, and the laws."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad_vec
from scipy.special import ellipe
from tests.friction_oracles import dissipated_power, motion_of_rotation_about_point, pure_spin_moment

from rollbench.lowfi.friction.contact import laws

NODES, WEIGHTS = np.polynomial.legendre.leggauss(64)
RATIOS = (1.0, 1.0 - 1e-9, 0.97, 0.6, 0.17, 1.0 / 30.0)
#: Centres of rotation in units of (a, b), on the edge at both ends and between, outside from just beyond it.
INSIDE = (0.0, 0.0), (0.3, 0.0), (0.0, -0.4), (0.5, 0.6), (0.999, 0.0)
EDGE = (1.0, 0.0), (0.0, 1.0), (0.6, -0.8)
OUTSIDE = (1.001, 0.0), (-0.7, 0.72), (1.3, 0.4), (0.0, 2.5), (-2.0, 1.0), (0.2, 6.0)
#: Centres of rotation in units of a, for a product rule: far away, and anywhere if the law is regularised.
FAR = (3.0, 0.0), (0.0, 4.0), (-8.0, 5.0), (300.0, -200.0), (2e3, 0.0)
ANYWHERE = (0.0, 0.0), (0.5, 0.3), (1.0, 0.0), (1.4, -0.3), (6.0, 3.0)
UNIT, SLENDER = laws.contacts_from_values(1.0, 0.2, 1.0, 1.0), laws.contacts_from_values(1.0, 0.2, 1.0, 0.1)


def along_ray(b, c, d, t):
    """Radial integrals from (c, d) in direction (cos t, b sin t), times b: exact but for Gauss error (a = 1)."""
    q = np.array([c, d / b])
    e = np.array([np.cos(t), np.sin(t)])
    middle, disc = -q @ e, (q @ e) ** 2 - q @ q + 1.0
    if disc <= 0.0:
        return np.zeros(4)
    half = np.sqrt(disc)
    start = np.arcsin(np.clip((max(middle - half, 0.0) - middle) / half, -1.0, 1.0))
    u = start + 0.5 * (0.5 * np.pi - start) * (NODES + 1.0)
    w = 0.5 * (0.5 * np.pi - start) * WEIGHTS * (half * np.cos(u)) ** 2
    r = middle + half * np.sin(u)
    length = np.hypot(e[0], b * e[1])  # metres per unit of r
    x, y = c + r * e[0], d + r * b * e[1]
    moment = (e[0] * x + b * e[1] * y) / length
    pull = -(w @ r) / length
    return b * np.array([w @ (r * r * length), pull * e[0], pull * b * e[1], w @ (r * moment)])


def reference(b, c, d):
    """psi, psi_c, psi_d and the moment integral of unit force by adaptive quadrature about the point (a = 1)."""
    q = np.array([c, d / b])
    size = np.hypot(*q)
    at = np.arctan2(-q[1], -q[0])
    if size < 1.0 - 1e-12:
        f, low, high = (lambda t: along_ray(b, c, d, t)), at - np.pi, at + np.pi
    else:
        wide = np.arcsin(min(1.0, 1.0 / size))
        f, low, high = ((lambda s: along_ray(b, c, d, at + wide * np.sin(s)) * wide * np.cos(s)), -0.5 * np.pi, 0.5 * np.pi)
    value, _ = quad_vec(f, low, high, epsabs=1e-15, epsrel=1e-13, limit=4000)
    return 1.5 / (np.pi * b) * value


def smooth_reference(b, c, d, h=0.0, n=400):
    """The same by a product rule about the ellipse's centre: for points far away, or h > 0 (also gives psi_h)."""
    t = 0.25 * np.pi * (NODES + 1.0)
    phi = 2.0 * np.pi * np.arange(n) / n
    r = np.sin(t)[:, None]
    w = (0.25 * np.pi * WEIGHTS * np.cos(t) ** 2 * np.sin(t))[:, None] * 2.0 * np.pi / n * 1.5 / np.pi
    x, y = r * np.cos(phi), b * r * np.sin(phi)
    size = np.sqrt((x - c) ** 2 + (y - d) ** 2 + h * h)
    parts = (size, (c - x) / size, (d - y) / size, (x * (x - c) + y * (y - d)) / size, h / size)
    return np.array([np.sum(w * p) for p in parts])


def ours(b, c, d, speed=0.0):
    """(psi, psi_c, psi_d, moment integral, excess) from the friction of a unit contact turning with 1 rad/s."""
    contact, motion = laws.contacts_from_values(1.0, b, 1.0, 1.0), motion_of_rotation_about_point(1.0, c, d)
    e = dissipated_power(contact, motion, speed)
    return np.array([e.power[0], e.gradient[0, 1], -e.gradient[0, 0], e.gradient[0, 2], e.excess_over_loss[0]])


@pytest.mark.parametrize("b", RATIOS)
@pytest.mark.parametrize(("c", "d", "h"), [*((*at, 0.0) for at in FAR), *((*at, 0.35) for at in ANYWHERE)])
def test_far_away_or_regularised_against_a_product_rule(b, c, d, h):
    got, exact = ours(b, c, d, h), smooth_reference(b, c, d, h)
    assert got[:3] == pytest.approx(exact[:3], rel=1e-11 if h else 1e-12, abs=1e-12 if h else 1e-13)
    assert got[3] == pytest.approx(exact[3], rel=1e-9, abs=1e-14)
    assert h == 0.0 or got[4] == pytest.approx(h * exact[4], rel=1e-10)


@pytest.mark.parametrize("b", RATIOS)
@pytest.mark.parametrize(("c", "d"), [*INSIDE, *EDGE, *OUTSIDE])
def test_against_adaptive_quadrature(b, c, d):
    got, exact = ours(b, c, d * b), reference(b, c, d * b)
    force = np.hypot(*exact[1:3])
    assert got[0] == pytest.approx(exact[0], rel=1e-10)
    assert got[1:3] == pytest.approx(exact[1:3], rel=1e-10, abs=1e-10 * force + 1e-15)
    assert got[3] == pytest.approx(exact[3], rel=1e-9)


@pytest.mark.parametrize("speed", [0.0, 0.02])
@pytest.mark.parametrize("motion", [(0.1, 0.2, 1.0), (0.0, 0.5, -0.3), (-2.0, 1.0, 0.7), (0.3, 0.0, 1e-3)])
def test_derivatives_against_finite_differences(motion, speed):
    at = laws.contacts_from_values(1.3, 0.4, 7.0, 0.2)
    m = np.array([motion])
    e = dissipated_power(at, m, speed)
    for j in range(3):
        step = np.zeros((1, 3))
        step[0, j] = 1e-5
        up, down = dissipated_power(at, m + step, speed), dissipated_power(at, m - step, speed)
        assert (up.power - down.power) / 2e-5 == pytest.approx(e.gradient[:, j], rel=1e-7, abs=1e-8)
        assert (up.gradient - down.gradient) / 2e-5 == pytest.approx(e.hessian[:, j], rel=1e-6, abs=1e-7)


def test_limits_of_pure_spin_and_pure_sliding():
    """Lin 3.32 and 3.33; M -> mu F b^2 / (5 c) for a centre far along x, the second moment of the pressure."""
    at = laws.contacts_from_values(2e-3, [2e-3, 1e-3, 1e-4], 100.0, 0.1)
    spin = laws.friction_forces(at, motion_of_rotation_about_point(np.full(3, -3.0), 0.0, 0.0))
    assert spin.force == pytest.approx(0.0, abs=1e-15)
    assert spin.moment == pytest.approx(pure_spin_moment(at), rel=1e-13)
    assert pure_spin_moment(at)[1] == pytest.approx(0.375 * 10.0 * 2e-3 * ellipe(0.75), rel=1e-14)
    turning = {c: motion_of_rotation_about_point(np.ones(3), c, 0.0) for c in (1e3, -1e9)}
    for c, motion in (turning | {np.inf: np.tile([0.0, 2.0, 0.0], (3, 1))}).items():
        slide = laws.friction_forces(at, motion)
        assert slide.force[:, 1] == pytest.approx(-np.sign(c) * at.friction_bound, rel=1e-11)
        assert np.all(np.abs(slide.moment) <= 10.0 * at.b**2 / 5.0 / min(abs(c), 1e37) * (1.0 + 1e-9))
    for c in (1e4, 1e8, 1e15, 1e30):  # the moment keeps its digits
        far_away = laws.friction_forces(UNIT, motion_of_rotation_about_point(1.0, c, 0.0))
        assert -far_away.moment[0] * c == pytest.approx(0.2**2 / 5.0, rel=2e-8)


@pytest.mark.parametrize("b", [0.9, 0.3, 0.12])
def test_force_inside_is_a_cubic(b):
    """Source's linear law: exact slope, exact cubic term, and the error of any slope over any reach."""
    t = np.array([0.1, 0.4, 0.8, 1.0])
    at = laws.contacts_from_values(2.0, np.full(4, 2.0 * b), 1.0, 1.0)
    motion = motion_of_rotation_about_point(np.ones(4), 2.0 * t, 0.0)
    linear, cubic = laws.linear_friction_force_factor(b), laws.cubic_friction_force_factor(b)
    assert -laws.friction_forces(at, motion).force[:, 1] == pytest.approx(linear * t - cubic * t**3, rel=1e-12)
    g = linear - cubic * np.linspace(1e-3, 0.5, 200) ** 2
    assert laws.error_of_linear_friction_force(b, 1.38) == pytest.approx(np.max(np.abs(1.38 / g - 1.0)), rel=1e-5)


def test_sigmoid_as_printed_and_its_faults():
    at, m = SLENDER, np.array([[0.0, 0.3, 0.02]])
    law, e = laws.SigmoidLaw(100.0, 10.0), np.exp(100.0 * 0.02 / 10.0)
    factor = 2.0 * e / (e + 1.0) - 1.0  # Lin 3.20
    assert law(at, m).force == pytest.approx(factor * laws.friction_forces(at, m).force, rel=1e-13)
    assert np.all(law(at, m * [0.0, 1.0, 0.0]).force == 0.0), "sliding without spin is frictionless"
    assert law(at, -m).force == pytest.approx(-law(at, m).force, rel=1e-13)
    assert np.all(np.isfinite(laws.SigmoidLaw(1e6, 1e-3)(at, m).force))


def test_interpolated_maps():
    """Linear between the multiples of the step, equal at them; exact again as the step falls."""
    at, exact = SLENDER, laws.friction_forces
    coarse = laws.SigmoidLaw(1e9, 1.0, map_spacing=0.08)
    on = motion_of_rotation_about_point(2.0, 0.16, 0.0)
    assert coarse(at, on).loss == pytest.approx(exact(at, on).loss, rel=1e-12)
    off = motion_of_rotation_about_point(-2.0, 0.2, 0.0)
    ends = [exact(at, motion_of_rotation_about_point(-2.0, c, 0.0)) for c in (0.16, 0.24)]
    got = coarse(at, off)
    for name in ("loss", "force", "moment"):
        assert getattr(got, name) == pytest.approx(0.5 * sum(getattr(end, name) for end in ends), rel=1e-12)
    assert abs(got.loss[0] / exact(at, off).loss[0] - 1.0) > 1e-4
    assert replace(coarse, map_spacing=1e-4)(at, off).loss == pytest.approx(exact(at, off).loss, rel=1e-7)
    assert np.all(coarse(at, np.array([[0.0, 1.0, 0.0]])).loss == 0.0)
    with pytest.raises(ValueError, match="major axis"):
        coarse(at, np.array([[0.1, 1.0, 1.0]]))
