"""The worst contact of a load distribution by Hertz, its static safety, and where an ellipse leaves its groove."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.lowfi.statics.contacts import curvature_changes, nominal_curvatures, own_hertz
from rollbench.lowfi.statics.validity import DENT_PRESSURE, groove_range
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import Specimen
from rollbench.meshes.one_arc import is_one_arc
from rollbench.meshes.parts import SIDES, Scene

#: Permanent indentation over the ball's diameter that the static rating of ball contacts allows (ISO 76).
ALLOWED = 1e-4
#: Constant of Palmgren's permanent deformation [m^3/N^2]: 1.3e-7 in mm and N.
PALMGREN = 1.3e-19


@dataclass(frozen=True)
class Contact:
    """One contact by Hertz, with its own radii of ball and groove at the nominal contact angle.

    ball from 1; side; force [N]; angle [rad]; approach, semi-axes a (across the groove) and b [m]; pole pressure [Pa].
    """

    ball: int
    side: str
    force: float
    angle: float
    approach: float
    a: float
    b: float
    pressure: float


@dataclass(frozen=True)
class StaticSafety:
    """Of the contact of highest pressure. factor: force at the allowed pressure [Pa] over its force, (4200 MPa / p)^3 of
    balls, (4000 MPa / p)^2 of rollers; permanent: of balls, its lasting indentation over the ball's diameter, of which ISO
    76 allows 1e-4."""

    factor: float
    allowed: float
    permanent: float | None = None


@dataclass(frozen=True)
class Truncation:
    """The ellipse that comes nearest to an edge of its groove's arc, or leaves it most.

    ball from 1; side; edge: ``"land"``, or ``"apex"`` between two arcs; angle, half: contact angle and half width of the
    ellipse as an angle of the groove's arc [rad]; limit: the angle of the edge [rad]; margin [rad]: from the ellipse to it,
    negative where it is cut; cut: number of contacts whose ellipse passes an edge.
    """

    ball: int
    side: str
    edge: str
    angle: float
    half: float
    limit: float
    margin: float
    cut: int


def worst_contact(scene: Scene, drawn: Specimen, load: Array, angle: Array) -> Contact | None:
    """The loaded contact of the highest pole pressure, None without load. load ``(n, 4)`` [N], angle ``(n, 4)`` [rad].

    Elliptical Hertz contact (Johnson 1985, 4.2) of the radii of ball and groove that are drawn, whatever constants the
    force law has (ingredient ``hertz``); valid as long as the ellipse is small against ball and groove. Raises ValueError
    where a drawn ball conforms to its groove.
    """
    if not (load > 0.0).any():
        return None
    h = own_hertz(scene, drawn)
    pressure = h.pressure(load)
    i, s = (int(k) for k in np.unravel_index(int(pressure.argmax()), load.shape))
    force, root = float(load[i, s]), float(np.cbrt(load[i, s]))
    return Contact(
        i + 1,
        SIDES[s],
        force,
        float(angle[i, s]),
        float(h.C[i, s]) * root**2,
        float(h.C_a[i, s]) * root,
        float(h.C_b[i, s]) * root,
        float(pressure[i, s]),
    )


def static_safety(scene: Scene, drawn: Specimen, worst: Contact) -> StaticSafety:
    """Static safety of a contact of hardened bearing steel.

    By pressure: ISO 76 rates a ball contact at the load of 4200 MPa. By indentation, as ISO 3408-5: Palmgren (1959; Harris
    and Kotzalas 2007, ball against raceway), permanent deformation of both surfaces together
    1.3e-7 Q^2/D (sum of curvatures across) (sum along) in mm and N; fitted near the elastic limit, hardness 63 to 65 HRC.
    D and curvatures are the contact's own.
    """
    i, s = worst.ball - 1, SIDES.index(worst.side)
    across, along = (nominal_curvatures(scene) + curvature_changes(scene, drawn, drawn.ball_radius))[i, s]
    diameter = 2.0 * float(drawn.ball_radius[i])
    permanent = PALMGREN * worst.force**2 / diameter * float(across * along)
    return StaticSafety((DENT_PRESSURE / worst.pressure) ** 3, DENT_PRESSURE, permanent / diameter)


def truncation(scene: Scene, drawn: Specimen, load: Array, angle: Array) -> Truncation | None:
    """Where the ellipses reach on the arcs of their grooves; None without load. Arguments as for `worst_contact`.

    The nut's land is not dimensioned in a low-order scene: its arc ends at 90 deg. Raises ValueError where the screw's
    surface does not cut its groove, and as `worst_contact`.
    """
    loaded = (load > 0.0) & np.isfinite(angle)
    if not loaded.any():
        return None
    low, high = groove_range(scene)
    half = own_hertz(scene, drawn).C_a * np.cbrt(load) / drawn.radius
    to_land = np.where(loaded, high - angle - half, np.inf)
    to_apex = np.where(loaded, angle - half - low, np.inf)
    margin = np.minimum(to_land, to_apex)
    i, s = (int(k) for k in np.unravel_index(int(margin.argmin()), load.shape))
    land = bool(to_land[i, s] <= to_apex[i, s])
    return Truncation(
        i + 1,
        SIDES[s],
        "land" if land or is_one_arc(scene) else "apex",
        float(angle[i, s]),
        float(half[i, s]),
        float(high[s] if land else low[s]),
        float(margin[i, s]),
        int((margin < 0.0).sum()),
    )
