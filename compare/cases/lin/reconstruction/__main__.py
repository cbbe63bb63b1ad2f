"""``python -m rollbench.compare.cases.lin.reconstruction``: compute the 3D runs that are missing."""

from __future__ import annotations

from rollbench.compare.cases.lin.reconstruction.readings import RUNS, complete
from rollbench.compare.commands.terminal import cache_folder
from rollbench.compare.text.printing import on_terminal

complete(on_terminal, cache_folder())
on_terminal(f"all runs are in {RUNS}; what follows from them: rollbench report --only reconstruction")
