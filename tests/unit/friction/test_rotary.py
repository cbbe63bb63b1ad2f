"""Ball of a rotary bearing: kinematics, loads, motion of least dissipation, energy balance, symmetry, uniqueness."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize
from tests.friction_oracles import dissipated_power

from rollbench.compare.cases.lin.evidence import source_cases
from rollbench.lowfi.friction import bearing as friction_bearing
from rollbench.lowfi.friction.contact import equilibrium
from rollbench.lowfi.friction.contact.laws import contacts_from_values
from rollbench.lowfi.friction.screw.motion import contact_ellipses_of_screw

BEARING = source_cases.rotary_ball_scene("I").bearing
DIAGONAL = np.stack([friction_bearing.AXIAL, friction_bearing.RADIAL], axis=1) * np.sqrt(0.5)
ANGLES = np.radians([43.0, 46.0, 47.5, 44.2])


def problem_of(forces, bearing=BEARING, angles=ANGLES, free_z=False):
    """Problem of motion with given contact forces (4,), axes of the right Hertz constants."""
    h, f = bearing.contact_hertz_constants, np.asarray(forces, dtype=float)
    cube = np.cbrt(np.maximum(f, 1e-6))
    (maps, drives), n = friction_bearing.contact_kinematics(bearing, angles), 4 if free_z else 3
    return equilibrium.BodyMotionProblem(
        contacts_from_values(h.C_a * cube, h.C_b * cube, f, bearing.mu), maps[..., :n], drives, np.zeros(n)
    )


TWO, THREE = (140.0, 0.0, 140.0, 0.0), (150.0, 20.0, 160.0, 0.0)
FOUR, VERGE = (188.0, 47.0, 189.0, 46.0), (144.8, 3.36, 144.8, 3.36)


@pytest.mark.parametrize(("clearance", "u_y", "start"), [(0.0, 6e-6, (9.0, 4.0, 3.0)), (10e-6, 40e-6, (30.0, 15.0, 20.0))])
def test_loads_balance_follow_hertz_and_are_those_of_least_energy(clearance, u_y, start):
    """Distance of the ball's centre from each groove centre, less r_G - r_B and the play, is the approach C F^(2/3); and
    a search over ring and ball that knows only the energy, written for a ring of its own, finds the same places."""
    b = replace(BEARING, clearance=clearance)
    load = friction_bearing.contact_loads_of_ball(b, 100.0, u_y)
    assert load.converged
    n = np.stack([friction_bearing.AXIAL * np.sin(load.angle), friction_bearing.RADIAL * np.cos(load.angle)], axis=1)
    assert load.force @ n == pytest.approx(0.0, abs=1e-9)
    assert -(load.force @ (n[:, 0] * friction_bearing.INNER)) == pytest.approx(100.0, rel=1e-10)
    C, reach, scale = b.contact_hertz_constants.C, b.groove_radius - b.ball_radius, 1e-6

    def approach(ring, ball):
        moved = ball - np.where(friction_bearing.INNER[:, None], [ring, u_y], 0.0)
        return np.maximum(np.linalg.norm(reach * DIAGONAL + moved, axis=1) - reach - clearance, 0.0)

    def energy(x):
        elastic = np.sum(0.4 * C**-1.5 * approach(scale * x[0], scale * x[1:]) ** 2.5)
        return (elastic - 100.0 * scale * x[0]) / (100.0 * scale)

    found = np.append(load.inner_body_displacements, load.ball_displacements) / scale
    assert approach(scale * found[0], scale * found[1:]) == pytest.approx(C * load.force ** (2.0 / 3.0), rel=1e-7)
    best = minimize(energy, np.array(start), method="BFGS", options={"gtol": 1e-9})
    assert energy(found) <= best.fun + 1e-12 * abs(best.fun)
    assert found == pytest.approx(best.x, abs=1e-3)


@pytest.mark.parametrize("forces", [TWO, THREE, FOUR, VERGE])
def test_least_dissipation_is_least(forces):
    """No other motion dissipates less: random ones at every scale, and a simplex search from a distance."""
    p = problem_of(forces, free_z=True)
    m = equilibrium.least_dissipation(p)
    assert m.status == "exact"
    loss = m.loss

    def total(q):
        return float(np.sum(dissipated_power(p.contacts, p.contact_motions_at(q)).power))

    assert total(m.unknown_velocities) == pytest.approx(loss, rel=1e-9)
    rng = np.random.default_rng(6)
    for scale in (1e-6, 1e-3, 1e-1, 10.0, 300.0):
        for _ in range(40):
            assert total(m.unknown_velocities + scale * rng.normal(size=4) * [0.1, 1.0, 1.0, 1.0]) >= loss * (1.0 - 1e-12)
    start = m.unknown_velocities + np.array([0.05, 3.0, -3.0, 1.0])
    options = {"maxiter": 4000, "maxfev": 4000, "xatol": 1e-9, "fatol": 1e-13}
    found = minimize(total, start, method="Nelder-Mead", options=options)
    assert found.fun >= loss * (1.0 - 1e-12)
    assert found.fun == pytest.approx(loss, rel=1e-2)
    about_path, about_axis = m.unknown_velocities[[3, 1]]
    assert abs(about_path) < 1e-6 * abs(about_axis), "the ball does not turn about its path: Lin's omega_z = 0"


@pytest.mark.parametrize("unknowns", [3, 4])
def test_energy_balance_over_random_scenes(unknowns):
    """Torque times speed equals the loss to 1e-8, whatever the geometry, load, friction, and with rest or slip."""
    rng, balls = np.random.default_rng(unknowns), []
    for _ in range(100):
        b = replace(
            BEARING,
            contact_angle=np.radians(rng.uniform(20, 70)),
            mu=10.0 ** rng.uniform(-3, -0.3),
            screw_speed=10.0 ** rng.uniform(-3, 3) * rng.choice([-1.0, 1.0]),
            clearance=rng.choice([0.0, 1e-6, -2e-6, 1e-5]),
            groove_radius=12.5e-3 * rng.uniform(0.505, 0.6),
        )
        load_on, u_y = 10.0 ** rng.uniform(-3, 5), rng.uniform(-5e-6, 1e-5)
        load = friction_bearing.contact_loads_of_ball(b, load_on, u_y)
        assert load.converged
        assert load.largest_unbalanced_force <= 1e-9 * (np.sum(load.force) + abs(load_on))
        maps, drives = friction_bearing.contact_kinematics(b, load.angle)
        contacts = contact_ellipses_of_screw(b, load.force)
        problem = equilibrium.BodyMotionProblem(contacts, maps[..., :unknowns], drives, np.zeros(unknowns))
        balls.append((b, load, problem))
    motions = equilibrium.least_dissipations([problem for *_, problem in balls])
    for (b, load, _), m in zip(balls, motions, strict=True):
        assert m.status == "exact"
        assert friction_bearing.inner_ring_torque(b, load, m) * b.screw_speed == pytest.approx(m.loss, rel=1e-8)
        assert np.all(m.friction.loss >= 0.0)
    assert {int(np.sum(m.sticking_contacts)) for m in motions} >= {0, 1}


def test_a_pushed_body_rests_below_the_limit_and_slides_above():
    """One contact pushed along z: mu F holds; beyond it no motion is quasi-static, and the result says so."""
    maps = np.eye(3)[None]
    base = equilibrium.BodyMotionProblem(contacts_from_values(1e-3, 3e-4, 100.0, 0.1), maps, np.zeros((1, 3)), np.zeros(3))
    held = equilibrium.least_dissipation(replace(base, other_forces=np.array([0.0, 6.0, 1e-3])))
    assert held.status == "exact"
    assert held.sticking_contacts[0]
    assert held.friction.force[0, 1] == pytest.approx(-6.0, rel=1e-9)
    assert held.friction.moment[0] == pytest.approx(-1e-3, rel=1e-9)
    assert equilibrium.least_dissipation(replace(base, other_forces=np.array([0.0, 12.0, 0.0]))).status == "failed"


def rotation(angle):
    """Rotation matrix about x."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])


def test_maps_are_rigid_body_kinematics():
    """Lin 3.4-3.9 in the fixed frame at an azimuth, differentiated in time by finite differences of positions."""
    b, q, phi, eps = BEARING, np.array([27.4, -136.0, 108.0, 5.0]), 0.7, 1e-7
    maps, drives = friction_bearing.contact_kinematics(b, ANGLES)
    centre = np.array([0.0, b.pitch_radius, 0.0])
    for i in range(4):
        n = np.array([friction_bearing.AXIAL[i] * np.sin(ANGLES[i]), friction_bearing.RADIAL[i] * np.cos(ANGLES[i]), 0.0])
        y = -n
        x = np.cross(y, [0.0, 0.0, 1.0])
        seen = drives[i] + maps[i] @ q
        for px, pz in ((0.0, 0.0), (1e-4, 0.0), (0.0, 5e-5), (-1e-4, 2e-5)):
            local = b.ball_radius * n + px * x + np.array([0.0, 0.0, pz])

            def on_ball(t, local=local):
                return rotation(phi + q[0] * t) @ (centre + local + np.cross(q[1:], local) * t)

            def on_ring(t, local=local, i=i):
                return rotation(phi + b.screw_speed * t * friction_bearing.INNER[i]) @ (centre + local)

            rate = (on_ball(eps) - on_ball(-eps) - on_ring(eps) + on_ring(-eps)) / (2.0 * eps)
            back = rotation(-phi) @ rate
            assert back @ x == pytest.approx(seen[0] + seen[2] * pz, abs=2e-7)
            assert back[2] == pytest.approx(seen[1] - seen[2] * px, abs=2e-7)
