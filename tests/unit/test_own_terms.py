"""What condensed bodies know of each contact's own approach: pressures as hats, contacts by active sets, the fitted law."""

from types import SimpleNamespace

import numpy as np
import pytest

from hifi.condensed import approaches, contact_weights
from meshes.condensed import CondensedBodies

FORCES = np.geomspace(40.0, 600.0, 16)
C = 1.4e-7


def bodies(local):
    """Two sides of a ring whose own approaches are given."""
    k = len(local)
    return CondensedBodies(
        "none", 1, np.array([0.0, 3.0]), 0.0, np.eye(2), np.eye(2), np.eye(k), np.array(local), np.tile(FORCES, (k, 1)),
        np.array([C, 2.0 * C]),
    )  # fmt: skip


def test_the_law_of_a_side_is_found_again_whatever_the_force():
    law = [(-2e-9, 9e-12), (1e-10, -3e-11)]
    found = bodies([e + h * np.cbrt(FORCES) for e, h in law])
    for side, expected in zip((0, 3), law, strict=True):
        assert found.own_law(side) == pytest.approx(expected, rel=1e-9)
        assert found.scatter(side) < 1e-12


def test_scatter_is_a_share_of_the_approach():
    wave = 0.002 * np.where(np.arange(FORCES.size) % 2, 1.0, -1.0) * C * np.cbrt(1.0 / FORCES)
    found = bodies([-2e-9 + wave, -2e-9 + wave])
    assert found.scatter(0) == pytest.approx(0.002, rel=0.05)
    assert found.scatter(3) == pytest.approx(0.001, rel=0.05)  # its approach is twice as large
    e, h = found.own_law(0)
    law = e + h * np.cbrt(FORCES)
    assert np.abs(law + 2e-9).max() < 0.5 * np.abs(wave).max()


def patch(x, y, z=np.zeros_like):
    """Contact nodes of a patch on a grid of element boundaries and midpoints."""
    lines = [np.sort(np.concatenate([v, 0.5 * (v[1:] + v[:-1])])) for v in (np.asarray(x), np.asarray(y))]
    X, Y = np.meshgrid(*lines, indexing="ij")
    points = np.stack([X, Y, z(X)], axis=-1).reshape(-1, 3)
    return SimpleNamespace(points=points, shape=X.shape), lines


def test_weights_of_a_flat_grid_are_those_of_bilinear_hats():
    made, (x, y) = patch([0.0, 1.0, 3.0, 4.5], [0.0, 2.0, 3.0])
    W = contact_weights(made)

    def hats(v):  # area of every hat on half cells
        return np.concatenate([[0.0], np.diff(v)]) / 2 + np.concatenate([np.diff(v), [0.0]]) / 2

    assert W.sum(axis=1) == pytest.approx(np.outer(hats(x), hats(y)).ravel(), rel=1e-13)
    assert W.sum() == pytest.approx(4.5 * 3.0, rel=1e-13)
    # displacements' functions: 1 : 4 : 1 along every cell, so that corners, edges and middles carry 1 : 4 : 16
    own = W.sum(axis=0).reshape(made.shape)
    assert own[3, 1] / own[2, 1] == pytest.approx(4 * 2.0 / (1.0 + 2.0), rel=1e-12)
    # linear gaps are weighed exactly: the integral of hat times gap is a product of moments in x and y
    mid, middle = np.diff(x), 2
    inner = mid[middle - 1] * (2 * x[middle] + x[middle - 1]) / 6 + mid[middle] * (2 * x[middle] + x[middle + 1]) / 6
    assert (W @ made.points[:, 0]).reshape(made.shape)[middle] == pytest.approx(inner * hats(y), rel=1e-12)


def test_weights_count_the_surface_and_not_its_shadow():
    made, _ = patch(np.linspace(-0.2, 0.2, 5), np.linspace(0.0, 1.0, 3), lambda x: np.sqrt(1.0 - x**2))
    assert contact_weights(made).sum() == pytest.approx(2 * np.arcsin(0.2), rel=1e-6)


def test_contacts_on_springs():
    """Springs of their own: each carries what the approach closes beyond its gap."""
    rng = np.random.default_rng(3)
    n = 40
    springs, gap, close = rng.uniform(1e-9, 2e-9, n), rng.uniform(0.0, 2e-6, n), rng.uniform(0.9, 1.0, n)
    loads = np.geomspace(1.0, 1e4, 5)
    for load, approach in zip(loads, approaches(np.diag(springs), gap, close, loads), strict=True):
        carried = np.maximum(approach * close - gap, 0.0) / springs @ close
        assert carried == pytest.approx(load, rel=1e-10)
