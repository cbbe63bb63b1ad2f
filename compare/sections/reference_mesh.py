"""How good the 3D reference is: mesh levels and their cost, mesh study, modelling spread, what each ingredient changes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from compare.comparison import CONTENDERS, from_model
from compare.measure import error_percent, load_error
from compare.reference import LEVELS, SOURCE_LEVEL, VARIANTS, Reference, Run, load
from compare.sections.reference import references, study_figure
from compare.study import Study
from compare.study_command import study_table
from reports.records import Cell, Column, Figure, Section, Table, Text

References = Mapping[str, Reference]


def level_table(study: Study, found: References, stores: Sequence[Any] | None) -> Table:
    """Mesh levels of every scene: size, cost, quality, residuals."""
    rows: list[dict[str, Cell]] = []
    for name, ref in found.items():
        source = load(study.scene(name), SOURCE_LEVEL, stores=stores)
        for run in ([source] if source else []) + list(ref.runs):
            e, frozen = load_error(run.load, ref.load), load_error(run.frozen, run.load)
            rows.append(
                {
                    "scene": name, "level": "source" if run.level == SOURCE_LEVEL else str(run.level),
                    "across": run.quality["elements across 2b"], "unknowns": run.unknowns, "sides": len(run.sides),
                    "setup": run.setup_seconds, "solve": run.solve_seconds, "memory": run.peak_MB,
                    "change": e.max_percent, "frozen": frozen.max_percent, "balance": max(run.balance, run.screw_balance),
                    "along": run.along_groove, "left": float(error_percent(run.left_out, 0.0, 1.0)),
                    "jacobian": min(run.quality[k] for k in ("screw", "nut", "ball")),
                    "deviation": 1e6 * run.quality["deviation"],
                }
            )  # fmt: skip
    columns = (
        Column("scene", "scene", "", "s"), Column("level", "level", "", "s"),
        Column("across", "elements across 2b", "", ".1f"), Column("sides", "sides meshed", "", "s"),
        Column("unknowns", "unknowns, equivalent monolithic mesh", "", "s"), Column("setup", "set-up", "s", ".1f"),
        Column("solve", "load case", "s", ".1f"), Column("memory", "peak memory", "MB", ".0f"),
        Column("change", "difference from the finest", "% of mean", ".2f"),
        Column("frozen", "effect of moving normals", "% of mean", ".2f"),
        Column("balance", "balance of balls and screw", "", "g2"), Column("along", "force along the groove", "", "g2"),
        Column("left", "modes left out, at most", "%", ".2f"), Column("jacobian", "smallest scaled Jacobian", "", ".2f"),
        Column("deviation", "coarse bodies off the exact groove", "um", "g2"),
    )  # fmt: skip
    note = (
        "Elements across the short axis 2b of the contact ellipse expected at the lightest scene of the geometry; balances "
        "are over the largest contact load; the modes left out are a bound on the change of one contact's compliance."
    )
    return Table("reference-levels", "Mesh levels of the 3D reference", columns, rows, note)


def stage_table(found: References) -> Table:
    """Where the time of the finest run goes."""
    rows: list[dict[str, Cell]] = []
    for name, ref in found.items():
        cells: dict[str, Cell] = {"scene": name, "contact": ref.best.solve_seconds}
        rows.append(cells | dict(ref.best.stages))
    names = list(dict.fromkeys(k for row in rows for k in row if k not in ("scene", "contact")))
    columns = [Column("scene", "scene", "", "s"), *(Column(k, k, "s", ".1f") for k in names)]
    columns.append(Column("contact", "load case", "s", ".1f"))
    note = "Scenes of one geometry share all stages but the last."
    return Table("reference-stages", "Stages of the finest runs", columns, rows, note)


def study_items(study: Study, found: References, stores: Sequence[Any] | None) -> list[Table | Figure]:
    """Mesh study of every scene with three levels: extremes and centreline; the CSV of ``mesh-study`` has every ball."""
    out: list[Table | Figure] = []
    for name, ref in found.items():
        if len(ref.runs) < 2:
            continue
        table = study_table(study.scene(name), stores)
        rows = [dict(r) for r in table if "load of ball" not in r["quantity"]]
        keys = [f"level {r.level}" for r in ref.runs]
        columns = [Column("quantity", "quantity", "", "s"), Column("unit", "unit", "", "s")]
        columns += [Column(k, k, "", "g5") for k in keys]
        if len(keys) >= 3:
            columns += [
                Column("order", "observed order", "", ".2f"), Column("extrapolated", "extrapolated", "", "g5"),
                Column("uncertainty", "uncertainty", "", "g2"), Column("uncertainty_percent", "uncertainty", "%", ".2f"),
                Column("kind", "kind", "", "s"),
            ]  # fmt: skip
        if any(row.get("modelling_spread") is not None for row in rows):
            columns.append(Column("modelling_spread", "modelling spread", "", "g2"))
            columns.append(Column("nut_fixing", "nut held elsewhere", "", "g2"))
        out.append(Table(f"mesh-study-{name}", f"{name}: mesh study", columns, rows))
        figure = study_figure(name, table)
        if figure is not None:
            out.append(figure)
    return out


def spread_table(study: Study, stores: Sequence[Any] | None) -> Table | None:
    """What moves the reference besides its mesh, on case 1 and the coarsest level."""
    scene = study.scene("lin-case1")
    whole = load(scene, min(LEVELS), stores=stores)
    base = load(scene, min(LEVELS), "base", stores) or whole
    if base is None or whole is None:
        return None
    low = from_model(CONTENDERS["lin"], scene)
    rows: list[dict[str, Cell]] = []
    for name, variant in VARIANTS.items():
        run = load(scene, min(LEVELS), name, stores)
        if run is None:
            continue
        e, model = load_error((whole if name == "base" else run).load, base.load), load_error(low.load, run.load)
        rows.append(
            {"choice": variant.label, "kind": "not printed or numerical" if variant.spread else "boundary condition",
             "max": e.max_percent, "rms": e.rms_percent, "at": f"{e.ball} {e.side}", "model": model.max_percent,
             "model_rms": model.rms_percent}
        )  # fmt: skip
    columns = (
        Column("choice", "choice", "", "s"), Column("kind", "kind", "", "s"),
        Column("max", "largest change of a load", "% of mean", ".2f"), Column("rms", "RMS change", "% of mean", ".2f"),
        Column("at", "at ball", "", "s"),
        Column("model", "low-order model against this variant: largest", "% of mean", ".2f"),
        Column("model_rms", "RMS", "% of mean", ".2f"),
    )  # fmt: skip
    title = "Case 1: what moves the reference besides its mesh (level 1)"
    return Table("reference-spread", title, columns, rows) if rows else None


SAVES = {
    "elastic nut": ("nut",), "3D shaft": ("screw",), "finite ball": ("ball",), "patch coupling": ("screw", "nut"),
    "moving normals": (),
}  # fmt: skip
MEANING = {
    "elastic nut": "the nut rigid beyond the local response of each contact",
    "3D shaft": "the screw a Timoshenko beam of the homogenised section, with the local response of each contact",
    "finite ball": "the ball rigid beyond its contact patches",
    "patch coupling": "nut rigid, screw a beam, ball rigid beyond the local response of each contact",
    "moving normals": "directions and gaps frozen in the nominal state",
}


def ablation_table(study: Study, stores: Sequence[Any] | None) -> Table | None:
    """What each ingredient of the reference changes, in per cent and seconds."""
    rows: list[dict[str, Cell]] = []
    for name in references(study, stores):
        scene = study.scene(name)
        run = load(scene, min(LEVELS), stores=stores)
        if run is None or not run.without:
            continue
        low = from_model(CONTENDERS["lin"], scene)
        with_all = load_error(low.load, run.load)
        for ingredient, loads in run.without.items():
            e, model = load_error(loads, run.load), load_error(low.load, loads)
            saved = sum(run.stages.get(k, 0.0) for k in SAVES[ingredient])
            saved += run.solve_seconds - run.without_seconds[ingredient]
            rows.append(
                {"scene": name, "without": ingredient, "meaning": MEANING[ingredient], "max": e.max_percent,
                 "rms": e.rms_percent, "at": f"{e.ball} {e.side}", "seconds": saved, "before": with_all.max_percent,
                 "model": model.max_percent}
            )  # fmt: skip
    columns = (
        Column("scene", "scene", "", "s"), Column("without", "left out", "", "s"),
        Column("meaning", "what stands in", "", "s"),
        Column("max", "largest change of a load", "% of mean", ".2f"), Column("rms", "RMS change", "% of mean", ".2f"),
        Column("at", "at ball", "", "s"), Column("seconds", "seconds it takes", "s", "+.1f"),
        Column("before", "low-order error against the full reference", "% of mean", ".2f"),
        Column("model", "against this one", "% of mean", ".2f"),
    )  # fmt: skip
    note = "On the coarsest level. A scene may leave out what changes less than it needs to know."
    title = "What each ingredient of the reference changes"
    return Table("reference-ablation", title, columns, rows, note) if rows else None


def ablation_text(study: Study, stores: Sequence[Any] | None) -> str:
    """Cause of the low-order error in words, from the data."""
    parts = []
    for name in references(study, stores):
        scene = study.scene(name)
        run: Run | None = load(scene, min(LEVELS), stores=stores)
        if run is None or "elastic nut" not in run.without:
            continue
        low = from_model(CONTENDERS["lin"], scene)
        before, after = load_error(low.load, run.load), load_error(low.load, run.without["elastic nut"])
        parts.append(f"{name} from {before.max_percent:.2f} % to {after.max_percent:.2f} %")
    if not parts:
        return ""
    return (
        "With the nut made rigid in the reference too, the largest error of the low-order model (of the mean load) goes: "
        f"{'; '.join(parts)}. What is left is beam, section and contact law together."
    )


def section(study: Study, step: Callable[[str], None], stores: Sequence[Any] | None = None) -> Section:
    """Section of the report on the reference's own quality."""
    step("mesh levels, mesh study, modelling spread, ablation")
    found = references(study, stores)
    items: list[Any] = []
    text = [
        "Every level refines patches, coarse bodies and balls together by about a third. The source's mesh has first-order "
        "tetrahedra, 0.08 mm around every contact and 5 mm elsewhere, condensed by the same method."
    ]
    assumed = list(dict.fromkeys(a for ref in found.values() for a in ref.best.assumed))
    if assumed:
        text.append("Assumed where the source prints nothing: " + " ".join(assumed))
    cause = ablation_text(study, stores)
    items.append(Text(tuple(text)))
    if found:
        items += [level_table(study, found, stores), stage_table(found), *study_items(study, found, stores)]
    spread, ablation = spread_table(study, stores), ablation_table(study, stores)
    items += [spread] if spread else []
    if ablation:
        items += [Text((cause,)), ablation] if cause else [ablation]
    return Section("reference-mesh", "How good the reference is", tuple(items))
