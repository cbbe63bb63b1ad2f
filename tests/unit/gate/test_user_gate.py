"""`rollbench check SCENE...`: a user's scenes and loads against stored references; exit codes, files, refusals."""

import csv
import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

from rollbench.compare.errors import InputError, SceneNotCoveredError
from rollbench.compare.gate import user
from rollbench.compare.gate.publish import HEADINGS, VerdictFileRow, junit_xml, markdown_text, verdicts_csv, write_verdicts
from rollbench.compare.gate.user import GateRequest, check_scenes, gate_request, limits_for_scene
from rollbench.compare.models import loads_file
from rollbench.compare.models.registry import ModelOptions, run_model
from rollbench.compare.reference import estimate, jobs, store
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.meshes.parts import SIDES

TWO = catalogue.scene("two-balls")


def check(scenes: list, what: GateRequest):
    return check_scenes(scenes, what, jobs.ComputingSettings(), lambda _: None)


@pytest.mark.parametrize(("factor", "code", "word"), [(1.02, 0, "PASS"), (1.07, 3, "UNDECIDED"), (1.2, 1, "FAIL")])
def test_loads_of_another_program(command, tmp_path, factor: float, code: int, word: str) -> None:
    """The stored reference's own loads of the two balls, that of ball 2 SR (uncertain by 0.34 %) times a factor."""
    load, file = estimate.reference_of_scene(TWO).load.copy(), tmp_path / "mesys.csv"
    load[1, 1] *= factor
    lines = [f"{b + 1},{s},{load[b, k]:.6g}" for b in range(2) for k, s in enumerate(SIDES)]
    file.write_text("\n".join(["ball,flank,newton", *lines]) + "\n", encoding="utf-8")
    found, out, err = command("check", "two-balls", "--loads", str(file), "--no-compute", "--max-error", "7")
    assert (found, err) == (code, "")
    assert out.startswith(f"{word}: two-balls by mesys.csv; worst contact ")
    assert " % of the mean load off (ball" in out.splitlines()[0]
    assert re.search(rf"^{word.lower()} +largest error of a contact load +[\d.]+ % +0.\d\d % +7 %", out, re.MULTILINE)
    assert "in per cent of the contact's own load, or of the mean load if its own load is below a tenth of the mean" in out


def test_json_of_a_model_and_of_a_scene_without_reference(command, tmp_path) -> None:
    mine = tmp_path / "mine.toml"
    mine.write_text(catalogue.shipped_scene_text("two-balls").replace('"6 um"', '"6.1 um"'), encoding="utf-8")
    code, data = command.json("check", "two-balls", str(mine), "--stored", str(tmp_path), "--json")
    assert (code, data["verdict"], data["passed"]) == (4, "not covered", False)
    first, second = data["verdicts"]
    said = [first[key] for key in ("scene", "judged", "word", "levels")]
    assert said == ["two-balls", "refined", "pass", [2, 3, 4, 5]]
    assert first["error_percent"] < 1.0
    assert first["uncertainty_percent"] > 0.0
    assert (second["scene"], second["word"], second["error_percent"]) == ("mine", "not covered", None)


@pytest.mark.parametrize("name", ["two-balls", "double-nut"])
def test_a_renamed_copy_has_the_stored_reference(name: str) -> None:
    same, copy = (
        check([replace(catalogue.scene_of_any_kind(name), name=as_)], gate_request(model="lin", compute=False))
        for as_ in (name, "my copy")
    )
    assert {v.scene for v in copy} == {"my copy"}
    assert [(v.word, v.error, v.uncertainty) for v in copy] == [(v.word, v.error, v.uncertainty) for v in same]
    assert all(v.error is not None for v in copy)


def test_a_scene_may_set_its_own_limits() -> None:
    text = catalogue.shipped_scene_text("two-balls") + "\n[gate]\nmax_error = 0.4\nrms_error = 1\n"
    scene = scene_file.scene_from_text(text, "two-balls.toml")
    assert scene == TWO, "limits are no part of what is solved and stored"
    assert store.content_key_of_run(scene, "", {}, (0, 3)) == store.content_key_of_run(TWO, "", {}, (0, 3))
    stated, given = limits_for_scene(scene, None), limits_for_scene(scene, 9.0)
    assert (stated.largest_load_error, stated.rms_load_error, given.largest_load_error) == (0.4, 1.0, 9.0)
    assert limits_for_scene(TWO, None).largest_load_error == 7.0
    verdicts = check([scene], gate_request(compute=False))
    assert [(v.word, v.limit_percent) for v in verdicts] == [("undecided", 0.4), ("pass", 1.0)]


def test_missing_levels_are_computed_by_geometry_and_a_refusal_is_not_covered(monkeypatch, tmp_path) -> None:
    planned: list[tuple[list[str], list[int]]] = []

    def refused(tasks, *_: object, **__: object) -> list[object]:
        planned.append((sorted({s.name for t in tasks for s in t.scenes}), sorted({t.level for t in tasks})))
        raise SceneNotCoveredError("mine", "3D reference", "no room for the contact", "deepen the groove")

    monkeypatch.setattr(user, "ensure_runs_are_stored", refused)
    text = catalogue.shipped_scene_text("two-balls").replace('"6 um"', '"6.1 um"')
    first, second = check(
        [scene_file.scene_from_text(text, "mine.toml"), TWO], GateRequest((tmp_path, gate_request().stores[1]))
    )
    assert planned == [(["mine"], [1, 2])], "the stored reference of the other is not computed again"
    assert (first.word, "no room for the contact" in first.detail) == ("not covered", True)
    assert second.word == "pass"


def test_a_model_that_does_not_converge_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    real = user.run_model
    monkeypatch.setattr(user, "run_model", lambda *a: replace(real(*a), status="no equilibrium"))
    (verdict,) = check([TWO], gate_request(model="lin", compute=False))
    assert (verdict.word, verdict.error_percent) == ("fail", None)
    assert verdict.line() == "FAIL: two-balls, lin: the model computed no loads: no equilibrium"


GOOD = "ball,flank,newton\n1,SL,100\n1,NR,90.5\n2,sl,0\n2,NR,80\n"


SAVED = ["\ufeff" + GOOD, GOOD.replace(",", "\t"), GOOD.replace("\n", "\r\n") + "\n\n"]
ORDERED = "flank,newton,ball,note\nSL,100,1,x\nNR,90.5,1,\nSL,0,2\nNR,80,2,y\n"


@pytest.mark.parametrize("text", [GOOD, *SAVED, GOOD.replace(",", ";").replace(".", ","), ORDERED])
def test_spreadsheets_as_they_are_saved(tmp_path, text: str) -> None:
    (tmp_path / "a.csv").write_text(text, encoding="utf-8", newline="")
    found = loads_file.read_loads(tmp_path / "a.csv", 2)
    assert found.flanks_with_rows == ("SL", "NR")
    np.testing.assert_array_equal(found.load, [[100.0, 0.0, 0.0, 90.5], [0.0, 0.0, 0.0, 80.0]])


FAULTY = [
    ("ball,", "index,", "line 1", "a column ball"),
    ("1,SL,100", "3,SL,100", "line 2: ball", "1 to 2"),
    ("1,SL,100", "0,SL,100", "line 2: ball", "1 to 2"),
    ("1,SL,100", "1,left,100", "line 2: flank", "SL, SR, NL, NR"),
    ("1,SL,100", "1,SL,-100", "line 2: newton", "at least 0"),
    ("1,SL,100", "1,SL,nan", "line 2: newton", "at least 0"),
    ("1,SL,100", "1,SL,100 N", "line 2: newton", "without unit"),
    ("1,SL,100", "1,SL", "line 2: newton", "nothing"),
    ("2,sl,0\n", "", "rows", "no load of ball 2 SL"),
    ("2,NR,80", "1,NR,80", "line 5", "ball 1 NR"),
    (GOOD, "", "line 1", "ball,flank,newton"),
    (GOOD, "ball,flank,newton\n", "file", "no loads"),
]


@pytest.mark.parametrize(("old", "new", "key", "words"), FAULTY)
def test_faulty_loads_are_refused_by_line(tmp_path, old: str, new: str, key: str, words: str) -> None:
    (tmp_path / "a.csv").write_text(GOOD.replace(old, new), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        loads_file.read_loads(tmp_path / "a.csv", 2)
    assert caught.value.key == key
    assert words in str(caught.value)


GREEN = VerdictFileRow(True, "pass", "mine", "a|b", "largest error", 8.5, 1.0, 7.0, "%", 2, "NR")
ROWS = [GREEN, replace(GREEN, good=False, word="fail", note="=1+1 <b>")]


def test_junit_is_green_only_where_it_passes() -> None:
    suite = ElementTree.fromstring(junit_xml(ROWS))
    assert (suite.get("tests"), suite.get("failures")) == ("2", "1")
    none, failure = (case.find("failure") for case in suite.iter("testcase"))
    assert (none, failure.get("type")) == (None, "fail")
    assert "error %: 8.5; uncertainty %: 1; limit %: 7" in str(failure.get("message"))


def test_markdown_and_csv(tmp_path) -> None:
    text = markdown_text(ROWS)
    lines = text.splitlines()
    assert lines[0] == "### rollbench check: 1 pass, 1 fail"
    assert lines[4].startswith("| fail | mine | a\\|b |"), "what is not green comes first"
    assert "<b>" not in text
    widths = {len(re.findall(r"(?<!\\)\|", line)) for line in lines[2:]}
    assert widths == {len(HEADINGS) + 1}
    rows = list(csv.reader(verdicts_csv(ROWS).splitlines()))
    assert (rows[0], rows[2][-1]) == (list(HEADINGS), "'=1+1 <b>")
    summary, other = tmp_path / "summary.md", tmp_path / "b.csv"
    summary.write_text("before\n", encoding="utf-8")
    files = {"markdown_file": tmp_path / "a.md", "junit_file": tmp_path / "a.xml", "csv_file": tmp_path / "a.csv"}
    environment = {"GITHUB_STEP_SUMMARY": str(summary)}
    assert set(write_verdicts(ROWS, **files, environment=environment)) == {*files.values(), summary}
    assert summary.read_text(encoding="utf-8") == "before\n" + text
    assert write_verdicts(ROWS, csv_file=other, environment=environment) == [other]


def solved_loads(command, folder) -> list[dict[str, str]]:
    assert command("solve", "lin-case1", "--model", "lin", "--loads-csv", folder / "loads.csv").code == 0
    with (folder / "loads.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def judged(folder, rows: list[dict[str, str]], *drop: str):
    heads = [head for head in rows[0] if head not in drop]
    lines = [",".join(heads), *(",".join(row[head] for head in heads) for row in rows)]
    (folder / "given.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    what = gate_request(loads=folder / "given.csv", max_error=8.0, store=folder / "none", compute=False)
    (found,) = check([catalogue.scene("lin-case1")], what)
    return found


def changed(rows: list[dict[str, str]], column: str, of) -> list[dict[str, str]]:
    """Rows with another value in a column."""
    return [row | {column: str(of(row[column]))} for row in rows]


def turned(ball: str) -> int:
    """Number of a ball counted from the other end."""
    return 33 - int(ball)


def test_loads_that_solve_writes_are_those_that_check_reads(command, tmp_path) -> None:
    rows = solved_loads(command, tmp_path)
    text = (tmp_path / "loads.csv").read_text(encoding="utf-8")
    assert (text.splitlines()[0], "#" in text, len(rows)) == ("ball,flank,newton,azimuth_deg,z_mm", False, 32 * 4)
    result = run_model(catalogue.scene("lin-case1"), "lin", ModelOptions())
    given = loads_file.read_loads(tmp_path / "loads.csv", 32, catalogue.scene("lin-case1"))
    np.testing.assert_array_equal(given.load, result.load)
    assert given.renumbered_ball_count == 0
    found = judged(tmp_path, rows)
    assert (found.word, found.detail) == ("pass", "")


def test_balls_are_matched_by_azimuth_and_station(command, tmp_path) -> None:
    rows = solved_loads(command, tmp_path)
    found, right = judged(tmp_path, changed(rows, "ball", turned)), judged(tmp_path, rows)
    assert found.error_percent == right.error_percent
    assert "32 balls are numbered differently in the file" in found.detail
    named = judged(tmp_path, changed(rows, "ball", "b".__add__))
    assert named.error_percent == right.error_percent, "with places, a number may be any name"
    with pytest.raises(InputError, match="the position of a ball; the nearest"):
        judged(tmp_path, changed(rows, "z_mm", lambda z: float(z) + 5.0))
    with pytest.raises(InputError, match="line 2: z_mm: got x"):
        judged(tmp_path, [rows[0] | {"z_mm": "x"}, *rows[1:]])


def test_what_loads_look_like_is_said_and_a_file_of_several_cases_is_refused(command, tmp_path) -> None:
    rows, places = solved_loads(command, tmp_path), ("azimuth_deg", "z_mm")
    found = judged(tmp_path, changed(rows, "newton", lambda x: 1e-3 * float(x)))
    assert (found.word, "look like kilonewtons" in found.line()) == ("fail", True)
    found = judged(tmp_path, changed(rows, "ball", turned), *places)
    assert "numbered in reverse order: add the columns azimuth_deg and z_mm" in found.detail
    shifted = judged(tmp_path, changed(rows, "ball", lambda ball: int(ball) % 32 + 1), *places)
    assert shifted.word == "pass" or "look numbered" in shifted.detail
    other = {"SL": "SR", "SR": "SL", "NL": "NR", "NR": "NL"}
    assert "opposite flanks" in judged(tmp_path, changed(rows, "flank", other.__getitem__)).detail
    wrong = judged(tmp_path, changed(rows, "newton", lambda x: 1.5 * float(x)))
    assert (wrong.word, wrong.detail) == ("fail", "")
    judged(tmp_path, [{"case": "1"} | row for row in rows])
    with pytest.raises(InputError, match="line 6: case: got 2"):
        judged(tmp_path, [{"case": row["ball"]} | row for row in rows])


def test_several_sets_write_their_loads_with_their_number(command, tmp_path) -> None:
    command("solve", "double-nut", "--model", "lin", "--loads-csv", tmp_path / "a.csv")
    lines = (tmp_path / "a.csv").read_text(encoding="utf-8").splitlines()
    assert (lines[0], len(lines)) == ("set,ball,flank,newton,azimuth_deg,z_mm", 1 + 2 * 68 * 4)
    assert (lines[1][:7], lines[-1][:8]) == ("1,1,SL,", "2,68,NR,")
