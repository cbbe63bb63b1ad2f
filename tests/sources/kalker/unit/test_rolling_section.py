"""Section on rolling in 3D and its gate rows, from the stored runs; the solves behind the rest are replaced."""

import json
from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare.cases.kalker import page as rolling
from rollbench.compare.cases.kalker.evidence import AS_RUNS, BY_GRID, RESOLVED, Verification
from rollbench.compare.cases.kalker.page import SlipAndTractionField
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.scenes import catalogue
from rollbench.compare.scenes.friction_kinds.common import FrictionScene
from rollbench.compare.studies.rolling import rows as rolling_changes
from rollbench.compare.studies.rolling import rows as rolling_rows
from rollbench.compare.studies.rolling import runs
from rollbench.compare.studies.rolling.rows import (
    KNOWN,
    ChoiceEffect,
    RunFromRest,
    force_changes_by_numerical_choices,
    runs_from_rest,
)
from rollbench.reports.content import PressureMap, Text
from rollbench.reports.figures import draw_pressure_map

#: Ball-to-ball forces and torques of the low-order models.
LOW = {"lin-pair-a": 4.0651, "lin-pair-b": 0.0, "lin-screw-pair-a": 0.98316, "lin-screw-pair-b": 1.29143}
LOW |= {"lin-screw-pair-a-inferred": 1.96154, "lin-screw-pair-b-inferred": 2.94679}
LOW |= {"lin-rotary-1": 2.31871, "lin-rotary-2": 20.2245, "lin-rotary-3": 35.5259}
#: A grid beyond those of a run.
BEYOND = (26, 38)


@pytest.fixture
def _low(monkeypatch):
    def low_order(scene):
        name = scene.name.removesuffix(".toml")
        return {"torque N mm" if "rotary" in name else "force 1-2 N": LOW[name]}, 1e-3, "converged"

    monkeypatch.setattr(rolling_rows, "solve_low_order", low_order)


@pytest.mark.usefixtures("_low")
def test_section_shows_both_tables_beside_low_order_and_3d(monkeypatch):
    proof = (
        Verification("Carter", "force", (0.51, 0.505, 0.501), 0.5, 0.5, 0.501),
        Verification("balls that touch, over a patch", "loss", (1.0, 1.0, 0.9), 1.0, 20.0, 0.9),
        *(
            Verification(f"full slip {way}, pole inside", "force", (1.0,) * 3, 1.0, 2.0, 1.0 + 0.01 * error)
            for way, error in ((BY_GRID, -1.5), (RESOLVED, 0.05), (AS_RUNS, 0.02), (AS_RUNS, -0.01))
        ),
    )
    series = (RunFromRest(10, (0.01, 0.02), (0.0, 4.0), ((0.005, 0.004), (0.005, 0.005)), 4.0, 1.0, "converged"),)
    monkeypatch.setattr(rolling, "verifications_of_rolling_model", lambda **_: proof)
    monkeypatch.setattr(rolling, "runs_from_rest", lambda: series)
    values = dict.fromkeys(runs.NAMES, 1.0)
    monkeypatch.setattr(
        rolling,
        "find_body_variants",
        lambda _, **__: runs.StoredBodyChoiceResults((runs.BodyChoiceResult("as shipped", values),), "Kept."),
    )
    at = np.array([[0.0, 0.0], [1e-5, 0.0], [0.0, 1e-5], [1e-5, 1e-5]])
    field = SlipAndTractionField("one", at, 1e-2 * at, 1e12 * at, np.array([True, False, False, False]), (1e-5, 1e-5))
    monkeypatch.setattr(rolling, "slip_and_traction_of_drawn_contacts", lambda: (field,))
    beyond = ChoiceEffect("lin-pair-a", "grid", "finer", 0.5, 0.4)
    monkeypatch.setattr(rolling, "force_changes_by_numerical_choices", lambda *_: (beyond, replace(beyond, change=0.3)))
    section = rolling.make_section(SceneResultCache(), lambda _: None)
    tables = {item.name: item for item in section.items if hasattr(item, "rows")}
    assert tables["rolling-verification"].rows[0]["verdict"] == "reached"
    forces = {row["scene"]: row for row in tables["rolling-pairs"].rows if row["quantity"] == "force 1-2"}
    pair = forces["lin-pair-a"]
    assert (pair["printed"], pair["ansys"], forces["lin-screw-pair-b"]["ansys"], pair["state"]) == (4.01, 3.96, 2.71, None)
    assert abs(pair["error"]) < 2.0
    states = {name: row["state"] for name, row in forces.items() if "screw" in name}
    assert states == {name: "inferred" if "inferred" in name else "plain" for name in LOW if "screw" in name}
    assert {row["scene"] for row in tables["rolling-ring"].rows} == {name for name in LOW if "rotary" in name}
    words = [line for item in section.items if isinstance(item, Text) for line in item.paragraphs]
    assert any("agree to 10 %" in line for line in words)
    assert any("grid alone is 1.5 %" in line and "leaves 0.05 %" in line and "within 0.02 %" in line for line in words)
    assert [row["verdict"] for row in tables["rolling-choices"].rows] == ["beyond", "within"]
    assert section.conclusion
    finite = {row["scene"]: row for row in tables["rolling-bodies"].rows if row["quantity"] in ("force 1-2", "torque")}
    assert set(finite) == set(LOW)
    assert finite["lin-pair-a"]["change"] == pytest.approx(-0.21, abs=0.03)
    assert finite["lin-pair-b"]["change"] is None  # of nothing
    assert all(abs(row["change"] or 0.0) < 0.25 for row in finite.values())
    grids = {row["scene"] for row in tables["rolling-grids"].rows if row["level"] == "source's size"}
    assert grids == {name for name in LOW if "pair" in name}
    maps = {item.name: item for item in section.items if isinstance(item, PressureMap)}
    assert "sticks" in draw_pressure_map(maps["rolling-traction"])
    assert max(maps["rolling-slip"].panels[0].values) == 1.0


@pytest.mark.usefixtures("_low")
def test_gate_fails_where_the_low_order_model_is_off_and_for_a_known_exceedance_that_is_none(monkeypatch):
    rows = rolling_rows.checks_of_rolling_balls(SceneResultCache(), 7.0)
    assert ([row.name for row in rows if not row.passed], len(rows)) == ([], len(LOW))
    monkeypatch.setitem(LOW, "lin-screw-pair-a", 1.05)
    assert sum(not row.passed for row in rolling_rows.checks_of_rolling_balls(SceneResultCache(), 7.0)) == 1
    monkeypatch.setitem(KNOWN, ("lin-rotary-2", "torque"), "made up")
    assert any(
        "made up" in row.name and not row.passed for row in rolling_rows.checks_of_rolling_balls(SceneResultCache(), 7.0)
    )


@pytest.mark.parametrize("name", runs.SCENES)
def test_no_choice_behind_finite_bodies_moves_an_answer_by_more_than_its_uncertainty(name):
    kept = json.loads((shipped_store() / runs.FILE).read_text(encoding="utf-8"))["variants"]
    tried = [
        v["values"]
        for v in kept
        if runs.scenes_and_sizes_of_body_variants()[v["choice"]][0] == name and "half spaces" not in v["choice"]
    ]
    rows = {
        f"{row.quantity} {row.unit}": row
        for row in rolling_rows.compare_scene_with_stored_runs(name, (shipped_store(),), runs.FINITE)
    }
    first, others = tried[0], tried[1:]
    assert len(others) >= 2
    for quantity in runs.NAMES[:3]:
        share = rows[quantity].uncertainty / abs(rows[quantity].reference)
        assert all(abs(values[quantity] / first[quantity] - 1.0) <= share for values in others)


def test_texts_of_a_scene_leave_its_stored_runs_valid():
    scene = catalogue.shipped_scene_of_kind("lin-pair-a", FrictionScene)
    other = replace(scene, name="copy", title="Another title", source="", assumed=("Another assumption.",))
    assert (
        runs.load_rolling_run(other, 1, (shipped_store(),))
        == runs.load_rolling_run(scene, 1, (shipped_store(),))
        is not None
    )


@pytest.mark.slow
@pytest.mark.usefixtures("_low")
def test_no_grid_step_or_path_moves_an_answer_by_more_than_its_uncertainty(monkeypatch):
    """A grid less fine than the report's, but finer than all of a run; the two longest of its steps from rest."""
    monkeypatch.setattr(rolling_changes, "BEYOND", BEYOND)
    monkeypatch.setattr(rolling_changes, "STEPS", rolling_changes.STEPS[:2])
    assert all(cells > most for cells, most in zip(BEYOND, runs.LEVELS[max(runs.LEVELS)], strict=True))
    kept = json.loads((shipped_store() / runs.FILE).read_text(encoding="utf-8"))["variants"]
    series = runs_from_rest.__wrapped__()
    found = force_changes_by_numerical_choices((shipped_store(),), series, [runs.BodyChoiceResult(**row) for row in kept])
    assert [(c.scene, c.choice) for c in found] == [
        *((runs.SCENES[0], choice) for choice in ("grid", "finite bodies", "time step", "path of regularisation")),
        *((runs.SCENES[1], choice) for choice in ("grid", "finite bodies", "path of regularisation")),
    ]
    assert [c for c in found if not c.is_within_uncertainty] == []
    assert all(c.change < 1e-8 for c in found if c.choice.startswith("path"))
    assert all(c.change > 1e-6 for c in found if not c.choice.startswith("path"))
    assert force_changes_by_numerical_choices((), series, ()) == ()


def test_every_shipped_run_has_the_key_of_its_scene():
    files = sorted(shipped_store().glob("rolling-*.json"))
    assert len(files) > 50
    for file in files:
        run = json.loads(file.read_text(encoding="utf-8"))
        scene = catalogue.scene_of_any_kind(run["scene"])
        assert file == runs.rolling_run_path(shipped_store(), scene, run["level"], run.get("bodies", runs.HALF_SPACE)), (
            file.name
        )
