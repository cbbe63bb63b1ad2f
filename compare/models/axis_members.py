"""Many specimens of a shaft with several rolling sets, each set with random errors of its own: as `compare.models.members`.

Of the whole: largest load, tangent stiffness along the axis where it is asked for, contacts lost. Of each set: largest and
mean load, force along the axis on the shaft, contacts lost, life. Rollers draw no errors, but feel those of the balls.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np
from threadpoolctl import threadpool_limits

from rollbench.comparison.errors import InputError
from rollbench.comparison.models.members import COMPILE_FROM, SYSTEM, Bands, Block, check_count, gathered, life_sum
from rollbench.comparison.models.registry import Options, default_model, random_errors, run_model
from rollbench.comparison.reference.jobs import Engine
from rollbench.lowfi.statics.result import AxisResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, RollingSet
from rollbench.meshes.errors import without_draws
from rollbench.meshes.loads import mean_load
from rollbench.meshes.parts import Scene

#: What is kept of each member, of the whole and of each set: key and heading.
WHOLE = {
    "largest_load_N": "largest load of a contact or roller / N",
    "stiffness_N_per_um": "tangent stiffness along the axis / (N/um)",
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


@dataclass(frozen=True)
class AxisMembers:
    """Members of an assembly. kept (M, 4 + 5 S): numbers of the whole, then of each of S sets; statuses of those that did
    not converge, by number; bands: of the contacts of all sets of balls, one set after the other; balls: the place of each
    set in them, None for rollers; seconds of wall clock."""

    assembly: Assembly
    model: str
    kept: Array
    failed: dict[int, str]
    bands: Bands
    balls: tuple[slice | None, ...]
    seconds: float


def columns(assembly: Assembly) -> list[str]:
    """Names of the numbers of a member."""
    return [*WHOLE, *(f"set {i + 1} {key}" for i in range(len(assembly.sets)) for key in OF_SET)]


def places(assembly: Assembly) -> tuple[slice | None, ...]:
    """Place of each set's balls among those of all sets."""
    found: list[slice | None] = []
    first = 0
    for s in assembly.sets:
        count = s.parts.ball_count if isinstance(s.parts, Scene) else 0
        found.append(slice(first, first + count) if count else None)
        first += count
    return tuple(found)


def with_seed(assembly: Assembly, seed: int) -> Assembly:
    """The assembly with seeds that count on from one, set by set."""

    def own(i: int, s: RollingSet) -> RollingSet:
        if not isinstance(s.parts, Scene):
            return s
        return replace(s, parts=replace(s.parts, errors=replace(s.parts.errors, seed=seed + i)))

    return replace(assembly, sets=tuple(own(i, s) for i, s in enumerate(assembly.sets)))


def solve_block(assembly: Assembly, model: str, kernels: str, nominal: Array, first: int, count: int) -> Block:
    """Members ``first`` and on; nominal: loads (N, 4) [N] of all balls without random errors."""
    with threadpool_limits(1, "blas"):
        results = [run_model(assembly, model, Options(engine=kernels, member=m)) for m in range(first, first + count)]
    where = places(assembly)
    loads = np.stack([contact_loads(r) if r.converged else np.full(nominal.shape, np.nan) for r in results])
    wide = len(columns(assembly))
    kept = [numbers(r, nominal, where) if r.converged else np.full(wide, np.nan) for r in results]
    return Block(loads, np.array(kept), tuple(r.status for r in results))


def contact_loads(result: AxisResult) -> Array:
    """Loads (N, 4) [N] of the balls of all sets."""
    return np.concatenate([s.balls.load for s in result.sets if s.balls is not None])


def numbers(result: AxisResult, nominal: Array, where: Sequence[slice | None]) -> Array:
    """What is kept of a member."""
    loads = contact_loads(result)
    lost = (loads == 0.0) & (nominal > 0.0)
    largest = max(float(s.loads.max(initial=0.0)) for s in result.sets)
    stiffness = np.nan if result.stiffness is None else 1e-6 * float(result.stiffness[2, 2])
    found = [largest, stiffness, float(lost.sum()), result.solver.residual]
    for s, place in zip(result.sets, where, strict=True):
        own = s.loads
        mean = mean_load(own)
        found += [float(own.max(initial=0.0)), mean, float(s.force[2])]
        if place is None:
            found += [np.nan, np.nan]
            continue
        with np.errstate(divide="ignore", invalid="ignore"):
            life = (life_sum(loads[place]) / life_sum(nominal[place])) ** (-1.0 / SYSTEM)
        found += [float(lost[place].sum()), float(life)]
    return np.array(found)


def run_axis_members(
    assembly: Assembly,
    model: str,
    count: int,
    engine: Engine | None = None,
    step: Callable[[str], None] = lambda _: None,
    row: Callable[[int, str, Array], None] = lambda *_: None,
) -> AxisMembers:
    """Solve members 0 to ``count`` - 1; arguments and InputErrors as `compare.models.members.run_members`."""
    model = model or default_model(assembly)
    check_count(count)
    if not random_errors(assembly):
        advice = "give a sigma to balls, pitch, roundness or profile of a set"
        raise InputError(assembly.name, "sets[].errors", "nothing random", "at least one sigma above zero", advice)
    start = perf_counter()
    kernels = "compiled" if count >= COMPILE_FROM else "interpreted"
    sets = (replace(s, parts=without_draws(s.parts)) if isinstance(s.parts, Scene) else s for s in assembly.sets)
    bare = run_model(replace(assembly, sets=tuple(sets)), model)
    if not bare.converged or not contact_loads(bare).max(initial=0.0) > 0.0:
        reason = bare.status if not bare.converged else "no contact carries load without random errors"
        allowed = "loaded contacts without random errors"
        raise InputError(assembly.name, "scene", reason, allowed, "load or preload the sets")
    nominal = contact_loads(bare)
    arguments = (assembly, model, kernels, nominal)
    bands, kept, failed = gathered(solve_block, arguments, nominal, count, engine or Engine(), step, row)
    return AxisMembers(assembly, model, kept, failed, bands, places(assembly), perf_counter() - start)
