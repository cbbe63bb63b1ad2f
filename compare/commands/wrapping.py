"""Lines wrapped to the width of a terminal."""

from __future__ import annotations

import textwrap


def wrapped(text: str, width: int) -> str:
    """A line wrapped at words, what follows indented; texts of several lines as they are."""
    if "\n" in text or len(text) <= max(width, 40):
        return text
    return textwrap.fill(text, max(width, 40), subsequent_indent="  ", break_on_hyphens=False)
