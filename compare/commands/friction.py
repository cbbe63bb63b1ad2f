"""The command rollbench friction."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from rollbench.compare.commands.terminal import Flag, Json, Verbose, Word, app
from rollbench.compare.errors import one_line
from rollbench.compare.running import on_terminal
from rollbench.compare.text.printing import Answer, listed, print_answer, text_width

if TYPE_CHECKING:
    from rich.console import RenderableType

    from rollbench.compare.studies.friction.answer import FrictionAnswer
    from rollbench.compare.studies.friction.whole import Choices


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
    verbose: Verbose = False,
    as_json: Json = False,
) -> int:
    """Friction of a screw or bearing at its static loads: ball motion, losses, friction torque, efficiency, drag.

    Also solves the kinds of scenes that only friction solves: balls of a rotary or linear bearing, two balls or a whole
    ball screw in time, bearings in pairs; these take --time-limit, --strict, --verbose and --json only.

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
    verbose
        Also print further quantities, what explains them, the assumptions, what is left out, the balance and the solver.
    """
    from rollbench.compare.studies.friction.whole import Choices

    choices = Choices(model, tuple(mu or ()), member, condensed)
    found = run_friction(scene, choices, balls=balls, details=verbose, time_limit=time_limit, strict=strict)
    return print_answer(found, as_json)


def run_friction(
    name: str,
    choices: Choices,
    *,
    balls: bool = False,
    details: bool = False,
    time_limit: float | None = None,
    strict: bool = False,
) -> Answer:
    """Solve a shipped scene or a file of any kind; balls, details: see `as_table`. Exit code 1 where it did not converge,
    the limit of time [s] ended it, or, if ``strict``, a line WARNING stands above the answers. Raises InputError."""
    from rollbench.compare.results.base import with_schema
    from rollbench.compare.running import checked, watched
    from rollbench.compare.studies.friction.solve import as_json, solve_friction

    with watched(f"{one_line(name)}, friction", checked(time_limit)):
        found = solve_friction(name, choices, lambda line: on_terminal(f"rollbench: {line}"))
    code = 1 if not found.converged or (strict and found.warning) else 0
    return Answer(with_schema(as_json(found)), as_table(found, balls=balls, details=details), code, folded=True)


def as_table(answer: FrictionAnswer, *, balls: bool = False, details: bool = False) -> list[RenderableType]:
    """The answer for the terminal: status, warning, the table of answers, tables, what to do; with details what
    explains the answers, balance, solver, assumptions, and what is left out, else where they are."""
    from rollbench.compare.results.base import as_text
    from rollbench.compare.results.rows import friction_rows
    from rollbench.compare.studies.friction.answer import BEHIND
    from rollbench.compare.text.solved import closing_lines

    data = answer.data
    drawn = "" if data.get("member") is None else f", member {data['member']} of its random errors"
    parts: list[Any] = [f"{data['scene']}{drawn}, {data['kind']}: {data['status']}", data["title"]]
    parts += [*filter(None, [answer.warning])]
    if rows := friction_rows(data):
        parts += ["", as_text(rows, text_width()), ""]
    if lines := [f"{label:<10}{text}" for label, text in answer.lines if details or not (rows or label in BEHIND)]:
        parts += ["", *lines, ""]
    for title, columns, body in [*answer.tables, *(answer.ball_tables if balls else ())]:
        parts += [listed(title, columns, body), ""]
    if answer.ball_tables and not balls:
        parts.append("motion, loads and losses of every ball: --balls")
    warnings = [w for w in data.get("warnings", ()) if w.brief != w]  # what stands above is not said again
    return [*parts, *closing_lines(warnings, (), data.get("assumed", ()), data.get("left_out", ()), details=details)]
