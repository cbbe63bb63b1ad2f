"""A scene of one set solved with all its answers, the load cases of a duty cycle one after the other, and what they say
together."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from rollbench.comparison.measure import error_percent
from rollbench.comparison.models.answers import Answers, gather
from rollbench.comparison.models.loading import axial_of
from rollbench.comparison.models.model_form import ModelForm, estimate
from rollbench.comparison.models.outside import outside
from rollbench.comparison.models.registry import Options, run_model
from rollbench.comparison.scenes.load_cases import DutyCycle, LoadCase
from rollbench.lowfi.rating.equivalent import EquivalentLife, equivalent_life
from rollbench.lowfi.rating.life import Life, life, over_cases
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import Scene


@dataclass(frozen=True)
class Solved:
    """A scene by one model: its result with all warnings; answers, and the error to expect of it, where it converged."""

    scene: Scene
    result: StaticResult
    answers: Answers | None = None
    expected: ModelForm | None = None


def solve_one(scene: Scene, model: str, options: Options) -> Solved:
    """Solve a scene and gather all answers. Raises InputError and Refusal as `run_model`."""
    result = run_model(scene, model, options)
    if not result.converged:
        return Solved(scene, result)
    found = gather(scene, result, model, options)
    warned = outside(scene, found.loads, axial_of(found.preload))
    result = replace(result, warnings=(*result.warnings, *warned))
    return Solved(scene, result, found, estimate(scene, result))


@dataclass(frozen=True)
class Extreme:
    """An extreme value over the cases in SI units (errors in per cent), and the case that has it."""

    value: float
    case: str


@dataclass(frozen=True)
class Together:
    """What the cases of a duty cycle say together.

    pressure [Pa], safety, error [% of the mean load]: largest pressure, least static safety and largest expected error of
    the converged cases; uncovered: cases whose error nothing says; unsolved: status of those that did not converge; life:
    of the contact loads over the cycle, standard: by the standards' equivalent loads, each None with words that say why;
    speed: mean one [rad/s].
    """

    pressure: Extreme | None
    safety: Extreme | None
    error: Extreme | None
    uncovered: tuple[str, ...]
    unsolved: dict[str, str]
    life: Life | None
    life_words: str
    standard: EquivalentLife | None
    standard_words: str
    speed: float | None

    @property
    def difference_percent(self) -> float | None:
        """Of the life by the loads from that by the standard [%]."""
        if self.life is None or self.standard is None:
            return None
        return float(error_percent(self.life.revolutions, self.standard.revolutions))


def together(cycle: DutyCycle, solved: Sequence[Solved]) -> Together:
    """Extremes and lives of the solved cases of a cycle, in its order."""
    pairs = list(zip(cycle.cases, solved, strict=True))
    found = [(case, one.answers.loads) for case, one in pairs if one.answers is not None]
    errors = [(case, None if one.expected is None else one.expected.percent) for case, one in pairs if one.answers]
    rated, words = cycle_life(cycle, [one.result.load if one.answers else None for one in solved])
    standard, why = (None, words) if rated is None else _by_standard(cycle, solved)
    return Together(
        _extreme(max, ((case, a.worst.pressure) for case, a in found if a.worst)),
        _extreme(min, ((case, a.safety.factor) for case, a in found if a.safety)),
        _extreme(max, errors),
        tuple(case.name for case, percent in errors if percent is None),
        {case.name: one.result.status for case, one in pairs if one.answers is None},
        rated,
        words,
        standard,
        why,
        cycle.speed,
    )


def cycle_life(cycle: DutyCycle, loads: Sequence[Array | None]) -> tuple[Life | None, str]:
    """Life over the cycle of contact loads ``(n, 4)`` [N] of every case (None: it has none), or why there is none."""
    lacking = [case.name for case, load in zip(cycle.cases, loads, strict=True) if load is None and case.share > 0.0]
    if lacking:
        return None, f"none, because case {lacking[0]} has no loads"
    try:
        known = [np.zeros((1, 4)) if load is None else load for load in loads]
        rated = life(cycle.parts, over_cases(known, cycle.shares))
    except ValueError as error:
        return None, str(error)
    return rated, "" if rated is not None else "no load"


def _by_standard(cycle: DutyCycle, solved: Sequence[Solved]) -> tuple[EquivalentLife | None, str]:
    """Life by the standards' equivalent loads, or why there is none."""
    used = [(case, one) for case, one in zip(cycle.cases, solved, strict=True) if case.share > 0.0]
    forces = [-one.result.equilibrium.contact_force for _, one in used if one.result.equilibrium is not None]
    offset = cycle.parts.errors.lead_offset != 0.0
    preload = max(axial_of(one.answers.preload) for _, one in used if one.answers is not None) if offset else 0.0
    try:
        found = equivalent_life([c.scene for c, _ in used], [c.share for c, _ in used], forces, preload)
    except ValueError as error:
        return None, str(error)
    return found, "" if found is not None else "no load"


def _extreme(pick: Callable[..., tuple[float, str]], values: Iterable[tuple[LoadCase, float | None]]) -> Extreme | None:
    """The extreme of the values that are known."""
    known = [(value, case.name) for case, value in values if value is not None]
    return Extreme(*pick(known, key=lambda one: one[0])) if known else None
