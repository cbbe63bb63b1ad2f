"""Whether a load can be carried at all: contact forces that push, with the supports, against a linear program.

By the theorem of the alternative (Farkas) either compressive forces at the nominal contacts and reactions of the supports
balance the load, or a rigid motion of the screw, with some motion of the balls, opens every contact or leaves it unchanged
while the load does work. Only the second proves that a screw is not held.
"""

from __future__ import annotations

import numpy as np

from rollbench.lowfi.statics.problem import SIGNS, Problem
from rollbench.lowfi.statics.shape import rigid_transport
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import nominal_contact_points
from rollbench.meshes.parts import FREEDOMS

#: Work of the load along the opening motion, of size one, over that of the whole load, from which on it is a proof.
PROVEN = 1e-7


def opening_motion(problem: Problem) -> Array | None:
    """Rigid motion ``(6,)`` of the screw about the nut's centre (rotations times the pitch radius) [m] that opens all
    contacts at their nominal angles while the load does work; None where compressive forces balance the load.

    Raises ArithmeticError where the linear program finds neither.
    """
    from scipy.optimize import linprog

    scene, layout = problem.scene, problem.layout
    arm, z0 = scene.track.pitch_radius, scene.nut.position
    scale = np.array([1.0, 1.0, 1.0, 1.0 / arm, 1.0 / arm, 1.0 / arm])
    N = layout.z.size
    beta = scene.track.contact_angle
    direction = SIGNS * np.array([np.cos(beta), np.sin(beta)])
    point = nominal_contact_points(scene)
    axes = np.stack([layout.radial, layout.binormal], axis=1)
    # unknowns: the screw's motion (6) and those of the balls (2 N); every contact's approach must not grow
    rows = np.zeros((4 * N, 6 + 2 * N))
    for s in range(4):
        normal = np.einsum("a,nak->nk", direction[s], axes)
        own = np.arange(N)
        rows[4 * own + s, 6 + 2 * own] = direction[s, 0]
        rows[4 * own + s, 7 + 2 * own] = direction[s, 1]
        if s < 2:
            x = layout.centre + point[s, 0] * layout.radial + point[s, 1] * layout.binormal - np.array([0.0, 0.0, z0])
            rows[4 * own + s, :6] = -np.concatenate([normal, np.cross(x, normal)], axis=1) * scale
    work = np.zeros(6 + 2 * N)
    held: list[Array] = []
    for load in scene.loads:
        work[:6] += scale * (rigid_transport(load.at - z0).T @ np.concatenate([load.force, load.moment]))
    for support in scene.supports:
        transport = rigid_transport(support.at - z0) * scale
        held += [transport[FREEDOMS.index(name)] for name, _ in support.fixed]
    size = float(np.abs(work).max())
    if size == 0.0:
        return None
    equal = np.concatenate([np.array(held).reshape(-1, 6), np.zeros((len(held), 2 * N))], axis=1) if held else None
    bounds = [(-1.0, 1.0)] * 6 + [(None, None)] * (2 * N)
    found = linprog(-work / size, A_ub=rows, b_ub=np.zeros(4 * N), A_eq=equal, b_eq=np.zeros(len(held)), bounds=bounds)
    if found.status != 0:
        raise ArithmeticError(f"no linear program of the contacts: {found.message}")
    return None if -found.fun <= PROVEN else np.asarray(found.x[:6])


def words_of(motion: Array) -> str:
    """Words for an opening motion of ``opening_motion``: its freedoms in order of size."""
    order = np.argsort(-np.abs(motion))
    named = [f"{FREEDOMS[k]} {motion[k] / np.abs(motion).max():+.2g}" for k in order if abs(motion[k]) > 1e-3]
    return ", ".join(named)
