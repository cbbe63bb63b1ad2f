"""The low-order models' answers to a scene of rolling balls, under the names of `compare.studies.rolling.runs.measures`."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import Any

from rollbench.compare.scenes.friction_kinds.bearings import BearingBallScene, LinearScene
from rollbench.compare.scenes.friction_kinds.common import KindScene
from rollbench.compare.scenes.friction_kinds.screw_balls import ScrewPairScene
from rollbench.compare.studies.friction.linear_kinds import linear_loads
from rollbench.lowfi.friction.bearing import SIDES, solve_ball
from rollbench.lowfi.friction.linear.chain import prepare, solve_linear_chain
from rollbench.lowfi.friction.screw.run import solve_pair


def low_order(scene: KindScene) -> tuple[dict[str, float], float, str]:
    """Values by name, seconds of a second solve, and "converged" or why not; kinds as in
    `compare.studies.rolling.cases.case_of`."""
    kinds: dict[type[KindScene], Callable[[Any], tuple[dict[str, float], str]]]
    kinds = {LinearScene: _linear, ScrewPairScene: _screw, BearingBallScene: _ring}
    solver = next(solver for kind, solver in kinds.items() if isinstance(scene, kind))
    solver(scene)
    begin = perf_counter()
    values, status = solver(scene)
    return values, perf_counter() - begin, status


def _linear(scene: LinearScene) -> tuple[dict[str, float], str]:
    angles, force, _ = linear_loads(scene)
    apart, near = (
        solve_linear_chain(prepare(scene.bearing, angles, force, t), fast=False) for t in (False, scene.gap <= 0.0)
    )
    out = {f"force {k + 1}-{k + 2} N": float(f) for k, f in enumerate(near.ball_force)}
    out |= {f"deviation {k + 1} apart %": 100.0 * float(v) for k, v in enumerate(apart.deviation)}
    out |= {"loss apart mW": 1e3 * apart.loss, "loss touching mW": 1e3 * near.loss}
    out |= {"drive apart N": apart.drive, "drive touching N": near.drive}
    out["increase %"] = 100.0 * (near.loss / apart.loss - 1.0)
    return out, next((r.status for r in (apart, near) if r.status != "converged"), "converged")


def _screw(scene: ScrewPairScene) -> tuple[dict[str, float], str]:
    found = solve_pair(scene.pair)
    apart, near = found.free.motion, found.touching.motion
    out = {"force 1-2 N": found.force}
    out |= {f"orbit {k + 1} apart rad/s": float(q[0]) for k, q in enumerate(apart.q)}
    out |= {"loss apart mW": 1e3 * apart.loss, "loss touching mW": 1e3 * near.loss}
    out["increase %"] = 100.0 * found.friction_increase
    return out, "converged" if found.converged else "loads and friction do not agree"


def _ring(scene: BearingBallScene) -> tuple[dict[str, float], str]:
    found = solve_ball(scene.bearing, scene.force, scene.displacement)
    q, loss = found.motion.q, found.motion.friction.loss
    out = {"orbit rad/s": float(q[0]), "omega x rad/s": float(q[1]), "omega y rad/s": float(q[2])}
    out |= {f"loss {n} mW": 1e3 * float(v) for n, v, f in zip(SIDES, loss, found.load.force, strict=True) if f > 0.0}
    return out | {"torque N mm": 1e3 * found.torque}, "converged" if found.motion.status != "failed" else "failed"
