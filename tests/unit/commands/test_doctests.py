"""Examples in docstrings give what they show."""

import doctest
import importlib

import pytest
from tests.copies import ROOT
from tests.slow import all_slow_but

SOURCES = ROOT / "src"
PACKAGES = ("lowfi", "hifi", "meshes", "compare", "reports")
FILES = [path for package in PACKAGES for path in (SOURCES / "rollbench" / package).rglob("*.py")]
WITH_EXAMPLES = [path.relative_to(SOURCES).with_suffix("") for path in FILES if ">>> " in path.read_text(encoding="utf-8")]
MODULES = ["rollbench", *sorted(".".join(path.parts) for path in WITH_EXAMPLES)]


def test_there_are_examples():
    assert len(MODULES) >= 5


SLOW = {"rollbench.compare.api.calls", "rollbench.compare.results.side_by_side", "rollbench.compare.results.friction"}


@pytest.mark.parametrize("name", all_slow_but({*MODULES} - SLOW, MODULES))
def test_examples(name):
    found = doctest.testmod(importlib.import_module(name))
    assert found.attempted > 0
    assert found.failed == 0
