"""Modelling uncertainty of the 3D reference: the effect of its idealisations and of unprinted dimensions.

Every modelling choice is varied alone on the coarsest level, every choice of the mesh refined alone on the finest, against
the same scene on the same level (``base``). Of several
variants of one choice each contact counts its largest change; choices are independent of one another and have no known
sign, so contact by contact they add by the root of the sum of squares. That sum is an estimate of one typical variation of
every choice, not a bound. What is the scene's own (where the nut is held) or the method's (modes, sockets) is listed, and
is not in it; nor are choices that cannot be varied (``compare.reference.variants.NOT_VARIED``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rollbench.compare.measure import LoadError, error_percent, load_error
from rollbench.compare.models.registry import DEFAULT, Options, run_model
from rollbench.compare.reference.store import Run, load
from rollbench.compare.reference.variants import TWIST, VARIANTS, Kind, twisted
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
