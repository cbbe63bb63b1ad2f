"""Simulation of the friction of a whole screw over time: record, and its JSON."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from rollbench.compare.quantities import json_number
from rollbench.meshes.arrays import Array

if TYPE_CHECKING:
    from rollbench.lowfi.friction.screw import travel

#: Effects that a simulation over time neglects in addition to those of one instant.
LEFT_OUT = (
    "travel of the nut along the screw: shaft and supports are those at the scene's position of the nut",
    "run-in of the grooves: balls take and lose their whole load at the ends of the loaded arc, where the torque jumps",
    "balls in the return: they roll along without friction or weight unless neighbours push them",
    "ball-to-ball forces in the balance of contact loads; inertia of the balls",
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
    #: "converged" if every step converged and no error is above ``allowed_error``; else the reason why not.
    status: str
    #: Whether the JSON results include the time series of each ball.
    shows_ball_histories: bool = True

    @property
    def converged(self) -> bool:
        """Whether all time steps converged and no estimated error is above the allowed one."""
        return self.status == "converged"


def transient_simulation_as_json(run: TransientRun) -> dict[str, Any]:
    """Return torque, energy and motion of the balls in a simulation over time as JSON.

    A time step is divided into shorter ones where a ball enters or leaves the loaded arc, or where neighbouring balls meet.
    Time series have the values at the middle of each of these shorter steps, but gaps between balls at its end.
    """
    h = run.history
    reached, asked = (json_number(math.degrees(angle)) for angle in h.reached_and_intended_angle)
    data: dict[str, Any] = {
        "status": run.status,
        "converged": run.converged,
        "complete": h.reached_end,
        "steps": h.begun_step_count,
        "reached_deg": reached,
        "asked_deg": asked,
        "step_error": step_error_as_json(run),
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


def step_error_as_json(run: TransientRun) -> dict[str, Any] | None:
    """Return the estimated errors due to finite time steps as JSON, with order of convergence and numbers of steps.

    None if they are not known.
    """
    if run.error is None:
        return None
    found = run.error.errors_by_quantity
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
        "no_order_seen": list(run.error.quantities_without_order),
        "steps": list(run.error.step_counts),
        "goal_percent": json_number(100.0 * run.allowed_error),
        "small": run.error.all_errors_within(run.allowed_error),
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
