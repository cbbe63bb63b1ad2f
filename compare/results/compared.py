"""Models compared with a 3D reference, set by set, and what is said of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from rollbench.compare.errors import Refusal
from rollbench.compare.gate.verdict import LIMIT
from rollbench.compare.measure import LoadError, load_error
from rollbench.compare.models.answers import LoadAnswers, load_answers, unloaded_place
from rollbench.compare.models.comparison import (
    Answered,
    Loads,
    SetOf,
    answered,
    from_result,
    from_run,
    gate_points,
    options_for,
    reference_answers,
    solved,
)
from rollbench.compare.models.loading import solve_scaled
from rollbench.compare.models.model_form import ModelForm, Point, estimate, shipped_points
from rollbench.compare.models.programs import title_of
from rollbench.compare.models.registry import DEFAULT, Model
from rollbench.compare.models.uncertainty import Total, total
from rollbench.compare.quantities import as_json
from rollbench.compare.reference.estimate import Reference, uncertainty_percent
from rollbench.compare.reference.levels import SOURCE_LEVEL
from rollbench.compare.reference.store import load
from rollbench.compare.results.rows import compared_rows
from rollbench.compare.results.scene_json import Axial, contacts_json, expected_json, loads_json
from rollbench.lowfi.statics.nominal import nominal_contacts
from rollbench.meshes.helix import lead_angle
from rollbench.meshes.parts import Scene

#: Name of the stored 3D reference next to a user's own.
OURS = "stored 3D reference"


@dataclass(frozen=True)
class Beside:
    """A model beside the reference: its answer, its errors (None for the reference itself), what its loads answer, axial
    displacement [m] of the screw at the nut's centre from its place without loads, axial force [N] of it on the nut, how
    many contacts the nominal screw loads; largest error [%] of a contact as the gate has it."""

    answer: Loads
    error: LoadError | None
    found: LoadAnswers
    displacement: float
    force: float
    contacts: int
    by_gate: float = 0.0

    @property
    def label(self) -> str:
        """What names it among others."""
        return self.answer.model

    @property
    def title(self) -> str:
        """Name for tables."""
        return title_of(self.answer.model)

    @property
    def pressure(self) -> float:
        """Pole pressure [Pa] of the worst contact."""
        return 0.0 if self.found.worst is None else self.found.worst.pressure


def beside(scene: Scene, answer: Loads, ref: Reference | None, start: float = 0.0, contacts: int | None = None) -> Beside:
    """An answer beside a reference, or by itself; start: the axial place [m] without loads; contacts: how many the nominal
    screw loads, where the scene itself does not tell."""
    angle = np.radians(answer.angle)
    moved = float(np.interp(scene.nut.position, answer.stations, answer.line[:, 2])) if answer.stations.size else np.nan
    error = None if ref is None else load_error(answer.load, ref.load, ref.contacts)
    pull = np.where(answer.load > 0.0, answer.load * np.sin(angle), 0.0).sum(axis=0) * np.cos(lead_angle(scene.track))
    count = nominal_contacts(scene) if contacts is None else contacts
    found, force = load_answers(scene, answer.load, angle, pressure=answer.pressure), float(pull[0] - pull[1])
    points = [] if ref is None else gate_points(ref.scene, ref, LIMIT, answer.load)
    by_gate = max((abs(p.error_percent) for p in points), default=0.0)
    return Beside(answer, error, found, moved - start, force, count, by_gate)


@dataclass(frozen=True)
class Compared:
    """Models and coarser meshes beside the reference of a scene; the reference itself; the error that was to be expected of
    the model that the verdict speaks of; what the comparison is uncertain by; start: axial place [m] of the screw without
    loads by that model, from which the displacements of the reference are counted too."""

    models: tuple[Beside, ...]
    itself: Beside
    expected: ModelForm | None
    total: Total
    start: float = 0.0

    @property
    def spoken(self) -> Beside:
        """What the verdict speaks of: the default model, or else the first."""
        return next((b for b in self.models if b.label == DEFAULT), self.models[0])


def compared(
    scene: Scene,
    models: Sequence[Model],
    reference: Reference,
    stores: Sequence[Path],
    of: SetOf | None = None,
    ours: Reference | None = None,
) -> Compared:
    """Models, coarser meshes and the source's mesh beside the reference; of: which set it is of several on one shaft; ours:
    the stored 3D reference beside a user's own.

    Raises InputError for a model that cannot be run, Refusal for one that finds no loads of several sets.
    """
    answers, expected, starts = [], {}, {}
    for model in models:
        of_model = answer_of(model, scene, reference, stores) if of is None else answered(of, model.name)
        if isinstance(of_model, str):
            raise Refusal(reference.scene, "model", f"{model.name}: {of_model}", "choose another one with --model")
        answers.append(from_result(of_model.result, of_model.seconds))
        starts[answers[-1].model] = unloaded_place(scene, of_model.bare)
        if of_model.result.converged:
            expected[model.name] = estimate(of_model.scene, of_model.result, others_than(reference))
    others = reference_answers(reference, None if of is not None else load(scene, SOURCE_LEVEL, stores=tuple(stores)))
    answers += [answer for answer in others if not is_itself(answer, reference)]
    answers += [] if ours is None else [from_run(ours.best, OURS)]
    shared = starts.get(DEFAULT, next(iter(starts.values()), 0.0))  # of the reference no run without loads is stored
    count = None if of is None else reference.contacts
    each = tuple(beside(scene, answer, reference, starts.get(answer.model, shared), count) for answer in answers)
    itself = beside(scene, from_run(reference.best, reference.label), None, shared, count)
    whole = Compared(each, itself, None, total(scene, reference, inputs=of is None), shared)
    return replace(whole, expected=expected.get(whole.spoken.label))


def answer_of(model: Model, scene: Scene, reference: Reference, stores: Sequence[Path]) -> Answered:
    """What a model finds for a scene of one set."""
    result, seconds = solved(model, scene, reference, stores)
    bare = solve_scaled(scene, 0.0, model.name, options_for(model, scene, reference, stores, "interpreted"))
    return Answered(result, bare, seconds, scene)


def others_than(reference: Reference) -> list[Point]:
    """Compared points of other scenes, whatever the name of this one: what is measured here is not to be expected of
    itself."""
    own = {reference.scene, *(run.scene for run in reference.runs)}
    return [point for point in shipped_points() if point.scene not in own]


def answers_of(b: Beside) -> dict[str, Any]:
    """What the loads of a model or of the reference answer, as JSON has it; null where there is no such answer."""
    stiff = b.force / b.displacement if b.displacement * b.force > 0.0 else None
    axial = as_json(
        Axial(b.force, b.displacement, stiff),
        "tangent_N_per_um",
        "tangent_words",
        "stepped_N_per_um",
        "lost_motion_um_per_100N",
    )
    return {"loads": loads_json(b.answer.load, b.contacts), "axial": axial, **contacts_json(b.found)}


def answers_json(whole: Compared, reference: Reference) -> dict[str, Any]:
    """Verdict, levels and uncertainty of the reference, error expected and measured, answers of models and reference."""
    error, expected = whole.spoken.error, whole.expected
    return {
        "scene": reference.scene,
        "verdict": verdict(whole, reference),
        "levels": list(reference.levels),
        "uncertainty_percent": uncertainty_percent(reference),
        "reference_status": reference.unsettled or "converged",
        "uncertainty": as_json(whole.total),
        "model": whole.spoken.label,
        "expected_error_percent": None if expected is None else expected.percent,
        **expected_json(expected, "expected_{}_error_percent"),
        "measured_error_percent": None if error is None else error.max_percent,
        "answers": {b.label: answers_of(b) for b in (whole.itself, *whole.models)},
    }


def is_itself(answer: Loads, reference: Reference) -> bool:
    """Whether an answer is the run that it would be compared with."""
    return answer.model == f"3D level {reference.best.level}"


def levels_text(reference: Reference, total: Total) -> str:
    """Levels of the reference and what it is uncertain by, in words."""
    if reference.stated:
        return total.stated
    levels = ", ".join(str(run.level) for run in reference.runs)
    rest = f"; {reference.unsettled}, which is added" if reference.unsettled else ""
    of = f"3D reference on level{'s' * (len(reference.runs) > 1)} {levels}{rest}"
    return f"uncertain by {total.percent:.2f} % ({of})"


def verdict(whole: Compared, reference: Reference) -> str:
    """The first sentence: the error of the default model, or of the first one, what was to be expected, and what the
    comparison is uncertain by."""
    b, worth, e = whole.spoken, whole.expected, whole.spoken.error
    off = expected = ""
    if e is not None:
        where = f" (ball {e.ball} {e.side})" if e.ball else ""
        off = (
            f"{b.title} is off by {e.max_percent:.2f} % of the mean load on the worst contact{where}, "
            f"{e.rms_percent:.2f} % RMS, {b.by_gate:.2f} % by the gate's rule"
        )
    if worth is not None:
        expected = "not covered by earlier comparisons" if worth.percent is None else f"{worth.percent:.2f} %"
    return "; ".join(filter(None, [off, expected and f"expected: {expected}", levels_text(reference, whole.total)]))


def answer_rows(whole: Compared) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Headings and rows of the table of a comparison: answers of the model of the verdict, and those of the reference."""
    headings = ("quantity", whole.spoken.title, whole.itself.label, "unit", "difference", "expected")
    return headings, [*compared_rows(answers_of(whole.spoken), answers_of(whole.itself), whole.expected)]
