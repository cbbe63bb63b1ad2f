"""Static load distribution with elastic bodies: the refined model, and intermediate steps between it and Lin's model.

The contact mechanics are those of `lowfi.statics.static`. In addition, the flanks of screw and nut deform under contact
forces by a compliance matrix, which is computed (`lowfi.compliance.bodies`) or read from the file of a condensed 3D model.

Specimens of a scene whose random errors concern only the radii of the balls are solved with one set of equations
(`ElasticMembers`): the compliance of the bodies, the shaft and its supports are the same for all. Only the contacts'
approaches, Hertz constants, and the terms that depend on the typical contact force differ. Each specimen is solved from the
solution of the first one.
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
    Backend,
    grooved_section,
    idealisation_statements,
    reduce_to_compliance_geometry,
)
from rollbench.lowfi.hertz import contact_stiffness_under_force
from rollbench.lowfi.statics.contacts import hertz_C
from rollbench.lowfi.statics.kernel.search import CONVERGED, ITERATIONS
from rollbench.lowfi.statics.kernel_types import NO_ROLLERS, RIGID, BallContacts, BodySystem, ForceState, Outcome
from rollbench.lowfi.statics.problem import Problem, SolvedState, centre_distances
from rollbench.lowfi.statics.response import (
    LARGEST,
    FlankCompliance,
    flanks_of,
    only_flank_pair,
    pair_data,
    response_of,
    spring_rows,
)
from rollbench.lowfi.statics.result import StaticResult
from rollbench.lowfi.statics.selection import choose_sides, flanks_of_scene, solutions_clear_of_left_out_flanks
from rollbench.lowfi.statics.settle import ACCEPTED, ContactState, ModelDescription, least_residual, solver_options
from rollbench.lowfi.statics.shaft import (
    Shaft,
    flank_motion_coefficients,
    nodal_loads_of_flank_forces,
    nodal_motions_of_rigid_screw,
    node_forces,
    node_motions,
)
from rollbench.lowfi.statics.static import (
    Engine,
    OneSetEquations,
    Solution,
    StaticInput,
    pick_engine,
    residual_scale,
    solve_built,
    solve_with_chosen_flanks,
)
from rollbench.lowfi.statics.summary import ELASTIC_ASSUMPTIONS
from rollbench.meshes.arrays import Array, Mask
from rollbench.meshes.errors import draw_specimen, draw_specimens, have_equal_circular_grooves, scene_without_random_errors
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Scene, UnfitKey
from rollbench.meshes.section import BeamSection

if TYPE_CHECKING:
    from rollbench.lowfi.compliance.bodies import Condensed


#: Formulation of a solution with elastic bodies.
CONDENSED = "convex energy, elastic bodies condensed to the contacts"
#: A flank that was left out counts as touching if its distance to a ball is smaller than this [m].
MARGIN = 0.2e-6


@dataclass(kw_only=True)
class ElasticEquations(OneSetEquations):
    """Equations of a single ball screw or ball bearing with elastic screw, nut and balls, for the numerical kernels."""

    SOLVER = "solve_forces"
    #: Arrays of bodies and balls for the kernels.
    given: BodySystem
    #: Unknowns of the iteration: contact forces, free rigid motions of the bodies (which only contacts resist), contacts.
    state: ForceState
    #: The screw's beam with its supports.
    shaft: Shaft
    #: Compliance of the bodies at the flanks.
    bodies: FlankCompliance
    #: Assumptions about the bodies, as sentences for the report.
    assumed: tuple[str, ...]

    @property
    def pair(self) -> tuple[int, int] | None:
        """Return the numbers of the two flanks if only one diagonal pair has contacts, the screw's flank first.

        Flanks are numbered SL 0, SR 1, NL 2, NR 3. None if all four flanks have contacts. The position of a ball between
        two flanks has a closed form.
        """
        if self.given.bodies.second.size:
            return None
        a = 0 if self.problem.use[0] else 1
        return a, 3 - a

    def iterate(self, from_linear: bool = True) -> Outcome:
        """Solve the equilibrium by Newton's method with the present Hertz constants.

        Parameters
        ----------
        from_linear
            Whether to start from the solution with linear springs for contacts, else from the present state.
        """
        if self.pair is not None:
            self.given.contacts.pair[:, 4] = self.problem.C[:, list(self.pair)].sum(axis=1)
        return super().iterate(from_linear)

    def flanks(self) -> Sequence[ContactState]:
        """Return contact forces, ball centres and flank motions, as the iteration has them now."""
        problem, state, moved, pair = self.problem, self.state, self.shifts(), self.pair
        if pair is None:
            return (ContactState(problem, state.contact, state.inner[:, :2].copy(), moved),)
        a, b = pair
        N = len(moved)
        contact, p, single = np.zeros((N, 4, 5)), np.zeros((N, 2)), np.zeros((4, 5))
        contact[:, a] = contact[:, b] = state.contact[:, 0]
        contact[:, b, 1:3] *= -1.0
        geometry, closure, drawn, tiny = problem.geometry, problem.closure, problem.drawn, self.given.contacts.tiny
        for i in range(N):  # the ball's centre follows from the motions of both flanks
            ball = geometry[i], closure[i], RIGID, drawn.ball_radius[i], drawn.profile
            self.engine.settle_ball(p[i], moved[i].copy(), *ball, tiny, single)
        return (ContactState(problem, contact, p, moved),)

    def forces(self) -> Array:
        """Return the forces of the balls on all flanks ``(N, 4, 2)`` [N]."""
        pair, contact = self.pair, self.state.contact
        pushes = contact[..., 0, None] * contact[..., 1:3]
        if pair is None:
            return np.asarray(pushes)
        out = np.zeros((contact.shape[0], 4, 2))
        out[:, pair[0]], out[:, pair[1]] = pushes[:, 0], -pushes[:, 0]
        return out

    def shifts(self) -> Array:
        """Return the motions of the four flanks ``(N, 4, 2)`` [m] in the present state; zero for a flank without contacts.

        The last axis holds two components in the ball's section plane, radial and along the helix's binormal.
        """
        screw, nut, v0, R = self.bodies.kept
        forces = self.forces()
        N, out = len(forces), np.zeros(forces.shape)
        for G, sides in ((screw, (0, 1)), (nut, (2, 3))):
            used = [s for s in sides if self.problem.use[s]]
            out[:, used] = (G @ forces[:, used].ravel()).reshape(N, len(used), 2)
        out[:, :2] += v0 + R @ self.state.a
        return out

    def round_off(self) -> float:
        """Return the relative residual that rounding errors leave, from the largest motion and the stiffest contact."""
        problem, v0 = self.problem, self.given.bodies.v0
        stiff = float(contact_stiffness_under_force(self.state.contact[..., 0], problem.C.min()).max(initial=0.0))
        motion = float(np.abs(self.shifts()).max()) + float(np.abs(v0).max(initial=0.0))
        return least_residual(motion, stiff, self.scale, [problem])

    def clears(self) -> bool:
        """Return whether every ball is at least ``MARGIN`` away from all flanks that were left out.

        A flank that was left out is taken to move like the other flank of the same groove. ``MARGIN`` covers the
        elastic deformation between the two.
        """
        problem, contact, p, shift = self.flanks()[0]
        for s in np.flatnonzero(~problem.use):
            shift[:, s] = shift[:, int(s) ^ 1]
        force = contact[None, ..., 0]
        return bool(
            solutions_clear_of_left_out_flanks(p[None], shift[None], problem.geometry[None], force, problem.use, MARGIN)[0]
        )

    def solved(self) -> SolvedState:
        """Return the solution: motions, contact forces and support reactions.

        Motions of the beam's nodes and reactions are no unknowns of the equations; they follow from the contact forces.
        """
        problem, squeeze = self.problem, self.bodies.squeeze
        used = [s for s in range(2) if problem.use[s]]
        pushes = self.forces()[:, used].transpose(1, 0, 2).reshape(-1, 2)
        by_flanks = nodal_loads_of_flank_forces(problem, pushes, used)
        if squeeze is not None:
            by_flanks += squeeze.nodal_loads_of_jumps(pushes.ravel())
        motion, nodal = node_motions(self.shaft, by_flanks, self.state.a), np.zeros((problem.nodes.size, 6))
        if problem.basis is None:
            nodal = node_forces(self.shaft, by_flanks) - problem.load - by_flanks.reshape(-1, 6)
        if squeeze is not None:
            motion = squeeze.add_jumps_inside_stretches(motion, pushes, problem.fixed)
        held = np.where(problem.fixed, nodal, 0.0)
        scale = max(self.scale, float(np.abs(held[:, :3]).max(initial=0.0)))
        _, contact, centre, shifts = self.flanks()[0]
        return SolvedState(problem, motion, centre, contact[..., 0], contact[..., 1:3], held, shifts, scale)

    def description(self) -> ModelDescription:
        """Return the formulation, number of unknowns and assumptions of the model for the record of the solution.

        It states how much negative compliance of the bodies was set to zero to make the compliance matrix positive.
        """
        build, clipped = self.build, self.bodies.clipped
        assert isinstance(build, ElasticInput)
        source = (
            idealisation_statements(build.backend, build.scene)
            if build.condensed is None
            else (build.condensed.describe_source(),)
        )
        size = self.state.phi.size + self.state.a.size
        cut = (f"negative compliance of the bodies, up to {100 * clipped:.2g} % of a contact's, is set to zero",)
        assumed = (*ELASTIC_ASSUMPTIONS, *source, *self.assumed)
        return ModelDescription(CONDENSED, size, assumed, cut if clipped > 1e-6 else ())


@dataclass(frozen=True, kw_only=True)
class ElasticInput(StaticInput):
    """Input from which a ball screw's static problem with elastic bodies is built, also with other flanks."""

    #: Method by which the compliance of screw, nut and balls is computed.
    backend: Backend = REFINED
    #: Compliance of the bodies condensed from a 3D model, in place of a computed one; None: computed.
    condensed: Condensed | None = None
    #: Function that computes the compliance of one complete screw or nut between its contacts.
    whole: WholeBody = compliance_between_contacts

    @property
    def section(self) -> BeamSection | None:
        """Return the screw's cross-section with its groove, if the ``backend`` computes one; None: a plain section is used.

        The plain section follows from the scene's dimensions.
        """
        return grooved_section(reduce_to_compliance_geometry(self.scene), True) if self.backend.section == "cell" else None

    def ready(self, problem: Problem) -> ElasticEquations:
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
        response = response_of(problem, self.layout, self.backend, self.condensed, self.whole)
        shaft, ball, scale = response.shaft.under(problem), response.ball, residual_scale(problem)
        flanks, pair, drawn = flanks_of(problem, scale.typical, shaft, response), only_flank_pair(problem), problem.drawn
        local, rows = np.zeros((N, 4, 3)), np.zeros((N, 7))
        local[..., 0], local[..., 2] = flanks.e, flanks.h
        local[..., 1] = ball.g * np.array([1.0, ball.sign, ball.sign, 1.0])
        if pair is not None:  # only one diagonal pair of flanks: no other pair that the ball could couple it with
            local[..., 0] += 2.0 * ball.g**2
            rows = pair_data(problem, pair, local[..., 0], flanks.h)
        balls = problem.geometry, problem.closure, local, drawn.ball_radius, np.repeat(drawn.profile[None], N, axis=0)
        v0, k = flanks.bodies.v0, flanks.bodies.work.size
        options = solver_options(scale, problem.scene.track.pitch_radius, float(drawn.ball_radius.max()))
        springs = spring_rows(problem, pair, options.stiffness)
        return ElasticEquations(
            engine=self.engine,
            given=BodySystem(flanks.bodies, BallContacts(*balls, rows, NO_ROLLERS, scale.none), springs),
            state=ForceState(np.zeros(v0.shape), np.zeros(k), np.zeros((N, 3)), np.zeros((N, 1 if pair else 4, 5))),
            options=options,
            problem=problem,
            build=self,
            shaft=shaft,
            bodies=flanks,
            assumed=response.assumed,
        )

    def touched(self) -> str:
        """Return the note for the result that balls may touch left-out flanks, so that all four flanks were solved."""
        return "two of the four flanks may touch balls in the solution without them: solved again with all four flanks"


def solve_elastic(
    scene: Scene,
    *,
    backend: Backend = REFINED,
    condensed: Condensed | None = None,
    name: str = "refined",
    engine: Engine = "auto",
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
    drawn = draw_specimen(scene, layout, member)
    uneven = drawn.profile.shape[1] > 0
    kernels = pick_engine(engine, layout.z.size, uneven)
    use = flanks_of_scene(scene) if everything or uneven else choose_sides(scene, drawn)
    parts = scene, drawn, layout, use, kernels, everything, refine
    return solve_built(ElasticInput(*parts, backend=backend, condensed=condensed), name, start)


class ElasticMembers:
    """Solver for specimens of a ball screw that differ only in the random radii of their balls and so share equations.

    The function `shared` returns whether the specimens of a scene differ in nothing else.
    """

    def __init__(self, scene: Scene, backend: Backend, engine: ModuleType, like: ElasticMembers | None = None) -> None:
        """Store the scene; the equations are built when the first specimen is solved.

        Parameters
        ----------
        scene
            Screw, nut and balls with random errors, supports and loads.
        backend
            Method by which the compliance of screw, nut and balls is computed.
        engine
            Module of the numerical kernels.
        like
            The same specimens under nearly the same loads, solved before; their solutions are the starts of the iteration.
            None: each specimen starts from the solution of specimen 0.
        """
        self.scene, self.backend, self.engine, self.like = scene, backend, engine, like
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
        drawn = draw_specimens(self.scene, self.layout, first, count)
        offset, closure = centre_distances(self.scene, drawn)
        nominal = draw_specimen(scene_without_random_errors(self.scene), self.layout)
        C = hertz_C(self.scene, nominal, drawn.ball_radius)
        loads, numbers = np.full((count, self.layout.z.size, 4), np.nan), np.full((2, count), np.nan)
        self._states.clear()
        for k in range(count):
            dims = drawn.ball_radius[k], offset[k], closure[k], C[k]
            use = choose_sides(self.scene, nominal, dims[1:3])
            solved = self._solve_specimen(first + k, use, dims)
            if solved is None and not np.array_equal(use, flanks_of_scene(self.scene)):
                solved = self._solve_specimen(first + k, flanks_of_scene(self.scene), dims)
            if solved is not None:
                loads[k], numbers[:, k] = solved[0], solved[1:]
        return loads, *numbers

    def _solve_specimen(
        self, number: int, use: Mask, dims: tuple[Array, Array, Array, Array]
    ) -> tuple[Array, float, float] | None:
        """Solve one specimen with contacts on the flanks in ``use``; return None if that fails.

        Parameters
        ----------
        number
            Number of the specimen.
        use
            Which of the flanks SL, SR, NL, NR have contacts ``(4,)``.
        dims
            Ball radii, distances of ball and groove centres, interferences and Hertz constants of the specimen: the first
            four arguments of `_SharedEquations.solve`, whose result is returned.
        """
        system, key = self._equations_for_flanks(use), (number, use.tobytes())
        if system is None:
            return None
        solved = system.solve(*dims, start=None if self.like is None else self.like._states.get(key))
        if solved is not None:
            self._states[key] = [array.copy() for array in system.elastic.state]
        return solved

    def _equations_for_flanks(self, use: Mask) -> _SharedEquations | None:
        """Return the equations with contacts on the flanks in ``use``, solved for specimen 0, for use by other specimens.

        If balls of specimen 0 touch a flank that was left out, the equations have all four flanks. None if specimen 0 has
        no solution or its equations fit no other specimen.
        """
        key = use.tobytes()
        if key not in self._systems:
            self._systems[key] = None
            drawn = draw_specimen(self.scene, self.layout)
            solved = solve_with_chosen_flanks(
                ElasticInput(self.scene, drawn, self.layout, use, self.engine, backend=self.backend)
            )
            if isinstance(solved, Solution) and solved.outcome.status == CONVERGED:
                elastic = solved.system
                if isinstance(elastic, ElasticEquations) and elastic.bodies.lent == 0.0:
                    self._systems[key] = _SharedEquations(elastic)
        return self._systems[key]


def shared(scene: Scene) -> bool:
    """Return whether all specimens of a scene can be solved with the same equations (`ElasticMembers`).

    This requires that they differ only in the radii of their balls, that Hertz constants are not updated in the iteration,
    and that the screw is not rigid.

    Parameters
    ----------
    scene
        Scene with random errors.
    """
    alike = have_equal_circular_grooves(scene) and len(draw_specimens(scene, ball_layout(scene), 0, 2).centre) == 1
    return alike and scene.ingredients.hertz != "actual" and scene.ingredients.screw != "rigid"


class _SharedEquations:
    """Equations of one solved specimen with elastic bodies, into which the ball radii of other specimens are written."""

    def __init__(self, elastic: ElasticEquations) -> None:
        """Store solved equations, whose solution is the start of the iteration for other specimens.

        ``elastic``: the equations. The coefficients of the contact law, which depend on the typical contact force, and of
        the work of the external loads are stored too.
        """
        self.elastic = elastic
        self.start = [array.copy() for array in elastic.state]
        self.local = elastic.given.contacts.local.copy()
        self.size = float(np.cbrt(residual_scale(elastic.problem).typical))
        self.by_pushes, self.by_motions, self.at_rest = _external_work_coefficients(elastic)

    def solve(
        self, radii: Array, offset: Array, closure: Array, C: Array, start: list[Array] | None
    ) -> tuple[Array, float, float] | None:
        """Compute the contact loads of one specimen.

        Parameters
        ----------
        radii
            Radii of its balls ``(N,)`` [m].
        offset, closure
            Distances ``(N, 4, 4)`` [m] of ball and groove centres, and interferences ``(N, 2)`` [m], from
            `centre_distances`.
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
        outcome = elastic.iterate(False)
        if outcome.status not in (CONVERGED, ITERATIONS):
            return None
        if outcome.residual > ACCEPTED and outcome.residual > elastic.round_off():
            return None
        whole = np.array_equal(elastic.problem.use, flanks_of_scene(elastic.problem.scene))
        if not whole and (outcome.status != CONVERGED or not elastic.clears()):
            return None
        contact = elastic.state.contact
        loads = np.zeros(offset.shape[:2])
        loads[:, slice(None) if elastic.pair is None else elastic.pair] = contact[..., 0]
        on_screw = elastic.forces()[:, [s for s in (0, 1) if elastic.problem.use[s]]].swapaxes(0, 1).ravel()
        work = float(self.by_pushes @ on_screw + self.by_motions @ elastic.state.a) + self.at_rest
        return loads, outcome.residual, work

    def _write_specimen(self, radii: Array, offset: Array, closure: Array, C: Array) -> None:
        """Write ball radii, interferences and contact laws of a specimen into the kernels' arrays.

        ``radii`` ``(N,)``: ball radii [m]; ``offset``, ``closure``: result of `centre_distances` (vectors from groove to
        ball centres, interferences); ``C`` ``(N, 4)``: Hertz constants.
        """
        elastic, problem = self.elastic, self.elastic.problem
        problem.geometry[..., :4], problem.geometry[..., 4] = offset, C
        problem.closure[:], problem.drawn.ball_radius[:] = closure, radii
        scale, slope = residual_scale(problem), elastic.bodies.slope
        size = float(np.cbrt(scale.typical))
        local = elastic.given.contacts.local
        local[:] = self.local
        local[..., 0] += slope * np.log(size / self.size)
        local[..., 2] += slope * (1.0 / size - 1.0 / self.size)
        if elastic.pair is not None:
            elastic.given.contacts.pair[:] = pair_data(problem, elastic.pair, local[..., 0], local[..., 2])
        elastic.given = elastic.given._replace(contacts=elastic.given.contacts._replace(tiny=scale.none))
        elastic.options = elastic.options._replace(floor=scale.floor, furthest=float(radii.max()))


def _external_work_coefficients(elastic: ElasticEquations) -> tuple[Array, Array, float]:
    """Return the coefficients of a linear function for the work [J] of the external loads on their points of action.

    Variables of the function are contact forces and free rigid motions, which no support prevents. Entries: derivative of
    the work by the forces of the balls on the c screw flanks ``(2 c,)`` [J/N], derivative by the amplitudes of the k free
    motions ``(k,)`` [N], and constant part [J].
    """
    problem, shaft, squeeze = elastic.problem, elastic.shaft, elastic.bodies.squeeze
    load = problem.load.ravel()
    dof, rows = flank_motion_coefficients(problem, [s for s in range(2) if problem.use[s]])
    by_flanks = np.zeros((load.size, 2 * len(rows)))
    for c in range(len(rows)):
        by_flanks[dof[c], 2 * c], by_flanks[dof[c], 2 * c + 1] = rows[c]
    given, inside = np.zeros(load.size), np.zeros(by_flanks.shape[1])
    if squeeze is not None:
        by_flanks += squeeze.wrenches.T @ squeeze.jumps
        given = squeeze.wrenches.T @ squeeze.given
        inside = squeeze.inside.by_loads(np.where(problem.fixed, 0.0, problem.load).reshape(-1, 1))[:, 0]
    moved = node_motions(shaft, given, np.zeros(elastic.state.a.size)).ravel()
    return load @ shaft.solve(by_flanks) + inside, load @ nodal_motions_of_rigid_screw(shaft), float(load @ moved)
