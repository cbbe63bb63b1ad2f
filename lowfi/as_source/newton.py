"""Second, independent solver of a ball screw's statics: the equations of Lin's thesis, with its misprints corrected.

The unknowns are ball centres, contact angles and all nodal motions of the screw (Lin 2.25, 2.26, Appendix E). The
equilibrium equations are solved by Newton's method without line search, with an explicit dense Jacobian. The results check
those of the solver that minimises energy (`lowfi.statics.static`), and show where Lin's iteration fails.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from time import perf_counter
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.hertz import contact_approach, contact_force, contact_stiffness_at_approach
from rollbench.lowfi.statics.beam import nodal_forces
from rollbench.lowfi.statics.contact_law import SIGNS
from rollbench.lowfi.statics.contacts import scene_with_error_free_hertz
from rollbench.lowfi.statics.held import find_unresisted_motions
from rollbench.lowfi.statics.problem import ContactState, Problem, SolvedState, build_problem
from rollbench.lowfi.statics.result import SolverReport, StaticResult, Status
from rollbench.lowfi.statics.selection import all_flank_motions_by_screw
from rollbench.lowfi.statics.shape import beam_shape_functions
from rollbench.lowfi.statics.summary import assemble_result, failed_result, model_assumptions
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout, lead_angle
from rollbench.meshes.parts import Scene
from rollbench.meshes.surface import groove_radius_with_slopes

Kinematics = Literal["arc", "source"]

Start = Literal["nominal", "guess", "load steps"]

#: Number of iterations after which Newton's method gives up.
MOST = 60
#: Relative residual at which Newton's method ends.
TOLERANCE = 1e-12


@dataclass(frozen=True)
class LinEquationsSolution:
    """Solution of Lin's equilibrium equations for N balls, n nodes; on failure, the state after the last Newton step."""

    #: ``"converged"``, or the reason why Newton's method failed.
    status: str
    #: Normal forces of the balls on the four groove flanks SL, SR, NL, NR (screw or nut, left or right) ``(N, 4)`` [N].
    contact_loads: Array
    #: Contact angles of the balls on the four groove flanks SL, SR, NL, NR (screw or nut, left or right) ``(N, 4)`` [rad].
    contact_angles: Array
    #: Displacements of the ball centres from their nominal positions, radial and binormal ``(N, 2)`` [m].
    ball_displacements: Array
    #: Displacements and rotations of the nodes of the screw's beam ``(n, 6)`` [m, rad].
    node_motions: Array
    #: Reaction forces and moments of the supports at the n beam nodes ``(n, 6)`` [N, N m].
    support_reactions: Array
    #: Number of Newton steps of the solution.
    iterations: int
    #: Relative residual, the larger of two ratios: largest unbalanced force over the largest contact force or nodal load;
    #: largest residual of a contact condition (a length) over the groove radius.
    residual: float
    #: Time that the solution took [s].
    seconds: float
    #: Number of unknowns of the equations.
    unknown_count: int

    @property
    def converged(self) -> bool:
        """Whether Newton's method converged, so that the loads may be used."""
        return self.status == "converged"


@dataclass
class LinEquations:
    """Constants of Lin's equilibrium equations of a ball screw with N balls, and functions for the flanks' motion."""

    #: Arrays of the scene: geometry, loads, supports and the beam of the screw.
    problem: Problem
    #: Lever arms of the contact forces about the nodes of the screw's beam: ``"source"``: they depend on the contact angle,
    #: as in Lin's thesis; ``"arc"``: they are constant.
    kinematics: Kinematics
    #: Stiffness matrix of the screw's beam of n nodes ``(6 n, 6 n)``.
    K: Array
    #: Indices of the unknowns that are solved for, among all 6 N + 6 n (ball centres, contact angles, nodal motions);
    #: supports prescribe the others.
    free_unknowns: NDArray[np.int64]
    #: Radial and binormal unit vector of the groove's cross-section at each ball ``(N, 2, 3)``.
    section_axes: Array

    def flank_motion_matrices(self, side: int, gamma: Array) -> tuple[NDArray[np.int64], Array, Array, Array]:
        """Return the matrices that give the motion of a flank at its contacts from the motions of the screw's nodes.

        Parameters
        ----------
        side
            Number of the screw's flank, 0 or 1.
        gamma
            Contact angles ``(N,)`` [rad].

        Returns
        -------
        tuple[NDArray[np.int64], Array, Array, Array]
            Index of the first of the m nodal unknowns that move a contact ``(N,)``; matrices M ``(N, 2, m)`` of Lin
            2.17-2.21, and their first and second derivative by the contact angle (eq. E.13 of Lin's thesis).
        """
        p = self.problem
        if self.kinematics == "arc":
            zero = np.zeros_like(p.B[:, side])
            return 6 * p.first_nodes[:, side], p.B[:, side], zero, zero
        layout = p.layout
        a, a1, a2 = self.contact_point_on_flank(side, gamma)
        x = layout.centre + a[:, :1] * layout.radial + a[:, 1:] * layout.binormal
        x1 = a1[:, :1] * layout.radial + a1[:, 1:] * layout.binormal
        x2 = a2[:, :1] * layout.radial + a2[:, 1:] * layout.binormal
        j = np.clip(np.searchsorted(p.nodes, x[:, 2], side="right") - 1, 0, p.nodes.size - 2)
        length = np.diff(p.nodes)[j]
        xi = (x[:, 2] - p.nodes[j]) / length
        n0, n1, n2 = (beam_shape_functions(xi, length, p.section, order) for order in range(3))
        flat = np.array([1.0, 1.0, 0.0])

        def lever_arm_products(r: Array) -> Array:
            """Return the cross products of vectors r with the radial and the binormal axis of the groove at each ball.

            ``r``: contact points, or their derivatives by the contact angle; the axial component is left out.
            """
            return np.cross((r * flat)[:, None, :], self.section_axes)

        s1, s2 = (x1[:, 2] / length)[:, None, None], (x2[:, 2] / length)[:, None, None]
        lever, lever1, lever2 = map(lever_arm_products, (x, x1, x2))
        # matrices at the contact point x if it depended on the angle only by the shape functions n0, n1, n2 of its position
        at0, at1, at2 = (self.section_axes @ n[:, :3] + lever @ n[:, 3:] for n in (n0, n1, n2))
        m1 = s1 * at1 + lever1 @ n0[:, 3:]
        m2 = s1**2 * at2 + s2 * at1 + 2.0 * s1 * (lever1 @ n1[:, 3:]) + lever2 @ n0[:, 3:]
        return 6 * j, at0, m1, m2

    def contact_point_on_flank(self, side: int, gamma: Array) -> tuple[Array, Array, Array]:
        """Return the contact point A(gamma) on a groove flank at given contact angles, and its first two angle derivatives.

        ``side``: number of the flank, 0 or 1 on the screw, 2 or 3 on the nut; ``gamma``: contact angles of N balls (N,)
        [rad]. Each result is (N, 2): radial and binormal coordinate [m], from the nominal ball centre (Lin 2.3 and 2.27).
        """
        drawn = self.problem.drawn
        r, r1, r2 = groove_radius_with_slopes(gamma, drawn.groove_radii[side], drawn.profile_coefficients[side])
        c, s = np.cos(gamma), np.sin(gamma)
        sx, sz = SIGNS[side]
        a = np.stack([sx * r * c, sz * r * s], -1) + drawn.groove_centres[:, side]
        a1 = np.stack([sx * (r1 * c - r * s), sz * (r1 * s + r * c)], -1)
        a2 = np.stack([sx * ((r2 - r) * c - 2.0 * r1 * s), sz * ((r2 - r) * s + 2.0 * r1 * c)], -1)
        return a, a1, a2


def equations_and_jacobian(system: LinEquations, unknowns: Array, load: Array) -> tuple[Array, Array, Array]:
    """Return the residuals of Lin's equations for balls and screw, their Jacobian, and the contact loads.

    The equations are the contact conditions and the equilibrium of balls and screw, Phi(x) = 0 in equation 2.25 of Lin's
    thesis; appendix E has the Jacobian.

    Parameters
    ----------
    system
        Constants of the equations.
    unknowns
        Unknowns: radial and binormal positions of the N ball centres [m], then the four contact angles of each ball [rad],
        then the six motions of each of the n nodes [m, rad].
    load
        Loads on the nodes ``(6 n,)`` [N, N m].

    Returns
    -------
    tuple
        Residuals ``(6 N + 6 n,)``, in the order of the unknowns; Jacobian; contact loads ``(N, 4)`` [N].
    """
    problem = system.problem
    count = problem.C.shape[0]
    p = unknowns[: 2 * count].reshape(count, 2)
    gamma = unknowns[2 * count : 6 * count].reshape(count, 4)
    u = unknowns[6 * count :]
    phi = np.zeros(unknowns.size)
    jac = np.zeros((unknowns.size, unknowns.size))
    balls = np.arange(count)
    rows_p, rows_g, base = 2 * balls[:, None] + np.arange(2), 2 * count + 4 * balls, 6 * count
    phi[base:] = system.K @ u - load
    jac[base:, base:] = system.K
    forces = np.zeros((count, 4))
    eye = np.eye(2)
    for side in range(4):
        # tangent t and dt/dgamma of the flank at its contact points a; matrices from nodal motions to its motion
        a, t, t1 = system.contact_point_on_flank(side, gamma[:, side])
        dof, m0, m1 = np.zeros(count, dtype=np.int64), np.zeros((count, 2, 0)), np.zeros((count, 2, 0))
        if side < 2:
            dof, m0, m1, m2 = system.flank_motion_matrices(side, gamma[:, side])
            u_local = u[dof[:, None] + np.arange(m0.shape[2])[None, :]]
            a = a + np.einsum("nak,nk->na", m0, u_local)
            t = t + np.einsum("nak,nk->na", m1, u_local)
            t1 = t1 + np.einsum("nak,nk->na", m2, u_local)
        d = p - a
        dist = np.linalg.norm(d, axis=1)
        n = d / dist[:, None]
        c, delta = problem.C[:, side], problem.drawn.ball_radii - dist
        force, stiff = contact_force(delta, c), contact_stiffness_at_approach(delta, c)
        g, pull = rows_g + side, force[:, None] * n
        forces[:, side] = force
        phi[g] = np.einsum("na,na->n", n, t)
        np.add.at(phi, rows_p, pull)
        columns = base + dof[:, None] + np.arange(m0.shape[2])[None, :]
        np.add.at(phi, columns, np.einsum("nak,na->nk", m0, pull))
        project = (eye - n[:, :, None] * n[:, None, :]) / dist[:, None, None]
        pt = np.einsum("nab,nb->na", project, t)
        fp = force[:, None, None] * project - stiff[:, None, None] * n[:, :, None] * n[:, None, :]
        fg = -force[:, None] * pt + (stiff * phi[g])[:, None] * n
        jac[g[:, None], rows_p] = pt
        jac[g, g] = np.einsum("na,na->n", n, t1) - np.einsum("na,na->n", t, pt)
        np.add.at(jac, (rows_p[:, :, None], rows_p[:, None, :]), fp)
        jac[rows_p, g[:, None]] = fg
        if side < 2:
            jac[g[:, None], columns] = np.einsum("nak,na->nk", m1, n) - np.einsum("nak,na->nk", m0, pt)
            fu = -fp @ m0
            np.add.at(jac, (rows_p[:, :, None], columns[:, None, :]), fu)
            np.add.at(jac, (columns[:, :, None], rows_p[:, None, :]), np.swapaxes(m0, 1, 2) @ fp)
            by_gamma = np.einsum("nak,na->nk", m1, pull) + np.einsum("nak,na->nk", m0, fg)
            np.add.at(jac, (columns, np.broadcast_to(g[:, None], columns.shape)), by_gamma)
            np.add.at(jac, (columns[:, :, None], columns[:, None, :]), np.swapaxes(m0, 1, 2) @ fu)
    return phi, jac, forces


def newton_start_values(system: LinEquations, start: Start, fraction: float) -> Array:
    """Return the unknowns ``(6 N + 6 n,)`` from which Newton's method starts: the nominal state, or a designer's guess.

    The guess (if ``start`` is not "nominal") displaces the screw along its axis as if the axial load times
    ``fraction`` were divided equally among all balls. The order of the unknowns is that of `equations_and_jacobian`.
    """
    problem = system.problem
    scene = problem.scene
    count = problem.C.shape[0]
    p, gamma = np.zeros((count, 2)), np.full((count, 4), scene.track.contact_angle)
    u = problem.prescribed.copy()
    if start != "nominal":
        axial = fraction * float(problem.load[:, 2].sum())
        cosine = np.cos(lead_angle(scene.track))
        rise = np.sin(scene.track.contact_angle) * cosine
        share = abs(axial) / (count * rise)
        pair = problem.C[:, 0] + problem.C[:, 3]
        shift = np.sign(axial) * float(contact_approach(share, pair.mean())) / rise
        u[:, 2] += np.where(problem.fixed[:, 2], 0.0, shift)
        p[:, 1] = 0.5 * shift * cosine
    return np.concatenate([p.ravel(), gamma.ravel(), u.ravel()])


def _problem_with_all_flanks(scene: Scene, everything: bool, member: int) -> Problem:
    """Return the arrays of a scene, with all four contacts of each ball, as Lin's equations need them."""
    layout = ball_layout(scene)
    drawn = draw_geometry_with_errors(scene, layout, member)
    return build_problem(scene, drawn, layout, np.ones(4, dtype=bool), everything=everything)


def solve_by_lin_equations(
    scene: Scene,
    *,
    kinematics: Kinematics = "source",
    start_values: Start = "guess",
    everything: bool = False,
    member: int = 0,
) -> LinEquationsSolution:
    """Solve a scene by Lin's equations and Newton's method without line search (eq. 2.26 of Lin's thesis).

    Parameters
    ----------
    scene
        The scene; its screw must be a beam.
    kinematics
        ``"source"``: lever arm and axial position of a contact depend on its contact angle (Lin 2.18-2.21); ``"arc"``:
        flanks are rigid arcs as in the solver that minimises energy, with which the result then agrees to round-off.
    start_values
        Starting values: ``"nominal"``, the undeformed state; ``"guess"``, the screw displaced by the axial load
        (`newton_start_values`); ``"load steps"``, ten load steps from that guess.
    everything
        Whether to model also the ends of the shaft that carry no load.
    member
        Number of the specimen, for a scene with random manufacturing errors.

    Raises
    ------
    ValueError
        The screw of the scene is rigid.
    """
    begin = perf_counter()
    if scene.ingredients.screw == "rigid":
        raise ValueError("Lin's equations need a screw that is modelled as a beam, got a rigid screw")
    problem = _problem_with_all_flanks(scene, everything, member)
    axes = np.stack([problem.layout.radial, problem.layout.binormal], axis=1)
    free_u = np.flatnonzero(~problem.fixed.ravel())
    count = problem.C.shape[0]
    free = np.concatenate([np.arange(6 * count), 6 * count + free_u])
    size, s = problem.fixed.size, problem.section
    sections = np.tile([[s.EA], [s.EI], [s.GJ], [s.kGA]], problem.nodes.size - 1)
    K = nodal_forces(np.diff(problem.nodes), sections, np.eye(size)).reshape(size, size)
    system = LinEquations(problem, kinematics, K, free, axes)
    steps = [1.0] if start_values != "load steps" else list(np.linspace(0.1, 1.0, 10))
    x = newton_start_values(system, start_values, steps[0])
    total, residual, status = 0, np.inf, "converged"
    with np.errstate(all="ignore"):
        for fraction in steps:
            load = fraction * problem.load.ravel()
            x, iterations, residual, status = solve_equations_by_newton(system, x, load)
            total += iterations
            if status != "converged":
                break
        phi, _, forces = equations_and_jacobian(system, x, problem.load.ravel())
    return LinEquationsSolution(
        status=status,
        contact_loads=forces,
        contact_angles=x[2 * count : 6 * count].reshape(count, 4),
        ball_displacements=x[: 2 * count].reshape(count, 2),
        node_motions=x[6 * count :].reshape(-1, 6),
        support_reactions=np.where(problem.fixed, phi[6 * count :].reshape(-1, 6), 0.0),
        iterations=total,
        residual=residual,
        seconds=perf_counter() - begin,
        unknown_count=free.size,
    )


def solve_lin_equations_as_static_result(scene: Scene, *, everything: bool = False, member: int = 0) -> StaticResult:
    """Solve a scene by Lin's equations from a designer's guess, and return a `StaticResult` as every static model does.

    Hertz constants are those of parts without manufacturing errors, as in Lin's thesis, even if the scene asks for radii
    with errors.

    Parameters
    ----------
    scene
        Scene with one nut.
    everything
        Whether to model also the ends of the shaft that carry no load.
    member
        Number of the specimen of a scene with random manufacturing errors.
    """
    scene = scene_with_error_free_hertz(scene)
    problem = _problem_with_all_flanks(scene, everything, member)
    mechanism = find_unresisted_motions(problem)
    if mechanism.is_driven_by_loads:
        return failed_result(problem, "source", Status("not held", mechanism.description), 0.0)
    solution = solve_by_lin_equations(scene, everything=everything, member=member)
    status = Status("converged") if solution.converged else Status("not converged", f"Lin's iteration: {solution.status}")
    if not np.all(np.isfinite(solution.contact_loads)) or not np.all(np.isfinite(solution.node_motions)):
        return failed_result(problem, "source", status, solution.seconds)
    angle = solution.contact_angles
    contacts = ContactState(
        problem,
        force=solution.contact_loads,
        normal=SIGNS * np.stack([np.cos(angle), np.sin(angle)], axis=-1),
        tangential=np.full(angle.shape, np.nan),  # not needed for the result
        ball_centres=solution.ball_displacements,
        flank_motions=all_flank_motions_by_screw(problem, solution.node_motions),
    )
    solved = SolvedState(contacts, solution.node_motions, solution.support_reactions, 0.0)
    report = SolverReport(
        solution.iterations,
        solution.iterations + 1,
        solution.residual,
        solution.seconds,
        solution.unknown_count,
        problem.nodes.size - 1,
        "equilibrium equations of Lin's thesis",
    )
    left_out = ("nothing: all four flanks are built",)
    return assemble_result(solved, "source", status, report, left_out, model_assumptions(scene), has_own_lever_arms=True)


def _relative_residual(system: LinEquations, residuals: Array, forces: Array, load: Array) -> float:
    """Return the relative residual of Lin's equilibrium equations, given their residuals ``residuals``.

    It is the larger of two ratios: the largest unbalanced force over the largest of the contact ``forces`` and of the
    ``load`` on the nodes; and the largest contact condition (scalar product of a contact's normal and tangent) over the
    groove radius. Moments are divided by the pitch radius. ``system``: constants of the equations.
    """
    count = forces.shape[0]
    arm = system.problem.scene.track.pitch_radius
    weights = np.tile([1.0, 1.0, 1.0, 1.0 / arm, 1.0 / arm, 1.0 / arm], system.problem.nodes.size)
    screw = (residuals[6 * count :] * weights)[system.free_unknowns[6 * count :] - 6 * count]
    scale = max(float(np.abs(load * weights).max(initial=0.0)), float(forces.max(initial=0.0)))
    if not scale > 0.0:
        return float("inf")
    unbalanced = max(float(np.abs(residuals[: 2 * count]).max()), float(np.abs(screw).max(initial=0.0)))
    skew = float(np.abs(residuals[2 * count : 6 * count]).max()) / float(system.problem.drawn.groove_radii.max())
    return max(unbalanced / scale, skew)


def solve_equations_by_newton(system: LinEquations, unknowns: Array, load: Array) -> tuple[Array, int, float, str]:
    """Solve Lin's equilibrium equations by Newton's method without line search (equation 2.26 of Lin's thesis).

    ``system``: constants of the equations; ``unknowns``: unknowns to start from, in the order of `equations_and_jacobian`;
    ``load``: loads on the nodes ``(6 n,)`` [N, N m].

    Returns
    -------
    tuple
        Unknowns; number of iterations; relative residual; ``"converged"`` or the reason of the failure.
    """
    best, stalled = np.inf, 0
    residual = np.inf
    for iteration in range(MOST + 1):
        phi, jac, forces = equations_and_jacobian(system, unknowns, load)
        residual = _relative_residual(system, phi, forces, load) if np.all(np.isfinite(phi)) else np.inf
        if residual <= TOLERANCE:
            return unknowns, iteration, residual, "converged"
        stalled = stalled + 1 if residual >= 0.5 * best else 0
        best = min(best, residual)
        if stalled >= 4 and residual < 1e-9:
            return unknowns, iteration, residual, "converged" if residual <= 1e-10 else f"stalled at {residual:.1e}"
        if not np.all(np.isfinite(phi)):
            return unknowns, iteration, residual, "diverged: the iterate is not finite"
        free = system.free_unknowns
        small = jac[np.ix_(free, free)]
        scale, step = np.abs(small).max(axis=1), np.full(free.size, np.inf)
        if np.all(np.isfinite(small)) and np.all(scale > 0.0):
            with suppress(np.linalg.LinAlgError):
                step = np.linalg.solve(small / scale[:, None], -phi[free] / scale)
        if not np.all(np.isfinite(step)) or float(np.abs(step).max()) > 1e6:
            return unknowns, iteration, residual, f"singular Jacobian at iteration {iteration + 1}"
        unknowns = unknowns.copy()
        unknowns[free] += step
    return unknowns, MOST, residual, f"not converged after {MOST} iterations (residual {residual:.1e})"


def solve_lin_equations_with_fallback(scene: Scene, kinematics: Literal["arc", "source"]) -> LinEquationsSolution:
    """Solve a scene by Lin's equations, starting from a designer's guess or, if that fails, in ten load steps.

    Parameters
    ----------
    scene
        Scene with one nut.
    kinematics
        Lever arms of the contacts: constant (``"arc"``), or dependent on the contact angle as in Lin's thesis
        (``"source"``); see `solve_by_lin_equations`.
    """
    solution = solve_by_lin_equations(scene, kinematics=kinematics, start_values="guess")
    if solution.converged:
        return solution
    return solve_by_lin_equations(scene, kinematics=kinematics, start_values="load steps")
