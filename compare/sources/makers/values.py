"""All outside values, each computed once a study, and their standing by quantity."""

from __future__ import annotations

from rollbench.comparison.models.study import Study
from rollbench.comparison.sources.makers.laws import bearings, nuts, programs, torque
from rollbench.comparison.sources.makers.outside import Outside, by_quantity
from rollbench.reports.records import Cell, Quantity

#: Order of quantities in tables; others follow.
ORDER = ("contact load", "displacement", "pressure", "torque", "rigidity", "rating", "preload")
LAWS = (
    bearings.sets,
    bearings.ball_bearings,
    bearings.printed_balls,
    nuts.nut_ratings,
    nuts.nut_rigidity,
    nuts.preloaded_nuts,
    torque.printed_torques,
    torque.measured,
)


def outside_values(study: Study) -> tuple[Outside, ...]:
    """Every outside value, by quantity."""
    return study.once(_computed)


def _computed(study: Study) -> tuple[Outside, ...]:
    found = [*programs.printed_elsewhere(study), *programs.calculix(study), *(x for law in LAWS for x in law())]
    rank = {name: k for k, name in enumerate(ORDER)}
    return tuple(sorted(found, key=lambda x: rank.get(x.quantity, len(rank))))


def first_page(study: Study) -> dict[str, dict[Quantity, Cell]]:
    """Number of outside values, bias and scatter, by quantity: columns for the first page's table."""
    return by_quantity(outside_values(study))
