"""Eliminations x = C y + g: prescribed freedoms, tied interfaces, rigid sections, by the Galerkin product C^T K C.

Freedoms are numbered 3 * node + component; a rigid section adds six of its own behind the last. Slaves may follow
slaves: chains are substituted, loops refused.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from hifi.elasticity import rigid_modes
from hifi.elements import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Constraint:
    """x = C y + g. basis: C, shape (n, m); constant: g, shape (n,); free: number of each freedom of y, shape (m,).

    Numbers in `free` below n are freedoms of x itself, those from n on were added by rigid sections.
    """

    basis: sp.csr_matrix
    constant: FloatArray
    free: IntArray


class Rows:
    """Rows `slave = sum weight * master + constant`, collected for n freedoms before they are eliminated."""

    def __init__(self, size: int) -> None:
        """Start without rows; size: number of freedoms n of the mesh."""
        self.size = size
        self.total = size
        self._slaves: list[IntArray] = []
        self._weights: list[sp.coo_matrix] = []
        self._constants: list[FloatArray] = []

    def eliminate(self, slaves: IntArray, weights: sp.spmatrix, constants: FloatArray | float = 0.0) -> None:
        """Freedoms slaves (m,) follow weights @ x + constants; weights (m, up to all freedoms so far)."""
        slaves = np.asarray(slaves, dtype=np.int64).ravel()
        weights = sp.coo_matrix(weights)
        if weights.shape[0] != len(slaves) or weights.shape[1] > self.total:
            raise ValueError(f"weights have shape {weights.shape} for {len(slaves)} slaves of {self.total} freedoms")
        if slaves.size and not (slaves.min() >= 0 and slaves.max() < self.total):
            raise ValueError(f"slave freedoms {slaves.min()} to {slaves.max()} of {self.total}")
        self._slaves.append(slaves)
        self._weights.append(weights)
        self._constants.append(np.broadcast_to(np.asarray(constants, dtype=float), slaves.shape))

    def fix(self, freedoms: IntArray, values: FloatArray | float = 0.0) -> None:
        """Prescribe freedoms (m,) [m, or rad for a section's rotations]."""
        freedoms = np.asarray(freedoms, dtype=np.int64).ravel()
        self.eliminate(freedoms, sp.coo_matrix((len(freedoms), self.total)), values)

    def tie(self, slaves: IntArray, masters: IntArray, weights: FloatArray) -> None:
        """Nodes slaves (m,) follow the nodes masters (m, k) with weights (m, k), shape functions at their feet.

        Raises ValueError when the weights of a slave do not sum to 1 within 1e-9: a rigid motion would strain the tie.
        """
        slaves, masters, weights = np.asarray(slaves), np.asarray(masters), np.asarray(weights, dtype=float)
        if weights.shape != masters.shape or len(slaves) != len(masters):
            raise ValueError(f"tie: {slaves.shape} slaves, {masters.shape} masters, {weights.shape} weights")
        off = np.abs(weights.sum(axis=1) - 1.0)
        if off.size and off.max() > 1e-9:
            raise ValueError(f"tie: the weights of node {slaves[off.argmax()]} miss the sum 1 by {off.max():.3g}")
        rows = np.repeat(np.arange(len(slaves)), masters.shape[1])
        for k in range(3):
            entries = (weights.ravel(), (rows, 3 * masters.ravel() + k))
            self.eliminate(3 * slaves + k, sp.coo_matrix(entries, shape=(len(slaves), self.total)))

    def rigid(self, points: FloatArray, nodes: IntArray, centre: FloatArray) -> IntArray:
        """All nodes (m,) follow the small rigid motion of a section; returns its six added freedoms, shape (6,).

        Translations of the centre [m], then rotations about the three axes [rad]. points: all points (n, 3).
        """
        nodes = np.asarray(nodes, dtype=np.int64)
        added = np.arange(self.total, self.total + 6)
        self.total += 6
        modes = rigid_modes(np.asarray(points)[nodes], np.asarray(centre))
        rows, columns = np.nonzero(modes)
        weights = sp.coo_matrix((modes[rows, columns], (rows, added[columns])), shape=(len(modes), self.total))
        self.eliminate((3 * nodes[:, None] + np.arange(3)).ravel(), weights)
        return added

    def constraint(self) -> Constraint:
        """Eliminate the slaves.

        Raises ValueError for a freedom enslaved twice or slaves that follow each other in a loop.
        """
        slaves = np.concatenate([np.empty(0, dtype=np.int64), *self._slaves])
        unique, counts = np.unique(slaves, return_counts=True)
        if np.any(counts > 1):
            raise ValueError(f"freedom {unique[counts > 1][0]} (node {unique[counts > 1][0] // 3}) is enslaved twice")
        is_free = np.ones(self.total, dtype=bool)
        is_free[slaves] = False
        free = np.flatnonzero(is_free)
        start, entries = 0, [(np.ones(len(free)), free, free)]
        for weights in self._weights:
            entries.append((weights.data, slaves[start + weights.row], weights.col))
            start += weights.shape[0]
        data, rows, columns = (np.concatenate(part) for part in zip(*entries, strict=True))
        step = sp.csr_matrix((data, (rows, columns)), shape=(self.total, self.total))
        constant = np.zeros(self.total)
        constant[slaves] = np.concatenate([np.empty(0), *self._constants])
        for _ in range(len(slaves).bit_length() + 1):  # x = M x + g, so x = M^2 x + M g + g: chains halve
            if not step[:, slaves].count_nonzero():
                break
            constant = constant + step @ constant
            step = step @ step
        else:
            raise ValueError("slaves follow each other in a loop")
        return Constraint(step[: self.size][:, free].tocsr(), constant[: self.size], free)


def reduce(K: sp.spmatrix, f: FloatArray | None, constraint: Constraint) -> tuple[sp.csc_matrix, FloatArray]:
    """C^T K C and C^T (f - K g), shapes (m, m) and (m,); f [N], shape (n,) or None for no forces.

    Forces and moments on the freedoms of rigid sections are added by the caller to the entries with `free >= n`.
    """
    C = constraint.basis
    if K.shape != (C.shape[0], C.shape[0]):
        raise ValueError(f"matrix has shape {K.shape}, the constraint is for {C.shape[0]} freedoms")
    product = (K @ C).tocsc()
    small = (C.T @ product).tocsc()
    small = 0.5 * (small + small.T)  # symmetric again to the last digit
    load = -(K @ constraint.constant) if f is None else np.asarray(f, dtype=float) - K @ constraint.constant
    return small.tocsc(), C.T @ load


def expand(y: FloatArray, constraint: Constraint) -> FloatArray:
    """x = C y + g [m], shape (n,) or (n, k), from y of shape (m,) or (m, k)."""
    x: FloatArray = constraint.basis @ np.asarray(y, dtype=float)
    return x + (constraint.constant if x.ndim == 1 else constraint.constant[:, None])
