"""Examples in docstrings give what they show."""

import doctest
import importlib

import pytest
from tests.copies import ROOT

SOURCES = ROOT / "src"
PACKAGES = ("lowfi", "hifi", "meshes", "compare", "reports")
FILES = [path for package in PACKAGES for path in (SOURCES / "rollbench" / package).rglob("*.py")]
WITH_EXAMPLES = [path.relative_to(SOURCES).with_suffix("") for path in FILES if ">>> " in path.read_text(encoding="utf-8")]
MODULES = ["rollbench", *sorted(".".join(path.parts) for path in WITH_EXAMPLES)]


def test_there_are_examples():
    assert len(MODULES) >= 5


@pytest.mark.parametrize("name", MODULES)
def test_examples(name):
    found = doctest.testmod(importlib.import_module(name))
    assert found.attempted > 0
    assert found.failed == 0
