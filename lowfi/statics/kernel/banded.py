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
def ldl_substitute(band: Array, b: Array) -> None:
    """Overwrite b (n,) by the solution, from the factors."""
    n, width = band.shape
    for j in range(n):
        if width == 12 and j + 12 <= n:
            forward(band, b, j, 12)
        else:
            forward(band, b, j, min(width, n - j))
    for j in range(n - 1, -1, -1):
        if width == 12 and j + 12 <= n:
            backward(band, b, j, 12)
        else:
            x = b[j] * band[j, 0]
            for i in range(1, min(width, n - j)):
                x -= band[j, i] * b[j + i]
            b[j] = x


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
