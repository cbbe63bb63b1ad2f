"""Tapered roller bearing: load zone under thrust and radial load, contact of the rollers with the rib, and speeds.

The inner ring's axial and radial displacement compress the roller at azimuth psi by

    delta = delta_a sin(alpha) + delta_r cos(alpha) cos(psi).                                                           (1)

The equilibrium of the single rollers is that of `lowfi.statics.axis`. The load-zone integrals are those of
Smith's method (1994, 3.1-3.21), in which a power law gives the loads.

Sjovall's integrals: a roller (or ball) at azimuth psi is compressed by delta_n [1 - (1 - cos psi)/(2 eps)], with the load
zone parameter eps = (1 + (delta_a/delta_r) tan alpha)/2 (Smith 1994, 3.1-3.3). It carries the largest load times the n-th
power of that bracket. The integrals run over the loaded part of the circumference. They are written with w = 1/(2 eps),
which is 0 for pure thrust.

Contact of a roller's spherical large end with the rib of the cone, in an axial plane, seen from the common apex: the end is
a sphere of radius R_s whose centre C lies on the roller's axis. It passes through the large end of the contact line with
the cone, at the distance g = l + L/2 from the apex (l: distance of the line's middle, L: its length; gamma: half angle of
the roller):

    sin(theta_0) = g sin(gamma)/R_s,   s = g cos(gamma) - R_s cos(theta_0)  (distance of C from the apex).              (2)

The rib is a conical surface about the bearing's axis that touches the sphere at the height h above the cone's race. There
the normal makes the angle theta with the roller's axis, and beta - theta with the bearing's axis, beta = alpha - gamma:

    theta = gamma - arcsin((h - s sin(gamma))/R_s).                                                                    (3)

Along its generator the rib is straight. Across the generator it is concave, and its radius of curvature is the length of
the normal up to the bearing's axis (Meusnier):

    R_f = R_s + s sin(beta)/sin(beta - theta);   relative curvatures 1/R_s and 1/R_s - 1/R_f.                          (4)

A sphere about the apex, R_s = g, therefore fits the rib all around the rim; manufacturers take R_s = 0.8 g to 0.95 g. By
equilibrium of the roller along its axis the rib carries 2 Q sin(gamma), Q the load of a race. The tilt theta of the normal
is neglected; it would multiply the load by 1/cos(theta), 0.1 to 0.3 % more. Pressure and contact ellipse follow by Hertz
(Smith 1994, 3.1.1: sphere and cylinder of the rib's radius).

Motion: all axes meet in the apex and the roller rolls on both races without sliding. Relative to the cup it therefore
rotates about its contact line with the cup, relative to the cone about that with the cone. The angular speeds of these
rotations, over that of the rings against each other, are

    cone  sin(alpha)/sin(2 gamma),   cup  sin(alpha - 2 gamma)/sin(2 gamma).                                           (5)

On the rib the end therefore slides as it rotates about the contact line with the cone, at the distance h from the middle of
the contact.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.lowfi.hertz import contact_modulus, hertz_constants
from rollbench.lowfi.rollers import TaperedBearing, tapered_bearing_of_row
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import RollerRow
from rollbench.meshes.numerics import brentq
from rollbench.meshes.quantity import quantity_field, result_record, text_or_none

# double-exponential quadrature on (0, 1), because at the end of the load zone the load is a fractional power of the angle
_T = np.arange(-3.6, 3.6001, 0.03)

_PLACES = 1.0 / (1.0 + np.exp(-np.pi * np.sinh(_T)))

_WEIGHTS = 0.03 * np.pi * np.cosh(_T) * _PLACES / (1.0 + np.exp(np.pi * np.sinh(_T)))


@dataclass(frozen=True)
class LoadZone:
    """Load zone, the loaded part of the circumference of a row of rolling elements, with Sjovall's integrals."""

    #: Load zone parameter epsilon: 1/2 if half of the circumference is loaded, infinite for pure thrust.
    eps: float
    #: Sjovall's integral J_a of the thrust, dimensionless.
    thrust_integral: float
    #: Sjovall's integral J_r of the radial load, dimensionless.
    radial_integral: float
    #: Half of the angle over which the circumference of the row is loaded [rad]; pi if all of it is loaded.
    half_angle: float


def load_zone_integrals(eps: float, exponent: float) -> LoadZone:
    """Return Sjovall's integrals J_a (thrust) and J_r (radial load) of a row of rolling elements for a load zone parameter.

    They hold for infinitely many rolling elements; the relative accuracy is 1e-12.

    Parameters
    ----------
    eps
        Load zone parameter, above 0: 1/2 if half of the circumference is loaded, infinite for pure thrust.
    exponent
        Exponent n of load ~ deflection^n: 1.1 for rollers, 1.5 for balls.

    Raises
    ------
    ValueError
        The load zone parameter is not positive.

    References
    ----------
    Smith (1994), 3.15 and 3.16.

    Examples
    --------
    Stribeck's factor of a radially loaded row of balls without clearance, 4.37:

    >>> round(1.0 / load_zone_integrals(0.5, 1.5).radial_integral, 4)
    4.3701
    """
    if not eps > 0.0:
        raise ValueError(
            f"load zone parameter: got {eps:g}; allowed: above zero (1/2 if half of the circumference is loaded)"
        )
    w = 0.5 / eps
    end = np.pi if w <= 0.5 else float(np.arccos(1.0 - 1.0 / w))
    psi = end * _PLACES
    lost = np.maximum(-2.0 * w * np.sin(0.5 * psi) ** 2, -1.0)
    with np.errstate(divide="ignore"):
        change = np.expm1(exponent * np.log1p(lost))  # load less a uniform load: no cancellation near pure thrust
    weights = end / np.pi * _WEIGHTS
    even = float(np.sin(end) / np.pi) if end < np.pi else 0.0
    return LoadZone(eps, end / np.pi + float(weights @ change), even + float(weights @ (change * np.cos(psi))), end)


def load_zone_under_thrust_and_radial_load(axial: float, radial: float, angle: float, exponent: float) -> LoadZone:
    """Return the load zone of a row of rolling elements under thrust and radial load.

    It is the load zone for which J_r/J_a = F_r tan(alpha)/F_a (Smith 1994, eq. 3.14), with Sjovall's integrals J_r of the
    radial load and J_a of the thrust (`load_zone_integrals`).

    Parameters
    ----------
    axial, radial
        Thrust F_a and radial load F_r [N].
    angle
        Contact angle alpha [rad].
    exponent
        Exponent n of load ~ deflection^n: 1.1 for rollers, 1.5 for balls.

    Raises
    ------
    ValueError
        The thrust is too small, F_a <= F_r tan(alpha), so that the rings separate, or the radial load is negative.
    """
    ratio = radial * np.tan(angle) / axial if axial > 0.0 else np.inf
    if not 0.0 <= ratio < 1.0:
        raise ValueError(
            f"load zone: got a thrust F_a of {axial:g} N and a radial load F_r of {radial:g} N; allowed: F_r of at least 0 "
            "and F_a above F_r tan(alpha) (alpha: contact angle), below which the rings separate"
        )
    if ratio == 0.0:
        return load_zone_integrals(np.inf, exponent)

    def logarithm_of_ratio_over_required(log_eps: float) -> float:
        """Return log((J_r/J_a)/ratio): ratio of Sjovall's integrals over its required value F_r tan(alpha)/F_a.

        ``log_eps``: logarithm of the load zone parameter, for which the integrals are computed.
        """
        zone = load_zone_integrals(float(np.exp(log_eps)), exponent)
        return float(np.log(zone.radial_integral / zone.thrust_integral / ratio))

    log_eps = brentq(logarithm_of_ratio_over_required, np.log(1e-8), np.log(exponent / ratio), xtol=1e-13)
    return load_zone_integrals(float(np.exp(log_eps)), exponent)


#: Height of the rib contact above the race, over the roller's diameter, if the scene does not give it.
USUAL_HEIGHT = 0.1

_U, _W = np.polynomial.legendre.leggauss(32)


def rib_relative_curvatures(bearing: TaperedBearing, end_radius: float, height: float) -> tuple[float, float]:
    """Return the relative curvatures of a roller's spherical large end and the rib, along and across the rim [1/m].

    They follow from eqs. (2) to (4) of this module.

    Parameters
    ----------
    bearing
        The bearing.
    end_radius
        Radius R_s of the spherical end [m].
    height
        Height h of the contact above the cone's race [m].

    Raises
    ------
    ValueError
        The sphere does not reach the rib or fits it without gap: R_s must be above the radius of the roller's large end and
        below the distance of this end from the common apex of the races. The message states only the allowed range of
        ``end_radius``; the caller adds the name of the input and its value.
    """
    gamma, beta = bearing.roller_angle, bearing.cup_angle - bearing.roller_angle
    g = bearing.apex_distance + 0.5 * bearing.length
    edge = g * float(np.sin(gamma))
    if not edge < end_radius < g:
        raise ValueError(
            f"a radius of the roller's spherical end above {1e3 * edge:.4g} mm (radius of the roller's large end) and "
            f"below {1e3 * g:.4g} mm (distance of that end from the common apex of the bearing's conical races)"
        )
    s = g * float(np.cos(gamma)) - float(np.sqrt(end_radius**2 - edge**2))
    tilt = gamma - float(np.arcsin((height - s * np.sin(gamma)) / end_radius))
    if not tilt < beta:
        raise ValueError("a larger radius of the roller's spherical end, with which this end can touch the conical rib")
    radius = end_radius + s * float(np.sin(beta) / np.sin(beta - tilt))
    return 1.0 / end_radius - 1.0 / radius, 1.0 / end_radius


def rib_height(row: RollerRow) -> float:
    """Return the height of the rib contact above the cone's race [m]; if not given, a tenth of the roller diameter.

    Parameters
    ----------
    row
        Row of tapered rollers.
    """
    return USUAL_HEIGHT * row.diameter if row.rib_height is None else row.rib_height


@result_record
class RibContact:
    """Contact of the large end of the most loaded roller of a row with the rib of the cone."""

    #: Number of the most loaded roller, from 1.
    roller: int = quantity_field("roller", "roller of the largest load on the rib")
    #: Force of the rib on the roller [N].
    load: float = quantity_field(
        "load_N",
        "force of the rib on the roller's large end, 2 Q sin(gamma), from equilibrium along the roller",
        error="that of the load",
        heading="load on the rib",
        note="roller {roller}",
    )
    #: Largest pressure of the roller's end on the rib [Pa]; None if the radius of the roller's end is not given.
    pressure: float | None = quantity_field(
        "pressure_MPa",
        "largest Hertz pressure of the roller's spherical end on the hollow conical rib; null without `end_radius`",
        error="a third of the load's, and of the height where that is assumed",
        heading="pressure on the rib",
    )
    #: Semi-axis of the contact ellipse along the rib's circumference [m]; None if the radius of the roller's end is not
    #: given.
    a: float | None = quantity_field(
        "semi_axis_a_mm", "semi-axis of the rib's contact ellipse along the rim", error="a third of the load's"
    )
    #: Semi-axis of the contact ellipse across the rib's circumference [m]; None if the radius of the roller's end is not
    #: given.
    b: float | None = quantity_field(
        "semi_axis_b_mm", "semi-axis of the rib's contact ellipse across the rim", error="a third of the load's"
    )
    #: Height of the rib contact above the cone's race [m].
    height: float = quantity_field("height_mm", "height of the rib's contact above the cone's race, as given or assumed")
    #: Text that names assumptions and missing data of the rib contact.
    words: str = text_or_none("words", "what is assumed or not known")


def rib_contact(row: RollerRow, loads: Array) -> RibContact | None:
    """Return the contact of the most loaded roller of a row with the rib of the cone.

    Valid for straight or crowned rollers that touch their ribs, with a contact ellipse small against the roller's end. The
    ellipse is truncated if its semi-axis across the rib's circumference is larger than the height of the contact above the
    cone's race.

    Parameters
    ----------
    row
        Row of tapered rollers.
    loads
        Contact load of each roller ``(count,)`` [N], the same on cone (inner ring) and cup (outer ring).

    Returns
    -------
    RibContact | None
        Load, pressure and ellipse of the contact; None without load.

    Raises
    ------
    ValueError
        The radius of the end is outside the range of `rib_relative_curvatures`.
    """
    if not (loads > 0.0).any():
        return None
    bearing, height = tapered_bearing_of_row(row), rib_height(row)
    worst = int(loads.argmax())
    load = 2.0 * float(loads[worst] * np.sin(bearing.roller_angle))
    words = [] if row.rib_height is not None else [f"rib_height is assumed, {USUAL_HEIGHT:g} of the roller's diameter"]
    a, b, pressure = None, None, None
    if row.end_radius is None:
        words.append("no pressure: rollers.end_radius, the sphere of the large end, is not given")
    else:
        a, b = map(float, rib_contact_ellipse(row, load))
        pressure = 1.5 * load / (np.pi * a * b)
        if b > height:
            words.append("the contact ellipse extends beyond the rib's surface: the actual pressure is higher")
    return RibContact(worst + 1, load, pressure, a, b, height, "; ".join(words))


def rib_contact_ellipse(row: RollerRow, load: Array | float) -> tuple[Array, Array]:
    """Return the semi-axes [m] of a roller end's contact ellipse on the rib, along and across the rib's circumference.

    Parameters
    ----------
    row
        Row of tapered rollers.
    load
        Forces of the rib [N], any shape.

    Returns
    -------
    tuple[Array, Array]
        Arrays of the shape of the forces; zero, as for a point contact, if the radius of the end is not given.

    Raises
    ------
    ValueError
        The radius of the end is outside the range of `rib_relative_curvatures`.
    """
    root = np.cbrt(np.asarray(load, dtype=float))
    if row.end_radius is None:
        return 0.0 * root, 0.0 * root
    E, nu = row.material.youngs_modulus, row.material.poissons_ratio
    along, across = rib_relative_curvatures(tapered_bearing_of_row(row), row.end_radius, rib_height(row))
    h = hertz_constants(np.array(along), np.array(across), contact_modulus(E, nu, E, nu))
    return np.asarray(h.C_a * root), np.asarray(h.C_b * root)


def mean_distance_of_rib_pressure(a: Array, b: Array, height: float) -> Array:
    """Return the mean distance of the pressure on the rib from the roller's contact line with the cone, int p r dA/F [m].

    p is the pressure and F its integral over the contact area; r is the distance from a point on the minor axis at the
    height h from the ellipse's centre. With s the distance from the centre over that of the ellipse's edge in the same
    direction and u = sqrt(1 - s^2), the integral over u and the angle around the centre has the weight 3 u^2/(2 pi).
    Gauss's rule for u and the trapezoid rule for the angle give it to 1e-4.

    Parameters
    ----------
    a, b
        Semi-axes of the contact ellipse along and across the rib's circumference ``(n,)`` [m]; zero for a point contact,
        whose distance is the height.
    height
        Height h of the contact above the cone's race [m].
    """
    u, angle = 0.5 * (1.0 + _U[:, None]), 2.0 * np.pi * (np.arange(64) + 0.5) / 64.0
    s = np.sqrt(1.0 - u**2)
    x, y = (np.multiply.outer(np.asarray(k, dtype=float), s * f(angle)) for k, f in ((a, np.cos), (b, np.sin)))
    weight = 1.5 * u**2 * _W[:, None] / 64.0
    return np.asarray((weight * np.hypot(x, y + height)).sum(axis=(-2, -1)))


def roller_speed_ratios(bearing: TaperedBearing) -> tuple[float, float]:
    """Return the angular speeds of a roller relative to the cone, then relative to the cup.

    Both are ratios to the angular speed of the rings relative to each other: sin(alpha)/sin(2 gamma) for the cone,
    sin(alpha - 2 gamma)/sin(2 gamma) for the cup, with the half angles alpha of the cup and gamma of the roller.
    ``bearing``: geometry of the row of rollers.
    """
    over = float(np.sin(2.0 * bearing.roller_angle))
    return float(np.sin(bearing.cup_angle)) / over, float(np.sin(bearing.cone_angle)) / over
