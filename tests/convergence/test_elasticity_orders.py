"""Observed orders of P1, P2, Q1, Q2 on a manufactured solution: k in energy, k + 1 in the mean square displacement."""

import numpy as np
import pytest
from skfem import Functional, condense
from skfem.helpers import ddot, sym_grad
from tests.fe_meshes import boundary_faces, cube, force, space

from rollbench.hifi.elements.forms import elastic_stiffness, isotropic_stress_law
from rollbench.hifi.linear_algebra import factorise_positive_definite
from rollbench.meshes.fem import build_mesh, degrees_of_freedom_on_boundaries, node_coordinates

E, NU = 2.5, 0.25  # lambda = mu = 1
LEVELS = {"P1": (5, 8, 11), "P2": (3, 4, 6), "Q1": (5, 7, 10), "Q2": (3, 4, 6)}
WAVES = np.array([[1.0, 0.7, 0.5], [0.6, 1.1, 0.8], [0.9, 0.5, 1.2]])


def exact(x):
    """u_i = sin(w_i . x), shape (m, 3)."""
    return np.sin(x @ WAVES.T)


def slope(x):
    """du_i/dx_j, shape (m, 3, 3)."""
    return np.cos(x @ WAVES.T)[:, :, None] * WAVES


def body_force(x):
    """-(lambda + mu) grad div u - mu laplace u."""
    s = exact(x)
    return 2.0 * np.einsum("mj,jj,ji->mi", s, WAVES, WAVES) + s * np.sum(WAVES**2, axis=1)


def test_body_force_balances_the_exact_stress():
    x, h = np.random.default_rng(0).random((5, 3)), 1e-4

    def stress(y):
        g = slope(y)
        return np.trace(g, axis1=1, axis2=2)[:, None, None] * np.eye(3) + g + g.swapaxes(1, 2)

    divergence = sum((stress(x + h * d) - stress(x - h * d))[:, :, k] / (2.0 * h) for k, d in enumerate(np.eye(3)))
    np.testing.assert_allclose(-divergence, body_force(x), atol=1e-7)


def at(field, x):
    """A field of places (m, 3) at scikit-fem's places (3, cells, q), components first."""
    values = field(np.moveaxis(x, 0, -1).reshape(-1, 3))
    return np.moveaxis(values.reshape(*x.shape[1:], *values.shape[1:]), (0, 1), (-2, -1))


def errors(name, m):
    """Mean square error of the displacement and energy norm of the error."""
    points, cells = cube(name, m)
    mesh, _ = build_mesh(points, cells, name, {"all": boundary_faces(cells, name)})
    basis = space(mesh, quadrature=None, intorder=6)
    K, load = elastic_stiffness(mesh, E, NU), force(lambda x: at(body_force, x)).assemble(basis)
    u = exact(node_coordinates(mesh)).ravel()
    inner, right, _, loose = condense(K, load, x=u, D=degrees_of_freedom_on_boundaries(mesh, "all"))
    u[loose] = factorise_positive_definite(inner)(right)

    def gap(w):
        return ((w.u - at(exact, w.x)) ** 2).sum(axis=0)

    def density(w):
        true = at(slope, w.x)
        d = sym_grad(w.u) - 0.5 * (true + np.swapaxes(true, 0, 1))
        return ddot(isotropic_stress_law(E, NU)(d), d)

    return np.sqrt([Functional(f).assemble(basis, u=basis.interpolate(u)) for f in (gap, density)])


@pytest.mark.parametrize("name", list(LEVELS))
def test_observed_orders(name):
    levels = LEVELS[name]
    found = np.array([errors(name, m) for m in levels])
    orders = np.log(found[:-1] / found[1:]) / np.log(np.array(levels[1:]) / np.array(levels[:-1]))[:, None]
    np.testing.assert_allclose(orders, np.broadcast_to([int(name[1]) + 1.0, int(name[1])], orders.shape), atol=0.15)
