"""A solved scene, of one set or several, as JSON and for the terminal."""

from __future__ import annotations

from typing import Any

from rollbench.comparison.commands.printing import text_width
from rollbench.comparison.commands.solving.solve_output import as_json, as_table, stiffness_json
from rollbench.comparison.commands.solving.summary import answers_json, block
from rollbench.comparison.models.load_cases import Solved, SolvedAxis
from rollbench.lowfi.statics.tangent import Tangent


def case_json(one: Solved | SolvedAxis, tangent: Tangent | None = None) -> dict[str, Any]:
    """A solved scene for JSON; tangent: the stiffness at a station, where it was asked for of one set."""
    if isinstance(one, SolvedAxis):
        from rollbench.comparison.commands.solving import axis_output

        return axis_output.as_json(one.scene, one.result, one.answers, one.result.member)
    answers = None if one.answers is None else answers_json(one.scene, one.result, one.answers)
    if answers is not None and tangent is not None:
        answers["stiffness"] = stiffness_json(tangent.station, tangent.status, tangent.matrix)
    return as_json(one.scene, one.result, one.expected, answers)


def case_table(one: Solved | SolvedAxis, *, balls: bool = False, details: bool = False) -> list[Any]:
    """A solved scene for the terminal; balls: with the table of every ball; details: with what lies behind the answers."""
    if isinstance(one, SolvedAxis):
        from rollbench.comparison.commands.solving import axis_output, axis_summary

        answers = "" if one.answers is None else axis_summary.block(one.scene, one.result, one.answers, text_width())
        return axis_output.as_table(one.scene, one.result, block=answers, balls=balls, details=details)
    speed = None if one.scene.motion is None else one.scene.motion.speed
    text = "" if one.answers is None else block(one.scene, one.result, one.answers, one.expected, text_width(), speed)
    return as_table(one.scene, one.result, one.expected, block=text, balls=balls, details=details)
