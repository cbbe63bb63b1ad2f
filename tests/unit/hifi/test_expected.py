"""The cheap model that tells the mesh what contacts to expect: closed forms, symmetries, limits, what it sees."""

from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare.scenes import catalogue
from rollbench.hifi.contact.hertz import solve_hertz
from rollbench.hifi.meshing import settings
from rollbench.hifi.meshing.settings import estimate_contacts_of_scene
from rollbench.meshes.helix import lead_angle
from rollbench.meshes.parts import BallErrors, Errors, FourierTerm, Load, SideErrors

CASE = catalogue.scene("lin-case1")
RING = catalogue.scene("bearing-9")


def axial_ring(force: float):
    return replace(RING, loads=(Load(8e-3, (0.0, 0.0, force)),))


def test_ring_under_axial_load_is_the_closed_form():
    """Equal loads Q = F / (z sin a); cos a falls as both arcs and approaches in series grow beyond the arcs alone."""
    force, z = 3000.0, 9
    found, units = estimate_contacts_of_scene(axial_ring(force)), settings.hertz_contacts_under_unit_force(RING)
    arms = RING.screw.groove_radius + RING.nut.groove_radius - 2.0 * RING.balls.radius
    angle = beta = RING.track.contact_angle
    for _ in range(200):
        load = force / (z * np.sin(angle))
        length = arms + (units[0].approach + units[2].approach) * load ** (2.0 / 3.0)
        angle = np.arccos(arms * np.cos(beta) / length)
    np.testing.assert_allclose(found.loads[:, [0, 3]], load, rtol=1e-5)
    np.testing.assert_allclose(found.angles[:, [0, 3]], angle, rtol=1e-5)
    assert found.loads[:, [1, 2]].max() == 0.0
    assert found.nearly_touching_flanks() == (0, 3)
    across = [solve_hertz(load, *radii(RING, sign), 210e9, 0.28).semi_x for sign in (-1.0, 1.0)]
    assert found.semi_axes_across[0, [0, 3]] == pytest.approx(across, rel=1e-6)
    assert found.centre_shifts[0, 0] == pytest.approx((angle - beta) * RING.screw.groove_radius, rel=1e-4)


@pytest.mark.parametrize("force", [200.0, 3000.0])
def test_a_nut_closes_all_balls_as_far_as_their_forces_sum_up_to_the_axial_one(force):
    """A shift x of the nut closes each ball's two contacts by x sin a, of whose forces the sine is along the axis."""
    sin, units = np.sin(RING.track.contact_angle), settings.hertz_contacts_under_unit_force(RING)
    load = (settings.nut_shift_for_axial_force(RING, force) * sin / (units[0].approach + units[3].approach)) ** 1.5
    assert RING.ball_count * load * sin == pytest.approx(force, rel=1e-12)


def radii(scene, sign):
    r, track = scene.balls.radius, scene.track
    hollow = sign * np.cos(track.contact_angle) / (track.pitch_radius + sign * r * np.cos(track.contact_angle))
    part = scene.screw if sign < 0 else scene.nut
    return 1.0 / (1.0 / r - 1.0 / part.groove_radius), 1.0 / (1.0 / r - hollow)


def test_preload_alone_is_the_closed_form():
    """A ball larger by e in its four contacts: the approaches of both arcs close e each on a rigid ring."""
    e = 5e-6
    scene = replace(axial_ring(0.0), errors=Errors(balls=BallErrors(oversize=e)))
    found, units = estimate_contacts_of_scene(scene), settings.hertz_contacts_under_unit_force(scene)
    load = (2.0 * e / (units[0].approach + units[2].approach)) ** 1.5  # both approaches of a diagonal close 2 e
    np.testing.assert_allclose(found.loads, load, rtol=2e-3)
    assert found.nearly_touching_flanks() == (0, 1, 2, 3)


@pytest.mark.parametrize(("name", "sums"), [("lin-case1", 14198.0), ("lin-case3", 33439.0), ("lin-case3-offset", 33679.0)])
def test_near_the_reference(name, sums):
    """Within 3 % of the sum of loads of the finest 3D runs."""
    assert estimate_contacts_of_scene(catalogue.scene(name)).loads.sum() == pytest.approx(sums, rel=0.03)


@pytest.mark.slow
def test_errors_are_seen():
    nominal = estimate_contacts_of_scene(CASE).loads
    for errors in (
        Errors(SL=SideErrors(profile=(10e-6,))),
        Errors(NR=SideErrors(pitch=(FourierTerm(1.0, sin=20e-6),))),
        Errors(SL=SideErrors(roundness=(FourierTerm(2.0, cos=20e-6),))),
        Errors(balls=BallErrors(listed=((7, 10e-6),))),
    ):
        assert np.abs(estimate_contacts_of_scene(replace(CASE, errors=errors)).loads - nominal).max() > 2.0, errors


@pytest.mark.parametrize("name", ["lin-random", "lin-combined", "lin-pitch-4p1", "unseen-four-point", "unseen-63x20"])
def test_shipped_scenes_are_found_in_balance(name):
    found = estimate_contacts_of_scene(catalogue.scene(name))
    assert found.loads.max() > 0.0
    assert np.all((found.gaps < 0.0) == (found.loads > 0.0))


def test_forces_balance_the_load_and_axes_are_rounded_up():
    found = estimate_contacts_of_scene(CASE)
    total = (found.loads[:, 3] * np.sin(found.angles[:, 3])).sum() * np.cos(lead_angle(CASE.track))
    assert total == pytest.approx(5000.0, rel=1e-4)
    semi = found.typical_semi_axes()
    for exact, rounded in zip(semi, settings.round_up_lengths(semi), strict=True):
        assert rounded >= exact > rounded - 5e-6
        assert rounded / 5e-6 == pytest.approx(round(rounded / 5e-6))
