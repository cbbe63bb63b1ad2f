"""Misprints with what shows them, and printed numbers that are no entries of the tables."""

from __future__ import annotations

import tomllib
from functools import cache
from pathlib import Path
from typing import Any

from rollbench.comparison.registration import ROOT, source_files


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
