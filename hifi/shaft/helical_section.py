"""Stiffness of a grooved shaft's section, exact but for a plane mesh: the shaft is invariant under the helix of its groove.

With (r, zeta, phi) of `meshes.groove_map`, zeta = z - r_g phi, the geometry does not depend on phi, nor does the strain
that the average stretch and twist of the shaft bring; that of its average curvature goes with exp(i phi). So does what the
section adds to them: u = w(r, zeta) exp(i n phi) in the directions r, phi and z, periodic in zeta with the lead over the
starts, n = 0 or 1, and derivatives around the axis at constant z are d_theta = i n - r_g d_zeta. What is stored at the
minimum over w gives the stiffnesses. (Helically symmetric bodies: Treyssede 2008; the average is that over a lead.)
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu
from skfem import Basis, ElementQuad2, ElementVector, MeshQuad

from rollbench.meshes.arrays import Array
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.parts import Material

#: Strains that averages bring: their component (as of `_strain`), and the power of the radius by which it goes.
STRETCH, TWIST, CURVATURE = (2, 0), (5, 1), (2, 1)
#: Second-order cells along the groove, along the land, and in depth.
CELLS = (32, 12, 12)


def helical_stiffness(
    m: GrooveMap, outer: float, bore: float, material: Material, cells: tuple[int, int, int] = CELLS
) -> tuple[Array, float]:
    """Stiffness ``(2, 2)`` against stretch and twist per length [N, N m; N m2], and bending stiffness [N m2].

    outer, bore: radii of the lands and of the bore [m] (0: solid). Raises ValueError where grooves of neighbouring turns
    overlap, or the bore cuts them.
    """
    mesh, period = _section_mesh(m, outer, bore, cells)
    basis = Basis(mesh, ElementVector(ElementQuad2(), 3), intorder=6)
    stretch_and_twist = _stored(basis, m.rg, 0, material, period, (STRETCH, TWIST)) * 2.0 * np.pi / period
    bending = _stored(basis, m.rg, 1, material, period, (CURVATURE,)) * np.pi / period
    return stretch_and_twist, float(bending[0, 0])


def _section_mesh(m: GrooveMap, outer: float, bore: float, cells: tuple[int, int, int]) -> tuple[MeshQuad, float]:
    """Mesh of (r, zeta) over one period, middle of the groove at zeta = 0, and the period [m]."""
    along, land, deep = cells
    period = 2.0 * np.pi * abs(m.rg) / m.starts
    gamma = np.linspace(0.0, np.pi / 2.0, 4001)
    r, zeta, _ = m.unroll(*m.section(1, gamma, np.full(gamma.size, m.radius[1])))
    kept = (zeta >= 0.0) & (r <= outer)
    r, zeta = r[kept], zeta[kept]
    edge = float(zeta[-1])
    if edge >= 0.5 * period:
        raise ValueError("the grooves of neighbouring turns overlap")
    if bore >= r.min():
        raise ValueError("the bore cuts the groove")
    length = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(r), np.diff(zeta)))])  # even cells along the flank
    at = np.linspace(0.0, length[-1], along // 2 + 1)
    flank, surface = np.interp(at, length, zeta), np.interp(at, length, r)
    flank[0], surface[-1] = 0.0, outer
    flat = np.linspace(edge, 0.5 * period, land // 2 + 1)[1:]
    z, top = np.concatenate([flank, flat]), np.concatenate([surface, np.full(flat.size, outer)])
    z, top = np.concatenate([-z[:0:-1], z]), np.concatenate([top[:0:-1], top])
    depth = 1.0 - np.linspace(1.0, 0.0, deep + 1) ** 1.5  # finer towards the surface
    mesh = MeshQuad.init_tensor(np.arange(depth.size, dtype=float), np.arange(z.size, dtype=float))
    i, j = mesh.p.round().astype(int)
    return mesh.translated(np.stack([bore + depth[i] * (top[j] - bore), z[j]]) - mesh.p[:, :]), period


def _strain(value: Any, slope: Any, r: Array, rg: float, n: int) -> list[Any]:
    """rr, tt, zz, rz, rt, tz (engineering shears) of w with the derivatives along r and zeta."""
    u, v, w = value
    (u_r, u_z), (v_r, v_z), (w_r, w_z) = slope
    turn = 1j * n if n else 0.0
    u_t, v_t, w_t = (turn * f - rg * f_z for f, f_z in ((u, u_z), (v, v_z), (w, w_z)))
    return [u_r, (v_t + u) / r, w_z, u_z + w_r, (u_t - v) / r + v_r, w_t / r + v_z]


def _stored(basis: Basis, rg: float, n: int, material: Material, period: float, means: Sequence[tuple[int, int]]) -> Array:
    """Integrals over the section of what means and what they bring store against one another, ``(k, k)``."""
    e, nu = material.youngs_modulus, material.poissons_ratio
    shear = e / (2.0 * (1.0 + nu))
    hooke = np.diag(shear * np.array([2.0, 2.0, 2.0, 1.0, 1.0, 1.0]))
    hooke[:3, :3] += 2.0 * shear * nu / (1.0 - 2.0 * nu)
    r = np.asarray(basis.global_coordinates()[0])
    weight = np.repeat(r * basis.dx, len(hooke), axis=1)

    def by_cells(strains: list[list[Array]]) -> Array:
        """Strains as ``(cells, functions, points and components)``."""
        values = np.array(strains).transpose(2, 0, 3, 1)
        return np.ascontiguousarray(values).reshape(*values.shape[:2], -1)

    def stress(strains: Array) -> Array:
        """Times the share of every point in the integral, ``(cells, points and components, functions)``."""
        values = (strains.reshape(-1, len(hooke)) @ hooke).reshape(strains.shape)
        return np.asarray((values * weight[:, None]).swapaxes(1, 2))

    B = by_cells([_strain(f[0], f[0].grad, r, rg, n) for f in basis.basis])
    mean = by_cells([[r**power if k == of else 0.0 * r for k in range(6)] for of, power in means])
    nodes, size = basis.element_dofs.T, basis.N
    lines, columns = np.repeat(nodes, nodes.shape[1], axis=1).ravel(), np.tile(nodes, nodes.shape[1]).ravel()
    K = sp.csr_array(((B.conj() @ stress(B)).ravel(), (lines, columns)), (size, size))
    F = np.zeros((size, len(means)), dtype=B.dtype)
    np.add.at(F, nodes, B.conj() @ stress(mean))
    prescribed = (mean @ stress(mean)).sum(axis=0)
    T = _periodic(basis, period)
    # the axis moves as a whole: n = 0 along and around, n = 1 across
    top = int(np.argmax(basis.doflocs[0]))
    point = np.flatnonzero(np.linalg.norm(basis.doflocs - basis.doflocs[:, [top]], axis=0) < 1e-12)
    held = T[point[1:] if n == 0 else point[:1]].nonzero()[1]
    free = np.setdiff1d(np.arange(T.shape[1]), held)
    T = T[:, free]
    answer = splu((T.T @ K @ T).tocsc(), permc_spec="MMD_AT_PLUS_A").solve(T.T @ F)
    return np.asarray((prescribed - np.conj(T.T @ F).T @ answer).real)


def _periodic(basis: Basis, period: float) -> sp.csr_array:
    """Freedoms ``(n, m)`` from those that are left where the two ends of the period are one."""
    x = basis.doflocs
    low, high = (np.flatnonzero(np.abs(x[1] - s * 0.5 * period) < 1e-9 * period) for s in (-1.0, 1.0))
    low, high = (at[np.lexsort((at, x[0, at]))] for at in (low, high))
    master = np.arange(x.shape[1])
    master[high] = low
    left, place = np.unique(master, return_inverse=True)
    return sp.csr_array((np.ones(place.size), (np.arange(place.size), place)), (place.size, left.size))
