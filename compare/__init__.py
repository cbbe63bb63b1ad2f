"""Comparison of models with references: scenes, printed numbers, errors, verdicts, reports, and the command line."""

import sys
from types import ModuleType
from typing import NoReturn

__version__ = "0.16.0"


class _Package(ModuleType):
    """Module type of ``rollbench.compare``; calling the module raises an error.

    Up to version 0.14, ``rollbench.compare`` was a function; the error names its successor ``rollbench.compare_models``.
    """

    def __call__(self, *_: object, **__: object) -> NoReturn:
        """Raise TypeError with the new name of the function."""
        raise TypeError("rollbench.compare is a package: the function is rollbench.compare_models")


sys.modules[__name__].__class__ = _Package
