"""Balls of a scene in their circuits: positions, gaps between neighbours, and how they push each other along the track.

Circuits are angles of the track: loaded arcs and returns of a screw, or the one closed turn of a bearing.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.friction.screw.chain import AnyChain, ChainMotion, FrictionContacts, solve_chain
from rollbench.lowfi.friction.screw.groove import ON_SCREW, Constants, Grooved, contact_spacing
from rollbench.lowfi.friction.screw.travel import ClosedTrack
from rollbench.lowfi.friction.whole.contacts import StaticContacts, contacts_of_result
from rollbench.lowfi.friction.whole.losses import BallPath, ball_friction, ball_path, rubs_of, shares, turn_back
from rollbench.lowfi.friction.whole.torque import ONE_TURN, about_axis
from rollbench.lowfi.jit import CONTACT, is_copy_loaded
from rollbench.lowfi.statics.contacts import error_free_hertz
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import Drawn, draw_ball_radii
from rollbench.meshes.helix import BallLayout, layout_at, reduced_lead
from rollbench.meshes.parts import Circulation, Friction, Scene
from rollbench.meshes.parts import Motion as Drive

#: Angle [rad] by which arcs may overlap, and balls reach beyond them, before it counts.
CLOSE = 1e-9

#: Distance between neighbours over the median distance from which on a gap lies between two circuits.
APART = 1.5


class CircuitError(ValueError):
    """Error for an impossible circuit: the key to change, the allowed values, and advice."""

    def __init__(self, key: str, allowed: str, advice: str) -> None:
        """Store the three parts."""
        super().__init__(f"{key}: {allowed}; {advice}")
        self.key, self.allowed, self.advice = key, allowed, advice


class Circuit(NamedTuple):
    """One closed track with n balls, all angles azimuths of the nut on the helix of start 1; a bearing has arc = ring."""

    #: The track.
    track: ClosedTrack
    #: Azimuth of the balls at the beginning, in order, those of the return last ``(n,)`` [rad].
    azimuth: Array
    #: Numbers of these balls in the scene ``(n,)``, -1 in the return.
    ball: NDArray[np.int64]


def circuits(scene: Scene) -> tuple[Circuit, ...]:
    """Return the circuits of a scene, those of the first start first.

    Without [circulation] the balls of a screw leave their loaded arc, from one gap to the next, at one end and enter it at
    the other at once.

    Parameters
    ----------
    scene
        Screw or bearing.

    Raises
    ------
    CircuitError
        Arcs that do not fit their balls or overlap, or returns that do not fit theirs.
    """
    loop = scene.circulation or Circulation()
    azimuths = np.sort(np.asarray(scene.balls.azimuths, dtype=float))
    ring = scene.track.lead == 0.0
    path = ball_path(scene, scene.motion or ONE_TURN, scene.balls.radius)
    spacing = contact_spacing(path)
    if azimuths.size % loop.circuits:
        allowed = f"a number that divides the {azimuths.size} balls of a start"
        raise CircuitError("circuits", allowed, "circuits share the balls of their start equally")
    apart = scene.circulation is None and not ring
    groups = np.split(azimuths, _gaps(azimuths) if apart else loop.circuits)
    turns = None if loop.turns is None else 2.0 * np.pi * loop.turns / loop.circuits
    arcs = [2.0 * np.pi if ring else _arc(group, turns, spacing) for group in groups]
    middles = [0.5 * float(group[0] + group[-1]) for group in groups]
    for k in range(1, len(groups)):
        if middles[k] - middles[k - 1] < 0.5 * (arcs[k] + arcs[k - 1]) - CLOSE:
            most = len(groups) * float(np.min(np.diff(middles))) / (2.0 * np.pi)
            raise CircuitError("turns", f"up to {most:.6g}", "the loaded arcs of neighbouring circuits would overlap")
    order, out, count = np.argsort(np.asarray(scene.balls.azimuths), kind="stable"), list[Circuit](), 0
    members = np.split(order, np.cumsum([group.size for group in groups])[:-1])
    for start in range(scene.track.starts):
        for k, group in enumerate(groups):
            number = members[k] + start * azimuths.size
            begin = float(group[0]) - 0.5 * spacing if ring else middles[k] - 0.5 * arcs[k]
            length = arcs[k] if ring else _ring(loop, group.size, arcs[k], spacing, path.radius)
            back = begin + arcs[k] + (length - arcs[k]) * (np.arange(loop.returning) + 0.5) / max(loop.returning, 1)
            azimuth = np.append(group, back)
            ball = np.append(number, np.full(loop.returning, -1))
            balls = slice(count, count + ball.size)
            out.append(Circuit(ClosedTrack(start, begin, arcs[k], length, spacing, balls), azimuth, ball))
            count = balls.stop
    return tuple(out)


def _gaps(azimuths: Array) -> NDArray[np.int64]:
    """Return the numbers of the balls, in the order of their azimuths [rad], before which a gap between circuits lies."""
    apart = np.diff(azimuths)
    return np.flatnonzero(apart > APART * np.median(apart)) + 1 if apart.size else np.zeros(0, dtype=np.int64)


def _arc(group: Array, given: float | None, spacing: float) -> float:
    """Return length of a loaded arc [rad]: ``given``, or as much as its balls fill, half a distance beyond outer ones."""
    span = float(group[-1] - group[0])
    if given is None:
        return span * group.size / (group.size - 1) if group.size > 1 else spacing
    if given < span - CLOSE:
        allowed = f"at least {span / (2.0 * np.pi):.6g} turns for each circuit"
        raise CircuitError("turns", allowed, "the loaded arc must hold the balls that the scene places on it")
    return given


def _ring(loop: Circulation, loaded: int, arc: float, spacing: float, radius: float) -> float:
    """Return the length of the closed track [rad]; radius: length of the track per angle [m]."""
    count = loaded + loop.returning
    if loop.filling is not None:
        length = count * spacing / loop.filling
    elif loop.gap is not None:
        length = count * (spacing + loop.gap / radius)
    else:
        return arc * count / loaded
    least = arc + loop.returning * spacing
    if length >= least - CLOSE:
        return max(length, least)
    advice = "the loaded arc and the return must hold their balls: fewer turns, more balls in the return, or more clearance"
    if loop.filling is not None:
        raise CircuitError("filling", f"up to {count * spacing / least:.4g}", advice)
    raise CircuitError("gap", f"at least {1e6 * radius * (least / count - spacing):.4g} um", advice)


def travel(scene: Scene) -> Array:
    """Return positions of the nut along the screw at both ends of the scene's run ``(2,)`` [m], from its first position.

    Parameters
    ----------
    scene
        Screw with a run in time.
    """
    motion = scene.motion or ONE_TURN
    span = 0.0 if scene.time is None else scene.time.span(motion)
    turned = motion.speed * span * (-1.0 if motion.turns == "screw" else 1.0)
    return np.array([0.0, reduced_lead(scene.track) * turned])


@dataclass(frozen=True, eq=False)
class SceneGrooves(BallPath, Grooved):
    """Nominal grooves of a scene in motion, one for a whole run: kernels cache arrays by it."""

    #: Largest coefficient of friction.
    mu: float
    #: Hertz constants of nominal contacts.
    hertz: Constants = field(repr=False)

    @property
    def constants(self) -> Constants:
        """Hertz constants of nominal contacts."""
        return self.hertz


def grooves_of(scene: Scene, friction: Friction, drive: Drive) -> SceneGrooves:
    """Return the nominal grooves of a scene whose screw or nut turns."""
    path, h = ball_path(scene, drive, scene.balls.radius), error_free_hertz(scene)
    return SceneGrooves(**asdict(path), mu=max(friction.screw, friction.nut), hertz=Constants(h.C, h.C_a, h.C_b))


@dataclass(frozen=True)
class SceneChain(AnyChain):
    """Balls of different sizes and coefficients."""

    #: Contacts of the balls.
    at: StaticContacts
    #: The contacts as friction needs them.
    contacts: FrictionContacts
    #: Coefficient of friction from ball to ball.
    between: float

    @property
    def friction_contacts(self) -> FrictionContacts:
        """Return the contacts with their semi-axes and maps."""
        return self.contacts

    @property
    def mu_balls(self) -> float:
        """Return the coefficient of friction from ball to ball."""
        return self.between

    def wrench(self, pull: Array) -> Array:
        """Return friction on the balls in x3, y3, z3 ``(N, 4, 6)`` of forces in the contacts' axes ``(N, 4, 3)``."""
        turned = pull.copy()
        turn_back(self.at, turned)
        return super().wrench(turned)

    def input_power(self, wrench: Array) -> float:
        """Return the power of screw and nut, from forces and moments about the axis in space [W]."""
        axial, moment = about_axis(self.at, wrench)
        helical = moment + self.groove.ratio * axial
        return float(np.sum(helical * np.where(ON_SCREW, self.groove.screw_speed, self.groove.nut_speed)))


def chain_motion(
    scene: Scene,
    at: StaticContacts,
    slack: Array,
    friction: Friction,
    drive: Drive,
    grooves: SceneGrooves,
    start: tuple[Array, Array] | None = None,
    fast: bool = True,
) -> ChainMotion:
    """Return the motion of the balls of one closed track, in order of azimuth, and the forces between them.

    The contact of two balls is that of nominal ones; their sizes count in the slack.

    Parameters
    ----------
    scene, at
        The scene and the contacts of its balls.
    slack
        As in `AnyChain` ``(N,)``.
    friction, drive
        Coefficients, and the motion of screw or nut.
    grooves
        Nominal grooves.
    start
        Motions ``(N, 4)`` [rad/s] and forces ``(N,)`` [N] to begin from.
    fast
        Whether to use compiled kernels.

    Returns
    -------
    ChainMotion
        The motion; see ``converged`` for a failure.
    """
    share, top = shares(friction)
    rubs = rubs_of(scene, at, top * share, drive)
    motion = solve_chain(
        SceneChain(grooves, at.force, at.normals, slack, at, rubs, friction.between_balls), start, fast, True
    )
    for rows in (motion.seen, motion.pull):
        turn_back(at, rows)
    return motion


#: Sum of gaps [rad] below which a closed track is full: forces between its balls are not determined.
FULL = 1e-9


@dataclass(frozen=True)
class Balls:
    """All N balls of a scene, circuit after circuit."""

    #: Tracks of the circuits.
    tracks: tuple[ClosedTrack, ...]
    #: ``(N,)`` [m].
    radius: Array
    #: Number of the ball in the scene ``(N,)``, -1 in the return.
    number: NDArray[np.int64]
    #: Azimuth in the nut's frame at the start ``(N,)`` [rad].
    azimuth: Array
    #: Azimuth by which the next ball of a circuit is ahead where they touch ``(N,)`` [rad].
    spacing: Array
    #: Nominal grooves.
    grooves: SceneGrooves

    def gaps(self, azimuth: Array) -> Array:
        """Return the gaps to the next ball of the circuit ``(N,)`` [rad] at azimuths ``(N,)``."""
        out = np.empty_like(azimuth)
        for track in self.tracks:
            balls = track.balls
            out[balls] = np.diff(azimuth[balls], append=azimuth[balls.start] + track.ring)
        return np.asarray(out - self.spacing)

    def place(self, azimuth: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Return azimuths on helix of start 1 folded into the circuits ``(N,)``, and which balls are on a loaded arc."""
        folded, loaded = np.empty_like(azimuth), np.zeros(azimuth.size, dtype=bool)
        for track in self.tracks:
            along = track.along(azimuth)
            folded[track.balls], loaded[track.balls] = track.first + along, along < track.arc
        return folded, loaded

    def layout(self, scene: Scene, folded: Array, turned: float = 0.0) -> BallLayout:
        """Return the positions of all balls at azimuths ``folded`` ``(N,)`` of `place`, where the nut has turned [rad]."""
        track, starts = scene.track, np.empty(folded.size)
        for loop in self.tracks:
            starts[loop.balls] = loop.start
        space = folded + turned + 2.0 * np.pi * starts / track.starts
        return layout_at(track, space, scene.nut.position + reduced_lead(track) * (folded - track.phase))


def balls_of(scene: Scene, friction: Friction, drive: Drive, drawn: Drawn, member: int = 0) -> Balls:
    """Return the balls of a scene in their circuits at the beginning.

    Parameters
    ----------
    scene
        Screw or bearing.
    friction
        Coefficients of friction.
    drive
        Motion of screw and nut.
    drawn
        Drawn errors of balls and grooves.
    member
        Number of the specimen.

    Raises
    ------
    CircuitError
        Impossible circuits.
    ValueError
        Balls that overlap, or a circuit without clearance.
    """
    tracks, azimuths, numbers = zip(*circuits(scene), strict=True)
    azimuth, number = np.concatenate(azimuths), np.concatenate(numbers)
    grooves = grooves_of(scene, friction, drive)
    radius = np.where(number >= 0, drawn.ball_radius[np.maximum(number, 0)], 0.0)
    rng = np.random.default_rng([scene.errors.seed, member, 1])  # the draws of the scene's own balls stay what they are
    radius[number < 0] = draw_ball_radii(scene, rng, int(np.sum(number < 0)))
    excess, pair = radius - scene.balls.radius, grooves.pair
    spacing = np.empty_like(radius)
    for members in (track.balls for track in tracks):
        spacing[members] = pair.spacing + (excess[members] + np.roll(excess[members], -1)) / pair.closing
    balls = Balls(tracks, radius, number, azimuth, spacing, grooves)
    gaps = balls.gaps(azimuth)
    if gaps.min() < -FULL:
        raise ValueError(f"balls overlap by {-1e6 * pair.closing * gaps.min():.3g} um where the run begins")
    for members in (track.balls for track in tracks):
        if members.stop - members.start > 1 and gaps[members].sum() < FULL:
            raise ValueError("a circuit without any clearance: forces between its balls are not determined")
    return balls


#: Motion in which the onset is given.
NUT = Drive(1.0, "nut")

#: Closing speed over that of the part that turns below which neighbours do not close in.
CLOSING = 1e-9


@dataclass(frozen=True)
class Onset:
    """Time until neighbours of a static state meet: N balls, M pairs of neighbours in their circuits."""

    #: Angular speeds ``(N,)`` [rad/s], of unloaded balls as assumed.
    orbit: Array
    #: Sums of contact loads ``(N,)`` [N].
    loaded: Array
    #: Numbers of the balls, the second at the larger azimuth ``(M, 2)``.
    pair: NDArray[np.int64]
    #: Gap between the two balls of a pair ``(M,)`` [rad].
    gap: Array
    #: Angle of the rotating part at which they meet at these speeds ``(M,)`` [rad]; inf: never.
    meeting: Array
    #: Angle at which the leading one has left its loaded arc, or the balls of a bearing have gone round once ``(M,)``
    #: [rad].
    leaving: Array
    #: Whether friction balances on every ball.
    converged: bool

    @property
    def first(self) -> float:
        """Angle of the rotating part at which the first neighbours meet [rad]."""
        return float(self.meeting.min(initial=np.inf))

    @property
    def touch(self) -> bool:
        """Whether any neighbours meet while they are neighbours under load."""
        return bool(np.any(self.meeting <= self.leaving))


def contact_onset(scene: Scene, result: StaticResult, idle: float = 0.0, drive: Drive = NUT) -> Onset:
    """Return the onset of ball-to-ball contact from a static load distribution (Lin 4.3.2).

    Lin argues from the loads: balls that lose contact stay behind, so that others run into them. Here each loaded ball
    moves with least dissipation at its static loads. Speeds are those of the moment: where balls go as they roll, and how
    loads follow, needs a run in time. They do not depend on the coefficient of friction and are proportional to the speed
    of the rotating part.

    Parameters
    ----------
    scene, result
        The scene and its static result.
    idle
        Orbit of unloaded balls over the nominal one: 0, they do not move, as Lin assumes; 1, they roll along.
    drive
        Motion of screw or nut.

    Raises
    ------
    ValueError
        Loads that did not converge, balls that overlap, or impossible circuits.
    """
    path = ball_path(scene, drive, scene.balls.radius)
    balls = ball_friction(scene, contacts_of_result(scene, result), Friction(1.0, 1.0), drive, fast=is_copy_loaded(CONTACT))
    carrying = result.load.sum(axis=1)
    orbit = np.where(carrying > 0.0, balls.orbit, idle * path.nominal_orbit)
    spacing, ring = contact_spacing(path), scene.track.lead == 0.0
    pairs, gaps, leaving = [], [], []
    for track, azimuth, ball in circuits(scene):
        here, number = azimuth[ball >= 0], ball[ball >= 0]
        after = np.append(here[1:], here[0] + 2.0 * np.pi)[: here.size if ring else -1]
        pair = np.column_stack([number, np.roll(number, -1)])[: after.size]
        along = orbit[pair] - path.nut_speed  # in the nut's frame, where the arcs are
        left = np.where(along[:, 1] > 0.0, track.first + track.arc - after, here[: after.size] - track.first)
        leader = np.abs(np.where(along[:, 1] > 0.0, along[:, 1], along[:, 0]))
        pairs.append(pair)
        gaps.append(after - here[: after.size] - spacing)
        with np.errstate(divide="ignore"):
            leaving.append(np.full(after.size, 2.0 * np.pi / abs(path.nominal_orbit)) if ring else left / leader)
    pair, gap = np.concatenate(pairs), np.concatenate(gaps)
    if np.any(gap < -CLOSE):
        raise ValueError("the balls of the scene overlap")
    speed = abs(drive.speed)
    closing = orbit[pair[:, 0]] - orbit[pair[:, 1]]
    meets = closing > CLOSING * speed
    meeting = np.where(meets, np.maximum(gap, 0.0) * speed / np.where(meets, closing, 1.0), np.inf)
    return Onset(orbit, carrying, pair, gap, meeting, speed * np.concatenate(leaving), balls.converged)
