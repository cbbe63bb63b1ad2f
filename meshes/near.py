"""Pairs of points that are near one another."""

from __future__ import annotations

import numpy as np

from rollbench.meshes.arrays import Array, Index

#: Number of points up to which all distances are computed: quicker than to import a tree and grow it.
FEW = 500


def close_pairs(points: Array, reach: float) -> Index:
    """Indices ``(m, 2)``, the lower first, of points ``(n, 3)`` [m] no farther than ``reach`` [m] apart, sorted."""
    if len(points) > FEW:
        from scipy.spatial import cKDTree

        pairs = np.sort(cKDTree(points).query_pairs(reach, output_type="ndarray"), axis=1)
        return np.asarray(pairs[np.lexsort(pairs.T[::-1])])
    i, j = np.triu_indices(len(points), 1)
    near = np.linalg.norm(points[i] - points[j], axis=1) <= reach
    return np.column_stack([i[near], j[near]])
