"""From the kernels' arrays to the result of an assembly: contacts and sums of each set, housings, balance, stiffness."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rollbench.lowfi.statics.axis.proof import crossed
from rollbench.lowfi.statics.axis.result import AxisResult, HousingResult, SetResult
from rollbench.lowfi.statics.axis.sides import left_out
from rollbench.lowfi.statics.axis.stiffness import asked_station
from rollbench.lowfi.statics.axis.system import BallSet, RollerSet, System
from rollbench.lowfi.statics.problem import SIGNS
from rollbench.lowfi.statics.records import AxisState
from rollbench.lowfi.statics.result import Equilibrium, SolverReport, StaticResult
from rollbench.lowfi.statics.shape import rigid_transport
from rollbench.lowfi.statics.solved import SolvedState
from rollbench.lowfi.statics.summary import MODEL_ASSUMPTIONS, contact_geometry
from rollbench.lowfi.statics.validity import warnings_of
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly

#: Statements that hold for every run of the source's low-order model on several sets.
AXIS_ASSUMPTIONS = (
    "nuts, outer rings and housings are rigid, apart from the contacts (Lin 2.3.1); inner rings are one with the shaft",
    *MODEL_ASSUMPTIONS[1:],
    "lever arms of contact forces are those of error-free flanks",
)
#: And where there are rollers.
ROLLERS = "rollers: slices of line contacts that do not feel one another, seated on their ribs; rings do not bend"


#: Contact angle [rad] below which a row that carries thrust one way has crossed the bottom of its groove, or lies on it.
APEX = 1e-6


@dataclass(frozen=True)
class Ending:
    """How a solve ended: status, report, words for what was held because nothing resists it; held (r, 6): forces of what
    holds the rows [N, N m]; stiffness: of each set of balls (6, 6), and of the whole; model, what it assumes
    and leaves out; shifts (N, 4, 2): of the flanks of all balls [m], None where they are those of the rows."""

    status: str
    report: SolverReport
    loose: str
    held: Array
    sets: Sequence[Array]
    whole: Array | None
    model: str
    assumed: tuple[str, ...]
    left_out: tuple[str, ...] = ()
    shifts: Array | None = None


def assemble_axis(system: System, state: AxisState, end: Ending) -> AxisResult:
    """Result of a finished solve."""
    assembly, structure = system.assembly, system.structure
    r, n = structure.stations.size, structure.nodes.size
    found = {b.of.name: ball_result(system, b, state, end, K) for b, K in zip(system.balls, end.sets, strict=True)}
    found |= {x.of.name: roller_result(x, state, structure.stations) for x in system.rollers}
    sets = tuple(found[s.name] for s in assembly.sets)
    held = (f"{end.loose}: held where it is, since nothing drives or resists it",) if end.loose else ()
    return AxisResult(
        end.model,
        end.status if end.status != "converged" else crossed_row(system, sets) or end.status,
        sets,
        tuple(_housing(system, i, sets, state.q, end.held) for i in range(r - n)),
        structure.nodes,
        state.q[:n].copy(),
        _balance(assembly, structure.nodes, end.held[:n], sets),
        asked_station(system)[1],
        end.whole,
        end.report,
        (*assembly.assumed, *end.assumed, *((ROLLERS,) if system.rollers else ())),
        (*held, *end.left_out, *left_out(system)),
        tuple(w.of(s.of.name) for s in sets if s.balls is not None for w in s.balls.warnings),
    )


def crossed_row(system: System, sets: Sequence[SetResult]) -> str:
    """Words for a row that carries thrust one way and is pulled the other way, past its balls; empty where none is."""
    for s in sets:
        if s.balls is not None and s.of.thrust in ("+z", "-z") and np.any(s.balls.contact_angle < APEX):
            return crossed(system, s.of.name, s.of.thrust, float(np.nanmin(s.balls.contact_angle)))
    return ""


def ball_result(system: System, b: BallSet, state: AxisState, end: Ending, stiffness: Array) -> SetResult:
    """Contacts and sums of a set of balls."""
    problem = b.problem
    contact = state.contact[b.balls]
    force, normal, p = contact[..., 0].copy(), contact[..., 1:3].copy(), state.p[b.balls].copy()
    shifts = None
    if problem.drawn.profile.shape[1] and end.shifts is not None:
        shifts = end.shifts[b.balls]
    elif problem.drawn.profile.shape[1]:
        rows = np.column_stack([problem.node, np.full((len(p), 2), b.outer)])
        moved = np.where((rows >= 0)[..., None], np.einsum("nsak,nsk->nsa", b.B, state.q[rows]), 0.0)
        shifts = b.v0 + moved
    motion = state.q[: problem.nodes.size]
    largest = float(force.max(initial=0.0))
    solved = SolvedState(problem, motion, p, force, normal, np.zeros(motion.shape), shifts, largest)
    points, on_ball = contact_geometry(solved)
    raw = np.arctan2(SIGNS[:, 1] * normal[..., 1], SIGNS[:, 0] * normal[..., 0])
    from_apex = np.abs(raw) if b.of.thrust == "deep groove" else raw
    notes = warnings_of(solved, from_apex, problem.nodes, motion)
    result = StaticResult(
        model="",
        status="converged",
        azimuth=problem.layout.azimuth,
        z=problem.layout.z,
        load=force,
        contact_angle=np.where(force > 0.0, raw, np.nan),
        contact_point=points,
        force_direction=on_ball,
        centre_shift=p,
        hertz_C=problem.C.copy(),
        centreline_z=problem.nodes,
        centreline=state.q[: problem.nodes.size],
        equilibrium=None,
        solver=end.report,
        assumed=(),
        left_out=(),
        warnings=notes,
    )
    forces = -on_ball * force[..., None]
    on_shaft, back = (_sum_at(points[:, half], forces[:, half], b.of.position) for half in (slice(2), slice(2, 4)))
    outer = _outer(b, state, system.structure.stations)
    return SetResult(b.of, *on_shaft, np.concatenate(back), stiffness, outer, result)


def roller_result(x: RollerSet, state: AxisState, stations: Array) -> SetResult:
    """Loads, sums and stiffness of a row of rollers."""
    slices = state.slices[x.slices]
    inner = float(stations[x.arrays.row[0, 0]])
    B = x.arrays.B[:, 0] @ rigid_transport(inner - x.of.position)
    wrench, K = -slices[:, 0] @ B, (B.T * slices[:, 1]) @ B
    loads = slices[:, 0].reshape(x.row.count, x.row.slices)
    rollers = np.column_stack([x.azimuths, loads.sum(axis=1)])
    lines = loads * x.row.slices / x.row.length
    return SetResult(x.of, wrench[:3], wrench[3:], -wrench, K, _outer(x, state, stations), None, rollers, lines)


def _outer(x: BallSet | RollerSet, state: AxisState, stations: Array) -> Array:
    """Motion (6,) of a set's outer part at its position, with its offset."""
    row = x.outer if isinstance(x, BallSet) else int(x.arrays.row[0, 1])
    moved = rigid_transport(x.of.position - float(stations[row])) @ state.q[row] if row >= 0 else np.zeros(6)
    return np.asarray(moved + np.array([0.0, 0.0, x.of.offset, 0.0, 0.0, 0.0]))


def _sum_at(points: Array, forces: Array, station: float) -> tuple[Array, Array]:
    """Sum of forces (N, s, 3) [N] at points (N, s, 3) [m], and of their moments about the axis at a station [m]."""
    arm = points - np.array([0.0, 0.0, station])
    return forces.sum(axis=(0, 1)), np.cross(arm, forces).sum(axis=(0, 1))


def _balance(assembly: Assembly, nodes: Array, held: Array, sets: tuple[SetResult, ...]) -> Equilibrium:
    """Loads, reactions and the sets' forces on the shaft; moments about the origin."""
    applied, reaction, contact = np.zeros(6), np.zeros(6), np.zeros(6)
    largest = 0.0
    for load in assembly.loads:
        applied += rigid_transport(load.at).T @ np.concatenate([load.force, load.moment])
    for j in np.flatnonzero(held.any(axis=1)):
        reaction += rigid_transport(float(nodes[j])).T @ held[j]
    for s in (x for x in sets if x.of.carrier is None):
        contact += rigid_transport(s.of.position).T @ np.concatenate([s.force, s.moment])
        contacts = 0.0 if s.balls is None else float(s.balls.load.max(initial=0.0))
        largest = max(largest, float(np.abs(s.force).max()), contacts)
    size = max(largest, float(np.abs(np.concatenate([applied[:3], reaction[:3]])).max()))
    arm = max(
        size * float(nodes[-1] - nodes[0]), float(np.abs(np.concatenate([applied[3:], reaction[3:], contact[3:]])).max())
    )
    rest = applied + reaction + contact
    return Equilibrium(
        applied[:3],
        applied[3:],
        reaction[:3],
        reaction[3:],
        contact[:3],
        contact[3:],
        float(np.abs(rest[:3]).max()) / size if size else 0.0,
        float(np.abs(rest[3:]).max()) / arm if arm else 0.0,
    )


def _housing(system: System, i: int, sets: tuple[SetResult, ...], q: Array, held: Array) -> HousingResult:
    """Balance of one housing: its load, what holds it, its springs, and the sets it carries."""
    structure = system.structure
    row = structure.nodes.size + i
    at = float(structure.at[i])
    springs = np.zeros(6)
    for (one, two), reach, K in zip(structure.ends, structure.reach, structure.springs, strict=True):
        ends = [(e, x) for e, x in enumerate((one, two)) if x >= 0]
        force = K @ sum((reach[e] @ q[x] for e, x in ends), start=np.zeros(6))
        springs -= sum((reach[e].T @ force for e, x in ends if x == row), start=np.zeros(6))
    name = next(name for name, own in structure.row.items() if own == row)
    carried = np.zeros(6)
    for s in sets:
        reach = rigid_transport(s.of.position - at).T
        if s.of.housing == name:
            carried += reach @ s.reaction
        if s.of.carrier == name:
            carried += reach @ np.concatenate([s.force, s.moment])
    wrench = held[row] + springs
    rest = structure.load[row] + carried + wrench
    pushes = [s.force for s in sets if name in (s.of.housing, s.of.carrier)]
    size = max(float(np.abs(x[:3]).max()) for x in (structure.load[row], wrench, *pushes))
    left = max(float(np.abs(rest[:3]).max()), float(np.abs(rest[3:]).max()) / system.arm)
    return HousingResult(name, q[row].copy(), wrench, left / size if size else 0.0)


def failed_axis(
    assembly: Assembly, model: str, status: str, seconds: float, assumed: tuple[str, ...] = AXIS_ASSUMPTIONS
) -> AxisResult:
    """Result of an assembly without equilibrium: no loads, and the reason; assumed: what the model assumes."""
    report = SolverReport(0, 0, float("nan"), seconds, 0, 0, "none", "none")
    none = np.zeros(0)
    return AxisResult(
        model, status, (), (), none, np.zeros((0, 6)), None, "", None, report, (*assembly.assumed, *assumed), ()
    )
