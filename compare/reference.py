"""Runs of the 3D reference: mesh levels, a store of their results, and what a scene's reference is worth."""

from __future__ import annotations

import hashlib
import json
import os
import resource
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from importlib import metadata, resources
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from compare import __version__
from compare.convergence import Convergence, observe
from compare.errors import InputError
from meshes.parts import Scene

Array = NDArray[np.float64]
Step = Callable[[str], None]

#: Mesh levels, coarse to fine; each refines patches, coarse bodies and balls by about 1.3. Lengths in m.
LEVELS: dict[int, dict[str, float]] = {
    1: {"b_over_h": 2.4, "fine": 1.6e-3, "coarse": 8.0e-3, "ball_fine": 0.55e-3, "ball_coarse": 1.2e-3},
    2: {"b_over_h": 3.2, "fine": 1.2e-3, "coarse": 6.0e-3, "ball_fine": 0.42e-3, "ball_coarse": 0.95e-3},
    3: {"b_over_h": 4.2, "fine": 0.92e-3, "coarse": 4.6e-3, "ball_fine": 0.32e-3, "ball_coarse": 0.72e-3},
}
#: Modelling choices that the source does not print, each varied on the coarsest level: label, changed settings.
VARIANTS: dict[str, tuple[str, dict[str, float | bool]]] = {
    "shaft-10": ("3D shaft 10 mm beyond the nut instead of 20 mm", {"shaft": 10e-3}),
    "shaft-40": ("3D shaft 40 mm beyond the nut", {"shaft": 40e-3}),
    "land": ("nut land radius 16.7 mm instead of 17 mm", {"nut_land": 16.7e-3}),
    "shaft-radius": ("shaft beyond the 3D stretch of 14.9 mm radius instead of 15.5 mm", {"shaft_radius": 14.9e-3}),
    "hole": ("hole along the axis of 0.8 mm radius instead of 1.5 mm", {"screw_hole": 0.8e-3}),
    "modes": ("24 modes per patch instead of 16", {"modes": 24}),
    "rigid-nut": ("rigid nut", {"elastic_nut": False}),
}


@dataclass(frozen=True)
class Run:
    """Stored result of one scene on one level: loads ``(n, 4)`` [N], contact angles ``(n, 4)`` [deg], loads with the
    directions frozen in the nominal state, unknowns of the equivalent monolithic mesh, seconds, peak memory [MB]."""

    scene: str
    level: int
    variant: str
    status: str
    load: Array
    angle: Array
    frozen: Array
    unknowns: int
    setup_seconds: float
    solve_seconds: float
    peak_MB: float
    balance: float
    along_groove: float
    settings: dict[str, Any]
    versions: dict[str, str]


def needed_sides(scene: Scene) -> tuple[int, ...]:
    """Sides that may touch, by the preload and the sense of the axial load; all four unless that is plain."""
    from meshes.errors import specimen
    from meshes.helix import ball_layout, groove_radii

    drawn = specimen(scene, ball_layout(scene))
    force = sum(x.force[2] for x in scene.loads)
    lateral = sum(abs(x.force[0]) + abs(x.force[1]) for x in scene.loads)
    bent = any(v != 0.0 for s in scene.supports for _, v in s.fixed)
    tight = float((drawn.ball_radius - scene.balls.radius).max()) > 2e-6 or bool(np.any(drawn.radius < groove_radii(scene)))
    if force == 0.0 or lateral > 0.2 * abs(force) or bent or tight:
        return (0, 1, 2, 3)
    return (0, 3) if force > 0.0 else (1, 2)


def key_of(scene: Scene, settings: dict[str, Any]) -> str:
    """Content key of a run: geometry, errors, loads, supports and mesh settings; names and remarks do not count."""
    bare = replace(scene, name="", title="", source="", assumed=(), members=1)
    return hashlib.sha256(f"1|{bare!r}|{sorted(settings.items())!r}".encode()).hexdigest()[:16]


def settings_of(scene: Scene, level: int, variant: str = "") -> dict[str, Any]:
    """Mesh settings of a scene on a level with a modelling variant."""
    from hifi.fit import Settings, expected_semi_axes

    if level not in LEVELS:
        raise InputError("command line", "--levels", str(level), f"1 to {len(LEVELS)}", "choose fewer levels")
    extra = VARIANTS[variant][1] if variant else {}
    axes = {"semi": expected_semi_axes(scene)}
    return asdict(Settings(**{**LEVELS[level], **axes, **extra}))  # type: ignore[arg-type]


def compute(scenes: Sequence[Scene], level: int, variant: str = "", step: Step = lambda _: None) -> list[Run]:
    """Run scenes of one geometry and one set of held freedoms on one level, sharing the set-up."""
    from hifi.fit import Settings
    from hifi.reference import solve_reference
    from hifi.setup import prepare

    settings = settings_of(scenes[0], level, variant)
    start = perf_counter()
    sides = tuple(sorted({s for scene in scenes for s in needed_sides(scene)}))
    try:
        setup = prepare(scenes[0], sides, Settings(**settings), step, tuple(scenes[1:]))
    except ValueError as error:
        raise InputError(
            scenes[0].name, "3D reference", str(error), "a scene whose contacts have room for their patches",
            "solve it with a low-order model only",
        ) from error  # fmt: skip
    shared = perf_counter() - start
    runs = []
    for scene in scenes:
        result = solve_reference(setup, scene)
        frozen = solve_reference(setup, scene, updates=0)
        runs.append(
            Run(
                scene.name, level, variant, result.status, result.load, np.degrees(result.contact_angle), frozen.load,
                result.unknowns, shared, result.seconds["contact"],
                resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0, result.balance, result.along_groove,
                settings, {"rollbench": __version__, "gmsh": metadata.version("gmsh")},
            )
        )  # fmt: skip
        step(f"{scene.name}, level {level}: {result.status}, {result.seconds['contact']:.1f} s")
    return runs


def path_in(store: Path, scene: Scene, level: int, variant: str = "") -> Path:
    """File of a run in a store."""
    tail = f"-{variant}" if variant else ""
    return store / f"{scene.name}-level{level}{tail}-{key_of(scene, settings_of(scene, level, variant))}.json"


def save(store: Path, scene: Scene, run: Run) -> Path:
    """Write a run whole or not at all."""
    store.mkdir(parents=True, exist_ok=True)
    path = path_in(store, scene, run.level, run.variant)
    data = asdict(run)
    for name in ("load", "angle", "frozen"):
        data[name] = [[None if np.isnan(x) else float(x) for x in row] for row in data[name]]
    handle, temporary = tempfile.mkstemp(dir=store, prefix=".run.", suffix=".tmp")
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            json.dump(data, file, indent=1)
        os.replace(temporary, path)
    except BaseException:
        os.unlink(temporary)
        raise
    return path


def shipped_store() -> Path:
    """Folder of the runs that come with the package."""
    return Path(str(resources.files("compare").joinpath("references")))


def load(scene: Scene, level: int, variant: str = "", stores: Sequence[Path] = ()) -> Run | None:
    """A stored run, or None; a damaged file counts as absent."""
    for store in (*stores, shipped_store()):
        path = path_in(store, scene, level, variant)
        try:
            data = json.loads(path.read_text(encoding="utf-8"))
            arrays: dict[str, Any] = {
                k: np.array([[np.nan if x is None else x for x in row] for row in data.pop(k)], dtype=float)
                for k in ("load", "angle", "frozen")
            }
            return Run(**data, **arrays)
        except (OSError, ValueError, KeyError, TypeError):
            continue
    return None


@dataclass(frozen=True)
class Reference:
    """The 3D reference of a scene: runs coarse to fine, loads of the finest ``(n, 4)`` [N], uncertainty ``(n, 4)`` [N] by
    grid convergence per contact (band where not monotone; None with fewer than three levels)."""

    scene: str
    runs: tuple[Run, ...]
    load: Array
    uncertainty: Array | None
    convergence: tuple[tuple[Convergence, ...], ...] | None


def reference(scene: Scene, stores: Sequence[Path] = ()) -> Reference | None:
    """Best stored reference of a scene, or None."""
    runs = tuple(run for level in LEVELS if (run := load(scene, level, stores=stores)) is not None)
    runs = tuple(run for run in runs if run.status == "converged")
    if not runs:
        return None
    best = runs[-1]
    if len(runs) < 3:
        return Reference(scene.name, runs, best.load, None, None)
    sizes = [1.0 / run.settings["b_over_h"] for run in runs[-3:]]
    stack = np.stack([run.load for run in runs[-3:]])
    found = tuple(
        tuple(observe(stack[:, i, s], sizes) for s in range(4)) for i in range(stack.shape[1])
    )
    return Reference(scene.name, runs, best.load, np.array([[c.uncertainty for c in row] for row in found]), found)
