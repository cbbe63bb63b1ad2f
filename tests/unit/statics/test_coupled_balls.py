"""The step of the contact forces against whole matrices, and modes of negative compliance of large bodies."""

import numpy as np
import pytest
from tests.helpers import relative

from rollbench.lowfi.compliance import bodies as compliance_modes
from rollbench.lowfi.statics.kernel import elastic as kernels
from rollbench.lowfi.statics.kernel_types import BallRows, Bodies


def body(rng, n, soft=(3000.0, 40.0, 2.0)):
    """Compliance of a body with a few soft modes and a stiff rest."""
    Q, _ = np.linalg.qr(rng.normal(size=(n, n)))
    values = np.append(soft, rng.uniform(0.001, 0.2, n - len(soft)))
    G = (Q * values) @ Q.T
    return 0.5 * (G + G.T)


@pytest.mark.parametrize("hold", [0.0, 0.7])
@pytest.mark.parametrize("free", [0, 1, 3])
@pytest.mark.parametrize("d", [2, 8])
def test_bordered_equations_are_solved(d, free, hold):
    """Balls with any number of rows, between one body or two, free motions held or not; against numpy."""
    rng, count = np.random.default_rng(3), 21
    if d == 2:
        G, second, width = body(rng, 2 * count), np.zeros((0, 0)), 2
        whole = G
    else:
        G, second, width = body(rng, 4 * count), body(rng, 4 * count), 6
        whole = np.zeros((count, 8, count, 8))
        whole[:, :4, :, :4] = G.reshape(count, 4, count, 4)
        whole[:, 4:, :, 4:] = second.reshape(count, 4, count, 4)
        whole = whole.reshape(8 * count, 8 * count)
    R, counts = rng.normal(size=(count, d, free)), rng.integers(0, width + 1, count)
    starts = np.append(0, np.cumsum(counts)[:-1])
    S, flat = rng.normal(size=(count, width, d)), np.zeros((counts.sum(), count, d))
    for i in range(count):
        flat[starts[i] : starts[i] + counts[i], i] = S[i, : counts[i]]
    rows, b, target = flat.reshape(counts.sum(), -1), rng.normal(size=counts.sum()), rng.normal(size=free)
    bodies, u, a = Bodies(G, second, R, np.zeros((count, d)), np.zeros(free)), b.copy(), np.zeros(free)
    assert kernels.solve_rows(bodies, BallRows(S, counts, starts), target, hold, u, a)
    SR = rows @ R.reshape(whole.shape[0], -1)
    K = np.block([[np.eye(len(rows)) + rows @ whole @ rows.T, -SR], [SR.T, hold * np.eye(free)]])
    right = np.linalg.solve(K, np.append(b, target))
    assert relative(u, right[: b.size]) < 1e-9
    assert free == 0 or relative(a, right[b.size :]) < 1e-9


def test_of_large_bodies_only_the_negative_modes_are_sought(monkeypatch):
    """Against all eigenvalues, where more are negative than are looked for at first."""
    monkeypatch.setattr(compliance_modes, "WHOLE", 100)
    monkeypatch.setattr(compliance_modes, "FEW", 4)
    Q = np.linalg.qr(np.random.default_rng(3).normal(size=(600, 600)))[0]
    values = np.concatenate([np.geomspace(1e3, 0.5, 30), np.geomspace(0.2, 1e-3, 566), -1e-3 * np.arange(1, 5)])
    found, least = compliance_modes.negative_part((Q * values) @ Q.T)
    assert relative(found, (Q[:, -4:] * values[-4:]) @ Q[:, -4:].T) < 1e-8
    assert least == pytest.approx(-4e-3, rel=1e-9)


def test_a_large_compliance_that_is_not_finite_is_refused() -> None:
    """A shift that makes it positive would be sought for ever."""
    G = np.eye(compliance_modes.WHOLE + 1)
    G[3, 4] = G[4, 3] = np.nan
    with pytest.raises(ValueError, match="infs or NaNs"):
        compliance_modes.negative_part(G)
