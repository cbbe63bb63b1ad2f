"""Contact loads of many specimens of a scene (an ensemble), each with its own random geometric errors, solved in blocks.

If ball sizes, pitch and roundness are random and flanks are exact arcs, all specimens share one system of equations: they
are drawn at once, and compiled kernels run through them. Other scenes are solved specimen by specimen by ``solve_static``.

On a shaft with several nuts and ball bearings, these have independent errors. Stored for the whole shaft are the largest
load, the axial tangent rigidity and the number of lost contacts (contacts that carry load only without random errors); for
each nut or bearing, the largest and mean load, the axial force on the shaft, the number of lost contacts and the life.
Rollers have no random errors, but their loads change with the errors of the balls.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np
from numpy.typing import NDArray

from rollbench.compare.measure import mean_load
from rollbench.compare.models.loading import with_scaled_loads
from rollbench.compare.models.registry import ModelOptions, run_model
from rollbench.compare.models.study import SceneResultCache
from rollbench.lowfi.compliance.parts import LADDER
from rollbench.lowfi.jit import STATICS, load_kernel_package
from rollbench.lowfi.statics import problem as statics_problem
from rollbench.lowfi.statics import static
from rollbench.lowfi.statics.contacts import hertz_constants_by_scene_choice
from rollbench.lowfi.statics.elastic import SpecimensWithSharedEquations, can_share_equations
from rollbench.lowfi.statics.held import find_unresisted_motions
from rollbench.lowfi.statics.kernel_types import SpecimenArrays, SpecimenSolutions
from rollbench.lowfi.statics.nominal import count_nominal_contacts
from rollbench.lowfi.statics.result import AxisResult, StaticResult, StaticSolution
from rollbench.lowfi.statics.selection import choose_flanks, flanks_of_scene, solutions_clear_of_left_out_flanks
from rollbench.lowfi.statics.settle import ACCEPTED
from rollbench.lowfi.statics.shape import beam_interpolation_matrices
from rollbench.meshes import errors
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.helix import BallLayout, ball_layout, nominal_groove_centres
from rollbench.meshes.parts import Scene

#: How numerical kernels run: as machine code, because for many solutions compiling them is worthwhile.
ENGINE: static.Engine = "compiled"

#: Distance between ball and flank at which a flank that was left out counts as touched [m]; the specimen is then solved
#: with all four flanks.
MARGIN = 1e-7

#: Relative residual at which the specimens of a batch count as solved. It saves one step of Newton's method compared with a
#: single solution, and is far below the accuracy that the uses of the loads need.
ENOUGH = 1e-11

#: Number of specimens that are first tried without the flanks that should not carry load; the other specimens are tried so
#: only if at least half of the first ones pass the check of the omitted flanks.
TRIAL = 32

#: Number of specimens per call of the kernels; so few that memory is reused from call to call. Other threads can run
#: meanwhile.
CHUNK = 96


@dataclass(frozen=True)
class RandomDrawsResult:
    """Contact loads of a scene for M random draws of its geometric errors; each draw is called a specimen."""

    #: Contact loads of N balls on the four flanks (screw left, screw right, nut left, nut right) in each draw, (M, N, 4)
    #: [N]; nan without equilibrium.
    loads: Array
    #: Status of the solution of each specimen, as in ``StaticResult``.
    statuses: tuple[str, ...]
    #: Relative residual of each specimen's equations, (M,).
    residuals: Array
    #: Sum of the scene's external loads times the displacements of the points at which they act, (M,) [J].
    works_of_loads: Array
    #: Number of specimens that were solved with contacts on all four flanks, not only on the flanks expected to be loaded.
    all_flanks_count: int
    #: Number of specimens that were solved one by one with ``solve_static``, not together.
    singly_solved_count: int

    @property
    def converged(self) -> NDArray[np.bool_]:
        """Whether each of the M random draws has an equilibrium, (M,)."""
        return np.array([s == "converged" for s in self.statuses], dtype=bool)


def can_share_one_system_of_equations(scene: Scene) -> bool:
    """Return whether many random draws of the scene's geometric errors can be solved together, by one system of equations.

    They can if only ball sizes, pitch and roundness have errors, so that flanks are exact circular arcs, and if the Hertz
    constants do not depend on the actual contact angle.
    """
    return errors.have_equal_circular_grooves(scene) and scene.ingredients.hertz != "actual"


def solve_random_draws(scene: Scene, members: int | None = None, first: int = 0, *, threads: int = 1) -> RandomDrawsResult:
    """Solve many random draws of a scene's geometric errors (specimens), with results as from ``solve_static`` for each.

    Parameters
    ----------
    scene
        Scene of one nut or bearing.
    members
        Number of specimens; None: the number that the scene states.
    first
        Number of the first specimen.
    threads
        Number of threads, which does not affect the result.

    Returns
    -------
    RandomDrawsResult
        Contact loads; ``statuses`` shows which specimens have no solution.
    """
    count = scene.members if members is None else members
    batch = _RandomDrawBatch(scene, count, first, threads)
    all_sides = batch.solve() if can_share_one_system_of_equations(scene) else 0
    statuses, left = ["converged"] * count, np.flatnonzero(~batch.solved)
    for m in left:
        result = static.solve_static(scene, engine=ENGINE, member=first + int(m))
        batch.loads[m], statuses[m] = result.load, result.status
        batch.residuals[m], batch.works[m] = result.solver.residual, work_done_by_loads(scene, result)
    return RandomDrawsResult(batch.loads, tuple(statuses), batch.residuals, batch.works, all_sides, int(left.size))


def work_done_by_loads(scene: Scene, result: StaticResult) -> float:
    """Return the sum of a scene's loads times the displacements of the points at which they act [J].

    Nan if the result has no displacements of the screw.
    """
    if result.centreline_z.size < 2:
        return float("nan")
    work = 0.0
    for x in scene.loads:
        motion = result.centreline[int(np.abs(result.centreline_z - x.at).argmin())]
        work += float(np.dot((*x.force, *x.moment), motion))
    return work


class _RandomDrawBatch:
    """Random draws of a scene's geometric errors (specimens) that share one system of equations, with contact loads.

    After `solve`, ``loads`` has the contact loads (M, N, 4) [N] of M specimens with N balls, ``residuals`` the relative
    residuals (M,), ``works`` the loads times the displacements of the points at which they act (M,) [J], and ``solved``
    whether each specimen has a solution (M,).
    """

    def __init__(self, scene: Scene, count: int, first: int, threads: int) -> None:
        """Draw the random geometric errors of a scene ``count`` times, from draw number ``first`` on.

        ``threads``: number of threads that `solve` uses.
        """
        self.scene, self.threads = scene, threads
        self.layout = ball_layout(scene)
        self.mean = errors.draw_geometry_with_errors(errors.scene_without_random_errors(scene), self.layout)
        self.drawn = errors.draw_geometries_with_errors(scene, self.layout, first, count)
        self.C = hertz_constants_by_scene_choice(scene, self.mean, self.drawn.ball_radii)
        self.loads, self.solved = np.full((count, scene.ball_count, 4), np.nan), np.zeros(count, dtype=bool)
        self.residuals, self.works = np.full(count, np.nan), np.full(count, np.nan)

    def _drawn_errors(self, draws: NDArray[np.int64]) -> errors.GeometriesWithErrors:
        """Return the geometric errors of the random draws with the numbers ``draws`` in this batch."""
        drawn, centres = self.drawn, self.drawn.groove_centres
        centres = centres[draws] if len(centres) > 1 else centres
        return errors.GeometriesWithErrors(drawn.ball_radii[draws], centres, drawn.groove_radii)

    def solve(self) -> int:
        """Solve all random draws and store their contact loads; return for how many all flanks had to be included.

        Flanks that are expected to carry no load are first left out of the equations. Draws without accepted solution, such
        as those in which a ball comes near such a flank, are solved again with all flanks. No draw is solved if the scene
        cannot carry its loads.
        """
        # flanks that carry no load if no ball is too large are left out, which is then verified specimen by specimen
        few = choose_flanks(self.scene, replace(self.mean, ball_radii=self.drawn.ball_radii.min(axis=0)))
        whole = self._problem_with_flanks(flanks_of_scene(self.scene))
        if whole is None:
            return 0
        if not np.all(few):
            self._solve_with_flanks(self._problem_with_flanks(few), np.arange(self.solved.size))
        rest = np.flatnonzero(~self.solved)
        if rest.size:
            self._solve_with_flanks(whole, rest)
        return int(rest.size)

    def _problem_with_flanks(self, used_flanks: NDArray[np.bool_]) -> statics_problem.Problem | None:
        """Return the static problem of the scene without random errors; None if the loads drive a free rigid motion.

        ``used_flanks``: whether each of the four flanks (screw left, screw right, nut left, nut right) takes part (4,).
        """
        problem = statics_problem.build_problem(self.scene, self.mean, self.layout, used_flanks)
        if static.residual_scale(problem).typical_force == 0.0:  # only the random errors press anything together
            interference = statics_problem.centre_vectors_and_interference(self.scene, self.drawn)[1]
            tightest = self._drawn_errors(np.array([interference.max(axis=(1, 2)).argmax()]))
            drawn = replace(self.mean, ball_radii=tightest.ball_radii[0], groove_centres=tightest.groove_centres[0])
            problem = statics_problem.build_problem(self.scene, drawn, self.layout, used_flanks)
        mechanism = find_unresisted_motions(problem)
        return None if mechanism.is_driven_by_loads else static.pin_free_motions(problem, mechanism)

    def _solve_with_flanks(self, problem: statics_problem.Problem | None, draws: NDArray[np.int64]) -> None:
        """Solve some random draws with contacts only on those flanks that ``problem`` includes; store accepted solutions.

        ``problem``: static problem, None if it has a free rigid motion; ``draws``: numbers of the specimens in
        the batch. A solution is accepted only if no ball comes near a flank that the problem leaves out.
        """
        if problem is None:
            return
        prepared = static.beam_equations(problem, static.pick_engine(ENGINE, self.scene.ball_count))
        prepared.solve_by_newton()  # without random errors
        prepared.options = prepared.options._replace(tolerance=ENOUGH)
        near = None if np.all(problem.used_flanks) else _OmittedFlankCheck(prepared, self.layout)
        some = partial(self._solve_draws_in_kernel, prepared, near)
        trial, rest = draws[:TRIAL], [draws[k : k + CHUNK] for k in range(TRIAL, draws.size, CHUNK)]
        some(trial)
        if near is not None and 2 * np.count_nonzero(self.solved[trial]) < trial.size:
            return
        with ThreadPoolExecutor(self.threads) as pool:
            list((map if self.threads == 1 else pool.map)(some, rest))

    def _solve_draws_in_kernel(
        self, equations: static.BeamEquations, check: _OmittedFlankCheck | None, draws: NDArray[np.int64]
    ) -> None:
        """Solve some random draws by one call of compiled code, and store the solutions that are accepted.

        ``equations``: common system of equations; ``check``: check of the flanks that the system leaves out,
        None if it has all; ``draws``: numbers of the specimens in the batch.
        """
        state, k = equations.state, draws.size
        arrays = self._geometry_for_kernel(equations.problem, draws)
        forces, status, residual = np.empty(arrays.geometry.shape[:3]), np.empty(k, dtype=np.int64), np.empty(k)
        states = SpecimenSolutions(forces, status, residual, np.empty((k, *state.q.shape)), np.empty((k, *state.p.shape)))
        equations.engine.solve_specimens(equations.kernel_arrays, state, equations.options, arrays, states)
        good = (states.status <= 1) & (states.residual <= ACCEPTED)
        if check is not None:
            shift = states.q.reshape(k, -1) @ check.rows.T
            good &= check.flanks_stay_clear_of_balls(shift, states.p, arrays.geometry, states.force)
        kept, works = draws[good], np.tensordot(states.q, equations.kernel_arrays.shaft.load, axes=2)
        self.loads[kept], self.residuals[kept], self.works[kept] = states.force[good], states.residual[good], works[good]
        self.solved[kept] = True

    def _geometry_for_kernel(self, problem: statics_problem.Problem, draws: NDArray[np.int64]) -> SpecimenArrays:
        """Return the geometry of some random draws as arrays for the compiled solver.

        ``problem``: static problem without random errors; ``draws``: numbers of the specimens in the batch.
        """
        drawn = self._drawn_errors(draws)
        offset, closure = statics_problem.centre_vectors_and_interference(self.scene, drawn)
        geometry = np.empty((draws.size, *problem.geometry.shape))
        geometry[..., :4], geometry[..., 4], geometry[..., 5:] = offset, self.C[draws], problem.geometry[..., 5:]
        B = problem.B[None]
        if len(drawn.groove_centres) > 1:
            B = statics_problem.flank_motions_of_specimens(problem, drawn.groove_centres)
        return SpecimenArrays(B, geometry, closure, drawn.ball_radii)


class _OmittedFlankCheck:
    """Check whether groove flanks that were left out of the equations stay clear of the balls in solved random draws.

    A specimen with such a flank nearer than ``MARGIN`` to its ball is solved again with all four flanks.
    """

    def __init__(self, prepared: static.BeamEquations, layout: BallLayout) -> None:
        """Prepare the check for the solved equations ``prepared``, which leave some flanks out."""
        problem = prepared.problem
        self.use = problem.used_flanks
        rows = [_nodal_to_flank_displacement_matrix(problem, layout, s) for s in range(2)]
        self.rows = np.stack(rows, axis=1).reshape(-1, problem.nodes.size * 6)

    def flanks_stay_clear_of_balls(
        self, flank_displacements: Array, ball_centres: Array, geometry: Array, loads: Array
    ) -> NDArray[np.bool_]:
        """Return for each of k random draws whether all flanks that the equations leave out stay clear of the balls, (k,).

        Parameters
        ----------
        flank_displacements
            Displacements of the screw's flanks in the groove's section at each of N balls, (k, 4 N) [m]; the four columns
            of a ball are left flank radial, left flank binormal, right flank radial, right flank binormal.
        ball_centres
            Displacements of the ball centres, radial and binormal, in these sections, (k, N, 2) [m].
        geometry
            Nominal ball position and further data of the contact of each ball with each flank, (k, N, 4, 4 or more), with
            the columns of ``geometry`` in `lowfi.statics.kernel.ball`.
        loads
            Contact loads, (k, N, 4) [N].
        """
        k, n = ball_centres.shape[:2]
        shift = np.zeros((k, n, 4, 2))
        shift[:, :, :2] = flank_displacements.reshape(k, n, 2, 2)
        return solutions_clear_of_left_out_flanks(ball_centres, shift, geometry, loads, self.use, MARGIN)


def _nodal_to_flank_displacement_matrix(problem: statics_problem.Problem, layout: BallLayout, side: int) -> Array:
    """Return the matrix that gives a screw flank's displacements at each ball from all nodal displacements, (N, 2, 6 n).

    N: number of balls; n: number of beam nodes; the two rows of a ball are the radial and the binormal component in the
    section of the groove at the ball. ``side``: flank, 0 for SL (left) and 1 for SR (right).
    """
    n, size = layout.z.size, problem.nodes.size * 6
    out = np.zeros((n, 2, size))
    if problem.used_flanks[side] or problem.rigid_motion_basis is not None:
        columns = 6 * problem.first_nodes[:, side, None] + np.arange(problem.B.shape[3])
        out[np.arange(n)[:, None, None], np.arange(2)[None, :, None], columns[:, None, :]] = problem.B[:, side]
        return out
    centre = nominal_groove_centres(problem.scene)[side]
    r = layout.centre + centre[0] * layout.radial + centre[1] * layout.binormal
    r[:, 2] -= layout.z
    axes = np.stack([layout.radial, layout.binormal], axis=1)
    rows = np.concatenate([axes, np.cross(r[:, None, :], axes)], axis=2)
    first, matrices = beam_interpolation_matrices(layout.z, problem.nodes, problem.section)
    for i, (j, row) in enumerate(zip(first, rows @ matrices, strict=True)):
        out[i, :, 6 * j : 6 * j + 12] = row
    return out


def cached_random_draws_of_scene(cache: SceneResultCache, name: str) -> RandomDrawsResult:
    """Return the contact loads of many random draws of the geometric errors of a built-in scene, computed once per report.

    ``cache``: cache of the report, which states the number of draws; ``name``: name of the scene.
    """
    return cache.compute_once(_solve_random_draws_of_scene, name)


def _solve_random_draws_of_scene(cache: SceneResultCache, name: str) -> RandomDrawsResult:
    """Solve many random draws of the geometric errors of the built-in scene ``name``; ``cache`` states how many."""
    return solve_random_draws(cache.built_in_scene(name), cache.random_draw_count)


#: Outputs of each specimen of one nut or bearing: name of the output, and its heading in tables.
KEPT = {
    "largest_load_N": "largest contact load / N",
    "mean_load_N": "mean contact load / N",
    "load_stiffness_N_per_um": "stiffness at the loads / (N/um)",
    "lost_contacts": "contacts that carry load only without random errors",
    "relative_life": "ratio of the life to that without random errors",
    "residual": "relative residual",
}

#: Outputs of each specimen of a shaft with several nuts and bearings: for the whole shaft.
WHOLE = {
    "largest_load_N": "largest load of a contact or roller / N",
    "tangent_N_per_um": "tangent rigidity along the axis / (N/um)",
    "lost_contacts": "contacts that carry load only without random errors",
    "residual": "relative residual",
}

#: Outputs of each specimen of a shaft: for each nut or bearing.
OF_SET = {
    "largest_load_N": "largest load / N",
    "mean_load_N": "mean of the loads above 1 % of the largest / N",
    "axial_force_N": "axial force on the shaft / N",
    "lost_contacts": "contacts that carry load only without random errors",
    "relative_life": "ratio of the life to that without random errors",
}


#: Exponents of ISO/TS 16281: of the load for a raceway that turns relative to the load and for one at rest, and of the life
#: of all raceways together.
TURNING, STANDING, SYSTEM = 3.0, 10.0 / 3.0, 10.0 / 9.0

#: Relative change of the loads between the two solutions from which the stiffness is computed.
STEP = 1e-3

#: Models with elastic bodies, whose specimens may share one system of equations.
ELASTIC = tuple(name for name in LADDER if name != "lin")


@dataclass(frozen=True)
class RandomDrawBlock:
    """Results of a scene with N balls for k random draws of its geometric errors (specimens), solved in one block."""

    #: Contact loads of the N balls on the four flanks (screw left, screw right, nut left, nut right), (k, N, 4) [N].
    loads: Array
    #: Outputs of each specimen in the order of `output_names_of_draw`, (k, number of outputs).
    outputs: Array
    #: Status of the solution of each specimen.
    statuses: tuple[str, ...]


def raceway_life_measure(load: Array) -> Array:
    """Return L^(-10/9) up to a constant factor, where L is the life of all raceways together by ISO/TS 16281.

    ``load``: contact loads (..., N, 4) [N] of N balls on the flanks SL, SR, NL, NR (screw left and right, nut left and
    right). The screw's raceways turn relative to the load (cubic mean over the balls), the nut's do not (mean with the
    power 10/3). All raceways are assumed to have the same dynamic load rating, and all positions of the balls to be equally
    frequent.
    """
    turning = (load[..., :2] ** TURNING).mean(axis=-2) ** (SYSTEM * 3.0 / TURNING)
    standing = (load[..., 2:] ** STANDING).mean(axis=-2) ** (SYSTEM * 3.0 / STANDING)
    return np.asarray(turning.sum(axis=-1) + standing.sum(axis=-1))


def relative_life(load: Array, loads_without_errors: Array) -> Array:
    """Return the ratio of the rating life with random geometric errors to the life without them, for each random draw.

    ``load``: contact loads with random errors (..., N, 4) [N] of N balls; ``loads_without_errors``: contact loads without
    random errors (N, 4) [N].
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray((raceway_life_measure(load) / raceway_life_measure(loads_without_errors)) ** (-1.0 / SYSTEM))


def output_names_of_draw(scene: Scene | Assembly) -> list[str]:
    """Return the names of the outputs that are stored for each random draw of a scene, such as the largest contact load."""
    if isinstance(scene, Scene):
        return [*KEPT]
    return [*WHOLE, *(f"set {i + 1} {key}" for i in range(len(scene.sets)) for key in OF_SET)]


def ball_slices(scene: Scene | Assembly) -> tuple[slice | None, ...]:
    """Return the index range of each nut's or bearing's balls in arrays over all balls of a scene; None for rollers."""
    if isinstance(scene, Scene):
        return (slice(0, scene.ball_count),)
    slices: list[slice | None] = []
    first = 0
    for s in scene.sets:
        count = s.parts.ball_count if isinstance(s.parts, Scene) else 0
        slices.append(slice(first, first + count) if count else None)
        first += count
    return tuple(slices)


def _change_parts_of_nuts_and_bearings(scene: Scene | Assembly, change: Callable[[Scene, int], Scene]) -> Scene | Assembly:
    """Return a copy of a scene in which a function changes the geometry of each nut or ball bearing.

    ``change``: function that takes the geometry and the number of the nut or bearing from 0, and returns the changed
    geometry.
    """
    if isinstance(scene, Scene):
        return change(scene, 0)
    sets = (replace(s, parts=change(s.parts, i)) if isinstance(s.parts, Scene) else s for i, s in enumerate(scene.sets))
    return replace(scene, sets=tuple(sets))


def with_error_seed(scene: Scene | Assembly, seed: int) -> Scene | Assembly:
    """Return a copy of a scene with another seed of its random errors; several nuts and bearings get consecutive seeds."""
    return _change_parts_of_nuts_and_bearings(
        scene, lambda parts, i: replace(parts, errors=replace(parts.errors, seed=seed + i))
    )


def without_random_errors(scene: Scene | Assembly) -> Scene | Assembly:
    """Return a copy of a scene without random geometric errors; fixed errors stay."""
    return _change_parts_of_nuts_and_bearings(scene, lambda parts, _: errors.scene_without_random_errors(parts))


def _solve_draws_under_scaled_loads(
    scene: Scene, model: str, engine: str, first: int, count: int, load_factor: float = 1.0
) -> tuple[Array, tuple[str, ...], Array, Array]:
    """Solve many random draws of the geometric errors of a nut or bearing under the scene's loads times a factor.

    ``engine``: whether numerical kernels run as plain Python ("interpreted") or as machine code ("compiled"); ``first``:
    number of the first draw; ``count``: number k of draws; ``load_factor``: factor on the loads. Returns contact
    loads (k, N, 4) [N] for N balls, statuses, relative residuals (k,), and works done by the loads (k,) [J], in this order.
    If the factor is not 1, a model with elastic bodies first solves with the factor 1, as a starting point.
    """
    of, scene = scene, with_scaled_loads(scene, load_factor) if load_factor != 1.0 else scene
    if model == "lin" and engine == "compiled":
        batch = solve_random_draws(scene, count, first)
        return batch.loads, batch.statuses, batch.residuals, batch.works_of_loads
    loads, residuals, works = np.full((count, scene.ball_count, 4), np.nan), np.full(count, np.nan), np.full(count, np.nan)
    if model in ELASTIC and can_share_equations(scene):
        loads, residuals, works = _equations_shared_by_draws(of, model, engine, load_factor).solve(first, count)
    statuses = ["converged"] * count
    for k in np.flatnonzero(np.isnan(residuals)):
        result = run_model(scene, model, ModelOptions(member=first + int(k), engine=engine, estimate_beam_mesh_error=False))
        statuses[k], residuals[k] = result.status, result.solver.residual
        if result.converged:
            loads[k], works[k] = result.load, work_done_by_loads(scene, result)
    return loads, tuple(statuses), residuals, works


@lru_cache(maxsize=4)
def _equations_shared_by_draws(scene: Scene, model: str, engine: str, load_factor: float) -> SpecimensWithSharedEquations:
    """Return the system of equations that all random draws of a scene's errors share; it is computed once in a process.

    ``engine``: whether numerical kernels run as plain Python ("interpreted") or as machine code ("compiled");
    ``load_factor``: factor on the loads of the scene.
    """
    like = None if load_factor == 1.0 else _equations_shared_by_draws(scene, model, engine, 1.0)
    loaded = scene if like is None else with_scaled_loads(scene, load_factor)
    return SpecimensWithSharedEquations(
        loaded, LADDER[model], load_kernel_package(STATICS, compiled=engine == "compiled"), like
    )


def solve_block_of_random_draws(
    scene: Scene | Assembly, model: str, engine: str, loads_without_errors: Array, first: int, count: int
) -> RandomDrawBlock:
    """Solve ``count`` random draws of a scene's geometric errors (specimens), from number ``first`` on.

    Parameters
    ----------
    scene
        Scene of one nut or bearing, or of a shaft with several.
    model
        Name of the model.
    engine
        How numerical kernels run: "interpreted" (plain Python) or "compiled" (machine code).
    loads_without_errors
        Contact loads of all N balls without random errors, (N, 4) [N].
    first
        Number of the first specimen.
    count
        Number of specimens.

    Returns
    -------
    RandomDrawBlock
        Contact loads and outputs.
    """
    if isinstance(scene, Assembly):
        return _solve_shaft_block_of_draws(scene, model, engine, loads_without_errors, first, count)
    loads, statuses, residuals, works = _solve_draws_under_scaled_loads(scene, model, engine, first, count)
    force = float(sum(np.dot(x.force, x.force) for x in scene.loads))
    stiffness = np.full(count, np.nan)
    if force > 0.0:
        asked = scene.ingredients.load_step if model == "liu" else None
        step = STEP if asked is None else asked / force**0.5
        heavier = _solve_draws_under_scaled_loads(scene, model, engine, first, count, 1.0 + step)[3] / (1.0 + step)
        with np.errstate(divide="ignore", invalid="ignore"):
            stiffness = 1e-6 * force * step / (heavier - works)
    good = np.array([s == "converged" for s in statuses])
    loads[~good] = np.nan
    contacts = count_nominal_contacts(scene)
    mean = np.array([mean_load(load, contacts) for load in loads])
    lost = (~(loads > 0.0) & (loads_without_errors > 0.0)).sum(axis=(1, 2)).astype(float)
    life = relative_life(loads, loads_without_errors)
    kept = np.column_stack([loads.max(axis=(1, 2)), mean, stiffness, lost, life, residuals])
    kept[~good] = np.nan
    return RandomDrawBlock(loads, kept, statuses)


def _solve_shaft_block_of_draws(
    assembly: Assembly, model: str, kernels: str, loads_without_errors: Array, first: int, count: int
) -> RandomDrawBlock:
    """Solve several random draws of the geometric errors of a shaft with several nuts and bearings.

    ``kernels``: whether numerical kernels run as plain Python ("interpreted") or as machine code ("compiled"); the other
    arguments are those of `solve_block_of_random_draws`.
    """
    results = [run_model(assembly, model, ModelOptions(engine=kernels, member=m)) for m in range(first, first + count)]
    where = ball_slices(assembly)
    loads = np.full((count, *loads_without_errors.shape), np.nan)
    kept = np.full((count, len(output_names_of_draw(assembly))), np.nan)
    for k, result in enumerate(results):
        if result.converged:
            loads[k] = contact_loads_of_all_balls(result)
            kept[k] = outputs_of_shaft_draw(result, loads_without_errors, where)
    return RandomDrawBlock(loads, kept, tuple(r.status for r in results))


def contact_loads_of_all_balls(result: StaticSolution) -> Array:
    """Return the contact loads of all N balls of a static result, (N, 4) [N], on the flanks SL, SR, NL, NR.

    The flanks are those of screw left and right, nut left and right. Balls of several nuts and bearings come one nut or
    bearing after the other.
    """
    return np.concatenate([b.load for b in result.ball_results()])


def outputs_of_shaft_draw(result: AxisResult, loads_without_errors: Array, ball_slices: Sequence[slice | None]) -> Array:
    """Return the outputs of one random draw of a shaft in the order of `output_names_of_draw`.

    An output that does not exist is nan.

    ``result``: static result of the draw; ``loads_without_errors``: contact loads of all N balls without random errors, (N,
    4) [N]; ``ball_slices``: range of the balls of each nut or bearing, from `ball_slices`.
    """
    loads = contact_loads_of_all_balls(result)
    lost = (loads == 0.0) & (loads_without_errors > 0.0)
    largest = max(float(s.loads.max(initial=0.0)) for s in result.sets)
    stiffness = np.nan if result.stiffness is None else 1e-6 * float(result.stiffness[2, 2])
    kept = [largest, stiffness, float(lost.sum()), result.solver.residual]
    for s, place in zip(result.sets, ball_slices, strict=True):
        kept += [float(s.loads.max(initial=0.0)), mean_load(s.loads), float(s.force[2])]
        if place is None:
            kept += [np.nan] * 2
        else:
            kept += [float(lost[place].sum()), float(relative_life(loads[place], loads_without_errors[place]))]
    return np.array(kept)
