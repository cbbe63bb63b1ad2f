"""One ball of a rotary bearing with up to four contacts: loads, quasi-static motion, friction torque (Lin 3.2).

Axes at the ball: x along the bearing's axis, y radially outward, z along the ball's path. Contacts in the order IL, IR,
OR, OL (inner or outer ring, left or right: towards -x or +x). The inner ring turns about x, the outer ring stands.
Friction does not change the contact loads here: they lie in the x-y plane, friction along z.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from rollbench.lowfi.friction.contact.ellipse import Contacts, contacts
from rollbench.lowfi.friction.contact.laws import Sigmoid
from rollbench.lowfi.friction.contact.motion import (
    Motion,
    Problem,
    balance_by_root,
    balance_by_sharpening,
    least_dissipation,
)
from rollbench.lowfi.friction.contact.records import CellArrays
from rollbench.lowfi.friction.contact.rings import Settled, settle_cell
from rollbench.lowfi.hertz import contact_modulus, hertz_constants, printed_hertz
from rollbench.meshes.arrays import Array

SIDES = ("IL", "IR", "OR", "OL")
#: Which way the contacts lie from the ball's centre along x and y, and which belong to the inner ring.
SIGN_X, SIGN_Y = np.array([-1.0, 1.0, 1.0, -1.0]), np.array([-1.0, -1.0, 1.0, 1.0])
INNER = np.array([True, True, False, False])
Mode = Literal["right", "as printed"]


@dataclass(frozen=True)
class Bearing:
    """A bearing with gothic grooves: lengths [m], angle [rad], Young's modulus [Pa], inner ring's speed [rad/s].

    groove_radius > ball_radius; clearance [m]: play of the ball along each contact normal, negative for an oversize.
    """

    ball_radius: float
    groove_radius: float
    pitch_radius: float
    contact_angle: float
    young: float
    poisson: float
    mu: float
    speed: float
    clearance: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what the model cannot treat."""
        if not 0.0 < self.ball_radius < self.groove_radius or self.pitch_radius <= self.groove_radius:
            raise ValueError("need 0 < ball_radius < groove_radius < pitch_radius")
        if not 0.0 < self.contact_angle < 0.5 * np.pi:
            raise ValueError("contact_angle must lie between 0 and pi/2")
        if self.young <= 0.0 or not 0.0 <= self.poisson < 0.5 or self.mu < 0.0:
            raise ValueError("need young > 0, 0 <= poisson < 0.5 and mu >= 0")


@dataclass(frozen=True)
class GrooveHertz:
    """Hertz constants of the four contacts (4,): approach = C F^(2/3), semi-axes = C_a F^(1/3), C_b F^(1/3)."""

    C: Array
    C_a: Array
    C_b: Array


@dataclass(frozen=True)
class Solution:
    """A ball under load: loads, contacts, the problem of motion, its solution, torque on the inner ring [N m]."""

    bearing: Bearing
    load: Settled
    at: Contacts
    problem: Problem
    motion: Motion
    torque: float

    @property
    def input_power(self) -> float:
        """Power [W] that turns the inner ring, torque times speed; equals the loss where friction balances."""
        return self.torque * self.bearing.speed


def groove_hertz(bearing: Bearing, mode: Mode = "right") -> GrooveHertz:
    """Constants at the nominal contact angle, across the groove and along the ring.

    "right": exact Hertz, radius along the ring (R_P -+ R_B cos beta) / cos beta. "as printed": F_1 = 1 and the
    eigenvalues of the second fundamental form alone, which make that radius (R_P -+ R_B cos beta) cos beta.
    """
    cos = np.cos(bearing.contact_angle)
    inner, outer = (bearing.pitch_radius + s * bearing.ball_radius * cos for s in (-1.0, 1.0))
    modulus = contact_modulus(bearing.young, bearing.poisson, bearing.young, bearing.poisson)
    across, ball = 1.0 / bearing.ball_radius - 1.0 / bearing.groove_radius, 1.0 / bearing.ball_radius
    if mode == "as printed":
        two = [
            printed_hertz(bearing.ball_radius, (-bearing.groove_radius, r), modulus) for r in (inner * cos, -outer * cos)
        ]
        table = np.array([[t.C, t.C_a, t.C_b] for t in two])
    else:
        along = np.array([ball + cos / inner, ball - cos / outer])
        h = hertz_constants(np.full(2, across), along, modulus)
        table = np.stack([h.C, h.C_a, h.C_b], axis=1)
    rows = table[[0, 0, 1, 1]]
    return GrooveHertz(C=rows[:, 0], C_a=rows[:, 1], C_b=rows[:, 2])


def bearing_load(bearing: Bearing, force_x: float, u_y: float, mode: Mode = "right") -> Settled:
    """Contact loads for an axial force [N] on the inner ring and its radial displacement u_y [m] towards the ball.

    Groove centres at the nominal contact angle (Lin 3.2.2). Loads (4,), actual contact angles (4,) from the radial line,
    place of the ball (2,) along x, y and of the ring (1,) along x. A ring is a screw of zero lead: the least of the energy
    of `lowfi.friction.contact.rings` over its axial displacement and the ball's centre. Contact forces are unique; with
    no force and play the ball floats, and its place is where the search ends.
    """
    normals = np.stack([SIGN_X * np.sin(bearing.contact_angle), SIGN_Y * np.cos(bearing.contact_angle)], axis=1)
    reach, C = bearing.groove_radius - bearing.ball_radius, groove_hertz(bearing, mode).C
    cell = CellArrays(
        start=np.ascontiguousarray(reach * normals[None]),
        interference=np.full((1, 4), -bearing.clearance),
        C=np.ascontiguousarray(C),
        section=np.array([[[1.0], [0.0]]]),
        offset=np.array([[0.0, u_y]]),
        push=np.zeros((1, 2)),
        pull=np.array([force_x]),
        reach=reach,
    )
    typical = float(np.max(C)) * max(abs(force_x), 1e-6) ** (2.0 / 3.0) + max(bearing.clearance, 0.0) + abs(u_y)
    way = typical * float(np.sign(force_x))
    start = np.array([[2.0 * way, 0.5 * u_y]]), np.array([4.0 * way])
    found = settle_cell(cell, abs(force_x), *start, lambda n: np.arctan2(np.abs(n[..., 0]), np.abs(n[..., 1])))
    return replace(found, force=found.force[0], angle=found.angle[0], ball=found.ball[0])


def contact_maps(bearing: Bearing, angles: Array, free_z: bool = False) -> tuple[Array, Array]:
    """Maps (4, 3, n) and drives (4, 3) of the ball at contact angles (4,) [rad].

    Unknowns: omega_B (orbit), omega_x, omega_y [rad/s], relative to the turning frame, and omega_z if ``free_z`` (zero
    in the least by symmetry). Rederived from 3.4-3.9; corrects the signs of 3.13 (compare F.1-F.3).
    """
    n = 4 if free_z else 3
    maps, drives = np.zeros((4, 3, n)), np.zeros((4, 3))
    for i in range(4):
        normal = np.array([SIGN_X[i] * np.sin(angles[i]), SIGN_Y[i] * np.cos(angles[i]), 0.0])
        arm, y = bearing.ball_radius * normal, -normal
        axes = np.stack([np.cross(y, [0.0, 0.0, 1.0]), [0.0, 0.0, 1.0], y])
        for j in range(n):
            turn = np.eye(3)[max(0, j - 1)]
            move = np.array([0.0, 0.0, bearing.pitch_radius if j == 0 else 0.0])
            slide = np.cross(turn, arm) + move
            maps[i, :, j] = axes[0] @ slide, axes[1] @ slide, axes[2] @ turn
        if INNER[i]:
            drives[i] = -bearing.speed * maps[i, :, 0]
    return maps, drives


def ball_contacts(bearing: Bearing, load: Settled, mode: Mode = "right") -> Contacts:
    """Friction contacts of the loaded ball; an unloaded one keeps a vanishing ellipse."""
    h = groove_hertz(bearing, mode)
    cube = np.cbrt(np.maximum(load.force, max(1e-9 * float(np.max(load.force)), 1e-30)))
    return contacts(h.C_a * cube, h.C_b * cube, load.force, bearing.mu)


def motion_problem(bearing: Bearing, load: Settled, at: Contacts) -> Problem:
    """The problem of motion at given loads and angles; works for two, three or four loaded contacts."""
    maps, drives = contact_maps(bearing, load.angle)
    return Problem(at=at, maps=maps, drives=drives, push=np.zeros(maps.shape[2]))


def inner_torque(bearing: Bearing, load: Settled, motion: Motion) -> float:
    """Torque [N m] about the axis that keeps the inner ring turning: friction's moment on the ball at its contacts."""
    radius = bearing.pitch_radius + SIGN_Y * bearing.ball_radius * np.cos(load.angle)
    along = -SIGN_X * np.sin(load.angle)  # of each contact's y on the axis
    moments = radius * motion.friction.force[:, 1] + along * motion.friction.moment
    return float(np.sum(moments[INNER]))


def source_law(bearing: Bearing, sharpness: float, map_spacing: float | None) -> Sigmoid:
    """The source's sigmoid with its k_S and reference spin omega_I sin(beta) (Lin 3.20).

    map_spacing: step in c/a of its interpolated maps; None: exact integrals.
    """
    return Sigmoid(sharpness, abs(bearing.speed) * float(np.sin(bearing.contact_angle)), map_spacing)


def solve_ball(bearing: Bearing, force_x: float, u_y: float, hertz: Mode = "right", fast: bool = False) -> Solution:
    """Loads, then the motion of least dissipation with Coulomb friction.

    hertz: constants of the loads and ellipses; "as printed" shows what the motion alone changes against the source.
    """
    load = bearing_load(bearing, force_x, u_y, hertz)
    at = ball_contacts(bearing, load, hertz)
    problem = motion_problem(bearing, load, at)
    motion = least_dissipation(problem, fast=fast)
    return Solution(bearing, load, at, problem, motion, inner_torque(bearing, load, motion))


def solve_ball_as_printed(bearing: Bearing, force_x: float, u_y: float, law: Sigmoid, fast: bool = False) -> Solution:
    """The source's method, faults included: Table B.1's Hertz constants, sigmoid, root of 3.19, torque 3.21.

    The root is searched from the motion of least dissipation, then if need be with a sigmoid that grows ever sharper.
    """
    load = bearing_load(bearing, force_x, u_y, "as printed")
    at = ball_contacts(bearing, load, "as printed")
    problem = motion_problem(bearing, load, at)
    first = least_dissipation(problem, fast=fast).q
    motion = balance_by_root(problem, law, first, fast)
    if motion.status != "exact":
        motion = balance_by_sharpening(problem, law, first, fast)
    return Solution(bearing, load, at, problem, motion, motion.loss / bearing.speed)


@dataclass(frozen=True)
class Sweep:
    """Series over the radial displacement u_y (n,) [m]: loads (n, 4) [N], losses (n, 4) [W], torque (n,) [N m].

    motion (n, 3): omega_B, omega_x, omega_y [rad/s]; status: one word each.
    """

    u_y: Array
    load: Array
    loss: Array
    torque: Array
    motion: Array
    status: tuple[str, ...] = field(default=())


def sweep(bearing: Bearing, force_x: float, u_y: Array, law: Sigmoid | None = None) -> Sweep:
    """Sum of contact forces and friction torque against u_y (Figure 3.7), each point solved on its own.

    law: the source's own way with that law, as ``solve_ball_as_printed``; without, least dissipation.
    """
    solutions = [
        solve_ball(bearing, force_x, float(u), fast=True)
        if law is None
        else solve_ball_as_printed(bearing, force_x, float(u), law, fast=True)
        for u in u_y
    ]
    return Sweep(
        u_y=np.asarray(u_y, dtype=float),
        load=np.array([s.load.force for s in solutions]),
        loss=np.array([s.motion.friction.loss for s in solutions]),
        torque=np.array([s.torque for s in solutions]),
        motion=np.array([s.motion.q for s in solutions]),
        status=tuple(s.motion.status for s in solutions),
    )
