"""Transient simulation of balls on closed tracks: loads and motions at instants, neighbours that meet and part.

Over a step dt the gap of neighbours obeys 0 <= F, 0 <= gap + rate dt, F (gap + rate dt) = 0 (section 3.4.4 of Lin's
thesis): balls keep their order and never overlap. Torques jump where a ball enters or leaves the loaded arc, or meets its
neighbour, and are smooth between these events. The scheme "located" ends a step at each event, computes a short piece of
time before and after the event, so that the torque on either side of the jump is known, and is of second order (midpoint
rule). The scheme "equal" is Lin's: equal steps with loads and motions computed at their start. This scheme is of first
order, and the time of an event is wrong by a part of a step.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property, partial
from typing import Any, Literal, NamedTuple, Protocol

import numpy as np

from rollbench.lowfi.friction.screw.groove import HelicalMotion
from rollbench.lowfi.together import Search, solve_alone
from rollbench.meshes.arrays import Array, Index, Mask


class ClosedTrack(NamedTuple):
    """One closed track of balls: a loaded arc, on which balls carry load, and a return, in which they do not."""

    #: Number of the thread start on which the track lies, from 0.
    start: int
    #: Azimuth of the beginning of the loaded arc [rad].
    loaded_arc_start: float
    #: Length of the loaded arc as an azimuth [rad].
    arc: float
    #: Length of the whole track, return included, as an azimuth [rad].
    ring: float
    #: Difference of the azimuths of two touching balls of nominal size [rad].
    spacing: float
    #: Indices, among all N balls of the screw or bearing, of the balls on this track.
    balls: slice

    def distances_from_arc_start(self, azimuth: Array, turned: float = 0.0) -> Array:
        """Return the angular distance of each ball of the track from the beginning of its loaded arc, 0 to ``ring`` [rad].

        ``azimuth``: azimuths of all N balls of the screw ``(N,)`` [rad]; ``turned``: angle by which the track has
        turned about the axis [rad].
        """
        return np.asarray(np.mod(azimuth[self.balls] - turned - self.loaded_arc_start, self.ring))

    def time_to_arc_end(self, azimuth: Array, rate: Array, turned: float = 0.0) -> float:
        """Return the time until a ball of this track reaches an end of the loaded arc [s]; inf if no ball moves.

        ``azimuth``: azimuths of all N balls ``(N,)`` [rad]; ``rate``: their angular speeds relative to the track
        ``(N,)`` [rad/s], which are taken as constant; ``turned``: angle by which the track has turned about the axis
        [rad].
        """
        along, rate = self.distances_from_arc_start(azimuth, turned), rate[self.balls]
        forward = np.where(along < self.arc, self.arc, self.ring) - along
        distance = np.where(rate > 0.0, forward, along - np.where(along > self.arc, self.arc, 0.0))
        return float(np.divide(distance, np.abs(rate), out=np.full_like(rate, np.inf), where=rate != 0.0).min())


#: Scheme of the time steps: steps divided at events ("located": balls enter or leave a loaded arc, or meet), or equal
#: steps.
Scheme = Literal["located", "equal"]

#: Duration of the pieces of a time step just before and just after an event (a ball enters or leaves a loaded arc, or meets
#: its neighbour), and least duration of a piece, both as fractions of a time step; largest number of pieces of a time step.
SHORT, TINY, PIECES = 1e-2, 1e-6, 100

#: Gap [rad] up to which neighbouring balls count as touching.
CLOSED = 1e-10

#: Ratio of a closing rate of two neighbours to the largest angular speed of a ball, so high that it is never reached: a gap
#: that could close only at a faster rate counts as open during the whole time step.
FASTEST = 10.0

#: Fields of `TravelHistory` with the friction torques that belong to the three values of ``InstantSolution.losses``, in the
#: same order.
TORQUES = ("groove_torque", "ball_torque", "closing_torque")

#: Number of time steps of the first simulation if the caller states none: steps per ball diameter travelled, then smallest
#: and largest number.
STEPS_PER_PITCH, FIRST_STEPS = 2.0, (8, 400)


class BallState(NamedTuple):
    """Azimuths and orbital speeds of N balls at one time of a simulation, with the gaps between neighbours."""

    #: Azimuths of the balls ``(N,)`` [rad].
    azimuth: Array
    #: Gap between each ball and the next ball on its track, as an azimuth: zero if the two touch ``(N,)`` [rad].
    gap: Array
    #: Angular speeds of the ball centres about the axis, in the frame in which azimuths are measured ``(N,)`` [rad/s].
    omega: Array
    #: Solution at the previous instant, from which the search at the next instant begins; None at the start.
    memory: Any


@dataclass(frozen=True)
class InstantSolution:
    """Contact loads, ball motions and friction losses of N balls at one instant of a simulation."""

    #: Angular speeds of the ball centres about the axis, in the frame in which azimuths are measured ``(N,)`` [rad/s].
    omega: Array
    #: Force of each ball on the next ball on its track ``(N,)`` [N].
    ball_force: Array
    #: Forces at the contacts of the balls with the grooves ``(N, 4)`` [N].
    load: Array
    #: Whether each ball is on a loaded arc ``(N,)``.
    loaded: Mask
    #: Power lost by friction [W]: in the grooves, by balls that slide on each other, and by gaps between balls that close
    #: while these balls press on each other.
    losses: tuple[float, float, float]
    #: Power that screw and nut supply [W].
    input_power: float
    #: Whether loads and motions converged.
    converged: bool
    #: Solution from which the search at the next instant begins.
    memory: Any
    #: Largest change of a friction force on a ball or the screw in the last round of the iteration between contact loads
    #: and friction [N].
    change: float = 0.0
    #: External axial load on the screw [N]; nan if it is not computed.
    axial: float = float("nan")
    #: Torque about +z that drives the screw [N m]; nan if it is not computed.
    on_screw: float = float("nan")


class SimulatedSystem(Protocol):
    """Interface of a screw or bearing that `simulate` can simulate: its tracks and balls, and its state at one instant."""

    @property
    def groove(self) -> HelicalMotion:
        """Grooves without errors, with the speeds of screw and nut (or of the rings)."""

    @property
    def tracks(self) -> Sequence[ClosedTrack]:
        """Closed tracks of the balls; the balls of a track have consecutive indices in the order of azimuth."""

    @property
    def spacing(self) -> Array:
        """Difference of the azimuths of each ball and the next one if they touch ``(N,)`` [rad]."""

    @property
    def number(self) -> Index:
        """Numbers of the balls in the scene ``(N,)``; -1 for a ball that is in the return at the start."""

    def state_at_start(self) -> BallState:
        """Return positions and speeds of the balls at the start of the simulation."""

    def time_to_next_arc_end(self, azimuth: Array, omega: Array, time: float) -> float:
        """Return the time until a ball reaches an end of its loaded arc [s]; inf if no ball ever reaches one.

        ``azimuth``: present azimuths of the balls ``(N,)`` [rad]; ``omega``: their angular speeds ``(N,)`` [rad/s];
        ``time``: present time since the start [s].
        """

    def solve_at_instant(
        self, azimuth: Array, time: float, slack: Array, memory: Any
    ) -> Search[InstantSolution] | Search[InstantSolution | str]:
        """Return contact loads and ball motions at one instant, or a text that says why no loads are found.

        ``azimuth``: azimuths of the balls ``(N,)`` [rad]; ``time``: time since the start [s]; ``slack``: largest rate at
        which the difference of the azimuths of each ball and the next one may decrease ``(N,)`` [rad/s], inf where they
        cannot touch; ``memory``: attribute ``memory`` of the solution at the previous instant.
        """


@dataclass(frozen=True)
class TravelHistory:
    """Time history of N balls that travel round their tracks.

    Events (a ball enters or leaves a loaded arc, or meets its neighbour) may divide a time step into pieces. All time
    steps together consist of T pieces. Ball k pushes the next ball of its track: forces and gaps with index k lie
    between these two balls.
    """

    #: Screw or bearing that was simulated (a `SimulatedSystem`).
    setting: Any
    #: Time that was to be simulated [s]; the simulation may have ended earlier.
    span: float
    #: Number of equal time steps into which ``span`` is divided.
    steps: int
    #: Times at which contact loads and ball motions are solved, one in each of the T pieces of time steps ``(T,)`` [s].
    time: Array
    #: Duration of each piece of a time step ``(T,)`` [s].
    lasts: Array
    #: Number of the time step, from 0, to which each of the T pieces belongs ``(T,)``.
    step: Index
    #: Azimuths of the balls at ``time``, unwrapped ``(T, N)`` [rad].
    azimuth: Array
    #: Which balls are on a loaded arc at ``time`` ``(T, N)``.
    loaded: Mask
    #: Gap from each ball to the next ball on its track at the end of each piece of a time step, as an azimuth: zero if the
    #: two touch ``(T, N)`` [rad].
    gap: Array
    #: Force of each ball on the next ball on its track ``(T, N)`` [N].
    ball_force: Array
    #: Angular speeds of the ball centres about the axis, in the frame in which azimuths are measured ``(T, N)`` [rad/s].
    omega: Array
    #: Forces at the contacts of the balls with the grooves ``(T, N, 4)`` [N].
    load: Array
    #: Friction torque due to losses in the grooves ``(T,)`` [N m]: the power lost, divided by the angular speed of the nut
    #: relative to the screw.
    groove_torque: Array
    #: Friction torque due to balls that slide on each other ``(T,)`` [N m].
    ball_torque: Array
    #: Friction torque due to gaps between balls that close while these balls press on each other ``(T,)`` [N m].
    closing_torque: Array
    #: External axial load on the screw ``(T,)`` [N]; nan if ``setting`` does not compute it.
    axial: Array
    #: Torque about +z that drives the screw ``(T,)`` [N m]; nan if ``setting`` does not compute it.
    on_screw: Array
    #: Power that screw and nut supply less all losses, divided by the losses ``(T,)``; where there are no losses, the
    #: supplied power [W].
    imbalance: Array
    #: Largest change of a friction force on a ball or the screw in the last round of the iteration between contact loads
    #: and friction ``(T,)`` [N].
    change: Array
    #: Whether contact loads and ball motions converged in each piece of a time step ``(T,)``.
    converged: Mask
    #: ``"converged"``, or a text with the angle at which the simulation ended early or at which no balance of friction was
    #: found.
    status: str

    @cached_property
    def torque(self) -> Array:
        """Friction torque due to all losses of the balls ``(T,)`` [N m] (Figure 3.25 of Lin's thesis)."""
        return np.asarray(self.groove_torque + self.ball_torque + self.closing_torque)

    def mean_over_time(self, values: Array) -> float:
        """Return the mean over time of ``values``, one for each piece of a time step ``(T,)``, in their unit."""
        return float(np.sum(self.lasts * values) / np.sum(self.lasts))

    @property
    def begun_step_count(self) -> int:
        """Number of time steps of which at least one piece was solved."""
        return int(self.step[-1]) + 1 if self.step.size else 0

    @cached_property
    def mean_torque_per_step(self) -> Array:
        """Mean friction torque of each time step of which at least one piece was solved ``(begun_step_count,)`` [N m]."""
        return np.asarray(np.bincount(self.step, self.lasts * self.torque) / np.bincount(self.step, self.lasts))

    @cached_property
    def torque_statistics(self) -> dict[str, float]:
        """Mean, largest and least friction torque over the simulated time [N m], keys "mean", "largest" and "least"."""
        return {
            "mean": self.mean_over_time(self.torque),
            "largest": float(self.torque.max()),
            "least": float(self.torque.min()),
        }

    @property
    def largest_ball_to_groove_ratio(self) -> float:
        """Largest ratio over time of the friction torque between balls to that in the grooves; nan without friction."""
        return float(self.ball_to_groove_ratio.max())

    @property
    def nut_angle(self) -> Array:
        """Angle by which the nut has turned relative to the screw ``(T,)`` [rad]."""
        return np.asarray(self.setting.groove.speed * self.time)

    @property
    def rotation_angle(self) -> Array:
        """Angle by which the rotating part (screw or nut) has turned, never negative ``(T,)`` [rad]."""
        return np.asarray(np.abs(self.nut_angle))

    @property
    def reached_and_intended_angle(self) -> tuple[float, float]:
        """Angle by which the rotating part had turned when the simulation ended, then the angle to be simulated [rad]."""
        speed = abs(self.setting.groove.speed)
        return speed * float(self.lasts.sum()), speed * self.span

    @property
    def reached_end(self) -> bool:
        """Whether the simulation covers the whole time ``span`` that was to be simulated."""
        return bool(abs(float(self.lasts.sum()) - self.span) <= TINY * self.span)

    @property
    def fully_converged(self) -> bool:
        """Whether the whole time ``span`` was simulated, and contact loads and motions converged at every instant."""
        return self.status == "converged"

    @property
    def azimuths_at_piece_ends(self) -> Array:
        """Azimuths of the balls at the end of each piece of a time step, unwrapped ``(T, N)`` [rad]."""
        return np.asarray(self.setting.state_at_start().azimuth + np.cumsum(self.lasts[:, None] * self.omega, axis=0))

    @property
    def presses_on_next(self) -> Mask:
        """Whether each ball presses on the next one ``(T, N)``, as shown by dots in Figure 3.24 of Lin's thesis."""
        return np.asarray(self.ball_force > 0.0)

    @property
    def spacing(self) -> Array:
        """Angle from each ball to the next one at the end of each piece of a step ``(T, N)`` [rad] (Lin's Figure 3.24)."""
        return np.asarray(self.gap + self.setting.spacing)

    @cached_property
    def touching_group_counts(self) -> Array:
        """Number of groups of touching balls, on all tracks, at each instant ``(T,)``."""
        return np.asarray(sum(count_touching_groups(self.presses_on_next[:, track.balls]) for track in self.setting.tracks))

    @cached_property
    def ball_to_groove_ratio(self) -> Array:
        """Ratio of the friction torque between balls to that in the grooves ``(T,)``; nan without friction in the grooves.

        The torque between balls is due to the losses by sliding on each other and by gaps that close under force.
        """
        groove, between = self.groove_torque, self.ball_torque + self.closing_torque
        return np.divide(between, groove, out=np.full_like(groove, np.nan), where=groove > 0.0)

    @property
    def turning_and_axial_speed(self) -> tuple[float, float]:
        """Angular speed of the screw relative to the nut [rad/s], then the speed of its axial advance [m/s]."""
        turning = -self.setting.groove.speed
        return turning, self.setting.groove.advance_per_radian * turning

    @property
    def power_balance_on_screw(self) -> Array:
        """Power of torque and axial load on the screw, less all losses ``(T,)`` [W]; zero but for round-off."""
        turning, along = self.turning_and_axial_speed
        return np.asarray(self.on_screw * turning + self.axial * along - self.torque * abs(turning))


def count_touching_groups(contact: Mask) -> Array:
    """Return the number of groups of touching balls on a closed track at each of T times ``(T,)``.

    Parameters
    ----------
    contact
        Whether each of the track's balls touches the next one ``(T, N)``.
    """
    return np.asarray(np.sum(contact & ~np.roll(contact, 1, axis=1), axis=1) + np.all(contact, axis=1))


def _time_until_neighbours_meet(place: BallState, tracks: Sequence[ClosedTrack]) -> float:
    """Return the time until the first two neighbours with a gap between them meet at their present speeds [s].

    The result is inf if none meet. ``place``: positions and speeds of the balls; ``tracks``: the closed tracks with their
    balls.
    """
    least = np.inf
    for track in tracks:
        gap, omega = place.gap[track.balls], place.omega[track.balls]
        closing = omega - np.roll(omega, -1)
        meets = (gap > CLOSED) & (closing > 0.0)
        least = min(least, float(np.min(gap[meets] / closing[meets], initial=np.inf)))
    return least


def _next_piece_of_step(left: float, step: float, time_to_event: float, after_event: bool) -> tuple[float, bool]:
    """Return the duration of the next piece of a time step [s], then whether an event ends this piece.

    Events are balls that enter or leave a loaded arc or meet. ``left``: time that remains of the step [s]; ``step``:
    duration of the whole step [s]; ``time_to_event``: time until the next event [s]; ``after_event``: whether an event
    ended the preceding piece, so that this one is to be short.
    """
    short = SHORT * step
    limit = min(short, left) if after_event else left
    if time_to_event >= limit:
        piece, ends = limit, False
    elif time_to_event > 2.0 * short:
        piece, ends = time_to_event - short, False
    else:
        piece, ends = max(time_to_event, TINY * step), True
    return (left, ends) if left - piece < TINY * step else (piece, ends)


def _history_from_pieces(
    rows: list[dict[str, Any]], setting: SimulatedSystem, duration: float, steps: int, status: str
) -> TravelHistory:
    """Return the time history of a simulation from its values at all pieces of the time steps.

    ``rows``: for each piece a dictionary of values by the names of the fields of `TravelHistory`; ``setting``: screw or
    bearing that was simulated; ``duration``: time that was to be simulated [s]; ``steps``: number of equal time steps;
    ``status``: text for the field of this name. The status "converged" is replaced by a text with the first angle at
    which a piece did not converge, if there is one.
    """
    direct = ("setting", "span", "steps", "status")
    arrays = {f.name: np.array([row[f.name] for row in rows]) for f in fields(TravelHistory) if f.name not in direct}
    run = TravelHistory(setting, duration, steps, status=status, **arrays)
    if status != "converged" or run.converged.all():
        return run
    first = np.degrees(run.rotation_angle[np.argmin(run.converged)])
    return replace(run, status=f"no balance of friction found at a rotation of {first:.6g} deg")


def travel(
    setting: SimulatedSystem,
    duration: float,
    steps: int,
    scheme: Scheme = "located",
    report: Callable[[float], object] = float,
) -> Search[TravelHistory]:
    """Search for the time history of balls that travel round their closed tracks, simulated in equal time steps.

    The scheme "located" divides a step at every event: a ball enters or leaves a loaded arc, or meets its neighbour.
    The gaps between balls are never negative, and their sum on a track does not change. The simulation ends early where
    no contact loads are found; the field ``status`` of the result then tells why.

    Parameters
    ----------
    setting
        Screw or bearing: its tracks, loads and friction.
    duration
        Time to simulate [s].
    steps
        Number of equal time steps.
    scheme
        ``"located"``: steps divided at events, second order; ``"equal"``: steps not divided, first order.
    report
        Function that is called after each step with the fraction of the steps that is done, from 0 to 1.

    Raises
    ------
    ValueError
        ``steps`` is below 1, or ``duration`` is not above zero.

    References
    ----------
    Lin (2019), section 3.4.4, for the scheme "equal".
    """
    if steps < 1 or not duration > 0.0:
        raise ValueError(f"a simulation needs at least 1 step and a duration above 0 s, got {steps} steps and {duration} s")
    dt, place, rows, located = duration / steps, setting.state_at_start(), list[dict[str, Any]](), scheme == "located"
    speed = abs(setting.groove.speed)
    if located:
        first = yield from setting.solve_at_instant(place.azimuth, 0.0, np.full(place.gap.size, np.inf), place.memory)
        if not isinstance(first, str):  # speeds of the first half step
            place = place._replace(omega=first.omega, memory=first.memory)
    for k in range(steps):
        left, after, count = dt, False, 0
        while left > 0.0:
            piece, begin, count = left, k * dt + (dt - left), count + 1
            if located and count < PIECES:
                arc_end = setting.time_to_next_arc_end(place.azimuth, place.omega, begin)
                event = min(arc_end, _time_until_neighbours_meet(place, setting.tracks))
                piece, after = _next_piece_of_step(left, dt, event, after)
            ahead = 0.5 * piece if located else 0.0
            azimuth, time = place.azimuth + ahead * place.omega, begin + ahead
            slack = place.gap / piece
            if located:
                slack = np.where(slack > FASTEST * np.abs(place.omega).max(), np.inf, slack)
            instant = yield from setting.solve_at_instant(azimuth, time, slack, place.memory)
            if isinstance(instant, str):
                ended = f"at a rotation of {np.degrees(speed * time):.6g} deg: {instant}"
                return _history_from_pieces(rows, setting, duration, steps, ended)
            place = _state_after_piece(setting, place, instant, piece)
            loss = sum(instant.losses)
            rows.append(
                {name: value for name, value in vars(instant).items() if name != "memory"}
                | {"time": time, "lasts": piece, "step": k, "azimuth": azimuth, "gap": place.gap}
                | dict(zip(TORQUES, (part / speed for part in instant.losses), strict=True))
                | {"imbalance": (instant.input_power - loss) / loss if loss > 0.0 else instant.input_power}
            )
            left -= piece
        report((k + 1) / steps)
    return _history_from_pieces(rows, setting, duration, steps, "converged")


def simulate(
    setting: SimulatedSystem, duration: float, steps: int, report: Callable[[float], object] = float
) -> TravelHistory:
    """Return the time history of balls that travel round their closed tracks; arguments and errors: see `travel`."""
    return solve_alone(travel(setting, duration, steps, report=report))


def ignore_progress(steps: str, share: float) -> None:
    """Do nothing: the default function to which `simulate_with_step_errors` reports progress.

    ``steps``: text that names the number of time steps; ``share``: fraction of them that is done.
    """


def simulate_with_step_errors(
    setting: SimulatedSystem,
    duration: float,
    steps: int | None,
    goal: float,
    report: Callable[[str, float], object] = ignore_progress,
) -> tuple[TravelHistory, TimeStepErrors | None]:
    """Simulate balls that travel round their tracks, and estimate the errors due to the finite time steps.

    Parameters
    ----------
    setting
        Screw or bearing: its tracks, loads and friction.
    duration
        Time to simulate [s].
    steps
        Number of equal time steps of the simulation that is returned; two simulations with about a quarter and half of this
        number are made for comparison. With None the number of steps is doubled until no estimated error is above ``goal``.
    goal
        Largest error that finite time steps may cause, as a ratio to the mean friction torque; only used if ``steps`` is
        None.
    report
        Function that is called with a text that states the number of steps of the present simulation, and with the
        fraction of these steps that is done.

    Returns
    -------
    tuple[TravelHistory, TimeStepErrors | None]
        The simulation with the most time steps, and its errors. The errors are None if the simulation ended early or has
        fewer than four steps.
    """
    if steps is None:
        pitches = abs(float(setting.state_at_start().omega[0])) * duration / setting.tracks[0].spacing
        first = int(np.clip(np.ceil(STEPS_PER_PITCH * pitches), *FIRST_STEPS))
        counts = [first * 2**k for k in range(20) if first * 2**k <= MOST]
    else:
        counts = sorted({max(1, steps // 4), max(1, steps // 2), steps})
    levels, error = list[TravelHistory](), None
    for count in counts:
        levels.append(simulate(setting, duration, count, partial(report, f"{count} steps")))
        if not levels[-1].fully_converged:
            return levels[-1], None
        error = estimate_time_step_errors(levels)
        if steps is None and error is not None and error.all_errors_within(goal):
            break
    return levels[-1], error


def _state_after_piece(setting: SimulatedSystem, place: BallState, instant: InstantSolution, piece: float) -> BallState:
    """Return azimuths, gaps and orbital speeds of the balls after one piece of a time step.

    ``setting``: screw or bearing with its tracks; ``place``: state before the piece; ``instant``: solution whose speeds
    the balls keep during the piece; ``piece``: duration [s].
    """
    gap = np.empty_like(place.gap)
    for track in setting.tracks:
        omega = instant.omega[track.balls]
        # never less than zero but for round-off
        gap[track.balls] = np.maximum(place.gap[track.balls] + piece * (np.roll(omega, -1) - omega), 0.0)
    return BallState(place.azimuth + piece * instant.omega, gap, instant.omega, instant.memory)


#: Order of convergence of the error for smooth motion and for jumps of the torque; factor by which the change between two
#: simulations is multiplied to estimate the error where no order is observed.
SMOOTH, OF_JUMPS, UNCLEAR = 2.0, 1.0, 10.0

#: Order of convergence below which Richardson's extrapolation would give a factor above ``UNCLEAR``; the order then counts
#: as not observed.
LEAST = float(np.log2(1.0 + 1.0 / UNCLEAR))

#: Safety factor on an extrapolated error.
SAFETY = 1.25

#: Largest number of time steps of a simulation.
MOST = 20_000

#: Change between two simulations, as a fraction of the mean torque, below which it is round-off and shows no order.
ROUND_OFF = 1e-9


@dataclass(frozen=True)
class TimeStepErrorEstimate:
    """Estimated error of one quantity of a simulation due to its finite time steps."""

    #: Estimated error as a ratio to the mean friction torque.
    error: float
    #: Order of convergence observed over three simulations; nan where the changes between them are round-off.
    order: float = float("nan")
    #: Order of convergence with which the error is extrapolated; nan where no order is observed.
    order_used: float = SMOOTH

    @property
    def no_order_observed(self) -> bool:
        """Whether no order of convergence is observed, so that the error is only a cautious guess."""
        return bool(np.isnan(self.order_used))


@dataclass(frozen=True)
class TimeStepErrors:
    """Estimated errors of the results of a simulation due to its finite time steps."""

    #: Estimated errors by the name of the quantity: "torque" (friction torque as a function of the angle), "mean",
    #: "largest" and "least" (mean, largest and least friction torque), and "share" (largest ratio of the friction torque
    #: between balls to that in the grooves).
    errors_by_quantity: dict[str, TimeStepErrorEstimate]
    #: Numbers of time steps of the three simulations that are compared, in increasing order.
    step_counts: tuple[int, ...]

    @property
    def largest_error(self) -> float:
        """Largest of the estimated errors of all quantities, as a ratio to the mean torque."""
        return max(q.error for q in self.errors_by_quantity.values())

    @property
    def quantities_without_order(self) -> tuple[str, ...]:
        """Names of the quantities, keys of ``errors_by_quantity``, for which no order of convergence is observed."""
        return tuple(name for name, q in self.errors_by_quantity.items() if q.no_order_observed)

    def all_errors_within(self, goal: float) -> bool:
        """Return whether every estimated error is at most ``goal``, a fraction of the mean torque."""
        return self.largest_error <= goal


def mean_torque_difference(long_step_torques: Array, short_step_torques: Array) -> float:
    """Return the mean absolute difference between the torques of two simulations over the same time, in their unit.

    ``long_step_torques``: mean torque in each of the S time steps of the simulation with longer steps ``(S,)``;
    ``short_step_torques``: mean torque in each of the S' >= S steps of the other simulation ``(S',)``, which is
    averaged over the longer steps before the comparison.
    """
    at = np.arange(long_step_torques.size + 1) * (short_step_torques.size / long_step_torques.size)
    work = np.interp(at, np.arange(short_step_torques.size + 1), np.concatenate([[0.0], np.cumsum(short_step_torques)]))
    return float(np.mean(np.abs(np.diff(work) * (long_step_torques.size / short_step_torques.size) - long_step_torques)))


def extrapolated_error(first_change: float, last_change: float, jumps: bool = False) -> TimeStepErrorEstimate:
    """Return the estimated error of a quantity due to finite time steps, from three simulations with ever shorter steps.

    The number of steps is doubled from one simulation to the next. ``first_change``: change of the quantity from the
    first to the second simulation; ``last_change``: change from the second to the third simulation, which has the
    shortest steps, both as ratios to the mean torque. Richardson's extrapolation uses the observed order of
    convergence, but at most that of smooth motion. If the quantity may have ``jumps``, it uses the order for jumps
    unless the observed one is near that of smooth motion. Changes that grow, keep their size, or change their sign show
    no order: the error is then ``UNCLEAR`` times the largest change.
    """
    most = max(abs(first_change), abs(last_change), abs(first_change + last_change))
    if most <= ROUND_OFF:
        return TimeStepErrorEstimate(most)
    order = float(np.log2(max(abs(first_change), 1e-300) / max(abs(last_change), 1e-300)))
    if first_change * last_change < 0.0 or order < LEAST:
        return TimeStepErrorEstimate(UNCLEAR * most, order, float("nan"))
    used = min(order, SMOOTH if not jumps or order > SMOOTH - 0.5 else OF_JUMPS)
    error = SAFETY * max(abs(last_change), abs(first_change) / 2.0**used) / (2.0**used - 1.0)
    return TimeStepErrorEstimate(error, order, used)


def estimate_time_step_errors(levels: Sequence[TravelHistory]) -> TimeStepErrors | None:
    """Return the estimated errors of a simulation due to its finite time steps, by comparison with two coarser simulations.

    ``levels``: simulations of the same motion in the order of increasing numbers of time steps, of which the last three are
    compared and the errors of the last one are returned. The result is None for fewer than three simulations, or if the
    numbers of steps do not increase. Simulations may by chance agree on a wrong time of a jump of the torque: the error of
    the torque is therefore at least the mean error over time that arises if the largest jump between two successive steps
    occurs half a step too early or too late.
    """
    steps = tuple(level.mean_torque_per_step.size for level in levels[-3:])
    if len(steps) < 3 or not steps[0] < steps[1] < steps[2]:
        return None
    one, two, three = (level.mean_torque_per_step for level in levels[-3:])
    size = abs(float(three.mean()))
    if size == 0.0:
        return TimeStepErrors({"torque": TimeStepErrorEstimate(0.0)}, steps)
    changes = (mean_torque_difference(one, two) / size, mean_torque_difference(two, three) / size)
    over = extrapolated_error(*changes, jumps=True)
    least = 0.5 * float(np.abs(np.diff(three)).max(initial=0.0)) / (steps[-1] * size)
    errors = {"torque": replace(over, error=max(over.error, least))}
    numbers = [
        {name: value / size for name, value in x.torque_statistics.items()} | {"share": x.largest_ball_to_groove_ratio}
        for x in levels[-3:]
    ]
    for name, value in numbers[-1].items():
        if not np.isnan(value):
            errors[name] = extrapolated_error(numbers[1][name] - numbers[0][name], value - numbers[1][name])
    return TimeStepErrors(errors, steps)
