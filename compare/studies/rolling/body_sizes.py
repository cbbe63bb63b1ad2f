"""What the choices behind finite bodies do to two balls of a linear bearing and of a screw; kept with the package.

The key is of all sources that the numbers come from, and of the scene; one choice is recomputed for each report and the
agreement told.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from pathlib import Path

from rollbench.compare.files import replace_file
from rollbench.compare.measure import error_percent
from rollbench.compare.provenance import sources_hash
from rollbench.compare.reference.body_names import FINITE
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.scenes import catalogue
from rollbench.compare.scenes.catalogue import case as shipped_case
from rollbench.compare.scenes.friction_kinds.common import KindScene
from rollbench.compare.studies.rolling.cases import case_of
from rollbench.compare.studies.rolling.runs import BODIES, measures
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
    scene = shipped_case(name, KindScene)
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


# --- what the choices behind finite bodies do, kept with the package: half a minute of every report


#: File of a store that holds them.
FILE = "body_sizes.json"
#: Choice that is recomputed.
LIVE = "3 x 3 cells in the contact zone instead of 4 x 4"


@dataclass(frozen=True)
class KeptSizes:
    """All variants, and how they were come by, as a sentence."""

    variants: tuple[Variant, ...]
    words: str


def key() -> str:
    """Hash of sources and scenes."""
    return sources_hash(("hifi", "meshes", "compare/studies/rolling"), "".join(map(catalogue.scene_text, SCENES)))


def sizes(stores: Sequence[Path], *, fresh: bool) -> KeptSizes:
    """Variants as kept where their key holds; fresh: computed, and kept in the first store."""
    kept = None if fresh else _load(stores)
    if kept is None:
        found = body_sizes()
        if fresh:
            rows = ",\n ".join(json.dumps(asdict(one)) for one in found)
            replace_file(stores[0] / FILE, f'{{"key": "{key()}", "variants": [\n {rows}]}}\n')
        return KeptSizes(found, "Computed for this report.")
    again, then = variant(LIVE), next(one for one in kept if one.choice == LIVE)
    off = max(abs(float(error_percent(again.values[name], value))) for name, value in then.values.items())
    return KeptSizes(kept, f'Kept with the package; "{LIVE}" recomputed differs by up to {off:.1g} %.')


def choices_share(straight: bool) -> float:
    """Largest relative change of a force or loss by one choice behind finite bodies, as kept with the package: on straight
    rails, or on rings and helices, by the scenes of `body_sizes.SCENES`."""
    found = json.loads((shipped_store() / FILE).read_text(encoding="utf-8"))["variants"]
    values = {row["choice"]: row["values"] for row in found}
    choices = [choice for choice, (name, sizes) in variants().items() if (name == LINEAR) == straight and sizes is not None]
    first, others = values[choices[0]], [values[choice] for choice in choices[1:]]
    return float(max(abs(other[name] / first[name] - 1.0) for other in others for name in NAMES[:3]))


def _load(stores: Sequence[Path]) -> tuple[Variant, ...] | None:
    for store in stores:
        try:
            found = json.loads((store / FILE).read_text(encoding="utf-8"))
            rows = tuple(Variant(**row) for row in found["variants"])
        except (OSError, ValueError, KeyError, TypeError):
            continue
        if found["key"] == key() and any(one.choice == LIVE for one in rows):
            return rows
    return None
