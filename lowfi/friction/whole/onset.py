"""What a static load distribution with geometric errors means for ball-to-ball contact (Lin 4.3.2).

The source argues from the loads: balls that lose contact stay behind, so that others run into them. Here each loaded
ball moves with least dissipation at its static loads; how an unloaded one moves is a parameter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.lowfi.friction.screw.groove import contact_spacing
from rollbench.lowfi.friction.whole.contacts import contacts_of
from rollbench.lowfi.friction.whole.losses import ball_friction, ball_path
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import Friction, Motion, Scene

#: Motion in which the onset is told.
NUT = Motion(1.0, "nut")


@dataclass(frozen=True)
class Onset:
    """How soon balls of a static state meet, N balls in order of azimuth.

    orbit (N,): angular speed over the nut's; loaded (N,): sum of contact forces [N]; gap: between neighbours at even
    spacing [rad]; meeting (N-1,): nut angle [rad] at which neighbours meet at these speeds (inf: never).
    """

    orbit: Array
    loaded: Array
    gap: float
    meeting: Array
    converged: bool

    @property
    def first(self) -> float:
        """Nut angle [rad] at which the first neighbours meet."""
        return float(self.meeting.min(initial=np.inf))


def contact_onset(scene: Scene, result: StaticResult, idle: float = 0.0) -> Onset:
    """Onset of ball-to-ball contact at static loads, nut at 1 rad/s; idle: orbit of unloaded balls over the nominal one.

    idle = 0: they do not move, as the source assumes; 1: they roll along. Speeds are those of the moment: where balls
    go as they roll, and how loads follow, is the matter of a run in time. They do not depend on the coefficient of friction
    and are proportional to the nut's speed. Raises ValueError for several starts, loads that did not converge, and balls
    that do not fit.
    """
    if scene.track.starts != 1:
        raise ValueError("onset of contact needs a screw with a single start")
    path, order = ball_path(scene, NUT, scene.balls.radius), np.argsort(result.azimuth)
    balls = ball_friction(scene, contacts_of(scene, result), Friction(1.0, 1.0), NUT, fast=True)
    loaded = result.load[order].sum(axis=1)
    orbit = np.where(loaded > 0.0, balls.orbit[order], idle * path.nominal_orbit)
    gap = float(np.min(np.diff(result.azimuth[order]))) - contact_spacing(path)
    if gap < 0.0:
        raise ValueError("the balls of the scene overlap")
    closing = orbit[:-1] - orbit[1:]
    meets = closing > 1e-9
    meeting = np.where(meets, gap / np.where(meets, closing, 1.0), np.inf)
    return Onset(orbit=orbit, loaded=loaded, gap=gap, meeting=meeting, converged=balls.converged)
