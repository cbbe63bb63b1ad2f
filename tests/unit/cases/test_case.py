"""Cases: ours are whole; another package adds one by an entry point, which is loaded when printed data are judged."""

import json
import os

import pytest
from tests import acme
from tests.copies import ROOT
from tests.processes import python

from rollbench.compare.case import CASES, shipped_toml_files
from rollbench.compare.scenes import catalogue

pytestmark = pytest.mark.slow

CASE = """
from rollbench.compare.case import Case
CASE = Case("acme", "Acme (1901)", "acme_case", "page")
"""


@pytest.fixture
def installed(tmp_path):
    """Installs a package with the text of its module and an entry point, and gives a command that finds it."""

    def install(module: str):
        acme.write(tmp_path / "acme_case", catalogue.shipped_scene_text("two-balls"))
        (tmp_path / "acme_case" / "__init__.py").write_text(module, encoding="utf-8")
        info = tmp_path / "acme_case-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text("Metadata-Version: 2.1\nName: acme_case\nVersion: 1.0\n", encoding="utf-8")
        (info / "entry_points.txt").write_text("[rollbench.cases]\nacme_case = acme_case:CASE\n", encoding="utf-8")
        path = os.pathsep.join((str(ROOT / "src"), str(tmp_path)))
        return lambda *words: python("-m", "rollbench", *words, cwd=tmp_path, environ={"PYTHONPATH": path})

    return install


def test_ours_have_what_they_name():
    assert {case.folder.name for case in CASES} == {p.parent.name for p in ROOT.glob("compare/cases/*/__init__.py")}
    for case in CASES:
        assert bool(case.files("printed")) == bool(case.title)
        assert all(name.startswith(f"{case.name}-") for name in (*case.files("printed"), *case.files("scenes")))
        assert case.folder.joinpath(case.page).is_dir() or callable(case.import_object(f"{case.page}:make_section"))
    files = (*ROOT.glob("compare/scenes/*.toml"), *ROOT.glob("compare/cases/*/scenes/**/*.toml"))
    assert set(shipped_toml_files("scenes")) == {path.stem for path in files}


def test_a_case_of_another_package_is_judged_and_shown_with_ours(installed, tmp_path):
    rollbench = installed(CASE)
    done = rollbench("check", "--printed", "--source", "acme", "--json")
    data = json.loads(done.stdout)
    assert (done.returncode, data["changed_verdicts"]) == (0, [])
    verdicts = {row["entry"]: row["verdict"] for row in data["entries"]}
    assert verdicts == dict.fromkeys(("acme-1:modulus", "acme-1:balls"), "reproduced")
    assert [row["source"] for row in data["counts"]] == ["Acme (1901)", "all"]
    done = rollbench("report", "--only", "acme", "--stored", "--out", "out")
    assert done.returncode == 0, done.stderr
    assert "113.9" in (tmp_path / "out/tables/acme-1.csv").read_text(encoding="utf-8")
    assert "acme" not in rollbench("list", "--json").stdout, "it is loaded when printed data are judged"


def test_a_broken_case_is_named_in_one_error_and_other_commands_go_on(installed):
    rollbench = installed("raise RuntimeError('no licence')")
    said = refused(rollbench, "lin-B1")
    assert [word for word in ("entry point acme_case", "RuntimeError: no licence", "uninstall") if word not in said] == []
    assert rollbench("list").returncode == rollbench("check", "lin-case1", "--no-compute").returncode == 0


def refused(rollbench, table: str) -> str:
    """The one line on standard error by which a table cannot be judged."""
    done = rollbench("check", "--printed", "--only", table)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1), done.stderr
    return done.stderr


#: Modules that give no case, and the error that names each.
NO_CASE = {
    "CASE = 3": "acme_case:CASE: got 3",
    CASE.replace("acme_case", "acme_cse"): "No module named 'acme_cse'",
    CASE.replace('"acme"', '"lin"'): 'name: got "lin"',
}


@pytest.mark.parametrize("module", NO_CASE, ids=["number", "package", "name"])
def test_what_is_no_case_and_a_name_that_is_taken_are_refused(installed, module):
    assert NO_CASE[module] in refused(installed(module), "lin-B1")


def test_computations_that_are_missing_or_wrong_are_named(installed, tmp_path):
    rollbench, file = installed(CASE), tmp_path / "acme_case/computations.toml"
    right = file.read_text(encoding="utf-8")
    for text, expected in (
        ("", "computations.toml: acme-1: got no computation"),
        ("[", "computations.toml: file: got"),
        (right.replace("table_1", "table_2"), "acme: computations.toml: acme-1: got module 'acme_case.evidence' has no"),
    ):
        file.write_text(text, encoding="utf-8")
        assert expected in refused(rollbench, "acme-1")
