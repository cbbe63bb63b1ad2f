"""Equilibrium of several rolling sets on one shaft with elastic bodies: the refined model."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from time import perf_counter

import numpy as np

from rollbench.lowfi.compliance.parts import REFINED, Backend
from rollbench.lowfi.statics.axis.elastic import ElasticAxis, ready, section_of
from rollbench.lowfi.statics.axis.loose import loose_motions, pinned
from rollbench.lowfi.statics.axis.mount import mount
from rollbench.lowfi.statics.axis.proof import unheld
from rollbench.lowfi.statics.axis.solve import engine_for, far_off, solve_assembly
from rollbench.lowfi.statics.axis.stiffness import asked_row, inverse, rigid_rows
from rollbench.lowfi.statics.axis.summary import Ending, assemble_axis, failed_axis
from rollbench.lowfi.statics.axis.system import BallSet, build, set_contacts, set_flanks, with_arms
from rollbench.lowfi.statics.elastic import CONDENSED
from rollbench.lowfi.statics.records import AxisState, Outcome
from rollbench.lowfi.statics.result import AxisResult, Status
from rollbench.lowfi.statics.settle import NO_LOADS, Contacts, Flanks, least_residual, report_of, settled, verdict
from rollbench.lowfi.statics.shaft import flank_loads, node_forces, node_motions
from rollbench.lowfi.statics.static import Engine
from rollbench.lowfi.statics.summary import ELASTIC_ASSUMPTIONS
from rollbench.lowfi.threads import one_thread
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, RollerRow

#: Statements that hold for every run of the refined model on several sets.
ASSUMPTIONS = (
    "the shaft is a Timoshenko beam between its sets; beyond the beam the screw, nut and balls of a set are elastic for "
    "that set's own contacts, and feel those of another set by the section forces of the shaft",
    "housings are rigid; nuts and outer rings are held in them as a scene of one set holds them",
    *ELASTIC_ASSUMPTIONS,
)
#: What a row of rollers leaves out.
RIGID_RINGS = "elastic rings: cone and cup are rigid beyond the line contacts, whose law holds both to their depth"

#: What an inner ring on a housing leaves out.
RIGID_INNER = "elastic inner ring: as the housing that it sits on, it is rigid beyond its contacts"


@one_thread()
def solve_refined(
    assembly: Assembly, *, engine: Engine = "auto", member: int = 0, backend: Backend = REFINED, name: str = "refined"
) -> AxisResult:
    """Loads, stiffness and motions of an assembly with elastic bodies; arguments as for `solve_assembly`.

    Rollers alone leave nothing but the beam and their line contacts to be elastic: the model lin. Raises ValueError
    for inner rings on housings that stand on springs, more than `LARGEST` balls and rollers, or bodies that cannot be.
    """
    if not assembly.ball_count:
        result = solve_assembly(assembly, engine=engine, member=member)
        return replace(result, model=name, left_out=(*result.left_out, *rigid_rings(assembly)))
    start = perf_counter()
    again = partial(solve_refined, engine=engine, member=member, backend=backend, name=name)
    mounted, notes, unmet = mount(assembly, again)
    if unmet:
        return failed_axis(assembly, name, unmet, perf_counter() - start, ASSUMPTIONS)
    kernels = engine_for(assembly, engine)
    system = build(mounted, member, section=section_of(mounted, backend))
    loose = loose_motions(system)
    if loose.driven:
        return failed_axis(assembly, name, Status("not held", loose.text), perf_counter() - start, ASSUMPTIONS)
    elastic = ready(pinned(system, loose), backend, kernels)
    prepared_at = perf_counter()
    elastic, outcome = settle(elastic, backend)
    system = elastic.system
    bound = round_off(elastic, outcome.scale)
    state, held = state_of(elastic)
    status = verdict(outcome, bound, partial(unheld, system), far_off(state.q, system))
    if outcome.status in NO_LOADS:
        return failed_axis(assembly, name, status, perf_counter() - start, ASSUMPTIONS)
    size = CONDENSED, elastic.state.phi.size + elastic.state.a.size, system.structure.nodes.size - 1
    report = report_of(outcome, kernels, (start, prepared_at), size, bound, notes)
    S = ball_roots(elastic)
    sets = [own_stiffness(elastic, i, b, S) for i, b in enumerate(system.balls)]
    total = elastic_stiffness(elastic, S)
    rigid = rigid_rings(assembly)
    words = *ASSUMPTIONS, *elastic.assumed
    ending = Ending(status, report, loose.text, held, sets, total, name, words, rigid, flank_shifts(elastic), outcome.scale)
    return assemble_axis(elastic.system, state, ending)


def settle(elastic: ElasticAxis, backend: Backend) -> tuple[ElasticAxis, Outcome]:
    """Solve, and follow the contacts (`lowfi.statics.settle.settled`)."""

    def iterated(start: bool) -> Outcome:
        arrays = elastic.bodies, elastic.contacts, elastic.state
        if start:
            elastic.engine.start_forces(elastic.bodies, elastic.state, elastic.springs, elastic.options)
        history = np.zeros(elastic.options.most + 1)
        outcome: Outcome = elastic.engine.solve_forces(*arrays, elastic.options, elastic.arms, history)
        return outcome

    def contacts() -> list[Contacts]:
        return set_contacts(elastic.system, elastic.state.contact)

    def flanks() -> list[Flanks]:
        return set_flanks(elastic.system, state_of(elastic)[0], flank_shifts(elastic))

    def rebuild(arms: list[Array]) -> Outcome:
        nonlocal elastic
        old, elastic = elastic, ready(with_arms(elastic.system, arms), backend, elastic.engine)
        for new, known in zip(elastic.state, old.state, strict=True):
            new[:] = known
        return iterated(False)

    outcome = settled(iterated, contacts, flanks, rebuild, elastic.system.assembly.ingredients.hertz)
    return elastic, outcome


def rigid_rings(assembly: Assembly) -> tuple[str, ...]:
    """A sentence each on what rows of rollers and inner rings on housings leave out."""
    rollers = tuple(f"{s.name}: {RIGID_RINGS}" for s in assembly.sets if isinstance(s.parts, RollerRow))
    return rollers + tuple(f"{s.name}: {RIGID_INNER}" for s in assembly.sets if s.carrier is not None)


def round_off(elastic: ElasticAxis, scale: float) -> float:
    """Relative residual below which double precision cannot get: see `lowfi.statics.settle.least_residual`."""
    contact = elastic.state.contact
    stiff = float(contact[..., 3].max(initial=0.0))
    moved = float(np.abs(elastic.state.inner[:, :2]).max(initial=0.0))
    motion = 2.0 * float(np.abs(elastic.bodies.v0).max(initial=0.0)) + moved
    return least_residual(motion, stiff, scale, [b.problem for b in elastic.system.balls])


def flank_forces(elastic: ElasticAxis) -> Array:
    """Forces (N, 4, 2) [N] of the balls on their flanks."""
    contact = elastic.state.contact
    return np.asarray(contact[..., 0, None] * contact[..., 1:3])


def flank_shifts(elastic: ElasticAxis) -> Array:
    """Motions (N, 4, 2) [m] of all flanks."""
    bodies, forces = elastic.bodies, flank_forces(elastic)
    N = len(forces)
    out = (bodies.v0 + bodies.R @ elastic.state.a).reshape(N, 4, 2)
    for G, half in ((bodies.first, slice(2)), (bodies.second, slice(2, 4))):
        out[:, half] += (G @ forces[:, half].ravel()).reshape(N, 2, 2)
    return np.asarray(out)


def state_of(elastic: ElasticAxis) -> tuple[AxisState, Array]:
    """Motions of all rows with the contacts there, and the forces (r, 6) of what holds them."""
    system, shaft = elastic.system, elastic.shaft
    structure, forces = system.structure, flank_forces(elastic)
    n, k = structure.nodes.size, shaft.work.size
    pushes = forces[:, :2].transpose(1, 0, 2).reshape(-1, 2)
    q = np.zeros((structure.stations.size, 6))
    by_flanks = flank_loads(elastic.whole, pushes, [0, 1])
    if elastic.squeeze is not None:
        by_flanks += elastic.squeeze.node_loads(pushes.ravel())
    q[:n] = node_motions(shaft, by_flanks, elastic.state.a[:k])
    on_outer = elastic.rows.T @ forces[:, 2:].ravel() + elastic.carried.T @ forces[:, :2].ravel()
    h = elastic.housings
    outer = h.given + h.solve(on_outer[:, None])[:, 0] + h.motions @ elastic.state.a[k:]
    q[n:] = outer.reshape(-1, 6)
    loads = structure.load.copy()
    loads[:n] += by_flanks.reshape(-1, 6)
    loads[n:] += on_outer.reshape(-1, 6)
    taken = np.concatenate([node_forces(shaft, by_flanks), (h.stiffness @ outer).reshape(-1, 6)])
    held = np.where(structure.fixed, taken - loads, 0.0)
    slices = np.zeros((system.slices.drop.size, 2))
    elastic.engine.roller_forces(system.slices, q, slices, np.zeros_like(q))
    if elastic.squeeze is not None:
        q[:n] = elastic.squeeze.with_inside(q[:n], pushes, structure.fixed[:n])
    state = AxisState(q, np.zeros((n - 1, 6)), elastic.state.inner[:, :2], elastic.state.contact, slices)
    return state, held


def ball_roots(elastic: ElasticAxis) -> list[Array]:
    """Square roots S_i (rows, 8) of the balls' stiffness by the motion of their flanks."""
    N = elastic.state.contact.shape[0]
    S, counts = np.zeros((N, 6, 8)), np.zeros(N, dtype=np.int64)
    elastic.engine.ball_rows(elastic.contacts, elastic.state.contact, S, counts)
    return [S[i, : counts[i]] for i in range(N)]


def spread(S: list[Array]) -> Array:
    """Square roots of all balls (rows, 8 N)."""
    out = np.zeros((sum(len(s) for s in S), 8 * len(S)))
    row = 0
    for i, s in enumerate(S):
        out[row : row + len(s), 8 * i : 8 * i + 8] = s
        row += len(s)
    return out


def both(first: Array, second: Array) -> Array:
    """Compliance (8 N, 8 N) of all flanks, ball by ball, from that of the screw's and of the nut's (4 N, 4 N)."""
    N = len(first) // 4
    out = np.zeros((N, 2, 4, N, 2, 4))
    out[:, 0, :, :, 0] = first.reshape(N, 4, N, 4)
    out[:, 1, :, :, 1] = second.reshape(N, 4, N, 4)
    return out.reshape(8 * N, 8 * N)


def own_stiffness(elastic: ElasticAxis, i: int, b: BallSet, S: list[Array]) -> Array:
    """Stiffness (6, 6) of a set alone with its own elastic bodies: its inner part moved rigidly, its outer one held."""
    root = spread(S[b.balls])
    rows = np.zeros((b.problem.layout.z.size, 8, 6))
    rows[:, :4] = rigid_rows(b, elastic.system.structure.stations)
    moved = root @ rows.reshape(-1, 6)
    return np.asarray(moved.T @ np.linalg.solve(np.eye(len(root)) + root @ both(*elastic.local[i]) @ root.T, moved))


def elastic_stiffness(elastic: ElasticAxis, S: list[Array]) -> Array | None:
    """Tangent stiffness (6, 6) of the whole at the row that is asked about, as `whole_stiffness` of the model lin."""
    system, structure = elastic.system, elastic.system.structure
    row = asked_row(system)
    if row < 0:
        return None
    n, k, N = structure.nodes.size, elastic.shaft.work.size, len(S)
    v, work = np.zeros((N, 4, 2, 6)), np.zeros((elastic.state.a.size, 6))
    unit = np.zeros((6 * (n if row < n else structure.at.size), 6))
    at = 6 * (row if row < n else row - n)
    unit[at : at + 6] = np.diag((~structure.fixed[row]).astype(float))
    if row < n:
        answer = elastic.shaft.solve(unit)
        B = elastic.whole.B
        v[:, :2] = np.einsum("nsak,nskj->nsaj", B, answer[6 * elastic.whole.node[..., None] + np.arange(B.shape[3])])
        if elastic.squeeze is not None:
            added, besides = elastic.squeeze.by_loads(unit, answer)
            v[:, :2] += added.reshape(2, N, 2, 6).transpose(1, 0, 2, 3)
            answer = answer + besides
        rigid = np.eye(6)
        z = float(structure.nodes[row] - structure.nodes[elastic.shaft.pin])
        rigid[0, 4], rigid[1, 3] = z, -z
        work[:k] = (rigid @ elastic.shaft.motions).T @ unit[at : at + 6]
    else:
        answer = elastic.housings.solve(unit)
        v[:, 2:] = (elastic.rows @ answer).reshape(N, 2, 2, 6)
        work[k:] = elastic.housings.motions.T @ unit
    root, load = spread(S), v.reshape(8 * N, 6)
    SR = root @ elastic.bodies.R.reshape(8 * N, -1)
    matrix = np.block(
        [
            [np.eye(len(root)) + root @ both(elastic.bodies.first, elastic.bodies.second) @ root.T, -SR],
            [SR.T, np.zeros((SR.shape[1],) * 2)],
        ]
    )
    try:
        x = np.linalg.solve(matrix, np.concatenate([root @ load, work]))
    except np.linalg.LinAlgError:
        return None
    compliance = answer[at : at + 6] - load.T @ (root.T @ x[: len(root)]) + work.T @ x[len(root) :]
    return inverse(0.5 * (compliance + compliance.T), ~structure.fixed[row], system.arm)
