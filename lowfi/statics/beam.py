"""Timoshenko beam elements between nodes of six motions each, and their banded stiffness matrix.

A banded matrix is stored as lower band: A[i, j] = band[j, i - j] for i >= j. It is solved in blocks by NumPy, because
importing scipy.linalg takes longer than solving a scene; a large one by LAPACK, which is 20 times as fast.
"""

from __future__ import annotations

import numpy as np

from rollbench.meshes.arrays import Array

#: Number of rows from which LAPACK solves a banded matrix.
LARGE = 1500
#: Cholesky's factor of a banded matrix: by blocks, or LAPACK's.
BandFactor = tuple[Array, Array] | Array


def element_constants(length: Array | float, section: Array) -> tuple[Array, Array, Array, Array, Array]:
    """Return the stiffness constants of Timoshenko beam elements: k_uu, k_uu L/2, k_rr, EA/L, GJ/L.

    They relate the force and moment at an element's second node to its deformation, the motion of this node minus the
    rigid-body motion of the first node transferred to it. k_uu [N/m] (lateral force by displacement) is
    1/(L (L^2/(12 EI) + 1/(kappa G A))), k_rr [N m] (moment by rotation) is k_uu L^2/3 + k_uu EI/(kappa G A), and k_uu L/2
    [N] couples both. Corrects equations D.1 and D.2 of Lin's thesis.

    Parameters
    ----------
    length
        Lengths L of the elements [m].
    section
        EA [N], EI [N m^2], GJ [N m^2], kappa G A [N] ``(4, ...)`` of the elements.
    """
    EA, EI, GJ, kGA = section
    kuu = 1.0 / (length * (length * length / (12.0 * EI) + 1.0 / kGA))
    krr = kuu * (length * length / 3.0 + EI / kGA)
    return kuu, 0.5 * length * kuu, krr, EA / length, GJ / length


def end_stiffness(length: float, section: Array) -> Array:
    """Return the stiffness ``(6, 6)`` [N/m, N, N m] of an element: force and moment at node 2 per unit deformation.

    The deformation is the motion of node 2 minus the rigid-body motion of node 1 transferred to it. ``section`` ``(4,)``:
    see `element_constants`.
    """
    kuu, kur, krr, ka, kt = element_constants(length, section)
    k = np.diag(np.array([kuu, kuu, ka, krr, krr, kt]))
    k[0, 4] = k[4, 0] = -kur  # plane x-z: u_x with r_y
    k[1, 3] = k[3, 1] = kur  # plane y-z: u_y with r_x, of the other sign
    return k


def beam_stiffness_band(lengths: Array, sections: Array) -> Array:
    """Return the stiffness matrix of a chain of n - 1 elements between n nodes as lower band ``(6 n, 12)``.

    ``lengths`` ``(n - 1,)`` [m]; ``sections`` ``(4, n - 1)``: see `element_constants`.
    """
    band = np.zeros((6 * (lengths.size + 1), 12))
    kuu, kur, krr, ka, kt = element_constants(lengths, sections)
    off = lengths * kur - krr  # between the rotations of both nodes
    i = 6 * np.arange(lengths.size)
    j = i + 6
    for u, r, sign in ((0, 4, 1.0), (1, 3, -1.0)):  # plane x-z: displacement u_x, rotation r_y; plane y-z: u_y, r_x
        # node 1 with itself, then node 1 with node 2 (columns j), then node 2 with itself
        band[i + u, 0] += kuu
        band[i + r, 0] += krr
        band[i + u, r - u] += sign * kur
        band[i + u, 6] -= kuu
        band[i + u, 6 + r - u] += sign * kur
        band[i + r, 6 + u - r] -= sign * kur
        band[i + r, 6] += off
        band[j + u, 0] += kuu
        band[j + r, 0] += krr
        band[j + u, r - u] -= sign * kur
    for k, along in ((2, ka), (5, kt)):
        band[i + k, 0] += along
        band[i + k, 6] -= along
        band[j + k, 0] += along
    return band


def nodal_forces(lengths: Array, sections: Array, q: Array) -> Array:
    """Return the forces and moments ``(6 n, ...)`` [N, N m] on the n nodes of a chain that its motions ``q`` need.

    It is the product of the stiffness matrix with the motions ``(6 n, ...)`` [m, rad], summed over the deformations of the
    elements. The product itself subtracts far larger numbers where elements are short: on a shaft of 0.8 m with an element
    of 0.05 mm, motions by the matrix alone are wrong by 7e-10, with one correction by these forces by 6e-14.

    ``lengths`` ``(n - 1,)`` [m]; ``sections`` ``(4, n - 1)``: see `element_constants`.
    """
    moved = q.reshape(lengths.size + 1, 6, -1)
    L = lengths[:, None]
    kuu, kur, krr, ka, kt = (x[:, None] for x in element_constants(lengths, sections))
    d, out, held = np.diff(moved, axis=0), np.zeros_like(moved), np.zeros_like(moved[1:])
    for u, r, sign in ((0, 4, 1.0), (1, 3, -1.0)):  # plane x-z, and plane y-z with the other sign
        d[:, u] -= sign * L * moved[:-1, r]
        held[:, u], held[:, r] = kuu * d[:, u] - sign * kur * d[:, r], krr * d[:, r] - sign * kur * d[:, u]
        out[:-1, r] -= sign * L * held[:, u]
    held[:, 2], held[:, 5] = ka * d[:, 2], kt * d[:, 5]
    out[1:] += held
    out[:-1] -= held
    return out.reshape(q.shape)


def factor_band(band: Array) -> BandFactor:
    """Return Cholesky's factor of a banded matrix, for `substitute`.

    It is that of LAPACK ``(b + 1, n)`` for `LARGE` rows and more. Otherwise it has blocks: the inverses of its m diagonal
    blocks ``(m, b, b)`` and the blocks below them ``(m, b, b)``. ``band`` ``(n, b + 1)``: lower band; in blocks it is
    extended by rows of a unit matrix to a multiple of b rows.

    Raises
    ------
    LinAlgError
        If the matrix is not positive definite.
    """
    if len(band) >= LARGE:
        from scipy.linalg import cholesky_banded

        return np.asarray(cholesky_banded(band.T, lower=True, check_finite=False))
    (n, width), size = band.shape, max(band.shape[1] - 1, 1)
    filled = np.zeros((-(-n // size) * size, size + 1))
    filled[:n, :width] = band
    for j in range(max(n - width + 1, 0), n):
        filled[j, n - j :] = 0.0
    filled[n:, 0] = 1.0
    # views of the blocks work because A[i, j] is stored at the flat index j (b + 1) + i - j = j b + i; their other triangle
    # shows coefficients of other blocks
    flat = filled.reshape(-1, size * (size + 1))
    on, below = (x.reshape(-1, size, size).transpose(0, 2, 1) for x in (flat[:, : size * size], flat[:, size:]))
    inverse, under, taken = np.zeros(on.shape), np.triu(below), np.zeros(on.shape[1:])
    for k in range(len(on)):
        inverse[k] = np.tril(np.linalg.inv(np.linalg.cholesky(on[k] - taken)))  # cholesky reads the lower triangle only
        under[k] = np.triu(under[k] @ inverse[k].T)
        taken = under[k] @ under[k].T
    return inverse, under


def substitute(factor: BandFactor, b: Array) -> None:
    """Solve A x = b for one right-hand side ``(n,)`` or several ``(n, k)``, and write x over b.

    ``factor``: that of A from `factor_band`.
    """
    if isinstance(factor, np.ndarray):
        from scipy.linalg import cho_solve_banded

        b[:] = cho_solve_banded((factor, True), b, check_finite=False)
        return
    inverse, below = factor
    whole = np.zeros((inverse.shape[0] * inverse.shape[1], *b.shape[1:]))
    whole[: len(b)] = b
    x = whole.reshape(*inverse.shape[:2], b.size // len(b))
    for k in range(len(inverse)):
        x[k] = inverse[k] @ (x[k] - below[k - 1] @ x[k - 1] if k else x[k])
    for k in range(len(inverse) - 1, -1, -1):
        x[k] = inverse[k].T @ (x[k] - below[k].T @ x[k + 1] if k + 1 < len(inverse) else x[k])
    b[:] = whole[: len(b)]
