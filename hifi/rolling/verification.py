"""Verification of the rolling model by contacts with known solutions, solved on grids.

The known solutions are the static reference's pressure, Carter's cylinder and Cattaneo and Mindlin's sphere in closed form,
balls that touch at a point, Kalker's linear theory, full slip under Hertz's pressure by fine quadrature, and contacts under
prescribed creepages.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rollbench.hifi.bodies.coarse import contact_compliance_in_fine_submodel
from rollbench.hifi.bodies.grid_wave import solve_unilateral_contact
from rollbench.hifi.contact.block import fit_pressure_ellipsoid
from rollbench.hifi.contact.hertz import solve_hertz
from rollbench.hifi.elements.forms import normalise_weight_rows
from rollbench.hifi.rolling import bodies
from rollbench.hifi.rolling import patch as rolling_patch
from rollbench.hifi.rolling.balls import RollingResult, quadrature_of_unit_disk
from rollbench.hifi.rolling.bodies import Sizes
from rollbench.hifi.rolling.contact_bodies import ContactZone, mesh_half_space
from rollbench.hifi.rolling.friction import FrictionContact, FrictionSolution, coulomb_friction_forces, solve_friction
from rollbench.hifi.rolling.kinematics import MOTIONS, RollingBalls, velocities_by_ball_motions
from rollbench.hifi.rolling.patch import GridContact
from rollbench.meshes.arrays import Array

#: Length over half width of the contact strip that represents a cylinder.
LONG = 1e4
#: Points along each axis over which the displacement of a rectangle is averaged.
MEANS = 200


@dataclass(frozen=True)
class Creep:
    """Longitudinal, lateral and spin creepage of a rolling contact: rigid slip over the rolling speed."""

    #: Rigid slip along the rolling direction, over the rolling speed.
    longitudinal: float
    #: Rigid slip across the rolling direction, over the rolling speed.
    lateral: float
    #: Angular velocity about the contact normal (spin), over the rolling speed [1/m].
    spin: float

    def rigid_slip(self, at: Array) -> Array:
        """Compute the rigid slip over the rolling speed at n points of the contact ``(2 n,)``, all along, then all across.

        ``at``: coordinates of the points along and across the rolling direction, from the contact's centre (n, 2) [m].

        Examples
        --------
        >>> Creep(0.001, 0.0, 2.0).rigid_slip(np.array([[0.0, 1e-3]])).tolist()
        [-0.001, 0.0]
        """
        return np.concatenate([self.longitudinal - self.spin * at[:, 1], self.lateral + self.spin * at[:, 0]])


@dataclass(frozen=True)
class RolledContact:
    """Friction force, moment and loss of a contact that rolls steadily at 1 m/s."""

    #: Friction force on body 1 along and across the rolling direction ``(2,)`` [N].
    friction_force: Array
    #: Moment of friction on body 1 about the contact normal [N m].
    friction_moment: float
    #: Normal contact on its grid.
    normal_contact: GridContact
    #: Tangential forces and slips in every cell.
    friction_solution: FrictionSolution
    #: Power dissipated by friction in the contact [W].
    friction_loss: float
    #: Power dissipated by the error of the finite differences along the flow of material [W].
    numerical_dissipation: float


def solve_friction_for_rigid_slip(
    patch: GridContact, elastic: Array, slip: Array, mu: float
) -> tuple[FrictionContact, FrictionSolution]:
    """Solve for the tangential forces of a contact whose bodies have a prescribed rigid slip.

    Parameters
    ----------
    patch : GridContact
        The contact, of n cells.
    elastic : (2 n, 2 n) Array
        Slip that unit tangential forces cause by elastic displacements [m/s/N].
    slip : (2 n,) Array
        Rigid slip [m/s].
    mu : float
        Coefficient of friction.

    Returns
    -------
    contact : FrictionContact
        Input of the friction solver.
    solution : FrictionSolution
        Solution of the friction solver.
    """
    no_motions = np.zeros((slip.size, 0)), np.zeros(0, dtype=np.int64)
    contact = FrictionContact(mu * patch.normal_forces, elastic, *no_motions, slip)
    return contact, solve_friction([contact])


def solve_steady_rolling_for_creepages(patch: GridContact, creep: Creep, mu: float, elastic: float = 1.0) -> RolledContact:
    """Solve the friction of a contact that rolls steadily at 1 m/s under prescribed creepages.

    Parameters
    ----------
    patch : GridContact
        Normal contact on its grid.
    creep : Creep
        The creepages.
    mu : float
        Coefficient of friction.
    elastic : float, default 1.0
        Factor on the tangential compliance of the bodies.

    Returns
    -------
    RolledContact
        Force and moment on body 1, friction loss, and the solution in every cell.
    """
    transport = elastic * patch.elastic_slip_per_rolling_length
    return _solve_rolling_at_unit_speed(patch, transport, creep.rigid_slip(patch.cell_centres), mu)


def solve_steady_rolling_like_kalker(patch: GridContact, creep: Creep, mu: float) -> RolledContact:
    """Solve the friction of a contact that rolls steadily at 1 m/s, discretised as in Kalker's program CONTACT.

    Differences along the flow are of first order over a whole cell, and the slip by spin is taken a sixth of a cell
    upstream (`set_tang_rhs`, `influe_cv_csv` in CONTACT).

    Parameters
    ----------
    patch : GridContact
        Normal contact on its grid.
    creep : Creep
        The creepages.
    mu : float
        Coefficient of friction.

    Returns
    -------
    RolledContact
        Force and moment on body 1, friction loss, and the solution in every cell.
    """
    step = float(patch.cell_size[0])
    transport = (patch.tangential_compliance() - patch.tangential_compliance(step)) / step
    upstream = patch.cell_centres + np.array([step / 6.0, 0.0])
    return _solve_rolling_at_unit_speed(patch, transport, creep.rigid_slip(upstream), mu)


def _solve_rolling_at_unit_speed(patch: GridContact, transport: Array, slip: Array, mu: float) -> RolledContact:
    """Solve the friction of a contact that rolls steadily at 1 m/s with a prescribed rigid slip.

    ``transport``: slip that unit tangential forces cause by elastic displacements (2 n, 2 n) [m/s/N]; ``slip``: rigid slip
    (2 n,) [m/s]; ``mu``: coefficient of friction.
    """
    contact, solution = solve_friction_for_rigid_slip(patch, transport, slip, mu)
    q = solution.forces[0]
    loss, upwind = -float(q @ solution.slips[0]), float(q @ (contact.elastic_slip_matrix @ q))
    return RolledContact(*_resultant_force_and_moment(patch.cell_centres, q), patch, solution, loss, upwind)


@dataclass(frozen=True)
class RollingOnsetStep:
    """State after one step of a contact that is loaded tangentially and then begins to roll under the same force."""

    #: Shift of body 1 along x after the push [m], or creepage along x after a step of rolling.
    shift_or_creepage: float
    #: Number of cells of the contact that stick.
    sticking_cell_count: int
    #: Energy dissipated by friction in the push [J], or power dissipated in a step of rolling at 1 m/s [W].
    friction_loss: float


def simulate_rolling_onset(patch: GridContact, mu: float, share: float, steps: int) -> list[RollingOnsetStep]:
    """Simulate a contact that is pushed along x and then rolls under the same tangential force.

    The contact passes from Cattaneo's solution (at rest) to Carter's (steady rolling). After the push, the contact rolls by
    one cell in each step, as in an example of Kalker's program CONTACT.

    Parameters
    ----------
    patch : GridContact
        Normal contact on its grid.
    mu : float
        Coefficient of friction.
    share : float
        Ratio Q/(mu P) of the tangential force Q to the friction limit, the normal force P times the coefficient of friction
        mu.
    steps : int
        Number of steps of rolling.

    Returns
    -------
    list[RollingOnsetStep]
        State after the push, and after every step of rolling.

    Raises
    ------
    ValueError
        A step does not converge.
    """
    n, size = len(patch.cell_centres), float(patch.cell_size[0])
    motion, bound = np.repeat([1.0, 0.0], n)[:, None], mu * patch.normal_forces

    def equilibrium_under_constant_force(_: Array) -> tuple[Array, Array]:
        return np.array([share * mu * patch.normal_load]), np.zeros((1, 1))

    forces, y, out = np.zeros(2 * n), np.array([patch.approach]), []
    response, upstream = patch.tangential_compliance(), patch.tangential_compliance(size)
    for step in range(steps + 1):
        seconds = 1.0 if step == 0 else size  # of a cell at 1 m/s
        contact = FrictionContact(bound, response / seconds, motion, np.array([0]), -upstream @ forces / seconds)
        solution = solve_friction([contact], equilibrium_under_constant_force, y, [forces] if step else None)
        if not solution.converged:
            raise ValueError(f"the friction of a contact that begins to roll, step {step}: {solution.status}")
        forces, y = solution.forces[0], solution.motions
        sticking = int(np.count_nonzero(solution.stick[0]))
        out.append(RollingOnsetStep(float(y[0]), sticking, -float(forces @ solution.slips[0])))
    return out


def spread_of_unused_friction(patch: GridContact, bound: Array, tangential: Array) -> Array:
    """Measure the size of the stick zone along x and y by the spread of the unused friction, mu p - abs(q).

    p: normal force of a cell; q: tangential force. The unused friction, the increase of q that is left before a cell slips,
    is zero where cells slip, and taken as uniform over a cell. Its standard deviations about its centre, along x and y,
    measure the size of the stick zone without counting the zone's cells. The error of the standard deviations is of
    second order in the cell size, with a scatter of 0.1 % on 20 to 40 cells; the error of a count is of first order.

    Parameters
    ----------
    patch : GridContact
        Normal contact on a grid of n cells.
    bound : (n,) Array
        Largest possible tangential force mu p of each cell [N].
    tangential : (2 n,) Array
        Tangential forces q, all along x and then all along y [N].

    Returns
    -------
    (2,) Array
        Standard deviations along x and y [m].
    """
    left = bound - np.linalg.norm(tangential.reshape(2, -1), axis=0)
    share = left / left.sum()
    return np.asarray(np.sqrt(share @ (patch.cell_centres - share @ patch.cell_centres) ** 2 + patch.cell_size**2 / 12.0))


# --- the static reference


@dataclass(frozen=True)
class NormalContact:
    """Approach of a contact at rest, and the semi-axes and peak of the semi-ellipsoid fitted to its pressure."""

    #: Approach of ball and groove [m].
    approach: float
    #: Semi-axes of the semi-ellipsoid fitted to the pressure, along and across the groove [m].
    semi_axes: tuple[float, float]
    #: Peak pressure of the semi-ellipsoid fitted to the pressure [Pa].
    peak_pressure: float


def solve_normal_contact_by_rolling_model(
    at: bodies.ContactGeometry, load: float, young: float, poisson: float, shape: tuple[int, int], sizes: Sizes
) -> NormalContact:
    """Solve the normal contact of ball and groove by the rolling model, to compare it with the static 3D reference.

    The model has half-spaces on a grid of cells, corrected by the kernel of the finite bodies.

    Parameters
    ----------
    at : ContactGeometry
        Position of the contact on its groove.
    load : float
        Contact load [N].
    young : float
        Young's modulus [Pa].
    poisson : float
        Poisson's ratio.
    shape : tuple[int, int]
        Cells of the grid along and across the groove.
    sizes : Sizes
        Numerical settings of the finite bodies.

    Returns
    -------
    NormalContact
        Approach, semi-axes and peak pressure.
    """
    kernel = bodies.compliance_kernel_of_contact(at, load, young, poisson, sizes)
    patch = rolling_patch.solve_elastic_contact_on_grid(load, at.relative_radii, young, poisson, shape, kernel)
    areas = np.full(len(patch.cell_centres), float(patch.cell_size.prod()))
    semi, _, peak = fit_pressure_ellipsoid(patch.cell_centres, areas, patch.normal_forces)
    return NormalContact(patch.approach, semi, peak)


def solve_normal_contact_by_patches(
    at: bodies.ContactGeometry, load: float, young: float, poisson: float, cells: tuple[int, int]
) -> NormalContact:
    """Solve the normal contact of ball and groove as the static 3D reference does, by finite-element patches of both.

    Parameters
    ----------
    at : ContactGeometry
        Position of the contact on its groove.
    load : float
        Contact load [N].
    young : float
        Young's modulus [Pa].
    poisson : float
        Poisson's ratio.
    cells : tuple[int, int]
        Cells of the contact zone along and across the groove.

    Returns
    -------
    NormalContact
        Approach, semi-axes and peak pressure.

    Raises
    ------
    ValueError
        The track is straight.
    """
    zone = at.contact_zone(load, young, poisson, replace(Sizes(), cells=cells, growth=2.0, margin=1.2))
    groove, ball = bodies.mesh_contact_pieces(at, zone)
    arms = groove.patch_mesh.points[groove.patch_mesh.contact_nodes] - groove.ball_centre
    length = np.linalg.norm(arms, axis=1)
    normals = arms / length[:, None]
    C = contact_compliance_in_fine_submodel(groove.body_piece, groove.patch_mesh, normals, young, poisson)
    C = C + contact_compliance_in_fine_submodel(ball.body_piece, ball.patch_mesh, -normals, young, poisson)
    W = normalise_weight_rows(groove.patch_mesh.pressure_weights)
    gap, close = W @ (length - at.ball_radius), W @ (normals @ groove.contact_axes[2])
    (approach,), closed = solve_unilateral_contact(C, gap, close, np.array([load]))
    i = np.flatnonzero(closed[0])
    forces = np.linalg.solve(C[np.ix_(i, i)], approach * close[i] - gap[i])
    semi, _, peak = fit_pressure_ellipsoid((arms @ groove.contact_axes.T)[i, :2], groove.patch_mesh.areas[i], forces)
    return NormalContact(float(approach), semi, peak)


# --- Carter


def compare_with_carter(cells: int, share: float) -> tuple[Array, Array]:
    """Compare the computed rolling of two equal cylinders under a tangential force with Carter's closed-form solution.

    The creep is mu a/R (1 - sqrt(1 - Q/(mu P))), with the forces P (normal) and Q (tangential), the coefficient of friction
    mu, the half width a of the contact and the relative radius R; cells stick over a strip of half width
    a sqrt(1 - Q/(mu P)) at the leading edge. nu = 0.3; plane strain. Over this strip mu p - q has the shape of a
    semi-ellipse, with the normal and tangential tractions p and q. The half width of the strip, twice the standard
    deviation of a semi-ellipse, is computed from the standard deviation of the computed mu p - q.

    Parameters
    ----------
    cells : int
        Number of cells across the contact.
    share : float
        Ratio Q/(mu P) of the tangential force Q to the friction limit, the normal force P times the coefficient of friction
        mu.

    Returns
    -------
    computed : (2,) Array
        Q/(mu P) at Carter's creep, and half width of the stick zone over the half width a of the contact.
    exact : (2,) Array
        The same in closed form.

    References
    ----------
    Johnson, Contact Mechanics (1985), eq. (8.26).
    """
    shear, nu, radius, mu, load = 80e9, 0.3, 10e-3, 0.1, 2e5
    modulus = shear / (1.0 - nu)
    half = float(np.sqrt(4.0 * load * radius / (np.pi * modulus)))
    long = LONG * half
    size = np.array([2.1 * half / cells, long])
    index, at = rolling_patch.create_cell_grid((cells, 1), size)
    material = 2.0 * shear * (1.0 + nu), nu
    gap = at[:, 0] ** 2 / (2.0 * radius)
    forces, approach = rolling_patch.solve_normal_contact(index, size, gap, load * long, material)
    inside = forces > 0.0
    patch = GridContact(index[inside], at[inside], size, forces[inside], material, approach)
    rest = float(np.sqrt(1.0 - share))
    answer = solve_steady_rolling_for_creepages(patch, Creep(mu * half / radius * (1.0 - rest), 0.0, 0.0), mu)
    stick = 2.0 * spread_of_unused_friction(patch, mu * patch.normal_forces, answer.friction_solution.forces[0])[0]
    return np.array([-answer.friction_force[0] / (mu * load * long), stick / half]), np.array([share, rest])


# --- Cattaneo and Mindlin


def compare_with_mindlin(cells: int, share: float, finite_balls: Sizes | None = None) -> tuple[Array, Array]:
    """Compare a sphere pressed onto an equal one and pushed sideways with the solution of Cattaneo and Mindlin.

    The stick radius is a (1 - Q/(mu P))^(1/3), and the relative tangential displacement of the spheres (shift) is
    3 mu P/(16 a) sum (2 - nu)/G (1 - (1 - Q/(mu P))^(2/3)), with the forces P (normal) and Q (tangential), the coefficient
    of friction mu, the radius a of the contact, and a sum over both spheres of shear modulus G and Poisson's ratio nu. Here
    nu = 0, for which the solution is exact because no traction across the push is neglected. mu p - abs(q), with the normal
    and tangential tractions p and q, has the shape of half an ellipsoid over the stick circle, so that the stick radius is
    sqrt(5) times the standard deviation of mu p - abs(q) along an axis.

    Parameters
    ----------
    cells : int
        Cells across the contact.
    share : float
        Ratio Q/(mu P) of the tangential force Q to the friction limit, the normal force P times the coefficient of friction
        mu.
    finite_balls : Sizes | None, default None
        Numerical settings of finite balls, whose shift is that of half-spaces plus that of the bodies by Q; None:
        half-spaces.

    Returns
    -------
    computed : (2,) Array
        Q/(mu P) at the exact shift, and stick radius over the radius a of the contact.
    exact : (2,) Array
        The same in closed form.

    References
    ----------
    Johnson, Contact Mechanics (1985), eqs. (7.38) and (7.39).
    """
    shear, mu, load, radius = 80e9, 0.1, 100.0, 10e-3
    material, radii = (2.0 * shear, 0.0), (radius, radius)
    size = solve_hertz(load, *radii, *material).semi_x
    kernel = None if finite_balls is None else kernel_of_two_balls(2.0 * radius, size, *material, finite_balls)
    patch = rolling_patch.solve_elastic_contact_on_grid(load, radii, *material, (cells, cells), kernel)
    size = solve_hertz(load, *rolling_patch.equivalent_half_space_radii(load, radii, *material, kernel), *material).semi_x
    rest = 1.0 - share
    shift = 3.0 * mu * load / (16.0 * size) * 4.0 / shear * (1.0 - rest ** (2.0 / 3.0))
    if kernel is not None:
        along, spread = slice(0, 1), patch.normal_forces / load
        by_unit_force = kernel.displacements_by_unit_forces(patch.cell_centres, along, along)
        shift += share * mu * load * float(spread @ by_unit_force @ spread)
    slip = np.repeat([shift, 0.0], len(patch.cell_centres))
    _, solution = solve_friction_for_rigid_slip(patch, patch.tangential_compliance(), slip, mu)
    unused = spread_of_unused_friction(patch, mu * patch.normal_forces, solution.forces[0])
    stick = np.sqrt(2.5) * float(np.linalg.norm(unused))
    force = -solution.forces[0][: len(patch.cell_centres)].sum() / (mu * load)
    return np.array([force, stick / size]), np.array([share, rest ** (1.0 / 3.0)])


def kernel_of_two_balls(
    radius: float, semi: float, young: float, poisson: float, sizes: Sizes
) -> rolling_patch.ComplianceKernel:
    """Compute the contact compliance of two equal touching balls less that of two half-spaces (their kernel).

    ``radius``: radius of the balls [m]; ``semi``: radius of the circular contact [m]; ``sizes``: mesh settings of the
    balls.
    """
    zone = ContactZone((sizes.margin * semi,) * 2, sizes.cells, sizes.growth)
    arguments = radius, zone, (0.0, 0.0), young, poisson, sizes.degree
    ball: rolling_patch.ComplianceKernel = bodies.kept_or_computed((bodies.compliance_kernel_of_ball, arguments))
    return ball + bodies.kernel_from_groove_response(ball.M, zone, sizes.degree)


# --- balls that touch


def compare_ball_friction_with_point(
    scene: RollingBalls, result: RollingResult, contact_index: int, points: int = 60, finite_balls: Sizes | None = None
) -> tuple[float, float]:
    """Compare the friction of two balls distributed over their contact area with friction taken to act at one point.

    The whole contact slides, so that the tractions are mu p against the local sliding and do not depend on elasticity.

    Parameters
    ----------
    scene : RollingBalls
        The balls.
    result : RollingResult
        Steady rolling of the balls.
    contact_index : int
        Index of the ball-to-ball contact among those of the scene.
    points : int, default 60
        Number of quadrature points, or of the grid's cells, along each axis of the contact.
    finite_balls : Sizes | None, default None
        Numerical settings of finite balls, on a grid; None: Hertz's circle, by quadrature.

    Returns
    -------
    force : float
        Distributed friction force over the friction force at one point.
    loss : float
        Friction loss of the distributed force over the friction loss of the force at one point.
    """
    m, force = scene.ball_to_ball_contacts[contact_index], float(result.ball_to_ball_forces[contact_index])
    touch = force, (0.5 * scene.ball_radius,) * 2, scene.young, scene.poisson
    circle = solve_hertz(force, *touch[1], *touch[2:])
    if finite_balls is None:
        unit, weight = quadrature_of_unit_disk(points)
        local, sunk = unit * circle.semi_x, 0.0
        normal = circle.pressure(local[:, 0], local[:, 1]) * weight * circle.semi_x**2
    else:
        kernel = kernel_of_two_balls(scene.ball_radius, circle.semi_x, *touch[2:], finite_balls)
        patch = rolling_patch.solve_elastic_contact_on_grid(*touch, (points, points), kernel)
        local, normal, sunk = patch.cell_centres, patch.normal_forces, patch.depth_of_contact_centre
    slide = np.zeros((len(local), 2))
    halves = (m.first_ball, 1.0, m.motion_indices[:MOTIONS]), (m.second_ball, -1.0, m.motion_indices[MOTIONS:])
    for ball, sign, half in halves:
        axes = m.axes @ scene.balls[ball].axes.T
        at = sign * (scene.ball_radius - sunk) * axes[0] + local @ axes[1:]
        speeds = velocities_by_ball_motions(scene.track, scene.ball_radius, at) @ result.friction_solution.motions[half]
        slide += sign * speeds @ axes[1:].T
    pull = coulomb_friction_forces(scene.ball_friction_coefficient * normal, slide.T.ravel())
    bound = scene.ball_friction_coefficient * force
    point = bound * float(np.linalg.norm(m.closing_and_sliding_speeds(result.friction_solution.motions)[1:]))
    total = float(np.linalg.norm(pull.reshape(2, -1).sum(axis=1)))
    return total / bound, -float(pull @ slide.T.ravel()) / point


# --- finite elements of a half space


def compare_half_space_displacements(zone: ContactZone, size: float, young: float, poisson: float) -> tuple[Array, Array]:
    """Compare the computed mean displacements of a rectangle on a half-space under uniform tractions with a closed form.

    Parameters
    ----------
    zone : ContactZone
        Contact zone.
    size : float
        Size of the block of elements [m].
    young : float
        Young's modulus [Pa].
    poisson : float
        Poisson's ratio.

    Returns
    -------
    computed : (3,) Array
        Mean displacements along x, y and inward by unit forces in these directions, by finite elements [m/N].
    exact : (3,) Array
        The same displacements in closed form [m/N].
    """
    block = mesh_half_space(size, zone)
    forces = bodies.nodal_forces_of_tractions(block, zone, 0, (0.0, 0.0))
    computed = bodies.compliance_of_half_space_block(block, forces, young, poisson).diagonal()
    sides = 2.0 * np.array(zone.half_lengths)
    _, at = rolling_patch.create_cell_grid((MEANS, MEANS), sides / MEANS)
    moved = rolling_patch.displacement_by_rectangle(at[:, 0], at[:, 1], sides[0], sides[1], young, poisson)
    return computed, 0.5 * (moved.mean(axis=0).diagonal() / sides.prod())


# --- Kalker's linear theory


def create_sticking_elliptic_contact(ratio: float, poisson: float, shape: tuple[int, int]) -> GridContact:
    """Create an elliptic contact on a grid that sticks everywhere, for Kalker's linear theory.

    ``ratio``: semi-axis along over semi-axis across; ``shape``: numbers of cells along and across. The semi-axes are
    sqrt(ratio) and 1/sqrt(ratio) [m], the shear modulus is 1 Pa, and the normal forces are infinite, so that nothing slips.
    The cells are stretched so that their area equals the ellipse's, which corrects the contact's size for its staircase
    edge.
    """
    semi = np.array([np.sqrt(ratio), 1.0 / np.sqrt(ratio)])
    size = 2.0 * semi / np.array(shape)
    index, at = rolling_patch.create_cell_grid(shape, size)
    inside = ((at / semi) ** 2).sum(axis=1) < 1.0
    stretch = float(np.sqrt(np.pi / (np.count_nonzero(inside) * size.prod())))
    forces, material = np.full(np.count_nonzero(inside), np.inf), (2.0 * (1.0 + poisson), poisson)
    return GridContact(index[inside], stretch * at[inside], stretch * size, forces, material, 0.0)


def kalker_linear_coefficients(ratio: float, poisson: float, shape: tuple[int, int]) -> Array:
    """Compute Kalker's creepage coefficients: forces and moment per creepage of a contact that sticks everywhere.

    Only the cells with y > 0 are solved: longitudinal creep causes tractions along x that are even in y and tractions
    across that are odd, lateral creep and spin the opposite.

    Parameters
    ----------
    ratio : float
        Semi-axis along over semi-axis across.
    poisson : float
        Poisson's ratio.
    shape : tuple[int, int]
        Cells along and across.

    Returns
    -------
    (4,) Array
        Kalker's coefficients C11, C22, C23, C33.

    Raises
    ------
    ValueError
        The number of cells across is odd.
    """
    if shape[1] % 2:
        raise ValueError(f"Kalker's coefficients need an even number of cells across the contact, got {shape[1]}")
    patch = create_sticking_elliptic_contact(ratio, poisson, shape)
    count = len(patch.cell_centres)
    half = np.flatnonzero(patch.cell_centres[:, 1] > 0.0)
    image = np.lexsort((-patch.cell_indices[:, 1], patch.cell_indices[:, 0]))[half]
    units = np.stack([Creep(*row).rigid_slip(patch.cell_centres) for row in np.eye(3)], axis=1)
    rows = np.concatenate([half, count + half])
    mirrored = np.concatenate([image, count + image])
    near, far = (patch.elastic_slip_per_rolling_length[np.ix_(rows, columns)] for columns in (rows, mirrored))
    F = np.zeros((3, 3))
    for kind, sense in ((slice(0, 1), 1.0), (slice(1, 3), -1.0)):
        slip = units[rows, kind]
        F[kind, kind] = 2.0 * slip.T @ np.linalg.solve(near + far * np.repeat([sense, -sense], half.size), slip)
    return np.array([F[0, 0], F[1, 1], F[1, 2], F[2, 2]])


# --- full slip


def friction_at_full_slip_by_quadrature(
    load: float, radii: tuple[float, float], young: float, poisson: float, creep: Creep, mu: float, points: int = 400
) -> tuple[Array, float]:
    """Compute the friction force and moment of a Hertz contact that slips over the whole ellipse, without elasticity.

    Parameters
    ----------
    load : float
        Normal load [N].
    radii : tuple[float, float]
        Relative radii along and across [m].
    young : float
        Young's modulus [Pa].
    poisson : float
        Poisson's ratio.
    creep : Creep
        The creepages.
    mu : float
        Coefficient of friction.
    points : int, default 400
        Number of quadrature points along each axis of the ellipse.

    Returns
    -------
    force : (2,) Array
        Force on body 1 along and across the rolling direction [N].
    moment : float
        Moment on body 1 about the contact normal [N m].
    """
    ellipse = solve_hertz(load, *radii, young, poisson)
    unit, weight = quadrature_of_unit_disk(points)
    at = unit * np.array([ellipse.semi_x, ellipse.semi_y])
    normal = ellipse.pressure(at[:, 0], at[:, 1]) * weight * ellipse.semi_x * ellipse.semi_y
    return _resultant_force_and_moment(at, coulomb_friction_forces(mu * normal, creep.rigid_slip(at)))


def friction_at_full_slip_by_cells(patch: GridContact, creep: Creep, mu: float) -> tuple[Array, float]:
    """Compute the friction force and moment of a contact that slips in all cells, by 20 x 20 points in each grid cell.

    The points resolve the rotation of the slip about the point without slip; only the error of the grid's staircase edge
    remains.

    Parameters
    ----------
    patch : GridContact
        Normal contact on its grid.
    creep : Creep
        The creepages.
    mu : float
        Coefficient of friction.

    Returns
    -------
    force : (2,) Array
        Force on body 1 along and across the rolling direction [N].
    moment : float
        Moment on body 1 about the contact normal [N m].
    """
    points = 20
    unit = (np.arange(points) + 0.5) / points - 0.5
    inside = np.stack(np.meshgrid(unit, unit, indexing="ij"), axis=-1).reshape(-1, 2) * patch.cell_size
    at = (patch.cell_centres[:, None] + inside).reshape(-1, 2)
    limits = np.repeat(mu * patch.normal_forces / points**2, points**2)
    return _resultant_force_and_moment(at, coulomb_friction_forces(limits, creep.rigid_slip(at)))


def _resultant_force_and_moment(at: Array, forces: Array) -> tuple[Array, float]:
    """Compute the resultant ``(2,)`` [N] of tangential forces, and their moment about the normal [N m].

    ``at``: points (n, 2) [m]; ``forces``: forces at them, all along x and then all along y (2 n,) [N].
    """
    x, y = forces.reshape(2, -1)
    return np.array([x.sum(), y.sum()]), float(at[:, 0] @ y - at[:, 1] @ x)
