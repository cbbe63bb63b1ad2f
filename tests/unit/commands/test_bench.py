"""The bench: what it measures and says (seconds are never asserted)."""

import pytest

from rollbench.compare.cases.lin import times
from rollbench.compare.commands import bench
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.reference.store import measuring_conditions
from rollbench.compare.sections import reference_time
from rollbench.compare.studies import run_times
from rollbench.compare.studies.run_times import load_run_times


def test_a_process_is_launched_as_a_users_without_threads_set(monkeypatch, tmp_path):
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    code = "import os; print(os.environ.get('OMP_NUM_THREADS'), os.environ['OWN'])"
    done = run_times.run_timed_python_process(["-c", code], {"OWN": "x"}, str(tmp_path))
    assert done.seconds >= done.first_line_seconds > 0.0
    assert done.printed_output == "None x\n"


def test_a_command_is_timed_from_an_empty_home_again_and_beside_a_busy_process():
    found = run_times.time_command_in_empty_home("schema --help")
    assert found.job.job == "schema --help, from an empty home"
    assert found.seconds >= found.first_line > 0.0
    assert min(found.cpu, found.again, found.again_cpu, found.beside, found.beside_cpu) > 0.0
    failed = run_times.time_command_in_empty_home("solve no-such-scene")
    assert failed.seconds is None
    assert failed.job.note.startswith("not measured: rollbench: ")


@pytest.fixture
def kept(monkeypatch):
    """Known times, in place of times that are measured."""
    times_of_models = {("lin-case1", "lin"): run_times.RunTime(0.4, 1e-3, 99.0)}
    levels = (run_times.ColdLevelTime(4, 60.0, 118.0, None, "converged", "lin-case1", 64, 0.9),)
    found = run_times.StoredRunTimes(measuring_conditions(), "2026-01-02", times_of_models, levels)
    monkeypatch.setattr(reference_time, "measure_run_times", lambda *_, **__: found)
    monkeypatch.setattr(reference_time, "COMMANDS", ())
    monkeypatch.setattr(run_times, "time_ensemble", lambda: run_times.RunTimeRow("members", 1.0))
    return found


@pytest.mark.usefixtures("kept")
def test_times_of_typed_commands_are_kept_for_the_report(monkeypatch, tmp_path, command):
    monkeypatch.setattr(reference_time, "COMMANDS", ("schema --help",))
    command.answer("bench", "--store", tmp_path)
    typed = load_run_times([tmp_path], run_times.TYPED)
    (row,), (one,) = reference_time.command_time_table(typed).rows, typed.command_times
    assert (row["command"], row["run_time_empty_home"], one.note) == ("schema --help", one.seconds, "")
    assert load_run_times([tmp_path]) is None


def test_an_ensemble_is_timed(monkeypatch):
    monkeypatch.setattr(run_times, "MEMBERS", 20)
    row = run_times.time_ensemble()
    assert row.job.startswith("20 members")
    assert row.seconds > 0.0


def test_models_are_listed_with_errors_beside_their_run_times(kept, tmp_path, command):
    rows = {row["job"]: row for row in command.answer("bench", "lin-case1")}
    study = SceneResultCache()
    study.computed_values[reference_time.run_times_to_show, print] = kept
    points = reference_time.error_and_time_points("lin-case1", study.stored_reference("lin-case1"), study, print)
    timed = {f"lin-case1: {p.label}": p for p in points if p.cold is not None}
    assert timed
    assert rows.keys() == {"members", *timed}
    for name, p in timed.items():
        assert (rows[name]["seconds"], rows[name]["error_percent"]) == (p.cold, pytest.approx(p.error))
    command.answer("bench", "--long", "--store", tmp_path)
    assert load_run_times([tmp_path]) == kept


def test_times_of_a_publication_are_listed_as_they_were_stored(kept, monkeypatch, tmp_path):
    monkeypatch.setattr(times, "measure_run_times", lambda *_: kept)
    rows = bench.measure_publication_times("lin", tmp_path).data
    cold = [one.cold for one in kept.times_by_scene_and_model.values()]
    assert [row["seconds"] for row in rows] == [*cold, *(one.process for one in kept.mesh_level_times)]
    assert load_run_times((tmp_path,), "lin") == kept
