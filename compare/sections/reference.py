"""The low-order models beside the 3D reference: errors with its error bar, run times, what moves the reference."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from compare.comparison import REFERENCED, gate_points, known_exceedances, summary
from compare.findings import Finding, entry
from compare.measure import error_percent, load_error
from compare.reference import LEVELS, VARIANTS, Reference, Run, load, reference
from compare.study import Study
from meshes.parts import SIDES, Scene
from reports.records import Cell, Column, Figure, Panel, Section, Series, Table, Text

PRINTED = {"lin-case1": ("case1_max_error", "case1_rms_error"), "lin-case2": ("case2_max_error", "case2_rms_error")}


def references(study: Study) -> dict[str, Reference]:
    """Stored references of the scenes that have one."""
    found = {name: reference(study.scene(name)) for name in REFERENCED}
    return {name: r for name, r in found.items() if r is not None}


def findings(study: Study) -> list[Finding]:
    """The source's errors against ANSYS, with ours against the 3D reference beside them; they stay open."""
    out = []
    for name, keys in PRINTED.items():
        found = reference(study.scene(name))
        if found is None:
            continue
        e = load_error(study.solve(name).load, found.load)
        for key, own, mean in zip(
            keys, (e.own_max_percent, e.own_rms_percent), (e.max_percent, e.rms_percent), strict=True
        ):
            out.append(
                Finding(
                    entry("lin-2.4.1", key), value=own,
                    evidence=f"ours: low-order model against this project's 3D reference, in per cent of each load "
                    f"({mean:.2f} % of the mean load); the source's ANSYS loads are not printed",
                )
            )  # fmt: skip
    return out


def variants(study: Study) -> list[tuple[str, str, Scene, str]]:
    """Low-order models compared: label, scene's name, scene, model."""
    out = []
    for name in REFERENCED:
        out.append(("low-order model", name, study.scene(name), "lin"))
        out.append(("source's partition (15 mm)", name, study.changed(name, partition="source"), "lin"))
        out.append(("Hertz constants as printed", name, study.changed(name, hertz="as printed"), "lin"))
        if name == "lin-case1":
            out.append(("Mei, axial bars, rigid nut", name, study.scene(name), "mei"))
            out.append(("Mei, nut as a bar", name, study.scene(name), "mei-nut"))
    return out


def error_table(study: Study, found: dict[str, Reference]) -> Table:
    """Errors of every low-order model against the reference."""
    rows: list[dict[str, Cell]] = []
    for label, name, scene, model in variants(study):
        if name not in found:
            continue
        ref = found[name]
        e, _, seconds = summary(scene, model, ref)
        mean = float(ref.load[ref.load > 0.0].mean())
        best = ref.runs[-1]
        cold = best.setup_seconds + best.solve_seconds
        printed = [entry("lin-2.4.1", k).printed for k in PRINTED.get(name, ())] if label == "low-order model" else []
        bar = None if ref.uncertainty is None else float(np.abs(error_percent(ref.uncertainty, 0.0, mean)).max())
        rows.append(
            {
                "scene": name, "model": label, "max": e.max_percent, "at": f"{e.ball} {e.side}", "rms": e.rms_percent,
                "own_max": e.own_max_percent, "own_rms": e.own_rms_percent,
                "printed": " / ".join(printed) if printed else "–", "bar": bar, "seconds": seconds, "cold": cold,
                "ratio": cold / seconds,
            }
        )  # fmt: skip
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
        Column("seconds", "low-order", "s", "g3"),
        Column("cold", "reference, cold", "s", "g3"),
        Column("ratio", "reference : low-order", "", ".0f"),
    )
    note = (
        "Low-order seconds are those of one interpreted call with set-up; the reference's are those of its finest run, "
        "set-up included. Printed: the source's low-order model against its ANSYS model."
    )
    return Table("reference-errors", "Low-order models against the 3D reference", columns, rows, note)


def level_table(found: dict[str, Reference]) -> Table:
    """Mesh levels of every scene."""
    rows: list[dict[str, Cell]] = []
    for name, ref in found.items():
        for run in ref.runs:
            e = load_error(run.load, ref.load)
            frozen = load_error(run.frozen, run.load)
            rows.append(
                {
                    "scene": name, "level": run.level, "b": run.settings["b_over_h"], "unknowns": run.unknowns,
                    "setup": run.setup_seconds, "solve": run.solve_seconds, "memory": run.peak_MB,
                    "max": float(run.load.max()), "min": float(run.load[:, 0].min()), "change": e.max_percent,
                    "frozen": frozen.max_percent, "balance": run.balance, "along": run.along_groove,
                }
            )  # fmt: skip
    columns = (
        Column("scene", "scene", "", "s"),
        Column("level", "level", "", "s"),
        Column("b", "b/h", "", ".1f"),
        Column("unknowns", "unknowns, equivalent monolithic mesh", "", "s"),
        Column("setup", "set-up", "s", ".1f"),
        Column("solve", "load case", "s", ".1f"),
        Column("memory", "peak memory", "MB", ".0f"),
        Column("max", "largest load", "N", ".2f"),
        Column("min", "smallest on SL", "N", ".2f"),
        Column("change", "largest difference from the finest", "% of mean", ".2f"),
        Column("frozen", "effect of moving normals", "% of mean", ".2f"),
        Column("balance", "ball's balance", "", "g2"),
        Column("along", "force along the groove", "", "g2"),
    )
    return Table("reference-levels", "Mesh levels of the 3D reference", columns, rows)


def spread_table(study: Study) -> Table:
    """What modelling choices that are not printed change, on the coarsest level."""
    scene = study.scene("lin-case1")
    base = load(scene, 1)
    rows: list[dict[str, Cell]] = []
    for name, (label, _) in VARIANTS.items():
        run: Run | None = load(scene, 1, name)
        if base is None or run is None:
            continue
        e = load_error(run.load, base.load)
        model = load_error(study.solve("lin-case1").load, run.load)
        rows.append(
            {
                "choice": label, "max": e.max_percent, "rms": e.rms_percent, "at": f"{e.ball} {e.side}",
                "model": model.max_percent, "model_rms": model.rms_percent,
            }
        )  # fmt: skip
    columns = (
        Column("choice", "choice", "", "s"),
        Column("max", "largest change of a load", "% of mean", ".2f"),
        Column("rms", "RMS change", "% of mean", ".2f"),
        Column("at", "at ball", "", "s"),
        Column("model", "low-order model against this variant: largest", "% of mean", ".2f"),
        Column("model_rms", "RMS", "% of mean", ".2f"),
    )
    return Table("reference-spread", "Case 1: what moves the reference besides its mesh (level 1)", columns, rows)


def _curve(label: str, load_: np.ndarray[tuple[int, ...], np.dtype[np.float64]], *, emphasis: bool = False) -> Series:
    return Series(label, [float(i + 1) for i in range(load_.size)], [float(x) for x in load_], emphasis=emphasis)


def figures(study: Study, found: dict[str, Reference]) -> list[Figure]:
    """Load distributions of all models on one axis, and error against run time."""
    panels = []
    for name, ref in found.items():
        low = study.solve(name).load
        series = [_curve("3D reference SL", ref.load[:, 0], emphasis=True), _curve("low-order SL", low[:, 0])]
        if (ref.load[:, 1] > 0.0).any():
            series += [_curve("3D reference SR", ref.load[:, 1], emphasis=True), _curve("low-order SR", low[:, 1])]
        elif name == "lin-case1":
            series.append(_curve("Mei, rigid nut", study.solve(name, "mei").load[:, 0]))
        panels.append(Panel(name, "ball", "contact load / N", tuple(series), integer_x=True))
    out = [Figure("reference-loads", "Load distributions: low-order models and 3D reference", tuple(panels))]
    if "lin-case1" in found:
        ref = found["lin-case1"]
        points = []
        for label, name, scene, model in variants(study):
            if name == "lin-case1":
                e, _, seconds = summary(scene, model, ref)
                points.append(Series(label, [seconds], [max(e.max_percent, 1e-3)], "markers"))
        levels = [run for run in ref.runs if run.level < max(LEVELS)]
        points.append(
            Series(
                "3D reference, coarser levels", [r.setup_seconds + r.solve_seconds for r in levels],
                [load_error(r.load, ref.load).max_percent for r in levels], "line+markers",
            )
        )  # fmt: skip
        panel = Panel("case 1", "run time, cold / s", "largest error / % of the mean load", tuple(points), log="xy")
        caption = "Errors are against the finest level of the 3D reference."
        out.append(Figure("reference-time", "Error against run time", (panel,), caption))
    return out


def gate_text(found: dict[str, Reference], study: Study, limit: float = 7.0) -> str:
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
    known = len(known_exceedances())
    return "Gate (per cent of each load, of the mean for loads below a tenth of it; the reference's uncertainty is " \
        f"deducted): {'; '.join(worst)}. Known exceedances named in the gate's data: {known}."  # fmt: skip


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report; reads stored runs of ``rollbench mesh-study``."""
    step("stored runs of the 3D reference")
    found = references(study)
    stamps = (run.versions for ref in found.values() for run in ref.runs)
    versions = sorted({f"rollbench {v['rollbench']}, gmsh {v['gmsh']}" for v in stamps})
    text = (
        "The reference is a 3D elastic-contact model: screw and nut meshed by gmsh with exact helical grooves, flat ends "
        "and a socket at every contact, one fine patch of 27-node hexahedra per flank condensed exactly and reused on all "
        "balls, elastic balls free to move, unilateral frictionless contact, normals that follow the motion. It shares "
        f"nothing with the low-order model but the description of the parts. These are stored runs ({'; '.join(versions)}) "
        "of `rollbench mesh-study`, which computes them again.",
        "The uncertainty is the grid convergence index of three levels per contact (Celik et al. 2008), or the band of the "
        "three where they are not monotone. Sides are " + ", ".join(SIDES) + ".",
        gate_text(found, study) if found else "No stored run was found.",
    )
    return Section(
        "reference",
        "Low-order models against the 3D reference",
        (Text(text), error_table(study, found), *figures(study, found), level_table(found), spread_table(study)),
    )
