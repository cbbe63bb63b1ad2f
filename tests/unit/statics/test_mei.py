from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare.scenes.catalogue import scene
from rollbench.lowfi.statics.contacts import hertz_without_errors
from rollbench.lowfi.statics.mei import solve_mei
from rollbench.meshes.helix import lead_angle
from rollbench.meshes.parts import Material, Scene
from rollbench.meshes.section import screw_section


def slope_of(s: Scene) -> float:
    return float(np.sin(s.track.contact_angle) * np.cos(lead_angle(s.track)))


def test_loads_fall_steadily_from_the_loaded_end_more_so_in_an_elastic_nut() -> None:
    load, elastic = solve_mei(scene("lin-case1")).load, solve_mei(scene("lin-case1"), elastic_nut=True).load[:, 0]
    assert np.all(np.diff(load[:, 0]) < 0.0)
    assert not load[:, [1, 2]].any()
    assert elastic[0] > load[0, 0]
    assert elastic.sum() == pytest.approx(load[:, 0].sum(), rel=1e-9)


def test_axial_balance() -> None:
    s = scene("lin-case3")
    result = solve_mei(s)
    assert slope_of(s) * (result.load[:, 0] - result.load[:, 1]).sum() == pytest.approx(5000.0, rel=1e-10)


def test_stiff_shaft_shares_the_load_evenly() -> None:
    s = scene("lin-case1")
    stiff = replace(s, screw=replace(s.screw, material=Material(210e16, 0.28)))
    assert solve_mei(stiff).load[:, 0] == pytest.approx(np.full(32, 5000.0 / (32 * slope_of(s))), rel=1e-5)


def test_two_balls_by_hand() -> None:
    """Two springs k1, k2 (Hertz, linearised by solving the scalar equation) joined by a bar of the screw."""
    s = scene("lin-case1")
    two = replace(s, balls=replace(s.balls, azimuths=(-np.pi, np.pi)))
    load = solve_mei(two).load[:, 0]
    c, bar = hertz_without_errors(s).C, screw_section(s).EA / 20e-3
    u = float(c[0] + c[3]) * load ** (2 / 3) / slope_of(s)
    assert bar * (u[0] - u[1]) == pytest.approx(slope_of(s) * load[1], rel=1e-9)
