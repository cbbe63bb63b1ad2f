"""Quantities of scene files: ranges with units and advice, as pydantic reads them and the JSON Schema shows them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from math import pi
from typing import Any

from pydantic import Field, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import PydanticCustomError, core_schema

from rollbench.compare.scenes import units

_OF_C = re.compile(r"\s*\+?([0-9]+\.?[0-9]*|\.[0-9]+)\s*%\s*of\s*C\s*")
#: Units of speeds, angular speeds and times, as factors to SI; the SI unit first.
RATES = {
    "speed": {"m/s": 1.0, "mm/s": 1e-3, "um/s": 1e-6, "m/min": 1.0 / 60.0},
    "angular speed": {"rad/s": 1.0, "deg/s": pi / 180.0, "rps": 2.0 * pi, "rpm": pi / 30.0},
    "time": {"s": 1.0, "ms": 1e-3, "min": 60.0, "h": 3600.0},
}


@dataclass(frozen=True)
class Quantity:
    """Range of a quantity, ends as in a scene (``above``, ``below``: without that end), and an example."""

    dimension: str
    low: str | float
    high: str | float
    example: str | float
    above: bool = False
    below: bool = False

    @property
    def allowed(self) -> str:
        """The range as text: ``0.01 mm to 1 m``, ``above 0 deg, below 90 deg``."""
        if not (self.above or self.below):
            return f"{self.low} to {self.high}"
        low = f"{'above' if self.above else 'from'} {self.low}"
        return f"{low}, {'below' if self.below else 'up to'} {self.high}"

    @property
    def unit(self) -> str:
        """SI unit of its values."""
        return units.DIMENSIONS[self.dimension][0]

    def read(self, value: object) -> float:
        """SI value of ``value``; raises pydantic's error carrying ``allowed`` and ``advice``."""
        number, low, high = (self._number(v) for v in (value, self.low, self.high))
        too_low = number <= low if self.above else number < low
        if not too_low and (number < high if self.below else number <= high):
            return number
        advice = f"the value is too {'small' if too_low else 'large'}; a usual one is {units.show(self.example)}"
        raise self._refused(self.allowed, advice)

    def _number(self, value: object) -> float:
        """SI value in range or not; raises pydantic's error."""
        try:
            return units.parse(value, self.dimension)
        except units.UnitError as error:
            allowed = f"{units.expected(self.dimension).split(',')[0]}, {self.allowed}"
            raise self._refused(allowed, f"the value {error.reason}: {error.advice}") from None

    @staticmethod
    def _refused(allowed: str, advice: str) -> PydanticCustomError:
        return PydanticCustomError("quantity", "{advice}", {"allowed": allowed, "advice": advice})

    def __get_pydantic_core_schema__(self, _source: object, _handler: GetCoreSchemaHandler) -> Any:
        """Validate with ``read``."""
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, _schema: Any, _handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """A number, or text with a unit."""
        kind = "number" if self.dimension == "number" else "string"
        schema: dict[str, Any] = {"type": kind, "examples": [self.example]}
        schema |= {"x-dimension": self.dimension, "x-allowed": self.allowed}
        if kind == "number":
            low = "exclusiveMinimum" if self.above else "minimum"
            high = "exclusiveMaximum" if self.below else "maximum"
            return schema | {low: self.low, high: self.high}
        return schema | {"x-unit": self.unit, "pattern": r"^\s*[+-]?[0-9.].*\S$"}


@dataclass(frozen=True)
class ShareOfRating:
    """Part of the basic dynamic load rating C as computed [-]."""

    share: float


@dataclass(frozen=True)
class ForceOrShare(Quantity):
    """Range of a force, or of per cents of the dynamic load rating C: ``5 % of C``."""

    most: float = 50.0

    def read(self, value: object) -> float | ShareOfRating:  # type: ignore[override]
        """SI value, or the part of C; raises pydantic's error carrying ``allowed`` and ``advice``."""
        match = _OF_C.fullmatch(value) if isinstance(value, str) else None
        if match is None:
            return super().read(value)
        percent = float(match[1])
        if not 0.0 < percent <= self.most:
            advice = "makers preload with 3 to 8 % of C, and seldom with more than 10 %"
            raise self._refused(f"above 0, up to {self.most:g} % of C", advice)
        return ShareOfRating(percent / 100.0)

    @property
    def allowed(self) -> str:
        """The range as text."""
        return f'{super().allowed}, or e.g. "5 % of C"'


@dataclass(frozen=True)
class Rate(Quantity):
    """Range of a speed, an angular speed or a time."""

    @property
    def unit(self) -> str:
        """SI unit of its values."""
        return next(iter(RATES[self.dimension]))

    def _number(self, value: object) -> float:
        rates = RATES[self.dimension]
        parts = units.number_and_unit(value) if isinstance(value, str) else None
        unit = units.tidy(parts[1]) if parts else ""
        if parts is None or unit not in rates:
            advice = f"write a number and one of {', '.join(rates)}, e.g. {units.show(self.example)}"
            article = "an" if self.dimension[0] == "a" else "a"
            raise self._refused(f"{article} {self.dimension}, {self.allowed}", advice)
        return float(parts[0]) * rates[unit]


def key(description: str, default: Any = ..., example: Any = None) -> Any:
    """A key of the file. ``default`` is written as in a scene; without it the key is required."""
    examples = None if example is None else [example]
    return Field(default=default, description=description, examples=examples)
