"""Static load distribution with elastic bodies: the refined model, and every step between it and the source's.

The same contact mechanics as `lowfi.static`, but the flanks of screw and nut answer forces by a compliance matrix with a
pluggable origin (`lowfi.compliance.bodies`, or a condensed 3D model read from a file).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from lowfi import jit
from lowfi.compliance.bodies import (
    REFINED,
    Backend,
    ball_compliance,
    body_compliance,
    geometry_only,
    grooved_section,
    idealised,
)
from lowfi.compliance.imported import Condensed
from lowfi.compliance.modes import soft_modes
from lowfi.compliance.shaft import Shaft, flank_loads, flank_response, node_motions, shaft_of
from lowfi.mechanism import free_motions
from lowfi.problem import Problem, actual_hertz, build, nominal_hertz
from lowfi.result import SolverReport, StaticResult
from lowfi.selection import choose_sides, describe_left_out
from lowfi.static import (
    ACCEPTED,
    MAX_ITERATIONS,
    TOLERANCE,
    Engine,
    Outcome,
    Prepared,
    contact_angles,
    force_floor,
    pick_engine,
    pin,
    prepare,
    reference_scale,
    verdict,
)
from lowfi.summary import Support, assemble_result, failed_result
from meshes.errors import Specimen, specimen
from meshes.helix import BallLayout, ball_layout
from meshes.parts import Scene

Array = NDArray[np.float64]

#: Largest number of balls: compliance between all contacts is formed whole, so memory and set-up grow as its square.
LARGEST = 250
#: Number of balls from which on the bodies' soft modes serve the solution, instead of a dense factor.
MODES_FROM = 24
#: A flank that was left out counts as touching when it comes this near [m].
MARGIN = 0.2e-6


@dataclass(frozen=True)
class Flanks:
    """How the flanks of all balls move, ball by ball: four flanks each (d = 8 motions), or one pair's relative motion (2).

    first, second: compliance [m/N] of screw and nut ``(4 N, 4 N)``, or of both together ``(2 N, 2 N)`` and nothing;
    R ``(N, d, k)`` by the free motions, v0 ``(N, d)`` [m] by loads and prescribed displacements, work ``(k,)`` of the
    loads; e ``(N, 4)`` [m/N] beside Hertz; clipped: largest negative compliance cut away over a contact's own. own: what
    the flanks' motions are found from again: compliance of screw and of nut on the built sides, v0 ``(N, 2, 2)`` and R
    ``(N, 2, 2, k)`` of the screw's flanks.
    """

    first: Array
    second: Array
    R: Array
    v0: Array
    work: Array
    e: Array
    clipped: float
    own: tuple[Array, Array, Array, Array]


@dataclass
class Elastic:
    """A problem ready for the kernels, in the order of `lowfi.kernel.elastic.solve_forces`.

    bodies, contacts, state, options, arms, history: its arguments; springs: those of `start_forces`; assumed: statements
    about the bodies; scale: largest force of the last run [N].
    """

    problem: Problem
    shaft: Shaft
    flanks: Flanks
    engine: ModuleType
    bodies: tuple[Array, ...]
    contacts: tuple[Array, ...]
    state: tuple[Array, ...]
    springs: Array
    options: Array
    arms: Array
    history: Array
    assumed: tuple[str, ...]
    scale: float = 0.0

    @property
    def pair(self) -> tuple[int, int] | None:
        """Sides of the one diagonal that the closed form serves, screw's first; None where all four flanks take part."""
        if self.bodies[1].size:
            return None
        a = 0 if self.problem.use[0] else 1
        return a, 3 - a


def typical_force(problem: Problem) -> float:
    """Force [N] at which small terms that depend on the contacts' size are taken: the mean share of load or squeeze."""
    return max(reference_scale(problem)[0], 1e-6)


def contact_compliance(problem: Problem) -> float:
    """Tangent compliance [m/N] of a typical contact."""
    return float(2.0 / 3.0 * np.mean(problem.C) / np.cbrt(typical_force(problem)))


def by_ball(N: int, sides: Sequence[int]) -> NDArray[np.int64]:
    """Places of (ball, side, axis) in arrays that go side after side, ``(N * sides * 2,)``."""
    i, s, a = np.meshgrid(np.arange(N), np.asarray(sides), np.arange(2), indexing="ij")
    return np.asarray(((s % 2) * N + i) * 2 + a, dtype=np.int64).ravel()


def positive(G: Array) -> tuple[Array, float]:
    """G without its negative eigenvalues, which would make the energy concave, and the largest one cut away [m/N]."""
    if G.size == 0:
        return G, 0.0
    bump = 1e-10 * float(np.trace(G)) / len(G)
    try:
        np.linalg.cholesky(G + max(bump, 1e-300) * np.eye(len(G)))
    except np.linalg.LinAlgError:
        lam, V = np.linalg.eigh(G)
        return (V * np.maximum(lam, 0.0)) @ V.T, float(-lam.min())
    return G, 0.0


def flanks_of(
    problem: Problem, shaft: Shaft, backend: Backend, condensed: Condensed | None, layout: BallLayout
) -> tuple[Flanks, tuple[str, ...]]:
    """Motions of all flanks of a problem for a backend, and what is assumed for the bodies."""
    scene, N = problem.scene, layout.z.size
    constants = nominal_hertz(scene)
    mean_axis = float(0.5 * np.mean(constants.C_a + constants.C_b)) * float(np.cbrt(typical_force(problem)))
    pair = one_pair(problem)
    e, assumed, G = np.zeros((N, 4)), [], []
    v0, R = np.zeros((N, 2, 2)), np.zeros((N, 2, 2, shaft.work.size))
    for screw in (True, False):
        sides = [s for s in ((0, 1) if screw else (2, 3)) if problem.use[s]]
        body = body_compliance(scene, layout, screw, backend, mean_axis)
        assumed += [x for x in body.assumed if x not in assumed]
        order = by_ball(N, sides)
        e[:, sides] = body.e if condensed is None else condensed.own(sides, typical_force(problem), body.e)
        own = body.G[np.ix_(order, order)]
        if screw:
            beam, moved, rigid = flank_response(shaft, sides)
            order = by_ball(N, range(len(sides)))
            own = own + beam[np.ix_(order, order)]
            v0[:, [s % 2 for s in sides]] = moved[order].reshape(N, len(sides), 2)
            R[:, [s % 2 for s in sides]] = rigid[order].reshape(N, len(sides), 2, -1)
        if condensed is not None:
            own = condensed.correct(scene, layout, sides, own, backend)
        G.append(own)
    if pair is not None:
        first, clipped = positive(G[0] + G[1])
        second, d = np.zeros((0, 0)), 2
        s = pair[0] % 2
        start, free = v0[:, s], R[:, s]
    else:
        (first, low), (second, high) = positive(G[0]), positive(G[1])
        clipped, d = max(low, high), 8
        start, free = np.zeros((N, 4, 2)), np.zeros((N, 4, 2, R.shape[3]))
        start[:, :2], free[:, :2] = v0, R
    flanks = Flanks(
        np.ascontiguousarray(first), np.ascontiguousarray(second), np.ascontiguousarray(free.reshape(N, d, -1)),
        np.ascontiguousarray(start.reshape(N, d)), shaft.work, e, clipped / contact_compliance(problem),
        (G[0], G[1], v0, R),
    )  # fmt: skip
    return flanks, tuple(assumed)


def one_pair(problem: Problem) -> tuple[int, int] | None:
    """The diagonal pair in use, screw's side first, where it is the only one and the flanks are arcs."""
    if problem.drawn.profile.shape[1] or np.all(problem.use):
        return None
    a = 0 if problem.use[0] else 1
    return a, 3 - a


def pair_data(problem: Problem, pair: tuple[int, int], e: Array) -> Array:
    """Rows of `lowfi.kernel.elastic_balls.pair_balls`, ``(N, 6)``."""
    a, b = pair
    geometry = problem.geometry
    D = geometry[:, b, :2] - geometry[:, a, :2]
    size = np.hypot(D[:, 0], D[:, 1])
    both = geometry[:, a, 4] + geometry[:, b, 4]
    return np.column_stack([D, size, problem.closure[:, a], both, e[:, a] + e[:, b]])


def ready(
    problem: Problem, backend: Backend, kernels: ModuleType, layout: BallLayout, condensed: Condensed | None = None,
    *, tolerance: float = TOLERANCE,
) -> Elastic:  # fmt: skip
    """Arrays for the kernels. Raises ValueError for more than ``LARGEST`` balls or impossible dimensions of the bodies."""
    N = layout.z.size
    if N > LARGEST:
        raise ValueError(f"{N} balls: elastic bodies are limited to {LARGEST}; use the model lin")
    if problem.drawn.profile.shape[1] and not np.all(problem.use):
        raise AssertionError("uneven flanks are solved with all four sides")
    shaft = shaft_of(problem)
    flanks, assumed = flanks_of(problem, shaft, backend, condensed, layout)
    constants = nominal_hertz(problem.scene)
    grow = float(np.cbrt(typical_force(problem)))
    axes = (float(constants.C_a[0]) * grow, float(constants.C_b[0]) * grow)
    ball = ball_compliance(problem.scene, axes, backend) if condensed is None else condensed.ball(problem.scene, axes)
    pair = one_pair(problem)
    local = np.zeros((N, 4, 2))
    local[..., 0] = flanks.e + ball.e
    local[..., 1] = ball.g * np.array([1.0, ball.sign, ball.sign, 1.0])
    rows = np.zeros((N, 6))
    if pair is not None:  # one diagonal alone: nothing to couple with
        local[..., 0] += 2.0 * ball.g**2
        rows = pair_data(problem, pair, local[..., 0])
    force, stiffness = reference_scale(problem)
    modes = [np.zeros((0, 0))] * 2
    if N >= MODES_FROM:
        modes = [soft_modes(G, contact_compliance(problem)) for G in (flanks.first, flanks.second)]
    bodies = (flanks.first, flanks.second, flanks.R, flanks.v0, flanks.work, *modes)
    contacts = (problem.geometry, problem.closure, local, problem.drawn.ball_radius, problem.drawn.profile, rows)
    state = (np.zeros(flanks.v0.shape), np.zeros(flanks.work.size), np.zeros((N, 3)), np.zeros((N, 1 if pair else 4, 5)))
    options = np.array([tolerance, MAX_ITERATIONS, stiffness, 1e-14 * force, 1e3, force_floor(problem)])
    return Elastic(
        problem, shaft, flanks, kernels, bodies, contacts, state, spring_rows(problem, pair, stiffness), options,
        shaft.arms, np.zeros(MAX_ITERATIONS + 1), assumed,
    )  # fmt: skip


def spring_rows(problem: Problem, pair: tuple[int, int] | None, stiffness: float) -> Array:
    """Linear springs between opposite flanks, ``(N, 1, 2)`` for one pair or ``(N, 2, 8)``."""
    w = problem.geometry[..., :2] / np.maximum(problem.geometry[..., 2:3], 1e-30)
    root = np.sqrt(stiffness)
    if pair is not None:
        return np.ascontiguousarray(root * w[:, pair[0], None, :])
    rows = np.zeros((w.shape[0], 2, 4, 2))
    for s in range(2):
        if problem.use[s] and problem.use[3 - s]:
            rows[:, s, s], rows[:, s, 3 - s] = root * w[:, s], -root * w[:, s]
    return rows.reshape(-1, 2, 8)


def run(elastic: Elastic, *, start: bool = True) -> Outcome:
    """Solve from the linear start, or from the state as it is: status, iterations, evaluations, residual, scale."""
    bodies, contacts, state, options = elastic.bodies, elastic.contacts, elastic.state, elastic.options
    if start:
        elastic.engine.start_forces(bodies, state, elastic.springs, options)
    status, it, evaluations, residual, _, scale = elastic.engine.solve_forces(
        bodies, contacts, state, options, elastic.arms, elastic.history
    )
    elastic.scale = scale
    return status, it, evaluations, residual, scale


def contacts_of(elastic: Elastic) -> tuple[Array, Array, Array]:
    """Centres ``(N, 2)`` [m], contacts ``(N, 4, 5)`` of all flanks, and flank motions ``(N, 4, 2)`` [m] at the state."""
    problem = elastic.problem
    N = elastic.state[2].shape[0]
    moved = flank_shifts(elastic)
    pair = elastic.pair
    if pair is None:
        return elastic.state[2][:, :2].copy(), elastic.state[3].copy(), moved
    a, b = pair
    own = elastic.state[3][:, 0]
    contact = np.zeros((N, 4, 5))
    contact[:, a] = own
    contact[:, b] = own
    contact[:, b, 1:3] *= -1.0
    p = np.zeros((N, 2))
    shift = moved.copy()
    single = np.zeros((4, 5))
    for i in range(N):  # the centre follows from the motions of both flanks
        elastic.engine.settle(
            p[i], shift[i], problem.geometry[i], problem.closure[i], problem.drawn.ball_radius[i],
            problem.drawn.profile, elastic.options[3], single,
        )  # fmt: skip
    return p, contact, moved


def flank_forces(elastic: Elastic) -> Array:
    """Forces ``(N, 4, 2)`` [N] of the balls on all flanks."""
    pair, contact = elastic.pair, elastic.state[3]
    pushes = contact[..., 0, None] * contact[..., 1:3]
    if pair is None:
        return np.asarray(pushes)
    out = np.zeros((contact.shape[0], 4, 2))
    out[:, pair[0]], out[:, pair[1]] = pushes[:, 0], -pushes[:, 0]
    return out


def flank_shifts(elastic: Elastic) -> Array:
    """Motions ``(N, 4, 2)`` [m] of all built flanks at the state."""
    N = elastic.state[2].shape[0]
    screw, nut, v0, R = elastic.flanks.own
    forces, out = flank_forces(elastic), np.zeros((N, 4, 2))
    for G, sides in ((screw, (0, 1)), (nut, (2, 3))):
        used = [s for s in sides if elastic.problem.use[s]]
        out[:, used] = (G @ forces[:, used].ravel()).reshape(N, len(used), 2)
    out[:, :2] += v0 + R @ elastic.state[1]
    return out


def round_off(elastic: Elastic, scale: float) -> float:
    """Relative residual below which double precision cannot get: see `lowfi.static.round_off_bound`."""
    if scale == 0.0:
        return 0.0
    problem = elastic.problem
    stiff = float((1.5 * np.cbrt(elastic.state[3][..., 0]) / problem.C.min()).max(initial=0.0))
    lengths = float(np.abs(flank_shifts(elastic)).max()) + float(np.abs(elastic.flanks.v0).max(initial=0.0))
    lengths += problem.scene.balls.radius if problem.drawn.profile.shape[1] else 0.0
    return float(8.0 * np.finfo(float).eps * lengths * stiff / scale)


def untouched(elastic: Elastic) -> bool:
    """Whether no flank that was left out comes near its ball, which every ball must show by carrying load.

    A flank that was left out moves with its neighbour on the same ridge, up to their own elastic difference.
    """
    problem = elastic.problem
    pair = elastic.pair
    if pair is None:
        return True
    p, contact, shift = contacts_of(elastic)
    if bool((contact[:, pair[0], 0] == 0.0).any()):
        return False
    for s in np.flatnonzero(~problem.use):
        twin = int(s) ^ 1
        w = problem.geometry[:, s, :2] + p - shift[:, twin]
        gap = problem.geometry[:, s, 2] - problem.geometry[:, s, 3] - np.hypot(w[:, 0], w[:, 1])
        if bool((gap < MARGIN).any()):
            return False
    return True


def solve_with_hertz(elastic: Elastic) -> Outcome:
    """Solve, and where the scene asks for Hertz at the actual geometry, update the constants until they settle."""
    outcome = run(elastic)
    problem = elastic.problem
    if problem.scene.ingredients.hertz != "actual" or outcome[0] not in (0, 1):
        return outcome
    iterations, evaluations = outcome[1], outcome[2]
    for _ in range(12):
        _, contact, _ = contacts_of(elastic)
        gamma = np.where(contact[..., 0] > 0.0, contact_angles(contact[..., 1:3]), problem.scene.track.contact_angle)
        updated = actual_hertz(problem.scene, problem.drawn, gamma).C
        change = float(np.abs(updated / problem.C - 1.0).max())
        problem.C[:] = updated
        if elastic.pair is not None:
            elastic.contacts[5][:, 4] = updated[:, list(elastic.pair)].sum(axis=1)
        outcome = run(elastic, start=False)
        iterations, evaluations = iterations + outcome[1], evaluations + outcome[2]
        if change < 1e-13:
            break
    return outcome[0], iterations, evaluations, outcome[3], outcome[4]


def follow_profile(elastic: Elastic, outcome: Outcome, rebuild: Rebuild) -> tuple[Elastic, Outcome]:
    """Let the flanks turn about their centre of curvature at the current contact: `lowfi.static.follow_profile`."""
    more = np.zeros((elastic.state[2].shape[0], 4, 2))
    iterations, evaluations = outcome[1], outcome[2]
    for _ in range(6):
        if outcome[0] not in (0, 1):
            break
        p, contact, shift = contacts_of(elastic)
        force, problem = contact[..., 0], elastic.problem
        w = -problem.drawn.centre + p[:, None, :] - shift
        with np.errstate(divide="ignore", invalid="ignore"):
            radius = np.where(force > 0.0, force / contact[..., 4], 0.0)
        new = np.where(force[..., None] > 0.0, w - contact[..., 1:3] * radius[..., None], 0.0)
        change = float(np.abs(new - more).max())
        more = new
        old = elastic
        elastic = rebuild(more)
        elastic.problem.C[:] = old.problem.C
        for new_state, old_state in zip(elastic.state, old.state, strict=True):
            new_state[:] = old_state
        outcome = run(elastic, start=False)
        iterations, evaluations = iterations + outcome[1], evaluations + outcome[2]
        if change < 1e-13:
            break
    return elastic, (outcome[0], iterations, evaluations, outcome[3], outcome[4])


@dataclass(frozen=True)
class Rebuild:
    """Builds a scene's problem anew with other lever arms."""

    scene: Scene
    drawn: Specimen
    layout: BallLayout
    use: NDArray[np.bool_]
    held: NDArray[np.bool_] | None
    backend: Backend
    condensed: Condensed | None
    engine: ModuleType
    everything: bool
    refine: int

    def __call__(self, more: Array | None = None) -> Elastic:
        """The problem, ready; ``more``: see `lowfi.problem.build`."""
        problem = self.problem(more)
        return ready(problem, self.backend, self.engine, self.layout, self.condensed)

    def problem(self, more: Array | None = None) -> Problem:
        """The problem with the backend's section."""
        found = build(
            self.scene, self.drawn, self.layout, self.use, everything=self.everything, refine=self.refine, more=more,
            section=grooved_section(geometry_only(self.scene), True) if self.backend.section == "cell" else None,
        )  # fmt: skip
        return found if self.held is None else replace(found, fixed=self.held)


def solve_elastic(
    scene: Scene, *, backend: Backend = REFINED, condensed: Condensed | None = None, name: str = "refined",
    engine: Engine = "auto", everything: bool = False, member: int = 0, refine: int = 1, drawn: Specimen | None = None,
) -> StaticResult:  # fmt: skip
    """Contact loads, contact angles and shaft motion of a scene in static equilibrium with elastic bodies.

    backend: what answers the contact forces; condensed: compliance from a 3D model instead; name: of the model, for the
    record; engine, everything, member, refine, drawn: as for `lowfi.static.solve_static`. Raises ValueError for bodies
    that the dimensions make impossible; a scene without equilibrium is named in ``status``.
    """
    with threadpool_limits(1, "blas"):  # small matrices: more threads only wait for one another
        return _solve(scene, backend, condensed, name, engine, everything, member, refine, drawn)


def _solve(
    scene: Scene, backend: Backend, condensed: Condensed | None, name: str, engine: Engine, everything: bool, member: int,
    refine: int, drawn: Specimen | None,
) -> StaticResult:  # fmt: skip
    start = perf_counter()
    layout = ball_layout(scene)
    drawn = drawn if drawn is not None else specimen(scene, layout, member)
    kernels = pick_engine(engine, scene.ball_count)
    every = everything or drawn.profile.shape[1] > 0
    use = np.ones(4, dtype=bool) if every else choose_sides(scene, drawn)
    notes: list[str] = []
    while True:
        rebuild = Rebuild(scene, drawn, layout, use, None, backend, condensed, kernels, everything, refine)
        problem = rebuild.problem()
        mechanism = free_motions(problem)
        if mechanism.driven:
            return failed_result(problem, name, f"not held: {mechanism.text}", perf_counter() - start)
        rebuild = replace(rebuild, held=pin(problem, mechanism).fixed)
        elastic = rebuild()
        prepared_at = perf_counter()
        outcome = solve_with_hertz(elastic)
        if drawn.profile.shape[1] and scene.ingredients.arm != "nominal":
            elastic, outcome = follow_profile(elastic, outcome, rebuild)
        if np.all(use) or (outcome[0] == 0 and untouched(elastic)):
            break
        notes.append("two of the four sides were left out at first, but may touch: included")
        use = np.ones(4, dtype=bool)
    bound = round_off(elastic, outcome[4])
    record, support = as_prepared(elastic)
    report = SolverReport(
        iterations=outcome[1], evaluations=outcome[2], residual=outcome[3], seconds=perf_counter() - start,
        unknowns=elastic.state[0].size + elastic.state[1].size, elements=problem.nodes.size - 1,
        engine="compiled" if jit.is_compiled(kernels.__name__) else "interpreted",
        formulation="convex energy, elastic bodies condensed to the contacts", round_off_bound=bound,
        setup_seconds=prepared_at - start,
    )  # fmt: skip
    left = (*describe_left_out(record, mechanism, everything=everything), *notes, *_cut(elastic))
    result = assemble_result(record, name, verdict(outcome, max(bound, ACCEPTED)), report, left, support)
    source = idealised(backend, scene.track.lead == 0.0) if condensed is None else (condensed.describe(),)
    return replace(result, assumed=(*result.assumed, *source, *elastic.assumed))


def _cut(elastic: Elastic) -> tuple[str, ...]:
    """What was done to keep the compliance positive."""
    clipped = elastic.flanks.clipped
    if clipped <= 1e-6:
        return ()
    return (f"negative compliance of the bodies, up to {100 * clipped:.2g} % of a contact's: cut away",)


def as_prepared(elastic: Elastic) -> tuple[Prepared, Support]:
    """The solved state in the form that results are made of: motions, contacts, reactions of the supports."""
    problem = elastic.problem
    record = prepare(problem, elastic.engine)
    q, d, p, contact = record.state
    used = [s for s in range(2) if problem.use[s]]
    pushes = flank_forces(elastic)[:, used].transpose(1, 0, 2).reshape(-1, 2)
    q[:] = node_motions(elastic.shaft, pushes, elastic.state[1], used)
    d[:] = 0.0
    p[:], contact[:], shifts = contacts_of(elastic)
    nodal = np.zeros((problem.nodes.size, 6))
    if problem.basis is None:
        nodal = (elastic.shaft.times(q.ravel()) - problem.load.ravel() - flank_loads(problem, pushes, used)).reshape(-1, 6)
    held = np.where(problem.fixed, nodal, 0.0)
    record.scale = max(elastic.scale, float(np.abs(held[:, :3]).max(initial=0.0)))
    return record, Support(held, shifts)


def with_discretisation(scene: Scene, result: StaticResult, **options: Any) -> StaticResult:
    """Add the beam's discretisation error: `lowfi.static.with_discretisation` for ``solve_elastic`` with these options."""
    if scene.ingredients.screw == "rigid" or not result.converged:
        return result
    if scene.ingredients.partition == "nodal":
        other = solve_elastic(scene, refine=2, **options)
    else:
        nodal = replace(scene, ingredients=replace(scene.ingredients, partition="nodal"))
        other = solve_elastic(nodal, **options)
    loaded = other.load[other.load > 0.0]
    measured = float(np.abs(result.load - other.load).max()), float(loaded.mean()) if loaded.size else 0.0
    return replace(result, solver=replace(result.solver, discretisation=measured))
