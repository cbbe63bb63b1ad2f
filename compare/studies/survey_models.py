"""Errors of models, also of users' models, on randomly drawn ball screws (`survey`), against stored 3D contact loads.

The contact loads of the survey's runs are stored next to its record (`store_reference_loads`), each with a digest of its
screw. If the digest differs from that of the screw that is drawn now, the model is not judged on this screw.

The stored loads are those of mesh level 1, which has errors of its own. On `COUNT` of the screws, chosen by a seed, all
models and mesh levels 1 and 2 are timed; level 2 judges the others, and on some of them level 3 judges level 2. Measured
are processor times of one process with one thread: for a new screw from the set-up to the contact loads, and for a further
load case.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache, partial
from pathlib import Path
from statistics import median
from time import perf_counter, process_time
from typing import Any, NamedTuple

import numpy as np

from rollbench.compare.errors import ArgumentError, InputError, one_line
from rollbench.compare.files import read_from_first_valid_folder, replace_file, shipped_path
from rollbench.compare.gate.user import loads_as_run_record
from rollbench.compare.gate.verdict import LIMIT, ErrorLimits, judge_contact_loads
from rollbench.compare.measure import error_percent, load_error
from rollbench.compare.models.loads_file import load_rows_for_csv
from rollbench.compare.models.many import solve_many, stored_in
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.programs import model_title
from rollbench.compare.models.registry import MODELS, model_by_name, run_model
from rollbench.compare.models.user_models import origin_of_model
from rollbench.compare.reference.computing import compute_reference_runs
from rollbench.compare.reference.estimate import Reference, largest_uncertainty_percent, reference_from_runs
from rollbench.compare.reference.jobs import ComputingSettings
from rollbench.compare.reference.store import SCHEMA, SETS, MeasuringConditions, measuring_conditions
from rollbench.compare.reference.tasks import ReferenceTask, Solvable
from rollbench.compare.results.base import JSON, TabularRecord, add_schema_version
from rollbench.compare.running import usable_cores
from rollbench.compare.scenes import scene_file
from rollbench.compare.studies import survey
from rollbench.compare.studies.run_times import measuring_conditions_from_json, save_times, utc_date_today
from rollbench.lowfi.statics.nominal import count_nominal_contacts
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.cache import forget_kept_results
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Scene
from rollbench.meshes.processes import limit_to_one_thread
from rollbench.meshes.record_keys import digest_of_values, static_part
from rollbench.reports.content import Figure, Panel, Series

#: Errors that are summarised, by their names in the survey's record, with descriptions; errors of loads are in % of the
#: mean load.
ERRORS = {"largest_percent": "worst load", "rms_percent": "loads, RMS", "pressure_percent": "largest pressure"}
#: Number of screws that are tried first; a model that fails on each of them is not tried on the others.
FIRST = 5
#: Largest number of worst screws that are listed.
WORST = 5
#: Options by which models solve a screw.
OPTIONS = ModelOptions(estimate_beam_mesh_error=False)
#: Words with which the status of a screw begins that a model refuses, or on which it fails.
REFUSED = "refused: "

Row = dict[str, Any]


@dataclass(frozen=True, kw_only=True)
class SurveyRow:
    """Errors of a model on one randomly drawn ball screw, against the 3D reference; None for what is not known of it.

    The stored results of rollbench's models have displacements and errors to expect, too.
    """

    #: Number of the screw.
    screw: int
    #: Description of the screw.
    title: str
    #: "converged", or the reason why the screw was not solved or is not judged.
    status: str
    #: Number of balls.
    balls: int | None = None
    #: Error of the worst contact load [% of the mean load].
    largest_percent: float | None = None
    #: Ball and flank of the worst contact load.
    at: str | None = None
    #: RMS error of the contact loads [% of the mean load].
    rms_percent: float | None = None
    #: Error of the largest pressure [%].
    pressure_percent: float | None = None
    #: Largest mesh uncertainty of the reference's loads [% of the mean load].
    uncertainty_percent: float | None = None
    #: Error of the contact that decides the verdict, as ``rollbench check`` judges it [%].
    gate_percent: float | None = None
    #: Verdict on the loads.
    verdict: str | None = None
    #: Error of the displacement [%].
    displacement_percent: float | None = None
    #: Error of the rigidity [%].
    rigidity_percent: float | None = None
    #: Error to expect of the worst contact load [% of the mean load].
    expected_percent: float | None = None
    #: RMS error to expect of the contact loads [% of the mean load].
    rms_expected_percent: float | None = None
    #: Error to expect of the displacement [%].
    displacement_expected_percent: float | None = None
    #: Error to expect of the rigidity [%].
    rigidity_expected_percent: float | None = None
    #: Error to expect of the largest pressure [%].
    pressure_expected_percent: float | None = None
    #: Why no error is expected; empty if one is.
    not_covered: str | None = None
    #: Computing time of the solution [s].
    seconds: float | None = None
    #: Processor time of a further load case [s].
    further_seconds: float | None = None

    @property
    def solved(self) -> bool:
        """Whether the model solved the screw and is judged."""
        return self.status == survey.ANSWERED

    def as_json(self) -> dict[str, Any]:
        """Return the values that are known, for JSON.

        Returns
        -------
        dict
            Values by key; the keys end with the unit.
        """
        return {key: value for key, value in asdict(self).items() if value is not None}


def random_screw_scene(number: int) -> Scene:
    """Return the ball screw number ``number`` of the survey, which draws screws at random, as a scene."""
    return scene_file.scene_from_text(survey.random_screw_scene_text(survey.SEED, number), f"{screw_name(number)}.toml")


def screw_name(number: int) -> str:
    """Return the name of the randomly drawn screw number ``number``, with which the names of its files begin."""
    return f"survey-{survey.SEED}-{number}"


def store_reference_loads(path: Path, run_folder: Path, count: int, kind: str = "ball screw") -> int:
    """Write the contact loads by the 3D reference on the first ``count`` random screws to a file.

    ``path``: the file; ``run_folder``: folder with stored solutions of the 3D reference; ``kind``: kind of the screws, a
    key of `survey.KINDS`. For screws without a solution
    there, the loads that the file already has are kept. Returns the number of screws in the file. Raises InputError if the
    file cannot be written.
    """
    before = _read_reference_loads(path)
    for number in range(survey.KINDS[kind].first, survey.KINDS[kind].first + count):
        scene, _ = survey.KINDS[kind].scenes_under_given_and_raised_loads(survey.SEED, number)
        run = survey.stored_run(run_folder, scene)
        if run is not None:
            load = [[float(f"{x:.6g}") for x in row] for row in run.load]
            before[number] = {"number": number, "of": _scene_digest(scene), "moving": run.moving, "load": load}
    rows = ",\n".join(json.dumps(before[number], separators=(",", ":")) for number in sorted(before))
    head = json.dumps({"seed": survey.SEED, "level": survey.LEVEL})
    replace_file(path, f'{head[:-1]}, "screws": [\n{rows}\n]}}\n')
    return len(before)


def _scene_digest(scene: Solvable) -> str:
    """Return a digest (hash value, 16 hexadecimal digits) of a scene's content and of the version of the 3D reference."""
    versions = (SCHEMA, SETS) if isinstance(scene, Assembly) else (SCHEMA,)
    return digest_of_values(*versions, static_part(scene))[:16]


def _read_reference_loads(path: Path) -> dict[int, Row]:
    """Read the contact loads of randomly drawn screws from a file, and return them by the number of the screw.

    The result is empty if the file is missing, or was written for another seed or mesh level.
    """
    if not path.exists():
        return {}
    found = json.loads(path.read_text(encoding="utf-8"))
    same = (found["seed"], found["level"]) == (survey.SEED, survey.LEVEL)
    return {row["number"]: row for row in found["screws"]} if same else {}


@cache
def stored_loads() -> dict[int, Row]:
    """Return the contact loads by the 3D reference on random screws, stored in the package, by number of the screw."""
    first, new = (shipped_path(f"references/{survey.KINDS[kind].loads}") for kind in ("ball screw", "new screw"))
    return _read_reference_loads(first) | _read_reference_loads(new)


def reference_from_stored_loads(scene: Scene, number: int) -> Reference | None:
    """Return the 3D reference of a randomly drawn screw from its stored contact loads; None without stored loads.

    ``scene``: the screw; ``number``: number of the screw. The uncertainty of the reference is the mesh uncertainty of the
    same mesh level on other scenes.
    """
    row = stored_loads().get(number)
    if row is None or row["of"] != _scene_digest(scene):
        return None
    load = np.array(row["load"])
    run = replace(loads_as_run_record(scene, load, np.full(load.shape, np.nan)), level=survey.LEVEL, moving=row["moving"])
    return reference_from_runs(scene.name, scene, (run,), contacts=count_nominal_contacts(scene))


def judge_model_on_random_screw(model: str, number: int, limit: float = LIMIT) -> SurveyRow:
    """Solve a randomly drawn screw with a model, and compare the contact loads with the stored 3D reference.

    Parameters
    ----------
    model
        Name of the model.
    number
        Number of the screw.
    limit
        Largest allowed error of a contact load [% of the mean load].

    Returns
    -------
    SurveyRow
        Errors in per cent and whether they are within the limit, or the reason why the model is not judged.
    """
    scene = random_screw_scene(number)
    row = partial(SurveyRow, screw=number, title=scene.title.partition(": ")[2], balls=scene.ball_count)
    found = reference_from_stored_loads(scene, number)
    if found is None:
        return row(status="no stored reference")
    if not model_by_name(model).covers_scene(scene):
        return row(status="the model does not describe it")
    start = perf_counter()
    try:
        result = run_model(scene, model, OPTIONS)
    except InputError as fault:
        return row(status=f"{REFUSED}{one_line(str(fault), 300)}")
    seconds = perf_counter() - start
    if not result.converged:
        return row(status=str(result.status), seconds=seconds)
    verdict = judge_contact_loads(model_title(model), result.load, found, ErrorLimits(limit))[0]
    off = load_error(result.load, found.load, found.contacts)
    pressed = np.cbrt(result.load.max() / found.load.max())  # Hertz
    return row(
        status=survey.ANSWERED,
        largest_percent=off.max_percent,
        at=f"{off.ball} {off.side}",
        rms_percent=off.rms_percent,
        pressure_percent=float(error_percent(pressed, 1.0)),
        uncertainty_percent=largest_uncertainty_percent(found),
        gate_percent=verdict.error,
        verdict=str(verdict.judgement),
        seconds=seconds,
    )


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Survey(TabularRecord):
    """Errors of models against stored runs of the 3D reference, on randomly drawn ball screws of catalogue dimensions.

    The error of a model on one screw is that of its worst contact load [% of the mean contact load].
    """

    screws: int
    """Number of randomly drawn screws for which a run of the 3D reference is stored."""
    of: int
    """Number of randomly drawn screws that were asked for."""
    max_error: float
    """Largest error that passes [% of the mean contact load]."""
    judged: tuple[str, ...]
    """Names of the models that were solved; results of the others are stored ones."""
    rows: Mapping[str, Sequence[SurveyRow]]
    """Results of a model for every screw, by the model's name."""

    @property
    def median(self) -> dict[str, float]:
        """Median of a model's errors on the screws that it solved [%], by the model's name."""
        return {name: median(sizes) for name, sizes in self._errors().items()}

    @property
    def largest(self) -> dict[str, float]:
        """Largest of a model's errors on the screws that it solved [%], by the model's name."""
        return {name: max(sizes) for name, sizes in self._errors().items()}

    def _errors(self) -> dict[str, list[float]]:
        """Return the errors on the solved screws [%], by the name of each model that solved one."""
        return {name: sizes for name, rows in self.rows.items() if (sizes := errors_of_rows(rows, "largest_percent"))}

    @property
    def summary(self) -> list[Row]:
        """Rows with median, 95th percentile and maximum of each kind of error of each model, see `ERRORS`."""
        return [line for name, of in self.rows.items() for line in error_summary_rows_of_model(name, of)]

    @property
    def verdicts(self) -> dict[str, dict[str, int]]:
        """Number of screws with each verdict, by the name of the judged model."""
        return {name: dict(Counter(r.verdict for r in self.rows[name] if r.verdict)) for name in self.judged}

    @property
    def without_answer(self) -> dict[str, int]:
        """Number of screws without result, by the name of the judged model."""
        return {name: sum(not r.solved for r in self.rows[name]) for name in self.judged}

    def to_dict(self) -> dict[str, JSON]:
        """Return the survey as a dictionary, as ``rollbench survey --json`` prints it.

        Returns
        -------
        dict
            JSON values by key: summary of the errors, numbers of screws within and beyond the limit, and all rows.
        """
        data: dict[str, Any] = {"seed": survey.SEED, "level": survey.LEVEL, "screws": self.screws, "of": self.of}
        data |= {"max_error_percent": self.max_error, "summary": self.summary, "verdicts": self.verdicts}
        models = {name: [row.as_json() for row in rows] for name, rows in self.rows.items()}
        return add_schema_version(data | {"without_answer": self.without_answer, "models": models})

    def frame_rows(self) -> Sequence[Mapping[str, Any]]:
        """Return a row for each model and screw.

        Returns
        -------
        list
            Row of each line of the frame, by the names of its columns.
        """
        return [{"model": model_title(name)} | row.as_json() for name, rows in self.rows.items() for row in rows]

    def figure(self) -> Figure | None:
        """Return the figure of the errors of all models on the screws; None if no judged model solved a screw.

        Returns
        -------
        reports.content.Figure or None
            The figure, as the report draws it; None if there is nothing to draw.
        """
        return figure_of_errors_on_random_screws(self.rows) if self.judged[0] in self._errors() else None

    @property
    def shown_rows(self) -> Sequence[Mapping[str, Any]]:
        """Rows of the table that notebooks show: those of `summary`."""
        return self.summary

    @property
    def _notes(self) -> tuple[str, ...]:
        """Sentence below the table: how many screws have a reference."""
        return (f"{self.screws} of {self.of} random screws have a stored reference, on level {survey.LEVEL}",)


def compare_models_on_random_screws(
    models: Sequence[str],
    count: int,
    workers: int | None,
    limit: float,
    show_progress: Callable[[str], None],
    store: str | Path | None = None,
) -> Survey:
    """Compare models with the 3D reference on the first ``count`` random screws.

    For the models lin and refined, unless they are among ``models``, the errors stored in the package are added.

    Parameters
    ----------
    models
        Names of the models.
    count
        Number of screws.
    workers
        Number of parallel processes.
    limit
        Largest allowed error of a contact load [% of the mean load].
    show_progress
        Function that is called with each line of progress.
    store
        Folder in which solved screws are looked up and stored, see `solve_many`; None: none.

    Returns
    -------
    Survey
        Errors of each model on each screw.

    Raises
    ------
    InputError
        If a model or number is not valid, a model fails on each of the screws that are tried first, or the folder cannot be
        used.
    """
    if not 1 <= count <= survey.DRAWN:
        allowed = f"1 to {survey.DRAWN} randomly drawn screws"
        raise ArgumentError("count", str(count), allowed, "choose a number in that range")
    if not 0.0 < limit < float("inf"):
        advice = "give the largest allowed error of a contact load in per cent of the mean load, such as 7"
        raise ArgumentError("max_error", f"{limit:g}", "above 0 %", advice)
    models = tuple(dict.fromkeys(models))
    for name in models:
        model_by_name(name, excluded_names=("condensed",))
    numbers = [number for number in range(count) if number in stored_loads()]
    origins = [(name, "" if name in MODELS else origin_of_model(name)) for name in models]
    stored, engine = stored_in(store, "survey", "", origins, limit, survey.SEED), ComputingSettings(parallel_jobs=workers)
    pairs = [(name, number) for name in models for number in numbers]
    first = [k for k, (_, number) in enumerate(pairs) if number in numbers[:FIRST]]
    rows, begin, pulse = dict[int, SurveyRow](), perf_counter(), 0
    for some, of in ((first, None), ([k for k in range(len(pairs)) if k not in first], engine)):
        for name in models if rows else ():
            if all(row.status.startswith(REFUSED) for k, row in rows.items() if pairs[k][0] == name):
                run_model(random_screw_scene(numbers[0]), name, OPTIONS)  # raises the error
        asked = {k: (*pairs[k], limit) for k in some}
        for k, row in solve_many(judge_model_on_random_screw, asked, of, stored=stored):
            rows[k] = row
            if len(rows) == len(pairs) or perf_counter() - begin > 10.0 * (pulse + 1):
                pulse = int((perf_counter() - begin) / 10.0)
                show_progress(f"[{len(rows)}/{len(pairs)}] {model_title(pairs[k][0])}: {perf_counter() - begin:.0f} s")
    judged = {name: [rows[k] for k, pair in enumerate(pairs) if pair[0] == name] for name in models}
    ours = [r for r in survey.records_of_all_screws() if r["number"] in numbers]
    record = {
        name: [
            SurveyRow(screw=r["number"], title=r["title"].partition(": ")[2], **r["models"][name])
            for r in ours
            if name in r.get("models", {})
        ]
        for name in survey.MODELS
        if name not in models
    }
    return Survey(screws=len(numbers), of=count, max_error=limit, judged=models, rows=judged | record)


def errors_of_rows(rows: Sequence[SurveyRow], error: str) -> list[float]:
    """Return one kind of error, a key of `ERRORS`, of all solved screws for which it is known [%], as magnitudes."""
    known = (getattr(row, error) for row in rows if row.solved)
    return [abs(value) for value in known if value is not None]


def error_summary_rows_of_model(model: str, rows: Sequence[SurveyRow]) -> list[Row]:
    """Return a table row for each kind of error of a model: median, 95th percentile and maximum over the solved screws.

    ``model``: name of the model; ``rows``: rows of `judge_model_on_random_screw` for this model.
    """
    known = ((words, errors_of_rows(rows, error)) for error, words in ERRORS.items())
    return [
        {"model": model_title(model), "error": words, "screws": len(sizes), **survey.median_p95_and_largest(sizes)}
        for words, sizes in known
        if sizes
    ]


#: Kinds of screws for which errors are summarised: name of the kind, and function that returns whether a record is of it.
WHERE: dict[str, Callable[[Mapping[str, Any]], bool]] = {
    "preload: none": lambda r: r["title"].endswith((", none", ", none, flange")),
    "preload: oversize, force": lambda r: ", oversize" in r["title"] or ", force" in r["title"],
    "preload: lead offset": lambda r: ", lead offset" in r["title"],
    "clearance": lambda r: ", clearance" in r["title"],
    "moment or radial load": lambda r: r["moment_Nm"] > 0.0 or r["radial_N"] > 0.0,
    "offset or tilted support": lambda r: r["offset_um"] > 0.0 or r["tilt_mrad"] > 0.0,
    "axial load alone": lambda r: not any(r[k] for k in ("moment_Nm", "radial_N", "offset_um", "tilt_mrad")),
}


def median_errors_by_screw_kind(models: Mapping[str, Sequence[SurveyRow]]) -> list[Row]:
    """Return a table row for each kind of random screw (such as with clearance) with the median error of each model.

    The error is the largest one of a contact load on a screw, in per cent of the mean load. ``models``: rows of
    `judge_model_on_random_screw` by the name of the model.
    """
    known = {r["number"]: r for r in survey.records_of_all_screws()}
    out = []
    for words, fits in WHERE.items():
        chosen = {number for number, r in known.items() if "moment_Nm" in r and fits(r)}
        sizes = {
            model_title(name): errors_of_rows([r for r in rows if r.screw in chosen], "largest_percent")
            for name, rows in models.items()
        }
        counts = [len(x) for x in sizes.values()]
        if any(counts):
            out.append({"screws": words, "number": max(counts)} | {k: float(np.median(x)) for k, x in sizes.items() if x})
    return out


def figure_of_errors_on_random_screws(rows_by_model: Mapping[str, Sequence[SurveyRow]]) -> Figure:
    """Return a figure of the errors of models on randomly drawn screws.

    One panel shows the fraction of screws whose error is below a value, the other the error on every screw; screws are
    sorted by the error of the first model. ``rows_by_model``: results of each model, as the field ``rows`` of `Survey`.
    """
    models = {
        model_title(name): {
            r.screw: (r.largest_percent, r.title) for r in rows if r.solved and r.largest_percent is not None
        }
        for name, rows in rows_by_model.items()
    }
    lines, points = [], []
    main = next(iter(models))
    order = sorted(models[main], key=lambda screw: models[main][screw])
    for title, found in models.items():
        if not found:
            continue
        sizes = np.sort([error for error, _ in found.values()])
        share = 100.0 * np.arange(1, sizes.size + 1) / sizes.size
        lines.append(Series(title, sizes.tolist(), share.tolist(), "line", bold=title == main))
        places = [(k, screw) for k, screw in enumerate(order, 1) if screw in found]
        names = [f"screw {screw}, {found[screw][1]}" for _, screw in places]
        errors = [found[screw][0] for _, screw in places]
        points.append(Series(title, [k for k, _ in places], errors, "markers", bold=title == main, point_names=names))
    label = "largest error of a contact load / % of the mean load"
    title = "share of screws whose largest error is below a value"
    panels = (
        Panel(title, label, "share of the screws / %", lines, log_axes="x", include_zero=True),
        Panel("largest error on each screw", f"screws, sorted by the error of {main}", label, points, log_axes="y"),
    )
    title = f"Errors of the model {main} on {len(models[main])} randomly drawn ball screws"
    caption = f"Errors against mesh level {survey.LEVEL} of the 3D reference; errors of refined and lin are stored ones."
    return Figure("survey", title, panels, caption, columns=1, size=(4.0, 6.4))


def write_scene_and_reference_files(number: int, folder: Path) -> tuple[Path, Path]:
    """Write a random screw as a scene file, and its 3D contact loads as a reference file for ``rollbench check``.

    ``number``: number of the screw; ``folder``: folder of the files. Returns the path of the scene file, then the path of
    the reference file, which ``rollbench compare`` also reads. Raises InputError for a screw without stored loads, and if a
    file cannot be written.
    """
    scene = random_screw_scene(number) if 0 <= number < survey.DRAWN else None
    found = None if scene is None else reference_from_stored_loads(scene, number)
    if scene is None or found is None:
        allowed = f"the number, 0 to {survey.DRAWN - 1}, of a randomly drawn screw whose 3D reference is stored"
        raise ArgumentError("screw", str(number), allowed, "choose another number")
    text, loads = folder / f"{screw_name(number)}.toml", folder / f"{screw_name(number)}-reference.csv"
    layout = ball_layout(scene)
    rows = load_rows_for_csv(found.load, layout.azimuth, layout.z)
    bars = [f"{x:.6g}" for x in found.uncertainty.ravel()]
    lines = [",".join((*row.values(), bar)) for row, bar in zip(rows, bars, strict=True)]
    head = f"# provenance: level {survey.LEVEL} of the 3D reference, screw {number} of the survey"
    replace_file(text, survey.random_screw_scene_text(survey.SEED, number))
    replace_file(loads, "\n".join([head, ",".join((*rows[0], "uncertainty_N")), *lines]) + "\n")
    return text, loads


#: Mesh levels of the 3D reference that are timed, by their names; the level that judges models and level 1.
LEVELS, JUDGE = {"3D level 1": 1, "3D level 2": 2, "3D level 3": 3}, "3D level 2"
#: Mesh level that judges another one.
JUDGE_OF_LEVEL = {"3D level 2": "3D level 3", "3D level 3": ""}
#: Number of screws on which models and mesh levels are timed, and on the first of which the finest level is, too.
COUNT, FINEST_COUNT = 24, 8
#: Number of screws, the first ones, from which these are chosen; names of timed models and levels.
CHOSEN_FROM, TIMED = 240, ("mei", "mei-nut", "source", "lin", "lin-cell", "lin-nut", "refined", *LEVELS)
#: How the line of progress of a solved load case begins.
SOLVED = "contact loads"
#: Name of the file with the timed solutions.
RUNS = "survey-times.json"


@dataclass(frozen=True)
class TimedRun:
    """Solution of a randomly drawn screw by a model, or by the 3D reference on one mesh level, with its processor times."""

    #: Number of the screw.
    number: int
    #: Name of the model or mesh level, one of `TIMED`.
    name: str
    #: Status of the solution, "converged" if there is one.
    status: str
    #: Processor time of a new screw: preparation of its geometry and one load case [s].
    seconds: float
    #: Processor time of a further load case [s].
    further_seconds: float
    #: Contact loads of the n balls on the four flanks (screw left, screw right, nut left, nut right), (n, 4) [N].
    load: list[list[float]]


class StoredTimedRuns(NamedTuple):
    """Timed solutions of random screws, with version and machine of the measurement."""

    #: Program version, digest of the program's source files, and machine of the measurement.
    measuring_conditions: MeasuringConditions
    #: Timed solutions, one for each screw and each model or mesh level.
    runs: Sequence[TimedRun]


@dataclass(frozen=True)
class LoadErrorsAndTimes:
    """Largest load errors and processor times of a model or mesh level, in arrays with one entry per random screw."""

    #: Name of the model or mesh level.
    name: str
    #: Mesh level that judges it; empty for the finest level.
    judge: str
    #: Largest contact-load error on each screw [% of the contact's load; of the mean load for a nearly
    #: unloaded contact]; an empty array for the finest level.
    gate_errors: Array
    #: Largest contact-load error on each screw [% of the mean load]; an empty array for the finest level.
    errors_of_mean_load: Array
    #: Processor time of each screw from its geometry to the contact loads of a first load case [s].
    first_case_seconds: Array
    #: Processor time of a further load case of each screw [s].
    further_case_seconds: Array


def numbers_of_timed_screws() -> list[int]:
    """Return the numbers of the random screws on which models and mesh levels are timed, in the order of their solution."""
    chosen = np.random.default_rng([survey.SEED, COUNT]).choice(CHOSEN_FROM, COUNT, replace=False)
    return [int(number) for number in chosen]


def load_cases_of_random_screw(number: int) -> tuple[Scene, Scene]:
    """Return the random screw number ``number`` under its drawn loads, then under these loads times 1.05.

    The axial tangent rigidity follows from the solutions under both loads.
    """
    scene, raised = survey.KINDS["ball screw"].scenes_under_given_and_raised_loads(survey.SEED, number)
    assert isinstance(scene, Scene)
    assert isinstance(raised, Scene)
    return scene, raised


def solve_and_time(number: int, name: str) -> TimedRun:
    """Solve a randomly drawn screw by a model or by the 3D reference on a mesh level, and measure the processor times.

    The screw is solved in this process with one thread. Meshes are not taken from a cache, and results of earlier
    solutions in this process are forgotten, so that a time has all work on the geometry, but no imports.

    ``number``: number of the screw; ``name``: name of the model or mesh level. Raises InputError if the screw cannot be
    meshed.
    """
    limit_to_one_thread()
    cases = load_cases_of_random_screw(number)
    times: list[float] = []
    if name in LEVELS:

        def note_processor_time_of_load_case(text: str) -> None:
            """Note the processor time when a line of progress says that a load case is solved."""
            if text.startswith(SOLVED):
                times.append(process_time())

        # on level 1 the cells at the cut ends of the shaft are coarser, as in the survey
        cells = survey.CUT_CELLS if LEVELS[name] == survey.LEVEL else 1.0
        task, begin = ReferenceTask(cases, LEVELS[name], cut_end_cell_ratio=cells), process_time()
        run, _ = compute_reference_runs(task, note_processor_time_of_load_case)
        load, status, first, last = run.load, run.status, times[-2], times[-1]
    else:
        options = ModelOptions(estimate_beam_mesh_error=False)
        run_model(cases[0], name, options)  # imports
        forget_kept_results("rollbench.lowfi")
        begin = process_time()
        result = run_model(cases[0], name, options)
        first = process_time()
        run_model(cases[1], name, options)
        load, status, last = result.load, result.status, process_time()
    rows = [[float(f"{x:.6g}") for x in row] for row in load]
    return TimedRun(number, name, str(status), round(first - begin, 4), round(last - first, 4), rows)


def time_models_and_levels_on_screws(
    store: Path, show_progress: Callable[[str], None], count: int = COUNT
) -> StoredTimedRuns:
    """Solve the first ``count`` chosen random screws by all `TIMED` models and levels and time them, on all cores.

    The finest level solves the first `FINEST_COUNT` of them.

    ``store``: folder in which each solution is stored when it is done. Stored solutions of the same program sources on the
    same machine are not repeated. ``show_progress``: function that is called with each line of progress. Raises InputError
    if the file cannot be written.
    """
    conditions, known = measuring_conditions(), load_timed_runs((store,))
    found = known if known is not None and known.measuring_conditions == conditions else StoredTimedRuns(conditions, [])
    numbers = numbers_of_timed_screws()[:count]
    wanted = [(n, name) for name in TIMED for n in (numbers[:FINEST_COUNT] if name == TIMED[-1] else numbers)]
    done = {(run.number, run.name) for run in found.runs}
    jobs = dict(enumerate(one for one in wanted if one not in done))
    for _, run in solve_many(solve_and_time, jobs, ComputingSettings(parallel_jobs=usable_cores())):
        runs = sorted([*found.runs, run], key=lambda x: (x.number, TIMED.index(x.name)))
        found = StoredTimedRuns(conditions, runs)
        save_timed_runs(store, found)
        show_progress(f"[{len(runs)}/{len(wanted)}] drawn screw {run.number}, {run.name}: {run.seconds:.2g} s")
    return found


def save_timed_runs(folder: Path, timed: StoredTimedRuns) -> None:
    """Write timed solutions of random screws to a JSON file in the folder ``folder``; InputError if that fails."""
    save_times(folder / RUNS, timed.measuring_conditions, utc_date_today(), runs=[asdict(run) for run in timed.runs])


def load_timed_runs(stores: Sequence[Path]) -> StoredTimedRuns | None:
    """Read timed solutions of random screws from the first of the folders ``stores`` with a valid file; None: no file."""

    def timed_runs_from_json(data: dict[str, Any]) -> StoredTimedRuns:
        """Return timed solutions of random screws from the JSON values of the file in which they are stored."""
        return StoredTimedRuns(measuring_conditions_from_json(data), [TimedRun(**row) for row in data["runs"]])

    return read_from_first_valid_folder(stores, RUNS, timed_runs_from_json)


def errors_and_times(runs: Sequence[TimedRun]) -> list[LoadErrorsAndTimes]:
    """Return load errors and processor times of all `TIMED` models and mesh levels, on the same random screws.

    These are the screws that mesh levels 1 and 2 solved; a model that failed on some of them has fewer. Errors are
    differences from mesh level 2, those of level 2 from level 3, which solved some of the screws.

    ``runs``: timed solutions of random screws.
    """
    solved = {(run.number, run.name): run for run in runs if run.status == survey.ANSWERED}
    judged = {number for number, name in solved if name == JUDGE}
    numbers = sorted(number for number in judged if (number, next(iter(LEVELS))) in solved)
    found = []
    for name in TIMED if numbers else ():
        judge, errors = JUDGE_OF_LEVEL.get(name, JUDGE), []
        of_screws = [solved[n, name] for n in numbers if (n, name) in solved]
        for run in of_screws:
            if (run.number, judge) in solved:
                contacts = count_nominal_contacts(load_cases_of_random_screw(run.number)[0])
                errors.append(load_error(np.array(run.load), np.array(solved[run.number, judge].load), contacts))
        check, of_mean = (np.array([getattr(e, key) for e in errors]) for key in ("gate_percent", "max_percent"))
        first, further = (np.array([getattr(run, key) for run in of_screws]) for key in ("seconds", "further_seconds"))
        if of_screws:
            found.append(LoadErrorsAndTimes(name, judge, check, of_mean, first, further))
    return found
