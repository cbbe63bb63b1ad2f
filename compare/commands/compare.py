"""Command ``rollbench compare``: compares low-order models with the 3D reference, on contact loads or on rolling balls."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rollbench.compare.commands import terminal
from rollbench.compare.errors import ArgumentError
from rollbench.compare.running import check_packages, show_progress_message
from rollbench.compare.text import printing

if TYPE_CHECKING:
    from rollbench.compare.reference.estimate import Reference
    from rollbench.compare.reference.tasks import Solvable
    from rollbench.compare.results.comparison import Comparison, ModelLoads
    from rollbench.compare.scenes.duty_cycle import FrictionScene
    from rollbench.compare.studies.rolling.rows import RollingComparisonRow


#: Exit code if contact loads of a 3D reference still change after its last update of contact normals and gaps.
NOT_SETTLED = 5


def exit_code_of_references(references: Iterable[Reference]) -> int:
    """Return the exit code: 5 if contact loads of a 3D reference still change after its last update, otherwise 0.

    An update recomputes contact normals and gaps for the solved motion.
    """
    return NOT_SETTLED if any(reference.unsettled for reference in references) else 0


def parse_levels(text: str) -> tuple[int, ...]:
    """Return the mesh levels that the option ``--levels`` names; InputError for unknown levels.

    Valid texts are ``3`` (levels 1 to 3), a list such as ``1,3``, and ``source,1,2,3``, where "source" is the mesh of the
    publication.
    """
    from rollbench.compare.reference.levels import LEVELS, SOURCE_LEVEL

    allowed = f"a number from 1 to {len(LEVELS)}, or a list such as 1,3 of these numbers and source, Lin's mesh"
    if text in [str(k) for k in LEVELS]:
        return tuple(range(1, int(text) + 1))
    names = {"source": SOURCE_LEVEL} | {str(k): k for k in LEVELS}
    words = [word.strip() for word in text.split(",")]
    if any(word not in names for word in words):
        raise ArgumentError("levels", f'"{text}"', allowed, "write 3 for the levels 1, 2 and 3, or 1,3 for these two")
    return tuple(sorted({names[word] for word in words}))


def _duty_cycle_sentence(data: dict[str, Any]) -> str:
    """Return a sentence on the largest error of a model's contact loads, and the life that follows, over a duty cycle.

    ``data``: JSON summary of the comparison over all load cases, for one nut or bearing.
    """
    lives, off = data["life_million_revolutions"], data["life_error_percent"]
    life = "no life over the duty cycle"
    if off is not None:
        life = (
            f"life over the duty cycle {lives[data['model']]:.4g} million revolutions, {lives['3D reference']:.4g} from "
            f"the loads of the reference ({off:+.2f} %)"
        )
    error = data["largest_error_percent"]
    case = data["largest_error_case"]
    worst = "" if error is None else f"largest error of {data['model']} {error:.2f} %, in case {case}; "
    return f"{data['scene']}{', ' + data['set'] if 'set' in data else ''}: {worst}{life}"


def _terminal_parts(
    whole: Comparison,
    origins: Sequence[tuple[Solvable, str]],
    store: Path,
    warned: Sequence[str],
    *,
    balls: bool,
    verbose: bool,
) -> Iterator[Any]:
    """Yield texts and tables for the terminal: verdict, results and errors of the models for one nut or bearing.

    ``origins``: each solved scene with the name or file that the user stated. ``warned``: warnings to print. ``store``:
    folder to which loads of all contacts are written. ``balls``: also print every contact. ``verbose``: also print the
    causes of the uncertainty.
    """
    from rollbench.compare.models.comparison import RULE, path_of_condensed_bodies
    from rollbench.compare.reference.store import shipped_store
    from rollbench.compare.results.base import format_table_as_text

    assert whole.of is not None
    assert whole.reference is not None
    assert whole.uncertainty is not None
    scene, shared = whole.of.scene, whole.uncertainty.shared_error_sentence
    yield from (f"{whole.scene}: {whole.verdict}", *filter(None, [shared]), *warned, "")
    yield from (format_table_as_text(whole.table(), printing.text_width(), whole.headings), "")
    cells = [*map(_model_table_cells, (whole.reference, *whole.models.values()))]
    yield from (printing.TextTable(MODEL_COLUMNS, cells), "")
    if verbose:
        yield from (whole.uncertainty.words, f"rule of rollbench check: {RULE}")
        if whole.unloaded_position:
            yield (
                "displacements of models and reference are measured from the position without loads, which is "
                f"{1e6 * whole.unloaded_position:.3g} um from the nominal position by the model "
                f"{whole.judged_model.title}"
            )
    if balls:
        rows = [
            {k.removesuffix("_N"): v for k, v in row.items() if not k.endswith("percent")} for row in whole.frame_rows()
        ]
        yield from (printing.table_of_records(rows, ".2f", f"{scene.name}: contact loads / N"), "")
    single, stores = whole.of.assembly is None, (store, shipped_store())
    bodies = path_of_condensed_bodies(scene, whole.of.reference, stores) if single else None
    if bodies is not None:
        name = next(name for of, name in origins if of is scene)
        command = f"rollbench solve {shlex.quote(name)} --condensed {shlex.quote(str(bodies))}"
        yield f"preload, 6 x 6 stiffness and friction with the 3D bodies: {command}"
    yield write_contact_loads(whole, store / f"{scene.name}-compare")
    if not verbose:
        yield "--verbose also shows: causes of the uncertainty, rule of rollbench check, times of stored runs"


@terminal.app.command
def compare(
    scenes: list[str],
    *,
    model: terminal.Names = None,
    levels: str | None = None,
    store: Path = Path("rollbench-reference"),
    fresh: terminal.Flag = False,
    balls: terminal.Flag = False,
    verbose: terminal.Verbose = False,
    reference: Path | None = None,
    bodies: str = "half-space",
    as_json: terminal.Json = False,
    program: terminal.ProgramOptions | None = None,
    where: terminal.ComputeOptions | None = None,
) -> int:
    """Compare low-order models with the 3D reference of scenes; the reference is computed if none is stored.

    Prints a verdict, the results of model and reference, and a table of models. Writes the loads of every contact to
    <scene>-compare.csv and .svg in the folder of stored runs. Scenes are compared with one another by rollbench solve A B;
    rollbench report SCENE writes a page on one scene. Exit code 5 if loads of the reference still change after its last
    update of contact normals and gaps: the remaining change is printed, stored with the run and added to its uncertainty.

    Parameters
    ----------
    scenes
        Names of shipped scenes, or scene files.
    model
        Names of low-order models (rollbench list shows all); condensed uses the 3D bodies of the reference's finest level.
        Default: the verdict is about refined, and the table also has the other models of the validation report.
    levels
        Mesh levels of the reference: 3 for levels 1 to 3, or a list such as source,1,2, where source is the publication's
        mesh. Default: the best stored level, or levels 1 and 3 if none is stored.
    store
        Folder of stored runs of the reference, used in addition to the shipped runs.
    fresh
        Compute runs even if they are stored or shipped.
    balls
        Also print the loads of every contact.
    verbose
        Also print the causes of the uncertainty, the rule by which rollbench check judges, and the times of stored runs.
    reference
        Compare with this file instead of the 3D reference, which is listed too if it is stored. The format is that of
        rollbench check --reference.
    bodies
        Bodies of the 3D model for scenes of single rolling balls: half-space, or finite (contact patches of the static
        3D reference; on straight tracks a ball and grooved bars).
    """
    wanted = None if levels is None else parse_levels(levels)
    command = terminal.model_or_program_name(program)
    unused = {"model": model, "model_command": command, "balls": balls, "verbose": verbose, "reference": reference}
    rolling = scenes_of_friction_or_none(scenes, bodies, unused)
    engine = terminal.engine_from_options(where)
    if rolling:
        from rollbench.compare.studies.rolling.rows import rolling_comparison

        rows = rolling_comparison(rolling, wanted, store, engine, fresh=fresh, bodies=bodies)
        shown = dict.fromkeys(row.scene for row in rows)
        tables = (rolling_comparison_table(name, [row for row in rows if row.scene == name]) for name in shown)
        answer = printing.CommandOutput({"rows": [row.as_json() for row in rows]}, tables)
        return printing.print_command_output(answer, as_json)
    from rollbench.compare.models.comparison import comparison_rows
    from rollbench.compare.models.registry import model_by_name
    from rollbench.compare.results.base import add_schema_version
    from rollbench.compare.results.comparing import make_comparison, prepare_comparison
    from rollbench.compare.scenes import catalogue
    from rollbench.compare.scenes.duty_cycle import DutyCycle, load_cases_by_scene_name
    from rollbench.compare.scenes.scene_file import scenes_to_solve

    chosen = [model_by_name(name, "models") for name in (*(model or ()), *filter(None, [command]))]
    described = [catalogue.scene_of_any_kind(name) for name in scenes]
    if reference is not None:
        advice = "leave one of the two out, because the file of `reference` replaces the 3D reference"
        given = {"levels": wanted, "fresh": fresh}
        terminal.refuse_given_arguments(given, "only without `reference`", advice, "this option with `reference`")
    how: dict[str, Any] = {"store": store, "levels": wanted, "fresh": fresh, "reference": reference}
    found = prepare_comparison(described, scenes, chosen, engine, show_progress_message, **how)
    origins = [(x, name) for one, name in zip(described, scenes, strict=True) for x in scenes_to_solve(one, name)]
    cases = load_cases_by_scene_name(described)

    def cycle_summaries(parts: Sequence[Comparison]) -> list[dict[str, Any]]:
        """Return the summaries of all duty cycles, from the comparisons of all nuts, bearings and load cases."""
        cycles = {one.name: one for one in described if isinstance(one, DutyCycle)}.values()
        return [row for one in cycles for row in make_comparison(one, parts).cycle_summaries()]

    def terminal_parts() -> Iterator[Any]:
        """Yield the texts and tables for the terminal, those of each nut or bearing as soon as it is compared."""
        comparisons: list[Comparison] = []
        warned = [f"WARNING: {warning}" for warning in found.warnings]
        for whole in found.compare_each():
            first = [] if comparisons else warned
            yield from _terminal_parts(whole, origins, store, first, balls=balls, verbose=verbose)
            comparisons.append(whole)
        for summary in cycle_summaries(comparisons):
            yield from ("", _duty_cycle_sentence(summary))

    def json_output() -> dict[str, Any]:
        """Return the JSON output: loads of every contact, and results and errors of the models, for each scene."""
        comparisons = list(found.compare_each())
        listed, single, of_cases = (list[dict[str, Any]]() for _ in range(3))
        for whole in comparisons:
            assert whole.of is not None
            for b in whole.models.values():
                rows = comparison_rows(whole.of.scene, b.contact_loads, whole.of.reference)
                listed += [row.as_json() | whole.identifying_values(cases) for row in rows]
            (of_cases if whole.of.described_scene.name in cases else single).append(whole.part_json(cases))
        out = add_schema_version({"scenes": single, "rows": listed})
        out |= {"warnings": found.warnings} if found.from_user_file else {}
        return out | ({"summary": cycle_summaries(comparisons), "cases": of_cases} if cases else {})

    code = exit_code_of_references(one.reference for sets in found.references for one in sets)
    return printing.print_command_output(printing.CommandOutput(json_output, terminal_parts(), code), as_json)


#: Scenes for which only friction is computed and which have a 3D reference, as words of a message.
SINGLE_BALLS = (
    "scenes of single balls that roll with friction (kinds linear pair, linear chain, screw pair and bearing ball)"
)


def scenes_of_friction_or_none(
    names: Sequence[str], bodies: str, unused_arguments: Mapping[str, object]
) -> list[FrictionScene]:
    """Return the named scenes if all have only single rolling balls; an empty list if all are whole screws and bearings.

    ``names``: names or files of the scenes. ``bodies``: bodies of the 3D model, "half-space" or "finite".
    ``unused_arguments``: values of the arguments that have no effect on scenes of single rolling balls.
    Raises InputError if only some scenes have only single rolling balls, for an unknown value of ``bodies``, for finite
    bodies with whole screws, and for an argument without effect.
    """
    from rollbench.compare.reference.levels import FINITE, HALF_SPACE
    from rollbench.compare.scenes import catalogue
    from rollbench.compare.scenes.duty_cycle import FrictionScene

    scenes = [catalogue.scene_of_any_kind(name) for name in names]
    rolling = [scene for scene in scenes if isinstance(scene, FrictionScene)]
    if rolling and len(rolling) < len(scenes):
        allowed = f"either scenes of whole screws and bearings, or {SINGLE_BALLS}"
        raise ArgumentError("scenes", " ".join(names), allowed, "compare them in separate runs")
    if bodies not in (HALF_SPACE, FINITE):
        advice = f"choose one of them; {HALF_SPACE} is faster"
        raise ArgumentError("bodies", bodies, f"{HALF_SPACE} or {FINITE}", advice)
    if not rolling:
        if bodies != HALF_SPACE:
            advice = "leave it out: the 3D reference of screws and bearings always has finite bodies"
            raise ArgumentError("bodies", bodies, f"only for {SINGLE_BALLS}", advice)
        return []
    check_packages("scikit-fem")
    given, advice = (
        "this option for scenes of single balls that roll with friction",
        "leave it out: it would change nothing",
    )
    terminal.refuse_given_arguments(unused_arguments, "only for scenes of whole screws and bearings", advice, given)
    return rolling


#: Headings of the table of models.
MODEL_COLUMNS = (
    "model",
    "largest\nerror %",
    "ball,\nflank",
    "RMS\nerror %",
    "check\nerror %",
    "largest\nload N",
    "mean\nload N",
    "peak\nMPa",
    "axial\nuz um",
    "time\ns",
)


def _model_table_cells(compared_loads: ModelLoads) -> list[str]:
    """Return the row of the table of models for one model or the reference, with the columns of `MODEL_COLUMNS`."""
    import numpy as np

    from rollbench.compare.measure import mean_load

    e, solution, uz = compared_loads.error, compared_loads.contact_loads, compared_loads.displacement
    loads, errors, time = solution.load[solution.load > 0.0], [""] * 4, ""
    if e is not None:
        at, by_check = f"{e.ball} {e.side}".strip(), compared_loads.gate_error
        errors = [f"{e.max_percent:.2f}", at, f"{e.rms_percent:.2f}", f"{by_check:.2f}"]
    if solution.seconds and not solution.measured:
        time = f"{solution.seconds:.{0 if solution.seconds >= 10.0 else 2}f}"
    return [
        compared_loads.title,
        *errors,
        f"{loads.max(initial=0.0):.1f}",
        f"{mean_load(loads, compared_loads.nominal_contacts):.1f}",
        f"{1e-6 * compared_loads.pressure:.0f}",
        f"{1e6 * uz:.3f}" if np.isfinite(uz) else "–",
        time,
    ]


def write_contact_loads(compared: Comparison, stem: Path) -> str:
    """Write the loads of every contact to a CSV file and a figure, and return a line with the names of both files.

    ``stem``: path of both files without suffix.
    """
    from rollbench.compare.files import write_csv, write_figure, written_together

    drawn = compared.figure()
    assert drawn is not None, "a reference has loads"
    with written_together():
        write_csv(Path(f"{stem}.csv"), compared.frame_rows())
        figure = write_figure(Path(f"{stem}.svg"), drawn)
    return f"wrote {stem}.csv (every contact) and {figure}"


#: Columns of the table of rolling contact, after the column with the quantity: attribute of a row, heading, number format.
ROLLING_COLUMNS = (
    ("low", "low-order", ".5g"),
    ("reference", "3D", ".5g"),
    ("uncertainty", "3D +-", ".2g"),
    ("error_percent", "error %", ".2f"),
    ("uncertainty_percent", "3D +- %", ".2f"),
    ("printed", "printed", ".5g"),
    ("printed_ansys", "ANSYS", ".5g"),
    ("flat", "3D flat", ".5g"),
    ("rigid", "3D rigid", ".5g"),
    ("half_space", "3D half space", ".5g"),
)


def rolling_comparison_table(name: str, rows: Sequence[RollingComparisonRow]) -> printing.TextTable:
    """Return the table that compares the low-order model of rolling contact with the 3D model and with printed values.

    ``name``: name of the scene. ``rows``: for each quantity, its values by all models.
    """
    from rollbench.compare.studies.rolling.rows import UNSTATED

    state = f" ({rows[0].load_state} load state{UNSTATED})" if rows[0].load_state else ""
    title = f"{name}{state}: low-order model against the 3D model of rolling"
    cells = [
        [f"{r.quantity} [{r.unit}]", *(printing.format_cell(x[key], form) for key, _, form in ROLLING_COLUMNS)]
        for r, x in ((r, r.as_json()) for r in rows)
    ]
    headings = ["quantity", *(heading for _, heading, _ in ROLLING_COLUMNS)]
    return printing.TextTable(headings, cells, title, f"time of the low-order model: {1e3 * rows[0].low_seconds:.2f} ms")
