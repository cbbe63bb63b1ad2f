"""Mesh choices of the 3D reference: sizes, the contact zone's grid, and the ball's patch on the groove's nodes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from hifi.expected import expected_contacts
from hifi.patch import Lines, graded, growing
from meshes.arrays import Array
from meshes.ball_body import BallSocket, ball_depth, ball_points
from meshes.groove_map import GrooveMap
from meshes.helix import BallLayout
from meshes.parts import Scene
from meshes.sockets import ZONE, SocketSize, fitted_socket
from meshes.solid import Dimensions


@dataclass(frozen=True)
class Settings:
    """Mesh choices of the 3D reference; lengths in m.

    b_over_h: cells across the short semi-axis; semi: semi-axes (a, b) of a typical contact; reach: how far contacts reach
    from their nominal middle across and along the groove; fine, coarse: element sizes of the coarse bodies near and away
    from sockets; ball_fine, ball_coarse: those of balls; cuts: subdivisions of the sockets' edges across, in depth and
    along; growth: ratio of neighbouring cells of a patch outside the contact zone; own_cuts, own_sizes, own_ball_sizes:
    subdivisions and element sizes (near, away) of the submodels of one contact's groove and ball; cell: element size of
    the shafts that say what a cut does; modes, ball_modes: smooth modes kept per patch of the bodies, of the ball; element:
    ``"Q2"`` patches on second-order bodies, or ``"P1"``: first-order tetrahedra of ``tet`` size around each contact, on
    first-order bodies, as the source's mesh, without submodels.
    """

    b_over_h: float = 4.0
    semi: tuple[float, float] = (0.40e-3, 0.105e-3)
    reach: tuple[float, float] = (0.40e-3, 0.105e-3)
    fine: float = 1.0e-3
    coarse: float = 5.0e-3
    ball_fine: float = 0.35e-3
    ball_coarse: float = 0.8e-3
    cuts: tuple[int, int, int] = (3, 2, 3)
    growth: float = 1.6
    own_cuts: tuple[int, int, int] = (4, 4, 4)
    own_sizes: tuple[float, float] = (0.5e-3, 2.5e-3)
    own_ball_sizes: tuple[float, float] = (0.3e-3, 0.6e-3)
    cell: float = 4.5e-3
    modes: int = 16
    ball_modes: int = 24
    element: str = "Q2"
    tet: float = 0.08e-3


#: Half width of the contact zone over the expected reach of the contacts, across and along the groove.
MARGIN = (1.15, 1.2)
#: How much smaller cells are at most where there is hardly room for the contact.
TIGHT = 4.0
#: Expected semi-axes are rounded to this length [m], so that like scenes share their patches.
ROUNDING = 5e-6


def expected_semi_axes(scene: Scene) -> tuple[float, float]:
    """Semi-axes (a, b) [m] of a typical contact of a scene, rounded up. Raises ValueError as `expected_contacts`."""
    return _rounded(expected_contacts(scene).semi())


def expected_reach(scene: Scene) -> tuple[float, float]:
    """How far contacts of a scene reach on any side from their nominal middle, across and along the groove [m], rounded up.

    Raises ValueError as `expected_contacts`.
    """
    return _rounded(expected_contacts(scene).reach((0, 1, 2, 3)))


def _rounded(lengths: tuple[float, float]) -> tuple[float, float]:
    a, b = (max(1.0, float(np.ceil(x / ROUNDING - 1e-9))) * ROUNDING for x in lengths)
    return a, b


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
    size = fitted_socket(
        m,
        layout,
        sides,
        scene.screw.outer_diameter / 2.0,
        dims.hole,
        dims.land,
        nut.outer_diameter / 2.0,
        ends,
        settings.reach,
    )
    return replace(size, cuts=settings.cuts)


def ball_place(
    m: GrooveMap, size: SocketSize, side: int, zone: tuple[float, float]
) -> tuple[BallSocket, Callable[[Array], Array]]:
    """Socket of the ball at a side and the map of local coordinates into it: in the contact zone its rays pass exactly
    through the groove's nodes."""
    socket = BallSocket(side, size, ball_depth(m, size, side), zone[1])
    return socket, partial(ball_points, m, socket)
