"""Case (a) of the linear bearing from rest, as the source ran it, with its ten steps and more."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

from rollbench.comparison.scenes.catalogue import case as shipped_case
from rollbench.comparison.wings.friction.kinds.linear import LinearPairScene
from rollbench.comparison.wings.rolling.cases import case_of
from rollbench.hifi.rolling.balls import Choices, solve_rolling
from rollbench.hifi.rolling.transient import run_from_rest

#: Time [s], gap at the start [m] and steps (Lin 3.3.5 has ten); cells of the contacts.
DURATION, GAP, STEPS = 0.1, 1e-6, (10, 50, 100)
SHAPE = (12, 16)


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
