"""The section of friction on the page of one's own screw: torque over the turn, losses, effect of coefficient and play."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rollbench.compare.errors import InputError
from rollbench.compare.models.registry import DEFAULT, Options, run_model
from rollbench.compare.studies.friction.band import MEASURED, Solved
from rollbench.compare.studies.friction.output import lines_of, loss_rows
from rollbench.compare.studies.friction.run import Run, solve_run
from rollbench.compare.studies.friction.whole import drag_torques, status_of
from rollbench.lowfi.friction.whole.losses import CAUSES
from rollbench.lowfi.friction.whole.settings import ONE_TURN
from rollbench.lowfi.friction.whole.state import friction_state
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.parts import Motion, Scene, Time
from rollbench.reports.content import Figure, Panel, Quantity, Row, Section, Series, Table, Text

#: Steps of the run over the turn that the page shows where the scene has none of its own.
STEPS = 24
#: How much balls are larger in radius than the scene says [m], at the points of the figure.
PLAY = (-10e-6, -5e-6, -2e-6, 0.0, 2e-6)


def section(scene: Scene, result: StaticResult, options: Options) -> Section | None:
    """Friction of a solved scene that names a coefficient; None for one that does not, or without friction's balance."""
    if scene.friction is None:
        return None
    motion = scene.motion or ONE_TURN
    bare = run_model(replace(scene, loads=()), DEFAULT, options) if scene.loads else result
    solved = Solved(scene, DEFAULT, options, scene.friction, motion, bare)
    try:
        state = friction_state(scene, result, scene.friction, motion, options.member)
    except ValueError as error:  # balls that overlap by their random sizes
        return Section("friction", "Friction", (Text((f"No friction: {error}.",)),))
    if not state.settled:
        return Section("friction", "Friction", (Text((f"No friction: {status_of(state)}.",)),))
    (drag,) = drag_torques(scene, [state], [scene.friction], bare, options)
    lines = lines_of(motion, state, (drag.torque, drag.reason or drag.note))
    panels, notes = [_over_coefficient(solved, result), _over_play(solved)], [f"{label}: {text}." for label, text in lines]
    try:
        run = solve_run(replace(scene, time=_turn(scene, motion)), scene.friction, motion, DEFAULT, options.member)
    except InputError as error:  # circuits that cannot be
        notes.append(f"No run in time: {error}.")
    else:
        panels[:0] = _over_turn(run)
        notes += [] if run.converged else [f"Run in time: {run.status}."]
    rows: list[Row] = [
        {
            Quantity("contact", "contact", "", "s"): row["contact"],
            Quantity("loss_W", "loss", "W", ".3g"): row["loss_W"],
            **{Quantity(cause, cause.replace("_", " "), "W", ".3g"): row[cause] for cause in CAUSES},
        }
        for row in loss_rows(state)
    ]
    caption = (
        "Grooves and neighbours over the angle of the turning part; friction torque over the coefficients "
        f"of lubricated contacts, {MEASURED[0]:g} to {MEASURED[1]:g}, and over ball radii near the scene's."
    )
    return Section(
        "friction",
        "Friction",
        (
            Text(tuple(notes), bullets=True),
            Figure("friction", "Friction torque over the turn, the coefficient and the play", tuple(panels), caption, 3),
            Table.of("losses", "Losses by contact and cause", rows),
        ),
    )


def _turn(scene: Scene, motion: Motion) -> Time:
    """The scene's own run, or one turn; a bearing's balls come round again after the angle from one to the next."""
    angle = 2.0 * np.pi / (scene.ball_count if scene.track.lead == 0.0 else 1.0)
    return scene.time or Time(duration=abs(angle / motion.speed), steps=STEPS, goal=1.0, output="torque")


def _over_turn(run: Run) -> list[Panel]:
    """Torque over the angle, with that of only the grooves; none where the run did not begin."""
    h = run.history
    if not h.begun:
        return []
    angle = np.degrees(h.turned).tolist()
    series = (
        Series("all", angle, (1e3 * h.torque).tolist(), "line", emphasis=True),
        Series("grooves", angle, (1e3 * h.groove_torque).tolist(), "line"),
    )
    return [Panel("over the turn", "angle / deg", "friction torque / N mm", series, zero=True)]


def _over_coefficient(solved: Solved, result: StaticResult) -> Panel:
    """Torque over the coefficients that are measured, with the scene's own."""
    given = solved.friction
    values = np.geomspace(*MEASURED, 7)
    torques = [1e3 * solved.torque(result, replace(given, screw=mu, nut=mu, balls=None)) for mu in values]
    this_scene = Series("this scene", [max(given.screw, given.nut)], [1e3 * solved.torque(result, given)], "markers")
    series = (Series("equal coefficients", values.tolist(), torques, emphasis=True), this_scene)
    return Panel("over the coefficient", "coefficient of friction", "friction torque / N mm", series, log="x", zero=True)


def _over_play(solved: Solved) -> Panel:
    """Torque with balls larger or smaller than the scene's."""
    scene, torques = solved.scene, []
    for play in PLAY:
        balls = replace(scene.errors.balls, oversize=scene.errors.balls.oversize + play)
        other = replace(scene, errors=replace(scene.errors, balls=balls))
        found = run_model(other, solved.model, replace(solved.options, discretisation=False))
        torques.append(1e3 * solved.torque(found, solved.friction, other))
    series = (Series("this coefficient", [1e6 * play for play in PLAY], torques, emphasis=True),)
    return Panel("over the play", "balls larger in radius by / um", "friction torque / N mm", series, zero=True)
