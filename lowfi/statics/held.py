"""Motions of a screw that nothing resists, and whether its contacts can carry a load at all.

Motions that neither a support nor a contact resists are found before anything is solved. Whether a load can be carried is
decided by a linear program on compressive contact forces.

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
    """Rigid motions of the screw that nothing resists."""

    #: Whether the loads drive one, so that there is no equilibrium.
    driven: bool
    #: Description of the motion.
    text: str
    #: Freedoms of the first node to fix.
    pins: tuple[int, ...] = ()
    #: Whether the track has no lead, so that no contact force twists the shaft, and no moment about the axis acts.
    no_torsion: bool = False
    #: Freedoms that could be fixed instead of the pins; empty where there are none.
    others: tuple[int, ...] = ()


def _free_rigid(problem: Problem) -> tuple[Array, Array, Array]:
    """Return rigid motions ``(6, k)`` of the first node that supports leave, the balls' motions, and the loads' work.

    The motion of the screw at each ball's centre represents its flanks: there the motion along the helix is exactly
    free, while the planar sections of the model would resist it by a false sin(alpha) (R_p - R_contact).
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
    """Return whether loads do work on any of some motions of size one.

    Parameters
    ----------
    work
        Of the loads on the motions [N].
    load
        The loads ``(n, 6)`` [N, N m].
    arm
        Length that makes rotations comparable [m].
    """
    total = float(np.abs(load[:, :3]).sum() + np.abs(load[:, 3:]).sum() / arm)
    return float(np.abs(work).max()) > 1e-9 * total > 0.0


def free_motions(problem: Problem) -> Mechanism:
    """Return the motions of the screw that no contact and no support resists, and whether the loads drive them.

    Parameters
    ----------
    problem
        The static problem.
    """
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
    """Return alternative freedoms that fix all free motions ``(6, k)``; empty where there are none."""
    scaled = free * np.array([1.0, 1.0, 1.0, arm, arm, arm])[:, None]
    rest = [k for k in range(6) if k not in pins]
    others = tuple(rest[k] for k in pivots(scaled[rest].T))
    sizes = np.linalg.svd(scaled[list(others)], compute_uv=False)
    return others if len(others) == len(pins) and sizes[-1] > 1e-6 * np.abs(scaled).max() else ()


def _name(free: Array, lead: float, arm: float) -> str:
    """Return a description of the free motion of the section at the nut's centre, ``(6, k)``."""
    scaled = np.abs(free * np.array([1.0, 1.0, 1.0, arm, arm, arm])[:, None]).max(axis=1)
    if free.shape[1] == 1 and scaled[:2].max() + scaled[3:5].max() < 1e-6 * scaled.max():
        return "screw motion along the helix" if lead > 0.0 else "rotation about the screw's axis"
    parts = [name for name, size in zip(FREEDOMS, scaled, strict=True) if size > 1e-6 * scaled.max()]
    return "rigid motion in " + ", ".join(parts) + " at the nut's centre"


#: Work of the load along the opening motion, of size one, over that of the whole load, from which on it is a proof.
PROVEN = 1e-7


def opening_motion(problem: Problem) -> Array | None:
    """Return a rigid motion of the screw that opens all contacts while the load does work.

    Contacts at their nominal angles; a linear program.

    Returns
    -------
    Array | None
        ``(6,)`` [m] about the nut's centre, rotations times the pitch radius; None where compressive forces balance the
        load.

    Raises
    ------
    ArithmeticError
        The linear program finds neither.
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
    """Return how the contacts on one flank of N balls approach by motions of the flank and of the balls.

    Parameters
    ----------
    side
        The flank.
    angle
        Contact angle [rad].
    flank
        Motions of the flank along x3 and z3, ``(N, 2, k)``.
    first
        Number of the set's first ball among all.
    balls
        Number of balls of all sets.

    Returns
    -------
    Array
        ``(N, k + 2 balls)``.
    """
    N, direction = len(flank), SIGNS[side] * np.array([np.cos(angle), np.sin(angle)])
    centres = np.zeros((N, balls, 2))
    centres[np.arange(N), first + np.arange(N)] = direction
    return np.concatenate([-np.einsum("a,nak->nk", direction, flank), centres.reshape(N, -1)], axis=1)


def opening(work: Array, approach: Any, held: Array) -> Array | None:
    """Return motions by which loads do work while no contact approaches and no fixed freedom moves.

    Parameters
    ----------
    work
        Of the loads on the k motions ``(k,)``.
    approach
        Of all contacts by these motions and by the balls' centres: a matrix, dense or sparse.
    held
        Rows of the fixed freedoms ``(h, k)``.

    Returns
    -------
    Array | None
        ``(k,)``, each at most one; None where compressive forces balance the loads.

    Raises
    ------
    ArithmeticError
        The linear program finds neither.
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
    """Return the status of a body that moved without limit: "not held" only where a linear program proves it.

    Parameters
    ----------
    motion
        Returns a motion that opens the body's contacts, or None.
    body
        Name of the body.
    opens
        Returns the text for that motion.
    """
    try:
        opened = motion()
    except ArithmeticError as error:
        why = f"{body} ran away, and whether its contacts can hold it is not known: {error}"
        return Status("not converged", why)
    if opened is not None:
        return Status("not held", opens(opened))
    why = f"{body} ran away, though contact forces that push can balance the loads (linear program)"
    return Status("not converged", why)


def describe_motion(motion: Array) -> str:
    """Return a description of an opening motion: its freedoms in order of size."""
    order = np.argsort(-np.abs(motion))
    named = [f"{FREEDOMS[k]} {motion[k] / np.abs(motion).max():+.2g}" for k in order if abs(motion[k]) > 1e-3]
    return ", ".join(named)
