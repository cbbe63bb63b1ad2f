"""One record per model: complete, and each use of the models takes it from there."""

from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare.errors import InputError
from rollbench.compare.models import comparison, model_form
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import run_model
from rollbench.compare.scenes import catalogue

QUIET = ModelOptions(estimate_beam_mesh_error=False)
CASE1 = catalogue.scene("lin-case1")


def test_a_variant_is_the_model_on_the_changed_scene():
    changed = replace(CASE1, ingredients=replace(CASE1.ingredients, partition="source"))
    found, expected = run_model(CASE1, "lin-source-partition", QUIET), run_model(changed, "lin", QUIET)
    np.testing.assert_array_equal(found.load, expected.load)
    assert found.model == comparison.solution_from_result(found).model == "lin-source-partition"
    assert np.abs(found.load - run_model(CASE1, "lin", QUIET).load).max() > 0.1


def test_the_estimate_speaks_for_the_source_too():
    lin, source, mei = (
        model_form.estimate_model_error(CASE1, run_model(CASE1, name, QUIET)).loads for name in ("lin", "source", "mei")
    )
    assert (source, mei) == (pytest.approx(lin, rel=0.02), None)


@pytest.mark.parametrize(("key", "value"), [("nut_inner_diameter", 9e-3), ("hole_diameter", 1.0)])
def test_a_body_that_cannot_be_built_names_its_key(key: str, value: float) -> None:
    with pytest.raises(InputError) as refused:
        run_model(replace(CASE1, solid=replace(CASE1.solid, **{key: value})), "refined", QUIET)
    assert refused.value.key == f"solid.{key}"
