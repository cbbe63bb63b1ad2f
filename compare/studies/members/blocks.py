"""Specimens of a scene with random errors solved in blocks, and what is kept of each.

Several sets draw errors of their own. Of the whole: largest load, tangent rigidity along the axis where it is asked for,
contacts lost. Of each set: largest and mean load, force along the axis on the shaft, contacts lost, life. Rollers draw no
errors, but feel those of the balls.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from rollbench.compare.models.loading import scaled
from rollbench.compare.models.registry import Options, run_model
from rollbench.compare.studies.members.ensemble import run_ensemble, work_of
from rollbench.lowfi.compliance.parts import LADDER
from rollbench.lowfi.jit import STATICS, kernels
from rollbench.lowfi.statics.elastic import ElasticMembers, shared
from rollbench.lowfi.statics.nominal import nominal_contacts
from rollbench.lowfi.statics.result import AxisResult, Solved
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.errors import without_draws
from rollbench.meshes.loads import mean_load
from rollbench.meshes.parts import Scene

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
        heavier = _solved(scene, model, engine, first, count, 1.0 + STEP)[3] / (1.0 + STEP)
        with np.errstate(divide="ignore", invalid="ignore"):
            stiffness = 1e-6 * force * STEP / (heavier - works)
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
