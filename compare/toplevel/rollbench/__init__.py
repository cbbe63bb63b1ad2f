"""rollbench as a library.

>>> import rollbench
>>> solution = rollbench.solve("lin-case1")
>>> solution.load.shape, solution["summary.loads.worst_ball"]
((32, 4), 12)

``read`` a scene, ``solve`` it with a low-order model, its ``friction``; ``compare`` models with the 3D reference; ``check``
loads against it. Results show as tables in a notebook; ``solution["summary.axial.displacement_um"]`` is a number,
``solution.quantity("summary.axial.displacement_um")`` the same with its unit. ``python -m rollbench`` is the command line.

The program's packages are called lowfi, hifi, meshes, compare and reports. They are loaded here from beside this file, so
that a file of one of these names in the working folder is not taken for them.
"""

from __future__ import annotations

import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

_PACKAGES = ("meshes", "lowfi", "hifi", "reports", "compare")


def _load_packages() -> None:
    """Load the packages from the folder that this file belongs to, wherever Python would look first.

    Raises ImportError where another module of such a name is loaded already.
    """
    here = Path(__file__).resolve()
    root = next(folder for folder in here.parents[1:] if (folder / "compare" / "errors.py").exists())
    for name in _PACKAGES:
        start = root / name / "__init__.py"
        if name in sys.modules:
            found = sys.modules[name].__file__
            if found is None or Path(found).resolve() != start:
                raise ImportError(f"rollbench needs its own package {name!r}, but {found} is loaded: rename that file")
            continue
        spec = spec_from_file_location(name, start, submodule_search_locations=[str(start.parent)])
        if spec is None or spec.loader is None:
            raise ImportError(f"rollbench: {start} cannot be loaded")
        sys.modules[name] = module = module_from_spec(spec)
        spec.loader.exec_module(module)


_load_packages()

from compare import __version__  # noqa: E402 - from the packages loaded above
from compare.api import Friction, Judged, Result, Solution, check, compare, friction, read, solve  # noqa: E402
from compare.errors import InputError  # noqa: E402

__all__ = [
    "Friction",
    "InputError",
    "Judged",
    "Result",
    "Solution",
    "__version__",
    "check",
    "compare",
    "friction",
    "read",
    "solve",
]
