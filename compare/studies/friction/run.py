"""Friction of a whole screw over time: simulation with several step sizes, from which the error of the steps follows."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from rollbench.compare.errors import ArgumentError, SceneNotCoveredError
from rollbench.compare.results.friction_run import QUANTITIES, TransientRun
from rollbench.compare.running import progress_bar
from rollbench.lowfi.friction.screw import travel
from rollbench.lowfi.friction.whole.circuit import balls_in_circuits
from rollbench.lowfi.friction.whole.run import MODELS_OVER_TIME, SceneInMotion, load_solver_for_travelling_balls
from rollbench.meshes.errors import draw_errors
from rollbench.meshes.parts import Friction, Motion, Scene, Time


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
        balls = balls_in_circuits(scene, motion, drawn, specimen)
    except ValueError as error:
        advice = "give the circuits more room by [circulation]"
        raise SceneNotCoveredError(scene.name, "circulation", str(error), advice) from error
    ahead = float(np.sign(balls.groove.nominal_orbit - balls.groove.nut_speed)) or 1.0
    loads = load_solver_for_travelling_balls(model, ahead)
    solve = partial(loads, scene)
    setting = SceneInMotion(
        **vars(balls), scene=scene, friction=friction, drive=motion, random_errors=drawn, solve_contact_loads=solve
    )
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
    return TransientRun(history, error, time.goal, status, time.output == "balls")
