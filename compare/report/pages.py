"""Table of the validation report's parts, with the page on which each is shown and the software that each needs.

A report states which parts it leaves out and how to obtain them. It also recomputes one shipped run of the 3D reference, as
a check of the installation.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import numpy as np

from rollbench.compare.case import ReportPart, all_cases
from rollbench.compare.measure import error_percent, mean_load
from rollbench.compare.printed import VERDICT_NAMES
from rollbench.compare.reference.computing import compute_reference_runs
from rollbench.compare.reference.store import load_stored_run
from rollbench.compare.reference.tasks import ReferenceTask
from rollbench.compare.running import gmsh_fault
from rollbench.compare.scenes import catalogue
from rollbench.meshes.libraries import MESHING, PICTURES, apt_command
from rollbench.reports.content import FieldPicture, LoadedScrew, Page, Section, Table
from rollbench.reports.offscreen import reason_drawing_fails

#: Titles of the report's pages by file name. The page of a publication has the name of its case (`compare.case`).
PAGES = {
    "reading": "How to read this report",
    **{
        case.name: f"{case.title[:1].upper()}{case.title[1:]}: published and computed results" if case.title else ""
        for case in all_cases()
        if case.report_parts
    },
    "cases": "Each compared screw and bearing",
    "accuracy": "Contact-load errors of the low-order models",
    "reference": "Uncertainty of the contact loads of the 3D reference",
    "robustness": "Numerical stability of the solvers on stiff and extreme cases",
    "tolerances": "Effect of manufacturing tolerances on the largest contact load",
    "trust": "Quantities for which each model is accurate enough",
    "entries": "All numbers printed in the publications that rollbench recomputes, and whether they are reproduced",
}

#: Names of the parts that summarise what the other parts used, and are made for each report.
SUMMARIES = ("notes", "verdicts", "audit")
#: Names of the parts that summarise results of all other parts, and are therefore made last.
GATHERING = ("overview", *SUMMARIES)

#: Pages that one process makes if two make the report; the other makes all other pages.
FIRST_PROCESS = tuple(case.name for case in all_cases() if case.in_first_process)

#: Verdicts on printed numbers that do not test a model, and the noun for each in a sentence.
APART = {"input": "inputs", "identity": "identities"}

#: Predicates for the other verdicts on printed numbers, in a sentence, by the names of the verdicts in tables.
WORDS = {
    VERDICT_NAMES["reproduced"]: "are reproduced",
    VERDICT_NAMES["only as printed"]: "are reproduced only with the publication's mistake repeated",
    VERDICT_NAMES["band"]: "lie in their tolerance band",
    VERDICT_NAMES["contradicted"]: "are contradicted",
    VERDICT_NAMES["not identifiable"]: "are not determined by the data in the publication",
}


#: Parts of the report that no publication brings.
PLACED = (
    ReportPart("how-to-read", "reading", "sections.how_to_read", in_quick_report=True, shows_3d_runs=True),
    ReportPart(
        "reference",
        "cases",
        "sections.reference",
        in_quick_report=True,
        shows_3d_runs=True,
        shows_run_times=True,
        needs_gmsh=True,
    ),
    ReportPart("overview", "accuracy", "report.overview", in_quick_report=True, shows_3d_runs=True, shows_run_times=True),
    ReportPart("survey", "accuracy", "report.stability:survey_section", in_quick_report=True, shows_run_times=True),
    ReportPart("ladder", "accuracy", "sections.ladder", in_quick_report=True, shows_3d_runs=True, needs_gmsh=True),
    ReportPart("u-val", "accuracy", "sections.u_val", in_quick_report=True, shows_3d_runs=True, needs_gmsh=True),
    ReportPart("reference-mesh", "reference", "sections.reference_mesh", in_quick_report=True, shows_3d_runs=True),
    ReportPart("pictures", "reference", "sections.pictures", needs_gmsh=True),
    ReportPart("verification", "reference", "sections.verification", needs_gmsh=True),
    ReportPart("crosscheck", "reference", "sections.verification:crosscheck_section", shows_3d_runs=True, needs_gmsh=True),
    ReportPart("stability", "robustness", "report.stability"),
    ReportPart("tolerances", "tolerances", "sections.tolerances"),
    ReportPart("fit", "trust", "sections.fit", in_quick_report=True),
    ReportPart("notes", "trust", "sections.how_to_read:assumptions_section", in_quick_report=True, shows_3d_runs=True),
    ReportPart("verdicts", "entries", "sections.verdicts", shows_3d_runs=True),
    ReportPart("audit", "entries", "sections.verdicts:misprints_section", shows_3d_runs=True),
)


#: All parts of the report, in the order of the pages.
SECTIONS = tuple(
    sorted(
        (*PLACED, *(part for case in all_cases() for part in case.report_parts)),
        key=lambda part: list(PAGES).index(part.page_name),
    )
)


def arrange_sections_on_pages(sections_by_part: Mapping[str, Sequence[Section]]) -> list[Page]:
    """Return the pages of the report in their order, each with its sections; pages without a section are left out.

    Parameters
    ----------
    sections_by_part
        Sections of each part of the report, by the part's name.
    """
    by_page: dict[str, list[Section]] = {}
    for part in SECTIONS:
        if part.name in sections_by_part:
            by_page.setdefault(part.page_name, []).extend(sections_by_part[part.name])
    return [
        Page(name, PAGES[name] or group[0].title, group, page_summary_sentence(group)) for name, group in by_page.items()
    ]


def page_summary_sentence(sections: Sequence[Section]) -> str:
    """Return the sentence that summarises a page: the first conclusion of its sections or, without one, a count.

    ``sections``: sections of the page. The count states how many printed numbers are reproduced, contradicted and so on.
    The text is empty if the sections contain neither a conclusion nor a table of printed numbers.
    """
    text = next((section.conclusion for section in sections if section.conclusion), "")
    if text:
        return text
    tables = [item for section in sections for item in section.items if isinstance(item, Table)]
    verdicts = [table.columns[key] for table in tables for key, head in table.heads.items() if head.mark == "verdict"]
    tally = Counter(str(verdict) for cells in verdicts for verdict in cells if verdict)
    judged = {verdict: count for verdict, count in tally.most_common() if verdict not in APART}
    if not judged:
        return ""
    apart = " and ".join(f"{tally[verdict]} {words}" for verdict, words in APART.items() if tally[verdict])
    total, of = sum(judged.values()), f"; another {apart} do not test a model" if apart else ""
    words = ", ".join(f"{count} {WORDS.get(verdict, verdict)}" for verdict, count in judged.items())
    return f"Of {total} printed numbers and claims that test a model on this page, {words}{of}."


#: Scene and mesh level of the shipped 3D run that is recomputed as a check: a quarter of a minute on one core.
CHECKED, LEVEL = "unseen-four-point", 1

#: Largest difference of recomputed contact loads [% of the mean load] that can be due to round-off on another processor.
AGREES = 1e-3


def split_into_made_and_omitted_parts(parts: Sequence[ReportPart]) -> tuple[list[ReportPart], list[str]]:
    """Return those of the requested ``parts`` of the report that can be made, and a text on those that are left out.

    Parts that generate meshes are left out if gmsh cannot be loaded. The text, if any, states them, the reason and the
    command that adds them.
    """
    meshing = [part for part in parts if part.needs_gmsh or part.contents_needing_gmsh]
    fault = gmsh_fault() if meshing else ""
    if not fault:
        return list(parts), []
    names = (f"{p.name} ({p.contents_needing_gmsh})" if p.contents_needing_gmsh else p.name for p in meshing)
    text = f"{', '.join(names)}: gmsh cannot be loaded ({fault}); {apt_command(MESHING, PICTURES)}"
    return [part for part in parts if not part.needs_gmsh], [text]


def omitted_picture_entries(sections: Iterable[Section]) -> list[str]:
    """Return a list with a text on the report's 3D pictures if this machine cannot draw them; else an empty list.

    ``sections``: sections of the report, which may contain 3D pictures.
    """
    if any(isinstance(item, LoadedScrew | FieldPicture) for section in sections for item in section.items) and (
        why := reason_drawing_fails()
    ):
        return [f"3D pictures: {why}; {apt_command(PICTURES)}"]
    return []


@dataclass(frozen=True)
class RecomputedRunCheck:
    """Comparison of a shipped run of the 3D reference with the same run recomputed on this machine."""

    #: Largest difference of a contact load between the two runs [% of the mean load].
    largest_load_difference_percent: float
    #: Time of the recomputation [s].
    computing_seconds: float

    @property
    def agrees_with_shipped_run(self) -> bool:
        """Whether the recomputed run differs from the shipped one by round-off only."""
        return self.largest_load_difference_percent <= AGREES

    def __str__(self) -> str:
        """Return scene, mesh level, time and largest difference of the recomputed run as a sentence."""
        verdict = "agrees" if self.agrees_with_shipped_run else "DOES NOT AGREE"
        return (
            f"{CHECKED}, level {LEVEL}, recomputed in {self.computing_seconds:.0f} s, {verdict} with the "
            f"shipped run: contact loads differ by up to {self.largest_load_difference_percent:.1g} % of the mean load"
        )


def recompute_shipped_run(stores: Sequence[Path] | None, step: Callable[[str], None]) -> RecomputedRunCheck | None:
    """Recompute one shipped run of the 3D reference without cache, and compare its contact loads with the stored ones.

    ``stores``: folders with runs of the 3D reference; None: the runs shipped with rollbench. ``step`` is called with each
    line of progress. Returns None if the run is not stored.
    """
    scene = catalogue.scene(CHECKED)
    stored = load_stored_run(scene, LEVEL, stores=stores)
    if stored is None:
        return None
    start = perf_counter()
    (run,) = compute_reference_runs(ReferenceTask((scene,), LEVEL), step)
    mean = mean_load(stored.load)
    percent = float(np.abs(error_percent(run.load, stored.load, mean)).max()) if run.status == "converged" else float("inf")
    return RecomputedRunCheck(percent, perf_counter() - start)
