"""Where the answers of a solved scene leave what the models mean, beyond what its result says by itself."""

from __future__ import annotations

from collections.abc import Iterator

from rollbench.comparison.models.answers import LoadAnswers
from rollbench.lowfi.rating.life import rating
from rollbench.lowfi.warned import Warned
from rollbench.meshes.parts import Scene


def outside(scene: Scene, loads: LoadAnswers, preload: float) -> Iterator[Warned]:
    """Static safety below one, and a preload [N] beyond the dynamic load rating."""
    if loads.safety is not None and loads.safety.factor < 1.0:
        factor = f"{loads.safety.factor:.3g}"
        words = "hardened steel keeps a permanent dent, which life and friction do not take into account"
        yield Warned("safety", f"static safety of {factor}, below 1: {words}", f"static safety {factor}, below 1")
    try:
        C = rating(scene)
    except ValueError:  # said with the answers
        return
    if preload > C:
        words = "the preload alone sets the life; catalogues stop at 8 % of the rating"
        text = f"preload of {preload:.4g} N, beyond the dynamic load rating of {C:.4g} N: {words}"
        yield Warned("preload", text, f"preload {preload:.4g} N, above C = {C:.4g} N")
