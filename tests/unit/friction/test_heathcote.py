"""Heathcote slip: closed form in pure rolling, bounds, and the whole motion solved again with curved contacts."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize
from tests.helpers import small_screw, solved

from rollbench.lowfi.friction.screw.groove import ON_SCREW, contact_axes
from rollbench.lowfi.friction.whole import losses
from rollbench.lowfi.friction.whole.state import friction_state
from rollbench.meshes.helix import nominal_groove_radii
from rollbench.meshes.parts import Friction, Motion

MU, TURN = Friction(0.1, 0.1, feedback=False), Motion(10.0)


def test_pressure_sums_up_to_one_with_its_second_moment():
    x, z, mass = losses.hertz_pressure_quadrature()
    assert mass.sum() == pytest.approx(1.0, rel=1e-12)
    assert mass @ x**2 == pytest.approx(0.2, rel=1e-3)
    assert mass @ z**2 == pytest.approx(0.2, rel=1e-3)


def rolling(slender, a=2e-3, curve=7.0):
    """One contact of a body that may slide along the path and must roll."""
    x, z, _ = losses.hertz_pressure_quadrature()
    rows, added = np.zeros((1, 4, x.size, 2, 4)), np.zeros((1, 4, x.size, 2))
    rows[..., 0, 0] = rows[..., 1, 1] = 1.0
    rows[..., 2] = np.stack([slender * a * z, -a * x], axis=-1)
    added[..., 1] = curve * (a * x) ** 2
    return rows, added


@pytest.mark.parametrize("slender", [1.0, 0.3, 0.05])
def test_pure_rolling_has_two_lines_without_slip(slender):
    """Half of the load lies within t0 of the middle, 3 t0 - t0^3 = 1; the loss is 1/5 - t0^3 + 3 t0^5 / 5 of a^2 curve."""
    t0 = float(min(r.real for r in np.roots([1.0, 0.0, -3.0, 1.0]) if r.real > 0.0))
    exact = 0.2 - t0**3 + 0.6 * t0**5
    strength = np.array([[3.0, 0.0, 0.0, 0.0]])
    rows, added = rolling(slender)
    found = losses.least_dissipated_power(rows, added, strength, np.zeros((1, 4)), 7.0 * 4e-6)[0]
    assert found == pytest.approx(3.0 * 7.0 * 4e-6 * exact, rel=0.02)


def curved_power(scene, at, i):
    """Power lost by ball i with curved contacts, a function of its motion q, by quadrature."""
    path, radii = losses.ball_kinematics(scene, TURN, float(at.ball_radius[i])), nominal_groove_radii(scene)
    maps, drives = path.contact_kinematics(at.normals[i])
    x, z, mass = losses.hertz_pressure_quadrature(16, 24)
    along = [contact_axes(normal)[0] for normal in at.normals[i]]

    def power(q):
        motion = maps @ q + drives
        total = 0.0
        for s in np.flatnonzero(at.force[i] > 0.0):
            body = path.screw_speed if ON_SCREW[s] else path.nut_speed
            omega = ((q[0] - body) * path.screw_axis_direction + q[1:]) @ along[s]
            curve = omega * 0.25 * (1.0 / at.ball_radius[i] + 1.0 / radii[s])
            a, b = at.a[i, s], at.b[i, s]
            vx = motion[s, 0] + motion[s, 2] * b * z
            vz = motion[s, 1] - motion[s, 2] * a * x + curve * (a * x) ** 2
            total += 0.1 * at.force[i, s] * float(np.hypot(vx, vz) @ mass)
        return total

    return power


@pytest.mark.parametrize(("beta", "conformity", "oversize"), [(15, 0.52, 0.0), (45, 0.52, 0.0), (45, 0.58, 8e-6)])
def test_estimate_is_that_of_the_motion_solved_again(beta, conformity, oversize):
    scene = small_screw(2, 0.5, beta=np.radians(beta), force=(0.0, 0.0, 500.0), oversize=oversize, screw="rigid")
    radius = conformity * 2.0 * scene.balls.radius
    scene = replace(scene, screw=replace(scene.screw, groove_radius=radius), nut=replace(scene.nut, groove_radius=radius))
    found = friction_state(scene, solved(scene), MU, TURN)
    at = found.contacts
    estimate = losses.heathcote_loss_increase(scene, at, found.ball_friction, MU, TURN)
    exact = 0.0
    for i in range(2):
        q0 = np.array([found.ball_friction.orbital_speed[i], *found.ball_friction.rotation[i]])
        scale = np.array([1e-4, 1e-3, 1e-3, 1e-3]) * np.abs(q0).max()
        power = curved_power(scene, at, i)
        best = minimize(
            lambda y, power=power, q0=q0, scale=scale: 1e3 * power(q0 + scale * y),
            np.zeros(4),
            method="Nelder-Mead",
            options={"xatol": 1e-5, "fatol": 1e-9, "maxiter": 4000, "adaptive": True},
        )
        exact += 1e-3 * best.fun
    exact = exact / found.ball_friction.total_power_lost - 1.0
    assert estimate == pytest.approx(exact, abs=0.003)
