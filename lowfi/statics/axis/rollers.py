"""Rollers as well as balls between elastic bodies: one element a roller, its ring motions from those of shaft and housing.

A ring moves as a rigid body, so that a slice's approach is that of the roller's middle plus its place times the slope along
the roller: two motions at each ring hold all slices, and the slices' law is that of the model lin.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.rollers import middles
from rollbench.lowfi.statics.axis.system import RollerSet
from rollbench.lowfi.statics.kernel_types import RollerContacts
from rollbench.meshes.arrays import Array


@dataclass(frozen=True)
class RollerElements:
    """M rollers of all rows. node (M,): of the shaft; outer (M,): row of the cup's motions, -1 where it stands; B
    (M, 2, 2, 6): the normal motion of cone and cup at the roller's middle, and its slope along the roller times the
    length [m], by the motions of those rows."""

    node: NDArray[np.int64]
    outer: NDArray[np.int64]
    B: Array
    contacts: RollerContacts

    @property
    def count(self) -> int:
        """Number of rollers."""
        return self.node.size


def roller_elements(sets: list[RollerSet]) -> RollerElements:
    """Rollers of all rows, one after the other."""
    M, K = sum(r.row.count for r in sets), max((r.row.slices for r in sets), default=0)
    node, outer = np.zeros(M, dtype=np.int64), np.full(M, -1, dtype=np.int64)
    B, law = np.zeros((M, 2, 2, 6)), np.zeros((2, M))
    place, width, drop = np.zeros((3, M, K))
    first = 0
    for r in sets:
        a, n = r.arrays, r.row.slices
        mine = slice(first, first + r.row.count)
        first = mine.stop
        x = middles(r.row.length, n) / r.row.length
        rows = a.B.reshape(r.row.count, n, 2, 6) * np.array([1.0, -1.0])[:, None]  # lin takes the approach, this motions
        base = np.linalg.pinv(np.column_stack([np.ones(n), x])) if n > 1 else np.array([[1.0], [0.0]])
        B[mine] = np.einsum("ak,ikej->ieaj", base, rows)
        place[mine, :n] = x
        width[mine, :n], drop[mine, :n] = a.width.reshape(-1, n), a.drop.reshape(-1, n)
        law[0, mine], law[1, mine] = a.g[0], a.s[0]
        node[mine], outer[mine] = a.row[0]
    return RollerElements(node, outer, B, RollerContacts(place, width, drop, *law))


def roller_springs(count: int, stiffness: float) -> Array:
    """Linear springs between cone and cup at the rollers' middles in place of slices, (count, 2, 8), as
    `lowfi.statics.elastic_system.spring_rows`."""
    rows = np.zeros((count, 2, 8))
    rows[:, 0, 0], rows[:, 0, 4] = np.sqrt(stiffness), -np.sqrt(stiffness)
    return rows
