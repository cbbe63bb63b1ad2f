"""``python -m rollbench.compare.cases.lin.reconstruction``: compute the 3D runs that are missing."""

from __future__ import annotations

from rollbench.compare.cases.lin.reconstruction.readings import RUNS, complete
from rollbench.compare.running import on_terminal
from rollbench.meshes.cache import default_root

complete(on_terminal, default_root())
on_terminal(f"all runs are in {RUNS}; what follows from them: rollbench report --only reconstruction")
