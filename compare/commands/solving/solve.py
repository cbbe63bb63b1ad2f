"""``rollbench solve``: one scene, one model; the answers first, tables and files where asked for."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from rollbench.compare.api.calls import solve_described
from rollbench.compare.commands.printing import Answer
from rollbench.compare.commands.solving.output import case_table, stiffness_lines
from rollbench.compare.errors import ArgumentError, one_line
from rollbench.compare.models.load_cases import Solved, SolvedAxis
from rollbench.compare.models.registry import Options, default_model
from rollbench.compare.quantities import count_of
from rollbench.compare.scenes import catalogue
from rollbench.compare.scenes.scene_file import each_case
from rollbench.compare.watch import checked, watched
from rollbench.lowfi.statics.result import StaticResult
from rollbench.lowfi.statics.tangent import Tangent
from rollbench.lowfi.warned import above
from rollbench.meshes import units
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Scene


@dataclass(frozen=True)
class Choices:
    """What the command line says: model, whether to leave nothing out, specimen, condensed bodies, whether to print the
    table of balls, station of the stiffness and its file, files of the load curve and of the contact loads, seconds after
    which to give up, whether a warning above the answers makes the exit code 1, whether to print what lies behind them."""

    model: str = ""
    everything: bool = False
    member: int = 0
    condensed: Path | None = None
    balls: bool = False
    stiffness_at: str = ""
    matrix: Path | None = None
    curve: Path | None = None
    loads_csv: Path | None = None
    time_limit: float | None = None
    strict: bool = False
    assumptions: bool = False


def run_solve(name: str, choices: Choices) -> Answer:
    """Solve one scene, or its load cases one after the other, of one set or several; exit code 1 where one did not
    converge. Raises InputError."""
    described = catalogue.any_scene(name)
    scenes: Sequence[Scene | Assembly] = each_case(described, name)
    model, station = _checked(choices)
    model = model or default_model(scenes[0])
    _check_parts(scenes[0], choices, station)
    options = Options(choices.everything, choices.member, condensed=choices.condensed)
    at = station if choices.stiffness_at else None
    with watched(f"{described.name}, model {one_line(model)}", checked(choices.time_limit)):
        found = solve_described(described, model, options, at, name)
    solved, names = found.solved, [*found.cases]
    of_cases = [_of_case(choices, case) for case in names] or [choices]
    written: list[str] = []
    for one, tangent, files in zip(solved, found.tangents, of_cases, strict=True):
        written += _write(one, tangent, options, files)
    if choices.loads_csv is not None:
        written += _write_loads(choices.loads_csv, solved, names)
    shown = {"balls": choices.balls, "details": choices.assumptions}
    if found.cycle is None or found.together is None:
        tangent = found.tangents[0]
        lines = [*case_table(solved[0], **shown), *([] if tangent is None else stiffness_lines(tangent))]
    else:
        from rollbench.compare.commands.solving.cases_output import cases_table

        lines = cases_table(found.cycle, solved, found.together, found.tangents, **shown)
    return Answer(found.to_dict, [*lines, *written], code_of(solved, choices), folded=True)


def _of_case(choices: Choices, name: str) -> Choices:
    """Files of one load case: its name stands in theirs."""

    def named(path: Path | None) -> Path | None:
        return None if path is None else path.with_stem(f"{path.stem}-{name}")

    return replace(choices, matrix=named(choices.matrix), curve=named(choices.curve))


def _write_loads(path: Path, solved: Sequence[Solved | SolvedAxis], names: Sequence[str]) -> list[str]:
    """Write all contacts of what converged, of load cases with their name, of several sets with their number; lines that
    say so."""
    from rollbench.compare.gate.loads_file import loads_csv
    from rollbench.compare.writing import write_csv

    rows = []
    for one, name in zip(solved, names or [""], strict=True):
        head = {"case": name} if name else {}
        sets: list[tuple[dict[str, str], StaticResult]]
        if isinstance(one, Solved):
            sets = [({}, one.result)]
        else:
            sets = [({"set": str(k)}, s.balls) for k, s in enumerate(one.result.sets, 1) if s.balls is not None]
        for of_set, balls in sets if one.result.converged else ():
            rows += [head | of_set | row for row in loads_csv(balls.load, balls.azimuth, balls.z)]
    if not rows:
        return []
    write_csv(path, rows)
    return [
        f"wrote {path}: {count_of(len(rows), 'contact load')}, for: rollbench check SCENE --loads {shlex.quote(str(path))}"
    ]


def _check_parts(scene: Scene | Assembly, choices: Choices, station: float) -> None:
    """Raises InputError for a station beyond the screw or shaft, and for what several sets do not have."""
    if isinstance(scene, Assembly):
        refused = (
            ("everything", choices.everything, "every set is built as its scene asks: leave it out"),
            ("condensed", choices.condensed, "a file of condensed bodies holds those of one set: leave it out"),
        )
        for argument, value, advice in refused:
            if value:
                raise ArgumentError(argument, f"with {scene.name}", "one set on a shaft", advice)
        if choices.loads_csv is not None and not scene.ball_count:
            advice = "rollers have no flanks: leave it out"
            raise ArgumentError("loads_csv", str(choices.loads_csv), "a set of balls", advice)
    if choices.stiffness_at and not 0.0 <= station <= scene.screw.length:
        allowed = f"0 mm to {1e3 * scene.screw.length:g} mm"
        what = "shaft" if isinstance(scene, Assembly) else "screw"
        raise ArgumentError("stiffness_at", choices.stiffness_at, allowed, f"give a station of the {what}")


def code_of(solved: Sequence[Solved | SolvedAxis], choices: Choices) -> int:
    """Exit code: 1 where one did not converge, or where a warning above the answers counts as a failure."""
    return int(any(one.answers is None or (choices.strict and above(one.result.warnings)) for one in solved))


def _checked(choices: Choices) -> tuple[str, float]:
    """Model (empty: not asked for) and station [m] of the choices. Raises InputError for what does not go together or
    cannot be written."""
    model = choices.model or ("" if choices.condensed is None else "condensed")
    if choices.condensed is not None and model != "condensed":
        advice = "leave `model` out"
        raise ArgumentError("condensed", str(choices.condensed), "the model condensed", advice)
    if not 0 <= choices.member < 10**9:
        raise ArgumentError("member", str(choices.member), "0 to 999999999", "give the specimen's number")
    if choices.matrix is not None:
        if not choices.stiffness_at:
            raise ArgumentError("matrix", str(choices.matrix), "with `stiffness_at`", "give a station")
        from rollbench.compare.commands.solving.files import check_matrix

        check_matrix(choices.matrix)
    if choices.curve is not None and choices.curve.suffix.lower() != ".csv":
        raise ArgumentError("curve", str(choices.curve), "a name that ends in .csv", "rename it")
    for path in filter(None, (choices.curve, choices.loads_csv)):
        from rollbench.compare.writing import need_writable

        need_writable(path)
    if not choices.stiffness_at:
        return model, 0.0
    try:
        return model, units.parse(choices.stiffness_at, "length")
    except ValueError as error:
        allowed = "a length with its unit"
        raise ArgumentError("stiffness_at", choices.stiffness_at, allowed, f'"400 mm"; {error}') from None


def _write(one: Solved | SolvedAxis, tangent: Tangent | None, options: Options, choices: Choices) -> list[str]:
    """Files that were asked for, but of loads; lines that say so. Raises InputError."""
    if not one.result.converged:
        return []
    lines, path, (K, where) = [], choices.matrix, _stiffness(one, tangent)
    if path is not None and isinstance(one, SolvedAxis) and (K is None or not np.isfinite(K).all()):
        advice = "ask for a station where no freedom of the shaft is held"
        raise ArgumentError("matrix", str(path), "a stiffness in all six freedoms", advice)
    if path is not None and K is not None:
        from rollbench.compare.commands.solving.files import write_stiffness

        write_stiffness(path, K, f"tangent stiffness of {one.scene.name}, model {one.result.model}, {where}")
        lines.append(f"wrote {path}: the matrix, symmetric, in N, m and rad")
    if choices.curve is not None:
        from rollbench.compare.commands.solving.files import write_curve

        lines += write_curve(choices.curve, one.scene, one.result.model, options)
    return lines


def _stiffness(one: Solved | SolvedAxis, tangent: Tangent | None) -> tuple[Array | None, str]:
    """The stiffness (6, 6) [N, m, rad] that was asked for, None where there is none, and words for where it is taken."""
    if isinstance(one, SolvedAxis):
        return one.result.stiffness, f"{one.result.stiffness_at} against all that the scene holds"
    if tangent is None or tangent.status != "converged":
        return None, ""
    return tangent.matrix, f"screw's section at {1e3 * tangent.station:.6g} mm against the held nut"
