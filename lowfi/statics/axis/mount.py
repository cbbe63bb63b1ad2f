"""Preload that is prescribed as a force: search for the axial shift of each outer ring or nut that produces it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from rollbench.lowfi.hertz import contact_approach
from rollbench.lowfi.rollers import tapered_bearing_of_row
from rollbench.lowfi.statics.contacts import hertz_without_errors
from rollbench.lowfi.statics.result import AxisResult, Status
from rollbench.lowfi.statics.settle import ACCEPTED
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, Housing, Joint, RollerRow, RollingSet, diagonal_stiffness
from rollbench.meshes.parts import FREEDOMS

#: Largest number of Newton steps in the search for the axial shifts.
STEPS = 12
#: Step of the axial shifts in the difference quotients that approximate the Jacobian matrix (logarithms of the preload
#: forces by the shifts), relative to the shift that gives the preload.
DIFFERENCE = 1e-3
#: Singular values of the Jacobian matrix below this share of the largest are noise: forces are accurate to ``ACCEPTED``,
#: hence difference quotients of their logarithms over ``DIFFERENCE`` to this. If two nuts press against each other, their
#: preload is one and the same force, and the matrix has one singular value only.
NOISE = ACCEPTED / DIFFERENCE
#: Relative error of a preload above which it is reported, and above which the search has failed.
TOLD, FAILED = 1e-8, 1e-4
#: Stiffness [N/m, N m] of springs that join an outer ring or nut to a moving housing in all motions except the axial one.
TIED = diagonal_stiffness((1e12, 1e12, 0.0, 1e9, 1e9, 1e9))


@dataclass(frozen=True)
class PreloadShifts:
    """Axial shifts of outer rings and nuts that press them onto their rolling elements with the prescribed preloads."""

    #: Axial shifts [m]; empty if there is no equilibrium.
    shifts: tuple[float, ...]
    #: Notes for the report.
    notes: tuple[str, ...] = ()
    #: Kind, reason and cause of the status of preloads that are not reached; empty if they are.
    failure: tuple[str, ...] = ()


def replace_preload_forces_by_offsets(
    assembly: Assembly, find_shifts: Callable[[Assembly], PreloadShifts]
) -> tuple[Assembly, tuple[str, ...], Status | None]:
    """Replace the preload forces of an assembly by axial offsets of outer rings and nuts that produce them.

    At these offsets each preloaded bearing or nut carries its preload force, without external loads and before thermal
    expansion.

    Parameters
    ----------
    assembly
        Shaft with bearings and ball nuts.
    find_shifts
        Function that finds the offsets for an assembly without loads and without thermal expansion.

    Returns
    -------
    tuple[Assembly, tuple[str, ...], Status | None]
        The assembly with offsets in place of preload forces; notes for the report; and None, or a status with the reason if
        the preloads are not reached. Without preload forces the assembly is returned unchanged, without notes.
    """
    numbers = _sets_with_preload_force(assembly)
    if not numbers:
        return assembly, (), None
    idle = tuple(replace(h, force=(0.0, 0.0, 0.0), moment=(0.0, 0.0, 0.0)) for h in assembly.housings)
    bare = replace(assembly, loads=(), housings=idle, thermal_strain=0.0)
    found = find_shifts(bare)
    failure: Any = found.failure
    mounted = _with_offsets_for_preload_forces(assembly, numbers, np.array(found.shifts)) if found.shifts else assembly
    return mounted, found.notes, Status(*failure) if failure else None


def _sets_with_preload_force(assembly: Assembly) -> list[int]:
    """Return the indices of the assembly's bearings and nuts whose preload is prescribed as a force."""
    return [i for i, s in enumerate(assembly.sets) if s.preload > 0.0]


def find_axial_preload_shifts(bare: Assembly, solve: Callable[[Assembly], AxisResult]) -> PreloadShifts:
    """Find the axial shifts [m] of outer rings and nuts that press them onto their balls with the prescribed preloads.

    First the outer rings and nuts are free to slide along the axis and are pushed by their preload forces. As the energy is
    convex also in their positions, they come to rest where the preloads are reached, or the solution proves that there is
    no equilibrium. In this solution a ring or nut on a moving housing is joined to it by stiff springs instead of rigidly;
    Newton's method on the logarithms of the forces corrects the shifts for that.

    Parameters
    ----------
    bare
        Assembly without loads and without thermal expansion.
    solve
        Function that solves an assembly.
    """
    numbers = _sets_with_preload_force(bare)
    goal = np.log([bare.sets[i].preload for i in numbers])

    def log_force_ratios(shift: Array) -> Array:
        """Return log(computed/prescribed preload force) for each outer ring or nut; nan for one that carries no force.

        ``shift``: axial shifts of the outer rings and nuts [m].
        """
        result = solve(_with_offsets_for_preload_forces(bare, numbers, shift))
        forces = np.array([abs(result.sets[i].force[2]) for i in numbers]) if result.converged else np.zeros(len(numbers))
        return np.asarray(np.log(np.where(forces > 0.0, forces, np.nan)) - goal)

    shift, status = _shifts_of_sliding_parts(bare, numbers, solve)
    if shift is None:
        why = f"preloads by force are not met at mounting: {status.reason}"
        return PreloadShifts((), (), (status.kind, why, "mounting"))
    value = log_force_ratios(shift)
    steps, slope = np.diag([DIFFERENCE * preload_shift_of_rigid_parts(bare.sets[i]) for i in numbers]), np.zeros((0, 0))
    for _ in range(STEPS):
        worst = float(np.abs(value).max())
        if not worst > ACCEPTED:
            break
        if not slope.size:
            slope = np.column_stack([(log_force_ratios(shift + e) - value) / e.sum() for e in steps])
        if not np.isfinite(slope).all():
            break
        move = np.linalg.lstsq(slope, -value, rcond=NOISE)[0]
        new = log_force_ratios(shift + move)
        if not float(np.abs(new).max()) < worst:
            break  # the forces are not more accurate than this
        shift, value = shift + move, new
    words = ", ".join(f"{bare.sets[i].name} {1e6 * d:.5g} um" for i, d in zip(numbers, shift, strict=True))
    note = f"preload by force: before loading, outer rings or nuts are pressed against the rolling elements by {words}"
    worst = float(np.abs(value).max())
    if not worst < TOLD:
        note += f"; the preload forces differ from the required ones by up to {100.0 * worst:.1e} %"
    reason = f"preload forces differ from the required ones by {100.0 * worst:.2g} % at the axial shifts {words}"
    return PreloadShifts(tuple(map(float, shift)), (note,), () if worst < FAILED else ("not converged", reason))


def _shifts_of_sliding_parts(
    unloaded: Assembly, numbers: Sequence[int], solve: Callable[[Assembly], AxisResult]
) -> tuple[Array | None, Status]:
    """Return the axial shifts [m] of outer rings and nuts that can slide along the axis, pushed by their preload forces.

    Parameters
    ----------
    unloaded
        Assembly without loads and thermal expansion.
    numbers
        Indices of the preloaded bearings and nuts.
    solve
        Function that solves an assembly.

    Returns
    -------
    tuple[Array | None, Status]
        Shifts towards the rolling elements, None if there is no equilibrium; and the status of the solution.
    """
    sets, joints, bodies = list(unloaded.sets), list(unloaded.joints), {h.name: h for h in unloaded.housings}
    seats: list[tuple[str, str | None, float]] = []
    for i in numbers:
        rolling = sets[i]
        push, seat = -rolling.preload if rolling.thrust == "+z" else rolling.preload, f"outer part of {rolling.name}"
        sliding = tuple((f, 0.0) for f in FREEDOMS if f != "uz")
        on = None if rolling.housing is None or bodies[rolling.housing].is_fixed else bodies[rolling.housing]
        if on is not None:
            sliding = ()
            joints.append(Joint(seat, on.name, rolling.position, TIED))
            bodies[on.name] = replace(on, force=(0.0, 0.0, on.force[2] - push))
        bodies[seat] = Housing(seat, rolling.position, sliding, None, (0.0, 0.0, push))
        sets[i] = replace(rolling, housing=seat, preload=0.0)
        seats.append((seat, None if on is None else on.name, np.sign(push)))
    result = solve(replace(unloaded, sets=tuple(sets), joints=tuple(joints), housings=tuple(bodies.values())))
    if not result.converged:
        return None, result.status
    moved = {h.name: float(h.motion[2]) for h in result.housings}
    return np.array([way * (moved[seat] - (moved[on] if on else 0.0)) for seat, on, way in seats]), result.status


def preload_shift_of_rigid_parts(rolling: RollingSet) -> float:
    """Return the axial shift [m] of the outer ring or nut that gives a bearing or nut its preload force, with rigid bodies.

    ``rolling``: bearing or nut whose preload is prescribed as a force.
    """
    if isinstance(rolling.parts, RollerRow):
        bearing = tapered_bearing_of_row(rolling.parts)
        sin = float(np.sin(bearing.cup_angle))
        return float(bearing.approach_law().approach(rolling.preload / (bearing.rollers * bearing.length * sin))) / sin
    sin, C = float(np.sin(rolling.parts.track.contact_angle)), hertz_without_errors(rolling.parts).C
    return float(contact_approach(rolling.preload / (rolling.parts.ball_count * sin), C[0] + C[3])) / sin


def _with_offsets_for_preload_forces(assembly: Assembly, numbers: Sequence[int], shift: Array) -> Assembly:
    """Return the assembly with axial offsets of outer rings and nuts in place of their preload forces.

    Parameters
    ----------
    assembly
        Shaft with bearings and ball nuts.
    numbers
        Indices of the preloaded bearings and nuts.
    shift
        Axial shifts [m] of their outer rings or nuts towards the rolling elements.
    """
    sets = list(assembly.sets)
    for i, x in zip(numbers, shift, strict=True):
        away = -float(x) if sets[i].thrust == "+z" else float(x)
        sets[i] = replace(sets[i], offset=sets[i].offset + away, preload=0.0)
    return replace(assembly, sets=tuple(sets))
