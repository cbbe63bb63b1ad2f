"""Symmetric positive definite banded systems, A[i, j] = band[j, i - j] for i >= j: the lower band, column by column.

Compiled: the LDL^T below. Interpreted: LAPACK through scipy. A test compares them.
"""

import numpy as np

from rollbench.lowfi.jit import is_compiled, kernel
from rollbench.lowfi.statics.records import Array


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


@kernel
def take(y: Array, x: Array, f: float) -> None:
    """Take f x from y."""
    for i in range(y.size):
        y[i] -= f * x[i]


@kernel
def ldl_substitute_columns(band: Array, Y: Array) -> None:
    """``ldl_substitute`` of the columns of Y (n, k), side by side."""
    n, width = band.shape
    for j in range(n):
        for i in range(1, min(width, n - j)):
            if band[j, i] != 0.0:
                take(Y[j + i], Y[j], band[j, i])
    for j in range(n - 1, -1, -1):
        for k in range(Y.shape[1]):
            Y[j, k] *= band[j, 0]
        for i in range(1, min(width, n - j)):
            if band[j, i] != 0.0:
                take(Y[j], Y[j + i], band[j, i])


def _lapack_factor(band: Array) -> bool:
    from scipy.linalg import LinAlgError, cholesky_banded

    try:
        band[:] = cholesky_banded(band.T, lower=True, check_finite=False).T
    except LinAlgError:
        return False
    return True


def _lapack_substitute(band: Array, b: Array) -> None:  # one column, or several
    from scipy.linalg import cho_solve_banded

    b[:] = cho_solve_banded((band.T, True), b, check_finite=False)


factor_band = ldl_factor if is_compiled(__name__) else _lapack_factor
substitute_band = ldl_substitute if is_compiled(__name__) else _lapack_substitute
substitute_columns = ldl_substitute_columns if is_compiled(__name__) else _lapack_substitute
