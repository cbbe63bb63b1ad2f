"""Motor torques and moments of inertia of a feed axis, and the combined life of its nuts and bearings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from rollbench.compare.models.answers import AxisAnswers, RollerAnswers
from rollbench.compare.models.registry import Options
from rollbench.lowfi.bearings.axis import TorqueBudget, acceleration_torque, reflected_inertia, screw_inertia
from rollbench.lowfi.bearings.torque import BallTorque, Band, roller_torque
from rollbench.lowfi.rating import roller_life
from rollbench.lowfi.rating.life import SLOPE, SystemLife, system_life
from rollbench.lowfi.statics.result import AxisResult, SetResult
from rollbench.meshes.axis import Assembly, RollerRow
from rollbench.meshes.parts import Scene
from rollbench.meshes.quantity import quantity, record

#: Default efficiency of a nut that accelerates a mass (Smith 4.3.1: typically 0.90 to 0.95).
EFFICIENCY: Band = (0.90, 0.95)
NOT_RUNNING = "the running torque of a bearing needs the tables [lubricant] and [motion]"
#: For the number (from 0) of each nut: its friction torques and efficiencies as JSON values, or None and the reason why
#: they are not known.
NutSums = Mapping[int, tuple[dict[str, Any] | None, str]]


@record
class SetDrive:
    """Torque of one nut or bearing row on the turning shaft, as (low, high) [N m]; None if not known."""

    name: str = quantity("name", "name of the set")
    running: Band | None = quantity(
        "running_Nmm",
        "torque that turns the shaft in this set, without seals: of a nut what drives it against its load and the friction "
        "of its balls, of a bearing its friction; negative where the load drives",
        parts="[]",
    )
    starting: Band | None = quantity("starting_Nmm", "the same from rest", parts="[]")
    seals: float = quantity("seals_Nmm", "friction torque of its seals and wipers, as given", default=0.0)
    words: str = quantity("words", "why it is not known", show=lambda words: words or None, default="")


@record
class AxisDrive:
    """Torques (low, high) [N m] and moments of inertia [kg m^2] at the motor of a feed axis (Smith 4.10 to 4.15)."""

    sets: tuple[SetDrive, ...] = quantity("sets")
    seals: float = quantity("seals_Nmm", "friction torque of all seals and wipers, as given")
    other: float = quantity("other_Nmm", "friction torque of all else, as given in [drive]")
    running: Band | None = quantity(
        "running_torque_Nmm",
        "torque of the motor at constant speed: all sets, seals and all else (Smith 4.10); null where one is not known",
        heading="motor torque, running",
        form="g3",
        error="empirical; that of the coefficient of friction",
        parts="[]",
    )
    starting: Band | None = quantity(
        "starting_torque_Nmm",
        "the same from rest",
        error="empirical; that of the coefficient of friction",
        parts="[]",
        heading="motor torque from rest",
        form="g3",
    )
    accelerating: Band | None = quantity(
        "accelerating_torque_Nmm",
        "torque of the motor while it comes to speed: at constant speed and for the inertias, that of the mass over the "
        "efficiency of the nut (Smith 4.11); null without a time",
        heading="motor torque, accelerating",
        form="g3",
        error="as at constant speed",
        parts="[]",
    )
    shaft_inertia: float = quantity("shaft_inertia_kg_mm2", "moment of inertia of the shaft (Smith 4.14), without rings")
    reflected_inertia: float = quantity(
        "reflected_inertia_kg_mm2", "moment of inertia that the moved mass adds, m (p/(2 pi))^2 (Smith 4.15)"
    )
    inertia: float = quantity("inertia_kg_mm2", "both and that of the motor", heading="moment of inertia")


def nut_sums(assembly: Assembly, result: AxisResult) -> NutSums:
    """Return the friction torques and efficiencies of every nut on a shaft, or the reason why they are not known.

    Parameters
    ----------
    assembly
        Shaft with several nuts or bearing rows.
    result
        Converged result of the assembly.

    Returns
    -------
    dict
        For the number (from 0) of each nut: its friction results as JSON values, or None and the reason.
    """
    from rollbench.compare.models.friction_sums import cached_friction_sums

    out: dict[int, tuple[dict[str, Any] | None, str]] = {}
    for i, s in enumerate(result.sets):
        if isinstance(s.of.parts, Scene) and s.of.parts.track.lead and s.balls is not None:
            if assembly.friction is None:
                out[i] = None, "no coefficient in [friction]"
            else:
                parts = replace(s.of.parts, friction=assembly.friction, motion=assembly.motion)
                out[i] = cached_friction_sums(parts, s.balls, Options(member=result.member))
    return out


def axis_drive(assembly: Assembly, result: AxisResult, answers: AxisAnswers, nuts: NutSums) -> AxisDrive | None:
    """Compute torques and moments of inertia at the motor of a feed axis with a turning shaft.

    Bearings whose inner ring sits on a moving housing do not turn with the shaft and are omitted.

    Parameters
    ----------
    assembly
        Shaft with several nuts or bearing rows.
    result
        Converged result of the assembly.
    answers
        Bearing torques and other results that follow from ``result``.
    nuts
        Friction results of the nuts, by `nut_sums`.

    Returns
    -------
    AxisDrive or None
        Torques and inertias; None if the nuts turn instead of the shaft.
    """
    drive, motion = assembly.drive, assembly.motion
    if motion is not None and motion.turns != "screw":
        return None
    sign = -1.0 if motion is not None and motion.speed < 0.0 else 1.0
    turning = [i for i, s in enumerate(result.sets) if s.of.carrier is None]
    found = (
        _torque_of_nut(result.sets[i].of.name, *nuts[i], sign)
        if i in nuts
        else _torque_of_bearing(assembly, result.sets[i], answers.sets[i].torque)
        for i in turning
    )
    sets = tuple(replace(x, seals=result.sets[i].of.seals) for x, i in zip(found, turning, strict=True))
    seals, lead = sum(result.sets[i].of.seals for i in turning), lead_of(assembly)
    running = _sum_of_torques(drive.torque, [s.running for s in sets], seals)
    inertias = [screw_inertia(assembly, drive.density), drive.motor_inertia]
    accelerating = None
    if running is not None and motion is not None and drive.time is not None:
        worst, best = EFFICIENCY if drive.efficiency is None else (drive.efficiency, drive.efficiency)
        each = [[*inertias, reflected_inertia(drive.mass, lead, e)] for e in (best, worst)]
        low, high = (acceleration_torque(of, abs(motion.speed), drive.time) for of in each)
        accelerating = running[0] + low, running[1] + high
    carried = reflected_inertia(drive.mass, lead)
    return AxisDrive(
        sets,
        seals,
        drive.torque,
        running,
        _sum_of_torques(drive.torque, [s.starting for s in sets], seals),
        accelerating,
        inertias[0],
        carried,
        sum(inertias) + carried,
    )


def lead_of(assembly: Assembly) -> float:
    """Return the lead of the first nut on the shaft [m]; 0 without a nut."""
    return next((s.parts.track.lead for s in assembly.sets if isinstance(s.parts, Scene) and s.parts.track.lead), 0.0)


def _sum_of_torques(other: float, sets: list[Band | None], seals: float) -> Band | None:
    """Return the sum of all torques on the shaft as (low, high) [N m] (Smith 4.10); None if one of ``sets`` is None."""
    known = [x for x in sets if x is not None]
    if len(known) < len(sets):
        return None
    low, high = (TorqueBudget(other, seals, tuple(x[k] for x in known), 0.0).constant_speed for k in (0, 1))
    return low, high


def _torque_of_nut(name: str, sums: dict[str, Any] | None, why: str, sign: float) -> SetDrive:
    """Return the torque with which the screw drives a nut, positive in the shaft's direction of rotation (``sign``)."""
    if sums is None or sums["driving_torque_on_screw_Nmm"] is None:
        return SetDrive(name, None, None, words=why or "the friction of the balls did not converge")
    torque = 1e-3 * sign * sums["driving_torque_on_screw_Nmm"]
    return SetDrive(name, (torque, torque), (torque, torque))


def _torque_of_bearing(assembly: Assembly, s: SetResult, torque: BallTorque | None) -> SetDrive:
    """Return the friction torque of a bearing row, running and from rest; zero if the row carries no load."""
    ends: tuple[Band | None, Band | None] = (0.0, 0.0), (0.0, 0.0)
    if torque is not None:
        ends = torque.running, torque.starting
    elif isinstance(s.of.parts, RollerRow) and s.line_loads is not None:
        speed = None if assembly.motion is None else assembly.motion.speed
        if (row := roller_torque(s.of.parts, s.line_loads, speed, assembly.lubricant)) is not None:
            low, high = (row.torque if x is None else x for x in (row.low, row.high))
            ends = None if row.film is None else (low, high), (low - (row.film or 0.0), high - (row.film or 0.0))
    return SetDrive(s.of.name, *ends, words="" if ends[0] is not None else NOT_RUNNING)


def axis_life(assembly: Assembly, result: AxisResult, answers: AxisAnswers) -> SystemLife | None:
    """Compute the combined life of all nuts and bearings that turn with the shaft; None if none of them has a life."""
    lives = {}
    for s, one in zip(result.sets, answers.sets, strict=True):
        life = getattr(one.loads, "life", None)
        if s.of.carrier is None and life is not None:
            slope = roller_life.SLOPE if isinstance(one.loads, RollerAnswers) else SLOPE
            lives[one.name] = 1e6 * life.revolutions, slope
    if not lives:
        return None
    speed = None if assembly.motion is None else assembly.motion.speed
    shortest = min(lives, key=lambda name: lives[name][0])
    return SystemLife(1e-6 * system_life([*lives.values()]), shortest, lead_of(assembly), speed)
