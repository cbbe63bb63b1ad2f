"""Comparison of models with references: scenes, printed numbers, errors, verdicts, reports, and the command line."""

import sys
from types import ModuleType
from typing import NoReturn

__version__ = "0.15.0"


class _Package(ModuleType):
    """Module type of ``rollbench.compare``; a call of the module raises an error that names the renamed function.

    The function ``rollbench.compare`` existed up to version 0.14.
    """

    def __call__(self, *_: object, **__: object) -> NoReturn:
        """Raise TypeError with the new name of the function."""
        raise TypeError("rollbench.compare is a package: the function is rollbench.compare_models")


sys.modules[__name__].__class__ = _Package
