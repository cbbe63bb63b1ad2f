"""The audit: one verdict for every printed entry of the sources, and how much of each source can be trusted."""

from __future__ import annotations

import hashlib
import json
import tomllib
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cache
from pathlib import Path
from typing import Any, Literal

from rollbench.compare import data
from rollbench.compare.models.study import Study
from rollbench.compare.printed.printed_data import Printed, load_table, tables
from rollbench.compare.registration import ROOT, TITLES, source_files
from rollbench.compare.wings.evidence.record import Evidence, sentences
from rollbench.compare.wings.evidence.registry import by_table, evidence, not_computed

Verdict = Literal["reproduced", "only as printed", "band", "contradicted", "not identifiable", "input", "identity"]
#: Verdicts, those that say something of the source's models first; in words.
VERDICTS: dict[Verdict, str] = {
    "reproduced": "the text determines it, and it comes out to the digits printed",
    "only as printed": "it comes out only when a fault of the source is repeated",
    "band": "under-specified or random, and within a range of stated origin",
    "contradicted": "computation, or the source itself, says otherwise",
    "not identifiable": "the text does not determine it: measured, of another program, resting on what is not printed, "
    "or within a range too wide for a wrong number to fall outside",
    "input": "given by the source and taken over",
    "identity": "arithmetic on printed numbers, or zero by symmetry: it tests no model",
}
#: Verdicts that are counted apart: they say nothing of a model.
APART: tuple[Verdict, ...] = ("input", "identity")


@cache
def misprints() -> list[dict[str, str]]:
    """Misprints and faults of all sources: source, place, wrong, right, evidence, command that shows it, test."""
    out = []
    for path in source_files("misprints.toml"):
        for row in _rows(path):
            shown = f"rollbench audit --only {row['shown']}" if "shown" in row else f"pytest {row['test']}"
            kept = {key: row[key] for key in ("place", "wrong", "right", "evidence")}
            out.append({"source": path.parent.name, **kept, "command": shown, "test": row["test"]})
    return out


@cache
def left_out() -> list[dict[str, Any]]:
    """Groups of printed numbers that are no entries: source, place, what, count, reason."""
    return _rows(ROOT / "printed" / "audit" / "left-out.toml")


def _rows(path: Path) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = tomllib.loads(path.read_text(encoding="utf-8"))["row"]
    return rows


def sources() -> dict[str, str]:
    """Titles of the sources with printed tables, by the beginning of the tables' names."""
    return TITLES


@dataclass(frozen=True)
class Audited:
    """One printed entry with its verdict: what is computed for it, of the 3D reference where it has one, and why."""

    found: Evidence
    verdict: Verdict
    reason: str
    reference: float | None = None

    @property
    def name(self) -> str:
        """ "table:key"."""
        return f"{self.found.printed.table}:{self.found.printed.key}"

    @property
    def source(self) -> str:
        """Name of the source."""
        return sources()[self.found.printed.table.split("-")[0]]

    def as_json(self) -> dict[str, Any]:
        """JSON-ready."""
        f, p = self.found, self.found.printed
        return {
            "entry": self.name,
            "source": self.source,
            "place": p.place,
            "quantity": p.label,
            "printed": p.claim or p.printed,
            "unit": p.unit,
            "class": p.cls,
            "kind": p.kind,
            "as_printed": f.as_printed,
            "right": f.value,
            "inferred_reading": f.reading,
            "reference_3d": self.reference,
            "error_percent": f.error_percent,
            "verdict": self.verdict,
            "reason": self.reason,
        }


@cache
def contradicted() -> dict[str, str]:
    """Patterns "table:key" of open entries that are contradicted, and by what."""
    patterns: dict[str, str] = data.table("printed/audit/open.toml")["contradicted"]
    return patterns


def judge(entry: Evidence) -> tuple[Verdict, str]:
    """Verdict of an entry and the reason."""
    p = entry.printed
    words = sentences(p.remark, entry.words)
    if p.cls == "open":
        for why in _contradictions(p).values():
            return "contradicted", sentences(why[:1].upper() + why[1:], words)
        return "not identifiable", words
    if p.kind == "input":
        return ("input" if entry.agrees is not False else "contradicted"), words
    if entry.agrees is None:
        return "not identifiable", words
    if not entry.agrees:
        return "contradicted", words
    if p.kind in ("arithmetic", "zero"):
        return "identity", words
    by_class: dict[str, Verdict] = {"as-printed": "only as printed", "band": "band"}
    return by_class.get(p.cls, "reproduced"), words


def _contradictions(p: Printed) -> dict[str, str]:
    """Patterns of `contradicted` that fit an entry, and by what it is contradicted."""
    return {pattern: why for pattern, why in contradicted().items() if fnmatchcase(f"{p.table}:{p.key}", pattern)}


def audit(study: Study, *names: str) -> list[Audited]:
    """Every printed entry of the tables ``names`` (all unless given) with its verdict, in the order of the tables.

    Raises InputError for an unknown table.
    """
    out = []
    for name in names or [name for name in tables() if name in by_table() or name in not_computed()]:
        why = not_computed().get(name)
        for one in evidence(study, name) if why is None else (Evidence(row, words=why) for row in load_table(name)):
            verdict, reason = judge(one)
            out.append(Audited(one, verdict, reason, reference_value(study, f"{name}:{one.printed.key}")))
    return out


def reference_value(study: Study, name: str) -> float | None:
    """What the 3D reference gives for an entry, in its unit; None where it says nothing of it or is not stored.

    The 3D reference has the case studies of 2.4.1 without errors of the grooves: of what is printed of them, one number is
    no comparison with another program.
    """
    if name != "lin-2.4.1:case1_ratio":
        return None
    reference = study.reference("lin-case1")
    if reference is None:
        return None
    load = reference.load[:, 0]
    return float(load.max() / load.min())


def counts(rows: Sequence[Audited]) -> list[dict[str, Any]]:
    """Entries by source and verdict, one row a source and one for all: verdicts, ``judged`` (without inputs and
    identities), ``all``."""
    out = []
    for source in (*sources().values(), "all"):
        by_verdict = Counter(row.verdict for row in rows if source in (row.source, "all"))
        if by_verdict:
            judged = sum(n for verdict, n in by_verdict.items() if verdict not in APART)
            verdicts: dict[str, Any] = {str(v): by_verdict[v] for v in VERDICTS}
            out.append({"source": source, **verdicts, "judged": judged, "all": by_verdict.total()})
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


def data_digest(printed: Printed) -> str:
    """Digest of all of an entry that its verdict rests on."""
    p = printed
    data = [p.printed, p.claim, p.unit, p.cls, p.kind, p.tolerance, p.low, p.high]
    data.append([*_contradictions(p)])
    return hashlib.sha256(json.dumps(data).encode()).hexdigest()[:8]


@cache
def stored() -> dict[str, tuple[str, str]]:
    """The list of verdicts that is held by tests: "table:key" -> (digest of its data, verdict); of all tables, and what a
    source's folder has in a ``verdicts.json`` of its own."""
    texts = [data.text("printed/audit/verdicts.json"), *(path.read_text("utf-8") for path in source_files("verdicts.json"))]
    return {name: (row[0], row[1]) for text in texts for name, row in json.loads(text).items()}


def as_stored(rows: Sequence[Audited]) -> str:
    """The list of verdicts as its file holds it."""
    lines = [f"{json.dumps(r.name)}: {json.dumps([data_digest(r.found.printed), r.verdict])}" for r in rows]
    return "{\n" + ",\n".join(lines) + "\n}\n"


def changes(rows: Sequence[Audited]) -> list[str]:
    """What differs from the stored list, in words: verdicts that changed, without their data or with them; new entries."""
    out = []
    for row in rows:
        before = stored().get(row.name)
        present = data_digest(row.found.printed), row.verdict
        if before is None:
            out.append(f"{row.name}: not in the stored list ({row.verdict})")
        elif before[1] != present[1]:
            why = "without its data changing" if before[0] == present[0] else "and so did its data"
            out.append(f"{row.name}: {before[1]} became {present[1]}, {why}")
        elif before[0] != present[0]:
            out.append(f"{row.name}: its data changed, {present[1]} as before")
    return out
