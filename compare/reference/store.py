"""Runs of the 3D reference as they are kept: the record of a run, its content key, its sealed file in a store.

A sealed file is text with a checksum: what was damaged or changed by hand is not used. Times that stand in one table,
figure or ratio are of one measuring run, by the stamp of what they were measured with.
"""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache, lru_cache, partial
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from rollbench.compare import __version__, files
from rollbench.compare.files import replace_file
from rollbench.compare.provenance import sources_hash
from rollbench.compare.reference.tasks import Solvable, meant, plain, serves
from rollbench.compare.running import machine
from rollbench.hifi.meshing.settings import Settings
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.canonical import Fields, canonical, digest
from rollbench.meshes.condensed import geometry_digest
from rollbench.meshes.parts import GateLimits, Operation, Scene
from rollbench.meshes.solid import dimensions

#: Largest file of a run [bytes], and deepest nesting of its brackets: the largest shipped one has a tenth, and 4.
LARGEST, DEEPEST = 8_000_000, 8


def sealed(data: Mapping[str, Any]) -> str:
    """Text of a run's file: its data, rows of numbers line by line, with their checksum."""
    whole = {**data, "checksum": checksum(data)}
    return json.dumps(whole, separators=(",", ":")).replace("],[", "],\n[") + "\n"


def unsealed(path: Path) -> dict[str, Any]:
    """Data of a run's file. Raises ValueError for one that is too large, too deep, no run, or does not fit its checksum;
    OSError where it cannot be read."""
    data = _parsed(path)
    if data.pop("checksum", None) != checksum(data):
        raise ValueError("the checksum does not fit")
    return data


def checksum(data: Mapping[str, Any]) -> str:
    """Digest of JSON data, whatever the order of its keys and the layout of its text."""
    return hashlib.sha256(json.dumps(data, sort_keys=True, separators=(",", ":")).encode()).hexdigest()[:32]


def _parsed(path: Path) -> dict[str, Any]:
    if not path.is_file():
        raise ValueError("no regular file")
    with open(path, "rb") as file:
        content = file.read(LARGEST + 1)
    if len(content) > LARGEST:
        raise ValueError(f"more than {LARGEST} bytes")
    text, depth = content.decode("utf-8"), 0
    for mark in (c for c in text if c in "[]{}"):
        depth += 1 if mark in "[{" else -1
        if depth > DEEPEST:
            raise ValueError(f"brackets nested more than {DEEPEST} deep")
    data = json.loads(text)
    if not isinstance(data, dict):
        raise ValueError("no table of a run")
    return data


#: Folders whose sources decide how long a solution takes.
SOLVERS = ("hifi", "lowfi", "meshes")


@dataclass(frozen=True)
class Measured:
    """What a time was measured with: version of this program, digest of the solvers' sources, machine; what runs of before
    0.15 do not say is empty."""

    version: str
    sources: str = ""
    machine: str = ""

    def __str__(self) -> str:
        """In words, after "measured with"."""
        return f"{self.version or 'an unknown version'}{f' on {self.machine}' if self.machine else ''}"


@cache
def here() -> Measured:
    """What a time that is measured by this process is measured with."""
    return Measured(__version__, sources_hash(SOLVERS)[:16], machine())


def one_run(times: Iterable[Measured]) -> Measured | None:
    """What some times were measured with; None of no times. Raises ValueError for times of several measuring runs."""
    found = set(times)
    if len(found) > 1:
        raise ValueError(f"times of several measuring runs: {', '.join(sorted(map(str, found)))}")
    return next(iter(found), None)


def most_of(times: Iterable[Measured]) -> Measured | None:
    """What most of some times were measured with, those that a table can show beside one another; None of no times."""
    common = Counter(times).most_common(1)
    return common[0][0] if common else None


#: Bump when the mechanics of the reference or an assumption of meshes.solid changes: older runs are not used then.
SCHEMA = 8

#: As `SCHEMA`, for the condensed bodies, and for runs of several sets on one shaft.
BODIES, SETS = 4, 1

#: As `SCHEMA`, for runs with a load or support inside the 3D stretch of the screw: how a section takes it.
SECTIONS = "mean of a slice"

#: As `SCHEMA`, for runs with a hollow shaft beyond its 3D stretch: how it shears.
HOLLOW = "shear of a hollow section"

#: Programs whose results runs depend on.
PROGRAMS = ("gmsh", "scikit-fem")

#: Pattern of a content key.
KEY = 16 * "[0-9a-f]"

#: Fields of a run that are arrays.
ARRAYS = ("load", "angle", "frozen", "centreline")

#: What of a scene says nothing about static loads (of an ensemble, those of the first member).
UNSAID: dict[str, Any] = {
    "name": "",
    "title": "",
    "source": "",
    "assumed": (),
    "role": "",
    "members": 1,
    "gate": GateLimits(),
    "operation": Operation(),
    **dict.fromkeys(("friction", "motion", "circulation", "time")),
}


@dataclass(frozen=True)
class Run:
    """Stored result of one scene on one level; of several sets on one shaft the balls of all, set after set.

    Loads ``(n, 4)`` [N], contact angles ``(n, 4)`` [deg], loads with directions frozen in the nominal state, centreline
    ``(stations, 4)``: z, ux, uy, uz [m]; loads without single ingredients, with seconds they take; sides that were
    prepared; unknowns of the equivalent monolithic mesh; seconds of the set-up by stage and of the load case; peak
    memory [MB] of the set-up and its load cases so far (None: not measured); balance of balls and screw; bound on the
    modes left out; settings and versions; moving: what any load may still move by [N] in a run that did not settle, else 0;
    sources, machine: what its seconds were measured with, beside the version (empty in runs of before 0.15).
    """

    scene: str
    level: int
    variant: str
    status: str
    load: Array
    angle: Array
    frozen: Array
    centreline: Array
    without: dict[str, Array]
    without_seconds: dict[str, float]
    sides: tuple[int, ...]
    unknowns: int
    stages: dict[str, float]
    solve_seconds: float
    peak_MB: float | None
    balance: float
    along_groove: float
    screw_balance: float
    quality: dict[str, float]
    settings: dict[str, Any]
    assumed: tuple[str, ...]
    versions: dict[str, str]
    date: str
    moving: float = 0.0
    sources: str = ""
    machine: str = ""

    @property
    def measured(self) -> Measured:
        """What its seconds were measured with."""
        return Measured(self.versions.get("rollbench", ""), self.sources, self.machine)

    @property
    def answers(self) -> bool:
        """Whether the run has loads: converged, or not settled but for a known rest."""
        return self.status == "converged" or self.moving > 0.0

    @property
    def setup_seconds(self) -> float:
        """Seconds of the whole set-up."""
        return sum(self.stages.values())


def versions() -> dict[str, str]:
    """Versions of the programs whose results runs depend on; empty for one that is not installed."""
    return {name: _version(name) for name in PROGRAMS}


@cache
def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return ""


def key_of(
    scene: Solvable,
    variant: str,
    settings: Mapping[str, Any],
    sides: Sequence[int],
    programs: Mapping[str, str] | None = None,
) -> str:
    """Content key of a run: all that its numbers depend on.

    Geometry, errors, loads and supports of the scene (not what is `UNSAID`), its solid dimensions as resolved, the
    variant, the mesh settings as resolved, in numbers, and the prepared sides (both set by all scenes that were meshed
    together), ``SCHEMA``, and versions of the mesh generator and the finite elements: those installed unless given.
    """
    if isinstance(scene, Assembly):
        each = zip(scene.sets, settings["sets"], strict=True)
        meshed = [_meshed(s.parts, mesh, mesh["sides"], programs) for s, mesh in each if isinstance(s.parts, Scene)]
        return digest(SCHEMA, SETS, SECTIONS, meant(scene, UNSAID), variant, *meshed)[:16]
    return digest(SCHEMA, replace(scene, **UNSAID), variant, *_meshed(scene, settings, sides, programs))[:16]


def bodies_key(
    scene: Scene, settings: Mapping[str, Any], sides: Sequence[int], programs: Mapping[str, str] | None = None
) -> str:
    """Content key of condensed bodies: parts, solid dimensions, settings, sides and versions as for runs, ``BODIES``."""
    return digest(SCHEMA, BODIES, geometry_digest(scene), *_meshed(scene, settings, sides, programs))[:16]


def _meshed(
    scene: Scene, settings: Mapping[str, Any], sides: Sequence[int], programs: Mapping[str, str] | None
) -> tuple[object, ...]:
    """What a mesh depends on beside the scene's own fields."""

    made_by = versions() if programs is None else {name: programs.get(name, "") for name in PROGRAMS}
    dims = dimensions(scene)
    low, high = dims.ends(scene)
    inner = dims.screw_held != "bore" and any(low < z < high for z in settings.get("stations", ()))
    hollow = dims.screw_held != "bore" and dims.shaft_radius is None and scene.screw.bore > 0.0
    marks = ((SECTIONS,) if inner else ()) + ((HOLLOW,) if hollow else ())
    return replace(dims, assumed=(), mesh_only=()), Fields(Settings, plain(settings)), tuple(sides), made_by, *marks


def path_in(store: Path, scene: Solvable, run: Run) -> Path:
    """File of a run of a scene in a store; by the versions that it names, as it may be read where others, or none, are
    installed, and by the scene's name when it was made."""
    key = key_of(scene, run.variant, run.settings, run.sides, run.versions)
    return store / f"{_stem(run.scene, run.level, run.variant)}{key}.json"


def bodies_path(store: Path, scene: Scene, run: Run) -> Path:
    """File of the condensed bodies that belong to a run of a scene, in a store."""
    key = bodies_key(scene, run.settings, run.sides, run.versions)
    return store / f"bodies-{geometry_digest(scene)}-level{run.level}-{key}.npz"


def _stem(name: str, level: int, variant: str) -> str:
    return f"{name}-level{level}-{variant}-" if variant else f"{name}-level{level}-"


def save(store: Path, scene: Solvable, run: Run) -> Path:
    """Write a run that has loads whole or not at all. Raises ValueError for another one."""
    if not run.answers:
        raise ValueError(f"a run that did not converge is no reference: {run.status}")
    path = path_in(store, scene, run)
    data = asdict(run) | {name: _rows(getattr(run, name)) for name in ARRAYS}
    data["without"] = {name: _rows(array) for name, array in run.without.items()}
    replace_file(path, sealed(data))
    return path


def _rows(array: Array) -> list[list[float | None]]:
    """Rows with seven significant digits: far beyond the reference's own uncertainty, and small files."""
    return [[None if np.isnan(x) else float(f"{x:.7g}") for x in row] for row in array]


def shipped_store() -> Path:
    """Folder of the runs that come with the package."""
    return files.place("references")


def load(scene: Solvable, level: int, variant: str = "", stores: Sequence[Path] | None = None) -> Run | None:
    """A stored run of a mesh that serves the scene, or None; a damaged file, or one of another key, counts as absent.

    It is found by its key, under whatever name the scene had when it was made, which `Run.scene` keeps. stores: the shipped
    one unless given, the first that has a run counts. Of several runs, made with other scenes, those by the installed
    versions of gmsh and scikit-fem come first, then those on the finest cells, then those with the largest patches.
    """
    installed = versions()
    for store in (shipped_store(),) if stores is None else stores:
        runs = []
        for path in files_of(store, scene, level, variant):
            run = read(path, scene, level, variant)
            if run is not None and serves(scene, level, variant, run.settings, run.sides):
                runs.append(run)
        if runs:
            return min(runs, key=partial(_order, installed))
    return None


def files_of(store: Path, scene: Solvable, level: int, variant: str = "") -> list[Path]:
    """Files of a store whose name ends with the key of the scene on one of the meshes of that level; those under the
    scene's own name first."""
    own, pattern = (_stem(name, level, variant) for name in (scene.name, "*"))
    paths = sorted(store.glob(f"{pattern}{KEY}.json"), key=lambda path: (not path.name.startswith(own), path.name))
    meshes = {mesh.text: mesh for path in paths if (mesh := _mesh_of(path)) is not None and mesh.balls == scene.ball_count}
    keys = {key for mesh in meshes.values() if (key := mesh.key(scene, variant)) is not None}
    return [path for path in paths if path.stem.rpartition("-")[2] in keys]


class _Mesh(NamedTuple):
    """What a key has of a run besides its scene, as text too, and how many balls the run is of."""

    balls: int
    settings: dict[str, Any]
    sides: tuple[int, ...]
    programs: dict[str, str]
    text: str

    def key(self, scene: Solvable, variant: str) -> str | None:
        """The key of a scene's run on this mesh; None where it is no mesh of such a scene."""
        try:
            return key_of(scene, variant, self.settings, self.sides, self.programs)
        except (ValueError, KeyError, TypeError):
            return None


def _mesh_of(path: Path) -> _Mesh | None:
    """The mesh of a run's file; None where that cannot be read."""
    try:
        return _known_mesh(path, path.stat().st_mtime_ns)
    except OSError:
        return None


@lru_cache(maxsize=100_000)
def _known_mesh(path: Path, _changed: int) -> _Mesh | None:

    try:
        run = unsealed(path)
        settings, sides, programs = plain(run["settings"]), tuple(run["sides"]), dict(run["versions"])
        text = canonical((Fields(Settings, settings), sides, programs))
        return _Mesh(len(run["load"]), settings, sides, programs, text)
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None


def _order(installed: Mapping[str, str], run: Run) -> tuple[float, ...]:
    """Sort key of runs, the preferred one first."""
    other = any(run.versions.get(name) != version for name, version in installed.items())
    each = run.settings.get("sets", (run.settings,))
    return (other, *(x for mesh in each for x in mesh["semi"]), *(-x for mesh in each for x in mesh["reach"]))


def read(path: Path, scene: Solvable, level: int, variant: str) -> Run | None:
    """Run in a file, if that is whole and its name is the key of what it holds."""
    try:
        data = unsealed(path)
        arrays: dict[str, Any] = {k: _array(data.pop(k)) for k in ARRAYS}
        without = {k: _array(v) for k, v in data.pop("without").items()}
        data |= {"sides": tuple(data["sides"]), "assumed": tuple(data["assumed"]), "settings": plain(data["settings"])}
        run = Run(**data, **arrays, without=without)
        whole = run.load.shape == (scene.ball_count, 4) == run.angle.shape == run.frozen.shape
        key = key_of(scene, run.variant, run.settings, run.sides, run.versions)
        as_named = (run.level, run.variant) == (level, variant) and path.stem.rpartition("-")[2] == key
        return run if whole and as_named and run.answers else None
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None


def _array(rows: list[list[float | None]]) -> Array:
    return np.array([[np.nan if x is None else x for x in row] for row in rows], dtype=float)
