"""Interpretations of what section 2.4.1 leaves open, in the source's low-order and 3D models, with their runs.

Two forces act on a ball in two-point contact, so they lie on the line through its two contacts. No friction acts
along the track, so nothing keeps the ball from rolling along it. Across the track, the ball may stand at a distance e
from the line of the arcs' centres. Both contact normals then turn by phi = e/h against the line through the contacts,
with h the arc's radius less the ball's; friction holds the ball while tan(phi) <= mu. With arcs of equal radius, the
line through the contacts stays parallel to that of the arcs' centres, so friction turns no force. Both contacts shift
by the arc's radius times phi, and the ball fills the grooves like a ball whose radius is larger by h phi^2/2
(`closure`).

How far a ball stands from its line depends on how it got there. A ball that rolls on both grooves moves by half of
the relative motion of the surfaces. So does the midpoint between the arcs' centres, except for the tilt of one groove
against the other: phi = r tilt/(2 h), with r the arc's radius (`tilt_that_slides`).

If a model keeps its balls from turning, the grooves slide on them, and friction does turn the forces, by mu
(`rollbench.compare.cases.lin.reconstruction.solvers`).

The text states that the contacts use an augmented Lagrangian, with all other settings by default. This leaves a
penetration, and so softer contacts, by a penalty that is not printed
(`rollbench.compare.cases.lin.reconstruction.solvers`). The natural size of the penalty is E/h, here with h the size
of the source's elements; it is computed from this size downwards.

Interpretations are combined in every way. Each combination gives the largest over the smallest load by both models,
the errors, and the scatter of meshes. Six numbers are printed: the ratio "about 1.34" for both models, and four
errors of one model against the other. Each combination is shown with its misses of these numbers; no tolerance
decides which numbers are met, and no combination is taken for what the source did. No model reads a printed number.

A contact of case 1 is meshed as the source says, by first-order tetrahedra of about 0.08 mm, and with several sizes
near that, each giving another unstructured mesh. Its approach, without its trend over size, scatters by a share s. A
ball's load then changes as under a closure of s times the approach at each of its contacts. Case 2 shows what a
closure does: its ball 17 is too large by 1 um in radius, which closes both contacts by 1 um.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from itertools import combinations
from pathlib import Path
from typing import Any, Literal

import numpy as np

from rollbench.compare.measure import error_percent, load_error
from rollbench.compare.models.study import Study
from rollbench.compare.printed import value_of
from rollbench.compare.reference.computing import compute_runs
from rollbench.compare.reference.levels import SOURCE_LEVEL
from rollbench.compare.reference.store import Run, load_run, save
from rollbench.compare.reference.tasks import Task
from rollbench.compare.reference.variants import ends_in_plain_shaft, scaled, solid
from rollbench.compare.scenes import catalogue
from rollbench.lowfi.statics.contacts import error_free_hertz
from rollbench.meshes.arrays import Array
from rollbench.meshes.loads import mean_load
from rollbench.meshes.parts import Scene

#: The coefficient that the source prints for the contacts of its 3D model.
MU = 0.01


def radius_difference(scene: Scene) -> float:
    """Return h [m], the groove's arc radius less the ball radius.

    Raises ValueError if screw and nut have different groove radii.
    """
    if scene.screw.groove_radius != scene.nut.groove_radius:
        raise ValueError("arcs of different radii: a ball that rolls leaves the line of their centres")
    return scene.screw.groove_radius - scene.balls.radius


def closure(scene: Scene, phi: float = MU) -> float:
    """Return the effective oversize of the ball radius [m] if the normals are turned by ``phi`` [rad]."""
    return 0.5 * radius_difference(scene) * phi**2


def tilt_that_slides(scene: Scene) -> float:
    """Return the tilt of one groove against the other [rad] at which a rolling ball begins to slide."""
    return 2.0 * MU * radius_difference(scene) / scene.screw.groove_radius


def off_line(scene: Scene, balls: Iterable[int] | None = None) -> Scene:
    """Return the scene with balls as far from the line of their arcs' centres as friction can hold them.

    ``balls``: numbers of these balls, from 1; by default all. They are modelled by their effective oversize
    (`closure`).
    """
    oversize, gap = dict(scene.errors.balls.listed), closure(scene)
    for k in range(1, scene.ball_count + 1) if balls is None else balls:
        oversize[k] = oversize.get(k, 0.0) + gap
    listed = tuple(sorted(oversize.items()))
    return replace(scene, errors=replace(scene.errors, balls=replace(scene.errors.balls, listed=listed)))


def largest_change(scene: Scene, of: Callable[[Scene], float]) -> float:
    """Return the relative change of a quantity ``of`` by friction on all balls whose friction raises it."""
    base = of(scene)
    return of(off_line(scene, [k for k in range(1, scene.ball_count + 1) if of(off_line(scene, (k,))) > base])) / base - 1.0


# --- readings of what section 2.4.1 leaves open: of the source's low-order model, and of its 3D model


#: The cases whose errors are printed, and the mesh level of the 3D runs without a penalty.
CASES, LEVEL = ("lin-case1", "lin-case2"), 1

#: The level of runs with a penalty (`rollbench.compare.cases.lin.reconstruction.solvers`).
PENALTY_LEVEL = 2


@dataclass(frozen=True)
class Reading:
    """One interpretation of one choice that the source leaves open."""

    #: Key.
    key: str
    #: Choice that the source leaves open.
    choice: str
    #: Interpretation of the choice.
    label: str
    #: Ingredients of the low-order model.
    ingredients: dict[str, Any] = field(default_factory=dict, hash=False)
    #: Change of the scene in 3D.
    change: Any = None
    #: Mesh level in 3D.
    level: int = LEVEL
    #: Why the text contradicts it; empty if it does not.
    by_text: str = ""
    #: Coefficient with which grooves slide on balls that do not turn, in 3D.
    sliding: float = 0.0
    #: Penalty of the contacts in 3D, over E/h; 0: no penetration.
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
    """Return the key of a combination of interpretations, used in names and tables."""
    return "+".join(r.key for r in readings) or "base"


def combinations_of(readings: tuple[Reading, ...], most: int) -> list[Combination]:
    """Return all combinations of up to ``most`` interpretations, at most one for each choice."""
    found: list[Combination] = [()]
    for count in range(1, most + 1):
        found += [c for c in combinations(readings, count) if len({r.choice for r in c}) == count]
    return found


def low_scene(scene: Scene, readings: Combination) -> Scene:
    """Return a scene for the low-order model under a combination of interpretations."""
    ingredients = {k: v for r in readings for k, v in r.ingredients.items()}
    return replace(scene, ingredients=replace(scene.ingredients, **ingredients))


def solid_scene(scene: Scene, readings: Combination) -> Scene:
    """Return a scene as the 3D model takes it under a combination of interpretations; the mesh is not part of it."""
    for r in readings:
        scene = scene if r.change is None else r.change(scene)
    return scene


def level_of(readings: Combination) -> int:
    """Return the 3D mesh level of a combination: the coarsest that any of its interpretations asks for."""
    return min((r.level for r in readings), default=LEVEL)


# --- 3D runs of the readings: computed where none is stored, kept in this folder


#: Folder of the runs.
RUNS = Path(__file__).parent / "runs"

#: Readings that move largest over smallest load by more than 0.5 % and that the text does not speak against: these are
#: combined in 3D (tests/sources/lin/literature/test_reconstruction.py). A penalty may be of any size: it is combined with
#: readings of the low-order model only.
MOVERS = ("plain", "runout", "outer-half", "tetrahedra")


def combinations_in_3d() -> list[Combination]:
    """Return the combinations that have 3D runs: none, each interpretation alone, pairs and triples of `MOVERS`."""
    movers = tuple(r for r in SOLID if r.key in MOVERS)
    return [*combinations_of(SOLID, 1), *(c for c in combinations_of(movers, 3) if len(c) > 1)]


def scenes(readings: Combination) -> tuple[Scene, ...]:
    """Return the 3D scenes of both cases under a combination; they share a set-up and are named after both."""
    name = key_of(readings).replace("/", "-")
    return tuple(replace(solid_scene(catalogue.scene(c), readings), name=f"{c}-{name}") for c in CASES)


def stored_runs(readings: Combination, level: int | None = None) -> tuple[Run, ...] | None:
    """Return the converged runs of both cases on a mesh level (default: `level_of`); None if one is missing."""
    level = level_of(readings) if level is None else level
    found = [load_run(scene, level, stores=[RUNS]) for scene in scenes(readings)]
    runs = tuple(run for run in found if run is not None and run.status == "converged")
    return runs if len(runs) == len(CASES) else None


def stored(readings: Combination, level: int | None = None) -> tuple[Array, ...] | None:
    """Return the loads of both cases, each ``(n, 4)`` [N], from `stored_runs`; None if one is missing."""
    runs = stored_runs(readings, level)
    return None if runs is None else tuple(run.load for run in runs)


def compute_missing(step: Callable[[str], None], cache: Path | None = None) -> None:
    """Compute and store the missing 3D runs.

    Raises ValueError if a run does not converge.
    """
    for readings, level in [*((r, level_of(r)) for r in combinations_in_3d()), (FINER, PENALTY_LEVEL + 1)]:
        if stored(readings, level) is not None:
            continue
        step(f"3D: {key_of(readings)}, level {level}")
        pair = scenes(readings)
        sliding, penalty = sum(r.sliding for r in readings), sum(r.penalty for r in readings)
        if penalty:
            from rollbench.compare.cases.lin.reconstruction.solvers import with_penalty

            shipped = [load_run(catalogue.scene(c), level) for c in CASES]
            runs = with_penalty(pair, [run for run in shipped if run is not None], penalty, cache)
        else:
            runs = compute_runs(Task(pair, level, cache=cache))
        if sliding:
            from rollbench.compare.cases.lin.reconstruction.solvers import with_sliding

            runs = with_sliding(pair, runs, sliding, cache)
        for scene, run in zip(pair, runs, strict=True):
            save(RUNS, scene, run)


#: Ball of case 2 that is too large, and by how much [m] in radius.
LARGE, OVERSIZE = 16, 1e-6

#: Drawn pairs of meshes of case 1 and case 2.
DRAWN = 5000

#: Approach of such a contact by Hertz [m], mean error of the approach on meshes of about the source's size, and scatter [%]
#: of one contact between two bodies meshed apart: measured by `tests/sources/lin/literature/test_reconstruction.py`.
APPROACH, BIAS, SCATTER = 6.4839e-6, -4.4, 0.33


def share_of_closure(solid: tuple[Array, ...]) -> float:
    """Return the relative change of a ball's load per relative change of one of its contact approaches.

    ``solid``: loads of cases 1 and 2 in 3D, each (n, 4) [N].
    """
    before, after = (load[LARGE, 0] for load in solid)
    return float((after / before - 1.0) * 0.5 * APPROACH / OVERSIZE)


def drawn_errors(low: tuple[Array, ...], solid: tuple[Array, ...], percent: float, *, of_load: bool = True) -> Array:
    """Return the largest and RMS error of case 1, then of case 2, with randomly scattered approaches, (DRAWN, 4) [%].

    Only flank SL counts, since both contacts of a ball carry the same load. Each case has its own mesh, and so its
    own scatter.

    Parameters
    ----------
    low
        Loads of both cases by the low-order model, each (n, 4) [N].
    solid
        Loads of both cases in 3D, each (n, 4) [N].
    percent
        Scatter of every contact's approach [%].
    of_load
        Whether errors are of each load instead of the mean load.
    """
    rng, share, out = np.random.default_rng(1), share_of_closure(solid), []
    for a, b in zip(low, solid, strict=True):
        change = 0.01 * percent * share * rng.normal(size=(DRAWN, len(b), 2)).sum(axis=2)
        meshed = b[:, 0] * (1.0 - change)
        meshed *= b[:, 0].sum() / meshed.sum(axis=1, keepdims=True)  # the axial force is the same
        errors = np.asarray(error_percent(a[:, 0], meshed, None if of_load else meshed.mean(axis=1, keepdims=True)))
        out += [np.abs(errors).max(axis=1), np.sqrt((errors**2).mean(axis=1))]
    return np.stack(out, axis=1)


def probability(errors: Array, falls: float, rises: float) -> float:
    """Return the share of `drawn_errors` whose largest error falls, and whose RMS rises, by given values or more [%]."""
    return float(((errors[:, 0] - errors[:, 2] >= falls) & (errors[:, 3] - errors[:, 1] >= rises)).mean())


# --- every combination of readings: largest over smallest load of both models, and the errors of one against the other


#: Readings of the low-order model that move the ratio by more than 0.5 %.
LOW_MOVERS = ("squared", "full", "source", "printed")

#: Errors in per cent of each contact's own load, or of the mean load.
Definition = Literal["own", "mean"]

DEFINITIONS: tuple[Definition, ...] = ("own", "mean")

#: The printed errors, in the order of `Combined.errors`.
ERRORS = ("case1_max_error", "case1_rms_error", "case2_max_error", "case2_rms_error")


@dataclass(frozen=True)
class Combined:
    """Interpretations of both models, with the load ratios of case 1 and the four errors [%] by definition."""

    low: Combination
    solid: Combination
    low_ratio: float
    solid_ratio: float
    errors: dict[Definition, tuple[float, ...]]

    @property
    def misses(self) -> Array:
        """Deviations from the printed numbers: both ratios [%], four errors of contact loads [percentage points]."""
        ratios = error_percent(np.array([self.low_ratio, self.solid_ratio]), printed_ratio())
        return np.concatenate([ratios, np.array(self.errors["own"]) - np.array(printed_errors())])

    @property
    def against_text(self) -> bool:
        """Whether the combination contradicts the text."""
        return any(r.by_text for r in (*self.low, *self.solid))


def printed_ratio() -> float:
    """Return the ratio that the text prints for both models."""
    return value_of("lin-2.4.1", "case1_ratio")


def ratio(load: Array) -> float:
    """Return the largest over smallest load of SL."""
    return float(load[:, 0].max() / load[:, 0].min())


def errors(low: tuple[Array, ...], solid: tuple[Array, ...]) -> dict[Definition, tuple[float, ...]]:
    """Return the largest and RMS error of cases 1 and 2 [%] by definition; loads ``(n, 4)`` [N] of both cases."""
    found = [load_error(a, b) for a, b in zip(low, solid, strict=True)]
    of_load = tuple(x for e in found for x in (e.own_max_percent, e.own_rms_percent))
    return {"own": of_load, "mean": tuple(x for e in found for x in (e.max_percent, e.rms_percent))}


def low_readings() -> list[Combination]:
    """Return the low-order combinations: none, each interpretation alone, pairs and triples of `LOW_MOVERS`."""
    movers = tuple(r for r in LOW if r.key in LOW_MOVERS)
    return [*combinations_of(LOW, 1), *(c for c in combinations_of(movers, 3) if len(c) > 1)]


def low_loads(study: Study, readings: Combination) -> tuple[Array, ...]:
    """Return the loads of both cases by the low-order model under a combination, each ``(n, 4)`` [N]."""
    return tuple(study.solve(low_scene(catalogue.scene(c), readings), "lin").load for c in CASES)


def solid_loads(study: Study, readings: Combination, level: int | None = None) -> tuple[Array, ...]:
    """Return loads of the cases by the 3D model, on their mesh level unless another is given.

    Raises LookupError where a run is missing.
    """
    return tuple(run.load for run in study.once(_runs, readings, level))


def _runs(study: Study, readings: Combination, level: int | None = None) -> tuple[Run, ...]:  # noqa: ARG001 - for `Study.once`
    """Return the stored runs of both cases; raises LookupError if one is missing."""
    found = stored_runs(readings, level)
    if found is None:
        raise LookupError(f"no run of {key_of(readings)}: python -m {__package__}")
    return found


def every_combination(study: Study) -> list[Combined]:
    """Return all pairs of a low-order and a 3D combination with their results, the defaults first.

    Raises LookupError if a run is missing.
    """
    low = [(c, low_loads(study, c)) for c in low_readings()]
    solid = [(c, solid_loads(study, c)) for c in combinations_in_3d()]
    return [Combined(a, b, ratio(x[0]), ratio(y[0]), errors(x, y)) for a, x in low for b, y in solid]


def printed_errors() -> tuple[float, ...]:
    """Return the four printed errors [%]."""
    return tuple(value_of("lin-2.4.1", key) for key in ERRORS)


def nearest(found: list[Combined], first: int = 6) -> Combined:
    """Return the combination closest to the printed numbers among those that the text does not contradict.

    Closest by the root mean square of the ``first`` misses: 2 are the ratios, 6 are all printed numbers.
    """
    allowed = [c for c in found if not c.against_text]
    return min(allowed, key=lambda c: float(np.linalg.norm(c.misses[:first])))


def without_penalty(found: list[Combined]) -> list[Combined]:
    """Return combinations whose contacts do not penetrate."""
    return [c for c in found if not any(r.penalty for r in c.solid)]


def explanations(found: list[Combined]) -> dict[str, Combined]:
    """Return the combinations that the page shows one by one, by name.

    They are: all defaults; the nearest in the printed ratio, without a penalty (some penalty would give any ratio);
    each penalty of the 3D contacts with all else by default; and the nearest in all six printed numbers.
    """
    softer = {
        f"penalty of the 3D contacts: {c.solid[0].label}": c for c in found if not c.low and any(r.penalty for r in c.solid)
    }
    return {
        "all by default": found[0],
        "nearest in the ratio, no penalty": nearest(without_penalty(found), 2),
        **softer,
        "nearest in all six": nearest(found),
    }


def penalty_share(study: Study, readings: Combination) -> float:
    """Return the approach that a penalty adds at a contact, over Hertz's approach at the mean load."""
    scene = catalogue.scene(CASES[0])
    still, moved = (study.once(_runs, r)[0] for r in ((), readings))
    track = scene.track
    lead = np.arctan(track.lead / (2.0 * np.pi * track.pitch_radius))
    added = (
        0.5 * float((moved.centreline[:, 3] - still.centreline[:, 3]).mean()) * np.sin(track.contact_angle) * np.cos(lead)
    )
    load = mean_load(still.load)
    return float(added / (np.mean(error_free_hertz(scene).C[[0, 3]]) * load ** (2.0 / 3.0)))
