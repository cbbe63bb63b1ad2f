"""Solvers for symmetric positive definite matrices, chosen by size, and what an elastic body answers to loads.

Larger ones: Cholesky factor by dense blocks (`hifi.linear_algebra.fronts`) in a nested-dissection order
(`hifi.linear_algebra.dissection`). Small ones: SuperLU of scipy.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import TypeVar

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from rollbench.hifi.linear_algebra.dissection import supernodes
from rollbench.hifi.linear_algebra.fronts import factor_by_fronts, gram_by_fronts
from rollbench.meshes.arrays import Array

T = TypeVar("T")
Solve = Callable[[Array], Array]
SMALL = 3_000
"""Freedoms below which SuperLU is as fast as anything for one right-hand side."""
FEW = 100_000
"""Entries of all right-hand sides below which it is so for them."""
SINGULAR = 1e13
"""Response of the matrix scaled to a unit diagonal to a unit load, above which it counts as singular."""
CHECKED = 1e-5
"""Largest relative error of the known answer of such a sweep: soft bodies lose up to half the digits."""


class FactorError(ArithmeticError):
    """The matrix cannot be factored: not positive definite, or singular to working precision."""


def factor(K: sp.sparray) -> Solve:
    """Solution of K x = rhs, rhs (n,) or (n, k), for symmetric positive definite K, shape (n, n); only symmetry is taken on
    trust.

    Raises FactorError for a matrix that is not positive definite or singular (a body that nothing holds).
    """
    matrix = sp.csc_array(K)
    diagonal = _diagonal(matrix)
    by_fronts = matrix.shape[0] > SMALL
    solve = _positive(lambda: factor_by_fronts(matrix, supernodes(matrix))) if by_fronts else _splu(matrix)
    _check_response(solve, diagonal)
    return solve


def compliance(K: sp.sparray, rows: sp.sparray) -> Array:
    """F ``(m, m)`` = rows K^-1 rows^T for sparse ``rows`` ``(m, n)`` of loads on the held stiffness K ``(n, n)``.

    Raises FactorError for a body that is not held, and where the factorisation fails for another reason.
    """
    F = gram(K, sp.csr_array(rows).T) if rows.shape[0] else np.zeros((0, 0))
    return np.asarray(0.5 * (F + F.T))


def gram(K: sp.sparray, B: sp.sparray) -> Array:
    """B^T K^-1 B, shape (m, m), for sparse B (n, m): front by front (`hifi.linear_algebra.fronts`), without holding the
    factor.

    Checked by one column more, K x for a known x, whose answer is x. Where that fails, a warning says so, and a factor that
    is held whole is solved with, column by column: it says what is wrong with the matrix. So it does, without a warning, up
    to `SMALL` freedoms and `FEW` entries of B. Raises FactorError as `factor` does.
    """
    inner, columns = sp.csc_array(K), sp.csc_array(B)
    diagonal = _diagonal(inner)
    if inner.shape[0] > SMALL or B.shape[0] * B.shape[1] > FEW:
        known = np.random.default_rng(2).standard_normal(inner.shape[0]) / np.sqrt(diagonal)
        loads = sp.hstack([columns, sp.csc_array((inner @ known)[:, None])]).tocsr()
        solved = _positive(lambda: gram_by_fronts(inner, loads, supernodes(inner)))
        answer = columns.T @ known
        off = np.linalg.norm(solved[:-1, -1] - answer)
        if off <= CHECKED * np.linalg.norm(answer):
            return np.asarray(solved[:-1, :-1])
        missed = f"a known answer is missed by {off / np.linalg.norm(answer):.1g} front by front"
        message = f"{missed}; the factor is held whole, in several times the memory and time"
        warnings.warn(message, RuntimeWarning, stacklevel=3)
    return np.asarray(columns.T @ factor(inner)(columns.toarray()))


def _diagonal(matrix: sp.csc_array) -> Array:
    """Diagonal of the matrix; raises FactorError unless all of it is positive."""
    diagonal: Array = matrix.diagonal()
    if not np.all(diagonal > 0.0):  # also NaN
        bad = int(np.argmin(np.where(np.isnan(diagonal), -np.inf, diagonal)))
        raise FactorError(f"not positive definite: diagonal entry {bad} is {diagonal[bad]:.3g} (a node no cell uses?)")
    return diagonal


def _check_response(solve: Solve, diagonal: Array) -> None:
    """Raise FactorError when the factor belongs to a matrix that is singular to working precision."""
    root = np.sqrt(diagonal)
    load = np.random.default_rng(1).standard_normal(len(root))
    with np.errstate(all="ignore"):
        response = root * solve(root * load)
        ratio = float(np.linalg.norm(response) / np.linalg.norm(load))
    if not ratio < SINGULAR:
        raise FactorError(f"singular to working precision (response {ratio:.1e} to a unit load): is every body held?")


def _positive(eliminate: Callable[[], T]) -> T:
    """Result of an elimination; its breakdown as a FactorError."""
    try:
        return eliminate()
    except ArithmeticError as error:
        raise FactorError(f"not positive definite: elimination breaks down at column {error.args[0]}") from error


def _splu(matrix: sp.csc_array) -> Solve:
    try:
        lu = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError as error:
        raise FactorError(f"not positive definite: SuperLU says {error}") from error
    if not (np.array_equal(lu.perm_r, lu.perm_c) and np.all(lu.U.diagonal() > 0.0)):
        raise FactorError("not positive definite: SuperLU met a pivot that is not positive")
    return lambda rhs: np.asarray(lu.solve(rhs))
