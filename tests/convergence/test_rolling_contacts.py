"""Rolling and sliding contacts against closed forms, and the orders at which they get there."""

import numpy as np
import pytest
from scipy.optimize import brentq

from hifi.hertz import hertz
from hifi.rolling.bodies import ball_kernel
from hifi.rolling.patch import hertz_patch
from hifi.rolling.verification import Creep, carter, linear_coefficients, mindlin, slip_everywhere, steady
from lowfi.friction.contact.ellipse import contacts, friction
from meshes.contact_bodies import Zone

#: A contact like those of the linear bearing: load [N], relative radii [m] along and across, modulus [Pa], ratio.
GROOVE = (100.0, (5e-3, 46.667e-3), 210e9, 0.28)


@pytest.mark.parametrize("share", [0.1, 0.25, 0.5, 0.75, 0.9])
def test_carter(share):
    """Creep force to 0.5 %, stick width to a cell, in the first and second halves of the range."""
    found, exact = carter(80, share)
    assert found[0] == pytest.approx(exact[0], rel=5e-3)
    assert found[1] == pytest.approx(exact[1], abs=2.1 / 80)


def test_carter_converges_with_the_grid():
    errors = [abs(carter(n, 0.5)[0][0] - 0.5) for n in (20, 80)]
    assert errors[1] < 0.2 * errors[0]


@pytest.mark.parametrize("share", [0.25, 0.5, 0.75])
def test_cattaneo_and_mindlin(share):
    found, exact = mindlin(18, share)
    assert found[0] == pytest.approx(exact[0], rel=5e-3)
    assert found[1] == pytest.approx(exact[1], abs=2.0 / 18)


def test_cattaneo_and_mindlin_stick_radius_converges():
    errors = [mindlin(n, 0.5)[0][1] - 0.5 ** (1.0 / 3.0) for n in (12, 24)]
    assert abs(errors[1]) < 0.6 * abs(errors[0])


def test_lateral_and_longitudinal_creep_are_alike_without_poisson():
    c = linear_coefficients(1.0, 0.0, (16, 16))
    assert c[0] == pytest.approx(c[1], rel=1e-9)


@pytest.mark.parametrize("spin", [0.0, 30.0, 400.0])
def test_full_slip_is_that_of_rigid_bodies_under_the_same_pressure(spin):
    """Nearly rigid bodies; spin pole far from, near and inside the contact. The grid's error falls with its cells."""
    load, radii, young, poisson = GROOVE
    creep = Creep(0.02, 0.004, spin)
    exact, moment = slip_everywhere(load, radii, young, poisson, creep, 0.1)
    errors = []
    for shape in ((12, 12), (36, 36)):
        found = steady(hertz_patch(load, radii, young, poisson, shape), creep, 0.1, elastic=1e-3)
        assert found.friction.converged
        scale = np.abs(exact).max()
        errors.append(max(np.abs(found.force - exact).max() / scale, abs(found.moment - moment) / (scale * 1e-4)))
    assert errors[1] < 5e-3
    assert errors[1] < max(0.5 * errors[0], 1e-3)


@pytest.mark.parametrize("spin", [30.0, 400.0, 4000.0])
def test_full_slip_is_the_closed_form_of_the_low_order_model(spin):
    """Numbers of the two models at the same load: their axes are exchanged."""
    load, radii, young, poisson = GROOVE
    size = hertz(load, *radii, young, poisson)
    own = contacts(size.semi_y, size.semi_x, load, 0.1)
    low = friction(own, np.array([[0.004, 0.02, spin]]))
    force, moment = slip_everywhere(load, radii, young, poisson, Creep(0.02, 0.004, spin), 0.1)
    assert force == pytest.approx(low.force[0][::-1], rel=1e-3, abs=1e-3)
    assert abs(moment) == pytest.approx(abs(float(low.moment[0])), rel=1e-3)


def test_full_slip_without_spin_is_the_coefficient_of_friction():
    load, radii, young, poisson = GROOVE
    found = steady(hertz_patch(load, radii, young, poisson, (12, 12)), Creep(0.3, 0.4, 0.0), 0.1)
    assert found.force == pytest.approx([-6.0, -8.0], rel=1e-3)
    assert not found.friction.stick[0].any()


@pytest.mark.slow
def test_kernels_of_finite_bodies_converge_with_their_cells():
    """Strains by linear tractions, in which finite bodies differ from half spaces, of a ball along tangents and along the
    normal: order about two on three meshes; the finest is off by less than the change to it."""
    cells = np.array([2, 4, 6])
    zones = [Zone((0.1e-3, 0.4e-3), (c, c), 2.0) for c in cells]
    found = [ball_kernel(5e-3, z, (100.0, 90.0), 210e9, 0.28, 1).M.diagonal()[[2, 4, 5, 8]] for z in zones]
    first, second = np.diff(found, axis=0)
    orders = [brentq(lambda p, r=r: np.divide(*-np.diff(1.0 / cells**p)) - r, 0.1, 6.0) for r in first / second]
    assert np.all((np.array(orders) > 1.6) & (np.array(orders) < 3.5)), orders
    assert np.all(np.abs(second) < 0.05 * np.abs(found[-1]))
