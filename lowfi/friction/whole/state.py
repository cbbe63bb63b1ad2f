"""Friction of a whole screw or bearing at the contact loads of a static model: losses of all balls, and the torques."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from rollbench.lowfi.friction.whole import feedback, heathcote, losses
from rollbench.lowfi.friction.whole import torque as whole_torque
from rollbench.lowfi.friction.whole.circuit import balls_in_circuits, search_motion_on_track
from rollbench.lowfi.friction.whole.contacts import StaticContacts, contacts_of_all_balls, contacts_of_result
from rollbench.lowfi.friction.whole.losses import BallsUnderLoad
from rollbench.lowfi.statics.result import StaticResult
from rollbench.lowfi.together import solve_together
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import draw_errors, draw_geometry_with_errors
from rollbench.meshes.parts import Friction, Scene
from rollbench.meshes.parts import Motion as Drive

#: Gap between neighbouring balls [m] up to which they count as touching.
TOUCHING = 1e-6


@dataclass(frozen=True)
class NeighbourFriction:
    """Friction of N balls, in the order of the scene, where neighbours that touch press on each other."""

    #: Motion of the balls, friction on them and losses at the grooves.
    ball_friction: losses.BallFriction
    #: Force of each ball on the next one, which is the neighbour at the larger azimuth ``(N,)`` [N].
    force_on_next_ball: Array
    #: Power lost between all touching balls together [W].
    power_lost_between_balls: float
    #: Number of pairs of neighbouring balls that touch.
    touching_pair_count: int
    #: Smallest gap between neighbours on the loaded arcs [m]; infinite if no ball has a neighbour.
    smallest_gap: float


def friction_with_neighbours(
    scene: Scene, contacts: StaticContacts, friction: Friction, drive: Drive, member: int = 0
) -> NeighbourFriction:
    """Return the friction of all balls at given contact loads, with forces between neighbours that touch.

    Neighbours touch if their gap is at most ``TOUCHING``; balls in the return tube touch no other ball. ``scene``: screw or
    bearing; ``contacts``: contacts of its balls; ``friction``: coefficients of friction; ``drive``: which part turns, screw
    or nut, and its angular speed; ``member``: number of the draw of random errors (specimen).

    Raises
    ------
    CircuitError
        The circuits cannot hold their balls.
    ValueError
        Balls overlap.
    """
    track, drawn = scene.track, draw_errors(scene, member)
    all_balls = balls_in_circuits(scene, drive, drawn, member)
    on_arc = np.flatnonzero(all_balls.number >= 0)
    order = all_balls.number[on_arc]
    layout = all_balls.layout(scene, all_balls.azimuth)
    full = contacts_of_all_balls(contacts.subset(order), layout, on_arc, all_balls.radius, track.contact_angle)
    gap = all_balls.gaps_to_next_balls(all_balls.azimuth) * all_balls.groove.pair.closing_speed_factor
    slack = np.where(gap <= TOUCHING, 0.0, np.inf)
    least = np.inf
    q, force, status = np.full((order.size, 4), np.nan), np.zeros(order.size), ["no load"] * order.size
    motion, pull = np.zeros((order.size, 4, 3)), np.zeros((order.size, 4, 3))
    power, touching, left, searches = 0.0, 0, 0.0, []
    for members in (track.balls for track in all_balls.tracks):
        number = all_balls.number[members]
        free = (number < 0) | (np.roll(number, -1) < 0)
        if track.lead != 0.0:
            free[-1] = True  # the return lies between the last ball and the first
        limit = np.where(free, np.inf, slack[members])
        least = min(least, float(np.min(np.where(free, np.inf, gap[members]))))
        touching += int(np.sum(limit == 0.0))
        searches.append(search_motion_on_track(scene, full.subset(members), limit, friction, drive))
    for track_of_balls, moved in zip(all_balls.tracks, solve_together(searches), strict=True):
        number = all_balls.number[track_of_balls.balls]
        kept, to = number >= 0, number[number >= 0]
        pressed = contacts.force[to].sum(axis=1) > 0.0
        q[to] = np.where(pressed[:, None], moved.q[kept], np.nan)
        motion[to], pull[to], force[to] = moved.contact_motions[kept], moved.contact_friction[kept], moved.ball_force[kept]
        power += float(moved.ball_loss.sum() + moved.closing_loss.sum())
        left = max(left, moved.largest_unbalanced_force)
        for k in to[pressed]:
            status[k] = "balanced" if moved.converged else "failed"
    scale = max(max(friction.screw, friction.nut) * float(contacts.force.sum(axis=1).max(initial=0.0)), 1e-30)
    by_ball = losses.ball_friction_from_motions(contacts, np.arange(order.size), (q, motion, pull), status, left / scale)
    return NeighbourFriction(by_ball, force, power, touching, least)


@dataclass(frozen=True)
class FrictionState:
    """Friction of a whole screw or bearing at one instant, for given coefficients of friction of screw and nut."""

    #: Contacts of all balls, with their loads, angles and ellipses.
    contacts: StaticContacts
    #: Motion and friction of every ball.
    ball_friction: losses.BallFriction
    #: Torque, axial force and power of the friction, as sums over all balls.
    friction_sums: whole_torque.FrictionSums
    #: Speed at which each ball approaches the next one ``(N,)`` [m/s]; negative if they separate, nan if there is no next
    #: ball or one of the two has no load.
    closing_speeds: Array
    #: Torque, axial force and power of the friction at the static contact loads, without the effect of friction on the
    #: loads.
    sums_without_feedback: whole_torque.FrictionSums
    #: Orbital speeds of the balls at the static contact loads ``(N,)`` [rad/s] (`BallFriction.orbital_speed`).
    orbital_speeds_without_feedback: Array
    #: Indices of balls for which no equilibrium of friction and position was found, in the motion of the scene or in the
    #: reversed motion.
    unsettled_balls: tuple[int, ...]
    #: Largest ratio, over all balls, of the unbalanced force on a ball, after friction has changed its contact loads, to
    #: the sum of these loads; 0 if friction does not change contact loads.
    change: float
    #: Whether friction displaces the balls in their grooves and so changes the contact loads.
    friction_changes_loads: bool
    #: Contact loads without friction, and with friction in the reversed motion, each ``(N, 4)`` [N].
    loads_without_friction: Array
    loads_in_reverse: Array
    #: Forces and losses between touching balls; None if the scene does not request them.
    neighbour_friction: NeighbourFriction | None = None
    #: Indices of balls for which a second equilibrium was found, jammed between their grooves; None if no search was made.
    jammed_balls: tuple[int, ...] | None = None

    @property
    def all_balanced(self) -> bool:
        """Whether the friction of every ball is in balance and agrees with the ball's position in its grooves."""
        return self.ball_friction.converged and not self.unsettled_balls

    @property
    def loaded(self) -> bool:
        """Whether any contact carries load."""
        return bool(np.any(self.contacts.force > 0.0))


class FrictionCase(NamedTuple):
    """A statically solved screw or bearing, whose friction is to be computed."""

    #: Screw or bearing.
    scene: Scene
    #: Static result of this scene, with the contact loads.
    result: StaticResult
    #: Coefficients of friction, and whether feedback and forces between neighbours are requested.
    friction: Friction
    #: Which part turns, screw or nut, and its angular speed.
    drive: Drive
    #: Number of the draw of random geometric errors (specimen) for which ``result`` was solved.
    member: int = 0


def friction_state(scene: Scene, result: StaticResult, friction: Friction, drive: Drive, member: int = 0) -> FrictionState:
    """Return the friction of one screw or bearing at the contact loads of a static result; see `friction_states`.

    The arguments are the fields of `FrictionCase`.
    """
    return friction_states([FrictionCase(scene, result, friction, drive, member)])[0]


def friction_states(cases: Sequence[FrictionCase]) -> list[FrictionState]:
    """Return the friction of several screws, bearings or load cases at the contact loads of their static results.

    If a case requests it, friction changes the positions of the balls (feedback), and touching neighbours press on each
    other. If both are requested, neighbours press on each other at the contact loads that result from each ball's own
    friction, as in a transient simulation. In a bearing ring, friction acts along the groove and displaces no ball. The
    balls of all cases, in both directions of motion, are iterated together, and balls in equal states are solved once.

    Parameters
    ----------
    cases
        The cases.

    Raises
    ------
    CircuitError
        Neighbours are requested, and the circuits cannot hold their balls.
    ValueError
        A static result did not converge, a speed is zero, or balls overlap.
    """
    if not cases:
        return []
    still = [BallsUnderLoad(c.scene, contacts_of_result(c.scene, c.result, c.member), c.friction, c.drive) for c in cases]
    fed = [k for k, c in enumerate(cases) if whole_torque.friction_displaces_balls(c.scene, c.friction)]
    alone = losses.friction_of_groups(still)
    displaced = []
    for k in fed:
        drawn = draw_geometry_with_errors(cases[k].scene, still[k].contacts.layout, cases[k].member)
        place = feedback.positions_in_grooves_with_errors(still[k].contacts, drawn, cases[k].result.hertz_C)
        back, motions = still[k]._replace(drive=reversed_motion(cases[k].drive)), alone[k].ball_motions
        displaced += [
            feedback.DisplacedBalls(*way) for way in ((still[k], place, None, motions), (back, place, None, -motions))
        ]
    equilibria = feedback.solve_friction_equilibria(displaced)
    found = dict(zip(fed, zip(displaced[::2], equilibria[::2], equilibria[1::2], strict=True), strict=True))
    return [_state_of_case(case, still[k].contacts, alone[k], found.get(k)) for k, case in enumerate(cases)]


def _state_of_case(
    case: FrictionCase,
    at: StaticContacts,
    by_ball: losses.BallFriction,
    fed_back: tuple[feedback.DisplacedBalls, feedback.FrictionEquilibrium, feedback.FrictionEquilibrium] | None,
) -> FrictionState:
    """Return the friction of one case from the solutions for its single balls.

    ``at``, ``by_ball``: contacts at the static loads, and the friction there; ``fed_back``: balls that friction displaces,
    with their equilibria in the motion of the case and in the reversed motion; None if friction displaces no ball.
    """
    scene, _, friction, drive, member = case
    without, at_back, orbit = at.force, at, by_ball.orbital_speed
    torque = bare = whole_torque.sum_friction_over_contacts(scene, at, by_ball, drive)
    unsettled: tuple[int, ...] = ()
    second: tuple[int, ...] | None = None
    change = 0.0
    if fed_back is not None:
        balls, there, back = fed_back
        at, at_back, by_ball = there.contacts, back.contacts, there.friction
        sums = whole_torque.sum_friction_over_contacts(scene, at, by_ball, drive, coupled=True)
        torque = replace(sums, reverse_power=back.friction.total_power_lost)
        change = max(there.largest_imbalance_ratio, back.largest_imbalance_ratio)
        unsettled = tuple(int(k) for k in np.flatnonzero(there.failed_balls | back.failed_balls))
        if max(friction.screw, friction.nut) >= feedback.JAMMED:
            second = feedback.balls_with_jammed_state(balls, there)
    touching, coupled = None, fed_back is not None
    if friction.neighbours:
        ways = ((at, drive), (at_back, reversed_motion(drive)))
        touching, again = (friction_with_neighbours(scene, contacts, friction, d, member) for contacts, d in ways)
        by_ball = touching.ball_friction
        sums = whole_torque.sum_friction_over_contacts(scene, at, by_ball, drive, coupled=coupled)
        torque = replace(
            sums,
            power=sums.power + touching.power_lost_between_balls,
            reverse_power=again.ball_friction.total_power_lost + again.power_lost_between_balls,
        )
    closing = losses.closing_speeds_of_neighbours(scene, at, by_ball, drive)
    loads = (without, at_back.force)
    return FrictionState(at, by_ball, torque, closing, bare, orbit, unsettled, change, coupled, *loads, touching, second)


def friction_of_curved_contacts(
    case: FrictionCase, state: FrictionState
) -> tuple[losses.BallFriction, losses.BallFriction]:
    """Return the friction of a screw or bearing with flat contact ellipses, and with curved ones (Heathcote slip).

    Both are that of every ball by itself, without forces between neighbours. Where friction changes the contact loads, it
    does so with curved contacts as well. Balls for which no balance was found have the status "failed".

    Parameters
    ----------
    case
        The case.
    state
        Its friction with flat contact ellipses.
    """
    balls = BallsUnderLoad(case.scene, state.contacts, case.friction, case.drive)
    flat = losses.ball_friction(balls) if case.friction.neighbours else state.ball_friction
    if not state.friction_changes_loads:
        return flat, heathcote.friction_of_curved_contacts([balls], [flat.ball_motions])[0]
    still = balls._replace(contacts=contacts_of_result(case.scene, case.result, case.member))
    drawn = draw_geometry_with_errors(case.scene, still.contacts.layout, case.member)
    place = feedback.positions_in_grooves_with_errors(still.contacts, drawn, case.result.hertz_C)
    begin = feedback.friction_on_balls_and_screw(flat, state.contacts)
    balls_and_start = feedback.DisplacedBalls(still, place, begin, flat.ball_motions)
    (found,) = feedback.solve_friction_equilibria([balls_and_start], heathcote.friction_of_curved_contacts)
    status = tuple("failed" if bad else word for word, bad in zip(found.friction.status, found.failed_balls, strict=True))
    return flat, replace(found.friction, status=status)


def reversed_motion(drive: Drive) -> Drive:
    """Return the motion of screw or nut that is opposite to ``drive``."""
    return replace(drive, speed=-drive.speed)
