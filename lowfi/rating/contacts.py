"""The worst contact of a load distribution, of balls by Hertz or of tapered rollers, and its static safety.

Basic static load ratings C0 of rings (ISO 76) and ball screws (ISO 3408-5), by the most heavily loaded contact.

A contact's own rating Q_0 is the lesser of its two raceways'. Rings, as ISO 76 has it for all but self-aligning ball
bearings: the force of a pole pressure of 4,200 MPa by Hertz, whose lasting dent in ball and raceway together is about 1e-4
of the ball's diameter D. Screws, as ISO 3408-5 has it: the force of that dent itself by Palmgren's formula, lengths in mm,

    1.3e-7 Q^2/D (1/D across)(1/D along) = 1e-4 D,  so  Q_0 = 27.74 D/sqrt(across along),                             (1)

across and along the relative curvatures [1/mm] of ball and groove. Of Z balls, all loads along the axis even, or radial
ones on half a circle without clearance (Stribeck's 5):

    C_0a = Z Q_0 sin(alpha) cos(phi)  (screws; rings above 45 deg),   C_0r = Z Q_0 cos(alpha)/5  (rings up to 45 deg).  (2)

Range: parts of hardened bearing steel; ISO 76's tables take E = 207 GPa and nu = 0.3, this the materials of the scene.
"""

from __future__ import annotations

from math import cos

import numpy as np

from rollbench.lowfi.rating.life import is_thrust, rating, standard_of
from rollbench.lowfi.rating.rigidity import slope_of
from rollbench.lowfi.rollers import middles, roller_contacts, slice_contacts, tapered
from rollbench.lowfi.statics.contacts import curvature_changes, error_free_hertz, nominal_curvatures, own_hertz
from rollbench.lowfi.statics.validity import DENT_PRESSURE, ROLLER_DENT_PRESSURE, groove_range
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import RollerRow
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


def worst_contact(
    scene: Scene, drawn: Specimen, load: Array, angle: Array, pressure: Array | None = None
) -> Contact | None:
    """The loaded contact of the highest pole pressure, None without load. load ``(n, 4)`` [N], angle ``(n, 4)`` [rad];
    pressure ``(n, 4)`` [Pa] in place of Hertz's.

    Elliptical Hertz contact (Johnson 1985, 4.2) of the radii of ball and groove that are drawn, whatever constants the
    force law has (ingredient ``hertz``); valid as long as the ellipse is small against ball and groove. Raises ValueError
    where a drawn ball conforms to its groove.
    """
    if not (load > 0.0).any():
        return None
    h = own_hertz(scene, drawn)
    pressure = h.pressure(load) if pressure is None else pressure
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


#: Raceways of a roller, inner (cone) and outer (cup).
RACES = ("inner", "outer")


@record
class RollerContact:
    """Line contact of the highest pressure.

    roller from 1; race: of `RACES`; force: the roller's load on either race [N]; place [m]: along the roller from its
    middle, outwards, where line_load [N/m], half_width b [m] and pressure [Pa] are; other: the greatest pressure on the
    other race of that roller [Pa]; middle: at the middle of the roller under its load evenly spread [Pa].
    """

    roller: int = quantity("roller", "roller of the highest pressure")
    race: str = quantity("race", "its race: inner or outer")
    force: float = quantity("force_N")
    place: float = quantity("place_mm", "that place, from the roller's middle, positive to its large end")
    line_load: float = quantity(
        "line_load_N_mm",
        "load per length q where the pressure is highest",
        error="without what the ends of straight rollers add",
    )
    half_width: float = quantity(
        "half_width_mm", "half-width b of the strip there, sqrt(4 q R/(pi E*))", error="half that of the line load"
    )
    pressure: float = quantity("pressure_MPa", heading="peak pressure", form=".0f")
    other: float = quantity(
        "other_race_pressure_MPa", "largest pressure of that roller on its other race", error="half that of the line load"
    )
    middle: float = quantity(
        "middle_pressure_MPa",
        "pressure at the roller's middle diameter if its load were spread evenly along it",
        error="half that of the load",
    )


def race_pressures(row: RollerRow, line_loads: Array) -> Array:
    """Greatest pressures ``(count, 2)`` [Pa] along every roller at inner and outer race; line_loads ``(count, slices)``
    [N/m]."""
    return np.asarray(slice_contacts(tapered(row), line_loads)[1].max(axis=1))


def worst_roller(row: RollerRow, line_loads: Array) -> RollerContact | None:
    """The place of the highest pressure of a row, None without load; line_loads ``(count, slices)`` [N/m].

    Equations and range: `lowfi.rollers.slice_contacts`. Under an even line load the place is the small end,
    where the curvatures are greatest.
    """
    bearing = tapered(row)
    half_width, pressure = slice_contacts(bearing, line_loads)
    if not (pressure > 0.0).any():
        return None
    i, k, race = (int(x) for x in np.unravel_index(int(pressure.argmax()), pressure.shape))
    force = float(line_loads[i].mean()) * row.length
    return RollerContact(
        roller=i + 1,
        race=RACES[race],
        force=force,
        place=float(middles(row.length, row.slices)[k]),
        line_load=float(line_loads[i, k]),
        half_width=float(half_width[i, k, race]),
        pressure=float(pressure[i, k, race]),
        other=float(pressure[i, :, 1 - race].max()),
        middle=float(roller_contacts(bearing, force).pressures[race]),
    )


def roller_safety(worst: RollerContact) -> StaticSafety:
    """Static safety of a line contact of hardened bearing steel: ISO 76 rates those of roller bearings at the load of 4000
    MPa, and pressure grows with the root of the load."""
    return StaticSafety((ROLLER_DENT_PRESSURE / worst.pressure) ** 2, ROLLER_DENT_PRESSURE)


#: Largest contact force over the mean radial share of a ball, radial load and no clearance (Stribeck; ISO 76).
STRIBECK = 5.0


def contact_rating(scene: Scene) -> float:
    """Force Q_0 [N] that a contact of the scene is rated at, of one pair of opposite raceways."""
    if scene.track.lead > 0.0:
        dent = nominal_curvatures(scene)[[0, 3]].prod(axis=1)
        diameter = 2.0 * scene.balls.radius
        return float(diameter * np.sqrt(ALLOWED / (PALMGREN * dent.max())))
    of_one_newton = error_free_hertz(scene).pressure(np.ones((1, 4)))[0, [0, 3]]
    return float((DENT_PRESSURE / of_one_newton.max()) ** 3)


def static_rating(scene: Scene) -> float:
    """Basic static load rating C_0 [N] by (2): axial for a screw and a thrust bearing, radial for a ring up to 45 deg."""
    ratings = scene.ball_count * contact_rating(scene)
    if is_thrust(scene) or scene.track.lead > 0.0:
        return ratings * slope_of(scene)
    return ratings * cos(scene.track.contact_angle) / STRIBECK


@record
class Ratings:
    """Basic load ratings as computed [N]: dynamic C, static C_0; axial or radial; whose formulas."""

    dynamic: float = quantity("dynamic_N", "basic dynamic load rating C")
    static: float = quantity("static_N", "basic static load rating C0")
    axial: bool = quantity("direction", "axial or radial", show=lambda axial: "axial" if axial else "radial")
    dynamic_standard: str = quantity("dynamic_standard", "whose formulas")
    static_standard: str = quantity("static_standard", "whose formulas")


def ratings(scene: Scene) -> Ratings:
    """Both ratings of a scene. Raises ValueError as `lowfi.rating.life.contact_capacity`."""
    axial = is_thrust(scene) or scene.track.lead > 0.0
    static_standard = "ISO 3408-5" if scene.track.lead > 0.0 else "ISO 76"
    return Ratings(rating(scene), static_rating(scene), axial, standard_of(scene), static_standard)
