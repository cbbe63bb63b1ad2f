"""Conversion of the solver's arrays into the result of an assembly: bearings, nuts, housings, equilibrium, stiffness."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from rollbench.lowfi.rollers import half_widths_and_pressures_of_slices, tapered_bearing
from rollbench.lowfi.statics.axis.held import APEX, reversed_status
from rollbench.lowfi.statics.axis.system import (
    AssemblyArrays,
    BallSet,
    RollerSet,
    describe_left_out_flanks,
    reported_body_number,
    reported_location,
)
from rollbench.lowfi.statics.kernel_types import MotionState
from rollbench.lowfi.statics.problem import SolvedState
from rollbench.lowfi.statics.result import AxisResult, Equilibrium, HousingResult, SetResult, SolverReport, Status
from rollbench.lowfi.statics.settle import ACCEPTED
from rollbench.lowfi.statics.shape import rigid_transport
from rollbench.lowfi.statics.summary import (
    BALANCE,
    MODEL_ASSUMPTIONS,
    add_reason_not_unique,
    check_equilibrium,
    contact_result,
    net_forces,
    nodal_reactions,
    resultant_about_origin,
    round_off_forces,
    status_after_equilibrium_check,
    wrench_of,
)
from rollbench.lowfi.statics.validity import contact_warnings, large_tilt_warning, rotation_warning
from rollbench.lowfi.warned import Warned
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, RollerRow

#: Assumptions of every result of Lin's low-order model on a shaft with several bearings and nuts.
AXIS_ASSUMPTIONS = (
    "nuts, outer rings and housings are rigid, apart from the contacts (Lin 2.3.1); inner rings are one with the shaft",
    *MODEL_ASSUMPTIONS[1:],
    "lever arms of contact loads are those of error-free flanks",
)
#: Assumption of every result with tapered roller bearings.
ROLLERS = (
    "rollers are slices with independent line contacts, so that the pressure peaks at straight ends are missing; rollers "
    "touch their ribs; rings do not bend"
)

#: A contact force below this share of the largest force counts as zero: ten times the accepted residual of the solver.
NOTHING = 10.0 * ACCEPTED


@dataclass(frozen=True)
class SolveRecord:
    """Data of a finished solve of an assembly that its result needs besides motions and contacts."""

    #: Status that the solver reported.
    status: Status
    #: Effort and accuracy of the solve.
    report: SolverReport
    #: Description in words of the motions that are pinned because nothing resists them; empty if there are none.
    loose: str
    #: Forces and moments at the fixed degrees of freedom of shaft nodes and moving housings ``(r, 6)`` [N, N m].
    held: Array
    #: Tangent stiffness ``(6, 6)`` [N/m, N, N m] of each ball nut and ball bearing by itself.
    sets: Sequence[Array]
    #: Tangent stiffness of the whole assembly at the reported shaft node or housing ``(6, 6)`` [N/m, N, N m]; None if the
    #: assembly has no stiffness there.
    whole: Array | None
    #: Name of the model.
    model: str
    #: Assumptions of the model, as sentences.
    assumed: tuple[str, ...]
    #: Effects that the model neglects, as sentences.
    left_out: tuple[str, ...]
    #: Motions of the flanks of each ball nut and ball bearing ``(N, 4, 2)`` [m].
    shifts: Sequence[Array]
    #: Force by which the solver divided its residual [N]: the largest force in the model.
    scale: float


def assemble_axis(system: AssemblyArrays, state: MotionState, end: SolveRecord) -> AxisResult:
    """Return the result of a solved assembly: bearings, housings, reactions, equilibrium check, stiffness and status.

    Parameters
    ----------
    system
        Arrays of the assembly.
    state
        Motions of shaft nodes and housings, and all contacts.
    end
        Data of the finished solve: its status, effort, stiffness, assumptions.
    """
    assembly, structure = system.assembly, system.structure
    r, n = structure.stations.size, structure.nodes.size
    by_name = {b.of.name: ball_result(system, i, state, end) for i, b in enumerate(system.balls)}
    by_name |= {x.of.name: roller_result(x, state, structure.stations) for x in system.rollers}
    sets = tuple(by_name[s.name] for s in assembly.sets)
    balance = _shaft_equilibrium(system, state, end, sets)
    housings = tuple(_housing_result(system, i, sets, state.q, end) for i in range(r - n))
    of_rollers = partial(roller_warnings, z=structure.nodes, motion=state.q[:n])
    warnings = tuple(
        w.with_part_name(s.of.name) for s in sets for w in (s.balls.warnings if s.balls is not None else of_rollers(s))
    )
    status = add_reason_not_unique(status_after_assembly_check(end.status, system, balance, housings), warnings)
    if status == "converged":
        status = status_of_reversed_bearing(system, sets, end.scale) or status
    held = (f"{end.loose}: fixed at its initial position, as no load drives and nothing resists it",) if end.loose else ()
    at = reported_location(assembly)
    station = None if isinstance(at, str) else float(structure.nodes[reported_body_number(system)])
    return AxisResult(
        model=end.model,
        status=status,
        sets=sets,
        housings=housings,
        centreline_z=structure.nodes,
        centreline=state.q[:n].copy(),
        equilibrium=balance,
        stiffness_at=f"shaft at {1e3 * station:.6g} mm" if station is not None else str(at),
        station=station,
        stiffness=end.whole,
        solver=end.report,
        assumed=(*assembly.assumed, *end.assumed, *((ROLLERS,) if system.rollers else ())),
        left_out=(*held, *end.left_out, *describe_left_out_flanks(system)),
        warnings=warnings,
        reactions=nodal_reactions(structure.nodes, assembly.supports, end.held[:n]),
    )


def status_after_assembly_check(
    status: Status, system: AssemblyArrays, balance: Equilibrium, housings: Sequence[HousingResult]
) -> Status:
    """Return the status of an assembly after the check of equilibrium of shaft, balls and housings.

    It is "not converged" if the sum of the forces or moments on one of them is not zero within the accepted residual.

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
    for b in system.balls:
        if b.balls.start < balance.worst_ball <= b.balls.stop:
            ball = f"ball {balance.worst_ball - b.balls.start} of {b.of.name}"
    status = status_after_equilibrium_check(status, balance, frozen, "the shaft", ball)
    worst = max(housings, key=lambda h: h.residual, default=None)
    if status == "converged" and worst is not None and not frozen and not worst.residual <= BALANCE:
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
                return reversed_status(system, s.of.name, s.of.thrust, float(angle), float(load))
    return None


def ball_result(system: AssemblyArrays, i: int, state: MotionState, end: SolveRecord) -> SetResult:
    """Return the result of one ball nut or ball bearing: contacts, and force and moment on the shaft and on nut or ring.

    Parameters
    ----------
    system
        Arrays of the assembly.
    i
        Number of the nut or bearing among those with balls.
    state
        Motions of shaft nodes and housings, and all contacts.
    end
        Data of the finished solve: its status, effort, stiffness, assumptions.
    """
    b = system.balls[i]
    problem = b.problem
    contact = state.contact[b.balls]
    force, normal, p = contact[..., 0].copy(), contact[..., 1:3].copy(), state.p[b.balls].copy()
    shifts = end.shifts[i] if problem.drawn.profile.shape[1] else None
    motion = state.q[: problem.nodes.size]
    largest = float(force.max(initial=0.0))
    solved = SolvedState(problem, motion, p, force, normal, np.zeros(motion.shape), shifts, largest)
    result = contact_result(solved, problem.nodes, motion, end.report, arc_on_both_sides=b.of.thrust == "deep groove")
    forces = -result.force_direction * force[..., None]
    on_shaft, back = (
        _sum_at(result.contact_point[:, half], forces[:, half], b.of.position) for half in (slice(2), slice(2, 4))
    )
    outer = _outer_part_motion(b, state, system.structure.stations)
    return SetResult(b.of, *on_shaft, np.concatenate(back), end.sets[i], outer, result)


def roller_result(x: RollerSet, state: MotionState, stations: Array) -> SetResult:
    """Return the result of one tapered roller bearing: roller loads, force and moment on the shaft, and stiffness.

    Parameters
    ----------
    x
        The bearing.
    state
        Motions of shaft nodes and housings, and all contacts.
    stations
        Axial positions of shaft nodes and moving housings [m].
    """
    slices = state.slices[x.slices]
    inner = float(stations[x.arrays.row[0, 0]])
    B = x.arrays.B[:, 0] @ rigid_transport(inner - x.of.position)
    wrench, K = -slices[:, 0] @ B, (B.T * slices[:, 1]) @ B
    loads = slices[:, 0].reshape(x.row.count, x.row.slices)
    lines = loads * x.row.slices / x.row.length
    outer = _outer_part_motion(x, state, stations)
    return SetResult(x.of, wrench[:3], wrench[3:], -wrench, K, outer, None, x.azimuths, loads.sum(axis=1), lines)


def _outer_part_motion(x: BallSet | RollerSet, state: MotionState, stations: Array) -> Array:
    """Return the motion ``(6,)`` [m, rad] of an outer ring or nut at its axial position, its prescribed offset included.

    Parameters
    ----------
    x
        Bearing or nut.
    state
        Motions of shaft nodes and housings.
    stations
        Axial positions of shaft nodes and moving housings [m].
    """
    row = x.outer if isinstance(x, BallSet) else int(x.arrays.row[0, 1])
    moved = rigid_transport(x.of.position - float(stations[row])) @ state.q[row] if row >= 0 else np.zeros(6)
    return np.asarray(moved + np.array([0.0, 0.0, x.of.offset, 0.0, 0.0, 0.0]))


def _sum_at(points: Array, forces: Array, station: float) -> tuple[Array, Array]:
    """Return the resultant force [N] of contact forces, and their moment [N m] about a point of the shaft's axis.

    Parameters
    ----------
    points
        Contact points ``(N, s, 3)`` [m].
    forces
        Contact forces ``(N, s, 3)`` [N].
    station
        Axial position of the point [m].
    """
    arm = points - np.array([0.0, 0.0, station])
    return forces.sum(axis=(0, 1)), np.cross(arm, forces).sum(axis=(0, 1))


def _shaft_equilibrium(
    system: AssemblyArrays, state: MotionState, end: SolveRecord, sets: tuple[SetResult, ...]
) -> Equilibrium:
    """Return the check of equilibrium of the shaft: external loads, support reactions, and forces of bearings and nuts.

    ``state``: solved motions; ``end``: data of the finished solve; ``sets``: results of the bearings and nuts.
    """
    nodes = system.structure.nodes
    applied, contact = wrench_of(system.assembly.loads), np.zeros(6)
    reaction = resultant_about_origin(nodes, end.held[: nodes.size])
    largest = end.scale
    for s in (x for x in sets if x.of.carrier is None):
        contact += rigid_transport(s.of.position).T @ np.concatenate([s.force, s.moment])
        contacts = 0.0 if s.balls is None else float(s.balls.load.max(initial=0.0))
        largest = max(largest, float(np.abs(s.force).max()), contacts)
    size = max(largest, float(np.abs(np.concatenate([applied[:3], reaction[:3]])).max()))
    noise = round_off_forces(np.diff(nodes), system.axis.sections, state.q[: nodes.size])
    net = net_forces(state.contact[..., 0], state.contact[..., 1:3])
    return check_equilibrium(
        (applied, reaction, contact, np.zeros(6)), size, system.arm, noise, net[: system.contacts.r_ball.size]
    )


def _housing_result(
    system: AssemblyArrays, i: int, sets: tuple[SetResult, ...], q: Array, end: SolveRecord
) -> HousingResult:
    """Return the result of one housing: its motion, the forces of supports and springs on it, and the unbalanced force.

    The unbalanced force is the sum of external load, reactions, spring forces, and forces of the bearings and nuts that the
    housing carries, divided by the largest force.

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
    end
        Data of the finished solve: its status, effort, stiffness, assumptions.
    """
    structure = system.structure
    row = structure.nodes.size + i
    at = float(structure.at[i])
    springs = np.zeros(6)
    for (first, second), reach, K in zip(structure.ends, structure.reach, structure.springs, strict=True):
        ends = [(e, x) for e, x in enumerate((first, second)) if x >= 0]
        force = K @ sum((reach[e] @ q[x] for e, x in ends), start=np.zeros(6))
        springs -= sum((reach[e].T @ force for e, x in ends if x == row), start=np.zeros(6))
    name = next(name for name, k in structure.row.items() if k == row)
    carried = np.zeros(6)
    for s in sets:
        reach = rigid_transport(s.of.position - at).T
        if s.of.housing == name:
            carried += reach @ s.reaction
        if s.of.carrier == name:
            carried += reach @ np.concatenate([s.force, s.moment])
    wrench = end.held[row] + springs
    balance = structure.load[row] + carried + wrench
    pushes = [s.force for s in sets if name in (s.of.housing, s.of.carrier)]
    size = max(end.scale, *(float(np.abs(x[:3]).max()) for x in (structure.load[row], wrench, *pushes)))
    left = max(float(np.abs(balance[:3]).max()), float(np.abs(balance[3:]).max()) / system.arm)
    return HousingResult(name, q[row].copy(), wrench, left / size if size else 0.0)


def failed_axis(
    assembly: Assembly, model: str, status: Status, seconds: float, assumed: tuple[str, ...] = AXIS_ASSUMPTIONS
) -> AxisResult:
    """Return the result of an assembly without equilibrium: its status gives the reason, and there are no loads.

    Parameters
    ----------
    assembly
        Shaft with bearings and ball nuts.
    model
        Name of the model.
    status
        Status with the reason.
    seconds
        Computing time [s].
    assumed
        Assumptions of the model.
    """
    report = SolverReport(0, 0, float("nan"), seconds, 0, 0, "none", "none")
    return AxisResult(
        model=model,
        status=status,
        centreline_z=np.zeros(0),
        centreline=np.zeros((0, 6)),
        equilibrium=None,
        solver=report,
        assumed=(*assembly.assumed, *assumed),
        left_out=(),
    )


def roller_warnings(s: SetResult, z: Array, motion: Array) -> tuple[Warned, ...]:
    """Return the warnings that contacts of a tapered roller bearing lie outside the model's range of validity.

    Parameters
    ----------
    s
        Result of the bearing; for a ball bearing or nut the returned tuple is empty.
    z
        Axial positions of the shaft's centreline ``(k,)`` [m].
    motion
        Motions of the shaft there ``(k, 6)`` [m, rad].
    """
    if not isinstance(s.of.parts, RollerRow) or s.line_loads is None:
        return ()
    bearing = tapered_bearing(s.of.parts)
    half_width, pressure = half_widths_and_pressures_of_slices(bearing, s.line_loads)
    approach = float(bearing.law().approach(s.line_loads).max(initial=0.0))
    rx, ry = (float(np.interp(s.of.position, z, motion[:, k])) for k in (3, 4))
    return (
        *contact_warnings(pressure.max(axis=1), half_width.max(axis=1), 0.5 * bearing.diameter, "roller"),
        *large_tilt_warning(float(np.hypot(rx, ry)), 0.5 * bearing.pitch_diameter, approach, "roller"),
        *rotation_warning(z, motion),
    )
