"""Solutions of scenes with all their results, motor torques of a feed axis, and lives over a duty cycle."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from rollbench.compare.measure import error_percent
from rollbench.compare.models import answers as models_answers
from rollbench.compare.models.loading import absolute_axial_preload, load_path_warnings
from rollbench.compare.models.model_form import ExpectedModelErrors, estimate_double_nut_error, estimate_model_error
from rollbench.compare.models.registry import ModelOptions, run_model
from rollbench.compare.scenes.duty_cycle import DutyCycle, LoadCase
from rollbench.lowfi.bearings.axis import DriveTorqueParts, acceleration_torque, reflected_inertia, screw_inertia
from rollbench.lowfi.bearings.torque import BallBearingTorque, Band, roller_bearing_torque
from rollbench.lowfi.rating import iso_lives, roller_life
from rollbench.lowfi.rating import life as rating_life
from rollbench.lowfi.rating.catalogue_checks import warn_of_overall_friction_coefficient
from rollbench.lowfi.rating.iso_lives import ModifiedLife, modified_life
from rollbench.lowfi.statics.result import AxisResult, SetResult, StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, RollerRow
from rollbench.meshes.parts import Scene
from rollbench.meshes.quantity import QuantityDescription, quantity_field, result_record

#: Smallest and largest efficiency of a nut that accelerates a mass, if the scene states none (Smith 4.3.1) [1].
EFFICIENCY: Band = (0.90, 0.95)
#: Reason why the running torque of a bearing is not known.
NOT_RUNNING = "the running torque of a bearing needs the tables [lubricant] and [motion]"
#: By the number of each nut on the shaft, from 0: its friction torques and efficiencies as JSON values, or None; and the
#: reason why they are not known, else empty.
NutSums = Mapping[int, tuple[dict[str, Any] | None, str]]


@result_record
class ShaftTorque:
    """Torque that one nut or bearing row requires for turning the shaft; ranges (low, high) [N m] are None if not known."""

    name: str = quantity_field("name", "name of the nut or bearing row")
    running: Band | None = quantity_field(
        "running_Nmm",
        "torque, without seals, that this nut or bearing row requires for turning the shaft steadily: a nut for its load "
        "and its friction, a bearing for its friction; negative where the load drives the shaft",
        parts="[]",
    )
    starting: Band | None = quantity_field(
        "starting_Nmm", "torque, without seals, that this nut or bearing row requires for starting from rest", parts="[]"
    )
    seals: float = quantity_field(
        "seals_Nmm",
        "friction torque of the seals and wipers of this nut or bearing row, as the scene states it",
        default=0.0,
    )
    words: str = quantity_field("words", "why the torque is not known", show=lambda words: words or None, default="")


@result_record
class AxisDrive:
    """Torques (low, high) [N m] and moments of inertia [kg m^2] at the motor of a feed axis.

    They follow equations 4.10 to 4.15 of Smith (1994).
    """

    #: Torque that each nut or bearing row requires for turning the shaft.
    sets: tuple[ShaftTorque, ...] = quantity_field("sets")
    seals: float = quantity_field(
        "seals_Nmm", "friction torque of all seals and wipers on the shaft, as the scene states it"
    )
    other: float = quantity_field("other_Nmm", "friction torque of all other parts, as the scene states it under [drive]")
    running: Band | None = quantity_field(
        "running_torque_Nmm",
        "torque of the motor at constant speed: sum over all nuts, bearings, seals and other parts (Smith 4.10); null "
        "where one of these torques is not known",
        heading="motor torque, running",
        form="g3",
        error="empirical; that of the coefficient of friction",
        parts="[]",
    )
    starting: Band | None = quantity_field(
        "starting_torque_Nmm",
        "torque of the motor that starts the shaft from rest: of all nuts, bearings, seals and other parts",
        error="empirical; that of the coefficient of friction",
        parts="[]",
        heading="motor torque from rest",
        form="g3",
    )
    accelerating: Band | None = quantity_field(
        "accelerating_torque_Nmm",
        "torque of the motor during acceleration: torque at constant speed, plus angular acceleration times the moments of "
        "inertia, of which that of the moved mass is divided by the efficiency of the nut (Smith 4.11); null without an "
        "acceleration time",
        heading="motor torque, accelerating",
        form="g3",
        error="that of the torque at constant speed",
        parts="[]",
    )
    shaft_inertia: float = quantity_field(
        "shaft_inertia_kg_mm2", "moment of inertia of the shaft (Smith 4.14), without inner rings"
    )
    reflected_inertia: float = quantity_field(
        "reflected_inertia_kg_mm2", "moment of inertia that the moved mass adds, m (p/(2 pi))^2 (Smith 4.15)"
    )
    inertia: float = quantity_field(
        "inertia_kg_mm2", "sum of the moments of inertia of shaft, moved mass and motor", heading="moment of inertia"
    )


def friction_of_nuts(assembly: Assembly, result: AxisResult) -> NutSums:
    """Return the friction torques and efficiencies of every nut on a shaft, or the reason why they are not known.

    Parameters
    ----------
    assembly
        Shaft with several nuts or bearing rows.
    result
        Converged result of the assembly.

    Returns
    -------
    dict
        For the number (from 0) of each nut: its friction results as JSON values, or None and the reason.
    """
    nuts = {
        i: (replace(s.of.parts, friction=assembly.friction, motion=assembly.motion), s.balls)
        for i, s in enumerate(result.sets)
        if isinstance(s.of.parts, Scene) and s.of.parts.track.lead and s.balls is not None
    }
    if assembly.friction is None:
        return dict.fromkeys(nuts, (None, "no coefficient in [friction]"))
    from rollbench.compare.models.friction_sums import friction_results_of_scenes  # heavy import

    solved = [(parts, assembly.friction, balls) for parts, balls in nuts.values()]
    return dict(zip(nuts, friction_results_of_scenes(solved, result.member), strict=True))


def motor_torques_and_inertias(
    assembly: Assembly, result: AxisResult, derived_results: models_answers.ShaftResults, friction_of_nuts: NutSums
) -> AxisDrive | None:
    """Compute torques and moments of inertia at the motor of a feed axis with a turning shaft.

    Bearings whose inner ring sits on a moving housing do not turn with the shaft and are omitted.

    Parameters
    ----------
    assembly
        Shaft with several nuts or bearing rows.
    result
        Converged result of the assembly.
    derived_results
        Friction torques of the bearings and other results that follow from ``result``.
    friction_of_nuts
        For the number (from 0) of each nut, its friction results or the reason why there are none, as the function
        `friction_of_nuts` returns them.

    Returns
    -------
    AxisDrive or None
        Torques and inertias; None if the nuts turn instead of the shaft.
    """
    drive, motion = assembly.drive, assembly.motion
    if motion is not None and motion.turns != "screw":
        return None
    sign = -1.0 if motion is not None and motion.speed < 0.0 else 1.0
    turning = [i for i, s in enumerate(result.sets) if s.of.carrier is None]
    found = (
        _driving_torque_of_nut(result.sets[i].of.name, *friction_of_nuts[i], sign)
        if i in friction_of_nuts
        else _friction_torque_of_bearing(assembly, result.sets[i], derived_results.set_results[i].friction_torque)
        for i in turning
    )
    sets = tuple(replace(x, seals=result.sets[i].of.seals) for x, i in zip(found, turning, strict=True))
    seals, lead = sum(result.sets[i].of.seals for i in turning), lead_of_first_nut(assembly)

    def total(torques: list[Band | None]) -> Band | None:
        """Return the sum of the friction torques of all nuts and bearings, seals and other parts (Smith 4.10) [N m].

        ``torques``: torque of each nut or bearing, (low, high) [N m]; the sum is None if one of them is None (not known).
        """
        known = [x for x in torques if x is not None]
        if len(known) < len(torques):
            return None
        ends = [tuple(x[k] for x in known) for k in (0, 1)]
        low, high = (DriveTorqueParts(drive.torque, seals, end, 0.0).constant_speed_torque for end in ends)
        return low, high

    running, starting = (total([getattr(s, name) for s in sets]) for name in ("running", "starting"))
    inertias = [screw_inertia(assembly, drive.density), drive.motor_inertia]
    accelerating = None
    if running is not None and motion is not None and drive.time is not None:
        worst, best = EFFICIENCY if drive.efficiency is None else (drive.efficiency, drive.efficiency)
        each = [[*inertias, reflected_inertia(drive.mass, lead, e)] for e in (best, worst)]
        low, high = (acceleration_torque(of, abs(motion.speed), drive.time) for of in each)
        accelerating = running[0] + low, running[1] + high
    carried = reflected_inertia(drive.mass, lead)
    whole = sum(inertias) + carried
    return AxisDrive(sets, seals, drive.torque, running, starting, accelerating, inertias[0], carried, whole)


class LivesOfSet(Protocol):
    """Lives of one nut or bearing row."""

    @property
    def life(self) -> rating_life.BasicRatingLife | None:
        """Life L10; None if it is not known."""

    @property
    def life_by_loads(self) -> models_answers.LifeByLoads | None:
        """Life by the loads of the contacts; None if it is not known."""


def lead_of_first_nut(assembly: Assembly) -> float:
    """Return the lead [m] of the first nut on a shaft with several nuts or bearing rows; 0 without a nut."""
    return next((s.parts.track.lead for s in assembly.sets if isinstance(s.parts, Scene) and s.parts.track.lead), 0.0)


def _driving_torque_of_nut(name: str, friction_results: dict[str, Any] | None, reason: str, sign: float) -> ShaftTorque:
    """Return the torque with which the turning screw drives a nut.

    ``name``: name of the nut; ``friction_results``: its friction torques as JSON values; None: not known, for the reason
    ``reason``; ``sign``: -1 if the screw turns in the negative direction, else 1.
    """
    if friction_results is None or friction_results["driving_torque_on_screw_Nmm"] is None:
        return ShaftTorque(name, None, None, words=reason or "the friction of the balls did not converge")
    torque = 1e-3 * sign * friction_results["driving_torque_on_screw_Nmm"]
    return ShaftTorque(name, (torque, torque), (torque, torque))


def _friction_torque_of_bearing(assembly: Assembly, bearing: SetResult, torque: BallBearingTorque | None) -> ShaftTorque:
    """Return the friction torque of a bearing row, while it runs and when it starts from rest; zero without load.

    ``bearing``: solution of the row; ``torque``: friction torque if the row has balls; None for rollers or without
    load.
    """
    ends: tuple[Band | None, Band | None] = (0.0, 0.0), (0.0, 0.0)
    if torque is not None:
        ends = torque.running, torque.starting
    elif isinstance(bearing.of.parts, RollerRow) and bearing.line_loads is not None:
        speed = None if assembly.motion is None else assembly.motion.speed
        row = roller_bearing_torque(bearing.of.parts, bearing.line_loads, speed, assembly.lubricant)
        if row is not None:
            low, high = (row.torque if x is None else x for x in (row.low, row.high))
            ends = None if row.film is None else (low, high), (low - (row.film or 0.0), high - (row.film or 0.0))
    return ShaftTorque(bearing.of.name, *ends, words="" if ends[0] is not None else NOT_RUNNING)


def _life_of_turning_sets(
    assembly: Assembly, sets: Iterable[tuple[str, LivesOfSet]], speed: float | None
) -> rating_life.SystemLife | None:
    """Return the combined rating life of all nuts and bearing rows that turn; None if no life is known.

    ``sets``: name and lives of each nut or row; bearings whose rings stand still have none, see
    `lowfi.rating.life.turning_ring`. ``speed``: speed of the turning part [rad/s]; None: not known.
    """
    parts = {s.name: s.parts for s in assembly.sets}
    slopes = {n: roller_life.SLOPE if isinstance(x, RollerRow) else rating_life.SLOPE for n, x in parts.items()}
    turning = {name: (x.life_by_loads, x.life) for name, x in sets if x.life_by_loads is not None}
    if not turning:
        return None
    known = {n: (x.revolutions, slopes[n]) for n, (x, _) in turning.items() if x is not None}
    basic = [(x.revolutions, slopes[n]) for n, (_, x) in turning.items() if x is not None]
    in_series, shortest = rating_life.life_of_parts_in_series, min(known, key=lambda n: known[n][0])
    together, complete = in_series([*known.values()]), len(basic) == len(turning)
    return rating_life.SystemLife(
        together, shortest, lead_of_first_nut(assembly), speed, in_series(basic) if complete else None
    )


@dataclass(frozen=True)
class LoadsOfNutOrBearing:
    """Contact loads and force of one nut or bearing row in one load case, from which its life over a duty cycle follows."""

    #: Geometry of the nut or row; if it has balls, as a scene with all loads and supports of the shaft.
    parts: Scene | RollerRow
    #: Contact loads of n balls (n, 4) [N]; line loads of rollers (count, slices) [N/m].
    load: Array
    #: Force of the shaft on the nut or row, (3,) [N].
    force: Array
    #: Axial force with which the two halves of a nut with lead offset are preloaded against each other [N]; 0 for other
    #: nuts and for bearing rows.
    preload: float = 0.0


@dataclass(frozen=True)
class SceneSolution:
    """Solution of a scene with one nut or bearing row by one model, with all results that follow from the contact loads."""

    #: Scene with one nut or bearing row.
    scene: Scene
    #: Contact loads and displacements by the model, with all warnings.
    result: StaticResult
    #: Results that follow from the contact loads; None without equilibrium.
    derived_results: models_answers.SceneResults | None = None
    #: Expected error of the model's results; None without equilibrium.
    expected_errors: ExpectedModelErrors | None = None

    @property
    def contact_results(self) -> tuple[models_answers.ContactLoadResults, ...]:
        """Pressure, static safety and life of the nut or row, as a tuple of one item; empty without equilibrium."""
        return () if self.derived_results is None else (self.derived_results.load_results,)

    @property
    def loads_by_set(self) -> dict[str, LoadsOfNutOrBearing]:
        """Contact loads and force of the scene's only nut or row, under the name ""; empty without equilibrium."""
        if self.derived_results is None or self.result.equilibrium is None:
            return {}
        preload = absolute_axial_preload(self.derived_results.preload) if self.scene.errors.lead_offset else 0.0
        force = -self.result.equilibrium.contact_force
        return {"": LoadsOfNutOrBearing(self.scene, self.result.load, force, preload)}


@dataclass(frozen=True)
class ShaftSolution:
    """Solution of a shaft with several nuts or bearing rows by one model, with all results that follow from the loads."""

    #: Shaft with several nuts or bearing rows.
    scene: Assembly
    #: Contact loads and displacements by the model, with all warnings.
    result: AxisResult
    #: Results that follow from the contact loads; None without equilibrium.
    derived_results: models_answers.ShaftResults | None = None
    #: Expected error of the model's results for a double nut; None without equilibrium, and for other shafts.
    expected_errors: ExpectedModelErrors | None = None
    #: Torques and moments of inertia at the motor; None without equilibrium, or if the nuts turn instead of the shaft.
    motor_torques: AxisDrive | None = None
    #: Combined life of all nuts and rows that turn with the shaft; None if none of them has a life.
    combined_life: rating_life.SystemLife | None = None

    @property
    def contact_results(self) -> tuple[models_answers.LoadResults, ...]:
        """Pressure, static safety and life of each nut or row, rollers included; empty without equilibrium."""
        return () if self.derived_results is None else tuple(x.load_results for x in self.derived_results.set_results)

    @property
    def loads_by_set(self) -> dict[str, LoadsOfNutOrBearing]:
        """Contact loads and force of each nut or row by its name; empty without equilibrium."""
        if self.derived_results is None:
            return {}
        out = {}
        for s, answers in zip(self.result.sets, self.derived_results.set_results, strict=True):
            if isinstance(answers.parts, Scene) and s.balls is not None:
                parts = models_answers.parts_under_loads(self.scene, answers.parts)
                out[s.of.name] = LoadsOfNutOrBearing(parts, s.balls.load, -s.force)
            elif s.line_loads is not None:
                out[s.of.name] = LoadsOfNutOrBearing(answers.parts, s.line_loads, -s.force)
        return out


def solve_with_results(scene: Scene | Assembly, model: str, options: ModelOptions) -> SceneSolution | ShaftSolution:
    """Solve a scene by a model and compute all results: pressure, safety, life, rigidity, preload, friction.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row, or with several on one shaft; one load case.
    model
        Name of the model.
    options
        Options of the model.

    Returns
    -------
    SceneSolution or ShaftSolution
        The solution with all results.

    Raises
    ------
    InputError
        If the model does not cover the scene.
    """
    if isinstance(scene, Assembly):
        return solve_shaft_with_results(scene, model, options)
    return solve_scene_with_results(scene, model, options)


def solve_shaft_with_results(scene: Assembly, model: str, options: ModelOptions) -> ShaftSolution:
    """Solve a shaft with several nuts or bearing rows, and compute all results.

    InputError if the model does not cover the assembly.
    """
    result, answers = models_answers.solve_assembly_with_results(scene, model, options.member)
    if answers is None:
        return ShaftSolution(scene, result)
    drive = motor_torques_and_inertias(scene, result, answers, friction_of_nuts(scene, result))
    speed = None if scene.motion is None else scene.motion.speed
    life = _life_of_turning_sets(scene, ((x.name, x.load_results) for x in answers.set_results), speed)
    return ShaftSolution(scene, result, answers, estimate_double_nut_error(scene, result), drive, life)


def solve_scene_with_results(scene: Scene, model: str, options: ModelOptions) -> SceneSolution:
    """Solve a scene with one nut or bearing row, and compute all results; InputError if the model does not cover it."""
    result = run_model(scene, model, options)
    if not result.converged:
        return SceneSolution(scene, result)
    answers = models_answers.compute_scene_results(scene, result, model, options)
    warned = [*models_answers.validity_warnings(scene, answers.load_results, absolute_axial_preload(answers.preload))]
    if scene.friction is not None:
        warned += warn_of_overall_friction_coefficient(scene.track, scene.friction)
    warned += [*load_path_warnings(answers.load_path), *models_answers.axial_play_warnings(scene)]
    warned += [] if answers.shaft_limits is None else answers.shaft_limits.warnings
    result = replace(result, warnings=(*result.warnings, *warned))
    return SceneSolution(scene, result, answers, estimate_model_error(scene, result))


@dataclass(frozen=True)
class ExtremeOverLoadCases:
    """Largest or smallest value of a quantity over the load cases of a duty cycle, and the load case with this value."""

    #: Largest or smallest value, in SI units; errors in per cent.
    value: float
    #: Name of the load case with this value.
    case: str


@result_record
class LivesOverDutyCycle:
    """Rating lives of one nut or bearing row over a duty cycle: from its contact loads, and from equivalent loads.

    Equivalent loads are those of the standards for ball screws and bearings.
    """

    #: Basic rating life L10 over the duty cycle: of a nut from the contact loads, of a bearing by ISO 281; if None,
    #: ``life_words`` states the reason.
    life: rating_life.BasicRatingLife | None
    life_words: str = quantity_field(
        "life_words", "why no life over the duty cycle can be computed", show=lambda words: words or None
    )
    #: Basic rating life of a nut over the duty cycle from the equivalent loads of ISO 3408-5; if None, ``standard_words``
    #: states the reason. None for a bearing, whose ``life`` is that from equivalent loads.
    standard: rating_life.EquivalentLoadLife | None = quantity_field("standard_life")
    standard_words: str = quantity_field(
        "standard_life_words", "why there is no life by the standard", show=lambda words: words or None
    )
    #: Name of the nut or row; empty if the scene has only one.
    set: str = ""
    #: Life by the contact loads, modified for reliability and lubricant.
    modified: ModifiedLife | None = quantity_field("modified_life", default=None)
    #: Life of a bearing over the duty cycle by ISO/TS 16281; None for nuts.
    reference: iso_lives.ReferenceLife | None = quantity_field("reference_life", default=None)

    @property
    def life_by_loads(self) -> models_answers.LifeByLoads | None:
        """Life over the cycle from the contact loads: L10 of a nut, L10r of a bearing; None if it is not known."""
        return self.life if self.reference is None else self.reference

    @property
    @QuantityDescription(
        "life_difference_percent",
        "difference of the life over the duty cycle by the contact loads (L10 of a nut, L10r of a bearing) from L10 by the "
        "standard's equivalent loads; a result, not an error",
    )
    def difference_percent(self) -> float | None:
        """Difference of the life by the contact loads from the life by the standard [%]."""
        by_loads, standard = self.life_by_loads, self.standard if self.reference is None else self.life
        return (
            None
            if by_loads is None or standard is None
            else float(error_percent(by_loads.revolutions, standard.revolutions))
        )


@result_record
class DutyCycleResults:
    """Extreme values over the load cases of a duty cycle, and lives of each nut or bearing row over the whole cycle."""

    #: Largest contact pressure [Pa] of the load cases with equilibrium; None if no contact is loaded.
    pressure: ExtremeOverLoadCases | None = quantity_field(
        "largest_pressure_MPa",
        "largest pressure of all load cases",
        QuantityDescription(
            "largest_pressure_case", "load case with the largest pressure", show=lambda found: found and found.case
        ),
        error="`model_form.pressure_percent` of its case",
        show=lambda found: found and found.value,
        heading="peak pressure of all load cases",
        note="case {largest_pressure_case}",
    )
    #: Smallest static safety of the load cases with equilibrium; None if no contact is loaded.
    safety: ExtremeOverLoadCases | None = quantity_field(
        "least_static_safety",
        "least static safety of all load cases",
        QuantityDescription(
            "least_static_safety_case", "load case with the least static safety", show=lambda found: found and found.case
        ),
        error="that of the load",
        show=lambda found: found and found.value,
        heading="least static safety",
        form="g3",
        note="case {least_static_safety_case}",
    )
    #: Largest expected error of a contact load in the load cases with equilibrium [% of the mean load]; None: not known.
    error: ExtremeOverLoadCases | None = quantity_field(
        "largest_expected_error_percent",
        "largest expected error of a contact load in any load case, in per cent of the mean load",
        QuantityDescription(
            "largest_expected_error_case",
            "load case with the largest expected error",
            show=lambda found: found and found.case,
        ),
        show=lambda found: found and found.value,
        heading="largest contact-load error to expect",
        form="g2",
        note="of the mean load, case {largest_expected_error_case}",
    )
    #: Names of the load cases with equilibrium whose expected error is not known.
    uncovered: tuple[str, ...] = quantity_field("expected_error_not_covered")
    #: For each load case without equilibrium, by its name, the reason why there is none.
    unsolved: dict[str, str] = quantity_field("unsolved")
    #: Lives of every nut or bearing row.
    lives: tuple[LivesOverDutyCycle, ...]
    #: Mean speed over the cycle [rad/s]; None: not known.
    speed: float | None
    #: Combined life of all nuts and rows that turn with the shaft; None for a single nut or row, or if no life is known.
    axis_life: rating_life.SystemLife | None = quantity_field("axis_life", default=None)

    @property
    @QuantityDescription(
        "life_set", "nut or bearing row with the shortest life over the duty cycle, which the summary gives"
    )
    def shortest(self) -> str:
        """Name of the nut or row with the shortest life over the duty cycle."""
        return self.shortest_lives.set

    @property
    def shortest_lives(self) -> LivesOverDutyCycle:
        """Lives of the nut or row with the shortest life over the cycle by its contact loads.

        A life that is not known counts as zero, that of a bearing whose rings stand still as infinite.
        """
        return min(self.lives, key=_life_for_ranking)


def compute_duty_cycle_results(cycle: DutyCycle, solutions: Sequence[SceneSolution | ShaftSolution]) -> DutyCycleResults:
    """Compute extreme values over the load cases of a duty cycle, and lives over the whole cycle.

    Parameters
    ----------
    cycle
        The duty cycle.
    solutions
        Solution of each load case, in the order of the cycle.

    Returns
    -------
    DutyCycleResults
        Largest pressure, least static safety, largest expected error, and lives.
    """
    pairs = list(zip(cycle.cases, solutions, strict=True))
    answers = [(case, x) for case, one in pairs for x in one.contact_results]
    expected = [(case, one.expected_errors) for case, one in pairs if one.derived_results]
    errors = [(case, None if e is None else e.percent) for case, e in expected]
    lives = tuple(_lives_of_set(cycle, name, [one.loads_by_set.get(name) for one in solutions]) for name in cycle.sets)
    axis_life = None
    if isinstance(cycle.parts, Assembly):
        axis_life = _life_of_turning_sets(cycle.parts, ((x.set, x) for x in lives), cycle.speed)
    return DutyCycleResults(
        _extreme_over_cases(max, ((case, a.worst_contact.pressure) for case, a in answers if a.worst_contact)),
        _extreme_over_cases(min, ((case, a.safety.factor) for case, a in answers if a.safety)),
        _extreme_over_cases(max, errors),
        tuple(case.name for case, percent in errors if percent is None),
        {case.name: one.result.status for case, one in pairs if one.derived_results is None},
        lives,
        cycle.speed,
        axis_life,
    )


def _life_for_ranking(lives: LivesOverDutyCycle) -> float:
    """Return the life of a nut or row by its contact loads; infinite if its rings stand still, zero if it is not known."""
    by_loads = lives.life_by_loads
    return by_loads.revolutions if by_loads else float("inf") if lives.life_words == rating_life.RINGS_STAND else 0.0


def rating_life_over_duty_cycle(
    cycle: DutyCycle, set_name: str, loads: Sequence[Array | None]
) -> tuple[models_answers.LifeByLoads | None, str]:
    """Compute the rating life of a nut (L10) or bearing row (L10r) over a duty cycle from its loads in every load case.

    Parameters
    ----------
    cycle
        The duty cycle.
    set_name
        Name of the nut or row, as in `DutyCycle.sets`.
    loads
        Contact loads of n balls on 4 flanks (n, 4) [N], or line loads of rollers (rollers, slices) [N/m], in every load
        case; None: not known.

    Returns
    -------
    BasicRatingLife or ReferenceLife or None
        The life.
    str
        Why there is no life; empty if there is one.
    """
    lacking = [case.name for case, load in zip(cycle.cases, loads, strict=True) if load is None and case.share > 0.0]
    if lacking:
        return None, f"the contact loads of case {lacking[0]} are not known"
    turning = _turning_ring_of_set(cycle, set_name)
    if turning == "none":
        return None, rating_life.RINGS_STAND
    known = [np.zeros((1, 4)) if load is None else load for load in loads]
    parts, shares = cycle.sets[set_name], cycle.revolution_shares
    rated: models_answers.LifeByLoads | None
    if isinstance(parts, RollerRow):
        equivalent = roller_life.damage_equivalent_line_loads(known, shares)
        rated = iso_lives.roller_reference_life(parts, equivalent, turning)
    else:
        try:
            basic = rating_life.basic_rating_life(
                parts, rating_life.damage_equivalent_contact_loads(known, shares), turning
            )
        except ValueError as error:
            return None, str(error)
        rated = basic if parts.track.lead else iso_lives.ball_reference_life(parts, basic, turning)
    return rated, "" if rated is not None else "no load"


def _turning_ring_of_set(cycle: DutyCycle, set_name: str) -> rating_life.TurningRing:
    """Return which ring of a bearing row turns, see `lowfi.rating.life.turning_ring`; ``set_name``: its name."""
    parts = cycle.parts
    row = None if isinstance(parts, Scene) else next(s for s in parts.sets if s.name == set_name)
    return rating_life.turning_ring(parts, row)


def contact_loads_by_nut_or_bearing(result: StaticResult | AxisResult) -> dict[str, Array]:
    """Return the contact loads of each nut or bearing row of a solved scene.

    Parameters
    ----------
    result
        Result of a scene with one nut or row, or with several on one shaft.

    Returns
    -------
    dict
        Contact loads of n balls on 4 flanks (n, 4) [N], or line loads of rollers (rollers, slices) [N/m], by name of the
        nut or row as in `DutyCycle.sets`.
    """
    if isinstance(result, StaticResult):
        return {"": result.load}
    found = ((s.of.name, s.line_loads if s.balls is None else s.balls.load) for s in result.sets)
    return {name: load for name, load in found if load is not None}


def _lives_of_set(cycle: DutyCycle, set_name: str, loads: Sequence[LoadsOfNutOrBearing | None]) -> LivesOverDutyCycle:
    """Return the rating lives of one nut or bearing row over a duty cycle.

    ``set_name``: name of the nut or row as in `DutyCycle.sets`; ``loads``: its contact loads and force in every
    load case; None for a load case without equilibrium.
    """
    rated, words = rating_life_over_duty_cycle(cycle, set_name, [None if s is None else s.load for s in loads])
    if rated is None:
        return LivesOverDutyCycle(None, words, None, words, set_name)
    used = [(s, case.share) for s, case in zip(loads, cycle.cases, strict=True) if s is not None and case.share > 0.0]
    shares, forces, row = [share for _, share in used], [s.force for s, _ in used], cycle.sets[set_name]
    if isinstance(row, RollerRow):
        basic = roller_life.life_of_row_by_equivalent_loads(row, shares, forces)
        return LivesOverDutyCycle(basic, "", None, "", set_name, None, rated)  # type: ignore[arg-type]
    scenes = [s.parts for s, _ in used if isinstance(s.parts, Scene)]
    if isinstance(rated, iso_lives.ReferenceLife):
        modified = modified_life(row, rated)
        try:
            basic = rating_life.bearing_life_of_equivalent_loads(scenes, shares, forces)
        except ValueError as error:
            return LivesOverDutyCycle(None, str(error), None, "", set_name, modified, rated)
        return LivesOverDutyCycle(basic, "" if basic is not None else "no load", None, "", set_name, modified, rated)
    modified = modified_life(row, rated)
    try:
        standard = rating_life.life_by_equivalent_loads(scenes, shares, forces, max(s.preload for s, _ in used))
    except ValueError as error:
        return LivesOverDutyCycle(rated, words, None, str(error), set_name, modified)
    return LivesOverDutyCycle(rated, words, standard, "" if standard is not None else "no load", set_name, modified)


def _extreme_over_cases(
    max_or_min: Callable[..., tuple[float, str]], values_by_case: Iterable[tuple[LoadCase, float | None]]
) -> ExtremeOverLoadCases | None:
    """Return the largest or smallest value over load cases, with the name of its load case; None if no value is known.

    ``max_or_min``: the function max or min; ``values_by_case``: pairs of a load case and its value, None for a value that
    is not known.
    """
    known = [(value, case.name) for case, value in values_by_case if value is not None]
    return ExtremeOverLoadCases(*max_or_min(known, key=lambda one: one[0])) if known else None
