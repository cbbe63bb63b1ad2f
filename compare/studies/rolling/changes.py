"""How far ball-to-ball forces move when a numerical choice changes, and how they come about from rest."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from rollbench.compare.measure import error_percent
from rollbench.compare.reference.body_names import FINITE
from rollbench.compare.scenes.catalogue import case as shipped_case
from rollbench.compare.scenes.friction_kinds.bearings import LinearPairScene
from rollbench.compare.scenes.friction_kinds.common import KindScene
from rollbench.compare.studies.rolling.body_sizes import LINEAR, SCENES, SHAPE, Variant, variants
from rollbench.compare.studies.rolling.cases import case_of
from rollbench.compare.studies.rolling.rows import stored_rows
from rollbench.compare.studies.rolling.runs import LEVELS, load
from rollbench.hifi.rolling.balls import NEARLY_RIGID, Choices, run_from_rest, solve_rolling
from rollbench.hifi.rolling.friction import PATH
from rollbench.hifi.rolling.kinematics import Rolling

#: Time [s], gap at the start [m] and steps (Lin 3.3.5 has ten).
DURATION, GAP, STEPS = 0.1, 1e-6, (10, 50, 100)


@dataclass(frozen=True)
class Series:
    """A run: steps, their ends [s], force [N], speeds of the balls [m/s], the steady force on the same grid [N], processor
    seconds, status."""

    steps: int
    time: tuple[float, ...]
    force: tuple[float, ...]
    speed: tuple[tuple[float, ...], ...]
    steady: float
    seconds: float
    status: str


@lru_cache(maxsize=1)
def from_rest() -> tuple[Series, ...]:
    """Runs with each number of steps of ``STEPS``."""
    choices = Choices(SHAPE)
    scene = case_of(shipped_case("lin-pair-a", LinearPairScene), choices).touching
    steady = float(solve_rolling(scene, choices).force[0])
    out = []
    for count in STEPS:
        run = run_from_rest(scene, DURATION, count, GAP, choices)
        force = tuple(map(float, run.force[:, 0]))
        speed = tuple(tuple(map(float, row)) for row in run.speed)
        out.append(Series(count, tuple(map(float, run.time)), force, speed, steady, run.seconds, run.status))
    return tuple(out)


# --- how far ball-to-ball forces move when a numerical choice changes, beside their stated uncertainty: a grid finer than


#: A grid beyond those of the uncertainty, and other paths: creeping speeds over the largest slip.
BEYOND = (30, 44)
PATHS = {"by threes": tuple(3.0**-k for k in range(14)), "two steps": (PATH[0], PATH[-1])}
FORCE = "force 1-2"


@dataclass(frozen=True)
class Change:
    """Scene, choice, what was tried, largest change of the force and its stated uncertainty [%]."""

    scene: str
    choice: str
    tried: str
    change: float
    uncertainty: float

    @property
    def within(self) -> bool:
        """Whether the answer stays within its uncertainty."""
        return self.change <= self.uncertainty


def changes(stores: Sequence[Path], series: Sequence[Series], sizes: Sequence[Variant]) -> tuple[Change, ...]:
    """Changes of the scenes of `studies.rolling.body_sizes.SCENES` that have stored runs; series: runs of the linear
    one from rest; sizes: variants of finite bodies (none: left out)."""
    return tuple(one for name in SCENES for one in _changes(name, stores, series, sizes))


def _changes(name: str, stores: Sequence[Path], series: Sequence[Series], sizes: Sequence[Variant]) -> Iterator[Change]:
    scene = shipped_case(name, KindScene)
    half, finite = (_uncertainty(name, stores, *bodies) for bodies in ((), (FINITE,)))
    run = load(scene, max(LEVELS), stores)
    if run is None or half is None:
        return
    key, case = f"{FORCE} N", case_of(scene, Choices(SHAPE)).touching
    near, elastic = (_force(case, Choices(BEYOND, share)) for share in (NEARLY_RIGID, 1.0))
    grid = _largest([run.limit[key] + elastic - near], run.values[key])
    yield Change(name, "grid", f"{BEYOND[0]} x {BEYOND[1]} cells beyond {run.shape[0]} x {run.shape[1]}", grid, half)
    values = [v.values[key] for v in sizes if variants()[v.choice][0] == name and variants()[v.choice][1] is not None]
    if values and finite is not None:
        tried = f"{len(values) - 1} other sizes, cells, kernels, patches"
        yield Change(name, "finite bodies", tried, _largest(values[1:], values[0]), finite)
    if name == LINEAR:
        tried = f"{', '.join(str(s.steps) for s in series)} steps from rest"
        ends = [s.force[-1] / s.steady if s.status == "converged" else np.nan for s in series]
        yield Change(name, "time step", tried, _largest(ends, 1.0), half)
    first, *others = (_force(case, Choices(SHAPE), path) for path in (PATH, *PATHS.values()))
    yield Change(name, "path of regularisation", ", ".join(PATHS), _largest(others, first), half)


def _force(scene: Rolling, choices: Choices, path: tuple[float, ...] = PATH) -> float:
    """Force of the first two balls [N]; NaN, which is within nothing, of a search that ends without a solution."""
    found = solve_rolling(scene, choices, path=path)
    return float(found.force[0]) if found.converged else np.nan


def _largest(values: Sequence[float], reference: float) -> float:
    return float(np.max([abs(float(error_percent(value, reference))) for value in values]))


def _uncertainty(name: str, stores: Sequence[Path], *bodies: str) -> float | None:
    """Stated uncertainty of the force [%]; None without stored runs."""
    return next((row.uncertainty_percent for row in stored_rows(name, stores, *bodies) if row.quantity == FORCE), None)
