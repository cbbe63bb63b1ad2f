"""All numbers that commands answer for shipped scenes of every kind: they guard against change, as those beside them.

Of the numbers of one name in an answer, whatever list they stand in, their count and two weighted means are kept. Whoever
changes them on purpose writes them anew with ``python -m tests.golden.test_answers`` and says why in the commit.
"""

import contextlib
import io
import json
import re
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest

from rollbench.comparison.cli import main

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
)
#: What machines, engines and round-off decide, which of equal balls is named, and the friction that `solve` has only where
#: kernels are compiled or it was kept.
LEFT_OUT = re.compile(
    r"second|residual|iteration|memory|version|balance|equilibrium|round_off|evaluations|ball$|^\.summary\.friction$"
)
#: Relative, and what is round-off in every unit of an answer.
TOLERANCE, ROUND_OFF = 1e-6, 1e-9


def leaves(value, name=""):
    """Names and values of an answer's numbers; places in lists are no part of a name."""
    if isinstance(value, dict):
        for key, below in value.items():
            if not LEFT_OUT.search(f"{name}.{key}"):
                yield from leaves(below, f"{name}.{key}")
    elif isinstance(value, list):
        for below in value:
            yield from leaves(below, name)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield name.removeprefix("."), float(value)


def kept(command):
    """Of each name: how many numbers, their mean size, and their mean weighted by their place."""
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(io.StringIO()), pytest.raises(SystemExit):
        main([*command.split(), "--json"])
    numbers = defaultdict(list)
    for name, value in leaves(json.loads(said.getvalue())):
        numbers[name].append(value)
    out = {}
    for name, values in numbers.items():
        x = np.array(values)
        out[name] = [x.size, *(float(f"{m:.9g}") for m in (np.abs(x).mean(), (x * np.cos(np.arange(x.size))).mean()))]
    return out


@pytest.mark.parametrize("command", ANSWERS)
def test_no_number_of_an_answer_moves(command):
    expected = json.loads(RECORD.read_text(encoding="utf-8"))[command]
    found = kept(command)
    assert not expected.keys() - found.keys()
    for name, (count, size, mean) in expected.items():
        assert found[name] == pytest.approx([count, size, mean], rel=TOLERANCE, abs=max(TOLERANCE * size, ROUND_OFF)), name


if __name__ == "__main__":
    lines = [f"{json.dumps(command)}: {json.dumps(kept(command))}" for command in ANSWERS]
    RECORD.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
