"""Command ``rollbench solve``: solves one scene, several side by side, a range of loads, or many specimens.

It can also write the stiffness matrix for other programs, and the load curve.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from rollbench.compare.commands.terminal import (
    Flag,
    Json,
    ProgramOptions,
    Verbose,
    Word,
    app,
    check_plot_file,
    join_paragraph_lines,
    model_or_program_name,
    refuse_given_arguments,
    write_plot,
)
from rollbench.compare.errors import ArgumentError, one_line
from rollbench.compare.running import show_progress_message
from rollbench.compare.text.printing import CommandOutput, TextTable, print_command_output

if TYPE_CHECKING:
    from rollbench.compare.results.data import Ensemble, Statistics
    from rollbench.compare.results.load_curve import LoadCurve
    from rollbench.compare.results.solved import Result
    from rollbench.meshes.arrays import Array
    from rollbench.meshes.axis import Assembly
    from rollbench.meshes.parts import Scene


@Parameter(name="*")
@dataclass(frozen=True)
class SolveOptions:
    """Command-line options of ``rollbench solve``.

    Attributes
    ----------
    model
        Low-order model (rollbench list shows all). Default: refined, or condensed if --condensed is given.
    everything
        Also model flanks that no ball can touch and shaft ends that carry no load, which do not change the contact loads.
    member
        Number of the specimen, from 0, in a scene with random errors.
    condensed
        File that rollbench condense wrote for these parts: the compliance of screw and nut from their 3D meshes, for the
        model "condensed".
    balls
        Also print the table of all balls.
    stiffness_at
        Also print the 6 x 6 tangent stiffness at this axial position of the screw, such as "400 mm", with the nut fixed.
    matrix
        File for the stiffness matrix of --stiffness-at: .mtx (Matrix Market) or .dmig (Nastran).
    curve
        Print the displacement over a range of loads (the load curve), the backlash and the stiffness outside the backlash.
        Forces such as "-3000N:3000N" replace the scene's loads; they act along the axis where the scene's own load acts
        (without one: at the nut's centre, or where the stiffness of an axis is reported). Append ":41" for 41 points
        (default 21); ":x", ":y" or an angle such as ":45deg" for a transverse force; ":300mm" or the name of a housing for
        another position. A range without unit, such as "0:1.5", scales all loads of the scene.
    loads_csv
        File for all contact loads, with the columns that check --loads reads: ball, flank, newton, azimuth_deg, z_mm, and
        case if the scene has load cases.
    plot
        File for a figure, SVG: loads of all balls on each loaded flank; of several scenes, the differences from the first.
    members
        Number of specimens to solve. Prints the distributions of the largest load, the stiffness, the number of unloaded
        contacts and the life; with --balls also the range of the load of every ball.
    csv
        With --members: file with one row per specimen. With --curve: file with one row per load, and a figure of the same
        name.
    seed
        With --members: seed of the random errors, which replaces that of the scene.
    workers
        With --members: number of parallel processes.
    store
        With --members, --curve, several scenes or several load cases: folder in which what is solved is stored at once, so
        that an interrupted command resumes.
    time_limit
        Stop after this many seconds, with exit code 1. Default: no limit.
    strict
        Return exit code 1 if a WARNING is printed: the result is outside the models' range of validity (such as contacts
        beyond the groove's arc, pressure, preload, static safety or rotations), the conformity looks wrong, or the supports
        carry nearly all of a load, so that little of it reaches the contacts.
    verbose
        Also print further quantities, the assumptions, neglected effects, the force balance and data of the solver.
    """

    model: Word = ""
    everything: Annotated[Flag, Parameter(name="--all")] = False
    member: int = 0
    condensed: Path | None = None
    balls: Flag = False
    stiffness_at: Word = ""
    matrix: Path | None = None
    curve: Annotated[Word, Parameter(allow_leading_hyphen=True)] = ""
    loads_csv: Path | None = None
    plot: Path | None = None
    members: int | None = None
    csv: Path | None = None
    seed: int | None = None
    workers: int | None = None
    store: Path | None = None
    time_limit: float | None = None
    strict: Flag = False
    verbose: Verbose = False


SolveOptions.__doc__ = join_paragraph_lines(SolveOptions.__doc__)
#: Options that are refused if several scenes are solved side by side.
OF_ONE_SCENE = (
    "matrix",
    "loads_csv",
    "csv",
    "condensed",
    "members",
    "seed",
    "workers",
    "curve",
    "balls",
    "everything",
    "verbose",
)


def solve_and_report(name: str, solve_options: SolveOptions) -> CommandOutput:
    """Solve one scene with all its load cases, and return what is printed; exit code 1 if a load case did not converge.

    Raises InputError if the scene or an option cannot be used.
    """
    from rollbench.compare.api.calls import solve_scene_record
    from rollbench.compare.files import written_together
    from rollbench.compare.models.model import ModelOptions
    from rollbench.compare.models.registry import default_model_name
    from rollbench.compare.results.solved import CycleResult
    from rollbench.compare.running import checked_time_limit, watch_running_time
    from rollbench.compare.scenes import catalogue
    from rollbench.compare.scenes.scene_file import scenes_to_solve
    from rollbench.compare.text.solved import solved_case_parts, tangent_stiffness_parts

    described = catalogue.scene_of_any_kind(name)
    scenes: Sequence[Scene | Assembly] = scenes_to_solve(described, name)
    model, station = _check_options(solve_options)
    model = model or default_model_name(scenes[0])
    _check_options_for_scene(scenes[0], solve_options, station)
    options = ModelOptions(solve_options.everything, solve_options.member, condensed_bodies_file=solve_options.condensed)
    at = station if solve_options.stiffness_at else None
    with watch_running_time(f"{described.name}, model {one_line(model)}", checked_time_limit(solve_options.time_limit)):
        found = solve_scene_record(described, model, options, at, name, store=solve_options.store)
    cases = found.cases or {"": found}
    written: list[str] = []
    with written_together():
        for case, one in cases.items():
            path = solve_options.matrix
            written += _write_stiffness_matrix(one, path.with_stem(f"{path.stem}-{case}") if path and case else path)
        if solve_options.loads_csv is not None:
            written += _write_contact_loads(solve_options.loads_csv, cases)
        if solve_options.plot is not None:
            written.append(write_plot(solve_options.plot, found))
    shown = {"balls": solve_options.balls, "details": solve_options.verbose, "stiffness": bool(solve_options.stiffness_at)}
    if isinstance(found, CycleResult):
        from rollbench.compare.text.solved import duty_cycle_parts

        lines = duty_cycle_parts(found, **shown)
    else:
        lines = solved_case_parts(found, **shown)
        lines += [] if found.tangent is None else tangent_stiffness_parts(found.tangent)
    code = exit_code_of_solutions([*cases.values()], solve_options)
    return CommandOutput(found.to_dict, [*lines, *written], code, wrap_always=True)


def _write_contact_loads(path: Path, cases: Mapping[str, Result]) -> list[str]:
    """Write the ball contact loads of all converged load cases to a CSV file; return a line that names the file.

    ``cases``: results of each load case by name; the name is empty for a scene without load cases.
    """
    from rollbench.compare.files import write_csv
    from rollbench.compare.models.loads_file import load_rows_for_csv
    from rollbench.compare.quantities import count_with_noun

    rows = []
    for name, one in cases.items():
        for k, s in enumerate(one.sets.values(), 1):
            if s.loads is not None and s.azimuth is not None and s.z is not None:
                head = ({"case": name} if name else {}) | ({"set": str(k)} if s.name else {})
                rows += [head | row for row in load_rows_for_csv(s.loads, s.azimuth, s.z)]
    if not rows:
        return []
    write_csv(path, rows)
    check = f"rollbench check SCENE --loads {shlex.quote(str(path))}"
    return [f"wrote {path}: {count_with_noun(len(rows), 'contact load')}; compare them with the 3D reference by: {check}"]


def _check_options_for_scene(scene: Scene | Assembly, solve_options: SolveOptions, station: float) -> None:
    """Raise InputError if an option does not suit the scene, such as an option for a single nut or bearing only.

    ``station``: axial position of the requested stiffness [m], which must lie on the screw or shaft.
    """
    from rollbench.meshes.axis import Assembly

    if isinstance(scene, Assembly):
        reasons = {
            "everything": "the scene states which terms of the models are computed",
            "condensed": "the file has the bodies of a single nut or bearing",
        }
        for argument, reason in reasons.items():
            if getattr(solve_options, argument):
                given = f"this option for the scene {scene.name}, which has several nuts or bearings"
                allowed = "only for a scene with a single nut or bearing"
                raise ArgumentError(argument, given, allowed, f"leave it out: {reason}")
        if solve_options.loads_csv is not None and not scene.ball_count:
            advice = "leave it out: the columns of the file are groove flanks, which rollers do not have"
            raise ArgumentError("loads_csv", str(solve_options.loads_csv), "only for a scene with balls", advice)
    if solve_options.stiffness_at and not 0.0 <= station <= scene.screw.length:
        allowed = f"0 mm to {1e3 * scene.screw.length:g} mm"
        body = "shaft" if isinstance(scene, Assembly) else "screw"
        raise ArgumentError("stiffness_at", solve_options.stiffness_at, allowed, f"state an axial position on the {body}")


def exit_code_of_solutions(cases: Sequence[Result], solve_options: SolveOptions) -> int:
    """Return exit code 1 if a load case did not converge or, with ``solve_options.strict``, has a warning; otherwise 0."""
    from rollbench.lowfi.warned import join_brief_warnings

    failed = any(not one.converged for one in cases)
    warned = solve_options.strict and any(join_brief_warnings(one.solution.warnings) for one in cases)
    return int(failed or warned)


def _check_options(solve_options: SolveOptions) -> tuple[str, float]:
    """Check the options for one scene; return the model's name (empty: the default) and the position of the stiffness [m].

    Raises InputError if options exclude each other, or if a file cannot be written.
    """
    from rollbench.meshes import units

    model = solve_options.model or ("" if solve_options.condensed is None else "condensed")
    if solve_options.condensed is not None and model != "condensed":
        given = f"{solve_options.condensed} with the model {model}"
        advice = 'leave `model` out: the file selects the model "condensed"'
        raise ArgumentError(
            "condensed", given, '`condensed` only with the model "condensed", which alone reads such a file', advice
        )
    if not 0 <= solve_options.member < 10**9:
        advice = "state the number of a specimen (one random draw of the geometric errors)"
        raise ArgumentError("member", str(solve_options.member), "0 to 999999999", advice)
    if solve_options.matrix is not None:
        if not solve_options.stiffness_at:
            advice = "add `stiffness_at` with an axial position"
            raise ArgumentError("matrix", str(solve_options.matrix), "only with `stiffness_at`", advice)
        check_matrix_file(solve_options.matrix)
    if solve_options.loads_csv is not None:
        from rollbench.compare.files import check_writable

        check_writable(solve_options.loads_csv)
    if solve_options.plot is not None:
        check_plot_file(solve_options.plot)
    if not solve_options.stiffness_at:
        return model, 0.0
    try:
        return model, units.parse_quantity(solve_options.stiffness_at, "length")
    except ValueError as error:
        advice = f'write it like "400 mm" ({error})'
        raise ArgumentError("stiffness_at", solve_options.stiffness_at, "a length with its unit", advice) from None


def _write_stiffness_matrix(found: Result, path: Path | None) -> list[str]:
    """Write the stiffness matrix of a load case to the file that the user asked for, if any; return a line that names it.

    ``found``: results of the load case. Raises InputError if a degree of freedom of the shaft is fixed at the requested
    position, because its stiffness would be infinite.
    """
    import numpy as np

    K = found.stiffness
    if path is None or not found.converged:
        return []
    if not found.only and (K is None or not np.isfinite(K).all()):
        advice = "choose an axial position at which no degree of freedom of the shaft is fixed"
        allowed = "only if the shaft has no fixed degree of freedom there, whose stiffness would be infinite"
        raise ArgumentError("matrix", str(path), allowed, advice)
    if K is None:
        return []
    title = f"tangent stiffness of {found.scene}, model {found.model}, {found.place_of_stiffness}"
    write_matrix_file(path, K, title)
    return [f"wrote {path}: the symmetric stiffness matrix in N, m and rad"]


@app.command
def solve(
    scenes: list[str], *, options: SolveOptions | None = None, as_json: Json = False, program: ProgramOptions | None = None
) -> int:
    """Solve one scene, compare several scenes side by side, or solve many specimens of a scene with random errors.

    Prints contact loads, rigidity, pressure, static safety, preload, friction and life. For several scenes, such as the
    same axis on ball bearings and on tapered roller bearings, prints a column for each with stiffness, torque and life.

    Parameters
    ----------
    scenes
        Name of a shipped scene, or a scene file. If several are given, each is compared with the first.
    """
    given = options or SolveOptions()
    given = replace(given, model=model_or_program_name(program, given.model))
    if program is not None and given.time_limit is not None:
        advice = "use `model_seconds`, which limits each run of the program"
        value = f"{given.time_limit:g} with a model that runs as a program of its own (--model-command)"
        raise ArgumentError("time_limit", value, "only without `model_command`", advice)
    if len(scenes) > 1:
        alone = {name: getattr(given, name) for name in OF_ONE_SCENE}
        advice = "leave it out, or solve one scene at a time"
        refuse_given_arguments(alone, "only for one scene", advice, f"this option for {len(scenes)} scenes")
        return print_command_output(solve_side_by_side(scenes, given), as_json)
    (scene,) = scenes
    if given.members is not None:
        advice = "leave it out, or solve a single specimen (random draw of the geometric errors) by `member=K`"
        names = ("stiffness_at", "matrix", "curve", "loads_csv", "plot", "strict")
        refuse_given_arguments({name: getattr(given, name) for name in names}, "only without `members`", advice)
        return print_command_output(solve_specimens(scene, given.members, given), as_json)
    unused = {"csv": None if given.curve else given.csv, "seed": given.seed, "workers": given.workers}
    advice = "add --members N, the number of random draws of the geometric errors"
    refuse_given_arguments(unused, "only with `members`", advice)
    return print_command_output(solve_load_curve(scene, given) if given.curve else solve_and_report(scene, given), as_json)


def solve_side_by_side(names: Sequence[str], solve_options: SolveOptions) -> CommandOutput:
    """Solve several scenes and return a table of their results side by side; exit code 1 if one did not converge.

    Raises InputError if a scene or an option cannot be used.
    """
    from rollbench.compare.api.calls import side_by_side
    from rollbench.compare.running import checked_time_limit, watch_running_time
    from rollbench.compare.scenes import catalogue
    from rollbench.compare.scenes.scene_file import scenes_to_solve
    from rollbench.compare.text.solved import side_by_side_parts
    from rollbench.lowfi.warned import join_brief_warnings

    model, station = _check_options(solve_options)
    for name in names:
        _check_options_for_scene(scenes_to_solve(catalogue.scene_of_any_kind(name), name)[0], solve_options, station)
    at = station if solve_options.stiffness_at else None
    with watch_running_time(f"{len(names)} scenes, model {one_line(model)}", checked_time_limit(solve_options.time_limit)):
        how: dict[str, Any] = {"member": solve_options.member, "stiffness_at": at, "store": solve_options.store}
        found = side_by_side(names, model=model, **how)
    warned = solve_options.strict and any(join_brief_warnings(one.warnings) for one in found.scenes)
    parts = side_by_side_parts(found)
    parts += [] if solve_options.plot is None else [write_plot(solve_options.plot, found)]
    return CommandOutput(found.to_dict, parts, int(not found.converged or warned), wrap_always=True)


def solve_load_curve(name: str, solve_options: SolveOptions) -> CommandOutput:
    """Solve a scene over a range of loads and return its load curve; exit code 1 if a load has no equilibrium.

    Of several load cases only the first is solved. Raises InputError if the range or an option cannot be used.
    """
    from rollbench.compare.api.calls import load_curve
    from rollbench.compare.running import checked_time_limit, watch_running_time
    from rollbench.compare.text.solved import load_curve_parts

    names, advice = ("stiffness_at", "matrix", "loads_csv", "plot", "balls"), "leave it out: it is for a single load"
    refuse_given_arguments({name: getattr(solve_options, name) for name in names}, "only without `curve`", advice)
    model, _ = _check_options(solve_options)
    if (csv_out := solve_options.csv) is not None:
        from rollbench.compare.files import check_writable

        check_writable(csv_out)
    how: dict[str, Any] = {"member": solve_options.member, "everything": solve_options.everything}
    how |= {"condensed": solve_options.condensed, "store": solve_options.store}
    with watch_running_time(f"{name}, load curve", checked_time_limit(solve_options.time_limit)):
        found = load_curve(name, solve_options.curve, model, **how)
    lines = load_curve_parts(found, details=solve_options.verbose)
    if csv_out is not None:
        lines += write_load_curve(csv_out, found)
    code = int(not found.converged or (solve_options.strict and bool(found.above)))
    return CommandOutput(found.to_dict, lines, code, wrap_always=True)


def solve_specimens(name: str, count: int, solve_options: SolveOptions) -> CommandOutput:
    """Solve many specimens of a scene with random errors and return their statistics; exit code 1 if none converged.

    ``count``: number of specimens. Raises InputError if the scene or an option cannot be used.
    """
    from rollbench.compare.reference.jobs import ComputingSettings
    from rollbench.compare.scenes import catalogue
    from rollbench.compare.studies.members.members import solve_random_draws_of_load_cases

    described, given, step = catalogue.scene_of_any_kind(name), solve_options, show_progress_message
    engine = ComputingSettings(parallel_jobs=given.workers)
    found = solve_random_draws_of_load_cases(
        described, name, given.model, count, given.seed, engine, step, given.csv, given.store
    )
    shown = ensemble_terminal_parts(found, balls=given.balls)
    shown += [f"wrote {given.csv}: one row for each specimen"] * bool(given.csv)
    return CommandOutput(found.to_dict(), shown, 0 if found.converged else 1)


def _statistics_table(title: str, headings: Mapping[str, str], outputs: Mapping[str, Statistics | None]) -> TextTable:
    """Return the table with the mean, standard deviation and quantiles of each computed quantity over the specimens.

    ``headings``: name of each quantity in the table, by its key. ``outputs``: statistics of each quantity by its key; a
    quantity with None gets no row.
    """
    table = []
    for key, x in outputs.items():
        if x is not None:
            ends = {level: "{:.4g} to {:.4g}".format(*x.intervals[level]) for level in x.quantiles}
            q = [f"{x.quantiles[level]:.4g} ({ends[level]})" for level in (0.05, 0.5, 0.95, 0.99)]
            first = (f"{v:.4g}" for v in (x.mean, x.standard_error, x.standard_deviation, x.smallest))
            table.append([headings[key], *first, *q, f"{x.largest:.4g}"])
    heads = ("", "mean", "standard error", "standard deviation", "smallest", "5 %", "median", "95 %", "99 %", "largest")
    return TextTable(heads, table, title)


def ensemble_terminal_parts(found: Ensemble, *, balls: bool = False) -> list[Any]:
    """Return lines and tables for the terminal with the statistics of all solved specimens with random errors.

    ``balls``: also a table with the range of the load of every ball.
    """
    from rollbench.compare.studies.members.ensemble import KEPT, OF_SET, WHOLE

    if found.cases:
        return [part for one in found.cases.values() for part in ensemble_terminal_parts(one, balls=balls)]
    parts: list[Any] = [
        f"{found.scene}, model {found.model}, seed {found.seed}: {found.members} specimens, {found.converged} "
        f"converged, {1e3 * found.seconds / found.members:.3g} ms for each"
    ]
    parts += [f"specimen {number}: {status}" for number, status in sorted(found.failed.items())[:5]]
    title = "specimens (in brackets: 95 % confidence interval of the quantile)"
    tables = [_statistics_table(title, WHOLE if found.sets else KEPT, found.outputs)]
    tables += [_statistics_table(f"set {k}, {name}", OF_SET, of) for k, (name, of) in enumerate(found.sets.items(), 1)]
    stiff = "tangents: as rollbench solve prints them, for the position that the scene states"
    parts += [*tables, f"life: equivalent loads by ISO/TS 16281, with raceways of equal strength; {stiff}"]
    return [*parts, _contact_load_quantiles_table(found) if balls else "range of the load of every ball: add --balls"]


def _contact_load_quantiles_table(found: Ensemble) -> TextTable:
    """Return the table with quantiles of every contact load over the specimens."""
    keys = [key for key in (found.contacts[0] if found.contacts else ()) if key != "quantile_0.5_N"]
    rows = [[v if isinstance(v := row[key], str) else f"{v:.4g}" for key in keys] for row in found.contacts]
    headings = [key.removesuffix("_N").replace("_", " ") for key in keys]
    title = f"contact loads / N over the specimens (sampling error of the quantiles: {found.band_resolution:.2g} N)"
    return TextTable(headings, rows, title)


#: Number of the grid point, and name of the matrix, in DMIG cards of Nastran.
GRID, MATRIX_NAME = 1, "KNUT"


def check_matrix_file(path: Path) -> None:
    """Raise InputError if the suffix of a file for a stiffness matrix is unknown, or if the file cannot be written."""
    from rollbench.compare.files import check_writable

    if path.suffix.lower() not in (".mtx", ".dmig"):
        allowed = "a name that ends in .mtx (Matrix Market) or .dmig (Nastran)"
        raise ArgumentError("matrix", str(path), allowed, "change the suffix of the file")
    check_writable(path)


def write_matrix_file(path: Path, matrix: Array, comment_text: str) -> None:
    """Write a stiffness matrix (6, 6) [N, m, rad] in the format that the suffix of the file names, .mtx or .dmig.

    ``comment_text``: comment in the file.
    """
    from rollbench.compare.files import replace_file

    comment = re.sub(r"[^ -~]", "?", f"rollbench: {comment_text}; ux uy uz rx ry rz; N, m, rad")
    replace_file(path, matrix_market_text(matrix, comment) if path.suffix.lower() == ".mtx" else dmig_text(matrix, comment))


def matrix_market_text(matrix: Array, comment: str) -> str:
    """Return the text of a symmetric matrix in the Matrix Market format."""
    import io

    from scipy.io import mmwrite

    stream = io.BytesIO()
    mmwrite(stream, matrix, comment=comment, symmetry="symmetric", precision=16)
    return stream.getvalue().decode("ascii")


def dmig_text(matrix: Array, comment: str) -> str:
    """Return the text of DMIG cards (Nastran) with a symmetric ``(6, 6)`` matrix at one grid point.

    The cards have the lower triangle in double precision, in large fields of 16 columns.
    """
    lines = [f"$ {comment[i : i + 70]}" for i in range(0, len(comment), 70)]
    lines.append(f"{'DMIG':<8}{MATRIX_NAME:<8}{0:>8}{6:>8}{2:>8}{0:>8}")
    for column in range(6):
        lines.append(f"{'DMIG*':<8}{MATRIX_NAME:<16}{GRID:>16}{column + 1:>16}{'':16}*")
        for row in range(column, 6):
            value = f"{matrix[row, column]:.9E}".replace("E", "D")
            lines.append(f"{'*':<8}{GRID:>16}{row + 1:>16}{value:>16}{'':16}{'*' if row < 5 else ''}".rstrip())
    return "\n".join(lines) + "\n"


def write_load_curve(path: Path, curve: LoadCurve) -> list[str]:
    """Write the points of a load curve (CSV) and its figure (SVG), and return a line that names the files.

    ``path``: the CSV file. InputError if a file cannot be written.
    """
    from rollbench.compare.files import write_csv, write_figure, written_together

    figure = curve.figure()
    with written_together():
        write_csv(path, curve.frame_rows())
        picture = "" if figure is None else f" and {write_figure(path.with_suffix('.svg'), figure)}"
    return [f"wrote {path}{picture}"]
