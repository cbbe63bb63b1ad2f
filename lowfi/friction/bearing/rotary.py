"""One ball of a rotary bearing with up to four contacts: loads, quasi-static motion, friction torque (Lin 3.2).

A bearing is a ball screw of zero lead whose "screw" is the inner ring. Axes at the ball: x along the bearing's axis, y
radially outward, z along the ball's path (z3, x3, y3 of a screw). Contacts in the order IL, IR, OR, OL (inner or outer
ring, left or right: towards -x or +x). The inner ring turns about x, the outer ring stands. Friction does not change the
contact loads here: they lie in the x-y plane, friction along z.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from rollbench.lowfi.friction.contact.ellipse import Contacts, contacts
from rollbench.lowfi.friction.contact.kernel_types import CellArrays
from rollbench.lowfi.friction.contact.laws import Sigmoid
from rollbench.lowfi.friction.contact.motion import (
    Motion,
    Problem,
    balance_by_root,
    balance_by_sharpening,
    least_dissipation,
)
from rollbench.lowfi.friction.contact.rings import Settled, settle_cell
from rollbench.lowfi.friction.screw.groove import ON_SCREW, SIGN_X, SIGN_Z, Constants, ScrewGroove
from rollbench.lowfi.hertz import contact_modulus, hertz_constants
from rollbench.meshes.arrays import Array
from rollbench.meshes.fields import keyed, usual

SIDES = ("IL", "IR", "OR", "OL")
#: Contacts of a screw (SL, SR, NL, NR) in the order of ``SIDES``, and back again; a screw's unknowns as those here.
AROUND, TURNS = [0, 1, 3, 2], [0, 3, 1, 2]
#: Which way the contacts lie from the ball's centre along x and y, and which belong to the inner ring.
AXIAL, RADIAL, INNER = SIGN_Z[AROUND], SIGN_X[AROUND], ON_SCREW


@keyed
@dataclass(frozen=True)
class Bearing(ScrewGroove):
    """A bearing with gothic grooves, of zero lead; its inner ring turns at ``screw_speed``.

    clearance [m]: play of the ball along each contact normal, negative for an oversize.
    """

    clearance: float = usual(0.0)

    @cached_property
    def constants(self) -> Constants:
        """Hertz constants at the nominal contact angle: exact ones by the radius along the ring (R_P -+ R_B cos beta) / cos
        beta, which is a helicoid's at no lead but for round-off; printed ones as those of a screw."""
        if self.hertz != "right":
            return super().constants
        cos, ball = np.cos(self.contact_angle), 1.0 / self.ball_radius
        inner, outer = (self.pitch_radius + s * self.ball_radius * cos for s in (-1.0, 1.0))
        modulus = contact_modulus(self.young, self.poisson, self.young, self.poisson)
        across, along = np.full(2, ball - 1.0 / self.groove_radius), np.array([ball + cos / inner, ball - cos / outer])
        h = hertz_constants(across, along, modulus)
        return Constants(*(np.repeat(values, 2) for values in (h.C, h.C_a, h.C_b)))


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
        return self.torque * self.bearing.screw_speed


def bearing_load(bearing: Bearing, force_x: float, u_y: float) -> Settled:
    """Contact loads for an axial force [N] on the inner ring and its radial displacement u_y [m] towards the ball.

    Groove centres at the nominal contact angle (Lin 3.2.2). Loads (4,), actual contact angles (4,) from the radial line,
    place of the ball (2,) along x, y and of the ring (1,) along x: the least of the energy of
    `lowfi.friction.contact.rings` over the ring's axial displacement and the ball's centre. Contact forces are unique; with
    no force and play the ball floats, and its place is where the search ends.
    """
    normals = np.stack([AXIAL * np.sin(bearing.contact_angle), RADIAL * np.cos(bearing.contact_angle)], axis=1)
    cell = CellArrays(
        start=bearing.reach * normals[None],
        interference=np.full((1, 4), -bearing.clearance),
        C=np.ascontiguousarray(bearing.constants.C),
        section=np.array([[[1.0], [0.0]]]),
        offset=np.array([[0.0, u_y]]),
        push=np.zeros((1, 2)),
        pull=np.array([force_x]),
        reach=bearing.reach,
    )
    approach = float(np.max(cell.C)) * max(abs(force_x), 1e-6) ** (2.0 / 3.0)
    way = float(np.sign(force_x)) * (approach + max(bearing.clearance, 0.0) + abs(u_y))
    start = np.array([[2.0 * way, 0.5 * u_y]]), np.array([4.0 * way])
    found = settle_cell(cell, abs(force_x), *start, lambda n: np.arctan2(np.abs(n[..., 0]), np.abs(n[..., 1])))
    return replace(found, force=found.force[0], angle=found.angle[0], ball=found.ball[0])


def contact_maps(bearing: Bearing, angles: Array) -> tuple[Array, Array]:
    """Maps (4, 3, 4) and drives (4, 3) of the ball at contact angles (4,) [rad].

    Unknowns: omega_B (orbit), omega_x, omega_y, omega_z [rad/s], relative to the turning frame. Rederived from 3.4-3.9;
    corrects the signs of 3.13 (compare F.1-F.3).
    """
    maps, drives = bearing.maps(bearing.normals(angles[AROUND]))
    return maps[AROUND][..., TURNS], drives[AROUND]


def ball_contacts(bearing: Bearing, load: Settled) -> Contacts:
    """Friction contacts of the loaded ball; an unloaded one keeps a vanishing ellipse."""
    h = bearing.constants
    cube = np.cbrt(np.maximum(load.force, max(1e-9 * float(np.max(load.force)), 1e-30)))
    return contacts(h.C_a * cube, h.C_b * cube, load.force, bearing.mu)


def motion_problem(bearing: Bearing, load: Settled, at: Contacts) -> Problem:
    """The problem of motion at given loads of two, three or four contacts and angles; omega_z is zero by symmetry."""
    maps, drives = contact_maps(bearing, load.angle)
    return Problem(at=at, maps=np.ascontiguousarray(maps[..., :3]), drives=drives, push=np.zeros(3))


def inner_torque(bearing: Bearing, load: Settled, motion: Motion) -> float:
    """Torque [N m] about the axis that keeps the inner ring turning: friction's moment on the ball at its contacts."""
    radius = bearing.pitch_radius + RADIAL * bearing.ball_radius * np.cos(load.angle)
    along = -AXIAL * np.sin(load.angle)  # of each contact's y on the axis
    moments = radius * motion.friction.force[:, 1] + along * motion.friction.moment
    return float(np.sum(moments[INNER]))


def solve_ball(bearing: Bearing, force_x: float, u_y: float, fast: bool = False) -> Solution:
    """Loads, then the motion of least dissipation with Coulomb friction."""
    load = bearing_load(bearing, force_x, u_y)
    at = ball_contacts(bearing, load)
    problem = motion_problem(bearing, load, at)
    motion = least_dissipation(problem, fast=fast)
    return Solution(bearing, load, at, problem, motion, inner_torque(bearing, load, motion))


def solve_ball_as_printed(bearing: Bearing, force_x: float, u_y: float, law: Sigmoid, fast: bool = False) -> Solution:
    """The source's method, faults included: Table B.1's Hertz constants, sigmoid, root of 3.19, torque 3.21.

    The root is searched from the motion of least dissipation, then if need be with a sigmoid that grows ever sharper.
    """
    least = solve_ball(replace(bearing, hertz="as printed"), force_x, u_y, fast)
    motion = balance_by_root(least.problem, law, least.motion.q, fast)
    if motion.status != "exact":
        motion = balance_by_sharpening(least.problem, law, least.motion.q, fast)
    return replace(least, motion=motion, torque=motion.loss / bearing.screw_speed)


def sweep(bearing: Bearing, force_x: float, u_y: Array, law: Sigmoid | None = None) -> list[Solution]:
    """Solutions over the radial displacement u_y (n,) [m] (Figure 3.7), each on its own.

    law: the source's own way with that law, as ``solve_ball_as_printed``; without, least dissipation.
    """
    if law is None:
        return [solve_ball(bearing, force_x, float(u), fast=True) for u in u_y]
    return [solve_ball_as_printed(bearing, force_x, float(u), law, fast=True) for u in u_y]
