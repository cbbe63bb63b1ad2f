"""What changed since earlier verdicts, that ``rollbench check`` wrote as CSV or JSON."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from rollbench.compare.errors import InputError, one_line
from rollbench.compare.gate.loads_file import read_table
from rollbench.compare.gate.publish import HEADS, Outcome, amount
from rollbench.compare.gate.verdict import of_whom

#: What a row is of: scene or check, and quantity.
Label = tuple[str, str]


class Row(NamedTuple):
    """A row as published: verdict, error and limit, to four digits, in one unit; None: the row has none."""

    verdict: str
    error: float | None
    limit: float | None
    unit: str

    @property
    def size(self) -> str:
        """Size of the error to two decimals, with its unit where that is not per cent."""
        return "" if self.error is None else f"{abs(self.error):.2f}{'' if self.unit == '%' else f' {self.unit}'}"


class Change(NamedTuple):
    """How a row differs from before; None: no such row."""

    scene: str
    quantity: str
    before: Row | None
    after: Row | None

    def as_json(self) -> dict[str, Any]:
        """JSON-ready: verdict and error before and after, and the limit, as published."""
        rows = self.before, self.after
        limits = [amount(row.limit, row.unit) for row in reversed(rows) if row is not None and row.limit is not None]
        return {
            "scene": self.scene,
            "quantity": self.quantity,
            "verdict": [row and row.verdict for row in rows],
            "error": [row and row.size for row in rows],
            "limit": limits[0] if limits else "",
        }

    def line(self) -> str:
        """In words: ``two-balls: largest error of a contact load 5.10 -> 6.80 %, limit 7, pass -> undecided``."""
        head, before, after = f"{self.scene}: {self.quantity}", self.before, self.after
        if after is None:
            return f"{head}: no more, {before.verdict if before else ''}"
        if before is None:
            return f"{head}: new, {after.verdict}"
        sizes = " -> ".join(dict.fromkeys(row.size or "no error" for row in (before, after)))
        unit, limit = " %" if after.unit == "%" else "", self.as_json()["limit"]
        words = f", {before.verdict} -> {after.verdict}" if before.verdict != after.verdict else ""
        return f"{head} {sizes}{unit}{f', limit {limit}' if limit else ''}{words}"


def changes(path: Path, outcomes: Sequence[Outcome]) -> list[Change]:
    """Rows whose verdict or error is another than in the file, that are new, or that are no more. Raises InputError."""
    before, after = _read(path), dict(map(_of_outcome, outcomes))
    pairs = {label: (before.get(label), after.get(label)) for label in (*before, *after)}
    return [Change(*label, old, new) for label, (old, new) in pairs.items() if _seen(old) != _seen(new)]


def _seen(row: Row | None) -> tuple[str, str] | None:
    """What counts as a change."""
    return None if row is None else (row.verdict, row.size)


def _row(verdict: str, error: float | None, limit: float | None, unit: str) -> Row:
    """A row with its numbers as published."""
    error, limit = (None if x is None else float(f"{x:.4g}") for x in (error, limit))
    return Row(verdict, error, limit, unit)


def _of_outcome(o: Outcome) -> tuple[Label, Row]:
    return (one_line(o.scene, 2000), one_line(o.quantity, 2000)), _row(o.word, o.error, o.limit, o.unit)


def _read(path: Path) -> dict[Label, Row]:
    text = read_table(path)
    try:
        return dict(map(_of_json, _listed(json.loads(text))) if text.lstrip().startswith("{") else _of_csv(text))
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        advice = "keep one of an earlier run: check with `csv=gate.csv`"
        raise InputError(str(path), "file", "something else", "verdicts that check wrote as CSV or JSON", advice) from None


def _of_csv(text: str) -> Iterator[tuple[Label, Row]]:
    heads, *rows = csv.reader(text.splitlines())
    if tuple(heads) != HEADS:
        raise ValueError(heads)
    for row in rows:
        cells = dict(zip(HEADS, row, strict=True))
        (error, unit), (limit, other) = _amount(cells["error %"]), _amount(cells["limit %"])
        label = cells["scene or check"], cells["quantity"]
        yield label, _row(cells["verdict"], error, limit, unit or other or "%")


def _amount(cell: str) -> tuple[float | None, str]:
    """Number and unit of a cell, as `gate.publish.amount` writes them."""
    number, _, unit = cell.partition(" ")
    return float(number) if number else None, unit


def _listed(data: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    return list(data["verdicts"] if "verdicts" in data else data["rows"])


def _of_json(row: Mapping[str, Any]) -> tuple[Label, Row]:
    """A row of JSON, of scenes or of the shipped gate; the ending of its limit's key says the unit."""
    if "kind" in row:
        label, verdict = (row["name"], row["kind"]), row["verdict"]
    else:
        case = f"case {row['case']}" if "case" in row else None
        label, verdict = (of_whom(row["scene"], case, row.get("set")), row["quantity"]), row["word"]
    endings = [key.removeprefix("limit_") for key in row if key.startswith("limit_") and row[key] is not None]
    unit = next(iter(endings), "percent")
    error, limit = row.get(f"error_{unit}"), row.get(f"limit_{unit}")
    return label, _row(verdict, error, limit, "%" if unit == "percent" else unit)
