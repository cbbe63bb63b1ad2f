"""How an elastic body answers generalised loads: F = B^T K^-1 B for many sparse rows of loads at once."""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from hifi.solvers import FactorError, factor, gram

Array = NDArray[np.float64]


def compliance(K: sp.spmatrix, rows: sp.spmatrix, chunk: int = 64) -> Array:
    """F ``(m, m)`` = rows K^-1 rows^T for sparse ``rows`` ``(m, n)`` on the held stiffness K ``(n, n)``.

    By one bordered Cholesky factorisation where cvxopt is there, else by solving for every row.
    Raises FactorError for a body that is not held.
    """
    rows = sp.csr_matrix(rows)
    if rows.shape[0] == 0:
        return np.zeros((0, 0))
    if find_spec("cvxopt") is not None and rows.shape[0] > 8:
        try:
            F, _ = gram(K, rows.T)
            return np.asarray(0.5 * (F + F.T))
        except FactorError:
            pass  # the border was ordered elsewhere: solve row by row, which also finds a body that is not held
    solver = factor(sp.csc_matrix(K))
    F = np.empty((rows.shape[0], rows.shape[0]))
    for start in range(0, rows.shape[0], chunk):
        F[:, start : start + chunk] = rows @ solver.solve(np.asarray(rows[start : start + chunk].toarray().T))
    return 0.5 * (F + F.T)


def transport(arm: float) -> Array:
    """Motion (6, 6) of the point at z + arm when the section at z moves rigidly by (u, rotation)."""
    t = np.eye(6)
    t[0, 4], t[1, 3] = arm, -arm
    return t
