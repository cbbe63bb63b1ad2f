"""Effect of friction on the position of a ball: new contact loads and angles at the same axial load of every ball.

Friction across the groove pushes each ball sideways until its contacts resist, at other contact angles or on a third flank
(section 3.4.1 of Lin's thesis). For each ball separately, the ball moves in its groove section and the screw along its axis
until the axial load of this ball, friction included, is that of the static model. The distribution of the axial load over
the balls therefore remains that of the static model.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from rollbench.lowfi.friction.contact.equilibrium import solve_contact_loads_of_each_ball
from rollbench.lowfi.friction.screw.groove import ON_SCREW
from rollbench.lowfi.friction.screw.motion import AndersonAcceleration
from rollbench.lowfi.friction.whole.contacts import StaticContacts, contacts_with_loads
from rollbench.lowfi.friction.whole.losses import BallFriction, ball_friction
from rollbench.lowfi.statics.settle import contact_angles
from rollbench.meshes.arrays import Array, Index, Mask
from rollbench.meshes.errors import GeometryWithErrors
from rollbench.meshes.parts import Friction, Scene
from rollbench.meshes.parts import Motion as Drive

#: Difference between the friction in a ball's contacts and the friction that its contact loads balance, as a fraction of
#: the sum of these loads: tolerance that the iteration aims at, and largest difference that is accepted.
AGREED, ACCEPTED = 1e-7, 1e-4
#: Number of rounds of the iteration between contact loads and friction, after which a ball is solved by Newton's method.
#: Where a lightly loaded contact is about to slip or to stick, friction changes its direction at the smallest change of
#: position, and the iteration oscillates.
ROUNDS = 40
#: Newton's method for a single ball: step of the finite differences and length of the last step, as fractions of the ball's
#: contact loads; largest number of evaluations.
DIFFERENCE, SOLVED, TRIALS = 1e-8, 1e-12, 400
#: Force that displaces a ball at the start of the search for a second equilibrium, and least difference of the contact
#: forces of two equilibria, as fractions of the ball's largest contact force.
DISPLACED, ANOTHER = 3.0, 1e-3
#: Coefficient of friction from which on a second state of a ball, jammed between its grooves, was observed.
JAMMED = 0.3


@dataclass(frozen=True)
class PositionsInGrooves:
    """Positions of N balls relative to their four grooves in the static state without friction."""

    #: Vector from the centre of each groove's profile to the ball's centre, along x3 and z3 ``(N, 4, 2)`` [m].
    groove_to_ball_vectors: Array
    #: Distance of the ball's centre from the centre of each groove's profile where ball and groove just touch ``(N, 4)``
    #: [m].
    touching_distance: Array
    #: Hertz constants C of the approach C F^(2/3) at a contact force F ``(N, 4)`` [m/N^(2/3)].
    C: Array
    #: Direction of the screw's axis in the axes x3, y3, z3 of a ball's section ``(3,)``.
    screw_axis_direction: Array


def positions_in_grooves(contacts: StaticContacts, C: Array, reach: Array, centre: Array) -> PositionsInGrooves:
    """Return the positions of N balls relative to their grooves without friction, from their contact loads and angles.

    A flank without contact is assumed to move with the other flank of the same body. A ball without load keeps its
    nominal position. ``contacts``: contacts of the balls; ``C``: Hertz constants of the approach C F^(2/3) ``(N, 4)``
    [m/N^(2/3)]; ``reach``: distance of the ball's centre from the centre of each groove's profile where ball and groove
    just touch ``(N, 4)`` [m]; ``centre``: centres of the profiles along x3 (radial) and z3 (binormal) ``(N, 4, 2)``
    [m].
    """
    squeeze = C * np.cbrt(contacts.force) ** 2
    away = (reach + squeeze)[..., None] * contacts.normals[..., [0, 2]]
    other = [1, 0, 3, 2]
    by_other = away[:, other] + centre[:, other] - centre
    free = (contacts.force == 0.0) & (contacts.force[:, other] > 0.0)
    away = np.where(free[..., None], by_other, away)
    reach = np.where(free, np.maximum(reach, np.hypot(away[..., 0], away[..., 1])), reach)
    return PositionsInGrooves(away, reach, C, np.asarray(contacts.section_axes[0, :, 2]))


def positions_in_grooves_with_errors(contacts: StaticContacts, drawn: GeometryWithErrors, C: Array) -> PositionsInGrooves:
    """Return the positions of N balls relative to grooves with geometric errors.

    ``contacts``: contacts of the balls; ``drawn``: radii, groove centres and groove profiles with random errors; ``C``:
    Hertz constants of the approach C F^(2/3) ``(N, 4)`` [m/N^(2/3)].
    """
    inward = np.zeros_like(contacts.angle)
    for s, row in enumerate(drawn.profile_coefficients):
        inward[:, s] = np.polynomial.polynomial.polyval(contacts.angle[:, s], row) if row.size else 0.0
    reach = drawn.groove_radii[None, :] - inward - drawn.ball_radii[:, None]
    return positions_in_grooves(contacts, C, reach, drawn.groove_centres)


def _unbalanced_forces(force: Array, normal: Array, along: Array, applied: Array) -> Array:
    """Return the unbalanced forces on each ball and on the screw, contact forces less applied forces ``(N, 3)`` [N].

    The three values are the forces on the ball along x3 (radial) and z3 (binormal), and on the screw along its axis.
    ``force``: contact forces ``(N, 4)``; ``normal``: unit vectors from each ball's centre to its contacts in x3, z3
    ``(N, 4, 2)``; ``along``: direction of the screw's axis in x3, z3 ``(2,)``; ``applied``: applied forces, in the
    order of the result ``(N, 3)`` [N].
    """
    push = force[..., None] * normal
    screw = -np.einsum("nsi,i->n", push[:, ON_SCREW], along)
    return np.column_stack([push.sum(axis=1), screw]) - applied


@dataclass(frozen=True)
class FrictionEquilibrium:
    """Contacts of N balls whose contact loads are in equilibrium with the friction at these contacts.

    A ball fails if its forces, or the axial load that it carried without friction, are out of balance by more than
    ``ACCEPTED`` times the sum of its contact loads.
    """

    #: Contacts of the balls, with the loads and angles under friction.
    contacts: StaticContacts
    #: Motion and friction of the balls in these contacts.
    friction: BallFriction
    #: Whether each ball failed to reach an equilibrium ``(N,)``.
    failed_balls: Mask
    #: Number of rounds of the iteration between contact loads and friction.
    rounds: int
    #: Largest ratio, over all balls, of the unbalanced force on a ball to the sum of its contact loads.
    largest_imbalance_ratio: float
    #: Friction forces, in balance with the contact loads: on each ball along x3 (radial) and z3 (binormal), and on the
    #: screw along its axis ``(N, 3)`` [N].
    friction_on_balls_and_screw: Array


def solve_friction_equilibrium(
    scene: Scene,
    static_contacts: StaticContacts,
    positions: PositionsInGrooves,
    friction: Friction,
    drive: Drive,
    fast: bool = False,
    starting_friction: Array | None = None,
    starting_motions: Array | None = None,
) -> FrictionEquilibrium:
    """Return the contact loads, contact angles and friction of each ball that are in equilibrium with each other.

    The iteration begins at the static state without friction. If a ball has several equilibria, the iteration leads to
    the one that the ball reaches by rolling from the static state.

    Parameters
    ----------
    scene
        Screw whose friction displaces balls.
    static_contacts
        Contacts of its N balls without friction.
    positions
        Positions of the balls relative to their grooves without friction.
    friction
        Coefficients of friction.
    drive
        Which part turns, screw or nut, and its angular speed.
    fast
        Whether to use the compiled functions instead of plain Python.
    starting_friction
        Friction of a similar state ``(N, 3)`` [N] (`FrictionEquilibrium.friction_on_balls_and_screw`), at which the
        iteration begins; None to begin at the static state.
    starting_motions
        Motions of the balls in a similar state ``(N, 4)`` [rad/s], which shorten the solution but do not change it; None if
        none are known.

    Returns
    -------
    FrictionEquilibrium
        The equilibrium; its field ``failed_balls`` marks balls for which none was found.
    """
    count = static_contacts.force.shape[0]
    along, loaded = positions.screw_axis_direction[[0, 2]], static_contacts.force.sum(axis=1) > 0.0
    still = _unbalanced_forces(static_contacts.force, static_contacts.normals[..., [0, 2]], along, np.zeros((count, 3)))
    guess, shift, mixer = np.zeros((count, 3)), np.zeros((count, 3)), AndersonAcceleration(2, ROUNDS)
    contacts, active, rounds = static_contacts, np.flatnonzero(loaded), 0
    settle = partial(_contacts_under_forces, place=positions, frictionless=static_contacts, fast=fast)
    if starting_friction is not None and active.size:
        guess[active] = starting_friction[active]
        contacts, shift[active], _ = settle(static_contacts, active, still[active] + guess[active], shift[active])
    failed = np.zeros(count, dtype=bool)
    q = np.full((count, 4), np.nan) if starting_motions is None else starting_motions.copy()
    while active.size and rounds < ROUNDS:
        rounds += 1
        chosen = contacts.subset(active)
        by_ball = ball_friction(scene, chosen, friction, drive, fast, q[active])
        q[active] = by_ball.ball_motions
        answer = _friction_on_balls_and_screw(by_ball, chosen, positions.screw_axis_direction)
        unsettled = (np.abs(answer - guess[active]).max(axis=1) > AGREED * chosen.force.sum(axis=1)) | failed[active]
        active = active[unsettled]
        mixer.keep_vectors(unsettled)
        guess[active] = mixer.next_iterate(guess[active], answer[unsettled])
        contacts, shift[active], failed[active] = settle(contacts, active, still[active] + guess[active], shift[active])
    for ball in active:
        from scipy.optimize import root  # few states come here

        one, size = np.array([ball]), float(contacts.force[ball].sum())

        def change_of_friction(x: Array, one: Index = one, size: float = size) -> Array:
            """Return the resulting less the assumed friction, divided by the sum of the contact loads ``(3,)``.

            ``x``: assumed friction on ball and screw divided by the sum of the contact loads ``(3,)``; ``one``: index
            of the ball ``(1,)``; ``size``: sum of its contact loads [N].
            """
            there, _, _ = settle(static_contacts, one, still[one] + size * x, shift[one])
            chosen = there.subset(one)
            by_ball = ball_friction(scene, chosen, friction, drive, fast, q[one])
            return np.asarray(_friction_on_balls_and_screw(by_ball, chosen, positions.screw_axis_direction)[0] / size - x)

        options = {"xtol": SOLVED, "eps": DIFFERENCE**2, "maxfev": TRIALS}
        guess[ball] = size * root(change_of_friction, guess[ball] / size, options=options).x
        contacts, shift[one], failed[one] = settle(contacts, one, still[one] + guess[one], shift[one])
    final = ball_friction(scene, contacts, friction, drive, fast, q)
    applied = still + _friction_on_balls_and_screw(final, contacts, positions.screw_axis_direction)
    off = _unbalanced_forces(contacts.force, contacts.normals[..., [0, 2]], along, applied)
    change = np.abs(off).max(axis=1) / np.maximum(contacts.force.sum(axis=1), 1e-300)
    return FrictionEquilibrium(contacts, final, failed | (change > ACCEPTED), rounds, float(change.max(initial=0.0)), guess)


def _friction_on_balls_and_screw(by_ball: BallFriction, contacts: StaticContacts, axis: Array) -> Array:
    """Return the friction on each ball along x3 (radial) and z3 (binormal) and on the screw along its axis ``(N, 3)`` [N].

    ``by_ball``: friction of the balls in the contacts ``contacts``; ``axis`` ``(3,)``: direction of the screw's axis in
    x3, y3, z3.
    """
    wrench = by_ball.contact_wrenches(contacts.normals)[..., :3]
    drag = -np.einsum("nsi,i->n", wrench[:, ON_SCREW], axis)
    return np.column_stack([wrench[:, :, [0, 2]].sum(axis=1), drag])


def balls_with_jammed_state(
    scene: Scene,
    positions: PositionsInGrooves,
    static_contacts: StaticContacts,
    rolling_state: FrictionEquilibrium,
    friction: Friction,
    drive: Drive,
    fast: bool = False,
) -> tuple[int, ...]:
    """Return the indices of balls for which a second equilibrium is found, in which they are jammed between their grooves.

    The search starts from four displaced states, in which the balls are pushed along x3 (radial) or z3 (binormal), in
    either direction, with ``DISPLACED`` times their largest contact load. The search may miss such an equilibrium.
    ``scene``: the screw; ``positions``, ``static_contacts``: positions and contacts of the balls without friction;
    ``rolling_state``: equilibrium that the balls reach by rolling from there; ``friction``: coefficients of friction;
    ``drive``: which part turns, screw or nut, and its angular speed; ``fast``: whether to use the compiled functions.
    """
    size, other = rolling_state.contacts.force.max(axis=1), np.zeros(static_contacts.force.shape[0], dtype=bool)
    for axis in range(2):
        for sign in (-1.0, 1.0):
            push = np.zeros((size.size, 3))
            push[:, axis] = sign * DISPLACED * size
            again = solve_friction_equilibrium(scene, static_contacts, positions, friction, drive, fast, push)
            difference = np.abs(again.contacts.force - rolling_state.contacts.force).max(axis=1)
            apart = difference > ANOTHER * np.maximum(size, 1e-300)
            other |= apart & ~again.failed_balls & ~rolling_state.failed_balls & (size > 0.0)
    return tuple(int(k) for k in np.flatnonzero(other))


def _contacts_under_forces(
    contacts: StaticContacts,
    balls: Index,
    forces: Array,
    start: Array,
    *,
    place: PositionsInGrooves,
    frictionless: StaticContacts,
    fast: bool,
) -> tuple[StaticContacts, Array, Mask]:
    """Return the contacts of N balls after k of them are brought into equilibrium with given forces.

    ``contacts``: contacts of all balls, of which those of ``balls`` (indices ``(k,)``) are replaced; ``forces``: forces on
    each of the k balls along x3 (radial) and z3 (binormal) and on the screw ``(k, 3)`` [N]; ``start``: displacements to
    begin from ``(k, 3)`` [m]; ``place``: positions of all balls without friction; ``frictionless``: contacts without
    friction, whose loads give the scale of the tolerance; ``fast``: whether to use the compiled functions.

    Returns
    -------
    tuple
        The contacts of all balls; displacements of the k balls along x3, z3 and of the screw along its axis ``(k, 3)`` [m];
        which of the k balls found no equilibrium ``(k,)``.
    """
    away = place.groove_to_ball_vectors[balls]
    pressed = np.hypot(away[..., 0], away[..., 1]) - place.touching_distance[balls]
    x, force, normal, left = solve_contact_loads_of_each_ball(
        away, pressed, place.C[balls], place.screw_axis_direction[[0, 2]], forces, start, fast
    )
    failed = left > 1e-8 * np.maximum(force.sum(axis=1), frictionless.force[balls].sum(axis=1))
    new_force, angle = contacts.force.copy(), contacts.angle.copy()
    new_force[balls] = force
    angle[balls] = contact_angles(normal)
    return contacts_with_loads(contacts, new_force, angle), x, failed
