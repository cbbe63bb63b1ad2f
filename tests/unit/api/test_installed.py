"""What is installed is the package rollbench alone, whatever a user's own files are called."""

import json
import os
import re
import shutil
import sysconfig
import tarfile
import venv
import zipfile
from pathlib import Path

import pytest
from hatchling.builders.sdist import SdistBuilder
from hatchling.builders.wheel import WheelBuilder
from tests.processes import python as here_python
from tests.processes import ran

import rollbench

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[3]
ALONE = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
BEFORE = "import meshes, compare, reports\nimport rollbench\n"
AFTER = "import rollbench\nfound = rollbench.solve('lin-case1')\nimport meshes, compare, reports\n"
SOLVE = """
import sys
found = rollbench.solve("lin-case1")
assert rollbench.__file__.startswith(sys.prefix), rollbench.__file__
assert meshes.OWN and compare.OWN and reports.OWN
assert not {"lowfi", "hifi"} & set(sys.modules)
judged = rollbench.check("lin-case1", max_error=7, compute=False)
assert judged.passed, judged
print(repr(float(found.loads.max())))
"""


def contents(wheel: Path | str) -> list[tuple[str, int]]:
    """Names and checksums of the files of a wheel's package."""
    with zipfile.ZipFile(wheel) as archive:
        return sorted((file.filename, file.CRC) for file in archive.infolist() if "dist-info" not in file.filename)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("built")
    (name,) = WheelBuilder(str(ROOT)).build(directory=str(folder), versions=["standard"])
    return Path(name)


@pytest.fixture(scope="module")
def python(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Python of a new environment that holds the wheel, and sees the libraries of this one but not its rollbench."""
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, symlinks=True)
    packages = Path(sysconfig.get_path("purelib", "venv", {"base": str(folder), "platbase": str(folder)}))
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(packages)
    here = sysconfig.get_paths()
    (packages / "libraries.pth").write_text(f"{here['purelib']}\n{here['platlib']}\n")
    return folder / "bin" / "python"


def test_the_wheel_holds_one_package(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    assert {name.split("/")[0] for name in names} == {"rollbench", f"rollbench-{rollbench.__version__}.dist-info"}
    files = ("__main__.py", "py.typed", "fixture.py", "compare/api/calls.py", "lowfi/warned.py")
    assert {f"rollbench/{file}" for file in files} <= set(names)
    assert not [name for name in names if name.startswith("rollbench/reports/validation")]
    assert len(names) == len(set(names))


@pytest.fixture
def unzipped(tmp_path: Path) -> Path:
    """The tree as a zip or a clone on Windows has it: links are files with the path as text. Without the old report, which
    no wheel holds."""
    folder = tmp_path / "unzipped"
    left = shutil.ignore_patterns(".git", ".venv*", "__pycache__", "validation", ".*_cache", ".hypothesis")
    shutil.copytree(ROOT, folder, symlinks=True, ignore=left)
    for link in [path for path in (folder / "src/rollbench").iterdir() if path.is_symlink()]:
        text = os.readlink(link)
        link.unlink()
        link.write_text(text)
    return folder


def test_a_wheel_of_a_tree_without_links_is_the_same(wheel: Path, unzipped: Path, tmp_path: Path) -> None:
    (again,) = WheelBuilder(str(unzipped)).build(directory=str(tmp_path), versions=["standard"])
    assert contents(again) == contents(wheel)


def test_an_editable_install_stops_without_links(unzipped: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    editable = WheelBuilder(str(unzipped)).build(directory=str(tmp_path), versions=["editable"])
    with pytest.raises(SystemExit) as stop:
        list(editable)
    said = capfd.readouterr()
    assert stop.value.code
    assert "links" in said.out + said.err
    assert list(WheelBuilder(str(ROOT)).build(directory=str(tmp_path), versions=["editable"]))


@pytest.mark.installs
def test_what_is_installed_from_a_tree_without_links_solves(unzipped: Path, tmp_path: Path) -> None:
    venv.create(tmp_path / "new", with_pip=True)
    bin_, constraints = tmp_path / "new/bin", ROOT / ".ci/constraints.txt"
    done = ran(bin_ / "pip", "install", "-q", "-c", constraints, unzipped, env=ALONE, timeout=1500)
    assert done.returncode == 0, done.stderr
    solved = ran(bin_ / "rollbench", "solve", "lin-case1", env=ALONE, cwd=tmp_path)
    assert solved.returncode == 0, solved.stderr
    editable = ran(bin_ / "pip", "install", "-q", "-c", constraints, "-e", unzipped, env=ALONE, timeout=1500)
    assert editable.returncode != 0
    assert "links" in editable.stderr + editable.stdout


def test_a_source_archive_runs_its_own_tests(tmp_path: Path) -> None:
    """By the package in it, which its links name, not by that of this environment."""
    (archive,) = SdistBuilder(str(ROOT)).build(directory=str(tmp_path), versions=["standard"])
    with tarfile.open(archive) as opened:
        assert not [name for name in opened.getnames() if "/reports/validation" in name]
        opened.extraction_filter = getattr(tarfile, "data_filter", None)  # Python has it from 3.11.4 on
        opened.extractall(tmp_path)
    (source,) = (path for path in tmp_path.iterdir() if path.is_dir())
    pytest_ = "-m", "pytest", "-p", "no:rollbench", "-p", "no:cacheprovider", "-n", "0"
    for words in (
        ("tests/unit/scenes", "tests/unit/commands/test_threads.py", "--co"),
        ("tests/unit/statics/test_beam.py",),
    ):
        done = here_python(*pytest_, *words, cwd=source, env=ALONE)
        assert done.returncode == 0, done.stdout
    assert (source / "src/rollbench/lowfi").is_symlink()


@pytest.mark.parametrize("order", [BEFORE, AFTER], ids=["loaded before", "loaded after"])
def test_it_solves_beside_files_of_the_same_names(python: Path, tmp_path: Path, order: str) -> None:
    (tmp_path / "meshes").mkdir()
    for file in ("meshes/__init__.py", "compare.py", "reports.py"):
        (tmp_path / file).write_text("OWN = True\n")
    done = ran(python, "-c", order + SOLVE, cwd=tmp_path, env=ALONE)
    assert done.returncode == 0, done.stderr
    assert float(done.stdout) == pytest.approx(rollbench.solve("lin-case1").loads.max(), rel=1e-9)


HASHES = """
import json
from rollbench.compare.provenance import hashes_of_report_inputs
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.scenes.catalogue import scene_names, shipped_scene_text
texts = {name: shipped_scene_text(name) for name in scene_names()}
print(json.dumps(hashes_of_report_inputs([shipped_store()], texts)))
"""


def test_a_report_is_verified_alike_from_the_wheel_and_from_here(python: Path) -> None:
    """Hashes of the sources, scenes, printed data and stored runs: every one that a report rests on."""
    there, here = ran(python, "-P", "-c", HASHES, env=ALONE).stdout, here_python("-c", HASHES).stdout
    assert len(json.loads(here)) > 200
    assert there == here


def test_the_names_of_the_library_are_loaded_when_used() -> None:
    code = (
        "import sys, rollbench; print(sorted(dir(rollbench)), [m for m in sys.modules if m.startswith('rollbench.')], "
        "'numpy' in sys.modules); rollbench.solve; rollbench.compare; print(callable(rollbench.compare))"
    )
    done = here_python("-c", code)
    assert done.stdout.splitlines() == [f"{sorted(rollbench.__all__)} [] False", "True"]


#: A user's script of all the library: what is right, then a fault in each of the last lines.
SCRIPT = """\
from pathlib import Path
import rollbench
scene = rollbench.read("lin-case1")
result = rollbench.solve(rollbench.new("40x10"), "lin", stiffness_at=0.4)
assert result.loads is not None and result.displacement is not None and result.life is not None
largest: float = float(result.loads.max())
moved: float = float(result.displacement[2])
life: float = result.life.L10
forces = [one.force for one in result.sets.values()]
worst = {name: one.worst.pressure for name, one in result.cases.items() if one.worst is not None}
expected: float | None = None if result.expected_error is None else result.expected_error.loads
page: Path = result.view("screw.html")
result.plot().savefig("loads.svg")
rows: int = len(result.to_dataframe())
version = result.to_dict()["schema"]
passed: bool = rollbench.check(scene, max_error=7, limits={"pressure": 5.0}).passed
judged = [(row.quantity, row.error, row.judgement is rollbench.Judgement.FAIL) for row in rollbench.check(scene).rows]
comparison = rollbench.compare_models(scene, ["lin"])
error: float = comparison.errors["lin"]
bars = None if comparison.uncertainty is None else comparison.uncertainty.discretisation
friction = rollbench.friction(scene, mu=[0.1])
torque: float | None = friction.torque
speeds = [ball.orbit for ball in friction.balls]
orders = [row.order for row in rollbench.mesh_study(scene).quantities]
mean = {name: one.mean for name, one in rollbench.sweep("lin-case1", ["x=1,2"]).outputs.items() if one is not None}
members: int = rollbench.ensemble("lin-random", 3).members
written: Path = rollbench.report("lin-case1").page
rollbench.solve(17)
word: int = rollbench.check("lin-case1").word
result.loads = None
result.life.l10
unsure: float = rollbench.friction("lin-case1").torque
"""
#: Checkers of types, as they are called with an interpreter that the library is installed in, and how they name a fault.
CHECKERS = {
    "mypy": (("--strict", "--follow-imports=silent", "--python-executable"), r"mine\.py:(\d+): error:"),
    "pyright": (("--pythonpath",), r"mine\.py:(\d+):\d+ - error:"),
}


@pytest.mark.parametrize("checker", CHECKERS)
def test_types_of_the_library_are_checked_in_a_users_script(python: Path, tmp_path: Path, checker: str) -> None:
    pytest.importorskip(checker)
    (tmp_path / "mine.py").write_text(SCRIPT)
    options, fault = CHECKERS[checker]
    done = here_python("-m", checker, *options, python, "mine.py", cwd=tmp_path)
    assert done.returncode == 1, done.stdout + done.stderr
    last = len(SCRIPT.splitlines())
    assert [int(line) for line in re.findall(fault, done.stdout)] == [*range(last - 4, last + 1)], done.stdout
