"""Shared by the tests of whole screws' friction: scenes, motion, friction at the static loads, one ball."""

from dataclasses import replace

import numpy as np
from tests.helpers import FLANK_ERRORS, small_screw, solved

from rollbench.lowfi.friction.whole.contacts import StaticContacts
from rollbench.lowfi.friction.whole.state import friction_state
from rollbench.meshes.helix import ball_layout_at_positions
from rollbench.meshes.parts import Balls, Friction, Material, Motion, Nut, Scene, Screw, Track

MU, TURN = Friction(0.1, 0.1, feedback=False), Motion(10.0)
AXIAL = (0.0, 0.0, 800.0)


def two_starts():
    """A preloaded left-hand screw of two starts with a side force, a moment, unlike grooves and all flank errors."""
    base = small_screw(8, 0.9, hand="left", oversize=4e-6, force=(30.0, 10.0, -600.0), moment=(0.0, 2.0, 0.0))
    errors = replace(FLANK_ERRORS, balls=base.errors.balls)
    return replace(base, track=replace(base.track, starts=2, lead=24e-3), errors=errors)


SCENES = {
    "two-point": lambda: small_screw(force=AXIAL),
    "four-point": lambda: small_screw(oversize=5e-6, force=AXIAL),
    "left hand": lambda: small_screw(hand="left", force=(20.0, 0.0, -300.0), oversize=3e-6),
    "two starts": two_starts,
    "ring": lambda: small_screw(9, 8.0 / 9.0, lead=0.0, oversize=2e-6, force=(50.0, 0.0, 400.0)),
    "rigid screw, actual Hertz": lambda: small_screw(force=AXIAL, oversize=2e-6, screw="rigid", hertz="actual"),
    "printed Hertz": lambda: small_screw(force=AXIAL, hertz="as printed"),
}


def state(scene, friction=MU, motion=TURN):
    return friction_state(scene, solved(scene), friction, motion)


def single(force, angle, groove):
    """Contacts of one ball at azimuth 0 with the groove's own Hertz constants."""
    return contacts_in(groove, np.array(force, dtype=float)[None, :], np.array(angle, dtype=float)[None, :], np.zeros(1))


def contacts_in(groove, force, angle, azimuth):
    """Contacts of N balls in a groove with its Hertz constants; force, angle (N, 4), azimuth (N,)."""
    h, cube = groove.contact_hertz_constants, np.cbrt(np.maximum(force, 1e-9 * force.max()))
    layout = ball_layout_at_positions(scene_of(groove).track, azimuth, groove.advance_per_radian * azimuth)
    size, across = np.full(azimuth.size, groove.ball_radius), np.ones(force.shape, dtype=bool)
    return StaticContacts(size, force, angle, h.C_a * cube, h.C_b * cube, across, layout)


def scene_of(groove, azimuth=(0.0,)):
    """A screw with the kinematics of the groove."""
    steel, radius = Material(groove.young, groove.poisson), groove.groove_radius
    track = Track(groove.pitch_radius, abs(groove.lead), groove.contact_angle, "left" if groove.lead < 0.0 else "right")
    screw, nut = Screw(0.2, 2.0 * groove.pitch_radius, radius, steel), Nut(0.1, 0.05, 0.1, radius, steel)
    return Scene("one", "one", track, screw, nut, Balls(groove.ball_radius, steel, tuple(azimuth)))
