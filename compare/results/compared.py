"""Comparison of low-order models with the 3D reference for one nut or bearing: errors, table, JSON and verdict."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from rollbench.compare.errors import SceneNotCoveredError
from rollbench.compare.measure import LoadError, error_percent, load_error
from rollbench.compare.models import comparison, model_form
from rollbench.compare.models.answers import motion_of_unloaded_screw, results_of_contact_loads
from rollbench.compare.models.loading import solve_with_scaled_loads
from rollbench.compare.models.model import Model
from rollbench.compare.models.programs import model_title
from rollbench.compare.models.registry import DEFAULT
from rollbench.compare.models.set_results import SetResult, ball_load_summary
from rollbench.compare.models.stiffness import LoadPointStiffness, place_of_displacement, place_text
from rollbench.compare.models.uncertainty import Uncertainty, uncertainty_of_loads
from rollbench.compare.quantities import record_as_json
from rollbench.compare.reference.estimate import Reference
from rollbench.compare.reference.levels import SOURCE_LEVEL
from rollbench.compare.reference.store import load_stored_run
from rollbench.compare.results.rows import nested_records, rows_with_reference
from rollbench.compare.results.solved import AxialResults
from rollbench.lowfi.statics.nominal import count_nominal_contacts
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import Scene
from rollbench.meshes.quantity import QuantityDescription, quantity_field, result_record

#: Name of the stored 3D reference in tables that compare models with a user's reference.
OURS = "stored 3D reference"


@dataclass(frozen=True, eq=False, repr=False)
class ModelLoads:
    """Contact loads of a model or of a 3D run, with their errors, and the pressure and life that follow.

    The four columns of arrays are the groove flanks SL, SR, NL, NR (screw or nut, left or right).
    """

    #: Contact loads and displacements of the model, or of the run of the 3D reference.
    contact_loads: comparison.ContactSolution
    #: Errors of the contact loads against the reference; None for the reference itself.
    error: LoadError | None
    #: Pressure, static safety and life, computed from the contact loads.
    derived_results: SetResult
    #: Axial position of the screw's section on which the load acts [m]; without a force, the nut's centre.
    place: float
    #: Axial displacement of the screw's section on which the load acts, to ground, from its unloaded position [m]; nan if
    #: not known.
    displacement: float
    #: Axial force of the screw on the nut [N].
    axial_force: float
    #: Number of contacts that are loaded in the screw without geometric errors.
    nominal_contacts: int
    #: Largest error of a contact load [%] as `rollbench check` defines it (`measure.load_scale_of_check_errors`).
    gate_error: float = 0.0
    #: Errors of n balls' loads on the four flanks ``(n, 4)`` [% of the mean contact load of the reference]; None for the
    #: reference itself.
    errors: Array | None = None

    @property
    def name(self) -> str:
        """Name of the model; ``3D reference``; ``3D level 1`` for a coarser mesh; or the file of a reference."""
        return self.contact_loads.model

    @property
    def loads(self) -> Array:
        """Contact loads of n balls on the four groove flanks ``(n, 4)`` [N]."""
        return self.contact_loads.load

    @property
    def angles(self) -> Array:
        """Contact angles of n balls, from the radial plane ``(n, 4)`` [rad]; nan without contact."""
        return np.where(self.loads > 0.0, np.radians(self.contact_loads.angle), np.nan)

    @property
    def L10(self) -> float | None:
        """Life [revolutions], L10 of a nut, L10r of a bearing; None without loads, and outside the formulas' range."""
        life = self.derived_results.life_by_loads
        return None if life is None else 1e6 * life.revolutions

    @property
    def seconds(self) -> float | None:
        """Computing time of the model or of the reference [s]; None if not measured."""
        return self.contact_loads.seconds or None

    @property
    def measured(self) -> str:
        """Version of rollbench and computer with which the time was measured; empty for those in use now."""
        return self.contact_loads.measured

    @property
    @QuantityDescription(
        "measured_error_percent",
        "measured largest error of a contact load, in per cent of the reference's mean load",
        error="`uncertainty.discretisation_percent`",
    )
    def largest_error(self) -> float | None:
        """Largest absolute error of a contact load [% of the mean contact load]; None for the reference itself."""
        return None if self.error is None else self.error.max_percent

    @property
    def rms_error(self) -> float | None:
        """Root mean square error over the loaded contacts [% of the mean contact load]; None for the reference itself."""
        return None if self.error is None else self.error.rms_percent

    @property
    def ball(self) -> int:
        """Number of the ball with the largest error, from 1; 0 for the reference itself."""
        return 0 if self.error is None else self.error.ball

    @property
    def side(self) -> str:
        """Groove flank with the largest error: SL, SR, NL or NR; empty for the reference itself."""
        return "" if self.error is None else self.error.side

    def __repr__(self) -> str:
        """Return a text with the name, and for a model its largest and its root mean square error."""
        if self.error is None:
            return self.name
        return f"{self.name}: largest error {self.largest_error:.2f} % of the mean load, RMS {self.rms_error:.2f} %"

    @property
    def title(self) -> str:
        """Name of the model, or of the run of the 3D reference, in tables and sentences."""
        return model_title(self.contact_loads.model)

    @property
    def pressure(self) -> float:
        """Largest contact pressure [Pa]; zero if no contact is loaded."""
        return 0.0 if self.derived_results.worst is None else self.derived_results.worst.pressure


def compare_loads_with_reference(
    scene: Scene,
    answer: comparison.ContactSolution,
    reference: Reference | None,
    unloaded_displacement: float = 0.0,
    contacts: int | None = None,
) -> ModelLoads:
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
        Number of contacts that are loaded in the screw without geometric errors, by which the sum of the loads is divided
        for the mean load; None: computed from the scene.

    Returns
    -------
    ModelLoads
        The contact loads, their errors, and the quantities that follow from the loads.
    """
    angle = np.radians(answer.angle)
    at = place_of_displacement(scene)
    moved = float(np.interp(at, answer.stations, answer.line[:, 2])) if answer.stations.size else np.nan
    error = None if reference is None else load_error(answer.load, reference.load, reference.contacts)
    count = count_nominal_contacts(scene) if contacts is None else contacts
    found = results_of_contact_loads(scene, answer.load, angle, pressure=answer.pressure)
    force = model_form.axial_contact_force(scene, answer.load, angle)
    points = [] if reference is None else comparison.contact_load_errors(reference, answer.load)
    by_gate = max((abs(p.error) for p in points), default=0.0)
    errors = None if reference is None else np.asarray(error_percent(answer.load, reference.load, reference.mean))
    return ModelLoads(answer, error, found, at, moved - unloaded_displacement, force, count, by_gate, errors)


@result_record
class NutOrBearingComparison:
    """Comparison of models, and of coarser meshes of the 3D reference, with the reference loads of one nut or bearing."""

    #: Contact loads and errors of each model, and of the 3D reference on each coarser mesh.
    models: tuple[ModelLoads, ...]
    #: Contact loads of the reference.
    reference_loads: ModelLoads
    #: Error to expect of the judged model (`judged_model`), estimated from comparisons on other scenes; None if unknown.
    expected: model_form.ExpectedError | None = quantity_field(
        "expected_error_percent",
        "largest error of a contact load that `model_form` estimates for the model",
        QuantityDescription(
            "expected_displacement_error_percent",
            "expected error of the displacement of the load's point, along z",
            show=lambda expected: expected and expected.displacement,
        ),
        QuantityDescription(
            "expected_rigidity_error_percent",
            "expected error of the tangent rigidity of the load's point, along z",
            show=lambda expected: expected and expected.rigidity,
        ),
        QuantityDescription(
            "expected_pressure_error_percent",
            "expected error of the largest pressure",
            show=lambda expected: expected and expected.pressure,
        ),
        show=lambda expected: expected and expected.loads,
    )
    #: Uncertainty of the errors, by its causes: mesh and choices of the reference, inputs of the scene.
    uncertainty: Uncertainty = quantity_field(
        "uncertainty_percent",
        "uncertainty of the reference's most uncertain contact load that is due to its mesh, at 95 % confidence",
        show=lambda uncertainty: uncertainty.discretisation,
    )
    #: Axial displacement of the screw without external loads [m], by the default model; displacements under load are
    #: measured from it.
    unloaded_position: float = 0.0

    @property
    def judged_model(self) -> ModelLoads:
        """Contact loads of the model whose error the verdict states: the default model if compared, else the first one."""
        return next((b for b in self.models if b.name == DEFAULT), self.models[0])


def compare_models_with_reference(
    scene: Scene,
    models: Sequence[Model],
    reference: Reference,
    stores: Sequence[Path],
    place: comparison.NutOrBearingOnShaft | None = None,
    stored_reference: Reference | None = None,
) -> NutOrBearingComparison:
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
    place
        The nut or bearing that ``scene`` represents, if it is one of several on a shaft; otherwise None.
    stored_reference
        Stored 3D reference that is compared too if ``reference`` comes from a user's file; otherwise None.

    Returns
    -------
    NutOrBearingComparison
        The comparison.

    Raises
    ------
    InputError
        If a model cannot be run; the subclass SceneNotCoveredError if several nuts or bearings on one shaft have no
        equilibrium.
    """
    answers, expected, starts = [], {}, {}
    for model in models:
        if place is None:
            by_model: comparison.NutOrBearingSolution | str = solve_with_and_without_loads(model, scene, reference, stores)
        else:
            by_model = comparison.solution_of_nut_or_bearing(place, model.name)
        if isinstance(by_model, str):
            reason, advice = f"{model.name}: {by_model}", "choose another model with --model"
            raise SceneNotCoveredError(reference.scene, "model", reason, advice)
        answers.append(comparison.solution_from_result(by_model.loaded_result, by_model.seconds))
        bare = motion_of_unloaded_screw(by_model.unloaded_result, place_of_displacement(scene))
        starts[answers[-1].model] = float(bare[2])
        if by_model.loaded_result.converged:
            measured = measured_errors_on_other_scenes(reference)
            if place is None:
                estimate = model_form.estimate_model_error(by_model.scene, by_model.loaded_result, measured)
            else:
                whole = comparison.solve_loaded_and_unloaded(place.assembly, model.name)[0]
                estimate = model_form.estimate_double_nut_error(place.assembly, whole, measured)
            expected[model.name] = estimate
    source_mesh_run = None if place is not None else load_stored_run(scene, SOURCE_LEVEL, stores=tuple(stores))
    others = comparison.solutions_of_reference_runs(reference, source_mesh_run)
    finest = f"3D level {reference.best.level}"  # all errors are computed against its loads
    answers += [answer for answer in others if answer.model != finest]
    answers += [] if stored_reference is None else [comparison.solution_from_run(stored_reference.best, OURS)]
    shared = starts.get(DEFAULT, next(iter(starts.values()), 0.0))  # no run of the reference without loads is stored
    count = None if place is None else reference.contacts
    errors = (
        compare_loads_with_reference(scene, answer, reference, starts.get(answer.model, shared), count)
        for answer in answers
    )
    best = comparison.solution_from_run(reference.best, reference.label)
    itself = compare_loads_with_reference(scene, best, None, shared, count)
    uncertainty = uncertainty_of_loads(scene, reference, inputs=place is None)
    compared = NutOrBearingComparison(tuple(errors), itself, None, uncertainty, shared)
    return replace(compared, expected=expected.get(compared.judged_model.name))


def solve_with_and_without_loads(
    model: Model, scene: Scene, reference: Reference, stores: Sequence[Path]
) -> comparison.NutOrBearingSolution:
    """Solve a scene with a single nut or bearing by a low-order model, with and without its external loads.

    ``reference``: 3D reference from which the model "condensed" takes the stiffness matrices of screw and nut. ``stores``:
    folders with runs of the 3D reference. The time of the solution with loads is measured.
    """
    result, seconds = comparison.solve_and_time(model, scene, reference, stores)
    options = comparison.comparison_options(model, scene, reference, stores)
    bare = solve_with_scaled_loads(scene, 0.0, model.name, options)
    return comparison.NutOrBearingSolution(result, bare, seconds, scene)


def measured_errors_on_other_scenes(reference: Reference) -> list[model_form.MeasuredModelErrors]:
    """Return the measured errors of models on all scenes but one, from which the errors to expect on this one follow.

    ``reference``: 3D reference of the scene that is left out.
    """
    own = {reference.scene, *(run.scene for run in reference.runs)}
    points = model_form.model_errors_on_compared_scenes()
    return [point for point in points if not {point.scene, point.described_scene} & own]


#: Keys of the results of a nut or bearing that follow from its contact loads alone.
OF_LOADS = (
    "worst_contact",
    "static_safety",
    "truncation",
    "life",
    "ratings",
    "rating_refused",
    "modified_life",
    "reference_life",
    "life_words",
)


def records_of_loads(one: ModelLoads) -> dict[str, Any]:
    """Return the records of contact loads, rigidity, pressure and life of a model or of the 3D reference by their keys.

    ``one``: the contact loads, from which the other values follow.
    """
    force, moved = one.axial_force, one.displacement
    secant = force / moved if moved * force > 0.0 else None
    return {
        "loads": ball_load_summary(one.contact_loads.load, one.nominal_contacts),
        "axial": AxialResults(force),
        "load_point": LoadPointStiffness(place_text(one.place), "z", force, moved, secant, None),
        **{key: record for key, record in nested_records(one.derived_results).items() if key in OF_LOADS},
    }


def loads_and_rigidities_json(one: ModelLoads) -> dict[str, Any]:
    """Return contact loads, rigidity, pressure and life of a model or of the 3D reference as JSON.

    ``one``: the contact loads, from which the other values follow. Forces are in N, displacements in um,
    rigidities in N/um.
    """
    data = {key: record_as_json(record) for key, record in records_of_loads(one).items()}
    del data["load_point"]["tangent_N_per_um"]
    ratings = record_as_json(one.derived_results)
    return data | {key: ratings[key] for key in OF_LOADS}


def comparison_json(compared: NutOrBearingComparison, reference: Reference) -> dict[str, Any]:
    """Return the comparison of models with a reference as JSON: verdict, errors, uncertainty and all results.

    ``compared``: the comparison of models with ``reference``.
    """
    error = compared.judged_model.error
    return {
        "scene": reference.scene,
        "verdict": comparison_verdict_sentence(compared, reference),
        "levels": list(reference.levels),
        "reference_status": reference.unsettled or "converged",
        "uncertainty": record_as_json(compared.uncertainty),
        "model": compared.judged_model.name,
        **record_as_json(compared),
        "measured_error_percent": None if error is None else error.max_percent,
        "answers": {b.name: loads_and_rigidities_json(b) for b in (compared.reference_loads, *compared.models)},
    }


def reference_uncertainty_text(reference: Reference, total: Uncertainty) -> str:
    """Return a phrase on the numerical uncertainty and mesh levels of the reference, and on the input uncertainty.

    The error of a model is judged by the numerical uncertainty: model and reference have the same inputs. ``total``:
    uncertainty of the comparison. For a reference from a user's file, the text is what the file states.
    """
    if reference.stated:
        return total.stated
    levels = ", ".join(str(run.level) for run in reference.runs)
    rest = f"; {reference.unsettled}, which is included" if reference.unsettled else ""
    of = f"3D reference on mesh level{'s' * (len(reference.runs) > 1)} {levels}{rest}"
    inputs = "" if total.inputs is None else f"; input uncertainty (tolerances) {total.inputs:.2f} %"
    return f"numerical uncertainty (mesh) {total.discretisation:.2f} % of the mean load ({of}){inputs}"


def comparison_verdict_sentence(compared: NutOrBearingComparison, reference: Reference) -> str:
    """Return one sentence on a comparison: measured and expected error of one model, and uncertainty of the reference.

    The model is the default model or, if that was not compared, the first one.

    ``compared``: the comparison of models with ``reference``.
    """
    model, expected, e = compared.judged_model, compared.expected, compared.judged_model.error
    phrases = []
    if e is not None:
        where = f" (ball {e.ball} {e.side})" if e.ball else ""
        phrases.append(
            f"error of {model.title}: {e.max_percent:.2f} % of the mean load on the worst contact{where}, "
            f"{e.rms_percent:.2f} % RMS, {model.gate_error:.2f} % as judged by rollbench check"
        )
    if expected is not None:
        percent = "not covered by earlier comparisons" if expected.loads is None else f"{expected.loads:.2f} %"
        phrases.append(f"expected error: {percent}")
    return "; ".join(filter(None, [*phrases, reference_uncertainty_text(reference, compared.uncertainty)]))


def model_and_reference_rows(compared: NutOrBearingComparison) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Return headings and rows of the table that compares one model with the reference.

    The model is the default model or, if that was not compared, the first one.

    Parameters
    ----------
    compared
        Comparison of all models with the reference of one nut or bearing.

    Returns
    -------
    tuple[tuple[str, ...], list[tuple[str, ...]]]
        Headings, and the texts of each row, one for each heading.
    """
    model, reference = compared.judged_model, compared.reference_loads
    headings = ("quantity", model.title, reference.name, "unit", "difference", "expected")
    return headings, [*rows_with_reference(records_of_loads(model), records_of_loads(reference), compared.expected)]
