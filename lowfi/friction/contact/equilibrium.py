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

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from rollbench.lowfi.friction.contact.kernel_types import BallContactArrays, BallContactState
from rollbench.lowfi.friction.contact.laws import ContactFriction, EllipticalContacts, FrictionLaw, SigmoidLaw
from rollbench.lowfi.jit import CONTACT, load_kernel_package
from rollbench.meshes.arrays import Array, Mask

#: Largest unbalanced force, divided by the sum of all forces, at which the search for contact loads ends, and up to which
#: its result counts as converged.
GOAL, ACCEPTED = 1e-13, 1e-8
#: Largest number of Newton steps in the search for contact loads.
STEPS = 600


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


def zero_contact_state_arrays(cell: BallContactArrays) -> BallContactState:
    """Return zero arrays, in the sizes of ``cell``, for contact forces, stiffness and unbalanced forces by the kernels."""
    n, m = cell.interference.shape[0], cell.inner_body_forces.shape[0]
    return BallContactState(np.zeros((n, 2)), np.zeros(m), np.zeros((n, 4, 3)), np.zeros((n, 4)), np.zeros((n, 4, 2)))


def solve_contact_loads(
    cell: BallContactArrays,
    total_force: float,
    ball: Array,
    inner: Array,
    angles: Callable[[Array], Array],
    fast: bool = False,
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
        Displacements of the balls ``(N, 2)`` and of the inner body ``(m,)`` [m] from which the search begins; both are
        overwritten by the result.
    angles
        Function that computes contact angles ``(N, 4)`` [rad] from contact normals ``(N, 4, 2)``.
    fast
        Whether to use compiled kernels.
    """
    state = zero_contact_state_arrays(cell)
    kernels = load_kernel_package(CONTACT, compiled=fast)
    steps = int(kernels.minimise_energy(cell, total_force, ball, inner, state, GOAL, STEPS))
    unbalanced = (state.ball_unbalanced_forces, state.inner_unbalanced_forces)
    left = max(float(np.max(np.abs(forces), initial=0.0)) for forces in unbalanced)
    good = left <= ACCEPTED * (total_force + float(np.sum(state.force)))
    return ContactLoadSolution(state.force, angles(state.normal), ball, inner, left, steps, good)


def solve_contact_loads_of_each_ball(
    start: Array,
    interference: Array,
    C: Array,
    inner_direction: Array,
    applied_forces: Array,
    starting_displacements: Array,
    fast: bool = False,
) -> tuple[Array, Array, Array, Array]:
    """Return the contact loads of N independent balls, each between its own inner body and the fixed outer body.

    Parameters
    ----------
    start
        Vectors from the grooves' centres of curvature to the ball's centre along x, z, before any displacement ``(N, 4,
        2)`` [m].
    interference
        Interference of ball and groove before any displacement, negative for clearance ``(N, 4)`` [m].
    C
        Hertz constants C of the approach C F^(2/3) ``(N, 4)`` [m/N^(2/3)].
    inner_direction
        Direction along x, z in which the inner bodies move ``(2,)``.
    applied_forces
        Applied forces: on the ball along x, z, and on the inner body along its motion ``(N, 3)`` [N].
    starting_displacements
        Displacements of ball (x, z) and inner body from which the search begins ``(N, 3)`` [m].
    fast
        Whether to use compiled kernels.

    Returns
    -------
    tuple[Array, Array, Array, Array]
        Displacements of ball and inner body ``(N, 3)`` [m], contact loads ``(N, 4)`` [N], contact normals along x, z
        ``(N, 4, 2)``, and largest unbalanced force ``(N,)`` [N].
    """
    x, n = starting_displacements.copy(), len(starting_displacements)
    force, normal, left = np.zeros((n, 4)), np.zeros((n, 4, 2)), np.zeros(n)
    given_arrays = (np.ascontiguousarray(a, dtype=float) for a in (start, interference, C, inner_direction, applied_forces))
    kernels = load_kernel_package(CONTACT, compiled=fast)
    kernels.minimise_energy_of_each_ball(*given_arrays, x, force, normal, left, GOAL, STEPS)
    return x, force, normal, left


#: Values of ``BodyMotion.status``; the kernel returns their indices.
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

    def contact_motions_at(self, q: Array) -> Array:
        """Return the sliding and spin of the body at its m contacts ``(m, 3)`` for unknown velocities q ``(n,)``.

        The values for a contact are the sliding vx, vz along the semi-axes a, b [m/s] and the spin about the normal
        [rad/s].
        """
        return np.asarray(self.imposed_contact_motions + self.contact_motion_maps @ q)

    def surface_speed_per_unknown(self) -> Array:
        """Return the root of the sum of squares of the loaded contacts' sliding speeds per unit of each unknown ``(n,)``.

        The value is 1 for an unknown velocity that moves no loaded contact. Solvers scale the unknowns by these values.
        """
        one = np.ones_like(self.contacts.a)
        rows = self.contact_motion_maps * np.stack([one, one, self.contacts.a], axis=1)[:, :, None]
        size = np.sqrt(np.sum(rows[self.contacts.friction_bound > 0.0] ** 2, axis=(0, 1)))
        return np.asarray(np.where(size > 0.0, size, 1.0))

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
    #: Lower, then upper bound of the minimum, over all motions of the body, of the dissipated power less the power of the
    #: forces other than friction [W].
    dissipation_bounds: tuple[float, float]
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


def least_dissipation(problem: BodyMotionProblem, start: Array | None = None, fast: bool = False) -> BodyMotion:
    """Return the quasi-static motion of a body on frictional contacts: the motion of least dissipation.

    At this motion the dissipated power less the power of the forces other than friction is least, so that all forces are in
    balance. Unknowns that cause no dissipation keep their values at the start.

    Parameters
    ----------
    problem
        Contacts, kinematics and forces, with any number of loaded contacts.
    start
        Values of the unknowns ``(n,)`` from which the search begins; None to begin with the motion nearest to pure rolling.
    fast
        Whether to use compiled kernels.
    """
    at = problem.contacts
    m, n = at.a.shape[0], problem.contact_motion_maps.shape[2]
    q = np.zeros(n) if start is None else np.array(start, dtype=float)
    forces, rest, bounds = np.zeros((m, 3)), np.zeros(m), np.zeros(2)
    shape = np.column_stack([at.a, at.b, at.friction_bound])
    maps = np.ascontiguousarray(problem.contact_motion_maps, dtype=float)
    drives = np.ascontiguousarray(problem.imposed_contact_motions, dtype=float)
    push = np.ascontiguousarray(problem.other_forces, dtype=float)
    used = load_kernel_package(CONTACT, compiled=fast)
    begin = used.ROLLING if start is None else used.GIVEN
    code, left, steps = used.least_dissipation(shape, maps, drives, push, begin, q, forces, rest, bounds)
    total = float(np.sum(at.friction_bound))
    motion = problem.contact_motions_at(q)
    resting = rest > 0.0
    motion[resting] = 0.0
    return BodyMotion(
        unknown_velocities=q,
        contact_motions=motion,
        friction=ContactFriction(force=-forces[:, :2], moment=-forces[:, 2], loss=np.sum(forces * motion, axis=1)),
        sticking_contacts=resting,
        imbalance=float(left),
        dissipation_bounds=(float(bounds[0]), float(bounds[1])),
        status=STATUS[code] if left <= 1e-6 * total or code == 2 else "failed",
        steps=int(steps),
    )


def motion_without_friction_forces(motion: BodyMotion) -> BodyMotion:
    """Return the same motion of a body with friction forces and losses of zero.

    This is the limit for a coefficient of friction that tends to zero, because with given normal loads the motion does
    not depend on the coefficient.

    Parameters
    ----------
    motion
        Motion of a body with its friction forces.
    """
    f = motion.friction
    none = ContactFriction(np.zeros_like(f.force), np.zeros_like(f.moment), np.zeros_like(f.loss))
    return replace(motion, friction=none, imbalance=0.0, dissipation_bounds=(0.0, 0.0))


def motion_by_root(problem: BodyMotionProblem, law: FrictionLaw, start: Array, fast: bool = False) -> BodyMotion:
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
    fast
        Whether to use compiled kernels.
    """
    units = problem.surface_speed_per_unknown()
    scale = max(float(np.sum(problem.contacts.friction_bound)), 1e-300)

    def residual(p: Array) -> Array:
        """Return the unbalanced generalised forces over the sum of friction bounds, for scaled unknowns p ``(n,)``."""
        friction = law.friction(problem.contacts, problem.contact_motions_at(p / units), fast)
        return np.asarray(problem.unbalanced_forces(friction) / (units * scale))

    from scipy.optimize import root

    solution = root(residual, np.asarray(start, dtype=float) * units, method="hybr", options=HYBRID)
    q = np.asarray(solution.x / units)
    motion = problem.contact_motions_at(q)
    friction = law.friction(problem.contacts, motion, fast)
    left = float(np.max(np.abs(problem.unbalanced_forces(friction) / units)))
    loss = float(np.sum(friction.loss))
    return BodyMotion(
        unknown_velocities=q,
        contact_motions=motion,
        friction=friction,
        sticking_contacts=np.zeros(motion.shape[0], dtype=bool),
        imbalance=left,
        dissipation_bounds=(loss, loss),
        status="exact" if left <= 1e-8 * scale else "failed",
        steps=int(solution.nfev),
    )


def motion_by_sharpened_sigmoids(
    problem: BodyMotionProblem, law: SigmoidLaw, start: Array, fast: bool = False
) -> BodyMotion:
    """Return the motion of a body in force balance under Lin's sigmoid law, found over sigmoids of increasing sharpness.

    The root for each sigmoid is the start of the next search (`motion_by_root`); the last sigmoid is ``law``. This is
    not Lin's method, but it finds the roots that his table prints where the direct search fails. After a failure the
    step in sharpness is reduced; if it becomes too small, the last motion is returned with the status "failed".

    Parameters
    ----------
    problem
        Contacts, kinematics and forces.
    law
        Lin's sigmoid, the sharpest of the sequence.
    start
        Values of the unknowns ``(n,)`` from which the search begins.
    fast
        Whether to use compiled kernels.
    """
    share, factor, calls = 0.05, 1.4, 0
    q = np.asarray(start, dtype=float)
    while True:
        last = share >= 1.0
        current = law if last else replace(law, sharpness=share * law.sharpness, map_spacing=None)
        motion = motion_by_root(problem, current, q, fast)
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
