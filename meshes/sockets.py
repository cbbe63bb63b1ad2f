"""Sockets: boxes left free around contacts for fine patches; their shape, faces and largest size.

A socket is bounded by surfaces of constant depth and azimuth; in gamma it narrows with its depth. Its local coordinates
xi are gamma and azimuth in [-1, 1] and depth in [0, 1]; all sockets of a flank are congruent, so that one patch fits them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise, product

import numpy as np

from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.helix import BallLayout
from rollbench.meshes.numerics import brentq
from rollbench.meshes.parts import SIDES

#: Usual socket: half width in gamma [rad]; depth and half length along the track over the ball's radius
#: (1.2 mm and 1.24 mm with the balls of 2.778 mm of Lin's case 1).
GAMMA, DEPTH, ALONG = 0.30, 1.2 / 2.778, 1.24 / 2.778
#: Smallest share of that size that is accepted.
LEAST = 0.4
#: That share near a flat end, where the wall leaves no more depth; contacts keep the width and length that they need.
LIP = 0.1
#: Share of a socket's half width and length that its contact zone fills: usually, and at most.
FILLED, ZONE = 0.6, 0.95
#: Width of sockets for contacts over the required one, unless that takes more than half of the remaining flank.
SPARE = 1.15
#: Flank kept free next to a socket, over its half width: usually, and where the contact needs more width.
BESIDE, CLOSE = 0.25, 0.03
#: Track kept free between two sockets, over their half length.
BETWEEN = 0.6
#: Material kept under a socket, over its depth; and from it to an end or to the next turn, over the ball's radius.
UNDER, AWAY = 0.5, 0.12
#: Material kept to an end, where no more is available.
THIN = 0.05
#: Relative reduction of a socket's width at its bottom: leaves room for its faces to bulge next to the edge of a groove.
TAPER = 0.2
#: Largest distance of a ball from its groove, over its radius.
ON_GROOVE = 1e-3
#: Shares tried by which a socket's faces bulge while a body is filled, see `socket_mesh`, and how far diagonals stand out
#: then at least, over their lengths; terms that twist the rectangles of side faces and bottom, so that one diagonal does,
#: and those in the middle of symmetric faces too.
RAISED, RIDGE, TWIST = (0.04, 0.06, 0.08), 1e-4, (0.8, 0.4)
SKEW = 0.2
AZIMUTH_TURNED = np.array([1.0, 1.0, -1.0])


@dataclass(frozen=True)
class SocketSize:
    """Size of a socket: the box left free in the mesh of a body around a contact, filled by a fine patch."""

    #: Half width in the section angle [rad].
    gamma: float
    #: Depth below the groove's surface [m].
    depth: float
    #: Half width in azimuth [rad].
    phi: float
    #: Subdivisions of its edges across, in depth and along.
    cuts: tuple[int, int, int] = (2, 2, 2)


@dataclass(frozen=True)
class SocketMesh:
    """Mesh of the five inner faces of a socket, which body and patch share."""

    #: Nodes in local coordinates ``(k, 3)``: gamma and azimuth in [-1, 1], depth in [0, 1].
    xi: Array
    #: Second-order triangles ``(t, 6)``.
    triangles: Index
    #: Number of the face on which each triangle lies ``(t,)``.
    face: Index
    #: Node in the middle of every edge, by its two corners.
    edges: dict[tuple[int, int], int]


def socket_mesh(place: Callable[[Array], Array], cuts: tuple[int, int, int]) -> tuple[SocketMesh, Array]:
    """Mesh of a socket's inner faces, and coordinates of their corners at which the faces bulge into the body.

    While a body is filled with cells, the corners of its sockets are at the bulging coordinates; the rim stays. A
    tetrahedron with all corners on a convex socket lies in the socket, so that none fits flat over a bulging face. Of the
    two diagonals of a rectangle the one that stands out into the body is taken; of the shares `RAISED`, the least with
    which all stand out by `RIDGE`, or else the best.

    Parameters
    ----------
    place : Callable[[Array], Array]
        Points ``(n, 3)`` [m] of local coordinates ``(n, 3)``.
    cuts : tuple[int, int, int]
        Equal parts of the edges across, in depth and along.

    Returns
    -------
    mesh : SocketMesh
        The faces.
    bulging : (c, 3) Array
        Local coordinates of the corners while the body is filled.
    """
    lines = (np.linspace(-1.0, 1.0, cuts[0] + 1), np.linspace(0.0, 1.0, cuts[1] + 1), np.linspace(-1.0, 1.0, cuts[2] + 1))
    number: dict[tuple[int, ...], int] = {}
    squares, owner = [], []
    for face, (axis, end) in enumerate(((0, 0), (0, cuts[0]), (1, cuts[1]), (2, 0), (2, cuts[2]))):
        a, b = (k for k in range(3) if k != axis)
        for i, j in product(range(cuts[a]), range(cuts[b])):
            keys = [[end] * 3 for _ in range(4)]
            for key, (di, dj) in zip(keys, ((0, 0), (1, 0), (1, 1), (0, 1)), strict=True):
                key[a], key[b] = i + di, j + dj
            squares.append([number.setdefault(tuple(key), len(number)) for key in keys])
            owner.append(face)
    step = np.array(list(number))
    xi = np.stack([lines[k][step[:, k]] for k in range(3)], axis=1)
    square, inside = np.array(squares), place(np.array([[0.0, 0.5, 0.0]]))[0]
    best = (-1.0, np.zeros(0), xi)
    for share in RAISED:
        raised = bulge_faces(xi, share)
        height = _ridge_heights(place(raised), square, inside)
        best = max(best, (float(np.abs(height).min()), height, raised), key=lambda x: x[0])
        if best[0] >= RIDGE:
            break
    turned = np.where((best[1] > 0.0)[:, None], square, np.roll(square, 1, axis=1))
    return _second_order(xi, turned[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3), np.repeat(owner, 2)), best[2]


def side_socket(
    places: Callable[[int], Callable[[Array], Array]], side: int, cuts: tuple[int, int, int]
) -> tuple[SocketMesh, Array]:
    """Mesh of the sockets of one flank, as `socket_mesh`.

    A turn by 180 degrees about the radius through the ball's centre takes left flanks onto right ones and reverses
    azimuths. So the socket of a right flank (SR, NR) is that of the left one with azimuths reversed, node by node.

    Parameters
    ----------
    places : Callable[[int], Callable[[Array], Array]]
        Map of local coordinates to points, by flank.
    side : int
        Flank 0 to 3.
    cuts : tuple[int, int, int]
        As for `socket_mesh`.

    Returns
    -------
    mesh : SocketMesh
        The faces.
    bulging : (c, 3) Array
        Local coordinates of the corners while the body is filled.
    """
    if side % 2 == 0:
        return socket_mesh(places(side), cuts)
    left, raised = socket_mesh(places(side - 1), cuts)
    turned = left.triangles[:, [0, 2, 1, 5, 4, 3]]
    face = np.where(left.face >= 3, 7 - left.face, left.face)
    return SocketMesh(left.xi * AZIMUTH_TURNED, turned, face, left.edges), raised * AZIMUTH_TURNED


def bulge_faces(xi: Array, share: float) -> Array:
    """Local coordinates of a socket's faces moved outwards; the rim stays.

    Parameters
    ----------
    xi : (n, 3) Array
        Local coordinates on the faces.
    share : float
        Displacement over the size of the faces, about.

    Returns
    -------
    (n, 3) Array
        Moved local coordinates.
    """
    a, u, b = xi.T
    rise, across, along = u * (2.0 - u), 1.0 - a * a, 1.0 - b * b
    bottom = u * u * (across + along + TWIST[1] * across * along + SKEW * a * b)
    side, end = (1.0 + share * (rise + TWIST[0] * u * (x + SKEW * y)) for x, y in ((along, b), (across, a)))
    return np.stack([a * side, u + share * bottom, b * end], axis=1)


def _ridge_heights(points: Array, square: Index, inside: Array) -> Array:
    """How far the first diagonal of quadrilaterals ``(s, 4)`` lies outside the second, over their lengths ``(s,)``."""
    a, b, c, d = (points[square[:, k]] for k in range(4))
    out = np.cross(c - a, d - b)
    out = out * np.sign(np.einsum("sx,sx->s", out, 0.25 * (a + b + c + d) - inside))[:, None]
    area = np.linalg.norm(out, axis=1)
    return np.asarray(np.einsum("sx,sx->s", 0.5 * (a + c - b - d), out) / area**1.5)


def _second_order(xi: Array, corners: Index, owner: Index) -> SocketMesh:
    """Second-order triangles from those of corners ``(t, 3)``."""
    edges: dict[tuple[int, int], int] = {}
    rows = []
    for a, b, c in corners.tolist():
        pairs = [(min(pair), max(pair)) for pair in ((a, b), (b, c), (c, a))]
        rows.append([a, b, c, *(edges.setdefault(pair, len(xi) + len(edges)) for pair in pairs)])
    middle = np.array([0.5 * (xi[i] + xi[j]) for i, j in edges])
    return SocketMesh(np.concatenate([xi, middle]), np.array(rows, dtype=np.int64), owner, edges)


def socket_rim(socket: SocketMesh) -> Index:
    """Corners around the open top of a socket, in order.

    Parameters
    ----------
    socket : SocketMesh
        Mesh of the faces.

    Returns
    -------
    (r,) Index
        Nodes, around the rim.
    """
    around: dict[int, list[int]] = {}
    for i, j in socket.edges:
        if socket.xi[i, 1] == 0.0 and socket.xi[j, 1] == 0.0:
            around.setdefault(i, []).append(j)
            around.setdefault(j, []).append(i)
    loop = [min(around)]
    loop.append(min(around[loop[0]]))
    while (following := next(k for k in around[loop[-1]] if k != loop[-2])) != loop[0]:
        loop.append(following)
    return np.array(loop, dtype=np.int64)


def socket_centre(m: GrooveMap, side: int) -> tuple[float, float, float]:
    """Unrolled coordinates of the nominal contact point of a flank.

    Parameters
    ----------
    m : GrooveMap
        Track.
    side : int
        Flank 0 to 3.

    Returns
    -------
    r, zeta, psi : float
        As of `GrooveMap.unroll` [m, m, rad].
    """
    x3, z3 = m.section_point(side, np.array(m.beta), np.array(m.radius[side]))
    r, zeta, psi = m.unroll(x3, z3)
    return float(r), float(zeta), float(psi)


def local_points(m: GrooveMap, size: SocketSize, side: int, xi: Array) -> Array:
    """Points of local socket coordinates, for a ball at azimuth 0 and z = 0.

    Parameters
    ----------
    m : GrooveMap
        Track.
    size : SocketSize
        Size of the socket.
    side : int
        Flank 0 to 3.
    xi : (n, 3) Array
        Local coordinates.

    Returns
    -------
    (n, 3) Array
        Points [m].
    """
    gamma = m.beta + size.gamma * xi[:, 0] * (1.0 - TAPER * xi[:, 1])
    rho = m.radius[side] + size.depth * xi[:, 1]
    r, zeta, _ = m.unroll(*m.section_point(side, gamma, rho))
    return m.space(r, zeta, socket_centre(m, side)[2] + size.phi * xi[:, 2])


def socket_points(m: GrooveMap, size: SocketSize, socket: tuple[float, float, int], xi: Array) -> Array:
    """Points of local coordinates in the socket of a ball.

    Parameters
    ----------
    m : GrooveMap
        Track.
    size : SocketSize
        Size of the socket.
    socket : tuple[float, float, int]
        Azimuth [rad] and station [m] of the ball, and flank 0 to 3.
    xi : (n, 3) Array
        Local coordinates.

    Returns
    -------
    (n, 3) Array
        Points [m].
    """
    phi, z, side = socket
    c, s = np.cos(phi), np.sin(phi)
    turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(local_points(m, size, side, xi) @ turn + np.array([0.0, 0.0, z]))


def socket_coordinates(
    m: GrooveMap, size: SocketSize, socket: tuple[float, float, int], phi: Array, z: Array, r: Array
) -> Array:
    """Local socket coordinates of points; the inverse of `socket_points`.

    Parameters
    ----------
    m, size, socket
        As for `socket_points`.
    phi, z, r : (n,) Array
        Cylindrical coordinates of the points [rad, m, m].

    Returns
    -------
    (n, 3) Array
        Local coordinates.
    """
    ball_phi, ball_z, side = socket
    centre = ball_phi + socket_centre(m, side)[2]
    total = phi + 2.0 * np.pi * np.round((centre - phi) / (2.0 * np.pi))
    zeta = z - (ball_z - m.rg * ball_phi) - m.rg * total
    gamma, rho = m.polar(side, *m.roll(r, zeta))
    depth = (rho - m.radius[side]) / size.depth
    across = (gamma - m.beta) / (size.gamma * (1.0 - TAPER * depth))
    return np.stack([across, depth, (total - centre) / size.phi], axis=1)


def flank_limits(m: GrooveMap, side: int, land: float) -> tuple[float, float]:
    """Section angles between which a flank extends.

    Parameters
    ----------
    m : GrooveMap
        Track.
    side : int
        Flank 0 to 3.
    land : float
        Radius of the lands [m].

    Returns
    -------
    low : float
        Angle of the apex [rad]; of a groove of one arc, of its other edge.
    high : float
        Angle of the edge at the land [rad].

    Raises
    ------
    ValueError
        The contact does not lie between the two.
    """
    apex = float(np.arcsin((m.radius[side] - m.ball) * np.sin(m.beta) / m.radius[side]))

    def excess(gamma: float) -> float:
        return float(m.unroll(*m.section_point(side, np.array(gamma), np.array(m.radius[side])))[0]) - land

    if excess(m.beta) * excess(np.pi) < 0.0:
        edge = float(brentq(excess, m.beta, np.pi, xtol=1e-14))
        return (-edge if m.one_arc else apex), edge
    raise ValueError(
        f"the {SIDES[side]} flank ends before its contact at {np.degrees(m.beta):.3g} deg: a land radius of "
        f"{1e3 * land:.4g} mm leaves no groove there; move the land towards the pitch radius {1e3 * m.R:.4g} mm"
    )


def whole_turns(m: GrooveMap, phi: float, z: float, line: float) -> tuple[int, float]:
    """Whole turns by which a ball's azimuth differs from that along a groove.

    Parameters
    ----------
    m : GrooveMap
        Track.
    phi, z : float
        Azimuth [rad] and station [m] of the ball.
    line : float
        z - r_g phi of the groove [m], by `groove_lines`.

    Returns
    -------
    turns : int
        Turns to add to the azimuth.
    off : float
        Distance along z that is left [m].
    """
    off = z - m.rg * phi - line
    pitch = 2.0 * np.pi * m.rg
    turns = round(off / pitch) if pitch else 0
    return turns, abs(off - turns * pitch)


def groove_lines(m: GrooveMap) -> list[float]:
    """Height z - r_g phi of every start's groove [m]; one entry for a ring.

    Parameters
    ----------
    m : GrooveMap
        Track.

    Returns
    -------
    list[float]
        Heights [m].
    """
    return [m.z0 - m.rg * (m.phase + 2.0 * np.pi * k / m.starts) for k in range(m.starts if m.rg else 1)]


def track_gaps(m: GrooveMap, azimuth: Array, z: Array) -> tuple[Array, Index]:
    """Angles between neighbouring balls along the grooves.

    In a ring the last ball is a neighbour of the first.

    Parameters
    ----------
    m : GrooveMap
        Track.
    azimuth, z : (k,) Array
        Azimuths [rad] and stations [m] of the balls.

    Returns
    -------
    gaps : (n,) Array
        Angles from ball to ball [rad].
    pairs : (n, 2) Index
        Numbers of these balls.
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


def _largest_share(fits: Callable[[float], bool]) -> float:
    """Largest share in [0, 1] that fits, by bisection; 0 where none does."""
    if fits(1.0):
        return 1.0
    low, high = 0.0, 1.0
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if fits(middle) else (low, middle)
    return low if low > 1e-6 else 0.0


def _hull_points(m: GrooveMap, size: SocketSize, side: int) -> Array:
    """Points all over a socket of the ball at azimuth 0, z = 0, ``(n, 3)`` [m]."""
    axes = (np.linspace(-1.0, 1.0, 7), np.linspace(0.0, 1.0, 3), np.linspace(-1.0, 1.0, 3))
    return local_points(m, size, side, np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3))


def wall_left(m: GrooveMap, size: SocketSize, side: int, beyond: float) -> float:
    """Wall thickness between a socket and the surface behind it.

    Parameters
    ----------
    m : GrooveMap
        Track.
    size : SocketSize
        Size of the socket.
    side : int
        Flank 0 to 3.
    beyond : float
        Radius of the bore, or of a nut's outside [m].

    Returns
    -------
    float
        [m]; negative where the socket reaches through the wall.
    """
    r = np.hypot(*_hull_points(m, size, side)[:, :2].T)
    return float(r.min() - beyond if side < 2 else beyond - r.max())


def socket_reach(m: GrooveMap, size: SocketSize, sides: tuple[int, ...]) -> tuple[float, float]:
    """Distances along z by which sockets reach below and above the ball's centre [m].

    Parameters
    ----------
    m : GrooveMap
        Track.
    size : SocketSize
        Size of the sockets.
    sides : tuple[int, ...]
        Flanks 0 to 3.

    Returns
    -------
    below, above : float
        [m].
    """
    z = np.concatenate([_hull_points(m, size, s)[:, 2] for s in sides])
    return float(-z.min()), float(z.max())


def turn_left(m: GrooveMap, size: SocketSize, sides: tuple[int, ...]) -> float:
    """Smallest distance of sockets from the next turn of the groove.

    From half-way to it where both flanks carry contacts.

    Parameters
    ----------
    m : GrooveMap
        Track.
    size : SocketSize
        Size of the sockets.
    sides : tuple[int, ...]
        Flanks of one body.

    Returns
    -------
    float
        [m]; infinite for a ring.
    """
    if m.rg == 0.0:
        return np.inf
    pitch = 2.0 * np.pi * abs(m.rg) / m.starts
    distances = []
    for side in sides:
        x = _hull_points(m, size, side)
        r, zeta = np.hypot(x[:, 0], x[:, 1]), x[:, 2] - m.rg * np.arctan2(x[:, 1], x[:, 0])
        other = side ^ 1
        x3, z3 = m.roll(r, zeta - m.signs[side, 1] * pitch)
        away = [m.polar(s, x3, z3)[1] - m.radius[s] for s in (side, other)]
        distances.append(float(np.max(away, axis=0).min()))
        if other in sides:
            distances.append(float((0.5 * pitch - np.abs(zeta)).min()))
    return min(distances)


def fitted_socket(
    m: GrooveMap,
    layout: BallLayout,
    sides: tuple[int, ...],
    land_screw: float,
    bore_screw: float,
    land_nut: float,
    outer_nut: float,
    ends: tuple[float, float],
    need: tuple[float, float] = (0.0, 0.0),
) -> SocketSize:
    """Largest socket, up to the usual one, that fits every ball on all of some sides.

    The usual socket is 0.30 rad wide to each side, or wider if the contacts fill more than 0.6 of that, 0.43 ball radii
    deep and 0.45 ball radii long to each side. It is made narrower beside the groove's edge and its apex, though not
    narrower than the contacts need; shallower over a thin wall; shorter between close balls; smaller altogether beside an
    end or the next turn of the groove.

    Parameters
    ----------
    m : GrooveMap
        Track.
    layout : BallLayout
        Places of the balls.
    sides : tuple[int, ...]
        Flanks 0 to 3 that carry contacts.
    land_screw, bore_screw, land_nut, outer_nut : float
        Radii [m].
    ends : tuple[float, float]
        Stations of the flat ends nearest the balls (the nut's) [m].
    need : tuple[float, float], optional
        Distances that contacts reach from their nominal middle, across along the groove's arc and along the track
        [m].

    Returns
    -------
    SocketSize
        Size that fits all contacts.

    Raises
    ------
    ValueError
        A contact reaches beyond what apex and edge leave to a socket, or less than 0.4 of the usual depth, length or
        (without ``need``) width is left, 0.1 of depth and length beside an end. The message gives cause and remedy.
    """
    usual = SocketSize(GAMMA, DEPTH * m.ball, ALONG * m.ball / m.R)
    bodies = [tuple(s for s in sides if (s < 2) == screw) for screw in (True, False)]
    least = max((need[0] / float(m.radius[s]) for s in sides), default=0.0) / ZONE
    wide = replace(usual, gamma=max(GAMMA, least * ZONE / FILLED), phi=max(usual.phi, need[1] / (FILLED * m.R)))
    gamma, why_gamma = _narrowed_width(m, sides, land_screw, land_nut, wide.gamma, need[0])
    size = replace(wide, gamma=gamma)
    cause = {"gamma": why_gamma, "depth": "", "phi": ""}

    def mm(x: float) -> str:
        return f"{1e3 * x:.4g} mm"

    for side in sides:
        behind, name = (bore_screw, "screw's bore") if side < 2 else (outer_nut, "nut's outside")

        def thick(share: float, side: int = side, behind: float = behind, size: SocketSize = size) -> bool:
            depth = share * wide.depth
            return wall_left(m, replace(size, depth=depth), side, behind) >= UNDER * depth

        depth = wide.depth * _largest_share(thick)
        if depth < size.depth:
            size = replace(size, depth=depth)
            wall = wall_left(m, replace(size, gamma=1e-3, depth=0.0), side, behind)
            cause["depth"] = f"the wall behind its contact, to the {name}, is {mm(wall)} thick; thicken it"

    if layout.z.size > 1 or m.rg == 0.0:
        gaps, pairs = track_gaps(m, layout.azimuth, layout.z)
        if gaps.size and gaps.min() < (2.0 + BETWEEN) * wide.phi:
            size = replace(size, phi=float(gaps.min()) / (2.0 + BETWEEN))
            first, second = pairs[gaps.round(9).argmin()] + 1
            cause["phi"] = f"balls {first} and {second} are {mm(gaps.min() * m.R)} apart along the track; spread them"

    low, high = layout.z.min() - ends[0], ends[1] - layout.z.max()

    def scaled(share: float) -> SocketSize:
        narrow = max(share * size.gamma, min(size.gamma, least))
        short = max(share * size.phi, min(size.phi, need[1] / (ZONE * m.R)))
        return replace(size, gamma=narrow, depth=share * size.depth, phi=short)

    def inside(share: float, away: float = AWAY) -> bool:
        below, above = socket_reach(m, scaled(share), sides)
        return bool(below + away * m.ball <= low and above + away * m.ball <= high)

    def just_inside(share: float) -> bool:
        return inside(share, THIN)

    def clear(share: float) -> bool:
        return min(turn_left(m, scaled(share), body_sides) for body_sides in bodies if body_sides) >= AWAY * m.ball

    lip = not inside(LEAST)
    for fits, why in (
        (
            just_inside if lip else inside,
            f"the outermost balls are {mm(low)} and {mm(high)} from the flat ends; lengthen the nut or move balls",
        ),
        (clear, f"the next turn of the groove is {mm(2.0 * np.pi * abs(m.rg) / m.starts)} on; raise the lead"),
    ):
        share = _largest_share(fits)
        if share < 1.0:
            size = scaled(share) if share else replace(size, gamma=0.0, depth=0.0, phi=0.0)
            cause = dict.fromkeys(cause, why)
    for name, word, floor in (
        ("gamma", "narrow", least or LEAST * GAMMA),
        ("depth", "shallow", (LIP if lip else LEAST) * usual.depth),
        ("phi", "short", max((LIP if lip else LEAST) * usual.phi, need[1] / (ZONE * m.R))),
    ):
        if getattr(size, name) < floor * (1.0 - 1e-9):
            left, wanted = getattr(size, name) / getattr(usual, name), floor / getattr(usual, name)
            raise ValueError(
                f"no room for the sockets of the contact patches: only {100.0 * left:.0f} % of the usual one is left, "
                f"less than {100.0 * wanted:.0f} % (too {word}), because {cause[name]}"
            )
    return size


def _narrowed_width(
    m: GrooveMap, sides: tuple[int, ...], land_screw: float, land_nut: float, wanted: float, need: float
) -> tuple[float, str]:
    """Half width of sockets allowed by edges and apexes of the grooves, and which of them limits it.

    Parameters
    ----------
    wanted : float
        Largest half width [rad].
    need : float
        Half width of the contacts along the arc [m].

    Returns
    -------
    gamma : float
        Half width [rad].
    reason : str
        What limits it.

    Raises
    ------
    ValueError
        A contact reaches beyond what edge and apex leave to a socket.
    """
    gamma, why = wanted, ""
    for side in sides:
        land, radius = land_screw if side < 2 else land_nut, float(m.radius[side])
        apex, edge = flank_limits(m, side, land)
        at_land = f"the groove, at the land radius of {1e3 * land:.4g} mm,"
        low_end, remedy_low = "apex between the two arcs", "bring the groove radius closer to the ball's"
        if m.one_arc:
            low_end, remedy_low = f"other edge of {at_land}", "deepen the groove"
        for room, name, remedy in (
            (m.beta - apex, low_end, remedy_low),
            (edge - m.beta, f"edge of {at_land}", "deepen the groove"),
        ):
            reason = f"the {name} is {np.degrees(room):.3g} deg from the contact of side {SIDES[side]}"
            usable = ZONE * room / (1.0 + CLOSE)
            if need / radius > usable:
                raise ValueError(
                    f"no room for the contact ellipse of side {SIDES[side]}: it reaches {1e3 * need:.3g} mm "
                    f"({np.degrees(need / radius):.3g} deg) from its nominal middle, and the mesh has room for "
                    f"{1e3 * usable * radius:.3g} mm ({np.degrees(usable):.3g} deg), because {reason}; {remedy}, lower the "
                    "load, or open the groove (a larger groove radius makes the ellipse shorter)"
                )
            bare = need / (radius * ZONE)
            width = max(room / (1.0 + BESIDE), min(SPARE * bare, 0.5 * (bare + room / (1.0 + CLOSE))))
            if width < gamma:
                gamma, why = width, f"{reason}; {remedy}"
    return gamma, why


def refuse_misfit(
    m: GrooveMap,
    size: SocketSize,
    sockets: tuple[tuple[float, float, int], ...],
    land: float,
    behind: float,
    ends: tuple[float, float],
) -> None:
    """Raise ValueError where sockets of one body leave it or overlap.

    Parameters
    ----------
    m : GrooveMap
        Track.
    size : SocketSize
        Size of the sockets.
    sockets : tuple[tuple[float, float, int], ...]
        Azimuth [rad] and station [m] of the ball, and flank, of each.
    land, behind : float
        Radii of the lands and of the surface behind the groove [m].
    ends : tuple[float, float]
        Stations of the flat ends [m].
    """
    remedy = "make the sockets smaller (rollbench.meshes.sockets.fitted_socket finds a size that fits)"
    sides = tuple(sorted({s for _, _, s in sockets}))
    for phi, z, _ in sockets:
        if min(whole_turns(m, phi, z, line)[1] for line in groove_lines(m)) > ON_GROOVE * m.ball:
            raise ValueError(
                f"the socket at azimuth {np.degrees(phi):.4g} deg, z = {1e3 * z:.4g} mm lies on no groove: place balls by "
                "rollbench.meshes.helix.ball_layout"
            )
    for side in sides:
        apex, edge = flank_limits(m, side, land)
        if not (apex < m.beta - size.gamma and m.beta + size.gamma < edge):
            raise ValueError(
                f"a socket of side {SIDES[side]} from {m.beta - size.gamma:.3g} to {m.beta + size.gamma:.3g} rad reaches "
                f"over its flank, from {apex:.3g} to {edge:.3g} rad: {remedy}"
            )
        if wall_left(m, size, side, behind) <= 0.0:
            raise ValueError(f"a socket of side {SIDES[side]} reaches through the wall behind it: {remedy}")
        places = np.array([(a, z) for a, z, s in sockets if s == side])
        gaps, pairs = track_gaps(m, places[:, 0], places[:, 1])
        if gaps.size and gaps.min() <= 2.0 * size.phi:
            first, second = pairs[gaps.round(9).argmin()] + 1
            raise ValueError(f"the sockets of balls {first} and {second} overlap along the track: {remedy}")
        below, above = socket_reach(m, size, (side,))
        if places[:, 1].min() - below <= ends[0] or places[:, 1].max() + above >= ends[1]:
            raise ValueError(f"a socket of side {SIDES[side]} reaches a flat end of the body: {remedy}")
    if sides and turn_left(m, size, sides) <= 0.0:
        raise ValueError(f"a socket reaches the next turn of the groove: {remedy}")
