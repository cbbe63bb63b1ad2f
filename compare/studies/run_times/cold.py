"""Cold and warm run times of a low-order model on a scene, measured in a process of its own with empty caches.

Cold is what somebody waits for who has done nothing yet: a new interpreter, all imports, the set-up of the geometry and one
solve, with empty folders for meshes and for machine code. Compiled kernels are timed cold too, because their first call
compiles. Warm is a further solve in the same process: bodies of the geometry known, kernels compiled.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from time import time
from typing import Any

from rollbench.compare.studies.run_times.timing import as_a_users

#: Longest wait for a process [s].
PATIENCE = 600.0
#: Solves whose fastest is the warm time.
REPEATS = 5

CHILD = """
import sys
sys.path[:] = {path!r}
from time import perf_counter, time
from pathlib import Path
from rollbench.meshes.processes import one_thread
one_thread()
import json
from rollbench.compare.scenes import catalogue
from rollbench.meshes.processes import peak_MB
from rollbench.compare.models.registry import Options, run_model
ask = json.loads({ask!r})
scene = catalogue.scene(ask["scene"])
path = Path(ask["condensed"]) if ask["condensed"] else None
options = Options(discretisation=False, engine=ask["engine"], condensed=path)
spent = []
for _ in range(1 + ask["repeats"]):
    start = perf_counter()
    result = run_model(scene, ask["model"], options)
    spent.append(perf_counter() - start)
    if len(spent) == 1:
        done, memory = time(), peak_MB()
print(json.dumps({{"done": done, "first": spent[0], "warm": min(spent[1:]), "memory": memory, "status": result.status}}))
"""


#: A level as `compare` computes it, without a cache to read or a store to write.
LEVEL_CHILD = """
import sys
sys.path[:] = {path!r}
from time import time
from rollbench.meshes.processes import one_thread
one_thread()
import json
from rollbench.compare.reference.computing import compute
from rollbench.compare.reference.tasks import Task
from rollbench.compare.scenes import catalogue
from rollbench.compare.running import cores
ask = json.loads({ask!r})
(run,) = compute(Task((catalogue.scene(ask["scene"]),), ask["level"], processes=cores()))
contacts = int((run.load > 0.0).sum())
own = {{"memory": run.peak_MB, "status": run.status, "contacts": contacts, "load_case": run.solve_seconds}}
print(json.dumps({{"done": time(), "stages": run.stages, **own}}))
"""


@dataclass(frozen=True)
class ColdLevel:
    """A level of the 3D reference, from the start of the interpreter to its loads: seconds, CPU seconds of all processes,
    sum of their peaks of memory [MB] (None: not measured), status; scene, contacts with load, seconds that a further load
    case takes, and those of every stage of the set-up by name (None: not measured)."""

    level: int
    process: float
    cpu: float
    memory: float | None
    status: str
    scene: str = "lin-case1"
    contacts: int | None = None
    load_case: float | None = None
    stages: dict[str, float] | None = None


@dataclass(frozen=True)
class Cold:
    """Seconds of a model on a scene: ``process``, interpreter, imports and the first solve; ``first``, that solve alone;
    ``warm``, the fastest further one; peak memory [MB] of the process (None: not measured); engine; the solve's status."""

    process: float
    first: float
    warm: float
    memory: float | None
    engine: str
    status: str


def measure(
    scene: str, model: str, *, engine: str = "interpreted", condensed: Path | None = None, repeats: int = REPEATS
) -> Cold:
    """Times of a shipped scene in a new process with empty caches. Raises RuntimeError where the process fails."""
    ask = {
        "scene": scene,
        "model": model,
        "engine": engine,
        "repeats": repeats,
        "condensed": str(condensed.resolve()) if condensed else "",
    }
    begin, printed = _alone(CHILD, ask, f"{model} on {scene}")
    return Cold(printed["done"] - begin, printed["first"], printed["warm"], printed["memory"], engine, printed["status"])


def measure_level(scene: str, level: int) -> ColdLevel:
    """Times of a level of the 3D reference of a shipped scene in a new process with empty caches, on all cores. Raises
    RuntimeError where the process fails."""
    before = os.times()
    begin, printed = _alone(LEVEL_CHILD, {"scene": scene, "level": level}, f"level {level} of {scene}")
    after = os.times()
    cpu = sum(y - x for x, y in zip(before[2:4], after[2:4], strict=True))
    known = {name: printed[name] for name in ("contacts", "load_case", "stages")}
    return ColdLevel(level, printed["done"] - begin, cpu, printed["memory"], printed["status"], scene, **known)


def _alone(child: str, ask: dict[str, Any], what: str) -> tuple[float, dict[str, Any]]:
    """Run a new process with empty caches; when it began, and what it printed."""
    with tempfile.TemporaryDirectory() as folder:
        caches = {name: str(Path(folder) / name.lower()) for name in ("ROLLBENCH_CACHE", "NUMBA_CACHE_DIR")}
        for place in caches.values():
            Path(place).mkdir()
        code = child.format(path=[p for p in sys.path if p], ask=json.dumps(ask))
        begin = time()
        process = subprocess.run(
            [sys.executable, "-I", "-c", code],
            capture_output=True,
            text=True,
            check=False,
            timeout=PATIENCE,
            env=as_a_users(caches),
        )
    if process.returncode != 0:
        last = process.stderr.strip().splitlines()[-1:] or ["no message"]
        raise RuntimeError(f"{what}: the timing process failed: {last[0]}")
    return begin, json.loads(process.stdout)
