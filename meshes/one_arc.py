"""Grooves of bearings whose two arcs are one: near a contact angle of zero both flanks' contacts lie within one patch."""

from __future__ import annotations

from dataclasses import replace
from math import degrees, sin

from rollbench.meshes.parts import Scene

#: Distance of the contact from the apex between both arcs, over the ball's radius, below which they count as one: there a
#: third of a contact of usual size lies beyond the apex.
NEAR = 0.0774
#: Contact angle [rad] of a groove of one arc: the way in which thrust turns it has a sign, its size plays no part.
LEAST = 1e-7


def is_one_arc(scene: Scene) -> bool:
    """Whether a bearing's contacts lie so near the apex of a groove that both flanks have one contact; never of a screw,
    which could carry no thrust."""
    radius = min(scene.screw.groove_radius, scene.nut.groove_radius)
    return scene.track.lead == 0.0 and near_apex(radius, scene.track.contact_angle, scene.balls.radius)


def near_apex(groove: float, angle: float, ball: float) -> bool:
    """Whether both flanks' contacts are one: radii of groove and ball [m], contact angle [rad]."""
    return groove * sin(angle) < NEAR * ball


def as_one_arc(scene: Scene) -> Scene:
    """The scene with grooves of one arc each, and a statement that says so, where `is_one_arc` holds; else as it is.

    The ball touches the arc where it touched the ridge between two, without play; what the ridge leaves out there,
    (r_g - r_b) r_b beta^2 / (2 r_g) of the larger groove [m], is stated.
    """
    angle, ball = scene.track.contact_angle, scene.balls.radius
    if angle <= LEAST or not is_one_arc(scene):
        return scene
    groove = max(scene.screw.groove_radius, scene.nut.groove_radius)
    ridge = (groove - ball) * ball / (2.0 * groove) * angle**2
    statement = (
        f"The grooves are one arc each: at a contact angle of {degrees(angle):.3g} deg the contacts of both flanks are one "
        f"(a ridge between two arcs would stand {1e6 * ridge:.2g} um away from the ball)."
    )
    return replace(scene, track=replace(scene.track, contact_angle=LEAST), assumed=(*scene.assumed, statement))
