"""Records of the friction of single parts: balls of a screw or bearing, two bearings, a screw over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from rollbench.compare.models.friction_torques import fraction_in_percent
from rollbench.compare.quantities import json_number
from rollbench.compare.results.friction import Friction
from rollbench.compare.results.friction_run import TransientRun, step_error_as_json, transient_simulation_as_json
from rollbench.meshes.quantity import QuantityDescription, quantity_field, quantity_or_none, result_record


@result_record(kw_only=True)
class BallPair:
    """Contact of two neighbouring balls."""

    balls: str = quantity_field("balls")
    """Numbers of the two balls."""
    gap: float | None = quantity_or_none("gap_um", "gap between two neighbouring balls", optional=True)
    """Gap between the balls [m]."""
    force: float = quantity_field("force_N", "force of one ball on its neighbour")
    """Force of one ball on the other [N]."""
    loss: float | None = quantity_or_none("loss_mW", "power lost between two neighbouring balls", optional=True)
    closing_apart: float | None = quantity_or_none(
        "closing_apart_rad_s",
        "speed at which the azimuths of two balls of a screw that do not touch approach each other",
        optional=True,
    )


@result_record(eq=False, repr=False, kw_only=True)
class FrictionOfNeighbours(Friction):
    """Friction of balls in a row that touch, compared with the same balls far apart."""

    hertz: str | None = quantity_or_none("hertz")
    """Which Hertz constants the contacts have, as in the scene file."""
    coupling: str | None = quantity_or_none("coupling")
    """Balance of loads that includes friction, as in the scene file."""
    pairs: tuple[BallPair, ...] = quantity_field("pairs")
    """Contacts of neighbouring balls."""
    loss_apart: float = quantity_field("loss_apart_W", "power lost if the balls are far apart")
    increase: float | None = quantity_field(
        "friction_increase_percent", "change of the power lost by contact between balls"
    )
    """Change of the power lost by contact between balls [%]; None if the power is round-off without."""
    between_balls_percent: float | None = quantity_field(
        "ball_to_ball_percent", "power lost between balls over that lost if the balls are far apart"
    )
    between_balls: float = quantity_field("ball_to_ball_loss_W", "power lost between balls")
    load_imbalance: float = quantity_field(
        "solver.load_imbalance_N",
        "largest unbalanced force of the contact loads",
        QuantityDescription("solver.load_imbalance", "the same over the vertical force on a linear bearing"),
    )
    """Largest unbalanced force of the contact loads [N]; of a linear bearing, over its vertical force."""


@result_record(eq=False, repr=False, kw_only=True)
class FrictionOfTwoBalls(FrictionOfNeighbours):
    """Friction of two neighbouring balls of a ball screw."""

    deviation: Sequence[float] = quantity_field("deviation_deg")
    """Deviations of the contact angles that the scene states [rad]."""
    oversize: float = quantity_field("oversize_um")
    """Oversize of the ball radius that the scene states [m]."""
    load_sums: Sequence[float] = quantity_field("load_sum_N", "sum of the contact loads of a ball", parts="[]")
    friction_imbalance: float = quantity_field(
        "solver.friction_imbalance_N", "largest unbalanced force of friction on a ball"
    )
    friction_change: float = quantity_field(
        "solver.feedback_change_N", "change of a friction force in the last round between loads and friction"
    )
    rounds: int = quantity_field("solver.rounds", "number of rounds between loads and friction")


@result_record(eq=False, repr=False, kw_only=True)
class JammedState:
    """Second equilibrium of a row of touching balls, in which friction jams them."""

    carriage_force: float = quantity_field("drive_N")
    """Force that drives the carriage [N]."""
    pairs: tuple[BallPair, ...] = quantity_field("pairs")
    """Those forces between neighbouring balls that differ from the first equilibrium."""


@result_record(eq=False, repr=False, kw_only=True)
class FrictionOfLinearBearing(FrictionOfNeighbours):
    """Friction of a row of balls in a linear bearing."""

    distribution: str = quantity_field("distribution")
    """How the loads are distributed to the contacts, as in the scene file."""
    carriage_force: float = quantity_field("drive_N", "force that drives the carriage")
    carriage_force_apart: float = quantity_field(
        "drive_apart_N", "force that drives the carriage if the balls are far apart"
    )
    second_state: JammedState | None = quantity_field("second_state")
    """Second equilibrium, in which friction jams the balls; None if none was found."""
    second_state_words: str = quantity_field("second_state_words")
    """Sentence on the search for it."""
    motion_residual: float = quantity_field(
        "solver.residual", "largest unbalanced force of friction on a ball over its bound"
    )
    lag: float = quantity_field("solver.lag", "largest violation of the gaps over the carriage's speed")
    iterations: int = quantity_field("solver.iterations", "number of steps of the solver")


@result_record(eq=False, repr=False, kw_only=True)
class FrictionOfBearingBall(Friction):
    """Friction of one ball of a bearing."""

    hertz: str = quantity_field("hertz")
    """Which Hertz constants the contacts have, as in the scene file."""
    load_sum: float = quantity_field("load_sum_N", "sum of the contact loads of the ball")
    load_imbalance: float = quantity_field("solver.load_imbalance_N", "largest unbalanced force of the contact loads")
    friction_imbalance: float = quantity_field(
        "solver.friction_imbalance_N", "largest unbalanced force of friction on a ball"
    )
    load_steps: int = quantity_field("solver.load_steps", "number of steps of the solver of the contact loads")
    motion_steps: int = quantity_field("solver.motion_steps", "number of steps of the solver of the ball's motion")
    motion: str = quantity_field("solver.motion")
    """How the motion of the ball was found."""


@result_record(kw_only=True)
class TorquesOfBearing:
    """Friction torque of a bearing over the angle of its load."""

    torque: Sequence[float] = quantity_field("friction_torque_Nmm", "friction torque at each angle of the load", parts="[]")
    beyond: Sequence[int] = quantity_field(
        "balls_beyond_two_contacts", "number of balls with more than two contacts", parts="[]"
    )
    variation: float | None = quantity_field(
        "largest_over_smallest", "largest friction torque over the smallest; null without friction"
    )
    converged: Sequence[bool] = quantity_field("converged")
    """Whether the solution at each angle converged."""


@result_record(eq=False, repr=False, kw_only=True)
class FrictionOfTwoBearings(Friction):
    """Friction of a four-point and a double-row bearing under the same force, over the angle of the force."""

    hertz: str = quantity_field("hertz")
    """Which Hertz constants the contacts have, as in the scene file."""
    force: float = quantity_field("force_N")
    """Force on each bearing [N]."""
    tilt: bool = quantity_field("tilt")
    """Whether the inner ring can tilt."""
    load_angle: Sequence[float] = quantity_field("load_angle_deg")
    """Angles of the force [rad]."""
    four_point: TorquesOfBearing | None = quantity_or_none("four_point")
    """Friction torques of the four-point bearing; None without equilibrium."""
    double_row: TorquesOfBearing | None = quantity_or_none("double_row")
    """Friction torques of the double-row bearing; None without equilibrium."""
    ratio: Sequence[float | None] = quantity_field(
        "four_over_double",
        "friction torque of the four-point bearing over that of the double-row one",
        parts="[]",
        default=(),
    )
    load_imbalance: float | None = quantity_or_none(
        "solver.load_imbalance_N", "largest unbalanced force of the contact loads"
    )


@result_record(kw_only=True)
class ScrewRunContacts:
    """Summary of a whole screw over time; None where no balls touch."""

    largest_ratio: float = quantity_field(
        "largest_ball_to_groove_percent",
        "largest ratio over time of the friction torque by contact between balls to that of the grooves",
        show=fraction_in_percent,
    )
    angle_of_largest: float | None = quantity_field("largest_at_deg", "angle of the nut at this largest ratio")
    begins: float | None = quantity_field("contact_begins_deg", "angle of the nut where contact between balls begins")
    ends: float | None = quantity_field(
        "contact_ends_deg", "angle of the nut where contact first ends after the largest ratio"
    )
    ends_within: float | None = quantity_field("contact_ends_within_deg", "uncertainty of this angle")
    groups: int = quantity_field("largest_groups", "largest number of groups of touching balls")
    torque: float = quantity_field("mean_torque_Nmm", "mean friction torque")
    groove_torque: float = quantity_field("mean_groove_torque_Nmm", "part of the grooves in the mean torque")
    ball_torque: float = quantity_field("mean_ball_torque_Nmm", "part of the contact between balls in the mean torque")
    closing_torque: float = quantity_field(
        "mean_closing_torque_Nmm", "part of the closing gaps between balls in the mean torque"
    )
    variation: float = quantity_field(
        "groove_variation_percent", "variation of the torque of the grooves", show=fraction_in_percent
    )
    ball_force: float = quantity_field("largest_ball_force_N", "largest force between balls")
    order_kept: bool = quantity_field("order_kept")
    """Whether no ball passes the next one."""
    gap: float = quantity_field("smallest_gap_um", "smallest gap between balls")
    occupation: float = quantity_field(
        "occupation_percent", "part of the loaded track that all balls fill", show=fraction_in_percent
    )


def _series_as_json(run: TransientRun) -> dict[str, Any]:
    """Return the time series of a screw's simulation as JSON; time and angle are those of the middle of a step."""
    h = run.history
    values = {
        "time_s": h.time,
        "nut_angle_deg": np.degrees(h.nut_angle),
        "groove_torque_Nmm": 1e3 * h.groove_torque,
        "ball_torque_Nmm": 1e3 * (h.ball_torque + h.closing_torque),
        "ball_to_groove_percent": 100.0 * h.ball_to_groove_ratio,
        "largest_ball_force_N": h.ball_force.max(axis=1),
        "smallest_gap_um": 1e6 * h.setting.groove.radius * h.gap.min(axis=1),
        "balance_percent": 100.0 * h.imbalance,
    }
    out: dict[str, list[Any]] = {name: [json_number(v) for v in row] for name, row in values.items()}
    out |= {"contacts": h.presses_on_next.sum(axis=1).tolist(), "groups": h.touching_group_counts.tolist()}
    return out | {"converged": h.converged.tolist()}


@result_record(eq=False, repr=False, kw_only=True)
class FrictionOfScrewRun(Friction):
    """Friction of a whole ball screw over time."""

    hertz: str = quantity_field("hertz")
    """Which Hertz constants the contacts have, as in the scene file."""
    coupling: str = quantity_field("coupling")
    """Balance of loads that includes friction, as in the scene file."""
    ball_count: int = quantity_field("ball_count")
    """Number of balls."""
    duration: float = quantity_field("duration_s")
    """Duration of the simulation [s]."""
    amplitude: float = quantity_field("amplitude_deg")
    """Amplitude of the deviations of the contact angles that the scene states [rad]."""
    oversize: float = quantity_field("oversize_um")
    """Oversize of the ball radius that the scene states [m]."""
    summary: ScrewRunContacts = quantity_field("summary")
    """Contacts between balls and mean torques."""
    largest_imbalance: float | None = quantity_field(
        "energy.largest_step_balance_percent", "largest error of the balance of power in a step", show=fraction_in_percent
    )
    """Largest error of the balance of power in a step over the power lost; None if that power is round-off."""
    friction_change: float = quantity_field(
        "solver.feedback_change_N", "change of a friction force in the last round between loads and friction"
    )
    run: TransientRun = quantity_field(
        "run",
        "",
        QuantityDescription("steps", show=lambda run: run.history.steps),
        QuantityDescription("series", show=_series_as_json),
        QuantityDescription("step_error", show=step_error_as_json),
        QuantityDescription("solver.failed_steps", show=lambda run: int(np.sum(~run.history.converged))),
        show=transient_simulation_as_json,
    )
    """The simulation over time."""
