"""Quantities as text (``"20 mm"``, ``"5 kN"``) to SI numbers.

Only a number followed by a unit is read: nothing is evaluated. Common units come from a table; pint, which is
slow to import, is asked only about the others.
"""

from __future__ import annotations

import math
import re
from decimal import Decimal
from functools import lru_cache
from typing import Any

#: What each dimension is called, its SI unit, and an example.
DIMENSIONS = {
    "length": ("m", "20 mm"),
    "force": ("N", "5 kN"),
    "pressure": ("Pa", "210 GPa"),
    "angle": ("rad", "45 deg"),
    "moment": ("N m", "3 N m"),
    "stiffness": ("N/m", "200 N/um"),
    "temperature difference": ("K", "5 K"),
    "number": ("", "0.28"),
}

#: By dimension, units with their factor to SI as exact decimal text or fraction; degrees are turned by ``math.radians``.
_FACTORS = {
    "length": {"m": "1", "cm": "1e-2", "mm": "1e-3", "um": "1e-6", "nm": "1e-9", "in": "0.0254", "inch": "0.0254"},
    "force": {"N": "1", "kN": "1e3", "MN": "1e6", "lbf": "4.4482216152605"},
    "pressure": {"Pa": "1", "kPa": "1e3", "MPa": "1e6", "GPa": "1e9", "psi": "4.4482216152605/0.00064516"},
    "angle": {"rad": "1", "mrad": "1e-3", "deg": "deg"},
    "moment": {"N m": "1", "N mm": "1e-3", "kN m": "1e3", "lbf in": "0.1129848290276167"},
    "stiffness": {"N/m": "1", "N/mm": "1e3", "N/um": "1e6", "lbf/in": "4.4482216152605/0.0254"},
    "temperature difference": {"K": "1", "degF": "5/9"},
}
#: Dimension and factor of each unit.
COMMON = {unit: (of, factor) for of, factors in _FACTORS.items() for unit, factor in factors.items()}

_RADIAN = "radian"
_BASE = {  # pint's base units of each dimension
    "length": {"meter": 1},
    "force": {"kilogram": 1, "meter": 1, "second": -2},
    "pressure": {"kilogram": 1, "meter": -1, "second": -2},
    "angle": {_RADIAN: 1},
    "moment": {"kilogram": 1, "meter": 2, "second": -2},
    "stiffness": {"kilogram": 1, "second": -2},
    "temperature difference": {"kelvin": 1},
}

_NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,4})?"
_QUANTITY = re.compile(rf"({_NUMBER})\s*(\S.*)?")
_FACTOR = re.compile(r"([A-Za-zµ°Å_]+)(?:(?:\^|\*\*)?(-?[1-9]))?")
_COMMA = re.compile(r"\s*[+-]?[0-9.]*[0-9],[0-9]")
_LONGEST = 64
#: Advice on a number with a comma.
COMMA = "is it a decimal comma? write a point, and nothing between thousands"


class UnitError(ValueError):
    """A text is not a quantity of the dimension asked for; ``reason`` and ``advice`` are half-sentences."""

    def __init__(self, value: object, dimension: str, reason: str, advice: str = "") -> None:
        """Compose the message from value, reason, what was expected and advice."""
        self.reason = reason
        self.advice = advice or f"write a number and a unit, e.g. {example(dimension)}"
        super().__init__(f"{show(value)} {reason}; expected {expected(dimension)}; {self.advice}")


def expected(dimension: str) -> str:
    """What is expected, with an example: ``a length, e.g. "20 mm"``."""
    article = "an" if dimension[0] in "aeiou" else "a"
    return f"{article} {dimension}, e.g. {example(dimension)}"


def example(dimension: str) -> str:
    """An example as it stands in a scene file: in quotes where it has a unit."""
    unit, text = DIMENSIONS[dimension]
    return f'"{text}"' if unit else text


def show(value: object) -> str:
    """A value as it stands in a TOML file: text in quotes, booleans in lower case, the rest by ``str``."""
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list):
        return "[" + ", ".join(show(v) for v in value) + "]"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{k} = {show(v)}" for k, v in value.items()) + " }"
    return str(value)


def parse(value: object, dimension: str) -> float:
    """Quantity ``value`` in SI units (m, N, Pa, rad, N m, N/m, K, or a plain number for ``dimension = "number"``).

    The conversion is done in decimal and rounded once: ``parse("3.254 mm", "length") == 3.254e-3``.
    Raises UnitError for a missing or unknown unit, another dimension, anything but a plain number before
    the unit, and a number that is not finite.

    >>> parse("20 mm", "length")
    0.02
    """
    if dimension == "number":
        return _plain(value)
    if isinstance(value, bool) or not isinstance(value, str):
        missing = isinstance(value, (int, float)) and not isinstance(value, bool)
        raise UnitError(value, dimension, "has no unit" if missing else "is not text")
    return _of_text(value, dimension)


@lru_cache(maxsize=1024)
def _of_text(value: str, dimension: str) -> float:
    """`parse` of a text: ends of ranges are read with every value, and a sweep reads one scene again and again."""
    number, unit = _split(value, dimension)
    if not unit:
        raise UnitError(value, dimension, "has no unit")
    if unit in COMMON:
        kind, factor = COMMON[unit]
    else:
        kind, factor = _ask_pint(unit)
    if kind != dimension:
        if kind:
            raise UnitError(value, dimension, f"is {expected(kind).split(',')[0]}")
        raise UnitError(value, dimension, "has no such unit", _nearest(unit, dimension))
    result = math.radians(float(number)) if factor == "deg" else _scaled(number, factor)
    if not math.isfinite(result):
        raise UnitError(value, dimension, "is too large to be a number")
    return result


def _scaled(number: Decimal, factor: str) -> float:
    """Number times a factor of the table, rounded once."""
    above, _, below = factor.partition("/")
    return float(number * Decimal(above) / Decimal(below or "1"))


def _plain(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        advice = COMMA if isinstance(value, str) and has_comma(value) else "write a number without quotes or unit"
        raise UnitError(value, "number", "is not a plain number", advice)
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise UnitError(value, "number", "is not finite", "write a finite number")
    return number


def number_and_unit(text: str) -> tuple[str, str] | None:
    """Number and unit of a quantity as written, the unit empty where there is none; None where the text is no quantity."""
    text = text.strip()
    match = _QUANTITY.fullmatch(text) if len(text) <= _LONGEST else None
    return None if match is None else (match[1], match[2] or "")


def has_comma(text: str) -> bool:
    """Whether a text begins with a number that has a comma: of decimals, or between thousands."""
    return _COMMA.match(text) is not None


def _split(value: str, dimension: str) -> tuple[Decimal, str]:
    """Number and tidied unit; raises UnitError if the text does not begin with a plain finite number."""
    if has_comma(value):
        raise UnitError(value, dimension, "has a comma in its number", COMMA)
    parts = number_and_unit(value)
    if parts is None:
        if re.match(r"[+-]?(nan|inf)", value.strip(), re.IGNORECASE):
            advice = f"write a finite number, e.g. {example(dimension)}"
            raise UnitError(value, dimension, "is not finite", advice)
        raise UnitError(value, dimension, "does not begin with a plain number")
    return Decimal(parts[0]), tidy(parts[1])


def tidy(unit: str) -> str:
    """One spelling per unit: micro, degree, products by a space (``N*m``, ``Nm``: ``N m``; ``in-lbf``: ``lbf in``)."""
    unit = re.sub(r"\s*(?:(?<!\*)\*(?!\*)|·|\s)\s*", " ", unit.replace("μ", "µ").strip())
    unit = {"µm": "um", "°": "deg", "N/µm": "N/um", "°F": "degF"}.get(unit, unit)
    unit = {"in-lbf": "lbf in", "lbf-in": "lbf in", "in lbf": "lbf in"}.get(unit, unit)
    return re.sub(r"^(k|M)?N(mm|m)$", lambda m: f"{m[1] or ''}N {m[2]}", unit)


@lru_cache(maxsize=1)
def _registry() -> Any:
    import pint

    return pint.UnitRegistry()


@lru_cache(maxsize=256)
def _ask_pint(unit: str) -> tuple[str, str]:
    """Dimension ("" if none here) and factor to SI of a product or quotient of units, each known to pint."""
    registry = _registry()
    factor = 1.0
    powers: dict[str, float] = {}
    for i, product in enumerate(re.split(r"\s*/\s*", unit)):
        for name in product.split() or [""]:
            match = _FACTOR.fullmatch(name)
            if match is None:
                return "", "1"
            power = int(match[2] or 1) * (-1 if i else 1)
            try:
                scale, base = registry.get_base_units(registry.parse_units(match[1]), check_nonmult=True)
            except Exception:  # undefined, logarithmic or offset units: pint raises several kinds
                return "", "1"
            factor *= float(scale) ** power
            for key, value in dict(base._units).items():
                powers[key] = powers.get(key, 0.0) + power * float(value)
    kept = {k: v for k, v in powers.items() if v != 0.0}
    for dimension, base_units in _BASE.items():
        if kept == base_units:
            return dimension, repr(factor)
    return "", "1"


def _nearest(unit: str, dimension: str) -> str:
    """Advice naming the nearest common unit of the dimension, or all of them."""
    import difflib

    known = [u for u, (d, _) in COMMON.items() if d == dimension]
    folded = [u for u in known if u.lower() == unit.lower()]
    near = folded or difflib.get_close_matches(unit, known, n=1, cutoff=0.6)
    return f'did you mean "{near[0]}"?' if near else f"use one of {', '.join(known)}"
