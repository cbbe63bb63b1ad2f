"""The mean load that percentages are of."""

import numpy as np
import pytest

from rollbench.comparison.commands.summary import loads_json
from rollbench.comparison.measure import load_error
from rollbench.meshes.loads import mean_load


def loads(stray=0.0):
    """32 balls on one diagonal, and a contact of the other that is barely touched."""
    found = np.zeros((32, 4))
    found[:, [0, 3]] = 358.0
    found[7, 1] = stray
    return found


def test_a_contact_that_is_barely_touched_moves_no_percentage():
    assert mean_load(loads()) == 358.0
    assert mean_load(loads(0.2)) == pytest.approx(358.0 + 0.2 / 64, rel=1e-12)
    assert loads_json(loads(0.2))["mean_N"] == mean_load(loads(0.2))
    assert [loads_json(loads(0.2))[k] for k in ("loaded_contacts", "contacts_in_mean")] == [65, 64]
    value = loads()
    value[3, 0] = 365.0
    errors = [load_error(value, reference).max_percent for reference in (loads(), loads(0.2))]
    assert errors[1] == pytest.approx(errors[0], rel=1e-4)


def test_contacts_that_bear_little_of_the_load_count_and_none_has_no_mean():
    few = np.array([[100.0, 0.0, 0.0, 100.0], [2.0, 0.0, 0.0, 2.0]])
    assert mean_load(few) == 51.0
    assert mean_load(np.zeros((3, 4))) == 0.0
    assert mean_load(np.zeros(0)) == 0.0
