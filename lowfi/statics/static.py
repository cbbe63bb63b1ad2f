"""Static load distribution of one ball screw or bearing, by Lin's model (2019, chapter 2) and with elastic bodies.

The equilibrium is the minimum of a convex energy. Misprints of the thesis are corrected.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from time import perf_counter
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from rollbench.lowfi.compliance.parts import LADDER, REFINED, ComplianceModel
from rollbench.lowfi.statics import held, selection, settle
from rollbench.lowfi.statics.equations import SingleNutEquations, StaticInput
from rollbench.lowfi.statics.equilibrium import Outcome
from rollbench.lowfi.statics.held import UnresistedMotions, find_unresisted_motions
from rollbench.lowfi.statics.problem import Problem
from rollbench.lowfi.statics.result import StaticResult, Status
from rollbench.lowfi.statics.summary import assemble_result, failed_result
from rollbench.lowfi.together import Search, solve_alone
from rollbench.meshes.errors import GeometryWithErrors, draw_geometry_with_errors
from rollbench.meshes.helix import BallLayout, ball_layout
from rollbench.meshes.parts import FREEDOMS, Scene

if TYPE_CHECKING:
    from rollbench.lowfi.compliance.bodies import CondensedCompliance


#: Reaction at a pin (a degree of freedom fixed without a support) above which it is reported, as a share of the largest
#: force or moment.
PIN_SHOWN = 1e-9


#: Note for the result that no equilibrium was found without some of the flanks.
UNSOLVED_WITHOUT_FLANKS = "no equilibrium was found with only some of the four flanks: solved again with all of them"


class SolvedEquations(NamedTuple):
    """Equations of a ball screw at the state where the solver ended, converged or not, with notes on left-out flanks."""

    #: Equations, with the state at which the solver ended.
    system: SingleNutEquations
    #: Status, residual and effort of the solver.
    outcome: Outcome
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


def solve_with_chosen_flanks(problem_input: StaticInput) -> Search[SolvedEquations | UnrestrainedProblem]:
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
        system, outcome = yield from settle.solve_with_updated_contacts(system)
        every = selection.flanks_of_scene(problem_input.scene)
        good = settle.is_solve_accepted(outcome, system.round_off_residual())
        whole = np.array_equal(problem_input.used_flanks, every)
        if whole or (good and system.are_balls_clear_of_left_out_flanks()):
            return SolvedEquations(system, outcome, problem_input, mechanism, notes, prepared_at)
        notes = (problem_input.note_on_touched_flanks() if good else UNSOLVED_WITHOUT_FLANKS,)
        problem_input = replace(problem_input, used_flanks=every)


def static_input(scene: Scene, drawn: GeometryWithErrors, layout: BallLayout, **how: Any) -> StaticInput:
    """Return the input of a static problem, without the flanks that the loads lift off the balls.

    ``scene``: screw, nut, balls, supports and loads; ``drawn``: their dimensions with manufacturing errors; ``layout``:
    positions of the balls; ``how``: other fields of `StaticInput`. All flanks are kept if the whole screw is modelled
    (``everything``), and for non-circular flanks on elastic bodies: the check of left-out flanks knows circular ones only.
    """
    found = StaticInput(scene, drawn, layout, selection.flanks_of_scene(scene), **how)
    if found.everything or not (found.has_rigid_bodies or not drawn.profile_coefficients.shape[1]):
        return found
    return replace(found, used_flanks=selection.choose_flanks(scene, drawn))


def solve_static(
    scene: Scene, *, everything: bool = False, member: int = 0, refine: int = 1, discretisation: bool = False
) -> StaticResult:
    """Compute contact loads, contact angles and shaft motion of a ball screw in static equilibrium, by Lin's model.

    The screw is a Timoshenko beam, or rigid. The nut is rigid, and every contact follows Hertz's law. The equilibrium is
    the minimum of a convex energy.

    Parameters
    ----------
    scene
        Screw, nut, balls, supports and loads.
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
    again = partial(solve_elastic, backend=LADDER["lin"], name="lin", member=member)
    result = again(scene, everything=everything, refine=refine)
    if discretisation and result.converged:
        result = with_discretisation_error(scene, result, again)
    return result


def solve_elastic(scene: Scene, **how: Any) -> StaticResult:
    """Return the result of `elastic_solution` for one scene; ``how``: its other arguments."""
    return solve_alone(elastic_solution(scene, **how))


def elastic_solution(
    scene: Scene,
    *,
    backend: ComplianceModel = REFINED,
    condensed: CondensedCompliance | None = None,
    name: str = "refined",
    everything: bool = False,
    member: int = 0,
    refine: int = 1,
) -> Search[StaticResult]:
    """Compute contact loads, contact angles and shaft motion of a ball screw with elastic bodies in static equilibrium.

    Several such computations can be run together (`solve_together`).

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
    start, layout = perf_counter(), ball_layout(scene)
    how: dict[str, Any] = {"condensed_bodies": condensed, "everything": everything, "refine": refine}
    drawn = draw_geometry_with_errors(scene, layout, member)
    problem_input = static_input(scene, drawn, layout, backend=backend, **how)
    solved = yield from solve_with_chosen_flanks(problem_input)
    if isinstance(solved, UnrestrainedProblem):
        return failed_result(solved.problem, name, solved.status, perf_counter() - start)
    system, outcome, mechanism = solved.system, solved.outcome, solved.mechanism
    problem, status = system.problem, solved.status
    if outcome.status in settle.NO_LOADS:
        return failed_result(problem, name, status, perf_counter() - start)
    report = settle.solver_report(outcome, system, problem.nodes.size - 1, (start, solved.prepared_at), solved.notes)
    assumed, neglected = system.assumed_and_left_out()
    left_out = *selection.describe_left_out_parts(problem, mechanism, everything=problem_input.everything), *neglected
    result = assemble_result(system.solved_state(), name, status, report, left_out, assumed)
    return (yield from with_note_on_pins(result, solved))


def with_note_on_pins(result: StaticResult, solved: SolvedEquations) -> Search[StaticResult]:
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
    other, found = yield from settle.solve_with_updated_contacts(equations, follow_profile_errors=False)
    pins, others = (" and ".join(FREEDOMS[k] for k in x) for x in (mechanism.pins, mechanism.alternative_pins))
    words = f"{mechanism.description} is prevented by fixing {pins} of the first node; if {others} is fixed instead, "
    if settle.is_solve_unusable(found):
        words += "the solver finds no equilibrium"
    else:
        change = float(np.abs(other.contact_states()[0].force - result.load).max())
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
