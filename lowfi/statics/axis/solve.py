"""Equilibrium of several bearings and ball nuts on one shaft, as the minimum of one energy, found by Newton's method.

Flanks that lift off the balls under load and preload are left out, which saves shaft nodes and rows of the matrix. As
the energy is convex, the solution without these flanks is also the solution with them, provided that no ball of this
solution touches them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from time import perf_counter

import numpy as np

from rollbench.lowfi.compliance.parts import REFINED, ComplianceModel
from rollbench.lowfi.hertz import contact_approach, contact_force
from rollbench.lowfi.statics import settle
from rollbench.lowfi.statics.axis import summary
from rollbench.lowfi.statics.axis import system as axis_system
from rollbench.lowfi.statics.axis.equations import assembly_equations, grooved_shaft_section
from rollbench.lowfi.statics.axis.held import pin_unrestrained_motions, status_of_runaway_assembly, unrestrained_motions
from rollbench.lowfi.statics.axis.mount import PreloadShifts, find_axial_preload_shifts, replace_preload_forces_by_offsets
from rollbench.lowfi.statics.axis.system import AssemblyArrays, BallSet, MountedState
from rollbench.lowfi.statics.contacts import hertz_without_errors
from rollbench.lowfi.statics.equilibrium import solve_alone
from rollbench.lowfi.statics.problem import place_balls
from rollbench.lowfi.statics.result import AxisResult, SolverReport, Status
from rollbench.lowfi.statics.selection import groove_arc_motions_in_section_planes, solutions_clear_of_left_out_flanks
from rollbench.lowfi.statics.summary import ELASTIC_ASSUMPTIONS
from rollbench.meshes.arrays import Array, Mask
from rollbench.meshes.axis import Assembly, RollerRow, RollingSet
from rollbench.meshes.cache import cached_on_disk
from rollbench.meshes.errors import GeometryWithErrors
from rollbench.meshes.numerics import brentq
from rollbench.meshes.parts import Scene
from rollbench.meshes.section import contact_force_positions

#: Assumptions of every result of the refined model on an assembly.
ASSUMPTIONS = (
    "the shaft is a Timoshenko beam between its bearings and nuts; in addition the screw, nut and balls of each bearing or "
    "nut deform under their own contact forces, and respond to contacts elsewhere only by the section forces of the shaft",
    "housings are rigid; nuts and outer rings are fixed in them as the nut of a single ball screw is fixed in its scene",
    *ELASTIC_ASSUMPTIONS,
)
#: Effect that the model neglects for tapered roller bearings.
RIGID_RINGS = (
    "elastic rings: cone and cup are rigid apart from the line contacts, whose force law includes the local deformation"
)

#: Effect that the model neglects for an inner ring that a housing carries.
RIGID_INNER = "elastic inner ring: apart from its contacts it is rigid, like the housing that carries it"


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
    closure = place_balls(scene, drawn).interference
    closed = closure + shift * np.sin(scene.track.contact_angle) * np.array([1.0, -1.0])
    if closed[:, 0].max() > 0.0 >= closed[:, 1].max():
        return axis_system.USE["+z"]
    return axis_system.USE["-z"] if closed[:, 1].max() > 0.0 >= closed[:, 0].max() else use


def are_balls_clear_of_left_out_flanks(system: AssemblyArrays, state: MountedState) -> bool:
    """Return whether no ball of the solved assembly touches a flank that was left out of its equations.

    A flank is examined only if thrust in the direction which its nut or bearing carries can load it. ``system``: arrays
    of the assembly; ``state``: solved motions, ball centres and contacts.
    """
    for b in system.ball_sets:
        problem, used = b.problem, b.problem.used_flanks
        if not np.any(axis_system.USE[b.of.thrust] & ~used):
            continue
        shift = b.v0 + b.flank_motions(state.q)
        for s in np.flatnonzero(~used[:2]) if b.of.carrier is None else ():
            shift[:, s] = _left_out_flank_motion(system, b, int(s), state.q)
        load, centres = state.contacts.force[:, b.ball_indices], state.centres[None, b.ball_indices]
        if not solutions_clear_of_left_out_flanks(centres, shift[None], problem.contacts[None], load, used)[0]:
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


#: Ratio of a body's displacement to the largest pitch radius, or rotation [rad], above which a linear program decides
#: whether the contacts can carry the loads.
FAR = 0.1


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


def solve_assembly(assembly: Assembly, *, member: int = 0) -> AxisResult:
    """Compute contact forces, stiffness and motions of a shaft with several bearings and nuts in static equilibrium.

    The shaft is a beam; nuts, outer rings and housings are rigid (model lin).

    Parameters
    ----------
    assembly
        Shaft with bearings and ball nuts.
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
    model = summary.AssemblyModel("lin", summary.AXIS_ASSUMPTIONS, (), None, None, True)
    return solve_assembly_by_model(assembly, model, member)


def solve_assembly_by_model(assembly: Assembly, model: summary.AssemblyModel, member: int) -> AxisResult:
    """Compute the static equilibrium of an assembly by a model, and return forces, stiffness and motions.

    Parameters
    ----------
    assembly
        Shaft with bearings and ball nuts.
    model
        Mechanical model.
    member
        Number of the specimen: each number gives other random errors.
    """
    start = perf_counter()

    def result_without_equilibrium(status: Status) -> AxisResult:
        """Return the result of an assembly without equilibrium, with the ``status`` that gives the reason."""
        report = SolverReport(0, 0, float("nan"), perf_counter() - start, 0, 0, "none")
        return AxisResult(model=model.name, status=status, solver=report, assumed=(*assembly.assumed, *model.assumed))

    mounted, notes, unmet = replace_preload_forces_by_offsets(
        assembly, lambda bare: _preload_shifts(bare, model.backend, model.name, member)
    )
    if unmet:
        return result_without_equilibrium(unmet)
    places = axis_system.ball_positions_with_errors(mounted, member)
    uses = guess_loaded_flanks(mounted, places) if model.leaves_out_lifted_flanks else flanks_by_thrust_direction(mounted)
    while True:
        system = axis_system.build_assembly_arrays(mounted, uses, places, model.threaded_shaft_section)
        loose = unrestrained_motions(system)
        if loose.is_driven_by_loads:
            return result_without_equilibrium(Status("not held", loose.description))
        prepared = assembly_equations(pin_unrestrained_motions(system, loose), model.backend)
        ready = perf_counter()
        prepared, outcome = solve_alone(settle.solve_with_updated_contacts(prepared))
        every = flanks_by_thrust_direction(mounted)
        good = settle.is_solve_accepted(outcome, prepared.round_off_residual())
        if all(map(np.array_equal, uses, every)):
            break
        if good and are_balls_clear_of_left_out_flanks(prepared.assembly_arrays, prepared.mounted_state_and_reactions()[0]):
            break
        uses = every
        notes = (*notes, "balls touch flanks that loads or offsets should lift off them: solved again with all flanks")
    state, held = prepared.mounted_state_and_reactions()
    # with elastic bodies, loose motions stay fixed in the proof
    proven = system if model.leaves_out_lifted_flanks else prepared.assembly_arrays
    prove, far = partial(status_of_runaway_assembly, proven), moved_too_far(state.q, proven)
    status = settle.status_of_solve(outcome, prepared.round_off_residual(), prove, far)
    if outcome.status in settle.NO_LOADS:
        return result_without_equilibrium(status)
    elements = prepared.assembly_arrays.structure.nodes.size - 1
    report = settle.solver_report(outcome, prepared, prepared.model_description(), elements, (start, ready), notes)
    return summary.result_of_solved_assembly(prepared, (state, held), model, status, report, loose.description)


def solve_assembly_with_elastic_bodies(
    assembly: Assembly, *, member: int = 0, backend: ComplianceModel = REFINED, name: str = "refined"
) -> AxisResult:
    """Compute contact forces, stiffness and motions of an assembly with elastic bodies.

    If all bearings are roller bearings, only the shaft's beam and the line contacts are elastic; the model lin is solved.

    Parameters
    ----------
    assembly
        Shaft with bearings and ball nuts.
    member
        Number of the specimen: each number gives other random errors.
    backend
        Method by which the compliance of screws, nuts and balls is computed.
    name
        Name of the model in the result.

    Raises
    ------
    ValueError
        If an inner ring sits on a housing that stands on springs, there are more than `LARGEST` balls and rollers, or a
        body has impossible dimensions.
    """
    rigid = describe_rigid_rings(assembly)
    if not assembly.ball_count:
        result = solve_assembly(assembly, member=member)
        return replace(result, model=name, left_out=(*result.left_out, *rigid))
    model = summary.AssemblyModel(name, ASSUMPTIONS, rigid, backend, grooved_shaft_section(assembly, backend), False)
    return solve_assembly_by_model(assembly, model, member)


@lru_cache(maxsize=4)
@cached_on_disk(PreloadShifts)
def _preload_shifts(bare: Assembly, backend: ComplianceModel | None, name: str, member: int) -> PreloadShifts:
    """Return the shifts that preload an assembly without loads, from memory or disk, as all its load cases share them."""
    solve: Callable[[Assembly], AxisResult] = partial(solve_assembly, member=member)
    if backend is not None:
        solve = partial(solve_assembly_with_elastic_bodies, member=member, backend=backend, name=name)
    return find_axial_preload_shifts(bare, solve)


def describe_rigid_rings(assembly: Assembly) -> tuple[str, ...]:
    """Return a sentence for each roller bearing and each inner ring on a housing; the model takes their rings as rigid."""
    rollers = tuple(f"{s.name}: {RIGID_RINGS}" for s in assembly.sets if isinstance(s.parts, RollerRow))
    return rollers + tuple(f"{s.name}: {RIGID_INNER}" for s in assembly.sets if s.carrier is not None)
