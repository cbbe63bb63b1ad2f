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
from rollbench.compare.case import ReportPart, all_cases
from rollbench.compare.errors import ArgumentError
from rollbench.compare.evidence import computations_with_function, evidence
from rollbench.compare.files import check_writable
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.provenance import hashes_of_report_inputs, source_commit
from rollbench.compare.reference.jobs import ComputingSettings
from rollbench.compare.reference.parallel import run_jobs
from rollbench.compare.report import pages as report_pages
from rollbench.compare.report.changes import read_report_tables, report_differences
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


def compute_missing_3d_runs(cache: SceneResultCache, engine: ComputingSettings, step: Step, *, fresh: bool = False) -> None:
    """Compute those runs of the 3D reference that the report needs and that are not stored yet.

    The runs are written to the first folder of stored runs; without such a folder, nothing is done. ``engine``: settings of
    the computation. ``step`` is called with each line of progress. ``fresh``: whether stored runs are computed anew.
    """
    from rollbench.compare.models.comparison import REFERENCED
    from rollbench.compare.models.modelling import REFINED, VARIED
    from rollbench.compare.reference.jobs import (
        ensure_runs_are_stored,
        expected_time_and_memory,
        modelling_variant_names,
        plan_reference_tasks,
        refinement_variant_names,
    )
    from rollbench.compare.reference.levels import LEVELS, STUDIED

    if cache.reference_folders is None:
        return
    from rollbench.compare.models.modelling import DEEP, UNSEEN
    from rollbench.compare.studies.crosscheck.study import scenes_and_levels_for_report as checked_references

    scenes = [cache.built_in_scene(name) for name in REFERENCED]
    if cache.quick:
        tasks = plan_reference_tasks(scenes[:2], (min(LEVELS),))
    else:
        tasks = plan_reference_tasks(scenes, STUDIED, with_source_mesh=True, leave_out_each_part=True)
        for name in VARIED:
            variants = (*modelling_variant_names(), *(refinement_variant_names() if name == REFINED else ()))
            tasks += plan_reference_tasks([cache.built_in_scene(name)], (), variants)
        tasks += plan_reference_tasks([cache.built_in_scene(name) for name in UNSEEN], STUDIED)
        of_cases = (case.import_object(case.references) for case in all_cases() if case.references)
        for names, levels in chain.from_iterable(of(fresh) for of in (checked_references, *of_cases)):
            tasks += plan_reference_tasks([cache.built_in_scene(name) for name in names], levels)
        tasks += plan_reference_tasks([cache.built_in_scene(name) for name in DEEP], (max(LEVELS),))
        tasks.sort(key=lambda task: -expected_time_and_memory(task).seconds)
    ensure_runs_are_stored(
        tasks, cache.reference_folders[0], engine, step, cache.reference_folders[1:], compute_again=fresh
    )
    if not cache.quick:
        save_uncertainty_parameters(cache.reference_folders)


def save_uncertainty_parameters(stores: Sequence[Path]) -> None:
    """Store the two contributions to the uncertainty of the 3D reference that are estimated from all compared scenes.

    One is the part of the mesh uncertainty that the mesh levels of a single scene do not show; the other is due to
    modelling choices. ``stores``: folders of 3D runs, to the first of which both are written.
    """
    from rollbench.compare.models import uncertainty
    from rollbench.compare.models.modelling import VARIED, combined_modelling_uncertainty, effects_of_changed_choices
    from rollbench.compare.models.study import SceneResultCache
    from rollbench.compare.reference import estimate
    from rollbench.compare.sections.u_val import mesh_uncertainty_parameters

    study = SceneResultCache(stores)
    known = mesh_uncertainty_parameters(study)
    if known is not None:
        estimate.save_uncertainty_of_other_scenes(stores[0], known)
    scenes = [study.built_in_scene(name) for name in VARIED]
    modelling = [combined_modelling_uncertainty(scene, effects_of_changed_choices(scene, stores)) for scene in scenes]
    if all(modelling):
        effects = {m.scene: uncertainty.largest_choice_effects(m) for m in modelling if m is not None}
        uncertainty.save_choice_effects(stores[0], effects)


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


def _make_sections_of_part(part: ReportPart, step: Step, cache: SceneResultCache) -> Sequence[Section]:
    """Make the sections of one part of the report.

    ``part``: the part, which names the module that makes it. ``step`` is called with each line of progress. After the part
    "ladder" (load errors of the low-order models against the 3D reference), the errors of the models are also stored.
    """
    path, _, function = part.maker.partition(":")
    module = import_module(f"{part.package}.{path}")
    # "section": cases of other packages before 0.15
    usual = "make_section" if hasattr(module, "make_section") else "section"
    made = getattr(module, function or usual)(cache, step)
    if part.name == "ladder":
        save_model_errors(cache)
    return (made,) if isinstance(made, Section) else tuple(made)


def _make_parts_in_worker(
    parts: Sequence[ReportPart], tables: Sequence[str], study_arguments: tuple[Any, ...], print_line: Step, *, keeping: bool
) -> tuple[dict[str, Sequence[Section]], SceneResultCache]:
    """Make parts of the report in a worker process.

    Parameters
    ----------
    parts
        Parts of the report to make.
    tables
        Names of files with numbers printed in publications; the values that rollbench computes for these numbers are added
        to the returned cache.
    study_arguments
        Arguments with which the process makes its `SceneResultCache`.
    print_line
        Called with each line of progress.
    keeping
        Whether compliances of bodies are stored on disk, as on the command line.

    Returns
    -------
    dict, SceneResultCache
        Sections of each part by its name, and a cache with the scenes and computed values that these sections used.
    """
    if keeping:
        cache.switch_on_geometry_cache()
    study, progress, made = SceneResultCache(*study_arguments), ReportProgressPrinter(len(parts), print_line), {}
    for part in parts:
        progress.begin_section(part.name)
        made[part.name] = _make_sections_of_part(part, progress.print_step, study)
    if tables:
        evidence(study, *tables)
    return made, SceneResultCache(
        scenes=study.scenes, other_scenes=study.other_scenes, evidence_by_table=study.evidence_by_table
    )


def make_sections(
    parts: Sequence[ReportPart],
    show_part_name: Step,
    step: Step,
    study: SceneResultCache,
    *,
    process_count: int = 1,
    show_worker_progress: Step = show_progress_message,
) -> dict[str, Sequence[Section]]:
    """Make the sections of the report's parts, in one process or in two.

    Of two processes, one makes the pages named in `pages.FIRST_PROCESS` and the other makes the rest. Parts that summarise
    the results of all others are made last.

    Parameters
    ----------
    parts
        Parts of the report to make.
    show_part_name
        Called with the name of each part: before it is made, or when its process has finished.
    step
        Called with each message on progress within a part.
    study
        Cache of scenes and solutions; scenes and computed values used in other processes are added to it.
    process_count
        Number of processes; values above 2 count as 2.
    show_worker_progress
        Called with each line of progress of the other processes.

    Returns
    -------
    dict[str, Sequence[Section]]
        Sections of each part of the report, by the part's name.
    """
    sections: dict[str, Sequence[Section]] = {}
    if process_count > 1:
        last = [part for part in parts if part.name in report_pages.GATHERING]
        gathered = [(name, one.case.name) for name, one in computations_with_function().items()] if last else []
        given = (study.reference_folders, None, study.quick, study.measures_run_times, study.mesh_cache)
        make, jobs = partial(_make_parts_in_worker, keeping=cache.is_geometry_cache_on()), []
        for first in (True, False):
            half = [part for part in parts if part not in last and (part.page_name in report_pages.FIRST_PROCESS) == first]
            tables = [name for name, case in gathered if (case in report_pages.FIRST_PROCESS) == first]
            if half or tables:
                jobs.append((make, (half, tables, given, show_worker_progress)))
        for _, (made, used) in run_jobs(jobs, workers=2):
            for name in made:
                show_part_name(name)
            sections |= made
            study.scenes |= used.scenes
            study.other_scenes |= used.other_scenes
            study.evidence_by_table |= used.evidence_by_table
        parts = last
    for part in parts:
        show_part_name(part.name)
        sections[part.name] = _make_sections_of_part(part, step, study)
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
    everything: bool = False,
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
    everything
        Whether sections that take long are made too.
    against
        Folder of an earlier report, of which changed table cells are listed.
    source
        Publication, such as "lin", whose page alone is written, from stored runs.
    say
        Called with each line of progress.

    Returns
    -------
    CommandOutput
        Lines for the terminal, and the exit code: 1 if the recomputed run differs from the shipped one.

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
    from rollbench.reports.pages import write_report

    with raise_folder_errors_as_input_errors(out):
        check_writable(out / "index.html")
    wanted, missed = report_pages.split_into_made_and_omitted_parts(
        wanted, named_by_user=bool(only), with_costly_parts=everything or fresh
    )
    meshing = not gmsh_fault()
    from rollbench.compare.reference.store import shipped_store

    stores = (store,) if fresh or quick else (store, shipped_store())
    facts = report_origin_facts()  # before anything is written
    engine = engine or ComputingSettings()
    runs = any(part.shows_3d_runs for part in wanted)
    checking = runs and meshing and not (only or stored or fresh or quick)
    study = SceneResultCache(
        None if stored else stores, quick=quick, measures_run_times=fresh, mesh_cache=engine.cache_folder
    )
    progress = ReportProgressPrinter(len(wanted) + runs + checking + 1, say)
    start = perf_counter()
    if runs:
        progress.begin_section("runs of the 3D reference")
        if meshing:
            compute_missing_3d_runs(study, engine, progress.print_step, fresh=fresh)
    checked = None
    if checking:
        progress.begin_section("one shipped run recomputed")
        checked = report_pages.recompute_shipped_run((shipped_store(),), progress.print_step)
    workers = min(engine.parallel_jobs or 1, usable_cores()) if engine.backend == "joblib" else 1
    sections = make_sections(
        wanted, progress.begin_section, progress.print_step, study, process_count=workers, show_worker_progress=say
    )
    progress.begin_section("drawing and writing")
    texts = {name: catalogue.shipped_scene_text(name) for name in study.used_scenes}
    facts["computed in"] = f"{perf_counter() - start:.0f} s"
    shipped = "shipped runs where they belong to the same inputs, else computed"
    computed = "computed, coarse meshes only" if quick else "computed" if fresh else shipped
    facts["3D reference"] = "shipped runs" if stored or not meshing else computed
    missed += report_pages.omitted_picture_entries(section for several in sections.values() for section in several)
    if missed:
        facts["left out"] = "; ".join(str(gap) for gap in missed)
    if checked is not None:
        facts["live check"] = str(checked)
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
        page = write_report(report, out, progress.print_step)
    parts = [*([] if checked is None else [f"live check: {checked}"]), *(f"left out: {gap}" for gap in missed)]
    if before is not None:
        parts += [*report_differences(before, read_report_tables(page.parent))] or ["no table cell changed"]
    parts.append(f"report: {page} ({perf_counter() - start:.0f} s)")
    return CommandOutput(texts_and_tables=parts, exit_code=0 if checked is None or checked.agrees_with_shipped_run else 1)


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
    everything: bool = False,
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
    everything
        Whether sections that take long are made too (``--all``).
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
    choices = {"only": only, "quick": quick, "stored": stored, "fresh": fresh, "everything": everything, "source": source}
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

    how: dict[str, Any] = {"quick": quick, "stored": stored, "fresh": fresh, "everything": everything, "source": source}
    answer = write_validation_report(only, folder, store=Path(store), say=LOG.info, **how)
    passed = answer.exit_code == 0
    return Written(
        {"page": str(index), "passed": passed}, tuple(map(str, answer.texts_and_tables)), page=index, passed=passed
    )
