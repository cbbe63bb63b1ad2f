"""The command ``rollbench compare``: scenes beside their references, and load cases together."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from rollbench.compare.commands.comparing.compare_output import (
    Beside,
    Comparison,
    answers_json,
    answers_table,
    compared,
    contact_rows,
    older_times,
    others,
    start_lines,
    verdict,
    write_files,
)
from rollbench.compare.commands.comparing.compare_output import table as compared_table
from rollbench.compare.commands.printing import Answer, on_terminal
from rollbench.compare.commands.tables import aligned
from rollbench.compare.errors import ArgumentError, Refusal
from rollbench.compare.gate.user import judged_by, stored_beside
from rollbench.compare.measure import error_percent
from rollbench.compare.models.comparison import compared_models, finest_bodies, rows, suited
from rollbench.compare.models.referenced import Referenced, referenced
from rollbench.compare.models.registry import Model
from rollbench.compare.models.together import cycle_life
from rollbench.compare.quantities import number
from rollbench.compare.reference.estimate import Reference
from rollbench.compare.reference.jobs import Engine, ensure, plan
from rollbench.compare.reference.levels import ADVISED, LEVELS, SOURCE_LEVEL
from rollbench.compare.reference.store import Run, shipped_store
from rollbench.compare.reference.tasks import Solvable, Task
from rollbench.compare.scenes import catalogue
from rollbench.compare.scenes.duty_cycle import CaseOf, DutyCycle, cases_by_name
from rollbench.compare.scenes.scene_file import each_case
from rollbench.meshes.parts import Scene

#: Exit code where a reference has loads that did not settle.
NOT_SETTLED = 5


def code_of(references: Iterable[Reference]) -> int:
    """Exit code of a command that shows references: `NOT_SETTLED` where the loads of one did not settle, else 0."""
    return NOT_SETTLED if any(reference.unsettled for reference in references) else 0


def unconverged(name: str, failed: Sequence[Run]) -> Refusal:
    """The refusal of a scene without a converged run, with the status of each of its runs."""
    why = [f"level {run.level}: {run.status}" for run in failed if run.scene == name]
    reason = f"no run of the 3D reference converged ({'; '.join(why)})" if why else "no converged run of the 3D reference"
    return Refusal(name, "3D reference", reason, "change what the status names, or solve it with a low-order model")


def each_compared(
    scenes: Sequence[Solvable],
    references: Sequence[Sequence[Referenced]],
    models: Sequence[Model],
    stores: Sequence[Path],
    failed: Sequence[Run],
    *,
    own: bool,
) -> Iterator[tuple[Referenced, Comparison]]:
    """References, set by set, and what is compared with them, as they are asked for; models: those that suit a scene where
    none is named; own: they are the user's, beside which stored ones stand. Raises Refusal where a scene has none."""
    for scene, sets in zip(scenes, references, strict=True):
        if not sets:
            raise unconverged(scene.name, failed)
        for one in sets:
            ours = stored_beside(one, stores) if own else None
            yield one, compared(one.scene, models or suited(scene), one.found, stores, one.of, ours)


def parse_levels(text: str) -> tuple[int, ...]:
    """Levels of ``--levels``: ``3`` (levels 1 to 3), ``1,3``, ``source,1,2,3``. Raises InputError."""
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
    reference: Path | None = None,
) -> Answer:
    """Verdict, answers, table and files of every scene, models beside the reference; what is not stored is computed first.
    reference: file of the user's own, in place of it.

    JSON: verdict and answers of every scene, and rows of every quantity and model, the reference's coarser runs among
    them. balls: also print every contact.
    levels: None for the best stored reference (levels `ADVISED` are computed where there is none); else just those. fresh:
    compute them even where they are stored. Raises Refusal for a scene of which no run converged.
    """
    chosen = compared_models(tuple(models))
    described = [catalogue.any_scene(name) for name in names]
    origins = [(x, name) for one, name in zip(described, names, strict=True) for x in each_case(one, name)]
    scenes: list[Solvable] = [scene for scene, _ in origins]
    cases = cases_by_name(described)
    stores = (store, shipped_store())
    warnings: list[str] = []
    names_of = {name: case.case.name for name, case in cases.items()}
    for name, beside in (("levels", levels is not None), ("fresh", fresh)) if reference is not None else ():
        if beside:
            raise ArgumentError(name, "with a reference of your own", "one of both", "the file is the reference")
    given = None if reference is None else own_references(scenes, reference, names_of, warnings)
    without = [s for s in scenes if not referenced(s, stores)] if levels is None and not fresh else scenes
    without = [] if given is not None else without
    failed: list[Run] = []
    if without:
        wanted = levels or ADVISED
        tasks = plan(without, [k for k in wanted if k != SOURCE_LEVEL], source=SOURCE_LEVEL in wanted)

        def first(task: Task) -> None:
            """Print the verdict by the coarsest level while finer ones are computed."""
            for scene in task.scenes if task.level == min(set(wanted) - {SOURCE_LEVEL}) else ():
                for one in referenced(scene, (store,), (task.level,)):
                    whole = compared(one.scene, (chosen or suited(scene))[:1], one.found, stores, one.of)
                    on_terminal(f"{one.found.scene}, by level {task.level} alone: {verdict(whole, one.found)}")

        failed = ensure(tasks, store, engine, on_terminal, stores, fresh=fresh, stored=first)
    references = [referenced(scene, stores) for scene in scenes] if given is None else given

    def each() -> Iterator[tuple[Referenced, Comparison]]:
        return each_compared(scenes, references, chosen, stores, failed, own=given is not None)

    def heading(one: Referenced) -> dict[str, Any]:
        return named(one) | (cases[one.described].keys if one.described in cases else {})

    def parts() -> Iterator[Any]:
        yield from (f"WARNING: {warning}" for warning in warnings)
        comparisons = []
        for one, whole in each():
            comparisons.append(((one.described, one.set), whole))
            yield from (
                f"{one.found.scene}: {verdict(whole, one.found)}",
                *others(whole),
                "",
                *filter(None, [whole.total.beside]),
            )
            yield from (answers_table(whole), *start_lines(whole), "", compared_table(whole.models, whole.itself))
            yield from (*older_times(whole.models, whole.itself), "")
            if balls:
                yield from (_contacts(one.scene, whole.models, one.found), "")
            bodies = finest_bodies(one.scene, one.found, stores) if one.of is None else None
            if bodies is not None:
                name = next(name for scene, name in origins if scene is one.scene)
                command = f"rollbench solve {shlex.quote(name)} --condensed {shlex.quote(str(bodies))}"
                yield f"preload, 6 x 6 stiffness, friction by the 3D bodies: {command}"
            yield write_files(one.scene, whole.models, one.found, store)
        yield from (line for cycle in cycles_of(cases) for line in together_lines(cycle, dict(comparisons)))

    def data() -> dict[str, Any]:
        pairs = list(each())
        listed = [
            row.as_json() | heading(one)
            for one, whole in pairs
            for b in whole.models
            for row in rows(one.scene, b.answer, one.found)
        ]
        answers = [(one, answers_json(whole, one.found) | heading(one)) for one, whole in pairs]
        out: dict[str, Any] = {"scenes": [x for one, x in answers if one.described not in cases], "rows": listed}
        out |= {"warnings": warnings} if given is not None else {}
        if not cases:
            return out
        by_name = {(one.described, one.set): whole for one, whole in pairs}
        summaries = [row for cycle in cycles_of(cases) for row in together_json(cycle, by_name)]
        return out | {"summary": summaries, "cases": [x for one, x in answers if one.described in cases]}

    return Answer(data, parts(), code_of(one.found for sets in references for one in sets))


def own_references(
    scenes: Sequence[Solvable], path: Path, cases: Mapping[str, str], warnings: list[str]
) -> list[list[Referenced]]:
    """The one scene, or its load cases, beside the user's own reference, set by set; cases: which each scene is. Raises
    InputError for several scenes."""
    if len(scenes) != 1 and len(cases) != len(scenes):
        advice = "compare the scenes one by one, each with its file"
        raise ArgumentError("reference", str(path), f"one scene, not {len(scenes)}", advice)
    warned: dict[str, None] = {}
    references = [judged_by(path, scene, warned.setdefault, case=cases.get(scene.name)) for scene in scenes]
    warnings += warned
    return references


def named(one: Referenced) -> dict[str, str]:
    """Keys of a set of several on one shaft: that of the scene, and its own."""
    return {} if one.of is None else {"scene": one.of.assembly.name, "set": one.of.name}


def _contacts(scene: Scene, models: Sequence[Beside], reference: Reference) -> Any:
    rows = [{k.removesuffix("_N"): v for k, v in [*row.items()][1:]} for row in contact_rows(scene, models, reference)]
    return aligned(rows, ".2f", f"{scene.name}: contact loads / N")


def cycles_of(cases: Mapping[str, CaseOf]) -> Iterable[DutyCycle]:
    """The cycles of some cases, each once."""
    return {case.cycle.name: case.cycle for case in cases.values()}.values()


#: What is compared of each case and set, by the names of their scene and set.
Compared = Mapping[tuple[str, str], Comparison]


def together_json(cycle: DutyCycle, each: Compared) -> list[dict[str, Any]]:
    """Of each set: largest error of the model that the verdicts speak of, its case, and the lives over the cycle [10^6
    revolutions] of every model and of the reference; null where a case has none."""
    return [_of_set(cycle, name, each) for name in cycle.sets]


def _of_set(cycle: DutyCycle, name: str, each: Compared) -> dict[str, Any]:
    by_case = [(case, each[case.scene.name, name]) for case in cycle.cases]
    errors = [(whole.spoken.error.max_percent, case.name) for case, whole in by_case if whole.spoken.error is not None]
    error, worst = max(errors, default=(None, None))
    lives = {}
    for label in ("3D reference", *(b.label for b in by_case[0][1].models)):
        of_case = [{b.label: b for b in (whole.itself, *whole.models)}.get(label) for _, whole in by_case]
        rated, _ = cycle_life(cycle, name, [None if b is None else b.answer.load for b in of_case])
        lives[label] = None if rated is None else number(rated.revolutions)
    predicted, reference = lives[by_case[0][1].spoken.label], lives["3D reference"]
    off = None if predicted is None or reference is None else float(error_percent(predicted, reference))
    return {
        "scene": cycle.name,
        **({"set": name} if name else {}),
        "model": by_case[0][1].spoken.label,
        "largest_error_percent": error,
        "largest_error_case": worst,
        "life_million_revolutions": lives,
        "life_error_percent": off,
    }


def together_lines(cycle: DutyCycle, each: Compared) -> list[str]:
    """The same for the terminal."""
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
