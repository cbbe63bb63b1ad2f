"""What modelling choices change: idealisations of the 3D reference one by one, and each rung of the ladder from the
source's model to the refined one.

Modelling uncertainty of the reference is the effect of its idealisations and of unprinted dimensions.
Every modelling choice is varied alone on the coarsest level, every choice of the mesh refined alone on the finest, against
the same scene on the same level (``base``). Of several
variants of one choice each contact counts its largest change; choices are independent of one another and have no known
sign, so contact by contact they add by the root of the sum of squares. That sum is an estimate of one typical variation of
every choice, not a bound. What is the scene's own (where the nut is held) or the method's (modes, sockets) is listed, and
is not in it; nor are choices that cannot be varied (``compare.reference.variants.NOT_VARIED``).
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
from rollbench.compare.models.model_form import Point, left_out, point, surveyed_points
from rollbench.compare.models.registry import DEFAULT, MODELS, Options, run_model
from rollbench.compare.models.study import Study
from rollbench.compare.reference.estimate import Reference, uncertainty_percent
from rollbench.compare.reference.store import Run, load
from rollbench.compare.reference.variants import TWIST, VARIANTS, Kind, twisted
from rollbench.compare.scenes.catalogue import with_role
from rollbench.lowfi.compliance.bodies import PARTS, Condensed
from rollbench.lowfi.statics.elastic import solve_elastic
from rollbench.lowfi.statics.response import forget
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.loads import mean_load
from rollbench.meshes.parts import Scene

#: Scenes on which every choice is varied: one without preload, one with.
VARIED = ("lin-case1", "lin-case3")

#: The one of them, preloaded, with all four flanks, on which every choice of the finest mesh is refined alone.
REFINED = "lin-case3"

#: The varied scene that speaks for others of the same parts.
SPOKEN_FOR = {"lin-case1": "lin-case1", "lin-case2": "lin-case1", "lin-case3": "lin-case3", "lin-case3-offset": "lin-case3"}


@dataclass(frozen=True)
class Effect:
    """One variant on one scene: changes of the contact loads ``(n, 4)`` [% of the mean load], their largest and RMS with
    the place, and the change of largest : smallest load on SL [%] (nan where one is zero)."""

    scene: str
    variant: str
    label: str
    choice: str
    kind: Kind
    change: Array
    error: LoadError
    ratio: float


@dataclass(frozen=True)
class Modelling:
    """Modelling uncertainty of a scene: of every contact's load ``(n, 4)`` [% of the mean load], its largest and RMS over
    the loaded contacts, and of largest : smallest load on SL [%]; the choices in it, by falling RMS, with their largest
    changes."""

    scene: str
    contacts: Array
    largest: float
    rms: float
    ratio: float
    choices: dict[str, float]


def base_run(scene: Scene, level: int, stores: Sequence[Path] | None) -> Run | None:
    """What variants of a level are compared with: the scene alone, or else in its group."""
    return load(scene, level, "base", stores) or load(scene, level, stores=stores)


def varied(scene: Scene, stores: Sequence[Path] | None = None) -> list[Effect]:
    """Effects of all variants of a scene that a store holds converged; the dropped coupling by the refined model, whose
    loads answer a turned shaft as the reference's do. Empty without any run."""
    out = []
    for name, variant in VARIANTS.items():
        run, against = load(scene, variant.level, name, stores), base_run(scene, variant.level, stores)
        if name == "base":  # what the base itself leaves out, against the scene in its group
            against = load(scene, variant.level, stores=stores)
        if run is not None and against is not None and run.status == "converged":
            out.append(effect(scene.name, name, variant.label, variant.choice, variant.kind, run.load, against.load))
    if not out:
        return []
    options = Options(discretisation=False)
    straight, turned = (run_model(s, DEFAULT, options).load for s in (scene, twisted(scene)))
    label = "supports turned by the largest twist that is dropped, by the refined model"
    return [*out, effect(scene.name, "coupling", label, TWIST, "modelling", turned, straight)]


def effect(scene: str, variant: str, label: str, choice: str, kind: Kind, changed: Array, base: Array) -> Effect:
    """The effect of loads ``changed`` (n, 4) against ``base`` (n, 4) [N]."""
    change = np.asarray(error_percent(changed, base, mean_load(base)))
    with np.errstate(divide="ignore", invalid="ignore"):
        before, after = (float(x[:, 0].max() / x[:, 0].min()) for x in (base, changed))
    ratio = float(error_percent(after, before)) if np.isfinite([before, after]).all() else float("nan")
    return Effect(scene, variant, label, choice, kind, change, load_error(changed, base), ratio)


def combined(scene: Scene, effects: Sequence[Effect]) -> Modelling | None:
    """Root of squares over the choices of a scene's effects; None where nothing was varied in 3D."""
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
    """Largest modelling uncertainty [% of the mean load] that speaks for a scene; None where its parts were not varied."""
    spoken = by_scene.get(SPOKEN_FOR.get(scene, ""))
    return None if spoken is None else spoken.largest


#: Screws and a bearing that were not used while the refined model was developed.
UNSEEN = with_role("unseen")

#: Scenes that four mesh levels leave with an uncertainty above 0.3 %, by lightly loaded contacts beside heavy ones.
DEEP = ("two-balls", "unseen-25x5")

#: Models on the ladder, from the source's upwards.
RUNGS = tuple(sorted((m for m in MODELS.values() if m.ladder_step), key=lambda m: m.ladder_step or (0, "")))


@dataclass(frozen=True)
class Rung:
    """One model on one scene against its reference: errors, the reference's uncertainty in per cent of the mean load,
    seconds of the solve of a geometry that is new (libraries loaded, interpreted), sum of loads against the reference's
    [%]."""

    scene: str
    model: str
    result: StaticResult
    error: LoadError
    uncertainty: float | None
    bias: float
    seconds: float


def climb(scene: Scene, reference: Reference, stores: Sequence[Path] | None) -> list[Rung]:
    """Every rung that a scene's stored data allow."""
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
class Share:
    """Error of the refined model on one scene with the bodies named taken from the finest 3D run, the low-order ones for
    the rest: none of them, one, both."""

    scene: str
    errors: dict[tuple[str, ...], LoadError]
    bias: dict[tuple[str, ...], float]


def shares(study: Study) -> list[Share]:
    """Which body's idealisation the refined model's error is, on every scene whose condensed bodies are stored."""
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
        out.append(Share(name, errors, bias))
    return out


def ladder(study: Study) -> list[Rung]:
    """Every rung of every scene that has a stored reference; the study keeps the results."""
    references = study.references((*REFERENCED, *UNSEEN))
    rungs = [rung for name, ref in references.items() for rung in climb(study.scene(name), ref, study.stores)]
    for rung in rungs:
        if rung.model != "condensed":  # that one depends on a file too
            study.results[study.scene(rung.scene), rung.model, 0] = rung.result
    return rungs


def points(study: Study, rungs: Sequence[Rung]) -> list[Point]:
    """What the model-form estimate rests on."""
    references = study.references((*REFERENCED, *UNSEEN))
    return [point(r.scene, study.scene(r.scene), r.result, references[r.scene].best) for r in rungs]


def left_out_one(study: Study, rungs: Sequence[Rung]) -> list[dict[str, Any]]:
    """Every compared screw judged by the others, drawn ones of the survey among them: errors of its loads that were
    measured and that were to be expected [% of the mean load]; None where the others do not cover it."""
    everything = [*points(study, rungs), *surveyed_points()]
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
        for one in left_out(everything, model.name)
    ]
