"""Friction of a whole screw over time: JSON values, a table of torque over angle, and lines for the terminal."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from rollbench.compare.errors import ArgumentError, SceneNotCoveredError
from rollbench.compare.quantities import json_number
from rollbench.compare.running import progress_bar
from rollbench.compare.studies.friction.answer import Line
from rollbench.lowfi.friction.screw import travel
from rollbench.lowfi.friction.whole.circuit import balls_in_circuits
from rollbench.lowfi.friction.whole.run import MODELS_OVER_TIME, SceneInMotion, load_solver_for_travelling_balls
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import draw_errors
from rollbench.meshes.parts import Friction, Motion, Scene, Time

#: Number of rows of the table in the terminal.
ROWS = 12
#: Effects that a simulation over time neglects in addition to those of one instant.
LEFT_OUT = (
    "travel of the nut along the screw: shaft and supports are those at the scene's position of the nut",
    "run-in of the grooves: balls take and lose their whole load at the ends of the loaded arc, where the torque jumps",
    "balls in the return: they roll along without friction or weight unless neighbours push them",
    "ball-to-ball forces in the balance of contact loads; inertia of the balls",
)
#: Columns of the table of the torque over the angle.
COLUMNS = (
    ("angle_deg", "angle deg", ".2f"),
    ("torque_Nmm", "torque N mm", ".5g"),
    ("groove_Nmm", "grooves N mm", ".5g"),
    ("balls_Nmm", "ball to ball N mm", ".4g"),
    ("loaded", "balls loaded", "d"),
    ("groups", "groups touching", "d"),
)


#: Quantities whose error due to finite time steps is estimated: key, and name in the texts of the terminal.
QUANTITIES = {
    "torque": "the torque over the angle",
    "mean": "its mean",
    "largest": "its largest value",
    "least": "its least value",
    "share": "the largest ratio of ball-to-ball to groove torque",
}


@dataclass(frozen=True)
class TransientRun:
    """Simulation of a screw over time, with the estimated error due to the finite time steps, and a status."""

    #: Time series of contact loads, torques and motions of the balls.
    history: travel.TravelHistory
    #: Estimated errors of the friction torque due to the finite time steps; None if not estimated.
    error: travel.TimeStepErrors | None
    #: Largest allowed error of the friction torque due to the time steps, as a fraction of the mean torque.
    allowed_error: float
    #: Whether the number of time steps was prescribed in the scene file, not chosen by the program.
    step_count_given: bool
    #: "converged" if every step converged and no error is above ``allowed_error``; else the reason why not.
    status: str
    #: Whether the JSON results include the time series of each ball.
    shows_ball_histories: bool = True

    @property
    def converged(self) -> bool:
        """Whether all time steps converged and no estimated error is above the allowed one."""
        return self.status == "converged"


def simulate_friction_over_time(
    scene: Scene, friction: Friction, motion: Motion, model: str, specimen: int
) -> TransientRun:
    """Simulate the friction of a screw over time, and estimate the error due to finite time steps.

    ``scene``: scene with a [time] table; ``friction``: coefficients of friction; ``motion``: motion of screw or nut;
    ``model``: name of the static model; ``specimen``: number of the draw of random errors. Raises InputError if the
    model cannot solve moving balls, and SceneNotCoveredError if the circuits have no room for the balls.
    """
    time = scene.time
    if time is None:
        raise ValueError(f"friction of {scene.name} cannot be simulated over time: add a table [time] to its scene")
    if model not in MODELS_OVER_TIME:
        advice = "take another model, or leave [time] out"
        raise ArgumentError("model", model, f"{' or '.join(MODELS_OVER_TIME)} for a scene with [time]", advice)
    drawn = draw_errors(scene, specimen)
    try:
        balls = balls_in_circuits(scene, friction, motion, drawn, specimen)
    except ValueError as error:
        advice = "give the circuits more room by [circulation]"
        raise SceneNotCoveredError(scene.name, "circulation", str(error), advice) from error
    ahead = float(np.sign(balls.grooves.nominal_orbit - balls.grooves.nut_speed)) or 1.0
    loads = load_solver_for_travelling_balls(model, ahead)
    setting = SceneInMotion(scene, friction, motion, drawn, balls, partial(loads, scene))
    return simulate_with_several_step_sizes(setting, motion, time, scene.name)


def simulate_with_several_step_sizes(setting: Any, motion: Motion, time: Time, name: str) -> TransientRun:
    """Simulate a screw over time with several step sizes, from which the error due to finite time steps is estimated.

    ``setting``: the screw with its balls, as the transient solver reads it; ``motion``: motion of screw or nut;
    ``time``: duration, number of steps and allowed error of the simulation; ``name``: name of the scene for the
    progress bar.
    """
    with progress_bar(f"{name}, simulation over time") as progress:
        found = travel.simulate_with_step_errors(setting, time.span(motion), time.steps, time.goal, progress)
    return simulation_with_status(*found, time)


def simulation_with_status(history: travel.TravelHistory, error: travel.TimeStepErrors | None, time: Time) -> TransientRun:
    """Return a simulation over time together with its status: "converged", or why it did not converge.

    ``history``: time series; ``error``: estimated error due to finite time steps, None if it is not known; ``time``:
    settings of the simulation with the largest allowed error. The simulation is not converged if a step failed, if the
    error is not known, or if it is larger than allowed.
    """
    status = history.status
    if history.fully_converged and error is None:
        status = "not converged in the time step: the error of fewer than 4 steps is not known; take more steps"
    elif error is not None and not error.all_errors_within(time.goal):
        of = error.errors_by_quantity
        name = max(of, key=lambda name: of[name].error)
        unseen = " (no order of convergence observed)" * of[name].no_order_observed
        status = (
            f"not converged in the time step: the error of {error.step_counts[-1]} steps is some "
            f"{100.0 * error.largest_error:.2g} % of the mean torque in {QUANTITIES[name]}{unseen}, more than the goal of "
            f"{100.0 * time.goal:g} %: {'take more steps' if time.steps else 'shorten the run'}"
        )
    return TransientRun(history, error, time.goal, time.steps is not None, status, time.output == "balls")


def transient_simulation_as_json(run: TransientRun) -> dict[str, Any]:
    """Return torque, energy and motion of the balls in a simulation over time as JSON.

    A time step is divided into shorter ones where a ball enters or leaves the loaded arc, or where neighbouring balls meet.
    Time series have the values at the middle of each of these shorter steps, but gaps between balls at its end.
    """
    h, e = run.history, run.error
    reached, asked = (json_number(math.degrees(angle)) for angle in h.reached_and_intended_angle)
    data: dict[str, Any] = {
        "status": run.status,
        "converged": run.converged,
        "complete": h.reached_end,
        "steps": h.begun_step_count,
        "reached_deg": reached,
        "asked_deg": asked,
        "step_error": None if e is None else step_error_json(e, run.allowed_error),
        "step_error_unknown": why_no_step_error(run),
        "left_out": list(LEFT_OUT),
    }
    if not h.begun_step_count:
        return data
    data["circuits"] = [
        {
            "start": t.start + 1,
            "balls": t.balls.stop - t.balls.start,
            "loaded_arc_deg": json_number(math.degrees(t.arc)),
            "length_deg": json_number(math.degrees(t.ring)),
            "touching_deg": json_number(math.degrees(t.spacing)),
            "filling": json_number((t.balls.stop - t.balls.start) * t.spacing / t.ring),
        }
        for t in h.setting.tracks
    ]
    data["torque"] = transient_torque_json(h)
    data["energy"] = transient_energy_json(h)
    data["over_angle"] = {
        "angle_deg": _finite_values_for_json(np.degrees(h.rotation_angle)),
        "covers_deg": _finite_values_for_json(np.degrees(h.lasts * abs(h.setting.groove.speed))),
        "torque_Nmm": _finite_values_for_json(1e3 * h.torque),
        "groove_Nmm": _finite_values_for_json(1e3 * h.groove_torque),
        "ball_sliding_Nmm": _finite_values_for_json(1e3 * h.ball_torque),
        "ball_closing_Nmm": _finite_values_for_json(1e3 * h.closing_torque),
        "axial_load_N": _finite_values_for_json(h.axial),
        "driving_torque_on_screw_Nmm": _finite_values_for_json(1e3 * h.on_screw),
    }
    if run.shows_ball_histories:
        data["balls"] = [ball_history_json(h, t, k) for t in h.setting.tracks for k in range(t.balls.start, t.balls.stop)]
    return data


def step_error_json(error: travel.TimeStepErrors, goal: float) -> dict[str, Any]:
    """Return the estimated errors due to finite time steps as JSON, with order of convergence and numbers of steps.

    ``error``: the errors; ``goal``: largest allowed error, as a fraction of the mean torque.
    """
    found = error.errors_by_quantity
    percent = {name: json_number(100.0 * found[name].error) if name in found else None for name in QUANTITIES}
    return {
        "quantity": "friction torque over the angle: mean absolute error, as a part of the mean torque",
        "torque_percent": percent["torque"],
        "mean_torque_percent": percent["mean"],
        "most_torque_percent": percent["largest"],
        "least_torque_percent": percent["least"],
        "ball_to_ball_most_percent": percent["share"],
        "observed_order": json_number(found["torque"].order),
        "order_used": json_number(found["torque"].order_used),
        "observed_orders": {name: json_number(q.order) for name, q in found.items()},
        "no_order_seen": list(error.quantities_without_order),
        "steps": list(error.step_counts),
        "goal_percent": json_number(100.0 * goal),
        "small": error.all_errors_within(goal),
    }


def why_no_step_error(run: TransientRun) -> str | None:
    """Return why the error of a simulation due to its time steps is not known; None if it is known."""
    if run.error is not None:
        return None
    if run.history.fully_converged:
        return "fewer than 4 steps"
    return "a step did not converge" if run.history.reached_end else "the run stopped before its end"


def transient_energy_json(history: travel.TravelHistory) -> dict[str, Any]:
    """Return the energies of a simulation over time [J], and their largest imbalances, as JSON.

    Energies are the work of torque and axial load on the screw, and the friction losses. Two powers are compared with the
    friction losses: the power that the contacts take in, and the power of torque and axial load. The imbalance of each is
    its largest difference from the losses in any time step, divided by the losses of that step.
    """
    turning, along = history.turning_and_axial_speed
    loss, power = history.torque * abs(turning), history.power_balance_on_screw
    ratio = json_number(float(np.abs(power / loss).max())) if np.all(loss > 0.0) else None
    return {
        "torque_work_J": json_number(turning * float(history.lasts @ history.on_screw)),
        "load_work_J": json_number(along * float(history.lasts @ history.axial)),
        "loss_J": json_number(float(history.lasts @ loss)),
        "balance_J": json_number(float(history.lasts @ power)),
        "largest_imbalance": json_number(float(np.abs(history.imbalance).max())),
        "largest_torque_imbalance": ratio,
    }


def transient_torque_json(history: travel.TravelHistory) -> dict[str, Any]:
    """Return the friction torque in a simulation over time [N mm] as JSON: mean, extremes, and contributions.

    The contributions are those of the contacts with the grooves and of the contacts between balls.
    """
    t = history.torque_statistics
    return {
        "mean_Nmm": json_number(1e3 * t["mean"]),
        "least_Nmm": json_number(1e3 * t["least"]),
        "most_Nmm": json_number(1e3 * t["largest"]),
        "groove_mean_Nmm": json_number(1e3 * history.mean_over_time(history.groove_torque)),
        "ball_to_ball_mean_Nmm": json_number(1e3 * history.mean_over_time(history.ball_torque + history.closing_torque)),
        "ball_to_ball_most_percent_of_groove": json_number(100.0 * history.largest_ball_to_groove_ratio),
        "largest_ball_force_N": json_number(float(history.ball_force.max(initial=0.0))),
    }


def ball_history_json(history: travel.TravelHistory, track: travel.ClosedTrack, ball: int) -> dict[str, Any]:
    """Return the time series of one ball as JSON: azimuth in the nut's frame, loads, distance and force to the next ball.

    ``history``: history of all balls; ``track``: circuit of the ball, on which the next ball follows; ``ball``: number
    of the ball from 0.
    """
    ahead = ball + 1 if ball + 1 < track.balls.stop else track.balls.start
    number_of = int(history.setting.number[ball])
    return {
        "index": None if number_of < 0 else number_of + 1,
        "next": ahead,
        "place": ball,
        "azimuth_deg": _finite_values_for_json(np.degrees(history.azimuth[:, ball])),
        "loaded": [bool(v) for v in history.loaded[:, ball]],
        "spacing_deg": _finite_values_for_json(np.degrees(history.spacing[:, ball])),
        "force_on_next_N": _finite_values_for_json(history.ball_force[:, ball]),
        "load_N": _finite_values_for_json(history.load[:, ball].sum(axis=1)),
    }


def _finite_values_for_json(values: Array) -> list[float | None]:
    """Return numbers (n,) as a list for JSON, with None for numbers that are not finite."""
    return [json_number(float(v)) for v in values]


def torque_rows_over_angle(history: travel.TravelHistory) -> list[dict[str, object]]:
    """Return table rows of the friction torque over the angle of rotation, at most `ROWS`, evenly spaced."""
    which = np.unique(np.linspace(0, history.time.size - 1, min(ROWS, history.time.size)).round().astype(int))
    return [
        {
            "angle_deg": json_number(math.degrees(history.rotation_angle[k])),
            "torque_Nmm": json_number(1e3 * history.torque[k]),
            "groove_Nmm": json_number(1e3 * history.groove_torque[k]),
            "balls_Nmm": json_number(1e3 * (history.ball_torque[k] + history.closing_torque[k])),
            "loaded": int(history.loaded[k].sum()),
            "groups": int(history.touching_group_counts[k]),
        }
        for k in which
    ]


def lines_on_simulation(run: TransientRun) -> list[Line]:
    """Return terminal lines (label, text) on a simulation over time: torque, error due to the time steps, failures."""
    h, e = run.history, run.error
    if not h.begun_step_count:
        return [("run", run.status)]
    t = transient_torque_json(h)
    reached, asked = (f"{math.degrees(angle):.6g} deg" for angle in h.reached_and_intended_angle)
    far = f"over {reached}" if h.reached_end else f"stopped at {reached} of {asked},"
    digits = f".{digits_for_relative_error(None if e is None else e.largest_error)}g"
    mean, least, most, groove, between = (
        format(t[f"{name}_Nmm"], digits) for name in ("mean", "least", "most", "groove_mean", "ball_to_ball_mean")
    )
    text = (
        f"{far} in {h.begun_step_count} steps: friction torque {mean} N mm in the mean, {least} to {most} N mm; "
        f"grooves {groove}, ball to ball {between} N mm in the mean"
    )
    lines = [("run", text)]
    if e is None:
        lines.append(("steps", f"error unknown, {why_no_step_error(run)}"))
    else:
        size = ", ".join(f"{100.0 * q.error:.2g} % in {QUANTITIES[name]}" for name, q in e.errors_by_quantity.items())
        order = e.errors_by_quantity["torque"].order
        seen = "no order observed" if math.isnan(order) else f"order {order:.2g} observed"
        text = (
            f"error of the time steps, as a part of the mean torque: {size}; from "
            f"{', '.join(map(str, e.step_counts))} steps ({seen}); goal {100.0 * run.allowed_error:g} %"
        )
        lines.append(("steps", text))
        if e.quantities_without_order:
            names = ", ".join(QUANTITIES[name] for name in e.quantities_without_order)
            text = (
                f"no order of convergence in {names}: the error is then taken as {travel.UNCLEAR:g} times the change "
                "between these numbers of steps"
            )
            lines.append(("", text))
    return lines if run.converged else [*lines, ("", run.status)]


def digits_for_relative_error(error: float | None) -> int:
    """Return how many significant digits of a value to show, from 3 to 6, so that at most two digits are uncertain.

    ``error``: relative error of the value; None if it is not known.
    """
    return 3 if error is None else int(np.clip(np.ceil(-np.log10(max(error, 1e-6))) + 2, 3, 6))
