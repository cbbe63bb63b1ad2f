"""``rollbench solve``: one scene, one model; the answers first, tables and files where asked for."""

from __future__ import annotations

from typing import Any

from rollbench.comparison.commands.printing import Answer, text_width
from rollbench.comparison.commands.solving.load_curve import write_curve
from rollbench.comparison.commands.solving.matrix_files import check_matrix, write_matrix
from rollbench.comparison.commands.solving.solve_choices import Choices
from rollbench.comparison.commands.solving.solve_output import as_json as to_json
from rollbench.comparison.commands.solving.solve_output import as_table, number, stiffness_lines
from rollbench.comparison.commands.solving.summary import answers_json, block
from rollbench.comparison.errors import InputError, named, one_line
from rollbench.comparison.gate.loads_file import loads_csv, write_loads
from rollbench.comparison.models.answers import Answers, gather, tangent_of
from rollbench.comparison.models.model_form import estimate
from rollbench.comparison.models.outside import with_answers
from rollbench.comparison.models.registry import DEFAULT, Options, run_model
from rollbench.comparison.scenes import catalogue, units
from rollbench.comparison.scenes.scene_file import whole
from rollbench.comparison.watch import checked, watched
from rollbench.comparison.writing import need_writable
from rollbench.lowfi.statics.result import StaticResult
from rollbench.lowfi.statics.tangent import Tangent
from rollbench.lowfi.warned import above
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import FREEDOMS, Scene


def run_solve(name: str, choices: Choices) -> Answer:
    """Solve one scene; exit code 1 where it did not converge. Raises InputError."""
    model, station = _checked(choices)
    described = catalogue.any_scene(name)
    if isinstance(described, Assembly):
        return _run_axis(described, name, choices, station)
    scene = whole(described, name)
    if choices.stiffness_at and not 0.0 <= station <= scene.screw.length:
        allowed = f"0 mm to {1e3 * scene.screw.length:g} mm"
        raise InputError("command line", "--stiffness-at", choices.stiffness_at, allowed, "give a station of the screw")
    options = Options(choices.everything, choices.member, condensed=choices.condensed)
    found: Answers | None = None
    tangent: Tangent | None = None
    with watched(f"{scene.name}, model {one_line(model)}", checked(choices.time_limit)), named(scene.name, name):
        result = run_model(scene, model, options)
        if result.converged:
            found = gather(scene, result, model, options)
            result = with_answers(scene, result, found)
            if choices.stiffness_at:
                tangent = tangent_of(scene, station, model, options)
    worth = estimate(scene, result) if found is not None else None
    written = _write(scene, result, tangent, model, options, choices)
    answers = None if found is None else answers_json(scene, result, found)
    if answers is not None and tangent is not None:
        answers["stiffness"] = stiffness_json(tangent)
    speed = None if scene.motion is None else scene.motion.speed
    text = "" if found is None else block(scene, result, found, worth, text_width(), speed)
    parts = as_table(scene, result, worth, block=text, balls=choices.balls)
    parts += [*([] if tangent is None else stiffness_lines(tangent)), *written]
    code = 1 if not result.converged or (choices.strict and above(result.warnings)) else 0
    return Answer(to_json(scene, result, worth, answers), parts, code, folded=True)


def _run_axis(axis: Assembly, name: str, choices: Choices, station: float) -> Answer:
    """Solve several sets on one shaft."""
    from rollbench.comparison.commands.solving.axis_solve import solve_axis

    with watched(axis.name, checked(choices.time_limit)), named(axis.name, name):
        return solve_axis(axis, choices, station)


def _checked(choices: Choices) -> tuple[str, float]:
    """Model and station [m] of the choices. Raises InputError for what does not go together or cannot be written."""
    model = choices.model or (DEFAULT if choices.condensed is None else "condensed")
    if choices.condensed is not None and model != "condensed":
        advice = "leave --model out"
        raise InputError("command line", "--condensed", str(choices.condensed), "the model condensed", advice)
    if not 0 <= choices.member < 10**9:
        raise InputError("command line", "--member", str(choices.member), "0 to 999999999", "give the specimen's number")
    if choices.matrix is not None:
        if not choices.stiffness_at:
            raise InputError("command line", "--matrix", str(choices.matrix), "with --stiffness-at", "give a station")
        check_matrix(choices.matrix)
    if choices.curve is not None:
        if choices.curve.suffix.lower() != ".csv":
            raise InputError("command line", "--curve", str(choices.curve), "a name that ends in .csv", "rename it")
        need_writable(choices.curve)
    if choices.loads_csv is not None:
        need_writable(choices.loads_csv)
    if not choices.stiffness_at:
        return model, 0.0
    try:
        return model, units.parse(choices.stiffness_at, "length")
    except ValueError as error:
        allowed = "a length with its unit"
        raise InputError("command line", "--stiffness-at", choices.stiffness_at, allowed, f'"400 mm"; {error}') from None


def _write(
    scene: Scene, result: StaticResult, tangent: Tangent | None, model: str, options: Options, choices: Choices
) -> list[str]:
    """Files that were asked for; lines that say so."""
    lines = []
    if choices.matrix is not None and tangent is not None and tangent.status == "converged":
        write_matrix(choices.matrix, tangent, scene.name, model)
        lines.append(f"wrote {choices.matrix}: the matrix, symmetric, in N, m and rad")
    if choices.curve is not None and result.converged:
        lines += write_curve(choices.curve, scene, model, options)
    if choices.loads_csv is not None and result.converged:
        lines.append(write_loads(choices.loads_csv, loads_csv(result.load, result.azimuth, result.z)))
    return lines


def stiffness_json(tangent: Tangent) -> dict[str, Any]:
    """The matrix for JSON: N/m, N/rad, N m/rad."""
    return {
        "station_mm": number(1e3 * tangent.station),
        "status": tangent.status,
        "freedoms": list(FREEDOMS),
        "matrix": [[number(x) for x in row] for row in tangent.matrix],
    }
