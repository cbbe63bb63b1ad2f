"""How an elastic body answers generalised loads: F = B^T K^-1 B for many sparse rows of loads at once."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from hifi.solvers import FactorError, factor, gram

Array = NDArray[np.float64]

#: Rows of loads up to which as many solves are as fast as a bordered factor.
FEW = 8


def compliance(K: sp.spmatrix, rows: sp.spmatrix, soft: float = 1e2) -> Array:
    """F ``(m, m)`` = rows K^-1 rows^T for sparse ``rows`` ``(m, n)`` on the held stiffness K ``(n, n)``.

    By one bordered Cholesky factorisation, or for up to `FEW` rows by solving for each. soft: how much more a body held far
    away may yield than its cells do beside a load; more of it costs digits, less a second factorisation. Raises FactorError
    for a body that is not held, and where the factorisation fails for another reason.
    """
    rows = sp.csr_matrix(rows)
    if rows.shape[0] == 0:
        return np.zeros((0, 0))
    if rows.shape[0] <= FEW:
        F = np.asarray(rows @ factor(K).solve(rows.toarray().T))
        return np.asarray(0.5 * (F + F.T))
    try:
        F = gram(K, rows.T, soft)
    except FactorError:
        factor(K)  # says if the body is not held
        raise
    return np.asarray(0.5 * (F + F.T))


def transport(arm: float) -> Array:
    """Motion (6, 6) of the point at z + arm when the section at z moves rigidly by (u, rotation)."""
    t = np.eye(6)
    t[0, 4], t[1, 3] = arm, -arm
    return t
