"""A screw or bearing in time: balls travel through circuits, loads are solved where they are, neighbours meet and part.

Each step is a midpoint rule: loads and motions are those of the places that the speeds of the step before lead to in half a
step, so that torques and paths are of second order in the step while nothing engages or parts, and of first order in the
time for which contacts begin, end, or balls enter and leave the loaded arc. Over a step the gap of neighbours obeys
0 <= F, 0 <= gap + rate dt, F (gap + rate dt) = 0 (Lin 3.4.4): balls keep their order and never overlap.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.friction.screw.chain import ChainMotion
from rollbench.lowfi.friction.screw.path import ON_SCREW
from rollbench.lowfi.friction.screw.steps import StepError, solve_steps
from rollbench.lowfi.friction.whole.balls import Balls
from rollbench.lowfi.friction.whole.chain import chain_motion
from rollbench.lowfi.friction.whole.contacts import StaticContacts, contacts_at, spread
from rollbench.lowfi.friction.whole.feedback import feed_back, feeds_back, seats_at
from rollbench.lowfi.friction.whole.torque import about_axis
from rollbench.lowfi.statics.again import ContactLoads
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import Drawn, Specimen
from rollbench.meshes.helix import BallLayout, layout_at, reduced_lead
from rollbench.meshes.parts import Friction, Scene, Time
from rollbench.meshes.parts import Motion as Drive

#: A static model: contact loads of balls with these errors at these places.
Solve = Callable[[Specimen, BallLayout], StaticResult | ContactLoads]
#: Steps to begin with: per ball diameter travelled, least and most.
STEPS_PER_PITCH, FIRST_STEPS = 2.0, (8, 400)


@dataclass(frozen=True)
class History:
    """Arrays over T steps, N balls in the order of ``balls``; SI.

    span: time asked for [s]; step: length of a step [s].
    turned (T,): angle of the part that turns, azimuth (T, N), unwrapped in the nut's frame, and loaded (T, N), whether on a
    loaded arc, at the middle of each step; gap (T, N) [rad] at its end; ball_force (T, N) of ball k on the next one of its
    circuit; omega (T, N): speed in the nut's frame; load (T, N, 4): contact forces; torques (T,) [N m] of grooves, of
    ball-to-ball sliding and of closing gaps, the losses per angle; axial (T,): external axial load on the screw; on_screw
    (T,): torque about +z that drives it, from the moments of all contact forces and friction in space; imbalance (T,):
    power taken in less losses, over the losses; converged (T,). status: of the whole run, in words.
    """

    balls: Balls
    span: float
    step: float
    turned: Array
    azimuth: Array
    loaded: NDArray[np.bool_]
    gap: Array
    ball_force: Array
    omega: Array
    load: Array
    groove_torque: Array
    ball_torque: Array
    closing_torque: Array
    axial: Array
    on_screw: Array
    imbalance: Array
    converged: NDArray[np.bool_]
    status: str

    @property
    def torque(self) -> Array:
        """Friction torque (T,) [N m]."""
        return np.asarray(self.groove_torque + self.ball_torque + self.closing_torque)

    @property
    def advance(self) -> tuple[float, float]:
        """Angular speed of the screw against the nut [rad/s], and its speed along the axis without end play [m/s]."""
        grooves = self.balls.grooves
        turning = grooves.screw_speed - grooves.nut_speed
        return turning, grooves.ratio * turning

    @property
    def torque_balance(self) -> Array:
        """Torque times speed and axial load times advance less all losses (T,) [W]: zero but for round-off."""
        turning, along = self.advance
        return np.asarray(self.on_screw * turning + self.axial * along - self.torque * abs(turning))

    @property
    def steps(self) -> int:
        """Number of steps."""
        return int(self.turned.size)

    @property
    def angles(self) -> tuple[float, float]:
        """Angles [rad] by which the part that turns has turned at the run's end, and was to turn."""
        speed = abs(self.balls.grooves.speed)
        return speed * self.step * self.steps, speed * self.span

    @property
    def complete(self) -> bool:
        """Whether the run reached its end."""
        return self.steps == round(self.span / self.step)

    @property
    def good(self) -> bool:
        """Whether every step converged."""
        return self.status == "converged"


@dataclass
class _State:
    """Where a run is: azimuths (N,), gaps (N,), speeds in the nut's frame (N,), motions and forces of the
    last step, and its friction fed back (N, 3)."""

    azimuth: Array
    gap: Array
    omega: Array
    q: Array
    force: Array
    push: Array
    rows: dict[str, list[Array | NDArray[np.bool_] | float | bool]] = field(default_factory=dict)

    def log(self, **values: Array | NDArray[np.bool_] | float | bool) -> None:
        """Append one step."""
        for key, value in values.items():
            self.rows.setdefault(key, []).append(value)


@dataclass(frozen=True)
class Setting:
    """What stays the same over a run: parts, coefficients, motion, errors, balls, static model, kernels."""

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

    def contacts(self, azimuth: Array, time: float, push: Array) -> tuple[StaticContacts, NDArray[np.bool_], str]:
        """Contacts of all N balls at azimuths (N,) in the nut's frame, which are on a loaded arc, and how loads ended.

        push (N, 3): forces of friction fed back in the step before, overwritten; see ``feed_back``.
        """
        scene, track = self.scene, self.scene.track
        on_screw, on_nut = self.angles(time)
        folded, loaded = self.balls.place(azimuth)
        starts = np.concatenate([np.full(t.azimuth.size, t.start) for t in self.balls.tracks])
        space = folded + on_nut + 2.0 * np.pi * starts / track.starts
        station = scene.nut.position + reduced_lead(track) * (folded - track.phase)
        who = np.flatnonzero(loaded)
        layout = layout_at(track, space, station)
        some = layout_at(track, space[who], station[who])
        on_errors = space[who] - on_screw, space[who] - on_nut - scene.nut.azimuth
        met = self.drawn.at(scene, *on_errors, station[who], self.balls.radius[who])
        result = self.solve(met, some)
        at, status = None, "converged" if result.converged else f"contact loads: {result.status}"
        if result.converged:
            at = contacts_at(scene, result, met, some)
            if feeds_back(scene, self.friction):
                place = seats_at(at, met, result.hertz_C)
                fed = feed_back(scene, at, place, self.friction, self.drive, self.fast, push[who])
                push[who], at = fed.push, fed.at
                status = f"friction and place do not agree on {int(fed.failed.sum())} balls" if fed.failed.any() else status
        return spread(at, layout, who, self.balls.radius, track.contact_angle), loaded, status


def resolved(setting: Setting, time: Time) -> tuple[History, StepError | None]:
    """The run of a scene's [time] with the error of its steps; steps that are not given are chosen by it."""
    span = time.span(setting.drive)
    nominal = setting.balls.grooves.nominal_orbit - setting.balls.grooves.nut_speed
    pitches = abs(nominal) * span / setting.balls.grooves.pair.spacing
    first = int(np.clip(np.ceil(STEPS_PER_PITCH * pitches), *FIRST_STEPS))
    return solve_steps(lambda steps: simulate(setting, span, steps), time.steps, first, time.goal)


def simulate(setting: Setting, span: float, steps: int) -> History:
    """Run over ``span`` [s] in ``steps`` equal steps, from the scene's places. Ends early where loads are not found."""
    balls, dt = setting.balls, span / steps
    nut = balls.grooves.nut_speed
    nominal = balls.grooves.nominal_orbit - nut
    state = _State(
        balls.azimuth.copy(),
        np.maximum(balls.gaps(balls.azimuth), 0.0),
        np.full(balls.radius.size, nominal),
        np.tile([nominal + nut, 0.0, 0.0, 0.0], (balls.radius.size, 1)),
        np.zeros(balls.radius.size),
        np.zeros((balls.radius.size, 3)),
    )
    at, _, status = setting.contacts(balls.azimuth, 0.0, state.push)
    if status == "converged":  # speeds for the first half step
        _advance(setting, state, at, 0.0, np.full(balls.radius.size, np.inf))
    for k in range(steps):
        time = (k + 0.5) * dt
        middle = state.azimuth + 0.5 * dt * state.omega
        at, loaded, status = setting.contacts(middle, time, state.push)
        if status != "converged":
            status = f"at {np.degrees(setting.drive.speed * time):.6g} deg: {status}"
            break
        moved = _advance(setting, state, at, dt, state.gap / dt)
        _record(setting, state, at, moved, (abs(setting.drive.speed) * time, middle, loaded))
    given = ("balls", "span", "step", "status")
    rows = {f.name: np.array(state.rows.get(f.name, [])) for f in fields(History) if f.name not in given}
    if status == "converged" and not np.all(rows["converged"]):
        first = float(rows["turned"][int(np.argmin(rows["converged"]))])
        status = f"no balance of friction found at {np.degrees(first):.6g} deg"
    return History(balls, span, dt, status=status, **rows)


def _advance(setting: Setting, state: _State, at: StaticContacts, dt: float, slack: Array) -> list[ChainMotion]:
    """Move the balls over a step with their motions at the contacts ``at``; the state is overwritten."""
    balls, out = setting.balls, []
    for own in balls.bounds:
        single = own.stop - own.start == 1
        moved = chain_motion(
            setting.scene,
            at.part(own),
            np.array([np.inf]) if single else slack[own],
            setting.friction,
            setting.drive,
            balls.grooves,
            (state.q[own], state.force[own]),
            setting.fast,
        )
        state.q[own], state.force[own] = moved.q, moved.ball_force
        rate = moved.q[:, 0] - balls.grooves.nut_speed
        state.omega[own] = rate
        # never less than zero but for round-off
        state.gap[own] = np.maximum(state.gap[own] + dt * (np.roll(rate, -1) - rate), 0.0)
        out.append(moved)
    state.azimuth = state.azimuth + dt * state.omega
    return out


def _record(
    setting: Setting,
    state: _State,
    at: StaticContacts,
    moved: list[ChainMotion],
    where: tuple[float, Array, NDArray[np.bool_]],
) -> None:
    """Append a step to the history."""
    speed = abs(setting.drive.speed)
    groove, ball, closing, power = (
        sum(float(np.sum(getattr(m, name))) for m in moved)
        for name in ("groove_loss", "ball_loss", "closing_loss", "input_power")
    )
    loss = groove + ball + closing
    axial = -at.axial_force - (_pull(at, moved) if feeds_back(setting.scene, setting.friction) else 0.0)
    state.log(
        turned=where[0],
        azimuth=where[1],
        loaded=where[2],
        gap=state.gap.copy(),
        ball_force=state.force.copy(),
        omega=state.omega.copy(),
        load=at.force,
        groove_torque=groove / speed,
        ball_torque=ball / speed,
        closing_torque=closing / speed,
        axial=axial,
        on_screw=_torque(setting, at, moved, axial),
        imbalance=(power - loss) / loss if loss > 0.0 else power,
        converged=all(m.converged for m in moved),
    )


def _torque(setting: Setting, at: StaticContacts, moved: list[ChainMotion], axial: float) -> float:
    """Torque [N m] about +z that drives the screw under the external axial load [N].

    Moments of contact forces and friction about the axis; an axial force of friction that the loads do not know of is
    carried down the helix.
    """
    wrench = np.concatenate([m.wrench for m in moved])
    wrench[..., :3] -= at.force[..., None] * at.normals
    along, moment = (float(part[:, ON_SCREW].sum()) for part in about_axis(at, wrench))
    return moment + reduced_lead(setting.scene.track) * (along - axial)


def _pull(at: StaticContacts, moved: list[ChainMotion]) -> float:
    """Axial force [N] of the friction of grooves on the screw: contact forces that know of it balance it."""
    wrench = np.concatenate([m.wrench for m in moved])
    return -float(np.einsum("nsi,ni->", wrench[:, ON_SCREW, :3], at.frames[:, :, 2]))
