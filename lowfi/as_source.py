"""Lin's formulation (2.25, 2.26, Appendix E) with its misprints corrected: a second, independent solver.

Unknowns are ball centres, contact angles and all nodal motions of the screw; plain Newton on the equilibrium equations
with the explicit Jacobian, dense. It checks the energy solver and shows where the source's iteration fails.
"""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.hertz import contact_approach, contact_force, contact_slope
from rollbench.lowfi.statics.contacts import error_free
from rollbench.lowfi.statics.held import free_motions
from rollbench.lowfi.statics.problem import SIGNS, Problem, SolvedState, build
from rollbench.lowfi.statics.result import SolverReport, StaticResult, Status
from rollbench.lowfi.statics.selection import shifts_of_beam
from rollbench.lowfi.statics.shape import shape_polynomials
from rollbench.lowfi.statics.summary import assemble_result, failed_result, model_assumptions
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import specimen
from rollbench.meshes.helix import ball_layout, lead_angle
from rollbench.meshes.parts import Scene
from rollbench.meshes.section import BeamSection
from rollbench.meshes.surface import groove_profile

Kinematics = Literal["arc", "source"]

Start = Literal["nominal", "guess", "load steps"]

#: Iterations after which Newton gives up.
MOST = 60


@dataclass(frozen=True)
class SourceSolution:
    """Outcome of Lin's Newton iteration for N balls and n nodes."""

    #: ``"converged"``, or why not.
    status: str
    #: Contact forces ``(N, 4)`` [N].
    load: Array
    #: ``(N, 4)`` [rad].
    contact_angle: Array
    #: Shifts of the balls ``(N, 2)`` [m].
    centre: Array
    #: Motion of the nodes ``(n, 6)`` [m, rad].
    motion: Array
    #: Reactions of the supports ``(n, 6)`` [N, N m].
    reactions: Array
    #: Newton steps.
    iterations: int
    #: Relative residual.
    residual: float
    #: Time [s].
    seconds: float
    #: Number of unknowns.
    unknowns: int

    @property
    def converged(self) -> bool:
        """Whether the loads may be used."""
        return self.status == "converged"


def element_stiffness(length: float, s: BeamSection) -> Array:
    """Return the stiffness of a Timoshenko element ``(12, 12)``.

    Parameters
    ----------
    length
        [m].
    s
        Section.

    References
    ----------
    Przemieniecki (1968); corrects Lin (2019), D.1 and D.2.
    """
    phi = 12.0 * s.EI / (s.kGA * length**2)
    c = s.EI / (length**3 * (1.0 + phi))
    k = np.zeros((12, 12))
    for u, r, sign in ((0, 4, 1.0), (1, 3, -1.0)):
        i = [u, r, u + 6, r + 6]
        k[np.ix_(i, i)] = c * np.array(
            [
                [12.0, sign * 6.0 * length, -12.0, sign * 6.0 * length],
                [sign * 6.0 * length, (4.0 + phi) * length**2, -sign * 6.0 * length, (2.0 - phi) * length**2],
                [-12.0, -sign * 6.0 * length, 12.0, -sign * 6.0 * length],
                [sign * 6.0 * length, (2.0 - phi) * length**2, -sign * 6.0 * length, (4.0 + phi) * length**2],
            ]
        )
    for u, value in ((2, s.EA / length), (5, s.GJ / length)):
        k[np.ix_([u, u + 6], [u, u + 6])] = value * np.array([[1.0, -1.0], [-1.0, 1.0]])
    return k


def beam_matrix(problem: Problem) -> Array:
    """Return the dense stiffness of the screw ``(6 n, 6 n)``."""
    n = problem.nodes.size
    k = np.zeros((6 * n, 6 * n))
    for e, length in enumerate(np.diff(problem.nodes)):
        k[6 * e : 6 * e + 12, 6 * e : 6 * e + 12] += element_stiffness(float(length), problem.section)
    return k


@dataclass
class System:
    """Scene as the equations need it."""

    #: Arrays of the scene.
    problem: Problem
    #: Whether lever arms follow the contact angle.
    kinematics: Kinematics
    #: Stiffness of the screw ``(6 n, 6 n)``.
    K: Array
    #: Indices of the free unknowns.
    free: NDArray[np.int64]
    #: Radial and binormal axis of each ball's section ``(N, 2, 3)``.
    axes: Array

    def motion_of_flank(self, side: int, gamma: Array) -> tuple[NDArray[np.int64], Array, Array, Array]:
        """Return first freedom of each flank's nodes, and M with two derivatives ``(N, 2, m)`` (Lin 2.17-2.21, E.13)."""
        p = self.problem
        if self.kinematics == "arc":
            zero = np.zeros_like(p.B[:, side])
            return 6 * p.node[:, side], p.B[:, side], zero, zero
        layout = p.layout
        a, a1, a2 = self.flank(side, gamma)
        x = layout.centre + a[:, :1] * layout.radial + a[:, 1:] * layout.binormal
        x1 = a1[:, :1] * layout.radial + a1[:, 1:] * layout.binormal
        x2 = a2[:, :1] * layout.radial + a2[:, 1:] * layout.binormal
        j = np.clip(np.searchsorted(p.nodes, x[:, 2], side="right") - 1, 0, p.nodes.size - 2)
        length = np.diff(p.nodes)[j]
        xi = (x[:, 2] - p.nodes[j]) / length
        n0, n1, n2 = (shape_polynomials(xi, length, p.section, order) for order in range(3))
        flat = np.array([1.0, 1.0, 0.0])

        def arm(r: Array) -> Array:
            return np.cross((r * flat)[:, None, :], self.axes)

        def motion(n: Array, lever: Array | None) -> Array:
            if lever is None:
                return self.axes @ n[:, :3]
            return self.axes @ n[:, :3] + lever @ n[:, 3:]

        s1, s2 = (x1[:, 2] / length)[:, None, None], (x2[:, 2] / length)[:, None, None]
        m0 = motion(n0, arm(x))
        m1 = s1 * motion(n1, arm(x)) + arm(x1) @ n0[:, 3:]
        m2 = s1**2 * motion(n2, arm(x)) + s2 * motion(n1, arm(x)) + 2.0 * s1 * (arm(x1) @ n1[:, 3:]) + arm(x2) @ n0[:, 3:]
        return 6 * j, m0, m1, m2

    def flank(self, side: int, gamma: Array) -> tuple[Array, Array, Array]:
        """Return the flank's profile A(gamma) from the nominal ball centre and its derivatives, ``(N, 2)`` each.

        Lin 2.3 and 2.27.
        """
        drawn = self.problem.drawn
        r, r1, r2 = groove_profile(gamma, drawn.radius[side], drawn.profile[side])
        c, s = np.cos(gamma), np.sin(gamma)
        sx, sz = SIGNS[side]
        a = np.stack([sx * r * c, sz * r * s], -1) + drawn.centre[:, side]
        a1 = np.stack([sx * (r1 * c - r * s), sz * (r1 * s + r * c)], -1)
        a2 = np.stack([sx * ((r2 - r) * c - 2.0 * r1 * s), sz * ((r2 - r) * s + 2.0 * r1 * c)], -1)
        return a, a1, a2


def _contact_terms(
    system: System, p: Array, gamma: Array, u: Array, side: int
) -> tuple[Array, Array, Array, Array, Array, Array, NDArray[np.int64], Array, Array]:
    """Return normal n, tangent t, dt/dgamma, distance, force, dF/d delta and motion matrices of one flank's contacts."""
    problem = system.problem
    a, t, t1 = system.flank(side, gamma)
    count = p.shape[0]
    if side < 2:
        dof, m0, m1, m2 = system.motion_of_flank(side, gamma)
        u_local = u[dof[:, None] + np.arange(m0.shape[2])[None, :]]
        a = a + np.einsum("nak,nk->na", m0, u_local)
        t = t + np.einsum("nak,nk->na", m1, u_local)
        t1 = t1 + np.einsum("nak,nk->na", m2, u_local)
    else:
        dof, m0, m1 = np.zeros(count, dtype=np.int64), np.zeros((count, 2, 0)), np.zeros((count, 2, 0))
    d = p - a
    dist = np.linalg.norm(d, axis=1)
    n = d / dist[:, None]
    c, delta = problem.C[:, side], problem.drawn.ball_radius - dist
    return n, t, t1, dist, contact_force(delta, c), contact_slope(delta, c), dof, m0, m1


def equations_and_jacobian(
    system: System, x: Array, load: Array, *, jacobian: bool = True
) -> tuple[Array, Array | None, Array]:
    """Return Phi(x) of Lin 2.25 (contact conditions, balls, screw), its Jacobian (Appendix E), and the contact loads.

    Parameters
    ----------
    system
        The scene.
    x
        Ball centres, contact angles and nodal motions.
    load
        Loads on the nodes ``(6 n,)`` [N, N m].
    jacobian
        Whether to compute the Jacobian; None in its place otherwise.
    """
    problem = system.problem
    count = problem.C.shape[0]
    p, gamma, u = x[: 2 * count].reshape(count, 2), x[2 * count : 6 * count].reshape(count, 4), x[6 * count :]
    phi = np.zeros(x.size)
    jac = np.zeros((x.size, x.size)) if jacobian else None
    balls = np.arange(count)
    rows_p, rows_g, base = 2 * balls[:, None] + np.arange(2), 2 * count + 4 * balls, 6 * count
    phi[base:] = system.K @ u - load
    if jac is not None:
        jac[base:, base:] = system.K
    forces = np.zeros((count, 4))
    eye = np.eye(2)
    for side in range(4):
        n, t, t1, dist, force, stiff, dof, m0, m1 = _contact_terms(system, p, gamma[:, side], u, side)
        forces[:, side] = force
        phi[rows_g + side] = np.einsum("na,na->n", n, t)
        np.add.at(phi, rows_p, force[:, None] * n)
        columns = base + dof[:, None] + np.arange(m0.shape[2])[None, :]
        pull = force[:, None] * n
        np.add.at(phi, columns, np.einsum("nak,na->nk", m0, pull))
        if jac is None:
            continue
        project = (eye - n[:, :, None] * n[:, None, :]) / dist[:, None, None]
        pt = np.einsum("nab,nb->na", project, t)
        fp = force[:, None, None] * project - stiff[:, None, None] * n[:, :, None] * n[:, None, :]
        nt = phi[rows_g + side]
        fg = -force[:, None] * pt + (stiff * nt)[:, None] * n
        g = rows_g + side
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


def initial_state(system: System, start: Start, fraction: float) -> Array:
    """Return the nominal state, or a designer's guess: the screw shifted along its axis as if all balls shared the load."""
    problem = system.problem
    scene = problem.scene
    count = problem.C.shape[0]
    p, gamma = np.zeros((count, 2)), np.full((count, 4), scene.track.contact_angle)
    u = problem.prescribed.copy()
    if start != "nominal":
        axial = fraction * float(problem.load[:, 2].sum())
        rise = np.sin(scene.track.contact_angle) * np.cos(lead_angle(scene.track))
        share = abs(axial) / (count * rise)
        pair = problem.C[:, 0] + problem.C[:, 3]
        shift = np.sign(axial) * float(contact_approach(share, pair.mean())) / rise
        u[:, 2] += np.where(problem.fixed[:, 2], 0.0, shift)
        cosine = np.cos(lead_angle(scene.track))
        p[:, 1] = 0.5 * shift * cosine
    return np.concatenate([p.ravel(), gamma.ravel(), u.ravel()])


def solve_source(
    scene: Scene,
    *,
    kinematics: Kinematics = "source",
    start: Start = "guess",
    everything: bool = False,
    member: int = 0,
    tolerance: float = 1e-12,
) -> SourceSolution:
    """Solve a scene with Lin's equations and plain Newton iteration (Lin 2.26).

    Parameters
    ----------
    scene
        The scene; its screw must be a beam.
    kinematics
        ``"source"``: lever arm and station follow the contact angle (Lin 2.18-2.21); ``"arc"``: the same rigid arcs as the
        energy solver, with which it then agrees to round-off.
    start
        Nominal state, a designer's guess, or ten load steps from that guess.
    everything
        Whether the shaft without influence is built too.
    member
        Number of the specimen, for a scene with random errors.
    tolerance
        Relative residual to reach.

    Raises
    ------
    ValueError
        A scene with a rigid screw.
    """
    begin = perf_counter()
    if scene.ingredients.screw == "rigid":
        raise ValueError("the source's formulation needs a beam screw")
    layout = ball_layout(scene)
    problem = build(scene, specimen(scene, layout, member), layout, np.ones(4, dtype=bool), everything=everything)
    axes = np.stack([layout.radial, layout.binormal], axis=1)
    free_u = np.flatnonzero(~problem.fixed.ravel())
    count = problem.C.shape[0]
    free = np.concatenate([np.arange(6 * count), 6 * count + free_u])
    system = System(problem, kinematics, beam_matrix(problem), free, axes)
    steps = [1.0] if start != "load steps" else list(np.linspace(0.1, 1.0, 10))
    x = initial_state(system, start, steps[0])
    total, residual, status = 0, np.inf, "converged"
    with np.errstate(all="ignore"):
        for fraction in steps:
            x, iterations, residual, status = newton_iteration(system, x, fraction * problem.load.ravel(), tolerance)
            total += iterations
            if status != "converged":
                break
        phi, _, forces = equations_and_jacobian(system, x, problem.load.ravel(), jacobian=False)
    return SourceSolution(
        status=status,
        load=forces,
        contact_angle=x[2 * count : 6 * count].reshape(count, 4),
        centre=x[: 2 * count].reshape(count, 2),
        motion=x[6 * count :].reshape(-1, 6),
        reactions=np.where(problem.fixed, phi[6 * count :].reshape(-1, 6), 0.0),
        iterations=total,
        residual=residual,
        seconds=perf_counter() - begin,
        unknowns=free.size,
    )


def solve_source_result(scene: Scene, *, everything: bool = False, member: int = 0) -> StaticResult:
    """Return the result of `solve_source` from the designer's guess, as the other models' record.

    With Hertz constants of error-free parts, as Lin has them, where the scene asks for each contact's actual radii.

    Parameters
    ----------
    scene
        Scene with one set.
    everything
        Whether all terms are computed; without effect on Lin's method.
    member
        Number of the specimen of a scene with random errors.
    """
    scene = error_free(scene)
    layout = ball_layout(scene)
    use = np.ones(4, dtype=bool)
    problem = build(scene, specimen(scene, layout, member), layout, use, everything=everything)
    mechanism = free_motions(problem)
    if mechanism.driven:
        return failed_result(problem, "source", Status("not held", mechanism.text), 0.0)
    solution = solve_source(scene, everything=everything, member=member)
    status = Status("converged") if solution.converged else Status("not converged", f"source's Newton: {solution.status}")
    if not np.all(np.isfinite(solution.load)) or not np.all(np.isfinite(solution.motion)):
        return failed_result(problem, "source", status, solution.seconds)
    angle = solution.contact_angle
    solved = SolvedState(
        problem,
        solution.motion,
        solution.centre,
        solution.load,
        SIGNS * np.stack([np.cos(angle), np.sin(angle)], axis=-1),
        solution.reactions,
        shifts_of_beam(problem, solution.motion),
        0.0,
    )
    report = SolverReport(
        solution.iterations,
        solution.iterations + 1,
        solution.residual,
        solution.seconds,
        solution.unknowns,
        problem.nodes.size - 1,
        "numpy, dense",
        "equilibrium equations of the source",
    )
    left_out = ("nothing: all four flanks are built",)
    return assemble_result(solved, "source", status, report, left_out, model_assumptions(scene), own_arms=True)


def _residual_measures(system: System, phi: Array, forces: Array, load: Array) -> float:
    """Return largest unbalanced force over largest force; moments over the pitch radius, contact conditions over r_G."""
    count = forces.shape[0]
    arm = system.problem.scene.track.pitch_radius
    weights = np.tile([1.0, 1.0, 1.0, 1.0 / arm, 1.0 / arm, 1.0 / arm], system.problem.nodes.size)
    screw = (phi[6 * count :] * weights)[system.free[6 * count :] - 6 * count]
    scale = max(float(np.abs(load * weights).max(initial=0.0)), float(forces.max(initial=0.0)))
    if not scale > 0.0:
        return float("inf")
    unbalanced = max(float(np.abs(phi[: 2 * count]).max()), float(np.abs(screw).max(initial=0.0)))
    skew = float(np.abs(phi[2 * count : 6 * count]).max()) / float(system.problem.drawn.radius.max())
    return max(unbalanced / scale, skew)


def newton_iteration(system: System, x: Array, load: Array, tolerance: float) -> tuple[Array, int, float, str]:
    """Iterate by plain Newton (Lin 2.26); return state, iterations, relative residual and status text."""
    best, stalled = np.inf, 0
    residual = np.inf
    for iteration in range(MOST + 1):
        phi, jac, forces = equations_and_jacobian(system, x, load)
        residual = _residual_measures(system, phi, forces, load) if np.all(np.isfinite(phi)) else np.inf
        if residual <= tolerance:
            return x, iteration, residual, "converged"
        stalled = stalled + 1 if residual >= 0.5 * best else 0
        best = min(best, residual)
        if stalled >= 4 and residual < 1e-9:
            return x, iteration, residual, "converged" if residual <= 1e-10 else f"stalled at {residual:.1e}"
        if not np.all(np.isfinite(phi)):
            return x, iteration, residual, "diverged: the iterate is not finite"
        assert jac is not None
        free = system.free
        small = jac[np.ix_(free, free)]
        scale = np.abs(small).max(axis=1)
        if not np.all(np.isfinite(small)) or np.any(scale == 0.0):
            return x, iteration, residual, f"singular Jacobian at iteration {iteration + 1}"
        try:
            step = np.linalg.solve(small / scale[:, None], -phi[free] / scale)
        except np.linalg.LinAlgError:
            return x, iteration, residual, f"singular Jacobian at iteration {iteration + 1}"
        if not np.all(np.isfinite(step)) or float(np.abs(step).max()) > 1e6:
            return x, iteration, residual, f"singular Jacobian at iteration {iteration + 1}"
        x = x.copy()
        x[free] += step
    return x, MOST, residual, f"not converged after {MOST} iterations (residual {residual:.1e})"


def best_start(scene: Scene, kinematics: Literal["arc", "source"]) -> SourceSolution:
    """Return Lin's Newton from the designer's guess, or by load steps where that fails.

    Parameters
    ----------
    scene
        Scene with one set.
    kinematics
        Motion of the flanks: rigid ``"arc"``, or as the ``"source"`` has it.
    """
    solution = solve_source(scene, kinematics=kinematics, start="guess")
    if solution.converged:
        return solution
    return solve_source(scene, kinematics=kinematics, start="load steps")
