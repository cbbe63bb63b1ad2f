"""Loads of balls of a ball screw and their motion with friction and ball-to-ball contact, in agreement (Lin 3.4.1).

Friction and ball-to-ball forces in the plane of the groove's section change the contact loads, and these the friction:
both are solved in turn in accelerated rounds, and as one system where the rounds do not settle.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rollbench.lowfi.friction.contact.rings import Settled
from rollbench.lowfi.friction.screw.chain import Chain, ChainMotion, solve_chain
from rollbench.lowfi.friction.screw.joint import solve_joint
from rollbench.lowfi.friction.screw.load import Cell, settle_load
from rollbench.lowfi.friction.screw.motion import AGREED, ROUNDS, Coupling, Mixer, feedback, hold_screw
from rollbench.meshes.arrays import Array

#: Rounds after which loads and friction are solved as one system.
PATIENCE = 26


@dataclass(frozen=True)
class CoupledChain:
    """Loads and motion of a chain that agree; change: last change of the friction fed back [N].

    bare: the loads without friction, where a held screw stays; rounds of loads and friction; converged: change at most
    ``AGREED`` of the sum of contact forces, loads and motion in balance.
    """

    bare: Settled
    load: Settled
    motion: ChainMotion
    change: float
    rounds: int
    converged: bool


@dataclass(frozen=True)
class Guess:
    """Start of the rounds: push on balls (N, 2) and drag on the screw (m,) [N] as in ``Cell``, and a motion.

    q (N, 4) [rad/s], ball_force (N,) [N] between neighbours; drag counts only where the screw keeps its freedoms.
    """

    push: Array
    drag: Array
    q: Array
    ball_force: Array


def coupled_chain(
    cell: Cell,
    slack: Array,
    coupling: Coupling,
    near: CoupledChain | None = None,
    rounds: int = ROUNDS,
    guess: Guess | None = None,
) -> CoupledChain:
    """Loads and motion of N balls in agreement, ball-to-ball forces included, after at most ``rounds`` rounds.

    slack: see ``Chain``. "ball": the screw stays where it is without friction and ball-to-ball forces (Lin 3.4.1);
    "ball and screw": it keeps balance with them. near: solution of a similar chain to begin from; guess: any forces and
    motion to begin from, in place of near's. Failure is data: see ``converged``.

    Not always unique: a ball that bears no load in ``bare``, or next to none, may float or be wedged between the
    grooves by its own friction. What is found then depends on where the search begins.
    """
    bare = settle_load(cell, None if near is None else (near.bare.ball, near.bare.inner))
    held = hold_screw(cell, bare) if coupling == "ball" else cell
    m = held.rows.shape[2]
    if guess is None:
        guess = _guess(held, coupling, near)
    push, drag, start = guess.push, guess.drag[:m], (guess.q, guess.ball_force)
    place, mixer, count = (bare.ball, bare.inner[:m]), Mixer(), 0
    while True:
        alike = held is cell and np.array_equal(push, cell.push) and np.array_equal(drag, cell.drag)
        load = bare if alike else settle_load(replace(held, push=push, drag=drag), place)
        moved = solve_chain(Chain(cell.groove, load.force, cell.groove.normals(load.angle), slack), start)
        new_push, new_drag = feedback(held, moved.wrench, moved.ball_push[:, [0, 2]], coupling)
        x, g = np.append(push, drag), np.append(new_push, new_drag)
        change, count = float(np.max(np.abs(g - x))), count + 1
        agreed = change <= AGREED * float(np.sum(load.force))
        if agreed or count == rounds:
            return CoupledChain(bare, load, moved, change, count, agreed and load.converged and moved.converged)
        if count == PATIENCE:
            like = None if near is None else (near.load.ball, near.load.inner)
            joint = solve_joint(held, slack, (bare.ball, bare.inner[:m]), like)
            if joint.done:
                push, drag, place = joint.push, joint.drag, (joint.ball, joint.screw)
                start = (joint.q, joint.ball_force)
                continue
        x = mixer.next(x, g)
        push, drag = x[: push.size].reshape(push.shape), x[push.size :]
        # no friction on a ball without load: what the mixer makes of it would push the ball about
        push = np.where(np.any(moved.wrench != 0.0, axis=(1, 2))[:, None], push, new_push)
        place, start = (load.ball, load.inner), (moved.q, moved.ball_force)


def _guess(cell: Cell, coupling: Coupling, near: CoupledChain | None) -> Guess:
    """Forces and motion of a similar chain, or none."""
    n = cell.angle.shape[0]
    if near is None:
        return Guess(cell.push, cell.drag, np.zeros((n, 4)), np.zeros(n))
    push, drag = cell.push, cell.drag
    if coupling != "none":
        push, drag = feedback(cell, near.motion.wrench, near.motion.ball_push[:, [0, 2]], coupling)
    return Guess(push, drag, near.motion.q, near.motion.ball_force)
