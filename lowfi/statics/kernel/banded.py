"""Symmetric positive definite banded systems, A[i, j] = band[j, i - j] for i >= j: the lower band, column by column.

Compiled: the column-wise LDL^T below. Interpreted: LAPACK through scipy. A test compares them.
"""

import numpy as np

from lowfi.jit import is_compiled, kernel
from lowfi.statics.records import Array


@kernel
def eliminate(band: Array, column: Array, j: int, m: int) -> None:
    """Eliminate unknown j from the m - 1 that follow it."""
    inverse = 1.0 / band[j, 0]
    for i in range(1, m):
        column[i] = band[j, i]  # a copy: the compiler then knows that the updates below do not change it
        band[j, i] = column[i] * inverse
    band[j, 0] = inverse
    for k in range(1, m):
        f = column[k] * inverse
        if f != 0.0:
            for i in range(m - k):
                band[j + k, i] -= f * column[k + i]


@kernel
def ldl_factor(band: Array) -> bool:
    """Overwrite ``band`` (n, w) with the factors L (unit) and 1/D; False where the matrix is not positive definite."""
    n, width = band.shape
    column = np.empty(width)
    for j in range(n):
        if not band[j, 0] > 0.0:
            return False
        if width == 12 and j + 12 <= n:
            eliminate(band, column, j, 12)  # the common width, known to the compiler: its loops unroll
        else:
            eliminate(band, column, j, min(width, n - j))
    return True


@kernel
def forward(band: Array, b: Array, j: int, m: int) -> None:
    """Take unknown j from the m - 1 that follow it."""
    x = b[j]
    for i in range(1, m):
        b[j + i] -= band[j, i] * x


@kernel
def backward(band: Array, b: Array, j: int, m: int) -> None:
    """Solve for unknown j by the m - 1 > 0 that follow it: the one found last at the end, so that nothing waits for it."""
    near, far, half = 0.0, 0.0, (m + 1) // 2
    for i in range(2, half):
        near += band[j, i] * b[j + i]
    for i in range(half, m):
        far += band[j, i] * b[j + i]
    b[j] = b[j] * band[j, 0] - (near + far) - band[j, 1] * b[j + 1]


@kernel
def forward_wide(band: Array, b: Array, j: int, m: int) -> None:
    """The same of a wide band, by rows that the compiler knows to begin at zero."""
    x, row, y = b[j], band[j, 1:m], b[j + 1 : j + m]
    for i in range(m - 1):
        y[i] -= row[i] * x


@kernel
def product(band: Array, b: Array, j: int, m: int) -> float:
    """Sum of the unknowns that follow j, times its factors: four sums side by side, so that none waits for the other."""
    w, x, y, z = 0.0, 0.0, 0.0, 0.0
    whole = m - (m - 1) % 4
    for i in range(1, whole, 4):
        w += band[j, i] * b[j + i]
        x += band[j, i + 1] * b[j + i + 1]
        y += band[j, i + 2] * b[j + i + 2]
        z += band[j, i + 3] * b[j + i + 3]
    for i in range(whole, m):
        w += band[j, i] * b[j + i]
    return (w + x) + (y + z)


@kernel
def ldl_substitute(band: Array, b: Array) -> None:
    """Overwrite b (n,) by the solution, from the factors."""
    n, width = band.shape
    for j in range(n):
        if width == 12 and j + 12 <= n:
            forward(band, b, j, 12)
        else:
            forward_wide(band, b, j, min(width, n - j))
    for j in range(n - 1, -1, -1):
        if width == 12 and j + 12 <= n:
            backward(band, b, j, 12)
        else:
            b[j] = b[j] * band[j, 0] - product(band, b, j, min(width, n - j))


def _lapack_factor(band: Array) -> bool:
    from scipy.linalg import LinAlgError, cholesky_banded

    try:
        band[:] = cholesky_banded(band.T, lower=True, check_finite=False).T
    except LinAlgError:
        return False
    return True


def _lapack_substitute(band: Array, b: Array) -> None:
    from scipy.linalg import cho_solve_banded

    b[:] = cho_solve_banded((band.T, True), b, check_finite=False)


factor_band = ldl_factor if is_compiled(__name__) else _lapack_factor
substitute_band = ldl_substitute if is_compiled(__name__) else _lapack_substitute
