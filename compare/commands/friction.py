"""The command rollbench friction."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from rollbench.compare.commands.terminal import Flag, Json, Verbose, Word, app
from rollbench.compare.errors import one_line
from rollbench.compare.running import on_terminal
from rollbench.compare.text.printing import Answer, listed_table, print_answer, text_width

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
    """Compute the friction of a screw or bearing at its static loads: ball motion, losses, torque, efficiency, drag.

    Also solves the kinds of scenes that only friction solves: balls of a rotary or linear bearing, two balls or a whole
    ball screw over time, bearings in pairs. For these, only --time-limit, --strict, --verbose and --json apply.

    Parameters
    ----------
    scene
        Name of a shipped scene of any kind, or a scene file.
    model
        Model of the contact loads (see: rollbench list). Default: refined, or condensed if --condensed is given.
    mu
        Coefficient of friction; it replaces the scene's. Several values: a table over them, with the balls of the first.
    member
        Number of the sample, for a scene with random errors.
    condensed
        File that rollbench condense made of these parts: condensed 3D bodies, for the model "condensed".
    balls
        Also print motion, loads and losses of every ball.
    time_limit
        Give up after this many seconds, with exit code 1. Default: no limit.
    strict
        Exit with 1 if a WARNING line precedes the answers: pressure, preload, static safety or rotations beyond the
        validity of the models, or a play that the scene does not state.
    verbose
        Also print further quantities and explanations, the assumptions, neglected effects, the balance and the solver.
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
    """Solve a shipped scene or a file of any kind. Raises InputError.

    balls, details: see `as_table`. Exit code 1 where it did not converge, the time limit [s] was reached, or, if
    ``strict``, a line WARNING precedes the answers.
    """
    from rollbench.compare.results.base import with_schema
    from rollbench.compare.running import checked, watched
    from rollbench.compare.studies.friction.solve import answer_json, solve_friction

    with watched(f"{one_line(name)}, friction", checked(time_limit)):
        found = solve_friction(name, choices, lambda line: on_terminal(f"rollbench: {line}"))
    code = 1 if not found.converged or (strict and found.warning) else 0
    return Answer(with_schema(answer_json(found)), as_table(found, balls=balls, details=details), code, folded=True)


def as_table(answer: FrictionAnswer, *, balls: bool = False, details: bool = False) -> list[RenderableType]:
    """Return the answer for the terminal: status, warning, the table of answers, further tables, and advice.

    details: also explanations, balance, solver, assumptions and neglected effects; else a line on how to see them.
    """
    from rollbench.compare.results.base import as_text
    from rollbench.compare.results.rows import friction_rows
    from rollbench.compare.studies.friction.answer import BEHIND
    from rollbench.compare.text.solved import closing_lines

    data = answer.data
    drawn = "" if data.get("member") is None else f", specimen {data['member']} of its random errors"
    parts: list[Any] = [f"{data['scene']}{drawn}, {data['kind']}: {data['status']}", data["title"]]
    parts += [*filter(None, [answer.warning])]
    if rows := friction_rows(data):
        parts += ["", as_text(rows, text_width()), ""]
    if lines := [f"{label:<10}{text}" for label, text in answer.lines if details or not (rows or label in BEHIND)]:
        parts += ["", *lines, ""]
    for title, columns, body in [*answer.tables, *(answer.ball_tables if balls else ())]:
        parts += [listed_table(title, columns, body), ""]
    if answer.ball_tables and not balls:
        parts.append("motion, loads and losses of every ball: --balls")
    warnings = [w for w in data.get("warnings", ()) if w.brief != w]  # what stands above is not said again
    return [*parts, *closing_lines(warnings, (), data.get("assumed", ()), data.get("left_out", ()), details=details)]
