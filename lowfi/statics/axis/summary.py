"""Conversion of the solver's arrays into the result of an assembly: bearings, nuts, housings, equilibrium, stiffness."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rollbench.lowfi.compliance.parts import ComplianceModel
from rollbench.lowfi.rollers import half_widths_and_pressures_of_slices, tapered_bearing_of_row
from rollbench.lowfi.statics import summary
from rollbench.lowfi.statics.axis import system as axis_system
from rollbench.lowfi.statics.axis.equations import AssemblyEquations
from rollbench.lowfi.statics.axis.held import APEX, status_of_reversed_thrust
from rollbench.lowfi.statics.axis.system import AssemblyArrays, BallSet, MountedState, RollerSet
from rollbench.lowfi.statics.problem import ContactState
from rollbench.lowfi.statics.result import HEAT, AxisResult, Equilibrium, HousingResult, SetResult, SolverReport, Status
from rollbench.lowfi.statics.settle import ACCEPTED
from rollbench.lowfi.statics.shape import rigid_motion_transfer_matrix
from rollbench.lowfi.statics.validity import contact_warnings, large_tilt_warning, rotation_warning
from rollbench.lowfi.warned import ResultWarning
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import RollerRow, RollingSet
from rollbench.meshes.section import BeamSection

#: Assumptions of every result of Lin's low-order model on a shaft with several bearings and nuts.
AXIS_ASSUMPTIONS = (
    "nuts, outer rings and housings are rigid, apart from the contacts (Lin 2.3.1); inner rings are one with the shaft",
    *summary.MODEL_ASSUMPTIONS[1:],
    "lever arms of contact loads are those of error-free flanks",
)
#: Assumption of every result with tapered roller bearings.
ROLLERS = (
    "rollers are slices with independent line contacts, so that the pressure peaks at straight ends are missing; rollers "
    "touch their ribs; rings do not bend"
)
#: Share of the largest force in the model below which a contact force counts as zero: ten times the residual up to which a
#: solution counts as converged.
NOTHING = 10.0 * ACCEPTED


class AssemblyModel(NamedTuple):
    """Mechanical model of an assembly: its name, its assumptions, and the function that makes its equations."""

    #: Name of the model.
    name: str
    #: Assumptions of the model, as sentences.
    assumed: tuple[str, ...]
    #: Effects that the model neglects, as sentences.
    left_out: tuple[str, ...]
    #: Method by which the compliance of screws, nuts and balls is computed; None: they are rigid.
    backend: ComplianceModel | None
    #: Cross-section of the threaded shaft; None: computed from the assembly's dimensions.
    threaded_shaft_section: BeamSection | None
    #: Whether flanks that are expected to lift off the balls, by loads and axial offsets, are left out of the equations.
    leaves_out_lifted_flanks: bool


def result_of_solved_assembly(
    equations: AssemblyEquations,
    mounted: tuple[MountedState, Array],
    model: AssemblyModel,
    status: Status,
    report: SolverReport,
    pinned_motions_text: str,
) -> AxisResult:
    """Return the result of a solved assembly: bearings, housings, reactions, equilibrium check, stiffness and status.

    Parameters
    ----------
    equations
        Solved equations of the assembly.
    mounted
        Motions of shaft nodes and housings with all contacts, then forces and moments at the fixed degrees of freedom of
        shaft nodes and moving housings ``(r, 6)`` [N, N m].
    model
        Mechanical model.
    status
        Status that the solver reported.
    report
        Effort and accuracy of the solve.
    pinned_motions_text
        Text that names the rigid motions which the model prevents by fixing degrees of freedom, because no support or
        contact resists them; empty if there are none.
    """
    system, (state, reactions), scale = equations.assembly_arrays, mounted, equations.residual_force_scale
    assembly, structure = system.assembly, system.structure
    r, n = structure.body_positions.size, structure.nodes.size
    stiffnesses, whole = equations.stiffness_of_sets_and_assembly()
    of_sets = zip(system.ball_sets, equations.contact_states(), stiffnesses, strict=True)
    by_name = {b.of.name: result_of_ball_set(system, b, state, report, at, K) for b, at, K in of_sets}
    by_name |= {x.of.name: result_of_roller_bearing(x, state, structure.body_positions) for x in system.roller_sets}
    sets = tuple(by_name[s.name] for s in assembly.sets)
    balance = _check_shaft_equilibrium(system, state, reactions, scale, sets)
    housings = tuple(_result_of_housing(system, i, sets, state.q, reactions, scale) for i in range(r - n))
    found = ((s, s.balls.warnings if s.balls else roller_warnings(s, structure.nodes, state.q[:n])) for s in sets)
    warnings = tuple(w.with_part_name(s.of.name) for s, of_set in found for w in of_set)
    status = summary.add_reason_not_unique(status_after_assembly_check(status, system, balance, housings), warnings)
    if status == "converged":
        status = status_of_reversed_bearing(system, sets, scale) or status
    fixed = "fixed at its initial position, as no load drives and nothing resists it"
    at = axis_system.location_of_reported_stiffness(assembly)
    station = None if isinstance(at, str) else float(structure.nodes[axis_system.body_of_reported_stiffness(system)])
    return AxisResult(
        model=model.name,
        status=status,
        sets=sets,
        housings=housings,
        centreline_z=structure.nodes,
        centreline=state.q[:n].copy(),
        equilibrium=balance,
        stiffness_at=f"shaft at {1e3 * station:.6g} mm" if station is not None else str(at),
        station=station,
        stiffness=whole,
        solver=report,
        assumed=(*assembly.assumed, *model.assumed, *equations.assumed, *((ROLLERS,) if system.roller_sets else ())),
        left_out=(
            *((HEAT,) if assembly.thermal_strain else ()),
            *((f"{pinned_motions_text}: {fixed}",) if pinned_motions_text else ()),
            *model.left_out,
            *axis_system.describe_left_out_flanks(system),
        ),
        warnings=warnings,
        reactions=summary.nodal_reactions(structure.nodes, assembly.supports, reactions[:n]),
    )


def status_after_assembly_check(
    status: Status, system: AssemblyArrays, balance: Equilibrium, housings: Sequence[HousingResult]
) -> Status:
    """Return the status of an assembly after the check of equilibrium of shaft, balls and housings.

    The status is "not converged" if forces or moments on shaft, a ball or a housing do not add up to zero within the
    accepted residual.

    Parameters
    ----------
    status
        Status that the solver reported.
    system
        Arrays of the assembly.
    balance
        Sums of forces and moments on shaft and balls.
    housings
        Results of the housings with their residuals.
    """
    frozen, ball = system.assembly.ingredients.arm == "nominal", ""
    for b in system.ball_sets:
        if b.ball_indices.start < balance.worst_ball <= b.ball_indices.stop:
            ball = f"ball {balance.worst_ball - b.ball_indices.start} of {b.of.name}"
    status = summary.status_after_equilibrium_check(status, balance, frozen, "the shaft", ball)
    worst = max(housings, key=lambda h: h.residual, default=None)
    if status == "converged" and worst is not None and not frozen and not worst.residual <= summary.BALANCE:
        reason = f"{worst.name} is out of balance by {worst.residual:.1e} of the largest force"
        return Status("not converged", reason)
    return status


def status_of_reversed_bearing(system: AssemblyArrays, sets: Sequence[SetResult], scale: float) -> Status | None:
    """Return the status if a bearing for one direction of thrust is loaded against this direction; None if none is.

    Parameters
    ----------
    system
        Arrays of the assembly.
    sets
        Results of bearings and nuts.
    scale
        Largest force in the model [N]; contact forces below 1e-9 of it count as zero.
    """
    for s in sets:
        if s.balls is not None and s.of.thrust in ("+z", "-z"):
            past = (s.balls.contact_angle < APEX) & (s.balls.load > NOTHING * scale)
            if past.any():
                worst = int(np.where(past, s.balls.load, 0.0).argmax())
                load, angle = s.balls.load.flat[worst], s.balls.contact_angle.flat[worst]
                return status_of_reversed_thrust(system, s.of.name, s.of.thrust, float(angle), float(load))
    return None


def result_of_ball_set(
    system: AssemblyArrays,
    ball_set: BallSet,
    state: MountedState,
    report: SolverReport,
    contacts: ContactState,
    stiffness: Array,
) -> SetResult:
    """Return the result of one ball nut or ball bearing: contacts, and force and moment on the shaft and on nut or ring.

    Parameters
    ----------
    system
        Arrays of the assembly.
    ball_set
        The nut or bearing.
    state
        Motions of shaft nodes and housings, and all contacts.
    report
        Effort and accuracy of the solve.
    contacts
        Contacts of the nut or bearing.
    stiffness
        Tangent stiffness ``(6, 6)`` [N/m, N, N m] of the nut or bearing, without shaft and housing.
    """
    of, nodes = ball_set.of, system.structure.nodes
    deep = of.thrust == "deep groove"
    result = summary.contact_result(contacts, nodes, state.q[: nodes.size], report, arc_on_both_sides=deep)
    forces, points = -result.force_direction * contacts.force[..., None], result.contact_point
    on_shaft, back = (_resultant_about_axis_point(points[:, x], forces[:, x], of.position) for x in (slice(2), slice(2, 4)))
    outer = _outer_part_motion(of, ball_set.outer_body_row, state, system.structure.body_positions)
    return SetResult(of, *on_shaft, np.concatenate(back), stiffness, outer, result)


def result_of_roller_bearing(roller_set: RollerSet, state: MountedState, stations: Array) -> SetResult:
    """Return the result of one tapered roller bearing: roller loads, force and moment on the shaft, and stiffness.

    Parameters
    ----------
    roller_set
        The bearing.
    state
        Motions of shaft nodes and housings, and all contacts.
    stations
        Axial positions of shaft nodes and moving housings [m].
    """
    forces, stiffness = (x[roller_set.slice_indices] for x in (state.slice_forces, state.slice_stiffness))
    inner = float(stations[roller_set.slices.ring_bodies[0, 0]])
    B = roller_set.slices.B[:, 0] @ rigid_motion_transfer_matrix(inner - roller_set.of.position)
    wrench, K = -forces @ B, (B.T * stiffness) @ B
    row = roller_set.row
    loads = forces.reshape(row.count, row.slices)
    lines = loads * row.slices / row.length
    outer = _outer_part_motion(roller_set.of, int(roller_set.slices.ring_bodies[0, 1]), state, stations)
    of_rollers = roller_set.roller_azimuths, loads.sum(axis=1), lines
    return SetResult(roller_set.of, wrench[:3], wrench[3:], -wrench, K, outer, None, *of_rollers)


def _outer_part_motion(of: RollingSet, row: int, state: MountedState, stations: Array) -> Array:
    """Return the motion ``(6,)`` [m, rad] of an outer ring or nut at its axial position, its prescribed offset included.

    Parameters
    ----------
    of
        Bearing or nut.
    row
        Number of the housing of its outer ring or nut among the bodies (shaft nodes, then moving housings); -1 if it is
        fixed.
    state
        Motions of shaft nodes and housings.
    stations
        Axial positions of shaft nodes and moving housings [m].
    """
    offset = np.array([0.0, 0.0, of.offset, 0.0, 0.0, 0.0])
    return rigid_motion_transfer_matrix(of.position - float(stations[row])) @ state.q[row] + offset if row >= 0 else offset


def _resultant_about_axis_point(points: Array, forces: Array, station: float) -> tuple[Array, Array]:
    """Return the resultant force [N] of contact forces, and their moment [N m] about a point of the shaft's axis.

    Parameters
    ----------
    points
        Contact points of N balls with s flanks ``(N, s, 3)`` [m].
    forces
        Contact forces ``(N, s, 3)`` [N].
    station
        Axial position of the point [m].
    """
    arm = points - np.array([0.0, 0.0, station])
    return forces.sum(axis=(0, 1)), np.cross(arm, forces).sum(axis=(0, 1))


def _check_shaft_equilibrium(
    system: AssemblyArrays, state: MountedState, reactions: Array, largest: float, sets: tuple[SetResult, ...]
) -> Equilibrium:
    """Return the check of the shaft's equilibrium under external loads, reactions, and forces of bearings and nuts.

    ``state``: solved motions; ``reactions`` ``(r, 6)`` [N, N m]: at the fixed degrees of freedom; ``largest``: largest
    force in the model [N]; ``sets``: results of the bearings and nuts.
    """
    nodes = system.structure.nodes
    applied, contact = summary.resultant_of_loads(system.assembly.loads), np.zeros(6)
    reaction = summary.resultant_about_origin(nodes, reactions[: nodes.size])
    for s in (x for x in sets if x.of.carrier is None):
        contact += rigid_motion_transfer_matrix(s.of.position).T @ np.concatenate([s.force, s.moment])
        contacts = 0.0 if s.balls is None else float(s.balls.load.max(initial=0.0))
        largest = max(largest, float(np.abs(s.force).max()), contacts)
    size = max(largest, float(np.abs(np.concatenate([applied[:3], reaction[:3]])).max()))
    noise = summary.round_off_forces(np.diff(nodes), system.structure.section_stiffnesses, state.q[: nodes.size])
    net = summary.magnitudes_of_net_ball_forces(state.contacts.force[0], state.contacts.normal[0])
    sums, net_on_balls = (applied, reaction, contact, np.zeros(6)), net
    return summary.check_equilibrium(sums, size, system.moment_arm, noise, net_on_balls)


def _result_of_housing(
    system: AssemblyArrays, i: int, sets: tuple[SetResult, ...], q: Array, reactions: Array, largest: float
) -> HousingResult:
    """Return the result of one housing: its motion, the forces of supports and springs on it, and the unbalanced force.

    The unbalanced force is the sum of external load, reactions, spring forces, and forces of the bearings and nuts that the
    housing carries, as a fraction of the largest force in the model.

    Parameters
    ----------
    system
        Arrays of the assembly.
    i
        Number of the housing among the moving ones.
    sets
        Results of bearings and nuts.
    q
        Motions of shaft nodes and moving housings ``(r, 6)`` [m, rad].
    reactions
        Forces and moments at the fixed degrees of freedom of shaft nodes and moving housings ``(r, 6)`` [N, N m].
    largest
        Largest force in the model [N].
    """
    structure = system.structure
    row = structure.nodes.size + i
    at = float(structure.housing_positions[i])
    springs = np.zeros(6)
    for bodies, reach, K in structure.each_spring():
        ends = [(e, x) for e, x in enumerate(bodies) if x >= 0]
        force = K @ sum((reach[e] @ q[x] for e, x in ends), start=np.zeros(6))
        springs -= sum((reach[e].T @ force for e, x in ends if x == row), start=np.zeros(6))
    name = next(name for name, k in structure.housing_numbers.items() if k == row)
    carried = np.zeros(6)
    for s in sets:
        reach = rigid_motion_transfer_matrix(s.of.position - at).T
        if s.of.housing == name:
            carried += reach @ s.reaction
        if s.of.carrier == name:
            carried += reach @ np.concatenate([s.force, s.moment])
    wrench = reactions[row] + springs
    balance = structure.load[row] + carried + wrench
    forces = structure.load[row], wrench, *(s.force for s in sets if name in (s.of.housing, s.of.carrier))
    size = max(largest, *(float(np.abs(x[:3]).max()) for x in forces))
    left = max(float(np.abs(balance[:3]).max()), float(np.abs(balance[3:]).max()) / system.moment_arm)
    return HousingResult(name, q[row].copy(), wrench, left / size if size > summary.NO_FORCE else 0.0)


def roller_warnings(set_result: SetResult, z: Array, motion: Array) -> tuple[ResultWarning, ...]:
    """Return the warnings that contacts of a tapered roller bearing lie outside the model's range of validity.

    Parameters
    ----------
    set_result
        Result of the bearing; for a ball bearing or nut the returned tuple is empty.
    z
        Axial positions of the shaft's centreline ``(k,)`` [m].
    motion
        Motions of the shaft there ``(k, 6)`` [m, rad].
    """
    if not isinstance(set_result.of.parts, RollerRow) or set_result.line_loads is None:
        return ()
    bearing = tapered_bearing_of_row(set_result.of.parts)
    half_width, pressure = half_widths_and_pressures_of_slices(bearing, set_result.line_loads)
    approach = float(bearing.approach_law().approach(set_result.line_loads).max(initial=0.0))
    rx, ry = (float(np.interp(set_result.of.position, z, motion[:, k])) for k in (3, 4))
    return (
        *contact_warnings(pressure.max(axis=1), half_width.max(axis=1), 0.5 * bearing.diameter, "roller"),
        *large_tilt_warning(float(np.hypot(rx, ry)), 0.5 * bearing.pitch_diameter, approach, "roller"),
        *rotation_warning(z, motion),
    )
