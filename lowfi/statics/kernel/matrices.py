"""Symmetric positive definite systems in a band and in an envelope.

Band: A[i, j] = band[j, i - j] for i >= j, the lower band, column by column. Envelope: row i holds the columns from first[i]
to i; elimination fills nothing outside it. A shaft is a narrow band; a body that is joined to a stretch of it and comes
right after that stretch has rows as long as the stretch, so that many bodies cost as much as their stretches together.

Compiled: LDL^T, and row-wise Cholesky. Interpreted: blocks of a band through numpy, as scipy.linalg takes longer to import
than a scene to be solved, and LAPACK on the full matrix of an envelope. Tests compare them.
"""

from math import sqrt

import numpy as np

from rollbench.lowfi.jit import is_compiled, kernel
from rollbench.lowfi.statics.kernel_types import Array


@kernel
def ldl_factor(band: Array) -> bool:
    """Overwrite ``band`` (n, w) with the factors L (unit) and 1/D; False where the matrix is not positive definite."""
    n, width = band.shape
    column = np.empty(width)
    for j in range(n):
        if not band[j, 0] > 0.0:
            return False
        m, inverse = min(width, n - j), 1.0 / band[j, 0]
        for i in range(1, m):
            column[i] = band[j, i]  # a copy: the compiler then knows that the updates below do not change it
            band[j, i] = column[i] * inverse
        band[j, 0] = inverse
        for k in range(1, m):
            f = column[k] * inverse
            if f != 0.0:
                for i in range(m - k):
                    band[j + k, i] -= f * column[k + i]
    return True


@kernel
def ldl_substitute(band: Array, b: Array) -> None:
    """Overwrite b (n,) by the solution, from the factors."""
    n, width = band.shape
    for j in range(n):
        for i in range(1, min(width, n - j)):
            b[j + i] -= band[j, i] * b[j]
    for j in range(n - 1, -1, -1):
        x = b[j] * band[j, 0]
        for i in range(1, min(width, n - j)):
            x -= band[j, i] * b[j + i]
        b[j] = x


def _filled(band: Array) -> Array:
    """Return a band (n, w) filled up to whole blocks of w - 1 freedoms by a unit matrix."""
    n, width = band.shape
    size = max(width - 1, 1)
    filled = np.zeros((-(-n // size) * size, size + 1))
    filled[:n, :width] = band
    for j in range(max(n - width + 1, 0), n):
        filled[j, n - j :] = 0.0
    filled[n:, 0] = 1.0
    return filled


def _views(filled: Array) -> tuple[Array, Array]:
    """Return views of the blocks (m, b, b) of a filled band on its diagonal, lower triangles, and below them, upper ones.

    Its columns lie one after the other, A[i, j] at j (b + 1) + i - j = j b + i: a block is b columns b apart, and the other
    triangle of a view belongs to other blocks.
    """
    size = filled.shape[1] - 1
    flat = filled.reshape(-1, size * (size + 1))
    on, below = (x.reshape(-1, size, size).transpose(0, 2, 1) for x in (flat[:, : size * size], flat[:, size:]))
    return on, below


def _block_factor(band: Array) -> bool:
    """Overwrite ``band`` with the inverses of the factor's blocks on the diagonal and the blocks below them.

    False where the matrix is not positive definite.
    """
    filled = _filled(band)
    factor = np.zeros_like(filled)
    (on, below), (inverse, under) = _views(filled), _views(factor)
    taken = np.zeros(on.shape[1:])
    try:
        for k in range(len(on)):
            inverted = np.tril(np.linalg.inv(np.linalg.cholesky(on[k] - taken)))  # of which it reads the lower triangle
            row = np.triu(below[k]) @ inverted.T
            taken = row @ row.T
            inverse[k] += inverted
            under[k] += row
    except np.linalg.LinAlgError:
        return False
    band[:] = factor[: band.shape[0], : band.shape[1]]
    return True


def inverse_blocks(band: Array) -> tuple[Array, Array]:
    """Return inverses of a factored band's blocks on the diagonal, and the blocks below them, for `substitute_blocks`."""
    on, below = _views(_filled(band))
    return np.tril(on), np.triu(below)


def substitute_blocks(blocks: tuple[Array, Array], b: Array) -> None:
    """Overwrite b, one column (n,) or several (n, k), by the solution, from `inverse_blocks`."""
    inverse, below = blocks
    whole = np.zeros((inverse.shape[0] * inverse.shape[1], *b.shape[1:]))
    whole[: len(b)] = b
    x = whole.reshape(*inverse.shape[:2], b.size // len(b))
    for k in range(len(inverse)):
        x[k] = inverse[k] @ (x[k] - below[k - 1] @ x[k - 1] if k else x[k])
    for k in range(len(inverse) - 1, -1, -1):
        x[k] = inverse[k].T @ (x[k] - below[k].T @ x[k + 1] if k + 1 < len(inverse) else x[k])
    b[:] = whole[: len(b)]


def _block_substitute(band: Array, b: Array) -> None:
    substitute_blocks(inverse_blocks(band), b)


factor_band = ldl_factor if is_compiled(__name__) else _block_factor
substitute_band = ldl_substitute if is_compiled(__name__) else _block_substitute


@kernel
def row_factor(values: Array, first: Array, start: Array) -> bool:
    """Overwrite the envelope by its Cholesky factor; False where the matrix is not positive definite."""
    for i in range(first.shape[0]):
        row = start[i]
        for j in range(first[i], i):
            other = start[j]
            x = values[row + j]
            for k in range(max(first[i], first[j]), j):
                x -= values[row + k] * values[other + k]
            values[row + j] = x / values[other + j]
        x = values[row + i]
        for k in range(first[i], i):
            x -= values[row + k] * values[row + k]
        if not x > 0.0:
            return False
        values[row + i] = sqrt(x)
    return True


@kernel
def row_solve(values: Array, first: Array, start: Array, b: Array) -> None:
    """Overwrite b (n,) by the solution, from the factor."""
    n = first.shape[0]
    for i in range(n):
        row = start[i]
        x = b[i]
        for k in range(first[i], i):
            x -= values[row + k] * b[k]
        b[i] = x / values[row + i]
    for i in range(n - 1, -1, -1):
        row = start[i]
        b[i] = b[i] / values[row + i]
        for k in range(first[i], i):
            b[k] -= values[row + k] * b[i]


def _lapack_factor(values: Array, first: Array, start: Array) -> bool:
    n = first.shape[0]
    full = np.zeros((n, n))
    for i in range(n):
        full[i, first[i] : i + 1] = values[start[i] + first[i] : start[i] + i + 1]
    try:
        factor = np.linalg.cholesky(full)
    except np.linalg.LinAlgError:
        return False
    for i in range(n):
        values[start[i] + first[i] : start[i] + i + 1] = factor[i, first[i] : i + 1]
    return True


def _lapack_solve(values: Array, first: Array, start: Array, b: Array) -> None:
    from scipy.linalg import solve_triangular

    n = first.shape[0]
    full = np.zeros((n, n))
    for i in range(n):
        full[i, first[i] : i + 1] = values[start[i] + first[i] : start[i] + i + 1]
    b[:] = solve_triangular(full, solve_triangular(full, b, lower=True), lower=True, trans=1)


factor = row_factor if is_compiled(__name__) else _lapack_factor
substitute = row_solve if is_compiled(__name__) else _lapack_solve
