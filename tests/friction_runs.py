"""Shared by tests of transient simulations: screws and bearings whose balls meet, enter and leave; settings."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from tests.helpers import small_screw
from tests.whole_screws import MU, TURN

from rollbench.lowfi.friction.screw.groove import azimuth_between_touching_balls, touching_balls_geometry
from rollbench.lowfi.friction.whole.circuit import balls_in_circuits
from rollbench.lowfi.friction.whole.losses import ball_kinematics
from rollbench.lowfi.friction.whole.run import SceneInMotion
from rollbench.lowfi.statics.nominal import contact_loads
from rollbench.meshes.errors import draw_errors
from rollbench.meshes.parts import BallErrors, Circulation, Errors, FourierTerm, SideErrors

SIZES = BallErrors(oversize=4e-6, listed=((2, 2e-6), (4, -2e-6), (5, 1.5e-6)))
WAVES = Errors(
    balls=SIZES, SL=SideErrors(pitch=(FourierTerm(2.0, 2e-6),)), NR=SideErrors(roundness=(FourierTerm(1.0, 1e-6, 2e-6),))
)


def setting(scene, friction=MU, motion=TURN, solve=contact_loads):
    """A run of a scene with a rigid or beam screw."""
    scene = replace(scene, motion=motion)
    drawn = draw_errors(scene)
    balls = balls_in_circuits(scene, motion, drawn)
    fixed = {"scene": scene, "friction": friction, "drive": motion, "random_errors": drawn}
    return SceneInMotion(**vars(balls), **fixed, solve_contact_loads=partial(solve, scene))


def crowded(clearance=1e-6, count=6, hand="right", **options):
    """Balls of unlike sizes that almost touch (clearance [rad]), errors of both grooves, and two balls in the return."""
    base = small_screw(count, 0.5, hand=hand, force=(40.0, 10.0, 700.0), screw="rigid", **options)
    path = ball_kinematics(base, TURN, base.balls.radius)
    spacing = azimuth_between_touching_balls(path) + 10e-6 / touching_balls_geometry(path).closing_speed_factor + clearance
    places = spacing * (np.arange(count) - 0.5 * (count - 1))
    balls = replace(base.balls, azimuths=tuple(float(p) for p in places))
    turns = count * spacing / (2.0 * np.pi)
    circulation = Circulation(turns=turns, returning=2, filling=0.93)
    return replace(base, balls=balls, errors=WAVES, circulation=circulation)


def sparse(count=9, **options):
    """A bearing with errors whose balls stay apart: nothing begins or ends."""
    base = small_screw(count, (count - 1) / count, lead=0.0, force=(60.0, 0.0, 400.0), screw="rigid", **options)
    return replace(base, errors=WAVES)


def balls_keep_their_order(history, close):
    """Assert that balls never overlap, keep their track's free way to ``close`` [rad], and press only where they meet."""
    for track in history.setting.tracks:
        gap, force = history.gap[:, track.balls], history.ball_force[:, track.balls]
        free = track.ring - history.setting.spacing[track.balls].sum()
        assert gap.min() >= 0.0
        assert gap.sum(axis=1) == pytest.approx(np.full(history.time.size, free), abs=close)
        assert force.min() >= 0.0
        assert np.max(gap[force > 0.0], initial=0.0) < 1e-9
