"""The answers on several rolling sets as JSON, in the keys of a single set, and as a block of lines."""

from __future__ import annotations

from typing import Any

import numpy as np

from rollbench.comparison.commands.solving.solve_output import stiffness_json, summary
from rollbench.comparison.commands.solving.summary import PRELOAD, contact_entries, contacts_json, entry, loads_json
from rollbench.comparison.models.answers import AxisAnswers, SetAnswers
from rollbench.comparison.quantities import number, quantity, record
from rollbench.comparison.registration import offered
from rollbench.lowfi.statics.result import AxisResult, SetResult
from rollbench.meshes.axis import Assembly


def whole_stiffness(result: AxisResult) -> dict[str, Any] | None:
    """The stiffness of the whole in the keys of a single set's; null where a freedom is held."""
    if result.stiffness is None:
        return None
    return {"at": result.stiffness_at, **stiffness_json(result.station, result.status, result.stiffness)}


#: Answers on a bearing's torque.
STARTING = (
    quantity("torque_Nmm"),
    quantity("factor"),
    quantity("equivalent_load_N"),
    quantity("static_rating_N", "rating"),
)


def starting_torque(s: SetResult, answers: SetAnswers) -> dict[str, Any] | None:
    """Starting torque of a bearing that carries thrust one way, under its preload; None without one, and for nuts."""
    ways, preload = offered("starting torque"), answers.preload
    if not ways or s.of.kind != "bearing" or s.of.thrust not in ("+z", "-z") or not (preload and preload.axial):
        return None
    return record(STARTING, ways[0](answers.parts, preload.axial))


def set_summary(s: SetResult, answers: SetAnswers | None) -> dict[str, Any]:
    """Summary of one set; empty for rollers."""
    if s.balls is None or not np.isfinite(s.balls.load).all():
        return {}
    data: dict[str, Any] = {"sides": summary(s.balls.load)}
    if answers is None:
        return data
    data |= {"loads": loads_json(s.balls.load), **contacts_json(answers.loads), "preload": record(PRELOAD, answers.preload)}
    return data | {"starting_torque": starting_torque(s, answers)}


def whole_summary(result: AxisResult, answers: AxisAnswers | None) -> dict[str, Any]:
    """Summary of the whole: sides over all sets, what the set of the worst contact says with its number, axial answers."""
    loads = [s.balls.load for s in result.sets if s.balls is not None]
    if not loads or not result.converged:
        return {}
    data: dict[str, Any] = {"sides": summary(np.concatenate(loads))}
    if answers is None:
        return data
    K = None if result.stiffness is None else result.stiffness[2, 2]
    data["axial"] = {
        "force_N": number(answers.force),
        "displacement_um": None if answers.displacement is None else number(1e6 * answers.displacement),
        "rigidity_N_per_um": number(1e-6 * answers.force / answers.displacement) if answers.displacement else None,
        "tangent_N_per_um": None if K is None else number(1e-6 * K),
        "lost_motion_um_per_100N": None if K is None or K <= 0.0 else number(1e6 * 2.0 * 100.0 / K),
    }
    data["stiffness"] = whole_stiffness(result)
    i = worst(answers)
    if i is not None:
        of_set = set_summary(result.sets[i], answers.sets[i])
        data |= {"worst_set": i + 1} | {k: of_set[k] for k in of_set if k not in ("sides", "preload", "starting_torque")}
    return data


def worst(answers: AxisAnswers) -> int | None:
    """Number (from 0) of the set of balls with the highest pressure."""
    pressures = [-1.0 if s is None or s.loads.worst is None else s.loads.worst.pressure for s in answers.sets]
    return int(np.argmax(pressures)) if max(pressures, default=-1.0) > 0.0 else None


def block(assembly: Assembly, result: AxisResult, answers: AxisAnswers, width: int) -> str:
    """Labelled entries, no line wider than ``width``: axial answers, then what the worst set's contacts say, preloads."""
    data = whole_summary(result, answers)
    axial = data.get("axial")
    lines = []
    if axial is not None:
        moved = axial["displacement_um"]
        text = f"{axial['force_N']:.5g} N on shaft and housings"
        text += "" if moved is None else f", {result.stiffness_at} moves by {moved:.4g} um from where it is without loads"
        rigid = axial["tangent_N_per_um"]
        lines.append(("axial", text if rigid is None else f"{text}; tangent rigidity {rigid:.5g} N/um"))
        lost = axial["lost_motion_um_per_100N"]
        if lost is not None:
            lines.append(("lost", f"{lost:.3g} um of motion for every 100 N of friction that reverses, by elasticity only"))
    if "worst_set" in data:
        name = assembly.sets[data["worst_set"] - 1].name
        speed = None if assembly.motion is None else assembly.motion.speed
        lines += [(label, f"{name}: {text}") for label, text in contact_entries(data, speed)]
    preloads = [
        f"{s.of.name} {of_set.preload.mean:.1f} N a contact, {of_set.preload.axial:.0f} N along the axis"
        for s, of_set in zip(result.sets, answers.sets, strict=True)
        if of_set is not None and of_set.preload is not None and of_set.preload.loaded
    ]
    lines.append(("preload", "; ".join(preloads) or "no contact of balls carries load when the loads are away"))
    torques = {
        s.of.name: found_torque["torque_Nmm"]
        for s, of_set in zip(result.sets, answers.sets, strict=True)
        if of_set is not None and (found_torque := starting_torque(s, of_set)) is not None
    }
    if torques:
        each = "; ".join(f"{name} {value:.3g} N mm" for name, value in torques.items())
        words = "in all by Palmgren's load formula (Smith 2.33), without lubricant and seals"
        lines.append(("starting", f"torque {sum(torques.values()):.3g} N mm {words}: {each}"))
    return "\n".join(entry(label, text, width) for label, text in lines)
