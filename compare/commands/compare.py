"""The command ``rollbench compare``: scenes against their references, load cases together, and scenes of rolling balls."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rollbench.compare.commands.terminal import Flag, Json, Names, OfProgram, Verbose, Where, app, engine, model_of
from rollbench.compare.errors import ArgumentError, Refusal
from rollbench.compare.running import need_packages, on_terminal
from rollbench.compare.text.printing import Answer, aligned, print_answer, ruled, text_width

if TYPE_CHECKING:
    from rollbench.compare.models.comparison import Referenced
    from rollbench.compare.reference.estimate import Reference
    from rollbench.compare.reference.jobs import Engine
    from rollbench.compare.results.compared import Beside
    from rollbench.compare.results.comparison import ByCase
    from rollbench.compare.scenes.duty_cycle import DutyCycle
    from rollbench.compare.scenes.friction_kinds.common import KindScene
    from rollbench.compare.studies.rolling.rows import RollingRow
    from rollbench.compare.studies.rolling.runs import RollingRun
    from rollbench.meshes.parts import Scene


#: Exit code where a reference has loads that did not settle.
NOT_SETTLED = 5


def code_of(references: Iterable[Reference]) -> int:
    """Exit code of a command that shows references: `NOT_SETTLED` where the loads of one did not settle, else 0."""
    return NOT_SETTLED if any(reference.unsettled for reference in references) else 0


def parse_levels(text: str) -> tuple[int, ...]:
    """Levels of ``--levels``: ``3`` (levels 1 to 3), ``1,3``, ``source,1,2,3``. Raises InputError."""
    from rollbench.compare.reference.levels import LEVELS, SOURCE_LEVEL

    allowed = f"a number from 1 to {len(LEVELS)}, or some of source, {', '.join(map(str, LEVELS))} with commas"
    if text in [str(k) for k in LEVELS]:
        return tuple(range(1, int(text) + 1))
    names = {"source": SOURCE_LEVEL} | {str(k): k for k in LEVELS}
    words = [word.strip() for word in text.split(",")]
    if any(word not in names for word in words):
        raise ArgumentError("levels", f'"{text}"', allowed, "3 computes levels 1, 2 and 3")
    return tuple(sorted({names[word] for word in words}))


def run_compare(
    names: Sequence[str],
    models: Sequence[str],
    levels: tuple[int, ...] | None,
    store: Path,
    engine: Engine,
    *,
    fresh: bool = False,
    balls: bool = False,
    verbose: bool = False,
    reference: Path | None = None,
) -> Answer:
    """Verdict, answers, table and files of every scene, models beside the reference; what is not stored is computed first.
    reference: file of the user's own, in place of it.

    JSON: verdict and answers of every scene, and rows of every quantity and model, the reference's coarser runs among
    them. balls: also print every contact; verbose: what the comparison is uncertain by.
    levels: None for the best stored reference (levels `ADVISED` are computed where there is none); else just those. fresh:
    compute them even where they are stored. Raises Refusal for a scene of which no run converged.
    """
    from rollbench.compare.commands.compare_output import older_times, start_lines, write_files
    from rollbench.compare.commands.compare_output import table as compared_table
    from rollbench.compare.models.comparison import RULE, compared_models, finest_bodies, rows
    from rollbench.compare.results.base import as_text, with_schema
    from rollbench.compare.results.compared import answer_rows, answers_json, verdict
    from rollbench.compare.results.comparison import comparing, cycles_of, named, together_json
    from rollbench.compare.scenes import catalogue
    from rollbench.compare.scenes.duty_cycle import cases_by_name
    from rollbench.compare.scenes.scene_file import each_case

    chosen = compared_models(tuple(models))
    described = [catalogue.any_scene(name) for name in names]
    for name, beside in (("levels", levels is not None), ("fresh", fresh)) if reference is not None else ():
        if beside:
            raise ArgumentError(name, "with a reference of your own", "one of both", "the file is the reference")
    how: dict[str, Any] = {"store": store, "levels": levels, "fresh": fresh, "reference": reference}
    found = comparing(described, names, chosen, engine, on_terminal, **how)
    origins = [(x, name) for one, name in zip(described, names, strict=True) for x in each_case(one, name)]
    cases, warnings, stores, own = cases_by_name(described), found.warnings, found.stores, found.own

    def heading(one: Referenced) -> dict[str, Any]:
        return named(one) | (cases[one.described].keys if one.described in cases else {})

    def parts() -> Iterator[Any]:
        comparisons, warned = [], [f"WARNING: {warning}" for warning in warnings]
        for one, whole in found.each():
            comparisons.append(((one.described, one.set), whole))
            yield from (f"{one.found.scene}: {verdict(whole, one.found)}", *filter(None, [whole.total.beside]), *warned, "")
            warned = []
            headings, answers = answer_rows(whole)
            yield from (as_text(answers, text_width(), headings), "", compared_table(whole.models, whole.itself), "")
            if verbose:
                yield from (whole.total.text, f"gate's rule: {RULE}")
                yield from (*start_lines(whole), *older_times(whole.models, whole.itself))
            if balls:
                yield from (_contacts(one.scene, whole.models, one.found), "")
            bodies = finest_bodies(one.scene, one.found, stores) if one.of is None else None
            if bodies is not None:
                name = next(name for scene, name in origins if scene is one.scene)
                command = f"rollbench solve {shlex.quote(name)} --condensed {shlex.quote(str(bodies))}"
                yield f"preload, 6 x 6 stiffness, friction by the 3D bodies: {command}"
            yield write_files(one.scene, whole.models, one.found, store)
            if not verbose:
                yield "--verbose: the uncertainty by its causes, the gate's rule, times of stored runs"
        yield from (line for cycle in cycles_of(cases) for line in together_lines(cycle, dict(comparisons)))

    def data() -> dict[str, Any]:
        pairs = list(found.each())
        listed = [
            row.as_json() | heading(one)
            for one, whole in pairs
            for b in whole.models
            for row in rows(one.scene, b.answer, one.found)
        ]
        answers = [(one, answers_json(whole, one.found) | heading(one)) for one, whole in pairs]
        out = with_schema({"scenes": [x for one, x in answers if one.described not in cases], "rows": listed})
        out |= {"warnings": warnings} if own else {}
        if not cases:
            return out
        by_name = {(one.described, one.set): whole for one, whole in pairs}
        summaries = [row for cycle in cycles_of(cases) for row in together_json(cycle, by_name)]
        return out | {"summary": summaries, "cases": [x for one, x in answers if one.described in cases]}

    return Answer(data, parts(), code_of(one.found for sets in found.references for one in sets))


def _contacts(scene: Scene, models: Sequence[Beside], reference: Reference) -> Any:
    from rollbench.compare.commands.compare_output import contact_rows

    listed = [{k.removesuffix("_N"): v for k, v in [*row.items()][1:]} for row in contact_rows(scene, models, reference)]
    return aligned(listed, ".2f", f"{scene.name}: contact loads / N")


def together_lines(cycle: DutyCycle, each: ByCase) -> list[str]:
    """The same for the terminal."""
    from rollbench.compare.results.comparison import together_json

    return [line for data in together_json(cycle, each) for line in ("", _line(data))]


def _line(data: dict[str, Any]) -> str:
    lives, off = data["life_million_revolutions"], data["life_error_percent"]
    life = "no life over the duty cycle"
    if off is not None:
        life = (
            f"life over the duty cycle {lives[data['model']]:.4g} million revolutions, {lives['3D reference']:.4g} by the "
            f"reference's loads ({off:+.2f} %)"
        )
    error = data["largest_error_percent"]
    worst = "" if error is None else f"{data['model']} is off most in case {data['largest_error_case']}, {error:.2f} %; "
    return f"{data['scene']}{', ' + data['set'] if 'set' in data else ''}: {worst}{life}"


@app.command
def compare(
    scenes: list[str],
    *,
    model: Names = None,
    levels: str | None = None,
    store: Path = Path("rollbench-reference"),
    fresh: Flag = False,
    balls: Flag = False,
    verbose: Verbose = False,
    reference: Path | None = None,
    bodies: str = "half-space",
    as_json: Json = False,
    program: OfProgram | None = None,
    where: Where | None = None,
) -> int:
    """Compare low-order models with the 3D reference of scenes; the reference is computed where none is stored.

    A verdict, answers of model and reference, a table of models; every contact goes to <scene>-compare.csv and .svg in
    the store. Scenes against one another: rollbench solve A B. For a page to send: rollbench report SCENE. Exit code 5
    where loads of the reference did not settle: what they may still move by is said, kept with the run and added to its
    uncertainty.

    Parameters
    ----------
    scenes
        Names of shipped scenes, or scene files.
    model
        Low-order models of rollbench list; condensed takes the bodies of the reference's finest level. Unless given:
        refined, the default of every command, whose error is the verdict, and beside it the others that the report
        compares.
    levels
        Mesh levels of the reference: 3 for levels 1 to 3, or a list such as source,1,2; the best stored one unless given,
        levels 1 and 3 where there is none.
    store
        Folder of the reference's results, besides those shipped.
    fresh
        Compute runs even where they are stored or shipped.
    balls
        Also print every contact.
    verbose
        Also print what the comparison is uncertain by, the gate's rule, and times of stored runs.
    reference
        Compare with this file in place of the 3D reference, which stands beside it where it is stored; as for rollbench
        check.
    bodies
        Of scenes of friction: half-space, or finite (patches of the static reference, or a ball and grooved bars).
    """

    wanted = None if levels is None else parse_levels(levels)
    command = model_of(program)
    means_nothing = {"model": model is not None, "model_command": command != ""}
    means_nothing |= {"balls": balls, "verbose": verbose, "reference": reference is not None}
    if all_rolling(scenes, bodies, means_nothing):
        answer = run_rolling_compare(scenes, wanted, store, engine(where), fresh=fresh, bodies=bodies)
    else:
        models = [*(model or ()), *filter(None, [command])]
        how: dict[str, Any] = {"fresh": fresh, "balls": balls, "verbose": verbose, "reference": reference}
        answer = run_compare(scenes, models, wanted, store, engine(where), **how)
    return print_answer(answer, as_json)


def runs_of(
    scene: KindScene, levels: Sequence[int], store: Path, engine: Engine, *, fresh: bool, bodies: str = "half-space"
) -> list[RollingRun]:
    """Runs of the levels in order, stored ones where there are; each is stored when it is done.

    Raises Refusal for a scene that is beyond the 3D model, and where a run did not converge.
    """
    from rollbench.compare.reference.parallel import as_done
    from rollbench.compare.reference.store import shipped_store
    from rollbench.compare.studies.rolling.runs import compute, load, save

    stores = (store, shipped_store())
    found = {} if fresh else {k: run for k in levels if (run := load(scene, k, stores, bodies)) is not None}
    missing = [k for k in levels if k not in found]
    jobs = [(compute, (scene, k, bodies, engine.processes)) for k in missing]
    for number, run in as_done(jobs, engine.backend, engine.scheduler, engine.workers, engine.wait):
        save(store, scene, run)
        found[missing[number]] = run
        on_terminal(f"{scene.name}: level {run.level}, {run.shape[0]} x {run.shape[1]} cells, {run.all_seconds:.1f} s")
    bad = next((found[k] for k in levels if not found[k].converged), None)
    if bad is not None:
        raise Refusal(scene.name, f"level {bad.level}", bad.status, "try another level")
    return [found[k] for k in levels]


def known_levels(levels: Sequence[int]) -> list[int]:
    """The levels as they are. Raises InputError for one that rolling balls do not have."""
    from rollbench.compare.studies.rolling.runs import LEVELS, SOURCE_LEVEL

    other = [k for k in levels if k not in LEVELS]
    if other:
        got = ", ".join("source" if k == SOURCE_LEVEL else str(k) for k in other)
        advice = "mesh-study with `source_mesh=True` shows the source's size"
        raise ArgumentError("levels", got, f"1 to {len(LEVELS)} for scenes of friction", advice)
    return list(levels)


def run_rolling_compare(
    names: Sequence[str], levels: tuple[int, ...] | None, store: Path, engine: Engine, *, fresh: bool, bodies: str
) -> Answer:
    """Low-order models beside the 3D model of rolling; all its levels unless given."""
    from rollbench.compare.reference.jobs import Engine
    from rollbench.compare.reference.levels import HALF_SPACE
    from rollbench.compare.scenes import catalogue
    from rollbench.compare.scenes.friction_kinds.common import KindScene
    from rollbench.compare.studies.rolling.rows import rows
    from rollbench.compare.studies.rolling.runs import LEVELS

    wanted = known_levels(levels or tuple(LEVELS))
    out: list[RollingRow] = []
    for name in names:
        scene = catalogue.any_scene(name)
        assert isinstance(scene, KindScene)
        found = runs_of(scene, wanted, store, engine, fresh=fresh, bodies=bodies)
        beside = None if bodies == HALF_SPACE else runs_of(scene, wanted[-1:], store, Engine(), fresh=False)[0]
        out += rows(scene, found, beside)
    shown = dict.fromkeys(row.scene for row in out)
    tables = (_table(name, [row for row in out if row.scene == name]) for name in shown)
    return Answer({"rows": [finite(row.as_json()) for row in out]}, tables)


def finite(row: dict[str, Any]) -> dict[str, Any]:
    """A row without infinity."""
    return {k: None if isinstance(v, float) and abs(v) == float("inf") else v for k, v in row.items()}


#: Columns of the table after the quantity: attribute of a row, heading, format.
COLUMNS = (
    ("low", "low-order", ".5g"),
    ("reference", "3D", ".5g"),
    ("uncertainty", "+-", ".2g"),
    ("error_percent", "error %", ".2f"),
    ("uncertainty_percent", "+- %", ".2f"),
    ("printed", "printed", ".5g"),
    ("printed_ansys", "ANSYS", ".5g"),
    ("flat", "3D flat", ".5g"),
    ("rigid", "3D rigid", ".5g"),
    ("half_space", "3D half space", ".5g"),
)


def _cell(value: float | None, form: str) -> str:
    return "–" if value is None or abs(value) == float("inf") else format(value, form)


def _table(name: str, rows: Sequence[RollingRow]) -> Any:
    from rollbench.compare.studies.rolling.rows import UNSTATED

    state = f" ({rows[0].load_state} load state{UNSTATED})" if rows[0].load_state else ""
    title = f"{name}{state}: low-order model against the 3D model of rolling"
    cells = ([f"{r.quantity} [{r.unit}]", *(_cell(getattr(r, key), form) for key, _, form in COLUMNS)] for r in rows)
    table = ruled(title, ["quantity", *(heading for _, heading, _ in COLUMNS)], cells, ["quantity"])
    table.caption = f"low-order: {1e3 * rows[0].low_seconds:.2f} ms now; 3D on the finest grid: {rows[0].seconds:.2f} s, "
    table.caption += f"measured with {rows[0].measured_with}"
    return table


def run_rolling_study(
    names: Sequence[str], levels: int | None, store: Path, engine: Engine, *, source: bool, fresh: bool, bodies: str
) -> Answer:
    """Every quantity on every grid, all of them unless given, as it is and on top of the rigid limit, and its uncertainty
    from them all."""
    from rollbench.compare.scenes import catalogue
    from rollbench.compare.scenes.friction_kinds.common import KindScene
    from rollbench.compare.studies.rolling.rows import uncertainty
    from rollbench.compare.studies.rolling.runs import LEVELS, SOURCE_LEVEL, SOURCE_SIZE

    levels = len(LEVELS) if levels is None else levels
    if not 1 <= levels <= len(LEVELS):
        raise ArgumentError("levels", str(levels), f"1 to {len(LEVELS)}", "three levels give a scatter")
    out: list[dict[str, Any]] = []
    for name in names:
        scene = catalogue.any_scene(name)
        assert isinstance(scene, KindScene)
        wanted = [*([SOURCE_LEVEL] if source and scene.kind in SOURCE_SIZE else []), *range(1, levels + 1)]
        runs = runs_of(scene, wanted, store, engine, fresh=fresh, bodies=bodies)
        grids = [run for run in runs if run.level != SOURCE_LEVEL]
        for key in runs[-1].values:
            share = finite({"uncertainty": uncertainty(grids, key)})
            out += [study_row(scene.name, run, key) | share for run in runs]
    return Answer(out, _study_parts(out))


def _study_parts(out: Sequence[dict[str, Any]]) -> Iterator[Any]:
    for name in dict.fromkeys(row["scene"] for row in out):
        rows_of = [{k: v for k, v in row.items() if k != "scene"} for row in out if row["scene"] == name]
        yield from (f"mesh study of {name}", "", aligned(rows_of, ".6g"))


def study_row(name: str, run: RollingRun, key: str) -> dict[str, Any]:
    """A quantity on a grid: with limit and elasticity apart, and the grid's own number."""
    from rollbench.compare.studies.rolling.rows import load_state
    from rollbench.compare.studies.rolling.runs import SOURCE_LEVEL

    return {
        "scene": name,
        "load_state": load_state(name),
        "quantity": key,
        "level": "source" if run.level == SOURCE_LEVEL else str(run.level),
        "cells": f"{run.shape[0]} x {run.shape[1]}",
        "value": run.values[key],
        "grid_alone": run.elastic[key],
        "elasticity": run.elastic[key] - run.near_rigid[key],
        "rigid_limit": run.limit[key],
        "energy_lost_percent": 100.0 * run.upwind,
        "seconds": run.seconds,
    }


def all_rolling(names: Sequence[str], bodies: str, means_nothing: Mapping[str, bool]) -> bool:
    """Whether scenes are all of kinds that only friction solves; False for whole screws and bearings.

    means_nothing: arguments that rolling balls do not know, and whether each was given. Raises InputError
    where some are and some are not, for an unknown name of bodies, for finite bodies under whole screws, and for such an
    option.
    """
    from rollbench.compare.reference.levels import FINITE, HALF_SPACE
    from rollbench.compare.scenes import catalogue
    from rollbench.compare.scenes.friction_kinds.common import KindScene

    kinds = [isinstance(catalogue.any_scene(name), KindScene) for name in names]
    if any(kinds) and not all(kinds):
        allowed = "whole screws and bearings, or scenes of friction"
        raise ArgumentError("scenes", " ".join(names), allowed, "name them apart")
    if bodies not in (HALF_SPACE, FINITE):
        raise ArgumentError("bodies", bodies, f"{HALF_SPACE} or {FINITE}", "half spaces are the faster ones")
    if not any(kinds):
        if bodies != HALF_SPACE:
            advice = "the static reference is of finite bodies"
            raise ArgumentError("bodies", bodies, "scenes of friction", advice)
        return False
    need_packages("scikit-fem")
    for argument in (name for name, given in means_nothing.items() if given):
        advice = "leave it out: it would change nothing"
        raise ArgumentError(argument, "scenes of friction", "whole screws and bearings", advice)
    return True
