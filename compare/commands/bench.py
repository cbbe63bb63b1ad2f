"""Command ``rollbench bench``: measures computing times on this computer."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from rollbench.compare.commands.terminal import Flag, Json, app
from rollbench.compare.errors import ArgumentError
from rollbench.compare.running import show_progress_message
from rollbench.compare.text.printing import CommandOutput, format_cell, print_command_output, ruled_table

if TYPE_CHECKING:
    from rollbench.compare.sections.reference_time import ErrorAndRunTime
    from rollbench.compare.studies.run_times import RunTimeRow

#: Scene whose models are timed unless the user names others.
FIRST = "lin-case1"


@app.command
def bench(
    names: Annotated[list[str] | None, Parameter(negative="", show_default=False)] = None,
    /,
    *,
    long: Flag = False,
    source: str | None = None,
    drawn: Flag = False,
    store: Annotated[Path | None, Parameter(show_default=False)] = None,
    as_json: Json = False,
) -> int:
    """Measure computing times on this computer: of models (with their errors) and of whole commands.

    Parameters
    ----------
    names
        Scenes with a 3D reference, on which the models are timed. Default: lin-case1; with --long all scenes that the
        report compares.
    long
        Also time every mesh level of the 3D reference, which takes about an hour on idle cores, but no commands.
    source
        Measure only the times that the page of this publication shows (such as lin), which takes ten to fifteen minutes on
        two idle cores.
    drawn
        Instead, solve 24 of the randomly drawn screws of rollbench survey by all models and on mesh levels 1 and 2 of the
        3D reference, in one and a half hours of processor time; needs --store. An interrupted run resumes.
    store
        Folder of stored runs in which the times are stored for the report. Without --long, --source and --drawn, only the
        times of commands are stored, run in an empty home folder and so without caches.
    """
    if drawn:
        if names or long or source is not None:
            given = "this option, which times screws drawn at random, with names of scenes, --long or --source"
            allowed, advice = (
                "`drawn` with `store`, without scenes and other options",
                "leave out all but `drawn` and `store`",
            )
            raise ArgumentError("drawn", given, allowed, advice)
        if store is None:
            advice = "add `store` with a folder in which the timed runs are stored"
            given = "this option, which times screws drawn at random, without a folder for the runs"
            raise ArgumentError("drawn", given, "only together with `store`", advice)
        return print_command_output(measure_drawn_screws(store), as_json)
    if source is not None and (names or long):
        given, allowed = (
            f"{source} with scenes or --long",
            "`source` without scenes and `long`: the scenes are those of the publication",
        )
        raise ArgumentError("source", given, allowed, "leave out scenes and `long`")
    if store is not None and names:
        advice = "leave the names out: the report shows the times of all scenes from one run of this command"
        raise ArgumentError("store", f"{store} with names of scenes", "only without names of scenes", advice)
    if source is not None:
        return print_command_output(measure_publication_times(source, store), as_json)
    return print_command_output(measure_default_times(names or (), store, long=long), as_json)


def measure_publication_times(source: str, store: Path | None) -> CommandOutput:
    """Measure the computing times that the report's page on a publication shows, and return a table of them.

    ``source``: name of the publication. ``store``: folder in which the times are stored; None: not stored. Raises
    InputError for a publication without times.
    """
    from rollbench.compare.case import all_cases
    from rollbench.compare.models.study import SceneResultCache
    from rollbench.compare.reference.store import shipped_store
    from rollbench.compare.studies.run_times import RunTimeRow, StoredRunTimes, save_run_times

    timed = {case.name: case for case in all_cases() if (case.folder / "times.py").is_file()}
    if source not in timed:
        raise ArgumentError("source", f'"{source}"', ", ".join(timed), "choose a publication whose page shows times")
    study = SceneResultCache(None if store is None else (store, shipped_store()))
    kept: StoredRunTimes = timed[source].import_object("times:measure_run_times")(study, show_progress_message)
    if store is not None:
        save_run_times(store, kept, source)
    note = "new process, empty caches; a further load case {:.3g} s"
    jobs = [
        RunTimeRow(f"{scene}: {way}", t.cold, None, None, t.memory, None, note.format(t.warm))
        for (scene, way), t in kept.times_by_scene_and_model.items()
    ]
    for one in kept.mesh_level_times:
        further = note.format(one.load_case or 0.0)
        jobs.append(RunTimeRow(f"{one.scene}: 3D level {one.level}", one.process, None, None, one.memory, None, further))
    return CommandOutput([asdict(job) for job in jobs], _run_time_tables(jobs))


def measure_drawn_screws(store: Path) -> CommandOutput:
    """Solve 24 randomly drawn screws, and return errors and computing times of all models and of two mesh levels in 3D.

    ``store``: folder in which each timed solution is stored. Raises InputError if a file cannot be written.
    """
    from rollbench.compare.studies.run_times import RunTimeRow
    from rollbench.compare.studies.survey_models import TIMED, errors_and_times, time_models_and_levels_on_screws

    jobs = [
        RunTimeRow(
            f"{s.name} on {s.first_case_seconds.size} random screws",
            float(median(s.first_case_seconds)),
            error_percent=float(median(s.gate_errors)) if s.gate_errors.size else None,
            note=f"medians, against {TIMED[-1]}; processor time of one core; a further load case "
            f"{median(s.further_case_seconds):.3g} s",
        )
        for s in errors_and_times(time_models_and_levels_on_screws(store, show_progress_message).runs)
    ]
    return CommandOutput([asdict(job) for job in jobs], _run_time_tables(jobs))


def measure_default_times(names: Sequence[str], store: Path | None, *, long: bool) -> CommandOutput:
    """Measure computing times of models and commands, and return a table of them.

    ``names``: scenes; if empty, lin-case1 or, with ``long``, all scenes that the report compares. ``store``: folder in
    which the times are stored; None: not stored. ``long``: time the mesh levels of the 3D reference instead of commands.
    Raises InputError for a scene without a 3D reference.
    """
    from rollbench.compare.sections.reference_time import measure_command_times
    from rollbench.compare.studies.run_times import TYPED, save_run_times, time_ensemble

    jobs = [*measure_model_times(names, store if long else None, long=long)]
    if not long:
        kept = measure_command_times(show_progress_message)
        if store is not None:
            save_run_times(store, kept, TYPED)
        jobs += [*(command.job for command in kept.command_times), time_ensemble()]
    return CommandOutput([asdict(job) for job in jobs], _run_time_tables(jobs))


def measure_model_times(names: Sequence[str], store: Path | None, *, long: bool) -> Iterator[RunTimeRow]:
    """Measure the computing times of the models of scenes and, if ``long``, of the levels of the 3D reference.

    ``store``: folder in which the times are stored; None: not stored. Raises InputError for a scene without a 3D reference.
    """
    from rollbench.compare.models.study import SceneResultCache
    from rollbench.compare.reference.store import shipped_store
    from rollbench.compare.sections.reference_time import (
        error_and_time_points,
        measure_run_times,
        references_of_compared_scenes,
        run_times_to_show,
    )
    from rollbench.compare.studies.run_times import save_run_times

    study = SceneResultCache(None if store is None else (store, shipped_store()))
    known = references_of_compared_scenes(study)
    for name in names:
        if name not in known:
            raise ArgumentError("names", name, ", ".join(known), "choose scenes that have a 3D reference")
    wanted = names or (tuple(known) if long else (FIRST,))
    kept = measure_run_times(study, wanted, show_progress_message, with_mesh_levels=long)
    if store is not None:
        save_run_times(store, kept)
    study.computed_values[run_times_to_show, show_progress_message] = kept
    for name in wanted:
        yield from run_time_rows_of_scene(name, error_and_time_points(name, known[name], study, show_progress_message))


def run_time_rows_of_scene(scene: str, points: Sequence[ErrorAndRunTime]) -> Iterator[RunTimeRow]:
    """Yield, for the table of computing times, the time and error of each model and mesh level on a scene.

    ``scene``: name of the scene. ``points``: errors and times of all models and mesh levels; those without a time are left
    out.
    """
    from rollbench.compare.studies.run_times import RunTimeRow

    for p in points:
        if p.cold is not None:
            warm = "" if p.warm is None else f"; a further solve {p.warm:.3g} s"
            note = f"new process, empty caches{warm}; RMS error {p.rms:.2f} %"
            yield RunTimeRow(f"{scene}: {p.label}", p.cold, None, p.unknowns, p.memory, p.error, note)


def _run_time_tables(jobs: Sequence[RunTimeRow]) -> Iterator[object]:
    """Yield the table of all measured computing times for the terminal."""
    forms = {"seconds": ".3g", "error_percent": ".2f", "ratio": ".3g", "unknowns": "d", "peak_MB": ".0f"}
    rows = ([job.job, *(format_cell(getattr(job, name), form) for name, form in forms.items()), job.note] for job in jobs)
    headings = ("timed", "seconds", "load error %", "ratio of times", "unknowns", "peak memory MB", "what is included")
    yield ruled_table("computing times on this computer", headings, rows, ("timed", "what is included"))
