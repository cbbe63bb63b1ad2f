"""Wings have one door each: what they register exists, a command loads no other's code, and the core stands without any."""

import random
import shutil

import pytest
from tests.copies import ROOT, copy_of_tree, rollbench
from tests.processes import python

from rollbench.compare.registration import HOOKS, load, registered

WINGS = sorted(path.parent.name for path in ROOT.glob("compare/wings/*/registration.py"))
#: Commands that go with a wing, and those of wings that need it.
COMMANDS = {name: {name} for name in ("bench", "crosscheck", "doctor", "friction")}
COMMANDS |= {"evidence": {"audit"}, "export": {"export"}, "members": {"bench"}, "mesh_study": {"mesh-study"}}
COMMANDS |= {"extremes": {"stability"}, "sweep": {"sweep", "stability"}}
COMMANDS |= {name: set() for name in ("bearings", "random_errors", "rolling")}
HERE = {"PYTHONPATH": str(ROOT / "src")}
#: Commands of the core that are run without a wing, and their exit codes.
CORE = (("list",), ("solve", "two-balls"), ("check", "lin-case1", "--no-compute"), ("schema",))


@pytest.mark.parametrize("name", registered())
def test_what_is_registered_exists(name):
    one = registered()[name]
    assert one.functions.keys() <= HOOKS.keys()
    for function in one.functions.values():
        assert load(function) is not None
    for kind, where in one.kinds.items():
        assert kind in load(where)
    for part in one.parts:
        assert callable(load(f"{part.module}:section"))


def test_every_computation_says_which_wings_it_needs():
    for one in load("wings.evidence.registry:computations")():
        assert set(one.needs) <= set(WINGS)
        assert not one.computed_by or callable(load(one.computed_by))


def test_a_solve_loads_no_wing_whose_answer_it_does_not_print(tmp_path):
    code = (
        "import sys\nfrom rollbench.compare.cli import main\n"
        "try:\n    main(['solve', 'two-balls'])\nexcept SystemExit:\n"
        "    print(*(name for name in sys.modules if name.startswith('rollbench')), file=sys.stderr)"
    )
    done = python("-c", code, cwd=tmp_path, environ=HERE)
    assert "SL" in done.stdout or "N" in done.stdout
    doors = {"wings", "sources"}
    loaded = [name for name in done.stderr.split() if name.startswith("rollbench.")]
    inside = [n for n in loaded if n.split(".")[2:3] and n.split(".")[2] in doors and len(n.split(".")) > 4]
    assert not [name for name in inside if not name.endswith(".registration")]
    physics = ("lowfi.friction", "lowfi.bearings", "lowfi.random_errors", "hifi")
    assert not [name for name in loaded if name.removeprefix("rollbench.").startswith(physics)]
    unasked = ("compare.gate.", "compare.reference.", "compare.scenes.axis", "lowfi.statics.axis.")
    assert not [name for name in loaded if name.removeprefix("rollbench.").startswith(unasked)]
    assert "rollbench.compare.commands.arguments.validation" not in loaded, "options of other commands"


@pytest.mark.parametrize("command", ["solve lin-case1-cut", "solve lin-case1", "friction two-balls --mu 0.1"])
def test_a_second_solve_of_known_parts_finds_what_the_first_one_kept(tmp_path, command):
    """And then takes none of the packages that are slow to import."""
    code = (
        "import atexit, sys\nfrom rollbench.compare.cli import main\n"
        "others = lambda: [n for n in ('numba', 'scipy', 'pydantic') if n in sys.modules]\n"
        "atexit.register(lambda: print(*others(), sep='\\n', file=sys.stderr))\n"
        f"sys.argv = ['rollbench', *{command.split()}]\nmain()"
    )
    environ = HERE | {"ROLLBENCH_CACHE": str(tmp_path / "cache")}
    first, again = (python("-c", code, cwd=tmp_path, environ=environ) for _ in range(2))
    assert again.stdout == first.stdout != ""
    assert not {"numba", "scipy", "pydantic"} & set(again.stderr.split("\n"))


def stands(wing, tmp_path):
    """The core does what it does in a copy of the tree without the folders of a wing."""
    tree = copy_of_tree(tmp_path / "tree")
    for folder in (f"compare/wings/{wing}", *registered()[wing].folders):
        shutil.rmtree(tree / folder)
    for tokens in CORE:
        done = rollbench(tree, *tokens, cwd=tmp_path)
        assert done.returncode == 0, (wing, tokens, done.stderr)
    shown = rollbench(tree, "--help", cwd=tmp_path).stdout
    words = {line.split()[1] for line in shown.splitlines() if line.startswith("│ ") and len(line.split()) > 1}
    assert "solve" in words
    assert not words & COMMANDS[wing], wing
    for command in COMMANDS[wing]:
        assert rollbench(tree, command, "lin-case1", cwd=tmp_path).returncode == 2


def test_the_core_stands_without_a_wing_that_is_drawn(tmp_path):
    seed = random.SystemRandom().randrange(10**6)
    wing = random.Random(seed).choice(WINGS)
    print(f"seed {seed}: without {wing}")
    stands(wing, tmp_path)


@pytest.mark.each_wing
@pytest.mark.parametrize("wing", WINGS)
def test_the_core_stands_without(wing, tmp_path):
    stands(wing, tmp_path)
