"""Symmetric positive definite banded systems, A[i, j] = band[j, i - j] for i >= j: the lower band, column by column.

Compiled: the LDL^T below. Interpreted: Cholesky block by block through numpy, as scipy.linalg takes longer to import than a
scene to be solved; on one thread, as more wait for one another at every block. A test compares them.
"""

import numpy as np

from rollbench.lowfi.jit import is_compiled, kernel
from rollbench.lowfi.statics.kernel_types import Array
from rollbench.lowfi.threads import one_thread


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


def _blocks(band: Array) -> tuple[Array, Array]:
    """The matrix of a band (n, w) as blocks of w - 1 freedoms: those on the diagonal (m, b, b), lower triangle, and those
    below them (m, b, b), upper triangle; filled up to m b freedoms by a unit matrix."""
    n, width = band.shape
    size = max(width - 1, 1)
    filled = np.zeros((-(-n // size) * size, size + 1))
    filled[:n, :width] = np.where(np.arange(n)[:, None] + np.arange(width) < n, band, 0.0)
    filled[n:, 0] = 1.0
    row, column = np.indices((size, size))
    first = np.arange(0, len(filled), size)[:, None, None] + column
    return np.tril(filled[first, np.maximum(row - column, 0)]), np.triu(filled[first, size + np.minimum(row - column, 0)])


@one_thread()
def _block_factor(band: Array) -> bool:
    n, width = band.shape
    on, below = _blocks(band)
    try:
        for k in range(len(on)):
            if k:
                below[k - 1] = np.linalg.solve(on[k - 1], below[k - 1].T).T
                on[k] -= below[k - 1] @ below[k - 1].T
            on[k] = np.linalg.cholesky(on[k])
    except np.linalg.LinAlgError:
        return False
    both = np.concatenate([on, below], axis=1)  # a column of the factor down to the end of the next block
    size = on.shape[1]
    place = np.arange(n)
    for k in range(width):
        band[:, k] = both[place // size, place % size + k, place % size]
    return True


def inverse_blocks(band: Array) -> tuple[Array, Array]:
    """What `substitute_blocks` takes of a factored band: inverses of the blocks on the diagonal, and those below them."""
    on, below = _blocks(band)
    return np.linalg.inv(on), below


@one_thread()
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
