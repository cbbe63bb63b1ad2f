"""The bench: its structure, and ratios above one (seconds are never asserted)."""

import io
import json
import subprocess
from contextlib import nullcontext, redirect_stdout
from dataclasses import asdict, replace
from time import perf_counter
from types import SimpleNamespace

import numpy as np
import pytest

from rollbench.compare import __version__, errors
from rollbench.compare.cases.liu import bench as chain_bench
from rollbench.compare.models.study import Study
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.wings.bench import bench, prepared, section, startup, waits
from rollbench.compare.wings.bench.arguments import bench as bench_command
from rollbench.compare.wings.bench.costs import timing
from rollbench.lowfi.jit import code_folder
from rollbench.lowfi.statics.kernel.ball import MZ


def test_timing_is_a_median_after_an_uncounted_run():
    calls: list[str] = []
    timing.timed(lambda: calls.append("work"), 3, lambda: calls.append("reset"))
    assert calls == 4 * ["reset", "work"]


def test_runs_begin_from_the_same_state_and_a_warm_one_carries_one_per_cent_more_load():
    scene = catalogue.scene("lin-case1")
    energy, before, source = prepared.Energy(scene), prepared.Energy(scene), prepared.Source(scene)
    before.cold()
    first = before.prepared.force.copy()
    assert first.max() > 100.0
    before.reset()
    assert before.prepared.force.max() == 0.0
    before.cold()
    assert (before.prepared.force == first).all()
    energy.change_load()
    energy.warm()
    rise, base = (abs(float((p.force[:, 0] * p.state.contact[:, 0, MZ]).sum())) for p in (energy.prepared, before.prepared))
    assert rise / base == pytest.approx(1.01, rel=1e-4)
    source.change_load()
    source.solve()
    assert source.status == "converged"


def test_failed_source_gives_no_ratio_and_a_power_law_its_exponent():
    task = prepared.Source(catalogue.scene("lin-case1"))
    task.begin = task.begin * 0.0  # no contact anywhere: singular
    assert (bench._source_seconds(task, 1), bench._ratio(None, 1.0), bench._ratio(3.0, 2.0)) == (None, None, 1.5)
    assert bench._power([10, 100, 1000], [3.0, 300.0, 30000.0]) == pytest.approx(2.0)


def test_command_line_that_fails_is_not_measured(monkeypatch):
    done = type("Done", (), {"stdout": "", "stderr": "No module named rollbench.compare.__main__\n", "returncode": 1})
    monkeypatch.setattr(startup, "launch", lambda _: (0.1, done))
    job = startup.command_line_job()
    assert (job.seconds, job.note) == (None, "not measured: No module named rollbench.compare.__main__")


def once_alike():
    """`launch` of processes, alike ones but once."""
    done = {}

    def launch(arguments, extra=None):
        key = json.dumps([arguments, extra])
        if key not in done:
            done[key] = timing.launch(arguments, extra)
        return done[key]

    return launch


def in_this_process(arguments):
    """`launch` of the jobs' process, whose code is run here: imports and kernels are there already."""
    said = io.StringIO()
    with redirect_stdout(said):
        exec(arguments[1], {})
    return 0.0, subprocess.CompletedProcess(arguments, 0, said.getvalue(), "")


def once_if_long(work, repeats, reset=None):
    """`timed`, but what takes more than 20 ms is run once."""
    if reset is not None:
        reset()
    begin = perf_counter()
    work()
    seconds = perf_counter() - begin
    return seconds if seconds > 0.02 else timing.timed(work, repeats, reset)


def test_a_process_is_launched_as_a_users_without_threads_set_and_its_failure_is_told(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    code = "import os; print(os.environ.get('OMP_NUM_THREADS'), os.environ['OWN'])"
    seconds, done = timing.launch(["-c", code], {"OWN": "x"})
    assert seconds > 0.0
    assert done.stdout == "None x\n"
    monkeypatch.setattr(bench, "launch", lambda _: (0.1, subprocess.CompletedProcess([], 1, "", "first\nlast\n")))
    with pytest.raises(RuntimeError, match=r"the timing process failed: \['last'\]"):
        bench.run_bench()


@pytest.mark.slow
def test_all_jobs(monkeypatch):
    # machine code of these very sources is there already: that it can be made from nothing, whoever changes them sees
    kept = code_folder().parents[1]
    monkeypatch.setattr(startup, "tempfile", SimpleNamespace(TemporaryDirectory=lambda: nullcontext(str(kept))))
    monkeypatch.setattr(bench, "launch", in_this_process)
    monkeypatch.setattr(bench, "timed", once_if_long)
    monkeypatch.setattr(startup, "launch", once_alike())  # so that to compile and to load are one and the same process
    seen: list[str] = []
    jobs = bench.run_bench(seen.append, repeats=1)
    assert [line.partition(":")[0] for line in seen] == [j.job for j in jobs]
    assert len({j.job for j in jobs}) == len(jobs)
    json.dumps([asdict(j) for j in jobs], allow_nan=False)
    named = {j.job: j for j in jobs}
    cold = (f"cold solve, {what}" for what in ("case 1", "all sides", "no guess", "source partition"))
    for name in (*cold, "warm re-solve, case 1", "ensemble, per member"):
        assert named[name].ratio > 1.0
    assert all(j.ratio is None for j in jobs if j.job.startswith("source"))
    assert [named[f"cold solve, {what}"].unknowns for what in ("case 1", "all sides")] == [193, 385]
    for name in ("set-up, case 1", "imports", "compile the kernels", "load the kernels", "250 balls, cold"):
        assert isinstance(named[name], timing.Job)
        assert named[name].seconds is not None
    assert all(j.note for j in jobs)


def test_random_errors_against_the_elimination():
    found = list(chain_bench.jobs(1))
    assert [j.job.split(", ")[1].split()[0] for j in found] == ["constant", "implicit", "exact"]
    assert all(j.ratio is not None and j.ratio > 1.0 for j in found)
    assert all("a second" in j.note and j.unknowns == 78 for j in found)


def test_commands_as_typed_and_what_they_cannot_do_without():
    found = waits.Wait("a schema", "schema", 1e-3, "import pydantic", module="scenes.kinds").measured()
    assert (found.job, found.when) == ("a schema", "")
    assert 0.0 < found.floor < found.modules < found.seconds
    (row,) = waits.spent_table([found, timing.Job("no aim", 1.0, None, None, None, "")]).rows
    assert row["floor"] + row["modules"] + row["work"] == pytest.approx(row["seconds"])
    assert row["misses"] == pytest.approx(found.seconds / 1e-3)
    failed = waits.Wait("none", "no-such-command", 1.0, "import sys", module="errors").measured()
    assert (failed.seconds, waits.spent_table([failed]).rows[0]["misses"]) == (None, None)
    assert all(one.module and one.aim for one in waits.TYPED)
    said = waits.TYPED[0].job, waits.LONG[9].words
    assert said == ("list, as typed", "report --all --out {folder}/report --store {folder}/runs")


def test_long_jobs_are_kept_with_version_and_day_and_shown(monkeypatch, tmp_path):
    sample = waits.Wait("sample", "list", 1e-9, "sum(range(200_000 * {count}))", "a sum", (1, 20))
    answer = waits.Wait("first use", "schema", 5.0, "import pydantic", caches="empty", clock="answer")
    broken = waits.Wait("first report", "no-such-command", 5.0, caches="as they are", clock="wall")
    monkeypatch.setattr(waits, "LONG", (answer, broken, sample))
    one, other = waits.long_jobs(["first"], tmp_path)
    assert 0.0 < one.floor < one.seconds < 60.0
    assert one.when.startswith(f"{__version__}, ")
    assert (other.seconds, other.note) == (None, "not measured: the command failed")
    assert sample.each(sample.base, {"folder": str(tmp_path)}) > 1e-4
    later = replace(other, seconds=3.0)
    waits.keep(tmp_path, later)
    assert waits.kept([tmp_path / "none", tmp_path]) == [one, later]
    assert [row["measured"] for row in waits.spent_table(waits.kept([tmp_path])).rows] == [one.when, other.when]
    with pytest.raises(errors.InputError, match="long: "):
        next(waits.long_jobs(["frist"], None))
    with pytest.raises(errors.InputError, match="add --long"):
        bench_command(["audit"])


def test_new_screws_are_solved_next_to_a_busy_process():
    for size, balls in waits.CATALOGUE.items():
        assert scene_file.loads(waits.scene_like(size), size).ball_count == balls
    job = waits.CATALOGUED[0]
    assert job.busy
    assert job.measured().seconds > 0.1


@pytest.mark.parametrize(("count", "length"), [(32, 54e-3), (120, 164e-3)])
def test_screws_turned_in_time_are_case_1_with_more_balls(count, length):
    longer, case = scene_file.loads(waits._balls(count), "balls"), catalogue.scene("lin-case1")
    assert (longer.ball_count, longer.nut.length) == (count, pytest.approx(length))
    assert np.diff(longer.balls.azimuths[:2]) == pytest.approx(np.diff(case.balls.azimuths[:2]))
    assert longer.time.steps == 200


def test_growth_with_size_is_a_figure_with_exponents(monkeypatch):
    points = [(n, 1e-3 * n**1.5, 2.0 * n) for n in (8.0, 16.0, 32.0, 64.0)]
    for name in ("by_balls", "by_members"):
        monkeypatch.setattr(section, name, lambda _: {"lin": points})
    table, figure = section.scaling(Study(quick=True))
    assert len(table.rows) == 8
    assert [s.label for panel in figure.panels for s in panel.series] == ["lin: exponent 1.50", "lin: exponent 1.00"] * 2


def test_growth_is_measured_once_and_kept(monkeypatch, tmp_path):
    measured = []
    for name in ("by_balls", "by_members"):
        monkeypatch.setattr(section, name, lambda: measured.append(1) or {"lin": [(8.0, 1e-3, 2.0), (16.0, 2e-3, 4.0)]})
    monkeypatch.setattr(section, "shipped_store", lambda: tmp_path / "none")
    points, said = section.growth(Study((tmp_path,)))
    again, kept = section.growth(Study((tmp_path,)))
    assert len(measured) == 2
    assert again == {of: {model: [list(p) for p in x] for model, x in found.items()} for of, found in points.items()}
    assert (said, kept.split(",")[0]) == ("Measured for this report.", "Kept")
    section.growth(Study((tmp_path,), timed=True))
    assert len(measured) == 4
