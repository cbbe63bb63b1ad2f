"""Interpretations of inputs that section 2.4.1 of Lin's thesis leaves open, for his low-order model and his 3D model.

Two forces act on a ball in two-point contact, so they lie on the line through its two contacts. No friction acts along the
track, so nothing keeps the ball from rolling along it. Across the track, the ball may be displaced by a distance e from the
line through the arcs' centres. Both contact normals then turn by phi = e/h against the line through the contacts, with h
the arc's radius less the ball's; friction holds the ball while tan(phi) <= mu. With arcs of equal radius, the line through
the contacts stays parallel to the line through the arcs' centres, so friction turns no force. Both contacts shift by the
arc's radius times phi, and the ball fills the grooves like a ball whose radius is larger by h phi^2/2
(`oversize_of_displaced_ball`).

How far a ball is displaced depends on its previous motion. A ball that rolls on both grooves moves by half of the relative
motion of the surfaces. So does the midpoint between the arcs' centres, except for the tilt of one groove against the other:
phi = r tilt/(2 h), with r the arc's radius (`tilt_at_onset_of_sliding`).

If a model keeps its balls from turning, the grooves slide on them, and friction does turn the forces, by mu
(`rollbench.compare.cases.lin.reconstruction.solvers`).

The text states that the contacts use an augmented Lagrangian, with all other settings by default. This leaves a
penetration, and so softer contacts, by a penalty that is not printed
(`rollbench.compare.cases.lin.reconstruction.solvers`). The natural size of the penalty is E/h, with E Young's modulus and
here h the size of Lin's elements; penalties of this size and smaller are computed.

All interpretations of different modelling choices are combined. Each combination gives the largest over the smallest load
by both models, the errors of one model against the other, and their scatter between meshes. Six numbers are printed: the
load ratio "about 1.34" for both models, and four errors. Each combination is shown with its deviations from these numbers;
no tolerance decides which numbers are met, and no combination is claimed to be what Lin did. No model reads a printed
number.

A contact of case 1 is meshed as Lin states, by first-order tetrahedra of about 0.08 mm, and with several sizes near that,
each of which gives another unstructured mesh. After subtraction of its trend over the element size, the approach scatters
by a fraction s. A ball's load then changes as if each of its contacts were closed (the bodies brought together) by s times
the approach. Case 2 shows the effect of such a closure: its ball 17 is too large by 1 um in radius, which closes both
contacts by 1 um.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from itertools import combinations
from pathlib import Path
from typing import Any, Literal

import numpy as np

from rollbench.compare.measure import error_percent, load_error, mean_load
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.printed import printed_value
from rollbench.compare.reference.computing import compute_reference_runs
from rollbench.compare.reference.levels import SOURCE_LEVEL, change_solid_model, scale_dimension, with_shortened_groove
from rollbench.compare.reference.store import Run, load_stored_run, save_run
from rollbench.compare.reference.tasks import ReferenceTask
from rollbench.compare.scenes import catalogue
from rollbench.lowfi.statics.contacts import hertz_without_errors
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import Scene

#: Coefficient of friction that Lin prints for the contacts of his 3D model.
MU = 0.01


def groove_radius_less_ball_radius(scene: Scene) -> float:
    """Return the difference h [m] between groove radius and ball radius.

    ``scene``: ball screw. Raises ValueError if screw and nut have different groove radii.
    """
    if scene.screw.groove_radius != scene.nut.groove_radius:
        radii = f"{scene.screw.groove_radius:g} and {scene.nut.groove_radius:g} m"
        raise ValueError(f"groove radius less ball radius: needs equal groove radii of screw and nut, got {radii}")
    return scene.screw.groove_radius - scene.balls.radius


def oversize_of_displaced_ball(scene: Scene, normal_rotation: float = MU) -> float:
    """Return the oversize of the ball radius [m] that reduces its clearance in the grooves as much as displacing it does.

    The ball is displaced across the groove, from the line through the arcs' centres of both groove sections. The oversize
    is h phi^2/2, with h the groove radius less the ball radius. ``normal_rotation``: angle phi [rad] by which the
    displacement turns the contact normals; ``scene``: ball screw with equal groove radii of screw and nut.
    """
    return 0.5 * groove_radius_less_ball_radius(scene) * normal_rotation**2


def tilt_at_onset_of_sliding(scene: Scene) -> float:
    """Return the tilt [rad] of the screw's groove against the nut's groove, at which a rolling ball begins to slide."""
    return 2.0 * MU * groove_radius_less_ball_radius(scene) / scene.screw.groove_radius


def with_displaced_balls(scene: Scene, balls: Iterable[int] | None = None) -> Scene:
    """Return a copy of the scene with balls displaced across their grooves as far as friction can hold them.

    A ball is displaced from the line through the arcs' centres of both groove sections. The displacement is modelled by an
    oversize of the ball (`oversize_of_displaced_ball`). ``balls``: numbers of the displaced balls, from 1; by default all.
    """
    oversize, gap = dict(scene.errors.balls.listed), oversize_of_displaced_ball(scene)
    for k in range(1, scene.ball_count + 1) if balls is None else balls:
        oversize[k] = oversize.get(k, 0.0) + gap
    listed = tuple(sorted(oversize.items()))
    return replace(scene, errors=replace(scene.errors, balls=replace(scene.errors.balls, listed=listed)))


def largest_relative_rise_by_friction(scene: Scene, quantity: Callable[[Scene], float]) -> float:
    """Return the largest relative rise of a quantity that friction can cause by displacing some of the balls of a scene.

    A ball is displaced if displacing it alone raises the quantity. ``quantity``: function that returns the quantity of a
    scene.
    """
    base, balls = quantity(scene), range(1, scene.ball_count + 1)
    raising = [k for k in balls if quantity(with_displaced_balls(scene, (k,))) > base]
    return quantity(with_displaced_balls(scene, raising)) / base - 1.0


# --- interpretations of inputs that section 2.4.1 leaves open: of Lin's low-order model, and of his 3D model


#: Scenes of the cases whose errors are printed, and the mesh level of 3D solutions without a penalty.
CASES, LEVEL = ("lin-case1", "lin-case2"), 1

#: Mesh level of 3D solutions with a penalty (`rollbench.compare.cases.lin.reconstruction.solvers`).
PENALTY_LEVEL = 2


@dataclass(frozen=True)
class Interpretation:
    """One interpretation of one modelling choice that Lin's thesis leaves open, for his low-order or his 3D model."""

    #: Short name of the interpretation, used in names of scenes and in tables.
    short_name: str
    #: Modelling choice that the thesis leaves open and that is interpreted here, in words.
    modelling_choice: str
    #: The interpretation, in words.
    description: str
    #: New values of the low-order model's options that the interpretation changes, by name of the option.
    low_order_options: dict[str, Any] = field(default_factory=dict, hash=False)
    #: Function that returns a copy of a scene as changed by the interpretation for the 3D model; None: no change.
    change_scene: Any = None
    #: Mesh level of the 3D model.
    mesh_level: int = LEVEL
    #: Why the text of the thesis contradicts the interpretation; empty if it does not.
    contradiction: str = ""
    #: Coefficient of friction between grooves and balls in 3D, where the grooves slide on balls that do not turn; 0: none.
    sliding_friction: float = 0.0
    #: Contact penalty in 3D divided by E/h (E: Young's modulus, h: size of Lin's elements); 0: no penetration.
    relative_penalty: float = 0.0


SHAFT, HELD, LAND = "shaft beyond the nut", "what holds the nut", "nut's lands"

HOLE, ENDS, MESH = "hole along the screw", "ends of the nut's groove", "mesh of the contacts"

FRICTION, PENALTY = "friction of the contacts", "penalty of the contacts"

SECTION, PARTITION, HERTZ, ARM = "section constant (C.8)", "beam elements in the nut", "Hertz constants", "lever arm"

#: Interpretations for the low-order model; default: equation C.8 with its root, node at every contact, exact Hertz
#: constants.
LOW = (
    Interpretation("squared", SECTION, "C.8 without its root", {"section": "groove squared"}),
    Interpretation("full", SECTION, "groove ignored", {"section": "full"}),
    Interpretation("source", PARTITION, "15 mm, as printed", {"partition": "source"}),
    Interpretation("printed", HERTZ, "as printed (Table B.1)", {"hertz": "as printed"}),
    Interpretation("actual", HERTZ, "at each contact's own geometry", {"hertz": "actual"}),
    Interpretation("nominal", ARM, "frozen at the nominal contact point", {"arm": "nominal"}),
    Interpretation("ball", ARM, "at the ball's station", {"arm": "ball"}),
)

#: Interpretations for the 3D model; default: shaft grooved all along, nut fixed at its whole left face, no friction.
SOLID = (
    Interpretation(
        "plain",
        SHAFT,
        "plain, of the lands' diameter",
        change_scene=lambda s: change_solid_model(shaft_diameter=s.screw.outer_diameter)(s),
    ),
    Interpretation("runout", SHAFT, "groove ends 12 mm beyond the nut", change_scene=with_shortened_groove),
    Interpretation(
        "outer-half", HELD, "outer half of the left face", change_scene=change_solid_model(nut_held="left face, outer half")
    ),
    Interpretation(
        "inner-half", HELD, "inner half of the left face", change_scene=change_solid_model(nut_held="left face, inner half")
    ),
    Interpretation(
        "surface",
        HELD,
        "outer surface",
        change_scene=change_solid_model(nut_held="outer surface"),
        contradiction="its left end holds the nut",
    ),
    Interpretation(
        "right",
        HELD,
        "right face",
        change_scene=change_solid_model(nut_held="right face"),
        contradiction="its left end holds the nut",
    ),
    Interpretation(
        "narrow",
        LAND,
        "0.6 mm narrower",
        change_scene=scale_dimension("nut_inner_diameter", lambda d: 2.0 * d.land, 1.0, -0.6e-3),
    ),
    Interpretation(
        "wide",
        LAND,
        "0.6 mm wider",
        change_scene=scale_dimension("nut_inner_diameter", lambda d: 2.0 * d.land, 1.0, 0.6e-3),
    ),
    Interpretation(
        "hole", HOLE, "half as wide", change_scene=scale_dimension("hole_diameter", lambda d: 2.0 * d.hole, 0.5)
    ),
    Interpretation("filled", ENDS, "filled beyond the balls", change_scene=change_solid_model(nut_groove="loaded")),
    Interpretation("tetrahedra", MESH, "first-order tetrahedra of 0.08 mm", mesh_level=SOURCE_LEVEL),
    Interpretation(
        "off-line",
        FRICTION,
        "0.01, balls roll, as far off their lines as it can hold them",
        change_scene=with_displaced_balls,
    ),
    Interpretation("sliding", FRICTION, "0.01, balls kept from turning, screw pushed on", sliding_friction=MU),
    Interpretation("sliding-back", FRICTION, "0.01, balls kept from turning, screw let back", sliding_friction=-MU),
    Interpretation("penalty", PENALTY, "E/h, h = 0.08 mm", mesh_level=PENALTY_LEVEL, relative_penalty=1.0),
    Interpretation("penalty/3", PENALTY, "a third of E/h", mesh_level=PENALTY_LEVEL, relative_penalty=1.0 / 3.0),
    Interpretation("penalty/4", PENALTY, "a quarter of E/h", mesh_level=PENALTY_LEVEL, relative_penalty=0.25),
    Interpretation("penalty/6", PENALTY, "a sixth of E/h", mesh_level=PENALTY_LEVEL, relative_penalty=1.0 / 6.0),
)

#: Interpretation with the penalty that is also computed on the next mesh level, to show the influence of the mesh.
FINER = tuple(r for r in SOLID if r.short_name == "penalty/4")

#: Interpretations of different modelling choices that are applied together.
Combination = tuple[Interpretation, ...]


def combination_name(combination: Combination) -> str:
    """Return the short names of a combination's interpretations, as in "plain+tetrahedra"; "base" if it has none."""
    return "+".join(r.short_name for r in combination) or "base"


def combine_interpretations(interpretations: tuple[Interpretation, ...], largest_count: int) -> list[Combination]:
    """Return all combinations of interpretations, each with at most one interpretation of the same modelling choice.

    ``interpretations``: the interpretations; ``largest_count``: largest number of interpretations in a combination. The
    first combination is empty: all choices by default.
    """
    found: list[Combination] = [()]
    for count in range(1, largest_count + 1):
        found += [c for c in combinations(interpretations, count) if len({r.modelling_choice for r in c}) == count]
    return found


def scene_for_low_order_model(scene: Scene, combination: Combination) -> Scene:
    """Return a copy of the scene, changed for the low-order model as a combination of interpretations requires."""
    ingredients = {k: v for r in combination for k, v in r.low_order_options.items()}
    return replace(scene, ingredients=replace(scene.ingredients, **ingredients))


def scene_for_3d_model(scene: Scene, combination: Combination) -> Scene:
    """Return a copy of the scene, changed for the 3D model (except its mesh) as a combination requires."""
    for r in combination:
        scene = scene if r.change_scene is None else r.change_scene(scene)
    return scene


def mesh_level_of_combination(combination: Combination) -> int:
    """Return the mesh level on which a combination of interpretations is solved in 3D: the lowest of their mesh levels."""
    return min((r.mesh_level for r in combination), default=LEVEL)


# --- 3D runs of the interpretations: computed if not stored, then stored in this folder


#: Folder of the stored 3D results.
RUNS = Path(__file__).parent / "runs"

#: Interpretations that change the ratio of largest to smallest load by more than 0.5 % and do not contradict the text:
#: these are combined in 3D (tests/sources/lin/literature/test_reconstruction.py). A penalty may be of any size: it is
#: combined with interpretations of the low-order model only.
MOVERS = ("plain", "runout", "outer-half", "tetrahedra")


def combinations_solved_in_3d() -> list[Combination]:
    """Return the combinations of interpretations that are solved in 3D: none, each alone, pairs and triples of `MOVERS`.

    None: all modelling choices by default. `MOVERS` are the interpretations that change the ratio of largest to smallest
    load noticeably.
    """
    movers = tuple(r for r in SOLID if r.short_name in MOVERS)
    return [*combine_interpretations(SOLID, 1), *(c for c in combine_interpretations(movers, 3) if len(c) > 1)]


def case_scenes_in_3d(combination: Combination) -> tuple[Scene, ...]:
    """Return the scenes of Lin's cases 1 and 2, changed for the 3D model as a combination of interpretations requires.

    ``combination``: the combination, whose short name (`combination_name`) becomes a part of the scenes' names.
    """
    name = combination_name(combination).replace("/", "-")
    return tuple(replace(scene_for_3d_model(catalogue.scene(c), combination), name=f"{c}-{name}") for c in CASES)


def stored_3d_results_or_none(combination: Combination, level: int | None = None) -> tuple[Run, ...] | None:
    """Return the stored 3D results of Lin's cases 1 and 2 under a combination of interpretations.

    Returns None if a result is missing or did not converge. ``combination``: the combination; ``level``: mesh level; None:
    level of `mesh_level_of_combination`.
    """
    level = mesh_level_of_combination(combination) if level is None else level
    found = [load_stored_run(scene, level, stores=[RUNS]) for scene in case_scenes_in_3d(combination)]
    runs = tuple(run for run in found if run is not None and run.status == "converged")
    return runs if len(runs) == len(CASES) else None


def stored_loads(combination: Combination, level: int | None = None) -> tuple[Array, ...] | None:
    """Return the stored contact loads of Lin's cases 1 and 2 in 3D under a combination; None if a result is missing.

    Each array is (n, 4) [N] for n balls and the flanks SL, SR, NL and NR (screw or nut, left or right). ``combination``:
    combination of interpretations; ``level``: mesh level; None: level of `mesh_level_of_combination`.
    """
    runs = stored_3d_results_or_none(combination, level)
    return None if runs is None else tuple(run.load for run in runs)


def compute_missing_3d_results(step: Callable[[str], None], cache: Path | None = None) -> None:
    """Compute and store those 3D results of all combinations of interpretations that are not stored yet.

    ``step``: function that receives a message before each solution; ``cache``: folder for intermediate results, None for no
    such folder. Raises ValueError if a solution does not converge.
    """
    for readings, level in [
        *((r, mesh_level_of_combination(r)) for r in combinations_solved_in_3d()),
        (FINER, PENALTY_LEVEL + 1),
    ]:
        if stored_loads(readings, level) is not None:
            continue
        step(f"3D: {combination_name(readings)}, level {level}")
        pair = case_scenes_in_3d(readings)
        sliding, penalty = sum(r.sliding_friction for r in readings), sum(r.relative_penalty for r in readings)
        if penalty:
            from rollbench.compare.cases.lin.reconstruction.solvers import solve_with_penalty_contacts

            shipped = [load_stored_run(catalogue.scene(c), level) for c in CASES]
            runs = solve_with_penalty_contacts(pair, [run for run in shipped if run is not None], penalty, cache)
        else:
            runs = compute_reference_runs(ReferenceTask(pair, level, cache_folder=cache))
        if sliding:
            from rollbench.compare.cases.lin.reconstruction.solvers import solve_with_sliding_balls

            runs = solve_with_sliding_balls(pair, runs, sliding, cache)
        for scene, run in zip(pair, runs, strict=True):
            save_run(RUNS, scene, run)


#: Index of the oversize ball of case 2, and oversize of its radius [m].
LARGE, OVERSIZE = 16, 1e-6

#: Number of random pairs of meshes, one mesh for case 1 and one for case 2, over which errors scatter.
DRAWN = 5000

#: Hertz approach [m] of a contact of case 1; mean error [%] of the approach on meshes of about Lin's element size, and
#: scatter of this error [%] between meshes: computed by `tests/sources/lin/literature/test_reconstruction.py`.
APPROACH, BIAS, SCATTER = 6.4839e-6, -4.4, 0.33


def relative_load_rise_per_hertz_approach(loads_in_3d: tuple[Array, ...]) -> float:
    """Return the relative rise of a ball's load if one of its contacts is compressed by one more Hertz approach.

    The rise is extrapolated linearly from the oversize ball of case 2, whose larger radius compresses both its contacts.
    ``loads_in_3d``: contact loads of Lin's cases 1 and 2 in 3D, each (n, 4) [N] for n balls and the flanks SL, SR, NL and
    NR (screw or nut, left or right).
    """
    before, after = (load[LARGE, 0] for load in loads_in_3d)
    return float((after / before - 1.0) * 0.5 * APPROACH / OVERSIZE)


def low_order_errors_on_random_meshes(
    low_order: tuple[Array, ...], in_3d: tuple[Array, ...], scatter_percent: float, *, in_percent_of_each_load: bool = True
) -> Array:
    """Return the errors [%] of the low-order loads against 3D loads that scatter with the mesh, as an array (DRAWN, 4).

    Rows: pairs of random meshes, one mesh for each of Lin's cases 1 and 2. Columns: largest and RMS error of case 1,
    largest and RMS error of case 2. Only flank SL (left flank of the screw) counts, since both contacts of a ball carry the
    same load. Each case has its own mesh, and so its own scatter.

    Parameters
    ----------
    low_order
        Contact loads of cases 1 and 2 by the low-order model, each (n, 4) [N] for n balls and four groove flanks, SL first.
    in_3d
        The same loads by the 3D model.
    scatter_percent
        Standard deviation [%] of the Hertz approach of each contact, at the same load, over the random meshes.
    in_percent_of_each_load
        Whether errors are in per cent of each load instead of the mean load.
    """
    rng, share, out = np.random.default_rng(1), relative_load_rise_per_hertz_approach(in_3d), []
    for a, b in zip(low_order, in_3d, strict=True):
        change = 0.01 * scatter_percent * share * rng.normal(size=(DRAWN, len(b), 2)).sum(axis=2)
        meshed = b[:, 0] * (1.0 - change)
        meshed *= b[:, 0].sum() / meshed.sum(axis=1, keepdims=True)  # the axial force is the same
        errors = np.asarray(
            error_percent(a[:, 0], meshed, None if in_percent_of_each_load else meshed.mean(axis=1, keepdims=True))
        )
        out += [np.abs(errors).max(axis=1), np.sqrt((errors**2).mean(axis=1))]
    return np.stack(out, axis=1)


def fraction_of_meshes_with_fall_and_rise(errors: Array, least_fall: float, least_rise: float) -> float:
    """Return the fraction of random mesh pairs with a fall of the largest and a rise of the RMS error from case 1 to 2.

    ``errors``: errors [%] from `low_order_errors_on_random_meshes`; ``least_fall``, ``least_rise``: smallest fall of the
    largest error and smallest rise of the RMS error that count [percentage points].
    """
    return float(((errors[:, 0] - errors[:, 2] >= least_fall) & (errors[:, 3] - errors[:, 1] >= least_rise)).mean())


# --- all combinations: largest over smallest load by both models, and errors of one model against the other


#: Interpretations of the low-order model that change the ratio of largest to smallest load by more than 0.5 %.
LOW_MOVERS = ("squared", "full", "source", "printed")

#: Definition of errors: in per cent of each contact's load ("own") or of the mean load.
Definition = Literal["own", "mean"]

DEFINITIONS: tuple[Definition, ...] = ("own", "mean")

#: Keys of the printed errors, in the order of the values of `CombinationResult.errors_percent`.
ERRORS = ("case1_max_error", "case1_rms_error", "case2_max_error", "case2_rms_error")


@dataclass(frozen=True)
class CombinationResult:
    """Results of a combination of interpretations: ratios of largest to smallest load, errors of the low-order loads.

    ``low_order_readings``, ``readings_in_3d``: interpretations for the low-order and for the 3D model; ``low_order_ratio``,
    ``ratio_in_3d``: ratio of largest to smallest load in case 1 by these models; ``errors_percent``: errors of the
    low-order loads against the 3D loads; key "own": in per cent of each load, "mean": in per cent of the mean load; values:
    largest and RMS error of case 1, then of case 2.
    """

    low_order_readings: Combination
    readings_in_3d: Combination
    low_order_ratio: float
    ratio_in_3d: float
    errors_percent: dict[Definition, tuple[float, ...]]

    @property
    def deviations_from_print(self) -> Array:
        """Deviations from the printed numbers (6,): two load ratios [%], then four errors of loads [percentage points].

        The load ratios are those of the low-order, then of the 3D model; the errors: largest and RMS of case 1, then of
        case 2.
        """
        ratios = error_percent(np.array([self.low_order_ratio, self.ratio_in_3d]), printed_load_ratio())
        return np.concatenate([ratios, np.array(self.errors_percent["own"]) - np.array(printed_errors_percent())])

    @property
    def contradicts_text(self) -> bool:
        """Whether one of the interpretations contradicts the text of Lin's thesis."""
        return any(r.contradiction for r in (*self.low_order_readings, *self.readings_in_3d))


def printed_load_ratio() -> float:
    """Return the ratio of largest to smallest load that Lin prints for both models: about 1.34."""
    return printed_value("lin-2.4.1", "case1_ratio")


def load_ratio(load: Array) -> float:
    """Return the ratio of the largest to the smallest ball load on flank SL, the left flank of the screw.

    ``load``: contact loads (n, 4) [N] of n balls on the flanks SL, SR, NL and NR (screw or nut, left or right).
    """
    return float(load[:, 0].max() / load[:, 0].min())


def low_order_errors_percent(low_order: tuple[Array, ...], in_3d: tuple[Array, ...]) -> dict[Definition, tuple[float, ...]]:
    """Return the errors of the low-order model's loads against the 3D loads, in per cent of each and of the mean load.

    The keys are "own" (of each load) and "mean" (of the mean load); the values are largest and RMS error of Lin's case 1,
    then of his case 2. ``low_order``, ``in_3d``: contact loads of both cases by the low-order and by the 3D model, each (n,
    4) [N] for n balls and four groove flanks.
    """
    found = [load_error(a, b) for a, b in zip(low_order, in_3d, strict=True)]
    of_load = tuple(x for e in found for x in (e.own_max_percent, e.own_rms_percent))
    return {"own": of_load, "mean": tuple(x for e in found for x in (e.max_percent, e.rms_percent))}


def combinations_for_low_order_model() -> list[Combination]:
    """Return combinations of interpretations for the low-order model: none, each alone, pairs and triples of `LOW_MOVERS`.

    None: all modelling choices by default. `LOW_MOVERS` are the interpretations that change the ratio of largest to
    smallest load noticeably.
    """
    movers = tuple(r for r in LOW if r.short_name in LOW_MOVERS)
    return [*combine_interpretations(LOW, 1), *(c for c in combine_interpretations(movers, 3) if len(c) > 1)]


def low_order_loads(cache: SceneResultCache, combination: Combination) -> tuple[Array, ...]:
    """Return the contact loads of Lin's cases 1 and 2 by the low-order model under a combination of interpretations.

    Each array is (n, 4) [N] for n balls and four groove flanks. ``cache``: gives the solved scenes; ``combination``: the
    combination.
    """
    return tuple(cache.solve_once(scene_for_low_order_model(catalogue.scene(c), combination), "lin").load for c in CASES)


def required_loads_in_3d(cache: SceneResultCache, combination: Combination, level: int | None = None) -> tuple[Array, ...]:
    """Return the stored contact loads of Lin's cases 1 and 2 by the 3D model under a combination of interpretations.

    Each array is (n, 4) [N] for n balls and four groove flanks. ``cache``: caches the results; ``combination``: the
    combination; ``level``: mesh level; None: level of `mesh_level_of_combination`. Raises LookupError if a result is not
    stored.
    """
    return tuple(run.load for run in cache.compute_once(_required_runs_in_3d, combination, level))


def _required_runs_in_3d(cache: SceneResultCache, combination: Combination, level: int | None = None) -> tuple[Run, ...]:  # noqa: ARG001
    """Return the stored 3D results of cases 1 and 2 under a combination; raises LookupError if one is missing.

    ``cache``: not used here; ``level``: mesh level; None: level of `mesh_level_of_combination`.
    """
    found = stored_3d_results_or_none(combination, level)
    if found is None:
        raise LookupError(
            "no contact loads of the 3D model are stored for the combination of interpretations of Lin's text "
            f"{combination_name(combination)!r}: run python -m {__package__}"
        )
    return found


def evaluate_combinations(cache: SceneResultCache) -> list[CombinationResult]:
    """Return load ratios and model errors for each combination of interpretations for the low-order and for the 3D model.

    A load ratio is the largest load of case 1 divided by its smallest load. The first result has all choices by default.
    Raises LookupError if a 3D result is not stored. ``cache``: gives solved scenes and stored 3D results.
    """
    low = [(c, low_order_loads(cache, c)) for c in combinations_for_low_order_model()]
    solid = [(c, required_loads_in_3d(cache, c)) for c in combinations_solved_in_3d()]
    return [
        CombinationResult(a, b, load_ratio(x[0]), load_ratio(y[0]), low_order_errors_percent(x, y))
        for a, x in low
        for b, y in solid
    ]


def printed_errors_percent() -> tuple[float, ...]:
    """Return the four errors [%] against ANSYS that Lin prints: largest and RMS error of case 1, then of case 2."""
    return tuple(printed_value("lin-2.4.1", key) for key in ERRORS)


def combination_nearest_to_print(found: list[CombinationResult], deviation_count: int = 6) -> CombinationResult:
    """Return the combination whose results are nearest to the printed numbers, of those that the text does not contradict.

    The distance is the root sum of squares of the deviations `CombinationResult.deviations_from_print`. ``found``: results
    of all combinations; ``deviation_count``: how many of the deviations count; 2: only the load ratios, 6: all.
    """
    allowed = [c for c in found if not c.contradicts_text]
    return min(allowed, key=lambda c: float(np.linalg.norm(c.deviations_from_print[:deviation_count])))


def combinations_without_penalty(found: list[CombinationResult]) -> list[CombinationResult]:
    """Return the combinations in ``found`` whose contacts in 3D have no penalty."""
    return [c for c in found if not any(r.relative_penalty for r in c.readings_in_3d)]


def explanations_shown_in_report(found: list[CombinationResult]) -> dict[str, CombinationResult]:
    """Return the combinations that the report shows one by one, by their name in the report.

    The combinations are: all choices by default; of those without a penalty, the one nearest to the printed load ratios
    (with a suitable penalty, any ratio results); each penalty of the 3D contacts with all other choices by default; and the
    combination nearest to all six printed numbers. ``found``: results of all combinations, of which the first has all
    choices by default.
    """
    softer = {
        f"penalty of the 3D contacts: {c.readings_in_3d[0].description}": c
        for c in found
        if not c.low_order_readings and any(r.relative_penalty for r in c.readings_in_3d)
    }
    return {
        "all by default": found[0],
        "nearest in the ratio, no penalty": combination_nearest_to_print(combinations_without_penalty(found), 2),
        **softer,
        "nearest in all six": combination_nearest_to_print(found),
    }


def penalty_over_hertz_approach(cache: SceneResultCache, combination: Combination) -> float:
    """Return the approach that a contact penalty adds in Lin's case 1, divided by the Hertz approach, at the mean load.

    ``cache``: caches the results; ``combination``: combination of interpretations that contains the penalty.
    """
    scene = catalogue.scene(CASES[0])
    still, moved = (cache.compute_once(_required_runs_in_3d, r)[0] for r in ((), combination))
    track = scene.track
    lead = np.arctan(track.lead / (2.0 * np.pi * track.pitch_radius))
    added = (
        0.5 * float((moved.centreline[:, 3] - still.centreline[:, 3]).mean()) * np.sin(track.contact_angle) * np.cos(lead)
    )
    load = mean_load(still.load)
    return float(added / (np.mean(hertz_without_errors(scene).C[[0, 3]]) * load ** (2.0 / 3.0)))
