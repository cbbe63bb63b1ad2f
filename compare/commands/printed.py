"""Commands ``check --printed`` (also ``audit``), which judges numbers printed in publications, and ``list``."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rollbench.compare.commands.terminal import Flag, Json, Names, Word, app
from rollbench.compare.errors import ArgumentError
from rollbench.compare.text.printing import CommandOutput, TextTable, format_cell, print_command_output, table_of_records

if TYPE_CHECKING:
    from rollbench.compare.evidence import PrintedEntryComparison
    from rollbench.compare.models.study import SceneResultCache


def judge_printed_numbers(sources: Sequence[str], only: Sequence[str], write: Path | None = None) -> CommandOutput:
    """Judge the numbers and claims that publications print; exit code 1 if a verdict differs from the expected one.

    The file of printed numbers states the expected verdict of each number or claim.

    ``sources``: names of publications; if empty, all. ``only``: names of printed tables and entries ("table:key"); if
    empty, all tables of these publications. ``write``: file for the verdicts. Raises InputError for an unknown name.
    """
    from rollbench.compare.files import replace_file
    from rollbench.compare.models.study import SceneResultCache

    rows = judged_printed_entries(SceneResultCache(), sources, only)
    if write is not None:
        verdicts = {row.printed.name: row.verdict for row in rows}
        replace_file(write, json.dumps(verdicts, indent=0) + "\n")
    changed = [row.verdict_change for row in rows if row.verdict_change]
    data = printed_entries_json(rows, changed)
    return CommandOutput(data, printed_entries_table(data), 1 if changed else 0)


def judged_printed_entries(
    cache: SceneResultCache, sources: Sequence[str] = (), only: Sequence[str] = ()
) -> list[PrintedEntryComparison]:
    """Return the numbers and claims of some publications or printed tables with the values computed for them.

    ``cache``: cache of computed values. ``sources``: names of publications; if empty, all. ``only``: names of printed
    tables and entries ("table:key"); if empty, all tables of these publications. The order is that of the tables.
    Raises InputError for an unknown name.
    """
    from rollbench.compare.case import all_cases
    from rollbench.compare.evidence import all_computations, evidence
    from rollbench.compare.printed import load_printed_table

    cases = [case.name for case in all_cases() if case.title]
    _refuse_unknown_names("source", sources, cases)
    tables = [name for name, one in sorted(all_computations().items()) if not sources or one.case.name in sources]
    entries = any(":" in word for word in only)
    names = {row.name for table in tables for row in load_printed_table(table)} if entries else set()
    _refuse_unknown_names("only", only, [*tables, *sorted(names)])
    asked = only or tables
    found = evidence(cache, *(name for name in tables if any(word.partition(":")[0] == name for word in asked)))
    return [one for one in found if one.printed.table in asked or one.printed.name in asked]


def _refuse_unknown_names(argument: str, given: Sequence[str], names: Sequence[str]) -> None:
    """Raise ArgumentError, with similar names, for the first name in ``given`` that is not in ``names``.

    ``argument``: name of the argument that is refused.
    """
    from rollbench.compare.files import did_you_mean, similar_names

    for word in given:
        if word not in names:
            allowed = ", ".join(name for name in names if ":" not in name)
            advice = did_you_mean(similar_names(word, names)) or "choose one that rollbench list shows"
            raise ArgumentError(argument, f'"{word}"', allowed, advice)


def printed_entries_json(rows: Sequence[PrintedEntryComparison], changed: Sequence[str]) -> dict[str, Any]:
    """Return judged printed numbers and claims as JSON, with counts of the verdicts, misprints, and numbers not compared.

    ``rows``: printed numbers and claims with their verdicts. ``changed``: a text for each verdict that differs from the
    expected one, which the file of printed numbers states.
    """
    from rollbench.compare.evidence import count_entries_by_verdict, misprint_rows, uncompared_number_rows

    return {
        "counts": count_entries_by_verdict(rows),
        "entries": [printed_entry_json(row) for row in rows],
        "misprints": misprint_rows(),
        "left_out": uncompared_number_rows(),
        "changed_verdicts": list(changed),
    }


def printed_entry_json(e: PrintedEntryComparison) -> dict[str, Any]:
    """Return one printed number or claim as JSON: printed and computed value, error, verdict and reason of the verdict."""
    from rollbench.compare.evidence import publication_title_of

    p = e.printed
    return {
        "entry": p.name,
        "source": publication_title_of(p),
        "place": p.place,
        "quantity": p.label,
        "printed": p.claim or p.number_as_printed,
        "unit": p.unit,
        "class": p.entry_class,
        "kind": p.kind,
        "as_printed": e.as_printed,
        "right": e.value,
        "inferred_reading": e.reading,
        "follows_from_printed": e.follows,
        "reference_3d": e.reference,
        "error_percent": e.error_percent,
        "verdict": e.verdict,
        "reason": e.reason,
    }


def printed_entries_table(data: Mapping[str, Any]) -> list[Any]:
    """Return tables and lines for the terminal: verdicts by publication, printed numbers and claims, changed verdicts.

    ``data``: `printed_entries_json`.
    """
    from rollbench.compare.evidence import APART, reproduction_sentence
    from rollbench.compare.printed import VERDICTS

    headings = [name + (" (not judged)" if name in APART else "") for name in ("source", *VERDICTS, "judged", "all")]
    counts = [[*map(str, row.values())] for row in data["counts"]]
    table = TextTable(headings, counts, "numbers printed in publications, by verdict")
    values = {
        "follows from printed": "follows_from_printed",
        "with mistakes": "as_printed",
        "computed": "right",
        "3D reference": "reference_3d",
        "error %": "error_percent",
    }
    rows = []
    for one in data["entries"]:
        numbers = (format_cell(one[k], ".5g") for k in values.values())
        printed = f"{one['printed']} {one['unit']}".rstrip()
        rows.append((one["entry"], printed, *numbers, one["verdict"], one["reason"]))
    headings = ["table:key", "printed", *values, "verdict", "reason"]
    entries = TextTable(headings, rows, "numbers and claims printed in publications")
    lines = [reproduction_sentence(row) for row in data["counts"]]
    left_out = f"{len(data['left_out'])} groups of numbers that are not compared"
    lines.append(f"--json also lists: {len(data['misprints'])} misprints, each with a command and a test; {left_out}")
    return [table, *lines, entries, *(f"changed: {line}" for line in data["changed_verdicts"])]


def list_computations_of_printed_numbers(table: str = "") -> CommandOutput:
    """Return a list of how the value for every printed number of one table, or of all tables, is computed and tested.

    ``table``: name of the printed table; empty: all. The list has the number as printed, the scenes from which its value is
    computed or the reason for none, the computing function and the test. Raises InputError for an unknown table.
    """
    from rollbench.compare.evidence import computations_of_entries

    entries = list(computations_of_entries(table))
    headings = ("table", "key", "printed", "class", "scenes, or reason for none", "computed by", "test")
    rows = []
    for t in entries:
        scenes = ", ".join(t["scenes"]) or t["no_scene"]
        texts = (t[key] for key in ("table", "key", "printed", "cls"))
        rows.append((*texts, scenes, t["computation"], t["test"].removeprefix("tests/sources/") or "–"))
    return CommandOutput(
        entries, [TextTable(headings, rows, "how the value for every printed number is computed and tested")]
    )


@app.command
def audit(*, only: Names = None, write: Path | None = None, as_json: Json = False) -> int:
    """Judge every number and claim that the publications print; earlier name of check --printed, available until 1.0.

    Parameters
    ----------
    only
        Names of printed tables or entries. Default: all.
    write
        File to which the verdicts are written.
    """
    return print_command_output(judge_printed_numbers((), only or (), write), as_json)


def list_parts_in_catalogues(words: str) -> CommandOutput:
    """Return the list of the nuts and bearings in makers' catalogues whose maker, name or type has some words.

    The numbers are as printed, in common units. Raises InputError, with similar names, if there is none.
    """
    from rollbench.compare.scenes import makers

    found = makers.parts_named_like(words) or [makers.find_part(words, argument="makers")]
    rows = {"nuts": [p for p in found if p.is_nut], "bearings": [p for p in found if not p.is_nut]}
    data = {name: [makers.printed_values(part) for part in parts] for name, parts in rows.items() if parts}
    tables = [table_of_records(one, title=f"{len(one)} {name}, as printed") for name, one in data.items()]
    line = "a scene of one: rollbench new FILE --like NAME"
    return CommandOutput(data, [*tables, line])


def _shipped_contents_json() -> dict[str, dict[str, Any]]:
    """Return shipped scenes (by kind) and models with their titles, makers and printed tables with numbers of rows."""
    from rollbench.compare import printed
    from rollbench.compare.models.registry import AXIS_MODELS, MODELS
    from rollbench.compare.models.user_models import entry_points_of_installed_models, origin_of_model
    from rollbench.compare.scenes import catalogue, makers
    from rollbench.compare.scenes.duty_cycle import AXIS, WHOLE

    names_with_counts = Counter(part.maker for part in (*makers.nuts_in_catalogues(), *makers.bearings_in_catalogues()))
    titles = {name: catalogue.top_level_keys(name)["title"] for name in catalogue.scene_names()}
    kinds = {name: catalogue.kind_of_shipped_scene(name) for name in titles}
    of_users = {name: origin_of_model(name) for name in entry_points_of_installed_models() if name not in MODELS}
    return {
        "scenes": {
            kind: {name: title for name, title in titles.items() if kinds[name] == kind}
            for kind in dict.fromkeys((*WHOLE, AXIS, *kinds.values()))
        },
        "models": {model.name: model.description for model in MODELS.values()},
        **({"models of other packages": of_users} if of_users else {}),
        "models of several sets on one shaft": {name: MODELS[name].label for name in AXIS_MODELS},
        "catalogues": dict(sorted(names_with_counts.items())),
        "printed_tables": {name: len(printed.load_printed_table(name)) for name in printed.printed_table_names()},
    }


def _shipped_contents_lines(data: Mapping[str, Any]) -> Iterator[str]:
    """Yield the lines in which the terminal shows shipped scenes, models and printed tables."""
    groups = {f"scenes, {kind}": titles for kind, titles in data["scenes"].items()}
    groups |= {group: entries for group, entries in data.items() if group != "scenes"}
    width = max(len(name) for group in groups.values() for name in group)
    for group, entries in groups.items():
        yield "makers' catalogues, with rollbench list --makers NAME" if group == "catalogues" else group.replace("_", " ")
        for name, text in entries.items():
            yield f"  {name:{width}}  {f'{text} rows' if group in ('catalogues', 'printed_tables') else text}"


@app.command(name="list")
def list_(*, makers: str | None = None, trace: Flag = False, table: Word = "", as_json: Json = False) -> None:
    """List the scenes, models and tables of printed numbers that are shipped with rollbench.

    Parameters
    ----------
    makers
        List the nuts and bearings in makers' catalogues whose maker, name or type has these words instead, such as R40,
        "THK double nut" or 7010C; rollbench new FILE --like NAME takes their names.
    trace
        List every printed number and claim instead, with the scenes from which it is computed (or the reason for none), the
        function that computes it, and its test.
    table
        List the numbers and claims of this printed table only, as --trace does.
    """
    if makers is not None:
        print_command_output(list_parts_in_catalogues(makers), as_json)
    elif trace or table:
        print_command_output(list_computations_of_printed_numbers(table), as_json)
    else:
        data = _shipped_contents_json()
        print_command_output(CommandOutput(data, _shipped_contents_lines(data)), as_json)
