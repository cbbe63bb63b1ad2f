"""Friction torque of ball and tapered roller bearings: empirical formulas, and the power lost in the contacts of rollers.

Palmgren's constants are written as published, in kg, mm and s, and converted here.

The running torque of a row of balls is M = M_0 + M_1 (`ball_torque`); starting from rest takes twice M_1. Published
coefficients differ by lubrication, series and author, so each torque is a range (low, high):

    M_0 = f_0 (nu n)^(2/3) d_m^3,  M_1 = z (Q/Q_0)^y P_1 d_m.

Q/Q_0 is the largest contact load over the contact force of the static load rating by ISO 76. It replaces P_0/C_0 (Smith
2.36) for any combination of loads. The coefficients z, y and P_1 are in `LOAD`, f_0 in `VISCOUS`.

For a row of tapered rollers the torque follows from the power lost in its contacts (`roller_bearing_torque`). The rollers
roll about the common apex (`lowfi.bearings.tapered_roller`, 5), so that the relative motion and the power P lost in every
contact are known. The torque about the bearing's axis is the sum of P/omega, omega the angular speed of the rings relative
to each other. The losses are:

- rolling resistance of the lubricant film between roller and race, per length and surface (Goksem and Hargreaves 1978;
  Harris, Rolling Bearing Analysis),
      F = 4.318 (G U)^0.658 W^0.0126 R/alpha_p,   G U = alpha_p eta u/R,   W = q/(E' R),   P = 2 u F,                  (1)
  with the rolling speed u, the pressure coefficient alpha_p of the viscosity eta, the relative radius R and
  E' = E/(1 - nu^2). It is the integral of (h/2)(dp/dx) over the inlet for a full film. Heating of the inlet and starvation
  reduce it, so it is an upper bound for grease.
- elastic hysteresis, 1 % of the work that deforms the steel (Johnson 1985, 9.1),
      P = 0.01 (2/(3 pi)) Q b Omega,                                                                                   (2)
  with the angular speed Omega of the roller relative to the race.
- sliding and spin of the roller's end on the rib,
      P = mu F Omega <r>,                                                                                              (3)
  with the load F of the rib and the mean distance <r> of its pressure from the cone's contact line, about which the end
  rotates.

At rest and without lubricant there is no film; rib and hysteresis give the starting torque. Cage, seals and drag are
neglected.

Timken's formula (Smith 1994, 3.29) is `timken_running_torque`, for thrust only, with the manufacturer's factor G_1.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from rollbench.lowfi import rollers
from rollbench.lowfi.bearings import tapered_roller
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import RollerRow
from rollbench.meshes.parts import Lubricant
from rollbench.meshes.quantity import QuantityDescription, quantity_field, result_record, text_or_none

#: Range of a quantity: its lowest and highest value, in SI units.
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


def load_independent_torque(lubrication_factor: float, pitch_diameter: float, viscosity: float, speed: float) -> float:
    """Return the load-independent friction torque M_0 of a ball bearing [N m].

    M_0 is 1e-8 f_0 (nu n)^(2/3) d_m^3 in kilogram-force mm, with d_m in mm, nu in mm^2/s and n in rpm. Below nu n = 2000
    mm^2/s rpm, where the film is thinner than a micrometre, M_0 has the value at 2000 (Palmgren; SKF: 160e-7 f_0 d_m^3 in N
    mm, which is 3 % more).

    Parameters
    ----------
    lubrication_factor
        Coefficient f_0 of design and lubrication (`VISCOUS`).
    pitch_diameter
        Pitch diameter d_m [m].
    viscosity
        Kinematic viscosity nu [m^2/s].
    speed
        Relative speed n of the rings [rad/s], of any sign.

    References
    ----------
    Palmgren (1959); Smith (1994), 2.32. Smith's 2.31 with the exponent 2/3 (printed 3/2) and atmospheric pressure agrees
    with it within 2 % for oil of 900 kg/m^3.

    Examples
    --------
    f_0 = 2, 40 mm, 20 mm^2/s, 1500 rpm; newer catalogues print 1e-7 for a result in N mm, which gives 12.36 N mm:

    >>> round(load_independent_torque(2.0, 40e-3, 20e-6, 1500.0 * np.pi / 30.0) * 1e3, 2)  # N mm
    12.12
    """
    film = max(1e6 * viscosity * abs(speed) * 30.0 / np.pi, LEAST_FILM)
    return float(1e-8 * KILOGRAM_FORCE * 1e-3 * lubrication_factor * film ** (2.0 / 3.0) * (1e3 * pitch_diameter) ** 3)


@result_record
class BallBearingTorque:
    """Friction torque of a row of balls [N m], as a range (low, high) given by the published coefficients."""

    #: Load-dependent part M_1 of the friction torque, as (low, high) [N m].
    load: Band = quantity_field(
        "load_Nmm",
        "load-dependent part M1 = z (Q/Q0)^y P1 dm, from the computed loads; lowest and highest published z",
        error="empirical",
        parts="[]",
    )
    #: Part M_0 of the friction torque that depends on lubricant and speed, as (low, high) [N m]; None without lubricant or
    #: speed.
    viscous: Band | None = quantity_field(
        "viscous_Nmm",
        "part M0 = f0 (nu n)^(2/3) dm^3 that depends on lubricant and speed; lowest and highest published f0; null without "
        "[lubricant] or [motion]",
        error="empirical",
        parts="[]",
    )
    #: Torque that starts the row from rest, twice M_1, as (low, high) [N m].
    starting: Band = quantity_field(
        "starting_Nmm",
        "torque that starts the row from rest: twice the load-dependent part",
        error="empirical",
        parts="[]",
        heading="friction torque from rest",
        form="g3",
        note="lowest to highest coefficients (Palmgren)",
    )

    @property
    @QuantityDescription(
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


def ball_bearing_torque(
    kind: Kind, angle: float, pitch_diameter: float, loads: tuple[float, float, float], viscous: Band | None
) -> BallBearingTorque:
    """Return the friction torque of a row of balls between rings that turn against each other.

    Validity: the coefficients were measured on catalogue bearings that are run in and not freshly greased, at loads up to
    the static load rating. Fresh grease needs more torque.

    Parameters
    ----------
    kind
        Design of the row, such as "angular contact": a key of `LOAD`.
    angle
        Nominal contact angle [rad].
    pitch_diameter
        Pitch diameter d_m [m].
    loads
        Thrust of all balls, with preload [N]; radial load [N]; ratio Q/Q_0 of the largest contact load to the permissible
        static one.
    viscous
        Load-independent torque M_0 as (low, high) [N m]; None without lubricant or speed.

    References
    ----------
    Palmgren (1959); SKF general catalogue (1989); Smith (1994), 2.3 and 2.34.

    Examples
    --------
    An angular-contact row at 1 kN thrust, Q/Q_0 = 1/8, d_m = 40 mm: factors 0.001 to 0.0013, times (1/8)^(1/3), times 40 N
    m.

    >>> torque = ball_bearing_torque("angular contact", np.pi / 6, 40e-3, (1e3, 0.0, 0.125), None)
    >>> [round(x * 1e3, 6) for x in torque.load]  # N mm
    [20.0, 26.0]
    """
    (low, high), power, (axial, across) = LOAD[kind]
    thrust, radial, share = loads
    if kind == "angular contact" and angle > RADIAL_UP_TO + 1e-9:
        low = THRUST
    one = share**power * max(axial * thrust + across * radial, radial) * pitch_diameter
    load = low * one, high * one
    return BallBearingTorque(load, viscous, (STARTING * load[0], STARTING * load[1]))


@result_record
class PalmgrenLoadTorque:
    """Load-dependent friction torque M_1 of a ball bearing, with the factors from which it is computed."""

    #: Load-dependent friction torque M_1 [N m].
    torque: float = quantity_field(
        "torque_Nmm",
        "starting torque of one bearing under its preload, by Palmgren's load formula M = f1 F dm (Smith 2.33 to 2.38), "
        "without lubricant and seals",
        error="empirical",
    )
    #: Factor f_1 = 0.0013 (P_0/C_0)^(1/3) of the torque M_1 = f_1 g_1 P_0 d_m, with static equivalent load P_0, static load
    #: rating C_0 and pitch diameter d_m; g_1 P_0 is taken as the thrust.
    factor: float = quantity_field("factor", "factor f1 = 0.0013 (P0/C0)^(1/3) of the starting torque")
    #: Static equivalent load P_0 [N].
    equivalent_load: float = quantity_field("equivalent_load_N", "static equivalent load P0 of the bearing")
    #: Static load rating C_0 [N].
    static_rating: float = quantity_field("static_rating_N", "static load rating C0 of the bearing by Palmgren's formula")


def palmgren_static_rating(rows: int, balls: int, ball_diameter: float, angle: float, across: float, along: float) -> float:
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


def load_dependent_torque(
    axial: float, radial: float, pitch_diameter: float, rating: float, *, axial_factor: float = 0.3
) -> PalmgrenLoadTorque:
    """Return the load-dependent friction torque M_1 = f_1 g_1 P_0 d_m of a ball bearing.

    The factor f_1 = 0.0013 (P_0/C_0)^(1/3) of design and load is for contact angles of about 60 deg. The load g_1 P_0 that
    determines the torque is taken as the thrust F_a; the factor Y_0 in P_0 therefore has an influence only through f_1.

    Parameters
    ----------
    axial, radial
        Static thrust F_a and radial load F_r [N].
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
    >>> round(load_dependent_torque(1e3, 0.0, 40e-3, 2.4e3).torque * 1e3, 6)  # 0.0013/2 times 40 N m, in N mm
    26.0
    """
    equivalent = 0.5 * radial + axial_factor * axial
    factor = 0.0013 * float(np.cbrt(equivalent / rating))
    return PalmgrenLoadTorque(factor * axial * pitch_diameter, factor, equivalent, rating)


def timken_running_torque(bearing_factor: float, viscosity: float, speed: float, axial: float) -> float:
    """Return the running torque of a tapered roller bearing under thrust by Timken's formula [N m].

    The formula is 3.54e-5 G_1 (n mu)^0.62 F_a^0.30 in-lb, in rpm, cP and lb. It is valid for run-in bearings in circulating
    oil, and too low at speeds below 1700 F_a^0.67/(G_2 mu) rpm in lb and cP (Smith 1994, eq. 3.30).

    Parameters
    ----------
    bearing_factor
        Bearing factor G_1 of Timken's formula, from the manufacturer's catalogue.
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
    >>> round(timken_running_torque(30.0, 20e-3, 1000.0 * np.pi / 30.0, 2e3), 4)
    0.348
    """
    rpm_centipoise = 1e3 * viscosity * speed * 30.0 / np.pi
    pounds = 3.54e-5 * bearing_factor * rpm_centipoise**0.62 * (axial / _POUND) ** 0.30
    return float(pounds * _INCH * _POUND)


def timken_factor_from_torque(torque: float, viscosity: float, speed: float, axial: float) -> float:
    """Return Timken's bearing factor G_1 from a running torque that a manufacturer's curve or a test gives.

    This is the inverse of `timken_running_torque`.

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
    return torque / timken_running_torque(1.0, viscosity, speed, axial)


#: Part of the work of deformation that steel loses by hysteresis (Johnson 1985, 9.1: about one per cent).
HYSTERESIS = 0.01

#: Coefficient of friction of the roller's end on the rib if none is given, and its range: full film to boundary
#: lubrication.
USUAL_FRICTION, FRICTIONS = 0.1, (0.03, 0.15)

#: Ratio of the largest to the mean roller load above which a row is taken to carry more than thrust.
UNEVEN = 1.1


@result_record
class RollerBearingTorque:
    """Friction torque of a row of tapered rollers about its axis [N m], from contact losses and by Timken's formula."""

    #: Friction torque of the lubricant film between rollers and races [N m]; None without lubricant or speed.
    film: float | None = quantity_field(
        "film_Nmm",
        "friction torque of the oil film between rollers and races; null without lubricant or speed",
        error="upper bound",
    )
    #: Friction torque of elastic hysteresis in the contacts of rollers and races [N m].
    hysteresis: float = quantity_field(
        "hysteresis_Nmm", "friction torque of the steel's hysteresis, 1 % of the work of deformation"
    )
    #: Friction torque of sliding and spin of the rollers' ends on the rib [N m].
    rib: float = quantity_field(
        "rib_Nmm",
        "friction torque of the rollers' large ends that slide and spin on the rib",
        error="that of the coefficient of friction",
    )
    #: Friction torque of the running row [N m] for the lowest coefficient of friction on the rib, 0.03; None if the scene
    #: gives the coefficient.
    low: float | None = quantity_field(
        "low_Nmm", "torque with a coefficient of friction of 0.03 on the rib (full film); null if rib_friction is given"
    )
    #: Friction torque of the running row [N m] for the highest coefficient of friction on the rib, 0.15; None if the scene
    #: gives the coefficient.
    high: float | None = quantity_field(
        "high_Nmm",
        "torque with a coefficient of friction of 0.15 on the rib (boundary lubrication); null if rib_friction is given",
    )
    #: Running torque by Timken's formula [N m]; None if one of its inputs is missing.
    timken: float | None = quantity_field(
        "timken_Nmm",
        "running torque by Timken's formula (Smith 3.29) under the row's thrust; null without torque_factor, "
        "lubricant or speed",
        error="empirical; of thrust alone",
    )
    #: Text on assumptions and missing data of the torque.
    words: str = text_or_none("words", "what is assumed or missing")

    @property
    @QuantityDescription(
        "torque_Nmm",
        "friction torque of the row from the power lost in its contacts: sum of film, hysteresis and rib",
        error="`low_Nmm` to `high_Nmm`",
        heading="friction torque of the row",
        form="g3",
    )
    def torque(self) -> float:
        """Friction torque of the running row: film, hysteresis and rib [N m]."""
        return (self.film or 0.0) + self.start

    @property
    @QuantityDescription(
        "band_Nmm",
        "range of `torque_Nmm`: from `low_Nmm` to `high_Nmm`, one value twice if rib_friction is given",
        error="the range itself, and that of the formulas",
        parts="[]",
    )
    def band(self) -> Band:
        """Friction torque of the running row, (low, high) [N m]."""
        return (self.torque, self.torque) if self.low is None or self.high is None else (self.low, self.high)

    @property
    @QuantityDescription(
        "starting_torque_Nmm",
        "friction torque of the row from rest, without the lubricant film",
        error="that of the coefficient of friction",
        heading="friction torque from rest",
        form="g3",
    )
    def start(self) -> float:
        """Friction torque that starts the row from rest, without lubricant film [N m]."""
        return self.hysteresis + self.rib


def roller_bearing_torque(
    row: RollerRow, line_loads: Array, speed: float | None, lubricant: Lubricant | None
) -> RollerBearingTorque | None:
    """Return the friction torque of a row of tapered rollers, by eqs. (1) to (3) of this module and by Timken's formula.

    Parameters
    ----------
    row
        Row of tapered rollers.
    line_loads
        Loads per length of each roller's slices ``(count, slices)`` [N/m], from the small end to the large one.
    speed
        Angular speed of the rings relative to each other [rad/s], of any sign; None or 0 at rest.
    lubricant
        Lubricant; None if it is not known.

    Returns
    -------
    RollerBearingTorque | None
        Parts and sum of the torque; None without load.

    Raises
    ------
    ValueError
        The radius of the rollers' ends is outside the range of
        `rollbench.lowfi.bearings.tapered_roller.rib_relative_curvatures`.
    """
    if not (line_loads > 0.0).any():
        return None
    bearing, speed = rollers.tapered_bearing_of_row(row), abs(speed or 0.0)
    loads = line_loads.mean(axis=1) * row.length
    cone, _ = tapered_roller.roller_speed_ratios(bearing)
    rib = 2.0 * np.sin(bearing.roller_angle) * loads
    ellipse = tapered_roller.rib_contact_ellipse(row, rib)
    distance = tapered_roller.mean_distance_of_rib_pressure(*ellipse, tapered_roller.rib_height(row))
    sliding = cone * float(rib @ distance)  # torque of the rib over its coefficient
    mu = USUAL_FRICTION if row.rib_friction is None else row.rib_friction
    words, film, timken = [], None, None
    if lubricant is None or not speed:
        words.append(f"no film: no {'[lubricant]' if lubricant is None else '[motion] speed'} is given")
    else:
        film = film_torque(bearing, line_loads, speed, lubricant)
        if row.torque_factor is not None:
            thrust = float(loads.sum() * np.sin(bearing.cup_angle))
            timken = timken_running_torque(row.torque_factor, lubricant.dynamic_viscosity, speed, thrust)
            if float(loads.max()) > UNEVEN * float(loads.mean()):
                words.append("Timken's formula uses only the thrust and neglects the radial force")
    if row.torque_factor is None:
        words.append("no torque by Timken's formula: rollers.torque_factor, the maker's G1, is not given")
    if row.rib_friction is None:
        words.append(f"rib_friction is assumed, {USUAL_FRICTION:g}")
    if row.end_radius is None:
        words.append("the rib's contact is taken as a point, without spin: rollers.end_radius is not given")
    elastic = hysteresis_torque(bearing, line_loads)
    others = elastic + (film or 0.0)
    low, high = (None if row.rib_friction is not None else others + k * sliding for k in FRICTIONS)
    return RollerBearingTorque(film, elastic, mu * sliding, low, high, timken, "; ".join(words))


def rolling_speed(bearing: rollers.TaperedBearing, along: Array, speed: float) -> Array:
    """Return the rolling speed of a tapered roller [m/s]: the speed of both surfaces relative to the contact with a race.

    The roller rolls without sliding, so that this speed is the same in the contacts with cone and cup.

    Parameters
    ----------
    bearing
        The bearing.
    along
        Distances along the roller from its middle [m].
    speed
        Angular speed of the rings relative to each other [rad/s].
    """
    cone, cup = np.sin(bearing.cone_angle), np.sin(bearing.cup_angle)
    return np.asarray(speed * (bearing.apex_distance + along) * cone * cup / (cone + cup))


def film_torque(bearing: rollers.TaperedBearing, line_loads: Array, speed: float, lubricant: Lubricant) -> float:
    """Return the friction torque of the lubricant films on both races [N m].

    It is the power lost by rolling resistance (`film_rolling_resistance`) in all slices of all rollers, divided by the
    relative angular speed of the rings.

    Parameters
    ----------
    bearing
        The bearing.
    line_loads
        Loads per length of each roller's slices ``(count, slices)`` [N/m].
    speed
        Angular speed of the rings relative to each other [rad/s].
    lubricant
        The lubricant.
    """
    x = rollers.slice_middles(bearing.length, line_loads.shape[-1])
    roller, cone, cup = bearing.curvature_radii(x)
    u, width = rolling_speed(bearing, x, speed), bearing.length / x.size
    lost, modulus = 0.0, bearing.young / (1.0 - bearing.poisson**2)
    for curvature in (1.0 / roller + 1.0 / cone, 1.0 / roller - 1.0 / cup):
        force = film_rolling_resistance(line_loads, u, 1.0 / curvature, lubricant, modulus)
        lost += float((2.0 * u * force).sum()) * width
    return lost / speed


def film_rolling_resistance(line_load: Array, speed: Array, radius: Array, lubricant: Lubricant, modulus: float) -> Array:
    """Return the rolling resistance of the lubricant film per length and surface [N/m].

    It is 4.318 (G U)^0.658 W^0.0126 R/alpha_p with G U = alpha_p eta u/R, W = q/(E' R), viscosity eta and pressure
    coefficient alpha_p of the viscosity; zero without load.

    Parameters
    ----------
    line_load
        Load per length q [N/m].
    speed
        Rolling speed u [m/s].
    radius
        Relative radius R [m].
    lubricant
        The lubricant.
    modulus
        Plane strain modulus E' = E/(1 - nu^2) [Pa].

    References
    ----------
    Goksem and Hargreaves (1978). For W of 1e-5 to 1e-4 the formula agrees within 15 % with the integral over the inlet of
    the film (Grubin).

    Examples
    --------
    >>> oil = Lubricant(100e-6, pressure_viscosity=20e-9)
    >>> round(float(film_rolling_resistance(np.array(1e5), np.array(1.0), np.array(5e-3), oil, 231e9)), 2)
    55.22
    """
    q = np.asarray(line_load, dtype=float)
    alpha_p = lubricant.pressure_viscosity
    gu = alpha_p * lubricant.dynamic_viscosity * speed / radius
    return np.asarray(4.318 * gu**0.658 * (q / (modulus * radius)) ** 0.0126 * radius / alpha_p)


def hysteresis_torque(bearing: rollers.TaperedBearing, line_loads: Array) -> float:
    """Return the friction torque of elastic hysteresis at both races [N m].

    The steel loses 1 % of the work that deforms it. In a slice of a roller the loss is 0.01 (2/(3 pi)) Q b Omega with the
    load Q, the half-width b of the contact, and the roller's angular speed Omega relative to the race.

    Parameters
    ----------
    bearing
        The bearing.
    line_loads
        Loads per length of each roller's slices ``(count, slices)`` [N/m].
    """
    b, _ = rollers.half_widths_and_pressures_of_slices(bearing, line_loads)
    work = (line_loads[..., None] * b).sum(axis=(0, 1)) * bearing.length / line_loads.shape[-1]
    return float(HYSTERESIS * 2.0 / (3.0 * np.pi) * work @ np.array(tapered_roller.roller_speed_ratios(bearing)))
