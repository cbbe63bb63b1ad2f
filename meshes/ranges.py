"""Annotated types for the quantities of scene files: dimension, allowed range, unit and example.

pydantic validates scene files with them; they also give the JSON schema, and the units in which scenes are written.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from decimal import Decimal
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args

from rollbench.meshes import units

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic_core import PydanticCustomError

_OF_C = re.compile(r"\s*\+?([0-9]+\.?[0-9]*|\.[0-9]+)\s*%\s*of\s*C\s*")


@dataclass(frozen=True)
class QuantityRange:
    """Physical dimension and allowed range of a quantity in scene files; used to annotate the type of a field."""

    #: Dimension, one of `meshes.units.DIMENSIONS`.
    dimension: str
    #: Lower limit, as written in a scene file.
    lower_limit: str | float
    #: Upper limit, as written in a scene file.
    upper_limit: str | float
    #: Typical value as written in a scene file; scenes are written with its unit.
    example: str | float
    #: Whether the lower limit is excluded.
    lower_limit_excluded: bool = False
    #: Whether the upper limit is excluded.
    upper_limit_excluded: bool = False

    @property
    def allowed_range_text(self) -> str:
        """Allowed range as text, for error messages.

        Examples
        --------
        >>> quantity_of_type(ContactAngle).allowed_range_text
        'above 0 deg, below 90 deg'
        """
        if not (self.lower_limit_excluded or self.upper_limit_excluded):
            return f"{self.lower_limit} to {self.upper_limit}"
        low = f"{'above' if self.lower_limit_excluded else 'from'} {self.lower_limit}"
        return f"{low}, {'below' if self.upper_limit_excluded else 'up to'} {self.upper_limit}"

    @property
    def unit(self) -> str:
        """SI unit of the quantity; empty for plain numbers."""
        return next(iter(units.DIMENSIONS[self.dimension][0]), "")

    def si_value(self, value: object) -> float:
        """Convert a value of a scene file to SI units, and check that it is in the allowed range.

        Parameters
        ----------
        value : object
            Text with a unit; a plain number where the quantity has no unit.

        Returns
        -------
        float
            Value in SI units.

        Raises
        ------
        PydanticCustomError
            The value is not a quantity of this dimension, or is out of range; the error holds two texts, ``allowed``
            (range) and ``advice``.

        Examples
        --------
        >>> quantity_of_type(Size).si_value("32 mm")
        0.032
        """
        number, low, high = (self._si_value_without_check(v) for v in (value, self.lower_limit, self.upper_limit))
        too_low = number <= low if self.lower_limit_excluded else number < low
        if not too_low and (number < high if self.upper_limit_excluded else number <= high):
            return number
        advice = f"the value is too {'small' if too_low else 'large'}; a typical value is {units.toml_text(self.example)}"
        raise self._refused_value_error(self.allowed_range_text, advice)

    def _si_value_without_check(self, value: object) -> float:
        """Convert a value to SI units without checking its range; raise pydantic's error for another dimension or unit."""
        try:
            return units.parse_quantity(value, self.dimension)
        except units.UnitError as error:
            allowed = f"{units.dimension_description(self.dimension).split(',')[0]}, {self.allowed_range_text}"
            raise self._refused_value_error(allowed, f"the value {error.reason}: {error.advice}") from None

    def text_with_unit(self, value: float, added_offset: float = 0.0) -> str | float:
        """Return the shortest text, in the unit of the field ``example``, from which exactly the same value is read.

        Parameters
        ----------
        value : float
            Value in SI units.
        added_offset : float, default 0.0
            Offset in SI units that is added to the value after reading. The text is the shortest one for which the sum is
            exact.

        Returns
        -------
        str | float
            Text, or the number itself where the quantity has no unit.

        Examples
        --------
        >>> quantity_of_type(Size).text_with_unit(0.032), quantity_of_type(Force).text_with_unit(250.0)
        ('32 mm', '250 N')
        """
        if self.dimension == "number":
            return value
        _, unit = units.split_quantity_text(str(self.example)) or ("", "")
        number = value / self._si_value_without_check(f"1 {unit}")
        if unit.startswith("kN") and abs(number) < 1.0:
            unit, number = unit[1:], 1e3 * number
        for digits in range(1, 18):
            text = f"{Decimal(f'{number:.{digits}g}'):f} {unit}"
            if added_offset + self._si_value_without_check(text) == added_offset + value:
                return text
        si_value_of_unit = self._si_value_without_check(f"1 {unit}")  # exact: decimal factor
        text = f"{Decimal(repr(float(value))) / Decimal(repr(si_value_of_unit))} {unit}"
        return text if self._si_value_without_check(text) == value else f"{float(value)!r} {self.unit}"

    @staticmethod
    def _refused_value_error(allowed: str, advice: str) -> PydanticCustomError:
        """Return pydantic's error for a refused value; ``allowed``: allowed range; ``advice``: advice to the user."""
        from pydantic_core import PydanticCustomError

        return PydanticCustomError("quantity", "{advice}", {"allowed": allowed, "advice": advice})

    def __get_pydantic_core_schema__(self, _source: object, _handler: GetCoreSchemaHandler) -> Any:
        """Return pydantic's schema, which validates a value by `si_value`."""
        from pydantic_core import core_schema

        return core_schema.no_info_plain_validator_function(self.si_value)

    def __get_pydantic_json_schema__(self, _schema: Any, _handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Return the JSON schema of the quantity: a number, or text with a unit."""
        kind = "number" if self.dimension == "number" else "string"
        schema: dict[str, Any] = {"type": kind, "examples": [self.example]}
        schema |= {"x-dimension": self.dimension, "x-allowed": self.allowed_range_text}
        if kind == "number":
            low = "exclusiveMinimum" if self.lower_limit_excluded else "minimum"
            high = "exclusiveMaximum" if self.upper_limit_excluded else "maximum"
            return schema | {low: self.lower_limit, high: self.upper_limit}
        return schema | {"x-unit": self.unit, "pattern": r"^\s*[+-]?[0-9.].*\S$"}


@dataclass(frozen=True)
class ShareOfLoadRating:
    """Force that a scene file states as a fraction of the basic dynamic load rating C."""

    #: Ratio of the force to C.
    share: float


@dataclass(frozen=True)
class ForceOrRatingShareRange(QuantityRange):
    """Allowed range of a force that may also be stated in per cent of the dynamic load rating C, as ``5 % of C``."""

    #: Largest allowed percentage of C.
    largest_percentage: float = 50.0

    def si_value(self, value: object) -> float | ShareOfLoadRating:  # type: ignore[override]
        """Convert a force as written in a scene file to N, or to a fraction of the dynamic load rating C.

        Arguments and errors are those of `QuantityRange.si_value`.

        Examples
        --------
        >>> ForceOrRatingShareRange("force", "0 N", "1 MN", "5 kN").si_value("5 % of C")
        ShareOfLoadRating(share=0.05)
        """
        match = _OF_C.fullmatch(value) if isinstance(value, str) else None
        if match is None:
            return super().si_value(value)
        percent = float(match[1])
        if not 0.0 < percent <= self.largest_percentage:
            advice = "give a value that manufacturers use: 3 to 8 % of C, seldom more than 10 %"
            allowed = f"above 0, up to {self.largest_percentage:g} % of C, the dynamic load rating"
            raise self._refused_value_error(allowed, advice)
        return ShareOfLoadRating(percent / 100.0)

    @property
    def allowed_range_text(self) -> str:
        """Allowed range as text, for error messages."""
        return f'{super().allowed_range_text}, or e.g. "5 % of C"'


@dataclass(frozen=True)
class Plain:
    """Whole number, text, or true or false in scene files, which is read as it stands; used to annotate a field's type."""

    #: Kind of the value, by pydantic's name.
    kind: Literal["int", "str", "bool"]
    #: Smallest and largest number, or number of characters of a text; None: any.
    low: int | None = None
    high: int | None = None

    def __get_pydantic_core_schema__(self, _source: object, _handler: GetCoreSchemaHandler) -> Any:
        """Return pydantic's schema."""
        low, high = ("ge", "le") if self.kind == "int" else ("min_length", "max_length")
        limits = {name: limit for name, limit in ((low, self.low), (high, self.high)) if limit is not None}
        return {"type": self.kind, "strict": True} | limits


@dataclass(frozen=True)
class ListLength:
    """Allowed number of entries of a list in scene files, which is read as a tuple; used to annotate a field's type."""

    #: Smallest number of entries.
    low: int
    #: Largest number of entries.
    high: int

    def __get_pydantic_core_schema__(self, source: object, handler: GetCoreSchemaHandler) -> Any:
        """Return pydantic's schema, which validates a list and converts it to a tuple."""
        from pydantic_core import core_schema

        items = handler.generate_schema(get_args(source)[0])
        return core_schema.tuple_variable_schema(items, min_length=self.low or None, max_length=self.high, strict=False)


@dataclass(frozen=True)
class OneKeyNeeded:
    """Table of scene files that must state a key of its class attribute ``ONE_OF``; used to annotate the table's type."""

    #: Number of other keys that the table must have.
    others: int = 0

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> Any:
        """Return pydantic's schema, which refuses a table without any of the keys."""
        from pydantic_core import PydanticCustomError, core_schema

        keys: tuple[str, ...] = source.ONE_OF

        def checked(table: Any, validate: Any) -> Any:
            """Return the validated table; pydantic's error if it states none of the keys."""
            found = validate(table)
            if isinstance(table, dict) and not table.keys() & {*keys}:
                allowed = f"a table with {' or '.join((', '.join(keys[:-1]), keys[-1]))}"
                advice = f"add {keys[0]}, or delete the table: without these keys it does nothing"
                raise PydanticCustomError("quantity", "{advice}", {"allowed": allowed, "advice": advice})
            return found

        return core_schema.no_info_wrap_validator_function(checked, handler(source))

    def __get_pydantic_json_schema__(self, schema: Any, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Return the JSON schema of the table, with one key more than those that it must have."""
        return handler(schema) | {"minProperties": self.others + 1}


def quantity_of_type(annotated_type: Any) -> QuantityRange:
    """Return dimension and allowed range of an annotated type such as `Size`.

    Parameters
    ----------
    annotated_type : Any
        Annotated type with a `QuantityRange`.

    Returns
    -------
    QuantityRange
        Dimension and allowed range.
    """
    found: QuantityRange = get_args(annotated_type)[1]
    return found


#: Largest number of balls that a scene may have.
MAX_BALLS = 100_000

#: A key that is true or false; a text of one line or sentence, the name of a nut, bearing or housing, a
#: text that may be empty, and a list of sentences.
Switch = Annotated[bool, Plain("bool")]
Sentence = Annotated[str, Plain("str", 1, 2000)]
Name = Annotated[str, Plain("str", 1, 60)]
Words = Annotated[str, Plain("str", None, 2000)]
Sentences = Annotated[tuple[Sentence, ...], ListLength(0, 100)]
#: Numbers of balls or rollers, of starts of a thread, of specimens with random errors; seed of random errors.
Count = Annotated[int, Plain("int", 1, MAX_BALLS)]
Starts = Annotated[int, Plain("int", 1, 100)]
Slices = Annotated[int, Plain("int", 1, 200)]
Circuits = Annotated[int, Plain("int", 1, 1000)]
Members = Annotated[int, Plain("int", 1, 100_000)]
Seed = Annotated[int, Plain("int", 0, 2**63 - 1)]

#: Types of lengths: a dimension of a part, a radius of groove, ball or pitch circle, a diameter that may be zero, and an
#: axial position.
Size = Annotated[float, QuantityRange("length", "0.01 mm", "100 m", "20 mm")]
Radius = Annotated[float, QuantityRange("length", "0.01 mm", "1 m", "2.778 mm")]
Bore = Annotated[float, QuantityRange("length", "0 mm", "100 m", "10 mm")]
Station = Annotated[float, QuantityRange("length", "0 mm", "100 m", "400 mm")]
#: Lead of a helix; zero for a bearing.
Lead = Annotated[float, QuantityRange("length", "0 mm", "1 m", "20 mm")]
#: Geometric error as a length, with its sign; and standard deviation of a random geometric error.
Deviation = Annotated[float, QuantityRange("length", "-10 mm", "10 mm", "1 um")]
Spread = Annotated[float, QuantityRange("length", "0 mm", "10 mm", "1 um")]
#: Prescribed displacement and prescribed rotation of a support.
Shift = Annotated[float, QuantityRange("length", "-1 m", "1 m", "300 um")]
Turn = Annotated[float, QuantityRange("angle", "-200 mrad", "200 mrad", "1 mrad")]
#: Azimuth, counted on over whole turns.
Azimuth = Annotated[float, QuantityRange("angle", "-1000000 deg", "1000000 deg", "-360 deg")]
ContactAngle = Annotated[
    float, QuantityRange("angle", "0 deg", "90 deg", "45 deg", lower_limit_excluded=True, upper_limit_excluded=True)
]
#: Contact angle of a screw or bearing; 90 deg is a thrust ball bearing with washers.
TrackAngle = Annotated[float, QuantityRange("angle", "0 deg", "90 deg", "45 deg", lower_limit_excluded=True)]
#: Young's modulus and Poisson's ratio of a material.
Modulus = Annotated[float, QuantityRange("pressure", "1 MPa", "5000 GPa", "210 GPa")]
Poisson = Annotated[float, QuantityRange("number", 0, 0.5, 0.28, upper_limit_excluded=True)]
#: Groove radius over ball diameter; number of turns; harmonic of an error, in cycles per turn.
Conformity = Annotated[float, QuantityRange("number", 0.5, 5, 0.52, lower_limit_excluded=True)]
Turns = Annotated[float, QuantityRange("number", 0, 10_000, 2, lower_limit_excluded=True)]
Harmonic = Annotated[float, QuantityRange("number", 0, 10_000, 1)]
#: Component of a force; component of a moment.
Force = Annotated[float, QuantityRange("force", "-1000 MN", "1000 MN", "5 kN")]
Moment = Annotated[float, QuantityRange("moment", "-1000000 kN m", "1000000 kN m", "3 N m")]
#: Load rating by a maker.
Rating = Annotated[float, QuantityRange("force", "1 N", "1000 MN", "23.2 kN")]
#: Components x, y, z of a force and of a moment.
Forces = Annotated[tuple[Force, Force, Force], ListLength(3, 3)]
Moments = Annotated[tuple[Moment, Moment, Moment], ListLength(3, 3)]
#: Inputs of the modified rating life: reliability [%], contamination factor, viscosity ratio; and the limit of pitch
#: diameter times rotational speed [mm/min].
Reliability = Annotated[float, QuantityRange("number", 90, 99.95, 95)]
Contamination = Annotated[float, QuantityRange("number", 0, 1, 0.6)]
ViscosityRatio = Annotated[float, QuantityRange("number", 0.1, 1000, 1.5)]
SpeedLimit = Annotated[float, QuantityRange("number", 1000, 1_000_000, 76_200)]
#: Increment of the axial load for a stiffness; length of a beam element.
LoadStep = Annotated[float, QuantityRange("force", "0.001 N", "1000 MN", "600 N")]
Element = Annotated[float, QuantityRange("length", "0.01 mm", "1 m", "1 mm")]
#: Coefficient of friction; clearance of a bearing or between balls; fraction of a ball circuit that is filled.
Coefficient = Annotated[float, QuantityRange("number", 0, 2, 0.1)]
Clearance = Annotated[float, QuantityRange("length", "0 mm", "1 m", "50 um")]
RadialClearance = Annotated[float, QuantityRange("length", "-1 mm", "1 m", "13 um")]
Filling = Annotated[float, QuantityRange("number", 0, 1, 0.8, lower_limit_excluded=True)]
#: Computation over time: angle of rotation, duration, and largest accepted error of the time steps (a fraction).
Travel = Annotated[float, QuantityRange("angle", "0.001 deg", "1000000 deg", "360 deg")]
Duration = Annotated[float, QuantityRange("time", "0 s", "1000000 s", "1 s", lower_limit_excluded=True)]
StepGoal = Annotated[float, QuantityRange("number", 0.0001, 0.1, 0.01)]
#: Angular speed of the rotating part.
Turning = Annotated[float, QuantityRange("angular speed", "-100000 rps", "100000 rps", "600 rpm")]
#: Error limit in per cent.
Percent = Annotated[float, QuantityRange("number", 0, 100, 7, lower_limit_excluded=True)]
#: Stiffness of a spring for a displacement; stiffness of a spring for a rotation, as a moment per radian.
Spring = Annotated[float, QuantityRange("stiffness", "0 N/m", "1000000 kN/um", "200 N/um")]
Twist = Annotated[float, QuantityRange("moment", "0 N m", "1000000 kN m", "5 kN m")]
#: Axial stiffness of screw and nut between two neighbouring balls.
SegmentStiffness = Annotated[
    float, QuantityRange("stiffness", "0 N/m", "1000000 kN/um", "258 kN/um", lower_limit_excluded=True)
]
#: Properties of lubricants and materials: kinematic viscosity, density, pressure-viscosity coefficient.
Viscosity = Annotated[float, QuantityRange("kinematic viscosity", "0.1 mm2/s", "100000 mm2/s", "27 mm2/s")]
Density = Annotated[float, QuantityRange("density", "100 kg/m3", "30000 kg/m3", "900 kg/m3")]
PressureViscosity = Annotated[float, QuantityRange("pressure coefficient", "1 1/GPa", "100 1/GPa", "20 1/GPa")]
#: Manufacturer's factor G_1 of the friction torque of tapered rollers; friction torque.
TorqueFactor = Annotated[float, QuantityRange("number", 0, 100_000, 40, lower_limit_excluded=True)]
Torque = Annotated[float, QuantityRange("moment", "0 N m", "1000000 kN m", "100 N mm")]
#: Mass and moment of inertia that a motor moves.
Mass = Annotated[float, QuantityRange("mass", "0 kg", "1000000 t", "200 kg")]
Inertia = Annotated[float, QuantityRange("moment of inertia", "0 kg m2", "1000000 kg m2", "20 kg cm2")]
#: Factor f0 of the lubrication in Palmgren's friction torque; efficiency of a ball screw.
Factor0 = Annotated[float, QuantityRange("number", 0, 100, 2, lower_limit_excluded=True)]
Efficiency = Annotated[float, QuantityRange("number", 0.1, 1, 0.92)]
#: Smallest and largest Young's modulus [Pa] of materials used for machine parts.
SOLIDS = (1e9, 1e12)
