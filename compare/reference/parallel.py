"""Parallel execution of independent jobs: in this process, in processes of this machine (joblib), or on a Dask cluster.

One job at a time unless more are asked for: a run of the 3D reference takes gigabytes, and its set-up uses all cores.
"""

from __future__ import annotations

import asyncio
import pickle
import sys
import threading
import traceback
import warnings
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import ExitStack, closing, contextmanager
from time import monotonic, sleep
from typing import Any

from rollbench.compare import __version__
from rollbench.compare.errors import ArgumentError, InputError
from rollbench.meshes.processes import local_workers, one_thread, without_restart_warnings

#: A job: a function without arguments, or a function and its arguments; picklable if it runs in another process.
Job = Callable[[], Any] | tuple[Callable[..., Any], Sequence[Any]]
Step = Callable[[str], None]
#: Request to a worker: number of the job, version of this program, function and arguments.
Asked = tuple[int, str, Callable[..., Any], Sequence[Any]]
#: Answer of a worker: number of the job, whether it succeeded, its pickled result or exception.
Answer = tuple[int, bool, bytes]

BACKENDS = ("joblib", "dask")
#: Seconds to wait for a scheduler.
PATIENCE = 5.0
#: Default time to wait for a worker [s], for the first, and for another after the last was lost.
LONELY = 60.0
#: Intervals at which the cluster and the jobs are polled [s].
LOOK, BLINK = 1.0, 0.02
#: Time without answer of a connected scheduler after which it counts as lost [s].
SILENCE = 120.0
#: Advice when a cluster was lost.
AGAIN = "see what ended it, restart it, and give the same command again: runs that are stored are not repeated"
#: Advice about workers without this program.
INSTALL = "install it where the workers run"

_ALONE = threading.Lock()


def as_done(
    jobs: Sequence[Job],
    backend: str = "joblib",
    scheduler: str | None = None,
    workers: int | None = None,
    wait: float | None = None,
) -> Generator[tuple[int, Any], None, None]:
    """Run independent jobs and yield each result as soon as it is available; closing the generator drops the rest.

    Parameters
    ----------
    jobs
        The jobs.
    backend
        ``joblib`` for this machine, ``dask`` for a cluster.
    scheduler
        Address of the scheduler of a cluster; None: a cluster is started on this machine.
    workers
        Number of jobs at the same time; None: one on this machine, or one on each worker of a scheduler, whenever it joins.
    wait
        Seconds to wait for a worker of the scheduler; `LONELY` unless given.

    Yields
    ------
    tuple
        Number of the job (from 0) and its result.

    Raises
    ------
    InputError
        If the backend is unknown, there is less than one worker, a package is missing, the scheduler does not answer, gets
        no workers or has other versions, or a worker died.
    RuntimeError
        If the exception of a job cannot be pickled. Other exceptions of jobs are raised as they are, once, and the
        remaining jobs dropped.
    """
    if backend not in BACKENDS:
        raise ArgumentError("backend", backend, " or ".join(BACKENDS), "leave it out for this machine")
    if workers is not None and workers < 1:
        raise ArgumentError("workers", str(workers), "1 or more", "every worker needs memory for a run")
    if scheduler is not None and backend != "dask":
        raise ArgumentError("scheduler", scheduler, "only with `backend=dask`", "add `backend=dask`")
    if wait is not None and scheduler is None:
        raise ArgumentError("wait_workers", f"{wait:g}", "only with `scheduler`", "leave it out")
    if wait is not None and not 0.0 <= wait <= 1e6:
        raise ArgumentError("wait_workers", f"{wait:g}", "0 to 1e6 seconds", "600 are ten minutes")
    calls = [job if isinstance(job, tuple) else (job, ()) for job in jobs]
    if backend == "joblib" and (workers or 1) == 1:
        return ((number, function(*arguments)) for number, (function, arguments) in enumerate(calls))
    return _elsewhere(calls, backend, scheduler, workers or 0, LONELY if wait is None else wait)


def _elsewhere(
    calls: list[tuple[Callable[..., Any], Sequence[Any]]], backend: str, scheduler: str | None, workers: int, wait: float
) -> Generator[tuple[int, Any], None, None]:
    """Run jobs in other processes or on a cluster, and yield number and result of each; raise a job's exception."""
    asked = [(number, __version__, *call) for number, call in enumerate(calls)]
    answers = _on_cluster(asked, scheduler, workers, wait) if backend == "dask" else _in_processes(asked, workers)
    with closing(answers):
        for number, good, packed in answers:
            value = pickle.loads(packed)
            if not good:
                raise value
            yield number, value


def _call(number: int, version: str, function: Callable[..., Any], arguments: Sequence[Any]) -> Answer:
    """Run one job in a worker; one at a time in a process, because gmsh has one state per process.

    A worker whose version is not ``version`` (it may have joined the cluster at any time) answers with an InputError.
    Results and exceptions are sent as bytes: joblib hangs on results that cannot be unpickled. Those of
    cloudpickle may hold functions without a name, as a table of the report has them.
    """
    import cloudpickle

    one_thread()
    with _ALONE:
        try:
            if version != __version__:
                raise _other_version(f"a worker of rollbench {__version__}, which joined later", version)
            return number, True, cloudpickle.dumps(function(*arguments))
        except Exception as error:
            note = f"In a worker: {traceback.format_exc()}"
            try:
                error.__cause__ = error.__context__ = None
                error.add_note(note)
                packed = pickle.dumps(error.with_traceback(None))
                pickle.loads(packed)
            except Exception:  # an exception that cannot travel, for whatever reason its class has: its words can
                plain = RuntimeError(f"{type(error).__name__}: {error}")
                plain.add_note(note)
                packed = pickle.dumps(plain)
            return number, False, packed


def _in_processes(asked: Sequence[Asked], workers: int) -> Generator[Answer, None, None]:
    """Run jobs in processes of this machine and yield answers as they come; closing drops the remaining jobs."""
    from joblib import Parallel, delayed
    from joblib.externals.loky.process_executor import BrokenProcessPool

    with local_workers():  # max_nbytes: no read-only arguments
        many = Parallel(workers, return_as="generator_unordered", pre_dispatch=workers, batch_size=1, max_nbytes=None)
        answers = many(delayed(_call)(*one) for one in asked)
        try:
            with without_restart_warnings():
                for answer in answers:  # noqa: UP028 - closed below, where its warning is not heard
                    yield answer
        except BrokenProcessPool as error:
            raise _died(error) from error
        finally:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # joblib tells how many jobs it drops
                answers.close()


def _on_cluster(asked: Sequence[Asked], scheduler: str | None, workers: int, wait: float) -> Generator[Answer, None, None]:
    """Run jobs on a cluster and yield the workers' answers as they come; closing drops the remaining jobs.

    The scheduler gets all jobs at once, or as many as may run at the same time: it hands them to workers whenever these
    join, and a cluster that adapts its size sees how much there is to do.
    """
    with _cluster(scheduler, workers) as client:
        from distributed import KilledWorker, as_completed

        left, running = deque(asked), 0
        looks = _looks(client, scheduler or "a cluster on this machine", wait)
        next(looks)  # before the first job: a worker that dies of it was there
        looked = monotonic()
        done = as_completed([], loop=client.loop)
        try:
            while left or running:
                while left and running < (workers or len(asked)):
                    done.add(client.submit(_call, *left.popleft(), pure=False))
                    running += 1
                if done.has_ready():
                    running -= 1
                    yield next(done).result()
                elif monotonic() - looked < LOOK:
                    sleep(BLINK)
                else:
                    next(looks)
                    looked = monotonic()
        except (KilledWorker, CancelledError) as error:
            if isinstance(error, CancelledError) and scheduler is not None and not _alive(scheduler):
                raise _lost(f"{scheduler}: the scheduler does not answer any more") from error
            raise _died(error) from error
        except ImportError as error:
            place = f"a worker without rollbench, which joined later ({error})"
            raise ArgumentError("scheduler", place, "workers with rollbench", INSTALL) from error


def _looks(client: Any, place: str, wait: float) -> Iterator[None]:
    """Check the state of a cluster once per item requested from the generator.

    Raises InputError if no job can run: no worker joins in ``wait`` seconds, at first or after the last was lost, or
    the scheduler does not answer any more.
    """
    alone, silent, had_workers = 0.0, 0.0, False
    while True:
        try:
            workers = len(client.sync(client.scheduler.identity, callback_timeout=PATIENCE)["workers"])
            silent = 0.0
        except TimeoutError as error:  # busy, it may be
            silent += PATIENCE
            if silent > SILENCE:
                raise _lost(f"{place}: the scheduler has not answered for {SILENCE:g} s") from error
        except Exception as error:  # whatever a connection that is gone raises
            raise _lost(f"{place}: the scheduler does not answer any more ({type(error).__name__})") from error
        else:
            had_workers = had_workers or workers > 0
            if workers == 0 and alone == 0.0:
                for_one = f"waiting {wait:g} s for {'another' if had_workers else 'a worker'}"
                sys.stderr.write(f"rollbench: {place}: {'the last worker is lost; ' * had_workers}{for_one}\n")
            alone = 0.0 if workers else alone + LOOK
            if alone > wait:
                if had_workers:
                    raise _lost(f"{place}: the last worker is lost, and none came in {wait:g} s")
                start = f"start some with: dask worker {place}; where they take longer to come: `wait_workers=600`"
                raise _no_cluster(place, f"no workers in {wait:g} s", start)
        yield


def _no_cluster(place: str, reason: str, advice: str) -> InputError:
    """Return the error for a scheduler that cannot be used."""
    return ArgumentError("scheduler", f"{place}: {reason}", "a scheduler with workers", advice)


def _lost(reason: str) -> InputError:
    """Return the error for a cluster that was lost while jobs ran."""
    return ArgumentError("scheduler", reason, "a scheduler with workers", AGAIN)


def _died(error: BaseException) -> InputError:
    """Return the error for a worker that died."""
    allowed, advice = "as many as there is memory for", "use fewer workers, those whose memory runs out are killed"
    return ArgumentError("workers", f"a worker that died ({type(error).__name__})", allowed, advice)


def use_tls(ca: str | None, cert: str | None, key: str | None) -> None:
    """Set the certificates for a scheduler at tls://HOST:PORT.

    Parameters
    ----------
    ca
        Certificate of the authority; None: no certificates.
    cert
        Certificate of this client.
    key
        Key of this client.

    Raises
    ------
    InputError
        If a file cannot be read, only some of the three are given, or Dask is missing.
    """
    given = {"tls_ca": ca, "tls_cert": cert, "tls_key": key}
    if not any(given.values()):
        return
    for name, value in given.items():
        if value is None:
            raise ArgumentError(name, "nothing", "all of `tls_ca`, `tls_cert`, `tls_key`", "give all three")
        try:
            with open(value, "rb"):
                pass
        except OSError as error:
            raise ArgumentError(name, f"{value}: {error.strerror}", "a PEM file", "check the path") from None
    try:
        import dask
        import distributed  # noqa: F401 - its defaults would overwrite these
    except ImportError:
        advice = "pip install 'rollbench[cluster]'"
        raise ArgumentError("tls_ca", "dask is not installed", "dask and distributed", advice) from None
    tls = "distributed.comm.tls"
    dask.config.set({f"{tls}.ca-file": ca, f"{tls}.client.cert": cert, f"{tls}.client.key": key})
    dask.config.set({"distributed.comm.require-encryption": True})


@contextmanager
def _cluster(scheduler: str | None, workers: int) -> Iterator[Any]:
    """Yield a Dask client of the scheduler, or of a cluster started on this machine; InputError if that fails."""
    try:
        from distributed import Client, LocalCluster
    except ImportError:
        raise ArgumentError(
            "backend", "dask without its packages", "dask and distributed installed", "pip install 'rollbench[cluster]'"
        ) from None
    place = "a cluster on this machine" if scheduler is None else scheduler
    with ExitStack() as stack:
        address: Any = scheduler
        if scheduler is None:
            address = stack.enter_context(
                LocalCluster(n_workers=workers or 1, threads_per_worker=1, dashboard_address="127.0.0.1:0", memory_limit=0)
            )
        else:
            try:
                asyncio.run(asyncio.wait_for(_greet(scheduler), PATIENCE))
            except Exception as error:  # nothing there, or something that is no scheduler
                start = "start one with: dask scheduler; its address looks like tcp://host:8786"
                raise _no_cluster(place, f"no answer of a scheduler ({type(error).__name__})", start) from error
        client = stack.enter_context(Client(address, timeout=PATIENCE, set_as_default=False))
        try:
            versions = set(
                client.run(_version).values()
            )  # of the workers that are there; `_call` asks those that join later
        except Exception as error:
            raise _no_cluster(place, f"workers without rollbench ({error})", INSTALL) from error
        if versions - {__version__}:
            others = ", ".join(sorted(versions))
            raise _other_version(f"{place}: workers of rollbench {others}", __version__)
        yield client


def _other_version(value: str, version: str) -> InputError:
    """Return the error for workers with another version of this program."""
    advice = f"install version {version} where the workers run"
    return ArgumentError("scheduler", value, f"workers of rollbench {version}", advice)


def _alive(scheduler: str) -> bool:
    """Return whether a scheduler answers."""
    try:
        asyncio.run(asyncio.wait_for(_greet(scheduler), PATIENCE))
    except Exception:  # whatever a connection that is gone raises
        return False
    return True


async def _greet(scheduler: str) -> None:
    """Connect to the scheduler, and raise if it does not answer; a failed Client would delay the process's end."""
    from distributed.core import connect
    from distributed.security import Security

    comm = await connect(scheduler, **Security().get_connection_args("client"))
    await comm.close()


def _version() -> str:
    """Return this program's version; run on the workers of a cluster."""
    return __version__
