"""What the choices behind finite bodies do to two balls of a linear bearing: size of the bars, groove, cells, kernel."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

from compare.rolling.cases import case_of
from compare.rolling.runs import BODIES, FINITE, measures
from compare.scenes.catalogue import case as shipped_case
from compare.scenes.kinds.linear import LinearPairScene
from hifi.rolling.balls import NEARLY_RIGID, Choices, solve_rolling
from hifi.rolling.bodies import Sizes
from hifi.rolling.rigid_limit import FIRST, solve_rigid_rolling

#: Case (a) of the linear pair.
SCENE = "lin-pair-a"
#: Cells of the contacts: differences between bodies are taken on one grid, which need not be fine.
SHAPE = (12, 16)
#: Quantities shown.
NAMES = ("force 1-2 N", "deviation 1 apart %", "loss apart mW", "loss touching mW")


@dataclass(frozen=True)
class Variant:
    """Bodies with one choice changed (None: half spaces): what it is, and values by name."""

    choice: str
    values: dict[str, float]


def variants() -> dict[str, Sizes | None]:
    """Choices by name, the shipped ones first, half spaces last."""
    own = BODIES[FINITE]
    assert own is not None
    return {
        "as shipped": own,
        "bars of 3 ball radii instead of 5": replace(own, bar=3.0),
        "bars of 8 ball radii": replace(own, bar=8.0),
        "grooves open to 69 deg instead of 80": replace(own, opening=1.2),
        "3 x 3 cells in the contact zone instead of 4 x 4": replace(own, cells=(3, 3)),
        "6 x 6 cells in the contact zone": replace(own, cells=(6, 6)),
        "kernel of degree 3 instead of 4": replace(own, degree=3),
        "half spaces": None,
    }


def variant(choice: str) -> Variant:
    """One variant of case (a) of the linear pair."""
    sizes = variants()[choice]
    case = case_of(shipped_case(SCENE, LinearPairScene), Choices(SHAPE))
    both = (case.apart, case.touching)
    elastic, near = (
        measures(case, *(solve_rolling(s, Choices(SHAPE, e, bodies=sizes)) for s in both)) for e in (1.0, NEARLY_RIGID)
    )
    limit = measures(case, *(solve_rigid_rolling(s, FIRST * 2, bodies=sizes) for s in both))
    return Variant(choice, {k: limit[k] + elastic[k] - near[k] for k in NAMES})


@lru_cache(maxsize=1)
def body_sizes() -> tuple[Variant, ...]:
    """All variants."""
    return tuple(variant(choice) for choice in variants())
