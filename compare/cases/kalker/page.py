"""Report page on the 3D model of rolling contact: verification, and comparison with the low-order friction models."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rollbench.compare.cases.kalker.evidence import AS_RUNS, BY_GRID, RESOLVED, Verification, verifications_of_rolling_model
from rollbench.compare.measure import error_percent
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.reference.levels import FINITE
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.running import gmsh_fault
from rollbench.compare.scenes.catalogue import shipped_scene_of_kind as shipped_case
from rollbench.compare.scenes.duty_cycle import FrictionScene
from rollbench.compare.studies.rolling.cases import prepare_rolling_case
from rollbench.compare.studies.rolling.rows import (
    GAP,
    KNOWN,
    LIMIT,
    PAIRS,
    RINGS,
    RollingComparisonRow,
    RunFromRest,
    compare_scene_with_stored_runs,
    force_changes_by_numerical_choices,
    interpretation_of_contact_loads,
    low_order_error_is_within_limit,
    runs_from_rest,
)
from rollbench.compare.studies.rolling.runs import (
    LEVELS,
    NAMES,
    SOURCE_LEVEL,
    BodyValues,
    RollingRun,
    find_body_variants,
    load_rolling_run,
)
from rollbench.hifi.rolling.balls import RollingSettings, hertz_semi_axes, solve_rolling
from rollbench.hifi.rolling.kinematics import rolling_speed
from rollbench.meshes.arrays import Array
from rollbench.reports.content import Figure, Panel, PressureMap, PressurePanel, Row, Section, Table, Text
from rollbench.reports.content import Series as Curve

#: Columns of the stored results of two touching balls, by name of the result.
NAMED = {
    "force 1-2 N": "ball_force",
    "loss apart mW": "loss_apart",
    "loss touching mW": "loss_touching",
    "increase %": "loss_increase",
}
#: Contacts whose slip and traction are drawn: scene, number of the ball, name of the contact.
SHOWN = (("lin-pair-a", 0, "BL"), ("lin-pair-a", 0, "TR"), ("lin-rotary-1", 0, "IL"), ("lin-rotary-1", 0, "OR"))
#: Numbers of cells along and across the drawn contacts.
SHAPE = LEVELS[1]


@lru_cache(maxsize=1)
def slip_and_traction_of_drawn_contacts() -> tuple[tuple[PressurePanel, PressurePanel], ...]:
    """Draw slip and traction over the rolling contacts that the report shows (`SHOWN`), for elastic half spaces."""
    choices, out = RollingSettings(SHAPE), []
    for name in dict.fromkeys(shown[0] for shown in SHOWN):
        scene = shipped_case(name, FrictionScene)
        case = prepare_rolling_case(scene, choices)
        found = solve_rolling(case.touching, choices)
        for _, ball, contact in (s for s in SHOWN if s[0] == name):
            index = case.contact_names.index(contact)
            one = next(c for c in found.contacts if (c.ball_index, c.contact_index) == (ball, index))
            touch = case.touching.balls[ball].groove_contacts[index]
            slip = one.slips / rolling_speed(touch, case.touching)
            traction = one.tangential_forces / float(one.cell_size.prod())
            axes = hertz_semi_axes(case.touching, touch)
            out.append(slip_and_traction_panels(f"{name}, {contact}", one.cell_centres, slip, traction, one.sticks, axes))
    return tuple(out)


def slip_and_traction_panels(
    title: str, cells: Array, slip: Array, traction: Array, sticks: NDArray[np.bool_], semi_axes: Sequence[float]
) -> tuple[PressurePanel, PressurePanel]:
    """Draw slip velocity, then tangential traction over the n cells of one rolling contact, with arrows for the directions.

    Abscissa: across the groove. Sticking cells are marked beside the traction. ``title``: name of the scene, then of the
    ball's contact; ``cells``: centres of the cells [m]; ``slip``: slip velocity divided by the rolling speed; ``traction``:
    [Pa]; each (n, 2) along and across the groove. ``sticks``: whether the surfaces stick in each cell, (n,);
    ``semi_axes``: of the contact ellipse along and across the groove [m].
    """

    def draw_vector_field(vectors: Array, unit_of: float, note: str, marked: list[bool] | None) -> PressurePanel:
        """Draw magnitude, divided by ``unit_of``, and direction of vectors (n, 2), with a text below."""
        size = np.linalg.norm(vectors, axis=1)
        has_direction = size > 1e-9 * size.max(initial=0.0)  # else it is that of round-off
        unit = np.where(has_direction[:, None], vectors / np.maximum(size, 1e-300)[:, None], 0.0)
        y, x = (1e6 * cells).T
        ellipse = (0.0, 0.0, 1e6 * semi_axes[1], 1e6 * semi_axes[0])
        arrows = (unit[:, 1].tolist(), unit[:, 0].tolist())
        return PressurePanel(title, x, y, size / unit_of, ellipse, note, arrows, 5, marked)

    most = float(np.linalg.norm(slip, axis=1).max())
    words = f"{int(sticks.sum())} of {len(sticks)} cells stick"
    return (
        draw_vector_field(slip, most, f"largest: {100.0 * most:.3g} % of the rolling speed", None),
        draw_vector_field(traction, 1e6, words, sticks.tolist() if sticks.any() else None),
    )


def make_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the report's section on the 3D model of rolling contact.

    ``cache``: gives the folders of stored 3D results (the section lists the scenes that have none). ``step``: function that
    receives a message before each step.
    """
    stores = cache.reference_folders or (shipped_store(),)
    step("rolling contacts with known answers")
    meshing = not gmsh_fault()
    proof = verifications_of_rolling_model(meshing=meshing)
    found = {name: compare_scene_with_stored_runs(name, stores) for name in (*PAIRS, *RINGS)}
    cache.record_used_scenes([name for name, rows in found.items() if rows])
    step("linear bearing from rest")
    series = runs_from_rest()
    step("slip and traction; finite bodies of other sizes")
    left = "Left out of a quick report." if cache.quick else "" if meshing else "Left out: gmsh cannot be loaded."
    sizes = ({}, left) if left else find_body_variants(stores, fresh=cache.measures_run_times)
    patches = slip_and_traction_of_drawn_contacts()
    step("other grids, steps and paths")
    changed = force_changes_by_numerical_choices(stores, series, sizes[0])
    missing = [name for name, rows in found.items() if not rows]
    items: list[Text | Table | Figure | PressureMap] = [
        Text(_introductory_paragraphs(found, proof)),
        Table.from_rows(
            "rolling-verification",
            "3D model of rolling contact: error on three grids for contacts whose solution is known",
            [_verification_row(p) for p in proof],
            "No order of convergence: the error grows on a finer grid, and depends on where cell boundaries lie.",
        ),
        Table.from_rows(
            "rolling-pairs",
            "Force between two touching balls (Lin's Tables 3.5 and 3.7): low-order model against 3D model",
            [_low_order_against_3d_row(row) for name in PAIRS for row in found[name]],
            (
                "3D: elastic half spaces; uncertainty: scatter of three grids. Table 3.7 does not print the contact "
                "loads. Two scenes assume them: balls of nominal size as in the text (plain), and balls with an "
                "oversize inferred from the results (inferred). The uncertainty does not cover this choice."
            )
            + (f" No stored runs: {', '.join(missing)}." if missing else ""),
        ),
        Table.from_rows(
            "rolling-ring",
            "Friction losses and torque of one ball of a rotary bearing: low-order model against 3D model",
            [_low_order_against_3d_row(row) for name in RINGS for row in found[name]],
        ),
        *_finite_body_results(stores, sizes, proof),
        *_slip_and_traction_maps(patches),
        Table.from_rows(
            "rolling-grids",
            "3D model of rolling contact: ball-to-ball force or friction torque on each grid of cells",
            _grid_dependence_rows(stores),
        ),
        Table.from_rows(
            "rolling-from-rest",
            "Two balls of a linear bearing started from rest: final ball-to-ball force against steady rolling",
            [_from_rest_row(s) for s in series],
        ),
        _from_rest_figure(series),
        Table.from_rows(
            "rolling-choices",
            "3D model of rolling contact: change of the ball-to-ball force with grid, time step and other settings",
            changed,
            "Stated uncertainty: by coarser grids than the compared one; for finite bodies also by their mesh and size. "
            "Runs from rest are compared with steady rolling on the same grid.",
        ),
    ]
    times = _error_over_cells_figure(stores)
    if times is not None:
        items.append(times)
    return Section(
        "rolling",
        "3D model of rolling contact: verification, and forces between touching balls",
        items,
        conclusion=_ball_force_conclusion(found),
    )


def _finite_body_results(
    stores: Sequence[Path], sizes: tuple[dict[str, BodyValues], str], verified: Sequence[Verification]
) -> list[Text | Table | Figure | PressureMap]:
    """Return text and tables that compare bodies of finite size with elastic half spaces in the 3D rolling model.

    ``stores``: folders of the stored 3D results; ``sizes``: results of two touching balls by size and mesh of the bodies,
    and a sentence on their origin; ``verified``: verifications of the model.
    """
    found = {name: compare_scene_with_stored_runs(name, stores, FINITE) for name in (*PAIRS, *RINGS)}
    missing, (variants, origin) = [name for name, rows in found.items() if not rows], sizes
    shown = [row for rows in found.values() for row in rows if row.half_space is not None]
    gated = [_change_by_finite_bodies_percent(row) for row in shown if row.quantity in ("force 1-2", "torque")]
    changes = [abs(change) for change in gated if change is not None]
    rub = max(abs(p.relative_error_percent) for p in verified if p.contact_problem.startswith("balls that touch"))
    most = f" They change forces and torques by up to {max(changes):.2f} %." if changes else ""
    return [
        Text(
            [
                (
                    "Finite bodies, normal and tangential: for rings and screws the static reference's patches of groove "
                    "and ball, set into pieces of their bodies; for straight rails, which the static reference does not "
                    "have, a whole ball and grooved bars of the same elements. Their response beyond a half space of the "
                    "same cells is a smooth kernel, added to the closed form of half spaces. Without motion, the pressures "
                    "are those of the static reference's patches (first rows of the verification). Simplified: balls "
                    "touch each other in a point. Over Hertz's circle and over the patch of two finite balls, all of "
                    f"which slides, force and loss of that friction agree to {rub:.2g} % (verification), whatever the "
                    "elasticity. The kernel changes the pressure, adds a strain by normal forces that half spaces of one "
                    "material do not have, and shortens the rolling radius of the ball by half of the approach. Contact "
                    "forces are unchanged, by Hertz's law; the contacts of one ball do not influence each other, and "
                    "friction does not change pressures."
                )
                + most
            ]
        ),
        Table.from_rows(
            "rolling-bodies",
            "3D model of rolling contact: forces with bodies of finite size instead of elastic half spaces",
            [_finite_body_row(row) for row in shown],
            "Uncertainty: scatter of three grids, and largest change of a force or loss over the sizes and meshes in the "
            "next table." + (f" No stored runs: {', '.join(missing)}." if missing else ""),
        ),
        Table.from_rows(
            "rolling-body-sizes",
            "Two touching balls in 3D: results for several sizes and meshes of the bodies of finite size",
            [{"body_sizes": choice} | {NAMED[name]: values[name] for name in NAMES} for choice, values in variants.items()],
            f"The grid of the contacts is the same in all rows. {origin}",
        ),
    ]


def _change_by_finite_bodies_percent(row: RollingComparisonRow) -> float | None:
    """Return the change [%] of a 3D result from elastic half spaces to bodies of finite size; None if not computed."""
    change = None if row.half_space is None else float(error_percent(row.reference, row.half_space))
    return change if change is not None and np.isfinite(change) and row.error_percent != 0.0 else None


def _finite_body_row(row: RollingComparisonRow) -> Row:
    """Return the table row of a quantity for rigid bodies, elastic half spaces, and elastic bodies of finite size."""
    uncertainty = row.uncertainty if np.isfinite(row.uncertainty) else None
    change = _change_by_finite_bodies_percent(row)
    return {
        "scene": row.scene,
        "quantity": row.quantity,
        "unit": row.unit,
        "value_rigid": row.rigid,
        "value_half_spaces": row.half_space,
        "value_finite": row.reference,
        "uncertainty_finite": uncertainty,
        "change_by_finite_bodies": change,
        "low_order_error_against_finite": row.error_percent,
    }


def _slip_and_traction_maps(patches: Sequence[tuple[PressurePanel, PressurePanel]]) -> list[PressureMap]:
    """Return two figures of rolling contacts: slip velocity, and tangential traction with the sticking cells marked.

    ``patches``: drawings of slip and traction of each contact.
    """
    axes = ("across the groove [um]", "along [um]")
    slip, traction = zip(*patches, strict=True)
    return [
        PressureMap(
            "rolling-slip",
            "Slip velocity in the contact areas of rolling balls",
            slip,
            *axes,
            "slip velocity over the largest of the contact",
            caption="Above each drawing: scene and contact of a ball (B bottom, T top; I inner ring, O outer ring; L left, "
            "R right). The material moves downwards through the contact.",
        ),
        PressureMap(
            "rolling-traction",
            "Tangential traction and stick zones in the contact areas of rolling balls",
            traction,
            *axes,
            "tangential traction on the ball [MPa]",
            marked_label="sticks",
            caption="Ball and groove stick where the traction is below mu p (mu: coefficient of friction, p: pressure).",
        ),
    ]


def _ball_force_conclusion(found: dict[str, list[RollingComparisonRow]]) -> str:
    """Return the sentence on the low-order model's error of the ball-to-ball force; empty without a stored 3D result.

    ``found``: for each scene, comparisons of the low-order friction models with the 3D model.
    """
    row = next((r for r in found["lin-pair-a"] if r.quantity == "force 1-2"), None)
    if row is None or row.error_percent is None:
        return ""
    sense = "larger" if row.error_percent > 0.0 else "smaller"
    return (
        f"The low-order model's force between two touching balls of Lin's linear bearing, case (a), is "
        f"{abs(row.error_percent):.2f} % {sense} than that of the 3D model."
    )


def _introductory_paragraphs(found: dict[str, list[RollingComparisonRow]], verified: Sequence[Verification]) -> list[str]:
    """Return the introductory paragraphs: 3D model, verifications passed, low-order results with errors above the limit.

    ``found``: for each scene, comparisons of the low-order friction models with the 3D model; ``verified``: verifications
    of the 3D model. The low-order results are ball-to-ball forces and torques.
    """
    reached = sum(p.within_permitted_error for p in verified)
    gated = [r for rows in found.values() for r in rows if r.quantity in ("force 1-2", "torque")]
    beyond = [r for r in gated if not low_order_error_is_within_limit(r)]
    out = [
        "The 3D model of rolling solves the normal and tangential contact of elastic bodies on a grid in every "
        "contact. Coulomb's law holds in every cell to round-off, elastic displacements travel with the material, and "
        "each ball moves so that its forces and moments balance. Bodies are elastic half spaces; finite bodies are "
        "computed for comparison. Grid errors that also occur for rigid bodies (cells, staircase edge, a spin pole "
        "inside a cell) are removed with nearly rigid bodies on the same grid and the rigid limit by quadrature.",
        f"{reached} of {len(verified)} known solutions are met within the permitted error.{_spin_pole_sentence(verified)}",
    ]
    if gated:
        causes = {(r.scene, r.quantity): KNOWN.get((r.scene, r.quantity), "cause unknown") for r in beyond}
        names = "; ".join(f"{scene}, {what}: {cause}" for (scene, what), cause in causes.items())
        out.append(
            f"{len(gated) - len(beyond)} of {len(gated)} ball-to-ball forces and torques of the low-order models are "
            f"within {LIMIT:g} % of 3D" + (f"; beyond it: {names}." if beyond else ".")
        )
    return out


def _spin_pole_sentence(verified: Sequence[Verification]) -> str:
    """Return the sentence on the grid error of a slipping contact whose spin pole lies inside a cell; empty if unknown.

    ``verified``: verifications of the 3D rolling model.
    """
    worst = []
    for way in (BY_GRID, RESOLVED, AS_RUNS):
        of = [p.relative_error_percent for p in verified if p.contact_problem == f"full slip {way}, pole inside"]
        worst.append(max(map(abs, of), default=np.nan))
    if not np.isfinite(worst).all():
        return ""
    alone, resolved, differenced = worst
    return (
        f" Where a whole contact slips about a pole inside a cell, the error of the grid alone is {alone:.2g} %: the "
        f"direction of slip turns within the cell. With this turn resolved, the staircase edge of the contact leaves "
        f"{resolved:.2g} %. Corrected by the rigid limit, as stored results are, every grid is within {differenced:.2g} %."
    )


def _verification_row(verification: Verification) -> Row:
    """Return the table row of a verification: values on three grids, exact value, error, order of convergence."""
    v = verification
    reached = "reached" if v.within_permitted_error else "not reached"
    row: Row = {"contact_problem": v.contact_problem, "quantity": v.quantity}
    for grid, value in zip(("coarse", "middle", "fine"), v.values_by_grid, strict=True):
        row["value_on_grid", grid] = value
    return row | {
        "exact_value": v.exact_value,
        "error_against_exact": v.relative_error_percent,
        "order_f1": v.convergence_order,
        "permitted_error": v.permitted_error_percent,
        "exact_reached": reached,
    }


def _low_order_against_3d_row(row: RollingComparisonRow) -> Row:
    """Return the table row that compares a quantity by the low-order model with the 3D model and printed values."""
    uncertainty = row.uncertainty if np.isfinite(row.uncertainty) else None
    verdict = f"{'within' if low_order_error_is_within_limit(row) else 'beyond'} {LIMIT:g} %"
    return {
        "scene": row.scene,
        "load_assumption": row.load_state,
        "quantity": row.quantity,
        "unit": row.unit,
        ("value_low_order", "5"): row.low,
        "value_3d": row.reference,
        "uncertainty_3d": uncertainty,
        "low_order_error": row.error_percent,
        "uncertainty_3d_share": row.uncertainty_percent,
        "lin_low_order": row.printed,
        "lin_ansys": row.printed_ansys,
        "value_flat": row.flat,
        "value_rigid": row.rigid,
        ("low_order_within", f"{LIMIT:g}"): verdict,
    }


def _stored_rolling_runs(name: str, stores: Sequence[Path]) -> list[RollingRun]:
    """Return the stored results of the 3D rolling model for a scene, on all grids.

    ``name``: name of the scene; ``stores``: folders of the results. The first result has the cell size of Lin's thesis.
    """
    scene = shipped_case(name, FrictionScene)
    found = (load_rolling_run(scene, level, stores) for level in (SOURCE_LEVEL, *LEVELS))
    return [run for run in found if run is not None]


def _grid_dependence_rows(stores: Sequence[Path]) -> Iterator[Row]:
    """Yield a table row for each stored result of the 3D rolling model, to show the influence of the grid of cells.

    Columns: scene, grid, force or torque, change of this value by elasticity, numerical loss of power (by the upwind finite
    differences) divided by the input power, number of sticking cells. ``stores``: folders of the results.
    """
    every = [(name, run) for name in (*PAIRS, *RINGS) for run in _stored_rolling_runs(name, stores)]
    for name, run in every:
        key = next(k for k in run.elastic if k.startswith(("force", "torque")))
        level, state = (
            "source's size" if run.level == SOURCE_LEVEL else str(run.level),
            interpretation_of_contact_loads(name),
        )
        yield {
            "scene": name,
            "load_assumption": state,
            "grid_level": level,
            "cell_counts": f"{run.shape[0]} x {run.shape[1]}",
            "grid_corrected_value": run.values[key],
            "uncorrected_value": run.elastic[key],
            "change_by_elasticity": run.elastic[key] - run.near_rigid[key],
            "numerical_power_loss": 100.0 * run.upwind,
            "sticking_cells": run.sticking,
        }


def _from_rest_row(run: RunFromRest) -> Row:
    """Return the table row of two balls started from rest: final and steady ball-to-ball force, time of first contact."""
    meet = next((t for t, f in zip(run.time, run.force, strict=True) if f > 0.0), None)
    error = float(error_percent(run.force[-1], run.steady_force))
    return {
        "time_steps": run.steps,
        "final_ball_force": run.force[-1],
        "steady_ball_force": run.steady_force,
        "error_against_steady": error,
        "meeting_time": None if meet is None else 1e3 * meet,
    }


def _from_rest_figure(series: Sequence[RunFromRest]) -> Figure:
    """Draw ball-to-ball force and speed of the balls over time, for two balls started from rest.

    ``series``: transient solutions with several numbers of time steps.
    """
    forces = [Curve(f"{s.steps} steps", [1e3 * t for t in s.time], s.force) for s in series]
    last = series[-1]
    time = [1e3 * t for t in last.time]
    speeds = [Curve(f"ball {k + 1}", time, [1e3 * v[k] for v in last.speed], "line") for k in range(2)]
    return Figure(
        "rolling-from-rest",
        f"Two balls of a linear bearing started from rest {1e6 * GAP:g} um apart: ball-to-ball force and speeds over time",
        [
            Panel("ball-to-ball force", "time [ms]", "force [N]", forces, include_zero=True),
            Panel(f"speed of the balls, {last.steps} steps", "time [ms]", "speed [mm/s]", speeds),
        ],
        f"Lin's thesis used {series[0].steps} steps.",
    )


def _error_over_cells_figure(stores: Sequence[Path]) -> Figure | None:
    """Draw, over the number of cells, the difference of the ball-to-ball force in 3D on each grid from that on the finest.

    Returns None if no scene has stored 3D results on every grid. ``stores``: folders of the results.
    """
    curves = []
    for name in PAIRS:
        runs = [r for r in _stored_rolling_runs(name, stores) if r.level != SOURCE_LEVEL]
        if len(runs) < len(LEVELS) or not runs[-1].values["force 1-2 N"] > 0.0:
            continue
        top = runs[-1].values["force 1-2 N"]
        errors = [max(abs(float(error_percent(r.values["force 1-2 N"], top))), 1e-3) for r in runs[:-1]]
        curves.append(Curve(name, [float(r.shape[0] * r.shape[1]) for r in runs[:-1]], errors))
    if not curves:
        return None
    panel = Panel("ball-to-ball force", "cells of the grid", "difference from the finest grid [%]", curves, log_axes="xy")
    title = "3D model of rolling contact: error of the ball-to-ball force, plotted against the number of cells"
    return Figure("rolling-cells", title, [panel])
