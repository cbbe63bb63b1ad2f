"""Load cases beside the 3D reference, together: the case with the largest error, and the life of a duty cycle by both."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from rollbench.comparison.commands.comparing.compare_output import Comparison
from rollbench.comparison.measure import error_percent
from rollbench.comparison.models.together import cycle_life
from rollbench.comparison.quantities import number
from rollbench.comparison.scenes.duty_cycle import CaseOf, DutyCycle


def cycles_of(cases: Mapping[str, CaseOf]) -> Iterable[DutyCycle]:
    """The cycles of some cases, each once."""
    return {case.cycle.name: case.cycle for case in cases.values()}.values()


#: What is compared of each case and set, by the names of their scene and set.
Compared = Mapping[tuple[str, str], Comparison]


def together_json(cycle: DutyCycle, each: Compared) -> list[dict[str, Any]]:
    """Of each set: largest error of the model that the verdicts speak of, its case, and the lives over the cycle [10^6
    revolutions] of every model and of the reference; null where a case has none."""
    return [_of_set(cycle, name, each) for name in cycle.sets]


def _of_set(cycle: DutyCycle, name: str, each: Compared) -> dict[str, Any]:
    by_case = [(case, each[case.scene.name, name]) for case in cycle.cases]
    errors = [(whole.spoken.error.max_percent, case.name) for case, whole in by_case if whole.spoken.error is not None]
    error, worst = max(errors, default=(None, None))
    lives = {}
    for label in ("3D reference", *(b.label for b in by_case[0][1].models)):
        of_case = [{b.label: b for b in (whole.itself, *whole.models)}.get(label) for _, whole in by_case]
        rated, _ = cycle_life(cycle, name, [None if b is None else b.answer.load for b in of_case])
        lives[label] = None if rated is None else number(rated.revolutions)
    predicted, reference = lives[by_case[0][1].spoken.label], lives["3D reference"]
    off = None if predicted is None or reference is None else float(error_percent(predicted, reference))
    return {
        "scene": cycle.name,
        **({"set": name} if name else {}),
        "model": by_case[0][1].spoken.label,
        "largest_error_percent": error,
        "largest_error_case": worst,
        "life_million_revolutions": lives,
        "life_error_percent": off,
    }


def together_lines(cycle: DutyCycle, each: Compared) -> list[str]:
    """The same for the terminal."""
    return [line for data in together_json(cycle, each) for line in ("", _line(data))]


def _line(data: dict[str, Any]) -> str:
    lives, off = data["life_million_revolutions"], data["life_error_percent"]
    life = "no life over the duty cycle"
    if off is not None:
        life = (
            f"life over the duty cycle {lives[data['model']]:.4g} million revolutions, {lives['3D reference']:.4g} by the "
            f"reference's loads ({off:+.2f} %)"
        )
    error = data["largest_error_percent"]
    worst = "" if error is None else f"{data['model']} is off most in case {data['largest_error_case']}, {error:.2f} %; "
    return f"{data['scene']}{', ' + data['set'] if 'set' in data else ''}: {worst}{life}"
