"""Normal contact on a grid of rectangles: pressure and gap not negative and complementary, at a given force."""

from __future__ import annotations

import numpy as np

from rollbench.hifi.rolling.elements import Solids, influence
from rollbench.meshes.arrays import Array, Index

#: Most changes of the active set.
MOST = 100


def normal_matrix(cells: Index, size: Array, solids: Solids) -> Array:
    """Compliance ``(n, n)`` [m/N] of normal forces, each spread evenly over its cell."""
    span = cells.max(axis=0) - cells.min(axis=0) + 1
    x, y = np.meshgrid(np.arange(span[0]) * size[0], np.arange(span[1]) * size[1], indexing="ij")
    table = influence(x, y, size[0], size[1], solids)[..., 2, 2] / (size[0] * size[1])
    apart = np.abs(cells[:, None] - cells[None])
    return np.asarray(table[apart[..., 0], apart[..., 1]])


def press(
    cells: Index, size: Array, gap: Array, load: float, solids: Solids, extra: Array | None = None
) -> tuple[Array, float]:
    """Forces ``(n,)`` [N] >= 0 of sum ``load`` and the approach [m] that closes the ``gap`` ``(n,)`` [m] where they act.

    extra ``(n, n)`` [m/N]: compliance beyond that of half spaces. Primal-dual active set; open cells carry exactly nothing.
    Raises ValueError where the set does not settle.
    """
    C = normal_matrix(cells, size, solids) + (0.0 if extra is None else extra)
    active = gap <= np.quantile(gap, 0.5)
    for _ in range(MOST):
        i = np.flatnonzero(active)
        K = np.ones((i.size + 1, i.size + 1))
        K[:-1, :-1], K[:-1, -1], K[-1, -1] = C[np.ix_(i, i)], -1.0, 0.0
        solved = np.linalg.solve(K, np.append(-gap[i], load))
        forces, approach = np.zeros(gap.size), float(solved[-1])
        forces[i] = solved[:-1]
        overlap = approach - gap - C @ forces
        closed = np.where(active, forces > 0.0, overlap > 0.0)
        if np.array_equal(closed, active):
            return forces, approach
        active = closed
    raise ValueError(f"the contact's active set did not settle in {MOST} changes")
