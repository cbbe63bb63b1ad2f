"""Simulation of a screw or bearing over time: contact loads and friction of its balls at any positions in their circuits.

The balls travel by ``lowfi.friction.screw.travel``. Contact loads are solved at every instant, while the compliance of
screw and nut between the contacts changes slowly.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import NamedTuple

import numpy as np

from rollbench.lowfi.compliance.bodies import compliance_between_contacts
from rollbench.lowfi.compliance.parts import REFINED, ComplianceModel
from rollbench.lowfi.friction.screw.chain import ChainMotion
from rollbench.lowfi.friction.screw.groove import ON_SCREW
from rollbench.lowfi.friction.screw.travel import BallState, InstantSolution
from rollbench.lowfi.friction.whole.circuit import BallsInCircuits, search_motion_on_track
from rollbench.lowfi.friction.whole.contacts import StaticContacts, contacts_of_all_balls, contacts_of_solution
from rollbench.lowfi.friction.whole.feedback import (
    DisplacedBalls,
    positions_in_grooves_with_errors,
    solve_friction_equilibria,
)
from rollbench.lowfi.friction.whole.losses import BallsUnderLoad
from rollbench.lowfi.friction.whole.torque import axial_forces_and_moments, friction_displaces_balls
from rollbench.lowfi.statics.nominal import ContactLoads, contact_loads
from rollbench.lowfi.statics.result import StaticResult
from rollbench.lowfi.together import Search, SideBySide
from rollbench.meshes.arrays import Array, Mask
from rollbench.meshes.errors import ErrorsAfterDrawing, GeometryWithErrors
from rollbench.meshes.helix import BallLayout, ball_layout_at_positions, lead_per_radian
from rollbench.meshes.parts import Friction, Scene, Track
from rollbench.meshes.parts import Motion as Drive

#: Lengths of a window of `TravellingCompliance` [rad], usual and least; distance by which balls may lie outside the ends of
#: a window, as a fraction of its length; largest motion of the balls relative to each other within a window [rad].
WINDOW, LEAST, BEYOND, APART = np.radians(8.0), 1e-4, 0.01, 5e-4


class ComplianceWindow(NamedTuple):
    """Compliance of screw or nut for balls at the start, middle and end of a short piece of the track."""

    #: Azimuths of the balls at the first of the three positions [rad].
    azimuth: Array
    #: Axial positions of the balls at the first of the three positions [m].
    z: Array
    #: Angle by which the balls travel from the first to the third position [rad], negative if they travel backwards.
    travel_angle: float
    #: Compliance between the c contacts, each with two axes, at the three positions in this order, each ``(2 c, 2 c)``
    #: [m/N].
    compliances: tuple[Array, Array, Array]


@dataclass
class TravellingCompliance:
    """Compliance of screw or nut between contacts that travel along the track together.

    The compliance is computed for balls at three positions of a window, which is a short piece of the track, and
    interpolated between these positions by a parabola. A body of revolution with a groove in it responds in the same way to
    balls that turn and advance together, except near its ends, so that the compliance changes slowly. Where balls have
    moved by more than ``APART`` relative to each other, or other balls are on the loaded arc, a new window begins. One
    object serves one scene and one compliance model only.
    """

    #: Length of a window of the track [rad], positive if the balls travel towards larger azimuths in the nut, else
    #: negative.
    window_angle: float
    #: Windows computed so far, listed under a key of body (whether screw), flanks and number of balls.
    windows: dict[tuple[object, ...], list[ComplianceWindow]] = field(default_factory=dict)

    def __call__(
        self, scene: Scene, layout: BallLayout, screw: bool, backend: ComplianceModel, flanks: Sequence[int]
    ) -> Array:
        """Return the compliance of screw or nut between its c contacts, each with two axes ``(2 c, 2 c)`` [m/N].

        ``scene``: screw or bearing; ``layout``: present positions of the balls; ``screw``: whether the body is the
        screw (True) or the nut; ``backend``: model for the compliance of the parts; ``flanks``: numbers of the flanks
        with contacts, 0 left and 1 right. The form of the result is that of `compliance_between_contacts`.
        """
        track, rate = scene.track, lead_per_radian(scene.track)
        known = self.windows.setdefault((screw, tuple(flanks), layout.z.size), [])
        for window in known:
            moved = layout.azimuth - window.azimuth
            share = float(np.mean(moved if rate == 0.0 else (layout.z - window.z) / rate)) / window.travel_angle
            apart = np.abs(moved - moved.mean()).max()
            if apart <= APART and -BEYOND <= share <= 1.0 + BEYOND:
                break
        else:
            compute = partial(compliance_between_contacts, scene, screw=screw, backend=backend, flanks=flanks)
            share, window = 0.0, self.new_window(layout, track, compute)
            known.append(window)
        first, second, third = window.compliances
        left = 1.0 - share
        return np.asarray(left * (left - share) * first + 4.0 * share * left * second + share * (share - left) * third)

    def new_window(self, layout: BallLayout, track: Track, compute: Callable[[BallLayout], Array]) -> ComplianceWindow:
        """Return a window that begins at the ball positions ``layout``, with the compliance of screw or nut.

        The compliance is that for balls at the start, middle and end of the window, a short piece of the track. The window
        is shorter than ``window_angle`` where a ball would otherwise pass the face of the nut. ``track``: helix along which
        the balls travel; ``compute``: function that returns the compliance [m/N] at given positions of the balls. Raises
        ValueError if ``compute`` raises it even for the shortest window.
        """
        rate, length = lead_per_radian(track), self.window_angle
        while True:
            steps = (length, 0.5 * length, 0.0)
            places = (ball_layout_at_positions(track, layout.azimuth + s, layout.z + s * rate) for s in steps)
            try:
                third, second, first = map(compute, places)
                return ComplianceWindow(layout.azimuth, layout.z, length, (first, second, third))
            except ValueError:
                if abs(length) < LEAST:
                    raise
                length /= 8.0


def load_solver_for_travelling_balls(model: str, travel_sense: float) -> Callable[..., ContactLoads]:
    """Return the function that computes contact loads at each instant of a simulation over time.

    Parameters
    ----------
    model
        Name of the static model: "lin" or "refined".
    travel_sense
        Sense in which the balls travel in the nut: 1.0 towards larger azimuths, -1.0 towards smaller ones.
    """
    if model == "lin":
        return contact_loads
    return partial(contact_loads, backend=REFINED, whole=TravellingCompliance(WINDOW * travel_sense))


#: Names of the static models with which contact loads can be computed at each instant of a simulation over time.
MODELS_OVER_TIME = ("lin", "refined")

#: A static model: function that returns the contact loads of balls with given errors at given positions.
Solve = Callable[[GeometryWithErrors, BallLayout], StaticResult | ContactLoads]


class LastInstant(NamedTuple):
    """Motions of N balls and forces on them at the previous instant, from which the next solution begins."""

    #: Motions of the balls: orbit, then three rotations ``(N, 4)`` [rad/s].
    ball_motions: Array
    #: Force of each ball on the next one ``(N,)`` [N].
    ball_forces: Array
    #: Friction forces that displace the balls across their grooves: on each ball along x3 and z3, and on the screw along
    #: its axis ``(N, 3)`` [N].
    displacing_friction: Array


@dataclass(frozen=True)
class SceneInMotion(BallsInCircuits):
    """Balls of a screw or bearing with everything that stays constant in a transient simulation; azimuths: nut's frame."""

    #: Scene of the screw or bearing.
    scene: Scene
    #: Coefficients of friction.
    friction: Friction
    #: Which part turns, screw or nut, and its angular speed.
    drive: Drive
    #: Random geometric errors of balls and grooves.
    random_errors: ErrorsAfterDrawing
    #: Function that computes the contact loads of balls with given errors at given positions.
    solve_contact_loads: Solve

    def rotations_of_screw_and_nut(self, time: float) -> tuple[float, float]:
        """Return the angles by which the screw, then the nut, has turned in space after a given time [rad].

        ``time``: time since the start [s].
        """
        turned = self.drive.speed * time
        return (turned, 0.0) if self.drive.turns == "screw" else (0.0, turned)

    def solve_contacts(self, azimuth: Array, time: float, push: Array, q: Array) -> tuple[StaticContacts, Mask, str]:
        """Return the contacts of all N balls at one instant; friction changes the contact loads if the scene requests it.

        Parameters
        ----------
        azimuth
            Azimuths of the balls in the nut's frame ``(N,)`` [rad].
        time
            Time since the start [s].
        push
            Friction on balls and screw in the previous step ``(N, 3)`` [N]
            (`FrictionEquilibrium.friction_on_balls_and_screw`); it is overwritten by the friction of this step.
        q
            Motions of the balls in the previous step ``(N, 4)`` [rad/s], first estimates for `solve_friction_equilibria`.

        Returns
        -------
        tuple
            The contacts; whether each ball is on a loaded arc ``(N,)``; ``"converged"``, or a phrase that says what
            failed.
        """
        scene, track = self.scene, self.scene.track
        on_screw, on_nut = self.rotations_of_screw_and_nut(time)
        folded, loaded = self.fold_into_circuits(azimuth)
        layout, on_arc = self.layout(scene, folded, on_nut), np.flatnonzero(loaded)
        space, station = layout.azimuth[on_arc], layout.z[on_arc]
        arc_layout = ball_layout_at_positions(track, space, station)
        in_screw, in_nut = space - on_screw, space - on_nut - scene.nut.azimuth
        met = self.random_errors.geometry_at_balls(scene, in_screw, in_nut, station, self.radius[on_arc])
        result = self.solve_contact_loads(met, arc_layout)
        at, status = None, "converged" if result.converged else f"contact loads: {result.status}"
        if result.converged:
            at = contacts_of_solution(scene, result, met, arc_layout)
            if friction_displaces_balls(scene, self.friction):
                place = positions_in_grooves_with_errors(at, met, result.hertz_C)
                still, start = BallsUnderLoad(scene, at, self.friction, self.drive), (push[on_arc], q[on_arc])
                fed = solve_friction_equilibria([DisplacedBalls(still, place, *start)])[0]
                push[on_arc], at = fed.friction_on_balls_and_screw, fed.contacts
                if fed.failed_balls.any():
                    status = f"friction and position do not agree on {int(fed.failed_balls.sum())} balls"
        return contacts_of_all_balls(at, layout, on_arc, self.radius, track.contact_angle), loaded, status

    def state_at_start(self) -> BallState:
        """Return the state at the start of the simulation: balls at the scene's positions, rolling at the nominal speed."""
        count, nut = self.radius.size, self.groove.nut_speed
        nominal = self.groove.nominal_orbit - nut
        memory = LastInstant(np.tile([nominal + nut, 0.0, 0.0, 0.0], (count, 1)), np.zeros(count), np.zeros((count, 3)))
        gap = np.maximum(self.gaps_to_next_balls(self.azimuth), 0.0)
        return BallState(self.azimuth, gap, np.full(count, nominal), memory)

    def time_to_next_arc_end(self, azimuth: Array, omega: Array, time: float) -> float:  # noqa: ARG002 - arcs are fixed in the nut
        """Return the time until a ball reaches an end of its loaded arc [s]; infinite for a bearing, which has no ends.

        ``azimuth``: azimuths of the balls in the nut's frame ``(N,)`` [rad]; ``omega``: their angular speeds in this
        frame ``(N,)`` [rad/s]; ``time`` is not used.
        """
        if self.scene.track.lead == 0.0:
            return np.inf
        return min(track.time_to_arc_end(azimuth, omega) for track in self.tracks)

    def solve_at_instant(
        self, azimuth: Array, time: float, slack: Array, memory: LastInstant
    ) -> Search[InstantSolution | str]:
        """Return the contact loads and ball motions at one instant, or a text that says why no loads were found.

        ``azimuth``: azimuths of the balls in the nut's frame ``(N,)`` [rad]; ``time``: time since the start [s]; ``slack``:
        largest rate at which the difference of the azimuths of each ball and the next one may decrease ``(N,)`` [rad/s],
        inf where they cannot touch; ``memory``: results at the previous instant, from which the searches begin.
        """
        push = memory.displacing_friction.copy()
        at, loaded, status = self.solve_contacts(azimuth, time, push, memory.ball_motions)
        if status != "converged":
            return status
        searches = []
        for members in (track.balls for track in self.tracks):
            rates = slack[members] if members.stop - members.start > 1 else np.array([np.inf])
            start = (memory.ball_motions[members], memory.ball_forces[members])
            balls = at.subset(members)
            searches.append(search_motion_on_track(self.scene, balls, rates, self.friction, self.drive, start))
        moved: list[ChainMotion] = yield SideBySide(searches)
        q, force, wrench = (np.concatenate([getattr(m, name) for m in moved]) for name in ("q", "ball_force", "wrench"))
        axial = -at.axial_force
        if friction_displaces_balls(self.scene, self.friction):
            # contact loads that friction has changed balance its axial force
            axial += float(np.einsum("nsi,ni->", wrench[:, ON_SCREW, :3], at.section_axes[:, :, 2]))
        groove, ball, closing = (sum(parts) for parts in zip(*(m.losses_by_cause for m in moved), strict=True))
        return InstantSolution(
            omega=q[:, 0] - self.groove.nut_speed,
            ball_force=force,
            load=at.force,
            loaded=loaded,
            losses=(groove, ball, closing),
            input_power=sum(m.input_power for m in moved),
            converged=all(m.converged for m in moved),
            memory=LastInstant(q, force, push),
            axial=axial,
            on_screw=_driving_torque_on_screw(self, at, wrench, axial),
        )


def _driving_torque_on_screw(setting: SceneInMotion, contacts: StaticContacts, wrench: Array, axial: float) -> float:
    """Return the torque about +z [N m] that drives the screw under an external axial load ``axial`` [N].

    The torque is the moment of contact loads and friction about the axis. If friction makes the axial force on the balls
    differ from the load, the difference times lead/(2 pi) is added. ``setting``: the simulated screw; ``contacts``:
    contacts of the N balls; ``wrench``: force and moment of friction on the balls in their sections' axes x3 (radial), y3
    (along the track), z3 (binormal) ``(N, 4, 6)`` [N, N m].
    """
    wrenches = wrench.copy()
    wrenches[..., :3] -= contacts.force[..., None] * contacts.normals
    along, moment = (float(component[:, ON_SCREW].sum()) for component in axial_forces_and_moments(contacts, wrenches))
    return moment + lead_per_radian(setting.scene.track) * (along - axial)
