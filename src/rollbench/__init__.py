"""rollbench as a library.

>>> import rollbench
>>> result = rollbench.solve("lin-case1")
>>> result.loads.shape, result.worst.element
((32, 4), 12)

``read`` a scene, or begin a ``new`` one; ``solve`` it with a low-order model, several ``side_by_side``, its
``load_curve`` and ``friction``; ``compare_models`` with the 3D reference, which ``mesh_study`` computes on several meshes;
``check`` loads against it; ``sweep`` over keys of a scene, ``table`` of its stiffness over them, ``survey`` of a model on
drawn screws; write a ``report``. Results are frozen records in SI units, tables in a notebook, and the JSON of the commands
by ``to_dict()``. ``python -m rollbench`` is the command line.

The folders compare, lowfi, hifi, meshes and reports of the repository are subpackages of this package.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING
from warnings import warn

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
    from rollbench.compare.models.programs import model_command
    from rollbench.compare.models.user_models import ModelAnswer
    from rollbench.compare.report.report import report
    from rollbench.compare.results.comparison import Comparison
    from rollbench.compare.results.data import Ensemble, Friction, MeshStudy, Survey, Sweep
    from rollbench.compare.results.load_curve import LoadCurve
    from rollbench.compare.results.side_by_side import SideBySide
    from rollbench.compare.results.solved import Result, Status
    from rollbench.compare.results.table import Table
    from rollbench.compare.results.verdict import Judgement, Verdict
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
#: Module of each public name that is not in the package ``rollbench.compare.api``.
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
    **dict.fromkeys(("Ensemble", "Friction", "MeshStudy", "Survey", "Sweep"), "rollbench.compare.results.data"),
    **dict.fromkeys(("Result", "Status"), "rollbench.compare.results.solved"),
    **dict.fromkeys(("Judgement", "Verdict"), "rollbench.compare.results.verdict"),
}
#: Former names, and what they are now.
_FORMER = {"Solution": "Result", "Judged": "Verdict"}


def __getattr__(name: str) -> object:
    """Import a public name of the library when it is first used; AttributeError for any other name."""
    if name == "compare":
        return import_module("rollbench.compare")
    if name in _FORMER:
        warn(
            f"rollbench.{name} is rollbench.{_FORMER[name]} now; the former name goes in the next version",
            DeprecationWarning,
            2,
        )
        name = _FORMER[name]
    if name not in __all__:
        raise AttributeError(f"module 'rollbench' has no attribute {name!r}")
    found: object = getattr(import_module(_ELSEWHERE.get(name, "rollbench.compare.api")), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return list(__all__)
