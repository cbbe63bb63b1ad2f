"""Contact of a tapered roller's spherical large end with the rib of the cone, and speeds of roller and rings.

Geometry in an axial plane, seen from the common apex. The end is a sphere of radius R_s whose centre C lies on the roller's
axis. It passes through the large end of the contact line with the cone, at the distance g = l + L/2 from the apex:

    sin(theta_0) = g sin(gamma)/R_s,   s = g cos(gamma) - R_s cos(theta_0)  (distance of C from the apex).              (1)

The rib is a conical surface about the bearing's axis that touches the sphere at the height h above the cone's race. There
the normal makes the angle theta with the roller's axis, and beta - theta with the bearing's axis, beta = alpha - gamma:

    theta = gamma - arcsin((h - s sin(gamma))/R_s).                                                                    (2)

Along its generator the rib is straight. Across the generator it is concave, and its radius of curvature is the length of
the normal up to the bearing's axis (Meusnier):

    R_f = R_s + s sin(beta)/sin(beta - theta);   relative curvatures 1/R_s and 1/R_s - 1/R_f.                          (3)

A sphere about the apex, R_s = g, therefore fits the rib all around the rim; manufacturers take R_s = 0.8 g to 0.95 g. By
equilibrium of the roller along its axis the rib carries 2 Q sin(gamma), Q the load of a race. The tilt theta of the normal
is neglected; it would multiply the load by 1/cos(theta), 0.1 to 0.3 % more. Pressure and contact ellipse follow by Hertz
(Smith 1994, 3.1.1: sphere and cylinder of the rib's radius).

Motion: all axes meet in the apex and the roller rolls on both races without sliding. Relative to the cup it therefore
rotates about its contact line with the cup, relative to the cone about that with the cone. The angular speeds of these
rotations, over that of the rings against each other, are

    cone  sin(alpha)/sin(2 gamma),   cup  sin(alpha - 2 gamma)/sin(2 gamma).                                           (4)

On the rib the end therefore slides as it rotates about the contact line with the cone, at the distance h from the middle of
the contact.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.lowfi.hertz import contact_modulus, hertz_constants
from rollbench.lowfi.rollers import TaperedBearing, tapered_bearing
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import RollerRow
from rollbench.meshes.quantity import quantity, record

#: Height of the rib contact above the race, over the roller's diameter, if the scene does not give it.
USUAL_HEIGHT = 0.1

_U, _W = np.polynomial.legendre.leggauss(32)


@dataclass(frozen=True)
class Rib:
    """Geometry of the contact of a roller's spherical end with the rib, by eqs. (1) to (3) of this module."""

    #: Angle theta of the contact normal against the roller's axis [rad].
    tilt: float
    #: Relative curvatures along the rim and across the rim [1/m].
    curvatures: tuple[float, float]
    #: Radius of curvature R_f of the rib across its generator [m].
    radius: float


def rib_geometry(bearing: TaperedBearing, end_radius: float, height: float) -> Rib:
    """Return the geometry of the contact of a roller's end with the rib, by eqs. (1) to (3) of this module.

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
        below its distance from the apex. The message is the condition for ``end_radius``, which the check of scenes prints
        as the allowed value.
    """
    gamma, beta = bearing.roller_angle, bearing.cup_angle - bearing.roller_angle
    g = bearing.apex_distance + 0.5 * bearing.length
    edge = g * float(np.sin(gamma))
    if not edge < end_radius < g:
        limits = f"above {1e3 * edge:.4g} mm, the radius of the roller's large end, and below {1e3 * g:.4g} mm"
        raise ValueError(f"{limits}, its distance from the apex")
    s = g * float(np.cos(gamma)) - float(np.sqrt(end_radius**2 - edge**2))
    tilt = gamma - float(np.arcsin((height - s * np.sin(gamma)) / end_radius))
    if not tilt < beta:
        raise ValueError("a larger radius, with which the sphere can touch a rib of the cone")
    radius = end_radius + s * float(np.sin(beta) / np.sin(beta - tilt))
    return Rib(tilt, (1.0 / end_radius - 1.0 / radius, 1.0 / end_radius), radius)


def rib_height(row: RollerRow) -> float:
    """Return the height h of the rib contact above the race [m]; a tenth of the roller diameter if the row gives none.

    Parameters
    ----------
    row
        Row of tapered rollers.
    """
    return USUAL_HEIGHT * row.diameter if row.rib_height is None else row.rib_height


@record
class RibContact:
    """Contact of the most loaded roller of a row with its rib."""

    #: Number of the roller, from 1.
    roller: int = quantity("roller", "roller of the largest load on the rib")
    #: Force of the rib on the roller [N].
    load: float = quantity(
        "load_N",
        "force of the rib on its large end, 2 Q sin(gamma), by balance along the roller",
        error="that of the load",
        heading="load on the rib",
        note="roller {roller}",
    )
    #: Largest pressure [Pa]; None if the radius of the roller's end is not given.
    pressure: float | None = quantity(
        "pressure_MPa",
        "largest pressure there by Hertz, sphere of the end on the hollow cone of the rib; null without `end_radius`",
        error="a third of the load's, and of the height where that is assumed",
        heading="pressure on the rib",
    )
    #: Semi-axis of the contact ellipse along the rim [m]; None if the radius of the roller's end is not given.
    a: float | None = quantity("semi_axis_a_mm", "semi-axis of its ellipse along the rim", error="a third of the load's")
    #: Semi-axis of the contact ellipse across the rim [m]; None if the radius of the roller's end is not given.
    b: float | None = quantity("semi_axis_b_mm", "semi-axis across the rim", error="a third of the load's")
    #: Height of the contact above the cone's race [m].
    height: float = quantity("height_mm", "height of the contact above the cone's race, as given or assumed")
    #: Text on assumptions and missing data.
    words: str = quantity("words", "what is assumed or not known", show=lambda words: words or None, default="")


def rib_contact(row: RollerRow, loads: Array) -> RibContact | None:
    """Return the contact of the most loaded roller of a row with its rib.

    Valid for straight or crowned rollers that touch their ribs, with a contact ellipse small against the roller's end. The
    ellipse is truncated if its semi-axis b is larger than the height of the contact.

    Parameters
    ----------
    row
        Row of tapered rollers.
    loads
        Force of either race on each roller ``(count,)`` [N].

    Returns
    -------
    RibContact | None
        Load, pressure and ellipse of the contact; None without load.

    Raises
    ------
    ValueError
        The radius of the end is outside the range of `rib_geometry`.
    """
    if not (loads > 0.0).any():
        return None
    bearing, height = tapered_bearing(row), rib_height(row)
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
    """Return the semi-axes of the contact ellipse of a roller's end with the rib [m], along and across the rim.

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
        The radius of the end is outside the range of `rib_geometry`.
    """
    root = np.cbrt(np.asarray(load, dtype=float))
    if row.end_radius is None:
        return 0.0 * root, 0.0 * root
    E, nu = row.material.youngs_modulus, row.material.poissons_ratio
    along, across = rib_geometry(tapered_bearing(row), row.end_radius, rib_height(row)).curvatures
    h = hertz_constants(np.array(along), np.array(across), contact_modulus(E, nu, E, nu))
    return np.asarray(h.C_a * root), np.asarray(h.C_b * root)


def mean_distance(a: Array, b: Array, height: float) -> Array:
    """Return the mean distance of the rib's contact pressure from the cone's contact line, int p r dA/F [m].

    r is the distance from a point on the minor axis at the height h from the ellipse's centre. With s the relative radius
    in the ellipse and u = sqrt(1 - s^2), the integral has the weight 3 u^2/(2 pi); Gauss and trapezoid rules give it to
    1e-4.

    Parameters
    ----------
    a, b
        Semi-axes along and across the rim ``(n,)`` [m]; zero for a point contact, whose distance is the height.
    height
        Height h of the contact above the cone's race [m].
    """
    u, angle = 0.5 * (1.0 + _U[:, None]), 2.0 * np.pi * (np.arange(64) + 0.5) / 64.0
    s = np.sqrt(1.0 - u**2)
    x, y = (np.multiply.outer(np.asarray(k, dtype=float), s * f(angle)) for k, f in ((a, np.cos), (b, np.sin)))
    weight = 1.5 * u**2 * _W[:, None] / 64.0
    return np.asarray((weight * np.hypot(x, y + height)).sum(axis=(-2, -1)))


def roller_speed_ratios(bearing: TaperedBearing) -> tuple[float, float]:
    """Return the angular speeds of a roller relative to the cone, then relative to the cup, by eq. (4) of this module.

    Both are ratios to the angular speed of the rings relative to each other.

    ``bearing``: geometry of the row of rollers.
    """
    over = float(np.sin(2.0 * bearing.roller_angle))
    return float(np.sin(bearing.cup_angle)) / over, float(np.sin(bearing.cone_angle)) / over
