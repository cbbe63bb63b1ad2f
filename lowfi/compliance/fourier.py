"""Elastic bodies of revolution under any load: quadratic elements in (r, z), harmonics around the axis (Wilson 1965).

Harmonic n has the displacements u_r = U cos n t, u_t = V sin n t, u_z = W cos n t; displacements shifted by a quarter wave
have the same stiffness. With the strain matrix B = B_0 + n B_1 the stiffness is K_n = c (K_0 + n K_1 + n^2 K_2). The factor
c = pi (2 pi for n = 0) makes the generalised force of a load equal to its work on the harmonic.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, pairwise
from typing import TYPE_CHECKING

import numpy as np

from rollbench.meshes.arrays import Array, Index, Mask
from rollbench.meshes.parts import Material

if TYPE_CHECKING:
    from scipy.sparse import csr_array

#: Limits below round-off: part of a unit load at a grid line that counts as zero; relative difference of the stiffnesses of
#: two rows of elements that count as equal.
NONE_LEFT, ALIKE = 1e-18, 1e-13
#: Largest number of values in the compliances of harmonics that are computed together.
AT_ONCE = 3_000_000
#: Gauss points of the 9-node quadrilateral, three per side.
GAUSS = np.array([-np.sqrt(0.6), 0.0, np.sqrt(0.6)])
WEIGHT = np.array([5.0, 8.0, 5.0]) / 9.0


def quadratic_shape_functions(x: Array) -> tuple[Array, Array]:
    """Return the values, then the slopes of the quadratic Lagrange polynomials with nodes at -1, 0, 1, each ``(..., 3)``.

    ``x`` ``(...)``: positions between -1 and 1.
    """
    values = np.stack([0.5 * x * (x - 1.0), 1.0 - x * x, 0.5 * x * (x + 1.0)], axis=-1)
    return values, np.stack([x - 0.5, -2.0 * x, x + 0.5], axis=-1)


@dataclass(frozen=True)
class QuadrilateralGrid:
    """Structured grid of 9-node quadrilaterals in the plane (r, z) of a body of revolution.

    The node on line i in z and line j in r has the number i * columns + j.
    """

    #: Radii of the nodes ``(lines in z, lines in r)`` [m]; both numbers of lines are odd.
    r: Array
    #: Axial positions of the nodes ``(lines in z, lines in r)`` [m].
    z: Array

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of lines in z and in r."""
        return int(self.r.shape[0]), int(self.r.shape[1])

    def element_nodes(self) -> Index:
        """Return the numbers of the nine nodes of every element ``(elements, 9)``; nodes along r follow one another."""
        rows, columns = self.shape
        i, j = np.meshgrid(np.arange(0, rows - 1, 2), np.arange(0, columns - 1, 2), indexing="ij")
        corner = (i * columns + j).ravel()
        local = (np.arange(3)[:, None] * columns + np.arange(3)).ravel()
        return np.asarray(corner[:, None] + local, dtype=np.int64)


def node_positions_with_mid_nodes(ends: Array) -> Array:
    """Return the positions ``(2 k + 1,)`` of the nodes of k quadratic elements in a row: ends and mid nodes.

    ``ends``: positions of the elements' ends (k + 1,) [m].
    """
    lines = np.empty(2 * ends.size - 1)
    lines[::2], lines[1::2] = ends, 0.5 * (ends[:-1] + ends[1:])
    return lines


def tube_grid(r_ends: Array, z_ends: Array) -> QuadrilateralGrid:
    """Return the grid of a plain tube whose elements end at given radii ``r_ends`` and axial positions ``z_ends`` [m]."""
    r, z = node_positions_with_mid_nodes(r_ends), node_positions_with_mid_nodes(z_ends)
    return QuadrilateralGrid(*np.meshgrid(r, z))


def elasticity_matrix(young: float, poisson: float) -> Array:
    """Return the isotropic elasticity matrix D ``(6, 6)`` [Pa] for strains rr, tt, zz, rz, rt, tz (engineering shears).

    ``young``: Young's modulus [Pa]; ``poisson``: Poisson's ratio.
    """
    lam = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
    shear = young / (2.0 * (1.0 + poisson))
    D = np.zeros((6, 6))
    D[:3, :3] = lam
    D[np.arange(3), np.arange(3)] += 2.0 * shear
    D[np.arange(3, 6), np.arange(3, 6)] = shear
    return D


@dataclass(frozen=True)
class GrooveLayer:
    """Smooth anisotropic elastic layer that replaces the grooves and lands of a nut.

    The lands between grooves are rings. Around the axis the layer's stiffness is proportional to the filled fraction of its
    volume; along the axis it is lower, because the lands are connected only through the material under them.
    """

    #: Radii of cylinders through the layer ``(k,)`` [m].
    radii: tuple[float, ...]
    #: Fraction of the surface of each of these cylinders that lies in the material of the lands, not in a groove ``(k,)``.
    filled_fractions: tuple[float, ...]
    #: Exponent p of the layer's stiffness across the grooves, nearly along the axis: that of solid material times (filled
    #: fraction)^p.
    axial_exponent: float
    #: Exponent p of the layer's stiffness against shear along the axis: that of solid material times (filled fraction)^p.
    shear_exponent: float
    #: Lead angle of the groove [rad].
    lead_angle: float

    def elasticity(self, young: float, poisson: float, radius: Array) -> Array:
        """Return the elasticity matrix D ``(..., 6, 6)`` [Pa] of the layer at radii ``(...)`` [m]; see `elasticity_matrix`.

        ``young``: Young's modulus [Pa] and ``poisson``: Poisson's ratio of the solid material.
        """
        f = np.interp(radius, self.radii, self.filled_fractions)
        S = np.zeros((*np.shape(f), 6, 6))
        S[..., :3, :3] = -poisson
        S[..., np.arange(3), np.arange(3)] = 1.0
        S[..., np.arange(3, 6), np.arange(3, 6)] = 2.0 * (1.0 + poisson)
        S /= young * f[..., None, None]
        S[..., 2, 2] *= f ** (1.0 - self.axial_exponent)
        for shear in (3, 5):
            S[..., shear, shear] *= f ** (1.0 - self.shear_exponent)
        c, s = np.cos(self.lead_angle), np.sin(self.lead_angle)
        T = np.eye(6)  # strains along and across the groove
        T[1:3, 1:3] = [[c * c, s * s], [s * s, c * c]]
        T[1, 5], T[2, 5] = -2.0 * c * s, 2.0 * c * s
        T[5] = [0.0, c * s, -c * s, 0.0, 0.0, c * c - s * s]
        T[3:5, 3:5] = [[c, s], [-s, c]]
        S = T.T @ S @ T
        for odd in ((0, 5), (1, 5), (2, 5), (3, 4)):
            S[..., odd[0], odd[1]] = S[..., odd[1], odd[0]] = 0.0
        return np.asarray(np.linalg.inv(S), dtype=float)


def element_stiffness_parts(
    grid: QuadrilateralGrid, young: float, poisson: float, layer: GrooveLayer | None = None
) -> tuple[Array, Array, Array]:
    """Return the parts K_0, K_1, K_2 of the element stiffness matrices c (K_0 + n K_1 + n^2 K_2) in harmonic n.

    Each part is ``(elements, 27, 27)``. The degrees of freedom of a node are the amplitudes U, V, W of the radial,
    circumferential and axial displacement; c is `circumference_integral_factor`. ``young`` [Pa], ``poisson``: constants of
    the material; ``layer``: anisotropic layer that represents grooves, or None.

    Raises
    ------
    ValueError
        An element is turned inside out.
    """
    cells = grid.element_nodes()
    r, z = grid.r.ravel()[cells], grid.z.ravel()[cells]
    D = elasticity_matrix(young, poisson)
    B, DB = np.empty((2, len(cells), 9, 6, 54))
    point = 0
    for a, wa in zip(GAUSS, WEIGHT, strict=True):
        for b, wb in zip(GAUSS, WEIGHT, strict=True):
            (nz, dz), (nr, dr) = quadratic_shape_functions(np.array(a)), quadratic_shape_functions(np.array(b))
            N, along_r, along_z = np.outer(nz, nr).ravel(), np.outer(nz, dr).ravel(), np.outer(dz, nr).ravel()
            J = np.stack([r @ along_r, z @ along_r, r @ along_z, z @ along_z], axis=-1)
            det = J[:, 0] * J[:, 3] - J[:, 1] * J[:, 2]
            if not (det > 0.0).all():
                raise ValueError("a finite element of screw or nut is turned inside out: check the dimensions of the body")
            by_r = (J[:, 3, None] * along_r - J[:, 1, None] * along_z) / det[:, None]
            by_z = (J[:, 0, None] * along_z - J[:, 2, None] * along_r) / det[:, None]
            radius = r @ N
            if layer is not None:
                D = layer.elasticity(young, poisson, radius)
            B[:, point, :, :27], B[:, point, :, 27:] = strain_matrices(N / radius[:, None], by_r, by_z)
            DB[:, point] = D @ B[:, point] * ((wa * wb) * det * radius)[:, None, None]
            point += 1
    B, DB = B.reshape(-1, 54, 54), DB.reshape(-1, 54, 54)
    K = np.swapaxes(B, 1, 2) @ DB
    cross = K[:, :27, 27:]
    return K[:, :27, :27], cross + np.swapaxes(cross, 1, 2), K[:, 27:, 27:]


def strain_matrices(over_r: Array, by_r: Array, by_z: Array) -> tuple[Array, Array]:
    """Return the strain matrix B_0 + n B_1 of harmonic n at one point of every element, B_0 and B_1 ``(elements, 6, 27)``.

    They give the strains rr, tt, zz, rz, rt, tz (t: circumferential) from the amplitudes U, V, W of the radial,
    circumferential and axial displacement of nine nodes. ``over_r``: shape functions divided by r; ``by_r``, ``by_z``:
    their derivatives along r and z, each ``(elements, 9)`` [1/m].
    """
    B0, B1 = np.zeros((len(by_r), 6, 27)), np.zeros((len(by_r), 6, 27))
    U, V, W = slice(0, 27, 3), slice(1, 27, 3), slice(2, 27, 3)
    B0[:, 0, U], B0[:, 1, U], B0[:, 2, W] = by_r, over_r, by_z
    B0[:, 3, U], B0[:, 3, W] = by_z, by_r
    B0[:, 4, V], B0[:, 5, V] = by_r - over_r, by_z
    B1[:, 1, V], B1[:, 4, U], B1[:, 5, W] = over_r, -over_r, -over_r
    return B0, B1


def circumference_integral_factor(harmonic: int) -> float:
    """Return the factor c of harmonic n: the integral of cos^2(n t) around the circle, 2 pi for n = 0, otherwise pi."""
    return 2.0 * np.pi if harmonic == 0 else np.pi


def stiffness_part_factors(n: int) -> Array:
    """Return the factors c, c n, c n^2 of the stiffness parts K_0, K_1, K_2 in harmonic n.

    c is `circumference_integral_factor`.
    """
    return circumference_integral_factor(n) * np.array([1.0, n, n * n])


def solve_harmonic_displacements(bands: Array, harmonic: int, loads: Array) -> Array:
    """Solve for the displacements of a body's k free degrees of freedom [m] under loads of harmonic n ``(k, ...)``.

    ``bands``: stiffness parts from `BodyOfRevolution.stiffness_bands`; ``loads``: generalised forces (k, ...) [N].

    Raises
    ------
    LinAlgError
        The body is not fixed.
    """
    from scipy.linalg import solveh_banded

    K = np.tensordot(stiffness_part_factors(harmonic), bands, 1)
    return np.asarray(solveh_banded(K, loads, overwrite_ab=True, lower=True, check_finite=False))


def condense_to_last_freedoms(
    bands: Array, harmonic: int, loads: Array, remaining_count: int
) -> tuple[Array, Array, Array]:
    """Condense a body's stiffness and loads of harmonic n statically to the last degrees of freedom.

    ``bands``: stiffness parts from `BodyOfRevolution.stiffness_bands`; ``loads`` ``(k, c)``: c load cases on all k degrees
    of freedom; ``remaining_count``: number of degrees of freedom that remain.

    Returns
    -------
    tuple[Array, Array, Array]
        Condensed stiffness ``(remaining_count, remaining_count)``; condensed loads ``(remaining_count, c)``; and the
        compliance ``(c, c)`` of the load cases with the last degrees of freedom fixed.

    Raises
    ------
    LinAlgError
        The body is not fixed.
    """
    from scipy.linalg import cholesky_banded
    from scipy.linalg.lapack import dtbtrs

    K = np.tensordot(stiffness_part_factors(harmonic), bands, 1)
    L = cholesky_banded(K, overwrite_ab=True, lower=True, check_finite=False)
    Y = dtbtrs(L, loads, uplo="L")[0]
    before = L.shape[1] - remaining_count
    corner = diagonal_block_of_bands(L, before, remaining_count)
    return corner @ corner.T, corner @ Y[before:], Y[:before].T @ Y[:before]


def diagonal_block_of_bands(L: Array, first: int, size: int) -> Array:
    """Return a square block on the diagonal of a lower triangular matrix that is stored in bands.

    ``L``: the matrix, with row k of the array for the k-th diagonal below the main one; ``first``: first row of the block;
    ``size``: number of its rows.
    """
    place = np.arange(size)
    below = place[:, None] - place
    return np.where((below >= 0) & (below < len(L)), L[np.clip(below, 0, len(L) - 1), first + place], 0.0)


class BodyOfRevolution:
    """Finite-element model of an elastic body of revolution; its element stiffnesses serve all harmonics."""

    def __init__(
        self, grid: QuadrilateralGrid, material: Material, layer: GrooveLayer | None = None, solid: Mask | None = None
    ) -> None:
        """Compute the stiffness parts K_0, K_1, K_2 of all finite elements of the body.

        ``material``: material of the body; ``layer``: anisotropic layer that represents grooves, or None; ``solid``: which
        elements are filled with material, None for all. Raises ValueError if an element is turned inside out.
        """
        self.grid, self.known_bands = grid, dict[bytes, Array]()
        self.elements = np.stack(element_stiffness_parts(grid, material.youngs_modulus, material.poissons_ratio, layer))
        if solid is not None:
            self.elements[:, ~solid] = 0.0

    def element_freedoms(self) -> Index:
        """Return the numbers of the degrees of freedom of every element ``(elements, 27)``."""
        cells = self.grid.element_nodes()
        return (3 * cells[:, :, None] + np.arange(3)).reshape(len(cells), 27)

    def stiffness_of_rows(self, chosen: slice | Index = slice(None)) -> Array:
        """Return the assembled stiffness parts K_0, K_1, K_2 of radial rows of elements ``(3, rows, 3, m, 3, m)``.

        A row consists of all elements between two neighbouring element ends in z. It has three grid lines (both ends and
        the middle) with m degrees of freedom each. The axes are the part, the row of elements, then grid line and degree of
        freedom twice. ``chosen``: numbers of the rows, all by default.
        """
        columns, width = self.grid.shape[1] // 2, self.grid.shape[1]
        elements = self.elements.reshape(3, -1, columns, *(3,) * 6)[:, chosen]
        out = np.zeros((3, elements.shape[1], 3, width, 3, 3, width, 3))
        for j in range(columns):
            at = slice(2 * j, 2 * j + 3)
            out[:, :, :, at, :, :, at] += elements[:, :, j]
        return out.reshape(3, -1, 3, 3 * width, 3, 3 * width)

    @cached_property
    def equals_previous_row(self) -> Mask:
        """Whether each radial row of elements has the same stiffness as the preceding row along the axis ``(rows,)``."""
        rows = self.elements.reshape(3, self.grid.shape[0] // 2, -1)
        change = np.abs(np.diff(rows, axis=1)).max(axis=(0, 2))
        return np.append(False, change < ALIKE * np.abs(rows).max())

    def stiffness_bands(self, free: Mask) -> Array:
        """Return the stiffness parts K_0, K_1, K_2 of the free degrees of freedom, stored in lower bands.

        ``free``: whether each degree of freedom is free (3 nodes,); k of them are.

        Returns
        -------
        Array
            Diagonals of K_0, K_1, K_2 from the main one downwards ``(3, bandwidth, k)``.
        """
        count, place = int(free.sum()), np.where(free, np.cumsum(free) - 1, -1)
        i = place[self.element_freedoms()]
        below = np.flatnonzero((i[:, :, None] >= i[:, None]) & (i[:, None] >= 0))
        j = np.broadcast_to(i[:, None], (len(i), 27, 27)).ravel()[below]
        down = np.broadcast_to(i[:, :, None], (len(i), 27, 27)).ravel()[below] - j
        width, at = int(down.max()) + 1, down * count + j
        parts = self.elements.reshape(3, -1)[:, below]
        found = [np.bincount(at, values, width * count) for values in parts]
        return np.asarray(found, dtype=float).reshape(3, width, count)

    def free_stiffness_bands(self, n: int, held: Mask) -> tuple[Mask, Array]:
        """Return which degrees of freedom are free in harmonic n ``(3 nodes,)``, then `stiffness_bands` of these.

        ``held``: whether each degree of freedom is fixed, of any shape with 3 nodes elements. The bands are computed once
        for all harmonics with the same free degrees of freedom, and must not be modified.
        """
        free = ~held.ravel() & self.freedoms_regular_on_axis(n)
        if free.tobytes() not in self.known_bands:
            self.known_bands[free.tobytes()] = self.stiffness_bands(free)
        return free, self.known_bands[free.tobytes()]

    def harmonic_stiffness(self, n: int) -> csr_array:
        """Return the stiffness matrix K_n of harmonic n ``(3 nodes, 3 nodes)``."""
        from scipy.sparse import coo_array

        dof, size = self.element_freedoms(), 3 * self.grid.r.size
        K = np.tensordot(stiffness_part_factors(n), self.elements, 1)
        at = np.repeat(dof, 27, axis=1).ravel(), np.tile(dof, (1, 27)).ravel()
        return coo_array((K.ravel(), at), (size, size)).tocsr()

    def freedoms_regular_on_axis(self, n: int) -> Mask:
        """Return whether each degree of freedom may move in harmonic n ``(3 nodes,)``: only the axis r = 0 restricts it.

        At r = 0, harmonic 0 allows the amplitude W of the axial displacement, harmonic 1 allows the amplitudes U of the
        radial and V of the circumferential one (U = -V follows from the minimum of energy), and higher harmonics allow
        none.
        """
        free = np.ones((self.grid.r.size, 3), dtype=bool)
        on_axis = self.grid.r.ravel() == 0.0
        free[on_axis] = {0: (False, False, True), 1: (True, True, False)}.get(n, (False, False, False))
        return free.ravel()


def mean_rigid_motion_matrix(r: Array, n: int) -> Array:
    """Return the matrix ``(k, 3 columns)`` that converts nodal displacements of a cross-section to its mean rigid motions.

    ``r`` ``(columns,)``: radii of the nodes [m]; the nodal displacements are the amplitudes U, V, W of the radial,
    circumferential and axial displacement in harmonic ``n``. Harmonic 0 has k = 2 rigid motions, axial motion and twist;
    harmonic 1 has lateral shift and tilt (u_z = - tilt r cos t at the azimuth t); higher harmonics have none.
    """
    weights = np.zeros((2, r.size))  # weights of the nodes in the mean of f over the area, and of f r over its moment
    for a in range(0, r.size - 2, 2):
        for x, w in zip(GAUSS, WEIGHT, strict=True):
            N = quadratic_shape_functions(np.array(x))[0]
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


@dataclass(frozen=True)
class OverlappingBlockMatrix:
    """Symmetric matrix stored as the sum of square blocks on its diagonal, which may overlap."""

    #: Number of rows of the matrix.
    size: int
    #: For each block the number of its first row in the matrix, then its values.
    blocks: tuple[tuple[int, Array], ...]

    def full_matrix(self) -> Array:
        """Return the full matrix ``(size, size)`` as the sum of its blocks."""
        out = np.zeros((self.size, self.size))
        for first, block in self.blocks:
            rows = slice(first, first + len(block))
            out[rows, rows] += block
        return out

    def nonzero_row_range(self, low: int, high: int) -> tuple[int, int]:
        """Return the range of rows (first, last + 1) in which the matrix may have nonzero entries in a range of columns.

        ``low``: first column; ``high``: last column + 1.
        """
        met = [(first, first + len(b)) for first, b in self.blocks if first < high and first + len(b) > low]
        return min((x[0] for x in met), default=low), max((x[1] for x in met), default=low)


def grid_line_compliance(
    body: BodyOfRevolution,
    harmonics: Sequence[int],
    held: Mask,
    line: int,
    rows: tuple[int, int],
    springs: Sequence[float] = (),
) -> list[OverlappingBlockMatrix]:
    """Return the compliance between the nodes on one axial grid line of a body of revolution, in several harmonics.

    Parameters
    ----------
    body
        Body of revolution.
    harmonics
        Numbers of the harmonics.
    held
        Whether each degree of freedom is fixed ``(3 nodes,)``.
    line
        Number of the grid line in r.
    rows
        Numbers of the first, and of the last + 1, of the grid lines in z whose nodes are loaded and whose motions are
        returned.
    springs
        Shift, tilt, axial and twist stiffness [N/m, N m] of springs on the low end's mean motions. With springs, harmonics
        0 and 1 have two more rows and columns: the mean motions of the high end (`mean_rigid_motion_matrix`).

    Returns
    -------
    list[OverlappingBlockMatrix]
        Compliance ``(3 k, 3 k)`` [m/N] between k nodes in each harmonic, with radial, circumferential and axial
        displacement of each node. In harmonics above 1 a load has an effect only over a short length; the blocks have about
        this length.

    Raises
    ------
    LinAlgError
        The body is not fixed.
    """
    n, size = np.asarray(harmonics), max(3 * (rows[1] - rows[0]), 9 * body.grid.shape[1])  # loads, and freedoms of a row
    most = max(1, AT_ONCE // size**2)
    beams, waves = n[n < 2], n[n > 1]  # a wave dies out along the body, a beam's motion does not
    groups = [beams[:1], beams[1:], *(waves[i : i + most] for i in range(0, waves.size, most))]
    found = (_grid_line_compliance_by_stretches(body, group, held, line, rows, springs) for group in groups if group.size)
    return list(chain.from_iterable(found))


@dataclass(frozen=True)
class CondensedStretch:
    """Axial part of a body of revolution in h Fourier harmonics, condensed to the q degrees of freedom at its two ends."""

    #: Stiffness of the degrees of freedom on the grid lines at both ends ``(h, q, q)``.
    end_stiffness: Array
    #: Forces on the grid lines at both ends that are equivalent to k unit loads on nodes between these lines ``(h, q, k)``.
    end_forces: Array
    #: Compliance between the loaded nodes while the grid lines at both ends are fixed: for each diagonal block the index of
    #: its first load, then the block ``(h, w, w)`` for its w loads.
    inner_compliance: tuple[tuple[int, Array], ...] = ()


def join_stretches(a: CondensedStretch, b: CondensedStretch, loads: Array) -> CondensedStretch:
    """Join two neighbouring axial parts of a body into one, and eliminate the grid line between them.

    ``a``: stretch at lower z; ``b``: stretch at higher z; ``loads`` ``(h, m, j)``: j unit loads on the m degrees of freedom
    of that line, in h harmonics. A stretch at an end of the body has only one line. Loads whose part at a line is below
    round-off are neglected there.

    Raises
    ------
    LinAlgError
        The line between is not fixed.
    """
    h, m, between = loads.shape
    low, high = a.end_stiffness.shape[1] - m, b.end_stiffness.shape[1] - m
    before, after = a.end_forces.shape[2], a.end_forces.shape[2] + between
    size, total = low + m + high, after + b.end_forces.shape[2]
    K, forces = np.zeros((h, size, size)), np.zeros((h, size, total))
    K[:, : low + m, : low + m] = a.end_stiffness
    K[:, low:, low:] += b.end_stiffness
    forces[:, : low + m, :before], forces[:, low:, after:] = a.end_forces, b.end_forces
    forces[:, low : low + m, before:after] = loads
    motion = *a.inner_compliance, *((after + first, block) for first, block in b.inner_compliance)
    return eliminate_freedoms(CondensedStretch(K, forces, motion), slice(low, low + m))


def eliminate_freedoms(stretch: CondensedStretch, line: slice) -> CondensedStretch:
    """Eliminate degrees of freedom of an axial part of a body by static condensation.

    ``line``: range of the degrees of freedom that are eliminated. The returned stretch has the remaining ones.
    """
    from scipy.linalg import solve_triangular

    K, forces, motion = stretch.end_stiffness, stretch.end_forces, stretch.inner_compliance
    left = np.delete(np.arange(K.shape[1]), line)
    reach = np.flatnonzero((np.abs(forces[:, line]) > NONE_LEFT).any(axis=(0, 1)))
    felt = slice(reach[0], reach[-1] + 1) if reach.size else slice(0, 0)
    X = np.concatenate([K[:, line, left], forces[:, line, felt]], axis=2)
    P, m = np.empty((len(X), *X.shape[2:] * 2)), left.size
    for product, L, x in zip(P, np.linalg.cholesky(K[:, line, line]), X, strict=True):
        y = solve_triangular(L, x, lower=True, check_finite=False)
        np.matmul(y.T, y, out=product)
    forces = forces[:, left]
    forces[:, :, felt] -= P[:, :m, m:]
    if reach.size:
        motion = *motion, (felt.start, P[:, m:, m:].copy())
    return CondensedStretch(K[:, left[:, None], left] - P[:, :m, :m], forces, motion)


def repeat_stretch(stretch: CondensedStretch, repetitions: int, loads: Array) -> CondensedStretch:
    """Join ``repetitions`` equal axial parts of a body in a row into one, by repeated doubling.

    ``loads`` ``(h, m, j)``: unit loads on each grid line between two stretches.
    """
    if repetitions == 1:
        return stretch
    half = repeat_stretch(stretch, repetitions // 2, loads)
    twice = join_stretches(half, half, loads)
    return join_stretches(twice, stretch, loads) if repetitions % 2 else twice


def _grid_line_compliance_by_stretches(
    body: BodyOfRevolution, n: Index, held: Mask, line: int, rows: tuple[int, int], springs: Sequence[float]
) -> list[OverlappingBlockMatrix]:
    """Return the result of `grid_line_compliance` for some harmonics, by joining radial rows of elements one after another.

    ``n``: numbers of the harmonics, either 0, or 1, or numbers above 1. Equal rows in succession are joined by doubling.
    The other arguments are those of `grid_line_compliance`.
    """
    count, width = body.grid.shape[0], 3 * body.grid.shape[1]
    factors = [(i, circumference_integral_factor(i)) for i in n.tolist()]
    powers = np.array([[c, c * i, c * i * i] for i, c in factors])
    free = np.array([~held & body.freedoms_regular_on_axis(i) for i in n.tolist()]).reshape(n.size, count, width)
    unit = np.zeros((width, 3))
    unit[3 * line + np.arange(3), np.arange(3)] = 1.0

    def unit_loads_on_line(i: int) -> Array:
        """Return the unit loads on grid line i in all harmonics, none if the line is not loaded."""
        return (free[:, i, :, None] * unit)[:, :, : 3 if rows[0] <= i < rows[1] else 0]

    def row_stretch(k: int) -> CondensedStretch:
        """Return the radial row k of elements as a condensed axial part, without its middle grid line."""
        moves, parts = free[:, 2 * k : 2 * k + 3].reshape(n.size, -1), body.stiffness_of_rows(np.array([k]))
        K = np.tensordot(powers, parts.reshape(3, 3 * width, -1), 1) * moves[:, :, None] * moves[:, None]
        K[:, np.arange(3 * width), np.arange(3 * width)] += np.where(moves, 0.0, np.abs(K).max())
        middle = unit_loads_on_line(2 * k + 1)
        forces = np.pad(middle, ((0, 0), (width, width), (0, 0)))
        return eliminate_freedoms(CondensedStretch(K, forces), slice(width, 2 * width))

    def end_stretch(springs: Array | float) -> CondensedStretch:
        """Return an axial part without material at an end of the body, with springs on its one grid line."""
        return CondensedStretch(np.zeros((n.size, width, width)) + springs, np.zeros((n.size, width, 0)))

    pattern = [(free[:, 2 * k : 2 * k + 3].tobytes(), rows[0] <= 2 * k + 1 < rows[1]) for k in range(count // 2)]
    alike = body.equals_previous_row
    starts = [k for k in range(count // 2) if not alike[k] or pattern[k] != pattern[k - 1]]
    stretches = [
        repeat_stretch(row_stretch(k), after - k, unit_loads_on_line(2 * k + 2))
        for k, after in pairwise([*starts, count // 2])
    ]
    between, soft = [*(unit_loads_on_line(2 * k) for k in starts), unit_loads_on_line(count - 1)], 0.0
    if springs and n[0] < 2:
        motions = mean_rigid_motion_matrix(body.grid.r[0], int(n[0]))
        low = motions * free[0, 0]
        soft = low.T @ (np.array(springs[2:] if n[0] == 0 else springs[:2])[:, None] * low)
        between[-1] = np.concatenate([between[-1], (motions * free[0, -1]).T[None]], axis=2)
    stretches = [end_stretch(soft), *stretches, end_stretch(0.0)]
    while between:  # join the neighbours with the fewest loads first
        counts = [s.end_forces.shape[2] for s in stretches]
        i = min(range(len(between)), key=lambda i: counts[i] + counts[i + 1])
        stretches[i : i + 2] = [join_stretches(stretches[i], stretches[i + 1], between.pop(i))]
    size, blocks = stretches[0].end_forces.shape[2], stretches[0].inner_compliance
    return [OverlappingBlockMatrix(size, tuple((first, block[i]) for first, block in blocks)) for i in range(n.size)]
