"""A nut whose halves are shifted against one another: closed form, two nuts on one shaft, rigidity, travelling balls."""

from dataclasses import replace

import numpy as np
import pytest
from tests.axes import assembly, nut
from tests.helpers import ALL_BUT_AXIAL, relative, small_screw, solved

from rollbench.lowfi.rating import rigidity
from rollbench.lowfi.rating.displacement import motion_at
from rollbench.lowfi.statics.axis.solve import solve_assembly
from rollbench.lowfi.statics.contacts import hertz_without_errors
from rollbench.lowfi.statics.static import solve_elastic
from rollbench.meshes.errors import are_in_shifted_half, draw_errors
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Errors, Load, Support

OFFSET = 12e-6


def halves(offset=OFFSET, force=0.0, hand="right", **ingredients):
    """Two circuits of six balls, a turn each, a turn apart."""
    scene = small_screw(count=6, lead=10e-3, force=(0.0, 0.0, force), hand=hand, **ingredients)
    turn = 2.0 * np.pi * (1.0 if hand == "right" else -1.0)
    azimuths = tuple(a + k * turn for k in (-1.0, 1.0) for a in scene.balls.azimuths)
    return replace(scene, balls=replace(scene.balls, azimuths=azimuths), errors=Errors(lead_offset=offset))


@pytest.mark.parametrize("hand", ["right", "left"])
def test_rigid_bodies_share_the_offset_between_their_halves(hand):
    """Without load the screw stands in the middle: each half presses its diagonal by s offset / 2."""
    scene = halves(hand=hand, screw="rigid")
    found = solved(scene)
    C = hertz_without_errors(scene).C
    expected = (0.5 * rigidity.approach_per_displacement(scene) * OFFSET / (C[0] + C[3])) ** 1.5
    first, second = ([0, 3], [1, 2]) if found.load[0, 0] > 0.0 else ([1, 2], [0, 3])
    for half, loaded, idle in ((found.load[:6], first, second), (found.load[6:], second, first)):
        np.testing.assert_allclose(half[:, loaded], expected, rtol=0.02)
        assert not half[:, idle].any()


def test_one_nut_is_two_nuts_of_which_one_is_shifted():
    """Rigid nuts on an elastic shaft under load: another code path, in which a nut is moved instead of its groove."""
    sets = [nut(f"nut {k}", z, count=6, turns=1.0, offset=o) for k, z, o in ((1, 0.14, 0.0), (2, 0.16, OFFSET))]
    given = {"supports": (Support(0.0, ALL_BUT_AXIAL),), "loads": (Load(0.0, (0.0, 0.0, 300.0)),)}
    two = solve_assembly(assembly(*sets, **given))
    one = sets[0].parts
    nut_of_both = replace(one.nut, position=0.15, length=60e-3)
    found = solved(replace(one, nut=nut_of_both, balls=halves().balls, errors=Errors(lead_offset=OFFSET), **given))
    assert two.status == "converged"
    wanted = np.concatenate([s.balls.load for s in two.sets])
    assert relative(found.load, wanted) < 2e-3  # a groove that is shifted turns its contacts by the offset, a nut does not
    assert (found.load[:, :2] > 0.0).any(axis=0).all()


def test_a_ball_that_travels_meets_the_half_it_is_in():
    scene = halves()
    z = np.array([-9e-3, 9e-3]) + scene.nut.position
    met = draw_errors(scene).geometry_at_balls(scene, np.zeros(2), np.zeros(2), z, np.full(2, scene.balls.radius))
    step = met.groove_centres[1] - met.groove_centres[0]
    np.testing.assert_allclose(step[:2], 0.0, atol=1e-15)
    along = rigidity.approach_per_displacement(scene) / np.sin(scene.track.contact_angle)
    np.testing.assert_allclose(step[2:], [[0.0, OFFSET * along]] * 2, atol=1e-12)


def test_preload_stiffens_the_contacts_as_the_solution_says():
    """Rigid bodies: the displacement of (1) is that of the solved screw, half and half of both diagonals."""
    force = 60.0
    scene = halves(force=force, screw="rigid")
    moved = [motion_at(solved(s), s.nut.position)[2] for s in (scene, halves(screw="rigid"))]
    preloaded, loose = (rigidity.displacement_by_contacts_only(s, force) for s in (scene, halves(0.0, force)))
    assert preloaded == pytest.approx(moved[0] - moved[1], rel=0.02)
    assert preloaded < 0.5 * loose


def test_elastic_bodies_are_pressed_alike_by_forces_this_small():
    rigid, elastic = solved(halves(screw="rigid")), solve_elastic(halves())
    assert elastic.status == "converged"
    assert elastic.load.mean() == pytest.approx(rigid.load.mean(), rel=0.02)
    assert ((elastic.load > 0.0) == (rigid.load > 0.0)).all()


@pytest.mark.parametrize("hand", ["right", "left"])
def test_a_ball_at_the_nut_s_centre_has_the_step_beside_it(hand):
    """It counts to the half before the step; as near the centre on either side it counts to its own half."""
    scene = replace(small_screw(count=7, turns=2.0, hand=hand, screw="rigid"), errors=Errors(lead_offset=OFFSET))
    layout = ball_layout(scene)
    middle = int(np.abs(layout.z - scene.nut.position).argmin())
    assert abs(layout.z[middle] - scene.nut.position) < 1e-9 * scene.balls.radius
    before, after = (layout.z < layout.z[middle] - 1e-6), (layout.z > layout.z[middle] + 1e-6)
    for moved in (0.0, 1e-14, -1e-14):
        np.testing.assert_array_equal(are_in_shifted_half(scene, layout.z + moved), after)
    pressed = solved(scene).load > 0.0
    assert pressed[before].any(axis=0).tolist() == pressed[middle].tolist()
    assert not (pressed[after].any(axis=0) & pressed[middle]).any()
    assert rigidity.displacement_by_contacts_only(scene, 100.0) > 0.0
