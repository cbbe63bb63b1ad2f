"""Every printed entry with its verdict, and how to read that."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence

from rollbench.comparison.evidence.audit import VERDICTS, Audited, audit
from rollbench.comparison.evidence.audit import counts as audited_counts
from rollbench.comparison.models.study import Study
from rollbench.comparison.printed.printed_data import KINDS
from rollbench.comparison.sections.finding_table import printed_table
from rollbench.reports.records import Quantity, Row, Section, Table, Text

#: What was inferred from printed results, and from which.
INFERRED = (
    "the screw's outer diameter of 32 mm (from the groove range of 2.4.2); the helix phase (from the last balls of case "
    "3); u_y of 5.2 and 8.0 um, k_S = 100 and the map step of 0.08 (from Table 3.2); theta and the side force ratio of "
    "the worst case (from 185.2 % in 3.3.4.1); the balls' oversize of 1.7 um (from Table 3.7), used in 3.4.4 too"
)
HOW_TO_READ = (
    "Every number printed by the source has a class. hard: the text determines it, it must be reproduced to the digits "
    "printed. as-printed: it comes out only when a fault of the source is repeated; that is done in a mode of its own, "
    "and the right value is given too. band: under-specified or random, compared with a range whose origin is "
    "stated. open: it contradicts itself, or what it compares with is not printed; shown, never gated on. input: the "
    "source gives it, or something was inferred from it; that its scene holds it is checked, not counted as reproduced.",
    "A reproduced entry says as much as its kind: a computed number tests a model, a claim in words tests its tendency, "
    "arithmetic on printed numbers tests the source, and a zero by symmetry tests a sign.",
    "An error is 100 (value - reference) / |reference| in per cent, for loads 100 (value - reference) / mean loaded "
    "contact of the reference; both come from one function. No model reads a printed number. "
    "What a scene of a case needs and the source does not print was inferred from printed results, and confirms none of "
    f"them: {INFERRED}.",
    "The low-order models are compared with printed values, closed forms, a second solver of the same equations, and this "
    "project's own 3D elastic-contact reference, which shares no mechanics with them and carries its own error bar.",
)


def counts(rows: Sequence[Audited]) -> list[tuple[str, str]]:
    """Headline figures: entries by verdict of the audit, and all of them."""
    total = audited_counts(rows)[-1]
    numbers = sum(r.verdict == "reproduced" and r.found.printed.kind == "number" for r in rows)
    return [
        *((f"entries {verdict}", str(total[verdict])) for verdict in VERDICTS),
        ("entries, all", str(total["all"])),
        ("computed numbers reproduced", str(numbers)),
    ]


def kinds_table(rows: Sequence[Audited]) -> Table:
    """Entries by kind and verdict."""
    tally = Counter((r.found.printed.kind, r.verdict) for r in rows)
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
    """Section of the report, with the headline figures."""
    step("every printed number and claim")
    audited = audit(study)
    tally: dict[tuple[str, str], int] = Counter((r.found.printed.cls, r.verdict) for r in audited)
    rows: list[Row] = [
        {"class": c, "verdict": v, Quantity("count", "entries", "", "s"): n} for (c, v), n in sorted(tally.items())
    ]
    return Section(
        "verdicts",
        "Printed entries and their verdicts",
        (
            Text(HOW_TO_READ),
            Table.of("verdicts", "Printed entries of all sources by class and verdict of the audit", rows),
            kinds_table(audited),
            printed_table("printed", "Every printed entry", [r.found for r in audited], place=True),
        ),
        tuple(counts(audited)),
    )
