"""Whole ball screw over time: recirculating balls that touch and part, between a rigid screw and a rigid nut.

The simulation is that of the case study in section 3.4.4 of Lin's thesis. The track is closed: the loaded turns of the nut
and a return tube of given length. The module ``travel`` simulates how the balls travel.

Two balls that touch are the case study of section 3.4.3 of Lin's thesis, with every assumption a parameter. What that
section does not print is the load state: clearance or oversize, how the force reaches the balls, which contact angles
deviate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from rollbench.lowfi.friction.screw import motion as screw_motion
from rollbench.lowfi.friction.screw.coupled import CoupledChainSolution, IterationStart, search_coupled_chain
from rollbench.lowfi.friction.screw.groove import ScrewGroove
from rollbench.lowfi.friction.screw.travel import BallState, ClosedTrack, InstantSolution, TravelHistory, travel
from rollbench.lowfi.together import Search, solve_alone, solve_together
from rollbench.meshes.arrays import Array, Index, Mask
from rollbench.meshes.numerics import brentq
from rollbench.meshes.record_keys import frozen_default, frozen_record

#: Factors by which theta, the angle by which contact angles differ from the nominal one, is multiplied at the contacts SL,
#: SR, NL, NR (screw or nut, left or right): both contact angles on the screw differ by the same amount, or by opposite
#: amounts, as on a groove that is shifted sideways.
BOTH, SHIFTED = (1.0, 1.0, 0.0, 0.0), (1.0, -1.0, 0.0, 0.0)


@frozen_record
class Pair:
    """Two neighbouring balls of a ball screw that touch, with their grooves, contact angles and loads."""

    #: Grooves of screw and nut with their speeds.
    groove: ScrewGroove
    #: Angle theta by which the contact angles of each ball differ from the nominal contact angle [rad].
    theta: tuple[float, float]
    #: Factors by which theta is multiplied at the contacts SL, SR, NL, NR (screw or nut, left or right) of the first and of
    #: the second ball.
    pattern: tuple[tuple[float, ...], tuple[float, ...]] = frozen_default((BOTH, BOTH))
    #: Oversize of the ball radii, which is the interference at each contact [m]; negative for clearance.
    oversize: float = frozen_default(0.0)
    #: Translations in which the screw is free, letters of "xyzr" (see `screw_displacement_maps`).
    free: str = frozen_default("z")
    #: External force on the screw along each of these translations [N].
    force: tuple[float, ...] = frozen_default((0.0,))
    #: What friction may change: nothing ("none"), the contact loads of the balls ("ball"), or also the position of the
    #: screw ("ball and screw").
    coupling: screw_motion.Coupling = frozen_default("none")

    def balls_with_loads(self) -> screw_motion.BallsBetweenGrooves:
        """Return both balls between screw and nut with their loads, as argument of `search_coupled_chain`.

        The balls touch each other, and azimuth 0 lies in the middle between them.
        """
        half = 0.5 * self.groove.pair.spacing
        angle = self.groove.contact_angle + np.array(self.theta)[:, None] * np.array(self.pattern)
        maps = screw_motion.screw_displacement_maps(self.groove, np.array([-half, half]), self.free)
        interference = np.full((2, 4), self.oversize)
        return screw_motion.balls_without_friction(self.groove, angle, interference, maps, np.array(self.force))


@dataclass(frozen=True)
class ScrewPairSolution:
    """Contact loads and motion of two balls of a screw, without and with contact of the balls with each other."""

    #: Solution for the two balls without contact with each other.
    apart: CoupledChainSolution
    #: Solution for the two balls with contact with each other.
    touching: CoupledChainSolution

    @property
    def force(self) -> float:
        """Ball-to-ball force [N] (Lin Table 3.7)."""
        return float(self.touching.motion.ball_force[0])

    @property
    def friction_increase(self) -> float:
        """Relative increase of the total friction loss by ball-to-ball contact; nan without friction."""
        touching, apart = self.touching.motion.loss, self.apart.motion.loss
        return touching / apart - 1.0 if apart > 0.0 else float("nan")

    @property
    def approach_speed_when_apart(self) -> float:
        """Orbital speed omega_B of the first ball less that of the second, without ball-to-ball contact [rad/s].

        The value is positive if the first ball, which is behind, approaches the second one.
        """
        q = self.apart.motion.q
        return float(q[0, 0] - q[1, 0])

    @property
    def ball_loads(self) -> Array:
        """Sum of the contact loads of each of the two balls in the state with ball-to-ball contact ``(2,)`` [N]."""
        return np.asarray(self.touching.loads_with_friction.force.sum(axis=1))

    @property
    def converged(self) -> bool:
        """Whether the solutions without and with ball-to-ball contact both converged."""
        return self.apart.converged and self.touching.converged


def solve_pair_of_screw_balls(pair: Pair, guess: IterationStart | None = None) -> ScrewPairSolution:
    """Return the states of two neighbouring balls without and with ball-to-ball contact (Lin 3.69-3.76).

    The ball-to-ball force and the rate at which the gap opens are complementary: the one or the other is zero, so that
    balls that separate exert no force on each other.

    Parameters
    ----------
    pair
        The two balls with their loads.
    guess
        Forces and motions from which the searches for both states begin. With None, the search for the state without
        contact begins without friction, and the search for the state with contact from the state without contact.
    """
    cell, apart = pair.balls_with_loads(), None if guess is None else replace(guess, ball_force=np.zeros(2))
    free = solve_alone(search_coupled_chain(cell, np.full(2, np.inf), pair.coupling, guess=apart))
    pressed = search_coupled_chain(cell, np.array([0.0, np.inf]), pair.coupling, free, guess=guess)
    return ScrewPairSolution(free, solve_alone(pressed))


def pair_sliding_speed(pair: Pair) -> float:
    """Return the speed at which two touching balls slide on each other at their contact [m/s].

    The speed is the loss between the balls, divided by coefficient of friction times ball-to-ball force. ``pair``: the
    balls, which must press on each other.
    """
    motion = solve_pair_of_screw_balls(pair).touching.motion
    return float(motion.ball_loss[0]) / (pair.groove.ball_to_ball_mu * float(motion.ball_force[0]))


def load_implied_by_ball_force(pair: Pair, force: float, increase: float) -> float:
    """Return the sum of contact loads of one ball [N] at which a ball-to-ball force increases friction by a given ratio.

    The loss mu F v of the balls that slide on each other, divided by the relative increase, is the loss at the grooves
    of both balls. Four equal contact loads of a ball are sought at which the ball has half of this loss; the result is
    their sum. Of ``pair`` only the kinematics matter, because the sliding speed v depends on its loads by a few per
    cent only.

    Parameters
    ----------
    pair
        Two balls with their grooves and speeds.
    force
        Ball-to-ball force F [N].
    increase
        Increase of the friction loss by ball-to-ball contact, as a ratio to the loss without this contact.
    """
    g = pair.groove
    loss = 0.5 * g.ball_to_ball_mu * force * pair_sliding_speed(pair) / increase
    angle = np.full(4, g.contact_angle)

    def relative_loss_excess(log_load: float) -> float:
        """Return the relative deviation of a ball's loss from the required one, at contact loads of exp(``log_load``) [N].

        The required loss is half of the loss at the grooves of both balls together.
        """
        return screw_motion.solve_ball_motion(g, np.full(4, np.exp(log_load)), angle).motion.loss / loss - 1.0

    return 4.0 * float(np.exp(brentq(relative_loss_excess, np.log(1e-3), np.log(1e5), xtol=1e-10)))


@frozen_record
class Run:
    """Ball screw with the data for its simulation over time by `travel`; azimuths are measured relative to the screw.

    Lin does not print values for the fields from ``oversize`` on; they are assumptions.
    """

    #: Grooves of screw and nut with their speeds.
    groove: ScrewGroove
    #: Number of balls.
    count: int
    #: Number of loaded turns of the nut.
    turns: float
    #: External force on the screw along each of the translations in ``free`` [N].
    force: tuple[float, ...]
    #: Translations in which the screw is free, letters of "xyzr" (see `screw_displacement_maps`).
    free: str
    #: Time that is simulated [s].
    duration: float
    #: Number of equal time steps into which ``duration`` is divided.
    steps: int
    #: Oversize of the ball radii, which is the interference at each contact [m]; negative for clearance.
    oversize: float = frozen_default(0.0)
    #: Amplitude of theta, the angle by which the contact angles differ from the nominal one, a sine function of the azimuth
    #: [rad].
    amplitude: float = frozen_default(0.0)
    #: Number of periods of theta (deviation of the contact angles from the nominal one) per turn of the helix.
    cycles: float = frozen_default(2.0)
    #: Phase, at azimuth 0, of the sine function theta (deviation of the contact angles from the nominal one) [rad].
    phase: float = frozen_default(0.0)
    #: Factors by which theta is multiplied at the contacts SL, SR, NL, NR (screw or nut, left or right).
    pattern: tuple[float, ...] = frozen_default(BOTH)
    #: Length of the return tube, expressed as an azimuth along the helix [rad]; balls in it bear no load.
    tube: float = frozen_default(0.0)
    #: Distance of the first ball from the beginning of the loaded turns at the start, as a fraction of the distance between
    #: balls.
    first: float = frozen_default(0.5)
    #: What friction may change: nothing ("none"), the contact loads of the balls ("ball"), or also the position of the
    #: screw ("ball and screw").
    coupling: screw_motion.Coupling = frozen_default("none")
    #: Largest number of rounds in each time step, in which contact loads and friction are solved in turn; with one round
    #: the contact loads are in balance with the friction of the previous step.
    rounds: int = frozen_default(1)
    #: Body, screw or nut, whose groove is the cause of theta, so that theta turns with this body.
    follows: Literal["screw", "nut"] = frozen_default("screw")

    def __post_init__(self) -> None:
        """Raise ValueError for numbers, times or lengths out of range, or if the balls do not fit into the closed track."""
        if self.count < 2 or self.steps < 1 or self.duration <= 0.0 or self.tube < 0.0:
            raise ValueError(
                "a simulation needs at least 2 balls and 1 time step, a duration > 0 and a return tube of length >= 0, "
                f"got count {self.count}, steps {self.steps}, duration {self.duration} s, tube {self.tube} rad (angle)"
            )
        if self.count * self.groove.pair.spacing >= self.ring:
            raise ValueError(
                f"{self.count} balls take {self.count * self.groove.pair.spacing:.6g} rad and do not fit into the closed "
                f"track of {self.ring:.6g} rad: lower the number of balls or lengthen the track"
            )

    @property
    def tracks(self) -> tuple[ClosedTrack]:
        """The one closed track of the screw, which turns with the nut."""
        arc = 2.0 * np.pi * self.turns
        return (ClosedTrack(0, -0.5 * arc, arc, self.ring, self.groove.pair.spacing, slice(0, self.count)),)

    @property
    def spacing(self) -> Array:
        """Difference of the azimuths of each ball and the next one if they touch ``(N,)`` [rad]."""
        return np.full(self.count, self.groove.pair.spacing)

    @property
    def number(self) -> Index:
        """Numbers of the balls, 0 to N - 1 ``(N,)``."""
        return np.arange(self.count)

    @property
    def ring(self) -> float:
        """Length of the closed track, return tube included, as an azimuth [rad]."""
        return 2.0 * np.pi * self.turns + self.tube

    @property
    def track_occupation(self) -> float:
        """Length of all balls in a row divided by the length of the loaded turns (97.8 % in Lin's section 3.4.4)."""
        return self.count * self.groove.pair.spacing / (2.0 * np.pi * self.turns)

    def fold_into_track(self, azimuth: Array, nut_angle: float) -> tuple[Array, Mask]:
        """Return the balls' azimuths, reduced to one passage of the closed track, then which balls are in the loaded turns.

        ``azimuth``: azimuths of the balls, measured on the screw, which increase without bound ``(N,)`` [rad];
        ``nut_angle``: angle by which the nut has turned relative to the screw [rad]. Returns first the azimuths within one
        passage of the track, measured on the screw ``(N,)`` [rad], then whether each ball is in the loaded turns ``(N,)``.
        """
        (track,) = self.tracks
        along = track.distances_from_arc_start(azimuth, nut_angle)
        return along + nut_angle + track.loaded_arc_start, along < track.arc

    def state_at_start(self) -> BallState:
        """Return the state at the start: balls spread evenly over the closed track, at the nominal orbital speed."""
        azimuth = self.ring * (np.arange(self.count) + self.first) / self.count - np.pi * self.turns
        gap = np.full(self.count, self.ring / self.count - self.groove.pair.spacing)
        return BallState(azimuth, gap, np.full(self.count, self.groove.nominal_orbit - self.groove.screw_speed), None)

    def time_to_next_arc_end(self, azimuth: Array, omega: Array, time: float) -> float:
        """Return the time until a ball reaches an end of the nut's loaded turns [s].

        The result is inf for a track without return tube whose contact angles are the same at both ends, because
        nothing then changes there. ``azimuth``: azimuths of the balls, measured on the screw ``(N,)`` [rad]; ``omega``:
        their angular speeds ``(N,)`` [rad/s]; ``time``: time since the start [s].
        """
        if self.tube == 0.0 and (self.amplitude == 0.0 or (self.cycles * self.turns).is_integer()):
            return np.inf
        speed = self.groove.speed
        return self.tracks[0].time_to_arc_end(azimuth, omega - speed, speed * time)

    def solve_at_instant(
        self, azimuth: Array, time: float, slack: Array, memory: CoupledChainSolution | None
    ) -> Search[InstantSolution]:
        """Return the contact loads and ball motions of the simulated screw at one instant.

        ``azimuth``: azimuths of the balls, measured on the screw ``(N,)`` [rad]; ``time``: time since the start [s];
        ``slack``: largest rate at which the difference of the azimuths of each ball and the next one may decrease ``(N,)``
        [rad/s]; ``memory``: solution at the previous instant, None at the start.
        """
        turned = self.groove.speed * time
        azimuths, loaded = self.fold_into_track(azimuth, turned)
        cell = balls_at_instant(self, azimuths, loaded, turned)
        near = yield from search_coupled_chain(cell, slack, self.coupling, memory, self.rounds)
        m = near.motion
        return InstantSolution(
            omega=m.q[:, 0] - self.groove.screw_speed,
            ball_force=m.ball_force,
            load=near.loads_with_friction.force,
            loaded=loaded,
            losses=m.losses_by_cause,
            input_power=m.input_power,
            converged=m.converged and near.loads_with_friction.converged and (near.converged or self.rounds == 1),
            memory=near,
            change=near.last_friction_change,
        )


def contact_angle_deviation(run: Run, azimuth: Array, nut_angle: float = 0.0) -> Array:
    """Return the deviation theta of each ball's contact angles from the nominal one ``(N,)`` [rad] (Lin's Figure 3.23).

    Parameters
    ----------
    run
        Simulated ball screw, which gives amplitude, number of periods and phase of theta.
    azimuth
        Azimuths of the balls on the screw ``(N,)`` [rad].
    nut_angle
        Angle by which the nut has turned relative to the screw [rad].
    """
    own = azimuth - (nut_angle if run.follows == "nut" else 0.0)
    return np.asarray(run.amplitude * np.sin(run.cycles * own + run.phase))


def balls_at_instant(run: Run, azimuth: Array, loaded: Mask, nut_angle: float) -> screw_motion.BallsBetweenGrooves:
    """Return the balls of a simulated screw at one instant and the force on it, as argument of `search_coupled_chain`.

    ``run``: the simulated screw; ``azimuth``: azimuths of the balls, measured on the screw ``(N,)`` [rad]; ``loaded``:
    whether each ball is in the loaded turns ``(N,)`` (balls outside get so much clearance that they have no contact);
    ``nut_angle``: angle by which the nut has turned relative to the screw [rad].
    """
    g = run.groove
    angle = g.contact_angle + contact_angle_deviation(run, azimuth, nut_angle)[:, None] * np.array(run.pattern)
    clear = np.where(loaded, run.oversize, -0.5 * g.groove_ball_centre_distance)
    rows = screw_motion.screw_displacement_maps(g, azimuth, run.free)
    return screw_motion.balls_without_friction(g, angle, np.repeat(clear[:, None], 4, axis=1), rows, np.array(run.force))


def simulate_equal_steps(run: Run) -> TravelHistory:
    """Return the time history of a ball screw, simulated by Lin's scheme of equal time steps from evenly spread balls.

    ``run``: ball screw, with duration and number of steps of the simulation.
    """
    return simulate_runs_in_equal_steps([run])[0]


def simulate_runs_in_equal_steps(runs: Sequence[Run]) -> list[TravelHistory]:
    """Return the time histories of several ball screws, simulated as by `simulate_equal_steps`, side by side."""
    return solve_together([travel(run, run.duration, run.steps, "equal") for run in runs])


@dataclass(frozen=True)
class ScrewRunSummary:
    """Those results of a simulated ball screw for which section 3.4.4 of Lin's thesis prints values."""

    #: Largest ratio of the friction torque between balls to that in the grooves.
    largest_ball_to_groove_ratio: float
    #: Nut angle at which the ratio of the friction torque between balls to that in the grooves is largest [deg].
    nut_angle_of_largest_ratio: float
    #: Nut angle of the first instant at which no balls press on each other, after the instant of the largest ratio [deg];
    #: nan if there is none.
    nut_angle_without_contact: float
    #: Largest number of groups of touching balls at any instant.
    most_touching_groups: int
    #: Variation of the friction torque in the grooves, (largest - least)/mean; nan without friction.
    groove_variation: float


def summarise_screw_run(result: TravelHistory) -> ScrewRunSummary:
    """Return those results of a simulated ball screw for which section 3.4.4 of Lin's thesis prints values.

    Parameters
    ----------
    result
        History of a transient simulation.
    """
    angle = np.degrees(result.nut_angle)
    top = int(np.argmax(result.ball_to_groove_ratio))
    later = np.flatnonzero(~result.presses_on_next.any(axis=1) & (np.arange(angle.size) > top))
    torque = result.groove_torque
    mean = result.mean_over_time(torque)
    return ScrewRunSummary(
        largest_ball_to_groove_ratio=float(result.ball_to_groove_ratio[top]),
        nut_angle_of_largest_ratio=float(angle[top]),
        nut_angle_without_contact=float(angle[later[0]]) if later.size else float("nan"),
        most_touching_groups=int(np.max(result.touching_group_counts)),
        groove_variation=float(np.ptp(torque) / mean) if mean > 0.0 else float("nan"),
    )
