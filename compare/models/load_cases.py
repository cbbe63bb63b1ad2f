"""Solution of a scene with all answers, and lives and extremes over the load cases of a duty cycle."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from rollbench.compare.measure import error_percent
from rollbench.compare.models.answers import (
    Answers,
    AxisAnswers,
    LoadAnswers,
    RollerAnswers,
    gather,
    outside,
    play_warnings,
    solve_sets,
)
from rollbench.compare.models.drive import AxisDrive, axis_drive, axis_life, lead_of, nut_sums
from rollbench.compare.models.loading import axial_of, path_warnings
from rollbench.compare.models.model_form import ModelForm, estimate
from rollbench.compare.models.registry import Options, run_model
from rollbench.compare.scenes.duty_cycle import DutyCycle, LoadCase
from rollbench.lowfi.rating import reference, roller_life
from rollbench.lowfi.rating.life import (
    SLOPE,
    EquivalentLife,
    Life,
    SystemLife,
    equivalent_contact_loads,
    equivalent_life,
    life,
    system_life,
)
from rollbench.lowfi.rating.modified import ModifiedLife, modified_life
from rollbench.lowfi.rating.overall_friction import overall_warnings
from rollbench.lowfi.statics.result import AxisResult, StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, RollerRow
from rollbench.meshes.parts import Load, Scene
from rollbench.meshes.quantity import Stated, quantity, record


@dataclass(frozen=True)
class OfSet:
    """Data of one solved set that the life over a duty cycle needs."""

    #: Parts of the set; a ball set has the loads and supports of the scene.
    parts: Scene | RollerRow
    #: Contact loads (n, 4) [N]; line loads of rollers (count, slices) [N/m].
    load: Array
    #: Force of the shaft on the set, (3,) [N].
    force: Array
    #: Axial force between both halves of a nut with a lead offset [N].
    preload: float = 0.0


@dataclass(frozen=True)
class Solved:
    """Solution of a scene with one set by one model."""

    #: The scene.
    scene: Scene
    #: Result of the model, with all warnings.
    result: StaticResult
    #: Answers; None without equilibrium.
    answers: Answers | None = None
    #: Error of the model to expect; None without equilibrium.
    expected: ModelForm | None = None

    @property
    def contacts(self) -> tuple[LoadAnswers, ...]:
        """Answers of the contact loads; empty without equilibrium."""
        return () if self.answers is None else (self.answers.loads,)

    @property
    def sets(self) -> dict[str, OfSet]:
        """Data of the only set, under an empty name; empty without equilibrium."""
        if self.answers is None or self.result.equilibrium is None:
            return {}
        preload = axial_of(self.answers.preload) if self.scene.errors.lead_offset else 0.0
        force = -self.result.equilibrium.contact_force
        return {"": OfSet(self.scene, self.result.load, force, preload)}


@dataclass(frozen=True)
class SolvedAxis:
    """Solution of several sets on one shaft by one model."""

    #: The assembly.
    scene: Assembly
    #: Result of the model, with all warnings.
    result: AxisResult
    #: Answers; None without equilibrium.
    answers: AxisAnswers | None = None
    #: Always None: the error to expect is not known for several sets.
    expected: None = None
    #: Torques and inertias at the motor.
    drive: AxisDrive | None = None
    #: Life of all sets that turn with the shaft, as one system.
    life: SystemLife | None = None

    @property
    def contacts(self) -> tuple[LoadAnswers | RollerAnswers, ...]:
        """Answers of the contact loads of each set, rollers included; empty without equilibrium."""
        return () if self.answers is None else tuple(x.loads for x in self.answers.sets)

    @property
    def sets(self) -> dict[str, OfSet]:
        """Data of each set by name; empty without equilibrium."""
        if self.answers is None:
            return {}
        on_housings = (Load(h.at, h.force, h.moment) for h in self.scene.housings)
        loads, out = (*self.scene.loads, *on_housings), {}
        for s, answers in zip(self.result.sets, self.answers.sets, strict=True):
            if isinstance(answers.parts, Scene) and isinstance(answers.loads, LoadAnswers) and s.balls is not None:
                parts = replace(answers.parts, name=self.scene.name, loads=loads, supports=self.scene.supports)
                out[s.of.name] = OfSet(parts, s.balls.load, -s.force)
            elif s.line_loads is not None:
                out[s.of.name] = OfSet(answers.parts, s.line_loads, -s.force)
        return out


def solve_any(scene: Scene | Assembly, model: str, options: Options) -> Solved | SolvedAxis:
    """Solve a scene with one set or several by a model, and compute all answers.

    Parameters
    ----------
    scene
        One load case.
    model
        Name of the model.
    options
        Options of the model.

    Returns
    -------
    Solved or SolvedAxis
        The solution.

    Raises
    ------
    InputError
        If the model does not cover the scene.
    """
    return solve_axis(scene, model, options) if isinstance(scene, Assembly) else solve_one(scene, model, options)


def solve_axis(scene: Assembly, model: str, options: Options) -> SolvedAxis:
    """Solve several sets on one shaft and compute all answers; InputError if the model does not cover them."""
    result, answers = solve_sets(scene, model, options.member)
    if answers is None:
        return SolvedAxis(scene, result)
    drive = axis_drive(scene, result, answers, nut_sums(scene, result))
    return SolvedAxis(scene, result, answers, None, drive, axis_life(scene, result, answers))


def solve_one(scene: Scene, model: str, options: Options) -> Solved:
    """Solve a scene with one set and compute all answers; InputError if the model does not cover it."""
    result = run_model(scene, model, options)
    if not result.converged:
        return Solved(scene, result)
    answers = gather(scene, result, model, options)
    warned = [*outside(scene, answers.loads, axial_of(answers.preload))]
    if scene.friction is not None:
        warned += overall_warnings(scene.track, scene.friction)
    warned += [*path_warnings(answers.path), *play_warnings(scene)]
    warned += [] if answers.shaft is None else answers.shaft.warnings
    result = replace(result, warnings=(*result.warnings, *warned))
    return Solved(scene, result, answers, estimate(scene, result))


@dataclass(frozen=True)
class Extreme:
    """Largest or smallest value over the load cases of a duty cycle."""

    #: The value, in SI units; errors in per cent.
    value: float
    #: Name of the load case.
    case: str


@record
class Lives:
    """Life of one set over a duty cycle."""

    #: Life by the contact loads; None with the reason in ``life_words``.
    life: Life | None
    life_words: str = quantity("life_words", "why there is no life over the duty cycle", show=lambda words: words or None)
    #: Life by the equivalent loads of the standards; None with the reason in ``standard_words``.
    standard: EquivalentLife | None = quantity("standard_life")
    standard_words: str = quantity(
        "standard_life_words", "why the standard does not apply", show=lambda words: words or None
    )
    #: Name of the set; empty if it is the only one.
    set: str = ""
    #: Life by the contact loads, modified for reliability and lubricant.
    modified: ModifiedLife | None = quantity("modified_life", default=None)
    reference: reference.ReferenceLife | None = quantity("reference_life", default=None)

    @property
    @Stated(
        "life_difference_percent",
        "life over the duty cycle by the contact loads against that by the standard; a result, not an error",
    )
    def difference_percent(self) -> float | None:
        """Difference of the life by the contact loads from the life by the standard [%]."""
        if self.life is None or self.standard is None:
            return None
        return float(error_percent(self.life.revolutions, self.standard.revolutions))


@record
class Together:
    """Extremes and lives over the load cases of a duty cycle."""

    #: Largest pressure [Pa] of the load cases with equilibrium.
    pressure: Extreme | None = quantity(
        "largest_pressure_MPa",
        "largest pressure of all cases",
        Stated("largest_pressure_case", "its case", show=lambda found: found and found.case),
        error="`model_form.pressure_percent` of its case",
        show=lambda found: found and found.value,
        heading="peak pressure of all cases",
        note="case {largest_pressure_case}",
    )
    #: Smallest static safety over these load cases.
    safety: Extreme | None = quantity(
        "least_static_safety",
        "least static safety of all cases",
        Stated("least_static_safety_case", "its case", show=lambda found: found and found.case),
        error="that of the load",
        show=lambda found: found and found.value,
        heading="least static safety",
        form="g3",
        note="case {least_static_safety_case}",
    )
    #: Largest expected error of a contact load over these load cases [% of the mean load].
    error: Extreme | None = quantity(
        "largest_expected_error_percent",
        "largest error to expect of a contact load in any case, in per cent of the mean load",
        Stated("largest_expected_error_case", "its case", show=lambda found: found and found.case),
        show=lambda found: found and found.value,
        heading="largest error to expect",
        form="g2",
        note="of the mean load, case {largest_expected_error_case}",
    )
    #: Load cases whose error to expect is not known.
    uncovered: tuple[str, ...] = quantity("expected_error_not_covered")
    #: Status of the load cases without equilibrium, by name.
    unsolved: dict[str, str] = quantity("unsolved")
    #: Life of every set.
    lives: tuple[Lives, ...]
    #: Mean speed [rad/s].
    speed: float | None
    #: Life of several sets as one system.
    axis_life: SystemLife | None = quantity("axis_life", default=None)

    @property
    @Stated("life_set", "of several sets that of the shortest life over the duty cycle, which the summary gives")
    def shortest(self) -> str:
        """Name of the set with the shortest life over the duty cycle."""
        return self.least.set

    @property
    def least(self) -> Lives:
        """Lives of the set with the shortest life; if a life is not known, those of the first set without one."""
        return min(self.lives, key=lambda lives: 0.0 if lives.life is None else lives.life.revolutions)


def together(cycle: DutyCycle, solved: Sequence[Solved | SolvedAxis]) -> Together:
    """Compute extremes and lives over the load cases of a duty cycle.

    Parameters
    ----------
    cycle
        The duty cycle.
    solved
        Solutions of its load cases, in order.

    Returns
    -------
    Together
        The record.
    """
    pairs = list(zip(cycle.cases, solved, strict=True))
    answers = [(case, x) for case, one in pairs for x in one.contacts]
    errors = [(case, None if one.expected is None else one.expected.percent) for case, one in pairs if one.answers]
    return Together(
        _extreme(max, ((case, a.worst.pressure) for case, a in answers if a.worst)),
        _extreme(min, ((case, a.safety.factor) for case, a in answers if a.safety)),
        _extreme(max, errors),
        tuple(case.name for case, percent in errors if percent is None),
        {case.name: one.result.status for case, one in pairs if one.answers is None},
        lives := tuple(_lives(cycle, name, [one.sets.get(name) for one in solved]) for name in cycle.sets),
        cycle.speed,
        _axis_life(cycle, lives),
    )


def _axis_life(cycle: DutyCycle, lives: Sequence[Lives]) -> SystemLife | None:
    """Return the life of all sets that turn with the shaft as one system; None for one set or without any life."""
    if not isinstance(cycle.parts, Assembly):
        return None
    turning = {s.name: s.parts for s in cycle.parts.sets if s.carrier is None}
    known = {x.set: x.life.revolutions for x in lives if x.life is not None and x.set in turning}
    if not known:
        return None
    slopes = {name: roller_life.SLOPE if isinstance(turning[name], RollerRow) else SLOPE for name in known}
    together = 1e-6 * system_life([(1e6 * life, slopes[name]) for name, life in known.items()])
    return SystemLife(together, min(known, key=lambda name: known[name]), lead_of(cycle.parts), cycle.speed)


def cycle_life(cycle: DutyCycle, name: str, loads: Sequence[Array | None]) -> tuple[Life | None, str]:
    """Compute the life of a set over a duty cycle from its loads in every load case.

    Parameters
    ----------
    cycle
        The duty cycle.
    name
        Name of the set, as in `DutyCycle.sets`.
    loads
        Contact loads (n, 4) [N], or line loads of rollers, in every load case; None: not known.

    Returns
    -------
    Life or None
        The life.
    str
        Why there is no life; else empty.
    """
    lacking = [case.name for case, load in zip(cycle.cases, loads, strict=True) if load is None and case.share > 0.0]
    if lacking:
        return None, f"none, because case {lacking[0]} has no loads"
    try:
        known = [np.zeros((1, 4)) if load is None else load for load in loads]
        parts = cycle.sets[name]
        if isinstance(parts, RollerRow):
            rated = roller_life.life(parts, roller_life.equivalent_line_loads(known, cycle.shares))
        else:
            rated = life(parts, equivalent_contact_loads(known, cycle.shares))
    except ValueError as error:
        return None, str(error)
    return rated, "" if rated is not None else "no load"


def loads_of(result: StaticResult | AxisResult) -> dict[str, Array]:
    """Return contact loads (n, 4) [N] or line loads of rollers of each set.

    Parameters
    ----------
    result
        Result of one set or several.

    Returns
    -------
    dict
        Loads by name, as in `DutyCycle.sets`.
    """
    if isinstance(result, StaticResult):
        return {"": result.load}
    found = ((s.of.name, s.line_loads if s.balls is None else s.balls.load) for s in result.sets)
    return {name: load for name, load in found if load is not None}


def _lives(cycle: DutyCycle, name: str, each: Sequence[OfSet | None]) -> Lives:
    """Return the lives of a set from its data in every load case (None: no equilibrium)."""
    rated, words = cycle_life(cycle, name, [None if s is None else s.load for s in each])
    if rated is None:
        return Lives(rated, words, None, words, name)
    used = [(s, case.share) for s, case in zip(each, cycle.cases, strict=True) if s is not None and case.share > 0.0]
    parts, shares, forces = [s.parts for s, _ in used], [share for _, share in used], [s.force for s, _ in used]
    row = cycle.sets[name]
    if isinstance(row, RollerRow):
        basic = reference.roller_reference_life(row, roller_life.equivalent_line_loads([s.load for s, _ in used], shares))
        return Lives(rated, words, roller_life.equivalent_life(row, shares, forces), "", name, None, basic)
    modified, basic = modified_life(row, rated), reference.ball_reference_life(row, rated)
    try:
        scenes = [x for x in parts if isinstance(x, Scene)]
        standard = equivalent_life(scenes, shares, forces, max(s.preload for s, _ in used))
    except ValueError as error:
        return Lives(rated, words, None, str(error), name, modified, basic)
    return Lives(rated, words, standard, "" if standard is not None else "no load", name, modified, basic)


def _extreme(pick: Callable[..., tuple[float, str]], values: Iterable[tuple[LoadCase, float | None]]) -> Extreme | None:
    """Return the largest or smallest known value (by ``pick``), with its load case; None if no value is known."""
    known = [(value, case.name) for case, value in values if value is not None]
    return Extreme(*pick(known, key=lambda one: one[0])) if known else None
