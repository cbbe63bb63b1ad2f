"""Balls of a scene in their circuits (closed tracks): positions, gaps between neighbours, and forces between balls.

A circuit is given by azimuths on the track: those of the loaded arc and the return of a screw, or one turn of a
bearing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rollbench.lowfi.friction.screw import groove
from rollbench.lowfi.friction.screw.chain import BallChain, ChainMotion, search_motion_of_chain
from rollbench.lowfi.friction.screw.travel import ClosedTrack
from rollbench.lowfi.friction.whole import losses
from rollbench.lowfi.friction.whole.contacts import StaticContacts, contacts_of_result
from rollbench.lowfi.friction.whole.torque import ONE_TURN, axial_forces_and_moments
from rollbench.lowfi.statics.result import StaticResult
from rollbench.lowfi.together import Search
from rollbench.meshes.arrays import Array, Index, Mask
from rollbench.meshes.errors import ErrorsAfterDrawing, draw_ball_radii
from rollbench.meshes.helix import BallLayout, ball_layout_at_positions, lead_per_radian
from rollbench.meshes.parts import Circulation, Friction, Scene
from rollbench.meshes.parts import Motion as Drive

#: Tolerance [rad] for the overlap of loaded arcs, and for balls outside the ends of their arc.
CLOSE = 1e-9

#: Ratio of the distance between two neighbouring balls to the median of these distances; where it is exceeded, one circuit
#: ends and the next one begins.
APART = 1.5


class CircuitError(ValueError):
    """Error for a circuit (closed track of balls) that cannot hold its balls or overlaps another circuit."""

    def __init__(self, key: str, allowed: str, advice: str) -> None:
        """Store the name of the key of the scene file that must be changed, the values allowed for it, and advice.

        ``key``: name in the table [circulation]; ``allowed``: text with the values that are allowed; ``advice``: text
        that says what to change.
        """
        super().__init__(f"{key}: {allowed}; {advice}")
        self.key, self.allowed, self.advice = key, allowed, advice


class Circuit(NamedTuple):
    """One closed track with the n balls on it.

    All angles are azimuths in the nut's frame, on the helix of the first thread start. A bearing is one closed turn, so
    that its loaded arc is as long as the whole track.
    """

    #: The closed track of the circuit, with its loaded arc.
    track: ClosedTrack
    #: Azimuths of the balls at the beginning of a simulation, in increasing order, those of the balls in the return last
    #: ``(n,)`` [rad].
    azimuth: Array
    #: Numbers in the scene of the balls of the circuit ``(n,)``; -1 for a ball in the return.
    ball_numbers: Index


def circuits_of_scene(scene: Scene) -> tuple[Circuit, ...]:
    """Return the circuits (closed tracks with their balls) of a scene, first those of the first thread start.

    If a screw has no table [circulation], gaps in the row of its balls separate the circuits. A ball that leaves the
    loaded arc of such a circuit at one end enters it at once at the other end.

    Parameters
    ----------
    scene
        Screw or bearing.

    Raises
    ------
    CircuitError
        A loaded arc or a return is too short for its balls, loaded arcs overlap, or the balls cannot be shared equally.
    """
    loop = scene.circulation or Circulation()
    azimuths = np.sort(np.asarray(scene.balls.azimuths, dtype=float))
    ring = scene.track.lead == 0.0
    path = losses.ball_kinematics(scene, scene.motion or ONE_TURN, scene.balls.radius)
    spacing = groove.azimuth_between_touching_balls(path)
    if azimuths.size % loop.circuits:
        allowed = f"a number by which the {azimuths.size} balls of a thread start can be divided"
        raise CircuitError("circuits", allowed, "give all circuits of a thread start the same number of balls")
    apart = scene.circulation is None and not ring
    groups = np.split(azimuths, _first_balls_after_gaps(azimuths) if apart else loop.circuits)
    turns = None if loop.turns is None else 2.0 * np.pi * loop.turns / loop.circuits
    arcs = [2.0 * np.pi if ring else _loaded_arc_length(group, turns, spacing) for group in groups]
    middles = [0.5 * float(group[0] + group[-1]) for group in groups]
    for k in range(1, len(groups)):
        if middles[k] - middles[k - 1] < 0.5 * (arcs[k] + arcs[k - 1]) - CLOSE:
            most = len(groups) * float(np.min(np.diff(middles))) / (2.0 * np.pi)
            raise CircuitError("turns", f"up to {most:.6g}", "shorten the loaded arcs, so that they do not overlap")
    order, out, count = np.argsort(np.asarray(scene.balls.azimuths), kind="stable"), list[Circuit](), 0
    members = np.split(order, np.cumsum([group.size for group in groups])[:-1])
    for start in range(scene.track.starts):
        for k, group in enumerate(groups):
            number = members[k] + start * azimuths.size
            begin = float(group[0]) - 0.5 * spacing if ring else middles[k] - 0.5 * arcs[k]
            length = arcs[k] if ring else _track_length(loop, group.size, arcs[k], spacing, path.radius)
            back = begin + arcs[k] + (length - arcs[k]) * (np.arange(loop.returning) + 0.5) / max(loop.returning, 1)
            azimuth = np.append(group, back)
            ball = np.append(number, np.full(loop.returning, -1))
            balls = slice(count, count + ball.size)
            out.append(Circuit(ClosedTrack(start, begin, arcs[k], length, spacing, balls), azimuth, ball))
            count = balls.stop
    return tuple(out)


def _first_balls_after_gaps(azimuths: Array) -> Index:
    """Return the indices of the balls that follow a gap which separates two circuits.

    ``azimuths``: azimuths of the balls, in increasing order [rad].
    """
    apart = np.diff(azimuths)
    return np.flatnonzero(apart > APART * np.median(apart)) + 1 if apart.size else np.zeros(0, dtype=np.int64)


def _loaded_arc_length(group: Array, given_length: float | None, spacing: float) -> float:
    """Return the angular length of the loaded arc of one circuit, on which balls carry load [rad].

    The result is ``given_length``, the length that the scene states [rad]. If this is None, the result is the length that
    the balls fill, plus half the distance between neighbours beyond the first and beyond the last ball. ``group``: sorted
    azimuths of the balls on the arc [rad]; ``spacing``: difference of the azimuths of two balls that touch [rad], which is
    the length of an arc with a single ball. Raises CircuitError if the given arc is too short for its balls.
    """
    span = float(group[-1] - group[0])
    if given_length is None:
        return span * group.size / (group.size - 1) if group.size > 1 else spacing
    if given_length < span - CLOSE:
        allowed = f"at least {span / (2.0 * np.pi):.6g} turns for each circuit"
        raise CircuitError("turns", allowed, "increase the loaded turns, so that the balls of the scene fit into them")
    return given_length


def _track_length(loop: Circulation, loaded_count: int, arc: float, spacing: float, path_length_per_angle: float) -> float:
    """Return the length of a closed track, loaded arc and return together, as an azimuth [rad].

    ``loop``: contents of the scene's table [circulation], whose filling or gap determines the length; ``loaded_count``:
    number of balls on the loaded arc; ``arc``: length of the loaded arc [rad]; ``spacing``: difference of the azimuths of
    two balls that touch [rad]; ``path_length_per_angle``: length of the track per angle [m]. Raises CircuitError if the
    loaded arc and the return cannot hold their balls.
    """
    count = loaded_count + loop.returning
    if loop.filling is not None:
        length = count * spacing / loop.filling
    elif loop.gap is not None:
        length = count * (spacing + loop.gap / path_length_per_angle)
    else:
        return arc * count / loaded_count
    least = arc + loop.returning * spacing
    if length >= least - CLOSE:
        return max(length, least)
    advice = (
        "use fewer turns, more balls in the return or larger gaps between the balls: the circuit must be long enough for "
        "its loaded arc and for a return that holds its balls"
    )
    if loop.filling is not None:
        meaning = "fraction of a circuit's length that its balls would fill if they touched"
        raise CircuitError("filling", f"up to {count * spacing / least:.4g} ({meaning})", advice)
    smallest = f"{1e6 * path_length_per_angle * (least / count - spacing):.4g} um"
    raise CircuitError("gap", f"at least {smallest} between neighbouring balls on average", advice)


def nut_positions_at_start_and_end(scene: Scene) -> Array:
    """Return the axial positions of the nut on the screw at the start and the end of a simulation ``(2,)`` [m].

    Positions are measured from that at the start, so that the first one is 0.

    Parameters
    ----------
    scene
        Screw with the settings of a simulation over time; without such settings both positions are 0.
    """
    motion = scene.motion or ONE_TURN
    span = 0.0 if scene.time is None else scene.time.span(motion)
    turned = motion.speed * span * (-1.0 if motion.turns == "screw" else 1.0)
    return np.array([0.0, lead_per_radian(scene.track) * turned])


@dataclass(frozen=True)
class SceneBallChain(BallChain):
    """Balls of one closed track of a scene with their contact loads; radii and friction may differ from ball to ball."""

    #: Grooves of screw and nut without errors, with the speeds of both.
    groove: losses.BallKinematics
    #: Contact forces, angles and ellipses of the balls.
    static_contacts: StaticContacts

    def contact_wrenches(self, pull: Array) -> Array:
        """Return force, then moment of friction on the balls, along x3, y3, z3 each ``(N, 4, 6)`` [N, N m].

        x3 is radial, y3 along the track, z3 the binormal. ``pull``: friction in the axes of each contact ``(N, 4, 3)``:
        two forces [N] and the moment about the normal [N m].
        """
        turned = pull.copy()
        losses.rotate_to_groove_axes(self.static_contacts, turned)
        return super().contact_wrenches(turned)

    def input_power(self, wrench: Array) -> float:
        """Return the power that the motions of screw and nut supply against friction [W].

        ``wrench``: force (first three components) and moment of friction on the balls at each contact in x3 (radial),
        y3 (along the track), z3 (binormal) ``(N, 4, 6)`` [N, N m], from `contact_wrenches`.
        """
        axial, moment = axial_forces_and_moments(self.static_contacts, wrench)
        helical = moment + self.groove.advance_per_radian * axial
        return float(np.sum(helical * np.where(groove.ON_SCREW, self.groove.screw_speed, self.groove.nut_speed)))


def search_motion_on_track(
    scene: Scene,
    contacts: StaticContacts,
    slack: Array,
    friction: Friction,
    drive: Drive,
    start: tuple[Array, Array] | None = None,
) -> Search[ChainMotion]:
    """Return the motion of the balls of one closed track, in order of azimuth, and the forces between them.

    The contact loads are known. Two balls touch each other as two balls of nominal size do; their actual sizes only
    change the rate at which they may approach each other.

    Parameters
    ----------
    scene
        Screw or bearing.
    contacts
        Contact loads, angles and ellipses of the N balls of this track.
    slack
        Largest rate at which the difference of the azimuths of each ball and the next one may decrease ``(N,)`` [rad/s],
        infinite where they cannot touch.
    friction
        Coefficients of friction.
    drive
        Which part turns, screw or nut, and its angular speed.
    start
        First estimates: motions of the balls ``(N, 4)`` [rad/s], then forces between neighbours ``(N,)`` [N]. If None, the
        solution begins without estimates.

    Returns
    -------
    ChainMotion
        The motion; its field ``converged`` is False if no solution was found.
    """
    share, top = losses.relative_friction_coefficients(friction)
    rubs = losses.friction_contacts(scene, contacts, top * share, drive)
    grooves = losses.ball_kinematics(scene, drive, scene.balls.radius)
    chain = SceneBallChain(grooves, contacts.force, contacts.normals, slack, rubs, friction.between_balls, contacts)
    motion = yield from search_motion_of_chain(chain, start, True)
    for rows in (motion.contact_motions, motion.contact_friction):
        losses.rotate_to_groove_axes(contacts, rows)
    return motion


#: Sum of the gaps of a closed track [rad] below which it counts as full, so that the forces between its balls are not
#: determined.
FULL = 1e-9


@dataclass(frozen=True)
class BallsInCircuits:
    """All N balls of a scene in their circuits (closed tracks), in the order of the circuits."""

    #: Closed tracks of the circuits.
    tracks: tuple[ClosedTrack, ...]
    #: Radii of the balls ``(N,)`` [m].
    radius: Array
    #: Number of each ball in the scene ``(N,)``, -1 for a ball in the return.
    number: Index
    #: Azimuth of each ball in the nut's frame at the start ``(N,)`` [rad].
    azimuth: Array
    #: Difference of the azimuths that each ball and the next ball of its circuit have if the two touch ``(N,)`` [rad].
    spacing: Array
    #: Grooves of screw and nut without geometric errors.
    groove: losses.BallKinematics

    def gaps_to_next_balls(self, azimuth: Array) -> Array:
        """Return the gap between each ball and the next one of its circuit, as an azimuth ``(N,)`` [rad]; < 0: overlap.

        ``azimuth``: azimuths of the balls in the nut's frame ``(N,)`` [rad].
        """
        out = np.empty_like(azimuth)
        for track in self.tracks:
            balls = track.balls
            out[balls] = np.diff(azimuth[balls], append=azimuth[balls.start] + track.ring)
        return np.asarray(out - self.spacing)

    def fold_into_circuits(self, azimuth: Array) -> tuple[Array, Mask]:
        """Return the azimuths of all balls within one revolution of their circuits, then which are on a loaded arc.

        ``azimuth``: azimuths in the nut's frame ``(N,)`` [rad], which increase without bound as balls circulate.

        Returns
        -------
        tuple
            First the azimuths, on the helix of the first start, reduced to one revolution of each circuit ``(N,)`` [rad];
            then whether each ball is on its loaded arc ``(N,)``.
        """
        folded, loaded = np.empty_like(azimuth), np.zeros(azimuth.size, dtype=bool)
        for track in self.tracks:
            along = track.distances_from_arc_start(azimuth)
            folded[track.balls], loaded[track.balls] = track.loaded_arc_start + along, along < track.arc
        return folded, loaded

    def layout(self, scene: Scene, folded: Array, turned: float = 0.0) -> BallLayout:
        """Return azimuths, centres and section axes of all balls in fixed axes.

        ``scene``: the scene with these balls; ``folded``: azimuths of the balls within one revolution of their circuits
        ``(N,)`` [rad], the first value that `fold_into_circuits` returns; ``turned``: angle by which the nut has turned
        since the start [rad].
        """
        track, starts = scene.track, np.empty(folded.size)
        for loop in self.tracks:
            starts[loop.balls] = loop.start
        space = folded + turned + 2.0 * np.pi * starts / track.starts
        return ball_layout_at_positions(track, space, scene.nut.position + lead_per_radian(track) * (folded - track.phase))


def balls_in_circuits(scene: Scene, drive: Drive, drawn: ErrorsAfterDrawing, member: int = 0) -> BallsInCircuits:
    """Return the balls of a scene in their circuits (closed tracks) at the beginning of a simulation.

    Parameters
    ----------
    scene
        Screw or bearing.
    drive
        Which part turns, screw or nut, and its angular speed.
    drawn
        Random geometric errors of the balls and grooves.
    member
        Number of the draw of random errors, from which the random radii of the balls in the return follow.

    Raises
    ------
    CircuitError
        The circuits cannot hold their balls.
    ValueError
        Balls overlap, or a circuit has no gaps between its balls.
    """
    tracks, azimuths, numbers = zip(*circuits_of_scene(scene), strict=True)
    azimuth, number = np.concatenate(azimuths), np.concatenate(numbers)
    grooves = losses.ball_kinematics(scene, drive, scene.balls.radius)
    radius = np.where(number >= 0, drawn.ball_radii[np.maximum(number, 0)], 0.0)
    rng = np.random.default_rng([scene.errors.seed, member, 1])  # the draws of the scene's own balls stay what they are
    radius[number < 0] = draw_ball_radii(scene, rng, int(np.sum(number < 0)))
    excess, pair = radius - scene.balls.radius, grooves.pair
    spacing = np.empty_like(radius)
    for members in (track.balls for track in tracks):
        spacing[members] = pair.spacing + (excess[members] + np.roll(excess[members], -1)) / pair.closing_speed_factor
    balls = BallsInCircuits(tracks, radius, number, azimuth, spacing, grooves)
    gaps = balls.gaps_to_next_balls(azimuth)
    if gaps.min() < -FULL:
        raise ValueError(
            f"neighbouring balls overlap by {-1e6 * pair.closing_speed_factor * gaps.min():.3g} um at their starting "
            "positions; use smaller balls or larger angles between them"
        )
    for members in (track.balls for track in tracks):
        if members.stop - members.start > 1 and gaps[members].sum() < FULL:
            raise ValueError(
                "a circuit is full of balls, so that the forces between them are not determined; "
                "leave gaps between the balls"
            )
    return balls


#: Default motion of `contact_onset`: the nut turns at 1 rad/s.
NUT = Drive(1.0, "nut")

#: Ratio of the closing speed of neighbours to the speed of the turning part below which they count as not approaching.
CLOSING = 1e-9


@dataclass(frozen=True)
class ContactOnset:
    """Rotation after which neighbouring balls meet, estimated from a static state.

    There are N balls and M pairs of neighbours.
    """

    #: Angular speeds of the ball centres about the axis ``(N,)`` [rad/s]; for unloaded balls an assumed value.
    orbital_speeds: Array
    #: Sum of the contact loads of each ball ``(N,)`` [N].
    contact_load_sums: Array
    #: Numbers of the two balls of each pair of neighbours; the second ball is at the larger azimuth ``(M, 2)``.
    neighbour_pairs: Index
    #: Gap between the two balls of a pair, as an azimuth: zero if they touch ``(M,)`` [rad].
    pair_gaps: Array
    #: Rotation of screw or nut after which the two balls of a pair meet at their present speeds ``(M,)`` [rad]; infinite if
    #: they never meet.
    rotation_to_meeting: Array
    #: Rotation of screw or nut after which the leading ball of a pair has left its loaded arc, or the balls of a bearing
    #: have gone round once ``(M,)`` [rad].
    rotation_to_arc_end: Array
    #: Whether the friction forces are in balance on every ball.
    converged: bool

    @property
    def rotation_to_first_meeting(self) -> float:
        """Rotation of screw or nut after which the first two neighbouring balls meet [rad]; infinite if none do."""
        return float(self.rotation_to_meeting.min(initial=np.inf))

    @property
    def touches_under_load(self) -> bool:
        """Whether any two neighbours meet while both still carry load, at a rotation of at most ``rotation_to_arc_end``."""
        return bool(np.any(self.rotation_to_meeting <= self.rotation_to_arc_end))


def contact_onset(
    scene: Scene,
    result: StaticResult,
    unloaded_speed_ratio: float = 0.0,
    drive: Drive = NUT,
    orbital_speeds: Array | None = None,
) -> ContactOnset:
    """Return the rotation after which neighbouring balls begin to touch, estimated from a static load distribution.

    The method is that of section 4.3.2 of Lin's thesis, who argues from the loads: balls that lose contact stay behind,
    so that others run into them. Here each loaded ball moves with least dissipation at its static loads. The speeds are
    those at this instant; how the balls go on, and how their loads change, can only be computed by a transient
    simulation. The speeds do not depend on the coefficient of friction and are proportional to the speed of the
    rotating part.

    Parameters
    ----------
    scene, result
        The scene and its static result.
    unloaded_speed_ratio
        Angular speed of unloaded balls around the axis, as a ratio to the nominal one: with 0 they do not move, as Lin
        assumes; with 1 they roll along with the others.
    drive
        Which part turns, screw or nut, and its angular speed.
    orbital_speeds
        Orbital speeds of the balls at the static loads ``(N,)`` [rad/s], with friction in balance on every ball and equal
        coefficients of friction of screw and nut; None if they are not known.

    Raises
    ------
    ValueError
        The static loads did not converge, balls overlap, or the circuits cannot hold their balls.
    """
    path = losses.ball_kinematics(scene, drive, scene.balls.radius)
    speeds, converged = orbital_speeds, True
    if speeds is None:
        balls = losses.BallsUnderLoad(scene, contacts_of_result(scene, result, result.member), Friction(1.0, 1.0), drive)
        moved = losses.ball_friction(balls)
        speeds, converged = moved.orbital_speed, moved.converged
    carrying = result.load.sum(axis=1)
    orbit = np.where(carrying > 0.0, speeds, unloaded_speed_ratio * path.nominal_orbit)
    spacing, ring = groove.azimuth_between_touching_balls(path), scene.track.lead == 0.0
    pairs, gaps, leaving = [], [], []
    for track, azimuth, ball in circuits_of_scene(scene):
        here, number = azimuth[ball >= 0], ball[ball >= 0]
        after = np.append(here[1:], here[0] + 2.0 * np.pi)[: here.size if ring else -1]
        pair = np.column_stack([number, np.roll(number, -1)])[: after.size]
        along = orbit[pair] - path.nut_speed  # in the nut's frame, where the arcs are
        begin = track.loaded_arc_start
        left = np.where(along[:, 1] > 0.0, begin + track.arc - after, here[: after.size] - begin)
        leader = np.abs(np.where(along[:, 1] > 0.0, along[:, 1], along[:, 0]))
        pairs.append(pair)
        gaps.append(after - here[: after.size] - spacing)
        with np.errstate(divide="ignore"):
            leaving.append(np.full(after.size, 2.0 * np.pi / abs(path.nominal_orbit)) if ring else left / leader)
    pair, gap = np.concatenate(pairs), np.concatenate(gaps)
    if np.any(gap < -CLOSE):
        raise ValueError("neighbouring balls of the scene overlap; increase the angles between the balls")
    speed = abs(drive.speed)
    closing = orbit[pair[:, 0]] - orbit[pair[:, 1]]
    meets = closing > CLOSING * speed
    meeting = np.where(meets, np.maximum(gap, 0.0) * speed / np.where(meets, closing, 1.0), np.inf)
    return ContactOnset(orbit, carrying, pair, gap, meeting, speed * np.concatenate(leaving), converged)
