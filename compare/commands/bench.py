"""Command ``rollbench bench``: measures computing times on this computer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from rollbench.compare.commands.terminal import Flag, Json, app
from rollbench.compare.errors import ArgumentError
from rollbench.compare.running import show_progress_message
from rollbench.compare.text.printing import CommandOutput, TextTable, format_cell, print_command_output

if TYPE_CHECKING:
    from rollbench.compare.studies.run_times import RunTimeRow

#: Scene whose models are timed unless the user names others.
FIRST = "lin-case1"


@app.command
def bench(
    names: Annotated[list[str] | None, Parameter(negative="", show_default=False)] = None,
    /,
    *,
    long: Flag = False,
    store: Annotated[Path | None, Parameter(show_default=False)] = None,
    as_json: Json = False,
) -> int:
    """Measure computing times on this computer: of models on scenes, with their errors; with --store of all that is shown.

    Parameters
    ----------
    names
        Scenes with a 3D reference, on which the models are timed. Default: lin-case1.
    long
        Also time every mesh level of the 3D reference on these scenes, which takes some minutes a scene on idle cores.
    store
        Folder of stored runs. Measures all times that a report shows, each of which is stored when it is measured: models
        on all compared scenes, mesh levels on Lin's case studies, commands run in an empty home folder, and 24 of the
        randomly drawn screws of rollbench survey by all models and mesh levels. Takes about three hours on two idle cores;
        an interrupted run resumes.
    """
    if store is not None and (names or long):
        advice = "leave them out: a stored run times all that the report shows"
        raise ArgumentError("store", f"{store} with names of scenes or --long", "`store` alone", advice)
    if store is not None:
        return print_command_output(measure_release(store), as_json)
    return print_command_output(measure_scenes(names or [FIRST], long=long), as_json)


def measure_release(store: Path) -> CommandOutput:
    """Measure all computing times that a report shows and store them, and return tables of them.

    ``store``: folder in which each time is stored; those of the same sources and machine are not measured again. Raises
    InputError if a file cannot be written.
    """
    from rollbench.compare.models.study import SceneResultCache
    from rollbench.compare.reference.store import measuring_conditions, shipped_store
    from rollbench.compare.sections.reference_time import command_time_jobs, time_jobs
    from rollbench.compare.studies.run_times import ColdLevelTime, CommandTime, RunTime, RunTimeRow, measure_and_store
    from rollbench.compare.studies.survey_models import errors_and_times, time_models_and_levels_on_screws

    study = SceneResultCache((store, shipped_store()))
    jobs = time_jobs(study) | command_time_jobs()
    kept = measure_and_store(store, measuring_conditions(), jobs, show_progress_message)
    note = "new process, empty caches; a further load case {:.3g} s"
    rows = [
        RunTimeRow(f"{scene}: {way}", t.cold, None, None, t.memory, None, note.format(t.warm))
        for (scene, way), t in kept.of_kind(RunTime).items()
    ]
    for one in kept.of_kind(ColdLevelTime).values():
        further = note.format(one.load_case or 0.0)
        rows.append(RunTimeRow(f"{one.scene}: 3D level {one.level}", one.process, None, None, one.memory, None, further))
    rows += [command.job for command in kept.of_kind(CommandTime).values()]
    for s in errors_and_times(time_models_and_levels_on_screws(store, show_progress_message).runs):
        error = float(median(s.gate_errors)) if s.gate_errors.size else None
        further = f"medians, against {s.judge}; processor time of one core; a further load case "
        further += f"{median(s.further_case_seconds):.3g} s"
        name = f"{s.name} on {s.first_case_seconds.size} random screws"
        rows.append(RunTimeRow(name, float(median(s.first_case_seconds)), error_percent=error, note=further))
    return CommandOutput([asdict(row) for row in rows], [_run_time_table(rows)])


def measure_scenes(names: Sequence[str], *, long: bool) -> CommandOutput:
    """Measure the computing times of the models on scenes and of an ensemble, and return a table of them.

    ``names``: names of the scenes; ``long``: whether to time each level of the 3D reference on them, too. Raises InputError
    for a scene without a 3D reference.
    """
    from rollbench.compare.models.study import SceneResultCache
    from rollbench.compare.reference.store import measuring_conditions
    from rollbench.compare.sections import reference_time
    from rollbench.compare.studies.run_times import RunTimeRow, measure_and_store, time_ensemble

    study = SceneResultCache()
    known = reference_time.references_of_compared_scenes(study)
    for name in names:
        if name not in known:
            raise ArgumentError("names", name, ", ".join(known), "choose scenes that have a 3D reference")
    jobs = reference_time.model_time_jobs(study, names) | (reference_time.level_time_jobs(study, names) if long else {})
    kept = measure_and_store(None, measuring_conditions(), jobs, show_progress_message)
    study.computed_values[reference_time.run_times_to_show, show_progress_message] = kept
    rows = list[RunTimeRow]()
    for name in names:
        for p in reference_time.error_and_time_points(name, known[name], study, show_progress_message):
            if p.cold is not None:
                warm = "" if p.warm is None else f"; a further solve {p.warm:.3g} s"
                note = f"new process, empty caches{warm}; RMS error {p.rms:.2f} %"
                rows.append(RunTimeRow(f"{name}: {p.label}", p.cold, None, p.unknowns, p.memory, p.error, note))
    rows.append(time_ensemble())
    return CommandOutput([asdict(row) for row in rows], [_run_time_table(rows)])


def _run_time_table(jobs: Sequence[RunTimeRow]) -> TextTable:
    """Return the table of all measured computing times for the terminal."""
    forms = {"seconds": ".3g", "error_percent": ".2f", "ratio": ".3g", "unknowns": "d", "peak_MB": ".0f"}
    rows = [[job.job, *(format_cell(getattr(job, name), form) for name, form in forms.items()), job.note] for job in jobs]
    headings = ("timed", "seconds", "load error %", "ratio of times", "unknowns", "peak memory MB", "what is included")
    return TextTable(headings, rows, "computing times on this computer")
