"""Tables and figures on load error over run time, for every low-order model and 3D mesh level on every compared scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any, Literal, cast

import numpy as np

from rollbench.compare.case import all_cases
from rollbench.compare.measure import error_percent, load_error, load_scale_of_check_errors
from rollbench.compare.models.comparison import REFERENCED, models_shown_for_scene, path_of_condensed_bodies
from rollbench.compare.models.model import Model, ModelOptions
from rollbench.compare.models.modelling import UNSEEN, RefinementStepResult, solve_refinement_sequence_on_all_scenes
from rollbench.compare.models.registry import MODELS, run_model
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.printed import printed_entry
from rollbench.compare.reference import store
from rollbench.compare.reference.estimate import Reference
from rollbench.compare.reference.levels import SOURCE_LEVEL
from rollbench.compare.studies import run_times as timing
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import Scene
from rollbench.reports.content import Figure, Panel, Row, Series, Table

Step = Callable[[str], None]
#: Smallest contact-load error drawn in the figures [% of the mean load]; smaller errors are drawn at this value.
FLOOR = 1e-2
#: Number of solutions in a running process whose median time is the time of a further solution (warm time).
WARM_CALLS = 10
#: Number of stages of a set-up, the longest ones, that the table of cold-start times names.
DEAREST = 3
#: Scenes with many contacts on which mesh level 1 is timed, for its memory.
LARGE = ("unseen-40x10", "unseen-25x5")
#: Largest number of panels in one figure.
PANELS = 6


@dataclass(frozen=True)
class ErrorAndRunTime:
    """Error and run time of one model or mesh level on one scene, against the finest mesh level of the 3D reference."""

    #: Name of the model or mesh level in tables.
    label: str
    #: Kind: low-order model, mesh level of the 3D reference, or the mesh of Lin's thesis ("source mesh").
    kind: Literal["model", "level", "source mesh"]
    #: Largest error of a contact load [% of the mean load].
    error: float
    #: RMS error of the contact loads [% of the mean load].
    rms: float
    #: Lower end of the range of ``error`` due to the mesh uncertainty of the reference [% of the mean load].
    low: float
    #: Upper end of the range of ``error`` due to the mesh uncertainty of the reference [% of the mean load].
    high: float
    #: Time of a solution in a new process with empty caches (cold start) [s]; None: not measured.
    cold: float | None
    #: Time of a further solution of the same geometry in this process [s]; None: not measured.
    warm: float | None
    #: Number of unknowns of the model or mesh.
    unknowns: int
    #: Peak memory [MB]; None: not measured.
    memory: float | None
    #: Short name of the model or mesh level, for figures.
    name: str
    #: Largest contact-load error as ``rollbench check`` judges it [% of the contact's load; for nearly unloaded contacts,
    #: of the mean load].
    gate_error: float
    #: Upper end of the range of ``gate_error`` due to the mesh uncertainty of the reference [%].
    gate_high: float
    #: Status of the solver, such as "converged".
    status: str = "converged"


def largest_error_with_range(loads: Array, reference: Reference, scale: Array) -> tuple[float, float, float]:
    """Return the largest error of contact loads against the 3D reference, and its range due to the mesh uncertainty.

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
    tuple of float
        Largest error, and lower and upper end of its range [%].
    """
    off = np.abs(error_percent(loads, reference.load, scale))
    bar = np.abs(error_percent(reference.uncertainty, 0.0, scale))
    return float(off.max()), max(0.0, float((off - bar).max())), float((off + bar).max())


def errors_against_reference(loads: Array, reference: Reference) -> dict[str, Any]:
    """Return the errors of contact loads against the 3D reference, as keyword arguments of `ErrorAndRunTime`.

    ``loads``: contact loads of n balls on the four groove flanks, (n, 4) [N]. ``reference``: the 3D reference. The values
    of the dictionary are the largest and the RMS error with the range of the largest one [% of the mean load] (error, rms,
    low, high), and the largest error [% of the contact's load; for nearly unloaded contacts, of the mean load], which
    ``rollbench check`` judges, with the upper end of its range (gate_error, gate_high).
    """
    e = load_error(loads, reference.load, reference.contacts)
    _, low, high = largest_error_with_range(loads, reference, np.full(loads.shape, reference.mean))
    gate = largest_error_with_range(loads, reference, load_scale_of_check_errors(reference.load, reference.mean))
    of_mean = {"error": e.max_percent, "rms": e.rms_percent, "low": low, "high": high}
    return of_mean | {"gate_error": gate[0], "gate_high": gate[2]}


def further_solution_seconds(model: Model, scene: Scene, options: ModelOptions) -> float:
    """Return the time [s] in which a model solves a scene again, with body compliances available.

    The time is the median of `WARM_CALLS` solutions, after a first solution that is not timed.
    """
    spent = []
    for _ in range(WARM_CALLS + 1):
        start = perf_counter()
        run_model(scene, model.name, options)
        spent.append(perf_counter() - start)
    return float(np.median(spent[1:]))


def model_time_jobs(
    cache: SceneResultCache, scene_names: Sequence[str]
) -> dict[timing.Timed, Callable[[], timing.Measured]]:
    """Return functions that time all models on scenes, in a new (cold) and in a running process (warm), by what they time.

    ``cache``: source of scenes and 3D references; ``scene_names``: names of the scenes.
    """

    def time_model(name: str, model: Model, bodies: Path | None) -> timing.RunTime:
        cold = timing.time_model_in_new_process(name, model.name, bodies)
        options = ModelOptions(estimate_beam_mesh_error=False, condensed_bodies_file=bodies)
        return replace(cold, warm=further_solution_seconds(model, cache.built_in_scene(name), options))

    return {
        (name, model.name): partial(time_model, name, model, bodies)
        for name, found in cache.stored_references(scene_names).items()
        for model, bodies in models_with_body_files(name, found, cache)
    }


def level_time_jobs(
    cache: SceneResultCache, scene_names: Sequence[str]
) -> dict[timing.Timed, Callable[[], timing.Measured]]:
    """Return functions that time all stored mesh levels of scenes in new processes, by scene and mesh level.

    ``cache``: source of scenes and 3D references; ``scene_names``: names of the scenes.
    """
    return {
        (name, run.level): partial(timing.time_mesh_level_in_new_process, name, run.level)
        for name, found in cache.stored_references(scene_names).items()
        for run in stored_reference_runs(name, found, cache)
    }


def command_time_jobs() -> dict[timing.Timed, Callable[[], timing.Measured]]:
    """Return functions that time the commands in `COMMANDS`, each with an empty home directory and without caches."""
    return {(command,): partial(timing.time_command_in_empty_home, command) for command in timing.COMMANDS}


def time_jobs(cache: SceneResultCache) -> dict[timing.Timed, Callable[[], timing.Measured]]:
    """Return functions that time all models on all compared scenes, mesh level 1 of `LARGE`, and what cases bring.

    ``cache``: source of scenes and 3D references. The key of a function is what it times.
    """
    jobs = model_time_jobs(cache, list(references_of_compared_scenes(cache)))
    jobs |= {(name, 1): partial(timing.time_mesh_level_in_new_process, name, 1) for name in LARGE}
    for case in all_cases():
        jobs |= case.import_object(case.time_jobs)(cache) if case.time_jobs else {}
    return jobs


def run_times_to_show(cache: SceneResultCache, step: Step) -> timing.StoredRunTimes | None:
    """Return the run times that a report shows: stored run times or, if ``cache`` asks for it, newly measured run times.

    New run times, but those of commands, are measured in about an hour and stored in the first folder of stored runs.
    Returns None if no times are to be measured and none are stored. ``step`` is called with each line of progress.
    """
    folders = cache.reference_folders or ()
    if not cache.measures_run_times:
        return timing.load_run_times((*folders, store.shipped_store()))
    return timing.measure_and_store(folders[0] if folders else None, store.measuring_conditions(), time_jobs(cache), step)


def references_of_compared_scenes(cache: SceneResultCache) -> dict[str, Reference]:
    """Return the 3D reference of every compared scene, by the scene's name.

    These are the case studies and, unless the report is quick, the scenes that were chosen before they were solved in 3D.
    """
    return cache.stored_references(REFERENCED if cache.quick else (*REFERENCED, *UNSEEN))


def models_with_body_files(
    scene_name: str, scene_reference: Reference, cache: SceneResultCache
) -> list[tuple[Model, Path | None]]:
    """Return the models that can describe a scene, each with the file of body compliances that it needs (or None).

    Only the model "condensed" needs a file: the compliances of screw and nut, condensed in the finest 3D run. It is left
    out if there is no such file. ``scene_name``: name of the scene. ``scene_reference``: its 3D reference.
    """
    scene = cache.built_in_scene(scene_name)
    bodies = path_of_condensed_bodies(scene, scene_reference, cache.reference_folders)
    further = [m for m in MODELS.values() if not m.compared and m.covers_scene(scene)]
    every = [(m, bodies if m.name == "condensed" else None) for m in (*models_shown_for_scene(scene), *further)]
    return [(m, file) for m, file in every if m.name != "condensed" or file is not None]


def stored_reference_runs(scene_name: str, scene_reference: Reference, cache: SceneResultCache) -> list[store.Run]:
    """Return the stored 3D runs of a scene: first the one on the mesh of Lin's thesis, if stored, then all mesh levels.

    ``scene_name``: name of the scene. ``scene_reference``: its 3D reference on the mesh levels.
    """
    source = store.load_stored_run(cache.built_in_scene(scene_name), SOURCE_LEVEL, stores=cache.reference_folders)
    return [*(() if source is None else (source,)), *scene_reference.runs]


def error_and_time_points(
    scene_name: str, scene_reference: Reference, cache: SceneResultCache, step: Step
) -> list[ErrorAndRunTime]:
    """Return the load errors and run times of all models and 3D mesh levels on one scene.

    Parameters
    ----------
    scene_name
        Name of the scene.
    scene_reference
        3D reference of the scene.
    cache
        Source of solutions and stored runs.
    step
        Called with each line of progress.
    """
    kept, out = cache.compute_once(run_times_to_show, step), []
    for model, bodies in models_with_body_files(scene_name, scene_reference, cache):
        known = None if kept is None else kept.times.get((scene_name, model.name))
        result = _solve_scene(scene_name, model, cache, bodies)
        errors = errors_against_reference(result.load, scene_reference)
        costs: dict[str, Any] = {name: getattr(known, name, None) for name in ("cold", "warm", "memory")}
        costs |= {"unknowns": result.solver.unknowns, "status": result.status}
        out.append(ErrorAndRunTime(model.label, "model", **errors, **costs, name=model.name))
    for run in stored_reference_runs(scene_name, scene_reference, cache):
        time = None if kept is None else kept.of_kind(timing.ColdLevelTime).get((scene_name, run.level))
        cold, warm = (None, None) if time is None else (time.process, time.load_case)
        costs = {"cold": cold, "warm": warm, "unknowns": run.unknowns, "memory": run.peak_MB, "status": run.status}
        costs |= errors_against_reference(run.load, scene_reference)
        if run.level == SOURCE_LEVEL:
            out.append(ErrorAndRunTime("3D reference, mesh of Lin's thesis", "source mesh", **costs, name="3D, Lin's mesh"))
        else:
            out.append(ErrorAndRunTime(f"3D reference, level {run.level}", "level", **costs, name=f"3D level {run.level}"))
    return out


def _solve_scene(scene_name: str, model: Model, cache: SceneResultCache, condensed_file: Path | None) -> StaticResult:
    """Solve a scene by a low-order model, or return the solution that another section has already computed.

    ``scene_name``: name of the scene. ``condensed_file``: file of condensed body compliances that the model needs; None: no
    file.
    """
    if condensed_file is None:
        return cache.solve_once(scene_name, model.name)
    for rung in cache.computed_values.get((solve_refinement_sequence_on_all_scenes,), ()):
        if (rung.scene, rung.model) == (scene_name, model.name):
            return cast(RefinementStepResult, rung).result
    options = ModelOptions(estimate_beam_mesh_error=False, condensed_bodies_file=condensed_file)
    return run_model(cache.built_in_scene(scene_name), model.name, options)


def error_and_time_table(points_by_scene: Mapping[str, Sequence[ErrorAndRunTime]], conditions_sentence: str = "") -> Table:
    """Return the table of load errors and run times of every model and 3D mesh level on every scene.

    Parameters
    ----------
    points_by_scene
        Errors and run times of models and mesh levels, by name of the scene.
    conditions_sentence
        Sentence on the conditions of the time measurement, which ends the note below the table.
    """
    rows: list[Row] = [
        {
            "scene": scene,
            "model_or_level": p.label,
            "largest_load_error": p.error,
            "largest_load_error_low": p.low,
            "largest_load_error_high": p.high,
            "rms_error": p.rms,
            "cold_start": p.cold,
            "further_load_case": p.warm,
            "unknowns": p.unknowns,
            "memory": p.memory,
            "status": "" if p.status == "converged" else p.status,
        }
        for scene, several in points_by_scene.items()
        for p in several
    ]
    note = (
        "Errors of all models and mesh levels are against the finest mesh level of the 3D reference, whose own error is "
        "zero by definition. At least and at most: range of the largest error due to the mesh uncertainty of every "
        "contact. Cold start: a new process with empty caches; for low-order models from the start of the interpreter to "
        "the first solution; for the 3D reference up to its loads, on all cores. Further "
        "solution: the compliance of the bodies is known; for the 3D reference a further load "
        "case. Peak memory includes interpreter and libraries; for several processes it is the sum of "
        "their peaks. Unknowns of the 3D reference are those of the single mesh that is equivalent to its condensed parts."
        + (f" {conditions_sentence}" if conditions_sentence else "")
    )
    title = "Contact-load error and run time of each model and 3D mesh level on each scene"
    return Table.from_rows("reference-time", title, rows, note)


def command_time_table(run_times: timing.StoredRunTimes) -> Table:
    """Return the table of run times of commands that start with an empty home directory, that is without caches.

    ``run_times``: measured run times.
    """
    rows: list[Row] = [
        {
            "command": c.command,
            "run_time_empty_home": c.seconds,
            "first_line_time": c.first_line,
            "cpu_time_empty_home": c.cpu,
            "run_time_again": c.again,
            "cpu_time_again": c.again_cpu,
            "run_time_beside": c.beside,
            "cpu_time_beside": c.beside_cpu,
            "measurement_note": c.note,
        }
        for c in run_times.of_kind(timing.CommandTime).values()
    ]
    note = (
        f"Each command is run as typed, without a set number of threads, in a home directory without any cache; rollbench "
        f"{timing.NEW} wrote my.toml. The second run finds stored body compliances, so its time is the least "
        "that caches can achieve. CPU time is the sum over all processes of the command; it depends less on other work on "
        f"the machine. {run_times}"
    )
    title = "Run times of commands that start with an empty home directory, without caches"
    return Table.from_rows("reference-typed", title, rows, note)


def cold_start_time_table_of_mesh_levels(run_times: timing.StoredRunTimes) -> Table:
    """Return the table of run times of each mesh level of the 3D reference from a cold start, without stored meshes.

    ``run_times``: measured run times.
    """
    rows: list[Row] = [
        {
            "scene": c.scene,
            "contacts": c.contacts,
            "level": c.level,
            "cold_start": c.process,
            "cpu_time": c.cpu,
            "further_load_case": c.load_case,
            "longest_stages": _longest_stages_text(c),
            "memory": c.memory,
            "status": c.status,
        }
        for c in run_times.of_kind(timing.ColdLevelTime).values()
    ]
    note = (
        "Each level is computed in a separate process on all cores, from the start of the interpreter to the loads, "
        "without any stored mesh, part or run. Peak memory: sum of the peaks of all processes of one "
        f"set-up. {run_times}"
    )
    title = "Run times of the mesh levels of the 3D reference from a cold start"
    return Table.from_rows("reference-levels-cold", title, rows, note)


def _longest_stages_text(level: timing.ColdLevelTime) -> str:
    """Return as text the longest stages (`DEAREST` in number) in the set-up of a 3D mesh level, each with its time [s]."""
    if level.stages is None:
        return "not measured"
    stages = sorted(level.stages.items(), key=lambda stage: -stage[1])
    return ", ".join(f"{name} {seconds:.1f} s" for name, seconds in stages[:DEAREST])


def run_time_ratio_table(points_by_scene: Mapping[str, Sequence[ErrorAndRunTime]]) -> Table:
    """Return the table of run times of the 3D reference on its finest mesh level divided by those of Lin's model.

    For each scene there are two ratios: of the times in a new process, from its start to the contact loads, and of the
    times for a further load case of the same geometry.
    ``points_by_scene``: errors and run times by name of the scene.
    """
    rows: list[Row] = []
    for scene, several in points_by_scene.items():
        low = next(p for p in several if p.name == "lin")
        best = [p for p in several if p.kind == "level"][-1]
        if low.cold and low.warm and best.cold and best.warm:
            rows.append(
                {
                    "scene": scene,
                    ("cold_start_of", "Lin's model"): low.cold,
                    ("further_load_case_of", "Lin's model"): low.warm,
                    ("cold_start_of_f1", "the 3D reference"): best.cold,
                    ("further_load_case_of_f2", "the 3D reference"): best.warm,
                    "time_ratio_cold": best.cold / low.cold,
                    "time_ratio_warm": best.warm / low.warm,
                }
            )
    printed = printed_entry("lin-2.4.1", "speed_ratio").number_as_printed
    title = f"Run time of the 3D reference divided by that of Lin's model (for ANSYS, Lin's thesis prints over {printed})"
    return Table.from_rows("reference-speed", title, rows)


def error_over_time_panel(scene_name: str, scene_points: Sequence[ErrorAndRunTime]) -> Panel:
    """Return the panel of the largest load error over the cold-start time of all models and mesh levels on one scene.

    ``scene_name``: name of the scene, the title of the panel. ``scene_points``: errors and run times on this scene. Only
    converged solutions with a measured time are drawn; bars show the range of the error due to the mesh uncertainty.
    """

    def series(label: str, points: Sequence[ErrorAndRunTime], style: str, *, emphasis: bool = False) -> Series:
        errors, low, high = ([max(getattr(p, end), FLOOR) for p in points] for end in ("error", "low", "high"))
        times = [p.cold for p in points if p.cold is not None]
        return Series(label, times, errors, style, bold=emphasis, error_bars=(low, high))

    good = [p for p in scene_points if p.status == "converged" and p.cold is not None]
    drawn = [series(p.label, [p], "markers") for kind in ("model", "source mesh") for p in good if p.kind == kind]
    levels = [p for p in good if p.kind == "level"]
    if levels:
        drawn.append(series("3D reference, mesh levels", levels, "markers", emphasis=True))
    label = "run time of a cold start / s"
    return Panel(scene_name, label, "largest contact-load error / % of the mean load", tuple(drawn), log_axes="xy")


def error_over_time_figures(points_by_scene: Mapping[str, Sequence[ErrorAndRunTime]]) -> list[Figure]:
    """Draw the largest load error of all models and mesh levels against run time, in a figure for each group of scenes.

    The groups are the case studies without preload, those with preload, and the screws not used in development.
    ``points_by_scene``: errors and run times by name of the scene.
    """
    caption = (
        "Errors against the finest mesh level of the 3D reference; bars: range due to its mesh uncertainty. Errors below "
        f"{FLOOR:g} % are drawn at this value. Cold start: a new process with empty caches."
    )
    cases, unseen = ([n for n in names if n in points_by_scene] for names in (REFERENCED, UNSEEN))
    plain = [n for n in cases if any(p.name == "mei" for p in points_by_scene[n])]
    groups = (
        ("", "case studies without preload", plain),
        ("-preload", "case studies with preload", [n for n in cases if n not in plain]),
        ("-unseen", "screws not used in development", unseen[:PANELS]),
    )
    return [
        Figure(
            f"reference-time{tail}",
            f"Largest contact-load error of each model and 3D mesh level against cold-start run time: {words}",
            tuple(error_over_time_panel(n, points_by_scene[n]) for n in names),
            caption,
        )
        for tail, words, names in groups
        if names
    ]


def errors_and_times_of_all_scenes(cache: SceneResultCache, step: Step) -> dict[str, list[ErrorAndRunTime]]:
    """Return errors and run times of all models and mesh levels on all compared scenes, by name of the scene.

    ``step`` is called with each line of progress.
    """
    cache.compute_once(solve_refinement_sequence_on_all_scenes)  # its solutions are used here too
    found = references_of_compared_scenes(cache)
    return {name: error_and_time_points(name, reference, cache, step) for name, reference in found.items()}


def run_time_conditions_sentence(cache: SceneResultCache, step: Step) -> str:
    """Return a sentence on the conditions under which run times were measured: program version, machine and date.

    The sentence is `UNMEASURED` if there are none of this version. ``step`` is called with each line of progress.
    """
    return str(cache.compute_once(run_times_to_show, step) or store.UNMEASURED)


def run_time_items(cache: SceneResultCache, step: Step) -> list[Table | Figure]:
    """Return the tables and figures of the section on run times.

    In a quick report, the tables on new processes, mesh levels and commands are left out. ``step`` is called with
    each line of progress.
    """
    points, kept = cache.compute_once(errors_and_times_of_all_scenes, step), cache.compute_once(run_times_to_show, step)
    items: list[Table | Figure] = [error_and_time_table(points, run_time_conditions_sentence(cache, step))]
    if not cache.quick:
        items += [] if kept is None else [cold_start_time_table_of_mesh_levels(kept), command_time_table(kept)]
    return items if kept is None else [*items, run_time_ratio_table(points), *error_over_time_figures(points)]
