"""A Dask cluster that is lost while jobs run: the last worker, or the scheduler."""

import subprocess
import sys
import threading
import time
from contextlib import contextmanager

import pytest
from tests.jobs_in_order import run

from rollbench.compare.errors import InputError
from rollbench.compare.reference import parallel

distributed = pytest.importorskip("distributed")
pytestmark = [pytest.mark.slow, pytest.mark.timeout(300)]


def sleepy(seconds, begun=None):
    """Sleep; ``begun``: a file that says so."""
    if begun is not None:
        begun.touch()
    time.sleep(seconds)
    return seconds


#: A scheduler and a worker in one process, which writes the scheduler's address to a file.
CLUSTER = """
import sys, time
from distributed import LocalCluster
options = {"threads_per_worker": 1, "processes": False, "dashboard_address": "127.0.0.1:0"}
cluster = LocalCluster(n_workers=1, host="127.0.0.1", protocol="tcp://", **options)
open(sys.argv[1], "w").write(cluster.scheduler_address + "\\n")
time.sleep(300)
"""


@contextmanager
def process(*words):
    """A Python process, ended when the context is left."""
    started = subprocess.Popen([sys.executable, *words])
    try:
        yield started
    finally:
        started.kill()
        started.wait()


@pytest.fixture
def worker():
    """A worker of its own process: (address of its scheduler, worker)."""
    with distributed.LocalCluster(n_workers=0, dashboard_address="127.0.0.1:0") as local:
        address = local.scheduler_address
        words = ("distributed.cli.dask_worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard")
        with process("-m", *words) as started, distributed.Client(address, set_as_default=False) as client:
            client.wait_for_workers(1, timeout=120)
            yield address, started


@pytest.fixture
def cluster(tmp_path):
    """A cluster of its own process: (address of its scheduler, process)."""
    file = tmp_path / "address"
    with process("-c", CLUSTER, str(file)) as started:
        end = time.monotonic() + 120.0
        while not (file.exists() and file.read_text().endswith("\n")) and time.monotonic() < end:
            time.sleep(0.05)
        yield file.read_text().strip(), started


def lose(address, process, begun, words):
    """Kill a process as soon as a job has begun, and see the jobs end with these words."""

    def watch():
        while not begun.exists():
            time.sleep(0.02)
        process.kill()

    killer = threading.Thread(target=watch, daemon=True)
    killer.start()
    with pytest.raises(InputError, match=words):
        run([(sleepy, (60.0, begun))] * 2, "dask", address)
    killer.join()


def test_a_last_worker_that_is_lost_ends_the_jobs_after_a_stated_wait(worker, monkeypatch, capfd, tmp_path):
    monkeypatch.setattr(parallel, "LONELY", 0.4)
    monkeypatch.setattr(parallel, "LOOK", 0.1)
    lose(*worker, tmp_path / "begun", r"the last worker was lost, and no other joined within 0\.4 s")
    assert "waiting 0.4 s for another" in capfd.readouterr().err


def test_a_scheduler_that_is_lost_is_named(cluster, monkeypatch, tmp_path):
    monkeypatch.setattr(parallel, "PATIENCE", 2.0)
    lose(*cluster, tmp_path / "begun", "the scheduler no longer answers")
