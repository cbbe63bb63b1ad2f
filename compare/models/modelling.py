"""Effect of modelling choices on contact loads: idealisations of the 3D reference, and each step of the model ladder.

The modelling uncertainty of the reference is the effect of its idealisations and of dimensions that the source does not
print. Each choice is varied separately on the coarsest level, each mesh setting refined separately on the finest,
and compared with the same scene on that level (``base``). If a choice has several variants, the largest change of
each contact counts. Choices are independent and of unknown sign, so they add by the root of the sum of squares, contact
by contact. The sum is an estimate of one typical variation of every choice, not a bound. Properties of the scene (where
the nut is fixed) or of the method (modes, sockets) are listed but not included, nor are choices that cannot be varied
(``compare.reference.variants.NOT_VARIED``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from rollbench.compare.measure import LoadError, error_percent, load_error
from rollbench.compare.models.comparison import REFERENCED, finest_bodies
from rollbench.compare.models.model_form import Point, leave_one_out, point, points_of_drawn_screws
from rollbench.compare.models.registry import DEFAULT, MODELS, Options, run_model
from rollbench.compare.models.study import Study
from rollbench.compare.reference.estimate import Reference, uncertainty_percent
from rollbench.compare.reference.store import Run, load_run
from rollbench.compare.reference.variants import TWIST, VARIANTS, Kind, twisted
from rollbench.compare.scenes.catalogue import names_with_role
from rollbench.lowfi.compliance.bodies import PARTS, Condensed
from rollbench.lowfi.statics.elastic import solve_elastic
from rollbench.lowfi.statics.response import forget
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.loads import mean_load
from rollbench.meshes.parts import Scene

#: Scenes on which every choice is varied: one without preload, one with.
VARIED = ("lin-case1", "lin-case3")

#: The preloaded scene of `VARIED`, with load on all flanks, on which each setting of the finest mesh is refined.
REFINED = "lin-case3"

#: By scene name: the varied scene with the same parts, whose effects are used for it.
SPOKEN_FOR = {"lin-case1": "lin-case1", "lin-case2": "lin-case1", "lin-case3": "lin-case3", "lin-case3-offset": "lin-case3"}


@dataclass(frozen=True)
class Effect:
    """Effect of one variant of the 3D reference on the contact loads of one scene."""

    #: Name of the scene.
    scene: str
    #: Name of the variant.
    variant: str
    #: Description of the variant.
    label: str
    #: Modelling choice that it varies.
    choice: str
    #: Kind of the choice.
    kind: Kind
    #: Changes of the contact loads, (n, 4) [% of the mean load].
    change: Array
    #: Largest and root mean square change, with its contact.
    error: LoadError
    #: Change of the ratio of largest to smallest load on SL [%]; nan if one is zero.
    ratio: float


@dataclass(frozen=True)
class Modelling:
    """Modelling uncertainty of a scene's reference, combined from the effects of all choices."""

    #: Name of the scene.
    scene: str
    #: Uncertainty of every contact load, (n, 4) [% of the mean load].
    contacts: Array
    #: Largest of these.
    largest: float
    #: Root mean square over the loaded contacts.
    rms: float
    #: Uncertainty of the ratio of largest to smallest load on SL [%].
    ratio: float
    #: Largest change by choice, sorted by decreasing root mean square.
    choices: dict[str, float]


def base_run(scene: Scene, level: int, stores: Sequence[Path] | None) -> Run | None:
    """Return the baseline run for variants on a level: the scene's run of variant ``base``, else its regular run."""
    return load_run(scene, level, "base", stores) or load_run(scene, level, stores=stores)


def varied(scene: Scene, stores: Sequence[Path] | None = None) -> list[Effect]:
    """Return the effects of all variants of a scene with a converged run in a store.

    The effect of the dropped coupling is computed by the refined model, whose loads respond to a turned shaft like the
    reference's. Empty if no run of a variant is stored.
    """
    out = []
    for name, variant in VARIANTS.items():
        run, against = load_run(scene, variant.level, name, stores), base_run(scene, variant.level, stores)
        if name == "base":  # what the base itself leaves out, against the scene in its group
            against = load_run(scene, variant.level, stores=stores)
        if run is not None and against is not None and run.status == "converged":
            out.append(effect(scene.name, name, variant.label, variant.choice, variant.kind, run.load, against.load))
    if not out:
        return []
    options = Options(discretisation=False)
    straight, turned = (run_model(s, DEFAULT, options).load for s in (scene, twisted(scene)))
    label = "supports turned by the largest twist that is dropped, by the refined model"
    return [*out, effect(scene.name, "coupling", label, TWIST, "modelling", turned, straight)]


def effect(scene: str, variant: str, label: str, choice: str, kind: Kind, changed: Array, base: Array) -> Effect:
    """Compute the effect of a variant from its loads and those of the base run.

    Parameters
    ----------
    scene, variant, label, choice, kind
        As in `Effect`.
    changed
        Contact loads of the variant, (n, 4) [N].
    base
        Contact loads of the base run, (n, 4) [N].
    """
    change = np.asarray(error_percent(changed, base, mean_load(base)))
    with np.errstate(divide="ignore", invalid="ignore"):
        before, after = (float(x[:, 0].max() / x[:, 0].min()) for x in (base, changed))
    ratio = float(error_percent(after, before)) if np.isfinite([before, after]).all() else float("nan")
    return Effect(scene, variant, label, choice, kind, change, load_error(changed, base), ratio)


def combine_effects(scene: Scene, effects: Sequence[Effect]) -> Modelling | None:
    """Return a scene's modelling uncertainty: root sum of squares over all choices; None if none was varied."""
    of_scene = [e for e in effects if e.kind == "modelling" and e.scene == scene.name]
    if all(e.variant == "coupling" for e in of_scene):
        return None
    by_choice: dict[str, list[Effect]] = {}
    for e in of_scene:
        by_choice.setdefault(e.choice, []).append(e)
    worst = {choice: np.abs([e.change for e in group]).max(axis=0) for choice, group in by_choice.items()}
    ratios = {choice: float(np.nanmax(np.abs([e.ratio for e in group]))) for choice, group in by_choice.items()}
    contacts = np.sqrt(sum(x * x for x in worst.values()))
    loaded = contacts > 0.0
    order = sorted(worst, key=lambda c: -float((worst[c] ** 2).mean()))
    return Modelling(
        scene.name,
        contacts,
        float(contacts.max()),
        float(np.sqrt((contacts[loaded] ** 2).mean())),
        float(np.sqrt(np.nansum(np.square(list(ratios.values()))))),
        {c: float(worst[c].max()) for c in order},
    )


def modelling_percent(scene: str, by_scene: Mapping[str, Modelling]) -> float | None:
    """Return the largest modelling uncertainty that applies to a scene [% of the mean load].

    None if no scene with its parts was varied.
    """
    spoken = by_scene.get(SPOKEN_FOR.get(scene, ""))
    return None if spoken is None else spoken.largest


#: Screws and a bearing that were not used while the refined model was developed.
UNSEEN = names_with_role("unseen")

#: Scenes with an uncertainty above 0.3 % on four mesh levels, due to lightly loaded contacts next to heavily loaded ones.
DEEP = ("two-balls", "unseen-25x5")

#: Models of the ladder, from the source's to the refined one.
RUNGS = tuple(sorted((m for m in MODELS.values() if m.ladder_step), key=lambda m: m.ladder_step or (0, "")))


@dataclass(frozen=True)
class Rung:
    """Result of one model of the ladder on one scene, against its reference."""

    #: Name of the scene.
    scene: str
    #: Name of the model.
    model: str
    #: Result of the model.
    result: StaticResult
    #: Errors of the contact loads.
    error: LoadError
    #: Uncertainty of the reference [% of the mean load].
    uncertainty: float | None
    #: Difference of the sum of loads from the reference's [%].
    bias: float
    #: Run time for a new geometry, in plain Python with libraries imported [s].
    seconds: float


def solve_ladder(scene: Scene, reference: Reference, stores: Sequence[Path] | None) -> list[Rung]:
    """Solve a scene with every model of the ladder that its stored data allow."""
    rungs = []
    for model in RUNGS:
        options = Options(discretisation=False, engine="interpreted")
        if model.name == "condensed":
            path = finest_bodies(scene, reference, stores)
            if path is None:
                continue
            options = replace(options, condensed=path)
        forget()
        start = perf_counter()
        result = run_model(scene, model.name, options)
        seconds = perf_counter() - start
        bias = float(error_percent(result.load.sum(), reference.load.sum()))
        rungs.append(
            Rung(
                scene.name,
                model.name,
                result,
                load_error(result.load, reference.load, reference.contacts),
                uncertainty_percent(reference),
                bias,
                seconds,
            )
        )
    return rungs


@dataclass(frozen=True)
class BodyShareErrors:
    """Errors of the refined model on one scene when the bodies of the finest 3D run replace some of its bodies."""

    #: Name of the scene.
    scene: str
    #: Errors of the loads, by the bodies that are taken from 3D: none, one, both.
    errors: dict[tuple[str, ...], LoadError]
    #: Difference of the sum of loads from the reference's [%], by the bodies that are taken from 3D.
    bias: dict[tuple[str, ...], float]


def errors_by_replaced_body(study: Study) -> list[BodyShareErrors]:
    """Compute, by scene, the refined model's errors with neither body, the screw, the nut or both taken from 3D."""
    out = []
    for name, reference in study.references((*REFERENCED, *UNSEEN)).items():
        scene = study.scene(name)
        path = finest_bodies(scene, reference, study.stores)
        if path is None:
            continue
        whole = Condensed.read(path, scene)
        errors: dict[tuple[str, ...], LoadError] = {}
        bias: dict[tuple[str, ...], float] = {}
        every: tuple[tuple[str, ...], ...] = ((), ("screw",), ("nut",), PARTS)
        for parts in every:
            result = solve_elastic(scene, condensed=replace(whole, parts=parts) if parts else None)
            errors[parts] = load_error(result.load, reference.load, reference.contacts)
            bias[parts] = float(error_percent(result.load.sum(), reference.load.sum()))
        out.append(BodyShareErrors(name, errors, bias))
    return out


def ladder(study: Study) -> list[Rung]:
    """Solve every scene with a stored reference by every model of the ladder; the study keeps the results."""
    references = study.references((*REFERENCED, *UNSEEN))
    rungs = [rung for name, ref in references.items() for rung in solve_ladder(study.scene(name), ref, study.stores)]
    for rung in rungs:
        if rung.model != "condensed":  # that one depends on a file too
            study.results[study.scene(rung.scene), rung.model, 0] = rung.result
    return rungs


def points(study: Study, rungs: Sequence[Rung]) -> list[Point]:
    """Return the comparison points (errors of a model on a scene) from which the expected error is estimated."""
    references = study.references((*REFERENCED, *UNSEEN))
    return [point(r.scene, study.scene(r.scene), r.result, references[r.scene].best) for r in rungs]


def left_out_one(study: Study, rungs: Sequence[Rung]) -> list[dict[str, Any]]:
    """Estimate the errors of every compared screw (shipped or drawn) from all others, for each model of the ladder.

    Returns
    -------
    list of dict
        Measured and expected errors of the loads [% of the mean load]; None if the others do not cover the screw.
    """
    everything = [*points(study, rungs), *points_of_drawn_screws()]
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
        for one in leave_one_out(everything, model.name)
    ]
