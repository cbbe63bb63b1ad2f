"""One tapered roller between its races in 3D: approach, stiffness, and pressure along and across both contact lines.

The bodies are a roller and sectors of cup and cone. The sectors end at the planes half-way to the neighbouring rollers,
where symmetry holds because all rollers are loaded alike, and at the depth of the rings, where the cone is fixed and the
cup is moved along the normal of its race. The rib is rigid and frictionless: it stops the mean motion of the roller's large
end along the roller's axis. The roller turns and moves between the races until it is in equilibrium. The plane of the axes
is one of symmetry, so that half of each race is meshed. Of the roller a quarter is meshed: the loads are split into parts
that are symmetric and antisymmetric about its other plane,

    C_cup,cup = C_cone,cone = (S + A)/2,   C_cup,cone = (S - A)/2,

each computed from one stiffness. Every body is condensed to the compliance of its contact zone under pressures that are
bilinear between nodes (`hifi.elements.forms`). Contact is unilateral and frictionless. Gaps are those of the cones, of a
circular crown and of the roundings of the ends. Small strains and displacements.
"""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter, process_time

import numpy as np
import scipy.sparse as sp

from rollbench.hifi.contact import balls
from rollbench.hifi.elements import forms
from rollbench.hifi.linear_algebra import symmetric_compliance_of_loads
from rollbench.meshes import roller_body
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import RollerRow
from rollbench.meshes.fem import nodes_on_boundaries

#: Mesh levels: cells across half of the zone, which is `ZONE` times as wide as the contact in the roller's middle, and
#: along half of the roller; all other cells follow in proportion.
LEVELS = {1: 6, 2: 8, 3: 12}
#: Half width of the contact zone over the half width of the contact in the roller's middle.
ZONE = 1.7
#: Edge length of a cell over its distance from the contact zone, times the number of cells across half of the zone.
GRADING = 5.4

#: Meshed length of the rounding at both ends of a roller, over the radius of the rounding: the rest is too far from the
#: race to touch.
FILLET = 0.6
#: Length of a race past either end of the roller, over the depth of the ring.
BEYOND = 1.0
#: Largest half angle of the sector of a race [rad].
WIDEST = np.pi / 4.0


class RollerError(ArithmeticError):
    """Error for a tapered roller or load that the 3D model of one roller cannot describe; its message gives advice."""

    def __init__(self, reason: str, advice: str) -> None:
        """Create the error from its reason and the advice to the user."""
        super().__init__(reason)
        self.advice = advice


@dataclass(frozen=True)
class CondensedRoller:
    """Compliance and gaps of one tapered roller with its cup and cone, at the nodes of both contact zones.

    Neither compliance nor gaps depend on the load.
    """

    #: Geometry and material of the row of rollers.
    roller_row: RollerRow
    #: Coordinates of the nodes of each contact zone along the roller, from its middle ``(m,)`` [m].
    positions_along: Array
    #: Coordinates of the nodes of each contact zone across the roller, from the plane of symmetry ``(n,)`` [m].
    positions_across: Array
    #: Compliance between the contact nodes with the cup, then those with the cone ``(2 m n, 2 m n)`` [m/N].
    compliance: Array
    #: Gaps between the undeformed roller and the cup, then the cone, at the nodes ``(2 m n,)`` [m].
    undeformed_gaps: Array
    #: Reduction of the gap at each contact node by three unit motions ``(2 m n, 3)``: approach of the cup, motion of the
    #: roller towards the cup, tilt of the roller.
    gap_closing_matrix: Array
    #: Area that each contact node carries, in the meshed half of the zone ``(m, n)`` [m2].
    nodal_areas: Array
    #: Number of cells of the meshes of roller, cup and cone together.
    cell_count: int
    #: Number of degrees of freedom of the meshes of roller, cup and cone together.
    degree_of_freedom_count: int
    #: Elapsed time of meshing and condensing [s].
    elapsed_seconds: float
    #: Processor time of meshing and condensing [s].
    cpu_seconds: float


@dataclass(frozen=True)
class RollerContactSolution:
    """Approach, stiffness and contact pressures of a tapered roller between cup and cone under a given race force."""

    #: Force of each race on the roller [N].
    race_force: float
    #: Approach of cup and cone along the normal of the cup's race [m], measured at the depth at which the cone is fixed and
    #: the cup is moved.
    approach: float
    #: Stiffness of the roller between cup and cone: derivative of the race force by the approach [N/m].
    stiffness: float
    #: Contact pressures on cup and cone at the contact nodes, m along and n across the roller ``(2, m, n)`` [Pa]
    #: (`CondensedRoller.positions_along`, `CondensedRoller.positions_across`).
    pressures: Array
    #: Loads per length on cup and cone at the nodes of `CondensedRoller.positions_along` ``(2, m)`` [N/m].
    line_loads: Array
    #: Largest difference between the resultant of a race's pressures and the race force, over the race force.
    load_imbalance: float
    #: Elapsed time of the solution [s].
    elapsed_seconds: float
    #: Processor time of the solution [s].
    cpu_seconds: float

    @property
    def largest_pressure_at_middle(self) -> Array:
        """Largest contact pressure with cup and with cone at the middle of the roller's length ``(2,)`` [Pa]."""
        return np.asarray(self.pressures[:, self.pressures.shape[1] // 2].max(axis=1))

    @property
    def line_load_at_middle(self) -> Array:
        """Load per length with cup and with cone at the middle of the roller's length ``(2,)`` [N/m]."""
        return np.asarray(self.line_loads[:, self.line_loads.shape[1] // 2])


def contact_half_width(row: RollerRow, load: float) -> float:
    """Compute the half width b of the wider of a roller's two line contacts by Hertz [m]: b^2 = 4 q R/(pi E*).

    R: relative radius of roller and cup [m]; E*: contact modulus [Pa]. ``row``: row of tapered rollers; ``load``: force of
    a race on the roller [N], distributed evenly over the roller's length as q [N/m].
    """
    modulus = 0.5 * row.material.youngs_modulus / (1.0 - row.material.poissons_ratio**2)
    r, cup = np.tan([row.roller_angle, row.cup_angle]) * _distance_from_apex(row)
    return float(np.sqrt(4.0 * load / row.length / (1.0 / r - 1.0 / cup) / (np.pi * modulus)))


def _distance_from_apex(row: RollerRow) -> float:
    """Return the distance [m] of the middle of a roller's contact line from the apex that roller, cup and cone share."""
    return float(0.5 * row.diameter / np.sin(row.roller_angle))


def crown_and_end_rounding_depths(row: RollerRow, x: Array) -> tuple[Array, Array]:
    """Return the depths of a roller's profile below a straight line: by its crown, and by the rounding of its ends [m].

    ``row``: row of tapered rollers; ``x``: positions along the roller from its middle [m]. Both results have the shape of
    ``x``.
    """
    beyond = np.maximum(np.abs(x) - 0.5 * row.length, 0.0)
    r = row.edge_radius
    edge = np.zeros_like(beyond) if r is None else r - np.sqrt(np.maximum(r**2 - beyond**2, 0.0))
    return x**2 / (2.0 * row.crown), edge


def _axial_cell_boundaries(row: RollerRow, cells: int, load: float) -> tuple[Array, float, Array]:
    """Compute the boundaries of the mesh cells along a roller and its races, as positions from the roller's middle [m].

    ``row``: row of tapered rollers; ``cells``: number of cells along half of the roller; ``load``: force of a race on the
    roller [N]. Returns the boundaries on the roller, half the length of the contact zone, and the boundaries on the races
    beyond the roller's end.
    """
    half, r = 0.5 * row.length, row.edge_radius
    if r is None:
        lines, touch = np.linspace(0.0, half, 2 * cells + 1), half
    else:
        # a rounding leaves the race within about b sqrt(2 r/D) of its beginning
        end = min(FILLET * r, 2.0 * contact_half_width(row, load) * np.sqrt(2.0 * r / row.diameter))
        step, touch = end / (cells // 2), half + end
        inner, outer = half - _growing_cell_boundaries(step, half, cells)[::-1], half + step * np.arange(1, cells // 2 + 1)
        lines = np.concatenate([inner, outer])
        if FILLET * r > end:
            lines = np.append(lines, half + FILLET * r)
    far = lines[-1] + _growing_cell_boundaries(float(lines[-1] - lines[-2]), BEYOND * row.depth, cells // 2)[1:]
    return np.concatenate([-lines[:0:-1], lines]), float(touch), far


def _growing_cell_boundaries(first: float, length: float, cells: int) -> Array:
    """Return the boundaries ``(cells + 1,)`` from 0 to ``length`` [m] of cells whose sizes grow by a constant ratio.

    ``first``: size of the first cell [m]; ``cells``: number of cells.
    """
    if first * cells >= length:
        return np.linspace(0.0, length, cells + 1)
    low, high = 1.0, (length / first) ** (1.0 / (cells - 1)) + 1.0
    for _ in range(80):
        ratio = 0.5 * (low + high)
        low, high = (ratio, high) if first * np.sum(ratio ** np.arange(cells)) < length else (low, ratio)
    ends = np.concatenate([[0.0], np.cumsum(first * ratio ** np.arange(cells))])
    return np.asarray(ends * length / ends[-1])


def condense_roller(row: RollerRow, cells: int, load: float) -> CondensedRoller:
    """Mesh a tapered roller, its cup and cone for forces up to ``load``; condense the three to the contact zones' nodes.

    Parameters
    ----------
    row
        Row of rollers.
    cells
        Number of cells across half of the contact zone, and along half of the roller; even, as in `LEVELS`.
    load
        Largest force of a race on a roller [N].

    Returns
    -------
    CondensedRoller
        Compliance, undeformed gaps and gap-closing matrix of both contact zones.

    Raises
    ------
    RollerError
        A straight roller has sharp ends, or a ring is thicker than the cone of its race allows.
    FactorError
        A stiffness cannot be factored.
    ImportError
        gmsh, or a system library that it needs, is missing.
    """
    wall, cpu = perf_counter(), process_time()
    if row.edge_radius is None and np.isinf(row.crown):
        reason = "the roller has a straight profile and sharp ends, at which the contact pressure is infinite"
        raise RollerError(reason, SHARP)
    middle, share_of = _distance_from_apex(row), min(np.pi / row.count, WIDEST)
    zone = roller_body.RollerContactZone(ZONE * contact_half_width(row, load), cells, GRADING / cells)
    lines, touch, far = _axial_cell_boundaries(row, cells, load)
    reach = (middle - touch, middle + touch)
    radius = 0.5 * row.diameter
    mesh_section, extrude = roller_body.mesh_roller_or_raceway_section, roller_body.build_extruded_roller_body
    shape = roller_body.roller_point_map(
        radius, row.roller_angle, lambda along: crown_and_end_rounding_depths(row, along - middle)[1]
    )
    flat = mesh_section(zone, radius, radius, is_roller=True)
    roller = extrude(flat, zone, middle + lines, reach, shape, is_roller=True)
    angles = (row.cup_angle, row.cup_angle - 2.0 * row.roller_angle)
    rings = []
    longer = middle + np.concatenate([-far[::-1], lines, far])
    for angle, outward in zip(angles, (1.0, -1.0), strict=True):
        flat = mesh_section(zone, middle * np.sin(angle) * np.sin(share_of), row.depth, is_roller=False)
        shape = roller_body.raceway_point_map(middle, angle, outward)
        rings.append(extrude(flat, zone, longer, reach, shape, mirrored=outward > 0.0))
    elastic = row.material.youngs_modulus, row.material.poissons_ratio
    S, A = (roller_compliance(roller, *elastic, symmetric_loads=even) for even in (True, False))
    own = [race_compliance(ring, *elastic, share_of) for ring in rings]
    same, other = 0.5 * (S + A), 0.5 * (S - A)
    matrix = np.block([[same + own[0], other], [other, same + own[1]]])
    along, across = roller.distances_from_apex - middle, roller.distances_from_contact_line
    x, y = np.repeat(along, len(across)), np.tile(across, len(along))
    place = middle + x
    sag = [_distance_from_tangent_plane(place, y * place / middle, angle) for angle in (row.roller_angle, *angles)]
    crown, edge = crown_and_end_rounding_depths(row, x)
    gap = np.concatenate([sag[0] - sag[1], sag[0] + sag[2]]) + np.tile(crown + edge, 2)
    areas = np.asarray(forms.pressure_function_integrals(roller.mesh, roller.contact_nodes.ravel()).sum(axis=1)).ravel()
    meshes = (roller, *rings)
    return CondensedRoller(
        roller_row=row,
        positions_along=along,
        positions_across=across,
        compliance=matrix,
        undeformed_gaps=gap,
        gap_closing_matrix=_gap_closing_matrix(roller, rings[0], middle * np.cos(row.roller_angle)),
        nodal_areas=areas.reshape(len(along), -1),
        cell_count=sum(len(one.cells) for one in meshes),
        degree_of_freedom_count=sum(3 * len(one.points) for one in meshes),
        elapsed_seconds=perf_counter() - wall,
        cpu_seconds=process_time() - cpu,
    )


def _distance_from_tangent_plane(along: Array, across: Array, angle: float) -> Array:
    """Return the depth of points on a cone below the plane that touches the cone along a generator [m].

    ``along``: distances of the points from the apex, along that generator [m]; ``across``: distances of the points
    from the generator, in the plane [m]; ``angle``: half angle of the cone [rad].
    """
    radius = along * np.sin(angle)
    return np.asarray(radius * np.cos(angle) * (1.0 - np.sqrt(1.0 - (across / radius) ** 2)))


def _nodal_forces_of_pressure_functions(body: roller_body.ExtrudedRollerBody) -> sp.csr_array:
    """Assemble the nodal forces of unit loads on a contact zone: one row for each basis function of the contact pressure.

    ``body``: mesh of a quarter of the roller or of half a race; the loads press into it, along the normals of its contact
    zone.
    """
    contact = body.contact_nodes.ravel()
    W = forms.normalise_weight_rows(forms.pressure_function_integrals(body.mesh, contact)).tocoo()
    normal = body.inward_normals.reshape(-1, 3)[W.col]
    rows, columns = np.repeat(W.row, 3), (3 * contact[W.col][:, None] + np.arange(3)).ravel()
    return sp.csr_array(((W.data[:, None] * normal).ravel(), (rows, columns)), (len(contact), 3 * len(body.points)))


def roller_compliance(
    body: roller_body.ExtrudedRollerBody, young: float, poisson: float, *, symmetric_loads: bool
) -> Array:
    """Compute the compliance of a roller between the m n contact nodes of its meshed quarter ``(m n, m n)`` [m/N].

    ``body``: mesh of the quarter; ``young``: Young's modulus [Pa]; ``poisson``: Poisson's ratio; ``symmetric_loads``:
    whether the loads of cup and cone are symmetric about the plane midway between both contacts; otherwise they are
    antisymmetric.
    """
    K, rows = forms.elastic_stiffness(body.mesh, young, poisson), _nodal_forces_of_pressure_functions(body)
    side, points = nodes_on_boundaries(body.mesh, "side"), body.points
    axis = np.intersect1d(side, nodes_on_boundaries(body.mesh, "y = 0"))
    ends = axis[[points[axis, 2].argmin(), points[axis, 2].argmax()]]
    held = [3 * nodes_on_boundaries(body.mesh, "y = 0") + 1]
    if symmetric_loads:
        held += [3 * side, 3 * ends[1:] + 2]
        along = np.zeros(3 * len(points))
        along[2::3] = 1.0
        thrust = np.zeros(3 * len(points))
        thrust[2::3] = forms.nodal_volume_form().assemble(forms.face_basis(body.mesh, "end"))
        rows = sp.vstack([rows, sp.csr_array(thrust[None] / thrust.sum())]).tocsr()
        carried = -(rows[:-1] @ along)  # force of the rib, even over the large end
        change = np.column_stack([np.eye(len(carried)), carried])
    else:
        held += [3 * side + 1, 3 * side + 2, 3 * ends]  # this support carries no force in equilibrium
        change = np.eye(rows.shape[0])
    free = np.setdiff1d(np.arange(K.shape[0]), np.concatenate(held))
    found = symmetric_compliance_of_loads(K[free][:, free], rows[:, free])
    return np.asarray(change @ found @ change.T)


def race_compliance(body: roller_body.ExtrudedRollerBody, young: float, poisson: float, sector_angle: float) -> Array:
    """Compute the compliance between the m n contact nodes of one race, cup or cone ``(m n, m n)`` [m/N].

    ``body``: mesh of half the sector of the race that belongs to one roller; ``young``: Young's modulus [Pa];
    ``poisson``: Poisson's ratio; ``sector_angle``: angle of the meshed sector about the bearing's axis [rad].
    """
    K, rows = forms.elastic_stiffness(body.mesh, young, poisson), _nodal_forces_of_pressure_functions(body)
    side = nodes_on_boundaries(body.mesh, "side")
    turn = np.ones((2, len(side))) * np.array([[np.cos(sector_angle)], [np.sin(sector_angle)]])
    x, y = 3 * side, 3 * side + 1
    rest = np.setdiff1d(np.arange(K.shape[0]), np.concatenate([x, y]))
    at = (np.concatenate([rest, x, x, y, y]), np.concatenate([rest, x, y, x, y]))
    T = sp.csc_array((np.concatenate([np.ones(len(rest)), turn[0], -turn[1], turn[1], turn[0]]), at), K.shape)
    K, rows = (T.T @ K @ T).tocsc(), (rows @ T).tocsr()  # on the side, y is the direction of the azimuth
    base = nodes_on_boundaries(body.mesh, "base")
    held = np.concatenate([3 * nodes_on_boundaries(body.mesh, "y = 0") + 1, y, *(3 * base + k for k in range(3))])
    free = np.setdiff1d(np.arange(K.shape[0]), held)
    return symmetric_compliance_of_loads(K[free][:, free], rows[:, free])


def _gap_closing_matrix(
    roller: roller_body.ExtrudedRollerBody, cup: roller_body.ExtrudedRollerBody, middle_from_apex: float
) -> Array:
    """Return the gap that each of three unit motions closes at each contact node ``(2 m n, 3)``, the cup's nodes first.

    Each contact zone has m nodes along the roller by n nodes across it. The motions are the approach of the cup, the
    translation of the roller towards the cup, and the tilt of the roller. ``middle_from_apex``: distance of the roller's
    middle from the apex, along the roller's axis [m].
    """
    n = -roller.inward_normals.reshape(-1, 3)
    arm = roller.points[roller.contact_nodes.ravel()]
    moves = np.column_stack([n[:, 0], n[:, 0] * (arm[:, 2] - middle_from_apex) - n[:, 2] * arm[:, 0]])
    normal = cup.inward_normals.reshape(-1, 3)
    approach = normal @ normal[0]
    nothing = np.zeros_like(approach)
    return np.column_stack([np.concatenate([approach, nothing]), np.concatenate([moves, -moves])])


#: Advice for rollers with sharp ends.
SHARP = "add the rollers' edge_radius, or a crown with which the contact ends before the roller does"

#: Relative change of the load for the difference quotient that gives the stiffness.
STEP = 0.01


def press_roller_between_races(bodies: CondensedRoller, load: float) -> RollerContactSolution:
    """Solve the contacts of a roller pressed between cup and cone: approach, pressures, stiffness by finite differences.

    Parameters
    ----------
    bodies
        Roller, cup and cone, condensed.
    load
        Force of each race on the roller [N], at most the load for which the bodies were meshed.

    Returns
    -------
    RollerContactSolution
        Approach, stiffness and pressures.

    Raises
    ------
    RollerError
        The contact does not converge, or reaches a sharp end of the roller or the end of the contact zone.
    """
    wall, cpu = perf_counter(), process_time()
    C, N = balls.contact_compliance_of_single_ball(bodies.compliance), sp.csr_array(bodies.gap_closing_matrix)
    found: list[balls.ContactResult] = []
    state: balls.SolverState | None = None
    for factor in (1.0 - STEP, 1.0 + STEP, 1.0):
        loads = np.array([0.5 * factor * load, 0.0, 0.0])
        result, state = balls.solve_contacts_of_all_balls(C, bodies.undeformed_gaps, N, loads, start=state)
        if not result.converged:
            reason = f"the roller's contact did not converge: {result.status}"
            raise RollerError(reason, "change the load or the mesh level")
        found.append(result)
    forces = found[2].forces.reshape(2, *bodies.nodal_areas.shape)
    touched = forces > 0.0
    at_ends = touched[:, [0, -1]].any()
    if at_ends and bodies.roller_row.edge_radius is None:
        reason = "the roller touches its races with its sharp ends, at which the contact pressure is infinite"
        raise RollerError(reason, SHARP)
    if at_ends or touched[:, :, -1].any():
        reason = "the roller touches its races outside the contact zone of the mesh"
        raise RollerError(reason, "increase the rollers' edge_radius, or decrease the load")
    steps = np.diff(bodies.positions_along)
    widths = np.append(0.0, steps) / 2.0 + np.append(steps, 0.0) / 2.0
    total = 2.0 * forces.reshape(2, -1) @ np.ones(bodies.nodal_areas.size)
    return RollerContactSolution(
        race_force=load,
        approach=float(found[2].rigid_motions[0]),
        stiffness=float(2.0 * STEP * load / (found[1].rigid_motions[0] - found[0].rigid_motions[0])),
        pressures=forces / bodies.nodal_areas,
        line_loads=2.0 * forces.sum(axis=2) / widths,
        load_imbalance=float(np.abs(total / load - 1.0).max()),
        elapsed_seconds=perf_counter() - wall,
        cpu_seconds=process_time() - cpu,
    )
