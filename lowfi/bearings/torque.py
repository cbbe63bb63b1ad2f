"""Friction torque of ball and tapered roller bearings: Palmgren's and Timken's empirical formulas, in SI units.

Palmgren's constants come from units of kg, mm and s; they are kept as published and converted here.

A row of balls in general, `ball_torque`: M = M_0 + M_1, and twice M_1 to start it from rest. Published coefficients differ
by lubrication, series and author, so each torque is a range (low, high):

    M_0 = f_0 (nu n)^(2/3) d_m^3,  M_1 = z (Q/Q_0)^y P_1 d_m.

Q/Q_0 is the largest contact force over the force at which ISO 76 rates the contact, which is what P_0/C_0 means (Smith
2.36), whatever loads the row. z, y and P_1 are those of `LOAD`, f_0 of `VISCOUS`.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from rollbench.meshes.quantity import Stated, quantity, record

#: Lowest and highest value [SI].
Band = tuple[float, float]

#: Kinds of rows: one arc per groove with thrust in one direction, one arc with thrust in both, gothic grooves.
Kind = Literal["angular contact", "deep groove", "four-point"]

#: One kilogram-force [N].
KILOGRAM_FORCE = 9.80665
#: Kinematic viscosity times speed [mm^2/s rpm] below which the film no longer grows, and M_0 stays as it is there.
LEAST_FILM = 2000.0
_INCH, _POUND = 0.0254, 4.4482216152605

#: f_0 by kind and by how lubricant gets there: Palmgren (1959; Smith 2.3: 2 for a row with grease), SKF's general catalogue
#: of 1989 and Schaeffler's (as the program Thermca quotes them); low and high where they differ or give a range.
VISCOUS: dict[Kind, dict[str, Band]] = {
    "angular contact": {"grease": (2.0, 2.0), "oil mist": (1.0, 1.7), "oil bath": (2.0, 3.3), "oil jet": (4.0, 6.6)},
    "deep groove": {"grease": (0.75, 2.0), "oil mist": (0.7, 1.0), "oil bath": (1.5, 2.0), "oil jet": (3.0, 4.0)},
    "four-point": {"grease": (4.0, 6.0), "oil mist": (2.0, 3.0), "oil bath": (4.0, 6.0), "oil jet": (8.0, 12.0)},
}
#: z, low and high, y, and P_1 by thrust and radial load, no less than the radial load. Angular contact: z from SKF, of
#: radial bearings and above 45 deg of thrust bearings, to Palmgren (Smith 2.34). Deep groove: Palmgren to SKF.
LOAD: dict[Kind, tuple[Band, float, tuple[float, float]]] = {
    "angular contact": ((0.0010, 0.0013), 1.0 / 3.0, (1.0, -0.1)),
    "deep groove": ((0.0004, 0.0009), 0.55, (3.0, -0.1)),
    "four-point": ((0.0010, 0.0013), 1.0 / 3.0, (1.5, 3.6)),
}
#: Lowest z of an angular-contact row that is a thrust bearing, and the angle [rad] above which it is.
THRUST, RADIAL_UP_TO = 0.0008, np.pi / 4.0
#: Torque that starts a row from rest over M_1 (SKF's general catalogue).
STARTING = 2.0


def viscous_torque(factor: float, pitch_diameter: float, viscosity: float, speed: float) -> float:
    """Return the load-independent torque M_0 of a ball bearing, 1e-8 kg f_0 (nu n)^(2/3) d_m^3 in mm, mm^2/s and rpm [N m].

    Below nu n = 2000 mm^2/s rpm, where the film is under a micrometre, M_0 keeps its value there (Palmgren; SKF:
    160e-7 f_0 d_m^3 N mm, which is 3 % less).

    Parameters
    ----------
    factor
        f_0, for design and lubrication (`VISCOUS`).
    pitch_diameter
        d_m [m].
    viscosity
        Kinematic viscosity nu [m^2/s].
    speed
        [rad/s], of any sign.

    References
    ----------
    Palmgren (1959); Smith (1994), 2.32. His 2.31 with the exponent 2/3 (printed 3/2) and atmospheric pressure agrees within
    2 % for oil of 900 kg/m^3.

    Examples
    --------
    f_0 = 2, 40 mm, 20 mm^2/s, 1500 rpm; with 1e-7 N for 1e-8 kg, as newer catalogues have it, 12.36 N mm:

    >>> round(viscous_torque(2.0, 40e-3, 20e-6, 1500.0 * np.pi / 30.0) * 1e3, 2)  # N mm
    12.12
    """
    film = max(1e6 * viscosity * abs(speed) * 30.0 / np.pi, LEAST_FILM)
    return float(1e-8 * KILOGRAM_FORCE * 1e-3 * factor * film ** (2.0 / 3.0) * (1e3 * pitch_diameter) ** 3)


@record
class BallTorque:
    """Friction torque of a row of balls, each as (low, high) of the published coefficients [N m]."""

    #: Part M_1 of the load.
    load: Band = quantity(
        "load_Nmm",
        "part M1 of the load: z (Q/Q0)^y P1 dm, of the loads as solved; lowest and highest published z",
        error="empirical",
        parts="[]",
    )
    #: Part M_0 of the lubricant; None without lubricant or speed.
    viscous: Band | None = quantity(
        "viscous_Nmm",
        "part M0 of the lubricant: f0 (nu n)^(2/3) dm^3, lowest and highest published f0; null without [lubricant] or "
        "[motion]",
        error="empirical",
        parts="[]",
    )
    #: Torque that starts the row from rest.
    starting: Band = quantity(
        "starting_Nmm",
        "torque that starts it from rest: twice the part of the load",
        error="empirical",
        parts="[]",
        heading="friction torque from rest",
        form="g3",
        note="lowest to highest coefficients (Palmgren)",
    )

    @property
    @Stated(
        "running_Nmm",
        "torque while it runs: M0 + M1, without seals",
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

    Range: measured on catalogue bearings under loads of up to a static safety of one, run in, shortly after greasing; fresh
    grease takes more.

    Parameters
    ----------
    kind
        Design of the row.
    angle
        Nominal contact angle [rad].
    pitch_diameter
        d_m [m].
    loads
        Thrust of all balls with preload [N], radial load [N], and the largest contact force over the rated one Q/Q_0.
    viscous
        M_0 as (low, high) [N m], or None.

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
    """Load-dependent torque of a ball bearing with what it follows from."""

    #: M_1 [N m].
    torque: float = quantity(
        "torque_Nmm",
        "starting torque of one bearing under its preload, by Palmgren's load formula M = f1 F dm (Smith 2.33 to 2.38), "
        "without lubricant and seals",
        error="empirical",
    )
    #: f_1.
    factor: float = quantity("factor", "its f1 = 0.0013 (P0/C0)^(1/3)")
    #: Static equivalent load P_0 [N].
    equivalent_load: float = quantity("equivalent_load_N", "its static equivalent load P0")
    #: Static load rating C_0 [N].
    rating: float = quantity("static_rating_N", "its static rating C0 by Palmgren's formula")


def static_rating(rows: int, balls: int, ball_diameter: float, angle: float, across: float, along: float) -> float:
    """Return Palmgren's static load rating C_0 = k_0 i Z sin(alpha) D^2 [N], k_0 = 2.8 kg/mm^2/(D sqrt(across along)).

    Parameters
    ----------
    rows, balls
        Numbers of rows i and of balls in a row Z.
    ball_diameter
        D [m].
    angle
        Contact angle [rad].
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
    """Return the load-dependent torque M_1 = f_1 g_1 P_0 d_m of a ball bearing.

    f_1 = 0.0013 (P_0/C_0)^(1/3), for contact angles of about 60 deg; g_1 P_0 = F_a, so that Y_0 enters by f_1 only.

    Parameters
    ----------
    axial, radial
        Static loads F_a and F_r [N].
    pitch_diameter
        d_m [m].
    rating
        Static load rating C_0 [N].
    axial_factor
        Y_0 of P_0 = 0.5 F_r + Y_0 F_a.

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
    """Return the running torque of a tapered roller bearing under thrust, 3.54e-5 G_1 (n mu)^0.62 F_a^0.30 in in-lb [N m].

    Range: run-in bearings in circulating oil; too low below 1700 F_a^0.67/(G_2 mu) rpm in lb and cP (Smith 3.30).

    Parameters
    ----------
    geometry
        The manufacturer's factor G_1.
    viscosity
        Dynamic viscosity mu [Pa s].
    speed
        [rad/s].
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
    """Return the factor G_1 that a running torque [N m] implies, for a manufacturer's curve or a test.

    The inverse of `taper_torque`, with the same arguments.

    Parameters
    ----------
    torque
        Running torque [N m].
    viscosity
        Kinematic viscosity, as `taper_torque` takes it.
    speed
        Speed of the shaft, as `taper_torque` takes it.
    axial
        Thrust [N].
    """
    return torque / taper_torque(1.0, viscosity, speed, axial)
