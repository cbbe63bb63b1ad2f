"""Motion and loads of balls in a ball screw: kinematics, limits, symmetry, energy, independent checks."""

from dataclasses import replace

import numpy as np
import pytest
from tests.friction_oracles import ball_cell, coupled_ball
from tests.helpers import SCREW_STATES as STATES

from rollbench.compare.cases.lin.evidence import source_cases
from rollbench.lowfi.friction.bearing import solve_ball_of_bearing
from rollbench.lowfi.friction.linear.bearing import LinearBearing
from rollbench.lowfi.friction.linear.chain import pair_angles_and_loads
from rollbench.lowfi.friction.linear.chain import solve_pair_of_linear_balls as solve_linear_pair
from rollbench.lowfi.friction.screw import motion
from rollbench.lowfi.friction.screw.chain import screw_ball_chain, solve_motion_of_chain
from rollbench.lowfi.friction.screw.groove import ON_SCREW, ScrewGroove, section_axes

SCREW = source_cases.screw_groove()
TWO = np.radians(2.0)
FLIP = [1, 0, 3, 2]  # SL <-> SR, NL <-> NR


def rotation(vector):
    """Rotation matrix of a rotation vector."""
    angle = np.linalg.norm(vector)
    if angle == 0.0:
        return np.eye(3)
    k = vector / angle
    cross = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


def helical(screw, point, angle):
    """A point of a body after its helical motion by ``angle``."""
    return rotation(np.array([0.0, 0.0, angle])) @ point + np.array([0.0, 0.0, screw.advance_per_radian * angle])


def material_velocity(screw, q, offset, azimuth, h=1e-6):
    """Velocity of a material point of the ball at ``offset`` (x3, y3, z3) from its centre, by central differences."""
    places = []
    for t in (-h, h):
        turn = section_axes(screw, azimuth + q[0] * t).T @ rotation(q[1:] * t)
        centre = helical(screw, section_axes(screw, azimuth)[0] * screw.pitch_radius, q[0] * t)
        places.append(centre + turn @ offset)
    return (places[1] - places[0]) / (2.0 * h)


def test_maps_against_finite_differences_of_the_rigid_motions() -> None:
    """Sliding and spin from positions of material points of ball, screw and nut (3.57-3.68, F.4-F.6)."""
    screw = replace(SCREW, nut_speed=5.0, screw_speed=-1.5)
    angle, q = np.array([0.6, 0.8, 0.9, 0.7]), np.array([2.0, -3.0, 0.7, 8.0])
    normals = screw.normals(angle)
    maps, drives = screw.contact_kinematics(normals)
    seen = drives + maps @ q
    turn = section_axes(screw, 0.3)
    for i in range(4):
        y = -normals[i]
        x, z = np.cross(y, [0.0, 1.0, 0.0]), np.array([0.0, 1.0, 0.0])
        speed = screw.screw_speed if ON_SCREW[i] else screw.nut_speed
        velocity, h = [], 1e-6
        for small in (np.zeros(3), 1e-4 * x, 1e-4 * z):
            offset = screw.ball_radius * normals[i] + small
            point = turn[0] * screw.pitch_radius + turn.T @ offset
            groove = (helical(screw, point, speed * h) - helical(screw, point, -speed * h)) / (2.0 * h)
            velocity.append(turn @ (material_velocity(screw, q, offset, 0.3) - groove))
        assert seen[i, :2] == pytest.approx([velocity[0] @ x, velocity[0] @ z], abs=1e-8)
        assert velocity[0] @ y == pytest.approx(0.0, abs=1e-9)
        spin = [(velocity[2] - velocity[0]) @ x / 1e-4, -(velocity[1] - velocity[0]) @ z / 1e-4]
        assert spin == pytest.approx([seen[i, 2]] * 2, abs=1e-5)


def test_pair_geometry_against_finite_differences() -> None:
    pair = SCREW.pair
    ends = [helical(SCREW, SCREW.pitch_radius * np.array([1.0, 0.0, 0.0]), s * 0.5 * pair.spacing) for s in (-1, 1)]
    line = ends[1] - ends[0]
    assert np.linalg.norm(line) == pytest.approx(2.0 * SCREW.ball_radius, rel=1e-13)
    line /= np.linalg.norm(line)
    frames = [section_axes(SCREW, s * 0.5 * pair.spacing) for s in (-1, 1)]
    q = [np.array([2.0, -3.0, 0.7, 8.0]), np.array([1.5, 1.0, -2.0, 7.0])]
    v = [
        material_velocity(SCREW, q[k], frames[k] @ (s * SCREW.ball_radius * line), s * -0.5 * pair.spacing)
        for k, s in ((0, 1.0), (1, -1.0))
    ]
    for k, rows in ((0, pair.first_ball_surface_speeds), (1, pair.second_ball_surface_speeds)):
        tangents = pair.tangent_directions[k] @ frames[k]
        assert tangents @ tangents.T == pytest.approx(np.eye(2), abs=1e-14)
        assert tangents @ line == pytest.approx([0.0, 0.0], abs=1e-14)
        assert rows @ q[k] == pytest.approx(tangents @ v[k], abs=1e-8)
        assert pair.force_directions[k] @ frames[k] == pytest.approx((-line, line)[k], abs=1e-14)
    assert (v[0] - v[1]) @ line == pytest.approx(pair.closing_speed_factor * (q[0][0] - q[1][0]), abs=1e-8)


def test_contact_spacing_of_3_72_is_exact_for_zero_lead_only() -> None:
    ring = replace(SCREW, lead=0.0)
    assert ring.pair.spacing == pytest.approx(2.0 * np.arcsin(ring.ball_radius / ring.radius), rel=1e-13)
    off = SCREW.pair.spacing / (2.0 * np.arcsin(SCREW.ball_radius / SCREW.radius)) - 1.0
    assert off == pytest.approx(-1.67e-4, abs=2e-6)


@pytest.mark.parametrize("name", STATES)
def test_input_power_is_dissipation_in_any_frame_reversed_and_mirrored(name: str) -> None:
    force, angle = STATES[name]
    one = motion.solve_ball_motion(SCREW, force, angle)
    assert one.motion.status == "exact"
    assert one.input_power == pytest.approx(one.motion.loss, rel=1e-10)
    moved = motion.solve_ball_motion(replace(SCREW, nut_speed=SCREW.nut_speed + 3.7, screw_speed=3.7), force, angle)
    assert moved.motion.loss == pytest.approx(one.motion.loss, rel=1e-10)
    assert moved.input_power == pytest.approx(one.input_power, rel=1e-9)
    assert moved.motion.unknown_velocities[0] == pytest.approx(one.motion.unknown_velocities[0] + 3.7, rel=1e-9)
    back = motion.solve_ball_motion(replace(SCREW, nut_speed=-SCREW.nut_speed), force, angle).motion
    mirror = motion.solve_ball_motion(replace(SCREW, lead=-SCREW.lead), force[FLIP], angle[FLIP]).motion
    for other, senses in ((back, -1.0), (mirror, [1.0, -1.0, -1.0, 1.0])):
        assert other.loss == pytest.approx(one.motion.loss, rel=1e-10)
        assert other.unknown_velocities == pytest.approx(one.motion.unknown_velocities * senses, rel=1e-7, abs=1e-7)


@pytest.mark.parametrize("u_y", [0.0, 5.2e-6, 8.0e-6])
def test_zero_lead_is_the_rotary_bearing(u_y: float) -> None:
    """Its x, y, z (axis, radius, path) are z3, x3, y3 here; its inner ring is the screw."""
    ring = source_cases.rotary_ball_scene("I").bearing
    s = solve_ball_of_bearing(ring, 100.0, u_y)
    screw = ScrewGroove(6.25e-3, 6.75e-3, 35e-3, 0.0, 0.25 * np.pi, 2.1e11, 0.28, 0.1, 0.0, 20.0 * np.pi)
    order = [0, 1, 3, 2]  # IL, IR, OL, OR
    one, loaded = motion.solve_ball_motion(screw, s.load.force[order], s.load.angle[order]), s.load.force[order] > 0.0
    assert one.contacts.a[loaded] == pytest.approx(s.problem.contacts.a[order][loaded], rel=1e-9)
    assert one.motion.loss == pytest.approx(s.motion.loss, rel=1e-9)
    assert one.motion.unknown_velocities[[0, 3, 1]] == pytest.approx(s.motion.unknown_velocities, rel=1e-7)
    assert one.motion.unknown_velocities[2] == pytest.approx(0.0, abs=1e-7)


def test_long_radius_is_the_linear_bearing() -> None:
    """Ball force and losses of a pair on a radius of 1 km are those of the linear bearing with the same loads."""
    line = LinearBearing(2.5e-3, 0.54, 0.25 * np.pi, 0.1, 0.1, 0.08, 210e9, 0.28)
    found = solve_linear_pair(line, np.radians(3.0), 0.5, 200.0)
    angles, loads = pair_angles_and_loads(line, np.radians(3.0), 0.5, 200.0)
    order = [0, 1, 3, 2]  # BL, BR, TL, TR of BL, BR, TR, TL
    radius = 1000.0
    groove = line.ball_radius, line.conformity * 2.0 * line.ball_radius, radius, 0.0, line.contact_angle
    screw = ScrewGroove(*groove, line.young, line.poisson, line.mu, line.speed / radius, mu_balls=line.mu_balls)
    balls = screw, loads[:, order], screw.normals(angles[:, order])
    apart, touching = (solve_motion_of_chain(screw_ball_chain(*balls, np.array([gap, np.inf]))) for gap in (np.inf, 0.0))
    assert touching.ball_force[0] == pytest.approx(found.ball_to_ball_force, rel=1e-4)
    assert apart.loss == pytest.approx(found.apart.loss, rel=1e-4)
    assert touching.loss == pytest.approx(found.touching.loss, rel=1e-4)


@pytest.mark.parametrize("coupling", ["ball", "ball and screw"])
@pytest.mark.parametrize("oversize", [-2e-6, 0.0, 1.7e-6])
def test_coupled_ball_is_in_equilibrium(coupling: str, oversize: float) -> None:
    """Forces and moments on the ball, normal and friction, and with them the axial force on the screw."""
    cell = ball_cell(SCREW, np.array([TWO, TWO, 0.0, 0.0]), oversize, "z", np.array([25.0]))
    r = coupled_ball(cell, coupling)  # type: ignore[arg-type]
    assert r.converged
    w, n = r.motion.wrench[0], SCREW.normals(r.loads_with_friction.angle[0])
    force = r.loads_with_friction.force[0]
    scale = float(force.sum())
    moment = w[:, 3:].sum(axis=0) + np.cross(SCREW.ball_radius * n, w[:, :3]).sum(axis=0)
    assert np.abs(w[:, :3].sum(axis=0) - force @ n).max() < 1e-8 * scale
    assert np.abs(moment).max() < 1e-8 * scale * SCREW.ball_radius
    on_screw = (force[:, None] * n - w[:, :3])[ON_SCREW].sum(axis=0) @ SCREW.screw_axis_direction
    off = abs(on_screw + 25.0) / 25.0
    assert off < 1e-8 if coupling == "ball and screw" else off > 4e-5
    assert r.motion.input_power == pytest.approx(r.motion.loss, rel=1e-10)


@pytest.mark.parametrize("lead", [0.0, 20e-3, -20e-3])
def test_a_ball_that_rolls_orbits_at_the_mean_of_its_two_contacts(lead):
    """Epicyclic gear: at the contact angle b the ball's centre moves along its path of radius L at half the sum of the
    contacts' speeds, w_s (L - r cos b cos a) and w_n (L + r cos b cos a); cos a = R / L."""
    groove = replace(SCREW, lead=lead)
    path = np.hypot(groove.pitch_radius, lead / (2.0 * np.pi))
    small = groove.ball_radius * np.cos(groove.contact_angle) * groove.pitch_radius / path
    speed = 0.5 * (groove.screw_speed * (path - small) + groove.nut_speed * (path + small))
    assert groove.nominal_orbit == pytest.approx(speed / path, rel=1e-12)
