"""Computing runs of the 3D reference: one set-up and its load cases, patches enlarged where a contact reaches their rim."""

from __future__ import annotations

import datetime
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from typing import TYPE_CHECKING

import numpy as np

from rollbench.comparison import __version__
from rollbench.comparison.reference.levels import LEVELS
from rollbench.comparison.reference.sets import SetUp, recorded, refused, set_ups
from rollbench.comparison.reference.store import Run, versions
from rollbench.comparison.reference.tasks import Task, needed_sides, settings_of
from rollbench.comparison.reference.variants import VARIANTS
from rollbench.comparison.system import need_reference, out_of_memory
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.cache import StageDone
from rollbench.meshes.condensed import CondensedBodies
from rollbench.meshes.memory import peak_MB
from rollbench.meshes.parts import Scene

if TYPE_CHECKING:
    from rollbench.hifi.meshing.settings import Settings
    from rollbench.hifi.setup import Setup
    from rollbench.hifi.several_sets import AxisReference

Step = Callable[[str], None]

#: How often patches are enlarged where a contact reaches their rim, by what, and in how many such steps at a time at most.
ENLARGE, BEYOND, LARGER = 3, 1.2, 4
#: Share of the length askew that a zone must have: with 0.995 of it, drawn contacts stay off the rim.
ALIKE = 0.99
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

    if task.assemblies:
        return _compute_sets(task, task.assemblies, step), None
    scenes = task.single
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
        larger, why = enlarged(setup, [(runs[k].load, np.radians(runs[k].angle)) for k in full], left)
        if larger is None or attempt == ENLARGE:
            for k in full:
                runs[k] = replace(runs[k], status=f"a contact reaches the rim of its patch: {why}")
            break
        settings = larger
        step(f"a contact reaches the rim of its patch, larger patches: {why}")
    good = all(run.answers for run in runs)
    return runs, condensed_bodies(setup, task.level) if good and with_bodies(task) else None


def _compute_sets(task: Task, assemblies: Sequence[Assembly], step: Step) -> list[Run]:
    """The runs of load cases of several sets on one shaft; patches are enlarged as for one set, those of all sets together.
    Raises Refusal and InputError as `compute_with_bodies`."""
    from rollbench.hifi.reference import AT_RIM
    from rollbench.hifi.setup import prepare
    from rollbench.hifi.several_sets import solve_sets
    from rollbench.meshes.cache import Cache

    ups, names = set_ups(assemblies, task.level), [s.name for s in assemblies[0].sets]
    for attempt in range(ENLARGE + 1):
        by_set: dict[int, Setup] = {}
        try:
            for up in ups:
                step(f"bodies of {', '.join(names[k] for k in up.sets)}")
                setup = prepare(up.bodies, up.sides, up.settings, step, cache=Cache(task.cache), processes=task.processes)
                by_set |= dict.fromkeys(up.sets, setup)
            setups = [by_set[k] for k in range(len(names))]
            sides = [s.sides for s in setups]
            results = [solve_sets(assembly, setups, sides, frozen=True, step=step) for assembly in assemblies]
        except MemoryError as error:
            raise out_of_memory(error) from error
        except ValueError as error:
            raise refused(assemblies[0], error) from error
        full = [result for result in results if result.status == AT_RIM]
        if not full or attempt == ENLARGE:
            break
        larger = []
        for up in ups:
            loads = [result.sets[k] for result in full for k in up.sets]
            settings, why = enlarged(by_set[up.sets[0]], [(s.load, s.angle) for s in loads], max(0, ENLARGE - 1 - attempt))
            larger.append(up if settings is None else replace(up, settings=settings))
        if tuple(larger) == ups:
            results = [replace(r, status=f"{AT_RIM}: {why}") if r.status == AT_RIM else r for r in results]
            break
        ups = tuple(larger)
        step("a contact reaches the rim of its patch, larger patches")
    return [_run_of_sets(task, *pair, setups, ups, step) for pair in zip(assemblies, results, strict=True)]


def _run_of_sets(
    task: Task, assembly: Assembly, result: AxisReference, setups: Sequence[Setup], ups: Sequence[SetUp], step: Step
) -> Run:
    """The run of one load case of several sets."""
    step(StageDone("contact loads", f"{result.seconds:.1f} s, {assembly.name} {result.status}"))
    shared = list({id(s): s for s in setups}.values())
    return Run(
        scene=assembly.name,
        level=task.level,
        variant=task.variant,
        status=result.status,
        moving=result.moving,
        load=np.concatenate([s.load for s in result.sets]),
        angle=np.degrees(np.concatenate([s.angle for s in result.sets])),
        frozen=np.concatenate([s.load if s.frozen is None else s.frozen for s in result.sets]),
        centreline=np.column_stack([result.stations, result.centreline[:, :3]]),
        without={},
        without_seconds={},
        sides=tuple(sorted({side for s in setups for side in s.sides})),
        unknowns=sum(s.unknowns for s in setups),
        stages={name: sum(s.seconds.get(name, 0.0) for s in shared) for name in shared[0].seconds},
        solve_seconds=result.seconds,
        peak_MB=None if (peak := peak_MB()) is None else peak + max(s.others_MB for s in shared),
        balance=result.balance,
        along_groove=result.along_groove,
        screw_balance=result.shaft_balance,
        quality=shared[0].quality | {name: min(s.quality[name] for s in shared) for name in ("screw", "nut", "ball")},
        settings=recorded(ups),
        assumed=tuple(dict.fromkeys(line for s in shared for line in s.dims.assumed)),
        versions={"rollbench": __version__, **versions()},
        date=datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d"),
    )


def enlarged(setup: Setup, contacts: Sequence[tuple[Array, Array]], left: int) -> tuple[Settings | None, str]:
    """Settings with patches for the loads and contact angles ``(n, 4)`` [N, rad] that were found, or None where that
    changes no patch; a text with both numbers.

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
    units = hertz_units(setup.scene)
    for load, touched in contacts:
        size, angle = np.cbrt(load), np.where(load > 0.0, touched, m.beta)
        across, along = (size * np.array([getattr(unit, name) for unit in units]) for name in ("semi_x", "semi_y"))
        needs = np.maximum(needs, [float((across + np.abs(angle - m.beta) * m.radius).max()), float(along.max())])
        askew = max(askew, *(reach_along(m, s, angle[:, s], across[:, s], along[:, s]) for s in setup.sides))
    has, reach = zone(setup.settings), np.array(setup.settings.reach)
    words = f"by the loads found it needs {mm((float(needs[0]), float(needs[1])))}, the patch has {mm(has)}"
    refused, wide = "", max(float(reach[0]), float(needs[0]))
    longer = replace(setup.settings, reach=(wide, askew))
    try:
        last = BEYOND**left * max(float(reach[1]), float(needs[1]) / BEYOND if left else 0.0)
        if zone(replace(longer, reach=(wide, last)))[1] < ALIKE * askew <= zone(longer)[1]:
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
    return None, words + (refused or ", as much as there is room for; lower the load, or make more room around the contact")


def with_bodies(task: Task) -> bool:
    """Whether a task also stores its bodies, condensed to the contacts: one set, base variant on a regular mesh level."""
    return not task.assemblies and not task.variant and task.level in LEVELS


def _one(task: Task, number: int, scene: Scene, setup: Setup, sides: tuple[int, ...], step: Step) -> Run:
    """One load case of a prepared geometry; the run carries the name of the task's own scene."""
    from rollbench.hifi.reference import INGREDIENTS, solve_reference

    result = solve_reference(setup, scene, sides=sides, frozen=True, step=step)
    assert result.frozen is not None
    without, seconds = {}, {}
    if task.ablate:
        for name in INGREDIENTS:
            ablated = solve_reference(setup, scene, sides=sides, leave_out=frozenset([name]))
            without[name], seconds[name] = ablated.load, ablated.seconds["contact"]
    step(StageDone("contact loads", f"{result.seconds['contact']:.1f} s, {scene.name} {result.status}"))
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
        peak_MB=None if (peak := peak_MB()) is None else peak + setup.others_MB,
        balance=result.balance,
        along_groove=result.along_groove,
        screw_balance=result.screw_balance,
        quality=setup.quality,
        settings=asdict(setup.settings) | {"stations": _stations(task.single)},
        assumed=setup.dims.assumed,
        versions={"rollbench": __version__, **versions()},
        date=datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d"),
    )


def _stations(scenes: Sequence[Scene]) -> tuple[float, ...]:
    """Stations of supports and loads [m] of all scenes that share a set-up: its shaft has freedoms there."""
    return tuple(sorted({z for scene in scenes for z in scene.stations}))
