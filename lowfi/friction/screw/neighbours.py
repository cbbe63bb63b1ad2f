"""Forces between neighbouring balls of closed tracks, with derivatives, and the linear systems of Newton's method.

In all arrays the first axis is the ball k, and index k of a pair is that of ball k and the next one of its track; several
tracks stand one after the other. Motions x ``(N, 4)`` are
the balls' surface speeds (orbit, and spins about x3, y3, z3) over the speed of the nut along the path, ``eps`` is the
regularising speed over the same speed, and ball-to-ball forces f ``(N,)`` act from ball k on ball k + 1, in the unit of
force of `ScaledBalls`.

A contact that sticks creeps at a tiny part of the speeds of its ball. Its motion is therefore never the difference of such
speeds: it moves along with the ball, step by step (`ScaledBalls.moved`), and keeps all its digits.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rollbench.lowfi.friction.screw.groove import ScaledTrack
from rollbench.meshes.arrays import Array, Index, Mask


class ScaledBalls(NamedTuple):
    """Frictional contacts of N balls with the grooves and with each other, under known contact loads, in motion.

    The balls are those of one track or of several independent ones. All friction forces of a track are in one unit of
    force, which is the largest friction bound mu F of its balls; all speeds are over the speed of the nut along the path.
    """

    #: Number of places from each ball to the next ball of its track, and from each ball to the one before it ``(N, 2)``.
    neighbour_offsets: Index
    #: Motion x of each ball when it rolls at the nominal contact angle ``(N, 4)``.
    nominal: Array
    #: Whether each ball counts as loaded ``(N,)``.
    loaded: Mask
    #: Stiffness of weak springs that draw the motion of each ball to the nominal motion ``(N,)``.
    holding_stiffness: Array
    #: Whether ball k can touch ball k + 1 ``(N,)``.
    can_touch_next: Mask
    #: Coefficient of friction between ball k and ball k + 1 ``(N,)``.
    mu: Array
    #: Semi-axes a of the contacts with the grooves, across the groove ``(N, 4)`` [m].
    a: Array
    #: Semi-axes b of these contacts, along the groove ``(N, 4)`` [m].
    b: Array
    #: Friction bound mu F of these contacts, in the unit of force ``(N, 4)``.
    bound: Array
    #: Sliding vx, vz and spin at the contacts per unit of the motion x of a ball ``(N, 4, 3, 4)``.
    contact_motion_maps: Array
    #: Motions x of the balls ``(N, 4)``.
    motion: Array
    #: Sliding vx, vz and spin at the contacts with the grooves ``(N, 4, 3)``.
    contact_motions: Array
    #: Velocity with which ball k slides on ball k + 1, along two tangents of their contact ``(N, 2)``.
    sliding_on_next: Array
    #: Speed at which ball k may further approach ball k + 1: what their gap allows, less the actual speed ``(N,)``.
    remaining_closing_rate: Array

    def of_next(self, values: Array) -> Array:
        """Return for each ball the values ``(N, ...)`` of the next ball of its track."""
        return np.asarray(values[np.arange(len(values)) + self.neighbour_offsets[:, 0]])

    def of_previous(self, values: Array) -> Array:
        """Return for each ball the values ``(N, ...)`` of the ball before it on its track."""
        return np.asarray(values[np.arange(len(values)) + self.neighbour_offsets[:, 1]])

    def moved(self, track: ScaledTrack, change: Array) -> ScaledBalls:
        """Return the balls after a ``change`` of their motions ``(N, 4)``."""
        first, second = track.first_ball_surface_speeds, track.second_ball_surface_speeds
        next_change = self.of_next(change)
        return self._replace(
            motion=self.motion + change,
            contact_motions=self.contact_motions + (self.contact_motion_maps @ change[:, None, :, None])[..., 0],
            sliding_on_next=self.sliding_on_next + change @ first.T - next_change @ second.T,
            remaining_closing_rate=self.remaining_closing_rate + (next_change - change) @ track.approach,
        )


class Sliding(NamedTuple):
    """Sliding of each ball on the next one, divided by the speed of the nut along the path."""

    #: Velocity along two tangents of the contact ``(N, 2)``.
    velocity: Array
    #: Regularised speed sqrt(velocity^2 + eps^2) ``(N,)``.
    speed: Array

    @property
    def direction(self) -> Array:
        """Velocity over regularised speed ``(N, 2)``."""
        return self.velocity / self.speed[:, None]


def sliding_on_next_ball(balls: ScaledBalls, eps: Array | float) -> Sliding:
    """Return how each ball slides on the next one."""
    v = balls.sliding_on_next
    return Sliding(v, np.sqrt((v * v).sum(axis=1) + eps * eps))


def neighbours_in_a_ring(count: int) -> Index:
    """Return ``neighbour_offsets`` of the balls of one closed track ``(N, 2)``; ``count``: their number N."""
    offsets = np.tile([1, -1], (count, 1))
    offsets[-1, 0], offsets[0, 1] = 1 - count, count - 1
    return offsets


class CutTracks(NamedTuple):
    """Order of N balls in which the equations of each closed track are cut open between two balls."""

    #: Numbers of the balls, track by track, each from the ball after the cut on ``(N,)``.
    order: Index
    #: Places in this order at which a track ends.
    ends: Index


def cut_at_open_gaps(balls: ScaledBalls, f: Array) -> CutTracks:
    """Return the order of the balls in which each closed track is cut open at its widest open gap.

    For this gap the remaining closing rate exceeds the ball-to-ball force by the largest amount, both in scaled units.
    """
    open_by = np.where(balls.can_touch_next, balls.remaining_closing_rate - f, np.inf)
    ends = np.flatnonzero(balls.neighbour_offsets[:, 0] <= 0)
    tracks = np.split(np.arange(f.size), ends[:-1] + 1)
    return CutTracks(np.concatenate([np.roll(track, -1 - int(np.argmax(open_by[track]))) for track in tracks]), ends)


class Complementarity(NamedTuple):
    """Fischer-Burmeister function f + g - sqrt(f^2 + g^2 + 2 s) of force f and closing rate g left of each gap ``(N,)``.

    For s = 0 it is zero where f and g are complementary: the one or the other is zero, and neither is negative. For s > 0
    it is smooth, and zero where both are positive and f g = s.
    """

    #: Value of the function.
    value: Array
    #: Derivative by the force f.
    by_force: Array
    #: Derivative by the remaining closing rate g.
    by_rate: Array


def complementarity(balls: ScaledBalls, f: Array, product: Array | float = 0.0) -> Complementarity:
    """Return the Fischer-Burmeister function of each gap; where the balls cannot touch, the force itself.

    ``product``: force times remaining closing rate, s.
    """
    g, can = balls.remaining_closing_rate, balls.can_touch_next
    root = np.maximum(np.sqrt(f * f + g * g + 2.0 * product), 1e-300)
    by_force, by_rate = np.where(can, 1.0 - f / root, 1.0), np.where(can, 1.0 - g / root, 0.0)
    return Complementarity(np.where(can, f + g - root, f), by_force, by_rate)


class NeighbourLevers(NamedTuple):
    """How the force between two balls acts on the r equations of the first and of the second ball.

    The last four of these equations are those of the ball's motion. A force f that slides in the direction t with friction
    mu f adds f normal + mu f (t @ tangents) to the equations of the first ball, and subtracts it from those of the second.
    """

    #: Effect of the force on the first ball ``(r,)``.
    first_normal: Array
    #: Effect of friction along each of the two tangents on the first ball ``(2, r)``.
    first_tangents: Array
    #: Effect of the force on the second ball ``(r,)``.
    second_normal: Array
    #: Effect of friction along each of the two tangents on the second ball ``(2, r)``.
    second_tangents: Array


def levers_on_motion(track: ScaledTrack) -> NeighbourLevers:
    """Return the effects of the force between two balls on the four equations of their motions (Lin 3.73-3.75)."""
    first, second = track.first_ball_surface_speeds, track.second_ball_surface_speeds
    return NeighbourLevers(track.approach, first, track.approach, second)


def forces_of_neighbours(balls: ScaledBalls, levers: NeighbourLevers, sliding: Sliding, mu: Array, f: Array) -> Array:
    """Return what the forces ``f`` of neighbours and their friction add to the equations of each ball ``(N, r)``."""
    normal, rub = f[:, None], (mu * np.maximum(f, 0.0))[:, None] * sliding.direction
    on_first = normal * levers.first_normal + rub @ levers.first_tangents
    on_second = normal * levers.second_normal + rub @ levers.second_tangents
    return np.asarray(on_first - balls.of_previous(on_second))


class RingMatrix(NamedTuple):
    """Matrix of rings of N balls with b equations each, in which only neighbours are coupled, as blocks ``(N, b, b)``."""

    #: Rows and columns of ball k.
    own: Array
    #: Rows of ball k, columns of ball k + 1.
    right: Array
    #: Rows of ball k + 1, columns of ball k.
    below: Array


def neighbour_blocks(
    track: ScaledTrack,
    balls: ScaledBalls,
    levers: NeighbourLevers,
    sliding: Sliding,
    mu: Array,
    f: Array,
    gaps: Complementarity,
) -> RingMatrix:
    """Return the derivatives of `forces_of_neighbours` (r rows) and of the complementarity (last row).

    The columns are the r unknowns of a ball, of which the last four are its motion, and last its force on the next ball.
    """
    x, r = slice(-5, -1), levers.first_normal.size
    t, F, S = sliding.direction, track.first_ball_surface_speeds, track.second_ball_surface_speeds
    first, second = levers.first_tangents.T, levers.second_tangents.T
    turn = (mu * np.maximum(f, 0.0) / sliding.speed)[:, None, None] * (np.eye(2) - t[:, :, None] * t[:, None, :])
    slides = np.where(f > 0.0, mu, 0.0)[:, None] * t
    own, right, below = np.zeros((3, f.size, r + 1, r + 1))
    own[:, :r, x] = first @ turn @ F + balls.of_previous(second @ turn @ S)
    right[:, :r, x] = -first @ turn @ S
    below[:, :r, x] = -second @ turn @ F
    own[:, :r, -1] = levers.first_normal + slides @ levers.first_tangents
    below[:, :r, -1] = -levers.second_normal - slides @ levers.second_tangents
    right[:, -1, x] = gaps.by_rate[:, None] * track.approach
    own[:, -1, x] = -right[:, -1, x]
    own[:, -1, -1] = gaps.by_force
    return RingMatrix(own, right, below)


def solve_rings_cut_open(matrix: RingMatrix, side: Array, cut: CutTracks) -> tuple[Array, Array]:
    """Solve the linear system of rings of N balls that are cut open, for c right-hand sides.

    Returns the solutions, and the sign of the determinant of each ring cut open ``(rings,)``.

    The couplings across the cuts are left out. Gaussian elimination with row exchange on a band, because friction between
    balls makes the matrix unsymmetric and, beyond a fold of the solution, indefinite. For a singular matrix the solutions
    are huge. ``side``: ``(N, b, c)``, in the order of the balls, as is the result.
    """
    from scipy.linalg.lapack import dgbtrf, dgbtrs

    own, right, below = (block[cut.order] for block in matrix)
    right[cut.ends], below[cut.ends] = 0.0, 0.0
    n, b = own.shape[:2]
    half = 2 * b - 1
    column = np.zeros((n, 3 * b, b))  # rows of the ball before, the ball itself and the next one, in the columns of a ball
    column[1:, :b], column[:, b : 2 * b], column[:-1, 2 * b :] = right[:-1], own, below[:-1]
    band = np.zeros((3 * half + 1, n * b), order="F")
    for c in range(b):  # LAPACK's form: entry (i, j) at row 2 half + i - j
        top = 2 * half - b - c
        band[top : top + 3 * b, c::b] = column[:, :, c].T
    factors, exchanged, _ = dgbtrf(band, half, half, overwrite_ab=1)
    pivots, begins = factors[2 * half], b * np.append(0, cut.ends[:-1] + 1)
    signs = np.where(exchanged == np.arange(n * b), 1.0, -1.0) * np.sign(pivots)
    pivots[pivots == 0.0] = 1e-300
    solved, _ = dgbtrs(factors, half, half, side[cut.order].reshape(n * b, -1), exchanged)
    out = np.empty_like(side)
    out[cut.order] = solved.reshape(side.shape)
    return out, np.multiply.reduceat(signs, begins)
