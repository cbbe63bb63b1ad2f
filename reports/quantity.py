"""What a column of a table holds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Quantity:
    """What a column of a table holds: key, heading, unit and format; value: it, of a record that has it.

    Formats: ``"g4"`` for 4 significant digits, ``"s"`` for text, or Python's such as ``".2f"``. Quantities with
    the keys ``class`` and ``verdict`` are marked in the page.
    """

    key: str
    label: str
    unit: str = ""
    format: str = "g4"
    value: Callable[[Any], Any] = field(default=lambda _: None, compare=False)
