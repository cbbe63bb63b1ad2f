"""Damped Newton steps of many independent problems at once, each with a line search of its own."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from rollbench.meshes.arrays import Array, Index, Mask


def move_along_steps(
    x: Array,
    state: tuple[Array, ...],
    problems: Index,
    steps: tuple[Array, Array],
    evaluate: Callable[[Index, Array], Any],
    accept: Callable[[Index, Array, Any], Mask],
    trials: int,
    shorten: Callable[[Index, Array, Any], Array] | None = None,
) -> Mask:
    """Move problems along their steps, each shortened until it is accepted; return which of them have moved ``(k,)``.

    Parameters
    ----------
    x
        Unknowns of all K problems ``(K, n)``; those of problems that move are overwritten.
    state
        What is known at ``x``, arrays with K rows, a named tuple as ``evaluate`` returns it; overwritten as ``x`` is.
    problems
        Numbers of the problems to be moved ``(k,)``.
    steps
        Their steps ``(k, n)``, and the fractions of them that are tried first ``(k,)``.
    evaluate
        Function that returns the state of some problems, given by their numbers, at unknowns ``(j, n)``.
    accept
        Function that decides on trials ``(j,)``: from their places in ``problems``, the fractions of the step, and the
        states there.
    trials
        Largest number of trials of a step.
    shorten
        Function of the same arguments as ``accept`` that returns by which factor a step is shortened that was not
        accepted; None to halve it.
    """
    step, length = steps[0], steps[1].copy()
    left = np.arange(problems.size)
    for _ in range(trials):
        tried = problems[left]
        trial = x[tried] + length[left, None] * step[left]
        there = evaluate(tried, trial)
        good = accept(left, length[left], there)
        x[tried[good]] = trial[good]
        for whole, part in zip(state, there, strict=True):
            whole[tried[good]] = part[good]
        refused = ~good
        left = left[refused]
        if not left.size:
            break
        if shorten is None:
            length[left] *= 0.5
        else:
            length[left] *= shorten(left, length[left], type(there)(*(part[refused] for part in there)))
    moved = np.ones(problems.size, dtype=bool)
    moved[left] = False
    return moved
