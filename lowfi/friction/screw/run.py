"""A whole ball screw in time: recirculating balls that engage and part (Lin 3.4.4), between a rigid screw and a rigid nut.

The track is a ring: the loaded turns of the nut and a return tube of given length. See ``travel``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.friction.screw.coupled import CoupledChain, coupled_chain
from rollbench.lowfi.friction.screw.groove import ScrewGroove
from rollbench.lowfi.friction.screw.load import Cell, bare_cell, screw_rows
from rollbench.lowfi.friction.screw.motion import Coupling
from rollbench.lowfi.friction.screw.pair import BOTH
from rollbench.lowfi.friction.screw.track import Track
from rollbench.lowfi.friction.screw.travel import History, Instant, Place, simulate
from rollbench.meshes.arrays import Array
from rollbench.meshes.fields import keyed, usual


@keyed
@dataclass(frozen=True)
class Run:
    """A run over ``duration`` [s], in ``steps`` steps by the scheme "equal"; SI. A setting of ``travel``, azimuths on the
    screw. From ``oversize`` on, assumptions that the source does not print.

    force: on the screw along its free translations ``free`` [N]; amplitude [rad], cycles per turn and phase [rad] of
    the deviation theta of the contact angles, times pattern (SL, SR, NL, NR), over the azimuth on the screw; tube:
    length of the return tube as an angle of the track [rad], balls in it bear no load; first: place of the first ball
    at the start as a fraction of the distance between balls; rounds: of load and friction per step (one: friction of the
    step before).
    """

    groove: ScrewGroove
    count: int
    turns: float
    force: tuple[float, ...]
    free: str
    duration: float
    steps: int
    oversize: float = usual(0.0)
    amplitude: float = usual(0.0)
    cycles: float = usual(2.0)
    phase: float = usual(0.0)
    pattern: tuple[float, ...] = usual(BOTH)
    tube: float = usual(0.0)
    first: float = usual(0.5)
    coupling: Coupling = usual("none")
    rounds: int = usual(1)

    def __post_init__(self) -> None:
        """Refuse what does not fit."""
        if self.count < 2 or self.steps < 1 or self.duration <= 0.0 or self.tube < 0.0:
            raise ValueError("need count >= 2, steps >= 1, duration > 0 and tube >= 0")
        if self.count * self.groove.pair.spacing >= self.ring:
            raise ValueError("more balls than the track holds")

    @property
    def tracks(self) -> tuple[Track]:
        """The one closed track, which turns with the nut."""
        arc = 2.0 * np.pi * self.turns
        return (Track(0, -0.5 * arc, arc, self.ring, self.groove.pair.spacing, slice(0, self.count)),)

    @property
    def spacing(self) -> Array:
        """Azimuth (N,) by which the next ball is ahead where both touch [rad]."""
        return np.full(self.count, self.groove.pair.spacing)

    @property
    def number(self) -> NDArray[np.int64]:
        """Numbers (N,) of the balls."""
        return np.arange(self.count)

    @property
    def ring(self) -> float:
        """Length of the closed track [rad]."""
        return 2.0 * np.pi * self.turns + self.tube

    @property
    def occupation(self) -> float:
        """Part of the loaded track that the balls would fill (97.8 % in 3.4.4)."""
        return self.count * self.groove.pair.spacing / (2.0 * np.pi * self.turns)

    def place(self, azimuth: Array, nut_angle: float) -> tuple[Array, NDArray[np.bool_]]:
        """Azimuths on the screw (N,) folded into the nut's turns, and which balls are in the loaded track."""
        (track,) = self.tracks
        along = track.along(azimuth, nut_angle)
        return along + nut_angle + track.first, along < track.arc

    def begin(self) -> Place:
        """Evenly spread balls."""
        azimuth = self.ring * (np.arange(self.count) + self.first) / self.count - np.pi * self.turns
        gap = np.full(self.count, self.ring / self.count - self.groove.pair.spacing)
        return Place(azimuth, gap, np.full(self.count, self.groove.nominal_orbit - self.groove.screw_speed), None)

    def to_end(self, azimuth: Array, omega: Array, time: float) -> float:
        """Time [s] until a ball passes an end of the nut's turns; inf where it meets the same there as at the other end."""
        if self.tube == 0.0 and (self.amplitude == 0.0 or (self.cycles * self.turns).is_integer()):
            return np.inf
        speed = self.groove.speed
        return self.tracks[0].to_end(azimuth, omega - speed, speed * time)

    def instant(self, azimuth: Array, time: float, slack: Array, memory: CoupledChain | None) -> Instant:
        """Loads and motions at azimuths (N,) on the screw; memory: the solution before."""
        azimuths, loaded = self.place(azimuth, self.groove.speed * time)
        near = coupled_chain(run_cell(self, azimuths, loaded), slack, self.coupling, memory, self.rounds)
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


def deviation(run: Run, azimuth: Array) -> Array:
    """Deviation theta (N,) [rad] of the screw's contact angles at azimuths (N,) (Figure 3.23)."""
    return np.asarray(run.amplitude * np.sin(run.cycles * azimuth + run.phase))


def run_cell(run: Run, azimuth: Array, loaded: NDArray[np.bool_]) -> Cell:
    """Balls at azimuths (N,) on the screw; those not loaded keep clear of the grooves."""
    g = run.groove
    angle = g.contact_angle + deviation(run, azimuth)[:, None] * np.array(run.pattern)
    clear = np.where(loaded, run.oversize, -0.5 * g.reach)
    rows = screw_rows(g, azimuth, run.free)
    return bare_cell(g, angle, np.repeat(clear[:, None], 4, axis=1), rows, np.array(run.force))


def equal_steps(run: Run) -> History:
    """The run in its own equal steps, the source's scheme, from evenly spread balls."""
    return simulate(run, run.duration, run.steps, "equal")


@dataclass(frozen=True)
class RunSummary:
    """What 3.4.4 says of its run: largest ratio of ball-to-ball torque, nut angles [deg] of it and of the first step
    without contact after it (nan if none), groups of touching balls at most, variation of groove torque (max-min)/mean.
    """

    largest: float
    at: float
    none_at: float
    groups: int
    groove_variation: float


def summarise(result: History) -> RunSummary:
    """The statements of 3.4.4 as numbers."""
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
