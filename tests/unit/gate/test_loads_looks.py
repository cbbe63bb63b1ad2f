"""What loads that disagree as a whole look like: another unit, other balls, other flanks."""

import numpy as np
import pytest

from rollbench.compare.gate.verdict import ALIKE, UNITS, suspected_cause_text

FLANKS = ("SL", "NR")
NEWTONS = {"kilonewtons": 1e3, "pounds": 0.45359237 * 9.80665, "kiloponds": 9.80665, "millinewtons": 1e-3}


def loads():
    """Eight balls on one diagonal, the last bears three times as much as the first."""
    found = np.zeros((8, 4))
    found[:, [0, 3]] = np.linspace(100.0, 300.0, 8)[:, None]
    return found


def test_units_are_those_of_their_definitions():
    """The pound is 0.45359237 kg and standard gravity 9.80665 m/s2, both exactly."""
    assert pytest.approx(NEWTONS, rel=1e-12) == UNITS


@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize(("share", "seen"), [(1.0 - 0.99 * ALIKE, True), (1.0 + 1.01 * ALIKE, False)])
def test_a_sum_near_that_in_another_unit_is_told(unit, share, seen):
    for size in (1.0, 1e-5):
        said = suspected_cause_text(size * share * loads() / NEWTONS[unit], size * loads(), FLANKS, 7.0)
        assert (f"look like {unit}: in newtons they are {NEWTONS[unit]:g} times as large" in said) is seen


def test_other_balls_and_other_flanks_are_told_and_what_is_within_the_limit_is_not():
    assert "in reverse order" in suspected_cause_text(loads()[::-1], loads(), FLANKS, 7.0)
    assert "in another order" in suspected_cause_text(np.roll(loads(), 3, axis=0), loads(), FLANKS, 7.0)
    other = loads()[:, [1, 0, 3, 2]]
    assert "opposite flanks" in suspected_cause_text(other, loads() + 0.1 * other, ("SR", "NL"), 7.0)
    for factor, limit in ((1.05, 12.0), (0.0, 7.0), (1.5, 7.0)):
        assert suspected_cause_text(factor * loads(), loads(), FLANKS, limit) == ""
