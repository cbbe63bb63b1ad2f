"""Coupled loads and friction of a pair in a ball screw do not depend on where the search begins.

Valid where the load presses both balls against their grooves by more than friction moves them: a ball with play may
float or be wedged by its own friction (tests/unit/friction/test_screw_coupled.py).
"""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from rollbench.compare.cases.lin.evidence.source_cases import pair_as_printed, screw_groove
from rollbench.lowfi.friction.screw.coupled import IterationStart
from rollbench.lowfi.friction.screw.run import Pair, ScrewPairSolution, solve_pair_of_screw_balls

#: Load [N] and oversize of the ball radii [m], negative for clearance.
STATES = [*product((1.0, 50.0), (1.7e-6, 0.0)), (50.0, -1e-7), (50.0, -1e-6), (2000.0, -3e-6), (2000.0, -1e-5)]
STARTS = 4


def random_guess(pair: Pair, found: ScrewPairSolution, rng: np.random.Generator) -> IterationStart:
    """Pushes, drags and forces from a tenth of the friction bound to ten times it, motions off by half."""
    held = pair.coupling == "ball"
    size = pair.groove.mu * float(found.ball_loads.max()) * 10.0 ** rng.uniform(-1.0, 1.0)
    q = found.touching.motion.q
    return IterationStart(
        ball_friction_forces=size * rng.normal(size=(2, 2)),
        screw_friction_forces=np.zeros(1) if held else size * rng.normal(size=1),
        ball_motions=q * (1.0 + 0.5 * rng.normal(size=q.shape)),
        ball_force=size * np.array([rng.uniform(), 0.0]),
    )


@pytest.mark.parametrize("coupling", ["ball", "ball and screw"])
@pytest.mark.parametrize("mu", [0.01, 0.05, 0.1, 0.2, 0.35, 0.5])
def test_random_starts_give_the_same_coupled_state(mu: float, coupling: str) -> None:
    """All contact forces and the ball-to-ball force within 1e-6 of the friction bound of a ball."""
    rng = np.random.default_rng(int(1000 * mu))
    printed = replace(pair_as_printed(np.radians(2.0)), groove=screw_groove(mu=mu), coupling=coupling)
    for force, oversize in STATES:
        pair = replace(printed, oversize=oversize, force=(force,))
        found = solve_pair_of_screw_balls(pair)
        assert found.converged
        near = 1e-6 * mu * float(found.ball_loads.max())
        for _ in range(STARTS):
            again = solve_pair_of_screw_balls(pair, random_guess(pair, found, rng))
            assert again.converged
            for one, two in ((found.apart, again.apart), (found.touching, again.touching)):
                assert two.loads_with_friction.force == pytest.approx(one.loads_with_friction.force, abs=near)
                assert two.motion.ball_force == pytest.approx(one.motion.ball_force, abs=near)
