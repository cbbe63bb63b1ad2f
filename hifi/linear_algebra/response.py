"""How an elastic body answers generalised loads: F = B^T K^-1 B for many sparse rows of loads at once."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from rollbench.hifi.linear_algebra.solvers import gram
from rollbench.meshes.arrays import Array


def compliance(K: sp.spmatrix, rows: sp.spmatrix) -> Array:
    """F ``(m, m)`` = rows K^-1 rows^T for sparse ``rows`` ``(m, n)`` on the held stiffness K ``(n, n)``.

    Raises FactorError for a body that is not held, and where the factorisation fails for another reason.
    """
    rows = sp.csr_matrix(rows)
    if rows.shape[0] == 0:
        return np.zeros((0, 0))
    F = gram(K, rows.T)
    return np.asarray(0.5 * (F + F.T))


def transport(arm: float) -> Array:
    """Motion (6, 6) of the point at z + arm when the section at z moves rigidly by (u, rotation)."""
    t = np.eye(6)
    t[0, 4], t[1, 3] = arm, -arm
    return t
