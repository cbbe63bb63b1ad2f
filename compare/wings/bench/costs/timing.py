"""Seconds of a piece of work, and what is told of them; processes that are timed from outside."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from time import perf_counter

from rollbench.meshes.threads import VARIABLES


@dataclass(frozen=True)
class Job:
    """One timed job.

    seconds: median wall clock (None: not measured); ratio: seconds of the source's formulation for the same task over
    these (None where it has no counterpart, or is the counterpart); unknowns of one solve; peak_MB: highest resident
    memory of the whole process, interpreter and libraries included, since the first job of its group (cold, warm,
    ensemble, ...; each number of balls is a group) began; note: what is included. Of a job that a user waits for also aim
    [s]; floor [s]: what no change here can save, measured, and of what (floor_of); modules [s]: with the import of the
    package's own besides; when: version, day and machine of a time that is kept, empty for one of this run.
    """

    job: str
    seconds: float | None
    ratio: float | None
    unknowns: int | None
    peak_MB: float | None
    note: str
    aim: float | None = None
    floor: float | None = None
    floor_of: str = ""
    modules: float | None = None
    when: str = ""


def timed(work: Callable[[], object], repeats: int, reset: Callable[[], object] | None = None) -> float:
    """Median wall clock of ``work`` [s], after one run that is not counted; ``reset`` runs before each, untimed."""
    seconds = []
    gc.collect()
    enabled = gc.isenabled()
    gc.disable()
    try:
        for _ in range(repeats + 1):
            if reset is not None:
                reset()
            begin = perf_counter()
            work()
            seconds.append(perf_counter() - begin)
    finally:
        if enabled:
            gc.enable()
    return median(seconds[1:])


def as_a_users(extra: dict[str, str] | None = None) -> dict[str, str]:
    """Environment of a process that is timed, with further variables: that of a user who has set no number of threads."""
    return {name: value for name, value in os.environ.items() if name not in VARIABLES} | (extra or {})


def launch(
    arguments: list[str], extra: dict[str, str] | None = None, limit: float = 300.0
) -> tuple[float, subprocess.CompletedProcess[str]]:
    """Wall clock of a Python process [s], which imports nothing from the working folder, and what it left; limit [s]."""
    environment = as_a_users(extra)
    begin = perf_counter()
    process = subprocess.run(
        [sys.executable, "-P", *arguments], capture_output=True, text=True, env=environment, check=False, timeout=limit
    )
    return perf_counter() - begin, process
