"""What holds a screw: motions that neither a support nor a contact resists, found before anything is solved, and whether a
load can be carried at all, by a linear program on contact forces that push.

By the theorem of the alternative (Farkas) either compressive forces at the nominal contacts and reactions of the supports
balance the load, or a rigid motion of the screw, with some motion of the balls, opens every contact or leaves it unchanged
while the load does work. Only the second proves that a screw is not held.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from rollbench.lowfi.statics.problem import SIGNS, Problem, wrench_rows
from rollbench.lowfi.statics.result import Status
from rollbench.lowfi.statics.shape import pivots, rigid_transport, unresisted
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import nominal_contact_points
from rollbench.meshes.parts import FREEDOMS


@dataclass(frozen=True)
class Mechanism:
    """What is free: ``driven`` by the loads (no equilibrium exists) or not; freedoms of the first node to hold.

    no_torsion: the track has no lead, so no contact force twists the shaft, and no moment is applied about it; others:
    freedoms that could be held instead of the pins (none where only those do).
    """

    driven: bool
    text: str
    pins: tuple[int, ...] = ()
    no_torsion: bool = False
    others: tuple[int, ...] = ()


def _free_rigid(problem: Problem) -> tuple[Array, Array, Array]:
    """Rigid motions ``(6, k)`` that supports leave (of the first node), the balls' motions, and the loads' work.

    The motion of the screw at each ball's centre stands for its flanks: there the motion along the helix is exactly
    free, while the planar sections of the model would hold it by a false sin(alpha) (R_p - R_contact).
    """
    arm = problem.scene.track.pitch_radius
    scale = np.array([1.0, 1.0, 1.0, 1.0 / arm, 1.0 / arm, 1.0 / arm])
    z = problem.nodes
    transport = rigid_transport(z - z[0])
    if problem.basis is not None:
        motions = problem.basis[:, ~problem.fixed[0]]
        work = problem.load[0, ~problem.fixed[0]]
    else:
        motions = scale[:, None] * unresisted(transport[problem.fixed] * scale).T
        work = np.einsum("nij,ni->j", transport, problem.load) @ motions
    layout = problem.layout
    r = layout.centre - np.array([0.0, 0.0, z[0]])
    rows = wrench_rows(layout, r)
    return motions, (rows @ motions).reshape(2 * len(r), motions.shape[1]), work


def drives(work: Array, load: Array, arm: float) -> bool:
    """Whether loads ``(n, 6)`` [N, N m] do work [N] on any of some motions of size one, rotations times the arm [m]."""
    total = float(np.abs(load[:, :3]).sum() + np.abs(load[:, 3:]).sum() / arm)
    return float(np.abs(work).max()) > 1e-9 * total > 0.0


def free_motions(problem: Problem) -> Mechanism:
    """Whether the screw can move without closing or sliding any contact, and whether the loads drive that motion."""
    track = problem.scene.track
    twist = float(np.abs(problem.load[:, 5]).sum()) if problem.basis is None else 0.0
    no_torsion = track.lead == 0.0 and twist == 0.0 and problem.nodes.size > 1
    motions, flanks, work = _free_rigid(problem)
    if motions.shape[1] == 0:
        return Mechanism(False, "", (), no_torsion)
    null = unresisted(flanks)
    if null.shape[0] == 0:
        return Mechanism(False, "", (), no_torsion)
    free = motions @ null.T
    seen = rigid_transport(problem.scene.nut.position - float(problem.nodes[0])) @ free
    text = _name(seen, track.lead, track.pitch_radius)
    if drives(null @ work, problem.load, track.pitch_radius):
        return Mechanism(True, f"{text}: no support and no contact resists it, and the loads drive it")
    if problem.basis is not None:  # freedoms are the columns of the basis that the supports leave
        left = np.flatnonzero(~problem.fixed[0])
        pins = tuple(int(left[k]) for k in pivots(null))
    else:
        pins = tuple(pivots(free.T))
    return Mechanism(
        False, text, pins, no_torsion, _others(free, pins, track.pitch_radius) if problem.basis is None else ()
    )


def _others(free: Array, pins: tuple[int, ...], arm: float) -> tuple[int, ...]:
    """Freedoms besides the pins that hold all free motions ``(6, k)`` as well; none where there are no such."""
    scaled = free * np.array([1.0, 1.0, 1.0, arm, arm, arm])[:, None]
    rest = [k for k in range(6) if k not in pins]
    others = tuple(rest[k] for k in pivots(scaled[rest].T))
    sizes = np.linalg.svd(scaled[list(others)], compute_uv=False)
    return others if len(others) == len(pins) and sizes[-1] > 1e-6 * np.abs(scaled).max() else ()


def _name(free: Array, lead: float, arm: float) -> str:
    """Words for the free motion of the section at the nut's centre, ``(6, k)``."""
    scaled = np.abs(free * np.array([1.0, 1.0, 1.0, arm, arm, arm])[:, None]).max(axis=1)
    if free.shape[1] == 1 and scaled[:2].max() + scaled[3:5].max() < 1e-6 * scaled.max():
        return "screw motion along the helix" if lead > 0.0 else "rotation about the screw's axis"
    parts = [name for name, size in zip(FREEDOMS, scaled, strict=True) if size > 1e-6 * scaled.max()]
    return "rigid motion in " + ", ".join(parts) + " at the nut's centre"


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
