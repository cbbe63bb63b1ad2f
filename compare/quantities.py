"""Conversion of physical quantities from the fields of records to JSON and text, in the unit at the end of each JSON key.

For example, the JSON key ``approach_um`` has 1e6 times the value of the field ``approach`` in m. The fields state their
quantities by `meshes.quantity`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from functools import cache, reduce
from typing import TYPE_CHECKING, Any, NamedTuple, overload

from rollbench.meshes.quantity import QuantityDescription, quantity_descriptions
from rollbench.reports.content import TableColumn

if TYPE_CHECKING:
    from _typeshed import DataclassInstance


class Unit(NamedTuple):
    """Unit with which a JSON key ends, and the factor that converts a value from the SI unit to it."""

    #: Name of the unit in texts.
    text: str
    #: Factor from the SI unit to this unit; 1 for per cent, hours and revolutions, in which rollbench also computes.
    factor: float = 1.0


#: Units by the endings of JSON keys. The first ending that matches is used, so longer endings come first.
UNITS = {
    "N_per_um": Unit("N/um", 1e-6),
    "N_mm": Unit("N/mm", 1e-3),
    "Nmm": Unit("N mm", 1e3),
    "Nm": Unit("N m"),
    "rad_s": Unit("rad/s"),
    "mm_s": Unit("mm/s", 1e3),
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


def name_and_unit_of_key(key: str) -> tuple[str, Unit | None]:
    """Split a JSON key, such as ``approach_um``, into its name and its unit; the unit is None if the key has none."""
    ending = next((ending for ending in UNITS if key.endswith(f"_{ending}")), None)
    return (key, None) if ending is None else (key[: -len(ending) - 1], UNITS[ending])


def count_with_noun(number: int, noun: str) -> str:
    """Return a text with a number and a noun in singular or plural; ``noun`` is the noun in singular.

    Examples
    --------
    >>> count_with_noun(1, "set"), count_with_noun(2, "set")
    ('1 set', '2 sets')
    """
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def words_and_unit_of_key(key: str) -> tuple[str, str]:
    """Split a JSON key into a description in words and the text of its unit, which is empty if the key has no unit.

    Examples
    --------
    >>> words_and_unit_of_key("rigidity_N_per_um"), words_and_unit_of_key("worst_ball")
    (('rigidity', 'N/um'), ('worst ball', ''))
    """
    name, unit = name_and_unit_of_key(key)
    return name.replace("_", " "), "" if unit is None else unit.text


@dataclass(frozen=True, kw_only=True)
class Quantity(TableColumn):
    """Quantity of a record: column of a table whose rows are records."""

    #: Name of the record's field or property.
    name: str
    #: Description of the quantity at the field.
    described: QuantityDescription
    #: Function that takes a record and returns its value in the unit with which the JSON key ends.
    value: Callable[[Any], Any]


@cache
def quantities_of_record(kind: type) -> dict[str, Quantity]:
    """Return a table column (heading, unit, format, value) for each field of the record class ``kind``, by the JSON key."""
    return {
        x.key: _quantity_of_field(name, x)
        for name, x in quantity_descriptions(kind)
        if not callable(getattr(kind, name, None))
    }


def quantities_of_instance(instance: Any) -> dict[str, Quantity]:
    """Return the quantities of the record ``instance`` by the JSON key; none for None."""
    kind: Any = type(instance)
    return quantities_of_record(kind)


def quantity_value(record: Any, key: str) -> Any:
    """Return a quantity of a record in the unit of its key; None if the record is None or has no such quantity."""
    stated = quantities_of_instance(record).get(key)
    return None if stated is None else stated.value(record)


def _unit_of_dotted_key(key: str) -> tuple[str, Unit | None]:
    """Return the last name of a dotted JSON key such as ``loads.max_N``, and the last unit that occurs in the key.

    The unit is None if no name ends with a unit.
    """
    *tables, last = map(name_and_unit_of_key, key.split("."))
    return last[0], next((unit for _, unit in (last, *reversed(tables)) if unit is not None), None)


def _quantity_of_field(name: str, description: QuantityDescription) -> Quantity:
    """Return the quantity of a record's field: key, heading, unit, format, and function that gets its value for JSON.

    ``name``: name of the field; ``description``: description of the quantity in this field.
    """
    words, unit = _unit_of_dotted_key(description.key)
    heading, (unit_text, factor) = description.heading or words.replace("_", " "), unit or Unit("")

    def value(holder: Any) -> Any:
        """Return the field ``name`` of the record ``holder`` as a JSON value, in the unit with which the JSON key ends."""
        return _in_key_unit(description.shown(getattr(holder, name)), factor)

    return Quantity(description.key, heading, unit_text, description.form, name=name, described=description, value=value)


@overload
def record_as_json(instance: None, *without: str) -> None: ...
@overload
def record_as_json(instance: DataclassInstance, *without: str) -> dict[str, Any]: ...
def record_as_json(instance: Any, *without: str) -> dict[str, Any] | None:
    """Return the quantities of the record ``instance`` as JSON values by key; None if the record is None.

    ``*without``: keys that are left out.
    """
    if instance is None:
        return None
    out: dict[str, Any] = {}
    for key, one in quantities_of_instance(instance).items():
        if key not in without and not (one.described.optional and getattr(instance, one.name) is None):
            *tables, last = key.split(".")
            reduce(lambda at, name: at.setdefault(name, {}), tables, out)[last] = one.value(instance)
    return out


def fields_from_json(record_class: type, data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of a record's quantity fields, in SI units, from its JSON.

    ``record_class``: class of the record; ``data``: JSON with the values in the units of their keys. The returned
    dictionary has the values by name of the field; None for a value that is missing in the JSON.
    """
    out: dict[str, Any] = {}
    for field in fields(record_class):
        one = next(iter(field.metadata.get("stated", ())), None)
        if one is not None and one.show is None:
            value: Any = data
            for key in one.key.split("."):
                value = value.get(key) if isinstance(value, Mapping) else None
            unit = _unit_of_dotted_key(one.key)[1] or Unit("")
            out[field.name] = _in_key_unit(value, 1.0 / unit.factor)
    return out


def json_number(value: float) -> float | None:
    """Return a number that JSON can represent: nan and infinity become None, and zero loses its sign."""
    value = float(value) + 0.0
    return value if math.isfinite(value) else None


def format_by_error(value: float, error: float | None = None, digits: int = 4) -> str:
    """Format a number with only those significant digits that its error justifies.

    The last digit shown stands at the second significant digit of the error if the error begins with 10 to 35,
    otherwise at its first significant digit, as in the rounding rule of the Particle Data Group.

    Parameters
    ----------
    value
        The number.
    error
        Error of the number, in the same unit; None if it is not known.
    digits
        Largest number of significant digits.

    Examples
    --------
    >>> format_by_error(237.46, 4.3), format_by_error(785.24, 11.0), format_by_error(36523.0), format_by_error(0.0)
    ('237', '785', '36520', '0')
    >>> format_by_error(251.93, 2.2), format_by_error(0.94, 2.2)
    ('251.9', '0.9')
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


def format_range(limits: Sequence[float] | None, digits: int = 3) -> str:
    """Format a range of numbers, or a single number if both limits agree in the digits shown.

    Parameters
    ----------
    limits
        Lower and upper limit, both in the unit shown; None if they are not known.
    digits
        Number of significant digits of each limit.

    Returns
    -------
    str
        ``LOW to HIGH``, one number, or "not known".
    """
    if limits is None:
        return "not known"
    low, high = (format_by_error(x, digits=digits) for x in limits)
    return low if low == high else f"{low} to {high}"


def _in_key_unit(value: Any, factor: float) -> Any:
    """Return a value as JSON, with all numbers multiplied by ``factor`` (from SI to the unit of the key).

    Numbers inside mappings, lists and arrays are multiplied, too, but whole numbers (int) are not. A record is converted to
    a dictionary in the units of its own keys.
    """
    if is_dataclass(value) and not isinstance(value, type):
        return record_as_json(value)
    if isinstance(value, Mapping):
        return {key: _in_key_unit(inner, factor) for key, inner in value.items()}
    if isinstance(value, tuple | list) or getattr(value, "ndim", False):
        return [_in_key_unit(inner, factor) for inner in value]
    return value if value is None or isinstance(value, str | int) else json_number(factor * value)
