"""The report's sections on how a nut is held, on external evidence, and on u_val: what their tables are made of."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from rollbench.compare.cases.external import page
from rollbench.compare.cases.external.evidence import scene_name_of_catalogue_size
from rollbench.compare.measure import load_error
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import run_model
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.scenes import catalogue
from rollbench.hifi.condensation import points_clamped_by_bolts
from rollbench.lowfi.rating.rigidity import approach_per_displacement
from rollbench.meshes.solid import dimensions_of_3d_parts


def test_ways_differ_in_how_the_nut_is_held_alone() -> None:
    scene = catalogue.scene(scene_name_of_catalogue_size("bnf-4010-5"))
    found = page.scenes_by_nut_fixation(scene)
    held = [dimensions_of_3d_parts(x).nut_held for x in found.values()]
    flange = ["flange face"] * 3 + ["flange face, 6 bolts", "flange face and centring"]
    assert held == ["left face", "right face", "outer surface", *flange]
    for other in found.values():
        assert replace(other, nut=scene.nut, solid=scene.solid) == scene
    inner, outer = (found[f"flange, {x} half of its face"].nut.flange for x in ("inner", "outer"))
    assert inner.seat[1] == outer.seat[0] == pytest.approx(51.25e-3)


STORED = page.stored_fixation_results(shipped_store())
SOLVED = sorted({(row["scene"], row["level"]) for row in STORED})


@pytest.mark.parametrize(("name", "level"), SOLVED)
def test_the_record_has_annulus_and_left_face_of_a_size(name: str, level: int) -> None:
    """Bolts hold less than the annulus; the loads of either way carry the scene's axial load."""
    scene = catalogue.shipped_scene(name)
    kept = {row["held"]: row for row in STORED if (row["scene"], row["level"]) == (name, level)}
    assert {"left face", page.WHOLE} <= set(kept) <= set(page.scenes_by_nut_fixation(scene))
    if page.BOLTED in kept:
        assert kept[page.BOLTED]["rigidity"] < kept[page.WHOLE]["rigidity"]
    for row in kept.values():
        load = page.loads_of_stored_result(row)
        assert row["status"] == "converged"
        assert load.shape == (scene.ball_count, 4)
        assert load.max(axis=1).sum() * approach_per_displacement(scene) == pytest.approx(scene.loads[0].force[2], rel=0.05)


ON_FLANGES = [row for row in STORED if row["held"].startswith("flange") and row["held"] != page.BOLTED]


@pytest.mark.parametrize("row", ON_FLANGES, ids=lambda x: f"{x['scene']}, {x['held']}, {x['level']}")
def test_refined_is_as_near_to_3d_on_a_flange_as_on_a_face(row: dict[str, Any]) -> None:
    """Within 0.6 % of the mean load (0.2 % RMS), whichever annulus is held; 1.1 % (0.4 %) of the outer half while what is
    far from a face rested on nothing."""
    scene = page.scenes_by_nut_fixation(catalogue.shipped_scene(row["scene"]))[row["held"]]
    found = run_model(scene, "refined", ModelOptions(estimate_beam_mesh_error=False))
    off = load_error(found.load, page.loads_of_stored_result(row))
    assert off.max_percent < 0.6
    assert off.rms_percent < 0.2


def test_six_bolts_hold_six_circles_of_the_annulus() -> None:
    """Of points spread evenly over the annulus, the share that is held is that of the circles' areas."""
    scene = page.scenes_by_nut_fixation(catalogue.scene(scene_name_of_catalogue_size(page.SIZES[0])))[page.BOLTED]
    low, high = dimensions_of_3d_parts(scene).held_radii
    x, y = np.meshgrid(*2 * [np.linspace(-high, high, 801)])
    held = points_clamped_by_bolts(x.ravel(), y.ravel(), (low, high), page.BOLTS)
    width = high - low
    assert held.mean() * (2.0 * high) ** 2 == pytest.approx(6 * np.pi * width**2 / 4.0, rel=0.01)
    sixths = np.arctan2(y.ravel()[held], x.ravel()[held]) * 3.0 / np.pi
    assert set(np.round(sixths).astype(int) % 6) == set(range(6))
    assert np.abs(sixths - np.round(sixths)).max() < 0.25
