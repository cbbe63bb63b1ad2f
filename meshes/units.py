"""Convert quantities written as text (``"20 mm"``, ``"5 kN"``) to numbers in SI units.

The text is a number followed by a unit; expressions are not evaluated. A unit is an entry of a table, with or without a
prefix, or a product or quotient of such units. Conversion factors are exact decimals.
"""

from __future__ import annotations

import math
import re
from decimal import Decimal
from functools import lru_cache

#: Common units of each dimension, which error messages suggest, and an example of a quantity as written in a scene file;
#: the first unit is the SI unit.
DIMENSIONS: dict[str, tuple[tuple[str, ...], str]] = {
    "length": (("m", "cm", "mm", "um", "nm", "in", "inch", "thou"), "20 mm"),
    "force": (("N", "kN", "MN", "lbf"), "5 kN"),
    "pressure": (("Pa", "kPa", "MPa", "GPa", "psi"), "210 GPa"),
    "angle": (("rad", "mrad", "deg"), "45 deg"),
    "moment": (("N m", "N mm", "kN m", "lbf in"), "3 N m"),
    "stiffness": (("N/m", "N/mm", "N/um", "lbf/in"), "200 N/um"),
    "temperature difference": (("K", "degF"), "5 K"),
    "speed": (("m/s", "mm/s", "um/s", "m/min"), "10 mm/s"),
    "angular speed": (("rad/s", "deg/s", "rps", "rpm"), "600 rpm"),
    "time": (("s", "ms", "min", "h"), "1 s"),
    "kinematic viscosity": (("m2/s", "mm2/s", "cSt"), "27 mm2/s"),
    "density": (("kg/m3", "g/cm3"), "900 kg/m3"),
    "pressure coefficient": (("1/Pa", "1/GPa"), "20 1/GPa"),
    "mass": (("kg", "g", "t", "lb"), "200 kg"),
    "moment of inertia": (("kg m2", "kg cm2", "kg mm2", "lb in2"), "20 kg cm2"),
    "number": ((), "0.28"),
}

_PI = "3.14159265358979323846264338328"
#: Units of each dimension, which may have a prefix or be part of a product: their names, and the exact factor to the SI
#: unit, a decimal or a quotient of two decimals. A plain number of degrees is converted by ``math.radians``.
_TABLE = {
    "length": {
        "m meter metre": "1",
        "in inch inches": "0.0254",
        "ft foot feet": "0.3048",
        "yd yard": "0.9144",
        "mi mile": "1609.344",
        "nmi nautical_mile": "1852",
        "th thou": "0.0000254",
        "µ micron": "1e-6",
        "Å angstrom": "1e-10",
    },
    "mass": {
        "g gram": "1e-3",
        "t tonne metric_ton": "1e3",
        "lb pound": "0.45359237",
        "oz ounce": "0.45359237/16",
        "slug": "4.4482216152605/0.3048",
        "slinch blob": "4.4482216152605/0.0254",
    },
    "time": {"s sec second": "1", "min minute": "60", "h hr hour": "3600"},
    "force": {
        "N newton": "1",
        "dyn dyne": "1e-5",
        "gf gram_force pond": "9.80665e-3",
        "kgf kilogram_force force_kilogram": "9.80665",
        "tf metric_ton_force": "9806.65",
        "lbf pound_force force_pound": "4.4482216152605",
        "ozf ounce_force": "4.4482216152605/16",
        "kip": "4448.2216152605",
        "pdl poundal": "0.138254954376",
    },
    "pressure": {
        "Pa pascal": "1",
        "bar": "1e5",
        "atm atmosphere": "101325",
        "at technical_atmosphere": "98066.5",
        "torr": "101325/760",
        "mHg": "133322.387415",
        "inHg": "3386.388640341",
        "psi": "4.4482216152605/0.00064516",
        "ksi": "4448.2216152605/0.00064516",
    },
    "angle": {
        "rad radian": "1",
        "deg degree arcdeg": f"{_PI}/180",
        "arcmin arcminute": f"{_PI}/10800",
        "arcsec arcsecond": f"{_PI}/648000",
        "gon grad grade gradian": f"{_PI}/200",
        "turn revolution cycle circle": f"{_PI}/0.5",
    },
    "angular speed": {"rps": f"{_PI}/0.5", "rpm": f"{_PI}/30"},
    "kinematic viscosity": {"St stokes": "1e-4"},
    "moment": {"J joule": "1", "erg": "1e-7", "ft_lb foot_pound": "1.3558179483314004"},
    "temperature difference": {
        "K kelvin degK": "1",
        "degC celsius °C delta_degC": "1",
        "degF fahrenheit °F delta_degF": "5/9",
        "degR rankine": "5/9",
    },
}
#: Dimension of each unit, and its conversion factor to the SI unit, by each name of the unit.
UNITS = {name: (of, factor) for of, units in _TABLE.items() for names, factor in units.items() for name in names.split()}
#: Exponent of ten for each prefix, by its symbol and its name.
PREFIXES = {"": 0, "p": -12, "n": -9, "u": -6, "µ": -6, "m": -3, "c": -2, "d": -1}
PREFIXES |= {"da": 1, "h": 2, "k": 3, "M": 6, "G": 9, "T": 12}
PREFIXES |= {"pico": -12, "nano": -9, "micro": -6, "milli": -3, "centi": -2, "deci": -1, "deca": 1, "hecto": 2}
PREFIXES |= {"kilo": 3, "mega": 6, "giga": 9, "tera": 12}
#: Dimension, factor and exponent of ten of each unit with and without a prefix; the first of `PREFIXES` counts, so that
#: "min" is a minute and no milli-inch.
_PREFIXED = {p + name: (*unit, tens) for p, tens in reversed(PREFIXES.items()) for name, unit in UNITS.items()}
#: Exponents of m, kg, s, rad and K in the SI unit of each dimension.
_POWERS = {
    "length": (1, 0, 0, 0, 0),
    "mass": (0, 1, 0, 0, 0),
    "time": (0, 0, 1, 0, 0),
    "force": (1, 1, -2, 0, 0),
    "pressure": (-1, 1, -2, 0, 0),
    "angle": (0, 0, 0, 1, 0),
    "moment": (2, 1, -2, 0, 0),
    "stiffness": (0, 1, -2, 0, 0),
    "temperature difference": (0, 0, 0, 0, 1),
    "speed": (1, 0, -1, 0, 0),
    "angular speed": (0, 0, -1, 1, 0),
    "kinematic viscosity": (2, 0, -1, 0, 0),
    "density": (-3, 1, 0, 0, 0),
    "pressure coefficient": (1, -1, 2, 0, 0),
    "moment of inertia": (2, 1, 0, 0, 0),
}

_NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,4})?"
_QUANTITY = re.compile(rf"({_NUMBER})\s*(\S.*)?")
_FACTOR = re.compile(r"([A-Za-zµ°Å_]+)(?:(?:\^|\*\*)?(-?[1-9]))?")
_COMMA = re.compile(r"\s*[+-]?[0-9.]*[0-9],[0-9]")
#: Largest number of characters of a text that is read as a quantity.
_LONGEST = 64
_UNDERSCORE = re.compile(r"\s*[+-]?[0-9][0-9.]*_[0-9_]")
_FORTRAN = re.compile(r"\s*[+-]?(?:[0-9.]+[dDqQ][+-]?[0-9]|[0-9]*\.[0-9]*[+-][0-9]{3})")
_MIL = re.compile(r"(?<![A-Za-z])mils?(?![A-Za-z])")
#: Advice in error messages about a number that is written with a comma, an underscore, or an exponent as in Fortran.
COMMA = "is it a decimal comma? write a point, and nothing between thousands"
UNDERSCORE = "leave the underscore out: nothing stands between thousands"
FORTRAN = "is it an exponent as Fortran writes it, with D or without a letter? write E, such as 1.5E+03"
#: Advice in error messages about the unit mil, a length in the USA and an angle elsewhere.
MIL = "mil has two meanings: write thou for 0.001 inch, and mrad for an angle"


class UnitError(ValueError):
    """Error for a text that is not a quantity of the required dimension, such as a length without unit.

    The attributes ``reason`` (such as "has no unit") and ``advice`` are parts of the message.
    """

    def __init__(self, value: object, dimension: str, reason: str, advice: str = "") -> None:
        """Compose the message from the faulty value, the reason, the required dimension and the advice to the user."""
        self.reason = reason
        self.advice = advice or f"write a number and a unit, e.g. {example_quantity(dimension)}"
        super().__init__(f"{toml_text(value)} {reason}; expected {dimension_description(dimension)}; {self.advice}")


def dimension_description(dimension: str) -> str:
    """Return the name of a dimension with an article, and an example of a quantity.

    Parameters
    ----------
    dimension
        Name of the dimension, such as ``"length"``.

    Examples
    --------
    >>> dimension_description("length")
    'a length, e.g. "20 mm"'
    """
    article = "an" if dimension[0] in "aeiou" else "a"
    return f"{article} {dimension}, e.g. {example_quantity(dimension)}"


def example_quantity(dimension: str) -> str:
    """Return an example of a quantity as written in a scene file: in quotes if it has a unit.

    Examples
    --------
    >>> example_quantity("pressure"), example_quantity("number")
    ('"210 GPa"', '0.28')
    """
    units, text = DIMENSIONS[dimension]
    return f'"{text}"' if units else text


def toml_text(value: object) -> str:
    """Return a value as it is written in a TOML file: text in quotes, booleans in lower case, other values by ``str``.

    Parameters
    ----------
    value
        Value as read from TOML.

    Examples
    --------
    >>> toml_text(["5 kN", True, 3])
    '["5 kN", true, 3]'
    """
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list):
        return "[" + ", ".join(toml_text(v) for v in value) + "]"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{k} = {toml_text(v)}" for k, v in value.items()) + " }"
    return str(value)


def parse_quantity(value: object, dimension: str) -> float:
    """Convert a quantity written as text to its value in SI units.

    The conversion is exact and rounded only once: ``parse_quantity("3.254 mm", "length") == 3.254e-3``.

    Parameters
    ----------
    value : object
        Text with a number and a unit; a plain number for ``dimension = "number"``.
    dimension : str
        Required dimension, one of `DIMENSIONS`.

    Returns
    -------
    float
        Value in m, N, Pa, rad, N m, N/m or K, or the plain number.

    Raises
    ------
    UnitError
        The unit is missing, unknown or of another dimension; the text does not begin with a plain number; or the number is
        not finite.

    Examples
    --------
    >>> parse_quantity("20 mm", "length"), parse_quantity("5 kN", "force"), parse_quantity("200 N/um", "stiffness")
    (0.02, 5000.0, 200000000.0)
    >>> parse_quantity("2 lbf in", "moment"), parse_quantity("45 deg", "angle")
    (0.2259696580552334, 0.7853981633974483)
    """
    if dimension != "number":
        if isinstance(value, str):
            return _parse_text_cached(value, dimension)
        missing = isinstance(value, (int, float)) and not isinstance(value, bool)
        raise UnitError(value, dimension, "has no unit" if missing else "is not text")
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        advice = "write a number without quotes or unit"
        advice = number_advice(value, advice) if isinstance(value, str) else advice
        raise UnitError(value, "number", "is not a plain number", advice)
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise UnitError(value, "number", "is not finite", "write a finite number")
    return number


@lru_cache(maxsize=1024)
def _parse_text_cached(value: str, dimension: str) -> float:
    """Convert a text to its value in SI units, as `parse_quantity` does; results are stored, because texts occur often."""
    if _COMMA.match(value):
        raise UnitError(value, dimension, "has a comma in its number", COMMA)
    parts = split_quantity_text(value)
    if parts is None:
        if re.match(r"[+-]?(nan|inf)", value.strip(), re.IGNORECASE):
            advice = f"write a finite number, e.g. {example_quantity(dimension)}"
            raise UnitError(value, dimension, "is not finite", advice)
        raise UnitError(value, dimension, "does not begin with a plain number")
    number, unit = Decimal(parts[0]), standard_unit_spelling(parts[1])
    if not unit:
        raise UnitError(value, dimension, "has no unit")
    kind, above, below = _unit_factor(unit)
    if kind != dimension:
        if kind:
            raise UnitError(value, dimension, f"is {dimension_description(kind).split(',')[0]}")
        advice = number_advice(value, MIL if _MIL.search(unit) else _nearest_unit_advice(unit, dimension))
        raise UnitError(value, dimension, "has an unknown unit", advice)
    result = math.radians(float(number)) if unit == "deg" else float(number * above / below)
    if not math.isfinite(result):
        raise UnitError(value, dimension, "is too large for a floating-point number")
    return result


def split_quantity_text(text: str) -> tuple[str, str] | None:
    """Split the text of a quantity into its number and its unit, both as written.

    Parameters
    ----------
    text : str
        Text of the quantity.

    Returns
    -------
    tuple[str, str] | None
        Number and unit; an empty unit where the text has none. None where the text is not a quantity.

    Examples
    --------
    >>> split_quantity_text("3.5e-3 N/um"), split_quantity_text("12"), split_quantity_text("mm")
    (('3.5e-3', 'N/um'), ('12', ''), None)
    """
    text = text.strip()
    match = _QUANTITY.fullmatch(text) if len(text) <= _LONGEST else None
    return None if match is None else (match[1], match[2] or "")


def has_comma_in_number(text: str) -> bool:
    """Return whether a text begins with a number that has a comma, before decimals or between thousands.

    Parameters
    ----------
    text
        Text of a quantity.

    Examples
    --------
    >>> has_comma_in_number("3,254 mm"), has_comma_in_number("3.254 mm")
    (True, False)
    """
    return _COMMA.match(text) is not None


def number_of_text(text: str) -> float:
    """Return the number that a text is: decimal digits with or without sign, point and exponent; nan for any other text.

    Parameters
    ----------
    text
        Text, such as a cell of a file.

    Examples
    --------
    >>> [number_of_text(text) for text in ("1000", " -1.5E+03 ", "1_000", "1.5D+03", "nan")]
    [1000.0, -1500.0, nan, nan, nan]
    """
    text = text.strip()
    return float(text) if re.fullmatch(_NUMBER, text) else math.nan


def number_advice(text: str, advice: str) -> str:
    """Return advice for a text that should begin with a number, on what is wrong with the way in which that is written.

    Parameters
    ----------
    text
        Text that cannot be read.
    advice
        Advice where the text has no decimal comma, no underscore and no exponent as in Fortran.

    Examples
    --------
    >>> number_advice("489,5", "write a number"), number_advice("x", "write a number")
    ('is it a decimal comma? write a point, and nothing between thousands', 'write a number')
    """
    known = ((_COMMA, COMMA), (_UNDERSCORE, UNDERSCORE), (_FORTRAN, FORTRAN))
    return next((found for pattern, found in known if pattern.match(text)), advice)


def standard_unit_spelling(unit: str) -> str:
    """Return a unit in standard spelling: "u" for micro, "deg" for degrees, and products with a space.

    Parameters
    ----------
    unit
        Unit as written by a user.

    Examples
    --------
    >>> [standard_unit_spelling(x) for x in ("Nmm", "N*m", "µm", "in-lbf")]
    ['N mm', 'N m', 'um', 'lbf in']
    """
    unit = re.sub(r"\s*(?:(?<!\*)\*(?!\*)|·|\s)\s*", " ", unit.replace("μ", "µ").strip())
    unit = {"µm": "um", "°": "deg", "N/µm": "N/um", "°F": "degF"}.get(unit, unit)
    unit = {"in-lbf": "lbf in", "lbf-in": "lbf in", "in lbf": "lbf in"}.get(unit, unit)
    return re.sub(r"^(k|M)?N(mm|m)$", lambda m: f"{m[1] or ''}N {m[2]}", unit)


@lru_cache(maxsize=256)
def _unit_factor(unit: str) -> tuple[str, Decimal, Decimal]:
    """Return dimension and conversion factor to SI units of a single unit, or of a product or quotient of units.

    The factor is returned as numerator and denominator.
    """
    above, below = Decimal(1), Decimal(1)
    powers: tuple[int, ...] = (0,) * 5
    for i, product in enumerate(re.split(r"\s*/\s*", unit)):
        for name in [] if product == "1" else product.split() or [""]:  # 1/Pa
            match = _FACTOR.fullmatch(name)
            found = match and (_PREFIXED.get(match[1]) or _PREFIXED.get(match[1].removesuffix("s")))
            if not match or not found:
                return "", above, below
            of, factor, tens = found
            over, under = Decimal(factor.partition("/")[0]).scaleb(tens), Decimal(factor.partition("/")[2] or 1)
            power = int(match[2] or 1) * (-1 if i else 1)
            powers = tuple(p + power * q for p, q in zip(powers, _POWERS[of], strict=True))
            if power < 0:
                over, under = under, over
            above, below = above * over ** abs(power), below * under ** abs(power)
    return next((of for of in DIMENSIONS if _POWERS.get(of) == powers), ""), above, below


def _nearest_unit_advice(unit: str, dimension: str) -> str:
    """Return advice on the unknown unit ``unit``: the most similar common unit of the dimension, or all common units."""
    import difflib

    known, _ = DIMENSIONS[dimension]
    folded = [u for u in known if u.lower() == unit.lower()]
    near = folded or difflib.get_close_matches(unit, known, n=1, cutoff=0.6)
    return f'did you mean "{near[0]}"?' if near else f"use one of {', '.join(known)}"
