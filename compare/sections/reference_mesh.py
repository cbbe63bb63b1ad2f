"""Report section on the uncertainty of the 3D reference: by its mesh, its modelling choices, and effects left out of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from rollbench.compare.measure import LoadError, error_percent, load_error
from rollbench.compare.models.comparison import REFERENCED
from rollbench.compare.models.modelling import REFINED, UNSEEN, VARIED, effects_of_changed_choices
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.models.uncertainty import SHARED, largest_uncertainty_near_face
from rollbench.compare.reference.estimate import Reference, largest_uncertainty_percent
from rollbench.compare.reference.levels import LEVELS, NOT_VARIED, SOURCE_LEVEL, SOURCE_MESH, VARIANTS
from rollbench.compare.reference.store import load_stored_run
from rollbench.compare.results.mesh_study import MeshStudy
from rollbench.compare.sections import u_val
from rollbench.compare.sections.reference import modelling_uncertainty_by_scene
from rollbench.compare.sections.reference_time import stored_reference_runs
from rollbench.compare.studies import mesh_study
from rollbench.reports.content import ColumnKey, Figure, Row, Section, Table, Text

References = Mapping[str, Reference]


def _load_change_cells(load_changes: LoadError, suffix: str = "") -> Row:
    """Return table cells on contact-load changes: largest and RMS change, and the contact with the largest change.

    ``load_changes``: differences of the contact loads between two 3D runs, one of which has one changed modelling choice
    or mesh setting. ``suffix``: end of the names of the columns, "_f3" for a third decimal.
    """
    return {
        f"largest_change{suffix}": load_changes.max_percent,
        f"rms_change{suffix}": load_changes.rms_percent,
        "at_largest_change": f"{load_changes.ball} {load_changes.side}",
    }


def _refines_one_mesh_setting(variant_name: str) -> bool:
    """Return whether the variant ``variant_name`` of the 3D reference refines one numerical setting of the mesh."""
    return variant_name in VARIANTS and bool(VARIANTS[variant_name].refined)


def mesh_level_table(cache: SceneResultCache, references: References) -> Table:
    """Return the table of the mesh levels of every scene: unknowns, load changes to finer levels, mesh quality.

    ``references``: 3D reference of each scene, by name of the scene.
    """
    rows: list[Row] = []
    for name, ref in references.items():
        runs = stored_reference_runs(name, ref, cache)
        for number, run in enumerate(runs):
            following = runs[number + 1] if number + 1 < len(runs) and run.level != SOURCE_LEVEL else None
            step = None if following is None else load_error(run.load, following.load, ref.contacts)
            change = None if following is None else float(error_percent(run.load.sum(), following.load.sum()))
            rows.append(
                {
                    "scene": name,
                    "level": "Lin's mesh" if run.level == SOURCE_LEVEL else str(run.level),
                    "elements_across_2b": run.quality["elements across 2b"],
                    "fine_flanks": len(run.sides),
                    "unknowns_of_single_mesh": run.unknowns,
                    "memory": "not measured" if run.peak_MB is None else run.peak_MB,
                    "largest_change_to_next_level": None if step is None else step.max_percent,
                    "rms_change_to_next_level": None if step is None else step.rms_percent,
                    "sum_change_to_next_level": change,
                    "largest_change_to_finest": load_error(run.load, ref.load, ref.contacts).max_percent,
                    "change_by_moving_normals": load_error(run.frozen, run.load, ref.contacts).max_percent,
                    "unbalanced_over_load": max(run.balance, run.screw_balance),
                    "net_force_along_groove": run.along_groove,
                    "scaled_jacobian": min(run.quality[k] for k in ("screw", "nut", "ball")),
                    "distance_from_surface": 1e6 * run.quality["deviation"],
                }
            )
    note = (
        "Elements across the short axis 2b of the contact ellipse: expected number in the least loaded scene with the same "
        "geometry. Forces are relative to the largest contact load. Peak memory of scenes with the same "
        "geometry is that of one common set-up."
    )
    title = "Changes of contact loads, unknowns and memory on each mesh level of the 3D reference"
    return Table.from_rows("reference-levels", title, rows, note)


def mesh_uncertainty_table(references: References) -> Table:
    """Return the table of the mesh uncertainty of the 3D contact loads of every scene, with its contributions.

    ``references``: 3D reference of each scene, by name of the scene.
    """
    rows: list[Row] = [
        {
            "scene": name,
            "levels": len(ref.runs),
            "scatter_by_contact_cells": p.contact_cell_deviation,
            "scatter_by_body_cells": p.body_cell_deviation,
            "scatter_by_boxes": p.refinement_box_deviation,
            "scatter_in_common": p.common_deviation,
            "mesh_uncertainty_rms": p.uncertainty,
            "mesh_uncertainty_near_face": largest_uncertainty_near_face(ref)[0],
            "largest_mesh_uncertainty": largest_uncertainty_percent(ref),
            "estimated_from_own_levels": "no" if p.is_from_other_scenes else "yes",
        }
        for name, ref in references.items()
        for p in (ref.parts,)
    ]
    note = (
        "The contributions are standard deviations of the difference between the finest mesh level and the next finer "
        "one, RMS over the contacts; the uncertainty is twice the root of the sum of their squares. Fine patches fill "
        "boxes that are cut out of the coarse meshes (refinement boxes). The contributions of bodies and boxes are "
        "distributed over the contacts in proportion to the contact stiffness, the cube root of the load. From level to "
        "level, contact cells are refined by 4/3 and body cells by 1.15; the size of the boxes does not change. No two "
        "levels share a cell, so loads scatter between levels and show no order of convergence. The first two "
        "contributions follow from load changes between the levels of the scene and decrease with the square of the cell "
        "size. The contribution of the boxes is half the variance caused by another number of cells on their edges. The "
        "common contribution follows from the mean load changes of all scenes in which equilibrium does not determine the"
        " sum of loads. Next to a free nut face, the compliance of the thin lip that the cells do not resolve is added "
        "where it exceeds all other contributions; it was measured on nuts alone with increasingly fine meshes."
    )
    title = "Mesh uncertainty of the contact loads of the 3D reference, by contribution"
    return Table.from_rows("reference-convergence", title, rows, note)


def mesh_uncertainty_test_table(cache: SceneResultCache) -> Table | None:
    """Return the table that tests the mesh uncertainty of each mesh level by the contact loads on a finer level.

    Returns None if runs of the 3D reference are missing.
    """
    found = u_val.check_uncertainty_of_all_mesh_levels(cache)
    if not found:
        return None
    groups = {name: [h for h in found if h.scene == name] for name in dict.fromkeys(h.scene for h in found)}
    several = [h for h in found if h.tested_level > min(LEVELS)]
    rows = [_mesh_uncertainty_test_row(name, group) for name, group in groups.items()]
    rows.append(_mesh_uncertainty_test_row("all shipped scenes", [h for h in found if not h.is_random_screw]))
    if any(h.is_random_screw for h in found):
        rows.append(_mesh_uncertainty_test_row("all drawn screws", [h for h in found if h.is_random_screw]))
    rows.append(_mesh_uncertainty_test_row("all", found))
    worst = min((h for h in several if h.contact_count >= u_val.MANY), key=lambda h: h.covered_share)
    note = (
        f"Of {sum(h.contact_count for h in several)} loads with an uncertainty from two mesh levels or more, "
        f"{100.0 * u_val.share_of_contacts_within_uncertainty(several):.1f} % change by less than it on the finer level; "
        f"in the worst scene with {u_val.MANY} contacts or more, {100.0 * worst.covered_share:.1f} % ({worst.scene}, "
        f"levels up to {worst.tested_level}). The aim is 95 %. Neither the finer level nor data of scenes with the same "
        "parts are used to estimate the uncertainty that is tested. Rows for several scenes show medians. Errors common to "
        "all meshes cannot be detected by this test."
    )
    title = "Test of the mesh uncertainty (95 %): share of contact loads that change by less on a finer mesh"
    return Table.from_rows("reference-coverage", title, rows, note)


def _mesh_uncertainty_test_row(first_cell: str, tests: Sequence[u_val.MeshUncertaintyTest]) -> Row:
    """Return the row of `mesh_uncertainty_test_table` for one scene, or for several scenes by medians over them.

    ``first_cell``: text in the first cell. ``tests``: tests of the mesh uncertainties of these scenes, on all mesh levels.
    """
    row: Row = {
        "scene": first_cell,
        "contacts": sum(h.contact_count for h in tests if h.tested_level == min(LEVELS)),
        "judging_level": ", ".join(map(str, sorted({h.finer_level for h in tests}))),
    }
    for k in sorted({h.tested_level for h in tests}):
        of_level = [h for h in tests if h.tested_level == k]
        levels = f"level {k} and other screws" if k == min(LEVELS) else f"levels {min(LEVELS)} to {k}"
        row |= {
            ("mesh_uncertainty_of_level", str(k), levels): float(np.median([h.uncertainty_percent for h in of_level])),
            ("share_within_uncertainty_of_level", str(k)): 100.0 * u_val.share_of_contacts_within_uncertainty(of_level),
        }
    return row


def common_error_paragraph(cache: SceneResultCache) -> str:
    """Return the paragraph on the error that all contact loads share and that the stated uncertainty does not include."""
    low, high = SHARED
    moves = [
        f"{e.choice} {float(e.change[e.change != 0.0].mean()):+.3f} %"
        for e in effects_of_changed_choices(cache.built_in_scene(REFINED), cache.reference_folders)
        if _refines_one_mesh_setting(e.variant)
    ]
    changes = ", ".join(moves)
    finer = f" On {REFINED}, refining one numerical choice at a time changes the mean load by: {changes}." if moves else ""
    return (
        "An error common to all contacts is not included in the stated uncertainty: for preloaded screws, independent 3D "
        f"programs, CalculiX among them (section crosscheck), give a sum of loads that is {low:g} to {high:g} % larger "
        f"than that of the 3D reference, always with this sign.{finer} No mesh of the reference shows this difference."
    )


def mesh_study_tables_and_figures(cache: SceneResultCache, references: References) -> list[Table | Figure]:
    """Return, for every scene solved on two mesh levels or more, its loads and displacements on each mesh level.

    These are a table and, if there is one, a figure for each scene. ``references``: 3D reference of each scene, by
    name of the scene.
    """
    out: list[Table | Figure] = []
    for name in references:
        ref = mesh_study.reference_from_stored_runs(cache.built_in_scene(name), cache.reference_folders)
        if ref is None or len(ref.runs) < 2:
            continue
        table = mesh_study.mesh_study_table_of_scene(cache.built_in_scene(name), cache.reference_folders)
        shown = mesh_study.quantities_without_single_balls(table)
        columns: dict[ColumnKey, list[Any]] = {"quantity": [x.name for x in shown], "unit": [x.unit for x in shown]}
        columns |= {("value_on_mesh_level", str(r.level)): [x.values[k] for x in shown] for k, r in enumerate(ref.runs)}
        names = {"order": "order", "extrapolated": "extrapolated", "value_uncertainty": "uncertainty"}
        names |= {"value_uncertainty_percent": "uncertainty_percent", "convergence_kind": "kind"}
        if any(x.modelling_spread is not None for x in shown):
            names |= {"value_uncertainty_by_choices": "modelling_spread", "value_change_by_choices": "scene_choices"}
        columns |= {column: [getattr(x, name) for x in shown] for column, name in names.items()}
        title = f"Contact loads and displacements of {name} on each mesh level"
        out.append(Table(f"mesh-study-{name}", title, columns, mesh_study.mesh_accuracy_sentence(ref)))
        sizes = tuple(mesh_study.mesh_levels_of_reference(ref))
        figure = MeshStudy(scene=name, levels=sizes, quantities=tuple(table)).figure()
        if figure is not None:
            out.append(figure)
    return out


#: Names in tables of the kinds of choices that are varied in the 3D reference: modelling, numerical, of the scene.
KINDS = {"modelling": "modelling choice", "numerical": "numerical setting", "scene": "unprinted input"}


def modelling_choice_table(cache: SceneResultCache) -> Table | None:
    """Return the table of the changes of contact loads when one modelling choice of the 3D reference is changed.

    It also has the error of Lin's model against the 3D reference with each changed choice. Returns None if no run with a
    changed choice is stored.
    """
    rows: list[Row] = []
    for name in VARIED:
        scene = cache.built_in_scene(name)
        low = cache.solve_once(name, "lin")
        for e in effects_of_changed_choices(scene, cache.reference_folders):
            if _refines_one_mesh_setting(e.variant):
                continue
            run = load_stored_run(scene, min(LEVELS), e.variant, cache.reference_folders)
            model = None if run is None else load_error(low.load, run.load)
            row: Row = {"scene": name, "varied_choice": e.choice, "varied_choice_after": e.label}
            row |= {"change_kind": KINDS[e.kind], **_load_change_cells(e.error)}
            row["load_ratio_change"] = e.ratio if np.isfinite(e.ratio) else None
            row["lin_error_with_change"] = None if model is None else model.max_percent
            rows.append(row | {"lin_rms_with_change": None if model is None else model.rms_percent})
    note = (
        "One choice is changed at a time on mesh level 1; changes are relative to the unchanged scene on the same level. "
        "Only modelling choices are part of the modelling uncertainty. Where the nut is fixed and where the "
        "groove of the screw ends are inputs that the publication does not print. The coupling of axial force and twist "
        "that beam models neglect is estimated here; the refined model includes it."
    )
    title = "Change of the 3D reference's contact loads (mesh level 1) by one modelling choice or unprinted input"
    return Table.from_rows("reference-spread", title, rows, note) if rows else None


def refined_mesh_setting_table(cache: SceneResultCache) -> Table | None:
    """Return the table of contact-load changes when one numerical setting of the finest mesh level is refined.

    The changes are compared with the mesh uncertainty of the loads. Returns None if no such run is stored.
    """
    scene, found, rows = cache.built_in_scene(REFINED), cache.stored_reference(REFINED), list[Row]()
    if found is None:
        return None
    grid = np.abs(error_percent(found.uncertainty, 0.0, found.mean))
    for e in effects_of_changed_choices(scene, cache.reference_folders):
        if not _refines_one_mesh_setting(e.variant):
            continue
        change = np.abs(e.change)
        row: Row = {"scene": REFINED, "numerical_setting": e.choice, "setting_after": e.label}
        row |= _load_change_cells(e.error, "_f3")
        row |= {
            "mesh_uncertainty_at_change": float(grid.flat[change.argmax()]),
            "largest_mesh_uncertainty": float(grid.max()),
        }
        rows.append(row | {"contacts_beyond_uncertainty": int((change > grid + 1e-9).sum())})
    note = (
        "One numerical choice at a time is refined beyond the finest mesh level; changes are relative to the unchanged "
        "scene on the finest level. The mesh uncertainty is the stated one with all its contributions."
    )
    title = "Change of contact loads when one numerical setting of the finest mesh level is refined"
    return Table.from_rows("reference-choices", title, rows, note) if rows else None


def modelling_uncertainty_table(cache: SceneResultCache) -> Table | None:
    """Return the table of the uncertainty of the 3D contact loads by modelling choices, for each choice and in total.

    Choices that were not varied are listed with the reason. Returns None if no run with a changed choice is stored.
    """
    found = cache.compute_once(modelling_uncertainty_by_scene)
    if not found:
        return None
    choices = dict.fromkeys(c for m in found.values() for c in m.choices)
    missing = dict.fromkeys(v.choice for v in VARIANTS.values() if v.kind == "modelling" and v.choice not in choices)
    values = {c: {name: m.choices.get(c) for name, m in found.items()} for c in choices}
    for words, total in (
        ("largest over the contacts", "largest"),
        ("RMS over the contacts", "rms"),
        ("ratio of largest to smallest load, SL", "ratio"),
    ):
        values[f"all choices combined, {words}"] = {name: getattr(m, total) for name, m in found.items()}
    rows: list[Row] = [
        {"modelling_choice": choice, **{("change_of_scene", name): value for name, value in of_scenes.items()}}
        for choice, of_scenes in values.items()
    ]
    reasons = dict.fromkeys(missing, "no run with this variation is stored") | NOT_VARIED
    rows += [{"modelling_choice": f"{choice}: not varied", "why_not_varied": why} for choice, why in reasons.items()]
    note = (
        "The effects of the choices are independent and of unknown sign, so on each contact they are combined as the root "
        "of the sum of squares; of several variants of one choice, the largest effect on the contact is taken. The RMS "
        "value is the error to expect on a typical contact; the largest value is quoted with the mesh uncertainty. "
        "This is an estimate from one typical variation of each choice, not a bound."
    )
    title = "Uncertainty of the 3D reference's contact loads by each modelling choice"
    return Table.from_rows("reference-modelling", title, rows, note)


#: Replacements of the 3D screw, and of all 3D bodies, in runs that leave out an effect.
BEAM = "the screw is a Timoshenko beam with homogenised section, with the local response of each contact"
RIGID = "the nut is rigid, the screw a beam, the ball rigid, each with the local response of each contact"
#: Effects that runs of the 3D reference leave out: what replaces each effect, and the set-up stages that are then saved.
INGREDIENTS = {
    "elastic nut": "the nut is rigid except for the local response of each contact",
    "3D shaft": BEAM,
    "finite ball": "the ball is rigid except for its contact patches",
    "patch coupling": RIGID,
    "moving normals": "contact normals and gaps stay those of the undeformed state",
}


def left_out_effects_table(cache: SceneResultCache, references: References) -> Table | None:
    """Return the table of changes of contact loads if one effect is left out of the 3D model.

    ``references``: 3D reference of each scene, by name of the scene. Returns None if no such run is stored.
    """
    rows: list[Row] = []
    for name in references:
        run = load_stored_run(cache.built_in_scene(name), min(LEVELS), stores=cache.reference_folders)
        if run is None or not run.without:
            continue
        low = cache.solve_once(name, "lin")
        full = load_error(low.load, run.load).max_percent
        for ingredient, loads in run.without.items():
            row: Row = {"scene": name, "effect_left_out": ingredient, "simplification": INGREDIENTS[ingredient]}
            row |= _load_change_cells(load_error(loads, run.load)) | {"lin_error_full_reference": full}
            rows.append(row | {"lin_error_reduced_reference": load_error(low.load, loads).max_percent})
    note = "On the coarsest mesh level. Effects that are small compared with the required accuracy can be left out."
    title = "Change of contact loads if one effect is left out of the 3D reference"
    return Table.from_rows("reference-ablation", title, rows, note) if rows else None


def rigid_nut_paragraph(effects: Table) -> str:
    """Return the paragraph on the error of Lin's model, which has a rigid nut, against a 3D reference with a rigid nut.

    ``effects``: `left_out_effects_table`.
    """
    parts = [
        f"{row['scene']} from {row['lin_error_full_reference']:.2f} % to {row['lin_error_reduced_reference']:.2f} %"
        for row in effects.rows
        if row["effect_left_out"] == "elastic nut"
    ]
    if not parts:
        return ""
    return (
        "If the nut of the 3D reference is made rigid, as in Lin's model, the largest error of that model (in per cent of "
        f"the mean load) changes: {'; '.join(parts)}. The rest is due to beam, section and contact law together."
    )


def mesh_uncertainty_sentence(references: References) -> str:
    """Return the sentence on the range, over all scenes, of the mesh uncertainty of the 3D contact loads.

    ``references``: 3D reference of each scene, by name of the scene; if there is none, the text is empty.
    """
    bars = [largest_uncertainty_percent(ref) for ref in references.values()]
    if not bars:
        return ""
    return (
        f"The mesh uncertainty (95 %) of the 3D reference's contact loads is {min(bars):.2f} to {max(bars):.2f} % of the "
        f"mean load, on the worst contact of each of {len(bars)} scenes. Modelling choices matter more, above all where "
        "the nut is fixed."
    )


def make_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the section on the uncertainty of the 3D reference: by its mesh and by its modelling choices.

    ``step`` is called with each line of progress.
    """
    step("mesh levels, mesh study, modelling choices, left-out effects")
    found, everything = cache.stored_references(REFERENCED), cache.stored_references((*REFERENCED, *UNSEEN))
    text = [
        (
            "From level to level all cells are refined, those of the contacts by a third; the boxes for the fine "
            "patches keep their size. The mesh of Lin's thesis has first-order tetrahedra of "
            f"{1000.0 * SOURCE_MESH['tet']:g} mm around every contact and {1000.0 * SOURCE_MESH['cell']:g} mm elsewhere; "
            "it is condensed by the same method."
        )
    ]
    assumed = list(dict.fromkeys(a for ref in found.values() for a in ref.best.assumed))
    if assumed:
        text.append("Assumptions where Lin's thesis prints no value: " + " ".join(assumed))
    items: list[Any] = [Text(tuple(text))]
    if everything:
        items += [mesh_uncertainty_table(everything), Text((common_error_paragraph(cache),))]
        items += [mesh_uncertainty_test_table(cache), mesh_level_table(cache, everything)]
    if found:
        items += mesh_study_tables_and_figures(cache, found)
    items += [refined_mesh_setting_table(cache), modelling_uncertainty_table(cache), modelling_choice_table(cache)]
    ablation = left_out_effects_table(cache, found)
    cause = "" if ablation is None else rigid_nut_paragraph(ablation)
    items += [Text((cause,)) if cause else None, ablation]
    shown = tuple(item for item in items if item is not None)
    title = "Uncertainty of the contact loads of the 3D reference"
    return Section("reference-mesh", title, shown, conclusion=mesh_uncertainty_sentence(everything))
