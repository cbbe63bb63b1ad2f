"""Loads and friction of a ball screw in agreement where friction wedges balls: equilibrium, one or several states."""

from dataclasses import replace

import numpy as np
import pytest
from tests.friction_oracles import ball_cell

from rollbench.compare.cases.lin.evidence import source_cases
from rollbench.lowfi.friction.screw import coupled, motion
from rollbench.lowfi.friction.screw.run import Pair, ScrewPairSolution, solve_pair_of_screw_balls
from rollbench.lowfi.together import solve_alone, solve_together

#: One of the cases below: the way with the first regularising speed ends in a fold.
FOLD = (0.0011870711354544847, 1.1600932507239492e-07, (2.7421699016943855, 0.6621765470335923), 0.06644672659308906)
#: Load [N], clearance [m], deviations [deg], mu at which rounds of loads and friction run away: friction carries the
#: ball aside until it is wedged, under a hundred times the load and more.
WEDGED = ((0.0101375, 2.33636e-7, (3.0, 1.45), 0.0883), (0.00192, 5.04e-6, (4.78, -2.56), 0.218), FOLD)


def out_of_balance(pair: Pair, state: coupled.CoupledChainSolution) -> float:
    """Largest force out of balance of a ball across its path, over the sum of contact forces: from forces alone."""
    n = pair.groove.normals(state.loads_with_friction.angle)
    force = state.motion.wrench[..., :3].sum(axis=1) + state.motion.neighbour_forces
    force = force - np.einsum("ki,kir->kr", state.loads_with_friction.force, n)
    return float(np.abs(force).max() / state.loads_with_friction.force.sum())


@pytest.mark.parametrize("case", WEDGED)
def test_wedged_pairs_and_balls_converge_and_are_in_equilibrium(case) -> None:
    force, clearance, theta, mu = case
    groove, deviations = source_cases.screw_groove(mu=mu), tuple(np.radians(theta))
    pair = Pair(groove, deviations, oversize=-clearance, force=(force,), coupling="ball")
    r = solve_pair_of_screw_balls(pair)
    assert r.converged
    assert r.apart.rounds > coupled.PATIENCE
    assert r.apart.loads_with_friction.force.sum() > 5.0 * r.apart.loads_without_friction.force.sum()
    for state in (r.apart, r.touching):
        assert out_of_balance(pair, state) < 1e-8
        assert state.motion.input_power == pytest.approx(state.motion.loss, rel=1e-8)


@pytest.mark.parametrize("coupling", ["ball", "ball and screw"])
@pytest.mark.parametrize("make", [source_cases.pair_as_printed, source_cases.oversized_pair])
def test_one_system_gives_what_rounds_give(make, coupling: str) -> None:
    """Two ways that share the laws only: rounds and Newton's method on everything at once."""
    pair = replace(make(np.radians(2.0)), coupling=coupling)
    rounds = solve_pair_of_screw_balls(pair).touching
    assert rounds.rounds < coupled.PATIENCE
    cell = pair.balls_with_loads()
    bare = motion.solve_screw_contact_loads(cell)
    held = motion.balls_with_fixed_screw(cell, bare) if coupling == "ball" else cell
    start = bare.ball_displacements, bare.inner_body_displacements[: held.external_screw_force.size]
    found = coupled.solve_loads_and_motion(held, np.array([0.0, np.inf]), start)
    assert found is not None
    reached, _ = found
    friction, pushed = rounds.motion.wrench, rounds.motion.neighbour_forces[:, [0, 2]]
    push, drag = motion.friction_on_balls_and_screw(held, friction, pushed, coupling)  # type: ignore[arg-type]
    scale = float(rounds.loads_with_friction.force.sum())
    assert reached.ball_friction_forces == pytest.approx(push, abs=1e-8 * scale)
    assert reached.screw_friction_forces == pytest.approx(drag, abs=1e-8 * scale)
    assert reached.ball_force == pytest.approx(rounds.motion.ball_force, abs=1e-8 * scale)


@pytest.mark.parametrize(("coupling", "count"), [("none", 10), ("ball", 20), ("ball and screw", 12)])
def test_random_pairs_converge(coupling: str, count: int) -> None:
    """Loads 1 mN to 100 kN, clearances 0.1 to 10 um, a third with preload, deviations to 5 deg, mu 0.001 to 0.5."""
    rng, pairs = np.random.default_rng(7), []
    for _ in range(count):
        force, clearance = 10.0 ** rng.uniform(-3.0, 5.0), 10.0 ** rng.uniform(-7.0, -5.0) * rng.choice([1.0, 1.0, -0.3])
        theta, mu = tuple(np.radians(rng.uniform(-5.0, 5.0, 2))), np.exp(rng.uniform(np.log(1e-3), np.log(0.5)))
        groove = source_cases.screw_groove(mu=mu)
        pairs.append(Pair(groove, theta, oversize=-clearance, force=(force,), coupling=coupling))  # type: ignore[arg-type]
    cells = [pair.balls_with_loads() for pair in pairs]
    apart = solve_together([coupled.search_coupled_chain(cell, np.full(2, np.inf), coupling) for cell in cells])
    slack = np.array([0.0, np.inf])
    begun = zip(cells, apart, strict=True)
    touching = solve_together([coupled.search_coupled_chain(cell, slack, coupling, free) for cell, free in begun])
    for pair, r in zip(pairs, map(ScrewPairSolution, apart, touching), strict=True):
        assert r.converged
        assert coupling == "none" or max(out_of_balance(pair, s) for s in (r.apart, r.touching)) < 1e-8
        assert r.touching.motion.input_power == pytest.approx(r.touching.motion.loss, rel=1e-8)
        assert r.force >= 0.0
        if abs(r.approach_speed_when_apart) > 1e-4:
            assert (r.force > 0.0) == (r.approach_speed_when_apart > 0.0)


def test_a_floating_ball_may_wedge_itself() -> None:
    """Not unique: a ball that bears no load floats, or is held between the grooves by its own friction.

    With 1 um of clearance under 0.01 N the second ball has play; pushed aside once, it stays wedged, at 18 times the
    load of the first. Both states are in balance.
    """
    pair = replace(source_cases.pair_as_printed(np.radians(2.0)), oversize=-1e-6, force=(0.01,))
    floats = solve_pair_of_screw_balls(pair).apart
    load = floats.loads_with_friction.force.sum(axis=1)
    assert load[1] < 1e-9 * load[0]
    found, rng, cell = [], np.random.default_rng(1), pair.balls_with_loads()
    for _ in range(12):
        push = np.array([[0.0, 0.0], 0.01 * rng.normal(size=2)])
        guess = coupled.IterationStart(push, np.zeros(1), floats.motion.q, np.zeros(2))
        search = coupled.search_coupled_chain(cell, np.full(2, np.inf), "ball", None, 100, guess)
        found.append(solve_alone(search))
    wedged = [s for s in found if s.loads_with_friction.force[1].sum() > 0.1]
    assert wedged
    assert all(s.converged and out_of_balance(pair, s) < 1e-8 for s in found)
    loads = [s.loads_with_friction.force[1].sum() for s in wedged]
    assert loads == pytest.approx([loads[0]] * len(loads), rel=1e-6)


def test_a_contact_past_the_apex_keeps_its_sign():
    groove = replace(source_cases.screw_groove(), contact_angle=0.02)
    cell = ball_cell(groove, np.zeros(4), 2e-6, "z", np.array([200.0]))
    found = motion.solve_screw_contact_loads(cell)
    normal = groove.normals(found.angle)
    assert found.converged
    assert found.angle[0].min() < 0.0
    # the balance of the ball in its section, summed from forces and angles
    left = np.einsum("ns,nsi->ni", found.force, normal)[:, [0, 2]]
    assert np.abs(left).max() < 1e-8 * found.force.sum()
