"""Results of a solved scene: pressure, safety, life, rigidity, preload and friction, for one bearing row or nut or several.

The module also warns where a result is outside the range of validity of the models, and where the supports fix a
deep-groove bearing near one end of its axial play.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import degrees, sin
from typing import Any, TypeAlias

import numpy as np

from rollbench.compare.errors import ArgumentError, SceneNotCoveredError
from rollbench.compare.measure import mean_load
from rollbench.compare.models import loading
from rollbench.compare.models.registry import MODELS, ModelOptions, read_condensed_bodies, run_model, scene_key_of_error
from rollbench.compare.models.stiffness import NutStiffness, SceneStiffness, place_of_displacement, stiffness_of_scene
from rollbench.lowfi.bearings import torque as bearings_torque
from rollbench.lowfi.bearings.tapered_roller import RibContact, rib_contact
from rollbench.lowfi.compliance.parts import LADDER, REFINED
from rollbench.lowfi.rating import contacts, iso_lives, life, roller_life
from rollbench.lowfi.rating.catalogue_checks import ShaftLimits, shaft_limits
from rollbench.lowfi.rating.displacement import motion_at
from rollbench.lowfi.rating.iso_lives import ModifiedLife, modified_life
from rollbench.lowfi.rating.life import BasicRatingLife, dynamic_rating
from rollbench.lowfi.rating.rigidity import AxialRigidities, axial_force, three_axial_rigidities
from rollbench.lowfi.statics.result import AxisResult, SetResult, StaticResult
from rollbench.lowfi.statics.tangent import TangentStiffness, tangent_stiffness
from rollbench.lowfi.warned import ResultWarning
from rollbench.meshes import one_arc
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, RollerRow, RollingSet
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Load, Lubricant, Scene
from rollbench.meshes.quantity import QuantityDescription, quantity_field, result_record

#: Distance of a ring from the middle of its axial play, over half the play, from which on it counts as at the end [1].
AT_END = 0.9


def clearance_of_deep_groove(parts: Scene, thrust: str = "deep groove") -> one_arc.InternalClearance | None:
    """Return the clearance of a deep-groove ball bearing row; None for other rows and for rows without play.

    Parameters
    ----------
    parts
        Bearing row as a scene.
    thrust
        Direction of the axial force that the row can carry: "+z", "-z", "both", or "deep groove" (both directions).

    Returns
    -------
    InternalClearance or None
        Axial and radial play [m], and the contact angle at the end of the play [rad].
    """
    found = one_arc.internal_clearance(parts) if thrust == "deep groove" else None
    return found if found is not None and found.axial > 0.0 else None


def axial_play_warnings(scene: Scene | Assembly) -> Iterator[ResultWarning]:
    """Yield a warning for each deep-groove bearing row that the supports hold axially near one end of its axial play."""
    shaft = next((value for s in scene.supports for name, value in s.fixed if name == "uz"), None)
    if shaft is None:
        return
    if isinstance(scene, Scene):
        yield from _axial_play_warnings_of_row(scene, shaft)
        return
    for row in scene.sets:
        outer = _prescribed_outer_ring_displacement(scene, row)
        if isinstance(row.parts, Scene) and row.carrier is None and row.thrust == "deep groove" and outer is not None:
            yield from (w.with_part_name(row.name) for w in _axial_play_warnings_of_row(row.parts, shaft - outer))


def _axial_play_warnings_of_row(parts: Scene, displacement: float) -> Iterator[ResultWarning]:
    """Yield a warning if the supports hold a deep-groove bearing row axially near one end of its axial play.

    ``parts``: the row as a scene; ``displacement``: prescribed axial displacement of the inner ring relative to the outer
    ring [m].
    """
    clearance = clearance_of_deep_groove(parts)
    if clearance is None:
        return
    middle = -one_arc.distance_of_groove_centres(parts) * sin(parts.track.contact_angle)
    if abs(displacement - middle) < AT_END * 0.5 * clearance.axial:
        return
    yield ResultWarning(
        "play",
        f"the support fixes uz near one end of the bearing's axial play of {1e6 * clearance.axial:.4g} um, where the "
        f"unloaded balls touch at a contact angle of {degrees(clearance.angle):.3g} deg; the ring can then move radially "
        "by less than its radial clearance; free uz, or fix it "
        f"{1e6 * (middle - displacement):+.4g} um from there, in the middle of the play",
    )


def _prescribed_outer_ring_displacement(assembly: Assembly, row: RollingSet) -> float | None:
    """Return the prescribed axial displacement [m] of the outer ring of ``row``; None if its housing can move axially."""
    if row.housing is None:
        return row.offset
    housing = next(h for h in assembly.housings if h.name == row.housing)
    return next((row.offset + value for name, value in housing.fixed if name == "uz"), None)


#: For each of these models, the model whose elastic bodies are used for its tangent stiffness. The models in `LADDER` and
#: "condensed" use their own bodies, Liu's model has an axial stiffness only; other models have no tangent stiffness.
TANGENT_OF = {"lin-source-partition": "lin", "lin-printed-hertz": "lin", "source": "lin"}


#: Largest credible conformity, groove radius over ball diameter [1]. Usual values are 0.51 to 0.58; a larger value suggests
#: that the groove radius was divided by the ball's radius instead.
WIDEST = 0.6

#: Life that follows from the loads of all contacts: L10 of a nut, L10r of a bearing.
LifeByLoads: TypeAlias = BasicRatingLife | iso_lives.ReferenceLife

#: Definition of the reason why there is no life L10.
WHY_NO_LIFE = "why there is no life L10: what ISO 281 does not cover, or that the rings do not turn; null if there is one"


@result_record
class ContactLoadResults:
    """Pressure, static safety, rating life and load ratings of a ball nut or ball bearing, from its contact loads.

    The contact loads stem from a low-order model or from the 3D reference. Fields are None if no contact carries load.
    """

    #: Contact with the highest pressure.
    worst_contact: contacts.BallContact | None = quantity_field("worst_contact")
    #: Static safety of the contact with the highest pressure.
    safety: contacts.StaticSafety | None = quantity_field("static_safety")
    #: Contact ellipse that comes closest to the edge of its groove.
    truncation: contacts.EllipseTruncation | None = quantity_field("truncation")
    #: Basic rating life L10: of a nut under the contact loads, of a bearing by ISO 281; ``life_words`` says why it is None.
    life: BasicRatingLife | None = quantity_field("life")
    #: Dynamic and static load ratings.
    ratings: contacts.Ratings | None = quantity_field("ratings")
    words: str = quantity_field(
        "rating_refused", "why no life and no load ratings can be computed", show=lambda words: words or None, default=""
    )
    #: Life modified for reliability, lubricant and contamination.
    modified: ModifiedLife | None = quantity_field("modified_life", default=None)
    #: Life of a ball bearing by ISO/TS 16281; None for ball nuts.
    reference: iso_lives.ReferenceLife | None = quantity_field("reference_life", default=None)
    life_words: str = quantity_field("life_words", WHY_NO_LIFE, show=lambda words: words or None, default="")

    @property
    def life_by_loads(self) -> LifeByLoads | None:
        """Life that follows from the contact loads: L10 of a nut, L10r of a bearing; None if it is not known."""
        return self.life if self.reference is None else self.reference


@result_record
class RollerLoadResults:
    """Pressure, static safety, rating life and friction torque of a row of rollers, from its line loads.

    Fields are None if no roller carries load.
    """

    #: Line contact with the highest pressure.
    worst_contact: contacts.RollerContact | None = quantity_field("worst_contact")
    #: Static safety of the line contact with the highest pressure.
    safety: contacts.StaticSafety | None = quantity_field("static_safety")
    #: Contact of the most loaded roller with the rib of its ring.
    rib_contact: RibContact | None = quantity_field("rib_contact")
    #: Basic rating life L10 by ISO 281; if None, ``life_words`` may say why.
    life: BasicRatingLife | None = quantity_field("life")
    #: Dynamic and static load ratings.
    ratings: contacts.Ratings = quantity_field("ratings")
    #: Friction torque of the row, while it runs and when it starts.
    torque: bearings_torque.RollerBearingTorque | None = quantity_field("roller_torque")
    #: Life of the bearing by ISO/TS 16281.
    reference: iso_lives.ReferenceLife | None = quantity_field("reference_life")
    life_words: str = quantity_field("life_words", WHY_NO_LIFE, show=lambda words: words or None, default="")

    @property
    def life_by_loads(self) -> LifeByLoads | None:
        """Life L10r, which follows from the line loads; None if it is not known."""
        return self.reference


#: Results from the contact loads of a nut or bearing row with balls, or from the line loads of a row of rollers.
LoadResults: TypeAlias = ContactLoadResults | RollerLoadResults


@dataclass(frozen=True)
class SceneResults:
    """All results of a low-order model for a scene with one nut or bearing row."""

    #: Pressure, static safety, life and load ratings that follow from the contact loads.
    load_results: ContactLoadResults
    #: Axial force of the screw on the nut [N].
    axial_force: float
    #: Displacement and stiffness of the nut or bearing, and of the point on which the load acts.
    stiffness: SceneStiffness
    #: Displacement of the screw's section on which the load acts from its unloaded position, (6,) [m, rad]; from the
    #: nominal position if nothing fixes the unloaded screw.
    displacement: Array
    #: Axial rigidity by several definitions; None without axial force.
    rigidities: AxialRigidities | None
    #: Contact loads that remain when the loads of the scene are removed.
    preload: loading.Preload | None
    #: External load at which the first preloaded contact opens; None without preload.
    lift_off: loading.LiftOff | None
    #: Friction torques and efficiencies as JSON values; None if not computed.
    friction: dict[str, Any] | None
    #: Why the friction torques are not computed; empty if they are.
    friction_words: str
    #: How the supports and the contacts share the loads of the scene; None without loads.
    load_path: loading.LoadPath | None = None
    #: Axial secant stiffness over the load step that the scene states [N/m]; only the model of Liu et al. computes it.
    load_step_stiffness: float | None = None
    #: Buckling load, critical speed and DN value of the screw.
    shaft_limits: ShaftLimits | None = None
    #: Friction torque of a bearing by Palmgren's formulas.
    bearing_torque: bearings_torque.BallBearingTorque | None = None


def results_of_contact_loads(
    scene: Scene,
    load: Array,
    angle: Array,
    member: int = 0,
    pressure: Array | None = None,
    turning: life.TurningRing | None = None,
) -> ContactLoadResults:
    """Compute pressure, static safety, rating life and load ratings from contact loads.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row.
    load
        Contact loads of n balls on the left and right flank of the screw, then of the nut, (n, 4) [N].
    angle
        Contact angles, (n, 4) [rad].
    member
        Number of the random draw of the geometric errors, from 0; 0 without random errors.
    pressure
        Largest pressure of each contact, (n, 4) [Pa]; None: computed from the loads by Hertz.
    turning
        Ring that turns, of a bearing on a shaft with several; None: as the scene's table [motion] says.

    Returns
    -------
    ContactLoadResults
        Pressure, static safety, rating life and load ratings.
    """
    drawn = draw_geometry_with_errors(scene, ball_layout(scene), member)
    words, ring = "", life.turning_ring(scene) if turning is None else turning
    rated_life: BasicRatingLife | None = None
    reach: contacts.EllipseTruncation | None = None
    rated: contacts.Ratings | None = None
    try:
        reach = contacts.most_truncated_ellipse(scene, drawn, load, angle)
        rated = contacts.dynamic_and_static_ratings(scene)
        rated_life = life.basic_rating_life(scene, load, ring)
    except ValueError as error:
        words = str(error)
    worst = contacts.contact_of_highest_pressure(scene, drawn, load, angle, pressure)
    safety = None if worst is None else contacts.static_safety(scene, drawn, worst)
    modified, basic = modified_life(scene, rated_life), iso_lives.ball_reference_life(scene, rated_life, ring)
    why = ""
    if scene.track.lead == 0.0:
        rated_life, why = _bearing_life(scene, load, angle, ring) if not words else (None, "")
    return ContactLoadResults(worst, safety, reach, rated_life, rated, words, modified, basic, why)


def _bearing_life(scene: Scene, load: Array, angle: Array, turning: life.TurningRing) -> tuple[BasicRatingLife | None, str]:
    """Return the life L10 of a ball bearing by ISO 281, and why there is none.

    The arguments are those of `results_of_contact_loads`.
    """
    if turning == "none" or not (load > 0.0).any():
        return None, life.RINGS_STAND if turning == "none" else ""
    force = life.force_of_contact_loads(ball_layout(scene).azimuth, load, angle)
    try:
        return life.bearing_life_of_equivalent_loads([scene], [1.0], [force]), ""
    except ValueError as error:
        return None, str(error)


def tangent_stiffness_at(scene: Scene, station: float, model: str, options: ModelOptions) -> TangentStiffness:
    """Compute the 6 x 6 tangent stiffness of a loaded screw at an axial position.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row.
    station
        Axial position on the screw [m].
    model
        Name of a model that describes the screw as a beam or as an elastic body.
    options
        Options of the model.

    Returns
    -------
    TangentStiffness
        Tangent stiffness, and the rigidities that follow from it.

    Raises
    ------
    InputError
        If the model has no tangent stiffness; its subclass SceneNotCoveredError if the model's elastic bodies cannot be
        built for the scene.
    """
    step = TANGENT_OF.get(model, model)
    if step not in (*LADDER, "condensed"):
        allowed = ", ".join((*LADDER, "condensed", *TANGENT_OF))
        raise ArgumentError("stiffness_at", f"the model {model}", f"one of the models {allowed}", "choose another model")
    condensed = read_condensed_bodies(scene, options) if step == "condensed" else None
    modelled, backend = MODELS[model].scene_with_settings(scene), LADDER.get(step, REFINED)
    try:
        return tangent_stiffness(modelled, station, backend=backend, condensed=condensed, member=options.member)
    except ValueError as error:
        advice = "omit the stiffness; contact loads are computed without it"
        raise SceneNotCoveredError(scene.name, scene_key_of_error(error), str(error), advice) from error


def tangent_stiffness_at_nut(scene: Scene, model: str, options: ModelOptions) -> tuple[TangentStiffness | None, str]:
    """Compute the tangent stiffness of a loaded screw at the nut's centre, if the model can give one.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row.
    model
        Name of the model.
    options
        Options of the model.

    Returns
    -------
    TangentStiffness or None
        The stiffness; None if it could not be computed.
    str
        Why the stiffness could not be computed; empty if it was, or if the model never computes a stiffness.
    """
    if model == "liu":
        from rollbench.lowfi.statics.liu import nut_as_spring_row  # heavy import, needed for this model only

        axial = nut_as_spring_row(scene, member=options.member).stiffness()
        along = np.full((6, 6), np.nan)
        along[2, 2] = np.nan if axial is None else axial
        return (None, "") if axial is None else (TangentStiffness(scene.nut.position, along, "converged"), "")
    if TANGENT_OF.get(model, model) not in (*LADDER, "condensed"):
        return None, ""
    try:
        tangent = tangent_stiffness_at(scene, scene.nut.position, model, options)
    except SceneNotCoveredError as refused:
        return None, refused.value.partition(";")[0]  # the rest is advice for other results
    return (tangent, "") if tangent.status == "converged" else (None, tangent.status)


def motion_of_unloaded_screw(unloaded: StaticResult, at: float | str) -> Array:
    """Return the motion (6,) [m, rad] of a section of the unloaded screw from its nominal position.

    ``unloaded``: result of the scene without loads; ``at``: axial position of the section. Displacements under load are
    measured from this position. It is zero if no contact fixes the unloaded screw.
    """
    held = unloaded.converged and (unloaded.load > 0.0).any()
    return motion_at(unloaded, at) if held else np.zeros(6)


def compute_scene_results(scene: Scene, result: StaticResult, model: str, options: ModelOptions) -> SceneResults:
    """Compute all results that follow from a converged solution, such as life, rigidity, preload and lift-off load.

    Preload and lift-off load (the load at which the first preloaded contact opens) need further solutions of the scene.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row.
    result
        Converged result of the scene.
    model
        Name of the model.
    options
        Options of the model.

    Returns
    -------
    SceneResults
        Stiffness, preload, lift-off load, friction, load path, and all results that follow from the contact loads.
    """
    bare = loading.solve_with_scaled_loads(scene, 0.0, model, options)
    held = loading.preload_from_unloaded(scene, bare) if bare.converged else None
    force = axial_force(result)
    stiffness = stiffness_of_scene(scene, result, bare, model, options)
    try:
        three = three_axial_rigidities(scene, force, stiffness.nut.displacement)
    except ValueError:
        three = None
    lift = loading.find_lift_off_load(scene, result, bare, model, options) if held is not None else None
    friction, words = None, "no coefficient of friction given; rollbench friction takes 0.1"
    if scene.friction is not None:
        from rollbench.compare.models.friction_sums import friction_results_of_scenes  # heavy import

        ((friction, words),) = friction_results_of_scenes([(scene, scene.friction, result)], options.member)
    at = place_of_displacement(scene)
    moved = motion_at(result, at) - motion_of_unloaded_screw(bare, at)
    loads = results_of_contact_loads(scene, result.load, result.contact_angle, result.member, result.pressure)
    path = loading.load_path_of_scene(scene, result, bare)
    step, stepped = scene.ingredients.load_step, None
    if model == "liu" and step is not None:
        from rollbench.lowfi.statics.liu import nut_as_spring_row  # heavy import, needed for this model only

        stepped = nut_as_spring_row(scene, member=options.member).stiffness(step)
    shaft = shaft_limits(scene, result)
    on_ring = np.zeros(3) if result.equilibrium is None else result.equilibrium.contact_force
    torque = bearing_friction_torque(scene, scene, "deep groove", result, on_ring, loads)
    return SceneResults(loads, force, stiffness, moved, three, held, lift, friction, words, path, stepped, shaft, torque)


def bearing_friction_torque(
    scene: Scene | Assembly, parts: Scene, thrust: str, balls: StaticResult, force: Array, load_results: ContactLoadResults
) -> bearings_torque.BallBearingTorque | None:
    """Compute the friction torque of a ball bearing by Palmgren's formulas.

    Parameters
    ----------
    scene
        Scene that states lubricant and speed; if it lacks either, only the load-dependent torque is computed.
    parts
        Row of balls as a scene.
    thrust
        Direction of the axial force that the row can carry: "+z", "-z", "both", or "deep groove" (both directions, with one
        arc per groove).
    balls
        Solution with the contact loads and angles of the row.
    force
        Force (x, y, z) between shaft and row, (3,) [N]; only its radial part is used.
    load_results
        Results from these contact loads, of which the static safety is used.

    Returns
    -------
    BallBearingTorque or None
        The torque; None for ball-screw nuts and for unloaded rows.
    """
    if parts.track.lead or load_results.safety is None:
        return None
    kind: bearings_torque.Kind = "deep groove" if thrust == "deep groove" else "angular contact"
    if not one_arc.has_single_arc_grooves(parts):
        kind = "four-point"
    inner, angle = balls.load[:, :2], balls.contact_angle[:, :2]
    along = float(np.sum(inner * np.sin(np.where(inner > 0.0, angle, 0.0))))
    pitch, viscous = 2.0 * parts.track.pitch_radius, None
    oil, motion = scene.lubricant, scene.motion
    if oil is not None and motion is not None:
        ends = bearings_torque.VISCOUS[kind][oil.supply] if oil.factor is None else (oil.factor, oil.factor)
        low, high = (bearings_torque.load_independent_torque(f, pitch, oil.viscosity, motion.speed) for f in ends)
        viscous = low, high
    share = 1.0 / load_results.safety.factor
    radial = float(np.hypot(force[0], force[1]))
    return bearings_torque.ball_bearing_torque(kind, parts.track.contact_angle, pitch, (along, radial, share), viscous)


def results_of_roller_loads(
    row: RollerRow,
    line_loads: Array,
    force: Array,
    speed: float | None,
    lubricant: Lubricant | None,
    turning: life.TurningRing,
) -> RollerLoadResults:
    """Compute pressure, safety, life and friction torque from the line loads of a row of rollers.

    Parameters
    ----------
    row
        The row of rollers.
    line_loads
        Load per length of each slice of each roller, (rollers, slices) [N/m].
    force
        Force (x, y, z) between shaft and row, (3,) [N].
    speed
        Relative speed of the rings [rad/s]; None: not known.
    lubricant
        Lubricant of the scene; None: the viscous part of the torque is not computed.
    turning
        Ring that turns.

    Returns
    -------
    RollerLoadResults
        Pressure, static safety, contact of the rollers with the rib, life, load ratings and friction torque.
    """
    worst, rated = (
        contacts.roller_contact_of_highest_pressure(row, line_loads),
        roller_life.dynamic_and_static_ratings_of_row(row),
    )
    maker, stands = row.rating.static, turning == "none"
    return RollerLoadResults(
        worst,
        None if worst is None else contacts.roller_static_safety(worst, None if maker is None else maker / rated.static),
        rib_contact(row, line_loads.mean(axis=1) * row.length),
        None if stands else roller_life.life_of_row_by_equivalent_loads(row, [1.0], [force]),
        rated,
        bearings_torque.roller_bearing_torque(row, line_loads, speed, lubricant),
        iso_lives.roller_reference_life(row, line_loads, turning),
        life.RINGS_STAND if stands else "",
    )


def parts_under_loads(assembly: Assembly, parts: Scene) -> Scene:
    """Return a nut or bearing of an assembly as a scene with all loads and supports of the assembly."""
    on_housings = (Load(h.at, h.force, h.moment) for h in assembly.housings)
    return replace(parts, name=assembly.name, loads=(*assembly.loads, *on_housings), supports=assembly.supports)


def _conformity_warnings(scene: Scene) -> Iterator[ResultWarning]:
    """Yield a warning if the conformity of a groove (its radius over the ball diameter) exceeds `WIDEST`, 0.6.

    The user has then probably divided the groove radius by the ball's radius instead of its diameter.
    """
    grooves = {"screw": scene.screw.groove_radius, "nut": scene.nut.groove_radius}
    wide = [f"{part} {f:.4g}" for part, radius in grooves.items() if (f := 0.5 * radius / scene.balls.radius) > WIDEST]
    if wide:
        brief = f"conformity above {WIDEST:g} ({', '.join(wide)})"
        text = (
            f"{brief}: conformity is groove radius over ball diameter, usually 0.51 to 0.58; "
            "if it was computed with the ball's radius, halve it"
        )
        yield ResultWarning("conformity", text, text)


def validity_warnings(parts: Scene | RollerRow, load_results: LoadResults, preload: float) -> Iterator[ResultWarning]:
    """Yield warnings for results outside the range of validity of the models.

    Parameters
    ----------
    parts
        Geometry and materials of the nut or bearing row.
    load_results
        Pressure, static safety and life of the nut or row.
    preload
        Axial preload [N].

    Yields
    ------
    ResultWarning
        Warning for a too wide groove, for a static safety below 1, or for a preload above the dynamic load rating.
    """
    if isinstance(parts, Scene):
        yield from _conformity_warnings(parts)
    if load_results.safety is not None and load_results.safety.factor < 1.0:
        factor = f"{load_results.safety.factor:.3g}"
        words = "the contact leaves a permanent dent in hardened steel, which life and friction do not take into account"
        yield ResultWarning("safety", f"static safety of {factor}, below 1: {words}", f"static safety {factor}, below 1")
    if isinstance(parts, RollerRow):
        return
    try:
        C = dynamic_rating(parts)
    except ValueError:  # the reason is in ContactLoadResults.words
        return
    if preload > C:
        words = "the preload alone determines the life; catalogues limit it to 8 % of the rating"
        text = f"preload of {preload:.4g} N, above the dynamic load rating of {C:.4g} N: {words}"
        yield ResultWarning("preload", text, f"preload {preload:.4g} N, above C = {C:.4g} N")


# --- several nuts or bearing rows on one shaft


@dataclass(frozen=True)
class NutOrBearingResults:
    """Results that follow from the contact loads of one of several nuts or bearing rows on a shaft."""

    #: Name of the nut or row.
    name: str
    #: Geometry and materials of the nut or row.
    parts: Scene | RollerRow
    #: Pressure, safety, life and ratings of the nut or row.
    load_results: LoadResults
    #: Contact loads, and axial force on the shaft, that remain without the scene's loads; None: no equilibrium without
    #: them.
    preload: loading.Preload | None
    #: Displacement and stiffness of the nut or row, without the shaft.
    stiffness: NutStiffness
    #: Friction torque of a loaded ball bearing.
    friction_torque: bearings_torque.BallBearingTorque | None = None


@dataclass(frozen=True)
class ShaftResults:
    """Results of a low-order model for a shaft with several nuts or bearing rows."""

    #: Results of each nut or row.
    set_results: tuple[NutOrBearingResults, ...]
    #: Sum of the axial loads on shaft and housings [N].
    axial_load: float
    #: Displacement and stiffness of the nuts or bearings, and of the point on which the load acts.
    stiffness: SceneStiffness
    #: Displacement, from its unloaded position, of the shaft's section or housing on which the load acts, (6,) [m, rad];
    #: None if the unloaded shaft has no equilibrium.
    displacement: Array | None
    #: How the supports and the contacts share the loads on all bodies; None without loads.
    load_path: loading.LoadPath | None = None
    #: For each loaded body (the shaft or a housing), how supports and contacts share the loads on this body alone.
    #: ``load_path``, which is for all loads together, may hide that the frame carries the whole load on one body.
    load_paths_by_body: tuple[loading.LoadPath, ...] = ()

    @property
    def set_indices_by_pressure(self) -> list[int]:
        """Indices (from 0) of the loaded nuts or bearing rows, by decreasing ratio of highest to allowed pressure."""
        found = [x.load_results for x in self.set_results]
        shares = {
            i: x.worst_contact.pressure / x.safety.allowed_pressure
            for i, x in enumerate(found)
            if x.worst_contact and x.safety
        }
        return sorted(shares, key=lambda i: -shares[i])

    @property
    @QuantityDescription(
        "worst_set", "nut or bearing row whose highest pressure is the largest share of its allowed pressure"
    )
    def worst_set(self) -> int | None:
        """Number (from 1) of the nut or row with the largest ratio of highest to allowed pressure; None without load."""
        return next((i + 1 for i in self.set_indices_by_pressure), None)


def compute_shaft_results(assembly: Assembly, result: AxisResult) -> ShaftResults:
    """Compute all results that follow from a converged solution of a shaft with several nuts or bearing rows.

    The shaft is solved once more without loads, and, if several bodies are loaded, once for each of them without
    the loads on this body.

    Parameters
    ----------
    assembly
        Shaft with several nuts or bearing rows.
    result
        Converged result of the assembly.

    Returns
    -------
    ShaftResults
        The results.
    """
    bare = run_model(loading.with_scaled_loads(assembly, 0.0), result.model, ModelOptions(member=result.member))
    unloaded: Sequence[SetResult | None] = [None] * len(result.sets)
    moved = None
    if bare.converged:
        unloaded, at = bare.sets, place_of_displacement(assembly)
        moved = motion_at(result, at) - motion_at(bare, at)
    stiffness = stiffness_of_scene(assembly, result, bare, result.model, ModelOptions(member=result.member))
    each = zip(result.sets, unloaded, stiffness.sets, strict=True)
    sets = tuple(_results_of_set(assembly, *one, result.member) for one in each)
    path, axial = loading.load_path_of_assembly(assembly, result, bare), loading.sum_of_axial_loads(assembly)
    return ShaftResults(sets, axial, stiffness, moved, path, _paths_by_body(assembly, result, path))


def _paths_by_body(assembly: Assembly, result: AxisResult, path: loading.LoadPath | None) -> tuple[loading.LoadPath, ...]:
    """Return for each loaded body (shaft or housing) how supports and contacts share the loads on this body.

    The shares are the changes of the reactions when the loads on the body are removed. ``result``: solution of the assembly
    under all loads; ``path``: how supports and contacts share all loads, returned alone if only one body is loaded. The
    tuple is empty without loads.
    """
    bodies, options = loading.assemblies_by_loaded_body(assembly), ModelOptions(member=result.member)
    if len(bodies) < 2:
        return () if path is None else (path,)
    without = {name: run_model(others, result.model, options) for name, (_, others) in bodies.items()}
    found = (loading.load_path_of_assembly(alone, result, without[name], name) for name, (alone, _) in bodies.items())
    return tuple(x for x in found if x is not None)


def solve_assembly_with_results(assembly: Assembly, model: str, member: int = 0) -> tuple[AxisResult, ShaftResults | None]:
    """Solve a shaft with several nuts or bearing rows, and compute all results and warnings.

    Parameters
    ----------
    assembly
        Shaft with several nuts or bearing rows.
    model
        Name of the model.
    member
        Number of the random draw of the geometric errors, from 0; 0 without random errors.

    Returns
    -------
    AxisResult
        The solution, with its warnings.
    ShaftResults or None
        Results that follow from the solution; None without equilibrium.

    Raises
    ------
    InputError
        If the model does not cover the assembly.
    """
    result = run_model(assembly, model, ModelOptions(member=member))
    if not result.converged:
        return result, None
    answers = compute_shaft_results(assembly, result)
    warned = (
        w.with_part_name(x.name)
        for x in answers.set_results
        for w in validity_warnings(x.parts, x.load_results, loading.absolute_axial_preload(x.preload))
    )
    held = (w for path in answers.load_paths_by_body for w in loading.load_path_warnings(path))
    lost = loading.lost_preload_warnings(assembly, result, [x.preload for x in answers.set_results])
    further = (*warned, *held, *lost, *axial_play_warnings(assembly))
    return replace(result, warnings=(*result.warnings, *further)), answers


def _results_of_set(
    assembly: Assembly, s: SetResult, unloaded: SetResult | None, stiffness: NutStiffness, member: int
) -> NutOrBearingResults:
    """Return pressure, safety, life, preload and friction torque of one nut or bearing row on a shaft.

    ``s``: solution of the row under the scene's loads; ``unloaded``: solution of the row without these loads; None if the
    unloaded shaft has no equilibrium; ``stiffness``: of the row; ``member``: number of the random draw of the geometric
    errors, from 0.
    """
    parts, torque, preload = s.of.parts, None, None
    answers: LoadResults
    turning = life.turning_ring(assembly, s.of)
    if isinstance(parts, RollerRow):
        assert s.line_loads is not None, "a row of rollers has line loads"
        speed = assembly.motion.speed if assembly.motion is not None and assembly.motion.turns == "screw" else None
        answers = results_of_roller_loads(parts, s.line_loads, s.force, speed, assembly.lubricant, turning)
    else:
        assert s.balls is not None, "a set of balls has contacts"
        loaded, found = parts_under_loads(assembly, parts), s.balls
        answers = results_of_contact_loads(loaded, found.load, found.contact_angle, member, None, turning)
        torque = bearing_friction_torque(assembly, parts, s.of.thrust, s.balls, s.force, answers)
    if unloaded is not None:
        loads = unloaded.loads[unloaded.loads > 0.0]
        mean = mean_load(loads) if loads.size else 0.0
        preload = loading.Preload(mean, float(loads.max(initial=0.0)), int(loads.size), float(unloaded.force[2]))
    return NutOrBearingResults(s.of.name, parts, answers, preload, stiffness, torque)
