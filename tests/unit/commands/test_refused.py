"""Command lines that are refused: exit status 2, nothing on standard output and one line that says why."""

import shlex
import tomllib
from pathlib import Path

import pytest

REFUSED = tomllib.loads(Path(__file__).with_name("refused.toml").read_text(encoding="utf-8"))["refused"]


@pytest.mark.parametrize(("line", "words"), [(line, words) for line, *words in REFUSED])
def test_a_refused_command_line_says_why_in_one_line(command, line: str, words: list[str]) -> None:
    code, out, err = command(*shlex.split(line))
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert [word for word in words if word not in err] == []
    assert "Traceback" not in err
