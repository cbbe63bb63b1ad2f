"""Equilibrium of several rolling sets on one shaft, by the source's model (`lin`): one energy, Newton's method."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from types import ModuleType

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr

from lowfi import jit
from lowfi.statics.axis.result import AxisResult
from lowfi.statics.axis.structure import held_rows, rigid_motions
from lowfi.statics.axis.summary import assemble_axis, failed_axis
from lowfi.statics.axis.system import System, build
from lowfi.statics.problem import actual_hertz
from lowfi.statics.records import AxisState, BeamOptions, Outcome
from lowfi.statics.result import SolverReport
from lowfi.statics.static import MAX_ITERATIONS, NO_LOADS, TOLERANCE, Engine, contact_angles, pick_engine, verdict
from meshes.axis import Assembly, RollingSet
from meshes.parts import FREEDOMS

Array = NDArray[np.float64]

#: Part of a preload by force that its error may have.
PRELOAD = 1e-12


@dataclass
class Prepared:
    """A system ready for the kernels: what is held, the state they fill, and their engine."""

    system: System
    engine: ModuleType
    state: AxisState
    options: BeamOptions
    history: Array
    scale: float = 0.0


def typical(system: System) -> tuple[float, float, float]:
    """Force [N] of a typical loaded contact, its secant stiffness [N/m], and least force [N] that residuals count by."""
    load = system.structure.load
    elements = max(1, system.contacts.r_ball.size + sum(r.row.count for r in system.rollers))
    applied = float(np.abs(load[:, :3]).sum() + np.abs(load[:, 3:]).sum() / system.arm)
    force, stiffness, floor = applied / elements, 1.0, 0.0
    squeezed = 0.0
    for b in system.balls:
        C = b.problem.C
        pair = float(np.mean(C[:, 0] + C[:, 3]))
        squeeze = max(
            0.0, float(b.problem.closure.max(initial=0.0)), abs(b.of.offset) * np.sin(b.problem.scene.track.contact_angle)
        )
        squeezed = max(squeezed, (squeeze / pair) ** 1.5)
        if force == 0.0 and squeezed == 0.0 and np.any(system.structure.prescribed):
            squeezed = (1e-6 / pair) ** 1.5
    force = max(force, squeezed)
    for b in system.balls:
        pair = float(np.mean(b.problem.C[:, 0] + b.problem.C[:, 3]))
        stiffness = max(stiffness, float(np.cbrt(force) / pair) if force > 0.0 else 1.0)
    for r in system.rollers:
        per_length = max(force, 1.0) / r.row.length
        law = r.arrays
        stiffness = max(stiffness, r.row.length / r.row.slices / float(law.g[0] - law.s[0] * np.log(per_length)))
    floor = max(float(np.abs(load[:, :3]).max()), float(np.abs(load[:, 3:]).max()) / system.arm, squeezed)
    return force, stiffness, floor


def prepare(system: System, engine: ModuleType, *, tolerance: float = TOLERANCE) -> Prepared:
    """Arrays for the kernels, with a start that meets the prescribed displacements."""
    s, n = system.structure, system.structure.nodes.size
    force, stiffness, floor = typical(system)
    q = np.zeros((s.stations.size, 6))
    for k in range(6):
        held = np.flatnonzero(s.fixed[:n, k])
        if held.size:
            q[:n, k] = np.interp(s.nodes, s.nodes[held], s.prescribed[held, k])
    q[n:] = np.where(s.fixed[n:], s.prescribed[n:], 0.0)
    lengths = np.diff(s.nodes)
    moved = q[: n - 1].copy()
    moved[:, 0] += lengths * q[: n - 1, 4]
    moved[:, 1] -= lengths * q[: n - 1, 3]
    N, M = system.contacts.r_ball.size, system.slices.drop.size
    state = AxisState(q, q[1:n] - moved, np.zeros((N, 2)), np.zeros((N, 4, 5)), np.zeros((M, 2)))
    system.contacts = system.contacts._replace(tiny=1e-14 * force)
    options = BeamOptions(tolerance, MAX_ITERATIONS, stiffness, system.arm, 1e3, 0, floor)
    return Prepared(system, engine, state, options, np.zeros(MAX_ITERATIONS + 1))


def run(prepared: Prepared, *, start: bool = True) -> Outcome:
    """Solve from the linear start, or from the state as it is."""
    arrays = prepared.system.axis, prepared.system.contacts, prepared.system.slices
    if start:
        prepared.engine.start_axis(*arrays, prepared.state, prepared.options)
    outcome: Outcome = prepared.engine.solve_axis(*arrays, prepared.state, prepared.options, prepared.history)
    prepared.scale = outcome.scale
    return outcome


@dataclass(frozen=True)
class Loose:
    """Rigid motions that nothing resists: whether the loads drive one, its words, and freedoms (rows, freedom) to hold."""

    driven: bool
    text: str
    pins: tuple[tuple[int, int], ...] = ()


def loose_motions(system: System) -> Loose:
    """Motions of shaft and housings as rigid bodies without resistance from supports, springs or rolling elements.

    As `lowfi.statics.mechanism.free_motions`, the motion at a ball's centre stands for its flanks.
    """
    s = system.structure
    motions = rigid_motions(s, system.arm)
    rows = [held_rows(s, motions)]
    by_row = motions.reshape(-1, 6, motions.shape[1])
    n = s.nodes.size
    for b in system.balls:
        layout = b.problem.layout
        axes = np.stack([layout.radial, layout.binormal], axis=1)
        moved = np.zeros((2 * layout.z.size, motions.shape[1]))
        for row, sign in ((0, 1.0), (b.outer, -1.0)):
            if row >= 0:
                arm = layout.centre - np.array([0.0, 0.0, s.stations[row]])
                lever = np.concatenate([axes, np.cross(arm[:, None, :], axes)], axis=2)
                moved += sign * (lever @ by_row[row]).reshape(len(moved), -1)
        rows.append(moved)
    for roller in system.rollers:
        a = roller.arrays
        moved = np.zeros((a.drop.size, motions.shape[1]))
        for end in range(2):
            if a.row[0, end] >= 0:
                moved += a.B[:, end] @ by_row[a.row[0, end]]
        rows.append(moved)
    _, size, vt = np.linalg.svd(np.concatenate(rows))
    rank = int((size > 1e-9 * max(1.0, size.max(initial=0.0))).sum())
    null = vt[rank:]
    if not null.shape[0]:
        return Loose(False, "")
    free = (motions @ null.T).reshape(-1, 6, null.shape[0])
    drive = np.einsum("rkc,rk->c", free, s.load)
    total = float(np.abs(s.load[:, :3]).sum() + np.abs(s.load[:, 3:]).sum() / system.arm)
    text = _words(system, free)
    if total > 0.0 and float(np.abs(drive).max()) > 1e-9 * total:
        return Loose(True, f"{text}: no support, spring or rolling element resists it, and the loads drive it")
    rows_of = [0, *range(n, s.stations.size)]
    flat = free[rows_of].reshape(-1, null.shape[0])
    arms = np.tile([1.0, 1.0, 1.0, system.arm, system.arm, system.arm], len(rows_of))
    _, _, order = qr((flat * arms[:, None]).T, pivoting=True)
    return Loose(False, text, tuple((rows_of[k // 6], int(k % 6)) for k in order[: null.shape[0]]))


def _words(system: System, free: Array) -> str:
    """Words for the free motions."""
    s, n = system.structure, system.structure.nodes.size
    names = {row: name for name, row in s.row.items() if row >= 0}
    arms = np.array([1.0, 1.0, 1.0, system.arm, system.arm, system.arm])
    found = []
    for row in (0, *range(n, s.stations.size)):
        size = np.abs(free[row] * arms[:, None]).max(axis=1)
        which = [name for name, x in zip(FREEDOMS, size, strict=True) if x > 1e-6 * np.abs(free).max()]
        if which:
            found.append(f"{'the shaft' if row == 0 else names[row]} in {', '.join(which)}")
    return "rigid motion of " + " and ".join(found)


def pinned(system: System, loose: Loose) -> System:
    """The system with the loose motions held where they are."""
    if not loose.pins:
        return system
    fixed = system.structure.fixed.copy()
    for row, k in loose.pins:
        fixed[row, k] = True
    structure = replace(system.structure, fixed=fixed)
    return replace(system, structure=structure, axis=system.axis._replace(fixed=fixed))


def solve_assembly(assembly: Assembly, *, engine: Engine = "auto", member: int = 0) -> AxisResult:
    """Loads, stiffness and motions of an assembly in static equilibrium, screw a beam, outer parts rigid.

    engine: interpreted, compiled, or chosen by size; member: which specimen of random errors. Never raises for a scene
    without equilibrium: ``status`` names the reason. Raises ValueError for dimensions that leave no body.
    """
    start = perf_counter()
    kernels = pick_engine(
        engine, assembly.ball_count + sum(10 for s in assembly.sets if s.kind == "tapered roller bearing")
    )
    mounted, notes = mount(assembly, kernels, member)
    system = build(mounted, member)
    loose = loose_motions(system)
    if loose.driven:
        return failed_axis(assembly, "lin", f"not held: {loose.text}", perf_counter() - start)
    prepared = prepare(pinned(system, loose), kernels)
    ready = perf_counter()
    outcome = solve_with_hertz(prepared)
    bound = round_off(prepared, outcome.scale)
    status = verdict(outcome, bound)
    if outcome.status in NO_LOADS:
        return failed_axis(assembly, "lin", status, perf_counter() - start)
    report = SolverReport(
        iterations=outcome.iterations,
        evaluations=outcome.evaluations,
        residual=outcome.residual,
        seconds=perf_counter() - start,
        unknowns=int(np.count_nonzero(~prepared.system.structure.fixed)),
        elements=system.structure.nodes.size - 1,
        engine="compiled" if jit.is_compiled(kernels.__name__) else "interpreted",
        formulation="convex energy",
        round_off_bound=bound,
        setup_seconds=ready - start,
        notes=notes,
    )
    return assemble_axis(prepared.system, prepared.engine, prepared.state, (status, report, loose.text))


def solve_with_hertz(prepared: Prepared) -> Outcome:
    """Solve, and where the assembly asks for Hertz at the actual geometry, update the constants until they settle."""
    outcome = run(prepared)
    system = prepared.system
    if system.assembly.ingredients.hertz != "actual" or outcome.status not in (0, 1):
        return outcome
    for _ in range(12):
        change = 0.0
        for b in system.balls:
            contact = prepared.state.contact[b.balls]
            nominal = b.problem.scene.track.contact_angle
            gamma = np.where(contact[..., 0] > 0.0, contact_angles(contact[..., 1:3]), nominal)
            updated = actual_hertz(b.problem.scene, b.problem.drawn, gamma).C
            change = max(change, float(np.abs(updated / b.problem.C - 1.0).max()))
            b.problem.C[:] = updated
            system.contacts.geometry[b.balls, :, 4] = updated
        again = run(prepared, start=False)
        outcome = again._replace(
            iterations=outcome.iterations + again.iterations, evaluations=outcome.evaluations + again.evaluations
        )
        if change < 1e-13:
            break
    return outcome


def round_off(prepared: Prepared, scale: float) -> float:
    """Relative residual that double precision cannot get below: see `lowfi.statics.static.round_off_bound`."""
    if scale == 0.0:
        return 0.0
    state = prepared.state
    motion = float(np.abs(state.q[:, :3]).max(initial=0.0)) + float(np.abs(prepared.system.contacts.v0).max(initial=0.0))
    stiff = float(state.contact[..., 3].max(initial=0.0)) + float(state.slices[:, 1].max(initial=0.0))
    return 4.0 * float(np.finfo(float).eps) * motion * stiff / scale


# --- preload by a force at mounting


def mount(assembly: Assembly, kernels: ModuleType, member: int) -> tuple[Assembly, tuple[str, ...]]:
    """The assembly with its preloads by force as offsets: those at which each such set carries its force, without loads.

    Newton's method on the axial forces of these sets by their offsets, from forces of both.
    """
    which = [i for i, s in enumerate(assembly.sets) if s.preload > 0.0]
    if not which:
        return assembly, ()
    bare = replace(
        assembly, loads=(), housings=tuple(replace(h, force=(0.0,) * 3, moment=(0.0,) * 3) for h in assembly.housings)
    )
    goal = np.array([assembly.sets[i].preload for i in which])
    closing = np.array([closes(assembly.sets[i]) for i in which])
    depth = np.full(len(which), 2e-6)

    def forces(at: Array) -> Array:
        found = solve_assembly(_shifted(bare, which, closing * at), engine=_engine_name(kernels), member=member)
        return np.array([abs(found.sets[i].force[2]) for i in which])

    value = forces(depth)
    for _ in range(60):
        if float(np.abs(value - goal).max()) <= PRELOAD * float(goal.max()):
            break
        step = 1e-4 * np.maximum(np.abs(depth), 1e-7)
        slope = np.column_stack(
            [(forces(depth + h * e) - value) / h for h, e in zip(step, np.eye(len(which)), strict=True)]
        )
        move = np.linalg.lstsq(slope, goal - value, rcond=1e-12)[0]
        most = 2.0 * np.abs(depth) + 1e-6
        depth = depth + np.clip(move, -most, most)
        value = forces(depth)
    found = ", ".join(f"{assembly.sets[i].name} {1e6 * d:.4g} um" for i, d in zip(which, depth, strict=True))
    note = f"preload by force is set by closing the rows before loading: {found}"
    worst = float(np.abs(value / goal - 1.0).max())
    if worst > 1e-9:
        note += f"; off by {worst:.1e} of it"
    return _shifted(assembly, which, closing * depth), (note,)


def closes(one: RollingSet) -> float:
    """Direction along z in which the outer part of a set moves to close it."""
    return -1.0 if one.thrust == "+z" else 1.0


def _shifted(assembly: Assembly, which: Sequence[int], shift: Array) -> Assembly:
    """The assembly with further offsets [m] of some sets in place of their preloads."""
    sets = list(assembly.sets)
    for i, x in zip(which, shift, strict=True):
        sets[i] = replace(sets[i], offset=sets[i].offset + float(x), preload=0.0)
    return replace(assembly, sets=tuple(sets))


def _engine_name(kernels: ModuleType) -> Engine:
    return "compiled" if jit.is_compiled(kernels.__name__) else "interpreted"
