"""A whole ball screw in time: recirculating balls that engage and part (Lin 3.4.4), by implicit non-smooth steps.

Over a step the gap of neighbours obeys 0 <= F, 0 <= gap + rate dt, F (gap + rate dt) = 0, so that balls keep their
order and never overlap. The track is a ring: the loaded turns of the nut and a return tube of given length.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.friction.screw.coupled import CoupledChain, coupled_chain
from rollbench.lowfi.friction.screw.groove import ScrewGroove
from rollbench.lowfi.friction.screw.load import Cell, screw_rows
from rollbench.lowfi.friction.screw.motion import Coupling
from rollbench.lowfi.friction.screw.pair import BOTH
from rollbench.lowfi.friction.screw.steps import StepError, step_error
from rollbench.meshes.arrays import Array


@dataclass(frozen=True)
class Run:
    """A run of ``steps`` over ``duration`` [s]; SI. From ``oversize`` on, assumptions that the source does not print.

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
    oversize: float = 0.0
    amplitude: float = 0.0
    cycles: float = 2.0
    phase: float = 0.0
    pattern: tuple[float, ...] = BOTH
    tube: float = 0.0
    first: float = 0.5
    coupling: Coupling = "none"
    rounds: int = 1

    def __post_init__(self) -> None:
        """Refuse what does not fit."""
        if self.count < 2 or self.steps < 1 or self.duration <= 0.0 or self.tube < 0.0:
            raise ValueError("need count >= 2, steps >= 1, duration > 0 and tube >= 0")
        if self.count * self.groove.pair.spacing >= self.ring:
            raise ValueError("more balls than the track holds")

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
        along = np.mod(azimuth - nut_angle + np.pi * self.turns, self.ring)
        return along + nut_angle - np.pi * self.turns, along < 2.0 * np.pi * self.turns


@dataclass(frozen=True)
class RunResult:
    """Arrays over T = steps, N balls; ball k pushes ball k + 1, the last one the first.

    nut_angle (T,) [rad]; azimuth (T, N) unwrapped, at the start of each step; gap (T, N) [rad] at its end; ball_force
    (T, N) [N]; omega (T, N) [rad/s]; load (T, N, 4) [N]; torques (T,) [N m] of grooves, of ball-to-ball sliding and of
    closing gaps; imbalance (T,): input power less losses, relative; change (T,): of friction fed back to loads [N];
    converged (T,): loads and motion, and with more than one round that they agree.
    """

    run: Run
    nut_angle: Array
    azimuth: Array
    gap: Array
    ball_force: Array
    omega: Array
    load: Array
    groove_torque: Array
    ball_torque: Array
    closing_torque: Array
    imbalance: Array
    change: Array
    converged: NDArray[np.bool_]

    @property
    def torque(self) -> Array:
        """Friction torque (T,) [N m] (Figure 3.25)."""
        return np.asarray(self.groove_torque + self.ball_torque + self.closing_torque)

    @property
    def good(self) -> bool:
        """Whether every step converged."""
        return bool(self.converged.all())

    @property
    def contact(self) -> NDArray[np.bool_]:
        """Which neighbours touch, (T, N): the dots of Figure 3.24."""
        return np.asarray(self.ball_force > 0.0)

    @property
    def spacing(self) -> Array:
        """Angular distance (T, N) of ball k + 1 from ball k at the end of each step [rad] (Figure 3.24)."""
        return self.gap + self.run.groove.pair.spacing

    @property
    def ratio(self) -> Array:
        """Torque by ball-to-ball contact over that of the grooves, (T,); nan without friction."""
        groove = self.groove_torque
        part = self.ball_torque + self.closing_torque
        return np.divide(part, groove, out=np.full_like(groove, np.nan), where=groove > 0.0)


def deviation(run: Run, azimuth: Array) -> Array:
    """Deviation theta (N,) [rad] of the screw's contact angles at azimuths (N,) (Figure 3.23)."""
    return np.asarray(run.amplitude * np.sin(run.cycles * azimuth + run.phase))


def run_cell(run: Run, azimuth: Array, loaded: NDArray[np.bool_]) -> Cell:
    """Balls at azimuths (N,) on the screw; those not loaded keep clear of the grooves."""
    n, g = azimuth.size, run.groove
    angle = g.contact_angle + deviation(run, azimuth)[:, None] * np.array(run.pattern)
    clear = np.where(loaded, run.oversize, -0.5 * g.reach)
    return Cell(
        g,
        angle,
        np.repeat(clear[:, None], 4, axis=1),
        screw_rows(g, azimuth, run.free),
        np.array(run.force),
        np.zeros((n, 2)),
        np.zeros((n, 2)),
        np.zeros(len(run.free)),
    )


@dataclass
class _Log:
    rows: dict[str, list[Array | float | bool]] = field(default_factory=dict)

    def add(self, **values: Array | float | bool) -> None:
        """Append one step."""
        for key, value in values.items():
            self.rows.setdefault(key, []).append(value)


def simulate(run: Run) -> RunResult:
    """Run from evenly spread balls. Gaps stay >= 0 and sum up to the free length of the ring, at every step."""
    g, n, dt = run.groove, run.count, run.duration / run.steps
    azimuth = run.ring * (np.arange(n) + run.first) / n - np.pi * run.turns
    gap = np.full(n, run.ring / n - g.pair.spacing)
    near: CoupledChain | None = None
    log = _Log()
    for k in range(run.steps):
        nut_angle = g.speed * dt * k
        there, loaded = run.place(azimuth, nut_angle)
        near = coupled_chain(run_cell(run, there, loaded), gap / dt, run.coupling, near, run.rounds)
        m, omega = near.motion, near.motion.q[:, 0] - g.screw_speed
        # never less than zero but for round-off
        gap = np.maximum(gap + dt * (np.roll(omega, -1) - omega), 0.0)
        log.add(
            nut_angle=nut_angle,
            azimuth=azimuth,
            gap=gap,
            ball_force=m.ball_force,
            omega=omega,
            load=near.load.force,
            groove_torque=float(m.groove_loss.sum()) / abs(g.speed),
            ball_torque=float(m.ball_loss.sum()) / abs(g.speed),
            closing_torque=float(m.closing_loss.sum()) / abs(g.speed),
            imbalance=m.input_power / m.loss - 1.0 if m.loss > 0.0 else 0.0,
            change=near.change,
            converged=m.converged and near.load.converged and (near.converged or run.rounds == 1),
        )
        azimuth = azimuth + dt * omega
    return RunResult(run, **{key: np.array(rows) for key, rows in log.rows.items()})


def checked(run: Run) -> tuple[RunResult, StepError | None]:
    """The run at its own steps with their error, from runs of half and a quarter of them; None for an odd number."""
    coarse = [simulate(replace(run, steps=run.steps // k)) for k in (4, 2) if run.steps % k == 0]
    found = simulate(run)
    if not coarse or not all(r.good for r in (*coarse, found)):
        return found, None
    return found, step_error([r.torque for r in (*coarse, found)])


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


def groups(contact: NDArray[np.bool_]) -> Array:
    """Number of groups of touching balls (T,) on the closed track, from contacts (T, N)."""
    return np.asarray(np.sum(contact & ~np.roll(contact, 1, axis=1), axis=1) + np.all(contact, axis=1))


def summarise(result: RunResult) -> RunSummary:
    """The statements of 3.4.4 as numbers."""
    angle = np.degrees(result.nut_angle)
    top = int(np.argmax(result.ratio))
    later = np.flatnonzero(~result.contact.any(axis=1) & (np.arange(angle.size) > top))
    torque = result.groove_torque
    return RunSummary(
        largest=float(result.ratio[top]),
        at=float(angle[top]),
        none_at=float(angle[later[0]]) if later.size else float("nan"),
        groups=int(np.max(groups(result.contact))),
        groove_variation=float(np.ptp(torque) / torque.mean()) if torque.mean() > 0.0 else float("nan"),
    )
