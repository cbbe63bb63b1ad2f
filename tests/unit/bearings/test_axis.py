"""Closed formulas of the axis against a chain of springs assembled by hand, and their limits."""

from dataclasses import replace

import numpy as np
import pytest
from tests.helpers import STEEL

from rollbench.lowfi.bearings import as_printed, axis
from rollbench.meshes.axis import Assembly, Segment
from rollbench.meshes.parts import Screw

SHAFT = {"length": 1.3, "area": 9.6e-4, "young": 207e9}
AXIS = axis.ScrewShaftSprings(**SHAFT, left=1.8e9, right=0.9e9)
RIGID, FREE_END = axis.ScrewShaftSprings(**SHAFT), axis.ScrewShaftSprings(**SHAFT, right=0.0)
NUT, EA = 1e9, SHAFT["young"] * SHAFT["area"]


def chain(a: axis.ScrewShaftSprings, x: float, nut: float) -> np.ndarray:
    """Stiffness (4, 4): left end of the shaft, shaft under the nut, right end, carriage; springs to the frame."""
    k = np.diag([a.left, 0.0, a.right, 0.0])
    for i, j, s in ((0, 1, EA / x), (1, 2, EA / (a.length - x)), (1, 3, nut)):
        k[np.ix_([i, j], [i, j])] += s * np.array([[1.0, -1.0], [-1.0, 1.0]])
    return k


@pytest.mark.parametrize("x", [0.01, 0.3, 0.65, 1.2])
@pytest.mark.parametrize("right", [0.9e9, 0.0])
def test_stiffness_and_loads_of_the_supports_are_those_of_the_chain(x, right):
    a = replace(AXIS, right=right)
    u = np.linalg.solve(chain(a, x, NUT), [0.0, 0.0, 0.0, 700.0])
    assert float(axis.carriage_to_frame_stiffness(a, x, NUT)) == pytest.approx(700.0 / u[3], rel=1e-10)
    assert float(axis.shaft_and_support_stiffness(a, x)) == pytest.approx(700.0 / u[1], rel=1e-10)
    on_left, on_right = axis.support_loads(a, x, 700.0, 5e3)
    assert (on_left, on_right) == pytest.approx((5e3 + a.left * u[0], 5e3 - a.right * u[2]), rel=1e-10)
    assert on_left - on_right == pytest.approx(700.0, rel=1e-12)


def test_rigid_supports_give_the_formulas_of_the_source_and_ends_of_the_travel():
    """Beside a support the nut feels it and the whole screw with the other one; a rigid one takes all."""
    x = np.linspace(0.1, 1.2, 12)
    np.testing.assert_allclose(axis.shaft_and_support_stiffness(RIGID, x), EA * 1.3 / (x * (1.3 - x)), rtol=1e-13)
    np.testing.assert_allclose(axis.shaft_and_support_stiffness(FREE_END, x), EA / x, rtol=1e-13)
    left, right = axis.stiffnesses_from_nut_to_frame(AXIS, np.array([0.0, 1.3]))
    np.testing.assert_allclose(left, [1.8e9, 1.0 / (1 / 1.8e9 + 1.3 / EA)], rtol=1e-13)
    np.testing.assert_allclose(right, [1.0 / (1 / 0.9e9 + 1.3 / EA), 0.9e9], rtol=1e-13)
    assert [axis.support_loads(RIGID, x, 100.0) for x in (0.0, 1.3)] == [(100.0, 0.0), (0.0, -100.0)]
    np.testing.assert_allclose(axis.carriage_to_frame_stiffness(RIGID, np.array([0.0, 1.3]), NUT), NUT)
    for x in (-1e-9, 1.3001):
        with pytest.raises(ValueError, match="position"):
            axis.stiffnesses_from_nut_to_frame(AXIS, x)


def test_stretch_and_warming():
    """Between rigid ends F = E A (dL/L - alpha dT); springs share the stretch, and the same warming uses it up."""
    a = 11e-6
    assert axis.shaft_tension(RIGID, 4e-5) == pytest.approx(EA * 4e-5 / 1.3, rel=1e-13)
    assert axis.shaft_tension(RIGID, 4e-5, a, 2.0) == pytest.approx(EA * (4e-5 / 1.3 - a * 2.0), rel=1e-12)
    pulled = axis.shaft_tension(AXIS, 4e-5)
    assert pulled * (1.3 / EA + 1 / AXIS.left + 1 / AXIS.right) == pytest.approx(4e-5, rel=1e-12)
    limit = axis.warming_that_removes_tension(AXIS, 4e-5, a)
    assert axis.shaft_tension(AXIS, 4e-5, a, limit) == pytest.approx(0.0, abs=1e-9 * pulled)
    assert axis.shaft_tension(AXIS, 4e-5, a, 2.0 * limit) == pytest.approx(-pulled, rel=1e-9)
    assert axis.shaft_tension(FREE_END, 4e-5) == 0.0


def test_inertia_of_a_mass_on_the_nut_holds_its_energy():
    """Half m v^2 is half J omega^2; of a bored shaft with a plain stretch each part by hand."""
    speed = axis.screw_angular_speed(0.4, 12e-3)
    assert 0.5 * axis.reflected_inertia(300.0, 12e-3) * speed**2 == pytest.approx(0.5 * 300.0 * 0.4**2, rel=1e-12)
    assert axis.reflected_inertia(300.0, 12e-3, 0.8) == pytest.approx(axis.reflected_inertia(300.0, 12e-3) / 0.8)
    shaft = Assembly("s", "s", Screw(0.5, 30e-3, 0.0, STEEL, 10e-3), (), (Segment(0.0, 0.1, 20e-3, 5e-3),))
    mass = [7850.0 * np.pi / 4.0 * (d**2 - b**2) * n for d, b, n in ((30e-3, 10e-3, 0.4), (20e-3, 5e-3, 0.1))]
    by_hand = [m * (d**2 + b**2) / 8.0 for m, d, b in zip(mass, (30e-3, 20e-3), (10e-3, 5e-3), strict=True)]
    assert axis.screw_inertia(shaft, 7850.0) == pytest.approx(sum(by_hand), rel=1e-12)


def test_sum_in_series_is_softer_than_any_topology():
    """The source's sum, against the chain: with both ends side by side the supports count a fourth of what it takes."""
    k = 1.75e9
    a = axis.ScrewShaftSprings(**SHAFT, left=k, right=k)
    middle = float(axis.shaft_and_support_stiffness(axis.ScrewShaftSprings(**SHAFT), 0.65))
    summed = as_printed.axis_stiffness_as_printed((k, k), middle, NUT)
    right = float(axis.carriage_to_frame_stiffness(a, 0.65, NUT))
    assert 1 / summed - 1 / middle - 1 / NUT == pytest.approx(2.0 / k, rel=1e-12)
    assert 1 / right - 1 / middle - 1 / NUT == pytest.approx(0.5 / k, rel=1e-9)
