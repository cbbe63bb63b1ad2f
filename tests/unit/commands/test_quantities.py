"""Quantities of results: a key says its unit, the unit its factor from SI."""

import math
from types import SimpleNamespace

import pytest

from rollbench.compare.quantities import UNITS, quantity, record, shown

#: Units whose values are kept in them: percent, hours and revolutions are no SI.
KEPT = ("percent", "million_revolutions", "hours")


@pytest.mark.parametrize("ending", [ending for ending in UNITS if ending not in KEPT])
def test_the_factor_of_a_unit_is_that_of_pint(ending):
    pint = pytest.importorskip("pint")
    one = pint.application_registry.get().Quantity(1.0, UNITS[ending].text)
    assert one.to_base_units().magnitude * UNITS[ending].factor == pytest.approx(1.0)


def test_a_record_is_read_in_the_units_of_its_keys():
    found = SimpleNamespace(approach=2e-6, tilt=math.pi, ball=3, words="", edge=math.nan, load=None)
    keys = ("ball", "approach_um", "tilt_deg", "words", "edge_mm", "load_N")
    expected = {"ball": 3, "approach_um": 2.0, "tilt_deg": 180.0, "words": "", "edge_mm": None, "load_N": None}
    assert record([quantity(key) for key in keys], found) == expected
    assert record((), None) is None
    assert (quantity("peak_pressure_MPa").label, quantity("peak_pressure_MPa").unit) == ("peak pressure", "MPa")


SHOWN = [
    (1234.56, 4.3, "1235"),
    (1234.56, 0.43, "1235"),
    (12.3456, 0.43, "12.35"),
    (12.3456, 5, "12.3"),
    (-838.6, 9e2, "-840"),
]


@pytest.mark.parametrize(("value", "error", "text"), SHOWN)
def test_people_see_one_digit_beyond_the_first_that_the_error_touches(value: float, error: float, text: str) -> None:
    assert shown(value, error) == text
    assert abs(float(text) - value) <= max(0.05 * 10.0 ** math.floor(math.log10(error)), abs(value) * 5e-4)
