"""JSON of a solved scene, of one set or several, and of the load cases of a duty cycle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from rollbench.compare.measure import error_percent
from rollbench.compare.models.answers import LoadAnswers, RollerAnswers, clearance_of_deep_groove
from rollbench.compare.models.load_cases import CycleResults, Lives, Solved, SolvedAxis
from rollbench.compare.models.model_form import ModelForm
from rollbench.compare.models.registry import random_errors
from rollbench.compare.quantities import as_json, number
from rollbench.compare.scenes.duty_cycle import DutyCycle, LoadCase
from rollbench.lowfi.rating.contacts import RACES, race_pressures
from rollbench.lowfi.rating.life import Life
from rollbench.lowfi.statics.contacts import own_hertz
from rollbench.lowfi.statics.nominal import nominal_contacts
from rollbench.lowfi.statics.result import AxisResult, SetResult, StaticResult
from rollbench.lowfi.statics.tangent import Tangent
from rollbench.lowfi.warned import warning_line
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import RollerRow
from rollbench.meshes.errors import specimen
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.loads import count_contacts, mean_load
from rollbench.meshes.parts import FREEDOMS, SIDES, Motion, Scene
from rollbench.meshes.quantity import Stated, quantity, record

if TYPE_CHECKING:
    from rollbench.compare.models.answers import SetAnswers
    from rollbench.lowfi.bearings.torque import LoadTorque

#: Keys of a set's summary that are not repeated in the summary of the whole shaft.
OF_A_SET = ("sides", "preload", "starting_torque", "bearing_torque", "clearance", "roller_torque")
#: Friction force [N] for whose reversal lost motion is given.
LOST_BY = 100.0


def per_side(row: Array) -> dict[str, float | None]:
    """Return four values by the names of the flanks."""
    return {side: number(value) for side, value in zip(SIDES, row, strict=True)}


@record
class BallRow:
    """One ball: position, and load, contact angle and pressure on its four flanks (4,), in SI."""

    index: int = quantity("index", "number of the ball along its track, from 1")
    azimuth: float = quantity("azimuth_deg", "nominal azimuth of the ball, from x to y; it goes on over turns")
    z: float = quantity("z_mm", "nominal station of the ball's centre along the screw")
    load: Array = quantity(
        "load_N",
        "contact load of this ball on this flank; 0 where it does not touch",
        error="model form: `model_form`; measured: `compare`",
        parts=".FLANK",
        show=per_side,
    )
    angle: Array = quantity(
        "contact_angle_deg",
        "angle of the contact normal to the radius, in the plane of axis and radius, at the solved place of the ball; null "
        "without load",
        error="of the order of the approach over the groove's excess radius",
        parts=".FLANK",
        show=per_side,
    )
    pressure: Array = quantity(
        "pressure_MPa",
        "largest pressure of this contact, by Hertz from the load and the radii with their errors, or as the model gives "
        "it; 0 where it does not touch",
        error="a third of that of the load",
        parts=".FLANK",
        show=per_side,
    )


@record
class RollerRowAnswer:
    """One roller of a row: azimuth [rad], load [N], largest load per length [N/m], largest pressure [Pa] by race."""

    index: int = quantity("index", "number of the roller in its row, from 1")
    azimuth: float = quantity("azimuth_deg", "azimuth of the roller, from x to y")
    load: float = quantity("load_N", "load of the roller on either race", error="not compared with a 3D model")
    line_load: float = quantity(
        "largest_line_load_N_mm",
        "largest load per length along the roller, of equal slices",
        error="of the slices' model: without what the ends of straight rollers add",
    )
    pressure: dict[str, float] = quantity(
        "pressure_MPa",
        "largest pressure along the roller on inner and outer race, sqrt(q E*/(pi R)) of line load q and relative radius R "
        "at each slice",
        error="half that of the line load",
        parts=".*",
    )


@record
class LoadSums:
    """Summary of contact loads: most loaded ball and flank, mean and extremes [N], numbers of contacts."""

    ball: int = quantity("worst_ball", "ball of the largest contact load")
    side: str = quantity("worst_side", "its flank")
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
        "mean contact load: the sum of the loads over the number of contacts that the screw without geometric errors loads",
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
    loaded: int = quantity("loaded_contacts", "contacts with load")
    in_mean: int = quantity("contacts_in_mean", "contacts over which the mean is taken")
    unloaded: int = quantity("balls_without_load", "balls without any load", heading="balls without load")


@record
class RollerSums:
    """Summary of the loads of a row of rollers: most loaded roller, mean and extremes [N], numbers of rollers."""

    roller: int = quantity(
        "worst_roller",
        "roller of the largest load; of a row of rollers the numbers of this table are those of rollers, each with one "
        "load on both races",
    )
    largest: float = quantity("max_N", heading="largest roller load", note="roller {worst_roller}")
    mean: float = quantity("mean_N", heading="mean roller load")
    least: float = quantity("min_N", heading="smallest roller load", note="of {loaded_contacts} loaded")
    loaded: int = quantity("loaded_contacts")
    unloaded: int = quantity("rollers_without_load", "rollers without any load", heading="rollers without load")


@record
class SideSums:
    """Summary of the contact loads on one flank: extremes [N], ratio, numbers of contacts."""

    largest: float = quantity("max_N", "largest load on this flank", error="as `loads.max_N`")
    least: float = quantity("min_N", "smallest load of a loaded contact on this flank", error="as `loads.min_N`")
    ratio: float = quantity(
        "ratio", "largest over smallest load on this flank", error="both loads' errors, opposite in sign at worst"
    )
    loaded: int = quantity("loaded", "loaded contacts on this flank")
    lost: int = quantity("lost", "contacts of a loaded flank that carry nothing")


@record
class Axial:
    """Axial force [N], displacement [m], rigidities [N/m], and why there is no tangent stiffness."""

    force: float = quantity(
        "force_N",
        "axial force on the screw, as loads and reactions give it; positive towards larger z",
        heading="axial force",
    )
    displacement: float | None = quantity(
        "displacement_um",
        "axial displacement of the screw at the nut's centre (at the loaded section of an axis) against the same scene "
        "without its loads",
        error="`model_form.displacement_percent`",
        heading="axial displacement",
        expected=("displacement_percent", 1.0),
    )
    rigidity: float | None = quantity(
        "rigidity_N_per_um",
        "secant: axial force over axial displacement",
        error="that of the displacement",
        heading="axial rigidity, secant",
        expected=("displacement_percent", 1.0),
    )
    tangent: float | None = quantity(
        "tangent_N_per_um",
        "tangent: change of axial force over change of displacement at the solution, other freedoms free",
        error="`model_form.rigidity_percent`",
        heading="axial rigidity, tangent",
        expected=("rigidity_percent", 1.0),
        default=None,
    )
    words: str = quantity("tangent_words", "why there is no tangent", show=lambda words: words or None, default="")
    stepped: float | None = quantity(
        "stepped_N_per_um",
        "stiffness of the model liu over ingredients.load_step, at the first loaded ball (Liu's 19 to 22)",
        error="the model is not covered by comparisons",
        heading="rigidity over the load step",
        default=None,
    )

    @property
    @Stated(
        "lost_motion_um_per_100N",
        "axial displacement when 100 N change sign, 2 x 100 N over the tangent at rest",
        heading="lost motion, um by 100 N",
    )
    def lost_motion(self) -> float | None:
        """Axial displacement [um] when a friction force of 100 N reverses; None without tangent."""
        return None if self.tangent is None or self.tangent <= 0.0 else 1e6 * (2.0 * LOST_BY / self.tangent)


@record
class StiffnessAt:
    """Stiffness (6, 6) [N/m, N/rad, N m/rad] at a station [m]; nan where a freedom is fixed."""

    station: float | None = quantity("station_mm", "station at which the 6 x 6 stiffness is taken")
    status: str = quantity("status")
    freedoms: tuple[str, ...] = quantity("freedoms")
    matrix: Array = quantity(
        "matrix",
        "row by row: change of force [N] and moment [N m] for a unit displacement [m] or rotation [rad] at the station, "
        "against the held nut; null for a freedom that a support holds",
        error="`model_form.rigidity_percent`, on its axial term",
        parts="[][]",
    )


@record
class CentrelinePoint:
    """Station [m] of the screw's axis, and its displacement (6,)."""

    z: float = quantity("z_mm", "station of the screw's axis")
    motion: Array = quantity(
        "ux_um",
        "displacement of the axis there, along x",
        Stated("uy_um", "along y", show=lambda motion: motion[1]),
        Stated("uz_um", "along z", show=lambda motion: motion[2]),
        show=lambda motion: motion[0],
    )


def sides_json(load: Array) -> dict[str, Any]:
    """Return, by loaded flank, largest and smallest load [N], their ratio, numbers of loaded and unloaded balls."""
    out = {}
    for side, values in zip(SIDES, load.T, strict=True):
        loaded = values[values > 0.0]
        if loaded.size:
            most, least = loaded.max(), loaded.min()
            out[side] = as_json(SideSums(most, least, most / least, int(loaded.size), int(values.size - loaded.size)))
    return out


def loads_json(load: Array, contacts: int = 0) -> dict[str, Any] | None:
    """Return the summary of contact loads (n, 4) [N] as JSON (`LoadSums`); None without load.

    ``contacts``: number in the mean load, see `meshes.loads.mean_load`.
    """
    loaded = load > 0.0
    if not loaded.any():
        return None
    carried, mean = load[loaded], mean_load(load, contacts)
    i, s = np.unravel_index(int(load.argmax()), load.shape)
    empty = int((~loaded.any(axis=1)).sum())
    ends = carried.max(), mean, carried.min()
    return as_json(LoadSums(int(i) + 1, SIDES[int(s)], *ends, int(carried.size), count_contacts(load, contacts), empty))


def roller_loads(load: Array) -> dict[str, Any] | None:
    """Return the summary of a row's roller loads (count,) [N] as JSON (`RollerSums`); None without load."""
    carried = load[load > 0.0]
    if not carried.size:
        return None
    ends = carried.max(), carried.mean(), carried.min()
    return as_json(RollerSums(int(load.argmax()) + 1, *ends, int(carried.size), int(load.size - carried.size)))


def stiffness_json(station: float | None, status: str, matrix: Array) -> dict[str, Any] | None:
    """Return a stiffness (6, 6) [N/m, N/rad, N m/rad] at a station [m] as JSON; null where a freedom is fixed."""
    return as_json(StiffnessAt(station, str(status), FREEDOMS, matrix))


def life_json(life: Life | None, speed: float | None) -> dict[str, Any] | None:
    """Return a life as JSON, also in hours if a speed [rad/s] is known; None without life."""
    data = as_json(life)
    return data | {"L10_hours": number(life.hours(speed))} if data is not None and life and speed else data


def contacts_json(answers: LoadAnswers | RollerAnswers, motion: Motion | None = None) -> dict[str, Any]:
    """Return the JSON of worst contact, truncation (balls), static safety, life and ratings; null if missing."""
    if isinstance(answers, RollerAnswers):
        safety = as_json(answers.safety, "permanent_over_diameter", "allowed_over_diameter")
        data = (as_json(answers) or {}) | {"static_safety": safety, "rating_refused": None}
    else:
        data = as_json(answers) or {}
    return data | {"life": life_json(answers.life, None if motion is None else motion.speed)}


def answers_json(one: Solved) -> dict[str, Any]:
    """Return all answers of one set: forces in N, displacements in um, rigidities in N/um; empty without equilibrium."""
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
    """Return the load-dependent friction torque of a bearing under a thrust [N] by Palmgren (Smith 2.33 to 2.38).

    The formula is for contact angles of about 60 deg.
    """
    from rollbench.lowfi.bearings.torque import load_torque, static_rating
    from rollbench.lowfi.statics.contacts import nominal_curvatures

    ball, track = 2.0 * parts.balls.radius, parts.track
    across, along = nominal_curvatures(parts)[0]
    rated = static_rating(1, parts.ball_count, ball, track.contact_angle, float(across), float(along))
    return load_torque(abs(thrust), 0.0, 2.0 * track.pitch_radius, rated)


def starting_torque(s: SetResult, answers: SetAnswers) -> dict[str, Any] | None:
    """Return the starting torque of a preloaded ball bearing that carries thrust one way; None for others."""
    parts, preload = answers.parts, answers.preload
    one_way = s.of.kind == "bearing" and s.of.thrust in ("+z", "-z")
    if not isinstance(parts, Scene) or not one_way or not (preload and preload.axial):
        return None
    return as_json(torque_by_palmgren(parts, preload.axial))


def set_json(s: SetResult, answers: SetAnswers | None, motion: Motion | None) -> dict[str, Any]:
    """Return the JSON summary of one of several sets, of balls or rollers; empty without equilibrium."""
    if not np.isfinite(s.loads).all():
        return {}
    data: dict[str, Any] = {} if s.balls is None else {"sides": sides_json(s.balls.load)}
    if answers is None:
        return data
    loads = roller_loads(s.loads) if s.balls is None else loads_json(s.balls.load)
    data |= {"loads": loads, **contacts_json(answers.loads, motion), "preload": as_json(answers.preload)}
    if not isinstance(answers.parts, Scene):
        return data
    data["clearance"] = as_json(clearance_of_deep_groove(answers.parts, s.of.thrust))
    data |= {} if answers.parts.track.lead else {"bearing_torque": as_json(answers.torque)}
    return data | {"starting_torque": starting_torque(s, answers)}


def whole_stiffness(result: AxisResult) -> dict[str, Any] | None:
    """Return the stiffness of a shaft with several sets as JSON, with the keys used for one set; None without."""
    if result.stiffness is None:
        return None
    return {"at": result.stiffness_at, **(stiffness_json(result.station, result.status, result.stiffness) or {})}


def whole_json(one: SolvedAxis) -> dict[str, Any]:
    """Return the JSON summary of several sets: flanks, axial answers, values of the set with the worst contact."""
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
    data["stiffness"] = whole_stiffness(result)
    data["load_path"] = as_json(answers.path)
    data |= {"drive": as_json(one.drive), "axis_life": as_json(one.life)}
    if k := answers.worst_set:
        of_set = set_json(result.sets[k - 1], answers.sets[k - 1], one.scene.motion)
        data |= {"worst_set": k} | {k: of_set[k] for k in of_set if k not in OF_A_SET}
    return data


def case_json(one: Solved | SolvedAxis, tangent: Tangent | None = None) -> dict[str, Any]:
    """Return a solved scene as JSON: angles in deg, stations in mm, displacements in um, forces in N.

    With several sets, each row of a ball or roller names its set, and the summary of each set is in ``sets``.

    Parameters
    ----------
    one
        The solution.
    tangent
        Stiffness at a station, if it was asked for.

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
            "balls": set_balls(one.result),
            "rollers": roller_rows(one.result),
            "summary": whole_json(one),
            "housings": [as_json(housing) for housing in one.result.housings],
            "stiffness": whole_stiffness(one.result),
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
    """Return expected errors [%] of displacement, rigidity, pressure by the template ``key``; None: not covered."""
    errors = {
        name: None if m is None else getattr(m, f"{name}_percent") for name in ("displacement", "rigidity", "pressure")
    }
    return {key.format(name): None if value is None else number(value) for name, value in errors.items()}


def discretisation_percent(scene: Scene, result: StaticResult) -> float | None:
    """Return the discretisation error of the beam [% of the mean contact load], if it was estimated."""
    change = result.solver.discretisation
    if change is None:
        return None
    return number(float(error_percent(change, 0.0, mean_load(result.load, nominal_contacts(scene, result)))))


def pole_pressure(scene: Scene, found: StaticResult) -> Array:
    """Return the largest pressure of every contact, (n, 4) [Pa]: the model's, else by Hertz with the radii's errors.

    nan without equilibrium.
    """
    if found.pressure is not None or not np.isfinite(found.load).all():
        return found.load if found.pressure is None else found.pressure
    return own_hertz(scene, specimen(scene, ball_layout(scene), found.member)).pressure(found.load)


def ball_rows(scene: Scene, balls: StaticResult) -> list[dict[str, Any]]:
    """Return position, loads, contact angles and pressures of every ball, numbered from 1."""
    pressure = pole_pressure(scene, balls)
    rows = zip(balls.azimuth, balls.z, balls.load, balls.contact_angle, pressure, strict=True)
    return [as_json(BallRow(i, *row)) or {} for i, row in enumerate(rows, 1)]


def set_balls(result: AxisResult) -> list[dict[str, Any]]:
    """Return the JSON rows of the balls of all sets, numbered from 1 in each set."""
    rows = []
    for k, s in enumerate(result.sets, 1):
        if s.balls is not None and isinstance(s.of.parts, Scene):
            rows += [{"set": k} | row for row in ball_rows(s.of.parts, s.balls)]
    return rows


def roller_rows(result: AxisResult) -> list[dict[str, Any]]:
    """Return the JSON rows of the rollers of all sets, numbered from 1 in each set."""
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
    """Return the JSON of a solved duty cycle: each load case in order, and extremes and lives over all.

    Parameters
    ----------
    cycle
        The duty cycle.
    solved
        Solutions of the load cases.
    whole
        Extremes and lives over the load cases.
    tangents
        Stiffness of each load case at a station, where asked for.
    """
    each = zip(cycle.cases, solved, tangents or [None] * len(solved), strict=True)
    unsolved = "; ".join(f"case {name}: {status}" for name, status in whole.unsolved.items())
    return {
        "scene": cycle.name,
        "model": solved[0].result.model,
        "status": unsolved or "converged",
        "summary": together_json(whole),
        "cases": [
            {**json_head(cycle, case), **case_json(one, tangent), "scene": cycle.name} for case, one, tangent in each
        ],
    }


def json_head(cycle: DutyCycle, case: LoadCase) -> dict[str, Any]:
    """Return the keys with which the JSON of every load case begins: scene, and data of the case."""
    return {"scene": cycle.name, **(as_json(case) or {})}


def together_json(whole: CycleResults) -> dict[str, Any]:
    """Return the JSON of extremes over the load cases and of lives over the cycle, or why there is no life."""
    several = len(whole.lives) != 1
    data = (as_json(whole, *([] if several else ["life_set", "axis_life"])) or {}) | _lives_json(whole.least, whole.speed)
    each = ({"name": lives.set} | _lives_json(lives, whole.speed) for lives in whole.lives)
    return data | {"sets": [*each]} if several else data


def _lives_json(lives: Lives, speed: float | None) -> dict[str, Any]:
    """Return the JSON of one set's lives over a duty cycle."""
    return {"life": life_json(lives.life, speed), **(as_json(lives) or {})}
