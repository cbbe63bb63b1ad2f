"""Static load distribution with elastic bodies: the refined model, and intermediate steps between it and Lin's model.

The contact mechanics are those of `lowfi.statics.static`. In addition, the flanks of screw and nut deform under contact
forces by a compliance matrix, which is computed (`lowfi.compliance.bodies`) or read from the file of a condensed 3D model.

Specimens of a scene whose random errors concern only the radii of the balls are solved with one set of equations
(`SpecimensWithSharedEquations`): the compliance of the bodies, the shaft and its supports are the same for all. Only the
contacts' approaches, Hertz constants, and the terms that depend on the typical contact force differ. Each specimen is
solved from the solution of the first one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np

from rollbench.lowfi.compliance.bodies import WholeBody, compliance_between_contacts
from rollbench.lowfi.compliance.parts import (
    REFINED,
    ComplianceModel,
    grooved_section,
    idealisation_statements,
    reduce_to_compliance_geometry,
)
from rollbench.lowfi.hertz import contact_stiffness_under_force
from rollbench.lowfi.statics import response, static
from rollbench.lowfi.statics import shaft as statics_shaft
from rollbench.lowfi.statics.contacts import hertz_constants_by_scene_choice
from rollbench.lowfi.statics.kernel.search import CONVERGED, ITERATIONS
from rollbench.lowfi.statics.kernel_types import NO_ROLLERS, RIGID, BallContacts, BodySystem, ForceState, Outcome
from rollbench.lowfi.statics.problem import Problem, SolvedState, centre_vectors_and_interference
from rollbench.lowfi.statics.response import LARGEST, FlankCompliance, flank_pair_data, only_flank_pair
from rollbench.lowfi.statics.result import StaticResult
from rollbench.lowfi.statics.selection import choose_flanks, flanks_of_scene, solutions_clear_of_left_out_flanks
from rollbench.lowfi.statics.settle import ACCEPTED, ContactState, ModelDescription, residual_by_round_off, solver_options
from rollbench.lowfi.statics.summary import ELASTIC_ASSUMPTIONS
from rollbench.meshes import errors
from rollbench.meshes.arrays import Array, Mask
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Scene, UnfitKey
from rollbench.meshes.section import BeamSection

if TYPE_CHECKING:
    from rollbench.lowfi.compliance.bodies import CondensedCompliance


#: Formulation of a solution with elastic bodies.
CONDENSED = "convex energy, elastic bodies condensed to the contacts"
#: Distance [m] of a ball from a flank that the equations leave out, below which the ball counts as touching it.
MARGIN = 0.2e-6


@dataclass(kw_only=True)
class ElasticEquations(static.SingleNutEquations):
    """Equations of a single ball screw or ball bearing with elastic screw, nut and balls, for the numerical kernels."""

    SOLVER = "solve_forces"
    #: Arrays of bodies and balls for the kernels.
    kernel_arrays: BodySystem
    #: Unknowns of the iteration: contact forces, free rigid motions of the bodies (which only contacts resist), contacts.
    state: ForceState
    #: The screw's beam with its supports.
    shaft: statics_shaft.ShaftBeam
    #: Compliance of screw, nut and balls at the flanks.
    flank_compliance: FlankCompliance
    #: Assumptions about the bodies, as sentences for the report.
    assumed: tuple[str, ...]

    @property
    def only_flank_pair(self) -> tuple[int, int] | None:
        """Return the numbers of the two flanks if only one pair of diagonally opposite flanks has contacts.

        The numbers are 0 screw left, 1 screw right, 2 nut left, 3 nut right; the screw's flank comes first. None if all
        four flanks have contacts. For such a pair the position of the ball follows in closed form.
        """
        return only_flank_pair(self.problem)

    def solve_by_newton(self, from_linear: bool = True) -> Outcome:
        """Solve the equilibrium by Newton's method with the present Hertz constants.

        Parameters
        ----------
        from_linear
            Whether to start from the solution with linear springs in place of the contacts; otherwise from the present
            state.
        """
        if self.only_flank_pair is not None:
            self.kernel_arrays.contacts.flank_pair_data[:, 4] = self.problem.C[:, list(self.only_flank_pair)].sum(axis=1)
        return super().solve_by_newton(from_linear)

    def contact_states(self) -> Sequence[ContactState]:
        """Return contact forces, ball centres and flank motions, as the iteration has them now."""
        problem, state, moved, pair = self.problem, self.state, self.flank_motions(), self.only_flank_pair
        if pair is None:
            return (ContactState(problem, state.contact, state.ball_unknowns[:, :2].copy(), moved),)
        a, b = pair
        N = len(moved)
        contact, p, single = np.zeros((N, 4, 5)), np.zeros((N, 2)), np.zeros((4, 5))
        contact[:, a] = contact[:, b] = state.contact[:, 0]
        contact[:, b, 1:3] *= -1.0
        geometry, closure, drawn = problem.geometry, problem.interference, problem.drawn
        tiny = self.kernel_arrays.contacts.unloaded_force_limit
        for i in range(N):  # the ball's centre follows from the motions of both flanks
            ball = geometry[i], closure[i], RIGID, drawn.ball_radii[i], drawn.profile_coefficients
            self.engine.find_ball_equilibrium(p[i], moved[i].copy(), *ball, tiny, single)
        return (ContactState(problem, contact, p, moved),)

    def forces_on_flanks(self) -> Array:
        """Return the forces of the balls on all flanks ``(N, 4, 2)`` [N], radial and along the helix's binormal."""
        pair, contact = self.only_flank_pair, self.state.contact
        pushes = contact[..., 0, None] * contact[..., 1:3]
        if pair is None:
            return np.asarray(pushes)
        out = np.zeros((contact.shape[0], 4, 2))
        out[:, pair[0]], out[:, pair[1]] = pushes[:, 0], -pushes[:, 0]
        return out

    def flank_motions(self) -> Array:
        """Return the motions of the four flanks ``(N, 4, 2)`` [m] in the present state; zero for a flank without contacts.

        The last axis holds two components in the ball's section plane, radial and along the helix's binormal.
        """
        screw, nut, v0, R = self.flank_compliance.flank_motion_terms
        forces = self.forces_on_flanks()
        N, out = len(forces), np.zeros(forces.shape)
        for G, sides in ((screw, (0, 1)), (nut, (2, 3))):
            used = [s for s in sides if self.problem.used_flanks[s]]
            out[:, used] = (G @ forces[:, used].ravel()).reshape(N, len(used), 2)
        out[:, :2] += v0 + R @ self.state.a
        return out

    def round_off_residual(self) -> float:
        """Return the relative residual that rounding errors leave, from the largest motion and the stiffest contact."""
        problem, v0 = self.problem, self.kernel_arrays.bodies.v0
        stiff = float(contact_stiffness_under_force(self.state.contact[..., 0], problem.C.min()).max(initial=0.0))
        motion = float(np.abs(self.flank_motions()).max()) + float(np.abs(v0).max(initial=0.0))
        return residual_by_round_off(motion, stiff, self.residual_force_scale, [problem])

    def are_balls_clear_of_left_out_flanks(self) -> bool:
        """Return whether every ball is at least ``MARGIN`` away from all flanks that were left out.

        A flank that was left out is taken to move like the other flank of the same groove. ``MARGIN`` covers the
        elastic deformation between these two flanks.
        """
        problem, contact, p, shift = self.contact_states()[0]
        for s in np.flatnonzero(~problem.used_flanks):
            shift[:, s] = shift[:, int(s) ^ 1]
        parts = p[None], shift[None], problem.geometry[None], contact[None, ..., 0]
        return bool(solutions_clear_of_left_out_flanks(*parts, problem.used_flanks, MARGIN)[0])

    def solved_state(self) -> SolvedState:
        """Return the solution: motions, contact forces and support reactions.

        Neither the motions of the beam's nodes nor the reactions are unknowns of the equations; both follow from the
        contact forces.
        """
        problem, coupling = self.problem, self.flank_compliance.coupling
        used = [s for s in range(2) if problem.used_flanks[s]]
        pushes = self.forces_on_flanks()[:, used].transpose(1, 0, 2).reshape(-1, 2)
        by_flanks = statics_shaft.nodal_loads_of_flank_forces(problem, pushes, used)
        if coupling is not None:
            by_flanks += coupling.nodal_loads_of_jumps(pushes.ravel())
        motion = statics_shaft.nodal_motions_under_loads(self.shaft, by_flanks, self.state.a)
        nodal = np.zeros((problem.nodes.size, 6))
        if problem.rigid_motion_basis is None:
            nodal = statics_shaft.nodal_forces_under_loads(self.shaft, by_flanks) - problem.load - by_flanks.reshape(-1, 6)
        if coupling is not None:
            motion = coupling.add_jumps_inside_stretches(motion, pushes, problem.fixed)
        held = np.where(problem.fixed, nodal, 0.0)
        scale = max(self.residual_force_scale, float(np.abs(held[:, :3]).max(initial=0.0)))
        _, contact, centre, shifts = self.contact_states()[0]
        return SolvedState(problem, motion, centre, contact[..., 0], contact[..., 1:3], held, shifts, scale)

    def model_description(self) -> ModelDescription:
        """Return the formulation, number of unknowns and assumptions of the model for the record of the solution.

        Among the assumptions is a statement of how much negative compliance of the bodies was set to zero, so that their
        matrices are positive semidefinite.
        """
        build, clipped = self.problem_input, self.flank_compliance.clipped_share
        assert isinstance(build, ElasticInput)
        of_file = build.condensed_bodies
        source = (of_file.describe_source(),) if of_file else idealisation_statements(build.backend, build.scene)
        size = self.state.phi.size + self.state.a.size
        cut = (f"negative compliance of the bodies, up to {100 * clipped:.2g} % of a contact's, is set to zero",)
        assumed = (*ELASTIC_ASSUMPTIONS, *source, *self.assumed)
        return ModelDescription(CONDENSED, size, assumed, cut if clipped > 1e-6 else ())


@dataclass(frozen=True, kw_only=True)
class ElasticInput(static.StaticInput):
    """Input from which a ball screw's static problem with elastic bodies is built, and can be rebuilt with more flanks."""

    #: Method by which the compliance of screw, nut and balls is computed.
    backend: ComplianceModel = REFINED
    #: Compliance of the bodies condensed from a 3D model, in place of a computed one; None: computed.
    condensed_bodies: CondensedCompliance | None = None
    #: Function that computes the compliance of one complete screw or nut between its contacts.
    compute_body_compliance: WholeBody = compliance_between_contacts

    @property
    def replacement_section(self) -> BeamSection | None:
        """Return the screw's cross-section with its groove, if the ``backend`` computes one; None: a plain section is used.

        The plain section follows from the scene's dimensions.
        """
        return grooved_section(reduce_to_compliance_geometry(self.scene), True) if self.backend.section == "cell" else None

    def build_equations(self, problem: Problem) -> ElasticEquations:
        """Return the equations of the problem with elastic bodies for the numerical kernels.

        Raises
        ------
        UnfitKey
            If there are more than ``LARGEST`` balls.
        ValueError
            If a body has impossible dimensions.
        """
        N = self.layout.z.size
        if N > LARGEST:
            reason = f"balls.count gives {N} balls: elastic bodies are allowed with at most {LARGEST}; use the model lin"
            raise UnfitKey("balls.count", reason)
        how = self.backend, self.condensed_bodies, self.compute_body_compliance
        bodies = response.compliance_of_screw_and_nut(problem, *how)
        shaft, ball, drawn = bodies.shaft_beam.with_loads_of(problem), bodies.ball_compliance, problem.drawn
        scale, pair = static.residual_scale(problem), only_flank_pair(problem)
        flanks = response.flank_compliance_under_loads(problem, scale.typical_force_for_ellipse, shaft, bodies)
        local, rows = np.zeros((N, 4, 3)), np.zeros((N, 7))
        local[..., 0], local[..., 2] = flanks.e, flanks.h
        local[..., 1] = ball.pair_coupling_root * np.array([1.0, ball.pair_coupling_sign, ball.pair_coupling_sign, 1.0])
        if pair is not None:  # only one diagonal pair of flanks: no other pair that the ball could couple it with
            local[..., 0] += 2.0 * ball.pair_coupling_root**2
            rows = flank_pair_data(problem, pair, local[..., 0], flanks.h)
        profile = np.repeat(drawn.profile_coefficients[None], N, axis=0)
        balls = problem.geometry, problem.interference, local, drawn.ball_radii, profile, rows
        contacts = BallContacts(*balls, NO_ROLLERS, scale.unloaded_force_limit)
        v0, k = flanks.kernel_bodies.v0, flanks.kernel_bodies.work_on_free_motions.size
        options = solver_options(scale, problem.scene.track.pitch_radius, float(drawn.ball_radii.max()))
        springs = response.starting_spring_factors(problem, pair, options.stiffness)
        return ElasticEquations(
            engine=self.engine,
            kernel_arrays=BodySystem(flanks.kernel_bodies, contacts, springs),
            state=ForceState(np.zeros(v0.shape), np.zeros(k), np.zeros((N, 3)), np.zeros((N, 1 if pair else 4, 5))),
            options=options,
            problem=problem,
            problem_input=self,
            shaft=shaft,
            flank_compliance=flanks,
            assumed=bodies.assumed,
        )

    def note_on_touched_flanks(self) -> str:
        """Return the note for the result that balls may touch left-out flanks, so that all four flanks were solved."""
        return "two of the four flanks may touch balls in the solution without them: solved again with all four flanks"


def solve_elastic(
    scene: Scene,
    *,
    backend: ComplianceModel = REFINED,
    condensed: CondensedCompliance | None = None,
    name: str = "refined",
    engine: static.Engine = "auto",
    everything: bool = False,
    member: int = 0,
    refine: int = 1,
) -> StaticResult:
    """Compute contact loads, contact angles and shaft motion of a ball screw with elastic bodies in static equilibrium.

    Parameters
    ----------
    scene
        Screw, nut, balls, supports and loads.
    backend
        Method by which the compliance of screw, nut and balls is computed.
    condensed
        Compliance of the bodies condensed from a 3D model, in place of a computed one.
    name
        Name of the model in the result.
    engine
        Numerical kernels: ``"interpreted"``, ``"compiled"``, or ``"auto"``, which chooses by the number of balls.
    everything
        Whether to model also flanks that cannot touch a ball, and ends of the shaft that carry no load.
    member
        Number of the specimen, for a scene with random errors: each number gives other errors.
    refine
        Number of elements that each beam element is split into.

    Returns
    -------
    StaticResult
        Loads, angles and motions; if there is no equilibrium, ``status`` gives the reason.

    Raises
    ------
    ValueError
        If a body has impossible dimensions, or (UnfitKey) if there are more than ``LARGEST`` balls.
    """
    start = perf_counter()
    layout = ball_layout(scene)
    drawn = errors.draw_geometry_with_errors(scene, layout, member)
    uneven = drawn.profile_coefficients.shape[1] > 0
    kernels = static.pick_engine(engine, layout.z.size, uneven)
    use = flanks_of_scene(scene) if everything or uneven else choose_flanks(scene, drawn)
    parts = scene, drawn, layout, use, kernels, everything, refine
    return static.solve_static_input(ElasticInput(*parts, backend=backend, condensed_bodies=condensed), name, start)


class SpecimensWithSharedEquations:
    """Solver for specimens of a ball screw that differ only in the random radii of their balls and so share equations.

    The function `can_share_equations` tells whether this holds for the specimens of a scene.
    """

    def __init__(
        self,
        scene: Scene,
        backend: ComplianceModel,
        engine: ModuleType,
        previous: SpecimensWithSharedEquations | None = None,
    ) -> None:
        """Store the scene; the equations are built when the first specimen is solved.

        Parameters
        ----------
        scene
            Screw, nut and balls with random errors, supports and loads.
        backend
            Method by which the compliance of screw, nut and balls is computed.
        engine
            Module of the numerical kernels.
        previous
            The same specimens under nearly the same loads, solved before; their solutions are the starts of the iteration.
            None: each specimen starts from the solution of specimen 0.
        """
        self.scene, self.backend, self.engine, self.like = scene, backend, engine, previous
        self.layout = ball_layout(scene)
        self._systems: dict[bytes, _SharedEquations | None] = {}
        self._states: dict[tuple[int, bytes], list[Array]] = {}  # by specimen and flanks

    def solve(self, first: int, count: int) -> tuple[Array, Array, Array]:
        """Compute the contact loads of consecutive specimens.

        Parameters
        ----------
        first
            Number of the first specimen.
        count
            Number of specimens.

        Returns
        -------
        tuple[Array, Array, Array]
            Contact loads ``(count, N, 4)`` [N]; relative residuals ``(count,)``; and work ``(count,)`` [J] of the external
            loads on the motions of their points of action. All are nan for a specimen that these equations do not solve; it
            needs `solve_elastic`.
        """
        drawn = errors.draw_geometries_with_errors(self.scene, self.layout, first, count)
        offset, closure = centre_vectors_and_interference(self.scene, drawn)
        nominal = errors.draw_geometry_with_errors(errors.scene_without_random_errors(self.scene), self.layout)
        C = hertz_constants_by_scene_choice(self.scene, nominal, drawn.ball_radii)
        loads, numbers = np.full((count, self.layout.z.size, 4), np.nan), np.full((2, count), np.nan)
        self._states.clear()
        for k in range(count):
            dims = drawn.ball_radii[k], offset[k], closure[k], C[k]
            use = choose_flanks(self.scene, nominal, dims[1:3])
            solved = self._solve_specimen(first + k, use, dims)
            if solved is None and not np.array_equal(use, flanks_of_scene(self.scene)):
                solved = self._solve_specimen(first + k, flanks_of_scene(self.scene), dims)
            if solved is not None:
                loads[k], numbers[:, k] = solved[0], solved[1:]
        return loads, *numbers

    def _solve_specimen(
        self, number: int, used: Mask, dims: tuple[Array, Array, Array, Array]
    ) -> tuple[Array, float, float] | None:
        """Solve one specimen with contacts on the flanks ``used``; return None if that fails.

        Returns contact loads ``(N, 4)`` [N], relative residual, and work of the external loads [J].

        Parameters
        ----------
        number
            Number of the specimen.
        used
            Which of the four flanks (screw left, screw right, nut left, nut right) have contacts ``(4,)``.
        dims
            Ball radii, distances of ball and groove centres, interferences and Hertz constants of the specimen: the
            first four arguments of `_SharedEquations.solve_specimen`.
        """
        system, key = self._equations_for_flanks(used), (number, used.tobytes())
        if system is None:
            return None
        solved = system.solve_specimen(*dims, start=self.like._states.get(key) if self.like else None)
        if solved is not None:
            self._states[key] = [array.copy() for array in system.elastic.state]
        return solved

    def _equations_for_flanks(self, used: Mask) -> _SharedEquations | None:
        """Return the equations with contacts on the flanks ``used``, solved for specimen 0, for use by other specimens.

        If balls of specimen 0 touch a flank that was left out, the equations have all four flanks. None if specimen 0 has
        no solution or its equations fit no other specimen.
        """
        key = used.tobytes()
        if key not in self._systems:
            self._systems[key] = None
            drawn = errors.draw_geometry_with_errors(self.scene, self.layout)
            parts = self.scene, drawn, self.layout, used, self.engine
            solved = static.solve_with_chosen_flanks(ElasticInput(*parts, backend=self.backend))
            if isinstance(solved, static.SolvedEquations) and solved.outcome.status == CONVERGED:
                elastic = solved.system
                if isinstance(elastic, ElasticEquations) and elastic.flank_compliance.compliance_moved_to_bodies == 0.0:
                    self._systems[key] = _SharedEquations(elastic)
        return self._systems[key]


def can_share_equations(scene: Scene) -> bool:
    """Return whether all specimens of a scene can be solved with the same equations (`SpecimensWithSharedEquations`).

    This requires that they differ only in the radii of their balls, that Hertz constants are not updated in the iteration,
    and that the screw is not rigid.

    Parameters
    ----------
    scene
        Scene with random errors.
    """
    if not errors.have_equal_circular_grooves(scene):
        return False
    two = errors.draw_geometries_with_errors(scene, ball_layout(scene), 0, 2)
    return len(two.groove_centres) == 1 and scene.ingredients.hertz != "actual" and scene.ingredients.screw != "rigid"


class _SharedEquations:
    """Equations of one solved specimen with elastic bodies, into which the ball radii of other specimens are written."""

    def __init__(self, elastic: ElasticEquations) -> None:
        """Store solved equations, whose solution is the start of the iteration for other specimens.

        ``elastic``: the equations. The coefficients of the contact law, which depend on the typical contact force, and of
        the work of the external loads are stored too.
        """
        self.elastic = elastic
        self.start = [array.copy() for array in elastic.state]
        self.local = elastic.kernel_arrays.contacts.compliance_terms.copy()
        self.size = float(np.cbrt(static.residual_scale(elastic.problem).typical_force_for_ellipse))
        self.by_pushes, self.by_motions, self.at_rest = _external_work_coefficients(elastic)

    def solve_specimen(
        self, radii: Array, offset: Array, closure: Array, C: Array, start: list[Array] | None
    ) -> tuple[Array, float, float] | None:
        """Compute the contact loads of one specimen.

        Parameters
        ----------
        radii
            Radii of its balls ``(N,)`` [m].
        offset, closure
            For each ball and flank the vector from groove centre to ball centre (two components), its length and the
            nominal approach ``(N, 4, 4)`` [m]; for each ball the interference with both pairs of opposite flanks ``(N, 2)``
            [m]. Both come from `centre_vectors_and_interference`.
        C
            Hertz constants ``(N, 4)`` [m/N^(2/3)].
        start
            Arrays of the state from which to iterate; None: the solution of specimen 0.

        Returns
        -------
        tuple[Array, float, float] | None
            Contact loads ``(N, 4)`` [N], relative residual, and work of the external loads [J]. None if the iteration does
            not converge, or a ball may touch a flank that was left out.
        """
        self._write_specimen(radii, offset, closure, C)
        for array, first in zip(self.elastic.state, start or self.start, strict=True):
            array[:] = first
        elastic = self.elastic
        outcome = elastic.solve_by_newton(False)
        if outcome.status not in (CONVERGED, ITERATIONS):
            return None
        if outcome.residual > ACCEPTED and outcome.residual > elastic.round_off_residual():
            return None
        used, pair = elastic.problem.used_flanks, elastic.only_flank_pair
        whole = np.array_equal(used, flanks_of_scene(elastic.problem.scene))
        if not whole and (outcome.status != CONVERGED or not elastic.are_balls_clear_of_left_out_flanks()):
            return None
        contact = elastic.state.contact
        loads = np.zeros(offset.shape[:2])
        loads[:, slice(None) if pair is None else pair] = contact[..., 0]
        on_screw = elastic.forces_on_flanks()[:, :2][:, used[:2]].swapaxes(0, 1).ravel()
        work = float(self.by_pushes @ on_screw + self.by_motions @ elastic.state.a) + self.at_rest
        return loads, outcome.residual, work

    def _write_specimen(self, radii: Array, offset: Array, closure: Array, C: Array) -> None:
        """Write ball radii, interferences and contact laws of a specimen into the kernels' arrays.

        ``radii`` ``(N,)``: ball radii [m]; ``offset``, ``closure``: result of `centre_vectors_and_interference` (vectors
        from groove to ball centres, interferences); ``C`` ``(N, 4)``: Hertz constants.
        """
        elastic, problem = self.elastic, self.elastic.problem
        problem.geometry[..., :4], problem.geometry[..., 4] = offset, C
        problem.interference[:], problem.drawn.ball_radii[:] = closure, radii
        scale, slope = static.residual_scale(problem), elastic.flank_compliance.slope_of_e
        size = float(np.cbrt(scale.typical_force_for_ellipse))
        contacts, pair = elastic.kernel_arrays.contacts, elastic.only_flank_pair
        local = contacts.compliance_terms
        local[:] = self.local
        local[..., 0] += slope * np.log(size / self.size)
        local[..., 2] += slope * (1.0 / size - 1.0 / self.size)
        if pair is not None:
            contacts.flank_pair_data[:] = flank_pair_data(problem, pair, local[..., 0], local[..., 2])
        contacts = contacts._replace(unloaded_force_limit=scale.unloaded_force_limit)
        elastic.kernel_arrays = elastic.kernel_arrays._replace(contacts=contacts)
        least, furthest = scale.least_force_scale, float(radii.max())
        elastic.options = elastic.options._replace(least_force_scale=least, max_flank_step=furthest)


def _external_work_coefficients(elastic: ElasticEquations) -> tuple[Array, Array, float]:
    """Return the coefficients of a linear function that gives the work [J] of the external loads on the moved screw.

    Variables of the function are contact forces and amplitudes of the rigid motions that no support prevents (free
    motions). Returns three values: the derivative of the work by the forces of the balls on the c screw flanks ``(2 c,)``
    [J/N], the derivative by the amplitudes of the k free motions ``(k,)`` [N], and the constant part [J].
    """
    problem, shaft, coupling = elastic.problem, elastic.shaft, elastic.flank_compliance.coupling
    load = problem.load.ravel()
    dof, rows = statics_shaft.flank_motion_coefficients(problem, [s for s in range(2) if problem.used_flanks[s]])
    by_flanks = np.zeros((load.size, 2 * len(rows)))
    for c in range(len(rows)):
        by_flanks[dof[c], 2 * c], by_flanks[dof[c], 2 * c + 1] = rows[c]
    given, inside = np.zeros(load.size), np.zeros(by_flanks.shape[1])
    if coupling is not None:
        by_flanks += coupling.wrenches_per_nodal_motion.T @ coupling.jumps_per_flank_force
        given = coupling.wrenches_per_nodal_motion.T @ coupling.jumps_by_external_loads
        free_load = np.where(problem.fixed, 0.0, problem.load).reshape(-1, 1)
        inside = coupling.inner_jumps.flank_motions_by_nodal_loads(free_load)[:, 0]
    moved = statics_shaft.nodal_motions_under_loads(shaft, given, np.zeros(elastic.state.a.size)).ravel()
    by_motions = load @ statics_shaft.nodal_motions_of_rigid_screw(shaft)
    return load @ shaft.motions_under_loads(by_flanks) + inside, by_motions, float(load @ moved)
