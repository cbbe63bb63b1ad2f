"""Which models solve a shaft with several rolling sets, and how they are run."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rollbench.comparison.errors import InputError, Refusal
from rollbench.comparison.models.registry import MODELS
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Scene

if TYPE_CHECKING:
    from rollbench.lowfi.statics.axis.result import AxisResult
    from rollbench.lowfi.statics.static import Engine

#: Models that know several sets on one shaft: the source's and the steps of the ladder to the refined one.
AXIS_MODELS = ("refined", "lin", "lin-cell", "lin-nut")
#: The one that is used unless another is asked for, or inner rings are on housings on springs, which only lin has.
AXIS_DEFAULT = "refined"
#: Why the others do not.
ONE_SET = {
    "lin-source-partition": "it sets the nodes of the beam by the one nut",
    "lin-printed-hertz": 'write hertz = "as printed" under [ingredients], and take the model lin',
    "condensed": "a file of condensed bodies holds those of one set",
    "source": "the source's own equations are those of one nut that stands",
    "mei": "its bars end in one nut that stands",
    "mei-nut": "its bars end in one nut that stands",
}


def random_errors(assembly: Assembly) -> bool:
    """Whether any set has random errors."""
    return any(isinstance(s.parts, Scene) and s.parts.errors.random for s in assembly.sets)


def default_model(assembly: Assembly) -> str:
    """The model of an assembly where none is asked for."""
    sprung = {h.name for h in assembly.housings if h.stiffness is not None}
    sprung |= {name for j in assembly.joints for name in (j.first, j.second)}
    return "lin" if any(s.carrier in sprung for s in assembly.sets) else AXIS_DEFAULT


def run_axis(assembly: Assembly, model: str = "", engine: Engine = "auto", member: int = 0) -> AxisResult:
    """Run a model on an assembly; member: which specimen of its random errors. No loads stand in a result that did not
    converge.

    Raises InputError for a model that knows one set only, or a member of a scene without random errors.
    """
    model = model or default_model(assembly)
    if model not in AXIS_MODELS:
        advice = f"{model} describes one set: {ONE_SET[model]}" if model in MODELS else "see: rollbench list"
        raise InputError(assembly.name, "model", f'"{model}"', ", ".join(AXIS_MODELS), advice)
    if member and not random_errors(assembly):
        raise InputError(assembly.name, "member", str(member), "0", "no set has random errors: leave it out")
    from rollbench.lowfi.compliance.bodies import LADDER
    from rollbench.lowfi.statics.axis.refined import solve_refined
    from rollbench.lowfi.statics.axis.solve import solve_assembly

    try:
        with np.errstate(all="ignore"):
            if model == "lin":
                return solve_assembly(assembly, engine=engine, member=member).answers()
            return solve_refined(assembly, engine=engine, member=member, backend=LADDER[model], name=model).answers()
    except ValueError as error:
        raise Refusal(assembly.name, "scene", str(error), "check the geometry") from error
