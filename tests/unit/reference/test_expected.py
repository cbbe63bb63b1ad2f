"""What a run of the 3D reference is expected to take, what is said while it runs, and what an interrupt leaves."""

import json
import os
import stat
from unittest.mock import Mock

import pytest

from rollbench.compare import errors, files, running
from rollbench.compare.reference import computing, jobs, store
from rollbench.compare.reference import jobs as module
from rollbench.compare.reference.jobs import TaskProgress, check_memory, expected_time_and_memory
from rollbench.compare.reference.tasks import ReferenceTask
from rollbench.compare.running import format_duration
from rollbench.compare.scenes import catalogue
from rollbench.compare.studies.run_times import load_run_times
from rollbench.hifi.setup import TOGETHER
from rollbench.meshes.cache import StageMessage
from rollbench.meshes.files import make_readable_for_group

CASE1 = catalogue.scene("lin-case1")
TASK = ReferenceTask((CASE1,), 1)
SCENES = ("unseen-hollow", "unseen-short-nut", "unseen-16x5", "unseen-40x10", "unseen-25x5")


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("level", [1, 2, 3])
def test_the_estimate_is_near_what_stored_runs_took(name: str, level: int) -> None:
    scene = catalogue.scene(name)
    run = store.load_stored_run(scene, level, stores=(store.shipped_store(),))
    found = expected_time_and_memory(ReferenceTask((scene,), level))
    assert 0.4 < found.seconds / (run.setup_seconds + run.solve_seconds) < 2.5
    assert 0.5 < 1e-3 * run.peak_MB / found.memory_GB < 1.6


def test_a_second_process_takes_less_time_and_with_many_contacts_the_memory_of_patches() -> None:
    alone, two = (expected_time_and_memory(ReferenceTask((CASE1,), 3, processes=n)) for n in (1, 2))
    assert 0.5 * alone.seconds < two.seconds < 0.8 * alone.seconds
    assert alone.memory_GB < two.memory_GB < 2.0 * alone.memory_GB
    few, many = (
        expected_time_and_memory(ReferenceTask((catalogue.scene("unseen-25x5"),), 1, processes=n)).memory_GB for n in (1, 2)
    )
    assert many - few == pytest.approx(module.PATCHES_ALONE * module.BASE_GB[1])
    assert module.TOGETHER == TOGETHER


def test_memory_of_many_contacts_is_told_as_it_was_measured() -> None:
    """228 and 264 contacts on level 1 in two processes: at most a tenth more is told, and less than 3 GB."""
    kept = load_run_times((store.shipped_store(),))
    large = [c for c in kept.mesh_level_times if (c.contacts or 0) > 200]
    assert {c.contacts for c in large} == {228, 264}
    for c in large:
        memory = expected_time_and_memory(ReferenceTask((catalogue.scene(c.scene),), c.level, processes=2)).memory_GB
        assert 1.0 <= memory / (1e-3 * c.memory) <= 1.1
        assert memory < 3.0


def test_a_machine_that_is_too_small_is_refused_before_anything_runs(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(module, "available_GB", lambda: 1.0)
    with pytest.raises(errors.InputError, match=r"memory: got 1.0 GB free; allowed: about .* GB for lin-case1: level 1"):
        jobs.ensure_runs_are_stored([TASK], tmp_path, jobs.ComputingSettings(), lambda _: None)
    enough = expected_time_and_memory(TASK).memory_GB
    monkeypatch.setattr(module, "available_GB", lambda: 1.5 * enough)
    assert check_memory([TASK, TASK], 1) == pytest.approx(enough)
    with pytest.raises(errors.InputError, match="`workers=1`"):
        check_memory([TASK, TASK], 2)
    monkeypatch.setattr(module, "available_GB", lambda: None)
    assert check_memory([TASK, TASK], 2) == pytest.approx(2.0 * enough)


def test_progress_says_stage_share_and_time_left() -> None:
    progress, whole, stages = (
        TaskProgress(TASK),
        expected_time_and_memory(TASK).seconds,
        expected_time_and_memory(TASK).seconds_by_stage,
    )
    assert progress.present_stage_text == "lin-case1: level 1: meshes"
    first = progress.progress_line(StageMessage("meshes", f"{stages['meshes']:.1f} s"), stages["meshes"])
    assert first.startswith("lin-case1: level 1: meshes: ")
    assert f"about {format_duration(whole - stages['meshes'])} left" in first
    assert progress.present_stage_text == "lin-case1: level 1: patches"
    done = stages["meshes"] + stages["patches"]
    second = progress.progress_line(StageMessage("patches", "1 s"), 2.0 * done)
    assert f"about {format_duration(2.0 * (whole - done))} left" in second
    assert progress.progress_line("contact of side SL", 1.0) == "lin-case1: level 1: contact of side SL"


def test_an_interrupt_says_what_is_kept(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    said = []
    monkeypatch.setattr(jobs, "compute_runs_and_bodies", Mock(side_effect=KeyboardInterrupt))
    monkeypatch.setattr(jobs, "output_closed", lambda: False)
    with pytest.raises(KeyboardInterrupt):
        jobs.ensure_runs_are_stored([TASK], tmp_path, jobs.ComputingSettings(cache_folder=tmp_path / "cache"), said.append)
    assert said[-1].startswith(f"WARNING: interrupted: 0 of 1 set-ups are stored in {tmp_path}, and finished stages")
    monkeypatch.setattr(jobs, "output_closed", lambda: True)
    with pytest.raises(BrokenPipeError):
        jobs.ensure_runs_are_stored([TASK], tmp_path, jobs.ComputingSettings(), said.append)


def test_a_reader_that_goes_away_is_seen() -> None:
    read, write = os.pipe()
    assert not running.output_closed((write,))
    os.close(read)
    assert running.output_closed((write,))
    os.close(write)


def test_stored_files_are_readable_by_the_group(tmp_path) -> None:
    before = os.umask(0o077)
    try:
        files.replace_file(tmp_path / "run.json", json.dumps({}))
        files.replace_file(tmp_path / "team" / "store" / "run.json", json.dumps({}))
        (tmp_path / "own").write_text("")
    finally:
        os.umask(before)
    make_readable_for_group(tmp_path / "own")
    modes = {"run.json": 0o640, "team": 0o750, "team/store": 0o750}
    assert {name: stat.S_IMODE((tmp_path / name).stat().st_mode) for name in modes} == modes
    assert all((tmp_path / name).stat().st_mode & 0o040 for name in ("team/store/run.json", "own"))


def test_memory_that_runs_out_is_said_in_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("gmsh")
    ended = Mock(side_effect=MemoryError("a process of the set-up was ended from outside"))
    monkeypatch.setattr("rollbench.hifi.setup.mesh_and_condense_geometry", ended)
    with pytest.raises(errors.InputError, match=r"memory.*ended from outside.*fewer workers"):
        computing.compute_reference_runs(TASK)
