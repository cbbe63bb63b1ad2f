"""rollbench as a library.

>>> import rollbench
>>> solution = rollbench.solve("lin-case1")
>>> solution.load.shape, solution["summary.loads.worst_ball"]
((32, 4), 12)

``read`` a scene, ``solve`` it with a low-order model, its ``friction``; ``compare_models`` with the 3D reference, which
``mesh_study`` computes on several meshes; ``check`` loads against it; ``sweep`` over keys of a scene; write a ``report``.
Results show as tables in a notebook; ``solution["summary.axial.displacement_um"]`` is a number,
``solution.quantity("summary.axial.displacement_um")`` the same with its unit. ``python -m rollbench`` is the command line.

The folders compare, lowfi, hifi, meshes and reports of the repository are packages of these names in here.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rollbench.compare import __version__
    from rollbench.compare.api import (
        Friction,
        Judged,
        Result,
        Solution,
        check,
        compare_models,
        friction,
        mesh_study,
        read,
        report,
        solve,
        sweep,
    )
    from rollbench.compare.errors import InputError

__all__ = [
    "Friction",
    "InputError",
    "Judged",
    "Result",
    "Solution",
    "__version__",
    "check",
    "compare_models",
    "friction",
    "mesh_study",
    "read",
    "report",
    "solve",
    "sweep",
]
#: Where a name of the library stands, if not in the package ``rollbench.compare.api``.
_ELSEWHERE = {"InputError": "rollbench.compare.errors", "__version__": "rollbench.compare"}


def __getattr__(name: str) -> object:
    """A name of the library, loaded when it is first used; AttributeError for others."""
    if name == "compare":
        return import_module("rollbench.compare")
    if name not in __all__:
        raise AttributeError(f"module 'rollbench' has no attribute {name!r}")
    found: object = getattr(import_module(_ELSEWHERE.get(name, "rollbench.compare.api")), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return list(__all__)
