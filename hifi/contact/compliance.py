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
    def starts(self) -> Indices:
        """First pair of each side, and the number of all at the end: (sides + 1,)."""
        return np.concatenate([[0], np.cumsum([len(a) for a in self.local], dtype=np.int64)])

    @cached_property
    def _sides(self) -> tuple[tuple[int, int], ...]:
        """First pair of each side and of the next one."""
        return tuple(pairwise(self.starts.tolist()))

    @cached_property
    def _all_modes(self) -> Array:
        """V of all sides (n, k)."""
        return np.asarray(block_diag(*self.modes))

    def __len__(self) -> int:
        """Number of pairs."""
        return self._sides[-1][1]

    def apply(self, forces: Array) -> Array:
        """D f (n,) [m] of forces f (n,) [N]."""
        alone = np.concatenate([a @ forces[i:j] for a, (i, j) in zip(self.local, self._sides, strict=True)])
        return np.asarray(alone + self._all_modes @ (self.coupling @ (forces @ self._all_modes)))

    def dense(self) -> Array:
        """D (n, n) [m/N]; for few pairs, tests and the rare problem on which the active set cycles."""
        return np.asarray(block_diag(*self.local) + self._all_modes @ self.coupling @ self._all_modes.T)

    def factor(self, active: Flags, known: BlockFactor | None = None) -> BlockFactor:
        """Factor of the rows and columns of the ``active`` (n,) pairs; sides that are as in ``known`` are taken over."""
        sides = []
        for s, (i, j) in enumerate(self._sides):
            pick = active[i:j]
            if known is not None and np.array_equal(pick, known.active[i:j]):
                sides.append(known.sides[s])
                continue
            closed, V = np.flatnonzero(pick), self.modes[s][pick]
            cholesky = picked_factor(self.local[s], closed) if closed.size else None
            solved = V if cholesky is None else dpotrs(cholesky, V, lower=1)[0]
            sides.append(SideFactor(i + closed, cholesky, solved, V.T @ solved))
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
        first = 0
        for side in self.sides:
            count = side.inner.shape[1]
            out[side.pairs] -= side.inner @ z[first : first + count]
            first += count
        return out


def plain(matrix: Array) -> BallBlock:
    """One dense matrix (n, n) as block."""
    return BallBlock((np.asarray(matrix, float),), (np.zeros((len(matrix), 0)),), np.zeros((0, 0)))


@dataclass(frozen=True)
class Compliance:
    """C = blkdiag(D_p) + U G U^T [m/N] without ever forming it.

    blocks: D_p of n_p pairs, one for each ball; modes: U_p (n_p, r_p), the rows of U that belong to ball p, only the
    columns in which they are not zero; columns: (r_p,) these columns; coupling: G (r, r), symmetric. A ball may share
    columns with others. Make it with `uncoupled` or `coupled`, which check the shapes.
    """

    blocks: tuple[BallBlock, ...]
    modes: tuple[Array, ...]
    columns: tuple[Indices, ...]
    coupling: Array

    @cached_property
    def starts(self) -> Indices:
        """First pair of each block, and the number of all pairs at the end: (blocks + 1,)."""
        return np.concatenate([[0], np.cumsum([len(block) for block in self.blocks], dtype=np.int64)])

    @property
    def size(self) -> int:
        """Number of pairs."""
        return sum(len(block) for block in self.blocks)

    def amplitude(self, forces: Array) -> Array:
        """U^T lambda (r,) of forces lambda (n,) [N]."""
        out = np.zeros(len(self.coupling))
        for (i, j), modes, columns in zip(pairwise(self.starts), self.modes, self.columns, strict=True):
            np.add.at(out, columns, modes.T @ forces[i:j])
        return out

    def apply(self, forces: Array) -> Array:
        """C lambda (n,) [m] of forces lambda (n,) [N]."""
        answer = self.coupling @ self.amplitude(forces)
        parts = zip(self.blocks, pairwise(self.starts), self.modes, self.columns, strict=True)
        return np.concatenate(
            [block.apply(forces[i:j]) + modes @ answer[columns] for block, (i, j), modes, columns in parts]
        )

    def dense(self) -> Array:
        """C (n, n) [m/N]; for tests and small scenes."""
        full = np.zeros((self.size, len(self.coupling)))
        out = np.zeros((self.size, self.size))
        for (i, j), block, modes, columns in zip(pairwise(self.starts), self.blocks, self.modes, self.columns, strict=True):
            out[i:j, i:j] = block.dense()
            full[i:j, columns] = modes
        return np.asarray(out + full @ self.coupling @ full.T)


def uncoupled(*blocks: Array | BallBlock) -> Compliance:
    """Compliance of balls that do not feel each other, or of one dense matrix.

    Args:
        blocks: D_p (n_p, n_p) [m/N], dense or as `BallBlock`.

    Raises:
        ValueError: a block that is not square or not symmetric to 1e-8 of its largest entry.
    """
    return coupled(blocks, [np.zeros((len(block), 0)) for block in blocks], np.zeros((0, 0)))


def coupled(
    blocks: Sequence[Array | BallBlock], modes: Sequence[Array], coupling: Array, columns: Sequence[Indices] | None = None
) -> Compliance:
    """Compliance blkdiag(D_p) + U G U^T, see `Compliance`.

    Args:
        blocks: D_p (n_p, n_p) [m/N], dense or as `BallBlock`.
        modes: U_p (n_p, r_p).
        coupling: G (r, r).
        columns: (r_p,) columns of U that modes[p] fills; one ball after the other if left out.

    Raises:
        ValueError: shapes that do not fit, column numbers beyond G, a column named twice by one ball, or matrices not
            symmetric to 1e-8 of their largest entry.
    """
    if columns is None:
        ends = np.cumsum([0] + [mode.shape[1] for mode in modes])
        columns = [np.arange(i, j) for i, j in pairwise(ends)]
        if ends[-1] != len(coupling):
            raise ValueError(f"the modes have {ends[-1]} columns, the coupling {len(coupling)} rows")
    if not len(blocks) == len(modes) == len(columns):
        raise ValueError(f"{len(blocks)} blocks, {len(modes)} modes and {len(columns)} columns; one each is needed")
    checked: dict[int, BallBlock] = {}  # congruent balls share one block
    for p, (block, mode, column) in enumerate(zip(blocks, modes, columns, strict=True)):
        if id(block) not in checked:
            checked[id(block)] = _checked(f"block {p}", block)
        if mode.shape != (len(block), len(column)):
            raise ValueError(f"modes of block {p} have shape {mode.shape}; it must be {(len(block), len(column))}")
        if len(np.unique(column)) != len(column) or np.any((column < 0) | (column >= len(coupling))):
            raise ValueError(f"columns of block {p} must be different numbers from 0 to {len(coupling) - 1}")
    _check_symmetric("the coupling", coupling)
    return Compliance(
        tuple(checked[id(block)] for block in blocks),
        tuple(np.asarray(mode, float) for mode in modes),
        tuple(np.asarray(column, np.int64) for column in columns),
        _symmetric(coupling),
    )


def _checked(name: str, block: Array | BallBlock) -> BallBlock:
    """The block with its parts made exactly symmetric."""
    if not isinstance(block, BallBlock):
        _check_symmetric(name, block)
        return plain(_symmetric(block))
    for matrix in (*block.local, block.coupling):
        _check_symmetric(name, matrix)
    if [len(v) for v in block.modes] != [len(a) for a in block.local]:
        sizes = [len(a) for a in block.local]
        raise ValueError(f"{name}: modes of {[len(v) for v in block.modes]} pairs on sides of {sizes}")
    columns = sum(v.shape[1] for v in block.modes)
    if columns != len(block.coupling):
        raise ValueError(f"{name}: the modes have {columns} columns, the coupling {len(block.coupling)} rows")
    return BallBlock(tuple(map(_symmetric, block.local)), block.modes, _symmetric(block.coupling))


def _check_symmetric(name: str, matrix: Array) -> None:
    if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1]:
        raise ValueError(f"{name} has shape {matrix.shape}; it must be square")
    if not np.isfinite(matrix).all():
        raise ValueError(f"{name} holds values that are not finite")
    skew = np.abs(matrix - matrix.T).max(initial=0.0)
    if skew > 1e-8 * np.abs(matrix).max(initial=0.0):
        raise ValueError(f"{name} is not symmetric: entries differ from the transposed by up to {skew:.3g}")


def _symmetric(matrix: Array) -> Array:
    return np.asarray(0.5 * (matrix + matrix.T))
