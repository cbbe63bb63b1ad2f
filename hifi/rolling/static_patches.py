"""Groove and ball of the static reference around one contact, for loads along tangents too: patches in pieces of bodies.

The patch is `hifi.bodies.patch.build_patch` on the exact groove, or on the ball, in its socket of a piece of screw, ring,
nut or ball as `hifi.condensation.sides` cuts it; patch and piece are solved as one
(`hifi.bodies.submodel.piece_compliance`). Cells of the contact zone are those of the other bodies of rolling
(`hifi.rolling.contact_bodies.Zone`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from rollbench.hifi.bodies.patch import Lines, PatchMesh, build_patch, graded, growing
from rollbench.hifi.bodies.submodel import Piece
from rollbench.hifi.condensation.sides import BEYOND
from rollbench.hifi.meshing.fit import ball_place
from rollbench.hifi.rolling.contact_bodies import Zone
from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.ball_body import build_ball
from rollbench.meshes.groove import BodySpec
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.grooved_body import build_body
from rollbench.meshes.helix import BallLayout
from rollbench.meshes.parts import SIDE_SIGNS
from rollbench.meshes.sockets import SocketSize, fitted_socket, local_points, reach, socket_centre

#: Left flanks of screw or inner ring, and of nut or outer ring; right ones are these turned.
INNER, OUTER = 0, 2
#: Land beyond the pitch circle, wall behind the groove at most and solid core of a screw, over the ball's radius, the
#: ball's radius and the pitch radius.
LAND, WALL, CORE = 0.18, 2.7, 1.0 / 11.0
#: Where the pieces of grooved bodies are held.
ENDS = ("low end", "high end")
#: Subdivisions of the sockets' edges; element sizes near and away from the socket over the ball's radius, of grooves and of
#: balls: level 1 of the static reference (`compare.reference.levels`).
CUTS, GROOVE_SIZES, BALL_SIZES = (4, 4, 4), (0.216, 1.3), (0.119, 0.27)


@dataclass(frozen=True)
class Curve:
    """Path of the balls' centres: radius [m] of its cylinder, and rise per angle [m/rad] (0: ring; < 0: left-hand)."""

    radius: float
    rise: float


@dataclass(frozen=True)
class Cut:
    """A patch in a piece of its body; ball's centre ``(3,)`` [m] in the patch's frame; rows ``(3, 3)``: along the track,
    across it towards the bottom of the groove, into the body; boundaries of the patch's cells [m] in their order;
    places of the contact's nodes in the zone's grid along the first two ``(c, 2)``."""

    patch: PatchMesh
    piece: Piece
    centre: Array
    axes: Array
    cells: tuple[Array, Array, Array]
    number: Index


def cuts_of(curve: Curve, ball: float, groove: float, angle: float, zone: Zone, *, outer: bool) -> tuple[Cut, Cut]:
    """Groove and ball at one contact.

    ball, groove: radii [m]; angle: from the groove's bottom to the contact [rad]; zone: half lengths along and across the
    track [m]; outer: whether the groove is the nut's or outer ring's. Raises ValueError where a socket
    has no room, or a mesh cannot be built.
    """
    side = OUTER if outer else INNER
    m = groove_map(curve, ball, groove, angle)
    walls = max(curve.radius - WALL * ball, CORE * curve.radius), curve.radius + WALL * ball
    lands = curve.radius - LAND * ball, curve.radius + LAND * ball
    nothing = np.zeros(1)
    alone = BallLayout(nothing, nothing, np.array([[curve.radius, 0.0, 0.0]]), *np.eye(3)[[0, 2, 1]][:, None])
    need = (zone.half[1], zone.half[0])
    size = fitted_socket(m, alone, (side,), lands[0], walls[0], lands[1], walls[1], (-3.0 * ball, 3.0 * ball), need)
    size = replace(size, cuts=CUTS)
    lines, local = _lines(m, size, side, zone)
    half = max(reach(m, size, (side,))) + BEYOND * ball
    radii = (lands[1], walls[1]) if outer else (walls[0], lands[0])
    near, away = (ball * share for share in GROOVE_SIZES)
    body = build_body(m, BodySpec(*radii, -half, half, not outer, ((0.0, 0.0, side),), size, near, away))
    ball_socket, place = ball_place(m, size, side, local)
    near, away = (ball * share for share in BALL_SIZES)
    sphere = build_ball(m, (ball_socket,), near, away, CUTS)
    grooved = build_patch(lines, local, partial(local_points, m, size, side), body.sockets[side])
    round_ = build_patch(lines, local, place, sphere.sockets[side])
    normal, axes = _axes(m, side)
    x, y = lines.along * zone.half[0] / local[1], lines.across * zone.half[1] / local[0]
    out = []
    for patch, piece, centre, inward, depth in (
        (grooved, Piece(body.mesh, body.socket_nodes[0], np.eye(3), ENDS), np.array([m.R, 0.0, 0.0]), normal, size.depth),
        (round_, Piece(sphere.mesh, sphere.socket_nodes[side], np.eye(3), ()), np.zeros(3), -normal, ball_socket.depth),
    ):
        number = _number(patch, axes, centre)
        out.append(Cut(patch, piece, centre, np.vstack([axes, inward]), (x, y, depth * lines.depth), number))
    return out[0], out[1]


def groove_map(curve: Curve, ball: float, groove: float, angle: float) -> GrooveMap:
    """The static reference's map of a track whose grooves are all alike."""
    signs = np.array(SIDE_SIGNS)
    to_contact = signs * np.array([np.cos(angle), np.sin(angle)])
    lead_angle = float(np.arctan2(curve.rise, curve.radius))
    centres = -(groove - ball) * to_contact
    return GrooveMap(curve.radius, curve.rise, lead_angle, angle, ball, signs, centres, np.full(4, groove), 0.0, 0.0, 1)


def _lines(m: GrooveMap, size: SocketSize, side: int, zone: Zone) -> tuple[Lines, tuple[float, float]]:
    """Element boundaries of a patch with the zone's cells, and the zone in the patch's coordinates."""
    along = size.phi * float(np.hypot(socket_centre(m, side)[0], m.rg))
    width = size.gamma * float(m.radius[side])
    local = (zone.half[1] / width, zone.half[0] / along)
    first = min(2.0 * h / n for h, n in zip(zone.half, zone.cells, strict=True)) / size.depth
    across, forth = (graded(local[k], 2.0 * local[k] / zone.cells[1 - k], zone.growth) for k in (0, 1))
    return Lines(across, growing(0.0, 1.0, first / zone.growth, zone.growth), forth), local


def _axes(m: GrooveMap, side: int) -> tuple[Array, Array]:
    """Normal from ball to groove; rows along the groove where it is touched, and across it towards its bottom, right-handed
    with the normal."""
    radial, binormal = np.array([1.0, 0.0, 0.0]), np.array([0.0, -np.sin(m.alpha), np.cos(m.alpha)])
    sx, sz = m.signs[side]
    normal = sx * np.cos(m.beta) * radial + sz * np.sin(m.beta) * binormal
    touched = m.R * radial + m.ball * normal
    along = np.array([-touched[1], touched[0], m.rg])
    along = (along - (along @ normal) * normal) / np.linalg.norm(along - (along @ normal) * normal)
    across = np.cross(normal, along)
    sign = np.sign(sx * (across @ radial))
    return normal, sign * np.stack([along, across])


def _number(patch: PatchMesh, axes: Array, centre: Array) -> Index:
    """Places of the contact's nodes along the rows of ``axes`` in their grid, ``(c, 2)``, from zero."""
    assert patch.contact_shape is not None  # a grid
    places = np.stack(np.unravel_index(np.arange(patch.contact.size), patch.contact_shape)[::-1], axis=1)
    at = (patch.points[patch.contact] - centre) @ axes.T
    for k in range(2):
        if (places[:, k] - places[:, k].mean()) @ at[:, k] < 0.0:
            places[:, k] = places[:, k].max() - places[:, k]
    return places
