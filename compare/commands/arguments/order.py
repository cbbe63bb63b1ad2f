"""The order of commands in ``rollbench --help``: by what one wants, the first steps first."""

from __future__ import annotations

import inspect
import re

from cyclopts import App, Group

#: Headings and the commands below them, in order.
ORDER = {
    "Start here": ("new", "solve", "friction", "report", "verify", "doctor"),
    "How far to trust it": ("compare", "check", "mesh-study"),
    "Many scenes": ("sweep",),
    "To and from other programs": ("export", "condense", "crosscheck", "schema"),
    "This program and its sources": ("list", "audit", "stability", "bench", "completion"),
}


def unwrapped(doc: str | None) -> str:
    """A docstring with every paragraph on one line, for help to wrap at the width of the terminal.

    >>> unwrapped("Solve.\\n\\nParameters\\n----------\\nscene\\n    A name,\\n    or a file.").splitlines()[-1]
    '    A name, or a file.'
    """
    paragraph = r"(?m)^( *)(?!-+$|Parameters$)\S.*(?:\n\1\S.*)+"
    return re.sub(paragraph, lambda match: re.sub(r"\n *", " ", match[0]), inspect.cleandoc(doc or ""))


def arrange(app: App) -> None:
    """Put the commands of ``app`` under headings; one that `ORDER` does not name stays under "Commands"."""
    for place, (heading, names) in enumerate(ORDER.items()):
        group = Group(heading, sort_key=place)
        for number, name in enumerate(names):
            if name in app:
                app[name].group = (group,)
                app[name].sort_key = number
                command = app[name].default_command
                command.__doc__ = unwrapped(command.__doc__)
    besides = Group("Besides", sort_key=len(ORDER))
    for flag in ("--help", "--version"):
        app[flag].group = (besides,)
