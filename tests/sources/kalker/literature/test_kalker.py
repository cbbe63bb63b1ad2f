"""Kalker (1990), Table E3: the linear creep coefficients to two per cent."""

import pytest
from tests.evidence_study import GROUP
from tests.sources.entries import check, keys

pytestmark = pytest.mark.xdist_group(GROUP)


@pytest.mark.parametrize("key", keys("kalker-E3"))
def test_entry(key):
    check(key)
