"""Many specimens of one screw with random errors: loads of every member, and bands over them.

Where only the ball radii are random, one system serves all members and compiled kernels run through them. Anything else
goes member by member through ``solve_static``.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from lowfi.statics.mechanism import free_motions
from lowfi.statics.problem import Problem, build, distances, hertz_C
from lowfi.statics.result import StaticResult
from lowfi.statics.selection import all_clear, choose_sides
from lowfi.statics.shape import motion_matrices
from lowfi.statics.static import ACCEPTED, Engine, Prepared, pick_engine, pin, prepare, reference_scale, run, solve_static
from meshes.errors import draw_ball_radii, specimen
from meshes.helix import BallLayout, ball_layout, nominal_groove_centres
from meshes.parts import SIDES, BallErrors, Scene

Array = NDArray[np.float64]
#: Many solves pay for compiled kernels.
ENGINE: Engine = "compiled"

#: A flank left out at first counts as touched when a ball comes this near [m]: the member is solved with all four.
MARGIN = 1e-7
#: Members tried first with fewer sides; the rest only if at least half of them pass.
TRIAL = 32
#: Members per call of the kernel that runs through them (bounds its memory).
CHUNK = 500
RADII_PATH = "one system, members differ in ball radii"
GENERAL_PATH = "member by member"


@dataclass(frozen=True)
class EnsembleResult:
    """Loads of every member of a scene with random errors.

    loads ``(M, N, 4)`` [N] (nan where there is no equilibrium); statuses ``(M,)`` as in ``StaticResult``; residuals
    ``(M,)``; works ``(M,)``, loads times the motions of their stations [J]; solve_seconds and setup_seconds per member
    (wall clock; setup: drawing and packing); path: how they were solved; all_sides: members that needed all four sides;
    general: members that went through ``solve_static``.
    """

    scene: str
    loads: Array
    statuses: tuple[str, ...]
    residuals: Array
    works: Array
    solve_seconds: float
    setup_seconds: float
    path: str
    all_sides: int
    general: int

    @property
    def converged(self) -> NDArray[np.bool_]:
        """Which members may be used, ``(M,)``."""
        return np.array([s == "converged" for s in self.statuses], dtype=bool)


def only_radii_differ(scene: Scene) -> bool:
    """Whether the members of a scene differ in nothing but ball radii, and one pass of the solver finishes each."""
    sides = [scene.errors.side(name) for name in SIDES]
    drawn = any(any(s > 0.0 for s in e.profile_sigma) for e in sides) or any(
        t.sigma > 0.0 for e in sides for t in (*e.pitch, *e.roundness)
    )
    uneven = any(len(e.profile) > 1 for e in sides)
    return not drawn and not uneven and scene.ingredients.hertz != "actual"


def run_ensemble(scene: Scene, members: int | None = None, first: int = 0) -> EnsembleResult:
    """Solve ``members`` members (default: as many as the scene states) from ``first`` on; same loads as ``solve_static``.

    Members without solution are reported in ``statuses``. Raises ValueError for less than one member.
    """
    count = scene.members if members is None else members
    if count < 1:
        raise ValueError(f"members = {count}; allowed: 1 or more")
    if only_radii_differ(scene):
        result = _RadiiEnsemble(scene, count, first).solve()
        if result is not None:
            return result
    begin = perf_counter()
    found = [_one(scene, m) for m in range(first, first + count)]
    return EnsembleResult(
        scene.name,
        np.stack([f[0] for f in found]),
        tuple(f[1] for f in found),
        np.array([f[2] for f in found]),
        np.array([f[3] for f in found]),
        (perf_counter() - begin) / count,
        0.0,
        GENERAL_PATH,
        0,
        count,
    )


def _one(scene: Scene, member: int) -> tuple[Array, str, float, float]:
    result = solve_static(scene, engine=ENGINE, member=member)
    return result.load, result.status, float(result.solver.residual), work_of(scene, result)


def work_of(scene: Scene, result: StaticResult) -> float:
    """Loads of a scene times the motions of their stations in a result [J]; nan where it has none."""
    if not result.centreline_z.size:
        return float("nan")
    work = 0.0
    for x in scene.loads:
        motion = result.centreline[int(np.abs(result.centreline_z - x.at).argmin())]
        work += float(np.dot((*x.force, *x.moment), motion))
    return work


class _RadiiEnsemble:
    """State of one run: the drawn radii, the common system and the members' results."""

    def __init__(self, scene: Scene, count: int, first: int = 0) -> None:
        begin = perf_counter()
        self.scene = scene
        self.layout = ball_layout(scene)
        self.mean = specimen(_without_draws(scene), self.layout)
        n = scene.ball_count
        self.radii = np.stack([_radii(scene, m) for m in range(first, first + count)])
        self.first, self.works = first, np.full(count, np.nan)
        self.closures = self._closures()
        self.loads, self.residuals = np.full((count, n, 4), np.nan), np.full(count, np.nan)
        self.solved = np.zeros(count, dtype=bool)
        self.setup = perf_counter() - begin

    def _closures(self) -> Array:
        """Interference of the diagonal pairs, ``(M, N, 2)`` [m]: it grows by twice what the ball's radius grows."""
        _, closure = distances(self.scene, self.mean)
        return closure[None] + 2.0 * (self.radii - self.mean.ball_radius)[..., None]

    def solve(self) -> EnsembleResult | None:
        """All members, or None for a scene that is not held."""
        begin = perf_counter()
        # sides that the loads would leave idle if no ball were tight: tried, then verified member by member
        few = choose_sides(self.scene, replace(self.mean, ball_radius=self.radii.min(axis=0)))
        if self._system(np.ones(4, dtype=bool)) is None:
            return None
        if not np.all(few):
            self._solve_reduced(few)
        rest = np.flatnonzero(~self.solved)
        if rest.size:
            self._solve_full(rest)
        statuses = ["converged"] * len(self.radii)
        left = np.flatnonzero(~self.solved)
        for m in left:
            self.loads[m], statuses[m], self.residuals[m], self.works[m] = _one(self.scene, self.first + int(m))
        count = len(self.radii)
        return EnsembleResult(
            self.scene.name,
            self.loads,
            tuple(statuses),
            self.residuals,
            self.works,
            (perf_counter() - begin) / count,
            self.setup / count,
            RADII_PATH,
            int(rest.size),
            int(left.size),
        )

    def _system(self, use: NDArray[np.bool_]) -> Prepared | None:
        """The common system, started from the solution without random errors; None where the screw is not held."""
        problem = build(self.scene, self.mean, self.layout, use)
        if reference_scale(problem)[0] == 0.0:  # only the random errors press anything together
            tightest = int(self.closures.max(axis=(1, 2)).argmax())
            problem = build(self.scene, replace(self.mean, ball_radius=self.radii[tightest]), self.layout, use)
        mechanism = free_motions(problem)
        if mechanism.driven:
            return None
        prepared = prepare(pin(problem, mechanism), pick_engine(ENGINE, self.scene.ball_count))
        run(prepared)
        return prepared

    def _contacts(self, prepared: Prepared, members: NDArray[np.int64]) -> tuple[Array, Array, Array]:
        """Radii, closures and packed geometry ``(k, N, 4, 9)`` of some members."""
        radii = self.radii[members]
        geometry = np.repeat(prepared.problem.geometry[None], members.size, axis=0)
        geometry[..., 3] += (radii - prepared.problem.drawn.ball_radius)[..., None]
        geometry[..., 4] = hertz_C(self.scene, self.mean, radii)
        return radii, np.ascontiguousarray(self.closures[members]), geometry

    def _solve_full(self, members: NDArray[np.int64]) -> None:
        """Members with all four sides: the kernel runs through them."""
        prepared = self._system(np.ones(4, dtype=bool))
        if prepared is None:
            return
        for first in range(0, members.size, CHUNK):
            part = members[first : first + CHUNK]
            loads = np.zeros((part.size, self.radii.shape[1], 4))
            statuses, residuals, works = np.zeros(part.size, dtype=np.int64), np.zeros(part.size), np.zeros(part.size)
            prepared.engine.ensemble(
                prepared.beam,
                prepared.contacts,
                prepared.state,
                prepared.options,
                *self._contacts(prepared, part),
                loads,
                statuses,
                residuals,
                works,
            )
            good = (statuses <= 1) & (residuals <= ACCEPTED)
            self.loads[part[good]], self.residuals[part[good]] = loads[good], residuals[good]
            self.works[part[good]] = works[good]
            self.solved[part] = good

    def _solve_reduced(self, use: NDArray[np.bool_]) -> None:
        """All members with the sides ``use``; only those count as solved that no flank left out comes near.

        Gives up after ``TRIAL`` members if fewer than half of them pass.
        """
        prepared = self._system(use)
        if prepared is None:
            return
        near = _Nearness(prepared, self.layout)
        begin = self._copy_start(prepared)
        members = np.arange(len(self.radii))
        edges = [0, *range(min(TRIAL, members.size), members.size, CHUNK), members.size]
        for first, last in pairwise(edges):
            self._solve_part(prepared, begin, near, members[first:last])
            if 2 * np.count_nonzero(self.solved[:last]) < last:
                break

    @staticmethod
    def _copy_start(prepared: Prepared) -> tuple[Array, Array]:
        return prepared.state.q.copy(), prepared.state.d.copy()

    def _solve_part(self, prepared: Prepared, begin: tuple[Array, Array], near: _Nearness, part: NDArray[np.int64]) -> None:
        beam, state, options, history = prepared.beam, prepared.state, prepared.options, prepared.history
        solve = prepared.engine.solve
        q, d, p, contact = state
        radii, closures, geometry = self._contacts(prepared, part)
        motions, centres = np.empty((part.size, *q.shape)), np.empty((part.size, *p.shape))
        good = np.zeros(part.size, dtype=bool)
        for k, m in enumerate(part):
            q[:], d[:] = begin
            own = prepared.contacts._replace(geometry=geometry[k], closure=closures[k], r_ball=radii[k])
            outcome = solve(beam, own, state, options, history)
            good[k] = outcome.status <= 1 and outcome.residual <= ACCEPTED
            motions[k], centres[k] = q, p
            self.loads[m], self.residuals[m] = contact[..., 0], outcome.residual
            self.works[m] = float(np.vdot(beam.load, q))
        good &= ~near.touched(motions.reshape(part.size, -1), centres, geometry, self.loads[part])
        self.solved[part] = good


def _without_draws(scene: Scene) -> Scene:
    balls = scene.errors.balls
    fixed = BallErrors(oversize=balls.oversize, listed=balls.listed)
    return replace(scene, errors=replace(scene.errors, balls=fixed))


def _radii(scene: Scene, member: int) -> Array:
    """Ball radii of a member: the first draws of ``meshes.errors.specimen``, from the same stream."""
    return draw_ball_radii(scene, np.random.default_rng([scene.errors.seed, member]))


class _Nearness:
    """Whether flanks that were left out could carry load in a solution, for many members at once: they come nearer than
    ``MARGIN``. A member in doubt is solved with all four sides.
    """

    def __init__(self, prepared: Prepared, layout: BallLayout) -> None:
        problem = prepared.problem
        self.use = problem.use
        rows = [_flank_motion(problem, layout, s) for s in range(2)]
        self.rows = np.stack(rows, axis=1).reshape(-1, problem.nodes.size * 6)

    def touched(self, motions: Array, centres: Array, geometry: Array, loads: Array) -> NDArray[np.bool_]:
        """motions ``(k, 6 n)``, centres ``(k, N, 2)``, geometry ``(k, N, 4, 9)``, loads ``(k, N, 4)`` -> ``(k,)``."""
        k, n = centres.shape[:2]
        shift = np.zeros((k, n, 4, 2))
        shift[:, :, :2] = (motions @ self.rows.T).reshape(k, n, 2, 2)
        return np.asarray(~all_clear(centres, shift, geometry, loads, self.use, MARGIN))


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
