import pytest
from tests.copies import ROOT
from tests.processes import COMMAND, ran

SLOW = ROOT / "tests/property/scenes/extreme-2513.toml"


@pytest.mark.parametrize("words", [("solve", SLOW, "--model", "lin"), ("friction", "lin-screw-run")], ids=lambda w: w[0])
def test_a_limit_of_time_ends_a_solution_in_one_line(words):
    done = ran(*COMMAND, *words, "--time-limit", "0.05", "--json", timeout=120)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.splitlines()[-1].endswith("stopped, because the time limit of 0.05 s is reached")
    assert "Traceback" not in done.stderr


def test_a_limit_that_is_not_reached_changes_nothing(command):
    assert command.answer("solve", "lin-case1", "--model", "lin", "--time-limit", "600")["status"] == "converged"
