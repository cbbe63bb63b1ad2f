"""Command lines that are refused: exit status 2, nothing on standard output and one line that says why."""

import shlex
import tomllib
from pathlib import Path

import pytest

REFUSED = tomllib.loads(Path(__file__).with_name("refused.toml").read_text(encoding="utf-8"))["refused"]


@pytest.mark.parametrize(("line", "words"), [(line, words) for line, *words in REFUSED])
def test_a_refused_command_line_says_why_in_one_line(command, line: str, words: list[str]) -> None:
    said = command.refused(*shlex.split(line))
    assert [word for word in words if word not in said] == []
