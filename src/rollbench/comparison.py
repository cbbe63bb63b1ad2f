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
    """Finds a module below the former name as the one below the present name, not a second copy of it."""

    def find_spec(
        self, name: str, _path: Sequence[str] | None = None, _target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return the spec of a module below the former name."""
        return ModuleSpec(name, self, is_package=True) if name.startswith(f"{_OLD}.") else None

    def exec_module(self, module: ModuleType) -> None:
        """Put the present module in the place of the new one."""
        sys.modules[module.__name__] = import_module(_NEW + module.__name__.removeprefix(_OLD))


warnings.warn(f"{_OLD} is {_NEW} now: change the import; the former name goes in the next version", DeprecationWarning, 2)
sys.meta_path.insert(0, _Renamed())
sys.modules[__name__] = import_module(_NEW)
