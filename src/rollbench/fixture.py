"""Pytest plug-in of rollbench, whose fixture ``rollbench`` judges scenes against their 3D reference inside tests."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from rollbench.compare.gate.pytest_plugin import Rollbench


@pytest.fixture
def rollbench(request: pytest.FixtureRequest) -> Rollbench:
    """Return an object whose method ``check`` judges a scene: ``rollbench.check("my.toml", max_error=7)``.

    Paths of scene files are relative to the test file.
    """
    from rollbench.compare.gate.pytest_plugin import Rollbench

    return Rollbench(request.path.parent)
