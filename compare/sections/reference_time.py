"""Tables and figures on load error over run time, for every low-order model and 3D mesh level on every compared scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from time import perf_counter
from typing import Any, Literal, cast

import numpy as np

from rollbench.compare.measure import error_percent, load_error, scale_of_gate_errors
from rollbench.compare.models.comparison import REFERENCED, path_of_condensed_bodies, suitable_models
from rollbench.compare.models.modelling import UNSEEN, Rung, ladder
from rollbench.compare.models.registry import MODELS, Model, Options, run_model
from rollbench.compare.models.study import Study
from rollbench.compare.printed import printed_entry
from rollbench.compare.reference.estimate import Reference
from rollbench.compare.reference.levels import SOURCE_LEVEL
from rollbench.compare.reference.store import (
    Measured,
    Run,
    common_conditions,
    load_run,
    measuring_conditions,
    shipped_store,
)
from rollbench.compare.studies.run_times import (
    COMMANDS,
    NEW,
    TYPED,
    ColdLevelTime,
    RunTime,
    SetUpCosts,
    StoredRunTimes,
    load_costs,
    load_times,
    save_times,
    time_command_in_empty_home,
    time_mesh_level_in_new_process,
    time_model_in_new_process,
    today,
)
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import Scene
from rollbench.reports.content import Figure, Panel, Quantity, Row, Series, Table

Step = Callable[[str], None]
#: Smallest error drawn in the figures [% of the mean load]; smaller errors are drawn at this value.
FLOOR = 1e-2
#: Number of repeated solutions whose median time is the time of a further solution (warm time).
WARM_CALLS = 10
#: Scene whose first solution in a new process is timed with interpreted and with compiled kernels.
FIRST = "lin-case1"
#: Number of the longest stages of a set-up that the table names.
DEAREST = 3
#: Kinds of work in a set-up of the 3D reference, and their column headings.
WORK = {
    "all": "CPU time",
    "meshing": "meshing",
    "assembly": "assembly",
    "elimination": "elimination",
    "dense": "dense algebra of the elimination",
}
#: Models that are timed on the scene `FIRST` with interpreted and with compiled kernels.
SAMPLE = ("lin", "refined")
#: Largest number of panels in one figure.
PANELS = 6


@dataclass(frozen=True)
class LargestError:
    """Largest error of a contact load [%], with its range due to the mesh uncertainty of the 3D reference."""

    #: Largest error [%].
    error: float
    #: Lower end of its range [%].
    low: float
    #: Upper end of its range [%].
    high: float


@dataclass(frozen=True)
class TimePoint:
    """Error and run time of one model or mesh level on one scene, against the finest mesh level of the 3D reference."""

    #: Name of the model or mesh level in tables.
    label: str
    #: Kind: low-order model, mesh level of the 3D reference, or the mesh of Lin's thesis ("source mesh").
    kind: Literal["model", "level", "source mesh"]
    #: Largest error of a contact load [% of the mean load].
    error: float
    #: RMS error of the contact loads [% of the mean load].
    rms: float
    #: Lower end of the range of ``error`` due to the mesh uncertainty [% of the mean load]; None with one mesh level.
    low: float | None
    #: Upper end of this range [% of the mean load]; None with one mesh level.
    high: float | None
    #: Time in a new process with empty caches [s] (cold start); None: not measured.
    cold: float | None
    #: Time of a further solution of the same geometry in this process [s]; None: not measured.
    warm: float | None
    #: Number of unknowns of the model or mesh.
    unknowns: int
    #: Peak memory [MB]; None: not measured.
    memory: float | None
    #: Short name of the model or mesh level, for figures.
    name: str
    #: Largest error as ``rollbench check`` (the gate) judges it.
    gate: LargestError
    #: Status of the solver, such as "converged".
    status: str = "converged"
    #: Conditions of the time measurement: program version and machine; None: not measured.
    measured: Measured | None = None
    #: Time from an earlier measurement, with its conditions, as text; empty: none.
    older: str = ""


def largest_error_with_range(loads: Array, reference: Reference, scale: Array) -> LargestError:
    """Return the largest error of contact loads against the 3D reference, and its range due to the grid uncertainty.

    If e is the error and U the uncertainty of a contact, the true largest error lies between max(|e| - U) and max(|e| + U)
    over all contacts.

    Parameters
    ----------
    loads
        Contact loads of n balls on the four groove flanks, (n, 4) [N].
    reference
        Contact loads of the 3D reference with their uncertainty.
    scale
        Load by which the error of each contact is divided, (n, 4) [N]; for all contacts, for example, the mean load.

    Returns
    -------
    LargestError
        Largest error and the ends of its range [%].
    """
    off = np.abs(error_percent(loads, reference.load, scale))
    bar = np.abs(error_percent(reference.uncertainty, 0.0, scale))
    return LargestError(float(off.max()), max(0.0, float((off - bar).max())), float((off + bar).max()))


def errors_against_reference(loads: Array, reference: Reference) -> dict[str, Any]:
    """Return the errors of contact loads against the 3D reference, as keyword arguments of a `TimePoint`.

    ``loads``: contact loads of n balls on the four groove flanks, (n, 4) [N]. ``reference``: the 3D reference. The values
    of the dictionary are the largest and the RMS error with the range of the largest one [% of the mean load] (error, rms,
    low, high), and the largest error by the gate's rule (gate).
    """
    e = load_error(loads, reference.load, reference.contacts)
    of_mean = largest_error_with_range(loads, reference, np.full(loads.shape, reference.mean))
    gate = largest_error_with_range(loads, reference, scale_of_gate_errors(reference.load, reference.mean))
    return {"error": e.max_percent, "rms": e.rms_percent, "low": of_mean.low, "high": of_mean.high, "gate": gate}


def further_solution_seconds(model: Model, scene: Scene, options: Options) -> float:
    """Return the time [s] in which a model solves a scene again, with body compliances and compiled kernels available.

    It is the median of `WARM_CALLS` solutions, after one that is not timed.
    """
    spent = []
    for _ in range(WARM_CALLS + 1):
        start = perf_counter()
        run_model(scene, model.name, options)
        spent.append(perf_counter() - start)
    return float(np.median(spent[1:]))


def measure_run_times(study: Study, names: Sequence[str], step: Step, *, levels: bool) -> StoredRunTimes:
    """Measure the times in which all models solve the named scenes, in a new process (cold) and in a running one (warm).

    Parameters
    ----------
    study
        Study that gives scenes and 3D references.
    names
        Names of the scenes.
    step
        Called with each line of progress.
    levels
        Whether the mesh levels of the 3D reference are timed too, and the first solution of `FIRST` with interpreted and
        with compiled kernels.

    Returns
    -------
    StoredRunTimes
        Measured times, with program version, machine and date.
    """
    times, cold_levels, first = {}, [], {}
    for name, found in study.references(names).items():
        for model, bodies in models_with_bodies(name, found, study):
            step(f"{name}, {model.label}: cold and warm")
            cold = time_model_in_new_process(name, model.name, condensed=bodies, repeats=1)
            options = Options(discretisation=False, engine="compiled", condensed=bodies)
            warm = further_solution_seconds(model, study.scene(name), options)
            times[name, model.name] = RunTime(cold.process, warm, cold.memory)
        for run in stored_reference_runs(name, found, study) if levels else ():
            step(f"{name}, level {run.level} of the 3D reference, cold")
            cold_levels.append(time_mesh_level_in_new_process(name, run.level))
    for name, engine in product(SAMPLE, ("interpreted", "compiled")) if levels else ():
        step(f"{FIRST}, {name} {engine}: first process")
        first[name, engine] = time_model_in_new_process(FIRST, name, engine=engine)
    return StoredRunTimes(measuring_conditions(), today(), times, first, cold_levels)


def measure_commands(step: Step) -> StoredRunTimes:
    """Measure the run times of the commands in `COMMANDS`, each started with an empty home directory, without caches.

    ``step`` is called with each line of progress.
    """
    commands = []
    for command in COMMANDS:
        step(f"{command}, with an empty home directory")
        commands.append(time_command_in_empty_home(command))
    return StoredRunTimes(measuring_conditions(), today(), {}, {}, typed=commands)


def run_times_to_show(study: Study, step: Step) -> StoredRunTimes | None:
    """Return the run times that a report shows: stored ones or, if the study asks for it, newly measured ones.

    A new measurement times every model and mesh level on every compared scene (about an hour) and is written to the study's
    first folder of stored runs. A quick study times the models only, and stores nothing. Returns None if the study is not
    timed and no times are stored. ``step`` is called with each line of progress.
    """
    if not study.timed:
        return load_times((*(study.stores or ()), shipped_store()))
    measured = measure_run_times(study, list(compared_scenes(study)), step, levels=not study.quick)
    if study.stores and not study.quick:
        save_times(study.stores[0], measured)
    return measured


def compared_scenes(study: Study) -> dict[str, Reference]:
    """Return the 3D reference of every compared scene, by the scene's name.

    These are the case studies and, unless the study is quick, the scenes that were chosen before they were solved in 3D.
    """
    return study.references(REFERENCED if study.quick else (*REFERENCED, *UNSEEN))


def models_with_bodies(name: str, found: Reference, study: Study) -> list[tuple[Model, Path | None]]:
    """Return the models that can describe a scene, each with the file of body compliances that it needs (or None).

    Only the model "condensed" needs a file: the compliances of screw and nut, condensed in the finest 3D run. It is left
    out if there is no such file. ``name``: name of the scene. ``found``: its 3D reference.
    """
    scene, bodies = study.scene(name), path_of_condensed_bodies(study.scene(name), found, study.stores)
    further = [m for m in MODELS.values() if not m.compared and m.suits(scene)]
    every = [(m, bodies if m.name == "condensed" else None) for m in (*suitable_models(scene), *further)]
    return [(m, file) for m, file in every if m.name != "condensed" or file is not None]


def stored_reference_runs(name: str, found: Reference, study: Study) -> list[Run]:
    """Return the stored 3D runs of a scene: first the one on the mesh of Lin's thesis, if stored, then all mesh levels.

    ``name``: name of the scene. ``found``: its 3D reference on the mesh levels.
    """
    source = load_run(study.scene(name), SOURCE_LEVEL, stores=study.stores)
    return [*(() if source is None else (source,)), *found.runs]


def error_and_time_points(name: str, found: Reference, study: Study, step: Step) -> list[TimePoint]:
    """Return the load errors and run times of all models and 3D mesh levels on one scene.

    Times from other measurements than the one shown are stated as text, with the conditions of their measurement.

    Parameters
    ----------
    name
        Name of the scene.
    found
        3D reference of the scene.
    study
        Study that gives solutions and stored runs.
    step
        Called with each line of progress.
    """
    kept, out = study.compute_once(run_times_to_show, step), []
    measured = None if kept is None else kept.measured
    for model, bodies in models_with_bodies(name, found, study):
        known = None if kept is None else kept.times.get((name, model.name))
        result = _solve_scene(name, model, study, bodies)
        cold, warm, memory = (None, None, None) if known is None else (known.cold, known.warm, known.memory)
        costs: dict[str, Any] = {"cold": cold, "warm": warm, "unknowns": result.solver.unknowns, "memory": memory}
        notes: dict[str, Any] = {"status": result.status, "measured": None if known is None else measured}
        out.append(
            TimePoint(
                model.label, "model", **errors_against_reference(result.load, found), **costs, name=model.name, **notes
            )
        )
    for run in stored_reference_runs(name, found, study):
        cold, warm, older = None, None, f"{run.setup_seconds + run.solve_seconds:.3g} s, measured with {run.measured}"
        for level in () if kept is None else kept.levels:
            if (level.scene, level.level) == (name, run.level):
                cold, warm, older = level.process, level.load_case, ""
        of_source = run.level == SOURCE_LEVEL
        label, short = (
            ("mesh of Lin's thesis", "3D, Lin's mesh") if of_source else (f"level {run.level}", f"3D level {run.level}")
        )
        kind: Literal["source mesh", "level"] = "source mesh" if of_source else "level"
        costs = {"cold": cold, "warm": warm, "unknowns": run.unknowns, "memory": run.peak_MB}
        notes = {"status": run.status, "measured": None if cold is None else measured, "older": older}
        errors = errors_against_reference(run.load, found)
        out.append(TimePoint(f"3D reference, {label}", kind, **errors, **costs, name=short, **notes))
    return out


def _solve_scene(name: str, model: Model, study: Study, bodies: Path | None) -> StaticResult:
    """Solve a scene by a low-order model, or return the solution that another section has already computed.

    ``name``: name of the scene. ``bodies``: file of condensed body compliances that the model needs; None: no file.
    """
    if bodies is None:
        return study.solve(name, model.name)
    for rung in study.computed.get((ladder,), ()):
        if (rung.scene, rung.model) == (name, model.name):
            return cast(Rung, rung).result
    return run_model(study.scene(name), model.name, Options(discretisation=False, condensed=bodies))


def error_and_time_table(points: Mapping[str, Sequence[TimePoint]], measured: str = "") -> Table:
    """Return the table of load errors and run times of every model and 3D mesh level on every scene.

    Parameters
    ----------
    points
        Errors and run times of models and mesh levels, by name of the scene.
    measured
        Sentence on the conditions of the time measurement, which ends the note below the table.
    """
    rows: list[Row] = [
        {
            "scene": scene,
            "model": p.label,
            Quantity("error", "largest error", "% of mean", ".2f"): p.error,
            Quantity("low", "largest error, at least", "% of mean", ".2f"): p.low,
            Quantity("high", "largest error, at most", "% of mean", ".2f"): p.high,
            Quantity("rms", "RMS error", "% of mean", ".2f"): p.rms,
            Quantity("cold", "cold start", "s", "g3"): p.cold,
            Quantity("warm", "further solution", "s", "g3"): p.warm,
            Quantity("older", "time by an earlier measurement", "", "s"): p.older,
            "unknowns": p.unknowns,
            Quantity("memory", "peak memory", "MB", ".0f"): p.memory if p.memory is not None else "not measured",
            Quantity("status", "status if not converged", "", "s"): "" if p.status == "converged" else p.status,
        }
        for scene, several in points.items()
        for p in several
    ]
    note = (
        "Errors of all models and mesh levels are against the finest mesh level of the 3D reference, whose own error is "
        "zero by definition. At least and at most: range of the largest error due to the grid uncertainty of every "
        "contact. Cold start: a new process with empty caches; for low-order models from the start of the interpreter to "
        "the first solution, with interpreted kernels; for the 3D reference up to its loads, on all cores. Further "
        "solution: the compliance of the bodies is known and kernels are compiled; for the 3D reference a further load "
        "case. All times are from one measurement; times from earlier measurements are shown in a column of their own, "
        "with their conditions. Peak memory includes interpreter and libraries; for several processes it is the sum of "
        "their peaks. Unknowns of the 3D reference are those of the single mesh that is equivalent to its condensed parts."
        + (f" {measured}" if measured else "")
    )
    return Table.of(
        "reference-time", "Contact-load error and run time of each model and 3D mesh level on each scene", rows, note
    )


def kernel_compilation_table(run_times: StoredRunTimes) -> Table:
    """Return the table of run times in a new process on the scene `FIRST`, with interpreted and with compiled kernels.

    ``run_times``: measured run times.
    """
    rows: list[Row] = [
        {
            "model": MODELS[name].label,
            Quantity("engine", "kernels", "", "s"): engine,
            Quantity("process", "new process, empty caches", "s", "g3"): cold.process,
            Quantity("first", "first solution in it", "s", "g3"): cold.first,
            Quantity("warm", "a further solution", "s", "g3"): cold.warm,
            Quantity("memory", "peak memory", "MB", ".0f"): cold.memory,
        }
        for (name, engine), cold in run_times.first.items()
    ]
    note = (
        "Kernels are compiled once per machine and stored in the user's cache; the command line solves single "
        "scenes with interpreted kernels. Each row is a separate process; the first solution of the refined model also "
        f"computes the compliance of the bodies. {run_times}"
    )
    title = f"Run times of a new process on {FIRST}, with interpreted and with compiled kernels"
    return Table.of("reference-cold", title, rows, note)


def command_time_table(run_times: StoredRunTimes) -> Table:
    """Return the table of run times of commands that start with an empty home directory, that is without caches.

    ``run_times``: measured run times.
    """
    rows: list[Row] = [
        {
            Quantity("command", "command", "", "s"): c.command,
            Quantity("reach", "target", "", "s"): COMMANDS.get(c.command, ""),
            Quantity("seconds", "empty home directory", "s", "g3"): c.seconds,
            Quantity("first_line", "until its first line", "s", "g3"): c.first_line,
            Quantity("cpu", "CPU time", "s", "g3"): c.cpu,
            Quantity("again", "second run", "s", "g3"): c.again,
            Quantity("again_cpu", "CPU time, second run", "s", "g3"): c.again_cpu,
            Quantity("beside", "next to a busy process", "s", "g3"): c.beside,
            Quantity("beside_cpu", "CPU time next to a busy process", "s", "g3"): c.beside_cpu,
            Quantity("note", "note", "", "s"): c.note,
        }
        for c in run_times.typed
    ]
    note = (
        f"Each command is run as typed, without a set number of threads, in a home directory without any cache; rollbench "
        f"{NEW} wrote my.toml. The second run finds compiled kernels and stored body compliances, so its time is the least "
        "that caches can achieve. CPU time is the sum over all processes of the command; it depends less on other work on "
        f"the machine. {run_times}"
    )
    return Table.of(
        "reference-typed", "Run times of commands that start with an empty home directory, without caches", rows, note
    )


def cold_level_time_table(run_times: StoredRunTimes) -> Table:
    """Return the table of run times of each mesh level of the 3D reference from a cold start, without stored meshes.

    ``run_times``: measured run times.
    """
    rows: list[Row] = [
        {
            "scene": c.scene,
            "contacts": c.contacts,
            "level": c.level,
            Quantity("cold", "new process, empty caches", "s", "g3"): c.process,
            Quantity("cpu", "CPU time of all processes", "s", "g3"): c.cpu,
            Quantity("load_case", "a further load case", "s", "g3"): c.load_case,
            Quantity("stages", "longest stages of the set-up", "", "s"): _costliest_stages(c),
            Quantity("memory", "peak memory", "MB", ".0f"): c.memory,
            "status": c.status,
        }
        for c in run_times.levels
    ]
    note = (
        "Each level is computed in a separate process on all cores, from the start of the interpreter to the loads, "
        "without any stored mesh, part or run. Peak memory: sum of the peaks of all processes of one "
        "set-up. Targets were 12 s for level 1 of a screw with 64 contacts, 40 s for its levels 1 to 3, 0.3 s for a "
        "further load case, and 45 s of processor time for level 1 with 200 contacts. Where a target is missed, the tables "
        f"reference-set-up-costs and reference-set-up-ways show the causes. {run_times}"
    )
    title = "Run times of the mesh levels of the 3D reference from a cold start"
    return Table.of("reference-levels-cold", title, rows, note)


def set_up_cost_tables(costs: SetUpCosts) -> list[Table]:
    """Return two tables on the set-up of the 3D reference: processor time of its stages, and cheaper variants of it.

    ``costs``: measured processor times and, for each cheaper variant, the saved time and the change of contact loads.
    """
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
        for stage, spent in (*job.stages.items(), ("all", {kind: job.processor_time_of_work(kind) for kind in WORK}))
    ]
    floors = ", ".join(
        f"{job.processor_time_of_work('all') / 2.0:.1f} s ({job.scene}, level {job.level})" for job in costs.jobs
    )
    note = (
        "One process with one thread, without start and imports. The work of elimination is determined by the meshes; its "
        f"dense algebra runs in LAPACK. Two cores that never wait for each other need at least {floors}. {measured}"
    )
    ways: list[Row] = [
        {
            "scene": way.scene,
            Quantity("way", "variant", "", "s"): way.way,
            Quantity("saved", "CPU time saved", "s", ".2f"): way.saved,
            Quantity("moved", "largest change of a load", "% of mean", ".4f"): way.moved,
        }
        for way in costs.ways
    ]
    tried = (
        "Cheaper variants of the set-up that were tried on level 1 and rejected. A variant may change a load by at most "
        "0.001 % of the mean load, because stored runs must remain valid. The variant with a library of patches "
        "interpolates the patch of one flank between pitch radii 5 % smaller and 5 % larger; a library for any screw would "
        "have five such parameters (two conformities, contact angle, lead angle, ratio of ball and pitch radius) and, with "
        f"ten values of each, 100,000 patches. {measured}"
    )
    return [
        Table.of(
            "reference-set-up-costs",
            "Processor time of the set-up of the 3D reference, by stage and kind of work",
            rows,
            note,
        ),
        Table.of(
            "reference-set-up-ways",
            "Cheaper variants of the 3D set-up that were rejected: time saved and change of loads",
            ways,
            tried,
        ),
    ]


def _costliest_stages(level: ColdLevelTime) -> str:
    """Return as text the `DEAREST` longest stages in the set-up of a 3D mesh level, each with its seconds."""
    if level.stages is None:
        return "not measured"
    stages = sorted(level.stages.items(), key=lambda stage: -stage[1])
    return ", ".join(f"{name} {seconds:.1f} s" for name, seconds in stages[:DEAREST])


def speed_ratio_table(points: Mapping[str, Sequence[TimePoint]]) -> Table:
    """Return the table of run times of the 3D reference on its finest mesh level over those of Lin's model.

    The ratio is given for each scene, for a new process up to the loads and for a further load case of a known geometry.
    ``points``: errors and run times by name of the scene. Raises ValueError if the times come from several measurements.
    """
    rows: list[Row] = []
    for scene, several in points.items():
        low = next(p for p in several if p.name == "lin")
        best = [p for p in several if p.kind == "level"][-1]
        if low.cold and low.warm and best.cold and best.warm:
            common_conditions(p.measured for p in (low, best) if p.measured is not None)
            rows.append(
                {
                    "scene": scene,
                    Quantity("low", "Lin's model, cold start", "s", "g3"): low.cold,
                    Quantity("low_warm", "Lin's model, further load case", "s", "g3"): low.warm,
                    Quantity("ref", "3D reference, cold start", "s", ".1f"): best.cold,
                    Quantity("ref_warm", "3D reference, further load case", "s", ".2f"): best.warm,
                    Quantity("cold", "ratio, cold start", "", ".0f"): best.cold / low.cold,
                    Quantity("warm", "ratio, further load case", "", ".0f"): best.warm / low.warm,
                }
            )
    printed = printed_entry("lin-2.4.1", "speed_ratio").printed
    title = f"Run time of the 3D reference divided by that of Lin's model (for ANSYS, Lin's thesis prints over {printed})"
    return Table.of("reference-speed", title, rows)


def error_over_time_panel(scene: str, of_scene: Sequence[TimePoint]) -> Panel:
    """Return the panel of the largest load error over the cold-start time of all models and mesh levels on one scene.

    ``scene``: name of the scene, the title of the panel. ``of_scene``: errors and run times on it. Only converged solutions
    with a measured time are drawn; bars show the range of the error due to the mesh uncertainty.
    """

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
        drawn.append(series("3D reference, mesh levels", levels, "markers", emphasis=True))
    label = "run time of a cold start / s"
    return Panel(scene, label, "largest error / % of the mean load", tuple(drawn), log="xy")


def error_over_time_figures(points: Mapping[str, Sequence[TimePoint]]) -> list[Figure]:
    """Draw the largest load error over run time of all models and mesh levels, in a figure for each group of scenes.

    The groups are the case studies without preload, those with preload, and the screws not used in development. ``points``:
    errors and run times by name of the scene.
    """
    caption = (
        "Errors against the finest mesh level of the 3D reference; bars: range due to its mesh uncertainty. Errors below "
        f"{FLOOR:g} % are drawn at this value. Cold start: a new process with empty caches."
    )
    plain = [n for n in REFERENCED if n in points and any(p.name == "mei" for p in points[n])]
    groups = {
        "": plain,
        "-preload": [n for n in REFERENCED if n in points and n not in plain],
        "-unseen": [n for n in UNSEEN if n in points][:PANELS],
    }
    return [
        Figure(
            f"reference-time{tail}",
            "Largest contact-load error of each model and 3D mesh level over its run time from a cold start",
            tuple(error_over_time_panel(n, points[n]) for n in names),
            caption,
        )
        for tail, names in groups.items()
        if names
    ]


def points_of_all_scenes(study: Study, step: Step) -> dict[str, list[TimePoint]]:
    """Return errors and run times of all models and mesh levels on all compared scenes, by name of the scene.

    ``step`` is called with each line of progress. Raises ValueError if the times come from several measurements.
    """
    study.compute_once(ladder)  # its solutions are used here too
    points = {name: error_and_time_points(name, ref, study, step) for name, ref in compared_scenes(study).items()}
    common_conditions(p.measured for several in points.values() for p in several if p.measured is not None)
    return points


def measurement_conditions_sentence(study: Study, step: Step) -> str:
    """Return a sentence on the conditions under which run times were measured: program version, machine and date.

    The sentence is "No run times are stored." if there are none. ``step`` is called with each line of progress.
    """
    kept = study.compute_once(run_times_to_show, step)
    return "No run times are stored." if kept is None else str(kept)


def run_time_items(study: Study, step: Step) -> list[Table | Figure]:
    """Return the tables and figures of the section on run times.

    In a quick study, the tables on new processes, mesh levels, commands and set-ups are left out. ``step`` is called with
    each line of progress.
    """
    points, kept = study.compute_once(points_of_all_scenes, step), study.compute_once(run_times_to_show, step)
    items: list[Table | Figure] = [error_and_time_table(points, measurement_conditions_sentence(study, step))]
    if not study.quick:
        costs = load_costs((*(study.stores or ()), shipped_store()))
        items += [] if kept is None else [kernel_compilation_table(kept), cold_level_time_table(kept)]
        commands = load_times((*(study.stores or ()), shipped_store()), TYPED)
        items += [] if commands is None else [command_time_table(commands)]
        items += [] if costs is None else set_up_cost_tables(costs)
    return [*items, speed_ratio_table(points), *error_over_time_figures(points)]
