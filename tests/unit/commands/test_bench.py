"""The bench: what it measures and says (seconds are never asserted)."""

from rollbench.compare.models.registry import MODELS
from rollbench.compare.reference.store import measuring_conditions
from rollbench.compare.sections import reference_time
from rollbench.compare.studies import run_times, survey_models
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


def test_a_stored_run_times_models_and_commands_for_the_report(tmp_path, command, monkeypatch):
    """One model, one command and no drawn screw in place of all that is timed; no ensemble."""
    for module, name, value in (
        (reference_time, "REFERENCED", ("lin-case1",)),
        (reference_time, "UNSEEN", ()),
        (reference_time, "LARGE", ()),
        (reference_time, "all_cases", tuple),
        (reference_time, "models_with_body_files", lambda *_: [(MODELS["mei"], None)]),
        (run_times, "COMMANDS", ("schema --help",)),
        (run_times, "time_ensemble", lambda: run_times.RunTimeRow("members", 1.0)),
        (survey_models, "COUNT", 0),
        (survey_models.time_models_and_levels_on_screws, "__defaults__", (0,)),
    ):
        monkeypatch.setattr(module, name, value)
    rows = {row["job"]: row for row in command.answer("bench", "--store", tmp_path)}
    kept = load_run_times([tmp_path])
    (row,), one = reference_time.command_time_table(kept).rows, kept.times["schema --help",]
    assert (row["command"], row["run_time_empty_home"], one.note) == ("schema --help", one.seconds, "")
    time = kept.times["lin-case1", "mei"]
    assert rows["lin-case1: mei"]["seconds"] == time.cold > time.warm > 0.0
    assert kept.measuring_conditions == measuring_conditions()


def test_a_stored_run_takes_no_scenes(command):
    assert "--store" in command.refused("bench", "lin-case1", "--store", "x")
