"""Compliance of contact pairs: each contact's own, what couples the contacts of a ball, and what couples all of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag, lu_factor, lu_solve
from scipy.linalg.lapack import dpotrf, dpotrs

from rollbench.meshes.arrays import Array

Indices = NDArray[np.int64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class BallBlock:
    """Compliance D = blkdiag(A_s) + V G V^T [m/N] between the contact pairs of one ball, side after side.

    own: A_s (n_s, n_s), symmetric positive definite; modes: V_s (n_s, k_s), smooth patterns by which a side feels the
    ball's other sides; coupling: G (k, k), k = sum k_s, symmetric positive semidefinite. A factor costs sum n_s^3 and not
    (sum n_s)^3.
    """

    own: tuple[Array, ...]
    modes: tuple[Array, ...]
    coupling: Array

    @property
    def starts(self) -> Indices:
        """First pair of each side, and the number of all at the end: (sides + 1,)."""
        return np.concatenate([[0], np.cumsum([len(a) for a in self.own], dtype=np.int64)])

    def __len__(self) -> int:
        """Number of pairs."""
        return sum(len(a) for a in self.own)

    def apply(self, forces: Array) -> Array:
        """D f (n,) [m] of forces f (n,) [N]."""
        parts = [forces[i:j] for i, j in pairwise(self.starts)]
        answer = self.coupling @ np.concatenate([v.T @ f for v, f in zip(self.modes, parts, strict=True)])
        ends = np.cumsum([0] + [v.shape[1] for v in self.modes])
        return np.concatenate(
            [a @ f + v @ answer[i:j] for a, v, f, (i, j) in zip(self.own, self.modes, parts, pairwise(ends), strict=True)]
        )

    def dense(self) -> Array:
        """D (n, n) [m/N]; for few pairs, tests and the rare problem on which the active set cycles."""
        V = block_diag(*self.modes)
        return np.asarray(block_diag(*self.own) + V @ self.coupling @ V.T)

    def factor(self, active: Flags, known: BlockFactor | None = None) -> BlockFactor:
        """Factor of the rows and columns of the ``active`` (n,) pairs; sides that are as in ``known`` are taken over."""
        cholesky: list[Array | None] = []
        inner: list[Array] = []
        middles: list[Array] = []
        for s, (i, j) in enumerate(pairwise(self.starts)):
            pick = active[i:j]
            if known is not None and np.array_equal(pick, known.active[i:j]):
                cholesky.append(known.cholesky[s])
                inner.append(known.inner[s])
                middles.append(known.middles[s])
                continue
            V = self.modes[s][pick]
            if not pick.any():
                cholesky.append(None)
                inner.append(V)
                middles.append(np.zeros((V.shape[1], V.shape[1])))
                continue
            found = picked_factor(self.own[s], np.flatnonzero(pick))
            solved = dpotrs(found, V, lower=1)[0]
            cholesky.append(found)
            inner.append(solved)
            middles.append(V.T @ solved)
        small = lu_factor(np.eye(len(self.coupling)) + self.coupling @ block_diag(*middles)) if len(self.coupling) else None
        return BlockFactor(self, active.copy(), tuple(cholesky), tuple(inner), tuple(middles), small)


def picked_factor(matrix: Array, pick: Indices) -> Array:
    """Lower Cholesky factor of the picked rows and columns of a symmetric matrix (above its diagonal: anything).

    Raises numpy.linalg.LinAlgError where they are not positive definite. LAPACK itself: SciPy's checks of small matrices
    take as long as their factors.
    """
    L, fault = dpotrf(matrix[pick[:, None], pick].T, lower=1, clean=0, overwrite_a=1)
    if fault:
        raise np.linalg.LinAlgError(f"{fault}-th leading minor of a contact's compliance is not positive definite")
    return np.asarray(L)


@dataclass(frozen=True, eq=False)
class BlockFactor:
    """D_aa^-1 on the active pairs of a `BallBlock`, by the sides' Cholesky factors and Woodbury's formula for V G V^T.

    inner: A_aa^-1 V (active of the side, k_s); middles: V^T A_aa^-1 V; small: LU factor of I + G V^T A_aa^-1 V.
    """

    block: BallBlock
    active: Flags
    cholesky: tuple[Array | None, ...]
    inner: tuple[Array, ...]
    middles: tuple[Array, ...]
    small: tuple[Array, Indices] | None

    def solve(self, rhs: Array) -> Array:
        """D_aa^-1 of the active rows of ``rhs`` (n,) or (n, m), zero on the other rows."""
        columns = rhs.reshape(len(rhs), -1)
        out = np.zeros(columns.shape)
        places = []
        for (i, j), found in zip(pairwise(self.block.starts), self.cholesky, strict=True):
            own = i + np.flatnonzero(self.active[i:j])
            places.append(own)
            if found is not None:
                out[own] = dpotrs(found, columns[own], lower=1)[0]
        if self.small is not None:
            amplitude = np.concatenate(
                [v.T @ columns[own] for v, own in zip(self.inner, places, strict=True)]
            )  # V^T A^-1 b
            answer = lu_solve(self.small, self.block.coupling @ amplitude, check_finite=False)
            ends = np.cumsum([0] + [v.shape[1] for v in self.inner])
            for v, own, (i, j) in zip(self.inner, places, pairwise(ends), strict=True):
                out[own] -= v @ answer[i:j]
        return out.reshape(rhs.shape)


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

    @property
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
    made: dict[int, BallBlock] = {}  # congruent balls share one block
    for p, (block, mode, column) in enumerate(zip(blocks, modes, columns, strict=True)):
        if id(block) not in made:
            made[id(block)] = _checked(f"block {p}", block)
        if mode.shape != (len(block), len(column)):
            raise ValueError(f"modes of block {p} have shape {mode.shape}; it must be {(len(block), len(column))}")
        if len(np.unique(column)) != len(column) or np.any((column < 0) | (column >= len(coupling))):
            raise ValueError(f"columns of block {p} must be different numbers from 0 to {len(coupling) - 1}")
    _check_symmetric("the coupling", coupling)
    return Compliance(
        tuple(made[id(block)] for block in blocks),
        tuple(np.asarray(mode, float) for mode in modes),
        tuple(np.asarray(column, np.int64) for column in columns),
        _symmetric(coupling),
    )


def _checked(name: str, block: Array | BallBlock) -> BallBlock:
    """The block with its parts made exactly symmetric."""
    if not isinstance(block, BallBlock):
        _check_symmetric(name, block)
        return plain(_symmetric(block))
    for part in (*block.own, block.coupling):
        _check_symmetric(name, part)
    if [len(v) for v in block.modes] != [len(a) for a in block.own]:
        sizes = [len(a) for a in block.own]
        raise ValueError(f"{name}: modes of {[len(v) for v in block.modes]} pairs on sides of {sizes}")
    columns = sum(v.shape[1] for v in block.modes)
    if columns != len(block.coupling):
        raise ValueError(f"{name}: the modes have {columns} columns, the coupling {len(block.coupling)} rows")
    return BallBlock(tuple(map(_symmetric, block.own)), block.modes, _symmetric(block.coupling))


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
