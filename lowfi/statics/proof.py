"""Whether a load can be carried at all: contact forces that push, with the supports, against a linear program.

By the theorem of the alternative (Farkas) either compressive forces at the nominal contacts and reactions of the supports
balance the load, or a rigid motion of the screw, with some motion of the balls, opens every contact or leaves it unchanged
while the load does work. Only the second proves that a screw is not held.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from rollbench.lowfi.statics.problem import SIGNS, Problem
from rollbench.lowfi.statics.result import Status
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
    scene, layout = problem.scene, problem.layout
    arm, z0 = scene.track.pitch_radius, scene.nut.position
    scale = np.array([1.0, 1.0, 1.0, 1.0 / arm, 1.0 / arm, 1.0 / arm])
    N, point = layout.z.size, nominal_contact_points(scene)
    axes = np.stack([layout.radial, layout.binormal], axis=1)
    flank = np.zeros((4, N, 2, 6))
    for s in range(2):
        x = layout.centre + point[s, 0] * layout.radial + point[s, 1] * layout.binormal - np.array([0.0, 0.0, z0])
        flank[s] = np.concatenate([axes, np.cross(x[:, None], axes)], axis=2) * scale
    sides = [approach(s, scene.track.contact_angle, flank[s], 0, N) for s in range(4)]
    rows = np.stack(sides, axis=1).reshape(4 * N, -1)
    work = np.zeros(6)
    held: list[Array] = []
    for load in scene.loads:
        work += scale * (rigid_transport(load.at - z0).T @ np.concatenate([load.force, load.moment]))
    for support in scene.supports:
        transport = rigid_transport(support.at - z0) * scale
        held += [transport[FREEDOMS.index(name)] for name, _ in support.fixed]
    return None if not work.any() else opening(work, rows, np.array(held).reshape(-1, 6))


def approach(side: int, angle: float, flank: Array, first: int, balls: int) -> Array:
    """How the contacts on one side of N balls, at an angle [rad], approach ``(N, k + 2 balls)``.

    By motions ``(N, 2, k)`` of the flank along x3 and z3, and by those of the centres of all ``balls``, of which they are
    from ``first`` on.
    """
    N, direction = len(flank), SIGNS[side] * np.array([np.cos(angle), np.sin(angle)])
    centres = np.zeros((N, balls, 2))
    centres[np.arange(N), first + np.arange(N)] = direction
    return np.concatenate([-np.einsum("a,nak->nk", direction, flank), centres.reshape(N, -1)], axis=1)


def opening(work: Array, approach: Any, held: Array) -> Array | None:
    """Motions ``(k,)`` up to one by which loads do ``work`` ``(k,)`` while no contact's approach grows and nothing moves
    what is ``held`` ``(h, k)``; None where compressive forces balance the loads.

    approach: of all contacts by these motions and by the balls' centres, a matrix, dense or sparse. Raises
    ArithmeticError where the linear program finds neither.
    """
    from scipy.optimize import linprog
    from scipy.sparse import csr_array, hstack

    k, (contacts, wide) = work.size, approach.shape
    centres = wide - k
    found = linprog(
        np.concatenate([-work / np.abs(work).max(), np.zeros(centres)]),
        A_ub=approach,
        b_ub=np.zeros(contacts),
        A_eq=hstack([csr_array(held), csr_array((len(held), centres))]) if len(held) else None,
        b_eq=np.zeros(len(held)) if len(held) else None,
        bounds=[(-1.0, 1.0)] * k + [(None, None)] * centres,
    )
    if found.status != 0:
        raise ArithmeticError(f"no linear program of the contacts: {found.message}")
    return None if -found.fun <= PROVEN else np.asarray(found.x[:k])


def ran_away(motion: Callable[[], Array | None], body: str, opens: Callable[[Array], str]) -> Status:
    """Status sentence of a body that ran away: not held only where a linear program finds a ``motion`` that opens its
    contacts; opens: words for that motion."""
    try:
        opened = motion()
    except ArithmeticError as error:
        why = f"{body} ran away, and whether its contacts can hold it is not known: {error}"
        return Status("not converged", why)
    if opened is not None:
        return Status("not held", opens(opened))
    why = f"{body} ran away, though contact forces that push can balance the loads (linear program)"
    return Status("not converged", why)


def words_of(motion: Array) -> str:
    """Words for an opening motion of ``opening_motion``: its freedoms in order of size."""
    order = np.argsort(-np.abs(motion))
    named = [f"{FREEDOMS[k]} {motion[k] / np.abs(motion).max():+.2g}" for k in order if abs(motion[k]) > 1e-3]
    return ", ".join(named)
