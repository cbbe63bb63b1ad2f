"""Grooves of bearings that are one circular arc each, and their internal clearance.

Deep-groove and angular-contact rows have such grooves. A gothic arch counts as one arc too where its contact angle is so
small that the contacts of both flanks overlap at the apex.
"""

from __future__ import annotations

from dataclasses import replace
from math import acos, asin, cos, degrees, sin

from rollbench.meshes.parts import Scene
from rollbench.meshes.quantity import quantity, record

#: Distance of the contact from the apex between both arcs, over the ball's radius, below which they count as one: there a
#: third of a contact of usual size lies beyond the apex.
NEAR = 0.0774
#: Contact angle [rad] of a groove of one arc: its sign gives the direction in which thrust turns it, its size has no
#: effect.
LEAST = 1e-7


def is_one_arc(scene: Scene) -> bool:
    """Whether each groove of a bearing is one arc, so that a ball has one contact with it.

    Parameters
    ----------
    scene : Scene
        Screw or bearing.

    Returns
    -------
    bool
        False for every screw.
    """
    return bool(sides_of_arc(scene))


def sides_of_arc(scene: Scene) -> tuple[int, ...]:
    """Flanks that carry the contacts of a bearing whose grooves are one arc each.

    Parameters
    ----------
    scene : Scene
        Screw or bearing.

    Returns
    -------
    tuple[int, ...]
        Flanks (0 to 3 for SL, SR, NL, NR) of screw and nut; empty where grooves have two arcs.
    """
    radius = min(scene.screw.groove_radius, scene.nut.groove_radius)
    track = scene.track
    return sides_of_arcs(track.lead, track.arcs, near_apex(radius, track.contact_angle, scene.balls.radius))


def sides_of_arcs(lead: float, arcs: str, near: bool) -> tuple[int, ...]:
    """Flanks that carry the contacts of grooves of one arc each, as `sides_of_arc`, from plain values.

    The thread of a screw always has two arcs: with one arc near the apex its nut would carry no thrust.

    Parameters
    ----------
    lead : float
        Lead [m] or reduced lead [m/rad]; only whether it is zero counts.
    arcs : str
        ``Track.arcs``.
    near : bool
        Whether the contacts of both flanks overlap, by `near_apex`.

    Returns
    -------
    tuple[int, ...]
        Flanks 0 to 3.
    """
    if lead != 0.0 or (arcs == "two" and not near):
        return ()
    return (1, 2) if arcs == "-z" else (0, 3)


def near_apex(groove: float, angle: float, ball: float) -> bool:
    """Whether the contacts of both flanks of a gothic arch count as one.

    Parameters
    ----------
    groove : float
        Radius of the groove [m].
    angle : float
        Contact angle [rad].
    ball : float
        Radius of the ball [m].

    Returns
    -------
    bool
        Whether the contact point lies within `NEAR` ball radii of the apex.

    Examples
    --------
    >>> near_apex(3.254e-3, 0.05, 2.778e-3), near_apex(3.254e-3, 0.7, 2.778e-3)
    (True, False)
    """
    return groove * sin(angle) < NEAR * ball


def as_one_arc(scene: Scene) -> Scene:
    """Replace a bearing's gothic arches by single arcs where the contacts of both flanks overlap.

    The ball touches the arc where it touched the ridge between two arcs, without clearance. What the ridge leaves out
    there, (r_G - r_B) r_B beta^2 / (2 r_G) of the larger groove [m], goes to the scene's ``assumed``.

    Parameters
    ----------
    scene : Scene
        Bearing; other scenes are returned unchanged.

    Returns
    -------
    Scene
        The changed scene, or the same one where nothing has to be changed.
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
    """Internal clearance of a bearing whose grooves are one arc each; whole travel of one ring against the other."""

    radial: float = quantity(
        "radial_um",
        "radial internal clearance P_d of that row, all the way that one ring goes across the other, with the balls' "
        "oversize",
        heading="radial clearance",
    )
    axial: float = quantity(
        "axial_um", "axial internal clearance P_e = 2 A sin alpha_0 of that row", heading="axial clearance"
    )
    angle: float = quantity(
        "rest_angle_deg",
        "contact angle at which the balls of a deep-groove row touch at either end of its axial play, "
        "without load: cos alpha_0 = 1 - P_d/(2 A), A = r_i + r_o - D; null without play",
        heading="contact angle at rest",
    )


def distance_of_centres(scene: Scene) -> float:
    """Distance of the groove centres at which a ball of nominal diameter touches both grooves.

    Parameters
    ----------
    scene : Scene
        Gives the radii.

    Returns
    -------
    float
        A = r_i + r_o - D [m].

    References
    ----------
    Harris and Kotzalas (2007), chapter 2.
    """
    return scene.screw.groove_radius + scene.nut.groove_radius - 2.0 * scene.balls.radius


def rest_angle(A: float, radial: float | None, axial: float | None) -> float:
    """Free contact angle of rings whose grooves are one arc each, from their clearance.

    P_d = 2 A (1 - cos alpha) and P_e = 2 A sin alpha.

    Parameters
    ----------
    A : float
        Distance of the groove centres in contact [m], by `distance_of_centres`.
    radial : float | None
        Radial internal clearance P_d [m]; used where ``axial`` is None.
    axial : float | None
        Axial internal clearance P_e [m], or None.

    Returns
    -------
    float
        Contact angle [rad], at least `LEAST`.

    Raises
    ------
    ValueError
        A clearance of 2 A or more; the message gives that limit.

    References
    ----------
    Harris and Kotzalas (2007), sections 2.3 and 2.4.

    Examples
    --------
    >>> round(degrees(rest_angle(0.18e-3, 13e-6, None)), 2)
    15.44
    """
    share = (radial if axial is None else axial or 0.0) or 0.0
    if not share < 2.0 * A:
        raise ValueError(f"below {2e3 * A:.4g} mm")
    return max(acos(1.0 - share / (2.0 * A)) if axial is None else asin(share / (2.0 * A)), LEAST)


def clearance_of(scene: Scene) -> Clearance | None:
    """Compute the internal clearance of a bearing whose grooves are one arc each, with the oversize of its balls.

    Parameters
    ----------
    scene : Scene
        Bearing.

    Returns
    -------
    Clearance | None
        Clearances [m] and free contact angle [rad], all 0 without clearance; None for other grooves.
    """
    if not is_one_arc(scene):
        return None
    A = distance_of_centres(scene)
    apart, touching = A * cos(scene.track.contact_angle), A - 2.0 * scene.errors.balls.oversize
    if touching <= apart:
        return Clearance(0.0, 0.0, 0.0)
    angle = acos(apart / touching)
    return Clearance(2.0 * (touching - apart), 2.0 * touching * sin(angle), angle)
