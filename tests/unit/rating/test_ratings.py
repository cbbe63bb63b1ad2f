"""Ratings of load distributions against closed forms, tables of the standards, and one another."""

from dataclasses import replace
from math import cos, pi, sin

import numpy as np
import pytest

from compare.scenes import catalogue
from lowfi.rating.contacts import static_safety, truncation, worst_contact
from lowfi.rating.life import contact_capacity, life, rating, turns_of
from lowfi.rating.rigidity import body_compliance, contacts_displacement, rigidities, slope_of
from lowfi.statics.problem import nominal_hertz
from lowfi.statics.validity import DENT_PRESSURE
from meshes.parts import BallErrors, Balls, Errors, Material, Nut, Scene, Screw, Track
from tests.helpers import small_screw

STEEL = Material(206e9, 0.3)


def ring(ratio: float, conformity: float = 0.52, balls: int = 9, angle: float = 0.0) -> Scene:
    """Ring of 10 mm balls with D cos(alpha)/D_pw = ratio."""
    r = 5e-3
    pitch = r * cos(angle) / ratio
    return Scene(
        name="ring",
        title="ring",
        track=Track(pitch, 0.0, angle),
        screw=Screw(20e-3, 2 * pitch - 1e-3, conformity * 2 * r, STEEL),
        nut=Nut(10e-3, 20e-3, 4 * pitch, conformity * 2 * r, STEEL),
        balls=Balls(r, STEEL, tuple(2 * pi * np.arange(balls) / balls)),
    )


def loads(scene: Scene, force: float) -> np.ndarray:
    """Equal forces on the one diagonal."""
    out = np.zeros((scene.ball_count, 4))
    out[:, [0, 3]] = force
    return out


@pytest.mark.parametrize(("ratio", "printed"), [(0.10, 55.5), (0.16, 59.6), (0.20, 59.9), (0.26, 58.2)])
def test_radial_rating_of_a_ring_is_that_of_the_table_of_ISO_281(ratio: float, printed: float) -> None:
    """C_r = 1.3 f_c cos(alpha)^0.7 Z^(2/3) D^1.8 with f_c of the standard's table (single-row, grooves up to 0.52)."""
    scene = ring(ratio)
    found = rating(scene) / (1.3 * scene.ball_count ** (2 / 3) * 10.0**1.8)
    assert found == pytest.approx(printed, rel=0.012)  # the table's own rounding of exponents and steps


def test_equal_loads_give_the_cube_of_rating_over_load() -> None:
    screw = catalogue.scene("unseen-40x10")
    force = 250.0
    found = life(screw, loads(screw, force))
    assert found is not None
    axial = force * screw.ball_count * slope_of(screw)
    assert found.revolutions == pytest.approx((rating(screw) / axial) ** 3, rel=1e-12)
    assert found.equivalent == pytest.approx(axial, rel=1e-12)
    assert found.hours(2 * pi) == pytest.approx(1e6 * found.revolutions / 3600.0)


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
    assert rating(scene) == pytest.approx(C_s * (1 + f_3 ** (10 / 3)) ** -0.3 * 3**0.86, rel=2e-3)
    assert turns_of(scene) == pytest.approx((19.0, 3.0))


def test_contact_capacities_are_those_of_the_rating_in_ISO_TS_16281() -> None:
    """Q_ci = C_r/(0.407 Z cos(alpha)) (1 + (1.044 ((1 - g)/(1 + g))^1.72)^(10/3))^(3/10), equal grooves."""
    scene, g = ring(0.15, angle=0.4), 0.15
    ratio = 1.044 * ((1 - g) / (1 + g)) ** 1.72
    inner = rating(scene) / (0.407 * 9 * cos(0.4)) * (1 + ratio ** (10 / 3)) ** 0.3
    outer = rating(scene) / (0.389 * 9 * cos(0.4)) * (1 + ratio ** (-10 / 3)) ** 0.3
    np.testing.assert_allclose(contact_capacity(scene)[[0, 3]], [inner, outer], rtol=3e-3)


def test_uneven_loads_and_a_second_pair_shorten_life() -> None:
    scene = catalogue.scene("lin-case1")
    even = loads(scene, 100.0)
    uneven = even * np.linspace(0.5, 1.5, scene.ball_count)[:, None]
    both = even + even[:, [1, 0, 3, 2]]
    lives = [life(scene, x) for x in (even, uneven, both)]
    assert lives[0] is not None
    assert lives[1] is not None
    assert lives[2] is not None
    assert lives[1].revolutions < lives[0].revolutions
    assert lives[2].revolutions == pytest.approx(lives[0].revolutions * 2.0**-0.9)
    assert life(scene, 0.0 * even) is None


def test_static_safety_at_the_rated_pressure_is_one_and_the_dent_about_a_ten_thousandth() -> None:
    """ISO 76 says of its 4200 MPa that both surfaces together are lastingly dented by about 1e-4 of the ball's diameter."""
    scene = ring(0.15)
    h = nominal_hertz(scene)
    force = float((DENT_PRESSURE / h.pressure(np.ones(4))[0]) ** 3)
    load = loads(scene, force)
    angle = np.where(load > 0.0, 0.0, np.nan)
    worst = worst_contact(scene, load, angle)
    assert worst is not None
    assert worst.side == "SL"
    assert worst.pressure == pytest.approx(1.5 * force / (pi * worst.a * worst.b))
    safety = static_safety(scene, worst)
    assert safety.factor == pytest.approx(1.0)
    assert safety.permanent == pytest.approx(1e-4, rel=0.5)


def test_an_ellipse_over_the_edge_of_the_land_is_cut_and_says_where() -> None:
    scene = small_screw(4)
    load = loads(scene, 100.0)
    angle = np.where(load > 0.0, scene.track.contact_angle, np.nan)
    free = truncation(scene, load, angle)
    assert free is not None
    assert free.cut == 0
    assert free.margin > 0.0
    angle[2, 0] = free.limit - 0.5 * free.half
    over = truncation(scene, load, angle)
    assert over is not None
    assert (over.ball, over.side, over.edge, over.cut) == (3, "SL", "land", 1)
    assert over.margin == pytest.approx(-0.5 * free.half)


def test_contacts_alone_are_Hertz_and_stiffer_under_preload() -> None:
    scene = catalogue.scene("lin-case1")
    h, s = nominal_hertz(scene), slope_of(scene)
    each = 5000.0 / (32 * s)
    closed = (h.C[0] + h.C[3]) * each ** (2 / 3) / s
    assert contacts_displacement(scene, 5000.0) == pytest.approx(closed, rel=1e-9)
    tight = replace(scene, errors=Errors(balls=BallErrors(oversize=7e-6)))
    loose = replace(scene, errors=Errors(balls=BallErrors(oversize=-5e-6)))
    assert contacts_displacement(tight, 5000.0) < 0.6 * closed
    assert contacts_displacement(loose, 5000.0) == pytest.approx(closed, rel=1e-6)


def test_bodies_add_the_displacement_of_thick_tubes_in_the_form_of_ISO_3408_4() -> None:
    """1/R = ((D_1^2 + D_c^2)/(D_1^2 - D_c^2) + (d_c^2 + d_b^2)/(d_c^2 - d_b^2))/(2 pi i P_h E tan^2), one material."""
    scene = catalogue.scene("lin-case1")
    d_c, D_c, D_1, E = 33e-3 - 5.556e-3 * cos(pi / 4), 33e-3 + 5.556e-3 * cos(pi / 4), 48e-3, 210e9
    sum_ = (D_1**2 + D_c**2) / (D_1**2 - D_c**2) + 1.0
    assert d_c > 0.0
    assert body_compliance(scene) == pytest.approx(sum_ / (2 * pi * 2 * 20e-3 * E), rel=1e-9)
    assert body_compliance(ring(0.15)) is None
    found = rigidities(scene, -5000.0, -20e-6)
    assert found is not None
    assert found.bodies is not None
    assert found.contacts > found.bodies
    assert found.unequal == pytest.approx(250e6)
    assert rigidities(scene, 0.0, None) is None
