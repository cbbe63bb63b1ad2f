"""Refinement boxes around the contacts of a screw or nut, which its coarse mesh leaves free: shape, faces, largest size.

A finer mesh (the contact patch) fills each box. A box is bounded by surfaces of constant depth below the groove and of
constant azimuth; its width in the section angle gamma (around the arc of the groove's cross-section) decreases with depth.
The local coordinates xi in a refinement box are the section angle in [-1, 1], the depth in [0, 1] and the azimuth in [-1,
1]. All refinement boxes of a flank are congruent, so that one patch fits them all.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise, product

import numpy as np

from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.helix import BallLayout
from rollbench.meshes.numerics import brentq
from rollbench.meshes.parts import SIDES

#: Default size of a refinement box: half width in the section angle gamma [rad]; depth, and half length along the track,
#: both as ratios to the ball's radius (1.2 mm and 1.24 mm for the ball radius 2.778 mm of case 1 of Lin's thesis).
GAMMA, DEPTH, ALONG = 0.30, 1.2 / 2.778, 1.24 / 2.778
#: Smallest accepted ratio of a refinement box's width, depth or length to its default.
LEAST = 0.4
#: Smallest accepted ratio of a refinement box's size to the default size near a flat end of the part, where the wall is too
#: thin for a deeper refinement box. Width and length are never smaller than the contact needs.
LIP = 0.1
#: Ratio of the half width and half length of the contact zone to those of the refinement box: default, and largest
#: accepted.
FILLED, ZONE = 0.6, 0.95
#: Ratio of a refinement box's width to the width that the contact needs, unless that takes more than half of the remaining
#: flank.
SPARE = 1.15
#: Width of the flank that a refinement box leaves free beside it, as a ratio to the refinement box's half width: default,
#: and where the contact needs more width.
BESIDE, CLOSE = 0.25, 0.03
#: Length of the track that is left free between two refinement boxes, as a ratio to the half length of a refinement box.
BETWEEN = 0.6
#: Thickness of the material under a refinement box, as a ratio to the refinement box's depth; and of the material between
#: the refinement box and a flat end or the next turn of the groove, as a ratio to the ball's radius.
UNDER, AWAY = 0.5, 0.12
#: Thickness of the material between a refinement box and a flat end where there is less room, as a ratio to the ball's
#: radius.
THIN = 0.05
#: Relative reduction of a refinement box's width at its bottom. It leaves room for the faces to bulge next to the groove's
#: edge.
TAPER = 0.2
#: Largest accepted distance of a ball's centre from the groove's centre line, as a ratio to the ball's radius.
ON_GROOVE = 1e-3
#: Shape in which the faces of a refinement box bulge while gmsh fills a body with cells (`mesh_refinement_box_faces`).
#: RAISED: heights of the bulge that are tried in turn, as ratios to the half width of the faces. RIDGE: smallest accepted
#: height of a rectangle's protruding diagonal above its other diagonal, as a ratio to their lengths. TWIST: coefficients,
#: for side faces and for the bottom, of the terms that twist every rectangle so that one diagonal protrudes. SKEW:
#: coefficient of a further twist, for rectangles that would stay flat because of the symmetry of a face.
RAISED, RIDGE, TWIST = (0.04, 0.06, 0.08), 1e-4, (0.8, 0.4)
SKEW = 0.2
#: Factors on the local coordinates that reverse the azimuth: a box on a left flank becomes one on the right flank.
AZIMUTH_TURNED = np.array([1.0, 1.0, -1.0])


#: Position of a contact: azimuth [rad] and axial position [m] of its ball, and the flank 0 to 3 on which it lies.
ContactPosition = tuple[float, float, int]


@dataclass(frozen=True)
class RefinementBoxSize:
    """Size of a refinement box: the box around a contact that a body's coarse mesh leaves free for a finer mesh."""

    #: Half width, as an angle around the arc of the groove's cross-section (section angle) [rad].
    gamma: float
    #: Depth below the groove's surface [m].
    depth: float
    #: Half length along the track, as an azimuth [rad].
    phi: float
    #: Number of equal parts into which the refinement box's edges are divided across the groove, in depth and along the
    #: groove.
    edge_divisions: tuple[int, int, int] = (2, 2, 2)


@dataclass(frozen=True)
class RefinementBoxFaces:
    """Triangle mesh of the five inner faces of a refinement box, where a body's coarse mesh meets the finer one."""

    #: Local coordinates of the nodes ``(k, 3)``: section angle in [-1, 1], depth in [0, 1], azimuth in [-1, 1].
    xi: Array
    #: Nodes of the second-order triangles ``(t, 6)``, as row indices of ``xi``.
    triangles: Index
    #: Midside node of each edge of the triangles; the key holds the edge's two corner nodes in ascending order.
    midside_node_of_edge: dict[tuple[int, int], int]


#: Mesh of the faces of a refinement box, and local coordinates of its corner nodes in the bulging shape that the faces have
#: while gmsh fills the body ``(c, 3)``.
BulgingBoxFaces = tuple[RefinementBoxFaces, Array]


def mesh_refinement_box_faces(point_map: Callable[[Array], Array], divisions: tuple[int, int, int]) -> BulgingBoxFaces:
    """Mesh the inner faces of a refinement box, and compute the shape in which they bulge while gmsh fills the body.

    While gmsh fills the body around the box with tetrahedra, the corner nodes of the box are displaced into the body; only
    the rim at the groove does not move. The bulging faces make the box convex: no flat tetrahedron fits between nodes of
    one face. The faces are divided into rectangles, each of which is cut into two triangles along the diagonal that
    protrudes farther into the body than the other one. The bulge is the smallest of the ratios `RAISED` at which this
    difference, relative to the diagonals' lengths, is at least `RIDGE` in every rectangle, or else the ratio at which its
    smallest value is largest.

    Parameters
    ----------
    point_map : Callable[[Array], Array]
        Function that maps local coordinates in the refinement box ``(n, 3)`` to points of the body ``(n, 3)`` [m].
    divisions : tuple[int, int, int]
        Number of equal parts into which the edges of the box are divided: across the groove, in depth and along the groove.

    Returns
    -------
    mesh : RefinementBoxFaces
        Mesh of the five faces in their final shape, without bulge.
    bulging : (c, 3) Array
        Local coordinates of the mesh's c corner nodes in the bulging shape.
    """
    lines = [np.linspace(low, 1.0, count + 1) for low, count in zip((-1.0, 0.0, -1.0), divisions, strict=True)]
    number: dict[tuple[int, ...], int] = {}
    squares = []
    for axis, end in ((0, 0), (0, divisions[0]), (1, divisions[1]), (2, 0), (2, divisions[2])):
        a, b = (k for k in range(3) if k != axis)
        for i, j in product(range(divisions[a]), range(divisions[b])):
            keys = [[end] * 3 for _ in range(4)]
            for key, (di, dj) in zip(keys, ((0, 0), (1, 0), (1, 1), (0, 1)), strict=True):
                key[a], key[b] = i + di, j + dj
            squares.append([number.setdefault(tuple(key), len(number)) for key in keys])
    step = np.array(list(number))
    xi = np.stack([lines[k][step[:, k]] for k in range(3)], axis=1)
    square, inside = np.array(squares), point_map(np.array([[0.0, 0.5, 0.0]]))[0]
    best = (-1.0, np.zeros(0), xi)
    for share in RAISED:
        raised = bulge_refinement_box_faces(xi, share)
        height = _heights_of_diagonals(point_map(raised), square, inside)
        best = max(best, (float(np.abs(height).min()), height, raised), key=lambda x: x[0])
        if best[0] >= RIDGE:
            break
    turned = np.where((best[1] > 0.0)[:, None], square, np.roll(square, 1, axis=1))
    return _add_midside_nodes(xi, turned[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)), best[2]


def mesh_refinement_box_of_flank(
    point_map_of_flank: Callable[[int], Callable[[Array], Array]], side: int, divisions: tuple[int, int, int]
) -> BulgingBoxFaces:
    """Mesh the inner faces of the refinement boxes on one flank of the groove; for details see `mesh_refinement_box_faces`.

    A rotation by 180 degrees about the radial line through the ball's centre maps left flanks onto right ones and reverses
    the azimuth. So the mesh for a right flank (SR, NR) is that for the left flank with reversed azimuth, node by node.

    Parameters
    ----------
    point_map_of_flank : Callable[[int], Callable[[Array], Array]]
        Function that returns, for the number of a flank, the function that maps local coordinates in its refinement box
        ``(n, 3)`` to points of the body ``(n, 3)`` [m].
    side : int
        Flank: 0 and 1 are left and right on the screw, 2 and 3 on the nut.
    divisions : tuple[int, int, int]
        Number of equal parts into which the edges of the box are divided: across the groove, in depth and along the groove.

    Returns
    -------
    mesh : RefinementBoxFaces
        Mesh of the five faces in their final shape, without bulge.
    bulging : (c, 3) Array
        Local coordinates of the mesh's c corner nodes in the bulging shape that they have while gmsh fills the body.
    """
    if side % 2 == 0:
        return mesh_refinement_box_faces(point_map_of_flank(side), divisions)
    left, raised = mesh_refinement_box_faces(point_map_of_flank(side - 1), divisions)
    turned = left.triangles[:, [0, 2, 1, 5, 4, 3]]
    return RefinementBoxFaces(left.xi * AZIMUTH_TURNED, turned, left.midside_node_of_edge), raised * AZIMUTH_TURNED


def bulge_refinement_box_faces(local_coordinates: Array, bulge_ratio: float) -> Array:
    """Move points on the faces of a refinement box away from its centre, so that the faces bulge; its rim does not move.

    Parameters
    ----------
    local_coordinates : (n, 3) Array
        Local coordinates of the points: section angle in [-1, 1], depth in [0, 1], azimuth in [-1, 1].
    bulge_ratio : float
        Approximate ratio of the largest displacement to the half width of the faces.

    Returns
    -------
    (n, 3) Array
        Local coordinates of the moved points.
    """
    a, u, b = local_coordinates.T
    rise, across, along = u * (2.0 - u), 1.0 - a * a, 1.0 - b * b
    bottom = u * u * (across + along + TWIST[1] * across * along + SKEW * a * b)
    side, end = (1.0 + bulge_ratio * (rise + TWIST[0] * u * (x + SKEW * y)) for x, y in ((along, b), (across, a)))
    return np.stack([a * side, u + bulge_ratio * bottom, b * end], axis=1)


def _heights_of_diagonals(points: Array, square: Index, inside: Array) -> Array:
    """Return how far the first diagonal of each quadrilateral lies outside the second one, relative to their lengths.

    ``points``: coordinates of the nodes ``(n, 3)`` [m]; ``square``: nodes of the quadrilaterals ``(s, 4)``, of which the
    first diagonal joins nodes 0 and 2, the second one nodes 1 and 3; ``inside``: a point inside the surface that the
    quadrilaterals form ``(3,)`` [m]. The ratios ``(s,)`` are positive where the first diagonal is farther from this point.
    """
    a, b, c, d = (points[square[:, k]] for k in range(4))
    out = np.cross(c - a, d - b)
    out = out * np.sign(np.einsum("sx,sx->s", out, 0.25 * (a + b + c + d) - inside))[:, None]
    area = np.linalg.norm(out, axis=1)
    return np.asarray(np.einsum("sx,sx->s", 0.5 * (a + c - b - d), out) / area**1.5)


def _add_midside_nodes(xi: Array, corners: Index) -> RefinementBoxFaces:
    """Add midside nodes to the linear triangles on the faces of a refinement box, and return the second-order mesh.

    ``xi``: local coordinates of the corner nodes ``(c, 3)``; ``corners``: corner nodes of the triangles ``(t, 3)``.
    """
    edges: dict[tuple[int, int], int] = {}
    rows = []
    for a, b, c in corners.tolist():
        pairs = [(min(pair), max(pair)) for pair in ((a, b), (b, c), (c, a))]
        rows.append([a, b, c, *(edges.setdefault(pair, len(xi) + len(edges)) for pair in pairs)])
    middle = np.array([0.5 * (xi[i] + xi[j]) for i, j in edges])
    return RefinementBoxFaces(np.concatenate([xi, middle]), np.array(rows, dtype=np.int64), edges)


def rim_nodes_of_refinement_box(box_faces: RefinementBoxFaces) -> Index:
    """Return the corner nodes around the rim of a refinement box, its open top at the groove's surface, in order.

    Parameters
    ----------
    box_faces : RefinementBoxFaces
        Mesh of the refinement box's faces.

    Returns
    -------
    (r,) Index
        Numbers of the nodes, once around the rim.
    """
    around: dict[int, list[int]] = {}
    for i, j in box_faces.midside_node_of_edge:
        if box_faces.xi[i, 1] == 0.0 and box_faces.xi[j, 1] == 0.0:
            around.setdefault(i, []).append(j)
            around.setdefault(j, []).append(i)
    loop = [min(around)]
    loop.append(min(around[loop[0]]))
    while (following := next(k for k in around[loop[-1]] if k != loop[-2])) != loop[0]:
        loop.append(following)
    return np.array(loop, dtype=np.int64)


def unrolled_nominal_contact_point(m: GrooveMap, side: int) -> tuple[float, float, float]:
    """Return the unrolled coordinates of the nominal contact point on a flank, for a ball at azimuth 0 and z = 0.

    Parameters
    ----------
    m : GrooveMap
        Groove surfaces of the track.
    side : int
        Flank: 0 and 1 are left and right on the screw, 2 and 3 on the nut.

    Returns
    -------
    r, zeta, psi : float
        Radius [m], axial coordinate along the unrolled groove [m] and azimuth [rad], as returned by
        `GrooveMap.section_to_unrolled`.
    """
    r, zeta, psi = m.flank_to_unrolled(side, np.array(m.beta))
    return float(r), float(zeta), float(psi)


def points_in_box_at_azimuth_zero(m: GrooveMap, size: RefinementBoxSize, side: int, xi: Array) -> Array:
    """Map local coordinates in a refinement box to points of the body, for the contact of a ball at azimuth 0 and z = 0.

    Parameters
    ----------
    m : GrooveMap
        Groove surfaces of the track.
    size : RefinementBoxSize
        Size of the refinement box.
    side : int
        Flank: 0 and 1 are left and right on the screw, 2 and 3 on the nut.
    xi : (n, 3) Array
        Local coordinates: section angle in [-1, 1], depth in [0, 1], azimuth in [-1, 1].

    Returns
    -------
    (n, 3) Array
        Cartesian coordinates of the points [m].
    """
    gamma = m.beta + size.gamma * xi[:, 0] * (1.0 - TAPER * xi[:, 1])
    rho = m.radius[side] + size.depth * xi[:, 1]
    r, zeta, _ = m.section_to_unrolled(*m.polar_to_section(side, gamma, rho))
    return m.unrolled_to_cartesian(r, zeta, unrolled_nominal_contact_point(m, side)[2] + size.phi * xi[:, 2])


def points_in_refinement_box(m: GrooveMap, size: RefinementBoxSize, ball_position: ContactPosition, xi: Array) -> Array:
    """Map local coordinates in a refinement box to points of the screw or nut, for the contact of a ball at any position.

    Parameters
    ----------
    m : GrooveMap
        Groove surfaces of the track.
    size : RefinementBoxSize
        Size of the refinement box.
    ball_position : ContactPosition
        Azimuth [rad] and axial position z [m] of the ball, and flank 0 to 3.
    xi : (n, 3) Array
        Local coordinates: section angle in [-1, 1], depth in [0, 1], azimuth in [-1, 1].

    Returns
    -------
    (n, 3) Array
        Cartesian coordinates of the points [m].
    """
    phi, z, side = ball_position
    c, s = np.cos(phi), np.sin(phi)
    turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(points_in_box_at_azimuth_zero(m, size, side, xi) @ turn + np.array([0.0, 0.0, z]))


def local_coordinates_in_refinement_box(
    m: GrooveMap, size: RefinementBoxSize, ball_position: ContactPosition, phi: Array, z: Array, r: Array
) -> Array:
    """Map points of a screw or nut to local coordinates in a refinement box; the inverse of `points_in_refinement_box`.

    Parameters
    ----------
    m, size, ball_position
        Groove surfaces of the track; size of the refinement box; and azimuth [rad] and axial position [m] of the ball with
        its flank 0 to 3, as for `points_in_refinement_box`.
    phi, z, r : (n,) Array
        Cylindrical coordinates of the points [rad, m, m].

    Returns
    -------
    (n, 3) Array
        Local coordinates: section angle in [-1, 1], depth in [0, 1], azimuth in [-1, 1].
    """
    ball_phi, ball_z, side = ball_position
    centre = ball_phi + unrolled_nominal_contact_point(m, side)[2]
    total = phi + 2.0 * np.pi * np.round((centre - phi) / (2.0 * np.pi))
    zeta = z - (ball_z - m.rg * ball_phi) - m.rg * total
    gamma, rho = m.section_to_polar(side, *m.unrolled_to_section(r, zeta))
    depth = (rho - m.radius[side]) / size.depth
    across = (gamma - m.beta) / (size.gamma * (1.0 - TAPER * depth))
    return np.stack([across, depth, (total - centre) / size.phi], axis=1)


def section_angles_of_flank(m: GrooveMap, side: int, land_radius: float) -> tuple[float, float]:
    """Return the section angles (around the arc of the groove's cross-section) at which a flank begins and ends.

    Parameters
    ----------
    m : GrooveMap
        Groove surfaces of the track.
    side : int
        Flank: 0 and 1 are left and right on the screw, 2 and 3 on the nut.
    land_radius : float
        Radius of the lands, the cylindrical surface between the turns of the groove [m].

    Returns
    -------
    low : float
        Angle at the apex between the two arcs of the groove [rad]; for a groove of one arc, at its other edge, -high.
    high : float
        Angle at the edge between groove and land [rad].

    Raises
    ------
    ValueError
        The nominal contact angle does not lie between the two angles.
    """
    apex = float(np.arcsin((m.radius[side] - m.ball) * np.sin(m.beta) / m.radius[side]))

    def radius_beyond_land(gamma: float) -> float:
        return float(m.flank_to_unrolled(side, np.array(gamma))[0]) - land_radius

    if radius_beyond_land(m.beta) * radius_beyond_land(np.pi) < 0.0:
        edge = float(brentq(radius_beyond_land, m.beta, np.pi, xtol=1e-14))
        return (-edge if m.has_single_arc else apex), edge
    raise ValueError(
        f"the {SIDES[side]} flank ends before its contact at {np.degrees(m.beta):.3g} deg: with a land radius of "
        f"{1e3 * land_radius:.4g} mm the groove does not reach that angle; move the land towards the pitch radius "
        f"{1e3 * m.R:.4g} mm (washers, whose grooves open in their faces, are not meshed)"
    )


def turns_and_distance_to_groove(m: GrooveMap, phi: float, z: float, helix_constant: float) -> tuple[int, float]:
    """Return the whole turns to add to a ball's azimuth, counted along a groove, and its axial distance from the groove.

    Azimuths along a helical groove increase by 2 pi with each turn.

    Parameters
    ----------
    m : GrooveMap
        Groove surfaces of the track.
    phi, z : float
        Azimuth [rad] and axial position [m] of the ball.
    helix_constant : float
        Constant z - r_g phi of the groove [m] from `helix_constants_of_starts`, with the lead per radian r_g.

    Returns
    -------
    turns : int
        Number of whole turns to add to the azimuth, so that z - r_g phi of the ball agrees best with ``helix_constant``.
    off : float
        Axial distance of the ball from the groove's centre line [m].
    """
    off = z - m.rg * phi - helix_constant
    pitch = 2.0 * np.pi * m.rg
    turns = round(off / pitch) if pitch else 0
    return turns, abs(off - turns * pitch)


def helix_constants_of_starts(m: GrooveMap) -> list[float]:
    """Return the constant z - r_g phi of the groove's helix for each thread start [m], with the lead per radian r_g.

    It is the axial position at which the helix crosses azimuth 0; for a bearing ring, the axial position of its one groove.

    Parameters
    ----------
    m : GrooveMap
        Groove surfaces of the track.

    Returns
    -------
    list[float]
        Axial positions [m], one for each thread start.
    """
    return [m.z0 - m.rg * (m.phase + 2.0 * np.pi * k / m.starts) for k in range(m.starts if m.rg else 1)]


def azimuth_gaps_between_balls(m: GrooveMap, azimuth: Array, z: Array) -> tuple[Array, Index]:
    """Return the differences in azimuth between neighbouring balls along the grooves.

    In a bearing ring, the last ball is a neighbour of the first.

    Parameters
    ----------
    m : GrooveMap
        Groove surfaces of the track.
    azimuth, z : (k,) Array
        Azimuths [rad] and axial positions [m] of the balls.

    Returns
    -------
    gaps : (n,) Array
        Difference in azimuth between the centres of the two balls of each pair [rad].
    pairs : (n, 2) Index
        Numbers of the two balls of each pair, counted from 0; no pairs for a single ball on a screw.
    """
    line = z - m.rg * azimuth
    pitch = 2.0 * np.pi * abs(m.rg)
    if pitch:  # one line for all turns of a start: unwrap whole turns
        turns = np.round((line - line[0]) / pitch * m.starts) // m.starts
        azimuth = azimuth + np.sign(m.rg) * 2.0 * np.pi * turns
        line = line - pitch * turns
    else:
        azimuth = np.mod(azimuth, 2.0 * np.pi)
    gaps: list[float] = []
    pairs: list[tuple[int, int]] = []
    keys = np.round((line - line[0]) / (0.01 * m.ball)).astype(int)
    for key in np.unique(keys):
        balls = np.flatnonzero(keys == key)
        balls = balls[np.argsort(azimuth[balls], kind="stable")]
        along = azimuth[balls]
        if not pitch:
            balls, along = np.append(balls, balls[0]), np.append(along, along[0] + 2.0 * np.pi)
        gaps += [float(g) for g in np.diff(along)]
        pairs += [(int(a), int(b)) for a, b in pairwise(balls)]
    return np.array(gaps), np.array(pairs, dtype=np.int64).reshape(-1, 2)


def _largest_fitting_factor(fits: Callable[[float], bool]) -> float:
    """Return the largest factor in [0, 1] for which ``fits`` returns True, by bisection; 0 where it is at most 1e-6."""
    if fits(1.0):
        return 1.0
    low, high = 0.0, 1.0
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if fits(middle) else (low, middle)
    return low if low > 1e-6 else 0.0


def _sample_points_in_refinement_box(m: GrooveMap, size: RefinementBoxSize, side: int) -> Array:
    """Return points on a regular grid that fills a refinement box, ``(n, 3)`` [m], for a ball at azimuth 0 and z = 0.

    ``m``: groove surfaces of the track; ``size``: size of the refinement box; ``side``: flank, 0 left and 1 right on
    the screw, 2 left and 3 right on the nut.
    """
    axes = (np.linspace(-1.0, 1.0, 7), np.linspace(0.0, 1.0, 3), np.linspace(-1.0, 1.0, 3))
    return points_in_box_at_azimuth_zero(m, size, side, np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3))


def wall_thickness_under_refinement_box(m: GrooveMap, size: RefinementBoxSize, side: int, wall_radius: float) -> float:
    """Return the thickness of the material between a refinement box and the screw's bore, or the nut's outer surface.

    Parameters
    ----------
    m : GrooveMap
        Groove surfaces of the track.
    size : RefinementBoxSize
        Size of the refinement box.
    side : int
        Flank: 0 and 1 are left and right on the screw, 2 and 3 on the nut.
    wall_radius : float
        Radius of the surface behind the groove [m]: the screw's bore (0 for a solid screw), or the nut's outer surface.

    Returns
    -------
    float
        Thickness [m]; negative where the refinement box reaches through the wall.
    """
    r = np.hypot(*_sample_points_in_refinement_box(m, size, side)[:, :2].T)
    return float(r.min() - wall_radius if side < 2 else wall_radius - r.max())


def axial_reach_of_refinement_boxes(m: GrooveMap, size: RefinementBoxSize, sides: tuple[int, ...]) -> tuple[float, float]:
    """Return how far the refinement boxes at the contacts of a ball extend along the axis from the ball's centre.

    Parameters
    ----------
    m : GrooveMap
        Groove surfaces of the track.
    size : RefinementBoxSize
        Size of the refinement boxes.
    sides : tuple[int, ...]
        Flanks with refinement boxes: 0 and 1 are left and right on the screw, 2 and 3 on the nut.

    Returns
    -------
    below, above : float
        Largest distance, over these flanks, in the direction -z, and in the direction +z [m].
    """
    z = np.concatenate([_sample_points_in_refinement_box(m, size, s)[:, 2] for s in sides])
    return float(-z.min()), float(z.max())


def distance_to_next_turn(m: GrooveMap, size: RefinementBoxSize, sides: tuple[int, ...]) -> float:
    """Return the smallest distance from the refinement boxes of a screw or nut to the next turn of its groove.

    Where both flanks carry contacts, the axial distance from the boxes to the middle between their own turn of the groove
    and the next one counts too.

    Parameters
    ----------
    m : GrooveMap
        Groove surfaces of the track.
    size : RefinementBoxSize
        Size of the refinement boxes.
    sides : tuple[int, ...]
        Flanks with refinement boxes: one or both of 0 and 1 (left and right on the screw), or of 2 and 3 (on the nut).

    Returns
    -------
    float
        Distance [m]; negative where a refinement box reaches into the next turn, infinite for a bearing ring.
    """
    if m.rg == 0.0:
        return np.inf
    pitch = 2.0 * np.pi * abs(m.rg) / m.starts
    distances = []
    for side in sides:
        x = _sample_points_in_refinement_box(m, size, side)
        r, zeta = np.hypot(x[:, 0], x[:, 1]), x[:, 2] - m.rg * np.arctan2(x[:, 1], x[:, 0])
        other = side ^ 1
        x3, z3 = m.unrolled_to_section(r, zeta - m.signs[side, 1] * pitch)
        away = [m.section_to_polar(s, x3, z3)[1] - m.radius[s] for s in (side, other)]
        distances.append(float(np.max(away, axis=0).min()))
        if other in sides:
            distances.append(float((0.5 * pitch - np.abs(zeta)).min()))
    return min(distances)


def largest_fitting_refinement_box(
    m: GrooveMap,
    layout: BallLayout,
    sides: tuple[int, ...],
    screw_land_radius: float,
    screw_bore_radius: float,
    nut_land_radius: float,
    nut_outer_radius: float,
    nut_end_positions: tuple[float, float],
    contact_half_lengths: tuple[float, float] = (0.0, 0.0),
) -> RefinementBoxSize:
    """Find the largest size, up to the default, of a refinement box that fits at every contact of a scene.

    A refinement box is the box around a contact that a body's coarse mesh leaves free for a finer mesh. The default size is
    a half width of 0.30 rad (more if the contacts fill more than 0.6 of it), a depth of 0.43 ball radii and a half length
    of 0.45 ball radii. The width is reduced if the groove's edge or apex is near, but not below what the contacts need; the
    depth is reduced over a thin wall, the length between close balls. Next to a flat end or to the next turn of the groove
    all three are reduced.

    Parameters
    ----------
    m : GrooveMap
        Groove surfaces of the track.
    layout : BallLayout
        Positions of the balls.
    sides : tuple[int, ...]
        Flanks that carry contacts: 0 and 1 are left and right on the screw, 2 and 3 on the nut.
    screw_land_radius, screw_bore_radius, nut_land_radius, nut_outer_radius : float
        Radii of the screw's lands and bore (0 for a solid screw), and of the nut's lands and outer surface [m].
    nut_end_positions : tuple[float, float]
        Axial positions of the nut's flat ends [m]; they are nearer to the balls than the ends of the screw.
    contact_half_lengths : tuple[float, float], default (0.0, 0.0)
        Half lengths of the contact zone about the nominal contact point: along the arc of the groove's section, and along
        the track [m].

    Returns
    -------
    RefinementBoxSize
        Size that fits all contacts.

    Raises
    ------
    ValueError
        A contact is wider than the flank between apex and edge allows; or less than 0.4 of the default depth, length or
        width remains (the width is checked only without ``contact_half_lengths``), or next to a flat end less than 0.1 of
        depth and length. The message gives cause and remedy.
    """
    across, along = contact_half_lengths
    usual = RefinementBoxSize(GAMMA, DEPTH * m.ball, ALONG * m.ball / m.R)
    least = max((across / float(m.radius[s]) for s in sides), default=0.0) / ZONE
    shortest = along / (ZONE * m.R)
    wide = replace(usual, gamma=max(GAMMA, least * ZONE / FILLED), phi=max(usual.phi, along / (FILLED * m.R)))
    gamma, why = _allowed_half_width(m, sides, screw_land_radius, nut_land_radius, wide.gamma, across)
    size, cause = replace(wide, gamma=gamma), {"gamma": why, "depth": "", "phi": ""}

    def mm(length: float) -> str:
        return f"{1e3 * length:.4g} mm"

    for side in sides:
        behind, name = (screw_bore_radius, "screw's bore") if side < 2 else (nut_outer_radius, "nut's outside")

        def wall_is_thick_enough(
            share: float, side: int = side, behind: float = behind, size: RefinementBoxSize = size
        ) -> bool:
            depth = share * wide.depth
            return wall_thickness_under_refinement_box(m, replace(size, depth=depth), side, behind) >= UNDER * depth

        depth = wide.depth * _largest_fitting_factor(wall_is_thick_enough)
        if depth < size.depth:
            size = replace(size, depth=depth)
            wall = wall_thickness_under_refinement_box(m, replace(size, gamma=1e-3, depth=0.0), side, behind)
            cause["depth"] = f"the wall between the contact and the {name} is only {mm(wall)} thick; thicken the wall"

    if layout.z.size > 1 or m.rg == 0.0:
        gaps, pairs = azimuth_gaps_between_balls(m, layout.azimuth, layout.z)
        if gaps.size and gaps.min() < (2.0 + BETWEEN) * wide.phi:
            size = replace(size, phi=float(gaps.min()) / (2.0 + BETWEEN))
            first, second = pairs[gaps.round(9).argmin()] + 1
            apart = mm(gaps.min() * m.R)
            cause["phi"] = f"balls {first} and {second} are only {apart} apart along the track; move them further apart"

    low, high = layout.z.min() - nut_end_positions[0], nut_end_positions[1] - layout.z.max()
    bodies = [body for body in (tuple(s for s in sides if (s < 2) == screw) for screw in (True, False)) if body]

    def scaled_refinement_box(share: float) -> RefinementBoxSize:
        narrow, short = max(share * size.gamma, min(size.gamma, least)), max(share * size.phi, min(size.phi, shortest))
        return replace(size, gamma=narrow, depth=share * size.depth, phi=short)

    def fits_between_ends(share: float, away: float = AWAY) -> bool:
        below, above = axial_reach_of_refinement_boxes(m, scaled_refinement_box(share), sides)
        return bool(below + away * m.ball <= low and above + away * m.ball <= high)

    def clears_next_turn(share: float) -> bool:
        box = scaled_refinement_box(share)
        return min(distance_to_next_turn(m, box, body) for body in bodies) >= AWAY * m.ball

    lip = not fits_between_ends(LEAST)
    ends = f"the outermost balls are only {mm(low)} and {mm(high)} from the flat ends; lengthen the nut or move the balls"
    turn = f"the next turn of the groove is only {mm(2.0 * np.pi * abs(m.rg) / m.starts)} away; raise the lead"
    for fits, why in ((partial(fits_between_ends, away=THIN if lip else AWAY), ends), (clears_next_turn, turn)):
        share = _largest_fitting_factor(fits)
        if share < 1.0:
            size = scaled_refinement_box(share) if share else replace(size, gamma=0.0, depth=0.0, phi=0.0)
            cause = dict.fromkeys(cause, why)
    fraction = LIP if lip else LEAST
    for name, word, floor in (
        ("gamma", "narrow", least or LEAST * GAMMA),
        ("depth", "shallow", fraction * usual.depth),
        ("phi", "short", max(fraction * usual.phi, shortest)),
    ):
        if getattr(size, name) < floor * (1.0 - 1e-9):
            left, wanted = getattr(size, name) / getattr(usual, name), floor / getattr(usual, name)
            raise ValueError(
                f"no room for the fine mesh around the contacts: only {100.0 * left:.0f} % of its default size remains, "
                f"less than the required {100.0 * wanted:.0f} % (too {word}), because {cause[name]}"
            )
    return size


def _allowed_half_width(
    m: GrooveMap, sides: tuple[int, ...], land_screw: float, land_nut: float, wanted: float, need: float
) -> tuple[float, str]:
    """Return the half width of refinement boxes that the edge and the apex of the grooves allow, and what limits it.

    Parameters
    ----------
    m : GrooveMap
        Groove surfaces of the track.
    sides : tuple[int, ...]
        Flanks that carry contacts: 0 and 1 are left and right on the screw, 2 and 3 on the nut.
    land_screw, land_nut : float
        Radii of the screw's and of the nut's lands [m].
    wanted : float
        Half width that is returned where nothing limits it [rad].
    need : float
        Half length of the contact zone along the arc of the groove's section [m].

    Returns
    -------
    gamma : float
        Allowed half width, at most ``wanted`` [rad].
    reason : str
        Which edge or apex limits the width, and how to change the groove, for an error message; empty without limit.

    Raises
    ------
    ValueError
        The contact zone needs a larger half width than edge and apex allow.
    """
    gamma, why = wanted, ""
    for side in sides:
        land, radius = land_screw if side < 2 else land_nut, float(m.radius[side])
        apex, edge = section_angles_of_flank(m, side, land)
        at_land = f"the groove, at the land radius of {1e3 * land:.4g} mm,"
        low_end, remedy_low = "apex between the two arcs", "bring the groove radius closer to the ball's"
        if m.has_single_arc:
            low_end, remedy_low = f"other edge of {at_land}", "deepen the groove"
        for room, name, remedy in (
            (m.beta - apex, low_end, remedy_low),
            (edge - m.beta, f"edge of {at_land}", "deepen the groove"),
        ):
            reason = f"the {name} is {np.degrees(room):.3g} deg from the contact of flank {SIDES[side]}"
            usable = ZONE * room / (1.0 + CLOSE)
            if need / radius > usable:
                raise ValueError(
                    f"no room for the contact ellipse on flank {SIDES[side]}: it extends {1e3 * need:.3g} mm "
                    f"({np.degrees(need / radius):.3g} deg of the groove arc) from the nominal contact point, and the mesh "
                    f"has room for {1e3 * usable * radius:.3g} mm ({np.degrees(usable):.3g} deg), because {reason}. "
                    f"Remedies: {remedy}; lower the load; or open the groove (a larger groove radius makes the ellipse "
                    "shorter)"
                )
            bare = need / (radius * ZONE)
            width = max(room / (1.0 + BESIDE), min(SPARE * bare, 0.5 * (bare + room / (1.0 + CLOSE))))
            if width < gamma:
                gamma, why = width, f"{reason}; {remedy}"
    return gamma, why
