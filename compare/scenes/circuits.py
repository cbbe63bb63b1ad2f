"""Balls of the circuits that a scene file describes: how many fill one, and where all of them stand."""

from __future__ import annotations

from math import floor, hypot, pi, sin

from rollbench.comparison.scenes.schema import BallKeys, TrackKeys


def balls_of_circuit(balls: BallKeys, track: TrackKeys) -> int:
    """Balls of one circuit: the count shared, or as many as fill the part of its turns that is asked for, at least one."""
    if balls.count is not None:
        return balls.count // (track.starts * balls.circuits)
    touching = touching_angle(track.pitch_radius, track.lead, 2.0 * balls.radius)
    return max(1, floor((balls.filling or 0.0) * 2.0 * pi * (balls.turns or 1.0) / touching + 1e-9))


def touching_angle(radius: float, lead: float, ball: float) -> float:
    """Angle [rad] between neighbours on a helix (radius, lead [m]) that touch: their chord is the ball's diameter [m].

    chord^2 = (2 R sin(phi/2))^2 + (lead phi / 2 pi)^2; half a turn where even that is shorter than a ball.
    """
    from rollbench.meshes.roots import brentq

    def gap(angle: float) -> float:
        return hypot(2.0 * radius * sin(angle / 2.0), lead * angle / (2.0 * pi)) - ball

    return float(brentq(gap, 0.0, pi, xtol=1e-14)) if gap(pi) > 0.0 else pi


def ball_total(balls: BallKeys, track: TrackKeys) -> int:
    """Number of balls over all starts and circuits."""
    return balls.count or balls_of_circuit(balls, track) * balls.circuits * track.starts


def azimuths(balls: BallKeys, track: TrackKeys) -> tuple[float, ...]:
    """Azimuths of one start [rad]: the balls of a circuit evenly over its turns, circuits centred on the nut with gaps."""
    n = balls_of_circuit(balls, track)
    turns = balls.turns or 1.0
    spacing, pitch = 2.0 * pi * turns / n, 2.0 * pi * (turns + (balls.circuit_gap or 0.0))
    middles = (track.phase + (k - (balls.circuits - 1) / 2.0) * pitch for k in range(balls.circuits))
    return tuple(middle + (i - (n - 1) / 2.0) * spacing for middle in middles for i in range(n))
