"""Quantities of results: a key says its unit, the unit its factor from SI."""

import math

import pytest

from rollbench.compare.quantities import UNITS, fields_from_json, format_by_error, quantities_of_record, record_as_json
from rollbench.meshes.quantity import QuantityDescription, quantity_field, result_record

#: Units whose values are kept in them: percent, hours and revolutions are no SI.
KEPT = ("percent", "million_revolutions", "hours")


@pytest.mark.parametrize("ending", [ending for ending in UNITS if ending not in KEPT])
def test_the_factor_of_a_unit_is_that_of_pint(ending):
    pint = pytest.importorskip("pint")
    one = pint.application_registry.get().Quantity(1.0, UNITS[ending].text)
    assert one.to_base_units().magnitude * UNITS[ending].factor == pytest.approx(1.0)


@result_record
class Part:
    force: tuple[float, float] = quantity_field(
        "forces.x_N", "", QuantityDescription("forces.y_N", show=lambda f: f[1]), show=lambda f: f[0]
    )


@result_record
class Whole:
    ball: int = quantity_field("ball")
    approach: float = quantity_field("peak_approach_um", "how far both come closer", error="small")
    tilt: float = quantity_field("tilt_deg")
    edge: float = quantity_field("edge_mm")
    load: float | None = quantity_field("load_N", default=None)
    part: Part = quantity_field("part", default=Part((1.0, 2.0)))
    inner: int = 0

    @property
    @QuantityDescription("half_deg")
    def half(self) -> float:
        return 0.5 * self.tilt


def test_a_record_is_shown_in_the_units_of_its_keys():
    found = record_as_json(Whole(3, 2e-6, math.pi, math.nan))
    part = {"part": {"forces": {"x_N": 1.0, "y_N": 2.0}}}
    numbers = {"ball": 3, "peak_approach_um": 2.0, "tilt_deg": 180.0, "edge_mm": None, "load_N": None, "half_deg": 90.0}
    assert found == numbers | part
    assert (record_as_json(None), [*record_as_json(Whole(3, 0.0, 0.0, 0.0), "part", "edge_mm")][-1]) == (None, "half_deg")
    column = quantities_of_record(Whole)["peak_approach_um"]
    assert (column.label, column.unit, column.value(Whole(3, 2e-6, 0.0, 0.0))) == ("peak approach", "um", 2.0)


def test_fields_are_read_back_from_json_in_si_units():
    found = fields_from_json(Whole, {"ball": 3, "peak_approach_um": 2.0, "edge_mm": None})
    none = dict.fromkeys(("tilt", "edge", "load", "part"))
    assert found == {"ball": 3, "approach": pytest.approx(2e-6)} | none


SHOWN = [
    (1234.56, 4.3, "1235"),
    (1234.56, 0.43, "1235"),
    (12.3456, 0.43, "12.3"),
    (12.3456, 5, "12"),
    (-838.6, 9e2, "-800"),
]


@pytest.mark.parametrize(("value", "error", "text"), SHOWN)
def test_people_see_no_digit_beyond_those_of_the_error(value: float, error: float, text: str) -> None:
    assert format_by_error(value, error) == text
    assert abs(float(text) - value) <= max(0.15 * error, abs(value) * 5e-4)
