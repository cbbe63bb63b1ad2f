"""The load cases of a duty cycle as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rollbench.compare.models.load_cases import Solved, SolvedAxis
from rollbench.compare.models.together import Lives, Together
from rollbench.compare.quantities import number, quantity, record
from rollbench.compare.results.answers_json import life_json
from rollbench.compare.results.solved_json import case_json
from rollbench.compare.scenes.duty_cycle import DutyCycle, LoadCase
from rollbench.lowfi.statics.tangent import Tangent

#: What the cases of a duty cycle say together.
TOGETHER = (
    quantity("largest_pressure_MPa", lambda t: t.pressure and t.pressure.value),
    quantity("largest_pressure_case", lambda t: t.pressure and t.pressure.case),
    quantity("least_static_safety", lambda t: t.safety and t.safety.value),
    quantity("least_static_safety_case", lambda t: t.safety and t.safety.case),
    quantity("largest_expected_error_percent", lambda t: t.error and t.error.value),
    quantity("largest_expected_error_case", lambda t: t.error and t.error.case),
    quantity("expected_error_not_covered", "uncovered"),
    quantity("unsolved"),
)
STANDARD_LIFE = (
    quantity("L10_million_revolutions", "revolutions"),
    quantity("equivalent_loads_N", "loads"),
    quantity("standard"),
)


def cases_json(
    cycle: DutyCycle, solved: Sequence[Solved | SolvedAxis], whole: Together, tangents: Sequence[Tangent | None] = ()
) -> dict[str, Any]:
    """The load cases in order, and what they say together; tangents: of each, where they were asked for."""
    each = zip(cycle.cases, solved, tangents or [None] * len(solved), strict=True)
    unsolved = "; ".join(f"case {name}: {status}" for name, status in whole.unsolved.items())
    return {
        "scene": cycle.name,
        "model": solved[0].result.model,
        "status": unsolved or "converged",
        "summary": together_json(whole),
        "cases": [{**head(cycle, case), **case_json(one, tangent), "scene": cycle.name} for case, one, tangent in each],
    }


def head(cycle: DutyCycle, case: LoadCase) -> dict[str, Any]:
    """What every row of a case begins with."""
    return {"scene": cycle.name, "case": case.name, "share": number(case.share)}


def together_json(whole: Together) -> dict[str, Any]:
    """Extremes of the cases, and the lives over the cycle with words where there is none."""
    data = (record(TOGETHER, whole) or {}) | _lives_json(whole.least, whole.speed)
    if len(whole.lives) == 1:
        return data
    each = ({"name": lives.set} | _lives_json(lives, whole.speed) for lives in whole.lives)
    return data | {"life_set": whole.least.set, "sets": [*each]}


def _lives_json(lives: Lives, speed: float | None) -> dict[str, Any]:
    off = lives.difference_percent
    return {
        "life": life_json(lives.life, speed),
        "life_words": lives.life_words or None,
        "standard_life": record(STANDARD_LIFE, lives.standard),
        "standard_life_words": lives.standard_words or None,
        "life_difference_percent": None if off is None else number(off),
    }
