"""Error of the beam's partition: none with nodes at the contacts, falling with the element length otherwise."""

from functools import cache

import numpy as np
import pytest
from tests.helpers import relative, solved, with_ingredients

from rollbench.compare.measure import mean_load
from rollbench.compare.models.set_results import SetResult
from rollbench.compare.results.solved import Result
from rollbench.compare.scenes import catalogue
from rollbench.lowfi.statics.nominal import count_nominal_contacts

pytestmark = pytest.mark.xdist_group("partition")

CASES = ("lin-case1", "lin-case2", "lin-case3-offset")
LENGTHS = (16e-3, 8e-3, 4e-3, 2e-3, 1e-3, 0.5e-3)


@cache
def nodal(case):
    return solved(catalogue.scene(case), everything=True).load


@pytest.mark.parametrize("case", CASES)
def test_nodal_partition_is_exact_and_says_so(case):
    """Loaded at its nodes only, the Timoshenko element is exact: splitting it changes nothing but round-off."""
    for refine in (2, 5):
        assert relative(solved(catalogue.scene(case), refine=refine).load, nodal(case)) < 1e-9
    result = solved(catalogue.scene(case), discretisation=True)
    assert result.solver.discretisation < 1e-9 * result.load.max()


@pytest.mark.parametrize("case", CASES)
def test_uniform_partition_converges_monotonically_and_in_first_order_or_more(case, record_property):
    """Forces inside an element are moved to its ends: the compliance misses a kink."""
    scene, errors = catalogue.scene(case), []
    for h in LENGTHS:
        uniform = with_ingredients(scene, partition="uniform", element_length=h)
        errors.append(relative(solved(uniform).load, nodal(case)))
    assert np.all(np.diff(errors) < 0.0), errors
    assert errors[-1] < 1e-3
    order = np.polyfit(np.log(LENGTHS), np.log(errors), 1)[0]
    record_property("order", round(float(order), 3))
    assert 0.8 < order < 2.5, order


@pytest.mark.parametrize("case", CASES)
def test_the_sources_partition_is_within_two_per_cent(case):
    scene = with_ingredients(catalogue.scene(case), partition="source")
    result = solved(scene, discretisation=True)
    error = relative(result.load, nodal(case))
    assert 1e-5 < error < 0.02
    change = np.abs(result.load - nodal(case)).max()
    assert result.solver.discretisation == pytest.approx(change, rel=1e-6)
    contacts = count_nominal_contacts(scene)
    sets = {"": SetResult(parts=scene, balls=result, nominal_contacts=contacts)}
    mean = mean_load(result.load, contacts)
    assert Result(described=scene, solution=result, sets=sets).discretisation_percent == pytest.approx(
        100.0 * change / mean, rel=1e-6
    )
