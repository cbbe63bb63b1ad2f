"""Many specimens of one scene with random errors: loads of every member, solved in blocks, and bands over them.

Where balls, pitch and roundness are random and flanks are exact arcs, one system serves all members: they are drawn and
packed at once, and compiled kernels run through them. Anything else goes member by member through ``solve_static``.

Several sets draw errors of their own. Of the whole: largest load, tangent rigidity along the axis where it is asked for,
contacts lost. Of each set: largest and mean load, force along the axis on the shaft, contacts lost, life. Rollers draw no
errors, but feel those of the balls.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np
from numpy.typing import NDArray

from rollbench.compare.models.loading import scaled
from rollbench.compare.models.registry import Options, run_model
from rollbench.compare.models.study import Study
from rollbench.lowfi.compliance.parts import LADDER
from rollbench.lowfi.jit import STATICS, kernels
from rollbench.lowfi.statics.contacts import hertz_C
from rollbench.lowfi.statics.elastic import ElasticMembers, shared
from rollbench.lowfi.statics.held import free_motions
from rollbench.lowfi.statics.kernel_types import MemberArrays, MemberStates
from rollbench.lowfi.statics.nominal import nominal_contacts
from rollbench.lowfi.statics.problem import Problem, build, distances, lever_arms
from rollbench.lowfi.statics.result import AxisResult, Solved, StaticResult
from rollbench.lowfi.statics.selection import all_clear, all_sides, choose_sides
from rollbench.lowfi.statics.settle import ACCEPTED
from rollbench.lowfi.statics.shape import motion_matrices
from rollbench.lowfi.statics.static import Beam, Engine, pick_engine, pin, prepare, scale_of, solve_static
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.errors import Specimens, alike_in_shape, specimen, specimens, without_draws
from rollbench.meshes.helix import BallLayout, ball_layout, nominal_groove_centres
from rollbench.meshes.loads import mean_load
from rollbench.meshes.parts import Scene

#: Many solves pay for compiled kernels.
ENGINE: Engine = "compiled"

#: A flank left out at first counts as touched when a ball comes this near [m]: the member is solved with all four.
MARGIN = 1e-7

#: Relative residual to which a member of a batch is solved: one step of Newton's method less than a single solve takes, and
#: far below what its loads are used for.
ENOUGH = 1e-11

#: Members tried first with fewer sides; the rest only if at least half of them pass.
TRIAL = 32

#: Members per call of the kernels, which let other threads run: so few that the memory of a call is not given back in
#: between.
CHUNK = 96


@dataclass(frozen=True)
class EnsembleResult:
    """Loads of every member of a scene with random errors.

    loads ``(M, N, 4)`` [N] (nan where there is no equilibrium); statuses ``(M,)`` as in ``StaticResult``; residuals
    ``(M,)``; works ``(M,)``, loads times the motions of their stations [J]; all_sides: members that needed all four sides;
    general: members that went through ``solve_static``.
    """

    loads: Array
    statuses: tuple[str, ...]
    residuals: Array
    works: Array
    all_sides: int
    general: int

    @property
    def converged(self) -> NDArray[np.bool_]:
        """Which members may be used, ``(M,)``."""
        return np.array([s == "converged" for s in self.statuses], dtype=bool)


def one_pass(scene: Scene) -> bool:
    """Whether one pass of the solver on exact arcs finishes each member of a scene, so that batches can be solved."""
    return alike_in_shape(scene) and scene.ingredients.hertz != "actual"


def run_ensemble(scene: Scene, members: int | None = None, first: int = 0, *, threads: int = 1) -> EnsembleResult:
    """Solve ``members`` members (default: as many as the scene states) from ``first`` on; same loads as ``solve_static``.

    threads: how many run side by side; the numbers do not depend on it. Members without solution are reported in
    ``statuses``.
    """
    count = scene.members if members is None else members
    batch = _Batch(scene, count, first, threads)
    all_sides = batch.solve() if one_pass(scene) else 0
    statuses, left = ["converged"] * count, np.flatnonzero(~batch.solved)
    for m in left:
        result = solve_static(scene, engine=ENGINE, member=first + int(m))
        batch.loads[m], statuses[m] = result.load, result.status
        batch.residuals[m], batch.works[m] = result.solver.residual, work_of(scene, result)
    return EnsembleResult(batch.loads, tuple(statuses), batch.residuals, batch.works, all_sides, int(left.size))


def work_of(scene: Scene, result: StaticResult) -> float:
    """Loads of a scene times the motions of their stations in a result [J]; nan where it has no
    line of them."""
    if result.centreline_z.size < 2:
        return float("nan")
    work = 0.0
    for x in scene.loads:
        motion = result.centreline[int(np.abs(result.centreline_z - x.at).argmin())]
        work += float(np.dot((*x.force, *x.moment), motion))
    return work


class _Batch:
    """State of one run: the drawn specimens, the common system and the members' results."""

    def __init__(self, scene: Scene, count: int, first: int, threads: int) -> None:
        self.scene, self.threads = scene, threads
        self.layout = ball_layout(scene)
        self.mean = specimen(without_draws(scene), self.layout)
        self.drawn = specimens(scene, self.layout, first, count)
        self.C = hertz_C(scene, self.mean, self.drawn.ball_radius)
        self.loads, self.solved = np.full((count, scene.ball_count, 4), np.nan), np.zeros(count, dtype=bool)
        self.residuals, self.works = np.full(count, np.nan), np.full(count, np.nan)

    def _of(self, members: NDArray[np.int64]) -> Specimens:
        centre = self.drawn.centre[members] if len(self.drawn.centre) > 1 else self.drawn.centre
        return Specimens(self.drawn.ball_radius[members], centre, self.drawn.radius)

    def solve(self) -> int:
        """Solve members, none of a scene that is not held; how many were tried with all four sides."""
        # sides that the loads would leave idle if no ball were tight: tried, then verified member by member
        few = choose_sides(self.scene, replace(self.mean, ball_radius=self.drawn.ball_radius.min(axis=0)))
        whole = self._held(all_sides(self.scene))
        if whole is None:
            return 0
        if not np.all(few):
            self._solve(self._held(few), np.arange(self.solved.size))
        rest = np.flatnonzero(~self.solved)
        if rest.size:
            self._solve(whole, rest)
        return int(rest.size)

    def _held(self, use: NDArray[np.bool_]) -> Problem | None:
        """The problem without random errors; None where the screw is not held."""
        problem = build(self.scene, self.mean, self.layout, use)
        if scale_of(problem).force == 0.0:  # only the random errors press anything together
            tightest = self._of(np.array([distances(self.scene, self.drawn)[1].max(axis=(1, 2)).argmax()]))
            drawn = replace(self.mean, ball_radius=tightest.ball_radius[0], centre=tightest.centre[0])
            problem = build(self.scene, drawn, self.layout, use)
        mechanism = free_motions(problem)
        return None if mechanism.driven else pin(problem, mechanism)

    def _system(self, problem: Problem) -> Beam:
        """The common system in its solution without random errors."""
        prepared = prepare(problem, pick_engine(ENGINE, self.scene.ball_count))
        prepared.iterate()
        prepared.options = prepared.options._replace(tolerance=ENOUGH)
        return prepared

    def _solve(self, problem: Problem | None, members: NDArray[np.int64]) -> None:
        """Solve members with the sides of a problem; one counts as solved where no flank left out comes near its ball.

        Gives up after ``TRIAL`` members if sides are left out and fewer than half of them pass.
        """
        if problem is None:
            return
        prepared = self._system(problem)
        near = None if np.all(problem.use) else _Nearness(prepared, self.layout)
        some = partial(self._follow, prepared, near)
        trial, rest = members[:TRIAL], [members[k : k + CHUNK] for k in range(TRIAL, members.size, CHUNK)]
        some(trial)
        if near is not None and 2 * np.count_nonzero(self.solved[trial]) < trial.size:
            return
        with ThreadPoolExecutor(self.threads) as pool:
            list((map if self.threads == 1 else pool.map)(some, rest))

    def _follow(self, prepared: Beam, near: _Nearness | None, members: NDArray[np.int64]) -> None:
        """Solve members in the compiled kernel."""
        state, k = prepared.state, members.size
        arrays = self._arrays(prepared.problem, members)
        forces, status, residual = np.empty(arrays.geometry.shape[:3]), np.empty(k, dtype=np.int64), np.empty(k)
        states = MemberStates(forces, status, residual, np.empty((k, *state.q.shape)), np.empty((k, *state.p.shape)))
        prepared.engine.ensemble(prepared.given, state, prepared.options, arrays, states)
        good = (states.status <= 1) & (states.residual <= ACCEPTED)
        if near is not None:
            shift = states.q.reshape(k, -1) @ near.rows.T
            good &= near.clear(shift, states.p, arrays.geometry, states.force)
        kept, works = members[good], np.tensordot(states.q, prepared.given.shaft.load, axes=2)
        self.loads[kept], self.residuals[kept], self.works[kept] = states.force[good], states.residual[good], works[good]
        self.solved[kept] = True

    def _arrays(self, problem: Problem, members: NDArray[np.int64]) -> MemberArrays:
        """Arrays of members for the kernels."""
        drawn = self._of(members)
        offset, closure = distances(self.scene, drawn)
        geometry = np.empty((members.size, *problem.geometry.shape))
        geometry[..., :4], geometry[..., 4], geometry[..., 5:] = offset, self.C[members], problem.geometry[..., 5:]
        B = lever_arms(problem, drawn.centre) if len(drawn.centre) > 1 else problem.B[None]
        return MemberArrays(B, geometry, closure, drawn.ball_radius)


class _Nearness:
    """Whether flanks that were left out could carry load in a solution, for many members at once: they come nearer than
    ``MARGIN``. A member in doubt is solved with all four sides.
    """

    def __init__(self, prepared: Beam, layout: BallLayout) -> None:
        problem = prepared.problem
        self.use = problem.use
        rows = [_flank_motion(problem, layout, s) for s in range(2)]
        self.rows = np.stack(rows, axis=1).reshape(-1, problem.nodes.size * 6)

    def clear(self, motions: Array, centres: Array, geometry: Array, loads: Array) -> NDArray[np.bool_]:
        """Whether none comes near, ``(k,)``: motions ``(k, 4 N)`` of the screw's flanks, centres ``(k, N, 2)``, geometry
        ``(k, N, 4, 4 or more)``, loads ``(k, N, 4)``."""
        k, n = centres.shape[:2]
        shift = np.zeros((k, n, 4, 2))
        shift[:, :, :2] = motions.reshape(k, n, 2, 2)
        return all_clear(centres, shift, geometry, loads, self.use, MARGIN)


def _flank_motion(problem: Problem, layout: BallLayout, side: int) -> Array:
    """Motion of a screw flank in each ball's section from all nodal motions, ``(N, 2, 6 n)``, built or left out."""
    n, size = layout.z.size, problem.nodes.size * 6
    out = np.zeros((n, 2, size))
    if problem.use[side] or problem.basis is not None:
        columns = 6 * problem.node[:, side, None] + np.arange(problem.B.shape[3])
        out[np.arange(n)[:, None, None], np.arange(2)[None, :, None], columns[:, None, :]] = problem.B[:, side]
        return out
    centre = nominal_groove_centres(problem.scene)[side]
    r = layout.centre + centre[0] * layout.radial + centre[1] * layout.binormal
    r[:, 2] -= layout.z
    axes = np.stack([layout.radial, layout.binormal], axis=1)
    rows = np.concatenate([axes, np.cross(r[:, None, :], axes)], axis=2)
    first, matrices = motion_matrices(layout.z, problem.nodes, problem.section)
    for i, (j, row) in enumerate(zip(first, rows @ matrices, strict=True)):
        out[i, :, 6 * j : 6 * j + 12] = row
    return out


def of_study(study: Study, name: str) -> EnsembleResult:
    """Drawn screws of a shipped scene with random errors, as many as the study says."""
    return study.once(_drawn, name)


def _drawn(study: Study, name: str) -> EnsembleResult:
    return run_ensemble(study.scene(name), study.members)


#: What is kept of each member: key and heading.
KEPT = {
    "largest_load_N": "largest contact load / N",
    "mean_load_N": "mean contact load / N",
    "load_stiffness_N_per_um": "stiffness at the loads / (N/um)",
    "lost_contacts": "contacts lost against no random errors",
    "relative_life": "life over that without random errors",
    "residual": "relative residual",
}

#: The same of several sets: of the whole, and of each.
WHOLE = {
    "largest_load_N": "largest load of a contact or roller / N",
    "tangent_N_per_um": "tangent rigidity along the axis / (N/um)",
    "lost_contacts": "contacts lost against no random errors",
    "residual": "relative residual",
}

OF_SET = {
    "largest_load_N": "largest load / N",
    "mean_load_N": "mean load of those above 1 % of the largest / N",
    "axial_force_N": "axial force on the shaft / N",
    "lost_contacts": "contacts lost",
    "relative_life": "life over that without random errors",
}


#: Exponents of the loads of a raceway that turns under the load and of one that does not, and of raceways together.
TURNING, STANDING, SYSTEM = 3.0, 10.0 / 3.0, 10.0 / 9.0

#: Part of the load by which the stiffness at the loads is taken.
STEP = 1e-3

#: Models with elastic bodies, whose members may share one system.
ELASTIC = tuple(name for name in LADDER if name != "lin")


@dataclass(frozen=True)
class Block:
    """Loads (k, N, 4) of a block, numbers (k, ...), statuses."""

    loads: Array
    kept: Array
    statuses: tuple[str, ...]


def life_sum(load: Array) -> Array:
    """L^(-10/9) of all raceways together, to a factor, from loads (..., N, 4) [N]: ISO/TS 16281, equivalent loads.

    The screw's grooves turn under the load (cubic mean over the balls), the nut's do not (power 10/3); the raceways are
    taken as equally strong, and every ball's place as equally frequent.
    """
    turning = (load[..., :2] ** TURNING).mean(axis=-2) ** (SYSTEM * 3.0 / TURNING)
    standing = (load[..., 2:] ** STANDING).mean(axis=-2) ** (SYSTEM * 3.0 / STANDING)
    return np.asarray(turning.sum(axis=-1) + standing.sum(axis=-1))


def relative_life(load: Array, nominal: Array) -> Array:
    """Life under loads (..., N, 4) over that under the loads (N, 4) without random errors."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray((life_sum(load) / life_sum(nominal)) ** (-1.0 / SYSTEM))


def columns(scene: Scene | Assembly) -> list[str]:
    """Names of the numbers of a member."""
    if isinstance(scene, Scene):
        return [*KEPT]
    return [*WHOLE, *(f"set {i + 1} {key}" for i in range(len(scene.sets)) for key in OF_SET)]


def places(scene: Scene | Assembly) -> tuple[slice | None, ...]:
    """Place of each set's balls among those of all sets."""
    if isinstance(scene, Scene):
        return (slice(0, scene.ball_count),)
    slices: list[slice | None] = []
    first = 0
    for s in scene.sets:
        count = s.parts.ball_count if isinstance(s.parts, Scene) else 0
        slices.append(slice(first, first + count) if count else None)
        first += count
    return tuple(slices)


def _with_parts(scene: Scene | Assembly, change: Callable[[Scene, int], Scene]) -> Scene | Assembly:
    """The scene with the parts of each set of balls changed; change: takes them and the number of the set, from 0."""
    if isinstance(scene, Scene):
        return change(scene, 0)
    sets = (replace(s, parts=change(s.parts, i)) if isinstance(s.parts, Scene) else s for i, s in enumerate(scene.sets))
    return replace(scene, sets=tuple(sets))


def with_seed(scene: Scene | Assembly, seed: int) -> Scene | Assembly:
    """The scene with a seed of its random errors, or seeds that count on from it, set by set."""
    return _with_parts(scene, lambda parts, i: replace(parts, errors=replace(parts.errors, seed=seed + i)))


def without_random_errors(scene: Scene | Assembly) -> Scene | Assembly:
    """The scene that its members scatter about."""
    return _with_parts(scene, lambda parts, _: without_draws(parts))


def _solved(
    scene: Scene, model: str, engine: str, first: int, count: int, factor: float = 1.0
) -> tuple[Array, tuple[str, ...], Array, Array]:
    """Loads, statuses, residuals and works of some members under the loads times a factor; with one other than 1 after
    those under the loads themselves."""
    of, scene = scene, scaled(scene, factor) if factor != 1.0 else scene
    if model == "lin" and engine == "compiled":
        batch = run_ensemble(scene, count, first)
        return batch.loads, batch.statuses, batch.residuals, batch.works
    loads, residuals, works = np.full((count, scene.ball_count, 4), np.nan), np.full(count, np.nan), np.full(count, np.nan)
    if model in ELASTIC and shared(scene):
        loads, residuals, works = _system(of, model, engine, factor).solve(first, count)
    statuses = ["converged"] * count
    for k in np.flatnonzero(np.isnan(residuals)):
        result = run_model(scene, model, Options(member=first + int(k), engine=engine, discretisation=False))
        statuses[k], residuals[k] = result.status, result.solver.residual
        if result.converged:
            loads[k], works[k] = result.load, work_of(scene, result)
    return loads, tuple(statuses), residuals, works


@lru_cache(maxsize=4)
def _system(scene: Scene, model: str, engine: str, factor: float) -> ElasticMembers:
    """The solver of all blocks of a scene in this process, under its loads times a factor."""
    like = None if factor == 1.0 else _system(scene, model, engine, 1.0)
    loaded = scene if like is None else scaled(scene, factor)
    return ElasticMembers(loaded, LADDER[model], kernels(STATICS, compiled=engine == "compiled"), like)


def solve_block(scene: Scene | Assembly, model: str, engine: str, nominal: Array, first: int, count: int) -> Block:
    """Members ``first`` and on; nominal: loads (N, 4) [N] of all balls without random errors."""
    if isinstance(scene, Assembly):
        return _of_several(scene, model, engine, nominal, first, count)
    loads, statuses, residuals, works = _solved(scene, model, engine, first, count)
    force = float(sum(np.dot(x.force, x.force) for x in scene.loads))
    stiffness = np.full(count, np.nan)
    if force > 0.0:
        asked = scene.ingredients.load_step if model == "liu" else None
        step = STEP if asked is None else asked / force**0.5
        heavier = _solved(scene, model, engine, first, count, 1.0 + step)[3] / (1.0 + step)
        with np.errstate(divide="ignore", invalid="ignore"):
            stiffness = 1e-6 * force * step / (heavier - works)
    good = np.array([s == "converged" for s in statuses])
    loads[~good] = np.nan
    contacts = nominal_contacts(scene)
    mean = np.array([mean_load(load, contacts) for load in loads])
    lost = (~(loads > 0.0) & (nominal > 0.0)).sum(axis=(1, 2)).astype(float)
    kept = np.column_stack([loads.max(axis=(1, 2)), mean, stiffness, lost, relative_life(loads, nominal), residuals])
    kept[~good] = np.nan
    return Block(loads, kept, statuses)


def _of_several(assembly: Assembly, model: str, kernels: str, nominal: Array, first: int, count: int) -> Block:
    """`solve_block` of several sets."""
    results = [run_model(assembly, model, Options(engine=kernels, member=m)) for m in range(first, first + count)]
    where = places(assembly)
    loads = np.stack([contact_loads(r) if r.converged else np.full(nominal.shape, np.nan) for r in results])
    wide = len(columns(assembly))
    kept = [numbers(r, nominal, where) if r.converged else np.full(wide, np.nan) for r in results]
    return Block(loads, np.array(kept), tuple(r.status for r in results))


def contact_loads(result: Solved) -> Array:
    """Loads (N, 4) [N] of the balls of all sets."""
    return np.concatenate([b.load for b in result.of_balls()])


def numbers(result: AxisResult, nominal: Array, where: Sequence[slice | None]) -> Array:
    """What is kept of a member."""
    loads = contact_loads(result)
    lost = (loads == 0.0) & (nominal > 0.0)
    largest = max(float(s.loads.max(initial=0.0)) for s in result.sets)
    stiffness = np.nan if result.stiffness is None else 1e-6 * float(result.stiffness[2, 2])
    kept = [largest, stiffness, float(lost.sum()), result.solver.residual]
    for s, place in zip(result.sets, where, strict=True):
        kept += [float(s.loads.max(initial=0.0)), mean_load(s.loads), float(s.force[2])]
        known = place is not None
        kept += [float(lost[place].sum()), float(relative_life(loads[place], nominal[place]))] if known else [np.nan] * 2
    return np.array(kept)
