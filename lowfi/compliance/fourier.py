"""Elastic bodies of revolution under any load: quadratic elements in (r, z), harmonics around the axis (Wilson 1965).

Harmonic n has u_r = U cos n t, u_t = V sin n t, u_z = W cos n t; the set turned by a quarter wave has the same stiffness.
With B = B_0 + n B_1 the stiffness is K_n = c (K_0 + n K_1 + n^2 K_2), c = pi (2 pi for n = 0), so that the generalised
force of a load is its work on the harmonic.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky_banded, solveh_banded
from scipy.linalg.blas import dtrsm
from scipy.linalg.lapack import dpotrf, dtbtrs

from rollbench.meshes.arrays import Array, Index

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

#: Share of a unit load that reaches a line, below which it is none: less than round-off.
NONE_LEFT = 1e-18
#: Gauss points of the 9-node quadrilateral: three a side.
GAUSS = np.array([-np.sqrt(0.6), 0.0, np.sqrt(0.6)])
WEIGHT = np.array([5.0, 8.0, 5.0]) / 9.0


def quadratic(x: Array) -> tuple[Array, Array]:
    """Values and slopes ``(..., 3)`` of the quadratic Lagrange polynomials on nodes -1, 0, 1."""
    values = np.stack([0.5 * x * (x - 1.0), 1.0 - x * x, 0.5 * x * (x + 1.0)], axis=-1)
    return values, np.stack([x - 0.5, -2.0 * x, x + 0.5], axis=-1)


@dataclass(frozen=True)
class Grid:
    """Structured grid of 9-node quadrilaterals: node coordinates r, z ``(lines in z, lines in r)`` [m], odd numbers of
    lines. Node (i, j) has number i * columns + j."""

    r: Array
    z: Array

    @property
    def shape(self) -> tuple[int, int]:
        """Lines in z and in r."""
        return int(self.r.shape[0]), int(self.r.shape[1])

    def cells(self) -> Index:
        """Nodes of every element, ``(elements, 9)``, r fastest."""
        rows, columns = self.shape
        i, j = np.meshgrid(np.arange(0, rows - 1, 2), np.arange(0, columns - 1, 2), indexing="ij")
        corner = (i * columns + j).ravel()
        local = (np.arange(3)[:, None] * columns + np.arange(3)).ravel()
        return np.asarray(corner[:, None] + local, dtype=np.int64)


def refine_lines(ends: Array) -> Array:
    """Element ends ``(k + 1,)`` with the mid nodes of quadratic elements between, ``(2 k + 1,)``."""
    lines = np.empty(2 * ends.size - 1)
    lines[::2], lines[1::2] = ends, 0.5 * (ends[:-1] + ends[1:])
    return lines


def tube_grid(r_ends: Array, z_ends: Array) -> Grid:
    """Grid of a plain tube from element ends in r and z [m]."""
    r, z = refine_lines(r_ends), refine_lines(z_ends)
    return Grid(np.broadcast_to(r, (z.size, r.size)).copy(), np.broadcast_to(z[:, None], (z.size, r.size)).copy())


def elasticity_matrix(young: float, poisson: float) -> Array:
    """D (6, 6) for strains rr, tt, zz, rz, rt, tz (engineering shears)."""
    lam = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
    shear = young / (2.0 * (1.0 + poisson))
    D = np.zeros((6, 6))
    D[:3, :3] = lam
    D[np.arange(3), np.arange(3)] += 2.0 * shear
    D[np.arange(3, 6), np.arange(3, 6)] = shear
    return D


@dataclass(frozen=True)
class Layer:
    """A grooved layer of a body as a smooth one: share ``(k,)`` of its cylinders that is solid at radii ``(k,)`` [m],
    the powers of that share which its stiffness along the axis, and in shear along it, has, and
    the groove's lead angle [rad].

    The lands between grooves are rings: around the axis they are as stiff as their share, along it they hang on what is
    under them.
    """

    radii: tuple[float, ...]
    shares: tuple[float, ...]
    axial: float
    shear: float
    tilt: float

    def elasticity(self, young: float, poisson: float, radius: Array) -> Array:
        """D ``(..., 6, 6)`` at radii ``(...)`` [m], as `elasticity_matrix`."""
        f = np.interp(radius, self.radii, self.shares)
        S = np.zeros((*np.shape(f), 6, 6))
        S[..., :3, :3] = -poisson
        S[..., np.arange(3), np.arange(3)] = 1.0
        S[..., np.arange(3, 6), np.arange(3, 6)] = 2.0 * (1.0 + poisson)
        S /= young * f[..., None, None]
        S[..., 2, 2] *= f ** (1.0 - self.axial)
        for shear in (3, 5):
            S[..., shear, shear] *= f ** (1.0 - self.shear)
        c, s = np.cos(self.tilt), np.sin(self.tilt)
        T = np.eye(6)  # strains along and across the groove
        T[1:3, 1:3] = [[c * c, s * s], [s * s, c * c]]
        T[1, 5], T[2, 5] = -2.0 * c * s, 2.0 * c * s
        T[5] = [0.0, c * s, -c * s, 0.0, 0.0, c * c - s * s]
        T[3:5, 3:5] = [[c, s], [-s, c]]
        S = T.T @ S @ T
        for odd in ((0, 5), (1, 5), (2, 5), (3, 4)):
            S[..., odd[0], odd[1]] = S[..., odd[1], odd[0]] = 0.0
        return np.asarray(np.linalg.inv(S), dtype=float)


def element_matrices(grid: Grid, young: float, poisson: float, layer: Layer | None = None) -> tuple[Array, Array, Array]:
    """K_0, K_1, K_2 ``(elements, 27, 27)`` of all elements, without the factor c; freedoms U, V, W node by node.

    Raises ValueError for an element turned inside out.
    """
    cells = grid.cells()
    r, z = grid.r.ravel()[cells], grid.z.ravel()[cells]
    D = elasticity_matrix(young, poisson)
    B, DB = np.empty((2, len(cells), 9, 6, 54))
    point = 0
    for a, wa in zip(GAUSS, WEIGHT, strict=True):
        for b, wb in zip(GAUSS, WEIGHT, strict=True):
            (nz, dz), (nr, dr) = quadratic(np.array(a)), quadratic(np.array(b))
            N, along_r, along_z = np.outer(nz, nr).ravel(), np.outer(nz, dr).ravel(), np.outer(dz, nr).ravel()
            J = np.stack([r @ along_r, z @ along_r, r @ along_z, z @ along_z], axis=-1)
            det = J[:, 0] * J[:, 3] - J[:, 1] * J[:, 2]
            if not (det > 0.0).all():
                raise ValueError("an element of the section is turned inside out")
            by_r = (J[:, 3, None] * along_r - J[:, 1, None] * along_z) / det[:, None]
            by_z = (J[:, 0, None] * along_z - J[:, 2, None] * along_r) / det[:, None]
            radius = r @ N
            if layer is not None:
                D = layer.elasticity(young, poisson, radius)
            B[:, point, :, :27], B[:, point, :, 27:] = strain_rows(N / radius[:, None], by_r, by_z)
            DB[:, point] = D @ B[:, point] * ((wa * wb) * det * radius)[:, None, None]
            point += 1
    B, DB = B.reshape(-1, 54, 54), DB.reshape(-1, 54, 54)
    K = np.swapaxes(B, 1, 2) @ DB
    cross = K[:, :27, 27:]
    return K[:, :27, :27], cross + np.swapaxes(cross, 1, 2), K[:, 27:, 27:]


def strain_rows(over_r: Array, by_r: Array, by_z: Array) -> tuple[Array, Array]:
    """B_0 and B_1 ``(elements, 6, 27)`` from shape functions over r and their slopes, ``(elements, 9)`` each."""
    B0, B1 = np.zeros((len(by_r), 6, 27)), np.zeros((len(by_r), 6, 27))
    U, V, W = slice(0, 27, 3), slice(1, 27, 3), slice(2, 27, 3)
    B0[:, 0, U], B0[:, 1, U], B0[:, 2, W] = by_r, over_r, by_z
    B0[:, 3, U], B0[:, 3, W] = by_z, by_r
    B0[:, 4, V], B0[:, 5, V] = by_r - over_r, by_z
    B1[:, 1, V], B1[:, 4, U], B1[:, 5, W] = over_r, -over_r, -over_r
    return B0, B1


def factor_c(n: int) -> float:
    """Integral of cos^2 n t (or of 1) around the circle."""
    return 2.0 * np.pi if n == 0 else np.pi


def solved(bands: Array, n: int, loads: Array) -> Array:
    """Motions ``(k, ...)`` of harmonic n by loads ``(k, ...)`` on the freedoms of `Body.bands`.

    Raises LinAlgError where these do not hold the body.
    """
    K = np.tensordot(factor_c(n) * np.array([1.0, n, n * n]), bands, 1)
    return np.asarray(solveh_banded(K, loads, overwrite_ab=True, lower=True, check_finite=False))


def on_last(bands: Array, n: int, loads: Array, last: int) -> tuple[Array, Array, Array]:
    """Harmonic n with all but the ``last`` freedoms of `Body.bands` condensed: stiffness S ``(last, last)`` and loads g
    ``(last, c)`` on these, by ``loads`` ``(k, c)`` on all, and the work ``(c, c)`` of these with the last ones held.

    Raises LinAlgError where these do not hold the body.
    """
    K = np.tensordot(factor_c(n) * np.array([1.0, n, n * n]), bands, 1)
    L = cholesky_banded(K, overwrite_ab=True, lower=True, check_finite=False)
    Y = dtbtrs(L, loads, uplo="L")[0]
    before = L.shape[1] - last
    corner = lower_corner(L, before, last)
    return corner @ corner.T, corner @ Y[before:], Y[:before].T @ Y[:before]


def lower_corner(L: Array, first: int, size: int) -> Array:
    """Block ``(size, size)`` from row ``first`` on the diagonal of a lower triangular matrix in bands."""
    place = np.arange(size)
    below = place[:, None] - place
    return np.where((below >= 0) & (below < len(L)), L[np.clip(below, 0, len(L) - 1), first + place], 0.0)


@dataclass(frozen=True)
class Block:
    """Freedoms ``(k,)`` and the parts K_0, K_1, K_2 of their own block ``(3, k, k)`` and of that between the first of them
    and the block before ``(3, m, j)``."""

    own: Index
    diagonal: Array
    lower: Array


class Body:
    """A body of revolution, assembled once for all harmonics."""

    def __init__(
        self, grid: Grid, young: float, poisson: float, layer: Layer | None = None, solid: NDArray[np.bool_] | None = None
    ) -> None:
        """Find the parts of K of all elements; solid: which of them the body fills. Raises ValueError for an element turned
        inside out."""
        self.grid = grid
        self.elements = np.stack(element_matrices(grid, young, poisson, layer))
        if solid is not None:
            self.elements[:, ~solid] = 0.0

    def freedoms(self) -> Index:
        """Freedoms of every element, ``(elements, 27)``."""
        cells = self.grid.cells()
        return (3 * cells[:, :, None] + np.arange(3)).reshape(len(cells), 27)

    @cached_property
    def parts(self) -> tuple[csr_matrix, ...]:
        """K_0, K_1, K_2 ``(3 nodes, 3 nodes)``, which hold the same entries."""
        from scipy.sparse import coo_matrix

        dof = self.freedoms()
        row = np.repeat(dof, 27, axis=1).ravel()
        column = np.tile(dof, (1, 27)).ravel()
        size = 3 * self.grid.r.size
        return tuple(coo_matrix((k.ravel(), (row, column)), (size, size)).tocsr() for k in self.elements)

    def rows(self) -> Array:
        """The parts of K of each row of elements along r, ``(3, rows, 3, m, 3, m)``: of its three lines of m freedoms."""
        count, columns = (n // 2 for n in self.grid.shape)
        own = self.elements.reshape(3, count, columns, *(3,) * 6)
        width = self.grid.shape[1]
        out = np.zeros((3, count, 3, width, 3, 3, width, 3))
        for j in range(columns):
            at = slice(2 * j, 2 * j + 3)
            out[:, :, :, at, :, :, at] += own[:, :, j]
        return out.reshape(3, count, 3, 3 * width, 3, 3 * width)

    def blocks(self, held: NDArray[np.bool_]) -> list[Block]:
        """The parts of K by pairs of grid lines along z: freedoms that are not held, own block, block to the one before.

        Lines 2 k and 2 k + 1, the last one alone: only the first line of a block is joined to the block before.
        """
        rows, width = self.rows(), 3 * self.grid.shape[1]
        found: list[Block] = []
        before = np.zeros(0, dtype=np.int64)
        for k in range(rows.shape[1] + 1):
            lines = 2 if k < rows.shape[1] else 1
            own = np.flatnonzero(~held[2 * k * width : (2 * k + lines) * width])
            whole = np.zeros((3, lines * width, lines * width))
            if lines == 2:
                whole += rows[:, k, :2, :, :2].reshape(whole.shape)
            if k:
                whole[:, :width, :width] += rows[:, k - 1, 2, :, 2]
            lower = rows[:, k - 1, 2, :, :2].reshape(3, width, 2 * width)
            first = own[own < width]
            found.append(Block(2 * k * width + own, whole[:, own[:, None], own], lower[:, first[:, None], before]))
            before = own
        return found

    def bands(self, free: NDArray[np.bool_]) -> Array:
        """The parts of K on the freedoms that are ``free`` ``(3 nodes,)``: lower bands ``(3, width, k)`` for `solved`."""
        count, place = int(free.sum()), np.where(free, np.cumsum(free) - 1, -1)
        i = place[self.freedoms()]
        below = np.flatnonzero((i[:, :, None] >= i[:, None]) & (i[:, None] >= 0))
        j = np.broadcast_to(i[:, None], (len(i), 27, 27)).ravel()[below]
        down = np.broadcast_to(i[:, :, None], (len(i), 27, 27)).ravel()[below] - j
        width, at = int(down.max()) + 1, down * count + j
        parts = self.elements.reshape(3, -1)[:, below]
        found = [np.bincount(at, part, width * count) for part in parts]
        return np.asarray(found, dtype=float).reshape(3, width, count)

    def stiffness(self, n: int) -> csr_matrix:
        """K_n ``(3 nodes, 3 nodes)``."""
        return factor_c(n) * (self.parts[0] + n * self.parts[1] + n * n * self.parts[2])

    def axis_free(self, n: int) -> NDArray[np.bool_]:
        """Freedoms that a regular field of harmonic n may have on the axis (all where the body has a bore), ``(3 nodes,)``.

        At r = 0: n = 0 leaves W, n = 1 leaves U and V (that U = -V there is left to the energy), n > 1 nothing.
        """
        free = np.ones((self.grid.r.size, 3), dtype=bool)
        on_axis = self.grid.r.ravel() == 0.0
        free[on_axis] = {0: (False, False, True), 1: (True, True, False)}.get(n, (False, False, False))
        return free.ravel()


def end_motions(body: Body, n: int) -> Array:
    """Mean rigid motions of an end section, rows on the freedoms of its grid line, ``(k, 3 columns)``.

    n = 0: axial motion and twist; n = 1: shift across and tilt (u_z = - tilt r cos t); none above.
    """
    r = body.grid.r[0]
    weights = np.zeros((2, r.size))  # shares of the nodes in the means of f over the area, and of f r over its moment
    for a in range(0, r.size - 2, 2):
        for x, w in zip(GAUSS, WEIGHT, strict=True):
            N = quadratic(np.array(x))[0]
            at = float(r[a : a + 3] @ N)
            weights[:, a : a + 3] += w * 0.5 * (r[a + 2] - r[a]) * N * np.array([[at], [at * at]])
    weights[0] *= 2.0 / (r[-1] ** 2 - r[0] ** 2)
    weights[1] *= 4.0 / (r[-1] ** 4 - r[0] ** 4)
    out = np.zeros((2 if n < 2 else 0, r.size, 3))
    if n == 0:
        out[0, :, 2], out[1, :, 1] = weights
    elif n == 1:
        out[0, :, 0], out[0, :, 1], out[1, :, 2] = 0.5 * weights[0], -0.5 * weights[0], -weights[1]
    return out.reshape(len(out), 3 * r.size)


def line_compliance(
    body: Body,
    harmonics: Sequence[int],
    held: NDArray[np.bool_],
    line: int,
    rows: tuple[int, int],
    springs: Sequence[float] = (),
) -> list[Array]:
    """Motion of the nodes of grid line r = ``line`` by loads on them, ``(3 k, 3 k)`` for each harmonic, freedoms U, V, W
    node by node.

    held ``(3 nodes,)``: fixed freedoms; rows (first, last + 1): which lines in z are loaded and watched; springs: shift,
    tilt, axial and twist stiffness [N/m, N m] of the low end's mean motions. With springs, harmonics 0 and 1 have two more
    rows and columns: the mean motions of the high end (`end_motions`). Raises LinAlgError where the body is not held.
    """
    nodes = np.arange(*rows) * body.grid.shape[1] + line
    watched = np.full(3 * body.grid.r.size, -1, dtype=np.int64)
    watched[(3 * nodes[:, None] + np.arange(3)).ravel()] = np.arange(3 * nodes.size)
    on_axis = bool((body.grid.r == 0.0).any())
    groups: dict[bytes, list[Block]] = {}
    answers = []
    for n in harmonics:
        fixed = held | ~body.axis_free(n) if on_axis else held
        blocks = groups.setdefault(fixed.tobytes(), [])
        if not blocks:
            blocks += body.blocks(fixed)
        answers.append(_sweep(body, blocks, n, watched, springs))
    return answers


def _sweep(body: Body, blocks: list[Block], n: int, watched: Index, springs: Sequence[float]) -> Array:
    """Block Cholesky along z, forward only: with K = L L^T and Y = L^-1 E the answer is Y^T Y.

    Of a block X = L^-1 (C^T, E), C to the first line of the block after it: X^T X is what that line and its loads lose,
    and a share of the answer. What harmonic n leaves of a load decays as exp(-n z / r): loads of which less than round-off
    reaches a line are none for all lines after it, so that time grows with the length of a body but for harmonics 0 and 1.
    """
    powers = factor_c(n) * np.array([1.0, n, n * n])
    ends = end_motions(body, n) if springs else np.zeros((0, 0))
    total = int(watched.max()) + 1
    found, seen, first = np.zeros((total + len(ends),) * 2), np.zeros(0, dtype=np.int64), 0
    lost, loads = np.zeros((0, 0)), np.zeros((0, 0))
    for k, block in enumerate(blocks):
        own, last = block.own, k == len(blocks) - 1
        diagonal = np.tensordot(powers, block.diagonal, 1)
        diagonal[: len(lost), : len(lost)] -= lost
        if k == 0 and len(ends):
            low = ends[:, own[own < ends.shape[1]]]
            size = low.shape[1]
            diagonal[:size, :size] += low.T @ (np.array(springs[2:] if n == 0 else springs[:2])[:, None] * low)
        new = np.flatnonzero(watched[own] >= 0)
        high = total + np.arange(len(ends) if last else 0)
        after = 0 if last else blocks[k + 1].lower.shape[1]
        known = after + seen.size - first
        X = np.zeros((own.size, known + new.size + high.size), order="F")
        if not last:
            X[:, :after] = np.tensordot(powers, blocks[k + 1].lower, 1).T
        X[: len(loads), after:known] = -loads
        X[new, known + np.arange(new.size)] = 1.0
        if high.size:  # the last block is the last line
            X[:, -high.size :] = ends[:, own - (3 * body.grid.r.size - ends.shape[1])].T
        seen = np.concatenate([seen, watched[own[new]], high])
        P = forward(diagonal, X)
        found[first : seen.size, first : seen.size] += P[after:, after:]
        felt = np.abs(P[:after, after:]).max(axis=0, initial=0.0) > NONE_LEFT
        gone = int(felt.argmax()) if felt.any() else felt.size
        lost, loads, first = P[:after, :after], P[:after, after + gone :], first + gone
    answer = np.zeros_like(found)
    answer[np.ix_(seen, seen)] = found[: seen.size, : seen.size]
    return answer


def forward(K: Array, X: Array) -> Array:
    """X^T K^-1 X of a symmetric K ``(k, k)``, by its Cholesky factor; both are overwritten. Raises LinAlgError where K is
    not positive."""
    if K.size == 0:
        return np.zeros((X.shape[1],) * 2)
    L, fault = dpotrf(K.T, lower=1, clean=0, overwrite_a=1)  # symmetric, so that the transpose is K in LAPACK's order
    if fault:
        raise np.linalg.LinAlgError("the body is not held")
    Y = dtrsm(1.0, L, X, lower=1, overwrite_b=1)
    return np.asarray(Y.T @ Y)
