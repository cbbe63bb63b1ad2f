"""A whole report against an earlier one, and its checksums."""

import json
import subprocess

import pytest
from tests.report_samples import paged

from rollbench.compare.errors import InputError
from rollbench.compare.provenance import SCENE, hashes_of_report_inputs
from rollbench.compare.report import changes
from rollbench.compare.scenes import catalogue
from rollbench.reports import manifest, pages
from rollbench.reports.content import Report, Section, Table, TableColumn

ERROR, TIME = TableColumn("x", "error", "%", ".2f"), TableColumn("t", "cold", "s", ".2f")
ROWS = (
    {"model": "lin", ERROR: 6.0, TIME: 1.0},
    {"model": "refined", ERROR: 0.8, TIME: 2.0},
    {"model": "refined", ERROR: 0.7, TIME: 2.0},
)
TABLE = Table.from_rows("errors", "Errors", ROWS)
TEXTS = {"two-balls": catalogue.shipped_scene_text("two-balls")}


def report(tmp_path, name: str, table: Table = TABLE):
    origin = {"rollbench": "1.0", "inputs": hashes_of_report_inputs((tmp_path / "store",), TEXTS)}
    whole = Report("a report", "", {}, paged(Section("s", "S", (table,))), origin=origin)
    return pages.write_report(whole, tmp_path / name).parent


def test_what_moved_but_measured_seconds_is_listed_by_the_texts_of_its_row(tmp_path):
    rows = [ROWS[2] | {ERROR: 0.77}, ROWS[0], {"model": "mei", ERROR: 20.0}, ROWS[1] | {ERROR: 0.8 * (1.0 + 1e-6)}]
    later, other = (Table.from_rows("errors", "Errors", found) for found in ([row | {TIME: 9.0} for row in ROWS], rows))
    all_of = (("a",), ("b", later), ("c", other))
    first, second, third = (changes.read_report_tables(report(tmp_path, *of)) for of in all_of)
    assert list(changes.report_differences(first, second)) == []
    assert list(changes.report_differences(first, third)) == [
        "errors: refined, error [%]: 0.8 became 0.77 (-3.75 %)",
        "errors: refined (2), error [%]: 0.7 became 0.800001 (+14.3 %)",
        "errors: mei: new row",
    ]
    damaged = tmp_path / "c" / "tables" / "errors.csv"
    damaged.write_text(damaged.read_text(encoding="utf-8") + "lin,6,1,7\n", encoding="utf-8")
    with pytest.raises(InputError, match="one cell for each column heading"):
        changes.read_report_tables(tmp_path / "c")
    assert list(changes.report_differences({"a": []}, {"b": []})) == ["a: table removed", "b: new table"]


def test_sha256sum_finds_what_was_changed_in_a_report(tmp_path):
    folder = report(tmp_path, "a")
    inputs = json.loads((folder / manifest.FILE).read_text(encoding="utf-8"))["inputs"]
    assert f"{SCENE}two-balls" in inputs

    def checked():
        done = subprocess.run(["sha256sum", "-c", "SHA256SUMS"], cwd=folder, capture_output=True, text=True, check=False)
        return done.returncode, done.stdout

    code, said = checked()
    files = {"index.html", "s.html", "search.js", "tables/errors.csv", "manifest.json"}
    assert (code, {line.removesuffix(": OK") for line in said.splitlines()}) == (0, files)
    (folder / "tables" / "errors.csv").write_text("changed", encoding="utf-8")
    code, said = checked()
    assert (code, [line for line in said.splitlines() if not line.endswith("OK")]) == (1, ["tables/errors.csv: FAILED"])
    with pytest.raises(InputError, match="against: "):
        changes.read_report_tables(tmp_path)
