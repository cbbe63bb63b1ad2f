"""``rollbench solve``: one scene, one model; the answers first, tables and files where asked for."""

from __future__ import annotations

from collections.abc import Sequence

from rollbench.comparison.commands.printing import Answer
from rollbench.comparison.commands.solving.cases_output import case_json, case_table, cases_json, cases_table
from rollbench.comparison.commands.solving.solve_choices import Choices
from rollbench.comparison.commands.solving.solve_output import stiffness_lines
from rollbench.comparison.errors import InputError, named, one_line
from rollbench.comparison.models.answers import tangent_of
from rollbench.comparison.models.load_cases import Solved, solve_one, together
from rollbench.comparison.models.registry import DEFAULT, Options
from rollbench.comparison.scenes import catalogue, units
from rollbench.comparison.scenes.load_cases import DutyCycle
from rollbench.comparison.scenes.scene_file import whole
from rollbench.comparison.watch import checked, watched
from rollbench.comparison.writing import need_writable
from rollbench.lowfi.statics.tangent import Tangent
from rollbench.lowfi.warned import above
from rollbench.meshes.axis import Assembly


def run_solve(name: str, choices: Choices) -> Answer:
    """Solve one scene; exit code 1 where it did not converge. Raises InputError."""
    model, station = _checked(choices)
    described = catalogue.any_scene(name)
    if isinstance(described, Assembly):
        return _run_axis(described, name, choices, station)
    if isinstance(described, DutyCycle):
        return _run_cases(described, name, model, choices)
    scene = whole(described, name)
    if choices.stiffness_at and not 0.0 <= station <= scene.screw.length:
        allowed = f"0 mm to {1e3 * scene.screw.length:g} mm"
        raise InputError("command line", "--stiffness-at", choices.stiffness_at, allowed, "give a station of the screw")
    options = Options(choices.everything, choices.member, condensed=choices.condensed)
    with watched(f"{scene.name}, model {one_line(model)}", checked(choices.time_limit)), named(scene.name, name):
        one = solve_one(scene, model, options)
        asked_for = one.answers is not None and choices.stiffness_at
        tangent = tangent_of(scene, station, model, options) if asked_for else None
    written = _write(one, tangent, model, options, choices)
    parts = [
        *case_table(one, balls=choices.balls, details=choices.assumptions),
        *([] if tangent is None else stiffness_lines(tangent)),
        *written,
    ]
    return Answer(case_json(one, tangent), parts, code_of([one], choices), folded=True)


def _run_cases(cycle: DutyCycle, name: str, model: str, choices: Choices) -> Answer:
    """Solve the load cases of a scene one after the other."""
    for option, value in (("--stiffness-at", choices.stiffness_at), ("--curve", choices.curve)):
        if value:
            advice = "it is of one load case: leave it out, or the other cases"
            with_them = f"with {len(cycle.cases)} cases"
            raise InputError("command line", option, with_them, "a scene without [[cases]]", advice)
    options = Options(choices.everything, choices.member, condensed=choices.condensed)
    solved = []
    with watched(f"{cycle.name}, model {one_line(model)}", checked(choices.time_limit)):
        for case in cycle.cases:
            with named(case.scene.name, name):
                solved.append(solve_one(case.scene, model, options))
    whole = together(cycle, solved)
    parts = cases_table(cycle, solved, whole, balls=choices.balls, details=choices.assumptions)
    if choices.loads_csv is not None:
        from rollbench.comparison.gate.loads_file import loads_csv, write_loads

        rows = [
            {"case": case.name, **row}
            for case, one in zip(cycle.cases, solved, strict=True)
            if one.answers is not None
            for row in loads_csv(one.result.load, one.result.azimuth, one.result.z)
        ]
        parts += [write_loads(choices.loads_csv, rows)] if rows else []
    return Answer(cases_json(cycle, solved, whole), parts, code_of(solved, choices), folded=True)


def code_of(solved: Sequence[Solved], choices: Choices) -> int:
    """Exit code: 1 where one did not converge, or warns above its answers and that counts."""
    return int(any(one.answers is None or (choices.strict and above(one.result.warnings)) for one in solved))


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
        from rollbench.comparison.commands.solving.matrix_files import check_matrix

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


def _write(one: Solved, tangent: Tangent | None, model: str, options: Options, choices: Choices) -> list[str]:
    """Files that were asked for; lines that say so."""
    scene, result, lines = one.scene, one.result, []
    if choices.matrix is not None and tangent is not None and tangent.status == "converged":
        from rollbench.comparison.commands.solving.matrix_files import write_matrix

        write_matrix(choices.matrix, tangent, scene.name, model)
        lines.append(f"wrote {choices.matrix}: the matrix, symmetric, in N, m and rad")
    if choices.curve is not None and result.converged:
        from rollbench.comparison.commands.solving.load_curve import write_curve

        lines += write_curve(choices.curve, scene, model, options)
    if choices.loads_csv is not None and result.converged:
        from rollbench.comparison.gate.loads_file import loads_csv, write_loads

        lines.append(write_loads(choices.loads_csv, loads_csv(result.load, result.azimuth, result.z)))
    return lines
