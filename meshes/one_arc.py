"""Grooves of bearings that are one arc each: of deep-groove and angular-contact rows, and of any ring whose two arcs meet
so near a contact angle of zero that both flanks' contacts lie within one patch."""

from __future__ import annotations

from dataclasses import replace
from math import acos, asin, cos, degrees, sin

from rollbench.meshes.parts import Scene
from rollbench.meshes.quantity import quantity, record

#: Distance of the contact from the apex between both arcs, over the ball's radius, below which they count as one: there a
#: third of a contact of usual size lies beyond the apex.
NEAR = 0.0774
#: Contact angle [rad] of a groove of one arc: the way in which thrust turns it has a sign, its size plays no part.
LEAST = 1e-7


def is_one_arc(scene: Scene) -> bool:
    """Whether each groove of a bearing is one arc: it has no apex, and a ball has one contact with it."""
    return bool(sides_of_arc(scene))


def sides_of_arc(scene: Scene) -> tuple[int, ...]:
    """Sides of the contacts in grooves of one arc each, of the screw and of the nut (0 to 3 for SL, SR, NL, NR); none where
    the grooves have two."""
    radius = min(scene.screw.groove_radius, scene.nut.groove_radius)
    track = scene.track
    return sides_of_arcs(track.lead, track.arcs, near_apex(radius, track.contact_angle, scene.balls.radius))


def sides_of_arcs(lead: float, arcs: str, near: bool) -> tuple[int, ...]:
    """`sides_of_arc` by a lead, by ``Track.arcs``, and by whether both flanks' contacts are one. The thread of a screw
    always has two arcs: its nut would carry no thrust on one near the apex."""
    if lead != 0.0 or (arcs == "two" and not near):
        return ()
    return (1, 2) if arcs == "-z" else (0, 3)


def near_apex(groove: float, angle: float, ball: float) -> bool:
    """Whether both flanks' contacts are one: radii of groove and ball [m], contact angle [rad]."""
    return groove * sin(angle) < NEAR * ball


def as_one_arc(scene: Scene) -> Scene:
    """The scene with grooves of one arc each, and a statement that says so, where both flanks' contacts are one; else as it
    is, as where the scene says itself that they are one arc.

    The ball touches the arc where it touched the ridge between two, without play; what the ridge leaves out there,
    (r_g - r_b) r_b beta^2 / (2 r_g) of the larger groove [m], is stated.
    """
    angle, ball = scene.track.contact_angle, scene.balls.radius
    if angle <= LEAST or scene.track.arcs != "two" or not is_one_arc(scene):
        return scene
    groove = max(scene.screw.groove_radius, scene.nut.groove_radius)
    ridge = (groove - ball) * ball / (2.0 * groove) * angle**2
    statement = (
        f"The grooves are one arc each: at a contact angle of {degrees(angle):.3g} deg the contacts of both flanks are one "
        f"(a ridge between two arcs would stand {1e6 * ridge:.2g} um away from the ball)."
    )
    return replace(scene, track=replace(scene.track, contact_angle=LEAST), assumed=(*scene.assumed, statement))


@record
class Clearance:
    """Play between rings of one arc each: radial and axial internal clearance [m], both the whole way that one ring goes
    against the other, and the contact angle [rad] at which the balls touch at either end of the axial one."""

    radial: float = quantity(
        "radial_um",
        "radial internal clearance P_d of that row, all the way that one ring goes across the other, with the balls' "
        "oversize",
    )
    axial: float = quantity("axial_um", "axial internal clearance P_e = 2 A sin alpha_0 of that row")
    angle: float = quantity(
        "rest_angle_deg",
        "contact angle at which the balls of a deep-groove row touch at either end of its axial play, "
        "without load: cos alpha_0 = 1 - P_d/(2 A), A = r_i + r_o - D; null without play",
    )


def distance_of_centres(scene: Scene) -> float:
    """Distance A = r_i + r_o - D [m] of the groove centres where a ball of nominal diameter D touches both grooves."""
    return scene.screw.groove_radius + scene.nut.groove_radius - 2.0 * scene.balls.radius


def rest_angle(A: float, radial: float | None, axial: float | None) -> float:
    """Contact angle at rest [rad] of rings whose groove centres are A [m] apart in contact, by their radial clearance
    P_d = 2 A (1 - cos alpha), or their axial one P_e = 2 A sin alpha [m] (Harris and Kotzalas 2007, 2.3 and 2.4).

    Raises ValueError, with the largest clearance that leaves a contact angle below 90 deg, for a larger one.

    >>> round(degrees(rest_angle(0.18e-3, 13e-6, None)), 2)
    15.44
    """
    share = (radial if axial is None else axial or 0.0) or 0.0
    if not share < 2.0 * A:
        raise ValueError(f"below {2e3 * A:.4g} mm")
    return max(acos(1.0 - share / (2.0 * A)) if axial is None else asin(share / (2.0 * A)), LEAST)


def clearance_of(scene: Scene) -> Clearance | None:
    """Clearance of a bearing whose grooves are one arc each, with the oversize of its balls; None of other grooves."""
    if not is_one_arc(scene):
        return None
    A = distance_of_centres(scene)
    apart, touching = A * cos(scene.track.contact_angle), A - 2.0 * scene.errors.balls.oversize
    if touching <= apart:
        return Clearance(0.0, 0.0, 0.0)
    angle = acos(apart / touching)
    return Clearance(2.0 * (touching - apart), 2.0 * touching * sin(angle), angle)
