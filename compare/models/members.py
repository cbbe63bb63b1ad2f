"""Many screws of one scene with random errors, by any model: what is kept of each, bands per ball, sampling errors.

Members are solved in blocks that may run side by side. What a member is depends on the scene's seed and its number alone,
and blocks are put together in their order, so the numbers are the same whatever the number of workers. Memory: a block of
loads in each process, six numbers a member, and one histogram a contact.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import bdtr, bdtrik
from threadpoolctl import threadpool_limits

from rollbench.comparison.errors import InputError
from rollbench.comparison.models.ensemble import run_ensemble, work_of
from rollbench.comparison.models.loading import scaled
from rollbench.comparison.models.registry import MODELS, Options, run_model
from rollbench.comparison.reference import parallel
from rollbench.comparison.reference.jobs import Engine
from rollbench.lowfi.compliance.bodies import LADDER
from rollbench.lowfi.jit import STATICS, cached, kernels
from rollbench.lowfi.statics.elastic_members import ElasticMembers, shared
from rollbench.lowfi.statics.nominal import nominal_contacts
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import without_draws
from rollbench.meshes.loads import mean_load
from rollbench.meshes.parts import Scene

#: What is kept of each member: key and heading.
KEPT = {
    "largest_load_N": "largest contact load / N",
    "mean_load_N": "mean contact load / N",
    "stiffness_N_per_um": "stiffness along the load / (N/um)",
    "lost_contacts": "contacts lost against no random errors",
    "relative_life": "life over that without random errors",
    "residual": "relative residual",
}
#: Members of a block; from how many on kernels are compiled, and are used where they have been; part of the load by which
#: stiffness is taken.
BLOCK, COMPILE_FROM, USE_FROM, STEP = 500, 200, 10, 1e-3
#: Models with elastic bodies, whose members may share one system.
ELASTIC = tuple(name for name in LADDER if name != "lin")
#: Least time [s] that other processes must take over to be started: each imports and compiles for itself.
WORTH_WORKERS = 10.0
#: Bins of the histogram of a contact's load, and its end over the largest load without random errors.
BINS, END = 2000, 10.0
LEVELS = (0.01, 0.05, 0.5, 0.95, 0.99)
MOST = 10_000_000
#: Exponents of the loads of a raceway that turns under the load and of one that does not, and of raceways together.
TURNING, STANDING, SYSTEM = 3.0, 10.0 / 3.0, 10.0 / 9.0


@dataclass(frozen=True)
class Bands:
    """Contacts over the members. nominal: loads (N, 4) [N] without random errors; mean, deviation, smallest, largest (N, 4)
    [N], loaded (N, 4): share of members in which a contact carries, counts (N, 4, `BINS` + 2): histogram of the loads of
    width ``width`` [N], the first of loads of zero, the last of those beyond its end."""

    nominal: Array
    mean: Array
    deviation: Array
    smallest: Array
    largest: Array
    loaded: Array
    counts: NDArray[np.int64]
    width: float

    def quantile(self, level: float) -> Array:
        """Quantile of each contact's load (N, 4) [N], to ``width``."""
        below = np.cumsum(self.counts, axis=-1)
        place = (below < level * below[..., -1:]).sum(axis=-1)
        return np.asarray(np.where(place == 0, 0.0, (place - 0.5) * self.width))


@dataclass(frozen=True)
class Members:
    """Members of a scene. kept (M, 6) as ``KEPT`` (nan where there is no equilibrium); statuses of those that did not
    converge, by number; seconds of wall clock."""

    scene: Scene
    model: str
    kept: Array
    failed: dict[int, str]
    bands: Bands
    seconds: float


@dataclass(frozen=True)
class Block:
    """Loads (k, N, 4) of a block, numbers (k, ...), statuses."""

    loads: Array
    kept: Array
    statuses: tuple[str, ...]


def life_sum(load: Array) -> Array:
    """L^(-10/9) of all raceways together, to a factor, from loads (..., N, 4) [N]: ISO/TS 16281, equivalent loads.

    The screw's grooves turn under the load (cubic mean over the balls), the nut's do not (power 10/3); the raceways are
    taken as equally strong, and every ball's place as equally frequent.
    """
    turning = (load[..., :2] ** TURNING).mean(axis=-2) ** (SYSTEM * 3.0 / TURNING)
    standing = (load[..., 2:] ** STANDING).mean(axis=-2) ** (SYSTEM * 3.0 / STANDING)
    return np.asarray(turning.sum(axis=-1) + standing.sum(axis=-1))


def _solved(scene: Scene, model: str, engine: str, first: int, count: int) -> tuple[Array, tuple[str, ...], Array, Array]:
    """Loads, statuses, residuals and works of some members."""
    if model == "lin" and engine == "compiled":
        batch = run_ensemble(scene, count, first)
        return batch.loads, batch.statuses, batch.residuals, batch.works
    loads, residuals, works = np.full((count, scene.ball_count, 4), np.nan), np.full(count, np.nan), np.full(count, np.nan)
    if model in ELASTIC and shared(scene):
        loads, residuals, works = _system(scene, model, engine).solve(first, count)
    statuses = ["converged"] * count
    for k in np.flatnonzero(np.isnan(residuals)):
        result = run_model(scene, model, Options(member=first + int(k), engine=engine, discretisation=False))
        statuses[k], residuals[k] = result.status, result.solver.residual
        if result.converged:
            loads[k], works[k] = result.load, work_of(scene, result)
    return loads, tuple(statuses), residuals, works


@lru_cache(maxsize=4)
def _system(scene: Scene, model: str, engine: str) -> ElasticMembers:
    """What solves all blocks of a scene in this process."""
    return ElasticMembers(scene, LADDER[model], kernels(STATICS, compiled=engine == "compiled"))


def solve_block(scene: Scene, model: str, engine: str, nominal: Array, first: int, count: int) -> Block:
    """Members ``first`` and on of a scene; nominal: loads (N, 4) [N] without random errors."""
    with threadpool_limits(1, "blas"):
        loads, statuses, residuals, works = _solved(scene, model, engine, first, count)
        force = float(sum(np.dot(x.force, x.force) for x in scene.loads))
        stiffness = np.full(count, np.nan)
        if force > 0.0:
            more = _solved(scaled(scene, 1.0 + STEP), model, engine, first, count)[3] / (1.0 + STEP)
            with np.errstate(divide="ignore", invalid="ignore"):
                stiffness = 1e-6 * force * STEP / (more - works)
    good = np.array([s == "converged" for s in statuses])
    loads[~good] = np.nan
    loaded = loads > 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        life = (life_sum(loads) / life_sum(nominal)) ** (-1.0 / SYSTEM)
    contacts = nominal_contacts(scene)
    mean = np.array([mean_load(load, contacts) for load in loads])
    lost = (~loaded & (nominal > 0.0)).sum(axis=(1, 2)).astype(float)
    kept = np.column_stack([loads.max(axis=(1, 2)), mean, stiffness, lost, life, residuals])
    kept[~good] = np.nan
    return Block(loads, kept, statuses)


def run_members(
    scene: Scene,
    model: str,
    count: int,
    engine: Engine | None = None,
    step: Callable[[str], None] = lambda _: None,
    row: Callable[[int, str, Array], None] = lambda *_: None,
) -> Members:
    """Solve members 0 to ``count`` - 1 of a scene; ``row`` hears of each, in order: number, status, numbers (6,).

    Raises InputError for an unknown model, a count out of range, a scene without random errors, or one that has no
    equilibrium without them.
    """
    engine = engine or Engine()
    _check(scene, model, count)
    start = perf_counter()
    fast = "compiled" if count >= COMPILE_FROM or (count >= USE_FROM and cached(STATICS)) else "interpreted"
    bare = run_model(without_draws(scene), model, Options(engine=fast, discretisation=False))
    if not bare.converged or not bare.load.max() > 0.0:
        reason = bare.status if not bare.converged else "no contact carries load without random errors"
        raise InputError(scene.name, "scene", reason, "loaded contacts without random errors", "load or preload the screw")
    bands, kept, failed = gathered(solve_block, (scene, model, fast, bare.load), bare.load, count, engine, step, row)
    return Members(scene, model, kept, failed, bands, perf_counter() - start)


def gathered(
    solve: Callable[..., Block],
    arguments: tuple[Any, ...],
    nominal: Array,
    count: int,
    engine: Engine,
    step: Callable[[str], None],
    row: Callable[[int, str, Array], None],
) -> tuple[Bands, Array, dict[int, str]]:
    """Bands, numbers (M, ...) and failures of members that ``solve`` finds block by block: (arguments, first, count).

    nominal: loads (N, 4) [N] without random errors.
    """
    sums = _Sums(nominal, END * float(nominal.max()) / BINS)
    rows: list[Array] = []
    failed: dict[int, str] = {}
    start, done = perf_counter(), 0
    for first, block in _blocks(solve, arguments, count, engine, step):
        sums.add(block.loads)
        rows.append(block.kept)
        for k, status in enumerate(block.statuses):
            row(first + k, status, block.kept[k])
            if status != "converged":
                failed[first + k] = status
        done += len(block.kept)
        spent = perf_counter() - start
        step(f"[{done}/{count}] {len(failed)} failed: {spent:.0f} s, about {spent * (count - done) / done:.0f} s left")
    return sums.bands(), np.concatenate(rows), failed


def check_count(count: int) -> None:
    """Raises InputError for a number of members that is out of range."""
    if not 2 <= count <= MOST:
        raise InputError("command line", "--members", str(count), f"2 to {MOST}", "a thousand give a band of some per cent")


def _check(scene: Scene, model: str, count: int) -> None:
    if model not in MODELS or model == "condensed":
        allowed = ", ".join(name for name in MODELS if name != "condensed")
        raise InputError("command line", "--model", model, allowed, "see: rollbench list")
    check_count(count)
    if not scene.errors.random:
        advice = "give a sigma to balls, pitch, roundness or profile"
        raise InputError(scene.name, "errors", "nothing random", "at least one sigma above zero", advice)


def _blocks(
    solve: Callable[..., Block], arguments: tuple[Any, ...], count: int, engine: Engine, step: Callable[[str], None]
) -> Iterator[tuple[int, Block]]:
    """Blocks in order, whatever the order they come in: the first in this process, and all where starting others would take
    longer."""
    size = max(1, min(BLOCK, count // 16))  # by the count alone: how members are cut into blocks shows in round-off
    jobs: list[parallel.Job] = [(solve, (*arguments, first, min(size, count - first))) for first in range(0, count, size)]
    if (engine.workers or 1) > 1 and engine.backend == "joblib":
        start = perf_counter()
        yield 0, solve(*arguments, 0, min(size, count))
        left, jobs = (perf_counter() - start) * (len(jobs) - 1), jobs[1:]
        if left < WORTH_WORKERS:
            step(f"no other processes: the members left take about {left:.1f} s here, to start others takes longer")
            engine = replace(engine, workers=1)
    waiting: dict[int, Block] = {}
    following = done = -(-count // size) - len(jobs)
    for number, block in parallel.as_done(jobs, engine.backend, engine.scheduler, engine.workers):
        waiting[done + number] = block
        while following in waiting:
            yield following * size, waiting.pop(following)
            following += 1


class _Sums:
    """Running sums over the members of each contact's load, about its load without random errors."""

    def __init__(self, nominal: Array, width: float) -> None:
        self.nominal, self.width = nominal, width
        self.first, self.second = np.zeros(nominal.shape), np.zeros(nominal.shape)
        self.low, self.high = np.full(nominal.shape, np.inf), np.zeros(nominal.shape)
        self.counts = np.zeros((nominal.size, BINS + 2), dtype=np.int64)

    def add(self, loads: Array) -> None:
        """Loads (k, N, 4) of a block; members without equilibrium are left out. Member by member, in order: the sums do
        not depend on how the members are cut into blocks."""
        place = np.arange(self.nominal.size)
        for load in loads[~np.isnan(loads[:, 0, 0])]:
            off = load - self.nominal
            self.first += off
            self.second += off * off
            np.minimum(self.low, load, out=self.low)
            np.maximum(self.high, load, out=self.high)
            bins = np.where(load > 0.0, 1 + np.minimum(load / self.width, BINS), 0).astype(np.int64)
            self.counts[place, bins.ravel()] += 1

    def bands(self) -> Bands:
        """What the sums say."""
        n = int(self.counts[0].sum())
        mean = self.first / max(n, 1)
        deviation = np.sqrt(np.maximum(self.second - n * mean**2, 0.0) / max(n - 1, 1))
        counts = self.counts.reshape(*self.nominal.shape, -1)
        shares = 1.0 - counts[..., 0] / max(n, 1)
        low = np.where(np.isfinite(self.low), self.low, 0.0)
        return Bands(self.nominal, self.nominal + mean, deviation, low, self.high, shares, counts, self.width)


def _binomial_quantile(p: float, trials: int, chance: float) -> int:
    """Least count that a binomial variable stays below or at with a probability of ``p``."""
    count = int(np.ceil(bdtrik(p, trials, chance)))
    return count - 1 if count > 0 and bdtr(count - 1, trials, chance) >= p else count


def statistics(values: Array) -> dict[str, Any] | None:
    """Mean with its standard error, deviation, extremes, and quantiles with their 95 % intervals, of the finite ones of
    values (M,); None of less than two.

    The interval of a quantile lies between order statistics, by the binomial distribution of how many values are below it.
    """
    y = np.sort(values[np.isfinite(values)])
    if y.size < 2:
        return None
    sd = float(y.std(ddof=1))
    out: dict[str, Any] = {"members": int(y.size), "mean": float(y.mean()), "standard_error": sd / float(np.sqrt(y.size))}
    out |= {"standard_deviation": sd, "smallest": float(y[0]), "largest": float(y[-1]), "quantiles": []}
    for level in LEVELS:
        low, high = (_binomial_quantile(p, y.size, level) for p in (0.025, 0.975))
        ends = float(y[max(low - 1, 0)]), float(y[min(high, y.size - 1)])
        out["quantiles"].append({"level": level, "value": float(np.quantile(y, level)), "low": ends[0], "high": ends[1]})
    return out
