"""Conversion of solved scenes, and of the load cases of a duty cycle, to the JSON that ``rollbench solve`` prints."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from rollbench.compare.measure import count_contacts, error_percent, mean_load
from rollbench.compare.models.answers import LifeByLoads, LoadResults, RollerLoadResults, clearance_of_deep_groove
from rollbench.compare.models.load_cases import DutyCycleResults, LivesOverDutyCycle, SceneSolution, ShaftSolution
from rollbench.compare.models.model_form import ExpectedModelErrors
from rollbench.compare.models.registry import has_random_errors
from rollbench.compare.models.stiffness import SceneStiffness
from rollbench.compare.quantities import json_number, record_as_json
from rollbench.compare.scenes.duty_cycle import DutyCycle, LoadCase
from rollbench.lowfi.rating.contacts import RACES, contact_pressures, race_pressures
from rollbench.lowfi.rating.iso_lives import ReferenceLife
from rollbench.lowfi.statics.nominal import count_nominal_contacts
from rollbench.lowfi.statics.result import AxisResult, SetResult, StaticResult
from rollbench.lowfi.statics.tangent import TangentStiffness
from rollbench.lowfi.warned import join_brief_warnings
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import RollerRow
from rollbench.meshes.parts import FREEDOMS, SIDES, Motion, Scene
from rollbench.meshes.quantity import QuantityDescription, quantity_field, result_record

if TYPE_CHECKING:
    from rollbench.compare.models.answers import NutOrBearingResults
    from rollbench.lowfi.bearings.torque import PalmgrenLoadTorque

#: JSON keys in the summary of a nut or bearing that are not repeated in the summary of the whole shaft.
OF_A_SET = ("sides", "nut", "preload", "starting_torque", "bearing_torque", "clearance", "roller_torque")


def values_by_flank(row: Array) -> dict[str, float | None]:
    """Return one ball's four values by groove flank: SL, SR, NL, NR (screw or nut, left or right); nan becomes None."""
    return {side: json_number(value) for side, value in zip(SIDES, row, strict=True)}


@result_record
class BallResult:
    """Position of one ball, and its load, contact angle and pressure on the four groove flanks, (4,) each, in SI units.

    The flanks are SL, SR, NL, NR (screw or nut, left or right).
    """

    index: int = quantity_field("index", "number of the ball along its track, from 1")
    azimuth: float = quantity_field(
        "azimuth_deg", "nominal azimuth of the ball, from x to y; it keeps increasing after each turn of the helix"
    )
    z: float = quantity_field("z_mm", "nominal axial position of the ball's centre along the screw")
    load: Array = quantity_field(
        "load_N",
        "contact load of this ball on this flank; 0 without contact",
        error="model form: `model_form`; measured: `compare`",
        parts=".FLANK",
        show=values_by_flank,
    )
    angle: Array = quantity_field(
        "contact_angle_deg",
        "angle between the contact normal and the radial direction, in the axial plane through the ball's solved position; "
        "null without load",
        error="of the order of the elastic approach divided by the groove's excess radius",
        parts=".FLANK",
        show=values_by_flank,
    )
    pressure: Array = quantity_field(
        "pressure_MPa",
        "largest pressure of this contact, from the load and the radii with their errors by Hertz's theory, or as the "
        "model gives it; 0 without contact",
        error="a third of that of the load",
        parts=".FLANK",
        show=values_by_flank,
    )


@result_record
class RollerResult:
    """Position, load, largest load per length and largest pressures of one roller, in SI units."""

    index: int = quantity_field("index", "number of the roller in its row, from 1")
    azimuth: float = quantity_field("azimuth_deg", "azimuth of the roller, from x to y")
    load: float = quantity_field("load_N", "load of the roller on either race", error="not compared with a 3D model")
    line_load: float = quantity_field(
        "largest_line_load_N_mm",
        "largest load per length of any of the equal slices into which the roller is divided",
        error="that of the slice model, which neglects the stress concentration at the ends of straight rollers",
    )
    pressure: dict[str, float] = quantity_field(
        "pressure_MPa",
        "largest pressure along the roller on inner and outer race, from sqrt(q E*/(pi R)) with the line load q and the "
        "relative radius R of each slice",
        error="half that of the line load",
        parts=".*",
    )


@result_record
class BallLoadSummary:
    """Summary of the contact loads of all balls: largest, mean and smallest load [N], and numbers of contacts."""

    ball: int = quantity_field("worst_ball", "number of the ball with the largest contact load")
    side: str = quantity_field("worst_side", "groove flank with the largest contact load")
    largest: float = quantity_field(
        "max_N",
        "largest contact load",
        error="model form, `largest_percent_of_mean`",
        heading="largest contact load",
        expected=("percent", 1.0),
        note="ball {worst_ball} {worst_side}",
    )
    mean: float = quantity_field(
        "mean_N",
        "mean contact load: sum of the loads, divided by the number of contacts that are loaded in the screw without "
        "geometric errors",
        error="small: equilibrium fixes the sum",
        heading="mean contact load",
    )
    smallest: float = quantity_field(
        "min_N",
        "smallest load of a loaded contact",
        error="model form, `largest_percent_of_mean`",
        heading="smallest contact load",
        expected=("percent", 1.0),
        note="of {loaded_contacts} loaded",
    )
    loaded_contacts: int = quantity_field("loaded_contacts", "number of loaded contacts")
    contacts_in_mean: int = quantity_field(
        "contacts_in_mean", "number of contacts by which the sum of the loads is divided for the mean"
    )
    unloaded_balls: int = quantity_field(
        "balls_without_load", "number of balls without any load", heading="balls without load"
    )


@result_record
class RollerLoadSummary:
    """Summary of the loads of a row of rollers: largest, mean and smallest load [N], and numbers of rollers."""

    roller: int = quantity_field(
        "worst_roller",
        "number of the roller with the largest load; for a row of rollers this table counts rollers instead of contacts, "
        "since each roller has the same load on both races",
    )
    largest: float = quantity_field("max_N", heading="largest roller load", note="roller {worst_roller}")
    mean: float = quantity_field("mean_N", heading="mean roller load")
    smallest: float = quantity_field("min_N", heading="smallest roller load", note="of {loaded_contacts} loaded")
    loaded_rollers: int = quantity_field("loaded_contacts")
    unloaded_rollers: int = quantity_field(
        "rollers_without_load", "number of rollers without any load", heading="rollers without load"
    )


@result_record
class FlankLoadSummary:
    """Summary of the contact loads on one groove flank: largest and smallest load [N], their ratio, numbers of contacts."""

    largest: float = quantity_field("max_N", "largest load on this flank", error="as `loads.max_N`")
    smallest: float = quantity_field("min_N", "smallest load of a loaded contact on this flank", error="as `loads.min_N`")
    ratio: float = quantity_field(
        "ratio",
        "largest load on this flank, divided by the smallest",
        error="that of both loads; in the worst case their errors have opposite signs",
    )
    loaded_contacts: int = quantity_field("loaded", "number of loaded contacts on this flank")
    unloaded_contacts: int = quantity_field("lost", "number of contacts on this flank that carry no load")


@result_record
class AxialResults:
    """Axial force [N] on a screw, bearing or shaft, and a stiffness of the model liu [N/m]."""

    force: float = quantity_field(
        "force_N",
        "axial force on the screw, from the external loads and the reactions; positive towards larger z",
        heading="axial force",
    )
    stiffness_over_load_step: float | None = quantity_field(
        "stepped_N_per_um",
        "stiffness by the model liu over the load step `ingredients.load_step`, at the first loaded ball (Liu, equations "
        "19 to 22)",
        error="not known: the model has not been compared with the 3D reference",
        heading="rigidity over the load step",
        default=None,
    )


@result_record
class StiffnessAtPosition:
    """Tangent stiffness (6, 6) [N/m, N/rad, N m/rad] at an axial position [m]; nan in fixed degrees of freedom."""

    station: float | None = quantity_field(
        "station_mm", "axial position on the shaft at which the 6 x 6 stiffness is taken"
    )
    status: str = quantity_field("status")
    """Status of the solution, such as "converged"."""
    freedoms: tuple[str, ...] = quantity_field("freedoms")
    """Names of the degrees of freedom of the rows and columns: ux, uy, uz, rx, ry, rz."""
    matrix: Array = quantity_field(
        "matrix",
        "row by row: change of force [N] and moment [N m] for a unit displacement [m] or rotation [rad] of the shaft at "
        "this position, with the nut fixed; null in degrees of freedom that a support fixes",
        parts="[][]",
    )


@result_record
class AxisPointDisplacement:
    """Displacement and rotation (6,) [m, rad] of a point on the screw's axis, at an axial position [m]."""

    z: float = quantity_field("z_mm", "axial position of a point on the screw's axis")
    motion: Array = quantity_field(
        "ux_um",
        "displacement of this point along x",
        QuantityDescription("uy_um", "displacement of this point along y", show=lambda motion: motion[1]),
        QuantityDescription("uz_um", "displacement of this point along z", show=lambda motion: motion[2]),
        show=lambda motion: motion[0],
    )


def flank_loads_json(load: Array) -> dict[str, Any]:
    """Return the summary of contact loads (`FlankLoadSummary`) on each loaded groove flank as JSON, by name of the flank.

    ``load``: contact loads of n balls, (n, 4) [N].
    """
    out = {}
    for side, values in zip(SIDES, load.T, strict=True):
        loaded = values[values > 0.0]
        if loaded.size:
            most, least, lost = loaded.max(), loaded.min(), int(values.size - loaded.size)
            out[side] = record_as_json(FlankLoadSummary(most, least, most / least, int(loaded.size), lost))
    return out


def ball_loads_json(load: Array, contacts: int = 0) -> dict[str, Any] | None:
    """Return the summary of the contact loads of balls as JSON (`BallLoadSummary`); None if no contact is loaded.

    ``load``: contact loads of n balls on the four flanks, (n, 4) [N]. ``contacts``: number by which the sum of the loads is
    divided for the mean load; 0: the number of loaded contacts.
    """
    loaded = load > 0.0
    if not loaded.any():
        return None
    carried, mean = load[loaded], mean_load(load, contacts)
    i, s = np.unravel_index(int(load.argmax()), load.shape)
    empty = int((~loaded.any(axis=1)).sum())
    ends, counts = (carried.max(), mean, carried.min()), (int(carried.size), count_contacts(load, contacts), empty)
    return record_as_json(BallLoadSummary(int(i) + 1, SIDES[int(s)], *ends, *counts))


def roller_loads_json(load: Array) -> dict[str, Any] | None:
    """Return the summary of the loads (count,) [N] of a row of rollers as JSON (`RollerLoadSummary`).

    None if all are zero.
    """
    carried = load[load > 0.0]
    if not carried.size:
        return None
    ends, empty = (carried.max(), carried.mean(), carried.min()), int(load.size - carried.size)
    return record_as_json(RollerLoadSummary(int(load.argmax()) + 1, *ends, int(carried.size), empty))


def stiffness_of_scene_json(stiffness: SceneStiffness, *without: str) -> dict[str, Any]:
    """Return displacement and stiffness of nut or bearing, and of the load's point, as JSON.

    ``without``: keys to leave out.
    """
    of_load = record_as_json(stiffness.load_point, *without)
    return {"nut": record_as_json(stiffness.nut), "load_point": of_load, "tangent_words": stiffness.words or None}


def stiffness_json(station: float | None, status: str, matrix: Array) -> dict[str, Any]:
    """Return a stiffness matrix as JSON, with null in fixed degrees of freedom.

    ``station``: axial position on the shaft [m]. ``status``: status of the solution. ``matrix``: stiffness, (6, 6) [N/m,
    N/rad, N m/rad].
    """
    return record_as_json(StiffnessAtPosition(station, str(status), FREEDOMS, matrix))


def life_json(life: LifeByLoads | None, speed: float | None) -> dict[str, Any] | None:
    """Return a rating life as JSON, also in hours if the speed is known; None if there is no life.

    ``speed``: speed of rotation [rad/s]; None if it is not known.
    """
    data, key = record_as_json(life), "L10r_hours" if isinstance(life, ReferenceLife) else "L10_hours"
    return data | {key: json_number(life.hours(speed))} if data is not None and life and speed else data


def contact_ratings_json(answers: LoadResults, motion: Motion | None = None) -> dict[str, Any]:
    """Return worst contact, static safety, life and load ratings of one nut or bearing as JSON.

    ``answers``: results from the contact loads of one nut or bearing. ``motion``: motion whose speed gives the life in
    hours.
    """
    if isinstance(answers, RollerLoadResults):
        safety = record_as_json(answers.safety, "permanent_over_diameter", "allowed_over_diameter")
        data = record_as_json(answers) | {"static_safety": safety, "rating_refused": None}
    else:
        data = record_as_json(answers)
    speed = None if motion is None else motion.speed
    return data | {"life": life_json(answers.life, speed), "reference_life": life_json(answers.reference, speed)}


def single_set_results_json(solved: SceneSolution) -> dict[str, Any]:
    """Return the summary of a scene with a single nut or bearing as JSON; empty if there is no equilibrium.

    ``solved``: the solved scene. Forces are in N, displacements in um, rigidities in N/um.
    """
    scene, answers = solved.scene, solved.derived_results
    if answers is None:
        return {}
    three, step = answers.rigidities, answers.load_step_stiffness
    axial = AxialResults(answers.axial_force, step)
    return {
        "loads": ball_loads_json(solved.result.load, count_nominal_contacts(scene, solved.result)),
        "axial": record_as_json(axial, *(("stepped_N_per_um",) if step is None else ())),
        **stiffness_of_scene_json(answers.stiffness, "lost_motion_um_per_100N"),
        **(record_as_json(three) or {"rigidities_N_per_um": None}),
        **contact_ratings_json(answers.load_results, scene.motion),
        "preload": record_as_json(answers.preload),
        "contact_lost": record_as_json(answers.lift_off),
        "friction": answers.friction,
        "friction_words": answers.friction_words or None,
        "load_path": record_as_json(answers.load_path),
        "shaft": record_as_json(answers.shaft_limits),
        "clearance": record_as_json(clearance_of_deep_groove(scene)),
        **({} if scene.track.lead else {"bearing_torque": record_as_json(answers.bearing_torque)}),
    }


def palmgren_load_torque(parts: Scene, thrust: float) -> PalmgrenLoadTorque:
    """Return the load-dependent friction torque of a ball bearing by Palmgren's formula (Smith, equations 2.33 to 2.38).

    ``thrust`` is the axial load [N]. The formula is for contact angles of about 60 deg.
    """
    from rollbench.lowfi.bearings.torque import load_dependent_torque, palmgren_static_rating
    from rollbench.lowfi.statics.contacts import nominal_curvatures

    ball, track = 2.0 * parts.balls.radius, parts.track
    across, along = nominal_curvatures(parts)[0]
    rated = palmgren_static_rating(1, parts.ball_count, ball, track.contact_angle, float(across), float(along))
    return load_dependent_torque(abs(thrust), 0.0, 2.0 * track.pitch_radius, rated)


def starting_torque_json(set_result: SetResult, answers: NutOrBearingResults) -> dict[str, Any] | None:
    """Return the starting torque of a preloaded ball bearing that carries thrust in one direction, as JSON.

    None is returned for a bearing that carries thrust in both directions or has no preload, and for a nut. ``set_result``:
    solution of the bearing. ``answers``: record from which the geometry (`Scene`) and the preload of the bearing are taken.
    """
    parts, preload = answers.parts, answers.preload
    one_way = set_result.of.kind == "bearing" and set_result.of.thrust in ("+z", "-z")
    if not isinstance(parts, Scene) or not one_way or not (preload and preload.axial):
        return None
    return record_as_json(palmgren_load_torque(parts, preload.axial))


def nut_or_bearing_summary_json(
    set_result: SetResult, answers: NutOrBearingResults | None, motion: Motion | None
) -> dict[str, Any]:
    """Return the JSON summary of one nut or bearing out of several on a shaft; empty without equilibrium.

    ``set_result``: solution of the nut or bearing. ``answers``: results from its contact loads, and its stiffness; None:
    only the loads on each flank are returned. ``motion``: motion whose speed gives the life in hours.
    """
    if not np.isfinite(set_result.loads).all():
        return {}
    data: dict[str, Any] = {} if set_result.balls is None else {"sides": flank_loads_json(set_result.balls.load)}
    if answers is None:
        return data
    loads = roller_loads_json(set_result.loads) if set_result.balls is None else ball_loads_json(set_result.balls.load)
    data |= {"loads": loads, "nut": record_as_json(answers.stiffness)} | contact_ratings_json(answers.load_results, motion)
    data["preload"] = record_as_json(answers.preload)
    if not isinstance(answers.parts, Scene):
        return data
    data["clearance"] = record_as_json(clearance_of_deep_groove(answers.parts, set_result.of.thrust))
    data |= {} if answers.parts.track.lead else {"bearing_torque": record_as_json(answers.friction_torque)}
    return data | {"starting_torque": starting_torque_json(set_result, answers)}


def axis_stiffness_json(result: AxisResult) -> dict[str, Any] | None:
    """Return the stiffness of a shaft with several nuts or bearings as JSON; None if it was not computed."""
    if result.stiffness is None:
        return None
    return {"at": result.stiffness_at, **stiffness_json(result.station, result.status, result.stiffness)}


def axis_summary_json(solved: ShaftSolution) -> dict[str, Any]:
    """Return the JSON summary of several nuts or bearings on one shaft.

    ``solved``: the solved shaft. The summary has the loads on each groove flank, the axial force, displacement and
    rigidities, and the results of the nut or bearing that has the worst contact.
    """
    result, answers = solved.result, solved.derived_results
    if not result.converged:
        return {}
    loads = [balls.load for balls in result.ball_results()]
    data: dict[str, Any] = {"sides": flank_loads_json(np.concatenate(loads))} if loads else {}
    if answers is None:
        return data
    data["axial"] = record_as_json(AxialResults(answers.axial_load), "stepped_N_per_um")
    data |= stiffness_of_scene_json(answers.stiffness)
    data["stiffness"] = axis_stiffness_json(result)
    data["load_path"] = record_as_json(answers.load_path)
    data |= {"drive": record_as_json(solved.motor_torques), "axis_life": record_as_json(solved.combined_life)}
    if k := answers.worst_set:
        of_set = nut_or_bearing_summary_json(result.sets[k - 1], answers.set_results[k - 1], solved.scene.motion)
        data |= {"worst_set": k} | {k: of_set[k] for k in of_set if k not in OF_A_SET}
    return data


def solved_case_json(solved: SceneSolution | ShaftSolution, tangent: TangentStiffness | None = None) -> dict[str, Any]:
    """Return the results of a solved scene as JSON: angles in deg, positions in mm, displacements in um, forces in N.

    With several nuts or bearings on one shaft, each row of a ball or roller has the number of its nut or bearing, and
    ``sets`` has a summary of each.

    Parameters
    ----------
    solved
        The solution.
    tangent
        Stiffness at the axial position that the user asked for; None if no position was asked for.

    Returns
    -------
    dict
        JSON values.
    """
    result = solved.result
    answers: dict[str, Any]
    if isinstance(solved, ShaftSolution):
        of_sets = [None] * len(solved.result.sets) if solved.derived_results is None else solved.derived_results.set_results
        pairs = enumerate(zip(solved.result.sets, of_sets, strict=True), 1)
        answers = {
            "kind": solved.scene.kind,
            "sets": [
                {"set": k, **record_as_json(s), "summary": nut_or_bearing_summary_json(s, x, solved.scene.motion)}
                for k, (s, x) in pairs
            ],
            "balls": ball_rows_of_shaft_json(solved.result),
            "rollers": roller_rows_json(solved.result),
            "summary": axis_summary_json(solved),
            "housings": [record_as_json(housing) for housing in solved.result.housings],
            "stiffness": axis_stiffness_json(solved.result),
        }
    else:
        summary = {"sides": flank_loads_json(solved.result.load), **single_set_results_json(solved)}
        if tangent is not None and solved.derived_results is not None:
            summary["stiffness"] = stiffness_json(tangent.station, tangent.status, tangent.matrix)
        balls = ball_rows_json(solved.scene, solved.result)
        answers = {"balls": balls, "summary": summary if np.isfinite(solved.result.load).all() else {}}
    grid = beam_discretisation_percent(solved.scene, solved.result) if isinstance(solved, SceneSolution) else None
    line = zip(result.centreline_z, result.centreline, strict=True)
    return {
        "scene": solved.scene.name,
        "model": result.model,
        "member": result.member if has_random_errors(solved.scene) else None,
        "status": result.status,
        **answers,
        "centreline": [record_as_json(AxisPointDisplacement(z, motion)) for z, motion in line],
        "equilibrium": record_as_json(result.equilibrium),
        "solver": record_as_json(result.solver) | {"discretisation_percent": grid},
        "model_form": record_as_json(solved.expected_errors),
        "assumed": list(result.assumed),
        "left_out": list(result.left_out),
        "warning": join_brief_warnings(result.warnings) or None,
        "warnings": list(result.warnings),
    }


def expected_errors_json(model_form: ExpectedModelErrors | None, key: str) -> dict[str, float | None]:
    """Return the errors to expect [%] of displacement, rigidity and pressure, by name; None where none can be estimated.

    ``model_form``: the errors to expect. ``key``: template of the names, such as ``expected_{}_error_percent``.
    """
    names = ("displacement", "rigidity", "pressure")
    errors = {key.format(name): getattr(model_form, f"{name}_percent", None) for name in names}
    return {name: None if value is None else json_number(value) for name, value in errors.items()}


def beam_discretisation_percent(scene: Scene, result: StaticResult) -> float | None:
    """Return the error of the contact loads due to the length of the beam elements [% of the mean contact load].

    Returns None if this error was not estimated.
    """
    change = result.solver.discretisation
    if change is None:
        return None
    return json_number(float(error_percent(change, 0.0, mean_load(result.load, count_nominal_contacts(scene, result)))))


def ball_rows_json(scene: Scene, balls: StaticResult) -> list[dict[str, Any]]:
    """Return a JSON row for every ball: number from 1, position, loads, contact angles and pressures.

    ``scene``: the nut or bearing. ``balls``: its solution.
    """
    pressure = contact_pressures(scene, balls)
    rows = zip(balls.azimuth, balls.z, balls.load, balls.contact_angle, pressure, strict=True)
    return [record_as_json(BallResult(i, *row)) for i, row in enumerate(rows, 1)]


def ball_rows_of_shaft_json(result: AxisResult) -> list[dict[str, Any]]:
    """Return a JSON row for every ball of all nuts and bearings of a shaft, numbered from 1 in each of them."""
    rows = []
    for k, s in enumerate(result.sets, 1):
        if s.balls is not None and isinstance(s.of.parts, Scene):
            rows += [{"set": k} | row for row in ball_rows_json(s.of.parts, s.balls)]
    return rows


def roller_rows_json(result: AxisResult) -> list[dict[str, Any]]:
    """Return a JSON row for every roller of all roller bearings of a shaft, numbered from 1 in each bearing."""
    rows = []
    for k, s in enumerate(result.sets, 1):
        if not isinstance(s.of.parts, RollerRow) or s.roller_azimuth is None or s.line_loads is None:
            continue
        pressures = race_pressures(s.of.parts, s.line_loads)
        each = zip(s.roller_azimuth, s.loads, s.line_loads.max(axis=1), pressures, strict=True)
        for i, (azimuth, load, line_load, of_races) in enumerate(each, 1):
            row = RollerResult(i, azimuth, load, line_load, dict(zip(RACES, of_races, strict=True)))
            rows.append({"set": k} | record_as_json(row))
    return rows


def duty_cycle_json(
    cycle: DutyCycle,
    solved: Sequence[SceneSolution | ShaftSolution],
    cycle_results: DutyCycleResults,
    tangents: Sequence[TangentStiffness | None] = (),
) -> dict[str, Any]:
    """Return a solved duty cycle as JSON: the results of each load case, and the extremes and lives over all cases.

    Parameters
    ----------
    cycle
        The duty cycle.
    solved
        Solutions of the load cases.
    cycle_results
        Extremes and lives over all load cases.
    tangents
        For each load case, the stiffness at the axial position that the user asked for; empty if none was asked for.
    """
    each = zip(cycle.cases, solved, tangents or [None] * len(solved), strict=True)
    unsolved = "; ".join(f"case {name}: {status}" for name, status in cycle_results.unsolved.items())
    return {
        "scene": cycle.name,
        "model": solved[0].result.model,
        "status": unsolved or "converged",
        "summary": cycle_results_json(cycle_results),
        "cases": [
            {**load_case_head_json(cycle, case), **solved_case_json(one, tangent), "scene": cycle.name}
            for case, one, tangent in each
        ],
    }


def load_case_head_json(cycle: DutyCycle, case: LoadCase) -> dict[str, Any]:
    """Return the first keys and values in the JSON of a load case: name of the scene, then name and data of the case."""
    return {"scene": cycle.name, **record_as_json(case)}


def cycle_results_json(cycle_results: DutyCycleResults) -> dict[str, Any]:
    """Return the extreme results over all load cases, and the lives over the duty cycle, as JSON.

    ``cycle_results``: extremes and lives over all load cases. With several nuts or bearings, ``sets`` has the lives of
    each.
    """

    def lives_json(lives: LivesOverDutyCycle) -> dict[str, Any]:
        """Return the lives of one nut or bearing over a duty cycle as JSON, one for each standard that gives a life."""
        speed = cycle_results.speed
        timed = {"reference_life": life_json(lives.reference, speed)}
        return {"life": life_json(lives.life, speed), **record_as_json(lives), **timed}

    several = len(cycle_results.lives) != 1
    data = record_as_json(cycle_results, *([] if several else ["life_set", "axis_life"]))
    data |= lives_json(cycle_results.shortest_lives)
    return data | {"sets": [{"name": x.set} | lives_json(x) for x in cycle_results.lives]} if several else data
