"""Runs of the 3D reference: mesh levels, a store of their results, and a scene's reference with its grid uncertainty."""

from __future__ import annotations

import datetime
import glob
import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from importlib import metadata, resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from compare import __version__
from compare.errors import InputError, Refusal
from compare.reference import grid_order
from compare.reference.convergence import Convergence, Pooled, pool, representative_size
from compare.reference.levels import LEVELS, SOURCE_LEVEL, scaled
from compare.reference.sealing import sealed, unsealed
from compare.reference.variants import VARIANTS
from compare.system import need_gmsh, out_of_memory
from compare.writing import replace_file
from meshes.condensed import CondensedBodies, geometry_digest
from meshes.memory import peak_MB
from meshes.parts import Scene
from meshes.solid import dimensions

if TYPE_CHECKING:
    from hifi.fit import Settings
    from hifi.setup import Setup

Array = NDArray[np.float64]
Step = Callable[[str], None]

#: Bump when the mechanics of the reference or an assumption of meshes.solid changes: older runs are not used then.
SCHEMA = 8
#: How often patches are enlarged where a contact reaches their rim, by what, and in how many such steps at a time at most.
ENLARGE, BEYOND, LARGER = 2, 1.2, 4
#: Share by which a patch must grow to be built again.
GROWN = 5e-3
#: Levels that a scene's uncertainty is taken from, the finest: the coarsest of more lie furthest from what a power of the
#: cell size says (lightly loaded contacts of two-balls: `rollbench mesh-study two-balls`).
FITTED = 4
#: As `SCHEMA`, for the condensed bodies.
BODIES = 4


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


def needed_sides(scene: Scene) -> tuple[int, ...]:
    """Sides that may touch, by `hifi.expected`. Raises Refusal where that finds no equilibrium."""
    from hifi.expected import expected_contacts

    try:
        return expected_contacts(scene).sides()
    except ValueError as error:
        raise _refused(scene, error) from error


def _refused(scene: Scene, error: ValueError) -> Refusal:
    return Refusal(scene.name, "3D reference", str(error), "change what it names, or solve it with a low-order model")


def geometry_of(scene: Scene) -> tuple[Any, ...]:
    """What scenes must share to share a set-up."""
    return scene.track, scene.screw, scene.nut, scene.balls, scene.solid, scene.ingredients.screw


def groups(scenes: Sequence[Scene]) -> list[list[Scene]]:
    """Scenes of one geometry together, in order."""
    found: dict[tuple[Any, ...], list[Scene]] = {}
    for scene in scenes:
        found.setdefault(geometry_of(scene), []).append(scene)
    return list(found.values())


def key_of(scene: Scene, variant: str, settings: Mapping[str, Any], sides: Sequence[int]) -> str:
    """Content key of a run: all that its numbers depend on.

    Geometry, errors, loads and supports of the scene (names and remarks do not count), its solid dimensions as resolved,
    the variant, the mesh settings as resolved, in numbers, and the prepared sides (both set by all scenes that were meshed
    together), the ensemble's member (the first), versions of the mesh generator and the finite elements, ``SCHEMA``.
    """
    bare = replace(scene, name="", title="", source="", assumed=(), members=1)
    solid = replace(dimensions(scene), assumed=())
    mesh, programs = sorted(_plain(settings).items()), sorted(versions().items())
    return _digest(SCHEMA, bare, solid, variant, mesh, tuple(sides), 0, programs)


def bodies_key(scene: Scene, settings: Mapping[str, Any], sides: Sequence[int]) -> str:
    """Content key of condensed bodies: parts, solid dimensions, mesh settings and sides as for runs, ``BODIES``."""
    solid = replace(dimensions(scene), assumed=())
    mesh = sorted(_plain(settings).items())
    return _digest(SCHEMA, BODIES, geometry_digest(scene), solid, mesh, tuple(sides), sorted(versions().items()))


def _digest(*parts: object) -> str:
    return hashlib.sha256("|".join(repr(part) for part in parts).encode()).hexdigest()[:16]


def _plain(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Settings as they come back from a file: lists are tuples."""
    return {name: tuple(value) if isinstance(value, list | tuple) else value for name, value in settings.items()}


def versions() -> dict[str, str]:
    """Versions of the programs whose results runs depend on; empty for one that is not installed."""
    found = {}
    for name in ("gmsh", "scikit-fem"):
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = ""
    return found


def settings_of(scenes: Sequence[Scene], level: int, variant: str = "") -> Settings:
    """Mesh settings that serve ``scenes`` of one geometry on a level with a modelling variant.

    Raises InputError for an unknown level, Refusal where no contacts can be expected.
    """
    from hifi.fit import Settings, expected_reach, expected_semi_axes

    if level not in (SOURCE_LEVEL, *LEVELS):
        raise InputError("command line", "--levels", str(level), f"1 to {len(LEVELS)}", "choose fewer levels")
    sizes = scaled(level, scenes[0].balls.radius, VARIANTS[variant].refined if variant else ())
    axes, reach = [], []
    for scene in scenes:
        try:
            axes.append(expected_semi_axes(scene))
            reach.append(expected_reach(scene))
        except ValueError as error:
            raise _refused(scene, error) from error
    sizes["semi"] = (min(a for a, _ in axes), min(b for _, b in axes))
    sizes["reach"] = (max(a for a, _ in reach), max(b for _, b in reach))
    sizes["element"] = "P1" if level == SOURCE_LEVEL else "Q2"
    return Settings(**sizes)


def serves(scene: Scene, level: int, variant: str, settings: Mapping[str, Any], sides: Sequence[int]) -> bool:
    """Whether a mesh of a level serves a scene: cells at least as fine, patches as large, all sides that may touch."""
    changed = VARIANTS[variant].change(scene) if variant else scene
    try:
        own, needed = asdict(settings_of([changed], level, variant)), needed_sides(changed)
    except InputError:
        return False
    found = _plain(settings)
    same = all(found.get(name) == value for name, value in own.items() if name not in ("semi", "reach"))
    fits = {"semi", "reach"} <= set(found) and set(needed) <= set(sides)
    return bool(
        same
        and fits
        and all(x <= y for x, y in zip(found["semi"], own["semi"], strict=True))
        and all(x >= y for x, y in zip(found["reach"], own["reach"], strict=True))
    )


@dataclass(frozen=True)
class Task:
    """One set-up and its load cases: scenes of one geometry on one level, with a variant; ``ablate``: also leave out every
    ingredient in turn; ``cache``: folder of the mesh cache; ``processes`` that one set-up may use."""

    scenes: tuple[Scene, ...]
    level: int
    variant: str = ""
    ablate: bool = False
    cache: Path | None = None
    processes: int = 1

    @property
    def label(self) -> str:
        """What it is, for the terminal."""
        mesh = "the source's mesh" if self.level == SOURCE_LEVEL else f"level {self.level}"
        tail = f", {VARIANTS[self.variant].label}" if self.variant else ""
        return f"{', '.join(s.name for s in self.scenes)}: {mesh}{tail}"


def compute(task: Task, step: Step = lambda _: None) -> list[Run]:
    """Run a task. Raises InputError where a mesh cannot be built, or memory runs out."""
    return compute_with_bodies(task, step)[0]


def compute_with_bodies(task: Task, step: Step = lambda _: None) -> tuple[list[Run], CondensedBodies | None]:
    """Run a task; with its runs, where all converged, the bodies condensed to the contacts, if `with_bodies`.

    Where a contact reaches the rim of its patch, patches are enlarged to what the loads found need, if that changes them.
    """
    need_gmsh()
    from hifi.condensed import condensed_bodies
    from hifi.reference import AT_RIM
    from hifi.setup import prepare
    from meshes.cache import Cache

    scenes = task.scenes
    if task.variant:
        scenes = tuple(VARIANTS[task.variant].change(scene) for scene in scenes)
    settings = settings_of(scenes, task.level, task.variant)
    sides = tuple(sorted({s for scene in scenes for s in needed_sides(scene)}))
    for attempt in range(ENLARGE + 1):
        try:
            setup = prepare(scenes[0], sides, settings, step, scenes[1:], cache=Cache(task.cache), processes=task.processes)
        except MemoryError as error:
            raise out_of_memory(error) from error
        except ValueError as error:
            raise _refused(scenes[0], error) from error
        runs = [_one(task, number, scene, setup, needed_sides(scene), step) for number, scene in enumerate(scenes)]
        full = [k for k, run in enumerate(runs) if run.status == AT_RIM]
        if not full:
            break
        larger, why = enlarged(setup, [scenes[k] for k in full], [runs[k] for k in full])
        if larger is None or attempt == ENLARGE:
            for k in full:
                runs[k] = replace(runs[k], status=f"a contact reaches the rim of its patch: {why}")
            break
        settings = larger
        step(f"a contact reaches the rim of its patch, larger patches: {why}")
    good = all(run.status == "converged" for run in runs)
    return runs, condensed_bodies(setup, task.level) if good and with_bodies(task) else None


def enlarged(setup: Setup, scenes: Sequence[Scene], runs: Sequence[Run]) -> tuple[Settings | None, str]:
    """Settings with patches for the loads that were found, or None where that changes no patch; a text with both
    numbers."""
    from hifi.expected import hertz_units
    from hifi.fit import patch_lines, socket_size

    def zone(settings: Settings) -> tuple[float, float]:
        """Half widths [m] of the contact zone."""
        size = socket_size(setup.scene, setup.map, setup.layout, setup.sides, setup.dims, settings)
        widths = (size.gamma * float(setup.map.radius.mean()), size.phi * setup.map.R)
        share = patch_lines(settings, widths, size.depth)[1]
        return share[0] * widths[0], share[1] * widths[1]

    def mm(lengths: tuple[float, float]) -> str:
        return f"{1e3 * lengths[0]:.3g} mm across and {1e3 * lengths[1]:.3g} mm along the groove"

    needs = np.zeros(2)
    for scene, run in zip(scenes, runs, strict=True):
        size = np.cbrt(run.load)
        shift = np.nan_to_num(np.abs(np.radians(run.angle) - setup.map.beta)) * setup.map.radius
        units = hertz_units(scene)
        across, along = (size * np.array([getattr(unit, name) for unit in units]) for name in ("semi_x", "semi_y"))
        needs = np.maximum(needs, [float((across + shift).max()), float(along.max())])
    has, reach = zone(setup.settings), np.array(setup.settings.reach)
    words = f"by the loads found it needs {mm((float(needs[0]), float(needs[1])))}, the patch has {mm(has)}"
    refused = ""
    # a small step may be less than a cell, a large one more than there is room for: then the largest that fits
    for factor in (*(BEYOND**power for power in range(1, LARGER + 1)), *np.linspace(BEYOND, 1.0, 41)[1:-1]):
        a, b = np.maximum(factor * reach, 0.0 if refused else needs).tolist()
        larger = replace(setup.settings, reach=(a, b))
        try:
            after = zone(larger)
        except ValueError as error:
            refused = refused or f"; a larger one is refused: {error}"
            continue
        if max(after[0] / has[0], after[1] / has[1]) > 1.0 + GROWN:
            return larger, words
    return None, words + (refused or ", as much as there is room for; lower the load, or make more room beside the contact")


def with_bodies(task: Task) -> bool:
    """Whether a task also stores its bodies, condensed to the contacts: base variant on a regular mesh level."""
    return not task.variant and task.level in LEVELS


def bodies_path(store: Path, scene: Scene, run: Run) -> Path:
    """File of the condensed bodies that belong to a run of a scene, in a store."""
    return store / f"bodies-{geometry_digest(scene)}-level{run.level}-{bodies_key(scene, run.settings, run.sides)}.npz"


def _one(task: Task, number: int, scene: Scene, setup: Setup, sides: tuple[int, ...], step: Step) -> Run:
    """One load case of a prepared geometry; the run carries the name of the task's own scene."""
    from hifi.reference import INGREDIENTS, solve_reference

    result = solve_reference(setup, scene, sides=sides)
    without, seconds = {}, {}
    if task.ablate:
        for name in INGREDIENTS:
            found = solve_reference(setup, scene, sides=sides, leave_out=frozenset([name]))
            without[name], seconds[name] = found.load, found.seconds["contact"]
    frozen = without.get("moving normals")
    if frozen is None:
        frozen = solve_reference(setup, scene, sides=sides, updates=0).load
    step(f"{scene.name}, level {task.level}: {result.status}, {result.seconds['contact']:.1f} s")
    return Run(
        scene=task.scenes[number].name,
        level=task.level,
        variant=task.variant,
        status=result.status,
        load=result.load,
        angle=np.degrees(result.contact_angle),
        frozen=frozen,
        centreline=np.column_stack([result.stations, result.centreline[:, :3]]),
        without=without,
        without_seconds=seconds,
        sides=setup.sides,
        unknowns=result.unknowns,
        stages=setup.seconds,
        solve_seconds=result.seconds["contact"],
        peak_MB=None if (own := peak_MB()) is None else own + setup.others_MB,
        balance=result.balance,
        along_groove=result.along_groove,
        screw_balance=result.screw_balance,
        quality=setup.quality,
        settings=asdict(setup.settings) | {"stations": _stations(task.scenes)},
        assumed=setup.dims.assumed,
        versions={"rollbench": __version__, **versions()},
        date=datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d"),
    )


def _stations(scenes: Sequence[Scene]) -> tuple[float, ...]:
    """Stations of supports and loads [m] of all scenes that share a set-up: its shaft has freedoms there."""
    return tuple(sorted({z for scene in scenes for z in scene.stations}))


def path_in(store: Path, scene: Scene, run: Run) -> Path:
    """File of a run of a scene in a store."""
    return store / f"{_stem(scene, run.level, run.variant)}{key_of(scene, run.variant, run.settings, run.sides)}.json"


def _stem(scene: Scene, level: int, variant: str) -> str:
    return f"{scene.name}-level{level}-{variant}-" if variant else f"{scene.name}-level{level}-"


ARRAYS = ("load", "angle", "frozen", "centreline")


def _rows(array: Array) -> list[list[float | None]]:
    """Rows with seven significant digits: far beyond the reference's own uncertainty, and small files."""
    return [[None if np.isnan(x) else float(f"{x:.7g}") for x in row] for row in array]


def save(store: Path, scene: Scene, run: Run) -> Path:
    """Write a converged run whole or not at all. Raises ValueError for another one."""
    if run.status != "converged":
        raise ValueError(f"a run that did not converge is no reference: {run.status}")
    path = path_in(store, scene, run)
    data = asdict(run) | {name: _rows(getattr(run, name)) for name in ARRAYS}
    data["without"] = {name: _rows(array) for name, array in run.without.items()}
    replace_file(path, sealed(data))
    return path


def shipped_store() -> Path:
    """Folder of the runs that come with the package."""
    return Path(str(resources.files("compare").joinpath("references")))


def _array(rows: list[list[float | None]]) -> Array:
    return np.array([[np.nan if x is None else x for x in row] for row in rows], dtype=float)


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
        data |= {"sides": tuple(data["sides"]), "assumed": tuple(data["assumed"]), "settings": _plain(data["settings"])}
        run = Run(**data, **arrays, without=without)
        whole = run.load.shape == (scene.ball_count, 4) == run.angle.shape == run.frozen.shape
        own = (run.level, run.variant) == (level, variant) and path.name == path_in(path.parent, scene, run).name
        return run if whole and own and run.status == "converged" else None
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None


@dataclass(frozen=True)
class Reference:
    """The 3D reference of a scene: runs coarse to fine, loads of the finest ``(n, 4)`` [N], their uncertainty ``(n, 4)``
    [N] by grid convergence (three times the difference of two levels; None with one), the convergence of every contact's
    load, and of all of them with one order; loads extrapolated to cells of no size, None where no order is believed."""

    scene: str
    runs: tuple[Run, ...]
    load: Array
    uncertainty: Array | None
    convergence: tuple[tuple[Convergence, ...], ...] | None
    pooled: Pooled | None
    extrapolated: Array | None

    @property
    def best(self) -> Run:
        """The finest run."""
        return self.runs[-1]

    @property
    def sizes(self) -> tuple[float, ...]:
        """Relative cell sizes of the runs."""
        return tuple(representative_size(run.settings) for run in self.runs)

    @property
    def estimate(self) -> Array:
        """Best estimate of the loads ``(n, 4)`` [N]: extrapolated, or else those of the finest level."""
        return self.load if self.extrapolated is None else self.extrapolated


def reference(scene: Scene, stores: Sequence[Path] | None = None) -> Reference | None:
    """Best stored reference of a scene, its `FITTED` finest runs, or None."""
    runs = tuple(run for level in LEVELS if (run := load(scene, level, stores=stores)) is not None)
    runs = tuple(run for run in runs if run.status == "converged")[-FITTED:]
    if not runs:
        return None
    order = grid_order.load((shipped_store(),) if stores is None else (*stores, shipped_store()))
    return reference_of(scene.name, runs, None if order is None else order.interval)


def reference_of(scene: str, runs: tuple[Run, ...], order: tuple[float, float] | None = None) -> Reference:
    """Reference of converged runs, coarse to fine; order: interval of the method's (`compare.reference.grid_order`)."""
    best = runs[-1]
    if len(runs) < 2:
        return Reference(scene, runs, best.load, None, None, None, None)
    shape = best.load.shape
    sizes = [representative_size(run.settings) for run in runs]
    pooled = pool(np.stack([run.load.ravel() for run in runs]), sizes, order)
    each = pooled.each
    uncertainty = np.array([c.uncertainty for c in each], dtype=float).reshape(shape)
    rows = tuple(each[i * shape[1] : (i + 1) * shape[1]] for i in range(shape[0]))
    extrapolated = None
    if all(c.extrapolated is not None for c in each):
        extrapolated = np.maximum(np.array([c.extrapolated for c in each], dtype=float).reshape(shape), 0.0)
    return Reference(scene, runs, best.load, uncertainty, rows, pooled, extrapolated)
