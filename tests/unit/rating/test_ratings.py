"""Ratings of load distributions against closed forms, tables of the standards, and one another. Turns without balls add
nothing: gaps of circuits, arcs, listed azimuths, preload by a share of C."""

from dataclasses import replace
from math import cos, pi, sin

import numpy as np
import pytest
from tests.helpers import small_screw

from rollbench.compare.models.answers import results_of_contact_loads
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.lowfi.rating import contacts, rigidity
from rollbench.lowfi.rating.life import basic_rating_life, contact_capacity, dynamic_rating, filled_turns
from rollbench.lowfi.statics import validity
from rollbench.lowfi.statics.contacts import hertz_without_errors, nominal_curvatures
from rollbench.lowfi.statics.problem import place_balls
from rollbench.meshes import errors, helix
from rollbench.meshes.parts import BallErrors, Balls, Errors, FourierTerm, Material, Nut, Scene, Screw, SideErrors, Track

STEEL = Material(206e9, 0.3)


def ring(ratio: float, conformity: float = 0.52, balls: int = 9, angle: float = 0.0) -> Scene:
    """Ring of 10 mm balls with D cos(alpha)/D_pw = ratio."""
    r, pitch, groove = 5e-3, 5e-3 * cos(angle) / ratio, conformity * 10e-3
    inner, outer = Screw(20e-3, 2 * pitch - 1e-3, groove, STEEL), Nut(10e-3, 20e-3, 4 * pitch, groove, STEEL)
    spread = Balls(r, STEEL, tuple(2 * pi * np.arange(balls) / balls))
    return Scene("ring", "ring", Track(pitch, 0.0, angle), inner, outer, spread)


def loads(scene: Scene, force: float) -> np.ndarray:
    """Equal forces on the one diagonal."""
    out = np.zeros((scene.ball_count, 4))
    out[:, [0, 3]] = force
    return out


def oversized(scene: Scene, oversize: float) -> Scene:
    return replace(scene, errors=Errors(balls=BallErrors(oversize=oversize)))


def drawn(scene: Scene) -> errors.GeometryWithErrors:
    return errors.draw_geometry_with_errors(scene, helix.ball_layout(scene))


@pytest.mark.parametrize(("ratio", "printed"), [(0.10, 55.5), (0.16, 59.6), (0.20, 59.9), (0.26, 58.2)])
def test_radial_rating_of_a_ring_is_that_of_the_table_of_ISO_281(ratio: float, printed: float) -> None:
    """C_r = 1.3 f_c cos(alpha)^0.7 Z^(2/3) D^1.8 with f_c of the standard's table (single-row, grooves up to 0.52)."""
    found = dynamic_rating(ring(ratio)) / (1.3 * 9 ** (2 / 3) * 10.0**1.8)
    assert found == pytest.approx(printed, rel=0.012)  # the table's own rounding of exponents and steps


def test_equal_loads_give_the_cube_of_rating_over_load() -> None:
    screw = catalogue.scene("unseen-40x10")
    found = basic_rating_life(screw, loads(screw, 250.0))
    axial = 250.0 * screw.ball_count * rigidity.approach_per_displacement(screw)
    assert (found.revolutions, found.equivalent_load) == pytest.approx(
        ((dynamic_rating(screw) / axial) ** 3, axial), rel=1e-12
    )
    assert replace(found, speed=2 * pi).hours == pytest.approx(1e6 * found.revolutions / 3600.0)


def test_the_rating_of_a_screw_by_the_formulas_of_ISO_3408_5_in_their_own_form() -> None:
    """C_a = C_i i^0.86, C_i = C_s (1 + (C_s/C_n)^(10/3))^-0.3, C_s = f_c cos^0.86 z^(2/3) D^1.8 tan cos(phi)^1.3, with
    f_c = 9.32 f_1 f_2 (1/(1 - 1/(2 f_rs)))^0.41 and C_s/C_n = f_3."""
    scene = catalogue.scene("unseen-40x10")
    a, D, f = scene.track.contact_angle, 6.35, 0.525
    g, phi = D * cos(a) / 41.4, np.arctan2(10.0, pi * 41.4)
    f_1, f_2 = 10.0 * (1.0 - sin(a) / 3.0), g**0.3 * (1 - g) ** 1.39 / (1 + g) ** (1 / 3)
    f_c = 9.32 * f_1 * f_2 * (1.0 / (1.0 - 1.0 / (2 * f))) ** 0.41
    C_s = f_c * cos(a) ** 0.86 * 19 ** (2 / 3) * D**1.8 * np.tan(a) * cos(phi) ** 1.3
    f_3 = ((1 - g) / (1 + g)) ** 1.723
    assert dynamic_rating(scene) == pytest.approx(C_s * (1 + f_3 ** (10 / 3)) ** -0.3 * 3**0.86, rel=2e-3)
    assert filled_turns(scene) == pytest.approx(3.0)


def test_contact_capacities_are_those_of_the_rating_in_ISO_TS_16281() -> None:
    """Q_ci = C_r/(0.407 Z cos(alpha)) (1 + (1.044 ((1 - g)/(1 + g))^1.72)^(10/3))^(3/10), equal grooves."""
    scene, g = ring(0.15, angle=0.4), 0.15
    ratio = 1.044 * ((1 - g) / (1 + g)) ** 1.72
    inner = dynamic_rating(scene) / (0.407 * 9 * cos(0.4)) * (1 + ratio ** (10 / 3)) ** 0.3
    outer = dynamic_rating(scene) / (0.389 * 9 * cos(0.4)) * (1 + ratio ** (-10 / 3)) ** 0.3
    np.testing.assert_allclose(contact_capacity(scene)[[0, 3]], [inner, outer], rtol=3e-3)


def test_static_safety_at_the_rated_pressure_is_one_and_the_dent_about_a_ten_thousandth() -> None:
    """ISO 76 says of its 4200 MPa that both surfaces together are lastingly dented by about 1e-4 of the ball's diameter."""
    scene = ring(0.15)
    force = float((validity.DENT_PRESSURE / hertz_without_errors(scene).pressure(np.ones(4))[0]) ** 3)
    load = loads(scene, force)
    worst = contacts.contact_of_highest_pressure(scene, drawn(scene), load, np.where(load > 0.0, 0.0, np.nan))
    assert worst.side == "SL"
    assert worst.pressure == pytest.approx(1.5 * force / (pi * worst.a * worst.b))
    safety = worst.static_safety
    assert safety.factor == pytest.approx(1.0)
    assert safety.permanent_indentation == pytest.approx(1e-4, rel=0.5)
    across, along = 1e-3 * nominal_curvatures(scene)[0]
    dent = 1.3e-7 * force**2 / 10.0 * across * along  # [mm]
    assert 10.0 * safety.permanent_indentation == pytest.approx(dent, rel=1e-9)


@pytest.mark.parametrize("hertz", ["nominal", "error-free"])
def test_the_worst_contact_is_that_of_the_ball_that_is_there(hertz: str) -> None:
    """Balls 5 um too large in grooves of 8 mm under 290.4 N, by another program; the law of the loads changes nothing."""
    scene = catalogue.scene("two-balls")
    wide = {"screw": replace(scene.screw, groove_radius=8e-3), "nut": replace(scene.nut, groove_radius=8e-3)}
    scene = replace(scene, **wide, ingredients=replace(scene.ingredients, hertz=hertz))
    load = np.array([[290.4, 0.0, 0.0, 0.0], [0.0] * 4])
    found = results_of_contact_loads(scene, load, np.full((2, 4), pi / 4))
    values = 1e-6 * found.worst.pressure, 1e3 * found.worst.a, 1e6 * found.worst.approach
    assert values == pytest.approx((3038.5, 0.2831, 8.775), rel=2e-4)
    larger = replace(scene, balls=replace(scene.balls, radius=4.005e-3), errors=Errors())
    same = results_of_contact_loads(larger, load, np.full((2, 4), pi / 4))
    by_error, by_size = (
        (x.worst.safety, x.worst.static_safety.permanent_indentation, x.truncation.half_width_angle) for x in (found, same)
    )
    assert by_error == pytest.approx(by_size, rel=1e-4)


def test_the_worst_contact_of_a_wider_groove_has_the_wider_groove_s_pressure() -> None:
    scene = small_screw(4)
    wide = replace(scene, errors=Errors(SL=SideErrors(profile=(-20e-6,))))
    wider = replace(scene, screw=replace(scene.screw, groove_radius=scene.screw.groove_radius + 20e-6))
    load = loads(scene, 100.0) * [1.0, 0.0, 0.0, 0.0]
    found = (results_of_contact_loads(s, load, np.full((4, 4), 0.7)) for s in (scene, wide, wider))
    before, by_error, by_key = (x.worst.pressure for x in found)
    assert by_error == pytest.approx(by_key, rel=1e-4)
    assert by_key > 1.002 * before


def test_an_ellipse_over_the_edge_of_the_land_is_cut_and_says_where() -> None:
    scene = small_screw(4)
    load = loads(scene, 100.0)
    angle = np.where(load > 0.0, scene.track.contact_angle, np.nan)
    free = contacts.most_truncated_ellipse(scene, drawn(scene), load, angle)
    assert free.margin > 0.0 == free.truncated_contacts
    angle[2, 0] = free.edge_angle - 0.5 * free.half_width_angle
    over = contacts.most_truncated_ellipse(scene, drawn(scene), load, angle)
    assert (over.ball, over.side, over.edge, over.truncated_contacts) == (3, "SL", "land", 1)
    assert over.margin == pytest.approx(-0.5 * free.half_width_angle)


def test_contacts_alone_are_Hertz_and_stiffer_under_preload() -> None:
    scene = catalogue.scene("lin-case1")
    h, s = hertz_without_errors(scene), rigidity.approach_per_displacement(scene)
    each = 5000.0 / (32 * s)
    closed = (h.C[0] + h.C[3]) * each ** (2 / 3) / s
    assert rigidity.displacement_by_contacts_only(scene, 5000.0) == pytest.approx(closed, rel=1e-9)
    tight, loose = (rigidity.displacement_by_contacts_only(oversized(scene, x), 5000.0) for x in (7e-6, -5e-6))
    assert tight < 0.6 * closed
    assert loose == pytest.approx(closed, rel=1e-6)


def test_bodies_add_the_displacement_of_thick_tubes_in_the_form_of_ISO_3408_4() -> None:
    """1/R = ((D_1^2 + D_c^2)/(D_1^2 - D_c^2) + (d_c^2 + d_b^2)/(d_c^2 - d_b^2))/(2 pi i P_h E tan^2), one material."""
    scene = catalogue.scene("lin-case1")
    D_c, D_1, E = 33e-3 + 5.556e-3 * cos(pi / 4), 48e-3, 210e9
    sum_ = (D_1**2 + D_c**2) / (D_1**2 - D_c**2) + 1.0
    assert rigidity.axial_compliance_of_bodies(scene) == pytest.approx(sum_ / (2 * pi * 2 * 20e-3 * E), rel=1e-9)
    assert rigidity.axial_compliance_of_bodies(ring(0.15)) is None
    found = rigidity.three_axial_rigidities(scene, -5000.0, -20e-6)
    assert found.contacts_only > found.with_bodies
    assert found.makers_practice == pytest.approx(0.8 * found.with_bodies)  # what makers advise to take
    assert found.with_unequal_loads == pytest.approx(250e6)
    assert rigidity.three_axial_rigidities(scene, 0.0, None) is None


@pytest.mark.parametrize(("angle", "printed"), [(45.1, 42.1), (60.0, 39.2), (75.0, 37.3)])
def test_axial_rating_of_a_thrust_bearing_is_that_of_the_table_of_ISO_281(angle: float, printed: float) -> None:
    """C_a = 1.3 f_c cos(alpha)^0.7 tan(alpha) Z^(2/3) D^1.8, D cos(alpha)/D_pw = 0.01, grooves of 0.535."""
    a = np.radians(angle)
    found = dynamic_rating(ring(0.01, 0.535, angle=a)) / (1.3 * cos(a) ** 0.7 * np.tan(a) * 9 ** (2 / 3) * 10.0**1.8)
    assert found == pytest.approx(printed, rel=0.012)


def test_a_bearing_of_62_deg_is_rated_as_a_thrust_bearing_and_one_of_45_deg_is_not() -> None:
    a = np.radians(62.0)
    scene = ring(0.1, angle=a)
    steep = contact_capacity(scene) / contact_capacity(ring(0.1))
    assert steep == pytest.approx(np.full(4, 0.9 / 0.95 * (1 - sin(a) / 3) * cos(a) ** -0.3), rel=1e-12)

    found, axial = basic_rating_life(scene, loads(scene, 500.0)), 9 * 500.0 * sin(a)
    assert (found.revolutions, found.equivalent_load) == pytest.approx(
        ((dynamic_rating(scene) / axial) ** 3, axial), rel=1e-12
    )
    rings = [ring(0.1, angle=np.radians(x)) for x in (40.0, 45.0, 46.0)]
    assert [contacts.dynamic_and_static_ratings(x).is_axial for x in rings] == [False, False, True]


@pytest.mark.parametrize(("ratio", "printed"), [(0.05, 15.7), (0.10, 16.4), (0.16, 14.9), (0.20, 14.0)])
def test_static_rating_of_a_ring_is_that_of_the_table_of_ISO_76(ratio: float, printed: float) -> None:
    """C_0r = f_0 Z D^2 cos(alpha), grooves of 0.52 and 0.53."""
    scene = replace(ring(ratio), nut=replace(ring(ratio).nut, groove_radius=0.53 * 10e-3))
    assert contacts.static_rating(scene) / (9 * 10.0**2) == pytest.approx(printed, rel=0.013)


def test_static_ratings_where_all_balls_share_an_axial_load() -> None:
    """A ring by pressure, a screw by ISO 3408-5: k_0 = 27.74/(D sqrt(...)), C_0a = k_0 i z sin(alpha) cos(phi) D^2."""
    a = np.radians(60.0)
    assert contacts.static_rating(ring(0.01, 0.54, angle=a)) / (9 * 100.0 * sin(a)) == pytest.approx(60.8, rel=0.013)
    screw = catalogue.scene("unseen-40x10")
    alpha, D, f, pitch = screw.track.contact_angle, 6.35, 0.525, 41.4
    across, along = 2 / D - 1 / (f * D), 2 / D + cos(alpha) / (pitch / 2 - D / 2 * cos(alpha))
    phi = np.arctan2(10.0, pi * pitch)
    k_0 = 27.74 / (D * np.sqrt(across * along))
    assert contacts.static_rating(screw) == pytest.approx(k_0 * 57 * sin(alpha) * cos(phi) * D**2, rel=3e-3)
    found = contacts.dynamic_and_static_ratings(screw)
    assert (found.dynamic, found.static_standard) == (dynamic_rating(screw), "ISO 3408-5")


def test_the_dynamic_rating_is_that_of_a_maker_who_prints_balls_and_diameters() -> None:
    """SNFA SEA 10: 12 balls of 2.38 mm between 10 and 19 mm, 15 deg: 190 daN."""
    a = np.radians(15.0)
    scene = ring(2.38 * cos(a) / 14.5, balls=12, angle=a)
    assert dynamic_rating(scene) * 0.238**1.8 == pytest.approx(1900.0, rel=0.02)


def test_displacement_by_a_load_far_below_the_preload_is_not_lost_beside_it() -> None:
    """A load of 1e-12 of the preload, and the linear stiffness N s^2 3 sqrt(c) / C^(3/2) of both diagonals."""
    scene = oversized(catalogue.scene("unseen-40x10"), 5e-6)
    C, s = hertz_without_errors(scene).C, rigidity.approach_per_displacement(scene)
    closure = float(place_balls(scene, drawn(scene)).interference.mean())
    stiff = 3.0 * scene.ball_count * s**2 * np.sqrt(closure) / (C[0] + C[3]) ** 1.5
    for force in (1.0, 1e-6):
        assert rigidity.displacement_by_contacts_only(scene, force) == pytest.approx(force / stiff, rel=1e-3)


def test_a_screw_pressed_more_by_one_diagonal_counts_from_where_it_rests() -> None:
    """A pitch error that shifts one flank along the track leaves the displacement by a load what it was."""
    even = oversized(catalogue.scene("unseen-40x10"), 5e-6)
    shifted = replace(even, errors=replace(even.errors, SL=SideErrors(pitch=(FourierTerm(0.0, cos=2e-6),))))
    moved, expected = (rigidity.displacement_by_contacts_only(scene, 1.0) for scene in (shifted, even))
    assert moved == pytest.approx(expected, rel=0.2)


#: SFU 2505 of a maker: 96 balls in four turns.
SCREW = """
title = "SFU 2505"
material = {{ name = "bearing steel" }}
track = {{ pitch_diameter = "25.698 mm", lead = "5 mm", contact_angle = "45 deg" }}
screw = {{ length = "500 mm", outer_diameter = "25 mm", conformity = 0.525 }}
nut = {{ position = "250 mm", length = "200 mm", outer_diameter = "40 mm", conformity = 0.525 }}
supports = [{{ at = "0 mm", fix = ["ux", "uy", "rx", "ry", "rz"] }}]
[balls]
diameter = "3.175 mm"
{balls}
"""
WHOLE = "count = 96\nturns = 4"


def sfu_2505(balls: str, more: str = "") -> Scene:
    return scene_file.scene_from_text(SCREW.format(balls=balls) + more, "my.toml")


def turned(*turns: float) -> str:
    return "[" + ", ".join(f'"{float(360.0 * x)!r} deg"' for x in turns) + "]"


def circuits(number: int, gap: float) -> str:
    return f"count = 96\nturns = {4 / number}\ncircuits = {number}\ncircuit_gap = {gap}"


SAME = [circuits(number, gap) for number in (2, 4, 8) for gap in (0.0, 0.01, 1 / 24, 0.25, 0.5, 1.0, 5.0)]
SAME += [
    "count = 96\narcs = [" + ", ".join((turned(-6, -3.5), turned(-1, 0), turned(0.75, 1.25))) + "]",
    "azimuths = " + turned(*(np.arange(96) / 24 + np.repeat([-3.0, 0.0, 0.2], [10, 70, 16]))),
    "azimuths = " + turned(*np.random.default_rng(1).permutation(np.arange(96) / 24)),
]


@pytest.mark.parametrize("balls", SAME)
def test_the_same_filled_turns_have_the_same_rating_and_life(balls: str) -> None:
    scene, whole = sfu_2505(balls), sfu_2505(WHOLE)
    load = np.full((96, 4), 60.0)
    assert filled_turns(scene) == pytest.approx(4.0, rel=1e-12)
    assert dynamic_rating(scene) == pytest.approx(dynamic_rating(whole), rel=1e-9)
    assert dynamic_rating(scene) == pytest.approx(15127.0, rel=1e-4)  # by hand, exponents of the standard rounded
    assert basic_rating_life(scene, load).revolutions == pytest.approx(basic_rating_life(whole, load).revolutions, rel=1e-9)
    np.testing.assert_allclose(contact_capacity(scene), contact_capacity(whole), rtol=1e-9)
    assert rigidity.axial_compliance_of_bodies(scene) == pytest.approx(rigidity.axial_compliance_of_bodies(whole), rel=1e-9)


def test_unequal_distances_fill_what_the_median_fills_and_no_jump_comes_of_a_moved_ball() -> None:
    whole = sfu_2505(WHOLE)
    places = np.array(whole.balls.azimuths)

    def of(azimuths: np.ndarray) -> Scene:
        return replace(whole, balls=replace(whole.balls, azimuths=tuple(azimuths)))

    piled = places - np.where(np.arange(96) % 24 == 23, 1e-3, 0.0)  # clearance behind one ball of every turn
    assert dynamic_rating(of(piled)) == pytest.approx(dynamic_rating(whole), rel=1e-9)
    spread = np.sort(places + np.random.default_rng(0).uniform(-0.02, 0.02, 96))
    assert filled_turns(of(spread)) == pytest.approx(96 * np.median(np.diff(spread)) / (2 * pi))
    assert dynamic_rating(of(spread)) == pytest.approx(dynamic_rating(whole), rel=0.01)
    moved = spread.copy()
    for step in np.linspace(0.0, 0.1, 50):
        moved[50] = spread[50] + step
        assert dynamic_rating(of(moved)) == pytest.approx(dynamic_rating(of(spread)), rel=2e-3)
    assert filled_turns(of(places[:1])) == 1.0


def test_a_preload_by_a_share_of_the_rating_does_not_depend_on_gaps() -> None:
    more = '[preload]\nforce = "5 % of C"\n'
    found = {sfu_2505(balls, more).errors.balls.oversize for balls in (WHOLE, circuits(4, 0.25), circuits(4, 5.0))}
    assert max(found) == pytest.approx(min(found), rel=1e-9)
    assert min(found) > 0.0
