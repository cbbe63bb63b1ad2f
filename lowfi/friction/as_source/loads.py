"""The source's method for contact loads of balls in a ball screw without friction, kept for comparison: a root.

Unknowns: place of each ball in its groove section (2), its contact angles gamma (4) and the screw's motions. Where the
beam is rigid that is chapter 2's state (Lin 2.11-2.25), searched by the hybrid method.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import root

from rollbench.lowfi.friction.as_source.chain import ACCEPTED
from rollbench.lowfi.friction.contact.motion import HYBRID
from rollbench.lowfi.friction.contact.rings import Settled
from rollbench.lowfi.friction.screw.groove import ON_SCREW, SIGN_X, SIGN_Z
from rollbench.lowfi.friction.screw.load import Cell
from rollbench.meshes.arrays import Array


@dataclass(frozen=True)
class Places:
    """Where N balls are: place (N, 2) along x3, z3 [m], contact angles gamma (N, 4) [rad], screw (m,) [m]."""

    ball: Array
    gamma: Array
    screw: Array


def contact_forces(cell: Cell, at: Places) -> tuple[Array, Array, Array]:
    """Contact forces (N, 4) [N], misalignment n . t (N, 4) of groove and line of centres, normals (N, 4, 2).

    Contact conditions of chapter 2: the groove's tangent at gamma is normal to the line of centres.
    """
    g, c, s = cell.groove, np.cos(at.gamma), np.sin(at.gamma)
    screw = (cell.section @ at.screw + cell.offset)[:, None, :]
    line = g.reach * np.stack([SIGN_X * np.cos(cell.angle), SIGN_Z * np.sin(cell.angle)], axis=-1)
    line = line + at.ball[:, None, :] - np.where(ON_SCREW[:, None], screw, 0.0)
    normal, tangent = np.stack([SIGN_X * c, SIGN_Z * s], axis=-1), np.stack([-SIGN_X * s, SIGN_Z * c], axis=-1)
    approach = np.sum(line * normal, axis=-1) - g.reach + cell.interference
    return (np.maximum(approach, 0.0) / g.constants.C) ** 1.5, np.sum(line * tangent, axis=-1) / g.reach, normal


def load_scale(cell: Cell) -> tuple[float, float]:
    """Force [N] of a ball's share of the load and its approach [m]: what the equations are scaled by."""
    share = max(float(np.linalg.norm(cell.force)) / cell.angle.shape[0], 1e-300)
    return share, float(np.max(cell.groove.constants.C)) * share ** (2.0 / 3.0)


def first_place(cell: Cell) -> Places:
    """Start of the search: screw pressed by four approaches of a ball's share (and the clearance), balls half way.

    The text's nominal state has no stiffness without preload; this is the start that ``rings.settle_cell`` takes.
    """
    total, (_, size) = float(np.linalg.norm(cell.force)), load_scale(cell)
    size += max(0.0, -float(np.min(cell.interference)))
    screw = np.zeros(cell.force.size) if total == 0.0 else 4.0 * size * cell.force / total
    return Places(0.5 * (cell.section @ screw + cell.offset), cell.angle.copy(), screw)


def loads_by_root(cell: Cell, start: Places | None = None) -> Settled:
    """Loads of a cell of N balls as a root of 6 N + m equations; from ``first_place`` where start is None.

    left [N]: largest force out of balance; steps: calls; ``converged`` is False where no root is found.
    """
    n = cell.angle.shape[0]
    scale, size = load_scale(cell)
    at = first_place(cell) if start is None else start

    def split(x: Array) -> Places:
        return Places(x[: 2 * n].reshape(n, 2) * size, x[2 * n : 6 * n].reshape(n, 4), x[6 * n :] * size)

    def residual(x: Array) -> Array:
        force, bent, normal = contact_forces(cell, split(x))
        pull = force[..., None] * normal
        on_screw = np.einsum("nim,ni->m", cell.section, pull[:, ON_SCREW].sum(axis=1)) + cell.force + cell.drag
        return np.concatenate([((cell.push - pull.sum(axis=1)) / scale).ravel(), bent.ravel(), on_screw / (n * scale)])

    x = np.concatenate([(at.ball / size).ravel(), at.gamma.ravel(), at.screw / size])
    solution = root(residual, x, method="hybr", options=HYBRID)
    places = split(solution.x)
    force, _, _ = contact_forces(cell, places)
    left = float(np.max(np.abs(solution.fun))) * scale
    good = left <= ACCEPTED * (scale * n + float(force.sum()))
    return Settled(force, places.gamma, places.ball, places.screw, left, int(solution.nfev), good)
