"""Report section on the low-order models from Lin's model to the refined model: load errors against the 3D reference."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from rollbench.compare.measure import error_percent, load_error, mean_load
from rollbench.compare.models import modelling
from rollbench.compare.models.comparison import REFERENCED
from rollbench.compare.models.model_form import SHARE
from rollbench.compare.models.study import SceneResultCache
from rollbench.lowfi.compliance.bodies import PARTS
from rollbench.lowfi.compliance.parts import REFINED, ComplianceModel
from rollbench.lowfi.statics.static import solve_elastic
from rollbench.reports.content import Figure, Panel, Row, Section, Series, Table, Text

#: Least number of scenes for which a figure of expected against measured errors of a model is drawn.
MANY = 40
#: Changed refined models, by the modelling choice that is changed; its derivation determines none of these choices.
CHOICES: dict[str, ComplianceModel] = {
    "loaded patch of the body compliance 1.5 times as wide": replace(REFINED, width=1.5),
    "loaded patch of the body compliance 2/3 as wide": replace(REFINED, width=1.0 / 1.5),
    "bore of the smooth nut by equal cube of the wall thickness, without a layer for the grooves": replace(
        REFINED, bore="ring"
    ),
    "bore of the smooth nut by equal volume of the nut": replace(REFINED, bore="volume"),
    "bore of the smooth nut as large as between the grooves (lands)": replace(REFINED, bore="land"),
    "1.5 times as many harmonics": replace(REFINED, harmonics=1.5),
    "2/3 of the harmonics": replace(REFINED, harmonics=1.0 / 1.5),
    "elements of the body compliance half as large": replace(REFINED, mesh=2.0),
    "elements of the body compliance 1.5 times as large": replace(REFINED, mesh=1.0 / 1.5),
    "flanks as plain half-spaces": replace(REFINED, flank=False),
    "balls as half-spaces": replace(REFINED, ball="half space"),
    "screw as a beam except for its contacts": replace(REFINED, screw="beam"),
    "section of the screw by equation C.8 of Lin's thesis": replace(REFINED, section="scene"),
}
#: Scenes on which these modelling choices are varied.
VARIED = ("lin-case1", "lin-case3", "unseen-thin-nut")


def model_error_table(model_solutions: Sequence[modelling.RefinementStepResult]) -> Table:
    """Return the table of the contact-load errors of every low-order model on every scene, simplest model first.

    ``model_solutions``: solution of each scene by each model of the sequence, with its errors against the 3D reference.
    """
    rows: list[Row] = [
        {
            "scene": r.scene,
            "model": r.model,
            "largest_load_error": r.load_error.max_percent,
            "at_largest_error": f"{r.load_error.ball} {r.load_error.side}",
            "rms_error": r.load_error.rms_percent,
            "largest_load_error_own": r.load_error.own_max_percent,
            "sum_error": r.load_sum_difference,
            "mesh_uncertainty": r.reference_uncertainty,
        }
        for r in model_solutions
    ]
    note = "; ".join(f"{m.name}: {m.refinement_step[1]}" for m in modelling.RUNGS if m.refinement_step) + (
        ". Errors against the finest stored mesh level of the 3D reference. Scenes named unseen were chosen before they "
        "were solved in 3D, and no choice of the models was based on them. With two mesh levels, the mesh uncertainty is "
        "three times their difference."
    )
    title = "Contact-load errors of each low-order model on each screw and bearing, from the simplest to the refined model"
    return Table.from_rows("ladder", title, rows, note)


def model_error_figure(model_solutions: Sequence[modelling.RefinementStepResult]) -> Figure:
    """Draw the largest and the RMS contact-load error over the sequence of models: a line per scene, one for the median.

    ``model_solutions``: solution of each scene by each model, with its errors against the 3D reference.
    """
    order = [m.name for m in modelling.RUNGS]
    scenes = list(dict.fromkeys(r.scene for r in model_solutions))

    panels = []
    for title, name in (("largest contact-load error", "max_percent"), ("RMS error of the contact loads", "rms_percent")):
        found = {(r.scene, order.index(r.model) + 1.0): float(getattr(r.load_error, name)) for r in model_solutions}
        steps = sorted({x for _, x in found})
        curves = [(scene, [x for x in steps if (scene, x) in found]) for scene in scenes]
        series = [Series(scene, x, [found[scene, v] for v in x], "line", pale=True) for scene, x in curves]
        middle = [float(np.median([y for (_, x), y in found.items() if x == step])) for step in steps]
        series.append(Series("median", steps, middle, "line+markers", bold=True))
        panels.append(Panel(title, "", "error / % of the mean load", series, log_axes="y", abscissa_names=order))
    caption = f"Each pale line: one of the {len(scenes)} example screws and bearings; bold line: their median."
    title = "Contact-load error of each low-order model against the 3D reference, from the simplest to the refined model"
    return Figure("ladder-rungs", title, panels, caption, same_y=True)


def choice_effects_table(cache: SceneResultCache, step: Callable[[str], None]) -> Table:
    """Return the table of load changes on three scenes when one modelling choice of the refined model is changed.

    ``step`` is called with each line of progress.
    """
    rows: list[Row] = []
    for name in VARIED:
        step(f"choices of the refined model varied on {name}")
        scene, reference = cache.built_in_scene(name), cache.stored_reference(name)
        if reference is None:
            continue
        base = solve_elastic(scene).load
        mean = mean_load(base, reference.contacts)
        for label, backend in {"unchanged": REFINED, **CHOICES}.items():
            load = solve_elastic(scene, backend=backend).load
            error = load_error(load, reference.load, reference.contacts)
            row: Row = {"scene": name, "modelling_choice": label}
            row["largest_change"] = float(np.abs(error_percent(load, base, mean)).max())
            rows.append(row | {"largest_load_error_changed": error.max_percent, "rms_error_changed": error.rms_percent})
    note = (
        "The choices of the refined model follow from arguments and are not fitted. The loaded patch is as wide as the "
        "groove (half the distance between the contacts of its two flanks), because a smooth body cannot resolve finer "
        "details. The nut grooves are a layer that is softer along the axis than around it, because lands are rings that "
        "are supported only at their base. The number of harmonics is the largest that a patch can excite."
    )
    title = "Contact-load errors of the refined model when one of its modelling choices is changed"
    return Table.from_rows("ladder-choices", title, rows, note)


def error_with_3d_bodies_table(cache: SceneResultCache) -> Table:
    """Return the table of the refined model's error with the compliance of screw, nut or both from the 3D reference.

    The difference from the error of the unchanged model is the contribution of the model's simplified screw or nut.
    """
    found = cache.compute_once(modelling.errors_by_replaced_body)
    variants: dict[tuple[str, ...], str] = {
        (): "unchanged model",
        ("screw",): "screw compliance from 3D",
        ("nut",): "nut compliance from 3D",
        PARTS: "both compliances from 3D",
    }
    rows: list[Row] = []
    for share in found:
        row: Row = {"scene": share.scene}
        for parts, variant in variants.items():
            row["largest_load_error_of", variant] = share.load_errors[parts].max_percent
            row["rms_error_of", variant] = share.load_errors[parts].rms_percent
        row |= {("sum_error_of", variants[parts]): share.load_sum_difference[parts] for parts in ((), PARTS)}
        rows.append(row)
    note = (
        "The refined model is solved with the compliance of screw, nut or both taken from the finest run of the 3D "
        "reference. The decrease of the error is the share of that body. The remaining error is due to the rest of the "
        "low-order model (contact law, kinematics, beam beyond the nut) and to the uncertainty of the reference."
    )
    title = "Contact-load error of the refined model with the compliance of screw or nut from the 3D reference"
    return Table.from_rows("ladder-shares", title, rows, note)


def expected_and_measured_error_items(
    cache: SceneResultCache, model_solutions: Sequence[modelling.RefinementStepResult]
) -> list[Table | Figure]:
    """Return table and figure that compare the expected error of each model with the measured one, screw by screw.

    The error is the largest one of a contact load on a screw; its expected value is estimated from the model's errors on
    all other screws. ``model_solutions``: solution of each scene by each model, with its errors against the 3D reference.
    """
    rows = modelling.leave_one_out_error_rows(cache, model_solutions)
    lines: list[Row] = []
    panels = []
    for model in dict.fromkeys(row["model"] for row in rows):
        of_model = [row for row in rows if row["model"] == model]
        covered = [row for row in of_model if row["expected"] is not None]
        if not covered:
            continue
        measured, expected = (np.array([row[key] for row in covered], float) for key in ("measured", "expected"))
        held = f"{int((measured <= expected).sum())} of {len(covered)}"
        ratio = expected / np.maximum(measured, 1e-9)
        line: Row = {"model": model, "screws": str(len(of_model)), "screws_covered": str(len(covered))}
        line |= {"screws_within_prediction": held, "prediction_ratio": float(np.median(ratio))}
        line |= {"predicted_error_median": float(np.median(expected)), "predicted_error_largest": float(expected.max())}
        lines.append(line)
        if len(covered) >= MANY:
            ends = [float(min(measured.min(), expected.min())), float(max(measured.max(), expected.max()))]
            series = (
                Series("screws", measured.tolist(), expected.tolist(), "markers", bold=True),
                Series("predicted = actual", ends, ends, "line"),
            )
            x, y = "actual largest error / % of the mean load", "predicted largest error / % of the mean load"
            panels.append(Panel(model, x, y, series, log_axes="xy"))
    note = (
        "For every screw, example or randomly drawn, the largest load error is predicted from all other screws: by a "
        "linear fit of the logarithm of the error over features of the screws, times the factor with which "
        f"{SHARE:.0%} of the other screws are covered. Actual error: against the 3D reference."
    )
    title = "Predicted contact-load error of each model, compared with the actual error"
    out: list[Table | Figure] = [Table.from_rows("ladder-estimate", title, lines, note)]
    if panels:
        caption = (
            "Error: the largest of a screw, predicted from all other screws, and actual against the 3D reference. One "
            "point for each screw. On or above the line the actual error does not exceed the predicted one."
        )
        title = "Predicted contact-load error of each model, plotted against the actual error"
        out.append(Figure("ladder-estimate-figure", title, tuple(panels), caption))
    return out


def largest_errors_of_models_sentence(model_solutions: Sequence[modelling.RefinementStepResult]) -> str:
    """Return the sentence on the largest contact-load errors of the models lin, refined and condensed.

    The errors are stated for the case studies, and for the screws that were not used in the development of the models.
    ``model_solutions``: solution of each scene by each model, with its errors against the 3D reference.
    """
    words = []
    for label, names in (("case studies", REFERENCED), ("screws not used in development", modelling.UNSEEN)):
        for model in ("lin", "refined", "condensed"):
            of_label = [r for r in model_solutions if r.model == model and r.scene in names]
            if of_label:
                worst = max(of_label, key=lambda r: r.load_error.max_percent)
                words.append(
                    f"{label}, {model}: largest contact-load error {worst.load_error.max_percent:.2f} % ({worst.scene}), "
                    f"RMS error up to {max(r.load_error.rms_percent for r in of_label):.2f} %"
                )
    return "Contact-load errors in per cent of the mean load against the 3D reference: " + "; ".join(words) + "."


def make_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the section on the errors of the sequence of models from Lin's rigid-nut model to the refined model.

    ``step`` is called with each line of progress.
    """
    step("every model on every scene with a 3D reference")
    rungs = cache.compute_once(modelling.solve_refinement_sequence_on_all_scenes)
    title = "Contact-load errors of a sequence of models, from Lin's rigid-nut model to the refined model"
    if not rungs:
        return Section("ladder", title, (Text(("No run of the 3D reference is stored.",)),))
    text = (
        (
            "The refined model uses the contact mechanics and the energy of Lin's model, and adds the elasticity of "
            "screw, nut and balls. The screw is a beam with the section of half a lead of grooved shaft "
            "(axisymmetric elements, harmonics 0 and 1); the nut is a beam too. Two deformations are added to those of the "
            "beams: that of a smooth body of revolution, as far as a beam lacks it (Fourier harmonics around the axis: "
            "ovalisation, ends, clamped face); and that of the true groove flank, as far as it differs from the half-space "
            "that Hertz's law assumes. Tension and bending of a screw that continues beyond the nut deform its grooves by "
            "lateral contraction (Saint-Venant). Balls are elastic spheres (Lur'e's series); bearing rings are bodies of "
            "revolution with their groove. The model contains no 3D solution, and nothing is fitted to one."
        ),
        largest_errors_of_models_sentence(rungs),
    )
    step("refined model with the compliance of bodies from 3D")
    items = (
        Text(text),
        model_error_table(rungs),
        model_error_figure(rungs),
        error_with_3d_bodies_table(cache),
        choice_effects_table(cache, step),
    )
    median = {
        name: float(np.median([r.load_error.max_percent for r in rungs if r.model == name])) for name in ("lin", "refined")
    }
    conclusion = (
        f"Median over screws and bearings of the largest contact-load error: {median['lin']:.1f} % of the mean load with "
        f"Lin's model, {median['refined']:.1f} % with the refined model."
    )
    return Section("ladder", title, (*items, *expected_and_measured_error_items(cache, rungs)), conclusion=conclusion)
