"""Friction torque of a row of tapered rollers: by the power lost in its contacts, and by Timken's formula.

The rollers roll about the common apex (`lowfi.bearings.rib`, 4), so that the relative motion and the power P lost in every
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

Timken's formula (Smith 1994, 3.29) is `lowfi.bearings.torque.taper_torque`, for thrust only, with the manufacturer's
factor G_1.
"""

from __future__ import annotations

import numpy as np

from rollbench.lowfi.bearings.rib import mean_distance, rib_contact_ellipse, rib_height, roller_speed_ratios
from rollbench.lowfi.bearings.torque import taper_torque
from rollbench.lowfi.rollers import TaperedBearing, slice_contacts, slice_middles, tapered_bearing
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import RollerRow
from rollbench.meshes.parts import Lubricant
from rollbench.meshes.quantity import Stated, quantity, record

#: Part of the work of deformation that steel loses by hysteresis (Johnson 1985, 9.1: about one per cent).
HYSTERESIS = 0.01

#: Coefficient of friction of the roller's end on the rib if none is given, and its range: full film to boundary
#: lubrication.
USUAL_FRICTION, FRICTIONS = 0.1, (0.03, 0.15)

#: Ratio of the largest to the mean roller load above which a row is taken to carry more than thrust.
UNEVEN = 1.1


@record
class RollerTorque:
    """Friction torque of a row of tapered rollers about its axis [N m], by the contacts' losses and by Timken's formula."""

    #: Torque of the lubricant film between rollers and races; None without lubricant or speed.
    film: float | None = quantity(
        "film_Nmm", "part of the oil film between rollers and races; null without lubricant or speed", error="upper bound"
    )
    #: Torque of elastic hysteresis.
    hysteresis: float = quantity("hysteresis_Nmm", "part of the steel's hysteresis, 1 % of the work of deformation")
    #: Torque of sliding and spin of the rollers' ends on the rib.
    rib: float = quantity(
        "rib_Nmm", "part of the large ends that slide and spin on the rib", error="that of the coefficient of friction"
    )
    #: Torque with the lowest coefficient of friction in `FRICTIONS`; None if the scene gives the coefficient.
    low: float | None = quantity(
        "low_Nmm", "torque with a coefficient of 0.03 on the rib, a full film; null where rib_friction is given"
    )
    #: Torque with the highest coefficient of friction in `FRICTIONS`; None if the scene gives the coefficient.
    high: float | None = quantity("high_Nmm", "torque with a coefficient of 0.15 on the rib, boundary lubrication")
    #: Torque by Timken's formula; None if one of its inputs is missing.
    timken: float | None = quantity(
        "timken_Nmm",
        "running torque by Timken's formula (Smith 3.29) under the row's thrust; null without torque_factor, "
        "lubricant or speed",
        error="empirical; of thrust alone",
    )
    #: Text on assumptions and missing data.
    words: str = quantity("words", "what is assumed or missing", show=lambda words: words or None, default="")

    @property
    @Stated(
        "torque_Nmm",
        "friction torque of the row by work in its contacts, the sum of film, hysteresis and rib",
        error="`low_Nmm` to `high_Nmm`",
        heading="friction torque of the row",
        form="g3",
    )
    def torque(self) -> float:
        """Friction torque of the running row: film, hysteresis and rib [N m]."""
        return (self.film or 0.0) + self.start

    @property
    @Stated(
        "starting_torque_Nmm",
        "the same at rest, without the film",
        error="that of the coefficient of friction",
        heading="friction torque from rest",
        form="g3",
    )
    def start(self) -> float:
        """Friction torque that starts the row from rest, without lubricant film [N m]."""
        return self.hysteresis + self.rib


def roller_torque(
    row: RollerRow, line_loads: Array, speed: float | None, lubricant: Lubricant | None
) -> RollerTorque | None:
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
    RollerTorque | None
        Parts and sum of the torque; None without load.

    Raises
    ------
    ValueError
        The radius of the rollers' ends is outside the range of `rollbench.lowfi.bearings.rib.rib_geometry`.
    """
    if not (line_loads > 0.0).any():
        return None
    bearing, speed = tapered_bearing(row), abs(speed or 0.0)
    loads = line_loads.mean(axis=1) * row.length
    cone, _ = roller_speed_ratios(bearing)
    rib = 2.0 * np.sin(bearing.roller_angle) * loads
    distance = mean_distance(*rib_contact_ellipse(row, rib), rib_height(row))
    sliding = cone * float(rib @ distance)  # torque of the rib over its coefficient
    mu = USUAL_FRICTION if row.rib_friction is None else row.rib_friction
    words, film, timken = [], None, None
    if lubricant is None or not speed:
        words.append(f"no film: no {'[lubricant]' if lubricant is None else '[motion] speed'} is given")
    else:
        film = film_torque(bearing, line_loads, speed, lubricant)
        if row.torque_factor is not None:
            thrust = float(loads.sum() * np.sin(bearing.cup_angle))
            timken = taper_torque(row.torque_factor, lubricant.dynamic_viscosity, speed, thrust)
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
    return RollerTorque(film, elastic, mu * sliding, low, high, timken, "; ".join(words))


def rolling_speed(bearing: TaperedBearing, along: Array, speed: float) -> Array:
    """Return the rolling speed, at which both surfaces move through a roller's contacts [m/s].

    The speed of the cage makes the rolling speeds in the contacts with cone and cup equal.

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


def film_torque(bearing: TaperedBearing, line_loads: Array, speed: float, lubricant: Lubricant) -> float:
    """Return the friction torque of the lubricant films on both races [N m], by eq. (1) of this module for each slice.

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
    x = slice_middles(bearing.length, line_loads.shape[-1])
    roller, cone, cup = bearing.radii(x)
    u, width = rolling_speed(bearing, x, speed), bearing.length / x.size
    lost = 0.0
    for curvature in (1.0 / roller + 1.0 / cone, 1.0 / roller - 1.0 / cup):
        force = rolling_force(line_loads, u, 1.0 / curvature, lubricant, bearing.young / (1.0 - bearing.poisson**2))
        lost += float((2.0 * u * force).sum()) * width
    return lost / speed


def rolling_force(line_load: Array, speed: Array, radius: Array, lubricant: Lubricant, modulus: float) -> Array:
    """Return the rolling resistance per length of the film's inlet on either surface [N/m], by eq. (1) of this module.

    It is zero without load.

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
        Modulus E' = E/(1 - nu^2) [Pa].

    References
    ----------
    Goksem and Hargreaves (1978). It agrees within 15 % with the integral over the inlet (Grubin) for W of 1e-5 to 1e-4.

    Examples
    --------
    >>> oil = Lubricant(100e-6, pressure_viscosity=20e-9)
    >>> round(float(rolling_force(np.array(1e5), np.array(1.0), np.array(5e-3), oil, 231e9)), 2)
    55.22
    """
    q = np.asarray(line_load, dtype=float)
    gu = lubricant.pressure_viscosity * lubricant.dynamic_viscosity * speed / radius
    return np.asarray(4.318 * gu**0.658 * (q / (modulus * radius)) ** 0.0126 * radius / lubricant.pressure_viscosity)


def hysteresis_torque(bearing: TaperedBearing, line_loads: Array) -> float:
    """Return the friction torque of elastic hysteresis at both races [N m], by eq. (2) of this module for each slice.

    Parameters
    ----------
    bearing
        The bearing.
    line_loads
        Loads per length of each roller's slices ``(count, slices)`` [N/m].
    """
    b, _ = slice_contacts(bearing, line_loads)
    work = (line_loads[..., None] * b).sum(axis=(0, 1)) * bearing.length / line_loads.shape[-1]
    return float(HYSTERESIS * 2.0 / (3.0 * np.pi) * work @ np.array(roller_speed_ratios(bearing)))
