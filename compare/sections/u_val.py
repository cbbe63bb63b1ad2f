"""Section on validation uncertainty: error against u_val, bias and scatter of every model, and how often bounds held.

Discretisation uncertainties are tested by finer levels. The uncertainty of a scene follows from its coarser levels
and from the experience with all other scenes (`compare.reference.grid_parts`); for the test this experience is
derived again without the scene, and without scenes that share its parts. Drawn screws (chosen and computed by
``tests/judging_levels.py``), and levels beyond those that are studied, are stored as loads only: they are used for
tests, not as reference.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from rollbench.compare.measure import error_percent
from rollbench.compare.models.comparison import REFERENCED, from_result
from rollbench.compare.models.model_form import SHARE
from rollbench.compare.models.modelling import REFINED, RUNGS, SPOKEN_FOR, UNSEEN, Rung, base_run, ladder, left_out_one
from rollbench.compare.models.registry import DEFAULT
from rollbench.compare.models.study import Study
from rollbench.compare.models.uncertainty import (
    CONTACTS,
    INPUTS,
    QUANTITIES,
    Scatter,
    Validated,
    bound_shares,
    scatter,
    validated_error,
)
from rollbench.compare.reference.grid_parts import (
    Experience,
    Levelled,
    derive_experience,
    error_near_faces,
    excess_near_faces,
    loaded_on_any_level,
    parts,
)
from rollbench.compare.reference.levels import LEVELS, PRODUCTION
from rollbench.compare.reference.store import load_run, shipped_store
from rollbench.compare.scenes import scene_file
from rollbench.compare.sections.fit import range_items
from rollbench.meshes.arrays import Array
from rollbench.meshes.loads import mean_load
from rollbench.meshes.parts import Scene
from rollbench.reports.content import Figure, Panel, Quantity, Row, Section, Series, Table, Text

#: Loads by level of drawn screws and of further levels of shipped scenes, beside the stored runs.
JUDGES = "judging_levels.json"

#: Key of the text of a drawn scene in that file.
SCENE = "scene"

#: The variant that cuts the coarse sockets finer.
SOCKETS = "finer-sockets"

#: Scenes that another program solved too, and those with two levels.
CHECKED = ("two-balls", "lin-case1-cut")

COARSE = ("liu-screw", "liu-drawn", "liu-small", "liu-drawn-1kN")

#: Shipped scenes that are compared.
SHIPPED = tuple(dict.fromkeys((*REFERENCED, *CHECKED, *UNSEEN, *COARSE)))

#: Number of contacts from which on the coverage of a single scene is meaningful.
MANY = 40


@dataclass(frozen=True)
class Held:
    """Test of the uncertainty of one level of one scene by a finer level."""

    #: Name of the scene.
    scene: str
    #: Level whose uncertainty is tested (with those before it).
    level: int
    #: Level that tests it.
    judge: int
    #: Number of loaded contacts.
    contacts: int
    #: Uncertainty, RMS over them [% of the mean load].
    bar: float
    #: Number of contacts within their uncertainty.
    held: int
    #: Whether the scene was drawn.
    drawn: bool

    @property
    def share(self) -> float:
        """Share of contacts within the uncertainty."""
        return self.held / self.contacts


@cache
def judges(store: Path) -> tuple[dict[str, dict[int, Array]], dict[str, Scene]]:
    """Return loads (n, 4) [N] by level that a store keeps for tests only, and the drawn scenes; empty if no file."""
    path = store / JUDGES
    data = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    drawn = {
        name: scene_file.scene_of_text(record.pop(SCENE), f"{name}.toml")
        for name, record in data.items()
        if SCENE in record
    }
    return {name: {int(k): np.array(rows, float) for k, rows in by_level.items()} for name, by_level in data.items()}, drawn


def levelled(study: Study) -> dict[str, dict[int, Array]]:
    """Return the loads (n, 4) [N] by level of every compared scene with two levels or more, drawn ones last."""
    out, extra = {}, dict(judges(shipped_store())[0])
    for name in SHIPPED:
        runs = [run for k in LEVELS if (run := load_run(study.scene(name), k, stores=study.stores)) is not None]
        if len(runs) > 1:
            out[name] = {run.level: run.load for run in runs} | extra.pop(name, {})
    return out | extra


def socket_scatter(study: Study) -> float | None:
    """Return the standard deviation of contact loads by the coarse sockets' cut [% of mean load]; None without runs.

    The difference of two cuts contains two such errors, hence the division by the root of two.
    """
    scene = study.scene(REFINED)
    finer, base = load_run(scene, PRODUCTION, SOCKETS, study.stores), base_run(scene, PRODUCTION, study.stores)
    if finer is None or base is None:
        return None
    on = base.load > 0.0
    change = error_percent(finer.load[on], base.load[on], mean_load(base.load))
    return float(np.sqrt((change**2).mean() / 2.0))


def experience(study: Study) -> Experience | None:
    """Return the experience from all compared scenes of a store; None if it does not hold them."""
    loads, sockets = levelled(study), socket_scatter(study)
    return (
        None
        if sockets is None or len(loads) < len(UNSEEN)
        else derive_experience(loads, sockets, study.once(_beside_faces))
    )


def _scene(study: Study, name: str) -> Scene:
    """Return a compared scene, shipped or drawn."""
    return judges(shipped_store())[1].get(name) or study.scene(name)


def _beside_faces(study: Study) -> dict[str, Array]:
    """Return the errors of level 1 near free faces, (n, 4) [% of the mean load], by compared scene."""
    first = min(LEVELS)
    return {
        name: error_percent(error_near_faces(_scene(study, name), loads[first], first), 0.0, mean_load(loads[max(loads)]))
        for name, loads in levelled(study).items()
        if first in loads
    }


def coverage(study: Study) -> list[Held]:
    """Test the uncertainty of every level of every compared scene by its finest level; empty if data are missing."""
    return study.once(_coverage)


def coverage_of(study: Study, levels: tuple[int, ...]) -> list[Held]:
    """Test the uncertainty that given levels alone state, on every compared scene that has them and a finer one."""
    return _judged(study, lambda loads: [levels] if set(levels) <= set(loads) and max(levels) < max(loads) else [])


def _coverage(study: Study) -> list[Held]:
    """Test every scene by its first level, its first two levels, and so on."""
    return _judged(study, lambda loads: [tuple(sorted(loads)[:k]) for k in range(1, len(loads))])


def _judged(study: Study, choose: Callable[[Levelled], list[tuple[int, ...]]]) -> list[Held]:
    """Test the uncertainties of all scenes; ``choose`` returns the sets of levels to test from a scene's loads."""
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
    """Test one scene's uncertainty by its finest level, with experience from the other scenes."""
    name, level = scene.name, max(levels)
    family = SPOKEN_FOR.get(name, name)
    others = {other: by_level for other, by_level in scenes.items() if SPOKEN_FOR.get(other, other) != family}
    known = derive_experience(others, sockets, beside)
    loads, judge = scenes[name], max(scenes[name])
    on, mean = loaded_on_any_level(loads), mean_load(loads[judge])
    coarser = {k: loads[k] for k in levels}
    grid, off = parts(coarser, known), np.abs(error_percent(loads[level][on], loads[judge][on], mean))
    beside_faces = error_near_faces if grid.by_experience else excess_near_faces
    bars = grid.bars(coarser) + error_percent(beside_faces(scene, loads[level], level), 0.0, mean)
    return Held(name, level, judge, int(on.sum()), grid.bar, int((off <= bars[on]).sum()), name not in SHIPPED)


def share_of(rows: Sequence[Held]) -> float:
    """Return the share of contacts whose error is within the stated uncertainty."""
    return sum(h.held for h in rows) / sum(h.contacts for h in rows)


#: Models whose rows are shown scene by scene; bias and scatter are of every one on the ladder.
SHOWN = (DEFAULT, "lin")


def rows_of(study: Study, rungs: Sequence[Rung]) -> list[Validated]:
    """Return the validation results of every model of the ladder, by scene and quantity."""
    found = [validated_error(study, r.scene, r.model, q, from_result(r.result)) for r in rungs for q in QUANTITIES]
    return [row for row in found if row is not None]


def u_val_table(rows: Sequence[Validated]) -> Table:
    """Return error and u_val by scene and quantity."""
    cells: list[Row] = []
    for row in rows:
        if row.model not in SHOWN:
            continue
        beyond = abs(row.error) > row.combined
        cells.append(
            {
                "scene": row.scene,
                "quantity": row.quantity,
                "model": row.model,
                Quantity("error", "error E", "%", "+.2f"): row.error,
                Quantity("grid", "grid", "%", ".2f"): row.grid,
                Quantity("choices", "modelling choices", "%", ".2f"): row.choices,
                Quantity("inputs", "input tolerances", "%", ".2f"): row.inputs,
                Quantity("u_val", "u_val", "%", ".2f"): row.combined,
                Quantity("says", "what E says", "", "s"): "E ± u_val is the model's" if beyond else "not told from u_val",
                Quantity("within", "values within u_val", "%", ".0f"): 100.0 * row.within,
                Quantity("varied", "choices varied on", "", "s"): row.varied or "–",
            }
        )
    note = (
        f"Of {CONTACTS}: the contact with the largest error, in per cent of the mean load; other quantities "
        "in per cent of the reference's value. Input tolerances are assumed: "
        f"{'; '.join(x.name for x in INPUTS)}; each is varied by itself, with the model lin. Choices were "
        "varied on two scenes; where the last column names another scene, its largest effect is used. As in "
        "ASME V&V 20, the parts are combined by the root of the sum of squares; nothing is deducted from an "
        "error."
    )
    return Table.of(
        "u-val", "Error of the models and uncertainty of the 3D reference, for each scene and quantity", cells, note
    )


def scatter_table(found: Sequence[Scatter]) -> Table:
    """Return the table of bias and scatter by model and quantity."""
    cells: list[Row] = [
        {
            "model": s.model,
            "quantity": s.quantity,
            Quantity("scenes", "scenes", "", "g4"): s.scenes,
            Quantity("values", "values", "", "g4"): s.values,
            Quantity("bias", "bias", "%", "+.2f"): s.bias,
            Quantity("scatter", "scatter", "%", ".2f"): s.scatter,
            Quantity("within", "within u_val", "%", ".0f"): 100.0 * s.within,
            Quantity("within_own", "within grid and choices", "%", ".0f"): 100.0 * s.within_own,
        }
        for s in found
    ]
    note = (
        "Bias: relative deviation of the model from the reference, geometric mean. Scatter: relative "
        "standard deviation of the model without that of the grid. All scenes with a reference, contacts "
        "above a tenth of the mean load."
    )
    return Table.of("bias-scatter", "Mean error (bias) and its scatter for each model", cells, note)


def scatter_figure(found: Sequence[Scatter]) -> Figure:
    """Draw bias with scatter model by model, a panel for each quantity."""
    panels = []
    order = [m.name for m in RUNGS]
    for quantity in dict.fromkeys(s.quantity for s in found):
        of_quantity = [s for s in found if s.quantity == quantity]
        x = [float(order.index(s.model) + 1) for s in of_quantity]
        ends = ([s.bias - 2.0 * s.scatter for s in of_quantity], [s.bias + 2.0 * s.scatter for s in of_quantity])
        series = (
            Series("bias and two scatters", x, [s.bias for s in of_quantity], "markers", emphasis=True, bars=ends),
            Series("none", [min(x), max(x)], [0.0, 0.0], "line"),
        )
        panels.append(Panel(quantity, "", "relative deviation from the reference / %", series, names=order))
    return Figure("bias-scatter", "Mean error (bias) and its scatter for each model", tuple(panels))


def bounds_table(study: Study, rungs: Sequence[Rung]) -> Table:
    """Return the table of stated error bounds and how often they were kept."""
    rows = left_out_one(study, rungs)
    counts = [
        (f"largest error to expect, model {name}, scene left out", held, total)
        for name, (held, total) in bound_shares(rows).items()
    ]
    bars = [h for h in coverage(study) if h.level > min(LEVELS)]
    if bars:
        words = (
            f"discretisation of coarser levels, against the finest, contact loads of {len({h.scene for h in bars})} scenes"
        )
        counts.append((words, sum(h.held for h in bars), sum(h.contacts for h in bars)))
    cells: list[Row] = [
        {
            Quantity("bound", "stated bound", "", "s"): words,
            Quantity("share", "held", "", "s"): f"{held} of {total}",
            Quantity("part", "share", "%", ".0f"): 100.0 * held / (total or 1),
        }
        for words, held, total in counts
    ]
    note = (
        f"Expected errors are set so that each holds {SHARE:.0%} of the other scenes, which promises nothing for a new "
        "one: the count is what is known. A bar of discretisation is one of 95 % and should hold 19 times in 20."
    )
    return Table.of("bounds-held", "Stated bounds, and how many held", cells, note)


def make_section(study: Study, step: Callable[[str], None]) -> Section:
    """Return the section of the report."""
    title = "Bias, scatter and uncertainty of the models"
    step("every rung on every scene with a reference")
    rungs = study.once(ladder)
    if not rungs:
        return Section("u-val", title, (Text(("No run of the 3D reference was found.",)),))
    step("grid, choices and input tolerances of every scene")
    rows = rows_of(study, rungs)
    found = scatter(rows)
    of_loads = {s.model: s for s in found if s.quantity == CONTACTS}
    words = [
        f"{name}: contact loads {s.bias:+.2f} % on average, scatter {s.scatter:.2f} %, {100.0 * s.within:.0f} % of them "
        f"within u_val and {100.0 * s.within_own:.0f} % within the reference's own part of it"
        for name, s in of_loads.items()
        if name in (*SHOWN, "condensed")
    ]
    text = (
        (
            "An error against the reference counts as the model's only as far as it exceeds what the reference, "
            "its choices and the inputs leave open. The three stand beside every error here, combined by the "
            "root of the sum of squares."
        ),
        f"{'; '.join(words)}.",
    )
    items: tuple[Text | Figure | Table, ...] = (
        Text(text),
        u_val_table(rows),
        scatter_table(found),
        scatter_figure(found),
        bounds_table(study, rungs),
        *range_items(study),
    )
    stated = [
        f"{name} {s.bias:+.1f} % with a scatter of {s.scatter:.1f} %" for name, s in of_loads.items() if name in SHOWN
    ]
    conclusion = f"Contact loads are off on average by: {', '.join(stated)}." if stated else ""
    return Section("u-val", title, items, conclusion=conclusion)
