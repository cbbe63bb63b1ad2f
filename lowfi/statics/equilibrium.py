"""Static equilibrium of rolling elements between elastic bodies: Newton's method on the contact forces of many members.

The bodies are given by their compliance G: the motion of the groove flank at every contact by the force on every other
contact. The flanks move by v = v0 + G phi + R a. Here v0 is the motion by external loads and prescribed displacements, phi
are the forces on the flanks, and a are the amplitudes of the free motions R: motions of a body that only the contacts
resist. The rolling elements exert the forces f(v) on the flanks; at the solution phi = f(v). With the stiffness S^T S of
the elements, a Newton step solves for u

    (I + S G S^T) u - S R da = S G (f - phi),    (S R)^T u + s da = work + R^T f,    dphi = f - phi - S^T u.            (1)

This minimises the convex energy phi G phi/2 - work a + (energy of the elements at v), regularised by a stiffness s of the
free motions that is proportional to the residual and therefore vanishes at the solution. The motions of a beam's nodes are
not among the unknowns. Where G is that of a long beam only, (1) is solved by its sparse stiffness matrix instead
(`BeamBodies`).

All members (specimens, load cases) of one model are worked at once; axes as in `lowfi.statics.rolling_elements`. A member
that has ended leaves the iteration.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, Self

import numpy as np

from rollbench.lowfi.statics.rolling_elements import (
    ElementForces,
    Ints,
    RollingElements,
    Stacked,
    field_names,
    forces_of_elements,
    stiffness_factors,
)
from rollbench.lowfi.together import Task
from rollbench.meshes.arrays import Array, Mask

#: Function from vectors ``(n, c)`` to their products with a matrix.
Matrix = Callable[[Array], Array]
#: How an iteration ended: converged, too many iterations, body moved without limit, stiffness not positive definite.
CONVERGED, ITERATIONS, NOT_HELD, SINGULAR = range(4)
#: Net contact force on a ball, as a fraction of the largest force in the model, up to which the ball is in equilibrium.
BALANCED = 1e-10
#: Largest unbalanced force, relative to the largest force, at which the solver stops.
TOLERANCE = 1e-14
#: A body counts as not held if no equilibrium lies within ``PLAY`` [m] plus the largest motion; a state ``FAR`` times that
#: distance away proves it. Singular values, relative to the largest, up to which a motion moves no loaded contact.
PLAY, FAR, UNMOVED = 1.0, 100.0, 1e-12
#: Largest number of Newton iterations of one solve.
MAX_ITERATIONS = 3000
#: Stiffness added to the free motions, as a fraction of that of a typical contact times the residual; number of larger
#: ones, each a hundred times the one before, that are tried until the equations count as singular.
ADDED, SHIFTS = 1e-3, 12
#: Relative round-off of an energy, which is a sum of positive and negative terms.
ROUNDING = 1e-14
#: Largest number of step lengths tried in one line search. On a convex energy it is not reached; the iteration ends when it
#: is reached a second time.
TRIALS = 60
#: Relative residual below which the whole Newton step is tried first, and the growth of the residual by which such a step
#: is rejected and replaced by a line search.
WHOLE_STEPS, GROWN = 1e-7, 10.0
#: Relative residual below which the state counts as the solution if the next step, even with a line search, makes the
#: residual grow by the factor ``GROWN``.
SOLVED = 1e-10
#: Number of iterations without halving the residual after which the iteration ends: in general, near the solution, and at
#: round-off. Near the solution is judged by the applied loads.
PATIENCE, PATIENCE_NEAR, PATIENCE_LAST = 100, 10, 2
#: Relative residuals below which the state counts as near the solution, and as exact to round-off.
NEAR, LAST = 1e-9, 1e-12
#: Relative decrease of the energy that counts as progress of an iteration.
FALLS = 1e-6
#: Largest number of coefficients of the matrices (1) of one block of members, 128 MB.
BLOCK = 2**24
#: Largest number of members of a block.
MEMBERS = 64


#: Largest number of conjugate gradients, and error relative to the solution, in the norm of the energy, at which they end.
GRADIENTS, GRADIENTS_END = 12, 1e-13

#: Compliance of bodies without any, for `Compliances`.
RIGID = np.zeros((1, 0, 0))


@dataclass(frozen=True)
class FreeMotions(Stacked):
    """Motions of the flanks that do not depend on the contact forces, for elements with F flanks."""

    #: Motions ``(M, N, F, 2)`` [m] of the flanks by external loads and prescribed displacements.
    v0: Array
    #: Motions ``(M, N, F, 2, k)`` of the flanks per metre of each free rigid motion, which only the contacts resist.
    R: Array
    #: Work ``(M, k)`` [N] of the external loads on the free motions, per metre of amplitude.
    work: Array

    def motions(self, a: Array) -> Array:
        """Return the motions R a of the flanks for the amplitudes a ``(M, k)`` [m]."""
        return np.asarray((self.R * a[:, None, None, None, :]).sum(axis=-1))

    def loads(self, f: Array) -> Array:
        """Return the loads R^T f ``(M, k)`` [N] on the free motions by forces f ``(M, N, F, 2)`` on the flanks."""
        return np.asarray((self.R * f[..., None]).sum(axis=(1, 2, 3)))


@dataclass(frozen=True)
class Compliances(Stacked):
    """Compliance matrices ``(M, ...)`` [m/N] of one body, or of two that share no flank.

    ``second`` None: there is one body for all flanks; `RIGID`: the second does not deform.
    """

    first: Array
    second: Array | None = None

    def of_flanks(self, of: Array) -> list[tuple[Array, slice]]:
        """Return each matrix with the flanks to which it belongs; ``of`` ``(M, N, F, 2)``: any array over the flanks."""
        half = of.shape[2] // 2
        if self.second is None:
            return [(self.first, slice(of.shape[2]))]
        bodies = (self.first, slice(half)), (self.second, slice(half, None))
        return [(G, flanks) for G, flanks in bodies if G.size]


@dataclass(frozen=True)
class DenseBodies(Stacked):
    """Elastic bodies with one compliance matrix for each group of flanks that can move together.

    Two bodies that do not touch each other, screw and nut, have a matrix each; the relative motion of a flank pair has one.
    """

    free: FreeMotions
    #: Compliance matrices ``(M, N F_i 2, N F_i 2)`` of the first and the second half of the F flanks, or of all.
    compliances: Compliances

    def motions_by_forces(self, phi: Array) -> Array:
        """Return the motions G phi ``(M, N, F, 2)`` [m] by forces ``phi`` on the flanks [N]."""
        out = np.zeros_like(phi)
        for G, flanks in self.compliances.of_flanks(phi):
            part = phi[:, :, flanks]
            flat = part.reshape(len(part), -1)
            moved = flat @ G[0] if len(G) == 1 else (G @ flat[..., None])[..., 0]
            out[:, :, flanks] = moved.reshape(part.shape)
        return out

    def solve(self, S: Array, b: Array) -> Array:
        """Return (I + S G S^T)^-1 b ``(M, q, c)`` with q = N w for the factors S ``(M, N, w, F, 2)``."""
        members, count, width = S.shape[:3]
        matrix = np.zeros((members, count, width, count * width))
        for G, flanks in self.compliances.of_flanks(S[:, :, 0]):
            of_body = np.ascontiguousarray(S[:, :, :, flanks]).reshape(members, count, width, -1)
            size = of_body.shape[3]
            moved = of_body @ G.reshape(len(G), count, size, -1)  # S G: (M, N, w, N size)
            by_element = moved.reshape(members, count * width, count, size).transpose(0, 2, 1, 3) @ of_body.swapaxes(2, 3)
            matrix += by_element.transpose(0, 2, 1, 3).reshape(matrix.shape)
        A = matrix.reshape(members, count * width, -1)
        A[:, np.arange(count * width), np.arange(count * width)] += 1.0
        return solved_or_nan(A, b)


def solved_or_nan(A: Array, b: Array) -> Array:
    """Return A^-1 b for a stack of matrices ``(M, q, q)`` and right-hand sides ``(M, q, c)``; nan where A is singular."""
    try:
        return np.asarray(np.linalg.solve(A, b))
    except np.linalg.LinAlgError:
        if len(A) == 1:
            return np.full(np.broadcast_shapes(b.shape, (1, 1, 1)), np.nan)
        return np.concatenate([solved_or_nan(A[i : i + 1], b[i : i + 1]) for i in range(len(A))])


def positive_definite(A: Array) -> Mask:
    """Return which matrices of a stack ``(M, k, k)`` are positive definite ``(M,)``."""
    if not np.isfinite(A).all():
        finite: Mask = np.asarray(np.isfinite(A).all(axis=(1, 2)))
        finite[finite] = positive_definite(A[finite])
        return finite
    try:
        np.linalg.cholesky(A)
    except np.linalg.LinAlgError:
        if len(A) == 1:
            return np.zeros(1, dtype=bool)
        return np.concatenate([positive_definite(A[i : i + 1]) for i in range(len(A))])
    return np.ones(len(A), dtype=bool)


@dataclass(frozen=True)
class BeamBodies(Stacked):
    """Rigid bodies on a beam or frame with a sparse stiffness matrix, of one member: G = L K^-1 L^T.

    Its Newton step (1) needs the matrix K + (S L)^T S L, whose band is narrow, in place of the dense I + S G S^T.
    """

    free: FreeMotions
    #: Stiffness matrix K of the frame's free degrees of freedom, sparse.
    K: Any
    #: Motions L of the flanks ``(N F 2, degrees of freedom)`` per motion of each degree of freedom, sparse.
    L: Any
    #: Function that returns the motions K^-1 p of the degrees of freedom under loads p on them ``(degrees of freedom,)``.
    #: It must be the one that gives the motions of the solution: on very short elements two factors of K differ by more
    #: than the contacts' round-off.
    motions_under_loads: Callable[[Array], Array]
    #: Function that returns the loads K q on the degrees of freedom that their motions q need ``(degrees of freedom, c)``,
    #: from the deformations of the elements: on short elements it is far more accurate than the product with K.
    loads_of_motions: Callable[[Array], Array]

    def motions_by_forces(self, phi: Array) -> Array:
        """Return the motions G phi ``(1, N, F, 2)`` [m] by forces ``phi`` on the flanks [N]."""
        if not self.K.shape[0]:
            return np.zeros_like(phi)
        return np.asarray(self.L @ self.motions_under_loads(self.L.T @ phi.ravel())).reshape(phi.shape)

    def solve(self, S: Array, b: Array) -> Array:
        """Return (I + S G S^T)^-1 b ``(1, q, c)`` with q = N w for the factors S ``(1, N, w, F, 2)``.

        The factor of K + (S L)^T S L has the round-off of K, which stiff contacts multiply: on a shaft of 2.5 m with 4,000
        elements Newton's steps would be of the wrong length. So the factor is a preconditioner only.
        """
        from scipy.sparse import bsr_array
        from scipy.sparse.linalg import splu

        if not self.K.shape[0]:
            return b
        count, width = S.shape[1:3]
        blocks, at = S.reshape(count, width, -1), np.arange(count)
        SL = bsr_array((blocks, at, np.arange(count + 1)), shape=(count * width, self.L.shape[0])).tocsr() @ self.L
        A, how = (self.K + SL.T @ SL).tocsc(), {"SymmetricMode": True}
        factor = splu(A, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=how)

        def precondition(x: Array) -> Array:
            return np.asarray(factor.solve(np.asfortranarray(x)))

        q = by_conjugate_gradients(lambda q: self.loads_of_motions(q) + SL.T @ (SL @ q), precondition, SL.T @ b[0])
        return np.asarray(b - (SL @ q)[None])


def by_conjugate_gradients(operator: Matrix, precondition: Matrix, b: Array) -> Array:
    """Return the solutions ``(n, c)`` of A x = b for c right-hand sides, by conjugate gradients from a close approximation.

    ``operator``: x to A x, of a positive definite matrix A; ``precondition``: b to nearly A^-1 b.
    """
    x = precondition(b)
    r = b - operator(x)
    z = precondition(r)
    p, size = z, (r * z).sum(axis=0)
    enough = GRADIENTS_END**2 * np.abs((b * x).sum(axis=0))
    for _ in range(GRADIENTS):
        if (size <= enough).all():
            break
        moved = operator(p)
        work = (p * moved).sum(axis=0)
        step = np.where((size > enough) & (work > 0.0), size / np.where(work > 0.0, work, 1.0), 0.0)
        x, r = x + step * p, r - step * moved
        z, last = precondition(r), size
        size = np.where(step > 0.0, (r * z).sum(axis=0), 0.0)
        p = z + size / np.where(last > 0.0, last, 1.0) * p
    return x


@dataclass(frozen=True)
class Limits(Stacked):
    """Typical values and limits of the iteration of each member ``(M,)``."""

    #: Stiffness of a typical contact [N/m], by which the stiffness added to free motions is scaled.
    stiffness: Array
    #: Lower bound of the force [N] by which unbalanced forces are divided.
    least_force: Array
    #: Largest motion of a flank in one step [m]: the largest ball's radius.
    furthest: Array
    #: Largest unbalanced force, relative to the largest force, at which the iteration ends.
    tolerance: float = TOLERANCE


@dataclass(frozen=True)
class StaticSystem(Stacked):
    """Elastic bodies with all balls and rollers between them."""

    bodies: DenseBodies | BeamBodies
    elements: RollingElements
    #: Factors ``(M, N, w, F, 2)`` of linear springs between opposite flanks, which replace the contacts in the first solve:
    #: square root of the stiffness times the direction of each spring; zero where there is no spring.
    springs: Array
    limits: Limits

    @property
    def block(self) -> int:
        """Largest number of members that are worked at once."""
        if isinstance(self.bodies, BeamBodies):
            return 1
        count, flanks = self.springs.shape[1], self.springs.shape[3]
        return int(max(1, min(MEMBERS, BLOCK // max(1, (2 * flanks * count) ** 2))))


@dataclass(frozen=True)
class ForceState(Stacked):
    """State of the iteration: unknowns, motions and forces that follow from them, and how far they are from balance."""

    #: Forces phi on the flanks ``(M, N, F, 2)`` [N], with which the bodies are in equilibrium.
    phi: Array
    #: Amplitudes ``(M, k)`` [m] of the free motions.
    a: Array
    #: Motions G phi, and all motions v of the flanks ``(M, N, F, 2)`` [m].
    elastic: Array
    motions: Array
    #: Forces of the elements at these motions.
    forces: ElementForces
    #: Energy of bodies, elements and loads ``(M,)`` [J].
    energy: Array


class Outcome(NamedTuple):
    """How the iteration of each member ended: arrays ``(M,)``, or numbers for one member."""

    #: Converged, too many iterations, body moved without limit, or singular stiffness: `CONVERGED` ... `SINGULAR`.
    status: Any
    #: Number of iterations, and of evaluations of the energy.
    iterations: Any
    evaluations: Any
    #: Largest unbalanced force as a fraction of ``scale``.
    residual: Any
    #: Force by which the residual was divided [N]: the largest force in the model, or a lower limit if that is larger.
    scale: Any

    def of_member(self, member: int) -> Outcome:
        """Return the outcome of one member."""
        return Outcome(*(x[member].item() for x in self))


def state_at(system: StaticSystem, phi: Array, a: Array) -> ForceState:
    """Return the state with the forces ``phi`` on the flanks and the amplitudes ``a`` of the free motions."""
    elastic = system.bodies.motions_by_forces(phi)
    return evaluated(system, phi, a, elastic, system.bodies.free.v0 + elastic + system.bodies.free.motions(a))


def evaluated(system: StaticSystem, phi: Array, a: Array, elastic: Array, motions: Array) -> ForceState:
    """Return the state with the forces of the elements and the energy at known motions of the flanks."""
    forces = forces_of_elements(system.elements, motions)
    energy = forces.energy + 0.5 * _dot(phi, elastic) - (a * system.bodies.free.work).sum(axis=1)
    return ForceState(phi, a, elastic, motions, forces, energy)


def _dot(x: Array, y: Array) -> Array:
    """Return the products ``(M,)`` of arrays ``(M, N, F, 2)`` summed over all but the members."""
    return np.asarray((x * y).sum(axis=(1, 2, 3)))


def unbalanced_forces(system: StaticSystem, state: ForceState) -> Array:
    """Return the largest unbalanced force ``(M,)`` [N]: on a flank, or on a free motion of the bodies."""
    free = system.bodies.free
    on_flanks = np.abs(state.forces.on_flanks - state.phi).max(axis=(1, 2, 3))
    on_motions = np.abs(free.work + free.loads(state.forces.on_flanks)).max(axis=1, initial=0.0)
    return np.asarray(np.maximum(on_flanks, on_motions))


def relative_motion(motions: Array) -> Array:
    """Return the largest motion ``(M,)`` [m] of a flank of the first body relative to the opposite one of the second."""
    half = motions.shape[2] // 2
    return np.asarray(np.abs(motions if half == 0 else motions[:, :, :half] - motions[:, :, half:]).max(axis=(1, 2, 3)))


class Step(NamedTuple):
    """Newton step: changes of forces, amplitudes, and of the motions G phi and v of the flanks."""

    phi: Array
    a: Array
    elastic: Array
    motions: Array


def factors_of_free_motions(free: FreeMotions, S: Array) -> Array:
    """Return the factors S R ``(M, N w, k)`` of the stiffness of elements against free motions; S ``(M, N, w, F, 2)``."""
    (members, count, width), k = S.shape[:3], free.R.shape[-1]
    by_element = S.reshape(members, count, width, -1)
    SR = by_element @ free.R.reshape(len(free.R), count, by_element.shape[3], k)
    return np.asarray(SR.reshape(members, count * width, k))


def solve_forces(
    bodies: DenseBodies | BeamBodies, S: Array, b: Array, target: Array, added: Array
) -> tuple[Array, Array, Mask]:
    """Solve (I + S G S^T) u - S R a = b, (S R)^T u + s a = target for u ``(M, N, w)`` and a ``(M, k)``.

    ``added`` ``(M,)``: stiffness s [N/m], increased by factors of a hundred until the equations for the free motions are
    positive definite. The third result tells which members are solved ``(M,)``.
    """
    SR = factors_of_free_motions(bodies.free, S)
    k, (members, count, width) = SR.shape[-1], S.shape[:3]
    x = bodies.solve(S, np.concatenate([b.reshape(members, -1, 1), SR], axis=2))
    u, Z = x[..., 0], x[..., 1:]
    good: Mask = np.asarray(np.isfinite(x).all(axis=(1, 2)))
    a = np.zeros((members, k))
    if k:
        schur, rest = SR.swapaxes(1, 2) @ Z, target - (SR.swapaxes(1, 2) @ u[..., None])[..., 0]
        schur = 0.5 * (schur + schur.swapaxes(1, 2))
        left, more = np.flatnonzero(good), added.copy()
        for _ in range(SHIFTS):
            now = schur[left] + more[left, None, None] * np.eye(k)
            fine = positive_definite(now)
            found = solved_or_nan(now[fine], rest[left[fine], :, None])[..., 0]
            fine[fine] = np.isfinite(found).all(axis=1)  # a matrix may be positive definite and yet singular in round-off
            a[left[fine]] = found[np.isfinite(found).all(axis=1)]
            left = left[~fine]
            if not left.size:
                break
            more[left] *= 100.0
        good[left] = False
        u = u + (Z @ a[..., None])[..., 0]
    return u.reshape(members, count, width), a, good


def small_response(bodies: DenseBodies | BeamBodies, S: Array, v: Array, work: Array) -> tuple[Array, Array] | None:
    """Return how one loaded member responds to c small load cases: the first-order changes of forces and free motions.

    Parameters
    ----------
    bodies
        Bodies, of one member.
    S
        Factors ``(1, N, w, F, 2)`` of the stiffness of the elements in the loaded state.
    v
        Motions ``(N, F, 2, c)`` [m] of the flanks by the load cases, without contact forces.
    work
        Work ``(k, c)`` [N] of the load cases on the free motions.

    Returns
    -------
    tuple[Array, Array] | None
        Forces ``(N, F, 2, c)`` [N] on the flanks, and amplitudes ``(k, c)`` [m]. None if nothing resists a free motion.
    """
    count, width = S.shape[1:3]
    of_flanks, k = S[0].reshape(count, width, -1), work.shape[0]
    R = bodies.free.R[0]
    Sv, SR = (of_flanks @ x.reshape(count, of_flanks.shape[2], x.shape[-1]) for x in (v, R))
    Sv, SR = (x.reshape(count * width, x.shape[-1]) for x in (Sv, SR))
    x = bodies.solve(S, np.concatenate([Sv, SR], axis=1)[None])[0]
    u, Z = x[:, : v.shape[-1]], x[:, v.shape[-1] :]
    schur = SR.T @ Z
    a = solved_or_nan(schur[None], (work - SR.T @ u)[None])[0] if k else work
    # a matrix may be positive definite and yet singular in round-off
    if not (positive_definite(0.5 * (schur + schur.T)[None])[0] and np.isfinite(a).all()):
        return None
    u = (u + Z @ a).reshape(count, width, v.shape[-1])
    return -(of_flanks.swapaxes(1, 2) @ u).reshape(v.shape), a


def newton_step(system: StaticSystem, state: ForceState, added: Array) -> tuple[Step, Mask]:
    """Return Newton's step (1) of all members, and which of them have one; ``added``: see `solve_forces`."""
    bodies, f = system.bodies, state.forces.on_flanks
    S, change = stiffness_factors(system.elements, state.forces), f - state.phi
    moved = bodies.motions_by_forces(change)
    b = (S * moved[:, :, None]).sum(axis=(3, 4))
    u, a, good = solve_forces(bodies, S, b, bodies.free.work + bodies.free.loads(f), added)
    change = change - (S * u[..., None, None]).sum(axis=2)
    elastic = bodies.motions_by_forces(change)
    return Step(change, a, elastic, elastic + bodies.free.motions(a)), good


def state_on_springs(system: StaticSystem) -> tuple[Array, Array]:
    """Return first guesses of forces and free motions: the equilibrium with linear springs in place of the contacts.

    The solution is scaled down such that no flank moves further from the opposite one than the limit. Where the loads
    without contact forces already move flanks further than that, as they do for a shaft that only the contacts support, ten
    times this motion is the limit. Zeros where the equations have no solution.
    """
    bodies, limits, members = system.bodies, system.limits, len(system.limits.furthest)
    free = bodies.free
    S = np.broadcast_to(system.springs, (members, *system.springs.shape[1:]))
    v0, work = (
        np.broadcast_to(free.v0, (members, *free.v0.shape[1:])),
        np.broadcast_to(free.work, (members, free.work.shape[1])),
    )
    u, a, good = solve_forces(bodies, S, (S * v0[:, :, None]).sum(axis=(3, 4)), work, 1e-9 * limits.stiffness)
    phi = -(S * u[..., None, None]).sum(axis=2)
    v = v0 + bodies.motions_by_forces(phi) + free.motions(a)
    alone = relative_motion(v0)
    furthest = np.where(alone <= limits.furthest, limits.furthest, 10.0 * alone)
    far = relative_motion(v) > furthest
    shorter = np.where(far, furthest / np.maximum(relative_motion(v - v0), furthest), 1.0)
    shorter = np.where(good, shorter, 0.0)
    return np.nan_to_num(phi) * shorter[:, None, None, None], np.nan_to_num(a) * shorter[:, None]


def find_equilibrium(system: StaticSystem, start: tuple[Array, Array] | None = None) -> tuple[ForceState, Outcome]:
    """Return the equilibrium of all members, and how their iterations ended.

    Parameters
    ----------
    system
        Bodies and rolling elements.
    start
        Forces on the flanks ``(M, N, F, 2)`` [N] and amplitudes of free motions ``(M, k)`` [m] from which to iterate; None:
        the equilibrium with springs in place of the contacts.
    """
    members, parts = np.arange(len(system.limits.furthest)), []
    for first in range(0, members.size, system.block):
        some = members[first : first + system.block]
        of = system if some.size == members.size else system.take(some)
        begin = state_on_springs(of) if start is None else (start[0][some], start[1][some])
        parts.append(_minimise(of, state_at(of, *begin)))
    if len(parts) == 1:
        return parts[0]
    states, outcomes = zip(*parts, strict=True)
    return stacked(states), Outcome(*(np.concatenate(x) for x in zip(*outcomes, strict=True)))


def stacked(records: Any) -> Any:
    """Return records of consecutive members as one record; what is neither an array nor a record is equal in all."""
    first = records[0]
    if isinstance(first, np.ndarray):
        return np.concatenate(records)
    if not isinstance(first, Stacked):
        return first
    return type(first)(**{name: stacked([getattr(r, name) for r in records]) for name in field_names(first)})


class EquilibriumTask(Task):
    """Task to find the equilibrium of a system of one member; tasks with systems of equal form are members of one.

    Its result is the state, and how the iteration ended. It depends on the other members by round-off only.
    """

    def __init__(self, system: StaticSystem, start: tuple[Array, Array] | None) -> None:
        """Ask for the equilibrium of a ``system`` from a ``start``, see `find_equilibrium`."""
        self.system, self.start = system, start

    @cached_property
    def likeness(self) -> Hashable:
        """Value that is the same for systems of equal form; systems that are worked alone have one of their own."""
        return id(self) if self.system.block == 1 else None, self.start is None, _form(self.system)

    @classmethod
    def solve(cls, tasks: Sequence[Self]) -> list[tuple[ForceState, Outcome]]:
        """Return the state and the outcome of each task."""
        systems = [task.system for task in tasks]
        start: Any = tasks[0].start and tuple(map(np.concatenate, zip(*(task.start or () for task in tasks), strict=True)))
        state, outcome = find_equilibrium(systems[0] if len(systems) == 1 else stacked(systems), start)
        return [(state.take(np.array([i])), outcome.of_member(i)) for i in range(len(tasks))]


def _form(record: Any) -> Hashable:
    """Return the sizes of all arrays of a record, and its other values: records of equal form can be `stacked`."""
    if isinstance(record, np.ndarray):
        return tuple(record.shape)
    if isinstance(record, Stacked):
        return (type(record), *(_form(getattr(record, name)) for name in field_names(record)))
    return record if isinstance(record, Hashable) else id(record)


def _minimise(system: StaticSystem, state: ForceState) -> tuple[ForceState, Outcome]:
    """Minimise the energy of a block of members by Newton's method with line search, from a state that is overwritten."""
    limits, count = system.limits, len(system.limits.furthest)
    tolerance, begin = limits.tolerance, limits.least_force.copy()
    begin = np.where(begin > 0.0, begin, 1e-3 * state.forces.largest)  # a final state may be free of forces
    scale = np.maximum(state.forces.largest, begin)
    residual = _relative(unbalanced_forces(system, state), scale)
    status, iterations = np.full(count, ITERATIONS), np.zeros(count, dtype=np.int64)
    evaluations, amount = np.ones(count, dtype=np.int64), np.full(count, ADDED)
    smallest, lowest = residual.copy(), state.energy.copy()
    stalled, exhausted = np.zeros(count, dtype=np.int64), np.zeros(count, dtype=np.int64)
    status[(residual <= tolerance) & (_loose(state, scale) <= BALANCED)] = CONVERGED
    left = np.flatnonzero(status != CONVERGED)
    for _ in range(MAX_ITERATIONS):
        if not left.size:
            break
        iterations[left] += 1
        of, now = (system, state) if left.size == count else (system.take(left), state.take(left))
        step, good = newton_step(of, now, amount[left] * of.limits.stiffness * np.minimum(1.0, residual[left]))
        if not good.all():
            status[left[~good]] = SINGULAR
            left, keep = left[good], np.flatnonzero(good)
            if not left.size:
                break
            of, now, step = system.take(left), state.take(left), Step(*(x[keep] for x in step))
        last = residual[left]
        new, found, rest, tried, falling = _search_along_step(of, now, step, last, begin[left])
        back = (tried > 0) & (last <= SOLVED) & (rest > GROWN * last)  # the state before was the solution to round-off
        kept = np.flatnonzero(~back)
        evaluations[left] += np.maximum(tried, 1)
        state.put(left[kept], new if kept.size == left.size else new.take(kept))
        left, tried, away = left[kept], tried[kept], falling[kept]
        scale[left], residual[left], energy = found[kept], rest[kept], new.energy[kept]
        amount[left] = np.maximum(ADDED, 0.1 * amount[left])
        done = (residual[left] <= tolerance) & (_loose(state, scale)[left] <= BALANCED)
        if away.any():
            at = left[away]
            away[away] = _moves_without_limit(system.take(at), state.take(at))
        status[left[away]], status[left[done]] = NOT_HELD, CONVERGED
        applied = np.where(limits.least_force[left] > 0.0, limits.least_force[left], scale[left])
        near = residual[left] * scale[left] / np.where(applied > 0.0, applied, 1.0)
        falls = lowest[left] - energy > FALLS * np.abs(energy)
        stalled[left] = np.where((residual[left] < 0.5 * smallest[left]) | falls, 0, stalled[left] + 1)
        exhausted[left] += tried >= TRIALS
        patience = np.where(residual[left] <= LAST, PATIENCE_LAST, np.where(near <= NEAR, PATIENCE_NEAR, PATIENCE))
        lowest[left] = np.where(falls, energy, lowest[left])
        smallest[left] = np.minimum(smallest[left], residual[left])
        left = left[~(done | away | (stalled[left] >= patience) | (exhausted[left] >= 2))]
    state = _with_less_round_off(system, state)
    loose = _loose(state, scale)
    residual = np.where(loose > BALANCED, np.maximum(residual, loose), residual)
    return state, Outcome(status, iterations, evaluations, residual, scale)


def _relative(force: Array, scale: Array) -> Array:
    """Return forces ``(M,)`` as fractions of ``scale`` [N]; in newtons where that is zero."""
    return np.asarray(force / np.where(scale > 0.0, scale, 1.0))


def _loose(state: ForceState, scale: Array) -> Array:
    """Return the largest net force on a ball of each member ``(M,)`` as a fraction of ``scale`` [N].

    It is zero where each ball touches two opposite flanks only, as their closed form keeps balls in equilibrium.
    """
    contacts = state.forces.contacts
    if contacts.force.shape[2] == 1:
        return np.zeros(len(scale))
    return _relative(contacts.net_forces.max(axis=1, initial=0.0), scale)


def _search_along_step(
    system: StaticSystem, state: ForceState, step: Step, residual: Array, begin: Array
) -> tuple[ForceState, Array, Array, Ints, Mask]:
    """Search the minimum of each member's energy along its Newton step.

    Near the solution the whole step is taken if the residual does not grow much. So it is, if the residual does not grow at
    all, where the energy that the step can gain is less than its round-off: forces phi between rigid bodies, for example,
    may be far from the contacts' while the energy is lowest. The search ends where the magnitude of the
    derivative along the step is sufficiently smaller than at its start, or at the largest step length. A longer step would
    carry flanks past their balls and give no information on the contacts.

    Parameters
    ----------
    system, state, step
        Bodies and elements, state at the start, and Newton step.
    residual
        Relative residual at the start ``(M,)``.
    begin
        Smallest force by which a residual is divided ``(M,)`` [N].

    Returns
    -------
    tuple[ForceState, Array, Array, Ints, Mask]
        State at the accepted point; the force by which its residual is divided [N]; the residual; the number of step
        lengths tried by the line search, 0 where the whole step was taken at once; and whether the energy still falls at
        the largest step length ``(M,)``.
    """
    count = len(residual)
    slope = _slope(system, state, step)
    reach = relative_motion(step.motions)
    limit = np.where(reach > 0.0, system.limits.furthest / np.where(reach > 0.0, reach, 1.0), 1e12)
    most = np.where(residual < WHOLE_STEPS, GROWN, 1.0) * np.maximum(residual, system.limits.tolerance)
    whole = (residual < WHOLE_STEPS) | (np.abs(slope) <= ROUNDING * np.abs(state.energy))
    whole &= limit >= 1.0
    t, low, high, tried = np.minimum(1.0, limit), np.zeros(count), np.zeros(count), np.zeros(count, dtype=np.int64)
    scale, rest, falling, found = np.zeros(count), np.zeros(count), np.zeros(count, dtype=bool), None
    left = np.arange(count)
    for _ in range(TRIALS):
        of, old, move = system, state, step
        if left.size < count:
            of, old, move = system.take(left), state.take(left), Step(*(x[left] for x in step))
        T = t[left, None, None, None]
        at = (
            old.phi + T * move.phi,
            old.a + T[..., 0, 0] * move.a,
            old.elastic + T * move.elastic,
            old.motions + T * move.motions,
        )
        trial = evaluated(of, *at)
        scale[left] = np.maximum(trial.forces.largest, begin[left])
        rest[left] = _relative(unbalanced_forces(of, trial), scale[left])
        at_once = whole[left] & (rest[left] <= most[left])
        whole[left] = False
        tried[left] += ~at_once
        if found is None:
            found = trial
        else:
            found.put(left, trial)
        up, begun, now = _slope(of, trial, move), slope[left], t[left]
        falling[left] = (up <= 0.0) & (now >= limit[left])
        lower = trial.energy <= old.energy + ROUNDING * np.abs(old.energy)
        descent = trial.energy <= old.energy + 1e-4 * now * begun
        beyond = (lower & (up <= 0.5 * np.abs(begun))) | (descent & (up <= 0.9 * np.abs(begun)))
        before = (up >= 0.9 * begun) | (high[left] > 0.0) | (now >= limit[left])
        ends = at_once | np.where(up > 0.0, beyond, before)
        back, on = left[~ends & (up > 0.0)], left[~ends & (up <= 0.0)]
        high[back] = t[back]
        t[back] = low[back] + np.where(low[back] > 0.0, 0.5, 0.35) * (high[back] - low[back])
        low[on] = t[on]
        t[on] = np.minimum(4.0 * t[on], limit[on])
        left = left[~ends]
        if not left.size:
            break
    assert found is not None
    return found, scale, rest, tried, falling


def _moves_without_limit(system: StaticSystem, state: ForceState) -> Mask:
    """Return which members are proven to have no equilibrium near their state ``(M,)``: up to which distance, see `PLAY`.

    The proof is the gradient g of the energy at a state y far away. As the energy is convex, it has no minimum at any x
    with g (y - x) < 0. This holds for every x whose free and elastic motions each differ from the present ones by no more
    than that distance, if at y the loads still drive the bodies and no contact has closed that stops them. The state y lies
    in the direction in which loads and contact forces drive those free motions that move no loaded contact.
    """
    free, f = system.bodies.free, state.forces.on_flanks
    drive = free.work + free.loads(f)
    _, size, V = np.linalg.svd(factors_of_free_motions(free, stiffness_factors(system.elements, state.forces)), False)
    V = V * (size > UNMOVED * size.max(axis=1, initial=0.0, keepdims=True))[..., None]
    way = drive - (V.swapaxes(1, 2) @ (V @ drive[..., None]))[..., 0]
    way = way / np.maximum(np.sqrt((way * way).sum(axis=1, keepdims=True)), 1e-300)
    moved = (np.abs(x).reshape(len(x), -1).max(axis=1, initial=0.0) for x in (state.a, state.elastic, free.v0))
    near = PLAY + np.max(np.broadcast_arrays(*moved), axis=0)
    there = forces_of_elements(system.elements, state.motions + free.motions((FAR * near)[:, None] * way)).on_flanks
    drive = free.work + free.loads(there)
    most = np.abs(drive).sum(axis=1) + np.abs(there - state.phi).sum(axis=(1, 2, 3))
    return np.asarray(FAR * (drive * way).sum(axis=1) > most)


def _slope(system: StaticSystem, state: ForceState, step: Step) -> Array:
    """Return the derivative of the energy by the length of the step ``(M,)`` [J]."""
    by_forces = _dot(step.phi, state.elastic) - _dot(state.forces.on_flanks, step.motions)
    return np.asarray(by_forces - (step.a * system.bodies.free.work).sum(axis=1))


def _with_less_round_off(system: StaticSystem, state: ForceState) -> ForceState:
    """Return the state with the contacts of those motions of the flanks that have less round-off.

    The motions are known in two ways: summed over all Newton steps, and computed anew from the contact forces as G phi. The
    latter have more round-off where bodies bend much under forces that almost cancel. The motions with the smaller residual
    are taken.
    """
    again = state_at(system, state.phi, state.a)
    better = np.flatnonzero(unbalanced_forces(system, again) <= unbalanced_forces(system, state))
    if better.size:
        state.put(better, again.take(better))
    return state
