"""Section on error against run time: every model, mesh and scene, cold and warm."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from time import perf_counter
from typing import Any, Literal, cast

import numpy as np

from rollbench.compare.measure import error_percent, gate_scale, load_error
from rollbench.compare.models.comparison import REFERENCED, finest_bodies, suitable_models
from rollbench.compare.models.modelling import UNSEEN, Rung, ladder
from rollbench.compare.models.registry import MODELS, Model, Options, run_model
from rollbench.compare.models.study import Study
from rollbench.compare.printed import entry
from rollbench.compare.reference.estimate import Reference
from rollbench.compare.reference.levels import SOURCE_LEVEL
from rollbench.compare.reference.store import Measured, Run, load_run, measuring_conditions, one_run, shipped_store
from rollbench.compare.studies.run_times import (
    COMMANDS,
    NEW,
    TYPED,
    ColdLevelTime,
    Kept,
    RunTime,
    SetUpCosts,
    load_costs,
    load_times,
    measure_level,
    measure_model,
    save_times,
    time_command,
    today,
)
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import Scene
from rollbench.reports.content import Figure, Panel, Quantity, Row, Series, Table

Step = Callable[[str], None]
#: Lower edge of the figures [% of the mean load].
FLOOR = 1e-2
#: Number of calls whose median is the warm time.
WARM_CALLS = 10
#: Scene whose first process is timed with and without compiling.
FIRST = "lin-case1"
#: Number of stages of a set-up that are named.
DEAREST = 3
#: Kinds of work of a set-up, and their headings.
WORK = {
    "all": "CPU time",
    "meshing": "of it meshing",
    "assembly": "of it assembly",
    "elimination": "of it elimination",
    "dense": "its dense algebra",
}
#: Models whose first process is timed there.
SAMPLE = ("lin", "refined")
#: Number of panels of one figure.
PANELS = 6


@dataclass(frozen=True)
class Largest:
    """Largest error of a contact load [%], with the range that the grid uncertainty allows (`error_range`)."""

    #: Largest error.
    error: float
    #: Smallest value that it may have.
    low: float
    #: Largest value that it may have.
    high: float


@dataclass(frozen=True)
class TimePoint:
    """Error and run time of one model or mesh of a scene, against the reference's finest level."""

    #: Name in tables.
    label: str
    #: Kind: low-order model, level of the reference, or the source's mesh.
    kind: Literal["model", "level", "source mesh"]
    #: Largest error [% of the mean load].
    error: float
    #: RMS error [% of the mean load].
    rms: float
    #: Smallest value of the largest error that the grid uncertainty allows; None with one level.
    low: float | None
    #: Largest value of the largest error that the grid uncertainty allows; None with one level.
    high: float | None
    #: Time of a cold start in the measuring run [s]; None: not measured.
    cold: float | None
    #: Time of a further solution in the measuring run [s]; None: not measured.
    warm: float | None
    #: Number of unknowns.
    unknowns: int
    #: Peak memory [MB]; None: not measured.
    memory: float | None
    #: Short name.
    name: str
    #: Largest error as the gate takes it.
    gate: Largest
    #: Status; "converged" for a solution.
    status: str = "converged"
    #: Conditions of the time measurement.
    measured: Measured | None = None
    #: Description of a time from an older run.
    older: str = ""


def error_range(value: Array, found: Reference, scale: Array) -> Largest:
    """Return the largest error of loads against the finest level, and its range by the grid uncertainty.

    With each contact's error e and uncertainty U, the true largest error lies between max(|e| - U) and max(|e| + U).

    Parameters
    ----------
    value
        Contact loads, (n, 4) [N].
    found
        The reference.
    scale
        Loads to which errors are related, (n, 4) [N].

    Returns
    -------
    Largest
        Error and range in per cent.
    """
    off = np.abs(error_percent(value, found.load, scale))
    bar = np.abs(error_percent(found.uncertainty, 0.0, scale))
    return Largest(float(off.max()), max(0.0, float((off - bar).max())), float((off + bar).max()))


def errors_of(value: Array, found: Reference) -> dict[str, Any]:
    """Return the errors of a `TimePoint` from loads (n, 4) [N]."""
    e = load_error(value, found.load, found.contacts)
    of_mean = error_range(value, found, np.full(value.shape, found.mean))
    gate = error_range(value, found, gate_scale(found.load, found.mean))
    return {"error": e.max_percent, "rms": e.rms_percent, "low": of_mean.low, "high": of_mean.high, "gate": gate}


def warm_seconds(model: Model, scene: Scene, options: Options) -> float:
    """Return the time [s] of a further solution with bodies and compiled kernels ready: the median of some calls."""
    spent = []
    for _ in range(WARM_CALLS + 1):
        start = perf_counter()
        run_model(scene, model.name, options)
        spent.append(perf_counter() - start)
    return float(np.median(spent[1:]))


def measured_now(study: Study, names: Sequence[str], step: Step, *, levels: bool) -> Kept:
    """Measure all models of scenes with a reference now; ``levels``: also the reference and first processes."""
    times, cold_levels, first = {}, [], {}
    for name, found in study.references(names).items():
        for model, bodies in models_of(name, found, study):
            step(f"{name}, {model.label}: cold and warm")
            cold = measure_model(name, model.name, condensed=bodies, repeats=1)
            options = Options(discretisation=False, engine="compiled", condensed=bodies)
            warm = warm_seconds(model, study.scene(name), options)
            times[name, model.name] = RunTime(cold.process, warm, cold.memory)
        for run in runs_of(name, found, study) if levels else ():
            step(f"{name}, level {run.level} of the 3D reference, cold")
            cold_levels.append(measure_level(name, run.level))
    for name, engine in product(SAMPLE, ("interpreted", "compiled")) if levels else ():
        step(f"{FIRST}, {name} {engine}: first process")
        first[name, engine] = measure_model(FIRST, name, engine=engine)
    return Kept(measuring_conditions(), today(), times, first, cold_levels)


def typed_now(step: Step) -> Kept:
    """Measure the commands of `COMMANDS` from an empty home now."""
    commands = []
    for command in COMMANDS:
        step(f"{command}, from an empty home")
        commands.append(time_command(command))
    return Kept(measuring_conditions(), today(), {}, {}, typed=commands)


def measuring_run(study: Study, step: Step) -> Kept | None:
    """Return the run times that a report shows: stored ones or, for a timed study, those measured now.

    A measuring run takes every model and level of every compared scene (about an hour) and is stored in the first
    store. A quick study measures models only, and stores nothing.
    """
    if not study.timed:
        return load_times((*(study.stores or ()), shipped_store()))
    measured = measured_now(study, list(compared_scenes(study)), step, levels=not study.quick)
    if study.stores and not study.quick:
        save_times(study.stores[0], measured)
    return measured


def compared_scenes(study: Study) -> dict[str, Reference]:
    """Return the references of all scenes that have one; in a quick study of the case studies only."""
    return study.references(REFERENCED if study.quick else (*REFERENCED, *UNSEEN))


def models_of(name: str, found: Reference, study: Study) -> list[tuple[Model, Path | None]]:
    """Return the models of a scene, each with the file of its condensed bodies, if it takes them."""
    scene, bodies = study.scene(name), finest_bodies(study.scene(name), found, study.stores)
    further = [m for m in MODELS.values() if not m.compared and m.suits(scene)]
    every = [(m, bodies if m.name == "condensed" else None) for m in (*suitable_models(scene), *further)]
    return [(m, file) for m, file in every if m.name != "condensed" or file is not None]


def runs_of(name: str, found: Reference, study: Study) -> list[Run]:
    """Return the runs of the 3D reference of a scene: on the source's mesh, if any, and on its levels."""
    source = load_run(study.scene(name), SOURCE_LEVEL, stores=study.stores)
    return [*(() if source is None else (source,)), *found.runs]


def time_points(name: str, found: Reference, study: Study, step: Step) -> list[TimePoint]:
    """Return errors and times of all models and meshes of a scene.

    Times that the measuring run does not contain are given as text, with the conditions of their measurement.
    """
    kept, out = study.once(measuring_run, step), []
    measured = None if kept is None else kept.measured
    for model, bodies in models_of(name, found, study):
        known = None if kept is None else kept.times.get((name, model.name))
        result = _solved(name, model, study, bodies)
        cold, warm, memory = (None, None, None) if known is None else (known.cold, known.warm, known.memory)
        costs: dict[str, Any] = {"cold": cold, "warm": warm, "unknowns": result.solver.unknowns, "memory": memory}
        notes: dict[str, Any] = {"status": result.status, "measured": None if known is None else measured}
        out.append(TimePoint(model.label, "model", **errors_of(result.load, found), **costs, name=model.name, **notes))
    for run in runs_of(name, found, study):
        cold, warm, older = None, None, f"{run.setup_seconds + run.solve_seconds:.3g} s, measured with {run.measured}"
        for level in () if kept is None else kept.levels:
            if (level.scene, level.level) == (name, run.level):
                cold, warm, older = level.process, level.load_case, ""
        of_source = run.level == SOURCE_LEVEL
        label, short = (
            ("the source's mesh", "3D, source's mesh") if of_source else (f"level {run.level}", f"3D level {run.level}")
        )
        kind: Literal["source mesh", "level"] = "source mesh" if of_source else "level"
        costs = {"cold": cold, "warm": warm, "unknowns": run.unknowns, "memory": run.peak_MB}
        notes = {"status": run.status, "measured": None if cold is None else measured, "older": older}
        errors = errors_of(run.load, found)
        out.append(TimePoint(f"3D reference, {label}", kind, **errors, **costs, name=short, **notes))
    return out


def _solved(name: str, model: Model, study: Study, bodies: Path | None) -> StaticResult:
    """Return the result of a model on a scene; with condensed bodies that of the ladder if it was computed."""
    if bodies is None:
        return study.solve(name, model.name)
    for rung in study.computed.get((ladder,), ()):
        if (rung.scene, rung.model) == (name, model.name):
            return cast(Rung, rung).result
    return run_model(study.scene(name), model.name, Options(discretisation=False, condensed=bodies))


def time_table(points: Mapping[str, Sequence[TimePoint]], measured: str = "") -> Table:
    """Return the table of errors and times of every model and mesh; ``measured``: text on the measurement."""
    rows: list[Row] = [
        {
            "scene": scene,
            "model": p.label,
            Quantity("error", "largest error", "% of mean", ".2f"): p.error,
            Quantity("low", "at least", "% of mean", ".2f"): p.low,
            Quantity("high", "at most", "% of mean", ".2f"): p.high,
            Quantity("rms", "RMS error", "% of mean", ".2f"): p.rms,
            Quantity("cold", "cold", "s", "g3"): p.cold,
            Quantity("warm", "warm", "s", "g3"): p.warm,
            Quantity("older", "not of this measuring run", "", "s"): p.older,
            "unknowns": p.unknowns,
            Quantity("memory", "peak memory", "MB", ".0f"): p.memory if p.memory is not None else "not measured",
            Quantity("status", "unless converged", "", "s"): "" if p.status == "converged" else p.status,
        }
        for scene, several in points.items()
        for p in several
    ]
    note = (
        "Errors of all models and meshes are against the finest level of the reference, whose own difference is zero by "
        "definition. At least and at most: what the grid uncertainty of every contact leaves of the largest error. Cold: "
        "for low-order models a new process with empty caches, from the start of the interpreter to the first solve, "
        "interpreted, for the 3D reference up to its loads, on all cores. Warm: bodies of the geometry "
        "known, kernels compiled; of the 3D reference a further load case. All times are of one measuring run; what it did "
        "not measure stands apart, with what it was measured with. Peak memory is each run's own (of several "
        "processes: the sum of their peaks), interpreter and libraries included. Unknowns of the 3D reference are those of "
        "the monolithic mesh that its condensed parts are equal to." + (f" {measured}" if measured else "")
    )
    return Table.of("reference-time", "Error against run time", rows, note)


def compile_table(kept: Kept) -> Table:
    """Return the table of times of a first process, with interpreted and with compiled kernels."""
    rows: list[Row] = [
        {
            "model": MODELS[name].label,
            Quantity("engine", "kernels", "", "s"): engine,
            Quantity("process", "new process, empty caches", "s", "g3"): cold.process,
            Quantity("first", "its first solve", "s", "g3"): cold.first,
            Quantity("warm", "a further solve", "s", "g3"): cold.warm,
            Quantity("memory", "peak memory", "MB", ".0f"): cold.memory,
        }
        for (name, engine), cold in kept.first.items()
    ]
    note = (
        "Kernels are compiled once per machine and kept in the user's cache; the command line solves single "
        "scenes interpreted. Each row is a process of its own; the first solve of the refined model also "
        f"prepares the bodies of the geometry. {kept}"
    )
    return Table.of("reference-cold", f"{FIRST}: first process, with and without compiling", rows, note)


def typed_table(kept: Kept) -> Table:
    """Return the table of waiting times of commands that are run from an empty home directory."""
    rows: list[Row] = [
        {
            Quantity("command", "command", "", "s"): c.command,
            Quantity("reach", "to reach", "", "s"): COMMANDS.get(c.command, ""),
            Quantity("seconds", "empty home", "s", "g3"): c.seconds,
            Quantity("first_line", "to its first line", "s", "g3"): c.first_line,
            Quantity("cpu", "CPU time", "s", "g3"): c.cpu,
            Quantity("again", "again (floor)", "s", "g3"): c.again,
            Quantity("again_cpu", "CPU time, again", "s", "g3"): c.again_cpu,
            Quantity("beside", "beside a busy process", "s", "g3"): c.beside,
            Quantity("beside_cpu", "CPU time there", "s", "g3"): c.beside_cpu,
            Quantity("note", "note", "", "s"): c.note,
        }
        for c in kept.typed
    ]
    note = (
        f"A process as typed, no number of threads set, in a home without any cache; rollbench {NEW} wrote my.toml. Typed "
        "again there, a command takes what does not come of the empty home: the floor of what compiled kernels and kept "
        f"bodies can save. CPU time is that of all its processes, and moves less with other work on the machine. {kept}"
    )
    return Table.of("reference-typed", "Commands as typed from an empty home", rows, note)


def level_table(kept: Kept) -> Table:
    """Return the table of waiting times for each level of the 3D reference on a new scene."""
    rows: list[Row] = [
        {
            "scene": c.scene,
            "contacts": c.contacts,
            "level": c.level,
            Quantity("cold", "new process, empty caches", "s", "g3"): c.process,
            Quantity("cpu", "CPU time of all processes", "s", "g3"): c.cpu,
            Quantity("load_case", "of it a load case", "s", "g3"): c.load_case,
            Quantity("stages", "of it the set-up's dearest stages", "", "s"): _dearest(c),
            Quantity("memory", "peak memory", "MB", ".0f"): c.memory,
            "status": c.status,
        }
        for c in kept.levels
    ]
    note = (
        "Each level in a process of its own on all cores, from the start of the interpreter to the loads, "
        "with no mesh, part or run known before. Peak memory: sum of the peaks of all processes of one "
        "set-up. Targets were 12 s for level 1 of a screw with 64 contacts, 40 s for its levels 1 to 3, and "
        "45 s of processor time for level 1 with 200 contacts, 0.3 s for a further load case. Where they are missed, "
        "the tables "
        f"reference-set-up-costs and reference-set-up-ways say what bounds them. {kept}"
    )
    return Table.of("reference-levels-cold", "Levels of the 3D reference, cold", rows, note)


def cost_tables(costs: SetUpCosts) -> list[Table]:
    """Return tables of the processor time of set-ups by stage, and of savings and changes by cheaper variants."""
    measured = f"Measured with {Measured(costs.version, machine=costs.machine)}, {costs.date}, by tests/set_up_costs.py."
    rows: list[Row] = [
        {
            "scene": job.scene,
            "level": job.level,
            "contacts": job.contacts,
            "stage": stage,
            **{Quantity(kind, words, "s", ".2f"): spent.get(kind, 0.0) for kind, words in WORK.items()},
        }
        for job in costs.jobs
        for stage, spent in (*job.stages.items(), ("all", {kind: job.seconds_of(kind) for kind in WORK}))
    ]
    floors = ", ".join(f"{job.seconds_of('all') / 2.0:.1f} s ({job.scene}, level {job.level})" for job in costs.jobs)
    note = (
        "One process of one thread, without start and imports. Elimination is what the meshes ask for: its dense algebra "
        f"runs in LAPACK. Two cores that never wait for one another need at least {floors}. {measured}"
    )
    ways: list[Row] = [
        {
            "scene": way.scene,
            "way": way.way,
            Quantity("saved", "CPU time saved", "s", ".2f"): way.saved,
            Quantity("moved", "moves a load by", "% of mean", ".4f"): way.moved,
        }
        for way in costs.ways
    ]
    tried = (
        "Ways that were tried on level 1 and not taken. A load may move by 0.001 % of the mean load, or stored runs "
        "would be of another reference. The library has one flank's patch, as the mean of those of pitch radii 5 % "
        "smaller and larger; one for any screw has five such parameters (two conformities, contact angle, lead angle, "
        f"ball over pitch radius), and with ten places of each 100,000 patches. {measured}"
    )
    return [
        Table.of("reference-set-up-costs", "Processor time of a cold set-up, by stage and work", rows, note),
        Table.of("reference-set-up-ways", "Cheaper set-ups, and what they do to loads", ways, tried),
    ]


def _dearest(level: ColdLevelTime) -> str:
    """Return the stages that take most of a set-up's time, in words."""
    if level.stages is None:
        return "not measured"
    stages = sorted(level.stages.items(), key=lambda stage: -stage[1])
    return ", ".join(f"{name} {seconds:.1f} s" for name, seconds in stages[:DEAREST])


def speed_table(points: Mapping[str, Sequence[TimePoint]]) -> Table:
    """Return the table of the finest level's time over that of the source's low-order model, by scene.

    For a new process up to the loads, and for a further load case of a known geometry. Raises ValueError for times of
    several measuring runs.
    """
    rows: list[Row] = []
    for scene, several in points.items():
        low = next(p for p in several if p.name == "lin")
        best = [p for p in several if p.kind == "level"][-1]
        if low.cold and low.warm and best.cold and best.warm:
            one_run(p.measured for p in (low, best) if p.measured is not None)
            rows.append(
                {
                    "scene": scene,
                    Quantity("low", "low-order, cold", "s", "g3"): low.cold,
                    Quantity("low_warm", "low-order, warm", "s", "g3"): low.warm,
                    Quantity("ref", "3D reference, cold", "s", ".1f"): best.cold,
                    Quantity("ref_warm", "3D reference, load case alone", "s", ".2f"): best.warm,
                    Quantity("cold", "ratio, cold", "", ".0f"): best.cold / low.cold,
                    Quantity("warm", "ratio, a further load case", "", ".0f"): best.warm / low.warm,
                }
            )
    printed = entry("lin-2.4.1", "speed_ratio").printed
    title = f"Speed ratio, 3D reference : the source's model (the source: over {printed}, ANSYS : its model)"
    return Table.of("reference-speed", title, rows)


def time_panel(scene: str, of_scene: Sequence[TimePoint]) -> Panel:
    """Return the panel of error over cold run time on one scene, with the error's uncertainty."""

    def series(label: str, points: Sequence[TimePoint], style: str, *, emphasis: bool = False) -> Series:
        low = [max(p.low, FLOOR) for p in points if p.low is not None]
        high = [max(p.high, FLOOR) for p in points if p.high is not None]
        bars = (low, high) if len(low) == len(high) == len(points) else None
        errors = [max(p.error, FLOOR) for p in points]
        times = [p.cold for p in points if p.cold is not None]
        return Series(label, times, errors, style, emphasis=emphasis, bars=bars)

    good = [p for p in of_scene if p.status == "converged" and p.cold is not None]
    drawn = [series(p.label, [p], "markers") for kind in ("model", "source mesh") for p in good if p.kind == kind]
    levels = [p for p in good if p.kind == "level"]
    if levels:
        drawn.append(series("3D reference, its levels", levels, "markers", emphasis=True))
    return Panel(scene, "run time, cold / s", "largest error / % of the mean load", tuple(drawn), log="xy")


def time_figures(points: Mapping[str, Sequence[TimePoint]]) -> list[Figure]:
    """Draw error over run time for case studies, without and with preload, and for screws not used in development."""
    caption = (
        "All points are errors against the finest level, with what its grid "
        f"uncertainty leaves of them as bars; what is below {FLOOR:g} % is drawn at the lower edge."
    )
    plain = [n for n in REFERENCED if n in points and any(p.name == "mei" for p in points[n])]
    groups = {
        "": plain,
        "-preload": [n for n in REFERENCED if n in points and n not in plain],
        "-unseen": [n for n in UNSEEN if n in points][:PANELS],
    }
    return [
        Figure(f"reference-time{tail}", "Error against run time", tuple(time_panel(n, points[n]) for n in names), caption)
        for tail, names in groups.items()
        if names
    ]


def all_points(study: Study, step: Step) -> dict[str, list[TimePoint]]:
    """Return the time points of all compared scenes; raises ValueError if several measuring runs are mixed."""
    study.once(ladder)  # its results serve here
    points = {name: time_points(name, ref, study, step) for name, ref in compared_scenes(study).items()}
    one_run(p.measured for several in points.values() for p in several if p.measured is not None)
    return points


def when_measured(study: Study, step: Step) -> str:
    """Return the conditions of the time measurement in words."""
    kept = study.once(measuring_run, step)
    return "No run times are kept." if kept is None else str(kept)


def time_items(study: Study, step: Step) -> list[Table | Figure]:
    """Return tables and figures on run times; a quick study has no first processes, levels and commands."""
    points, kept = study.once(all_points, step), study.once(measuring_run, step)
    items: list[Table | Figure] = [time_table(points, when_measured(study, step))]
    if not study.quick:
        costs = load_costs((*(study.stores or ()), shipped_store()))
        items += [] if kept is None else [compile_table(kept), level_table(kept)]
        commands = load_times((*(study.stores or ()), shipped_store()), TYPED)
        items += [] if commands is None else [typed_table(commands)]
        items += [] if costs is None else cost_tables(costs)
    return [*items, speed_table(points), *time_figures(points)]
