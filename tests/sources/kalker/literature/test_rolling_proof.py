"""Rolling contacts with known answers: all as close as the report says that they are to be."""

from functools import partial

import pytest
from tests.evidence_study import GROUP

from rollbench.compare.cases.external.evidence import EXAMPLE_CELLS, solve_rolling_example
from rollbench.compare.cases.kalker import evidence as rolling_proof
from rollbench.compare.cases.kalker.evidence import FINER, Verification
from rollbench.hifi.rolling.bodies import Sizes

pytestmark = pytest.mark.xdist_group(GROUP)


@pytest.mark.slow
def test_known_answers_are_reached(monkeypatch):
    """On finite bodies of a quarter of the report's cells, which the answers do not tell from those."""
    monkeypatch.setattr(rolling_proof, "Sizes", partial(Sizes, cells=(2, 2)))
    found = rolling_proof.verifications_of_rolling_model.__wrapped__(meshing=False)
    assert [p for p in found if not p.within_permitted_error] == []
    strict = [p for p in found if p.contact_problem.startswith(("Carter", "Cattaneo", "full slip"))]
    loose = "alone", f"{rolling_proof.NARROW:g}"
    strict = [p.permitted_error_percent for p in strict if not any(words in p.contact_problem for words in loose)]
    assert max(strict) == 0.5
    assert sum(reach == 0.1 for reach in strict) == 10


def test_contact_of_another_program_to_its_digits():
    """CONTACT's example fastsim.ref_out, case 1, by its own differences: what its other digits print too."""
    found = solve_rolling_example(EXAMPLE_CELLS, by_contact_scheme=True)
    assert (len(found.normal_contact.cell_centres), int(found.friction_solution.stick[0].sum())) == (1276, 356)
    assert 30.0 * found.friction_loss == pytest.approx(540.4, abs=0.05)


def test_order_counts_the_cells_of_its_own_grids_and_is_none_where_errors_do_not_fall():
    values = (1.0 + 0.1, 1.0 - 0.09, 1.0 + 0.1 / FINER**2)
    assert Verification("", "", values, 1.0, 1.0, values[-1], FINER).convergence_order == pytest.approx(2.0)
    assert Verification("", "", values, 1.0, 1.0, values[-1], None).convergence_order is None
    for others in (values[::-1], *((1.1, middle, 1.01) for middle in (0.89, 1.1, 1.0, 1.001))):
        assert Verification("", "", others, 1.0, 1.0, others[-1]).convergence_order is None


def test_a_narrow_strip_of_stick_has_no_order_and_says_so():
    """Its width changes with where cells lie: errors of -1.9, 0.3 and 0.8 % on ever finer grids."""
    narrow = [p for p in rolling_proof._verify_carter() if "0.95" in p.contact_problem]
    assert [p.convergence_order for p in narrow] == [None, None]
    assert all(p.grid_refinement is None and p.within_permitted_error for p in narrow)
    width = narrow[1]
    errors = [100.0 * (v / width.exact_value - 1.0) for v in width.values_by_grid]
    assert errors == pytest.approx([-1.916, 0.304, 0.807], abs=0.02)
    assert max(abs(errors[1]), abs(errors[2])) < rolling_proof.NARROW_REACH
