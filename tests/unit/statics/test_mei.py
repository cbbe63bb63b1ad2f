"""Mei's model: axial bars for the shaft."""

import numpy as np
import pytest

from rollbench.compare.scenes.catalogue import scene
from rollbench.lowfi.as_source.mei import solve_mei
from rollbench.meshes.helix import lead_angle


def test_axial_balance() -> None:
    """With contacts on all four flanks; on two, the chain of `lowfi.as_source.liu` finds the same loads."""
    s = scene("lin-case3")
    result, slope = solve_mei(s), np.sin(s.track.contact_angle) * np.cos(lead_angle(s.track))
    assert slope * (result.load[:, 0] - result.load[:, 1]).sum() == pytest.approx(5000.0, rel=1e-10)
