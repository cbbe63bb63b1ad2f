"""Parts of one set-up computed in several processes of this machine.

gmsh and the sparse factor serve one part at a time in each process.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from threading import Lock
from time import perf_counter
from typing import Any, NamedTuple

from rollbench.meshes.cache import Cache
from rollbench.meshes.processes import end_with_parent, for_one_thread, peak_MB, reset_peak, restarts_unsaid


class Job(NamedTuple):
    """A record to be computed, or read from the cache; all fields can be pickled."""

    #: Name of its stage.
    stage: str
    #: Function, as for `Cache.get`.
    build: Callable[..., Any]
    #: Its arguments.
    arguments: tuple[Any, ...]
    #: Class of the record.
    type_: type


@dataclass(frozen=True)
class Made:
    """A record, and what it cost."""

    #: The record.
    value: Any
    #: Time it took [s].
    seconds: float
    #: Whether it came from the cache.
    cached: bool
    #: Time it took when it was computed [s].
    cold_seconds: float
    #: Process that computed it.
    process: int
    #: Peak memory of that process [MB]; None: not measured.
    peak_MB: float | None
    #: Why that process writes nothing to the cache any more; empty: it does.
    cache_fault: str = ""


def make(
    jobs: Sequence[Job], cache: Cache, processes: int, report: Callable[[int, Made], None] = lambda *_: None
) -> list[Made]:
    """Compute the records of independent jobs in several processes, this one among them.

    The other processes use one thread each, unless the user's variables give more.

    Parameters
    ----------
    jobs : Sequence[Job]
        The jobs.
    cache : Cache
        Cache of records.
    processes : int
        Number of processes.
    report : Callable[[int, Made], None], optional
        Called with the number of each job and its record, one at a time.

    Returns
    -------
    list[Made]
        Records in the order of the jobs.

    Raises
    ------
    MemoryError
        A process was ended from outside.
    """
    if processes == 1 or len(jobs) < 2:
        alone = []
        for k, job in enumerate(jobs):
            alone.append(_make(job, cache))
            report(k, alone[-1])
        return alone
    from joblib.executor import get_memmapping_executor  # the workers of joblib.Parallel, not further ones
    from joblib.externals.loky.process_executor import BrokenProcessPool

    helpers = min(processes, len(jobs)) - 1
    of_worker = {"initializer": end_with_parent, "initargs": (os.getpid(),), "env": for_one_thread()}
    others = get_memmapping_executor(helpers, **of_worker, max_nbytes=None)
    left, done, one_at_a_time = deque(enumerate(jobs)), dict[int, Made](), Lock()

    def take(maker: Callable[[Job], Made]) -> None:
        """Run jobs until none is left."""
        while left:
            try:
                k, job = left.popleft()
            except IndexError:  # another thread was faster
                return
            done[k] = maker(job)
            with one_at_a_time:
                report(k, done[k])

    def helped(job: Job) -> Made:
        found: Made = others.submit(_elsewhere, job, cache).result()
        return found

    with restarts_unsaid(), ThreadPoolExecutor(helpers) as threads:
        helping = [threads.submit(take, helped) for _ in range(helpers)]
        try:
            take(lambda job: _make(job, cache))
            for future in helping:
                future.result()
        except BrokenProcessPool as error:
            raise MemoryError("a process of the set-up was ended from outside: is there memory for it?") from error
        except KeyboardInterrupt:  # a job may take minutes: nobody waits for it
            others.terminate(kill_workers=True)
            raise
        finally:
            left.clear()
    away = [record.cached for record in done.values() if record.process != os.getpid()]
    cache.hits += sum(away)
    cache.misses += len(away) - sum(away)
    for record in done.values():
        cache.report(record.cache_fault)
    return [done[k] for k in range(len(jobs))]


def _elsewhere(job: Job, cache: Cache) -> Made:
    """Run a job in another process, whose record of memory starts at zero."""
    reset_peak()
    cache.quiet = True
    return _make(job, cache)


def _make(job: Job, cache: Cache) -> Made:
    start, hits, cold = perf_counter(), cache.hits, cache.cold_seconds
    value = cache.get(job.build, job.arguments, job.type_)
    spent, known = perf_counter() - start, cache.cold_seconds - cold
    return Made(value, spent, cache.hits > hits, known, os.getpid(), peak_MB(), cache.fault)
