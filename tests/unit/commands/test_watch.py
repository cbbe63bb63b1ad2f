import subprocess
import sys
from pathlib import Path

import pytest

from rollbench.comparison import watch

SCENES = Path(__file__).parents[2] / "property" / "scenes"


def run(*words, timeout=120):
    command = [sys.executable, "-P", "-m", "rollbench", *words]
    return subprocess.run(command, capture_output=True, text=True, timeout=timeout, check=False)


@pytest.mark.parametrize(
    "words",
    [("solve", str(SCENES / "extreme-2513.toml"), "--model", "lin"), ("friction", "lin-screw-run")],
    ids=lambda w: w[0],
)
def test_a_limit_of_time_ends_a_solution_in_one_line(words):
    done = run(*words, "--time-limit", "0.05", "--json")
    assert done.returncode == 1
    assert done.stdout == ""
    assert done.stderr.splitlines()[-1].endswith("stopped: the limit of time, 0.05 s, is reached")
    assert "Traceback" not in done.stderr


def test_a_limit_that_is_not_reached_changes_nothing(command):
    code, found = command.json("solve", "lin-case1", "--model", "lin", "--time-limit", "600", "--json")
    assert (code, found["status"]) == (0, "converged")


def test_a_bar_says_on_a_terminal_what_is_done_and_leaves_nothing(monkeypatch, capsys):
    for terminal in (False, True):
        monkeypatch.setattr(watch.sys.stderr, "isatty", lambda shown=terminal: shown)
        monkeypatch.setattr(watch, "FIRST", 0.0)
        with watch.bar("my.toml") as progress:
            for k in range(3):
                progress("50 steps", 0.5 * k)
        shown = capsys.readouterr().err
        if not terminal:
            assert shown == ""
    assert shown.count("#") == 15 + 30
    assert "my.toml: 50 steps" in shown
    assert " 50 %" in shown
    assert shown.rpartition("\r")[0].rpartition("\r")[2].strip() == ""
