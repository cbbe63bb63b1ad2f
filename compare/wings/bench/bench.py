"""Speed: what a solve costs, cold and warm, singly and in thousands, against the source's formulation.

The jobs of a group run in one child process with single-threaded linear algebra, both formulations side by side, garbage
collection off; each time is the median of repeated runs. Start-up and compile times are those of further processes.

Both solve to the relative residual ``TOLERANCE`` at which either counts as converged. The source's Newton often cannot
reach a tighter one, and iterates in vain for it: one job shows that comparison, at 1e-12, too.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, replace
from functools import partial
from statistics import median

import numpy as np

from rollbench.compare.models.study import with_balls
from rollbench.compare.scenes.catalogue import scene as shipped
from rollbench.compare.wings.bench.costs.timing import Job, launch, timed
from rollbench.compare.wings.bench.prepared import TOLERANCE, Energy, Refined, Source
from rollbench.compare.wings.bench.startup import command_line_job, startup_jobs
from rollbench.compare.wings.members.ensemble import ENOUGH, run_ensemble
from rollbench.lowfi.as_source import static as lin
from rollbench.lowfi.statics.response import forget
from rollbench.lowfi.statics.static import solve_static
from rollbench.meshes.kept import made_anew
from rollbench.meshes.memory import peak_MB, reset_peak
from rollbench.meshes.parts import Scene
from rollbench.meshes.threads import one_thread

MEMBERS = 1000
#: Time of a member [s] and of a set-up [s], and ratio of a cold solve, that are aimed at.
MEMBER_AIM, SETUP_AIM, COLD_AIM = 75e-6, 0.15e-3, 1000.0
BALLS = (125, 250, 500, 1000)
#: The same for the refined model: time is about linear to the last but one, the last is its largest size.
REFINED_BALLS = (16, 32, 64, 125, 250)
#: Balls of the second new geometry, beside those of case 1.
NEW = 100


def _source_seconds(task: Source, repeats: int, work: Callable[[], object] | None = None) -> float | None:
    """Seconds of one solve, None where it does not converge (or only stalls above ``ACCEPTED``)."""
    seconds = timed(work or task.solve, repeats)
    return seconds if task.status == "converged" else None


def _ratio(source: float | None, seconds: float) -> float | None:
    return source / seconds if source is not None else None


def _cold_jobs(repeats: int) -> Iterator[Job]:
    scene = shipped("lin-case1")
    setup = timed(lambda: Energy(scene), repeats)
    reference, energy, full = Source(scene), Energy(scene), Energy(scene, everything=True)
    floor = timed(energy.packed, repeats)
    note = "from the scene to packed arrays: in no solve below"
    yield Job("set-up, case 1", setup, None, None, peak_MB(), note, SETUP_AIM, floor, "packing of a known problem")
    slow = _source_seconds(reference, repeats)
    fast = timed(energy.cold, 40 * repeats, energy.reset)
    least = timed(energy.warm, 40 * repeats)  # from the solution itself
    note = "linear start and Newton, a node at every contact, sides that cannot touch left out; source: its good guess; "
    note += f"aim: a ratio of {COLD_AIM:g}; {1e6 * least:.1f} us of it are the call, its arrays and one evaluation"
    yield Job("cold solve, case 1", fast, _ratio(slow, fast), energy.unknowns, peak_MB(), note)
    all_sides = timed(full.cold, 40 * repeats, full.reset)
    note = "the same with all four sides in the system: the very partition and contacts of the source's formulation"
    yield Job("cold solve, all sides", all_sides, _ratio(slow, all_sides), full.unknowns, peak_MB(), note)
    note = "Newton from its good guess; all four sides, a node at every contact (its nominal start is singular)"
    yield Job("source, cold, good guess", slow, None, reference.unknowns, peak_MB(), note)
    steps = _source_seconds(reference, max(1, repeats // 3), reference.solve_by_steps)
    note = "as 'cold solve, case 1', against ten load steps: what the source needs where no good guess is known"
    yield Job("cold solve, no guess", fast, _ratio(steps, fast), energy.unknowns, peak_MB(), note)
    yield Job("source, cold, load steps", steps, None, reference.unknowns, peak_MB(), "ten load steps")
    yield _strict_job(scene, repeats)


def _strict_job(scene: Scene, repeats: int) -> Job:
    reference, energy = Source(scene, tolerance=1e-12), Energy(scene, tolerance=1e-12)
    slow = _source_seconds(reference, repeats)
    fast = timed(energy.cold, 40 * repeats, energy.reset)
    note = "both asked for 1e-12, which the source does not reach: it counts as converged when it stalls below 1e-10"
    return Job("cold solve, to 1e-12", fast, _ratio(slow, fast), energy.unknowns, peak_MB(), note)


def _coarse_jobs(repeats: int) -> Iterator[Job]:
    case = shipped("lin-case1")
    scene = replace(case, ingredients=replace(case.ingredients, partition="source"))
    reference = Source(scene)
    slow = _source_seconds(reference, repeats)
    energy = Energy(scene)
    fast = timed(energy.cold, 40 * repeats, energy.reset)
    note = "both on the source's own 15 mm partition"
    yield Job("cold solve, source partition", fast, _ratio(slow, fast), energy.unknowns, peak_MB(), note)
    note = "Newton from its good guess, on its 15 mm partition"
    yield Job("source, cold, source partition", slow, None, reference.unknowns, peak_MB(), note)


def _warm_jobs(repeats: int) -> Iterator[Job]:
    scene = shipped("lin-case1")
    energy, reference = Energy(scene), Source(scene)
    energy.change_load()
    reference.change_load()
    slow = _source_seconds(reference, repeats)
    fast = timed(energy.warm, 40 * repeats, energy.reset)
    note = "load changed by 1 %, from the previous solution; both without set-up"
    yield Job("warm re-solve, case 1", fast, _ratio(slow, fast), energy.unknowns, peak_MB(), note)
    yield Job("source, warm", slow, None, reference.unknowns, peak_MB(), "as above")


def _ensemble_jobs(repeats: int) -> Iterator[Job]:
    scene = shipped("lin-random")
    members = [Source(scene, m) for m in range(max(4, repeats))]
    seconds = [s for m in members if (s := _source_seconds(m, 1)) is not None]
    slow = median(seconds) if seconds else None
    count = MEMBERS if repeats > 1 else 100
    last = run_ensemble(scene, count)
    whole = timed(lambda: run_ensemble(scene, count), min(repeats, 5)) / count
    good = int(last.converged.sum())
    note = (
        f"per member of {count} on one core, to {ENOUGH:g}, with drawing, packing and the check of the "
        f"sides left out; {good} converged; the source (no set-up, to {TOLERANCE:g}) solved {len(seconds)} of "
        f"{len(members)} tried; aim {1e6 * MEMBER_AIM:g} us"
    )
    unknowns = Energy(shipped("lin-case1")).unknowns  # the sides that every member was solved with, unless some touch
    unknowns = unknowns if last.all_sides == 0 else Energy(scene, everything=True).unknowns
    yield Job("ensemble, per member", whole, _ratio(slow, whole), unknowns, peak_MB(), note)
    in_threads = timed(lambda: run_ensemble(scene, count, threads=2), min(repeats, 5)) / count
    note = f"the same in two threads, the same numbers: {whole / in_threads:.2f} times as fast"
    yield Job("ensemble, two threads", in_threads, _ratio(slow, in_threads), unknowns, peak_MB(), note)
    yield Job("source, per member", slow, None, members[0].unknowns, peak_MB(), "Newton from its good guess, no set-up")
    scene = shipped("lin-case3-tolerances")
    whole = timed(lambda: run_ensemble(scene, count), min(repeats, 3)) / count
    note = f"per member of {count}, preloaded, all four flanks, random balls, pitch and roundness; "
    note += "one system, members in a batch"
    yield Job("ensemble, case 3 with tolerances", whole, None, None, peak_MB(), note)


def _refined_jobs(repeats: int) -> Iterator[Job]:
    scene = shipped("lin-case1")
    slow = _source_seconds(Source(scene), repeats)
    note = "cell, kernels, flanks, beam, arrays"
    for job, wanted, aim in (("", scene, 0.2), (f", {NEW} balls", with_balls(scene, NEW), 0.5)):
        with made_anew():
            setup = timed(partial(Refined, wanted), max(1, repeats // 3), forget)
        name, floor = f"refined, bodies of a new geometry{job}", timed(partial(Refined, wanted), max(1, repeats // 3))
        yield Job(name, setup, None, None, peak_MB(), note, aim, floor, "set-up with bodies kept")
    again = timed(lambda: Refined(scene), repeats)
    note = "bodies kept: beam, supports, arrays"
    yield Job("refined, set-up of a known geometry", again, None, None, peak_MB(), note)
    for label, everything in (("refined, cold solve, case 1", False), ("refined, cold solve, all sides", True)):
        model = Refined(scene, everything=everything)
        fast = timed(model.cold, 40 * repeats)
        note = "linear start and Newton on the contact forces; set-up above"
        yield Job(label, fast, _ratio(slow, fast), model.unknowns, peak_MB(), note)
    seconds: list[float] = []
    counts = REFINED_BALLS if repeats > 1 else REFINED_BALLS[:2]
    for count in counts:
        model = Refined(with_balls(scene, count))
        fast = timed(model.cold, 5 * repeats)
        seconds.append(fast)
        note = "two flanks a ball"
        done = counts[: len(seconds)]
        if len(done) >= min(len(counts), 4):
            note += f"; from {done[0]} to {done[-1]} balls time grows as balls^{_power(done, seconds):.2f}"
        yield Job(f"refined, {count} balls, cold", fast, None, model.unknowns, peak_MB(), note)


def _size_jobs(repeats: int) -> Iterator[Job]:
    counts = BALLS if repeats > 1 else BALLS[:2]
    seconds: list[float] = []
    steps: list[int] = []
    for count in counts:
        reset_peak()
        scene = with_balls(shipped("lin-case1"), count)
        energy = Energy(scene, tolerance=1e-12)
        fast = timed(energy.cold, 5 * repeats, energy.reset)
        seconds.append(fast)
        steps.append(energy.iterations)
        peak, note, slow = peak_MB(), "linear start and Newton, to 1e-12", None
        size = 6 * count + Energy(scene, everything=True).unknowns
        if count == counts[0] and repeats > 1:
            slow = _source_seconds(Source(scene), 1)
            note += f"; the source's Jacobian of {size} unknowns is the largest one tried"
        elif repeats > 1:
            note += f"; the source's dense Jacobian would be {size**2 * 8e-9:.1f} GB: not tried"
        if count == counts[-1]:
            note += f"; from {counts[0]} balls ({steps[0]} iterations) to {counts[-1]} ({steps[-1]}) time grows as "
            note += f"balls^{_power(counts, seconds):.2f}, time per iteration as "
            note += f"balls^{_power(counts, [t / k for t, k in zip(seconds, steps, strict=True)]):.2f}"
        yield Job(f"{count} balls, cold", fast, _ratio(slow, fast), energy.unknowns, peak, note)


def _power(counts: Sequence[int], seconds: Sequence[float]) -> float:
    """Exponent k of the fit seconds = c counts^k."""
    return float(np.polyfit(np.log(counts), np.log(seconds), 1)[0])


def _interpreted_jobs(repeats: int) -> Iterator[Job]:
    scene = shipped("lin-case1")
    slow = timed(lambda: lin.solve_source(scene, tolerance=TOLERANCE), repeats)
    fast = timed(lambda: solve_static(scene, engine="interpreted"), repeats)
    note = "as one command-line solve runs it: set-up, interpreted kernels, result record; source: good guess, set-up"
    unknowns = solve_static(scene, engine="interpreted").solver.unknowns
    yield Job("interpreted solve, case 1", fast, _ratio(slow, fast), unknowns, peak_MB(), note)


GROUPS: tuple[Callable[[int], Iterator[Job]], ...] = (
    _interpreted_jobs,
    _cold_jobs,
    _coarse_jobs,
    _warm_jobs,
    _ensemble_jobs,
    _size_jobs,
    _refined_jobs,
)


def _child(group: int, repeats: int) -> None:
    """Print one JSON object per job of a group (the child process of ``run_bench``)."""
    one_thread()
    solve_static(shipped("lin-case1"), engine="compiled")
    reset_peak()
    for job in GROUPS[group](repeats):
        print(json.dumps(asdict(job)), flush=True)


def run_bench(progress: Callable[[str], None] | None = None, *, repeats: int = 15) -> list[Job]:
    """All jobs; ``progress`` is called with each job's name when it is done; repeats: 1 for a quick look (small jobs).

    Raises RuntimeError where the timing process fails.
    """
    jobs: list[Job] = []
    for job in _jobs(repeats):
        jobs.append(job)
        if progress is not None:
            progress(job.job if job.seconds is None else f"{job.job}: {job.seconds:.3g} s")
    return jobs


def _jobs(repeats: int) -> Iterator[Job]:
    """The jobs as they are done, those of a group together."""
    for group in range(len(GROUPS)):
        _, done = launch(["-c", f"from rollbench.compare.wings.bench.bench import _child; _child({group}, {repeats})"])
        if done.returncode != 0:
            raise RuntimeError(f"bench: the timing process failed: {done.stderr.strip().splitlines()[-1:]}")
        yield from (Job(**json.loads(line)) for line in done.stdout.splitlines())
    yield command_line_job()
    yield from startup_jobs()
