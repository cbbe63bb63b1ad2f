"""Bodies around one contact as tensor grids of hexahedra: a whole ball, a grooved bar, and a block of a half-space.

Axes: x along the track, y across it towards the bottom of the groove, z into the body; the contact's centre is the origin.
The cells of the contact zone are equal in all three bodies, so that the effect of the grid on a contact's local response
cancels.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from skfem import Mesh

from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.fem import mesh_rectangular_grid, node_coordinates, with_boundaries_from_facets, with_node_coordinates


@dataclass(frozen=True)
class ContactZone:
    """Rectangular contact zone on the surface of a body, and the mesh cells in and around it."""

    #: Half lengths of the zone along x and y [m].
    half_lengths: tuple[float, float]
    #: Numbers of cells of the zone along x and y.
    cell_counts: tuple[int, int]
    #: Ratio of the sizes of neighbouring cells outside the zone.
    cell_growth: float

    def cell_boundaries(self, axis: int, low: float, high: float) -> Array:
        """Return the boundaries of a body's mesh cells along x or y: equal in the contact zone, growing outside.

        Parameters
        ----------
        axis : int
            0 for x, 1 for y.
        low, high : float
            First and last boundary [m], low < 0 < high.

        Returns
        -------
        Array
            Ascending boundaries [m].

        Raises
        ------
        ValueError
            The zone does not fit between the first and the last boundary.
        """
        half = self.half_lengths[axis]
        if not (low < -half and half < high):
            raise ValueError(
                f"a contact zone from {-half:.3g} to {half:.3g} m does not fit on a body from {low:.3g} to {high:.3g} m: "
                "decrease the load"
            )
        core = np.linspace(-half, half, self.cell_counts[axis] + 1)
        step = float(core[1] - core[0])
        below, above = (_growing_boundaries_to_end(half, end, step, self.cell_growth) for end in (-low, high))
        return np.concatenate([-below[::-1], core, above])

    def nearest_node_indices(self, at: Array) -> Index:
        """Find for each of n points the column and row of the nearest node of the contact zone, from zero ``(n, 2)``.

        ``at``: coordinates x, y of the points (n, 2) [m].
        """
        cells = np.array(self.cell_counts)
        return np.asarray(np.clip(np.rint((at / np.array(self.half_lengths) + 1.0) * cells), 0, 2 * cells).astype(np.int64))

    def cell_boundaries_in_depth(self, deep: float) -> Array:
        """Return the boundaries of growing mesh cells from the surface to the depth ``deep`` [m].

        The first cell is as large as the smaller side of the zone's cells.
        """
        first = min(2.0 * h / n for h, n in zip(self.half_lengths, self.cell_counts, strict=True))
        return np.concatenate([[0.0, first], _growing_boundaries_to_end(first, deep, first, self.cell_growth)])


def _growing_boundaries_to_end(start: float, end: float, step: float, growth: float) -> Array:
    """Return the boundaries of mesh cells whose sizes grow from ``start`` to ``end`` [m], without ``start`` itself.

    ``step``: size of the cell before ``start`` [m]; ``growth``: ratio of the sizes of neighbouring cells. The last cell
    ends at ``end``; the other cells do not depend on ``end``.
    """
    out, width = [start], step * growth
    while out[-1] + 1.5 * width < end:
        out.append(out[-1] + width)
        width *= growth
    return np.array([*out[1:], end])


@dataclass(frozen=True)
class ContactBody:
    """Mesh of a body around one contact, with named boundaries.

    The boundaries are "contact" (the contact zone) and "held" (where the body is fixed or cut off; a ball has none).
    """

    #: Mesh of the body.
    mesh: Mesh
    #: Indices of the nodes of the contact zone ``(c,)``.
    contact_nodes: Index
    #: Direction of the mesh's axis z relative to the normal from ball to groove: -1 for the ball, 1 for a groove.
    normal_sense: int
    #: Indices of the contact nodes in the grid of the contact zone, along x and y ``(c, 2)``, from zero.
    node_grid_indices: Index


def _contact_body_from_grid(
    zone: ContactZone, x: Array, y: Array, z: Array, points: Array, held: list[tuple[int, float]], sense: int
) -> ContactBody:
    """Create the mesh of a body from a rectangular grid whose nodes are moved, and name its boundaries.

    ``x``, ``y``, ``z``: cell boundaries of the grid [m]; ``points``: positions to which its n nodes are moved (n, 3) [m];
    ``held``: axis and coordinate of each face of the grid that is fixed; ``sense``: direction of the mesh's axis z relative
    to the normal from ball to groove, 1 for a groove, -1 for the ball.
    """
    flat = mesh_rectangular_grid(x, y, z, "Q2")
    xi = node_coordinates(flat)
    mesh = with_node_coordinates(flat, points)
    outer = mesh.boundary_facets()
    corners = xi[mesh.facets[:, outer]]  # (4, faces, 3)
    top = np.all(np.abs(corners[..., 2]) < 1e-12, axis=0)
    half = np.array(zone.half_lengths) * (1.0 + 1e-9)
    inside = np.all(np.abs(corners[..., :2]) <= half, axis=(0, 2))
    names = {"contact": outer[top & inside]}
    if held:
        on = [np.all(np.abs(corners[..., k] - value) < 1e-12, axis=0) for k, value in held]
        names["held"] = outer[np.any(on, axis=0)]
    nodes = np.flatnonzero((np.abs(xi[:, 2]) < 1e-12) & np.all(np.abs(xi[:, :2]) <= half, axis=1))
    return ContactBody(with_boundaries_from_facets(mesh, names), nodes, sense, zone.nearest_node_indices(xi[nodes, :2]))


def mesh_whole_ball(radius: float, zone: ContactZone) -> ContactBody:
    """Mesh a whole ball by hexahedra: a cube whose faces are mapped onto the sphere.

    Parameters
    ----------
    radius : float
        Radius of the ball [m].
    zone : ContactZone
        Contact zone.

    Returns
    -------
    ContactBody
        The ball.
    """
    root = np.sqrt(0.5)
    x, y = (zone.cell_boundaries(k, -root * radius, root * radius) for k in (0, 1))
    half = zone.cell_boundaries_in_depth(radius)
    z = np.concatenate([half, radius + radius * np.array([0.5, 1.0])])
    grid = node_coordinates(mesh_rectangular_grid(x, y, z, "Q2"))
    u = np.column_stack([grid[:, :2] / (root * radius), 1.0 - grid[:, 2] / radius])
    s = u**2
    out = np.empty_like(u)
    for k in range(3):
        a, b = s[:, (k + 1) % 3], s[:, (k + 2) % 3]
        out[:, k] = radius * u[:, k] * np.sqrt(1.0 - 0.5 * a - 0.5 * b + a * b / 3.0)
    out[:, 2] = radius - out[:, 2]
    return _contact_body_from_grid(zone, x, y, z, out, [], -1)


@dataclass(frozen=True)
class Groove:
    """Cross-section of a groove of two arcs (gothic arch), and its curvature along the track."""

    #: Radius of the ball [m].
    ball_radius: float
    #: Radius of the two arcs of the groove's cross-section [m].
    arc_radius: float
    #: Contact angle, from the bottom of the groove to the contact [rad].
    contact_angle: float
    #: Half of the groove's opening angle, seen from the ball's centre [rad].
    half_opening_angle: float
    #: Curvature of the groove's surface along the track at the contact [1/m]; positive: concave, 0: straight.
    curvature_along_track: float

    def surface_distance(self, theta: Array) -> Array:
        """Compute the distance of points on the groove's surface from the ball's centre [m].

        ``theta``: angles at the ball's centre from the contact towards the bottom of the groove [rad].
        """
        c = self.arc_radius - self.ball_radius
        cos = np.cos(np.where(theta > self.contact_angle, 2.0 * self.contact_angle - theta, theta))
        return np.asarray(-c * cos + np.sqrt(c**2 * cos**2 + self.arc_radius**2 - c**2))


def mesh_grooved_bar(groove: Groove, size: float, zone: ContactZone) -> ContactBody:
    """Mesh a bar with a groove along it, straight or bent into a ring, around a contact on one of the groove's flanks.

    The bar is round outside, where it is fixed, and equally long on both sides of the contact. The lands beside the groove,
    its other flank and the ends of the bar are free.

    Parameters
    ----------
    groove : Groove
        The groove.
    size : float
        Radius of the outside, from the ball's centre [m].
    zone : ContactZone
        Contact zone.

    Returns
    -------
    ContactBody
        The bar.

    Raises
    ------
    ValueError
        The groove's opening leaves no room for the contact zone, or the bent bar would reach the ring's axis.
    """
    R = groove.ball_radius
    low, high = groove.contact_angle - groove.half_opening_angle, groove.contact_angle + groove.half_opening_angle
    bottom = groove.contact_angle * R
    y = np.concatenate([zone.cell_boundaries(1, low * R, bottom), np.linspace(bottom, high * R, 5)[1:]])
    x, z = zone.cell_boundaries(0, -size, size), zone.cell_boundaries_in_depth(size - R)
    grid = node_coordinates(mesh_rectangular_grid(x, y, z, "Q2"))
    theta = grid[:, 1] / R
    inner = groove.surface_distance(theta)
    r = inner + (size - inner) * grid[:, 2] / (size - R)
    across, along = r * np.sin(theta), r * np.cos(theta) - R
    points = _bend_bar_along_track(groove, grid[:, 0], across, along)
    return _contact_body_from_grid(zone, x, y, z, points, [(2, float(z[-1]))], 1)


def _bend_bar_along_track(groove: Groove, x: Array, y: Array, z: Array) -> Array:
    """Map n points of a straight grooved bar to the bar along the track, straight or bent into a ring ``(n, 3)`` [m].

    ``x``: coordinates along the track; ``y``, ``z``: coordinates in its section [m].
    """
    if groove.curvature_along_track == 0.0:
        return np.column_stack([x, y, z])
    sin, cos = np.sin(groove.contact_angle), np.cos(groove.contact_angle)
    down = np.array([sin, cos])  # to the bottom of the groove, in the section
    outward = 1.0 if groove.curvature_along_track > 0.0 else -1.0
    pitch = cos / abs(groove.curvature_along_track) - outward * groove.ball_radius * cos
    depth = np.column_stack([y, z + groove.ball_radius]) @ down
    radius = pitch + outward * depth
    if radius.min() <= 0.0:
        raise ValueError(
            "the body around a contact is meshed as a straight grooved bar and then bent to the ring; the bar is so thick "
            "that it would reach the ring's axis: decrease its size"
        )
    middle = pitch + outward * groove.ball_radius * cos
    turn = x / middle
    lost = outward * radius * (1.0 - np.cos(turn))  # towards the axis
    return np.column_stack([radius * np.sin(turn), y - lost * down[0], z - lost * down[1]])


def mesh_half_space(
    cut_distance: float, zone: ContactZone, inner_cell_boundaries: tuple[Array, Array, Array] | None = None
) -> ContactBody:
    """Mesh a rectangular block that is cut out of a half-space around a contact.

    Parameters
    ----------
    cut_distance : float
        Distance of its cut faces from the contact's centre [m].
    zone : ContactZone
        Contact zone.
    inner_cell_boundaries : tuple[Array, Array, Array] | None, default None
        Cell boundaries along x, y and z around the contact, to be continued [m]; None: those of the zone.

    Returns
    -------
    ContactBody
        The block.
    """
    size = float(cut_distance)
    if inner_cell_boundaries is None:
        x, y = (zone.cell_boundaries(axis, -size, size) for axis in (0, 1))
        z = zone.cell_boundaries_in_depth(size)
    else:

        def continued(lines: Array) -> Array:
            """Continue ascending cell boundaries by growing cells up to ``size``."""
            step = float(lines[-1] - lines[-2])
            return np.concatenate([lines, _growing_boundaries_to_end(float(lines[-1]), size, step, zone.cell_growth)])

        x, y = (-continued(-continued(lines)[::-1])[::-1] for lines in inner_cell_boundaries[:2])  # at both ends
        z = continued(inner_cell_boundaries[2])
    cut = [(0, -size), (0, size), (1, -size), (1, size), (2, size)]
    points = node_coordinates(mesh_rectangular_grid(x, y, z, "Q2"))
    return _contact_body_from_grid(zone, x, y, z, points, cut, 1)
