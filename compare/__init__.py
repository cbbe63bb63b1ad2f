"""Scenes, printed numbers, errors, gates and the command line: comparison of models with references."""

import sys
from types import ModuleType
from typing import NoReturn

__version__ = "0.15.0"


class _Package(ModuleType):
    """Module type of ``rollbench.compare``, which was a function of the library up to 0.14."""

    def __call__(self, *_: object, **__: object) -> NoReturn:
        """Raise TypeError, with the present name of the function."""
        raise TypeError("rollbench.compare is a package: the function is rollbench.compare_models")


sys.modules[__name__].__class__ = _Package
