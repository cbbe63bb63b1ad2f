"""Write records as the text of a TOML scene file, with units, and without keys that have their default values.

A table is a dict of keys, values and inner tables. The records of `meshes.parts` and `meshes.axis` say which they have.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from functools import cache
from typing import Any, get_args, get_type_hints

from rollbench.meshes import ranges

#: Number of characters up to which a table or list is written on one line with its key.
LINE = 100
#: Keys of a table of a scene file, with their values or inner tables.
Table = dict[str, Any]


def toml_of_tables(tables: Mapping[str, Any]) -> str:
    """Return keys and tables as TOML text; a short inner table is written on one line with its key.

    Parameters
    ----------
    tables : Mapping[str, Any]
        Keys and tables of a scene file, in order.

    Returns
    -------
    str
        Text of a scene file.

    Examples
    --------
    >>> print(toml_of_tables({"title": "Two balls", "balls": {"count": 2}}), end="")
    title = "Two balls"
    <BLANKLINE>
    [balls]
    count = 2
    """
    return "\n".join(_table_lines(tables, "")).strip() + "\n"


def without_empty_values(**table: Any) -> Table:
    """Return the keyword arguments that are neither None nor empty as a dict, the keys of a table of a scene file.

    Examples
    --------
    >>> without_empty_values(a=1, b=None, c="", d=[])
    {'a': 1}
    """
    return {name: value for name, value in table.items() if value not in (None, "", [], {})}


def with_unit(annotated_type: Any, value: float, added_offset: float = 0.0) -> str | float:
    """Return a value in SI units as text with a unit, as in a scene file.

    Parameters
    ----------
    annotated_type : Any
        Annotated type from `ranges` that defines the unit, such as ``Size``.
    value : float
        Value in SI units.
    added_offset : float, default 0.0
        Offset in SI units that is added to the value after reading, as for `QuantityRange.text_with_unit`.

    Returns
    -------
    str | float
        Text with a unit, such as ``"3.254 mm"``; the number itself where the quantity has no unit.
    """
    return ranges.quantity_of_type(annotated_type).text_with_unit(value, added_offset)


def displacements_with_unit(values: Iterable[tuple[str, float]]) -> Table:
    """Return displacements [m] and rotations [rad], given with their degrees of freedom, as texts with units.

    Parameters
    ----------
    values : Iterable[tuple[str, float]]
        Pairs of a degree of freedom and its displacement [m] or rotation [rad].

    Returns
    -------
    Table
        Texts by the names of the degrees of freedom.

    Examples
    --------
    >>> displacements_with_unit([("ux", 0.0), ("uz", 8e-6)])
    {'ux': '0 um', 'uz': '8 um'}
    """
    return {name: with_unit(ranges.Shift if name[0] == "u" else ranges.Turn, value) for name, value in values}


def fixed_keys(fixed: Sequence[tuple[str, float]]) -> Table:
    """Return the keys ``fix`` and ``displace`` of a support or housing from its prescribed displacements.

    Parameters
    ----------
    fixed : Sequence[tuple[str, float]]
        Pairs of a degree of freedom and its prescribed displacement [m] or rotation [rad].

    Returns
    -------
    Table
        Names of the degrees of freedom that are fixed at zero, and the other displacements with units.

    Examples
    --------
    >>> fixed_keys([("ux", 0.0), ("uz", 8e-6)])
    {'fix': ['ux'], 'displace': {'uz': '8 um'}}
    """
    moved = displacements_with_unit((name, value) for name, value in fixed if value != 0.0)
    return without_empty_values(fix=[name for name, value in fixed if value == 0.0], displace=moved)


@cache
def _quantities_of_fields(record: type) -> dict[str, ranges.QuantityRange]:
    """Return the quantity (unit and range) of each field of the class ``record`` that has one, by the field's name."""
    hints = get_type_hints(record, include_extras=True)
    return {name: found[0] for name, hint in hints.items() if (found := [*_quantities_in_type(hint)])}


def _quantities_in_type(hint: Any) -> Iterator[ranges.QuantityRange]:
    """Yield the quantities with which an annotated type is annotated, also inside tuples and unions."""
    if isinstance(hint, ranges.QuantityRange):
        yield hint
    for part in (*get_args(hint), *getattr(hint, "__metadata__", ())):
        yield from _quantities_in_type(part)


def keys_of_record(record: Any, *left_out: str, **written: Any) -> Table:
    """Return the fields of a record whose values differ from the defaults, as keys of a scene file with their values.

    Fields without a description are no keys. Of keys of which a file states at least one (class attribute ``ONE_OF``) the
    first is there even so.

    Parameters
    ----------
    record : Any
        Dataclass whose fields are keys of scene files.
    *left_out : str
        Names of fields that are left out.
    **written : Any
        Values of keys as in a scene file, in place of fields or in addition; empty ones are left out.

    Returns
    -------
    Table
        Keys and their values, with units.
    """
    of: type = type(record)
    out: Table = {}
    for each in fields(record):
        value = getattr(record, each.name)
        if each.name in written:
            out[each.name] = written[each.name]
        elif "description" in each.metadata and each.name not in left_out and repr(value) != repr(each.default):
            out[each.name] = _value_with_unit(value, _quantities_of_fields(of).get(each.name))  # repr: -0 is not 0
    needed = getattr(of, "ONE_OF", ())
    if needed and not out.keys() & {*needed}:
        out[needed[0]] = _value_with_unit(getattr(record, needed[0]), _quantities_of_fields(of)[needed[0]])
    return without_empty_values(**out | written)


def _value_with_unit(value: Any, quantity: ranges.QuantityRange | None) -> Any:
    """Return the value of a record's field as in a scene file: with its unit, a record as a table, a tuple as a list.

    ``quantity``: quantity of the field, which defines the unit; None for a field without unit. A table whose keys all have
    their defaults states the first key.
    """
    if isinstance(value, tuple):
        return [_value_with_unit(x, quantity) for x in value]
    if is_dataclass(value):
        first = fields(value)[0].name
        return keys_of_record(value) or {first: getattr(value, first)}
    return quantity.text_with_unit(value) if quantity is not None and isinstance(value, float) else value


# --- text


def _table_lines(table: Mapping[str, Any], path: str) -> Iterator[str]:
    """Yield the TOML lines of a table: first its keys with plain values, then the tables inside it.

    ``path``: name of the table with a dot at its end; empty for the whole file.
    """
    inner = {}
    for name, value in table.items():
        tables = isinstance(value, dict) or (isinstance(value, list) and value and isinstance(value[0], dict))
        if tables and (not path or len(_toml_value(value)) > LINE):
            inner[name] = value
        else:
            yield f"{name} = {_toml_value(value, wrapped=True)}"
    for name, value in inner.items():
        for one in [value] if isinstance(value, dict) else value:
            yield from ("", f"[{path}{name}]" if isinstance(value, dict) else f"[[{path}{name}]]")
            yield from _table_lines(one, f"{path}{name}.")


def _toml_value(value: Any, *, wrapped: bool = False) -> str:
    """Return a value as TOML text; ``wrapped``: whether a list longer than `LINE` gets one line for each entry."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{name} = {_toml_value(x)}" for name, x in value.items()) + " }"
    if isinstance(value, list):
        entries = [_toml_value(x) for x in value]
        short = f"[{', '.join(entries)}]"
        return short if len(short) <= LINE or not wrapped else "[\n" + "".join(f"  {x},\n" for x in entries) + "]"
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e15:
        return str(int(value))
    return json.dumps(value, ensure_ascii=False)
