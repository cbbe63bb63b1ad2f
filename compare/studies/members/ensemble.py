"""Contact loads of many specimens of a scene (an ensemble), each with its own random geometric errors, solved in blocks.

Specimens that differ little enough are solved together as members of one system (`lowfi.statics.members`), the others one
by one.

On a shaft with several nuts and ball bearings, these have independent errors. Stored for the whole shaft are the largest
load, the axial tangent rigidity and the number of lost contacts (contacts that carry load only without random errors); for
each nut or bearing, the largest and mean load, the axial force on the shaft, the number of lost contacts and the life.
Rollers have no random errors, but their loads change with the errors of the balls.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from rollbench.compare.measure import mean_load
from rollbench.compare.models.loading import with_scaled_loads
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import model_by_name, run_model
from rollbench.compare.models.stiffness import (
    PROBE,
    SceneStiffness,
    change_of_loads,
    is_axial,
    place_of_displacement,
    ratios,
    stiffness_of_scene,
    with_axial_force,
)
from rollbench.compare.models.study import SceneResultCache
from rollbench.lowfi.compliance.parts import LADDER
from rollbench.lowfi.rating import life
from rollbench.lowfi.rating.displacement import LoadPoint, load_point, motion_at, section_of_nut
from rollbench.lowfi.rating.life import TurningRing
from rollbench.lowfi.rating.rigidity import axial_force
from rollbench.lowfi.statics.members import MemberLoads, SpecimensOfScene, can_share_equations
from rollbench.lowfi.statics.nominal import count_nominal_contacts
from rollbench.lowfi.statics.result import AxisResult, StaticSolution
from rollbench.meshes import errors
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.helix import lead_per_radian
from rollbench.meshes.parts import Scene


@dataclass(frozen=True)
class RandomDrawsResult(MemberLoads):
    """Solutions of a scene for M random draws of its geometric errors (specimens); values are nan without equilibrium."""

    #: Status of the solution of each specimen, as in ``StaticResult``.
    statuses: tuple[str, ...]
    #: Number of specimens that were solved one by one with ``solve_static``, not together.
    singly_solved_count: int

    @property
    def converged(self) -> NDArray[np.bool_]:
        """Whether each of the M random draws has an equilibrium, (M,)."""
        return np.array([s == "converged" for s in self.statuses], dtype=bool)


def solve_random_draws(scene: Scene, members: int | None = None, first: int = 0) -> RandomDrawsResult:
    """Solve many random draws of a scene's geometric errors (specimens) by Lin's model, as `solve_static` would each.

    Parameters
    ----------
    scene
        Scene of one nut or bearing.
    members
        Number of specimens; None: the number that the scene states.
    first
        Number of the first specimen.

    Returns
    -------
    RandomDrawsResult
        Contact loads; ``statuses`` shows which specimens have no solution.
    """
    count, backend = scene.members if members is None else members, LADDER["lin"]
    together = SpecimensOfScene(scene, backend).solve(first, count) if can_share_equations(scene, backend) else None
    return _complete_draws(scene, "lin", first, count, (), together)


def _complete_draws(
    scene: Scene, model: str, first: int, count: int, sections: tuple[float, ...], together: MemberLoads | None
) -> RandomDrawsResult:
    """Solve one by one those random draws that were not solved together.

    ``sections``: axial positions of the screw whose motions are asked for [m]; ``together``: the solutions that share
    equations; None: there are none. Returns the solutions of all draws.
    """
    if together is None:
        shapes = (scene.ball_count, 4), (), (len(sections), 6), ()
        loads, residuals, motions, forces = (np.full((count, *shape), np.nan) for shape in shapes)
        together = MemberLoads(loads, residuals, motions, forces, 0)
    found = together
    statuses, left = ["converged"] * count, np.flatnonzero(np.isnan(found.residuals))
    for k in left:
        result = run_model(scene, model, ModelOptions(member=first + int(k), estimate_beam_mesh_error=False))
        statuses[k], found.residuals[k] = result.status, result.solver.residual
        if result.converged:
            found.loads[k], found.forces[k] = result.load, axial_force(result)
            for i, at in enumerate(sections):
                found.motions[k, i] = motion_at(result, at)
    return RandomDrawsResult(**vars(found), statuses=tuple(statuses), singly_solved_count=int(left.size))


def random_draws_of_built_in_scene(cache: SceneResultCache, name: str) -> RandomDrawsResult:
    """Return the contact loads of many random draws of the geometric errors of the built-in scene ``name``.

    ``cache``: cache of the report, which states the number of draws.
    """
    return solve_random_draws(cache.built_in_scene(name), cache.random_draw_count)


#: Outputs of each specimen of one nut or bearing: name of the output, and its heading in tables.
KEPT = {
    "largest_load_N": "largest contact load / N",
    "mean_load_N": "mean contact load / N",
    "nut_tangent_N_per_um": "axial tangent of the nut or bearing / (N/um)",
    "load_point_tangent_N_per_um": "tangent of the load's point to ground / (N/um)",
    "lost_contacts": "contacts that carry load only without random errors",
    "relative_life": "ratio of the life by the contact loads to that without random errors",
    "residual": "relative residual",
}

#: Outputs of each specimen of a shaft with several nuts and bearings: for the whole shaft.
WHOLE = {
    "largest_load_N": "largest load of a contact or roller / N",
    "nut_tangent_N_per_um": "axial tangent of the nuts, or of the bearings without a nut / (N/um)",
    "load_point_tangent_N_per_um": "tangent of the load's point to ground / (N/um)",
    "lost_contacts": "contacts that carry load only without random errors",
    "residual": "relative residual",
}

#: Outputs of each specimen of a shaft: for each nut or bearing.
OF_SET = {
    "largest_load_N": "largest load / N",
    "mean_load_N": "mean of the loads above 1 % of the largest / N",
    "axial_force_N": "axial force on the shaft / N",
    "lost_contacts": "contacts that carry load only without random errors",
    "relative_life": "ratio of the life by the contact loads to that without random errors",
}


#: Exponent of the life of all raceways together (ISO/TS 16281).
SYSTEM = 10.0 / 9.0


@dataclass(frozen=True)
class RandomDrawBlock:
    """Results of a scene with N balls for k random draws of its geometric errors (specimens), solved in one block."""

    #: Contact loads of the N balls on the four flanks (screw left, screw right, nut left, nut right), (k, N, 4) [N].
    loads: Array
    #: Outputs of each specimen in the order of `output_names_of_draw`, (k, number of outputs).
    outputs: Array
    #: Status of the solution of each specimen.
    statuses: tuple[str, ...]
    #: Wall-clock time of the computation [s].
    seconds: float


def raceway_life_measure(load: Array, turning: TurningRing = "inner") -> Array:
    """Return L^(-10/9) up to a constant factor, where L is the life of all raceways together by ISO/TS 16281.

    ``load``: contact loads (..., N, 4) [N] of N balls on the flanks SL, SR, NL, NR (screw left and right, nut left and
    right). The raceways of the ring ``turning`` (of a screw: "inner") turn relative to the load (cubic mean over the
    balls), the others do not (mean with the power 10/3); nan if both rings stand still. All raceways are assumed to have
    the same dynamic load rating, and all positions of the balls to be equally frequent.
    """
    if turning == "none":
        return np.full(load.shape[:-2], np.nan)
    orders = (life.TURNING, life.STANDING) if turning == "inner" else (life.STANDING, life.TURNING)
    pairs = zip((load[..., :2], load[..., 2:]), orders, strict=True)
    return np.asarray(sum(((Q**p).mean(axis=-2) ** (SYSTEM * 3.0 / p)).sum(axis=-1) for Q, p in pairs))


def relative_life(load: Array, loads_without_errors: Array, turning: TurningRing = "inner") -> Array:
    """Return the ratio of the rating life with random geometric errors to the life without them, for each random draw.

    ``load``: contact loads with random errors (..., N, 4) [N] of N balls; ``loads_without_errors``: contact loads without
    random errors (N, 4) [N]; ``turning``: ring that turns.
    """
    of = raceway_life_measure
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray((of(load, turning) / of(loads_without_errors, turning)) ** (-1.0 / SYSTEM))


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


@dataclass(frozen=True)
class _TangentStep:
    """Change of a scene's loads from which the tangents of its random draws are computed."""

    #: The scene with changed loads.
    changed: Scene
    #: Point on which the load acts, and change of the force along its direction [N].
    point: LoadPoint
    change: float
    #: Axial positions [m] of the section of the nut or bearing, and of the load's point.
    sections: tuple[float, float]


@lru_cache(maxsize=4)
def _tangent_step(scene: Scene, model: str) -> _TangentStep:
    """Return the change of a scene's loads from which the tangents of its random draws are computed.

    It is that of `stiffness_of_scene` without random errors, in one direction; with a model that has its own axial
    stiffness (liu) the load step of the scene, if it has one.
    """
    bare, options = without_random_errors(scene), ModelOptions(estimate_beam_mesh_error=False)
    assert isinstance(bare, Scene), "a scene of one nut or bearing stays one"
    result = run_model(bare, model, options)
    step = change_of_loads(bare, run_model(with_scaled_loads(bare, 0.0), model, options))
    point = load_point(scene)
    if point is None:
        at, change = place_of_displacement(scene), PROBE * float(result.load.sum())
        point, changed = LoadPoint(at, (0.0, 0.0, 1.0), 0.0), with_axial_force(scene, change)
    else:
        asked = scene.ingredients.load_step if model_by_name(model).axial_stiffness else None
        step = step if asked is None else asked / abs(point.force)
        changed, change = with_scaled_loads(scene, 1.0 + step), step * point.force
    assert isinstance(changed, Scene), "a scene of one nut or bearing stays one"
    assert isinstance(point.at, float), "its loads act on the shaft"
    return _TangentStep(changed, point, change, (section_of_nut(scene, result), point.at))


def _solve_draws(scene: Scene, model: str, first: int, count: int, changed: bool) -> RandomDrawsResult:
    """Solve many random draws of the geometric errors of a nut or bearing under its loads, or under changed ones.

    ``first``: number of the first draw; ``count``: number of draws; ``changed``: whether the loads are those of
    `_tangent_step`. Under changed loads the solutions under the scene's are the starting
    points, where draws are solved together.
    """
    step = _tangent_step(scene, model)
    of, together = step.changed if changed else scene, None
    if model in LADDER and can_share_equations(of, LADDER[model]):
        together = _equations_shared_by_draws(scene, model, changed).solve(first, count)
    return _complete_draws(of, model, first, count, step.sections, together)


@lru_cache(maxsize=4)
def _equations_shared_by_draws(scene: Scene, model: str, changed: bool) -> SpecimensOfScene:
    """Return the system of equations that all random draws of a scene's errors share; it is computed once in a process.

    ``changed``: whether the loads are those of `_tangent_step`.
    """
    step, previous = _tangent_step(scene, model), _equations_shared_by_draws(scene, model, False) if changed else None
    return SpecimensOfScene(step.changed if changed else scene, LADDER[model], previous, step.sections)


def _tangents_of_draws(scene: Scene, model: str, before: MemberLoads, after: MemberLoads) -> Array:
    """Return the tangents of the nut and of the load's point of k random draws, (k, 2) [N/um]; nan where there is none.

    ``before``, ``after``: solutions under the scene's loads, and under those of `_tangent_step`.
    """
    step, moved = _tangent_step(scene, model), after.motions - before.motions
    along_nut = moved[:, 0, 2] - lead_per_radian(scene.track) * moved[:, 0, 5]
    along_load = moved[:, 1, :3] @ np.array(step.point.direction)
    forces = after.forces - before.forces
    changes = np.stack([forces, along_nut, np.full(len(forces), step.change), along_load], axis=1).reshape(-1, 2, 2)
    found = np.array([ratios(x) if np.isfinite(x).all() else [None, None] for x in changes], dtype=float)
    if not is_axial(step.point):
        found[:, 0] = np.nan
    return 1e-6 * found


def solve_block_of_random_draws(
    scene: Scene | Assembly, model: str, loads_without_errors: Array, first: int, count: int
) -> RandomDrawBlock:
    """Solve ``count`` random draws of a scene's geometric errors (specimens), from number ``first`` on.

    Parameters
    ----------
    scene
        Scene of one nut or bearing, or of a shaft with several.
    model
        Name of the model.
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
    start = perf_counter()
    if isinstance(scene, Assembly):
        found = _solve_shaft_block_of_draws(scene, model, loads_without_errors, first, count)
        return RandomDrawBlock(*found, perf_counter() - start)
    before = _solve_draws(scene, model, first, count, False)
    tangents = _tangents_of_draws(scene, model, before, _solve_draws(scene, model, first, count, True))
    loads, good = before.loads, before.converged
    loads[~good] = np.nan
    contacts = count_nominal_contacts(scene)
    mean = np.array([mean_load(load, contacts) for load in loads])
    lost = (~(loads > 0.0) & (loads_without_errors > 0.0)).sum(axis=(1, 2)).astype(float)
    lives = relative_life(loads, loads_without_errors, life.turning_ring(scene))
    kept = np.column_stack([loads.max(axis=(1, 2)), mean, tangents, lost, lives, before.residuals])
    kept[~good] = np.nan
    return RandomDrawBlock(loads, kept, before.statuses, perf_counter() - start)


def _solve_shaft_block_of_draws(
    assembly: Assembly, model: str, loads_without_errors: Array, first: int, count: int
) -> tuple[Array, Array, tuple[str, ...]]:
    """Return loads, outputs and statuses of several random draws of a shaft's errors, as in `RandomDrawBlock`.

    The arguments are those of `solve_block_of_random_draws`.
    """
    results = [run_model(assembly, model, ModelOptions(member=m)) for m in range(first, first + count)]
    where = ball_slices(assembly)
    loads = np.full((count, *loads_without_errors.shape), np.nan)
    kept = np.full((count, len(output_names_of_draw(assembly))), np.nan)
    for k, result in enumerate(results):
        if result.converged:
            loads[k] = contact_loads_of_all_balls(result)
            stiffness = stiffness_of_scene(assembly, result, result, model, ModelOptions(member=first + k))
            kept[k] = outputs_of_shaft_draw(assembly, result, stiffness, loads_without_errors, where)
    return loads, kept, tuple(r.status for r in results)


def contact_loads_of_all_balls(result: StaticSolution) -> Array:
    """Return the contact loads of all N balls of a static result, (N, 4) [N], on the flanks SL, SR, NL, NR.

    The flanks are those of screw left and right, nut left and right. Balls of several nuts and bearings come one nut or
    bearing after the other.
    """
    return np.concatenate([b.load for b in result.ball_results()])


def outputs_of_shaft_draw(
    assembly: Assembly,
    result: AxisResult,
    stiffness: SceneStiffness,
    loads_without_errors: Array,
    ball_slices: Sequence[slice | None],
) -> Array:
    """Return the outputs of one random draw of a shaft in the order of `output_names_of_draw`.

    An output that does not exist is nan.

    ``assembly``: the shaft; ``result``: static result of the draw; ``stiffness``: its stiffness;
    ``loads_without_errors``: contact loads of all N balls without random errors, (N, 4) [N]; ``ball_slices``: range of the
    balls of each nut or bearing, from `ball_slices`.
    """
    loads = contact_loads_of_all_balls(result)
    lost = (loads == 0.0) & (loads_without_errors > 0.0)
    largest = max(float(s.loads.max(initial=0.0)) for s in result.sets)
    tangents = (np.nan if x is None else 1e-6 * x for x in (stiffness.nut.tangent, stiffness.load_point.tangent))
    kept = [largest, *tangents, float(lost.sum()), result.solver.residual]
    for s, place in zip(result.sets, ball_slices, strict=True):
        kept += [float(s.loads.max(initial=0.0)), mean_load(s.loads), float(s.force[2])]
        if place is None:
            kept += [np.nan] * 2
        else:
            ring = life.turning_ring(assembly, s.of)
            lives = relative_life(loads[place], loads_without_errors[place], ring)
            kept += [float(lost[place].sum()), float(lives)]
    return np.array(kept)
