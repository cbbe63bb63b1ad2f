"""Jobs in this process, in processes of this machine and on a Dask cluster: same results, and failures with a reason."""

import os
import socket
import sys
import time
from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from tests.jobs_in_order import run

from rollbench.compare.errors import InputError
from rollbench.compare.reference import parallel

pytestmark = pytest.mark.xdist_group("scheduler")


class Stubborn(Exception):
    """Cannot be made again from its message, so it cannot travel."""

    def __init__(self, a, b):
        super().__init__(f"{a} and {b}")


def squares(n: int) -> tuple[int, np.ndarray]:
    return os.getpid(), np.arange(n) ** 2


def process() -> int:
    time.sleep(0.2)
    return os.getpid()


def meet(folder) -> int:
    """Wait for two processes to be here; give up where only one ever comes."""
    (folder / str(os.getpid())).touch()
    end = time.monotonic() + 60.0
    while len(list(folder.iterdir())) < 2 and time.monotonic() < end:
        time.sleep(0.01)
    return os.getpid()


def stay() -> tuple[float, float]:
    """When a job begins and ends, by the clock that all processes of a machine share."""
    begin = time.monotonic()
    time.sleep(0.2)
    return begin, time.monotonic()


def fail(kind: str, seconds: float = 0.2):
    time.sleep(seconds)
    if kind == "input":
        raise InputError("scene.toml", "balls.radius", "-1", "above 0", "give a length")
    if kind == "stubborn":
        raise Stubborn("this", "that")
    raise ValueError(f"no {kind}")


def cluster_of(workers, **options):
    import dask  # not above: workers read this file
    from distributed import LocalCluster

    with dask.config.set({"distributed.worker.multiprocessing-method": "spawn", **options}):
        return LocalCluster(n_workers=workers, threads_per_worker=1, processes=True, dashboard_address="127.0.0.1:0")


@pytest.fixture(scope="module")
def scheduler():
    with cluster_of(2, **{"distributed.scheduler.allowed-failures": 0}) as cluster:
        yield cluster.scheduler_address


JOBS = [(squares, (n,)) for n in (60, 3, 40, 5, 1)]


@pytest.mark.parametrize("backend", ["joblib", "dask"])
def test_the_results_are_those_of_one_process(where):
    said = []
    serial = run([*JOBS, partial(squares, 7)])
    assert {pid for pid, _ in serial} == {os.getpid()}
    several = run([*JOBS, partial(squares, 7)], *where, said.append)
    assert os.getpid() not in {pid for pid, _ in several}
    for (_, ours), (_, theirs) in zip(serial, several, strict=True):
        np.testing.assert_array_equal(ours, theirs)
    assert [line.split(", ")[1] for line in said] == [f"{k} of 6" for k in range(1, 7)]
    assert {line.split(" done")[0] for line in said} == {f"job {k}" for k in range(1, 7)}


def test_one_at_a_time_here_unless_more_are_asked_for():
    assert run([process, process]) == [os.getpid()] * 2
    assert run([]) == run([], workers=2) == []


def wait(seconds: float, folder) -> float:
    time.sleep(seconds)
    (folder / str(seconds)).touch()
    return seconds


def test_results_come_as_they_are_done_and_the_rest_is_dropped(tmp_path):
    assert list(parallel.run_jobs([(wait, (0.0, tmp_path))] * 2)) == [(0, 0.0), (1, 0.0)]
    some = parallel.run_jobs([(wait, (s, tmp_path)) for s in (1.5, 0.01, 0.02)], workers=2)
    assert next(some) == (1, 0.01)
    assert next(some) == (2, 0.02)
    some.close()
    assert not (tmp_path / "1.5").exists()


def test_a_cluster_is_used_by_all_its_workers_or_as_many_as_asked(scheduler, tmp_path):
    assert len(set(run([(meet, (tmp_path,))] * 2, "dask", scheduler))) == 2
    stays = sorted(run([stay] * 3, "dask", scheduler, workers=1))
    assert all(end <= begin for (_, end), (begin, _) in pairwise(stays))


@pytest.fixture
def where(backend, scheduler):
    """Backend, scheduler and workers of a test."""
    return {"serial": ("joblib", None, 1), "joblib": ("joblib", None, 2), "dask": ("dask", scheduler, 2)}[backend]


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")  # loky, when it is stopped at once
@pytest.mark.parametrize("backend", ["serial", "joblib", "dask"])
def test_an_exception_is_raised_once_with_its_message(backend, where, capfd):
    capfd.readouterr()
    said, here = [], backend == "serial"
    with pytest.raises(ValueError, match=r"^no luck") as found:
        run([(fail, ("luck",)), (fail, ("mercy", 0.5))], *where, said.append)
    assert str(found.value) == "no luck"
    assert here or "in fail" in found.value.__notes__[0]
    with pytest.raises(InputError) as found:
        run([(fail, ("input",))] * 2, *where)
    assert found.value.key == "balls.radius"
    with pytest.raises(Stubborn if here else RuntimeError) as stubborn:
        run([(fail, ("stubborn",))] * 2, *where)
    assert str(stubborn.value) == ("this and that" if here else "Stubborn: this and that")
    assert (said, capfd.readouterr().err) == ([], "")
    assert len(run(JOBS, *where)) == 5


@pytest.mark.parametrize("backend", ["joblib", "dask"])
def test_a_worker_that_dies_is_reported(where):
    with pytest.raises(InputError, match=r"workers: got a worker that died.*fewer workers"):
        run([(os._exit, (3,))] * 2, *where)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"backend": "mpi"}, r"backend: got mpi; allowed: joblib or dask"),
        ({"workers": 0}, r"workers: got 0; allowed: 1 or more"),
        ({"scheduler": "tcp://here:1"}, r"scheduler: got tcp://here:1; allowed: only with `backend=dask`"),
    ],
)
def test_strange_options_are_refused(options, message):
    with pytest.raises(InputError, match=message):
        run(JOBS, **options)


def test_missing_packages_are_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=r"pip install 'rollbench\[cluster\]'"):
        run(JOBS, "dask", "tcp://127.0.0.1:8786")


@pytest.fixture
def deaf():
    """Address of a port that takes connections and never says a word."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield f"tcp://127.0.0.1:{server.getsockname()[1]}"


@pytest.mark.timeout(120)
@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "deaf", "localhost", "no://such", ""])
def test_what_is_no_scheduler_is_refused(address, request, monkeypatch):
    """By our own patience: that of Dask is set longer than the test may last."""
    import dask

    if address == "deaf":
        address = request.getfixturevalue(address)
    monkeypatch.setattr(parallel, "PATIENCE", 0.5)
    refused = pytest.raises(InputError, match=r"scheduler: got .*no answer of a scheduler.*advice: start one with")
    with dask.config.set({"distributed.comm.timeouts.connect": "1h"}), refused:
        run(JOBS, "dask", address)


def test_a_scheduler_without_workers_is_refused_after_a_wait(capfd, monkeypatch):
    monkeypatch.setattr(parallel, "LONELY", 1.0)
    with cluster_of(0) as cluster, pytest.raises(InputError, match=r"no workers within 1 s; .*dask worker tcp://"):
        run(JOBS, "dask", cluster.scheduler_address)
    assert "waiting 1 s for a worker" in capfd.readouterr().err


def test_a_cluster_that_adapts_its_size_gets_workers_for_the_jobs():
    with cluster_of(0) as cluster:
        cluster.adapt(minimum=0, maximum=1, interval="100 ms", wait_count=1000)
        assert len(set(run([process] * 2, "dask", cluster.scheduler_address))) == 1


def test_workers_of_another_version_are_refused(scheduler, monkeypatch, tmp_path):
    with monkeypatch.context() as patch:
        patch.setattr(parallel, "__version__", "99.0")
        with pytest.raises(InputError, match=r"workers of rollbench .*install version 99\.0"):
            run(JOBS, "dask", scheduler)
    (tmp_path / "only_here.py").write_text("def version():\n    return ''\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    import only_here

    monkeypatch.setattr(parallel, "_rollbench_version", only_here.version)
    with pytest.raises(InputError, match=r"workers without rollbench .*only_here"):
        run(JOBS, "dask", scheduler)
