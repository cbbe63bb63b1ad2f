"""Friction beside a static answer is kept between commands: made once for equal scenes and loads."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from rollbench.compare.models.friction_sums import kept_sums
from rollbench.compare.models.registry import Options, run_model
from rollbench.compare.models.study import with_balls
from rollbench.compare.scenes import catalogue
from rollbench.lowfi.friction.whole import state as whole
from rollbench.meshes import kept


@pytest.fixture
def asked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[list[int]]:
    """How often contacts were taken from a result, with a folder of this test's own."""
    counts: list[int] = []
    taken = whole.contacts_of
    monkeypatch.setattr(whole, "contacts_of", lambda *args: counts.append(1) or taken(*args))
    monkeypatch.setenv("ROLLBENCH_CACHE", str(tmp_path))
    kept.switch_on()
    yield counts
    kept.switch_off()


@pytest.mark.parametrize("neighbours", [False, True])
def test_a_state_is_made_once_for_equal_loads(asked: list[int], neighbours: bool) -> None:
    scene = with_balls(catalogue.scene("lin-case1"), 3)
    scene = replace(scene, friction=replace(scene.friction, neighbours=neighbours))
    options = Options(discretisation=False, engine="interpreted")
    result = run_model(scene, "lin", options)
    first, _ = kept_sums(scene, result, options)
    later = replace(result, solver=replace(result.solver, seconds=9.0, setup_seconds=9.0))
    second, _ = kept_sums(scene, later, options)
    assert len(asked) == 1
    assert second == first
    third, _ = kept_sums(scene, replace(result, load=1.01 * result.load), options)
    assert len(asked) == 2
    assert third is not None
