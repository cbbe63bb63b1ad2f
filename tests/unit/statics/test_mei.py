from dataclasses import replace

import numpy as np
import pytest

from rollbench.comparison.scenes.catalogue import scene
from rollbench.lowfi.statics.mei import solve_mei
from rollbench.lowfi.statics.problem import nominal_hertz
from rollbench.meshes.helix import lead_angle
from rollbench.meshes.parts import Material


def test_loads_fall_steadily_from_the_loaded_end() -> None:
    load = solve_mei(scene("lin-case1")).load
    assert np.all(np.diff(load[:, 0]) < 0.0)
    assert not load[:, [1, 2]].any()


def test_axial_balance() -> None:
    s = scene("lin-case3")
    result = solve_mei(s)
    slope = np.sin(s.track.contact_angle) * np.cos(lead_angle(s.track))
    assert slope * (result.load[:, 0] - result.load[:, 1]).sum() == pytest.approx(5000.0, rel=1e-10)


def test_stiff_shaft_shares_the_load_evenly() -> None:
    s = scene("lin-case1")
    stiff = replace(s, screw=replace(s.screw, outer_diameter=s.screw.outer_diameter, material=Material(210e16, 0.28)))
    load = solve_mei(stiff).load[:, 0]
    slope = np.sin(s.track.contact_angle) * np.cos(lead_angle(s.track))
    assert load == pytest.approx(np.full(32, 5000.0 / (32 * slope)), rel=1e-5)


def test_two_balls_by_hand() -> None:
    """Two springs k1, k2 (Hertz, linearised by solving the scalar equation) joined by a bar of the screw."""
    s = scene("lin-case1")
    two = replace(s, balls=replace(s.balls, azimuths=(-np.pi, np.pi)))
    load = solve_mei(two).load[:, 0]
    c = nominal_hertz(s).C
    pair = float(c[0] + c[3])
    slope = np.sin(s.track.contact_angle) * np.cos(lead_angle(s.track))
    from rollbench.meshes.section import screw_section

    bar = screw_section(s).EA / 20e-3
    u = pair * load ** (2 / 3) / slope
    assert bar * (u[0] - u[1]) == pytest.approx(slope * load[1], rel=1e-9)


def test_elastic_nut_makes_the_first_balls_carry_more() -> None:
    rigid, elastic = (solve_mei(scene("lin-case1"), elastic_nut=e).load[:, 0] for e in (False, True))
    assert elastic[0] > rigid[0]
    assert elastic.sum() == pytest.approx(rigid.sum(), rel=1e-9)
