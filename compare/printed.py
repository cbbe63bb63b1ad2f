"""Records of the numbers and claims that publications print, with their tolerances; no model uses them as input."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from functools import cache
from typing import Any, Literal, cast

from rollbench.compare.case import find_file_of_other_packages, shipped_toml_files
from rollbench.compare.errors import InputError

Class = Literal["hard", "as-printed", "band", "open", "input"]

#: Classes of printed numbers and claims, and what each says about reproducing the number.
CLASSES: dict[Class, str] = {
    "hard": "the publication states all that is needed: the number has to come out",
    "as-printed": "the number follows from a mistake of the publication: it comes out only if the mistake is repeated",
    "band": "the publication leaves something open, or the number is random: it has to lie in a range of stated origin",
    "open": "the publication does not state what is needed: the number is shown and judged by nothing",
    "input": "input data of the publication",
}

Kind = Literal["number", "claim", "arithmetic", "zero", "input"]

#: Kinds of printed numbers and claims, with their descriptions; the kind shows whether reproducing the number tests a
#: model. The file of a printed table states the kinds `NAMED` only; the other kinds follow from the class of the entry and
#: from whether it is a number or a claim.
KINDS: dict[Kind, str] = {
    "number": "computed number",
    "claim": "claim in words",
    "arithmetic": "arithmetic on printed numbers",
    "zero": "zero by symmetry or definition",
    "input": "input of the publication, used without change",
}

NAMED: tuple[Kind, ...] = ("arithmetic", "zero")

Verdict = Literal["reproduced", "only as printed", "band", "contradicted", "not identifiable", "input", "identity"]

#: Verdicts on printed numbers and claims, and their meanings; those that judge a model first.
VERDICTS: dict[Verdict, str] = {
    "reproduced": "the publication states all that is needed, and the computed number agrees to the printed digits",
    "only as printed": "the computed number agrees only if a mistake of the publication is repeated",
    "band": "not fully specified, or random, and the computed number lies within a range of stated origin",
    "contradicted": "a computation, or the publication itself, gives something else",
    "not identifiable": "the publication does not state all that is needed: the number is measured, comes from another "
    "program, depends on data that are not printed, or its range is so wide that no wrong number would fall outside",
    "input": "input data of the publication, used without change",
    "identity": "arithmetic on printed numbers, or zero by symmetry or definition: it tests no model",
}

#: Names of the verdicts in tables and sentences of the report.
VERDICT_NAMES: dict[Verdict, str] = {
    "reproduced": "reproduced",
    "only as printed": "only with the publication's mistake repeated",
    "band": "within a tolerance band",
    "contradicted": "contradicted",
    "not identifiable": "not determined by the data in the publication",
    "input": "input",
    "identity": "identity",
}

#: Largest ratio of half the width of a tolerance band to the middle of the band: a wider band contains nearly any value
#: and tests nothing.
WIDEST = 0.25

_TEXTS = (
    *("key", "label", "printed", "unit", "place", "class", "kind", "verdict", "contradicted", "remark", "origin", "claim"),
)

_NUMBERS = ("tolerance", "low", "high")


@dataclass(frozen=True)
class PrintedEntry:
    """One number or claim that a publication prints, with its tolerance and the verdict that is expected for it."""

    #: Name of the file of printed numbers, such as "lin-3.5" for Table 3.5 of Lin's thesis.
    table: str
    #: Key of the number or claim in this file.
    key: str
    #: Description of the printed quantity or claim.
    label: str
    #: Printed number, in the unit ``unit``; None for a claim in words.
    value: float | None
    #: Unit of the number, as the publication prints it.
    unit: str
    #: Section or table of the publication that prints the number or claim.
    place: str
    #: Class: "hard" (must be reproduced), "as-printed" (reproduced only by repeating a mistake of the publication), "band"
    #: (must lie between ``low`` and ``high``), "open" (shown, but never a reason to fail a check) or "input" (input data
    #: that the publication states or that were inferred from it; nothing reproduces them).
    entry_class: Class
    #: Largest difference between computed and printed number that counts as agreement, in the unit ``unit``; half a unit of
    #: the last printed digit unless the file states another.
    tolerance: float
    #: Remark on the number or claim; may be empty.
    remark: str
    #: Number as text, with the digits that the publication prints.
    number_as_printed: str = ""
    #: Lower end of the tolerance band; None: no band.
    low: float | None = None
    #: Upper end of the tolerance band; None: no band.
    high: float | None = None
    #: Sentence that states where the limits of the tolerance band come from.
    origin_of_limits: str = ""
    #: Claim of the publication in words; empty for a number.
    claim: str = ""
    #: Kind of the number or claim, a key of `KINDS`.
    kind: Kind = "number"
    #: Expected verdict on the computed value, a key of `VERDICTS`; None: no verdict is stored.
    expected_verdict: Verdict | None = None
    #: Sentence on the result or statement that contradicts a number or claim of class "open"; empty if nothing does.
    contradicting_statement: str = ""

    @property
    def name(self) -> str:
        """Name of the printed number or claim, written as ``table:key``."""
        return f"{self.table}:{self.key}"


def printed_table_names() -> list[str]:
    """Return the sorted names of all files of printed numbers, such as "lin-3.5" for table 3.5 of Lin's thesis."""
    return list(shipped_toml_files("printed"))


@cache
def load_printed_table(name: str) -> tuple[PrintedEntry, ...]:
    """Return the printed numbers and claims of the table ``name``, from a cache after the first call.

    InputError for an unknown table, or if a row of its file is not valid.
    """
    path = shipped_toml_files("printed").get(name) or find_file_of_other_packages("printed", name)
    if path is None:
        advice = "list the tables with: rollbench list"
        raise InputError("tables of publications", "name", f'"{name}"', ", ".join(printed_table_names()), advice)
    return parse_printed_table(path.read_text(encoding="utf-8"), name)


def printed_entry(table: str, key: str) -> PrintedEntry:
    """Return the printed number or claim with the key ``key`` in the file of printed numbers called ``table``.

    InputError for an unknown file, KeyError for an unknown key.
    """
    for row in load_printed_table(table):
        if row.key == key:
            return row
    raise KeyError(f"table {table} of a publication: no printed number or claim has the key {key!r}")


def printed_value(table: str, key: str) -> float:
    """Return the printed number with the key ``key`` in the file of printed numbers ``table``, in the printed unit.

    KeyError for a claim or unknown key, InputError for an unknown file.
    """
    value = printed_entry(table, key).value
    if value is None:
        raise KeyError(f"table {table} of a publication: {key!r} is a claim in words, not a number")
    return value


def parse_printed_table(text: str, name: str) -> tuple[PrintedEntry, ...]:
    """Read the numbers and claims of the printed table ``name`` from the TOML text of its file.

    The text has the keys ``title``, ``source`` (the publication) and ``place`` (its section or table), and a ``[[row]]``
    for each number or claim. InputError if a row is not valid.
    """
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{name}.toml", "file", str(error), "valid TOML", "correct the table") from None
    unknown = set(data) - {"title", "source", "place", "row"}
    if unknown or not isinstance(data.get("row"), list) or not all(isinstance(r, dict) for r in data["row"]):
        value = f"the unknown keys {', '.join(sorted(unknown))}" if unknown else "no [[row]]"
        raise InputError(f"{name}.toml", "file", value, "the keys title, source, place and [[row]]", "correct the table")
    rows = tuple(_parse_row(name, data, raw, i) for i, raw in enumerate(data["row"]))
    keys = [row.key for row in rows]
    for i, key in enumerate(keys):
        if key in keys[:i]:
            allowed, advice = "a key that no other row has", "rename one of the rows"
            raise InputError(f"{name}.toml", f"row[{i}].key", f'"{key}"', allowed, advice)
    return rows


def half_unit_of_last_digit(printed: str) -> float:
    """Return half a unit of the last digit of a printed number, which is its largest rounding error.

    Examples
    --------
    >>> half_unit_of_last_digit("0.978"), half_unit_of_last_digit("1.812e-7")
    (0.0005, 5e-11)
    """
    exponent = Decimal(printed).as_tuple().exponent
    return float(Decimal(5).scaleb(int(exponent) - 1))


def _parse_row(table: str, data: Mapping[str, Any], raw: Mapping[str, Any], index: int) -> PrintedEntry:
    """Convert a ``[[row]]`` of a file of printed numbers to a record; InputError if a key or value of the row is not valid.

    ``table``: name of the file. ``data``: content of the whole file. ``raw``: the row. ``index``: its number, from 0.
    """

    def refuse(key: str, allowed: str, advice: str, shown: str = "") -> InputError:
        """Return the InputError to raise for a faulty key of the ``[[row]]`` that is being read.

        ``key``: the faulty key; ``allowed``, ``advice``: what is allowed, and what to do, as texts of the message;
        ``shown``: text that the message shows instead of the value of the key; empty: the value is shown.
        """
        given = raw.get(key)
        value = shown or ("nothing" if given is None else f'"{given}"' if isinstance(given, str) else f"{given}")
        return InputError(f"{table}.toml", f"row[{index}].{key}", value, allowed, advice)

    _check_value_types(raw, refuse)
    cls, claim, printed = raw.get("class"), raw.get("claim", ""), raw.get("printed", "")
    if cls not in CLASSES:
        advice = (
            "state the class of this printed number or claim, which determines how the computed value is compared with it"
        )
        raise refuse("class", ", ".join(CLASSES), advice)
    for key in ("key", "label"):
        if not raw.get(key):
            raise refuse(key, "a text that is not empty", "give every row a key and a label")
    if bool(claim) == bool(printed):
        shown = "both `printed` and `claim`" if claim else "neither `printed` nor `claim`"
        allowed = "either the key `printed` with a number, or the key `claim` with words"
        raise refuse("printed", allowed, "state one of the two", shown)
    low, high = raw.get("low"), raw.get("high")
    if cls == "band":
        if not raw.get("origin"):
            raise refuse("origin", "a sentence", "state where the limits of the tolerance band come from")
        if printed:
            if low is None or high is None or low >= high:
                allowed, given = "both low and high, with low < high", f"low {low} and high {high}"
                advice = (
                    'state both limits of the tolerance band; for a zero that every computation gives, write kind = "zero" '
                    'and class = "hard"'
                )
                raise refuse("low", allowed, advice, given)
            if 0.5 * (high - low) > WIDEST * abs(0.5 * (high + low)):
                allowed = f"half the width of the band, (high - low)/2, up to {WIDEST:g} times its middle, (low + high)/2"
                advice = (
                    'change the class to "open" (the number is shown, but not compared) and state the range in the remark, '
                    "because nearly any value lies in a wider band"
                )
                raise refuse("low", allowed, advice, f"low {low} and high {high}")
    elif "low" in raw or "high" in raw:
        advice = 'remove the key, or change the class to "band"'
        raise refuse("low" if "low" in raw else "high", 'only in a row of class "band"', advice)
    if cls == "as-printed" and not raw.get("remark"):
        advice = "state which mistake of the publication must be repeated to reproduce the number"
        raise refuse("remark", "a sentence", advice)
    if "verdict" in raw and raw["verdict"] not in VERDICTS:
        raise refuse("verdict", ", ".join(VERDICTS), "state the verdict that `rollbench check --printed` shows")
    if "contradicted" in raw and cls != "open":
        advice = "remove the key: in rows of other classes, the comparison with the computed value shows a contradiction"
        raise refuse("contradicted", 'only in a row of class "open"', advice)
    try:
        tolerance = raw.get("tolerance", half_unit_of_last_digit(printed) if printed else 0.0)
        value = float(printed) if printed else None
    except (ValueError, InvalidOperation):
        advice = 'write only the number here, and its unit in the key "unit"'
        raise refuse("printed", 'a number as text, e.g. "0.978"', advice) from None
    if not math.isfinite(tolerance) or tolerance < 0.0 or (value is not None and not math.isfinite(value)):
        raise refuse("tolerance", "a finite number, at least 0", "state an absolute tolerance in the unit of the row")
    source, place = str(data.get("source", "")), str(raw.get("place", data.get("place", "")))
    kind = raw.get("kind", "input" if cls == "input" else "claim" if claim else "number")
    if "kind" in raw and (kind not in NAMED or claim or cls == "input"):
        advice = (
            "leave the key out, unless the row has a number that tests no model: arithmetic on printed numbers, or zero by "
            "symmetry"
        )
        raise refuse("kind", ", ".join(NAMED), advice)
    return PrintedEntry(
        table=table,
        key=raw["key"],
        label=raw["label"],
        value=value,
        unit=raw.get("unit", ""),
        place=", ".join(p for p in (source, place) if p),
        entry_class=cast(Class, cls),
        tolerance=float(tolerance),
        remark=raw.get("remark", ""),
        number_as_printed=printed,
        low=None if low is None else float(low),
        high=None if high is None else float(high),
        origin_of_limits=raw.get("origin", ""),
        claim=claim,
        kind=cast(Kind, kind),
        expected_verdict=raw.get("verdict"),
        contradicting_statement=raw.get("contradicted", ""),
    )


def _check_value_types(raw: Mapping[str, Any], refuse: Any) -> None:
    """Raise an error if a ``[[row]]`` of a file of printed numbers has an unknown key or a value of the wrong type.

    ``raw``: the row. ``refuse``: function that returns the error to raise, for a key, its allowed values and an advice.
    """
    for key, value in raw.items():
        if key in _TEXTS:
            if not isinstance(value, str):
                raise refuse(key, "a text", "put the value in double quotes")
        elif key not in _NUMBERS:
            raise refuse(key, ", ".join((*_TEXTS, *_NUMBERS)), "remove the unknown key")
        elif isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            raise refuse(key, "a finite number", "write a number without quotes")
