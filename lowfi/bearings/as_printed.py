"""Approximations and errors of Smith (1994) exactly as printed, to show their effect; no other model uses them.

Units are Smith's (curvatures 1/mm, K in N/mm^1.5, or lb and in), because his constants contain them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rollbench.meshes.arrays import Array
from rollbench.meshes.numerics import brentq

#: Constant of Smith's 2.8 in the spreadsheet of figure 2-10 [N/mm^2] (the printed 3.12e7 in lb and in is 2.151e5).
LOAD_CONSTANT = 2.15e5
#: Reciprocal of the exponent 1.5 in Smith's 2.7: the spreadsheet's K_n follows to all digits with this value, not with 2/3.
SHEET_EXPONENT = 0.66666
#: Coefficients of the fits 2.18 (approach), 2.25 (major axis), 2.26 (minor axis) in powers of (-log10 F)^(2/3).
FITS = {
    "approach": (0.13013, 12.787, -148.46, 956.25, -2925.8, 3346.3),
    "major": (0.71288, 14.701, -49.315, 158.98, -190.41, 99.340),
    "minor": (1.0689, 55.224, -366.71, 2007.3, -3894.5, 3192.6),
}


def hertz_parameter_by_smith_polynomial(curvature_difference: float, quantity: str) -> float:
    """Return the dimensionless approach delta* or semi-axis a* or b* of Hertz contact by Smith's fitted polynomials.

    delta* is within 2 % of the exact value only for curvature differences F between 0.68 and 0.962, where the minor
    semi-axis b* is 39 to 42 % too large.

    Parameters
    ----------
    curvature_difference
        Curvature difference F, which is already divided by the sum of the curvatures (`curvature_difference`).
    quantity
        ``"approach"`` for delta*, ``"major"`` for a*, ``"minor"`` for b*.

    References
    ----------
    Smith (1994), 2.18, 2.25 and 2.26, here as polynomials with the powers 1 to 5, as Smith must have meant. In print, 2.25
    has a square in place of the first power, and 2.18 has the coefficient -148.46 as an exponent.
    """
    x = (-np.log10(curvature_difference)) ** (2.0 / 3.0)
    value = float(np.polyval(FITS[quantity][::-1], x))
    if quantity == "approach":
        return value
    return float(10.0 ** (1.0 / value if quantity == "major" else -1.0 / value))


def curvature_difference(curvatures: Sequence[float]) -> float:
    """Return the curvature difference F of a contact (Smith 1994, eq. 2.16) from its four principal curvatures.

    F = |(rho_11 - rho_12) + (rho_21 - rho_22)| divided by the sum of all four. The absolute value is taken here; the
    publication prints the formula without it.
    """
    a, b, c, d = curvatures
    return abs((a - b) + (c - d)) / (a + b + c + d)


@dataclass(frozen=True)
class SmithSpreadsheetValues:
    """Values in the cells of Smith's spreadsheet for a ball bearing (figure 2-10); pairs are for (inner, outer) race."""

    #: Sums of the four principal curvatures at the contacts [1/mm].
    curvature_sums: tuple[float, float]
    #: Curvature differences F, which are already divided by the curvature sum.
    curvature_differences: tuple[float, float]
    #: Dimensionless Hertz approaches delta*.
    dimensionless_approaches: tuple[float, float]
    #: Load constant K of each race in Q = K delta^1.5 [N/mm^1.5].
    race_load_constants: tuple[float, float]
    #: Load constant K_n of both races in series, in Q = K_n delta^1.5 [N/mm^1.5].
    load_constant: float
    #: Contact angle under load [rad].
    contact_angle: float
    #: Contact load of a ball [N].
    ball_load: float
    #: Axial deflection of the bearing [mm].
    deflection: float


def compute_smith_spreadsheet(
    load: float,
    balls: int,
    diameter: float,
    grooves: tuple[float, float],
    raceways: tuple[float, float],
    outer_difference: float | None = None,
) -> SmithSpreadsheetValues:
    """Compute the values of the spreadsheet of Smith's figure 2-10 for an axial load on a ball bearing.

    Parameters
    ----------
    load
        Axial load [N].
    balls
        Number of balls.
    diameter
        Ball diameter [mm].
    grooves, raceways
        Groove radii and raceway diameters (inner, outer) [mm].
    outer_difference
        Curvature difference F of the outer race as printed in the spreadsheet, although the geometry gives another value;
        None: computed from the geometry.
    """
    d, dm, b = diameter, 0.5 * sum(raceways), sum(grooves) - diameter
    rest = float(np.arccos(1.0 - 0.5 * (raceways[1] - raceways[0] - 2.0 * d) / b))

    def spreadsheet_values(angle: float) -> SmithSpreadsheetValues:
        """Return the values of all cells of the spreadsheet for a contact angle under load [rad]."""
        path = dm / np.cos(angle)
        four = (
            (-1.0 / grooves[0], 2.0 / (path - d), 2.0 / d, 2.0 / d),
            (2.0 / d, 2.0 / d, -1.0 / grooves[1], -2.0 / (path + d)),
        )
        sums = (float(sum(four[0])), float(sum(four[1])))
        outer = curvature_difference(four[1]) if outer_difference is None else outer_difference
        differences = (curvature_difference(four[0]), outer)
        inner, outer = (hertz_parameter_by_smith_polynomial(F, "approach") for F in differences)
        race = LOAD_CONSTANT * sums[0] ** -0.5 * inner**-1.5, LOAD_CONSTANT * sums[1] ** -0.5 * outer**-1.5
        both = (race[0] ** -SHEET_EXPONENT + race[1] ** -SHEET_EXPONENT) ** -1.5
        moved = b * float(np.sin(angle - rest)) / float(np.cos(angle))
        q = load / (balls * float(np.sin(angle)))
        return SmithSpreadsheetValues(sums, differences, (inner, outer), race, both, angle, q, moved)

    def ball_load_above_deflection_load(angle: float) -> float:
        """Return the ball load by equilibrium with the thrust less that by Hertz's law [N], for a contact angle [rad]."""
        state = spreadsheet_values(angle)
        return state.ball_load - state.load_constant * float((b * (np.cos(rest) / np.cos(angle) - 1.0)) ** 1.5)

    return spreadsheet_values(float(brentq(ball_load_above_deflection_load, rest + 1e-9, 0.5 * np.pi - 1e-3, xtol=1e-14)))


def bearing_row_loads_as_printed(loads: Sequence[float], directions: Sequence[int], force: float) -> Array:
    """Return the loads of bearing rows under an external force [N] by Smith's method, which counts the force twice.

    Smith adds the whole force to the rows that resist it and also subtracts it from the opposite rows, so that the rows
    together resist twice the force. When he computes the stretch of a screw, he lets only half of the force act at each
    end, so that the two errors cancel.

    Parameters
    ----------
    loads
        Loads of the rows by preload alone [N].
    directions
        Direction of each row's thrust, 1 or -1.
    force
        External force [N].

    References
    ----------
    Smith (1994), 2.1.2 and the table of 4.2.
    """
    s = np.array(directions)
    count = np.array([np.sum(s == d) for d in s])
    return np.asarray(np.array(loads, dtype=float) + s * force / count)


def axis_stiffness_as_printed(supports: Sequence[float], screw: float, nut: float) -> float:
    """Return the axial stiffness of a ball-screw axis with supports, whole screw and nut in series (Smith 1994, eq. 4.6).

    The result has the unit of the arguments.

    Parameters
    ----------
    supports
        Stiffnesses of both supports.
    screw
        Stiffness of the whole screw.
    nut
        Stiffness of the nut.
    """
    return 1.0 / (sum(1.0 / k for k in supports) + 1.0 / screw + 1.0 / nut)


def roller_approach_as_printed(line_load: float, diameter: float, cup_angle: float, roller_angle: float) -> float:
    """Return the approach of inner and outer race across a roller, along the contact normal [in] (Smith 1994, eq. 3.19).

    The logarithm has the base 10. The factor 8.89e-8 is 4 (1 - nu^2)/(pi E) ln 10 for steel, from the law of two line
    contacts. The logarithm's argument has a dimension, 1/(length times line load), so the formula does not scale: a bearing
    of twice the size at the same pressure does not have twice the deflection.

    Parameters
    ----------
    line_load
        Load per length [lb/in].
    diameter
        Roller diameter [in].
    cup_angle, roller_angle
        Half included angles of cup and roller [rad].
    """
    argument = np.sin(roller_angle) / (diameter * line_load * np.sin(cup_angle))
    return float(8.89e-8 * line_load * (8.45 + np.log10(argument)))


def roller_contact_as_printed(
    axial: float, rollers: int, length: float, diameter: float, pitch_diameter: float, cone_angle: float
) -> tuple[float, float, float, float]:
    """Compute the contact of a tapered roller with the inner race by eqs. 3.23 to 3.28 of Smith (1994), errors included.

    Parameters
    ----------
    axial
        Thrust [lb].
    rollers
        Number of rollers.
    length, diameter, pitch_diameter
        Contact length, roller diameter and pitch diameter [in].
    cone_angle
        Half included angle of the cone [rad].

    Returns
    -------
    tuple
        Contact load of the roller [lb], half-width [in] and area [in^2] of the line contact, largest pressure [psi].
    """
    q = axial / (rollers * np.sin(cone_angle))
    curvature = 1.0 / (diameter * (1.0 - diameter * np.cos(cone_angle) / pitch_diameter))
    b = 0.000278 * np.sqrt(q / (length * curvature))
    return float(q), float(b), float(0.5 * length * b), float(2.0 * q / (np.pi * length * b))
