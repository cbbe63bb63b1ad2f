"""Write the validation report (`rollbench.report`): compute missing 3D runs, make the sections and write the pages."""

from __future__ import annotations

import datetime
import platform
from collections.abc import Callable, Sequence
from functools import partial
from importlib import import_module
from itertools import chain
from pathlib import Path
from time import perf_counter
from typing import Any

from rollbench.compare import __version__
from rollbench.compare.api.calls import LOG
from rollbench.compare.case import ReportPart, all_cases, modules_for_all_scenes
from rollbench.compare.errors import ArgumentError
from rollbench.compare.evidence import computations_with_function, evidence_of_table
from rollbench.compare.files import check_writable
from rollbench.compare.models.stored_study import Recomputed, StoredStudies, Study
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.provenance import hashes_of_report_inputs, source_commit
from rollbench.compare.reference.jobs import ComputingSettings
from rollbench.compare.reference.parallel import run_jobs
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.report import pages as report_pages
from rollbench.compare.report.changes import read_report_tables, report_differences
from rollbench.compare.report.runs import compute_missing_3d_runs
from rollbench.compare.report.scene_page import raise_folder_errors_as_input_errors
from rollbench.compare.results.base import JSON
from rollbench.compare.results.data import Written
from rollbench.compare.running import (
    check_packages,
    gmsh_fault,
    machine_description,
    package_versions,
    show_progress_message,
    usable_cores,
)
from rollbench.compare.scenes import catalogue
from rollbench.compare.text.printing import CommandOutput
from rollbench.meshes import cache
from rollbench.meshes.libraries import PAGES
from rollbench.meshes.processes import limited_to_one_thread
from rollbench.reports.content import Report, Section

Step = Callable[[str], None]

#: Text of the first page while stored results are computed again.
PENDING = "stored results are being computed again; what this says is added when the command ends"


def report_origin_facts() -> dict[str, str]:
    """Return what the report states about its origin, by label: versions, date, machine, and publications compared."""
    packages = ("numpy", "scipy", "gmsh", "scikit-fem", "pymetis", "matplotlib", "pyvista")
    return {
        "rollbench": f"{__version__}, commit {source_commit()}",
        "date": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M UTC"),
        "machine": f"{machine_description()}, {platform.system()}",
        "Python": platform.python_version(),
        "libraries": package_versions(packages),
        "source": "Lin (2019), doctoral thesis: chapters 2 and 3, appendices B to G, section 4.3; "
        "Smith (1994), thesis; Liu et al. (2025), Lubricants 13, 57",
    }


class ReportProgressPrinter:
    """Printer of progress lines while a report is made: number and name of each section, its steps, the elapsed time."""

    def __init__(self, section_count: int, say: Step) -> None:
        """Start the clock and the count of sections.

        ``section_count``: number of sections to be made. ``say``: function that prints a line.
        """
        self.total, self.count, self.say = section_count, 0, say
        self.start = perf_counter()

    def begin_section(self, name: str) -> None:
        """Print the number and ``name`` of the section that is made next, and the elapsed time."""
        self.count += 1
        self.say(f"[{self.count}/{self.total}] {name} ({perf_counter() - self.start:.1f} s)")

    def print_step(self, text: str) -> None:
        """Print an indented line on a step of the section that is being made."""
        self.say(f"      {text}")


def select_report_parts(only: Sequence[str], *, quick: bool = False) -> list[ReportPart]:
    """Return the parts of the report that are to be made: those named in ``only`` or, without names, all of them.

    ``quick``: whether, without names, only the parts of a quick report are returned. Raises InputError for an unknown name.
    """
    for name in only:
        if name not in (names := [part.name for part in report_pages.SECTIONS]):
            raise ArgumentError("only", f'"{name}"', ", ".join(names), "choose names of sections from this list")
    return [part for part in report_pages.SECTIONS if (part.name in only if only else part.in_quick_report or not quick)]


def report_parts_of_publication(case_name: str) -> list[ReportPart]:
    """Return the parts of the report that make up its page on one publication.

    ``case_name``: short name of the publication, such as "lin". Raises InputError if it has no page.
    """
    with_page = [case.name for case in all_cases() if case.report_parts]
    if case_name not in with_page:
        raise ArgumentError("source", f'"{case_name}"', ", ".join(with_page), "choose a publication that has a page")
    return [part for part in report_pages.SECTIONS if part.page_name == case_name]


def save_model_errors(cache: SceneResultCache) -> None:
    """Store the models' errors against the 3D reference, from which ``rollbench solve`` estimates its expected errors.

    ``cache``: cache with the errors and the folders of stored runs. The errors are written to the first of these folders.
    """
    from rollbench.compare.models.applicability import save_descriptors_of_built_in_scenes
    from rollbench.compare.models.model_form import save_model_errors
    from rollbench.compare.models.modelling import model_errors_on_built_in_scenes, solve_refinement_sequence_on_all_scenes

    rungs = cache.compute_once(solve_refinement_sequence_on_all_scenes)
    if rungs and cache.reference_folders:
        save_model_errors(cache.reference_folders[0], model_errors_on_built_in_scenes(cache, rungs))
        save_descriptors_of_built_in_scenes(cache.reference_folders[0])


def study_of_part(part: ReportPart, step: Step) -> Study:
    """Return how the sections of one part of the report are made; ``step`` is called with each line of progress."""
    modules = (part.maker_module, *modules_for_all_scenes(), *chain.from_iterable(case.modules for case in part.cases))
    make = partial(_make_sections_of_part, part, step)
    return Study(f"section-{part.name}", modules, make, part.shows_run_times)


def sections_of_part(part: ReportPart, step: Step, cache: SceneResultCache) -> tuple[Section, ...]:
    """Return the sections of one part of the report: stored ones, or else made and stored.

    The parts `pages.SUMMARIES` are made each time. ``step`` is called with each line of progress.
    """
    if cache.stored_studies is None or part.name in report_pages.SUMMARIES:
        return _make_sections_of_part(part, step, cache)
    sections: tuple[Section, ...] = cache.stored_studies.value(cache, study_of_part(part, step))
    return sections


def _make_sections_of_part(part: ReportPart, step: Step, cache: SceneResultCache) -> tuple[Section, ...]:
    """Make the sections of one part of the report.

    ``part``: the part, which names the module that makes it. ``step`` is called with each line of progress. After the part
    "ladder" (load errors of the low-order models against the 3D reference), the errors of the models are also stored.
    """
    module, function = import_module(part.maker_module), part.maker.partition(":")[2]
    # "section": cases of other packages before 0.15
    usual = "make_section" if hasattr(module, "make_section") else "section"
    made = getattr(module, function or usual)(cache, step)
    if part.name == "ladder":
        save_model_errors(cache)
    return (made,) if isinstance(made, Section) else tuple(made)


def make_parts(
    parts: Sequence[ReportPart], tables: Sequence[str], study: SceneResultCache, say: Step, *, keeping: bool
) -> tuple[dict[str, tuple[Section, ...]], SceneResultCache]:
    """Make parts of the report and compute the values of printed tables, in a process of its own.

    Parameters
    ----------
    parts
        Parts of the report.
    tables
        Names of printed tables.
    study
        Cache with which they are made.
    say
        Called with each line of progress.
    keeping
        Whether compliances of bodies are stored on disk, as on the command line.

    Returns
    -------
    tuple
        Sections of each part by its name, and a cache with the scenes and the values of printed tables that they used.
    """
    if keeping:
        cache.switch_on_geometry_cache()
    progress, made = ReportProgressPrinter(len(parts), say), {}
    for part in parts:
        progress.begin_section(part.name)
        made[part.name] = sections_of_part(part, progress.print_step, study)
    for name in tables:
        study.compute_once(evidence_of_table, name)
    values = {key: value for key, value in study.computed_values.items() if key[0] is evidence_of_table}
    scenes = {key: study.scenes_of_values[key] for key in values}
    return made, SceneResultCache(used_scene_names=study.used_scene_names, computed_values=values, scenes_of_values=scenes)


#: Stored studies that do not agree when computed again: cases contains measured seconds of a solution, rolling
#: directions of a slip that is round-off.
NOT_COMPARED = ("section-cases", "section-rolling")
#: Least number of stored studies that a report computes again: those that its date draws, then the quickest ones.
LEAST = 20
#: Number of parts in which these are distributed over processes.
PARTS = 4


def recompute_studies(names: Sequence[str], study: SceneResultCache, *, keeping: bool) -> list[Recomputed]:
    """Compute stored studies again, in a process of its own, and return how far they agree.

    ``names``: names of the studies; ``study``, ``keeping``: as for `make_parts`.
    """
    studies = study.stored_studies
    if studies is None:
        return []
    if keeping:
        cache.switch_on_geometry_cache()
    studies.compared = names

    def quiet(text: str) -> None:
        """Show no progress."""

    every = [study_of_part(part, quiet) for part in report_pages.SECTIONS]
    every.append(study_of_3d_runs(ComputingSettings(), quiet, fresh=False))
    for one in (*every, *(computation.study for computation in computations_with_function().values())):
        if one.name in names:
            studies.value(study, one)
    return studies.recomputed


def make_sections(
    parts: Sequence[ReportPart], show_part_name: Step, step: Step, study: SceneResultCache, *, process_count: int = 1
) -> dict[str, tuple[Section, ...]]:
    """Make the sections of the report's parts; return those of each part, by its name.

    Those that are not stored are made in one process or in two, of which one makes the pages named in
    `pages.FIRST_PROCESS`. Parts that summarise the results of all others are made last.

    Parameters
    ----------
    parts
        Parts of the report to make.
    show_part_name
        Called with the name of each part: before it is made, or when its process has finished.
    step
        Called with each message on progress, also of the other processes.
    study
        Cache of scenes and solutions; scenes and computed values used in other processes are added to it.
    process_count
        Number of processes; values above 2 count as 2.
    """
    sections: dict[str, tuple[Section, ...]] = {}
    studies, last = study.stored_studies, [part for part in parts if part.name in report_pages.GATHERING]
    missing = [part for part in parts if part not in last]
    tables = list(computations_with_function().values()) if last else []
    if studies is not None:
        missing = [part for part in missing if studies.stored(study_of_part(part, step)) is None]
        tables = [one for one in tables if studies.stored(one.study) is None]
    if process_count > 1 and missing:
        jobs = []
        for first in (True, False):
            half = [part for part in missing if (part.page_name in report_pages.FIRST_PROCESS) == first]
            names = [one.table for one in tables if (one.case.name in report_pages.FIRST_PROCESS) == first]
            jobs.append((partial(make_parts, keeping=cache.is_geometry_cache_on()), (half, names, study, step)))
        for _, (made, used) in run_jobs(jobs, workers=2):
            sections |= made
            study.record_used_scenes(used.used_scene_names)
            study.computed_values |= used.computed_values
            study.scenes_of_values |= used.scenes_of_values
    for part in parts:
        show_part_name(part.name)
        if part.name not in sections:
            sections[part.name] = sections_of_part(part, step, study)
    return sections


def write_validation_report(
    only: Sequence[str],
    out: Path,
    *,
    quick: bool = False,
    stored: bool = False,
    store: Path = Path("rollbench-reference"),
    engine: ComputingSettings | None = None,
    fresh: bool = False,
    against: Path | None = None,
    source: str = "",
    say: Step = show_progress_message,
) -> CommandOutput:
    """Write the validation report: compute missing 3D runs, make all sections, and write the pages.

    One shipped run of the 3D reference is recomputed as a check. Run times of models and meshes are stored ones; with
    ``fresh`` they are measured anew.

    Parameters
    ----------
    only
        Names of the sections to make; empty: all.
    out
        Folder of the report.
    quick
        Whether the report is reduced to the coarsest meshes of two scenes and the sections that need no more.
    stored
        Whether only shipped runs of the 3D reference are used.
    store
        Folder in which computed runs are stored, so that an interrupted report can be continued.
    engine
        Settings for computing runs of the 3D reference; None: the default.
    fresh
        Whether stored runs are computed again.
    against
        Folder of an earlier report, of which changed table cells are listed.
    source
        Publication, such as "lin", whose page alone is written, from stored runs.
    say
        Called with each line of progress.

    Returns
    -------
    CommandOutput
        Lines for the terminal, and the exit code: 1 if a recomputed run or study differs from the stored one.

    Raises
    ------
    InputError
        For an unknown section or a folder that cannot be used.
    """
    check_packages(*PAGES, "scikit-fem")
    before = None if against is None else read_report_tables(against)
    for name, value in {"only": only, "quick": quick, "fresh": fresh}.items():
        if source and value:
            raise ArgumentError(name, str(value), "only without `source`", "leave one of the two arguments out")
    wanted, stored = (
        (report_parts_of_publication(source), True) if source else (select_report_parts(only, quick=quick), stored)
    )
    if fresh and stored:
        advice = "leave `stored` out to compute 3D runs anew"
        raise ArgumentError("fresh", "both fresh and stored", "only one of the two", advice)
    from rollbench.reports.pages import replace_in_first_page, write_report

    with raise_folder_errors_as_input_errors(out):
        check_writable(out / "index.html")
    wanted, missed = report_pages.split_into_made_and_omitted_parts(wanted)
    meshing = not gmsh_fault()
    stores = (store,) if fresh or quick else (store, shipped_store())
    facts = report_origin_facts()  # before anything is written
    engine = engine or ComputingSettings()
    runs = any(part.shows_3d_runs for part in wanted) and meshing and not stored
    searched = () if fresh else (shipped_store(),) if stored else stores
    studies = None if quick else StoredStudies(searched, None if fresh or stored else store)
    study = SceneResultCache(None if stored else stores, None, quick, fresh, engine.cache_folder, studies)
    checking = not (only or source or quick or fresh)
    progress = ReportProgressPrinter(len(wanted) + runs + 1 + checking, say)
    start = perf_counter()
    if runs:
        progress.begin_section("runs of the 3D reference")
        ensure_3d_runs(study, engine, progress.print_step, fresh=fresh)
    workers = min(engine.parallel_jobs or 1, usable_cores()) if engine.backend == "joblib" else 1
    sections = make_sections(wanted, progress.begin_section, progress.print_step, study, process_count=workers)
    progress.begin_section("drawing and writing")
    facts["computed in"] = f"{perf_counter() - start:.0f} s"
    texts = {name: catalogue.shipped_scene_text(name) for name in study.used_scenes}
    shipped = "shipped runs where they belong to the same inputs, else computed"
    computed = "computed, coarse meshes only" if quick else "computed" if fresh else shipped
    facts["3D reference"] = "shipped runs" if stored or not meshing else computed
    missed += report_pages.omitted_picture_entries(section for several in sections.values() for section in several)
    if missed:
        facts["left out"] = "; ".join(missed)
    if checking:
        facts["checks"] = PENDING
    slow = (part.name for part in report_pages.SECTIONS if not part.in_quick_report)
    without = "" if only or source else f", without {', '.join(slow)}"
    report = Report(
        title="rollbench validation report",
        subtitle="Low-order models of ball screws and bearings against printed numbers and a 3D contact reference"
        + (f" (quick report: coarse meshes, Lin's cases 1 and 2 only{without})" if quick else "")
        + "".join(f" (left out: {gap})" for gap in missed),
        provenance=facts,
        pages=report_pages.arrange_sections_on_pages(sections),
        origin={**facts, "inputs": hashes_of_report_inputs(study.reference_folders or (shipped_store(),), texts)},
    )
    with raise_folder_errors_as_input_errors(out):
        page = write_report(report, out, progress.print_step, workers)
    agree, checks = True, list[str]()
    if checking:
        say(f"report: {page} ({perf_counter() - start:.0f} s)")
        progress.begin_section("stored results computed again")
        agree, checks = check_stored_results(study, workers, progress.print_step, with_3d_run=runs)
        replace_in_first_page(page, PENDING, "; ".join(checks), {**report.origin, "checks": "; ".join(checks)})
    parts = [*checks, *(f"left out: {gap}" for gap in missed)]
    if before is not None:
        parts += [*report_differences(before, read_report_tables(page.parent))] or ["no table cell changed"]
    parts.append(f"report: {page} ({perf_counter() - start:.0f} s)")
    return CommandOutput(texts_and_tables=parts, exit_code=0 if agree else 1)


def ensure_3d_runs(study: SceneResultCache, engine: ComputingSettings, step: Step, *, fresh: bool) -> None:
    """Compute the missing runs of the 3D reference, unless a stored study says that none is missing.

    ``study``, ``engine``, ``step``, ``fresh``: as for `runs.compute_missing_3d_runs`.
    """
    if study.stored_studies is None:
        compute_missing_3d_runs(study, engine, step, fresh=fresh)
    else:
        study.stored_studies.value(study, study_of_3d_runs(engine, step, fresh=fresh))
        study.stored_studies.read_runs()


def study_of_3d_runs(engine: ComputingSettings, step: Step, *, fresh: bool) -> Study:
    """Return how the missing runs of the 3D reference are computed; arguments as for `runs.compute_missing_3d_runs`."""
    modules = (compute_missing_3d_runs.__module__, *modules_for_all_scenes())
    return Study("runs", modules, partial(compute_missing_3d_runs, engine=engine, step=step, fresh=fresh))


def check_stored_results(
    study: SceneResultCache, process_count: int, step: Step, *, with_3d_run: bool
) -> tuple[bool, list[str]]:
    """Compute stored studies that the date draws again, and a shipped run of the 3D reference, in several processes.

    Parameters
    ----------
    study
        Cache of the report.
    process_count
        Number of processes.
    step
        Called with each line of progress.
    with_3d_run
        Whether a 3D run is computed again.

    Returns
    -------
    tuple
        Whether all agree, and a sentence on each kind.
    """
    studies, jobs = study.stored_studies, list[Any]()
    if studies is not None:
        drawn = studies.drawn(datetime.datetime.now(datetime.UTC).date().isoformat())
        names = [name for name in drawn if name not in NOT_COMPARED]
        quickest = sorted(studies.found.keys() - {*names, *NOT_COMPARED}, key=lambda name: studies.found[name])
        names += quickest[: max(0, LEAST - len(names))]
        again = partial(recompute_studies, keeping=cache.is_geometry_cache_on())
        longest_first = sorted(names, key=lambda name: -studies.found.get(name, 0.0))
        parts = [longest_first[k::PARTS] for k in range(PARTS if process_count > 1 else 1)]
        jobs += [(again, (part, study.without_values())) for part in parts if part]
    if with_3d_run:
        jobs.insert(0, (report_pages.recompute_shipped_run, ((shipped_store(),), step)))
    agree, texts, recomputed = True, list[str](), dict[str, Recomputed]()
    for _, found in run_jobs(jobs, workers=max(1, min(process_count, len(jobs)))):
        if isinstance(found, list):
            recomputed |= {one.name: one for one in found}
        elif found is not None:
            agree, texts = found.agrees_with_shipped_run, [f"live check: {found}"]
    if studies is not None:
        studies.recomputed[:] = [recomputed[name] for name in sorted(recomputed)]
        agree, texts = agree and studies.agree, [*texts, f"stored studies: {studies}"]
    return agree, texts


def refuse_unusable_scene_arguments(names: Sequence[str], **given: Any) -> None:
    """Raise InputError if ``names`` is empty, or if an argument that needs a single scene is given for several.

    ``names``: names or files of the scenes. ``given``: values of such arguments by their names; None: not given.
    """
    if not names:
        allowed, advice = "at least one name or file of a scene", "name a scene"
        raise ArgumentError("scene", "an empty list", allowed, advice)
    for name, value in given.items():
        if value is not None and len(names) > 1:
            raise ArgumentError(name, str(value), "only with a single scene", "write the page of each scene separately")


@limited_to_one_thread()
def report(
    scene: str | Path | Sequence[str | Path] | None = None,
    *,
    only: Sequence[str] = (),
    out: str | Path = "rollbench-report",
    store: str | Path = "rollbench-reference",
    reference: str | Path | None = None,
    quick: bool = False,
    stored: bool = False,
    fresh: bool = False,
    source: str = "",
) -> Written:
    """Write the validation report of rollbench, or a page with results and errors of each named scene, as HTML.

    Parameters
    ----------
    scene
        Name or file of a scene, or several: a page for each, and a table of all. None: the validation report.
    only
        Names of the sections of the validation report; empty: all.
    out
        Folder in which the pages are written.
    store
        Folder in which computed runs of the 3D reference are stored and looked up, besides the shipped runs.
    reference
        CSV file with contact loads that replaces the 3D reference of a scene.
    quick
        Whether the report is reduced to coarse meshes of two scenes and the sections that need no more.
    stored
        Whether only stored runs of the 3D reference are used.
    fresh
        Whether all runs of the 3D reference are computed again.
    source
        Name of a publication, such as ``"lin"``, whose page alone is written, from stored runs.

    Returns
    -------
    Written
        First page of the report, and whether the recomputed run agrees with the stored one.

    Raises
    ------
    rollbench.InputError
        If an argument cannot be used. If the models cannot describe a scene, the subclass SceneNotCoveredError.
    """
    folder = Path(out)
    choices = {"only": only, "quick": quick, "stored": stored, "fresh": fresh, "source": source}
    given = [name for name, value in choices.items() if value]
    if scene is not None and given:
        value = f"both {given[0]} and a scene"
        raise ArgumentError(given[0], value, "only without a scene", "leave out the scene or the argument")
    index = folder / "index.html"
    if scene is not None:
        from rollbench.compare.report.several import write_scene_pages

        names = [str(scene)] if isinstance(scene, str | Path) else [str(one) for one in scene]
        refuse_unusable_scene_arguments(names, reference=reference)
        pages = write_scene_pages(names, folder, Path(store), None if reference is None else Path(reference))
        warned = tuple(f"WARNING: {warning}" for page in pages for warning in page.warnings)
        verdict = "\n".join(page.verdict for page in pages)
        data: dict[str, JSON] = {"page": str(index), "passed": True, "verdict": verdict}
        return Written(data, (*warned, *verdict.split("\n")), page=index, passed=True, verdict=verdict)
    if reference is not None:
        advice = "name the scene to which the reference belongs"
        raise ArgumentError("reference", str(reference), "only with a scene", advice)

    how: dict[str, Any] = {"quick": quick, "stored": stored, "fresh": fresh, "source": source}
    answer = write_validation_report(only, folder, store=Path(store), say=LOG.info, **how)
    passed = answer.exit_code == 0
    return Written(
        {"page": str(index), "passed": passed}, tuple(map(str, answer.texts_and_tables)), page=index, passed=passed
    )
