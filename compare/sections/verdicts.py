"""Every printed entry with its verdict, and how to read that."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence

from compare.evidence.record import TAKEN, WITHIN, Evidence
from compare.evidence.registry import evidence
from compare.models.study import Study
from compare.printed.printed_data import KINDS
from compare.sections.finding_table import printed_table
from reports.records import Cell, Column, Section, Table, Text

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


def counts(found: Sequence[Evidence]) -> list[tuple[str, str]]:
    """Headline figures: entries by verdict."""
    tally = Counter(f.verdict.split(":")[0] for f in found)
    order = ("reproduced", "reproduced as printed", WITHIN, "not reproduced", "open")
    numbers = sum(f.verdict == "reproduced" and f.printed.kind == "number" for f in found)
    return [
        *((f"entries {verdict}", str(tally[verdict])) for verdict in order),
        ("computed numbers reproduced", str(numbers)),
        ("inputs taken over, not counted", str(tally[TAKEN])),
    ]


def kinds_table(found: Sequence[Evidence]) -> Table:
    """Entries by kind and verdict."""
    verdicts = ("reproduced", "reproduced as printed", WITHIN, TAKEN, "not reproduced", f"not {TAKEN}", "open")
    tally = Counter((f.printed.kind, f.verdict.split(":")[0]) for f in found)
    used = [v for v in verdicts if any(tally[kind, v] for kind in KINDS)]
    rows: list[dict[str, Cell]] = [
        {"kind": words, **{v: tally[kind, v] for v in used}, "all": sum(tally[kind, v] for v in verdicts)}
        for kind, words in KINDS.items()
    ]
    columns = (Column("kind", "kind", "", "s"), *(Column(v, v, "", "s") for v in used), Column("all", "entries", "", "s"))
    return Table("kinds", "Printed entries by kind and verdict", columns, rows)


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report, with the headline figures."""
    step("every printed number and claim")
    found = evidence(study)
    tally: dict[tuple[str, str], int] = Counter((f.printed.cls, f.verdict) for f in found)
    rows: list[dict[str, Cell]] = [{"class": c, "verdict": v, "count": n} for (c, v), n in sorted(tally.items())]
    return Section(
        "verdicts",
        "Printed entries and their verdicts",
        (
            Text(HOW_TO_READ),
            Table(
                "verdicts",
                "Printed entries of Lin (2019), Smith (1994) and Liu et al. (2025) by class and verdict",
                (
                    Column("class", "class", "", "s"),
                    Column("verdict", "verdict", "", "s"),
                    Column("count", "entries", "", "s"),
                ),
                rows,
            ),
            kinds_table(found),
            printed_table("printed", "Every printed entry", found, place=True),
        ),
        tuple(counts(found)),
    )
