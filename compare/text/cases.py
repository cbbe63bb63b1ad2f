"""The load cases of a duty cycle for the terminal."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from rollbench.compare.models.load_cases import Lives, Solved, SolvedAxis, Together
from rollbench.compare.quantities import count_of
from rollbench.compare.results.scene_json import cases_json, life_json
from rollbench.compare.scenes.duty_cycle import DutyCycle
from rollbench.compare.text.entries import entry, life_words
from rollbench.compare.text.printing import text_width
from rollbench.compare.text.solved import case_table, stiffness_lines
from rollbench.compare.text.tables import aligned
from rollbench.lowfi.statics.tangent import Tangent

#: Columns of the table of cases: heading, group of a case's summary, and key.
COLUMNS = (
    ("largest load N", "loads", "max_N"),
    ("axial N", "axial", "force_N"),
    ("pressure MPa", "worst_contact", "pressure_MPa"),
    ("static safety", "static_safety", "factor"),
    ("life 1e6 rev", "life", "L10_million_revolutions"),
)


def cases_table(
    cycle: DutyCycle,
    solved: Sequence[Solved | SolvedAxis],
    whole: Together,
    tangents: Sequence[Tangent | None] = (),
    *,
    balls: bool = False,
    details: bool = False,
) -> list[Any]:
    """What the cases say together, a row on each, then each by itself; what is assumed is said once."""
    data = cases_json(cycle, solved, whole)
    parts: list[Any] = [f"{cycle.name}, model {data['model']}: {count_of(len(solved), 'load case')}, {data['status']}", ""]
    parts += [*(entry(label, text, text_width()) for label, text in together_entries(whole)), ""]
    parts += [aligned([*case_rows(data["cases"])], ".4g"), ""]
    shown: set[str] = set()
    for case, one, tangent in zip(cycle.cases, solved, tangents or [None] * len(solved), strict=True):
        lines = [x for x in case_table(one, balls=balls, details=details) if not (isinstance(x, str) and x in shown)]
        shown |= {x for x in lines if isinstance(x, str) and x.startswith(("assumed: ", "left out: "))}
        parts += [f"case {case.name}, share {case.share:.4g}", *lines, *(stiffness_lines(tangent) if tangent else []), ""]
    return parts


def case_rows(cases: Sequence[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """A row on every case by `cases_json`."""
    for one in cases:
        row: dict[str, Any] = {"case": one["case"], "share": one["share"]}
        groups = ((heading, key, one["summary"].get(group)) for heading, group, key in COLUMNS)
        row |= {heading: None if group is None else group[key] for heading, key, group in groups}
        worth = one["model_form"]
        yield row | {"expected error %": None if worth is None else worth["largest_percent_of_mean"]}


def together_entries(whole: Together) -> tuple[tuple[str, str], ...]:
    """Labels and sentences of what the cases say together."""
    p, s, e = whole.pressure, whole.safety, whole.error
    lost = f"; not covered by comparisons: {', '.join(whole.uncovered)}" if whole.uncovered else ""
    lives = (x for of_set in whole.lives for x in (("life", _life(of_set, whole.speed)), ("standard", _standard(of_set))))
    return (
        ("pressure", "none" if p is None else f"largest in case {p.case}: {1e-6 * p.value:.0f} MPa"),
        ("static", "none" if s is None else f"least safety in case {s.case}: {s.value:.3g}"),
        (
            "error",
            ("none" if e is None else f"largest to expect in case {e.case}: {e.value:.1f} % of the mean load") + lost,
        ),
        *lives,
    )


def _life(lives: Lives, speed: float | None) -> str:
    """Life by the contact loads."""
    rated, of = lives.life, f"{lives.set}: " if lives.set else ""
    if rated is None:
        return of + lives.life_words
    return (
        f"{of}L10 {life_words(life_json(rated, speed) or {})} of the duty cycle, by the contact loads, the nut at "
        f"one position; rating {rated.rating:.0f} N as computed by {rated.standard}"
    )


def _standard(lives: Lives) -> str:
    """Life by the equivalent loads, and what the contact loads make of it."""
    rated, off, of = lives.standard, lives.difference_percent, f"{lives.set}: " if lives.set else ""
    if rated is None:
        return f"{of}no life by equivalent loads: {lives.standard_words}"
    loads = " and ".join(f"{load:.0f} N" for load in rated.loads if load > 0.0)
    than = "" if off is None else f"; by the contact loads {abs(off):.2g} % {'more' if off > 0.0 else 'less'}"
    return f"{of}L10 {rated.revolutions:.4g} million revolutions by {rated.standard}'s equivalent loads, {loads}{than}"
