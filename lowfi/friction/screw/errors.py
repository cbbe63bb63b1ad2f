"""What a static load distribution with geometric errors means for ball-to-ball contact (Lin 4.3.2).

The source argues from the loads: balls that lose contact stay behind, so that others run into them. Here each loaded
ball moves with least dissipation at its static loads; how an unloaded one moves is a parameter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.lowfi.friction.screw.groove import ScrewGroove
from rollbench.lowfi.friction.screw.motion import ball_motion
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import Scene


@dataclass(frozen=True)
class Onset:
    """How soon balls of a static state meet, N balls in order of azimuth.

    orbit (N,): angular speed over the nut's; loaded (N,): sum of contact forces [N]; gap: between neighbours at even
    spacing [rad]; meeting (N-1,): nut angle [rad] at which neighbours meet at these speeds (inf: never); converged: loads
    and motions.
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


def groove_of(scene: Scene) -> ScrewGroove:
    """The grooves of a right-hand scene with one groove radius and material; coefficient of friction 1, nut at 1 rad/s.

    Orbits of least dissipation do not depend on the coefficient and are proportional to the speed.

    Raises ValueError for other scenes.
    """
    screw, nut, balls = scene.screw, scene.nut, scene.balls
    if screw.groove_radius != nut.groove_radius or screw.material != nut.material != balls.material:
        raise ValueError("friction needs one groove radius and one material")
    if scene.track.hand != "right" or scene.track.starts != 1:
        raise ValueError("friction needs a right-hand screw with a single start")
    return ScrewGroove(
        balls.radius,
        screw.groove_radius,
        scene.track.pitch_radius,
        scene.track.lead,
        scene.track.contact_angle,
        screw.material.youngs_modulus,
        screw.material.poissons_ratio,
        mu=1.0,
        nut_speed=1.0,
    )


def contact_onset(scene: Scene, result: StaticResult, idle: float = 0.0) -> Onset:
    """Onset of ball-to-ball contact from static loads (N, 4); idle: orbit of unloaded balls over the nominal one.

    idle = 0: they do not move, as the source assumes; 1: they roll along. Speeds are those of the moment: where balls
    go as they roll, and how loads follow, is the matter of a run in time. Raises ValueError for balls that do not fit.
    """
    groove = groove_of(scene)
    order = np.argsort(result.azimuth)
    load = result.load[order]
    angle = np.where(np.isnan(result.contact_angle[order]), groove.contact_angle, result.contact_angle[order])
    loaded = load.sum(axis=1)
    orbit = np.full(load.shape[0], idle * groove.nominal_orbit)
    good = result.status == "converged"
    for k in np.flatnonzero(loaded > 0.0):
        ball = ball_motion(groove, load[k], angle[k])
        orbit[k] = ball.motion.q[0]
        good = good and ball.motion.status != "failed"
    gap = float(np.min(np.diff(result.azimuth[order]))) - groove.pair.spacing
    if gap < 0.0:
        raise ValueError("the balls of the scene overlap")
    closing = orbit[:-1] - orbit[1:]
    meets = closing > 1e-9
    meeting = np.where(meets, gap / np.where(meets, closing, 1.0), np.inf)
    return Onset(orbit=orbit, loaded=loaded, gap=gap, meeting=meeting, converged=good)
