"""Base class of all results: JSON, a table for a notebook, numbers with units by their path in the JSON."""

from __future__ import annotations

import html
import warnings
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from itertools import groupby
from typing import TYPE_CHECKING, Any, TypeAlias

from rollbench.compare.quantities import split_unit, unit_of
from rollbench.reports.cells import micro

if TYPE_CHECKING:
    import pint

#: A value that JSON holds.
JSON: TypeAlias = "bool | int | float | str | list[JSON] | dict[str, JSON] | None"
#: Version of the JSON of results, at its key ``schema``; raised when a key is removed or changes its meaning.
SCHEMA = 1


def with_schema(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the JSON of a result with its version first."""
    return {"schema": SCHEMA, **data}


class Record(ABC):
    """Result of a computation: a frozen record in SI units.

    A field is None where the scene has no such quantity, or there is no equilibrium. In a notebook a result is shown as a
    table, as text by ``print``.
    """

    @abstractmethod
    def to_dict(self) -> dict[str, JSON]:
        """Return the JSON that the command of the same name prints.

        Returns
        -------
        dict
            JSON values by key; the keys end with the unit, such as ``max_N``. The key ``schema`` holds the version.
        """

    @property
    def _shown(self) -> str:
        """Path in the JSON of the part that tables show; empty: all."""
        return ""

    @property
    def _notes(self) -> tuple[str, ...]:
        """Sentences below the table."""
        return ()

    def __getitem__(self, path: str) -> JSON:
        """Return the value at a path of keys in the JSON; deprecated, use the fields or `to_dict`.

        Parameters
        ----------
        path
            Keys joined by dots, such as ``"summary.loads.max_N"``.

        Returns
        -------
        number, text, list or dict
            The value.

        Raises
        ------
        KeyError
            If there is no such key; the message lists those that there are.
        """
        deprecated(f"result[{path!r}]", "its fields, in SI units, or result.to_dict()")
        return self._at(path)

    @property
    def data(self) -> dict[str, JSON]:
        """JSON of the result; deprecated, use `to_dict`."""
        deprecated("result.data", "result.to_dict()")
        return self.to_dict()

    def quantity(self, path: str) -> pint.Quantity:
        """Return the number at a path of keys in the JSON with its unit, which needs the package pint.

        Parameters
        ----------
        path
            Keys joined by dots, such as ``"summary.loads.max_N"``.

        Returns
        -------
        pint.Quantity
            Number or list of numbers, with the unit that the key ends with.

        Raises
        ------
        KeyError
            If there is no such key.
        ValueError
            If the key names no unit or holds no number.
        ImportError
            If pint is not installed.

        Examples
        --------
        >>> import rollbench
        >>> print(rollbench.solve("lin-case1", "lin").quantity("summary.loads.max_N").to("kN").round(3))
        0.243 kilonewton
        """
        try:
            import pint
        except ImportError as error:
            raise ImportError("quantities with units need the package pint: pip install pint") from error

        value = self._at(path)
        keys = reversed(path.split("."))  # a table of one unit has it in its own name
        unit = next((unit for key in keys if (unit := unit_of(key)[1]) is not None), None)
        if unit is None or value is None or isinstance(value, (str, bool, Mapping)):
            raise ValueError(f"{path}: {'no value' if value is None else 'no number with a unit'}")
        return pint.application_registry.get().Quantity(value, unit.text.replace("million ", "mega"))

    def definition(self, path: str) -> str:
        """Return the definition of the number at a path of keys in the JSON, and what its error is.

        Parameters
        ----------
        path
            Keys joined by dots, such as ``"summary.loads.max_N"``.

        Returns
        -------
        str
            Definition; empty for keys without one, such as names.

        Raises
        ------
        KeyError
            If there is no such key.

        Examples
        --------
        >>> import rollbench
        >>> rollbench.solve("lin-case1", "lin").definition("summary.loads.max_N")
        'largest contact load; its error: model form, `largest_percent_of_mean`'
        """
        from rollbench.compare.results.definitions import definition

        self._at(path)
        stated = definition(path)
        return "" if stated is None else stated.definition + (f"; its error: {stated.error}" if stated.error else "")

    def table(self) -> list[tuple[str, str, str]]:
        """Return the rows of the table: name, value and unit of every number that it shows.

        Returns
        -------
        list of tuple of str
            Name, value with 5 digits, unit (empty without).
        """
        return [(name, _text(value), unit) for name, value, unit in _flat(self._at(self._shown), "")]

    def __str__(self) -> str:
        """Return the table as aligned text, with its notes below."""
        rows = self.table()
        width = max((len(name) for name, *_ in rows), default=0)
        return "\n".join([*(f"{name:<{width}}  {value} {unit}".rstrip() for name, value, unit in rows), *self._notes])

    def _repr_html_(self) -> str:
        """Return the table as HTML for a notebook, with a heading for each quantity that has parts."""
        body = ""
        for group, rows in groupby(self.table(), lambda row: row[0].rpartition(": ")[0]):
            body += f"<tr><th colspan='3' style='text-align:left'>{html.escape(group)}</th></tr>" if group else ""
            body += "".join(
                f"<tr><td style='text-align:left'>{html.escape(name.removeprefix(f'{group}: '))}</td>"
                f"<td style='text-align:right'>{html.escape(value)}</td>"
                f"<td style='text-align:left'>{html.escape(micro(unit))}</td></tr>"
                for name, value, unit in rows
            )
        notes = "".join(f"<p>{html.escape(note)}</p>" for note in self._notes)
        head = "<thead><tr><th>quantity</th><th>value</th><th>unit</th></tr></thead>"
        return f"<table>{head}<tbody>{body}</tbody></table>{notes}"

    def _at(self, path: str) -> JSON:
        """Return the value at a path of keys in the JSON; KeyError with the keys that there are."""
        value: JSON = self.to_dict()
        for key in path.split(".") if path else ():
            if not isinstance(value, dict) or key not in value:
                there = ", ".join(value) if isinstance(value, dict) else "none, this is a value"
                raise KeyError(f"{path}: no {key!r}; keys here: {there}")
            value = value[key]
        return value


def deprecated(what: str, instead: str) -> None:
    """Warn the caller's caller that a name is removed in the next version.

    Parameters
    ----------
    what
        The deprecated expression.
    instead
        What replaces it.
    """
    warnings.warn(f"{what} goes in the next version: use {instead}", DeprecationWarning, stacklevel=3)


def _flat(value: JSON, name: str, of_all: str = "") -> Iterator[tuple[str, JSON, str]]:
    """Yield name, value and unit of every single value below a JSON value; None and lists of records are left out.

    Keys without a unit take that of the table that holds them (``of_all``).
    """
    if isinstance(value, dict):
        for key, inner in value.items():
            words, unit = split_unit(key)
            whole = f"{name}: {words}" if name else words
            if isinstance(inner, dict):
                yield from _flat(inner, whole, unit or of_all)
            elif inner is not None and not (isinstance(inner, list) and any(isinstance(x, (dict, list)) for x in inner)):
                yield whole, inner, unit or of_all
    elif isinstance(value, list):
        for number, inner in enumerate(value, start=1):
            yield from _flat(inner, f"{name} {number}".strip())


def _text(value: JSON) -> str:
    if isinstance(value, float):
        return f"{value:.5g}"
    if isinstance(value, list):
        return ", ".join(map(_text, value))
    return str(value)
