"""Command ``rollbench check``: judges models on scenes against the 3D reference, or checks data shipped with rollbench."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from rollbench.compare.commands import terminal
from rollbench.compare.errors import InputError
from rollbench.compare.running import show_progress_message
from rollbench.compare.text.printing import CommandOutput, TextTable, format_cell, print_command_output, text_width

if TYPE_CHECKING:
    from rollbench.compare.gate.gate import GateCheck
    from rollbench.compare.gate.publish import Outcome
    from rollbench.compare.gate.user import GateRequest
    from rollbench.compare.models.study import SceneResultCache
    from rollbench.compare.reference.jobs import ComputingSettings


@Parameter(name="*")
@dataclass(frozen=True)
class VerdictFiles:
    """Files to which ``rollbench check`` writes its verdicts, and an earlier such file (baseline) to compare them with.

    Attributes
    ----------
    junit
        Also write the verdicts to this file as JUnit XML.
    markdown
        Also write the verdicts to this file as Markdown for a comment, with a chart of the worst ball and its neighbours,
        and append them to the job summary of the CI (the file named by GITHUB_STEP_SUMMARY).
    csv
        Also write the verdicts to this CSV file.
    baseline
        Report which verdicts changed since this file was written by an earlier --csv or --json.
    """

    junit: Path | None = None
    markdown: Path | None = None
    csv: Path | None = None
    baseline: Path | None = None

    def compare_and_write(
        self, outcomes: Sequence[Outcome], notes: Sequence[str]
    ) -> tuple[dict[str, Any], list[str], list[str]]:
        """Compare the verdicts with those of the baseline file, and write them with notes and changes to the files.

        Returns the changes as JSON (empty without baseline), and lines on the changes and on the written files. InputError
        if a file cannot be read or written.
        """
        from rollbench.compare.gate.publish import verdict_changes_since_file, write_verdicts

        data, lines = dict[str, Any](), list[str]()
        if self.baseline is not None:
            changed = verdict_changes_since_file(self.baseline, outcomes)
            data["changed"] = [change.as_json() for change in changed]
            said = [change.line() for change in changed] or ["nothing changed"]
            lines = [f"since {self.baseline.name}: {line}" for line in said]
        files = {"junit_file": self.junit, "markdown_file": self.markdown, "csv_file": self.csv}
        return data, lines, [f"wrote {path}" for path in write_verdicts(outcomes, [*notes, *lines], **files)]


VerdictFiles.__doc__ = terminal.join_paragraph_lines(VerdictFiles.__doc__)


def judge_and_report(
    names: Sequence[str], request: GateRequest, engine: ComputingSettings, files: VerdictFiles
) -> CommandOutput:
    """Judge a model, or another program's results, on scenes against their references, and return the verdicts.

    ``names``: names or files of the scenes. ``request``: values to judge, limits and reference. ``engine``: computes
    missing runs of the 3D reference. ``files``: files for the verdicts. The exit code is that of the worst verdict. Raises
    InputError if two scenes have the same name.
    """
    from rollbench.compare.gate.verdict import CODES
    from rollbench.compare.results.base import format_table_as_text
    from rollbench.compare.results.verdict import judge_scenes
    from rollbench.compare.scenes import catalogue
    from rollbench.compare.scenes.scene_file import scenes_to_solve

    described = [catalogue.scene_of_any_kind(name) for name in names]
    taken: dict[str, str] = {}
    for one, name in zip(described, names, strict=True):
        for scene in scenes_to_solve(one, name):
            if scene.name in taken:
                advice = "rename one of the scenes or load cases"
                raise InputError(name, "name", scene.name, "a name that no other scene of the command has", advice)
            taken[scene.name] = name
    found = judge_scenes(described, names, request, engine, show_progress_message)
    left = found.not_judged
    above = [f"WARNING: {warning}" for warning in found.warnings]
    missing = f"quantities not judged, because the file or the reference has no value of them: {', '.join(left)}"
    below = [missing] if left else []
    changes, lines, written = files.compare_and_write(found.rows, [*above, *below])
    data: dict[str, Any] = found.to_dict() | changes
    worst = [f"worst load case of {x.duty_cycle.name}: {x.load_case.name}, {one.word}" for x, one in found.worst_cases]
    table = format_table_as_text(found.table(), text_width(), found.headings)
    parts = [found.answer, *above, "", table, "", *worst, *below, *lines, *found.advice, *written]
    return CommandOutput(data, parts, CODES[found.judgement])


def check_shipped_data(cache: SceneResultCache, max_error: float) -> list[GateCheck]:
    """Run all checks of the data and models shipped with rollbench, and return the result of each.

    ``cache``: cache of computed values. ``max_error``: largest permitted error of contact loads [%].
    """
    from rollbench.compare.gate import gate
    from rollbench.compare.studies.rolling.rows import checks_of_rolling_balls

    checks = (
        gate.check_published_entries,
        gate.check_closed_forms,
        gate.check_solvers,
        gate.check_default_model,
        gate.check_known_errors_of_lin_model,
        checks_of_rolling_balls,
    )
    found = [row for check in checks for row in check(cache, max_error)]
    return found + gate.check_external_tolerance_bands(cache)


def report_shipped_data_checks(max_error: float | None, files: VerdictFiles, *, verbose: bool = False) -> CommandOutput:
    """Check the data and models shipped with rollbench, and return what the terminal shows; exit code 1 if a check fails.

    ``max_error``: largest permitted error of contact loads [%]; None: 7. ``files``: files for the results. ``verbose``:
    also list the checks that pass.
    """
    from rollbench.compare.gate.user import fraction_limit_warnings
    from rollbench.compare.gate.verdict import LIMIT, ErrorLimits
    from rollbench.compare.models.study import SceneResultCache
    from rollbench.compare.results.base import add_schema_version

    limit = LIMIT if max_error is None else max_error
    cache = SceneResultCache(random_draw_count=0)  # no random specimens are solved: no check is about random errors
    rows = check_shipped_data(cache, limit)
    bad = [row for row in rows if not row.passed]
    changes, lines, written = files.compare_and_write(rows, ())
    warnings = [*fraction_limit_warnings(ErrorLimits(limit))]
    data = add_schema_version(
        {"max_error_percent": limit, "passed": not bad, "rows": [row.as_json() for row in rows], "warnings": warnings}
    )
    data |= changes
    words = [row.judgement for row in rows]
    others = "".join(f", {n} {word}" for word in ("undecided", "reported") if (n := words.count(word)))
    line = f"{'FAIL' if bad else 'PASS'}: {words.count('ok')} passed, {len(bad)} failed{others}"
    shown = [row for row in rows if verbose or row.judgement != "ok"]
    more = [] if verbose else ["--verbose, --csv or --json also list the checks that pass"]
    above = [f"WARNING: {warning}" for warning in warnings]
    table = [shipped_checks_table(shown)] if shown else []
    return CommandOutput(data, [line, *above, *table, *more, *lines, *written], 1 if bad else 0)


def shipped_checks_table(rows: Sequence[GateCheck]) -> TextTable:
    """Return the table of the checks of shipped data for the terminal, failed checks first.

    Values have enough digits to show whether they exceed their limits.
    """
    texts = [
        (
            row.judgement,
            row.subject + (f" ({row.note})" if row.note and not row.passed else ""),
            row.quantity,
            *(format_cell(x, ".6g") for x in (row.value, row.reference)),
            *(format_cell(x, ".3g") for x in (row.error, row.limit)),
        )
        for row in sorted(rows, key=lambda row: row.passed)
    ]
    headings = ("", "check", "kind", "value", "reference", "error %", "limit %")
    return TextTable(headings, texts, "checks of shipped data")


@terminal.app.command
def check(
    scenes: list[str] | None = None,
    /,
    *,
    model: terminal.Word = "",
    loads: Path | None = None,
    values: Path | None = None,
    max_error: float | None = None,
    limit: Annotated[list[str] | None, Parameter(negative="")] = None,
    strict: terminal.Flag = False,
    reference: Path | None = None,
    levels: int | None = None,
    stored: Path | None = None,
    no_compute: terminal.Flag = False,
    store: Path = Path("rollbench-reference"),
    verdict_files: VerdictFiles | None = None,
    printed: terminal.Flag = False,
    source: terminal.Names = None,
    only: terminal.Names = None,
    verbose: terminal.Verbose = False,
    as_json: terminal.Json = False,
    program: terminal.ProgramOptions | None = None,
) -> int:
    """Judge the loads of a model against the 3D reference of scenes: pass, fail or undecided.

    A scene passes if error + u is within the limit, where u is the uncertainty of the reference. It fails if error - u is
    beyond the limit, and is undecided otherwise. It is not covered if no reference is stored and none may be computed. The
    error of a contact load is in per cent of its reference load, or of the mean load if the reference load is below a tenth
    of the mean.

    Without scenes, the data shipped with rollbench are checked: values printed in publications, closed-form solutions,
    equilibrium, runs of the 3D reference. With --printed, every number and claim that the reproduced publications print is
    judged.

    Exit codes: 0 all pass (without scenes: no check fails); 1 one fails; 2 bad input; 3 none fails, but one is undecided; 4
    none fails or is undecided, but one is not covered.

    Parameters
    ----------
    scenes
        Names of shipped scenes, or scene files. A scene may state its limits in a table [gate].
    model
        Low-order model to judge. Default: refined.
    loads
        Judge the contact loads of another program, from a CSV file with the columns ball, flank (SL, SR, NL or NR: screw or
        nut, left or right), newton. If the file also has azimuth_deg and z_mm, balls are matched by position. The columns
        contact_angle_deg, approach_um and pressure_MPa are judged too. The headings state the units: load_kN, angle_rad,
        z_um.
    values
        Judge values of the whole screw from another program, from a CSV file with the columns quantity (displacement
        and rigidity of the point on which the load acts, to ground; torque; life), value, unit, where (empty: at the
        scene's loads; an axial load such as 5 kN; for a displacement also an axial position such as 400 mm).
    max_error
        Largest permitted error of the contact loads in per cent, which replaces the scenes' limits. Default: the limit that
        the scene states, or 7.
    limit
        Largest permitted error of another quantity, as NAME=NUMBER, in per cent (contact angle: in degrees); may be
        repeated. Default: contact angle 1 degree; approach two thirds, pressure one third, life three times the limit of
        the loads; other quantities the limit of the loads. A model is judged on the quantities for which a limit is stated.
    strict
        Treat an unknown column as an error instead of a warning, and fail a model whose result is outside its range of
        validity, even if its loads agree with the reference.
    reference
        Judge by this file instead of the 3D reference: reference loads of every flank in the columns of --loads, with a
        column uncertainty_N, or a line "# uncertainty: 0.5 %" and a line "# provenance: ..." above. Default uncertainty:
        0.
    levels
        Compute mesh levels 1 to N of the reference unless they are stored. Default: the best stored level, or 2 if fewer
        are stored. With level 1 only, the uncertainty is estimated from other scenes.
    stored
        Use only runs of the reference that are stored in this folder or shipped, and compute none.
    no_compute
        Compute no run of the reference.
    store
        Folder of stored runs of the reference, used in addition to the shipped runs.
    printed
        Judge the numbers and claims that publications print. Exit code 1 if a verdict differs from the expected one.
    source
        With --printed: publications to judge, such as lin. Default: all.
    only
        With --printed: tables or entries to judge, such as lin-3.5 or lin-3.5:a_force_numerical. Default: all.
    verbose
        Without scenes: also list the checks that pass.
    """
    model, files = terminal.model_or_program_name(program, model), verdict_files or VerdictFiles()
    if printed:
        given: dict[str, object] = {"scenes": scenes, "model": model, "loads": loads, "values": values}
        given |= {"max_error": max_error, "limits": limit, "strict": strict, "reference": reference, "levels": levels}
        given |= {"stored": stored, "no_compute": no_compute, **asdict(files)}
        advice = "leave it out, because printed numbers have limits of their own"
        terminal.refuse_given_arguments(given, "only without --printed", advice)
        from rollbench.compare.commands.printed import judge_printed_numbers

        return print_command_output(judge_printed_numbers(source or (), only or ()), as_json)
    terminal.refuse_given_arguments({"source": source, "only": only}, "only with --printed", "add --printed")
    from rollbench.compare.gate.user import GateRequest
    from rollbench.compare.reference.jobs import ComputingSettings

    request = GateRequest(
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
        engine = ComputingSettings(cache_folder=terminal.cache_folder())
        return print_command_output(judge_and_report(scenes, request, engine, files), as_json)
    given = {"model": model, "loads": loads, "values": values, "limits": limit}
    given |= {"reference": reference, "strict": strict, "levels": levels, "stored": stored, "no_compute": no_compute}
    terminal.refuse_given_arguments(given, "only together with a scene", "state the scenes to judge")
    return print_command_output(report_shipped_data_checks(max_error, files, verbose=verbose), as_json)
