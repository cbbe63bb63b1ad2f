"""The unit at the end of a key says its factor from SI.

That each number of the JSON is the SI value of the record times this factor is asserted in ``api/test_api.py``, and that
texts show no digit beyond the error in the examples of `format_by_error`.
"""

import pytest

from rollbench.compare.quantities import UNITS

#: Units whose values are kept in them: percent, hours and revolutions are no SI.
KEPT = ("percent", "million_revolutions", "hours")


@pytest.mark.parametrize("ending", [ending for ending in UNITS if ending not in KEPT])
def test_the_factor_of_a_unit_is_that_of_pint(ending):
    pint = pytest.importorskip("pint")
    one = pint.application_registry.get().Quantity(1.0, UNITS[ending].text)
    assert one.to_base_units().magnitude * UNITS[ending].factor == pytest.approx(1.0)
