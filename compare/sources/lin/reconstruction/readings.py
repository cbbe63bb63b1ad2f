"""Readings of what section 2.4.1 leaves open: of the source's low-order model, and of its 3D model."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Any

from rollbench.comparison.reference.levels import SOURCE_LEVEL
from rollbench.comparison.reference.variants import ends_in_plain_shaft, scaled, solid
from rollbench.comparison.sources.lin.reconstruction.friction import MU, off_line
from rollbench.meshes.parts import Scene

#: The cases whose errors are printed, and the mesh level of the 3D runs.
CASES, LEVEL = ("lin-case1", "lin-case2"), 1


@dataclass(frozen=True)
class Reading:
    """One reading of one open choice: key, what is open, what it is read as; ingredients of the low-order model, or what
    it makes of a scene in 3D; level of the 3D mesh; by_text: why the text speaks against it (empty: it does not); sliding:
    coefficient with which grooves slide on balls that do not turn, in 3D."""

    key: str
    choice: str
    label: str
    ingredients: dict[str, Any] = field(default_factory=dict, hash=False)
    change: Any = None
    level: int = LEVEL
    by_text: str = ""
    sliding: float = 0.0


SHAFT, HELD, LAND = "shaft beyond the nut", "what holds the nut", "nut's lands"
HOLE, ENDS, MESH = "hole along the screw", "ends of the nut's groove", "mesh of the contacts"
FRICTION = "friction of the contacts"
SECTION, PARTITION, HERTZ, ARM = "section constant (C.8)", "beam elements in the nut", "Hertz constants", "lever arm"

#: Of the low-order model, against the default: C.8 with its root, a node at every contact, right Hertz constants.
LOW = (
    Reading("squared", SECTION, "C.8 without its root", {"section": "groove squared"}),
    Reading("full", SECTION, "groove ignored", {"section": "full"}),
    Reading("source", PARTITION, "15 mm, as printed", {"partition": "source"}),
    Reading("printed", HERTZ, "as printed (Table B.1)", {"hertz": "as printed"}),
    Reading("actual", HERTZ, "at each contact's own geometry", {"hertz": "actual"}),
    Reading("nominal", ARM, "frozen at the nominal contact point", {"arm": "nominal"}),
    Reading("ball", ARM, "at the ball's station", {"arm": "ball"}),
)

#: Of the 3D model, against the reference: shaft grooved all along, nut held on its whole left face, no friction.
SOLID = (
    Reading(
        "plain", SHAFT, "plain, of the lands' diameter", change=lambda s: solid(shaft_diameter=s.screw.outer_diameter)(s)
    ),
    Reading("runout", SHAFT, "groove ends 12 mm beyond the nut", change=ends_in_plain_shaft),
    Reading("outer-half", HELD, "outer half of the left face", change=solid(nut_held="left face, outer half")),
    Reading("inner-half", HELD, "inner half of the left face", change=solid(nut_held="left face, inner half")),
    Reading("surface", HELD, "outer surface", change=solid(nut_held="outer surface"), by_text="its left end holds the nut"),
    Reading("right", HELD, "right face", change=solid(nut_held="right face"), by_text="its left end holds the nut"),
    Reading("narrow", LAND, "0.6 mm narrower", change=scaled("nut_inner_diameter", lambda d: 2.0 * d.land, 1.0, -0.6e-3)),
    Reading("wide", LAND, "0.6 mm wider", change=scaled("nut_inner_diameter", lambda d: 2.0 * d.land, 1.0, 0.6e-3)),
    Reading("hole", HOLE, "half as wide", change=scaled("hole_diameter", lambda d: 2.0 * d.hole, 0.5)),
    Reading("filled", ENDS, "filled beyond the balls", change=solid(nut_groove="loaded")),
    Reading("tetrahedra", MESH, "first-order tetrahedra of 0.08 mm", level=SOURCE_LEVEL),
    Reading("off-line", FRICTION, "0.01, balls roll, as far off their lines as it can hold them", change=off_line),
    Reading("sliding", FRICTION, "0.01, balls kept from turning, screw pushed on", sliding=MU),
    Reading("sliding-back", FRICTION, "0.01, balls kept from turning, screw let back", sliding=-MU),
)

#: Some readings of different choices together.
Combination = tuple[Reading, ...]


def key_of(readings: Combination) -> str:
    """Name of a combination."""
    return "+".join(r.key for r in readings) or "base"


def together(readings: tuple[Reading, ...], most: int) -> list[Combination]:
    """All combinations of up to ``most`` readings of different choices."""
    found: list[Combination] = [()]
    for count in range(1, most + 1):
        found += [c for c in combinations(readings, count) if len({r.choice for r in c}) == count]
    return found


def low_scene(scene: Scene, readings: Combination) -> Scene:
    """A scene as the low-order model reads it."""
    ingredients = {k: v for r in readings for k, v in r.ingredients.items()}
    return replace(scene, ingredients=replace(scene.ingredients, **ingredients))


def solid_scene(scene: Scene, readings: Combination) -> Scene:
    """A scene as the 3D model reads it, and not its mesh."""
    for r in readings:
        scene = scene if r.change is None else r.change(scene)
    return scene


def level_of(readings: Combination) -> int:
    """Mesh level of a combination."""
    return min((r.level for r in readings), default=LEVEL)
