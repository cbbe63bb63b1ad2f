"""Rows of the gate: every printed number and claim that is gated on."""

from __future__ import annotations

from rollbench.compare.gate.gate import GateRow
from rollbench.compare.measure import error_percent
from rollbench.compare.models.study import Study
from rollbench.compare.wings.evidence.record import Evidence
from rollbench.compare.wings.evidence.registry import evidence


def evidence_row(entry: Evidence, max_error: float) -> GateRow:
    """Row of a printed entry: its own printed digits are the limit, and ``max_error`` on top."""
    p = entry.printed
    if p.value is None:
        return GateRow(
            f"{p.place}: {p.claim}", f"claim, {p.cls}", None, None, None, None, entry.agrees is not False, entry.words
        )
    label = f"{p.place}: {p.label}"
    kind = f"printed, {p.cls}" if p.cls != "input" else "input, held by its scene"
    if p.value == 0.0:  # no per cent of it: within its own tolerance or not
        return GateRow(label, kind, entry.compared, 0.0, None, None, entry.agrees is True)
    error = entry.error_percent
    limit = min(max_error, abs(float(error_percent(p.value + p.tolerance, p.value))))
    passed = bool(entry.agrees) and error is not None and abs(error) <= max_error
    return GateRow(label, kind, entry.compared, p.value, error, limit, passed)


def printed_rows(study: Study, max_error: float) -> list[GateRow]:
    """Every hard or as-printed entry and every input of the printed tables."""
    gated = [e for e in evidence(study) if e.printed.cls in ("hard", "as-printed", "input") and e.agrees is not None]
    return [evidence_row(e, max_error) for e in gated]
