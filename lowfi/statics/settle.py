"""What follows the contacts of a solved state, and is solved with anew until it settles: Hertz' constants at the actual
contact angle, and lever arms on uneven flanks. The same for one set and several, whatever solves them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from time import perf_counter
from types import ModuleType
from typing import NamedTuple

import numpy as np

from rollbench.lowfi import jit
from rollbench.lowfi.statics.kernel.status import CONVERGED, ITERATIONS, NOT_HELD, SINGULAR
from rollbench.lowfi.statics.problem import SIGNS, Problem, actual_hertz
from rollbench.lowfi.statics.records import Outcome
from rollbench.lowfi.statics.result import SolverReport, Status
from rollbench.meshes.arrays import Array

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


class Contacts(NamedTuple):
    """Contacts (N, 4, 5) of a set's balls as the kernels leave them, and its problem."""

    problem: Problem
    contact: Array


class Flanks(NamedTuple):
    """The same with the centres (N, 2) of the balls and the motions (N, 4, 2) of all flanks [m]."""

    problem: Problem
    contact: Array
    centre: Array
    shift: Array


def contact_angles(normal: Array) -> Array:
    """Contact angle gamma of each contact [rad] from the normals (ball to groove), ``(..., 4, 2)`` -> ``(..., 4)``."""
    return np.asarray(np.arctan2(SIGNS[:, 1] * normal[..., 1], SIGNS[:, 0] * normal[..., 0]))


def lost(outcome: Outcome) -> bool:
    """Whether a run found no state that changed constants or lever arms could start from."""
    return outcome.status in NO_LOADS or outcome.residual > LOST


def settled(
    iterate: Callable[[bool], Outcome],
    contacts: Callable[[], Sequence[Contacts]],
    flanks: Callable[[], Sequence[Flanks]],
    rebuild: Callable[[list[Array]], Outcome] | None,
    hertz: str,
) -> Outcome:
    """Solve from the start, and follow the contacts by Hertz' constants where ``hertz`` is "actual", and by lever arms on
    uneven flanks where there is a ``rebuild``; iterate: from the linear start (True) or the present state. Of all sets; for
    the rest see ``follow_hertz`` and ``follow_profile``."""
    outcome = iterate(True)
    if hertz == "actual":
        outcome = follow_hertz(outcome, contacts, lambda: iterate(False))
    if rebuild is not None and any(uneven(problem) for problem, _ in contacts()):
        outcome = follow_profile(outcome, flanks, rebuild)
    return outcome


def least_residual(motions: float, stiffness: float, scale: float, problems: Iterable[Problem]) -> float:
    """Relative residual that double precision cannot get below: eps times the lengths [m] whose difference makes the
    approach of contacts of such a stiffness [N/m], over the largest force met ``scale`` [N], times 8. Lengths are motions,
    and in problems with uneven flanks the ball's radius beside them."""
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
    outcome: Outcome,
    kernels: ModuleType,
    times: tuple[float, float],
    system: tuple[str, int, int],
    bound: float,
    notes: tuple[str, ...],
) -> SolverReport:
    """How a solution came about. times: when it began, and when its system was ready (`time.perf_counter`); system: its
    formulation, unknowns and beam elements; bound: see ``verdict``."""
    formulation, unknowns, elements = system
    return SolverReport(
        iterations=outcome.iterations,
        evaluations=outcome.evaluations,
        residual=outcome.residual,
        seconds=perf_counter() - times[0],
        unknowns=unknowns,
        elements=elements,
        engine="compiled" if jit.is_compiled(kernels.__name__) else "interpreted",
        formulation=formulation,
        round_off_bound=bound,
        setup_seconds=times[1] - times[0],
        notes=notes,
    )


def follow_hertz(outcome: Outcome, contacts: Callable[[], Sequence[Contacts]], again: Callable[[], Outcome]) -> Outcome:
    """The outcome with Hertz' constants at the actual geometry.

    contacts: of all sets at the state; again: solves from it with the constants that their problems then have.
    """
    for _ in range(HERTZ_RUNS):
        if lost(outcome):
            break
        change = 0.0
        for problem, contact in contacts():
            nominal = problem.scene.track.contact_angle
            gamma = np.where(contact[..., 0] > 0.0, contact_angles(contact[..., 1:3]), nominal)
            updated = actual_hertz(problem.scene, problem.drawn, gamma).C
            change = max(change, float(np.abs(updated / problem.C - 1.0).max()))
            problem.C[:] = updated
        outcome = after(outcome, again())
        if change < SETTLED:
            break
    return outcome


def follow_profile(
    outcome: Outcome, flanks: Callable[[], Sequence[Flanks]], rebuild: Callable[[list[Array]], Outcome]
) -> Outcome:
    """The outcome with flanks that turn about their centre of curvature at the contact, which an uneven profile shifts.

    Repeats the solution with moved lever arms until they settle (the shift is of the size of the profile error). flanks: of
    all sets at the state; rebuild: solves from it with arms that are longer by (N, 4, 2) [m] for each set.
    """
    before: list[Array] | None = None
    for _ in range(ARM_RUNS):
        if lost(outcome):
            break
        arms = [centre_shift(s) for s in flanks()]
        old = [np.zeros_like(x) for x in arms] if before is None else before
        change = max(float(np.abs(x - y).max()) for x, y in zip(arms, old, strict=True))
        before = arms
        outcome = after(outcome, rebuild(arms))
        if change < SETTLED:
            break
    return outcome


def uneven(problem: Problem) -> bool:
    """Whether lever arms follow a set's profiles."""
    return problem.drawn.profile.shape[1] > 0 and problem.scene.ingredients.arm != "nominal"


def centre_shift(s: Flanks) -> Array:
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
