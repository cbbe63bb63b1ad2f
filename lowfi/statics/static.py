"""Static load distribution by a convex energy: Lin's model (2019, chapter 2) with its misprints corrected."""

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
from rollbench.lowfi.hertz import contact_force, contact_stiffness
from rollbench.lowfi.statics.held import Mechanism, free_motions
from rollbench.lowfi.statics.kernel_types import BeamArrays, BeamContacts, BeamSystem, Outcome, RowState, Slopes
from rollbench.lowfi.statics.problem import Problem, SolvedState, build, centre_distances, largest_interference
from rollbench.lowfi.statics.result import StaticResult, Status
from rollbench.lowfi.statics.selection import (
    all_sides,
    choose_sides,
    describe_left_out,
    flank_motions,
    shifts_of_beam,
    touched_sides,
)
from rollbench.lowfi.statics.settle import (
    NO_LOADS,
    TOLERANCE,
    Description,
    Prepared,
    Scale,
    SetFlanks,
    least_residual,
    no_state_found,
    options_of,
    report_of,
    settled,
    status_of,
)
from rollbench.lowfi.statics.shape import lifted
from rollbench.lowfi.statics.summary import assemble_result, failed_result, model_assumptions
from rollbench.meshes.arrays import Array, Mask
from rollbench.meshes.errors import Specimen, specimen
from rollbench.meshes.helix import BallLayout, ball_layout
from rollbench.meshes.parts import FREEDOMS, SIDES, Scene
from rollbench.meshes.section import BeamSection

Engine = Literal["auto", "interpreted", "compiled"]

#: Above this many balls the compiled engine pays even for a single solve: where machine code is kept, and where not.
COMPILE_ABOVE, COMPILE_ALONE = 120, 1000
#: The same where flanks are no arcs: every contact is a search for its place on the profile.
COMPILE_UNEVEN = 24
#: Share of the largest force or moment from which on what a pin takes is looked into.
PIN_SHOWN = 1e-9


def pick_engine(engine: Engine, balls: int, uneven: bool = False) -> ModuleType:
    """Return the kernels to use: interpreted for one small solve, compiled for large or many ones.

    Parameters
    ----------
    engine
        ``"interpreted"``, ``"compiled"``, or ``"auto"``.
    balls
        Number of balls.
    uneven
        Whether flanks deviate from circular arcs, with which a contact costs an iteration.
    """
    most = COMPILE_UNEVEN if uneven else COMPILE_ABOVE
    many = balls > most and (uneven or balls > COMPILE_ALONE or jit.is_machine_code_cached(jit.STATICS))
    fast = engine == "compiled" or (engine == "auto" and (jit.is_copy_loaded(jit.STATICS) or many))
    return jit.kernels(jit.STATICS, compiled=fast)


def scale_of(problem: Problem) -> Scale:
    """Return the scales of forces and stiffnesses of a problem.

    A contact that counts as unloaded has the round-off of a typical force. Where only motions are prescribed, which may
    meet no resistance in the end, the typical force says little, and forces that tend to zero must be followed there.

    Parameters
    ----------
    problem
        The static problem.
    """
    arm, load = problem.scene.track.pitch_radius, np.abs(problem.load)
    pair = float((problem.C[:, 0] + problem.C[:, 3]).sum()) / problem.C.shape[0] if problem.C.size else float("nan")
    squeeze = float(contact_force(largest_interference(problem), pair))
    (applied, turning), (largest, most) = ((x[:3], x[3:]) for x in (load.sum(axis=0), load.max(axis=0)))
    force = max(float(applied.sum() + turning.sum() / arm) / max(1, problem.C.shape[0]), squeeze)
    if force == 0.0:  # given motions, or errors that squeeze a ball by three flanks
        force = float(contact_force(1e-6, pair))
    floor = max(float(largest.max()), float(most.max()) / arm, squeeze)
    return Scale(force, float(np.cbrt(force) / pair), floor, (1e-14 if floor > 0.0 else 1e-10) * force)


@dataclass(kw_only=True)
class OneSet(Prepared):
    """Problem of one set of balls, ready for the kernels."""

    #: The problem.
    problem: Problem
    #: Makes it again with other lever arms.
    build: Build

    @property
    def problems(self) -> Sequence[Problem]:
        """The problem, as a sequence of one."""
        return (self.problem,)

    def with_arms(self, arms: Sequence[Array]) -> Self:
        """Return the system with longer lever arms, as `Prepared.with_arms`."""
        longer: Any = self.build.ready(self.build.problem(arms[0]))
        longer.problem.C[:] = self.problem.C
        return longer.at_state(self)  # type: ignore[no-any-return]

    @abstractmethod
    def clears(self) -> bool:
        """Return whether no ball touches a flank that was left out, at the solution."""

    @abstractmethod
    def solved(self) -> SolvedState:
        """Return the solved state with the reactions."""


@dataclass(kw_only=True)
class Beam(OneSet):
    """Screw as a beam, or rigid, in a rigid nut."""

    SOLVER = "solve_beam"
    #: Beam and balls as the kernels take them.
    given: BeamSystem
    #: Motions, deformations and contacts.
    state: RowState

    @property
    def force(self) -> Array:
        """Contact forces ``(N, 4)`` [N]."""
        return np.asarray(self.state.contact[..., 0])

    def flanks(self) -> Sequence[SetFlanks]:
        """Return the contacts at the state."""
        moved = np.zeros((len(self.state.p), 4, 2))
        moved[:, :2] = flank_motions(self.problem, self.state.q)
        return (SetFlanks(self.problem, self.state.contact, self.state.p, moved),)

    def clears(self) -> bool:
        """Return whether no omitted flank touches, by offering all four flanks to every ball."""
        touched = touched_sides(self.engine, self.problem, self.state.q, self.state.p, self.force)
        return not np.any(touched & ~self.problem.use)

    def round_off(self) -> float:
        """Return the residual that rounding leaves, by the largest motion and the stiffest node's flanks together."""
        problem, motion = self.problem, float(np.abs(self.state.q[:, :3]).max(initial=0.0))
        stiff = contact_stiffness(self.force[:, :2], problem.C[:, :2])
        most = float(np.bincount(problem.node.ravel(), weights=stiff.ravel()).max(initial=0.0))
        return least_residual(motion, most, self.scale, [problem])

    def solved(self) -> SolvedState:
        """Return the solved state; the reactions are the energy's gradient at the fixed freedoms."""
        problem, gradient, force = self.problem, np.zeros(self.state.q.shape), self.force.copy()
        motion, centre, normal = self.state.q.copy(), self.state.p.copy(), self.state.contact[..., 1:3].copy()
        if problem.basis is None:
            self.engine.evaluate(self.given, self.state, Slopes(gradient, np.zeros((len(problem.C), 4, 4))))
        held = np.where(problem.fixed, gradient, 0.0)
        return SolvedState(problem, motion, centre, force, normal, held, shifts_of_beam(problem, motion), self.scale)

    def description(self) -> Description:
        """As `Prepared.description`."""
        return Description("convex energy", self.problem.unknowns, model_assumptions(self.problem.scene))


def prepare(problem: Problem, engine: ModuleType, *, tolerance: float = TOLERANCE, build: Build | None = None) -> Beam:
    """Return a problem ready for the kernels, with a start that has the prescribed displacements.

    Parameters
    ----------
    problem
        The static problem.
    engine
        Kernels, plain or compiled.
    tolerance
        Largest relative residual.
    build
        Function that packs the problem for the kernels; None: the beam's.
    """
    lengths, s = np.diff(problem.nodes), problem.section
    sections = np.tile([s.EA, s.EI, s.GJ, s.kGA], (lengths.size, 1))
    count, scale, drawn = problem.C.shape[0], scale_of(problem), problem.drawn
    state = RowState(
        *lifted(problem.nodes, problem.fixed, problem.prescribed),
        np.zeros((count, 2)),
        np.zeros((count, 4, 5)),
        np.zeros((0, 2)),
    )
    geometry, closure = problem.geometry, problem.closure
    contacts = BeamContacts(problem.node, problem.B, geometry, closure, drawn.ball_radius, drawn.profile, scale.none)
    constants, band = np.zeros((lengths.size, 5)), np.zeros((6 * problem.nodes.size, problem.half_bandwidth + 1))
    engine.assemble_beam(lengths, sections, constants, band)
    given = BeamSystem(BeamArrays(lengths, problem.fixed, problem.load, constants, band), contacts)
    arm, furthest = problem.scene.track.pitch_radius, float(drawn.ball_radius.max())
    options = options_of(scale, arm, furthest, tolerance)
    build = build or Build(problem.scene, drawn, problem.layout, problem.use, engine)
    return Beam(engine=engine, given=given, state=state, options=options, problem=problem, build=build)


@dataclass(frozen=True)
class Build:
    """Everything from which a scene's problem is built, and built again with other flanks or lever arms."""

    #: The scene.
    scene: Scene
    #: Parts of the scene with their errors.
    drawn: Specimen
    #: Positions of the balls.
    layout: BallLayout
    #: Flanks to build ``(4,)``.
    use: Mask
    #: Kernels.
    engine: ModuleType
    #: Whether nothing is left out, see `solve_static`.
    everything: bool = False
    #: Elements that each beam element is split into.
    refine: int = 1
    #: `distances` of the parts, where they have been computed.
    known: tuple[Array, Array] | None = None
    #: Fixed freedoms of the nodes and their values ``(n, 6)`` each, and which freedoms of the first node are pins; None: as
    #: the scene has them.
    held: tuple[NDArray[np.bool_], Array, tuple[int, ...]] | None = None

    @property
    def section(self) -> BeamSection | None:
        """Section of the screw; None: the scene's."""
        return None

    def problem(self, arms: Array | None = None) -> Problem:
        """Return the problem; arms: see `lowfi.statics.problem.build`."""
        parts = self.scene, self.drawn, self.layout, self.use
        how: dict[str, Any] = {"everything": self.everything, "refine": self.refine, "known": self.known}
        found = build(*parts, arms=arms, section=self.section, **how)
        held = self.held
        return found if held is None else replace(found, fixed=held[0], prescribed=held[1], pins=held[2])

    def holding(self, pinned: Problem) -> Self:
        """Return a copy with the fixed freedoms of another problem."""
        return replace(self, held=(pinned.fixed, pinned.prescribed, pinned.pins))

    def ready(self, problem: Problem) -> OneSet:
        """Return a problem ready for the kernels."""
        return prepare(problem, self.engine, build=self)

    def touched(self) -> str:
        """Return the note that the flanks left out are touched."""
        names = ", ".join(name for name, used in zip(SIDES, self.use, strict=True) if not used)
        return f"sides {names} touch in the solution without them: solved again with all four"


class Solution(NamedTuple):
    """Scene at the outcome of its solver."""

    #: The system at its last state.
    system: OneSet
    #: Outcome of the solver.
    outcome: Outcome
    #: Function object that built the system.
    build: Build
    #: Free motions of the screw.
    mechanism: Mechanism
    #: Notes on the flanks that were left out.
    notes: tuple[str, ...]
    #: When the system was ready (`time.perf_counter`) [s].
    prepared_at: float

    @property
    def status(self) -> Status:
        """Return the status of the solution."""
        return status_of(self.outcome, self.system.round_off(), partial(unheld, self.system.problem))


class Unheld(NamedTuple):
    """Problem whose load drives a motion that nothing resists."""

    #: The problem.
    problem: Problem
    #: The driven motion.
    mechanism: Mechanism

    @property
    def status(self) -> Status:
        """Status of the problem."""
        return Status("not held", self.mechanism.text)


def solve_sides(build: Build) -> Solution | Unheld:
    """Solve with the flanks of ``build``, and again with all four where a ball touches one of the others."""
    notes: tuple[str, ...] = ()
    while True:
        problem = build.problem()
        mechanism = free_motions(problem)
        if mechanism.driven:
            return Unheld(problem, mechanism)
        problem = pin(problem, mechanism)
        system = build.holding(problem).ready(problem)
        prepared_at = perf_counter()
        system, outcome = settled(system)
        if np.array_equal(build.use, all_sides(build.scene)) or (outcome.status == 0 and system.clears()):
            return Solution(system, outcome, build, mechanism, notes, prepared_at)
        notes = (build.touched(),)
        build = replace(build, use=all_sides(build.scene))


def solve_static(
    scene: Scene,
    *,
    engine: Engine = "auto",
    everything: bool = False,
    member: int = 0,
    refine: int = 1,
    discretisation: bool = False,
) -> StaticResult:
    """Compute contact loads, contact angles and shaft motion of a scene in static equilibrium, by Lin's model.

    The screw is a Timoshenko beam, or rigid, the nut rigid; every contact follows Hertz. The equilibrium is the minimum of
    a convex energy.

    Parameters
    ----------
    scene
        The scene.
    engine
        Kernels: ``"interpreted"``, ``"compiled"``, or ``"auto"``, by size.
    everything
        Whether to leave nothing out: flanks that cannot touch, shaft without influence.
    member
        Number of the specimen, for a scene with random errors.
    refine
        Elements that each beam element is split into.
    discretisation
        Whether to estimate the error of the beam's discretisation too.

    Returns
    -------
    StaticResult
        The result; for a scene without equilibrium its ``status`` gives the reason.

    Raises
    ------
    UnfitKey
        Keys of the scene that contradict each other or that the model cannot represent.

    References
    ----------
    Lin (2019), 2.23 to 2.25.

    Examples
    --------
    >>> import rollbench
    >>> result = solve_static(rollbench.read("lin-case1"))
    >>> result.status, result.load.shape, round(float(result.load.max()), 1)
    ('converged', (32, 4), 243.4)
    """
    start = perf_counter()
    layout = ball_layout(scene)
    drawn = specimen(scene, layout, member)
    kernels = pick_engine(engine, layout.z.size, drawn.profile.shape[1] > 0)
    known = centre_distances(scene, drawn)
    use = all_sides(scene) if everything else choose_sides(scene, drawn, known)
    build = Build(scene, drawn, layout, use, kernels, everything, refine, known)
    result = solve_built(build, "lin", start)
    if discretisation and result.converged:
        result = with_discretisation(scene, result, partial(solve_static, engine=engine, member=member))
    return result


def solve_built(build: Build, name: str, start: float) -> StaticResult:
    """Solve a model for what is built.

    Parameters
    ----------
    build
        What the problem is built from.
    name
        Of the model, for the record.
    start
        When the solve began (`time.perf_counter`) [s].
    """
    solved = solve_sides(build)
    if isinstance(solved, Unheld):
        return failed_result(solved.problem, name, solved.status, perf_counter() - start)
    system, outcome, mechanism = solved.system, solved.outcome, solved.mechanism
    problem, status = system.problem, solved.status
    if outcome.status in NO_LOADS:
        return failed_result(problem, name, status, perf_counter() - start)
    description = system.description()
    report = report_of(outcome, system, description, problem.nodes.size - 1, (start, solved.prepared_at), solved.notes)
    left_out = (*describe_left_out(problem, mechanism, everything=build.everything), *description.left_out)
    result = assemble_result(system.solved(), name, status, report, left_out, description.assumed)

    def otherwise() -> Array | None:
        again = pin(solved.build.problem(), mechanism, True)
        other, found = settled(solved.build.holding(again).ready(again), profile=False)
        return None if no_state_found(found) else other.flanks()[0].contact[..., 0]

    return with_other_pin(result, mechanism, otherwise)


def with_other_pin(result: StaticResult, mechanism: Mechanism, otherwise: Callable[[], Array | None]) -> StaticResult:
    """Return the result with a note on how much the choice of the pin changes the loads, where the pin carries any.

    Parameters
    ----------
    result
        The result.
    mechanism
        Free motions, with the freedoms that could be pinned instead.
    otherwise
        Finds the loads ``(N, 4)`` [N] with the other pins; None where there are none.
    """
    balance = result.equilibrium
    if balance is None or balance.pin_share <= PIN_SHOWN or not result.converged or not mechanism.others:
        return result
    load = otherwise()
    pins, others = (" and ".join(FREEDOMS[k] for k in x) for x in (mechanism.pins, mechanism.others))
    words = f"{mechanism.text} is held by {pins} of the first node; held by {others} instead, "
    if load is None:
        words += "no loads are found"
    else:
        change = float(np.abs(load - result.load).max())
        words += f"loads change by up to {change:.2g} N, the largest is {result.load.max():.4g} N"
    return replace(result, solver=replace(result.solver, notes=(*result.solver.notes, words)))


def pin(problem: Problem, mechanism: Mechanism, other: bool = False) -> Problem:
    """Return the problem with pins at motions that nothing resists and nothing drives.

    Torsion is fixed too where no contact can twist the shaft. other: pin the freedoms that the mechanism names as
    alternative.

    Parameters
    ----------
    problem
        The static problem.
    mechanism
        Motions that nothing resists.
    other
        Whether the alternative freedoms of the mechanism are fixed.
    """
    chosen = mechanism.others if other else mechanism.pins
    if not mechanism.pins and not mechanism.no_torsion:
        return problem
    fixed, prescribed = problem.fixed.copy(), problem.prescribed.copy()
    for k in chosen:
        fixed[0, k] = True
    if mechanism.no_torsion and problem.basis is None:
        held = np.flatnonzero(problem.fixed[:, 5])
        if held.size:  # an untwisted shaft turns as a whole, and in proportion to its length between two supports
            prescribed[:, 5] = np.interp(problem.nodes, problem.nodes[held], prescribed[held, 5])
        fixed[:, 5] = True
    return replace(problem, fixed=fixed, prescribed=prescribed, pins=chosen)


def unheld(problem: Problem) -> Status:
    """Return the status of a screw that moved without limit; "not held" only if a linear program proves it."""
    from rollbench.lowfi.statics.held import describe_motion, opening_motion, ran_away

    opens = "the load opens every contact that could carry it, so the screw moves without limit (linear program: {})"
    return ran_away(partial(opening_motion, problem), "the screw", lambda motion: opens.format(describe_motion(motion)))


def with_discretisation(scene: Scene, result: StaticResult, solve: Callable[..., StaticResult]) -> StaticResult:
    """Return the result with the beam's discretisation error, the largest change of a contact load [N].

    A nodal partition is compared with the same one at half the element length, any other with the nodal one.

    Parameters
    ----------
    scene
        The scene.
    result
        Its result.
    solve
        Computes the result of a scene, with ``refine`` for split elements.
    """
    if scene.ingredients.screw == "rigid":
        return replace(result, solver=replace(result.solver, discretisation=0.0))
    nodal = replace(scene, ingredients=replace(scene.ingredients, partition="nodal"))
    other = solve(scene, refine=2) if scene.ingredients.partition == "nodal" else solve(nodal)
    change = float(np.abs(result.load - other.load).max())
    return replace(result, solver=replace(result.solver, discretisation=change))
