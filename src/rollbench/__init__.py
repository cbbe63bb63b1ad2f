"""Python library of rollbench: finite-element validation of models for ball screws and rolling bearings.

>>> import rollbench
>>> result = rollbench.solve("lin-case1")
>>> result.loads.shape, result.worst.element
((32, 4), 12)

``read`` reads a scene, and ``new`` makes one. ``solve`` solves a scene with a low-order model, ``side_by_side`` compares
several scenes, ``load_curve`` solves a range of loads, and ``friction`` computes torque and efficiency. ``compare_models``
compares models with the 3D reference, and ``mesh_study`` solves this reference on several meshes. ``check`` judges contact
loads against it. ``ensemble`` solves many specimens with random geometric errors. ``sweep`` and ``table`` vary parameters
of a scene, ``survey`` compares a model with the 3D reference on randomly drawn screws, and ``report`` writes a report.
Results are immutable records in SI units. Notebooks show them as tables, and ``to_dict()`` gives the JSON that the commands
print. ``python -m rollbench`` is the command line.

The folders compare, lowfi, hifi, meshes and reports of the repository are subpackages of this package.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rollbench.compare import __version__
    from rollbench.compare.api import (
        check,
        compare_models,
        ensemble,
        friction,
        load_curve,
        mesh_study,
        new,
        read,
        side_by_side,
        solve,
        survey,
        sweep,
        table,
    )
    from rollbench.compare.errors import InputError
    from rollbench.compare.gate.verdict import Judgement
    from rollbench.compare.models.programs import model_command
    from rollbench.compare.models.user_models import ModelAnswer
    from rollbench.compare.report.report import report
    from rollbench.compare.results.comparison import Comparison
    from rollbench.compare.results.data import Ensemble
    from rollbench.compare.results.friction import Friction
    from rollbench.compare.results.load_curve import LoadCurve
    from rollbench.compare.results.mesh_study import MeshStudy
    from rollbench.compare.results.side_by_side import SideBySide
    from rollbench.compare.results.solved import Result, Status
    from rollbench.compare.results.table import Table
    from rollbench.compare.results.verdict import Verdict
    from rollbench.compare.studies.survey_models import Survey
    from rollbench.compare.studies.sweep.run import Sweep
    from rollbench.meshes.parts import Scene

__all__ = [
    "Comparison",
    "Ensemble",
    "Friction",
    "InputError",
    "Judgement",
    "LoadCurve",
    "MeshStudy",
    "ModelAnswer",
    "Result",
    "Scene",
    "SideBySide",
    "Status",
    "Survey",
    "Sweep",
    "Table",
    "Verdict",
    "__version__",
    "check",
    "compare_models",
    "ensemble",
    "friction",
    "load_curve",
    "mesh_study",
    "model_command",
    "new",
    "read",
    "report",
    "side_by_side",
    "solve",
    "survey",
    "sweep",
    "table",
]
#: Modules of those public names that are not in the package ``rollbench.compare.api``.
_ELSEWHERE = {
    "InputError": "rollbench.compare.errors",
    "Comparison": "rollbench.compare.results.comparison",
    "LoadCurve": "rollbench.compare.results.load_curve",
    "ModelAnswer": "rollbench.compare.models.user_models",
    "Scene": "rollbench.meshes.parts",
    "Table": "rollbench.compare.results.table",
    "model_command": "rollbench.compare.models.programs",
    "SideBySide": "rollbench.compare.results.side_by_side",
    "report": "rollbench.compare.report.report",
    "__version__": "rollbench.compare",
    "Ensemble": "rollbench.compare.results.data",
    "Friction": "rollbench.compare.results.friction",
    "MeshStudy": "rollbench.compare.results.mesh_study",
    "Survey": "rollbench.compare.studies.survey_models",
    "Sweep": "rollbench.compare.studies.sweep.run",
    **dict.fromkeys(("Result", "Status"), "rollbench.compare.results.solved"),
    "Judgement": "rollbench.compare.gate.verdict",
    "Verdict": "rollbench.compare.results.verdict",
}


def __getattr__(name: str) -> object:
    """Import a public name of the library when it is first used; AttributeError for any other name."""
    if name == "compare":
        return import_module("rollbench.compare")
    if name not in __all__:
        raise AttributeError(f"module 'rollbench' has no attribute {name!r}")
    found: object = getattr(import_module(_ELSEWHERE.get(name, "rollbench.compare.api")), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    """Return all public names, also those that are not imported yet."""
    return list(__all__)
