"""Studies of the report, stored like runs of the 3D reference and found again while nothing that moves them changed.

A study is a section of the report, or a printed table with the values computed for it. A stored value holds for a digest
of what moves it: the syntax trees of the modules that compute it and of all modules of the package that these import, the
scenes and the printed numbers of publications, and the stored runs of the 3D reference. Comments and docstrings are no part
of it. The versions of NumPy and SciPy stand beside the value and are not part of it either. Measured run times move only
studies that show them. A report recomputes some of the values that it found, which its date draws, and states how far they
agree.
"""

from __future__ import annotations

import ast
import hashlib
import json
import re
import tomllib
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from decimal import Decimal
from functools import cache
from importlib.util import find_spec
from math import isnan
from pathlib import Path
from random import Random
from typing import Any, Protocol, TypeVar

import numpy as np

from rollbench.compare.case import shipped_toml_files
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.running import package_versions, show_progress_message
from rollbench.meshes.cache import record_from_bytes, record_to_bytes
from rollbench.meshes.files import temporary_path

T = TypeVar("T")

#: Folder of stored studies, within a folder of stored runs; file there with the syntax digests of the modules.
FOLDER, MODULES = "studies", "modules.json"
#: Processor time [s] of the found studies, 20 or more, that a report recomputes: as it was when they were stored.
RECOMPUTED = 40.0
#: Files of measured run times, within a folder of stored runs.
TIMES = ("run_times.json", "survey-times.json")
#: Difference of two numbers, over the larger one, that is round-off; and magnitude below which a number counts as zero.
ROUND_OFF, NOTHING = 1e-6, 1e-9
#: A number in a text.
NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e[+-]?\d+)?")


@dataclass(frozen=True)
class Study:
    """How the value of a study is computed."""

    #: Name of the study, which is that of its file.
    name: str
    #: Names of the modules that compute it.
    modules: tuple[str, ...]
    #: Function of the report's cache that computes it.
    compute: Callable[[Any], Any]
    #: Whether it shows measured run times.
    shows_run_times: bool = False


@dataclass(frozen=True)
class StoredStudy:
    """Value of a study, with what is needed to find it again."""

    #: Name of the study, which is that of its file.
    name: str
    #: Digest of what moves the value.
    digest: str
    #: The value.
    value: Any
    #: Processor time [s] in which it was computed, and versions of NumPy and SciPy with which it was.
    seconds: float
    versions: str
    #: Names of the shipped scenes that it used.
    scenes: tuple[str, ...]


@dataclass(frozen=True)
class Recomputed:
    """A stored study that was computed again."""

    #: Name of the study.
    name: str
    #: Largest difference between a stored and a recomputed number, over the larger of the two; infinite where a text or
    #: the number of values differs.
    difference: float
    #: Versions of NumPy and SciPy with which the stored value was computed.
    versions: str


class StudyCache(Protocol):
    """Cache of a report with which studies are computed (`compare.models.study.SceneResultCache`)."""

    def record_used_scenes(self, names: Iterable[str]) -> None:
        """Record that results depend on the shipped scenes ``names``."""

    def value_with_scenes_and_seconds(self, compute: Callable[[Any], T]) -> tuple[T, frozenset[str], float]:
        """Return the value of ``compute(self)``, the shipped scenes on which it depends, and its processor time [s]."""


# --- what moves a study


def syntax_text(node: Any) -> str:
    """Return a syntax tree as text, without docstrings, comments and places; the same for every version of Python."""
    if isinstance(node, list):
        return f"[{','.join(map(syntax_text, node))}]"
    if not isinstance(node, ast.AST):
        return repr(node)
    if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
        node.body = [x for x in node.body if not _is_text(x)]
    parts = ((name, value) for name, value in ast.iter_fields(node) if value is not None and value != [])
    return f"{type(node).__name__}({','.join(f'{name}={syntax_text(value)}' for name, value in parts)})"


def _is_text(statement: ast.stmt) -> bool:
    value = statement.value if isinstance(statement, ast.Expr) else None
    return isinstance(value, ast.Constant) and isinstance(value.value, str)


def imported_names(tree: ast.AST) -> Iterator[str]:
    """Yield the names of modules that a syntax tree may import; what it imports from a module may be one, too."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


@cache
def source_path(module: str) -> Path | None:
    """Return the file of a module of the package or of another case's package; None if there is no such module."""
    try:
        spec = find_spec(module)
    except ModuleNotFoundError:
        return None
    return Path(spec.origin) if spec is not None and spec.origin else None


@cache
def syntax_and_imports(module: str, content: bytes) -> tuple[str, list[str]]:
    """Return the digest of a module's syntax tree, and the names of the modules of its package that it imports."""
    tree, packages = ast.parse(content), ("rollbench", module.split(".")[0])
    near = {x for x in imported_names(tree) if x.split(".")[0] in packages and source_path(x)}
    return hashlib.sha256(syntax_text(tree).encode()).hexdigest()[:16], sorted(near)


class Sources:
    """Syntax digests of modules; a module whose file is as it was when its digest was stored is not parsed again."""

    def __init__(self, files: Sequence[Path]) -> None:
        """Read the stored digests from those of the ``files`` that exist; the first one counts most."""
        #: For each module: digests of its file and of its syntax tree, and the modules of the same package it imports.
        self.modules: dict[str, tuple[str, str, list[str]]] = {}
        for file in filter(Path.is_file, reversed(files)):
            self.modules |= {name: tuple(x) for name, x in json.loads(file.read_text("utf-8")).items()}
        self._checked: set[str] = set()

    def of_module(self, module: str, path: Path) -> tuple[str, list[str]]:
        """Return the digest of a module's syntax tree, and the names of the modules of its package that it imports."""
        if module not in self._checked:
            content = path.read_bytes()
            own = hashlib.sha256(content).hexdigest()[:16]
            if self.modules.get(module, ("",))[0] != own:
                self.modules[module] = own, *syntax_and_imports(module, content)
            self._checked.add(module)
        return self.modules[module][1:]

    def digest(self, modules: Iterable[str]) -> str:
        """Return a digest of the syntax trees of modules and of all modules of their packages that they import."""
        left, trees = list(modules), dict[str, str]()
        while left:
            name = left.pop()
            if name not in trees and (path := source_path(name)) is not None:
                trees[name], near = self.of_module(name, path)
                left += near
        return hashlib.sha256(json.dumps(sorted(trees.items())).encode()).hexdigest()


@cache
def digest_of_inputs() -> str:
    """Return a digest of all data of the package, as values: a comment in their files does not count.

    These are scenes, printed numbers, campaigns, results of other programs and columns of tables, but not the stored runs
    (`digest_of_runs`) and the schema of scene files, which follows from the code.
    """
    package = Path(__file__).parents[1]
    values = dict[str, Any]()
    for path in (*package.rglob("*.toml"), *package.rglob("*.json"), *package.with_name("reports").glob("*.toml")):
        name = path.relative_to(package.parent).as_posix()
        if not path.is_relative_to(shipped_store()) and path.name != "scene.schema.json":
            values[name] = (tomllib.loads if path.suffix == ".toml" else json.loads)(path.read_text("utf-8"))
    return hashlib.sha256(json.dumps(values, default=str, sort_keys=True).encode()).hexdigest()


def digest_of_runs(folders: Sequence[Path]) -> str:
    """Return a digest of the shipped tables of results and of the runs of the 3D reference in ``folders``, by their names.

    The name of a run contains the digest of its inputs. Runs of scenes that are not shipped do not count, and neither do
    measured run times and what a report derives from the runs and keeps beside them.
    """
    shipped = set(shipped_store().glob("*-level*.json"))
    tables = sorted(path for path in set(shipped_store().glob("*.json")) - shipped if path.name not in TIMES)
    runs = {path.name for folder in folders for path in folder.glob("*-level*.json")}
    known = {scene_of_run(path.name) for path in shipped} | set(shipped_toml_files("scenes"))
    counted = sorted(name for name in runs if scene_of_run(name) in known)
    return hashlib.sha256(json.dumps(counted).encode() + b"".join(path.read_bytes() for path in tables)).hexdigest()


def digest_of_run_times(folders: Sequence[Path]) -> str:
    """Return a digest of the measured run times that a report shows: of each file the first one in ``folders``."""
    found = (next(filter(Path.is_file, (folder / name for folder in folders)), None) for name in TIMES)
    return hashlib.sha256(b"".join(path.read_bytes() for path in found if path is not None)).hexdigest()


def scene_of_run(file_name: str) -> str:
    """Return the name of the scene of a stored run.

    Examples
    --------
    >>> scene_of_run("lin-case1-level2-8648d5aa9d79e740.json")
    'lin-case1'
    """
    return file_name.rpartition("-level")[0]


# --- stored values


@dataclass
class StoredStudies:
    """Stored values of studies, and those that a report has used."""

    #: Folders of runs with their studies, in order of search; without a folder, all values are computed.
    folders: Sequence[Path]
    #: Folder of runs to which new values are written; None: they are not stored.
    written_to: Path | None
    #: Names of studies that are computed and compared with their stored values.
    compared: Sequence[str] = ()
    #: Processor time [s] of each study found in a folder, by name.
    found: dict[str, float] = field(default_factory=dict)
    #: Found studies that were computed again.
    recomputed: list[Recomputed] = field(default_factory=list)
    _sources: Sources = field(init=False)
    _runs: str = field(init=False)

    def __post_init__(self) -> None:
        """Read the digests of the modules and of the runs."""
        self._sources = Sources([folder / FOLDER / MODULES for folder in (*self.folders, shipped_store())])
        self.read_runs()

    def read_runs(self) -> None:
        """Read the digest of the runs, which may have changed."""
        self._runs = digest_of_runs(self.folders)

    def value(self, cache: StudyCache, study: Study) -> Any:
        """Return the value of a study that is stored, or else compute and store it.

        ``cache``: cache of the report, with which it is computed and in which its scenes are recorded.
        """
        known = self.stored(study)
        if known is None or study.name in self.compared:
            value, scenes, spent = cache.value_with_scenes_and_seconds(study.compute)
            versions = package_versions(("numpy", "scipy"))
            if known is None:
                known = StoredStudy(study.name, self._digest(study), value, spent, versions, tuple(sorted(scenes)))
                self._write(known)
            else:
                self.recomputed.append(Recomputed(study.name, largest_difference(known.value, value), known.versions))
        cache.record_used_scenes(known.scenes)
        return known.value

    def stored(self, study: Study) -> StoredStudy | None:
        """Return the stored value of a study; None if nothing is stored for what moves it now."""
        digest = self._digest(study)
        for folder in self.folders:
            try:
                record = record_from_bytes((folder / FOLDER / f"{study.name}.npz").read_bytes())
            except (OSError, ValueError):  # not stored, or damaged: it is computed
                continue
            if isinstance(record, StoredStudy) and record.digest == digest:
                self.found[study.name] = record.seconds
                return record
        return None

    def _digest(self, study: Study) -> str:
        what = [study.name, self._sources.digest(study.modules), digest_of_inputs(), self._runs]
        if study.shows_run_times:
            what.append(digest_of_run_times((*self.folders, shipped_store())))
        return hashlib.sha256(json.dumps(what).encode()).hexdigest()

    def _write(self, record: StoredStudy) -> None:
        if self.written_to is None:
            return
        try:
            content = record_to_bytes(record, compressed=True)
        except TypeError as error:  # of a case of another package; the report goes on without storing it
            show_progress_message(f"WARNING: study {record.name}: {error}")
            return
        path = self.written_to / FOLDER / f"{record.name}.npz"
        path.parent.mkdir(parents=True, exist_ok=True)
        modules = json.dumps(dict(sorted(self._sources.modules.items())), indent=0).encode()
        for file, data in ((path, content), (path.with_name(MODULES), modules)):
            new = temporary_path(file)
            new.write_bytes(data)
            new.replace(file)

    def drawn(self, day: str) -> list[str]:
        """Return the names of found studies that are computed again, in the order that the text ``day`` draws.

        A study is left out if it would raise the processor time of all beyond `RECOMPUTED`.
        """
        names, left = list[str](), RECOMPUTED
        for name in Random(day).sample(sorted(self.found), len(self.found)):
            if self.found[name] <= left:
                names.append(name)
                left -= self.found[name]
        return names

    @property
    def agree(self) -> bool:
        """Whether every study that was computed again has its stored value."""
        return all(x.difference <= ROUND_OFF for x in self.recomputed)

    def __str__(self) -> str:
        """Return a sentence on the studies that were computed again and on how far their values agree."""
        if not self.recomputed:
            return "all slow studies were computed"
        worst = max(self.recomputed, key=lambda x: x.difference)
        names, versions = (
            ", ".join(sorted(x.name for x in self.recomputed)),
            ", ".join({x.versions for x in self.recomputed}),
        )
        return (
            f"{len(self.recomputed)} stored studies, drawn by the date, were computed again ({names}): the largest "
            f"difference of a number is {worst.difference:.1e} of it ({worst.name}; stored with {versions})"
        )


def largest_difference(one: Any, other: Any) -> float:
    """Return the largest difference between numbers of two values, over the larger one; infinite if others differ.

    Numbers below `NOTHING` count as zero. Numbers in texts are equal if they differ by a unit of their last digit. Measured
    times, by their names in dictionaries, are not compared.
    """
    if isinstance(one, np.ndarray):
        one, other = one.tolist(), np.asarray(other).tolist()
    if is_dataclass(one) and type(one) is type(other):
        names = [f.name for f in fields(one) if f.compare]
        return max((largest_difference(getattr(one, name), getattr(other, name)) for name in names), default=0.0)
    if isinstance(one, dict) and isinstance(other, dict) and one.keys() == other.keys():
        return max((largest_difference(one[k], other[k]) for k in one if not _is_time(k)), default=0.0)
    if isinstance(one, list | tuple) and isinstance(other, list | tuple) and len(one) == len(other):
        return max(map(largest_difference, one, other), default=0.0)
    if isinstance(one, float | int | np.generic) and isinstance(other, float | int | np.generic):
        a, b = float(one), float(other)
        equal = a == b or (isnan(a) and isnan(b)) or max(abs(a), abs(b)) < NOTHING
        return 0.0 if equal else abs(a - b) / max(abs(a), abs(b))
    if isinstance(one, str) and isinstance(other, str) and NUMBER.sub("0", one) == NUMBER.sub("0", other):
        pairs = zip(NUMBER.findall(one), NUMBER.findall(other), strict=True)
        return max((_difference_of_number_texts(*pair) for pair in pairs), default=0.0)
    return 0.0 if one == other else float("inf")


def _is_time(key: Any) -> bool:
    """Return whether a key of JSON or a column of a table, or the first part of its name, is that of a measured time."""
    name = str(key[0] if isinstance(key, tuple) else key)
    return name.endswith(("seconds", "_time")) or name.startswith("time_of_")


def _difference_of_number_texts(one: str, other: str) -> float:
    unit = max(10.0 ** int(Decimal(text).as_tuple().exponent) for text in (one, other))
    return 0.0 if abs(float(one) - float(other)) < 1.5 * unit else largest_difference(float(one), float(other))
