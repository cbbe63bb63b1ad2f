"""Motions of the screw that neither a support nor a contact resists, found before anything is solved."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.lowfi.statics.problem import Problem, wrench_rows
from rollbench.lowfi.statics.shape import pivots, rigid_transport, unresisted
from rollbench.meshes.arrays import Array
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
