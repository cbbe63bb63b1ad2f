"""The models by name, and how each is run on a scene."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from compare.errors import InputError
from lowfi.result import StaticResult
from meshes.parts import Scene


@dataclass(frozen=True)
class Options:
    """How to run: leave nothing out (``everything``), which specimen of a scene with random errors, which engine."""

    everything: bool = False
    member: int = 0
    engine: str = "auto"
    discretisation: bool = True


def _lin(scene: Scene, options: Options) -> StaticResult:
    from lowfi.static import solve_static

    return solve_static(
        scene,
        everything=options.everything,
        member=options.member,
        engine=options.engine,  # type: ignore[arg-type]
        discretisation=options.discretisation,
    )


def _source(scene: Scene, options: Options) -> StaticResult:
    from lowfi.source import solve_source_result

    if scene.ingredients.screw == "rigid":
        raise InputError(
            scene.name, "ingredients.screw", '"rigid"', '"beam"', "the source's equations are those of a beam: use lin"
        )
    return solve_source_result(scene, everything=options.everything, member=options.member)


def _mei(scene: Scene, options: Options) -> StaticResult:
    from lowfi.mei import solve_mei

    return solve_mei(scene, member=options.member)


def _mei_nut(scene: Scene, options: Options) -> StaticResult:
    from lowfi.mei import solve_mei

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
        Model("lin", "beam screw, rigid nut, Hertz contacts; convex energy (Lin chapter 2, misprints mended)", _lin),
        Model("source", "the same model in the source's own equations, plain Newton from a designer's guess", _source),
        Model("mei", "axial bars and springs of fixed direction, rigid nut (Mei et al. 2003)", _mei),
        Model("mei-nut", "the same with the nut as an elastic bar held at its left face", _mei_nut),
    )
}


def run_model(scene: Scene, name: str = "lin", options: Options | None = None) -> StaticResult:
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
        raise InputError(
            scene.name, "scene", str(error), "a scene the model can describe", "check the geometry and the ingredients"
        ) from error
    return replace(result, model=name)
