"""``rollbench solve SCENE --members N``: bands and distributions of a scene with random errors."""

from __future__ import annotations

import csv
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from rollbench.compare.errors import ArgumentError
from rollbench.compare.models.registry import default_model
from rollbench.compare.quantities import number
from rollbench.compare.reference.jobs import Engine
from rollbench.compare.scenes.duty_cycle import Described, DutyCycle
from rollbench.compare.scenes.scene_file import each_case
from rollbench.compare.studies.members.blocks import KEPT, OF_SET, WHOLE, columns, with_seed
from rollbench.compare.studies.members.members import Bands, Members, run_members, statistics
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import SIDES, Scene


def library(
    described: Described, model: str, count: int, seed: int | None, workers: int | None, step: Callable[[str], None]
) -> dict[str, Any]:
    """What `rollbench.ensemble` returns of a scene, JSON-ready. Raises InputError."""
    each, cases = solved(described, described.name, model, count, seed, Engine(workers=workers), step)
    return whole(described, each, cases)


def whole(described: Described, each: Sequence[Members], cases: Sequence[str]) -> dict[str, Any]:
    """JSON-ready answer: of a scene, or of each of its load cases."""
    data = [as_json(batch) for batch in each]
    by_case = [{"case": case} | x for case, x in zip(cases, data, strict=True)] if cases else []
    return {"scene": described.name, "cases": by_case} if cases else data[0]


def solved(
    described: Described,
    name: str,
    model: str,
    count: int,
    seed: int | None,
    engine: Engine,
    step: Callable[[str], None],
    csv_out: Path | None = None,
) -> tuple[list[Members], list[str]]:
    """Members of the scene, or of each of its load cases, and the names of these. Raises InputError."""
    if seed is not None and not 0 <= seed < 2**62:
        raise ArgumentError("seed", str(seed), f"0 to {2**62 - 1}", "leave it out for the scene's")
    cases = [case.name for case in described.cases] if isinstance(described, DutyCycle) else []
    scenes = [scene if seed is None else with_seed(scene, seed) for scene in each_case(described, name)]
    each: list[Members] = []
    with _rows(csv_out, [*(["case"] if cases else []), "member", "status", *columns(scenes[0])]) as write:
        for scene, head in zip(scenes, [[case] for case in cases] or [[]], strict=True):
            row = partial(_row, write, head)
            each.append(run_members(scene, model or default_model(scene), count, engine, step, row))
    return each, cases


def _row(write: Callable[[list[Any]], None], head: Sequence[str], member: int, status: str, kept: Array) -> None:
    write([*head, member, status, *("" if np.isnan(v) else repr(float(v)) for v in kept)])


@contextmanager
def _rows(path: Path | None, names: Sequence[str]) -> Iterator[Callable[[list[Any]], None]]:
    """A writer of rows to the file, which gets its name only when it is complete."""
    if path is None:
        yield lambda *_: None
        return
    unfinished = path.with_name(f".{path.name}.part")
    try:
        with unfinished.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(names)
            yield writer.writerow
        os.replace(unfinished, path)
    except OSError as error:
        reason = error.strerror or str(error)
        raise ArgumentError("csv", reason, "a file that can be written", "check the path", str(path)) from None
    finally:
        unfinished.unlink(missing_ok=True)


def as_json(members: Members) -> dict[str, Any]:
    """JSON-ready: statistics of what is kept, failures, bands of every contact that any member loads. Of several sets,
    their statistics stand in ``sets``, and rows of ``balls`` begin with their set."""
    scene, kept = members.scene, members.kept
    counts: dict[str, Any] = {"members": len(kept), "converged": len(kept) - len(members.failed)}
    counts["failed"] = [{"member": m, "status": s} for m, s in sorted(members.failed.items())]
    rows = _balls(members.bands)
    if isinstance(scene, Assembly):
        seed: Any = [s.parts.errors.seed if isinstance(s.parts, Scene) else None for s in scene.sets]
        counts["sets"] = _sets(members, scene)
        balls = [
            {"set": i + 1, **x, "index": x["index"] - place.start}
            for i, place in enumerate(members.balls)
            if place is not None
            for one in rows[place]
            for x in one
        ]
    else:
        seed, balls = scene.errors.seed, [x for one in rows for x in one]
    names = WHOLE if isinstance(scene, Assembly) else KEPT
    sums = {key: statistics(kept[:, k]) for k, key in enumerate(names)}
    head = {"scene": scene.name, "model": members.model, "seed": seed, **counts, "statistics": sums}
    return {**head, "band_resolution_N": number(members.bands.width), "balls": balls}


def _sets(members: Members, assembly: Assembly) -> list[dict[str, Any]]:
    """Statistics of each set."""
    by_set = np.split(members.kept[:, len(WHOLE) :], len(assembly.sets), axis=1)
    return [
        {"set": i + 1, "name": s.name, "statistics": {key: statistics(kept[:, k]) for k, key in enumerate(OF_SET)}}
        for i, (s, kept) in enumerate(zip(assembly.sets, by_set, strict=True))
    ]


def _balls(bands: Bands) -> list[list[dict[str, Any]]]:
    """Rows of the loaded contacts of every ball."""
    found = {
        "without_random_errors_N": bands.nominal,
        "mean_N": bands.mean,
        "standard_deviation_N": bands.deviation,
        "smallest_N": bands.smallest,
        **{f"quantile_{level:g}_N": bands.quantile(level) for level in (0.05, 0.5, 0.95)},
        "largest_N": bands.largest,
        "loaded_share": bands.loaded,
    }
    return [
        [
            {"index": i + 1, "side": side, **{key: number(values[i, s]) for key, values in found.items()}}
            for s, side in enumerate(SIDES)
            if bands.largest[i, s] > 0.0
        ]
        for i in range(bands.nominal.shape[0])
    ]
