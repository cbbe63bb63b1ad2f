"""Random bearings and sets: balance, monotony, mirror image, and similarity of bodies of another size."""

from dataclasses import replace

import numpy as np
import pytest
from tests.tapered_row_oracle import solve_thrust_and_radial_equilibrium

from rollbench.lowfi.bearings.angular_contact import BallBearing, bearing_with_contact_angle
from rollbench.lowfi.bearings.axis import BearingRows, solve_bearing_row_equilibrium
from rollbench.lowfi.rollers import TaperedBearing, TaperedRow

SEEDS = range(12)


def ball(rng: np.random.Generator, scale: float = 1.0) -> BallBearing:
    d = scale * rng.uniform(2e-3, 30e-3)
    count, pitch = int(rng.integers(6, 40)), d * rng.uniform(4.0, 12.0)
    conformities, angle = (rng.uniform(0.505, 0.57), rng.uniform(0.505, 0.57)), np.radians(rng.uniform(5.0, 75.0))
    return bearing_with_contact_angle(count, d, pitch, conformities, angle, 207e9, 0.3)


def taper(rng: np.random.Generator, scale: float = 1.0) -> TaperedBearing:
    d = scale * rng.uniform(4e-3, 30e-3)
    gamma = np.radians(rng.uniform(1.0, 5.0))
    cup = 2.0 * gamma + np.radians(rng.uniform(4.0, 50.0))
    return TaperedBearing(int(rng.integers(8, 40)), d, 1.5 * d, cup, gamma, 207e9, 0.3, 0.7 * d)


def any_set(seed: int, scale: float = 1.0) -> tuple[BearingRows, float]:
    """Two to five rows, balls or rollers, facing both ways, and a load of the size of their preload."""
    rng = np.random.default_rng(seed)
    make = (lambda: ball(rng, scale)) if seed % 2 else (lambda: TaperedRow(taper(rng, scale)))
    rows = [make() for _ in range(int(rng.integers(2, 6)))]
    directions = [1, -1, *(int(s) for s in rng.choice([1, -1], len(rows) - 2))]
    load = scale**2 * 10.0 ** rng.uniform(1.0, 4.0)
    offsets = [row.deflection(load * rng.uniform(0.2, 2.0)) for row in rows]
    return BearingRows(tuple(rows), tuple(directions), tuple(offsets)), load


@pytest.mark.parametrize("seed", SEEDS)
def test_balance_monotony_mirror_image_and_similarity(seed: int) -> None:
    """Three times the size under the same pressure: nine times the load, three times the displacement and stiffness."""
    rows, load = any_set(seed)
    before = -np.inf
    for force in load * np.array([-20.0, -1.0, -0.1, 0.0, 0.1, 1.0, 20.0]):
        s = solve_bearing_row_equilibrium(rows, float(force))
        near = 1e-11 * max(abs(force), s.row_thrusts.max())
        assert np.array(rows.directions) @ s.row_thrusts == pytest.approx(force, abs=near)
        assert np.all(s.row_thrusts >= 0.0)
        assert s.displacement > before
        assert s.stiffness > 0.0
        before = s.displacement
    mirror = replace(rows, directions=tuple(-s for s in rows.directions))
    a, b = solve_bearing_row_equilibrium(rows, 0.7 * load), solve_bearing_row_equilibrium(mirror, -0.7 * load)
    assert b.displacement == pytest.approx(-a.displacement, rel=1e-10)
    np.testing.assert_allclose(a.row_thrusts, b.row_thrusts, rtol=1e-9, atol=1e-9 * load)
    large, more = any_set(seed, 3.0)
    a, b = solve_bearing_row_equilibrium(rows, 0.5 * load), solve_bearing_row_equilibrium(large, 0.5 * more)
    np.testing.assert_allclose(b.row_thrusts, 9.0 * a.row_thrusts, rtol=1e-8, atol=1e-8 * load)
    assert b.displacement == pytest.approx(3.0 * a.displacement, rel=1e-7, abs=1e-15)
    assert b.stiffness == pytest.approx(3.0 * a.stiffness, rel=1e-7)


@pytest.mark.parametrize("seed", SEEDS)
def test_combined_load_of_any_tapered_bearing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    b = taper(rng)
    thrust = 10.0 ** rng.uniform(0.0, 5.0)
    for share in (0.0, rng.uniform(0.01, 0.9), 0.98):
        s = solve_thrust_and_radial_equilibrium(b, thrust, share * thrust / np.tan(b.cup_angle))
        assert s.converged
        assert np.all(np.linalg.eigvalsh(s.stiffness) > 0.0)
