"""Circuits of the balls as angles of the track: loaded arcs and returns of a screw, or the one closed turn of a bearing."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.friction.screw.groove import contact_spacing
from rollbench.lowfi.friction.screw.track import Track
from rollbench.lowfi.friction.whole.losses import ball_path
from rollbench.lowfi.friction.whole.settings import ONE_TURN
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import reduced_lead
from rollbench.meshes.parts import Circulation, Scene

#: Angle [rad] by which arcs may overlap, and balls reach beyond them, before it counts.
CLOSE = 1e-9
#: Distance between neighbours over the median distance from which on a gap lies between two circuits.
APART = 1.5


class CircuitError(ValueError):
    """A circuit that cannot be: the key to blame, what is allowed, and what to do."""

    def __init__(self, key: str, allowed: str, advice: str) -> None:
        """Keep the three parts."""
        super().__init__(f"{key}: {allowed}; {advice}")
        self.key, self.allowed, self.advice = key, allowed, advice


class Circuit(NamedTuple):
    """One closed track, all angles [rad] azimuths of the nut on the helix of start 1; a bearing has arc = ring.

    azimuth (n,): of the balls at the beginning, in order, those of the return last; ball (n,): their numbers in the scene,
    -1 in the return.
    """

    track: Track
    azimuth: Array
    ball: NDArray[np.int64]


def circuits(scene: Scene) -> tuple[Circuit, ...]:
    """The circuits of a scene, those of the first start first.

    Without [circulation] the balls of a screw leave their loaded arc, from one gap to the next, at one end and enter it at
    the other at once. Raises CircuitError for arcs that do not hold their balls, or overlap, and for returns that do not
    hold theirs.
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
            out.append(Circuit(Track(start, begin, arcs[k], length, spacing, balls), azimuth, ball))
            count = balls.stop
    return tuple(out)


def _gaps(azimuths: Array) -> NDArray[np.int64]:
    """Numbers of the balls, in the order of their azimuths [rad], before which a gap between circuits lies."""
    apart = np.diff(azimuths)
    return np.flatnonzero(apart > APART * np.median(apart)) + 1 if apart.size else np.zeros(0, dtype=np.int64)


def _arc(group: Array, given: float | None, spacing: float) -> float:
    """Length of a loaded arc [rad]; ``given`` or as much as its balls fill, half a distance beyond the outer ones."""
    span = float(group[-1] - group[0])
    if given is None:
        return span * group.size / (group.size - 1) if group.size > 1 else spacing
    if given < span - CLOSE:
        allowed = f"at least {span / (2.0 * np.pi):.6g} turns for each circuit"
        raise CircuitError("turns", allowed, "the loaded arc must hold the balls that the scene places on it")
    return given


def _ring(loop: Circulation, loaded: int, arc: float, spacing: float, radius: float) -> float:
    """Length of the closed track [rad]; radius: length of the track per angle [m]."""
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
    """Places (2,) [m] of the nut along the screw at both ends of the scene's run, from where it is at the beginning."""
    motion = scene.motion or ONE_TURN
    span = 0.0 if scene.time is None else scene.time.span(motion)
    turned = motion.speed * span * (-1.0 if motion.turns == "screw" else 1.0)
    return np.array([0.0, reduced_lead(scene.track) * turned])
