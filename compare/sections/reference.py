"""Report section on low-order models against the 3D reference: errors, contact loads, screw deflection and run times."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from rollbench.compare.gate.verdict import LIMIT
from rollbench.compare.measure import error_percent, load_error
from rollbench.compare.models import comparison, modelling
from rollbench.compare.models.registry import MODELS
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.printed import printed_entry
from rollbench.compare.reference.estimate import Reference, largest_uncertainty_percent
from rollbench.compare.reference.levels import LEVELS, PRODUCTION, SOURCE_LEVEL
from rollbench.compare.reference.store import Run, load_stored_run
from rollbench.compare.sections import curves
from rollbench.compare.sections.reference_time import run_time_items
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import SIDES
from rollbench.reports.content import Figure, Panel, Row, Section, Series, Table, Text

References = Mapping[str, Reference]


def modelling_uncertainty_by_scene(cache: SceneResultCache) -> dict[str, modelling.ModellingUncertainty]:
    """Return the uncertainty of the 3D contact loads by modelling choices, for each scene on which they were varied.

    ``cache``: has the scenes and stored runs. Scenes without stored runs with changed choices are left out.
    """
    found = {}
    for scene in map(cache.built_in_scene, modelling.VARIED):
        effects = modelling.effects_of_changed_choices(scene, cache.reference_folders)
        if (combined := modelling.combined_modelling_uncertainty(scene, effects)) is not None:
            found[scene.name] = combined
    return found


def solve_contact_loads(cache: SceneResultCache, name: str, model: str) -> comparison.ContactSolution:
    """Solve a scene by a low-order model, and return its contact loads and displacements.

    ``name``: name of the scene. ``model``: name of the model.
    """
    return comparison.solution_from_result(cache.solve_once(name, model))


def load_error_table(cache: SceneResultCache, references: References) -> Table:
    """Return the table of contact-load errors against the finest mesh level of the 3D reference, for each scene.

    Its rows are the low-order models, the 3D model on the mesh of Lin's thesis, and coarser mesh levels. ``references``: 3D
    reference of each scene, by name of the scene.
    """
    rows: list[Row] = []
    modelled = cache.compute_once(modelling_uncertainty_by_scene)
    for name, ref in references.items():
        scene = cache.built_in_scene(name)
        uncertainty = largest_uncertainty_percent(ref), modelling.applicable_modelling_uncertainty(name, modelled)
        keys, found = comparison.PRINTED.get(name), list[tuple[str, Array, str | None]]()
        for model in comparison.models_shown_for_scene(scene):
            shown = keys[:2] if keys and model.name == "lin" else ()
            printed = " / ".join(printed_entry("lin-2.4.1", k).number_as_printed for k in shown) or "–"
            found.append((model.label, cache.solve_once(name, model.name).load, printed))
        source = load_stored_run(scene, SOURCE_LEVEL, stores=cache.reference_folders)
        finest = f"3D level {ref.best.level}"
        coarser = (run for run in comparison.solutions_of_reference_runs(ref, source) if run.model != finest)
        found += [(LABELS[run.model], run.load, "–") for run in coarser]
        for label, load, printed_errors in (*found, (LABELS[finest], ref.load, None)):
            e = load_error(load, ref.load, ref.contacts)
            errors: Row = {
                "largest_load_error": e.max_percent,
                "at_largest_error": f"{e.ball} {e.side}",
                "rms_error": e.rms_percent,
                "largest_load_error_own": e.own_max_percent,
                "rms_error_own": e.own_rms_percent,
            }
            row: Row = {"scene": name, "model": label}
            row |= dict.fromkeys(errors) if printed_errors is None else errors
            row |= {"lin_errors_against_ansys": printed_errors, "mesh_uncertainty": uncertainty[0]}
            row |= {"modelling_uncertainty": uncertainty[1], "load_ratio_on_sl": comparison.load_ratio(load)}
            rows.append(row)
    note = (
        "Errors against the finest mesh level of the 3D reference. Printed by Lin: errors that the thesis prints for its "
        "low-order model against its ANSYS model (whose loads are not printed), relative to the load of each contact. Mesh "
        "uncertainty: largest over the contacts of the 3D reference. Uncertainty by modelling choices: effect of "
        "idealisations and of dimensions that Lin's thesis does not print (section reference-mesh). No error is reduced "
        "by an uncertainty; section u-val combines both uncertainties with the input tolerances."
    )
    title = "Contact-load errors of the low-order models against the 3D reference on each scene"
    return Table.from_rows("reference-errors", title, rows, note)


#: Names of the 3D runs in tables and figures, by the name under which their loads are returned.
LABELS = {
    "3D source mesh": "3D reference, mesh of Lin's thesis",
    **{f"3D level {level}": f"3D reference, level {level}" for level in LEVELS},
}


def contact_load_tables(cache: SceneResultCache, references: References) -> list[Table]:
    """Return, for each scene, a table with the load and contact angle of every contact by every model and mesh.

    ``references``: 3D reference of each scene, by name of the scene.
    """
    out = []
    for name, ref in references.items():
        scene = cache.built_in_scene(name)
        answers = [solve_contact_loads(cache, name, m.name) for m in comparison.models_shown_for_scene(scene)]
        source = load_stored_run(scene, SOURCE_LEVEL, stores=cache.reference_folders)
        answers += comparison.solutions_of_reference_runs(ref, source)
        labels = [MODELS[a.model].label if a.model in MODELS else LABELS.get(a.model, a.model) for a in answers]
        rows: list[Row] = []
        for i, s in np.ndindex(ref.load.shape):
            if not any(a.load[i, s] > 0.0 for a in answers):
                continue
            truth, low = float(ref.load[i, s]), answers[0]
            row: Row = {"ball": i + 1, "flank": SIDES[s]}
            row |= {("load_of", label): float(a.load[i, s]) for label, a in zip(labels, answers, strict=True)}
            row["mesh_uncertainty_N"] = float(ref.uncertainty[i, s])
            row["load_error_refined"] = float(error_percent(low.load[i, s], truth)) if truth > 0.0 else None
            for words, angle in (("3D reference", ref.best.angle), ("refined model", low.angle)):
                row["contact_angle_of", words] = float(angle[i, s]) if np.isfinite(angle[i, s]) else None
            rows.append(row)
        title = f"Loads and contact angles of all contacts of {name} by every model"
        out.append(Table.from_rows(f"reference-loads-{name}", title, rows))
    return out


#: Names of the displacements along the axes of the scene; the screw lies along z.
DIRECTIONS = {"x": "lateral (x)", "y": "lateral (y)", "z": "axial (z)"}


def centreline_displacement_table(cache: SceneResultCache, references: References) -> Table:
    """Return the table of displacements of the screw's centreline along its length, by refined model and 3D reference.

    ``references``: 3D reference of each scene, by name of the scene.
    """
    rows: list[Row] = []
    for name, ref in references.items():
        low = solve_contact_loads(cache, name, "refined")
        line = ref.best.centreline
        for row in line:
            cells: Row = {"scene": name, "axial_position": 1e3 * float(row[0])}
            for k, axis in enumerate("xyz"):
                beam = float(np.interp(row[0], low.stations, low.line[:, k]))
                cells["screw_displacement_along", DIRECTIONS[axis], "3D reference"] = 1e6 * float(row[1 + k])
                cells["screw_displacement_along", DIRECTIONS[axis], "refined model"] = 1e6 * beam
            rows.append(cells)
    note = (
        "3D reference: mean displacement of the surface of the axial hole where the screw is meshed, near the nut; "
        "displacement of the beam nodes elsewhere."
    )
    title = "Displacement of the screw's centreline by the refined model and by the 3D reference"
    return Table.from_rows("reference-centreline", title, rows, note)


def contact_load_figures(cache: SceneResultCache, references: References) -> list[Figure]:
    """Draw the contact loads of all balls by all models, with the uncertainty of the 3D reference as a band.

    ``references``: 3D reference of each scene, by name of the scene. Each scene has a figure, with a panel for each flank.
    """
    out = []
    for name, ref in references.items():
        scene = cache.built_in_scene(name)
        models = [m for m in comparison.models_shown_for_scene(scene) if m.name != "lin-source-partition"]
        answers = {m: solve_contact_loads(cache, name, m.name) for m in models}
        panels = []
        for s in range(4):
            if not (ref.load[:, s] > 0.0).any() or (s >= 2 and len(ref.best.sides) == 2):
                continue
            series = [curves.contact_load_curve(f"3D reference, level {ref.best.level}", ref, s, emphasis=True)]
            bar = ref.uncertainty[:, s]
            low, high = map(curves.scale_to_python_floats, (ref.load[:, s] - bar, ref.load[:, s] + bar))
            series.insert(0, Series("uncertainty of the 3D reference", series[0].x, low, "band", high))
            series += [curves.contact_load_curve(m.label, a, s) for m, a in answers.items() if (a.load[:, s] > 0.0).any()]
            panels.append(curves.contact_load_panel(SIDES[s], *series))
        shown = f"{name} ({scene.title.partition(':')[0]})"
        title = f"Contact load of every ball of {shown}, by the low-order models and the 3D reference"
        out.append(Figure(f"reference-loads-{name}", title, tuple(panels)))
    return out


def centreline_displacement_figure(cache: SceneResultCache, references: References) -> Figure:
    """Draw the lateral displacement of the screw's centreline over its length, by refined model and 3D reference.

    ``references``: 3D reference of each scene, by name of the scene.
    """
    panels = []
    for name, ref in references.items():
        low = solve_contact_loads(cache, name, "refined")
        line = ref.best.centreline
        model = curves.lateral_displacement_curves(low.stations, low.line, "u{}, refined model")
        solid = curves.lateral_displacement_curves(line[:, 0], line[:, 1:], "u{}, 3D reference", "markers", emphasis=True)
        series = (x for pair in zip(model, solid, strict=True) for x in pair)
        panels.append(Panel(name, "axial position / mm", "displacement", tuple(series)))
    title = "Lateral displacement of the screw's centreline by the refined model and the 3D reference"
    return Figure("reference-centreline", title, tuple(panels))


def lin_model_check_paragraph(references: References, cache: SceneResultCache) -> str:
    """Return the paragraph on the load errors of Lin's model as ``rollbench check`` judges them.

    It states, for each scene, the largest error and the number of contacts beyond the limit. ``references``: 3D reference
    of each scene, by name of the scene.
    """
    worst = []
    for name, ref in references.items():
        points = comparison.contact_load_errors(ref, cache.solve_once(name, "lin").load)
        top = max(points, key=lambda p: abs(p.error))
        over = [p for p in points if p.exceeds(LIMIT)]
        worst.append(
            f"{name}: largest error {abs(top.error):.1f} % at ball {top.ball} {top.side}, "
            f"{len(over)} of {len(points)} contacts beyond {LIMIT:g} %"
        )
    return (
        f"Errors of Lin's model by rollbench check ({comparison.RULE}; a contact counts as beyond the limit if its error "
        f"minus the uncertainty of the reference exceeds it): {'; '.join(worst)}. Number of contacts beyond the limit "
        f"whose cause is known: {len(comparison.known_exceedances())}."
    )


def error_against_rigid_nut_reference(cache: SceneResultCache, name: str, ball: int, side: str) -> float | None:
    """Return the load error of Lin's model on one contact against a 3D model with a rigid nut [% of the contact's load].

    ``name``: name of the scene. ``ball``: number of the ball, from 1. ``side``: flank, one of SL, SR, NL, NR (screw left
    and right, nut left and right). Lin's model has a rigid nut, so this error excludes the effect of nut elasticity.
    Returns None if no 3D run with a rigid nut is stored, or if the contact is unloaded in this run.
    """
    run = load_stored_run(cache.built_in_scene(name), min(LEVELS), stores=cache.reference_folders)
    if run is None or "elastic nut" not in run.without:
        return None
    truth = float(run.without["elastic nut"][ball - 1, SIDES.index(side)])
    low = float(cache.solve_once(name, "lin").load[ball - 1, SIDES.index(side)])
    return float(error_percent(low, truth)) if truth > 0.0 else None


def contacts_beyond_check_limit_table(references: References, cache: SceneResultCache) -> Table:
    """Return the table of contacts on which the load error of Lin's model exceeds the limit of ``rollbench check``.

    Each row has the known cause of the error. ``references``: 3D reference of each scene, by name of the scene.
    """
    causes = {(x.scene, x.ball, x.side): x.cause for x in comparison.known_exceedances()}
    rows: list[Row] = []
    for name, ref in references.items():
        for p in comparison.contact_load_errors(ref, cache.solve_once(name, "lin").load):
            if p.exceeds(LIMIT):
                unknown = "not listed among the known causes: rollbench check fails"
                row: Row = {"scene": name, "ball": p.ball, "flank": p.side}
                row["load_of", "3D reference"] = float(ref.load[p.ball - 1, SIDES.index(p.side)])
                row |= {"load_error_lin": p.error, "mesh_uncertainty_own": p.uncertainty}
                row["load_error_rigid_nut"] = error_against_rigid_nut_reference(cache, name, p.ball, p.side)
                rows.append(row | {"cause": causes.get((name, p.ball, p.side), unknown)})
    note = f"Errors by the rule of rollbench check: {comparison.RULE}."
    title = f"Contacts whose load by Lin's model differs from the 3D reference by more than {LIMIT:g} %"
    return Table.from_rows("reference-exceedances", title, rows, note)


def make_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the section that compares the low-order models with the 3D reference on the case studies.

    ``step`` is called with each line of progress.
    """
    step("low-order models against the 3D reference")
    found = cache.stored_references(comparison.REFERENCED)
    title = "Contact loads by the low-order models and by the 3D reference"
    if not found:
        return Section("reference", title, (Text(("No run of the 3D reference is stored.",)),))
    runs: list[Run] = [run for ref in found.values() for run in ref.runs]
    versions = sorted({f"rollbench {r.versions['rollbench']}, gmsh {r.versions['gmsh']}, {r.date}" for r in runs})
    text = [
        (
            "The 3D reference is a finite-element model with elastic contact. gmsh meshes screw and nut with exact helical "
            "grooves, flat ends and a cut-out at every contact. A fine patch of 27-node hexahedra fills the cut-out; one "
            "patch per flank is condensed exactly and used for all balls. Balls are elastic and free to move, contact is "
            "unilateral and frictionless, and contact normals follow the motion. The reference shares only the description "
            f"of the parts with the low-order models. Computed: {'; '.join(versions)}."
        ),
        "The mesh uncertainty follows from the convergence of the mesh levels, fitted by least squares (Eca and Hoekstra "
        "2014) with one order for all contacts of a scene, and from the scatter of each contact about this fit; with two "
        "levels, it is three times their difference. Flanks are " + ", ".join(SIDES) + " (screw and nut, left and right).",
        lin_model_check_paragraph(found, cache),
    ]
    if cache.quick:
        quick = "QUICK REPORT: only coarse meshes were computed, so the mesh uncertainty is unknown. Do not base decisions "
        text.insert(0, f"{quick}on these numbers.")
    elif any(ref.best.level < PRODUCTION for ref in found.values()):
        text.insert(0, f"Some references were not computed up to mesh level {PRODUCTION}; their uncertainty is larger.")
    over = contacts_beyond_check_limit_table(found, cache)
    items: list[Any] = [Text(tuple(text)), load_error_table(cache, found)]
    items += [over] if over.rows else []
    items += [
        *contact_load_figures(cache, found),
        *contact_load_tables(cache, found),
        centreline_displacement_figure(cache, found),
        centreline_displacement_table(cache, found),
    ]
    items += run_time_items(cache, step)
    return Section("reference", title, tuple(items))
