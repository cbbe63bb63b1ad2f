"""The command ``rollbench bench``: run times on this machine."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from rollbench.compare.commands.terminal import Flag, Json, app
from rollbench.compare.errors import ArgumentError
from rollbench.compare.running import on_terminal
from rollbench.compare.text.printing import Answer, cell, print_answer, ruled

if TYPE_CHECKING:
    from rollbench.compare.sections.reference_time import TimePoint
    from rollbench.compare.studies.run_times import Job

#: Scene whose models are timed unless others are named.
FIRST = "lin-case1"


@app.command
def bench(
    names: Annotated[list[str] | None, Parameter(negative="", show_default=False)] = None,
    /,
    *,
    long: Flag = False,
    source: str | None = None,
    store: Annotated[Path | None, Parameter(show_default=False)] = None,
    as_json: Json = False,
) -> int:
    """Measure run times on this machine: models with their errors, whole commands, and threads.

    Parameters
    ----------
    names
        Scenes with a 3D reference whose models are timed. Default: lin-case1; with --long all scenes that the report
        compares.
    long
        Also time every mesh level of the 3D reference, about an hour on idle cores; threads are not timed.
    source
        Measure only the times that the page of this case shows (such as lin), minutes on idle cores.
    store
        Folder of stored runs in which the times are kept for the report; without --long and --source, the times of
        commands typed in an empty home.
    """
    if source is not None and (names or long):
        raise ArgumentError("source", source, "without names and --long", "leave them out")
    if store is not None and names:
        raise ArgumentError("store", str(store), "without names", "a report shows times of one measuring run")
    answer = run_bench(names or (), store, long=long) if source is None else run_source(source, store)
    return print_answer(answer, as_json)


def run_source(source: str, store: Path | None) -> Answer:
    """Measure the run times that the page of a case shows. Raises InputError for a case without run times."""
    from rollbench.compare.case import every_case
    from rollbench.compare.models.study import Study
    from rollbench.compare.reference.store import shipped_store
    from rollbench.compare.studies.run_times import Job, save_times

    timed = {case.name: case for case in every_case() if (case.folder / "times.py").is_file()}
    if source not in timed:
        raise ArgumentError("source", f'"{source}"', ", ".join(timed), "name a case whose page shows run times")
    study = Study(None if store is None else (store, shipped_store()))
    kept = timed[source].import_object("times:measured_now")(study, on_terminal)
    if store is not None:
        save_times(store, kept, source)
    note = "new process, empty caches; a further load case {:.3g} s"
    jobs = [
        Job(f"{scene}: {way}", t.cold, None, None, t.memory, None, note.format(t.warm))
        for (scene, way), t in kept.times.items()
    ]
    for one in kept.levels:
        further = note.format(one.load_case or 0.0)
        jobs.append(Job(f"{one.scene}: 3D level {one.level}", one.process, None, None, one.memory, None, further))
    return Answer([asdict(job) for job in jobs], _tables(jobs))


def run_bench(names: Sequence[str], store: Path | None, *, long: bool) -> Answer:
    """Measure run times; a command that fails carries a note. Raises InputError for a scene without a reference."""
    from rollbench.compare.sections.reference_time import typed_now
    from rollbench.compare.studies.run_times import TYPED, save_times, time_threads

    jobs = [*models(names, store if long else None, long=long)]
    if not long:
        kept = typed_now(on_terminal)
        if store is not None:
            save_times(store, kept, TYPED)
        jobs += [*(command.job for command in kept.typed), *time_threads()]
    return Answer([asdict(job) for job in jobs], _tables(jobs))


def models(names: Sequence[str], store: Path | None, *, long: bool) -> Iterator[Job]:
    """Time the models of scenes in one measuring run and, with ``long``, the levels of the 3D reference.

    The times are kept in ``store`` if it is given. Raises InputError for a scene without a reference.
    """
    from rollbench.compare.models.study import Study
    from rollbench.compare.reference.store import shipped_store
    from rollbench.compare.sections.reference_time import compared_scenes, measured_now, measuring_run, time_points
    from rollbench.compare.studies.run_times import save_times

    study = Study(None if store is None else (store, shipped_store()))
    known = compared_scenes(study)
    for name in names:
        if name not in known:
            raise ArgumentError("names", name, ", ".join(known), "name scenes that have a 3D reference")
    wanted = names or (tuple(known) if long else (FIRST,))
    kept = measured_now(study, wanted, on_terminal, levels=long)
    if store is not None:
        save_times(store, kept)
    study.computed[measuring_run, on_terminal] = kept
    for name in wanted:
        yield from jobs_of(name, time_points(name, known[name], study, on_terminal))


def jobs_of(scene: str, points: Sequence[TimePoint]) -> Iterator[Job]:
    """Yield the measured times of a scene."""
    from rollbench.compare.studies.run_times import Job

    for p in points:
        if p.cold is not None:
            warm = "" if p.warm is None else f"; a further solve {p.warm:.3g} s"
            note = f"new process, empty caches{warm}; RMS error {p.rms:.2f} %"
            yield Job(f"{scene}: {p.label}", p.cold, None, p.unknowns, p.memory, p.error, note)


def _tables(jobs: Sequence[Job]) -> Iterator[object]:
    forms = {"seconds": ".3g", "error_percent": ".2f", "ratio": ".3g", "unknowns": "d", "peak_MB": ".0f"}
    rows = ([job.job, *(cell(getattr(job, name), form) for name, form in forms.items()), job.note] for job in jobs)
    headings = ("job", "seconds", "error %", "ratio", "unknowns", "peak MB", "what is included")
    yield ruled("bench", headings, rows, ("job", "what is included"))
