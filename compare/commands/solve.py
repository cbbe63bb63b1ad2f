"""``rollbench solve``: solve one scene, several side by side, a load curve, or many samples of random errors."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from rollbench.compare.commands.terminal import Flag, Json, OfProgram, Verbose, Word, app, model_of
from rollbench.compare.errors import ArgumentError, one_line
from rollbench.compare.running import on_terminal
from rollbench.compare.text.printing import Answer, print_answer, ruled

if TYPE_CHECKING:
    from rollbench.compare.models.load_cases import Solved, SolvedAxis
    from rollbench.compare.reference.jobs import Engine
    from rollbench.compare.studies.members.members import Members
    from rollbench.lowfi.statics.result import StaticResult
    from rollbench.lowfi.statics.tangent import Tangent
    from rollbench.meshes.arrays import Array
    from rollbench.meshes.axis import Assembly
    from rollbench.meshes.parts import Scene


@dataclass(frozen=True)
class Choices:
    """Options of the command line for one solve.

    everything: build all parts, needed or not; member: number of the sample; condensed: file of condensed bodies; balls:
    print the table of balls; stiffness_at, matrix: station of the stiffness, and its file; loads_csv: file of the contact
    loads; time_limit [s]; strict: exit code 1 where a warning precedes the answers; verbose: print details.
    """

    model: str = ""
    everything: bool = False
    member: int = 0
    condensed: Path | None = None
    balls: bool = False
    stiffness_at: str = ""
    matrix: Path | None = None
    loads_csv: Path | None = None
    time_limit: float | None = None
    strict: bool = False
    verbose: bool = False


def run_solve(name: str, choices: Choices) -> Answer:
    """Solve one scene, of one set or several, or each of its load cases; exit code 1 where one did not converge.

    Raises InputError.
    """
    from rollbench.compare.api.calls import solve_described
    from rollbench.compare.models.registry import Options, default_model
    from rollbench.compare.running import checked, watched
    from rollbench.compare.scenes import catalogue
    from rollbench.compare.scenes.scene_file import each_case
    from rollbench.compare.text.solved import case_table, stiffness_lines

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
        written += _write(one, tangent, files)
    if choices.loads_csv is not None:
        written += _write_loads(choices.loads_csv, solved, names)
    shown = {"balls": choices.balls, "details": choices.verbose, "stiffness": bool(choices.stiffness_at)}
    if found.cycle is None or found.together is None:
        tangent = found.tangents[0]
        lines = [*case_table(solved[0], **shown), *([] if tangent is None else stiffness_lines(tangent))]
    else:
        from rollbench.compare.text.solved import cases_table

        lines = cases_table(found.cycle, solved, found.together, found.tangents, **shown)
    return Answer(found.to_dict, [*lines, *written], code_of(solved, choices), folded=True)


def _of_case(choices: Choices, name: str) -> Choices:
    """Return the options for one load case, with its name added to the name of the matrix file."""

    def named(path: Path | None) -> Path | None:
        return None if path is None else path.with_stem(f"{path.stem}-{name}")

    return replace(choices, matrix=named(choices.matrix))


def _write_loads(path: Path, solved: Sequence[Solved | SolvedAxis], names: Sequence[str]) -> list[str]:
    """Write the ball contact loads of converged load cases as CSV, by case and set; return a line naming the file."""
    from rollbench.compare.files import write_csv
    from rollbench.compare.models.load_cases import Solved
    from rollbench.compare.models.loads_file import loads_csv
    from rollbench.compare.quantities import count_of

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
    """Raise InputError for a station beyond the screw or shaft, and for options that several sets do not have."""
    from rollbench.meshes.axis import Assembly

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
    """Return exit code 1 if a scene or load case did not converge or, if ``strict``, has a warning; else 0."""
    from rollbench.lowfi.warned import above

    return int(any(one.answers is None or (choices.strict and above(one.result.warnings)) for one in solved))


def _checked(choices: Choices) -> tuple[str, float]:
    """Check the options; return the model's name (empty: the default) and the station of the stiffness [m].

    Raises InputError for options that exclude each other, and for a file that cannot be written.
    """
    from rollbench.meshes import units

    model = choices.model or ("" if choices.condensed is None else "condensed")
    if choices.condensed is not None and model != "condensed":
        advice = "leave `model` out"
        raise ArgumentError("condensed", str(choices.condensed), "the model condensed", advice)
    if not 0 <= choices.member < 10**9:
        raise ArgumentError("member", str(choices.member), "0 to 999999999", "give the specimen's number")
    if choices.matrix is not None:
        if not choices.stiffness_at:
            raise ArgumentError("matrix", str(choices.matrix), "with `stiffness_at`", "give a station")
        from rollbench.compare.commands.solve_files import check_matrix

        check_matrix(choices.matrix)
    if choices.loads_csv is not None:
        from rollbench.compare.files import need_writable

        need_writable(choices.loads_csv)
    if not choices.stiffness_at:
        return model, 0.0
    try:
        return model, units.parse(choices.stiffness_at, "length")
    except ValueError as error:
        allowed = "a length with its unit"
        raise ArgumentError("stiffness_at", choices.stiffness_at, allowed, f'"400 mm"; {error}') from None


def _write(one: Solved | SolvedAxis, tangent: Tangent | None, choices: Choices) -> list[str]:
    """Write the requested files other than loads; return a line for each. Raises InputError."""
    import numpy as np

    from rollbench.compare.models.load_cases import SolvedAxis

    if not one.result.converged:
        return []
    lines, path, (K, where) = [], choices.matrix, _stiffness(one, tangent)
    if path is not None and isinstance(one, SolvedAxis) and (K is None or not np.isfinite(K).all()):
        advice = "ask for a station where no freedom of the shaft is held"
        raise ArgumentError("matrix", str(path), "a stiffness in all six freedoms", advice)
    if path is not None and K is not None:
        from rollbench.compare.commands.solve_files import write_stiffness

        write_stiffness(path, K, f"tangent stiffness of {one.scene.name}, model {one.result.model}, {where}")
        lines.append(f"wrote {path}: the matrix, symmetric, in N, m and rad")
    return lines


def _stiffness(one: Solved | SolvedAxis, tangent: Tangent | None) -> tuple[Array | None, str]:
    """Return the requested stiffness (6, 6) [N, m, rad], or None, and a text on where it is taken."""
    from rollbench.compare.models.load_cases import SolvedAxis

    if isinstance(one, SolvedAxis):
        return one.result.stiffness, f"{one.result.stiffness_at} against all that the scene holds"
    if tangent is None or tangent.status != "converged":
        return None, ""
    return tangent.matrix, f"screw's section at {1e3 * tangent.station:.6g} mm against the held nut"


@app.command
def solve(
    scenes: list[str],
    *,
    model: Word = "",
    as_json: Json = False,
    everything: Annotated[Flag, Parameter(name="--all")] = False,
    member: int = 0,
    condensed: Path | None = None,
    balls: Flag = False,
    stiffness_at: Word = "",
    matrix: Path | None = None,
    curve: Annotated[Word, Parameter(allow_leading_hyphen=True)] = "",
    loads_csv: Path | None = None,
    members: int | None = None,
    csv: Path | None = None,
    seed: int | None = None,
    workers: int | None = None,
    time_limit: float | None = None,
    strict: Flag = False,
    verbose: Verbose = False,
    program: OfProgram | None = None,
) -> int:
    """Solve one scene, compare several scenes side by side, or solve many samples of a scene with random errors.

    Prints loads, rigidity, pressure, safety, preload, friction and life. For several scenes, such as one axis on ball
    bearings and on tapered roller bearings: a column each with stiffness, torque, life.

    Parameters
    ----------
    scenes
        Name of a shipped scene, or a scene file; of several scenes, each is compared with the first.
    model
        Low-order model (see: rollbench list). Default: refined, or condensed if --condensed is given.
    everything
        Build all parts of the model, even those that the scene does not need.
    member
        Number of the sample, for a scene with random errors.
    condensed
        File that rollbench condense made of these parts: condensed 3D bodies, for the model "condensed".
    balls
        Also print the table of all balls.
    stiffness_at
        Also print the 6 x 6 tangent stiffness at a station of the screw, such as "400 mm", with the nut fixed.
    matrix
        File for that matrix: .mtx (Matrix Market) or .dmig (Nastran).
    curve
        Print a load curve, the lash and the stiffness outside it, instead of the answers. Forces such as "-3000N:3000N"
        replace the scene's loads; they act along the axis at the nut's centre (of several sets: where the loads act).
        Append ":41" for 41 points (default 21), ":x", ":y" or an angle such as ":45deg" for a transverse force, ":300mm"
        or the name of a housing for another position. Without unit, "0:1.5" scales all loads of the scene.
    loads_csv
        File for all contact loads, in the format of check --loads: ball, flank, newton, azimuth_deg, z_mm; for load cases
        with a column case.
    members
        Number of samples to solve; prints distributions of the largest load, stiffness, number of unloaded contacts,
        life; with --balls also the range of every ball.
    csv
        With --members: file with one row per sample; with --curve: one row per load, and a figure of the same name.
    seed
        With --members: seed of the random errors; it replaces the scene's.
    workers
        With --members: number of parallel processes.
    time_limit
        Give up after this many seconds, with exit code 1. Default: no limit.
    strict
        Exit with 1 if a WARNING line precedes the answers: pressure, preload, static safety or rotations beyond the
        validity of the models, or a load of which little reaches the contacts.
    verbose
        Also print further quantities, the assumptions, neglected effects, the balance and the solver.
    """
    model = model_of(program, model)
    if program is not None and time_limit is not None:
        raise ArgumentError("time_limit", f"{time_limit:g}", "without a program", "`model_seconds` limits each of its runs")
    if len(scenes) > 1:
        alone: dict[str, object] = {"matrix": matrix, "loads_csv": loads_csv, "csv": csv, "condensed": condensed}
        alone |= {"members": members}
        alone |= {"seed": seed, "workers": workers, "curve": curve or None, "balls": balls or None}
        alone |= {"everything": everything or None, "verbose": verbose or None}
        for name in (k for k, v in alone.items() if v is not None):
            raise ArgumentError(name, f"with {len(scenes)} scenes", "one scene", "solve one scene at a time for that")
        choices = Choices(model, member=member, stiffness_at=stiffness_at, time_limit=time_limit, strict=strict)
        return print_answer(run_side_by_side(scenes, choices), as_json)
    (scene,) = scenes
    if members is not None:
        from rollbench.compare.reference.jobs import Engine

        if stiffness_at or strict or curve or any(file is not None for file in (matrix, loads_csv)):
            named = "stiffness_at, matrix, curve, loads_csv, strict"
            raise ArgumentError(named, "given", "without --members", "they are of one member: --member K")
        how = Engine(workers=workers)
        return print_answer(run(scene, model, members, csv_out=csv, seed=seed, engine=how, balls=balls), as_json)
    if seed is not None or workers is not None or (csv is not None and not curve):
        raise ArgumentError("csv, seed, workers", "given", "with --members", "add --members N")
    choices = Choices(
        model, everything, member, condensed, balls, stiffness_at, matrix, loads_csv, time_limit, strict, verbose
    )
    return print_answer(run_curve(scene, curve, choices, csv) if curve else run_solve(scene, choices), as_json)


def run_side_by_side(names: Sequence[str], choices: Choices) -> Answer:
    """Solve several scenes and compare them side by side; exit code 1 where one did not converge. Raises InputError."""
    from rollbench.compare.api.calls import side_by_side_described
    from rollbench.compare.running import checked, watched
    from rollbench.compare.scenes import catalogue
    from rollbench.compare.scenes.scene_file import each_case
    from rollbench.compare.text.solved import side_by_side_lines
    from rollbench.lowfi.warned import above

    described = [catalogue.any_scene(name) for name in names]
    model, station = _checked(choices)
    for one, name in zip(described, names, strict=True):
        _check_parts(each_case(one, name)[0], choices, station)
    at = station if choices.stiffness_at else None
    with watched(f"{len(names)} scenes, model {one_line(model)}", checked(choices.time_limit)):
        found = side_by_side_described(described, names, model, choices.member, at)
    warned = choices.strict and any(above(one.warnings) for one in found.scenes)
    return Answer(found.to_dict, side_by_side_lines(found), int(not found.converged or warned), folded=True)


def run_curve(name: str, text: str, choices: Choices, csv_out: Path | None) -> Answer:
    """Solve a scene over a range of loads (of load cases: the first); exit code 1 where a load has no equilibrium.

    Raises InputError.
    """
    from rollbench.compare.api.calls import load_curve_of
    from rollbench.compare.models.registry import Options
    from rollbench.compare.running import checked, watched
    from rollbench.compare.scenes import catalogue
    from rollbench.compare.text.solved import curve_lines

    if choices.stiffness_at or choices.matrix or choices.loads_csv or choices.balls:
        raise ArgumentError("stiffness_at, matrix, loads_csv, balls", "given", "without `curve`", "they are of one load")
    model, _ = _checked(choices)
    if csv_out is not None:
        from rollbench.compare.files import need_writable

        need_writable(csv_out)
    options = Options(choices.everything, choices.member, condensed=choices.condensed)
    with watched(f"{name}, load curve", checked(choices.time_limit)):
        found = load_curve_of(catalogue.any_scene(name), text, model, options, name)
    lines = curve_lines(found, details=choices.verbose)
    if csv_out is not None:
        from rollbench.compare.commands.solve_files import write_curve

        lines += write_curve(csv_out, found)
    return Answer(found.to_dict, lines, int(not found.converged or (choices.strict and bool(found.above))), folded=True)


def run(
    name: str, model: str, count: int, *, csv_out: Path | None, seed: int | None, engine: Engine, balls: bool = False
) -> Answer:
    """Solve many samples and write one CSV row for each as they come; exit code 1 where none converged.

    balls: also show the range of every ball. Raises InputError.
    """
    from rollbench.compare.results.base import with_schema
    from rollbench.compare.scenes import catalogue

    described = catalogue.any_scene(name)
    from rollbench.compare.studies.members.members import ensemble_json, solve_ensemble

    each, cases = solve_ensemble(described, name, model, count, seed, engine, on_terminal, csv_out)
    shown = [x for batch in each for x in as_table(batch, balls=balls)] + [f"{csv_out}: one row a member"] * bool(csv_out)
    data = with_schema(ensemble_json(described, each, cases))
    return Answer(data, shown, 0 if all(len(batch.failed) < count for batch in each) else 1)


def _statistics(title: str, headings: Mapping[str, str], rows: Mapping[str, dict[str, Any] | None]) -> Any:
    table = []
    for key, stats in rows.items():
        if stats is None:
            continue
        q = {row["level"]: f"{row['value']:.4g} ({row['low']:.4g} to {row['high']:.4g})" for row in stats["quantiles"]}
        first = (f"{stats[k]:.4g}" for k in ("mean", "standard_error", "standard_deviation", "smallest"))
        table.append([headings[key], *first, q[0.05], q[0.5], q[0.95], q[0.99], f"{stats['largest']:.4g}"])
    heads = ("", "mean", "standard error", "deviation", "smallest", "5 %", "median", "95 %", "99 %", "largest")
    return ruled(title, heads, table, ("",))


def as_table(members: Members, *, balls: bool = False) -> list[Any]:
    """Return the statistics of samples for the terminal and, if ``balls``, the range of every ball."""
    from rollbench.compare.studies.members.ensemble import KEPT, OF_SET, WHOLE
    from rollbench.compare.studies.members.members import members_json
    from rollbench.meshes.axis import Assembly

    data = members_json(members)
    several = isinstance(members.scene, Assembly)
    parts: list[Any] = [
        f"{data['scene']}, model {data['model']}, seed {data['seed']}: {data['members']} members, {data['converged']} "
        f"converged, {1e3 * members.seconds / data['members']:.3g} ms a member"
    ]
    parts += [f"member {row['member']}: {row['status']}" for row in data["failed"][:5]]
    headings = WHOLE if several else KEPT
    tables = [_statistics("members (in brackets: 95 % interval of the quantile)", headings, data["statistics"])]
    tables += [_statistics(f"set {s['set']}, {s['name']}", OF_SET, s["statistics"]) for s in data.get("sets", [])]
    of_nut = (
        "stiffness at the loads: by 0.1 % more load (liu: load_step), of shaft and nut; "
        "the rigidity of solve is that of the nut only"
    )
    stiff = "tangent rigidity: in equilibrium, where it is asked for" if several else of_nut
    parts += [*tables, f"life: ISO/TS 16281 equivalent loads, raceways equally strong; {stiff}"]
    return [*parts, _bands(data, members.bands.width) if balls else "bands of every ball: --balls"]


def _bands(data: dict[str, Any], width: float) -> Any:
    keys = [key for key in (data["balls"][0] if data["balls"] else ()) if key != "quantile_0.5_N"]
    rows = ([v if isinstance(v := row[key], str) else f"{v:.4g}" for key in keys] for row in data["balls"])
    headings = (key.removesuffix("_N").replace("_", " ") for key in keys)
    return ruled(f"bands of the contact loads / N (to {width:.2g} N)", headings, rows)
