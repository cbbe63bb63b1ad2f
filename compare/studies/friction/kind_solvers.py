"""Which function solves a friction scene of which kind."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rollbench.compare.scenes.friction_kinds.common import KindScene
from rollbench.compare.studies.friction.answer import FrictionAnswer
from rollbench.compare.studies.friction.bearing_kinds import solve_ball, solve_bearings
from rollbench.compare.studies.friction.linear_kinds import solve_linear
from rollbench.compare.studies.friction.screw_kinds import solve_run, solve_screw_pair

SOLVERS: dict[str, Callable[[Any], FrictionAnswer]] = {
    "bearing ball": solve_ball,
    "bearing pair": solve_bearings,
    "linear pair": solve_linear,
    "linear chain": solve_linear,
    "screw pair": solve_screw_pair,
    "screw run": solve_run,
}


def solve_kind(scene: KindScene) -> FrictionAnswer:
    """Solve a scene of a kind that only friction solves."""
    return SOLVERS[scene.kind](scene)
