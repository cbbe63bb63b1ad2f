"""The cases: what a publication printed, the scenes, how each number is computed, and its page of the report.

Ours are the folders of ``compare/cases``, named in `CASES`. Another package adds its own by an entry point of the group
``rollbench.cases`` that names its `Case`; it is loaded when printed data are judged.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from importlib import import_module, resources
from pathlib import Path
from typing import Any

from rollbench.compare import data
from rollbench.compare.errors import InputError

GROUP = "rollbench.cases"


@dataclass(frozen=True)
class Part:
    """A section of the report by name: its module, in ``compare`` or in the package of its case; quick: stands in a quick
    report too; runs: shows runs of the 3D reference; meshes: needs gmsh; meshed: what of it needs gmsh, where the rest does
    not; page: on which it stands, named in `commands.reporting.parts`."""

    name: str
    module: str
    quick: bool = False
    runs: bool = False
    meshes: bool = False
    meshed: str = ""
    page: str = "outside"


@dataclass(frozen=True)
class Case:
    """A publication, or several of a kind, that answers are held against.

    The folder of its package holds ``printed/NAME-*.toml`` (numbers and claims with their expected verdicts),
    ``scenes/*.toml``, ``computations.toml`` (how each number is computed), ``misprints.toml``; a case
    has those that it needs.
    """

    #: Names of its tables begin with it and a hyphen.
    name: str
    #: The publication as answers name it; empty where no table is printed.
    title: str
    #: Import name of the package with all of it.
    package: str
    #: Its sections of the report; their modules are named below ``package``.
    parts: tuple[Part, ...] = ()

    @property
    def folder(self) -> Path:
        """Where its files are."""
        return Path(str(resources.files(self.package)))

    def files(self, folder: str) -> dict[str, Path]:
        """Its TOML files in a folder, ``printed`` or ``scenes``, by name without ending."""
        return {path.stem: path for path in sorted(self.folder.joinpath(folder).rglob("*.toml"))}

    def load(self, function: str) -> Any:
        """The object that ``module:name`` names in its package, imported now."""
        module, _, name = function.partition(":")
        return getattr(import_module(f"{self.package}.{module}"), name)


def _ours(name: str, title: str, *parts: Part) -> Case:
    return Case(name, title, f"{__package__}.cases.{name}", parts)


#: Cases of this package, in the order of the report.
CASES = (
    _ours(
        "lin",
        "Lin (2019)",
        Part("hertz", "pages.hertz", page="reference"),
        Part("cases", "pages.cases", quick=True, runs=True, page="cases"),
        Part("reconstruction", "pages.reconstruction", runs=True, page="cases"),
        Part("errors", "pages.errors", page="tolerances"),
        Part("manufacturing", "pages.manufacturing", page="tolerances"),
        Part("steering", "pages.steering", page="friction"),
        Part("friction", "pages.friction", page="friction"),
        Part("friction-screw", "pages.friction_screw", page="friction"),
        Part("formulations", "pages.formulations", page="robustness"),
    ),
    _ours("smith", "Smith (1994)", Part("smith", "page", page="sources")),
    _ours(
        "kalker",
        "Kalker (1990)",
        Part("rolling", "page", meshed="no motion against the static reference, sizes of bodies", page="rolling"),
    ),
    _ours("liu", "Liu et al. (2025)", Part("liu", "page", page="sources")),
    _ours(
        "external",
        "other programs, makers, textbooks",
        Part("external", "page", runs=True, page="outside"),
        Part("holding", "holding", runs=True, page="outside"),
    ),
    _ours("makers", "", Part("outside", "page", page="outside")),
)


@cache
def others() -> tuple[Case, ...]:
    """Cases of other packages, sorted by name. Raises InputError for one that cannot be loaded, is no `Case`, or has the
    name of another."""
    from importlib.metadata import entry_points  # takes longer to import than all of this

    found: dict[str, Case] = {}
    for point in sorted(entry_points(group=GROUP), key=lambda point: point.name):
        place, advice = f"entry point {point.name}", "mend the package that adds it, or uninstall it"
        try:
            one = point.load()
        except Exception as error:
            reason = f"{type(error).__name__}: {error}"
            raise InputError(place, point.value, reason, "a rollbench.compare.case.Case", advice) from error
        if not isinstance(one, Case):
            raise InputError(place, point.value, repr(one), "a rollbench.compare.case.Case", advice)
        if one.name in found or one.name in (case.name for case in CASES):
            raise InputError(place, "name", f'"{one.name}"', "a name that no other case has", advice)
        found[one.name] = one
    return tuple(found.values())


def every_case() -> tuple[Case, ...]:
    """Ours, then those of other packages."""
    return (*CASES, *others())


@cache
def shipped_files(folder: str) -> dict[str, Path]:
    """Shipped TOML files in a folder, ``scenes`` or ``printed``, by name without ending, sorted."""
    files = {path.stem: path for path in data.place(folder).glob("*.toml")}
    for case in CASES:
        files |= case.files(folder)
    return dict(sorted(files.items()))


def file_of(folder: str, name: str) -> Path | None:
    """The file of a scene or printed table by name: ours, or of another package's case; None where there is none."""
    path = shipped_files(folder).get(name)
    return path or next((files[name] for case in others() if name in (files := case.files(folder))), None)


def files_named(name: str, cases: Iterable[Case] = CASES) -> dict[Case, Path]:
    """The files of that name, one a case, of the cases that have one."""
    return {case: path for case in cases if (path := case.folder / name).is_file()}
