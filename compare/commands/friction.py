"""Command ``rollbench friction``: computes ball motion, losses, torque and efficiency of screws and bearings."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from rollbench.compare.commands.terminal import Flag, Json, Verbose, Word, app, check_plot_file, write_plot
from rollbench.compare.errors import one_line
from rollbench.compare.text.printing import CommandOutput, print_command_output, table_of_records, text_width

if TYPE_CHECKING:
    from rollbench.compare.results.friction import Friction


@app.command
def friction(
    scene: str,
    *,
    model: Word = "",
    mu: Annotated[list[float] | None, Parameter(negative="")] = None,
    member: int = 0,
    condensed: Path | None = None,
    balls: Flag = False,
    plot: Path | None = None,
    time_limit: float | None = None,
    strict: Flag = False,
    verbose: Verbose = False,
    as_json: Json = False,
) -> int:
    """Compute ball motion, power losses, friction torque and efficiency of a screw or bearing under its static loads.

    This command also solves kinds of scenes that no other command solves: one ball of a rotary bearing, several balls of a
    linear bearing, two touching balls of a ball screw, a whole ball screw that turns for some time, and a four-point and a
    double-row bearing under the same force. For these, only --time-limit, --strict, --verbose and --json apply.

    Parameters
    ----------
    scene
        Name of a shipped scene of any kind, or a scene file.
    model
        Model that computes the contact loads (rollbench list shows all). Default: refined, or condensed if --condensed is
        given.
    mu
        Coefficient of friction, which replaces that of the scene. For several values, a table over them is printed; the
        results of the balls belong to the first.
    member
        Number of the specimen, from 0, in a scene with random errors.
    condensed
        File that rollbench condense wrote for these parts: the compliance of screw and nut from their 3D meshes, for the
        model "condensed".
    balls
        Also print motion, loads and losses of every ball.
    plot
        File for a figure, SVG: power that each ball loses on each flank, so that one sees which flank takes it.
    time_limit
        Stop after this many seconds, with exit code 1. Default: no limit.
    strict
        Return exit code 1 if a WARNING is printed: the result is outside the models' range of validity (such as contacts
        beyond the groove's arc, pressure, a second, jammed state, or neglected feedback of friction), or the scene states
        neither play nor preload of a screw, and friction depends on the play.
    verbose
        Also print further quantities and explanations, the assumptions, neglected effects, the force balance and data of
        the solver.
    """
    from rollbench.compare.running import checked_time_limit, watch_running_time
    from rollbench.compare.studies.friction.solve import solve_friction_of_named_scene
    from rollbench.compare.studies.friction.whole import FrictionChoices

    if plot is not None:
        check_plot_file(plot)
    with watch_running_time(f"{one_line(scene)}, friction", checked_time_limit(time_limit)):
        found = solve_friction_of_named_scene(scene, FrictionChoices(model, tuple(mu or ()), member, condensed))
    code = 1 if not found.converged or (strict and found.warning) else 0
    parts = friction_terminal_parts(found, balls=balls, details=verbose)
    parts += [] if plot is None else [write_plot(plot, found)]
    return print_command_output(CommandOutput(found.to_dict(), parts, code, wrap_always=True), as_json)


def friction_terminal_parts(found: Friction, *, balls: bool = False, details: bool = False) -> list[Any]:
    """Return the texts and tables in which the terminal shows the friction in a scene.

    ``found``: the computed friction. ``balls``: also the table of all balls. ``details``: also explanations, force
    balance, data of the solver, assumptions and neglected effects; without it, a line refers to --verbose.
    """
    from rollbench.compare.results.base import format_table_as_text
    from rollbench.compare.text.friction import friction_tables, has_table_of_balls, onset_sentences
    from rollbench.compare.text.solved import warning_and_note_lines

    drawn = "" if found.member is None else f", specimen {found.member} of its random errors"
    parts: list[Any] = [f"{found.scene}{drawn}, {found.kind}: {found.reason}", found.title]
    parts += [*filter(None, [found.warning])]
    if rows := found.rows(details=details):
        parts += ["", format_table_as_text(rows, text_width()), ""]
    if sentences := onset_sentences(found):
        parts += [*sentences, ""]
    for title, body in friction_tables(found, balls=balls):
        parts += [table_of_records(body, title=title), ""]
    if not balls and has_table_of_balls(found):
        parts.append("--balls also shows motion, loads and losses of every ball")
    warnings = [w for w in found.warnings if w.brief != w]  # without those that are printed above
    return [*parts, *warning_and_note_lines(warnings, (), found.assumed, found.left_out, details=details)]
