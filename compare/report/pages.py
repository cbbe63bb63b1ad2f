"""Sections of the report in order, their requirements, and the pages that they belong to.

The first report on a machine states what it leaves out and how to get it, and recomputes one shipped run.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import numpy as np

from rollbench.compare.case import every_case
from rollbench.compare.measure import error_percent
from rollbench.compare.reference.computing import compute_runs
from rollbench.compare.reference.store import load_run
from rollbench.compare.reference.tasks import Task
from rollbench.compare.running import cores, gmsh_fault
from rollbench.compare.scenes import catalogue
from rollbench.meshes.libraries import MESHING, PICTURES, apt_command
from rollbench.meshes.loads import mean_load
from rollbench.reports.content import FieldPicture, LoadedScrew, Page, Section, Table
from rollbench.reports.offscreen import drawing_fault as drawing_fault

#: Pages by name: title. A case's page has the name of the case and its title, else that of its first section.
PAGES = {
    "reading": "How to read this report",
    **{case.name: case.title[:1].upper() + case.title[1:] for case in every_case() if case.page},
    "cases": "Each compared scene",
    "accuracy": "Errors of the models",
    "reference": "Uncertainty of the 3D reference",
    "robustness": "Stability and run time",
    "tolerances": "Effect of manufacturing tolerances",
    "trust": "Quantities for which each model is accurate enough",
    "entries": "All printed values and their verdicts",
}

#: Sections of what all others used and found: they are made last.
GATHERING = ("overview", "notes", "verdicts", "audit")

#: Pages that rest on compiled kernels: where two processes make the report, one of them makes these.
COMPILED = ("lin", "smith", "liu")

#: Verdicts that do not concern a model, and the other ones in a sentence.
APART = {"input": "inputs", "identity": "identities"}

WORDS = {
    "reproduced": "are reproduced",
    "only as printed": "come out only with the source's own fault",
    "band": "lie in their band",
    "contradicted": "are contradicted",
    "not identifiable": "are not identifiable",
}


@dataclass(frozen=True)
class Listed:
    """A part of the report: one section or several."""

    #: Name for ``--only``.
    name: str
    #: Page that it belongs to.
    page: str
    #: Module in ``package``, as ``module:function`` if the function is not ``make_section``.
    module: str
    #: Whether it is part of a quick report.
    quick: bool = False
    #: Whether it shows runs of the 3D reference.
    runs: bool = False
    #: Whether it needs gmsh.
    meshes: bool = False
    #: What of it needs gmsh, if the rest does not.
    meshed: str = ""
    #: Package of the module.
    package: str = "rollbench.compare"


#: Sections whose page is chosen here, in the order of the pages.
PLACED = (
    Listed("how-to-read", "reading", "sections.how_to_read", quick=True, runs=True),
    Listed("sheets", "cases", "sections.sheets", quick=True, runs=True),
    Listed("reference", "cases", "sections.reference", quick=True, runs=True, meshes=True),
    Listed("lin", "lin", "cases.lin.pages.tables"),
    Listed("cases", "lin", "cases.lin.pages.chapter_2:cases_section", quick=True, runs=True),
    Listed("reconstruction", "lin", "cases.lin.pages.reconstruction", runs=True),
    Listed("overview", "accuracy", "report.overview", quick=True, runs=True),
    Listed("survey", "accuracy", "report.stability:survey_section", quick=True),
    Listed("ladder", "accuracy", "sections.ladder", quick=True, runs=True, meshes=True),
    Listed("u-val", "accuracy", "sections.u_val", quick=True, runs=True, meshes=True),
    Listed("reference-mesh", "reference", "sections.reference_mesh", quick=True, runs=True),
    Listed("pictures", "reference", "sections.pictures", meshes=True),
    Listed("verification", "reference", "sections.verification", meshes=True),
    Listed("crosscheck", "reference", "sections.verification:crosscheck_section", runs=True, meshes=True),
    Listed("hertz", "lin", "cases.lin.pages.chapter_2:hertz_section"),
    Listed("stability", "robustness", "report.stability"),
    Listed("formulations", "lin", "cases.lin.pages.chapter_2:formulations_section"),
    Listed("tolerances", "tolerances", "sections.tolerances"),
    Listed("errors", "lin", "cases.lin.pages.chapter_2:errors_section"),
    Listed("manufacturing", "lin", "cases.lin.pages.chapter_2:manufacturing_section"),
    Listed("friction", "lin", "cases.lin.pages.friction"),
    Listed("steering", "lin", "cases.lin.pages.steering"),
    Listed("friction-screw", "lin", "cases.lin.pages.friction:screw_section"),
    Listed("rolling", "kalker", "cases.kalker.page", meshed="no motion against the static reference, sizes of bodies"),
    Listed("smith", "smith", "cases.smith.page"),
    Listed("liu", "liu", "cases.liu.page"),
    Listed("outside", "makers", "cases.makers.page"),
    Listed("external", "external", "cases.external.page", runs=True),
    Listed("holding", "external", "cases.external.holding", runs=True),
    Listed("fit", "trust", "sections.fit", quick=True),
    Listed("notes", "trust", "sections.how_to_read:notes_section", quick=True, runs=True),
    Listed("verdicts", "entries", "sections.verdicts", runs=True),
    Listed("audit", "entries", "sections.verdicts:audit_section", runs=True),
)


def _with_cases() -> tuple[Listed, ...]:
    """Return all parts in the order of the pages, with those of the cases that are not listed in `PLACED`."""
    placed = {part.page for part in PLACED}
    cases = (case for case in every_case() if case.page and case.name not in placed)
    added = [Listed(case.name, case.name, case.page, package=case.package) for case in cases]
    return tuple(sorted((*PLACED, *added), key=lambda part: list(PAGES).index(part.page)))


#: Sections in the order of the pages.
SECTIONS = _with_cases()


def arrange_pages(by_name: Mapping[str, Sequence[Section]]) -> list[Page]:
    """Return the pages, in order, from sections by name of their part; pages without a section are left out."""
    by_page: dict[str, list[Section]] = {}
    for part in SECTIONS:
        if part.name in by_name:
            by_page.setdefault(part.page, []).extend(by_name[part.name])
    return [Page(name, PAGES[name] or group[0].title, group, first_sentence(group)) for name, group in by_page.items()]


def first_sentence(sections: Sequence[Section]) -> str:
    """Return the first sentence of a page: the conclusion of its first section that has one, else a count of verdicts."""
    text = next((section.conclusion for section in sections if section.conclusion), "")
    if text:
        return text
    tables = [item for section in sections for item in section.items if isinstance(item, Table)]
    tally = Counter(str(row["verdict"]) for table in tables for row in table.rows if row.get("verdict"))
    judged = {verdict: count for verdict, count in tally.most_common() if verdict not in APART}
    if not judged:
        return ""
    apart = " and ".join(f"{tally[verdict]} {words}" for verdict, words in APART.items() if tally[verdict])
    total, of = sum(judged.values()), f"; another {apart} say nothing of a model" if apart else ""
    words = ", ".join(f"{count} {WORDS.get(verdict, verdict)}" for verdict, count in judged.items())
    return f"Of {total} printed numbers and claims that test something here, {words}{of}."


#: Sections that take most of a report's time: they come with ``--all``, with ``--fresh``, and by name.
COSTLY = frozenset({"pictures", "friction", "friction-screw", "rolling", "verification", "stability"})

#: Scene and level of the shipped run that is recomputed: a quarter of a minute on one core.
CHECKED, LEVEL = "unseen-four-point", 1

#: Largest difference [% of the mean load] that another processor's round-off explains.
AGREES = 1e-3


@dataclass(frozen=True)
class LeftOut:
    """Sections or files that a report leaves out, with reason and remedy."""

    #: Their names.
    names: tuple[str, ...]
    #: The reason.
    why: str
    #: Command that adds them.
    remedy: str

    def __str__(self) -> str:
        """Return names, reason and command."""
        return f"{', '.join(self.names)}: {self.why}; {self.remedy}"


def kept_parts(parts: Sequence[Listed], *, named: bool, everything: bool) -> tuple[list[Listed], list[LeftOut]]:
    """Return the parts that can be made on this machine, and what is left out.

    Left out are costly parts, unless parts are named or all are asked for, and parts that mesh if gmsh cannot be
    loaded.
    """
    left: list[LeftOut] = []
    out = {part.name for part in parts if part.name in COSTLY} if not (named or everything) else set()
    if out:
        names = tuple(part.name for part in parts if part.name in out)
        left.append(LeftOut(names, "they take most of the time", "rollbench report --all makes them too"))
    meshing = [part for part in parts if (part.meshes or part.meshed) and part.name not in out]
    fault = gmsh_fault() if meshing else ""
    if fault:
        names = tuple(f"{part.name} ({part.meshed})" if part.meshed else part.name for part in meshing)
        left.append(LeftOut(names, f"gmsh cannot be loaded ({fault})", apt_command(MESHING, PICTURES)))
        out |= {part.name for part in meshing if part.meshes}
    return [part for part in parts if part.name not in out], left


def missing_features(sections: Iterable[Section]) -> list[LeftOut]:
    """Return what a report leaves out because a package is not installed or 3D pictures cannot be drawn."""
    left = []
    if any(isinstance(item, LoadedScrew | FieldPicture) for section in sections for item in section.items) and (
        why := drawing_fault()
    ):
        left.append(LeftOut(("3D pictures",), why, apt_command(PICTURES)))
    return left


@dataclass(frozen=True)
class LiveCheck:
    """A shipped run recomputed."""

    #: Name of the scene.
    scene: str
    #: Mesh level.
    level: int
    #: Largest difference of a contact load [% of the mean load].
    percent: float
    #: Run time [s].
    seconds: float

    @property
    def agrees(self) -> bool:
        """Whether the recomputed run differs from the stored one by round-off only."""
        return self.percent <= AGREES

    def __str__(self) -> str:
        """Return what was computed, and whether it agrees."""
        verdict = "agrees" if self.agrees else "DOES NOT AGREE"
        return (
            f"{self.scene}, level {self.level}, recomputed in {self.seconds:.0f} s, {verdict} with the "
            f"shipped run: contact loads differ by up to {self.percent:.1g} % of the mean load"
        )


def live_check(stores: Sequence[Path] | None, step: Callable[[str], None]) -> LiveCheck | None:
    """Recompute one shipped run without cache and compare it; None if no store has it."""
    scene = catalogue.scene(CHECKED)
    stored = load_run(scene, LEVEL, stores=stores)
    if stored is None:
        return None
    start = perf_counter()
    (run,) = compute_runs(Task((scene,), LEVEL, processes=cores()), step)
    mean = mean_load(stored.load)
    percent = float(np.abs(error_percent(run.load, stored.load, mean)).max()) if run.status == "converged" else float("inf")
    return LiveCheck(CHECKED, LEVEL, percent, perf_counter() - start)
