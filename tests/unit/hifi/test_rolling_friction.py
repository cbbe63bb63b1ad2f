"""Coulomb friction on grids: complementarity to round-off, energy, and answers that do not depend on the way to them."""

import numpy as np
import pytest

from rollbench.hifi.rolling import friction
from rollbench.hifi.rolling.patch import solve_elastic_contact_on_grid
from rollbench.hifi.rolling.verification import Creep, solve_friction_for_rigid_slip, solve_steady_rolling_for_creepages

PATCH = solve_elastic_contact_on_grid(100.0, (5e-3, 46.667e-3), 210e9, 0.28, (16, 16))
MU = 0.1
CREEPS = {
    "stick and slip": Creep(1e-4, 2e-4, 0.0),
    "spin": Creep(0.0, 0.0, 20.0),
    "spin pole inside": Creep(1e-3, 0.0, 10.0),
    "pole outside": Creep(1e-2, 0.0, 10.0),
    "little": Creep(1e-7, 0.0, 0.0),
}


@pytest.mark.parametrize("name", list(CREEPS))
def test_coulomb_holds_in_every_cell_to_round_off_and_the_power_put_in_is_lost(name):
    """Dissipated, or lost by the differences along the flow."""
    creep = CREEPS[name]
    found = solve_steady_rolling_for_creepages(PATCH, creep, MU)
    power = -float(found.friction_solution.forces[0] @ creep.rigid_slip(PATCH.cell_centres))
    assert found.friction_loss >= -1e-9 * power
    assert found.numerical_dissipation >= 0.0
    assert found.friction_loss + found.numerical_dissipation == pytest.approx(power, rel=1e-9)
    assert found.friction_solution.converged
    q, s = (v.reshape(2, -1) for v in (found.friction_solution.forces[0], found.friction_solution.slips[0]))
    bound, size, speed = MU * PATCH.normal_forces, np.hypot(*q), np.hypot(*s)
    stick = found.friction_solution.stick[0]
    assert np.all(size <= bound * (1.0 + 1e-9))
    assert np.all(speed[stick] <= 1e-9 * max(speed.max(), 1e-12 + np.abs(creep.rigid_slip(PATCH.cell_centres)).max()))
    assert size[~stick] == pytest.approx(bound[~stick], rel=1e-9)
    against = (q * s).sum(axis=0)[~stick] + (size * speed)[~stick]
    assert np.abs(against).max(initial=0.0) <= 1e-9 * (size * speed).max()


def test_differences_lose_energy_only_and_the_answer_does_not_depend_on_the_path(monkeypatch):
    assert np.linalg.eigvalsh(PATCH.elastic_slip_per_rolling_length + PATCH.elastic_slip_per_rolling_length.T)[0] > 0.0
    creep = CREEPS["spin pole inside"]
    straight = solve_steady_rolling_for_creepages(PATCH, creep, MU)
    monkeypatch.setattr(friction, "PATH", tuple(3.0**-k for k in range(8)))
    monkeypatch.setattr(friction, "SOFT", 0.004)
    other = solve_steady_rolling_for_creepages(PATCH, creep, MU)
    assert other.friction_solution.forces[0] == pytest.approx(
        straight.friction_solution.forces[0], abs=1e-9 * MU * PATCH.normal_forces.max()
    )


def test_mirrored_motion_gives_mirrored_forces():
    one, two = (
        solve_steady_rolling_for_creepages(PATCH, Creep(1e-3, 4e-4, 8.0), MU),
        solve_steady_rolling_for_creepages(PATCH, Creep(1e-3, -4e-4, -8.0), MU),
    )
    assert two.friction_force == pytest.approx(one.friction_force * [1.0, -1.0], rel=1e-9)
    assert two.friction_moment == pytest.approx(-one.friction_moment, rel=1e-9)


def test_a_search_that_is_cut_short_says_so(monkeypatch):
    monkeypatch.setattr(friction, "MOST", 1)
    monkeypatch.setattr(friction, "PATH", (1.0,))
    _, found = solve_friction_for_rigid_slip(
        PATCH, PATCH.elastic_slip_per_rolling_length, CREEPS["spin"].rigid_slip(PATCH.cell_centres), MU
    )
    assert not found.converged
    assert "not converged" in found.status
