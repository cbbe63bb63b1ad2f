"""Influence of tractions on rectangles: against quadrature of the point forces, symmetry, pressures."""

import numpy as np
import pytest
from scipy.integrate import dblquad
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

from rollbench.hifi.rolling import patch as rolling_patch

E, NU = 210e9, 0.28
#: Johnson (1985): displacements (row) by unit point forces (column) at (x, y), shear modulus g, ratio n.
POINT = {
    (0, 0): lambda x, y, g, n: ((1 - n) / np.hypot(x, y) + n * x * x / np.hypot(x, y) ** 3) / (2 * np.pi * g),
    (1, 1): lambda x, y, g, n: POINT[0, 0](y, x, g, n),
    (0, 1): lambda x, y, g, n: n * x * y / np.hypot(x, y) ** 3 / (2 * np.pi * g),
    (2, 2): lambda x, y, g, n: (1 - n) / np.hypot(x, y) / (2 * np.pi * g),
}


@pytest.mark.parametrize("entry", list(POINT))
@pytest.mark.parametrize("at", [(3e-4, 1e-4), (-2e-4, 2.5e-4)])
def test_against_quadrature(entry, at):
    dx, dy = 1e-4, 2e-4

    def integrand(v, u):
        return 2.0 * POINT[entry](at[0] - u, at[1] - v, 0.5 * E / (1.0 + NU), NU)

    exact = dblquad(integrand, -dx / 2, dx / 2, -dy / 2, dy / 2)[0]
    assert rolling_patch.displacement_by_rectangle(np.array(at[0]), np.array(at[1]), dx, dy, E, NU)[entry] == pytest.approx(
        exact, rel=1e-9
    )


def hertz(load, radii, modulus):
    """Approach and largest pressure by Johnson (1985), 4.22 to 4.24 for a sphere and 4.26 with Legendre's integrals."""
    least, most = sorted(0.5 / np.array(radii))
    if least == most:
        a = (0.75 * load * radii[0] / modulus) ** (1.0 / 3.0)
        return a * a / radii[0], 1.5 * load / (np.pi * a * a)

    def terms(r):
        m = 1.0 - r * r
        return (ellipk(m) - ellipe(m)) / m, (ellipe(m) / (r * r) - ellipk(m)) / m

    r = brentq(lambda r: terms(r)[1] / terms(r)[0] - most / least, 1e-3, 1.0 - 1e-9)  # r = b/a
    a = (1.5 * load * terms(r)[0] / (np.pi * modulus * least)) ** (1.0 / 3.0)
    pressure = 1.5 * load / (np.pi * r * a * a)
    return pressure / modulus * r * a * ellipk(1.0 - r * r), pressure


@pytest.mark.parametrize("radii", [(2.778e-3, 2.778e-3), (5e-3, 4e-2), (4e-2, 5e-3)])
def test_pressure_of_a_sphere_and_of_an_ellipse_is_hertz(radii):
    """Cells are longer along the ellipse's longer axis."""
    patch = rolling_patch.solve_elastic_contact_on_grid(225.0, radii, E, NU, (24, 24) if radii[0] == radii[1] else (28, 20))
    assert patch.normal_load == pytest.approx(225.0, rel=1e-12)
    approach, pressure = hertz(225.0, radii, 0.5 * E / (1.0 - NU**2))
    assert patch.approach == pytest.approx(approach, rel=2e-3)
    assert patch.normal_forces.max() / patch.cell_size.prod() == pytest.approx(pressure, rel=1e-2)


def test_pressure_and_gap_are_complementary():
    cells, at = rolling_patch.create_cell_grid((14, 14), np.array([2e-5, 2e-5]))
    gap = 0.5 * (at**2).sum(axis=1) / 1e-3
    forces, approach = rolling_patch.solve_normal_contact(cells, np.array([2e-5, 2e-5]), gap, 5.0, (2e11, 0.3))
    assert np.all(forces >= 0.0)
    assert 0 < np.count_nonzero(forces) < forces.size
    assert approach > gap[forces > 0.0].max()


def test_a_similar_contact_is_the_unit_one_scaled():
    unit = rolling_patch.solve_elastic_contact_on_grid(1.0, (5e-3, 4e-2), E, NU, (10, 10))
    unit.elastic_slip_per_rolling_length  # noqa: B018 - computed once
    direct = rolling_patch.solve_elastic_contact_on_grid(64.0, (5e-3, 4e-2), E, NU, (10, 10))
    scaled = unit.similar_contact(4.0, 64.0)
    assert scaled.normal_forces == pytest.approx(direct.normal_forces, rel=1e-9)
    assert scaled.approach == pytest.approx(direct.approach, rel=1e-9)
    assert (
        np.abs(scaled.elastic_slip_per_rolling_length - direct.elastic_slip_per_rolling_length).max()
        < 1e-9 * np.abs(direct.elastic_slip_per_rolling_length).max()
    )
