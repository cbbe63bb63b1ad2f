"""Lines wrapped to the width of a terminal."""

from __future__ import annotations

import re
import textwrap

#: Width below which lines are not wrapped.
LEAST = 40


def wrapped(text: str, width: int) -> str:
    """A text whose lines are wrapped at words; what follows stands below the text behind a label, or is indented by two.

    >>> print(wrapped("ok    a sentence that is too long for a terminal of forty", 40))
    ok    a sentence that is too long for a
          terminal of forty
    """
    return "\n".join(_wrapped(line, max(width, LEAST)) for line in text.split("\n"))


def _wrapped(line: str, width: int) -> str:
    if len(line) <= width:
        return line
    label = re.match(r" *\S+  +(?=\S)", line)
    indent = len(label[0]) if label and len(label[0]) <= width // 2 else len(line) - len(line.lstrip()) + 2
    return textwrap.fill(line, width, subsequent_indent=" " * indent, break_on_hyphens=False)
