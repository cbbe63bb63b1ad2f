"""``import rollbench``: the commands' answers as records with units, and the module's own packages."""

import json
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
import rollbench
from hatchling.builders.wheel import WheelBuilder

from compare.cli import main
from tests.axes import one_set
from tests.helpers import small_screw

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def solved() -> rollbench.Solution:
    return rollbench.solve("lin-case1", "lin")


def test_solve_is_what_the_command_prints(solved: rollbench.Solution, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["solve", "lin-case1", "--model", "lin", "--json"])
    printed = json.loads(capsys.readouterr().out)
    assert solved.converged
    assert solved["summary.loads"] == printed["summary"]["loads"]
    np.testing.assert_allclose(solved.load[:, 0], [ball["load_N"]["SL"] for ball in printed["balls"]])


def test_values_have_units(solved: rollbench.Solution) -> None:
    number = solved["summary.axial.displacement_um"]
    assert solved.quantity("summary.axial.displacement_um").to("mm").magnitude == pytest.approx(1e-3 * number)
    stiff = solved.quantity("summary.rigidities_N_per_um.contacts_alone")
    assert stiff.to("N/m").magnitude == pytest.approx(1e6 * solved["summary.rigidities_N_per_um.contacts_alone"])
    with pytest.raises(ValueError, match="no number with a unit"):
        solved.quantity("summary.loads.worst_ball")
    with pytest.raises(KeyError, match="keys here: sides, loads"):
        solved["summary.load"]


def test_results_are_tables_in_a_notebook(solved: rollbench.Solution) -> None:
    page = solved._repr_html_()
    assert "<td>axial: displacement</td>" in page
    assert ">um</td>" in page
    assert "rigidities: contacts alone" in str(solved)
    assert len(solved.balls().splitlines()) == 33
    assert "<script>" not in rollbench.Result({"a<script>": 1.0})._repr_html_()


def test_a_scene_is_a_record_that_can_be_changed(tmp_path: Path) -> None:
    from dataclasses import replace

    scene = rollbench.read("lin-case1")
    half = replace(scene, loads=tuple(replace(x, force=tuple(0.5 * f for f in x.force)) for x in scene.loads))
    assert rollbench.solve(half, "lin").load.sum() == pytest.approx(
        0.5 * rollbench.solve(scene, "lin").load.sum(), rel=0.02
    )
    (tmp_path / "bad.toml").write_text("[track]\nlead = 3\n")
    with pytest.raises(rollbench.InputError):
        rollbench.read(tmp_path / "bad.toml")


def test_compare_and_check_take_stored_references(tmp_path: Path) -> None:
    beside = rollbench.compare("lin-case1", ["lin"], store=tmp_path)
    assert beside["models.lin.largest_error_percent"] == pytest.approx(6.15, abs=0.1)
    assert "lin is off by" in str(beside)
    judged = rollbench.check("lin-case1", max_error=1e-3, compute=False, store=tmp_path)
    assert (judged.word, judged.passed) == ("fail", False)
    assert rollbench.check("lin-case1", compute=False, store=tmp_path).passed


def test_several_sets_on_a_shaft() -> None:
    found = rollbench.solve(one_set(small_screw(count=4)), "lin")
    assert found.converged
    assert any(name.endswith("force on shaft") for name, *_ in found.rows())


@pytest.mark.parametrize("statement", ["import rollbench", "import runpy; runpy.run_module('rollbench', run_name='other')"])
def test_a_file_of_the_users_named_compare_does_not_get_in(tmp_path: Path, statement: str) -> None:
    (tmp_path / "compare.py").write_text("raise SystemExit('the wrong file')\n")
    path = f"import sys; sys.path[1:1] = [{str(ROOT / 'compare' / 'toplevel')!r}]"
    code = f"{path}; {statement}; import rollbench as r; r.read('lin-case1')"
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_a_module_of_that_name_that_is_loaded_already_is_named(tmp_path: Path) -> None:
    (tmp_path / "meshes.py").write_text("x = 1\n")
    code = f"import sys; sys.path[1:1] = [{str(ROOT / 'compare' / 'toplevel')!r}]; import meshes, rollbench"
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "rollbench needs its own package 'meshes'" in done.stderr


def test_the_wheel_holds_the_module_once(tmp_path: Path) -> None:
    (made,) = WheelBuilder(str(ROOT)).build(directory=str(tmp_path), versions=["standard"])
    names = zipfile.ZipFile(made).namelist()
    assert {"rollbench/__init__.py", "rollbench/__main__.py", "compare/api/calls.py"} <= set(names)
    assert not [name for name in names if name.startswith(("compare/toplevel", "tests", "reports/validation"))]
    assert len(names) == len(set(names))
