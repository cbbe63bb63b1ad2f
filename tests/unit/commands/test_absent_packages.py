"""What still works where a Python package is not installed: `ONLY_FOR` of `meshes.libraries` says what does not."""

import sys
import venv

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
EXPORT = ("export", "lin-case1", "nut", "--out", "nut.vtu")
TABLE = ("table", "two-balls", "--model", "lin", "--quantities", "load")
#: Package, command, exit code, words of its output; the first few are tried without removing the package.
CASES = [
    ("gmsh", CHECK, 0, "1 pass"),
    ("scikit-fem", ("check", "--printed"), 2, "pip install 'rollbench[reference]'"),
    ("scikit-fem", COMPARE, 0, "compare.svg"),
    ("scikit-fem", PAGE, 0, "index.html"),
    ("matplotlib", SWEEP, 0, "and no figure (matplotlib is not installed: pip install 'rollbench[report]')"),
    ("matplotlib", PAGE, 2, "this computer: matplotlib: got matplotlib is not installed"),
    ("matplotlib", COMPARE, 0, "no figure (matplotlib is not installed"),
    ("scikit-fem", EXPORT, 2, "scikit-fem: got scikit-fem is not installed"),
    ("scikit-fem", ("audit",), 2, "pip install 'rollbench[reference]'"),
    ("scikit-fem", ("condense", "two-balls", "--level", "1"), 2, "pip install 'rollbench[reference]'"),
    ("scikit-fem", ("report", "--stored"), 2, "scikit-fem: got scikit-fem is not installed"),
    ("scikit-fem", ("compare", "lin-pair-a"), 2, "scikit-fem: got scikit-fem is not installed"),
    ("gmsh", COMPARE, 0, "compare.svg"),
    ("gmsh", PAGE, 0, "index.html"),
    ("gmsh", EXPORT, 2, "pip install 'rollbench[reference]'"),
    ("meshio", EXPORT, 2, "meshio"),
    ("pymetis", ("compare", "lin-case1-cut", "--levels", "1", "--fresh", "--store", "runs"), 2, "pymetis is not installed"),
    ("pyvista", PAGE, 0, "index.html"),
    ("pillow", PAGE, 2, "pip install 'rollbench[report]'"),
    ("jinja2", PAGE, 2, "pip install 'rollbench[report]'"),
    ("h5py", (*EXPORT[:-1], "nut.med"), 2, "pip install 'rollbench[reference]'"),
    ("dask", (*SWEEP, "--backend", "dask"), 2, "pip install 'rollbench[cluster]'"),
    ("distributed", (*SWEEP, "--backend", "dask"), 2, "pip install 'rollbench[cluster]'"),
    ("pyarrow", (*TABLE, "--out", "t.parquet"), 2, "pip install 'rollbench[tables]'"),
    ("xarray", (*TABLE, "--out", "t.nc"), 2, "pip install 'rollbench[tables]'"),
]


def run(words, folder, before=(sys.executable, "-m", "tests.without"), **variables):
    done = ran(*before, *words, cwd=folder, environ=variables)
    return done.returncode, done.stdout + done.stderr


@pytest.mark.parametrize(("package", "words", "code", "said"), all_slow_but([CASES[1]], CASES[:6]))
def test_commands_without_a_package(package, words, code, said, tmp_path):
    found, text = run([package, *words], tmp_path, PYTHONPATH=str(ROOT))
    assert (found, said in text, "Traceback" in text) == (code, True, False), text


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """Python of an environment of its own, into which the package is installed from the registry."""
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, with_pip=True)
    python = str(folder / "bin" / "python")
    pip(python, "install", f"{ROOT}[all]")
    return python


def pip(python, what, *words):
    constraints = ["-c", str(ROOT / ".ci" / "constraints.txt")] if what == "install" else []
    ran(python, "-m", "pip", "-q", what, *constraints, *words, timeout=None).check_returncode()


@pytest.mark.survey
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("package", sorted(libraries.ONLY_FOR))
def test_commands_where_a_package_is_truly_not_installed(package, installed, tmp_path):
    pip(installed, "uninstall", "-y", package)
    try:
        for _, words, code, said in ((package, CHECK, 0, "1 pass"), *(case for case in CASES if case[0] == package)):
            found, text = run(words, tmp_path, (installed, "-P", "-m", "rollbench"), PYTHONPATH="")
            assert (found, said in text, "Traceback" in text) == (code, True, False), text
        found, text = run(["doctor"], tmp_path, (installed, "-P", "-m", "rollbench"), PYTHONPATH="")
        assert (found, f"optional  {package}: not installed; {libraries.ONLY_FOR[package]}" in text) == (0, True), text
    finally:
        pip(installed, "install", package)


def test_every_package_that_may_be_absent_is_of_an_extra_and_is_tried():
    assert {case[0] for case in CASES} == set(libraries.ONLY_FOR) == set(libraries.EXTRA) <= set(oldest_package_versions())
