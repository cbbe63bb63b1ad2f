"""Compliance of bodies between balls that travel: parabolas through three places in place of each place by itself."""

import numpy as np
from tests.helpers import small_screw

from rollbench.lowfi.compliance.between import contact_points_and_axes
from rollbench.lowfi.compliance.parts import REFINED
from rollbench.lowfi.friction.whole.run import WINDOW, TravellingCompliance
from rollbench.lowfi.statics.nominal import contact_loads
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout, ball_layout_at_positions, lead_per_radian

SCENE = small_screw(6, 1.2, force=(0.0, 0.0, 400.0))


def moved(by, scene=SCENE, apart=0.0):
    start, track = ball_layout(scene), scene.track
    turned = by + apart * np.linspace(-1.0, 1.0, start.z.size)
    return ball_layout_at_positions(track, start.azimuth + turned, start.z + lead_per_radian(track) * turned)


def test_a_window_ends_before_a_ball_passes_the_nuts_face():
    """The nut's end stands less than a window beyond the last ball."""
    last = float(contact_points_and_axes(SCENE, ball_layout(SCENE), False)[0][:, 2].max())
    room = (SCENE.nut.position + 0.5 * SCENE.nut.length - last) / lead_per_radian(SCENE.track)
    place = moved(room - 0.3 * WINDOW)
    travelling = TravellingCompliance(WINDOW)
    travelling(SCENE, place, False, REFINED, (0, 1))
    ((window,),) = travelling.windows.values()
    assert 0.0 < window.travel_angle < 0.3 * WINDOW


def test_loads_of_balls_that_travel_are_those_of_balls_that_stay():
    scene = small_screw(3, 0.7, force=(0.0, 0.0, 60.0))
    layout = ball_layout(scene)
    drawn = draw_geometry_with_errors(scene, layout)
    still = contact_loads(scene, drawn, layout, REFINED)
    moving = contact_loads(scene, drawn, layout, REFINED, whole=TravellingCompliance(WINDOW))
    assert moving.converged
    assert np.allclose(moving.load, still.load, rtol=0.0, atol=1e-12 * still.load.max())
