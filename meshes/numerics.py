"""Brent's method for roots, and a search for pairs of close points, without importing scipy, which takes seconds."""

from __future__ import annotations

from collections.abc import Callable
from math import copysign

import numpy as np

from rollbench.meshes.arrays import Array, Index

#: Smallest relative tolerance that `brentq` accepts: four units in the last place.
LEAST = 8.881784197001252e-16


def brentq(f: Callable[[float], float], low: float, high: float, xtol: float = 2e-12, rtol: float = LEAST) -> float:
    """Return a root of a function in an interval by Brent's method; all digits equal those of ``scipy.optimize.brentq``.

    Parameters
    ----------
    f : Callable[[float], float]
        Continuous function.
    low, high : float
        Ends of the interval, at which f has different signs.
    xtol, rtol : float, default 2e-12 and LEAST
        Tolerances: the error of the root is at most ``xtol + rtol abs(root)``; rtol must be at least `LEAST`.

    Returns
    -------
    float
        Root of the function.

    Raises
    ------
    ValueError
        f has the same sign at both ends.
    ArithmeticError
        The root is not found in 300 steps.

    References
    ----------
    R. P. Brent, Algorithms for Minimization Without Derivatives (1973), chapter 4.

    Examples
    --------
    >>> brentq(lambda x: x * x - 2.0, 0.0, 2.0)
    1.4142135623731364
    """
    before, at = float(low), float(high)  # the last two estimates; ``other`` is on the other side of the root
    f_before, f_at = float(f(before)), float(f(at))
    if f_before == 0.0:
        return before
    if f_at == 0.0:
        return at
    if copysign(1.0, f_before) == copysign(1.0, f_at):
        raise ValueError("Brent's method: the function must have different signs at the two ends of the interval")
    other = f_other = step_before = step = 0.0
    for _ in range(300):
        if f_before != 0.0 and f_at != 0.0 and copysign(1.0, f_before) != copysign(1.0, f_at):
            other, f_other = before, f_before
            step_before = step = at - before
        if abs(f_other) < abs(f_at):
            before, at, other = at, other, at
            f_before, f_at, f_other = f_at, f_other, f_at
        least, half = (xtol + rtol * abs(at)) / 2.0, (other - at) / 2.0
        if f_at == 0.0 or abs(half) < least:
            return at
        taken = half, half
        if abs(step_before) > least and abs(f_at) < abs(f_before):
            if before == other:
                over, under = at - before, f_at - f_before
            else:
                by_before, by_other = (f_before - f_at) / (before - at), (f_other - f_at) / (other - at)
                over = f_other * by_other - f_before * by_before
                under = by_other * by_before * (f_other - f_before)
            if under != 0.0 and 2.0 * abs(-f_at * over / under) < min(abs(step_before), 3.0 * abs(half) - least):
                taken = step, -f_at * over / under
        step_before, step = taken
        before, f_before = at, f_at
        at += step if abs(step) > least else (least if half > 0.0 else -least)
        f_at = float(f(at))
    raise ArithmeticError("Brent's method finds no root of the function in 300 steps")


#: Number of points up to which `pairs_of_close_points` computes the distances of all pairs, which is then faster than
#: importing scipy and building a k-d tree.
FEW = 500


def pairs_of_close_points(points: Array, largest_distance: float) -> Index:
    """Return the pairs of points whose distance does not exceed a limit.

    Parameters
    ----------
    points : (n, 3) Array
        Points [m].
    largest_distance : float
        Largest distance [m].

    Returns
    -------
    (m, 2) Index
        Indices of the two points of each pair, the smaller one first; pairs are sorted.

    Examples
    --------
    >>> pairs_of_close_points(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [9.0, 0.0, 0.0]]), 2.0).tolist()
    [[0, 1]]
    """
    if len(points) > FEW:
        from scipy.spatial import cKDTree

        pairs = np.sort(cKDTree(points).query_pairs(largest_distance, output_type="ndarray"), axis=1)
        return np.asarray(pairs[np.lexsort(pairs.T[::-1])])
    i, j = np.triu_indices(len(points), 1)
    near = np.linalg.norm(points[i] - points[j], axis=1) <= largest_distance
    return np.column_stack([i[near], j[near]])
