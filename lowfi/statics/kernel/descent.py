"""Minimise a convex energy by Newton's method with line search: the solver shared by all static models of this package.

`jit.load_solver_copy` loads this file once for each model, which is one of the modules ``beam``, ``axis`` and ``elastic``.
The model's module defines the functions named below, and ``KEPT``: near the solution, the stiffness is factored again only
if the residual is more than this fraction of the smallest one before. In the functions, ``given`` holds the constants of
the model, ``state`` its unknowns, and ``workspace`` its work arrays (derivatives, the step, and the start of the line
search).

Newton's method is regularised by a stiffness on the diagonal. It is proportional to the residual and therefore vanishes at
the solution, where convergence remains fast.
"""

from typing import Any

from rollbench.lowfi.jit import kernel
from rollbench.lowfi.statics.kernel_types import IterationProgress, NewtonOptions, Outcome

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
    first_line_search_trial,
    next_line_search_trial,
    record_progress,
)

#: Module of the model that this copy of the solver minimises; set by `lowfi.jit.load_solver_copy`.
system: Any = globals()["system"]
#: Ratio of a residual to the smallest residual of earlier iterations, above which the stiffness is factored again.
KEPT: float = system.KEPT
#: Return the energy [J] and the largest force [N] at the state; write the energy's derivatives to the workspace.
energy_and_largest_force = system.energy_and_largest_force
#: Write Newton's step to the workspace; return False if stiffness plus added diagonal [N/m] is not positive definite.
write_newton_step = system.write_newton_step
#: Return the largest unbalanced force, relative to a given force.
relative_residual = system.relative_residual
#: Return the derivative [J] of the energy by the step length, along the Newton step.
energy_slope_along_step = system.energy_slope_along_step
#: Return the largest motion [m] of a groove flank in the whole Newton step.
largest_flank_motion_in_step = system.largest_flank_motion_in_step
#: Store the present state in the workspace as the start of a line search.
save_line_search_start = system.save_line_search_start
#: Set the state to the start of the line search plus t times the Newton step.
move_along_step = system.move_along_step
#: Complete the state after the last iteration.
complete_final_state = system.complete_final_state
#: Return the smallest force [N] by which unbalanced forces may be divided.
least_residual_force_scale = system.least_residual_force_scale
#: Return the largest displacement [m] of a node or body from its initial position.
largest_displacement = system.largest_displacement
#: Return the largest net contact force on a ball, relative to a given force.
largest_relative_net_ball_force = system.largest_relative_net_ball_force


@kernel
def search_along_step(
    given: Any, state: Any, workspace: Any, energy: float, slope: float, limit: float
) -> tuple[float, float, int]:
    """Search the minimum of the energy along the Newton step, and leave the state at the accepted point.

    The ``workspace`` holds the step. energy, slope: energy [J] and derivative of the energy by the step length [J] at the
    start; limit: largest step length, as a fraction of the Newton step; ``given``: constants of the model. Returns the
    energy [J] and the largest force [N] at the accepted point, and the number of step lengths tried.
    """
    trial, go_on = first_line_search_trial(energy, slope, limit), True
    new, scale = energy, 0.0
    while go_on:
        move_along_step(given, state, workspace, trial.t)
        new, scale = energy_and_largest_force(given, state, workspace)
        trial, go_on = next_line_search_trial(trial, new, energy_slope_along_step(given, state, workspace))
    return new, scale, trial.trial_count


@kernel
def force_scale_and_residual(
    given: Any, state: Any, options: NewtonOptions, workspace: Any, scale: float, first_force: float
) -> tuple[float, float]:
    """Return the force [N] by which the largest unbalanced force is divided, and the quotient: the relative residual.

    That force is the largest force in the model, ``scale`` [N], but at least the result of `least_residual_force_scale`.
    Where only displacements are prescribed (``options.least_force_scale`` is zero), it is at least ``first_force`` [N]
    instead, a force of the first state, because the final state may be free of forces. ``given``: constants of the model;
    the ``workspace`` holds the unbalanced forces.
    """
    least = least_residual_force_scale(given, state, options) if options.least_force_scale > 0.0 else first_force
    scale = max(scale, least)
    return scale, relative_residual(given, state, options, workspace, scale)


@kernel
def minimise(given: Any, state: Any, options: NewtonOptions, workspace: Any) -> Outcome:
    """Minimise the energy of the model, starting from ``state``, which holds the solution on return.

    Iterates until the relative residual is at most ``options.tolerance`` and all balls are in equilibrium, or until the
    iteration cannot improve the state. Returns how it ended, with iteration counts, residual, energy and largest force.
    ``given``: constants of the model; ``workspace``: work arrays of its functions.
    """
    tolerance, begin = options.tolerance, least_residual_force_scale(given, state, options)
    energy, scale = energy_and_largest_force(given, state, workspace)
    if begin == 0.0:
        begin = 1e-3 * scale
    scale = max(scale, begin)
    residual = relative_residual(given, state, options, workspace, scale)
    evaluations, amount, iteration, status, fresh = 1, 1e-3, 0, ITERATIONS, True
    progress = IterationProgress(residual, energy, 0, 0)
    if residual <= tolerance and largest_relative_net_ball_force(state, scale) <= BALANCED:
        return Outcome(CONVERGED, iteration, evaluations, residual, energy, scale)
    for iteration in range(1, options.max_iterations + 1):  # noqa: B007 - reported at the end
        solved = False
        for _ in range(SHIFTS):
            shift = amount * options.stiffness * min(1.0, residual)
            solved = write_newton_step(given, state, options, workspace, shift, fresh)
            if solved:
                break
            amount, fresh = 100.0 * amount, True
        if not solved:
            status = SINGULAR
            break
        slope, reach = energy_slope_along_step(given, state, workspace), largest_flank_motion_in_step(given, workspace)
        limit = options.max_flank_step / reach if reach > 0.0 else 1e12
        whole, used, before, last = residual < WHOLE_STEPS and limit >= 1.0, 0, energy, residual
        save_line_search_start(state, workspace)
        if whole:
            move_along_step(given, state, workspace, 1.0)
            energy, scale = energy_and_largest_force(given, state, workspace)
            evaluations += 1
            scale, residual = force_scale_and_residual(given, state, options, workspace, scale, begin)
            whole = residual <= GROWN * max(last, tolerance)
        if not whole:
            energy, scale, used = search_along_step(given, state, workspace, before, slope, limit)
            evaluations += used
            scale, residual = force_scale_and_residual(given, state, options, workspace, scale, begin)
        if used > 0 and last <= SOLVED and residual > GROWN * last:
            move_along_step(given, state, workspace, 0.0)
            energy, scale = energy_and_largest_force(given, state, workspace)
            scale, residual = force_scale_and_residual(given, state, options, workspace, scale, begin)[0], last
            break
        amount = max(1e-3, amount * 0.1)
        if residual <= tolerance and largest_relative_net_ball_force(state, scale) <= BALANCED:
            status = CONVERGED
            break
        if largest_displacement(given, state) > options.unrestrained_motion_limit:
            status = NOT_HELD
            break
        fresh = residual >= WHOLE_STEPS or residual >= KEPT * progress.smallest_residual
        near = residual * scale / options.least_force_scale if options.least_force_scale > 0.0 else residual
        progress, ends = record_progress(progress, residual, near, energy, used)
        if ends:
            break
    complete_final_state(given, state, options, workspace)
    loose = largest_relative_net_ball_force(state, scale)
    if loose > BALANCED:
        residual = max(residual, loose)
    return Outcome(status, iteration, evaluations, residual, energy, scale)
