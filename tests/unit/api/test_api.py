"""``import rollbench``: the commands' answers as records with units, and the module's own packages."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.axes import one_set
from tests.helpers import small_screw

import rollbench
from rollbench.reports.cells import typeset


@pytest.fixture(scope="module")
def solved() -> rollbench.Solution:
    return rollbench.solve("lin-case1", "lin")


def test_solve_is_what_the_command_prints(solved: rollbench.Solution, command) -> None:
    printed = command.answer("solve", "lin-case1", "--model", "lin")
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
    left = "style='text-align:left'"
    for words in (f"<th colspan='3' {left}>axial</th></tr>", f"<td {left}>displacement</td>", ">µm</td>"):
        assert words in solved._repr_html_()
    assert "rigidities: contacts alone" in str(solved)
    assert len(solved.balls().splitlines()) == 33
    assert "<script>" not in rollbench.Result({"a<script>": 1.0})._repr_html_()


def test_a_scene_is_a_record_that_can_be_changed(tmp_path: Path) -> None:
    scene = rollbench.read("lin-case1")
    half = replace(scene, loads=tuple(replace(x, force=tuple(0.5 * f for f in x.force)) for x in scene.loads))
    less, whole = (rollbench.solve(one, "lin").load.sum() for one in (half, scene))
    assert less == pytest.approx(0.5 * whole, rel=0.02)
    (tmp_path / "bad.toml").write_text("[track]\nlead = 3\n")
    with pytest.raises(rollbench.InputError):
        rollbench.read(tmp_path / "bad.toml")


def test_compare_and_check_take_stored_references(tmp_path: Path) -> None:
    beside = rollbench.compare_models("lin-case1", ["lin"], store=tmp_path)
    assert beside["models.lin.largest_error_percent"] == pytest.approx(6.15, abs=0.1)
    assert "lin is off by" in str(beside)
    judged = rollbench.check("lin-case1", max_error=1e-3, compute=False, store=tmp_path)
    assert (judged.word, judged.passed) == ("fail", False)
    assert rollbench.check("lin-case1", compute=False, store=tmp_path).passed


def test_several_sets_on_a_shaft() -> None:
    found = rollbench.solve(one_set(small_screw(count=4)), "lin")
    assert found.converged
    assert any(name.endswith("force on shaft") for name, *_ in found.rows())


def test_a_study_of_meshes_takes_stored_runs(tmp_path: Path) -> None:
    study = rollbench.mesh_study("two-balls", store=tmp_path)
    assert [row["level"] for row in study["levels"]] == [1, 3]
    assert study["quantities"]
    with pytest.raises(rollbench.InputError, match="three levels give an order"):
        rollbench.mesh_study("two-balls", levels=9, store=tmp_path)


def test_the_page_of_a_scene_is_written(tmp_path: Path) -> None:
    page = rollbench.report("two-balls", out=tmp_path / "page", store=tmp_path)
    assert page["passed"]
    assert typeset(page["verdict"]) in Path(page["page"]).read_text(encoding="utf-8")
    with pytest.raises(rollbench.InputError, match="quick: got given; allowed: without a scene"):
        rollbench.report("two-balls", quick=True, out=tmp_path / "page")
