"""The command ``rollbench compare``: scenes beside their references, and load cases together."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rollbench.compare.commands.terminal import Flag, Json, Names, Where, app, engine
from rollbench.compare.errors import ArgumentError
from rollbench.compare.text.printing import Answer, on_terminal, print_answer
from rollbench.compare.text.tables import aligned

if TYPE_CHECKING:
    from rollbench.compare.models.comparison import Referenced
    from rollbench.compare.reference.estimate import Reference
    from rollbench.compare.reference.jobs import Engine
    from rollbench.compare.results.compared import Beside
    from rollbench.compare.results.comparison import ByCase
    from rollbench.compare.scenes.duty_cycle import DutyCycle
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
    reference: Path | None = None,
) -> Answer:
    """Verdict, answers, table and files of every scene, models beside the reference; what is not stored is computed first.
    reference: file of the user's own, in place of it.

    JSON: verdict and answers of every scene, and rows of every quantity and model, the reference's coarser runs among
    them. balls: also print every contact.
    levels: None for the best stored reference (levels `ADVISED` are computed where there is none); else just those. fresh:
    compute them even where they are stored. Raises Refusal for a scene of which no run converged.
    """
    from rollbench.compare.commands.compare_output import answers_table, older_times, start_lines, write_files
    from rollbench.compare.commands.compare_output import table as compared_table
    from rollbench.compare.models.comparison import compared_models, finest_bodies, rows
    from rollbench.compare.results.base import with_schema
    from rollbench.compare.results.compared import answers_json, others, verdict
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
        yield from (f"WARNING: {warning}" for warning in warnings)
        comparisons = []
        for one, whole in found.each():
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
    reference: Path | None = None,
    bodies: str = "half-space",
    as_json: Json = False,
    where: Where | None = None,
) -> int:
    """Compare low-order models with the 3D reference of scenes; the reference is computed where none is stored.

    A verdict, ten answers beside the reference's, a table of models; every contact goes to <scene>-compare.csv and .svg in
    the store. For a page to send: rollbench report SCENE. Exit code 5 where loads of the reference did not settle: what
    they may still move by is said, kept with the run and added to its uncertainty.

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
    reference
        Compare with this file in place of the 3D reference, which stands beside it where it is stored; as for rollbench
        check.
    bodies
        Of scenes of friction: half-space, or finite (patches of the static reference, or a ball and grooved bars).
    """
    from rollbench.compare.commands.rolling import all_rolling, run_rolling_compare

    wanted = None if levels is None else parse_levels(levels)
    means_nothing = {"model": model is not None, "balls": balls, "reference": reference is not None}
    if all_rolling(scenes, bodies, means_nothing):
        answer = run_rolling_compare(scenes, wanted, store, engine(where), fresh=fresh, bodies=bodies)
    else:
        answer = run_compare(
            scenes, model or (), wanted, store, engine(where), fresh=fresh, balls=balls, reference=reference
        )
    return print_answer(answer, as_json)
