"""Mesh choices of the 3D reference: sizes, the contact zone's grid, and the ball's patch on the groove's nodes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hifi.hertz import hertz
from hifi.patch import Lines, graded, growing
from meshes.ball_body import BallSocket, directions, pyramid_points
from meshes.errors import specimen
from meshes.groove_map import GrooveMap
from meshes.helix import BallLayout, ball_layout, lead_angle
from meshes.parts import Scene
from meshes.sockets import SocketSize, fitted_socket, local_points
from meshes.solid import Dimensions

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Settings:
    """Mesh choices of the 3D reference; lengths in m.

    b_over_h: cells across the short semi-axis; semi, reach: smallest and largest expected semi-axes (a, b); fine, coarse:
    element sizes of the coarse bodies near and away from sockets; ball_fine, ball_coarse: those of balls; cell: that of
    the homogenised shaft; modes: smooth modes kept per patch; element: ``"Q2"`` patches on second-order bodies, or
    ``"P1"``: first-order tetrahedra of ``tet`` size around each contact, on first-order bodies, as the source's mesh.
    """

    b_over_h: float = 4.0
    semi: tuple[float, float] = (0.40e-3, 0.105e-3)
    reach: tuple[float, float] = (0.40e-3, 0.105e-3)
    fine: float = 1.0e-3
    coarse: float = 5.0e-3
    ball_fine: float = 0.35e-3
    ball_coarse: float = 0.8e-3
    cell: float = 4.5e-3
    modes: int = 16
    element: str = "Q2"
    tet: float = 0.08e-3


#: Half width of the contact zone over the largest expected semi-axes, across and along the groove.
MARGIN = (1.25, 1.35)
#: Expected semi-axes are rounded to this length [m], so that like scenes share their patches.
ROUNDING = 5e-6


def expected_semi_axes(scene: Scene) -> tuple[float, float]:
    """Semi-axes (a, b) [m] of a typical contact, for the grid only: the even share of the load plus that of the preload.

    Hertz of the ball on the screw's nominal groove; oversized balls carry (e / c)^(3/2) with the approach c F^(2/3).
    """
    track, balls = scene.track, scene.balls
    beta, alpha = track.contact_angle, lead_angle(track)
    reach = track.pitch_radius - balls.radius * np.cos(beta)
    across = 1.0 / (1.0 / balls.radius - 1.0 / scene.screw.groove_radius)
    along = 1.0 / (1.0 / balls.radius + np.cos(beta) * np.cos(alpha) ** 2 / reach)
    material = balls.material
    unit = hertz(1.0, across, along, material.youngs_modulus, material.poissons_ratio)
    axial = sum(abs(load.force[2]) for load in scene.loads)
    lateral = sum(float(np.hypot(*load.force[:2])) for load in scene.loads)
    moment = sum(float(np.hypot(*load.moment[:2])) for load in scene.loads)
    share = axial / (scene.ball_count * np.sin(beta) * np.cos(alpha))
    share += 4.0 * (lateral + moment / track.pitch_radius) / (scene.ball_count * np.cos(beta))
    squeeze = max(0.0, float((specimen(scene, ball_layout(scene)).ball_radius - balls.radius).min()))
    load = max(share + (squeeze / unit.approach) ** 1.5, 1.0)
    a, b = (max(unit.semi_x, unit.semi_y), min(unit.semi_x, unit.semi_y))
    scale = load ** (1.0 / 3.0)
    return float(np.ceil(a * scale / ROUNDING) * ROUNDING), float(np.ceil(b * scale / ROUNDING) * ROUNDING)


def patch_lines(
    settings: Settings, width: tuple[float, float], deep: float
) -> tuple[Lines, tuple[float, float]]:
    """Element boundaries of a patch and its contact zone in local units; half widths and depth of the socket [m]."""
    a, b = settings.semi
    wide, long = settings.reach  # the long axis lies across the groove, where ball and groove conform
    cell_a, cell_b = a / settings.b_over_h, b / settings.b_over_h
    zone_a, zone_b = MARGIN[0] * wide, MARGIN[1] * long
    if settings.element == "Q2":
        zone_a, zone_b = cell_a * np.ceil(zone_a / cell_a), cell_b * np.ceil(zone_b / cell_b)
    zone = (float(min(zone_a / width[0], 0.85)), float(min(zone_b / width[1], 0.85)))
    across = graded(zone[0], cell_a / width[0])
    along = graded(zone[1], cell_b / width[1])
    depth = growing(0.0, 1.0, 0.6 * cell_b / deep, 1.8)
    return Lines(across, depth, along), zone


def socket_size(
    scene: Scene, m: GrooveMap, layout: BallLayout, sides: tuple[int, ...], dims: Dimensions
) -> SocketSize:
    """Socket of all contacts, as large as the scene leaves room for. Raises ValueError where that is too small."""
    nut, position = scene.nut, scene.nut.position
    low, high = dims.ends(scene)
    ends = (max(position - nut.length / 2.0, low), min(position + nut.length / 2.0, high))
    return fitted_socket(
        m, layout, sides, scene.screw.outer_diameter / 2.0, dims.hole, dims.land, nut.outer_diameter / 2.0, ends
    )


def ball_place(
    m: GrooveMap, size: SocketSize, side: int, zone: tuple[float, float]
) -> tuple[BallSocket, Callable[[Array], Array]]:
    """Socket of the ball at a side and the map of local coordinates into it.

    Inside the contact zone the rays pass exactly through the groove's nodes; towards the rim they blend into the pyramid.
    """
    n, t1, t2 = directions(m, side)
    centre = np.array([m.R, 0.0, 0.0])

    def project(xi1: Array, xi3: Array) -> tuple[Array, Array]:
        flat = np.stack([xi1, np.zeros_like(xi1), xi3], axis=1)
        x = local_points(m, size, side, flat) - centre
        return (x @ t1) / (x @ n), (x @ t2) / (x @ n)

    one = np.array([1.0])
    across = 0.5 * float(project(one, 0 * one)[0][0] - project(-one, 0 * one)[0][0])
    along = 0.5 * float(project(0 * one, one)[1][0] - project(0 * one, -one)[1][0])
    socket = BallSocket(side, across, along, size.depth * 0.75)

    def ramp(x: Array, start: float) -> Array:
        u = np.clip((np.abs(x) - start) / (1.0 - start), 0.0, 1.0)
        return np.asarray(u * u * (3.0 - 2.0 * u))

    def place(xi: Array) -> Array:
        s, t = project(xi[:, 0], xi[:, 2])
        w = np.maximum(ramp(xi[:, 0], zone[0]), ramp(xi[:, 2], zone[1]))
        s = s * (1.0 - w) + w * across * xi[:, 0]
        t = t * (1.0 - w) + w * along * xi[:, 2]
        return pyramid_points(m, socket, s, t, xi[:, 1])

    return socket, place
