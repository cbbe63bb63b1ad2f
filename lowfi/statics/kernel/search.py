"""The line search that all of Newton's iterations here share: where to try next along a step on a convex energy."""

from rollbench.lowfi.jit import kernel
from rollbench.lowfi.statics.records import Trial

#: Relative round-off of an energy, summed over springs of both signs of work.
ROUNDING = 1e-14
#: Trials of a search: on a convex energy they never run out, where they do twice the iteration ends.
TRIALS = 60


@kernel
def first_trial(energy: float, slope: float, limit: float) -> Trial:
    """The whole step, or the longest that ``limit`` allows; energy and slope < 0 along the step where the search begins.

    limit: largest step length: a step that carries flanks past their balls says nothing of the contacts.
    """
    return Trial(energy, slope, limit, 0.0, 0.0, min(1.0, limit), 0)


@kernel
def next_trial(trial: Trial, new: float, ahead: float) -> tuple[Trial, bool]:
    """The trial that follows one of energy ``new`` and slope ``ahead``, and whether the search goes on to it.

    The step is shrunk on overshoot, and stretched while the slope does not change (open gaps).
    """
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
