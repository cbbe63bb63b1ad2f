"""The command ``rollbench check``: the shipped gate, or a user's scenes against their 3D reference."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from rollbench.compare.commands.terminal import (
    Flag,
    Json,
    Names,
    OfProgram,
    Verbose,
    Word,
    app,
    cache_folder,
    model_name_of,
)
from rollbench.compare.errors import ArgumentError, InputError
from rollbench.compare.running import on_terminal
from rollbench.compare.text.printing import Answer, cell, print_answer, ruled_table, text_width

if TYPE_CHECKING:
    from rich.table import Table

    from rollbench.compare.gate.gate import GateRow
    from rollbench.compare.gate.publish import Change, Outcome
    from rollbench.compare.gate.user import GateRequest
    from rollbench.compare.models.study import Study
    from rollbench.compare.reference.jobs import Engine


@dataclass(frozen=True)
class Files:
    """Files to write the verdicts to, and an earlier file of verdicts to compare with."""

    junit: Path | None = None
    markdown: Path | None = None
    csv: Path | None = None
    baseline: Path | None = None

    def changed(self, outcomes: Sequence[Outcome]) -> list[Change]:
        """Return what changed since the verdicts of the baseline. Raises InputError."""
        from rollbench.compare.gate.publish import changes_against_file

        return [] if self.baseline is None else changes_against_file(self.baseline, outcomes)

    def since(self, changed: Sequence[Change]) -> list[str]:
        """Return the changes as sentences; none without a baseline."""
        if self.baseline is None:
            return []
        return [f"since {self.baseline.name}: {change.line()}" for change in changed] or [
            f"since {self.baseline.name}: nothing changed"
        ]

    def write(self, outcomes: Sequence[Outcome], notes: Sequence[str]) -> list[str]:
        """Write the requested files and return a line for each."""
        from rollbench.compare.gate.publish import publish

        written = publish(outcomes, notes, junit_file=self.junit, markdown_file=self.markdown, csv_file=self.csv)
        return [f"{path} written" for path in written]


def run_check(names: Sequence[str], request: GateRequest, engine: Engine, files: Files) -> Answer:
    """Judge scenes, one row per quantity or per load case; the exit code is that of the worst verdict."""
    from rollbench.compare.gate.publish import outcome_of_verdict
    from rollbench.compare.gate.verdict import CODES
    from rollbench.compare.results.base import as_text
    from rollbench.compare.results.verdict import judge_request
    from rollbench.compare.scenes import catalogue
    from rollbench.compare.scenes.scene_file import each_case

    described = [catalogue.any_scene(name) for name in names]
    taken: dict[str, str] = {}
    for one, name in zip(described, names, strict=True):
        for scene in each_case(one, name):
            if scene.name in taken:
                advice = "verdicts differ by the name of file and case: rename one"
                raise InputError(name, "name", scene.name, "each scene once, with a unique name", advice)
            taken[scene.name] = name
    found = judge_request(described, names, request, engine, on_terminal)
    verdicts, left = found.judged, found.not_judged
    outcomes = [outcome_of_verdict(v) for v in verdicts]
    changed = files.changed(outcomes)
    above = [f"WARNING: {warning}" for warning in found.warnings]
    below = [f"not judged, because not given or not held by the reference: {', '.join(left)}"] if left else []
    below += files.since(changed)
    written = files.write(outcomes, [*above, *below])
    data: dict[str, Any] = found.to_dict()
    data |= {} if files.baseline is None else {"changed": [change.as_json() for change in changed]}
    worst = [f"the worst of {x['scene']}: case {x['case']}, {x['verdict']}" for x in data.get("worst_cases", ())]
    table = as_text(found.table(), text_width(), found.headings)
    parts = [found.answer, *above, "", table, "", *worst, *below, *found.advice, *written]
    return Answer(data, parts, CODES[data["verdict"]])


def run_gate(study: Study, max_error: float) -> list[GateRow]:
    """Return all rows of the acceptance check of the shipped data."""
    from rollbench.compare.gate.gate import (
        band_rows,
        closed_form_rows,
        printed_rows,
        reference_rows,
        solver_rows,
        source_rows,
    )
    from rollbench.compare.studies.rolling.rows import rolling_rows

    return [
        *printed_rows(study, max_error),
        *closed_form_rows(study, max_error),
        *solver_rows(study, max_error),
        *reference_rows(study, max_error),
        *source_rows(study, max_error),
        *rolling_rows(study, max_error),
        *band_rows(study),
    ]


def run_shipped(max_error: float | None, files: Files, *, verbose: bool = False) -> Answer:
    """Check the shipped data: counts, and the rows that do not pass (or all); exit code 1 where a row fails."""
    from rollbench.compare.gate.publish import outcome_of_check
    from rollbench.compare.gate.user import fraction_warnings
    from rollbench.compare.gate.verdict import LIMIT, Limits
    from rollbench.compare.models.study import Study
    from rollbench.compare.results.base import with_schema

    limit = LIMIT if max_error is None else max_error
    rows = run_gate(Study(members=0), limit)  # no screws are drawn: no claim on random errors is gated
    bad = [row for row in rows if not row.passed]
    outcomes = [outcome_of_check(row) for row in rows]
    changed = files.changed(outcomes)
    written = [*files.since(changed), *files.write(outcomes, files.since(changed))]
    warnings = [*fraction_warnings(Limits(limit))]
    data = with_schema(
        {"max_error_percent": limit, "passed": not bad, "rows": [row.as_json() for row in rows], "warnings": warnings}
    )
    data |= {} if files.baseline is None else {"changed": [change.as_json() for change in changed]}
    words = [row.verdict for row in rows]
    others = "".join(f", {n} {word}" for word in ("undecided", "reported") if (n := words.count(word)))
    line = f"{'FAIL' if bad else 'PASS'}: {words.count('ok')} passed, {len(bad)} failed{others}"
    shown = [row for row in rows if verbose or row.verdict != "ok"]
    more = [] if verbose else ["rows that pass: --verbose, --csv or --json"]
    above = [f"WARNING: {warning}" for warning in warnings]
    return Answer(data, [line, *above, *([gate_table(shown)] if shown else []), *more, *written], 1 if bad else 0)


def gate_table(rows: Sequence[GateRow]) -> Table:
    """Return the rows of the gate as a table, failed rows first.

    Digits are chosen so that no value beyond its limit is printed as if it were within.
    """
    texts = (
        (
            row.verdict,
            row.name + (f" ({row.detail})" if row.detail and not row.passed else ""),
            row.kind,
            *(cell(x, ".6g") for x in (row.value, row.reference)),
            *(cell(x, ".3g") for x in (row.error_percent, row.limit_percent)),
        )
        for row in sorted(rows, key=lambda row: row.passed)
    )
    return ruled_table(
        "gate", ("", "check", "kind", "value", "reference", "error %", "limit %"), texts, ("", "check", "kind")
    )


@app.command
def check(
    scenes: list[str] | None = None,
    /,
    *,
    model: Word = "",
    loads: Path | None = None,
    values: Path | None = None,
    max_error: float | None = None,
    limit: Annotated[list[str] | None, Parameter(negative="")] = None,
    strict: Flag = False,
    reference: Path | None = None,
    levels: int | None = None,
    stored: Path | None = None,
    no_compute: Flag = False,
    store: Path = Path("rollbench-reference"),
    junit: Path | None = None,
    markdown: Path | None = None,
    csv: Path | None = None,
    baseline: Path | None = None,
    printed: Flag = False,
    source: Names = None,
    only: Names = None,
    verbose: Verbose = False,
    as_json: Json = False,
    program: OfProgram | None = None,
) -> int:
    """Judge a model on scenes by their 3D reference: pass, fail or undecided; without scenes, check all shipped data.

    A scene passes where error + u is within the limit, with u the uncertainty of the reference; it fails where error - u
    is beyond the limit, and is undecided in between. It is not covered where no reference is stored and none may be
    computed. The error of a contact load is in per cent of its reference load (of the mean load where the reference load
    is below a tenth of the mean).

    Without scenes, the shipped data are checked: printed values, closed forms, equilibrium, 3D references. With
    --printed, every number and claim that the sources print is judged.

    Exit codes: 0 all pass (without scenes: no row fails); 1 one fails; 2 bad input; 3 none fails, but one is undecided; 4
    none fails or is undecided, but one is not covered.

    Parameters
    ----------
    scenes
        Names of shipped scenes, or scene files. A scene may set its limits in a table [gate].
    model
        Low-order model to judge. Default: refined.
    loads
        Judge loads computed by another program: CSV file with the columns ball, flank (SL, SR, NL, NR), newton. With
        azimuth_deg and z_mm too, balls are matched by position. Columns contact_angle_deg, approach_um, pressure_MPa are
        judged too. Headings give the unit: load_kN, angle_rad, z_um.
    values
        Judge values of the whole screw computed by another program: CSV file with the columns quantity (displacement,
        rigidity, torque, life), value, unit, where (empty: at the scene's loads; an axial load such as 5 kN; for a
        displacement also a station such as 400 mm).
    max_error
        Limit of the error of loads in per cent; it replaces the scenes' limits. Default: the scene's limit, else 7.
    limit
        Limit of another quantity, NAME=NUMBER, in per cent (contact angle: in degrees); may be repeated. Default: contact
        angle 1 degree; approach two thirds, pressure one third, life three times the limit of the loads; other quantities
        the limit of the loads. A model is judged on the quantities that are named.
    strict
        Treat an unknown column as an error instead of a warning.
    reference
        Judge by this file instead of the 3D reference: reference loads of every flank in the columns of --loads, with a
        column uncertainty_N, or a line "# uncertainty: 0.5 %" and a line "# provenance: ..." above. Default uncertainty:
        0.
    levels
        Compute mesh levels 1 to N of the reference where they are not stored. Default: the best stored level, or 2 where
        fewer are stored. With level 1 only, the uncertainty is estimated from other scenes.
    stored
        Take the reference from the runs stored in this folder or shipped, and compute none.
    no_compute
        Compute no run of the reference.
    store
        Folder of stored reference runs, used in addition to the shipped runs.
    junit
        Also write the verdicts as JUnit XML.
    markdown
        Also write them as Markdown for a comment, with a chart of the worst ball and its neighbours, and append it to the
        job summary of the CI (the file named by GITHUB_STEP_SUMMARY).
    csv
        Also write them as CSV.
    baseline
        Report what changed since this file of verdicts, which an earlier --csv or --json wrote.
    printed
        Judge what the sources print: each entry gets a verdict; exit code 1 where a verdict differs from the expected
        one.
    source
        With --printed: sources to judge, such as lin. Default: all.
    only
        With --printed: tables or entries to judge, such as lin-3.5 or lin-3.5:a_force_numerical. Default: all.
    verbose
        Without scenes: also print the rows that pass.
    """
    model = model_name_of(program, model)
    if printed:
        given: dict[str, object] = {"scenes": scenes, "model": model, "loads": loads, "values": values}
        given |= {"max_error": max_error, "limits": limit, "strict": strict, "reference": reference, "levels": levels}
        given |= {"stored": stored, "no_compute": no_compute, "junit": junit, "markdown": markdown, "csv": csv}
        refuse_given(given | {"baseline": baseline}, "without --printed", "leave it out: printed data have separate limits")
        from rollbench.compare.commands.printed import run_printed

        return print_answer(run_printed(source or (), only or ()), as_json)
    refuse_given({"source": source, "only": only}, "with --printed", "add it")
    from rollbench.compare.gate.user import gate_request
    from rollbench.compare.reference.jobs import Engine

    files = Files(junit, markdown, csv, baseline)
    request = gate_request(
        model=model,
        loads=loads,
        values=values,
        max_error=max_error,
        limits=limit or (),
        strict=strict,
        reference=reference,
        levels=levels,
        store=store,
        stored=stored,
        compute=not no_compute,
    )
    if scenes:
        return print_answer(run_check(scenes, request, Engine(cache=cache_folder()), files), as_json)
    given = {"model": model, "loads": loads, "values": values, "limits": limit}
    given |= {"reference": reference, "strict": strict, "levels": levels, "stored": stored, "no_compute": no_compute}
    refuse_given(given, "with a scene", "name the scenes that are judged")
    return print_answer(run_shipped(max_error, files, verbose=verbose), as_json)


def refuse_given(given: Mapping[str, object], allowed: str, advice: str) -> None:
    """Raise ArgumentError for the first given argument that has no meaning here."""
    for name, value in given.items():
        if value:
            text = ", ".join(map(str, value)) if isinstance(value, list) else str(value)
            raise ArgumentError(name, text, allowed, advice)
