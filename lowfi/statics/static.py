"""Lin's model (2019, chapter 2) of a ball screw's static load distribution, as the minimum of a convex energy.

Misprints of the thesis are corrected.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from time import perf_counter
from types import ModuleType
from typing import Any, Literal, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi import jit
from rollbench.lowfi.hertz import contact_force, contact_stiffness_under_force
from rollbench.lowfi.statics import held, kernel_types, selection, settle
from rollbench.lowfi.statics import problem as statics_problem
from rollbench.lowfi.statics.held import UnresistedMotions, find_unresisted_motions
from rollbench.lowfi.statics.problem import Problem, SolvedState, build_problem, largest_interference
from rollbench.lowfi.statics.result import StaticResult, Status
from rollbench.lowfi.statics.shape import initial_motions_with_supports
from rollbench.lowfi.statics.summary import assemble_result, failed_result, model_assumptions
from rollbench.meshes.arrays import Array, Mask
from rollbench.meshes.errors import GeometryWithErrors, draw_geometry_with_errors
from rollbench.meshes.helix import BallLayout, ball_layout
from rollbench.meshes.parts import FREEDOMS, SIDES, Scene
from rollbench.meshes.section import BeamSection

#: Choice of the numerical kernels: plain Python, compiled by numba, or chosen by the size of the problem.
Engine = Literal["auto", "interpreted", "compiled"]

#: Number of balls above which the compiled kernels are faster even for a single solve: if their machine code is cached on
#: disk, and if it has to be compiled first.
COMPILE_ABOVE, COMPILE_ALONE = 120, 1000
#: Number of balls above which the compiled kernels are faster for flanks that are not circular arcs, where an iteration
#: finds each contact point.
COMPILE_UNEVEN = 24
#: Reaction at a pin (a degree of freedom fixed without a support) above which it is reported, as a share of the largest
#: force or moment.
PIN_SHOWN = 1e-9


def pick_engine(engine: Engine, balls: int, uneven: bool = False) -> ModuleType:
    """Return the module of numerical kernels: interpreted for a small problem, compiled for a large one.

    Parameters
    ----------
    engine
        ``"interpreted"``, ``"compiled"``, or ``"auto"``: compiled if there are many balls, or if the compiled kernels are
        loaded already.
    balls
        Number of balls.
    uneven
        Whether flanks deviate from circular arcs, so that each contact point needs an iteration.
    """
    most = COMPILE_UNEVEN if uneven else COMPILE_ABOVE
    many = balls > most and (uneven or balls > COMPILE_ALONE or jit.is_machine_code_cached(jit.STATICS))
    fast = engine == "compiled" or (engine == "auto" and (jit.is_copy_loaded(jit.STATICS) or many))
    return jit.load_kernel_package(jit.STATICS, compiled=fast)


def residual_scale(problem: Problem) -> settle.ResidualScale:
    """Return the typical force and stiffness of a problem's contacts, by which the solver scales residuals.

    A contact counts as unloaded if its force is below a limit: the round-off of the typical force. If there are prescribed
    displacements, but neither loads nor preload, perhaps no contact resists the displacements and all contact forces tend
    to zero. The limit is then higher, so that such contacts count as unloaded.

    Parameters
    ----------
    problem
        Arrays of the static problem.
    """
    arm, load = problem.scene.track.pitch_radius, np.abs(problem.load)
    pair = float((problem.C[:, 0] + problem.C[:, 3]).sum()) / problem.C.shape[0] if problem.C.size else float("nan")
    squeeze = float(contact_force(largest_interference(problem), pair))
    (applied, turning), (largest, most) = ((x[:3], x[3:]) for x in (load.sum(axis=0), load.max(axis=0)))
    force = max(float(applied.sum() + turning.sum() / arm) / max(1, problem.C.shape[0]), squeeze)
    if force == 0.0:  # only prescribed displacements, or errors by which three flanks clamp a ball
        force = float(contact_force(1e-6, pair))
    floor = max(float(largest.max()), float(most.max()) / arm, squeeze)
    return settle.ResidualScale(force, float(np.cbrt(force) / pair), floor, (1e-14 if floor > 0.0 else 1e-10) * force)


@dataclass(kw_only=True)
class SingleNutEquations(settle.StaticEquations):
    """Equations of one ball nut or ball bearing for the numerical kernels: base class for rigid and for elastic bodies."""

    #: Arrays of the static problem.
    problem: Problem
    #: Input of the problem, from which it is built again if the lever arms of the contacts change.
    problem_input: StaticInput

    @property
    def problems(self) -> Sequence[Problem]:
        """Return the contact problem of the nut or bearing, in a sequence of length one."""
        return (self.problem,)

    def with_lever_arms(self, arms: Sequence[Array]) -> Self:
        """Return equations with new lever arms of the contact forces, and with the present unknowns as initial values.

        ``arms``: sequence of one array ``(N, 4, 2)`` [m], the shifts of the flanks' centres of curvature by profile errors:
        N balls, four flanks (screw left, screw right, nut left, nut right), radial and along the helix's binormal. Contact
        forces act through these centres.
        """
        longer: Any = self.problem_input.build_equations(self.problem_input.build_problem(arms[0]))
        longer.problem.C[:] = self.problem.C
        return longer.copy_state_from(self)  # type: ignore[no-any-return]

    @abstractmethod
    def are_balls_clear_of_left_out_flanks(self) -> bool:
        """Return whether no ball of the solution touches a flank that was left out of the equations."""

    @abstractmethod
    def solved_state(self) -> SolvedState:
        """Return the solution: motions, contact forces and support reactions."""


@dataclass(kw_only=True)
class BeamEquations(SingleNutEquations):
    """Equations of Lin's model for the numerical kernels: a beam or rigid screw on Hertzian contacts in a rigid nut."""

    SOLVER = "solve_beam"
    #: Arrays of beam and balls for the kernels.
    kernel_arrays: kernel_types.BeamSystem
    #: Node motions, element deformations and contacts: the unknowns of the iteration.
    state: kernel_types.MotionState

    @property
    def contact_forces(self) -> Array:
        """Return the present contact forces of N balls on the four flanks ``(N, 4)`` [N].

        The flanks are screw left, screw right, nut left, nut right.
        """
        return np.asarray(self.state.contact[..., 0])

    def contact_states(self) -> Sequence[settle.ContactState]:
        """Return contact forces, ball centres and flank motions, as the iteration has them now."""
        moved = np.zeros((len(self.state.p), 4, 2))
        moved[:, :2] = selection.screw_flank_motions(self.problem, self.state.q)
        return (settle.ContactState(self.problem, self.state.contact, self.state.p, moved),)

    def are_balls_clear_of_left_out_flanks(self) -> bool:
        """Return whether no ball of the solution touches a flank that was left out of the equations.

        For this check, the equilibrium of every ball is computed with all four flanks, while the screw keeps the motion of
        the solution.
        """
        touched = selection.touched_flanks(self.engine, self.problem, self.state.q, self.state.p, self.contact_forces)
        return not np.any(touched & ~self.problem.used_flanks)

    def round_off_residual(self) -> float:
        """Return the relative residual that rounding errors leave at the solution.

        It follows from the largest motion of a node, and the largest sum of contact stiffnesses at one node.
        """
        problem, motion = self.problem, float(np.abs(self.state.q[:, :3]).max(initial=0.0))
        stiff = contact_stiffness_under_force(self.contact_forces[:, :2], problem.C[:, :2])
        most = float(np.bincount(problem.first_nodes.ravel(), weights=stiff.ravel()).max(initial=0.0))
        return settle.residual_by_round_off(motion, most, self.residual_force_scale, [problem])

    def solved_state(self) -> SolvedState:
        """Return the solution: motions, contact forces and support reactions.

        The reactions are the gradient of the energy at the fixed degrees of freedom.
        """
        problem, gradient, force = self.problem, np.zeros(self.state.q.shape), self.contact_forces.copy()
        motion, centre, normal = self.state.q.copy(), self.state.p.copy(), self.state.contact[..., 1:3].copy()
        if problem.rigid_motion_basis is None:
            derivatives = kernel_types.EnergyDerivatives(gradient, np.zeros((len(problem.C), 4, 4)))
            self.engine.evaluate_screw(self.kernel_arrays, self.state, derivatives)
        held = np.where(problem.fixed, gradient, 0.0)
        flanks = selection.all_flank_motions_by_screw(problem, motion)
        return SolvedState(problem, motion, centre, force, normal, held, flanks, self.residual_force_scale)

    def model_description(self) -> settle.ModelDescription:
        """Return the formulation, number of unknowns and assumptions of the model for the record of the solution."""
        return settle.ModelDescription("convex energy", self.problem.unknowns, model_assumptions(self.problem.scene))


def beam_equations(
    problem: Problem, engine: ModuleType, *, tolerance: float = settle.TOLERANCE, problem_input: StaticInput | None = None
) -> BeamEquations:
    """Return the equations of a screw in a rigid nut; the initial motions satisfy the supports' prescribed displacements.

    Parameters
    ----------
    problem
        Arrays of the static problem.
    engine
        Module of the numerical kernels, interpreted or compiled.
    tolerance
        Relative residual at which the iteration ends.
    problem_input
        Input from which the problem was built; None: assembled from the scene, errors, balls and flanks of ``problem``.
    """
    lengths, s = np.diff(problem.nodes), problem.section
    sections = np.tile([s.EA, s.EI, s.GJ, s.kGA], (lengths.size, 1))
    count, scale, drawn = problem.C.shape[0], residual_scale(problem), problem.drawn
    motions = initial_motions_with_supports(problem.nodes, problem.fixed, problem.prescribed)
    state = kernel_types.MotionState(*motions, np.zeros((count, 2)), np.zeros((count, 4, 5)), np.zeros((0, 2)))
    flanks = problem.first_nodes, problem.B, problem.geometry, problem.interference
    balls = drawn.ball_radii, drawn.profile_coefficients, scale.unloaded_force_limit
    constants, band = np.zeros((lengths.size, 5)), np.zeros((6 * problem.nodes.size, problem.half_bandwidth + 1))
    engine.assemble_beam_stiffness(lengths, sections, constants, band)
    shaft = kernel_types.BeamArrays(lengths, problem.fixed, problem.load, constants, band)
    given = kernel_types.BeamSystem(shaft, kernel_types.BeamContacts(*flanks, *balls))
    arm, furthest = problem.scene.track.pitch_radius, float(drawn.ball_radii.max())
    options = settle.solver_options(scale, arm, furthest, tolerance)
    problem_input = problem_input or StaticInput(problem.scene, drawn, problem.layout, problem.used_flanks, engine)
    return BeamEquations(
        engine=engine, kernel_arrays=given, state=state, options=options, problem=problem, problem_input=problem_input
    )


@dataclass(frozen=True)
class StaticInput:
    """Input from which a ball screw's static problem is built, and can be built again.

    It is built again with contacts on other flanks, with other fixed degrees of freedom, or with other lever arms of the
    contact forces.
    """

    #: Scene: screw, nut, balls, supports and loads.
    scene: Scene
    #: Dimensions of screw, nut and balls with their manufacturing errors.
    drawn: GeometryWithErrors
    #: Positions of the balls.
    layout: BallLayout
    #: Which of the four flanks (screw left, screw right, nut left, nut right) get contacts ``(4,)``.
    used_flanks: Mask
    #: Module of the numerical kernels.
    engine: ModuleType
    #: Whether to model also flanks that cannot touch a ball, and ends of the shaft that carry no load.
    everything: bool = False
    #: Number of elements that each beam element is split into.
    refine: int = 1
    #: Result of `centre_vectors_and_interference` for these dimensions; None: not computed yet.
    known: tuple[Array, Array] | None = None
    #: Three entries: which degrees of freedom of the n nodes are fixed ``(n, 6)``; their prescribed values ``(n, 6)`` [m,
    #: rad]; and the "pins", numbers of the degrees of freedom of the first node that are fixed although no support fixes
    #: them. None: only those degrees of freedom are fixed that the scene's supports fix.
    fixed_dofs: tuple[NDArray[np.bool_], Array, tuple[int, ...]] | None = None

    @property
    def replacement_section(self) -> BeamSection | None:
        """Return the screw's cross-section that replaces the one computed from the scene's dimensions; None: none does."""
        return None

    def build_problem(self, arms: Array | None = None) -> Problem:
        """Return the arrays of the static problem.

        Parameters
        ----------
        arms
            Shifts of the flanks' centres of curvature by profile errors ``(N, 4, 2)`` [m], None for zero: N balls, four
            flanks (screw left, screw right, nut left, nut right), radial and along the helix's binormal.
        """
        parts = self.scene, self.drawn, self.layout, self.used_flanks
        how: dict[str, Any] = {"everything": self.everything, "refine": self.refine, "known": self.known}
        found = build_problem(*parts, arms=arms, section=self.replacement_section, **how)
        held = self.fixed_dofs
        return found if held is None else replace(found, fixed=held[0], prescribed=held[1], pins=held[2])

    def with_supports_of(self, pinned: Problem) -> Self:
        """Return a copy of this input with the fixed degrees of freedom of the problem ``pinned``.

        Pins, which are fixed although no support fixes them, are included.
        """
        return replace(self, fixed_dofs=(pinned.fixed, pinned.prescribed, pinned.pins))

    def build_equations(self, problem: Problem) -> SingleNutEquations:
        """Return the equations of the problem for the numerical kernels, with an initial state."""
        return beam_equations(problem, self.engine, problem_input=self)

    def note_on_touched_flanks(self) -> str:
        """Return the note for the result that balls touched left-out flanks, so that all four flanks were solved."""
        names = ", ".join(name for name, used in zip(SIDES, self.used_flanks, strict=True) if not used)
        return f"flanks {names} touch balls in the solution without these flanks: solved again with all four flanks"


#: Note for the result that no equilibrium was found without some of the flanks.
UNSOLVED_WITHOUT_FLANKS = "no equilibrium was found with only some of the four flanks: solved again with all of them"


class SolvedEquations(NamedTuple):
    """Equations of a ball screw at the state where the solver ended, converged or not, with notes on left-out flanks."""

    #: Equations, with the state at which the solver ended.
    system: SingleNutEquations
    #: Status, residual and effort of the solver.
    outcome: kernel_types.Outcome
    #: Input from which the equations were built.
    build: StaticInput
    #: Rigid motions of the screw that neither supports nor contacts resist, with the degrees of freedom ("pins") that the
    #: model fixes to prevent them.
    mechanism: UnresistedMotions
    #: Notes on the flanks that were left out.
    notes: tuple[str, ...]
    #: Time at which the iteration could begin (`time.perf_counter`) [s].
    prepared_at: float

    @property
    def status(self) -> Status:
        """Return the status of the solve: "converged", or else the kind of failure with its reason."""
        prove = partial(status_of_runaway_screw, self.system.problem)
        return settle.status_of_solve(self.outcome, self.system.round_off_residual(), prove)


class UnrestrainedProblem(NamedTuple):
    """Static problem without equilibrium, because its load drives a motion of the screw that nothing resists."""

    #: Arrays of the static problem.
    problem: Problem
    #: The motion that the load drives.
    unresisted_motions: UnresistedMotions

    @property
    def status(self) -> Status:
        """Return the status "not held" with a sentence that describes the motion."""
        return Status("not held", self.unresisted_motions.description)


def solve_with_chosen_flanks(problem_input: StaticInput) -> SolvedEquations | UnrestrainedProblem:
    """Solve a ball screw with contacts on the chosen flanks, and if need be again with all flanks.

    It is solved again if the solver fails, or if a ball of the solution touches a flank that was left out.

    Parameters
    ----------
    problem_input
        Input of the problem; its field ``used_flanks`` tells on which flanks there are contacts in the first solve.

    Returns
    -------
    SolvedEquations | UnrestrainedProblem
        The equations at the state where the solver ended, converged or not; `UnrestrainedProblem` if the load drives a
        motion that nothing resists, so that nothing was solved.
    """
    notes: tuple[str, ...] = ()
    while True:
        problem = problem_input.build_problem()
        mechanism = find_unresisted_motions(problem)
        if mechanism.is_driven_by_loads:
            return UnrestrainedProblem(problem, mechanism)
        problem = pin_free_motions(problem, mechanism)
        system = problem_input.with_supports_of(problem).build_equations(problem)
        prepared_at = perf_counter()
        system, outcome = settle.solve_with_updated_contacts(system)
        every, good = selection.flanks_of_scene(problem_input.scene), outcome.status == 0
        whole = np.array_equal(problem_input.used_flanks, every)
        if whole or (good and system.are_balls_clear_of_left_out_flanks()):
            return SolvedEquations(system, outcome, problem_input, mechanism, notes, prepared_at)
        notes = (problem_input.note_on_touched_flanks() if good else UNSOLVED_WITHOUT_FLANKS,)
        problem_input = replace(problem_input, used_flanks=every)


def solve_static(
    scene: Scene,
    *,
    engine: Engine = "auto",
    everything: bool = False,
    member: int = 0,
    refine: int = 1,
    discretisation: bool = False,
) -> StaticResult:
    """Compute contact loads, contact angles and shaft motion of a ball screw in static equilibrium, by Lin's model.

    The screw is a Timoshenko beam, or rigid. The nut is rigid, and every contact follows Hertz's law. The equilibrium is
    the minimum of a convex energy.

    Parameters
    ----------
    scene
        Screw, nut, balls, supports and loads.
    engine
        Numerical kernels: ``"interpreted"``, ``"compiled"``, or ``"auto"``, which chooses by the number of balls.
    everything
        Whether to model also flanks that cannot touch a ball, and ends of the shaft that carry no load.
    member
        Number of the specimen, for a scene with random errors: each number gives other errors.
    refine
        Number of elements that each beam element is split into.
    discretisation
        Whether to estimate the error of the beam's discretisation too.

    Returns
    -------
    StaticResult
        Loads, angles and motions; if there is no equilibrium, ``status`` gives the reason.

    Raises
    ------
    UnfitKey
        If keys of the scene contradict each other or the model cannot represent them.

    References
    ----------
    Lin (2019), equations 2.23 to 2.25.

    Examples
    --------
    >>> import rollbench
    >>> result = solve_static(rollbench.read("lin-case1"))
    >>> result.status, result.load.shape, round(float(result.load.max()), 1)
    ('converged', (32, 4), 243.4)
    """
    start = perf_counter()
    layout = ball_layout(scene)
    drawn = draw_geometry_with_errors(scene, layout, member)
    kernels = pick_engine(engine, layout.z.size, drawn.profile_coefficients.shape[1] > 0)
    known = statics_problem.centre_vectors_and_interference(scene, drawn)
    use = selection.flanks_of_scene(scene) if everything else selection.choose_flanks(scene, drawn, known)
    build = StaticInput(scene, drawn, layout, use, kernels, everything, refine, known)
    result = solve_static_input(build, "lin", start)
    if discretisation and result.converged:
        result = with_discretisation_error(scene, result, partial(solve_static, engine=engine, member=member))
    return result


def solve_static_input(problem_input: StaticInput, name: str, start: float) -> StaticResult:
    """Solve the static problem that an input describes, and return loads, motions and status.

    Parameters
    ----------
    problem_input
        Input of the problem; its class decides which bodies are elastic.
    name
        Name of the model in the result.
    start
        Time at which the computation began (`time.perf_counter`) [s].
    """
    solved = solve_with_chosen_flanks(problem_input)
    if isinstance(solved, UnrestrainedProblem):
        return failed_result(solved.problem, name, solved.status, perf_counter() - start)
    system, outcome, mechanism = solved.system, solved.outcome, solved.mechanism
    problem, status = system.problem, solved.status
    if outcome.status in settle.NO_LOADS:
        return failed_result(problem, name, status, perf_counter() - start)
    description = system.model_description()
    report = settle.solver_report(
        outcome, system, description, problem.nodes.size - 1, (start, solved.prepared_at), solved.notes
    )
    left_out = selection.describe_left_out_parts(problem, mechanism, everything=problem_input.everything)
    texts = (*left_out, *description.left_out), description.assumed
    return with_note_on_pins(assemble_result(system.solved_state(), name, status, report, *texts), solved)


def with_note_on_pins(result: StaticResult, solved: SolvedEquations) -> StaticResult:
    """Return the result with a note on how much the contact loads depend on the choice of pins.

    A pin is a degree of freedom that the model fixes because neither load nor support determines it. The result is returned
    unchanged if the pins carry no noticeable reaction, if there are no other degrees of freedom to pin, or if it has not
    converged.

    Parameters
    ----------
    result
        Result of the solve with the first choice of pins.
    solved
        Solved equations, with the motions that nothing resists and the degrees of freedom that could be pinned instead.
    """
    balance, mechanism = result.equilibrium, solved.mechanism
    if balance is None or balance.pin_share <= PIN_SHOWN or not result.converged or not mechanism.alternative_pins:
        return result
    again = pin_free_motions(solved.build.build_problem(), mechanism, True)
    equations = solved.build.with_supports_of(again).build_equations(again)
    other, found = settle.solve_with_updated_contacts(equations, follow_profile_errors=False)
    pins, others = (" and ".join(FREEDOMS[k] for k in x) for x in (mechanism.pins, mechanism.alternative_pins))
    words = f"{mechanism.description} is prevented by fixing {pins} of the first node; if {others} is fixed instead, "
    if settle.is_solve_unusable(found):
        words += "the solver finds no equilibrium"
    else:
        change = float(np.abs(other.contact_states()[0].contacts[..., 0] - result.load).max())
        words += f"contact loads change by up to {change:.2g} N (largest load {result.load.max():.4g} N)"
    return replace(result, solver=replace(result.solver, notes=(*result.solver.notes, words)))


def pin_free_motions(problem: Problem, mechanism: UnresistedMotions, use_alternative_pins: bool = False) -> Problem:
    """Return the problem with "pins": degrees of freedom fixed against motions that nothing resists and no load drives.

    If no contact can twist the shaft, its torsion is fixed too.

    Parameters
    ----------
    problem
        Arrays of the static problem.
    mechanism
        Motions that nothing resists, and the degrees of freedom that can be pinned.
    use_alternative_pins
        Whether to pin the degrees of freedom ``mechanism.alternative_pins`` instead of the first choice
        ``mechanism.pins``.
    """
    chosen = mechanism.alternative_pins if use_alternative_pins else mechanism.pins
    if not mechanism.pins and not mechanism.no_torsion:
        return problem
    fixed, prescribed = problem.fixed.copy(), problem.prescribed.copy()
    for k in chosen:
        fixed[0, k] = True
    if mechanism.no_torsion and problem.rigid_motion_basis is None:
        held = np.flatnonzero(problem.fixed[:, 5])
        if held.size:  # an untwisted shaft turns as a whole, and in proportion to its length between two supports
            prescribed[:, 5] = np.interp(problem.nodes, problem.nodes[held], prescribed[held, 5])
        fixed[:, 5] = True
    return replace(problem, fixed=fixed, prescribed=prescribed, pins=chosen)


def status_of_runaway_screw(problem: Problem) -> Status:
    """Return the status of a solve in which the screw moved without limit in the Newton iteration.

    The status is "not held" only if a linear program proves that contacts and supports cannot carry the load; otherwise it
    is "not converged". ``problem``: the static problem that was iterated.
    """
    opens = "the load opens every contact that could carry it, so the screw moves without limit (linear program: {})"
    search = partial(held.find_opening_motion, problem)
    return held.status_of_runaway_body(search, "the screw", lambda x: opens.format(held.describe_motion(x)))


def with_discretisation_error(scene: Scene, result: StaticResult, solve: Callable[..., StaticResult]) -> StaticResult:
    """Return the result with an estimate of the beam's discretisation error: the largest change of a contact load [N].

    If the scene's ``partition`` is "nodal" (a beam node at every contact), the result is compared with a solution on
    elements of half the length. With any other partition it is compared with the solution of the nodal partition.
    A rigid screw has the error zero.

    Parameters
    ----------
    scene
        Scene that was solved.
    result
        Result of the solve of this scene.
    solve
        Function that computes the result of a scene; its keyword ``refine`` gives the number of elements that each beam
        element is split into.
    """
    if scene.ingredients.screw == "rigid":
        return replace(result, solver=replace(result.solver, discretisation=0.0))
    nodal = replace(scene, ingredients=replace(scene.ingredients, partition="nodal"))
    other = solve(scene, refine=2) if scene.ingredients.partition == "nodal" else solve(nodal)
    change = float(np.abs(result.load - other.load).max())
    return replace(result, solver=replace(result.solver, discretisation=change))
