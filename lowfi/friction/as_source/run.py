"""A whole ball screw in time by the source's method, kept for comparison: a root for every touching group (Lin 3.4.4).

Each step: loads as a root, every ball's motion alone, then the groups of those that are within reach and close in
(Lin 3.77); places move on with these speeds. Nothing keeps gaps from becoming negative: how far is reported.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.friction.as_source.chain import SHARPNESS, SourceMotion, solve_by_root
from rollbench.lowfi.friction.as_source.loads import Places, loads_by_root
from rollbench.lowfi.friction.as_source.screw import screw_balls
from rollbench.lowfi.friction.contact.laws import Law
from rollbench.lowfi.friction.screw.motion import source_law
from rollbench.lowfi.friction.screw.run import Run, run_cell
from rollbench.meshes.arrays import Array


@dataclass(frozen=True)
class SourceRun:
    """T steps, N balls; ball k pushes ball k + 1, the last one the first.

    nut_angle (T,) [rad]; gap (T, N) [rad] at the end of each step, negative for overlap; ball_force (T, N) [N]; omega
    (T, N) [rad/s]; groove_torque, ball_torque (T,) [N m]; status: of each step's motion, "failed" also where no loads
    were found: then the speeds of the step before go on.
    """

    nut_angle: Array
    gap: Array
    ball_force: Array
    omega: Array
    groove_torque: Array
    ball_torque: Array
    status: tuple[str, ...]

    @property
    def failures(self) -> int:
        """Steps without a root."""
        return self.status.count("failed")

    @property
    def overlapping(self) -> int:
        """Steps with a root whose neighbours in reach close in nevertheless or pull."""
        return self.status.count("overlapping")

    @property
    def overlap(self) -> float:
        """Largest overlap of neighbours [rad]."""
        return max(0.0, -float(self.gap.min()))


@dataclass
class _Before:
    """What the step before leaves: places, motions alone and in contact (N, 4), forces (N,)."""

    at: Places
    free: Array
    q: Array
    force: Array


def simulate_by_root(run: Run, steps: int | None = None) -> SourceRun:
    """The first ``steps`` of a run (all where None) from evenly spread balls, under the source's sigmoid.

    Starts of each search: the step before, rolling at first; the text names none. Raises ValueError for what the
    comparison leaves out: balls in a return tube, loads coupled with friction.
    """
    if run.tube > 0.0 or run.coupling != "none":
        raise ValueError('the run by root finding needs tube = 0 and coupling = "none"')
    g, n, dt = run.groove, run.count, run.duration / run.steps
    law = source_law(g, SHARPNESS)
    azimuth = run.ring * (np.arange(n) + run.first) / n - np.pi * run.turns
    gap = np.full(n, run.ring / n - g.pair.spacing)
    before: _Before | None = None
    omega, rows, status = np.zeros(n), list[tuple[Array, Array, Array, float, float]](), list[str]()
    for k in range(steps or run.steps):
        azimuths, loaded = run.place(azimuth, g.speed * dt * k)
        load = loads_by_root(run_cell(run, azimuths, loaded), None if before is None else before.at)
        at = Places(load.ball, load.angle, load.inner)
        motion, order = _step(run, load.force, load.angle, gap <= 0.0, law, before)
        good = load.converged and motion.status != "failed"
        force, q, free = np.zeros(n), np.empty((n, 4)), np.empty((n, 4))
        force[order[:-1]], q[order], free[order] = motion.ball_force, motion.q, motion.free
        if good:
            before, omega = _Before(at, free, q, force), q[:, 0] - g.screw_speed
        gap = gap + dt * (np.roll(omega, -1) - omega)
        speed = abs(g.speed)
        rows.append((gap, force, omega, float(motion.groove_loss.sum()) / speed, float(motion.ball_loss.sum()) / speed))
        status.append(motion.status if good else "failed")
        azimuth = azimuth + dt * omega
    gaps, forces, speeds, groove, ball = (np.array(c, dtype=float) for c in zip(*rows, strict=True))
    nut_angle = np.array([g.speed * dt * k for k in range(len(rows))])
    return SourceRun(nut_angle, gaps, forces, speeds, groove, ball, tuple(status))


def _step(
    run: Run, force: Array, angle: Array, reach: NDArray[np.bool_], law: Law, before: _Before | None
) -> tuple[SourceMotion, NDArray[np.intp]]:
    """Motion of the balls and their order, which begins after a neighbour out of reach: the ring is cut there.

    Raises RuntimeError where all neighbours touch.
    """
    if np.all(reach):
        raise RuntimeError("every ball touches the next: the ring has no place to be cut")
    order = np.roll(np.arange(run.count), -int(np.argmin(reach)) - 1)
    balls = screw_balls(run.groove, force[order], angle[order])
    near = reach[order[:-1]]
    if before is None:
        return solve_by_root(balls, law, near), order
    free = before.free[order]
    motion = solve_by_root(balls, law, near, free, (before.q[order], before.force[order[:-1]]))
    return (motion if motion.status != "failed" else solve_by_root(balls, law, near, free)), order
