"""All numbers that commands answer for shipped scenes of every kind: they guard against change, not against error.

They were written by the code that they test; closed forms, literature and property tests judge whether it is right.

Of the numbers of one name in an answer, whatever list they stand in, their count and two weighted means are kept. Whoever
changes them on purpose writes them again with ``python -m tests.golden.test_answers`` and says why in the commit.
"""

import json
import re
import shlex
from pathlib import Path

import pytest
from tests.golden.means import answered, means, same, write

#: The answers by their commands: a new command is added with an empty answer and written.
RECORD = Path(__file__).parent / "answers.json"
ANSWERS = json.loads(RECORD.read_text(encoding="utf-8"))
#: What machines and round-off decide, how many steps a solver takes, which of equal balls or rollers is named; the version
#: of the keys.
LEFT_OUT = re.compile(
    r"second|residual|iteration|(load|motion)_steps|memory|version|balance|equilibrium|round_off|evaluations|ball$|roller$"
    r"|^\.schema$"
)


def kept(command):
    """Means of all numbers that a command answers as JSON."""
    return means(answered(shlex.split(command))[1], LEFT_OUT.search)


#: Commands that take seconds.
SLOW = {"solve axis-fixed-fixed", "solve double-nut", "solve lin-combined --model lin"}
SLOW |= {"solve axis-fixed-fixed --model lin", "solve lin-case3-offset", "compare lin-case1", "compare lin-case3-offset"}


def marked(command):
    """A command with its marks: friction is marked as further."""
    holds = {"further": command.startswith("friction"), "slow": command in SLOW}
    return pytest.param(command, marks=[getattr(pytest.mark, mark) for mark in holds if holds[mark]])


@pytest.mark.parametrize("command", [marked(command) for command in ANSWERS])
def test_no_number_of_an_answer_moves(command):
    same(kept(command), ANSWERS[command])


if __name__ == "__main__":
    write(RECORD, {command: kept(command) for command in ANSWERS})
