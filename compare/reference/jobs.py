"""Planning and computing runs of the 3D reference: missing runs, expected time and memory, parallel execution.

Expected time and memory of each stage are fitted to the stored runs of 17 screws and bearings (6 to 264 contacts, four mesh
levels), within a factor of two. Each run used one process, with another run at the same time, on two cores of 2026. The
effect of several processes for one run was measured on Lin's case 1 on level 3, and on screws with 228 and 264 contacts on
level 1. Level 5 was not measured; it is assumed to take twice as much as level 4.
"""

from __future__ import annotations

import threading
from _thread import interrupt_main
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import compress
from pathlib import Path
from time import perf_counter

from rollbench.compare.errors import InputError
from rollbench.compare.quantities import count_with_noun
from rollbench.compare.reference import parallel
from rollbench.compare.reference.computing import are_condensed_bodies_stored, compute_runs_and_bodies
from rollbench.compare.reference.levels import LEVELS, PRODUCTION, SOURCE_LEVEL, VARIANTS
from rollbench.compare.reference.store import Run, load_stored_run, path_of_bodies, path_of_run, save_run
from rollbench.compare.reference.tasks import ReferenceTask, Solvable, group_scenes_by_geometry, mesh_specifications
from rollbench.compare.running import available_GB, format_duration, output_closed, usable_cores
from rollbench.meshes.cache import StageMessage
from rollbench.meshes.condensed import CondensedBodies
from rollbench.meshes.processes import reset_peak_memory

#: Time of the finely meshed contact patches by mesh level [s], independent of the number of contacts.
PATCHES = {0: 3.0, 1: 13.0, 2: 25.0, 3: 45.0, 4: 100.0, 5: 200.0}

#: Time per contact of each stage other than the patches, on mesh level 1 [s].
A_CONTACT = {"meshes": 0.02, "shaft section": 0.05, "screw": 0.08, "nut": 0.06, "contact loads": 0.02}

#: Factor on the times per contact by mesh level; 1 on level 1.
GROWTH = {0: 0.4, 1: 1.0, 2: 1.2, 3: 1.8, 4: 3.0, 5: 6.0}

#: Part of the peak memory that does not depend on the number of contacts, by mesh level [GB].
BASE_GB = {0: 0.6, 1: 0.65, 2: 0.9, 3: 1.3, 4: 2.2, 5: 4.4}

#: Part of the peak memory for each contact [GB].
CONTACT_GB = 0.0103

#: Stages that are divided between two processes, factor by which these stages are then faster, and memory that the second
#: process adds: up to `TOGETHER` contacts the share `MORE` of the memory of one process. With more contacts the second
#: process computes only patches (`hifi.setup.TOGETHER`) and adds the share `PATCHES_ALONE` of `BASE_GB`.
SHARED, FASTER, MORE, TOGETHER = ("meshes", "patches", "ball", "shaft section", "screw", "nut"), 1.7, 0.7, 160

#: Memory of a second process that computes only patches, as a share of `BASE_GB`.
PATCHES_ALONE = 0.68

#: Stages of a task in the order in which they are computed, by their names in `hifi.setup.mesh_and_condense_geometry`.
STAGES = ("meshes", "patches", "shaft section", "screw", "nut", "ball", "contact loads")


@dataclass(frozen=True)
class ExpectedCost:
    """Expected computing time and memory of a task of the 3D reference."""

    #: Expected time of each stage of the task [s], by the name of the stage.
    seconds_by_stage: dict[str, float]
    #: Expected peak memory of the task [GB].
    memory_GB: float

    @property
    def seconds(self) -> float:
        """Expected computing time of all stages of the task together [s]."""
        return sum(self.seconds_by_stage.values())


def expected_time_and_memory(task: ReferenceTask) -> ExpectedCost:
    """Estimate computing time and memory of a task of the 3D reference from its mesh level and number of contacts."""
    by_bodies = [len(up.meshed_flanks) * up.parts.ball_count for up in mesh_specifications(task.scenes, task.level)]
    contacts = sum(by_bodies)
    times = len(task.scenes) * (6 if task.leave_out_each_part else 1)
    stages = {name: GROWTH[task.level] * A_CONTACT.get(name, 0.0) * contacts for name in STAGES}
    stages |= {"patches": len(by_bodies) * PATCHES[task.level], "ball": float(len(by_bodies))}
    stages["contact loads"] *= times
    memory = BASE_GB[task.level] + CONTACT_GB * contacts
    if task.processes > 1:
        stages |= {name: stages[name] / FASTER for name in SHARED}
        memory += MORE * memory if contacts <= TOGETHER else PATCHES_ALONE * BASE_GB[task.level]
    return ExpectedCost(stages, memory)


def check_memory(tasks: Sequence[ReferenceTask], workers: int) -> float:
    """Estimate the peak memory of tasks of the 3D reference that run in parallel, and check that as much memory is free.

    Parameters
    ----------
    tasks
        The tasks.
    workers
        Number of tasks that run at the same time.

    Returns
    -------
    float
        Memory [GB].

    Raises
    ------
    InputError
        If this machine has less free memory.
    """
    each = sorted((expected_time_and_memory(task).memory_GB for task in tasks), reverse=True)
    peak, free = sum(each[:workers]), available_GB()
    if free is not None and peak > free:
        largest = max(tasks, key=lambda task: expected_time_and_memory(task).memory_GB)
        fewer = f"fewer workers (`workers={workers - 1}`), " if workers > 1 else ""
        value, allowed = f"{free:.1f} GB free", f"at least about {peak:.1f} GB for {largest.label}"
        advice = f"end other programs, or use {fewer}a coarser level (`levels=1`) or a cluster (`backend=dask`)"
        raise InputError("this machine", "memory", value, allowed, advice)
    return peak


class TaskProgress:
    """Progress of a running task of the 3D reference: present stage, elapsed fraction of its time, expected time left."""

    def __init__(self, task: ReferenceTask, after: float = 0.0) -> None:
        """Start the progress of a task; ``after``: expected time of all tasks that follow it [s]."""
        self.label, self.after = task.label, after
        stages, scenes = expected_time_and_memory(task).seconds_by_stage, len(task.scenes)
        loads = stages.pop("contact loads")
        self.stages = [*stages.items(), *[("contact loads", loads / scenes)] * scenes]
        self.done = self.computed = 0.0

    @property
    def present_stage_text(self) -> str:
        """Text for the terminal: name of the task and, until it is finished, its present stage."""
        return f"{self.label}: {self.stages[0][0]}" if self.stages else self.label

    def progress_line(self, text: str, spent: float) -> str:
        """Return a message as a line of progress, with the expected time left if the message reports the end of a stage.

        ``text``: the message, a `StageMessage` at the end of a stage; ``spent``: time since the task began [s]. The speed
        of the machine is estimated from computed stages only, not from those that were read from the cache.
        """
        stage = next((s for s in self.stages if isinstance(text, StageMessage) and s[0] == text.stage), None)
        if stage is None or not isinstance(text, StageMessage):
            return f"{self.label}: {text}"
        self.stages.remove(stage)
        self.done += stage[1]
        self.computed += 0.0 if text.cached else stage[1]
        left = sum(seconds for _, seconds in self.stages)
        pace = min(max(spent / self.computed, 0.1), 10.0) if self.computed else 1.0
        total = f"about {format_duration(pace * (left + self.after))} left"
        return f"{self.label}: {text}; {self.done / (self.done + left):.0%}, {total}{' in all' if self.after else ''}"


#: Function that is called with each line of progress.
Step = Callable[[str], None]

#: Interval between regular messages on the progress of a task [s].
HEARTBEAT = 20.0


@dataclass(frozen=True)
class ComputingSettings:
    """Settings for computing runs of the 3D reference: this machine or a cluster, number of jobs at once, cache folder."""

    #: ``joblib``: processes on this machine; ``dask``: a cluster.
    backend: str = "joblib"
    #: Address of the scheduler of a Dask cluster; None: a cluster is started on this machine.
    scheduler_address: str | None = None
    #: Number of jobs that run at the same time; None: one, or one on each worker of a Dask cluster.
    parallel_jobs: int | None = None
    #: Folder in which meshes and condensed parts are cached; None: no cache.
    cache_folder: Path | None = None

    @property
    def processes_per_job(self) -> int:
        """Number of processes for one job: cores of this machine over the jobs at the same time; one on a cluster."""
        return max(usable_cores() // (self.parallel_jobs or 1), 1) if self.backend == "joblib" else 1


def plan_reference_tasks(
    scenes: Sequence[Solvable],
    levels: Sequence[int],
    variants: Sequence[str] = (),
    *,
    with_source_mesh: bool = False,
    leave_out_each_part: bool = False,
) -> list[ReferenceTask]:
    """List the computations of the 3D reference (tasks) for a mesh study, in the order in which they are computed.

    The coarsest level of every geometry comes first; the other tasks follow by decreasing computing time.

    Parameters
    ----------
    scenes
        Scenes with one load case each.
    levels
        Mesh levels.
    variants
        Names of variants of the 3D reference (`VARIANTS`), each computed on the mesh level that belongs to it.
    with_source_mesh
        Whether a task on the mesh of Lin's thesis is added.
    leave_out_each_part
        Whether the scenes are also solved on the coarsest level with each part of the 3D model (such as the elastic nut)
        left out in turn.

    Returns
    -------
    list of ReferenceTask
        The tasks.
    """
    tasks = []
    for cases in map(tuple, group_scenes_by_geometry(scenes)):
        tasks += [
            ReferenceTask(cases, level, leave_out_each_part=leave_out_each_part and level == min(LEVELS))
            for level in levels
        ]
        if with_source_mesh:
            tasks.append(ReferenceTask(cases, SOURCE_LEVEL))
        tasks += [ReferenceTask(cases[:1], VARIANTS[variant].level, variant) for variant in variants]
        if any(VARIANTS[variant].refined for variant in variants):
            tasks.append(ReferenceTask(cases[:1], PRODUCTION, "base"))  # baseline for variants that refine one mesh setting

    def position(task: ReferenceTask) -> tuple[bool, float]:
        """Return the sort key of a task: coarsest level first, then by decreasing time."""
        return task.level != min(levels, default=None) or bool(task.variant), -expected_time_and_memory(task).seconds

    return sorted(tasks, key=position)


def tasks_without_stored_runs(tasks: Sequence[ReferenceTask], stores: Sequence[Path]) -> list[ReferenceTask]:
    """Return those tasks of the 3D reference that are not stored yet, reduced to the scenes without a stored result.

    ``tasks``: the required tasks; ``stores``: folders that are searched. A task whose condensed screw and nut are required
    but not stored is returned with all its scenes.
    """
    left = []
    for task in tasks:
        runs = [load_stored_run(scene, task.level, task.variant, stores) for scene in task.scenes]
        lacking = (run is None or (task.leave_out_each_part and not run.without) for run in runs)
        scenes = tuple(compress(task.scenes, lacking))
        if scenes:
            left.append(replace(task, scenes=scenes))
        elif are_condensed_bodies_stored(task) and not all(
            run and any(path_of_bodies(store, scene, run).exists() for store in stores)
            for scene, run in zip(task.single_row_scenes, runs, strict=True)
        ):
            left.append(task)
    return left


def compute_and_store(
    task: ReferenceTask, store: Path, step: Step = lambda _: None, progress: TaskProgress | None = None
) -> tuple[list[Run], CondensedBodies | None]:
    """Compute one task of the 3D reference and store its results immediately.

    If a mesh study with several tasks is interrupted, only the results of the unfinished task are lost.

    Parameters
    ----------
    task
        The task.
    store
        Folder to which the runs are written.
    step
        Function that is called with lines of progress.
    progress
        Record of the task's progress, which gives the expected time left; None: a new record.

    Returns
    -------
    list of Run
        A run for each scene, with its peak memory.
    CondensedBodies or None
        Condensed screw and nut, if the task stores them.
    """
    reset_peak_memory()
    start, progress = perf_counter(), progress or TaskProgress(task)
    runs, bodies = compute_runs_and_bodies(task, lambda text: step(progress.progress_line(text, perf_counter() - start)))
    store_runs_and_condensed_bodies(store, task, runs, bodies)
    return runs, bodies


def store_runs_and_condensed_bodies(
    store: Path, task: ReferenceTask, runs: Sequence[Run], bodies: CondensedBodies | None
) -> None:
    """Write the results of one task of the 3D reference, and its condensed screw and nut, to the folder ``store``.

    Results (runs) whose contact loads cannot be used are not written.

    ``runs``: a run for each scene of the task; ``bodies``: condensed screw and nut; None: none are written. InputError if
    the file of the bodies cannot be written.
    """
    for run, scene in zip(runs, task.scenes, strict=True):
        if run.answers:
            save_run(store, scene, run)
    if bodies is None:
        return
    path = path_of_bodies(store, task.single_row_scenes[0], runs[0])
    try:
        bodies.save(path)
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(str(path), "file", reason, "a file in a writable folder", "check the path") from None


def ensure_runs_are_stored(
    tasks: Sequence[ReferenceTask],
    store: Path,
    engine: ComputingSettings,
    step: Step,
    further_stores: Sequence[Path] = (),
    *,
    compute_again: bool = False,
    after_each_stored_task: Callable[[ReferenceTask], None] = lambda _: None,
) -> list[Run]:
    """Compute and store all required results (runs) of the 3D reference that are not stored yet.

    Parameters
    ----------
    tasks
        Tasks whose runs are required.
    store
        Folder to which new runs are written.
    engine
        Settings that determine where runs are computed.
    step
        Function that is called with lines of progress, first with the expected time.
    further_stores
        Further folders that are searched for runs.
    compute_again
        Whether stored runs are computed again.
    after_each_stored_task
        Function that is called after every stored task except the last.

    Returns
    -------
    list of Run
        Computed runs without usable loads, because they did not converge; empty if there are none.

    Raises
    ------
    InputError
        If this machine has too little free memory.
    """
    wanted = tasks if compute_again else tasks_without_stored_runs(tasks, (store, *further_stores))
    local = engine.backend == "joblib"
    left = [replace(task, cache_folder=engine.cache_folder, processes=engine.processes_per_job) for task in wanted]
    failed: list[Run] = []
    if not left:
        return failed
    start, done = perf_counter(), 0.0
    alone = local and (engine.parallel_jobs or 1) == 1
    step(_text_announcing_tasks(left, len(tasks) - len(left), store, engine.parallel_jobs or 1, here=local))
    seconds = [expected_time_and_memory(task).seconds for task in left]
    progress = [TaskProgress(task, sum(seconds[k + 1 :])) for k, task in enumerate(left)]
    jobs = [
        (compute_and_store, (task, store, step, p) if alone else (task, store))
        for task, p in zip(left, progress, strict=True)
    ]
    finished = 0

    over = threading.Event()

    def report_progress_regularly() -> None:
        while not over.wait(HEARTBEAT):
            if output_closed():
                interrupt_main()
                return
            stage = f"; {progress[finished].present_stage_text}" if alone and finished < len(left) else ""
            step(f"[{finished}/{len(left)}] {perf_counter() - start:.0f} s{stage}")

    threading.Thread(target=report_progress_regularly, daemon=True).start()
    try:
        for number, (runs, bodies) in parallel.run_jobs(
            jobs, engine.backend, engine.scheduler_address, engine.parallel_jobs
        ):
            task = left[number]
            good = [(scene, run) for scene, run in zip(task.scenes, runs, strict=True) if run.answers]
            if not all(path_of_run(store, scene, run).exists() for scene, run in good):  # computed without the folder
                store_runs_and_condensed_bodies(store, task, runs, bodies)
            failed.extend(run for run in runs if not run.answers)
            done += seconds[number]
            finished += 1
            spent = perf_counter() - start
            rest = spent * (sum(seconds) - done) / done
            lost = [run for run in runs if run.status != "converged"]
            bad = [f"{run.scene}: {'' if run.answers else 'not stored: '}{run.status}" for run in lost]
            tail = f" ({'; '.join(bad)})" if bad else ""
            ahead = f", about {rest:.0f} s left" if finished < len(left) else ""
            step(" ".join(f"[{finished}/{len(left)}] {task.label}{tail}: {spent:.0f} s{ahead}".split()))
            if finished < len(left):
                after_each_stored_task(task)
    except KeyboardInterrupt:
        if output_closed():
            raise BrokenPipeError from None
        stages = "" if engine.cache_folder is None else f", and finished stages of the next one in {engine.cache_folder}"
        kept = f"{finished} of {len(left)} set-ups are stored in {store}{stages}"
        step(f"WARNING: interrupted: {kept}; the same command continues from there")
        raise
    finally:
        over.set()
    return failed


def _text_announcing_tasks(left: Sequence[ReferenceTask], stored: int, store: Path, workers: int, *, here: bool) -> str:
    """Return the message that announces how many tasks are to be computed, with their expected time and memory.

    ``left``: the tasks to compute; ``stored``: number of tasks whose runs are stored already; ``store``: folder of new
    runs; ``workers``: number of tasks at the same time; ``here``: whether they run on this machine. InputError if the free
    memory of this machine is too small.
    """
    kept = f", {stored} are stored" if stored > 0 else ""
    head = f"3D reference: {count_with_noun(len(left), 'set-up')} to compute{kept}"
    if not here:
        return f"{head}; stored in {store}"
    memory = check_memory(left, workers)
    time = format_duration(sum(expected_time_and_memory(task).seconds for task in left) / workers)
    return f"{head}; expected: about {time}, up to {memory:.1f} GB of memory; stored in {store}"


def variant_names(*, refined: bool) -> tuple[str, ...]:
    """Return the names of the variants of the 3D reference that refine one mesh setting, or that change another choice."""
    return tuple(name for name, variant in VARIANTS.items() if bool(variant.refined) == refined)
