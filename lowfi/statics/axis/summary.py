"""Conversion of the solver's arrays into the result of an assembly: bearings, nuts, housings, equilibrium, stiffness."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rollbench.lowfi.rollers import half_widths_and_pressures_of_slices, tapered_bearing_of_row
from rollbench.lowfi.statics import summary
from rollbench.lowfi.statics.axis import system as axis_system
from rollbench.lowfi.statics.axis.equations import AssemblyEquations
from rollbench.lowfi.statics.axis.held import APEX, status_of_reversed_thrust
from rollbench.lowfi.statics.axis.system import AssemblyArrays, BallSet, RollerSet
from rollbench.lowfi.statics.problem import ContactState
from rollbench.lowfi.statics.result import AxisResult, Equilibrium, HousingResult, SetResult, SolverReport, Status
from rollbench.lowfi.statics.settle import ACCEPTED
from rollbench.lowfi.statics.shape import rigid_motion_transfer_matrix
from rollbench.lowfi.statics.validity import contact_warnings, large_tilt_warning, rotation_warning
from rollbench.lowfi.warned import ResultWarning
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import RollerRow, RollingSet

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


def result_of_solved_assembly(
    equations: AssemblyEquations, q: Array, reactions: Array, status: Status, report: SolverReport
) -> AxisResult:
    """Return the result of a solved assembly: bearings, housings, reactions, equilibrium check, stiffness and status.

    Of its assumptions it states those that depend on the bearings and nuts.

    Parameters
    ----------
    equations
        Solved equations of the assembly.
    q
        Motions of shaft nodes and moving housings ``(r, 6)`` [m, rad].
    reactions
        Forces and moments at the fixed degrees of freedom of shaft nodes and moving housings ``(r, 6)`` [N, N m].
    status
        Status that the solver reported.
    report
        Effort and accuracy of the solve.
    """
    system, scale = equations.assembly_arrays, equations.residual_force_scale
    assembly, structure = system.assembly, system.structure
    r, n = structure.body_positions.size, structure.nodes.size
    stiffnesses, whole = equations.stiffness_of_sets_and_assembly()
    of_sets = zip(system.ball_sets, equations.contact_states(), stiffnesses, strict=True)
    by_name = {b.of.name: result_of_ball_set(system, b, q, report, at, K) for b, at, K in of_sets}
    by_name |= {x.of.name: result_of_roller_bearing(x, equations, q) for x in system.roller_sets}
    sets = tuple(by_name[s.name] for s in assembly.sets)
    balance = _check_shaft_equilibrium(equations, q, reactions, sets)
    housings = tuple(_result_of_housing(system, i, sets, q, reactions, scale) for i in range(r - n))
    found = ((s, s.balls.warnings if s.balls else roller_warnings(s, structure.nodes, q[:n])) for s in sets)
    warnings = tuple(w.with_part_name(s.of.name) for s, of_set in found for w in of_set)
    status = summary.add_reason_not_unique(status_after_assembly_check(status, system, balance, housings), warnings)
    if status == "converged":
        status = status_of_reversed_bearing(system, sets, scale) or status
    at = axis_system.location_of_reported_stiffness(assembly)
    station = None if isinstance(at, str) else float(structure.nodes[axis_system.body_of_reported_stiffness(system)])
    return AxisResult(
        model="",
        status=status,
        sets=sets,
        housings=housings,
        centreline_z=structure.nodes,
        centreline=q[:n].copy(),
        equilibrium=balance,
        stiffness_at=f"shaft at {1e3 * station:.6g} mm" if station is not None else str(at),
        station=station,
        stiffness=whole,
        solver=report,
        assumed=(*equations.assumed, *((ROLLERS,) if system.roller_sets else ())),
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
    system: AssemblyArrays, ball_set: BallSet, q: Array, report: SolverReport, contacts: ContactState, stiffness: Array
) -> SetResult:
    """Return the result of one ball nut or ball bearing: contacts, force and moment on the shaft, and stiffness.

    Parameters
    ----------
    system
        Arrays of the assembly.
    ball_set
        The nut or bearing.
    q
        Motions of shaft nodes and moving housings ``(r, 6)`` [m, rad].
    report
        Effort and accuracy of the solve.
    contacts
        Contacts of the nut or bearing.
    stiffness
        Tangent stiffness ``(6, 6)`` [N/m, N, N m] of the nut or bearing, without shaft and housing.
    """
    of, nodes = ball_set.of, system.structure.nodes
    deep = of.thrust == "deep groove"
    result = summary.contact_result(contacts, nodes, q[: nodes.size], report, arc_on_both_sides=deep)
    forces, points = -result.force_direction * contacts.force[..., None], result.contact_point
    on_shaft, back = (_resultant_about_axis_point(points[:, x], forces[:, x], of.position) for x in (slice(2), slice(2, 4)))
    outer = _outer_part_motion(of, ball_set.outer_body_row, q, system.structure.body_positions)
    return SetResult(of, *on_shaft, np.concatenate(back), stiffness, outer, result)


def result_of_roller_bearing(roller_set: RollerSet, equations: AssemblyEquations, q: Array) -> SetResult:
    """Return the result of one tapered roller bearing: roller loads, force and moment on the shaft, and stiffness.

    Parameters
    ----------
    roller_set
        The bearing.
    equations
        Solved equations of the assembly.
    q
        Motions of shaft nodes and moving housings ``(r, 6)`` [m, rad].
    """
    of, row, stations = roller_set.of, roller_set.row, equations.assembly_arrays.structure.body_positions
    loads, stiffness = (x[roller_set.roller_indices, : row.slices] for x in equations.forces_and_stiffness_of_slices())
    cone, cup = roller_set.ring_bodies
    B = roller_set.slice_motions(0) @ rigid_motion_transfer_matrix(float(stations[cone]) - of.position)
    wrench, K = -loads.ravel() @ B, (B.T * stiffness.ravel()) @ B
    outer = _outer_part_motion(of, cup, q, stations)
    of_rollers = roller_set.roller_azimuths, loads.sum(axis=1), loads * row.slices / row.length
    return SetResult(of, wrench[:3], wrench[3:], -wrench, K, outer, None, *of_rollers)


def _outer_part_motion(of: RollingSet, row: int, q: Array, stations: Array) -> Array:
    """Return the motion ``(6,)`` [m, rad] of an outer ring or nut at its axial position, its prescribed offset included.

    Parameters
    ----------
    of
        Bearing or nut.
    row
        Number of the housing of its outer ring or nut among the bodies (shaft nodes, then moving housings); -1 if it is
        fixed.
    q
        Motions of shaft nodes and moving housings ``(r, 6)`` [m, rad].
    stations
        Axial positions of shaft nodes and moving housings [m].
    """
    offset = np.array([0.0, 0.0, of.offset, 0.0, 0.0, 0.0])
    return rigid_motion_transfer_matrix(of.position - float(stations[row])) @ q[row] + offset if row >= 0 else offset


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
    equations: AssemblyEquations, q: Array, reactions: Array, sets: tuple[SetResult, ...]
) -> Equilibrium:
    """Return the check of the shaft's equilibrium under external loads, reactions, and forces of bearings and nuts.

    ``equations``: solved equations; ``q`` ``(r, 6)`` [m, rad]: motions of shaft nodes and moving housings; ``reactions``
    ``(r, 6)`` [N, N m]: at the fixed degrees of freedom; ``sets``: results of the bearings and nuts.
    """
    system, largest = equations.assembly_arrays, equations.residual_force_scale
    nodes = system.structure.nodes
    applied, contact = summary.resultant_of_loads(system.assembly.loads), np.zeros(6)
    reaction = summary.resultant_about_origin(nodes, reactions[: nodes.size])
    for s in (x for x in sets if x.of.carrier is None):
        contact += rigid_motion_transfer_matrix(s.of.position).T @ np.concatenate([s.force, s.moment])
        contacts = 0.0 if s.balls is None else float(s.balls.load.max(initial=0.0))
        largest = max(largest, float(np.abs(s.force).max()), contacts)
    size = max(largest, float(np.abs(np.concatenate([applied[:3], reaction[:3]])).max()))
    noise = summary.round_off_forces(np.diff(nodes), system.structure.section_stiffnesses, q[: nodes.size])
    net = equations.state.forces.contacts.net_forces[0]
    return summary.check_equilibrium((applied, reaction, contact, np.zeros(6)), size, system.moment_arm, noise, net)


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
