"""``compare`` and ``mesh-study`` of scenes of rolling balls: rows, store, refusals."""

from unittest.mock import Mock

import pytest

from rollbench.compare.errors import InputError
from rollbench.compare.reference import store
from rollbench.compare.reference.jobs import ComputingSettings
from rollbench.compare.scenes import catalogue
from rollbench.compare.studies.rolling import rows as rolling_rows
from rollbench.compare.studies.rolling import runs
from rollbench.compare.studies.rolling.runs import find_or_compute_rolling_runs
from rollbench.hifi.rolling import balls, bodies

ROTARY = catalogue.scene_of_any_kind("lin-rotary-3")


@pytest.fixture(autouse=True)
def _coarse(monkeypatch, tmp_path):
    """Grids that take no time, and no runs but those of the test."""
    monkeypatch.setattr(runs, "LEVELS", {1: (6, 8), 2: (8, 10), 3: (10, 12)})
    monkeypatch.setattr(runs, "QUADRATURES", (24, 27))
    monkeypatch.setattr(store, "shipped_store", lambda: tmp_path / "none")


def test_mesh_study_resumes_from_its_store(command, tmp_path, monkeypatch):
    command.json("mesh-study", "lin-rotary-3", "--levels", "1", "--json", "--store", tmp_path)
    assert len(list(tmp_path.glob("rolling-lin-rotary-3-level1-*.json"))) == 1
    computed = []
    real = runs.compute_run
    monkeypatch.setattr(runs, "compute_run", lambda s, level, *more: computed.append(level) or real(s, level, *more))
    rows = command.answer("mesh-study", "lin-rotary-3", "--levels", "2", "--store", tmp_path)
    assert computed == [2]
    assert {r["level"] for r in rows} == {"1", "2"}
    for r in rows:
        assert r["value"] == pytest.approx(r["rigid_limit"] + r["elasticity"])
        (other,) = (o for o in rows if o["quantity"] == r["quantity"] and o["level"] != r["level"])
        assert r["uncertainty"] > abs(r["value"] - other["value"])


def test_a_grid_is_stored_as_soon_as_it_is_done(tmp_path, monkeypatch):
    """What ends a study later loses no grid that was done before."""
    real, settings = runs.compute_run, ComputingSettings()

    def until_the_second(scene, level, *rest):
        if level == 2:
            raise KeyboardInterrupt
        return real(scene, level, *rest)

    monkeypatch.setattr(runs, "compute_run", until_the_second)
    with pytest.raises(KeyboardInterrupt):
        find_or_compute_rolling_runs(ROTARY, [1, 2], tmp_path, settings, fresh=False)
    assert len(list(tmp_path.glob("rolling-lin-rotary-3-level1-*.json"))) == 1
    kept = find_or_compute_rolling_runs(ROTARY, [1], tmp_path, settings, fresh=False)
    assert rolling_rows.quantity_uncertainty(kept, "torque N mm") == float("inf"), "one grid has none"


def test_the_uncertainty_is_deducted_but_excuses_no_more_than_the_limit():
    for low, bar, within in ((4.07, 0.0, True), (4.1, 0.0, False), (4.1, 0.03, True), (4.2, 1.0, False)):
        errors = 100.0 * (low - 4.0) / 4.0, 100.0 * bar / 4.0
        row = rolling_rows.RollingComparisonRow("a", "force 1-2", "N", low, 4.0, bar, None, None, 0, 0, *errors, 0, 0)
        assert rolling_rows.low_order_error_is_within_limit(row) is within


def test_finite_bodies_have_keys_of_their_own_and_half_spaces_beside_them(command, tmp_path, monkeypatch):
    monkeypatch.setitem(runs.BODIES, "finite", bodies.Sizes(cells=(2, 2), growth=3.0, degree=2))
    words = "compare", "lin-pair-a", "--levels", "1", "--bodies", "finite", "--store", tmp_path
    rows = command.answer(*words)["rows"]
    (force,) = (r for r in rows if r["quantity"] == "force 1-2")
    assert force["half_space"] == pytest.approx(force["reference"], rel=0.02)
    assert force["half_space"] != force["reference"]
    kept = sorted(p.name.rsplit("-", 1)[0] for p in tmp_path.glob("*.json"))
    assert kept == ["rolling-lin-pair-a-finite-level1", "rolling-lin-pair-a-level1"]


def test_the_end_of_a_process_for_want_of_memory_is_bad_input(monkeypatch):
    monkeypatch.setattr(balls, "cache_kernels_of_scenes", Mock(side_effect=MemoryError("ended from outside")))
    with pytest.raises(InputError, match="memory"):
        runs.compute_run(ROTARY, 1)
