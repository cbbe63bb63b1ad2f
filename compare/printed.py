"""Numbers and claims printed in the sources, with class and tolerance; models never read them."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from functools import cache
from typing import Any, Literal, cast

from rollbench.compare.case import file_of, shipped_files
from rollbench.compare.errors import InputError

Class = Literal["hard", "as-printed", "band", "open", "input"]

CLASSES: tuple[Class, ...] = ("hard", "as-printed", "band", "open", "input")

Kind = Literal["number", "claim", "arithmetic", "zero", "input"]

#: Kinds in words: what reproducing an entry of the kind says of a model. A table names the two in the middle.
KINDS: dict[Kind, str] = {
    "number": "computed number",
    "claim": "claim in words",
    "arithmetic": "arithmetic on printed numbers",
    "zero": "zero by symmetry",
    "input": "input, taken over",
}

NAMED: tuple[Kind, ...] = ("arithmetic", "zero")

Verdict = Literal["reproduced", "only as printed", "band", "contradicted", "not identifiable", "input", "identity"]

#: Verdicts in words, those on a model first.
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

#: Half width of a band over its middle at most: a range from 0.6 to 1.67 times a number says something of it, a wider one
#: holds nearly whatever is computed.
WIDEST = 0.25

_TEXTS = (
    *("key", "label", "printed", "unit", "place", "class", "kind", "verdict", "contradicted", "remark", "origin", "claim"),
)

_NUMBERS = ("tolerance", "low", "high")


@dataclass(frozen=True)
class Printed:
    """One number or claim printed in a source, with class, tolerance and expected verdict."""

    #: Name of its table.
    table: str
    #: Key in the table.
    key: str
    #: Description.
    label: str
    #: Number in ``unit``; None for a claim.
    value: float | None
    #: Unit as printed.
    unit: str
    #: Section or table of the source.
    place: str
    #: Class: "hard" (must be reproduced), "as-printed" (only by repeating a fault of the source), "band" (must lie between
    #: ``low`` and ``high``), "open" (shown, never gated) or "input" (given by the source, or inferred from; nothing
    #: reproduces it).
    cls: Class
    #: Absolute tolerance in ``unit``: half a unit of the last printed digit unless stated.
    tolerance: float
    #: Remark.
    remark: str
    #: Number as printed.
    printed: str = ""
    #: Low end of a band.
    low: float | None = None
    #: High end of a band.
    high: float | None = None
    #: Origin of a band.
    origin: str = ""
    #: Statement in words, if there is no number.
    claim: str = ""
    #: Kind, a key of ``KINDS``.
    kind: Kind = "number"
    #: Expected verdict, one of `VERDICTS`; None if it was never judged.
    verdict: Verdict | None = None
    #: What contradicts an open entry.
    contradicted: str = ""

    @property
    def name(self) -> str:
        """Name of the entry, ``table:key``."""
        return f"{self.table}:{self.key}"


def tables() -> list[str]:
    """Return the names of the shipped printed tables, sorted."""
    return list(shipped_files("printed"))


@cache
def load_table(name: str) -> tuple[Printed, ...]:
    """Return the entries of a printed table of any case; cached. InputError for an unknown name or a faulty row."""
    path = file_of("printed", name)
    if path is None:
        advice = "list the tables with: rollbench list"
        raise InputError("printed tables", "name", f'"{name}"', ", ".join(tables()), advice)
    return parse_table(path.read_text(encoding="utf-8"), name)


def entry(table: str, key: str) -> Printed:
    """Return a printed entry by table and key; InputError for an unknown table, KeyError for an unknown key."""
    for row in load_table(table):
        if row.key == key:
            return row
    raise KeyError(f"{table}: no printed entry {key!r}")


def value_of(table: str, key: str) -> float:
    """Return the printed number of an entry; KeyError for a claim or unknown key, InputError for an unknown table."""
    value = entry(table, key).value
    if value is None:
        raise KeyError(f"{table}: {key!r} is no number")
    return value


def parse_table(text: str, name: str) -> tuple[Printed, ...]:
    """Return the entries of a printed table from its TOML text: ``source``, ``place`` and ``[[row]]`` entries.

    InputError for a faulty row.
    """
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{name}.toml", "file", str(error), "TOML", "mend the table") from None
    unknown = set(data) - {"title", "source", "place", "row"}
    if unknown or not isinstance(data.get("row"), list) or not all(isinstance(r, dict) for r in data["row"]):
        value = ", ".join(sorted(unknown)) or "no rows"
        raise InputError(f"{name}.toml", "file", value, "title, source, place, [[row]]", "mend the table")
    rows = tuple(_row(name, data, raw, i) for i, raw in enumerate(data["row"]))
    keys = [row.key for row in rows]
    for i, key in enumerate(keys):
        if key in keys[:i]:
            raise InputError(f"{name}.toml", f"row[{i}].key", f'"{key}"', "each key once", "rename one")
    return rows


def last_digit(printed: str) -> float:
    """Return half a unit of the last digit of a printed number.

    Examples
    --------
    >>> last_digit("0.978"), last_digit("1.812e-7")
    (0.0005, 5e-11)
    """
    exponent = Decimal(printed).as_tuple().exponent
    return float(Decimal(5).scaleb(int(exponent) - 1))


def _row(table: str, data: Mapping[str, Any], raw: Mapping[str, Any], index: int) -> Printed:
    """Return the entry in a row of a printed table's TOML; InputError if a key or value is not valid."""

    def refuse(key: str, allowed: str, advice: str) -> InputError:
        value = f'"{raw[key]}"' if key in raw else "nothing"
        return InputError(f"{table}.toml", f"row[{index}].{key}", value, allowed, advice)

    _check_kinds(raw, refuse)
    cls, claim, printed = raw.get("class"), raw.get("claim", ""), raw.get("printed", "")
    if cls not in CLASSES:
        raise refuse("class", ", ".join(CLASSES), "say which class the number belongs to")
    for key in ("key", "label"):
        if not raw.get(key):
            raise refuse(key, "a text", "every row has a key and a label")
    if bool(claim) == bool(printed):
        raise refuse("printed", "either printed (a number) or claim (words)", "give one of the two")
    low, high = raw.get("low"), raw.get("high")
    if cls == "band":
        if not raw.get("origin"):
            raise refuse("origin", "a sentence", "a band says where its range comes from")
        if printed:
            if low is None or high is None or low > high:
                raise refuse("low", "low and high, low <= high", "a band of a number has two ends")
            if 0.5 * (high - low) > WIDEST * abs(0.5 * (high + low)):
                allowed = f"low and high, half their distance at most {WIDEST:g} of their middle"
                raise refuse(
                    "low", allowed, 'a wider band cannot fail: make the class "open" and say the range in the remark'
                )
    elif "low" in raw or "high" in raw:
        raise refuse("low" if "low" in raw else "high", "only in class band", "remove it, or make it a band")
    if cls == "as-printed" and not raw.get("remark"):
        raise refuse("remark", "a sentence", "say which fault of the source the number repeats")
    if "verdict" in raw and raw["verdict"] not in VERDICTS:
        raise refuse("verdict", ", ".join(VERDICTS), "give the verdict of: rollbench check --printed")
    if "contradicted" in raw and cls != "open":
        raise refuse("contradicted", "only in class open", "remove it: any other entry is contradicted by what is computed")
    try:
        tolerance = raw.get("tolerance", last_digit(printed) if printed else 0.0)
        value = float(printed) if printed else None
    except (ValueError, InvalidOperation):
        raise refuse("printed", 'a number as text, e.g. "0.978"', "write only the number; the unit has its key") from None
    if not math.isfinite(tolerance) or tolerance < 0.0 or (value is not None and not math.isfinite(value)):
        raise refuse("tolerance", "finite, not negative", "give an absolute tolerance in the row's unit")
    source, place = str(data.get("source", "")), str(raw.get("place", data.get("place", "")))
    kind = raw.get("kind", "input" if cls == "input" else "claim" if claim else "number")
    if "kind" in raw and (kind not in NAMED or claim or cls == "input"):
        raise refuse("kind", ", ".join(NAMED), "only for a number that is no input; else leave it out")
    return Printed(
        table=table,
        key=raw["key"],
        label=raw["label"],
        value=value,
        unit=raw.get("unit", ""),
        place=", ".join(p for p in (source, place) if p),
        cls=cast(Class, cls),
        tolerance=float(tolerance),
        remark=raw.get("remark", ""),
        printed=printed,
        low=None if low is None else float(low),
        high=None if high is None else float(high),
        origin=raw.get("origin", ""),
        claim=claim,
        kind=cast(Kind, kind),
        verdict=raw.get("verdict"),
        contradicted=raw.get("contradicted", ""),
    )


def _check_kinds(raw: Mapping[str, Any], refuse: Any) -> None:
    """Raise the error that ``refuse`` makes for an unknown key, or a value of the wrong type."""
    for key, value in raw.items():
        if key in _TEXTS:
            if not isinstance(value, str):
                raise refuse(key, "a text", "put it in double quotes")
        elif key not in _NUMBERS:
            raise refuse(key, ", ".join((*_TEXTS, *_NUMBERS)), "unknown key: remove it")
        elif isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            raise refuse(key, "a finite number", "write a number without quotes")
