"""Outer iteration of the static models, which updates Hertz constants and lever arms until they no longer change.

Hertz constants depend on the actual contact angle. Lever arms of the contact forces depend on the contact point if flanks
are not circular arcs. The equilibrium is solved again after each update. The iteration is the same for a single nut or
bearing and for several on one shaft.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any, NamedTuple, Self, TypeVar

import numpy as np

from rollbench.lowfi.statics.contact_law import SIGNS
from rollbench.lowfi.statics.contacts import hertz_at_contact_angles
from rollbench.lowfi.statics.equilibrium import (
    CONVERGED,
    ITERATIONS,
    NOT_HELD,
    SINGULAR,
    EquilibriumTask,
    ForceState,
    Limits,
    Outcome,
    StaticSystem,
)
from rollbench.lowfi.statics.problem import ContactState, Problem
from rollbench.lowfi.statics.result import SolverReport, Status
from rollbench.lowfi.together import Search
from rollbench.meshes.arrays import Array

#: Formulation of a solution, as the record of a result states it.
FORMULATION = "convex energy, bodies condensed to the contacts"
#: Outcomes of the solver after which the state gives no contact loads.
NO_LOADS = (NOT_HELD, SINGULAR)
#: Largest unbalanced force, relative to the largest force, up to which a solution counts as converged.
ACCEPTED = 1e-10
#: Relative residual of a solve above which it counts as failed, so that Hertz constants and lever arms are not updated.
LOST = 1e-6
#: Relative round-off error of the motions from which a contact force is computed: that of about eight operations.
ROUND_OFF = 8.0 * float(np.finfo(float).eps)
#: Largest number of updates of Hertz constants and of lever arms, and the change of Hertz constants (relative) or lever
#: arms [m] below which no further update follows.
HERTZ_RUNS, ARM_RUNS, SETTLED = 12, 6, 1e-13
#: Largest number of updates of the typical contact force, and the relative change below which no further update follows.
FORCE_RUNS, FORCE_SETTLED = 8, 1e-3
#: Smallest typical contact force as a share of the mean force of the loaded contacts. Terms with the logarithm of the force
#: are replaced by their tangent in its cube root at the typical force. The tangent is 8 % of their slope off at three times
#: the typical force, and off without limit beyond.
LEAST_SHARE = 1.0 / 3.0


class ResidualScale(NamedTuple):
    """Typical force and stiffness of the contacts, to which the static solver relates residuals and tolerances.

    Numbers, or arrays ``(M,)`` for M specimens.
    """

    #: Force of a typical loaded contact [N]: from loads, interference or a solution; without any of them, the force at an
    #: approach of 1 um.
    typical_force: Any
    #: Secant stiffness of a contact under the force ``typical_force`` [N/m].
    stiffness: Any
    #: Lower bound of the force [N] by which residuals are divided: the largest external load (moments divided by the lever
    #: arm), or the contact force of the tightest ball without load.
    least_force_scale: Any
    #: Force [N] below which a contact counts as unloaded.
    unloaded_force_limit: Any

    @property
    def typical_force_for_ellipse(self) -> Any:
        """Return the force of a typical loaded contact [N], at least 1e-6 N, at which contact ellipses are evaluated.

        Compliance terms that depend on the size of the contact ellipse are evaluated at the ellipse under this force.
        """
        return np.maximum(self.typical_force, 1e-6)


def limits_of(scale: ResidualScale, furthest: float) -> Limits:
    """Return the limits of the solver's iteration for one member.

    Parameters
    ----------
    scale
        Typical contact force and stiffness of the problem.
    furthest
        Largest motion of a flank that one Newton step may cause [m]; longer steps are shortened. Callers pass the radius of
        the largest ball.
    """
    return Limits(np.array([scale.stiffness]), np.array([scale.least_force_scale]), np.array([furthest]))


@dataclass(kw_only=True)
class StaticEquations(ABC):
    """Equations of one or several bearings and nuts, with the state of the solver's iteration."""

    #: Bodies and rolling elements as one member for the solver.
    system: StaticSystem
    #: Present state of the iteration; before the first solve there is none.
    _state: ForceState | None = None
    #: Force by which the residual of the last solve was divided [N]: the largest force in the model, or a lower limit.
    residual_force_scale: float = 0.0

    @property
    def state(self) -> ForceState:
        """Present state of the iteration."""
        assert self._state is not None
        return self._state

    def solve_by_newton(self, from_linear: bool = True) -> Search[Outcome]:
        """Solve the equilibrium by Newton's method while Hertz constants and lever arms stay constant.

        Parameters
        ----------
        from_linear
            Whether to start from the solution with linear springs in place of the contacts; otherwise from the present
            state.
        """
        outcome: Outcome
        self._state, outcome = yield EquilibriumTask(self.system, None if from_linear else (self.state.phi, self.state.a))
        self.residual_force_scale = outcome.scale
        return outcome

    @property
    @abstractmethod
    def problems(self) -> Sequence[Problem]:
        """Return the contact problem of each bearing and nut, whose array of Hertz constants the solver reads."""

    @abstractmethod
    def contact_states(self) -> Sequence[ContactState]:
        """Return contact forces, ball centres and flank motions of each bearing and nut, as the iteration has them now."""

    @abstractmethod
    def with_lever_arms(self, arms: Sequence[Array]) -> Self:
        """Return equations with new lever arms of the contact forces, which start from the present state.

        Parameters
        ----------
        arms
            For each bearing or nut with N balls, the shifts ``(N, 4, 2)`` [m] of the flanks' centres of curvature by
            profile errors; contact forces act through these centres.
        """

    def at_forces_of_solution(self) -> Self:
        """Return equations whose typical contact force fits the present state, from which their next solution starts.

        The same equations are returned if they do already, or if no term of their contact law depends on this force.
        """
        return self

    @abstractmethod
    def round_off_residual(self) -> float:
        """Return the relative residual that rounding errors of double precision leave at the solution."""

    def start_from(self, of: StaticEquations) -> Self:
        """Return these equations with the state of others of the same size, from which the next solve can start."""
        self._state = of.state
        return self


P = TypeVar("P", bound=StaticEquations)


def contact_angles(normal: Array) -> Array:
    """Return the contact angles ``(..., 4)`` [rad] of unit normals ``(..., 4, 2)`` that point from ball to groove.

    The angle counts from the radial direction at the groove's bottom towards the flank, for the four flanks (screw left,
    screw right, nut left, nut right).
    """
    return np.asarray(np.arctan2(SIGNS[:, 1] * normal[..., 1], SIGNS[:, 0] * normal[..., 0]))


def least_typical_force(forces: Array) -> float:
    """Return the least typical contact force [N] for a solution with the contact forces ``forces`` [N]; 0 without any.

    It is the share `LEAST_SHARE` of the mean of all forces above zero.
    """
    loaded = forces[forces > 0.0]
    return LEAST_SHARE * float(loaded.mean()) if loaded.size else 0.0


def is_solve_unusable(outcome: Outcome) -> bool:
    """Return whether a solve failed so badly that its last state is no basis for new Hertz constants and lever arms.

    The contact loads of such a state have no meaning.

    ``outcome``: status and relative residual of the solve.
    """
    return outcome.status in NO_LOADS or outcome.residual > LOST


def is_solve_accepted(outcome: Outcome, round_off_residual: float) -> bool:
    """Return whether a solve found the equilibrium, as exactly as ``round_off_residual`` allows."""
    return outcome.residual <= max(ACCEPTED, round_off_residual) and outcome.status in (CONVERGED, ITERATIONS)


def solve_with_updated_contacts(system: P, follow_profile_errors: bool = True) -> Search[tuple[P, Outcome]]:
    """Solve the equilibrium again and again with updated properties of the contacts, until they no longer change.

    These are the typical contact force, Hertz constants and lever arms.

    Parameters
    ----------
    system
        Equations to solve. Hertz constants are updated only if the scene's ``hertz`` is "actual".
    follow_profile_errors
        Whether lever arms are updated for flanks that are not circular arcs.

    Returns
    -------
    tuple[P, Outcome]
        The equations at the last state, and status, residual and effort of the solver.
    """
    system, outcome = yield from update_typical_force(system, (yield from system.solve_by_newton()))
    if system.problems and system.problems[0].scene.ingredients.hertz == "actual":
        outcome = yield from update_hertz_constants(system, outcome)
    if follow_profile_errors and any(map(has_profile_errors, system.problems)):
        return (yield from update_lever_arms(system, outcome))
    return system, outcome


def residual_by_round_off(motions: float, stiffness: float, scale: float, problems: Iterable[Problem]) -> float:
    """Return the relative residual that rounding errors of double precision leave at the solution.

    It is eight machine epsilons times the largest length from which contact approaches are computed, times the stiffness of
    the stiffest contact or node, divided by the force ``scale``.

    Parameters
    ----------
    motions
        Largest motion of a body or flank [m]. For flanks that are not circular arcs, the ball's radius is added to it here.
    stiffness
        Stiffness of the stiffest contact or node [N/m].
    scale
        Force [N] by which the residual force is divided: the largest force in the model; with 0 the result is 0.
    problems
        Contact problems of the bearings and nuts.
    """
    radius = max((p.scene.balls.radius for p in problems if p.drawn.profile_coefficients.shape[1]), default=0.0)
    return ROUND_OFF * (motions + radius) * stiffness / scale if scale else 0.0


def status_of_solve(
    outcome: Outcome, round_off_residual: float, prove_status: Callable[[], Status], moved_too_far: bool = False
) -> Status:
    """Return the status of a solve: "converged", or else the kind of failure with its reason.

    Parameters
    ----------
    outcome
        Status, residual and effort of the solver.
    round_off_residual
        Relative residual that rounding errors leave.
    prove_status
        Function that decides by a linear program whether a body can move without limit, and returns the status.
    moved_too_far
        Whether the bodies moved so far that ``prove_status`` has to decide although the solver converged.
    """
    good = is_solve_accepted(outcome, round_off_residual)
    if good and not moved_too_far:
        return Status("converged")
    if outcome.status == NOT_HELD:
        return prove_status()
    if moved_too_far and (status := prove_status()).kind == "not held":
        return status
    if good:
        return Status("converged")
    if outcome.status == SINGULAR:
        return Status("stopped", "the stiffness matrix is not positive definite")
    reason = f"relative residual {outcome.residual:.1e} after {outcome.iterations} iterations"
    return Status("not converged", reason)


def solver_report(
    outcome: Outcome, system: StaticEquations, elements: int, times: tuple[float, float], notes: tuple[str, ...]
) -> SolverReport:
    """Return the record of effort and accuracy of a solve.

    Parameters
    ----------
    outcome
        Status, residual and effort of the solver.
    system
        Solved equations.
    elements
        Number of beam elements.
    times
        Times at which the computation began and at which its equations were ready (`time.perf_counter`) [s].
    notes
        Sentences on special events during the solve, such as a second solve with more flanks.
    """
    return SolverReport(
        iterations=outcome.iterations,
        evaluations=outcome.evaluations,
        residual=outcome.residual,
        seconds=perf_counter() - times[0],
        unknowns=system.state.phi.size + system.state.a.size,
        elements=elements,
        formulation=FORMULATION,
        round_off_bound=system.round_off_residual(),
        setup_seconds=times[1] - times[0],
        notes=notes,
    )


def update_typical_force(system: P, outcome: Outcome) -> Search[tuple[P, Outcome]]:
    """Take the typical contact force from the solution and solve again, until it no longer changes.

    Returns the equations with the last typical force at their solution, and the outcome of the last solve.

    Parameters
    ----------
    system
        Solved equations.
    outcome
        Outcome of the solve of these equations.
    """
    for _ in range(FORCE_RUNS):
        if is_solve_unusable(outcome):
            break
        before, system = system, system.at_forces_of_solution()
        if system is before:
            break
        outcome = add_iteration_counts(outcome, (yield from system.solve_by_newton(False)))
    return system, outcome


def update_hertz_constants(system: StaticEquations, outcome: Outcome) -> Search[Outcome]:
    """Update the Hertz constants to the actual contact angles and solve again, until they no longer change.

    Returns the outcome of the last solve, with the iterations of all solves added up. The equations ``system`` then hold
    the state of the last solve.

    Parameters
    ----------
    system
        Solved equations.
    outcome
        Outcome of the solve of these equations.
    """
    for _ in range(HERTZ_RUNS):
        if is_solve_unusable(outcome):
            break
        change = 0.0
        for state in system.contact_states():
            problem, nominal = state.problem, state.problem.scene.track.contact_angle
            gamma = np.where(state.force > 0.0, contact_angles(state.normal), nominal)
            updated = hertz_at_contact_angles(problem.scene, problem.drawn, gamma).C
            change = max(change, float(np.abs(updated / problem.C - 1.0).max()))
            problem.C[:] = updated
        outcome = add_iteration_counts(outcome, (yield from system.solve_by_newton(False)))
        if change < SETTLED:
            break
    return outcome


def update_lever_arms(system: P, outcome: Outcome) -> Search[tuple[P, Outcome]]:
    """Update the lever arms of the contact forces and solve again, until they no longer change.

    A contact force acts through the centre of curvature of the flank at the contact point. If the flank deviates from a
    circular arc, this centre shifts by about the size of the deviation. Returns the equations with the last lever arms at
    their solution, and the outcome of the last solve.

    Parameters
    ----------
    system
        Solved equations.
    outcome
        Outcome of the solve of these equations.
    """
    before = [np.zeros((*p.C.shape, 2)) for p in system.problems]
    for _ in range(ARM_RUNS):
        if is_solve_unusable(outcome):
            break
        arms = [curvature_centre_shifts(s) for s in system.contact_states()]
        change = max(float(np.abs(x - y).max()) for x, y in zip(arms, before, strict=True))
        before, system = arms, system.with_lever_arms(arms)
        outcome = add_iteration_counts(outcome, (yield from system.solve_by_newton(False)))
        if change < SETTLED:
            break
    return system, outcome


def has_profile_errors(problem: Problem) -> bool:
    """Return whether profile errors of the flanks change the lever arms of the contact forces of a bearing or nut.

    They do if flanks are not circular arcs, unless the scene's ``arm`` is "nominal": lever arms then end at the nominal
    contact points.
    """
    return problem.drawn.profile_coefficients.shape[1] > 0 and problem.scene.ingredients.arm != "nominal"


def curvature_centre_shifts(contact_state: ContactState) -> Array:
    """Return the shift of the flank's centre of curvature by profile errors, at each loaded contact.

    It is the vector from the centre of the nominal groove arc to the centre of curvature of the flank with its profile
    errors, in the ball's section plane. ``contact_state``: contacts, ball centres and flank motions of one bearing or nut
    with N balls.

    Returns
    -------
    Array
        ``(N, 4, 2)`` [m]; zero for circular arcs and unloaded contacts.
    """
    force, normal = contact_state.force, contact_state.normal
    if not has_profile_errors(contact_state.problem):
        return np.zeros(normal.shape)
    w = -contact_state.problem.drawn.groove_centres + contact_state.ball_centres[:, None, :] - contact_state.flank_motions
    with np.errstate(divide="ignore", invalid="ignore"):
        radius = np.where(force > 0.0, force / contact_state.tangential, 0.0)
    return np.where(force[..., None] > 0.0, w - normal * radius[..., None], 0.0)


def add_iteration_counts(first: Outcome, then: Outcome) -> Outcome:
    """Return the outcome of the second of two solves, with the iterations and evaluations of both added up.

    ``first``, ``then``: outcomes of the first and the second solve.
    """
    return then._replace(iterations=first.iterations + then.iterations, evaluations=first.evaluations + then.evaluations)
