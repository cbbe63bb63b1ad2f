"""``rollbench friction``: whole screws and bearings, several sets on one shaft, and the kinds that only friction solves."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

from rollbench.comparison.commands.answer import Answer, as_table
from rollbench.comparison.errors import InputError, one_line
from rollbench.comparison.scenes import catalogue
from rollbench.comparison.watch import checked, watched
from rollbench.comparison.wings.friction.whole import COMPILING, Choices, coefficients, solve_scene
from rollbench.lowfi.friction.whole.state import will_compile
from rollbench.lowfi.jit import cached
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Scene


def run_friction(
    name: str,
    choices: Choices,
    as_json: bool,
    show: Callable[..., None],
    print_json: Callable[[Any], None],
    *,
    balls: bool = False,
    width: int = 100,
    time_limit: float | None = None,
    strict: bool = False,
) -> int:
    """Solve a shipped scene or a file of any kind and print it, texts wrapped at ``width``; balls: also the table of every
    ball. 1 where it did not converge, the limit of time [s] ended it, or, if ``strict``, a line WARNING stands above the
    answers. Raises InputError."""
    with watched(f"{one_line(name)}, friction", checked(time_limit)):
        answer = solve_friction(name, choices)
    if as_json:
        print_json(answer.data | {"warning": answer.warning or None})
    else:
        show(*as_table(answer, width, balls=balls))
    return 1 if not answer.converged or (strict and answer.warning) else 0


def solve_friction(name: str, choices: Choices) -> Answer:
    """Solve a shipped scene or a file of any kind. Raises InputError."""
    scene = catalogue.any_scene(name)
    if isinstance(scene, Scene):
        if any(will_compile(scene, pair) for pair in coefficients(scene, choices.mu)) and not cached():
            sys.stderr.write(COMPILING)
        return solve_scene(scene, choices)
    if choices != Choices() and not isinstance(scene, Assembly):
        advice = "leave them out: such a scene holds its own loads and coefficients"
        given = "--model, --mu, --member or --condensed"
        raise InputError("command line", given, f"with {name}", "with the scene of a whole screw or bearing", advice)
    if isinstance(scene, Assembly):
        from rollbench.comparison.wings.friction.axis import solve_axis

        return solve_axis(scene, choices)
    from rollbench.comparison.wings.friction.kind_solvers import solve_kind

    return solve_kind(scene)
