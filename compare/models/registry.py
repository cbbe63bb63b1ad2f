"""The models by name, and how each is run on a scene."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from compare.errors import InputError, Refusal
from lowfi.statics.result import StaticResult
from meshes.parts import Scene


@dataclass(frozen=True)
class Options:
    """How to run: leave nothing out (``everything``), which specimen of a scene with random errors, which engine;
    ``condensed``: file of condensed bodies for the elastic models; ``estimate``: add the model-form error estimate."""

    everything: bool = False
    member: int = 0
    engine: str = "auto"
    discretisation: bool = True
    condensed: Path | None = None
    estimate: bool = True


def _lin(scene: Scene, options: Options) -> StaticResult:
    from lowfi.statics.static import solve_static

    return solve_static(
        scene,
        everything=options.everything,
        member=options.member,
        engine=options.engine,  # type: ignore[arg-type]
        discretisation=options.discretisation,
    )


def _elastic(scene: Scene, options: Options, *, name: str) -> StaticResult:
    """A model with elastic bodies, by the name of its backend; "condensed" takes them from a file."""
    from lowfi.compliance.bodies import LADDER, REFINED
    from lowfi.compliance.imported import Condensed
    from lowfi.statics.elastic import solve_elastic, with_discretisation

    condensed = None
    if name == "condensed":
        if options.condensed is None:
            raise InputError(
                scene.name,
                "model",
                '"condensed"',
                "a file of condensed bodies",
                "rollbench condense makes one: --condensed FILE",
            )
        try:
            condensed = Condensed.read(options.condensed, scene)
        except OSError as error:
            reason = error.strerror or str(error)
            name_ = str(options.condensed)
            raise InputError(name_, "file", reason, "a file of condensed bodies", "check the path") from None
        except ValueError as error:
            raise InputError(
                str(options.condensed),
                "file",
                str(error),
                "a file that rollbench condense made of this scene's parts",
                "make it anew: rollbench condense",
            ) from None
    own: dict[str, Any] = {
        "backend": LADDER.get(name, REFINED),
        "condensed": condensed,
        "name": name,
        "everything": options.everything,
        "member": options.member,
        "engine": options.engine,
    }
    result = solve_elastic(scene, **own)
    return with_discretisation(scene, result, **own) if options.discretisation else result


def _source(scene: Scene, options: Options) -> StaticResult:
    from lowfi.as_source.static import solve_source_result

    if scene.ingredients.screw == "rigid":
        raise InputError(
            scene.name, "ingredients.screw", '"rigid"', '"beam"', "the source's equations are those of a beam: use lin"
        )
    return solve_source_result(scene, everything=options.everything, member=options.member)


def _mei(scene: Scene, options: Options) -> StaticResult:
    from lowfi.statics.mei import solve_mei

    return solve_mei(scene, member=options.member)


def _mei_nut(scene: Scene, options: Options) -> StaticResult:
    from lowfi.statics.mei import solve_mei

    return solve_mei(scene, member=options.member, elastic_nut=True)


@dataclass(frozen=True)
class Model:
    """A model: what it is in one sentence, and its runner."""

    name: str
    about: str
    run: Callable[[Scene, Options], StaticResult]


MODELS = {
    m.name: m
    for m in (
        Model(
            "refined",
            "elastic grooved screw, nut and balls between Hertz contacts, no 3D solve; the default",
            partial(_elastic, name="refined"),
        ),
        Model("lin", "beam screw, rigid nut, Hertz contacts; convex energy (Lin chapter 2, misprints mended)", _lin),
        Model("lin-cell", "the same with the section of the grooved shaft", partial(_elastic, name="lin-cell")),
        Model("lin-nut", "the same with the nut as a beam too", partial(_elastic, name="lin-nut")),
        Model(
            "condensed",
            "refined, with the bodies of a condensed 3D model read from a file (--condensed FILE)",
            partial(_elastic, name="condensed"),
        ),
        Model("source", "the same model in the source's own equations, plain Newton from a designer's guess", _source),
        Model("mei", "axial bars and springs of fixed direction, rigid nut (Mei et al. 2003)", _mei),
        Model("mei-nut", "the same with the nut as an elastic bar held at its left face", _mei_nut),
    )
}


#: The model that is used unless another one is asked for.
DEFAULT = "refined"


def run_model(scene: Scene, name: str = DEFAULT, options: Options | None = None) -> StaticResult:
    """Run one model on a scene. Raises InputError for an unknown name or a scene that the model cannot describe."""
    if name not in MODELS:
        raise InputError("model", "name", f'"{name}"', ", ".join(MODELS), "see: rollbench list")
    options = options or Options()
    if options.member and not scene.errors.random:
        raise InputError(scene.name, "member", str(options.member), "0", "the scene has no random errors: leave it out")
    try:
        with np.errstate(all="ignore"):
            result = MODELS[name].run(scene, options)
    except ValueError as error:
        raise Refusal(scene.name, "scene", str(error), "check the geometry and the ingredients") from error
    result = replace(result, model=name, member=options.member)
    if options.estimate and result.converged:
        from compare.models.model_form import estimate

        result = replace(result, model_form=estimate(scene, result))
    return result
