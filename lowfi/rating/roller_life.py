"""Fatigue life L10 and load ratings of rows of tapered rollers by ISO 281 and ISO 76.

The capacity Q_c of a line contact by Lundberg and Palmgren (ISO/TR 1281-1), with lengths in mm, forces in N, gamma = D
cos(alpha)/D_pw, the upper sign for the inner race, the roller's mean diameter D and effective length L, the pitch diameter
D_pw, Z rollers, and the cup's half angle alpha, is

    Q_c = 551.13 b_m lambda (1 -+ gamma)^(29/27)/(1 +- gamma)^(1/4) (gamma/cos(alpha))^(2/9)
          D^(29/27) L^(7/9) Z^(-1/4),                                                                                   (1)

with b_m = 1.1 for cylindrical and tapered rollers. The factor lambda accounts for edge stress and non-uniform load: it is
0.83 for radial bearings (alpha up to 45 deg) and 0.73 (1 - 0.15 sin(alpha)) for thrust bearings (above). The ratings of one
row are

    C_r = 0.377 Z cos(alpha) Q_ci (1 + (1.04 ((1 - gamma)/(1 + gamma))^(143/108))^(9/2))^(-2/9)
        = b_m f_c (L cos(alpha))^(7/9) Z^(3/4) D^(29/27),                                                               (2)
    C_a = Z sin(alpha) (Q_ci^(-9/2) + Q_ce^(-9/2))^(-2/9).

The life L10 is (C/P)^(10/3) with the equivalent load P of one row under radial and axial force (ISO 281): P = F_r for
F_a up to e F_r, e = 1.5 tan(alpha), otherwise 0.4 F_r + 0.4 cot(alpha) F_a; above 45 deg P = tan(alpha) F_r + F_a. The
life L10r under the loads of every slice of every roller is in `lowfi.rating.iso_lives`. For several load cases the mean of
order 4 is taken at every position of a race, as in `lowfi.rating.life` (4).

Static ratings (ISO 76): Q_0 is the force at which the middle of the cone's contact has a pressure of 4,000 MPa;
C_0r = Z Q_0 cos(alpha)/5, C_0a = Z Q_0 sin(alpha).

Valid for rollers of hardened bearing steel with profiled ends that touch their ribs, full lubrication, and no plastic
contact; factors for material, reliability and lubricant are one. The ratings are computed and not those of a manufacturer.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, degrees, hypot, pi, sin, tan

import numpy as np

from rollbench.lowfi.hertz import contact_modulus
from rollbench.lowfi.rating.contacts import STRIBECK, Ratings
from rollbench.lowfi.rating.life import RADIAL_UP_TO, Life, by_maker, mean_force
from rollbench.lowfi.rollers import tapered_bearing_of_row
from rollbench.lowfi.statics.validity import ROLLER_DENT_PRESSURE
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import RollerRow

#: Constant of (1) for mm and N; rating factor of contemporary steel; reduction factors of radial and of thrust bearings.
CONTACT, STEEL, RADIAL, THRUST = 551.13, 1.1, 0.83, 0.73

#: Weibull slope of the life of line contacts; orders of the mean load for a race that rotates relative to the load and for
#: a stationary race.
SLOPE, TURNING, STANDING = 9.0 / 8.0, 4.0, 4.5

#: Exponent of the ratio of load rating to equivalent load in the life.
EXPONENT = 10.0 / 3.0


def is_thrust_bearing_row(row: RollerRow) -> bool:
    """Return whether a row of tapered rollers is rated as a thrust bearing: its cup has a half angle above 45 deg."""
    return degrees(row.cup_angle) > RADIAL_UP_TO + 1e-9


def race_capacities(row: RollerRow) -> Array:
    """Return the capacities Q_c of a roller's contacts with inner and outer race, for 10^6 revolutions ``(2,)`` [N].

    They follow from eq. (1) of this module.
    """
    alpha, D, length = row.cup_angle, 1e3 * row.diameter, 1e3 * row.length
    gamma = row.diameter * cos(alpha) / tapered_bearing_of_row(row).pitch_diameter
    reduced = THRUST * (1.0 - 0.15 * sin(alpha)) if is_thrust_bearing_row(row) else RADIAL
    sign = np.array([-1.0, 1.0])
    curve = (1.0 + sign * gamma) ** (29.0 / 27.0) / (1.0 - sign * gamma) ** 0.25
    size = (gamma / cos(alpha)) ** (2.0 / 9.0) * D ** (29.0 / 27.0) * length ** (7.0 / 9.0) * row.count**-0.25
    return np.asarray(STEEL * CONTACT * reduced * curve * size)


def dynamic_rating_of_row(row: RollerRow) -> float:
    """Return the basic dynamic load rating C of a row of rollers by eq. (2) of this module.

    Parameters
    ----------
    row
        Row of tapered rollers; its pitch diameter follows from the angles of cup and rollers.

    Returns
    -------
    float
        C [N]: radial for a cup's half angle up to 45 deg, axial above.

    References
    ----------
    ISO 281; ISO/TR 1281-1. The factor f_c in eq. (2) agrees with the table of ISO 281 for radial roller bearings within
    0.2 %.

    Examples
    --------
    >>> from math import radians
    >>> from rollbench.meshes.parts import Material
    >>> row = RollerRow(16, 12e-3, 16e-3, radians(15.0), radians(2.5), 8e-3, Material(206e9, 0.3))
    >>> pitch_diameter = tapered_bearing_of_row(row).pitch_diameter
    >>> round(pitch_diameter * 1e3, 2), round(dynamic_rating_of_row(row)), round(static_rating_of_row(row))
    (59.49, 94723, 105724)
    """
    inner, outer = (float(Q) for Q in race_capacities(row))
    if is_thrust_bearing_row(row):
        return row.count * sin(row.cup_angle) * float((inner**-4.5 + outer**-4.5) ** (-2.0 / 9.0))
    gamma = row.diameter * cos(row.cup_angle) / tapered_bearing_of_row(row).pitch_diameter
    both = 1.0 + (1.04 * ((1.0 - gamma) / (1.0 + gamma)) ** (143.0 / 108.0)) ** 4.5
    return 0.377 * row.count * cos(row.cup_angle) * inner * float(both ** (-2.0 / 9.0))


def static_rating_of_row(row: RollerRow) -> float:
    """Return the basic static load rating C_0 of a row of tapered rollers (ISO 76).

    It is the load at which the most heavily loaded roller has a pressure of 4,000 MPa at the middle of its contact with the
    cone. Under a radial load that roller carries five times the mean load (Stribeck).

    Returns
    -------
    float
        C_0 [N]: radial for a cup's half angle up to 45 deg, axial above.
    """
    bearing, E, nu = tapered_bearing_of_row(row), row.material.youngs_modulus, row.material.poissons_ratio
    roller, cone, _ = bearing.curvature_radii()
    curvature = float(1.0 / roller + 1.0 / cone)
    line = pi * ROLLER_DENT_PRESSURE**2 / (contact_modulus(E, nu, E, nu) * curvature)
    each = row.count * line * row.length
    return each * sin(row.cup_angle) if is_thrust_bearing_row(row) else each * cos(row.cup_angle) / STRIBECK


def dynamic_and_static_ratings_of_row(row: RollerRow) -> Ratings:
    """Return the dynamic and static load ratings of a row of tapered rollers.

    Parameters
    ----------
    row
        Row of rollers.
    """
    thrust, maker = is_thrust_bearing_row(row), row.rating
    standard = "ISO 281" + (" (thrust bearing)" if thrust else "")
    return Ratings(
        dynamic_rating_of_row(row), static_rating_of_row(row), thrust, standard, "ISO 76", maker.dynamic, maker.static
    )


def equivalent_load_of_row(row: RollerRow, radial: float, axial: float) -> float:
    """Return the dynamic equivalent load P of a row of tapered rollers under radial and axial force (ISO 281).

    Parameters
    ----------
    row
        Row of tapered rollers.
    radial, axial
        Forces [N], not negative.

    Returns
    -------
    float
        P [N]: radial for a cup's half angle up to 45 deg, axial above.

    Examples
    --------
    >>> from math import radians
    >>> from rollbench.meshes.parts import Material
    >>> row = RollerRow(16, 12e-3, 16e-3, radians(15.0), radians(2.5), 8e-3, Material(206e9, 0.3))
    >>> equivalent_load_of_row(row, 1e3, 400.0), round(equivalent_load_of_row(row, 1e3, 2e3), 1)
    (1000.0, 3385.6)
    """
    if is_thrust_bearing_row(row):
        return tan(row.cup_angle) * radial + axial
    if axial <= 1.5 * tan(row.cup_angle) * radial:
        return radial
    return 0.4 * radial + 0.4 / tan(row.cup_angle) * axial


def life_of_row_by_equivalent_loads(row: RollerRow, shares: Sequence[float], forces: Sequence[Array]) -> Life | None:
    """Return the life L10 of a row of tapered rollers by the equivalent loads of one or several load cases (ISO 281).

    Parameters
    ----------
    row
        Row of tapered rollers.
    shares
        Fractions of the revolutions in each case, with the sum 1.
    forces
        For each load case the force of the shaft on the row along x, y, z ``(3,)`` [N].

    Returns
    -------
    Life | None
        Life (C/P_m)^(10/3) with the dynamic load rating C, and the mean P_m of order 10/3 of the equivalent loads; None
        without load.
    """
    loads = np.array([equivalent_load_of_row(row, hypot(F[0], F[1]), abs(float(F[2]))) for F in forces])
    mean, C = mean_force(np.asarray(shares), loads, EXPONENT), dynamic_rating_of_row(row)
    if mean <= 0.0:
        return None
    found, standard = (C / mean) ** EXPONENT, dynamic_and_static_ratings_of_row(row).dynamic_standard
    return Life(found, {}, C, mean, standard, revolutions_by_maker=by_maker(row, C, found, EXPONENT))
