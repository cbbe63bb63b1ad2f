"""Base class of all results of the library, which converts them to JSON, to tables, and to numbers with units."""

from __future__ import annotations

import html
import re
import textwrap
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from itertools import zip_longest
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from rollbench.compare.quantities import name_and_unit_of_key, words_and_unit_of_key
from rollbench.reports.cells import replace_um_by_micrometre

if TYPE_CHECKING:
    import pandas
    import pint
    from matplotlib.figure import Figure

    from rollbench.reports.content import Figure as FigureContent

#: A value that the JSON format can represent.
JSON: TypeAlias = "bool | int | float | str | list[JSON] | dict[str, JSON] | None"
#: Version of the JSON format of results, at the key ``schema``; it increases when a key is removed or changes its meaning.
SCHEMA = 2


#: Units with which only names of columns end, not keys of the JSON.
SI_UNITS = ("Pa", "m", "rad")
#: Headings of the columns of a table of results.
HEADINGS = ("quantity", "value", "unit", "error to expect", "note")
#: Smallest width of the last column of a table [characters]; where less is left, the notes stand on lines of their own.
ROOM = 18


class Row(NamedTuple):
    """Texts of one row of a table of results, for example quantity "largest contact load" with the note "ball 12 SL"."""

    #: Name of the quantity.
    quantity: str
    #: Value as text.
    value: str
    #: Unit of the value; may be empty.
    unit: str = ""
    #: Error to expect of the value, as text; empty if it is not known.
    error: str = ""
    #: Remark on the value, such as the ball that it belongs to; may be empty.
    note: str = ""


def format_table_as_text(rows: Sequence[Sequence[str]], line_width: int, headings: Sequence[str] = HEADINGS) -> str:
    """Format a table as plain text with aligned columns below their headings.

    Numbers are right-aligned, the last column is wrapped, and columns without any text are left out.

    Parameters
    ----------
    rows
        Texts of each row, one for each heading.
    line_width
        Largest length of a line [characters].
    headings
        Headings of the columns, each of one line or several.

    Returns
    -------
    str
        The lines of the table, separated by newlines.
    """
    kept = [k for k in range(len(headings)) if not rows or any(row[k] for row in rows)]
    heads = zip_longest(*(heading.split("\n") for heading in headings), fillvalue="")
    table = [[row[k] for k in kept] for row in (*heads, *rows)]
    wide = [max(len(row[k]) for row in table) for k in range(len(kept))]
    left = {n for n, k in enumerate(kept) if not _is_number_column(rows, headings, k)}
    out = []
    for *cells, note in table:
        texts = [text.ljust(wide[n]) if n in left else text.rjust(wide[n]) for n, text in enumerate(cells)]
        line = "  ".join(texts)
        room, no_note = line_width - len(line) - 2, [""]
        if room < min(ROOM, wide[-1]):
            out.append(line.rstrip())
            line, room, no_note = "  ", line_width - 4, []
        last = note if len(kept) - 1 in left else note.rjust(wide[-1])
        notes = textwrap.wrap(last, room, break_on_hyphens=False) or no_note
        out += [f"{line if n == 0 else ' ' * len(line)}  {text}".rstrip() for n, text in enumerate(notes)]
    return "\n".join(out)


def _is_number_column(rows: Sequence[Sequence[str]], headings: Sequence[str], k: int) -> bool:
    """Return whether column ``k`` of a table contains numbers, and so is right-aligned.

    ``rows``: texts of each row, one for each heading. The first column and the columns of units and notes are left-aligned.
    """
    return k > 0 and headings[k] not in ("unit", "note") and any(re.match(r"[+-]?\d", row[k]) for row in rows)


def format_table_as_html(rows: Sequence[Sequence[str]], headings: Sequence[str] = HEADINGS) -> str:
    """Format a table as HTML with its headings.

    Parameters
    ----------
    rows
        Texts of each row, one for each heading.
    headings
        Headings of the columns; a column without any text is left out.

    Returns
    -------
    str
        HTML of the table.
    """
    kept = [k for k in range(len(headings)) if any(row[k] for row in rows)]
    sides = ["right" if _is_number_column(rows, headings, k) else "left" for k in range(len(headings))]

    def line(tag: str, texts: Sequence[str]) -> str:
        """Return a row of the table with the HTML tag of its cells, "th" or "td"."""
        cells = (f"<{tag} style='text-align:{sides[k]}'>{html.escape(texts[k])}</{tag}>" for k in kept)
        return f"<tr>{''.join(cells)}</tr>"

    body = "".join(line("td", [replace_um_by_micrometre(text) for text in row]) for row in rows)
    return f"<table><thead>{line('th', headings)}</thead><tbody>{body}</tbody></table>"


def add_schema_version(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the JSON values ``data`` of a result, with the version number of the format added as first key, ``schema``."""
    return {"schema": SCHEMA, **data}


class Record(ABC):
    """Result of a computation: an immutable record in SI units.

    A field is None if the quantity does not exist for the scene, or if there is no equilibrium. Notebooks show a result as
    a table, and ``print`` shows it as text.
    """

    @abstractmethod
    def to_dict(self) -> dict[str, JSON]:
        """Return the result as a dictionary, as the command of the same name prints it with ``--json``.

        Returns
        -------
        dict
            JSON values by key; the keys end with the unit, such as ``max_N``. The value of ``schema`` is the version number
            of the format.
        """

    @property
    def _notes(self) -> tuple[str, ...]:
        """Sentences printed below the table of results."""
        return ()

    def quantity(self, path: str) -> pint.Quantity:
        """Return a number of the result's JSON with its unit, as a quantity of the package pint.

        Parameters
        ----------
        path
            Keys of the number joined by dots, such as ``"summary.loads.max_N"``.

        Returns
        -------
        pint.Quantity
            Number or list of numbers, with the unit that the key ends with.

        Raises
        ------
        KeyError
            If a key does not exist.
        ValueError
            If the key does not end with a unit, or its value is no number.
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

        value = self._json_value_at(path)
        keys = reversed(path.split("."))  # a table of one unit has it in its own name
        unit = next((unit for key in keys if (unit := name_and_unit_of_key(key)[1]) is not None), None)
        if unit is None or value is None or isinstance(value, (str, bool, Mapping)):
            lacking = "value" if value is None else "number with a unit"
            raise ValueError(f"{path}: the result has no {lacking} at this path")
        return pint.application_registry.get().Quantity(value, unit.text.replace("million ", "mega"))

    def definition(self, path: str) -> str:
        """Return the definition of a number of the result's JSON, with a statement on its error.

        Parameters
        ----------
        path
            Keys of the number joined by dots, such as ``"summary.loads.max_N"``.

        Returns
        -------
        str
            The definition; empty for keys without a definition, such as names.

        Raises
        ------
        KeyError
            If a key does not exist.

        Examples
        --------
        >>> import rollbench
        >>> rollbench.solve("lin-case1", "lin").definition("summary.loads.max_N")
        'largest contact load; its error: model form, `largest_percent_of_mean`'
        """
        from rollbench.compare.results.definitions import definition

        self._json_value_at(path)
        stated = definition(path)
        return "" if stated is None else stated.definition + (f"; its error: {stated.error}" if stated.error else "")

    @property
    def headings(self) -> Sequence[str]:
        """Headings of the columns of `table`."""
        return HEADINGS

    @abstractmethod
    def table(self) -> Sequence[Sequence[str]]:
        """Return the rows of the result's table that notebooks and ``print`` show.

        Returns
        -------
        Sequence[Sequence[str]]
            Texts of each row, one for each of `headings`.
        """

    def __str__(self) -> str:
        """Return the table of results as aligned text, with the notes below it; a table without notes has long lines."""
        rows, width = self.table(), 100 if "note" in self.headings else 10_000
        return "\n".join([*([format_table_as_text(rows, width, self.headings)] if rows else []), *self._notes])

    def _repr_html_(self) -> str:
        """Return the table of results as HTML for a notebook, with the notes below it."""
        notes = "".join(f"<p>{html.escape(note)}</p>" for note in self._notes)
        return format_table_as_html(self.table(), self.headings) + notes

    def _json_value_at(self, path: str) -> JSON:
        """Return the JSON value at a path, which consists of keys joined by dots.

        Raises KeyError, with the available keys, if a key does not exist.
        """
        value: JSON = self.to_dict()
        for key in path.split("."):
            if not isinstance(value, dict) or key not in value:
                there = ", ".join(value) if isinstance(value, dict) else "none, because this is a single value"
                raise KeyError(f"{path}: there is no key {key!r}; available keys: {there}")
            value = value[key]
        return value


class TabularRecord(Record):
    """Result that is also a data frame and a figure."""

    @abstractmethod
    def frame_rows(self) -> Sequence[Mapping[str, Any]]:
        """Return the rows of the data frame: numbers and texts by column, whose names end with the unit of a number."""

    @abstractmethod
    def figure(self) -> FigureContent | None:
        """Return the figure that `plot` draws, as the report draws it; None if there is nothing to draw."""

    def columns(self) -> dict[str, Any]:
        """Return the columns of `to_dataframe` without pandas.

        Returns
        -------
        dict
            List or array of each column, by its name; all have the same length. None where a row has no value.
        """
        return _columns_of_rows(self.frame_rows())

    @property
    def shown_rows(self) -> Sequence[Mapping[str, Any]]:
        """Rows of `table` as values by column: those of the data frame, unless the class of the result shows others."""
        return self.frame_rows()

    @property
    def headings(self) -> Sequence[str]:
        """Headings of the columns of `table`, with units."""
        return [" ".join(words_and_unit_of_key(name)).rstrip() for name in _columns_of_rows(self.shown_rows)]

    def table(self) -> Sequence[Sequence[str]]:
        """Return the rows of the table that notebooks and ``print`` show, see `shown_rows`.

        Returns
        -------
        Sequence[Sequence[str]]
            Texts of each row, one for each of `headings`.
        """
        columns = _columns_of_rows(self.shown_rows).values()
        return [[*map(_format_cell_value, row)] for row in zip(*columns, strict=True)]

    def units(self) -> dict[str, str]:
        """Return the unit of each column of `columns` by its name; columns without unit are left out.

        Returns
        -------
        dict
            Unit of each column, such as "N", by the column's name.
        """
        found = {name: self.unit_of_column(name) for name in self.columns()}
        return {name: unit for name, unit in found.items() if unit}

    def unit_of_column(self, name: str) -> str:
        """Return the unit of a column, with which its name ends; a flank or the number of a component may follow it.

        Parameters
        ----------
        name
            Name of the column.

        Returns
        -------
        str
            The unit; empty without one.
        """
        bare = re.sub(r"(_(SL|SR|NL|NR))?(_\d)?$", "", name)
        unit, last = name_and_unit_of_key(bare)[1], bare.rpartition("_")[2]
        return unit.text if unit is not None else last if last in SI_UNITS else ""

    def to_dataframe(self) -> pandas.DataFrame:
        """Return the result as a pandas data frame with the columns of `columns`.

        Returns
        -------
        pandas.DataFrame
            The frame; its ``attrs["units"]`` are the units of the columns by their names, see `units`, and its
            ``attrs["values"]`` the single numbers and texts of `to_dict`, by their keys joined by dots.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        import pandas

        frame = pandas.DataFrame({name: list(column) for name, column in self.columns().items()})
        frame.attrs |= {"units": self.units(), "values": dict(single_values(self.to_dict(), ".", lists=False))}
        return frame

    def plot(self) -> Figure:
        """Draw the result, as the commands and the report draw it.

        Returns
        -------
        matplotlib.figure.Figure
            Figure that is independent of pyplot; save it by ``plot().savefig("figure.svg")``.

        Raises
        ------
        ValueError
            If there is nothing to draw.
        ImportError
            If matplotlib is not installed.
        """
        shown = self.figure()
        if shown is None:
            raise ValueError(f"{type(self).__name__}: nothing to draw")
        from rollbench.reports.figures import draw_figure_and_canvas

        drawn = draw_figure_and_canvas(shown)[1]
        drawn.suptitle("\n".join(textwrap.wrap(shown.title, 76)), fontsize="medium")
        return drawn


def _columns_of_rows(rows: Sequence[Mapping[str, Any]]) -> dict[str, list[Any]]:
    """Return the columns of rows by name; None where a row has no value."""
    return {name: [row.get(name) for row in rows] for name in dict.fromkeys(name for row in rows for name in row)}


def single_values(data: Mapping[str, JSON], joint: str = "_", *, lists: bool = True) -> Iterator[tuple[str, JSON]]:
    """Yield path and value of every number and text in nested JSON objects.

    ``joint``: text between the keys of a path. ``lists``: whether values inside lists are yielded, by their number from 1.
    """
    for key, value in data.items():
        inner = {str(k): x for k, x in enumerate(value, 1)} if isinstance(value, list) and lists else value
        if isinstance(inner, dict):
            yield from ((f"{key}{joint}{path}", x) for path, x in single_values(inner, joint, lists=lists))
        elif not isinstance(inner, list):
            yield key, inner


def known_values(data: Mapping[str, JSON]) -> dict[str, JSON]:
    """Return every number and text in nested JSON objects and lists by its keys joined by ``_``; None is left out."""
    return {path: value for path, value in single_values(data) if value is not None}


def json_rows(data: Mapping[str, JSON], group: str) -> list[Row]:
    """Return a table row for every number and text in nested JSON objects, but not those inside lists; None is left out.

    ``group``: words with which the names of the quantities begin.
    """
    named = (
        (*words_and_unit_of_key(path), value) for path, value in single_values(data, ".", lists=False) if value is not None
    )
    return [Row(f"{group}: {name.replace('.', ', ')}", _format_cell_value(value), unit) for name, unit, value in named]


def values_in_words(row: Mapping[str, Any]) -> str:
    """Return the values of a row as a line of text, such as ``level 2, cell size 0.5``; without those that are None."""
    each = ((*words_and_unit_of_key(key), value) for key, value in row.items() if value is not None)
    return ", ".join(f"{words} {_format_cell_value(value)} {unit}".rstrip() for words, unit, value in each)


def _format_cell_value(value: JSON) -> str:
    """Format a JSON value as the text of a table cell, empty for None; numbers have five significant digits."""
    if isinstance(value, float):
        return f"{value:.5g}"
    if isinstance(value, list):
        return ", ".join(map(_format_cell_value, value))
    return "" if value is None else str(value)
