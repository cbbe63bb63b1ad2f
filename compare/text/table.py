"""Text and tables that the terminal shows for ``rollbench table``."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rollbench.compare.quantities import count_of, quantities
from rollbench.compare.results.table import ERROR_OF, Table, TableRow
from rollbench.compare.text.printing import aligned_table, split_to_width, text_width

#: Largest number of different reasons for missing results that are printed.
REASONS = 5


def table_parts(found: Table) -> list[Any]:
    """Return the table of quantities with expected errors, then lines on the combinations without results."""
    return [*split_to_width(aligned_table(_table_rows(found)), text_width()), "", *_summary_lines(found)]


def _table_rows(found: Table) -> list[dict[str, Any]]:
    """Return the rows of the table by headings: values of the varied parameters, quantities, and their expected errors."""
    named, rows = quantities(TableRow), []
    for row, place in zip(found.rows, found.places, strict=True):
        shown: dict[str, Any] = {f"{x.key} {x.unit}".rstrip(): place[x.column] for x in found.over}
        for key, field in ERROR_OF.items():
            value = named[key].value(row)
            shown[f"{named[key].label} {named[key].unit}"] = value
            if field != "load_error":
                shown[f"{named[key].label} ± %"] = None if value is None else _round_percent(getattr(row, field))
        rows.append(shown | {"loads ± %": _round_percent(row.load_error)})
    return rows


def _round_percent(percent: float | None) -> float | None:
    """Round an error [%] to two significant digits; None stays None."""
    return None if percent is None else float(f"{percent:.2g}")


def _summary_lines(found: Table) -> Iterator[str]:
    """Yield lines on the number of combinations with results, on failures, and on errors that cannot be estimated."""
    matrix = any(row.stiffness is not None for row in found.rows)
    further = "; ±: error to expect" if any(row.load_error is not None for row in found.rows) else ""
    further += "; --json and --out have the 6 x 6 stiffness" if matrix else ""
    yield f"{found.converged} of {len(found.rows)} rows have results{further}"
    yield from failure_words(found)
    yield from dict.fromkeys(f"expected error not known: {row.error_words}" for row in found.rows if row.error_words)


def failure_words(found: Table) -> Iterator[str]:
    """Yield a line for each of the first reasons for missing results, with the parameter values concerned."""
    reasons = list(found.failures.items())
    for reason, places in reasons[:REASONS]:
        others = f" and {count_of(len(places) - 1, 'further row')}" if places[1:] else ""
        yield f"{places[0]}{others}: {reason}"
    if reasons[REASONS:]:
        yield f"{count_of(len(reasons) - REASONS, 'further reason')}: see the status of the rows"
