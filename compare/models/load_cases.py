"""Motor torques of a feed axis, and extremes and lives over the load cases of a duty cycle."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from rollbench.compare.measure import error_percent
from rollbench.compare.models.answers import parts_under_loads
from rollbench.compare.models.friction_torques import FrictionTorques
from rollbench.compare.models.model_form import ExpectedError
from rollbench.compare.models.set_results import LifeByLoads, SetResult
from rollbench.compare.scenes.duty_cycle import DutyCycle, LoadCase
from rollbench.lowfi.bearings.axis import acceleration_torque, reflected_inertia, screw_inertia
from rollbench.lowfi.bearings.torque import Band
from rollbench.lowfi.rating import iso_lives, roller_life
from rollbench.lowfi.rating import life as rating_life
from rollbench.lowfi.rating.iso_lives import ModifiedLife, modified_life
from rollbench.lowfi.statics.result import AxisResult, StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, RollerRow
from rollbench.meshes.parts import Scene
from rollbench.meshes.quantity import QuantityDescription, quantity_field, quantity_or_none, result_record, text_or_none

#: Smallest and largest efficiency of a nut that accelerates a mass, if the scene states none (Smith 4.3.1) [1].
EFFICIENCY: Band = (0.90, 0.95)
#: Reason why the running torque of a bearing is not known.
NOT_RUNNING = "the running torque of a bearing needs the tables [lubricant] and [motion]"


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
    words: str = text_or_none("words", "why the torque is not known")


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
        note="{drives}",
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

    @property
    @QuantityDescription("drives", "what turns the shaft at constant speed, if it is the load; null if it is the motor")
    def driving_load(self) -> str | None:
        """Words if the load turns the shaft at constant speed, and the motor brakes; None if the motor drives."""
        return "the load drives, the motor brakes" if self.running is not None and max(self.running) < 0.0 else None


def with_friction_of_nuts(scene: Scene | Assembly, sets: Mapping[str, SetResult], member: int) -> dict[str, SetResult]:
    """Return the results of nuts and bearings with the friction torques of a scene's only row, or of all nuts on a shaft.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row, or with several on one shaft.
    sets
        Results of each nut or bearing, by name.
    member
        Number of the random draw of the geometric errors, from 0.

    Returns
    -------
    dict
        The results with friction torques, or with words why there are none.
    """
    nuts = {
        name: (replace(s.parts, friction=scene.friction, motion=scene.motion), s.balls)
        for name, s in sets.items()
        if isinstance(s.parts, Scene) and (s.parts.track.lead or isinstance(scene, Scene)) and s.balls is not None
    }
    why = "of friction given; rollbench friction takes 0.1" if isinstance(scene, Scene) else "in [friction]"
    found: list[tuple[FrictionTorques | None, str]] = [(None, f"no coefficient {why}")] * len(nuts)
    if scene.friction is not None:
        from rollbench.compare.models.friction_sums import friction_results_of_scenes  # heavy import

        solved = [(parts, scene.friction, balls) for parts, balls in nuts.values()]
        found = friction_results_of_scenes(solved, member)
    each = zip(nuts, found, strict=True)
    return {**sets, **{name: replace(sets[name], friction=x, friction_words=words) for name, (x, words) in each}}


def motor_torques_and_inertias(assembly: Assembly, sets: Mapping[str, SetResult]) -> AxisDrive | None:
    """Compute torques and moments of inertia at the motor of a feed axis with a turning shaft.

    Bearings whose inner ring sits on a moving housing do not turn with the shaft and are omitted.

    Parameters
    ----------
    assembly
        Shaft with several nuts or bearing rows.
    sets
        Results of each nut or bearing row, by name, with the friction of the nuts and the torques of the bearings.

    Returns
    -------
    AxisDrive or None
        Torques and inertias; None if the nuts turn instead of the shaft.
    """
    drive, motion = assembly.drive, assembly.motion
    if motion is not None and motion.turns != "screw":
        return None
    sign = -1.0 if motion is not None and motion.speed < 0.0 else 1.0
    turning = [row for row in assembly.sets if row.carrier is None]
    torques = tuple(replace(_torque_on_shaft(sets[row.name], sign), seals=row.seals) for row in turning)
    seals, lead = sum(row.seals for row in turning), lead_of_first_nut(assembly)

    def total(torques: list[Band | None]) -> Band | None:
        """Return the sum of the friction torques of all nuts and bearings, seals and other parts (Smith 4.10) [N m].

        ``torques``: torque of each nut or bearing, (low, high) [N m]; the sum is None if one of them is None (not known).
        """
        known = [x for x in torques if x is not None]
        if len(known) < len(torques):
            return None
        ends = [tuple(x[k] for x in known) for k in (0, 1)]
        low, high = (drive.torque + seals + sum(end) for end in ends)
        return low, high

    running, starting = (total([getattr(s, name) for s in torques]) for name in ("running", "starting"))
    inertias = [screw_inertia(assembly, drive.density), drive.motor_inertia]
    accelerating = None
    if running is not None and motion is not None and drive.time is not None:
        worst, best = EFFICIENCY if drive.efficiency is None else (drive.efficiency, drive.efficiency)
        each = [[*inertias, reflected_inertia(drive.mass, lead, e)] for e in (best, worst)]
        low, high = (acceleration_torque(of, abs(motion.speed), drive.time) for of in each)
        accelerating = running[0] + low, running[1] + high
    carried = reflected_inertia(drive.mass, lead)
    whole = sum(inertias) + carried
    return AxisDrive(torques, seals, drive.torque, running, starting, accelerating, inertias[0], carried, whole)


def lead_of_first_nut(assembly: Assembly) -> float:
    """Return the lead [m] of the first nut on a shaft with several nuts or bearing rows; 0 without a nut."""
    return next((s.parts.track.lead for s in assembly.sets if isinstance(s.parts, Scene) and s.parts.track.lead), 0.0)


def _torque_on_shaft(one: SetResult, sign: float) -> ShaftTorque:
    """Return the torque with which the turning shaft drives a nut, or the friction torque of a bearing.

    The torque of a bearing is that while it runs and when it starts from rest, zero without load. ``one``: results of the
    nut or bearing; ``sign``: -1 if the screw turns in the negative direction, else 1.
    """
    if one.kind == "ball nut":
        if one.friction is None or one.friction.driving_torque_on_screw is None:
            words = one.friction_words or "the friction of the balls did not converge"
            return ShaftTorque(one.name, None, None, words=words)
        torque = sign * one.friction.driving_torque_on_screw
        return ShaftTorque(one.name, (torque, torque), (torque, torque))
    ends: tuple[Band | None, Band | None] = (0.0, 0.0), (0.0, 0.0)
    if one.bearing_torque is not None:
        ends = one.bearing_torque.running, one.bearing_torque.starting
    elif (row := one.torque) is not None:
        low, high = (row.torque if x is None else x for x in (row.low, row.high))
        ends = None if row.film is None else (low, high), (low - (row.film or 0.0), high - (row.film or 0.0))
    return ShaftTorque(one.name, *ends, words="" if ends[0] is not None else NOT_RUNNING)


def life_of_turning_sets(
    assembly: Assembly, sets: Iterable[tuple[str, SetResult | LivesOverDutyCycle]], speed: float | None
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
    life: rating_life.Life | None = quantity_field("life")
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
    modified: ModifiedLife | None = quantity_or_none("modified_life")
    #: Life of a bearing over the duty cycle by ISO/TS 16281; None for nuts.
    reference: iso_lives.ReferenceLife | None = quantity_or_none("reference_life")

    @property
    def life_by_loads(self) -> LifeByLoads | None:
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


def _extreme_field(key: str, definition: str, case_key: str, **others: Any) -> Any:
    """Return a field with an extreme over all load cases, which has a key for its value and one for the load case.

    ``key``, ``definition``, ``others``: as for `quantity_field`; ``case_key``: beginning of the key of the load case.
    """
    words = f"load case with the {case_key.replace('_', ' ')}"
    case = QuantityDescription(f"{case_key}_case", words, show=lambda found: found and found.case)
    note = f"case {{{case_key}_case}}"
    return quantity_field(key, definition, case, **{"note": note} | others, show=lambda found: found and found.value)


@result_record(kw_only=True)
class DutyCycleResults:
    """Extreme values over the load cases of a duty cycle, and lives of each nut or bearing row over the whole cycle."""

    #: Largest contact pressure [Pa] of the load cases with equilibrium; None if no contact is loaded.
    pressure: ExtremeOverLoadCases | None = _extreme_field(
        "largest_pressure_MPa",
        "largest pressure of all load cases",
        "largest_pressure",
        error="`model_form.pressure_percent` of its case",
        heading="peak pressure of all load cases",
    )
    #: Smallest static safety of the load cases with equilibrium; None if no contact is loaded.
    safety: ExtremeOverLoadCases | None = _extreme_field(
        "least_static_safety",
        "least static safety of all load cases",
        "least_static_safety",
        error="that of the load",
        heading="least static safety",
        form="g3",
    )
    #: Largest expected error of a contact load in the load cases with equilibrium [% of the mean load]; None: not known.
    error: ExtremeOverLoadCases | None = _extreme_field(
        "largest_expected_error_percent",
        "largest expected error of a contact load in any load case, in per cent of the mean load",
        "largest_expected_error",
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
    axis_life: rating_life.SystemLife | None = quantity_or_none("axis_life")

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


def compute_duty_cycle_results(
    cycle: DutyCycle,
    sets: Sequence[Mapping[str, SetResult]],
    statuses: Sequence[str],
    expected_errors: Sequence[ExpectedError | None],
) -> DutyCycleResults:
    """Compute extreme values over the load cases of a duty cycle, and lives over the whole cycle.

    Parameters
    ----------
    cycle
        The duty cycle.
    sets
        For each load case, in the order of the cycle, the results of each nut or bearing row by name.
    statuses
        For each load case the reason why there is no equilibrium; empty if there is one.
    expected_errors
        For each load case the errors to expect.

    Returns
    -------
    DutyCycleResults
        Largest pressure, least static safety, largest expected error, and lives.
    """
    pairs = [*zip(cycle.cases, sets, strict=True)]
    worst = [(case, s.worst) for case, one in pairs for s in one.values() if s.worst]
    each = zip(cycle.cases, statuses, expected_errors, strict=True)
    errors = [(case, None if e is None else e.loads) for case, lost, e in each if not lost]
    lives = tuple(_lives_of_set(cycle, name, [one.get(name) for one in sets]) for name in cycle.sets)
    axis_life = None
    if isinstance(cycle.parts, Assembly):
        axis_life = life_of_turning_sets(cycle.parts, ((x.set, x) for x in lives), cycle.speed)
    return DutyCycleResults(
        pressure=_extreme_over_cases(max, ((case, w.pressure) for case, w in worst)),
        safety=_extreme_over_cases(min, ((case, w.safety) for case, w in worst)),
        error=_extreme_over_cases(max, errors),
        uncovered=tuple(case.name for case, percent in errors if percent is None),
        unsolved={case.name: lost for case, lost in zip(cycle.cases, statuses, strict=True) if lost},
        lives=lives,
        speed=cycle.speed,
        axis_life=axis_life,
    )


def _life_for_ranking(lives: LivesOverDutyCycle) -> float:
    """Return the life of a nut or row by its contact loads; infinite if its rings stand still, zero if it is not known."""
    by_loads = lives.life_by_loads
    return by_loads.revolutions if by_loads else float("inf") if lives.life_words == rating_life.RINGS_STAND else 0.0


def rating_life_over_duty_cycle(
    cycle: DutyCycle, set_name: str, loads: Sequence[Array | None]
) -> tuple[LifeByLoads | None, str]:
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
    Life or ReferenceLife or None
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
    rated: LifeByLoads | None
    if isinstance(parts, RollerRow):
        equivalent = rating_life.damage_equivalent_loads(known, shares, roller_life.TURNING)
        rated = iso_lives.roller_reference_life(parts, equivalent, turning)
    else:
        try:
            basic = rating_life.basic_rating_life(parts, rating_life.damage_equivalent_loads(known, shares), turning)
        except ValueError as error:
            return None, str(error)
        rated = basic if parts.track.lead else iso_lives.ball_reference_life(parts, basic, turning)
    return rated and replace(rated, speed=cycle.speed), "" if rated is not None else "no load"


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


def _lives_of_set(cycle: DutyCycle, set_name: str, results: Sequence[SetResult | None]) -> LivesOverDutyCycle:
    """Return the rating lives of one nut or bearing row over a duty cycle.

    ``set_name``: name of the nut or row as in `DutyCycle.sets`; ``results``: its results in every load case; None for a
    load case without equilibrium.
    """
    solved = [s if s is not None and s.force is not None else None for s in results]
    rated, words = rating_life_over_duty_cycle(cycle, set_name, [None if s is None else s.life_loads for s in solved])
    if rated is None:
        return LivesOverDutyCycle(None, words, None, words, set_name)
    used = [(s, case) for s, case in zip(solved, cycle.cases, strict=True) if s is not None and case.share > 0.0]
    shares, forces = [case.share for _, case in used], [-s.force for s, _ in used if s.force is not None]
    row, why = cycle.sets[set_name], ""
    modified = None if isinstance(row, RollerRow) else modified_life(row, rated)
    found: Any = None
    try:
        if isinstance(row, RollerRow):
            found = roller_life.life_of_row_by_equivalent_loads(row, shares, forces)
        elif isinstance(rated, iso_lives.ReferenceLife):
            found = rating_life.bearing_life_of_equivalent_loads([_scene_of_case(*one) for one in used], shares, forces)
        else:
            preload, scenes = max(s.preload_of_halves for s, _ in used), [_scene_of_case(*one) for one in used]
            found = rating_life.life_by_equivalent_loads(scenes, shares, forces, preload)
    except ValueError as error:
        why = str(error)
    why = why or ("" if found is not None or isinstance(row, RollerRow) else "no load")
    if isinstance(rated, rating_life.Life):
        return LivesOverDutyCycle(rated, words, found, why, set_name, modified)
    return LivesOverDutyCycle(found and replace(found, speed=cycle.speed), why, None, "", set_name, modified, rated)


def _scene_of_case(one: SetResult, case: LoadCase) -> Scene:
    """Return a nut or ball bearing as a scene with all loads and supports of a load case."""
    assert isinstance(one.parts, Scene)
    return parts_under_loads(case.scene, one.parts) if isinstance(case.scene, Assembly) else one.parts


def _extreme_over_cases(
    max_or_min: Callable[..., tuple[float, str]], values_by_case: Iterable[tuple[LoadCase, float | None]]
) -> ExtremeOverLoadCases | None:
    """Return the largest or smallest value over load cases, with the name of its load case; None if no value is known.

    ``max_or_min``: the function max or min; ``values_by_case``: pairs of a load case and its value, None for a value that
    is not known.
    """
    known = [(value, case.name) for case, value in values_by_case if value is not None]
    return ExtremeOverLoadCases(*max_or_min(known, key=lambda one: one[0])) if known else None
