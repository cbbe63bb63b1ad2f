"""A scene over its load."""

from dataclasses import replace

import pytest
from tests.helpers import small_screw

from rollbench.compare.models import loading
from rollbench.compare.models.registry import Options, run_model
from rollbench.lowfi.rating.rigidity import axial_displacement
from rollbench.lowfi.statics.result import Status

SCENE, OPTIONS = small_screw(force=(0.0, 0.0, 300.0), oversize=3e-6), Options(discretisation=False)


def test_displacements_are_counted_from_the_scene_without_loads_where_that_is_solved():
    at = {f: axial_displacement(SCENE, run_model(loading.scaled(SCENE, f), "lin", OPTIONS)) for f in (0.0, 0.5, 1.0)}
    alone = loading.curve(SCENE, (0.5, 1.0), "lin", OPTIONS)
    assert [p.displacement for p in alone] == pytest.approx([at[0.5], at[1.0]], rel=1e-9)
    whole = loading.curve(SCENE, (0.0, 0.5, 1.0), "lin", OPTIONS)
    assert [p.displacement for p in whole] == pytest.approx([0.0, at[0.5] - at[0.0], at[1.0] - at[0.0]], rel=1e-9)


@pytest.mark.parametrize("good", [0, 1])
def test_a_search_for_lift_off_that_ends_early_counts_its_solutions_and_says_where(good, monkeypatch):
    full, bare = (run_model(loading.scaled(SCENE, f), "lin", OPTIONS) for f in (1.0, 0.0))
    asked = []

    def solved(_scene, factor, model, options):
        asked.append(factor)
        found = run_model(loading.scaled(SCENE, factor), model, options)
        return found if len(asked) <= good else replace(found, status=Status("not converged", "as if"))

    monkeypatch.setattr(loading, "solve_scaled", solved)
    found = loading.lift_off(SCENE, full, bare, "lin", OPTIONS)
    assert (found.factor, found.solves) == (None, len(asked)) == (None, good + 1)
    assert found.words == f"not found: at {asked[-1]:.3g} times the loads not converged: as if"
