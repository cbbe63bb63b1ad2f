"""Former name of the package `rollbench.compare`; imports from it still work in this version, with a warning."""

import sys
import warnings
from collections.abc import Sequence
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType

#: Former and present name of the package.
_OLD, _NEW = "rollbench.comparison", "rollbench.compare"


class _FormerModuleImporter(MetaPathFinder, Loader):
    """Importer that gives modules of `rollbench.compare` for imports by its former name ``rollbench.comparison``."""

    def find_spec(
        self, name: str, _path: Sequence[str] | None = None, _target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return an import specification for a module inside ``rollbench.comparison``; None for other modules."""
        return ModuleSpec(name, self, is_package=True) if name.startswith(f"{_OLD}.") else None

    def exec_module(self, module: ModuleType) -> None:
        """Replace ``module``, of ``rollbench.comparison``, in ``sys.modules`` by its namesake in `rollbench.compare`."""
        sys.modules[module.__name__] = import_module(_NEW + module.__name__.removeprefix(_OLD))


warnings.warn(f"{_OLD} will be removed in the next version: import {_NEW} instead", DeprecationWarning, 2)
sys.meta_path.insert(0, _FormerModuleImporter())
sys.modules[__name__] = import_module(_NEW)
