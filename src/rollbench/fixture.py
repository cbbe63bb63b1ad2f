"""What pytest loads where rollbench is installed: the fixture ``rollbench`` judges scenes against their 3D reference.

def test_my_screw(rollbench):
    rollbench.check("my.toml", max_error=7)

Nothing heavy is loaded before a test asks for it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from rollbench.compare.gate.pytest_plugin import Rollbench


@pytest.fixture
def rollbench(request: pytest.FixtureRequest) -> Rollbench:
    """Judges scenes, their paths from the folder of the test: ``rollbench.check("my.toml", max_error=7)``."""
    from rollbench.compare.gate.pytest_plugin import Rollbench

    return Rollbench(request.path.parent)
