import re

import pytest
from tests.copies import ROOT
from tests.processes import COMMAND, ran

from rollbench.compare import running

SLOW = ROOT / "tests/property/scenes/extreme-2513.toml"


@pytest.mark.parametrize("words", [("solve", SLOW, "--model", "lin"), ("friction", "lin-screw-run")], ids=lambda w: w[0])
def test_a_limit_of_time_ends_a_solution_in_one_line(words):
    done = ran(*COMMAND, *words, "--time-limit", "0.05", "--json", timeout=120)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.splitlines()[-1].endswith("stopped, because the time limit of 0.05 s is reached")
    assert "Traceback" not in done.stderr


def test_a_limit_that_is_not_reached_changes_nothing(command):
    assert command.answer("solve", "lin-case1", "--model", "lin", "--time-limit", "600")["status"] == "converged"


def test_a_bar_says_on_a_terminal_what_is_done_and_leaves_nothing(monkeypatch, capsys):
    monkeypatch.setattr(running, "FIRST", 0.0)
    for terminal in (False, True):
        monkeypatch.setattr(running.sys.stderr, "isatty", lambda shown=terminal: shown)
        with running.progress_bar("my.toml") as progress:
            for k in range(3):
                progress("50 steps", 0.5 * k)
        shown = capsys.readouterr().err
        assert terminal or shown == ""
    bars = re.findall(r"\[([#.]+)\]", shown)
    assert [bar.count("#") / len(bar) for bar in bars] == [0.0, 0.5, 1.0]
    assert "my.toml: 50 steps" in shown
    assert shown.endswith("\r\033[K")
    running.show_progress_message("meshes [1/2]")
    assert "meshes [1/2]" in capsys.readouterr().err
