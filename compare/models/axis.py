"""Which models solve a shaft with several rolling sets, and how they are run."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rollbench.comparison.errors import InputError, Refusal
from rollbench.comparison.models.registry import DEFAULT, MODELS, Options
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Scene

if TYPE_CHECKING:
    from rollbench.lowfi.statics.axis.result import AxisResult
    from rollbench.lowfi.statics.static import Engine

#: Models that know several sets on one shaft: the source's and the steps of the ladder to the refined one.
AXIS_MODELS = tuple(name for name, model in MODELS.items() if callable(model.axis))


def random_errors(assembly: Assembly) -> bool:
    """Whether any set has random errors."""
    return any(isinstance(s.parts, Scene) and s.parts.errors.random for s in assembly.sets)


def default_model(assembly: Assembly) -> str:
    """The model of an assembly where none is asked for: lin where inner rings are on housings on springs, which only it
    has."""
    sprung = {h.name for h in assembly.housings if h.stiffness is not None}
    sprung |= {name for j in assembly.joints for name in (j.first, j.second)}
    return "lin" if any(s.carrier in sprung for s in assembly.sets) else DEFAULT


def run_axis(assembly: Assembly, model: str = "", engine: Engine = "auto", member: int = 0) -> AxisResult:
    """Run a model on an assembly; member: which specimen of its random errors. No loads stand in a result that did not
    converge.

    Raises InputError for a model that knows one set only, or a member of a scene without random errors.
    """
    model = model or default_model(assembly)
    found = MODELS.get(model)
    if found is None or isinstance(found.axis, str):
        advice = "see: rollbench list" if found is None else f"{model} describes one set: {found.axis}"
        raise InputError(assembly.name, "model", f'"{model}"', ", ".join(AXIS_MODELS), advice)
    if member and not random_errors(assembly):
        raise InputError(assembly.name, "member", str(member), "0", "no set has random errors: leave it out")
    try:
        with np.errstate(all="ignore"):
            return found.axis(assembly, Options(member=member, engine=engine)).answers()
    except ValueError as error:
        raise Refusal(assembly.name, "scene", str(error), "check the geometry") from error
