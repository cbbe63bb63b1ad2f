"""Scenes changed in one respect, and all that has to follow it."""

import numpy as np
import pytest
from tests.helpers import small_screw

from rollbench.compare.models.study import with_balls, with_groove
from rollbench.compare.scenes import catalogue
from rollbench.lowfi.statics.contacts import nominal_curvatures


@pytest.mark.parametrize("conformity", [0.515, 0.56])
def test_a_conformity_is_the_groove_s_radius_over_the_ball_s_diameter(conformity):
    """The curvature across is 1/r - 1/(2 f r), the more open the groove the larger; that of the helix adds some 1e-4."""
    scene = with_groove(catalogue.scene("lin-case1"), conformity)
    r = scene.balls.radius
    assert scene.screw.groove_radius == scene.nut.groove_radius == pytest.approx(2.0 * r * conformity, rel=1e-12)
    across = nominal_curvatures(scene)[:, 0]
    assert across == pytest.approx(np.full(4, 1.0 / r - 1.0 / (2.0 * conformity * r)), rel=3e-4)


@pytest.mark.parametrize("count", [1, 8, 300])
def test_more_balls_lie_as_close_in_a_nut_that_holds_them(count):
    base = small_screw(12, 2.3)
    changed = with_balls(base, count)
    azimuths = np.array(changed.balls.azimuths)
    assert azimuths.size == count
    assert azimuths.sum() == pytest.approx(0.0, abs=1e-9)
    assert np.diff(azimuths) == pytest.approx(np.full(count - 1, np.diff(base.balls.azimuths)[0]), rel=1e-9)
    along = np.ptp(azimuths) * base.track.lead / (2.0 * np.pi)
    assert changed.nut.length >= max(base.nut.length, along + 4.0 * base.balls.radius)
    assert changed.screw.length - changed.nut.length == pytest.approx(base.screw.length - base.nut.length, rel=1e-12)
    assert changed.nut.position == pytest.approx(changed.screw.length / 2.0, rel=1e-12)
