"""What changed since earlier verdicts, that ``rollbench check`` wrote with ``--csv`` or ``--json``."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from rollbench.comparison.errors import InputError
from rollbench.comparison.gate.loads_file import read_table
from rollbench.comparison.gate.publish import HEADS, Outcome

#: What a row is of: scene or check, and quantity.
Label = tuple[str, str]


class Change(NamedTuple):
    """What is another than before of a row: verdict and error as published (None: no such row), and the limit."""

    scene: str
    quantity: str
    verdict: tuple[str | None, str | None]
    error: tuple[str | None, str | None]
    limit: str

    def line(self) -> str:
        """In words: ``two-balls: largest error of a contact load 5.10 -> 6.80 %, limit 7, pass -> undecided``."""
        head = f"{self.scene}: {self.quantity}"
        if None in self.verdict:
            before, after = self.verdict
            return f"{head}: {'new' if before is None else 'no more'}, {before or after}"
        unit = "" if self.error[1] and not self.error[1][-1].isdigit() else " %"
        error = " -> ".join(dict.fromkeys(x or "no error" for x in self.error))
        words = f", {' -> '.join(map(str, self.verdict))}" if self.verdict[0] != self.verdict[1] else ""
        return f"{head} {error}{unit}{f', limit {self.limit}' if self.limit else ''}{words}"


def changes(path: Path, outcomes: Sequence[Outcome]) -> list[Change]:
    """Rows whose verdict or error is another than in the file, that are new, or that are no more. Raises InputError."""
    before = _read(path)
    after = {_label(o.cells): o.cells for o in outcomes}
    out = []
    for label in dict.fromkeys((*before, *after)):
        old, new = (_seen(of.get(label)) for of in (before, after))
        if old[:2] != new[:2]:
            out.append(Change(*label, (old[0], new[0]), (old[1], new[1]), new[2] or old[2] or ""))
    return out


def _seen(cells: Sequence[str] | None) -> tuple[str | None, str | None, str | None]:
    """Verdict, error and limit of a row."""
    return (None, None, None) if cells is None else (cells[0], _shown(cells[4]), cells[6])


def _label(cells: Sequence[str]) -> Label:
    return cells[1], cells[3]


def _shown(error: str) -> str:
    """An error as it is compared: its size to two decimals, with its unit where that is not per cent."""
    number, _, unit = error.partition(" ")
    return f"{abs(float(number)):.2f} {unit}".rstrip() if number else ""


def _read(path: Path) -> dict[Label, Sequence[str]]:
    """Cells in the order of HEADS."""
    text = read_table(path)
    try:
        if text.lstrip().startswith("{"):
            return {_label(row): row for row in map(_cells, _listed(json.loads(text)))}
        heads, *rows = csv.reader(text.splitlines())
        own: dict[Label, Sequence[str]] = {_label(row): row for row in rows}
        if tuple(heads) != HEADS or any(len(row) != len(HEADS) for row in rows):
            raise ValueError(heads)
        for row in rows:
            _shown(row[4])
    except (ValueError, TypeError, KeyError, AttributeError, IndexError, RecursionError):
        advice = "keep one of an earlier run: rollbench check SCENE --csv gate.csv"
        raise InputError(str(path), "file", "something else", "verdicts that --csv or --json wrote", advice) from None
    return own


def _listed(data: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    return list(data["verdicts"] if "verdicts" in data else data["rows"])


def _cells(row: Mapping[str, Any]) -> tuple[str, ...]:
    """The cells of a row of JSON, of scenes or of the shipped gate."""
    if "kind" in row:
        head = (row["verdict"], row["name"], "", row["kind"])
    else:
        inner = row.get("set") or ("case" in row and f"case {row['case']}")
        scene = f"{row['scene']}, {inner}" if inner else row["scene"]
        head = (row["word"], scene, row["judged"], row["quantity"])
    numbers = []
    for key in ("error", "uncertainty", "limit"):
        unit = next(
            (name.removeprefix(f"{key}_") for name in row if name.startswith(f"{key}_") and row[name] is not None), ""
        )
        value = row[f"{key}_{unit}"] if unit else None
        numbers.append("" if value is None else f"{float(value):.4g}{'' if unit == 'percent' else f' {unit}'}")
    return (*map(str, head), *numbers, "", "", "")
