"""Many specimens of one screw with random errors: loads of every member, and bands over them.

Where balls, pitch and roundness are random and flanks are exact arcs, one system serves all members: they are drawn and
packed at once, and compiled kernels run through them. Anything else goes member by member through ``solve_static``.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from rollbench.compare.models.study import Study
from rollbench.lowfi.statics.contacts import hertz_C
from rollbench.lowfi.statics.held import free_motions
from rollbench.lowfi.statics.kernel_types import MemberArrays, MemberStates
from rollbench.lowfi.statics.problem import Problem, build, distances, lever_arms
from rollbench.lowfi.statics.result import StaticResult
from rollbench.lowfi.statics.selection import all_clear, all_sides, choose_sides
from rollbench.lowfi.statics.settle import ACCEPTED
from rollbench.lowfi.statics.shape import motion_matrices
from rollbench.lowfi.statics.static import Beam, Engine, pick_engine, pin, prepare, scale_of, solve_static
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import Specimens, alike_in_shape, specimen, specimens, without_draws
from rollbench.meshes.helix import BallLayout, ball_layout, nominal_groove_centres
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
