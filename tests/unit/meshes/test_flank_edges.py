"""Edges on the flanks of a groove: as long as the coarse element size asks for, no longer than the curvature allows."""

from dataclasses import replace

import numpy as np
import pytest
from tests.helpers import body_specs, small_screw

from rollbench.meshes import groove_map, grooved_body, shell


@pytest.mark.parametrize(("coarse", "share"), [(20e-3, 1.0), (6e-3, 1.0), (6e-3, 0.5)])
def test_longest_edge_of_flanks_follows_the_coarse_size_up_to_the_bend(monkeypatch, coarse, share):
    case = small_screw(2)
    m, spec = groove_map.GrooveMap.of(case), replace(body_specs(case, (0,))["screw"], coarse=coarse, sockets=())
    monkeypatch.setattr(grooved_body.Surface, "_helix", lambda _: [])
    monkeypatch.setattr(grooved_body.Surface, "_ends", lambda *_: None)
    surface = grooved_body.Surface(None, m, spec, share)
    assert surface.flank_limit == pytest.approx(share * min(shell.BEND[0] * m.radius[0], grooved_body.FLANK * coarse))


def test_a_parabola_through_the_longest_edge_misses_the_arc_by_little():
    """Second-order edges: the middle node is exact, the rest of the edge within 1 % of the radius."""
    t = np.linspace(-1.0, 1.0, 201)
    half = 0.5 * shell.BEND[0]
    end, middle = np.array([np.sin(half), np.cos(half)]), np.array([0.0, 1.0])
    ends = (0.5 * t * (t + 1))[:, None] * end + (0.5 * t * (t - 1))[:, None] * (end * [-1, 1])
    curve = ends + (1 - t * t)[:, None] * middle
    assert np.abs(np.linalg.norm(curve, axis=1) - 1.0).max() < 0.01
