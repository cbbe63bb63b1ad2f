"""The order of the reference's method: measured over scenes, stored, read back."""

from dataclasses import replace

import numpy as np
import pytest

from compare.reference import grid_order
from compare.reference.estimate import reference, reference_of
from compare.reference.store import shipped_store
from compare.scenes import catalogue

SIZES = {1: 1.8, 2: 2.4, 3: 3.2}


def made(order, scale, seed, levels=(1, 2, 3)):
    """A reference whose loads converge with that order, from a shipped run."""
    ref = reference(catalogue.scene("lin-case1"))
    base, rng = ref.best, np.random.default_rng(seed)
    slope = scale * rng.normal(size=base.load.shape) * (base.load > 0.0)
    runs = []
    for level in levels:
        settings = base.settings | {"b_over_h": SIZES[level]}
        load = scale * (base.load + slope * (SIZES[3] / SIZES[level]) ** order)
        runs.append(replace(base, level=level, settings=settings, load=load))
    return reference_of(f"scene {seed}", tuple(runs))


def test_scenes_of_any_load_level_count_alike():
    found = grid_order.measured([made(2.5, 1.0, 1), made(2.5, 1e3, 2), made(2.5, 1.0, 3, (2, 3))])
    assert found.order == pytest.approx(2.5, abs=1e-3)
    assert found.scenes == ("scene 1", "scene 2")
    assert found.contacts == 2 * int((reference(catalogue.scene("lin-case1")).load > 0.0).sum())
    assert found.sizes == pytest.approx([3.2 / 1.8, 3.2 / 2.4, 1.0])
    assert grid_order.measured([made(2.5, 1.0, 3, (2, 3))]) is None


def test_record_is_kept_and_a_damaged_one_is_none(tmp_path):
    found = grid_order.measured([made(3.0, 1.0, 4)])
    grid_order.save(tmp_path, found)
    assert grid_order.load([tmp_path / "elsewhere", tmp_path]) == found
    (tmp_path / grid_order.FILE).write_text("{", encoding="utf-8")
    assert grid_order.load([tmp_path]) is None


def test_the_shipped_record_is_that_of_the_shipped_runs():
    """Measured anew it is the same; the references that are shipped are judged by it."""
    kept = grid_order.load([shipped_store()])
    found = grid_order.measured([reference(catalogue.scene(name)) for name in kept.scenes])
    assert found.order == pytest.approx(kept.order, abs=1e-6)
    assert found.interval == pytest.approx(kept.interval, abs=1e-6)
    assert found.contacts == kept.contacts
    assert reference(catalogue.scene("lin-case1")).pooled.by_method
