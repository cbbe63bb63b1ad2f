"""Report section on the uncertainty of the 3D reference: by its mesh, its modelling choices, and effects left out of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from rollbench.compare.measure import LoadError, error_percent, load_error
from rollbench.compare.models.comparison import REFERENCED
from rollbench.compare.models.modelling import REFINED, UNSEEN, VARIED, effects_of_changed_choices
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.models.uncertainty import SHARED, largest_uncertainty_near_face
from rollbench.compare.reference.estimate import Reference, largest_uncertainty_percent
from rollbench.compare.reference.levels import LEVELS, NOT_VARIED, SOURCE_LEVEL, SOURCE_MESH, VARIANTS
from rollbench.compare.reference.store import MeasuringConditions, Run, load_stored_run, most_frequent_measuring_conditions
from rollbench.compare.results.mesh_study import MeshStudy
from rollbench.compare.sections import u_val
from rollbench.compare.sections.reference import modelling_uncertainty_by_scene, references_of_case_studies
from rollbench.compare.studies import mesh_study
from rollbench.lowfi.statics.result import StaticResult
from rollbench.reports.content import Cell, Figure, Row, Section, Table, TableColumn, Text, load_percent_column, text_column

References = Mapping[str, Reference]


def _load_change_cells(load_changes: LoadError, number_format: str = ".2f") -> Row:
    """Return table cells on contact-load changes: largest and RMS change, and the contact with the largest change.

    ``load_changes``: differences of the contact loads between two 3D runs, one of which has one changed modelling choice
    or mesh setting. ``number_format``: number format of the largest and the RMS change.
    """
    return {
        load_percent_column("max", "largest change of a contact load", number_format): load_changes.max_percent,
        load_percent_column("rms", "RMS change of the contact loads", number_format): load_changes.rms_percent,
        text_column("at", "ball and flank with the largest change"): f"{load_changes.ball} {load_changes.side}",
    }


def _refines_one_mesh_setting(variant_name: str) -> bool:
    """Return whether the variant ``variant_name`` of the 3D reference refines one numerical setting of the mesh."""
    return variant_name in VARIANTS and bool(VARIANTS[variant_name].refined)


def mesh_level_table(cache: SceneResultCache, references: References) -> Table:
    """Return the table of the mesh levels of every scene: unknowns, run times, load changes to finer levels, mesh quality.

    ``references``: 3D reference of each scene, by name of the scene.
    """
    rows: list[Row] = []
    common = most_frequent_measuring_conditions(run.measured for ref in references.values() for run in ref.runs)
    for name, ref in references.items():
        source = load_stored_run(cache.built_in_scene(name), SOURCE_LEVEL, stores=cache.reference_folders)
        runs = ([source] if source else []) + list(ref.runs)
        for number, run in enumerate(runs):
            frozen = load_error(run.frozen, run.load, ref.contacts)
            following = runs[number + 1] if number + 1 < len(runs) and run.level != SOURCE_LEVEL else None
            step = None if following is None else load_error(run.load, following.load, ref.contacts)
            largest, rms = (None, None) if step is None else (step.max_percent, step.rms_percent)
            change = None if following is None else float(error_percent(run.load.sum(), following.load.sum()))
            best = load_error(run.load, ref.load, ref.contacts)
            times = (run.setup_seconds, run.solve_seconds) if run.measured == common else (None, None)
            jacobian = min(run.quality[k] for k in ("screw", "nut", "ball"))
            rows.append(
                {
                    "scene": name,
                    text_column("level", "mesh level"): "Lin's mesh" if run.level == SOURCE_LEVEL else str(run.level),
                    TableColumn("across", "elements across the contact ellipse's short axis 2b", "", ".1f"): run.quality[
                        "elements across 2b"
                    ],
                    text_column("sides", "number of groove flanks (of SL, SR, NL, NR) that are finely meshed"): len(
                        run.sides
                    ),
                    text_column(
                        "unknowns", "number of unknowns of a single mesh of all bodies, equally fine at the contacts"
                    ): run.unknowns,
                    TableColumn("setup", "run time of the set-up", "s", ".1f"): times[0],
                    TableColumn("solve", "run time of a load case", "s", ".1f"): times[1],
                    TableColumn("memory", "peak memory", "MB", ".0f"): "not measured"
                    if run.peak_MB is None
                    else run.peak_MB,
                    load_percent_column("change", "largest change of a contact load to the next level"): largest,
                    load_percent_column("rms", "RMS change of the contact loads to the next level"): rms,
                    TableColumn("sum", "change of the sum of loads to the next level", "%", "+.2f"): change,
                    load_percent_column("best", "largest change of a contact load to the finest level"): best.max_percent,
                    load_percent_column("frozen", "largest load change by updating contact normals"): frozen.max_percent,
                    TableColumn(
                        "balance", "largest unbalanced force on a ball or the screw / largest contact load", "", "g2"
                    ): max(run.balance, run.screw_balance),
                    TableColumn(
                        "along", "largest net force on a ball along the groove / largest contact load", "", "g2"
                    ): run.along_groove,
                    TableColumn("jacobian", "smallest scaled Jacobian of the elements", "", ".2f"): jacobian,
                    TableColumn(
                        "deviation", "largest distance of the coarse meshes from the exact groove surface", "um", "g2"
                    ): 1e6 * run.quality["deviation"],
                }
            )
    note = (
        "Elements across the short axis 2b of the contact ellipse: expected number in the least loaded scene with the same "
        "geometry. Forces are relative to the largest contact load. Set-up time and peak memory of scenes with the same "
        f"geometry are those of one common set-up. {_measured_times_sentence(common)}"
    )
    title = "Changes of contact loads, unknowns and run times on each mesh level of the 3D reference"
    return Table.from_rows("reference-levels", title, rows, note)


def mesh_uncertainty_table(references: References) -> Table:
    """Return the table of the mesh uncertainty of the 3D contact loads of every scene, with its contributions.

    ``references``: 3D reference of each scene, by name of the scene.
    """
    rows: list[Row] = [
        {
            "scene": name,
            text_column("levels", "number of mesh levels"): len(ref.runs),
            load_percent_column(
                "contact", "standard deviation of loads due to the cell size at the contacts", ".3f"
            ): p.contact_cell_deviation,
            load_percent_column(
                "bodies", "standard deviation of loads due to the cell size in the bodies", ".3f"
            ): p.body_cell_deviation,
            load_percent_column(
                "sockets", "standard deviation of loads due to the finely meshed boxes at the contacts", ".3f"
            ): p.refinement_box_deviation,
            load_percent_column(
                "common", "standard deviation of the load error that all contacts have in common", ".3f"
            ): p.common_deviation,
            load_percent_column("bar", "mesh uncertainty (95 %), RMS over the contacts", ".3f"): p.uncertainty,
            load_percent_column(
                "beside", "largest mesh uncertainty next to a free nut face", ".3f"
            ): largest_uncertainty_near_face(ref)[0],
            load_percent_column(
                "largest", "largest mesh uncertainty of a contact load", ".3f"
            ): largest_uncertainty_percent(ref),
            text_column("from", "whether the uncertainty is estimated from mesh levels of this screw or bearing"): "no"
            if p.is_from_other_scenes
            else "yes",
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
    levels = sorted({h.tested_level for h in found})
    groups = {name: [h for h in found if h.scene == name] for name in dict.fromkeys(h.scene for h in found)}
    several = [h for h in found if h.tested_level > min(LEVELS)]
    rows: list[dict[str, Cell]] = [_mesh_uncertainty_test_row(name, group) for name, group in groups.items()]
    rows.append(_mesh_uncertainty_test_row("all shipped scenes", [h for h in found if not h.is_random_screw]))
    if any(h.is_random_screw for h in found):
        rows.append(_mesh_uncertainty_test_row("all drawn screws", [h for h in found if h.is_random_screw]))
    rows.append(_mesh_uncertainty_test_row("all", found))
    columns = [text_column("scene", "scene"), text_column("contacts", "number of contacts")]
    columns.append(text_column("judge", "finer mesh level whose loads test the uncertainty"))
    for k in levels:
        words = f"level {k} and other screws" if k == min(LEVELS) else f"levels {min(LEVELS)} to {k}"
        columns.append(load_percent_column(f"bar {k}", f"mesh uncertainty of level {k}, from {words}", ".3f"))
        columns.append(TableColumn(f"held {k}", f"loads within the mesh uncertainty of level {k}", "%", ".1f"))
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
    return Table("reference-coverage", title, tuple(columns), rows, note)


def _mesh_uncertainty_test_row(first_cell: str, tests: Sequence[u_val.MeshUncertaintyTest]) -> dict[str, Cell]:
    """Return the row of `mesh_uncertainty_test_table` for one scene, or for several scenes by medians over them.

    ``first_cell``: text in the first cell. ``tests``: tests of the mesh uncertainties of these scenes, on all mesh levels.
    """
    row: dict[str, Cell] = {
        "scene": first_cell,
        "contacts": sum(h.contact_count for h in tests if h.tested_level == min(LEVELS)),
    }
    row["judge"] = ", ".join(map(str, sorted({h.finer_level for h in tests})))
    for k in sorted({h.tested_level for h in tests}):
        of_level = [h for h in tests if h.tested_level == k]
        row |= {
            f"bar {k}": float(np.median([h.uncertainty_percent for h in of_level])),
            f"held {k}": 100.0 * u_val.share_of_contacts_within_uncertainty(of_level),
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


def _measured_times_sentence(conditions: MeasuringConditions | None) -> str:
    """Return the sentence on the conditions under which the run times of a table were measured.

    ``conditions``: program version and machine of most runs; times of other runs are left out of the table.
    """
    return f"Times were measured with {conditions}; times from other measurements are left out."


#: Names of the stages of a 3D computation in column headings, by their names in stored runs.
STAGES = {
    "meshes": "coarse meshes of all parts",
    "patches": "compliance of the fine patches at the contacts",
    "shaft section": "beam stiffness of the shaft outside the 3D mesh",
    "screw": "compliance of the screw at the contacts",
    "nut": "compliance of the nut at the contacts",
    "ball": "compliance of a ball at its contacts",
}


def stage_time_table(references: References) -> Table:
    """Return the table of the run time of each stage of the 3D reference on its finest mesh level, scene by scene.

    ``references``: 3D reference of each scene, by name of the scene.
    """
    rows: list[dict[str, Cell]] = []
    common = most_frequent_measuring_conditions(ref.best.measured for ref in references.values())
    for name, ref in references.items():
        if ref.best.measured != common:
            continue
        rows.append({"scene": name, "contact": ref.best.solve_seconds, **ref.best.stages})
    names = list(dict.fromkeys(k for row in rows for k in row if k not in ("scene", "contact")))
    columns = [text_column("scene", "scene"), *(TableColumn(k, f"run time: {STAGES.get(k, k)}", "s", ".1f") for k in names)]
    columns.append(TableColumn("contact", "run time: one load case", "s", ".1f"))
    note = f"Scenes with the same geometry share all stages except the load case. {_measured_times_sentence(common)}"
    title = "Run time of each stage of the 3D computation on its finest mesh level"
    return Table("reference-stages", title, columns, rows, note)


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
        rows = [x.as_json() for x in table if "load of ball" not in x.name]
        columns = [
            text_column("quantity", "quantity"),
            text_column("unit", "unit"),
            *(TableColumn(f"level {r.level}", f"value on mesh level {r.level}", "", "g5") for r in ref.runs),
            TableColumn("order", "observed order of convergence", "", ".2f"),
            TableColumn("extrapolated", "value extrapolated to cell size zero", "", "g5"),
            TableColumn("uncertainty", "mesh uncertainty of the value", "", "g2"),
            TableColumn("uncertainty_percent", "relative mesh uncertainty of the value", "%", ".2f"),
            text_column("kind", "kind of convergence over the mesh levels"),
        ]
        if any(row.get("modelling_spread") is not None for row in rows):
            columns.append(TableColumn("modelling_spread", "uncertainty of the value by modelling choices", "", "g2"))
            words = "largest change of the value when one modelling choice is varied on this screw"
            columns.append(TableColumn("scene_choices", words, "", "g2"))
        title, note = (
            f"Contact loads and displacements of {name} on each mesh level",
            mesh_study.mesh_accuracy_sentence(ref),
        )
        out.append(Table(f"mesh-study-{name}", title, columns, rows, note))
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
            largest, rms = (None, None) if model is None else (model.max_percent, model.rms_percent)
            ratio = e.ratio if np.isfinite(e.ratio) else None
            rows.append(
                {
                    "scene": name,
                    text_column("choice", "modelling choice or unprinted input that is changed"): e.choice,
                    text_column("variant", "modelling choice or input after the change"): e.label,
                    text_column("kind", "kind of the change"): KINDS[e.kind],
                    **_load_change_cells(e.error),
                    TableColumn(
                        "ratio", "change of the ratio of largest to smallest load on the left screw flank (SL)", "%", "+.2f"
                    ): ratio,
                    load_percent_column(
                        "model", "largest load error of Lin's model against the 3D reference with this change"
                    ): largest,
                    load_percent_column(
                        "model_rms", "RMS load error of Lin's model against the 3D reference with this change"
                    ): rms,
                }
            )
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
        at = np.unravel_index(int(np.abs(e.change).argmax()), e.change.shape)
        beyond = int((np.abs(e.change) > grid + 1e-9).sum())
        rows.append(
            {
                "scene": REFINED,
                text_column("choice", "numerical setting that is refined"): e.choice,
                text_column("variant", "value after the refinement"): e.label,
                **_load_change_cells(e.error, ".3f"),
                load_percent_column("grid", "mesh uncertainty of the contact load with the largest change", ".3f"): float(
                    grid[at]
                ),
                load_percent_column("largest", "largest mesh uncertainty of a contact load", ".3f"): float(grid.max()),
                text_column("beyond", "contacts whose load changes by more than its mesh uncertainty"): beyond,
            }
        )
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
    found = modelling_uncertainty_by_scene(cache)
    if not found:
        return None
    choices = dict.fromkeys(c for m in found.values() for c in m.choices)
    missing = dict.fromkeys(v.choice for v in VARIANTS.values() if v.kind == "modelling" and v.choice not in choices)
    together = {
        "all choices combined, largest over the contacts": {name: m.largest for name, m in found.items()},
        "all choices combined, RMS over the contacts": {name: m.rms for name, m in found.items()},
        "all choices combined, ratio of largest to smallest load, SL": {name: m.ratio for name, m in found.items()},
    }
    values = {c: {name: m.choices[c] for name, m in found.items() if c in m.choices} for c in choices} | together
    rows: list[dict[str, Cell]] = [{"choice": choice, **of_scenes} for choice, of_scenes in values.items()]
    rows += [{"choice": f"{c}: not varied", "why": "no run with this variation is stored"} for c in missing]
    rows += [{"choice": f"{n.choice}: not varied", "why": n.reason} for n in NOT_VARIED]
    columns = [
        text_column("choice", "modelling choice"),
        *(load_percent_column(name, f"{name}, largest change of a contact load") for name in found),
        text_column("why", "reason why this modelling choice was not varied"),
    ]
    note = (
        "The effects of the choices are independent and of unknown sign, so on each contact they are combined as the root "
        "of the sum of squares; of several variants of one choice, the largest effect on the contact is taken. The RMS "
        "value is the error to expect on a typical contact; the largest value is quoted with the mesh uncertainty. "
        "This is an estimate from one typical variation of each choice, not a bound."
    )
    title = "Uncertainty of the 3D reference's contact loads by each modelling choice"
    return Table("reference-modelling", title, columns, rows, note)


#: Replacements of the 3D screw, and of all 3D bodies, in runs that leave out an effect.
BEAM = "the screw is a Timoshenko beam with homogenised section, with the local response of each contact"
RIGID = "the nut is rigid, the screw a beam, the ball rigid, each with the local response of each contact"
#: Effects that runs of the 3D reference leave out: what replaces each effect, and the set-up stages that are then saved.
INGREDIENTS: dict[str, tuple[str, tuple[str, ...]]] = {
    "elastic nut": ("the nut is rigid except for the local response of each contact", ("nut",)),
    "3D shaft": (BEAM, ("screw",)),
    "finite ball": ("the ball is rigid except for its contact patches", ("ball",)),
    "patch coupling": (RIGID, ("screw", "nut")),
    "moving normals": ("contact normals and gaps stay those of the undeformed state", ()),
}


def _scenes_with_effects_left_out(cache: SceneResultCache) -> Iterator[tuple[str, Run, StaticResult]]:
    """Yield the case studies with stored 3D runs that leave out one effect at a time, such as the nut's elasticity.

    For each, the name of the scene, its run on the coarsest mesh level, and the solution by Lin's model are yielded.
    """
    for name in references_of_case_studies(cache):
        run = load_stored_run(cache.built_in_scene(name), min(LEVELS), stores=cache.reference_folders)
        if run is not None and run.without:
            yield name, run, cache.solve_once(name, "lin")


def left_out_effects_table(cache: SceneResultCache) -> Table | None:
    """Return the table of changes of contact loads and run time if one effect is left out of the 3D model.

    Returns None if no such run is stored.
    """
    rows: list[Row] = []
    common = most_frequent_measuring_conditions(run.measured for _, run, _ in _scenes_with_effects_left_out(cache))
    for name, run, low in _scenes_with_effects_left_out(cache):
        full = load_error(low.load, run.load).max_percent
        for ingredient, loads in run.without.items():
            e, model = load_error(loads, run.load), load_error(low.load, loads)
            meaning, stages = INGREDIENTS[ingredient]
            saved = sum(run.stages.get(k, 0.0) for k in stages)
            saved += run.solve_seconds - run.without_seconds[ingredient]
            rows.append(
                {
                    "scene": name,
                    text_column("without", "effect left out of the 3D reference"): ingredient,
                    text_column("meaning", "simplification that replaces the effect"): meaning,
                    **_load_change_cells(e),
                    TableColumn("seconds", "run time saved", "s", "+.1f"): saved if run.measured == common else None,
                    load_percent_column("before", "largest load error of Lin's model against the full 3D reference"): full,
                    load_percent_column(
                        "model", "largest load error of Lin's model against the reduced 3D reference"
                    ): model.max_percent,
                }
            )
    note = "On the coarsest mesh level. Effects that are small compared with the required accuracy can be left out. "
    note += _measured_times_sentence(common)
    title = "Change of contact loads and run time if one effect is left out of the 3D reference"
    return Table.from_rows("reference-ablation", title, rows, note) if rows else None


def rigid_nut_paragraph(cache: SceneResultCache) -> str:
    """Return the paragraph on the error of Lin's model, which has a rigid nut, against a 3D reference with a rigid nut."""
    parts = []
    for name, run, low in _scenes_with_effects_left_out(cache):
        if "elastic nut" not in run.without:
            continue
        before, after = load_error(low.load, run.load), load_error(low.load, run.without["elastic nut"])
        parts.append(f"{name} from {before.max_percent:.2f} % to {after.max_percent:.2f} %")
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
    found, everything = references_of_case_studies(cache), cache.stored_references((*REFERENCED, *UNSEEN))
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
        items += [stage_time_table(found), *mesh_study_tables_and_figures(cache, found)]
    items += [refined_mesh_setting_table(cache), modelling_uncertainty_table(cache), modelling_choice_table(cache)]
    cause, ablation = rigid_nut_paragraph(cache), left_out_effects_table(cache)
    items += [Text((cause,)) if cause and ablation else None, ablation]
    shown = tuple(item for item in items if item is not None)
    title = "Uncertainty of the contact loads of the 3D reference"
    return Section("reference-mesh", title, shown, conclusion=mesh_uncertainty_sentence(everything))
