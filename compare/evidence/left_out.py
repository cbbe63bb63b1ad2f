"""Misprints with what shows them, and printed numbers that are no entries of the tables."""

from __future__ import annotations

import tomllib
from functools import cache
from importlib import resources
from typing import Any

SOURCES = ("lin", "smith", "liu")


@cache
def misprints() -> list[dict[str, str]]:
    """Misprints and faults of all sources: source, place, wrong, right, evidence, command that shows it, test."""
    out = []
    for source in SOURCES:
        for row in _rows("misprints", f"{source}.toml"):
            shown = f"rollbench audit --only {row['shown']}" if "shown" in row else f"pytest {row['test']}"
            kept = {key: row[key] for key in ("place", "wrong", "right", "evidence")}
            out.append({"source": source, **kept, "command": shown, "test": row["test"]})
    return out


@cache
def left_out() -> list[dict[str, Any]]:
    """Groups of printed numbers that are no entries: source, place, what, count, reason."""
    return _rows("audit", "left-out.toml")


def _rows(*place: str) -> list[dict[str, Any]]:
    text = resources.files("rollbench.comparison").joinpath("printed", *place).read_text(encoding="utf-8")
    rows: list[dict[str, Any]] = tomllib.loads(text)["row"]
    return rows
