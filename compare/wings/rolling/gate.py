"""Rows of the gate on rolling: low-order balls against the 3D model's."""

from __future__ import annotations

from rollbench.comparison.gate.gate import GateRow
from rollbench.comparison.models.study import Study
from rollbench.comparison.reference.store import shipped_store
from rollbench.comparison.wings.rolling.rows import GATED, KNOWN, LIMIT, PAIRS, RINGS, stored_rows, within


def rolling_rows(study: Study, max_error: float) -> list[GateRow]:
    """Low-order balls in motion against the stored runs of the 3D model of rolling: ball-to-ball forces and torques.

    A quantity beyond the line passes where the list of known ones names it with its cause, and fails where it names one
    that is not.
    """
    out: list[GateRow] = []
    stores = study.stores or (shipped_store(),)
    limit = min(LIMIT, max_error)
    for name in (*PAIRS, *RINGS):
        rows = [row for row in stored_rows(name, stores) if row.quantity in GATED]
        if not rows:
            text = f"no stored runs of the 3D model of rolling: run rollbench mesh-study {name}"
            out.append(GateRow(f"{name}: 3D rolling", "3D rolling", None, None, None, limit, False, text))
        for row in rows:
            cause = KNOWN.get((name, row.quantity), "")
            passed = within(row) != bool(cause)
            state = f", {row.load_state} load state" if row.load_state else ""
            label = f"{name}: {row.quantity} [{row.unit}] against 3D rolling{state}" + (
                f" (known: {cause})" if cause else ""
            )
            text = f"uncertainty of the 3D model {row.uncertainty:.2g} {row.unit}"
            out.append(GateRow(label, "3D rolling", row.low, row.reference, row.error_percent, limit, passed, text))
    return out
