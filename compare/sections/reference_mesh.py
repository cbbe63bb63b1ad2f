"""Section on the accuracy of the 3D reference: mesh levels, mesh study, modelling choices, effect of each ingredient."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from rollbench.compare.measure import LoadError, error_percent, load_error
from rollbench.compare.models.comparison import REFERENCED
from rollbench.compare.models.modelling import REFINED, UNSEEN, VARIED, varied
from rollbench.compare.models.study import Study
from rollbench.compare.models.uncertainty import SHARED, beside_face
from rollbench.compare.reference.estimate import Reference, uncertainty_percent
from rollbench.compare.reference.levels import LEVELS, SOURCE_LEVEL, SOURCE_MESH
from rollbench.compare.reference.store import Measured, Run, load_run, most_of
from rollbench.compare.reference.variants import NOT_VARIED, VARIANTS
from rollbench.compare.sections.curves import study_figure
from rollbench.compare.sections.reference import case_studies, modelling
from rollbench.compare.sections.u_val import MANY, Held, coverage, share_of
from rollbench.compare.studies.mesh_study import accuracy_sentence, reference_from_stored_runs, study_table
from rollbench.lowfi.statics.result import StaticResult
from rollbench.reports.content import Cell, Figure, Quantity, Row, Section, Table, Text

References = Mapping[str, Reference]


def _changed(error: LoadError, form: str = ".2f") -> Row:
    """Return table cells with the load changes that a choice causes."""
    return {
        Quantity("max", "largest change of a load", "% of mean", form): error.max_percent,
        Quantity("rms", "RMS change", "% of mean", form): error.rms_percent,
        Quantity("at", "at ball", "", "s"): f"{error.ball} {error.side}",
    }


def _refined(variant: str) -> bool:
    """Return whether a variant refines a single numerical choice."""
    return variant in VARIANTS and bool(VARIANTS[variant].refined)


def level_table(study: Study, found: References) -> Table:
    """Return the mesh levels of every scene: size, cost, change to the next level, quality, residuals."""
    rows: list[Row] = []
    common = most_of(run.measured for ref in found.values() for run in ref.runs)
    for name, ref in found.items():
        source = load_run(study.scene(name), SOURCE_LEVEL, stores=study.stores)
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
                    "level": "source" if run.level == SOURCE_LEVEL else str(run.level),
                    Quantity("across", "elements across 2b", "", ".1f"): run.quality["elements across 2b"],
                    Quantity("sides", "flanks meshed", "", "s"): len(run.sides),
                    Quantity("unknowns", "unknowns, equivalent monolithic mesh", "", "s"): run.unknowns,
                    Quantity("setup", "set-up", "s", ".1f"): times[0],
                    Quantity("solve", "load case", "s", ".1f"): times[1],
                    Quantity("memory", "peak memory", "MB", ".0f"): "not measured" if run.peak_MB is None else run.peak_MB,
                    Quantity("change", "difference from the next level: largest", "% of mean", ".2f"): largest,
                    Quantity("rms", "RMS", "% of mean", ".2f"): rms,
                    Quantity("sum", "of the sum", "%", "+.2f"): change,
                    Quantity("best", "difference from the finest level", "% of mean", ".2f"): best.max_percent,
                    Quantity("frozen", "effect of moving normals", "% of mean", ".2f"): frozen.max_percent,
                    Quantity("balance", "balance of balls and screw", "", "g2"): max(run.balance, run.screw_balance),
                    Quantity("along", "force along the groove", "", "g2"): run.along_groove,
                    Quantity("jacobian", "smallest scaled Jacobian", "", ".2f"): jacobian,
                    Quantity("deviation", "coarse bodies off the exact groove", "um", "g2"): 1e6 * run.quality["deviation"],
                }
            )
    note = (
        "Elements across the short axis 2b of the contact ellipse, as expected in the least loaded scene of "
        "the geometry. Balances are relative to the largest contact load. Seconds and peak memory are each "
        f"run's own; scenes of one geometry share set-up and memory. {_only(common)}"
    )
    return Table.of("reference-levels", "Mesh levels of the 3D reference", rows, note)


def convergence_table(found: References) -> Table:
    """Return the table of every scene's mesh uncertainty of contact loads, by contribution."""
    rows: list[Row] = []
    for name, ref in found.items():
        p = ref.parts
        rows.append(
            {
                "scene": name,
                "levels": len(ref.runs),
                Quantity("contact", "contact's cells", "% of mean", ".3f"): p.contact,
                Quantity("bodies", "bodies' cells", "% of mean", ".3f"): p.bodies,
                Quantity("sockets", "coarse sockets", "% of mean", ".3f"): p.sockets,
                Quantity("common", "common to all contacts", "% of mean", ".3f"): p.common,
                Quantity("bar", "uncertainty (95 %), RMS", "% of mean", ".3f"): p.bar,
                Quantity("beside", "beside a free face of the nut, largest", "% of mean", ".3f"): beside_face(ref)[0],
                Quantity("largest", "largest", "% of mean", ".3f"): uncertainty_percent(ref),
                Quantity("from", "taken from", "", "s"): "other scenes"
                if p.by_experience
                else "its levels and other scenes",
            }
        )
    note = (
        "Standard deviations of the difference between the finest level and the next finer one, RMS over "
        "the contacts; the uncertainty is twice the root of the sum of their squares. Parts of bodies and "
        "sockets are distributed over the contacts by stiffness, the cube root of the load. From level to "
        "level, contact cells are refined by 4/3, body cells by 1.15, and the cut of the coarse sockets not "
        "at all; no two levels share a cell, so loads scatter between levels and show no order. The first "
        "two parts come from changes between the scene's own levels and fall with the square of the cell "
        "size; the part of the sockets is half the variance caused by a different cut; the common part "
        "comes from the mean changes of all scenes in which equilibrium does not fix the sum of loads. "
        "Beside a free nut face, the compliance of the lip that the cells miss is added where it exceeds "
        "all other parts (measured on nuts solved alone with ever finer bodies)."
    )
    return Table.of("reference-convergence", "Discretisation's part in the contact loads", rows, note)


def coverage_table(study: Study) -> Table | None:
    """Return the table of coarser levels' uncertainties, tested by finer levels; None if runs are missing."""
    found = coverage(study)
    if not found:
        return None
    levels = sorted({h.level for h in found})
    groups = {name: [h for h in found if h.scene == name] for name in dict.fromkeys(h.scene for h in found)}
    several = [h for h in found if h.level > min(LEVELS)]
    rows: list[dict[str, Cell]] = [_coverage_row(name, group) for name, group in groups.items()]
    rows.append(_coverage_row("all shipped scenes", [h for h in found if not h.drawn]))
    if any(h.drawn for h in found):
        rows.append(_coverage_row("all drawn screws", [h for h in found if h.drawn]))
    rows.append(_coverage_row("all", found))
    columns = [Quantity("scene", "scene", "", "s"), Quantity("contacts", "contacts", "", "s")]
    columns.append(Quantity("judge", "judged by level", "", "s"))
    for k in levels:
        words = f"level {k} alone (experience)" if k == min(LEVELS) else f"levels up to {k}"
        columns.append(Quantity(f"bar {k}", f"{words}: bar", "% of mean", ".3f"))
        columns.append(Quantity(f"held {k}", f"held by level {k}'s bar", "%", ".1f"))
    worst = min((h for h in several if h.contacts >= MANY), key=lambda h: h.share)
    note = (
        f"{100.0 * share_of(several):.1f} % of {sum(h.contacts for h in several)} loads with bars from two levels "
        f"or more lie within them; in the worst scene with {MANY} contacts or more, "
        f"{100.0 * worst.share:.1f} % ({worst.scene}, levels up to {worst.level}). Bars are meant to cover "
        "95 %. The finest level, which judges a bar, is not used to make it, nor is experience from scenes "
        "that share its parts; rows for several scenes give medians. Errors common to all meshes are not "
        "covered here."
    )
    return Table("reference-coverage", "Bars of 95 % against a finer level", tuple(columns), rows, note)


def _coverage_row(name: str, group: Sequence[Held]) -> dict[str, Cell]:
    """Return a row of `coverage_table`, of one scene or of several."""
    row: dict[str, Cell] = {"scene": name, "contacts": sum(h.contacts for h in group if h.level == min(LEVELS))}
    row["judge"] = ", ".join(map(str, sorted({h.judge for h in group})))
    for k in sorted({h.level for h in group}):
        of_level = [h for h in group if h.level == k]
        row |= {f"bar {k}": float(np.median([h.bar for h in of_level])), f"held {k}": 100.0 * share_of(of_level)}
    return row


def shared_text(study: Study) -> str:
    """Return a text on the error that all contacts share and that no stated uncertainty includes."""
    low, high = SHARED
    moves = [
        f"{e.choice} {float(e.change[e.change != 0.0].mean()):+.3f} %"
        for e in varied(study.scene(REFINED), study.stores)
        if _refined(e.variant)
    ]
    finer = f" On {REFINED}, refining one choice at a time moves the mean load by: {', '.join(moves)}." if moves else ""
    return (
        "Common to all contacts and contained in no bar: independent 3D programs, CalculiX among them "
        f"(section crosscheck), give a sum of loads of preloaded screws that is {low:g} to {high:g} % larger "
        f"than the reference's, always with this sign.{finer} No mesh of the reference shows it."
    )


def _only(common: Measured | None) -> str:
    """Return a sentence on which measured times a table shows."""
    return f"Times are those measured with {common}; others are left out."


def stage_table(found: References) -> Table:
    """Return the time of each stage of the finest run."""
    rows: list[dict[str, Cell]] = []
    common = most_of(ref.best.measured for ref in found.values())
    for name, ref in found.items():
        if ref.best.measured != common:
            continue
        cells: dict[str, Cell] = {"scene": name, "contact": ref.best.solve_seconds}
        rows.append(cells | dict(ref.best.stages))
    names = list(dict.fromkeys(k for row in rows for k in row if k not in ("scene", "contact")))
    columns = [Quantity("scene", "scene", "", "s"), *(Quantity(k, k, "s", ".1f") for k in names)]
    columns.append(Quantity("contact", "load case", "s", ".1f"))
    note = f"Scenes of one geometry share all stages but the last. {_only(common)}"
    return Table("reference-stages", "Stages of the finest runs", columns, rows, note)


def study_items(study: Study, found: References) -> list[Table | Figure]:
    """Return tables and figures of the mesh study of every scene with at least two levels."""
    out: list[Table | Figure] = []
    for name in found:
        ref = reference_from_stored_runs(study.scene(name), study.stores)
        if ref is None or len(ref.runs) < 2:
            continue
        table = study_table(study.scene(name), study.stores)
        rows = [dict(r) for r in table if "load of ball" not in r["quantity"]]
        columns = [
            Quantity("quantity", "quantity", "", "s"),
            Quantity("unit", "unit", "", "s"),
            *(Quantity(f"level {r.level}", f"level {r.level}", "", "g5") for r in ref.runs),
            Quantity("order", "observed order", "", ".2f"),
            Quantity("extrapolated", "extrapolated", "", "g5"),
            Quantity("uncertainty", "uncertainty", "", "g2"),
            Quantity("uncertainty_percent", "relative uncertainty", "%", ".2f"),
            Quantity("kind", "order or why none", "", "s"),
        ]
        if any(row.get("modelling_spread") is not None for row in rows):
            columns.append(Quantity("modelling_spread", "modelling uncertainty", "", "g2"))
            columns.append(Quantity("scene_choices", "the scene's own choices, largest", "", "g2"))
        out.append(Table(f"mesh-study-{name}", f"{name}: mesh study", columns, rows, accuracy_sentence(ref)))
        figure = study_figure(name, table, ref)
        if figure is not None:
            out.append(figure)
    return out


KINDS = {"modelling": "modelling", "numerical": "numerical", "scene": "the scene's own"}


def spread_table(study: Study) -> Table | None:
    """Return the table of load changes by modelling choices of the reference; None if there is no run."""
    rows: list[Row] = []
    for name in VARIED:
        scene = study.scene(name)
        low = study.solve(name, "lin")
        for e in varied(scene, study.stores):
            if _refined(e.variant):
                continue
            run = load_run(scene, min(LEVELS), e.variant, study.stores)
            model = None if run is None else load_error(low.load, run.load)
            largest, rms = (None, None) if model is None else (model.max_percent, model.rms_percent)
            ratio = e.ratio if np.isfinite(e.ratio) else None
            rows.append(
                {
                    "scene": name,
                    "choice": e.choice,
                    Quantity("variant", "varied", "", "s"): e.label,
                    "kind": KINDS[e.kind],
                    **_changed(e.error),
                    Quantity("ratio", "change of largest : smallest, SL", "%", "+.2f"): ratio,
                    Quantity("model", "low-order model against this variant: largest", "% of mean", ".2f"): largest,
                    Quantity("model_rms", "RMS", "% of mean", ".2f"): rms,
                }
            )
    note = (
        "One choice at a time on level 1, against the unchanged scene on the same level. Only choices "
        "marked modelling are part of the modelling uncertainty; where the nut is held and where the "
        "screw's groove ends are choices of the scene. The coupling that beams neglect is bounded here and "
        "included in the refined model."
    )
    title = "What moves the reference besides its mesh (level 1)"
    return Table.of("reference-spread", title, rows, note) if rows else None


def single_choice_table(study: Study) -> Table | None:
    """Return the table of load changes by each numerical choice of the finest level, against its uncertainty."""
    scene, found, rows = study.scene(REFINED), study.reference(REFINED), list[Row]()
    if found is None:
        return None
    grid = np.abs(error_percent(found.uncertainty, 0.0, found.mean))
    for e in varied(scene, study.stores):
        if not _refined(e.variant):
            continue
        at = np.unravel_index(int(np.abs(e.change).argmax()), e.change.shape)
        beyond = int((np.abs(e.change) > grid + 1e-9).sum())
        rows.append(
            {
                "scene": REFINED,
                "choice": e.choice,
                Quantity("variant", "refined alone", "", "s"): e.label,
                **_changed(e.error, ".3f"),
                Quantity("grid", "grid uncertainty of that load", "% of mean", ".3f"): float(grid[at]),
                Quantity("largest", "largest grid uncertainty", "% of mean", ".3f"): float(grid.max()),
                Quantity("beyond", "contacts that change by more than their uncertainty", "", "s"): beyond,
            }
        )
    note = (
        "One choice at a time, refined beyond the finest level, against the unchanged scene on the finest "
        "level. The uncertainty is the printed one of the discretisation, all parts included."
    )
    return Table.of("reference-choices", "Every numerical choice refined alone", rows, note) if rows else None


def modelling_table(study: Study) -> Table | None:
    """Return the table of the modelling uncertainty by choice and in total, and of choices not varied."""
    found = modelling(study)
    if not found:
        return None
    choices = dict.fromkeys(c for m in found.values() for c in m.choices)
    missing = dict.fromkeys(v.choice for v in VARIANTS.values() if v.kind == "modelling" and v.choice not in choices)
    together = {
        "together, root of squares: largest contact": {name: m.largest for name, m in found.items()},
        "together: RMS of the contacts": {name: m.rms for name, m in found.items()},
        "together: largest : smallest load, SL": {name: m.ratio for name, m in found.items()},
    }
    values = {c: {name: m.choices[c] for name, m in found.items() if c in m.choices} for c in choices} | together
    rows: list[dict[str, Cell]] = [{"choice": choice, **of_scenes} for choice, of_scenes in values.items()]
    rows += [{"choice": f"{c}: not varied", "why": "no run of it in this store"} for c in missing]
    rows += [{"choice": f"{n.choice}: not varied", "why": n.reason} for n in NOT_VARIED]
    columns = [
        Quantity("choice", "choice", "", "s"),
        *(Quantity(name, f"{name}, largest change of a load", "% of mean", ".2f") for name in found),
        Quantity("why", "why not", "", "s"),
    ]
    note = (
        "Choices are independent and have no known sign, so they are added contact by contact as the root "
        "of the sum of squares; of several variants of one choice, each contact takes the largest. The RMS "
        "value is what a typical contact may be wrong by; the largest is quoted with the grid uncertainty. "
        "This is an estimate from one typical variation of each choice, not a bound."
    )
    return Table("reference-modelling", "Modelling uncertainty of the 3D reference", columns, rows, note)


BEAM = "the screw a Timoshenko beam of the homogenised section, with the local response of each contact"
RIGID = "nut rigid, screw a beam, ball rigid beyond the local response of each contact"
#: Ingredients of the reference, with their replacement and the stages of a set-up that each takes.
INGREDIENTS: dict[str, tuple[str, tuple[str, ...]]] = {
    "elastic nut": ("the nut rigid beyond the local response of each contact", ("nut",)),
    "3D shaft": (BEAM, ("screw",)),
    "finite ball": ("the ball rigid beyond its contact patches", ("ball",)),
    "patch coupling": (RIGID, ("screw", "nut")),
    "moving normals": ("directions and gaps frozen in the nominal state", ()),
}


def _ablated(study: Study) -> Iterator[tuple[str, Run, StaticResult]]:
    """Yield name, coarsest run and source's model of case studies that were also solved with ingredients left out."""
    for name in case_studies(study):
        run = load_run(study.scene(name), min(LEVELS), stores=study.stores)
        if run is not None and run.without:
            yield name, run, study.solve(name, "lin")


def ablation_table(study: Study) -> Table | None:
    """Return the table of each reference ingredient's effect on loads [%] and time [s]; None if there is no run."""
    rows: list[Row] = []
    common = most_of(run.measured for _, run, _ in _ablated(study))
    for name, run, low in _ablated(study):
        full = load_error(low.load, run.load).max_percent
        for ingredient, loads in run.without.items():
            e, model = load_error(loads, run.load), load_error(low.load, loads)
            meaning, stages = INGREDIENTS[ingredient]
            saved = sum(run.stages.get(k, 0.0) for k in stages)
            saved += run.solve_seconds - run.without_seconds[ingredient]
            rows.append(
                {
                    "scene": name,
                    Quantity("without", "left out", "", "s"): ingredient,
                    Quantity("meaning", "what stands in", "", "s"): meaning,
                    **_changed(e),
                    Quantity("seconds", "seconds it takes", "s", "+.1f"): saved if run.measured == common else None,
                    Quantity("before", "low-order error against the full reference", "% of mean", ".2f"): full,
                    Quantity("model", "against this one", "% of mean", ".2f"): model.max_percent,
                }
            )
    note = f"On the coarsest level. A scene may leave out what changes less than it needs to know. {_only(common)}"
    title = "What each ingredient of the reference changes"
    return Table.of("reference-ablation", title, rows, note) if rows else None


def ablation_text(study: Study) -> str:
    """Return a text on how the low-order error changes if the nut is rigid in the reference too."""
    parts = []
    for name, run, low in _ablated(study):
        if "elastic nut" not in run.without:
            continue
        before, after = load_error(low.load, run.load), load_error(low.load, run.without["elastic nut"])
        parts.append(f"{name} from {before.max_percent:.2f} % to {after.max_percent:.2f} %")
    if not parts:
        return ""
    return (
        "With the nut rigid in the reference too, the largest error of the low-order model (in per cent of "
        f"the mean load) goes: {'; '.join(parts)}. The remainder is due to beam, section and contact law "
        "together."
    )


def conclusion(found: References) -> str:
    """Return a sentence on the mesh uncertainty of the finest levels."""
    bars = [uncertainty_percent(ref) for ref in found.values()]
    if not bars:
        return ""
    return (
        f"The largest contact load of the reference is known to {min(bars):.2f} to {max(bars):.2f} % as far "
        f"as its mesh is concerned (95 %, {len(bars)} scenes). Choices that no mesh shows matter more, above "
        "all where the nut is held."
    )


def make_section(study: Study, step: Callable[[str], None]) -> Section:
    """Return the section of the report."""
    step("mesh levels, mesh study, modelling spread, ablation")
    found, everything = case_studies(study), study.references((*REFERENCED, *UNSEEN))
    text = [
        (
            "From level to level all cells are refined, those of the contacts by a third, except the cut of the "
            f"coarse sockets. The source's mesh has first-order tetrahedra, {1000.0 * SOURCE_MESH['tet']:g} mm "
            f"around every contact and {1000.0 * SOURCE_MESH['cell']:g} mm elsewhere, condensed by the same "
            "method."
        )
    ]
    assumed = list(dict.fromkeys(a for ref in found.values() for a in ref.best.assumed))
    if assumed:
        text.append("Assumed where the source prints nothing: " + " ".join(assumed))
    items: list[Any] = [Text(tuple(text))]
    if everything:
        items += [convergence_table(everything), Text((shared_text(study),))]
        items += [coverage_table(study), level_table(study, everything)]
    if found:
        items += [stage_table(found), *study_items(study, found)]
    items += [single_choice_table(study), modelling_table(study), spread_table(study)]
    cause, ablation = ablation_text(study), ablation_table(study)
    items += [Text((cause,)) if cause and ablation else None, ablation]
    shown = tuple(item for item in items if item is not None)
    return Section("reference-mesh", "How good the reference is", shown, conclusion=conclusion(everything))
