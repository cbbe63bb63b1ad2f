"""Parallel computation of the parts of one set-up in several processes of this machine.

gmsh and the sparse factorisation handle one part at a time in each process.
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
from rollbench.meshes.processes import end_with_parent, one_thread_variables, peak_MB, reset_peak, without_restart_warnings


class Job(NamedTuple):
    """Record to be computed, or read from the cache; all fields can be pickled."""

    #: Name of the stage of the set-up to which the job belongs.
    stage: str
    #: Function that computes the record, as for `Cache.get`.
    build: Callable[..., Any]
    #: Arguments of the function.
    arguments: tuple[Any, ...]
    #: Class of the record.
    type_: type


@dataclass(frozen=True)
class ComputedRecord:
    """Computed record, with the time and memory that it took."""

    #: The record.
    value: Any
    #: Time of computing or reading it [s].
    seconds: float
    #: Whether it came from the cache.
    cached: bool
    #: Time of computing it, also if it came from the cache [s].
    cold_seconds: float
    #: Identifier of the process that computed it.
    process: int
    #: Peak memory of that process [MB]; None: not measured.
    peak_MB: float | None
    #: Reason why that process no longer writes to the cache; empty if it writes.
    cache_fault: str = ""


def compute_records(
    jobs: Sequence[Job], cache: Cache, processes: int, report: Callable[[int, ComputedRecord], None] = lambda *_: None
) -> list[ComputedRecord]:
    """Compute the records of independent jobs in several processes, of which this process is one.

    The other processes use one thread each, unless the user's environment variables allow more.

    Parameters
    ----------
    jobs : Sequence[Job]
        The jobs.
    cache : Cache
        Cache of records.
    processes : int
        Number of processes.
    report : Callable[[int, ComputedRecord], None], optional
        Called with the index of each job and its record, one at a time.

    Returns
    -------
    list[ComputedRecord]
        Records in the order of the jobs.

    Raises
    ------
    MemoryError
        A worker process was ended from outside.
    """
    if processes == 1 or len(jobs) < 2:
        alone = []
        for k, job in enumerate(jobs):
            alone.append(_compute_or_read(job, cache))
            report(k, alone[-1])
        return alone
    from joblib.executor import get_memmapping_executor  # the workers of joblib.Parallel, not further ones
    from joblib.externals.loky.process_executor import BrokenProcessPool

    helpers = min(processes, len(jobs)) - 1
    of_worker = {"initializer": end_with_parent, "initargs": (os.getpid(),), "env": one_thread_variables()}
    others = get_memmapping_executor(helpers, **of_worker, max_nbytes=None)
    left, done, one_at_a_time = deque(enumerate(jobs)), dict[int, ComputedRecord](), Lock()

    def take_jobs(maker: Callable[[Job], ComputedRecord]) -> None:
        """Take jobs and compute their records by the function ``maker`` until none is left."""
        while left:
            try:
                k, job = left.popleft()
            except IndexError:  # another thread was faster
                return
            done[k] = maker(job)
            with one_at_a_time:
                report(k, done[k])

    def run_in_worker(job: Job) -> ComputedRecord:
        """Compute the record of a job in a worker process."""
        found: ComputedRecord = others.submit(_compute_in_worker, job, cache).result()
        return found

    with without_restart_warnings(), ThreadPoolExecutor(helpers) as threads:
        helping = [threads.submit(take_jobs, run_in_worker) for _ in range(helpers)]
        try:
            take_jobs(lambda job: _compute_or_read(job, cache))
            for future in helping:
                future.result()
        except BrokenProcessPool as error:
            raise MemoryError("a process of the set-up was ended from outside: is there enough memory?") from error
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


def _compute_in_worker(job: Job, cache: Cache) -> ComputedRecord:
    """Compute the record of a job in a worker process, whose memory peak is reset first."""
    reset_peak()
    cache.quiet = True
    return _compute_or_read(job, cache)


def _compute_or_read(job: Job, cache: Cache) -> ComputedRecord:
    """Compute the record of a job in this process, or read it from the cache, and measure its time and memory."""
    start, hits, cold = perf_counter(), cache.hits, cache.cold_seconds
    value = cache.get(job.build, job.arguments, job.type_)
    spent, known = perf_counter() - start, cache.cold_seconds - cold
    return ComputedRecord(value, spent, cache.hits > hits, known, os.getpid(), peak_MB(), cache.fault)
