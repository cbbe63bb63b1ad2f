"""Stored runs of the 3D reference: keys, damage, the gate against them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from compare import catalogue, gate, reference
from compare.comparison import gate_points, rows
from compare.reference import Run, key_of, load, needed_sides, path_in, save, settings_of
from compare.study import Study


def run_of(scene_name: str, level: int, load_: np.ndarray) -> Run:
    scene = catalogue.scene(scene_name)
    return Run(
        scene_name, level, "", "converged", load_, np.full(load_.shape, np.nan), load_, 10, 1.0, 0.1, 5.0, 0.0, 0.0,
        settings_of(scene, level), {"rollbench": "x", "gmsh": "y"},
    )  # fmt: skip


def test_round_trip_and_damage(tmp_path: Path) -> None:
    scene = replace(catalogue.scene("lin-case1"), screw=replace(catalogue.scene("lin-case1").screw, bore=1e-3))
    loads = np.arange(128.0).reshape(32, 4)
    file = save(tmp_path, scene, replace(run_of("lin-case1", 2, loads), settings=settings_of(scene, 2)))
    assert file == path_in(tmp_path, scene, 2)
    back = load(scene, 2, stores=(tmp_path,))
    assert back is not None
    assert np.array_equal(back.load, loads)
    assert np.isnan(back.angle).all()
    assert load(scene, 1, stores=(tmp_path,)) is None
    file.write_text(file.read_text()[:100])
    assert load(scene, 2, stores=(tmp_path,)) is None
    assert [p.name for p in tmp_path.iterdir()] == [file.name]


def test_key_follows_the_content_not_the_name() -> None:
    scene = catalogue.scene("lin-case1")
    key = key_of(scene, settings_of(scene, 1))
    assert key_of(replace(scene, title="other", assumed=()), settings_of(scene, 1)) == key
    assert key_of(replace(scene, nut=replace(scene.nut, length=0.055)), settings_of(scene, 1)) != key
    assert key_of(scene, settings_of(scene, 2)) != key


@pytest.mark.parametrize(
    ("name", "sides"),
    [("lin-case1", (0, 3)), ("lin-case2", (0, 3)), ("lin-case3", (0, 1, 2, 3)), ("lin-profile", (0, 1, 2, 3))],
)
def test_sides_that_may_touch(name: str, sides: tuple[int, ...]) -> None:
    assert needed_sides(catalogue.scene(name)) == sides


@pytest.mark.parametrize("name", ["lin-case1", "lin-case2", "lin-case3", "lin-case3-offset"])
def test_shipped_runs_are_converged_and_in_balance(name: str) -> None:
    found = reference.reference(catalogue.scene(name))
    assert found is not None
    for run in found.runs:
        assert run.status == "converged"
        assert run.balance < 1e-8
        assert abs(run.along_groove) < 1e-3
    slope = np.sin(np.radians(found.runs[-1].angle[:, 0])) @ found.load[:, 0]
    if not found.load[:, 1].any():
        lead = np.cos(np.arctan(20.0 / (2.0 * np.pi * 16.5)))
        assert slope * lead == pytest.approx(5000.0, rel=1e-3)


def test_low_order_model_passes_and_a_wrong_stiffness_does_not(monkeypatch: pytest.MonkeyPatch) -> None:
    """The gate must see a low-order stiffness that is off by 20 per cent."""
    assert all(row.passed for row in gate.reference_rows(Study(), 7.0))
    import lowfi.problem
    from meshes.section import BeamSection

    right = lowfi.problem.screw_section

    def soft(scene):  # type: ignore[no-untyped-def]
        s = right(scene)
        return BeamSection(0.8 * s.EA, 0.8 * s.EI, 0.8 * s.GJ, 0.8 * s.kGA)

    before = [p.error_percent for p in gate_points(catalogue.scene("lin-case1"), _found("lin-case1"), 7.0)]
    monkeypatch.setattr(lowfi.problem, "screw_section", soft)
    after = [p.error_percent for p in gate_points(catalogue.scene("lin-case1"), _found("lin-case1"), 7.0)]
    assert max(np.abs(np.array(after) - np.array(before))) > 1.0


def _found(name: str) -> reference.Reference:
    found = reference.reference(catalogue.scene(name))
    assert found is not None
    return found


def test_unnamed_exceedance_and_vanished_one_fail(monkeypatch: pytest.MonkeyPatch) -> None:
    from compare import comparison

    worst = max(gate_points(catalogue.scene("lin-case1"), _found("lin-case1"), 7.0), key=lambda p: abs(p.error_percent))
    limit = abs(worst.error_percent) - worst.uncertainty_percent - 0.01
    failed = [r for r in gate.reference_rows(Study(), limit) if not r.passed]
    assert any(f"ball {worst.ball} {worst.side}" in r.name for r in failed)
    gone = comparison.Exceedance("lin-case1", 5, "SL", "no cause")
    known = comparison.known_exceedances()
    monkeypatch.setattr(comparison, "known_exceedances", lambda: [*known, gone])
    assert any("has gone" in r.detail for r in gate.reference_rows(Study(), 7.0))


def test_rows_name_every_loaded_contact() -> None:
    scene = catalogue.scene("lin-case1")
    found = rows(scene, "lin", _found("lin-case1"))
    assert sum(r.quantity == "load" for r in found) == 64
    assert {r.unit for r in found} == {"N", "%"}
