"""Which models solve a shaft with several rolling sets, and how they are run."""

from __future__ import annotations

import numpy as np

from compare.errors import InputError, Refusal
from compare.models.registry import MODELS
from lowfi.statics.axis.refined import solve_refined
from lowfi.statics.axis.result import AxisResult
from lowfi.statics.axis.solve import solve_assembly
from lowfi.statics.static import Engine
from meshes.axis import Assembly, RollerRow

#: Models that know several sets on one shaft.
AXIS_MODELS = ("refined", "lin")
#: The one that is used unless another is asked for, or rollers or inner rings on housings are there, which only lin has.
AXIS_DEFAULT = "refined"


def run_axis(assembly: Assembly, model: str = "", engine: Engine = "auto") -> AxisResult:
    """Run a model on an assembly. Raises InputError for a model that knows one set only."""
    rollers = any(isinstance(s.parts, RollerRow) or s.carrier is not None for s in assembly.sets)
    model = model or ("lin" if rollers else AXIS_DEFAULT)
    if model not in AXIS_MODELS:
        advice = "the other models describe one set on a shaft" if model in MODELS else "see: rollbench list"
        raise InputError(assembly.name, "model", f'"{model}"', ", ".join(AXIS_MODELS), advice)
    try:
        with np.errstate(all="ignore"):
            solve = solve_assembly if model == "lin" else solve_refined
            return solve(assembly, engine=engine)
    except ValueError as error:
        raise Refusal(assembly.name, "scene", str(error), "check the geometry") from error
