"""One contact of rolling bodies on a grid: influence of tractions against quadrature, Hertz's pressure; Coulomb friction
with complementarity to round-off, energy, and answers that do not depend on the way to them; rolling from rest; loads of
the 3D model."""

import numpy as np
import pytest
from scipy.integrate import dblquad
from tests.rolling_scenes import linear_pair

from rollbench.hifi.contact.hertz import solve_hertz
from rollbench.hifi.rolling import friction, patch
from rollbench.hifi.rolling.balls import RollingSettings, compute_motion_from_rest, solve_rolling
from rollbench.hifi.rolling.patch import solve_elastic_contact_on_grid
from rollbench.hifi.rolling.scenes import StaticProblem, solve_static_problem
from rollbench.hifi.rolling.verification import (
    Creep,
    simulate_rolling_onset,
    solve_friction_for_rigid_slip,
    solve_steady_rolling_for_creepages,
    solve_steady_rolling_like_kalker,
)

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
    found = patch.displacement_by_rectangle(*np.array(at), dx, dy, E, NU)[entry]
    assert found == pytest.approx(exact, rel=1e-9)


@pytest.mark.parametrize("radii", [(2.778e-3, 2.778e-3), (5e-3, 4e-2), (4e-2, 5e-3)])
def test_pressure_of_a_sphere_and_of_an_ellipse_is_hertz(radii):
    """Cells are longer along the ellipse's longer axis."""
    found = solve_elastic_contact_on_grid(225.0, radii, E, NU, (24, 24) if radii[0] == radii[1] else (28, 20))
    assert found.normal_load == pytest.approx(225.0, rel=1e-12)
    exact = solve_hertz(225.0, *radii, E, NU)
    assert found.approach == pytest.approx(exact.approach, rel=2e-3)
    assert found.normal_forces.max() / found.cell_size.prod() == pytest.approx(exact.pole_pressure, rel=1e-2)


def test_a_similar_contact_is_the_unit_one_scaled():
    unit, direct = (solve_elastic_contact_on_grid(load, (5e-3, 4e-2), E, NU, (10, 10)) for load in (1.0, 64.0))
    unit.elastic_slip_per_rolling_length  # noqa: B018 - computed once
    scaled = unit.similar_contact(4.0, 64.0)
    assert scaled.normal_forces == pytest.approx(direct.normal_forces, rel=1e-9)
    assert scaled.approach == pytest.approx(direct.approach, rel=1e-9)
    slip, wanted = scaled.elastic_slip_per_rolling_length, direct.elastic_slip_per_rolling_length
    assert np.abs(slip - wanted).max() < 1e-9 * np.abs(wanted).max()


PATCH = solve_elastic_contact_on_grid(100.0, (5e-3, 46.667e-3), E, NU, (16, 16))
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
    found, rigid = solve_steady_rolling_for_creepages(PATCH, creep, MU), creep.rigid_slip(PATCH.cell_centres)
    state = found.friction_solution
    power = -float(state.forces[0] @ rigid)
    assert found.friction_loss >= -1e-9 * power
    assert found.numerical_dissipation >= 0.0
    assert found.friction_loss + found.numerical_dissipation == pytest.approx(power, rel=1e-9)
    assert state.converged
    q, s = (v.reshape(2, -1) for v in (state.forces[0], state.slips[0]))
    bound, size, speed, stick = MU * PATCH.normal_forces, np.hypot(*q), np.hypot(*s), state.stick[0]
    assert np.all(size <= bound * (1.0 + 1e-9))
    assert np.all(speed[stick] <= 1e-9 * max(speed.max(), 1e-12 + np.abs(rigid).max()))
    assert size[~stick] == pytest.approx(bound[~stick], rel=1e-9)
    against = (q * s).sum(axis=0)[~stick] + (size * speed)[~stick]
    assert np.abs(against).max(initial=0.0) <= 1e-9 * (size * speed).max()


def test_a_search_that_is_cut_short_says_so(monkeypatch):
    monkeypatch.setattr(friction, "MOST", 1)
    monkeypatch.setattr(friction, "PATH", (1.0,))
    slip = CREEPS["spin"].rigid_slip(PATCH.cell_centres)
    _, found = solve_friction_for_rigid_slip(PATCH, PATCH.elastic_slip_per_rolling_length, slip, MU)
    assert not found.converged
    assert "not converged" in found.status


GRID = RollingSettings((8, 8))


def test_balls_meet_and_end_in_steady_rolling_whatever_the_steps_and_power_put_in_is_dissipated_or_stored():
    """In every step, that in which the balls meet too; what is stored at the end is lost by the steps."""
    scene = linear_pair()
    run, *others = (compute_motion_from_rest(scene, 0.1, steps, 1e-6, GRID) for steps in (20, 10, 50))
    assert run.converged
    assert run.ball_to_ball_forces[0, 0] == 0.0 < run.ball_to_ball_gaps[0, 0]
    assert run.ball_to_ball_gaps[-1, 0] == pytest.approx(0.0, abs=1e-15)
    assert np.all(np.diff(run.ball_to_ball_gaps[:, 0]) <= 1e-15)
    assert run.track_speeds[0, 0] > run.track_speeds[0, 1]
    assert run.track_speeds[-1, 0] == pytest.approx(run.track_speeds[-1, 1], rel=1e-9)
    assert run.ball_to_ball_forces[-1, 0] == pytest.approx(solve_rolling(scene, GRID).ball_to_ball_forces[0], rel=0.02)
    for other in others:
        assert other.ball_to_ball_forces[-1, 0] == pytest.approx(run.ball_to_ball_forces[-1, 0], rel=0.02)
    for one in (run, *others):
        assert one.losses + one.stored_power == pytest.approx(one.driving_power, rel=1e-9)
        assert 0.0 <= one.stored_power[-1] < 0.03 * one.driving_power[-1]


def solved(n, inner, motions, pull, push):
    """One ball with contacts along these directions, without gaps, pressed by forces on its cell and on itself."""
    count = len(n)
    given = n[None], 6e-4, np.zeros((1, count)), np.full((1, count), 1e-7), np.array(inner), motions
    return solve_static_problem(StaticProblem(*given, np.zeros((1, 2)), np.array(pull), np.array([push])))


def test_loads_of_two_opposite_contacts_share_a_force_and_a_cell_that_nothing_holds_does_not_converge():
    """Contacts at 45 deg under a force along one diagonal: F = force, directions unturned."""
    n = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) * np.sqrt(0.5)
    found = solved(n, [False, False, True, True], np.eye(2)[None], 100.0 * n[0], [0.0, 0.0])
    assert found.converged
    assert found.force[0] == pytest.approx([100.0, 0.0, 100.0, 0.0], rel=1e-6, abs=1e-3)
    assert not solved(np.array([[0.0, 1.0]]), [False], np.zeros((1, 2, 0)), [], [0.0, -5.0]).converged


def test_a_pushed_ball_rolls_on_towards_the_creepage_of_steady_rolling() -> None:
    """Found without time, at the same force: by two contact lengths it is there."""
    load, share, mu = 0.4705, 0.657, 0.4
    patch = solve_elastic_contact_on_grid(load, (0.17, 0.17), 2.56e6, 0.28, (11, 11))
    found = simulate_rolling_onset(patch, mu, share, 22)
    steady = solve_steady_rolling_like_kalker(patch, Creep(found[-1].shift_or_creepage, 0.0, 0.0), mu)
    assert steady.friction_force[0] == pytest.approx(-share * mu * load, rel=2e-3)
    assert found[1].shift_or_creepage < 0.7 * found[-1].shift_or_creepage
    assert max(one.shift_or_creepage for one in found[1:]) > 1.05 * found[-1].shift_or_creepage
