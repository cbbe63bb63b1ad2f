"""Quantities as text: exact values, agreement of the table with pint, and refusals."""

import math
import re

import pytest

from rollbench.meshes import units

#: Names that are something else to pint, old or new: knot, carat, the constant of Planck and a chain.
ELSE = {"ch", "hbar", "kat", "cmil", "pt", "ct", "dat", "kt", "Tt"}


@pytest.mark.parametrize("unit", [*units.UNITS, *(unit for names, _ in units.DIMENSIONS.values() for unit in names)])
def test_every_unit_is_that_of_pint(unit):
    """By itself and with each prefix."""
    registry = pytest.importorskip("pint").application_registry.get()
    of = (
        units.UNITS[unit][0]
        if unit in units.UNITS
        else next(of for of, (names, _) in units.DIMENSIONS.items() if unit in names)
    )
    for prefix in units.PREFIXES if unit in units.UNITS else ("",):
        name = prefix + unit
        if (of == "temperature difference" and prefix) or {name, unit} & ELSE or (prefix and name in units.UNITS):
            continue  # a point of pint's scale has no prefix; a unit of its own: ft, min
        spelt = re.sub(r"(?<=[a-z])(?=[0-9])", "**", "*".join(name.split()))
        theirs, zero = (registry.Quantity(x, spelt).to_base_units() for x in (1.0, 0.0))
        expected = pytest.approx((theirs - zero).magnitude, rel=1e-12, abs=0.0)
        assert units.parse_quantity(f"1 {name}", of) == expected, name


#: Units of no dimension that a scene has.
NONE_HERE = ("3 mm2", "3 N m/rad", "3 lbmm", "3 m m-1")
#: Why values of a dimension are refused.
REFUSED = {
    ("length", "has no unit"): (20, 0, "20"),
    ("length", "is not text"): (True, ["1 mm"]),
    ("length", "is a force"): ("20 kN",),
    ("length", "is a mass"): ("3 kg",),
    ("force", "is a stiffness"): ("3 lbf/in",),
    ("angle", "is a temperature difference"): ("20 degC", "3 degF"),
    ("number", "is not a plain number"): ("1 mm", "0.28", True),
    ("number", "is not finite"): (math.nan, -math.inf, 10**400),
    ("force", "is not finite"): ("-inf N",),
    ("length", "too large"): ("1e9999 mm",),
    ("length", "plain number"): ("(2) mm", "__import__('os') mm", "٣ mm", "", "1" * 100 + " mm"),
    ("length", "has an unknown unit"): ("2*10 mm", "2+3 mm", "2**99 mm", "2 mm*__import__('os')", "3 mm/", *NONE_HERE),
    ("number", "decimal comma"): ("0,28",),
    ("length", "decimal comma"): ("2,5 mm", "1,800 mm", "-.5,5 mm"),
    ("force", 'has an unknown unit.*did you mean "kN"'): ("5 KN",),
    ("length", "thou"): ("2 mil", "-1.5 mils", "3mil"),
    ("force", "underscore"): ("1_000 N",),
    ("force", "Fortran"): ("1.5D+03 N", "1d3 N", "0.15+004 N"),
    ("stiffness", "has an unknown unit"): ("3 lb/in",),
}


ROWS = [(value, *kind) for kind, values in REFUSED.items() for value in values]


@pytest.mark.parametrize(("value", "dimension", "reason"), ROWS)
def test_refusals_name_value_dimension_and_example(value, dimension, reason):
    with pytest.raises(units.UnitError, match=reason) as caught:
        units.parse_quantity(value, dimension)
    for words in (units.toml_text(value), dimension, units.example_quantity(dimension)):
        assert words in str(caught.value)
