import numpy as np
import pytest

from rollbench.compare.measure import error_percent, load_error


def test_definition_no_error_of_equal_values_even_at_zero_and_no_percentage_of_nothing() -> None:
    assert error_percent(110.0, 100.0) == pytest.approx(10.0)
    assert error_percent(90.0, -100.0) == pytest.approx(190.0)
    assert error_percent(1.0, 2.0, 50.0) == pytest.approx(-2.0)
    assert error_percent(0.0, 0.0) == 0.0
    assert np.isnan(error_percent(1.0, 0.0))


def test_load_error_names_the_worst_contact() -> None:
    reference = np.zeros((3, 4))
    reference[:, 0] = reference[:, 3] = [100.0, 200.0, 300.0]
    value = reference.copy()
    value[1, 3] += 20.0
    value[2, 1] = 4.0
    e = load_error(value, reference)
    assert (e.ball, e.side) == (2, "NR")
    assert (e.max_percent, e.own_max_percent) == pytest.approx((10.0, 10.0))
    assert e.rms_percent == pytest.approx(np.sqrt((10.0**2 + 2.0**2) / 7))
    assert e.own_rms_percent == pytest.approx(np.sqrt(10.0**2 / 6))
