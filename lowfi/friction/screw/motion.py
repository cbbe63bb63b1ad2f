"""Balls between a rigid screw and a rigid nut: contact loads, quasi-static motion, effect of friction on loads (Lin 3.4.1).

The motion of each ball is that of least dissipation. Its in-plane friction (the helix turns nut and screw against each
other about y3) changes the contact loads through the ball's equilibrium: ``screw_coupled`` iterates both.

Loads are the minimum of a convex energy over all positions. Each ball moves in the plane of its groove section (x3 radial,
z3 binormal), the screw by its free motions u, the nut is fixed. In-plane friction enters as forces on balls and screw that
do not change while they settle.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from rollbench.lowfi.friction.contact.kernel_types import CellArrays
from rollbench.lowfi.friction.contact.laws import Contacts, Law, Sigmoid, equal_contacts
from rollbench.lowfi.friction.contact.motion import Motion, Problem, balance_by_root, least_dissipation
from rollbench.lowfi.friction.contact.rings import SettledCell, settle_cell
from rollbench.lowfi.friction.screw.groove import (
    ON_SCREW,
    SIGN_X,
    SIGN_Z,
    ScrewGroove,
    contact_axes,
    plain_array,
    section_frame,
)
from rollbench.lowfi.jit import SCREW, kernels
from rollbench.lowfi.statics.settle import contact_angles
from rollbench.meshes.arrays import Array, Mask


def bare_cell(groove: ScrewGroove, angle: Array, interference: Array, rows: Array, force: Array) -> Cell:
    """Return a cell with no forces but ``force`` on the screw, which begins at its nominal position."""
    none = np.zeros((angle.shape[0], 2))
    return Cell(groove, angle, interference, rows, force, none, none, np.zeros(force.size))


@dataclass(frozen=True)
class Cell:
    """N balls between screw and nut, with m free motions u of the screw."""

    #: The grooves.
    groove: ScrewGroove
    #: Groove angles ``(N, 4)`` [rad].
    angle: Array
    #: Interference along each contact ``(N, 4)`` [m].
    interference: Array
    #: Motion of the screw along x3, y3, z3 per u ``(N, 3, m)``.
    rows: Array
    #: Force on the screw along u ``(m,)`` [N].
    force: Array
    #: Further displacement of the screw along x3, z3 ``(N, 2)`` [m].
    offset: Array
    #: Forces on the balls along x3, z3 ``(N, 2)`` [N].
    push: Array
    #: Further forces on the screw along u ``(m,)`` [N].
    drag: Array

    @property
    def screw_motion(self) -> Array:
        """Motion of the screw along x3 and z3 per u ``(N, 2, m)``."""
        return self.rows[:, [0, 2]]


def load_arrays(cell: Cell) -> CellArrays:
    """Return the cell as the kernels take it."""
    start = cell.groove.reach * np.stack([SIGN_X * np.cos(cell.angle), SIGN_Z * np.sin(cell.angle)], axis=-1)
    start, interference, C, section, offset, push, pull = map(
        plain_array,
        (
            start,
            cell.interference,
            cell.groove.constants.C,
            cell.screw_motion,
            cell.offset,
            cell.push,
            cell.force + cell.drag,
        ),
    )
    return CellArrays(start, interference, C, section, offset, push, pull, float(cell.groove.reach))


def _first_guess(cell: Cell) -> tuple[Array, Array]:
    """Return a start: screw pressed along its load by about the approach of an equal share, balls half way."""
    total = float(np.linalg.norm(cell.force))
    count, m = cell.angle.shape[0], cell.rows.shape[2]
    if total == 0.0 or m == 0:
        return np.zeros((count, 2)), np.zeros(m)
    approach = float(np.max(cell.groove.constants.C)) * (total / count) ** (2.0 / 3.0)
    u = cell.force / total * 4.0 * (approach + max(0.0, -float(np.min(cell.interference))))
    return 0.5 * (cell.screw_motion @ u), u


def settle_load(cell: Cell, start: tuple[Array, Array] | None = None, fast: bool = True) -> SettledCell:
    """Return the loads of the cell, the minimum of sum (2/5) C^(-3/2) <approach>^(5/2) - force . u - push . p.

    By Newton's method with line search; forces do not depend on the start.

    Parameters
    ----------
    cell
        The cell.
    start
        Positions of balls ``(N, 2)`` and screw ``(m,)`` to begin from [m].
    fast
        Whether to use compiled kernels.
    """
    load = float(np.linalg.norm(cell.force) + np.linalg.norm(cell.drag) + np.sum(np.abs(cell.push)))
    p, u = _first_guess(cell) if start is None else (plain_array(start[0]).copy(), plain_array(start[1]).copy())
    settled = settle_cell(load_arrays(cell), load, p, u, contact_angles, fast)
    # from a distant start a nearly unloaded ball may creep along a flat energy
    return settled if settled.converged or start is None else settle_load(cell, None, fast)


def screw_rows(groove: ScrewGroove, azimuth: Array, free: str) -> Array:
    """Return the motion ``(N, 3, m)`` along x3, y3, z3 by the screw's free translations, letters of ``free`` in order.

    "z": along the axis; "x", "y": across, in fixed axes; "r": radially at every ball (a ball with a separate screw).
    Raises ValueError for other letters.
    """
    if any(letter not in "xyzr" for letter in free):
        raise ValueError(f'free motions of the screw are letters of "xyzr", not "{free}"')
    turn = section_frame(groove, azimuth)
    out = np.zeros((*turn.shape[:2], len(free)))
    for j, letter in enumerate(free):
        out[..., j] = (1.0, 0.0, 0.0) if letter == "r" else turn[..., "xyz".index(letter)]
    return out


#: What friction may change: nothing; the balls' places (as the source, 3.4.1); those and the screw's.
Coupling = Literal["none", "ball", "ball and screw"]

#: Change of friction [of the sum of contact loads] between rounds that counts as agreement, and most rounds.
AGREED, ROUNDS = 1e-11, 100


@dataclass(frozen=True)
class BallMotion:
    """Motion of one ball."""

    #: The grooves.
    groove: ScrewGroove
    #: Contacts of the ball ``(4,)``.
    at: Contacts
    #: Directions to them ``(4, 3)``.
    normals: Array
    #: Problem of its motion.
    problem: Problem
    #: Motion of least dissipation.
    motion: Motion

    @property
    def wrench(self) -> Array:
        """Friction force and moment on the ball at each contact, in x3, y3, z3 ``(4, 6)`` [N, N m]."""
        return contact_wrench(self.normals, self.motion.friction.force, self.motion.friction.moment)

    @property
    def input_power(self) -> float:
        """Power [W] that the helical motions of nut and screw supply against friction; equals ``motion.loss``."""
        return helical_power(self.groove, self.normals, self.wrench)


def contact_wrench(normals: Array, force: Array, moment: Array) -> Array:
    """Return friction in x3, y3, z3 ``(..., 4, 6)`` of forces ``(..., 4, 2)`` along x, z and moments ``(..., 4)``."""
    axes = contact_axes(normals)
    f = np.einsum("...r,...ri->...i", force, axes[..., :2, :])
    return np.concatenate([f, moment[..., None] * axes[..., 2, :]], axis=-1)


def helical_power(groove: ScrewGroove, normals: Array, wrench: Array) -> float:
    """Return the power that keeps nut and screw in helical motion against friction on the balls ``(..., 4, 6)`` [W].

    The bodies' friction is the opposite of the balls', so that the drives push with it: velocity of the body's surface
    at the contact times force, axis times moment.
    """
    body = np.where(ON_SCREW, groove.screw_speed, groove.nut_speed)
    surface = groove.ball_radius * (normals @ groove.crosses[0].T) + groove.radius * np.array([0.0, 1.0, 0.0])
    per_speed = np.sum(surface * wrench[..., :3], axis=-1) + wrench[..., 3:] @ groove.axis
    return float(np.sum(body * per_speed))


def screw_contacts(groove: ScrewGroove, force: Array) -> Contacts:
    """Return friction contacts ``(n,)`` of forces ``(..., 4)``, flattened; an unloaded one keeps a vanishing ellipse.

    Parameters
    ----------
    groove
        Grooves and balls of a screw.
    force
        Contact forces, ``(..., 4)`` [N].
    """
    h, four = groove.constants, np.reshape(force, (-1, 4)).astype(float)
    a, b = np.empty_like(four), np.empty_like(four)
    kernels(SCREW, compiled=True).semi_axes(four, plain_array(h.C_a), plain_array(h.C_b), a, b)
    return equal_contacts(a.ravel(), b.ravel(), four.ravel(), groove.mu)


def ball_motion(
    groove: ScrewGroove,
    force: Array,
    angle: Array,
    push: Array | None = None,
    start: Array | None = None,
    fast: bool = True,
) -> BallMotion:
    """Return the motion of one ball at given loads.

    Parameters
    ----------
    groove
        The grooves.
    force
        Contact forces ``(4,)`` [N], two to four of them loaded.
    angle
        Contact angles ``(4,)`` [rad].
    push
        Other generalised forces on omega_B, omega_x, omega_y, omega_z ``(4,)`` [N m].
    start
        Motion to begin from ``(4,)`` [rad/s].
    fast
        Whether to use compiled kernels.
    """
    normals = groove.normals(angle)
    maps, drives = groove.maps(normals)
    at = screw_contacts(groove, np.asarray(force, dtype=float))
    problem = Problem(at, maps, drives, np.zeros(4) if push is None else np.asarray(push, dtype=float))
    return BallMotion(groove, at, normals, problem, least_dissipation(problem, start, fast))


def source_law(groove: ScrewGroove, sharpness: float, map_spacing: float | None = None) -> Sigmoid:
    """Return Lin's sigmoid with the relative spin of a diagonal pair as its reference, omega_I sin(beta) for a bearing.

    Parameters
    ----------
    groove
        The grooves.
    sharpness
        k_S.
    map_spacing
        Step in c/a of his interpolated maps; None: exact integrals.

    References
    ----------
    Lin (2019), 3.20 and 3.70.
    """
    spin = abs(groove.speed) * float(np.cos(groove.lead_angle) * np.sin(groove.contact_angle))
    return Sigmoid(sharpness, spin, map_spacing)


def ball_motion_by_root(ball: BallMotion, law: Law, start: Array | None = None) -> Motion:
    """Return the motion by Lin's method at the same loads, for comparison: a root of the balance (Lin 3.69, 3.71).

    law: friction law; start ``(4,)``: rolling at the nominal contact angle where None. "failed" from many starts near
    two-point contact.
    """
    first = np.array([ball.groove.nominal_orbit, 0.0, 0.0, 0.0]) if start is None else start
    return balance_by_root(ball.problem, law, first, fast=True)


def feedback(cell: Cell, wrench: Array, extra: Array, coupling: Coupling) -> tuple[Array, Array]:
    """Return push on balls ``(N, 2)`` and drag on the screw ``(m,)`` of friction ``(N, 4, 6)`` and forces ``(N, 2)``."""
    push = wrench[:, :, [0, 2]].sum(axis=1) + extra
    on_screw = wrench[:, ON_SCREW, :3].sum(axis=1)
    drag = -np.einsum("nim,ni->m", cell.rows, on_screw)
    if coupling == "none":
        return np.zeros_like(push), np.zeros_like(drag)
    return push, drag if coupling == "ball and screw" else np.zeros_like(drag)


class Mixer:
    """Anderson acceleration of x = g(x) over the last few rounds, damped, and restarted after many rounds."""

    def __init__(self, depth: int = 3, patience: int = 20) -> None:
        """Make a mixer without history.

        depth: differences stored; patience: rounds after which steps are halved and the history dropped.
        """
        self.depth, self.patience, self.rounds = depth, patience, 0
        self.x, self.r = list[Array](), list[Array]()

    def keep(self, which: Mask) -> None:
        """Go on with some of many x."""
        self.x, self.r = [x[which] for x in self.x], [r[which] for r in self.r]

    def next(self, x: Array, g: Array) -> Array:
        """Return the next iterate after x gave g; x may be overwritten afterwards."""
        if self.rounds % self.patience == 0:
            self.x, self.r = [], []
        damping = 0.5 ** (self.rounds // self.patience)
        self.rounds += 1
        self.x, self.r = [*self.x[-self.depth :], x.copy()], [*self.r[-self.depth :], g - x]
        if len(self.x) == 1:
            return np.asarray(x + damping * (g - x))
        dx, dr = (np.diff(np.stack(rows, axis=-1)) for rows in (self.x, self.r))
        share = np.linalg.pinv(dr, rcond=1e-8) @ self.r[-1][..., None]
        return np.asarray(x + damping * (g - x) - ((dx + damping * dr) @ share)[..., 0])


def hold_screw(cell: Cell, load: SettledCell) -> Cell:
    """Return the cell with its screw fixed in its equilibrium position, without freedoms."""
    return replace(
        cell,
        rows=np.zeros((cell.angle.shape[0], 3, 0)),
        force=np.zeros(0),
        drag=np.zeros(0),
        offset=cell.offset + cell.screw_motion @ load.inner,
    )
