"""One sample of a sweep: the scene with other values, solved, and the few numbers that are kept."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from contextlib import nullcontext
from functools import lru_cache
from pathlib import Path
from typing import Any

from rollbench.compare.errors import InputError
from rollbench.compare.models.registry import Options, run_model
from rollbench.compare.scenes import scene_file, scene_tables
from rollbench.compare.scenes.duty_cycle import DutyCycle
from rollbench.compare.studies.sweep import store
from rollbench.compare.studies.sweep.keys import Vary, changed
from rollbench.compare.studies.sweep.outputs import OUTPUTS, axis_outputs, cycle_outputs, outputs
from rollbench.lowfi.statics.result import AxisResult, StaticResult
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Scene

CONVERGED = "converged"
_NUMBER = re.compile(r"[0-9][0-9.]*(e[+-]?[0-9]+)?")
#: Balls on one shaft from which a sample by plain Python takes seconds.
AXIS_COMPILED = 40


@lru_cache(maxsize=8)
def _tables(text: str, origin: str) -> dict[str, Any]:
    return scene_file.read_toml(text, origin)


def solve_sample(
    text: str,
    origin: str,
    keys: Sequence[Vary],
    values: Sequence[Any],
    model: str,
    engine: str,
    wanted: Collection[str] = tuple(OUTPUTS),
) -> dict[str, Any]:
    """Status and outputs of one sample, those that are wanted; a scene or model that refuses the values is a status, with
    its reason."""
    try:
        return attempt(text, origin, keys, values, model, engine, wanted)
    except InputError as error:
        return {"status": f"refused: {error}", "reason": reason(error)}


def attempt(
    text: str,
    origin: str,
    keys: Sequence[Vary],
    values: Sequence[Any],
    model: str,
    engine: str,
    wanted: Collection[str] = tuple(OUTPUTS),
) -> dict[str, Any]:
    """The same of values that scene and model take; raises InputError for others."""
    scene = scene_tables.read_tables(changed(_tables(text, origin), keys, values), origin)
    if isinstance(scene, DutyCycle):
        return _solve_cases(scene, model, engine, wanted)
    result, kept = _solve(scene_file.solvable(scene, origin), model, engine, wanted)
    return {"status": result.status, **kept}


def reason(error: InputError) -> str:
    """Why values are refused, without the numbers, as a range depends on the sample."""
    return _NUMBER.sub("#", f"{error.key}: {error.allowed or error.value}")


def _solve_cases(cycle: DutyCycle, model: str, engine: str, wanted: Collection[str]) -> dict[str, Any]:
    solved = [_solve(case.scene, model, engine, wanted) for case in cycle.cases]
    for case, (result, _) in zip(cycle.cases, solved, strict=True):
        if not result.converged:
            return {"status": f"case {case.name}: {result.status}"}
    return {"status": CONVERGED, **cycle_outputs(cycle, *zip(*solved, strict=True), wanted=wanted)}


def _solve(
    scene: Scene | Assembly, model: str, engine: str, wanted: Collection[str]
) -> tuple[StaticResult | AxisResult, dict[str, Any]]:
    """Result and outputs of one load case; several sets are solved from `AXIS_COMPILED` balls on always by compiled
    kernels."""
    if isinstance(scene, Assembly):
        kernels = "compiled" if scene.ball_count >= AXIS_COMPILED else engine
        found = run_model(scene, model, Options(engine=kernels))
        return found, axis_outputs(scene, found, kernels, wanted) if found.converged else {}
    options = Options(discretisation=False, engine=engine)
    result = run_model(scene, model, options)
    return result, outputs(scene, result, model, options, wanted) if result.converged else {}


def solve_batch(
    folder: str,
    token: str,
    sweep: tuple[str, str, tuple[Vary, ...], str, str, tuple[str, ...]],
    batch: list[tuple[int, list[Any]]],
) -> tuple[list[store.Record], bool]:
    """Records of the samples (number, values) of a batch, and whether they were appended to the folder here, together.

    A worker that does not see the run's folder, or whose run is over, does not write there and sends them back.
    sweep: text and origin of the scene, keys, model, engine, outputs that are wanted.
    """
    run_folder = Path(folder)
    text, origin, keys, model, engine, wanted = sweep
    here = store.current(run_folder, token)
    found: list[store.Record] = []
    with store.working(run_folder) if here else nullcontext():
        try:
            for number, values in batch:
                solved = solve_sample(text, origin, keys, values, model, engine, wanted)
                found.append({"sample": number, "values": values, **solved})
        finally:  # of an interrupted batch too
            if here and found:
                store.Writer(run_folder, token).append(found)
    return found, here
