"""The step of the contact forces against whole matrices, and modes of negative compliance of large bodies."""

import numpy as np
import pytest
from tests.helpers import relative

from rollbench.lowfi.compliance import modes as compliance_modes


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
