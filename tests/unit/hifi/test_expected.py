"""The cheap model that tells the mesh what contacts to expect: closed forms, symmetries, limits, what it sees."""

from dataclasses import replace

import numpy as np
import pytest
from tests.helpers import small_screw

from rollbench.compare.models.study import with_conformity
from rollbench.compare.scenes import catalogue
from rollbench.hifi.contact.hertz import solve_hertz
from rollbench.hifi.meshing import settings
from rollbench.hifi.meshing.part_meshes import choose_refinement_box_size
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.helix import ball_layout, lead_angle
from rollbench.meshes.parts import BallErrors, Errors, FourierTerm, Load, SideErrors, Support
from rollbench.meshes.solid import dimensions_of_3d_parts

CASE = catalogue.scene("lin-case1")
RING = catalogue.scene("bearing-9")


def axial_ring(force: float):
    return replace(RING, loads=(Load(8e-3, (0.0, 0.0, force)),))


def test_ring_under_axial_load_is_the_closed_form():
    """Equal loads Q = F / (z sin a); cos a falls as both arcs and approaches in series grow beyond the arcs alone."""
    force, z = 3000.0, 9
    found, units = settings.estimate_contacts_of_scene(axial_ring(force)), settings.hertz_contacts_under_unit_force(RING)
    arms = [part.groove_radius - RING.balls.radius for part in (RING.screw, RING.nut)]
    angle = beta = RING.track.contact_angle
    for _ in range(200):
        load = force / (z * np.sin(angle))
        length = sum(arms) + (units[0].approach + units[2].approach) * load ** (2.0 / 3.0)
        angle = np.arccos(sum(arms) * np.cos(beta) / length)
    np.testing.assert_allclose(found.loads[:, [0, 3]], load, rtol=1e-5)
    np.testing.assert_allclose(found.angles[:, [0, 3]], angle, rtol=1e-5)
    assert found.loads[:, [1, 2]].max() == 0.0
    assert found.nearly_touching_flanks() == (0, 3)
    a = solve_hertz(1.0, *radii(RING, -1.0), 210e9, 0.28).semi_x * np.cbrt(load)
    assert found.semi_axes_across[0, 0] == pytest.approx(a, rel=1e-6)
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
    found = settings.estimate_contacts_of_scene(scene)
    units = settings.hertz_contacts_under_unit_force(scene)
    load = (2.0 * e / (units[0].approach + units[2].approach)) ** 1.5  # both approaches of a diagonal close 2 e
    np.testing.assert_allclose(found.loads, load, rtol=2e-3)
    assert found.nearly_touching_flanks() == (0, 1, 2, 3)


@pytest.mark.parametrize(("name", "sums"), [("lin-case1", 14198.0), ("lin-case3", 33439.0), ("lin-case3-offset", 33679.0)])
def test_near_the_reference(name, sums):
    """Within 3 % of the sum of loads of the finest 3D runs."""
    assert settings.estimate_contacts_of_scene(catalogue.scene(name)).loads.sum() == pytest.approx(sums, rel=0.03)


def test_hand_and_direction_do_not_matter():
    as_is, left, other = (
        settings.estimate_contacts_of_scene(replace(CASE, **changes))
        for changes in ({}, {"track": replace(CASE.track, hand="left")}, {"loads": (Load(0.0, (0.0, 0.0, -5000.0)),)})
    )
    assert left.largest_reach() == pytest.approx(as_is.largest_reach(), rel=1e-3)
    assert other.nearly_touching_flanks() == (1, 2)
    assert other.typical_semi_axes() == pytest.approx(as_is.typical_semi_axes(), rel=1e-2)


def test_prescribed_displacements_are_seen():
    pushed = [(*CASE.supports, Support(at, (("ux", 1e-3), ("uy", 0.0)))) for at in (0.8, 0.5)]
    as_is, bent, near = (settings.estimate_contacts_of_scene(replace(CASE, supports=s)) for s in (CASE.supports, *pushed))
    assert as_is.loads.max() < bent.loads.max() < near.loads.max()
    assert near.largest_reach()[0] > 1.3 * as_is.largest_reach()[0]


@pytest.mark.parametrize(
    "errors",
    [
        Errors(SL=SideErrors(profile=(10e-6,))),
        Errors(NR=SideErrors(pitch=(FourierTerm(1.0, sin=20e-6),))),
        Errors(SL=SideErrors(roundness=(FourierTerm(2.0, cos=20e-6),))),
        Errors(balls=BallErrors(listed=((7, 10e-6),))),
    ],
)
def test_errors_are_seen(errors):
    changed = settings.estimate_contacts_of_scene(replace(CASE, errors=errors)).loads
    assert np.abs(changed - settings.estimate_contacts_of_scene(CASE).loads).max() > 2.0


def test_a_smaller_conformity_moves_contacts_farther():
    wide, close = (settings.estimate_contacts_of_scene(with_conformity(CASE, c)) for c in (0.58, 0.52))
    assert np.abs(close.centre_shifts).max() > 2.5 * np.abs(wide.centre_shifts).max()
    assert close.semi_axes_across.max() > 1.6 * wide.semi_axes_across.max()


@pytest.mark.parametrize("name", ["lin-random", "lin-combined", "lin-pitch-4p1", "unseen-four-point", "unseen-63x20"])
def test_shipped_scenes_are_found_in_balance(name):
    found = settings.estimate_contacts_of_scene(catalogue.scene(name))
    assert isinstance(found, settings.ExpectedContacts)
    assert found.loads.max() > 0.0
    assert np.all((found.gaps < 0.0) == (found.loads > 0.0))


def test_a_screw_that_nothing_holds_is_refused():
    free = replace(CASE, supports=())
    with pytest.raises(ValueError, match=r"no equilibrium.*support the screw"):
        settings.estimate_contacts_of_scene(free)


def test_forces_balance_the_load_and_axes_are_rounded_up():
    found = settings.estimate_contacts_of_scene(CASE)
    total = (found.loads[:, 3] * np.sin(found.angles[:, 3])).sum() * np.cos(lead_angle(CASE.track))
    assert total == pytest.approx(5000.0, rel=1e-4)
    semi = found.typical_semi_axes()
    a, b = settings.round_up_lengths(semi)
    assert a >= semi[0] > a - 5e-6
    assert b >= semi[1] > b - 5e-6
    assert a / 5e-6 == pytest.approx(round(a / 5e-6))


def test_sockets_take_cuts_and_reach_from_the_settings():
    case = small_screw(4)
    m, layout, dims = GrooveMap.from_scene(case), ball_layout(case), dimensions_of_3d_parts(case)
    size = choose_refinement_box_size(
        case, m, layout, (0, 3), dims, settings.Settings(reach=(0.9e-3, 0.1e-3), cuts=(4, 3, 4))
    )
    assert size.edge_divisions == (4, 3, 4)
    assert size.gamma > 0.3
    with pytest.raises(ValueError, match=r"reaches 3 mm .* room for"):
        choose_refinement_box_size(case, m, layout, (0, 3), dims, settings.Settings(reach=(3e-3, 0.1e-3)))
