"""Parts common to all Newton iterations here: the next trial along a step on a convex energy, and when to end."""

from rollbench.lowfi.jit import kernel
from rollbench.lowfi.statics.kernel_types import Progress, Trial

#: Converged, out of iterations, moved without limit, stiffness not positive definite.
CONVERGED, ITERATIONS, NOT_HELD, SINGULAR = range(4)
#: Net force on a ball over the largest force up to which it counts as balanced.
BALANCED = 1e-10
#: Shifts of the stiffness that are tried before it counts as singular, each a hundred times the one before.
SHIFTS = 12

#: Relative round-off of an energy, summed over springs of both signs of work.
ROUNDING = 1e-14
#: Trials of a search: on a convex energy they never run out, where they do twice the iteration ends.
TRIALS = 60
#: Relative residual from which on whole steps are tried first, and growth at which one is taken back and searched along.
WHOLE_STEPS, GROWN = 1e-7, 10.0
#: Relative residual of a solution: it is the last one where a step from it, whole and searched along, makes that grow so.
SOLVED = 1e-10
#: Iterations in which the residual was not halved once, after which the iteration ends: at any residual, near the
#: solution, and at round-off. Contacts far weaker than the beam between them settle near the solution only. Near means
#: near by the applied loads: a shaft that fixed ends twist has forces beside which an unbalanced load is nothing.
PATIENCE, PATIENCE_NEAR, PATIENCE_LAST = 100, 10, 2
NEAR, LAST = 1e-9, 1e-12
#: Share of the energy by which it has to fall for an iteration to have got on.
FALLS = 1e-6


@kernel
def first_trial(energy: float, slope: float, limit: float) -> Trial:
    """Return the whole step, or the longest that ``limit`` allows, as the first trial.

    energy and slope < 0 along the step where the search begins; limit: largest step length: a step that carries flanks past
    their balls gives no information on the contacts.
    """
    return Trial(energy, slope, limit, 0.0, 0.0, min(1.0, limit), 0)


@kernel
def next_trial(trial: Trial, new: float, ahead: float) -> tuple[Trial, bool]:
    """Return the trial step after one with energy ``new`` and slope ``ahead``, and whether the search continues."""
    energy, slope, limit, low, high, t, tried = trial
    tried += 1
    go_on = tried < TRIALS
    if ahead > 0.0:
        if ahead <= 0.5 * abs(slope) and new <= energy + ROUNDING * abs(energy):
            return Trial(energy, slope, limit, low, high, t, tried), False
        if new <= energy + 1e-4 * t * slope and ahead <= 0.9 * abs(slope):
            return Trial(energy, slope, limit, low, high, t, tried), False
        high = t
        t = low + (0.5 if low > 0.0 else 0.35) * (high - low)
    else:
        if ahead >= 0.9 * slope or high > 0.0 or t >= limit:
            return Trial(energy, slope, limit, low, high, t, tried), False
        low = t
        t = min(4.0 * t, limit)
    return Trial(energy, slope, limit, low, high, t, tried), go_on


@kernel
def got_on(progress: Progress, residual: float, unbalanced: float, energy: float, tried: int) -> tuple[Progress, bool]:
    """Return the progress after an iteration that searched ``tried`` times, and whether it is the last one.

    unbalanced: the residual over the applied loads in place of the largest force met.
    """
    falls = progress.lowest - energy > FALLS * abs(energy)
    stalled = 0 if residual < 0.5 * progress.best or falls else progress.stalled + 1
    stuck = progress.stuck + (1 if tried >= TRIALS else 0)
    patience = PATIENCE_LAST if residual <= LAST else PATIENCE_NEAR if unbalanced <= NEAR else PATIENCE
    lowest = energy if falls else progress.lowest
    return Progress(min(progress.best, residual), lowest, stalled, stuck), stalled >= patience or stuck >= 2
