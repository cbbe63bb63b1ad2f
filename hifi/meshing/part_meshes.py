"""Meshes of one geometry: coarse screw, nut and ball with their sockets, and the patches that fit into these.

Here are their sizes too, the contact zone's grid, and the ball's patch on the groove's nodes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal

import numpy as np

from rollbench.hifi.bodies.coarse import Socket
from rollbench.hifi.bodies.patch import Lines, PatchMesh, build_patch, build_tet_patch, graded, growing
from rollbench.hifi.meshing.settings import Settings
from rollbench.meshes.arrays import Array
from rollbench.meshes.ball_body import BallBody, BallSocket, ball_depth, ball_points, build_ball
from rollbench.meshes.cache import Cache
from rollbench.meshes.groove import BodySpec
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.grooved_body import GroovedBody, build_body
from rollbench.meshes.helix import BallLayout
from rollbench.meshes.parts import Scene
from rollbench.meshes.sockets import ZONE, SocketMesh, SocketSize, fitted_socket, socket_centre
from rollbench.meshes.solid import Dimensions
from rollbench.meshes.tet_patch import build_tets, source_box

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


#: Edges [m] of first-order tetrahedra tried at a patch's rim; long ones may be turned inside out by the map to space.
RIM_EDGES = (0.5e-3, 0.35e-3, 0.25e-3, 0.15e-3)

#: Cells across the short semi-axis of the patch that is condensed with its socket, over those of the contact's own.
CARRIER = 0.5

#: Contact as a socket of a body: (azimuth [rad], z [m], side).
Place = tuple[float, float, int]

#: Function, arguments and class of a record, as for `rollbench.meshes.cache.Cache.get`.
Recipe = tuple[Callable[..., Any], tuple[Any, ...], type]


@dataclass(frozen=True)
class Sockets:
    """What the patches of one side fit: sockets of groove and ball; socket size, contact zone and widths as in `Meshes`."""

    groove: SocketMesh
    ball: SocketMesh
    size: SocketSize
    zone: tuple[float, float]
    widths: tuple[float, float]


@dataclass(frozen=True)
class Meshes:
    """Meshes of one geometry: coarse screw, nut (None: rigid) and ball, socket size, contact zone of the patches."""

    screw: GroovedBody
    nut: GroovedBody
    ball: BallBody
    size: SocketSize
    zone: tuple[float, float]
    widths: tuple[float, float]

    def sockets(self, side: int) -> Sockets:
        """Sockets of the patches of a side."""
        body = self.screw if side < 2 else self.nut
        return Sockets(body.sockets[side], self.ball.sockets[side], self.size, self.zone, self.widths)


def mesh_parts(
    scene: Scene,
    m: GrooveMap,
    layout: BallLayout,
    dims: Dimensions,
    sides: tuple[int, ...],
    settings: Settings,
    cache: Cache | None = None,
) -> Meshes:
    """Mesh screw, nut and one ball of a scene."""
    cache = cache or Cache(None)
    recipes, gather = mesh_recipes(scene, m, layout, dims, sides, settings)
    return gather(*(cache.get(*recipe) for recipe in recipes))


def mesh_recipes(
    scene: Scene, m: GrooveMap, layout: BallLayout, dims: Dimensions, sides: tuple[int, ...], settings: Settings
) -> tuple[list[Recipe], Callable[..., Meshes]]:
    """Recipes of the meshes of screw, nut and one ball of a scene, and what makes one record of the three."""
    size = socket_size(scene, m, layout, sides, dims, settings)
    widths = (size.gamma * float(m.radius.mean()), size.phi * m.R)
    _, zone = patch_lines(settings, widths, size.depth)
    nut, middle = scene.nut, scene.nut.position
    ends = (middle - nut.length / 2.0, middle + nut.length / 2.0)
    on_screw, on_nut = (sockets_of(layout, sides, screw) for screw in (True, False))
    cells = (settings.fine, settings.coarse)
    screw_spec = BodySpec(dims.hole, scene.screw.outer_diameter / 2.0, *dims.ends(scene), True, on_screw, size, *cells)
    nut_spec = BodySpec(
        dims.land, nut.outer_diameter / 2.0, *ends, False, on_nut, size, *cells, dims.groove_ends, nut.flange
    )
    sockets = tuple(ball_place(m, size, s, zone)[0] for s in sides)
    bodies: list[Recipe] = [(build_body, (m, spec), GroovedBody) for spec in (screw_spec, nut_spec)]
    ball = (build_ball, (m, sockets, settings.ball_fine, settings.ball_coarse, size.cuts), BallBody)
    return [*bodies, ball], partial(Meshes, size=size, zone=zone, widths=widths)


def sockets_of(layout: BallLayout, sides: tuple[int, ...], screw: bool) -> tuple[Place, ...]:
    """Contacts of all balls on the screw's sides, or on the nut's."""
    body_sides = [s for s in sides if (s < 2) == screw]
    return tuple((float(a), float(z), s) for a, z in zip(layout.azimuth, layout.z, strict=True) for s in body_sides)


def rotation(phi: float) -> Array:
    """Rotation about z."""
    c, s = np.cos(phi), np.sin(phi)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def placed(mesh: GroovedBody, places: tuple[Place, ...]) -> list[Socket]:
    """Sockets of a body with their rotations."""
    return [Socket(n, rotation(x[0]), x[2]) for n, x in zip(mesh.socket_nodes, places, strict=True)]


def body_kind(settings: Settings) -> Literal["P1", "P2"]:
    """Elements of the coarse bodies: those of the patches' order."""
    return "P2" if settings.element == "Q2" else "P1"


def carrier_mesh(
    meshes: Meshes | Sockets, socket: SocketMesh, place: Callable[[Array], Array], settings: Settings
) -> PatchMesh | None:
    """The patch that stands for a finer one of hexahedra where only what it passes on to its body counts."""
    coarse = replace(settings, b_over_h=CARRIER * settings.b_over_h)
    return patch_mesh(meshes, socket, place, coarse) if settings.element == "Q2" else None


def patch_mesh(
    meshes: Meshes | Sockets, socket: SocketMesh, place: Callable[[Array], Array], settings: Settings
) -> PatchMesh:
    """Mesh of a patch in a socket: graded hexahedra, or the source's tetrahedra."""
    lines, zone = patch_lines(settings, meshes.widths, meshes.size.depth)
    if settings.element == "Q2":
        return build_patch(lines, zone, place, socket)
    for far in RIM_EDGES:
        box = source_box(meshes.widths, meshes.size.depth, zone, settings.tet, far)
        try:
            return build_tet_patch(build_tets(box, socket), place, socket)
        except ValueError:
            if far == RIM_EDGES[-1]:
                raise
    raise AssertionError("unreachable")


def patch_normals(mesh: PatchMesh, centre: Array) -> Array:
    """Unit vectors ``(c, 3)`` from the ball's centre to the contact nodes of a patch."""
    arms = mesh.points[mesh.contact] - centre
    return np.asarray(arms / np.linalg.norm(arms, axis=1)[:, None])
