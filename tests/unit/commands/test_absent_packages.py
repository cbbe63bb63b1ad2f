"""What still works where a Python package is not installed: `ONLY_FOR` of `meshes.libraries` says what does not."""

import sys

import pytest
from tests.copies import ROOT
from tests.processes import ran
from tests.slow import all_slow_but

from rollbench.compare.commands.doctor import oldest_package_versions
from rollbench.meshes import libraries

CHECK = ("check", "lin-case1", "--no-compute")
DESIGN = ("--vary", "errors.balls.oversize=4 um:7 um", "--samples", "2")
SWEEP = ("sweep", "two-balls", *DESIGN, "--model", "lin", "--out", "out")
COMPARE = ("compare", "lin-case1", "--model", "lin", "--store", "runs")
PAGE = ("report", "two-balls", "--out", "page")
#: Package, command, exit code, words of its output; `.ci/extras` installs each extra by itself and tries the commands.
CASES = [
    ("gmsh", CHECK, 0, "1 pass"),
    ("scikit-fem", ("check", "--printed"), 2, "pip install 'rollbench[reference]'"),
    ("scikit-fem", COMPARE, 0, "compare.svg"),
    ("scikit-fem", PAGE, 0, "index.html"),
    ("matplotlib", SWEEP, 0, "and no figure (matplotlib is not installed: pip install 'rollbench[report]')"),
    ("matplotlib", PAGE, 2, "this computer: matplotlib: got matplotlib is not installed"),
    ("matplotlib", COMPARE, 0, "no figure (matplotlib is not installed"),
]


def run(words, folder, before=(sys.executable, "-m", "tests.without"), **variables):
    done = ran(*before, *words, cwd=folder, environ=variables)
    return done.returncode, done.stdout + done.stderr


@pytest.mark.parametrize(("package", "words", "code", "said"), all_slow_but([CASES[1]], CASES))
def test_commands_without_a_package(package, words, code, said, tmp_path):
    found, text = run([package, *words], tmp_path, PYTHONPATH=str(ROOT))
    assert (found, said in text, "Traceback" in text) == (code, True, False), text


def test_every_package_that_may_be_absent_is_of_an_extra():
    assert set(libraries.ONLY_FOR) == set(libraries.EXTRA) <= set(oldest_package_versions())
