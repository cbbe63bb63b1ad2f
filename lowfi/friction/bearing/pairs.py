"""Friction torque of a four-point and of a double-row angular-contact bearing against the load's angle (Lin 4.3.1).

Loads of all balls between a rigid inner and a rigid outer ring, then each ball's motion of least dissipation. A
bearing is a ball screw of zero lead whose "screw" is the inner ring; friction then does not change the loads.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.friction.contact.rings import Settled
from rollbench.lowfi.friction.screw.groove import ON_SCREW, SIGN_X, SIGN_Z, ScrewGroove, frame
from rollbench.lowfi.friction.screw.load import Cell, bare_cell, settle_load
from rollbench.lowfi.friction.screw.motion import ball_motion
from rollbench.meshes.arrays import Array
from rollbench.meshes.fields import keyed, usual

#: Freedoms of the inner ring in the order of the unknowns, and the smallest part that is not round-off.
UNKNOWNS, RANK = ("ux", "uy", "uz", "rx", "ry"), 1e-9
#: Contacts (SL, SR, NL, NR) that a row has: all, or those of one diagonal.
ALL, DIAGONAL, OTHER = (True, True, True, True), (True, False, False, True), (False, True, True, False)


@dataclass(frozen=True)
class BallRow:
    """One row of balls: axial place [m] and the contacts (SL, SR, NL, NR; S: inner ring) that its grooves have."""

    place: float
    contacts: tuple[bool, bool, bool, bool]


@keyed
@dataclass(frozen=True)
class BearingCase:
    """A bearing, inner ring turning and loaded, outer ring held; SI.

    groove: lead 0; count: balls per row; force [N] in the plane of x and z at the angle from the axis z given to
    ``solve_bearing``; clearance [m] of the ball's radius at each contact, negative for preload; tilt: whether the inner
    ring may tilt; phase: azimuth of the first ball, as a fraction of the distance between balls, 0 on x; arm [m]: axial
    place where the force acts.
    """

    groove: ScrewGroove
    count: int
    rows: tuple[BallRow, ...]
    force: float
    clearance: float = usual(0.0)
    tilt: bool = usual(False)
    phase: float = usual(0.0)
    arm: float = usual(0.0)

    def __post_init__(self) -> None:
        """Refuse a helix and empty rows."""
        if self.groove.lead != 0.0 or self.count < 1 or not self.rows:
            raise ValueError("a bearing has zero lead, count >= 1 and at least one row")


@dataclass(frozen=True)
class BearingState:
    """Loads (N, 4) [N], N balls of all rows in order, losses (N, 4) [W], friction torque [N m] on the inner ring.

    points (N,): loaded contacts of each ball; converged: loads and every motion.
    """

    load: Settled
    loss: Array
    torque: float
    points: NDArray[np.int64]
    input_power: float
    converged: bool


def ring_rows(case: BearingCase) -> Array:
    """Motion (N, 3, m) at each ball by the inner ring's translations x, y, z and, with tilt, rotations about x, y.

    Rotations are scaled by the pitch radius, so that all unknowns are lengths [m].
    """
    radius, out = case.groove.pitch_radius, []
    for row in case.rows:
        for k in range(case.count):
            turn = frame(case.groove, 2.0 * np.pi * (k + case.phase) / case.count)
            move = np.eye(3)
            if case.tilt:
                at = radius * turn[0] + np.array([0.0, 0.0, row.place])
                move = np.column_stack([move, np.cross(np.eye(3)[:2], at).T / radius])
            out.append(turn @ move)
    return np.array(out)


def bearing_cell(case: BearingCase, angle: float) -> Cell:
    """Balls and load of a bearing whose force makes ``angle`` [rad] with its axis."""
    g, rows = case.groove, ring_rows(case)
    has = np.repeat(np.array([r.contacts for r in case.rows]), case.count, axis=0)
    force = case.force * np.array([np.sin(angle), 0.0, np.cos(angle)])
    if case.tilt:
        force = np.append(force, np.cross([0.0, 0.0, case.arm], force)[:2] / g.pitch_radius)
    interference = np.where(has, -case.clearance, -2.0 * g.reach)
    return bare_cell(g, np.full(has.shape, g.contact_angle), interference, rows, force)


def free_motion(case: BearingCase, angle: float) -> str:
    """Motion of the inner ring that the force at ``angle`` [rad] drives and no contact resists, in words; or empty.

    A contact resists motion along its normal at the nominal contact angle. Exact for the question whether the linear
    equilibrium of contact forces and load has a solution, but for signs of the contact forces.
    """
    cell, beta = bearing_cell(case, angle), case.groove.contact_angle
    normal = np.stack([SIGN_X * np.cos(beta), SIGN_Z * np.sin(beta)], axis=1)[ON_SCREW]
    has = cell.interference[:, ON_SCREW] > -case.groove.reach
    resists = np.einsum("sx,nxm->nsm", normal, cell.section)[has]
    _, size, v = np.linalg.svd(resists, full_matrices=True)
    null = v[int(np.sum(size > RANK * size.max(initial=0.0))) :]
    drive = null @ cell.force
    if not np.abs(drive).max(initial=0.0) > RANK * float(np.linalg.norm(cell.force)):
        return ""
    motion = np.abs(drive @ null)
    parts = [name for name, share in zip(UNKNOWNS, motion, strict=False) if share > RANK * motion.max()]
    return f"rigid motion of the inner ring in {', '.join(parts)}"


def solve_bearing(case: BearingCase, angle: float, near: BearingState | None = None) -> BearingState:
    """Loads, motions and friction torque with the force at ``angle`` [rad] from the axis; near: a similar state."""
    load = settle_load(bearing_cell(case, angle), None if near is None else (near.load.ball, near.load.inner))
    loss, good, power = np.zeros_like(load.force), load.converged, 0.0
    for k in np.flatnonzero(load.force.sum(axis=1) > 0.0):
        ball = ball_motion(case.groove, load.force[k], load.angle[k])
        loss[k] = ball.motion.friction.loss
        power += ball.input_power
        good = good and ball.motion.status != "failed"
    speed = abs(case.groove.speed)
    return BearingState(
        load=load,
        loss=loss,
        torque=float(loss.sum()) / speed,
        points=np.sum(load.force > 0.0, axis=1),
        input_power=power,
        converged=good,
    )


@dataclass(frozen=True)
class TorqueCurve:
    """Torque (n,) [N m] against the load's angle (n,) [rad] (Figure 4.7); four (n,): balls with more than two contacts.

    ratio: largest over smallest torque.
    """

    angle: Array
    torque: Array
    four: NDArray[np.int64]
    converged: NDArray[np.bool_]

    @property
    def ratio(self) -> float:
        """Largest over smallest torque."""
        return float(self.torque.max() / self.torque.min())


def bearing_states(case: BearingCase, angle: Array) -> list[BearingState]:
    """States with the force at angles (n,) [rad] from the axis, each the start of the next."""
    states: list[BearingState] = []
    for a in angle:
        states.append(solve_bearing(case, float(a), states[-1] if states else None))
    return states


def torque_curve(case: BearingCase, angle: Array) -> TorqueCurve:
    """Figure 4.7 for one bearing: angles (n,) [rad] of the force from the axis."""
    states = bearing_states(case, angle)
    return TorqueCurve(
        angle=np.asarray(angle, dtype=float),
        torque=np.array([s.torque for s in states]),
        four=np.array([int(np.sum(s.points > 2)) for s in states]),
        converged=np.array([s.converged for s in states]),
    )
