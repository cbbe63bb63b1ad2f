"""Functions that compute the results of a nut or bearing: pressure, safety, life, rigidity, preload and friction.

The module also warns where a result is outside the range of validity of the models, and where the supports fix a
deep-groove bearing near one end of its axial play.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from math import degrees, sin

import numpy as np

from rollbench.compare.errors import ArgumentError, SceneNotCoveredError
from rollbench.compare.models import loading
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import MODELS, model_by_name, read_condensed_bodies, run_model, scene_key_of_error
from rollbench.compare.models.set_results import SetResult, clearance_of_deep_groove
from rollbench.compare.models.stiffness import NutStiffness
from rollbench.lowfi.bearings import torque as bearings_torque
from rollbench.lowfi.bearings.tapered_roller import rib_contact
from rollbench.lowfi.compliance.parts import LADDER, REFINED
from rollbench.lowfi.rating import contacts, iso_lives, life, roller_life
from rollbench.lowfi.rating.contacts import WorstContact
from rollbench.lowfi.rating.displacement import motion_at
from rollbench.lowfi.rating.iso_lives import modified_life
from rollbench.lowfi.rating.life import Life, dynamic_rating
from rollbench.lowfi.rating.rigidity import AxialRigidities, axial_force, three_axial_rigidities
from rollbench.lowfi.statics.nominal import count_nominal_contacts
from rollbench.lowfi.statics.result import AxisResult, StaticResult, StaticSolution
from rollbench.lowfi.statics.result import SetResult as SetOnShaft
from rollbench.lowfi.statics.tangent import TangentStiffness, tangent_stiffness
from rollbench.lowfi.warned import ResultWarning
from rollbench.meshes import one_arc
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, RollerRow, RollingSet
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Load, Lubricant, Motion, Scene

#: Distance of a ring from the middle of its axial play, over half the play, from which on it counts as at the end [1].
AT_END = 0.9


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


def results_of_contact_loads(
    scene: Scene,
    load: Array,
    angle: Array,
    member: int = 0,
    pressure: Array | None = None,
    turning: life.TurningRing | None = None,
    speed: float | None = None,
    name: str = "",
) -> SetResult:
    """Compute pressure, static safety, rating life and load ratings of a nut or ball bearing from its contact loads.

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
    speed
        Speed of the rotating part [rad/s], for the life in hours; None: not known.
    name
        Name of the nut or bearing; empty if the scene has only one.

    Returns
    -------
    SetResult
        Results with pressure, static safety, rating life and load ratings only.
    """
    drawn = draw_geometry_with_errors(scene, ball_layout(scene), member)
    words, ring = "", life.turning_ring(scene) if turning is None else turning
    rated_life: Life | None = None
    reach: contacts.EllipseTruncation | None = None
    rated: contacts.Ratings | None = None
    try:
        reach = contacts.most_truncated_ellipse(scene, drawn, load, angle)
        rated = contacts.dynamic_and_static_ratings(scene)
        rated_life = life.basic_rating_life(scene, load, ring)
    except ValueError as error:
        words = str(error)
    worst = contacts.contact_of_highest_pressure(scene, drawn, load, angle, pressure)
    modified, basic = modified_life(scene, rated_life), iso_lives.ball_reference_life(scene, rated_life, ring)
    why = ""
    if scene.track.lead == 0.0:
        rated_life, why = _bearing_life(scene, load, angle, ring) if not words else (None, "")
    return SetResult(
        name=name,
        parts=scene,
        worst=worst and replace(worst, set=name),
        truncation=reach,
        life=rated_life and replace(rated_life, speed=speed),
        ratings=rated,
        rating_refused=words,
        modified_life=modified,
        reference_life=basic and replace(basic, speed=speed),
        life_words=why,
    )


def _bearing_life(scene: Scene, load: Array, angle: Array, turning: life.TurningRing) -> tuple[Life | None, str]:
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


def tangent_stiffness_at_nut(scene: Scene, model: str, options: ModelOptions) -> TangentStiffness | None:
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
    """
    axial_stiffness = model_by_name(model).axial_stiffness
    if axial_stiffness is not None:
        axial = axial_stiffness(scene, options, 0.0)
        if axial is None:
            return None
        along = np.full((6, 6), np.nan)
        along[2, 2] = axial
        return TangentStiffness(station=scene.nut.position, matrix=along, status="converged")
    if TANGENT_OF.get(model, model) not in (*LADDER, "condensed"):
        return None
    try:
        tangent = tangent_stiffness_at(scene, scene.nut.position, model, options)
    except SceneNotCoveredError:
        return None
    return tangent if tangent.status == "converged" else None


def motion_of_unloaded_screw(unloaded: StaticSolution, at: float | str) -> Array:
    """Return the motion (6,) [m, rad] of a section or housing of the unloaded scene from its nominal position.

    ``unloaded``: result of the scene without loads; ``at``: axial position of the section, or name of the housing.
    Displacements under load are measured from this position. With one nut or bearing it is zero if no contact fixes the
    unloaded screw; with several it is nan if they have no equilibrium.
    """
    if isinstance(unloaded, StaticResult):
        return motion_at(unloaded, at) if unloaded.converged and (unloaded.load > 0.0).any() else np.zeros(6)
    return motion_at(unloaded, at) if unloaded.converged else np.full(6, np.nan)


def unsolved_sets(scene: Scene | Assembly, result: StaticResult | AxisResult) -> dict[str, SetResult]:
    """Return each nut or bearing of a scene without equilibrium by name, without results."""
    if isinstance(result, AxisResult):
        return {s.of.name: SetResult(name=s.of.name, parts=s.of.parts, balls=s.balls, on_shaft=s) for s in result.sets}
    assert isinstance(scene, Scene), "a scene with one nut or bearing has the result of one"
    return {"": SetResult(parts=scene, balls=result)}


def results_of_sets(
    scene: Scene | Assembly,
    result: StaticResult | AxisResult,
    bare: StaticResult | AxisResult,
    stiffness: Sequence[NutStiffness],
    lift_off: Sequence[loading.LiftOff | None],
) -> dict[str, SetResult]:
    """Compute the results of each nut or bearing of a scene, such as life, rigidity and preload, by its name.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row, or with several on one shaft.
    result, bare
        Converged result of the scene, and its result without loads.
    stiffness
        Displacement and stiffness of each nut or bearing.
    lift_off
        For each nut or bearing, load at which its first preloaded contact opens.

    Returns
    -------
    dict
        The results without friction of nuts, see `load_cases.with_friction_of_nuts`.
    """
    speed, sets = None if scene.motion is None else scene.motion.speed, dict[str, SetResult]()
    rows: Sequence[SetOnShaft | None] = result.sets if isinstance(result, AxisResult) else [None]
    for k, s in enumerate(rows):
        name, turning = "" if s is None else s.of.name, life.turning_ring(scene, None if s is None else s.of)
        parts, balls = (scene, result) if s is None else (s.of.parts, s.balls)
        if isinstance(parts, RollerRow):
            assert s is not None, "a row of rollers is on a shaft"
            assert s.line_loads is not None, "a row of rollers has line loads"
            found = results_of_roller_loads(parts, s.line_loads, s.force, scene.motion, scene.lubricant, turning, name)
        else:
            assert isinstance(parts, Scene)
            assert isinstance(balls, StaticResult), "a set of balls has contacts"
            thrust, force = "deep groove", np.zeros(3) if balls.equilibrium is None else balls.equilibrium.contact_force
            if s is not None:
                thrust, force = s.of.thrust, s.force
            loaded = parts_under_loads(scene, parts) if isinstance(scene, Assembly) else scene
            loads = balls.load, balls.contact_angle, result.member, balls.pressure
            found = results_of_contact_loads(loaded, *loads, turning, speed, name)
            torque = bearing_friction_torque(scene, parts, thrust, balls, force, found.worst)
            found = replace(found, parts=parts, balls=balls, bearing_torque=torque)
        if s is None:
            assert isinstance(scene, Scene)
            assert isinstance(result, StaticResult)
            assert isinstance(bare, StaticResult)
            preload = loading.preload_from_unloaded(scene, bare) if bare.converged else None
            rigidities = _rigidities_by_formula(scene, axial_force(result), stiffness[k])
            found = replace(found, nominal_contacts=count_nominal_contacts(scene, result), rigidities=rigidities)
        else:
            assert isinstance(bare, AxisResult)
            preload = loading.preload_on_shaft(bare.sets[k]) if bare.converged else None
            free = preload is not None and abs(preload.axial) <= FREE * preload.contacts * preload.mean
            if isinstance(parts, Scene) and s.of.thrust != "deep groove" and free:
                found = replace(found, rigidities=_rigidities_by_formula(parts, stiffness[k].force, stiffness[k]))
        sets[name] = replace(found, on_shaft=s, nut=stiffness[k], preload=preload, lift_off=lift_off[k])
    return sets


def _rigidities_by_formula(parts: Scene, force: float, stiffness: NutStiffness) -> AxialRigidities | None:
    """Return the axial rigidities of a nut or bearing row by the formulas of ISO 3408-4; None where they do not apply.

    ``force``: axial force on it [N]; ``stiffness``: its displacement and stiffness by the model.
    """
    try:
        return three_axial_rigidities(parts, force, stiffness.displacement)
    except ValueError:
        return None


def load_step_stiffness(scene: Scene, model: str, options: ModelOptions) -> float | None:
    """Return the axial secant stiffness [N/m] over the load step that a scene states; None without step or such a model."""
    step, axial_stiffness = scene.ingredients.load_step, model_by_name(model).axial_stiffness
    return None if step is None or axial_stiffness is None else axial_stiffness(scene, options, step)


def bearing_friction_torque(
    scene: Scene | Assembly, parts: Scene, thrust: str, balls: StaticResult, force: Array, worst: WorstContact | None
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
    worst
        Contact with the highest pressure, whose static safety is used; None: no contact is loaded.

    Returns
    -------
    BallBearingTorque or None
        The torque; None for ball-screw nuts and for unloaded rows.
    """
    if parts.track.lead or worst is None:
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
    share = 1.0 / worst.safety
    radial = float(np.hypot(force[0], force[1]))
    return bearings_torque.ball_bearing_torque(kind, parts.track.contact_angle, pitch, (along, radial, share), viscous)


def results_of_roller_loads(
    row: RollerRow,
    line_loads: Array,
    force: Array,
    motion: Motion | None,
    lubricant: Lubricant | None,
    turning: life.TurningRing,
    name: str,
) -> SetResult:
    """Compute pressure, safety, life and friction torque from the line loads of a row of rollers.

    Parameters
    ----------
    row
        The row of rollers.
    line_loads
        Load per length of each slice of each roller, (rollers, slices) [N/m].
    force
        Force (x, y, z) between shaft and row, (3,) [N].
    motion
        Motion of the shaft or its nuts; None: not known.
    lubricant
        Lubricant of the scene; None: the viscous part of the torque is not computed.
    turning
        Ring that turns.
    name
        Name of the row.

    Returns
    -------
    SetResult
        Results with pressure, static safety, contact of the rollers with the rib, life, load ratings and friction torque.
    """
    rated, speed = roller_life.dynamic_and_static_ratings_of_row(row), None if motion is None else motion.speed
    maker, stands = row.rating.static, turning == "none"
    worst = contacts.roller_contact_of_highest_pressure(row, line_loads, None if maker is None else maker / rated.static)
    basic = None if stands else roller_life.life_of_row_by_equivalent_loads(row, [1.0], [force])
    reference = iso_lives.roller_reference_life(row, line_loads, turning)
    rubbing = speed if motion is not None and motion.turns == "screw" else None
    return SetResult(
        name=name,
        parts=row,
        worst=worst and replace(worst, set=name),
        rib=rib_contact(row, line_loads.mean(axis=1) * row.length),
        life=basic and replace(basic, speed=speed),
        ratings=rated,
        torque=bearings_torque.roller_bearing_torque(row, line_loads, rubbing, lubricant),
        reference_life=reference and replace(reference, speed=speed),
        life_words=life.RINGS_STAND if stands else "",
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


def warnings_of_set(found: SetResult, preload: float) -> Iterator[ResultWarning]:
    """Yield warnings for results outside the range of validity of the models.

    Parameters
    ----------
    found
        Results of the nut or row.
    preload
        Axial preload [N].

    Yields
    ------
    ResultWarning
        Warning for a too wide groove, for a static safety below 1, or for a preload above the dynamic load rating.
    """
    parts = found.parts
    if isinstance(parts, Scene):
        yield from _conformity_warnings(parts)
    if found.worst is not None and found.worst.safety < 1.0:
        factor = f"{found.worst.safety:.3g}"
        words = "the contact leaves a permanent dent in hardened steel, which life and friction do not take into account"
        yield ResultWarning("safety", f"static safety of {factor}, below 1: {words}", f"static safety {factor}, below 1")
    if isinstance(parts, RollerRow):
        return
    try:
        C = dynamic_rating(parts)
    except ValueError:  # the reason is in SetResult.rating_refused
        return
    if preload > C:
        words = "the preload alone determines the life; catalogues limit it to 8 % of the rating"
        text = f"preload of {preload:.4g} N, above the dynamic load rating of {C:.4g} N: {words}"
        yield ResultWarning("preload", text, f"preload {preload:.4g} N, above C = {C:.4g} N")


# --- several nuts or bearing rows on one shaft


def load_paths_by_body(
    assembly: Assembly, result: AxisResult, path: loading.LoadPath | None
) -> tuple[loading.LoadPath, ...]:
    """Return for each loaded body (shaft or housing) how supports and contacts share the loads on this body.

    The path for all loads together may hide that the frame carries the whole load on one body.

    Parameters
    ----------
    assembly
        Shaft with several nuts or bearing rows.
    result
        Converged result of the assembly.
    path
        How supports and contacts share all loads, returned alone if only one body is loaded.

    Returns
    -------
    tuple
        The paths, from the changes of the reactions when the loads on a body are removed; empty without loads.
    """
    bodies, options = loading.assemblies_by_loaded_body(assembly), ModelOptions(member=result.member)
    if len(bodies) < 2:
        return () if path is None else (path,)
    without = {name: run_model(others, result.model, options) for name, (_, others) in bodies.items()}
    found = (loading.load_path(alone, result, without[name], name) for name, (alone, _) in bodies.items())
    return tuple(x for x in found if x is not None)


#: Axial force on an unloaded nut or row, over the sum of its contact loads, up to which nothing on the shaft braces it: the
#: formulas of rigidity know only the preload within a nut.
FREE = 1e-6


def names_by_pressure(sets: Mapping[str, SetResult]) -> list[str]:
    """Return the names of the loaded nuts or bearing rows, by decreasing ratio of highest to allowed pressure."""
    worst = {name: s.worst for name, s in sets.items()}
    shares = {name: w.pressure / w.static_safety.allowed_pressure for name, w in worst.items() if w is not None}
    return sorted(shares, key=lambda name: -shares[name])
