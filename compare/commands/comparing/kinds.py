"""Which scenes are of rolling balls, and which options those know; imports neither models nor meshes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rollbench.comparison.errors import InputError
from rollbench.comparison.reference.body_names import FINITE, HALF_SPACE
from rollbench.comparison.scenes import catalogue
from rollbench.comparison.scenes.kinds import KindScene


def all_of_friction(names: Sequence[str]) -> bool:
    """Whether all scenes are of kinds that only friction solves. Raises InputError where some are and some are not."""
    kinds = [isinstance(catalogue.any_scene(name), KindScene) for name in names]
    if any(kinds) and not all(kinds):
        raise InputError(
            "command line", "scenes", " ".join(names), "whole screws and bearings, or scenes of friction", "name them apart"
        )
    return bool(kinds) and all(kinds)


def known_bodies(bodies: str, *, rolling: bool) -> str:
    """The name of bodies as it is. Raises InputError for an unknown one, and for half spaces under whole screws."""
    if bodies not in (HALF_SPACE, FINITE):
        raise InputError("command line", "--bodies", bodies, f"{HALF_SPACE} or {FINITE}", "half spaces are the faster ones")
    if bodies != HALF_SPACE and not rolling:
        raise InputError(
            "command line", "--bodies", bodies, "scenes of friction", "the static reference is of finite bodies"
        )
    return bodies


def refuse_options(given: Mapping[str, bool]) -> None:
    """Raises InputError for an option that means nothing to rolling balls; given: whether each was."""
    for option in (name for name, is_given in given.items() if is_given):
        raise InputError(
            "command line",
            option,
            "scenes of friction",
            "whole screws and bearings",
            "leave it out: it would change nothing",
        )
