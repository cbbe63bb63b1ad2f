"""Parameters of a test of which the plain run of the tests takes a few; the others are marked as slow."""

from collections.abc import Collection, Iterable
from typing import Any

import pytest


def all_slow_but(quick: Collection[Any], values: Iterable[Any]) -> list[Any]:
    """Parameters of a test, each a value or a tuple of values; those that are not in ``quick`` are marked as slow."""
    several = [(value, value if isinstance(value, tuple) else (value,)) for value in values]
    return [value if value in quick else pytest.param(*each, marks=pytest.mark.slow) for value, each in several]
