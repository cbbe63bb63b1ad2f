"""Every printed entry with its verdict, and how to read that."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence

from rollbench.compare.evidence import Evidence, audit
from rollbench.compare.evidence import counts as audited_counts
from rollbench.compare.models.study import Study
from rollbench.compare.printed import KINDS, VERDICTS
from rollbench.compare.sections.finding_table import printed_table
from rollbench.reports.content import Quantity, Row, Section, Table, Text

PLURALS = {"computed number": "computed numbers", "claim in words": "claims in words"}
#: What was inferred from printed results, and from which.
INFERRED = (
    "the screw's outer diameter of 32 mm (from the groove range of 2.4.2); the helix phase (from the last balls of case "
    "3); u_y of 5.2 and 8.0 um, k_S = 100 and the map step of 0.08 (from Table 3.2); theta and the side force ratio of "
    "the worst case (from 185.2 % in 3.3.4.1); the balls' oversize of 1.7 um (from Table 3.7), used in 3.4.4 too"
)


def total_text(rows: Sequence[Evidence]) -> str:
    """All entries and their verdicts in one sentence, claims, table values and computed results apart."""
    total = audited_counts(rows)[-1]
    kinds = Counter(r.printed.kind for r in rows if r.verdict == "reproduced")
    parts = " and ".join(f"{n} {PLURALS.get(KINDS[kind], KINDS[kind])}" for kind, n in kinds.most_common())
    words = ", ".join(f"{total[v]} {v}" for v in VERDICTS)
    return f"Of {total['all']} printed entries: {words}. Those reproduced are {parts}."


def kinds_table(rows: Sequence[Evidence]) -> Table:
    """Entries by kind and verdict."""
    tally = Counter((r.printed.kind, r.verdict) for r in rows)
    cells: list[Row] = [
        {
            "kind": words,
            **{str(v): tally[kind, v] for v in VERDICTS},
            Quantity("all", "entries", "", "s"): sum(tally[kind, v] for v in VERDICTS),
        }
        for kind, words in KINDS.items()
    ]
    return Table.of("kinds", "Printed entries by kind and verdict", cells)


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report."""
    step("every printed number and claim")
    audited = audit(study)
    tally: dict[tuple[str, str], int] = Counter((r.printed.cls, r.verdict) for r in audited)
    rows: list[Row] = [
        {"class": c, "verdict": v, Quantity("count", "entries", "", "s"): n} for (c, v), n in sorted(tally.items())
    ]
    return Section(
        "verdicts",
        "Printed entries and their verdicts",
        (
            Text(
                (
                    (
                        "What a scene needs and the source does not print was inferred from printed results, "
                        f"and therefore confirms none of them: {INFERRED}."
                    ),
                )
            ),
            Table.of("verdicts", "Printed entries of all sources by class and verdict of the audit", rows),
            kinds_table(audited),
            printed_table("printed", "Every printed entry", audited, place=True),
        ),
        conclusion=total_text(audited),
    )
