"""Conversion of solved scenes, and of the load cases of a duty cycle, to the JSON that ``rollbench solve`` prints."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from rollbench.compare.measure import count_contacts, error_percent, mean_load
from rollbench.compare.models.answers import LoadAnswers, RollerAnswers, clearance_of_deep_groove
from rollbench.compare.models.load_cases import CycleResults, Lives, Solved, SolvedAxis
from rollbench.compare.models.model_form import ModelForm
from rollbench.compare.models.registry import random_errors
from rollbench.compare.quantities import as_json, number
from rollbench.compare.scenes.duty_cycle import DutyCycle, LoadCase
from rollbench.lowfi.rating.contacts import RACES, contact_pressures, race_pressures
from rollbench.lowfi.rating.life import Life
from rollbench.lowfi.statics.nominal import nominal_contacts
from rollbench.lowfi.statics.result import AxisResult, SetResult, StaticResult
from rollbench.lowfi.statics.tangent import Tangent
from rollbench.lowfi.warned import warning_line
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import RollerRow
from rollbench.meshes.parts import FREEDOMS, SIDES, Motion, Scene
from rollbench.meshes.quantity import Stated, quantity, record

if TYPE_CHECKING:
    from rollbench.compare.models.answers import SetAnswers
    from rollbench.lowfi.bearings.torque import LoadTorque

#: Keys in the summary of a nut or bearing that are not repeated in the summary of the whole shaft.
OF_A_SET = ("sides", "preload", "starting_torque", "bearing_torque", "clearance", "roller_torque")
#: Friction force [N] whose reversal causes the lost motion that is printed.
LOST_BY = 100.0


def per_side(row: Array) -> dict[str, float | None]:
    """Return four values as a dictionary, by the names of the groove flanks SL, SR, NL, NR; None for a value of nan."""
    return {side: number(value) for side, value in zip(SIDES, row, strict=True)}


@record
class BallRow:
    """Position of one ball, and its load, contact angle and pressure on the four groove flanks, (4,) each, in SI units."""

    index: int = quantity("index", "number of the ball along its track, from 1")
    azimuth: float = quantity(
        "azimuth_deg", "nominal azimuth of the ball, from x to y; it keeps increasing after each turn of the helix"
    )
    z: float = quantity("z_mm", "nominal axial position of the ball's centre along the screw")
    load: Array = quantity(
        "load_N",
        "contact load of this ball on this flank; 0 without contact",
        error="model form: `model_form`; measured: `compare`",
        parts=".FLANK",
        show=per_side,
    )
    angle: Array = quantity(
        "contact_angle_deg",
        "angle between the contact normal and the radial direction, in the axial plane through the ball's solved position; "
        "null without load",
        error="of the order of the elastic approach divided by the groove's excess radius",
        parts=".FLANK",
        show=per_side,
    )
    pressure: Array = quantity(
        "pressure_MPa",
        "largest pressure of this contact, from the load and the radii with their errors by Hertz's theory, or as the "
        "model gives it; 0 without contact",
        error="a third of that of the load",
        parts=".FLANK",
        show=per_side,
    )


@record
class RollerRowAnswer:
    """Azimuth [rad], load [N], largest load per length [N/m] and largest pressure [Pa] on each race, for one roller."""

    index: int = quantity("index", "number of the roller in its row, from 1")
    azimuth: float = quantity("azimuth_deg", "azimuth of the roller, from x to y")
    load: float = quantity("load_N", "load of the roller on either race", error="not compared with a 3D model")
    line_load: float = quantity(
        "largest_line_load_N_mm",
        "largest load per length of any of the equal slices into which the roller is divided",
        error="that of the slice model, which neglects the stress concentration at the ends of straight rollers",
    )
    pressure: dict[str, float] = quantity(
        "pressure_MPa",
        "largest pressure along the roller on inner and outer race, from sqrt(q E*/(pi R)) with the line load q and the "
        "relative radius R of each slice",
        error="half that of the line load",
        parts=".*",
    )


@record
class LoadSums:
    """Summary of the contact loads of balls: largest, mean and smallest load [N], worst contact, numbers of contacts."""

    ball: int = quantity("worst_ball", "number of the ball with the largest contact load")
    side: str = quantity("worst_side", "groove flank with the largest contact load")
    largest: float = quantity(
        "max_N",
        "largest contact load",
        error="model form, `largest_percent_of_mean`",
        heading="largest contact load",
        expected=("percent", 1.0),
        note="ball {worst_ball} {worst_side}",
    )
    mean: float = quantity(
        "mean_N",
        "mean contact load: sum of the loads, divided by the number of contacts that are loaded in the screw without "
        "geometric errors",
        error="small: equilibrium fixes the sum",
        heading="mean contact load",
    )
    least: float = quantity(
        "min_N",
        "smallest load of a loaded contact",
        error="model form, `largest_percent_of_mean`",
        heading="smallest contact load",
        expected=("percent", 1.0),
        note="of {loaded_contacts} loaded",
    )
    loaded: int = quantity("loaded_contacts", "number of loaded contacts")
    in_mean: int = quantity("contacts_in_mean", "number of contacts by which the sum of the loads is divided for the mean")
    unloaded: int = quantity("balls_without_load", "number of balls without any load", heading="balls without load")


@record
class RollerSums:
    """Summary of the loads of a row of rollers: largest, mean and smallest load [N], worst roller, numbers of rollers."""

    roller: int = quantity(
        "worst_roller",
        "number of the roller with the largest load; for a row of rollers this table counts rollers instead of contacts, "
        "since each roller has the same load on both races",
    )
    largest: float = quantity("max_N", heading="largest roller load", note="roller {worst_roller}")
    mean: float = quantity("mean_N", heading="mean roller load")
    least: float = quantity("min_N", heading="smallest roller load", note="of {loaded_contacts} loaded")
    loaded: int = quantity("loaded_contacts")
    unloaded: int = quantity("rollers_without_load", "number of rollers without any load", heading="rollers without load")


@record
class SideSums:
    """Summary of the contact loads on one groove flank: largest and smallest load [N], their ratio, numbers of contacts."""

    largest: float = quantity("max_N", "largest load on this flank", error="as `loads.max_N`")
    least: float = quantity("min_N", "smallest load of a loaded contact on this flank", error="as `loads.min_N`")
    ratio: float = quantity(
        "ratio",
        "largest load on this flank, divided by the smallest",
        error="that of both loads; in the worst case their errors have opposite signs",
    )
    loaded: int = quantity("loaded", "number of loaded contacts on this flank")
    lost: int = quantity("lost", "number of contacts on this flank that carry no load")


@record
class Axial:
    """Axial force [N], displacement [m] and rigidities [N/m] of a scene, and the reason if it has no tangent stiffness."""

    force: float = quantity(
        "force_N",
        "axial force on the screw, from the external loads and the reactions; positive towards larger z",
        heading="axial force",
    )
    displacement: float | None = quantity(
        "displacement_um",
        "axial displacement of the screw at the nut's centre (of an axis: at its loaded cross-section), relative to the "
        "same scene without external loads",
        error="`model_form.displacement_percent`",
        heading="axial displacement",
        expected=("displacement_percent", 1.0),
    )
    rigidity: float | None = quantity(
        "rigidity_N_per_um",
        "secant stiffness: axial force divided by axial displacement",
        error="that of the displacement",
        heading="axial rigidity, secant",
        expected=("displacement_percent", 1.0),
    )
    tangent: float | None = quantity(
        "tangent_N_per_um",
        "tangent stiffness: derivative of the axial force with respect to the axial displacement at the solution, with the "
        "other degrees of freedom free",
        error="`model_form.rigidity_percent`",
        heading="axial rigidity, tangent",
        expected=("rigidity_percent", 1.0),
        default=None,
    )
    words: str = quantity(
        "tangent_words", "reason why there is no tangent stiffness", show=lambda words: words or None, default=""
    )
    stepped: float | None = quantity(
        "stepped_N_per_um",
        "stiffness by the model liu over the load step `ingredients.load_step`, at the first loaded ball (Liu, equations "
        "19 to 22)",
        error="not known: the model has not been compared with the 3D reference",
        heading="rigidity over the load step",
        default=None,
    )

    @property
    @Stated(
        "lost_motion_um_per_100N",
        "axial displacement when a friction force of 100 N reverses: 2 x 100 N divided by the tangent stiffness at rest",
        heading="lost motion, um by 100 N",
    )
    def lost_motion(self) -> float | None:
        """Axial displacement [um] when a friction force of 100 N reverses; None without tangent stiffness."""
        return None if self.tangent is None or self.tangent <= 0.0 else 1e6 * (2.0 * LOST_BY / self.tangent)


@record
class StiffnessAt:
    """Tangent stiffness (6, 6) [N/m, N/rad, N m/rad] at an axial position [m]; nan in fixed degrees of freedom."""

    station: float | None = quantity("station_mm", "axial position on the shaft at which the 6 x 6 stiffness is taken")
    status: str = quantity("status")
    freedoms: tuple[str, ...] = quantity("freedoms")
    matrix: Array = quantity(
        "matrix",
        "row by row: change of force [N] and moment [N m] for a unit displacement [m] or rotation [rad] of the shaft at "
        "this position, with the nut fixed; null in degrees of freedom that a support fixes",
        error="`model_form.rigidity_percent`, on its axial term",
        parts="[][]",
    )


@record
class CentrelinePoint:
    """A point of the screw's axis: its axial position [m] and its displacement, (6,) [m, rad]."""

    z: float = quantity("z_mm", "axial position of a point on the screw's axis")
    motion: Array = quantity(
        "ux_um",
        "displacement of this point along x",
        Stated("uy_um", "displacement of this point along y", show=lambda motion: motion[1]),
        Stated("uz_um", "displacement of this point along z", show=lambda motion: motion[2]),
        show=lambda motion: motion[0],
    )


def sides_json(load: Array) -> dict[str, Any]:
    """Return the load summary (`SideSums`) of every groove flank with a loaded contact as JSON, by name of the flank.

    ``load``: contact loads of n balls, (n, 4) [N].
    """
    out = {}
    for side, values in zip(SIDES, load.T, strict=True):
        loaded = values[values > 0.0]
        if loaded.size:
            most, least = loaded.max(), loaded.min()
            out[side] = as_json(SideSums(most, least, most / least, int(loaded.size), int(values.size - loaded.size)))
    return out


def loads_json(load: Array, contacts: int = 0) -> dict[str, Any] | None:
    """Return the summary of the contact loads of balls as JSON (`LoadSums`); None if no contact is loaded.

    ``load``: contact loads of n balls on the four flanks, (n, 4) [N]. ``contacts``: number by which their sum is divided
    for the mean load; 0: the number of loaded contacts.
    """
    loaded = load > 0.0
    if not loaded.any():
        return None
    carried, mean = load[loaded], mean_load(load, contacts)
    i, s = np.unravel_index(int(load.argmax()), load.shape)
    empty = int((~loaded.any(axis=1)).sum())
    ends = carried.max(), mean, carried.min()
    return as_json(LoadSums(int(i) + 1, SIDES[int(s)], *ends, int(carried.size), count_contacts(load, contacts), empty))


def roller_loads_json(load: Array) -> dict[str, Any] | None:
    """Return the summary of the loads (count,) [N] of a row of rollers as JSON (`RollerSums`); None if all are zero."""
    carried = load[load > 0.0]
    if not carried.size:
        return None
    ends = carried.max(), carried.mean(), carried.min()
    return as_json(RollerSums(int(load.argmax()) + 1, *ends, int(carried.size), int(load.size - carried.size)))


def stiffness_json(station: float | None, status: str, matrix: Array) -> dict[str, Any] | None:
    """Return a stiffness matrix as JSON, with null in fixed degrees of freedom.

    ``station``: axial position on the shaft [m]. ``status``: status of the solution. ``matrix``: stiffness, (6, 6) [N/m,
    N/rad, N m/rad].
    """
    return as_json(StiffnessAt(station, str(status), FREEDOMS, matrix))


def life_json(life: Life | None, speed: float | None) -> dict[str, Any] | None:
    """Return a rating life as JSON, also in hours if the speed is known; None if there is no life.

    ``speed``: speed of rotation [rad/s]; None if it is not known.
    """
    data = as_json(life)
    return data | {"L10_hours": number(life.hours(speed))} if data is not None and life and speed else data


def contacts_json(answers: LoadAnswers | RollerAnswers, motion: Motion | None = None) -> dict[str, Any]:
    """Return worst contact, static safety, life, load ratings and (for balls) ellipse truncation as JSON.

    ``answers``: results from the contact loads of one nut or bearing. ``motion``: motion whose speed gives the life in
    hours.
    """
    if isinstance(answers, RollerAnswers):
        safety = as_json(answers.safety, "permanent_over_diameter", "allowed_over_diameter")
        data = (as_json(answers) or {}) | {"static_safety": safety, "rating_refused": None}
    else:
        data = as_json(answers) or {}
    return data | {"life": life_json(answers.life, None if motion is None else motion.speed)}


def answers_json(one: Solved) -> dict[str, Any]:
    """Return all results of a single nut or bearing as JSON, which is empty if there is no equilibrium.

    ``one``: the solved scene. Forces are in N, displacements in um, rigidities in N/um.
    """
    scene, answers = one.scene, one.answers
    if answers is None:
        return {}
    three = answers.rigidities
    secant = None if three is None else three.unequal
    axial = Axial(answers.force, answers.displacement, secant, answers.tangent, answers.tangent_words, answers.stepped)
    return {
        "loads": loads_json(one.result.load, nominal_contacts(scene, one.result)),
        "axial": as_json(axial, "lost_motion_um_per_100N", *(["stepped_N_per_um"] if answers.stepped is None else [])),
        **(as_json(three) or {"rigidities_N_per_um": None}),
        **contacts_json(answers.loads, scene.motion),
        "preload": as_json(answers.preload),
        "contact_lost": as_json(answers.lift),
        "friction": answers.friction,
        "friction_words": answers.friction_words or None,
        "load_path": as_json(answers.path),
        "shaft": as_json(answers.shaft),
        "clearance": as_json(clearance_of_deep_groove(scene)),
        **({} if scene.track.lead else {"bearing_torque": as_json(answers.torque)}),
    }


def torque_by_palmgren(parts: Scene, thrust: float) -> LoadTorque:
    """Return the load-dependent friction torque of a ball bearing by Palmgren's formula (Smith, equations 2.33 to 2.38).

    ``thrust`` is the axial load [N]. The formula is for contact angles of about 60 deg.
    """
    from rollbench.lowfi.bearings.torque import load_torque, static_rating
    from rollbench.lowfi.statics.contacts import nominal_curvatures

    ball, track = 2.0 * parts.balls.radius, parts.track
    across, along = nominal_curvatures(parts)[0]
    rated = static_rating(1, parts.ball_count, ball, track.contact_angle, float(across), float(along))
    return load_torque(abs(thrust), 0.0, 2.0 * track.pitch_radius, rated)


def starting_torque_json(s: SetResult, answers: SetAnswers) -> dict[str, Any] | None:
    """Return the starting torque of a preloaded ball bearing as JSON; None unless it carries thrust in one direction.

    ``s``: solution of the bearing. ``answers``: its parts and its preload.
    """
    parts, preload = answers.parts, answers.preload
    one_way = s.of.kind == "bearing" and s.of.thrust in ("+z", "-z")
    if not isinstance(parts, Scene) or not one_way or not (preload and preload.axial):
        return None
    return as_json(torque_by_palmgren(parts, preload.axial))


def set_json(s: SetResult, answers: SetAnswers | None, motion: Motion | None) -> dict[str, Any]:
    """Return the JSON summary of one nut or bearing out of several on a shaft; empty without equilibrium.

    ``s``: its solution. ``answers``: results from its contact loads; None: only the loads on each flank are returned.
    ``motion``: motion whose speed gives the life in hours.
    """
    if not np.isfinite(s.loads).all():
        return {}
    data: dict[str, Any] = {} if s.balls is None else {"sides": sides_json(s.balls.load)}
    if answers is None:
        return data
    loads = roller_loads_json(s.loads) if s.balls is None else loads_json(s.balls.load)
    data |= {"loads": loads, **contacts_json(answers.loads, motion), "preload": as_json(answers.preload)}
    if not isinstance(answers.parts, Scene):
        return data
    data["clearance"] = as_json(clearance_of_deep_groove(answers.parts, s.of.thrust))
    data |= {} if answers.parts.track.lead else {"bearing_torque": as_json(answers.torque)}
    return data | {"starting_torque": starting_torque_json(s, answers)}


def axis_stiffness_json(result: AxisResult) -> dict[str, Any] | None:
    """Return the stiffness of a shaft with several nuts or bearings as JSON; None if it was not computed."""
    if result.stiffness is None:
        return None
    return {"at": result.stiffness_at, **(stiffness_json(result.station, result.status, result.stiffness) or {})}


def axis_summary_json(one: SolvedAxis) -> dict[str, Any]:
    """Return the JSON summary of several nuts or bearings on one shaft.

    ``one``: the solved shaft. The summary has the loads on each groove flank, the axial force, displacement and rigidities,
    and the results of the nut or bearing that has the worst contact.
    """
    result, answers = one.result, one.answers
    if not result.converged:
        return {}
    loads = [balls.load for balls in result.of_balls()]
    data: dict[str, Any] = {"sides": sides_json(np.concatenate(loads))} if loads else {}
    if answers is None:
        return data
    moved, tangent = answers.displacement, None if result.stiffness is None else result.stiffness[2, 2]
    secant = answers.force / moved if moved and answers.force else None
    data["axial"] = as_json(Axial(answers.force, moved, secant, tangent), "tangent_words", "stepped_N_per_um")
    data["stiffness"] = axis_stiffness_json(result)
    data["load_path"] = as_json(answers.path)
    data |= {"drive": as_json(one.drive), "axis_life": as_json(one.life)}
    if k := answers.worst_set:
        of_set = set_json(result.sets[k - 1], answers.sets[k - 1], one.scene.motion)
        data |= {"worst_set": k} | {k: of_set[k] for k in of_set if k not in OF_A_SET}
    return data


def case_json(one: Solved | SolvedAxis, tangent: Tangent | None = None) -> dict[str, Any]:
    """Return a solved scene as JSON: angles in deg, axial positions in mm, displacements in um, forces in N.

    With several nuts or bearings on one shaft, each row of a ball or roller has the number of its nut or bearing, and
    ``sets`` has a summary of each.

    Parameters
    ----------
    one
        The solution.
    tangent
        Stiffness at the axial position that the user asked for; None if no position was asked for.

    Returns
    -------
    dict
        JSON values.
    """
    result = one.result
    answers: dict[str, Any]
    if isinstance(one, SolvedAxis):
        of_sets = [None] * len(one.result.sets) if one.answers is None else one.answers.sets
        pairs = enumerate(zip(one.result.sets, of_sets, strict=True), 1)
        answers = {
            "kind": one.scene.kind,
            "sets": [{"set": k, **(as_json(s) or {}), "summary": set_json(s, x, one.scene.motion)} for k, (s, x) in pairs],
            "balls": ball_rows_of_axis(one.result),
            "rollers": roller_rows(one.result),
            "summary": axis_summary_json(one),
            "housings": [as_json(housing) for housing in one.result.housings],
            "stiffness": axis_stiffness_json(one.result),
        }
    else:
        summary = {"sides": sides_json(one.result.load), **answers_json(one)}
        if tangent is not None and one.answers is not None:
            summary["stiffness"] = stiffness_json(tangent.station, tangent.status, tangent.matrix)
        balls = ball_rows(one.scene, one.result)
        answers = {"balls": balls, "summary": summary if np.isfinite(one.result.load).all() else {}}
    grid = discretisation_percent(one.scene, one.result) if isinstance(one, Solved) else None
    line = zip(result.centreline_z, result.centreline, strict=True)
    return {
        "scene": one.scene.name,
        "model": result.model,
        "member": result.member if random_errors(one.scene) else None,
        "status": result.status,
        **answers,
        "centreline": [as_json(CentrelinePoint(z, motion)) for z, motion in line],
        "equilibrium": as_json(result.equilibrium),
        "solver": (as_json(result.solver) or {}) | {"discretisation_percent": grid},
        "model_form": as_json(one.expected),
        "assumed": list(result.assumed),
        "left_out": list(result.left_out),
        "warning": warning_line(result.warnings) or None,
        "warnings": list(result.warnings),
    }


def expected_json(m: ModelForm | None, key: str) -> dict[str, float | None]:
    """Return the expected errors [%] of displacement, rigidity and pressure by name; None if no error can be estimated.

    ``m``: the errors to expect. ``key``: template of the names, such as ``expected_{}_error_percent``.
    """
    errors = {
        name: None if m is None else getattr(m, f"{name}_percent") for name in ("displacement", "rigidity", "pressure")
    }
    return {key.format(name): None if value is None else number(value) for name, value in errors.items()}


def discretisation_percent(scene: Scene, result: StaticResult) -> float | None:
    """Return the error of the contact loads from the division of the beam into elements [% of the mean contact load].

    Returns None if this error was not estimated.
    """
    change = result.solver.discretisation
    if change is None:
        return None
    return number(float(error_percent(change, 0.0, mean_load(result.load, nominal_contacts(scene, result)))))


def ball_rows(scene: Scene, balls: StaticResult) -> list[dict[str, Any]]:
    """Return a JSON row for every ball: number from 1, position, loads, contact angles and pressures.

    ``scene``: the nut or bearing. ``balls``: its solution.
    """
    pressure = contact_pressures(scene, balls)
    rows = zip(balls.azimuth, balls.z, balls.load, balls.contact_angle, pressure, strict=True)
    return [as_json(BallRow(i, *row)) or {} for i, row in enumerate(rows, 1)]


def ball_rows_of_axis(result: AxisResult) -> list[dict[str, Any]]:
    """Return a JSON row for every ball of all nuts and bearings of a shaft, numbered from 1 in each of them."""
    rows = []
    for k, s in enumerate(result.sets, 1):
        if s.balls is not None and isinstance(s.of.parts, Scene):
            rows += [{"set": k} | row for row in ball_rows(s.of.parts, s.balls)]
    return rows


def roller_rows(result: AxisResult) -> list[dict[str, Any]]:
    """Return a JSON row for every roller of all roller bearings of a shaft, numbered from 1 in each bearing."""
    rows = []
    for k, s in enumerate(result.sets, 1):
        if not isinstance(s.of.parts, RollerRow) or s.roller_azimuth is None or s.line_loads is None:
            continue
        pressures = race_pressures(s.of.parts, s.line_loads)
        each = zip(s.roller_azimuth, s.loads, s.line_loads.max(axis=1), pressures, strict=True)
        for i, (azimuth, load, line_load, of_races) in enumerate(each, 1):
            row = RollerRowAnswer(i, azimuth, load, line_load, dict(zip(RACES, of_races, strict=True)))
            rows.append({"set": k} | (as_json(row) or {}))
    return rows


def cases_json(
    cycle: DutyCycle, solved: Sequence[Solved | SolvedAxis], whole: CycleResults, tangents: Sequence[Tangent | None] = ()
) -> dict[str, Any]:
    """Return a solved duty cycle as JSON: the results of each load case, and the extremes and lives over all cases.

    Parameters
    ----------
    cycle
        The duty cycle.
    solved
        Solutions of the load cases.
    whole
        Extremes and lives over all load cases.
    tangents
        For each load case, the stiffness at the axial position that the user asked for; empty if none was asked for.
    """
    each = zip(cycle.cases, solved, tangents or [None] * len(solved), strict=True)
    unsolved = "; ".join(f"case {name}: {status}" for name, status in whole.unsolved.items())
    return {
        "scene": cycle.name,
        "model": solved[0].result.model,
        "status": unsolved or "converged",
        "summary": together_json(whole),
        "cases": [
            {**load_case_keys(cycle, case), **case_json(one, tangent), "scene": cycle.name} for case, one, tangent in each
        ],
    }


def load_case_keys(cycle: DutyCycle, case: LoadCase) -> dict[str, Any]:
    """Return the first keys in the JSON of a load case: name of the scene, name and other data of the case."""
    return {"scene": cycle.name, **(as_json(case) or {})}


def together_json(whole: CycleResults) -> dict[str, Any]:
    """Return as JSON the extremes over all load cases and the lives over the duty cycle, or the reason for no life.

    ``whole``: extremes and lives over all load cases. With several nuts or bearings, ``sets`` has the lives of each.
    """
    several = len(whole.lives) != 1
    data = (as_json(whole, *([] if several else ["life_set", "axis_life"])) or {}) | _lives_json(whole.least, whole.speed)
    each = ({"name": lives.set} | _lives_json(lives, whole.speed) for lives in whole.lives)
    return data | {"sets": [*each]} if several else data


def _lives_json(lives: Lives, speed: float | None) -> dict[str, Any]:
    """Return as JSON the lives of one nut or bearing over a duty cycle, by the standards for which there is a life.

    ``speed``: mean speed [rad/s], for the life in hours; None if it is not known.
    """
    return {"life": life_json(lives.life, speed), **(as_json(lives) or {})}
