"""Description of one column of a report's table: heading, unit and number format."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Quantity:
    """Column of a report's table: the quantity it shows, with heading, unit and number format.

    On a web page, the values of columns with the keys ``class`` and ``verdict`` are shown as coloured labels.
    """

    #: Key under which a row of the table stores the value.
    key: str
    #: Heading of the column, without unit.
    label: str
    #: Unit of the values; empty for texts and plain numbers.
    unit: str = ""
    #: Number format: ``"g4"`` for 4 significant digits, ``"s"`` for text, or a format of Python such as ``".2f"``.
    format: str = "g4"
    #: Function that returns the value for a record from which a row of the table is made.
    value: Callable[[Any], Any] = field(default=lambda _: None, compare=False)
