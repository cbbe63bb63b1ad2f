"""Whole ball screw in time: recirculating balls that touch and part (Lin 3.4.4), between a rigid screw and a rigid nut.

The track is a ring: the loaded turns of the nut and a return tube of given length. See ``travel``.

Two balls that touch are the case study of Lin 3.4.3, with every assumption a parameter. What the section does not print is
the load state: clearance or oversize, how the force reaches the balls, which contact angles deviate.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.friction.screw.chain import CoupledChain, Guess, coupled_chain
from rollbench.lowfi.friction.screw.groove import ScrewGroove
from rollbench.lowfi.friction.screw.motion import Cell, Coupling, ball_motion, bare_cell, screw_rows
from rollbench.lowfi.friction.screw.travel import ClosedTrack, History, Instant, Place, simulate
from rollbench.meshes.arrays import Array
from rollbench.meshes.fields import keyed, usual
from rollbench.meshes.numerics import brentq

#: Contact angles (SL, SR, NL, NR) that grow with theta: both of the screw; those of a groove shifted sideways.
BOTH, SHIFTED = (1.0, 1.0, 0.0, 0.0), (1.0, -1.0, 0.0, 0.0)


@keyed
@dataclass(frozen=True)
class Pair:
    """Two balls in touch, the first behind the second."""

    #: The grooves.
    groove: ScrewGroove
    #: Deviation of the contact angles of each ball [rad].
    theta: tuple[float, float]
    #: Factors of it at the contacts of each ball (SL, SR, NL, NR).
    pattern: tuple[tuple[float, ...], tuple[float, ...]] = usual((BOTH, BOTH))
    #: Of the ball radii [m], negative for clearance.
    oversize: float = usual(0.0)
    #: Free translations of the screw, see `screw_rows`.
    free: str = usual("z")
    #: On the screw along each of them [N].
    force: tuple[float, ...] = usual((0.0,))
    #: Of loads and friction.
    coupling: Coupling = usual("none")

    def cell(self) -> Cell:
        """Return the balls, half the spacing before and behind azimuth 0, and their loads."""
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
    """Two balls of a screw."""

    #: Without contact.
    free: CoupledChain
    #: In contact.
    touching: CoupledChain

    @property
    def force(self) -> float:
        """Ball-to-ball force [N] (Lin Table 3.7)."""
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
        """Sum of the contact forces of each ball in touch ``(2,)`` [N]."""
        return np.asarray(self.touching.load.force.sum(axis=1))

    @property
    def converged(self) -> bool:
        """Whether both states converged."""
        return self.free.converged and self.touching.converged


def _over(amount: float, whole: float) -> float:
    return amount / whole if whole > 0.0 else float("nan")


def solve_pair(pair: Pair, guess: Guess | None = None) -> PairResult:
    """Return both states of the pair (Lin 3.69-3.76).

    Force and rate are complementary, so that balls that part stay apart.

    Parameters
    ----------
    pair
        The two balls.
    guess
        Forces and motion from which both states are sought, in place of none and of the balls without contact.
    """
    cell, apart = pair.cell(), None if guess is None else replace(guess, ball_force=np.zeros(2))
    free = coupled_chain(cell, np.full(2, np.inf), pair.coupling, guess=apart)
    return PairResult(free, coupled_chain(cell, np.array([0.0, np.inf]), pair.coupling, free, guess=guess))


def sliding_speed(pair: Pair) -> float:
    """Return the sliding speed at the ball-to-ball contact of a pair that touches [m/s]."""
    motion = solve_pair(pair).touching.motion
    return float(motion.ball_loss[0]) / (pair.groove.between * float(motion.ball_force[0]))


def implied_load(pair: Pair, force: float, increase: float) -> float:
    """Return the sum of contact forces of a ball that a ball-to-ball force and its friction increase imply [N].

    mu F v over the increase is the loss at the grooves of both balls; here four equal contacts of each cause it. Of the
    pair only the kinematics enter: the sliding speed depends on its loads by per cents.

    Parameters
    ----------
    pair
        The pair.
    force
        Ball-to-ball force [N].
    increase
        Relative increase of the friction.
    """
    g = pair.groove
    loss = 0.5 * g.between * force * sliding_speed(pair) / increase
    angle = np.full(4, g.contact_angle)

    def excess(log_load: float) -> float:
        return ball_motion(g, np.full(4, np.exp(log_load)), angle).motion.loss / loss - 1.0

    return 4.0 * float(np.exp(brentq(excess, np.log(1e-3), np.log(1e5), xtol=1e-10)))


@dataclass(frozen=True)
class PairMap:
    """Results over a grid of two assumptions."""

    #: Ball-to-ball force [N].
    force: Array
    #: Relative increase of the friction.
    increase: Array
    #: Whether both states converged.
    converged: Array


def oversize_map(pair: Pair, oversize: Array, axial: Array) -> PairMap:
    """Return results over oversize [m] (rows) and force on the screw [N] (columns), each pair solved separately.

    The force is spread over the screw's free motions as given.

    Parameters
    ----------
    pair
        Two balls of a screw.
    oversize
        Oversizes of the ball radius, ``(m,)`` [m].
    axial
        Forces on the screw, ``(n,)`` [N].
    """
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


@keyed
@dataclass(frozen=True)
class Run:
    """Run in time of a ball screw, a setting of ``travel`` with azimuths on the screw.

    From ``oversize`` on, assumptions that Lin does not print.
    """

    #: The grooves.
    groove: ScrewGroove
    #: Number of balls.
    count: int
    #: Loaded turns.
    turns: float
    #: On the screw along its free translations [N].
    force: tuple[float, ...]
    #: Those translations, see `screw_rows`.
    free: str
    #: [s].
    duration: float
    #: Number of steps, by the scheme "equal".
    steps: int
    #: Of the ball radii [m].
    oversize: float = usual(0.0)
    #: Of the deviation theta of the contact angles over the azimuth [rad].
    amplitude: float = usual(0.0)
    #: Cycles of theta per turn.
    cycles: float = usual(2.0)
    #: Of theta [rad].
    phase: float = usual(0.0)
    #: Factors of theta at the contacts (SL, SR, NL, NR).
    pattern: tuple[float, ...] = usual(BOTH)
    #: Length of the return tube as an angle of the track [rad]; balls in it bear no load.
    tube: float = usual(0.0)
    #: Position of the first ball at the start as a fraction of the distance between balls.
    first: float = usual(0.5)
    #: Of loads and friction.
    coupling: Coupling = usual("none")
    #: Of load and friction per step (one: friction of the step before).
    rounds: int = usual(1)
    #: Whether the screw or the nut carries the deviation.
    follows: Literal["screw", "nut"] = usual("screw")

    def __post_init__(self) -> None:
        """Refuse numbers that do not fit together."""
        if self.count < 2 or self.steps < 1 or self.duration <= 0.0 or self.tube < 0.0:
            raise ValueError("need count >= 2, steps >= 1, duration > 0 and tube >= 0")
        if self.count * self.groove.pair.spacing >= self.ring:
            raise ValueError("more balls than the track holds")

    @property
    def tracks(self) -> tuple[ClosedTrack]:
        """The one closed track, which turns with the nut."""
        arc = 2.0 * np.pi * self.turns
        return (ClosedTrack(0, -0.5 * arc, arc, self.ring, self.groove.pair.spacing, slice(0, self.count)),)

    @property
    def spacing(self) -> Array:
        """Azimuth by which the next ball is ahead where both touch ``(N,)`` [rad]."""
        return np.full(self.count, self.groove.pair.spacing)

    @property
    def number(self) -> NDArray[np.int64]:
        """Numbers of the balls ``(N,)``."""
        return np.arange(self.count)

    @property
    def ring(self) -> float:
        """Length of the closed track [rad]."""
        return 2.0 * np.pi * self.turns + self.tube

    @property
    def occupation(self) -> float:
        """Part of the loaded track that the balls would fill (97.8 % in Lin 3.4.4)."""
        return self.count * self.groove.pair.spacing / (2.0 * np.pi * self.turns)

    def place(self, azimuth: Array, nut_angle: float) -> tuple[Array, NDArray[np.bool_]]:
        """Return azimuths on the screw ``(N,)`` folded into the nut's turns, and which balls are in the loaded track."""
        (track,) = self.tracks
        along = track.along(azimuth, nut_angle)
        return along + nut_angle + track.first, along < track.arc

    def begin(self) -> Place:
        """Return evenly spread balls."""
        azimuth = self.ring * (np.arange(self.count) + self.first) / self.count - np.pi * self.turns
        gap = np.full(self.count, self.ring / self.count - self.groove.pair.spacing)
        return Place(azimuth, gap, np.full(self.count, self.groove.nominal_orbit - self.groove.screw_speed), None)

    def to_end(self, azimuth: Array, omega: Array, time: float) -> float:
        """Return the time until a ball passes an end of the nut's turns [s].

        inf where contact angles there are the same as at the other end.
        """
        if self.tube == 0.0 and (self.amplitude == 0.0 or (self.cycles * self.turns).is_integer()):
            return np.inf
        speed = self.groove.speed
        return self.tracks[0].to_end(azimuth, omega - speed, speed * time)

    def instant(self, azimuth: Array, time: float, slack: Array, memory: CoupledChain | None) -> Instant:
        """Return loads and motions at azimuths on the screw ``(N,)``; memory: the solution before."""
        turned = self.groove.speed * time
        azimuths, loaded = self.place(azimuth, turned)
        near = coupled_chain(run_cell(self, azimuths, loaded, turned), slack, self.coupling, memory, self.rounds)
        m = near.motion
        return Instant(
            omega=m.q[:, 0] - self.groove.screw_speed,
            ball_force=m.ball_force,
            load=near.load.force,
            loaded=loaded,
            losses=m.losses,
            input_power=m.input_power,
            converged=m.converged and near.load.converged and (near.converged or self.rounds == 1),
            memory=near,
            change=near.change,
        )


def deviation(run: Run, azimuth: Array, turned: float = 0.0) -> Array:
    """Return the deviation theta of the contact angles ``(N,)`` [rad] (Lin Figure 3.23).

    Parameters
    ----------
    run
        The run.
    azimuth
        Of the balls on the screw ``(N,)`` [rad].
    turned
        Angle of the nut [rad].
    """
    own = azimuth - (turned if run.follows == "nut" else 0.0)
    return np.asarray(run.amplitude * np.sin(run.cycles * own + run.phase))


def run_cell(run: Run, azimuth: Array, loaded: NDArray[np.bool_], turned: float) -> Cell:
    """Return balls at azimuths ``(N,)`` on the screw, the nut turned by an angle [rad].

    Balls that are not loaded are kept clear of the grooves.
    """
    g = run.groove
    angle = g.contact_angle + deviation(run, azimuth, turned)[:, None] * np.array(run.pattern)
    clear = np.where(loaded, run.oversize, -0.5 * g.reach)
    rows = screw_rows(g, azimuth, run.free)
    return bare_cell(g, angle, np.repeat(clear[:, None], 4, axis=1), rows, np.array(run.force))


def equal_steps(run: Run) -> History:
    """Return the run by Lin's scheme of equal steps, from evenly spread balls.

    Parameters
    ----------
    run
        A whole screw in time.
    """
    return simulate(run, run.duration, run.steps, "equal")


@dataclass(frozen=True)
class RunSummary:
    """Numbers that Lin 3.4.4 states for its run."""

    #: Largest ratio of ball-to-ball torque to groove torque.
    largest: float
    #: Nut angle of it [deg].
    at: float
    #: Nut angle of the first step without contact after it [deg]; nan if none.
    none_at: float
    #: Largest number of groups of touching balls.
    groups: int
    #: Variation of the groove torque, (max - min)/mean.
    groove_variation: float


def summarise(result: History) -> RunSummary:
    """Return the numbers that Lin 3.4.4 states.

    Parameters
    ----------
    result
        Time series of a run.
    """
    angle = np.degrees(result.nut_angle)
    top = int(np.argmax(result.ratio))
    later = np.flatnonzero(~result.contact.any(axis=1) & (np.arange(angle.size) > top))
    torque = result.groove_torque
    return RunSummary(
        largest=float(result.ratio[top]),
        at=float(angle[top]),
        none_at=float(angle[later[0]]) if later.size else float("nan"),
        groups=int(np.max(result.groups)),
        groove_variation=float(np.ptp(torque) / result.mean(torque)) if result.mean(torque) > 0.0 else float("nan"),
    )
