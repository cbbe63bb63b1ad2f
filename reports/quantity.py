"""Record for a column of a report's table."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Quantity:
    """Column of a table: key, heading, unit and format.

    Columns with the keys ``class`` and ``verdict`` are marked in the page.
    """

    #: Key in the rows.
    key: str
    #: Heading.
    label: str
    #: Unit.
    unit: str = ""
    #: ``"g4"`` for 4 significant digits, ``"s"`` for text, or a format of Python such as ``".2f"``.
    format: str = "g4"
    #: Function that takes the value from a record.
    value: Callable[[Any], Any] = field(default=lambda _: None, compare=False)
