"""Contact loads, motions and ball-to-ball forces as one system of equations, solved by Newton's method.

Unknowns of a ball, in this order: position p (x3, z3) in units of ``position_unit``, motion x (4,), force f on the next
ball; after all balls the screw's displacements u (m,), also in units of ``position_unit``. Forces are in the unit of
`ScaledBalls`. Axes of arrays: ball, contact, component.

In all functions ``eps`` is the regularising speed over the nut's speed along the path, and ``share`` is the fraction of the
friction that acts on the loads, by which the search approaches the solution.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from rollbench.lowfi.friction.contact.dissipation import dissipation_ratio
from rollbench.lowfi.friction.contact.normal_force import BallContactArrays, normal_forces
from rollbench.lowfi.friction.screw import neighbours
from rollbench.lowfi.friction.screw.chain import BalanceSearch, screw_ball_chain
from rollbench.lowfi.friction.screw.groove import ON_SCREW
from rollbench.lowfi.friction.screw.motion import BallsBetweenGrooves, arrays_for_contact_loads
from rollbench.lowfi.friction.screw.neighbours import NeighbourLevers, RingMatrix
from rollbench.meshes.arrays import Array

#: Part of the stiffest position's stiffness that keeps positions which no contact resists where they are.
FLOOR = 1e-12


@dataclass(frozen=True)
class LoadsAndMotionSystem:
    """Data of the one system of equations that determines contact loads and motions of the balls together.

    There are N balls; the screw is free in m motions u.
    """

    #: Balls between screw and nut, with the forces on the screw.
    cell: BallsBetweenGrooves
    #: Chain of the resting balls under the present contact loads, and its scales.
    search: BalanceSearch

    @classmethod
    def at_positions(cls, cell: BallsBetweenGrooves, slack: Array, ball: Array, screw: Array) -> LoadsAndMotionSystem:
        """Return the system scaled at the contact loads after displacements of balls and screw [m].

        ``slack``: largest rate at which the difference of the azimuths of balls k and k + 1 may decrease ``(N,)`` [rad/s].
        """
        at = normal_forces(arrays_for_contact_loads(cell), ball, screw)
        chain = screw_ball_chain(cell.groove, at.force, np.insert(at.normal, 1, 0.0, axis=-1), slack)
        return cls(cell, BalanceSearch(chain))

    @cached_property
    def arrays(self) -> BallContactArrays:
        """Geometry, stiffness and loads of the balls."""
        return arrays_for_contact_loads(self.cell)

    @property
    def force_unit(self) -> float:
        """Unit of force in these equations [N]: the largest friction bound of a ball."""
        return float(self.search.bound)

    @cached_property
    def position_unit(self) -> float:
        """Unit of positions in these equations [m]: approach at a contact under the sum of all contact loads."""
        total = float(self.search.chain.force[self.search.loaded].sum())
        return float(np.max(self.cell.groove.contact_hertz_constants.C) * max(total, 1e-30) ** (2.0 / 3.0))

    @property
    def units(self) -> Array:
        """Units of all unknowns of the system and of the part of the way ``(7 N + m + 1,)``."""
        n, m = self.search.count, self.cell.screw_displacement_maps.shape[2]
        unknowns = LoadsAndMotionUnknowns(np.ones((n, 2)), np.ones(m), np.ones((n, 4)), np.full(n, self.force_unit))
        return np.append(unknowns.in_units(1.0 / self.position_unit), 1.0)


class LoadsAndMotionUnknowns(NamedTuple):
    """Unknowns of N balls and the screw if contact loads and ball motion are solved as one system of equations."""

    #: Displacements of the balls along x3, z3 ``(N, 2)`` [m].
    ball: Array
    #: Displacement of the screw in each motion u in which it is free ``(m,)`` [m].
    screw: Array
    #: Motions x of the balls: orbit and three spins as surface speeds, over the nut's speed along the path ``(N, 4)``.
    motion: Array
    #: Force of ball k on ball k + 1, in the unit of force ``(N,)``.
    ball_force: Array

    def moved(self, step: LoadsAndMotionUnknowns, length: float) -> LoadsAndMotionUnknowns:
        """Return the unknowns after ``length`` times a step."""
        return LoadsAndMotionUnknowns(*(a + length * d for a, d in zip(self, step, strict=True)))

    def in_units(self, position_unit: float) -> Array:
        """Return all unknowns in one array ``(7 N + m,)``: ball by ball, then the screw, positions over their unit [m]."""
        of_balls = np.concatenate([self.ball / position_unit, self.motion, self.ball_force[:, None]], axis=1)
        return np.concatenate([of_balls.ravel(), self.screw / position_unit])

    @classmethod
    def from_units(cls, values: Array, count: int, position_unit: float) -> LoadsAndMotionUnknowns:
        """Return the unknowns of ``count`` balls and the screw from one array, as `in_units` returns it."""
        of_balls, screw = values[: 7 * count].reshape(count, 7), values[7 * count :]
        return cls(of_balls[:, ON_BALL] * position_unit, screw * position_unit, of_balls[:, BY_MOTION], of_balls[:, -1])


#: Rows of the equations to which the contacts of a ball contribute: forces on it along x3, z3; gradient by its motion; its
#: force on the screw along x3, y3, z3. The first two are equations of the ball.
ON_BALL, BY_MOTION, ON_THE_SCREW, OF_BALL = slice(0, 2), slice(2, 6), slice(6, 9), slice(0, 6)


class GrooveForces(NamedTuple):
    """What the contacts of each ball with the grooves add to the nine equations, with derivatives."""

    #: Forces ``(N, 9)`` [N].
    value: Array
    #: Derivatives by the ball's position along x3, z3 ``(N, 9, 2)`` [N/m].
    by_position: Array
    #: Derivatives by the displacement of the screw along x3, z3 ``(N, 9, 2)`` [N/m].
    by_screw: Array
    #: Derivatives by the ball's motion x ``(N, 9, 4)`` [N].
    by_motion: Array


def groove_forces(system: LoadsAndMotionSystem, at: LoadsAndMotionUnknowns, share: float, eps: float) -> GrooveForces:
    """Return the forces of all contacts of the balls with the grooves, normal forces and friction, with derivatives.

    With the normal n, the direction m across it, the friction g (components vx, vz, spin) over its bound mu F, and the
    matrix R by which the motion of the ball gives that of the contact, a contact pushes the ball by F n + mu F g_x m in
    its section and by mu F g_z along the path, and adds mu F R^T g to the gradient by the motion. A displacement changes F
    by its part along n, and n by its part along m over the distance of the centres; F also changes the semi-axes, which
    grow with F^(1/3), and n changes R.
    """
    groove, (F, stiffness, n, distance) = system.cell.groove, normal_forces(system.arrays, at.ball, at.screw)
    m = np.stack([n[..., 1], -n[..., 0]], axis=-1)
    (rest, *by_normal), body_motion = groove.affine_contact_maps
    h, speed = groove.contact_hertz_constants, groove.speed_along_path
    turned = np.tensordot(m, by_normal, 1)  # change of R as n turns
    R = rest + np.tensordot(n, by_normal, 1)
    x = at.motion[:, None, :] - body_motion
    v, v_turned = ((rows @ x[..., None])[..., 0] for rows in (R, turned))
    root = np.cbrt(np.where(F > 0.0, F, 1.0))
    D = dissipation_ratio(h.C_a * root, h.C_b * root, v, eps * speed)
    rubs = ((F > 0.0) & system.search.loaded[:, None])[..., None]  # other contacts have no friction
    g, H = D.gradient * rubs, D.hessian * rubs[..., None]
    # d(F g)/dF = g + F dg/dF, from D(s a, s b, vx, vz, spin) = D(a, b, vx, vz, s spin) for any factor s of the semi-axes
    spin, about_normal = v[..., 2:], np.array([0.0, 0.0, 1.0])
    by_force = g + (spin * H[..., 2] + g * about_normal) / 3.0
    H_R = np.swapaxes(H @ R, -1, -2)  # axes ball, contact, motion, component
    H_turned = (H @ v_turned[..., None])[..., 0]
    mu = groove.mu or 1.0
    bound = mu * F[..., None]

    def pull_on_ball(pull: Array, rows: Array) -> Array:
        """Return the effect on the nine equations ``(N, 4, 9)`` of a friction ``pull`` in the plane of the contact.

        ``rows``: matrix by which the motion of the ball gives that of the contact.
        """
        across, along = share * pull[..., :1] * m, share * pull[..., 1]
        return effect_of_contact(across, along, (np.swapaxes(rows, -1, -2) @ pull[..., None])[..., 0] / speed)

    no_motion = np.zeros((*F.shape, 4))
    push, aside, turned_pull = (effect_of_contact(d, 0.0 * F, no_motion) for d in (n, m, share * g[..., :1] * n))
    value = F[..., None] * push + bound * pull_on_ball(g, R)
    along_n = stiffness[..., None] * (push + mu * pull_on_ball(by_force, R))
    along_m = F[..., None] * aside + bound * (pull_on_ball(H_turned, R) - turned_pull)
    along_m[..., BY_MOTION] += bound * (np.swapaxes(turned, -1, -2) @ g[..., None])[..., 0] / speed
    by_position = along_n[..., None] * n[..., None, :] + (along_m / distance[..., None])[..., None] * m[..., None, :]
    by_motion = bound[..., None] * effect_of_contact(
        share * H_R[..., :1] * m[..., None, :], share * H_R[..., 1], H_R @ R / speed
    )
    by_screw = -by_position[:, ON_SCREW].sum(axis=1)
    return GrooveForces(value.sum(axis=1), by_position.sum(axis=1), by_screw, np.swapaxes(by_motion.sum(axis=1), 1, 2))


def effect_of_contact(in_section: Array, along: Array, on_motion: Array) -> Array:
    """Return the effect of the contacts on the nine equations of their balls ``(N, 4, ..., 9)``.

    ``in_section``: force on the ball along x3, z3 ``(N, 4, ..., 2)``; ``along``: force along the path, which only the screw
    feels ``(N, 4, ...)``; ``on_motion``: gradient by the motion of the ball ``(N, 4, ..., 4)``.
    """
    on_screw = np.stack([in_section[..., 0], along, in_section[..., 1]], axis=-1)
    on_screw[:, ~ON_SCREW] = 0.0
    return np.concatenate([in_section, on_motion, on_screw], axis=-1)


class LoadsAndMotionEquations(NamedTuple):
    """Residual and Jacobian of the one system for contact loads and motion: a ring of balls, bordered by the screw."""

    #: Residual of the equations of the balls ``(N, 7)``.
    balls: Array
    #: Residual of the equations of the screw ``(m,)``.
    screw: Array
    #: Derivatives of the balls' equations by the balls' unknowns.
    ring: RingMatrix
    #: Derivatives of the balls' equations by the displacements u of the screw ``(N, 7, m)``.
    balls_by_screw: Array
    #: Derivatives of the screw's equations by the balls' unknowns ``(m, N, 7)``.
    screw_by_balls: Array
    #: Derivatives of the screw's equations by its displacements u ``(m, m)``.
    screw_by_screw: Array

    @property
    def residual(self) -> Array:
        """All residuals, ball by ball, then those of the screw ``(7 N + m,)``."""
        return np.append(self.balls, self.screw)

    @property
    def size(self) -> float:
        """Root of the sum of squares of all residuals."""
        return float(np.sqrt((self.balls**2).sum() + (self.screw**2).sum()))


def levers_on_loads_and_motion(system: LoadsAndMotionSystem, share: float) -> NeighbourLevers:
    """Return the effects of the force between two balls on the six equations of each: its force balance and its motion."""
    track, pair, in_section = system.search.track, system.cell.groove.pair, [0, 2]
    normal, tangents = pair.force_directions[:, in_section], pair.tangent_directions[..., in_section]
    return NeighbourLevers(
        first_normal=np.append(-share * normal[0], track.approach),
        first_tangents=np.hstack([share * tangents[0], track.first_ball_surface_speeds]),
        second_normal=np.append(share * normal[1], track.approach),
        second_tangents=np.hstack([share * tangents[1], track.second_ball_surface_speeds]),
    )


def loads_and_motion_equations(
    system: LoadsAndMotionSystem, at: LoadsAndMotionUnknowns, share: float, eps: float
) -> LoadsAndMotionEquations:
    """Return residual and Jacobian of the equations for contact loads and motion; the loads on the screw are the cell's."""
    cell, track, unit = system.arrays, system.search.track, system.force_unit
    balls, f = system.search.in_motion(at.motion), at.ball_force
    length, maps = system.position_unit, system.cell.screw_displacement_maps
    own = groove_forces(system, at, share, eps)
    value, by_motion = own.value / unit, own.by_motion / unit
    by_position, by_screw = (values * length / unit for values in (own.by_position, own.by_screw))
    levers, sliding = levers_on_loads_and_motion(system, share), neighbours.sliding_on_next_ball(balls, eps)
    gaps = neighbours.complementarity(balls, f)
    side = np.concatenate([value[:, OF_BALL], gaps.value[:, None]], axis=1)
    side[:, OF_BALL] += neighbours.forces_of_neighbours(balls, levers, sliding, balls.mu, f)
    side[:, BY_MOTION] += balls.holding_stiffness[:, None] * (at.motion - balls.nominal)
    ring = neighbours.neighbour_blocks(track, balls, levers, sliding, balls.mu, f, gaps)
    ring.own[:, OF_BALL, ON_BALL] += by_position[:, OF_BALL]
    ring.own[:, OF_BALL, BY_MOTION] += by_motion[:, OF_BALL]
    ring.own[:, BY_MOTION, BY_MOTION] += balls.holding_stiffness[:, None, None] * np.eye(4)
    by_u = by_screw @ cell.inner_displacement_maps
    balls_by_screw = np.pad(by_u[:, OF_BALL], ((0, 0), (0, 1), (0, 0)))
    by_unknowns = np.concatenate([by_position[:, ON_THE_SCREW], by_motion[:, ON_THE_SCREW]], axis=2)
    return LoadsAndMotionEquations(
        balls=side,
        screw=-cell.inner_body_forces / unit - np.einsum("krq,kr->q", maps, value[:, ON_THE_SCREW]),
        ring=ring,
        balls_by_screw=balls_by_screw,
        screw_by_balls=-np.pad(np.einsum("krq,krj->qkj", maps, by_unknowns), ((0, 0), (0, 0), (0, 1))),
        screw_by_screw=-np.einsum("krq,kro->qo", maps, by_u[:, ON_THE_SCREW]),
    )


def solve_linear_equations(
    system: LoadsAndMotionSystem, at: LoadsAndMotionUnknowns, now: LoadsAndMotionEquations, sides: Array
) -> Array:
    """Solve the linear system with the Jacobian of ``now`` for c right-hand sides; return ``(7 N + m, c)`` as ``sides``.

    Rows are in the order of `LoadsAndMotionUnknowns.in_units`. Positions that no contact resists do not move.
    """
    n, m = at.ball_force.size, at.screw.size
    own, i = now.ring.own.copy(), np.arange(2)
    floor = max(FLOOR * float(own[:, i, i].max()), 1e-300)
    own[:, i, i] += floor
    cut = neighbours.cut_at_open_gaps(system.search.in_motion(at.motion), at.ball_force)
    of_balls = np.concatenate([now.balls_by_screw, sides[: 7 * n].reshape(n, 7, -1)], axis=2)
    both, _ = neighbours.solve_rings_cut_open(now.ring._replace(own=own), of_balls, cut)
    by_screw, alone = both[..., :m], both[..., m:]
    # Schur complement of the balls for the screw's motions
    schur = now.screw_by_screw - np.einsum("qki,kio->qo", now.screw_by_balls, by_screw) + floor * np.eye(m)
    u = np.linalg.solve(schur, sides[7 * n :] - np.einsum("qki,kic->qc", now.screw_by_balls, alone))
    return np.concatenate([(alone - by_screw @ u).reshape(7 * n, -1), u])


def newton_step(
    system: LoadsAndMotionSystem, at: LoadsAndMotionUnknowns, now: LoadsAndMotionEquations
) -> LoadsAndMotionUnknowns:
    """Return Newton's step of all unknowns, with positions in m."""
    step = solve_linear_equations(system, at, now, -now.residual[:, None])[:, 0]
    return LoadsAndMotionUnknowns.from_units(step, at.ball_force.size, system.position_unit)
