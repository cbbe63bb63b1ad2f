"""Sockets: their faces and coordinates, the size that fits a scene, and refusals that name cause and remedy."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from tests.helpers import small_screw, sockets_of, solid_sizes

from rollbench.compare.scenes.catalogue import scene
from rollbench.meshes import sockets as rules
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.helix import ball_layout

SIZE = rules.RefinementBoxSize(0.30, 1.2e-3, 0.075)
ALL = (0, 1, 2, 3)
LIN, RING, SIX, FLAT = scene("lin-case1"), scene("bearing-9"), small_screw(6), small_screw(4, beta=np.radians(20.0))


def fitted(case, sides=ALL, **changes):
    names = ("screw_land_radius", "screw_bore_radius", "nut_land_radius", "nut_outer_radius", "nut_end_positions")
    given = dict(zip(names, solid_sizes(case), strict=True)) | changes
    return rules.largest_fitting_refinement_box(GrooveMap.from_scene(case), ball_layout(case), sides, **given)


def with_balls(case, azimuths):
    return replace(case, balls=replace(case.balls, azimuths=tuple(float(a) for a in azimuths)))


def with_lead(lead):
    """The scene of small balls, its turns so far apart."""
    case = scene("lin-nominal-4p1")
    return replace(case, track=replace(case.track, lead=lead))


def gaps_of(case, pick=slice(None), turns=0.0):
    """Gaps between balls along the track and their pairs, balls counted from so many turns on."""
    layout = ball_layout(case)
    places = (layout.azimuth + 2.0 * np.pi * turns)[pick], layout.z[pick]
    return rules.azimuth_gaps_between_balls(GrooveMap.from_scene(case), *places)


# --- shape -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("divisions", [(2, 2, 2), (1, 1, 1), (3, 2, 1)], ids=str)
def test_socket_mesh_is_of_second_order_and_closed_but_for_its_rim(divisions):
    place = partial(rules.points_in_box_at_azimuth_zero, GrooveMap.from_scene(SIX), SIZE, 0)
    mesh, _ = rules.mesh_refinement_box_faces(place, divisions)
    count = {}
    for tri in mesh.triangles:
        for k, (i, j) in enumerate(((0, 1), (1, 2), (2, 0))):
            pair = tuple(sorted((int(tri[i]), int(tri[j]))))
            assert mesh.midside_node_of_edge[pair] == tri[3 + k]
            np.testing.assert_allclose(mesh.xi[tri[3 + k]], mesh.xi[list(pair)].mean(axis=0), atol=1e-15)
            count[pair] = count.get(pair, 0) + 1
    loop = rules.rim_nodes_of_refinement_box(mesh).tolist()
    around = {tuple(sorted(p)) for p in zip(loop, [*loop[1:], loop[0]], strict=True)}
    assert {pair for pair, times in count.items() if times == 1} == around
    assert set(count.values()) == {1, 2}
    assert np.all(mesh.xi[loop, 1] == 0.0)
    assert len(np.unique(np.round(mesh.xi, 12), axis=0)) == len(mesh.xi)


@pytest.mark.parametrize("side", range(4))
def test_socket_coordinates_invert_socket_points(side):
    case = small_screw(6, hand="left", phase=0.2)
    m = GrooveMap.from_scene(case)
    xi = np.stack(np.meshgrid(*[np.linspace(-1, 1, 5), np.linspace(0, 1, 4), np.linspace(-1, 1, 5)]), -1).reshape(-1, 3)
    for socket in sockets_of(case, (side,)):
        x = rules.points_in_refinement_box(m, SIZE, socket, xi)
        place = np.arctan2(x[:, 1], x[:, 0]), x[:, 2], np.hypot(x[:, 0], x[:, 1])
        found = rules.local_coordinates_in_refinement_box(m, SIZE, socket, *place)
        np.testing.assert_allclose(found, xi, atol=1e-11)


@pytest.mark.parametrize("side", range(4))
def test_middle_of_a_socket_is_the_nominal_contact_point(side):
    m = GrooveMap.from_scene(small_screw(6))
    x = rules.points_in_box_at_azimuth_zero(m, SIZE, side, np.zeros((1, 3)))[0] - [m.R, 0.0, 0.0]
    assert np.linalg.norm(x) == pytest.approx(m.ball, abs=1e-15)
    assert x[0] == pytest.approx(m.signs[side, 0] * m.ball * np.cos(m.beta), abs=1e-15)


# --- distances along the track ---------------------------------------------------------------------------------------


def test_gaps_follow_each_start_over_all_turns():
    case = small_screw(2)
    case = replace(case, track=replace(case.track, starts=2))
    gaps, pairs = gaps_of(with_balls(case, [-4.0, 0.5, 0.9, 7.0]))
    np.testing.assert_allclose(sorted(gaps), sorted(2 * [4.5, 0.4, 6.1]), atol=1e-9)
    assert {tuple(p) for p in pairs[np.abs(gaps - 0.4) < 1e-9]} == {(1, 2), (5, 6)}


def test_gaps_of_a_ring_close_around():
    case = with_balls(RING, [0.0, 2.0, -2.5])
    np.testing.assert_allclose(sorted(gaps_of(case)[0]), sorted([2.0, 2.5, 2 * np.pi - 4.5]), atol=1e-9)
    gaps, pairs = gaps_of(case, slice(1))
    np.testing.assert_allclose(gaps, [2.0 * np.pi])
    assert pairs.tolist() == [[0, 0]]


# --- room for the contacts -------------------------------------------------------------------------------------------


def test_long_contacts_get_long_sockets_or_are_refused():
    expected = 0.9e-3 / rules.FILLED / GrooveMap.from_scene(LIN).R
    assert fitted(LIN, contact_half_lengths=(0.2e-3, 0.9e-3)).phi == pytest.approx(expected)
    close = with_balls(small_screw(4), [0.0, 1.0, 1.12])
    assert fitted(close, contact_half_lengths=(0.2e-3, 0.5e-3)).phi == pytest.approx(0.12 / 2.6)
    with pytest.raises(ValueError, match=r"too short.*balls 2 and 3"):
        fitted(close, contact_half_lengths=(0.2e-3, 0.8e-3))


def test_sockets_beside_the_next_turn_stay_as_wide_as_their_contacts():
    case = with_lead(5.2e-3)
    m, size = GrooveMap.from_scene(case), fitted(case, contact_half_lengths=(0.58e-3, 0.05e-3))
    assert size.gamma >= 0.58e-3 / m.radius.min() / rules.ZONE * (1.0 - 1e-12)
    assert size.depth < rules.DEPTH * m.ball


@pytest.mark.parametrize("beta", [14.0, 30.0, 60.0, 74.0])
@pytest.mark.parametrize("conformity", [1.02, 1.3])
def test_sockets_of_a_ball_stay_apart(beta, conformity):
    """Seen from the ball's centre, no rim comes nearer than a tenth of the way to the middle between two contacts."""
    case = small_screw(4, beta=np.radians(beta))
    radius = conformity * case.balls.radius
    case = replace(case, screw=replace(case.screw, groove_radius=radius), nut=replace(case.nut, groove_radius=radius))
    m = GrooveMap.from_scene(case)
    size = fitted(case, screw_land_radius=16.45e-3, nut_land_radius=16.55e-3)
    for side in ALL:
        x3, z3 = m.polar_to_section(side, m.beta + size.gamma * np.array([-1.0, 1.0]), np.full(2, m.radius[side]))
        angle = np.degrees(np.arctan2(np.abs(z3), np.abs(x3)))
        assert np.all(np.sign(x3) == m.signs[side, 0])
        assert np.all(np.sign(z3) == m.signs[side, 1])
        assert 0.1 * beta < angle.min()
        assert angle.max() < 90.0 - 0.1 * (90.0 - beta)


CLOSE, TOUCHING = (with_balls(small_screw(4), [0.0, 1.0, last]) for last in (1.06, 1.0))
EDGE = r"flank SL: .*1\.6 mm \(28\.2 deg.*room for 1\.57 mm.*edge.*deepen the groove"
LOW_EDGE = r"28\.2 deg.*room for 1\.18 mm \(20\.8 deg\).*15\.6 mm, is 22\.5 deg.*lower"
APEX = r"1 mm .*because the apex between the two arcs is .* deg.*groove radius"
LONG = {"contact_half_lengths": (1.6e-3, 0.1e-3)}
NO_ROOM = [
    (LIN, ALL, LONG, EDGE),
    (LIN, ALL, LONG | {"screw_land_radius": 15.6e-3}, LOW_EDGE),
    (FLAT, ALL, {"contact_half_lengths": (1e-3, 0.1e-3)}, APEX),
    (LIN, (0,), {"screw_land_radius": 14.9e-3}, r"narrow.*edge of the groove.*14\.9 mm.*deepen the groove"),
    (LIN, (0,), {"screw_land_radius": 14.3e-3}, "SL flank ends before its contact.*move the land"),
    (small_screw(4, beta=np.radians(8.0)), (0,), {}, "narrow.*apex.*bring the groove radius closer"),
    (LIN, (0,), {"screw_bore_radius": 13.5e-3}, "shallow.*wall.*screw's bore.*thicken"),
    (LIN, (3,), {"nut_outer_radius": 19.5e-3}, "shallow.*wall.*nut's outside.*thicken"),
    (CLOSE, ALL, {}, "short.*balls 2 and 3 are only 0.99 mm apart.*further apart"),
    (TOUCHING, ALL, {}, "only 0 %.*balls 2 and 3 are only 0 mm apart"),
    (RING, ALL, {"nut_end_positions": (2.5e-3, 13.5e-3)}, "outermost balls are only 5.5 mm and 5.5 mm.*lengthen the nut"),
    (LIN, ALL, {"nut_end_positions": (0.3, 0.41)}, "from the flat ends; lengthen the nut or move the balls"),
    (with_lead(4.0e-3), ALL, {}, "next turn of the groove is only 4 mm away; raise the lead"),
]


@pytest.mark.parametrize(("case", "sides", "change", "match"), NO_ROOM)
def test_no_room_is_refused_with_cause_and_remedy(case, sides, change, match):
    with pytest.raises(ValueError, match=match):
        fitted(case, sides, **change)
