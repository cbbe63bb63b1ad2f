"""Computation of comparisons: references of scenes, solutions of models, and their errors."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from rollbench.compare.errors import ArgumentError, SceneNotCoveredError
from rollbench.compare.gate.user import references_from_file, stored_reference_of_nut_or_bearing
from rollbench.compare.measure import error_percent, load_error
from rollbench.compare.models import comparison, model_form
from rollbench.compare.models.answers import motion_of_unloaded_screw, results_of_contact_loads
from rollbench.compare.models.comparison import SceneWithReference, models_shown_for_scene, stored_references
from rollbench.compare.models.model import Model
from rollbench.compare.models.registry import DEFAULT
from rollbench.compare.models.stiffness import place_of_displacement
from rollbench.compare.models.uncertainty import uncertainty_of_loads
from rollbench.compare.reference.estimate import Reference
from rollbench.compare.reference.jobs import ComputingSettings, ensure_runs_are_stored, plan_reference_tasks
from rollbench.compare.reference.levels import ADVISED, SOURCE_LEVEL
from rollbench.compare.reference.store import Run, load_stored_run, shipped_store
from rollbench.compare.reference.tasks import ReferenceTask, Solvable
from rollbench.compare.results.comparison import Comparison, ModelLoads
from rollbench.compare.scenes.duty_cycle import Described, DutyCycle, load_cases_by_scene_name
from rollbench.compare.scenes.scene_file import scenes_to_solve
from rollbench.lowfi.statics.nominal import count_nominal_contacts
from rollbench.meshes.parts import Scene

#: Name of the stored 3D reference in tables that compare models with a user's reference.
OURS = "stored 3D reference"


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


def compare_models_with_reference(
    one: SceneWithReference, models: Sequence[Model], stores: Sequence[Path], stored_reference: Reference | None = None
) -> Comparison:
    """Compare models, and coarser meshes of the 3D reference, with the reference of one nut or bearing.

    Parameters
    ----------
    one
        Nut or bearing with its reference: contact loads of the 3D finite-element model, or of a user's file.
    models
        Models to compare.
    stores
        Folders with runs of the 3D reference.
    stored_reference
        Stored 3D reference that is compared too if the reference comes from a user's file; otherwise None.

    Returns
    -------
    Comparison
        The comparison.

    Raises
    ------
    InputError
        If a model cannot be run; the subclass SceneNotCoveredError if several nuts or bearings on one shaft have no
        equilibrium.
    """
    scene, reference, single = one.scene, one.reference, one.assembly is None
    answers, expected, starts = [], {}, {}
    for model in models:
        solved = comparison.solve_nut_or_bearing(one, model, stores)
        if isinstance(solved, str):
            reason, advice = f"{model.name}: {solved}", "choose another model with --model"
            raise SceneNotCoveredError(reference.scene, "model", reason, advice)
        loaded, unloaded, seconds = solved
        answers.append(comparison.solution_from_result(loaded, seconds))
        starts[model.name] = float(motion_of_unloaded_screw(unloaded, place_of_displacement(scene))[2])
        if loaded.converged:
            measured = measured_errors_on_other_scenes(reference)
            if one.assembly is None:
                expected[model.name] = model_form.estimate_model_error(scene, loaded, measured)
            else:
                whole = comparison.solve_loaded_and_unloaded(one.assembly, model.name)[0]
                expected[model.name] = model_form.estimate_double_nut_error(one.assembly, whole, measured)
    source_mesh_run = load_stored_run(scene, SOURCE_LEVEL, stores=tuple(stores)) if single else None
    others = comparison.solutions_of_reference_runs(reference, source_mesh_run)
    finest = f"3D level {reference.best.level}"  # all errors are computed against its loads
    answers += [answer for answer in others if answer.model != finest]
    answers += [] if stored_reference is None else [comparison.solution_from_run(stored_reference.best, OURS)]
    shared = starts.get(DEFAULT, next(iter(starts.values()), 0.0))  # no run of the reference without loads is stored
    count = None if single else reference.contacts
    best = comparison.solution_from_run(reference.best, reference.label)
    found = Comparison(
        scene=reference.scene,
        of=one,
        reference=compare_loads_with_reference(scene, best, None, shared, count),
        models={
            answer.model: compare_loads_with_reference(scene, answer, reference, starts.get(answer.model, shared), count)
            for answer in answers
        },
        uncertainty=uncertainty_of_loads(scene, reference, inputs=single),
        unloaded_position=shared,
    )
    return replace(found, expected_error=expected.get(found.judged_model.name))


def measured_errors_on_other_scenes(reference: Reference) -> list[model_form.MeasuredModelErrors]:
    """Return the measured errors of models on all scenes but one, from which the errors to expect on this one follow.

    ``reference``: 3D reference of the scene that is left out.
    """
    own = {reference.scene, *(run.scene for run in reference.runs)}
    points = model_form.model_errors_on_compared_scenes()
    return [point for point in points if not {point.scene, point.described_scene} & own]


def make_comparison(described: Described, parts: Sequence[Comparison], warnings: Sequence[str] = ()) -> Comparison:
    """Combine the comparisons of a scene's load cases, nuts and bearings into one record.

    Parameters
    ----------
    described
        The scene.
    parts
        Comparison of each load case and each nut or bearing; those of other scenes are left out.
    warnings
        Warnings to the user, such as unknown columns of a reference file.

    Returns
    -------
    Comparison
        The combined record.
    """

    def of_scene(name: str, scene_name: str) -> Comparison:
        """Return the comparison called ``name`` of the scene with one load case that is called ``scene_name``."""
        its = {x.of.set_name: x for x in parts if x.of is not None and x.of.described_scene.name == scene_name}
        return replace(its[""], scene=name) if "" in its else Comparison(scene=name, sets=its)

    if not isinstance(described, DutyCycle):
        return replace(of_scene(described.name, described.name), described=described, warnings=tuple(warnings))
    cases = {case.name: of_scene(case.name, case.scene.name) for case in described.cases}
    return Comparison(scene=described.name, described=described, warnings=tuple(warnings), cases=cases)


@dataclass(frozen=True)
class ComparisonInput:
    """Input of a comparison: scenes, their references and the models to compare; its method computes the comparisons."""

    scenes: Sequence[Solvable]
    """Scenes with one load case each."""
    references: Sequence[Sequence[SceneWithReference]]
    """References of each of `scenes`, one for each nut or bearing."""
    models: Sequence[Model]
    """Models to compare; if empty, all models that suit each scene."""
    stores: Sequence[Path]
    """Folders with runs of the 3D reference."""
    failed_runs: Sequence[Run]
    """Runs of the 3D reference that did not converge."""
    warnings: Sequence[str]
    """Warnings from reading a reference file."""
    from_user_file: bool
    """Whether the references come from a file of the user, not from the 3D reference."""

    def compare_each(self) -> Iterator[Comparison]:
        """Yield the comparison of the models with each reference, one nut or bearing after the other.

        Stored runs of the 3D reference are compared with a user's reference, too.

        Yields
        ------
        Comparison
            Comparison with the reference of a nut or bearing.

        Raises
        ------
        SceneNotCoveredError
            If a scene has no reference.
        """
        for scene, sets in zip(self.scenes, self.references, strict=True):
            if not sets:
                raise error_for_unconverged_reference(scene.name, self.failed_runs)
            models = self.models or models_shown_for_scene(scene)
            for one in sets:
                ours = stored_reference_of_nut_or_bearing(one, self.stores) if self.from_user_file else None
                yield compare_models_with_reference(one, models, self.stores, ours)


def prepare_comparison(
    described: Sequence[Described],
    origins: Sequence[str],
    models: Sequence[Model],
    engine: ComputingSettings,
    step: Callable[[str], None],
    *,
    store: Path,
    levels: Sequence[int] | None = None,
    otherwise: Sequence[int] = ADVISED,
    fresh: bool = False,
    reference: Path | None = None,
) -> ComparisonInput:
    """Look up the references of scenes and their load cases, and compute missing runs of the 3D reference.

    Parameters
    ----------
    described
        The scenes.
    origins
        File or name of each scene, for error messages.
    models
        Models to compare; if empty, all models that suit each scene.
    engine
        Settings that determine where runs of the 3D reference are computed.
    step
        Function that is called with each line of progress, such as the errors against the coarsest mesh level while finer
        levels are computed.
    store
        Folder in which runs are looked up and stored, in addition to the runs shipped with rollbench.
    levels
        Mesh levels to compute unless they are stored; None: use the best stored run.
    otherwise
        Mesh levels to compute if ``levels`` is None and no run is stored.
    fresh
        Whether stored runs are computed again.
    reference
        File with contact loads that replace the 3D reference.

    Returns
    -------
    ComparisonInput
        Scenes and references; the method `compare_each` of this record computes the comparisons.

    Raises
    ------
    rollbench.InputError
        If a scene or file cannot be used.
    """
    scenes: list[Solvable] = [x for one, name in zip(described, origins, strict=True) for x in scenes_to_solve(one, name)]
    stores, warnings = (store, shipped_store()), list[str]()
    if reference is not None:
        names = {name: case.load_case.name for name, case in load_cases_by_scene_name(described).items()}
        given = read_user_references(scenes, reference, names, warnings)
        return ComparisonInput(scenes, given, models, stores, (), warnings, from_user_file=True)
    without = [s for s in scenes if not stored_references(s, stores)] if levels is None and not fresh else scenes
    failed: list[Run] = []
    if without:
        wanted = levels or otherwise

        def report_errors_on_coarsest_level(task: ReferenceTask) -> None:
            """Report a model's load errors against the coarsest mesh of the 3D reference, once ``task`` has computed it."""
            for scene in task.scenes if task.level == min(set(wanted) - {SOURCE_LEVEL}) else ():
                first = (models or models_shown_for_scene(scene))[:1]
                for one in stored_references(scene, (store,), (task.level,)):
                    verdict = compare_models_with_reference(one, first, stores).verdict
                    step(f"{one.reference.scene}, against mesh level {task.level} only: {verdict}")

        levels_to_compute, with_source_mesh = [k for k in wanted if k != SOURCE_LEVEL], SOURCE_LEVEL in wanted
        tasks = plan_reference_tasks(without, levels_to_compute, with_source_mesh=with_source_mesh)
        report = report_errors_on_coarsest_level
        failed = ensure_runs_are_stored(
            tasks, store, engine, step, stores, compute_again=fresh, after_each_stored_task=report
        )
    references = [stored_references(scene, stores) for scene in scenes]
    return ComparisonInput(scenes, references, models, stores, failed, warnings, from_user_file=False)


def error_for_unconverged_reference(name: str, failed: Sequence[Run]) -> SceneNotCoveredError:
    """Return the error to raise for a scene of which no run of the 3D reference converged.

    Parameters
    ----------
    name
        Name of the scene.
    failed
        Runs that did not converge.

    Returns
    -------
    SceneNotCoveredError
        Error that names the status of each run of the scene.
    """
    why = [f"level {run.level}: {run.status}" for run in failed if run.scene == name]
    reason = f"no run of the 3D reference converged ({'; '.join(why)})" if why else "no converged run of the 3D reference"
    advice = "correct the scene as the status of the runs suggests, or solve it with a low-order model"
    return SceneNotCoveredError(name, "3D reference", reason, advice)


def read_user_references(
    scenes: Sequence[Solvable], path: Path, cases: Mapping[str, str], warnings: list[str]
) -> list[list[SceneWithReference]]:
    """Read a user's file with reference loads of one scene or of its load cases.

    Parameters
    ----------
    scenes
        One scene, or the scenes of its load cases.
    path
        File with contact loads.
    cases
        Name of the load case, by the name of its scene.
    warnings
        List to which warnings are added.

    Returns
    -------
    list[list[SceneWithReference]]
        References of each load case, one for each nut or bearing.

    Raises
    ------
    rollbench.InputError
        If the scenes are not load cases of one scene, or the file cannot be used.
    """
    if len(scenes) != 1 and len(cases) != len(scenes):
        advice = "compare the scenes one by one, each with its own file"
        raise ArgumentError("reference", f"{path} for {len(scenes)} scenes", "a file for one scene", advice)
    warned: dict[str, None] = {}
    references = [references_from_file(path, scene, warned.setdefault, case=cases.get(scene.name)) for scene in scenes]
    warnings += warned
    return references
