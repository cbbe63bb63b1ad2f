"""Answers of meshed bodies to smooth tractions on their contact zone, in three directions, and those of a half space meshed
alike.

A body is free, its loads balanced by a rigid field of body forces, or held at its boundary "held"; the cut of a half
space's block moves as Boussinesq's and Cerruti's point forces move it.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import scipy.sparse as sp

from rollbench.hifi.bodies.coarse import isostatic, rigid_loads
from rollbench.hifi.contact.block import boussinesq
from rollbench.hifi.elements import assembly
from rollbench.hifi.elements.forms import elasticity
from rollbench.hifi.elements.pressures import contact_weights, mean_weights
from rollbench.hifi.elements.rigid import rigid_modes
from rollbench.hifi.linear_algebra.solvers import compliance
from rollbench.hifi.rolling.contact_bodies import ContactBody, Zone, half_space
from rollbench.hifi.rolling.regular import monomials
from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.fem import freedoms_on, moved, nodes_on, points_of


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


@dataclass(frozen=True)
class Frame:
    """Where a body's mesh has the contact's axes: a point of the normal through the contact's middle ``(3,)`` [m], and rows
    along x, y and into the body ``(3, 3)``."""

    centre: Array = field(default_factory=lambda: np.zeros(3))
    axes: Array = field(default_factory=lambda: np.eye(3))


def in_frame(body: ContactBody, frame: Frame) -> Array:
    """Nodes of the contact zone along x and y ``(c, 2)`` [m]."""
    return np.asarray(((points_of(body.mesh)[body.contact] - frame.centre) @ frame.axes.T)[:, :2])


def tractions(
    body: ContactBody, zone: Zone, degree: int, bends: tuple[float, float], frame: Frame | None = None
) -> sp.csr_array:
    """Loads ``(3 k, 3 n)``: nodal forces of smooth tractions along x, y and into the body, in axes that follow the surface.

    Their work on a motion is the motion's coefficient of each monomial, by least squares over the zone's area. bends:
    curvatures [1/m] along x and y of the surface that ball and groove share, positive towards the ball; frame: of the
    mesh, the contact's own unless given.
    """
    frame = frame or Frame()
    at = in_frame(body, frame)
    c = len(at)
    hats = contact_weights(body.mesh, body.contact)
    root = np.sqrt(np.asarray(hats.sum(axis=1))[:, None])
    fit = np.linalg.pinv(root * monomials(at, zone.half, degree)) @ (root * mean_weights(hats).toarray())
    tilt = -body.sense * at * np.array(bends)  # rise of the surface into the body, per length
    frames = np.zeros((c, 3, 3))  # rows: local x, y, inward
    frames[:, 0, 0] = frames[:, 1, 1] = frames[:, 2, 2] = 1.0
    frames[:, :2, 2], frames[:, 2, :2] = tilt, -tilt
    frames /= np.linalg.norm(frames, axis=2, keepdims=True)
    k = len(fit)
    nodal = np.einsum("kc,cdx->dkcx", fit, frames @ frame.axes).reshape(3 * k, 3 * c)
    columns = (3 * body.contact[:, None] + np.arange(3)).ravel()
    spread = sp.csr_array((np.ones(3 * c), (np.arange(3 * c), columns)), (3 * c, body.mesh.doflocs.size))
    return sp.csr_array(sp.csr_array(nodal) @ spread)


def free_answer(body: ContactBody, rows: sp.csr_array, young: float, poisson: float) -> Array:
    """Answers ``(m, m)`` [m/N] of a free body, loads and motions freed of what moves it as a whole."""
    K, points = assembly.assemble(elasticity(young, poisson), body.mesh), points_of(body.mesh)
    relief, rigid = rigid_loads(body.mesh), rigid_modes(points)
    F = _held(K, isostatic(points, body.contact), sp.vstack([rows, sp.csr_array(relief)]))
    S = np.hstack([np.eye(rows.shape[0]), -np.linalg.solve(relief @ rigid, (rows @ rigid).T).T])
    return np.asarray(S @ F @ S.T)


def _held(K: sp.csr_array, held: Index, rows: sp.sparray) -> Array:
    """Answers ``(m, m)`` [m/N] of a body whose freedoms ``held`` stand."""
    free = np.setdiff1d(np.arange(K.shape[0]), held)
    return compliance(K[free][:, free], rows.tocsr()[:, free])


def held_answer(body: ContactBody, rows: sp.csr_array, young: float, poisson: float) -> Array:
    """Answers ``(m, m)`` [m/N] of a body held at its boundary "held"."""
    return _held(assembly.assemble(elasticity(young, poisson), body.mesh), freedoms_on(body.mesh, "held"), rows)


def half_space_answer(body: ContactBody, rows: sp.csr_array, young: float, poisson: float) -> Array:
    """Answers ``(m, m)`` [m/N] of a block of a half space, the rest of it in the motion of its cut
    (`hifi.contact.block`)."""
    K, cut = assembly.assemble(elasticity(young, poisson), body.mesh), freedoms_on(body.mesh, "held")
    by_cut = sp.csr_array(-(K[cut].T @ _far_field(body, rows, young, poisson)).T)
    F, m = _held(K, cut, sp.vstack([rows, by_cut])), rows.shape[0]
    out = F[:m, :m] + F[:m, m:]
    return np.asarray(0.5 * (out + out.T))


def _far_field(body: ContactBody, rows: sp.csr_array, young: float, poisson: float) -> Array:
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


def beside(
    body: ContactBody,
    zone: Zone,
    size: float,
    young: float,
    poisson: float,
    degree: int,
    frame: Frame | None = None,
    near: tuple[Array, Array, Array] | None = None,
) -> Array:
    """Answers ``(3 k, 3 k)`` [m/N] of a half space whose zone has its nodes where the body's are, seen along the normal.

    A zone that is wider by a share e answers a linear traction by 2 e to 3 e less: what its shape does is then in both
    answers, as far as the half space has it.
    near: cells as in `hifi.rolling.contact_bodies.half_space`.
    """
    block = half_space(size, zone, near)
    cells = np.array(zone.cells)
    off = np.zeros((*(2 * cells + 1), 2))
    off[tuple(body.number.T)] = in_frame(body, frame or Frame()) - np.array(zone.half) * (body.number / cells - 1.0)
    points = points_of(block.mesh).copy()
    points[:, :2] += off[tuple(zone.number(points[:, :2]).T)]
    block = replace(block, mesh=moved(block.mesh, points))
    return half_space_answer(block, tractions(block, zone, degree, (0.0, 0.0)), young, poisson)
