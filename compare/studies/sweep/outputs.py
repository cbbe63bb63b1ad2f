"""The few numbers that a sweep keeps of a solved sample."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from functools import cache
from typing import Any

import numpy as np

from rollbench.compare.models.answers import unloaded_place
from rollbench.compare.models.load_cases import cycle_life, loads_of
from rollbench.compare.models.loading import along_axis, axial_load, axial_preload, scaled, solve_scaled
from rollbench.compare.models.registry import Options, run_model
from rollbench.compare.scenes.duty_cycle import DutyCycle
from rollbench.lowfi.rating.life import life
from rollbench.lowfi.rating.rigidity import axial_displacement, axial_force
from rollbench.lowfi.statics.nominal import nominal_contacts
from rollbench.lowfi.statics.result import AxisResult, StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.loads import mean_load
from rollbench.meshes.parts import SIDES, Friction, Motion, Scene

#: What is kept of a solved sample: key and heading.
OUTPUTS = {
    "largest_load_N": "largest contact load / N",
    "mean_load_N": "mean contact load / N",
    "loaded_contacts": "loaded contacts",
    "idle_balls": "balls without load",
    "displacement_um": "displacement at the load / um",
    "largest_approach_um": "largest approach of a contact / um",
    "rigidity_N_per_um": "axial rigidity / (N/um)",
    "preload_N": "axial preload / N",
    "torque_Nmm": "friction torque / (N mm)",
    "life_million_revolutions": "life L10 / 10^6 revolutions",
}


#: The output that worst cases, effects and plots are about; always kept, with its place ``at``.
MAIN = "largest_load_N"

#: How outputs are computed, by name, called for those that are wanted alone.
Makers = dict[str, Callable[[], Any]]


def outputs(
    scene: Scene, result: StaticResult, model: str, options: Options, wanted: Collection[str] = tuple(OUTPUTS)
) -> dict[str, Any]:
    """Numbers of a converged result: those of `OUTPUTS` that are wanted, and ``at``, the ball and side of the largest load.

    Rigidity (secant, from the place without loads) and preload take the solution without loads, which is solved for them
    alone; the torque takes [friction] of the scene. None where there is no such answer.
    """

    @cache
    def bare() -> StaticResult:
        return solve_scaled(scene, 0.0, model, options)

    def rigidity() -> float | None:
        moved = axial_displacement(scene, result) - unloaded_place(scene, bare())
        return _rigidity(axial_force(result), moved)

    makers: Makers = {
        "displacement_um": lambda: _displacement(scene, result),
        "rigidity_N_per_um": rigidity,
        "preload_N": lambda: axial_preload(scene, bare()) if bare().converged else None,
    }
    return _of_sets([("", scene, result)], scene, makers, options, wanted, lambda: nominal_contacts(scene))


def cycle_outputs(
    cycle: DutyCycle,
    results: Sequence[StaticResult | AxisResult],
    each: Sequence[dict[str, Any]],
    *,
    wanted: Collection[str] = tuple(OUTPUTS),
) -> dict[str, Any]:
    """`OUTPUTS` of load cases: those of the case with the largest contact load, which ``at`` names; but the life over the
    duty cycle, of the set that lives shortest, and the mean torque over its revolutions. results, each: of every case its
    result and outputs."""
    case, worst = max(zip(cycle.cases, each, strict=True), key=lambda pair: float(pair[1][MAIN]))
    found = worst | {"at": f"case {case.name}: {worst['at']}"}
    if "torque_Nmm" in wanted:
        torques = [(share, one["torque_Nmm"]) for share, one in zip(cycle.shares, each, strict=True) if share > 0.0]
        known = all(torque is not None for _, torque in torques)
        found["torque_Nmm"] = sum(share * torque for share, torque in torques) if known else None
    if "life_million_revolutions" in wanted:
        lives = [cycle_life(cycle, name, [loads_of(one)[name] for one in results])[0] for name in cycle.sets]
        rated = [x.revolutions for x in lives if x is not None]
        found["life_million_revolutions"] = min(rated) if len(rated) == len(lives) else None
    return found


def axis_outputs(
    assembly: Assembly, result: AxisResult, engine: str, wanted: Collection[str] = tuple(OUTPUTS)
) -> dict[str, Any]:
    """`OUTPUTS` of several sets together, those that are wanted; loads are of contacts of balls and of rollers; ``at``
    begins with the name of the set; displacement: along the axis, of what the scene asks about, from the unloaded place of
    the parts; approaches, life and torque are those of balls, life of the set that lives shortest; preload: the largest
    axial force of a set without loads.
    """
    sets = [(f"{s.of.name}: ", s.of.parts, s.balls) for s in result.sets if s.balls and isinstance(s.of.parts, Scene)]
    force, moved = axial_load(assembly), along_axis(assembly, result)

    @cache
    def bare() -> AxisResult:
        without = run_model(scaled(assembly, 0.0), result.model, Options(engine=engine))
        assert isinstance(without, AxisResult)
        return without

    def preload() -> float | None:
        return max((abs(float(s.force[2])) for s in bare().sets), default=0.0) if bare().converged else None

    makers: Makers = {
        "displacement_um": lambda: 1e6 * moved if force else None,
        "rigidity_N_per_um": lambda: _rigidity(force, moved - along_axis(assembly, bare())) if bare().converged else None,
        "preload_N": preload,
    }
    rollers = [(f"{s.of.name}: roller ", s.loads) for s in result.sets if s.balls is None]
    return _of_sets(sets, assembly, makers, Options(), wanted, lambda: 0, rollers)


def _of_sets(
    sets: list[tuple[str, Scene, StaticResult]],
    scene: Scene | Assembly,
    whole: Makers,
    options: Options,
    wanted: Collection[str],
    contacts: Callable[[], int],
    rollers: Sequence[tuple[str, Array]] = (),
) -> dict[str, Any]:
    """`OUTPUTS` and ``at`` of the sets of a scene together, each with the words that name it. whole: makers of
    displacement [um], rigidity [N/um] and preload [N]; contacts: see `mean_load`; rollers: loads [N] of each row."""
    solved, friction = [(parts, balls) for _, parts, balls in sets], scene.friction
    named = [*((name, x.load) for name, _, x in sets), *rollers]
    every = np.concatenate([np.zeros(0), *(load[load > 0.0] for _, load in named)])
    at = ""
    if every.size:
        name, load = max(named, key=lambda one: float(one[1].max(initial=0.0)))
        one, *side = np.unravel_index(int(load.argmax()), load.shape)
        at = " ".join([f"{name}{one + 1}", *(SIDES[k] for k in side)])
    makers: Makers = {
        MAIN: lambda: float(every.max(initial=0.0)),
        "mean_load_N": lambda: mean_load(every, contacts()),
        "loaded_contacts": lambda: int(every.size),
        "idle_balls": lambda: sum(int(np.count_nonzero(~(x.load > 0.0).any(axis=1))) for _, x in solved),
        "largest_approach_um": lambda: max((_approach(balls) for _, balls in solved), default=None),
        "torque_Nmm": lambda: None if friction is None else _friction_torque(solved, friction, scene.motion, options),
        "life_million_revolutions": lambda: _life([(parts, balls.load) for parts, balls in solved]),
        **whole,
    }
    return {name: makers[name]() for name in OUTPUTS if name == MAIN or name in wanted} | {"at": at}


def _displacement(scene: Scene, result: StaticResult) -> float | None:
    """Displacement of the loaded stations along the forces there [um], weighted by the forces; None without a force."""
    work = total = 0.0
    for x in scene.loads:
        motion = result.centreline[int(np.abs(result.centreline_z - x.at).argmin())]
        work += float(np.dot(x.force, motion[:3]))
        total += float(np.linalg.norm(x.force))
    return 1e6 * work / total if total > 0.0 else None


def _approach(balls: StaticResult) -> float:
    return 1e6 * float((balls.hertz_C * np.cbrt(balls.load) ** 2).max(initial=0.0))


def _rigidity(force: float, moved: float) -> float | None:
    """Axial force [N] over displacement [m] in N/um; None without a force, or with a displacement against it."""
    return 1e-6 * force / moved if force * moved > 0.0 else None


def _life(sets: list[tuple[Scene, Array]]) -> float | None:
    """Shortest life of the sets [10^6 revolutions]; None without load, or where no rating takes them."""
    try:
        found = [life(scene, load) for scene, load in sets]
    except ValueError:
        return None
    return min((one.revolutions for one in found if one is not None), default=None)


def _friction_torque(
    sets: list[tuple[Scene, StaticResult]], friction: Friction, motion: Motion | None, options: Options
) -> float | None:
    """Friction torque of all sets [N mm]; None where it does not settle, or friction does not take a set."""
    from rollbench.compare.models.friction_sums import torque

    return torque(sets, friction, motion, options)
