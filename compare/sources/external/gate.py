"""Rows of the gate on other programs, makers and textbooks."""

from __future__ import annotations

from rollbench.compare.gate.gate import GateRow
from rollbench.compare.measure import error_percent
from rollbench.compare.models.study import Study
from rollbench.compare.sources.external.evidence.case import PREFIX
from rollbench.compare.wings.evidence.record import Evidence
from rollbench.compare.wings.evidence.registry import by_table, evidence


def external_rows(study: Study, max_error: float) -> list[GateRow]:  # noqa: ARG001 - of every function of rows
    """Every number and claim of other programs, makers and textbooks that has a band, each within its own: the limit is the
    end of the band on the value's side. Hard ones are among the printed rows; open ones decide nothing."""
    tables = [name for name in by_table() if name.startswith(PREFIX)]
    return [band_row(e) for e in evidence(study, *tables) if e.printed.cls == "band"]


def band_row(found: Evidence) -> GateRow:
    """Row of an entry in a band."""
    p, value = found.printed, found.compared
    label, passed = f"{p.place}: {p.claim or p.label}", found.agrees is True
    if p.value is None or value is None or p.low is None or p.high is None:
        return GateRow(label, "external, band", None, None, None, None, passed, found.words)
    limit = abs(float(error_percent(p.high if value >= p.value else p.low, p.value)))
    return GateRow(label, "external, band", value, p.value, found.error_percent, limit, passed, found.words)
