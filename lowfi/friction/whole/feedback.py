"""Effect of friction on the position of a ball: new contact loads and angles at the same axial load of every ball.

Friction across the groove pushes each ball sideways until its contacts resist, at other contact angles or on a third flank
(section 3.4.1 of Lin's thesis). For each ball separately, the ball moves in its groove section and the screw along its axis
until the axial load of this ball, friction included, is that of the static model. The distribution of the axial load over
the balls therefore remains that of the static model.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rollbench.lowfi.friction.contact.descent import move_along_steps
from rollbench.lowfi.friction.contact.loads import groups_at, minimise_energy
from rollbench.lowfi.friction.contact.normal_force import BallContactArrays
from rollbench.lowfi.friction.screw.groove import ON_SCREW
from rollbench.lowfi.friction.screw.motion import AndersonAcceleration
from rollbench.lowfi.friction.whole.contacts import StaticContacts, contacts_with_loads
from rollbench.lowfi.friction.whole.losses import BallFriction, BallsUnderLoad, friction_of_groups
from rollbench.lowfi.statics.settle import contact_angles
from rollbench.meshes.arrays import Array, Index, Mask
from rollbench.meshes.errors import GeometryWithErrors

#: Difference between the friction in a ball's contacts and the friction that its contact loads balance, as a fraction of
#: the sum of these loads: tolerance that the iteration aims at, and largest difference that is accepted.
AGREED, ACCEPTED = 1e-7, 1e-4
#: Number of rounds of the iteration between contact loads and friction, after which a ball is solved by Newton's method.
#: Where a lightly loaded contact is about to slip or to stick, friction changes its direction at the smallest change of
#: position, and the iteration oscillates.
ROUNDS = 40
#: Newton's method: step of the finite differences and change of friction at which it ends, as fractions of the ball's
#: contact loads; largest numbers of steps, and of halvings of a step.
DIFFERENCE, SOLVED, STEPS, HALVINGS = 1e-8, 1e-12, 40, 20
#: Force that displaces a ball at the start of the search for a second equilibrium, and least difference of the contact
#: forces of two equilibria, as fractions of the ball's largest contact force.
DISPLACED, ANOTHER = 3.0, 1e-3
#: Coefficient of friction from which on a second state of a ball, jammed between its grooves, was observed.
JAMMED = 0.3


def positions_in_grooves(contacts: StaticContacts, C: Array, reach: Array, centre: Array) -> BallContactArrays:
    """Return the positions of N balls relative to their grooves without friction, from their contact loads and angles.

    A flank without contact is assumed to move with the other flank of the same body. A ball without load keeps its
    nominal position. ``contacts``: contacts of the balls; ``C``: Hertz constants of the approach C F^(2/3) ``(N, 4)``
    [m/N^(2/3)]; ``reach``: distance of the ball's centre from the centre of each groove's profile where ball and groove
    just touch ``(N, 4)`` [m]; ``centre``: centres of the profiles along x3 (radial) and z3 (binormal) ``(N, 4, 2)``
    [m]. Each of the N balls is a group of its own, with the screw that moves along its axis; no forces are applied.
    """
    squeeze = C * np.cbrt(contacts.force) ** 2
    away = (reach + squeeze)[..., None] * contacts.normals[..., [0, 2]]
    other = [1, 0, 3, 2]
    by_other = away[:, other] + centre[:, other] - centre
    free = (contacts.force == 0.0) & (contacts.force[:, other] > 0.0)
    away = np.where(free[..., None], by_other, away)
    reach = np.where(free, np.maximum(reach, np.hypot(away[..., 0], away[..., 1])), reach)
    distance, none = np.hypot(away[..., 0], away[..., 1]), np.zeros((len(C), 1, 2))
    return BallContactArrays(
        groove_to_ball_vectors=away[:, None],
        interference=(distance - reach)[:, None],
        C=C[:, None],
        inner_displacement_maps=contacts.section_axes[:, None, [0, 2], 2, None],
        given_inner_displacement=none,
        ball_forces=none,
        inner_body_forces=none[:, 0, :1],
        groove_ball_centre_distance=np.linalg.norm(away, axis=-1).min(axis=1),
    )


def positions_in_grooves_with_errors(contacts: StaticContacts, drawn: GeometryWithErrors, C: Array) -> BallContactArrays:
    """Return the positions of N balls relative to grooves with geometric errors.

    ``contacts``: contacts of the balls; ``drawn``: radii, groove centres and groove profiles with random errors; ``C``:
    Hertz constants of the approach C F^(2/3) ``(N, 4)`` [m/N^(2/3)].
    """
    inward = np.zeros_like(contacts.angle)
    for s, row in enumerate(drawn.profile_coefficients):
        inward[:, s] = np.polynomial.polynomial.polyval(contacts.angle[:, s], row) if row.size else 0.0
    reach = drawn.groove_radii[None, :] - inward - drawn.ball_radii[:, None]
    return positions_in_grooves(contacts, C, reach, drawn.groove_centres)


def _unbalanced_forces(contacts: StaticContacts, applied: Array) -> Array:
    """Return the unbalanced forces on each ball and on the screw, contact forces less applied forces ``(N, 3)`` [N].

    The three values are the forces on the ball along x3 (radial) and z3 (binormal), and on the screw along its axis.
    ``applied``: applied forces, in the order of the result ``(N, 3)`` [N].
    """
    push = contacts.force[..., None] * contacts.normals[..., [0, 2]]
    screw = -np.einsum("nsi,ni->n", push[:, ON_SCREW], contacts.section_axes[:, [0, 2], 2])
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
    #: Largest ratio, over all balls, of the unbalanced force on a ball to the sum of its contact loads.
    largest_imbalance_ratio: float
    #: Friction forces, in balance with the contact loads: on each ball along x3 (radial) and z3 (binormal), and on the
    #: screw along its axis ``(N, 3)`` [N].
    friction_on_balls_and_screw: Array


class DisplacedBalls(NamedTuple):
    """Balls of a screw that friction displaces in their grooves, and from where the search for their equilibrium begins."""

    #: The N balls at the contact loads without friction.
    still: BallsUnderLoad
    #: Positions of the balls relative to their grooves without friction, by `positions_in_grooves_with_errors`.
    place: BallContactArrays
    #: Friction of a similar state ``(N, 3)`` [N] (`FrictionEquilibrium.friction_on_balls_and_screw`), at which the
    #: iteration begins; None to begin at the static state.
    starting_friction: Array | None = None
    #: Motions of the balls in a similar state ``(N, 4)`` [rad/s], which shorten the solution but do not change it; None if
    #: none are known.
    starting_motions: Array | None = None


#: Function that returns motion and friction of the balls of several groups at given contact loads, such as
#: `friction_of_groups`; it takes the groups, and first estimates of their motions.
FrictionLaw = Callable[[Sequence[BallsUnderLoad], Sequence[Array]], list[BallFriction]]


class _BallsOfGroups:
    """All balls of several groups in one row, in search of their equilibria with friction.

    A ball is known by its number in this row. Attributes: ``contacts``, the present contacts of all balls; ``friction``,
    that on balls and screw which these contacts balance ``(N, 3)``; ``shift``, displacements of balls and screw from the
    state without friction ``(N, 3)``; ``q``, motions ``(N, 4)``; ``failed``, whether no contact loads were found ``(N,)``.
    """

    def __init__(self, groups: Sequence[DisplacedBalls], law: FrictionLaw) -> None:
        """Begin at the state without friction, or at the friction that a group begins from; ``law``: gives the friction."""
        self.groups, self.law = [group.still for group in groups], law
        sizes = [balls.contacts.force.shape[0] for balls in self.groups]
        self.count, self.group_of_ball = sum(sizes), np.repeat(np.arange(len(sizes)), sizes)
        self.frictionless = self.contacts = StaticContacts.joined([balls.contacts for balls in self.groups])
        self.cells = BallContactArrays(*map(np.concatenate, zip(*(group.place for group in groups), strict=True)))
        self.loaded = self.contacts.force.sum(axis=1) > 0.0
        self.friction, self.shift = np.zeros((self.count, 3)), np.zeros((self.count, 3))
        self.still = _unbalanced_forces(self.contacts, self.friction)
        self.q, self.failed = np.full((self.count, 4), np.nan), np.zeros(self.count, dtype=bool)
        for part, group in zip(self.parts(np.arange(self.count)), groups, strict=True):
            if group.starting_friction is not None:
                self.friction[part] = np.where(self.loaded[part, None], group.starting_friction, 0.0)
            if group.starting_motions is not None:
                self.q[part] = group.starting_motions
        self.settle(np.flatnonzero(self.friction.any(axis=1)))
        self.failed[:] = False

    def parts(self, balls: Index) -> list[Index]:
        """Return for each group those of some balls, in ascending order, that belong to it."""
        return np.split(balls, np.searchsorted(self.group_of_ball[balls], np.arange(1, len(self.groups))))

    def settle(self, balls: Index) -> None:
        """Bring some balls into equilibrium with the friction that is assumed on them; write contacts and displacements."""
        forces = self.still[balls] + self.friction[balls]
        cells = groups_at(self.cells, balls)._replace(ball_forces=forces[:, None, :2], inner_body_forces=forces[:, 2:])
        ball, inner = np.split(self.shift[balls], [2], axis=1)
        ball, inner, state, _ = minimise_energy(cells, np.abs(forces).sum(axis=1), ball[:, None], inner)
        force = state.force[:, 0]
        scale = np.maximum(force.sum(axis=1), self.frictionless.force[balls].sum(axis=1))
        self.shift[balls], self.failed[balls] = np.column_stack([ball[:, 0], inner]), state.imbalance > 1e-8 * scale
        new_force, angle = self.contacts.force.copy(), self.contacts.angle.copy()
        new_force[balls], angle[balls] = force, contact_angles(state.normal[:, 0])
        self.contacts = contacts_with_loads(self.contacts, new_force, angle)

    def rolling(self, balls: Index) -> list[BallsUnderLoad]:
        """Return for each group those of some balls that belong to it, at their present contacts."""
        parts = zip(self.groups, self.parts(balls), strict=True)
        return [group._replace(contacts=self.contacts.subset(part)) for group, part in parts]

    def resulting_friction(self, balls: Index) -> Array:
        """Return the friction of some balls at their contacts, on each ball and the screw ``(k, 3)`` [N]; note motions."""
        rolling = self.rolling(balls)
        found = self.law(rolling, [self.q[part] for part in self.parts(balls)])
        self.q[balls] = np.concatenate([by_ball.ball_motions for by_ball in found])
        each = zip(found, rolling, strict=True)
        return np.concatenate([friction_on_balls_and_screw(by_ball, at.contacts) for by_ball, at in each])


def solve_friction_equilibria(
    groups: Sequence[DisplacedBalls], law: FrictionLaw = friction_of_groups
) -> list[FrictionEquilibrium]:
    """Return the contact loads, contact angles and friction of each ball that are in equilibrium with each other.

    The iteration begins at the static state without friction. If a ball has several equilibria, the iteration leads to
    the one that the ball reaches by rolling from the static state. All groups are iterated together.

    Parameters
    ----------
    groups
        Groups of balls that do not depend on each other, such as those of several load cases, coefficients of friction and
        directions of motion.
    law
        Function that returns motion and friction of the balls at given contact loads.

    Returns
    -------
    list of FrictionEquilibrium
        The equilibrium of each group; its field ``failed_balls`` marks balls for which none was found.
    """
    if not groups:
        return []
    balls, mixer = _BallsOfGroups(groups, law), AndersonAcceleration(2, ROUNDS)
    active, everyone = np.flatnonzero(balls.loaded), np.arange(balls.count)
    for _ in range(ROUNDS):
        if not active.size:
            break
        answer = balls.resulting_friction(active)
        change = np.abs(answer - balls.friction[active]).max(axis=1)
        unsettled = (change > AGREED * balls.contacts.force[active].sum(axis=1)) | balls.failed[active]
        active = active[unsettled]
        mixer.keep_vectors(unsettled)
        balls.friction[active] = mixer.next_iterate(balls.friction[active], answer[unsettled])
        balls.settle(active)
    if active.size:
        _settle_by_newton(balls, active)
    rolling = balls.rolling(everyone)
    final = law(rolling, [balls.q[part] for part in balls.parts(everyone)])
    out = []
    for found, at, part in zip(final, rolling, balls.parts(everyone), strict=True):
        applied = balls.still[part] + friction_on_balls_and_screw(found, at.contacts)
        off = _unbalanced_forces(at.contacts, applied)
        change = np.abs(off).max(axis=1) / np.maximum(at.contacts.force.sum(axis=1), 1e-300)
        failed = balls.failed[part] | (change > ACCEPTED)
        out.append(FrictionEquilibrium(at.contacts, found, failed, float(change.max(initial=0.0)), balls.friction[part]))
    return out


def _settle_by_newton(balls: _BallsOfGroups, some: Index) -> None:
    """Find the friction on those balls at which the iteration oscillates, and their contacts.

    Newton's method with finite differences and a line search, for all these balls at the same time and each for itself.
    """
    size, shift, q = balls.contacts.force[some].sum(axis=1)[:, None], balls.shift[some].copy(), balls.q[some].copy()

    def change_of_friction(at: Index, x: Array) -> tuple[Array]:
        """Return the resulting less the assumed friction of the balls ``some[at]``, over their contact loads ``(k, 3)``."""
        balls.friction[some[at]], balls.shift[some[at]], balls.q[some[at]] = size[at] * x, shift[at], q[at]
        balls.settle(some[at])
        return (balls.resulting_friction(some[at]) / size[at] - x,)

    def accept(at: Index, length: Array, found: tuple[Array]) -> Mask:
        """Return whether the change of friction has decreased."""
        return np.asarray(np.linalg.norm(found[0], axis=1) < (1.0 - 1e-4 * length) * np.linalg.norm(change[on[at]], axis=1))

    x, everyone = balls.friction[some] / size, np.arange(some.size)
    state, moving = change_of_friction(everyone, x), np.ones(some.size, dtype=bool)
    for _ in range(STEPS):
        moving &= np.abs(state[0]).max(axis=1) > SOLVED
        on = np.flatnonzero(moving)
        if not on.size:
            break
        change = state[0].copy()
        beside = [change_of_friction(on, x[on] + DIFFERENCE * axis)[0] for axis in np.eye(3)]
        slope = np.stack([there - change[on] for there in beside], axis=2) / DIFFERENCE
        step = -(np.linalg.pinv(slope) @ change[on][..., None])[..., 0]
        moving[on] = move_along_steps(x, state, on, (step, np.ones(on.size)), change_of_friction, accept, HALVINGS)
    change_of_friction(everyone, x)


def friction_on_balls_and_screw(by_ball: BallFriction, contacts: StaticContacts) -> Array:
    """Return the friction on each ball along x3 (radial) and z3 (binormal) and on the screw along its axis ``(N, 3)`` [N].

    ``by_ball``: friction of the balls in the contacts ``contacts``.
    """
    wrench = by_ball.contact_wrenches(contacts.normals)[..., :3]
    drag = -np.einsum("nsi,ni->n", wrench[:, ON_SCREW], contacts.section_axes[:, :, 2])
    return np.column_stack([wrench[:, :, [0, 2]].sum(axis=1), drag])


def balls_with_jammed_state(balls: DisplacedBalls, rolling_state: FrictionEquilibrium) -> tuple[int, ...]:
    """Return the indices of balls for which a second equilibrium is found, in which they are jammed between their grooves.

    The search starts from four displaced states, in which the balls are pushed along x3 (radial) or z3 (binormal), in
    either direction, with ``DISPLACED`` times their largest contact load. The search may miss such an equilibrium.
    ``balls``: the balls at their contact loads without friction; ``rolling_state``: equilibrium that they reach by rolling
    from there.
    """
    size, other = rolling_state.contacts.force.max(axis=1), np.zeros(len(rolling_state.failed_balls), dtype=bool)
    pushes = [sign * DISPLACED * size[:, None] * np.eye(3)[axis] for axis in range(2) for sign in (-1.0, 1.0)]
    pushed = [balls._replace(starting_friction=push, starting_motions=None) for push in pushes]
    for again in solve_friction_equilibria(pushed):
        difference = np.abs(again.contacts.force - rolling_state.contacts.force).max(axis=1)
        apart = difference > ANOTHER * np.maximum(size, 1e-300)
        other |= apart & ~again.failed_balls & ~rolling_state.failed_balls & (size > 0.0)
    return tuple(int(k) for k in np.flatnonzero(other))
