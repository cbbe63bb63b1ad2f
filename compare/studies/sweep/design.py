"""Where a sweep takes its samples: points of a unit cube by scipy.stats.qmc, one coordinate a varied key."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product
from typing import Literal

import numpy as np
from scipy.stats import qmc

from rollbench.compare.errors import ArgumentError
from rollbench.compare.studies.sweep.keys import Vary
from rollbench.meshes.arrays import Array

Method = Literal["sobol", "lhs", "grid"]
METHODS: tuple[Method, ...] = ("sobol", "lhs", "grid")
#: Most samples of a sweep.
MOST = 1_000_000


def base_points(samples: int, keys: int) -> int:
    """Base points n of a design for Sobol indices: the power of two whose n (keys + 2) is nearest to ``samples`` by ratio,
    at least 2."""
    return max(2, 1 << max(0, round(math.log2(max(samples, 1) / (keys + 2)))))


def points(method: Method, keys: Sequence[Vary], samples: int, seed: int) -> Array:
    """Places ``(m, d)`` in [0, 1] of all samples of a design; same arguments, same places.

    sobol: n base points A, n base points B, and for each key those of A with that key's coordinate of B (Saltelli et al.
    2010), n as in `base_points`: m = n (d + 2), in that order. lhs: a Latin hypercube of ``samples``. grid: all
    combinations of the values of lists and of equal steps of ranges, ends included, as many as ``samples`` allows.
    Raises InputError for a bad method or number of samples.
    """
    if method not in METHODS:
        raise ArgumentError("method", str(method), ", ".join(METHODS), "sobol gives indices too")
    if not 2 <= samples <= MOST:
        raise ArgumentError("samples", str(samples), f"2 to {MOST}", "start with a hundred")
    d = len(keys)
    if method == "lhs":
        return np.asarray(qmc.LatinHypercube(d, rng=np.random.default_rng(seed)).random(samples))
    if method == "grid":
        return _grid(keys, samples)
    n = base_points(samples, d)
    joined = qmc.Sobol(2 * d, rng=np.random.default_rng(seed)).random(n)
    a, b = joined[:, :d], joined[:, d:]
    mixed = [np.where(np.arange(d) == k, b, a) for k in range(d)]
    return np.concatenate([a, b, *mixed])


def _grid(keys: Sequence[Vary], samples: int) -> Array:
    fixed = math.prod(len(v.choices) for v in keys if v.choices)
    ranges = sum(not v.choices for v in keys)
    steps = int((samples / fixed) ** (1.0 / ranges) + 1e-9) if ranges else 1
    if fixed > samples or (ranges and steps < 2):
        least = fixed * 2**ranges
        raise ArgumentError("samples", str(samples), f"{least} or more for this grid", "or `method=lhs`")
    axes = [(np.arange(len(v.choices)) + 0.5) / len(v.choices) if v.choices else np.linspace(0.0, 1.0, steps) for v in keys]
    return np.array(list(product(*axes)))


def values(keys: Sequence[Vary], place: Array) -> list[object]:
    """Values of all keys at a place ``(d,)``, as a scene file holds them."""
    return [vary.at(float(u)) for vary, u in zip(keys, place, strict=True)]
