"""Storage of runs of the 3D reference: record of a run, its content key, and its file with a checksum.

A file that was damaged or edited is not used. A run records the version, sources and machine with which its times were
measured, so that a table or ratio compares only times that were measured under the same conditions.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cache, lru_cache, partial
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from rollbench.compare import __version__, files
from rollbench.compare.files import replace_file
from rollbench.compare.provenance import sources_hash
from rollbench.compare.reference.tasks import Solvable, is_mesh_suitable, mesh_settings_with_tuples
from rollbench.compare.running import machine_description
from rollbench.hifi.meshing.settings import Settings
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.condensed import digest_of_geometry
from rollbench.meshes.parts import Scene
from rollbench.meshes.record_keys import RecordFields, canonical_text, digest_of_values, static_part
from rollbench.meshes.solid import dimensions_of_3d_parts

#: Largest size of a run's file [bytes] and deepest nesting of its brackets, beyond which a file is not read. The files that
#: are included with rollbench have at most a tenth of this size and a nesting of 4.
LARGEST, DEEPEST = 8_000_000, 8


def run_text_with_checksum(data: Mapping[str, Any]) -> str:
    """Return the text of the file of a 3D run: its data as JSON with a checksum, one line for each row of an array."""
    whole = {**data, "checksum": checksum_of_data(data)}
    return json.dumps(whole, separators=(",", ":")).replace("],[", "],\n[") + "\n"


def read_checked_data(path: Path) -> dict[str, Any]:
    """Read the data of a stored 3D run from its file, and verify their checksum.

    Parameters
    ----------
    path
        Path of the file.

    Returns
    -------
    dict
        Data of the run.

    Raises
    ------
    ValueError
        If the file is too large, too deeply nested, not a run, or does not match its checksum.
    OSError
        If the file cannot be read.
    """
    data = _parse_json_file(path)
    if data.pop("checksum", None) != checksum_of_data(data):
        raise ValueError("the checksum in the file does not match its data: the file is damaged or was edited")
    return data


def checksum_of_data(data: Mapping[str, Any]) -> str:
    """Return a hash of JSON data that does not depend on the order of keys or the layout of the text."""
    return hashlib.sha256(json.dumps(data, sort_keys=True, separators=(",", ":")).encode()).hexdigest()[:32]


def _parse_json_file(path: Path) -> dict[str, Any]:
    """Return the JSON object in the file of a stored 3D run; ValueError if there is none, or it is too large."""
    if not path.is_file():
        raise ValueError("the path of a stored 3D run is not a regular file")
    with open(path, "rb") as file:
        content = file.read(LARGEST + 1)
    if len(content) > LARGEST:
        raise ValueError(f"the file of a stored 3D run is larger than {LARGEST} bytes, the largest size that is read")
    text, depth = content.decode("utf-8"), 0
    for mark in (c for c in text if c in "[]{}"):
        depth += 1 if mark in "[{" else -1
        if depth > DEEPEST:
            raise ValueError(f"the brackets in the file of a stored 3D run are nested more than {DEEPEST} deep")
    data = json.loads(text)
    if not isinstance(data, dict):
        raise ValueError("the file does not contain the JSON object of a stored 3D run")
    return data


#: Folders whose sources determine how long a solution takes.
SOLVERS = ("hifi", "lowfi", "meshes")


@dataclass(frozen=True)
class MeasuringConditions:
    """Conditions under which computing times were measured: version of rollbench, hash of its sources, and machine.

    Sources and machine are empty in runs of versions before 0.15.
    """

    #: Version of this program.
    version: str
    #: Hash of the solvers' source files.
    sources: str = ""
    #: Description of the machine.
    machine: str = ""

    def __str__(self) -> str:
        """Return version and machine as text, such as "0.20.0 on <machine>"."""
        return f"{self.version or 'an unknown version'}{f' on {self.machine}' if self.machine else ''}"


@cache
def measuring_conditions() -> MeasuringConditions:
    """Return the conditions under which this process measures computing times: version, sources, machine."""
    return MeasuringConditions(__version__, sources_hash(SOLVERS)[:16], machine_description())


#: What a page says in place of computing times of another version.
UNMEASURED = "Run times of this version are not measured yet; the command rollbench bench measures them."


def shows_times_of(version: str) -> bool:
    """Return whether computing times measured with a version of rollbench are shown beside errors of this version.

    They are if the first two numbers of both versions are the same. ``version``: such as "0.20.0".
    """
    return version.split(".")[:2] == __version__.split(".")[:2]


#: Version of the mechanics in content keys. Raise it if the mechanics or an assumption of meshes.solid changes; older runs
#: are then no longer used.
SCHEMA = 8

#: Further versions of the mechanics in content keys: of condensed bodies, and of runs with several nuts or bearing rows on
#: one shaft.
BODIES, SETS = 4, 1

#: Further text in the keys of runs with a load or support inside the 3D part of the screw: how a cross-section carries it.
SECTIONS = "mean of a slice"

#: Further text in the keys of runs whose shaft is hollow outside its 3D part: how its shear compliance is computed.
HOLLOW = "shear of a hollow section"

#: Programs whose versions affect the results of a run.
PROGRAMS = ("gmsh", "scikit-fem")

#: Pattern of a content key.
KEY = 16 * "[0-9a-f]"

#: Names of the fields of a run that are arrays.
ARRAYS = ("load", "angle", "frozen", "centreline")


@dataclass(frozen=True)
class Run:
    """Stored result of the 3D reference for one scene on one mesh level.

    If the scene has several nuts or bearing rows on one shaft, the balls are listed nut by nut, in the order of the scene.
    """

    #: Name of the scene.
    scene: str
    #: Mesh level, from 1 (coarsest); 0: the mesh of Lin's thesis, or loads from a file.
    level: int
    #: Name of the modelling variant in `levels.VARIANTS`; empty: none.
    variant: str
    #: "converged", or the reason why the run did not converge.
    status: str
    #: Contact loads, (n, 4) [N].
    load: Array
    #: Contact angles, (n, 4) [deg].
    angle: Array
    #: Contact loads computed with the contact normals of the nominal, unloaded state, (n, 4) [N].
    frozen: Array
    #: Displacement of the screw's axis, rows of z, ux, uy, uz [m].
    centreline: Array
    #: Contact loads (n, 4) [N] of the 3D model with one of its parts (such as the elastic nut) left out, by the name of the
    #: part.
    without: dict[str, Array] = field(default_factory=dict)
    #: Computing times of the solutions in ``without`` [s].
    without_seconds: dict[str, float] = field(default_factory=dict)
    #: Numbers of the flanks that were meshed: 0 to 3 for SL, SR, NL, NR.
    sides: tuple[int, ...] = ()
    #: Number of unknowns of the equivalent single mesh.
    unknowns: int = 0
    #: Time of each stage of the set-up (meshing, condensing and so on) [s], by its name.
    stages: dict[str, float] = field(default_factory=dict)
    #: Computing time of the load case on the finished set-up [s].
    solve_seconds: float = 0.0
    #: Peak memory of the set-up and of the load cases solved up to this one [MB]; None: not measured.
    peak_MB: float | None = None
    #: Largest unbalanced force on a ball, divided by the largest contact load.
    balance: float = 0.0
    #: Largest unbalanced force on a ball along its groove, divided by the largest contact load.
    along_groove: float = 0.0
    #: Unbalanced force on shaft and housings in the directions in which they are free to move, divided by the largest
    #: contact load.
    screw_balance: float = 0.0
    #: Measures of mesh quality by name, such as the cells across a contact and the smallest scaled Jacobian of each body.
    quality: dict[str, float] = field(default_factory=dict)
    #: Settings of the mesh (sizes of cells and patches) by name.
    settings: dict[str, Any] = field(default_factory=dict)
    #: Assumptions of scene and 3D model, as sentences.
    assumed: tuple[str, ...] = ()
    #: Versions of the programs that affect the result, by name.
    versions: dict[str, str] = field(default_factory=dict)
    #: Date of the run.
    date: str = ""
    #: Remaining change of a contact load in a run that did not fully converge [N], else 0.
    moving: float = 0.0
    #: Hash of the solvers' source files when the run was measured (empty before 0.15).
    sources: str = ""
    #: Machine on which the run was measured (empty before 0.15).
    machine: str = ""

    @property
    def measured(self) -> MeasuringConditions:
        """Version, sources and machine with which the computing times of the run were measured."""
        return MeasuringConditions(self.versions.get("rollbench", ""), self.sources, self.machine)

    @property
    def answers(self) -> bool:
        """Whether the contact loads can be used: the run converged, or how much its loads would still change is known."""
        return self.status == "converged" or self.moving > 0.0

    @property
    def setup_seconds(self) -> float:
        """Computing time of all stages of the set-up (meshing, condensing and so on) together [s]."""
        return sum(self.stages.values())


def program_versions() -> dict[str, str]:
    """Return the installed versions of gmsh and scikit-fem; an empty text for a program that is not installed."""
    return {name: _installed_version(name) for name in PROGRAMS}


@cache
def _installed_version(name: str) -> str:
    """Return the installed version of a package; empty if it is not installed."""
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return ""


def content_key_of_run(
    scene: Solvable,
    variant: str,
    settings: Mapping[str, Any],
    sides: Sequence[int],
    programs: Mapping[str, str] | None = None,
) -> str:
    """Return the key by which a stored 3D run is found: a hash of everything that affects the run's results.

    The hash covers the scene's geometry, manufacturing errors, loads and supports (not names, friction and other fields
    that do not affect static loads), its solid dimensions, the variant, the mesh settings and meshed flanks
    (which depend on all scenes that were meshed together), the version `SCHEMA` of the mechanics, and the versions of the
    mesh generator and the finite-element library.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row, or with several on one shaft.
    variant
        Name of the modelling variant; empty: none.
    settings
        Mesh settings by name, as stored with the run.
    sides
        Numbers of the flanks that were meshed: 0 and 1 for the left and right flank of the screw, 2 and 3 of the nut.
    programs
        Versions of gmsh and scikit-fem by name; None: those installed.

    Returns
    -------
    str
        The key, 16 hexadecimal digits.
    """
    if isinstance(scene, Assembly):
        each = ((s.parts, mesh) for s, mesh in zip(scene.sets, settings["sets"], strict=True))
        meshed = [_mesh_parts_of_key(x, mesh, mesh["sides"], programs) for x, mesh in each if isinstance(x, Scene)]
        return digest_of_values(SCHEMA, SETS, SECTIONS, static_part(scene), variant, *meshed)[:16]
    parts = _mesh_parts_of_key(scene, settings, sides, programs)
    return digest_of_values(SCHEMA, static_part(scene), variant, *parts)[:16]


def content_key_of_condensed_bodies(
    scene: Scene, settings: Mapping[str, Any], sides: Sequence[int], programs: Mapping[str, str] | None = None
) -> str:
    """Return the key by which stored condensed screw and nut are found: a hash of all that affects their stiffness.

    The hash covers the geometry of the parts, the mesh ``settings``, the numbers of the meshed flanks (``sides``), the
    versions of gmsh and scikit-fem (``programs``; None: those installed), and the versions of the mechanics: `SCHEMA`, and
    `BODIES` for condensed parts.
    """
    parts = _mesh_parts_of_key(scene, settings, sides, programs)
    return digest_of_values(SCHEMA, BODIES, digest_of_geometry(scene), *parts)[:16]


def _mesh_parts_of_key(
    scene: Scene, settings: Mapping[str, Any], sides: Sequence[int], programs: Mapping[str, str] | None
) -> tuple[object, ...]:
    """Return the values in a stored run's content key that describe its mesh: dimensions, settings, flanks, programs.

    ``settings``: mesh settings by name; ``sides``: numbers of the meshed flanks; ``programs``: versions of gmsh and
    scikit-fem; None: those installed.
    """
    made_by = program_versions() if programs is None else {name: programs.get(name, "") for name in PROGRAMS}
    dims = dimensions_of_3d_parts(scene)
    low, high = dims.ends_of_meshed_screw(scene)
    inner = dims.screw_held != "bore" and any(low < z < high for z in settings.get("stations", ()))
    hollow = dims.screw_held != "bore" and dims.shaft_radius is None and scene.screw.bore > 0.0
    marks = ((SECTIONS,) if inner else ()) + ((HOLLOW,) if hollow else ())
    mesh = RecordFields(Settings, mesh_settings_with_tuples(settings))
    return replace(dims, assumed=(), mesh_only=()), mesh, tuple(sides), made_by, *marks


def path_of_run(store: Path, scene: Solvable, run: Run) -> Path:
    """Return the path of the file of a scene's run in the folder ``store``.

    The file's name contains the name that the scene had when the run was computed, and a content key with the program
    versions of the run, which may differ from the installed versions.
    """
    key = content_key_of_run(scene, run.variant, run.settings, run.sides, run.versions)
    return store / f"{_file_name_start(run.scene, run.level, run.variant)}{key}.json"


def path_of_bodies(store: Path, scene: Scene, run: Run) -> Path:
    """Return the path of the file with the condensed screw and nut of a scene's ``run`` in the folder ``store``."""
    key = content_key_of_condensed_bodies(scene, run.settings, run.sides, run.versions)
    return store / f"bodies-{digest_of_geometry(scene)}-level{run.level}-{key}.npz"


def _file_name_start(name: str, level: int, variant: str) -> str:
    """Return the beginning of a stored run's file name, before its content key: scene, mesh level and variant."""
    return f"{name}-level{level}-{variant}-" if variant else f"{name}-level{level}-"


def save_run(store: Path, scene: Solvable, run: Run) -> Path:
    """Write a run of a scene to the folder ``store``, completely or not at all, and return the file's path.

    ValueError for a run whose contact loads cannot be used because it did not converge.
    """
    if not run.answers:
        raise ValueError(f"a 3D run that did not converge cannot be a reference: {run.status}")
    path = path_of_run(store, scene, run)
    data = asdict(run) | {name: _rounded_rows(getattr(run, name)) for name in ARRAYS}
    data["without"] = {name: _rounded_rows(array) for name, array in run.without.items()}
    replace_file(path, run_text_with_checksum(data))
    return path


def _rounded_rows(array: Array) -> list[list[float | None]]:
    """Return the rows of an array as lists of numbers with seven significant digits, for small files; nan becomes None."""
    return [[None if np.isnan(x) else float(f"{x:.7g}") for x in row] for row in array]


def shipped_store() -> Path:
    """Return the folder of the 3D reference runs that are part of the package."""
    return files.shipped_path("references")


def load_stored_run(scene: Solvable, level: int, variant: str = "", stores: Sequence[Path] | None = None) -> Run | None:
    """Return the stored run of the 3D reference for a scene; None if no folder has one.

    The run is identified by its content key, even if the scene had another name when the run was computed. Several runs may
    fit, because the mesh of a scene depends on the other scenes that were meshed together with it. Then runs with the
    installed versions of gmsh and scikit-fem are preferred, then those with the finest contact cells, then those with the
    largest contact patches. Damaged files are ignored.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row, or with several on one shaft.
    level
        Mesh level.
    variant
        Name of the modelling variant; empty: none.
    stores
        Folders in order of search; None: that included with rollbench.

    Returns
    -------
    Run or None
        The run.
    """
    installed = program_versions()
    for store in (shipped_store(),) if stores is None else stores:
        runs = []
        for path in files_of_stored_runs(store, scene, level, variant):
            run = read_run_file(path, scene, level, variant)
            if run is not None and is_mesh_suitable(scene, level, variant, run.settings, run.sides):
                runs.append(run)
        if runs:
            return min(runs, key=partial(_sort_key_of_run, installed))
    return None


def files_of_stored_runs(store: Path, scene: Solvable, level: int, variant: str = "") -> list[Path]:
    """Return the files of stored runs in the folder ``store`` whose content key fits a scene, mesh level and variant.

    Files with the scene's name come first. ``variant``: name of the modelling variant; empty: none.
    """
    own, pattern = (_file_name_start(name, level, variant) for name in (scene.name, "*"))
    paths = sorted(store.glob(f"{pattern}{KEY}.json"), key=lambda path: (not path.name.startswith(own), path.name))
    read = [found for path in paths if (found := _read_run_and_mesh(path)) is not None]
    meshes = {mesh: run for run, mesh in read if len(run.load) == scene.ball_count}
    keys = {_content_key_or_none(scene, variant, run) for run in meshes.values()}
    return [path for path in paths if path.stem.rpartition("-")[2] in keys]


def _content_key_or_none(scene: Solvable, variant: str, run: Run) -> str | None:
    """Return the key that a stored run of ``scene`` on the mesh of ``run`` would have; None if it does not fit the scene.

    ``variant``: name of the modelling variant; empty: none.
    """
    try:
        return content_key_of_run(scene, variant, run.settings, run.sides, run.versions)
    except (ValueError, KeyError, TypeError):
        return None


def _read_run_and_mesh(path: Path) -> tuple[Run, str] | None:
    """Return the run in a file, and the text that identifies its mesh; None if the file is damaged or missing."""
    try:
        return _cached_run_and_mesh(path, path.stat().st_mtime_ns)
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None


@lru_cache(maxsize=100_000)
def _cached_run_and_mesh(path: Path, _changed: int) -> tuple[Run, str]:
    """Return the run in a file, and the text of its settings, flanks and program versions, which identifies equal meshes.

    The result is cached by the path and the file's time of change ``_changed`` [ns].
    """
    data = read_checked_data(path)
    arrays: dict[str, Any] = {k: _array_from_json(data.pop(k)) for k in ARRAYS}
    without = {k: _array_from_json(v) for k, v in data.pop("without").items()}
    data |= {name: tuple(data[name]) for name in ("sides", "assumed")}
    data["settings"] = mesh_settings_with_tuples(data["settings"])
    run = Run(**data, **arrays, without=without)
    return run, canonical_text((RecordFields(Settings, run.settings), run.sides, run.versions))


def _sort_key_of_run(installed: Mapping[str, str], run: Run) -> tuple[float, ...]:
    """Return a sort key of stored runs: installed program versions first, then finest contact cells, largest patches.

    ``installed``: installed versions of gmsh and scikit-fem by name.
    """
    other = any(run.versions.get(name) != version for name, version in installed.items())
    each = run.settings.get("sets", (run.settings,))
    return (other, *(x for mesh in each for x in mesh["semi"]), *(-x for mesh in each for x in mesh["reach"]))


def read_run_file(path: Path, scene: Solvable, level: int, variant: str) -> Run | None:
    """Read a stored run of a scene on a mesh level, with a modelling variant ("": none), from a file.

    None if the file is damaged, is of another mesh level or variant, or its name does not contain the content key.
    """
    found = _read_run_and_mesh(path)
    if found is None:
        return None
    run = found[0]
    whole = run.load.shape == (scene.ball_count, 4) == run.angle.shape == run.frozen.shape
    key = _content_key_or_none(scene, run.variant, run)
    as_named = (run.level, run.variant) == (level, variant) and path.stem.rpartition("-")[2] == key
    return run if whole and as_named and run.answers else None


def _array_from_json(rows: list[list[float | None]]) -> Array:
    """Return rows of numbers from JSON as an array; None becomes nan."""
    return np.array([[np.nan if x is None else x for x in row] for row in rows], dtype=float)
