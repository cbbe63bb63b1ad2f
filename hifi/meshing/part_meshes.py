"""Meshes of one geometry: coarse screw, nut and ball with refinement boxes at their contacts, and patches that fill these.

Also here: mesh sizes, the grid of the contact zone, and the patch of the ball on the nodes of the groove.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal

import numpy as np

from rollbench.hifi.bodies import patch
from rollbench.hifi.bodies.coarse import BodySocket
from rollbench.hifi.meshing.settings import Settings
from rollbench.meshes import ball_body, sockets
from rollbench.meshes.arrays import Array
from rollbench.meshes.ball_body import BallRefinementBox, CoarseBallMesh, mesh_ball_with_refinement_boxes
from rollbench.meshes.cache import Cache
from rollbench.meshes.groove import GroovedBodySpec
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.grooved_body import CoarseGroovedBodyMesh, mesh_grooved_body
from rollbench.meshes.helix import BallLayout
from rollbench.meshes.parts import Scene
from rollbench.meshes.sockets import RefinementBoxFaces, RefinementBoxSize
from rollbench.meshes.solid import Dimensions
from rollbench.meshes.tet_patch import mesh_patch_with_tetrahedra, patch_as_in_thesis

#: Half width of the contact zone over the largest expected distance of a contact's edge, across and along the groove.
MARGIN = (1.15, 1.2)

#: Largest reduction of the cell size where the refinement box is hardly wider than the contact.
TIGHT = 4.0

#: Number of points around an ellipse at which its reach is evaluated.
AROUND = 73


def choose_patch_cells(
    settings: Settings, half_widths: tuple[float, float], deep: float
) -> tuple[patch.PatchCellBoundaries, tuple[float, float]]:
    """Choose the cell boundaries of the fine mesh (patch) around a contact, and the size of its contact zone.

    Parameters
    ----------
    settings : Settings
        Mesh settings: cell sizes, modes and element type.
    half_widths : tuple[float, float]
        Half widths of the refinement box that the patch fills, across and along the groove [m].
    deep : float
        Depth of the refinement box [m].

    Returns
    -------
    lines : PatchCellBoundaries
        Cell boundaries in local coordinates.
    zone : tuple[float, float]
        Half widths of the contact zone across and along the groove, over those of the refinement box.
    """
    a, b = settings.semi
    wide, long = settings.reach  # the long axis lies across the groove, where ball and groove conform
    cell_a, cell_b = a / settings.b_over_h, b / settings.b_over_h
    zone_a, zone_b = MARGIN[0] * wide, MARGIN[1] * long
    if settings.element == "Q2":
        zone_a, zone_b = cell_a * np.ceil(zone_a / cell_a), cell_b * np.ceil(zone_b / cell_b)
    zone = (float(min(zone_a / half_widths[0], sockets.ZONE)), float(min(zone_b / half_widths[1], sockets.ZONE)))
    # near an edge, where the zone is hardly larger than the contact, smaller cells keep the outermost nodes outside
    cell_a = min(cell_a, max(4.0 * (zone[0] * half_widths[0] - wide), cell_a / TIGHT))
    across = patch.graded_cell_boundaries(zone[0], cell_a / half_widths[0], settings.growth)
    along = patch.graded_cell_boundaries(zone[1], cell_b / half_widths[1], settings.growth)
    depth = patch.growing_cell_boundaries(0.0, 1.0, cell_b / deep / settings.growth, settings.growth)
    return patch.PatchCellBoundaries(across, depth, along), zone


def choose_refinement_box_size(
    scene: Scene, m: GrooveMap, layout: BallLayout, sides: tuple[int, ...], dims: Dimensions, settings: Settings
) -> RefinementBoxSize:
    """Choose the size of the refinement boxes, holes in the coarse meshes for fine meshes around the contact ellipses.

    Parameters
    ----------
    scene : Scene
        Ball screw or bearing.
    m : GrooveMap
        Geometry of the track.
    layout : BallLayout
        Positions of the balls on the track.
    sides : tuple[int, ...]
        Groove flanks (0, 1: screw, 2, 3: nut) that carry contacts.
    dims : Dimensions
        Dimensions of the solid parts.
    settings : Settings
        Mesh settings: cell sizes, modes and element type.

    Returns
    -------
    RefinementBoxSize
        Size of the refinement boxes.

    Raises
    ------
    ValueError
        The parts leave no room for the refinement boxes.
    """
    nut, position = scene.nut, scene.nut.position
    low, high = dims.ends_of_meshed_screw(scene)
    ends = (max(position - nut.length / 2.0, low), min(position + nut.length / 2.0, high))
    radii = (scene.screw.outer_diameter / 2.0, dims.hole, dims.land, nut.outer_diameter / 2.0)
    largest = sockets.largest_fitting_refinement_box(m, layout, sides, *radii, ends, settings.reach)
    return replace(largest, edge_divisions=settings.cuts)


def reach_of_ellipses_along_groove(m: GrooveMap, side: int, angle: Array, across: Array, along: Array) -> float:
    """Compute how far contact ellipses extend along the groove from the middle line of the fine mesh (patch).

    The long axis of an ellipse lies across the helix, but the mesh lines of a patch lie at constant azimuth. Because of the
    lead angle, the ends of the long axis therefore lie ahead of the middle line and behind it.

    Parameters
    ----------
    m : GrooveMap
        Geometry of the track.
    side : int
        Groove flank: 0, 1 on the screw (left, right), 2, 3 on the nut.
    angle : (n,) Array
        Contact angles of n contacts [rad].
    across, along : (n,) Array
        Semi-axes across and along the groove [m].

    Returns
    -------
    float
        Largest distance at the pitch radius [m].
    """
    turn = np.linspace(0.0, 2.0 * np.pi, AROUND)
    gamma = angle[:, None] + across[:, None] / float(m.radius[side]) * np.cos(turn)
    r, _, psi = m.section_to_unrolled(*m.polar_to_section(side, gamma, np.array(m.radius[side])))
    middle = sockets.unrolled_nominal_contact_point(m, side)[2]
    ahead = psi - middle + along[:, None] * np.sin(turn) / np.hypot(r, m.rg)
    return float(m.R * np.abs(ahead).max(initial=0.0))


def ball_refinement_box_and_map(
    m: GrooveMap, groove_box_size: RefinementBoxSize, side: int, zone: tuple[float, float]
) -> tuple[BallRefinementBox, Callable[[Array], Array]]:
    """Return the ball's refinement box at a flank, and the function that maps local coordinates in it to points.

    In the contact zone the map places the ball's nodes exactly opposite to those of the groove.

    Parameters
    ----------
    m : GrooveMap
        Geometry of the track.
    groove_box_size : RefinementBoxSize
        Size of the groove's refinement box.
    side : int
        Groove flank: 0, 1 on the screw (left, right), 2, 3 on the nut.
    zone : tuple[float, float]
        Half widths of the contact zone across and along the groove, over those of the refinement box.

    Returns
    -------
    box : BallRefinementBox
        Refinement box of the ball.
    to_space : callable
        Function that maps local coordinates ``(n, 3)`` to points ``(n, 3)`` [m] in the ball's frame.
    """
    depth = ball_body.depth_of_ball_refinement_box(m, groove_box_size, side)
    box = BallRefinementBox(side, groove_box_size, depth, zone[1])
    return box, partial(ball_body.points_in_ball_refinement_box, m, box)


#: Edges [m] of first-order tetrahedra at a patch's rim, tried one by one; long ones may be turned inside out in space.
RIM_EDGES = (0.5e-3, 0.35e-3, 0.25e-3, 0.15e-3)

#: Ratio of the numbers of cells across the short semi-axis, in the coarser patch that only transfers loads (carrier) to the
#: contact's patch.
CARRIER = 0.5

#: Contact at which a body has a refinement box: azimuth [rad], axial position [m], and flank (0 to 3).
Place = tuple[float, float, int]

#: Function, arguments and class of a record, as for `rollbench.meshes.cache.Cache.get`.
Recipe = tuple[Callable[..., Any], tuple[Any, ...], type]


@dataclass(frozen=True)
class FlankSockets:
    """Refinement boxes of groove and ball at one flank: boxes in their coarse meshes that the fine contact meshes fill."""

    #: Meshed faces of the groove's refinement box.
    groove_socket: RefinementBoxFaces
    #: Meshed faces of the ball's refinement box.
    ball_socket: RefinementBoxFaces
    #: Size of the groove's refinement box.
    socket_size: RefinementBoxSize
    #: Half widths of the contact zone across and along the groove, over those of the refinement box.
    relative_zone_size: tuple[float, float]
    #: Half widths of the refinement box across and along the groove [m].
    half_widths: tuple[float, float]


@dataclass(frozen=True)
class PartMeshes:
    """Coarse meshes of screw, nut and ball of one geometry."""

    #: Coarse mesh of the screw.
    screw_mesh: CoarseGroovedBodyMesh
    #: Coarse mesh of the nut.
    nut_mesh: CoarseGroovedBodyMesh
    #: Coarse mesh of one ball.
    ball_mesh: CoarseBallMesh
    #: Size of the grooves' refinement boxes.
    socket_size: RefinementBoxSize
    #: Half widths of the contact zone across and along the groove, over those of the refinement box.
    relative_zone_size: tuple[float, float]
    #: Half widths of the refinement boxes across and along the groove [m].
    half_widths: tuple[float, float]

    def refinement_boxes_of_flank(self, side: int) -> FlankSockets:
        """Return the refinement boxes of groove and ball at a flank (0 to 3), which the fine contact meshes fill."""
        body = self.screw_mesh if side < 2 else self.nut_mesh
        sizes = self.socket_size, self.relative_zone_size, self.half_widths
        return FlankSockets(body.box_faces[side], self.ball_mesh.box_faces[side], *sizes)


def mesh_parts(
    scene: Scene,
    m: GrooveMap,
    layout: BallLayout,
    dims: Dimensions,
    sides: tuple[int, ...],
    settings: Settings,
    cache: Cache | None = None,
) -> PartMeshes:
    """Mesh screw, nut and one ball of a ball screw or bearing.

    Parameters
    ----------
    scene : Scene
        Ball screw or bearing.
    m : GrooveMap
        Geometry of the track.
    layout : BallLayout
        Positions of the balls on the track.
    dims : Dimensions
        Dimensions of the solid parts.
    sides : tuple[int, ...]
        Groove flanks (0, 1: screw, 2, 3: nut) that carry contacts.
    settings : Settings
        Mesh settings: cell sizes, modes and element type.
    cache : Cache, optional, default None
        Cache of meshes on disk; None: all parts are meshed.

    Returns
    -------
    PartMeshes
        The meshes.

    Raises
    ------
    ValueError
        There is no room for a refinement box, or gmsh finds no good mesh.
    """
    cache = cache or Cache(None)
    recipes, gather = list_part_mesh_calls(scene, m, layout, dims, sides, settings)
    return gather(*(cache.get(*recipe) for recipe in recipes))


def list_part_mesh_calls(
    scene: Scene, m: GrooveMap, layout: BallLayout, dims: Dimensions, sides: tuple[int, ...], settings: Settings
) -> tuple[list[Recipe], Callable[..., PartMeshes]]:
    """List the function calls that mesh screw, nut and one ball, which can run in parallel.

    The second result is a function that collects the three meshes.

    Parameters
    ----------
    scene : Scene
        Ball screw or bearing.
    m : GrooveMap
        Geometry of the track.
    layout : BallLayout
        Positions of the balls on the track.
    dims : Dimensions
        Dimensions of the solid parts.
    sides : tuple[int, ...]
        Groove flanks (0, 1: screw, 2, 3: nut) that carry contacts.
    settings : Settings
        Mesh settings: cell sizes, modes and element type.

    Returns
    -------
    recipes : list of Recipe
        Function, arguments and class of the meshes of screw, nut and ball.
    gather : callable
        Function that returns the `PartMeshes` of these three meshes.
    """
    size = choose_refinement_box_size(scene, m, layout, sides, dims, settings)
    widths = (size.gamma * float(m.radius.mean()), size.phi * m.R)
    _, zone = choose_patch_cells(settings, widths, size.depth)
    nut, middle = scene.nut, scene.nut.position
    ends = (middle - nut.length / 2.0, middle + nut.length / 2.0)
    on_screw, on_nut = (contact_positions_on_body(layout, sides, screw) for screw in (True, False))
    cells = (settings.fine, settings.coarse)
    screw_spec = GroovedBodySpec(
        dims.hole, scene.screw.outer_diameter / 2.0, *dims.ends_of_meshed_screw(scene), True, on_screw, size, *cells
    )
    nut_spec = GroovedBodySpec(
        dims.land, nut.outer_diameter / 2.0, *ends, False, on_nut, size, *cells, dims.groove_ends, nut.flange
    )
    ball_boxes = tuple(ball_refinement_box_and_map(m, size, s, zone)[0] for s in sides)
    bodies: list[Recipe] = [(mesh_grooved_body, (m, spec), CoarseGroovedBodyMesh) for spec in (screw_spec, nut_spec)]
    of_ball = (m, ball_boxes, settings.ball_fine, settings.ball_coarse, size.edge_divisions)
    ball = (mesh_ball_with_refinement_boxes, of_ball, CoarseBallMesh)
    return [*bodies, ball], partial(PartMeshes, socket_size=size, relative_zone_size=zone, half_widths=widths)


def contact_positions_on_body(layout: BallLayout, sides: tuple[int, ...], screw: bool) -> tuple[Place, ...]:
    """List the contacts of all balls on the screw, or on the nut, each as its azimuth, axial position and flank.

    Parameters
    ----------
    layout : BallLayout
        Positions of the balls on the track.
    sides : tuple[int, ...]
        Groove flanks (0, 1: screw, 2, 3: nut) that carry contacts.
    screw : bool
        True: contacts on the screw; False: contacts on the nut.

    Returns
    -------
    tuple[Place, ...]
        Azimuth [rad], axial position [m] and flank of each contact, ball after ball.
    """
    body_sides = [s for s in sides if (s < 2) == screw]
    return tuple((float(a), float(z), s) for a, z in zip(layout.azimuth, layout.z, strict=True) for s in body_sides)


def rotation_about_z(phi: float) -> Array:
    """Return the matrix of a rotation about z.

    Parameters
    ----------
    phi : float
        Angle of the rotation [rad].

    Returns
    -------
    (3, 3) Array
        Rotation matrix.
    """
    c, s = np.cos(phi), np.sin(phi)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def refinement_boxes_at_contact_azimuths(mesh: CoarseGroovedBodyMesh, contacts: tuple[Place, ...]) -> list[BodySocket]:
    """Create the refinement boxes of screw or nut, each with the rotation of its fine mesh to the contact's azimuth.

    Parameters
    ----------
    mesh : CoarseGroovedBodyMesh
        Mesh of the body.
    contacts : tuple[Place, ...]
        Azimuth [rad], axial position [m] and flank of its contacts, by `contact_positions_on_body`.

    Returns
    -------
    list[BodySocket]
        One refinement box for each contact.
    """
    return [BodySocket(n, rotation_about_z(x[0]), x[2]) for n, x in zip(mesh.nodes_on_box_faces, contacts, strict=True)]


def element_type_of_bodies(settings: Settings) -> Literal["P1", "P2"]:
    """Return the element type of the coarse meshes, whose order is that of the fine contact meshes.

    Parameters
    ----------
    settings : Settings
        Mesh settings: cell sizes, modes and element type.

    Returns
    -------
    "P1" or "P2"
        First-order or second-order tetrahedra.
    """
    return "P2" if settings.element == "Q2" else "P1"


def mesh_coarser_patch(
    meshes: PartMeshes | FlankSockets, box_faces: RefinementBoxFaces, to_space: Callable[[Array], Array], settings: Settings
) -> patch.PatchMesh | None:
    """Mesh a coarser patch of hexahedra in the same refinement box, which only transfers loads from a contact to its body.

    Parameters
    ----------
    meshes : PartMeshes | FlankSockets
        Size of the refinement boxes and their contact zone.
    box_faces : RefinementBoxFaces
        Mesh of the refinement box's faces.
    to_space : Callable[[Array], Array]
        Function that maps local coordinates ``(n, 3)`` to points ``(n, 3)`` [m].
    settings : Settings
        Mesh settings of the contact's patch.

    Returns
    -------
    PatchMesh | None
        The coarser patch; None for tetrahedra.
    """
    coarse = replace(settings, b_over_h=CARRIER * settings.b_over_h)
    return mesh_patch(meshes, box_faces, to_space, coarse) if settings.element == "Q2" else None


def mesh_patch(
    meshes: PartMeshes | FlankSockets, box_faces: RefinementBoxFaces, to_space: Callable[[Array], Array], settings: Settings
) -> patch.PatchMesh:
    """Mesh the patch (fine mesh) that fills a refinement box, with hexahedra or tetrahedra as the settings say.

    The hexahedra are graded; the tetrahedra are sized as in Lin's thesis.

    Parameters
    ----------
    meshes : PartMeshes | FlankSockets
        Size of the refinement boxes and their contact zone.
    box_faces : RefinementBoxFaces
        Mesh of the refinement box's faces.
    to_space : Callable[[Array], Array]
        Function that maps local coordinates ``(n, 3)`` to points ``(n, 3)`` [m].
    settings : Settings
        Mesh settings: cell sizes, modes and element type.

    Returns
    -------
    PatchMesh
        Fine mesh (patch) around the contact.

    Raises
    ------
    ValueError
        With every edge length of `RIM_EDGES` some tetrahedra are turned inside out.
    """
    lines, zone = choose_patch_cells(settings, meshes.half_widths, meshes.socket_size.depth)
    if settings.element == "Q2":
        return patch.mesh_hexahedral_patch(lines, zone, to_space, box_faces)
    for far in RIM_EDGES:
        box = patch_as_in_thesis(meshes.half_widths, meshes.socket_size.depth, zone, settings.tet, far)
        try:
            return patch.fit_tetrahedral_patch(mesh_patch_with_tetrahedra(box, box_faces), to_space, box_faces)
        except ValueError as error:
            fault = error
    raise fault


def contact_normals_of_patch(mesh: patch.PatchMesh, centre: Array) -> Array:
    """Compute the unit vectors from the ball's centre to the contact nodes of a patch.

    Parameters
    ----------
    mesh : PatchMesh
        Fine mesh (patch) around the contact.
    centre : (3,) Array
        Centre of the ball [m].

    Returns
    -------
    (c, 3) Array
        Unit vectors.
    """
    arms = mesh.points[mesh.contact_nodes] - centre
    return np.asarray(arms / np.linalg.norm(arms, axis=1)[:, None])
