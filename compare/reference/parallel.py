"""Execution of independent jobs: in this process, in several processes of this machine (joblib), or on a Dask cluster.

By default jobs run one after another, because a run of the 3D reference takes gigabytes, and its set-up uses all cores.
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
from rollbench.meshes.processes import limit_to_one_thread, single_thread_workers, without_restart_warnings

#: Job: a function without arguments, or a function and its arguments; picklable if it runs in another process.
Job = Callable[[], Any] | tuple[Callable[..., Any], Sequence[Any]]
#: Request to a worker: number of the job, version of this program, function and arguments.
Asked = tuple[int, str, Callable[..., Any], Sequence[Any]]
#: Reply of a worker: number of the job, whether it succeeded, its pickled result or exception.
Answer = tuple[int, bool, bytes]

#: Names of the ways to run jobs: in processes of this machine, or on a Dask cluster.
BACKENDS = ("joblib", "dask")
#: Time to wait for one reply of the scheduler [s].
PATIENCE = 5.0
#: Default time to wait for the first worker of a cluster, and for another worker after the last one was lost [s].
LONELY = 60.0
#: Interval at which the state of the cluster is checked, and interval at which finished jobs are looked for [s].
LOOK, BLINK = 1.0, 0.02
#: Advice in the error message when the scheduler or the workers of a cluster were lost.
AGAIN = "find out what ended the cluster, restart it, and repeat the command; stored runs are not computed again"
#: Advice in the error message about workers of a cluster without rollbench.
INSTALL = "install rollbench where the workers run"

#: Lock by which a worker process runs one job at a time.
_ALONE = threading.Lock()


def run_jobs(
    jobs: Sequence[Job], backend: str = "joblib", scheduler: str | None = None, workers: int | None = None
) -> Generator[tuple[int, Any], None, None]:
    """Run independent jobs and yield each result as soon as it is available.

    Closing the generator cancels the remaining jobs.

    Parameters
    ----------
    jobs
        Functions, with or without arguments.
    backend
        ``joblib`` for this machine, ``dask`` for a cluster.
    scheduler
        Address of the scheduler of a cluster; None: a cluster is started on this machine.
    workers
        Number of jobs that run at the same time; None: one on this machine, or one on each worker of a scheduler.

    Yields
    ------
    tuple
        Number of the job (from 0) and its result.

    Raises
    ------
    InputError
        If the backend is unknown, the number of workers is below one, a package is missing, the scheduler does not answer,
        has no workers or workers of other versions, or a worker died.
    RuntimeError
        If a job raised an exception that cannot be pickled. Other exceptions of jobs are raised unchanged, and the
        remaining jobs are cancelled.
    """
    if backend not in BACKENDS:
        raise ArgumentError("backend", backend, " or ".join(BACKENDS), "leave `backend` out to compute on this machine")
    if workers is not None and workers < 1:
        raise ArgumentError("workers", str(workers), "1 or more", "choose as many as the memory allows")
    if scheduler is not None and backend != "dask":
        raise ArgumentError("scheduler", scheduler, "only with `backend=dask`", "add `backend=dask`")
    calls = [job if isinstance(job, tuple) else (job, ()) for job in jobs]
    if backend == "joblib" and (workers or 1) == 1:
        return ((number, function(*arguments)) for number, (function, arguments) in enumerate(calls))
    return _run_in_workers(calls, backend, scheduler, workers or 0)


def _run_in_workers(
    calls: list[tuple[Callable[..., Any], Sequence[Any]]], backend: str, scheduler: str | None, workers: int
) -> Generator[tuple[int, Any], None, None]:
    """Run jobs in other processes or on a cluster, and yield number (from 0) and result of each.

    ``calls``: function and arguments of each job; ``backend``, ``scheduler``: as for `run_jobs`; ``workers``: number of
    simultaneous jobs (0: as many as the cluster has workers). The exception of a job is raised here.
    """
    asked = [(number, __version__, *call) for number, call in enumerate(calls)]
    answers = _run_on_cluster(asked, scheduler, workers) if backend == "dask" else _run_in_processes(asked, workers)
    with closing(answers):
        for number, good, packed in answers:
            value = pickle.loads(packed)
            if not good:
                raise value
            yield number, value


def _run_job(number: int, version: str, function: Callable[..., Any], arguments: Sequence[Any]) -> Answer:
    """Run one job in a worker process, and return its number, whether it succeeded, and its pickled result or exception.

    ``number``: number of the job; ``function``, ``arguments``: the job. A process runs one job at a time, because gmsh has
    one state per process. A worker of another version of rollbench than ``version``, which may have joined the cluster at
    any time, returns an InputError. Results and exceptions are sent as bytes, because joblib hangs on results that cannot
    be unpickled; cloudpickle is used because jobs may contain lambdas.
    """
    import cloudpickle

    limit_to_one_thread()
    with _ALONE:
        try:
            if version != __version__:
                advice = f"install version {version} where the workers run"
                other = f"a worker of rollbench {__version__}"
                raise ArgumentError("scheduler", other, f"workers of rollbench {version}", advice)
            return number, True, cloudpickle.dumps(function(*arguments))
        except Exception as error:
            note = f"In a worker: {traceback.format_exc()}"
            try:
                error.__cause__ = error.__context__ = None
                error.add_note(note)
                packed = pickle.dumps(error.with_traceback(None))
                pickle.loads(packed)
            except Exception:  # the exception cannot be pickled: send its text
                plain = RuntimeError(f"{type(error).__name__}: {error}")
                plain.add_note(note)
                packed = pickle.dumps(plain)
            return number, False, packed


def _run_in_processes(requests: Sequence[Asked], workers: int) -> Generator[Answer, None, None]:
    """Run jobs in processes of this machine, and yield their replies as they arrive.

    ``requests``: requests to the processes; ``workers``: number of processes. Closing the generator cancels the remaining
    jobs.
    """
    from joblib import Parallel, delayed
    from joblib.externals.loky.process_executor import BrokenProcessPool

    with single_thread_workers():  # max_nbytes: no read-only arguments
        many = Parallel(workers, return_as="generator_unordered", pre_dispatch=workers, batch_size=1, max_nbytes=None)
        answers = many(delayed(_run_job)(*one) for one in requests)
        try:
            with without_restart_warnings():
                for answer in answers:  # noqa: UP028 - closed below, where its warning is suppressed
                    yield answer
        except BrokenProcessPool as error:
            raise _dead_worker_error(error) from error
        finally:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # joblib warns of cancelled jobs
                answers.close()


def _run_on_cluster(requests: Sequence[Asked], scheduler: str | None, workers: int) -> Generator[Answer, None, None]:
    """Run jobs on a Dask cluster, and yield the workers' replies as they arrive; closing cancels the remaining jobs.

    ``requests``: requests to the workers; ``scheduler``: address; None: a cluster is started on this machine; ``workers``:
    number of simultaneous jobs; 0: no limit. The scheduler gets all jobs at once, or as many as may run at the same time.
    It assigns them to workers as these join. From the number of waiting jobs, a cluster of adaptive size decides how many
    workers to start. The Dask backend of joblib waits for ever where a worker dies, so that it is not used.
    """
    with _connect_to_cluster(scheduler, workers) as client:
        from distributed import KilledWorker, as_completed

        left, running = deque(requests), 0
        looks = _check_cluster_repeatedly(client, scheduler or "a cluster on this machine")
        next(looks)  # before the first job, so that a worker that this job kills is counted
        looked = monotonic()
        done = as_completed([], loop=client.loop)
        try:
            while left or running:
                while left and running < (workers or len(requests)):
                    done.add(client.submit(_run_job, *left.popleft(), pure=False))
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
            if isinstance(error, CancelledError) and scheduler is not None and not _scheduler_answers(scheduler):
                raise _cluster_error(f"{scheduler}: the scheduler no longer answers") from error
            raise _dead_worker_error(error) from error
        except ImportError as error:
            place = f"a worker without rollbench, which joined the cluster during the computation ({error})"
            raise ArgumentError("scheduler", place, "workers with rollbench", INSTALL) from error


def _check_cluster_repeatedly(client: Any, place: str) -> Iterator[None]:
    """Yield after each check that a Dask cluster has workers and its scheduler answers.

    ``client``: Dask client of the cluster; ``place``: address of the scheduler, for messages. InputError if no worker joins
    within `LONELY` seconds, at the beginning or after the last one was lost, or if the scheduler no longer answers.
    """
    alone, had_workers = 0.0, False
    while True:
        try:
            workers = len(client.sync(client.scheduler.identity, callback_timeout=PATIENCE)["workers"])
        except TimeoutError:  # the scheduler is busy
            pass
        except Exception as error:  # any error of a closed connection
            raise _cluster_error(f"{place}: the scheduler no longer answers ({type(error).__name__})") from error
        else:
            had_workers = had_workers or workers > 0
            if workers == 0 and alone == 0.0:
                for_one = f"waiting {LONELY:g} s for {'another' if had_workers else 'a worker'}"
                sys.stderr.write(f"rollbench: {place}: {'the last worker was lost; ' * had_workers}{for_one}\n")
            alone = 0.0 if workers else alone + LOOK
            if alone > LONELY:
                if had_workers:
                    raise _cluster_error(f"{place}: the last worker was lost, and no other joined within {LONELY:g} s")
                reason, advice = f"no workers within {LONELY:g} s", f"start workers with: dask worker {place}"
                raise _cluster_error(f"{place}: {reason}", advice)
        yield


def _cluster_error(reason: str, advice: str = AGAIN) -> InputError:
    """Return the error for a Dask cluster that cannot be used or has been lost.

    ``reason``: what is wrong, with the scheduler's address; ``advice``: remedy.
    """
    return ArgumentError("scheduler", reason, "a scheduler with workers", advice)


def _dead_worker_error(error: BaseException) -> InputError:
    """Return the error to raise if a worker process died, for example for lack of memory; ``error``: what was caught."""
    allowed, advice = "as many as the memory allows", "use fewer workers; a worker that runs out of memory is killed"
    return ArgumentError("workers", f"a worker that died ({type(error).__name__})", allowed, advice)


@contextmanager
def _connect_to_cluster(scheduler: str | None, workers: int) -> Iterator[Any]:
    """Yield a Dask client that is connected to a scheduler; InputError if that fails.

    ``scheduler``: its address; None: a cluster with ``workers`` workers is started on this machine (0: with one).
    """
    try:
        from distributed import Client, LocalCluster
    except ImportError:
        raise ArgumentError(
            "backend", "dask", "only with dask and distributed installed", "pip install 'rollbench[cluster]'"
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
                asyncio.run(asyncio.wait_for(_try_connection(scheduler), PATIENCE))
            except Exception as error:  # nothing there, or something that is no scheduler
                start = "start one with: dask scheduler; its address looks like tcp://host:8786"
                raise _cluster_error(f"{place}: no answer of a scheduler ({type(error).__name__})", start) from error
        client = stack.enter_context(Client(address, timeout=PATIENCE, set_as_default=False))
        try:
            client.run(_rollbench_version)
        except Exception as error:
            raise _cluster_error(f"{place}: workers without rollbench ({error})", INSTALL) from error
        yield client


def _scheduler_answers(scheduler: str) -> bool:
    """Return whether a Dask scheduler at the address ``scheduler`` (such as tcp://host:8786) accepts a connection."""
    try:
        asyncio.run(asyncio.wait_for(_try_connection(scheduler), PATIENCE))
    except Exception:  # any error of a closed connection
        return False
    return True


async def _try_connection(scheduler: str) -> None:
    """Connect to the scheduler at an address, and raise if it does not answer.

    A Dask client that fails to connect would delay the end of the process.
    """
    from distributed.core import connect
    from distributed.security import Security

    comm = await connect(scheduler, **Security().get_connection_args("client"))
    await comm.close()


def _rollbench_version() -> str:
    """Return the version of this program; called on the workers of a cluster, which fails where they have no rollbench."""
    return __version__
