"""What the static reference's own grid leaves open where rolling is held against it."""

import numpy as np
import pytest

from rollbench.compare.cases.kalker.evidence import STATIC_CELLS, STATIC_REACH, most_loaded_contact_by_3d_reference


@pytest.mark.survey
def test_rolling_is_held_no_closer_than_the_static_grid_is_known():
    coarse, fine = (np.array(most_loaded_contact_by_3d_reference(cells)) for cells in ((6, 6), STATIC_CELLS))
    change = 100.0 * (fine / coarse - 1.0)
    assert change == pytest.approx([0.07, 1.44, 0.99, -2.85], abs=0.02)
    assert np.all(np.abs(change[[1, 3]]) > 0.9 * np.array(STATIC_REACH)[[1, 3]])
