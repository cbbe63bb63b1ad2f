"""What the choices behind finite bodies do, kept with the package: half a minute of every report.

The key is of all sources that the numbers come from, and of the scene; one choice is computed anew for each report and the
agreement told.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from rollbench.comparison.measure import error_percent
from rollbench.comparison.provenance import sources_hash
from rollbench.comparison.reference.store import shipped_store
from rollbench.comparison.scenes import catalogue
from rollbench.comparison.wings.rolling.body_sizes import LINEAR, NAMES, SCENES, Variant, body_sizes, variant, variants
from rollbench.comparison.writing import replace_file

#: File of a store that holds them.
FILE = "body_sizes.json"
#: Choice that is computed anew.
LIVE = "3 x 3 cells in the contact zone instead of 4 x 4"


@dataclass(frozen=True)
class Sizes:
    """All variants, and how they were come by, as a sentence."""

    variants: tuple[Variant, ...]
    words: str


def key() -> str:
    """Hash of sources and scenes."""
    return sources_hash(("hifi", "meshes", "compare/wings/rolling"), "".join(map(catalogue.scene_text, SCENES)))


def sizes(stores: Sequence[Path], *, fresh: bool) -> Sizes:
    """Variants as kept where their key holds; fresh: computed, and kept in the first store."""
    kept = None if fresh else _load(stores)
    if kept is None:
        found = body_sizes()
        if fresh:
            rows = ",\n ".join(json.dumps(asdict(one)) for one in found)
            replace_file(stores[0] / FILE, f'{{"key": "{key()}", "variants": [\n {rows}]}}\n')
        return Sizes(found, "Computed for this report.")
    anew, then = variant(LIVE), next(one for one in kept if one.choice == LIVE)
    off = max(abs(float(error_percent(anew.values[name], value))) for name, value in then.values.items())
    return Sizes(kept, f'Kept with the package; "{LIVE}" computed anew differs by up to {off:.1g} %.')


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
