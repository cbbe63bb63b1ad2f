"""Force balance of many moving balls with friction and ball-to-ball contact, solved by Newton's method.

The module also computes the relative motion at the contacts of balls with grooves, friction and losses. Arrays and their
units are those of ``neighbours``; the axes are ball, contact, component.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Hashable, Sequence
from typing import Any, NamedTuple, Self

import numpy as np

from rollbench.lowfi.friction.contact.dissipation import ContactDissipationRatio, dissipation_ratio
from rollbench.lowfi.friction.screw import neighbours
from rollbench.lowfi.friction.screw.groove import ScaledTrack
from rollbench.lowfi.friction.screw.neighbours import Complementarity, RingMatrix, ScaledBalls, Sliding
from rollbench.lowfi.friction.screw.path import PathPoint
from rollbench.lowfi.together import Search, Task
from rollbench.meshes.arrays import Array

#: Largest Newton step of a ball's surface speeds, as a fraction of the nut's speed along the path: farther away, friction
#: no longer gives the direction of the step.
REACH = 0.3

#: Number of Newton steps near the solution that may let the residual rise.
RISES = 6

#: First and last values of `Smoothing` on the path of solutions: regularising speed, product of force and closing rate,
#: stiffness of springs.
SPEEDS, PRODUCTS, SPRINGS = (1e-1, 1e-7), (1e-3, 1e-14), (1e-2, 1e-9)


class Smoothing(NamedTuple):
    """Smoothing of the equations: friction with the grooves and between balls, contact conditions, free motions.

    Each value is a number, or one for each ball ``(N,)``.
    """

    #: Regularising speed of friction over the speed of the moving groove along the track.
    speed: Array | float
    #: Fraction of the friction between balls that acts, 0 to 1.
    share: Array | float = 1.0
    #: Product of force and remaining closing rate of a gap, zero for exact complementarity.
    product: Array | float = 0.0
    #: Stiffness of springs that draw the balls to nominal rolling, in addition to their ``holding_stiffness``.
    spring: Array | float = 0.0


class ForceBalance(NamedTuple):
    """Unbalanced forces on N balls and contact conditions between neighbours, at given motions and forces."""

    #: Unbalanced generalised forces on the balls, one for each component of the motion x ``(N, 4)``.
    forces: Array
    #: Contact condition of each gap.
    gaps: Complementarity
    #: How each ball slides on the next one.
    sliding: Sliding
    #: Dissipated power at the contacts with the grooves, over their friction bounds.
    dissipation: ContactDissipationRatio

    @property
    def size(self) -> float:
        """Root of the sum of squares of all residuals."""
        return float(np.sqrt((self.forces**2).sum() + (self.gaps.value**2).sum()))

    @property
    def largest(self) -> float:
        """Largest absolute value of all residuals."""
        return float(max(np.abs(self.forces).max(), np.abs(self.gaps.value).max()))


def force_balance(track: ScaledTrack, balls: ScaledBalls, f: Array, law: Smoothing) -> ForceBalance:
    """Return the residuals of force balance and contact conditions of N balls (Lin 3.69, 3.73-3.77)."""
    D = dissipation_ratio(balls.a, balls.b, balls.contact_motions, np.reshape(law.speed, (-1, 1)))
    sliding = neighbours.sliding_on_next_ball(balls, law.speed)
    friction = np.einsum("ki,kir,kirj->kj", balls.bound, D.gradient, balls.contact_motion_maps)
    held = (balls.holding_stiffness + law.spring)[:, None] * (balls.motion - balls.nominal)
    push = neighbours.forces_of_neighbours(balls, neighbours.levers_on_motion(track), sliding, law.share * balls.mu, f)
    return ForceBalance(friction + held + push, neighbours.complementarity(balls, f, law.product), sliding, D)


def jacobian(track: ScaledTrack, balls: ScaledBalls, f: Array, at: ForceBalance, law: Smoothing) -> RingMatrix:
    """Return the derivatives of all residuals by motions and ball-to-ball forces; ``at``: force balance at forces ``f``."""
    maps, n, x = balls.contact_motion_maps, f.size, slice(0, 4)
    ring = neighbours.neighbour_blocks(
        track, balls, neighbours.levers_on_motion(track), at.sliding, law.share * balls.mu, f, at.gaps
    )
    bent = (balls.bound[..., None, None] * at.dissipation.hessian) @ maps
    ring.own[:, x, x] += maps.reshape(n, 12, 4).swapaxes(1, 2) @ bent.reshape(n, 12, 4)
    ring.own[:, x, x] += (balls.holding_stiffness + law.spring)[:, None, None] * np.eye(4)
    return ring


class BalancedMotion(NamedTuple):
    """Motions and forces of N balls at which a search for the force balance ended."""

    #: Balls in the motion found.
    balls: ScaledBalls
    #: Force of ball k on ball k + 1 ``(N,)``.
    ball_force: Array
    #: Residuals there.
    residuals: ForceBalance
    #: Number of Newton steps.
    steps: int


def joined(parts: Sequence[Any]) -> Any:
    """Return records of arrays (or arrays) as one, each array joined along its first axis, that of the balls."""
    first = parts[0]
    return np.concatenate(parts) if isinstance(first, np.ndarray) else type(first)(*map(joined, zip(*parts, strict=True)))


def parts_of(whole: Any, spans: Sequence[slice]) -> list[Any]:
    """Return the records that `joined` has joined; ``spans``: places of their balls along the first axis."""
    if isinstance(whole, np.ndarray):
        return [whole[span] for span in spans]
    return [type(whole)(*values) for values in zip(*(parts_of(field, spans) for field in whole), strict=True)]


class _OfOneTrack(Task):
    """Task of a search for the balls of one track; such tasks are solved together as tracks one after the other."""

    def __init__(self, track: ScaledTrack, balls: ScaledBalls, f: Array, law: Smoothing, at: ForceBalance | None) -> None:
        """Ask for the result at ``balls`` in motion and forces ``f``; ``at``: their force balance, if the task needs it."""
        self.track, self.unknowns, self.law, self.at = track, (balls, f), law, at

    @property
    def likeness(self) -> Hashable:
        """Kinematics that all balls share."""
        return tuple(kinematics.tobytes() for kinematics in self.track)

    @classmethod
    @abstractmethod
    def solve_joined(cls, track: ScaledTrack, balls: ScaledBalls, f: Array, law: Smoothing, at: Any) -> Any:
        """Return the result for all balls; the values of ``law`` may be arrays, one value a ball."""

    @classmethod
    def solve(cls, tasks: Sequence[Self]) -> Sequence[Any]:
        """Return the result for the balls of each task."""
        first = tasks[0]
        if len(tasks) == 1:
            return [cls.solve_joined(first.track, *first.unknowns, first.law, first.at)]
        counts = [task.unknowns[1].size for task in tasks]
        ends = np.cumsum(counts)
        balls, f = map(joined, zip(*(task.unknowns for task in tasks), strict=True))
        law = Smoothing(*np.repeat([task.law for task in tasks], counts, axis=0).T)
        at = None if first.at is None else joined([task.at for task in tasks])
        found = cls.solve_joined(first.track, balls, f, law, at)
        return parts_of(found, [slice(end - count, end) for end, count in zip(ends, counts, strict=True)])


class ForceBalanceTask(_OfOneTrack):
    """Task of a search: the residuals of force balance and contact conditions (`force_balance`)."""

    @classmethod
    def solve_joined(cls, track: ScaledTrack, balls: ScaledBalls, f: Array, law: Smoothing, at: None) -> ForceBalance:  # noqa: ARG003
        """Return the residuals of all balls."""
        return force_balance(track, balls, f, law)


class NewtonStepTask(_OfOneTrack):
    """Task of a search: Newton's step of motions and forces of the balls ``(N, 5)``."""

    @classmethod
    def solve_joined(cls, track: ScaledTrack, balls: ScaledBalls, f: Array, law: Smoothing, at: ForceBalance) -> Array:
        """Return the steps of all balls ``(N, 5)``."""
        side = -np.concatenate([at.forces, at.gaps.value[:, None]], axis=1)
        cut = neighbours.cut_at_open_gaps(balls, f)
        return neighbours.solve_rings_cut_open(jacobian(track, balls, f, at, law), side[..., None], cut)[0][..., 0]


def search_force_balance(
    track: ScaledTrack, balls: ScaledBalls, f: Array, law: Smoothing, goal: float, near: float, limit: int
) -> Search[BalancedMotion]:
    """Solve the force balance of the balls of one track by Newton's method under one smoothing.

    ``balls``, ``f``: balls in motion and forces to begin from. A step is halved until the residual falls. The iteration
    ends when the residual (root of the sum of squares) is at most ``goal``, after ``limit`` steps, or when no step lets the
    residual fall. Below a residual of ``near`` a few steps may let it rise: a force that is too small by far while its gap
    is nearly closed must first grow. The result is the state of least residual.
    """
    at: ForceBalance = yield ForceBalanceTask(track, balls, f, law, None)
    best, rises = BalancedMotion(balls, f, at, 0), 0
    for count in range(limit):
        if at.size < best.residuals.size:
            best = BalancedMotion(balls, f, at, count)
        if at.size <= goal:
            return best
        step: Array = yield NewtonStepTask(track, balls, f, law, at)
        dx, df = step[:, :-1], step[:, -1]
        length = min(1.0, REACH / max(float(np.abs(dx).max()), 1e-300))
        for _ in range(3 if best.residuals.size <= near else 25):
            moved = balls.moved(track, length * dx)
            trial: ForceBalance = yield ForceBalanceTask(track, moved, f + length * df, law, None)
            falls = trial.size < (1.0 - 0.1 * length) * at.size
            if falls or (trial.size <= near and rises < RISES):
                break
            length *= 0.5
        else:
            return best._replace(steps=count + 1)
        rises += not falls
        balls, f, at = moved, f + length * df, trial
    return BalancedMotion(balls, f, at, limit) if at.size < best.residuals.size else best._replace(steps=limit)


def determinant_sign(track: ScaledTrack, found: BalancedMotion, law: Smoothing) -> float:
    """Return the sign of the determinant of the derivatives of all residuals by all unknowns at a solution.

    Without friction between balls the problem is convex, with one sign; another sign tells another branch of solutions.
    """
    cut = neighbours.cut_at_open_gaps(found.balls, found.ball_force)
    ring = jacobian(track, found.balls, found.ball_force, found.residuals, law)
    return float(neighbours.solve_rings_cut_open(ring, np.zeros((found.ball_force.size, 5, 1)), cut)[1][0])


class BalancePoint(PathPoint):
    """Force balance of N balls on the path along which the friction between balls rises and all smoothing falls."""

    #: The end of the path is solved to more digits afterwards; rounding errors of many balls leave no residual of 1e-10.
    on_path = 1e-6

    def __init__(self, track: ScaledTrack, balls: ScaledBalls, point: Array) -> None:
        """Compute the equations at a ``point`` ``(5 N + 1,)``: motion and force on the next ball, ball by ball.

        ``balls``: the balls in any motion.
        """
        self.track, self.point = track, point
        unknowns = point[:-1].reshape(-1, 5)
        self.balls, self.ball_force = balls.moved(track, unknowns[:, :4] - balls.motion), unknowns[:, 4]
        self.law = smoothing_on_path(float(point[-1]))
        self.now = force_balance(track, self.balls, self.ball_force, self.law)
        self.residual = np.column_stack([self.now.forces, self.now.gaps.value]).ravel()

    def at(self, point: Array) -> BalancePoint:
        """Return the equations at another point ``(5 N + 1,)``."""
        return BalancePoint(self.track, self.balls, point)

    def solve(self, sides: Array) -> Array:
        """Solve the linear system with the Jacobian for c right-hand sides ``(5 N, c)``."""
        cut = neighbours.cut_at_open_gaps(self.balls, self.ball_force)
        ring = jacobian(self.track, self.balls, self.ball_force, self.now, self.law)
        solved, _ = neighbours.solve_rings_cut_open(ring, sides.reshape(self.ball_force.size, 5, -1), cut)
        return solved.reshape(sides.shape)

    def rescaled(self) -> tuple[BalancePoint, float]:
        """Return the same equations: their scales, known contact loads and speeds, do not change along the path."""
        return self, 1.0


def smoothing_on_path(way: float) -> Smoothing:
    """Return the smoothing at a part of the way, 0 to 1: friction between balls comes early, and the rest fades away."""
    speed, product, spring = (first * (last / first) ** way for first, last in (SPEEDS, PRODUCTS, SPRINGS))
    return Smoothing(speed, 1.0 - (1.0 - way) ** 8, product, spring)
