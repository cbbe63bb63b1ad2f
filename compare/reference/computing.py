"""Computing runs of the 3D reference: one set-up and its load cases, patches enlarged where a contact reaches their rim."""

from __future__ import annotations

import datetime
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from typing import TYPE_CHECKING

import numpy as np

from rollbench.comparison import __version__
from rollbench.comparison.reference.levels import LEVELS
from rollbench.comparison.reference.store import Run, versions
from rollbench.comparison.reference.tasks import Task, needed_sides, refused, settings_of
from rollbench.comparison.reference.variants import VARIANTS
from rollbench.comparison.system import need_reference, out_of_memory
from rollbench.meshes.condensed import CondensedBodies
from rollbench.meshes.memory import peak_MB
from rollbench.meshes.parts import Scene

if TYPE_CHECKING:
    from rollbench.hifi.meshing.settings import Settings
    from rollbench.hifi.setup import Setup

Step = Callable[[str], None]

#: How often patches are enlarged where a contact reaches their rim, by what, and in how many such steps at a time at most.
ENLARGE, BEYOND, LARGER = 3, 1.2, 4
#: Share by which a patch must grow to be built again.
GROWN = 5e-3


def compute(task: Task, step: Step = lambda _: None) -> list[Run]:
    """Run a task. Raises InputError where a mesh cannot be built, or memory runs out."""
    return compute_with_bodies(task, step)[0]


def compute_with_bodies(task: Task, step: Step = lambda _: None) -> tuple[list[Run], CondensedBodies | None]:
    """Run a task; with its runs, where all have loads, the bodies condensed to the contacts, if `with_bodies`.

    Where a contact reaches the rim of its patch, patches are enlarged to what the loads found need, if that changes them.
    """
    need_reference()
    from rollbench.hifi.condensed import condensed_bodies
    from rollbench.hifi.reference import AT_RIM
    from rollbench.hifi.setup import prepare
    from rollbench.meshes.cache import Cache

    scenes = task.scenes
    if task.variant:
        scenes = tuple(VARIANTS[task.variant].change(scene) for scene in scenes)
    settings = settings_of(scenes, task.level, task.variant)
    settings = replace(settings, cell=task.cut_cells * settings.cell)
    sides = tuple(sorted({s for scene in scenes for s in needed_sides(scene)}))
    for attempt in range(ENLARGE + 1):
        try:
            setup = prepare(scenes[0], sides, settings, step, scenes[1:], cache=Cache(task.cache), processes=task.processes)
        except MemoryError as error:
            raise out_of_memory(error) from error
        except ValueError as error:
            raise refused(scenes[0], error) from error
        runs = [_one(task, number, scene, setup, needed_sides(scene), step) for number, scene in enumerate(scenes)]
        full = [k for k, run in enumerate(runs) if run.status == AT_RIM]
        if not full:
            break
        left = max(0, ENLARGE - 1 - attempt)
        larger, why = enlarged(setup, [scenes[k] for k in full], [runs[k] for k in full], left)
        if larger is None or attempt == ENLARGE:
            for k in full:
                runs[k] = replace(runs[k], status=f"a contact reaches the rim of its patch: {why}")
            break
        settings = larger
        step(f"a contact reaches the rim of its patch, larger patches: {why}")
    good = all(run.answers for run in runs)
    return runs, condensed_bodies(setup, task.level) if good and with_bodies(task) else None


def enlarged(setup: Setup, scenes: Sequence[Scene], runs: Sequence[Run], left: int) -> tuple[Settings | None, str]:
    """Settings with patches for the loads that were found, or None where that changes no patch; a text with both
    numbers.

    Patches grow by a step; where ``left`` steps would leave them shorter than the contacts reach along the groove, as its
    lead sets these askew, they are at once as long as those need.
    """
    from rollbench.hifi.meshing.expected import hertz_units
    from rollbench.hifi.meshing.fit import patch_lines, reach_along, socket_size

    def zone(settings: Settings) -> tuple[float, float]:
        """Half widths [m] of the contact zone."""
        size = socket_size(setup.scene, setup.map, setup.layout, setup.sides, setup.dims, settings)
        widths = (size.gamma * float(setup.map.radius.mean()), size.phi * setup.map.R)
        share = patch_lines(settings, widths, size.depth)[1]
        return share[0] * widths[0], share[1] * widths[1]

    def mm(lengths: tuple[float, float]) -> str:
        return f"{1e3 * lengths[0]:.3g} mm across and {1e3 * lengths[1]:.3g} mm along the groove"

    m, needs, askew = setup.map, np.zeros(2), 0.0
    for scene, run in zip(scenes, runs, strict=True):
        size, angle = np.cbrt(run.load), np.where(run.load > 0.0, np.radians(run.angle), m.beta)
        units = hertz_units(scene)
        across, along = (size * np.array([getattr(unit, name) for unit in units]) for name in ("semi_x", "semi_y"))
        needs = np.maximum(needs, [float((across + np.abs(angle - m.beta) * m.radius).max()), float(along.max())])
        askew = max(askew, *(reach_along(m, s, angle[:, s], across[:, s], along[:, s]) for s in setup.sides))
    has, reach = zone(setup.settings), np.array(setup.settings.reach)
    words = f"by the loads found it needs {mm((float(needs[0]), float(needs[1])))}, the patch has {mm(has)}"
    refused, wide = "", max(float(reach[0]), float(needs[0]))
    longer = replace(setup.settings, reach=(wide, askew))
    try:
        if zone(replace(longer, reach=(wide, BEYOND**left * float(reach[1]))))[1] < askew <= zone(longer)[1]:
            return longer, f"{words}, askew {1e3 * askew:.3g} mm along it"
    except ValueError as error:
        refused = f"; a larger one is refused: {error}"
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


def _one(task: Task, number: int, scene: Scene, setup: Setup, sides: tuple[int, ...], step: Step) -> Run:
    """One load case of a prepared geometry; the run carries the name of the task's own scene."""
    from rollbench.hifi.reference import INGREDIENTS, solve_reference

    result = solve_reference(setup, scene, sides=sides, frozen=True, step=step)
    assert result.frozen is not None
    without, seconds = {}, {}
    if task.ablate:
        for name in INGREDIENTS:
            found = solve_reference(setup, scene, sides=sides, leave_out=frozenset([name]))
            without[name], seconds[name] = found.load, found.seconds["contact"]
    step(f"contact loads: {result.seconds['contact']:.1f} s, {scene.name} {result.status}")
    return Run(
        scene=task.scenes[number].name,
        level=task.level,
        variant=task.variant,
        status=result.status,
        moving=result.moving,
        load=result.load,
        angle=np.degrees(result.contact_angle),
        frozen=result.frozen,
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
