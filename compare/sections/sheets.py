"""A sheet for every scene that was solved in 3D: sketch, inputs, result, verdict, and how far to trust it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from rollbench.comparison.models.comparison import REFERENCED, from_result, from_run
from rollbench.comparison.models.ladder import UNSEEN
from rollbench.comparison.models.registry import DEFAULT
from rollbench.comparison.models.study import Study
from rollbench.comparison.models.u_val import CONTACTS, QUANTITIES, Validated, validated
from rollbench.comparison.reference.estimate import Reference
from rollbench.comparison.sections.sketch import sketch_of
from rollbench.meshes.parts import SIDES, Scene
from rollbench.reports.content import Figure, Quantity, Row, Section, Sketch, Table, Text

#: Limit [%] of the verdict, that of the gate.
LIMIT = 7.0
#: Models on a sheet, the one that the verdict is on first.
MODELS = (DEFAULT, "lin")

LEGEND = (
    "Sketches are to scale near the nut. Hatched: surface held in the 3D reference; pale: balls behind the "
    f"axis. Verdicts are for {DEFAULT} and the inputs as stated, which model and reference share. u_val: how closely the "
    "error against a real screw would be known, input tolerances included, with 95 % confidence (section u-val)."
)

Judged = Mapping[tuple[str, str], Validated]


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report: the sheets, the source's cases first."""
    step("a sheet for every scene with a 3D reference")
    found = study.references((*REFERENCED, *UNSEEN))
    title = "A sheet for every case"
    if not found:
        return Section("sheets", title, (Text(("No run of the 3D reference was found.",)),))
    judged = {name: judge(study, name) for name in found}
    legend = Text((LEGEND,))
    items = [legend, *(item for name, reference in found.items() for item in sheet(study, name, reference, judged[name]))]
    return Section("sheets", title, items, conclusion=conclusion(judged))


def judge(study: Study, name: str) -> Judged:
    """Every model of a sheet on every quantity, by the names of both."""
    return {
        (model, quantity.name): one
        for model in MODELS
        for quantity in QUANTITIES
        if (one := validated(study, name, model, quantity, from_result(study.solve(name, model)))) is not None
    }


def conclusion(judged: Mapping[str, Judged]) -> str:
    """The largest error of either model on the source's cases and on the others."""
    kinds = (
        ("case studies of the source", REFERENCED),
        ("screws and bearings that were fixed before they were solved in 3D", UNSEEN),
    )
    words = []
    for kind, names in kinds:
        of_kind = {name: judged[name] for name in names if name in judged}
        if of_kind:
            worst = [_largest(of_kind, model) for model in MODELS]
            words.append(f"{' and '.join(worst)} on the {len(of_kind)} {kind}")
    return f"The worst contact load is off by {'; by '.join(words)}, in per cent of the mean load."


def _largest(judged: Mapping[str, Judged], model: str) -> str:
    errors = {name: abs(v[model, CONTACTS].error) for name, v in judged.items()}
    name = max(errors, key=errors.__getitem__)
    return f"{errors[name]:.1f} % in {model} ({name})"


def sheet(study: Study, name: str, reference: Reference, judged: Judged) -> Sequence[Text | Sketch | Table | Figure]:
    """One sheet: heading and verdict, sketch with its inputs, results."""
    scene = study.scene(name)
    words = (verdict(study, name, reference, judged), trust(reference, judged[DEFAULT, CONTACTS]))
    return (
        Text(words, heading=f"{name}: {scene.title}"),
        sketch_of(scene, f"sketch-{name}", name),
        results(study, scene, reference, judged),
    )


def verdict(study: Study, name: str, reference: Reference, judged: Judged) -> str:
    """Which contact of each model is off most, and whether that is within the limit."""
    sentences = []
    for model in MODELS:
        error = judged[model, CONTACTS].error
        load = study.solve(name, model).load
        ball, side = np.unravel_index(int(np.abs(load - reference.load).argmax()), load.shape)
        fit = "fit" if abs(error) <= LIMIT else "not fit"
        off = f"{error:+.2f}".replace("-", "−")
        sentences.append(f"{model} is {fit} for {LIMIT:g} %: {off} % of the mean load on ball {ball + 1} {SIDES[side]}")
    return f"Verdict: {'; '.join(sentences)}."


def trust(reference: Reference, bounds: Validated) -> str:
    """Uncertainty of the errors of a sheet."""
    levels = ", ".join(str(run.level) for run in reference.runs)
    parts = [("mesh", bounds.grid), ("modelling choices", bounds.choices), ("input tolerances", bounds.inputs)]
    known = ", ".join(f"{name} {value:.2f}" for name, value in parts if np.isfinite(value))
    whole = f"u_val {bounds.combined:.2f} %" if np.isfinite(bounds.combined) else "u_val unknown, of one mesh level"
    also = f" {reference.unsettled[:1].upper()}{reference.unsettled[1:]}." if reference.unsettled else ""
    return f"How far to trust it: mesh levels {levels} of the 3D reference; {whole} there, of which {known}.{also}"


def results(study: Study, scene: Scene, reference: Reference, judged: Judged) -> Table:
    """The quantities of a sheet: reference, models, their errors, verdict on the default model. Of all contact loads it
    has only the errors, as the worst contact is another one in each model."""
    answers = {"3D reference": from_run(reference.best, "")}
    answers |= {model: from_result(study.solve(scene.name, model)) for model in MODELS}
    rows: list[Row] = []
    for quantity in QUANTITIES:
        first, *_ = of_models = [judged[model, quantity.name] for model in MODELS]
        single = quantity.name != CONTACTS
        values = {key: float(quantity.take(scene, answer)[0]) if single else None for key, answer in answers.items()}
        rows.append(
            {
                "quantity": f"{quantity.name} [{quantity.unit}]" if single else f"{quantity.name}, the worst",
                **{Quantity(key, key): value for key, value in values.items()},
                **{Quantity(f"error-{v.model}", f"error of {v.model}", "%", "+.2f"): v.error for v in of_models},
                Quantity("u_val", "u_val", "%", ".2f"): first.combined if np.isfinite(first.combined) else None,
                "verdict": f"{'within' if abs(first.error) <= LIMIT else 'not within'} {LIMIT:g} %",
            }
        )
    return Table.of(f"sheet-{scene.name}", f"{scene.name}, results", rows)
