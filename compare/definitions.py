"""Definitions of the output's numbers, from the one file that holds them."""

from __future__ import annotations

import re
from functools import cache
from typing import NamedTuple

from rollbench.compare import data


class Definition(NamedTuple):
    """What a number is (formula and sign where it needs them), and what its error is; empty where it has none."""

    text: str
    error: str


@cache
def _known() -> tuple[tuple[re.Pattern[str], Definition], ...]:
    listed = [one for table in data.table("definitions.toml")["table"] for one in table["quantity"]]
    return tuple((_pattern(one["path"]), Definition(one["is"], one.get("error", ""))) for one in listed)


def _pattern(path: str) -> re.Pattern[str]:
    named = re.escape(path).replace("FLANK", "(SL|SR|NL|NR)").replace(r"\*", r"[^.]+")
    return re.compile(rf"(.*\.)?{named}")


def definition(path: str) -> Definition | None:
    """Definition of a path in a command's JSON, None where it has none; indices of lists may stand in the brackets.

    >>> definition("summary.loads.max_N").text
    'largest contact load'
    """
    path = re.sub(r"\[\d+\]", "[]", path)
    return next((known for pattern, known in _known() if pattern.fullmatch(path)), None)
