"""Outer iteration of the static models: Hertz constants at the actual contact angle, lever arms on uneven flanks.

Both depend on the solved state, which is solved again until they no longer change; the same for one set and several.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from time import perf_counter
from types import ModuleType
from typing import Any, ClassVar, NamedTuple, Self, TypeVar

import numpy as np

from rollbench.lowfi import jit
from rollbench.lowfi.statics.contacts import actual_hertz
from rollbench.lowfi.statics.kernel.search import CONVERGED, ITERATIONS, NOT_HELD, SINGULAR
from rollbench.lowfi.statics.kernel_types import Options, Outcome
from rollbench.lowfi.statics.problem import SIGNS, Problem
from rollbench.lowfi.statics.result import SolverReport, Status
from rollbench.meshes.arrays import Array

#: Relative residual that the solver drives for.
TOLERANCE = 1e-14
MAX_ITERATIONS = 3000
#: Outcomes without a usable state.
NO_LOADS = (NOT_HELD, SINGULAR)
#: Relative residual at which a solution counts as converged.
ACCEPTED = 1e-10
#: Relative residual of a run above which its constants or lever arms are not followed any further.
LOST = 1e-6
#: Relative round-off of a force by that of the motions in its contacts: some operations of each.
ROUND_OFF = 8.0 * float(np.finfo(float).eps)
#: Runs for the constants and for the arms, and the change (relative, or [m]) at which they have settled.
HERTZ_RUNS, ARM_RUNS, SETTLED = 12, 6, 1e-13


class Scale(NamedTuple):
    """Scales of the forces and stiffnesses of a problem."""

    #: Force of a typical loaded contact [N], from loads, interference, or else an approach of a micrometre.
    force: float
    #: Secant stiffness of a contact under that force [N/m].
    stiffness: float
    #: Least force [N] that residuals are measured by: the largest load, moments over the arm, or the force of the tightest
    #: ball without load.
    floor: float
    #: Force [N] below which a contact counts as unloaded.
    none: float

    @property
    def typical(self) -> float:
        """Force [N] above zero at which small terms that depend on a contact's size are taken."""
        return max(self.force, 1e-6)


def options_of(scale: Scale, arm: float, furthest: float, tolerance: float = TOLERANCE) -> Options:
    """Return the options of the solvers.

    Parameters
    ----------
    scale
        Scales of the problem.
    arm
        Length that makes forces of moments [m].
    furthest
        Radius of the largest ball [m].
    tolerance
        Relative residual to reach.
    """
    return Options(
        tolerance=tolerance,
        most=MAX_ITERATIONS,
        stiffness=scale.stiffness,
        arm=arm,
        bound=1e3,
        floor=scale.floor,
        furthest=furthest,
    )


class Description(NamedTuple):
    """Description of a model for the record of its solution."""

    #: Formulation that is solved.
    formulation: str
    #: Number of unknowns.
    unknowns: int
    #: Assumptions.
    assumed: tuple[str, ...]
    #: Neglected effects.
    left_out: tuple[str, ...] = ()


class SetFlanks(NamedTuple):
    """Contacts, ball centres and flank motions of one set of N balls in one state of the iteration."""

    #: The set's problem.
    problem: Problem
    #: Contacts as the kernels leave them ``(N, 4, 5)``, see ``kernel.ball``.
    contact: Array
    #: Shifts of the balls' centres ``(N, 2)`` [m].
    centre: Array
    #: Motions of all flanks ``(N, 4, 2)`` [m].
    shift: Array


@dataclass(kw_only=True)
class Prepared(ABC):
    """Sets of balls ready for the kernels."""

    #: Name of the kernel that solves such a system.
    SOLVER: ClassVar[str]

    #: Kernels.
    engine: ModuleType
    #: System as the kernel takes it.
    given: Any
    #: State that the kernel changes.
    state: Any
    #: Options of the iteration.
    options: Options
    #: Largest force met in the last run [N].
    scale: float = 0.0

    def iterate(self, start: bool = True) -> Outcome:
        """Solve from the linear start, or from the present state."""
        outcome: Outcome = getattr(self.engine, self.SOLVER)(self.given, self.state, self.options, start)
        self.scale = outcome.scale
        return outcome

    @property
    @abstractmethod
    def problems(self) -> Sequence[Problem]:
        """Problem of each set, whose Hertz constants the kernels take."""

    @abstractmethod
    def flanks(self) -> Sequence[SetFlanks]:
        """Return the contacts of each set at the state."""

    @abstractmethod
    def with_arms(self, arms: Sequence[Array]) -> Self:
        """Return the system at the state with lever arms that are longer by ``(N, 4, 2)`` [m] for each set."""

    @abstractmethod
    def round_off(self) -> float:
        """Return the relative residual that double precision cannot get below (`least_residual`)."""

    @abstractmethod
    def description(self) -> Description:
        """Return the description of the model for the record."""

    def at_state(self, of: Prepared) -> Self:
        """Copy the state of another system into this one, and return this one."""
        for mine, known in zip(self.state, of.state, strict=True):
            mine[:] = known
        return self


P = TypeVar("P", bound=Prepared)


def contact_angles(normal: Array) -> Array:
    """Return the contact angles ``(..., 4)`` [rad] of normals from ball to groove ``(..., 4, 2)``."""
    return np.asarray(np.arctan2(SIGNS[:, 1] * normal[..., 1], SIGNS[:, 0] * normal[..., 0]))


def no_state_found(outcome: Outcome) -> bool:
    """Return whether a run found no state from which changed constants or lever arms could start."""
    return outcome.status in NO_LOADS or outcome.residual > LOST


def settled(system: P, profile: bool = True) -> tuple[P, Outcome]:
    """Solve from the start and update Hertz constants and lever arms until they settle.

    Hertz constants where the scene has them "actual", lever arms on uneven flanks (``profile``).

    Returns
    -------
    tuple[P, Outcome]
        The system at its last state, and the outcome.
    """
    outcome = system.iterate()
    if system.problems and system.problems[0].scene.ingredients.hertz == "actual":
        outcome = follow_hertz(system, outcome)
    if profile and any(map(uneven, system.problems)):
        return follow_profile(system, outcome)
    return system, outcome


def least_residual(motions: float, stiffness: float, scale: float, problems: Iterable[Problem]) -> float:
    """Return the relative residual that double precision cannot get below.

    Eight times eps times the lengths whose difference makes the approach, times the stiffness, over the largest force.

    Parameters
    ----------
    motions
        Largest motion [m]; in problems with uneven flanks the ball's radius is added.
    stiffness
        Of the contacts [N/m].
    scale
        Largest force met [N].
    problems
        The sets.
    """
    radius = max((p.scene.balls.radius for p in problems if p.drawn.profile.shape[1]), default=0.0)
    return ROUND_OFF * (motions + radius) * stiffness / scale if scale else 0.0


def status_of(outcome: Outcome, bound: float, unheld: Callable[[], Status], far: bool = False) -> Status:
    """Return the status of a solver's outcome.

    Parameters
    ----------
    outcome
        Of the solver.
    bound
        Relative residual that double precision cannot get below.
    unheld
        Returns the status of a body that moves without limit, by a linear program.
    far
        Whether the state is so far away that ``unheld`` decides about it too.
    """
    good = outcome.residual <= max(ACCEPTED, bound) and outcome.status in (CONVERGED, ITERATIONS)
    if good and not far:
        return Status("converged")
    if outcome.status == NOT_HELD:
        return unheld()
    if far and (status := unheld()).kind == "not held":
        return status
    if good:
        return Status("converged")
    if outcome.status == SINGULAR:
        return Status("stopped", "the stiffness matrix is not positive definite")
    reason = f"relative residual {outcome.residual:.1e} after {outcome.iterations} iterations"
    return Status("not converged", reason)


def report_of(
    outcome: Outcome,
    system: Prepared,
    description: Description,
    elements: int,
    times: tuple[float, float],
    notes: tuple[str, ...],
) -> SolverReport:
    """Return the record of effort and accuracy of a solve.

    Parameters
    ----------
    outcome, system, description
        Of the solver.
    elements
        Number of beam elements.
    times
        When the solve began and when its system was ready (`time.perf_counter`) [s].
    notes
        What happened during the solve.
    """
    return SolverReport(
        iterations=outcome.iterations,
        evaluations=outcome.evaluations,
        residual=outcome.residual,
        seconds=perf_counter() - times[0],
        unknowns=description.unknowns,
        elements=elements,
        engine="compiled" if jit.is_compiled(system.engine.__name__) else "interpreted",
        formulation=description.formulation,
        round_off_bound=system.round_off(),
        setup_seconds=times[1] - times[0],
        notes=notes,
    )


def follow_hertz(system: Prepared, outcome: Outcome) -> Outcome:
    """Solve again with Hertz constants at the actual contact angles until they settle."""
    for _ in range(HERTZ_RUNS):
        if no_state_found(outcome):
            break
        change = 0.0
        for problem, contact, _, _ in system.flanks():
            nominal = problem.scene.track.contact_angle
            gamma = np.where(contact[..., 0] > 0.0, contact_angles(contact[..., 1:3]), nominal)
            updated = actual_hertz(problem.scene, problem.drawn, gamma).C
            change = max(change, float(np.abs(updated / problem.C - 1.0).max()))
            problem.C[:] = updated
        outcome = with_counts_of(outcome, system.iterate(False))
        if change < SETTLED:
            break
    return outcome


def follow_profile(system: P, outcome: Outcome) -> tuple[P, Outcome]:
    """Solve again with lever arms to the flanks' centres of curvature at the contacts until they settle.

    An uneven profile shifts that centre, by about the size of the profile error.
    """
    before = [np.zeros((*p.C.shape, 2)) for p in system.problems]
    for _ in range(ARM_RUNS):
        if no_state_found(outcome):
            break
        arms = [centre_shift(s) for s in system.flanks()]
        change = max(float(np.abs(x - y).max()) for x, y in zip(arms, before, strict=True))
        before, system = arms, system.with_arms(arms)
        outcome = with_counts_of(outcome, system.iterate(False))
        if change < SETTLED:
            break
    return system, outcome


def uneven(problem: Problem) -> bool:
    """Return whether lever arms depend on a set's profiles."""
    return problem.drawn.profile.shape[1] > 0 and problem.scene.ingredients.arm != "nominal"


def centre_shift(s: SetFlanks) -> Array:
    """Return the shift from the groove's centre to the profile's centre of curvature at each loaded contact.

    Returns
    -------
    Array
        ``(N, 4, 2)`` [m]; zero for circular arcs.
    """
    force, normal = s.contact[..., 0], s.contact[..., 1:3]
    if not uneven(s.problem):
        return np.zeros(normal.shape)
    w = -s.problem.drawn.centre + s.centre[:, None, :] - s.shift
    with np.errstate(divide="ignore", invalid="ignore"):
        radius = np.where(force > 0.0, force / s.contact[..., 4], 0.0)
    return np.where(force[..., None] > 0.0, w - normal * radius[..., None], 0.0)


def with_counts_of(first: Outcome, then: Outcome) -> Outcome:
    """Return the later outcome with the iterations and evaluations of both."""
    return then._replace(iterations=first.iterations + then.iterations, evaluations=first.evaluations + then.evaluations)
