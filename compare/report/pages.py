"""The sections of the report, in order, what each needs, and the pages that they stand on."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from rollbench.compare.case import every_case
from rollbench.reports.content import Page, Section, Table

#: Pages by name: title; those of `WHOLE` show their tables in full length.
PAGES = {
    "reading": "How to read this report",
    "cases": "Sheets of the cases",
    "accuracy": "How far off the models are",
    "reference": "How good the reference is",
    "robustness": "Stability and run time",
    "tolerances": "What errors of manufacture do",
    "friction": "Friction",
    "rolling": "Rolling contact",
    "sources": "Bearings, axes and chains of balls",
    "outside": "Measured, printed by makers, computed by others",
    "trust": "Fit for, not fit for",
    "entries": "Every printed entry",
}
WHOLE = ("entries",)
#: Verdicts that say nothing of a model, and others as a sentence has them.
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
    """A section of the report: its name, its page, its module in ``package``, as
    ``module:function`` where the function is not ``section``; quick: stands in a quick report too; runs:
    shows runs of the 3D reference; meshes: needs gmsh; meshed: what of it needs gmsh, where the rest does not."""

    name: str
    page: str
    module: str
    quick: bool = False
    runs: bool = False
    meshes: bool = False
    meshed: str = ""
    package: str = "rollbench.compare"


#: Sections whose page is chosen here, in the order of the pages.
PLACED = (
    Listed("how-to-read", "reading", "sections.how_to_read", quick=True, runs=True),
    Listed("sheets", "cases", "sections.sheets", quick=True, runs=True),
    Listed("reference", "cases", "sections.reference", quick=True, runs=True, meshes=True),
    Listed("cases", "cases", "cases.lin.pages.chapter_2:cases_section", quick=True, runs=True),
    Listed("reconstruction", "cases", "cases.lin.pages.reconstruction", runs=True),
    Listed("overview", "accuracy", "report.overview", quick=True, runs=True),
    Listed("ladder", "accuracy", "sections.ladder", quick=True, runs=True, meshes=True),
    Listed("u-val", "accuracy", "sections.u_val", quick=True, runs=True, meshes=True),
    Listed("reference-mesh", "reference", "sections.reference_mesh", quick=True, runs=True),
    Listed("pictures", "reference", "sections.pictures", meshes=True),
    Listed("verification", "reference", "sections.verification", meshes=True),
    Listed("crosscheck", "reference", "sections.crosscheck", runs=True, meshes=True),
    Listed("hertz", "reference", "cases.lin.pages.chapter_2:hertz_section"),
    Listed("stability", "robustness", "report.stability"),
    Listed("formulations", "robustness", "cases.lin.pages.chapter_2:formulations_section"),
    Listed("tolerances", "tolerances", "sections.tolerances"),
    Listed("errors", "tolerances", "cases.lin.pages.chapter_2:errors_section"),
    Listed("manufacturing", "tolerances", "cases.lin.pages.chapter_2:manufacturing_section"),
    Listed("friction", "friction", "cases.lin.pages.friction"),
    Listed("steering", "friction", "cases.lin.pages.steering"),
    Listed("friction-screw", "friction", "cases.lin.pages.friction:screw_section"),
    Listed("rolling", "rolling", "cases.kalker.page", meshed="no motion against the static reference, sizes of bodies"),
    Listed("smith", "sources", "cases.smith.page"),
    Listed("liu", "sources", "cases.liu.page"),
    Listed("outside", "outside", "cases.makers.page"),
    Listed("external", "outside", "cases.external.page", runs=True),
    Listed("holding", "outside", "cases.external.holding", runs=True),
    Listed("fit", "trust", "sections.fit", quick=True),
    Listed("notes", "trust", "sections.notes", quick=True, runs=True),
    Listed("verdicts", "entries", "sections.verdicts", runs=True),
    Listed("audit", "entries", "sections.audit", runs=True),
)


def _with_cases() -> tuple[Listed, ...]:
    """Sections in the order of the pages: with the page of each case that is not placed above, among the sources."""
    placed = {part.module.split(".")[1] for part in PLACED if part.module.startswith("cases.")}
    cases = (case for case in every_case() if case.page and case.name not in placed)
    added = [Listed(case.name, "sources", case.page, package=case.package) for case in cases]
    return tuple(sorted((*PLACED, *added), key=lambda part: list(PAGES).index(part.page)))


#: Sections in the order of the pages.
SECTIONS = _with_cases()


def pages(by_name: Mapping[str, Section]) -> list[Page]:
    """The pages of sections by name, in order; those without a section are left out."""
    by_page: dict[str, list[Section]] = {}
    for part in SECTIONS:
        if part.name in by_name:
            by_page.setdefault(part.page, []).append(by_name[part.name])
    return [Page(name, PAGES[name], group, conclusion(group), name in WHOLE) for name, group in by_page.items()]


def conclusion(sections: Sequence[Section]) -> str:
    """What a page opens with: the conclusion of its first section that has one, else how many of the printed entries in its
    tables have which verdict."""
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
