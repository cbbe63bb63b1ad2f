"""The same draws for each test of friction, in whatever order tests run."""

import numpy as np
import pytest


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(3)
