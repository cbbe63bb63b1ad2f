"""All numbers that commands answer for shipped scenes of every kind: they guard against change, as those beside them.

Of the numbers of one name in an answer, whatever list they stand in, their count and two weighted means are kept. Whoever
changes them on purpose writes them again with ``python -m tests.golden.test_answers`` and says why in the commit.
"""

import contextlib
import io
import json
import re
import shlex
import tempfile
from pathlib import Path

import pytest
from tests.golden.means import means, same

from rollbench.compare.cli import main

RECORD = Path(__file__).parent / "answers.json"
ANSWERS = (
    "solve lin-combined --model lin",
    "solve lin-case1 --model source",
    "solve lin-case2 --model mei-nut",
    "solve lin-case3-offset",
    "solve unseen-32x10",
    "solve unseen-63x20 --model lin-nut",
    "solve unseen-hollow --model lin-cell",
    "solve unseen-flange",
    "solve lin-random --members 12 --model lin",
    "solve lin-random --members 4",
    "solve bearing-9-preload",
    "solve unseen-four-point",
    "solve two-balls --model lin",
    "solve axis-fixed-fixed --model lin",
    "solve double-nut",
    "solve smith-axis-taper --model lin",
    "solve lin-steering-rack --model lin",
    "solve external-harris-218",
    "friction lin-case3-offset --mu 0.1",
    "friction unseen-four-point --mu 0.1",
    "friction axis-fixed-fixed --mu 0.1 --model lin",
    "friction lin-rotary-1",
    "friction lin-rotary-2",
    "friction lin-rotary-3",
    "friction lin-bearing-pairs",
    "friction lin-pair-worst",
    "friction lin-chain-10",
    "friction lin-screw-pair-a",
    "friction lin-screw-run",
    "solve lin-case3-offset --model lin --stiffness-at '200 mm'",
    "solve unseen-hollow --stiffness-at '200 mm'",
    "solve lin-case3-tolerances --members 20 --model lin",
    "solve axis-fixed-fixed",
    "solve liu-drawn --model mei",
    "friction double-nut",
    "friction lin-pair-b",
    "friction lin-screw-pair-b-inferred",
    "compare lin-case1",
    "compare lin-case3-offset",
    "compare two-balls",
    "compare lin-pair-a",
    "mesh-study lin-case2 --levels 4",
    "mesh-study lin-screw-pair-a",
    "check lin-case3-offset --no-compute",
)
#: What machines, engines and round-off decide, which of equal balls or rollers is named, and the friction that `solve` has
#: only where kernels are compiled or it was kept; the version of the keys.
LEFT_OUT = re.compile(
    r"second|residual|iteration|memory|version|balance|equilibrium|round_off|evaluations|ball$|roller$|^\.summary\.friction$|^\.schema$"
)


def kept(command):
    """Means of all numbers that a command answers as JSON, in an empty folder."""
    said, unsaid = io.StringIO(), contextlib.redirect_stderr(io.StringIO())
    with (
        tempfile.TemporaryDirectory() as folder,
        contextlib.chdir(folder),
        contextlib.redirect_stdout(said),
        unsaid,
        pytest.raises(SystemExit),
    ):
        main([*shlex.split(command), "--json"])
    return means(json.loads(said.getvalue()), LEFT_OUT.search)


def marked(command):
    """A command with its mark: friction is marked as further."""
    return pytest.param(command, marks=pytest.mark.further if command.startswith("friction") else ())


@pytest.mark.usefixtures("friction_of_solve")
@pytest.mark.parametrize("command", [marked(command) for command in ANSWERS])
def test_no_number_of_an_answer_moves(command):
    expected = json.loads(RECORD.read_text(encoding="utf-8"))[command]
    same(kept(command), expected)


if __name__ == "__main__":
    lines = [f"{json.dumps(command)}: {json.dumps(kept(command))}" for command in ANSWERS]
    RECORD.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
