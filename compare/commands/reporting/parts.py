"""The sections of the report, in order, and what each needs."""

from __future__ import annotations

from rollbench.comparison.registration import Part, parts

#: Those of the core; wings and sources register theirs.
CORE = (
    Part("overview", "sections.overview", runs=True, beside=True),
    Part("ladder", "sections.ladder", runs=True, meshes=True, beside=True),
    Part("reference", "sections.reference", runs=True, meshes=True, beside=True),
    Part("reference-mesh", "sections.reference_mesh", runs=True, beside=True),
    Part("u-val", "sections.u_val", runs=True, meshes=True, beside=True),
    Part("pictures", "sections.pictures", long=True, meshes=True),
    Part("verification", "sections.verification", meshes=True),
    Part("history", "sections.history", runs=True, beside=True),
    Part("verdicts", "sections.verdicts", runs=True, appendix=True),
    Part("audit", "sections.audit", runs=True, appendix=True),
    Part("notes", "sections.notes", runs=True, appendix=True),
)
#: Order by name; others stand before the appendix.
ORDER = (
    "overview",
    "ladder",
    "reference",
    "reference-mesh",
    "u-val",
    "crosscheck",
    "benchmark",
    "pictures",
    "hertz",
    "cases",
    "errors",
    "manufacturing",
    "steering",
    "tolerances",
    "friction",
    "friction-screw",
    "rolling",
    "smith",
    "liu",
    "external",
    "holding",
    "formulations",
    "verification",
    "stability",
    "timing",
    "history",
    "verdicts",
    "audit",
    "notes",
)


def _place(part: Part) -> int:
    return ORDER.index(part.name) if part.name in ORDER else ORDER.index("verdicts")


#: Sections in order.
PARTS = tuple(sorted(parts(CORE), key=lambda part: (part.appendix, _place(part))))
SECTIONS = tuple(part.name for part in PARTS)
