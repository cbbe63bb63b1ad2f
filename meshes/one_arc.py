"""Bearings whose grooves are single circular arcs (deep-groove and angular contact bearings), and their clearance.

A gothic arch is treated as a single arc too where its contact angle is so small that the contacts of both flanks overlap at
the apex.
"""

from __future__ import annotations

from dataclasses import replace
from math import acos, cos, degrees, sin

from rollbench.meshes.parts import Scene
from rollbench.meshes.quantity import quantity_field, result_record
from rollbench.meshes.stated import LEAST

#: Distance between contact and apex, as a ratio to the ball's radius, below which both arcs are treated as one. At this
#: distance a third of a contact of typical size lies beyond the apex.
NEAR = 0.0774


def has_single_arc_grooves(scene: Scene) -> bool:
    """Return whether each groove of a scene is a single arc, so that a ball has one contact with each ring.

    Parameters
    ----------
    scene : Scene
        Scene with a screw or bearing.

    Returns
    -------
    bool
        True for grooves of single arcs; False for gothic arches, and for every screw.
    """
    return bool(flanks_of_single_arc_contacts(scene))


def flanks_of_single_arc_contacts(scene: Scene) -> tuple[int, ...]:
    """Return the flanks that carry the contacts of a bearing whose grooves are single arcs.

    Parameters
    ----------
    scene : Scene
        Scene with a screw or bearing.

    Returns
    -------
    tuple[int, ...]
        One flank of the inner ring (0 left, 1 right) and one of the outer ring (2 left, 3 right); empty for gothic arches.
    """
    radius, track = min(scene.screw.groove_radius, scene.nut.groove_radius), scene.track
    merge = contacts_merge_at_apex(radius, track.contact_angle, scene.balls.radius)
    return flanks_with_contacts_of_arcs(track.lead, track.arcs, merge)


def flanks_with_contacts_of_arcs(lead: float, arcs: str, contacts_merge: bool) -> tuple[int, ...]:
    """Return the flanks that carry the contacts of single-arc grooves, for a given lead and given arcs.

    The groove of a screw is always a gothic arch: with a single arc near the apex its nut would carry no thrust.

    Parameters
    ----------
    lead : float
        Lead [m] or lead per radian [m/rad]: zero for a bearing, any other value for a screw.
    arcs : str
        Arcs of each groove, as in ``Track.arcs``: ``"two"``, ``"+z"`` or ``"-z"``.
    contacts_merge : bool
        Whether the contacts on both flanks of a gothic arch count as one, as returned by `contacts_merge_at_apex`.

    Returns
    -------
    tuple[int, ...]
        One flank of the inner ring (0 left, 1 right) and one of the outer ring (2 left, 3 right); empty for gothic arches.
    """
    if lead != 0.0 or (arcs == "two" and not contacts_merge):
        return ()
    return (1, 2) if arcs == "-z" else (0, 3)


def contacts_merge_at_apex(groove_radius: float, contact_angle: float, ball_radius: float) -> bool:
    """Return whether the contacts on both flanks of a gothic arch are so close to the apex that they count as one.

    Parameters
    ----------
    groove_radius : float
        Radius of the groove [m].
    contact_angle : float
        Contact angle [rad].
    ball_radius : float
        Radius of the ball [m].

    Returns
    -------
    bool
        Whether the distance between contact point and apex is less than `NEAR` ball radii.

    Examples
    --------
    >>> contacts_merge_at_apex(3.254e-3, 0.05, 2.778e-3), contacts_merge_at_apex(3.254e-3, 0.7, 2.778e-3)
    (True, False)
    """
    return groove_radius * sin(contact_angle) < NEAR * ball_radius


def with_single_arc_grooves(scene: Scene) -> Scene:
    """Return a bearing in which single arcs replace gothic arches where the contacts of both flanks overlap.

    The single arc touches the ball, without clearance, where the ridge between the two arcs was. This neglects the gap
    between ball and ridge, (r_G - r_B) r_B beta^2 / (2 r_G) [m], with the radii r_G of the larger groove and r_B of the
    ball, and the contact angle beta. The gap is stated in the scene's ``assumed``.

    Parameters
    ----------
    scene : Scene
        Scene with a bearing; other scenes are returned unchanged.

    Returns
    -------
    Scene
        Scene with single arcs; the same scene where no arch is replaced.
    """
    angle, ball, track = scene.track.contact_angle, scene.balls.radius, scene.track
    if track.lead != 0.0 or track.arcs != "two" or angle <= LEAST or not has_single_arc_grooves(scene):
        return scene
    groove = max(scene.screw.groove_radius, scene.nut.groove_radius)
    ridge = (groove - ball) * ball / (2.0 * groove) * angle**2
    statement = (
        f"The grooves are one arc each: at a contact angle of {degrees(angle):.3g} deg the contacts of both flanks are one "
        f"(a ridge between two arcs would stand {1e6 * ridge:.2g} um away from the ball)."
    )
    return replace(scene, track=replace(scene.track, contact_angle=LEAST), assumed=(*scene.assumed, statement))


@result_record
class InternalClearance:
    """Internal clearance of a bearing with single-arc grooves: total free travel of one ring against the other."""

    radial: float = quantity_field(
        "radial_um",
        "radial internal clearance P_d of the row: total free radial travel of one ring against the other, for "
        "balls with their oversize",
        heading="radial clearance",
    )
    axial: float = quantity_field(
        "axial_um",
        "axial internal clearance P_e = 2 A sin alpha_0 of the row, with the contact angle alpha_0 without load "
        "(rest_angle_deg) and A = r_i + r_o - D: groove radii of both rings minus ball diameter",
        heading="axial clearance",
    )
    angle: float = quantity_field(
        "rest_angle_deg",
        "contact angle alpha_0 of a deep-groove row at either end of its axial play, without load: cos alpha_0 = 1 - "
        "P_d/(2 A), A = r_i + r_o - D with groove radii r_i, r_o of both rings and ball diameter D; null without play",
        heading="contact angle at rest",
    )


def distance_of_groove_centres(scene: Scene) -> float:
    """Return the distance between the groove centres of both rings when a nominal ball touches both grooves.

    Parameters
    ----------
    scene : Scene
        Scene with the groove radii r_i and r_o, and the ball diameter D.

    Returns
    -------
    float
        A = r_i + r_o - D [m].

    References
    ----------
    Harris and Kotzalas (2007), chapter 2.
    """
    return scene.screw.groove_radius + scene.nut.groove_radius - 2.0 * scene.balls.radius


def internal_clearance(scene: Scene) -> InternalClearance | None:
    """Compute the internal clearance of a bearing with single-arc grooves, including the oversize of its balls.

    Parameters
    ----------
    scene : Scene
        Scene with a bearing.

    Returns
    -------
    InternalClearance | None
        Clearances [m] and free contact angle [rad], all 0 without clearance; None where grooves are gothic arches.
    """
    if not has_single_arc_grooves(scene):
        return None
    A = distance_of_groove_centres(scene)
    apart, touching = A * cos(scene.track.contact_angle), A - 2.0 * scene.errors.balls.oversize
    if touching <= apart:
        return InternalClearance(0.0, 0.0, 0.0)
    angle = acos(apart / touching)
    return InternalClearance(2.0 * (touching - apart), 2.0 * touching * sin(angle), angle)
