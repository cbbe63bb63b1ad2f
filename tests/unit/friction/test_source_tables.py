"""How the source's way enters the stability table: failures and overlaps counted."""

import numpy as np
import pytest

from rollbench.lowfi.friction.as_source.chain import SourceMotion

pytestmark = pytest.mark.xdist_group("ways of the source")


def motion(force, status) -> SourceMotion:
    n = len(force) + 1
    zero = np.zeros((n, 3))
    return SourceMotion(zero, zero, np.array(force), np.zeros((n, 4)), np.zeros(n - 1), 0.0, 1, status)
