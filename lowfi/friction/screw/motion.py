"""Balls between a rigid screw and a rigid nut: contact loads, quasi-static motion, effect of friction on the loads.

The model is that of section 3.4.1 of Lin's thesis. The motion of each ball is that of least dissipation. The friction of a
ball in the plane of its groove section (the helix turns nut and screw against each other about y3) changes the contact
loads through the ball's equilibrium: ``coupled.search_coupled_chain`` solves loads and friction in turn.

Loads are the minimum of a convex energy over all positions. Each ball moves in the plane of its groove section (x3 radial,
z3 binormal), the screw by its free motions u, the nut is fixed. Friction in this plane is given by forces on balls and
screw that do not change while the loads are computed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from rollbench.lowfi.friction.contact import equilibrium
from rollbench.lowfi.friction.contact.laws import EllipticalContacts, SigmoidLaw, contacts_from_values
from rollbench.lowfi.friction.contact.normal_force import BallContactArrays
from rollbench.lowfi.friction.screw import groove as screw_groove
from rollbench.lowfi.statics.settle import contact_angles
from rollbench.lowfi.together import Search, solve_alone
from rollbench.meshes.arrays import Array, Mask


def balls_without_friction(
    groove: screw_groove.ScrewGroove, angle: Array, interference: Array, rows: Array, force: Array
) -> BallsBetweenGrooves:
    """Return N balls between screw and nut under an external force on the screw, with friction forces of zero.

    ``groove``: grooves of screw and nut; ``angle``: contact angles of the unloaded balls ``(N, 4)`` [rad];
    ``interference``: interference of ball and groove at each contact, negative for clearance ``(N, 4)`` [m]; ``rows``:
    displacement of the screw along x3 (radial), y3 (along the track), z3 (binormal) at each ball per unit of each of
    the m motions in which the screw is free ``(N, 3, m)``; ``force``: force on the screw along these motions ``(m,)``
    [N].
    """
    none = np.zeros((angle.shape[0], 2))
    return BallsBetweenGrooves(groove, angle, interference, rows, force, none, none, np.zeros(force.size))


@dataclass(frozen=True)
class BallsBetweenGrooves:
    """N balls between screw and nut with the forces on balls and screw; the screw is free in m motions u."""

    #: Grooves of screw and nut, with the speeds of both bodies.
    groove: screw_groove.ScrewGroove
    #: Contact angles of the unloaded balls ``(N, 4)`` [rad].
    angle: Array
    #: Interference of ball and groove at each contact before any displacement, negative for clearance ``(N, 4)`` [m].
    interference: Array
    #: Displacement of the screw along x3, y3, z3 at each ball per unit of each motion u ``(N, 3, m)``.
    screw_displacement_maps: Array
    #: External force on the screw along each motion u ``(m,)`` [N].
    external_screw_force: Array
    #: Prescribed displacement of the screw along x3, z3 at each ball, in addition to its free motions u ``(N, 2)`` [m].
    given_screw_displacement: Array
    #: Forces other than contact loads on the balls along x3, z3, such as friction ``(N, 2)`` [N].
    ball_friction_forces: Array
    #: Force of friction on the screw along each motion u ``(m,)`` [N].
    screw_friction_forces: Array

    @property
    def section_displacement_maps(self) -> Array:
        """Displacement of the screw along x3 (radial), z3 (binormal) at each ball per unit of each motion ``(N, 2, m)``."""
        return self.screw_displacement_maps[:, [0, 2]]


def arrays_for_contact_loads(cell: BallsBetweenGrooves) -> BallContactArrays:
    """Return geometry, stiffness and applied forces of the balls in ``cell`` as arrays."""
    start = cell.groove.groove_ball_centre_distance * np.stack(
        [screw_groove.SIGN_X * np.cos(cell.angle), screw_groove.SIGN_Z * np.sin(cell.angle)], axis=-1
    )
    return BallContactArrays(
        groove_to_ball_vectors=start,
        interference=cell.interference,
        C=cell.groove.contact_hertz_constants.C,
        inner_displacement_maps=cell.section_displacement_maps,
        given_inner_displacement=cell.given_screw_displacement,
        ball_forces=cell.ball_friction_forces,
        inner_body_forces=cell.external_screw_force + cell.screw_friction_forces,
        groove_ball_centre_distance=cell.groove.groove_ball_centre_distance,
    )


def starting_displacements(cell: BallsBetweenGrooves) -> tuple[Array, Array]:
    """Return displacements to start the search for contact loads: of N balls ``(N, 2)``, then of the screw ``(m,)`` [m].

    The screw moves along its load by four times the approach under equal loads of all balls, plus the clearance, and
    the balls move half as far. ``cell``: the balls and the load on the screw.
    """
    total = float(np.linalg.norm(cell.external_screw_force))
    count, m = cell.angle.shape[0], cell.screw_displacement_maps.shape[2]
    if total == 0.0 or m == 0:
        return np.zeros((count, 2)), np.zeros(m)
    approach = float(np.max(cell.groove.contact_hertz_constants.C)) * (total / count) ** (2.0 / 3.0)
    u = cell.external_screw_force / total * 4.0 * (approach + max(0.0, -float(np.min(cell.interference))))
    return 0.5 * (cell.section_displacement_maps @ u), u


def search_screw_contact_loads(
    cell: BallsBetweenGrooves, start: tuple[Array, Array] | None = None
) -> Search[equilibrium.ContactLoadSolution]:
    """Return the contact loads of balls between screw and nut, in balance with the forces on balls and screw.

    The loads are found by Newton's method with line search at the minimum of sum (2/5) C^(-3/2) <approach>^(5/2) -
    (force + drag) . u - push . p over the displacements u of the screw and p of the balls. C is the Hertz constant of a
    contact, <approach> the approach where positive, and force, drag and push stand for ``external_screw_force``,
    ``screw_friction_forces`` and ``ball_friction_forces`` of ``cell``. The loads do not depend on the start.

    Parameters
    ----------
    cell
        Balls between screw and nut with the forces on them.
    start
        Displacements of the balls ``(N, 2)`` and of the screw ``(m,)`` [m] from which the search begins; None for a start
        estimated from the load.
    """
    load = float(
        np.linalg.norm(cell.external_screw_force)
        + np.linalg.norm(cell.screw_friction_forces)
        + np.sum(np.abs(cell.ball_friction_forces))
    )
    begin = starting_displacements(cell) if start is None else start
    settled: equilibrium.ContactLoadSolution = yield equilibrium.ContactLoadsTask(
        arrays_for_contact_loads(cell), load, *begin, contact_angles
    )
    # from a distant start a nearly unloaded ball may creep along a flat energy
    return settled if settled.converged or start is None else (yield from search_screw_contact_loads(cell))


def solve_screw_contact_loads(
    cell: BallsBetweenGrooves, start: tuple[Array, Array] | None = None
) -> equilibrium.ContactLoadSolution:
    """Return the contact loads of balls between screw and nut; arguments: see `search_screw_contact_loads`."""
    return solve_alone(search_screw_contact_loads(cell, start))


def screw_displacement_maps(groove: screw_groove.ScrewGroove, azimuth: Array, free: str) -> Array:
    """Return the displacement of the screw at each of N balls per unit of its m translations ``(N, 3, m)``.

    The displacement is along x3 (radial), y3 (along the track), z3 (binormal) of each ball. ``groove``: the helix;
    ``azimuth``: azimuths of the balls ``(N,)`` [rad]; ``free``: one letter for each translation in which the screw is
    free, in their order: "z" along the axis, "x" and "y" across it, in fixed axes, "r" radially at every ball (as if
    each ball had a screw of its own). Raises ValueError for other letters.
    """
    if any(letter not in "xyzr" for letter in free):
        raise ValueError(
            '`free`, the directions in which the screw is free to move, must be letters of "xyzr" (x, y: across the axis; '
            f'z: along it; r: radial at every ball), got "{free}"'
        )
    turn = screw_groove.section_axes(groove, azimuth)
    out = np.zeros((*turn.shape[:2], len(free)))
    for j, letter in enumerate(free):
        out[..., j] = (1.0, 0.0, 0.0) if letter == "r" else turn[..., "xyz".index(letter)]
    return out


#: What friction may change: nothing ("none"); the contact loads of the balls ("ball", section 3.4.1 of Lin's thesis); also
#: the position of the screw ("ball and screw").
Coupling = Literal["none", "ball", "ball and screw"]

#: Change of the friction forces from one round to the next, divided by the sum of the contact loads, up to which contact
#: loads and friction agree; largest number of rounds.
AGREED, ROUNDS = 1e-11, 100


@dataclass(frozen=True)
class BallMotion:
    """Motion of one ball of a screw under given contact loads, with the friction on it."""

    #: Grooves of screw and nut, with the speeds of both bodies.
    groove: screw_groove.ScrewGroove
    #: Ellipses, loads and coefficients of friction of the ball's contacts ``(4,)``.
    contacts: EllipticalContacts
    #: Directions from the ball's centre to the contacts in x3, y3, z3 ``(4, 3)``.
    normals: Array
    #: Contacts, kinematics and forces that determine the motion.
    problem: equilibrium.BodyMotionProblem
    #: Motion of the ball with least dissipation, and the friction on it.
    motion: equilibrium.BodyMotion

    @property
    def wrench(self) -> Array:
        """Force (first three components), then moment of friction on the ball at each contact ``(4, 6)`` [N, N m].

        Components are those along x3 (radial), y3 (along the track), z3 (binormal).
        """
        return friction_wrench_at_contacts(self.normals, self.motion.friction.force, self.motion.friction.moment)

    @property
    def input_power(self) -> float:
        """Power [W] that the helical motions of nut and screw supply against friction; equals ``motion.loss``."""
        return power_of_helical_motion(self.groove, self.normals, self.wrench)


def friction_wrench_at_contacts(normals: Array, force: Array, moment: Array) -> Array:
    """Return force, then moment of friction on balls at each contact, along x3, y3, z3 each ``(..., 4, 6)`` [N, N m].

    x3 is radial, y3 along the track, z3 the binormal. ``normals``: directions from the ball's centre to the contacts in
    these axes ``(..., 4, 3)``; ``force``: friction at each contact across the groove and along the path ``(..., 4, 2)``
    [N]; ``moment``: friction moment about the contact normal into the ball ``(..., 4)`` [N m].
    """
    axes = screw_groove.contact_axes(normals)
    f = np.einsum("...r,...ri->...i", force, axes[..., :2, :])
    return np.concatenate([f, moment[..., None] * axes[..., 2, :]], axis=-1)


def power_of_helical_motion(groove: screw_groove.ScrewGroove, normals: Array, wrench: Array) -> float:
    """Return the power [W] that keeps nut and screw in helical motion against friction.

    The power is summed over the contacts: velocity of the surface of screw or nut times the force, plus angular
    velocity of screw or nut times the moment, because screw and nut push with the friction on the balls. ``groove``:
    grooves with the speeds of screw and nut; ``normals``: directions from the ball's centre to the contacts in x3
    (radial), y3 (along the track), z3 (binormal) ``(..., 4, 3)``; ``wrench``: force and moment of friction on the balls
    in the same axes ``(..., 4, 6)`` [N, N m].
    """
    body = np.where(screw_groove.ON_SCREW, groove.screw_speed, groove.nut_speed)
    along_path = groove.radius * np.array([0.0, 1.0, 0.0])
    surface = groove.ball_radius * (normals @ groove.cross_product_matrices[0].T) + along_path
    per_speed = np.sum(surface * wrench[..., :3], axis=-1) + wrench[..., 3:] @ groove.screw_axis_direction
    return float(np.sum(body * per_speed))


def contact_ellipses_of_screw(groove: screw_groove.ScrewGroove, force: Array) -> EllipticalContacts:
    """Return ellipses, loads and friction coefficients of all n contacts of several balls of a screw, as arrays ``(n,)``.

    A contact without load has an ellipse of vanishing size.

    Parameters
    ----------
    groove
        Grooves and balls of a screw.
    force
        Contact forces, ``(..., 4)`` [N].
    """
    h, four = groove.contact_hertz_constants, np.reshape(force, (-1, 4)).astype(float)
    root = np.maximum(four, max(1e-9 * float(four.max()), 1e-30)) ** (1.0 / 3.0)
    return contacts_from_values((h.C_a * root).ravel(), (h.C_b * root).ravel(), four.ravel(), groove.mu)


def solve_ball_motion(
    groove: screw_groove.ScrewGroove, force: Array, angle: Array, push: Array | None = None, start: Array | None = None
) -> BallMotion:
    """Return the motion of least dissipation of one ball under given contact loads, with its friction.

    Parameters
    ----------
    groove
        Grooves of screw and nut with their speeds.
    force
        Contact forces ``(4,)`` [N], two to four of them loaded.
    angle
        Contact angles ``(4,)`` [rad].
    push
        Generalised forces other than friction along omega_B, omega_x, omega_y, omega_z ``(4,)`` [N m]; None if there
        are none.
    start
        Motion omega_B, omega_x, omega_y, omega_z from which the search begins ``(4,)`` [rad/s]; None to begin near pure
        rolling.
    """
    of_one = (None if values is None else np.asarray(values, dtype=float)[None] for values in (push, start))
    return solve_ball_motions(groove, np.asarray(force, dtype=float)[None], np.asarray(angle)[None], *of_one)[0]


def solve_ball_motions(
    groove: screw_groove.ScrewGroove, force: Array, angle: Array, push: Array | None = None, start: Array | None = None
) -> list[BallMotion]:
    """Return the motions of least dissipation of N independent balls; all arrays as in `solve_ball_motion`, ``(N, 4)``."""
    normals, pushes = groove.normals(angle), np.zeros(force.shape) if push is None else push
    ellipses = (contact_ellipses_of_screw(groove, of_ball) for of_ball in force)
    of_each = zip(ellipses, *groove.contact_kinematics(normals), pushes, strict=True)
    problems = [equilibrium.BodyMotionProblem(*values) for values in of_each]
    motions = equilibrium.least_dissipations(problems, start)
    return [
        BallMotion(groove, problem.contacts, direction, problem, motion)
        for problem, direction, motion in zip(problems, normals, motions, strict=True)
    ]


def lin_sigmoid_law(groove: screw_groove.ScrewGroove, sharpness: float, map_spacing: float | None = None) -> SigmoidLaw:
    """Return Lin's sigmoid friction law for the contacts of a screw.

    The reference spin of the sigmoid is the relative spin of two opposite contacts, which for a bearing is omega_I
    sin(beta) with the speed omega_I of the inner ring and the contact angle beta.

    Parameters
    ----------
    groove
        Grooves of screw and nut with their speeds.
    sharpness
        Sharpness k_S of the sigmoid.
    map_spacing
        Step in c/a of Lin's tables of friction forces, between whose values he interpolates (c: distance of the centre of
        rotation from the centre of the contact ellipse along its semi-axis a); None for exact integrals.

    References
    ----------
    Lin (2019), 3.20 and 3.70.
    """
    spin = abs(groove.speed) * float(np.cos(groove.lead_angle) * np.sin(groove.contact_angle))
    return SigmoidLaw(sharpness, spin, map_spacing)


def friction_on_balls_and_screw(
    cell: BallsBetweenGrooves, wrench: Array, neighbour_forces: Array, coupling: Coupling
) -> tuple[Array, Array]:
    """Return the forces of friction and of neighbours that change the contact loads: on the balls, then on the screw.

    The forces on the balls are along x3 (radial) and z3 (binormal) ``(N, 2)`` [N], those on the screw along its m
    motions ``(m,)`` [N]. ``cell``: balls between screw and nut; ``wrench``: force and moment of friction on the balls
    at each contact in x3, y3, z3 ``(N, 4, 6)`` [N, N m]; ``neighbour_forces``: forces of neighbours on the balls along
    x3, z3 ``(N, 2)`` [N]; ``coupling``: what friction may change. Forces on balls or screw that friction may not move
    are zero.
    """
    push = wrench[:, :, [0, 2]].sum(axis=1) + neighbour_forces
    on_screw = wrench[:, screw_groove.ON_SCREW, :3].sum(axis=1)
    drag = -np.einsum("nim,ni->m", cell.screw_displacement_maps, on_screw)
    if coupling == "none":
        return np.zeros_like(push), np.zeros_like(drag)
    return push, drag if coupling == "ball and screw" else np.zeros_like(drag)


class AndersonAcceleration:
    """Anderson acceleration of a fixed-point iteration x = g(x), from the history of the last few rounds.

    After many rounds without convergence the steps are damped and the history is dropped.
    """

    def __init__(self, depth: int = 3, patience: int = 20) -> None:
        """Begin an iteration without a history of earlier rounds.

        ``depth``: number of differences between successive rounds that are used; ``patience``: number of rounds after
        which, each time, the steps are halved and the history is dropped.
        """
        self.depth, self.patience, self.rounds = depth, patience, 0
        self.x, self.r = list[Array](), list[Array]()

    def keep_vectors(self, which: Mask) -> None:
        """Keep some of the vectors x that are iterated together, and drop the other vectors with their history.

        ``which``: whether to keep each vector.
        """
        self.x, self.r = [x[which] for x in self.x], [r[which] for r in self.r]

    def next_iterate(self, x: Array, g: Array) -> Array:
        """Return the next iterate of the iteration x = g(x).

        ``x``: present iterate; ``g``: value g(x) for it. Both arrays may be overwritten afterwards.
        """
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


def balls_with_fixed_screw(cell: BallsBetweenGrooves, load: equilibrium.ContactLoadSolution) -> BallsBetweenGrooves:
    """Return the balls of ``cell`` with the screw fixed at the displacement that it has in the solution ``load``.

    The screw then has no free motions, so that the arrays of forces on it are empty.
    """
    moved = cell.section_displacement_maps @ load.inner_body_displacements
    return replace(
        cell,
        screw_displacement_maps=np.zeros((cell.angle.shape[0], 3, 0)),
        external_screw_force=np.zeros(0),
        screw_friction_forces=np.zeros(0),
        given_screw_displacement=cell.given_screw_displacement + moved,
    )
