"""Pytest plug-in of rollbench: the fixture ``rollbench`` judges scenes by their 3D reference."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from rollbench.compare.gate.pytest_plugin import Rollbench


@pytest.fixture
def rollbench(request: pytest.FixtureRequest) -> Rollbench:
    """Fixture to judge scenes, with paths relative to the test file: ``rollbench.check("my.toml", max_error=7)``."""
    from rollbench.compare.gate.pytest_plugin import Rollbench

    return Rollbench(request.path.parent)
