"""Many chains of one design with random errors: drawn by number, solved in chunks, only what is asked for kept."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from rollbench.lowfi.jit import RANDOM_ERRORS, kernels
from rollbench.lowfi.random_errors.chain import LAWS, Chain, checked, free_motion
from rollbench.meshes.arrays import Array

#: What is kept of each chain: smallest and largest contact load [N], loaded balls, motion since the first touch of ball 1
#: and of the first loaded ball (Liu's 19) [m], stiffness dF/du_1 [N/m].
Quantity = Literal["smallest", "largest", "loaded", "displacement", "displacement_first_loaded", "stiffness"]
QUANTITIES: tuple[Quantity, ...] = get_args(Quantity)
#: Chains solved at a time: 5 MB of errors for 78 balls.
CHUNK = 8192


@dataclass(frozen=True)
class Ensemble:
    """Chains drawn and solved. loads (L,) [N]; kept (n, L, 6), last axis as ``QUANTITIES``; residual: the largest, over the
    load; failed: chains that did not converge under some load."""

    loads: Array
    kept: Array
    residual: float
    failed: int

    def of(self, quantity: Quantity, load: float) -> Array:
        """One quantity of every chain (n,) at a load [N]. Raises KeyError for a load that was not solved."""
        at = np.flatnonzero(self.loads == load)
        if at.size != 1:
            raise KeyError(f"no load of {load} N in this ensemble")
        return np.asarray(self.kept[:, at[0], QUANTITIES.index(quantity)])


def draw_errors(seed: int, first: int, count: int, balls: int, half_range: float) -> Array:
    """Errors (count, balls) [m], uniform and independent in [-half_range, half_range], of the chains ``first`` and on.

    Chain i has the numbers i M to (i + 1) M - 1 of the stream of ``seed``, so a chain is the same however it is asked for
    (Liu, 2.1: e - 2 e rand(1, 78); the source's plus sign would leave the band).
    """
    stream = np.random.PCG64(seed)
    stream.advance(first * balls)
    return half_range * (1.0 - 2.0 * np.random.Generator(stream).random((count, balls)))


def solve_errors(chain: Chain, errors: Array, loads: Array) -> tuple[Array, Array]:
    """Quantities (n, L, 6) and residuals (n, L) of chains with errors (n, M) [m] under loads (L,) [N].

    Raises ValueError for a load that is not positive, or errors that do not fit.
    """
    f = np.ascontiguousarray(loads, dtype=float)
    if f.ndim != 1 or f.size == 0 or not np.all((f > 0.0) & np.isfinite(f)):
        raise ValueError("loads must be positive")
    e = checked(chain, errors)
    out = np.empty((len(e), f.size, len(QUANTITIES) + 1))
    k = kernels(RANDOM_ERRORS, compiled=True)
    k.batch(e, f, chain.compliance, LAWS.index(chain.law), chain.parameters, out)
    at = QUANTITIES.index("displacement")
    out[..., at : at + 2] -= np.asarray(free_motion(chain, e.max(axis=1)))[:, None, None]
    return out[..., :-1], out[..., -1]


def solve_ensemble(
    chain: Chain, half_range: float, loads: Array | list[float], members: int, *, seed: int = 0, chunk: int = CHUNK
) -> Ensemble:
    """Chains 0 to ``members`` - 1 of a seed, errors within +-half_range [m], under loads (L,) [N].

    Memory: one chunk of errors, and six numbers a chain and load. The same numbers whatever the chunk.
    Raises ValueError where members or chunk are not positive, or as ``solve_errors``.
    """
    if members < 1 or chunk < 1 or half_range < 0.0:
        raise ValueError("members and chunk must be positive, the range of errors not negative")
    f = np.asarray(loads, dtype=float)
    kept, worst, failed = np.empty((members, f.size, len(QUANTITIES))), 0.0, 0
    tolerance = kernels(RANDOM_ERRORS, compiled=False).TOLERANCE
    for first in range(0, members, chunk):
        count = min(chunk, members - first)
        errors = draw_errors(seed, first, count, chain.balls, half_range)
        kept[first : first + count], residual = solve_errors(chain, errors, f)
        worst = max(worst, float(residual.max()))
        failed += int(np.count_nonzero((residual > tolerance).any(axis=1)))
    return Ensemble(f, kept, worst, failed)


@dataclass(frozen=True)
class Percentile:
    """Where a number stands in a sample: share at or below and share below it (they differ where values repeat), both with
    the standard error of the share; size of the sample."""

    below: float
    at_most: float
    size: int

    @property
    def middle(self) -> float:
        """Percentile [%], a repeated value counted half."""
        return 50.0 * (self.below + self.at_most)

    @property
    def error(self) -> float:
        """Standard error [%]; by the rule of succession, so that none is zero."""
        p = (0.01 * self.middle * self.size + 1.0) / (self.size + 2.0)
        return float(100.0 * np.sqrt(p * (1.0 - p) / self.size))

    @property
    def tail(self) -> float:
        """Probability of a value at least as far out, to the nearer side."""
        return min(self.at_most, 1.0 - self.below)

    @property
    def tail_bound(self) -> float:
        """Upper 95 % bound of ``tail`` (Wilson; 2.7 / size where no value reaches it)."""
        z, n, p = 1.645, self.size, self.tail
        return float((p + z * z / (2 * n) + z * np.sqrt(p * (1 - p) / n + z * z / (4 * n * n))) / (1 + z * z / n))


def percentile(sample: Array, value: float, width: float = 0.0) -> Percentile:
    """Where ``value`` stands in a sample (n,); ``width``: half of what rounding hides, counted as equal."""
    return Percentile(float(np.mean(sample < value - width)), float(np.mean(sample <= value + width)), sample.size)
