"""Where the answers of a solved scene leave what the models mean, beyond what its result says by itself."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from rollbench.comparison.models.answers import Answers, LoadAnswers
from rollbench.comparison.models.axis_answers import AxisAnswers
from rollbench.lowfi.rating.life import rating
from rollbench.lowfi.statics.axis.result import AxisResult
from rollbench.lowfi.statics.result import StaticResult
from rollbench.lowfi.warned import Warned
from rollbench.meshes.parts import Scene


def with_answers(scene: Scene, result: StaticResult, found: Answers) -> StaticResult:
    """The result with the warnings that follow from its answers."""
    axial = 0.0 if found.preload is None else found.preload.axial
    return replace(result, warnings=(*result.warnings, *outside(scene, found.loads, axial)))


def with_axis_answers(result: AxisResult, found: AxisAnswers) -> AxisResult:
    """The same of several sets."""
    more = [
        warned.of(s.of.name)
        for s, own in zip(result.sets, found.sets, strict=True)
        if own is not None and isinstance(s.of.parts, Scene)
        for warned in outside(s.of.parts, own.loads, 0.0 if own.preload is None else abs(own.preload[3]))
    ]
    return replace(result, warnings=(*result.warnings, *more))


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
