"""Two balls of a ball screw that touch: the case study of Lin 3.4.3 with every assumption a parameter.

What the section does not print is the load state: clearance or oversize, how the force reaches the balls, which contact
angles deviate.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rollbench.lowfi.friction.screw.coupled import CoupledChain, Guess, coupled_chain
from rollbench.lowfi.friction.screw.groove import ScrewGroove
from rollbench.lowfi.friction.screw.load import Cell, bare_cell, screw_rows
from rollbench.lowfi.friction.screw.motion import Coupling, ball_motion
from rollbench.meshes.arrays import Array
from rollbench.meshes.fields import keyed, usual
from rollbench.meshes.roots import brentq

#: Contact angles (SL, SR, NL, NR) that grow with theta: both of the screw; those of a groove shifted sideways.
BOTH, SHIFTED = (1.0, 1.0, 0.0, 0.0), (1.0, -1.0, 0.0, 0.0)


@keyed
@dataclass(frozen=True)
class Pair:
    """Two balls in touch, the first behind the second; SI.

    theta: deviations of the contact angles of each ball [rad], times its pattern (SL, SR, NL, NR); oversize of the ball
    radii [m], negative for clearance; free: the screw's free translations (see ``screw_rows``); force: on the screw
    along each [N]; coupling of loads and friction.
    """

    groove: ScrewGroove
    theta: tuple[float, float]
    pattern: tuple[tuple[float, ...], tuple[float, ...]] = usual((BOTH, BOTH))
    oversize: float = usual(0.0)
    free: str = usual("z")
    force: tuple[float, ...] = usual((0.0,))
    coupling: Coupling = usual("none")

    def cell(self) -> Cell:
        """The balls, half the spacing before and behind azimuth 0, and their loads."""
        half = 0.5 * self.groove.pair.spacing
        angle = self.groove.contact_angle + np.array(self.theta)[:, None] * np.array(self.pattern)
        return bare_cell(
            self.groove,
            angle,
            np.full((2, 4), self.oversize),
            screw_rows(self.groove, np.array([-half, half]), self.free),
            np.array(self.force),
        )


@dataclass(frozen=True)
class PairResult:
    """The balls without contact and in contact."""

    free: CoupledChain
    touching: CoupledChain

    @property
    def force(self) -> float:
        """Ball-to-ball force [N] (Table 3.7)."""
        return float(self.touching.motion.ball_force[0])

    @property
    def friction_increase(self) -> float:
        """Relative increase of the dissipation by ball-to-ball contact; nan without friction."""
        return _over(self.touching.motion.loss, self.free.motion.loss) - 1.0

    @property
    def rubbing_ratio(self) -> float:
        """Ball-to-ball loss over the losses of the balls without contact; nan without friction."""
        return _over(float(self.touching.motion.ball_loss.sum()), self.free.motion.loss)

    @property
    def closing(self) -> float:
        """omega_B of the first ball less that of the second without contact [rad/s]; they meet where it is positive."""
        q = self.free.motion.q
        return float(q[0, 0] - q[1, 0])

    @property
    def load(self) -> Array:
        """Sum of the contact forces (2,) of each ball in touch [N]."""
        return np.asarray(self.touching.load.force.sum(axis=1))

    @property
    def converged(self) -> bool:
        """Whether both states are."""
        return self.free.converged and self.touching.converged


def _over(amount: float, whole: float) -> float:
    return amount / whole if whole > 0.0 else float("nan")


def solve_pair(pair: Pair, guess: Guess | None = None) -> PairResult:
    """Both states of the pair (Lin 3.69-3.76); force and rate are complementary, so that balls that part stay apart.

    guess: forces and motion of two balls from which both states are sought, in place of none and of the balls without
    contact.
    """
    cell, apart = pair.cell(), None if guess is None else replace(guess, ball_force=np.zeros(2))
    free = coupled_chain(cell, np.full(2, np.inf), pair.coupling, guess=apart)
    return PairResult(free, coupled_chain(cell, np.array([0.0, np.inf]), pair.coupling, free, guess=guess))


def sliding_speed(pair: Pair) -> float:
    """Sliding speed [m/s] at the ball-to-ball contact of a pair that touches."""
    motion = solve_pair(pair).touching.motion
    return float(motion.ball_loss[0]) / (pair.groove.between * float(motion.ball_force[0]))


def implied_load(pair: Pair, force: float, increase: float) -> float:
    """Sum of contact forces of a ball [N] that a ball-to-ball force [N] and the friction increase it causes imply.

    mu F v over the increase is the loss at the grooves of both balls; here four equal contacts of each cause it. Of the
    pair only the kinematics enter: the sliding speed depends on its loads by per cents.
    """
    g = pair.groove
    loss = 0.5 * g.between * force * sliding_speed(pair) / increase
    angle = np.full(4, g.contact_angle)

    def excess(log_load: float) -> float:
        return ball_motion(g, np.full(4, np.exp(log_load)), angle).motion.loss / loss - 1.0

    return 4.0 * float(np.exp(brentq(excess, np.log(1e-3), np.log(1e5), xtol=1e-10)))


@dataclass(frozen=True)
class PairMap:
    """Grids over two assumptions: ball-to-ball force [N], friction increase, whether both states converged."""

    force: Array
    increase: Array
    converged: Array


def oversize_map(pair: Pair, oversize: Array, axial: Array) -> PairMap:
    """Grid over oversize [m] (rows) and the force on the screw [N] (columns), spread over its free motions as given; each
    pair is solved on its own."""
    total = float(np.linalg.norm(pair.force)) or 1.0
    solved = [
        [solve_pair(replace(pair, oversize=float(o), force=tuple(f / total * float(a) for f in pair.force))) for a in axial]
        for o in oversize
    ]
    force, increase, converged = (
        np.array([[getattr(r, name) for r in row] for row in solved])
        for name in ("force", "friction_increase", "converged")
    )
    return PairMap(force, increase, converged)
