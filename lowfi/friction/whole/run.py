"""A screw or bearing in time: balls travel through circuits, loads are solved where they are; see ``screw.travel``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.friction.screw.groove import ON_SCREW
from rollbench.lowfi.friction.screw.track import Track
from rollbench.lowfi.friction.screw.travel import Instant, Place
from rollbench.lowfi.friction.whole.balls import Balls
from rollbench.lowfi.friction.whole.chain import SceneGrooves, chain_motion
from rollbench.lowfi.friction.whole.contacts import StaticContacts, contacts_at, spread
from rollbench.lowfi.friction.whole.feedback import feed_back, seats_at
from rollbench.lowfi.friction.whole.settings import feeds_back
from rollbench.lowfi.friction.whole.torque import about_axis
from rollbench.lowfi.statics.nominal import ContactLoads
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import Drawn, Specimen
from rollbench.meshes.helix import BallLayout, layout_at, reduced_lead
from rollbench.meshes.parts import Friction, Scene
from rollbench.meshes.parts import Motion as Drive

#: A static model: contact loads of balls with these errors at these places.
Solve = Callable[[Specimen, BallLayout], StaticResult | ContactLoads]


class Memory(NamedTuple):
    """Motions (N, 4) [rad/s] and forces (N,) [N] of the last instant, and its friction fed back (N, 3) [N]."""

    q: Array
    force: Array
    push: Array


@dataclass(frozen=True)
class Setting:
    """Constants of a run: parts, coefficients, motion, errors, balls, static model, kernels. A setting of
    ``travel``, azimuths in the nut's frame."""

    scene: Scene
    friction: Friction
    drive: Drive
    drawn: Drawn
    balls: Balls
    solve: Solve
    fast: bool = True

    def angles(self, time: float) -> tuple[float, float]:
        """Angles [rad] of screw and nut in space."""
        turned = self.drive.speed * time
        return (turned, 0.0) if self.drive.turns == "screw" else (0.0, turned)

    def contacts(self, azimuth: Array, time: float, push: Array, q: Array) -> tuple[StaticContacts, NDArray[np.bool_], str]:
        """Contacts of all N balls at azimuths (N,) in the nut's frame, which are on a loaded arc, and how loads ended.

        push (N, 3): forces of friction fed back in the step before, overwritten, q (N, 4): its motions; see ``feed_back``.
        """
        scene, track = self.scene, self.scene.track
        on_screw, on_nut = self.angles(time)
        folded, loaded = self.balls.place(azimuth)
        layout, on_arc = self.balls.layout(scene, folded, on_nut), np.flatnonzero(loaded)
        space, station = layout.azimuth[on_arc], layout.z[on_arc]
        arc_layout = layout_at(track, space, station)
        met = self.drawn.at(scene, space - on_screw, space - on_nut - scene.nut.azimuth, station, self.balls.radius[on_arc])
        result = self.solve(met, arc_layout)
        at, status = None, "converged" if result.converged else f"contact loads: {result.status}"
        if result.converged:
            at = contacts_at(scene, result, met, arc_layout)
            if feeds_back(scene, self.friction):
                place = seats_at(at, met, result.hertz_C)
                fed = feed_back(scene, at, place, self.friction, self.drive, self.fast, push[on_arc], q[on_arc])
                push[on_arc], at = fed.push, fed.at
                status = f"friction and place do not agree on {int(fed.failed.sum())} balls" if fed.failed.any() else status
        return spread(at, layout, on_arc, self.balls.radius, track.contact_angle), loaded, status

    @property
    def groove(self) -> SceneGrooves:
        """Nominal grooves in motion."""
        return self.balls.grooves

    @property
    def tracks(self) -> tuple[Track, ...]:
        """The closed tracks of the circuits."""
        return self.balls.tracks

    @property
    def spacing(self) -> Array:
        """Azimuth (N,) by which the next ball is ahead where both touch [rad]."""
        return self.balls.spacing

    @property
    def number(self) -> NDArray[np.int64]:
        """Numbers (N,) of the balls in the scene, -1 for those of the return."""
        return self.balls.number

    def begin(self) -> Place:
        """The scene's places, balls rolling at the nominal speed."""
        count, nut = self.balls.radius.size, self.groove.nut_speed
        nominal = self.groove.nominal_orbit - nut
        memory = Memory(np.tile([nominal + nut, 0.0, 0.0, 0.0], (count, 1)), np.zeros(count), np.zeros((count, 3)))
        gap = np.maximum(self.balls.gaps(self.balls.azimuth), 0.0)
        return Place(self.balls.azimuth, gap, np.full(count, nominal), memory)

    def to_end(self, azimuth: Array, omega: Array, time: float) -> float:  # noqa: ARG002 - the arcs stand in the nut
        """Time [s] until a ball passes an end of its loaded arc; inf for a bearing, which has none."""
        if self.scene.track.lead == 0.0:
            return np.inf
        return min(track.to_end(azimuth, omega) for track in self.tracks)

    def instant(self, azimuth: Array, time: float, slack: Array, memory: Memory) -> Instant | str:
        """Loads where the balls are, then their motions; azimuths (N,) in the nut's frame."""
        push = memory.push.copy()
        at, loaded, status = self.contacts(azimuth, time, push, memory.q)
        if status != "converged":
            return status
        moved = [
            chain_motion(
                self.scene,
                at.subset(members),
                slack[members] if members.stop - members.start > 1 else np.array([np.inf]),
                self.friction,
                self.drive,
                self.groove,
                (memory.q[members], memory.force[members]),
                self.fast,
            )
            for members in (track.balls for track in self.tracks)
        ]
        q, force, wrench = (np.concatenate([getattr(m, name) for m in moved]) for name in ("q", "ball_force", "wrench"))
        axial = -at.axial_force
        if feeds_back(self.scene, self.friction):  # contact forces that know of friction balance its axial force
            axial += float(np.einsum("nsi,ni->", wrench[:, ON_SCREW, :3], at.frames[:, :, 2]))
        groove, ball, closing = (sum(parts) for parts in zip(*(m.losses for m in moved), strict=True))
        return Instant(
            omega=q[:, 0] - self.groove.nut_speed,
            ball_force=force,
            load=at.force,
            loaded=loaded,
            losses=(groove, ball, closing),
            input_power=sum(m.input_power for m in moved),
            converged=all(m.converged for m in moved),
            memory=Memory(q, force, push),
            axial=axial,
            on_screw=_on_screw(self, at, wrench, axial),
        )


def _on_screw(setting: Setting, at: StaticContacts, wrench: Array, axial: float) -> float:
    """Torque [N m] about +z that drives the screw under the external axial load [N].

    Moments of contact forces and friction about the axis; an axial force of friction that the loads leave out is
    carried down the helix.
    """
    wrenches = wrench.copy()
    wrenches[..., :3] -= at.force[..., None] * at.normals
    along, moment = (float(component[:, ON_SCREW].sum()) for component in about_axis(at, wrenches))
    return moment + reduced_lead(setting.scene.track) * (along - axial)
