"""Symmetric positive definite systems in an envelope: row i holds the columns from first[i] to i.

Elimination fills nothing outside the envelope. A shaft is a narrow band; a body that is joined to a stretch of it and comes
right after that stretch has rows as long as the stretch, so that many bodies cost as much as their stretches together.
Compiled: row-wise Cholesky. Interpreted: LAPACK on the full matrix. A test compares them.
"""

from math import sqrt

import numpy as np

from rollbench.lowfi.jit import is_compiled, kernel
from rollbench.lowfi.statics.kernel_types import Array


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
