"""Sizes of the meshes of the 3D reference, the contact zone's grid, and the ball's patch on the groove's nodes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from rollbench.hifi.bodies.patch import Lines, graded, growing
from rollbench.hifi.meshing.settings import Settings
from rollbench.meshes.arrays import Array
from rollbench.meshes.ball_body import BallSocket, ball_depth, ball_points
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.helix import BallLayout
from rollbench.meshes.parts import Scene
from rollbench.meshes.sockets import ZONE, SocketSize, fitted_socket, socket_centre
from rollbench.meshes.solid import Dimensions

#: Half width of the contact zone over the expected reach of the contacts, across and along the groove.
MARGIN = (1.15, 1.2)
#: How much smaller cells are at most where there is hardly room for the contact.
TIGHT = 4.0
#: Points around an ellipse that say how far it reaches.
AROUND = 73


def patch_lines(settings: Settings, width: tuple[float, float], deep: float) -> tuple[Lines, tuple[float, float]]:
    """Element boundaries of a patch and its contact zone in local units; half widths and depth of the socket [m]."""
    a, b = settings.semi
    wide, long = settings.reach  # the long axis lies across the groove, where ball and groove conform
    cell_a, cell_b = a / settings.b_over_h, b / settings.b_over_h
    zone_a, zone_b = MARGIN[0] * wide, MARGIN[1] * long
    if settings.element == "Q2":
        zone_a, zone_b = cell_a * np.ceil(zone_a / cell_a), cell_b * np.ceil(zone_b / cell_b)
    zone = (float(min(zone_a / width[0], ZONE)), float(min(zone_b / width[1], ZONE)))
    # beside an edge, where the zone hardly reaches beyond the contact, smaller cells keep the outermost nodes out of it
    cell_a = min(cell_a, max(4.0 * (zone[0] * width[0] - wide), cell_a / TIGHT))
    across = graded(zone[0], cell_a / width[0], settings.growth)
    along = graded(zone[1], cell_b / width[1], settings.growth)
    depth = growing(0.0, 1.0, cell_b / deep / settings.growth, settings.growth)
    return Lines(across, depth, along), zone


def socket_size(
    scene: Scene, m: GrooveMap, layout: BallLayout, sides: tuple[int, ...], dims: Dimensions, settings: Settings
) -> SocketSize:
    """Socket of all contacts for their expected reach. Raises ValueError where the scene leaves no room for it."""
    nut, position = scene.nut, scene.nut.position
    low, high = dims.ends(scene)
    ends = (max(position - nut.length / 2.0, low), min(position + nut.length / 2.0, high))
    radii = (scene.screw.outer_diameter / 2.0, dims.hole, dims.land, nut.outer_diameter / 2.0)
    return replace(fitted_socket(m, layout, sides, *radii, ends, settings.reach), cuts=settings.cuts)


def reach_along(m: GrooveMap, side: int, angle: Array, across: Array, along: Array) -> float:
    """How far contacts reach from their nominal middle along the lines of azimuth of a patch, over the pitch radius [m].

    angle ``(n,)`` [rad], semi-axes across and along the groove ``(n,)`` [m]. An ellipse lies across its helix, a patch's
    lines at constant azimuth: by the lead angle the ends of the long axis are ahead and behind.
    """
    turn = np.linspace(0.0, 2.0 * np.pi, AROUND)
    gamma = angle[:, None] + across[:, None] / float(m.radius[side]) * np.cos(turn)
    r, _, psi = m.unroll(*m.section(side, gamma, np.array(m.radius[side])))
    ahead = psi - socket_centre(m, side)[2] + along[:, None] * np.sin(turn) / np.hypot(r, m.rg)
    return float(m.R * np.abs(ahead).max(initial=0.0))


def ball_place(
    m: GrooveMap, size: SocketSize, side: int, zone: tuple[float, float]
) -> tuple[BallSocket, Callable[[Array], Array]]:
    """Socket of the ball at a side and the map of local coordinates into it: in the contact zone its rays pass exactly
    through the groove's nodes."""
    socket = BallSocket(side, size, ball_depth(m, size, side), zone[1])
    return socket, partial(ball_points, m, socket)
