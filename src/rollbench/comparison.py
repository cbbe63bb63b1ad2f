"""Former name of `rollbench.compare`: its imports still work in this version, with a warning."""

import sys
import warnings
from collections.abc import Sequence
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType

_OLD, _NEW = "rollbench.comparison", "rollbench.compare"


class _Renamed(MetaPathFinder, Loader):
    """Importer that gives the present module for a module below the former name, without a second copy."""

    def find_spec(
        self, name: str, _path: Sequence[str] | None = None, _target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return an import spec for a module below the former name; None for other modules."""
        return ModuleSpec(name, self, is_package=True) if name.startswith(f"{_OLD}.") else None

    def exec_module(self, module: ModuleType) -> None:
        """Replace the module just created by that of the present name in ``sys.modules``."""
        sys.modules[module.__name__] = import_module(_NEW + module.__name__.removeprefix(_OLD))


warnings.warn(f"{_OLD} is {_NEW} now: change the import; the former name goes in the next version", DeprecationWarning, 2)
sys.meta_path.insert(0, _Renamed())
sys.modules[__name__] = import_module(_NEW)
