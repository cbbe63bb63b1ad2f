"""Records that `rollbench.compare_models` returns: errors of low-order models against the 3D finite-element reference."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from rollbench.compare.errors import ArgumentError, SceneNotCoveredError
from rollbench.compare.gate.user import references_from_file, stored_reference_of_nut_or_bearing
from rollbench.compare.measure import error_percent
from rollbench.compare.models.comparison import SceneWithReference, models_shown_for_scene, stored_references
from rollbench.compare.models.load_cases import rating_life_over_duty_cycle
from rollbench.compare.models.model import Model
from rollbench.compare.models.model_form import ExpectedError
from rollbench.compare.models.uncertainty import Uncertainty
from rollbench.compare.quantities import json_number, record_as_json
from rollbench.compare.reference.jobs import ComputingSettings, ensure_runs_are_stored, plan_reference_tasks
from rollbench.compare.reference.levels import ADVISED, SOURCE_LEVEL
from rollbench.compare.reference.store import Run, shipped_store
from rollbench.compare.reference.tasks import ReferenceTask, Solvable
from rollbench.compare.results import compared as results_compared
from rollbench.compare.results.base import JSON, TabularRecord, add_schema_version
from rollbench.compare.results.compared import ModelLoads, NutOrBearingComparison
from rollbench.compare.scenes.duty_cycle import Described, DutyCycle, LoadCaseOfDutyCycle, load_cases_by_scene_name
from rollbench.compare.scenes.scene_file import scenes_to_solve
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import SIDES, Scene
from rollbench.meshes.quantity import quantity_field, result_record
from rollbench.reports.content import Figure, Panel, Series

#: Comparisons, by the name of the load case and the name of the nut or bearing.
ByCase = Mapping[tuple[str, str], NutOrBearingComparison]
#: Reference of a nut or bearing, and the comparison of models with it.
Pair: TypeAlias = tuple[SceneWithReference, NutOrBearingComparison]


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Comparison(TabularRecord):
    """Errors of low-order models against a reference.

    With several nuts or bearings on one shaft, `sets` has a comparison for each. With several load cases, `cases` has a
    comparison for each, which may in turn have `sets`. In both cases the fields about contacts are None or empty.

    Examples
    --------
    >>> import rollbench
    >>> comparison = rollbench.compare_models("lin-case1", ["lin"])
    >>> lin = comparison.models["lin"]
    >>> round(lin.largest_error, 1), round(lin.rms_error, 1), lin.ball, lin.side
    (6.2, 2.5, 31, 'SL')
    >>> round(comparison.uncertainty.discretisation, 2), comparison.levels
    (0.08, (1, 2, 3, 4))
    """

    scene: str
    """Name of the scene; for one of several nuts or bearings, also the name of the nut or bearing."""
    warnings: tuple[str, ...] = ()
    """Warnings, such as unknown columns of a file."""
    pair: Pair | None = None
    """Reference, and the comparison of models with it, of a single nut or bearing; None with `sets` or `cases`."""
    sets: Mapping[str, Comparison] = field(default_factory=dict)
    """Comparison of each nut or bearing on a shaft with several, by name; empty for a single nut or bearing."""
    cases: Mapping[str, Comparison] = field(default_factory=dict)
    """Comparison of each load case, by name; empty without load cases."""
    described: Described | None = None
    """The compared scene; None in the records for single load cases (`cases`) and for single nuts or bearings (`sets`)."""

    @property
    def compared(self) -> tuple[Pair, ...]:
        """Reference and comparison of each load case and each nut or bearing."""
        if self.pair is not None:
            return (self.pair,)
        return tuple(pair for one in (*self.cases.values(), *self.sets.values()) for pair in one.compared)

    @property
    def verdict(self) -> str:
        """Sentence on the error of the default model; one line for each nut or bearing and each load case."""
        sentence = results_compared.comparison_verdict_sentence
        return "\n".join(sentence(whole, one.reference) for one, whole in self.compared)

    @property
    def reference(self) -> ModelLoads | None:
        """Contact loads of the reference."""
        return None if self.pair is None else self.pair[1].reference_loads

    @property
    def models(self) -> dict[str, ModelLoads]:
        """Loads and errors of the models, and of the 3D reference on coarser meshes, by name."""
        return {} if self.pair is None else {one.name: one for one in self.pair[1].models}

    @property
    def levels(self) -> tuple[int, ...]:
        """Mesh levels of the 3D reference; empty for a user's reference."""
        return () if self.pair is None else self.pair[0].reference.levels

    @property
    def unsettled(self) -> str:
        """Sentence on loads of the 3D reference that had not converged in its iteration on normals and gaps; else empty."""
        return "" if self.pair is None else self.pair[0].reference.unsettled

    @property
    def uncertainties(self) -> Array | None:
        """Uncertainty of each contact load of the reference, (n, 4) [N]."""
        return None if self.pair is None else self.pair[0].reference.uncertainty

    @property
    def uncertainty(self) -> Uncertainty | None:
        """Uncertainty of the errors in the comparison, by its causes."""
        return None if self.pair is None else self.pair[1].uncertainty

    @property
    def expected_error(self) -> ExpectedError | None:
        """Error of the default model that was expected from comparisons on other scenes."""
        return None if self.pair is None else self.pair[1].expected

    @property
    def errors(self) -> dict[str, float]:
        """Largest error of a contact load of each model [% of the mean contact load], by the model's name."""
        return {name: one.error.max_percent for name, one in self.models.items() if one.error is not None}

    @property
    def seconds(self) -> dict[str, float | None]:
        """Computing time of each model [s], by its name; None if not measured."""
        return {name: one.seconds for name, one in self.models.items()}

    def _parts(self) -> dict[str, Comparison]:
        """Return the comparison of each single nut or bearing, by load case and set; empty if there is only one."""
        parts = {**self.cases, **self.sets}
        return {
            f"{name}, {of}".rstrip(", "): inner
            for name, one in parts.items()
            for of, inner in (one._parts() or {"": one}).items()
        }

    def frame_rows(self) -> Sequence[Mapping[str, Any]]:
        """Return a row for each contact that the reference or a model loads; flanks SL, SR, NL, NR.

        Returns
        -------
        list
            Row of each line of the frame, by the names of its columns.
        """
        if parts := self._parts():
            return [{"of": name, **row} for name, one in parts.items() for row in one.frame_rows()]
        if self.reference is None:
            return []
        loads = {model: one.loads for model, one in self.models.items()}
        touched = np.any([self.reference.loads > 0.0, *(x > 0.0 for x in loads.values())], axis=0)
        return [
            {
                "ball": int(i) + 1,
                "flank": SIDES[j],
                "reference_N": float(self.reference.loads[i, j]),
                "uncertainty_N": None if self.uncertainties is None else float(self.uncertainties[i, j]),
                **{f"{model}_N": float(x[i, j]) for model, x in loads.items()},
                **{
                    f"{model}_error_percent": float(one.errors[i, j])
                    for model, one in self.models.items()
                    if one.errors is not None
                },
            }
            for i, j in np.argwhere(touched)
        ]

    def figure(self) -> Figure | None:
        """Return the figure of the contact loads of models and reference, a panel for each loaded flank of each part.

        Returns
        -------
        reports.content.Figure or None
            The figure, as the report draws it; None if there is nothing to draw.
        """
        panels = [p for name, one in (self._parts() or {"": self}).items() for p in one._panels(name)]
        return Figure("comparison", f"{self.scene}: contact loads of models and reference", panels) if panels else None

    def _panels(self, part: str) -> list[Panel]:
        """Return a panel for each loaded flank of a single nut or bearing; ``part``: its name, before the flank's."""
        if self.reference is None:
            return []
        balls, shown = list(range(1, len(self.reference.loads) + 1)), []
        for j in np.flatnonzero((self.reference.loads > 0.0).any(axis=0)):
            truth = self.reference.loads[:, j]
            half = np.zeros_like(truth) if self.uncertainties is None else self.uncertainties[:, j]
            bars = ((truth - half).tolist(), (truth + half).tolist())
            series = [
                Series(self.reference.name, balls, truth.tolist(), "markers", bold=True, error_bars=bars),
                *(
                    Series(name, balls, one.loads[:, j].tolist(), "line")
                    for name, one in self.models.items()
                    if "3D" not in name
                ),
            ]
            title = ", ".join(filter(None, (part, f"flank {SIDES[j]}")))
            shown.append(Panel(title, "number_of_ball", "contact_load", series, include_zero=True, integer_x=True))
        return shown

    def to_dict(self) -> dict[str, JSON]:
        """Return the models' errors, and the results of models and reference, as a dictionary of JSON values.

        Returns
        -------
        dict
            JSON values by key.
        """
        return add_schema_version(self._json())

    def _json(self) -> dict[str, Any]:
        """Return the JSON values of the comparison, without the version number of their format."""
        results = [
            results_compared.comparison_json(whole, one.reference)
            | {"models": _models_json(whole)}
            | scene_and_set_keys(one)
            for one, whole in self.compared
        ]
        if isinstance(self.described, DutyCycle):
            cases = load_cases_by_scene_name([self.described])
            names = [one.described_scene_name for one, _ in self.compared]
            rows = [row | cases[name].identifying_values for row, name in zip(results, names, strict=True)]
            each = {(one.described_scene_name, one.set_name): whole for one, whole in self.compared}
            summaries = cycle_summaries_json(self.described, each)
            summary = summaries[0] if len(summaries) == 1 else {row["set"]: row for row in summaries}
            return {"scene": self.scene, "summary": summary, "cases": rows}
        return {"scene": self.scene, "sets": results} if self.sets else results[0]

    @property
    def headings(self) -> Sequence[str]:
        """Headings of the columns of `table`."""
        return results_compared.model_and_reference_rows(self.compared[0][1])[0]

    def table(self) -> Sequence[Sequence[str]]:
        """Return the rows of the table that ``rollbench compare`` prints.

        Returns
        -------
        Sequence[Sequence[str]]
            The texts of each row, one for each of `headings`. Rows of several load cases, nuts or bearings follow one
            another.
        """
        return [
            (", ".join(filter(None, (one.reference.scene * (len(self.compared) > 1), name))), *row)
            for one, whole in self.compared
            for name, *row in results_compared.model_and_reference_rows(whole)[1]
        ]

    @property
    def _notes(self) -> tuple[str, ...]:
        """Lines below the table: each warning, then the sentences on the error of the default model (`verdict`)."""
        return (*(f"WARNING: {words}" for words in self.warnings), *self.verdict.splitlines())

    def __repr__(self) -> str:
        """Return the scene's name, then a line for each model (with several load cases, nuts or bearings: for each)."""
        if self.cases or self.sets:
            return "\n".join([self.scene, *self.verdict.splitlines()])
        return "\n".join([f"{self.scene}: {self.verdict}", *map(repr, self.models.values())])


def make_comparison(described: Described, pairs: Sequence[Pair], warnings: Sequence[str]) -> Comparison:
    """Combine the comparisons of a scene's load cases, nuts and bearings into one record.

    Parameters
    ----------
    described
        The scene.
    pairs
        Reference and comparison of each load case and each nut or bearing.
    warnings
        Warnings to the user, such as unknown columns of a reference file.

    Returns
    -------
    Comparison
        The combined record.
    """
    if not isinstance(described, DutyCycle):
        return _comparison_of_scene(described.name, pairs, described, warnings)
    by_case = {case.name: [x for x in pairs if x[0].described_scene_name == case.scene.name] for case in described.cases}
    cases = {name: _comparison_of_scene(name, its) for name, its in by_case.items()}
    return Comparison(scene=described.name, described=described, warnings=tuple(warnings), cases=cases)


def _comparison_of_scene(
    name: str, pairs: Sequence[Pair], described: Described | None = None, warnings: Sequence[str] = ()
) -> Comparison:
    """Combine the comparisons of all nuts and bearings of a scene under one load case into one record.

    ``name``: name of the scene or load case. ``pairs``: reference and comparison of each nut or bearing. ``described``: the
    scene to be kept in the record; None if the record is for one of several load cases.
    """
    whole = Comparison(scene=name, described=described, warnings=tuple(warnings))
    if pairs[0][0].place_on_shaft is None:
        return replace(whole, pair=pairs[0])
    return replace(whole, sets={x[0].set_name: Comparison(scene=x[0].reference.scene, pair=x) for x in pairs})


def _models_json(comparison: NutOrBearingComparison) -> dict[str, Any]:
    """Return errors, largest load and pressure, and displacement of each compared model as JSON, by the model's name."""
    return {
        b.name: {
            "largest_error_percent": b.largest_error,
            "rms_error_percent": b.rms_error,
            "largest_load_N": float(b.loads.max(initial=0.0)),
            "pressure_MPa": 1e-6 * b.pressure,
            "displacement_um": json_number(1e6 * b.displacement),
        }
        for b in comparison.models
    }


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

    def compare_each(self) -> Iterator[Pair]:
        """Yield the comparison of the models with each reference, one nut or bearing after the other.

        Stored runs of the 3D reference are compared with a user's reference, too.

        Yields
        ------
        tuple
            Reference of a nut or bearing, and the comparison with it.

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
                given = (one.scene, models, one.reference, self.stores, one.place_on_shaft, ours)
                yield one, results_compared.compare_models_with_reference(*given)


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
                    given = (one.scene, first, one.reference, stores, one.place_on_shaft)
                    whole = results_compared.compare_models_with_reference(*given)
                    verdict = results_compared.comparison_verdict_sentence(whole, one.reference)
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


def scene_and_set_keys(referenced: SceneWithReference) -> dict[str, str]:
    """Return a JSON object that names the compared nut or bearing: its scene (key "scene") and its name (key "set").

    Parameters
    ----------
    referenced
        Reference of the nut or bearing.

    Returns
    -------
    dict
        Names of the scene and of the nut or bearing; empty if the scene has only one.
    """
    if referenced.place_on_shaft is None:
        return {}
    return {"scene": referenced.described_scene_name, "set": referenced.set_name}


def distinct_duty_cycles(cases: Mapping[str, LoadCaseOfDutyCycle]) -> Iterable[DutyCycle]:
    """Return the duty cycles to which the given load cases belong.

    Parameters
    ----------
    cases
        Load cases, by the names of their scenes.

    Returns
    -------
    Iterable[DutyCycle]
        The duty cycles, each of them once.
    """
    return {case.duty_cycle.name: case.duty_cycle for case in cases.values()}.values()


@result_record
class CycleSummary:
    """Largest error of a model's contact loads, and life, over all load cases of a duty cycle, for one nut or bearing."""

    model: str = quantity_field("model")
    """Name of the model."""
    error: float | None = quantity_field(
        "largest_error_percent",
        "largest measured error of a contact load in any case, in per cent of the mean load of its case",
    )
    case: str | None = quantity_field("largest_error_case", "load case with the largest error")
    lives: dict[str, float | None] = quantity_field(
        "life_million_revolutions",
        "life over the duty cycle by the contact loads of a model, or of the reference",
        parts=".*",
    )
    life_error: float | None = quantity_field(
        "life_error_percent", "error of the model's life against the life from the reference's loads"
    )


def cycle_summaries_json(cycle: DutyCycle, each: ByCase) -> list[dict[str, Any]]:
    """Summarise a comparison of models with the reference over all load cases of a duty cycle.

    Parameters
    ----------
    cycle
        The duty cycle.
    each
        Comparisons, by the name of the load case and the name of the nut or bearing.

    Returns
    -------
    list[dict[str, Any]]
        For each nut or ball bearing: the largest error of the default model, the load case in which it occurs, and the life
        [10^6 revolutions] from the loads of each model and of the reference. The life is None if a load case has no loads.
    """
    return [_cycle_summary_of_set(cycle, name, each) for name, parts in cycle.sets.items() if isinstance(parts, Scene)]


def _cycle_summary_of_set(cycle: DutyCycle, name: str, each: ByCase) -> dict[str, Any]:
    """Return a JSON summary of load errors and lives over all load cases, for the nut or bearing called ``name``.

    The load error stated is the one of the default model or, if that model was not compared, of the first model; the lives
    [10^6 revolutions] are those of all models and of the 3D reference.

    ``each``: comparisons, by the name of the load case and the name of the nut or bearing.
    """
    by_case = [(case, each[case.scene.name, name]) for case in cycle.cases]
    first, judged = by_case[0][1], [(whole.judged_model.error, case.name) for case, whole in by_case]
    error, worst = max(((e.max_percent, case) for e, case in judged if e is not None), default=(None, None))
    lives = {}
    for label in ("3D reference", *(b.name for b in first.models)):
        of_case = [{b.name: b for b in (whole.reference_loads, *whole.models)}.get(label) for _, whole in by_case]
        rated, _ = rating_life_over_duty_cycle(cycle, name, [None if b is None else b.contact_loads.load for b in of_case])
        lives[label] = None if rated is None else json_number(rated.revolutions)
    predicted, reference = lives[first.judged_model.name], lives["3D reference"]
    off = None if predicted is None or reference is None else float(error_percent(predicted, reference))
    summary = CycleSummary(first.judged_model.name, error, worst, lives, off)
    return {"scene": cycle.name, **({"set": name} if name else {}), **record_as_json(summary)}
