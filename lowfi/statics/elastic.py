"""Static load distribution with elastic bodies: the refined model, and every step between it and the source's.

The same contact mechanics as `lowfi.statics.static`, but the flanks of screw and nut answer forces by a compliance matrix
with a pluggable origin (`lowfi.compliance.bodies`, or a condensed 3D model read from a file).
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from time import perf_counter
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rollbench.lowfi.compliance.parts import REFINED, Backend, idealised
from rollbench.lowfi.hertz import contact_stiffness
from rollbench.lowfi.statics.elastic_system import Elastic, Rebuild
from rollbench.lowfi.statics.mechanism import Mechanism, free_motions
from rollbench.lowfi.statics.records import Outcome
from rollbench.lowfi.statics.result import StaticResult
from rollbench.lowfi.statics.selection import all_clear, all_sides, choose_sides, describe_left_out
from rollbench.lowfi.statics.settle import NO_LOADS, Contacts, Flanks, least_residual, lost, report_of, settled, verdict
from rollbench.lowfi.statics.shaft import flank_loads, node_forces, node_motions
from rollbench.lowfi.statics.solved import SolvedState
from rollbench.lowfi.statics.static import Engine, Unheld, pick_engine, pin, unheld, with_other_pin
from rollbench.lowfi.statics.summary import ELASTIC_ASSUMPTIONS, assemble_result, failed_result
from rollbench.lowfi.threads import one_thread
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import specimen
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Scene

if TYPE_CHECKING:
    from rollbench.lowfi.compliance.imported import Condensed

#: Formulation of a solution with elastic bodies.
CONDENSED = "convex energy, elastic bodies condensed to the contacts"
#: A flank that was left out counts as touching when it comes this near [m].
MARGIN = 0.2e-6


def iterate(elastic: Elastic, start: bool = True) -> Outcome:
    """Solve from the linear start, or from the present state."""
    bodies, contacts, state, options = elastic.bodies, elastic.contacts, elastic.state, elastic.options
    if start:
        elastic.engine.start_forces(bodies, state, elastic.springs, options)
    outcome: Outcome = elastic.engine.solve_forces(bodies, contacts, state, options, elastic.arms, elastic.history)
    elastic.scale = outcome.scale
    return outcome


def contacts_of(elastic: Elastic) -> tuple[Array, Array, Array]:
    """Centres ``(N, 2)`` [m], contacts ``(N, 4, 5)`` of all flanks, and flank motions ``(N, 4, 2)`` [m] at the state."""
    problem = elastic.problem
    N = elastic.state.inner.shape[0]
    moved = flank_shifts(elastic)
    pair = elastic.pair
    if pair is None:
        return elastic.state.inner[:, :2].copy(), elastic.state.contact.copy(), moved
    a, b = pair
    of_pair = elastic.state.contact[:, 0]
    contact = np.zeros((N, 4, 5))
    contact[:, a] = of_pair
    contact[:, b] = of_pair
    contact[:, b, 1:3] *= -1.0
    p = np.zeros((N, 2))
    shift = moved.copy()
    single = np.zeros((4, 5))
    for i in range(N):  # the centre follows from the motions of both flanks
        elastic.engine.settle_ball(
            p[i],
            shift[i],
            problem.geometry[i],
            problem.closure[i],
            problem.drawn.ball_radius[i],
            problem.drawn.profile,
            elastic.contacts.tiny,
            single,
        )
    return p, contact, moved


def flank_forces(elastic: Elastic) -> Array:
    """Forces ``(N, 4, 2)`` [N] of the balls on all flanks."""
    pair, contact = elastic.pair, elastic.state.contact
    pushes = contact[..., 0, None] * contact[..., 1:3]
    if pair is None:
        return np.asarray(pushes)
    out = np.zeros((contact.shape[0], 4, 2))
    out[:, pair[0]], out[:, pair[1]] = pushes[:, 0], -pushes[:, 0]
    return out


def flank_shifts(elastic: Elastic) -> Array:
    """Motions ``(N, 4, 2)`` [m] of all built flanks at the state."""
    N = elastic.state.inner.shape[0]
    screw, nut, v0, R = elastic.flanks.kept
    forces, out = flank_forces(elastic), np.zeros((N, 4, 2))
    for G, sides in ((screw, (0, 1)), (nut, (2, 3))):
        used = [s for s in sides if elastic.problem.use[s]]
        out[:, used] = (G @ forces[:, used].ravel()).reshape(N, len(used), 2)
    out[:, :2] += v0 + R @ elastic.state.a
    return out


def round_off(elastic: Elastic, scale: float) -> float:
    """Relative residual below which double precision cannot get: see `lowfi.statics.settle.least_residual`."""
    problem = elastic.problem
    stiff = float(contact_stiffness(elastic.state.contact[..., 0], problem.C.min()).max(initial=0.0))
    motion = float(np.abs(flank_shifts(elastic)).max()) + float(np.abs(elastic.flanks.v0).max(initial=0.0))
    return least_residual(motion, stiff, scale, [problem])


def untouched(elastic: Elastic) -> bool:
    """True if no ball comes within MARGIN of an omitted flank, as `lowfi.statics.selection.all_clear` has it.

    A flank that was left out moves with its neighbour on the same ridge, up to their own elastic difference.
    """
    problem = elastic.problem
    p, contact, shift = contacts_of(elastic)
    for s in np.flatnonzero(~problem.use):
        shift[:, s] = shift[:, int(s) ^ 1]
    force = contact[None, ..., 0]
    return bool(all_clear(p[None], shift[None], problem.geometry[None], force, problem.use, MARGIN)[0])


def settle(elastic: Elastic, build: Rebuild | None = None) -> tuple[Elastic, Outcome]:
    """Solve, and follow the contacts (`lowfi.statics.settle.settled`), lever arms on uneven flanks where ``build`` makes
    the problem anew; the problem that was solved, and its outcome."""

    def iterated(start: bool) -> Outcome:
        if elastic.pair is not None:
            elastic.contacts.pair[:, 4] = elastic.problem.C[:, list(elastic.pair)].sum(axis=1)
        return iterate(elastic, start)

    def flanks() -> list[Flanks]:
        centre, contact, shift = contacts_of(elastic)
        return [Flanks(elastic.problem, contact, centre, shift)]

    def rebuild(arms: list[Array]) -> Outcome:
        nonlocal elastic
        old = elastic
        elastic = elastic if build is None else build(arms[0])
        elastic.problem.C[:] = old.problem.C
        for new_state, old_state in zip(elastic.state, old.state, strict=True):
            new_state[:] = old_state
        return iterate(elastic, False)

    def contacts() -> list[Contacts]:
        return [Contacts(elastic.problem, contacts_of(elastic)[1])]

    hertz = elastic.problem.scene.ingredients.hertz
    outcome = settled(iterated, contacts, flanks, None if build is None else rebuild, hertz)
    return elastic, outcome


class Solution(NamedTuple):
    """A scene at the outcome of its solver, with what builds it anew without its pins, its unheld motions, notes on its
    sides, and when it was prepared (`time.perf_counter`)."""

    elastic: Elastic
    outcome: Outcome
    rebuild: Rebuild
    mechanism: Mechanism
    notes: tuple[str, ...]
    prepared_at: float


def solve_sides(rebuild: Rebuild) -> Solution | Unheld:
    """Solve with the sides that ``rebuild`` builds, and again with all four where a ball may touch the others."""
    notes: tuple[str, ...] = ()
    scene = rebuild.scene
    while True:
        problem = rebuild.problem()
        mechanism = free_motions(problem)
        if mechanism.driven:
            return Unheld(problem, mechanism)
        held, elastic = rebuild.pinned(pin(problem, mechanism))
        prepared_at = perf_counter()
        elastic, outcome = settle(elastic, held)
        if np.array_equal(rebuild.use, all_sides(scene)) or (outcome.status == 0 and untouched(elastic)):
            return Solution(elastic, outcome, rebuild, mechanism, notes, prepared_at)
        notes = ("two of the four sides may touch in the solution without them: solved again with all four",)
        rebuild = replace(rebuild, use=all_sides(scene))


@one_thread()
def solve_elastic(
    scene: Scene,
    *,
    backend: Backend = REFINED,
    condensed: Condensed | None = None,
    name: str = "refined",
    engine: Engine = "auto",
    everything: bool = False,
    member: int = 0,
    refine: int = 1,
) -> StaticResult:
    """Contact loads, contact angles and shaft motion of a scene in static equilibrium with elastic bodies.

    backend: what answers the contact forces; condensed: compliance from a 3D model instead; name: of the model, for the
    record; engine, everything, member, refine: as for `lowfi.statics.static.solve_static`. Raises ValueError for bodies
    that the dimensions make impossible; a scene without equilibrium is named in ``status``.
    """
    start = perf_counter()
    layout = ball_layout(scene)
    drawn = specimen(scene, layout, member)
    kernels = pick_engine(engine, layout.z.size, drawn.profile.shape[1] > 0)
    every = everything or drawn.profile.shape[1] > 0
    use = all_sides(scene) if every else choose_sides(scene, drawn)
    solved = solve_sides(Rebuild(scene, drawn, layout, use, None, backend, condensed, kernels, everything, refine))
    if isinstance(solved, Unheld):
        return failed_result(solved.problem, name, solved.status, perf_counter() - start)
    elastic, outcome, mechanism, rebuild = solved.elastic, solved.outcome, solved.mechanism, solved.rebuild
    problem = elastic.problem
    bound = round_off(elastic, outcome.scale)
    status = verdict(outcome, bound, partial(unheld, problem))
    if outcome.status in NO_LOADS:
        return failed_result(problem, name, status, perf_counter() - start)
    system = CONDENSED, elastic.state.phi.size + elastic.state.a.size, problem.nodes.size - 1
    report = report_of(outcome, kernels, (start, solved.prepared_at), system, bound, solved.notes)
    left = (*describe_left_out(problem, mechanism, everything=everything), *_cut(elastic))
    source = idealised(backend, scene) if condensed is None else (condensed.describe(),)
    assumed = (*ELASTIC_ASSUMPTIONS, *source, *elastic.assumed)
    result = assemble_result(solved_state(elastic), name, status, report, left, assumed)

    def otherwise() -> Array | None:
        _, other = rebuild.pinned(pin(rebuild.problem(), mechanism, True))
        other, found = settle(other)
        return None if lost(found) else contacts_of(other)[1][..., 0]

    return with_other_pin(result, mechanism, otherwise)


def _cut(elastic: Elastic) -> tuple[str, ...]:
    """What was done to keep the compliance positive."""
    clipped = elastic.flanks.clipped
    if clipped <= 1e-6:
        return ()
    return (f"negative compliance of the bodies, up to {100 * clipped:.2g} % of a contact's: cut away",)


def solved_state(elastic: Elastic) -> SolvedState:
    """The state with the motions of the nodes and the reactions, which the condensed system does not hold itself."""
    problem = elastic.problem
    used = [s for s in range(2) if problem.use[s]]
    pushes = flank_forces(elastic)[:, used].transpose(1, 0, 2).reshape(-1, 2)
    by_flanks = flank_loads(problem, pushes, used)
    if elastic.flanks.squeeze is not None:
        by_flanks += elastic.flanks.squeeze.node_loads(pushes.ravel())
    motion = node_motions(elastic.shaft, by_flanks, elastic.state.a)
    centre, contact, shifts = contacts_of(elastic)
    nodal = np.zeros((problem.nodes.size, 6))
    if problem.basis is None:
        nodal = node_forces(elastic.shaft, by_flanks) - problem.load - by_flanks.reshape(-1, 6)
    if elastic.flanks.squeeze is not None:
        motion = elastic.flanks.squeeze.with_inside(motion, pushes, problem.fixed)
    held = np.where(problem.fixed, nodal, 0.0)
    scale = max(elastic.scale, float(np.abs(held[:, :3]).max(initial=0.0)))
    return SolvedState(problem, motion, centre, contact[..., 0], contact[..., 1:3], held, shifts, scale)
