"""What still works where a Python package is not installed: `ONLY_FOR` of `meshes.libraries` says what does not."""

import sys

import pytest
from tests.copies import ROOT
from tests.processes import ran
from tests.slow import all_slow_but

from rollbench.compare.commands.doctor import oldest_package_versions
from rollbench.meshes import libraries

DESIGN = ("--vary", "errors.balls.oversize=4 um:7 um", "--samples", "2")
SWEEP = ("sweep", "two-balls", *DESIGN, "--model", "lin", "--out", "out")
COMPARE = ("compare", "lin-case1", "--model", "lin", "--store", "runs")
#: Package, command, exit code, words of its output; `.ci/extras` installs each extra by itself and tries the commands.
CASES = [
    ("scikit-fem", ("check", "--printed"), 2, "pip install 'rollbench[reference]'"),
    ("scikit-fem", COMPARE, 0, "compare.svg"),
    ("matplotlib", SWEEP, 0, "and no figure (matplotlib is not installed: pip install 'rollbench[report]')"),
    ("matplotlib", COMPARE, 0, "no figure (matplotlib is not installed"),
]


def run(words, folder, before=(sys.executable, "-m", "tests.without"), **variables):
    done = ran(*before, *words, cwd=folder, environ=variables)
    return done.returncode, done.stdout + done.stderr


@pytest.mark.parametrize(("package", "words", "code", "said"), all_slow_but([CASES[0]], CASES))
def test_commands_without_a_package(package, words, code, said, tmp_path):
    found, text = run([package, *words], tmp_path, PYTHONPATH=str(ROOT))
    assert (found, said in text, "Traceback" in text) == (code, True, False), text


def test_every_package_that_may_be_absent_is_of_an_extra():
    assert set(libraries.ONLY_FOR) == set(libraries.EXTRA) <= set(oldest_package_versions())
