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
    """A timed job: wall clock [s] (None: not measured), a ratio and what it is over (in ``note``), unknowns of one solve,
    peak memory of the process [MB], largest error of a contact load [% of the mean load]."""

    job: str
    seconds: float | None
    ratio: float | None = None
    unknowns: int | None = None
    peak_MB: float | None = None
    error_percent: float | None = None
    note: str = ""


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
