"""Hertz contact on a finite block of elements, with the far field of the half-space on its cut faces.

The block is a quarter of the half-space z > 0 (x = 0 and y = 0 are planes of symmetry). With its cut faces fixed it is
too stiff: a block of 5 mm shifts a ball's approach by 1.7-2.5 %. Here the cut moves as it would in the half-space, by
Boussinesq's displacement of each contact load. By superposition, with i the free degrees of freedom, c those of the cut,
P the unit contact loads and B the displacements of the cut under them,

    u_i = K_ii^-1 (P - K_ic B) lambda,    C = P^T K_ii^-1 P - (K_ci K_ii^-1 P)^T B:

the compliance with the cut fixed, plus the contribution of the cut's motion through the reactions computed with it fixed.
The second term is the compliance between the loads P and the loads -K_ic B. It replaces the rest of the half-space up to
the difference between a nodal force and a point force, seen from the cut.

Both bodies of a Hertz contact are half-spaces of the same material: one is modelled, and its compliance doubled.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
import scipy.sparse as sp

from rollbench.hifi.contact.balls import contact_compliance_of_single_ball, solve_contacts_of_all_balls
from rollbench.hifi.contact.hertz import HertzSolution, solve_hertz
from rollbench.hifi.elements.forms import elastic_stiffness, nodal_areas
from rollbench.hifi.linear_algebra import symmetric_compliance_of_loads
from rollbench.meshes import block
from rollbench.meshes.arrays import Array
from rollbench.meshes.fem import degrees_of_freedom_on_boundaries, nodes_on_boundaries

#: Edge of the block over the long semi-axis of the contact. The far field makes the result independent of this size.
SIZE = 3.0
#: Ratio of the sizes of neighbouring hexahedra outside the contact, and edge of tetrahedra there over their distance from
#: the contact, both for a mesh of four cells across the short semi-axis.
GROWTH, GRADING = 1.8, 0.5
#: Tetrahedra of Lin's thesis (section 2.4.1) [m]: first order, edge within the body of influence and elsewhere. The thesis
#: does not state the size and shape of that body; here it is a sphere of this radius, with edges growing by a fifth of the
#: distance beyond.
SOURCE_FINE, SOURCE_COARSE, SOURCE_RADIUS = 0.08e-3, 5e-3, 0.8e-3


@dataclass(frozen=True, eq=False)
class SurfaceCompliance:
    """Compliance between m surface nodes of a half-space, one quarter of which is meshed, under normal forces."""

    #: Coordinates x, y of the nodes on the surface ``(m, 2)`` [m].
    surface_points: Array
    #: Area of the quarter's surface that each node carries ``(m,)`` [m2]; pressure = force / area.
    nodal_areas: Array
    #: Displacement of each node into the body by a unit force on each node, in the half-space ``(m, m)`` [m/N].
    half_space_compliance: Array
    #: Displacement of each node into the body by a unit force on each node, in a block whose cut faces are fixed
    #: ``(m, m)`` [m/N].
    fixed_block_compliance: Array
    #: Largest difference of ``half_space_compliance`` from its transpose, over its largest entry, before it was made
    #: symmetric.
    asymmetry: float
    #: Number of degrees of freedom of the mesh that are not fixed.
    free_degree_of_freedom_count: int


def boussinesq_displacements(points: Array, sources: Array, young: float, poisson: float) -> Array:
    """Compute the displacements of the half-space z > 0 under unit normal forces on its surface, by Boussinesq's formula.

    u_r = (1 + nu)/(2 pi E) (r z/R^3 - (1 - 2 nu) r/(R (R + z))), u_z = (1 + nu)/(2 pi E) (z^2/R^3 + 2 (1 - nu)/R), where R
    is the distance from the force and r its part along the surface. The displacement is infinite where a force acts.

    Parameters
    ----------
    points : (n, 3) Array
        Points [m].
    sources : (m, 2) Array
        Coordinates x, y of the forces, which act along +z at z = 0 [m].
    young : float
        Young's modulus [Pa].
    poisson : float
        Poisson's ratio.

    Returns
    -------
    (n, 3, m) Array
        Displacements along x, y, z [m/N].

    References
    ----------
    Johnson, Contact Mechanics (1985), eqs. (3.18) and (3.19).

    Examples
    --------
    >>> below = boussinesq_displacements(np.array([[0.0, 0.0, 1e-3]]), np.zeros((1, 2)), 210e9, 0.3)
    >>> f"{1e9 * below[0, 2, 0]:.4f} nm/N"  # (1 + nu) (3 - 2 nu) / (2 pi E z)
    '2.3646 nm/N'
    """
    offset = points[:, None, :2] - sources
    z = points[:, 2, None]
    distance = np.sqrt((offset**2).sum(axis=2) + z**2)
    along = z / distance**3 - (1.0 - 2.0 * poisson) / (distance * (distance + z))
    down = z**2 / distance**3 + 2.0 * (1.0 - poisson) / distance
    parts = np.stack([along * offset[..., 0], along * offset[..., 1], down], axis=1)
    return np.asarray((1.0 + poisson) / (2.0 * np.pi * young) * parts)


def nodal_contact_areas(mesh: block.QuarterBlockMesh) -> Array:
    """Compute the area of the contact plane that belongs to each node: the integral of the node's shape function.

    A uniform pressure loads only the midside nodes of 6-node triangles, not their corners, so that only midside nodes may
    touch. Pressures defined at the corners too, or linear between them, oscillate by tens of per cent on the same meshes.

    Parameters
    ----------
    mesh : QuarterBlockMesh
        Quarter block.

    Returns
    -------
    (n,) Array
        Areas of the n nodes of the mesh [m2]; zero for nodes that do not lie on the contact plane.
    """
    areas = nodal_areas(mesh.mesh, "contact")
    return np.where(areas > 1e-6 * areas.max(initial=0.0), areas, 0.0)


def surface_compliance(
    mesh: block.QuarterBlockMesh, semi_axes: tuple[float, float], young: float, poisson: float
) -> SurfaceCompliance:
    """Compute the compliance between surface nodes within an ellipse, for a half-space and for a block with fixed faces.

    Both compliances follow from one mesh of a block, whose cut faces move as in the half-space, or are fixed.

    Parameters
    ----------
    mesh : QuarterBlockMesh
        Quarter block.
    semi_axes : tuple[float, float]
        Semi-axes along x, y of the ellipse in which nodes may touch [m].
    young : float
        Young's modulus [Pa].
    poisson : float
        Poisson's ratio.

    Returns
    -------
    SurfaceCompliance
        Compliance between these nodes.

    Raises
    ------
    FactorError
        The stiffness of the mesh cannot be factored.
    """
    K = sp.csr_array(elastic_stiffness(mesh.mesh, young, poisson))
    areas = nodal_contact_areas(mesh)
    near = ((mesh.points[:, :2] / np.array(semi_axes)) ** 2).sum(axis=1) <= 1.0
    nodes = np.flatnonzero((areas > 0.0) & near)
    cut, m = degrees_of_freedom_on_boundaries(mesh.mesh, "cut"), len(nodes)
    on_x, on_y = (nodes_on_boundaries(mesh.mesh, plane) for plane in ("x = 0", "y = 0"))
    free = np.setdiff1d(np.arange(K.shape[0]), np.concatenate([cut, 3 * on_x, 3 * on_y + 1]))
    unit = sp.csr_array((np.ones(m), (np.arange(m), 3 * nodes + 2)), (m, K.shape[0]))
    by_cut = sp.csr_array(-(K[cut].T @ _half_space_motion_of_cut_faces(mesh, mesh.points[nodes, :2], young, poisson)).T)
    F = symmetric_compliance_of_loads(K[free][:, free], sp.vstack([unit, by_cut]).tocsr()[:, free])
    full = F[:m, :m] + F[:m, m:]
    return SurfaceCompliance(
        surface_points=mesh.points[nodes, :2],
        nodal_areas=areas[nodes],
        half_space_compliance=0.5 * (full + full.T),
        fixed_block_compliance=F[:m, :m],
        asymmetry=float(np.abs(full - full.T).max() / np.abs(full).max()),
        free_degree_of_freedom_count=len(free),
    )


def _half_space_motion_of_cut_faces(mesh: block.QuarterBlockMesh, sources: Array, young: float, poisson: float) -> Array:
    """Compute how a block's cut faces move in the half-space under unit surface forces ``(3 cut nodes, m)`` [m/N].

    ``sources``: coordinates x, y of the m forces in the meshed quarter (m, 2) [m]. Each acts together with its mirror
    images in the other three quarters.
    """
    points = mesh.points[nodes_on_boundaries(mesh.mesh, "cut")]
    images = [np.array(signs) for signs in product((1.0, -1.0), repeat=2)]
    total = sum(boussinesq_displacements(points, sources * signs, young, poisson) for signs in images)
    return np.asarray(total).reshape(3 * len(points), len(sources))


@dataclass(frozen=True)
class HertzProblem:
    """Hertz contact of two bodies of one material, to be solved by finite elements.

    The gap of the undeformed bodies is x^2/(2 R_x) + y^2/(2 R_y), with the relative radii of curvature R_x and R_y.
    """

    #: Name of the contact, for messages and tables.
    name: str
    #: Relative radius of curvature R_x along x [m].
    relative_radius_x: float
    #: Relative radius of curvature R_y along y [m], at most ``relative_radius_x``, so that the long semi-axis lies along x.
    relative_radius_y: float
    #: Young's modulus [Pa].
    young: float = 210e9
    #: Poisson's ratio.
    poisson: float = 0.28
    #: Normal force [N].
    load: float = 225.0

    @property
    def hertz_solution(self) -> HertzSolution:
        """Hertz's closed-form solution of the contact."""
        return solve_hertz(self.load, self.relative_radius_x, self.relative_radius_y, self.young, self.poisson)


#: Radii [m] of the ball, of the groove across (x) and of its convex course along (y).
BALL, GROOVE, ALONG = 2.778e-3, 3.254e-3, 20.56e-3
#: A: ball on a flat. B: ball in a groove.
JOBS = {
    "A": HertzProblem("A", BALL, BALL),
    "B": HertzProblem("B", 1.0 / (1.0 / BALL - 1.0 / GROOVE), 1.0 / (1.0 / BALL + 1.0 / ALONG)),
}


@dataclass(frozen=True)
class HertzContactSolution:
    """Finite-element solution of a Hertz contact on one mesh, with the closed form for comparison."""

    #: Name of the contact that was solved.
    contact_name: str
    #: Element type: P1, P2, Q1 or Q2.
    element: str
    #: Number of mesh cells across the short semi-axis of the contact ellipse.
    b_over_h: float
    #: Number of degrees of freedom of the mesh that are not fixed.
    free_degree_of_freedom_count: int
    #: Number of surface nodes that may come into contact.
    contact_node_count: int
    #: Number of iterations of Newton's method.
    newton_iteration_count: int
    #: Approach of the two bodies [m].
    approach: float
    #: Semi-axis along x [m] of the semi-ellipsoid of pressure whose load and second moments are those of the nodal forces
    #: f: semi_x^2 = 5 sum(f x^2) / sum(f), which is exact for Hertz's pressure.
    semi_x: float
    #: Semi-axis along y [m] of the same semi-ellipsoid of pressure.
    semi_y: float
    #: Peak pressure [Pa]: pressure (force over area) at the node nearest to the centre of the contact, extrapolated to the
    #: centre by the shape of the semi-ellipsoid. All meshes but P2 have a node at the centre.
    pole_pressure: float
    #: Peak pressure [Pa] of a semi-ellipsoid on the semi-axes ``semi_x`` and ``semi_y``, fitted to all nodal pressures by
    #: least squares over the area.
    fitted_pole_pressure: float
    #: Hertz's closed-form solution of the contact.
    hertz_solution: HertzSolution


def solve_hertz_contact(
    job: HertzProblem,
    element: str,
    b_over_h: float,
    *,
    relative_block_size: float = SIZE,
    far_field: bool = True,
    mesh_scale: float = 1.0,
) -> HertzContactSolution:
    """Solve a Hertz contact by finite elements, on a mesh that is refined at its contact ellipse.

    With growing ``b_over_h`` meshes of one element type become finer everywhere, so that the solution converges.

    Parameters
    ----------
    job : HertzProblem
        Contact to be solved, such as one of `JOBS`.
    element : str
        Tetrahedra ("P1", "P2") or hexahedra ("Q1", "Q2") of first or second order. Hexahedra are stretched like the
        ellipse, with as many cells across its long semi-axis as across the short one; tetrahedra are not.
    b_over_h : float
        Cells across the short semi-axis.
    relative_block_size : float, default SIZE
        Edge of the block over the long semi-axis.
    far_field : bool, default True
        True: the cut faces of the block move as in the half-space; False: they are fixed.
    mesh_scale : float, default 1.0
        Ratio of the semi-axes for which the mesh is made to those of the contact; other values than 1 move the contact's
        edge relative to the mesh.

    Returns
    -------
    HertzContactSolution
        Result and closed form.

    Raises
    ------
    ValueError
        ``element`` is not one of the four element types.
    ArithmeticError
        The contact does not converge, or the stiffness cannot be factored.
    """
    a, b = mesh_scale * job.hertz_solution.semi_x, mesh_scale * job.hertz_solution.semi_y
    refinement = b_over_h / 4.0
    if element in ("Q1", "Q2"):
        order = int(element[1])
        edge = np.array([a, b, b]) / b_over_h
        core, growth = (1.15 * a, 1.15 * b, 0.0), GROWTH ** (1.0 / refinement)
        mesh = block.mesh_block_with_hexahedra(order, tuple(edge / order), core, relative_block_size * a, growth)
    elif element in ("P1", "P2"):
        zone, size = (1.15 * a, 1.15 * b, 0.5 * b), relative_block_size * a
        influence = block.EllipsoidElementSizes(b / b_over_h, zone, GRADING / refinement, size)
        mesh = block.mesh_block_with_tetrahedra(int(element[1]), influence, size)
    else:
        raise ValueError(f"the element type of a block must be one of P1, P2, Q1, Q2, got {element!r}")
    return solve_hertz_contact_on_mesh(job, mesh, b_over_h, far_field=far_field)


def solve_hertz_contact_on_lin_mesh(job: HertzProblem) -> HertzContactSolution:
    """Solve a Hertz contact on first-order tetrahedra as in Lin's thesis: edges of 0.08 mm at the contact, 5 mm elsewhere.

    Parameters
    ----------
    job : HertzProblem
        Contact to be solved, such as one of `JOBS`.

    Returns
    -------
    HertzContactSolution
        Result and closed form.

    References
    ----------
    Lin (2019), section 2.4.1.
    """
    influence = block.EllipsoidElementSizes(SOURCE_FINE, (SOURCE_RADIUS,) * 3, 0.2, SOURCE_COARSE)
    mesh = block.mesh_block_with_tetrahedra(1, influence, SOURCE_COARSE)
    return solve_hertz_contact_on_mesh(job, mesh, job.hertz_solution.semi_y / SOURCE_FINE)


def solve_hertz_contact_on_mesh(
    job: HertzProblem, mesh: block.QuarterBlockMesh, b_over_h: float, *, far_field: bool = True
) -> HertzContactSolution:
    """Solve a Hertz contact on a given mesh of a quarter block.

    Parameters
    ----------
    job : HertzProblem
        Contact.
    mesh : QuarterBlockMesh
        Quarter block.
    b_over_h : float
        Number of cells of the mesh across the short semi-axis.
    far_field : bool, default True
        True: the cut faces of the block move as in the half-space; False: they are fixed.

    Returns
    -------
    HertzContactSolution
        Result and closed form.

    Raises
    ------
    ArithmeticError
        The contact does not converge.
    """
    margin = 1.0 + 1.5 / (int(mesh.element[1]) * b_over_h)  # the contact may end one node too far
    reach = (margin * job.hertz_solution.semi_x, margin * job.hertz_solution.semi_y)
    surface = surface_compliance(mesh, reach, job.young, job.poisson)
    x, y = surface.surface_points.T
    gap = x**2 / (2.0 * job.relative_radius_x) + y**2 / (2.0 * job.relative_radius_y)
    matrix = 2.0 * (surface.half_space_compliance if far_field else surface.fixed_block_compliance)  # two bodies
    C, closing = contact_compliance_of_single_ball(matrix), sp.csr_array(np.ones((len(gap), 1)))
    quarter = np.array([0.25 * job.load])
    result, _ = solve_contacts_of_all_balls(C, gap, closing, quarter)
    if not result.converged:
        raise ArithmeticError(
            f"Hertz contact {job.name} on a mesh of {mesh.element} elements with {b_over_h:g} cells across its short "
            f"semi-axis: {result.status}"
        )
    semi, pole, fitted = fit_pressure_ellipsoid(surface.surface_points, surface.nodal_areas, result.forces)
    return HertzContactSolution(
        contact_name=job.name,
        element=mesh.element,
        b_over_h=b_over_h,
        free_degree_of_freedom_count=surface.free_degree_of_freedom_count,
        contact_node_count=len(gap),
        newton_iteration_count=result.iterations,
        approach=float(result.rigid_motions[0]),
        semi_x=semi[0],
        semi_y=semi[1],
        pole_pressure=pole,
        fitted_pole_pressure=fitted,
        hertz_solution=job.hertz_solution,
    )


def fit_pressure_ellipsoid(places: Array, areas: Array, forces: Array) -> tuple[tuple[float, float], float, float]:
    """Fit a semi-ellipsoidal (Hertzian) pressure distribution to nodal contact forces.

    Parameters
    ----------
    places : (n, 2) Array
        Coordinates of the nodes from the contact's centre [m].
    areas : (n,) Array
        Area of the surface that each node carries [m2].
    forces : (n,) Array
        Nodal forces [N].

    Returns
    -------
    semi : tuple[float, float]
        Semi-axes along both coordinates, from the second moments of the forces [m].
    pole : float
        Peak pressure from the node nearest to the centre, as `HertzContactSolution.pole_pressure` [Pa].
    fitted : float
        Peak pressure fitted to all nodal pressures by least squares, as `HertzContactSolution.fitted_pole_pressure` [Pa].
    """
    pressure = forces / areas
    squares = 5.0 * (forces @ places**2) / forces.sum()
    ellipse = (places**2 / squares).sum(axis=1)
    height = np.sqrt(np.maximum(1.0 - ellipse, 0.0))
    nearest = int(ellipse.argmin())
    fitted = (areas * height) @ pressure / ((areas * height) @ height)
    semi = np.sqrt(squares)
    return (float(semi[0]), float(semi[1])), float(pressure[nearest] / height[nearest]), float(fitted)
