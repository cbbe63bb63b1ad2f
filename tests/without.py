"""Runs rollbench as if a Python package were not installed: python -m tests.without PACKAGE WORD..."""

import sys
from importlib import abc, metadata

MODULES = {"scikit-fem": "skfem", "pillow": "PIL"}


class Absent(abc.MetaPathFinder):
    def __init__(self, package):
        self.module = MODULES.get(package, package)

    def find_spec(self, name, *_):
        if name.split(".")[0] == self.module:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)


def hide(package):
    found = metadata.Distribution.from_name

    def from_name(name):
        if name == package:
            raise metadata.PackageNotFoundError(name)
        return found(name)

    sys.meta_path.insert(0, Absent(package))
    metadata.Distribution.from_name = from_name


if __name__ == "__main__":
    hide(sys.argv[1])
    from rollbench.compare.cli import main

    main(sys.argv[2:])
