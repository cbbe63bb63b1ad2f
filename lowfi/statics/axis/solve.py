"""Equilibrium of several rolling sets on one shaft, by the source's model (`lin`): one energy, Newton's method."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from time import perf_counter
from types import ModuleType

import numpy as np

from rollbench.lowfi.statics.axis.loose import loose_motions, pinned
from rollbench.lowfi.statics.axis.mount import mount
from rollbench.lowfi.statics.axis.proof import unheld
from rollbench.lowfi.statics.axis.sides import all_sides, clear, complete, likely_sides
from rollbench.lowfi.statics.axis.stiffness import set_stiffness, whole_stiffness
from rollbench.lowfi.statics.axis.summary import AXIS_ASSUMPTIONS, Ending, assemble_axis, failed_axis
from rollbench.lowfi.statics.axis.system import System, build, placed, set_contacts, set_flanks, with_arms
from rollbench.lowfi.statics.axis.typical import typical
from rollbench.lowfi.statics.records import AxisSlopes, AxisState, Options, Outcome
from rollbench.lowfi.statics.result import AxisResult, SolverReport, Status
from rollbench.lowfi.statics.settle import NO_LOADS, Contacts, Flanks, least_residual, report_of, settled, verdict
from rollbench.lowfi.statics.shape import lifted
from rollbench.lowfi.statics.static import MAX_ITERATIONS, TOLERANCE, Engine, pick_engine
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, RollerRow

#: Motion over the largest pitch radius, and rotation, from which on a linear program says whether contacts hold the loads.
FAR = 0.1


@dataclass
class Prepared:
    """A system ready for the kernels: what is held, the state they fill, and their engine."""

    system: System
    engine: ModuleType
    state: AxisState
    options: Options
    history: Array
    scale: float = 0.0


def far_off(q: Array, system: System) -> bool:
    """Whether rows go so far by their motions q (r, 6) that contacts may hold by a curvature that linear motions lack."""
    return not float((np.abs(q) / np.repeat([system.arm, 1.0], 3)).max()) <= FAR


def prepare(system: System, engine: ModuleType, *, tolerance: float = TOLERANCE) -> Prepared:
    """Arrays for the kernels, with a start that meets the prescribed displacements."""
    s, n = system.structure, system.structure.nodes.size
    force, stiffness, floor = typical(system)
    q = np.zeros((s.stations.size, 6))
    q[:n], d = lifted(s.nodes, s.fixed[:n], s.prescribed[:n])
    q[n:] = np.where(s.fixed[n:], s.prescribed[n:], 0.0)
    N, M = system.contacts.r_ball.size, system.slices.drop.size
    state = AxisState(q, d, np.zeros((N, 2)), np.zeros((N, 4, 5)), np.zeros((M, 2)))
    system.contacts = system.contacts._replace(tiny=1e-14 * force)
    furthest = float(system.contacts.r_ball.max(initial=0.0))
    options = Options(tolerance, MAX_ITERATIONS, stiffness, system.arm, 1e3, floor, furthest)
    return Prepared(system, engine, state, options, np.zeros(options.most + 1))


def iterate(prepared: Prepared, *, start: bool = True) -> Outcome:
    """Solve from the linear start, or from the present state."""
    arrays = prepared.system.axis, prepared.system.contacts, prepared.system.slices
    if start:
        prepared.engine.start_axis(*arrays, prepared.state, prepared.options)
    outcome: Outcome = prepared.engine.solve_axis(*arrays, prepared.state, prepared.options, prepared.history)
    prepared.scale = outcome.scale
    return outcome


def solve_assembly(assembly: Assembly, *, engine: Engine = "auto", member: int = 0) -> AxisResult:
    """Loads, stiffness and motions of an assembly in static equilibrium, screw a beam, outer parts rigid.

    engine: interpreted, compiled, or chosen by size; member: which specimen of random errors. Never raises for a scene
    without equilibrium: ``status`` names the reason. Raises ValueError for dimensions that leave no body.
    """
    start = perf_counter()
    mounted, notes, unmet = mount(assembly, partial(solve_assembly, engine=engine, member=member))
    if unmet:
        return failed_axis(assembly, "lin", unmet, perf_counter() - start)
    kernels = engine_for(assembly, engine)
    places = placed(mounted, member)
    uses = likely_sides(mounted, places)
    while True:
        system = build(mounted, member, uses, places)
        loose = loose_motions(system)
        if loose.driven:
            return failed_axis(assembly, "lin", Status("not held", loose.text), perf_counter() - start)
        prepared = prepare(pinned(system, loose), kernels)
        ready = perf_counter()
        outcome = settle(prepared)
        if complete(uses, mounted) or (outcome.status == 0 and clear(prepared.system, prepared.state)):
            break
        uses = all_sides(mounted)
        notes = (*notes, "flanks that load or offsets should open touch in the solution: solved again with all of them")
    bound = round_off(prepared, outcome.scale)
    far = far_off(prepared.state.q, system)
    status = verdict(outcome, bound, partial(unheld, system), far)
    if outcome.status in NO_LOADS:
        return failed_axis(assembly, "lin", status, perf_counter() - start)
    size = "convex energy", int(np.count_nonzero(~prepared.system.structure.fixed)), system.structure.nodes.size - 1
    report = report_of(outcome, kernels, (start, ready), size, bound, notes)
    return assemble_axis(prepared.system, prepared.state, _ending(prepared, status, report, loose.text))


def _ending(prepared: Prepared, status: Status, report: SolverReport, loose: str) -> Ending:
    """Reactions and stiffnesses at the state."""
    system, state = prepared.system, prepared.state
    out = AxisSlopes(np.zeros(state.q.shape), np.zeros((system.contacts.r_ball.size, 8, 8)))
    prepared.engine.evaluate_axis(system.axis, system.contacts, system.slices, state, out)
    held = np.where(system.structure.fixed, out.gradient, 0.0)
    sets = [set_stiffness(b, system.structure.stations, out.hessians[b.balls, :4, :4]) for b in system.balls]
    tangent = whole_stiffness(system, prepared.engine, state, out.hessians)
    return Ending(status, report, loose, held, sets, tangent, "lin", AXIS_ASSUMPTIONS, scale=prepared.scale)


def engine_for(assembly: Assembly, engine: Engine) -> ModuleType:
    """Interpreted kernels for one small solve, compiled ones for many elements, several solves, or where they are ready."""
    slices = sum(s.parts.count * s.parts.slices for s in assembly.sets if isinstance(s.parts, RollerRow))
    preloads = sum(s.preload > 0.0 for s in assembly.sets)
    return pick_engine(engine, (assembly.ball_count + slices // 4) * (1 + preloads))


def settle(prepared: Prepared) -> Outcome:
    """Solve, and follow the contacts (`lowfi.statics.settle.settled`)."""

    def iterated(start: bool) -> Outcome:
        return iterate(prepared, start=start)

    def rebuild(arms: list[Array]) -> Outcome:
        prepared.system = with_arms(prepared.system, arms)
        return iterated(False)

    def contacts() -> list[Contacts]:
        return set_contacts(prepared.system, prepared.state.contact)

    def flanks() -> list[Flanks]:
        return set_flanks(prepared.system, prepared.state)

    return settled(iterated, contacts, flanks, rebuild, prepared.system.assembly.ingredients.hertz)


def round_off(prepared: Prepared, scale: float) -> float:
    """Relative residual that double precision cannot get below: see `lowfi.statics.settle.least_residual`."""
    state = prepared.state
    motion = float(np.abs(state.q[:, :3]).max(initial=0.0)) + float(np.abs(prepared.system.contacts.v0).max(initial=0.0))
    stiff = float(state.contact[..., 3].max(initial=0.0)) + float(state.slices[:, 1].max(initial=0.0))
    return least_residual(motion, stiff, scale, [b.problem for b in prepared.system.balls])
