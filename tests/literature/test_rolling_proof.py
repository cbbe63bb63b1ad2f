"""Rolling contacts with known answers: all as close as the report says that they are to be."""

from functools import partial

import pytest

from compare.evidence import rolling_proof
from compare.evidence.external.contacts import EXAMPLE_CELLS, example
from compare.evidence.rolling_proof import FINER, Proof, proofs
from hifi.rolling.bodies import Sizes
from tests.evidence_study import GROUP

pytestmark = pytest.mark.xdist_group(GROUP)


@pytest.mark.slow
def test_known_answers_are_reached(monkeypatch):
    """On finite bodies of a quarter of the report's cells, which the answers do not tell from those."""
    monkeypatch.setattr(rolling_proof, "Sizes", partial(Sizes, cells=(2, 2)))
    found = proofs.__wrapped__(meshing=False)
    assert [(p.case, p.quantity, p.error) for p in found if not p.reached] == []
    strict = [p.reach for p in found if p.case.startswith(("Carter", "Cattaneo", "full slip")) and "alone" not in p.case]
    assert max(strict) == 0.5
    assert sum(reach == 0.1 for reach in strict) == 10


def test_contact_of_another_program_to_its_digits():
    """CONTACT's example fastsim.ref_out, case 1, by its own differences: what its other digits print too."""
    found = example(EXAMPLE_CELLS, by_cells=True)
    assert (found.cells, found.sticking) == (1276, 356)
    assert 30.0 * found.power == pytest.approx(540.4, abs=0.05)


def test_order_counts_the_cells_of_its_own_grids():
    values = (1.0 + 0.1, 1.0, 1.0 + 0.1 / FINER**2)
    assert Proof("", "", values, 1.0, 1.0, values[-1], FINER).order == pytest.approx(2.0)
    assert Proof("", "", values, 1.0, 1.0, values[-1], None).order is None
    assert Proof("", "", values[::-1], 1.0, 1.0, values[-1]).order is None
