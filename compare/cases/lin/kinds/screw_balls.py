"""Scene files for friction in ball screws (Lin 3.4): "screw pair", two balls, and "screw run", a whole screw over time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import degrees, pi
from typing import Annotated, Any, ClassVar, Literal

import numpy as np

from rollbench.compare.cases.lin.kinds import common
from rollbench.compare.cases.lin.kinds.common import head_of_scene
from rollbench.compare.scenes.duty_cycle import FrictionScene
from rollbench.compare.scenes.fault import Fault, length_text
from rollbench.compare.scenes.key_checks import simulation_time_faults
from rollbench.compare.scenes.keys import BallHelixKeys, BallSizeKeys, SceneFileTable, record_from_keys
from rollbench.lowfi.friction.screw.groove import ScrewGroove
from rollbench.lowfi.friction.screw.motion import Coupling
from rollbench.lowfi.friction.screw.run import Pair, Run
from rollbench.meshes import ranges
from rollbench.meshes.parts import Motion, Time
from rollbench.meshes.ranges import Azimuth, Force, ListLength, Plain, QuantityRange, Turning, Turns
from rollbench.meshes.record_keys import scene_key
from rollbench.meshes.scene_text import Table, keys_of_record, with_unit, without_empty_values

#: Factor on the deviation of a contact angle.
Share = Annotated[float, QuantityRange("number", -1, 1, 1)]
#: Factors on the deviation for the contact angles at SL, SR, NL, NR (screw or nut, left or right).
Pattern = Annotated[tuple[Share, ...], ListLength(4, 4)]
#: Fraction of the distance between balls.
Part = Annotated[float, QuantityRange("number", 0, 1, 0.5)]
#: Number of periods of the angle deviation per turn of the screw.
Cycles = Annotated[float, QuantityRange("number", 0, 1000, 2)]
#: Direction in which the screw can move.
Direction = Literal["axial", "radial"]
#: Largest number of balls times number of time steps, because the results of all steps are stored.
MOST = 5_000_000
#: Name in the friction solvers of the direction in which the screw can move.
FREE_TRANSLATION: dict[Direction, str] = {"axial": "z", "radial": "r"}
_PATTERN = "factors on the deviation for the contact angles at SL, SR, NL, NR (screw or nut, left or right)"


class ScrewLoadKeys(SceneFileTable):
    """Force on the screw, and the direction in which it acts and the screw can move; the nut is fixed."""

    force: common.AxialLoad = scene_key("force on the screw")
    direction: Direction = scene_key(
        "direction of the force and of the screw's motion: along the axis, or radial at every ball",
        "axial",
        default="axial",
    )


class ScrewFrictionKeys(common.BallFrictionKeys):
    """Coefficients of Coulomb friction at grooves and between balls, and the bodies that friction displaces.

    Friction that displaces the balls changes their contact loads; it may also change the position of the screw.
    """

    coupling: Coupling = scene_key(
        "bodies whose displacement by friction changes the contact loads: none, the balls, or balls and screw",
        "ball",
        default="none",
    )


class BallPairAngleKeys(SceneFileTable):
    """Deviations of the contact angles of two balls from the nominal contact angle."""

    deviations: Annotated[tuple[common.Theta, ...], ListLength(2, 2)] = scene_key(
        "deviation theta from the nominal angle at the rear ball and at the front ball", ["0 deg", "2 deg"]
    )
    pattern: Pattern = scene_key(_PATTERN, [1, 1, 0, 0], default=(1.0, 1.0, 0.0, 0.0))


class AngleVariationKeys(SceneFileTable):
    """Deviation of contact angles from the nominal angle: theta = amplitude * sin(cycles_per_turn * azimuth + phase)."""

    amplitude: common.Theta = scene_key("amplitude of theta")
    cycles_per_turn: Cycles = scene_key("number of periods of theta per turn of the screw", 2, default=2.0)
    phase: Azimuth = scene_key("phase of theta", "90 deg", default=0.0)
    pattern: Pattern = scene_key(_PATTERN, [1, 1, 0, 0], default=(1.0, 1.0, 0.0, 0.0))
    follows: Literal["screw", "nut"] = scene_key(
        "part to which the pattern of theta is attached, and in whose axes the azimuth is measured", "nut", default="screw"
    )


class CircuitBallKeys(BallSizeKeys):
    """Balls of a closed ball circuit: size, number, and loaded turns."""

    count: Annotated[int, Plain("int", 2, 1000)] = scene_key("number of balls", 37)
    turns: Turns = scene_key("number of turns in the nut over which balls carry load")


class BallReturnKeys(SceneFileTable):
    """Return of the balls in a closed circuit: length of the return tube, and position of the first ball."""

    return_tube: common.Gap = scene_key("length of the return tube, in which balls carry no load", "5.6 mm", default=0.0)
    first_ball: Part = scene_key(
        "initial position of the first ball, as a fraction of the distance between balls", 0.5, default=0.5
    )


class SimulationTimeKeys(SceneFileTable, Time):
    """Duration and number of steps of a simulation over time, and iterations between loads and friction in each step.

    One iteration solves the contact loads under given friction, then the friction under these loads.
    """

    rounds: Annotated[int, Plain("int", 1, 100)] = scene_key(
        "iterations in each time step, each of the contact loads and then of friction; 1: contact loads under the "
        "friction of the previous time step",
        1,
        default=1,
    )


class BallScrewFrictionKeys(common.HertzSceneKeys, common.EqualGrooveKeys):
    """Ball screw with load, motion and friction; only the speed of nut and screw relative to each other matters."""

    track: BallHelixKeys = scene_key("path of the ball centres")  # type: ignore[assignment] # a bearing has no hand
    load: ScrewLoadKeys = scene_key("force on the screw")
    motion: Motion = scene_key("motion along the helix")
    friction: ScrewFrictionKeys = scene_key("friction")


class ScrewPairKeys(BallScrewFrictionKeys):
    """Two neighbouring balls of a ball screw that touch each other."""

    kind: Literal["screw pair"] = scene_key("what the scene describes", "screw pair")
    angles: BallPairAngleKeys = scene_key("contact angles")


class ScrewSimulationKeys(BallScrewFrictionKeys):
    """Whole ball screw that turns for some time."""

    kind: Literal["screw run"] = scene_key("what the scene describes", "screw run")
    balls: CircuitBallKeys = scene_key("balls of the closed track")
    circulation: BallReturnKeys = scene_key("return of the balls", {"return_tube": "5.6 mm"}, default=BallReturnKeys())
    angles: AngleVariationKeys = scene_key("contact angles")
    time: SimulationTimeKeys = scene_key("simulation over time", {"duration": "2 s"})


@dataclass(frozen=True)
class ScrewPairScene(FrictionScene):
    """Scene of two neighbouring balls of a ball screw that touch each other."""

    #: Kind of the scene, as its file names it.
    kind: ClassVar[str] = "screw pair"
    #: The two balls with grooves, load and friction.
    pair: Pair

    def file_tables(self) -> Table:
        """Return the tables of the scene file of two balls of a screw."""
        angles = {"deviations": [with_unit(common.Theta, x) for x in self.pair.theta], "pattern": [*self.pair.pattern[0]]}
        return _shared_screw_tables(self.pair.groove, self.pair, angles)


@dataclass(frozen=True)
class ScrewRunScene(FrictionScene):
    """Scene of a whole ball screw that turns for some time."""

    #: Kind of the scene, as its file names it.
    kind: ClassVar[str] = "screw run"
    #: Screw, balls, load, motion and friction of the simulation.
    run: Run
    #: Duration and steps of the simulation.
    time: Time

    def file_tables(self) -> Table:
        """Return the tables of the scene file for a transient simulation of a whole ball screw."""
        run = self.run
        angles: Table = {"amplitude": with_unit(common.Theta, run.amplitude), "cycles_per_turn": run.cycles}
        angles |= {"phase": with_unit(Azimuth, run.phase), "pattern": [*run.pattern], "follows": run.follows}
        table, radius = _shared_screw_tables(run.groove, run, angles), run.groove.radius
        lengths = (float(f"{run.tube * radius:.{digits}g}") for digits in range(1, 18))
        tube = next((length for length in lengths if length / radius == run.tube), run.tube * radius)
        table["balls"] |= {"count": run.count, "turns": run.turns}
        table["circulation"] = {"return_tube": with_unit(ranges.Clearance, tube), "first_ball": run.first}
        return table | {"time": keys_of_record(self.time) | {"rounds": run.rounds}}


# --- faults of keys


def ball_screw_faults(keys: ScrewPairKeys | ScrewSimulationKeys) -> Iterator[Fault]:
    """Yield the faults of a scene file of ball-screw friction: contradictory keys, and geometry the models do not cover."""
    wrong = list(common.material_faults(keys.material))
    wrong = wrong or list(common.groove_and_path_faults(keys, is_bearing=False))
    wrong = wrong or list(_angle_and_load_faults(keys))
    if not wrong and isinstance(keys, ScrewSimulationKeys):
        wrong = list(_screw_simulation_faults(keys))
    yield from wrong


def _angle_and_load_faults(keys: ScrewPairKeys | ScrewSimulationKeys) -> Iterator[Fault]:
    """Yield the faults of the keys for contact angles, ball size, Hertz constants and load of the balls of a screw."""
    pair = isinstance(keys, ScrewPairKeys)
    where = "angles.deviations" if pair else "angles.amplitude"
    largest = max(map(abs, keys.angles.deviations)) if isinstance(keys, ScrewPairKeys) else abs(keys.angles.amplitude)
    nominal = keys.track.contact_angle
    room = min(nominal, 0.5 * pi - nominal)
    if largest * max(map(abs, keys.angles.pattern)) >= room:
        advice = f"choose a smaller deviation; the nominal contact angle is {degrees(nominal):.6g} deg"
        yield Fault((where,), "contact angles above 0 deg, below 90 deg", advice)
    try:
        _ = _screw_groove_from_keys(keys).pair
    except ValueError:
        advice = "choose smaller balls: the centres of touching balls must be less than a quarter of a turn apart"
        yield Fault(("balls.radius",), f"small against the pitch radius, {length_text(keys.track.pitch_radius)}", advice)
    yield from common.missing_hertz_constant_faults(_screw_groove_from_keys(keys))
    if keys.load.force == 0.0 and keys.errors.balls.oversize <= 0.0:
        advice = "give a force, or an oversize above 0 um; without them the balls carry no load"
        yield Fault(("load.force",), "not zero for balls without oversize", advice)


def _screw_simulation_faults(keys: ScrewSimulationKeys) -> Iterator[Fault]:
    """Yield the faults of the keys for speed, number of balls and time steps of the simulation of a whole screw."""
    if keys.motion.speed == 0.0:
        advice = "let nut and screw turn relative to each other; friction torque is computed for a moving screw"
        yield Fault(("motion.speed",), "any angular speed except zero", advice)
    groove, count = _screw_groove_from_keys(keys), keys.balls.count
    ring = 2.0 * pi * keys.balls.turns + keys.circulation.return_tube / groove.radius
    most = int(np.ceil(ring / groove.pair.spacing)) - 1
    if count > most:
        advice = "choose fewer balls, more turns or a longer return tube; the balls need some free length on the track"
        yield Fault(("balls.count",), f"2 to {most} on this track" if most > 1 else "none on so short a track", advice)
    yield from simulation_time_faults(keys.time)
    if keys.time.steps is not None and count * keys.time.steps > MOST:
        advice = "choose fewer steps or fewer balls; the results of all steps are stored"
        yield Fault(("time.steps",), f"1 to {MOST // count} with {count} balls", advice)


# --- records


def _screw_groove_from_keys(keys: ScrewPairKeys | ScrewSimulationKeys) -> ScrewGroove:
    """Return grooves, balls, speeds and friction of a ball screw from the validated keys of its scene file."""
    track, motion = keys.track, keys.motion
    speeds = (motion.speed, 0.0) if motion.turns == "nut" else (0.0, motion.speed)
    lead = -track.lead if track.hand == "left" else track.lead
    return common.grooves_from_keys(ScrewGroove, keys, keys, lead, speeds, mu_balls=keys.friction.balls)


def screw_pair_scene(keys: ScrewPairKeys, name: str) -> ScrewPairScene:
    """Return the scene ``name`` of two balls of a ball screw from the validated keys of its file."""
    first, second = keys.angles.deviations
    pattern = tuple(keys.angles.pattern)
    pair = Pair(
        _screw_groove_from_keys(keys),
        (first, second),
        (pattern, pattern),
        keys.errors.balls.oversize,
        FREE_TRANSLATION[keys.load.direction],
        (keys.load.force,),
        keys.friction.coupling,
    )
    return ScrewPairScene(*head_of_scene(keys, name), pair)


def screw_run_scene(keys: ScrewSimulationKeys, name: str) -> ScrewRunScene:
    """Return the scene ``name`` of a ball screw simulated over time from the validated keys of its file."""
    groove, a = _screw_groove_from_keys(keys), keys.angles
    time = record_from_keys(Time, keys.time)
    run = Run(
        groove,
        keys.balls.count,
        keys.balls.turns,
        (keys.load.force,),
        FREE_TRANSLATION[keys.load.direction],
        time.span(Motion(keys.motion.speed)),
        time.steps or 1,
        keys.errors.balls.oversize,
        a.amplitude,
        a.cycles_per_turn,
        a.phase,
        tuple(a.pattern),
        keys.circulation.return_tube / groove.radius,
        keys.circulation.first_ball,
        keys.friction.coupling,
        keys.time.rounds,
        a.follows,
    )
    return ScrewRunScene(*head_of_scene(keys, name), run, time)


def _shared_screw_tables(groove: ScrewGroove, pair_or_run: Any, angles: Table) -> Table:
    """Return the tables that scene files of two balls of a screw and of a simulated whole screw have in common.

    ``groove``: grooves, balls, speeds and friction; ``pair_or_run``: record of the two balls or of the simulation, with
    ball oversize, force on the screw, direction in which the screw can move, and bodies that friction displaces;
    ``angles``: table of the contact angles.
    """
    by_nut = groove.nut_speed != 0.0
    speed = {"speed": with_unit(Turning, groove.nut_speed if by_nut else groove.screw_speed)}
    direction = next(name for name, letter in FREE_TRANSLATION.items() if letter == pair_or_run.free)
    return {
        "material": common.material_table(groove.young, groove.poisson),
        **common.track_and_groove_tables(groove, pair_or_run.oversize),
        "angles": angles,
        **common.hertz_table(groove),
        "load": {"force": with_unit(Force, pair_or_run.force[0]), "direction": direction},
        "motion": speed | ({"turns": "nut"} if by_nut else {}),
        "friction": {
            "coefficient": groove.mu,
            **without_empty_values(balls=groove.mu_balls),
            "coupling": pair_or_run.coupling,
        },
    }
