"""Runs of the 3D reference as they are kept: the record of a run, its content key, its sealed file in a store."""

from __future__ import annotations

import glob
import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from importlib import metadata, resources
from pathlib import Path
from typing import Any

import numpy as np

from compare.reference.sealing import sealed, unsealed
from compare.reference.tasks import plain, serves
from compare.writing import replace_file
from meshes.arrays import Array
from meshes.condensed import geometry_digest
from meshes.parts import Scene
from meshes.solid import dimensions

#: Bump when the mechanics of the reference or an assumption of meshes.solid changes: older runs are not used then.
SCHEMA = 8
#: As `SCHEMA`, for the condensed bodies.
BODIES = 4
#: Fields of a run that are arrays.
ARRAYS = ("load", "angle", "frozen", "centreline")


@dataclass(frozen=True)
class Run:
    """Stored result of one scene on one level.

    Loads ``(n, 4)`` [N], contact angles ``(n, 4)`` [deg], loads with directions frozen in the nominal state, centreline
    ``(stations, 4)``: z, ux, uy, uz [m]; loads without single ingredients, with seconds they take; sides that were
    prepared; unknowns of the equivalent monolithic mesh; seconds of the set-up by stage and of the load case; peak
    memory [MB] of the set-up and its load cases so far (None: not measured); balance of balls and screw; bound on the
    modes left out; settings and versions.
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

    @property
    def setup_seconds(self) -> float:
        """Seconds of the whole set-up."""
        return sum(self.stages.values())


def versions() -> dict[str, str]:
    """Versions of the programs whose results runs depend on; empty for one that is not installed."""
    found = {}
    for name in ("gmsh", "scikit-fem"):
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = ""
    return found


def key_of(scene: Scene, variant: str, settings: Mapping[str, Any], sides: Sequence[int]) -> str:
    """Content key of a run: all that its numbers depend on.

    Geometry, errors, loads and supports of the scene (names and remarks do not count), its solid dimensions as resolved,
    the variant, the mesh settings as resolved, in numbers, and the prepared sides (both set by all scenes that were meshed
    together), the ensemble's member (the first), versions of the mesh generator and the finite elements, ``SCHEMA``.
    """
    bare = replace(scene, name="", title="", source="", assumed=(), members=1)
    solid = replace(dimensions(scene), assumed=())
    mesh, programs = sorted(plain(settings).items()), sorted(versions().items())
    return _digest(SCHEMA, bare, solid, variant, mesh, tuple(sides), 0, programs)


def bodies_key(scene: Scene, settings: Mapping[str, Any], sides: Sequence[int]) -> str:
    """Content key of condensed bodies: parts, solid dimensions, mesh settings and sides as for runs, ``BODIES``."""
    solid = replace(dimensions(scene), assumed=())
    mesh = sorted(plain(settings).items())
    return _digest(SCHEMA, BODIES, geometry_digest(scene), solid, mesh, tuple(sides), sorted(versions().items()))


def _digest(*parts: object) -> str:
    return hashlib.sha256("|".join(repr(part) for part in parts).encode()).hexdigest()[:16]


def path_in(store: Path, scene: Scene, run: Run) -> Path:
    """File of a run of a scene in a store."""
    return store / f"{_stem(scene, run.level, run.variant)}{key_of(scene, run.variant, run.settings, run.sides)}.json"


def bodies_path(store: Path, scene: Scene, run: Run) -> Path:
    """File of the condensed bodies that belong to a run of a scene, in a store."""
    return store / f"bodies-{geometry_digest(scene)}-level{run.level}-{bodies_key(scene, run.settings, run.sides)}.npz"


def _stem(scene: Scene, level: int, variant: str) -> str:
    return f"{scene.name}-level{level}-{variant}-" if variant else f"{scene.name}-level{level}-"


def save(store: Path, scene: Scene, run: Run) -> Path:
    """Write a converged run whole or not at all. Raises ValueError for another one."""
    if run.status != "converged":
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
    return Path(str(resources.files("compare").joinpath("references")))


def load(scene: Scene, level: int, variant: str = "", stores: Sequence[Path] | None = None) -> Run | None:
    """A stored run of a mesh that serves the scene, or None; a damaged file, or one of another key, counts as absent.

    stores: the shipped one unless given, the first that has a run counts. Of several runs, made with other scenes, that on
    the finest cells is taken (then that with the largest patches).
    """
    for store in (shipped_store(),) if stores is None else stores:
        found = []
        for path in sorted(store.glob(f"{glob.escape(_stem(scene, level, variant))}*.json")):
            run = _read(path, scene, level, variant)
            if run is not None and serves(scene, level, variant, run.settings, run.sides):
                found.append(run)
        if found:
            return min(found, key=lambda run: (*run.settings["semi"], *(-x for x in run.settings["reach"])))
    return None


def _read(path: Path, scene: Scene, level: int, variant: str) -> Run | None:
    """Run in a file, if that is whole and its name is the key of what it holds."""
    try:
        data = unsealed(path)
        arrays: dict[str, Any] = {k: _array(data.pop(k)) for k in ARRAYS}
        without = {k: _array(v) for k, v in data.pop("without").items()}
        data |= {"sides": tuple(data["sides"]), "assumed": tuple(data["assumed"]), "settings": plain(data["settings"])}
        run = Run(**data, **arrays, without=without)
        whole = run.load.shape == (scene.ball_count, 4) == run.angle.shape == run.frozen.shape
        own = (run.level, run.variant) == (level, variant) and path.name == path_in(path.parent, scene, run).name
        return run if whole and own and run.status == "converged" else None
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None


def _array(rows: list[list[float | None]]) -> Array:
    return np.array([[np.nan if x is None else x for x in row] for row in rows], dtype=float)
