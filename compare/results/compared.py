"""Comparison of low-order models with the 3D reference for one nut or bearing: errors, table, JSON and verdict."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from rollbench.compare.errors import Refusal
from rollbench.compare.gate.verdict import LIMIT
from rollbench.compare.measure import LoadError, load_error
from rollbench.compare.models.answers import LoadAnswers, rate_contact_loads, unloaded_axial_displacement
from rollbench.compare.models.comparison import (
    Loads,
    SetOfAssembly,
    SetSolution,
    comparison_options,
    contact_load_errors,
    loads_from_result,
    loads_from_run,
    loads_of_reference_runs,
    solution_of_set,
    solve_and_time,
)
from rollbench.compare.models.loading import solve_scaled
from rollbench.compare.models.model_form import ModelForm, Point, errors_on_compared_scenes, estimate_model_error
from rollbench.compare.models.programs import model_title
from rollbench.compare.models.registry import DEFAULT, Model
from rollbench.compare.models.uncertainty import LoadUncertainty, uncertainty_of_loads
from rollbench.compare.quantities import record_as_json
from rollbench.compare.reference.estimate import Reference, largest_uncertainty_percent
from rollbench.compare.reference.levels import SOURCE_LEVEL
from rollbench.compare.reference.store import load_run
from rollbench.compare.results.rows import rows_with_reference
from rollbench.compare.results.scene_json import Axial, ball_loads_json, contact_ratings_json, expected_errors_json
from rollbench.lowfi.statics.nominal import nominal_contacts
from rollbench.meshes.helix import lead_angle
from rollbench.meshes.parts import Scene

#: Name of the stored 3D reference in tables that compare models with a user's reference.
OURS = "stored 3D reference"


@dataclass(frozen=True)
class ComparedLoads:
    """Contact loads of a model or of a 3D run, with their errors against the reference and the quantities that follow."""

    #: Contact loads and displacements of the model, or of the run of the 3D reference.
    answer: Loads
    #: Errors of the contact loads against the reference; None for the reference itself.
    error: LoadError | None
    #: Pressure, static safety and life, computed from the contact loads.
    found: LoadAnswers
    #: Axial displacement of the screw at the nut's centre from its unloaded position [m].
    displacement: float
    #: Axial force of the screw on the nut [N].
    force: float
    #: Number of contacts that are loaded in the screw without geometric errors.
    contacts: int
    #: Largest error of a contact load [%] as `rollbench check` defines it (`measure.scale_of_gate_errors`).
    by_gate: float = 0.0

    @property
    def label(self) -> str:
        """Name of the model, or of the run of the 3D reference, in the JSON."""
        return self.answer.model

    @property
    def title(self) -> str:
        """Name of the model, or of the run of the 3D reference, in tables and sentences."""
        return model_title(self.answer.model)

    @property
    def pressure(self) -> float:
        """Largest contact pressure [Pa]; zero if no contact is loaded."""
        return 0.0 if self.found.worst is None else self.found.worst.pressure


def compare_loads_with_reference(
    scene: Scene,
    answer: Loads,
    reference: Reference | None,
    unloaded_displacement: float = 0.0,
    contacts: int | None = None,
) -> ComparedLoads:
    """Compute the errors of contact loads against a reference, and the pressure, life and displacement that follow.

    Parameters
    ----------
    scene
        Scene with a single nut or bearing.
    answer
        Contact loads and displacements of a model or of the reference.
    reference
        The reference; None: no errors are computed.
    unloaded_displacement
        Axial displacement of the screw in the scene without external loads [m]; it is subtracted from the displacement.
    contacts
        Number of contacts that are loaded in the screw without geometric errors; None: computed from the scene.

    Returns
    -------
    ComparedLoads
        Loads, errors and results.
    """
    angle = np.radians(answer.angle)
    moved = float(np.interp(scene.nut.position, answer.stations, answer.line[:, 2])) if answer.stations.size else np.nan
    error = None if reference is None else load_error(answer.load, reference.load, reference.contacts)
    pull = np.where(answer.load > 0.0, answer.load * np.sin(angle), 0.0).sum(axis=0) * np.cos(lead_angle(scene.track))
    count = nominal_contacts(scene) if contacts is None else contacts
    found, force = rate_contact_loads(scene, answer.load, angle, pressure=answer.pressure), float(pull[0] - pull[1])
    points = [] if reference is None else contact_load_errors(reference.scene, reference, LIMIT, answer.load)
    by_gate = max((abs(p.error_percent) for p in points), default=0.0)
    return ComparedLoads(answer, error, found, moved - unloaded_displacement, force, count, by_gate)


@dataclass(frozen=True)
class SetComparison:
    """Comparison of models, and of coarser meshes of the 3D reference, with the reference of one nut or bearing."""

    #: Contact loads and errors of each model, and of the 3D reference on each coarser mesh.
    models: tuple[ComparedLoads, ...]
    #: Contact loads of the reference.
    itself: ComparedLoads
    #: Error to expect of the judged model (`judged_model`), estimated from comparisons on other scenes; None if unknown.
    expected: ModelForm | None
    #: Uncertainty of the errors, by its causes: mesh and choices of the reference, inputs of the scene.
    total: LoadUncertainty
    #: Axial position of the screw without loads [m], by the default model; displacements are measured from it.
    start: float = 0.0

    @property
    def judged_model(self) -> ComparedLoads:
        """Contact loads of the model whose error the verdict states: the default model if compared, else the first one."""
        return next((b for b in self.models if b.label == DEFAULT), self.models[0])


def compare_models_with_reference(
    scene: Scene,
    models: Sequence[Model],
    reference: Reference,
    stores: Sequence[Path],
    set_of_assembly: SetOfAssembly | None = None,
    stored_reference: Reference | None = None,
) -> SetComparison:
    """Compare models, and coarser meshes of the 3D reference, with the reference of one nut or bearing.

    Parameters
    ----------
    scene
        Scene with a single nut or bearing.
    models
        Models to compare.
    reference
        The reference: contact loads of the 3D finite-element model, or of a user's file.
    stores
        Folders with runs of the 3D reference.
    set_of_assembly
        The nut or bearing on a shaft with several that ``scene`` represents; None if the scene has only one.
    stored_reference
        Stored 3D reference that is compared too if ``reference`` comes from a user's file; otherwise None.

    Returns
    -------
    SetComparison
        The comparison.

    Raises
    ------
    InputError
        If a model cannot be run; the subclass Refusal if several nuts or bearings on one shaft have no equilibrium.
    """
    answers, expected, starts = [], {}, {}
    for model in models:
        of_model = (
            solve_and_compare(model, scene, reference, stores)
            if set_of_assembly is None
            else solution_of_set(set_of_assembly, model.name)
        )
        if isinstance(of_model, str):
            raise Refusal(reference.scene, "model", f"{model.name}: {of_model}", "choose another model with --model")
        answers.append(loads_from_result(of_model.result, of_model.seconds))
        starts[answers[-1].model] = unloaded_axial_displacement(scene, of_model.bare)
        if of_model.result.converged:
            expected[model.name] = estimate_model_error(
                of_model.scene, of_model.result, error_points_of_other_scenes(reference)
            )
    others = loads_of_reference_runs(
        reference, None if set_of_assembly is not None else load_run(scene, SOURCE_LEVEL, stores=tuple(stores))
    )
    answers += [answer for answer in others if not is_from_finest_reference_run(answer, reference)]
    answers += [] if stored_reference is None else [loads_from_run(stored_reference.best, OURS)]
    shared = starts.get(DEFAULT, next(iter(starts.values()), 0.0))  # no run of the reference without loads is stored
    count = None if set_of_assembly is None else reference.contacts
    each = tuple(
        compare_loads_with_reference(scene, answer, reference, starts.get(answer.model, shared), count)
        for answer in answers
    )
    itself = compare_loads_with_reference(scene, loads_from_run(reference.best, reference.label), None, shared, count)
    whole = SetComparison(
        each, itself, None, uncertainty_of_loads(scene, reference, inputs=set_of_assembly is None), shared
    )
    return replace(whole, expected=expected.get(whole.judged_model.label))


def solve_and_compare(model: Model, scene: Scene, reference: Reference, stores: Sequence[Path]) -> SetSolution:
    """Solve a scene with a single nut or bearing by a low-order model, with and without its external loads.

    ``reference``: 3D reference whose condensed bodies a model may need. ``stores``: folders with runs of the 3D reference.
    The time of the solution with loads is measured.
    """
    result, seconds = solve_and_time(model, scene, reference, stores)
    bare = solve_scaled(scene, 0.0, model.name, comparison_options(model, scene, reference, stores, "interpreted"))
    return SetSolution(result, bare, seconds, scene)


def error_points_of_other_scenes(reference: Reference) -> list[Point]:
    """Return the known errors of models on scenes other than that of a reference, for estimating the errors to expect.

    ``reference``: reference of the scene whose errors are left out.
    """
    own = {reference.scene, *(run.scene for run in reference.runs)}
    return [point for point in errors_on_compared_scenes() if point.scene not in own]


def loads_and_rigidities(compared_loads: ComparedLoads) -> dict[str, Any]:
    """Return the loads of a model or the 3D reference, and rigidity, pressure and life that follow from them, as JSON.

    ``compared_loads``: the loads. Forces are in N, displacements in um, rigidities in N/um.
    """
    stiff = (
        compared_loads.force / compared_loads.displacement
        if compared_loads.displacement * compared_loads.force > 0.0
        else None
    )
    axial = record_as_json(
        Axial(compared_loads.force, compared_loads.displacement, stiff),
        "tangent_N_per_um",
        "tangent_words",
        "stepped_N_per_um",
        "lost_motion_um_per_100N",
    )
    return {
        "loads": ball_loads_json(compared_loads.answer.load, compared_loads.contacts),
        "axial": axial,
        **contact_ratings_json(compared_loads.found),
    }


def comparison_json(comparison: SetComparison, reference: Reference) -> dict[str, Any]:
    """Return the comparison of models with a reference as JSON: verdict, errors, uncertainty and all results.

    ``comparison``: the comparison of models with ``reference``.
    """
    error, expected = comparison.judged_model.error, comparison.expected
    return {
        "scene": reference.scene,
        "verdict": comparison_verdict_sentence(comparison, reference),
        "levels": list(reference.levels),
        "uncertainty_percent": largest_uncertainty_percent(reference),
        "reference_status": reference.unsettled or "converged",
        "uncertainty": record_as_json(comparison.total),
        "model": comparison.judged_model.label,
        "expected_error_percent": None if expected is None else expected.percent,
        **expected_errors_json(expected, "expected_{}_error_percent"),
        "measured_error_percent": None if error is None else error.max_percent,
        "answers": {b.label: loads_and_rigidities(b) for b in (comparison.itself, *comparison.models)},
    }


def is_from_finest_reference_run(answer: Loads, reference: Reference) -> bool:
    """Return whether contact loads are those of the reference's finest 3D run, against which all errors are computed."""
    return answer.model == f"3D level {reference.best.level}"


def reference_uncertainty_text(reference: Reference, total: LoadUncertainty) -> str:
    """Return a phrase on the uncertainty and the mesh levels of the reference.

    ``total``: uncertainty of the comparison. For a reference from a user's file, the text is what the file states.
    """
    if reference.stated:
        return total.stated
    levels = ", ".join(str(run.level) for run in reference.runs)
    rest = f"; {reference.unsettled}, which is included" if reference.unsettled else ""
    of = f"3D reference on mesh level{'s' * (len(reference.runs) > 1)} {levels}{rest}"
    return f"uncertain by {total.percent:.2f} % ({of})"


def comparison_verdict_sentence(comparison: SetComparison, reference: Reference) -> str:
    """Return one sentence on a comparison: measured and expected error of the judged model, uncertainty of the reference.

    ``comparison``: the comparison of models with ``reference``.
    """
    b, worth, e = comparison.judged_model, comparison.expected, comparison.judged_model.error
    off = expected = ""
    if e is not None:
        where = f" (ball {e.ball} {e.side})" if e.ball else ""
        off = (
            f"error of {b.title}: {e.max_percent:.2f} % of the mean load on the worst contact{where}, "
            f"{e.rms_percent:.2f} % RMS, {b.by_gate:.2f} % as judged by rollbench check"
        )
    if worth is not None:
        expected = "not covered by earlier comparisons" if worth.percent is None else f"{worth.percent:.2f} %"
    return "; ".join(
        filter(
            None, [off, expected and f"expected error: {expected}", reference_uncertainty_text(reference, comparison.total)]
        )
    )


def model_and_reference_rows(comparison: SetComparison) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Return headings and rows of the table that compares the judged model with the reference.

    Parameters
    ----------
    comparison
        The comparison.

    Returns
    -------
    tuple[tuple[str, ...], list[tuple[str, ...]]]
        Headings, and the texts of each row, one for each heading.
    """
    headings = ("quantity", comparison.judged_model.title, comparison.itself.label, "unit", "difference", "expected")
    return headings, [
        *rows_with_reference(
            loads_and_rigidities(comparison.judged_model), loads_and_rigidities(comparison.itself), comparison.expected
        )
    ]
