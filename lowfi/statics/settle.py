"""What follows the contacts of a solved state, and is solved with again until it settles: Hertz' constants at the actual
contact angle, and lever arms on uneven flanks. The same for one set and several, whatever solves them."""

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
    """Scales of the forces and stiffnesses of a problem.

    force [N]: of a typical loaded contact, from loads, interference, or else an approach of a micrometre; stiffness [N/m]:
    its secant; floor [N]: the least that residuals are measured by: the largest load, moments over the arm, or the force by
    which the tightest ball is pressed without load; none [N]: of a contact that counts as none.
    """

    force: float
    stiffness: float
    floor: float
    none: float

    @property
    def typical(self) -> float:
        """Force [N] above zero at which small terms that depend on a contact's size are taken."""
        return max(self.force, 1e-6)


def options_of(scale: Scale, arm: float, furthest: float, tolerance: float = TOLERANCE) -> Options:
    """How the solvers iterate on systems of a scale; arm [m]: makes forces of moments; furthest [m]: radius of the largest
    ball."""
    return Options(
        tolerance=tolerance,
        most=MAX_ITERATIONS,
        stiffness=scale.stiffness,
        arm=arm,
        bound=1e3,
        floor=scale.floor,
        furthest=furthest,
    )


class Words(NamedTuple):
    """What a model says of a solution: its formulation and number of unknowns, what it assumes and leaves out."""

    formulation: str
    unknowns: int
    assumed: tuple[str, ...]
    left_out: tuple[str, ...] = ()


class SetFlanks(NamedTuple):
    """A set's problem with the contacts (N, 4, 5) of its balls as the kernels leave them, their centres (N, 2), and the
    motions (N, 4, 2) of all flanks [m]."""

    problem: Problem
    contact: Array
    centre: Array
    shift: Array


@dataclass(kw_only=True)
class Prepared(ABC):
    """Sets of balls ready for the kernels: what these solve, the state that they fill, how they iterate; scale: the largest
    force met in the last run [N]."""

    #: Kernel that solves such a system.
    SOLVER: ClassVar[str]

    engine: ModuleType
    given: Any
    state: Any
    options: Options
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
        """Contacts of each set at the state."""

    @abstractmethod
    def with_arms(self, arms: Sequence[Array]) -> Self:
        """The same at the state with lever arms that are longer by (N, 4, 2) [m] for each set."""

    @abstractmethod
    def round_off(self) -> float:
        """Relative residual that double precision cannot get below (`least_residual`)."""

    @abstractmethod
    def words(self) -> Words:
        """What the model says of the solution."""

    def at_state(self, of: Prepared) -> Self:
        """Itself at the state of another."""
        for mine, known in zip(self.state, of.state, strict=True):
            mine[:] = known
        return self


P = TypeVar("P", bound=Prepared)


def contact_angles(normal: Array) -> Array:
    """Contact angle gamma of each contact [rad] from the normals (ball to groove), ``(..., 4, 2)`` -> ``(..., 4)``."""
    return np.asarray(np.arctan2(SIGNS[:, 1] * normal[..., 1], SIGNS[:, 0] * normal[..., 0]))


def lost(outcome: Outcome) -> bool:
    """Whether a run found no state that changed constants or lever arms could start from."""
    return outcome.status in NO_LOADS or outcome.residual > LOST


def settled(system: P, profile: bool = True) -> tuple[P, Outcome]:
    """Solve from the start, and follow the contacts: by Hertz' constants where the scene has them "actual", by lever arms
    on uneven flanks (``profile``); the system then, and its outcome."""
    outcome = system.iterate()
    if system.problems and system.problems[0].scene.ingredients.hertz == "actual":
        outcome = follow_hertz(system, outcome)
    if profile and any(map(uneven, system.problems)):
        return follow_profile(system, outcome)
    return system, outcome


def least_residual(motions: float, stiffness: float, scale: float, problems: Iterable[Problem]) -> float:
    """Relative residual that double precision cannot get below: eps times the lengths [m] whose difference makes the
    approach of contacts of such a stiffness [N/m], over the largest force met ``scale`` [N], times 8. Lengths are motions,
    and in problems with uneven flanks the ball's radius next to them."""
    radius = max((p.scene.balls.radius for p in problems if p.drawn.profile.shape[1]), default=0.0)
    return ROUND_OFF * (motions + radius) * stiffness / scale if scale else 0.0


def verdict(outcome: Outcome, bound: float, unheld: Callable[[], Status], far: bool = False) -> Status:
    """Status sentence of a solver outcome; bound: relative residual that double precision cannot get below; unheld: status
    by a linear program of a body that moves without limit; far: the state is so far away that ``unheld`` judges it too."""
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
    outcome: Outcome, system: Prepared, words: Words, elements: int, times: tuple[float, float], notes: tuple[str, ...]
) -> SolverReport:
    """How the solution of a system came about. elements: of the beam; times: when it began, and when its system was ready
    (`time.perf_counter`)."""
    return SolverReport(
        iterations=outcome.iterations,
        evaluations=outcome.evaluations,
        residual=outcome.residual,
        seconds=perf_counter() - times[0],
        unknowns=words.unknowns,
        elements=elements,
        engine="compiled" if jit.is_compiled(system.engine.__name__) else "interpreted",
        formulation=words.formulation,
        round_off_bound=system.round_off(),
        setup_seconds=times[1] - times[0],
        notes=notes,
    )


def follow_hertz(system: Prepared, outcome: Outcome) -> Outcome:
    """The outcome with Hertz' constants at the actual geometry."""
    for _ in range(HERTZ_RUNS):
        if lost(outcome):
            break
        change = 0.0
        for problem, contact, _, _ in system.flanks():
            nominal = problem.scene.track.contact_angle
            gamma = np.where(contact[..., 0] > 0.0, contact_angles(contact[..., 1:3]), nominal)
            updated = actual_hertz(problem.scene, problem.drawn, gamma).C
            change = max(change, float(np.abs(updated / problem.C - 1.0).max()))
            problem.C[:] = updated
        outcome = after(outcome, system.iterate(False))
        if change < SETTLED:
            break
    return outcome


def follow_profile(system: P, outcome: Outcome) -> tuple[P, Outcome]:
    """The system with flanks that turn about their centre of curvature at the contact, which an uneven profile shifts, and
    its outcome: solved again with moved lever arms until they settle (the shift is of the size of the profile error)."""
    before = [np.zeros((*p.C.shape, 2)) for p in system.problems]
    for _ in range(ARM_RUNS):
        if lost(outcome):
            break
        arms = [centre_shift(s) for s in system.flanks()]
        change = max(float(np.abs(x - y).max()) for x, y in zip(arms, before, strict=True))
        before, system = arms, system.with_arms(arms)
        outcome = after(outcome, system.iterate(False))
        if change < SETTLED:
            break
    return system, outcome


def uneven(problem: Problem) -> bool:
    """Whether lever arms follow a set's profiles."""
    return problem.drawn.profile.shape[1] > 0 and problem.scene.ingredients.arm != "nominal"


def centre_shift(s: SetFlanks) -> Array:
    """From the groove's centre to the profile's centre of curvature at each loaded contact (N, 4, 2) [m]; zero for arcs."""
    force, normal = s.contact[..., 0], s.contact[..., 1:3]
    if not uneven(s.problem):
        return np.zeros(normal.shape)
    w = -s.problem.drawn.centre + s.centre[:, None, :] - s.shift
    with np.errstate(divide="ignore", invalid="ignore"):
        radius = np.where(force > 0.0, force / s.contact[..., 4], 0.0)
    return np.where(force[..., None] > 0.0, w - normal * radius[..., None], 0.0)


def after(first: Outcome, then: Outcome) -> Outcome:
    """The later outcome with the iterations and evaluations of both."""
    return then._replace(iterations=first.iterations + then.iterations, evaluations=first.evaluations + then.evaluations)
