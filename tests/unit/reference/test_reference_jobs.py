"""Jobs of the 3D reference: plan, what is missing, what is kept and told, levels of the command line; what a run is
expected to take, and what an interrupt leaves."""

from dataclasses import replace
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest
from tests.reference_records import bodies_of, run_of

from rollbench.compare.commands.compare import exit_code_of_references, parse_levels
from rollbench.compare.errors import InputError
from rollbench.compare.gate.verdict import ErrorLimits, judge_contact_loads
from rollbench.compare.models.uncertainty import uncertainty_of_loads
from rollbench.compare.reference import computing, jobs
from rollbench.compare.reference.estimate import reference_from_runs
from rollbench.compare.reference.jobs import check_memory, expected_time_and_memory
from rollbench.compare.reference.store import Run, load_stored_run, path_of_bodies, path_of_run, save_run, shipped_store
from rollbench.compare.reference.tasks import ReferenceTask
from rollbench.compare.results.comparing import error_for_unconverged_reference
from rollbench.compare.results.comparison import reference_uncertainty_text
from rollbench.compare.scenes import catalogue
from rollbench.meshes.condensed import CondensedBodies

CASE1 = catalogue.scene("lin-case1")
TASK = ReferenceTask((CASE1,), 1)
ONES = np.ones((32, 4))


def stored(folder: Path, tasks: list[ReferenceTask], **options: object) -> tuple[list[Run], list[str]]:
    """Runs that are stored or computed, and what is said."""
    said: list[str] = []
    return jobs.ensure_runs_are_stored(tasks, folder, jobs.ComputingSettings(), said.append, **options), said


def test_a_task_without_its_bodies_is_missing(tmp_path: Path) -> None:
    run = run_of("lin-case1", 1, ONES)
    save_run(tmp_path, CASE1, run)
    assert jobs.tasks_without_stored_runs([TASK], (tmp_path,)) == [TASK]
    jobs.store_runs_and_condensed_bodies(tmp_path, TASK, [run], bodies_of(CASE1, 1))
    assert jobs.tasks_without_stored_runs([TASK], (tmp_path,)) == []


def test_plan_and_what_is_missing(tmp_path: Path) -> None:
    scenes = [catalogue.scene(n) for n in ("lin-case1", "lin-case2")]
    tasks = jobs.plan_reference_tasks(scenes, (1, 2), ("land",), leave_out_each_part=True)
    planned = {(t.level, t.variant, t.leave_out_each_part, len(t.scenes)) for t in tasks}
    assert planned == {(1, "", True, 2), (2, "", False, 2), (1, "land", False, 1)}
    save_run(tmp_path, scenes[0], run_of("lin-case1", 2, ONES))
    save_run(tmp_path, scenes[1], replace(run_of("lin-case2", 1, ONES), without={}))
    left = {(t.level, t.variant): [s.name for s in t.scenes] for t in jobs.tasks_without_stored_runs(tasks, (tmp_path,))}
    assert left == {(1, ""): ["lin-case1", "lin-case2"], (2, ""): ["lin-case2"], (1, "land"): ["lin-case1"]}
    coarsest_first = jobs.plan_reference_tasks([CASE1], (1, 2, 3), with_source_mesh=True)
    assert [t.level for t in coarsest_first] == [1, 3, 2, 0]


def test_each_job_is_stored_when_it_is_done(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run = run_of("lin-case1", 1, ONES)

    def fake(task: ReferenceTask, _: object) -> tuple[list[Run], CondensedBodies]:
        if task.level == 2:
            raise KeyboardInterrupt
        return [run], bodies_of(CASE1, 1)

    monkeypatch.setattr(jobs, "compute_runs_and_bodies", fake)
    tasks = [TASK, ReferenceTask((CASE1,), 2)]
    with pytest.raises(KeyboardInterrupt):
        stored(tmp_path, tasks)
    assert {*tmp_path.iterdir()} == {path_of_run(tmp_path, CASE1, run), path_of_bodies(tmp_path, CASE1, run)}
    assert jobs.tasks_without_stored_runs(tasks, (tmp_path,)) == [tasks[1]]


def test_a_run_that_did_not_converge_is_told_and_computed_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    reason = "a contact reaches the rim of its patch: it needs 1.6 mm,\nhas 1.5 mm"
    failed, tasks = replace(run_of("lin-case1", 1, ONES), status=reason), [TASK]
    monkeypatch.setattr(jobs, "compute_runs_and_bodies", lambda *_: ([failed], None))
    found, said = stored(tmp_path, tasks)
    assert [run.status for run in found] == [reason]
    assert list(tmp_path.iterdir()) == []
    assert jobs.tasks_without_stored_runs(tasks, (tmp_path,)) == tasks
    refusal = str(error_for_unconverged_reference("lin-case1", found))
    assert all("\n" not in line for line in (*said, refusal))
    assert any("it needs 1.6 mm, has 1.5 mm" in line for line in said)
    assert "level 1: a contact reaches the rim of its patch: it needs 1.6 mm, has 1.5 mm" in refusal


def test_a_run_that_did_not_settle_is_kept_with_what_it_may_move_by(tmp_path: Path, monkeypatch) -> None:
    status = "not settled: loads may still move by 0.5 N after 30 updates of normals and gaps"
    first, good = run_of("lin-case1", 1, np.full((32, 4), 99.0)), run_of("lin-case1", 2, np.full((32, 4), 100.0))
    monkeypatch.setattr(jobs, "compute_runs_and_bodies", lambda *_: ([replace(first, status=status, moving=0.5)], None))
    found, said = stored(tmp_path, [TASK])
    assert found == []
    assert any(status in line and "not stored" not in line for line in said)
    kept = load_stored_run(CASE1, 1, stores=(tmp_path,))
    assert (kept.status, kept.moving) == (status, 0.5)
    alone, before = (reference_from_runs("lin-case1", CASE1, (run,)) for run in (kept, first))
    assert alone.unsettled == f"level 1 {status}"
    np.testing.assert_allclose(alone.uncertainty, before.uncertainty + 0.5)
    settled, found = (
        reference_from_runs("lin-case1", CASE1, (first, finest))
        for finest in (good, replace(good, status=status, moving=0.5))
    )
    assert settled.unsettled == ""
    np.testing.assert_allclose(found.uncertainty, settled.uncertainty + 0.5)
    assert (exit_code_of_references([settled]), exit_code_of_references([settled, found])) == (0, 5)
    assert status in reference_uncertainty_text(found, uncertainty_of_loads(CASE1, found))
    limits = ErrorLimits(1.0 + float(settled.uncertainty.max()) + 0.2)
    before, after = (judge_contact_loads("mine", np.full((32, 4), 101.0), r, limits)[0] for r in (settled, found))
    assert (before.judgement, after.judgement) == ("pass", "undecided")
    assert status in after.detail


def test_fresh_computes_what_is_stored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    jobs.store_runs_and_condensed_bodies(tmp_path, TASK, [run_of("lin-case1", 1, ONES)], bodies_of(CASE1, 1))
    fresh = run_of("lin-case1", 1, 2.0 * ONES)
    monkeypatch.setattr(jobs, "compute_runs_and_bodies", lambda *_: ([fresh], bodies_of(CASE1, 1)))
    for again, load in ((False, 1.0), (True, 2.0)):
        stored(tmp_path, [TASK], compute_again=again)
        assert load_stored_run(CASE1, 1, stores=(tmp_path,)).load.max() == load


def test_levels_of_the_command_line() -> None:
    levels = {"3": (1, 2, 3), "1": (1,), "1,3": (1, 3), "source, 2": (0, 2)}
    assert {text: parse_levels(text) for text in levels} == levels
    for text in ("6", "0", "", "fine", "1;2"):
        with pytest.raises(InputError, match="levels: "):
            parse_levels(text)


@pytest.mark.parametrize("name", ["unseen-hollow", "unseen-short-nut", "unseen-16x5", "unseen-40x10", "unseen-25x5"])
@pytest.mark.parametrize("level", [1, 2, 3])
def test_the_estimate_is_near_what_stored_runs_took(name: str, level: int) -> None:
    scene = catalogue.scene(name)
    run = load_stored_run(scene, level, stores=(shipped_store(),))
    found = expected_time_and_memory(ReferenceTask((scene,), level))
    assert 0.4 < found.seconds / (run.setup_seconds + run.solve_seconds) < 2.5
    assert 0.5 < 1e-3 * run.peak_MB / found.memory_GB < 1.6


def test_a_machine_that_is_too_small_is_refused_before_anything_runs(tmp_path, monkeypatch) -> None:
    enough = expected_time_and_memory(TASK).memory_GB
    monkeypatch.setattr(jobs, "available_GB", lambda: 1.0)
    with pytest.raises(InputError, match=r"memory: got 1.0 GB free; allowed: at least about .* GB for lin-case1: level 1"):
        stored(tmp_path, [TASK])
    monkeypatch.setattr(jobs, "available_GB", lambda: 1.5 * enough)
    assert check_memory([TASK, TASK], 1) == pytest.approx(enough)
    with pytest.raises(InputError, match="`workers=1`"):
        check_memory([TASK, TASK], 2)
    monkeypatch.setattr(jobs, "available_GB", lambda: None)
    assert check_memory([TASK, TASK], 2) == pytest.approx(2.0 * enough)


def test_memory_that_runs_out_is_said_in_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("gmsh")
    ended = Mock(side_effect=MemoryError("a process of the set-up was ended from outside"))
    monkeypatch.setattr("rollbench.hifi.setup.mesh_and_condense_geometry", ended)
    with pytest.raises(InputError, match=r"memory.*ended from outside.*fewer workers"):
        computing.compute_reference_runs(TASK)
