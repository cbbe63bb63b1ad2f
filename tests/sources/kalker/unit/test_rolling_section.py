"""Section on rolling in 3D and its gate rows, from the stored runs; the solves behind the rest are replaced."""

import json
from dataclasses import replace

import pytest

from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.scenes import catalogue
from rollbench.compare.scenes.duty_cycle import FrictionScene
from rollbench.compare.studies.rolling import rows as rolling_rows
from rollbench.compare.studies.rolling import runs

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
def test_gate_fails_where_the_low_order_model_is_off_and_for_a_known_exceedance_that_is_none(monkeypatch):
    rows = rolling_rows.checks_of_rolling_balls(SceneResultCache(), 7.0)
    assert ([row.subject for row in rows if not row.passed], len(rows)) == ([], len(LOW))
    monkeypatch.setitem(LOW, "lin-screw-pair-a", 1.05)
    assert sum(not row.passed for row in rolling_rows.checks_of_rolling_balls(SceneResultCache(), 7.0)) == 1
    monkeypatch.setitem(rolling_rows.KNOWN, ("lin-rotary-2", "torque"), "made up")
    rows = rolling_rows.checks_of_rolling_balls(SceneResultCache(), 7.0)
    assert [row.passed for row in rows if "made up" in row.subject] == [False]


def stored_variants():
    """Stored results with other choices of finite bodies."""
    return json.loads((shipped_store() / runs.FILE).read_text(encoding="utf-8"))["variants"]


@pytest.mark.parametrize("name", runs.SCENES)
def test_no_choice_behind_finite_bodies_moves_an_answer_by_more_than_its_uncertainty(name):
    scenes = runs.scenes_and_sizes_of_body_variants()
    of_scene = [v for v in stored_variants() if scenes[v["choice"]][0] == name]
    first, *others = [v["values"] for v in of_scene if "half spaces" not in v["choice"]]
    found = rolling_rows.compare_scene_with_stored_runs(name, (shipped_store(),), runs.FINITE)
    rows = {f"{row.quantity} {row.unit}": row for row in found}
    assert len(others) >= 2
    for quantity in runs.NAMES[:3]:
        share = rows[quantity].uncertainty / abs(rows[quantity].reference)
        assert all(abs(values[quantity] / first[quantity] - 1.0) <= share for values in others)


def test_texts_of_a_scene_leave_its_stored_runs_valid():
    scene = catalogue.shipped_scene_of_kind("lin-pair-a", FrictionScene)
    other = replace(scene, name="copy", title="Another title", source="", assumed=("Another assumption.",))
    mine, stored = (runs.load_rolling_run(one, 1, (shipped_store(),)) for one in (other, scene))
    assert mine == stored is not None


@pytest.mark.slow
@pytest.mark.usefixtures("_low")
def test_no_grid_step_or_path_moves_an_answer_by_more_than_its_uncertainty(monkeypatch):
    """A grid less fine than the report's, but finer than all of a run; the two longest of its steps from rest."""
    monkeypatch.setattr(rolling_rows, "BEYOND", BEYOND)
    monkeypatch.setattr(rolling_rows, "STEPS", rolling_rows.STEPS[:2])
    assert all(cells > most for cells, most in zip(BEYOND, runs.LEVELS[max(runs.LEVELS)], strict=True))
    series = rolling_rows.runs_from_rest.__wrapped__()
    kept = {row["choice"]: row["values"] for row in stored_variants()}
    found = rolling_rows.force_changes_by_numerical_choices((shipped_store(),), series, kept)
    choices = "grid", "finite bodies", "time step", "path of regularisation"
    both = [(scene, choice) for scene in runs.SCENES for choice in choices]
    assert [(c["scene"], c["numerical_setting"]) for c in found] == [
        one for one in both if one != (runs.SCENES[1], "time step")
    ]
    assert [c for c in found if c["change_within_uncertainty"] != "within"] == []
    assert all(c["largest_force_change"] < 1e-8 for c in found if c["numerical_setting"].startswith("path"))
    assert all(c["largest_force_change"] > 1e-6 for c in found if not c["numerical_setting"].startswith("path"))
    assert rolling_rows.force_changes_by_numerical_choices((), series, {}) == []


def test_every_shipped_run_has_the_key_of_its_scene():
    files = sorted(shipped_store().glob("rolling-*.json"))
    assert len(files) > 50
    for file in files:
        run = json.loads(file.read_text(encoding="utf-8"))
        scene, bodies = catalogue.scene_of_any_kind(run["scene"]), run.get("bodies", runs.HALF_SPACE)
        assert file == runs.rolling_run_path(shipped_store(), scene, run["level"], bodies)
