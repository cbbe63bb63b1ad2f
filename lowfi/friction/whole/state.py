"""Friction of a whole screw or bearing at the contact loads of a static model: losses of all balls, and the torques."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from rollbench.lowfi.friction.whole import feedback, losses
from rollbench.lowfi.friction.whole import torque as whole_torque
from rollbench.lowfi.friction.whole.circuit import balls_in_circuits, solve_motion_on_track
from rollbench.lowfi.friction.whole.contacts import StaticContacts, contacts_of_all_balls, contacts_of_result
from rollbench.lowfi.jit import CONTACT, is_copy_loaded, is_machine_code_cached, register_compile_job
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import draw_errors, draw_geometry_with_errors
from rollbench.meshes.parts import Friction, Scene
from rollbench.meshes.parts import Motion as Drive

#: Number of balls up to which a command does not wait until functions are compiled. The functions in plain Python take
#: about 0.05 s for each ball, and a command, with drag torque and a range of coefficients of friction, needs up to seven
#: solutions.
UNCOMPILED = 120
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
    scene: Scene, contacts: StaticContacts, friction: Friction, drive: Drive, member: int = 0, fast: bool = False
) -> NeighbourFriction:
    """Return the friction of all balls at given contact loads, with forces between neighbours that touch.

    Neighbours touch if their gap is at most ``TOUCHING``; balls in the return tube touch no other ball. ``scene``: screw or
    bearing; ``contacts``: contacts of its balls; ``friction``: coefficients of friction; ``drive``: which part turns, screw
    or nut, and its angular speed; ``member``: number of the draw of random errors (specimen); ``fast``: whether to use the
    compiled functions.

    Raises
    ------
    CircuitError
        The circuits cannot hold their balls.
    ValueError
        Balls overlap.
    """
    track, drawn = scene.track, draw_errors(scene, member)
    all_balls = balls_in_circuits(scene, friction, drive, drawn, member)
    on_arc = np.flatnonzero(all_balls.number >= 0)
    order = all_balls.number[on_arc]
    layout = all_balls.layout(scene, all_balls.azimuth)
    full = contacts_of_all_balls(contacts.subset(order), layout, on_arc, all_balls.radius, track.contact_angle)
    gap = all_balls.gaps_to_next_balls(all_balls.azimuth) * all_balls.grooves.pair.closing_speed_factor
    slack = np.where(gap <= TOUCHING, 0.0, np.inf)
    least = np.inf
    q, force, status = np.full((order.size, 4), np.nan), np.zeros(order.size), ["no load"] * order.size
    motion, pull = np.zeros((order.size, 4, 3)), np.zeros((order.size, 4, 3))
    power, touching, left = 0.0, 0, 0.0
    for members in (track.balls for track in all_balls.tracks):
        number = all_balls.number[members]
        free = (number < 0) | (np.roll(number, -1) < 0)
        if track.lead != 0.0:
            free[-1] = True  # the return lies between the last ball and the first
        limit = np.where(free, np.inf, slack[members])
        least = min(least, float(np.min(np.where(free, np.inf, gap[members]))))
        touching += int(np.sum(limit == 0.0))
        moved = solve_motion_on_track(scene, full.subset(members), limit, friction, drive, all_balls.grooves, None, fast)
        kept, to = number >= 0, number[number >= 0]
        pressed = contacts.force[to].sum(axis=1) > 0.0
        q[to] = np.where(pressed[:, None], moved.q[kept], np.nan)
        motion[to], pull[to], force[to] = moved.contact_motions[kept], moved.contact_friction[kept], moved.ball_force[kept]
        power += float(moved.ball_loss.sum() + moved.closing_loss.sum())
        left = max(left, moved.largest_unbalanced_force)
        for k in to[pressed]:
            status[k] = "balanced" if moved.converged else "failed"
    rest = np.zeros(contacts.force.shape, dtype=bool)
    scale = max(max(friction.screw, friction.nut) * float(contacts.force.sum(axis=1).max(initial=0.0)), 1e-30)
    by_ball = losses.ball_friction_from_motions(contacts, q, motion, pull, rest, status, left / scale)
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
    #: Indices of balls for which no equilibrium of friction and position was found, in the motion of the scene or in the
    #: reversed motion.
    unsettled_balls: tuple[int, ...]
    #: Largest ratio, over all balls, of the unbalanced force on a ball, after friction has changed its contact loads, to
    #: the sum of these loads; 0 if friction does not change contact loads.
    change: float
    #: Whether friction displaces the balls in their grooves and so changes the contact loads.
    friction_changes_loads: bool
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


def friction_state(
    scene: Scene, result: StaticResult, friction: Friction, drive: Drive, member: int = 0, *, fast: bool | None = None
) -> FrictionState:
    """Return the friction of a screw or bearing at the contact loads of a static result.

    If ``friction`` requests it, friction changes the positions of the balls (feedback), and touching neighbours press
    on each other. If both are requested, neighbours press on each other at the contact loads that result from each
    ball's own friction, as in a transient simulation. In a bearing ring, friction acts along the groove and displaces
    no ball.

    Parameters
    ----------
    scene
        Screw or bearing.
    result
        Static result of this scene, with the contact loads.
    friction
        Coefficients of friction, and whether feedback and forces between neighbours are requested.
    drive
        Which part turns, screw or nut, and its angular speed.
    member
        Number of the draw of random geometric errors (specimen) for which ``result`` was solved.
    fast
        Whether to use the compiled functions instead of plain Python; None: only if the scene has so many balls that
        compiling them first saves time; otherwise `register_compile_job` has them compiled after this computation.

    Raises
    ------
    CircuitError
        Neighbours are requested, and the circuits cannot hold their balls.
    ValueError
        The static result did not converge, the speed is zero, or balls overlap.
    """
    at = contacts_of_result(scene, result, member)
    coupled = whole_torque.friction_displaces_balls(scene, friction)
    pushed = friction.neighbours
    compiled = is_machine_code_cached(CONTACT) or is_copy_loaded(CONTACT)
    first = fast is None and not compiled and not pushed and scene.ball_count <= UNCOMPILED
    if first and whole_torque.compiling_saves_time(scene, friction):
        register_compile_job(CONTACT, partial(friction_state, scene, result, friction, drive, member, fast=True))
    if fast is None:
        fast = not first and (
            whole_torque.compiling_saves_time(scene, friction)
            or is_copy_loaded(CONTACT)
            or (coupled and is_machine_code_cached(CONTACT))
        )
    balls = losses.ball_friction(scene, at, friction, drive, fast)
    torque = bare = whole_torque.sum_friction_over_contacts(scene, at, balls, drive)
    unsettled: tuple[int, ...] = ()
    second: tuple[int, ...] | None = None
    change, at_back = 0.0, at
    if coupled:
        drawn = draw_geometry_with_errors(scene, at.layout, member)
        place = feedback.positions_in_grooves_with_errors(at, drawn, result.hertz_C)
        both_ways = (drive, reversed_motion(drive))
        there, back = (feedback.solve_friction_equilibrium(scene, at, place, friction, d, fast) for d in both_ways)
        still, at, at_back, balls = at, there.contacts, back.contacts, there.friction
        sums = whole_torque.sum_friction_over_contacts(scene, at, balls, drive, coupled=True)
        torque = replace(sums, reverse_power=back.friction.total_power_lost)
        change = max(there.largest_imbalance_ratio, back.largest_imbalance_ratio)
        unsettled = tuple(int(k) for k in np.flatnonzero(there.failed_balls | back.failed_balls))
        if max(friction.screw, friction.nut) >= feedback.JAMMED:
            second = feedback.balls_with_jammed_state(scene, place, still, there, friction, drive, fast)
    touching = None
    if pushed:
        ways = ((at, drive), (at_back, reversed_motion(drive)))
        touching, again = (friction_with_neighbours(scene, contacts, friction, d, member, fast) for contacts, d in ways)
        balls = touching.ball_friction
        sums = whole_torque.sum_friction_over_contacts(scene, at, balls, drive, coupled=coupled)
        torque = replace(
            sums,
            power=sums.power + touching.power_lost_between_balls,
            reverse_power=again.ball_friction.total_power_lost + again.power_lost_between_balls,
        )
    closing = losses.closing_speeds_of_neighbours(scene, at, balls, drive)
    return FrictionState(at, balls, torque, closing, bare, unsettled, change, coupled, touching, second)


def reversed_motion(drive: Drive) -> Drive:
    """Return the motion of screw or nut that is opposite to ``drive``."""
    return replace(drive, speed=-drive.speed)
