"""The low-order models beside the 3D reference: errors with its error bar, loads, centreline, run times."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from compare.measure import LoadError, error_percent, load_error
from compare.models.comparison import (
    CONTENDERS,
    PRINTED,
    REFERENCED,
    Contender,
    from_model,
    gate_points,
    known_exceedances,
    load_ratio,
    reference_answers,
    suited,
    summary,
)
from compare.models.ladder import UNSEEN
from compare.models.modelling import VARIED, Modelling, combined, modelling_percent, varied
from compare.models.study import Study
from compare.printed.findings import Finding, entry
from compare.reference.grid_summary import uncertainty_percent
from compare.reference.levels import LEVELS, PRODUCTION, SOURCE_LEVEL
from compare.reference.runs import Reference, Run, load, reference
from compare.sections.reference_time import time_items
from meshes.parts import SIDES, Scene
from reports.records import Cell, Column, Figure, Panel, Section, Series, Table, Text

References = Mapping[str, Reference]


def references(
    study: Study, stores: Sequence[Any] | None = None, names: Sequence[str] = REFERENCED
) -> dict[str, Reference]:
    """Stored references of the scenes that have one: the case studies unless ``names`` says otherwise."""
    found = {name: reference(study.scene(name), stores) for name in names}
    return {name: r for name, r in found.items() if r is not None}


def modelling(study: Study, stores: Sequence[Any] | None) -> dict[str, Modelling]:
    """Modelling uncertainty of the scenes on which choices were varied."""
    scenes = [study.scene(name) for name in VARIED]
    found = {scene.name: combined(scene, varied(scene, stores)) for scene in scenes}
    return {name: m for name, m in found.items() if m is not None}


def findings(study: Study, stores: Sequence[Any] | None = None) -> list[Finding]:
    """The source's errors against ANSYS, with ours against the 3D reference beside them; they stay open."""
    out = []
    for name, keys in PRINTED.items():
        found = reference(study.scene(name), stores)
        if found is None:
            continue
        e = load_error(study.solve(name).load, found.load)
        for key, own, mean in zip(
            keys[:2], (e.own_max_percent, e.own_rms_percent), (e.max_percent, e.rms_percent), strict=True
        ):
            out.append(
                Finding(
                    entry("lin-2.4.1", key),
                    value=own,
                    evidence=f"ours: the source's model against this project's 3D reference, in per cent of each load "
                    f"({mean:.2f} % of the mean load); the source's ANSYS loads are not printed",
                )
            )
    return out


def error_table(study: Study, found: References, stores: Sequence[Any] | None) -> Table:
    """Errors of every low-order model, of the source's mesh and of the extrapolation against the finest reference."""
    rows: list[dict[str, Cell]] = []
    modelled = modelling(study, stores)
    for name, ref in found.items():
        scene = study.scene(name)
        keys = PRINTED.get(name)
        for contender in suited(scene):
            e, result, _ = summary(contender, scene, ref)
            shown = keys[:2] if keys and contender.name == "lin" else ()
            printed = " / ".join(entry("lin-2.4.1", k).printed for k in shown) or "–"
            rows.append(_error_row(name, contender.label, e, load_ratio(result.load), printed, uncertainty_percent(ref)))
        source = load(scene, SOURCE_LEVEL, stores=stores)
        for answer in reference_answers(ref, source):
            if answer.model != f"3D level {ref.best.level}":
                e = load_error(answer.load, ref.load)
                rows.append(
                    _error_row(name, LABELS[answer.model], e, load_ratio(answer.load), "–", uncertainty_percent(ref))
                )
        own: dict[str, Cell] = {"scene": name, "model": LABELS[f"3D level {ref.best.level}"]}
        rows.append(own | {"load_ratio": load_ratio(ref.load), "bar": uncertainty_percent(ref)})
        for row in rows:
            if row["scene"] == name:
                row["modelling"] = modelling_percent(name, modelled)
    columns = (
        Column("scene", "scene", "", "s"),
        Column("model", "model", "", "s"),
        Column("max", "largest error", "% of mean", ".2f"),
        Column("at", "at ball", "", "s"),
        Column("rms", "RMS error", "% of mean", ".2f"),
        Column("own_max", "largest", "% of own load", ".2f"),
        Column("own_rms", "RMS", "% of own load", ".2f"),
        Column("printed", "printed max / RMS", "%", "s"),
        Column("bar", "reference's uncertainty", "% of mean", ".2f"),
        Column("modelling", "its modelling uncertainty", "% of mean", ".2f"),
        Column("load_ratio", "largest : smallest on SL", "", ".3f"),
    )
    note = (
        "Errors against the finest level of the 3D reference. Printed: the source's low-order model against its ANSYS "
        "model, whose loads are not printed; its errors are of the own load. The reference's uncertainty is its grid's "
        "(largest of any contact); its modelling uncertainty, what idealisations and unprinted dimensions are worth, is a "
        "number of its own (section reference-mesh) and deducted nowhere."
    )
    return Table("reference-errors", "Models against the 3D reference", columns, rows, note)


LABELS = {
    "3D source mesh": "3D reference, the source's mesh",
    "3D extrapolated": "3D reference, extrapolated",
    **{f"3D level {level}": f"3D reference, level {level}" for level in LEVELS},
}


def _error_row(scene: str, label: str, e: LoadError, ratio: float, printed: str, bar: float | None) -> dict[str, Cell]:
    return {
        "scene": scene,
        "model": label,
        "max": e.max_percent,
        "at": f"{e.ball} {e.side}",
        "rms": e.rms_percent,
        "own_max": e.own_max_percent,
        "own_rms": e.own_rms_percent,
        "printed": printed,
        "bar": bar,
        "load_ratio": ratio,
    }


def load_tables(study: Study, found: References, stores: Sequence[Any] | None) -> list[Table]:
    """Every contact load of every model, scene by scene."""
    out = []
    for name, ref in found.items():
        scene = study.scene(name)
        answers = [from_model(c, scene) for c in suited(scene)]
        answers += reference_answers(ref, load(scene, SOURCE_LEVEL, stores=stores))
        columns = [Column("ball", "ball", "", "s"), Column("side", "side", "", "s")]
        for k, a in enumerate(answers):
            label = CONTENDERS[a.model].label if a.model in CONTENDERS else LABELS.get(a.model, a.model)
            columns.append(Column(f"m{k}", label, "N", ".1f"))
        columns.append(Column("bar", "uncertainty", "N", ".2f"))
        columns.append(Column("error", "error of the refined model", "% of own load", "+.2f"))
        columns.append(Column("angle", "contact angle, reference", "deg", ".2f"))
        columns.append(Column("low_angle", "refined model", "deg", ".2f"))
        rows: list[dict[str, Cell]] = []
        for i, s in np.ndindex(ref.load.shape):
            if not any(a.load[i, s] > 0.0 for a in answers):
                continue
            row: dict[str, Cell] = {f"m{k}": float(a.load[i, s]) for k, a in enumerate(answers)}
            own = float(ref.load[i, s])
            row |= {
                "ball": i + 1,
                "side": SIDES[s],
                "angle": _number(ref.best.angle[i, s]),
                "low_angle": _number(answers[0].angle[i, s]),
                "bar": None if ref.uncertainty is None else float(ref.uncertainty[i, s]),
                "error": float(error_percent(answers[0].load[i, s], own)) if own > 0.0 else None,
            }
            rows.append(row)
        out.append(Table(f"reference-loads-{name}", f"{name}: contact loads and angles", columns, rows))
    return out


def _number(value: Any) -> float | None:
    return float(value) if np.isfinite(value) else None


def line_table(study: Study, found: References) -> Table:
    """Centreline of the screw at the reference's stations."""
    rows: list[dict[str, Cell]] = []
    for name, ref in found.items():
        low = from_model(CONTENDERS["refined"], study.scene(name))
        line = ref.best.centreline
        for row in line:
            cells: dict[str, Cell] = {"scene": name, "z": 1e3 * float(row[0])}
            for k, axis in enumerate("xyz"):
                cells[f"r{axis}"] = 1e6 * float(row[1 + k])
                cells[f"l{axis}"] = 1e6 * float(np.interp(row[0], low.stations, low.line[:, k]))
            rows.append(cells)
    columns = [Column("scene", "scene", "", "s"), Column("z", "station", "mm", ".1f")]
    for axis in "xyz":
        columns += [
            Column(f"r{axis}", f"u{axis}, reference", "um", ".2f"),
            Column(f"l{axis}", f"u{axis}, refined model", "um", ".2f"),
        ]
    note = "Mean motion of the meshed screw's hole inside the nut's reach, of the beam's nodes outside."
    return Table("reference-centreline", "Centreline of the screw", columns, rows, note)


def _curve(label: str, values: np.ndarray[tuple[int, ...], np.dtype[np.float64]], *, emphasis: bool = False) -> Series:
    return Series(label, [float(i + 1) for i in range(values.size)], [float(x) for x in values], emphasis=emphasis)


def load_figures(study: Study, found: References) -> list[Figure]:
    """Load distributions of all models on one axis; the reference's uncertainty as a band."""
    out = []
    for name, ref in found.items():
        scene = study.scene(name)
        answers = {c: from_model(c, scene) for c in suited(scene) if c.name != "lin-source-partition"}
        panels = []
        for s in range(4):
            if not (ref.load[:, s] > 0.0).any() or (s >= 2 and len(ref.best.sides) == 2):
                continue
            series = [_curve(f"3D reference, level {ref.best.level}", ref.load[:, s], emphasis=True)]
            if ref.uncertainty is not None:
                low, high = ref.load[:, s] - ref.uncertainty[:, s], ref.load[:, s] + ref.uncertainty[:, s]
                x = [float(i + 1) for i in range(len(low))]
                series.insert(0, Series("its uncertainty", x, [float(v) for v in low], "band", [float(v) for v in high]))
            series += [_curve(c.label, a.load[:, s]) for c, a in answers.items() if (a.load[:, s] > 0.0).any()]
            panels.append(Panel(SIDES[s], "ball", "contact load / N", tuple(series), integer_x=True))
        out.append(Figure(f"reference-loads-{name}", f"{name}: contact loads of all models", tuple(panels)))
    return out


def line_figure(study: Study, found: References) -> Figure:
    """Lateral deflection of the screw: beam against 3D."""
    panels = []
    for name, ref in found.items():
        low = from_model(CONTENDERS["refined"], study.scene(name))
        line = ref.best.centreline
        series = []
        for k, axis in ((0, "x"), (1, "y")):
            series.append(
                Series(
                    f"u{axis}, refined model",
                    [1e3 * float(z) for z in low.stations],
                    [1e6 * float(v) for v in low.line[:, k]],
                    "line",
                )
            )
            series.append(
                Series(
                    f"u{axis}, 3D reference",
                    [1e3 * float(z) for z in line[:, 0]],
                    [1e6 * float(v) for v in line[:, 1 + k]],
                    "markers",
                    emphasis=True,
                )
            )
        panels.append(Panel(name, "station / mm", "displacement / um", tuple(series)))
    return Figure("reference-centreline", "Lateral displacement of the centreline", tuple(panels))


def study_figure(name: str, table: Sequence[Mapping[str, Any]]) -> Figure | None:
    """Largest and smallest loads over the mesh levels, as change from the finest; None with fewer than two levels."""
    keys = sorted({k for row in table for k in row if k.startswith("level ")})
    if len(keys) < 2:
        return None
    loads = [row for row in table if "est load" in row["quantity"]]
    line = [row for row in table if row["quantity"].startswith("centreline")]
    panels = []
    for title, own in (("contact loads", loads), ("centreline", line)):
        series = []
        for row in own:
            finest = row[keys[-1]]
            if abs(finest) < 1e-9:
                continue
            change = [float(error_percent(row[k], finest)) for k in keys]
            series.append(Series(row["quantity"], [float(k.split()[1]) for k in keys], change, "line+markers"))
        if series:
            panels.append(Panel(title, "mesh level", "change from the finest / %", tuple(series[:8]), integer_x=True))
    if not panels:
        return None
    return Figure(f"mesh-study-{name}", f"{name}: mesh study", tuple(panels))


def gate_text(found: References, study: Study, limit: float = 7.0) -> str:
    """What the gate sees, in words from the data."""
    worst = []
    for name, ref in found.items():
        points = gate_points(study.scene(name), ref, limit)
        top = max(points, key=lambda p: abs(p.error_percent))
        over = [p for p in points if p.exceeds]
        worst.append(
            f"{name}: largest error {abs(top.error_percent):.1f} % at ball {top.ball} {top.side}, "
            f"{len(over)} of {len(points)} contacts beyond {limit:g} %"
        )
    return (
        "The source's model at the gate (per cent of each load, of the mean for loads below a tenth of it; the reference's "
        f"uncertainty is deducted): {'; '.join(worst)}. Known exceedances named in its data: {len(known_exceedances())}."
    )


def rigid_nut_error(scene: Scene, ball: int, side: str, stores: Sequence[Any] | None) -> float | None:
    """Low-order error [%] of a contact against the reference whose nut is rigid too (coarsest level); None if not run."""
    run = load(scene, min(LEVELS), stores=stores)
    if run is None or "elastic nut" not in run.without:
        return None
    own = float(run.without["elastic nut"][ball - 1, SIDES.index(side)])
    low = float(from_model(CONTENDERS["lin"], scene).load[ball - 1, SIDES.index(side)])
    return float(error_percent(low, own)) if own > 0.0 else None


def exceedance_table(found: References, study: Study, stores: Sequence[Any] | None, limit: float = 7.0) -> Table:
    """Contacts beyond the gate's limit, with the cause that the gate's data name and its evidence."""
    causes = {(x.scene, x.ball, x.side): x.cause for x in known_exceedances()}
    rows: list[dict[str, Cell]] = []
    for name, ref in found.items():
        for p in gate_points(study.scene(name), ref, limit):
            if p.exceeds:
                k = SIDES.index(p.side)
                rows.append(
                    {
                        "scene": name,
                        "ball": p.ball,
                        "side": p.side,
                        "error": p.error_percent,
                        "bar": p.uncertainty_percent,
                        "ref": float(ref.load[p.ball - 1, k]),
                        "rigid": rigid_nut_error(study.scene(name), p.ball, p.side, stores),
                        "cause": causes.get((name, p.ball, p.side), "not named: the gate fails"),
                    }
                )
    columns = (
        Column("scene", "scene", "", "s"),
        Column("ball", "ball", "", "s"),
        Column("side", "side", "", "s"),
        Column("ref", "reference", "N", ".1f"),
        Column("error", "error of the source's model", "%", "+.1f"),
        Column("bar", "reference's uncertainty", "%", ".2f"),
        Column("rigid", "the same, nut rigid in both", "%", "+.1f"),
        Column("cause", "cause", "", "s"),
    )
    return Table("reference-exceedances", f"Contacts of the source's model beyond {limit:g} %", columns, rows)


def section(study: Study, step: Callable[[str], None], stores: Sequence[Any] | None = None, quick: bool = False) -> Section:
    """Section of the report; reads runs that ``compare.reference.jobs`` computed."""
    step("low-order models against the 3D reference")
    found = references(study, stores)
    title = "Low-order models against the 3D reference"
    if not found:
        return Section("reference", title, (Text(("No run of the 3D reference was found.",)),))
    runs: list[Run] = [run for ref in found.values() for run in ref.runs]
    versions = sorted({f"rollbench {r.versions['rollbench']}, gmsh {r.versions['gmsh']}, {r.date}" for r in runs})
    text = [
        "The reference is a 3D elastic-contact model: screw and nut meshed by gmsh with exact helical grooves, flat ends "
        "and a socket at every contact, one fine patch of 27-node hexahedra per flank condensed exactly and reused on all "
        "balls, elastic balls free to move, unilateral frictionless contact, normals that follow the motion. It shares "
        f"nothing with the low-order models but the description of the parts. Computed: {'; '.join(versions)}.",
        "The uncertainty is the reference's grid convergence by least squares (Eca and Hoekstra 2014) with one order for "
        "all contacts of a scene, and each contact's own scatter about that fit; with two levels, three times their "
        "difference. Sides are " + ", ".join(SIDES) + ".",
        gate_text(found, study),
    ]
    if quick:
        text.insert(
            0,
            "QUICK RUN: coarse meshes only, so there is no grid uncertainty; these numbers are for a look, not "
            "for a decision.",
        )
    elif any(ref.best.level < PRODUCTION for ref in found.values()):
        text.insert(0, f"Some references were not computed up to level {PRODUCTION}; their uncertainty is larger for it.")
    over = exceedance_table(found, study, stores)
    items: list[Any] = [Text(tuple(text)), error_table(study, found, stores)]
    items += [over] if over.rows else []
    items += [
        *load_figures(study, found),
        *load_tables(study, found, stores),
        line_figure(study, found),
        line_table(study, found),
    ]
    timed = found if quick else references(study, stores, (*REFERENCED, *UNSEEN))
    items += time_items(timed, study, stores, step, quick=quick)
    return Section("reference", title, tuple(items))


__all__ = ["Contender", "findings", "section", "study_figure"]
