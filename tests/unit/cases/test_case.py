"""Cases: ours are whole; another package adds one by an entry point, which is loaded when printed data are judged."""

import json
import os

import pytest
from tests import acme
from tests.copies import ROOT
from tests.processes import python

from rollbench.compare.case import CASES, shipped_toml_files
from rollbench.compare.scenes import catalogue

CASE = """
from rollbench.compare.case import Case
CASE = Case("acme", "Acme (1901)", "acme_case", "page")
"""


@pytest.fixture
def installed(tmp_path):
    """Installs a package with the text of its module and an entry point, and gives a command that finds it."""

    def install(module: str, point: str = "acme_case:CASE", name: str = "acme_case"):
        acme.write(tmp_path / name, catalogue.shipped_scene_text("two-balls"))
        (tmp_path / name / "__init__.py").write_text(module, encoding="utf-8")
        info = tmp_path / f"{name}-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n", encoding="utf-8")
        (info / "entry_points.txt").write_text(f"[rollbench.cases]\n{name} = {point}\n", encoding="utf-8")
        path = os.pathsep.join((str(ROOT / "src"), str(tmp_path)))
        return lambda *words: python("-m", "rollbench", *words, cwd=tmp_path, environ={"PYTHONPATH": path})

    return install


def test_ours_have_what_they_name():
    assert {case.folder.name for case in CASES} == {p.parent.name for p in ROOT.glob("compare/cases/*/__init__.py")}
    for case in CASES:
        assert bool(case.files("printed")) == bool(case.title)
        assert all(name.startswith(f"{case.name}-") for name in (*case.files("printed"), *case.files("scenes")))
        assert case.folder.joinpath(case.page).is_dir() or callable(case.import_object(f"{case.page}:make_section"))
    files = (
        path for pattern in ("compare/scenes/*.toml", "compare/cases/*/scenes/**/*.toml") for path in ROOT.glob(pattern)
    )
    assert set(shipped_toml_files("scenes")) == {path.stem for path in files}


def test_a_case_of_another_package_is_judged_and_shown_with_ours(installed, tmp_path):
    rollbench = installed(CASE)
    done = rollbench("check", "--printed", "--source", "acme", "--json")
    data = json.loads(done.stdout)
    assert (done.returncode, data["changed_verdicts"]) == (0, [])
    assert {row["entry"]: row["verdict"] for row in data["entries"]} == {
        "acme-1:modulus": "reproduced",
        "acme-1:balls": "reproduced",
    }
    assert [row["source"] for row in data["counts"]] == ["Acme (1901)", "all"]
    done = rollbench("report", "--only", "acme", "--stored", "--out", "out")
    assert done.returncode == 0, done.stderr
    assert "113.9" in (tmp_path / "out/tables/acme-1.csv").read_text(encoding="utf-8")
    assert "acme" not in rollbench("list", "--json").stdout, "it is loaded when printed data are judged"


def test_a_broken_case_is_named_in_one_error_and_other_commands_go_on(installed):
    rollbench = installed("raise RuntimeError('no licence')")
    done = rollbench("check", "--printed", "--only", "lin-B1")
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    for word in ("entry point acme_case", "RuntimeError: no licence", "uninstall"):
        assert word in done.stderr
    assert rollbench("list").returncode == rollbench("check", "lin-case1", "--no-compute").returncode == 0


#: Modules that give no case, and the error that names each.
NO_CASE = {
    "CASE = 3": "acme_case:CASE: got 3",
    CASE.replace("acme_case", "acme_cse"): "No module named 'acme_cse'",
    CASE.replace('"acme"', '"lin"'): 'name: got "lin"',
}


@pytest.mark.parametrize("module", NO_CASE, ids=["number", "package", "name"])
def test_what_is_no_case_and_a_name_that_is_taken_are_refused(installed, module):
    done = installed(module)("check", "--printed", "--only", "lin-B1")
    assert (done.returncode, NO_CASE[module] in done.stderr) == (2, True), done.stderr


def test_computations_that_are_missing_or_wrong_are_named(installed, tmp_path):
    rollbench, file = installed(CASE), tmp_path / "acme_case/computations.toml"
    right = file.read_text(encoding="utf-8")
    for text, expected in (
        ("", "computations.toml: acme-1: got no computation"),
        ("[", "computations.toml: file: got"),
        (right.replace("table_1", "table_2"), "acme: computations.toml: acme-1: got module 'acme_case.evidence' has no"),
    ):
        file.write_text(text, encoding="utf-8")
        done = rollbench("check", "--printed", "--only", "acme-1")
        assert (done.returncode, expected in done.stderr, done.stderr.count("\n")) == (2, True, 1), done.stderr
