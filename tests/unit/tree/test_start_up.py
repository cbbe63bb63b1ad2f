"""What a command loads: no other command, no study, no case, and the second time no slow package."""

import pytest
from tests.copies import ROOT
from tests.processes import python

HERE = {"PYTHONPATH": str(ROOT / "src")}


def test_a_solve_loads_nothing_whose_answer_it_does_not_print(tmp_path):
    code = (
        "import sys\nfrom rollbench.compare.cli import main\n"
        "try:\n    main(['solve', 'two-balls'])\nexcept SystemExit:\n"
        "    print(*(name for name in sys.modules if name.startswith('rollbench')), file=sys.stderr)"
    )
    done = python("-c", code, cwd=tmp_path, environ=HERE)
    assert "SL" in done.stdout or "N" in done.stdout
    loaded = [name for name in done.stderr.split() if name.startswith("rollbench.")]
    unasked = ("compare.studies.", "compare.cases.", "compare.sections.", "compare.report.", "compare.evidence.")
    inside = [name for name in loaded if name.count(".") > 3]  # the folders of cases are looked into for scenes
    assert not [name for name in inside if name.removeprefix("rollbench.").startswith(unasked)]
    physics = ("lowfi.friction", "lowfi.random_errors", "hifi")
    assert not [name for name in loaded if name.removeprefix("rollbench.").startswith(physics)]
    unasked = ("compare.gate.", "compare.reference.", "compare.scenes.axis_file", "lowfi.statics.axis.")
    assert not [name for name in loaded if name.removeprefix("rollbench.").startswith(unasked)]
    commands = [name for name in loaded if name.startswith("rollbench.compare.commands.")]
    assert {name.rsplit(".")[-1] for name in commands} <= {"solve", "terminal"}, "options of other commands"


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
