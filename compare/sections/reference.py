"""Section on low-order models against the 3D reference: errors with its uncertainty, loads, axis of the screw, times."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from rollbench.compare.gate.verdict import LIMIT
from rollbench.compare.measure import LoadError, error_percent, load_error
from rollbench.compare.models.comparison import (
    PRINTED,
    REFERENCED,
    RULE,
    Loads,
    from_result,
    gate_points,
    known_exceedances,
    load_ratio,
    reference_answers,
    suitable_models,
)
from rollbench.compare.models.modelling import VARIED, Modelling, combine_effects, modelling_percent, varied
from rollbench.compare.models.registry import MODELS
from rollbench.compare.models.study import Study
from rollbench.compare.printed import entry
from rollbench.compare.reference.estimate import Reference, uncertainty_percent
from rollbench.compare.reference.levels import LEVELS, PRODUCTION, SOURCE_LEVEL
from rollbench.compare.reference.store import Run, load_run
from rollbench.compare.sections.curves import lateral_displacement_curves, load_curve, load_panel, plain_numbers
from rollbench.compare.sections.reference_time import time_items
from rollbench.meshes.parts import SIDES
from rollbench.reports.content import Figure, Panel, Quantity, Row, Section, Series, Table, Text

References = Mapping[str, Reference]


def case_studies(study: Study) -> dict[str, Reference]:
    """Return the stored references of the case studies."""
    return study.references(REFERENCED)


def modelling_uncertainties(study: Study) -> dict[str, Modelling]:
    """Return the modelling uncertainty of the scenes whose modelling choices were varied."""
    return study.once(_compute_modelling_uncertainty)


def _compute_modelling_uncertainty(study: Study) -> dict[str, Modelling]:
    """Compute the modelling uncertainty for `modelling_uncertainties`."""
    scenes = [study.scene(name) for name in VARIED]
    found = {scene.name: combine_effects(scene, varied(scene, study.stores)) for scene in scenes}
    return {name: m for name, m in found.items() if m is not None}


def solve_by_model(study: Study, name: str, model: str) -> Loads:
    """Return loads and displacements of a scene by a low-order model."""
    return from_result(study.solve(name, model))


def error_table(study: Study, found: References) -> Table:
    """Return the table of errors against the finest level: of low-order models, the source's mesh, coarser levels."""
    rows: list[Row] = []
    modelled = modelling_uncertainties(study)
    for name, ref in found.items():
        scene, bars = study.scene(name), (uncertainty_percent(ref), modelling_percent(name, modelled))
        keys = PRINTED.get(name)
        for model in suitable_models(scene):
            result = study.solve(name, model.name)
            e = load_error(result.load, ref.load, ref.contacts)
            shown = keys[:2] if keys and model.name == "lin" else ()
            printed = " / ".join(entry("lin-2.4.1", k).printed for k in shown) or "–"
            rows.append(_error_row((name, model.label), e, load_ratio(result.load), printed, bars))
        source = load_run(scene, SOURCE_LEVEL, stores=study.stores)
        for coarser in reference_answers(ref, source):
            if coarser.model != f"3D level {ref.best.level}":
                e = load_error(coarser.load, ref.load, ref.contacts)
                rows.append(_error_row((name, LABELS[coarser.model]), e, load_ratio(coarser.load), "–", bars))
        rows.append(_error_row((name, LABELS[f"3D level {ref.best.level}"]), None, load_ratio(ref.load), None, bars))
    note = (
        "Errors against the finest level of the 3D reference. Printed: the source's low-order model against "
        "its ANSYS model, whose loads are not printed; its errors are relative to the own load. Grid "
        "uncertainty: the reference's, largest of any contact. Its modelling uncertainty, the effect of "
        "idealisations and unprinted dimensions, is stated separately (section reference-mesh) and deducted "
        "nowhere; section u-val combines both with the input tolerances."
    )
    return Table.of("reference-errors", "Errors of the low-order models against the 3D reference on each scene", rows, note)


LABELS = {
    "3D source mesh": "3D reference, the source's mesh",
    **{f"3D level {level}": f"3D reference, level {level}" for level in LEVELS},
}


def _error_row(
    named: tuple[str, str], e: LoadError | None, ratio: float, printed: str | None, bars: tuple[float | None, float | None]
) -> Row:
    """Return a row of `error_table`; ``bars``: uncertainty by grid and by modelling choices."""
    errors: Sequence[float | None] = (None,) * 4
    if e is not None:
        errors = e.max_percent, e.rms_percent, e.own_max_percent, e.own_rms_percent
    return {
        "scene": named[0],
        "model": named[1],
        Quantity("max", "largest error", "% of mean", ".2f"): errors[0],
        Quantity("at", "at ball", "", "s"): None if e is None else f"{e.ball} {e.side}",
        Quantity("rms", "RMS error", "% of mean", ".2f"): errors[1],
        Quantity("own_max", "largest error", "% of own load", ".2f"): errors[2],
        Quantity("own_rms", "RMS error", "% of own load", ".2f"): errors[3],
        Quantity("printed", "printed max / RMS", "%", "s"): printed,
        Quantity("bar", "grid uncertainty", "% of mean", ".2f"): bars[0],
        Quantity("modelling", "its modelling uncertainty", "% of mean", ".2f"): bars[1],
        Quantity("load_ratio", "largest : smallest on SL", "", ".3f"): ratio,
    }


def load_tables(study: Study, found: References) -> list[Table]:
    """Return a table for each scene with every contact load by every model."""
    out = []
    for name, ref in found.items():
        scene = study.scene(name)
        answers = [solve_by_model(study, name, m.name) for m in suitable_models(scene)]
        answers += reference_answers(ref, load_run(scene, SOURCE_LEVEL, stores=study.stores))
        headings = [MODELS[a.model].label if a.model in MODELS else LABELS.get(a.model, a.model) for a in answers]
        loads = [Quantity(f"m{k}", head, "N", ".1f") for k, head in enumerate(headings)]
        rows: list[Row] = []
        for i, s in np.ndindex(ref.load.shape):
            if not any(a.load[i, s] > 0.0 for a in answers):
                continue
            truth, low = float(ref.load[i, s]), answers[0]
            bar = None if ref.uncertainty is None else float(ref.uncertainty[i, s])
            error = float(error_percent(low.load[i, s], truth)) if truth > 0.0 else None
            rows.append(
                {
                    "ball": i + 1,
                    "side": SIDES[s],
                    **{q: float(a.load[i, s]) for q, a in zip(loads, answers, strict=True)},
                    Quantity("bar", "uncertainty of the reference", "N", ".2f"): bar,
                    Quantity("error", "error of the refined model", "% of own load", "+.2f"): error,
                    Quantity("angle", "contact angle, reference", "deg", ".2f"): _number_or_none(ref.best.angle[i, s]),
                    Quantity("low_angle", "contact angle, refined model", "deg", ".2f"): _number_or_none(low.angle[i, s]),
                }
            )
        out.append(Table.of(f"reference-loads-{name}", f"{name}: contact loads and angles", rows))
    return out


def _number_or_none(value: Any) -> float | None:
    return float(value) if np.isfinite(value) else None


def line_table(study: Study, found: References) -> Table:
    """Return the table of the screw axis displacement at the reference's stations, by refined model and reference."""
    rows: list[Row] = []
    for name, ref in found.items():
        low = solve_by_model(study, name, "refined")
        line = ref.best.centreline
        for row in line:
            cells: Row = {"scene": name, Quantity("z", "station", "mm", ".1f"): 1e3 * float(row[0])}
            for k, axis in enumerate("xyz"):
                beam = float(np.interp(row[0], low.stations, low.line[:, k]))
                cells[Quantity(f"r{axis}", f"u{axis}, reference", "µm", ".2f")] = 1e6 * float(row[1 + k])
                cells[Quantity(f"l{axis}", f"u{axis}, refined model", "µm", ".2f")] = 1e6 * beam
            rows.append(cells)
    note = "Mean motion of the meshed screw's hole inside the nut's reach, of the beam's nodes outside."
    return Table.of("reference-centreline", "Displacement of the screw's centreline by each model", rows, note)


def load_figures(study: Study, found: References) -> list[Figure]:
    """Draw the loads of all models on one axis, with the reference's uncertainty as a band."""
    out = []
    for name, ref in found.items():
        scene = study.scene(name)
        answers = {
            m: solve_by_model(study, name, m.name) for m in suitable_models(scene) if m.name != "lin-source-partition"
        }
        panels = []
        for s in range(4):
            if not (ref.load[:, s] > 0.0).any() or (s >= 2 and len(ref.best.sides) == 2):
                continue
            series = [load_curve(f"3D reference, level {ref.best.level}", ref, s, emphasis=True)]
            if ref.uncertainty is not None:
                low, high = ref.load[:, s] - ref.uncertainty[:, s], ref.load[:, s] + ref.uncertainty[:, s]
                series.insert(0, Series("its uncertainty", series[0].x, plain_numbers(low), "band", plain_numbers(high)))
            series += [load_curve(m.label, a, s) for m, a in answers.items() if (a.load[:, s] > 0.0).any()]
            panels.append(load_panel(SIDES[s], *series))
        out.append(Figure(f"reference-loads-{name}", f"{name}: contact loads of all models", tuple(panels)))
    return out


def line_figure(study: Study, found: References) -> Figure:
    """Draw the lateral deflection of the screw: beam against 3D."""
    panels = []
    for name, ref in found.items():
        low = solve_by_model(study, name, "refined")
        line = ref.best.centreline
        model = lateral_displacement_curves(low.stations, low.line, "u{}, refined model")
        solid = lateral_displacement_curves(line[:, 0], line[:, 1:], "u{}, 3D reference", "markers", emphasis=True)
        series = (x for pair in zip(model, solid, strict=True) for x in pair)
        panels.append(Panel(name, "station / mm", "displacement / µm", tuple(series)))
    return Figure("reference-centreline", "Lateral displacement of the screw's centreline over its length", tuple(panels))


def gate_text(found: References, study: Study) -> str:
    """Return a sentence on the contacts beyond the gate's limit, from the data."""
    worst = []
    for name, ref in found.items():
        points = gate_points(name, ref, LIMIT, study.solve(name, "lin").load)
        top = max(points, key=lambda p: abs(p.error_percent))
        over = [p for p in points if p.exceeds]
        worst.append(
            f"{name}: largest error {abs(top.error_percent):.1f} % at ball {top.ball} {top.side}, "
            f"{len(over)} of {len(points)} contacts beyond {LIMIT:g} %"
        )
    return (
        f"The source's model at the gate ({RULE}; the reference's "
        f"uncertainty is deducted): {'; '.join(worst)}. Known exceedances named in its data: {len(known_exceedances())}."
    )


def rigid_nut_error(study: Study, name: str, ball: int, side: str) -> float | None:
    """Return the low-order error of a contact against a reference whose nut is rigid too [%]; None without such a run."""
    run = load_run(study.scene(name), min(LEVELS), stores=study.stores)
    if run is None or "elastic nut" not in run.without:
        return None
    truth = float(run.without["elastic nut"][ball - 1, SIDES.index(side)])
    low = float(study.solve(name, "lin").load[ball - 1, SIDES.index(side)])
    return float(error_percent(low, truth)) if truth > 0.0 else None


def exceedance_table(found: References, study: Study) -> Table:
    """Return the table of contacts beyond the gate's limit, with known causes and the error with a rigid nut."""
    causes = {(x.scene, x.ball, x.side): x.cause for x in known_exceedances()}
    rows: list[Row] = []
    for name, ref in found.items():
        for p in gate_points(name, ref, LIMIT, study.solve(name, "lin").load):
            if p.exceeds:
                k, rigid = SIDES.index(p.side), rigid_nut_error(study, name, p.ball, p.side)
                rows.append(
                    {
                        "scene": name,
                        "ball": p.ball,
                        "side": p.side,
                        Quantity("ref", "reference", "N", ".1f"): float(ref.load[p.ball - 1, k]),
                        Quantity("error", "error of the source's model", "% of own load", "+.1f"): p.error_percent,
                        Quantity("bar", "grid uncertainty", "% of own load", ".2f"): p.uncertainty_percent,
                        Quantity("rigid", "the same, nut rigid in both", "% of own load", "+.1f"): rigid,
                        "cause": causes.get((name, p.ball, p.side), "not named: the gate fails"),
                    }
                )
    note = f"The gate's rule: {RULE}."
    return Table.of(
        "reference-exceedances", f"Contacts whose load by Lin's model is off by more than {LIMIT:g} %", rows, note
    )


def make_section(study: Study, step: Callable[[str], None]) -> Section:
    """Return the section of the report, from stored runs."""
    step("low-order models against the 3D reference")
    found = case_studies(study)
    title = "Contact loads by the low-order models and by the 3D reference"
    if not found:
        return Section("reference", title, (Text(("No run of the 3D reference was found.",)),))
    runs: list[Run] = [run for ref in found.values() for run in ref.runs]
    versions = sorted({f"rollbench {r.versions['rollbench']}, gmsh {r.versions['gmsh']}, {r.date}" for r in runs})
    text = [
        (
            "The reference is a 3D elastic-contact model. gmsh meshes screw and nut with exact helical grooves, "
            "flat ends and a socket at every contact; one fine patch of 27-node hexahedra per flank is "
            "condensed exactly and reused for all balls. Balls are elastic and free to move, contact is "
            "unilateral and frictionless, and normals follow the motion. It shares nothing with the low-order "
            f"models but the description of the parts. Computed: {'; '.join(versions)}."
        ),
        "The uncertainty is the reference's grid convergence by least squares (Eca and Hoekstra 2014) with one order for "
        "all contacts of a scene, and each contact's own scatter about that fit; with two levels, three times their "
        "difference. Sides are " + ", ".join(SIDES) + ".",
        gate_text(found, study),
    ]
    if study.quick:
        text.insert(
            0,
            "QUICK RUN: coarse meshes only, so there is no grid uncertainty; these numbers are for a look, not "
            "for a decision.",
        )
    elif any(ref.best.level < PRODUCTION for ref in found.values()):
        text.insert(0, f"Some references were not computed up to level {PRODUCTION}; their uncertainty is larger.")
    over = exceedance_table(found, study)
    items: list[Any] = [Text(tuple(text)), error_table(study, found)]
    items += [over] if over.rows else []
    items += [*load_figures(study, found), *load_tables(study, found), line_figure(study, found), line_table(study, found)]
    items += time_items(study, step)
    return Section("reference", title, tuple(items))
