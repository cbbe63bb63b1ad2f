"""Compute the missing 3D results, by ``python -m rollbench.compare.cases.lin.reconstruction``."""

from __future__ import annotations

from rollbench.compare.cases.lin.reconstruction.readings import RUNS, compute_missing
from rollbench.compare.running import on_terminal
from rollbench.meshes.cache import default_root

compute_missing(on_terminal, default_root())
on_terminal(f"all runs are in {RUNS}; what follows from them: rollbench report --only reconstruction")
