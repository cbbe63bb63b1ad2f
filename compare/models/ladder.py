"""The ladder from the source's model to the refined one, rung by rung against the 3D reference."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import Any

from rollbench.compare.measure import LoadError, error_percent, load_error
from rollbench.compare.models.comparison import REFERENCED, finest_bodies
from rollbench.compare.models.model_form import Point, left_out, point, surveyed_points
from rollbench.compare.models.registry import MODELS, Options, run_model
from rollbench.compare.models.study import Study
from rollbench.compare.reference.estimate import Reference, uncertainty_percent
from rollbench.compare.scenes.catalogue import with_role
from rollbench.lowfi.compliance.bodies import PARTS, Condensed
from rollbench.lowfi.statics.elastic import solve_elastic
from rollbench.lowfi.statics.response import forget
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.parts import Scene

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
