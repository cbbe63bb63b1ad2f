"""Preparation of one geometry of the 3D reference: meshes, condensed patches, and compliance of screw, nut and balls.

Screw, nut and one ball are meshed coarsely, with a refinement box (a pocket for a fine patch) at every contact. One fine
patch per flank is condensed exactly and fits every refinement box of that flank. All load cases of the geometry share this
set-up, whatever their supports and manufacturing errors.

The parts of a set-up are computed in several processes of this machine (`compute_records`): gmsh and the sparse
factorisation handle one part at a time in each process.
"""

from __future__ import annotations

import os
from collections import Counter, deque
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial
from threading import Lock
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from rollbench.hifi import condensation
from rollbench.hifi.meshing.part_meshes import PartMeshes, list_part_mesh_calls
from rollbench.hifi.meshing.settings import Settings
from rollbench.hifi.shaft import section as shafts
from rollbench.hifi.shaft.beam import ShaftSection, round_section, tube_section
from rollbench.hifi.shaft.mounting import correct_beam_stiffness, subtract_cut_end_flexibility
from rollbench.meshes import processes as workers
from rollbench.meshes.cache import Cache, StageMessage
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.helix import BallLayout, ball_layout
from rollbench.meshes.parts import Scene
from rollbench.meshes.sockets import AZIMUTH_TURNED
from rollbench.meshes.solid import Dimensions, dimensions_of_3d_parts

#: Function that is called with a text on the progress.
Step = Callable[[str], None]
#: Largest number of contacts with which screw and nut are condensed in parallel; with more, each takes gigabytes of memory.
TOGETHER = 160


@dataclass
class CondensedGeometry:
    """Screw, nut and balls of one geometry, meshed and condensed to compliance matrices that serve all load cases."""

    #: Scene whose geometry was meshed and condensed.
    scene: Scene
    #: Geometry of the track: the map from groove coordinates to space.
    groove_map: GrooveMap
    #: Positions of the balls on the track.
    ball_positions: BallLayout
    #: Dimensions of the solid parts.
    solid_dimensions: Dimensions
    #: Mesh settings: cell sizes, modes and element type.
    mesh_settings: Settings
    #: Groove flanks (0, 1: screw, 2, 3: nut) that may carry load.
    loaded_flanks: tuple[int, ...]
    #: Condensed fine meshes (patches) of groove and ball at the contact on each flank.
    patches_by_flank: dict[int, condensation.FlankPatches]
    #: Screw, condensed to compliance matrices at its contacts.
    condensed_screw: condensation.CondensedScrew
    #: Nut, condensed to compliance matrices at its contacts; None: rigid.
    condensed_nut: condensation.CondensedNut | None
    #: One ball, condensed to a compliance matrix at its contacts.
    condensed_ball: condensation.CondensedBall
    #: Cross-section (beam stiffnesses) of the shaft outside the part that is meshed in 3D.
    shaft_section: ShaftSection
    #: Uniform beam equivalent to the grooved shaft; None where it is not needed.
    equivalent_beam: shafts.EquivalentBeam | None
    #: Number of degrees of freedom that one mesh of all bodies, without condensation, would have.
    degree_of_freedom_count: int
    #: Measures of mesh quality by name: number of cells across a contact, smallest scaled Jacobian of each mesh, and
    #: largest deviation of the meshed grooves from their exact surface [m].
    mesh_quality: dict[str, float]
    #: Time of every stage of meshing and condensing [s]. A cached result counts with the time that its computation once
    #: took. The elapsed time of stages that run in parallel is divided between them.
    seconds_by_stage: dict[str, float] = field(default_factory=dict)
    #: Sum of the peak memory of all worker processes, without the main process [MB].
    worker_peak_memory_MB: float = 0.0

    def condensed_body_of_flank(self, side: int) -> condensation.CondensedScrew | condensation.CondensedNut | None:
        """Return the condensed body on which a groove flank (0 to 3) lies: screw or nut; None for a rigid nut."""
        return self.condensed_screw if side < 2 else self.condensed_nut


class _StageRunner:
    """Runs the stages of meshing and condensing one geometry; records stage times and the memory of worker processes.

    ``cache``: cache of computed records; ``step``: function that is called with a text on the progress. The attributes
    are the elapsed time of each stage (``seconds``) [s], and the peak memory of each worker process by the number of the
    process (``others``) [MB].
    """

    def __init__(self, cache: Cache, step: Step) -> None:
        self.cache, self.step = cache, step
        self.seconds: dict[str, float] = {}
        self.others: dict[int, float] = {}

    def run(self, jobs: Sequence[RecordJob], processes: int) -> list[Any]:
        """Compute the results of jobs in several processes, and return them in the order of the jobs.

        A job computes one mesh or condensed part. When the last job of a stage is done, the stage is reported with the
        computing time of its jobs. The elapsed time is divided between the stages in proportion to these times.
        """
        start = perf_counter()
        by_stage: dict[str, list[ComputedRecord]] = {job.stage_name: [] for job in jobs}
        wanted = Counter(job.stage_name for job in jobs)

        def report_finished_stage(k: int, record: ComputedRecord) -> None:
            records = by_stage[jobs[k].stage_name]
            records.append(record)
            if len(records) == wanted[jobs[k].stage_name]:
                cached = [x.from_cache for x in records]
                origin = "" if not any(cached) else ", from the cache" if all(cached) else ", partly from the cache"
                spent = sum(x.elapsed_seconds for x in records)
                self.step(StageMessage(jobs[k].stage_name, f"{spent:.1f} s{origin}", cached=all(cached)))

        done = compute_records(jobs, self.cache, processes, report_finished_stage)
        share = (perf_counter() - start) / max(sum(record.elapsed_seconds for record in done), 1e-9)
        for stage, records in by_stage.items():
            self.seconds[stage] = sum((1.0 if x.from_cache else share) * x.seconds_without_cache for x in records)
        for record in done:
            if record.process_id != os.getpid() and record.peak_memory_MB is not None:
                self.others[record.process_id] = max(self.others.get(record.process_id, 0.0), record.peak_memory_MB)
        return [record.result for record in done]


def mesh_and_condense_geometry(
    scene: Scene,
    sides: tuple[int, ...],
    settings: Settings,
    step: Step = lambda _: None,
    scenes: Sequence[Scene] = (),
    *,
    cache: Cache | None = None,
    processes: int = 1,
) -> CondensedGeometry:
    """Mesh and condense the screw, nut and balls of one geometry.

    Parameters
    ----------
    scene : Scene
        Screw or bearing.
    sides : tuple[int, ...]
        Flanks (0 to 3 for SL, SR, NL, NR) that may carry load.
    settings : Settings
        Mesh settings: cell sizes, modes and element type.
    step : Step, optional
        Function that is called with a text on the progress.
    scenes : Sequence[Scene], optional
        Further scenes of the same parts that will be solved with the result; they may differ in loads, supports and
        manufacturing errors.
    cache : Cache | None, default None
        Cache of meshes and condensed parts; None: compute everything.
    processes : int, default 1
        Number of processes that compute the meshes, then patches and shaft, then bodies.

    Returns
    -------
    CondensedGeometry
        The meshed and condensed geometry.

    Raises
    ------
    ValueError
        A mesh cannot be built.
    MemoryError
        A worker process was ended from outside.
    """
    stages = _StageRunner(cache or Cache(None), step)
    m, layout, dims = GrooveMap.from_scene(scene), ball_layout(scene), dimensions_of_3d_parts(scene)
    stations = tuple(sorted({z for case in (scene, *scenes) for z in case.stations}))
    recipes, gather = list_part_mesh_calls(scene, m, layout, dims, sides, settings)
    meshes = gather(*stages.run([RecordJob("meshes", *recipe) for recipe in recipes], processes))
    jobs = _list_patch_jobs(scene, m, dims, meshes, sides, settings)
    records = stages.run([*jobs.values(), *_list_shaft_section_jobs(scene, m, dims, settings, stations)], processes)
    condensed = dict(zip(jobs, records[: len(jobs)], strict=True))
    turned = condensation.turn_patches_to_right_flank
    patches = {s: condensed[s] if s in condensed else turned(condensed[s - 1]) for s in sides}
    section, *meshed = records[len(jobs) :]
    beam = None
    if meshed:
        beam = shafts.compute_equivalent_beam(m, scene.screw.bore / 2.0, scene.screw.material, section, meshed)

    ends = dims.ends_of_meshed_screw(scene)
    inside = tuple(z for z in stations if ends[0] < z < ends[1])
    on_screw = {s: p.groove_patch for s, p in patches.items() if s < 2}
    on_nut = {s: p.groove_patch for s, p in patches.items() if s >= 2}
    of_screw = (scene.screw.material, scene.nut, ends, inside, meshes.screw_mesh, layout, sides, on_screw, settings, dims)
    of_nut = (scene.nut.material, meshes.nut_mesh, layout, sides, on_nut, settings, dims)
    of_ball = (scene.balls.material, meshes.ball_mesh, patches, settings)
    nut_job = RecordJob("nut", condensation.condense_nut, of_nut, condensation.CondensedNut)
    bodies = [
        RecordJob("screw", condensation.condense_screw, of_screw, condensation.CondensedScrew),
        *([nut_job] if scene.solid.nut == "elastic" else []),
        RecordJob("ball", condensation.condense_ball, of_ball, condensation.CondensedBall),
    ]
    together = processes if layout.z.size * len(sides) <= TOGETHER else 1
    screw, *nuts, ball = stages.run(bodies, together)
    screw = _correct_screw_stiffness(screw, beam, m, layout, sides, stations)
    of_each_ball = [ball, *(patch for p in patches.values() for patch in (p.groove_patch, p.ball_patch))]
    unknowns = sum(part.degree_of_freedom_count for part in (screw, *nuts))
    unknowns += layout.z.size * sum(part.degree_of_freedom_count for part in of_each_ball)
    return CondensedGeometry(
        scene=scene,
        groove_map=m,
        ball_positions=layout,
        solid_dimensions=dims,
        mesh_settings=settings,
        loaded_flanks=sides,
        patches_by_flank=patches,
        condensed_screw=screw,
        condensed_nut=nuts[0] if nuts else None,
        condensed_ball=ball,
        shaft_section=beam.section if beam else section,
        equivalent_beam=beam,
        degree_of_freedom_count=unknowns,
        mesh_quality=_collect_mesh_quality(meshes, settings),
        seconds_by_stage=stages.seconds,
        worker_peak_memory_MB=sum(stages.others.values()),
    )


def _list_patch_jobs(
    scene: Scene, m: GrooveMap, dims: Dimensions, meshes: PartMeshes, sides: tuple[int, ...], settings: Settings
) -> dict[int, RecordJob]:
    """List the jobs that condense the fine meshes (patches) around the contacts, by groove flank.

    ``m``: geometry of the track; ``dims``: dimensions of the solid parts; ``sides``: flanks that carry contacts. A right
    flank has no job if its patches are those of the left flank of the same groove, turned by 180 degrees.
    """
    jobs = {}
    for s in sides:
        turned = s - 1 in sides and settings.element == "Q2" and condensation.is_left_flank_after_half_turn(m, s)
        if not (turned and _are_refinement_boxes_mirrored(meshes, s)):
            given = condensation.collect_flank_condensation_arguments(scene, m, dims, meshes, s, settings)
            jobs[s] = RecordJob("patches", condensation.condense_patches_of_flank, given, condensation.FlankPatches)
    return jobs


def _list_shaft_section_jobs(
    scene: Scene, m: GrooveMap, dims: Dimensions, settings: Settings, stations: tuple[float, ...]
) -> list[RecordJob]:
    """List the jobs that compute the beam stiffnesses of the shaft outside the part that is meshed in 3D.

    ``stations``: axial positions of all supports and loads [m]. A smooth shaft needs one job; a grooved shaft needs one job
    for its section and three jobs that mesh shafts for `compute_equivalent_beam`. The arguments of the jobs are only those
    on which the result depends, so that scenes with other nuts and loads find it in the cache. If no support or load lies
    outside the 3D part, the section has no effect, and that of a smooth shaft is used.
    """
    screw, e, (low, high) = scene.screw, scene.screw.material, dims.ends_of_meshed_screw(scene)
    outer, bore = screw.outer_diameter / 2.0, screw.bore / 2.0
    section_job = partial(RecordJob, "shaft section")
    beyond = dims.screw_held != "bore" and not all(low <= z <= high for z in stations)
    plain = dims.shaft_radius if beyond else outer
    if plain is not None:
        return [section_job(round_section, (plain, e.youngs_modulus, e.poissons_ratio), ShaftSection)]
    if m.rg == 0.0:
        return [section_job(tube_section, (outer, bore, e), ShaftSection)]
    meshed = [
        section_job(shafts.meshed_shaft_flexibility, (m, outer, dims.hole, e, settings.cell, x), tuple)
        for x in shafts.choose_lengths_of_fitted_shafts(m)
    ]
    return [section_job(shafts.stiffness_of_grooved_shaft, (m, outer, bore, e), tuple), *meshed]


def _correct_screw_stiffness(
    screw: condensation.CondensedScrew,
    beam: shafts.EquivalentBeam | None,
    m: GrooveMap,
    layout: BallLayout,
    sides: tuple[int, ...],
    stations: tuple[float, ...],
) -> condensation.CondensedScrew:
    """Correct the compliance of the screw's 3D mesh: to the beam stiffness of the grooved shaft, and for its cut ends.

    ``beam``: uniform beam that is equivalent to the grooved shaft, or None for no correction; ``stations``: axial positions
    of all supports and loads [m], which show at which ends the shaft continues.
    """
    if beam is None:
        return screw
    along, cut = np.repeat(layout.z, sum(s < 2 for s in sides)), beam.cut_end_flexibility
    stretch = correct_beam_stiffness(screw.stretch, screw.modes_by_rigid_motions, along, beam.section, cut, m)
    return replace(screw, stretch=subtract_cut_end_flexibility(stretch, cut, m, stations))


def _collect_mesh_quality(meshes: PartMeshes, settings: Settings) -> dict[str, float]:
    """Collect measures of mesh quality by name: elements across a contact, smallest scaled Jacobian of each mesh.

    The measure "deviation" is the largest distance of the meshed grooves from their exact surface [m].
    """
    across = 2.0 * settings.b_over_h if settings.element == "Q2" else 2.0 * settings.semi[1] / settings.tet
    return {
        "elements across 2b": across,
        "screw": meshes.screw_mesh.quality.smallest_jacobian,
        "nut": meshes.nut_mesh.quality.smallest_jacobian,
        "ball": meshes.ball_mesh.quality.smallest_jacobian,
        "deviation": max(meshes.screw_mesh.flank_deviation, meshes.nut_mesh.flank_deviation),
    }


def _are_refinement_boxes_mirrored(meshes: PartMeshes, side: int) -> bool:
    """Return whether the refinement boxes of a right flank are mirror images of those of the left flank.

    A refinement box is a hole in a coarse mesh that a fine mesh fills. ``side``: the right flank. Compared are the nodes
    and triangles of the faces of the refinement boxes in groove and ball.
    """
    for body in (meshes.screw_mesh if side < 2 else meshes.nut_mesh, meshes.ball_mesh):
        right, left = body.box_faces[side], body.box_faces[side - 1]
        corners, mirrored = (np.sort(faces.triangles[:, :3]) for faces in (right, left))
        if not (np.array_equal(right.xi, left.xi * AZIMUTH_TURNED) and np.array_equal(corners, mirrored)):
            return False
    return True


class RecordJob(NamedTuple):
    """One independent computation (such as a mesh or a condensed part) whose result may be cached; can be pickled."""

    #: Name of the stage (such as meshing or condensing) to which the job belongs.
    stage_name: str
    #: Function that computes the result, as for `Cache.get`.
    compute: Callable[..., Any]
    #: Arguments of the function ``compute``.
    arguments: tuple[Any, ...]
    #: Class of the result, by which it is read from the cache.
    result_type: type


@dataclass(frozen=True)
class ComputedRecord:
    """Result of a `RecordJob`, with the time and memory that its computation took."""

    #: Result of the job, such as a mesh or a condensed part.
    result: Any
    #: Time of computing the result, or of reading it from the cache [s].
    elapsed_seconds: float
    #: Whether the result came from the cache.
    from_cache: bool
    #: Time that the computation of the result took, now or when it was written to the cache [s].
    seconds_without_cache: float
    #: Identifier of the process that computed or read the result.
    process_id: int
    #: Peak memory of the process that computed or read the result [MB]; None: not measured.
    peak_memory_MB: float | None
    #: Reason why the process no longer writes to the cache; empty if it still writes.
    cache_fault: str = ""


def compute_records(
    jobs: Sequence[RecordJob], cache: Cache, processes: int, report: Callable[[int, ComputedRecord], None] = lambda *_: None
) -> list[ComputedRecord]:
    """Compute the results of independent jobs in several processes, of which this process is one.

    The other processes use one thread each, unless the user's environment variables allow more.

    Parameters
    ----------
    jobs : Sequence[RecordJob]
        The jobs.
    cache : Cache
        Cache of records.
    processes : int
        Number of processes.
    report : Callable[[int, ComputedRecord], None], optional
        Function that is called with the index of each job and its record, one at a time.

    Returns
    -------
    list[ComputedRecord]
        Records in the order of the jobs.

    Raises
    ------
    MemoryError
        A worker process was ended from outside.
    """
    if processes == 1 or len(jobs) < 2:
        alone = []
        for k, job in enumerate(jobs):
            alone.append(_compute_or_read_record(job, cache))
            report(k, alone[-1])
        return alone
    from joblib.executor import get_memmapping_executor  # the workers of joblib.Parallel, not further ones
    from joblib.externals.loky.process_executor import BrokenProcessPool

    helpers = min(processes, len(jobs)) - 1
    start = {"initializer": workers.end_process_with_parent, "initargs": (os.getpid(),)}
    others = get_memmapping_executor(helpers, **start, env=workers.one_thread_environment(), max_nbytes=None)
    left, done, one_at_a_time = deque(enumerate(jobs)), dict[int, ComputedRecord](), Lock()

    def run_jobs_from_queue(maker: Callable[[RecordJob], ComputedRecord]) -> None:
        """Take jobs from the common queue and compute their results by the function ``maker``, until none is left."""
        while left:
            try:
                k, job = left.popleft()
            except IndexError:  # another thread was faster
                return
            done[k] = maker(job)
            with one_at_a_time:
                report(k, done[k])

    def run_in_worker(job: RecordJob) -> ComputedRecord:
        """Compute the result of a job in a worker process, and wait for it."""
        found: ComputedRecord = others.submit(_compute_record_in_worker, job, cache).result()
        return found

    with workers.without_restart_warnings(), ThreadPoolExecutor(helpers) as threads:
        helping = [threads.submit(run_jobs_from_queue, run_in_worker) for _ in range(helpers)]
        try:
            run_jobs_from_queue(lambda job: _compute_or_read_record(job, cache))
            for future in helping:
                future.result()
        except BrokenProcessPool as error:
            raise MemoryError(
                "a process that meshes or condenses parts was ended from outside: free some memory, or use fewer processes"
            ) from error
        except KeyboardInterrupt:  # a job may take minutes: nobody waits for it
            others.terminate(kill_workers=True)
            raise
        finally:
            left.clear()
    away = [record.from_cache for record in done.values() if record.process_id != os.getpid()]
    cache.hits += sum(away)
    cache.misses += len(away) - sum(away)
    for record in done.values():
        cache.report_fault_and_stop(record.cache_fault)
    return [done[k] for k in range(len(jobs))]


def _compute_record_in_worker(job: RecordJob, cache: Cache) -> ComputedRecord:
    """Reset this worker process's record of peak memory, then compute a job's result or read it from the cache."""
    workers.reset_peak_memory()
    cache.quiet = True
    return _compute_or_read_record(job, cache)


def _compute_or_read_record(job: RecordJob, cache: Cache) -> ComputedRecord:
    """Compute the result of a job (a mesh or condensed part), or read it from the cache; measure time and memory."""
    start, hits, cold = perf_counter(), cache.hits, cache.cold_seconds
    value = cache.get(job.compute, job.arguments, job.result_type)
    spent, known = perf_counter() - start, cache.cold_seconds - cold
    return ComputedRecord(value, spent, cache.hits > hits, known, os.getpid(), workers.peak_memory_MB(), cache.fault)
