"""Kernels of finite bodies (`hifi.rolling.regular`) from finite elements: a ball, and grooved bars.

A body's answers to smooth tractions on its contact zone, in all three directions, less those of a half space meshed
alike and solved with the same elements: what the grid does to the singular part is in both. The ball is free, its loads
balanced by a rigid field of body forces; a bar is held at its back; the half space's cut moves as Boussinesq's and
Cerruti's point forces move it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from skfem import Basis, ElementVector

from hifi import assembly
from hifi.block import boussinesq
from hifi.bodies import isostatic
from hifi.forms import elasticity, force
from hifi.hertz import hertz
from hifi.pressures import contact_weights, mean_weights
from hifi.response import compliance
from hifi.rigid import rigid_modes
from hifi.rolling.regular import Regular, monomials
from hifi.solvers import factor
from meshes.contact_bodies import ContactBody, Groove, Zone, grooved_bar, half_space, whole_ball
from meshes.fem import freedoms_on, nodes_on, points_of

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Sizes:
    """Numerical choices: cells of the contact zone along and across, ratio of cells beyond it, zone over the contact's
    semi-axes, degree of the kernel; size of the bars over the ball's radius, half of the grooves' opening [rad]."""

    cells: tuple[int, int] = (4, 4)
    growth: float = 2.5
    margin: float = 1.1
    degree: int = 4
    bar: float = 5.0
    opening: float = 1.4


def cerruti(points: Array, sources: Array, shear: float, poisson: float) -> Array:
    """Displacements ``(n, 3, m)`` [m/N] at points ``(n, 3)`` [m] under a unit force along x on the half space z > 0.

    Johnson, Contact Mechanics (1985), (3.75); sources ``(m, 2)`` [m] lie on z = 0. The displacement is infinite there.
    """
    x, y = np.moveaxis(points[:, None, :2] - sources, 2, 0)
    z = points[:, 2, None]
    r = np.sqrt(x**2 + y**2 + z**2)
    k, s = 1.0 - 2.0 * poisson, r * (r + z)
    parts = [
        1.0 / r + x**2 / r**3 + k * (1.0 / (r + z) - x**2 / (s * (r + z))),
        x * y / r**3 - k * x * y / (s * (r + z)),
        x * z / r**3 + k * x / s,
    ]
    return np.stack(parts, axis=1) / (4.0 * np.pi * shear)


def tractions(body: ContactBody, zone: Zone, degree: int, bends: tuple[float, float]) -> sp.csr_matrix:
    """Loads ``(3 k, 3 n)``: nodal forces of smooth tractions along x, y and into the body, in axes that follow the surface.

    Their work on a motion is the motion's coefficient of each monomial, by least squares over the zone's area. bends:
    curvatures [1/m] along x and y of the surface that ball and groove share, positive towards the ball.
    """
    at = points_of(body.mesh)[body.contact, :2]
    c = len(at)
    hats = contact_weights(body.mesh, body.contact)
    root = np.sqrt(np.asarray(hats.sum(axis=1)))
    fit = np.linalg.pinv(root * monomials(at, zone.half, degree)) @ (root * mean_weights(hats).toarray())
    tilt = -body.sense * at * np.array(bends)  # rise of the surface into the body, per length
    frames = np.zeros((c, 3, 3))  # rows: local x, y, inward
    frames[:, 0, 0] = frames[:, 1, 1] = frames[:, 2, 2] = 1.0
    frames[:, :2, 2], frames[:, 2, :2] = tilt, -tilt
    frames /= np.linalg.norm(frames, axis=2, keepdims=True)
    k = len(fit)
    nodal = np.einsum("kc,cdx->dkcx", fit, frames).reshape(3 * k, 3 * c)
    columns = (3 * body.contact[:, None] + np.arange(3)).ravel()
    spread = sp.csr_matrix((np.ones(3 * c), (np.arange(3 * c), columns)), (3 * c, body.mesh.doflocs.size))
    return sp.csr_matrix(sp.csr_matrix(nodal) @ spread)


def free_answer(body: ContactBody, rows: sp.csr_matrix, young: float, poisson: float) -> Array:
    """Answers ``(m, m)`` [m/N] of a free body, loads and motions freed of what moves it as a whole."""
    K = assembly.assemble(elasticity(young, poisson), body.mesh)
    points = points_of(body.mesh)
    held = isostatic(points, body.contact)
    V = Basis(
        body.mesh, ElementVector(body.mesh.elem()), assembly.CurvedMap(body.mesh), quadrature=assembly.rule(body.mesh)
    )
    rigid = rigid_modes(points)

    def density(k: int) -> Array:
        def field(x: Array) -> Array:
            flat = np.asarray(x).reshape(3, -1).T
            return np.asarray(rigid_modes(flat)[:, k].reshape(-1, 3).T.reshape(np.shape(x)))

        return np.asarray(force(field).assemble(V))

    relief = np.array([density(k) for k in range(6)])
    free = np.setdiff1d(np.arange(K.shape[0]), held)
    every = sp.vstack([rows, sp.csr_matrix(relief)]).tocsr()[:, free]
    F = compliance(K[free][:, free].tocsc(), every)
    S = np.hstack([np.eye(rows.shape[0]), -np.linalg.solve(relief @ rigid, (rows @ rigid).T).T])
    return np.asarray(S @ F @ S.T)


def held_answer(body: ContactBody, rows: sp.csr_matrix, young: float, poisson: float) -> Array:
    """Answers ``(m, m)`` [m/N] of a body held at its boundary "held"."""
    K = assembly.assemble(elasticity(young, poisson), body.mesh)
    free = np.setdiff1d(np.arange(K.shape[0]), freedoms_on(body.mesh, "held"))
    return compliance(K[free][:, free].tocsc(), rows[:, free])


def half_space_answer(body: ContactBody, rows: sp.csr_matrix, young: float, poisson: float) -> Array:
    """Answers ``(m, m)`` [m/N] of a block of a half space, the rest of it in the motion of its cut (`hifi.block`)."""
    K = sp.csr_matrix(assembly.assemble(elasticity(young, poisson), body.mesh))
    cut = freedoms_on(body.mesh, "held")
    free = np.setdiff1d(np.arange(K.shape[0]), cut)
    P = rows[:, free].toarray().T
    u = factor(K[free][:, free].tocsc()).solve(P)
    far = _far_field(body, rows, young, poisson)
    out = P.T @ u - (K[cut][:, free] @ u).T @ far
    return np.asarray(0.5 * (out + out.T))


def _far_field(body: ContactBody, rows: sp.csr_matrix, young: float, poisson: float) -> Array:
    """Motion ``(3 cut nodes, m)`` [m/N] of the cut under the loads ``rows`` on the zone's nodes."""
    points = points_of(body.mesh)
    cut, sources = points[nodes_on(body.mesh, "held")], points[body.contact, :2]
    shear = 0.5 * young / (1.0 + poisson)
    along = cerruti(cut, sources, shear, poisson)
    turned = cerruti(cut[:, [1, 0, 2]], sources[:, ::-1], shear, poisson)[:, [1, 0, 2]]
    down = boussinesq(cut, sources, young, poisson)
    out = np.zeros((3 * len(cut), rows.shape[0]))
    for axis, motion in enumerate((along, turned, down)):
        out += motion.reshape(3 * len(cut), -1) @ rows[:, 3 * body.contact + axis].toarray().T
    return out


@lru_cache(maxsize=8)
def half_space_kernel(zone: Zone, size: float, young: float, poisson: float, degree: int) -> Array:
    """Answers of a half space on a zone, ``(3 k, 3 k)`` [m/N]."""
    body = half_space(size, zone)
    return half_space_answer(body, tractions(body, zone, degree, (0.0, 0.0)), young, poisson)


@lru_cache(maxsize=8)
def ball_kernel(
    radius: float, zone: Zone, bends: tuple[float, float], young: float, poisson: float, degree: int
) -> Regular:
    """What a whole ball of ``radius`` [m] adds to a half space."""
    body = whole_ball(radius, zone)
    found = free_answer(body, tractions(body, zone, degree, bends), young, poisson)
    return Regular(found - half_space_kernel(zone, radius, young, poisson, degree), zone.half, degree)


@lru_cache(maxsize=8)
def bar_kernel(
    groove: Groove, size: float, zone: Zone, bends: tuple[float, float], young: float, poisson: float, degree: int
) -> Regular:
    """What a grooved bar of ``size`` [m] adds to a half space, as it counts in the motion of a ball past it."""
    body = grooved_bar(groove, size, zone)
    found = held_answer(body, tractions(body, zone, degree, bends), young, poisson)
    M = found - half_space_kernel(zone, groove.ball, young, poisson, degree)
    signs = np.repeat([-1.0, -1.0, 1.0], len(M) // 3)
    return Regular(M * np.outer(signs, signs), zone.half, degree)


#: Zones are made for loads of whole powers of two, and grooves for whole tenths of a radian, so that like contacts share
#: their kernel.
STEP = 0.1


@lru_cache(maxsize=8)
def _kernel(
    radius: float, radii: tuple[float, float], angle: float, load: float, young: float, poisson: float, sizes: Sizes
) -> Regular:
    found = hertz(load, *radii, young, poisson)
    zone = Zone((sizes.margin * found.semi_x, sizes.margin * found.semi_y), sizes.cells, sizes.growth)
    bends = (1.0 / radius - 0.5 / radii[0], 1.0 / radius - 0.5 / radii[1])
    groove = Groove(radius, 1.0 / (1.0 / radius - 1.0 / radii[1]), angle, sizes.opening, 1.0 / radius - 1.0 / radii[0])
    bar = bar_kernel(groove, sizes.bar * radius, zone, bends, young, poisson, sizes.degree)
    return ball_kernel(radius, zone, bends, young, poisson, sizes.degree) + bar


def contact_kernel(
    radius: float, radii: tuple[float, float], angle: float, load: float, young: float, poisson: float, sizes: Sizes
) -> Regular:
    """What a ball and a grooved bar add to half spaces, y towards the bottom of the groove.

    radius: the ball's [m]; radii: relative ones along and across [m]; angle: from the groove's bottom to the contact [rad];
    load: the largest of the contacts that share it [N]. Other contacts of the ball are not felt. Raises ValueError where
    groove or ring have no room for the bar.
    """
    shared = float(2.0 ** np.ceil(np.log2(load)))
    return _kernel(radius, radii, STEP * round(angle / STEP), shared, young, poisson, sizes)
