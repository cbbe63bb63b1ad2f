"""Contact of the highest pressure of balls or tapered rollers, its static safety, and static load ratings.

The basic static load rating C0 of ball bearings (ISO 76) and ball screws (ISO 3408-5) follows from the permissible force
Q_0 of the most heavily loaded contact, the smaller one of its two raceways. For bearings (ISO 76, all but self-aligning
ball bearings) Q_0 causes a largest Hertz pressure of 4,200 MPa; the permanent indentation of ball and raceway together is
then about 1e-4 of the ball's diameter D. For screws (ISO 3408-5) Q_0 causes that indentation by Palmgren's formula, lengths
in mm,

    1.3e-7 Q^2/D (1/D across)(1/D along) = 1e-4 D,  so  Q_0 = 27.74 D/sqrt(across along),                             (1)

with the relative curvatures of ball and groove, across the groove and along the track [1/mm]. For Z balls under equal axial
loads, or under a radial load on half a circle without clearance (Stribeck's factor 5), the ratings are

    C_0a = Z Q_0 sin(alpha) cos(phi)  (screws; bearings above 45 deg),
    C_0r = Z Q_0 cos(alpha)/5         (bearings up to 45 deg).                                                        (2)

Valid for parts of hardened bearing steel. ISO 76's tables assume E = 207 GPa and nu = 0.3; here the materials of the scene
are used.
"""

from __future__ import annotations

from math import cos
from typing import ClassVar, TypeAlias

import numpy as np

from rollbench.lowfi import rollers
from rollbench.lowfi.rating.life import dynamic_rating, is_thrust_bearing, name_life_standard
from rollbench.lowfi.rating.rigidity import approach_per_displacement
from rollbench.lowfi.statics import contacts
from rollbench.lowfi.statics.result import StaticResult
from rollbench.lowfi.statics.validity import DENT_PRESSURE, ROLLER_DENT_PRESSURE, contact_angle_limits
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import RollerRow
from rollbench.meshes.errors import GeometryWithErrors, draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.one_arc import has_single_arc_grooves
from rollbench.meshes.parts import SIDES, Scene
from rollbench.meshes.quantity import QuantityDescription, quantity_field, result_record

#: Permanent indentation over the ball's diameter at the static load rating (ISO 76).
ALLOWED = 1e-4

#: Constant of Palmgren's formula for permanent indentation [m^3/N^2]; 1.3e-7 in mm and N.
PALMGREN = 1.3e-19


@result_record
class BallContact:
    """The contact of a ball with a groove flank that has the highest pressure, with radii with manufacturing errors."""

    #: Number of the ball, from 1.
    element: int = quantity_field("ball", "number of the ball with the highest pressure")
    #: Name of the groove flank: SL, SR, NL or NR (S: screw or inner ring, N: nut or outer ring; L: left, R: right).
    side: str = quantity_field("side", "groove flank of the contact with the highest pressure")
    #: Contact force F [N].
    force: float = quantity_field("force_N", "contact load F", error="that of the load")
    #: Contact angle of the ball on this flank [rad].
    angle: float = quantity_field("contact_angle_deg", "contact angle of this contact")
    #: Hertz approach of ball and groove [m].
    approach: float = quantity_field(
        "approach_um",
        "local Hertz approach of ball and groove, delta = (F/C)^(2/3)",
        error="two thirds of the load's",
        expected=("pressure", 2.0),
    )
    #: Larger semi-axis of the contact ellipse [m], across the groove.
    a: float = quantity_field(
        "semi_axis_a_mm",
        "larger semi-axis of the contact ellipse, along the groove's profile",
        error="a third of the load's",
        expected=("pressure", 1.0),
    )
    #: Smaller semi-axis of the contact ellipse [m], along the track.
    b: float = quantity_field(
        "semi_axis_b_mm", "smaller semi-axis of the contact ellipse, along the track", error="a third of the load's"
    )
    #: Largest contact pressure [Pa].
    pressure: float = quantity_field(
        "pressure_MPa",
        "largest pressure, for the radii of ball and groove with their errors, at the nominal contact angle: "
        "3 F/(2 pi a b) of a ball, 2 q/(pi b) = sqrt(q E*/(pi R)) of a roller",
        error="of balls a third of the load's, `model_form.pressure_percent`; of rollers half the line load's",
        heading="peak pressure",
        expected=("pressure", 1.0),
        note="ball {ball} {side}",
    )
    #: Static safety of this contact.
    static_safety: StaticSafety
    #: Name of the nut or bearing that the contact belongs to; empty if the scene has only one.
    set: str = ""

    @property
    def safety(self) -> float:
        """Static safety factor [1]: contact load at the allowed pressure (4200 MPa) divided by the contact load."""
        return self.static_safety.factor

    @property
    def semi_axes(self) -> tuple[float, float]:
        """Semi-axes of the contact ellipse, across and along the groove [m]."""
        return self.a, self.b


@result_record
class StaticSafety:
    """Static safety factor of the contact with the highest pressure, with the permissible pressure and indentation."""

    #: Ratio of the force at the permissible pressure to the contact force: (4200 MPa/p)^3 of balls, (4000 MPa/p)^2 of
    #: rollers.
    factor: float = quantity_field(
        "factor",
        "ratio of the permissible to the actual load: (permissible / largest pressure)^3, for rollers ^2",
        error="that of the load",
        heading="static safety",
        form="g3",
        expected=("pressure", 3.0),
        note="{allowed_pressure_MPa} MPa (ISO 76)",
    )
    #: Permissible contact pressure [Pa].
    allowed_pressure: float = quantity_field(
        "allowed_pressure_MPa", "permissible pressure: 4,200 MPa for balls, 4,000 MPa for rollers (ISO 76)"
    )
    #: Permanent indentation of ball and groove together over the ball's diameter (ISO 76 permits 1e-4); None for rollers.
    permanent_indentation: float | None = quantity_field(
        "permanent_over_diameter",
        "permanent indentation over the ball's diameter, by Palmgren's formula",
        error="twice that of the load",
        optional=True,
        default=None,
    )
    #: The same factor by the maker's C0 in place of the computed one; None: the scene gives no such C0.
    by_maker: float | None = quantity_field(
        "maker_factor",
        "static safety times the maker's C0 (key `rating.static`) over the computed C0; null if it is not given",
        error="that of the load",
        heading="static safety by the maker's C0",
        form="g3",
        default=None,
    )

    @property
    @QuantityDescription(
        "allowed_over_diameter", "permissible permanent indentation over the ball's diameter, 1e-4", optional=True
    )
    def allowed_indentation(self) -> float | None:
        """Largest permanent indentation over the ball's diameter that ISO 76 permits, 1e-4; None for rollers."""
        return None if self.permanent_indentation is None else ALLOWED


@result_record
class EllipseTruncation:
    """Contact ellipse that is nearest to an edge of its groove's arc, or that extends farthest beyond the edge."""

    #: Number of the ball whose ellipse it is, from 1.
    ball: int = quantity_field("ball", "number of the ball whose contact ellipse comes nearest to an edge of its groove")
    #: Name of the groove flank: SL, SR, NL or NR (S: screw or inner ring, N: nut or outer ring; L: left, R: right).
    side: str = quantity_field("side", "groove flank of this contact ellipse")
    #: Edge of the groove's arc: ``"land"``, at the cylindrical surface beside the groove, or ``"apex"``, where the two arcs
    #: of a groove meet.
    edge: str = quantity_field(
        "edge", "edge of the groove's arc: land, or apex between two arcs; a groove of one arc has lands at both ends"
    )
    #: Contact angle of the ball on this flank [rad].
    angle: float = quantity_field("contact_angle_deg", "contact angle at this contact ellipse")
    #: Half width of the ellipse as an angle on the groove's arc [rad].
    half_width_angle: float = quantity_field(
        "ellipse_half_width_deg", "half width of the contact ellipse, as an angle on the groove's arc"
    )
    #: Angle of the arc's edge [rad], measured from the groove's bottom like the contact angle.
    edge_angle: float = quantity_field("edge_angle_deg", "angle of the edge on the groove's arc")
    #: Angle on the groove's arc from the end of the ellipse to the edge of the arc [rad]; negative if the ellipse is
    #: truncated.
    margin: float = quantity_field(
        "margin_deg",
        "angle from the contact ellipse to the edge of the groove's arc; negative: the ellipse is truncated",
        heading="angle, ellipse to groove edge",
        form="g3",
        note="ball {ball} {side}, {edge}",
    )
    #: Number of contacts whose ellipse extends beyond an edge.
    truncated_contacts: int = quantity_field(
        "contacts_cut", "number of contacts whose ellipse extends beyond an edge", heading="truncated contact ellipses"
    )


def contact_pressures(scene: Scene, static_result: StaticResult) -> Array:
    """Return the largest pressure in each of the four contacts of n balls ``(n, 4)`` [Pa]; nan without equilibrium.

    If the model of the result ``static_result`` computes no pressures, they follow from the loads by Hertz's theory, for
    radii with their random errors.
    """
    if static_result.pressure is not None:
        return static_result.pressure
    if not np.isfinite(static_result.load).all():
        return static_result.load
    drawn = draw_geometry_with_errors(scene, ball_layout(scene), static_result.member)
    return contacts.hertz_of_every_contact(scene, drawn).pressure(static_result.load)


def contact_of_highest_pressure(
    scene: Scene, drawn: GeometryWithErrors, load: Array, angle: Array, pressure: Array | None = None
) -> BallContact | None:
    """Return the contact of a ball with a groove flank that has the highest pressure.

    It is an elliptical Hertz contact for the radii of ball and groove with their random errors, even if the model computes
    its contact forces with error-free radii. Valid for ellipses small against ball and groove.

    Parameters
    ----------
    scene, drawn
        Scene, and the dimensions of screw, nut and balls with their random errors.
    load
        Contact forces ``(n, 4)`` [N].
    angle
        Contact angles ``(n, 4)`` [rad].
    pressure
        Largest pressure in each contact ``(n, 4)`` [Pa], to use in place of Hertz's; None for Hertz's pressures.

    Returns
    -------
    BallContact | None
        The contact; None without load.

    Raises
    ------
    ValueError
        A ball with its errors conforms to its groove.

    References
    ----------
    Johnson (1985), 4.2.
    """
    if not (load > 0.0).any():
        return None
    h = contacts.hertz_of_every_contact(scene, drawn)
    pressure = h.pressure(load) if pressure is None else pressure
    i, s = (int(k) for k in np.unravel_index(int(pressure.argmax()), load.shape))
    force, at, highest = (float(x[i, s]) for x in (load, angle, pressure))
    C, C_a, C_b = (float(x[i, s]) for x in (h.C, h.C_a, h.C_b))
    root = float(np.cbrt(force))
    safety = static_safety(scene, drawn, (i, s), force, highest)
    return BallContact(i + 1, SIDES[s], force, at, C * root**2, C_a * root, C_b * root, highest, safety)


def static_safety(
    scene: Scene, drawn: GeometryWithErrors, contact: tuple[int, int], force: float, pressure: float
) -> StaticSafety:
    """Return the static safety of a ball contact, between parts of hardened bearing steel.

    The permissible load of a ball contact is the load at which its largest pressure is 4200 MPa (ISO 76). The permanent
    indentation is also returned (ISO 3408-5): a force Q indents both surfaces together by 1.3e-7 Q^2/D times the relative
    curvatures across and along the groove, in mm and N. The formula was measured near the elastic limit at a hardness of 63
    to 65 HRC. The ball diameter D and the curvatures contain the random errors.

    Parameters
    ----------
    scene, drawn
        Scene, and the dimensions of screw, nut and balls with their random errors.
    contact
        Index of the ball, and index of the flank in `SIDES`.
    force, pressure
        Contact force [N] and largest pressure [Pa].

    References
    ----------
    Palmgren (1959); Harris and Kotzalas (2007), ball against raceway.
    """
    changes = contacts.curvature_changes(scene, drawn, drawn.ball_radii)
    across, along = (contacts.nominal_curvatures(scene) + changes)[contact]
    diameter = 2.0 * float(drawn.ball_radii[contact[0]])
    permanent = PALMGREN * force**2 / diameter * float(across * along)
    factor, given = (DENT_PRESSURE / pressure) ** 3, scene.rating.static
    by_maker = None if given is None else factor * given / static_rating(scene)
    return StaticSafety(factor, DENT_PRESSURE, permanent / diameter, by_maker)


def most_truncated_ellipse(scene: Scene, drawn: GeometryWithErrors, load: Array, angle: Array) -> EllipseTruncation | None:
    """Return the contact ellipse that is nearest to an edge of its groove's arc, and the number of truncated ellipses.

    The nut's arc is assumed to end at 90 deg, because a low-order scene does not give the dimension of the nut's land.

    Parameters
    ----------
    scene, drawn
        Scene, and the dimensions of screw, nut and balls with their random errors.
    load
        Contact forces ``(n, 4)`` [N].
    angle
        Contact angles ``(n, 4)`` [rad].

    Returns
    -------
    EllipseTruncation | None
        The ellipse with the smallest margin; None without load.

    Raises
    ------
    ValueError
        The screw's outer cylinder does not cut its groove, or a ball with its errors conforms to its groove.
    """
    loaded = (load > 0.0) & np.isfinite(angle)
    if not loaded.any():
        return None
    low, high = contact_angle_limits(scene)
    half = contacts.hertz_of_every_contact(scene, drawn).C_a * np.cbrt(load) / drawn.groove_radii
    to_land = np.where(loaded, high - angle - half, np.inf)
    to_apex = np.where(loaded, angle - half - low, np.inf)
    margin = np.minimum(to_land, to_apex)
    i, s = (int(k) for k in np.unravel_index(int(margin.argmin()), load.shape))
    at_high = bool(to_land[i, s] <= to_apex[i, s])
    edge = "land" if at_high or has_single_arc_grooves(scene) else "apex"
    at, width, left = (float(x[i, s]) for x in (angle, half, margin))
    end = float(high[s] if at_high else low[s])
    return EllipseTruncation(i + 1, SIDES[s], edge, at, width, end, left, int((margin < 0.0).sum()))


#: Names of a roller's raceways, inner (cone) and outer (cup).
RACES = ("inner", "outer")


@result_record
class RollerContact:
    """The line contact with the highest pressure in a row of tapered rollers."""

    #: Number of the roller, from 1.
    element: int = quantity_field("roller", "number of the roller with the highest pressure")
    #: Race of the contact, ``"inner"`` or ``"outer"``.
    side: str = quantity_field("race", "race with the highest pressure: inner or outer")
    #: Force of either race on the roller [N].
    force: float = quantity_field("force_N")
    #: Distance of the highest pressure from the roller's middle [m], positive towards the large end.
    position_along_roller: float = quantity_field(
        "place_mm", "position of the highest pressure, from the roller's middle, positive towards its large end"
    )
    #: Load per length at the position of the highest pressure [N/m].
    line_load: float = quantity_field(
        "line_load_N_mm",
        "load per length q where the pressure is highest",
        error="does not include the stress concentration at the ends of straight rollers",
    )
    #: Half-width b of the line contact at the position of the highest pressure [m].
    half_width: float = quantity_field(
        "half_width_mm",
        "half-width b of the line contact at that position, sqrt(4 q R/(pi E*))",
        error="half that of the line load",
    )
    #: Highest contact pressure in the row of rollers [Pa].
    pressure: float = quantity_field("pressure_MPa", heading="peak pressure", note="roller {roller}, {race} race")
    #: Largest pressure on the roller's other race [Pa].
    other_race_pressure: float = quantity_field(
        "other_race_pressure_MPa", "largest pressure of that roller on its other race", error="half that of the line load"
    )
    #: Pressure at the roller's middle if its load were uniform along its length [Pa].
    uniform_load_pressure: float = quantity_field(
        "middle_pressure_MPa",
        "pressure at the roller's middle diameter if its load were spread evenly along it",
        error="half that of the load",
    )
    #: Static safety of this contact.
    static_safety: StaticSafety
    #: Name of the nut or bearing that the contact belongs to.
    set: str = ""
    #: Contact angle, approach and semi-axes, which only the contacts of balls have.
    angle: ClassVar[None] = None
    approach: ClassVar[None] = None
    semi_axes: ClassVar[None] = None

    @property
    def safety(self) -> float:
        """Static safety factor [1]: contact load at the allowed pressure (4000 MPa) divided by the contact load."""
        return self.static_safety.factor


#: The contact of a rolling body with a raceway that has the highest pressure.
WorstContact: TypeAlias = BallContact | RollerContact


def race_pressures(row: RollerRow, line_loads: Array) -> Array:
    """Return the largest pressure of every roller at inner and outer race ``(count, 2)`` [Pa].

    Parameters
    ----------
    row
        Row of tapered rollers.
    line_loads
        Loads per length of each roller's slices ``(count, slices)`` [N/m].
    """
    bearing = rollers.tapered_bearing_of_row(row)
    return np.asarray(rollers.half_widths_and_pressures_of_slices(bearing, line_loads)[1].max(axis=1))


def roller_contact_of_highest_pressure(
    row: RollerRow, line_loads: Array, maker_over_computed: float | None = None
) -> RollerContact | None:
    """Return the line contact with the highest pressure in a row of rollers, with its position and static safety.

    Equations and validity are those of `rollbench.lowfi.rollers.half_widths_and_pressures_of_slices`. Under a uniform line
    load the position is the small end, where the curvatures are largest. The permissible load of a contact between parts of
    hardened bearing steel is the load at which its largest pressure is 4000 MPa (ISO 76); the pressure is proportional to
    the square root of the load.

    Parameters
    ----------
    row
        Row of tapered rollers.
    line_loads
        Loads per length of each roller's slices ``(count, slices)`` [N/m].
    maker_over_computed
        The maker's static load rating over the computed one; None if it is not given.

    Returns
    -------
    RollerContact | None
        The contact; None without load.
    """
    bearing = rollers.tapered_bearing_of_row(row)
    half_width, pressure = rollers.half_widths_and_pressures_of_slices(bearing, line_loads)
    if not (pressure > 0.0).any():
        return None
    i, k, race = (int(x) for x in np.unravel_index(int(pressure.argmax()), pressure.shape))
    force, highest = float(line_loads[i].mean()) * row.length, float(pressure[i, k, race])
    factor = (ROLLER_DENT_PRESSURE / highest) ** 2
    by_maker = None if maker_over_computed is None else factor * maker_over_computed
    _, uniform = rollers.half_widths_and_pressures_of_slices(bearing, np.array([force / row.length]))
    return RollerContact(
        element=i + 1,
        side=RACES[race],
        force=force,
        position_along_roller=float(rollers.slice_middles(row.length, row.slices)[k]),
        line_load=float(line_loads[i, k]),
        half_width=float(half_width[i, k, race]),
        pressure=highest,
        other_race_pressure=float(pressure[i, :, 1 - race].max()),
        uniform_load_pressure=float(uniform[0, race]),
        static_safety=StaticSafety(factor, ROLLER_DENT_PRESSURE, by_maker=by_maker),
    )


#: Stribeck's factor: largest contact load over F_r/Z for Z balls under a radial load F_r without clearance (ISO 76).
STRIBECK = 5.0


def permissible_contact_force(scene: Scene) -> float:
    """Return the permissible static force Q_0 on a ball [N], the smaller of the values for its two opposite raceways."""
    if scene.track.lead > 0.0:
        dent = contacts.nominal_curvatures(scene)[[0, 3]].prod(axis=1)
        diameter = 2.0 * scene.balls.radius
        return float(diameter * np.sqrt(ALLOWED / (PALMGREN * dent.max())))
    of_one_newton = contacts.hertz_without_errors(scene).pressure(np.ones((1, 4)))[0, [0, 3]]
    return float((DENT_PRESSURE / of_one_newton.max()) ** 3)


def static_rating(scene: Scene) -> float:
    """Return the basic static load rating C_0 of a ball screw or ball bearing.

    With Z balls, the permissible contact force Q_0, the contact angle alpha and the lead angle phi, the axial rating is
    Z Q_0 sin(alpha) cos(phi) and the radial rating is Z Q_0 cos(alpha)/5.

    Parameters
    ----------
    scene
        Screw or bearing.

    Returns
    -------
    float
        C_0 [N]: axial for a screw (ISO 3408-5) and a thrust bearing, radial for a bearing up to 45 deg (ISO 76).

    Examples
    --------
    >>> import rollbench
    >>> scene = rollbench.read("lin-case1")
    >>> round(static_rating(scene)), round(dynamic_rating(scene))
    (23397, 11426)
    """
    ratings = scene.ball_count * permissible_contact_force(scene)
    if is_thrust_bearing(scene) or scene.track.lead > 0.0:
        return ratings * approach_per_displacement(scene)
    return ratings * cos(scene.track.contact_angle) / STRIBECK


@result_record
class Ratings:
    """Basic load ratings of a screw or bearing, computed from its dimensions."""

    #: Basic dynamic load rating C [N].
    dynamic: float = quantity_field(
        "dynamic_N",
        "basic dynamic load rating C",
        heading="dynamic load rating C",
        note="{direction}, as computed ({dynamic_standard})",
    )
    #: Basic static load rating C_0 [N].
    static: float = quantity_field(
        "static_N",
        "basic static load rating C0",
        heading="static load rating C0",
        note="{direction}, as computed ({static_standard})",
    )
    #: Whether the ratings are axial loads; otherwise they are radial loads.
    is_axial: bool = quantity_field(
        "direction", "direction of the ratings: axial or radial", show=lambda axial: "axial" if axial else "radial"
    )
    #: Standard whose formulas give the dynamic rating.
    dynamic_standard: str = quantity_field("dynamic_standard", "standard of the dynamic load rating")
    #: Standard whose formulas give the static rating.
    static_standard: str = quantity_field("static_standard", "standard of the static load rating")
    #: Dynamic load rating as the maker gives it [N]; None: not given.
    maker_dynamic: float | None = quantity_field(
        "maker_dynamic_N",
        "the maker's basic dynamic load rating C, as the scene gives it (key `rating.dynamic`); null if not given",
        heading="dynamic load rating C, maker",
        note="{direction}, as given",
        default=None,
    )
    #: Static load rating as the maker gives it [N]; None: not given.
    maker_static: float | None = quantity_field(
        "maker_static_N",
        "the maker's basic static load rating C0, as the scene gives it (key `rating.static`); null if not given",
        heading="static load rating C0, maker",
        note="{direction}, as given",
        default=None,
    )


def dynamic_and_static_ratings(scene: Scene) -> Ratings:
    """Return the dynamic and static load ratings of a ball screw or ball bearing.

    Parameters
    ----------
    scene
        Screw or bearing.

    Raises
    ------
    ValueError
        A groove radius does not exceed the ball's, or the contact angle of a screw is zero.
    """
    axial = is_thrust_bearing(scene) or scene.track.lead > 0.0
    static_standard = "ISO 3408-5" if scene.track.lead > 0.0 else "ISO 76"
    ours, maker = (dynamic_rating(scene), static_rating(scene)), (scene.rating.dynamic, scene.rating.static)
    return Ratings(*ours, axial, name_life_standard(scene), static_standard, *maker)
