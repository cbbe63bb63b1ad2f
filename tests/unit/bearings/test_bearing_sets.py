"""Sets of rows: tandem, preload, unloading, and the shortcut of equal shares."""

import numpy as np
import pytest

from rollbench.lowfi.bearings import angular_contact, axis

ROW = angular_contact.bearing_with_contact_angle(18, 8.73e-3, 55e-3, (0.52, 0.53), np.radians(57.0), 207e9, 0.3)
TRIPLEX = (1, 1, -1)
solve = axis.solve_bearing_row_equilibrium


class Power:
    """Row of load (1e9 N/m^n) u^n, for closed forms."""

    def __init__(self, n: float) -> None:
        self.n = n

    def thrust(self, deflection: float) -> float:
        return 1e9 * max(deflection, 0.0) ** self.n

    def stiffness(self, deflection: float) -> float:
        return 1e9 * self.n * max(deflection, 0.0) ** (self.n - 1.0) if deflection > 0.0 else 0.0

    def deflection(self, load: float) -> float:
        return (load / 1e9) ** (1.0 / self.n)


@pytest.mark.parametrize("n", [1, 2, 5])
def test_tandem_rows_are_n_times_one(n):
    rows = axis.BearingRows((ROW,) * n, (1,) * n, (0.0,) * n)
    s = solve(rows, 4e3)
    np.testing.assert_allclose(s.row_thrusts, 4e3 / n, rtol=1e-12)
    assert s.displacement == pytest.approx(ROW.deflection(4e3 / n), rel=1e-12)
    assert s.stiffness == pytest.approx(n * ROW.stiffness(s.displacement), rel=1e-12)


def test_opposed_rows_double_the_stiffness_at_preload_and_are_second_order_straight():
    """Preloaded pair: u = F/k to third order, because the curvatures of both rows cancel: half of F, an eighth off."""
    pair = axis.equal_rows_with_preload(ROW, (1, -1), 2e3)
    s = solve(pair)
    np.testing.assert_allclose(s.row_thrusts, 2e3, rtol=1e-11)
    assert s.displacement == pytest.approx(0.0, abs=1e-16)
    assert s.stiffness == pytest.approx(2.0 * ROW.stiffness(ROW.deflection(2e3)), rel=1e-9)
    off = [abs(solve(pair, f).displacement - f / s.stiffness) for f in (800.0, 400.0, 200.0)]
    assert off[0] / off[1] == pytest.approx(8.0, rel=0.05)
    assert off[1] / off[2] == pytest.approx(8.0, rel=0.02)


def test_unloaded_row_leaves_the_rest_alone():
    pair = axis.equal_rows_with_preload(ROW, (1, -1), 1e3)
    limit = axis.lift_off_force(pair)
    just, beyond = solve(pair, 0.999 * limit), solve(pair, 1.5 * limit)
    assert just.row_thrusts[1] > 0.0
    np.testing.assert_array_equal(beyond.row_thrusts[1], 0.0)
    assert beyond.row_thrusts[0] == pytest.approx(1.5 * limit, rel=1e-12)
    assert beyond.row_stiffness[1] == 0.0


@pytest.mark.parametrize("n", [1.0, 1.1, 1.5])
def test_lift_off_of_a_power_law(n):
    pair = axis.equal_rows_with_preload(Power(n), (1, -1), 700.0)
    assert axis.lift_off_force(pair) == pytest.approx(2.0**n * 700.0, rel=1e-12)


def test_triplex_preload_of_a_power_law():
    """Both gaps closed: (P/2)^(1/n) + P^(1/n) = 2 F_p^(1/n), so P/F_p = (2/(1 + 2^(-1/n)))^n; 1.359 for n = 1.5."""
    row = Power(1.5)
    loads = solve(axis.equal_rows_with_gap(row, TRIPLEX, row.deflection(1500.0))).row_thrusts
    expected = 1500.0 * (2.0 / (1.0 + 2.0 ** (-2.0 / 3.0))) ** 1.5
    np.testing.assert_allclose(loads, [expected / 2.0, expected / 2.0, expected], rtol=1e-10)


def test_gap_and_force_describe_one_set():
    by_gap = axis.equal_rows_with_gap(ROW, TRIPLEX, 1.5e-5)
    by_force = axis.equal_rows_with_preload(ROW, TRIPLEX, float(solve(by_gap).row_thrusts[2]))
    assert sum(by_force.preload_deflections[1:]) == pytest.approx(3e-5, rel=1e-10)
    for force, within in ((0.0, 1e-10), (2e3, 1e-7)):
        np.testing.assert_allclose(solve(by_force, force).row_thrusts, solve(by_gap, force).row_thrusts, rtol=within)


def test_a_set_facing_one_way_rests_loose():
    assert np.all(solve(axis.BearingRows((ROW, ROW), (-1, -1), (1e-6, 2e-6))).row_thrusts == 0.0)
