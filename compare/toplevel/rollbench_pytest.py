"""What pytest loads where rollbench is installed: the fixture ``rollbench`` judges scenes against their 3D reference.

def test_my_screw(rollbench):
    rollbench.check("my.toml", max_error=7)

A module of its own at the top level: pytest rewrites the assertions of the whole package that a plug-in stands in, and a
user's own ``compare.py`` is not taken for rollbench's package.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from compare.gate.pytest_plugin import Rollbench


@pytest.fixture
def rollbench(request: pytest.FixtureRequest) -> Rollbench:
    """Judges scenes, their paths from the folder of the test: ``rollbench.check("my.toml", max_error=7)``."""
    import rollbench  # noqa: F401 - loads the packages from beside it

    from compare.gate.pytest_plugin import Rollbench

    return Rollbench(request.path.parent)
