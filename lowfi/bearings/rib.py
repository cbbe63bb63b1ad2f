"""Contact of a tapered roller's large end, a sphere, with the rib of the cone, and how roller and rings turn.

Geometry in an axial plane, from the apex of the row. The end is a sphere of radius R_s whose centre C lies on the roller's
axis; it goes through the large end of the contact line with the cone, at the distance g = l + L/2 from the apex:

    sin(theta_0) = g sin(gamma)/R_s,   s = g cos(gamma) - R_s cos(theta_0)  (distance of C from the apex).              (1)

The rib is a cone about the bearing's axis that touches the sphere at the height h above the cone's race, where the normal
makes the angle theta with the roller's axis, and beta - theta with the bearing's, beta = alpha - gamma:

    theta = gamma - arcsin((h - s sin(gamma))/R_s).                                                                    (2)

Along its generator the rib is straight; across, its radius of curvature is the length of the normal up to the bearing's
axis (Meusnier), and the rib is concave:

    R_f = R_s + s sin(beta)/sin(beta - theta);   relative curvatures 1/R_s and 1/R_s - 1/R_f.                          (3)

So a sphere about the apex, R_s = g, fits its rib all around the rim; manufacturers take 0.8 to 0.95 of it. By balance of
the roller along its axis the rib carries 2 Q sin(gamma), Q the load of a race; the tilt theta of the normal, which is left
out, adds its 1/cos(theta), 0.1 to 0.3 %. Pressure and ellipse follow by Hertz (Smith 1994, 3.1.1: sphere and cylinder
of the rib's radius).

Motion: all axes meet in the apex and races roll without sliding, so that the roller turns about the cup's contact line
against the cup, about the cone's against the cone. Angular speeds over that of the rings against one another:

    cone  sin(alpha)/sin(2 gamma),   cup  sin(alpha - 2 gamma)/sin(2 gamma).                                           (4)

So the end slides on the rib about the cone's contact line, which lies the height h from the middle of the contact.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.lowfi.hertz import contact_modulus, hertz_constants
from rollbench.lowfi.rollers import TaperedBearing, tapered_bearing
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import RollerRow
from rollbench.meshes.quantity import quantity, record

#: Height of the contact above the race over the roller's diameter, where it is not given.
USUAL_HEIGHT = 0.1

_U, _W = np.polynomial.legendre.leggauss(32)


@dataclass(frozen=True)
class Rib:
    """Geometry of the contact of a roller's spherical end with the rib, by (1) to (3)."""

    #: Angle theta of the contact normal against the roller's axis [rad].
    tilt: float
    #: Relative curvatures along the rim and across it [1/m].
    curvatures: tuple[float, float]
    #: Radius R_f of the rib across its generator [m].
    radius: float


def rib_geometry(bearing: TaperedBearing, end_radius: float, height: float) -> Rib:
    """Return the geometry of the contact of a roller's end with the rib, by (1) to (3).

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
        A sphere that does not reach the rib or fits it without gap: R_s must lie above the end's radius and below its
        distance from the apex. The text completes a sentence "must be ...".
    """
    gamma, beta = bearing.roller_angle, bearing.cup_angle - bearing.roller_angle
    g = bearing.apex_distance + 0.5 * bearing.length
    edge = g * float(np.sin(gamma))
    if not edge < end_radius < g:
        raise ValueError(f"above {1e3 * edge:.4g} mm, the end's own, below {1e3 * g:.4g} mm, its distance from the apex")
    s = g * float(np.cos(gamma)) - float(np.sqrt(end_radius**2 - edge**2))
    tilt = gamma - float(np.arcsin((height - s * np.sin(gamma)) / end_radius))
    if not tilt < beta:
        raise ValueError("larger: so small a sphere touches no rib of the cone")
    radius = end_radius + s * float(np.sin(beta) / np.sin(beta - tilt))
    return Rib(tilt, (1.0 / end_radius - 1.0 / radius, 1.0 / end_radius), radius)


def rib_height(row: RollerRow) -> float:
    """Return height h of the contact with the rib [m]; a tenth of the roller's diameter where the row does not give it.

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
    #: Largest pressure [Pa]; None where the radius of the end is not given.
    pressure: float | None = quantity(
        "pressure_MPa",
        "largest pressure there by Hertz, sphere of the end on the hollow cone of the rib; null without `end_radius`",
        error="a third of the load's, and of the height where that is assumed",
        heading="pressure on the rib",
    )
    #: Semi-axis along the rim [m]; None likewise.
    a: float | None = quantity("semi_axis_a_mm", "semi-axis of its ellipse along the rim", error="a third of the load's")
    #: Semi-axis across the rim [m]; None likewise.
    b: float | None = quantity("semi_axis_b_mm", "semi-axis across the rim", error="a third of the load's")
    #: Height of the contact above the cone's race [m].
    height: float = quantity("height_mm", "height of the contact above the cone's race, as given or assumed")
    #: What is assumed or not known.
    words: str = quantity("words", "what is assumed or not known", show=lambda words: words or None, default="")


def rib_contact(row: RollerRow, loads: Array) -> RibContact | None:
    """Return the contact of the most loaded roller of a row with its rib.

    Range: straight or crowned rollers seated on their ribs, ellipse small against the end; the ellipse is truncated where
    its semi-axis b is larger than the height.

    Parameters
    ----------
    row
        The row.
    loads
        Force of either race on each roller ``(count,)`` [N].

    Returns
    -------
    RibContact | None
        The contact; None without load.

    Raises
    ------
    ValueError
        A radius of the end that `rib_geometry` refuses.
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
            words.append("the ellipse reaches below the rib's contact surface: its pressure is higher")
    return RibContact(worst + 1, load, pressure, a, b, height, "; ".join(words))


def rib_contact_ellipse(row: RollerRow, load: Array | float) -> tuple[Array, Array]:
    """Return the semi-axes of the contact with the rib along and across the rim [m].

    Parameters
    ----------
    row
        The row.
    load
        Forces of the rib [N], any shape.

    Returns
    -------
    tuple[Array, Array]
        Arrays of the shape of the forces; zero, as for a point contact, where the radius of the end is not given.

    Raises
    ------
    ValueError
        A radius of the end that `rib_geometry` refuses.
    """
    root = np.cbrt(np.asarray(load, dtype=float))
    if row.end_radius is None:
        return 0.0 * root, 0.0 * root
    E, nu = row.material.youngs_modulus, row.material.poissons_ratio
    along, across = rib_geometry(tapered_bearing(row), row.end_radius, rib_height(row)).curvatures
    h = hertz_constants(np.array(along), np.array(across), contact_modulus(E, nu, E, nu))
    return np.asarray(h.C_a * root), np.asarray(h.C_b * root)


def mean_distance(a: Array, b: Array, height: float) -> Array:
    """Return the mean distance of a contact's pressure from a point at the height h across it, int p r dA/F [m].

    With sqrt(1 - s^2) = u of the relative radius s the pressure's weight is 3 u^2/(2 pi): Gauss and trapezoid rule, to
    1e-4.

    Parameters
    ----------
    a, b
        Semi-axes along and across the rim ``(n,)`` [m]; zero for a point contact, whose distance is the height.
    height
        h [m].
    """
    u, angle = 0.5 * (1.0 + _U[:, None]), 2.0 * np.pi * (np.arange(64) + 0.5) / 64.0
    s = np.sqrt(1.0 - u**2)
    x, y = (np.multiply.outer(np.asarray(k, dtype=float), s * f(angle)) for k, f in ((a, np.cos), (b, np.sin)))
    weight = 1.5 * u**2 * _W[:, None] / 64.0
    return np.asarray((weight * np.hypot(x, y + height)).sum(axis=(-2, -1)))


def roller_speed_ratios(bearing: TaperedBearing) -> tuple[float, float]:
    """Return the angular speeds of a roller against cone and cup over that of the rings against each other, by (4)."""
    over = float(np.sin(2.0 * bearing.roller_angle))
    return float(np.sin(bearing.cup_angle)) / over, float(np.sin(bearing.cone_angle)) / over
