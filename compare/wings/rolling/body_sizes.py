"""What the choices behind finite bodies do to two balls of a linear bearing and of a screw: size of bars, groove, cells,
kernel, bars in place of the static reference's patches."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

from rollbench.comparison.reference.body_names import FINITE
from rollbench.comparison.scenes.catalogue import shipped
from rollbench.comparison.scenes.kinds import KindScene
from rollbench.comparison.wings.rolling.cases import case_of
from rollbench.comparison.wings.rolling.runs import BODIES, measures
from rollbench.hifi.rolling.balls import FIRST, NEARLY_RIGID, Choices, solve_rigid_rolling, solve_rolling
from rollbench.hifi.rolling.bodies import Sizes

#: Scenes: two balls of a linear bearing, on bars, and of a screw, on patches of the static reference.
LINEAR, SCREW = SCENES = ("lin-pair-a", "lin-screw-pair-b-inferred")
#: Cells of the contacts: differences between bodies are taken on one grid, which need not be fine.
SHAPE = (12, 16)
#: Quantities shown.
NAMES = ("force 1-2 N", "loss apart mW", "loss touching mW", "increase %")


@dataclass(frozen=True)
class Variant:
    """Bodies with one choice changed (None: half spaces): what it is, and values by name."""

    choice: str
    values: dict[str, float]


def variants() -> dict[str, tuple[str, Sizes | None]]:
    """Scenes and choices by name, the shipped ones first, half spaces last."""
    sizes = BODIES[FINITE]
    assert sizes is not None
    return {
        "linear bearing: as shipped": (LINEAR, sizes),
        "bars of 3 ball radii instead of 5": (LINEAR, replace(sizes, bar=3.0)),
        "bars of 8 ball radii": (LINEAR, replace(sizes, bar=8.0)),
        "grooves open to 69 deg instead of 80": (LINEAR, replace(sizes, opening=1.2)),
        "3 x 3 cells in the contact zone instead of 4 x 4": (LINEAR, replace(sizes, cells=(3, 3))),
        "6 x 6 cells in the contact zone": (LINEAR, replace(sizes, cells=(6, 6))),
        "kernel of degree 3 instead of 4": (LINEAR, replace(sizes, degree=3)),
        "half spaces": (LINEAR, None),
        "screw: as shipped, the static reference's patches": (SCREW, sizes),
        "screw: a whole ball and bent bars instead": (SCREW, replace(sizes, patches=False)),
        "screw: 6 x 6 cells in the contact zone": (SCREW, replace(sizes, cells=(6, 6))),
        "screw: half spaces": (SCREW, None),
    }


def variant(choice: str) -> Variant:
    """One variant."""
    name, sizes = variants()[choice]
    scene = shipped(name)
    assert isinstance(scene, KindScene)
    case = case_of(scene, Choices(SHAPE))
    systems = (case.apart, case.touching)
    elastic, near = (
        measures(case, *(solve_rolling(s, Choices(SHAPE, e, bodies=sizes)) for s in systems)) for e in (1.0, NEARLY_RIGID)
    )
    limit = measures(case, *(solve_rigid_rolling(s, FIRST * 2, bodies=sizes) for s in systems))
    return Variant(choice, {k: limit[k] + elastic[k] - near[k] for k in NAMES})


@lru_cache(maxsize=1)
def body_sizes() -> tuple[Variant, ...]:
    """All variants."""
    return tuple(variant(choice) for choice in variants())
