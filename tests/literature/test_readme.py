"""The README's table is the report's table, and its two commands are there to be typed."""

import csv
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def stored(name: str) -> list[dict[str, str]]:
    path = ROOT / "reports" / "validation" / "tables" / f"{name}.csv"
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_table_is_the_report_s() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    lines = text.split("<!-- table: reference-errors -->")[1].strip().split("\n\n")[0].splitlines()
    heads = [cell.strip() for cell in lines[0].strip().strip("|").split("|")]
    columns = {
        "largest %": "largest error [% of mean]",
        "at": "at ball",
        "RMS %": "RMS error [% of mean]",
        "own load, largest %": "largest error [% of own load]",
        "printed %": "printed max / RMS [%]",
    }
    rows = {(row["scene"], row["model"]): row for row in stored("reference-errors")}
    # the grid's, named "reference's uncertainty" up to version 0.3.0
    columns["uncertainty %"] = next(key for key in next(iter(rows.values())) if key.endswith(" uncertainty [% of mean]"))
    assert len(lines) >= 10
    for line in lines[2:]:
        cells = dict(zip(heads, (cell.strip() for cell in line.strip().strip("|").split("|")), strict=True))
        row = rows[cells["scene"], cells["model"]]
        for head, key in columns.items():
            shown = cells[head]
            decimals = len(shown.split(".")[1]) if "." in shown and "/" not in shown else 0
            assert shown == (f"{float(row[key]):.{decimals}f}" if decimals else row[key]), (line, head)


def test_report_s_tables_are_what_the_models_give_now() -> None:
    from rollbench.comparison.models.study import Study
    from rollbench.comparison.sections.reference import case_studies, error_table
    from rollbench.comparison.sources.lin.evidence.choices_2_4_1 import choices
    from rollbench.comparison.sources.lin.sections.cases import choice_rows
    from rollbench.reports.records import Table

    study = Study()
    computed = Table.of("cases-choices", "", choice_rows(choices(study)))
    for row, old in zip(computed.rows, stored("cases-choices"), strict=True):
        assert abs(float(row["max"]) - float(old["max [N]"])) < 1e-6 * float(old["max [N]"])
    table = error_table(study, case_studies(study))
    for row, old in zip(table.rows, stored("reference-errors"), strict=True):
        assert (row["scene"], row["model"]) == (old["scene"], old["model"])
        if row.get("max") is not None:
            assert abs(float(row["max"]) - float(old["largest error [% of mean]"])) < 1e-4


def test_exactly_two_set_up_commands() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    commands = [line.strip() for line in text.splitlines() if "pip install" in line]
    assert len(commands) == 2
    assert commands[0].endswith("rollbench report")
    assert commands[1].endswith("pytest")


def test_linked_files_exist() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)]+)\)", text):
        assert (ROOT / target).exists(), target


def test_a_user_s_screw_stands_before_the_results_of_the_thesis() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert text.index("Lin (2019)") < text.index("## Your own screw") < text.index("## A result")
    assert text.index("(SL, SR)") < text.index("--loads")


def test_paths_that_contributing_names_exist() -> None:
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    named = {m for m in re.findall(r"`([\w.-]+(?:/[\w.-]+)+/?)`", text) if not m.startswith(".venv")}
    assert len(named) > 30
    assert {m for m in named if not any((ROOT / root / m).exists() for root in ("", "compare", "lowfi"))} == set()
