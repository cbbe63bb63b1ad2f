"""Ensembles: many ball screws of one design with numbered random errors, and the place of a number among them.

Screws are drawn and solved in chunks; only a few quantities of each screw are stored.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from rollbench.lowfi.as_source.liu import chain as ball_chain
from rollbench.lowfi.as_source.liu.chain import BallScrewChain
from rollbench.meshes.arrays import Array

#: Quantities that are stored for each screw of an ensemble: smallest and largest contact load [N], number of loaded balls,
#: axial motion since the first contact at ball 1 and at the first loaded ball (Liu's equation 19) [m], stiffness dF/du_1
#: [N/m].
Quantity = Literal["smallest", "largest", "loaded", "displacement", "displacement_first_loaded", "stiffness"]

QUANTITIES: tuple[Quantity, ...] = get_args(Quantity)

#: Number of screws solved at a time; an array of their 78 balls under three loads takes 1 MB.
CHUNK = 512


@dataclass(frozen=True)
class ScrewEnsemble:
    """Results of n ball screws of one design with random ball errors, each solved under L axial loads."""

    #: The L axial loads under which each screw is solved ``(L,)`` [N].
    loads: Array
    #: Results of each screw under each load ``(n, L, 6)``; the last axis holds smallest and largest contact load [N],
    #: number of loaded balls, axial motion at ball 1 and at the first loaded ball [m], and stiffness [N/m].
    kept: Array
    #: Largest unbalanced axial force on a ball, as a fraction of the axial load: maximum over all screws and loads.
    residual: float
    #: Number of screws for which Newton's method did not converge under at least one of the loads.
    failed: int

    def values_at(self, quantity: Quantity, load: float) -> Array:
        """Return one quantity of all n screws under one of the axial loads ``(n,)``, in the unit that `Quantity` states.

        Raises KeyError if the ensemble was not solved under this load.
        """
        at = np.flatnonzero(self.loads == load)
        if at.size != 1:
            raise KeyError(f"the ensemble of ball screws was not solved at an axial load of {load} N")
        return np.asarray(self.kept[:, at[0], QUANTITIES.index(quantity)])


def draw_uniform_errors(seed: int, first: int, count: int, balls: int, half_range: float) -> Array:
    """Return independent, uniformly distributed random errors ``(count, balls)`` [m] of the balls of several screws.

    Screw i uses the random numbers i M to (i + 1) M - 1 of the stream that ``seed`` starts, so that its errors do not
    depend on the number of screws.

    Parameters
    ----------
    seed
        Seed of the random numbers.
    first, count
        Number of the first screw, from 0, and number of screws.
    balls
        Number of balls M of a screw.
    half_range
        Largest absolute value of an error [m]; the errors lie between -half_range and +half_range.

    References
    ----------
    Liu et al. (2025), 2.1: e - 2 e rand(1, 78). The printed plus sign, which would exceed the range, is corrected.
    """
    stream = np.random.PCG64(seed)
    stream.advance(first * balls)
    return half_range * (1.0 - 2.0 * np.random.Generator(stream).random((count, balls)))


def solve_screws_with_errors(chain: BallScrewChain, errors: Array, loads: Array) -> tuple[Array, Array]:
    """Solve n ball screws with errors of their M balls under L axial loads each.

    ``chain``: ball screw without errors; ``errors``: oversize of each ball ``(n, M)`` [m]; ``loads``: axial loads ``(L,)``
    [N].

    Returns
    -------
    tuple[Array, Array]
        Smallest and largest contact load, number of loaded balls, axial motion at ball 1 and at the first loaded ball, and
        stiffness ``(n, L, 6)``; and the residual of the equations: the largest unbalanced axial force on a ball, as a
        fraction of the load ``(n, L)``.

    Raises
    ------
    ValueError
        A load is not positive, or the errors have the wrong number or size.
    """
    f = np.ascontiguousarray(loads, dtype=float)
    if f.ndim != 1 or f.size == 0 or not np.all((f > 0.0) & np.isfinite(f)):
        raise ValueError(f"all axial loads on the ball screws must be positive and finite, got {f.tolist()} N")
    e = ball_chain.checked_ball_errors(chain, errors)
    solved = ball_chain.solve_screws(chain, np.repeat(e, f.size, axis=0), np.tile(f, len(e)))
    quantities: dict[Quantity, Array] = {
        "smallest": solved.load.min(axis=-1),
        "largest": solved.load.max(axis=-1),
        "loaded": solved.loaded_balls,
        "displacement": solved.displacement,
        "displacement_first_loaded": solved.displacement_first_loaded,
        "stiffness": solved.stiffness,
    }
    found = np.stack([quantities[name] for name in QUANTITIES], axis=-1)
    return found.reshape(len(e), f.size, -1), solved.residual.reshape(len(e), f.size)


def solve_ensemble(
    chain: BallScrewChain, half_range: float, loads: Array | list[float], screw_count: int, *, seed: int = 0
) -> ScrewEnsemble:
    """Solve many ball screws of one design with uniformly distributed random ball errors under several axial loads.

    The memory needed is that for the ball errors of one chunk of screws, and for six results for each screw and load.

    Parameters
    ----------
    chain
        Ball screw as a sequence of balls.
    half_range
        Largest absolute value of the random errors, which are uniformly distributed [m].
    loads
        Axial loads ``(L,)`` [N].
    screw_count
        Number of screws.
    seed
        Seed of the random numbers.

    Raises
    ------
    ValueError
        The number of screws is not positive, or errors as in `solve_screws_with_errors`.
    """
    if screw_count < 1 or half_range < 0.0:
        raise ValueError(
            "`screw_count`, the number of screws, must be positive; `half_range` of errors must not be negative, "
            f"got screw_count {screw_count}, half_range {half_range} m"
        )
    f = np.asarray(loads, dtype=float)
    kept, worst, failed = np.empty((screw_count, f.size, len(QUANTITIES))), 0.0, 0
    for first in range(0, screw_count, CHUNK):
        count = min(CHUNK, screw_count - first)
        errors = draw_uniform_errors(seed, first, count, chain.balls, half_range)
        kept[first : first + count], residual = solve_screws_with_errors(chain, errors, f)
        worst = max(worst, float(residual.max()))
        failed += int(np.count_nonzero((residual > ball_chain.TOLERANCE).any(axis=1)))
    return ScrewEnsemble(f, kept, worst, failed)


@dataclass(frozen=True)
class PercentileRank:
    """Percentile rank of a given number in a sample of random values."""

    #: Fraction of the sample's values that are below the number.
    below: float
    #: Fraction of the sample's values that are below or equal to the number.
    at_most: float
    #: Number of values in the sample.
    size: int

    @property
    def percent(self) -> float:
        """Percentile rank of the number [%], for which values of the sample equal to it count half."""
        return 50.0 * (self.below + self.at_most)

    @property
    def standard_error(self) -> float:
        """Standard error of the percentile rank [%].

        By the rule of succession, it is never zero.
        """
        p = (0.01 * self.percent * self.size + 1.0) / (self.size + 2.0)
        return float(100.0 * np.sqrt(p * (1.0 - p) / self.size))

    @property
    def tail_probability(self) -> float:
        """One-sided tail probability: fraction of the sample at least as far from the sample's median as the number.

        Only values on the same side of the median as the number are counted.
        """
        return min(self.at_most, 1.0 - self.below)

    @property
    def tail_bound(self) -> float:
        """Upper 95 % confidence bound of ``tail_probability`` by Wilson's score interval.

        It is 2.7/size if no value of the sample is as extreme as the number.
        """
        z, n, p = 1.645, self.size, self.tail_probability
        return float((p + z * z / (2 * n) + z * np.sqrt(p * (1 - p) / n + z * z / (4 * n * n))) / (1 + z * z / n))


def percentile_rank(sample: Array, value: float, rounding_error: float = 0.0) -> PercentileRank:
    """Return the percentile rank of a given number in a sample of values.

    Parameters
    ----------
    sample
        Values of the sample ``(n,)``.
    value
        The given number, in the unit of the sample.
    rounding_error
        Rounding error of the number; values of the sample that differ from the number by no more count as equal.
    """
    below, at_most = np.mean(sample < value - rounding_error), np.mean(sample <= value + rounding_error)
    return PercentileRank(float(below), float(at_most), sample.size)
