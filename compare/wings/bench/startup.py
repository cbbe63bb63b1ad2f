"""Start-up, measured from outside: imports, first call of the command line, compiled kernels with and without a cache."""

from __future__ import annotations

import json
import subprocess
import tempfile
from collections.abc import Iterator

from rollbench.compare.wings.bench.costs.timing import Job, launch

#: The command that is timed.
COMMAND = "rollbench solve lin-case1 --json"


def command_line_job() -> Job:
    """First solve from the command line, process start to exit."""
    seconds, done = launch(["-m", *COMMAND.split()])
    try:
        solver = json.loads(done.stdout)["solver"]
        unknowns, failed = int(solver["unknowns"]), done.returncode != 0
    except (ValueError, KeyError, TypeError):
        unknowns, failed = 0, True
    if failed:
        last = done.stderr.strip().splitlines()[-1:] or ["no message"]
        return Job("first call, command line", None, None, None, None, f"not measured: {last[0][:120]}")
    note = f"python -m {COMMAND}: interpreter, imports, solve and output"
    return Job("first call, command line", seconds, None, unknowns, None, note)


def startup_jobs() -> Iterator[Job]:
    """Import time, and the time to compile the kernels into an empty cache, each in a process of its own."""
    code = (
        "from time import perf_counter as t; a = t()\n"
        "from rollbench.meshes.threads import one_thread; one_thread()\n"
        "from rollbench.compare.scenes.catalogue import scene\n"
        "from rollbench.lowfi.statics.static import solve_static; b = t()\n"
        "s = scene('lin-case1'); solve_static(s, engine={engine!r}); c = t(); solve_static(s, engine={engine!r})\n"
        "print(b - a, c - b - (t() - c))"
    )
    _, done = launch(["-c", code.format(engine="interpreted")])
    note = "imports of a low-order solve (numpy among them), after the interpreter's own start"
    yield Job("imports", _number(done, 0), None, None, None, note)
    with tempfile.TemporaryDirectory() as cache:
        for job, note in (
            ("compile the kernels", "first compiled solve less a second one, with an empty cache: once per machine"),
            ("load the kernels", "the same with the cache filled: once per process that uses compiled kernels"),
        ):
            _, done = launch(["-c", code.format(engine="compiled")], {"NUMBA_CACHE_DIR": cache})
            yield Job(job, _number(done, 1), None, None, None, note)


def _number(done: subprocess.CompletedProcess[str], place: int) -> float | None:
    return float(done.stdout.split()[place]) if done.returncode == 0 else None
