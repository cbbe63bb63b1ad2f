"""Observed orders of P1, P2, Q1, Q2 on a manufactured solution: k in energy, k + 1 in the mean square displacement."""

import numpy as np
import pytest

from hifi.elasticity import load_vector, stiffness, strain_stress
from hifi.elements import ELEMENTS
from hifi.solvers import factor
from tests.fe_meshes import boundary, cube, freedoms

E, NU = 2.5, 0.25  # lambda = mu = 1
LEVELS = {"P1": (8, 12, 16), "P2": (3, 5, 7), "Q1": (6, 9, 13), "Q2": (3, 5, 7)}
WAVES = np.array([[1.0, 0.7, 0.5], [0.6, 1.1, 0.8], [0.9, 0.5, 1.2]])


def exact(x):
    """u_i = sin(w_i . x), shape (m, 3)."""
    return np.sin(x @ WAVES.T)


def slope(x):
    """du_i/dx_j, shape (m, 3, 3)."""
    return np.cos(x @ WAVES.T)[:, :, None] * WAVES


def body_force(x):
    """-(lambda + mu) grad div u - mu laplace u."""
    s = np.sin(x @ WAVES.T)
    grad_div = -np.einsum("mj,jj,ji->mi", s, WAVES, WAVES)
    laplace = -s * np.sum(WAVES**2, axis=1)
    return -2.0 * grad_div - laplace


def test_body_force_balances_the_exact_stress():
    x, h = np.random.default_rng(0).random((5, 3)), 1e-4

    def stress(y):
        g = slope(y)
        return np.trace(g, axis1=1, axis2=2)[:, None, None] * np.eye(3) + g + g.swapaxes(1, 2)

    divergence = sum((stress(x + h * d) - stress(x - h * d))[:, :, k] / (2.0 * h) for k, d in enumerate(np.eye(3)))
    np.testing.assert_allclose(-divergence, body_force(x), atol=1e-7)


def errors(name, m):
    """Mean square error of the displacement and energy norm of the error."""
    points, cells = cube(name, m)
    e = ELEMENTS[name]
    held = freedoms(boundary(points))
    loose = np.setdiff1d(np.arange(3 * len(points)), held)
    K = stiffness(points, cells, name, E, NU).tocsr()
    u = exact(points).ravel()
    force = load_vector(points, cells, name, body_force, degree=6)
    u[loose] = factor(K[loose][:, loose]).solve(force[loose] - K[loose][:, held] @ u[held])
    at, weights = e.rule(6)
    strain, _ = strain_stress(points, cells, name, u, E, NU, at=at)
    where = np.einsum("qa,cai->cqi", e.shape(at), points[cells])
    volume = weights * m**-3 / (1.0 if e.simplex else 8.0)
    gap = np.einsum("qa,cai->cqi", e.shape(at), u.reshape(-1, 3)[cells]) - exact(where.reshape(-1, 3)).reshape(
        where.shape
    )
    g = slope(where.reshape(-1, 3)).reshape(*where.shape, 3)
    true = np.stack(
        [g[..., 0, 0], g[..., 1, 1], g[..., 2, 2]] + [g[..., i, j] + g[..., j, i] for i, j in ((1, 2), (0, 2), (0, 1))],
        axis=-1,
    )
    d = strain - true
    density = d[..., :3].sum(axis=-1) ** 2 + 2.0 * (d[..., :3] ** 2).sum(axis=-1) + (d[..., 3:] ** 2).sum(axis=-1)
    return np.sqrt(((gap**2).sum(axis=-1) * volume).sum()), np.sqrt((density * volume).sum())


@pytest.mark.parametrize("name", list(LEVELS))
def test_observed_orders(name):
    levels = LEVELS[name]
    found = np.array([errors(name, m) for m in levels])
    orders = np.log(found[:-1] / found[1:]) / np.log(np.array(levels[1:]) / np.array(levels[:-1]))[:, None]
    k = ELEMENTS[name].order
    np.testing.assert_allclose(orders, np.broadcast_to([k + 1.0, k], orders.shape), atol=0.15)
