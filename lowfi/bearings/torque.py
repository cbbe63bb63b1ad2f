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

#: Kinds of rows: of one arc a groove that carries thrust one way, of one that carries it both ways, of gothic grooves.
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
    """Load-independent torque M_0 [N m] of a ball bearing: 1e-8 kg f_0 (nu n)^(2/3) d_m^3 in mm, mm^2/s, rpm (Smith 2.32).

    factor: f_0, design and lubrication; pitch_diameter [m]; viscosity: kinematic [m^2/s]; speed [rad/s], of any sign.
    His 2.31 with the exponent 2/3 (printed 3/2) and atmospheric pressure agrees to 2 % for oil of 900 kg/m^3. Below nu n =
    2000 mm^2/s rpm, where the film is under a micron, M_0 keeps its value there (Palmgren; SKF: 160e-7 f_0 d_m^3 N mm,
    which is 3 % less).
    """
    film = max(1e6 * viscosity * abs(speed) * 30.0 / np.pi, LEAST_FILM)
    return float(1e-8 * KILOGRAM_FORCE * 1e-3 * factor * film ** (2.0 / 3.0) * (1e3 * pitch_diameter) ** 3)


@record
class BallTorque:
    """Friction torque of a row of balls, each (low, high) [N m]; viscous and running None without lubricant or speed."""

    load: Band = quantity(
        "load_Nmm",
        "part M1 of the load: z (Q/Q0)^y P1 dm, of the loads as solved; lowest and highest published z",
        error="empirical",
        parts="[]",
    )
    viscous: Band | None = quantity(
        "viscous_Nmm",
        "part M0 of the lubricant: f0 (nu n)^(2/3) dm^3, lowest and highest published f0; null without [lubricant] or "
        "[motion]",
        error="empirical",
        parts="[]",
    )
    starting: Band = quantity(
        "starting_Nmm", "torque that starts it from rest: twice the part of the load", error="empirical", parts="[]"
    )

    @property
    @Stated("running_Nmm", "torque while it runs: M0 + M1, without seals", error="empirical", parts="[]")
    def running(self) -> Band | None:
        """M_0 + M_1 [N m]."""
        return None if self.viscous is None else (self.load[0] + self.viscous[0], self.load[1] + self.viscous[1])


def ball_torque(
    kind: Kind, angle: float, pitch_diameter: float, loads: tuple[float, float, float], viscous: Band | None
) -> BallTorque:
    """Friction torque of a row of balls between rings that turn against each other.

    angle: nominal contact angle [rad]; pitch_diameter [m]; loads: thrust of all balls, preload included [N], radial load
    [N], largest contact force over the rated one [1]; viscous: M_0 [N m]. Range: measured on catalogue bearings under loads
    of up to a static safety of one, run in, shortly after greasing (Smith 2.3); fresh grease takes more.
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
    """Load-dependent torque M_1 [N m] of a ball bearing, factor f_1, equivalent load P_0 [N], static rating C_0 [N]."""

    torque: float = quantity(
        "torque_Nmm",
        "starting torque of one bearing under its preload, by Palmgren's load formula M = f1 F dm (Smith 2.33 to 2.38), "
        "without lubricant and seals",
        error="empirical",
    )
    factor: float = quantity("factor", "its f1 = 0.0013 (P0/C0)^(1/3)")
    equivalent_load: float = quantity("equivalent_load_N", "its static equivalent load P0")
    rating: float = quantity("static_rating_N", "its static rating C0 by Palmgren's formula")


def static_rating(rows: int, balls: int, ball_diameter: float, angle: float, across: float, along: float) -> float:
    """Static load rating C_0 [N] = k_0 i Z sin(alpha) D^2, k_0 = 2.8 kg/mm^2 / (D sqrt(across along)) (Smith 2.36, 2.37).

    ball_diameter [m]; angle [rad]; across, along: relative curvatures [1/m] of the inner contact across the groove and
    along the track, (rho_11 + rho_21) and (rho_12 + rho_22): as printed, (rho_11 + rho_12)(rho_21 + rho_22) is negative.
    """
    k = 2.8 * KILOGRAM_FORCE * 1e6 / (ball_diameter * np.sqrt(across * along))
    return float(k * rows * balls * np.sin(angle) * ball_diameter**2)


def load_torque(
    axial: float, radial: float, pitch_diameter: float, rating: float, *, axial_factor: float = 0.3
) -> LoadTorque:
    """Load-dependent torque M_1 = f_1 g_1 P_0 d_m [N m] (Smith 2.33-2.38).

    axial, radial: static loads [N]; pitch_diameter [m]; rating C_0 [N]; axial_factor: Y_0 of P_0 = 0.5 F_r + Y_0 F_a.
    f_1 = 0.0013 (P_0/C_0)^(1/3) for contact angles of about 60 degrees; g_1 P_0 = F_a, so that Y_0 enters by f_1 only.
    """
    equivalent = 0.5 * radial + axial_factor * axial
    factor = 0.0013 * float(np.cbrt(equivalent / rating))
    return LoadTorque(factor * axial * pitch_diameter, factor, equivalent, rating)


def taper_torque(geometry: float, viscosity: float, speed: float, axial: float) -> float:
    """Running torque [N m] of a tapered roller bearing under thrust: 3.54e-5 G_1 (n mu)^0.62 F_a^0.30 in-lb (Smith 3.29).

    geometry: the maker's factor G_1, an input; viscosity: dynamic [Pa s]; speed [rad/s]; axial [N].
    Too low below 1700 F_a^0.67/(G_2 mu) rpm in lb and cP (Smith 3.30). Run-in bearings in circulating oil.
    """
    rpm_centipoise = 1e3 * viscosity * speed * 30.0 / np.pi
    pounds = 3.54e-5 * geometry * rpm_centipoise**0.62 * (axial / _POUND) ** 0.30
    return float(pounds * _INCH * _POUND)


def taper_geometry(torque: float, viscosity: float, speed: float, axial: float) -> float:
    """Factor G_1 that a running torque [N m] implies: the inverse of `taper_torque`, for a maker's curve or a test."""
    return torque / taper_torque(1.0, viscosity, speed, axial)
