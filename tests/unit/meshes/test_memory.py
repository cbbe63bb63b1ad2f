"""Peak memory of one piece of work: seen, and not inherited from the one before."""

import sys
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest

from rollbench.meshes import processes


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the record can be started again on Linux only")
def test_every_piece_of_work_has_its_own_peak() -> None:
    assert processes.reset_peak_memory()
    before = processes.peak_memory_MB()
    np.ones(40_000_000).sum()
    large = processes.peak_memory_MB()
    assert processes.reset_peak_memory()
    np.ones(5_000_000).sum()
    small = processes.peak_memory_MB()
    assert None not in (before, large, small)
    assert large - before > 250.0
    assert small < large - 200.0


def test_a_record_that_was_not_started_anew_is_not_quoted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(processes, "_stale", False)
    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_text", Mock(side_effect=PermissionError))
        assert not processes.reset_peak_memory()
    assert processes.peak_memory_MB() is None
