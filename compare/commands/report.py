"""Regenerates the validation report: runs the models, fills the records, writes the page."""

from __future__ import annotations

import datetime
import os
import platform
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from importlib import metadata
from pathlib import Path
from time import perf_counter

from compare import __version__
from compare.errors import InputError
from compare.models.study import Study
from compare.printed.findings import Finding
from compare.reference.jobs import Engine
from compare.scenes import catalogue
from compare.scenes.scene_file import scene_hash
from compare.system import need_gmsh
from reports.records import Report, Section

Step = Callable[[str], None]
#: Sections that a quick report leaves out.
LONG = ("pictures", "stability", "timing")
#: Sections by name, in order.
SECTIONS = (
    "overview",
    "ladder",
    "reference",
    "reference-mesh",
    "crosscheck",
    "pictures",
    "hertz",
    "cases",
    "errors",
    "manufacturing",
    "friction",
    "friction-screw",
    "formulations",
    "verification",
    "stability",
    "timing",
    "notes",
)
#: Sections that show runs of the 3D reference.
WITH_RUNS = ("overview", "ladder", "reference", "reference-mesh", "crosscheck", "notes")


def provenance() -> dict[str, str]:
    """What was run where: version, date, machine, library versions."""
    cpu = platform.processor() or platform.machine()
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        cpu = next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), cpu)
    except OSError:
        pass
    packages = ("numpy", "scipy", "numba", "gmsh", "scikit-fem", "cvxopt", "matplotlib", "pyvista")
    return {
        "rollbench": __version__,
        "date": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M UTC"),
        "machine": f"{cpu}, {os.cpu_count()} cores, {platform.system()}",
        "Python": platform.python_version(),
        "libraries": ", ".join(f"{name} {metadata.version(name)}" for name in packages),
        "source": "Lin (2019), doctoral thesis: chapters 2 and 3, appendices B to G, section 4.3",
    }


class Progress:
    """Lines on the terminal: which section, which step, how long it took."""

    def __init__(self, total: int) -> None:
        """Start counting sections out of ``total``."""
        self.total, self.count = total, 0
        self.start = perf_counter()

    def section(self, name: str) -> None:
        """Announce a section."""
        self.count += 1
        print(f"[{self.count}/{self.total}] {name} ({perf_counter() - self.start:.1f} s)", flush=True)

    def step(self, text: str) -> None:
        """Announce a step of the section."""
        print(f"      {text}", flush=True)


@dataclass(frozen=True)
class Source:
    """Where the runs of the 3D reference come from: folders, computed now or stored, coarse meshes only, anew even where
    the folder holds them."""

    stores: tuple[Path, ...] | None
    engine: Engine
    compute: bool = True
    quick: bool = False
    fresh: bool = False


def compute_references(study: Study, source: Source, step: Step) -> None:
    """Compute the runs that the report needs and ``source`` does not hold yet."""
    from compare.models.comparison import REFERENCED
    from compare.models.modelling import REFINED, VARIED
    from compare.reference.jobs import all_variants, ensure, plan, refinements
    from compare.reference.levels import LEVELS

    if not source.compute or source.stores is None:
        return
    from compare.crosscheck.study import STUDIES
    from compare.models.ladder import LARGE, UNSEEN
    from compare.reference import grid_order
    from compare.reference.runs import reference

    scenes = [study.scene(name) for name in REFERENCED]
    if source.quick:
        tasks = plan(scenes[:2], (min(LEVELS),))
    else:
        tasks = plan(scenes, tuple(LEVELS), source=True, ablate=True)
        for name in VARIED:
            tasks += plan([study.scene(name)], (), (*all_variants(), *(refinements() if name == REFINED else ())))
        tasks += plan([study.scene(name) for name in UNSEEN if name not in LARGE], tuple(LEVELS))
        tasks += plan([study.scene(name) for name in LARGE], (1, 2))
        tasks += plan([study.scene(name) for name in STUDIES], tuple(LEVELS))
        tasks.sort(key=lambda task: -task.weight)
    ensure(tasks, source.stores[0], source.engine, step, source.stores[1:], fresh=source.fresh)
    if not source.quick:
        known = [reference(study.scene(name), source.stores) for name in dict.fromkeys((*REFERENCED, *STUDIES, *UNSEEN))]
        order = grid_order.measured([ref for ref in known if ref is not None])
        if order is not None:
            grid_order.save(source.stores[0], order)


def _printed(study: Study, source: Source, step: Step) -> tuple[list[Finding], Section, Section]:
    """Findings of all tables, and the two sections that share the ensembles."""
    from compare.evidence import rotary_linear as friction_values
    from compare.evidence import screw as friction_screw_values
    from compare.sections import cases, errors, hertz, manufacturing, reference

    section, found = errors.section_with_findings(study, step)
    against = {f.printed.key: f for f in reference.findings(study, source.stores)}
    own = [against.get(f.printed.key, f) for f in cases.findings_241(study)]
    everything = [*hertz.findings(study), *own, *found, *manufacturing.findings(study), *friction_values.findings(study)]
    everything += friction_screw_values.findings(study)
    return everything, section, manufacturing.section(study, step)


def build(only: Sequence[str], progress: Progress, source: Source) -> tuple[list[Section], list[tuple[str, str]], Study]:
    """Sections asked for (all if none), headline figures, and the study they were made from."""
    from compare.evidence.source_cases import SCENES_3_2_3_3, SCENES_3_4_4_3
    from compare.sections import (
        cases,
        crosscheck,
        formulations,
        friction,
        friction_screw,
        hertz,
        ladder,
        notes,
        overview,
        pictures,
        reference,
        reference_mesh,
        stability,
        timing,
        verification,
    )

    study = Study()
    wanted = [name for name in SECTIONS if (name in only if only else not (source.quick and name in LONG))]
    made: dict[str, Section] = {}
    headline: list[tuple[str, str]] = []
    found: list[Finding] = []
    if any(name in wanted for name in WITH_RUNS):
        progress.section("runs of the 3D reference")
        compute_references(study, source, progress.step)
    if any(name in wanted for name in ("overview", "errors", "manufacturing", "notes")):
        progress.section("printed numbers and claims, geometric errors")
        found, made["errors"], made["manufacturing"] = _printed(study, source, progress.step)
        made["overview"] = overview.section(found)
        headline += overview.counts(found)
    simple: dict[str, Callable[[Study, Step], Section]] = {
        "hertz": hertz.section,
        "cases": cases.section,
        "formulations": formulations.section,
        "ladder": partial(ladder.section, stores=source.stores, keep=source.stores[0] if source.stores else None),
        "reference": partial(reference.section, stores=source.stores, quick=source.quick),
        "reference-mesh": partial(reference_mesh.section, stores=source.stores),
        "crosscheck": partial(crosscheck.section, stores=source.stores),
        "pictures": partial(pictures.section, cache=source.engine.cache),
        "friction": friction.section,
        "friction-screw": friction_screw.section,
    }
    for name in wanted:
        if name in simple:
            progress.section(name)
            made[name] = simple[name](study, progress.step)
        elif name == "verification":
            progress.section(name)
            wanted_levels = verification.QUICK if source.quick else verification.LEVELS
            made[name] = verification.section(progress.step, wanted_levels)
        elif name == "stability":
            progress.section(name)
            study.uses((*SCENES_3_2_3_3, *SCENES_3_4_4_3))
            made[name], line = stability.section(progress.step)
            headline.append(line)
        elif name == "timing":
            progress.section(name)
            study.uses((*SCENES_3_2_3_3, *SCENES_3_4_4_3))
            made[name], lines = timing.section(progress.step)
            headline += lines
    if "notes" in wanted:
        progress.section("notes")
        made["notes"] = notes.section(study, found, progress.step)
    return [made[name] for name in wanted], headline, study


def make_report(
    only: Sequence[str],
    out: Path,
    *,
    quick: bool = False,
    stored: bool = False,
    store: Path = Path("rollbench-reference"),
    engine: Engine | None = None,
    fresh: bool = False,
) -> int:
    """Run, draw and write the report; returns the exit code.

    quick: coarsest meshes of the 3D reference only; stored: the runs that come with the package; store: folder in which
    computed runs are kept, so that an interrupted report goes on; fresh: compute them even if it holds them.
    Raises InputError for a bad section name or folder.
    """
    unknown = [name for name in only if name not in SECTIONS]
    if unknown:
        raise InputError("command line", "--only", f'"{unknown[0]}"', ", ".join(SECTIONS), "name a section")
    if fresh and stored:
        raise InputError("command line", "--fresh", "also --stored", "one of both", "leave --stored out to compute")
    from reports.html import check_target, write

    try:
        check_target(out)
    except (ValueError, OSError) as error:
        raise _bad_folder(out, error) from None
    if any(not only or n in only for n in ("ladder", "reference", "crosscheck", "pictures", "verification")):
        need_gmsh()
    made = [n for n in SECTIONS if (n in only if only else not (quick and n in LONG))]
    total = len([n for n in made if n not in ("overview", "errors", "manufacturing")])
    total += 1 + any(not only or n in only for n in ("overview", "errors", "manufacturing", "notes"))
    total += any(not only or n in only for n in WITH_RUNS)
    from compare.reference.runs import shipped_store

    own = (store,) if fresh or quick else (store, shipped_store())
    source = Source(None if stored else own, engine or Engine(), not stored, quick, fresh)
    progress = Progress(total)
    start = perf_counter()
    sections, headline, study = build(only, progress, source)
    progress.section("drawing and writing")
    facts = provenance()
    facts["computed in"] = f"{perf_counter() - start:.0f} s"
    computed = "computed, coarse meshes only" if quick else "computed" if fresh else "of the package where their key holds"
    facts["3D reference"] = "stored runs of the package" if stored else computed
    report = Report(
        title="rollbench validation report",
        subtitle="Low-order models of ball screws and bearings against printed numbers and a 3D contact reference"
        + (f" (quick run: coarse meshes, cases 1 and 2 only, without {', '.join(LONG)})" if quick else ""),
        headline=headline,
        provenance=facts,
        sections=sections,
        scene_hashes={name: scene_hash(catalogue.scene_text(name)) for name in study.used},
    )
    try:
        page = write(report, out, partial(progress.step))
    except (ValueError, OSError) as error:
        raise _bad_folder(out, error) from None
    print(f"report: {page} ({perf_counter() - start:.0f} s)", flush=True)
    return 0


def _bad_folder(out: Path, error: Exception) -> InputError:
    return InputError(
        str(out), "--out", str(error), "a folder that is new, empty or an earlier report", "choose another folder"
    )
