"""What makers print of a pair of bearings, and the geometry behind it."""

from __future__ import annotations

import numpy as np

from rollbench.lowfi.bearings.angular_contact import AngleRows, conformity_of_pair
from rollbench.lowfi.bearings.torque import LoadTorque, load_torque, static_rating
from rollbench.lowfi.statics.contacts import nominal_curvatures
from rollbench.meshes.parts import Scene

#: Conformity where the search for one begins.
USUAL = 0.52


def _rows(parts: Scene) -> AngleRows:
    """The bearing of a scene, with a usual conformity."""
    steel, track = parts.nut.material, parts.track
    sizes = (parts.ball_count, 2.0 * parts.balls.radius, 2.0 * track.pitch_radius, USUAL, track.contact_angle)
    balls, ball, pitch, groove, angle = (np.array([float(x)]) for x in sizes)
    return AngleRows(balls, ball, pitch, groove, angle, steel.youngs_modulus, steel.poissons_ratio)


def conformity(parts: Scene, preload: float, rigidity: float) -> float:
    """Conformity of both grooves of a bearing, of which a pair has an axial rigidity [N/m] under its preload [N]. Raises
    ValueError where none gives it."""
    return float(conformity_of_pair(_rows(parts), np.array([preload]), np.array([rigidity]))[0])


def starting_torque(parts: Scene, thrust: float) -> LoadTorque:
    """Load-dependent friction torque of a bearing under a thrust [N] by Palmgren's formula (Smith 2.33 to 2.38), which is
    for contact angles of about 60 deg."""
    ball, track = 2.0 * parts.balls.radius, parts.track
    across, along = nominal_curvatures(parts)[0]
    rated = static_rating(1, parts.ball_count, ball, track.contact_angle, float(across), float(along))
    return load_torque(abs(thrust), 0.0, 2.0 * track.pitch_radius, rated)
