"""Static load distribution by the convex energy: the source's model (Lin chapter 2) with its misprints mended."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from time import perf_counter
from types import ModuleType
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi import jit
from rollbench.lowfi.hertz import contact_force, contact_stiffness
from rollbench.lowfi.statics.mechanism import Mechanism, free_motions
from rollbench.lowfi.statics.problem import Problem, build, distances, tightest
from rollbench.lowfi.statics.records import BeamArrays, BeamContacts, BeamSlopes, BeamState, Options, Outcome
from rollbench.lowfi.statics.result import StaticResult, Status
from rollbench.lowfi.statics.selection import (
    all_sides,
    choose_sides,
    describe_left_out,
    flank_motions,
    shifts_of_beam,
    touched_sides,
)
from rollbench.lowfi.statics.settle import NO_LOADS, Contacts, Flanks, least_residual, lost, report_of, settled, verdict
from rollbench.lowfi.statics.shape import lifted
from rollbench.lowfi.statics.solved import SolvedState
from rollbench.lowfi.statics.summary import assemble_result, failed_result, model_assumptions
from rollbench.meshes.arrays import Array, Mask
from rollbench.meshes.errors import Specimen, specimen
from rollbench.meshes.helix import BallLayout, ball_layout
from rollbench.meshes.parts import FREEDOMS, Scene

Engine = Literal["auto", "interpreted", "compiled"]

#: Relative residual that the solver drives for.
TOLERANCE = 1e-14
MAX_ITERATIONS = 3000
#: Above this many balls the compiled engine pays even for a single solve: where machine code is kept, and where not.
COMPILE_ABOVE, COMPILE_ALONE = 120, 1000
#: The same where flanks are no arcs: every contact is a search for its place on the profile.
COMPILE_UNEVEN = 24
#: Share of the largest force or moment from which on what a pin takes is looked into.
PIN_SHOWN = 1e-9


@dataclass
class Prepared:
    """A problem ready for the kernels: their arguments, the state they fill, and the largest force met [N]."""

    problem: Problem
    engine: ModuleType
    beam: BeamArrays
    contacts: BeamContacts
    state: BeamState
    options: Options
    history: Array
    scale: float = 0.0

    @property
    def force(self) -> Array:
        """Contact forces, ``(N, 4)`` [N]."""
        return np.asarray(self.state.contact[..., 0])

    @property
    def normal(self) -> Array:
        """Unit normals from ball to groove in the section plane, ``(N, 4, 2)``."""
        return np.asarray(self.state.contact[..., 1:3])


def pick_engine(engine: Engine, balls: int, uneven: bool = False) -> ModuleType:
    """Interpreted kernels for one small solve, compiled ones for large or many; uneven: flanks that are no arcs."""
    most = COMPILE_UNEVEN if uneven else COMPILE_ABOVE
    many = balls > most and (uneven or balls > COMPILE_ALONE or jit.cached(jit.STATICS))
    fast = engine == "compiled" or (engine == "auto" and (jit.loaded(jit.STATICS) or many))
    return jit.kernels(jit.STATICS, compiled=fast)


class Scale(NamedTuple):
    """Scales of the forces and stiffnesses of a problem.

    force [N]: of a typical loaded contact, from loads, interference, or else an approach of a micrometre; stiffness [N/m]:
    its secant; floor [N]: the least that residuals are measured by: the largest load, moments over the arm, or the force by
    which the tightest ball is pressed without load; none [N]: of a contact that counts as none.
    """

    force: float
    stiffness: float
    floor: float
    none: float

    @property
    def typical(self) -> float:
        """Force [N] above zero at which small terms that depend on a contact's size are taken."""
        return max(self.force, 1e-6)


def scale_of(problem: Problem) -> Scale:
    """The scale of a problem.

    A contact that counts as none has the round-off of a typical force. Where only motions are given, which may meet no
    resistance in the end, the typical one says little, and forces on their way to nothing must get there.
    """
    arm, load = problem.scene.track.pitch_radius, np.abs(problem.load)
    pair = float((problem.C[:, 0] + problem.C[:, 3]).sum()) / problem.C.shape[0] if problem.C.size else float("nan")
    squeeze = float(contact_force(tightest(problem), pair))
    (applied, turning), (largest, most) = ((x[:3], x[3:]) for x in (load.sum(axis=0), load.max(axis=0)))
    force = max(float(applied.sum() + turning.sum() / arm) / max(1, problem.C.shape[0]), squeeze)
    if force == 0.0:  # given motions, or errors that squeeze a ball by three flanks
        force = float(contact_force(1e-6, pair))
    floor = max(float(largest.max()), float(most.max()) / arm, squeeze)
    return Scale(force, float(np.cbrt(force) / pair), floor, (1e-14 if floor > 0.0 else 1e-10) * force)


def options_of(problem: Problem, scale: Scale, tolerance: float = TOLERANCE) -> Options:
    """How the solvers iterate on a problem of a scale, with rigid outer parts or elastic bodies."""
    return Options(
        tolerance=tolerance,
        most=MAX_ITERATIONS,
        stiffness=scale.stiffness,
        arm=float(problem.scene.track.pitch_radius),
        bound=1e3,
        floor=scale.floor,
        furthest=float(problem.drawn.ball_radius.max()),
    )


def prepare(problem: Problem, engine: ModuleType, *, tolerance: float = TOLERANCE) -> Prepared:
    """Arrays for the kernels, with a start that meets the prescribed displacements."""
    nodes = problem.nodes
    lengths = nodes[1:] - nodes[:-1]
    s = problem.section
    sections = np.empty((lengths.size, 4))
    sections[:] = s.EA, s.EI, s.GJ, s.kGA
    count, scale = problem.C.shape[0], scale_of(problem)
    q, d = lifted(nodes, problem.fixed, problem.prescribed)
    contacts = BeamContacts(
        problem.node,
        problem.B,
        problem.geometry,
        problem.closure,
        problem.drawn.ball_radius,
        problem.drawn.profile,
        scale.none,
    )
    state = BeamState(q, d, np.zeros((count, 2)), np.zeros((count, 4, 5)))
    constants, band = np.zeros((lengths.size, 5)), np.zeros((6 * nodes.size, problem.half_bandwidth + 1))
    engine.assemble_beam(lengths, sections, constants, band)
    beam = BeamArrays(lengths, problem.fixed, problem.load, constants, band)
    options = options_of(problem, scale, tolerance)
    return Prepared(problem, engine, beam, contacts, state, options, np.zeros(options.most + 1))


def iterate(prepared: Prepared, start: bool = True) -> Outcome:
    """Solve from the linear start (or from the present state)."""
    solve = prepared.engine.start_and_solve if start else prepared.engine.solve_beam
    outcome: Outcome = solve(prepared.beam, prepared.contacts, prepared.state, prepared.options, prepared.history)
    prepared.scale = outcome.scale
    return outcome


def round_off_bound(prepared: Prepared, scale: float) -> float:
    """Relative residual that double precision cannot get below (`lowfi.statics.settle.least_residual`), by the largest
    motion and the largest stiffness of a node's flanks, summed."""
    q, force = prepared.state.q, prepared.force
    problem = prepared.problem
    motion = float(np.abs(q[:, :3]).max(initial=0.0))
    stiff = contact_stiffness(force[:, :2], problem.C[:, :2])
    most = float(np.bincount(problem.node.ravel(), weights=stiff.ravel()).max(initial=0.0))
    return least_residual(motion, most, scale, [problem])


class Solution(NamedTuple):
    """A problem at the outcome of its solver, its unheld motions, the sides it was built with ``(4,)``, notes on these, and
    when it was prepared (`time.perf_counter`)."""

    prepared: Prepared
    outcome: Outcome
    mechanism: Mechanism
    use: Mask
    notes: tuple[str, ...]
    prepared_at: float


class Unheld(NamedTuple):
    """A problem whose load drives motions that nothing holds."""

    problem: Problem
    mechanism: Mechanism

    @property
    def status(self) -> Status:
        """Status sentence."""
        return Status("not held", self.mechanism.text)


def solve_sides(
    scene: Scene,
    drawn: Specimen,
    layout: BallLayout,
    kernels: ModuleType,
    use: Mask,
    *,
    everything: bool = False,
    refine: int = 1,
    known: tuple[Array, Array] | None = None,
) -> Solution | Unheld:
    """Solve with the sides ``use`` (4,), and again with all four where a ball touches the others; known: the specimen's
    ``distances``, where they have been computed."""
    notes: tuple[str, ...] = ()
    while True:
        problem = build(scene, drawn, layout, use, everything=everything, refine=refine, known=known)
        mechanism = free_motions(problem)
        if mechanism.driven:
            return Unheld(problem, mechanism)
        prepared = prepare(pin(problem, mechanism), kernels)
        prepared_at = perf_counter()
        outcome = settle(prepared, everything=everything, refine=refine)
        touched = touched_sides(kernels, prepared.problem, prepared.state.q, prepared.state.p, prepared.force)
        if (outcome.status == 0 and not np.any(touched & ~use)) or np.array_equal(use, all_sides(scene)):
            return Solution(prepared, outcome, mechanism, use, notes, prepared_at)
        notes = (f"sides {', '.join(_names(~use))} touch in the solution without them: solved again with all four",)
        use = all_sides(scene)


def solve_static(
    scene: Scene,
    *,
    engine: Engine = "auto",
    everything: bool = False,
    member: int = 0,
    refine: int = 1,
    discretisation: bool = False,
) -> StaticResult:
    """Contact loads, contact angles and shaft motion of a scene in static equilibrium (Lin 2.23-2.25).

    engine: interpreted, compiled, or chosen by size; everything: leave nothing out; member: which specimen of a scene
    with random errors; refine: split every element; discretisation: also estimate the beam's discretisation error. Never
    raises for a scene without equilibrium: ``status`` names the reason.
    """
    start = perf_counter()
    layout = ball_layout(scene)
    drawn = specimen(scene, layout, member)
    kernels = pick_engine(engine, layout.z.size, drawn.profile.shape[1] > 0)
    known = distances(scene, drawn)
    use = all_sides(scene) if everything else choose_sides(scene, drawn, known)
    solved = solve_sides(scene, drawn, layout, kernels, use, everything=everything, refine=refine, known=known)
    if isinstance(solved, Unheld):
        return failed_result(solved.problem, "lin", solved.status, perf_counter() - start)
    prepared, outcome, mechanism, use = solved.prepared, solved.outcome, solved.mechanism, solved.use
    problem = prepared.problem
    bound = round_off_bound(prepared, outcome.scale)
    status = verdict(outcome, bound, partial(unheld, problem))
    if outcome.status in NO_LOADS:
        return failed_result(problem, "lin", status, perf_counter() - start)
    system = "convex energy", problem.unknowns, problem.nodes.size - 1
    report = report_of(outcome, kernels, (start, solved.prepared_at), system, bound, solved.notes)
    left_out = describe_left_out(problem, mechanism, everything=everything)
    result = assemble_result(solved_state(prepared), "lin", status, report, left_out, model_assumptions(scene))

    def otherwise() -> Array | None:
        built = build(scene, drawn, layout, use, everything=everything, refine=refine)
        other = prepare(pin(built, mechanism, True), kernels)
        return None if lost(settle(other, profile=False)) else other.force

    result = with_other_pin(result, mechanism, otherwise)
    if discretisation and result.converged:
        result = with_discretisation(scene, result, partial(solve_static, engine=engine, member=member))
    return result


def solved_state(prepared: Prepared) -> SolvedState:
    """State in the kernels' arrays, with the reactions: the gradient at the held freedoms."""
    problem, (q, _, p, _) = prepared.problem, prepared.state
    motion, centre, force, normal = (np.array(x) for x in (q, p, prepared.force, prepared.normal))
    gradient = np.zeros(motion.shape)
    if problem.basis is None:
        hessians = np.zeros((force.shape[0], 4, 4))
        prepared.engine.evaluate(prepared.beam, prepared.contacts, prepared.state, BeamSlopes(gradient, hessians))
    held = np.where(problem.fixed, gradient, 0.0) if problem.basis is None else gradient
    return SolvedState(problem, motion, centre, force, normal, held, shifts_of_beam(problem, motion), prepared.scale)


def _names(mask: NDArray[np.bool_]) -> list[str]:
    return [n for n, m in zip(("SL", "SR", "NL", "NR"), mask, strict=True) if m]


def with_other_pin(result: StaticResult, mechanism: Mechanism, otherwise: Callable[[], Array | None]) -> StaticResult:
    """The result, with a note on how much the choice of the pin moves its loads where the pin takes any; otherwise: finds
    the loads ``(N, 4)`` [N] with the other one, None where there are none."""
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
    """Hold motions that nothing resists and nothing drives, and torsion where no contact can twist the shaft.

    other: by the freedoms that the mechanism names besides its pins.
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


def settle(prepared: Prepared, *, everything: bool = False, refine: int = 1, profile: bool = True) -> Outcome:
    """Solve, and follow the contacts (`lowfi.statics.settle.settled`); profile: lever arms on uneven flanks too."""

    def contacts() -> list[Contacts]:
        return [Contacts(prepared.problem, prepared.state.contact)]

    def flanks() -> list[Flanks]:
        problem, moved = prepared.problem, np.zeros((prepared.problem.layout.z.size, 4, 2))
        moved[:, :2] = flank_motions(problem, prepared.state.q)
        return [Flanks(problem, prepared.state.contact, prepared.state.p, moved)]

    def rebuild(arms: list[Array]) -> Outcome:
        p = prepared.problem
        rebuilt = build(p.scene, p.drawn, p.layout, p.use, everything=everything, refine=refine, arms=arms[0])
        rebuilt = replace(rebuilt, fixed=p.fixed, prescribed=p.prescribed, pins=p.pins)
        rebuilt.C[:] = p.C
        prepared.problem = rebuilt
        prepared.contacts = prepared.contacts._replace(B=rebuilt.B, geometry=rebuilt.geometry)
        return iterate(prepared, start=False)

    hertz = prepared.problem.scene.ingredients.hertz
    return settled(partial(iterate, prepared), contacts, flanks, rebuild if profile else None, hertz)


def unheld(problem: Problem) -> Status:
    """Status sentence of a screw that ran away: not held only where a linear program proves it."""
    from rollbench.lowfi.statics.proof import opening_motion, ran_away, words_of

    opens = "the load opens every contact that could carry it, so the screw moves without limit (linear program: {})"
    return ran_away(partial(opening_motion, problem), "the screw", lambda motion: opens.format(words_of(motion)))


def with_discretisation(scene: Scene, result: StaticResult, solve: Callable[..., StaticResult]) -> StaticResult:
    """Add the beam's discretisation error: largest change of a contact load [N].

    A nodal partition is compared with the same one at half the element length, any other with the nodal one; solve: finds
    the result of a scene, or of its elements ``refine`` times split.
    """
    if scene.ingredients.screw == "rigid":
        return replace(result, solver=replace(result.solver, discretisation=0.0))
    nodal = replace(scene, ingredients=replace(scene.ingredients, partition="nodal"))
    other = solve(scene, refine=2) if scene.ingredients.partition == "nodal" else solve(nodal)
    change = float(np.abs(result.load - other.load).max())
    return replace(result, solver=replace(result.solver, discretisation=change))


__all__ = ["BallLayout", "Prepared", "iterate", "prepare", "solve_static"]
