"""Loads of balls that travel: compliance by parabolas in windows of travel against every place solved by itself."""

import numpy as np
import pytest
from tests.helpers import small_screw

from rollbench.lowfi.compliance.parts import REFINED
from rollbench.lowfi.friction.whole.run import WINDOW, TravellingCompliance
from rollbench.lowfi.statics.nominal import contact_loads
from rollbench.meshes.errors import draw_errors
from rollbench.meshes.helix import ball_layout, ball_layout_at_positions, lead_per_radian

SCENE = small_screw(6, 1.2, force=(150.0, 0.0, 400.0))
#: Parts of the widest window at which loads are compared: inside windows of all widths, at ends of some.
PARTS = np.array([0.07, 0.19, 0.31, 0.44, 0.57, 0.69, 0.81, 0.93])


def loads_at(by, **how):
    """Contact forces (N, 4) where all balls have travelled by an angle [rad] in the nut."""
    start, track = ball_layout(SCENE), SCENE.track
    azimuth, station = start.azimuth + by, start.z + lead_per_radian(track) * by
    layout, radius = ball_layout_at_positions(track, azimuth, station), np.full(start.z.size, SCENE.balls.radius)
    geometry = draw_errors(SCENE).geometry_at_balls(SCENE, azimuth, azimuth, station, radius)
    found = contact_loads(SCENE, geometry, layout, REFINED, **how)
    assert found.converged
    return found.load


@pytest.mark.slow
def test_loads_between_the_places_of_a_window_are_those_of_the_places():
    """Differences on one stretch fall with the width, and are 1e-7 of the mean load at the width that runs take."""
    widths = 2.0 * WINDOW, WINDOW, 0.5 * WINDOW
    places = PARTS * widths[0]
    exact = np.array([loads_at(by) for by in places])
    mean = np.mean([load[load > 0.0].mean() for load in exact])
    windows = [TravellingCompliance(width) for width in widths]
    found = np.array([[loads_at(by, whole=t) for by in places] for t in windows])
    wide, usual, narrow = np.abs(found - exact).max(axis=(1, 2, 3)) / mean
    assert 0.0 < narrow < usual / 4.0 < wide / 12.0
    assert usual < 2e-7
