"""Preload by a force at mounting: the shift of each outer part that brings it about."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from rollbench.lowfi.statics.axis.system import tapered
from rollbench.lowfi.statics.problem import nominal_hertz
from rollbench.lowfi.statics.result import AxisResult
from rollbench.lowfi.statics.static import ACCEPTED
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, RollerRow, RollingSet

#: Relative error of a preload that is enough, and steps that are tried.
ERROR, STEPS = 1e-12, 60
#: Step of the differences that make the slope, in logarithms: an e-th part of a depth.
DIFFERENCE = 1e-3
#: Part of the slope's largest singular value below which a direction is noise: forces are known to ``ACCEPTED``, so that
#: differences of their logarithms over ``DIFFERENCE`` are known to this. Nuts that press one another carry one force: the
#: slope then has no other direction, and the depths stay as far apart as they began.
NOISE = ACCEPTED / DIFFERENCE
#: Relative errors of a preload that are told, and that are a failure.
TOLD, FAILED = 1e-8, 1e-4


def mount(assembly: Assembly, solve: Callable[[Assembly], AxisResult]) -> tuple[Assembly, tuple[str, ...], str]:
    """The assembly with its preloads by force as offsets: those at which each such set carries its force, without loads
    and before the shaft warms.

    Newton's method on the axial forces of these sets by their offsets, logarithms of both: a law of a power is a line. The
    slope follows the secants of moves that are longer than the differences it began with: shorter ones hold more noise.
    Returns the assembly, notes, and words for preloads that are not met (else empty).
    """
    which = [i for i, s in enumerate(assembly.sets) if s.preload > 0.0]
    if not which:
        return assembly, (), ""
    idle = tuple(replace(h, force=(0.0, 0.0, 0.0), moment=(0.0, 0.0, 0.0)) for h in assembly.housings)
    bare = replace(assembly, loads=(), housings=idle, thermal_strain=0.0)
    goal = np.log([assembly.sets[i].preload for i in which])

    def excess(depth: Array) -> Array:
        found = solve(_shifted(bare, which, np.exp(depth)))
        forces = np.array([abs(found.sets[i].force[2]) for i in which]) if found.converged else np.zeros(len(which))
        return np.asarray(np.log(np.where(forces > 0.0, forces, np.nan)) - goal)

    depth = np.log([2.0 * closing(assembly.sets[i]) for i in which])
    value = excess(depth)
    slope = np.column_stack([(excess(depth + DIFFERENCE * e) - value) / DIFFERENCE for e in np.eye(len(which))])
    for _ in range(STEPS):
        if not np.isfinite(value).all() or not np.isfinite(slope).all():
            break
        worst = float(np.abs(value).max())
        if worst <= ERROR:
            break
        move = np.clip(np.linalg.lstsq(slope, -value, rcond=NOISE)[0], -1.0, 1.0)
        new = excess(depth + move)
        if worst < ACCEPTED and not float(np.abs(new).max()) < worst:
            break  # the forces are not known any better
        if float(np.abs(move).max()) > DIFFERENCE:
            slope = slope + np.outer(new - value - slope @ move, move) / float(move @ move)
        depth, value = depth + move, new
    shift = np.exp(depth)
    words = ", ".join(f"{assembly.sets[i].name} {1e6 * d:.5g} um" for i, d in zip(which, shift, strict=True))
    note = f"preload by force: before loading, outer parts are moved against their rows by {words}"
    worst = float(np.abs(value).max())
    if not worst < TOLD:
        note += f"; the forces are off by {100.0 * worst:.1e} %"
    failed = "" if worst < FAILED else f"preloads by force are not met, off by {100.0 * worst:.2g} %: {words}"
    return _shifted(assembly, which, shift), (note,), failed


def closing(one: RollingSet) -> float:
    """Shift [m] that closes a row to its preload, all else rigid."""
    if isinstance(one.parts, RollerRow):
        bearing = tapered(one.parts)
        sin = float(np.sin(bearing.cup_angle))
        return float(bearing.law().approach(one.preload / (bearing.rollers * bearing.length * sin))) / sin
    sin, C = float(np.sin(one.parts.track.contact_angle)), nominal_hertz(one.parts).C
    return float((C[0] + C[3]) * np.cbrt(one.preload / (one.parts.ball_count * sin)) ** 2) / sin


def _shifted(assembly: Assembly, which: Sequence[int], shift: Array) -> Assembly:
    """The assembly with some rows closed by shifts [m] of their outer parts, in place of their preloads."""
    sets = list(assembly.sets)
    for i, x in zip(which, shift, strict=True):
        away = -float(x) if sets[i].thrust == "+z" else float(x)
        sets[i] = replace(sets[i], offset=sets[i].offset + away, preload=0.0)
    return replace(assembly, sets=tuple(sets))
