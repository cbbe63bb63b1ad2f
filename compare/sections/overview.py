"""The first page: what was compared with what, and every printed entry with its verdict."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from compare.findings import WITHIN, Finding
from compare.sections.cases import FINDING_COLUMNS, finding_rows
from reports.records import Cell, Column, Section, Table, Text

HOW_TO_READ = (
    "Every number printed by the source has a class. hard: the text determines it, it must be reproduced to the digits "
    "printed. as-printed: it comes out only when a fault of the source is repeated; that is done in a mode of its own, "
    "and the right value stands beside it. band: under-specified or random, compared with a range whose origin is "
    "stated. open: it contradicts itself, or what it compares with is not printed; shown, never gated on.",
    "An error is 100 (value - reference) / |reference| in per cent, for loads 100 (value - reference) / mean loaded "
    "contact of the reference; both come from one function. No model reads a printed number and nothing is tuned.",
    "The low-order models are compared with printed values, closed forms, a second solver of the same equations, and this "
    "project's own 3D elastic-contact reference, which shares no mechanics with them and carries its own error bar.",
)


def counts(found: Sequence[Finding]) -> list[tuple[str, str]]:
    """Headline figures: entries by verdict."""
    tally = Counter(f.verdict.split(":")[0] for f in found)
    order = ("reproduced", "reproduced as printed", WITHIN, "not reproduced", "open")
    return [(f"entries {verdict}", str(tally[verdict])) for verdict in order]


def section(found: Sequence[Finding]) -> Section:
    """Section of the report."""
    tally: dict[tuple[str, str], int] = Counter((f.printed.cls, f.verdict) for f in found)
    rows: list[dict[str, Cell]] = [{"class": c, "verdict": v, "count": n} for (c, v), n in sorted(tally.items())]
    return Section(
        "overview",
        "What was compared, and the verdicts",
        (
            Text(HOW_TO_READ),
            Table(
                "verdicts", "Printed entries of chapters 2 and 3, Table B.1, appendix G and 4.3 by class and verdict",
                (
                    Column("class", "class", "", "s"),
                    Column("verdict", "verdict", "", "s"),
                    Column("count", "entries", "", "s"),
                ),
                rows,
            ),
            Table("printed", "Every printed entry", FINDING_COLUMNS, finding_rows(found)),
        ),
    )  # fmt: skip
