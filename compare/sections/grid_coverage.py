"""Whether bars of discretisation hold what a finer level finds: every scene by what its own coarser levels and all other
scenes tell.

A scene's experience (`compare.reference.grid_parts`) is taken again without it and without the scenes of its parts. Drawn
screws (chosen and computed by ``tests/judging_levels.py``), and levels beyond those that are studied, are kept as loads
alone: they judge, and are nobody's reference.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from rollbench.compare.measure import error_percent
from rollbench.compare.models.comparison import REFERENCED
from rollbench.compare.models.modelling import REFINED, SPOKEN_FOR, UNSEEN, base_run
from rollbench.compare.models.study import Study
from rollbench.compare.reference.grid_parts import Experience, Levelled, measured, moving, parts
from rollbench.compare.reference.levels import LEVELS, PRODUCTION
from rollbench.compare.reference.near_face import left_out, too_large
from rollbench.compare.reference.store import load, shipped_store
from rollbench.compare.scenes import scene_file
from rollbench.meshes.arrays import Array
from rollbench.meshes.loads import mean_load
from rollbench.meshes.parts import Scene

#: Loads by level of drawn screws and of further levels of shipped scenes, beside the stored runs.
JUDGES = "judging_levels.json"
#: Its key of a drawn scene's text.
SCENE = "scene"
#: The variant that cuts the coarse sockets finer.
SOCKETS = "finer-sockets"
#: Scenes that another program solved as well, and those that have two levels.
CHECKED = ("two-balls", "lin-case1-cut")
COARSE = ("liu-screw", "liu-drawn", "liu-small", "liu-drawn-1kN")
#: Shipped scenes that are compared.
SHIPPED = tuple(dict.fromkeys((*REFERENCED, *CHECKED, *UNSEEN, *COARSE)))
#: Contacts from which on a scene's own coverage says something.
MANY = 40


@dataclass(frozen=True)
class Held:
    """Of one scene: level whose bars are judged (with those before it) and level that judges; contacts that carry load; the
    bar, RMS over them [% of the mean load], and how many are within theirs; whether the scene was drawn."""

    scene: str
    level: int
    judge: int
    contacts: int
    bar: float
    held: int
    drawn: bool

    @property
    def share(self) -> float:
        """Share of contacts within the bar."""
        return self.held / self.contacts


@cache
def judges(store: Path) -> tuple[dict[str, dict[int, Array]], dict[str, Scene]]:
    """Loads ``(n, 4)`` [N] by level that a store keeps only to judge by, and the drawn scenes; empty without a record."""
    path = store / JUDGES
    data = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    drawn = {name: scene_file.loads(record.pop(SCENE), f"{name}.toml") for name, record in data.items() if SCENE in record}
    return {name: {int(k): np.array(rows, float) for k, rows in by_level.items()} for name, by_level in data.items()}, drawn


def levelled(study: Study) -> dict[str, dict[int, Array]]:
    """Loads ``(n, 4)`` [N] by level of every compared scene that a store holds on two levels or more, drawn ones last."""
    out, extra = {}, dict(judges(shipped_store())[0])
    for name in SHIPPED:
        runs = [run for k in LEVELS if (run := load(study.scene(name), k, stores=study.stores)) is not None]
        if len(runs) > 1:
            out[name] = {run.level: run.load for run in runs} | extra.pop(name, {})
    return out | extra


def socket_scatter(study: Study) -> float | None:
    """Standard deviation [% of the mean load] that the cut of the coarse sockets leaves: a change of it alone is the
    difference of two of its errors. None without the run."""
    scene = study.scene(REFINED)
    finer, base = load(scene, PRODUCTION, SOCKETS, study.stores), base_run(scene, PRODUCTION, study.stores)
    if finer is None or base is None:
        return None
    on = base.load > 0.0
    change = error_percent(finer.load[on], base.load[on], mean_load(base.load))
    return float(np.sqrt((change**2).mean() / 2.0))


def experience(study: Study) -> Experience | None:
    """What all compared scenes of a store tell; None where it does not hold them."""
    loads, sockets = levelled(study), socket_scatter(study)
    return None if sockets is None or len(loads) < len(UNSEEN) else measured(loads, sockets, study.once(_beside_faces))


def _scene(study: Study, name: str) -> Scene:
    """A compared scene, shipped or drawn."""
    return judges(shipped_store())[1].get(name) or study.scene(name)


def _beside_faces(study: Study) -> dict[str, Array]:
    """Of every compared scene that has level 1, what this leaves out beside free faces ``(n, 4)`` [% of the mean load]."""
    first = min(LEVELS)
    return {
        name: error_percent(left_out(_scene(study, name), loads[first], first), 0.0, mean_load(loads[max(loads)]))
        for name, loads in levelled(study).items()
        if first in loads
    }


def coverage(study: Study) -> list[Held]:
    """Every compared scene, level by level, against its finest; empty where a store does not hold what is needed."""
    return study.once(_coverage)


def coverage_of(study: Study, levels: tuple[int, ...]) -> list[Held]:
    """Every compared scene that has these levels and a finer one, by these only, against its finest."""
    return _judged(study, lambda loads: [levels] if set(levels) <= set(loads) and max(levels) < max(loads) else [])


def _coverage(study: Study) -> list[Held]:
    return _judged(study, lambda loads: [tuple(sorted(loads)[:k]) for k in range(1, len(loads))])


def _judged(study: Study, choose: Callable[[Levelled], list[tuple[int, ...]]]) -> list[Held]:
    """Bars of all scenes by the sets of levels that are chosen from those that each has."""
    scenes, sockets = levelled(study), socket_scatter(study)
    if sockets is None or len(scenes) < len(UNSEEN):
        return []
    beside = study.once(_beside_faces)
    return [
        _held(_scene(study, name), levels, scenes, sockets, beside)
        for name, loads in scenes.items()
        for levels in choose(loads)
    ]


def _held(
    scene: Scene, levels: tuple[int, ...], scenes: Mapping[str, Levelled], sockets: float, beside: Mapping[str, Array]
) -> Held:
    name, level = scene.name, max(levels)
    family = SPOKEN_FOR.get(name, name)
    others = {other: by_level for other, by_level in scenes.items() if SPOKEN_FOR.get(other, other) != family}
    known = measured(others, sockets, beside)
    loads, judge = scenes[name], max(scenes[name])
    on, mean = moving(loads), mean_load(loads[judge])
    coarser = {k: loads[k] for k in levels}
    grid, off = parts(coarser, known), np.abs(error_percent(loads[level][on], loads[judge][on], mean))
    beside_faces = left_out if grid.by_experience else too_large
    bars = grid.bars(coarser) + error_percent(beside_faces(scene, loads[level], level), 0.0, mean)
    return Held(name, level, judge, int(on.sum()), grid.bar, int((off <= bars[on]).sum()), name not in SHIPPED)


def share_of(rows: Sequence[Held]) -> float:
    """Share of all contacts within their bars."""
    return sum(h.held for h in rows) / sum(h.contacts for h in rows)
