"""Where the answers of a solved scene leave what the models mean, beyond what its result says by itself."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import overload

from rollbench.comparison.models.answers import Answers, LoadAnswers
from rollbench.comparison.models.axis_answers import AxisAnswers
from rollbench.comparison.models.loading import axial_of
from rollbench.lowfi.rating.life import rating
from rollbench.lowfi.statics.result import AxisResult, Solved, StaticResult
from rollbench.lowfi.warned import Warned
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Scene


@overload
def with_answers(scene: Scene, result: StaticResult, found: Answers) -> StaticResult: ...
@overload
def with_answers(scene: Assembly, result: AxisResult, found: AxisAnswers) -> AxisResult: ...
def with_answers(scene: Scene | Assembly, result: Solved, found: Answers | AxisAnswers) -> Solved:
    """The result with the warnings that follow from its answers, those of several sets with their names."""
    if isinstance(found, AxisAnswers):
        warned = [w.of(x.name) for x in found.sets if x is not None for w in outside(x.parts, x.loads, axial_of(x.preload))]
    else:
        warned = [*outside(scene, found.loads, axial_of(found.preload))] if isinstance(scene, Scene) else []
    return replace(result, warnings=(*result.warnings, *warned))


def outside(scene: Scene, loads: LoadAnswers, preload: float) -> Iterator[Warned]:
    """Static safety below one, and a preload [N] beyond the dynamic load rating."""
    if loads.safety is not None and loads.safety.factor < 1.0:
        factor = f"{loads.safety.factor:.3g}"
        words = "hardened steel keeps a lasting dent, of which neither life nor friction knows"
        yield Warned("safety", f"static safety of {factor}, below 1: {words}", f"static safety {factor}, below 1")
    try:
        C = rating(scene)
    except ValueError:  # said with the answers
        return
    if preload > C:
        words = "the life is that of the preload, and catalogues stop at 8 % of it"
        text = f"preload of {preload:.4g} N, beyond the dynamic load rating of {C:.4g} N: {words}"
        yield Warned("preload", text, f"preload {preload:.4g} N, above C = {C:.4g} N")
