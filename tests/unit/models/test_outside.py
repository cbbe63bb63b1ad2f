"""Where answers leave what the models mean: said just beyond each line, and not on it."""

from types import SimpleNamespace

import numpy as np
import pytest
from tests.helpers import small_screw

from rollbench.compare.models.answers import warnings_of_set
from rollbench.lowfi.rating.life import dynamic_rating

SCENE = small_screw()
RATING = dynamic_rating(SCENE)


@pytest.mark.parametrize(
    ("safety", "preload", "kinds"),
    [
        (None, RATING, []),
        (1.0, RATING, []),
        (np.nextafter(1.0, 0.0), RATING, ["safety"]),
        (1.0, np.nextafter(RATING, np.inf), ["preload"]),
        (0.5, 2.0 * RATING, ["safety", "preload"]),
    ],
)
def test_each_line_is_said_just_beyond_it(safety, preload, kinds):
    found = SimpleNamespace(parts=SCENE, worst=None if safety is None else SimpleNamespace(safety=safety))
    assert [warned.kind for warned in warnings_of_set(found, preload)] == kinds
