"""The worst contact of a load distribution by Hertz, its static safety, and where an ellipse leaves its groove."""

from __future__ import annotations

import numpy as np

from rollbench.lowfi.statics.contacts import curvature_changes, nominal_curvatures, own_hertz
from rollbench.lowfi.statics.validity import DENT_PRESSURE, groove_range
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import Specimen
from rollbench.meshes.one_arc import is_one_arc
from rollbench.meshes.parts import SIDES, Scene
from rollbench.meshes.quantity import Stated, quantity, record

#: Permanent indentation over the ball's diameter that the static rating of ball contacts allows (ISO 76).
ALLOWED = 1e-4
#: Constant of Palmgren's permanent deformation [m^3/N^2]: 1.3e-7 in mm and N.
PALMGREN = 1.3e-19


@record
class Contact:
    """One contact by Hertz, with its own radii of ball and groove at the nominal contact angle.

    ball from 1; side; force [N]; angle [rad]; approach, semi-axes a (across the groove) and b [m]; pole pressure [Pa].
    """

    ball: int = quantity("ball", "ball of the highest pressure")
    side: str = quantity("side", "its flank")
    force: float = quantity("force_N", "its load F", error="that of the load")
    angle: float = quantity("contact_angle_deg", "its contact angle")
    approach: float = quantity(
        "approach_um",
        "local Hertz approach of ball and groove, delta = (F/C)^(2/3)",
        error="two thirds of the load's",
        heading="approach of its contact",
        form=".3f",
    )
    a: float = quantity(
        "semi_axis_a_mm",
        "larger semi-axis of the contact ellipse, along the groove's profile",
        error="a third of the load's",
        heading="larger semi-axis",
        form=".4f",
    )
    b: float = quantity("semi_axis_b_mm", "smaller semi-axis, along the track", error="a third of the load's")
    pressure: float = quantity(
        "pressure_MPa",
        "largest pressure, of the radii that ball and groove have with their errors, at the nominal contact angle: "
        "3 F/(2 pi a b) of a ball, 2 q/(pi b) = sqrt(q E*/(pi R)) of a roller",
        error="of balls a third of the load's, `model_form.pressure_percent`; of rollers half the line load's",
        heading="peak pressure",
        form=".0f",
    )


@record
class StaticSafety:
    """Of the contact of highest pressure. factor: force at the allowed pressure [Pa] over its force, (4200 MPa / p)^3 of
    balls, (4000 MPa / p)^2 of rollers; permanent: of balls, its lasting indentation over the ball's diameter, of which ISO
    76 allows 1e-4."""

    factor: float = quantity(
        "factor",
        "(allowed pressure / largest pressure)^3, of rollers ^2: how many times the load may grow",
        error="that of the load",
        heading="static safety",
        form=".2f",
    )
    allowed: float = quantity("allowed_pressure_MPa", "4,200 MPa of balls, 4,000 MPa of rollers (ISO 76)")
    permanent: float | None = quantity(
        "permanent_over_diameter",
        "lasting dent over the ball's diameter, by Palmgren's formula",
        error="twice that of the load",
        default=None,
    )

    @property
    @Stated("allowed_over_diameter", "1e-4, the dent that standards allow")
    def allowed_permanent(self) -> float:
        """What ISO 76 allows of ``permanent``."""
        return ALLOWED


@record
class Truncation:
    """The ellipse that comes nearest to an edge of its groove's arc, or leaves it most.

    ball from 1; side; edge: ``"land"``, or ``"apex"`` between two arcs; angle, half: contact angle and half width of the
    ellipse as an angle of the groove's arc [rad]; limit: the angle of the edge [rad]; margin [rad]: from the ellipse to it,
    negative where it is cut; cut: number of contacts whose ellipse passes an edge.
    """

    ball: int = quantity("ball", "ball whose ellipse comes nearest to an edge of its groove")
    side: str = quantity("side", "its flank")
    edge: str = quantity("edge", "which edge: land, or apex between two arcs; a groove of one arc has lands at both ends")
    angle: float = quantity("contact_angle_deg", "its contact angle")
    half: float = quantity("ellipse_half_width_deg", "half width of the ellipse over the groove's profile")
    limit: float = quantity("edge_angle_deg", "angle of the edge on the same profile")
    margin: float = quantity(
        "margin_deg",
        "edge angle less contact angle and half width; negative: the ellipse is cut",
        heading="ellipse to edge of groove",
        form=".2f",
    )
    cut: int = quantity("contacts_cut", "contacts whose ellipse passes an edge")


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
