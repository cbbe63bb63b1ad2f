"""What a command loads: no other command, no study, no case, and the second time no slow package."""

import pytest
from tests.copies import ROOT
from tests.processes import python
from tests.slow import all_slow_but

#: Runs a command and lists at its end, on standard error, the modules that are loaded.
LISTED = """
import atexit, sys
from rollbench.compare.cli import main
atexit.register(lambda: print(*sys.modules, file=sys.stderr))
sys.argv[0] = "rollbench"
main()
"""


def loaded(words, folder, **variables):
    """What a command writes on standard output, and the modules that it loads."""
    environ = {"PYTHONPATH": str(ROOT / "src")} | variables
    done = python("-c", LISTED, *words.split(), cwd=folder, environ=environ)
    return done.stdout, set(done.stderr.split())


@pytest.mark.parametrize("command", ["--help", "solve two-balls --json", "list"])
def test_nothing_heavy_is_loaded(command, tmp_path):
    heavy = {"gmsh", "pyvista", "vtk", "vtkmodules", "skfem", "meshio", "matplotlib"}
    assert not heavy & loaded(command, tmp_path)[1]


def test_a_solve_loads_nothing_whose_answer_it_does_not_print(tmp_path):
    out, modules = loaded("solve two-balls", tmp_path)
    assert "SL" in out
    found = [name.removeprefix("rollbench.") for name in modules if name.startswith("rollbench.")]
    inside = [name for name in found if name.count(".") > 2 and not name.endswith(".models")]  # cases bring scenes, models
    unasked = ("compare.studies.", "compare.cases.", "compare.sections.", "compare.report.", "compare.evidence.")
    assert not [name for name in inside if name.startswith(unasked)]
    unasked = ("lowfi.friction", "lowfi.as_source", "hifi", "compare.gate.", "compare.reference.")
    assert not [name for name in found if name.startswith((*unasked, "compare.scenes.axis_file", "lowfi.statics.axis."))]
    commands = {name.rsplit(".")[-1] for name in found if name.startswith("compare.commands.")}
    assert commands <= {"solve", "terminal"}, "options of other commands"


COMMANDS = ("solve lin-case1-cut", "solve lin-case1", "friction two-balls --mu 0.1")


@pytest.mark.parametrize("command", all_slow_but(["solve lin-case1"], COMMANDS))
def test_a_second_solve_of_known_parts_finds_what_the_first_one_kept(tmp_path, command):
    """And then takes none of the packages that are slow to import."""
    (first, _), (again, modules) = (loaded(command, tmp_path, ROLLBENCH_CACHE=tmp_path / "cache") for _ in range(2))
    assert again == first != ""
    assert not {"scipy", "pydantic"} & modules
