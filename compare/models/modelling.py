"""Effects of modelling choices on contact loads: in the 3D reference, and in the sequence of low-order models.

The modelling uncertainty of the 3D reference is the effect of its idealisations, and of dimensions that Lin's thesis does
not print. Each choice is varied separately on the coarsest mesh level, and each mesh setting is refined separately on the
finest level. Each varied run is compared with the unchanged scene on the same level (``base``). If a choice has several
variants, the largest change of each contact load counts. The choices are independent and their effects have unknown signs,
so they are combined for each contact by the root of the sum of squares. The result estimates the effect of one typical
variation of every choice and is not a bound. Properties of the scene (where the nut is fixed) or of the method (number of
modes, mesh around the contacts) are listed but not included; choices that cannot be varied are not included either
(``compare.reference.levels.NOT_VARIED``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from rollbench.compare.measure import LoadError, error_percent, load_error, mean_load
from rollbench.compare.models import model_form
from rollbench.compare.models.comparison import REFERENCED, path_of_condensed_bodies
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import DEFAULT, MODELS, run_model
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.reference.estimate import Reference, largest_uncertainty_percent
from rollbench.compare.reference.levels import TWIST, VARIANTS, Kind, with_supports_turned_by_coupling
from rollbench.compare.reference.store import Run, load_stored_run
from rollbench.compare.scenes.catalogue import names_of_scenes_with_role
from rollbench.lowfi.compliance.bodies import PARTS, CondensedCompliance
from rollbench.lowfi.statics.result import StaticResult
from rollbench.lowfi.statics.static import solve_elastic
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import Scene

#: Scenes on which every modelling choice is varied: one without preload, one with preload.
VARIED = ("lin-case1", "lin-case3")

#: Scene on which each setting of the finest mesh is refined separately: the preloaded one, with loads on all flanks.
REFINED = "lin-case3"

#: For each of these scenes: the scene with the same parts on which choices were varied; its effects are used for both.
SPOKEN_FOR = {"lin-case1": "lin-case1", "lin-case2": "lin-case1", "lin-case3": "lin-case3", "lin-case3-offset": "lin-case3"}


@dataclass(frozen=True)
class ModellingChoiceEffect:
    """Effect of one changed modelling choice (such as an idealisation) of the 3D reference on a scene's contact loads."""

    #: Name of the scene.
    scene: str
    #: Name of the variant of the 3D reference in which the choice is changed.
    variant: str
    #: Description of the variant in tables.
    label: str
    #: Name of the modelling choice that the variant changes.
    choice: str
    #: Kind of the choice: "modelling", "numerical" or "scene" (a property of the scene).
    kind: Kind
    #: Changes of the contact loads, (n, 4) [% of the mean load].
    change: Array
    #: Largest change of a contact load and the contact with it, and root mean square change [% of the mean load].
    error: LoadError
    #: Change of the ratio of largest to smallest contact load on the screw's left flank SL [%]; nan if the smallest load is
    #: zero with or without the changed choice.
    ratio: float


@dataclass(frozen=True)
class ModellingUncertainty:
    """Modelling uncertainty of the 3D reference on one scene, from the effects of its modelling choices.

    Modelling choices are idealisations, and dimensions that the scene's publication does not print. Their effects are
    combined as the root of the sum of squares.
    """

    #: Name of the scene.
    scene: str
    #: Modelling uncertainty of every contact load, (n, 4) [% of the mean load].
    contacts: Array
    #: Largest modelling uncertainty of a contact load [% of the mean load].
    largest: float
    #: Root mean square of the modelling uncertainty over the loaded contacts [% of the mean load].
    rms: float
    #: Modelling uncertainty of the ratio of largest to smallest contact load on the screw's left flank SL [%].
    ratio: float
    #: Largest change of a contact load by each choice, by the name of the choice [% of the mean load]; sorted by decreasing
    #: root mean square change over all contacts.
    choices: dict[str, float]


def run_without_changed_choices(scene: Scene, level: int, stores: Sequence[Path] | None) -> Run | None:
    """Return the stored 3D run of a scene on a mesh level without changed modelling choices; None if none is stored.

    Runs with a changed choice are compared with this run. ``stores``: folders with runs; None: the folder included with
    rollbench. The result is the run of the variant ``base`` if one is stored, else the regular run.
    """
    return load_stored_run(scene, level, "base", stores) or load_stored_run(scene, level, stores=stores)


def effects_of_changed_choices(scene: Scene, stores: Sequence[Path] | None = None) -> list[ModellingChoiceEffect]:
    """Return the effects of changed modelling choices of the 3D reference on a scene, from stored runs that converged.

    ``stores``: folders with runs; None: the included one. Outside the part of the shaft that is meshed in 3D, the 3D
    reference neglects that an axial force twists a grooved shaft. The refined model computes the effect of this twist, and
    this effect is added to the list. The list is empty if no run of a variant is stored.
    """
    out = []
    for name, variant in VARIANTS.items():
        run = load_stored_run(scene, variant.level, name, stores)
        against = load_stored_run(scene, variant.level, stores=stores)
        if name != "base":  # the base run itself is compared with the scene's regular run
            against = run_without_changed_choices(scene, variant.level, stores)
        if run is not None and against is not None and run.status == "converged":
            what = (scene.name, name, variant.label, variant.choice, variant.kind)
            out.append(effect_of_changed_choice(*what, run.load, against.load))
    if not out:
        return []
    options = ModelOptions(estimate_beam_mesh_error=False)
    straight, turned = (run_model(s, DEFAULT, options).load for s in (scene, with_supports_turned_by_coupling(scene)))
    label = "supports rotated by the largest twist that the reference neglects, by the refined model"
    return [*out, effect_of_changed_choice(scene.name, "coupling", label, TWIST, "modelling", turned, straight)]


def effect_of_changed_choice(
    scene: str, variant: str, label: str, choice: str, kind: Kind, changed: Array, unchanged: Array
) -> ModellingChoiceEffect:
    """Compute by how much a changed modelling choice of the 3D reference changes the contact loads of a scene.

    Parameters
    ----------
    scene, variant, label, choice, kind
        Fields of the returned `ModellingChoiceEffect`.
    changed
        Contact loads of n balls by the 3D run with the changed choice, (n, 4) [N].
    unchanged
        Contact loads by the unchanged 3D run, (n, 4) [N].

    Returns
    -------
    ModellingChoiceEffect
        Changes of the contact loads, in per cent of the mean load of the unchanged run.
    """
    change = np.asarray(error_percent(changed, unchanged, mean_load(unchanged)))
    with np.errstate(divide="ignore", invalid="ignore"):
        before, after = (float(x[:, 0].max() / x[:, 0].min()) for x in (unchanged, changed))
    ratio = float(error_percent(after, before)) if np.isfinite([before, after]).all() else float("nan")
    return ModellingChoiceEffect(scene, variant, label, choice, kind, change, load_error(changed, unchanged), ratio)


def combined_modelling_uncertainty(scene: Scene, effects: Sequence[ModellingChoiceEffect]) -> ModellingUncertainty | None:
    """Return the modelling uncertainty of the 3D reference on a scene: root of the sum of squares of all effects.

    ``effects``: effects of changed modelling choices; those on other scenes are ignored. None if no choice was varied on
    the scene.
    """
    of_scene = [e for e in effects if e.kind == "modelling" and e.scene == scene.name]
    if all(e.variant == "coupling" for e in of_scene):
        return None
    by_choice: dict[str, list[ModellingChoiceEffect]] = {}
    for e in of_scene:
        by_choice.setdefault(e.choice, []).append(e)
    worst = {choice: np.abs([e.change for e in group]).max(axis=0) for choice, group in by_choice.items()}
    ratios = {choice: float(np.nanmax(np.abs([e.ratio for e in group]))) for choice, group in by_choice.items()}
    contacts = np.sqrt(sum(x * x for x in worst.values()))
    loaded = contacts > 0.0
    order = sorted(worst, key=lambda c: -float((worst[c] ** 2).mean()))
    return ModellingUncertainty(
        scene.name,
        contacts,
        float(contacts.max()),
        float(np.sqrt((contacts[loaded] ** 2).mean())),
        float(np.sqrt(np.nansum(np.square(list(ratios.values()))))),
        {c: float(worst[c].max()) for c in order},
    )


def applicable_modelling_uncertainty(scene: str, by_scene: Mapping[str, ModellingUncertainty]) -> float | None:
    """Return the modelling uncertainty of the 3D reference that applies to the scene named ``scene`` [% of the mean load].

    Choices were varied on some scenes only. Returned is the largest modelling uncertainty of a contact load on that of
    these scenes which has the same parts; None if there is none. ``by_scene``: modelling uncertainty of each scene with
    varied choices, by its name.
    """
    spoken = by_scene.get(SPOKEN_FOR.get(scene, ""))
    return None if spoken is None else spoken.largest


#: Screws and a bearing that were not used while the refined model was developed.
UNSEEN = names_of_scenes_with_role("unseen")

#: Scenes whose 3D reference has an uncertainty above 0.3 % on four mesh levels, because lightly loaded contacts lie next to
#: heavily loaded ones.
DEEP = ("two-balls", "unseen-25x5")

#: Models of the refinement sequence, each of which refines the one before it: from the model of Lin's thesis to the refined
#: model and the model "condensed".
RUNGS = tuple(sorted((m for m in MODELS.values() if m.refinement_step), key=lambda m: m.refinement_step or (0, "")))


@dataclass(frozen=True)
class RefinementStepResult:
    """Result of one model of the refinement sequence (from Lin's to the refined model) on a scene, with its errors."""

    #: Name of the scene.
    scene: str
    #: Name of the model.
    model: str
    #: Result of the model.
    result: StaticResult
    #: Errors of the contact loads against the 3D reference.
    load_error: LoadError
    #: Uncertainty of the most uncertain contact load of the 3D reference [% of the mean load].
    reference_uncertainty: float | None
    #: Relative difference of the sum of the contact loads from that of the 3D reference [%].
    load_sum_difference: float


def solve_refinement_sequence(scene: Scene, ref: Reference, stores: Sequence[Path] | None) -> list[RefinementStepResult]:
    """Solve a scene with every model of the refinement sequence (`RUNGS`), and compare the loads with the 3D reference.

    The model "condensed" is left out if the condensed screw and nut are in none of the folders ``stores``.
    """
    rungs = []
    for model in RUNGS:
        options = ModelOptions(estimate_beam_mesh_error=False)
        if model.name == "condensed":
            path = path_of_condensed_bodies(scene, ref, stores)
            if path is None:
                continue
            options = replace(options, condensed_bodies_file=path)
        result = run_model(scene, model.name, options)
        error, bias = load_error(result.load, ref.load, ref.contacts), error_percent(result.load.sum(), ref.load.sum())
        bar = largest_uncertainty_percent(ref)
        rungs.append(RefinementStepResult(scene.name, model.name, result, error, bar, float(bias)))
    return rungs


@dataclass(frozen=True)
class ErrorsByReplacedBody:
    """Errors of the refined model on one scene when its screw, nut or both have the stiffness of the finest 3D run."""

    #: Name of the scene.
    scene: str
    #: Errors of the contact loads, by the bodies that have the 3D stiffness: (), ("screw",), ("nut",) or both.
    load_errors: dict[tuple[str, ...], LoadError]
    #: Relative difference of the sum of the contact loads from that of the 3D reference [%], by the bodies that have the 3D
    #: stiffness.
    load_sum_difference: dict[tuple[str, ...], float]


def errors_by_replaced_body(cache: SceneResultCache) -> list[ErrorsByReplacedBody]:
    """Compute the errors of the refined model with the 3D stiffness of the screw, of the nut, of both or of none of them.

    All built-in scenes with a stored 3D reference and condensed bodies are solved.
    """
    out = []
    for name, reference in cache.stored_references((*REFERENCED, *UNSEEN)).items():
        scene = cache.built_in_scene(name)
        path = path_of_condensed_bodies(scene, reference, cache.reference_folders)
        if path is None:
            continue
        whole = CondensedCompliance.read_checked(path, scene)
        errors: dict[tuple[str, ...], LoadError] = {}
        bias: dict[tuple[str, ...], float] = {}
        for parts in ((), ("screw",), ("nut",), PARTS):
            result = solve_elastic(scene, condensed=replace(whole, parts=parts) if parts else None)
            errors[parts] = load_error(result.load, reference.load, reference.contacts)
            bias[parts] = float(error_percent(result.load.sum(), reference.load.sum()))
        out.append(ErrorsByReplacedBody(name, errors, bias))
    return out


def solve_refinement_sequence_on_all_scenes(cache: SceneResultCache) -> list[RefinementStepResult]:
    """Solve every scene that has a stored 3D reference with every model of the refinement sequence.

    ``cache``: cache of scenes, results and 3D references, which also keeps the results.
    """
    rungs: list[RefinementStepResult] = []
    for name, ref in cache.stored_references((*REFERENCED, *UNSEEN)).items():
        rungs += solve_refinement_sequence(cache.built_in_scene(name), ref, cache.reference_folders)
    for rung in rungs:
        if rung.model != "condensed":  # its result also depends on a file, which is not part of the key
            cache.static_results[cache.built_in_scene(rung.scene), rung.model] = rung.result
    return rungs


def model_errors_on_built_in_scenes(
    cache: SceneResultCache, sequence_results: Sequence[RefinementStepResult]
) -> list[model_form.MeasuredModelErrors]:
    """Return the errors of the models on the built-in scenes; errors to expect on other scenes are estimated from them.

    ``cache``: cache of scenes and 3D references; ``sequence_results``: result of each model of the refinement sequence on
    each scene.
    """
    references, measure = cache.stored_references((*REFERENCED, *UNSEEN)), model_form.measure_model_error
    return [measure(r.scene, cache.built_in_scene(r.scene), r.result, references[r.scene].best) for r in sequence_results]


def leave_one_out_error_rows(cache: SceneResultCache, rungs: Sequence[RefinementStepResult]) -> list[dict[str, Any]]:
    """Estimate the errors of each model on every compared screw (built-in or random) from its errors on all other screws.

    Parameters
    ----------
    cache
        Cache of scenes and 3D references.
    rungs
        Result of each model of the refinement sequence on each built-in scene.

    Returns
    -------
    list of dict
        For each model and screw, the measured and expected largest error of a contact load (keys ``measured`` and
        ``expected``) and RMS error (``rms`` and ``expected_rms``) [% of the mean load]. Expected errors are None if a screw
        is outside the range of the others.
    """
    everything = [*model_errors_on_built_in_scenes(cache, rungs), *model_form.model_errors_on_random_screws()]
    return [
        {
            "scene": one.point.scene,
            "model": model.name,
            "measured": one.point.percent,
            "expected": None if one.expected is None else one.expected["percent"],
            "rms": one.point.rms_percent,
            "expected_rms": None if one.expected is None else one.expected["rms_percent"],
        }
        for model in RUNGS
        for one in model_form.leave_one_out_errors(everything, model.name)
    ]
