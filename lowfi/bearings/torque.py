"""Friction torque of ball and tapered roller bearings: Palmgren's and Timken's empirical formulas, in SI units.

Palmgren's constants are written as published, in kg, mm and s, and converted here.

The running torque of a row of balls is M = M_0 + M_1 (`ball_torque`); starting from rest takes twice M_1. Published
coefficients differ by lubrication, series and author, so each torque is a range (low, high):

    M_0 = f_0 (nu n)^(2/3) d_m^3,  M_1 = z (Q/Q_0)^y P_1 d_m.

Q/Q_0 is the largest contact load over the contact force of the static load rating by ISO 76. It replaces P_0/C_0 (Smith
2.36) for any combination of loads. The coefficients z, y and P_1 are in `LOAD`, f_0 in `VISCOUS`.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from rollbench.meshes.quantity import Stated, quantity, record

#: Lowest and highest value of a quantity, in SI units.
Band = tuple[float, float]

#: Kinds of ball rows: circular grooves with thrust in one direction or in both, and gothic-arch grooves.
Kind = Literal["angular contact", "deep groove", "four-point"]

#: One kilogram-force [N].
KILOGRAM_FORCE = 9.80665
#: Kinematic viscosity times speed [mm^2/s rpm] below which M_0 is constant.
LEAST_FILM = 2000.0
_INCH, _POUND = 0.0254, 4.4482216152605

#: Coefficient f_0 by kind of row and of lubrication, after Palmgren (1959; Smith 2.3: 2 for a row with grease), SKF's
#: general catalogue of 1989 and Schaeffler's (as the program Thermca quotes them); (low, high) where they differ or give a
#: range.
VISCOUS: dict[Kind, dict[str, Band]] = {
    "angular contact": {"grease": (2.0, 2.0), "oil mist": (1.0, 1.7), "oil bath": (2.0, 3.3), "oil jet": (4.0, 6.6)},
    "deep groove": {"grease": (0.75, 2.0), "oil mist": (0.7, 1.0), "oil bath": (1.5, 2.0), "oil jet": (3.0, 4.0)},
    "four-point": {"grease": (4.0, 6.0), "oil mist": (2.0, 3.0), "oil bath": (4.0, 6.0), "oil jet": (8.0, 12.0)},
}
#: Coefficients of M_1 by kind of row: z (low, high), exponent y, and factors of thrust and radial load in P_1, which is at
#: least the radial load. Angular contact: z from SKF (radial bearings; thrust bearings above 45 deg) to Palmgren (Smith
#: 2.34). Deep groove: Palmgren to SKF.
LOAD: dict[Kind, tuple[Band, float, tuple[float, float]]] = {
    "angular contact": ((0.0010, 0.0013), 1.0 / 3.0, (1.0, -0.1)),
    "deep groove": ((0.0004, 0.0009), 0.55, (3.0, -0.1)),
    "four-point": ((0.0010, 0.0013), 1.0 / 3.0, (1.5, 3.6)),
}
#: Lowest z of an angular-contact thrust bearing, and the contact angle [rad] above which a bearing is a thrust bearing.
THRUST, RADIAL_UP_TO = 0.0008, np.pi / 4.0
#: Starting torque of a row over M_1 (SKF's general catalogue).
STARTING = 2.0


def viscous_torque(factor: float, pitch_diameter: float, viscosity: float, speed: float) -> float:
    """Return the load-independent friction torque M_0 of a ball bearing [N m].

    M_0 = 1e-8 kg f_0 (nu n)^(2/3) d_m^3 in mm, mm^2/s and rpm. Below nu n = 2000 mm^2/s rpm, where the film is thinner than
    a micrometre, M_0 has the value at 2000 (Palmgren; SKF: 160e-7 f_0 d_m^3 N mm, which is 3 % less).

    Parameters
    ----------
    factor
        Coefficient f_0 of design and lubrication (`VISCOUS`).
    pitch_diameter
        Pitch diameter d_m [m].
    viscosity
        Kinematic viscosity nu [m^2/s].
    speed
        Relative speed n of the rings [rad/s], of any sign.

    References
    ----------
    Palmgren (1959); Smith (1994), 2.32. His 2.31 with the exponent 2/3 (printed 3/2) and atmospheric pressure agrees within
    2 % for oil of 900 kg/m^3.

    Examples
    --------
    f_0 = 2, 40 mm, 20 mm^2/s, 1500 rpm; newer catalogues have 1e-7 N for 1e-8 kg, which gives 12.36 N mm:

    >>> round(viscous_torque(2.0, 40e-3, 20e-6, 1500.0 * np.pi / 30.0) * 1e3, 2)  # N mm
    12.12
    """
    film = max(1e6 * viscosity * abs(speed) * 30.0 / np.pi, LEAST_FILM)
    return float(1e-8 * KILOGRAM_FORCE * 1e-3 * factor * film ** (2.0 / 3.0) * (1e3 * pitch_diameter) ** 3)


@record
class BallTorque:
    """Friction torque of a row of balls [N m], as a range (low, high) given by the published coefficients."""

    #: Load-dependent part M_1 as (low, high) [N m].
    load: Band = quantity(
        "load_Nmm",
        "load-dependent part M1 = z (Q/Q0)^y P1 dm, from the computed loads; lowest and highest published z",
        error="empirical",
        parts="[]",
    )
    #: Part M_0 that depends on lubricant and speed, as (low, high) [N m]; None without lubricant or speed.
    viscous: Band | None = quantity(
        "viscous_Nmm",
        "part M0 = f0 (nu n)^(2/3) dm^3 that depends on lubricant and speed; lowest and highest published f0; null without "
        "[lubricant] or [motion]",
        error="empirical",
        parts="[]",
    )
    #: Torque that starts the row from rest, twice M_1, as (low, high) [N m].
    starting: Band = quantity(
        "starting_Nmm",
        "torque that starts the row from rest: twice the load-dependent part",
        error="empirical",
        parts="[]",
        heading="friction torque from rest",
        form="g3",
        note="lowest to highest coefficients (Palmgren)",
    )

    @property
    @Stated(
        "running_Nmm",
        "torque of the running row: M0 + M1, without seals",
        error="empirical",
        parts="[]",
        heading="friction torque, running",
        form="g3",
    )
    def running(self) -> Band | None:
        """Torque of the running row M_0 + M_1, as (low, high) [N m]; None without lubricant or speed."""
        return None if self.viscous is None else (self.load[0] + self.viscous[0], self.load[1] + self.viscous[1])


def ball_torque(
    kind: Kind, angle: float, pitch_diameter: float, loads: tuple[float, float, float], viscous: Band | None
) -> BallTorque:
    """Return the friction torque of a row of balls between rings that turn against each other.

    Validity: the coefficients were measured on catalogue bearings that are run in and not freshly greased, at loads up to
    the static load rating. Fresh grease needs more torque.

    Parameters
    ----------
    kind
        Design of the row.
    angle
        Nominal contact angle [rad].
    pitch_diameter
        Pitch diameter d_m [m].
    loads
        Thrust of all balls, with preload [N]; radial load [N]; largest contact load over that of the static rating, Q/Q_0.
    viscous
        Load-independent torque M_0 as (low, high) [N m]; None without lubricant or speed.

    References
    ----------
    Palmgren (1959); SKF general catalogue (1989); Smith (1994), 2.3 and 2.34.

    Examples
    --------
    An angular-contact row at 1 kN thrust, Q/Q_0 = 1/8, d_m = 40 mm: 0.001 to 0.0013 times 0.5 times 40 N m.

    >>> [round(x * 1e3, 6) for x in ball_torque("angular contact", np.pi / 6, 40e-3, (1e3, 0.0, 0.125), None).load]  # N mm
    [20.0, 26.0]
    """
    (low, high), power, (axial, across) = LOAD[kind]
    thrust, radial, share = loads
    if kind == "angular contact" and angle > RADIAL_UP_TO + 1e-9:
        low = THRUST
    one = share**power * max(axial * thrust + across * radial, radial) * pitch_diameter
    load = low * one, high * one
    return BallTorque(load, viscous, (STARTING * load[0], STARTING * load[1]))


@record
class LoadTorque:
    """Load-dependent torque of a ball bearing, with the factors from which it is computed."""

    #: Torque M_1 [N m].
    torque: float = quantity(
        "torque_Nmm",
        "starting torque of one bearing under its preload, by Palmgren's load formula M = f1 F dm (Smith 2.33 to 2.38), "
        "without lubricant and seals",
        error="empirical",
    )
    #: Factor f_1.
    factor: float = quantity("factor", "factor f1 = 0.0013 (P0/C0)^(1/3) of that torque")
    #: Static equivalent load P_0 [N].
    equivalent_load: float = quantity("equivalent_load_N", "static equivalent load P0 of the bearing")
    #: Static load rating C_0 [N].
    rating: float = quantity("static_rating_N", "static load rating C0 of the bearing by Palmgren's formula")


def static_rating(rows: int, balls: int, ball_diameter: float, angle: float, across: float, along: float) -> float:
    """Return Palmgren's static load rating of a ball bearing, C_0 = k_0 i Z sin(alpha) D^2 [N].

    Here k_0 = 2.8 kg/mm^2/(D sqrt(product of the relative curvatures across and along the track)).

    Parameters
    ----------
    rows, balls
        Number i of rows, and number Z of balls in a row.
    ball_diameter
        Ball diameter D [m].
    angle
        Contact angle alpha [rad].
    across, along
        Relative curvatures of the inner contact across the groove and along the track [1/m].

    References
    ----------
    Smith (1994), 2.36 and 2.37, where (rho_11 + rho_12)(rho_21 + rho_22) is printed, which is negative.
    """
    k = 2.8 * KILOGRAM_FORCE * 1e6 / (ball_diameter * np.sqrt(across * along))
    return float(k * rows * balls * np.sin(angle) * ball_diameter**2)


def load_torque(
    axial: float, radial: float, pitch_diameter: float, rating: float, *, axial_factor: float = 0.3
) -> LoadTorque:
    """Return the load-dependent friction torque M_1 = f_1 g_1 P_0 d_m of a ball bearing.

    f_1 = 0.0013 (P_0/C_0)^(1/3) is for contact angles of about 60 deg. g_1 P_0 is taken as F_a, so that Y_0 has an
    influence only through f_1.

    Parameters
    ----------
    axial, radial
        Static loads F_a and F_r [N].
    pitch_diameter
        Pitch diameter d_m [m].
    rating
        Static load rating C_0 [N].
    axial_factor
        Factor Y_0 of the static equivalent load P_0 = 0.5 F_r + Y_0 F_a.

    References
    ----------
    Smith (1994), 2.33 to 2.38.

    Examples
    --------
    >>> round(load_torque(1e3, 0.0, 40e-3, 2.4e3).torque * 1e3, 6)  # 0.0013/2 times 40 N m, in N mm
    26.0
    """
    equivalent = 0.5 * radial + axial_factor * axial
    factor = 0.0013 * float(np.cbrt(equivalent / rating))
    return LoadTorque(factor * axial * pitch_diameter, factor, equivalent, rating)


def taper_torque(geometry: float, viscosity: float, speed: float, axial: float) -> float:
    """Return the running torque of a tapered roller bearing under thrust by Timken's formula [N m].

    The formula is 3.54e-5 G_1 (n mu)^0.62 F_a^0.30 in-lb, in rpm, cP and lb. It is valid for run-in bearings in circulating
    oil, and too low at speeds below 1700 F_a^0.67/(G_2 mu) rpm in lb and cP (Smith 1994, eq. 3.30).

    Parameters
    ----------
    geometry
        Timken's bearing factor G_1, from the manufacturer.
    viscosity
        Dynamic viscosity mu [Pa s].
    speed
        Relative speed n of the rings [rad/s].
    axial
        Thrust F_a [N].

    References
    ----------
    Timken; Smith (1994), 3.29.

    Examples
    --------
    >>> round(taper_torque(30.0, 20e-3, 1000.0 * np.pi / 30.0, 2e3), 4)
    0.348
    """
    rpm_centipoise = 1e3 * viscosity * speed * 30.0 / np.pi
    pounds = 3.54e-5 * geometry * rpm_centipoise**0.62 * (axial / _POUND) ** 0.30
    return float(pounds * _INCH * _POUND)


def taper_geometry(torque: float, viscosity: float, speed: float, axial: float) -> float:
    """Return Timken's bearing factor G_1 from a running torque that a manufacturer's curve or a test gives.

    This is the inverse of `taper_torque`.

    Parameters
    ----------
    torque
        Running torque [N m].
    viscosity
        Dynamic viscosity mu [Pa s].
    speed
        Relative speed n of the rings [rad/s].
    axial
        Thrust F_a [N].
    """
    return torque / taper_torque(1.0, viscosity, speed, axial)
