"""Equilibrium of several rolling sets on one shaft: one energy, Newton's method.

By Lin's model (`lin`) here, with elastic bodies in `lowfi.statics.axis.elastic`.

Flanks that load and preload open are left out: such a flank needs no node of the shaft and no rows of the matrix. The
energy is convex: where every ball clears the flanks left out at the solution without them, that is the solution with them.
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
from rollbench.lowfi.statics.axis.held import loose_motions, pinned, unheld
from rollbench.lowfi.statics.axis.mount import mount
from rollbench.lowfi.statics.axis.structure import spring_terms
from rollbench.lowfi.statics.axis.summary import AXIS_ASSUMPTIONS, Ending, assemble_axis, failed_axis
from rollbench.lowfi.statics.axis.system import (
    USE,
    BallSet,
    Placed,
    System,
    reported_row,
    build,
    motions_of,
    moved_flanks,
    ball_positions,
    scale_of,
    set_flanks,
    with_arms,
)
from rollbench.lowfi.statics.contacts import error_free_hertz
from rollbench.lowfi.statics.kernel_types import AxisSystem, RowState, Slopes
from rollbench.lowfi.statics.problem import Problem, centre_distances
from rollbench.lowfi.statics.result import AxisResult, Status
from rollbench.lowfi.statics.selection import all_clear, motions_in_section
from rollbench.lowfi.statics.settle import (
    NO_LOADS,
    Description,
    Prepared,
    SetFlanks,
    least_residual,
    options_of,
    report_of,
    settled,
    status_of,
)
from rollbench.lowfi.statics.shape import lifted, rigid_transport
from rollbench.lowfi.statics.static import Engine, pick_engine
from rollbench.meshes.arrays import Array, Mask
from rollbench.meshes.axis import Assembly, RollerRow, RollingSet
from rollbench.meshes.errors import Specimen
from rollbench.meshes.numerics import brentq
from rollbench.meshes.parts import Scene
from rollbench.meshes.section import BeamSection, contact_stations


def likely_sides(assembly: Assembly, places: Sequence[Placed]) -> list[Mask]:
    """Return the flanks ``(4,)`` of each set of balls that thrust, load and offsets leave: a guess, tested by `clear`."""
    sets = [(s, s.parts) for s in assembly.sets if isinstance(s.parts, Scene)]
    if len(sets) < len(assembly.sets) or any(s.carrier is not None for s, _ in sets):
        return all_sides(assembly)
    along = axial_place(assembly, sets)
    return [_of_set(s, scene, along - s.offset, drawn) for (s, scene), (_, drawn) in zip(sets, places, strict=True)]


def axial_place(assembly: Assembly, sets: Sequence[tuple[RollingSet, Scene]]) -> float:
    """Return the axial position of the shaft [m] with everything else rigid.

    Where it is fixed, or where the sets' forces balance its load.
    """
    held = [value for s in assembly.supports for name, value in s.fixed if name == "uz"]
    force = sum(x.force[2] for x in assembly.loads)
    if held:
        return float(held[0])
    sin = np.array([np.sin(scene.track.contact_angle) for _, scene in sets])
    C = np.array([error_free_hertz(scene).C for _, scene in sets])
    share, pair = sin * [scene.ball_count for _, scene in sets], C[:, 0] + C[:, 3]
    offset = np.array([s.offset for s, _ in sets])

    def excess(u: float) -> float:
        return float(np.sum(np.sign(u - offset) * share * contact_force(abs(u - offset) * sin, pair))) - force

    reach = 1e-9 + float((contact_approach(abs(force) / share, pair) / sin).max())
    return float(brentq(excess, offset.min() - reach, offset.max() + reach, xtol=1e-9))


def _of_set(rolling: RollingSet, scene: Scene, shift: float, drawn: Specimen) -> Mask:
    """Return the flanks that a set uses when the shaft moves by ``shift`` [m] along z.

    A positive shift closes SL-NR and opens SR-NL, by the contact angle's sine.
    """
    use = USE[rolling.thrust]
    if rolling.thrust != "both" or drawn.profile.shape[1]:
        return use
    closed = centre_distances(scene, drawn)[1] + shift * np.sin(scene.track.contact_angle) * np.array([1.0, -1.0])
    if closed[:, 0].max() > 0.0 >= closed[:, 1].max():
        return USE["+z"]
    return USE["-z"] if closed[:, 1].max() > 0.0 >= closed[:, 0].max() else use


def clear(system: System, state: RowState) -> bool:
    """Return whether all balls clear the flanks that a set could use and that were left out."""
    return all(_set_clear(system, b, state) for b in system.balls if np.any(USE[b.of.thrust] & ~b.problem.use))


def _set_clear(system: System, b: BallSet, state: RowState) -> bool:
    contact = state.contact[b.balls]
    shift = moved_flanks(b, state.q)
    for s in range(2):
        if not b.problem.use[s] and b.of.carrier is None:
            shift[:, s] = _flank_motion(system, b, s, state.q)
    place, load = state.p[None, b.balls], contact[None, ..., 0]
    return bool(all_clear(place, shift[None], b.problem.geometry[None], load, b.problem.use)[0])


def _flank_motion(system: System, b: BallSet, s: int, q: Array) -> Array:
    """Return the motion ``(N, 2)`` [m] of a screw flank that has no node: the beam's at its station."""
    stations = contact_stations(b.problem.scene, b.problem.layout)[:, s]
    j, m = motions_of(system.structure, stations)
    moved = np.einsum("nab,nb->na", m, np.concatenate([q[j], q[j + 1]], axis=1))
    return motions_in_section(b.problem.layout, b.problem.drawn.centre[:, s], stations, moved)


def all_sides(assembly: Assembly) -> list[Mask]:
    """Return all flanks ``(4,)`` that each set of balls can use."""
    return [USE[s.thrust] for s in assembly.sets if isinstance(s.parts, Scene)]


def complete(uses: Sequence[Mask], assembly: Assembly) -> bool:
    """Return whether nothing that the sets can use is left out."""
    return all(np.array_equal(a, b) for a, b in zip(uses, all_sides(assembly), strict=True))


def whole_stiffness(
    system: System, engine: ModuleType, given: AxisSystem, state: RowState, hessians: Array
) -> Array | None:
    """Return stiffness ``(6, 6)`` [N/m, N, N m] against wrenches on the reported row, with everything else free to follow.

    Rows and columns of fixed freedoms are nan. None where the row is fixed, or where contacts carry too little to be stiff.
    """
    row = reported_row(system)
    if row < 0:
        return None
    r = system.structure.stations.size
    size = given.shaft.start[-1]
    base, values, step = np.zeros(size), np.empty(size), np.empty((r, 6))
    engine.add_axis(base, given.shaft)
    if not engine.tangent(given, state, hessians, base, values, np.zeros(6)):
        return None
    compliance = np.empty((6, 6))
    for k in range(6):
        load = np.zeros((r, 6))
        load[row, k] = 1.0
        engine.solve_lines(given.shaft, values, load, step)
        compliance[:, k] = step[row]
    return inverse(compliance, ~system.structure.fixed[row], system.arm)


def inverse(compliance: Array, free: NDArray[np.bool_], arm: float) -> Array | None:
    """Return the stiffness ``(6, 6)`` of the free freedoms from a compliance, nan for the others.

    None for a matrix that is no compliance: contacts that carry nothing leave round-off. arm [m]: makes rotations
    comparable.
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


def rigid_rows(b: BallSet, stations: Array) -> Array:
    """Return the motion ``(N, 4, 6)`` of the inner flanks of a set, two axes each, by its inner part as a rigid body.

    The motion is taken at the set's position. stations: of all rows [m].
    """
    return b.flank_motions(rigid_transport(stations - b.of.position))[:, :2].reshape(-1, 4, 6)


def set_stiffness(b: BallSet, stations: Array, hessians: Array) -> Array:
    """Return the stiffness ``(6, 6)`` of a set against motions of its inner part at its position, the outer part fixed.

    hessians ``(N, 4, 4)``: second derivatives of the balls' energy by the motion of their screw flanks [N/m].
    """
    rows = rigid_rows(b, stations)
    return np.asarray(np.einsum("nai,nab,nbj->ij", rows, hessians, rows))


#: Motion over the largest pitch radius, and rotation, from which on a linear program says whether contacts hold the loads.
FAR = 0.1


@dataclass(kw_only=True)
class Sets(Prepared):
    """Assembly ready for the kernels."""

    #: The assembly as arrays.
    system: System

    @property
    def problems(self) -> Sequence[Problem]:
        """Problem of each set of balls."""
        return [b.problem for b in self.system.balls]

    @abstractmethod
    def row_states(self) -> tuple[RowState, Array]:
        """Return the motions of all rows with their contacts, and the reaction forces of fixed rows ``(r, 6)``."""

    @abstractmethod
    def stiffness(self) -> tuple[Sequence[Array], Array | None]:
        """Return the stiffness ``(6, 6)`` of each set of balls, and of the whole at the reported row."""


@dataclass(kw_only=True)
class RigidSets(Sets):
    """Assembly with the shaft as a beam and rigid outer parts."""

    SOLVER = "solve_axis"
    #: Shaft and rolling elements as the kernels take them.
    given: AxisSystem
    #: Motions, deformations and contacts.
    state: RowState

    def flanks(self) -> Sequence[SetFlanks]:
        """Return the contacts at the state."""
        return set_flanks(self.system, self.state)

    def with_arms(self, arms: Sequence[Array]) -> Self:
        """Return the system with longer lever arms, as `Prepared.with_arms`."""
        system = with_arms(self.system, arms)
        return replace(self, system=system, given=self.given._replace(balls=system.contacts))

    def round_off(self) -> float:
        """Return the residual that rounding leaves, by the largest motions and the stiffest contact, and by the springs."""
        state, v0 = self.state, self.given.balls.v0
        motion = float(np.abs(state.q[:, :3]).max(initial=0.0)) + float(np.abs(v0).max(initial=0.0))
        stiff = float(state.contact[..., 3].max(initial=0.0)) + float(state.slices[:, 1].max(initial=0.0))
        contacts = least_residual(motion, stiff, self.scale, self.problems)
        springs = spring_terms(self.system.structure, state.q, self.system.arm)
        return max(contacts, least_residual(springs, 1.0, self.scale, ()))

    def description(self) -> Description:
        """Return the description of the model; its assumptions are part of the model."""
        return Description("convex energy", int(np.count_nonzero(~self.system.structure.fixed)), ())

    def slopes(self) -> Slopes:
        """Return the derivatives of the energy at the state."""
        out = Slopes(np.zeros(self.state.q.shape), np.zeros((len(self.state.p), 8, 8)))
        self.engine.evaluate_axis(self.given, self.state, out)
        return out

    def row_states(self) -> tuple[RowState, Array]:
        """Return motions and reactions; these are the gradient at the fixed freedoms."""
        return self.state, np.where(self.system.structure.fixed, self.slopes().gradient, 0.0)

    def stiffness(self) -> tuple[Sequence[Array], Array | None]:
        """Return stiffness matrices, as `Sets.stiffness`."""
        system, hessians = self.system, self.slopes().hessians
        sets = [set_stiffness(b, system.structure.stations, hessians[b.balls, :4, :4]) for b in system.balls]
        return sets, whole_stiffness(system, self.engine, self.given, self.state, hessians)


def far_off(q: Array, system: System) -> bool:
    """Return whether rows move so far that contacts may resist by a curvature that linear motions lack; q ``(r, 6)``."""
    return not float((np.abs(q) / np.repeat([system.arm, 1.0], 3)).max()) <= FAR


def prepare(system: System, engine: ModuleType) -> RigidSets:
    """Return a system ready for the kernels, with a start that has the prescribed displacements."""
    s, n = system.structure, system.structure.nodes.size
    scale, furthest = scale_of(system), float(system.contacts.r_ball.max(initial=0.0))
    q = np.zeros((s.stations.size, 6))
    q[:n], d = lifted(s.nodes, s.fixed[:n], s.prescribed[:n])
    q[n:] = np.where(s.fixed[n:], s.prescribed[n:], 0.0)
    N, M = system.contacts.r_ball.size, system.slices.drop.size
    state = RowState(q, d, np.zeros((N, 2)), np.zeros((N, 4, 5)), np.zeros((M, 2)))
    system.contacts = system.contacts._replace(tiny=scale.none)
    options = options_of(scale, system.arm, furthest)
    given = AxisSystem(system.axis, system.contacts, system.slices)
    return RigidSets(engine=engine, given=given, state=state, options=options, system=system)


class Model(NamedTuple):
    """Model of an assembly."""

    #: Name of the model.
    name: str
    #: Assumptions of the model.
    assumed: tuple[str, ...]
    #: Effects that the model neglects.
    left_out: tuple[str, ...]
    #: Makes a system ready for the kernels.
    ready: Callable[[System, ModuleType], Sets]
    #: Section of the threaded shaft; None: the scene's.
    section: BeamSection | None
    #: Whether flanks that load and offsets open are left out.
    fewer: bool


def solve_assembly(assembly: Assembly, *, engine: Engine = "auto", member: int = 0) -> AxisResult:
    """Compute loads, stiffness and motions of an assembly in static equilibrium, shaft a beam, outer parts rigid.

    Parameters
    ----------
    assembly
        The assembly.
    engine
        Kernels: ``"interpreted"``, ``"compiled"``, or ``"auto"``, by size.
    member
        Number of the specimen, for random errors.

    Returns
    -------
    AxisResult
        The result; for an assembly without equilibrium its ``status`` gives the reason.

    Raises
    ------
    ValueError
        Dimensions that leave no body.
    """
    model = Model("lin", AXIS_ASSUMPTIONS, (), prepare, None, True)
    return equilibrium(assembly, model, engine, member, partial(solve_assembly, engine=engine, member=member))


def equilibrium(assembly: Assembly, model: Model, engine: Engine, member: int, again: partial[AxisResult]) -> AxisResult:
    """Solve an assembly by a model, as `solve_assembly`; again: function that solves the assembly as mounted."""
    start = perf_counter()

    def failed(status: Status) -> AxisResult:
        return failed_axis(assembly, model.name, status, perf_counter() - start, model.assumed)

    mounted, notes, unmet = mount(assembly, again)
    if unmet:
        return failed(unmet)
    kernels, places = engine_for(assembly, engine), ball_positions(mounted, member)
    uses = likely_sides(mounted, places) if model.fewer else all_sides(mounted)
    while True:
        system = build(mounted, member, uses, places, model.section)
        loose = loose_motions(system)
        if loose.driven:
            return failed(Status("not held", loose.text))
        prepared = model.ready(pinned(system, loose), kernels)
        ready = perf_counter()
        prepared, outcome = settled(prepared)
        if complete(uses, mounted) or (outcome.status == 0 and clear(prepared.system, prepared.state)):
            break
        uses = all_sides(mounted)
        notes = (*notes, "flanks that load or offsets should open touch in the solution: solved again with all of them")
    state, held = prepared.row_states()
    proven = system if model.fewer else prepared.system  # with elastic bodies loose motions are held in the proof too
    status = status_of(outcome, prepared.round_off(), partial(unheld, proven), far_off(state.q, proven))
    if outcome.status in NO_LOADS:
        return failed(status)
    description, (sets, whole) = prepared.description(), prepared.stiffness()
    ending = Ending(
        status=status,
        report=report_of(outcome, prepared, description, prepared.system.structure.nodes.size - 1, (start, ready), notes),
        loose=loose.text,
        held=held,
        sets=sets,
        whole=whole,
        model=model.name,
        assumed=(*model.assumed, *description.assumed),
        left_out=model.left_out,
        shifts=[x.shift for x in prepared.flanks()],
        scale=outcome.scale,
    )
    return assemble_axis(prepared.system, state, ending)


def engine_for(assembly: Assembly, engine: Engine) -> ModuleType:
    """Return kernels: interpreted for one small solve, compiled for many elements, several solves, or where available."""
    slices = sum(s.parts.count * s.parts.slices for s in assembly.sets if isinstance(s.parts, RollerRow))
    preloads = sum(s.preload > 0.0 for s in assembly.sets)
    return pick_engine(engine, (assembly.ball_count + slices // 4) * (1 + preloads))
