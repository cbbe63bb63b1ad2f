"""The README's table is the report's table, and its two commands are there to be typed."""

import csv
import io
import re
from pathlib import Path
from statistics import median

from tests.copies import ROOT, of_report

README = (ROOT / "README.md").read_text(encoding="utf-8")


def stored(name: str) -> list[dict[str, str]]:
    text = (ROOT / "reports" / "validation" / "tables" / f"{name}.csv").read_text(encoding="utf-8")
    return list(csv.DictReader(io.StringIO(text, newline="")))


def _percentiles(model: str) -> tuple[float, float]:
    """Median and 95th percentile of the largest error on the screws that were drawn after the models last changed."""
    row = next(r for r in stored("stability-unseen") if (r["model"], r["screws"]) == (model, "drawn later"))
    assert f"On {row['number of screws']} randomly drawn screws" in README
    names = ("median", "95th percentile")
    median_error, most = (
        next(float(v) for k, v in row.items() if k.startswith(f"largest contact-load error, {n}")) for n in names
    )
    return median_error, most


def _unseen(model: str) -> tuple[float, float]:
    """Median and largest error on the screws that were fixed before they were solved."""
    rows = [r for r in stored("ladder") if r["model"] == model and r["scene"].startswith("unseen")]
    assert len(rows) == 11
    errors = [float(r["largest contact-load error [% of mean load]"]) for r in rows]
    return median(errors), max(errors)


@of_report
def test_table_and_first_sentence_are_the_report_s() -> None:
    refined, lin = _percentiles("refined"), _percentiles("lin")
    for model, found in (("refined", refined), ("lin", lin), ("condensed", _unseen("condensed"))):
        row = next(line for line in README.splitlines() if line.startswith(f"| `{model}`"))
        assert row.split("|")[2].split("(")[0].strip() == "{:.1f} / {:.1f}".format(*found), row
    timed = {r["model or mesh level"]: r for r in stored("stability-levels")}
    for name, of in (("`refined`", "refined"), ("`lin`", "lin"), ("3D reference", "3D level 1")):
        row = next(line for line in README.splitlines() if line.startswith(f"| {name}"))
        seconds = float(timed[of]["CPU time for a new screw, median [s]"])
        assert row.split("|")[3].split("(")[0].strip() == f"{seconds:.2g} s", row
        assert f"median on {timed[of]['number of screws']} of them" in README
    first = " ".join(README.split("\n\n")[1].split())
    assert "{:.1f} % of the mean contact load in the median and by at most {:.1f} % on 19 of 20".format(*refined) in first
    assert "by {:.1f} and {:.0f} %".format(*lin) in first
    bars = {f"{float(row['mesh uncertainty of the 3D reference [% of mean load]']):.1f} %" for row in stored("ladder")}
    assert bars == {"0.1 %"}
    assert "by its mesh, is 0.1 % of the mean load" in first


@of_report
def test_shown_output_is_what_is_printed(tmp_path: Path, monkeypatch, command) -> None:
    monkeypatch.chdir(tmp_path)
    command.said("new", "my.toml", "--like", "40x10")
    printed = " ".join(command.said("solve", "my.toml").split())
    shown = README.split("<!-- output: solve my.toml -->")[1].split("```")[1].removeprefix("text").strip().splitlines()
    assert len(shown) >= 4
    for line in shown:
        assert " ".join(line.split()) in printed


@of_report
def test_report_s_tables_are_what_the_models_give_now() -> None:
    from rollbench.compare.cases.lin.evidence.chapter_2 import model_choice_rows
    from rollbench.compare.models.comparison import REFERENCED
    from rollbench.compare.models.study import SceneResultCache
    from rollbench.compare.sections.reference import load_error_table
    from rollbench.reports.content import Table

    study = SceneResultCache()
    computed = Table.from_rows("cases-choices", "", model_choice_rows(study))
    for row, old in zip(computed.rows, stored("cases-choices"), strict=True):
        before = float(old["largest contact load [N]"])
        assert abs(float(row["largest_load"]) - before) < 1e-6 * before
    table = load_error_table(study, study.stored_references(REFERENCED))
    for row, old in zip(table.rows, stored("reference-errors"), strict=True):
        assert (row["scene"], row["model"]) == (old["scene"], old["model"])
        if row["largest_load_error"] is not None:
            assert abs(float(row["largest_load_error"]) - float(old["largest contact-load error [% of mean load]"])) < 1e-4


@of_report
def test_one_page_with_exactly_two_set_up_commands_whose_linked_files_exist() -> None:
    assert len(README.splitlines()) <= 80
    assert len(README.split()) <= 900
    for target in re.findall(r"\]\((?!\.\./\.\./actions/)([^)]+)\)", README):  # pages of the site that hosts the project
        assert (ROOT / target.partition("#")[0]).exists(), target
    commands = [line.strip() for line in README.splitlines() if "pip install" in line]
    assert len(commands) == 2
    assert commands[0].endswith("rollbench report")
    assert commands[1].endswith("pytest")


@of_report
def test_paths_that_contributing_names_exist() -> None:
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    named = {m for m in re.findall(r"`([\w.-]+(?:/[\w.-]+)+/?)`", text) if not m.startswith(".venv")}
    assert len(named) > 20
    assert {m for m in named if not any((ROOT / root / m).exists() for root in ("", "compare", "lowfi"))} == set()
