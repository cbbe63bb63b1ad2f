"""Exact condensation of an elastic body on a few of its freedoms and the loads that contact will put on it.

With i the eliminated freedoms, c the kept ones and f the amplitudes of the loads P on i:

    [K_ii K_ic; K_ci K_cc] [u_i; q] = [P f; r],     u = P^T u_i
    u = A f + H q,   r = S q - H^T f
    A = P^T K_ii^-1 P,   H = -P^T K_ii^-1 K_ic,   S = K_cc - K_ci K_ii^-1 K_ic
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from hifi.elements import FloatArray, IntArray
from hifi.solvers import FactorError, choose, factor, gram

CHUNK_BYTES = 128e6
"""Memory of one chunk of right-hand sides [bytes]."""
MANY = 100
"""Right-hand sides above which one bordered factor is faster than as many solves."""


@dataclass(frozen=True, eq=False)
class Condensed:
    """A condensed body: u = A f + H q, r = S q - H^T f.

    stiffness: S [N/m], shape (c, c); compliance: A [m/N], shape (m, m); transfer: H, shape (m, c), of unit loads P;
    keep: kept freedoms in the order of q, shape (c,); method, seconds: of the factorisation [s].
    """

    stiffness: FloatArray
    compliance: FloatArray
    transfer: FloatArray
    keep: IntArray
    method: str
    seconds: float


def condense(
    K: sp.spmatrix, keep: IntArray, load_basis: sp.spmatrix | FloatArray | None = None, *, method: str = "auto"
) -> Condensed:
    """Condense the symmetric K (n, n) on the freedoms keep (c,), with loads in the columns of load_basis.

    load_basis: sparse or dense, shape (n, m) with nothing on the kept freedoms, or (n - c, m) on the eliminated ones in
    ascending order; None for no loads. The rows of `transfer` and `compliance` measure P^T u_i.
    Exact up to round-off. With 'cholmod' and many columns by one partial factorisation (`hifi.solvers.gram`), whose
    factor is held twice for a moment; otherwise by solves with chunks of columns.
    Raises ValueError for repeated or absent freedoms or a load on a kept one, FactorError when the eliminated part is
    free to move (keep too few freedoms).
    """
    matrix = sp.csr_matrix(K)
    n = matrix.shape[0]
    keep = np.asarray(keep, dtype=np.int64).ravel()
    if keep.size and not (keep.min() >= 0 and keep.max() < n):
        raise ValueError(f"kept freedoms {keep.min()} to {keep.max()} of {n}")
    if len(np.unique(keep)) != len(keep):
        raise ValueError("a freedom is kept twice")
    inside = np.setdiff1d(np.arange(n), keep)
    loads = _on_eliminated(load_basis, n, keep, inside)
    rows = matrix[inside]
    coupling, m = rows[:, keep].tocsc(), loads.shape[1]
    sources = sp.hstack([loads, -coupling], format="csc")
    product, chosen, seconds = _compliances(rows[:, inside].tocsc(), sources, method)
    product = 0.5 * (product + product.T)
    stiffness = matrix[keep][:, keep].toarray() - product[m:, m:]
    return Condensed(stiffness, product[:m, :m].copy(), product[:m, m:].copy(), keep, chosen, seconds)


def _compliances(inner: sp.csc_matrix, sources: sp.csc_matrix, method: str) -> tuple[FloatArray, str, float]:
    """B^T K_ii^-1 B of the sources B (n, m), shape (m, m), the method and the seconds of its factorisation [s]."""
    size, total = sources.shape
    chosen = choose(size, columns=total) if method == "auto" else method
    if chosen == "cholmod" and total > MANY:
        try:
            product, seconds = gram(inner, sources)
            return product, chosen, seconds
        except FactorError:
            pass  # the columns below work without a border, or say what is wrong
    solver = factor(inner, method=method, columns=total)
    outputs = sources.T.tocsr()
    product = np.empty((total, total))
    step = max(1, int(CHUNK_BYTES / (8 * max(1, size))))
    for start in range(0, total, step):
        part = slice(start, min(start + step, total))
        product[:, part] = outputs @ solver.solve(sources[:, part].toarray())
    return product, solver.method, solver.seconds


def _on_eliminated(
    load_basis: sp.spmatrix | FloatArray | None, n: int, keep: IntArray, inside: IntArray
) -> sp.csc_matrix:
    """Load columns restricted to the eliminated freedoms."""
    if load_basis is None:
        return sp.csc_matrix((len(inside), 0))
    loads = sp.csr_matrix(load_basis)
    if loads.shape[0] == len(inside):
        return loads.tocsc()
    if loads.shape[0] != n:
        raise ValueError(f"load basis has {loads.shape[0]} rows, expected {n} or, without the kept ones, {len(inside)}")
    if loads[keep].count_nonzero():
        raise ValueError("a load acts on a kept freedom: apply it there directly")
    return loads[inside].tocsc()
