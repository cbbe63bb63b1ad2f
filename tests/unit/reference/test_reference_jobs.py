"""Jobs of the 3D reference: plan, what is missing, what is kept and told, levels of the command line."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.reference_records import bodies_of, run_of

from rollbench.compare.commands import compare as study
from rollbench.compare.commands.compare import exit_code_of_references, parse_levels
from rollbench.compare.commands.mesh_study import study_mesh_levels
from rollbench.compare.errors import InputError
from rollbench.compare.gate.verdict import ErrorLimits, judge_contact_loads
from rollbench.compare.models.uncertainty import uncertainty_of_loads
from rollbench.compare.reference import jobs
from rollbench.compare.reference.estimate import reference_from_runs
from rollbench.compare.reference.store import Run, load_stored_run, path_of_bodies, path_of_run, save_run, shipped_store
from rollbench.compare.reference.tasks import ReferenceTask
from rollbench.compare.results.compared import reference_uncertainty_text
from rollbench.compare.results.comparison import error_for_unconverged_reference
from rollbench.compare.scenes import catalogue
from rollbench.meshes.condensed import CondensedBodies


def test_a_task_without_its_bodies_is_missing(tmp_path: Path) -> None:
    scene = catalogue.scene("lin-case1")
    task, run = ReferenceTask((scene,), 1), run_of("lin-case1", 1, np.ones((32, 4)))
    save_run(tmp_path, scene, run)
    assert jobs.tasks_without_stored_runs([task], (tmp_path,)) == [task]
    jobs.store_runs_and_condensed_bodies(tmp_path, task, [run], bodies_of(scene, 1))
    assert jobs.tasks_without_stored_runs([task], (tmp_path,)) == []


def test_plan_and_what_is_missing(tmp_path: Path) -> None:
    scenes = [catalogue.scene(n) for n in ("lin-case1", "lin-case2")]
    tasks = jobs.plan_reference_tasks(scenes, (1, 2), ("land",), leave_out_each_part=True)
    planned = {(t.level, t.variant, t.leave_out_each_part, len(t.scenes)) for t in tasks}
    assert planned == {(1, "", True, 2), (2, "", False, 2), (1, "land", False, 1)}
    loads = np.ones((32, 4))
    save_run(tmp_path, scenes[0], run_of("lin-case1", 2, loads))
    save_run(tmp_path, scenes[1], replace(run_of("lin-case2", 1, loads), without={}))
    left = {(t.level, t.variant): [s.name for s in t.scenes] for t in jobs.tasks_without_stored_runs(tasks, (tmp_path,))}
    assert left == {(1, ""): ["lin-case1", "lin-case2"], (2, ""): ["lin-case2"], (1, "land"): ["lin-case1"]}


def test_the_coarsest_level_comes_first_and_is_told() -> None:
    scene = catalogue.scene("lin-case1")
    assert [t.level for t in jobs.plan_reference_tasks([scene], (1, 2, 3), with_source_mesh=True)] == [1, 3, 2, 0]


@pytest.mark.parametrize("command", ["compare", "mesh-study"])
def test_commands_print_the_coarsest_level_first(command: str, tmp_path: Path, monkeypatch, capsys) -> None:
    known = {k: load_stored_run(catalogue.scene("lin-case1"), k, stores=(shipped_store(),)) for k in (1, 2)}
    monkeypatch.setattr(jobs, "compute_runs_and_bodies", lambda task, _: ([known[task.level]], None))
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    engine = jobs.ComputingSettings()
    if command == "compare":
        study.compare_and_report(("lin-case1",), (), (1, 2), tmp_path, engine, fresh=True)
    else:
        study_mesh_levels(("lin-case1",), 2, tmp_path, engine, fresh=True, spread=False, source=False)
    said = capsys.readouterr().err
    assert "[############............] [1/2]" in said, "half of the bar"
    words = {"compare": "error of refined: ", "mesh-study": "largest load, SL"}[command]
    assert said.index("[1/2] lin-case1: level 1") < said.index(words) < said.index("[2/2]")


def test_each_job_is_stored_when_it_is_done(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scenes = [catalogue.scene("lin-case1")]
    said: list[str] = []

    def fake(task: ReferenceTask, _: object) -> tuple[list[Run], CondensedBodies]:
        if task.level == 2:
            raise KeyboardInterrupt
        return [run_of("lin-case1", task.level, np.ones((32, 4)))], bodies_of(scenes[0], task.level)

    monkeypatch.setattr(jobs, "compute_runs_and_bodies", fake)
    tasks = [ReferenceTask((scenes[0],), level) for level in (1, 2)]
    with pytest.raises(KeyboardInterrupt):
        jobs.ensure_runs_are_stored(tasks, tmp_path, jobs.ComputingSettings(), said.append)
    run = run_of("lin-case1", 1, np.ones((32, 4)))
    kept = {path_of_run(tmp_path, scenes[0], run).name, path_of_bodies(tmp_path, scenes[0], run).name}
    assert {p.name for p in tmp_path.iterdir()} == kept
    assert jobs.tasks_without_stored_runs(tasks, (tmp_path,)) == [tasks[1]]
    assert any("[1/2]" in line and "s left" in line for line in said)


def test_a_run_that_did_not_converge_is_told_and_computed_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = catalogue.scene("lin-case1")
    said: list[str] = []
    reason = "a contact reaches the rim of its patch: it needs 1.6 mm,\nhas 1.5 mm"
    failed = replace(run_of("lin-case1", 1, np.ones((32, 4))), status=reason)
    monkeypatch.setattr(jobs, "compute_runs_and_bodies", lambda *_: ([failed], None))
    found = jobs.ensure_runs_are_stored([ReferenceTask((scene,), 1)], tmp_path, jobs.ComputingSettings(), said.append)
    assert [run.status for run in found] == [reason]
    assert list(tmp_path.iterdir()) == []
    assert all("\n" not in line for line in said)
    assert any("it needs 1.6 mm, has 1.5 mm" in line for line in said)
    assert len(jobs.tasks_without_stored_runs([ReferenceTask((scene,), 1)], (tmp_path,))) == 1
    words = str(error_for_unconverged_reference("lin-case1", found))
    assert "level 1: a contact reaches the rim of its patch: it needs 1.6 mm, has 1.5 mm" in words
    assert "\n" not in words


def test_a_run_that_did_not_settle_is_kept_with_what_it_may_move_by(tmp_path: Path, monkeypatch) -> None:
    scene, said = catalogue.scene("lin-case1"), list[str]()
    status = "not settled: loads may still move by 0.5 N after 30 updates of directions and gaps"
    first, good = run_of("lin-case1", 1, np.full((32, 4), 99.0)), run_of("lin-case1", 2, np.full((32, 4), 100.0))
    monkeypatch.setattr(jobs, "compute_runs_and_bodies", lambda *_: ([replace(first, status=status, moving=0.5)], None))
    assert jobs.ensure_runs_are_stored([ReferenceTask((scene,), 1)], tmp_path, jobs.ComputingSettings(), said.append) == []
    assert any(status in line and "not stored" not in line for line in said)
    kept = load_stored_run(scene, 1, stores=(tmp_path,))
    assert (kept.status, kept.moving) == (status, 0.5)
    alone = reference_from_runs("lin-case1", catalogue.scene("lin-case1"), (kept,))
    assert alone.unsettled == f"level 1 {status}"
    assert (alone.uncertainty >= 0.5).all()
    settled = reference_from_runs("lin-case1", catalogue.scene("lin-case1"), (first, good))
    found = reference_from_runs(
        "lin-case1", catalogue.scene("lin-case1"), (first, replace(good, status=status, moving=0.5))
    )
    assert settled.unsettled == ""
    np.testing.assert_allclose(found.uncertainty, settled.uncertainty + 0.5)
    assert (exit_code_of_references([settled]), exit_code_of_references([settled, found])) == (0, 5)
    assert status in reference_uncertainty_text(found, uncertainty_of_loads(scene, found))
    limit = 1.0 + 100.0 * float(settled.uncertainty.max()) / 100.0 + 0.2
    before, after = (
        judge_contact_loads("mine", np.full((32, 4), 101.0), r, ErrorLimits(limit))[0] for r in (settled, found)
    )
    assert (before.word, after.word) == ("pass", "undecided")
    assert status in after.detail


def test_fresh_computes_what_is_stored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = catalogue.scene("lin-case1")
    task, old = ReferenceTask((scene,), 1), run_of("lin-case1", 1, np.ones((32, 4)))
    jobs.store_runs_and_condensed_bodies(tmp_path, task, [old], bodies_of(scene, 1))
    fresh = run_of("lin-case1", 1, np.full((32, 4), 2.0))
    monkeypatch.setattr(jobs, "compute_runs_and_bodies", lambda *_: ([fresh], bodies_of(scene, 1)))
    jobs.ensure_runs_are_stored([task], tmp_path, jobs.ComputingSettings(), lambda _: None)
    assert load_stored_run(scene, 1, stores=(tmp_path,)).load.max() == 1.0
    jobs.ensure_runs_are_stored([task], tmp_path, jobs.ComputingSettings(), lambda _: None, compute_again=True)
    assert load_stored_run(scene, 1, stores=(tmp_path,)).load.max() == 2.0


def test_levels_of_the_command_line() -> None:
    levels = {"3": (1, 2, 3), "1": (1,), "1,3": (1, 3), "source, 2": (0, 2)}
    assert {text: parse_levels(text) for text in levels} == levels
    for text in ("6", "0", "", "fine", "1;2"):
        with pytest.raises(InputError, match="levels: "):
            parse_levels(text)
