"""What people wait for: commands as they are typed, first with nothing in the user's folders; members in threads."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

from rollbench.compare.scenes.catalogue import scene
from rollbench.compare.studies.members.ensemble import run_ensemble
from rollbench.compare.studies.run_times.timing import Job, launch, timed

#: Commands that are timed.
COMMANDS = (
    "list",
    "solve lin-case1",
    "solve lin-case1 --model lin",
    "friction lin-case1",
    "solve lin-random --members 1000",
    "check lin-case1 --no-compute",
)
#: Members of an ensemble, and numbers of threads.
MEMBERS, THREADS = 1000, (1, 2)


def typed(command: str) -> Job:
    """Wall clock of a command from start to end in an empty home, then again there; a note where it fails."""
    with tempfile.TemporaryDirectory() as home:
        places = {
            "HOME": "",
            "XDG_CACHE_HOME": "cache",
            "ROLLBENCH_CACHE": "cache/rollbench",
            "NUMBA_CACHE_DIR": "cache/numba",
        }
        own = {name: str(Path(home) / place) for name, place in places.items()}
        spent = []
        for _ in range(2):
            seconds, done = launch(["-m", "rollbench", *command.split(), "--json"], own)
            if done.returncode != 0:
                last = done.stderr.strip().splitlines()[-1:] or ["no message"]
                return Job(f"{command}, from an empty home", None, note=f"not measured: {last[0][:120]}")
            spent.append(seconds)
    return Job(f"{command}, from an empty home", spent[0], note=f"wall clock of the process; again: {spent[1]:.3g} s")


def in_threads(count: int = MEMBERS, repeats: int = 3) -> Iterator[Job]:
    """An ensemble of ``lin-random`` by the model lin in one and in two threads; ratio: one thread's time over it."""
    parts = scene("lin-random")
    alone = 0.0
    for threads in THREADS:

        def work(threads: int = threads) -> object:
            return run_ensemble(parts, count, threads=threads)

        seconds = timed(work, repeats)
        alone = alone or seconds
        name = f"{count} members of lin-random, threads: {threads}"
        yield Job(name, seconds, alone / seconds, note="model lin, compiled; ratio: one thread's time over this")
