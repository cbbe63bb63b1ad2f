"""Run times: ratios to the source's formulation in the same process, with seconds, and the times that the source
reports."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from functools import partial
from time import process_time
from typing import Any

import numpy as np

from rollbench.compare.models.registry import Options, run_model
from rollbench.compare.models.study import Study, with_balls
from rollbench.compare.printed.printed_data import entry, load_table
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.registration import offered
from rollbench.compare.scenes.catalogue import scene as shipped
from rollbench.compare.system import machine
from rollbench.compare.wings.bench.axis_bench import jobs as axis_jobs
from rollbench.compare.wings.bench.bench import run_bench
from rollbench.compare.wings.bench.costs.kept import first_kept, save_rows, today
from rollbench.compare.wings.bench.costs.timing import Job
from rollbench.compare.wings.bench.waits import TYPED, kept, now_and_here, spent_table
from rollbench.compare.wings.members.members import run_members
from rollbench.compare.writing import replace_file
from rollbench.lowfi.statics.response import LARGEST
from rollbench.meshes.kept import made_anew
from rollbench.meshes.memory import peak_MB, reset_peak
from rollbench.reports.content import Figure, Panel, Quantity, Row, Section, Series, Table, Text

#: File of a store that holds the jobs of this section.
JOBS = "jobs.json"
#: File of a store that holds time and memory over size.
GROWTH = "growth.json"
#: Numbers of balls and of members over which they are shown, and the most members of a quick look.
BALLS, MEMBERS, FEW = (8, 16, 32, 64, 125, 250, 500, 1000), (10, 100, 1000, 10_000, 100_000), 100

#: Count, processor seconds and MB at the peak.
Points = list[tuple[float, float, float]]


def _power(x: Sequence[float], y: Sequence[float]) -> float:
    """Exponent of y over x, by the larger half of the places."""
    some = len(x) // 2
    return float(np.polyfit(np.log(x[some:]), np.log(y[some:]), 1)[0])


def _measured(counts: Iterable[int], work: Callable[[int], object]) -> Points:
    found = []
    for count in counts:
        reset_peak()
        begin = process_time()
        work(count)
        found.append((float(count), process_time() - begin, peak_MB() or 0.0))
    return found


def by_balls(counts: Sequence[int] = BALLS) -> dict[str, Points]:
    """Balls, processor seconds with set-up and MB at the peak of one solve, by model."""
    case, options = shipped("lin-case1"), Options(engine="compiled", discretisation=False)
    longer = {n: replace(case.screw, length=case.screw.length + 1e-6 * n) for n in counts}  # a geometry for every count
    scenes = {n: replace(with_balls(case, n), screw=screw) for n, screw in longer.items()}
    found = {}
    with made_anew():
        for model, most in {"lin": max(counts), "refined": LARGEST}.items():
            for count in (8, 64):  # compiles both ways to solve
                run_model(with_balls(case, count), model, options)
            few = [n for n in counts if n <= most]
            found[model] = _measured(few, lambda n: run_model(scenes[n], model, options))  # noqa: B023 - called at once
    return found


def by_members(counts: Sequence[int] = MEMBERS) -> dict[str, Points]:
    """Members, processor seconds and MB at the peak of an ensemble of `lin-random`, by model."""
    scene, found = shipped("lin-random"), {}
    for model in ("lin", "refined"):
        run_members(scene, model, 200)
        found[model] = _measured(counts, partial(run_members, scene, model))
    return found


def growth(study: Study) -> tuple[Mapping[str, Mapping[str, Sequence[Sequence[float]]]], str]:
    """Points by what grows and by model, and a sentence on where and when they were measured: those kept, measured again
    and kept in the first store where the study is timed or none are."""
    if study.quick:
        few = [n for n in MEMBERS if n <= FEW]
        return {"balls": by_balls(BALLS[:4]), "members": by_members(few)}, "Measured for this report."
    stores = () if study.timed else (*(study.stores or ()), shipped_store())
    known = first_kept(stores, GROWTH, lambda x: (x["points"], f"Kept, of {x['date']} on {x['machine']}."))
    if known is not None:
        return known
    members = by_members()  # first: what large bodies took stays with the process
    points = {"balls": by_balls(), "members": members}
    if study.stores:
        kept = {"machine": machine(), "date": today(), "points": points}
        replace_file(study.stores[0] / GROWTH, f"{json.dumps(kept, indent=1)}\n")
    return points, "Measured for this report."


def scaling(study: Study) -> tuple[Table, Figure]:
    """Time and memory over balls and members, with the observed exponents of the larger half of the sizes."""
    rows: list[Row] = []
    panels = []
    measured, origin = growth(study)
    for of, found in measured.items():
        for place, unit in ((1, "s"), (2, "MB")):
            series = []
            for model, points in found.items():
                x, y = [p[0] for p in points], [p[place] for p in points]
                series.append(Series(f"{model}: exponent {_power(x, y):.2f}", x, y, "line+markers"))
            panels.append(Panel("", of, f"{'time' if unit == 's' else 'memory'} / {unit}", tuple(series), log="xy"))
        rows += [
            {
                "model": model,
                "over": of,
                Quantity("count", "number", "", ".0f"): p[0],
                Quantity("seconds", "CPU", "s", "g3"): p[1],
                Quantity("peak_MB", "peak memory", "MB", ".0f"): p[2],
            }
            for model, points in found.items()
            for p in points
        ]
    note = f"One solve with its set-up, bodies of a new geometry; ensembles of lin-random with their bands. {origin}"
    return Table.of("scaling", "Time and memory over size", rows), Figure(
        "scaling", "Growth with size", tuple(panels), note
    )


def jobs_now(step: Callable[[str], None]) -> Iterator[Job]:
    """Every job, measured now."""
    for one in TYPED:
        step(one.job)
        yield one.measured()
    yield from run_bench(step)
    yield from (job for added in offered("timing jobs") for job in added())
    yield from axis_jobs(5)


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report."""
    stores = [*(study.stores or ()), shipped_store()]
    done = [] if study.timed else kept(stores, JOBS)
    if not done:
        done = [replace(job, when=now_and_here()) for job in jobs_now(step)]
        if study.stores:
            save_rows(study.stores[0], JOBS, done)
    rows: list[dict[str, Any]] = [asdict(job) for job in done]
    printed: list[Row] = [
        {
            Quantity("label", "quantity", "", "s"): p.label,
            "printed": p.printed,
            "unit": p.unit,
            "class": p.cls,
            "remark": p.remark,
        }
        for p in load_table("lin-2.2")
    ]
    reported = entry("lin-2.2", "time_proposed_1")
    return Section(
        "timing",
        "Run times",
        (
            Text(
                (
                    (
                        "Ratios: seconds of the source's formulation over those of the solver here, for the "
                        f"same task in the same process. The source reports {reported.printed} s for case 1 on "
                        "its own machine and in its own language; this is shown below, not compared."
                    ),
                )
            ),
            spent_table([*done, *kept(stores)]),
            *scaling(study),
            Table(
                "timing-jobs",
                "Jobs",
                (
                    Quantity("job", "job", "", "s"),
                    Quantity("seconds", "seconds", "s", "g3"),
                    Quantity("ratio", "ratio", "", "g3"),
                    Quantity("unknowns", "unknowns", "", "s"),
                    Quantity("peak_MB", "peak memory", "MB", ".0f"),
                    Quantity("note", "what is included", "", "s"),
                    Quantity("when", "measured", "", "s"),
                ),
                rows,
            ),
            *(table for added in offered("timing") for table in added(step)),
            Table.of("timing-printed", "Table 2.2 as printed", printed),
        ),
        conclusion=conclusion(done),
    )


def conclusion(done: Sequence[Job]) -> str:
    """Time of case 1, and its ratio to the source's Newton from a good guess."""
    job = next(job for job in done if job.job == "cold solve, case 1")
    if job.seconds is None or job.ratio is None:
        return ""
    return (
        f"A cold solve of case 1 takes {1e6 * job.seconds:.0f} µs, the source's formulation {job.ratio:.0f} times as long."
    )
