"""The sections of the report, in order, what each needs, and the pages that they stand on."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

from rollbench.compare.registration import Part, parts
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
#: Sections of the core; wings and sources register theirs.
CORE = (
    Part("how-to-read", "sections.how_to_read", quick=True, runs=True, page="reading"),
    Part("sheets", "sections.sheets", quick=True, runs=True, page="cases"),
    Part("reference", "sections.reference", quick=True, runs=True, meshes=True, page="cases"),
    Part("ladder", "sections.ladder", quick=True, runs=True, meshes=True, page="accuracy"),
    Part("u-val", "sections.u_val", quick=True, runs=True, meshes=True, page="accuracy"),
    Part("pictures", "sections.pictures", meshes=True, page="reference"),
    Part("verification", "sections.verification", meshes=True, page="reference"),
    Part("fit", "sections.fit", quick=True, page="trust"),
    Part("notes", "sections.notes", quick=True, runs=True, page="trust"),
    Part("verdicts", "sections.verdicts", runs=True, page="entries"),
    Part("audit", "sections.audit", runs=True, page="entries"),
)
#: Sections that stand before others of their page.
FIRST = (
    "overview",
    "sheets",
    "reference",
    "reference-mesh",
    "stability",
    "tolerances",
    "friction",
    "outside",
    "fit",
    "notes",
)


def _place(part: Part) -> tuple[int, int]:
    page = list(PAGES).index(part.page) if part.page in PAGES else len(PAGES)
    return page, FIRST.index(part.name) if part.name in FIRST else len(FIRST)


#: Sections in order.
PARTS = tuple(sorted(parts(CORE), key=_place))
SECTIONS = tuple(part.name for part in PARTS)


def pages(by_name: Mapping[str, Section]) -> list[Page]:
    """The pages of sections by name, in order; those without a section are left out."""
    by_page: dict[str, list[Section]] = {}
    for part in PARTS:
        if part.name in by_name:
            by_page.setdefault(part.page, []).append(by_name[part.name])
    return [Page(name, PAGES.get(name, name), group, conclusion(group), name in WHOLE) for name, group in by_page.items()]


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
