"""Section 4.2.1: axial and conical lash of one screw with its balls at four sets of places."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rollbench.comparison.measure import error_percent
from rollbench.lowfi.statics.static import solve_static
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import reduced_lead
from rollbench.meshes.parts import Load, Scene, Support

#: Greatest force of the axial lash test [N]; that of the conical one is not printed, and taken to be the same.
FORCE = 200.0
#: Loaded track of Table 4.1 [turns], and directions of the lateral force [rad]: each with its opposite.
TURNS, DIRECTIONS = 3.75, np.radians([0.0, 45.0, 90.0, 135.0])
#: Freedoms of the screw's left end that are held: turning only.
TURNING = ("rz",)
PATTERNS = ("evenly distributed", "stacked on one end", "stacked on one side", "half-half")


def places(scene: Scene, pattern: str) -> tuple[float, ...]:
    """Azimuths [rad] of the balls in a pattern of figure 4.2, those that are stacked touching one another.

    One side is where the axes of x and of the balls meet; at the other the gap is left in every turn.
    """
    n, track = scene.ball_count, scene.track
    full = 2.0 * np.pi * TURNS
    if pattern == "evenly distributed":
        return tuple(full * ((np.arange(n) + 0.5) / n - 0.5))
    step = 2.0 * scene.balls.radius * (1.0 + 1e-9) / float(np.hypot(track.pitch_radius, reduced_lead(track)))
    free = full - step * n
    at = -0.5 * full + step * (np.arange(n) + 0.5)
    if pattern == "stacked on one end":
        return tuple(at)
    if pattern == "half-half":
        return tuple(np.where(np.arange(n) < n // 2, at, at + free))
    gaps = np.pi * np.array([k for k in range(-9, 10, 2) if abs(k) < TURNS])
    wide = free / gaps.size
    out = at.copy()
    for gap in gaps:
        out = np.where(out > gap - 0.5 * wide, out + wide, out)
    return tuple(out)


def with_balls(scene: Scene, pattern: str) -> Scene:
    """The screw with its balls at the places of a pattern."""
    return replace(scene, balls=replace(scene.balls, azimuths=places(scene, pattern)))


def held_at_left(freedoms: Sequence[str]) -> tuple[Support, ...]:
    """Support of the screw's left end: the freedoms that are held."""
    return (Support(0.0, tuple((name, 0.0) for name in freedoms)),)


def axial(scene: Scene, held: Sequence[str] = TURNING) -> float:
    """Peak-to-peak displacement [m] of the screw's left end under +-FORCE along its axis, some freedoms held there."""
    low, high = axial_curve(scene, (-FORCE, FORCE), held)
    return high - low


def axial_curve(scene: Scene, forces: Sequence[float], held: Sequence[str] = TURNING) -> list[float]:
    """Displacement [m] of the screw's left end along its axis under forces [N] along it."""
    base = replace(scene, supports=held_at_left(held))
    return [float(_moved(replace(base, loads=(Load(0.0, (0.0, 0.0, f)),)))[0, 2]) for f in forces]


def conical(scene: Scene, direction: float, reach: float, held: Sequence[str] = TURNING) -> float:
    """Peak-to-peak displacement [m] along +-FORCE across the screw, ``reach`` [m] to the right of the nut's centre."""
    low, high = conical_curve(scene, (-FORCE, FORCE), direction, reach, held)
    return high - low


def conical_curve(
    scene: Scene, forces: Sequence[float], direction: float, reach: float, held: Sequence[str] = TURNING
) -> list[float]:
    """Displacement [m] along forces [N] across the screw in a direction [rad], ``reach`` [m] to the right of the nut."""
    at = scene.nut.position + reach
    across = np.array([np.cos(direction), np.sin(direction)])
    base, found = replace(scene, supports=held_at_left(held)), []
    for f in forces:
        x, y = f * across
        moved = solve_static(replace(base, loads=(Load(at, (float(x), float(y), 0.0)),)), engine="compiled")
        where = [np.interp(at, moved.centreline_z, moved.centreline[:, k]) for k in (0, 1)]
        found.append(float(across @ np.array(where)))
    return found


def _moved(scene: Scene) -> Array:
    return solve_static(scene, engine="compiled").centreline


def difference(values: list[float]) -> float:
    """(largest - smallest) / smallest [%] over the patterns: the definition that fits the printed axial one best."""
    return float(error_percent(max(values), min(values)))


@dataclass(frozen=True)
class Lash:
    """Differences [%] over the patterns: of the axial lash, and of the conical one by direction."""

    axial: float
    conical: tuple[float, ...]


def lash(scene: Scene, reach: float, held: Sequence[str] = TURNING) -> Lash:
    """Both tests of a screw, the lateral force at a distance [m] from the nut; held: freedoms of the screw's left end."""
    screws = [with_balls(scene, p) for p in PATTERNS]
    cones = tuple(difference([conical(s, d, reach, held) for s in screws]) for d in DIRECTIONS)
    return Lash(difference([axial(s, held) for s in screws]), cones)
