"""Compute the missing 3D results, by ``python -m rollbench.compare.cases.lin.reconstruction``."""

from __future__ import annotations

from rollbench.compare.cases.lin.reconstruction.explanations import RUNS, compute_missing_3d_results
from rollbench.compare.running import show_progress_message
from rollbench.meshes.cache import default_cache_folder

compute_missing_3d_results(show_progress_message, default_cache_folder())
show_progress_message(f"all runs are in {RUNS}; what follows from them: rollbench report --only reconstruction")
