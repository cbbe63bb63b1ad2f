"""The bench: its structure, and ratios above one (seconds are never asserted)."""

import subprocess

import pytest

from rollbench.compare.sources.liu import bench as chain_bench
from rollbench.compare.wings.bench import bench
from rollbench.compare.wings.bench.costs import timing


def test_a_process_is_launched_as_a_users_without_threads_set_and_its_failure_is_told(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    code = "import os; print(os.environ.get('OMP_NUM_THREADS'), os.environ['OWN'])"
    seconds, done = timing.launch(["-c", code], {"OWN": "x"})
    assert seconds > 0.0
    assert done.stdout == "None x\n"
    monkeypatch.setattr(bench, "launch", lambda _: (0.1, subprocess.CompletedProcess([], 1, "", "first\nlast\n")))
    with pytest.raises(RuntimeError, match=r"the timing process failed: \['last'\]"):
        bench.run_bench()


def test_random_errors_against_the_elimination():
    found = list(chain_bench.jobs(1))
    assert [j.job.split(", ")[1].split()[0] for j in found] == ["constant", "implicit", "exact"]
    assert all(j.ratio is not None and j.ratio > 1.0 for j in found)
    assert all("a second" in j.note and j.unknowns == 78 for j in found)
