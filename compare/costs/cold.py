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

from compare.costs.timing import ROOT, SINGLE_THREAD

#: Longest wait for a process [s].
PATIENCE = 600.0
#: Solves whose fastest is the warm time.
REPEATS = 5

CHILD = """
import sys
sys.path.insert(0, {root!r})
from time import perf_counter, time
from pathlib import Path
import json
from compare.scenes import catalogue
from meshes.memory import peak_MB
from compare.models.registry import Options, run_model
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
    with tempfile.TemporaryDirectory() as folder:
        own = {name: str(Path(folder) / name.lower()) for name in ("ROLLBENCH_CACHE", "NUMBA_CACHE_DIR")}
        for place in own.values():
            Path(place).mkdir()
        code = CHILD.format(root=str(ROOT), ask=json.dumps(ask))
        begin = time()
        done = subprocess.run(
            [sys.executable, "-I", "-c", code],
            capture_output=True,
            text=True,
            check=False,
            timeout=PATIENCE,
            env={**os.environ, **SINGLE_THREAD, **own},
        )
    if done.returncode != 0:
        last = done.stderr.strip().splitlines()[-1:] or ["no message"]
        raise RuntimeError(f"{model} on {scene}: the timing process failed: {last[0]}")
    found = json.loads(done.stdout)
    return Cold(found["done"] - begin, found["first"], found["warm"], found["memory"], engine, found["status"])
