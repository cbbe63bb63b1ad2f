"""Options and help of ``rollbench friction``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from rollbench.compare.commands.arguments.terminal import Flag, Json, Word, app
from rollbench.compare.commands.printing import print_answer


@app.command
def friction(
    scene: str,
    *,
    model: Word = "",
    mu: Annotated[list[float] | None, Parameter(negative="")] = None,
    member: int = 0,
    condensed: Path | None = None,
    balls: Flag = False,
    time_limit: float | None = None,
    strict: Flag = False,
    assumptions: Flag = False,
    as_json: Json = False,
) -> int:
    """Friction of a screw or bearing at its static loads: ball motion, losses, friction torque, efficiency, drag.

    Also solves the kinds of scenes that only friction solves: balls of a rotary or linear bearing, two balls or a whole
    ball screw in time, bearings in pairs; these take --time-limit, --strict, --assumptions and --json only.

    Parameters
    ----------
    scene
        Name of a shipped scene of any kind, or a scene file.
    model
        Model of the contact loads: refined unless given, or "condensed" where its file is given; see: rollbench list.
    mu
        Coefficient of friction in place of the scene's; several: a table over them, with the balls of the first.
    member
        Which specimen of a scene with random errors.
    condensed
        File that rollbench condense made of these parts: bodies of a condensed 3D model, for the model "condensed".
    balls
        Also print motion, loads and losses of every ball.
    time_limit
        Seconds after which to give up, with exit code 1; none unless given.
    strict
        Exit code 1 where a line WARNING stands above the answers: pressure, preload, static safety or rotations beyond
        what the models mean, or a play that nobody stated.
    assumptions
        Also print the assumptions, what is left out, the balance and the solver.
    """
    from rollbench.compare.wings.friction.solve import run_friction
    from rollbench.compare.wings.friction.whole import Choices

    choices = Choices(model, tuple(mu or ()), member, condensed)
    found = run_friction(scene, choices, balls=balls, details=assumptions, time_limit=time_limit, strict=strict)
    return print_answer(found, as_json)
