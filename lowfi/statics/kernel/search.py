"""Line search on a convex energy, and the criteria that end a Newton iteration; used by all static solvers."""

from rollbench.lowfi.jit import kernel
from rollbench.lowfi.statics.kernel_types import IterationProgress, LineSearchTrial

#: How an iteration ended: converged, too many iterations, body moved without limit, stiffness not positive definite.
CONVERGED, ITERATIONS, NOT_HELD, SINGULAR = range(4)
#: Net contact force on a ball, as a fraction of the largest force in the model, up to which the ball is in equilibrium.
BALANCED = 1e-10
#: Number of stiffnesses that are tried in addition to those on the diagonal, each a hundred times the one before, until the
#: stiffness matrix counts as singular.
SHIFTS = 12

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
#: round-off. Near the solution is judged by the applied loads: in a shaft twisted by its fixed ends, the element forces are
#: so large that an unbalanced load is small compared with them.
PATIENCE, PATIENCE_NEAR, PATIENCE_LAST = 100, 10, 2
#: Relative residuals below which the state counts as near the solution, and as exact to round-off.
NEAR, LAST = 1e-9, 1e-12
#: Relative decrease of the energy that counts as progress of an iteration.
FALLS = 1e-6


@kernel
def first_line_search_trial(energy: float, slope: float, limit: float) -> LineSearchTrial:
    """Return the first trial of a line search: the whole Newton step, or the longest step that ``limit`` allows.

    The step length is a fraction of the Newton step. energy, slope: energy [J] at the start of the search, and its
    derivative by the step length there [J], which is negative. limit: largest step length; a longer step would carry flanks
    past their balls and give no information on the contacts.
    """
    return LineSearchTrial(energy, slope, limit, 0.0, 0.0, min(1.0, limit), 0)


@kernel
def next_line_search_trial(trial: LineSearchTrial, trial_energy: float, trial_slope: float) -> tuple[LineSearchTrial, bool]:
    """Return the next step length to try in a line search, and whether the search continues.

    trial: last step length tried, with the largest one known to be too short and the smallest one known to be too long;
    trial_energy, trial_slope: energy [J] and its derivative by the step length [J], at the last step length tried. The
    search ends where the magnitude of the derivative is sufficiently smaller than at the start, or at the largest step
    length.
    """
    energy, slope, limit, low, high, t, tried = trial
    tried += 1
    go_on = tried < TRIALS
    if trial_slope > 0.0:
        if trial_slope <= 0.5 * abs(slope) and trial_energy <= energy + ROUNDING * abs(energy):
            return LineSearchTrial(energy, slope, limit, low, high, t, tried), False
        if trial_energy <= energy + 1e-4 * t * slope and trial_slope <= 0.9 * abs(slope):
            return LineSearchTrial(energy, slope, limit, low, high, t, tried), False
        high = t
        t = low + (0.5 if low > 0.0 else 0.35) * (high - low)
    else:
        if trial_slope >= 0.9 * slope or high > 0.0 or t >= limit:
            return LineSearchTrial(energy, slope, limit, low, high, t, tried), False
        low = t
        t = min(4.0 * t, limit)
    return LineSearchTrial(energy, slope, limit, low, high, t, tried), go_on


@kernel
def record_progress(
    progress: IterationProgress, residual: float, unbalanced: float, energy: float, tried: int
) -> tuple[IterationProgress, bool]:
    """Update the record of a Newton iteration's progress; return it, and whether to end the iteration for lack of progress.

    residual: largest unbalanced force relative to the largest force; unbalanced: the same force relative to the applied
    loads; energy: energy of the model [J] after the step; tried: number of step lengths that the last line search tried.
    The iteration ends after several steps that neither halved the residual nor lowered the energy, or after two exhausted
    line searches.
    """
    falls = progress.lowest_energy - energy > FALLS * abs(energy)
    stalled = 0 if residual < 0.5 * progress.smallest_residual or falls else progress.stalled_iterations + 1
    stuck = progress.exhausted_searches + (1 if tried >= TRIALS else 0)
    patience = PATIENCE_LAST if residual <= LAST else PATIENCE_NEAR if unbalanced <= NEAR else PATIENCE
    lowest = energy if falls else progress.lowest_energy
    return IterationProgress(
        min(progress.smallest_residual, residual), lowest, stalled, stuck
    ), stalled >= patience or stuck >= 2
