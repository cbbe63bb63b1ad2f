"""Equilibria of balls and other bodies on rolling contacts, each found as the minimum of a convex function.

The contact loads of balls between two rigid bodies are those at the minimum of elastic energy over all positions
(`solve_contact_loads`). The bodies are screw and nut, inner and outer ring, or carriage and rail. The inner body moves by
u, the outer body is fixed, and the unknowns of every ball are its two coordinates in the plane of its groove section.

The quasi-static motion of a body on frictional contacts with given normal loads is the motion of least dissipation
(`least_dissipation`). At contact i the body moves relative to its counterbody by v_i = ``maps[i] @ q + drives[i]``, with
the unknown motion q. Friction and the other forces ``push`` on the body balance at the minimum of

    sum_i mu F_i D_i(v_i) - push . q.                                                                                  (1)

The function is convex, so that every equilibrium is a minimum, also with contacts at rest.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from rollbench.lowfi.friction.contact.laws import ContactFriction, EllipticalContacts, FrictionLaw, SigmoidLaw
from rollbench.lowfi.friction.contact.least_dissipation import FrictionalBodies, least_dissipation_of_bodies
from rollbench.lowfi.friction.contact.loads import minimise_energy, one_group
from rollbench.lowfi.friction.contact.normal_force import BallContactArrays
from rollbench.lowfi.together import Task
from rollbench.meshes.arrays import Array, Mask

#: Largest unbalanced force, divided by the sum of all forces, up to which contact loads count as converged.
ACCEPTED = 1e-8


@dataclass(frozen=True)
class ContactLoadSolution:
    """Contact loads of N balls between two rigid bodies, the inner of which is free in m motions."""

    #: Contact forces ``(N, 4)`` [N].
    force: Array
    #: Contact angles under load ``(N, 4)`` [rad].
    angle: Array
    #: Displacements of the balls along the axes x, z of their groove sections ``(N, 2)`` [m].
    ball_displacements: Array
    #: Displacement of the inner body in each of the m motions in which it is free ``(m,)`` [m].
    inner_body_displacements: Array
    #: Largest unbalanced force on a ball or on the inner body [N].
    largest_unbalanced_force: float
    #: Number of Newton steps.
    steps: int
    #: Whether the largest unbalanced force is at most 1e-8 times the sum of all forces.
    converged: bool

    @property
    def displacements(self) -> tuple[Array, Array]:
        """Displacements of the balls ``(N, 2)``, then of the inner body ``(m,)`` [m]."""
        return self.ball_displacements, self.inner_body_displacements


class ContactLoadsTask(Task):
    """Task of a search: the contact loads of balls between two rigid bodies (`solve_contact_loads`)."""

    def __init__(
        self, cell: BallContactArrays, total_force: float, ball: Array, inner: Array, angles: Callable[[Array], Array]
    ) -> None:
        """Ask for the loads; arguments: see `solve_contact_loads`."""
        self.group = one_group(cell._replace(C=np.broadcast_to(cell.C, cell.interference.shape)))
        self.total_force, self.ball, self.inner, self.angles = total_force, ball, inner, angles

    @property
    def likeness(self) -> Hashable:
        """Numbers of balls and of free motions of the inner body."""
        return self.ball.shape, self.inner.shape

    @classmethod
    def solve(cls, tasks: Sequence[Self]) -> list[ContactLoadSolution]:
        """Return the contact loads of each task."""
        groups = BallContactArrays(*map(np.concatenate, zip(*(task.group for task in tasks), strict=True)))
        load, ball, inner = (np.array([getattr(t, name) for t in tasks]) for name in ("total_force", "ball", "inner"))
        balls, bodies, state, steps = minimise_energy(groups, load, ball, inner)
        good = state.imbalance <= ACCEPTED * (load + state.force.sum(axis=(1, 2)))
        of_each = zip(tasks, state.force, state.normal, balls, bodies, state.imbalance.tolist(), good.tolist(), strict=True)
        return [ContactLoadSolution(F, task.angles(n), p, u, left, steps, ok) for task, F, n, p, u, left, ok in of_each]


def solve_contact_loads(
    cell: BallContactArrays, total_force: float, ball: Array, inner: Array, angles: Callable[[Array], Array]
) -> ContactLoadSolution:
    """Return the contact loads of balls between two rigid bodies, by Newton's method with line search.

    The loads are found at the minimum of sum (2/5) C^(-3/2) <approach>^(5/2) - pull . u - push . p over the
    displacements u of the inner body and p of the balls. C is the Hertz constant of a contact, <approach> the approach
    where positive, and pull and push are the applied forces on inner body and balls in ``cell``. The model is valid for
    approaches far below the distance of groove centre and ball centre. The loads do not depend on the displacements
    from which the search begins.

    Parameters
    ----------
    cell
        Geometry, stiffness and loads of balls and bodies.
    total_force
        Sum of the magnitudes of the applied forces [N].
    ball, inner
        Displacements of the balls ``(N, 2)`` and of the inner body ``(m,)`` [m] from which the search begins.
    angles
        Function that computes contact angles ``(N, 4)`` [rad] from contact normals ``(N, 4, 2)``.
    """
    return ContactLoadsTask.solve([ContactLoadsTask(cell, total_force, ball, inner, angles)])[0]


#: Values of ``BodyMotion.status``, in the order of the codes in ``least_dissipation``.
STATUS = ("exact", "regularised", "at rest")
#: Options of MINPACK's hybrid method, which is similar to Matlab's fsolve. With a short first step it finds more roots for
#: single balls from random starts than with the default factor of 100.
HYBRID = {"xtol": 1e-13, "factor": 0.1}


@dataclass(frozen=True)
class BodyMotionProblem:
    """Contacts, kinematics and forces that determine n unknown velocities of a body with m frictional contacts."""

    #: Ellipses, loads and friction coefficients of the body's contacts.
    contacts: EllipticalContacts
    #: Motion vx, vz [m/s], spin [rad/s] of the contacts per unit of each unknown velocity ``(m, 3, n)``.
    contact_motion_maps: Array
    #: Motion vx, vz [m/s], spin [rad/s] that the drive imposes on the contacts while all unknown velocities are zero ``(m,
    #: 3)``.
    imposed_contact_motions: Array
    #: Generalised forces on the body other than friction ``(n,)`` [W per unit of the unknown velocity].
    other_forces: Array

    @property
    def body(self) -> FrictionalBodies:
        """The body as the only one of K = 1 bodies."""
        at, motions = self.contacts, (self.contact_motion_maps, self.imposed_contact_motions, self.other_forces)
        return FrictionalBodies(*(np.asarray(x, dtype=float)[None] for x in (at.a, at.b, at.friction_bound, *motions)))

    def contact_motions_at(self, q: Array) -> Array:
        """Return the sliding and spin of the body at its m contacts ``(m, 3)`` for unknown velocities q ``(n,)``.

        The values for a contact are the sliding vx, vz along the semi-axes a, b [m/s] and the spin about the normal
        [rad/s].
        """
        return np.asarray(self.imposed_contact_motions + self.contact_motion_maps @ q)

    def unbalanced_forces(self, friction: ContactFriction) -> Array:
        """Return the sum of friction and other forces on the body as generalised forces ``(n,)`` [W per unit of unknown].

        ``friction``: friction at the contacts.
        """
        wrench = np.column_stack([friction.force, friction.moment])
        return np.asarray(np.einsum("ir,irj->j", wrench, self.contact_motion_maps) + self.other_forces)


@dataclass(frozen=True)
class BodyMotion:
    """Computed motion of a body with m frictional contacts and n unknown velocities, with the friction on it."""

    #: Computed values of the unknown velocities of the body ``(n,)``.
    unknown_velocities: Array
    #: Motion vx, vz [m/s], spin [rad/s] of the body relative to its counterbody at each contact ``(m, 3)``.
    contact_motions: Array
    #: Friction on the body at each contact; for contacts at rest, the reactions.
    friction: ContactFriction
    #: Whether each contact is at rest ``(m,)``.
    sticking_contacts: Mask
    #: Largest unbalanced force on the body [N].
    imbalance: float
    #: ``"exact"``: equilibrium in which contacts rest or slip exactly; ``"regularised"``: equilibrium with regularised
    #: friction, because a contact is on the verge of slip; ``"at rest"``: no motion, for lack of drive and force;
    #: ``"failed"``: no equilibrium found.
    status: str
    #: Number of Newton steps, or of evaluations of the equations, in the search.
    steps: int

    @property
    def loss(self) -> float:
        """Friction loss of the body, summed over its contacts [W]."""
        return float(np.sum(self.friction.loss))


def least_dissipation(problem: BodyMotionProblem, start: Array | None = None) -> BodyMotion:
    """Return the quasi-static motion of a body on frictional contacts: the motion of least dissipation.

    At this motion the dissipated power less the power of the forces other than friction is least, so that all forces are in
    balance. Unknowns that cause no dissipation keep their values at the start.

    Parameters
    ----------
    problem
        Contacts, kinematics and forces, with any number of loaded contacts.
    start
        Values of the unknowns ``(n,)`` from which the search begins; None to begin with the motion nearest to pure rolling.
    """
    return least_dissipations([problem], None if start is None else np.asarray(start, dtype=float)[None])[0]


def least_dissipations(problems: Sequence[BodyMotionProblem], start: Array | None = None) -> list[BodyMotion]:
    """Return the motions of least dissipation of K independent bodies with the same numbers of contacts and unknowns.

    Parameters
    ----------
    problems
        Contacts, kinematics and forces of each body.
    start
        Values of the unknowns ``(K, n)`` from which the search begins; None to begin near pure rolling.
    """
    if not problems:
        return []
    bodies = FrictionalBodies(*map(np.concatenate, zip(*(p.body for p in problems), strict=True)))
    found = least_dissipation_of_bodies(bodies, start)
    good = found.balanced(bodies)
    out = []
    for k, problem in enumerate(problems):
        motion, forces = problem.contact_motions_at(found.q[k]), found.forces[k]
        motion[found.rest[k]] = 0.0
        friction = ContactFriction(force=-forces[:, :2], moment=-forces[:, 2], loss=np.sum(forces * motion, axis=1))
        out.append(
            BodyMotion(
                unknown_velocities=found.q[k],
                contact_motions=motion,
                friction=friction,
                sticking_contacts=found.rest[k],
                imbalance=float(found.imbalance[k]),
                status=STATUS[found.status[k]] if good[k] else "failed",
                steps=int(found.steps[k]),
            )
        )
    return out


def motion_by_root(problem: BodyMotionProblem, law: FrictionLaw, start: Array) -> BodyMotion:
    """Return the motion of a body at which its friction balances, as a root found by MINPACK's hybrid method.

    This is the method of Lin's thesis, which uses Matlab's fsolve for eq. (3.19). The method fails from many starts
    near two-point contact, and for sharp sigmoids.

    Parameters
    ----------
    problem
        Contacts, kinematics and forces.
    law
        Friction law.
    start
        Values of the unknowns ``(n,)`` from which the search begins.
    """
    units = problem.body.surface_speed_per_unknown[0]
    scale = max(float(np.sum(problem.contacts.friction_bound)), 1e-300)

    def residual(p: Array) -> Array:
        """Return the unbalanced generalised forces over the sum of friction bounds, for scaled unknowns p ``(n,)``."""
        friction = law(problem.contacts, problem.contact_motions_at(p / units))
        return np.asarray(problem.unbalanced_forces(friction) / (units * scale))

    from scipy.optimize import root

    solution = root(residual, np.asarray(start, dtype=float) * units, method="hybr", options=HYBRID)
    q = np.asarray(solution.x / units)
    motion = problem.contact_motions_at(q)
    friction = law(problem.contacts, motion)
    left = float(np.max(np.abs(problem.unbalanced_forces(friction) / units)))
    return BodyMotion(
        unknown_velocities=q,
        contact_motions=motion,
        friction=friction,
        sticking_contacts=np.zeros(motion.shape[0], dtype=bool),
        imbalance=left,
        status="exact" if left <= 1e-8 * scale else "failed",
        steps=int(solution.nfev),
    )


def motion_by_sigmoid(problem: BodyMotionProblem, law: SigmoidLaw, start: Array) -> BodyMotion:
    """Return the motion of a body in force balance under Lin's sigmoid law, by `motion_by_root`.

    Where this direct search fails, the root is found over sigmoids of increasing sharpness: the root for each is the start
    of the next search; the last sigmoid is ``law``. This is not Lin's method, but it finds the roots that his table prints.
    After a failure the step in sharpness is reduced; if it becomes too small, the last motion is returned with the status
    "failed".

    Parameters
    ----------
    problem
        Contacts, kinematics and forces.
    law
        Lin's sigmoid.
    start
        Values of the unknowns ``(n,)`` from which the search begins.
    """
    direct = motion_by_root(problem, law, start)
    if direct.status == "exact":
        return direct
    share, factor, calls = 0.05, 1.4, 0
    q = np.asarray(start, dtype=float)
    while True:
        last = share >= 1.0
        current = law if last else replace(law, sharpness=share * law.sharpness, map_spacing=None)
        motion = motion_by_root(problem, current, q)
        calls += motion.steps
        if motion.status == "exact":
            if last:
                return replace(motion, steps=calls)
            q, factor = motion.unknown_velocities, min(1.4, factor * factor)
        else:
            share, factor = share / factor, float(np.sqrt(factor))
            if factor < 1.005:
                return replace(motion, steps=calls)
        share = min(1.0, share * factor)
