"""What the scenes assume, what the source misprints, and what does not reproduce."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Sequence

from rollbench.comparison.evidence.audit import judge
from rollbench.comparison.evidence.record import Evidence
from rollbench.comparison.evidence.registry import evidence
from rollbench.comparison.models.study import Study
from rollbench.comparison.registration import ROOT
from rollbench.lowfi.statics.summary import MODEL_ASSUMPTIONS
from rollbench.reports.records import Cell, Column, Section, Table, Text

#: Columns of a table of misprints.
MISPRINT_COLUMNS = (
    Column("place", "place", "", "s"),
    Column("wrong", "as printed", "", "s"),
    Column("right", "right", "", "s"),
    Column("evidence", "evidence here", "", "s"),
)

#: Tables of misprints: name, source, and the source's author.
MISPRINTS = (
    ("misprints", "lin", "Lin (2019)"),
    ("smith-misprints", "smith", "Smith (1994)"),
    ("liu-misprints", "liu", "Liu et al. (2025)"),
)


def misprints(source: str = "lin") -> list[dict[str, Cell]]:
    """Shipped list of misprints and faults of a source, "lin", "smith" or "liu", with the evidence for each."""
    text = ROOT.joinpath("sources", source, "misprints.toml").read_text(encoding="utf-8")
    return [dict(row) for row in tomllib.loads(text)["row"]]


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


def not_reproduced(found: Sequence[Evidence]) -> list[dict[str, Cell]]:
    """Entries that are contradicted, and those that the text does not determine."""
    return [
        {
            "entry": f.printed.claim or f"{f.printed.label}: {f.printed.printed} {f.printed.unit}",
            "place": f.printed.place,
            "class": f.printed.cls,
            "verdict": judge(f)[0],
            "why": f.words if f.words and f.agrees is not None else f.printed.remark,
        }
        for f in found
        if judge(f)[0] in ("contradicted", "not identifiable")
    ]


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report."""
    step("assumptions and misprints")
    return Section(
        "notes",
        "Assumptions, misprints, and what does not reproduce",
        (
            Table(
                "not-reproduced",
                "Contradicted, or not identifiable",
                (
                    Column("entry", "printed", "", "s"),
                    Column("place", "place", "", "s"),
                    Column("class", "class", "", "s"),
                    Column("verdict", "verdict", "", "s"),
                    Column("why", "best explanation and its evidence", "", "s"),
                ),
                not_reproduced(evidence(study)),
            ),
            Table(
                "assumptions",
                "What the scenes assume where the source is silent",
                (Column("assumed", "assumed", "", "s"), Column("scenes", "scenes", "", "s")),
                assumptions(study),
            ),
            Text(MODEL_ASSUMPTIONS, bullets=True),
            *(
                Table(name, f"Misprints and faults of {of}", MISPRINT_COLUMNS, misprints(key))
                for name, key, of in MISPRINTS
            ),
        ),
    )
