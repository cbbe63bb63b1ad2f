"""Every command that has --json, on every kind of shipped scene, prints one strict JSON value: no nan, no infinity."""

import inspect
from pathlib import Path

import pytest

from rollbench.compare.cli import app_with_commands as complete
from rollbench.compare.scenes import catalogue

#: Shipped scenes, the smallest of each kind that `solve` and `friction` take, and of those that only `friction` does.
WHOLE = ("two-balls", "bearing-9", "bearing-9-preload", "lin-random", "axis-fixed-fixed")
FRICTION_ONLY = ("lin-rotary-1", "lin-bearing-pairs", "lin-pair-a", "lin-chain-10", "lin-screw-pair-a", "lin-screw-run")
#: Commands with --json that take no scene, or one only, as short as they can be.
OTHERS = {
    "list_": (("list",), ("list", "--trace"), ("list", "--table", "lin-3.2")),
    "doctor": (("doctor",),),
    "audit": (("audit", "--only", "lin-3.2"),),  # which prints a zero where another number is computed
    "compare": (("compare", "lin-case1", "--model", "lin"),),
    "check": (("check", "lin-case1", "--model", "lin", "--no-compute"),),
    "survey": (("survey", "--model", "mei", "--count", "2"), ("survey", "--screw", "0")),
    "table": (("table", "lin-case3", "--model", "lin", "--over", "load=1:2:2 kN", "--quantities", "load"),),
    "mesh_study": (("mesh-study", "two-balls", "--levels", "2"),),
}
#: Others are not run here: the first two below, sweep and crosscheck where their own tests read the JSON; the last two take
#: a minute, the report runs the table of the one, and ``test_bench.py`` the other.
ELSEWHERE = {"solve", "friction", "sweep", "crosscheck", "stability", "bench"}


def strict(command, *tokens):
    """Parsed output of a command that ends with 0 or 1; `command.json` takes no nan and no infinity."""
    code, data = command.json(*tokens, "--json")
    assert code in (0, 1), tokens
    return data


def test_no_command_is_forgotten():
    functions = (complete()[name].default_command for name in complete() if not name.startswith("-"))
    commands = {f.__name__ for f in functions if "as_json" in inspect.signature(f).parameters}
    assert commands == OTHERS.keys() | ELSEWHERE


def test_no_kind_of_shipped_scene_is_forgotten():
    def kinds(names):
        return {(type(s).__name__, getattr(s, "kind", "")) for s in map(catalogue.scene_of_any_kind, names)}

    assert kinds((*WHOLE, *FRICTION_ONLY)) == kinds(catalogue.scene_names())


@pytest.mark.parametrize("name", WHOLE)
def test_solve(command, name):
    assert strict(command, "solve", name, "--model", "lin")["scene"] == name


@pytest.mark.further
@pytest.mark.parametrize("name", [*WHOLE, *FRICTION_ONLY])
def test_friction(command, scene_file, name):
    mu = ("--mu", "0.1") if name in WHOLE and catalogue.scene_of_any_kind(name).friction is None else ()
    if name == "lin-screw-run":  # as shipped but for its 200 steps, which take seconds
        name = scene_file(catalogue.shipped_scene_text(name), ("steps = 200", "steps = 4"))
    assert strict(command, "friction", name, *mu)["scene"] == Path(name).stem


@pytest.mark.parametrize("tokens", [tokens for several in OTHERS.values() for tokens in several], ids=" ".join)
def test_other_commands(command, tokens, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # a mesh study writes its files beside its store
    assert strict(command, *tokens)
