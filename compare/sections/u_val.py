"""Report section on validation uncertainty: errors of the models, their bias and scatter, and tests of error bounds.

u_val is the validation uncertainty of ASME V&V 20: mesh, modelling choices and input tolerances combined. The mesh
uncertainty of a coarse mesh level is tested by the loads on a finer level. This uncertainty is estimated from the scene's
own mesh levels and from data of all other scenes (`compare.reference.estimate`); for the test, these data are derived
without the scene and without scenes that share its parts. Of randomly drawn screws (chosen and computed by
``tests/judging_levels.py``), and of levels finer than those of the mesh study, only loads are stored, for these tests.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from rollbench.compare.measure import error_percent, mean_load
from rollbench.compare.models.comparison import REFERENCED, loads_from_result
from rollbench.compare.models.model_form import SHARE
from rollbench.compare.models.modelling import (
    REFINED,
    RUNGS,
    SPOKEN_FOR,
    UNSEEN,
    Rung,
    ladder,
    leave_one_out_rows,
    unchanged_run,
)
from rollbench.compare.models.registry import DEFAULT
from rollbench.compare.models.study import Study
from rollbench.compare.models.uncertainty import (
    CONTACTS,
    INPUTS,
    QUANTITIES,
    Scatter,
    Validated,
    bias_and_scatter,
    count_within_expected_error,
    validated_error,
)
from rollbench.compare.reference.estimate import (
    Experience,
    Levelled,
    derive_experience,
    error_near_faces,
    excess_near_faces,
    loaded_on_any_level,
    mesh_uncertainty,
)
from rollbench.compare.reference.levels import LEVELS, PRODUCTION
from rollbench.compare.reference.store import load_run, shipped_store
from rollbench.compare.scenes import scene_file
from rollbench.compare.sections.fit import validated_range_items
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import Scene
from rollbench.reports.content import Figure, Panel, Quantity, Row, Section, Series, Table, Text

#: File with contact loads that are used for tests only: of randomly drawn screws, and of further mesh levels of shipped
#: scenes.
JUDGES = "judging_levels.json"

#: Key under which the file `JUDGES` has the TOML text of a randomly drawn scene.
SCENE = "scene"

#: Name of the variant of the 3D reference whose coarse meshes have finer cut-outs (sockets) for the fine contact patches.
SOCKETS = "finer-sockets"

#: Scenes that were also solved by another program.
CHECKED = ("two-balls", "lin-case1-cut")

#: Scenes that were solved in 3D on only two mesh levels.

COARSE = ("liu-screw", "liu-drawn", "liu-small", "liu-drawn-1kN")

#: Shipped scenes whose mesh levels are compared with each other.
SHIPPED = tuple(dict.fromkeys((*REFERENCED, *CHECKED, *UNSEEN, *COARSE)))

#: Least number of contacts for which the share of loads within their uncertainty is meaningful for a single scene.
MANY = 40


@dataclass(frozen=True)
class UncertaintyTest:
    """Test of the mesh uncertainty that is stated for the contact loads of one scene on one mesh level.

    The test counts the contacts whose load on a finer mesh level differs by less than the stated uncertainty.
    """

    #: Name of the scene.
    scene: str
    #: Finest mesh level among those from which the tested uncertainty was estimated.
    level: int
    #: Finer mesh level, whose loads test the uncertainty.
    judge: int
    #: Number of loaded contacts.
    contacts: int
    #: Tested uncertainty, as RMS over the loaded contacts [% of the mean load].
    bar: float
    #: Number of contacts whose load on the finer level differs by less than its uncertainty.
    held: int
    #: Whether the scene is a randomly drawn screw; if not, it comes with rollbench.
    drawn: bool

    @property
    def share(self) -> float:
        """Share (0 to 1) of contacts whose load differs from that on the finer level by less than its uncertainty."""
        return self.held / self.contacts


@cache
def stored_loads_and_scenes_for_tests(store: Path) -> tuple[dict[str, dict[int, Array]], dict[str, Scene]]:
    """Return contact loads that are stored only to test the mesh uncertainty, and the randomly drawn scenes among them.

    ``store``: folder with the file `JUDGES`. First result: loads of n balls on the four flanks, (n, 4) [N], by name of the
    scene, then by mesh level. Second result: the randomly drawn scenes by name. Both are empty if there is no such file.
    """
    path = store / JUDGES
    data = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    drawn = {
        name: scene_file.scene_from_text(record.pop(SCENE), f"{name}.toml")
        for name, record in data.items()
        if SCENE in record
    }
    return {name: {int(k): np.array(rows, float) for k, rows in by_level.items()} for name, by_level in data.items()}, drawn


def loads_by_scene_and_level(study: Study) -> dict[str, dict[int, Array]]:
    """Return the contact loads (n, 4) [N] of every compared scene with at least two mesh levels, by scene and level.

    Randomly drawn scenes come last.
    """
    out, extra = {}, dict(stored_loads_and_scenes_for_tests(shipped_store())[0])
    for name in SHIPPED:
        runs = [run for k in LEVELS if (run := load_run(study.scene(name), k, stores=study.stores)) is not None]
        if len(runs) > 1:
            out[name] = {run.level: run.load for run in runs} | extra.pop(name, {})
    return out | extra


def load_scatter_by_sockets(study: Study) -> float | None:
    """Return the standard deviation of contact loads due to the size of the cut-outs for fine patches [% of the mean load].

    It follows from two 3D runs with cut-outs of different size. Their difference contains two such errors, hence the
    division by the root of two. Returns None if the runs are not stored.
    """
    scene = study.scene(REFINED)
    finer, base = load_run(scene, PRODUCTION, SOCKETS, study.stores), unchanged_run(scene, PRODUCTION, study.stores)
    if finer is None or base is None:
        return None
    on = base.load > 0.0
    change = error_percent(finer.load[on], base.load[on], mean_load(base.load))
    return float(np.sqrt((change**2).mean() / 2.0))


def uncertainty_parameters(study: Study) -> Experience | None:
    """Return the parameters of the mesh uncertainty that follow from the mesh levels of all compared scenes together.

    They give the contributions to the uncertainty that the mesh levels of a single scene do not show. Returns None if 3D
    runs are missing.
    """
    loads, sockets = loads_by_scene_and_level(study), load_scatter_by_sockets(study)
    return (
        None
        if sockets is None or len(loads) < len(UNSEEN)
        else derive_experience(loads, sockets, study.compute_once(_errors_near_faces))
    )


def _shipped_or_drawn_scene(study: Study, name: str) -> Scene:
    """Return the scene called ``name``: a scene that comes with rollbench, or a randomly drawn screw with stored loads."""
    return stored_loads_and_scenes_for_tests(shipped_store())[1].get(name) or study.scene(name)


def _errors_near_faces(study: Study) -> dict[str, Array]:
    """Return the largest errors of contact loads on mesh level 1 due to free faces of the nut, by name of the scene.

    ``study``: has the scenes and stored runs. The errors are (n, 4) [% of the mean load], for n balls on the four flanks.
    """
    first = min(LEVELS)
    return {
        name: error_percent(
            error_near_faces(_shipped_or_drawn_scene(study, name), loads[first], first), 0.0, mean_load(loads[max(loads)])
        )
        for name, loads in loads_by_scene_and_level(study).items()
        if first in loads
    }


def test_all_mesh_levels(study: Study) -> list[UncertaintyTest]:
    """Test the mesh uncertainty of every coarser mesh level of every compared scene by the loads on its finest level.

    Returns an empty list if 3D runs are missing.
    """
    return study.compute_once(_compute_level_tests)


def test_given_mesh_levels(study: Study, levels: tuple[int, ...]) -> list[UncertaintyTest]:
    """Test, for each scene, the mesh uncertainty estimated from given mesh levels by the loads on its finest level.

    ``levels``: the given mesh levels. Scenes that were solved on these levels and on a finer one are tested.
    """
    return _test_uncertainty_of_scenes(
        study, lambda loads: [levels] if set(levels) <= set(loads) and max(levels) < max(loads) else []
    )


def _compute_level_tests(study: Study) -> list[UncertaintyTest]:
    """Test the mesh uncertainty of every scene as estimated from its coarsest level, its two coarsest levels, and so on."""
    return _test_uncertainty_of_scenes(study, lambda loads: [tuple(sorted(loads)[:k]) for k in range(1, len(loads))])


def _test_uncertainty_of_scenes(study: Study, choose: Callable[[Levelled], list[tuple[int, ...]]]) -> list[UncertaintyTest]:
    """Test mesh uncertainties of all scenes by the contact loads on the finest mesh level of each scene.

    ``choose``: function of a scene's contact loads by mesh level; it returns the groups of levels from each of which an
    uncertainty is estimated and tested. Returns an empty list if 3D runs are missing.
    """
    scenes, sockets = loads_by_scene_and_level(study), load_scatter_by_sockets(study)
    if sockets is None or len(scenes) < len(UNSEEN):
        return []
    beside = study.compute_once(_errors_near_faces)
    return [
        _test_uncertainty_of_scene(_shipped_or_drawn_scene(study, name), levels, scenes, sockets, beside)
        for name, loads in scenes.items()
        for levels in choose(loads)
    ]


def _test_uncertainty_of_scene(
    scene: Scene,
    levels: tuple[int, ...],
    loads_by_scene: Mapping[str, Levelled],
    sockets: float,
    errors_by_scene_near_faces: Mapping[str, Array],
) -> UncertaintyTest:
    """Test the mesh uncertainty of one scene by the loads on its finest level.

    The parameters of the uncertainty are derived without this scene and without scenes that share its parts.

    Parameters
    ----------
    scene
        Scene that is tested.
    levels
        Mesh levels from which the tested uncertainty is estimated.
    loads_by_scene
        Contact loads (n, 4) [N] of all scenes, by name of the scene and mesh level.
    sockets
        Standard deviation of contact loads due to the cut-outs for the fine patches [% of the mean load].
    errors_by_scene_near_faces
        Errors of contact loads near free nut faces on level 1, (n, 4) [% of the mean load], by name of the scene.
    """
    name, level = scene.name, max(levels)
    family = SPOKEN_FOR.get(name, name)
    others = {other: by_level for other, by_level in loads_by_scene.items() if SPOKEN_FOR.get(other, other) != family}
    known = derive_experience(others, sockets, errors_by_scene_near_faces)
    loads, judge = loads_by_scene[name], max(loads_by_scene[name])
    on, mean = loaded_on_any_level(loads), mean_load(loads[judge])
    coarser = {k: loads[k] for k in levels}
    grid, off = mesh_uncertainty(coarser, known), np.abs(error_percent(loads[level][on], loads[judge][on], mean))
    beside_faces = error_near_faces if grid.by_experience else excess_near_faces
    bars = grid.bars(coarser) + error_percent(beside_faces(scene, loads[level], level), 0.0, mean)
    return UncertaintyTest(name, level, judge, int(on.sum()), grid.bar, int((off <= bars[on]).sum()), name not in SHIPPED)


def share_of_covered_contacts(rows: Sequence[UncertaintyTest]) -> float:
    """Return the share (0 to 1) of contacts, over several tests, whose load on a finer mesh is within its uncertainty.

    ``rows``: the tests, each of one scene and mesh level.
    """
    return sum(h.held for h in rows) / sum(h.contacts for h in rows)


#: Models whose errors are shown for each scene; bias and scatter are shown for all models of the section "ladder".
SHOWN = (DEFAULT, "lin")


def validated_errors_of_models(study: Study, rungs: Sequence[Rung]) -> list[Validated]:
    """Return the error of every model, with its validation uncertainty u_val, for each scene and quantity.

    ``rungs``: solution of each scene by each low-order model.
    """
    found = [validated_error(study, r.scene, r.model, q, loads_from_result(r.result)) for r in rungs for q in QUANTITIES]
    return [row for row in found if row is not None]


def u_val_table(rows: Sequence[Validated]) -> Table:
    """Return the table of the errors of the models in `SHOWN`, with u_val, for each scene and quantity.

    ``rows``: error and uncertainty by scene, model and quantity.
    """
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
                Quantity("grid", "uncertainty by mesh", "%", ".2f"): row.grid,
                Quantity("choices", "by modelling choices", "%", ".2f"): row.choices,
                Quantity("inputs", "by input tolerances", "%", ".2f"): row.inputs,
                Quantity("u_val", "u_val", "%", ".2f"): row.combined,
                Quantity("says", "conclusion", "", "s"): "error of the model, E ± u_val" if beyond else "E within u_val",
                Quantity("within", "values within u_val", "%", ".0f"): 100.0 * row.within,
                Quantity("varied", "scene on which choices were varied", "", "s"): row.varied or "–",
            }
        )
    note = (
        f"For {CONTACTS}: the contact with the largest error, in per cent of the mean load; for other quantities "
        "in per cent of the value by the 3D reference. Input tolerances are assumed: "
        f"{'; '.join(x.name for x in INPUTS)}; each is varied alone, with the model lin. Modelling choices were varied on "
        "two scenes; if the last column names another scene, the largest effect there is used. As in ASME V&V 20, the "
        "uncertainties are combined by the root of the sum of squares; they are not subtracted from an error."
    )
    return Table.of("u-val", "Error of each model and uncertainty of this error, for each scene and quantity", cells, note)


def bias_and_scatter_table(found: Sequence[Scatter]) -> Table:
    """Return the table of bias and scatter of the errors, for each model and quantity, over all scenes.

    ``found``: bias and scatter by model and quantity.
    """
    cells: list[Row] = [
        {
            "model": s.model,
            "quantity": s.quantity,
            Quantity("scenes", "scenes", "", "g4"): s.scenes,
            Quantity("values", "values", "", "g4"): s.values,
            Quantity("bias", "bias", "%", "+.2f"): s.bias,
            Quantity("scatter", "scatter", "%", ".2f"): s.scatter,
            Quantity("within", "values within u_val", "%", ".0f"): 100.0 * s.within,
            Quantity("within_own", "values within uncertainty by mesh and choices", "%", ".0f"): 100.0 * s.within_own,
        }
        for s in found
    ]
    note = (
        "Bias: geometric mean of the relative deviation of the model from the 3D reference. Scatter: relative standard "
        "deviation of the model, after subtraction of the variance by the mesh of the reference. All scenes with a 3D "
        "reference; contacts above a tenth of the mean load."
    )
    return Table.of(
        "bias-scatter", "Mean error (bias) of each model against the 3D reference, and its scatter", cells, note
    )


def bias_and_scatter_figure(found: Sequence[Scatter]) -> Figure:
    """Draw the mean error (bias) of each model with bars of two standard deviations, in a panel for each quantity.

    ``found``: bias and scatter by model and quantity.
    """
    panels = []
    order = [m.name for m in RUNGS]
    for quantity in dict.fromkeys(s.quantity for s in found):
        of_quantity = [s for s in found if s.quantity == quantity]
        x = [float(order.index(s.model) + 1) for s in of_quantity]
        ends = ([s.bias - 2.0 * s.scatter for s in of_quantity], [s.bias + 2.0 * s.scatter for s in of_quantity])
        series = (
            Series("bias ± 2 scatter", x, [s.bias for s in of_quantity], "markers", emphasis=True, bars=ends),
            Series("no error", [min(x), max(x)], [0.0, 0.0], "line"),
        )
        panels.append(Panel(quantity, "", "relative deviation from the 3D reference / %", series, names=order))
    return Figure(
        "bias-scatter", "Mean error (bias) of each model against the 3D reference, and its scatter", tuple(panels)
    )


def stated_bounds_table(study: Study, rungs: Sequence[Rung]) -> Table:
    """Return the table of the error bounds that rollbench states, with the share of errors that lie within each.

    The bounds are the largest expected error of each model, and the mesh uncertainty of coarser 3D mesh levels. ``rungs``:
    solution of each scene by each low-order model.
    """
    rows = leave_one_out_rows(study, rungs)
    counts = [
        (f"largest error to expect of the model {name}, estimated without the scene", held, total)
        for name, (held, total) in count_within_expected_error(rows).items()
    ]
    bars = [h for h in test_all_mesh_levels(study) if h.level > min(LEVELS)]
    if bars:
        words = f"mesh uncertainty of coarser levels: loads of {len({h.scene for h in bars})} scenes on their finest level"
        counts.append((words, sum(h.held for h in bars), sum(h.contacts for h in bars)))
    cells: list[Row] = [
        {
            Quantity("bound", "stated bound", "", "s"): words,
            Quantity("share", "values within the bound", "", "s"): f"{held} of {total}",
            Quantity("part", "share within the bound", "%", ".0f"): 100.0 * held / (total or 1),
        }
        for words, held, total in counts
    ]
    note = (
        f"Each expected error is chosen such that {SHARE:.0%} of the other scenes are within it. This does not guarantee "
        "the same share for a new scene; the table shows the share that was observed. The mesh uncertainty is meant to "
        "cover 95 % of the contacts, 19 of 20."
    )
    return Table.of("bounds-held", "Share of errors that lie within the error bounds that rollbench states", cells, note)


def make_section(study: Study, step: Callable[[str], None]) -> Section:
    """Return the section on validation uncertainty: errors with u_val, their bias and scatter, tests of error bounds.

    ``step`` is called with each line of progress.
    """
    title = "Bias and scatter of the models' errors, and uncertainty of these errors"
    step("every model on every scene with a 3D reference")
    rungs = study.compute_once(ladder)
    if not rungs:
        return Section("u-val", title, (Text(("No run of the 3D reference is stored.",)),))
    step("uncertainty by mesh, modelling choices and input tolerances of every scene")
    rows = validated_errors_of_models(study, rungs)
    found = bias_and_scatter(rows)
    of_loads = {s.model: s for s in found if s.quantity == CONTACTS}
    words = [
        f"{name}: mean error (bias) of contact loads {s.bias:+.2f} %, scatter {s.scatter:.2f} %; {100.0 * s.within:.0f} % "
        f"of the loads are within u_val, and {100.0 * s.within_own:.0f} % within the uncertainty by mesh and choices alone"
        for name, s in of_loads.items()
        if name in (*SHOWN, "condensed")
    ]
    text = (
        (
            "A difference from the 3D reference is an error of the model only as far as it exceeds the validation "
            "uncertainty u_val. u_val combines the uncertainties by the mesh of the reference, by its modelling choices "
            "and by the input tolerances as the root of the sum of squares; all three are shown with every error."
        ),
        f"{'. '.join(words)}.",
    )
    items: tuple[Text | Figure | Table, ...] = (
        Text(text),
        u_val_table(rows),
        bias_and_scatter_table(found),
        bias_and_scatter_figure(found),
        stated_bounds_table(study, rungs),
        *validated_range_items(study),
    )
    stated = [
        f"{s.bias:+.1f} % with a scatter of {s.scatter:.1f} % by the model {name}"
        for name, s in of_loads.items()
        if name in SHOWN
    ]
    conclusion = f"Mean error of contact loads against the 3D reference: {', '.join(stated)}." if stated else ""
    return Section("u-val", title, items, conclusion=conclusion)
