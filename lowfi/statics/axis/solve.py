"""Equilibrium of several bearings and ball nuts on one shaft, as the minimum of one energy, found by Newton's method.

This module contains Lin's model ("lin"); the model with elastic bodies is in `lowfi.statics.axis.elastic`.

Flanks that load and preload lift off the balls are left out, which saves shaft nodes and rows of the matrix. As the energy
is convex, the solution without these flanks is also the solution with them, provided that no ball touches them in it.
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
    ball_positions,
    build,
    motions_of,
    moved_flanks,
    reported_row,
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
    """Guess which flanks of each ball nut or ball bearing can be loaded; `clear` tests the guess at the solution.

    Parameters
    ----------
    assembly
        Shaft with bearings and ball nuts.
    places
        Ball positions and errors, from `ball_positions`.

    Returns
    -------
    list[Mask]
        For each ball nut or ball bearing, whether to use the flanks SL, SR, NL, NR ``(4,)``.
    """
    sets = [(s, s.parts) for s in assembly.sets if isinstance(s.parts, Scene)]
    if len(sets) < len(assembly.sets) or any(s.carrier is not None for s, _ in sets):
        return all_sides(assembly)
    along = axial_place(assembly, sets)
    return [_flanks_of_set(s, scene, along - s.offset, drawn) for (s, scene), (_, drawn) in zip(sets, places, strict=True)]


def axial_place(assembly: Assembly, sets: Sequence[tuple[RollingSet, Scene]]) -> float:
    """Estimate the axial displacement of the shaft [m], with all bodies rigid.

    It is the prescribed displacement of a support, or else the one at which the contact forces of all bearings and nuts
    balance the axial load.
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
        """Return the axial contact forces minus the axial load [N] at an axial displacement u [m] of the shaft."""
        return float(np.sum(np.sign(u - offset) * share * contact_force(abs(u - offset) * sin, pair))) - force

    reach = 1e-9 + float((contact_approach(abs(force) / share, pair) / sin).max())
    return float(brentq(excess, offset.min() - reach, offset.max() + reach, xtol=1e-9))


def _flanks_of_set(rolling: RollingSet, scene: Scene, shift: float, drawn: Specimen) -> Mask:
    """Return which flanks of one ball nut or bearing touch a ball when the shaft moves by ``shift`` [m] along z.

    ``scene``: dimensions of the ball nut or bearing; ``drawn``: these with random errors. A positive shift closes the flank
    pair SL-NR and opens SR-NL by the shift times the sine of the contact angle. Returns truth values ``(4,)`` for SL, SR,
    NL, NR.
    """
    use = USE[rolling.thrust]
    if rolling.thrust != "both" or drawn.profile.shape[1]:
        return use
    closed = centre_distances(scene, drawn)[1] + shift * np.sin(scene.track.contact_angle) * np.array([1.0, -1.0])
    if closed[:, 0].max() > 0.0 >= closed[:, 1].max():
        return USE["+z"]
    return USE["-z"] if closed[:, 1].max() > 0.0 >= closed[:, 0].max() else use


def clear(system: System, state: RowState) -> bool:
    """Return whether no ball of the solved assembly touches a flank that was left out of its equations.

    Only flanks that the direction of thrust of a ball nut or bearing can load are examined.
    """
    return all(_set_clear(system, b, state) for b in system.balls if np.any(USE[b.of.thrust] & ~b.problem.use))


def _set_clear(system: System, b: BallSet, state: RowState) -> bool:
    """Return whether no ball of the ball nut or bearing ``b`` touches a flank that was left out of the equations."""
    contact = state.contact[b.balls]
    shift = moved_flanks(b, state.q)
    for s in range(2):
        if not b.problem.use[s] and b.of.carrier is None:
            shift[:, s] = _flank_motion(system, b, s, state.q)
    place, load = state.p[None, b.balls], contact[None, ..., 0]
    return bool(all_clear(place, shift[None], b.problem.geometry[None], load, b.problem.use)[0])


def _flank_motion(system: System, b: BallSet, s: int, q: Array) -> Array:
    """Return the motion ``(N, 2)`` [m] of screw flank ``s`` (0: SL, 1: SR), which was left out, at each of N balls.

    ``q`` ``(r, 6)``: solved motions of shaft nodes and housings [m, rad], between which the motion is interpolated.
    """
    stations = contact_stations(b.problem.scene, b.problem.layout)[:, s]
    j, m = motions_of(system.structure, stations)
    moved = np.einsum("nab,nb->na", m, np.concatenate([q[j], q[j + 1]], axis=1))
    return motions_in_section(b.problem.layout, b.problem.drawn.centre[:, s], stations, moved)


def all_sides(assembly: Assembly) -> list[Mask]:
    """Return for each ball nut or ball bearing which of SL, SR, NL, NR its direction of thrust can load ``(4,)``."""
    return [USE[s.thrust] for s in assembly.sets if isinstance(s.parts, Scene)]


def uses_all_flanks(uses: Sequence[Mask], assembly: Assembly) -> bool:
    """Return whether the chosen flanks ``uses`` are all flanks that the directions of thrust can load."""
    return all(np.array_equal(a, b) for a, b in zip(uses, all_sides(assembly), strict=True))


def whole_stiffness(
    system: System, engine: ModuleType, given: AxisSystem, state: RowState, hessians: Array
) -> Array | None:
    """Return the tangent stiffness ``(6, 6)`` [N/m, N, N m] of the assembly at the reported shaft node or housing.

    It is the wrench per unit motion there while all other bodies follow freely. Rows and columns of fixed degrees of
    freedom are nan. None if the housing is fixed, or the contacts carry too little load to resist.

    Parameters
    ----------
    system
        Arrays of the assembly.
    engine
        Module of the numerical kernels.
    given
        Arrays of shaft, balls and rollers with which the equilibrium was solved.
    state
        Solution.
    hessians
        Second derivatives of each ball's energy by the motions of its flanks [N/m].
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
    """Return the stiffness ``(6, 6)`` of the free degrees of freedom, from the compliance ``(6, 6)``; nan for the others.

    None if the matrix is not a positive compliance but round-off, as happens if no contact carries load.

    Parameters
    ----------
    compliance
        Compliance matrix ``(6, 6)``.
    free
        Which degrees of freedom are free ``(6,)``.
    arm
        Length [m] that scales rotations to displacements.
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
    """Return the motions ``(N, 4, 6)`` of the two inner flanks, two axes each, per unit motion of the rigid inner part.

    The motion of the inner part is taken at the axial position of the nut or bearing.

    Parameters
    ----------
    b
        The ball nut or bearing, with N balls.
    stations
        Axial positions of all shaft nodes and moving housings [m].
    """
    return b.flank_motions(rigid_transport(stations - b.of.position))[:, :2].reshape(-1, 4, 6)


def set_stiffness(b: BallSet, stations: Array, hessians: Array) -> Array:
    """Return the stiffness ``(6, 6)`` of one ball nut or bearing against motions of its inner part, the outer part fixed.

    Parameters
    ----------
    b
        The ball nut or bearing, with N balls; motions are taken at its axial position.
    stations
        Axial positions of all shaft nodes and moving housings [m].
    hessians
        Second derivatives of each ball's energy by the motions of its inner flanks ``(N, 4, 4)`` [N/m].
    """
    rows = rigid_rows(b, stations)
    return np.asarray(np.einsum("nai,nab,nbj->ij", rows, hessians, rows))


#: If a body moves by more than this times the largest pitch radius, or rotates by more than this [rad], a linear program
#: decides whether the contacts can carry the loads.
FAR = 0.1


@dataclass(kw_only=True)
class Sets(Prepared):
    """Equations of an assembly for the numerical kernels: base class for rigid and for elastic bodies."""

    #: Arrays of the assembly.
    system: System

    @property
    def problems(self) -> Sequence[Problem]:
        """Return the contact problem of each ball nut and ball bearing."""
        return [b.problem for b in self.system.balls]

    @abstractmethod
    def row_states(self) -> tuple[RowState, Array]:
        """Return the motions of shaft nodes and housings with all contacts, and the reactions at fixed freedoms ``(r, 6)``.

        Reactions are forces [N] and moments [N m], zero at free degrees of freedom.
        """

    @abstractmethod
    def stiffness(self) -> tuple[Sequence[Array], Array | None]:
        """Return the tangent stiffness ``(6, 6)`` of each ball nut or bearing, and of the assembly where it is reported.

        The second is None if the assembly has no stiffness there.
        """


@dataclass(kw_only=True)
class RigidSets(Sets):
    """Equations of an assembly whose shaft is a beam and whose nuts, outer rings and housings are rigid (model lin)."""

    SOLVER = "solve_axis"
    #: Arrays of shaft and rolling elements for the kernels.
    given: AxisSystem
    #: Motions, element deformations and contacts: the unknowns of the iteration.
    state: RowState

    def flanks(self) -> Sequence[SetFlanks]:
        """Return contact forces, ball centres and flank motions of each bearing and nut in the present state."""
        return set_flanks(self.system, self.state)

    def with_arms(self, arms: Sequence[Array]) -> Self:
        """Return equations with changed lever arms of the contacts, which start from the present state.

        ``arms``: for each bearing or nut with N balls, the lengths ``(N, 4, 2)`` [m] added to the lever arms.
        """
        system = with_arms(self.system, arms)
        return replace(self, system=system, given=self.given._replace(balls=system.contacts))

    def round_off(self) -> float:
        """Return the relative residual that rounding errors leave.

        It is the larger of two bounds: one from the largest motion and the stiffest contact, one from the springs.
        """
        state, v0 = self.state, self.given.balls.v0
        motion = float(np.abs(state.q[:, :3]).max(initial=0.0)) + float(np.abs(v0).max(initial=0.0))
        stiff = float(state.contact[..., 3].max(initial=0.0)) + float(state.slices[:, 1].max(initial=0.0))
        contacts = least_residual(motion, stiff, self.scale, self.problems)
        springs = spring_terms(self.system.structure, state.q, self.system.arm)
        return max(contacts, least_residual(springs, 1.0, self.scale, ()))

    def description(self) -> Description:
        """Return the formulation and the number of unknowns for the record; the assumptions are those of `Model`."""
        return Description("convex energy", int(np.count_nonzero(~self.system.structure.fixed)), ())

    def slopes(self) -> Slopes:
        """Return the first and second derivatives of the energy in the present state."""
        out = Slopes(np.zeros(self.state.q.shape), np.zeros((len(self.state.p), 8, 8)))
        self.engine.evaluate_axis(self.given, self.state, out)
        return out

    def row_states(self) -> tuple[RowState, Array]:
        """Return the present state, and the reactions: the gradient of the energy at the fixed degrees of freedom."""
        return self.state, np.where(self.system.structure.fixed, self.slopes().gradient, 0.0)

    def stiffness(self) -> tuple[Sequence[Array], Array | None]:
        """Return the tangent stiffness ``(6, 6)`` of each bearing or nut, and of the assembly, see `Sets.stiffness`."""
        system, hessians = self.system, self.slopes().hessians
        sets = [set_stiffness(b, system.structure.stations, hessians[b.balls, :4, :4]) for b in system.balls]
        return sets, whole_stiffness(system, self.engine, self.given, self.state, hessians)


def far_off(q: Array, system: System) -> bool:
    """Return whether a body moved so far that the linear kinematics of the contacts no longer hold.

    Parameters
    ----------
    q
        Motions of shaft nodes and housings ``(r, 6)`` [m, rad].
    system
        Arrays of the assembly.
    """
    return not float((np.abs(q) / np.repeat([system.arm, 1.0], 3)).max()) <= FAR


def prepare(system: System, engine: ModuleType) -> RigidSets:
    """Return the equations of an assembly (model lin), with an initial state that has the prescribed displacements.

    ``system``: arrays of the assembly; ``engine``: module of the numerical kernels, compiled or interpreted.
    """
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
    """Mechanical model by which an assembly is solved."""

    #: Name of the model.
    name: str
    #: Assumptions of the model, as sentences.
    assumed: tuple[str, ...]
    #: Effects that the model neglects, as sentences.
    left_out: tuple[str, ...]
    #: Function that makes the equations for the kernels from the arrays of an assembly.
    ready: Callable[[System, ModuleType], Sets]
    #: Cross-section of the threaded shaft; None: computed from the assembly's dimensions.
    section: BeamSection | None
    #: Whether flanks are left out that load and offsets lift off the balls.
    fewer: bool


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
    model = Model("lin", AXIS_ASSUMPTIONS, (), prepare, None, True)
    return equilibrium(assembly, model, engine, member, partial(solve_assembly, engine=engine, member=member))


def equilibrium(assembly: Assembly, model: Model, engine: Engine, member: int, again: partial[AxisResult]) -> AxisResult:
    """Compute the static equilibrium of an assembly by a model, and return forces, stiffness and motions.

    Parameters
    ----------
    assembly
        Shaft with bearings and ball nuts.
    model
        Mechanical model.
    engine, member
        Kernels, and number of the specimen with random errors, as for `solve_assembly`.
    again
        Function that solves another assembly by the same model, to find the axial offsets that give the required preloads.
    """
    start = perf_counter()

    def failed(status: Status) -> AxisResult:
        """Return the result of an assembly without equilibrium."""
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
        if uses_all_flanks(uses, mounted) or (outcome.status == 0 and clear(prepared.system, prepared.state)):
            break
        uses = all_sides(mounted)
        notes = (*notes, "balls touch flanks that load or offset should lift off: solved again with all flanks")
    state, held = prepared.row_states()
    proven = system if model.fewer else prepared.system  # elastic bodies: loose motions stay fixed in the proof
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
    """Return the module of numerical kernels, compiled or interpreted, that suits the size of an assembly.

    ``engine``: the user's choice, see `pick_engine`. The size counts the balls, the rollers' slices at a quarter each, and
    a further solve for each preload.
    """
    slices = sum(s.parts.count * s.parts.slices for s in assembly.sets if isinstance(s.parts, RollerRow))
    preloads = sum(s.preload > 0.0 for s in assembly.sets)
    return pick_engine(engine, (assembly.ball_count + slices // 4) * (1 + preloads))
