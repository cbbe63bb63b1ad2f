"""Numbers and claims printed in publications, with class and tolerance; no model reads them."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from functools import cache
from typing import Any, Literal, cast

from rollbench.compare.case import find_case_file, shipped_files
from rollbench.compare.errors import InputError

Class = Literal["hard", "as-printed", "band", "open", "input"]

CLASSES: tuple[Class, ...] = ("hard", "as-printed", "band", "open", "input")

Kind = Literal["number", "claim", "arithmetic", "zero", "input"]

#: Kinds of entries in words; an entry's kind shows whether reproducing it tests a model. Printed tables may state `NAMED`.
KINDS: dict[Kind, str] = {
    "number": "computed number",
    "claim": "claim in words",
    "arithmetic": "arithmetic on printed numbers",
    "zero": "zero by symmetry",
    "input": "input, taken over",
}

NAMED: tuple[Kind, ...] = ("arithmetic", "zero")

Verdict = Literal["reproduced", "only as printed", "band", "contradicted", "not identifiable", "input", "identity"]

#: Verdicts on printed entries, and their meanings; those that judge a model first.
VERDICTS: dict[Verdict, str] = {
    "reproduced": "the text determines it, and it comes out to the digits printed",
    "only as printed": "it comes out only when a fault of the publication is repeated",
    "band": "under-specified or random, and within a range of stated origin",
    "contradicted": "computation, or the publication itself, says otherwise",
    "not identifiable": "the text does not determine it: measured, of another program, resting on what is not printed, "
    "or within a range too wide for a wrong number to fall outside",
    "input": "given by the publication and taken over",
    "identity": "arithmetic on printed numbers, or zero by symmetry: it tests no model",
}

#: Largest half width of a band over its middle: a wider band contains nearly any computed value, and tests nothing.
WIDEST = 0.25

_TEXTS = (
    *("key", "label", "printed", "unit", "place", "class", "kind", "verdict", "contradicted", "remark", "origin", "claim"),
)

_NUMBERS = ("tolerance", "low", "high")


@dataclass(frozen=True)
class Printed:
    """One number or claim printed in a publication, with class, tolerance and expected verdict."""

    #: Name of the printed table.
    table: str
    #: Key of the entry in the table.
    key: str
    #: Description of the quantity or claim.
    label: str
    #: Number in ``unit``; None for a claim.
    value: float | None
    #: Unit as printed.
    unit: str
    #: Section or table of the publication.
    place: str
    #: Class: "hard" (must be reproduced), "as-printed" (only by repeating a fault of the publication), "band" (must lie
    #: between ``low`` and ``high``), "open" (shown, never gated) or "input" (given by the publication, or inferred from it;
    #: nothing reproduces it).
    cls: Class
    #: Absolute tolerance in ``unit``: half a unit of the last printed digit unless stated.
    tolerance: float
    #: Remark.
    remark: str
    #: Number as printed.
    printed: str = ""
    #: Lower end of the band.
    low: float | None = None
    #: Upper end of the band.
    high: float | None = None
    #: Origin of the band's range.
    origin: str = ""
    #: Statement in words, if there is no number.
    claim: str = ""
    #: Kind of entry, a key of ``KINDS``.
    kind: Kind = "number"
    #: Expected verdict, one of `VERDICTS`; None if the entry was never judged.
    verdict: Verdict | None = None
    #: Result or statement that contradicts an entry of class "open".
    contradicted: str = ""

    @property
    def name(self) -> str:
        """Name of the printed entry, ``table:key``."""
        return f"{self.table}:{self.key}"


def tables() -> list[str]:
    """Return the names of all shipped printed tables, such as "lin-3.5", sorted."""
    return list(shipped_files("printed"))


@cache
def load_table(name: str) -> tuple[Printed, ...]:
    """Return the entries of a printed table by its name; cached.

    InputError for an unknown name or a faulty row.
    """
    path = find_case_file("printed", name)
    if path is None:
        advice = "list the tables with: rollbench list"
        raise InputError("printed tables", "name", f'"{name}"', ", ".join(tables()), advice)
    return parse_table(path.read_text(encoding="utf-8"), name)


def entry(table: str, key: str) -> Printed:
    """Return a printed entry by names of table and key.

    InputError for an unknown table, KeyError for an unknown key.
    """
    for row in load_table(table):
        if row.key == key:
            return row
    raise KeyError(f"{table}: no printed entry {key!r}")


def value_of(table: str, key: str) -> float:
    """Return the printed number of an entry, in its printed unit.

    KeyError for a claim or unknown key, InputError for an unknown table.
    """
    value = entry(table, key).value
    if value is None:
        raise KeyError(f"{table}: {key!r} is a claim in words, not a number")
    return value


def parse_table(text: str, name: str) -> tuple[Printed, ...]:
    """Read the entries of a printed table from its TOML text.

    The text has keys ``title``, ``source``, ``place``, and a ``[[row]]`` for each entry. InputError for a faulty row.
    """
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{name}.toml", "file", str(error), "valid TOML", "correct the table") from None
    unknown = set(data) - {"title", "source", "place", "row"}
    if unknown or not isinstance(data.get("row"), list) or not all(isinstance(r, dict) for r in data["row"]):
        value = f"the unknown keys {', '.join(sorted(unknown))}" if unknown else "no rows"
        raise InputError(f"{name}.toml", "file", value, "the keys title, source, place and [[row]]", "correct the table")
    rows = tuple(_parse_row(name, data, raw, i) for i, raw in enumerate(data["row"]))
    keys = [row.key for row in rows]
    for i, key in enumerate(keys):
        if key in keys[:i]:
            raise InputError(
                f"{name}.toml", f"row[{i}].key", f'"{key}"', "a key that no other row has", "rename one of the rows"
            )
    return rows


def last_digit(printed: str) -> float:
    """Return half a unit of the last digit of a printed number: its tolerance by rounding.

    Examples
    --------
    >>> last_digit("0.978"), last_digit("1.812e-7")
    (0.0005, 5e-11)
    """
    exponent = Decimal(printed).as_tuple().exponent
    return float(Decimal(5).scaleb(int(exponent) - 1))


def _parse_row(table: str, data: Mapping[str, Any], raw: Mapping[str, Any], index: int) -> Printed:
    """Convert a ``[[row]]`` of a printed table to an entry; InputError if a key or value is not valid.

    ``table``: name of the table; ``data``: its whole content; ``index``: number of the row, from 0.
    """

    def refuse(key: str, allowed: str, advice: str, shown: str = "") -> InputError:
        """Return the error for a key of this row, with the value that was given or ``shown``."""
        given = raw.get(key)
        value = shown or ("nothing" if given is None else f'"{given}"' if isinstance(given, str) else f"{given}")
        return InputError(f"{table}.toml", f"row[{index}].{key}", value, allowed, advice)

    _check_value_types(raw, refuse)
    cls, claim, printed = raw.get("class"), raw.get("claim", ""), raw.get("printed", "")
    if cls not in CLASSES:
        raise refuse("class", ", ".join(CLASSES), "give the class of the number or claim")
    for key in ("key", "label"):
        if not raw.get(key):
            raise refuse(key, "a text that is not empty", "give every row a key and a label")
    if bool(claim) == bool(printed):
        shown = "both `printed` and `claim`" if claim else "neither `printed` nor `claim`"
        raise refuse("printed", "either printed (a number) or claim (words)", "give one of the two", shown)
    low, high = raw.get("low"), raw.get("high")
    if cls == "band":
        if not raw.get("origin"):
            raise refuse("origin", "a sentence", "state where the range of the band comes from")
        if printed:
            if low is None or high is None or low > high:
                raise refuse("low", "low and high, low <= high", "give both ends of the band", f"low {low}, high {high}")
            if 0.5 * (high - low) > WIDEST * abs(0.5 * (high + low)):
                allowed = f"low and high, half their distance at most {WIDEST:g} of their middle"
                raise refuse(
                    "low",
                    allowed,
                    'make the class "open" and give the range in the remark: a wider band tests nothing',
                    f"low {low}, high {high}",
                )
    elif "low" in raw or "high" in raw:
        raise refuse(
            "low" if "low" in raw else "high", 'only in a row of class "band"', 'remove the key, or make the class "band"'
        )
    if cls == "as-printed" and not raw.get("remark"):
        raise refuse("remark", "a sentence", "state which fault of the publication the number repeats")
    if "verdict" in raw and raw["verdict"] not in VERDICTS:
        raise refuse("verdict", ", ".join(VERDICTS), "give the verdict that `rollbench check --printed` shows")
    if "contradicted" in raw and cls != "open":
        raise refuse(
            "contradicted",
            'only in a row of class "open"',
            "remove the key; other classes are judged by the computed value",
        )
    try:
        tolerance = raw.get("tolerance", last_digit(printed) if printed else 0.0)
        value = float(printed) if printed else None
    except (ValueError, InvalidOperation):
        raise refuse(
            "printed", 'a number as text, e.g. "0.978"', "write the number only, and its unit in the key `unit`"
        ) from None
    if not math.isfinite(tolerance) or tolerance < 0.0 or (value is not None and not math.isfinite(value)):
        raise refuse("tolerance", "a finite number, at least 0", "give an absolute tolerance in the unit of the row")
    source, place = str(data.get("source", "")), str(raw.get("place", data.get("place", "")))
    kind = raw.get("kind", "input" if cls == "input" else "claim" if claim else "number")
    if "kind" in raw and (kind not in NAMED or claim or cls == "input"):
        raise refuse("kind", ", ".join(NAMED), "leave the key out for a claim or an input")
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


def _check_value_types(raw: Mapping[str, Any], refuse: Any) -> None:
    """Check that a row has known keys only, with values of the right type.

    Raises the error that ``refuse`` returns for a key, the allowed values and an advice.
    """
    for key, value in raw.items():
        if key in _TEXTS:
            if not isinstance(value, str):
                raise refuse(key, "a text", "put the value in double quotes")
        elif key not in _NUMBERS:
            raise refuse(key, ", ".join((*_TEXTS, *_NUMBERS)), "remove the unknown key")
        elif isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            raise refuse(key, "a finite number", "write a number without quotes")
