"""Balls between a rigid screw and a rigid nut: contact loads, quasi-static motion, what friction does to loads (Lin 3.4.1).

The motion of each ball is that of least dissipation. Its in-plane friction (the helix turns nut and screw against each
other about y3) changes the contact loads through the ball's equilibrium: ``screw_coupled`` iterates both.

Loads are the minimum of a convex energy over all positions. Each ball moves in the plane of its groove section (x3 radial,
z3 binormal), the screw by its free motions u, the nut stands. In-plane friction enters as forces on balls and screw that do
not change while they settle.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from rollbench.lowfi.friction.contact.kernel_types import CellArrays
from rollbench.lowfi.friction.contact.laws import Contacts, Law, Sigmoid, contacts
from rollbench.lowfi.friction.contact.motion import Motion, Problem, balance_by_root, least_dissipation
from rollbench.lowfi.friction.contact.rings import Settled, settle_cell
from rollbench.lowfi.friction.screw.groove import ON_SCREW, SIGN_X, SIGN_Z, ScrewGroove, contact_axes, frame, plain_array
from rollbench.lowfi.jit import SCREW, kernels
from rollbench.lowfi.statics.settle import contact_angles
from rollbench.meshes.arrays import Array, Mask


def bare_cell(groove: ScrewGroove, angle: Array, interference: Array, rows: Array, force: Array) -> Cell:
    """A cell with no forces but ``force`` on the screw, which begins at its place."""
    none = np.zeros((angle.shape[0], 2))
    return Cell(groove, angle, interference, rows, force, none, none, np.zeros(force.size))


@dataclass(frozen=True)
class Cell:
    """N balls: groove angles (N, 4) [rad], interference (N, 4) [m] along each, screw's motion rows (N, 3, m) per u.

    Rows are along x3, y3, z3; offset (N, 2): further displacement of the screw along x3, z3 [m]; force (m,): on the
    screw along u; push (N, 2): on the balls along x3, z3 [N]; drag (m,): more force along u.
    """

    groove: ScrewGroove
    angle: Array
    interference: Array
    rows: Array
    force: Array
    offset: Array
    push: Array
    drag: Array

    @property
    def section(self) -> Array:
        """The rows along x3 and z3, (N, 2, m)."""
        return self.rows[:, [0, 2]]


def load_arrays(cell: Cell) -> CellArrays:
    """The cell as the kernels take it."""
    start = cell.groove.reach * np.stack([SIGN_X * np.cos(cell.angle), SIGN_Z * np.sin(cell.angle)], axis=-1)
    start, interference, C, section, offset, push, pull = map(
        plain_array,
        (start, cell.interference, cell.groove.constants.C, cell.section, cell.offset, cell.push, cell.force + cell.drag),
    )
    return CellArrays(start, interference, C, section, offset, push, pull, float(cell.groove.reach))


def _first_guess(cell: Cell) -> tuple[Array, Array]:
    """Screw pressed along its load by about the approach of a fair share of it, balls half way."""
    total = float(np.linalg.norm(cell.force))
    count, m = cell.angle.shape[0], cell.rows.shape[2]
    if total == 0.0 or m == 0:
        return np.zeros((count, 2)), np.zeros(m)
    approach = float(np.max(cell.groove.constants.C)) * (total / count) ** (2.0 / 3.0)
    u = cell.force / total * 4.0 * (approach + max(0.0, -float(np.min(cell.interference))))
    return 0.5 * (cell.section @ u), u


def settle_load(cell: Cell, start: tuple[Array, Array] | None = None, fast: bool = True) -> Settled:
    """Loads of the cell, from positions of balls (N, 2) and screw (m,) [m] if given; forces do not depend on the start.

    Minimises sum (2/5) C^(-3/2) <approach>^(5/2) - force . u - push . p by Newton with line search, in the compiled
    kernels if ``fast``.
    """
    load = float(np.linalg.norm(cell.force) + np.linalg.norm(cell.drag) + np.sum(np.abs(cell.push)))
    p, u = _first_guess(cell) if start is None else (plain_array(start[0]).copy(), plain_array(start[1]).copy())
    settled = settle_cell(load_arrays(cell), load, p, u, contact_angles, fast)
    # from a distant start a nearly unloaded ball may creep along a flat energy
    return settled if settled.converged or start is None else settle_load(cell, None, fast)


def screw_rows(groove: ScrewGroove, azimuth: Array, free: str) -> Array:
    """Motion (N, 3, m) along x3, y3, z3 by the screw's free translations, letters of ``free`` in order.

    "z": along the axis; "x", "y": across, in fixed axes; "r": radially at every ball (a ball with its own screw).
    Raises ValueError for other letters.
    """
    if any(letter not in "xyzr" for letter in free):
        raise ValueError(f'free motions of the screw are letters of "xyzr", not "{free}"')
    turn = frame(groove, azimuth)
    out = np.zeros((*turn.shape[:2], len(free)))
    for j, letter in enumerate(free):
        out[..., j] = (1.0, 0.0, 0.0) if letter == "r" else turn[..., "xyz".index(letter)]
    return out


#: What friction may change: nothing; the balls' places (as the source, 3.4.1); those and the screw's.
Coupling = Literal["none", "ball", "ball and screw"]

#: Change of friction [of the sum of contact forces] between rounds that counts as agreement, and most rounds.
AGREED, ROUNDS = 1e-11, 100


@dataclass(frozen=True)
class BallMotion:
    """A ball's contacts (4,), directions to them (4, 3), problem and motion of least dissipation; SI.

    input_power [W]: of the body that drives, helical motion times friction; equals ``motion.loss``.
    """

    groove: ScrewGroove
    at: Contacts
    normals: Array
    problem: Problem
    motion: Motion

    @property
    def wrench(self) -> Array:
        """Friction force and moment on the ball at each contact, in x3, y3, z3: (4, 6) [N, N m]."""
        return contact_wrench(self.normals, self.motion.friction.force, self.motion.friction.moment)

    @property
    def input_power(self) -> float:
        """Power [W] that nut and screw put in by their helical motions, from friction on them."""
        return helical_power(self.groove, self.normals, self.wrench)


def contact_wrench(normals: Array, force: Array, moment: Array) -> Array:
    """Friction (..., 4, 6) in x3, y3, z3 of forces (..., 4, 2) along x, z and moments (..., 4) about y."""
    axes = contact_axes(normals)
    f = np.einsum("...r,...ri->...i", force, axes[..., :2, :])
    return np.concatenate([f, moment[..., None] * axes[..., 2, :]], axis=-1)


def helical_power(groove: ScrewGroove, normals: Array, wrench: Array) -> float:
    """Power [W] that keeps nut and screw in helical motion against friction (..., 4, 6) on the balls.

    The bodies' friction is the opposite of the balls', so that the drives push with it: velocity of the body's surface
    at the contact times force, axis times moment.
    """
    body = np.where(ON_SCREW, groove.screw_speed, groove.nut_speed)
    surface = groove.ball_radius * (normals @ groove.crosses[0].T) + groove.radius * np.array([0.0, 1.0, 0.0])
    per_speed = np.sum(surface * wrench[..., :3], axis=-1) + wrench[..., 3:] @ groove.axis
    return float(np.sum(body * per_speed))


def screw_contacts(groove: ScrewGroove, force: Array) -> Contacts:
    """Friction contacts (n,) of forces (..., 4), flattened; an unloaded one keeps a vanishing ellipse."""
    h, four = groove.constants, np.reshape(force, (-1, 4)).astype(float)
    a, b = np.empty_like(four), np.empty_like(four)
    kernels(SCREW, compiled=True).semi_axes(four, plain_array(h.C_a), plain_array(h.C_b), a, b)
    return contacts(a.ravel(), b.ravel(), four.ravel(), groove.mu)


def ball_motion(
    groove: ScrewGroove,
    force: Array,
    angle: Array,
    push: Array | None = None,
    start: Array | None = None,
    fast: bool = True,
) -> BallMotion:
    """Motion of one ball at given contact forces (4,) [N] and contact angles (4,) [rad]; two to four of them loaded.

    push (4,): other generalised forces on omega_B, omega_x, omega_y, omega_z [N m].
    """
    normals = groove.normals(angle)
    maps, drives = groove.maps(normals)
    at = screw_contacts(groove, np.asarray(force, dtype=float))
    problem = Problem(at, maps, drives, np.zeros(4) if push is None else np.asarray(push, dtype=float))
    return BallMotion(groove, at, normals, problem, least_dissipation(problem, start, fast))


def source_law(groove: ScrewGroove, sharpness: float, map_spacing: float | None = None) -> Sigmoid:
    """The source's sigmoid: k_S and the relative spin of a diagonal pair (Lin 3.20, 3.70), omega_I sin(beta) of a bearing.

    map_spacing: step in c/a of its interpolated maps; None: exact integrals.
    """
    spin = abs(groove.speed) * float(np.cos(groove.lead_angle) * np.sin(groove.contact_angle))
    return Sigmoid(sharpness, spin, map_spacing)


def ball_motion_by_root(ball: BallMotion, law: Law, start: Array | None = None) -> Motion:
    """The method of the source at the same loads, for comparison: a root of the balance under ``law`` (Lin 3.69, 3.71).

    start (4,): rolling at the nominal contact angle where None. "failed" from many starts near two-point contact.
    """
    first = np.array([ball.groove.nominal_orbit, 0.0, 0.0, 0.0]) if start is None else start
    return balance_by_root(ball.problem, law, first, fast=True)


def feedback(cell: Cell, wrench: Array, extra: Array, coupling: Coupling) -> tuple[Array, Array]:
    """Push on the balls (N, 2) and drag on the screw (m,) of friction (N, 4, 6) and other in-plane forces (N, 2)."""
    push = wrench[:, :, [0, 2]].sum(axis=1) + extra
    on_screw = wrench[:, ON_SCREW, :3].sum(axis=1)
    drag = -np.einsum("nim,ni->m", cell.rows, on_screw)
    if coupling == "none":
        return np.zeros_like(push), np.zeros_like(drag)
    return push, drag if coupling == "ball and screw" else np.zeros_like(drag)


class Mixer:
    """Anderson's acceleration of x = g(x) over the last few rounds, damped and restarted where it takes many; of one x
    (n,), or of many apart (k, n)."""

    def __init__(self, depth: int = 3, patience: int = 20) -> None:
        """Depth: differences kept; patience: rounds after which steps are halved and the history dropped."""
        self.depth, self.patience, self.rounds = depth, patience, 0
        self.x, self.r = list[Array](), list[Array]()

    def keep(self, which: Mask) -> None:
        """Go on with some of many x."""
        self.x, self.r = [x[which] for x in self.x], [r[which] for r in self.r]

    def next(self, x: Array, g: Array) -> Array:
        """Next iterate after x gave g; x may be overwritten afterwards."""
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


def hold_screw(cell: Cell, load: Settled) -> Cell:
    """The cell with its screw held where it settled: no freedoms left."""
    return replace(
        cell,
        rows=np.zeros((cell.angle.shape[0], 3, 0)),
        force=np.zeros(0),
        drag=np.zeros(0),
        offset=cell.offset + cell.section @ load.inner,
    )
