"""What the scenes assume, what the source misprints, and what does not reproduce."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rollbench.compare.evidence import Evidence, evidence
from rollbench.compare.models.study import Study
from rollbench.lowfi.statics.summary import MODEL_ASSUMPTIONS
from rollbench.reports.content import Cell, Quantity, Row, Section, Table, Text


def assumptions(study: Study) -> list[dict[str, Cell]]:
    """Assumed statements and the scenes that make them."""
    by_text: dict[str, list[str]] = {}
    for name, scene in study.used.items():
        for sentence in scene.assumed:
            by_text.setdefault(sentence, []).append(name)
    total = len(study.used)
    return [
        {"assumed": text, "scenes": "all" if len(names) == total else ", ".join(names)}
        for text, names in sorted(by_text.items(), key=lambda item: -len(item[1]))
    ]


def _why(f: Evidence) -> str:
    """The best explanation of an entry."""
    return f.words if f.words and f.agrees is not None else f.printed.remark


def not_reproduced(found: Sequence[Evidence]) -> list[Row]:
    """Entries that are contradicted, and those that the text does not determine."""
    return [
        {
            Quantity("entry", "printed", "", "s"): p.claim or f"{p.label}: {p.printed} {p.unit}",
            "place": p.place,
            "class": p.cls,
            "verdict": verdict,
            Quantity("why", "best explanation and its evidence", "", "s"): _why(f),
        }
        for f in found
        for p, verdict in ((f.printed, f.verdict),)
        if verdict in ("contradicted", "not identifiable")
    ]


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report."""
    step("assumptions and misprints")
    return Section(
        "notes",
        "Assumptions, misprints, and what does not reproduce",
        (
            Table.of("not-reproduced", "Contradicted, or not identifiable", not_reproduced(evidence(study))),
            Table(
                "assumptions",
                "What the scenes assume where the source is silent",
                (Quantity("assumed", "assumed", "", "s"), Quantity("scenes", "scenes", "", "s")),
                assumptions(study),
            ),
            Text(MODEL_ASSUMPTIONS, bullets=True),
        ),
    )
