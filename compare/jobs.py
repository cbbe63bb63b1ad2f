"""Runs of the 3D reference as jobs: what is missing, side by side where asked, each stored when it is done."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter

from compare.errors import InputError
from compare.memory import reset_peak
from compare.reference import (
    LEVELS,
    SOURCE_LEVEL,
    Run,
    Task,
    bodies_path,
    compute_with_bodies,
    groups,
    load,
    path_in,
    save,
    with_bodies,
)
from compare.variants import VARIANTS
from meshes.condensed import CondensedBodies, load_condensed
from meshes.parts import Scene

Step = Callable[[str], None]
#: Seconds between signs of life.
HEARTBEAT = 20.0


@dataclass(frozen=True)
class Engine:
    """Where jobs run: joblib's processes on this machine, or a Dask cluster at ``scheduler``; ``workers`` at once;
    ``cache``: folder of meshes and condensed parts (None: none)."""

    backend: str = "joblib"
    scheduler: str | None = None
    workers: int | None = None
    cache: Path | None = None


def plan(
    scenes: Sequence[Scene], levels: Sequence[int], variants: Sequence[str] = (), *, source: bool = False,
    ablate: bool = False,
) -> list[Task]:  # fmt: skip
    """Tasks of a study, dearest first: every level of every geometry, variants and ablation on the coarsest level."""
    tasks = []
    for group in groups(scenes):
        own = tuple(group)
        tasks += [Task(own, level, ablate=ablate and level == min(LEVELS)) for level in levels]
        if source:
            tasks.append(Task(own, SOURCE_LEVEL))
        tasks += [Task(own[:1], min(LEVELS), variant) for variant in variants]
    return sorted(tasks, key=lambda task: -task.weight)


def missing(tasks: Sequence[Task], stores: Sequence[Path]) -> list[Task]:
    """What no store holds yet, task by task; an ablation is missing where a run has none."""
    left = []
    for task in tasks:
        scenes = []
        for scene in task.scenes:
            run = load(scene, task.level, task.variant, stores)
            if run is None or (task.ablate and not run.without):
                scenes.append(scene)
        if scenes:
            left.append(replace(task, scenes=tuple(scenes)))
        elif with_bodies(task) and not any(bodies_path(s, task.scenes[0], task.level).exists() for s in stores):
            left.append(task)
    return left


def perform(task: Task, store: Path) -> tuple[list[Run], CondensedBodies | None]:
    """Compute a task and store what it gives at once, so that an interrupted study loses only what was under way.

    The record of peak memory starts anew, so that every run has its own.
    """
    reset_peak()
    runs, bodies = compute_with_bodies(task)
    for run, scene in zip(runs, task.scenes, strict=True):
        save(store, scene, run)
    keep_bodies(store, task, bodies)
    return runs, bodies


def keep_bodies(store: Path, task: Task, bodies: CondensedBodies | None) -> None:
    """Store the condensed bodies of a task. Raises InputError where the folder cannot be written to."""
    if bodies is None:
        return
    path = bodies_path(store, task.scenes[0], task.level)
    with suppress(OSError, ValueError):  # none yet, or a damaged one
        if len(load_condensed(path).sides) > len(bodies.sides):
            return
    try:
        bodies.save(path)
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(str(path), "file", reason, "a folder that can be written to", "check the path") from None


def ensure(tasks: Sequence[Task], store: Path, engine: Engine, step: Step, stores: Sequence[Path] = ()) -> int:
    """Compute what neither ``store`` nor ``stores`` hold; returns how many tasks that were."""
    from compare import parallel

    left = [replace(task, cache=engine.cache) for task in missing(tasks, (store, *stores))]
    if not left:
        return 0
    start, done, total = perf_counter(), 0.0, sum(task.weight for task in left)
    step(f"3D reference: {len(left)} set-ups to compute, stored in {store}")
    jobs = [(perform, (task, store)) for task in left]
    finished = 0

    def reached(index: int, made: tuple[list[Run], CondensedBodies | None]) -> None:
        nonlocal done, finished
        task = left[index]
        runs, bodies = made
        for run, scene in zip(runs, task.scenes, strict=True):
            if not path_in(store, scene, task.level, task.variant).exists():
                save(store, scene, run)  # computed on a machine that does not share this folder
        if bodies is not None and not bodies_path(store, task.scenes[0], task.level).exists():
            keep_bodies(store, task, bodies)
        done += task.weight
        finished += 1
        spent = perf_counter() - start
        rest = spent * (total - done) / done
        bad = sorted({run.status for run in runs} - {"converged"})
        tail = f" ({'; '.join(bad)})" if bad else ""
        ahead = f", about {rest:.0f} s left" if finished < len(left) else ""
        step(f"[{finished}/{len(left)}] {task.label}{tail}: {spent:.0f} s{ahead}")

    over = threading.Event()

    def pulse() -> None:
        while not over.wait(HEARTBEAT):
            step(f"... {perf_counter() - start:.0f} s, {finished} of {len(left)} done")

    threading.Thread(target=pulse, daemon=True).start()
    try:
        for number, made in parallel.as_done(jobs, engine.backend, engine.scheduler, engine.workers):
            reached(number, made)
    finally:
        over.set()
    return len(left)


def all_variants() -> tuple[str, ...]:
    """Names of all modelling variants."""
    return tuple(VARIANTS)
