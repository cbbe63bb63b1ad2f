"""The README's table is the report's table, and its two commands are there to be typed."""

import csv
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def test_table_is_the_report_s() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    lines = text.split("<!-- table: cases-choices -->")[1].strip().split("\n\n")[0].splitlines()[2:]
    with open(ROOT / "reports" / "validation" / "tables" / "cases-choices.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(lines) == len(rows) >= 10
    for line, row in zip(lines, rows, strict=True):
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        values = list(row.values())
        assert cells[0] == values[0]
        for cell, value in zip(cells[1:], values[1:6], strict=True):
            decimals = len(cell.split(".")[1])
            assert cell == f"{float(value):.{decimals}f}"


def test_report_s_table_is_what_the_model_gives_now() -> None:
    from compare.sections.cases import choices
    from compare.study import Study

    with open(ROOT / "reports" / "validation" / "tables" / "cases-choices.csv", encoding="utf-8", newline="") as file:
        stored = list(csv.DictReader(file))
    for row, old in zip(choices(Study()), stored, strict=True):
        assert abs(float(row["max"]) - float(old["max [N]"])) < 1e-6 * float(old["max [N]"])


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
