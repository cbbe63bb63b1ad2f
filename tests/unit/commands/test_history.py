"""The answer of a command does not depend on what ran before it in the same home."""

import json
import os
import subprocess
import sys

import pytest

#: Commands whose answers are compared, and those that run before them in one of the homes.
ASKED = (
    ("solve", "axis-fixed-fixed"),
    ("friction", "axis-fixed-fixed", "--model", "lin"),
    ("solve", "lin-random", "--members", "20"),
    ("friction", "lin-case1", "--mu", "0.08"),
)
BEFORE = (
    ("friction", "axis-fixed-fixed", "--model", "lin", "--mu", "0.05"),
    ("solve", "lin-random", "--members", "5", "--model", "lin"),
    ("friction", "lin-case1"),
    ("solve", "lin-case2"),
)

#: Parts of keys whose values may differ: run times, and the day on which something was computed.
OF_THE_CLOCK = ("seconds", "_s_cpu", "time", "date", "day")


def timeless(value: object) -> object:
    """A JSON value without what the clock says."""
    if isinstance(value, dict):
        return {k: timeless(v) for k, v in value.items() if not any(part in k for part in OF_THE_CLOCK)}
    return [timeless(v) for v in value] if isinstance(value, list) else value


def answers(home, commands) -> list[object]:
    """What the commands answer as JSON, each in a process of its own with this home."""
    home.mkdir(exist_ok=True)
    places = {name: str(home) for name in ("HOME", "XDG_CACHE_HOME", "XDG_DATA_HOME", "XDG_CONFIG_HOME")}
    python = [sys.executable, "-m", "rollbench"]
    done = [
        subprocess.run([*python, *tokens, "--json"], capture_output=True, check=True, env=os.environ | places, cwd=home)
        for tokens in commands
    ]
    return [timeless(json.loads(one.stdout)) for one in done]


@pytest.mark.slow
def test_an_answer_is_the_same_whatever_ran_before(tmp_path):
    first = answers(tmp_path / "empty", ASKED)
    answers(tmp_path / "used", BEFORE)
    assert answers(tmp_path / "used", ASKED[::-1])[::-1] == first
