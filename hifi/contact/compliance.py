"""Compliance of contact pairs: each contact's own, what couples the contacts of a ball, and what couples all of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag
from scipy.linalg.lapack import dpotrf, dpotrs

from rollbench.meshes.arrays import Array

Indices = NDArray[np.int64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class BallBlock:
    """Compliance D = blkdiag(A_s) + V G V^T [m/N] between the contact pairs of one ball, side after side.

    local: A_s (n_s, n_s), symmetric positive definite; modes: V_s (n_s, k_s), smooth patterns by which a side feels the
    ball's other sides; coupling: G (k, k), k = sum k_s, symmetric positive semidefinite. A factor costs sum n_s^3 and not
    (sum n_s)^3.
    """

    local: tuple[Array, ...]
    modes: tuple[Array, ...]
    coupling: Array

    @cached_property
    def sides(self) -> tuple[slice, ...]:
        """Pairs of each side."""
        return _slices([len(a) for a in self.local])

    @cached_property
    def _all_modes(self) -> Array:
        """V of all sides (n, k)."""
        return np.asarray(block_diag(*self.modes))

    def __len__(self) -> int:
        """Number of pairs."""
        return sum(len(a) for a in self.local)

    def apply(self, forces: Array) -> Array:
        """D f (n,) [m] of forces f (n,) [N]."""
        alone = np.concatenate([a @ forces[pairs] for a, pairs in zip(self.local, self.sides, strict=True)])
        return np.asarray(alone + self._all_modes @ (self.coupling @ (forces @ self._all_modes)))

    def dense(self) -> Array:
        """D (n, n) [m/N]; for the rare problem on which the active set cycles."""
        return np.asarray(block_diag(*self.local) + self._all_modes @ self.coupling @ self._all_modes.T)

    def factor(self, active: Flags, known: BlockFactor | None = None) -> BlockFactor:
        """Factor of the rows and columns of the ``active`` (n,) pairs; sides that are as in ``known`` are taken over."""
        sides = []
        for s, pairs in enumerate(self.sides):
            pick = active[pairs]
            if known is not None and np.array_equal(pick, known.active[pairs]):
                sides.append(known.sides[s])
                continue
            closed, V = np.flatnonzero(pick), self.modes[s][pick]
            cholesky = picked_factor(self.local[s], closed) if closed.size else None
            solved = V if cholesky is None else dpotrs(cholesky, V, lower=1)[0]
            sides.append(SideFactor(pairs.start + closed, cholesky, solved, V.T @ solved))
        k, answer = len(self.coupling), self.coupling
        if k:
            answer = np.linalg.solve(np.eye(k) + self.coupling @ block_diag(*(side.middle for side in sides)), answer)
        return BlockFactor(active.copy(), tuple(sides), answer)


def picked_factor(matrix: Array, pick: Indices) -> Array:
    """Lower Cholesky factor of the picked rows and columns of a symmetric matrix. Raises as `factored`."""
    return factored(matrix[pick[:, None], pick].T)


def factored(matrix: Array) -> Array:
    """Lower Cholesky factor of a matrix in Fortran's order, in its place (above its diagonal: anything).

    Raises numpy.linalg.LinAlgError where it is not positive definite. LAPACK itself: SciPy's checks of small matrices take
    as long as their factors.
    """
    L, fault = dpotrf(matrix, lower=1, clean=0, overwrite_a=1)
    if fault:
        raise np.linalg.LinAlgError(f"{fault}-th leading minor of a compliance is not positive definite")
    return np.asarray(L)


class SideFactor(NamedTuple):
    """Factor of one side of a `BallBlock`: its active pairs, Cholesky factor of A_aa (None: none is active), A_aa^-1 V
    (active, k_s) and V^T A_aa^-1 V (k_s, k_s)."""

    pairs: Indices
    cholesky: Array | None
    inner: Array
    middle: Array


@dataclass(frozen=True, eq=False)
class BlockFactor:
    """D_aa^-1 on the ``active`` (n,) pairs of a `BallBlock`, by the sides' Cholesky factors and Woodbury's formula for
    V G V^T; answer (k, k): (I + G V^T A_aa^-1 V)^-1 G."""

    active: Flags
    sides: tuple[SideFactor, ...]
    answer: Array

    def solve(self, rhs: Array) -> Array:
        """D_aa^-1 of the active rows of ``rhs`` (n,) or (n, m), zero on the other rows."""
        out = np.zeros(rhs.shape)
        for side in self.sides:
            if side.cholesky is not None:
                out[side.pairs] = dpotrs(side.cholesky, rhs[side.pairs], lower=1)[0].reshape(-1, *rhs.shape[1:])
        z = self.answer @ np.concatenate([side.inner.T @ rhs[side.pairs] for side in self.sides])
        for side, columns in zip(self.sides, _slices([side.inner.shape[1] for side in self.sides]), strict=True):
            out[side.pairs] -= side.inner @ z[columns]
        return out


def plain(matrix: Array) -> BallBlock:
    """One dense matrix (n, n) as block."""
    return BallBlock((matrix,), (np.zeros((len(matrix), 0)),), np.zeros((0, 0)))


@dataclass(frozen=True)
class Compliance:
    """C = blkdiag(D_p) + U G U^T [m/N] without ever forming it, U = blkdiag(U_p).

    blocks: D_p of n_p pairs, one for each ball; modes: U_p (n_p, r_p); coupling: G (r, r), symmetric, r = sum r_p. Make it
    with `uncoupled` or `coupled`, which check the matrices.
    """

    blocks: tuple[BallBlock, ...]
    modes: tuple[Array, ...]
    coupling: Array

    @cached_property
    def pairs(self) -> tuple[slice, ...]:
        """Pairs of each block among all."""
        return _slices([len(block) for block in self.blocks])

    @cached_property
    def columns(self) -> tuple[slice, ...]:
        """Columns of U and rows of G of each block."""
        return _slices([modes.shape[1] for modes in self.modes])

    def amplitude(self, forces: Array) -> Array:
        """U^T lambda (r,) of forces lambda (n,) [N]."""
        return np.concatenate([modes.T @ forces[pairs] for pairs, modes in zip(self.pairs, self.modes, strict=True)])


def _slices(counts: Sequence[int]) -> tuple[slice, ...]:
    """Stretches of so many numbers, one after another."""
    return tuple(slice(i, j) for i, j in pairwise(np.cumsum([0, *counts]).tolist()))


def uncoupled(block: Array | BallBlock) -> Compliance:
    """Compliance D (n, n) [m/N] of one ball, or of one dense matrix. Raises ValueError as `coupled`."""
    return coupled([block], [np.zeros((len(block), 0))], np.zeros((0, 0)))


def coupled(blocks: Sequence[Array | BallBlock], modes: Sequence[Array], coupling: Array) -> Compliance:
    """Compliance blkdiag(D_p) + U G U^T, see `Compliance`: blocks D_p (n_p, n_p) [m/N], dense or as `BallBlock`, modes U_p
    (n_p, r_p), coupling G (r, r).

    Raises ValueError for matrices that are not finite, or not symmetric to 1e-8 of their largest entry.
    """
    made: dict[int, BallBlock] = {}  # congruent balls share one block
    for p, block in enumerate(blocks):
        if id(block) not in made:
            given = block if isinstance(block, BallBlock) else plain(block)
            local = tuple(_symmetric(f"block {p}", matrix) for matrix in given.local)
            made[id(block)] = BallBlock(local, given.modes, _symmetric(f"block {p}", given.coupling))
    return Compliance(tuple(made[id(block)] for block in blocks), tuple(modes), _symmetric("the coupling", coupling))


def _symmetric(name: str, matrix: Array) -> Array:
    """The matrix made exactly symmetric."""
    if not np.isfinite(matrix).all():
        raise ValueError(f"{name} holds values that are not finite")
    skew = np.abs(matrix - matrix.T).max(initial=0.0)
    if skew > 1e-8 * np.abs(matrix).max(initial=0.0):
        raise ValueError(f"{name} is not symmetric: entries differ from the transposed by up to {skew:.3g}")
    return np.asarray(0.5 * (matrix + matrix.T))
