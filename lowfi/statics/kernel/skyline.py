"""Symmetric positive definite systems in an envelope: row i holds the columns from first[i] to i.

Elimination fills nothing outside the envelope. A shaft is a narrow band; a body that is joined to a stretch of it and comes
right after that stretch has rows as long as the stretch, so that many bodies cost as much as their stretches together.
"""

from math import sqrt

import numpy as np

from rollbench.lowfi.jit import kernel
from rollbench.lowfi.statics.records import Array


@kernel
def row_factor(values: Array, first: Array, start: Array) -> bool:
    """Overwrite the envelope by its Cholesky factor, row by row; False where the matrix is not positive definite."""
    for i in range(first.shape[0]):
        row = start[i]
        for j in range(first[i], i + 1):
            other, low = start[j], max(first[i], first[j])
            x = values[row + j] - np.dot(values[row + low : row + j], values[other + low : other + j])
            if j < i:
                values[row + j] = x / values[other + j]
            elif x > 0.0:
                values[row + i] = sqrt(x)
            else:
                return False
    return True


@kernel
def row_solve(values: Array, first: Array, start: Array, b: Array) -> None:
    """Overwrite b (n,) by the solution, from the factor."""
    n = first.shape[0]
    for i in range(n):
        low, row = first[i], start[i]
        b[i] = (b[i] - np.dot(values[row + low : row + i], b[low:i])) / values[row + i]
    for i in range(n - 1, -1, -1):
        low, row = first[i], start[i]
        b[i] /= values[row + i]
        b[low:i] -= b[i] * values[row + low : row + i]
