"""A whole report against an earlier one, and its hashes computed again."""

import json
from dataclasses import replace

import pytest
from tests.report_samples import paged

from rollbench.compare.errors import InputError
from rollbench.compare.provenance import SCENE, hashes_of_report_inputs
from rollbench.compare.report import verify
from rollbench.compare.scenes import catalogue
from rollbench.reports import manifest, pages
from rollbench.reports.content import Report, Section, Table, TableColumn

COLUMNS = (TableColumn("m", "model", "", "s"), TableColumn("x", "error", "%", ".2f"), TableColumn("t", "cold", "s", ".2f"))
ROWS = ({"m": "lin", "x": 6.0, "t": 1.0}, {"m": "refined", "x": 0.8, "t": 2.0}, {"m": "refined", "x": 0.7, "t": 2.0})
TABLE = Table("errors", "Errors", COLUMNS, ROWS)
TEXTS = {"two-balls": catalogue.shipped_scene_text("two-balls")}


def report(tmp_path, name: str, table: Table = TABLE):
    origin = {"rollbench": "1.0", "inputs": hashes_of_report_inputs((tmp_path / "store",), TEXTS)}
    whole = Report("a report", "", {}, paged(Section("s", "S", (table,))), origin=origin)
    return pages.write_report(whole, tmp_path / name).parent


def test_what_moved_but_measured_seconds_is_listed_by_the_texts_of_its_row(tmp_path):
    rows = [ROWS[2] | {"x": 0.77}, ROWS[0], {"m": "mei", "x": 20.0}, ROWS[1] | {"x": 0.8 * (1.0 + 1e-6)}]
    later, other = (replace(TABLE, rows=found) for found in ([{**row, "t": 9.0} for row in ROWS], rows))
    first, second, third = (verify.read_report_tables(report(tmp_path, *of)) for of in (("a",), ("b", later), ("c", other)))
    assert list(verify.report_differences(first, second)) == []
    assert list(verify.report_differences(first, third)) == [
        "errors: refined, error [%]: 0.8 became 0.77 (-3.75 %)",
        "errors: refined (2), error [%]: 0.7 became 0.800001 (+14.3 %)",
        "errors: mei: new row",
    ]
    damaged = tmp_path / "c" / "tables" / "errors.csv"
    damaged.write_text(damaged.read_text(encoding="utf-8") + "lin,6,1,7\n", encoding="utf-8")
    with pytest.raises(InputError, match="one cell for each column heading"):
        verify.read_report_tables(tmp_path / "c")
    assert list(verify.report_differences({"a": []}, {"b": []})) == ["a: table removed", "b: new table"]


def test_a_report_is_verified_by_its_manifest_and_what_is_none_is_refused(tmp_path):
    (tmp_path / "store").mkdir()
    (tmp_path / "store" / "run.json").write_text("{}", encoding="utf-8")
    folder = report(tmp_path, "a")
    stated = json.loads((folder / manifest.FILE).read_text(encoding="utf-8"))
    assert {"index.html", "s.html", "search.js", "tables/errors.csv"} == set(stated["files"])
    assert f"{SCENE}two-balls" in stated["inputs"]
    assert {row.comparison_result for row in verify.check_report_hashes(folder, (tmp_path / "store",))} == {"ok"}
    assert verify.verify_report_hashes(folder / "index.html", tmp_path / "store").exit_code == 0
    (folder / "tables" / "errors.csv").write_text("changed", encoding="utf-8")
    (folder / "s.html").unlink()
    (folder / "more.txt").write_text("added", encoding="utf-8")
    (tmp_path / "store" / "run.json").write_text("[]", encoding="utf-8")
    found = {row.name: row.comparison_result for row in verify.check_report_hashes(folder, (tmp_path / "store",))}
    changed = dict.fromkeys(("tables/errors.csv", "reference run.json"), "changed")
    wrong = {name: result for name, result in found.items() if result != "ok"}
    assert wrong == {**changed, "s.html": "missing", "more.txt": "added"}
    said = verify.verify_report_hashes(folder, tmp_path / "store")
    assert (said.exit_code, len(list(said.texts_and_tables))) == (1, 5)

    (folder / manifest.FILE).write_text("{}", encoding="utf-8")
    with pytest.raises(InputError, match="damaged"):
        list(verify.check_report_hashes(folder, ()))
    with pytest.raises(InputError, match="against: "):
        verify.read_report_tables(tmp_path)
