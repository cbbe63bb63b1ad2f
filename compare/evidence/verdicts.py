"""The audit: one verdict for every printed entry of the sources, and how much of each source can be trusted."""

from __future__ import annotations

import tomllib
from collections import Counter
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from rollbench.compare import data
from rollbench.compare.case import every_case, files_named
from rollbench.compare.evidence.computations import computations, evidence
from rollbench.compare.evidence.record import Evidence
from rollbench.compare.models.study import Study
from rollbench.compare.printed.printed_data import VERDICTS, Printed, Verdict

#: Verdicts that are counted apart: they say nothing of a model.
APART: tuple[Verdict, ...] = ("input", "identity")


@cache
def misprints() -> list[dict[str, str]]:
    """Misprints and faults of all sources: source, place, wrong, right, evidence, command that shows it, test."""
    out = []
    for case, path in files_named("misprints.toml", every_case()).items():
        for row in tomllib.loads(path.read_text(encoding="utf-8"))["row"]:
            shown = f"rollbench check --printed --only {row['shown']}" if "shown" in row else f"pytest {row['test']}"
            kept = {key: row[key] for key in ("place", "wrong", "right", "evidence")}
            out.append({"source": case.name, **kept, "command": shown, "test": row["test"]})
    return out


def left_out() -> list[dict[str, Any]]:
    """Groups of printed numbers that are no entries: source, place, what, count, reason."""
    rows: list[dict[str, Any]] = data.table("cases/left-out.toml")["row"]
    return rows


def sources() -> list[str]:
    """Titles of the sources with printed tables."""
    return [case.title for case in every_case() if case.title]


def audit(study: Study, *names: str) -> list[Evidence]:
    """Every printed entry of the tables ``names`` (all unless given) with what is computed for it and its verdict, in the
    order of the tables. Raises InputError for an unknown table."""
    return evidence(study, *(names or sorted(computations())))


def source(printed: Printed) -> str:
    """Title of the source of an entry."""
    return computations()[printed.table].case.title


def counts(rows: Sequence[Evidence]) -> list[dict[str, Any]]:
    """Entries by source and verdict, one row a source and one for all: verdicts, ``judged`` (without inputs and
    identities), ``all``."""
    out = []
    for title in (*sources(), "all"):
        by_verdict = Counter(row.verdict for row in rows if title in (source(row.printed), "all"))
        if by_verdict:
            judged = sum(n for verdict, n in by_verdict.items() if verdict not in APART)
            verdicts: dict[str, Any] = {str(v): by_verdict[v] for v in VERDICTS}
            out.append({"source": title, **verdicts, "judged": judged, "all": by_verdict.total()})
    return out


def trust(row: Mapping[str, Any]) -> str:
    """How much of a source can be trusted, in one sentence, from its row of ``counts``."""
    n = row["judged"]
    if n == 0:
        return f"{row['source']}: nothing that a model could be judged by."
    share = {v: f"{row[v]} ({100.0 * row[v] / n:.0f} %)" for v in VERDICTS if v not in APART}
    return (
        f"{row['source']}: of {n} numbers and claims that a model can be judged by, {share['reproduced']} come out as "
        f"printed, {share['band']} lie within a band, {share['only as printed']} come out only with a fault repeated, "
        f"{share['contradicted']} are contradicted and {share['not identifiable']} cannot be identified from the text."
    )
