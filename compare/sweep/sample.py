"""One sample of a sweep: the scene with other values, solved, and the few numbers that are kept."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from compare.errors import InputError
from compare.models.axis import run_axis
from compare.models.axis_answers import along_axis, axial_load
from compare.models.registry import Options, run_model
from compare.scenes import scene_file
from compare.sweep import store
from compare.sweep.keys import Vary, changed
from lowfi.statics.axis.result import AxisResult
from lowfi.statics.result import StaticResult
from meshes.axis import Assembly
from meshes.parts import SIDES, Scene

#: What is kept of a solved sample: key and heading.
OUTPUTS = {
    "largest_load_N": "largest contact load / N",
    "mean_load_N": "mean loaded contact / N",
    "loaded_contacts": "loaded contacts",
    "idle_balls": "balls without load",
    "displacement_um": "displacement at the load / um",
    "largest_approach_um": "largest approach of a contact / um",
}
CONVERGED = "converged"
#: Balls on one shaft from which a sample by plain Python takes seconds.
AXIS_COMPILED = 40


def outputs(scene: Scene, result: StaticResult) -> dict[str, Any]:
    """Numbers of a converged result: `OUTPUTS`, and ``at``, the ball and side of the largest load."""
    load = result.load
    ball, side = np.unravel_index(int(load.argmax()), load.shape)
    loaded = load > 0.0
    return {
        "largest_load_N": float(load.max()),
        "mean_load_N": float(load[loaded].mean()) if loaded.any() else 0.0,
        "loaded_contacts": int(np.count_nonzero(loaded)),
        "idle_balls": int(np.count_nonzero(~loaded.any(axis=1))),
        "displacement_um": _displacement(scene, result),
        "largest_approach_um": 1e6 * float((result.hertz_C * np.cbrt(load) ** 2).max()),
        "at": f"{ball + 1} {SIDES[side]}" if loaded.any() else "",
    }


def _displacement(scene: Scene, result: StaticResult) -> float | None:
    """Displacement of the loaded stations along the forces there [um], weighted by the forces; None without a force."""
    work = total = 0.0
    for x in scene.loads:
        motion = result.centreline[int(np.abs(result.centreline_z - x.at).argmin())]
        work += float(np.dot(x.force, motion[:3]))
        total += float(np.linalg.norm(x.force))
    return 1e6 * work / total if total > 0.0 else None


@lru_cache(maxsize=8)
def _tables(text: str, origin: str) -> dict[str, Any]:
    return scene_file.read_toml(text, origin)


def solve_sample(
    text: str, origin: str, keys: Sequence[Vary], values: Sequence[Any], model: str, engine: str
) -> dict[str, Any]:
    """Status and outputs of one sample; a scene or model that refuses the values is a status, with its reason."""
    try:
        scene = scene_file.read_tables(changed(_tables(text, origin), keys, values), origin)
        if isinstance(scene, Assembly):
            return _solve_axis(scene, model, engine)
        scene = scene_file.whole(scene, origin)
        result = run_model(scene, model, Options(discretisation=False, engine=engine))
    except InputError as error:
        return {"status": f"refused: {error}"}
    if not result.converged:
        return {"status": result.status}
    return {"status": CONVERGED, **outputs(scene, result)}


def _solve_axis(assembly: Assembly, model: str, engine: str) -> dict[str, Any]:
    """Status and outputs of several sets on one shaft; from `AXIS_COMPILED` balls on always by compiled kernels."""
    result = run_axis(assembly, model, "compiled" if assembly.ball_count >= AXIS_COMPILED else engine)  # type: ignore[arg-type]
    if not result.converged:
        return {"status": result.status}
    return {"status": CONVERGED, **axis_outputs(assembly, result)}


def axis_outputs(assembly: Assembly, result: AxisResult) -> dict[str, Any]:
    """`OUTPUTS` of several sets of balls together; ``at`` begins with the name of the set; displacement: along the axis, of
    what the scene asks about, from the unloaded place of the parts; approaches are those of balls.
    """
    rows = [(s.of.name, s.balls) for s in result.sets if s.balls is not None]
    loads = [balls.load for _, balls in rows]
    loaded = [load[load > 0.0] for load in loads]
    every = np.concatenate(loaded) if loaded else np.zeros(0)
    worst = int(np.argmax([load.max(initial=0.0) for load in loads])) if loads else 0
    at = ""
    if every.size:
        ball, side = np.unravel_index(int(loads[worst].argmax()), loads[worst].shape)
        at = f"{rows[worst][0]}: {ball + 1} {SIDES[side]}"
    return {
        "largest_load_N": float(every.max(initial=0.0)),
        "mean_load_N": float(every.mean()) if every.size else 0.0,
        "loaded_contacts": int(every.size),
        "idle_balls": sum(int(np.count_nonzero(~(load > 0.0).any(axis=1))) for load in loads),
        "displacement_um": 1e6 * along_axis(assembly, result) if axial_load(assembly) else None,
        "largest_approach_um": max((1e6 * float((b.hertz_C * np.cbrt(b.load) ** 2).max()) for _, b in rows), default=0.0),
        "at": at,
    }


def solve_batch(
    folder: str, token: str, sweep: tuple[str, str, tuple[Vary, ...], str, str], batch: list[tuple[int, list[Any]]]
) -> tuple[list[store.Record], bool]:
    """Records of the samples (number, values) of a batch, and whether they were appended to the folder here.

    A worker that does not see the run's folder sends them back unstored; one whose run is over stops.
    sweep: text and origin of the scene, keys, model, engine.
    """
    own = Path(folder)
    text, origin, keys, model, engine = sweep
    here = store.current(own, token)
    found: list[store.Record] = []
    with threadpool_limits(1, "blas"):
        if not here:
            return [_record(n, v, solve_sample(text, origin, keys, v, model, engine)) for n, v in batch], False
        with store.working(own):
            writer = store.Writer(own, token)
            for number, values in batch:
                if not store.current(own, token):
                    break
                record = _record(number, values, solve_sample(text, origin, keys, values, model, engine))
                writer.append(record)
                found.append(record)
    return found, True


def _record(number: int, values: Sequence[Any], solved: dict[str, Any]) -> store.Record:
    return {"sample": number, "values": list(values), **solved}
