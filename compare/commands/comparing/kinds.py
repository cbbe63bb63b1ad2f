"""Which scenes are of rolling balls, and which options those know; imports neither models nor meshes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rollbench.compare.errors import ArgumentError
from rollbench.compare.reference.body_names import FINITE, HALF_SPACE
from rollbench.compare.registration import needed
from rollbench.compare.scenes import catalogue
from rollbench.compare.scenes.kinds import KindScene
from rollbench.compare.system import need_packages


def all_rolling(names: Sequence[str], bodies: str, hook: str, means_nothing: Mapping[str, bool]) -> Any:
    """What a wing does with scenes that are all of kinds that only friction solves; None for whole screws and bearings.

    hook: its name in `registration.HOOKS`; means_nothing: arguments that rolling balls do not know, and whether each was
    given. Raises InputError where some are and some are not, for an unknown name of bodies, for finite bodies under whole
    screws, and for such an option.
    """
    kinds = [isinstance(catalogue.any_scene(name), KindScene) for name in names]
    if any(kinds) and not all(kinds):
        allowed = "whole screws and bearings, or scenes of friction"
        raise ArgumentError("scenes", " ".join(names), allowed, "name them apart")
    if bodies not in (HALF_SPACE, FINITE):
        raise ArgumentError("bodies", bodies, f"{HALF_SPACE} or {FINITE}", "half spaces are the faster ones")
    if not any(kinds):
        if bodies != HALF_SPACE:
            advice = "the static reference is of finite bodies"
            raise ArgumentError("bodies", bodies, "scenes of friction", advice)
        return None
    need_packages("scikit-fem")
    work = needed(hook, "command line", "scenes", " ".join(names))
    for argument in (name for name, given in means_nothing.items() if given):
        advice = "leave it out: it would change nothing"
        raise ArgumentError(argument, "scenes of friction", "whole screws and bearings", advice)
    return work
