"""``rollbench friction`` of a shaft with several rolling sets: the friction of each, and the torque of the shaft."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from rollbench.compare.errors import ArgumentError, InputError
from rollbench.compare.models.answers import solve_sets
from rollbench.compare.models.friction_sums import sums
from rollbench.compare.models.registry import run_model
from rollbench.compare.quantities import number
from rollbench.compare.studies.friction import output
from rollbench.compare.studies.friction.answer import NOTHING, FrictionAnswer, Line, balance, energy_line, three
from rollbench.compare.studies.friction.whole import NO_SPEED, Choices, coefficients, status_of
from rollbench.compare.text.printing import Column
from rollbench.lowfi.friction.whole.state import FrictionState, friction_state
from rollbench.lowfi.friction.whole.torque import ONE_TURN
from rollbench.lowfi.statics.result import AxisResult, SetResult
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Friction, Motion, Scene

#: What the friction of a shaft does not hold besides that of its sets.
ROLLERS = "friction of tapered rollers: races, ribs and cage (Smith 3.29 needs the maker's factor)"
SET_COLUMNS: tuple[Column, ...] = (
    ("set", "set", "s"),
    ("name", "name", "s"),
    ("friction_torque_Nmm", "friction torque N mm", ".5g"),
    ("drag_torque_Nmm", "drag torque N mm", ".5g"),
    ("axial_load_N", "axial load N", ".5g"),
    ("driving_torque_on_screw_Nmm", "torque on the shaft N mm", ".5g"),
    ("loss_W", "loss W", ".5g"),
)
Solved = list[tuple[int, SetResult, FrictionState]]


def solve_axis(assembly: Assembly, choices: Choices) -> FrictionAnswer:
    """Loads by the chosen model, then friction of every set of balls. Raises InputError for choices that do not fit."""
    if choices.condensed is not None or choices.member or len(choices.mu) > 1:
        given = "condensed, member, mu"
        raise ArgumentError(given, f"with {assembly.name}", "one set on the shaft, or one `mu` alone", "leave them out")
    friction = _coefficient(assembly, choices.mu)
    motion = assembly.motion or ONE_TURN
    if motion.turns != "screw":
        raise InputError(
            assembly.name, "motion.turns", '"nut"', '"screw"', "several outer parts stand while the shaft turns"
        )
    result, _ = solve_sets(assembly, choices.model)
    head = {"scene": assembly.name, "title": assembly.title, "kind": assembly.kind, "model": result.model}
    if not result.converged:
        remarks = {"assumed": list(assembly.assumed), "left_out": [], "warnings": []}
        return FrictionAnswer(
            head | {"status": f"contact loads: {result.status}", "converged": False} | remarks, [], [], False
        )
    solved = _states(result, friction, motion)
    drag = _drag(assembly, result.model, friction, motion)
    return _answer(head, assembly, result, (friction, motion, solved, drag))


def _coefficient(assembly: Assembly, mu: Sequence[float]) -> Friction:
    """The coefficient of the command line, or the scene's."""
    first = next((s.parts for s in assembly.sets if isinstance(s.parts, Scene)), None)
    if first is None:
        advice = "give the shaft a set of balls: rollers have none"
        raise InputError(assembly.name, "sets", "rollers only", "a set of balls", advice)
    return coefficients(replace(first, name=assembly.name, friction=assembly.friction), mu)[0]


def _states(result: AxisResult, friction: Friction, motion: Motion) -> Solved:
    """Friction of every set of balls, with its number."""
    out: Solved = []
    for i, s in enumerate(result.sets):
        if s.balls is None or not isinstance(s.of.parts, Scene):
            continue
        out.append((i, s, friction_state(s.of.parts, s.balls, friction, motion)))
    return out


def _drag(assembly: Assembly, model: str, friction: Friction, motion: Motion) -> dict[int, float]:
    """Friction torque [N m] of each set without the loads on shaft and housings, where it is known."""
    idle = tuple(replace(h, force=(0.0, 0.0, 0.0), moment=(0.0, 0.0, 0.0)) for h in assembly.housings)
    result = run_model(replace(assembly, loads=(), housings=idle), model)
    if not result.converged:
        return {}
    return {i: state.torque.friction for i, _, state in _states(result, friction, motion) if state.settled}


def _set_row(i: int, s: SetResult, state: FrictionState, drag: float | None) -> dict[str, Any]:
    return {"set": i + 1, "name": s.of.name} | sums(state.torque, drag) | {"loss_W": number(state.torque.power)}


def _answer(
    head: dict[str, str], assembly: Assembly, result: AxisResult, found: tuple[Friction, Motion, Solved, dict[int, float]]
) -> FrictionAnswer:
    friction, motion, solved, drag = found
    rows = [_set_row(i, s, state, drag.get(i)) for i, s, state in solved]
    balls = [{"set": i + 1} | row for i, s, state in solved if s.balls for row in output.ball_rows(s.balls, state)]
    losses = [{"set": i + 1} | row for i, _, state in solved for row in output.loss_rows(state)]
    good = all(state.settled for _, _, state in solved)
    failed = next((x for x in solved if not x[2].settled), None)
    torque, power = _sum(solved, drag), _energy(solved)
    without = any(s.balls is None for s in result.sets)
    of_rollers = tuple(f"{s.of.name}: " for s in result.sets if s.balls is None)  # whose loads friction leaves as they are
    warnings = [w for w in result.warnings if w.startswith(of_rollers)]
    warnings += output.static_only([w for w in result.warnings if not w.startswith(of_rollers)])
    for _, s, state in solved:
        if isinstance(s.of.parts, Scene):
            warnings += [w.of(s.of.name) for w in output.warnings_of(s.of.parts, friction, state, ())]
    data = head | {
        "status": "converged" if failed is None else f"{failed[1].of.name}: {status_of(failed[2])}",
        "converged": good,
        "law": "coulomb",
        "friction": {"screw": friction.screw, "nut": friction.nut},
        "motion": {"turns": motion.turns, "speed_rad_s": number(motion.speed)},
        "sets": rows,
        "balls": balls,
        "torque": torque,
        "losses": {"total_W": number(sum(x.torque.power for _, _, x in solved)), "by_contact_W": losses},
        "energy": power,
        "assumed": [
            *friction.assumed,
            *(() if assembly.motion else (NO_SPEED,)),
            *assembly.assumed,
            *(f"contact loads: {x}" for x in result.assumed if x not in assembly.assumed),
        ],
        "left_out": [*output.left_out(friction), *((ROLLERS,) if without else ())],
        "warnings": warnings,
    }
    flat = [{"set": b["set"]} | f for b, f in zip(balls, output.flat_rows(balls), strict=True)]
    every = [("per ball", (("set", "set", "s"), *output.BALL_COLUMNS), flat)]
    lines = [
        (
            "torque",
            f"{torque['driving_torque_on_screw_Nmm']:+.3g} N mm about +z drive the shaft at {motion.speed:.6g} rad/s; "
            f"friction torque of all sets {three(torque['friction_torque_Nmm'])} N mm",
        ),
        _energy_line(power),
        output.solver_line(result.solver.residual, max((x.balls.left for _, _, x in solved), default=0.0)),
    ]
    return FrictionAnswer(data, [("sets", SET_COLUMNS, rows)], lines, good, every)


def _energy(solved: Solved) -> dict[str, Any]:
    """Powers [W] of all sets together: what the contacts take and lose, what the shaft's torque and the axial loads of the
    sets put in; efficiency where one of these two drives the other."""
    torques = [x.torque for _, _, x in solved]
    turning = float(np.sum([t.on_screw * t.speed for t in torques]))
    along = float(np.sum([t.load * t.ratio * t.speed for t in torques]))
    taken, lost = (float(np.sum([getattr(t, name) for t in torques])) for name in ("input_power", "power"))
    driving, driven = max(turning, along), min(turning, along)
    return balance(taken, lost) | {
        "axial_load_power_W": number(along),
        "torque_power_W": number(turning),
        "efficiency_percent": number(-100.0 * driven / driving) if driven < -NOTHING * driving else None,
    }


def _energy_line(values: dict[str, Any]) -> Line:
    """The powers in words."""
    efficiency = values["efficiency_percent"]
    by = "the torque" if values["torque_power_W"] > values["axial_load_power_W"] else "the axial load"
    worth = "no power leaves the shaft" if efficiency is None else f"{by} drives with an efficiency of {efficiency:.3g} %"
    label, text = energy_line(values, 3)
    return label, f"{text}; {worth}"


def _sum(solved: Solved, drag: dict[int, float]) -> dict[str, Any]:
    """Torques [N mm] of all sets together."""
    known = len(drag) == len(solved)
    return {
        "friction_torque_Nmm": number(1e3 * float(np.sum([x.torque.friction for _, _, x in solved]))),
        "drag_torque_Nmm": number(1e3 * sum(drag.values())) if known else None,
        "driving_torque_on_screw_Nmm": number(1e3 * float(np.sum([x.torque.on_screw for _, _, x in solved]))),
    }
