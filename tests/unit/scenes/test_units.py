"""Quantities as text: exact values, agreement of the table with pint, and refusals."""

import math
import subprocess
import sys
from fractions import Fraction

import pytest

from rollbench.comparison.scenes import units


@pytest.mark.parametrize(
    ("text", "dimension", "value"),
    [
        ("20 mm", "length", 0.02),
        ("3.254mm", "length", 3.254e-3),
        ("2.778 mm", "length", 2.778e-3),
        ("-7 um", "length", -7e-6),
        ("7 µm", "length", 7e-6),  # micro sign
        ("7 μm", "length", 7e-6),  # Greek letter
        ("1.5e2 nm", "length", 1.5e-7),
        (".5 in", "length", 0.0127),
        ("5 kN", "force", 5e3),
        ("+1 lbf", "force", 4.4482216152605),
        ("210 GPa", "pressure", 210e9),
        ("45 deg", "angle", math.pi / 4),
        ("360°", "angle", 2 * math.pi),
        ("1 mrad", "angle", 1e-3),
        ("3 N m", "moment", 3.0),
        ("3 N*m", "moment", 3.0),
        ("3 N·m", "moment", 3.0),
        ("3 Nm", "moment", 3.0),
        ("3 Nmm", "moment", 3e-3),
        ("3 kN m", "moment", 3e3),
        ("2 lbf", "force", 8.896443230521),
        ("0.0015 in", "length", 3.81e-5),
        ("1 in-lbf", "moment", 0.1129848290276167),
        ("1 in lbf", "moment", 0.1129848290276167),
        ("1 lbf in", "moment", 0.1129848290276167),
        ("254 lbf/in", "stiffness", 44482.216152605),
        ("3 N/um", "stiffness", 3e6),
        ("3 N/µm", "stiffness", 3e6),
        ("1 psi", "pressure", 6894.757293168362),
        ("4.8 degF", "temperature difference", 4.8 / 1.8),
        ("9 °F", "temperature difference", 5.0),
        ("5 K", "temperature difference", 5.0),
    ],
)
def test_table_is_exact(text, dimension, value):
    assert units.parse(text, dimension) == value


@pytest.mark.parametrize(
    ("text", "dimension", "value"),
    [
        ("1 ft", "length", 0.3048),
        ("1 turn", "angle", 2 * math.pi),
        ("1 arcmin", "angle", math.pi / 10800),
        ("210 kN/mm^2", "pressure", 210e9),
        ("210000 N/mm2", "pressure", 210e9),
        ("1 psi", "pressure", 6894.757293168362),
        ("1 kgf", "force", 9.80665),
        ("1 lbf in", "moment", 4.4482216152605 * 0.0254),
        ("1 lbf * ft", "moment", 4.4482216152605 * 0.3048),
    ],
)
def test_other_units_by_pint(text, dimension, value):
    assert units.parse(text, dimension) == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize("unit", sorted(units.COMMON))
def test_table_and_pint_agree(unit):
    dimension, factor = units.COMMON[unit]
    by_pint = units._ask_pint({"degF": "delta_degF"}.get(unit, unit))  # a difference, no point of the scale
    assert by_pint[0] == dimension
    above, _, below = factor.partition("/")
    expected = math.radians(1.0) if factor == "deg" else float(Fraction(above) / Fraction(below or "1"))
    assert float(by_pint[1]) == pytest.approx(expected, rel=4e-16)


def test_numbers_are_plain():
    assert units.parse(0.28, "number") == 0.28
    assert units.parse(3, "number") == 3.0


@pytest.mark.parametrize(
    ("value", "dimension", "reason"),
    [
        (20, "length", "has no unit"),
        (0, "length", "has no unit"),
        ("20", "length", "has no unit"),
        ("20 kN", "length", "is a force"),
        ("20 mm", "force", "is a length"),
        ("1 mm", "number", "is not a plain number"),
        ("0.28", "number", "is not a plain number"),
        (True, "number", "is not a plain number"),
        (True, "length", "is not text"),
        (["1 mm"], "length", "is not text"),
        (math.nan, "number", "is not finite"),
        (-math.inf, "number", "is not finite"),
        (10**400, "number", "is not finite"),
        ("nan mm", "length", "is not finite"),
        ("-inf N", "force", "is not finite"),
        ("1e9999 mm", "length", "too large"),
        ("2*10 mm", "length", "has no such unit"),
        ("2+3 mm", "length", "has no such unit"),
        ("(2) mm", "length", "plain number"),
        ("2**99 mm", "length", "has no such unit"),
        ("__import__('os') mm", "length", "plain number"),
        ("2 mm*__import__('os')", "length", "has no such unit"),
        ("2,5 mm", "length", "has no such unit"),
        ("٣ mm", "length", "plain number"),
        ("", "length", "plain number"),
        ("1" * 100 + " mm", "length", "plain number"),
        ("5 KN", "force", "has no such unit"),
        ("20 degC", "angle", "is a temperature difference"),
        ("5 percent", "angle", "has no such unit"),
        ("3 dB", "angle", "has no such unit"),
        ("3 N m/rad", "moment", "has no such unit"),
        ("3 mm/", "length", "has no such unit"),
        ("3 lb/in", "stiffness", "has no such unit"),
        ("3 lbf/in", "force", "is a stiffness"),
        ("3 degF", "angle", "is a temperature difference"),
    ],
)
def test_refusals_name_value_dimension_and_example(value, dimension, reason):
    with pytest.raises(units.UnitError, match=reason) as caught:
        units.parse(value, dimension)
    message = str(caught.value)
    assert units.show(value) in message
    assert dimension in message
    assert units.example(dimension) in message


def test_nearest_unit_is_suggested():
    with pytest.raises(units.UnitError, match='did you mean "kN"'):
        units.parse("5 KN", "force")


def test_common_units_do_not_import_pint():
    code = (
        "import sys; from rollbench.comparison.scenes import units\n"
        "units.parse('2 mm', 'length'); sys.exit('pint' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
