"""A run in time of a scene with [time]: values for JSON, a table of the torque over the angle, and a few lines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rollbench.comparison.commands.solving.solve_output import number
from rollbench.comparison.errors import InputError, Refusal
from rollbench.lowfi.friction.screw.run import groups
from rollbench.lowfi.friction.screw.steps import REFUSED, StepError
from rollbench.lowfi.friction.whole.balls import balls_of
from rollbench.lowfi.friction.whole.run import History, Setting, resolved
from rollbench.lowfi.statics.again import AGAIN
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import draw
from rollbench.meshes.parts import Friction, Motion, Scene, Time

#: Rows of the table in the terminal.
ROWS = 12
#: What a run leaves out besides what an instant does.
LEFT_OUT = (
    "travel of the nut along the screw: shaft and supports are those at the scene's station of the nut",
    "run-in of the grooves: balls enter and leave the loaded arc at full depth",
    "balls in the return: they roll along without friction or weight unless neighbours push them",
    "ball-to-ball forces in the balance of contact loads; inertia of the balls",
)
COLUMNS = (
    ("angle_deg", "angle deg", ".2f"),
    ("torque_Nmm", "torque N mm", ".5g"),
    ("groove_Nmm", "grooves N mm", ".5g"),
    ("balls_Nmm", "ball to ball N mm", ".4g"),
    ("loaded", "balls loaded", "d"),
    ("groups", "groups touching", "d"),
)


@dataclass(frozen=True)
class Run:
    """A run and the error of its steps; status in words, converged: whether it may be used, warnings."""

    time: Time
    history: History
    error: StepError | None
    status: str
    warnings: tuple[str, ...]

    @property
    def converged(self) -> bool:
        """Whether every step converged, and their error was not refused."""
        return self.status == "converged"


def solve_run(scene: Scene, friction: Friction, motion: Motion, model: str, member: int) -> Run:
    """Run a scene in time. Raises InputError for models that do not solve it again and again, and Refusal for circuits."""
    time = scene.time
    if time is None:
        raise ValueError("the scene has no [time]")
    if model not in AGAIN:
        advice = "take another model, or leave [time] out"
        raise InputError("command line", "--model", model, f"{' or '.join(AGAIN)} for a run in time", advice)
    drawn, loads = draw(scene, member), AGAIN[model]
    try:
        balls = balls_of(scene, friction, motion, drawn, member)
    except ValueError as error:
        advice = "give the circuits more room: see [circulation]"
        raise Refusal(scene.name, "circulation", str(error), advice) from error
    setting = Setting(scene, friction, motion, drawn, balls, lambda met, at: loads(scene, met, at, "compiled"))
    history, error_of = resolved(setting, time)
    return judged(time, history, error_of)


def judged(time: Time, history: History, error: StepError | None) -> Run:
    """The run with its verdict: refused where a step failed or the error of the steps is large, warned of otherwise."""
    if not history.good or error is None:
        return Run(time, history, error, history.status, ())
    size = f"the error of {error.steps[-1]} steps is some {100.0 * error.torque:.2g} % of the mean torque"
    if error.refused:
        advice = "take more steps" if time.steps else "shorten the run"
        return Run(time, history, error, f"refused: {size}, more than {100.0 * REFUSED:g} %: {advice}", ())
    if not error.small(time.goal):
        return Run(time, history, error, "converged", (f"{size}, more than the goal of {100.0 * time.goal:g} %",))
    return Run(time, history, error, "converged", ())


def run_data(run: Run) -> dict[str, Any]:
    """Values of a run for JSON; histories step by step at the middle of each, gaps at its end."""
    h, e = run.history, run.error
    reached, asked = (number(math.degrees(angle)) for angle in h.angles)
    data: dict[str, Any] = {
        "status": run.status,
        "converged": run.converged,
        "complete": h.complete,
        "steps": h.steps,
        "reached_deg": reached,
        "asked_deg": asked,
        "step_error": None if e is None else error_data(e, run.time.goal),
        "step_error_unknown": no_error(run),
        "left_out": list(LEFT_OUT),
    }
    if not h.steps:
        return data
    data["circuits"] = [
        {
            "start": t.start + 1,
            "balls": int(t.azimuth.size),
            "loaded_arc_deg": number(math.degrees(t.arc)),
            "length_deg": number(math.degrees(t.ring)),
            "touching_deg": number(math.degrees(t.spacing)),
            "filling": number(t.azimuth.size * t.spacing / t.ring),
        }
        for t in h.balls.tracks
    ]
    data["torque"] = torque_data(h)
    data["energy"] = energy_data(h)
    data["over_angle"] = {
        "angle_deg": _list(np.degrees(h.turned)),
        "torque_Nmm": _list(1e3 * h.torque),
        "groove_Nmm": _list(1e3 * h.groove_torque),
        "ball_sliding_Nmm": _list(1e3 * h.ball_torque),
        "ball_closing_Nmm": _list(1e3 * h.closing_torque),
        "axial_load_N": _list(h.axial),
        "driving_torque_on_screw_Nmm": _list(1e3 * h.on_screw),
    }
    if run.time.output == "balls":
        data["balls"] = [ball_data(h, own, k) for own in h.balls.bounds for k in range(own.start, own.stop)]
    return data


def error_data(e: StepError, goal: float) -> dict[str, Any]:
    """The estimate of the error of the steps, and what it is made of."""
    return {
        "quantity": "friction torque over the angle: mean absolute error, as a part of the mean torque",
        "torque_percent": number(100.0 * e.torque),
        "mean_torque_percent": number(100.0 * e.mean),
        "observed_order": None if math.isnan(e.order) else number(e.order),
        "order_used": e.used,
        "steps": list(e.steps),
        "goal_percent": number(100.0 * goal),
        "small": e.small(goal),
    }


def no_error(run: Run) -> str | None:
    """Why a run has no estimate of the error of its steps; None where it has one."""
    if run.error is not None:
        return None
    return "a step did not converge" if run.history.complete else "the run stopped before its end"


def energy_data(h: History) -> dict[str, Any]:
    """Work over the run [J] of the torque on the screw and of its axial load, losses, and the largest imbalance of a step
    over its losses: of the power that contacts take in, and of torque and load against losses."""
    dt, (turning, along) = h.step, h.advance
    loss = h.torque * abs(turning)
    rubs = bool(np.all(loss > 0.0))
    return {
        "torque_work_J": number(dt * turning * float(h.on_screw.sum())),
        "load_work_J": number(dt * along * float(h.axial.sum())),
        "loss_J": number(dt * float(loss.sum())),
        "balance_J": number(dt * float(h.torque_balance.sum())),
        "largest_imbalance": number(float(np.abs(h.imbalance).max())),
        "largest_torque_imbalance": number(float(np.abs(h.torque_balance / loss).max())) if rubs else None,
    }


def torque_data(h: History) -> dict[str, Any]:
    """Mean, ends and parts of the friction torque."""
    balls = h.ball_torque + h.closing_torque
    return {
        "mean_Nmm": number(1e3 * float(h.torque.mean())),
        "least_Nmm": number(1e3 * float(h.torque.min())),
        "most_Nmm": number(1e3 * float(h.torque.max())),
        "groove_mean_Nmm": number(1e3 * float(h.groove_torque.mean())),
        "ball_to_ball_mean_Nmm": number(1e3 * float(balls.mean())),
        "ball_to_ball_most_percent_of_groove": _percent(balls, h.groove_torque),
        "largest_ball_force_N": number(float(h.ball_force.max(initial=0.0))),
    }


def _percent(part: Array, whole: Array) -> float | None:
    """Largest ratio of two histories [%]; None where the whole vanishes."""
    if float(whole.min()) <= 0.0:
        return None
    return number(100.0 * float((part / whole).max()))


def ball_data(h: History, own: slice, k: int) -> dict[str, Any]:
    """Histories of one ball: azimuth in the nut's frame, distance and force to the next ball of its circuit, loads."""
    ahead = k + 1 if k + 1 < own.stop else own.start
    number_of = int(h.balls.number[k])
    return {
        "index": None if number_of < 0 else number_of + 1,
        "next": ahead,
        "place": k,
        "azimuth_deg": _list(np.degrees(h.azimuth[:, k])),
        "loaded": [bool(v) for v in h.loaded[:, k]],
        "spacing_deg": _list(np.degrees(h.gap[:, k] + h.balls.spacing[k])),
        "force_on_next_N": _list(h.ball_force[:, k]),
        "load_N": _list(h.load[:, k].sum(axis=1)),
    }


def _list(values: Array) -> list[float | None]:
    return [number(float(v)) for v in values]


def run_rows(h: History) -> list[dict[str, object]]:
    """Some rows of the torque over the angle for the terminal."""
    which = np.unique(np.linspace(0, h.steps - 1, min(ROWS, h.steps)).round().astype(int))
    touching = sum(groups(h.ball_force[:, own] > 0.0) for own in h.balls.bounds)
    return [
        {
            "angle_deg": number(math.degrees(h.turned[k])),
            "torque_Nmm": number(1e3 * h.torque[k]),
            "groove_Nmm": number(1e3 * h.groove_torque[k]),
            "balls_Nmm": number(1e3 * (h.ball_torque[k] + h.closing_torque[k])),
            "loaded": int(h.loaded[k].sum()),
            "groups": int(np.asarray(touching)[k]),
        }
        for k in which
    ]


def run_lines(run: Run) -> list[str]:
    """The run in a few lines."""
    h, e = run.history, run.error
    if not h.steps:
        return [f"run in time: {run.status}"]
    t = torque_data(h)
    reached, asked = (f"{math.degrees(angle):.6g} deg" for angle in h.angles)
    far = f"over {reached}" if h.complete else f"stopped at {reached} of {asked},"
    lines = [
        f"{far} in {h.steps} steps: friction torque "
        f"{t['mean_Nmm']:.6g} N mm in the mean, {t['least_Nmm']:.6g} to {t['most_Nmm']:.6g} N mm; grooves "
        f"{t['groove_mean_Nmm']:.6g}, ball to ball {t['ball_to_ball_mean_Nmm']:.4g} N mm in the mean"
    ]
    if e is not None:
        order = "no order observed" if math.isnan(e.order) else f"order {e.order:.2g} observed"
        lines.append(
            f"error of the steps: {100.0 * e.torque:.2g} % of the mean torque over the angle, {100.0 * e.mean:.2g} % in "
            f"its mean, from {', '.join(str(n) for n in e.steps)} steps ({order}, {e.used:.2g} used); goal "
            f"{100.0 * run.time.goal:g} %"
        )
    else:
        lines.append(f"error of the steps: unknown, {no_error(run)}")
    return lines if run.converged else [*lines, f"run in time: {run.status}"]


def run_table(run: Run) -> list[tuple[str, Sequence[tuple[str, str, str]], Sequence[dict[str, object]]]]:
    """The table of the run, if there is one."""
    return [("torque over the angle", COLUMNS, run_rows(run.history))] if run.history.steps else []
