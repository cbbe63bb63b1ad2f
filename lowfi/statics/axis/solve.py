"""Equilibrium of several bearings and ball nuts on one shaft, as the minimum of one energy, found by Newton's method.

This module contains Lin's model ("lin"); the model with elastic bodies is in `lowfi.statics.axis.elastic`.

Flanks that lift off the balls under load and preload are left out, which saves shaft nodes and rows of the matrix. As
the energy is convex, the solution without these flanks is also the solution with them, provided that no ball of this
solution touches them.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from time import perf_counter
from types import ModuleType
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.hertz import contact_approach, contact_force
from rollbench.lowfi.statics import settle
from rollbench.lowfi.statics.axis import summary
from rollbench.lowfi.statics.axis import system as axis_system
from rollbench.lowfi.statics.axis.held import pin_unrestrained_motions, status_of_runaway_assembly, unrestrained_motions
from rollbench.lowfi.statics.axis.mount import replace_preload_forces_by_offsets
from rollbench.lowfi.statics.axis.structure import largest_spring_force_term
from rollbench.lowfi.statics.axis.system import AssemblyArrays, BallSet
from rollbench.lowfi.statics.contacts import hertz_without_errors
from rollbench.lowfi.statics.kernel_types import AxisSystem, EnergyDerivatives, MotionState
from rollbench.lowfi.statics.problem import Problem, centre_vectors_and_interference
from rollbench.lowfi.statics.result import AxisResult, Status
from rollbench.lowfi.statics.selection import groove_arc_motions_in_section_planes, solutions_clear_of_left_out_flanks
from rollbench.lowfi.statics.shape import initial_motions_with_supports, rigid_motion_transfer_matrix
from rollbench.lowfi.statics.static import Engine, pick_engine
from rollbench.meshes.arrays import Array, Mask
from rollbench.meshes.axis import Assembly, RollerRow, RollingSet
from rollbench.meshes.errors import GeometryWithErrors
from rollbench.meshes.numerics import brentq
from rollbench.meshes.parts import Scene
from rollbench.meshes.section import BeamSection, contact_force_positions


def guess_loaded_flanks(assembly: Assembly, places: Sequence[axis_system.Placed]) -> list[Mask]:
    """Guess which groove flanks of each ball nut or ball bearing carry load; the guess is tested at the solution.

    Parameters
    ----------
    assembly
        Shaft with bearings and ball nuts.
    places
        Ball positions and errors, from `ball_positions_with_errors`.

    Returns
    -------
    list[Mask]
        For each ball nut or ball bearing, whether to use the four flanks (screw left, screw right, nut left, nut right)
        ``(4,)``.
    """
    sets = [(s, s.parts) for s in assembly.sets if isinstance(s.parts, Scene)]
    if len(sets) < len(assembly.sets) or any(s.carrier is not None for s, _ in sets):
        return flanks_by_thrust_direction(assembly)
    along = estimate_axial_displacement(assembly, sets)
    drawn = (parts for _, parts in places)
    return [_flanks_in_contact(s, scene, along - s.offset, x) for (s, scene), x in zip(sets, drawn, strict=True)]


def estimate_axial_displacement(assembly: Assembly, sets: Sequence[tuple[RollingSet, Scene]]) -> float:
    """Estimate the axial displacement of the shaft [m] under the loads, with elastic contacts between rigid bodies.

    It is the displacement uz that a support prescribes, or else the one at which the contact forces of all bearings and
    nuts balance the axial load. ``sets``: the bearings and nuts, each with a scene of its dimensions.
    """
    held = [value for s in assembly.supports for name, value in s.fixed if name == "uz"]
    force = sum(x.force[2] for x in assembly.loads)
    if held:
        return float(held[0])
    sin = np.array([np.sin(scene.track.contact_angle) for _, scene in sets])
    C = np.array([hertz_without_errors(scene).C for _, scene in sets])
    share, pair = sin * [scene.ball_count for _, scene in sets], C[:, 0] + C[:, 3]
    offset = np.array([s.offset for s, _ in sets])

    def unbalanced_axial_force(u: float) -> float:
        """Return the axial contact forces minus the axial load [N] for an axial displacement u [m] of the shaft."""
        return float(np.sum(np.sign(u - offset) * share * contact_force(abs(u - offset) * sin, pair))) - force

    reach = 1e-9 + float((contact_approach(abs(force) / share, pair) / sin).max())
    return float(brentq(unbalanced_axial_force, offset.min() - reach, offset.max() + reach, xtol=1e-9))


def _flanks_in_contact(rolling: RollingSet, scene: Scene, shift: float, drawn: GeometryWithErrors) -> Mask:
    """Return which flanks of one ball nut or bearing touch a ball at an axial shift, as booleans ``(4,)``.

    The flanks are SL, SR, NL, NR: screw left, screw right, nut left, nut right. ``shift``: displacement of the shaft along
    z [m] relative to the nut or outer ring; a positive one closes the flank pair SL-NR and opens SR-NL by the shift times
    the sine of the contact angle. ``rolling``: the ball nut or bearing in the assembly; ``scene``: its dimensions;
    ``drawn``: dimensions with manufacturing errors. If one pair touches balls and the other does not, only the flanks of
    the first pair are returned; otherwise all flanks that can be loaded by thrust in the direction which the nut or bearing
    carries.
    """
    use = axis_system.USE[rolling.thrust]
    if rolling.thrust != "both" or drawn.profile_coefficients.shape[1]:
        return use
    closure = centre_vectors_and_interference(scene, drawn)[1]
    closed = closure + shift * np.sin(scene.track.contact_angle) * np.array([1.0, -1.0])
    if closed[:, 0].max() > 0.0 >= closed[:, 1].max():
        return axis_system.USE["+z"]
    return axis_system.USE["-z"] if closed[:, 1].max() > 0.0 >= closed[:, 0].max() else use


def are_balls_clear_of_left_out_flanks(system: AssemblyArrays, state: MotionState) -> bool:
    """Return whether no ball of the solved assembly touches a flank that was left out of its equations.

    A flank is examined only if thrust in the direction which its nut or bearing carries can load it. ``system``: arrays
    of the assembly; ``state``: solved motions, ball centres and contacts.
    """
    for b in system.ball_sets:
        problem, used = b.problem, b.problem.used_flanks
        if not np.any(axis_system.USE[b.of.thrust] & ~used):
            continue
        shift = axis_system.flank_motions_of_set(b, state.q)
        for s in np.flatnonzero(~used[:2]) if b.of.carrier is None else ():
            shift[:, s] = _left_out_flank_motion(system, b, int(s), state.q)
        load, centres = state.contact[None, b.ball_indices, :, 0], state.p[None, b.ball_indices]
        if not solutions_clear_of_left_out_flanks(centres, shift[None], problem.geometry[None], load, used)[0]:
            return False
    return True


def _left_out_flank_motion(system: AssemblyArrays, ball_set: BallSet, flank: int, q: Array) -> Array:
    """Return the motion ``(N, 2)`` [m] of a screw flank that the solved equations leave out, at each of N balls.

    ``flank``: 0 for the left flank of the screw, 1 for the right one; ``q`` ``(r, 6)``: solved motions of shaft nodes and
    housings [m, rad], interpolated between the nodes; ``ball_set``: the ball nut or bearing.
    """
    problem = ball_set.problem
    stations = contact_force_positions(problem.scene, problem.layout)[:, flank]
    j, m = axis_system.interpolate_shaft_motions(system.structure, stations)
    moved = np.einsum("nab,nb->na", m, np.concatenate([q[j], q[j + 1]], axis=1))
    return groove_arc_motions_in_section_planes(problem.layout, problem.drawn.groove_centres[:, flank], stations, moved)


def flanks_by_thrust_direction(assembly: Assembly) -> list[Mask]:
    """Return which flanks of each ball nut or bearing can be loaded by thrust in the direction that it carries.

    The flanks of each are screw left, screw right, nut left, nut right ``(4,)``.
    """
    return [axis_system.USE[s.thrust] for s in assembly.sets if isinstance(s.parts, Scene)]


def stiffness_of_rigid_assembly(equations: BeamAssemblyEquations, hessians: Array) -> Array | None:
    """Return the tangent stiffness ``(6, 6)`` [N/m, N, N m] of the assembly at the reported shaft node or housing.

    It is the force and moment per unit motion of that node or housing while all other bodies follow freely. Rows and
    columns of fixed degrees of freedom are nan. None if the housing is fixed, or the contacts carry too little load to
    resist. Nuts, rings and housings are rigid.

    Parameters
    ----------
    equations
        Solved equations.
    hessians
        Second derivatives of each ball's energy by the motions of its four flanks ``(N, 8, 8)`` [N/m].
    """
    system, engine, given = equations.assembly_arrays, equations.engine, equations.kernel_arrays
    row = axis_system.body_of_reported_stiffness(system)
    if row < 0:
        return None
    r = system.structure.body_positions.size
    size = given.shaft.row_offsets[-1]
    base, values, step = np.zeros(size), np.empty(size), np.empty((r, 6))
    engine.add_structure_stiffness(base, given.shaft)
    if not engine.factor_tangent_stiffness(given, equations.state, hessians, base, values, np.zeros(6)):
        return None
    compliance = np.empty((6, 6))
    for k in range(6):
        load = np.zeros((r, 6))
        load[row, k] = 1.0
        engine.solve_for_motions(given.shaft, values, load, step)
        compliance[:, k] = step[row]
    return stiffness_from_compliance(compliance, ~system.structure.fixed[row], system.moment_arm)


def stiffness_from_compliance(compliance: Array, free: NDArray[np.bool_], arm: float) -> Array | None:
    """Return the stiffness ``(6, 6)`` [N/m, N, N m] of the free degrees of freedom of a body; nan for the fixed ones.

    None if the matrix is not positive definite but consists of round-off, as happens if no contact carries load.

    Parameters
    ----------
    compliance
        Compliance matrix ``(6, 6)`` of the body [m/N, 1/N, 1/(N m)], whose inverse is the result.
    free
        Which degrees of freedom are free ``(6,)``.
    arm
        Length [m] by which rotations are multiplied to be comparable with displacements when the matrix is inverted.
    """
    rows = np.flatnonzero(free)
    out = np.full((6, 6), np.nan)
    if rows.size:
        size = np.where(rows < 3, 1.0, 1.0 / arm)
        scaled = compliance[np.ix_(rows, rows)] / size[:, None] / size[None, :]
        if not (np.diag(scaled) > 0.0).all():
            return None
        try:
            stiffness = np.linalg.inv(scaled)
        except np.linalg.LinAlgError:
            return None
        stiffness = stiffness / size[:, None] / size[None, :]
        out[np.ix_(rows, rows)] = 0.5 * (stiffness + stiffness.T)
    return out


def screw_flank_motions_per_rigid_motion(ball_set: BallSet, stations: Array) -> Array:
    """Return the motions ``(N, 4, 6)`` of the screw's flanks at N balls per unit of the screw's six rigid motions.

    The four rows of a ball are the left flank, radial and along the helix's binormal, then the right flank likewise. In a
    bearing, the inner ring takes the screw's place. The rigid motion is taken at the axial position of the nut or bearing.

    Parameters
    ----------
    ball_set
        The ball nut or bearing, with N balls.
    stations
        Axial positions of all shaft nodes and moving housings [m].
    """
    return ball_set.flank_motions(rigid_motion_transfer_matrix(stations - ball_set.of.position))[:, :2].reshape(-1, 4, 6)


def stiffness_of_nut_or_bearing(ball_set: BallSet, stations: Array, hessians: Array) -> Array:
    """Return the stiffness ``(6, 6)`` [N/m, N, N m] between screw and nut, or between the rings of a bearing.

    Screw or inner ring move as a rigid body, while nut or outer ring are fixed.

    Parameters
    ----------
    ball_set
        The ball nut or bearing, with N balls; motions are taken at its axial position.
    stations
        Axial positions of all shaft nodes and moving housings [m].
    hessians
        Second derivatives of each ball's energy by the motions of its two flanks on the screw or inner ring ``(N, 4, 4)``
        [N/m].
    """
    rows = screw_flank_motions_per_rigid_motion(ball_set, stations)
    return np.asarray(np.einsum("nai,nab,nbj->ij", rows, hessians, rows))


#: Ratio of a body's displacement to the largest pitch radius, or rotation [rad], above which a linear program decides
#: whether the contacts can carry the loads.
FAR = 0.1


@dataclass(kw_only=True)
class AssemblyEquations(settle.StaticEquations):
    """Equations of an assembly for the numerical kernels: base class for rigid and for elastic bodies."""

    #: Shaft, housings, bearings and nuts of the assembly as arrays.
    assembly_arrays: AssemblyArrays

    @property
    def problems(self) -> Sequence[Problem]:
        """Return the contact problem of each ball nut and ball bearing."""
        return [b.problem for b in self.assembly_arrays.ball_sets]

    @abstractmethod
    def motions_and_reactions(self) -> tuple[MotionState, Array]:
        """Return the present state (motions of shaft nodes and housings, ball centres, contacts), and support reactions.

        The reactions ``(r, 6)`` [N, N m] act on the r shaft nodes and housings and are zero at free degrees of freedom.
        """

    @abstractmethod
    def stiffness_of_sets_and_assembly(self) -> tuple[Sequence[Array], Array | None]:
        """Return the tangent stiffness ``(6, 6)`` [N/m, N, N m] of each ball nut or bearing, and of the assembly.

        The assembly's stiffness is taken at the shaft node or housing for which it is reported; it is None if this housing
        is fixed or nothing resists its motion.
        """


@dataclass(kw_only=True)
class BeamAssemblyEquations(AssemblyEquations):
    """Equations of an assembly whose shaft is a beam and whose nuts, outer rings and housings are rigid (model lin)."""

    SOLVER = "solve_axis"
    #: Arrays of shaft and rolling elements for the kernels.
    kernel_arrays: AxisSystem
    #: Motions, element deformations and contacts: the unknowns of the iteration.
    state: MotionState

    def contact_states(self) -> Sequence[settle.ContactState]:
        """Return contact forces, ball centres and flank motions of each bearing and nut, as the iteration has them now."""
        return axis_system.contact_states_of_sets(self.assembly_arrays, self.state)

    def with_lever_arms(self, arms: Sequence[Array]) -> Self:
        """Return equations with new lever arms of the contact forces, which start from the present state.

        ``arms``: for each bearing or nut with N balls, the shifts ``(N, 4, 2)`` [m] of the flanks' centres of curvature by
        profile errors; contact forces act through these centres.
        """
        system = axis_system.replace_lever_arms(self.assembly_arrays, arms)
        return replace(self, assembly_arrays=system, kernel_arrays=self.kernel_arrays._replace(balls=system.ball_arrays))

    def round_off_residual(self) -> float:
        """Return the relative residual that rounding errors leave at the solution.

        It is the larger of two bounds: one from the largest motion and the stiffest contact, one from the housings'
        springs.
        """
        state, v0 = self.state, self.kernel_arrays.balls.v0
        motion = float(np.abs(state.q[:, :3]).max(initial=0.0)) + float(np.abs(v0).max(initial=0.0))
        stiff = float(state.contact[..., 3].max(initial=0.0)) + float(state.slices[:, 1].max(initial=0.0))
        contacts = settle.residual_by_round_off(motion, stiff, self.residual_force_scale, self.problems)
        springs = largest_spring_force_term(self.assembly_arrays.structure, state.q, self.assembly_arrays.moment_arm)
        return max(contacts, settle.residual_by_round_off(springs, 1.0, self.residual_force_scale, ()))

    def model_description(self) -> settle.ModelDescription:
        """Return the formulation and the number of unknowns for the record of the solution.

        Its list of assumptions is empty; `AssemblyModel` states those of the model.
        """
        return settle.ModelDescription("convex energy", int(np.count_nonzero(~self.assembly_arrays.structure.fixed)), ())

    def energy_derivatives(self) -> EnergyDerivatives:
        """Return the first and second derivatives of the energy in the present state of the iteration."""
        out = EnergyDerivatives(np.zeros(self.state.q.shape), np.zeros((len(self.state.p), 8, 8)))
        self.engine.evaluate_axis(self.kernel_arrays, self.state, out)
        return out

    def motions_and_reactions(self) -> tuple[MotionState, Array]:
        """Return the present state, and support reactions ``(r, 6)``: the energy's gradient at fixed degrees of freedom."""
        return self.state, np.where(self.assembly_arrays.structure.fixed, self.energy_derivatives().gradient, 0.0)

    def stiffness_of_sets_and_assembly(self) -> tuple[Sequence[Array], Array | None]:
        """Return the tangent stiffness ``(6, 6)`` [N/m, N, N m] of each ball nut or bearing, and of the assembly.

        The assembly's stiffness is taken at the shaft node or housing for which it is reported; it is None if this housing
        is fixed or nothing resists its motion.
        """
        system, hessians = self.assembly_arrays, self.energy_derivatives().ball_hessians
        at, inner = system.structure.body_positions, hessians[:, :4, :4]
        sets = [stiffness_of_nut_or_bearing(b, at, inner[b.ball_indices]) for b in system.ball_sets]
        return sets, stiffness_of_rigid_assembly(self, hessians)


def moved_too_far(q: Array, system: AssemblyArrays) -> bool:
    """Return whether a shaft node or housing moved so far that the linear kinematics of the contacts no longer hold.

    Parameters
    ----------
    q
        Motions of shaft nodes and housings ``(r, 6)`` [m, rad].
    system
        Arrays of the assembly.
    """
    return not float((np.abs(q) / np.repeat([system.moment_arm, 1.0], 3)).max()) <= FAR


def build_beam_assembly_equations(system: AssemblyArrays, engine: ModuleType) -> BeamAssemblyEquations:
    """Return the equations of an assembly (model lin), with an initial state that has the prescribed displacements.

    ``system``: arrays of the assembly; ``engine``: module of the numerical kernels, compiled or interpreted.
    """
    s, n = system.structure, system.structure.nodes.size
    scale, furthest = axis_system.assembly_residual_scale(system), float(system.ball_arrays.r_ball.max(initial=0.0))
    q = np.zeros((s.body_positions.size, 6))
    q[:n], d = initial_motions_with_supports(s.nodes, s.fixed[:n], s.prescribed[:n])
    q[n:] = np.where(s.fixed[n:], s.prescribed[n:], 0.0)
    N, M = system.ball_arrays.r_ball.size, system.slice_arrays.gap.size
    state = MotionState(q, d, np.zeros((N, 2)), np.zeros((N, 4, 5)), np.zeros((M, 2)))
    system.ball_arrays = system.ball_arrays._replace(unloaded_force_limit=scale.unloaded_force_limit)
    options = settle.solver_options(scale, system.moment_arm, furthest)
    given = AxisSystem(system.structure_arrays, system.ball_arrays, system.slice_arrays)
    return BeamAssemblyEquations(engine=engine, kernel_arrays=given, state=state, options=options, assembly_arrays=system)


class AssemblyModel(NamedTuple):
    """Mechanical model of an assembly: its name, its assumptions, and the function that makes its equations."""

    #: Name of the model.
    name: str
    #: Assumptions of the model, as sentences.
    assumed: tuple[str, ...]
    #: Effects that the model neglects, as sentences.
    left_out: tuple[str, ...]
    #: Function that builds the equations for the kernels from the arrays of an assembly and the module of the kernels.
    build_equations: Callable[[AssemblyArrays, ModuleType], AssemblyEquations]
    #: Cross-section of the threaded shaft; None: computed from the assembly's dimensions.
    threaded_shaft_section: BeamSection | None
    #: Whether flanks that are expected to lift off the balls, by loads and axial offsets, are left out of the equations.
    leaves_out_lifted_flanks: bool


def solve_assembly(assembly: Assembly, *, engine: Engine = "auto", member: int = 0) -> AxisResult:
    """Compute contact forces, stiffness and motions of a shaft with several bearings and nuts in static equilibrium.

    The shaft is a beam; nuts, outer rings and housings are rigid (model lin).

    Parameters
    ----------
    assembly
        Shaft with bearings and ball nuts.
    engine
        Numerical kernels: ``"interpreted"``, ``"compiled"``, or ``"auto"``, which chooses by the size of the problem.
    member
        Number of the specimen: each number gives other random errors.

    Returns
    -------
    AxisResult
        Forces, stiffness and motions; if there is no equilibrium, ``status`` gives the reason.

    Raises
    ------
    ValueError
        If dimensions leave a part without material.
    """
    model = AssemblyModel("lin", summary.AXIS_ASSUMPTIONS, (), build_beam_assembly_equations, None, True)
    return solve_assembly_by_model(assembly, model, engine, member, partial(solve_assembly, engine=engine, member=member))


def solve_assembly_by_model(
    assembly: Assembly, model: AssemblyModel, engine: Engine, member: int, solve_same_model: partial[AxisResult]
) -> AxisResult:
    """Compute the static equilibrium of an assembly by a model, and return forces, stiffness and motions.

    Parameters
    ----------
    assembly
        Shaft with bearings and ball nuts.
    model
        Mechanical model.
    engine
        Numerical kernels: ``"interpreted"``, ``"compiled"``, or ``"auto"``, which chooses by the size of the problem.
    member
        Number of the specimen: each number gives other random errors.
    solve_same_model
        Function that solves another assembly by the same model. If preloads are prescribed as forces, it is used to find
        the axial offsets of outer rings and nuts that produce them.
    """
    start = perf_counter()

    def result_without_equilibrium(status: Status) -> AxisResult:
        """Return the result of an assembly without equilibrium, with the ``status`` that gives the reason."""
        return summary.axis_result_without_equilibrium(assembly, model.name, status, perf_counter() - start, model.assumed)

    mounted, notes, unmet = replace_preload_forces_by_offsets(assembly, solve_same_model)
    if unmet:
        return result_without_equilibrium(unmet)
    kernels, places = kernels_for_assembly(assembly, engine), axis_system.ball_positions_with_errors(mounted, member)
    uses = guess_loaded_flanks(mounted, places) if model.leaves_out_lifted_flanks else flanks_by_thrust_direction(mounted)
    while True:
        system = axis_system.build_assembly_arrays(mounted, uses, places, model.threaded_shaft_section)
        loose = unrestrained_motions(system)
        if loose.is_driven_by_loads:
            return result_without_equilibrium(Status("not held", loose.description))
        prepared = model.build_equations(pin_unrestrained_motions(system, loose), kernels)
        ready = perf_counter()
        prepared, outcome = settle.solve_with_updated_contacts(prepared)
        every, good = flanks_by_thrust_direction(mounted), outcome.status == 0
        if all(map(np.array_equal, uses, every)):
            break
        if good and are_balls_clear_of_left_out_flanks(prepared.assembly_arrays, prepared.state):
            break
        uses = every
        notes = (*notes, "balls touch flanks that loads or offsets should lift off them: solved again with all flanks")
    state, held = prepared.motions_and_reactions()
    # with elastic bodies, loose motions stay fixed in the proof
    proven = system if model.leaves_out_lifted_flanks else prepared.assembly_arrays
    prove, far = partial(status_of_runaway_assembly, proven), moved_too_far(state.q, proven)
    status = settle.status_of_solve(outcome, prepared.round_off_residual(), prove, far)
    if outcome.status in settle.NO_LOADS:
        return result_without_equilibrium(status)
    description, (sets, whole) = prepared.model_description(), prepared.stiffness_of_sets_and_assembly()
    elements = prepared.assembly_arrays.structure.nodes.size - 1
    ending = summary.SolveRecord(
        status=status,
        report=settle.solver_report(outcome, prepared, description, elements, (start, ready), notes),
        pinned_motions_text=loose.description,
        support_reactions=held,
        set_stiffnesses=sets,
        assembly_stiffness=whole,
        model=model.name,
        assumed=(*model.assumed, *description.assumed),
        left_out=model.left_out,
        flank_motions=[x.flank_motions for x in prepared.contact_states()],
        residual_force_scale=outcome.scale,
    )
    return summary.result_of_solved_assembly(prepared.assembly_arrays, state, ending)


def kernels_for_assembly(assembly: Assembly, engine: Engine) -> ModuleType:
    """Return the module of numerical kernels, compiled or interpreted, that suits the size of an assembly.

    ``engine``: ``"interpreted"``, ``"compiled"`` or ``"auto"``, see `pick_engine`. The size is the number of balls plus a
    quarter of the number of roller slices. It is multiplied by one plus the number of preload forces, because each preload
    force takes further solves.
    """
    slices = sum(s.parts.count * s.parts.slices for s in assembly.sets if isinstance(s.parts, RollerRow))
    preloads = sum(s.preload > 0.0 for s in assembly.sets)
    return pick_engine(engine, (assembly.ball_count + slices // 4) * (1 + preloads))
