"""Balls that begin to roll from rest, in time: elastic displacements carried along by the material, gaps that close.

In a step dt material moves by V dt through every contact, so that

    s dt = A q(t) - A_shifted q(t - dt) + rigid slip dt,

A_shifted giving the old displacements where the material was: nothing is interpolated. First order in the step. Contact
forces are given and stay; the frame moves with each ball's centre.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from time import process_time

import numpy as np

from rollbench.hifi.rolling import balls
from rollbench.hifi.rolling.friction import Contact, solve_friction
from rollbench.hifi.rolling.kinematics import Rolling, rolling_speed
from rollbench.meshes.arrays import Array

#: How far beyond its zone the kernel of finite bodies is good, over the zone's half length.
REACH = 1.2


@dataclass(frozen=True)
class TransientResult:
    """Steps of a run: ends of the steps ``(T,)`` [s], speeds of the balls along the track ``(T, N)``, rotations ``(T,
    N, 3)`` [rad/s], forces ``(T, M)`` [N] and gaps ``(T, M)`` [m] of the meetings, losses ``(T,)`` [W] of friction and of
    closing balls in the step in which they meet, power put in ``(T,)`` [W] and the rest of it that elastic displacements
    store or lose in their steps ``(T,)`` [W]; seconds of processor time; "converged", or the first step that did not and
    why."""

    time: Array
    speed: Array
    rotation: Array
    force: Array
    gap: Array
    loss: Array
    power: Array
    stored: Array
    seconds: float
    status: str

    @property
    def converged(self) -> bool:
        """Whether every step is a solution."""
        return self.status == "converged"


@dataclass(frozen=True)
class _Carried:
    """A contact without its history, its displacements now and where the material was, per force, over the step."""

    contact: Contact
    present: Array
    before: Array

    def at(self, forces: Array) -> Contact:
        """The contact with the history of ``forces`` (2 n,) [N]."""
        return replace(self.contact, elastic=self.present, given=self.contact.given - self.before @ forces)


def run_from_rest(
    scene: Rolling, duration: float, steps: int, gap: float = 0.0, choices: balls.Choices | None = None
) -> TransientResult:
    """Equal steps of ``duration`` [s] from rest, all neighbours ``gap`` [m] apart at first.

    Raises ValueError for a duration, steps or gap that make no sense, and for finite bodies in steps that carry material
    from beyond their contact zone.
    """
    if not duration > 0.0 or steps < 1 or gap < 0.0:
        raise ValueError("need a duration > 0, at least one step and no negative gap")
    return _run(scene, duration / steps, steps, gap, choices or balls.Choices())


def _run(scene: Rolling, dt: float, steps: int, gap: float, choices: balls.Choices) -> TransientResult:
    begin = process_time()
    carried = _carried(scene, choices, dt)
    forces = [np.zeros(c.contact.given.size) for c in carried]
    y, gaps, out, status = balls.start_of(scene), np.full(len(scene.meetings), gap), [], "converged"
    for step in range(steps):
        meetings = tuple(replace(m, apart=float(g) / dt) for m, g in zip(scene.meetings, gaps, strict=True))
        contacts = [c.at(q) for c, q in zip(carried, forces, strict=True)]
        balance = balls.balance_of(replace(scene, meetings=meetings), contacts)
        solution = solve_friction(contacts, balance, y, forces)
        if not solution.converged:
            status = f"step {step + 1}: {solution.status}"
            break
        y, old, forces = solution.motions, forces, solution.forces
        closing = np.array([float(m.rows[0] @ y[m.columns]) for m in scene.meetings])
        gaps = np.maximum(gaps - dt * closing, 0.0)
        out.append(_row(scene, carried, (old, forces), solution.slips, y, gaps))
    speed, rotation, force, gap_left, loss, power, stored = (
        np.array([row[k] for row in out], dtype=float) for k in range(7)
    )
    time = np.asarray(dt * (1.0 + np.arange(len(out))))
    return TransientResult(time, speed, rotation, force, gap_left, loss, power, stored, process_time() - begin, status)


def _carried(scene: Rolling, choices: balls.Choices, dt: float) -> list[_Carried]:
    out = []
    for (_, _, touch), contact in zip(balls.touching(scene), balls.contacts_of(scene, choices), strict=True):
        patch = balls.patch_of(scene, touch, choices)
        shift = rolling_speed(touch, scene) * dt
        if patch.regular is not None and float(patch.at[:, 0].max()) + shift > REACH * patch.regular.scale[0]:
            raise ValueError(
                "a step carries material from beyond the zone of finite bodies: take shorter ones, or half spaces"
            )
        share = choices.elastic / dt
        out.append(_Carried(contact, share * patch.tangential(), share * patch.tangential(shift)))
    return out


def _row(
    scene: Rolling,
    carried: list[_Carried],
    forces: tuple[list[Array], list[Array]],
    slips: list[Array],
    y: Array,
    gaps: Array,
) -> tuple[Array, Array, Array, Array, float, float, float]:
    """Speeds, rotations, forces, gaps, loss, power put in and stored at the end of a step; forces: before and after it."""
    old, new = forces
    speed, rotation, press = balls.moving(scene, y)
    closing = sum(float(f) * float(m.rows[0] @ y[m.columns]) for f, m in zip(press, scene.meetings, strict=True))
    rub = -sum(float(q @ s) for q, s in zip(new, slips, strict=True)) + float(balls.meeting_losses(scene, y).sum())
    power = -sum(float(q @ c.contact.given) for q, c in zip(new, carried, strict=True))
    stored = sum(float(q @ (c.present @ q - c.before @ before)) for q, before, c in zip(new, old, carried, strict=True))
    return speed, rotation, press, gaps, rub + closing, power, stored
