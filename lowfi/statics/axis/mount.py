"""Preload by a force at mounting: the shift of each outer part that produces it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial

import numpy as np

from rollbench.lowfi.hertz import contact_approach
from rollbench.lowfi.rollers import tapered_bearing
from rollbench.lowfi.statics.contacts import error_free_hertz
from rollbench.lowfi.statics.result import AxisResult, Status
from rollbench.lowfi.statics.settle import ACCEPTED
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, Housing, Joint, RollerRow, RollingSet, diagonal_stiffness
from rollbench.meshes.parts import FREEDOMS

#: Corrections of the shifts that are tried at most.
STEPS = 12
#: Step of the differences that make the slope, as a part of the shift that closes a row.
DIFFERENCE = 1e-3
#: Part of the slope's largest singular value below which a direction is noise: forces are known to ``ACCEPTED``, so that
#: differences of their logarithms over ``DIFFERENCE`` are known to this. Nuts that press one another carry one force: the
#: slope then has no other direction.
NOISE = ACCEPTED / DIFFERENCE
#: Relative errors of a preload that are reported, and that are a failure.
TOLD, FAILED = 1e-8, 1e-4
#: Springs [N/m, N m] that tie an outer part to a housing that moves, in all but the axis.
TIED = diagonal_stiffness((1e12, 1e12, 0.0, 1e9, 1e9, 1e9))


@dataclass(frozen=True)
class _Mounting:
    """An assembly as mounted, and its solver; ``key`` identifies the solver."""

    bare: Assembly
    key: tuple[object, ...]
    solve: Callable[[Assembly], AxisResult] = field(compare=False)


def mount(assembly: Assembly, solve: partial[AxisResult]) -> tuple[Assembly, tuple[str, ...], Status | None]:
    """Return the assembly with offsets in place of its preloads by force.

    At these offsets each such set carries its force, without loads and before the shaft warms.

    Parameters
    ----------
    assembly
        The assembly.
    solve
        Solves an assembly.

    Returns
    -------
    tuple[Assembly, tuple[str, ...], Status | None]
        The assembly, notes, and a status for preloads that are not reached (else None).
    """
    numbers = _preloaded(assembly)
    if not numbers:
        return assembly, (), None
    idle = tuple(replace(h, force=(0.0, 0.0, 0.0), moment=(0.0, 0.0, 0.0)) for h in assembly.housings)
    bare = replace(assembly, loads=(), housings=idle, thermal_strain=0.0)
    shift, notes, unmet = _shifts(_Mounting(bare, (solve.func, solve.args, *sorted(solve.keywords.items())), solve))
    return assembly if shift is None else _shifted(assembly, numbers, np.array(shift)), notes, unmet


def _preloaded(assembly: Assembly) -> list[int]:
    """Return the indices of the sets that are preloaded by a force."""
    return [i for i, s in enumerate(assembly.sets) if s.preload > 0.0]


@lru_cache(maxsize=4)
def _shifts(mounting: _Mounting) -> tuple[tuple[float, ...] | None, tuple[str, ...], Status | None]:
    """Return the shifts [m] of the sets preloaded by a force against their rows, notes, and a status.

    None for shifts that find no equilibrium; cached for the load cases of an assembly, which all are mounted alike.

    The energy is convex in the shifts too: outer parts that slide along the axis and are pushed by their preloads come to
    rest where these are reached, or at none, which the solution then proves. Where a housing moves, to which they are only
    tied, Newton's method on the logarithms of the forces corrects their shifts. Parts that may be moved all together are
    moved as far one way as the other.
    """
    bare, solve = mounting.bare, mounting.solve
    numbers = _preloaded(bare)
    goal = np.log([bare.sets[i].preload for i in numbers])

    def excess(shift: Array) -> Array:
        result = solve(_shifted(bare, numbers, shift))
        forces = np.array([abs(result.sets[i].force[2]) for i in numbers]) if result.converged else np.zeros(len(numbers))
        return np.asarray(np.log(np.where(forces > 0.0, forces, np.nan)) - goal)

    pushed, status = _pushed(bare, numbers, solve)
    if pushed is None:
        why = f"preloads by force are not met at mounting: {status.reason}"
        return None, (), Status(status.kind, why, "mounting")
    ways = np.array([-1.0 if bare.sets[i].thrust == "+z" else 1.0 for i in numbers])
    shift = pushed - ways * float((ways * pushed).mean())
    value = excess(shift) if len(numbers) > 1 else np.array([np.nan])
    if not float(np.abs(value).max()) < DIFFERENCE:  # the axis is held where it is
        shift = pushed
        value = excess(shift)
    steps, slope = np.diag([DIFFERENCE * closing(bare.sets[i]) for i in numbers]), np.zeros((0, 0))
    for _ in range(STEPS):
        worst = float(np.abs(value).max())
        if not worst > ACCEPTED:
            break
        if not slope.size:
            slope = np.column_stack([(excess(shift + e) - value) / e.sum() for e in steps])
        if not np.isfinite(slope).all():
            break
        move = np.linalg.lstsq(slope, -value, rcond=NOISE)[0]
        new = excess(shift + move)
        if not float(np.abs(new).max()) < worst:
            break  # the forces are not known any better
        shift, value = shift + move, new
    words = ", ".join(f"{bare.sets[i].name} {1e6 * d:.5g} um" for i, d in zip(numbers, shift, strict=True))
    note = f"preload by force: before loading, outer parts are moved against their rows by {words}"
    worst = float(np.abs(value).max())
    if not worst < TOLD:
        note += f"; the forces are off by {100.0 * worst:.1e} %"
    failed = Status("not converged", f"preloads by force are not met, off by {100.0 * worst:.2g} %: {words}")
    return tuple(shift), (note,), None if worst < FAILED else failed


def _pushed(bare: Assembly, numbers: Sequence[int], solve: Callable[[Assembly], AxisResult]) -> tuple[Array | None, Status]:
    """Return the shifts [m] against their rows of outer parts that slide along the axis, pushed by their preloads.

    None where they find no equilibrium, and the status of that solution.
    """
    sets, joints, bodies = list(bare.sets), list(bare.joints), {h.name: h for h in bare.housings}
    seats: list[tuple[str, str | None, float]] = []
    for i in numbers:
        rolling = sets[i]
        push, seat = -rolling.preload if rolling.thrust == "+z" else rolling.preload, f"outer part of {rolling.name}"
        sliding = tuple((f, 0.0) for f in FREEDOMS if f != "uz")
        on = None if rolling.housing is None or bodies[rolling.housing].stands else bodies[rolling.housing]
        if on is not None:
            sliding = ()
            joints.append(Joint(seat, on.name, rolling.position, TIED))
            bodies[on.name] = replace(on, force=(0.0, 0.0, on.force[2] - push))
        bodies[seat] = Housing(seat, rolling.position, sliding, None, (0.0, 0.0, push))
        sets[i] = replace(rolling, housing=seat, preload=0.0)
        seats.append((seat, None if on is None else on.name, np.sign(push)))
    result = solve(replace(bare, sets=tuple(sets), joints=tuple(joints), housings=tuple(bodies.values())))
    if not result.converged:
        return None, result.status
    moved = {h.name: float(h.motion[2]) for h in result.housings}
    return np.array([way * (moved[seat] - (moved[on] if on else 0.0)) for seat, on, way in seats]), result.status


def closing(rolling: RollingSet) -> float:
    """Return the shift [m] that closes a row to its preload, with everything else rigid."""
    if isinstance(rolling.parts, RollerRow):
        bearing = tapered_bearing(rolling.parts)
        sin = float(np.sin(bearing.cup_angle))
        return float(bearing.law().approach(rolling.preload / (bearing.rollers * bearing.length * sin))) / sin
    sin, C = float(np.sin(rolling.parts.track.contact_angle)), error_free_hertz(rolling.parts).C
    return float(contact_approach(rolling.preload / (rolling.parts.ball_count * sin), C[0] + C[3])) / sin


def _shifted(assembly: Assembly, numbers: Sequence[int], shift: Array) -> Assembly:
    """Return the assembly with some rows closed by shifts [m] of their outer parts, in place of their preloads."""
    sets = list(assembly.sets)
    for i, x in zip(numbers, shift, strict=True):
        away = -float(x) if sets[i].thrust == "+z" else float(x)
        sets[i] = replace(sets[i], offset=sets[i].offset + away, preload=0.0)
    return replace(assembly, sets=tuple(sets))
