"""Compliance of contact pairs: blocks of patches, and what couples them through the bodies at low rank."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True)
class Compliance:
    """C = blkdiag(A_p) + U G U^T [m/N] without ever forming it.

    blocks: A_p (n_p, n_p), symmetric positive definite, one for each patch; modes: U_p (n_p, r_p), the rows of U that
    belong to patch p, only the columns in which they are not zero; columns: (r_p,) these columns; coupling: G (r, r),
    symmetric. A patch may share columns with others. Make it with `uncoupled` or `coupled`, which check the shapes.
    """

    blocks: tuple[Array, ...]
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

    def apply(self, forces: Array) -> Array:
        """C lambda (n,) [m] of forces lambda (n,) [N]."""
        pieces = [forces[i:j] for i, j in pairwise(self.starts)]
        amplitude = np.zeros(len(self.coupling))
        for piece, modes, columns in zip(pieces, self.modes, self.columns, strict=True):
            np.add.at(amplitude, columns, modes.T @ piece)
        answer = self.coupling @ amplitude
        parts = zip(self.blocks, pieces, self.modes, self.columns, strict=True)
        return np.concatenate([block @ piece + modes @ answer[columns] for block, piece, modes, columns in parts])

    def dense(self) -> Array:
        """C (n, n) [m/N]; for tests and small scenes."""
        full = np.zeros((self.size, len(self.coupling)))
        out = np.zeros((self.size, self.size))
        for (i, j), block, modes, columns in zip(
            pairwise(self.starts), self.blocks, self.modes, self.columns, strict=True
        ):
            out[i:j, i:j] = block
            full[i:j, columns] = modes
        return np.asarray(out + full @ self.coupling @ full.T)


def uncoupled(*blocks: Array) -> Compliance:
    """Compliance of patches that do not feel each other, or of one dense matrix.

    Args:
        blocks: A_p (n_p, n_p) [m/N].

    Raises:
        ValueError: a block that is not square or not symmetric to 1e-8 of its largest entry.
    """
    return coupled(blocks, [np.zeros((len(block), 0)) for block in blocks], np.zeros((0, 0)))


def coupled(
    blocks: Sequence[Array], modes: Sequence[Array], coupling: Array, columns: Sequence[Indices] | None = None
) -> Compliance:
    """Compliance blkdiag(A_p) + U G U^T, see `Compliance`.

    Args:
        blocks: A_p (n_p, n_p) [m/N].
        modes: U_p (n_p, r_p).
        coupling: G (r, r).
        columns: (r_p,) columns of U that modes[p] fills; one patch after the other if left out.

    Raises:
        ValueError: shapes that do not fit, column numbers beyond G, a column named twice by one patch, or matrices not
            symmetric to 1e-8 of their largest entry.
    """
    if columns is None:
        ends = np.cumsum([0] + [mode.shape[1] for mode in modes])
        columns = [np.arange(i, j) for i, j in pairwise(ends)]
        if ends[-1] != len(coupling):
            raise ValueError(f"the modes have {ends[-1]} columns, the coupling {len(coupling)} rows")
    if not len(blocks) == len(modes) == len(columns):
        raise ValueError(f"{len(blocks)} blocks, {len(modes)} modes and {len(columns)} columns; one each is needed")
    checked: set[int] = set()
    for p, (block, mode, column) in enumerate(zip(blocks, modes, columns, strict=True)):
        if id(block) not in checked:
            _check_symmetric(f"block {p}", block)
        checked.add(id(block))
        if mode.shape != (len(block), len(column)):
            raise ValueError(f"modes of block {p} have shape {mode.shape}; it must be {(len(block), len(column))}")
        if len(np.unique(column)) != len(column) or np.any((column < 0) | (column >= len(coupling))):
            raise ValueError(f"columns of block {p} must be different numbers from 0 to {len(coupling) - 1}")
    _check_symmetric("the coupling", coupling)
    once = {id(block): _symmetric(block) for block in blocks}  # congruent patches share one block
    return Compliance(
        tuple(map(once.__getitem__, map(id, blocks))),
        tuple(np.asarray(mode, float) for mode in modes),
        tuple(np.asarray(column, np.int64) for column in columns),
        _symmetric(coupling),
    )


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
