"""Rolling and sliding contacts against closed forms, and the orders at which they get there."""

import numpy as np
import pytest
from scipy.optimize import brentq

from rollbench.hifi.contact.hertz import solve_hertz
from rollbench.hifi.rolling import verification
from rollbench.hifi.rolling.bodies import compliance_kernel_of_ball
from rollbench.hifi.rolling.contact_bodies import ContactZone
from rollbench.hifi.rolling.patch import GridContact, create_cell_grid, solve_elastic_contact_on_grid
from rollbench.hifi.rolling.verification import Creep, solve_steady_rolling_for_creepages
from rollbench.lowfi.friction.contact.laws import contacts_from_values, friction_forces

#: A contact like those of the linear bearing: load [N], relative radii [m] along and across, modulus [Pa], ratio.
GROOVE = (100.0, (5e-3, 46.667e-3), 210e9, 0.28)


@pytest.mark.parametrize(
    ("solve", "cells", "share"),
    [(verification.compare_with_carter, 82, share) for share in (0.1, 0.25, 0.5, 0.75, 0.9)]
    + [(verification.compare_with_mindlin, 28, share) for share in (0.25, 0.5, 0.75)],
)
def test_carter_and_cattaneo_and_mindlin(solve, cells, share):
    """Creep force or shift and stick width to 0.5 %, in the first and second halves of the range."""
    found, exact = solve(cells, share)
    assert found == pytest.approx(exact, rel=5e-3)


@pytest.mark.parametrize("quantity", [0, 1])
def test_carter_converges_with_the_grid(quantity):
    errors = [abs(np.subtract(*verification.compare_with_carter(n, 0.5))[quantity]) for n in (20, 80)]
    assert errors[1] < 0.2 * errors[0]


@pytest.mark.parametrize("share", [0.25, 0.5, 0.75])
def test_cattaneo_and_mindlin_stick_radius_converges(share):
    """In second order; a count of cells, of first, halves its error."""
    errors = [abs(np.subtract(*verification.compare_with_mindlin(n, share))[1]) for n in (14, 28)]
    assert errors[1] < 0.3 * errors[0]


def test_stick_is_measured_by_what_the_tractions_leave_of_their_bound():
    """Uniform remainders of friction on known cells: deviations of a rectangle, exact on any grid, whatever else slips."""
    size = np.array([0.5, 0.25])
    index, at = create_cell_grid((8, 6), size)
    patch = GridContact(index, at, size, np.ones(48), (210e9, 0.3), 0.0)
    held = (index[:, 0] >= 2) & (index[:, 1] < 3)
    forces = np.concatenate([np.where(held, 0.06, 0.1), np.where(held, 0.08, 0.0)])
    bound = np.where(held, 0.3, 0.1)
    found = verification.spread_of_unused_friction(patch, bound, forces)
    assert found == pytest.approx(np.array([3.0, 0.75]) / np.sqrt(12.0))


def test_lateral_and_longitudinal_creep_are_alike_without_poisson():
    c = verification.kalker_linear_coefficients(1.0, 0.0, (16, 16))
    assert c[0] == pytest.approx(c[1], rel=1e-9)
    with pytest.raises(ValueError, match="even number of cells"):
        verification.kalker_linear_coefficients(1.0, 0.0, (16, 15))


def test_half_of_the_cells_gives_the_coefficients_of_all():
    given = 2.0, 0.28, (12, 10)
    patch = verification.create_sticking_elliptic_contact(*given)
    units = np.stack([Creep(*row).rigid_slip(patch.cell_centres) for row in np.eye(3)], axis=1)
    F = units.T @ np.linalg.solve(patch.elastic_slip_per_rolling_length, units)
    assert verification.kalker_linear_coefficients(*given) == pytest.approx([F[0, 0], F[1, 1], F[1, 2], F[2, 2]], rel=1e-10)


@pytest.mark.parametrize("spin", [0.0, 30.0, 400.0])
def test_full_slip_is_that_of_rigid_bodies_under_the_same_pressure(spin):
    """Nearly rigid bodies; spin pole far from, near and inside the contact. The grid's error falls with its cells."""
    creep = Creep(0.02, 0.004, spin)
    exact, moment = verification.friction_at_full_slip_by_quadrature(*GROOVE, creep, 0.1)
    errors, size = [], np.abs(exact).max()
    for shape in ((12, 12), (36, 36)):
        patch = solve_elastic_contact_on_grid(*GROOVE, shape)
        found = solve_steady_rolling_for_creepages(patch, creep, 0.1, elastic=1e-3)
        assert found.friction_solution.converged
        off = np.abs(found.friction_force - exact).max(), abs(found.friction_moment - moment) / 1e-4
        errors.append(max(off) / size)
    assert errors[1] < 5e-3
    assert errors[1] < max(0.5 * errors[0], 1e-3)


def test_the_bias_of_a_spin_pole_inside_a_cell_is_that_of_slip_at_its_centre():
    """Of a per cent and more where the slip is taken at centres; the staircase edge alone leaves less than 0.1 %."""
    creep, patch = Creep(0.02, 0.004, 400.0), solve_elastic_contact_on_grid(*GROOVE, (32, 32))
    exact, moment = verification.friction_at_full_slip_by_quadrature(*GROOVE, creep, 0.1, 1200)
    alone = solve_steady_rolling_for_creepages(patch, creep, 0.1, elastic=1e-3)
    force, turn = verification.friction_at_full_slip_by_cells(patch, creep, 0.1)
    assert abs(alone.friction_force[0] / exact[0] - 1.0) > 0.01
    assert force == pytest.approx(exact, rel=1e-3)
    assert turn == pytest.approx(moment, rel=1e-3)


@pytest.mark.parametrize("spin", [30.0, 400.0, 4000.0])
def test_full_slip_is_the_closed_form_of_the_low_order_model(spin):
    """Numbers of the two models at the same load: their axes are exchanged."""
    load, radii, *elastic = GROOVE
    size = solve_hertz(load, *radii, *elastic)
    contact = contacts_from_values(size.semi_y, size.semi_x, load, 0.1)
    low = friction_forces(contact, np.array([[0.004, 0.02, spin]]))
    force, moment = verification.friction_at_full_slip_by_quadrature(*GROOVE, Creep(0.02, 0.004, spin), 0.1)
    assert force == pytest.approx(low.force[0][::-1], rel=1e-3, abs=1e-3)
    assert abs(moment) == pytest.approx(abs(float(low.moment[0])), rel=1e-3)


def test_full_slip_without_spin_is_the_coefficient_of_friction():
    patch = solve_elastic_contact_on_grid(*GROOVE, (12, 12))
    found = solve_steady_rolling_for_creepages(patch, Creep(0.3, 0.4, 0.0), 0.1)
    assert found.friction_force == pytest.approx([-6.0, -8.0], rel=1e-3)
    assert not found.friction_solution.stick[0].any()


@pytest.mark.slow
def test_kernels_of_finite_bodies_converge_with_their_cells():
    """Strains by linear tractions, in which finite bodies differ from half spaces, of a ball along tangents and along the
    normal: order about two on three meshes; the finest is off by less than the change to it."""
    cells = np.array([2, 4, 6])
    zones = [ContactZone((0.1e-3, 0.4e-3), (c, c), 2.0) for c in cells]
    found = [compliance_kernel_of_ball(5e-3, z, (100.0, 90.0), 210e9, 0.28, 1).M.diagonal()[[2, 4, 5, 8]] for z in zones]
    first, second = np.diff(found, axis=0)
    orders = [brentq(lambda p, r=r: np.divide(*-np.diff(1.0 / cells**p)) - r, 0.1, 6.0) for r in first / second]
    assert np.all((np.array(orders) > 1.6) & (np.array(orders) < 3.5)), orders
    assert np.all(np.abs(second) < 0.05 * np.abs(found[-1]))
