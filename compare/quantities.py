"""Converts quantities stated at record fields (`meshes.quantity`) to JSON and text, in the units of their keys.

The ending of a key gives the unit: ``approach_um`` is 1e6 times the field ``approach`` in m. JSON, terminal, comparison and
the tables of the library use them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from functools import cache, reduce
from typing import Any, NamedTuple

from rollbench.meshes.quantity import Stated, stated_in
from rollbench.reports.quantity import Quantity


class Unit(NamedTuple):
    """Unit at the end of a key, with the factor from SI."""

    #: Unit as shown in texts.
    text: str
    #: Factor from SI (1 for percent, hours and revolutions).
    factor: float = 1.0


#: Endings of keys with their units; the first that fits is used, so longer endings come first.
UNITS = {
    "N_per_um": Unit("N/um", 1e-6),
    "N_mm": Unit("N/mm", 1e-3),
    "Nmm": Unit("N mm", 1e3),
    "Nm": Unit("N m"),
    "rad_s": Unit("rad/s"),
    "mm_rpm": Unit("mm rpm", 3e4 / math.pi),
    "rpm": Unit("rpm", 30.0 / math.pi),
    "percent": Unit("%"),
    "million_revolutions": Unit("million revolutions"),
    "kg_mm2": Unit("kg mm²", 1e6),
    "hours": Unit("h"),
    "MPa": Unit("MPa", 1e-6),
    "mrad": Unit("mrad", 1e3),
    "deg": Unit("deg", 180.0 / math.pi),
    "mW": Unit("mW", 1e3),
    "um": Unit("um", 1e6),
    "mm": Unit("mm", 1e3),
    "km": Unit("km", 1e-3),
    "N": Unit("N"),
    "W": Unit("W"),
}


def unit_of(key: str) -> tuple[str, Unit | None]:
    """Return a key without its unit, and the unit at its end (None without unit)."""
    ending = next((ending for ending in UNITS if key.endswith(f"_{ending}")), None)
    return (key, None) if ending is None else (key[: -len(ending) - 1], UNITS[ending])


def count_of(number: int, one: str) -> str:
    """Return a number with a noun in singular or plural.

    Examples
    --------
    >>> count_of(1, "set"), count_of(2, "set")
    ('1 set', '2 sets')
    """
    return f"{number} {one}" if number == 1 else f"{number} {one}s"


def split_unit(key: str) -> tuple[str, str]:
    """Return description and unit of a key; the unit is empty if the key names none.

    Examples
    --------
    >>> split_unit("rigidity_N_per_um"), split_unit("worst_ball")
    (('rigidity', 'N/um'), ('worst ball', ''))
    """
    name, unit = unit_of(key)
    return name.replace("_", " "), "" if unit is None else unit.text


@cache
def quantities(kind: type) -> dict[str, Quantity]:
    """Return the quantities that the fields of a record class state, by their JSON keys."""
    return {x.key: _quantity_of_field(name, x) for name, x in stated_in(kind) if not callable(getattr(kind, name, None))}


def _unit_of_dotted_key(key: str) -> tuple[str, Unit | None]:
    """Return the last part of a dotted key without unit, and its unit, or else the unit of an outer part."""
    *tables, last = map(unit_of, key.split("."))
    return last[0], next((unit for _, unit in (last, *reversed(tables)) if unit is not None), None)


def heading_of(x: Stated) -> tuple[str, str]:
    """Return heading and unit of a quantity in tables."""
    words, unit = _unit_of_dotted_key(x.key)
    return x.heading or words.replace("_", " "), "" if unit is None else unit.text


def _quantity_of_field(name: str, x: Stated) -> Quantity:
    """Return the quantity of a record's field: key, heading, unit, format and the function that takes its value."""
    unit = _unit_of_dotted_key(x.key)[1]
    factor = 1.0 if unit is None else unit.factor

    def value(holder: Any) -> Any:
        return _in_key_unit(x.shown(getattr(holder, name)), factor)

    return Quantity(x.key, *heading_of(x), x.form, value)


def as_json(holder: Any, *without: str) -> dict[str, Any] | None:
    """Return a record's quantities as JSON values by key, except the keys in ``without``; None without a record."""
    if holder is None:
        return None
    out: dict[str, Any] = {}
    kind: Any = type(holder)
    for key, one in quantities(kind).items():
        if key not in without:
            *tables, last = key.split(".")
            reduce(lambda at, name: at.setdefault(name, {}), tables, out)[last] = one.value(holder)
    return out


def from_json(kind: type, data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the quantity fields of a record class, in SI, from its JSON; None for a missing value."""
    out: dict[str, Any] = {}
    for field in fields(kind):
        one = next(iter(field.metadata.get("stated", ())), None)
        if one is not None and one.show is None:
            value: Any = data
            for key in one.key.split("."):
                value = value.get(key) if isinstance(value, Mapping) else None
            unit = _unit_of_dotted_key(one.key)[1]
            out[field.name] = _in_key_unit(value, 1.0 if unit is None else 1.0 / unit.factor)
    return out


def number(value: float) -> float | None:
    """Return a number for JSON: nan and infinity become None, and zero has no sign."""
    value = float(value) + 0.0
    return value if math.isfinite(value) else None


def shown(value: float, error: float | None = None, digits: int = 4) -> str:
    """Return a number as text with some significant digits, and none beyond those of its error.

    The error counts with two digits up to 3.5, else with one, as the Particle Data Group rounds.

    Parameters
    ----------
    value
        The number.
    error
        Its error, in the same unit; None: not known.
    digits
        Largest number of significant digits.

    Examples
    --------
    >>> shown(237.46, 4.3), shown(785.24, 11.0), shown(36523.0), shown(251.93, 2.2), shown(0.94, 2.2), shown(0.0)
    ('237', '785', '36520', '251.9', '0.9', '0')
    """
    if not value or not math.isfinite(value):
        return f"{value:g}"
    if abs(value) < 1e-4:
        return f"{value:.{digits - 1}e}"
    place = math.floor(math.log10(abs(value))) - digits + 1
    if error:
        leading = math.floor(math.log10(abs(error)))
        place = max(place, leading - (abs(error) < 3.55 * 10.0**leading))
    return f"{round(value, -place) + 0.0:.{max(-place, 0)}f}"


def range_text(ends: Sequence[float] | None, digits: int = 3) -> str:
    """Return a range as text, or one number if its ends agree to the digits shown.

    Parameters
    ----------
    ends
        Lower and upper end, both in the unit shown; None: not known.
    digits
        Number of significant digits of each end.

    Returns
    -------
    str
        ``LOW to HIGH``, one number, or "not known".
    """
    if ends is None:
        return "not known"
    low, high = (shown(x, digits=digits) for x in ends)
    return low if low == high else f"{low} to {high}"


def _in_key_unit(value: Any, factor: float) -> Any:
    """Return a value for JSON in the unit of its key: numbers times ``factor``, also inside mappings and lists.

    A record becomes a dictionary.
    """
    if is_dataclass(value):
        return as_json(value)
    if isinstance(value, Mapping):
        return {key: _in_key_unit(inner, factor) for key, inner in value.items()}
    if isinstance(value, tuple | list) or getattr(value, "ndim", False):
        return [_in_key_unit(inner, factor) for inner in value]
    return value if value is None or isinstance(value, str | int) else number(factor * value)
