"""Every command that has --json prints one strict JSON value: no nan, no infinity. Kinds of scenes: ``tests/golden``."""

import inspect

import pytest

from rollbench.compare.cli import app_with_commands as complete

#: Commands with --json that take no scene, or one only, as short as they can be.
OTHERS = {
    "list_": (("list",), ("list", "--trace"), ("list", "--table", "lin-3.2")),
    "audit": (("audit", "--only", "lin-3.2"),),  # which prints a zero where another number is computed
    "compare": (("compare", "lin-case1", "--model", "lin"),),
    "check": (("check", "lin-case1", "--model", "lin", "--no-compute"),),
    "survey": (("survey", "--model", "mei", "--count", "2"), ("survey", "--screw", "0")),
    "table": (("table", "lin-case3", "--model", "lin", "--over", "load=1:2:2 kN", "--quantities", "load"),),
    "friction": (("friction", "bearing-9", "--model", "lin", "--mu", "0.1"),),
    "mesh_study": (("mesh-study", "two-balls", "--levels", "2"),),
}
#: Others are not run here: solve by ``tests/golden``, doctor, sweep and crosscheck where their own tests read the JSON; the
#: last two take a minute, the report runs the table of the one, and ``test_bench.py`` the other.
ELSEWHERE = {"solve", "doctor", "sweep", "crosscheck", "stability", "bench"}


def strict(command, *tokens):
    """Parsed output of a command that ends with 0 or 1; `command.json` takes no nan and no infinity."""
    code, data = command.json(*tokens, "--json")
    assert code in (0, 1), tokens
    return data


def test_no_command_is_forgotten():
    functions = (complete()[name].default_command for name in complete() if not name.startswith("-"))
    commands = {f.__name__ for f in functions if "as_json" in inspect.signature(f).parameters}
    assert commands == OTHERS.keys() | ELSEWHERE


@pytest.mark.parametrize("tokens", [tokens for several in OTHERS.values() for tokens in several], ids=" ".join)
def test_other_commands(command, tokens, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # a mesh study writes its files beside its store
    assert strict(command, *tokens)
