"""Solve linear equations with a symmetric positive definite matrix that is stored as a band or as an envelope.

Band: A[i, j] = band[j, i - j] for i >= j, the lower triangle, column by column. Envelope: row i stores the columns
first_column[i] to i; the factorisation fills no entry outside of them.

The stiffness matrix of a shaft is a narrow band. A body (nut or bearing ring) that is connected to a part of the shaft is
ordered directly after this part, and its rows are as long as that part. The cost for many bodies is therefore that of their
parts of the shaft, summed.

The compiled functions use LDL^T for the band and row-wise Cholesky for the envelope. Without compilation, the band is
solved in blocks by numpy, because importing scipy.linalg takes longer than solving a scene, and the envelope by LAPACK as a
full matrix. Tests compare the results with and without compilation.
"""

from math import sqrt

import numpy as np

from rollbench.lowfi.jit import is_compiled_module, kernel
from rollbench.lowfi.statics.kernel_types import Array


@kernel
def ldl_factor(band: Array) -> bool:
    """Factor a banded matrix as L D L^T; return False if it is not positive definite.

    ``band`` (n, w) holds the lower band of the matrix on entry and the factors L (unit diagonal) and 1/D on return.
    """
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
    """Solve A x = b for one right-hand side and write x over b (n,); band: factors of A from `ldl_factor`."""
    n, width = band.shape
    for j in range(n):
        for i in range(1, min(width, n - j)):
            b[j + i] -= band[j, i] * b[j]
    for j in range(n - 1, -1, -1):
        x = b[j] * band[j, 0]
        for i in range(1, min(width, n - j)):
            x -= band[j, i] * b[j + i]
        b[j] = x


def _pad_band_to_blocks(band: Array) -> Array:
    """Return the lower band (n, w) of a matrix that is extended by rows of a unit matrix to a multiple of w - 1 rows.

    w - 1 is the size of the blocks into which `_block_factor` divides the matrix.
    """
    n, width = band.shape
    size = max(width - 1, 1)
    filled = np.zeros((-(-n // size) * size, size + 1))
    filled[:n, :width] = band
    for j in range(max(n - width + 1, 0), n):
        filled[j, n - j :] = 0.0
    filled[n:, 0] = 1.0
    return filled


def _block_views(filled: Array) -> tuple[Array, Array]:
    """Return views of the m diagonal blocks (m, b, b) of a band matrix A, and of the blocks below them.

    ``filled`` (m b, b + 1): lower band of A from `_pad_band_to_blocks`. Only the lower triangles of the diagonal blocks
    and the upper triangles of the blocks below belong to the matrix; the other triangle of a view shows coefficients of
    other blocks. The views work because A[i, j] is stored at the flat index j (b + 1) + i - j = j b + i.
    """
    size = filled.shape[1] - 1
    flat = filled.reshape(-1, size * (size + 1))
    on, below = (x.reshape(-1, size, size).transpose(0, 2, 1) for x in (flat[:, : size * size], flat[:, size:]))
    return on, below


def _block_factor(band: Array) -> bool:
    """Factor a banded matrix by blocks (Cholesky); return False if it is not positive definite.

    On return ``band`` holds the inverses of the diagonal blocks of the factor, and the blocks below them.
    """
    filled = _pad_band_to_blocks(band)
    factor = np.zeros_like(filled)
    (on, below), (inverse, under) = _block_views(filled), _block_views(factor)
    taken = np.zeros(on.shape[1:])
    try:
        for k in range(len(on)):
            inverted = np.tril(np.linalg.inv(np.linalg.cholesky(on[k] - taken)))  # cholesky reads the lower triangle only
            row = np.triu(below[k]) @ inverted.T
            taken = row @ row.T
            inverse[k] += inverted
            under[k] += row
    except np.linalg.LinAlgError:
        return False
    band[:] = factor[: band.shape[0], : band.shape[1]]
    return True


def inverted_and_lower_blocks(band: Array) -> tuple[Array, Array]:
    """Return the inverted diagonal blocks (m, b, b) of a banded matrix's Cholesky factor, and the blocks below them.

    ``band``: factor from `_block_factor`. The result is the input of `substitute_blocks`.
    """
    on, below = _block_views(_pad_band_to_blocks(band))
    return np.tril(on), np.triu(below)


def substitute_blocks(blocks: tuple[Array, Array], b: Array) -> None:
    """Solve A x = b for one right-hand side (n,) or several (n, k) and write x over b.

    blocks: inverted diagonal blocks of the factor of A, and the blocks below them, from `inverted_and_lower_blocks`.
    """
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
    """Solve A x = b and write x over b (n,); band: factor of A from `_block_factor`."""
    substitute_blocks(inverted_and_lower_blocks(band), b)


#: Factor a banded matrix in place, and solve with that factor: compiled or numpy version.
factor_band = ldl_factor if is_compiled_module(__name__) else _block_factor
substitute_band = ldl_substitute if is_compiled_module(__name__) else _block_substitute


@kernel
def envelope_factor(values: Array, first_column: Array, row_start: Array) -> bool:
    """Replace a symmetric matrix A stored as an envelope by its Cholesky factor; return False if not positive definite.

    ``values``: stored coefficients of the lower triangle, A[i, j] at row_start[i] + j for first_column[i] <= j <= i.
    ``first_column`` (n,): column of the first stored coefficient of each row; ``row_start``: offsets of the rows.
    """
    for i in range(first_column.shape[0]):
        row = row_start[i]
        for j in range(first_column[i], i):
            other = row_start[j]
            x = values[row + j]
            for k in range(max(first_column[i], first_column[j]), j):
                x -= values[row + k] * values[other + k]
            values[row + j] = x / values[other + j]
        x = values[row + i]
        for k in range(first_column[i], i):
            x -= values[row + k] * values[row + k]
        if not x > 0.0:
            return False
        values[row + i] = sqrt(x)
    return True


@kernel
def envelope_substitute(values: Array, first_column: Array, row_start: Array, b: Array) -> None:
    """Solve A x = b and write x over b (n,).

    ``values``: Cholesky factor of A from `envelope_factor`, stored as an envelope: coefficient [i, j] at row_start[i] + j
    for first_column[i] <= j <= i. ``first_column`` (n,) and ``row_start`` are those of `envelope_factor`.
    """
    n = first_column.shape[0]
    for i in range(n):
        row = row_start[i]
        x = b[i]
        for k in range(first_column[i], i):
            x -= values[row + k] * b[k]
        b[i] = x / values[row + i]
    for i in range(n - 1, -1, -1):
        row = row_start[i]
        b[i] = b[i] / values[row + i]
        for k in range(first_column[i], i):
            b[k] -= values[row + k] * b[i]


def _lapack_factor(values: Array, first_column: Array, row_start: Array) -> bool:
    """Replace a symmetric matrix by its Cholesky factor, with LAPACK; return False if it is not positive definite.

    ``values``: coefficients of the lower triangle stored as an envelope, [i, j] at row_start[i] + j for first_column[i] <=
    j <= i.
    """
    n = first_column.shape[0]
    full = np.zeros((n, n))
    for i in range(n):
        full[i, first_column[i] : i + 1] = values[row_start[i] + first_column[i] : row_start[i] + i + 1]
    try:
        factor = np.linalg.cholesky(full)
    except np.linalg.LinAlgError:
        return False
    for i in range(n):
        values[row_start[i] + first_column[i] : row_start[i] + i + 1] = factor[i, first_column[i] : i + 1]
    return True


def _lapack_solve(values: Array, first_column: Array, row_start: Array, b: Array) -> None:
    """Solve A x = b with LAPACK and write x over b (n,).

    ``values``: Cholesky factor of A from `_lapack_factor`, stored as an envelope: coefficient [i, j] at row_start[i] + j
    for first_column[i] <= j <= i.
    """
    from scipy.linalg import solve_triangular

    n = first_column.shape[0]
    full = np.zeros((n, n))
    for i in range(n):
        full[i, first_column[i] : i + 1] = values[row_start[i] + first_column[i] : row_start[i] + i + 1]
    b[:] = solve_triangular(full, solve_triangular(full, b, lower=True), lower=True, trans=1)


#: Factor a matrix stored as an envelope in place, and solve with that factor: compiled or LAPACK version.
factor = envelope_factor if is_compiled_module(__name__) else _lapack_factor
substitute = envelope_substitute if is_compiled_module(__name__) else _lapack_solve
