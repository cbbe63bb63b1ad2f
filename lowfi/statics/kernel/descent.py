"""Newton's method with a vanishing shift and a line search on a convex energy: the one driver of all systems here.

This file is loaded once for each system (`jit.load_driver`), a module that gives by name the functions taken below and
``KEPT``, the residual over the least one before from which on, near the end, the stiffness is factored again. ``given`` is
the constants of such a system, ``state`` its unknowns, ``workspace`` its work arrays: derivatives, the step and its start.
The shift is proportional to the residual, so it vanishes at the solution and convergence stays fast.
"""

from typing import Any

from rollbench.lowfi.jit import kernel
from rollbench.lowfi.statics.kernel_types import Options, Outcome, Progress

from .search import (
    BALANCED,
    CONVERGED,
    GROWN,
    ITERATIONS,
    NOT_HELD,
    SHIFTS,
    SINGULAR,
    SOLVED,
    WHOLE_STEPS,
    first_trial,
    got_on,
    next_trial,
)

#: The module that this copy of the driver serves, put here by `lowfi.jit.load_driver`.
system: Any = globals()["system"]
KEPT: float = system.KEPT
#: Energy [J] and largest force met [N] at the state; fills the derivatives in the workspace.
energy_at = system.energy_at
#: Step by Newton's method to the workspace, False where the stiffness plus the shift [N/m] is not positive definite.
find_step = system.find_step
#: Largest unbalanced force over the scale; slope of the energy along the step; largest motion [m] of a flank by it.
residual_at, slope_along, reach_of = system.residual_at, system.slope_along, system.reach_of
#: Note where the step begins; go to t steps from there; what has to be found again at the end.
keep, move, finish = system.keep, system.move, system.finish
#: Least force [N] that residuals are measured by; furthest free motion [m]; largest net force on a ball over the scale.
least_force, furthest, unbalanced = system.least_force, system.furthest, system.unbalanced


@kernel
def search(given: Any, state: Any, workspace: Any, energy: float, slope: float, limit: float) -> tuple[float, float, int]:
    """Search along the step (see ``search``), leaving the state at the accepted point; limit: largest step length.

    Returns the energy, the largest force and the number of evaluations.
    """
    trial, go_on = first_trial(energy, slope, limit), True
    new, scale = energy, 0.0
    while go_on:
        move(given, state, workspace, trial.t)
        new, scale = energy_at(given, state, workspace)
        trial, go_on = next_trial(trial, new, slope_along(given, state, workspace))
    return new, scale, trial.tried


@kernel
def judge(given: Any, state: Any, options: Options, workspace: Any, scale: float, start: float) -> tuple[float, float]:
    """Return the scale [N], at least the least force that residuals are measured by, and the residual over it.

    That of the start (``start``) where only displacements are given, which may meet no resistance in the end.
    """
    least = least_force(given, state, options) if options.floor > 0.0 else start
    scale = max(scale, least)
    return scale, residual_at(given, state, options, workspace, scale)


@kernel
def minimise(given: Any, state: Any, options: Options, workspace: Any) -> Outcome:
    """Minimise the energy from the given state."""
    tolerance, begin = options.tolerance, least_force(given, state, options)
    energy, scale = energy_at(given, state, workspace)
    if begin == 0.0:
        begin = 1e-3 * scale
    scale = max(scale, begin)
    residual = residual_at(given, state, options, workspace, scale)
    evaluations, amount, iteration, status, fresh = 1, 1e-3, 0, ITERATIONS, True
    progress = Progress(residual, energy, 0, 0)
    if residual <= tolerance and unbalanced(state, scale) <= BALANCED:
        return Outcome(CONVERGED, iteration, evaluations, residual, energy, scale)
    for iteration in range(1, options.most + 1):  # noqa: B007 - reported at the end
        solved = False
        for _ in range(SHIFTS):
            shift = amount * options.stiffness * min(1.0, residual)
            solved = find_step(given, state, options, workspace, shift, fresh)
            if solved:
                break
            amount, fresh = 100.0 * amount, True
        if not solved:
            status = SINGULAR
            break
        slope, reach = slope_along(given, state, workspace), reach_of(given, workspace)
        limit = options.furthest / reach if reach > 0.0 else 1e12
        whole, used, before, last = residual < WHOLE_STEPS and limit >= 1.0, 0, energy, residual
        keep(state, workspace)
        if whole:
            move(given, state, workspace, 1.0)
            energy, scale = energy_at(given, state, workspace)
            evaluations += 1
            scale, residual = judge(given, state, options, workspace, scale, begin)
            whole = residual <= GROWN * max(last, tolerance)
        if not whole:
            energy, scale, used = search(given, state, workspace, before, slope, limit)
            evaluations += used
            scale, residual = judge(given, state, options, workspace, scale, begin)
        if used > 0 and last <= SOLVED and residual > GROWN * last:
            move(given, state, workspace, 0.0)
            energy, scale = energy_at(given, state, workspace)
            scale, residual = judge(given, state, options, workspace, scale, begin)[0], last
            break
        amount = max(1e-3, amount * 0.1)
        if residual <= tolerance and unbalanced(state, scale) <= BALANCED:
            status = CONVERGED
            break
        if furthest(given, state) > options.bound:
            status = NOT_HELD
            break
        fresh = residual >= WHOLE_STEPS or residual >= KEPT * progress.best
        near = residual * scale / options.floor if options.floor > 0.0 else residual
        progress, ends = got_on(progress, residual, near, energy, used)
        if ends:
            break
    finish(given, state, options, workspace)
    loose = unbalanced(state, scale)
    if loose > BALANCED:
        residual = max(residual, loose)
    return Outcome(status, iteration, evaluations, residual, energy, scale)
