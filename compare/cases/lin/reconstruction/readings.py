"""Readings of what section 2.4.1 leaves open: of the source's low-order model, and of its 3D model, with their runs.

Two forces act on such a ball, so that they lie on the line through its two contacts. Nothing keeps it from rolling along
the track: no friction acts that way. Across it, the ball may stand beside the line of the arcs' centres by e. Both normals
then turn by phi = e/h against the line of the contacts, h the arc's radius less the ball's, and friction holds the ball
while tan(phi) <= mu. With arcs of one radius the line of the contacts stays parallel to that of the arcs' centres, so that
friction turns no force. It shifts both by the arc's radius times phi, and the ball fills the grooves as a ball does whose
radius is larger by h phi^2/2 (`closure`).

How far a ball stands beside its line follows from how it gets there. Rolling on both grooves, it goes half of the way that
one surface goes past the other. So does the middle of the arcs' centres, but for the tilt of one groove against the other:
phi = r tilt/(2 h), r the arc's radius (`tilt_that_slides`).

Where a model keeps its balls from turning, the grooves slide on them instead, and friction does turn the forces, by mu
(`rollbench.compare.cases.lin.reconstruction.solvers`).

The text prints that contacts are those of an augmented Lagrangian, all else by default: that leaves a penetration, and so
softer contacts, by a penalty that is not printed (`rollbench.compare.cases.lin.reconstruction.solvers`). Its natural
size is E/h, h the size of the source's elements; it is computed from there on downwards.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from itertools import combinations
from pathlib import Path
from typing import Any

from rollbench.compare.reference.computing import compute
from rollbench.compare.reference.levels import SOURCE_LEVEL
from rollbench.compare.reference.store import Run, load, save
from rollbench.compare.reference.tasks import Task
from rollbench.compare.reference.variants import ends_in_plain_shaft, scaled, solid
from rollbench.compare.scenes import catalogue
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import Scene

#: The coefficient that the source prints for the contacts of its 3D model.
MU = 0.01


def slack(scene: Scene) -> float:
    """h [m]: the arc's radius less the ball's. Raises ValueError for grooves of different radii."""
    if scene.screw.groove_radius != scene.nut.groove_radius:
        raise ValueError("arcs of different radii: a ball that rolls leaves the line of their centres")
    return scene.screw.groove_radius - scene.balls.radius


def closure(scene: Scene, phi: float = MU) -> float:
    """What a ball is larger by [m in radius] in effect whose normals are turned by ``phi`` [rad]."""
    return 0.5 * slack(scene) * phi**2


def tilt_that_slides(scene: Scene) -> float:
    """Tilt [rad] of one groove against the other in their section at which a ball that rolled there begins to slide."""
    return 2.0 * MU * slack(scene) / scene.screw.groove_radius


def off_line(scene: Scene, balls: Iterable[int] | None = None) -> Scene:
    """The scene with these balls, from 1 (all unless given), as far beside the lines of their arcs' centres as friction can
    hold them."""
    oversize, gap = dict(scene.errors.balls.listed), closure(scene)
    for k in range(1, scene.ball_count + 1) if balls is None else balls:
        oversize[k] = oversize.get(k, 0.0) + gap
    listed = tuple(sorted(oversize.items()))
    return replace(scene, errors=replace(scene.errors, balls=replace(scene.errors.balls, listed=listed)))


def largest_change(scene: Scene, of: Callable[[Scene], float]) -> float:
    """Relative change of a quantity ``of`` a scene by friction on those balls alone by which it rises."""
    base = of(scene)
    return of(off_line(scene, [k for k in range(1, scene.ball_count + 1) if of(off_line(scene, (k,))) > base])) / base - 1.0


# --- readings of what section 2.4.1 leaves open: of the source's low-order model, and of its 3D model


#: The cases whose errors are printed, and the mesh level of the 3D runs without a penalty.
CASES, LEVEL = ("lin-case1", "lin-case2"), 1
#: The level of runs with a penalty (`rollbench.compare.cases.lin.reconstruction.solvers`).
PENALTY_LEVEL = 2


@dataclass(frozen=True)
class Reading:
    """One reading of one open choice: key, what is open, what it is read as; ingredients of the low-order model, or what
    it makes of a scene in 3D; level of the 3D mesh; by_text: why the text speaks against it (empty: it does not); sliding:
    coefficient with which grooves slide on balls that do not turn, in 3D; penalty: of the contacts in 3D, as a share of
    E/h (0: none, contacts do not penetrate)."""

    key: str
    choice: str
    label: str
    ingredients: dict[str, Any] = field(default_factory=dict, hash=False)
    change: Any = None
    level: int = LEVEL
    by_text: str = ""
    sliding: float = 0.0
    penalty: float = 0.0


SHAFT, HELD, LAND = "shaft beyond the nut", "what holds the nut", "nut's lands"
HOLE, ENDS, MESH = "hole along the screw", "ends of the nut's groove", "mesh of the contacts"
FRICTION, PENALTY = "friction of the contacts", "penalty of the contacts"
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
    Reading("penalty", PENALTY, "E/h, h = 0.08 mm", level=PENALTY_LEVEL, penalty=1.0),
    Reading("penalty/3", PENALTY, "a third of E/h", level=PENALTY_LEVEL, penalty=1.0 / 3.0),
    Reading("penalty/4", PENALTY, "a quarter of E/h", level=PENALTY_LEVEL, penalty=0.25),
    Reading("penalty/6", PENALTY, "a sixth of E/h", level=PENALTY_LEVEL, penalty=1.0 / 6.0),
)
#: The penalty that is computed on the next mesh level too, which says what its level leaves open.
FINER = tuple(r for r in SOLID if r.key == "penalty/4")

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


# --- 3D runs of the readings: computed where none is stored, kept in this folder


#: Folder of the runs.
RUNS = Path(__file__).parent / "runs"
#: Readings that move largest over smallest load by more than 0.5 % and that the text does not speak against: these are
#: combined in 3D (tests/sources/lin/literature/test_reconstruction.py). A penalty may be of any size: it is combined with
#: readings of the low-order model only.
MOVERS = ("plain", "runout", "outer-half", "tetrahedra")


def wanted() -> list[Combination]:
    """Combinations of the 3D model that have runs: none, every reading alone, all pairs and triples of `MOVERS`."""
    movers = tuple(r for r in SOLID if r.key in MOVERS)
    return [*together(SOLID, 1), *(c for c in together(movers, 3) if len(c) > 1)]


def scenes(readings: Combination) -> tuple[Scene, ...]:
    """The cases by a combination, which share a set-up; named after both."""
    name = key_of(readings).replace("/", "-")
    return tuple(replace(solid_scene(catalogue.scene(c), readings), name=f"{c}-{name}") for c in CASES)


def stored_runs(readings: Combination, level: int | None = None) -> tuple[Run, ...] | None:
    """Converged runs of the cases, on their level unless another is given; None where one is missing."""
    level = level_of(readings) if level is None else level
    found = [load(scene, level, stores=[RUNS]) for scene in scenes(readings)]
    runs = tuple(run for run in found if run is not None and run.status == "converged")
    return runs if len(runs) == len(CASES) else None


def stored(readings: Combination, level: int | None = None) -> tuple[Array, ...] | None:
    """Loads ``(n, 4)`` [N] of the cases, as `stored_runs`."""
    runs = stored_runs(readings, level)
    return None if runs is None else tuple(run.load for run in runs)


def complete(step: Callable[[str], None], cache: Path | None = None) -> None:
    """Compute and keep the runs that are missing. Raises ValueError for one that does not converge."""
    for readings, level in [*((r, level_of(r)) for r in wanted()), (FINER, PENALTY_LEVEL + 1)]:
        if stored(readings, level) is not None:
            continue
        step(f"3D: {key_of(readings)}, level {level}")
        pair = scenes(readings)
        sliding, penalty = sum(r.sliding for r in readings), sum(r.penalty for r in readings)
        if penalty:
            from rollbench.compare.cases.lin.reconstruction.solvers import with_penalty

            shipped = [load(catalogue.scene(c), level) for c in CASES]
            runs = with_penalty(pair, [run for run in shipped if run is not None], penalty, cache)
        else:
            runs = compute(Task(pair, level, cache=cache))
        if sliding:
            from rollbench.compare.cases.lin.reconstruction.solvers import with_sliding

            runs = with_sliding(pair, runs, sliding, cache)
        for scene, run in zip(pair, runs, strict=True):
            save(RUNS, scene, run)
