"""Coarse mesh of a screw, nut or ring: second-order tetrahedra by gmsh, with a refinement box left free at each contact.

The surface consists of smooth faces. Each has plane coordinates in which its shape is known exactly: (azimuth, section
angle gamma) for flanks, (azimuth, z) for lands and bores, (x, y) for the flat ends. On a helix, flanks and lands are strips
that end at the flat ends. On a ring, faces are closed around the axis; they are cut open midway between two refinement
boxes. ``meshes.shell`` fills the closed surface with tetrahedra.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from itertools import product
from typing import Any

import numpy as np

from rollbench.meshes import fem, groove, shell, sockets
from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.parts import SIDE_SIGNS, SIDES

#: Longest edges on flanks, as a ratio to the coarse element size. Most cells of a body are at its long, narrow groove.
FLANK = 0.48
#: Longest edges on a flange, as a ratio to its thickness.
THICKNESS = 0.25
#: Width of a ring on a flange below which the ring is not meshed, as a ratio to the longest edges on the flange.
SLIVER = 0.1


@dataclass(frozen=True)
class CoarseGroovedBodyMesh(fem.MeshedBody):
    """Coarse mesh of a screw, nut or ring, with a refinement box left free around each contact for a finer mesh.

    Names of its boundaries: "low end", "high end", "land"; "flank SL" (left) and "flank SR" (right) of a screw, or "flank
    NL" and "flank NR" of a nut; "bore" of a hollow screw or "outside" of a nut; "sockets", the faces of the refinement
    boxes, if there are any. A flanged nut also has "rim", "seat" (the ring at which the flange may be fixed), "flange" (the
    rest of that face) and "centring" (the cylindrical fit next to it).
    """

    #: Nodes on the faces of each refinement box ``(count, k)``, in the order of the nodes of its mesh in ``box_faces``.
    nodes_on_box_faces: Index
    #: Mesh of the faces of a refinement box, by the flank (0 to 3) on which the box lies.
    box_faces: dict[int, sockets.RefinementBoxFaces]
    #: Largest distance of the flanks' nodes, including the refinement boxes' rims, from the exact flanks [m].
    flank_deviation: float
    #: Number of cells and nodes of the mesh, and smallest scaled Jacobian of its cells.
    quality: fem.MeshQuality


class GroovedBodySurface:
    """Closed surface of a screw, nut or ring, built face by face in a `ClosedSurfaceMesh`.

    Plane coordinates of curved faces are (azimuth, section angle gamma) on flanks, and (azimuth, z) on cylinders.

    Attributes: ``flank_limit``: length of the longest edges on flanks [m]; ``bend``: length of the longest edges on
    cylinders, as a ratio to their radius; ``start``: azimuth at which the closed faces of a ring are cut open [rad].
    """

    def __init__(
        self,
        surface: shell.ClosedSurfaceMesh,
        spec: groove.GroovedBodySpec,
        section: groove.GrooveCrossSection,
        share: float,
    ) -> None:
        """Divide the curves of the body's surface and triangulate its faces.

        Afterwards the attribute ``corners`` holds the corner nodes of every refinement box, in the order of
        ``spec.contact_positions``.

        Parameters
        ----------
        surface : ClosedSurfaceMesh
            Surface mesh to which the faces are added.
        spec : GroovedBodySpec
            Dimensions and refinement boxes of the body.
        section : GrooveCrossSection
            Cross-section of the groove.
        share : float
            Factor on the default lengths of the longest edges on curved faces.
        """
        m = section.groove_map
        self.surface, self.m, self.spec, self.section = surface, m, spec, section
        self.z = (spec.z_low, spec.z_high)
        size = spec.refinement_box_size
        point_map = partial(partial, sockets.points_in_box_at_azimuth_zero, m, size)
        kinds = {s: sockets.mesh_refinement_box_of_flank(point_map, s, size.edge_divisions) for s in self.section.sides}
        self.boxes = {side: kinds[side][0] for side in sorted({s for _, _, s in spec.contact_positions})}
        self.corners = []
        for contact in spec.contact_positions:
            box, raised = kinds[contact[2]]
            places = (sockets.points_in_refinement_box(m, size, contact, x) for x in (box.xi, raised))
            self.corners.append(surface.add_refinement_box("sockets", box, *places))
        bend = shell.BEND[0] * float(m.radius[self.section.sides[0]])
        self.flank_limit = share * min(bend, FLANK * spec.cell_size_far_away)
        self.bend = share * shell.BEND[1]
        self.start = groove.azimuth_of_widest_gap(spec)
        self._triangulate_end_faces(self._triangulate_helical_groove() if m.rg else self._triangulate_ring_groove())

    def _box_rims_on_flank(self, side: int, line: float) -> list[list[shell.Side]]:
        """Return the rims of the refinement boxes on a flank of one thread start, which are the holes in the flank's face.

        ``side``: flank 0 to 3; ``line``: constant z - r_g phi of the groove [m], with the lead per radian r_g. Each rim is
        a closed loop of one boundary segment, in the plane coordinates (azimuth, section angle gamma) [rad].
        """
        m, spec = self.m, self.spec
        holes = []
        for corners, (phi, z, box_side) in zip(self.corners, spec.contact_positions, strict=True):
            turns, off = sockets.turns_and_distance_to_groove(m, phi, z, line)
            if box_side != side or off > sockets.ON_GROOVE * m.ball:
                continue
            top = sockets.rim_nodes_of_refinement_box(self.boxes[side])
            top = np.append(top, top[0])
            xi = self.boxes[side].xi[top]
            middle = phi + 2.0 * np.pi * turns + sockets.unrolled_nominal_contact_point(m, side)[2]
            if not m.rg:
                middle = self.start + np.mod(middle - self.start, 2.0 * np.pi)
            size = spec.refinement_box_size
            at = np.stack([middle + size.phi * xi[:, 2], m.beta + size.gamma * xi[:, 0]], axis=1)
            holes.append([(corners[top], at)])
        return holes

    def _triangulate_flank(self, side: int, line: float, boundary: list[shell.Side]) -> None:
        """Triangulate a flank of the helical groove of one thread start.

        ``side``: flank 0 to 3; ``line``: constant z - r_g phi of the groove [m], with the lead per radian r_g;
        ``boundary``: segments of the boundary of the face in the coordinates (azimuth, section angle) [rad]. gmsh
        triangulates the face in a plane in which azimuths are measured from the section normal to the helix, because this
        distorts angles least.
        """
        m = self.m
        scale = np.array([np.hypot(m.rg, sockets.unrolled_nominal_contact_point(m, side)[0]), float(m.radius[side])])

        def to_plane_of_gmsh(x: Array) -> Array:
            return scale * np.stack([x[:, 0] - self.m.flank_to_unrolled(side, x[:, 1])[2], x[:, 1]], axis=1)

        def plane_to_flank(plane: Array) -> Array:
            along, gamma = (plane / scale).T
            r, zeta, turn = self.m.flank_to_unrolled(side, gamma)
            phi = along + turn
            radius = self.section.radius_with_run_out(line, r, phi)
            return groove.points_from_cylindrical(radius, phi, line + zeta + m.rg * phi)

        loops = [[(n, to_plane_of_gmsh(x)) for n, x in loop] for loop in (boundary, *self._box_rims_on_flank(side, line))]
        self.surface.add_face(f"flank {SIDES[side]}", loops, plane_to_flank, self.flank_limit)

    def _triangulate_on_cylinder(self, name: str, r: float, boundary: list[shell.Side], limit: float) -> None:
        """Triangulate a face on the cylinder of radius ``r`` [m] about the axis, with edges of at most ``limit`` [m].

        ``name``: name of the boundary of the mesh to which the face belongs; ``boundary``: segments of the boundary of the
        face in the coordinates (azimuth [rad], z [m]).
        """
        scale = np.array([r, 1.0])
        loop = [(n, x * scale) for n, x in boundary]
        self.surface.add_face(name, [loop], groove.cylinder_point_map(r), limit)

    def _divide_circle(self, r: float, z: float, limit: float) -> shell.DividedCurve:
        """Divide the circle of radius ``r`` about the axis, at the position ``z``, into edges of at most ``limit`` [m]."""
        return self.surface.add_curve(groove.circle_in_space(r, z), self.start, self.start + 2.0 * np.pi, limit)

    def _sides_of_closed_face(
        self, low: shell.DividedCurve, high: shell.DividedCurve, at: tuple[float, float], seam: shell.Placing, limit: float
    ) -> list[shell.Side]:
        """Return the four boundary segments of a face between two circles about the axis, cut open along a seam.

        ``low``, ``high``: the two divided circles; ``at``: the second plane coordinate (z or section angle) of ``low`` and
        of ``high``; ``seam``: function that maps the second plane coordinate to points in space, from ``low`` to ``high``;
        ``limit``: length of the longest edge on the seam [m].
        """
        cut = self.surface.add_curve(seam, *at, limit, (int(low.nodes[0]), int(high.nodes[0])))
        begin, end = (groove.line_along_second_axis(phi) for phi in (self.start, self.start + 2.0 * np.pi))
        return [
            low.side(groove.line_along_first_axis(at[0])),
            cut.side(end),
            high.reversed_side(groove.line_along_first_axis(at[1])),
            cut.reversed_side(begin),
        ]

    def _triangulate_tube(
        self, name: str, r: float, low: shell.DividedCurve, high: shell.DividedCurve, z: tuple[float, float], limit: float
    ) -> None:
        """Triangulate the face between two divided circles, ``low`` and ``high``, on the cylinder of radius ``r`` [m].

        ``name``: name of the boundary of the mesh to which the face belongs; ``z``: axial positions of ``low`` and ``high``
        [m]; ``limit``: length of the longest edge [m].
        """
        seam = self._sides_of_closed_face(low, high, z, lambda t: groove.points_from_cylindrical(r, self.start, t), limit)
        self._triangulate_on_cylinder(name, r, seam, limit)

    def _triangulate_end_faces(self, bounds: list[list[shell.Side]]) -> None:
        """Triangulate the two flat ends, and the bore of a hollow screw or the outside of a nut.

        ``bounds``: for the end at smaller z, then for that at larger z, the segments of the end's closed boundary at the
        groove, in the coordinates (x, y) [m].
        """
        r = self.section.back_radius
        loops = [[bound] for bound in bounds]
        if r > 0.0:
            limit = min(self.bend * r, max(shell.WALL * self.section.wall_thickness, self.surface.fine))
            names, places, thin = ["bore" if self.spec.groove_outside else "outside"], [(r, z) for z in self.z], limit
            if self.spec.flange is not None:
                thin = max(THICKNESS * self.spec.flange.thickness, self.surface.fine)
                names, places = groove.outer_surfaces_of_flanged_nut(self.spec.flange, r, self.z, SLIVER * thin)
            circles = self._triangulate_behind_groove(names, places, limit, thin)
            for loop, ring, (radius, _) in zip(loops, (circles[0], circles[-1]), (places[0], places[-1]), strict=True):
                loop.insert(1 if self.spec.groove_outside else 0, [ring.side(groove.circle_in_plane(radius))])
        for name, z, loop in zip(("low end", "high end"), self.z, loops, strict=True):
            self.surface.add_face(name, loop, groove.point_map_at_z(z), np.inf)

    def _triangulate_behind_groove(
        self, names: list[str], places: list[tuple[float, float]], limit: float, thin: float
    ) -> list[shell.DividedCurve]:
        """Triangulate the bore, or the outer surfaces of a nut, and return the divided circles between which they lie.

        ``names``: names of the surfaces, from smaller to larger z; ``places``: radius and z [m] of the circles that bound
        the surfaces, one more than surfaces; ``limit``, ``thin``: lengths of the longest edges on the body and on its
        flange [m].
        """
        sizes = [limit if name in ("centring", "outside") else min(thin, limit) for name in names]
        around = [min(pair) for pair in zip([limit, *sizes], [*sizes, limit], strict=True)]
        circles = [self._divide_circle(r, z, size) for (r, z), size in zip(places, around, strict=True)]
        for k, (name, size) in enumerate(zip(names, sizes, strict=True)):
            (r, z), (other, end) = places[k : k + 2]
            if r == other:
                self._triangulate_tube(name, r, circles[k], circles[k + 1], (z, end), size)
            else:
                outer, inner = sorted(((r, circles[k]), (other, circles[k + 1])), key=lambda x: -x[0])
                loops = [[c.side(groove.circle_in_plane(x))] for x, c in (outer, inner)]
                self.surface.add_face(name, loops, groove.point_map_at_z(z), size)
        return circles

    def _triangulate_ring_groove(self) -> list[list[shell.Side]]:
        """Triangulate the flanks and lands of a bearing ring, and return the boundary of each flat end at the land.

        Each boundary, first that at smaller z, is a circle in the plane coordinates (x, y) [m].
        """
        g, line = self.section, self.m.z0
        limit = self.bend * g.land_radius
        circles = [self._divide_circle(g.land_radius, z, limit) for z in self.z]
        low, high = line + g.opening_position - g.opening_half_width, line + g.opening_position + g.opening_half_width
        left, right = (self._divide_circle(g.land_radius, z, min(limit, self.flank_limit)) for z in (low, high))
        self._triangulate_tube("land", g.land_radius, circles[0], left, (self.z[0], low), limit)
        self._triangulate_tube("land", g.land_radius, right, circles[1], (high, self.z[1]), limit)
        if self.m.has_single_arc:
            side = g.sides[0]
            faces = [(side, *((left, right) if SIDE_SIGNS[side][1] > 0.0 else (right, left)), -g.edge_angle)]
        else:
            r, zeta = g.profile_points(g.sides[0], np.array([g.apex_angle]))
            apex = self._divide_circle(float(r[0]), line + float(zeta[0]), min(limit, self.flank_limit))
            faces = [(side, apex, edge, g.apex_angle) for side, edge in zip(g.sides, (left, right), strict=True)]
        for side, first, last, begin in faces:

            def seam_points(gamma: Array, side: int = side) -> Array:
                r, zeta = g.profile_points(side, gamma)
                return groove.points_from_cylindrical(r, self.start, line + zeta)

            span = begin, g.edge_angle
            self._triangulate_flank(
                side, line, self._sides_of_closed_face(first, last, span, seam_points, self.flank_limit)
            )
        return [[c.side(groove.circle_in_plane(g.land_radius))] for c in circles]

    def _triangulate_helical_groove(self) -> list[list[shell.Side]]:
        """Triangulate the flanks and lands of a screw or nut, and return the inner or outer boundary of each flat end.

        It follows the lands and grooves. That of the end at smaller z comes first; each is a list of segments in the plane
        coordinates (x, y) [m].
        """
        g, rg, limit = self.section, self.m.rg, self.bend * self.section.land_radius
        threads = [
            HelicalGrooveCurves(self.surface, g, line, self.z, min(self.flank_limit, limit))
            for line in sockets.helix_constants_of_starts(self.m)
        ]
        pitch = 2.0 * np.pi * abs(rg) / self.m.starts
        arcs = []
        for k, thread in enumerate(threads):
            for place, side in enumerate(g.sides):
                self._triangulate_flank(side, thread.line, thread.sides_of_flank(place))
            following = threads[(k - 1 if rg > 0.0 else k + 1) % len(threads)]
            near, far = (
                groove.helix_in_plane_coordinates(thread.line, zeta, rg)
                for zeta in (g.opening_half_width, pitch - g.opening_half_width)
            )
            pair = []
            for end, z in zip((0, -1), self.z, strict=True):
                begin, stop = (float(x(np.array([z]))[0, 0]) for x in (near, far))
                ends = int(thread.rails[2].nodes[end]), int(following.rails[0].nodes[end])
                pair.append(self.surface.add_curve(groove.circle_in_space(g.land_radius, z), begin, stop, limit, ends))
            boundary = [
                pair[0].side(groove.line_along_first_axis(self.z[0])),
                following.rails[0].side(far),
                pair[1].reversed_side(groove.line_along_first_axis(self.z[1])),
                thread.rails[2].reversed_side(near),
            ]
            self._triangulate_on_cylinder("land", g.land_radius, boundary, limit)
            arcs.append(pair)
        return [self._boundary_of_end_face(threads, [pair[end] for pair in arcs], end) for end in (0, 1)]

    def _boundary_of_end_face(
        self, threads: list[HelicalGrooveCurves], arcs: list[shell.DividedCurve], end: int
    ) -> list[shell.Side]:
        """Return the segments of a flat end's boundary: for each thread start, right flank, land, and next left flank.

        ``threads``: curves of each start's groove; ``arcs``: for each start, the arc of its land at this end; ``end``: 0
        for the end at smaller z, 1 for that at larger z. Plane coordinates are (x, y) [m].
        """
        g, step = self.section, -1 if self.m.rg > 0.0 else 1
        loop, k = [], 0
        for _ in threads:
            n = (k + step) % len(threads)
            loop += [
                threads[k].cuts[1][end].side(threads[k].end_curve_in_plane(1, end)),
                arcs[k].side(groove.circle_in_plane(g.land_radius)),
                threads[n].cuts[0][end].reversed_side(threads[n].end_curve_in_plane(0, end)),
            ]
            k = n
        return loop


class HelicalGrooveCurves:
    """Curves that bound the two flanks of the helical groove of one thread start.

    The attribute ``rails`` holds the curves along the left edge, the apex and the right edge of the groove; ``cuts`` holds,
    for the left and the right flank, the curves in which it meets the two flat ends.
    """

    def __init__(
        self,
        surface: shell.ClosedSurfaceMesh,
        section: groove.GrooveCrossSection,
        line: float,
        z: tuple[float, float],
        limit: float,
    ) -> None:
        """Divide the curves into edges of at most ``limit`` [m], and add their nodes to ``surface``.

        ``section``: cross-section of the groove; ``line``: constant z - r_g phi of the groove [m], with the lead per radian
        r_g; ``z``: axial positions of the flat ends [m].
        """
        self.section, self.line, self.z = section, line, z
        r, zeta = section.profile_points(section.sides[0], np.array([section.apex_angle]))
        places = (
            (section.land_radius, -section.opening_half_width),
            (float(r[0]), float(zeta[0])),
            (section.land_radius, section.opening_half_width),
        )
        self.zeta = [p[1] for p in places]
        self.rails = []
        for radius, height in places:

            def rail_points(t: Array, radius: float = radius, height: float = height) -> Array:
                phi = (t - line - height) / section.groove_map.rg
                return groove.points_from_cylindrical(section.radius_with_run_out(line, radius, phi), phi, t)

            first, last = surface.add_nodes(rail_points(np.array(z)))
            self.rails.append(surface.add_curve(rail_points, *z, limit, (int(first), int(last))))
        self.cuts = []
        for place in (0, 1):
            pair = []
            for end in (0, 1):
                corners = int(self.rails[1].nodes[-end]), int(self.rails[2 * place].nodes[-end])
                curve = self._end_curve_in_space(place, end)
                pair.append(surface.add_curve(curve, section.apex_angle, section.edge_angle, limit, corners))
            self.cuts.append(pair)

    def _radius_and_azimuth_at_end(self, place: int, end: int, gamma: Array) -> tuple[float | Array, Array]:
        """Return radius [m] and azimuth [rad] of points on the curve in which a flank meets a flat end.

        ``place``: 0 left, 1 right flank; ``end``: 0 for the end at smaller z, 1 for that at larger z; ``gamma``: section
        angles of the points [rad].
        """
        r, zeta = self.section.profile_points(self.section.sides[place], gamma)
        phi = (self.z[end] - self.line - zeta) / self.section.groove_map.rg
        return self.section.radius_with_run_out(self.line, r, phi), phi

    def _end_curve_in_space(self, place: int, end: int) -> shell.Placing:
        """Return the curve in space in which a flank meets a flat end, as a function of the section angle gamma [rad].

        ``place``: 0 left, 1 right flank; ``end``: 0 for the end at smaller z, 1 for that at larger z.
        """
        return lambda gamma: groove.points_from_cylindrical(
            *self._radius_and_azimuth_at_end(place, end, gamma), self.z[end]
        )

    def end_curve_in_plane(self, place: int, end: int) -> shell.Placing:
        """Return the curve in which a flank meets a flat end, in the plane coordinates (x, y) [m] of the end.

        ``place``: 0 left, 1 right flank; ``end``: 0 for the end at smaller z, 1 for that at larger z. The parameter of the
        curve is the section angle gamma [rad].
        """
        return lambda gamma: self._end_curve_in_space(place, end)(gamma)[:, :2]

    def sides_of_flank(self, place: int) -> list[shell.Side]:
        """Return the four boundary segments of a flank in the plane coordinates (azimuth, section angle gamma) [rad].

        ``place``: 0 left, 1 right flank.
        """
        g = self.section

        def end_curve_in_flank_coordinates(end: int) -> shell.Placing:
            return lambda gamma: np.stack([self._radius_and_azimuth_at_end(place, end, gamma)[1], gamma], axis=1)

        apex, edge = (
            groove.helix_in_plane_coordinates(self.line, self.zeta[k], g.groove_map.rg, at)
            for k, at in ((1, g.apex_angle), (2 * place, g.edge_angle))
        )
        low, high = self.cuts[place]
        return [
            low.side(end_curve_in_flank_coordinates(0)),
            self.rails[2 * place].side(edge),
            high.reversed_side(end_curve_in_flank_coordinates(1)),
            self.rails[1].reversed_side(apex),
        ]


def mesh_grooved_body(m: GrooveMap, spec: groove.GroovedBodySpec) -> CoarseGroovedBodyMesh:
    """Mesh a screw, nut or ring coarsely, and leave a refinement box free around each contact for a finer mesh.

    Parameters
    ----------
    m : GrooveMap
        Groove surfaces of the track.
    spec : GroovedBodySpec
        Dimensions, refinement boxes and element sizes of the body.

    Returns
    -------
    CoarseGroovedBodyMesh
        The mesh.

    Raises
    ------
    ValueError
        The groove leaves no land or wall, or no attempt of gmsh gives a good mesh.
    """
    section = groove.GrooveCrossSection.from_body(m, spec)
    xi = np.array(list(product((-1.0, 0.0, 1.0), (0.0, 0.5, 1.0), (-1.0, 0.0, 1.0))))
    size, contacts = spec.refinement_box_size, spec.contact_positions
    boxes = [sockets.points_in_refinement_box(m, size, contact, xi) for contact in contacts]
    near = np.concatenate([np.zeros((0, 3)), *boxes])

    def mesh_once(gmsh: Any, plane: int, volume: int, share: float) -> tuple[CoarseGroovedBodyMesh, float]:
        sizes = share * spec.cell_size_at_contacts, share * spec.cell_size_far_away
        edge_length = shell.edge_length_growing_with_distance(near, *sizes, *(m.ball * g for g in shell.GROWTH))
        surface = shell.ClosedSurfaceMesh(gmsh, edge_length, min(sizes), plane)
        built = GroovedBodySurface(surface, spec, section, share)
        body = _build_body_record(built, shell.mesh_inside_closed_surface(surface, volume))
        off = body.flank_deviation / m.ball if body.flank_deviation > shell.EXACT else 0.0
        return body, off + max(0.0, shell.POOREST - body.quality.smallest_jacobian)

    return shell.best_mesh_of_attempts(spec.part_name, mesh_once)


def _build_body_record(built: GroovedBodySurface, filled: shell.FilledSurfaceMesh) -> CoarseGroovedBodyMesh:
    """Build the record of a body's mesh: name its boundaries, improve badly curved cells, measure deviation and quality.

    ``built``: surface of the body; ``filled``: mesh of the volume inside it. Edges that would invert cells are
    straightened.
    """
    m, spec, surface = built.m, built.spec, built.surface
    places = zip(built.corners, spec.contact_positions, strict=True)
    rows = [filled.nodes_on_refinement_box(corners, built.boxes[side]) for corners, (_, _, side) in places]
    box_nodes = np.array(rows, dtype=np.int64).reshape(len(rows), -1 if rows else 0)
    mesh, _, quality = filled.improved_mesh(surface, spec.part_name, box_nodes)
    deviation, ends = 0.0, built.section.run_out
    for s in built.section.sides:
        x = fem.node_coordinates(mesh)[fem.nodes_on_boundaries(mesh, f"flank {SIDES[s]}")]
        off = m.distances_from_flank(s, x if ends is None else x[ends.has_full_depth(x)])
        deviation = max(deviation, float(np.abs(off).max(initial=0.0)))
    return CoarseGroovedBodyMesh(mesh, box_nodes, built.boxes, deviation, quality)
