"""What a command answers, and the one printer of answers: text for people, or one JSON value."""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from rollbench.compare.errors import escaped

#: A column of a table on the terminal: key of the row, heading, format.
Column = tuple[str, str, str]


@dataclass(frozen=True)
class Answer:
    """What a command answers. data: JSON-ready value, or a function that gives it where JSON is asked for; parts: texts and
    tables of rich, printed as they come; code: exit code; folded: texts wrapped to `text_width` off a terminal too."""

    data: Any = None
    parts: Iterable[Any] = ()
    code: int = 0
    folded: bool = False


def print_answer(answer: Answer, as_json: bool = False) -> int:
    """Print an answer on standard output; its exit code. Raises OutputLost."""
    if as_json:
        print_json(answer.data() if callable(answer.data) else answer.data)
    else:
        _show(answer.parts, folded=answer.folded)
    return answer.code


class OutputLost(Exception):
    """Standard output cannot be written: full, or taken away."""


@contextmanager
def writing() -> Iterator[None]:
    """Writing to standard output: any failure but a pipe without reader raises OutputLost."""
    try:
        yield
    except BrokenPipeError:
        raise
    except OSError as error:
        raise OutputLost(error.strerror or str(error)) from error


def print_json(value: Any) -> None:
    """Print one JSON value on standard output. Raises ValueError for a number that is not finite, OutputLost."""
    text = json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    with writing():
        sys.stdout.write(text)


def _show(parts: Iterable[Any], *, folded: bool) -> None:
    """On a terminal texts wrapped, and tables taken apart, to its width; elsewhere texts as they are unless folded, and
    tables without rules, 160 columns wide or as their words need."""
    from rollbench.compare.text.wrapping import wrapped

    terminal = sys.stdout.isatty()
    for part in parts:
        if not isinstance(part, str):
            _show_table(part, terminal)
            continue
        text = wrapped(part, text_width()) if folded else part
        text = "\n".join(map(escaped, text.split("\n")))  # names of files
        with writing():
            print(wrapped(text, text_width()) if terminal else text)


def _show_table(table: Any, terminal: bool) -> None:
    """A table of rich, which texts do not load."""
    from rich.console import Console

    from rollbench.compare.text.wrapping import fitted, unbroken

    console = Console(width=None if terminal else 160, soft_wrap=True, highlight=False, markup=False)
    tables = fitted(table, text_width()) if terminal else [table]
    if not terminal:
        table.box, table.pad_edge = None, False
        console.width = max(160, unbroken(table))
    with writing():
        console.print(*tables, sep="\n")


def text_width() -> int:
    """Width of running text: the terminal's, 100 where standard output is none."""
    return shutil.get_terminal_size((100, 24)).columns if sys.stdout.isatty() else 100


def on_terminal(text: str) -> None:
    """A line of progress, on standard error."""
    print(text, file=sys.stderr, flush=True)


def cell(value: Any, form: str) -> str:
    """A value as text; a number that is rounded to zero has no minus.

    >>> cell(-0.001, ".2f"), cell(-0.001, "+.2f"), cell(-0.001, ".2g"), cell(-3, "d"), cell(None, "s")
    ('0.00', '+0.00', '-0.001', '-3', '–')
    """
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if form == "s" or not isinstance(value, float):
        return str(value) if form == "s" else format(value, form)
    sign = form[:1] if form[:1] in "+- " else ""
    return format(value, f"{sign}z{form.removeprefix(sign)}")
