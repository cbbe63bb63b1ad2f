"""`rollbench check SCENE...`: a user's scenes and loads against stored references; exit codes, files, refusals."""

import csv
from dataclasses import replace

import numpy as np
import pytest
from tests.slow import all_slow_but

from rollbench.compare.errors import InputError, SceneNotCoveredError
from rollbench.compare.gate import user
from rollbench.compare.gate.user import GateRequest, check_scenes, limits_for_scene
from rollbench.compare.models import loads_file
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import run_model
from rollbench.compare.reference import estimate, jobs
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
    found, out, err = command("check", "two-balls", "--loads", file, "--no-compute", "--max-error", "7")
    assert (found, err) == (code, "")
    assert out.startswith(f"{word}: two-balls by mesys.csv; ")


@pytest.mark.parametrize("name", all_slow_but(["two-balls"], ["two-balls", "double-nut"]))
def test_a_renamed_copy_has_the_stored_reference(name: str) -> None:
    scene, what = catalogue.scene_of_any_kind(name), GateRequest(model="lin", compute=False)
    same, copy = check([scene], what), check([replace(scene, name="my copy")], what)
    assert copy == [replace(verdict, scene="my copy") for verdict in same]
    assert all(v.error is not None for v in copy)


def test_a_scene_may_set_its_own_limits() -> None:
    text = catalogue.shipped_scene_text("two-balls") + "\n[gate]\nmax_error = 0.4\nrms_error = 1\n"
    scene = scene_file.scene_from_text(text, "two-balls.toml")
    assert scene == TWO, "limits are no part of what is solved and stored"
    assert limits_for_scene(scene, 9.0).largest_load_error == 9.0
    assert limits_for_scene(TWO, None).largest_load_error == 7.0
    verdicts = check([scene], GateRequest(compute=False))
    assert [(v.judgement, v.limit) for v in verdicts] == [("undecided", 0.4), ("pass", 1.0)]


def test_missing_levels_are_computed_by_geometry_and_a_refusal_is_not_covered(monkeypatch, tmp_path) -> None:
    planned: list[tuple[str, int]] = []

    def refused(tasks, *_: object, **__: object) -> list[object]:
        planned.extend((s.name, t.level) for t in tasks for s in t.scenes)
        raise SceneNotCoveredError("mine", "3D reference", "no room for the contact", "deepen the groove")

    monkeypatch.setattr(user, "ensure_runs_are_stored", refused)
    text = catalogue.shipped_scene_text("two-balls").replace('"6 um"', '"6.1 um"')
    mine = scene_file.scene_from_text(text, "mine.toml")
    first, second = check([mine, TWO], GateRequest(store=tmp_path))
    assert sorted(planned) == [("mine", 1), ("mine", 2)], "the stored reference of the other is not computed again"
    assert (first.judgement, "no room for the contact" in first.detail) == ("not covered", True)
    assert second.judgement == "pass"


def solved_loads(command, folder) -> list[dict[str, str]]:
    command.said("solve", "lin-case1", "--model", "lin", "--loads-csv", folder / "loads.csv")
    return list(csv.DictReader((folder / "loads.csv").read_text(encoding="utf-8").splitlines()))


def judged(folder, rows: list[dict[str, str]]):
    heads = [*rows[0]]
    lines = [",".join(heads), *(",".join(row[head] for head in heads) for row in rows)]
    (folder / "given.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    what = GateRequest(loads=folder / "given.csv", max_error=8.0, store=folder / "none", compute=False)
    (found,) = check([catalogue.scene("lin-case1")], what)
    return found


def changed(rows: list[dict[str, str]], column: str, of) -> list[dict[str, str]]:
    """Rows with another value in a column."""
    return [row | {column: str(of(row[column]))} for row in rows]


def turned(ball: str) -> int:
    """Number of a ball counted from the other end."""
    return 33 - int(ball)


def test_loads_that_solve_writes_are_those_that_check_reads(command, tmp_path) -> None:
    rows, scene = solved_loads(command, tmp_path), catalogue.scene("lin-case1")
    assert (list(rows[0]), len(rows)) == (["ball", "flank", "newton", "azimuth_deg", "z_mm"], 32 * 4)
    given = loads_file.read_loads(tmp_path / "loads.csv", scene)
    np.testing.assert_array_equal(given.load, run_model(scene, "lin", ModelOptions()).load)
    assert given.renumbered_ball_count == 0
    found = judged(tmp_path, rows)
    assert (found.judgement, found.detail) == ("pass", "")


def test_balls_are_matched_by_azimuth_and_station(command, tmp_path) -> None:
    rows = solved_loads(command, tmp_path)
    found, right = judged(tmp_path, changed(rows, "ball", turned)), judged(tmp_path, rows)
    assert found.error == right.error
    assert "32 balls are numbered differently in the file" in found.detail
    named = judged(tmp_path, changed(rows, "ball", "b".__add__))
    assert named.error == right.error, "with places, a number may be any name"
    with pytest.raises(InputError, match="the position of a ball; the nearest"):
        judged(tmp_path, changed(rows, "z_mm", lambda z: float(z) + 5.0))
    with pytest.raises(InputError, match="line 2: z_mm: got x"):
        judged(tmp_path, [rows[0] | {"z_mm": "x"}, *rows[1:]])


def test_what_loads_look_like_is_said_and_a_file_of_several_cases_is_refused(command, tmp_path) -> None:
    rows = solved_loads(command, tmp_path)
    found = judged(tmp_path, changed(rows, "newton", lambda x: 1e-3 * float(x)))
    assert (found.judgement, "look like kilonewtons" in found.line) == ("fail", True)
    judged(tmp_path, [{"case": "1"} | row for row in rows])
    with pytest.raises(InputError, match="line 6: case: got 2"):
        judged(tmp_path, [{"case": row["ball"]} | row for row in rows])
