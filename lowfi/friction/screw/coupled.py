"""Loads of balls of a ball screw and their motion with friction and ball-to-ball contact, in agreement (Lin 3.4.1).

Friction and ball-to-ball forces in the plane of the groove's section change the contact loads, and these the friction:
both are solved in turn in accelerated rounds, and as one system where the rounds do not settle: friction that wedges a ball
between grooves changes the loads by many times as much as it changes itself, so that rounds of loads and friction run away.
Positions and motions together are well behaved: the ball's place is what the contact angles follow. Newton's method follows
them from no friction, smooth, to all of it, sharp.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rollbench.lowfi.friction.contact.rings import Settled, cell_state
from rollbench.lowfi.friction.screw.chain import SPEEDS, Chain, ChainMotion, Search, solve_chain
from rollbench.lowfi.friction.screw.groove import plain_array
from rollbench.lowfi.friction.screw.kernel_types import JointSystem, Place
from rollbench.lowfi.friction.screw.load import Cell, load_arrays, settle_load
from rollbench.lowfi.friction.screw.motion import AGREED, ROUNDS, Coupling, Mixer, feedback, hold_screw
from rollbench.lowfi.jit import CONTACT, kernels
from rollbench.meshes.arrays import Array

#: Rounds after which loads and friction are solved as one system.
PATIENCE = 26
#: Residual aimed at, in units of the largest friction bound of a ball, and what lets a stage pass.
GOAL, PASSED = 1e-13, 1e-9
#: Most Newton steps of a stage and of a way; after fewer than these the next stage is longer.
STEPS, MOST, EASY = 80, 800, 8
#: Regularising speeds at which friction rises, one after the other: a way may turn back at a fold.
SMOOTH = (SPEEDS[0], 1e-2, 1e-3)
#: First and shortest stage, as parts of a way.
FIRST, SHORTEST = 1.0 / 32.0, 1e-5


@dataclass(frozen=True)
class Joint:
    """Positions of balls (N, 2) and screw (m,) [m], motions (N, 4) [rad/s], ball-to-ball forces (N,) [N].

    push (N, 2), drag (m,): forces on balls and screw [N] with which the contacts are in balance, see ``Cell``; done:
    whether all friction has been reached, else it is where the search ended; steps: of Newton's method.
    """

    ball: Array
    screw: Array
    q: Array
    ball_force: Array
    push: Array
    drag: Array
    done: bool
    steps: int


def solve_joint(
    cell: Cell, slack: Array, start: tuple[Array, Array], near: tuple[Array, Array] | None = None, fast: bool = True
) -> Joint:
    """All equations at once, from positions of balls (N, 2) and screw (m,) [m] in balance without friction.

    slack: as in ``Chain``; near: positions of a similar state with friction, for where no way leads from ``start``. The
    cell's push and drag do not enter: they are what is sought. ``fast`` takes the compiled kernels. Where several
    states exist, this is the one that grows out of the state without friction.
    """
    bare = replace(cell, push=np.zeros_like(cell.push), drag=np.zeros_like(cell.drag))
    sharp, steps = float(np.log(SPEEDS[-1])), 0
    ways = [(start, eps, 0.0) for eps in SMOOTH]
    if near is not None:
        ways += [(near, eps, 1.0) for eps in reversed(SMOOTH)]
    for place, eps, share in ways:
        path, smooth = _Path(bare, slack, place, fast), float(np.log(eps))
        done = share == 1.0 or path.follow((share, smooth), (1.0, smooth))
        done = done and path.follow((1.0, smooth), (1.0, sharp))
        steps += path.steps
        if done:
            break
    push, drag = path.state.ball, path.state.inner
    return Joint(path.ball, path.screw, path.q, path.ball_force, push, drag, done, steps)


def system_of(cell: Cell, search: Search) -> JointSystem:
    """Arguments of the joint kernels for a cell and the scaled arrays of its chain."""
    pair, total = cell.groove.pair, float(search.balls.force.sum())
    length = float(np.max(cell.groove.constants.C)) * max(total, 1e-30) ** (2.0 / 3.0)
    return JointSystem(
        cell=load_arrays(cell),
        groove=search.groove,
        balls=search.balls,
        unit=search.bound,
        length=length,
        push=plain_array(pair.push[:, [0, 2]]),
        slide=plain_array(pair.slide[..., [0, 2]]),
        rows=plain_array(cell.rows),
    )


class _Path:
    """State of the search; ``follow`` moves it."""

    def __init__(self, cell: Cell, slack: Array, start: tuple[Array, Array], fast: bool) -> None:
        """Begin at positions, with the motion at the loads there."""
        self.cell, self.slack, self.fast, self.steps = cell, slack, fast, 0
        self.ball, self.screw = start
        self.measure()
        moved = solve_chain(self.search.chain, None, fast)
        self.q, self.ball_force = moved.q, moved.ball_force

    def measure(self) -> None:
        """Rescale forces and the set of loaded balls by the loads at the present state."""
        g, arrays = self.cell.groove, load_arrays(self.cell)
        self.state = cell_state(arrays)
        kernels(CONTACT, compiled=self.fast).press(arrays, self.ball, self.screw, self.state)
        n = self.state.normal
        normals = np.stack([n[..., 0], np.zeros_like(n[..., 0]), n[..., 1]], axis=-1)
        self.search = Search(Chain(g, self.state.force, normals, self.slack), self.fast)
        self.system = system_of(self.cell, self.search)

    def follow(self, start: tuple[float, float], end: tuple[float, float]) -> bool:
        """Go from a fraction of the friction on balls and screw and a logarithm of the regularising speed to others.

        Each stage begins where the last two point to; stages shrink where Newton's method fails. Whether it arrived.
        """
        way, step = 0.0, FIRST
        last: tuple[float, Place] | None = None
        while way < 1.0 and step >= SHORTEST and self.steps < MOST:
            goal, here = min(1.0, way + step), self.place()
            guess = here
            if last is not None:
                p, u, x, f = (a + (goal - way) / (way - last[0]) * (a - b) for a, b in zip(here, last[1], strict=True))
                guess = Place(p, u, x, f)
            share, eps = start[0] + goal * (end[0] - start[0]), np.exp(start[1] + goal * (end[1] - start[1]))
            used = self.stage(guess, float(share), float(eps))
            if used is None:
                step *= 0.5
                continue
            last, way = (way, here), goal
            step *= 1.5 if used <= EASY else 1.0
        return way >= 1.0

    def place(self) -> Place:
        """Unknowns of the kernels, but forces in N, so that places with different measures can be compared."""
        return Place(self.ball, self.screw, self.q * self.search.units / self.search.speed, self.ball_force)

    def stage(self, guess: Place, share: float, eps: float) -> int | None:
        """Newton at one fraction of the friction and one regularising speed; stays here and returns None where it fails."""
        s = self.search
        p, u, x, f = (plain_array(a).copy() for a in guess)
        f /= s.bound
        left, used = s.kernels.newton_joint(self.system, Place(p, u, x, f), share, eps, GOAL, STEPS)
        self.steps += int(used)
        if not left <= PASSED:
            return None
        self.ball, self.screw, self.q, self.ball_force = p, u, x * s.speed / s.units, f * s.bound
        self.measure()
        return int(used)


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
