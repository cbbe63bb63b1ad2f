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
from rollbench.compare.models import modelling, uncertainty
from rollbench.compare.models.comparison import REFERENCED, solution_from_result
from rollbench.compare.models.model_form import SHARE
from rollbench.compare.models.registry import DEFAULT
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.reference import estimate
from rollbench.compare.reference.levels import LEVELS, PRODUCTION
from rollbench.compare.reference.store import load_stored_run, shipped_store
from rollbench.compare.scenes import scene_file
from rollbench.compare.sections.fit import validated_range_figure, validated_range_table
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import Scene
from rollbench.reports.content import Figure, Panel, Row, Section, Series, Table, Text

#: File with contact loads that are used for tests only: of randomly drawn screws, and of further mesh levels of shipped
#: scenes.
JUDGES = "judging_levels.json"

#: Key, in a record of the file `JUDGES`, of the TOML text of a randomly drawn scene.
SCENE = "scene"

#: Name of the variant of the 3D reference whose boxes around the contacts (refinement boxes) have edges with more cells.
SOCKETS = "finer-sockets"

#: Scenes that were also solved by another program.
CHECKED = ("two-balls", "lin-case1-cut")

#: Scenes that were solved in 3D on only two mesh levels.
COARSE = ("liu-screw", "liu-drawn", "liu-small", "liu-drawn-1kN")

#: Shipped scenes whose mesh levels are compared with each other.
SHIPPED = tuple(dict.fromkeys((*REFERENCED, *CHECKED, *modelling.UNSEEN, *COARSE)))

#: Least number of contacts for which the share of loads within their uncertainty is meaningful for a single scene.
MANY = 40


@dataclass(frozen=True)
class MeshUncertaintyTest:
    """Test of the mesh uncertainty that is stated for the contact loads of one scene on one mesh level.

    The test counts the contacts whose load on a finer mesh level differs by less than the stated uncertainty.
    """

    #: Name of the scene.
    scene: str
    #: Finest mesh level among those from which the tested uncertainty was estimated.
    tested_level: int
    #: Finer mesh level, whose loads test the uncertainty.
    finer_level: int
    #: Number of loaded contacts.
    contact_count: int
    #: Tested uncertainty, as RMS over the loaded contacts [% of the mean load].
    uncertainty_percent: float
    #: Number of contacts whose load on this level differs from that on the finer level by less than the stated uncertainty.
    covered_contact_count: int
    #: Whether the scene is a randomly drawn screw; if not, it comes with rollbench.
    is_random_screw: bool

    @property
    def covered_share(self) -> float:
        """Share (0 to 1) of contacts whose load differs from that on the finer level by less than its uncertainty."""
        return self.covered_contact_count / self.contact_count


@cache
def read_loads_and_scenes_for_tests(store: Path) -> tuple[dict[str, dict[int, Array]], dict[str, Scene]]:
    """Return contact loads stored only to test the mesh uncertainty, and those randomly drawn scenes that have some.

    ``store``: folder with the file `JUDGES` of these loads. First result: loads of n balls on the four flanks, (n, 4) [N],
    by name of the scene, then by mesh level. Second result: the randomly drawn scenes by name. Both are empty if there is
    no such file.
    """
    path = store / JUDGES
    data = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    texts = {name: record.pop(SCENE) for name, record in data.items() if SCENE in record}
    drawn = {name: scene_file.scene_from_text(text, f"{name}.toml") for name, text in texts.items()}
    return {name: {int(k): np.array(rows, float) for k, rows in by_level.items()} for name, by_level in data.items()}, drawn


def loads_by_scene_and_level(cache: SceneResultCache) -> dict[str, dict[int, Array]]:
    """Return the contact loads (n, 4) [N] of every compared scene with at least two mesh levels, by scene and level.

    Randomly drawn scenes come last.
    """
    out, extra = {}, dict(read_loads_and_scenes_for_tests(shipped_store())[0])
    for name in SHIPPED:
        scene = cache.built_in_scene(name)
        runs = (load_stored_run(scene, level, stores=cache.reference_folders) for level in LEVELS)
        loads = {run.level: run.load for run in runs if run is not None}
        if len(loads) > 1:
            out[name] = loads | extra.pop(name, {})
    return out | extra


def load_scatter_by_refinement_boxes(cache: SceneResultCache) -> float | None:
    """Return the standard deviation of contact loads due to the mesh of the refinement boxes [% of the mean load].

    A refinement box is a box around a contact that is filled with a fine mesh patch. Two 3D runs whose boxes have edges
    with different numbers of cells are compared. The difference of a contact load contains the errors of both runs, hence
    the division by the root of two. Returns None if the runs are not stored.
    """
    scene = cache.built_in_scene(modelling.REFINED)
    finer = load_stored_run(scene, PRODUCTION, SOCKETS, cache.reference_folders)
    base = modelling.run_without_changed_choices(scene, PRODUCTION, cache.reference_folders)
    if finer is None or base is None:
        return None
    on = base.load > 0.0
    change = error_percent(finer.load[on], base.load[on], mean_load(base.load))
    return float(np.sqrt((change**2).mean() / 2.0))


def mesh_uncertainty_parameters(cache: SceneResultCache) -> estimate.UncertaintyFromOtherScenes | None:
    """Return the contributions to the mesh uncertainty of contact loads that are taken to be equal for all scenes.

    They follow from the mesh levels of all compared scenes together, because the mesh levels of a single scene do not show
    them; an example is an error that all contact loads of a scene share. Returns None if 3D runs are missing.
    """
    loads, box_scatter = loads_by_scene_and_level(cache), load_scatter_by_refinement_boxes(cache)
    if box_scatter is None or len(loads) < len(modelling.UNSEEN):
        return None
    return estimate.derive_uncertainty_of_other_scenes(loads, box_scatter, cache.compute_once(_load_errors_near_nut_faces))


def _shipped_or_drawn_scene(cache: SceneResultCache, name: str) -> Scene:
    """Return the scene called ``name``: a scene that comes with rollbench, or a randomly drawn screw with stored loads."""
    return read_loads_and_scenes_for_tests(shipped_store())[1].get(name) or cache.built_in_scene(name)


def _load_errors_near_nut_faces(cache: SceneResultCache) -> dict[str, Array]:
    """Return an upper bound of each contact load's error on mesh level 1 due to free end faces of the nut, by scene name.

    ``cache``: has the scenes and stored runs. The bounds are (n, 4) [% of the mean load], for n balls on the four flanks.
    """
    first, out = min(LEVELS), {}
    for name, loads in loads_by_scene_and_level(cache).items():
        if first in loads:
            errors = estimate.load_error_near_faces(_shipped_or_drawn_scene(cache, name), loads[first], first)
            out[name] = error_percent(errors, 0.0, mean_load(loads[max(loads)]))
    return out


def check_uncertainty_of_all_mesh_levels(cache: SceneResultCache) -> list[MeshUncertaintyTest]:
    """Test the mesh uncertainty of all coarser mesh levels of each compared scene by the loads on its finest level.

    Returns an empty list if 3D runs are missing.
    """
    return cache.compute_once(_compute_mesh_uncertainty_tests)


def _compute_mesh_uncertainty_tests(cache: SceneResultCache) -> list[MeshUncertaintyTest]:
    """Test the mesh uncertainty of every scene as estimated from its coarsest level, its two coarsest levels, and so on."""
    return check_uncertainty_of_scenes(cache, lambda loads: [tuple(sorted(loads)[:k]) for k in range(1, len(loads))])


def check_uncertainty_of_scenes(
    cache: SceneResultCache, choose_level_groups: Callable[[estimate.Levelled], list[tuple[int, ...]]]
) -> list[MeshUncertaintyTest]:
    """Test mesh uncertainties of all scenes by the contact loads on the finest mesh level of each scene.

    ``choose_level_groups``: function of a scene's contact loads by mesh level; it returns groups of levels, and
    one uncertainty is estimated from each group and tested. Returns an empty list if 3D runs are missing.
    """
    scenes, box_scatter = loads_by_scene_and_level(cache), load_scatter_by_refinement_boxes(cache)
    if box_scatter is None or len(scenes) < len(modelling.UNSEEN):
        return []
    beside = cache.compute_once(_load_errors_near_nut_faces)
    return [
        _test_uncertainty_of_scene(_shipped_or_drawn_scene(cache, name), levels, scenes, box_scatter, beside)
        for name, loads in scenes.items()
        for levels in choose_level_groups(loads)
    ]


def _test_uncertainty_of_scene(
    scene: Scene,
    levels: tuple[int, ...],
    loads_by_scene: Mapping[str, estimate.Levelled],
    box_scatter: float,
    errors_by_scene_near_faces: Mapping[str, Array],
) -> MeshUncertaintyTest:
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
    box_scatter
        Standard deviation of contact loads due to the mesh of refinement boxes around the contacts [% of the mean load].
    errors_by_scene_near_faces
        Errors of contact loads near free nut faces on level 1, (n, 4) [% of the mean load], by name of the scene.
    """
    name, level = scene.name, max(levels)
    family = modelling.SPOKEN_FOR.get(name, name)
    others = {o: of for o, of in loads_by_scene.items() if modelling.SPOKEN_FOR.get(o, o) != family}
    known = estimate.derive_uncertainty_of_other_scenes(others, box_scatter, errors_by_scene_near_faces)
    loads, judge = loads_by_scene[name], max(loads_by_scene[name])
    on, mean = estimate.is_loaded_on_any_level(loads), mean_load(loads[judge])
    coarser = {k: loads[k] for k in levels}
    grid, off = estimate.mesh_uncertainty(coarser, known), np.abs(error_percent(loads[level][on], loads[judge][on], mean))
    beside_faces = estimate.load_error_near_faces if grid.is_from_other_scenes else estimate.load_overestimate_near_faces
    bars = grid.uncertainties_of_loads(coarser) + error_percent(beside_faces(scene, loads[level], level), 0.0, mean)
    return MeshUncertaintyTest(
        name, level, judge, int(on.sum()), grid.uncertainty, int((off <= bars[on]).sum()), name not in SHIPPED
    )


def share_of_contacts_within_uncertainty(tests: Sequence[MeshUncertaintyTest]) -> float:
    """Return the share (0 to 1) of contacts, over several tests, whose load on a finer mesh is within its uncertainty.

    ``tests``: the tests, each of one scene and mesh level.
    """
    return sum(h.covered_contact_count for h in tests) / sum(h.contact_count for h in tests)


#: Models whose errors are shown for each scene; bias and scatter are shown for all models of the section "ladder".
SHOWN = (DEFAULT, "lin")

#: Title of the table and of the figure of bias and scatter.
BIAS_TITLE = "Mean error (bias) of each model against the 3D reference, and its scatter"

#: Names of models in a sentence, other than "the refined model" and so on.
SPOKEN = {"lin": "Lin's model"}


def validated_errors_of_models(
    cache: SceneResultCache, model_solutions: Sequence[modelling.RefinementStepResult]
) -> list[uncertainty.ErrorWithUncertainty]:
    """Return the error of every model, with its validation uncertainty u_val, for each scene and quantity.

    ``model_solutions``: solution of each scene by each low-order model.
    """
    found = [
        uncertainty.error_with_validation_uncertainty(cache, r.scene, r.model, q, solution_from_result(r.result))
        for r in model_solutions
        for q in uncertainty.QUANTITIES
    ]
    return [row for row in found if row is not None]


def errors_with_u_val_table(validated_errors: Sequence[uncertainty.ErrorWithUncertainty]) -> Table:
    """Return the table of the errors of the models in `SHOWN`, with u_val, for each scene and quantity.

    ``validated_errors``: error and uncertainty by scene, model and quantity.
    """
    in_error = "the model is in error, by model error ± u_val"
    within = "model error within u_val: not distinguishable from zero"
    cells: list[Row] = [
        {
            "scene": row.scene,
            "quantity": row.quantity,
            "model": row.model,
            "error_against_reference": row.error,
            "u_mesh": row.uncertainty.discretisation,
            "u_choices": row.uncertainty.choices,
            "u_inputs": row.uncertainty.inputs,
            "u_val": row.uncertainty.total,
            "error_beyond_u_val": in_error if abs(row.error) > row.uncertainty.total else within,
            "share_within_u_val": 100.0 * row.within,
            "varied_on": row.uncertainty.choices_varied_on or "–",
        }
        for row in validated_errors
        if row.model in SHOWN
    ]
    note = (
        f"Model error: against the 3D reference. u_val: validation uncertainty, by mesh, modelling choices and input "
        f"tolerances together. For {uncertainty.CONTACTS}: the contact with the largest error, in per cent of the mean "
        "load; for other quantities in per cent of the value by the 3D reference. Input tolerances are assumed: "
        f"{'; '.join(uncertainty.INPUTS)}; each is varied alone, with the model lin. Modelling choices "
        "were varied on two screws; if the last column names another one, the largest effect there is used. As in ASME "
        "V&V 20, the uncertainties are combined by the root of the sum of squares; they are not subtracted from an error."
    )
    title = "Error of each model and uncertainty of this error, for each scene and quantity"
    return Table.from_rows("u-val", title, cells, note)


def bias_and_scatter(rows: Sequence[uncertainty.ErrorWithUncertainty]) -> list[Row]:
    """Compute bias and scatter of the errors of each model in each quantity, as a row of a table for each such pair.

    ``rows``: errors with their uncertainties, one for each scene, model and quantity.

    Returns
    -------
    list[Row]
        Model, quantity, numbers of scenes and of compared values; bias: geometric mean of the ratios of model to 3D
        reference over all values, less 1 [%]; scatter: standard deviation of ln(model / reference) over all values, without
        the part due to the mesh of the reference [%]; shares of the values whose error is at most u_val, and at most the
        part of u_val that is due to the 3D reference [%].

    Notes
    -----
    The method is that of NUREG-1824, supplement 1, a validation of fire models. With the ratio M/E of model to reference,
    the bias is delta = exp(mean ln(M/E)), and the scatter sigma_M follows from sigma_M^2 = var(ln(M/E)) - sigma_E^2, at
    least zero. sigma_E is the standard deviation of the error of the reference due to its mesh: u_grid / 2, because u_grid
    is a 95 % bound, that is two standard deviations. Inputs and modelling choices are the same for model and reference and
    cause no scatter.
    """
    out: list[Row] = []
    for model, name in dict.fromkeys((r.model, r.quantity) for r in rows):
        group = [r for r in rows if (r.model, r.quantity) == (model, name)]
        logs = np.log(np.concatenate([r.ratio for r in group]))
        grids = [r.uncertainty.discretisation for r in group]
        known = [grid for grid in grids if np.isfinite(grid)]
        spread = float(np.sqrt(np.mean(np.square(known)))) / 200.0 if known else 0.0
        variance = float(logs.var(ddof=1)) if logs.size > 1 else 0.0
        out.append(
            {
                "model": model,
                "quantity": name,
                "scenes": len(group),
                "values": logs.size,
                "bias": float(error_percent(np.exp(logs.mean()), 1.0)),
                "scatter": float(error_percent(np.sqrt(max(variance - spread**2, 0.0)), 0.0, 1.0)),
                "share_within_u_val": 100.0 * float(np.mean([r.within for r in group])),
                "share_within_own": 100.0 * float(np.mean([r.within_own for r in group])),
            }
        )
    return out


def bias_and_scatter_table(rows: list[Row]) -> Table:
    """Return the table of bias and scatter of the errors, for each model and quantity, over all scenes.

    ``rows``: bias and scatter by model and quantity (`bias_and_scatter`).
    """
    note = (
        "Bias: geometric mean of the relative deviation of the model from the 3D reference. Scatter: relative standard "
        "deviation of the model, after subtraction of the variance by the mesh of the reference. u_val: validation "
        "uncertainty, by mesh, modelling choices and input tolerances together. All screws and bearings with a 3D "
        "reference; contacts above a tenth of the mean load."
    )
    return Table.from_rows("bias-scatter", BIAS_TITLE, rows, note)


def bias_and_scatter_figure(table: Table) -> Figure:
    """Draw the mean error (bias) of each model with bars of two standard deviations, in a panel for each quantity.

    ``table``: bias and scatter by model and quantity (`bias_and_scatter_table`).
    """
    panels = []
    order = [m.name for m in modelling.RUNGS]
    for quantity in dict.fromkeys(map(str, table.columns["quantity"])):
        of_quantity = [row for row in table.rows if row["quantity"] == quantity]
        x = [float(order.index(str(row["model"])) + 1) for row in of_quantity]
        bias, scatter = (np.array([row[column] for row in of_quantity]) for column in ("bias", "scatter"))
        ends = (list(bias - 2.0 * scatter), list(bias + 2.0 * scatter))
        series = (
            Series("bias ± 2 scatter", x, list(bias), "markers", bold=True, error_bars=ends),
            Series("no error", [min(x), max(x)], [0.0, 0.0], "line"),
        )
        panels.append(Panel(quantity, "", "relative deviation from the 3D reference / %", series, abscissa_names=order))
    return Figure("bias-scatter", BIAS_TITLE, tuple(panels))


def error_bound_coverage_table(cache: SceneResultCache, model_solutions: Sequence[modelling.RefinementStepResult]) -> Table:
    """Return the table of the error bounds that rollbench prints, with the share of actual errors that lie within each.

    The bounds are the largest expected error of each model, and the mesh uncertainty of coarser 3D mesh levels.
    ``model_solutions``: solution of each scene by each low-order model.
    """
    rows = modelling.leave_one_out_error_rows(cache, model_solutions)
    counts = [
        (f"largest error to expect of the model {name}, estimated without the scene", held, total)
        for name, (held, total) in uncertainty.count_within_expected_error(rows).items()
    ]
    bars = [h for h in check_uncertainty_of_all_mesh_levels(cache) if h.tested_level > min(LEVELS)]
    if bars:
        words = f"mesh uncertainty of coarser levels: loads of {len({h.scene for h in bars})} scenes on their finest level"
        counts.append((words, sum(h.covered_contact_count for h in bars), sum(h.contact_count for h in bars)))
    cells: list[Row] = [
        {"error_bound": x, "errors_within_bound": f"{n} of {all_}", "share_within_bound": 100.0 * n / (all_ or 1)}
        for x, n, all_ in counts
    ]
    note = (
        f"Each expected error is chosen such that {SHARE:.0%} of the other scenes are within it. This does not guarantee "
        "the same share for a new scene; the table shows the share that was observed. The mesh uncertainty is meant to "
        "cover 95 % of the contacts, 19 of 20."
    )
    title = "Share of the models' actual errors that lie within the error bounds given by rollbench"
    return Table.from_rows("bounds-held", title, cells, note)


def tables_of_errors(cache: SceneResultCache) -> tuple[Table, Table]:
    """Return the tables of the errors with u_val and of bias and scatter; the first page of the report reads them, too."""
    rows = validated_errors_of_models(cache, cache.compute_once(modelling.solve_refinement_sequence_on_all_scenes))
    return errors_with_u_val_table(rows), bias_and_scatter_table(bias_and_scatter(rows))


def make_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the section on validation uncertainty: errors with u_val, their bias and scatter, tests of error bounds.

    ``step`` is called with each line of progress.
    """
    title = "Bias and scatter of the models' errors, and uncertainty of these errors"
    step("every model on every scene with a 3D reference")
    rungs = cache.compute_once(modelling.solve_refinement_sequence_on_all_scenes)
    if not rungs:
        return Section("u-val", title, (Text(("No run of the 3D reference is stored.",)),))
    step("uncertainty by mesh, modelling choices and input tolerances of every scene")
    errors, scatters = cache.compute_once(tables_of_errors)
    of_loads = {row["model"]: row for row in scatters.rows if row["quantity"] == uncertainty.CONTACTS}
    words = [
        f"{name}: mean error (bias) of contact loads {row['bias']:+.2f} %, scatter {row['scatter']:.2f} %; "
        f"{row['share_within_u_val']:.0f} % of the loads are within u_val, and {row['share_within_own']:.0f} % within the "
        "uncertainty by mesh and choices alone"
        for name, row in of_loads.items()
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
        errors,
        scatters,
        bias_and_scatter_figure(scatters),
        error_bound_coverage_table(cache, rungs),
        validated_range_table(),
        validated_range_figure(),
    )
    stated = [
        f"{row['bias']:+.1f} % (standard deviation {row['scatter']:.1f} %) with {SPOKEN.get(name, f'the {name} model')}"
        for name, row in of_loads.items()
        if name in SHOWN
    ]
    conclusion = f"Mean error of the contact loads against the 3D reference: {', '.join(stated)}." if stated else ""
    return Section("u-val", title, items, conclusion=conclusion)
