"""Report section with a data sheet for every scene that has a 3D reference: sketch, inputs, results, errors of models."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import degrees

import numpy as np

from rollbench.compare.gate.verdict import LIMIT, ErrorLimits, Verdict
from rollbench.compare.gate.verdict import judge_contact_loads as by_gate
from rollbench.compare.models import uncertainty
from rollbench.compare.models.comparison import REFERENCED, RULE, solution_from_result, solution_from_run
from rollbench.compare.models.modelling import UNSEEN
from rollbench.compare.models.registry import DEFAULT
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.reference.estimate import Reference
from rollbench.compare.sections.u_val import SPOKEN
from rollbench.meshes.parts import Scene
from rollbench.reports.content import Figure, Row, Section, Sketch, Table, TableColumn, Text


def sketch_scene(scene: Scene, name: str, title: str) -> Sketch:
    """Return the sketch of a scene, with a caption on the inputs that the drawing does not show.

    ``name``: file name of the sketch. ``title``: title of the sketch.
    """
    return Sketch(name, title, scene, scene_inputs_sentence(scene))


def scene_inputs_sentence(scene: Scene) -> str:
    """Return a sentence on the inputs that a sketch does not show: balls, lead, contact angle, conformity, errors."""
    track, balls, errors = scene.track, scene.balls, scene.errors.balls
    lead = f"lead {1e3 * track.lead:.4g} mm" + (f", {track.starts} starts" if track.starts > 1 else "")
    words = [
        f"{scene.ball_count} balls of {2e3 * balls.radius:.5g} mm diameter",
        *([lead] if track.lead else []),
        f"pitch diameter {2e3 * track.pitch_radius:.5g} mm",
        f"contact angle {degrees(track.contact_angle):.4g} deg",
        f"groove radius/ball diameter {_conformity_text(scene)}",
    ]
    if errors.oversize:
        words.append(f"ball radii {errors.oversize * 1e6:+.3g} um from nominal")
    if scene.errors.lead_offset:
        words.append(f"lead offset {scene.errors.lead_offset * 1e6:.3g} um")
    return f"{', '.join(words)}."


def _conformity_text(scene: Scene) -> str:
    """Return the conformities (groove radius over ball diameter) of screw and nut, or of both rings, as text.

    They are one number if both are equal.
    """
    screw, nut = (f"{body.groove_radius / (2.0 * scene.balls.radius):.3g}" for body in (scene.screw, scene.nut))
    names = ("in the screw", "in the nut") if scene.track.lead else ("in the inner ring", "in the outer ring")
    return screw if screw == nut else f"{screw} {names[0]} and {nut} {names[1]}"


#: Names of the models on a data sheet; the uncertainty u_val is stated for the first.
MODELS = (DEFAULT, "lin")

LEGEND = (
    "Sketches are to scale near the nut. Hatched: surface that is fixed in the 3D reference; light: balls behind the "
    f"axis. Errors by the rule of rollbench check are {RULE}, for the stated inputs, which model and reference share. "
    "u_val: uncertainty (95 %) of the error against a real screw, by mesh, modelling choices and input tolerances "
    "(section u-val)."
)

#: Errors of models with their validation uncertainty, by pairs of model and quantity.
Judged = Mapping[tuple[str, str], uncertainty.ErrorWithUncertainty]


def make_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the section with a data sheet for every scene that has a 3D reference; Lin's case studies come first.

    ``step`` is called with each line of progress.
    """
    step("a data sheet for every scene with a 3D reference")
    found = cache.stored_references((*REFERENCED, *UNSEEN))
    title = "Geometry, loads and errors of each compared screw and bearing"
    if not found:
        return Section("sheets", title, (Text(("No run of the 3D reference is stored.",)),))
    judged = {name: errors_by_model_and_quantity(cache, name) for name in found}
    sheets = (data_sheet_items(cache, name, reference, judged[name]) for name, reference in found.items())
    items = [Text((LEGEND,)), *(item for sheet in sheets for item in sheet)]
    return Section("sheets", title, items, conclusion=largest_errors_sentence(judged))


def errors_by_model_and_quantity(cache: SceneResultCache, name: str) -> Judged:
    """Return the error of each model in `MODELS` in every quantity on a scene, with the uncertainty of the error.

    ``name``: name of the scene. The keys are pairs: name of the model, name of the quantity.
    """
    found: dict[tuple[str, str], uncertainty.ErrorWithUncertainty] = {}
    for model in MODELS:
        solution = solution_from_result(cache.solve_once(name, model))
        for quantity in uncertainty.QUANTITIES:
            one = uncertainty.error_with_validation_uncertainty(cache, name, model, quantity, solution)
            if one is not None:
                found[model, quantity.name] = one
    return found


def largest_errors_sentence(errors_by_scene: Mapping[str, Judged]) -> str:
    """Return the sentences on the largest contact-load error of each model: over all scenes, then by kind of scene.

    ``errors_by_scene``: errors by name of the scene, then by model and quantity. Kinds: Lin's case studies, and other
    scenes.
    """
    kinds = (
        ("case studies of Lin's thesis", REFERENCED),
        ("screws and bearings that were chosen before they were solved in 3D", UNSEEN),
    )
    words, whole = [], [f"{_largest_error_text(errors_by_scene, model).partition(' (')[0]}" for model in MODELS]
    for kind, names in kinds:
        of_kind = {name: errors_by_scene[name] for name in names if name in errors_by_scene}
        if of_kind:
            worst = [_largest_error_text(of_kind, model) for model in MODELS]
            words.append(f"{' and '.join(worst)} on the {len(of_kind)} {kind}")
    return (
        f"Largest contact-load error on {len(errors_by_scene)} screws and bearings, in per cent of the mean load: "
        f"{' and '.join(whole)}. In detail: {'; '.join(words)}."
    )


def _largest_error_text(errors_by_scene: Mapping[str, Judged], model: str) -> str:
    """Return as text the largest contact-load error of a model over several scenes, and the scene on which it occurs.

    ``errors_by_scene``: errors by name of the scene, then by model and quantity.
    """
    errors = {name: abs(v[model, uncertainty.CONTACTS].error) for name, v in errors_by_scene.items()}
    name = max(errors, key=errors.__getitem__)
    return f"{errors[name]:.1f} % with {SPOKEN.get(model, f'the {model} model')} ({name})"


def data_sheet_items(
    cache: SceneResultCache, name: str, reference: Reference, validated_errors: Judged
) -> Sequence[Text | Sketch | Table | Figure]:
    """Return the contents of one scene's data sheet: text on verdict and uncertainty, sketch, table of results.

    ``name``: name of the scene. ``reference``: its 3D reference. ``validated_errors``: errors on this scene, by model and
    quantity.
    """
    scene = cache.built_in_scene(name)
    gate = check_verdicts_by_model(cache, name, reference)
    words = (check_verdict_sentence(gate), uncertainty_sentence(reference, validated_errors[DEFAULT, uncertainty.CONTACTS]))
    title = f"Side view of the {'screw' if scene.track.lead else 'bearing'} {name}, with supports and loads"
    return (
        Text(words, heading=f"{name}: {scene.title}"),
        sketch_scene(scene, f"sketch-{name}", title),
        data_sheet_table(cache, scene, reference, validated_errors, gate),
    )


#: Verbs for the verdicts of ``rollbench check`` on a model, in a sentence.
WORDS = {"pass": "passes", "fail": "fails", "undecided": "is undecided at"}


def check_verdicts_by_model(cache: SceneResultCache, name: str, reference: Reference) -> dict[str, Verdict]:
    """Return the verdict of ``rollbench check`` on each model's contact loads on a scene, by model name.

    ``name``: name of the scene. ``reference``: its 3D reference.
    """
    return {model: by_gate(model, cache.solve_once(name, model).load, reference, ErrorLimits())[0] for model in MODELS}


def check_verdict_sentence(verdicts: Mapping[str, Verdict]) -> str:
    """Return the sentence on the verdicts of ``rollbench check`` on each model, with the contact that decided the verdict.

    ``verdicts``: verdicts on the contact loads, by name of the model. The text states error, ball and flank of the contact.
    """
    sentences = [
        f"the model {model} {WORDS[v.word]} the limit of {LIMIT:g} % of rollbench check: "
        f"{_signed_text(v.error or 0.0)} % on ball {v.ball} {v.flank}"
        for model, v in verdicts.items()
    ]
    return f"Contact loads: {'; '.join(sentences)}."


def _signed_text(value: float) -> str:
    """Return a number as text with its sign (a typographic minus) and two decimals."""
    return f"{value:+.2f}".replace("-", "−")


def uncertainty_sentence(reference: Reference, validated: uncertainty.ErrorWithUncertainty) -> str:
    """Return the sentence on the uncertainty of the contact-load error on a scene, and on its three contributions.

    The contributions are mesh, modelling choices and input tolerances. ``reference``: 3D reference of the scene.
    ``validated``: error of the default model with these uncertainties.
    """
    levels = ", ".join(str(run.level) for run in reference.runs)
    parts = [("mesh", validated.grid), ("modelling choices", validated.choices), ("input tolerances", validated.inputs)]
    known = ", ".join(f"{name} {value:.2f}" for name, value in parts if np.isfinite(value))
    also = f" {reference.unsettled[:1].upper()}{reference.unsettled[1:]}." if reference.unsettled else ""
    return f"Uncertainty: mesh levels {levels} of the 3D reference; {validated.uncertainty_text}, of which {known}.{also}"


def data_sheet_table(
    cache: SceneResultCache,
    scene: Scene,
    reference: Reference,
    validated_errors: Judged,
    gate_verdicts_of_models: Mapping[str, Verdict],
) -> Table:
    """Return the table of a scene's data sheet: each quantity by the 3D reference and by the models, with their errors.

    ``validated_errors``: errors by model and quantity. ``gate_verdicts_of_models``: verdicts of ``rollbench check`` on the
    contact loads, by model. For contact loads only the largest error is shown, because the worst contact differs from model
    to model: in per cent of the contact's load (for nearly unloaded contacts, of the mean load), as ``rollbench check``
    judges it, and in per cent of the mean load.
    """
    answers = {"3D reference": solution_from_run(reference.best, "")}
    answers |= {model: solution_from_result(cache.solve_once(scene.name, model)) for model in MODELS}
    origins = {"3D reference": "the 3D reference"} | {model: f"the model {model}" for model in MODELS}
    stated = TableColumn("u_val", f"validation uncertainty u_val of the error of the {DEFAULT} model", "%", ".2f")

    def quantity_row(
        quantity: str, errors: Mapping[str, float | None], u_val: float, values: Mapping[str, float | None]
    ) -> Row:
        return {
            "quantity": quantity,
            **{TableColumn(key, f"value by {origin}"): values.get(key) for key, origin in origins.items()},
            **{TableColumn(f"error-{m}", f"error of the model {m}", "%", "+.2f"): error for m, error in errors.items()},
            stated: u_val if np.isfinite(u_val) else None,
        }

    by_check = {model: verdict.error for model, verdict in gate_verdicts_of_models.items()}
    rows = [quantity_row("largest contact-load error by the rule of rollbench check", by_check, np.nan, {})]
    for q in uncertainty.QUANTITIES:
        single = q.name != uncertainty.CONTACTS
        errors = {model: validated_errors[model, q.name].error for model in MODELS}
        values = {key: float(q.values_of_solution(scene, answer)[0]) if single else None for key, answer in answers.items()}
        words = f"{q.name} [{q.unit}]" if single else "largest contact-load error, in per cent of the mean load"
        rows.append(quantity_row(words, errors, validated_errors[DEFAULT, q.name].combined, values))
    title = f"Results on {scene.name} by 3D reference and models, with the models' errors"
    return Table.from_rows(f"sheet-{scene.name}", title, rows)
