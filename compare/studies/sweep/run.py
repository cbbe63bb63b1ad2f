"""A sweep (``rollbench sweep``): its definition, the solution of its samples, and the summary of its results.

Missing samples are solved in batches, in parallel if requested, and every sample is stored. The summary has counts,
statistics, main effects, Sobol indices, figures and the samples with the largest contact loads.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import sem, sobol_indices

from rollbench.compare import __version__
from rollbench.compare.errors import ArgumentError, InputError, ProgramError, SceneNotCoveredError
from rollbench.compare.files import replace_file, write_csv, write_figure, written_together
from rollbench.compare.models import many, user_models
from rollbench.compare.models.registry import DEFAULT, MODELS, default_model_name
from rollbench.compare.reference.jobs import ComputingSettings
from rollbench.compare.results.base import JSON, TabularRecord, add_schema_version
from rollbench.compare.results.data import Statistics, output_statistics, statistics_as_json, statistics_rows
from rollbench.compare.scenes import catalogue, scene_file, scene_tables
from rollbench.compare.scenes.scene_file import hash_of_scene_text
from rollbench.compare.studies.columns import COLUMNS, MAIN
from rollbench.compare.studies.sweep import keys as sweep_keys
from rollbench.compare.studies.sweep import sample
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.reports.content import Figure, Panel, Series

#: Function that shows a line of progress.
Step = Callable[[str], None]
#: Number of samples that are tried before anything is stored: if all are refused for the same reason, the sweep ends.
FIRST = 10
#: Largest number of samples that are solved and stored together, and number of such batches of a small sweep.
LARGEST_BATCH, BATCHES = 50, 20


@dataclass(frozen=True)
class SweepDefinition(sample.VariedScene):
    """Definition of a sweep: scene, varied keys, design of the samples, model and outputs."""

    #: Number of samples.
    samples: int
    #: Design of the samples: "sobol", "lhs" (Latin hypercube) or "grid".
    method: sweep_keys.Method = "sobol"
    #: Seed of the random numbers of the design.
    seed: int = 0
    #: Name of the model.
    model: str = "refined"
    #: Names of the outputs that are computed for each sample, keys of `COLUMNS`; empty: all.
    outputs: tuple[str, ...] = ()

    @property
    def wanted_outputs(self) -> tuple[str, ...]:
        """Names of the stored outputs, in the order of `COLUMNS`: those in ``outputs`` and the largest contact load.

        All outputs are stored if ``outputs`` is empty.
        """
        return tuple(name for name in COLUMNS if not self.outputs or name in (MAIN, *self.outputs))

    def coordinates(self) -> Array:
        """Return the positions of the m samples in the ranges of the d varied keys, (m, d), from 0 (low end) to 1."""
        return sweep_keys.sample_coordinates(self.method, self.keys, self.samples, self.seed)

    def header(self) -> dict[str, Any]:
        """Return the inputs on which the samples' results depend, as JSON values by which the sweep is recognised."""
        names = ("samples", "method", "seed", "model")
        what = {"scene": self.file_name, "text": self.text, "vary": [vary.stated_text for vary in self.keys]}
        some: dict[str, Any] = {"outputs_kept": list(self.wanted_outputs)}
        if self.model not in MODELS:
            some["model_of"] = user_models.origin_of_model(self.model)
        return {"rollbench": __version__, **what, **{name: getattr(self, name) for name in names}, **some}

    def check(self) -> None:
        """Raise InputError if model, output or varied key is unknown, or if the scene does not allow a value of a key."""
        for name in self.outputs:
            if name not in COLUMNS:
                raise ArgumentError("outputs", name, ", ".join(COLUMNS), "give names separated by commas")
        scene = scene_tables.scene_from_tables(self.tables, self.origin)
        sample.check_model(scene, self.model)
        scene_file.scenes_to_solve(scene, self.origin)
        self.check_keys()


def solve_missing_samples(
    sweep: SweepDefinition, folder: Path, engine: ComputingSettings, show_progress: Step
) -> dict[int, many.Record]:
    """Solve the samples of a sweep that its folder does not hold yet, and return the records of all samples by number.

    ``folder``: folder of the stored samples; ``engine``: number of processes, or cluster, that solve the samples;
    ``show_progress``: function that is called with each line of progress. Raises InputError if the sweep is not valid, if
    the folder holds another sweep or other files, or if worker processes are lost.
    """
    sweep.check()
    places = sweep.coordinates()
    if not any(many.stored_rows(folder)):
        _check_first_samples_are_accepted(sweep, places)
    sweep.say_which_keys_are_replaced(show_progress)
    solve = partial(sample.records_of_samples, sweep, sweep.model, sweep.wanted_outputs)
    size = max(1, min(LARGEST_BATCH, len(places) // BATCHES))  # of the sweep only: it affects round-off
    batches = {}
    for first in range(0, len(places), size):
        numbers = range(first, min(first + size, len(places)))
        batches[first] = numbers, [sweep_keys.key_values_at_coordinates(sweep.keys, places[n]) for n in numbers]
    found: dict[int, many.Record] = {}
    stored, noun = many.StoredIn(folder, sweep.header(), "out"), "batches of samples"
    for _, records in many.solve_many(solve, batches, engine, show_progress, noun=noun, stored=stored):
        found |= {record["sample"]: record for record in records}
        failed = sum(record["status"] != many.CONVERGED for record in found.values())
        show_progress(f"[{len(found)}/{len(places)}] {failed} failed")
    return {number: found[number] for number in range(len(places))}


def _check_first_samples_are_accepted(sweep: SweepDefinition, coordinates: Array) -> None:
    """Raise InputError if scene or model refuse each of the first samples of a sweep for the same reason.

    Samples are tried until one is accepted. ``coordinates``: positions of the m samples in the ranges of the d varied keys,
    (m, d) from 0 to 1.
    """
    refused: list[InputError] = []
    for place in coordinates[:FIRST]:
        values = sweep_keys.key_values_at_coordinates(sweep.keys, place)
        (row,) = sample.rows_of_samples(sweep, [values], sweep.model, sweep.wanted_outputs, sweep.origin)
        if not isinstance(row, InputError):
            return
        refused.append(row)
    if len({sample.refusal_reason_without_numbers(error) for error in refused}) > 1:
        return
    if isinstance(refused[-1], ProgramError):
        raise refused[-1]
    few = f"all of the first {len(refused)} samples (combinations of values) were refused for the same reason"
    given = f"{few}; message for the last of them: {refused[-1]}"
    raise SceneNotCoveredError(sweep.origin, "vary", given, "vary other keys, or other ranges")


#: Number of listed samples with the largest contact loads, and number of parts of a range for main effects.
WORST, BINS = 10, 8

#: Number of resamples for confidence intervals, level of these intervals, and smallest number of base points for Sobol
#: indices.
RESAMPLES, CONFIDENCE, LEAST = 200, 0.95, 8

#: Standard deviation over the mean below which an output counts as constant.
CONSTANT = 1e-9


@dataclass(frozen=True)
class GroupMean:
    """Mean largest contact load of a group of samples: those in one part of a key's range, or at one value of its list."""

    at: float
    """Mean value of the key, in its unit."""
    mean: float
    """Mean largest contact load [N]."""
    standard_error: float
    """Standard error of this mean [N]."""
    samples: int
    """Number of samples in the group."""


@dataclass(frozen=True)
class SobolIndex:
    """First-order and total Sobol index of an output for one key [1], each with the ends of its confidence interval."""

    first: float
    first_low: float
    first_high: float
    total: float
    total_low: float
    total_high: float


@dataclass(frozen=True)
class SobolIndices:
    """Sobol indices of all outputs of a sweep."""

    base_points: int
    """Number of base points of the design from which they are estimated."""
    of: int
    """Number of base points of the design."""
    confidence: float
    """Level of the confidence intervals [1]."""
    outputs: Mapping[str, Mapping[str, SobolIndex] | None]
    """Indices by the name of the output and the key of the parameter; None for an output that does not vary."""


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Sweep(TabularRecord):
    """Statistics of a scene's results over sampled values of its parameters."""

    design: SweepDefinition
    """Scene, varied parameters, design of the samples and model."""
    folder: Path
    """Folder with every sample (``samples.csv``) and the summary."""
    solved: int
    """Number of samples."""
    converged: int
    """Number of samples with an equilibrium."""
    failures: tuple[tuple[str, int], ...]
    """Reasons why samples have no equilibrium or were refused, each with the number of samples; the most frequent first."""
    outputs: Mapping[str, Statistics | None]
    """Statistics of each output, by its name; None if fewer than two samples have a value."""
    main_effects: Mapping[str, Sequence[GroupMean]]
    """For each varied key the mean largest contact load [N] in groups of samples."""
    worst: tuple[many.Record, ...]
    """Samples with the largest contact loads, the largest first."""
    indices: SobolIndices | str
    """Sobol indices with confidence intervals of each output, or the reason for none."""

    @property
    def sobol(self) -> dict[str, dict[str, float]]:
        """Total Sobol index [1], by the name of the output and the key of the parameter.

        Outputs that do not vary are left out; empty if the samples are no Sobol design, or too few.
        """
        each = {} if isinstance(self.indices, str) else self.indices.outputs
        return {name: {key: x.total for key, x in of.items()} for name, of in each.items() if of is not None}

    def to_dict(self) -> dict[str, JSON]:
        """Return the sweep as a dictionary, as ``rollbench sweep --json`` prints it and ``summary.json`` holds it.

        Returns
        -------
        dict
            JSON values by key.
        """
        data: dict[str, Any] = {k: v for k, v in self.design.header().items() if k != "text"}
        data |= {"scene_hash": hash_of_scene_text(self.design.text), "solved": self.solved, "converged": self.converged}
        data["failures"] = [{"reason": reason, "samples": count} for reason, count in self.failures]
        data["outputs"] = statistics_as_json(self.outputs)
        data["main_effects"] = {key: [asdict(group) for group in groups] for key, groups in self.main_effects.items()}
        indices = {"none": self.indices} if isinstance(self.indices, str) else asdict(self.indices)
        return add_schema_version(data | {"worst": list(self.worst), "indices": indices})

    def frame_rows(self) -> Sequence[Mapping[str, Any]]:
        """Return a row for each statistic, with a column for each output.

        Returns
        -------
        list
            Row of each line of the frame, by the names of its columns.
        """
        return statistics_rows(self.outputs)

    def figure(self) -> Figure | None:
        """Return the figure of the mean largest contact load over each varied parameter; None without samples.

        Returns
        -------
        reports.content.Figure or None
            The figure, as the report draws it; None if there is nothing to draw.
        """
        return next(iter(self.figures()), None)

    def figures(self, rows: Sequence[many.Record] = ()) -> list[Figure]:
        """Return all figures of the sweep, none without samples.

        Parameters
        ----------
        rows
            Records of converged samples that are shown.

        Returns
        -------
        list of Figure
            The figures.
        """
        if self.converged < 2:
            return []
        return sweep_figures("sweep", self.design.keys, self.main_effects, self.worst, self.indices, rows)

    @property
    def _notes(self) -> tuple[str, ...]:
        """Sentence below the table: how many samples converged, and where they are."""
        return (f"{self.converged} of {self.solved} samples converged: {self.folder}",)


def sweep_summary(sweep: SweepDefinition, records: Mapping[int, many.Record], folder: Path) -> Sweep:
    """Return the summary of a sweep: counts, failures, statistics, main effects and Sobol indices.

    ``records``: records of the samples by sample number; ``folder``: their folder.
    """
    rows = [records[n] for n in sorted(records)]
    good = converged_records(records)
    failures: dict[str, list[str]] = {}  # statuses by reason; the status of a refused sample also states its value
    for row in rows:
        if row["status"] != many.CONVERGED:
            failures.setdefault(str(row.get("reason", row["status"])), []).append(row["status"])
    return Sweep(
        design=sweep,
        folder=folder,
        solved=len(rows),
        converged=len(good),
        failures=tuple((of[0], len(of)) for of in sorted(failures.values(), key=len, reverse=True)),
        outputs={name: output_statistics(output_values(good, name)) for name in sweep.wanted_outputs},
        main_effects=main_effects(sweep.keys, good),
        worst=tuple(sorted(good, key=lambda row: -row[MAIN])[:WORST]),
        indices=sobol_indices_by_output(sweep, records),
    )


def converged_records(records: Mapping[int, many.Record]) -> list[many.Record]:
    """Return the records of converged samples in the order of their numbers."""
    return [records[n] for n in sorted(records) if records[n]["status"] == many.CONVERGED]


def output_values(records: Sequence[many.Record], name: str) -> Array:
    """Return the values of one output in k samples as an array (k,); nan for a sample without this output.

    ``records``: records of the samples; ``name``: name of the output, a key of `COLUMNS`.
    """
    return np.array([np.nan if row[name] is None else row[name] for row in records], dtype=float)


def key_values_as_numbers(keys: Sequence[sweep_keys.VariedKey], records: Sequence[many.Record]) -> Array:
    """Return the values of d varied keys in k samples as an array of numbers (k, d).

    ``records``: records of the samples. A value from a list is replaced by its position in the list, from 1.
    """
    found = [[vary.as_number(v) for vary, v in zip(keys, row["values"], strict=True)] for row in records]
    return np.array(found, dtype=float).reshape(len(records), len(keys))


def main_effects(keys: Sequence[sweep_keys.VariedKey], rows: Sequence[many.Record]) -> dict[str, list[GroupMean]]:
    """Return for each varied key the mean largest contact load [N] in groups of samples.

    ``rows``: records of the converged samples.
    """
    x, y = key_values_as_numbers(keys, rows), output_values(rows, MAIN)
    effects = {}
    for vary, at in zip(keys, x.T, strict=True):
        group = at
        if np.unique(at).size > BINS and not vary.listed_values:
            group = np.clip(((at - vary.low) / (vary.high - vary.low) * BINS).astype(int), 0, BINS - 1)
        of_groups = [(at[group == g], y[group == g]) for g in np.unique(group)]
        effects[vary.key] = [
            GroupMean(float(a.mean()), float(b.mean()), float(sem(b)) if b.size > 1 else 0.0, b.size) for a, b in of_groups
        ]
    return effects


def sobol_indices_by_output(sweep: SweepDefinition, records: Mapping[int, many.Record]) -> SobolIndices | str:
    """Return the Sobol indices of every output with confidence intervals of level `CONFIDENCE`, or the reason for none.

    Only base points whose samples all
    converged are used: the first ones, as many as the largest power of two allows. ``records``: records of the samples by
    sample number.
    """
    if sweep.method != "sobol":
        return f"a design by {sweep.method} gives no Sobol indices: sobol does"
    d, n = len(sweep.keys), sweep_keys.base_point_count(sweep.samples, len(sweep.keys))
    rows = [records.get(k) for k in range(n * (d + 2))]
    good = np.array([row is not None and row["status"] == many.CONVERGED for row in rows]).reshape(d + 2, n)
    whole = np.flatnonzero(good.all(axis=0))
    if whole.size < LEAST:
        return f"{whole.size} base points of {n} have all their samples; {LEAST} are needed"
    kept = whole[: 2 ** int(np.log2(whole.size))]
    outputs = {}
    for name in sweep.wanted_outputs:
        y = np.array([np.nan if row is None or row.get(name) is None else row[name] for row in rows], dtype=float)
        outputs[name] = _sobol_indices_with_intervals(sweep.keys, y.reshape(d + 2, n)[:, kept], sweep.seed)
    return SobolIndices(int(kept.size), n, CONFIDENCE, outputs)


def _sobol_indices_with_intervals(
    keys: Sequence[sweep_keys.VariedKey], outputs: Array, seed: int
) -> dict[str, SobolIndex] | None:
    """Return the Sobol indices of one output for each key, with intervals by resampling; None for a constant output.

    ``outputs``: output (d + 2, n) at n base points A (first row), at n base points B (second row), and, for each of d keys,
    at the points A with the coordinate of this key from B; ``seed``: seed of the resampling.
    """
    if not np.all(np.isfinite(outputs)) or outputs[:2].std() <= CONSTANT * abs(outputs[:2].mean()):
        return None
    n = outputs.shape[1]
    rng = np.random.default_rng([seed, n])
    drawn = np.stack([np.stack(_sobol_estimates(outputs[:, rng.integers(0, n, n)])) for _ in range(RESAMPLES)])
    tail = 0.5 * (1.0 - CONFIDENCE)
    low, high = np.quantile(drawn, [tail, 1.0 - tail], axis=0)
    ends = np.stack([np.stack(_sobol_estimates(outputs)), low, high], axis=1)
    return {vary.key: SobolIndex(*map(float, ends[:, :, k].ravel())) for k, vary in enumerate(keys)}


def _sobol_estimates(outputs: Array) -> tuple[Array, Array]:
    """Return the first-order, then the total Sobol indices of an output, each (d,) for d keys.

    ``outputs``: output (d + 2, n) at n base points A (first row), at n base points B (second row), and, for each key, at
    the points A with the coordinate of this key from B.
    """
    d = len(outputs) - 2
    mixtures = outputs[2:] if d > 1 else np.repeat(outputs[2:], 2, axis=0)  # scipy 1.17 fails for one key: given twice
    found = sobol_indices(func={"f_A": outputs[:1], "f_B": outputs[1:2], "f_AB": mixtures[:, None, :]}, n=outputs.shape[1])
    return np.atleast_1d(found.first_order)[:d], np.atleast_1d(found.total_order)[:d]


#: Largest number of panels of a figure, and of points of a scatter plot.
PANELS, POINTS = 6, 2000

#: Key of the seed of random errors.
SEED = "errors.seed"

#: Axis label of the largest contact load.
LOAD = COLUMNS[MAIN].heading


def sweep_figures(
    name: str,
    keys: Sequence[sweep_keys.VariedKey],
    effects: Mapping[str, Sequence[GroupMean]],
    worst: Sequence[many.Record],
    indices: SobolIndices | str,
    rows: Sequence[many.Record] = (),
) -> list[Figure]:
    """Return the figures of a sweep with two converged samples or more; the last shows the samples, if they are given.

    ``name``: start of the figures' names; ``effects``, ``worst``, ``indices``: as the fields of `Sweep`; ``rows``: records
    of the converged samples.
    """
    shown, left = _keys_with_largest_effect(keys, effects)
    figures = [
        _main_effects_figure(name, [keys[k] for k in shown], effects, left),
        _worst_samples_figure(name, keys, worst),
        _sobol_indices_figure(name, keys, indices),
        _sample_scatter_figure(name, keys, shown, rows, left) if rows else None,
    ]
    return [figure for figure in figures if figure is not None]


def _keys_with_largest_effect(
    keys: Sequence[sweep_keys.VariedKey], effects: Mapping[str, Sequence[GroupMean]]
) -> tuple[list[int], str]:
    """Return the indices of the varied keys with the largest effects on the largest load, then a sentence on left-out keys.

    The effect is the difference between the largest and the smallest mean load over the parts of the key's range.

    At most `PANELS` keys are returned, as many as a figure has panels. A seed of random errors is left out, because an
    output has no trend over it. ``effects``: main effects of the sweep.
    """
    ordered = _indices_of_keys_without_seed(keys)
    means = [[group.mean for group in effects[vary.key]] for vary in keys]
    shown = sorted(ordered, key=lambda k: min(means[k]) - max(means[k]))[:PANELS]
    left = f" Shown are the {PANELS} inputs with the largest effects, of {len(ordered)} varied inputs."
    return shown, left if len(shown) < len(ordered) else ""


def _indices_of_keys_without_seed(keys: Sequence[sweep_keys.VariedKey]) -> list[int]:
    """Return the indices of the varied keys without the seed of random errors; of all keys if only the seed varies.

    Values of a seed have no meaningful order.
    """
    return [k for k, vary in enumerate(keys) if vary.key != SEED] or list(range(len(keys)))


def _main_effects_figure(
    figure_name: str,
    keys: Sequence[sweep_keys.VariedKey],
    effects: Mapping[str, Sequence[GroupMean]],
    left_out_sentence: str,
) -> Figure:
    """Return a figure of the mean of the largest contact load over each varied key, with the standard error of the mean.

    ``figure_name``: start of the figure's name; ``keys``: varied keys to show; ``effects``: main effects of the sweep;
    ``left_out_sentence``: sentence on keys that are left out, empty if there are none.
    """
    panels = []
    for vary in keys:
        groups = effects[vary.key]
        at, mean = [g.at for g in groups], [g.mean for g in groups]
        low, high = ([g.mean + sign * g.standard_error for g in groups] for sign in (-1.0, 1.0))
        series = Series("mean", at, mean, "line+markers", error_bars=(low, high))
        panels.append(Panel(vary.short_name, vary.axis_label, LOAD, (series,), integer_x=bool(vary.listed_values)))
    title = "Mean of the largest contact load of a sample, plotted against the value of each varied input"
    caption = (
        "Each mean is taken over the samples in one part of the range of the input; bars: standard error of this mean."
    )
    return Figure(f"{figure_name}-effects", title, tuple(panels), caption + left_out_sentence, same_y=True)


def _sample_scatter_figure(
    name: str,
    keys: Sequence[sweep_keys.VariedKey],
    shown: Sequence[int],
    rows: Sequence[many.Record],
    left_out_sentence: str,
) -> Figure:
    """Return a figure of the largest contact load of single samples over each varied key that is shown.

    ``name``: start of the figure's name; ``shown``: indices of the keys that are shown; ``rows``: records of the samples;
    ``left_out_sentence``: sentence on keys that are left out, empty if there are none.
    """
    some = list(rows[:: max(1, len(rows) // POINTS)])
    x, y = key_values_as_numbers(keys, some), output_values(some, MAIN)
    points = [Series("samples", list(x[:, k]), list(y), "markers") for k in shown]
    panels = [Panel(keys[k].short_name, keys[k].axis_label, LOAD, (of,)) for k, of in zip(shown, points, strict=True)]
    title = "Largest contact load of each sample, plotted against the value of each varied input"
    caption = f"Shown are {len(some)} of {len(rows)} samples.{left_out_sentence}"
    return Figure(f"{name}-scatter", title, tuple(panels), caption)


def _worst_samples_figure(name: str, keys: Sequence[sweep_keys.VariedKey], worst: Sequence[many.Record]) -> Figure:
    """Return a figure of the samples with the largest contact loads: position of each varied key in its range.

    ``name``: start of the figure's name; ``worst``: records of these samples.
    """
    kept = _indices_of_keys_without_seed(keys)
    x, keys = key_values_as_numbers(keys, worst)[:, kept], [keys[k] for k in kept]
    low = np.array([1.0 if v.listed_values else v.low for v in keys])
    high = np.array([float(len(v.listed_values)) if v.listed_values else v.high for v in keys])
    place = (x - low) / (high - low)
    number = [float(k) for k in range(1, len(keys) + 1)]
    series = tuple(
        Series(f"{row[MAIN]:.4g} N at {row['at']}", number, list(at)) for row, at in zip(worst[:5], place[:5], strict=True)
    )
    caption = f"Value of each varied input as position in its range (0: lower end, 1: upper end), in {len(series)} samples."
    ylabel, names = "position in the range of the input", [v.short_name for v in keys]
    panel = Panel("samples with the largest loads", "", ylabel, series, abscissa_names=names)
    title = "Values of the varied inputs in the samples with the largest contact loads"
    return Figure(f"{name}-worst", title, (panel,), caption)


def _sobol_indices_figure(name: str, keys: Sequence[sweep_keys.VariedKey], indices: SobolIndices | str) -> Figure | None:
    """Return a figure of the Sobol indices of the largest contact load, with confidence intervals; None without indices.

    ``name``: start of the figure's name; ``indices``: result of `sobol_indices_by_output`.
    """
    if isinstance(indices, str) or (main := indices.outputs.get(MAIN)) is None:
        return None
    keys = sorted(keys, key=lambda vary: -main[vary.key].total)
    number = [float(k) for k in range(1, len(keys) + 1)]
    series = []
    for kind, label, shift in (("first", "first-order", -0.06), ("total", "total", 0.06)):
        value, low, high = ([getattr(main[v.key], f"{kind}{end}") for v in keys] for end in ("", "_low", "_high"))
        bars = ([min(a, b) for a, b in zip(low, value, strict=True)], [max(a, b) for a, b in zip(high, value, strict=True)])
        series.append(Series(label, [n + shift for n in number], value, "markers", error_bars=bars))
    caption = (
        f"Sobol indices of the {LOAD.removesuffix(' / N')}, estimated from "
        f"{indices.base_points} base points of the design, with {100 * indices.confidence:g} % confidence intervals. "
        "First-order index: effect of the input alone; total index: including its interactions."
    )
    names, shares = [v.short_name for v in keys], tuple(series)
    panel = Panel("Sobol indices", "", "share of the variance", shares, include_zero=True, abscissa_names=names)
    title = "Share of the variance of the largest contact load that each varied input causes"
    return Figure(f"{name}-indices", title, (panel,), caption)


def sweep_definition(
    scene: str,
    vary: Sequence[str],
    samples: int,
    method: sweep_keys.Method,
    seed: int,
    model: str,
    outputs: Sequence[str] = (),
) -> SweepDefinition:
    """Return the definition of a sweep of a scene: varied keys, design of the samples, model and outputs.

    ``scene``: name of a scene of the package, or a scene file; ``vary``: texts that name the varied keys with their ranges
    or values; ``samples``, ``method`` and ``seed``: number of samples, design and seed of the design; ``model``: name of
    the model, empty for the default; ``outputs``: names of the outputs that are computed, empty for all. Raises InputError
    if the scene or the texts cannot be read.
    """
    found = catalogue.scene_of_any_kind(scene)
    text, origin = catalogue.scene_text_and_file_name(scene)
    model = model or (default_model_name(found) if isinstance(found, Assembly) else DEFAULT)
    keys = sweep_keys.with_axial_load_key(sweep_keys.read_varied_keys(vary), scene_file.parse_toml(text, origin), origin)
    return SweepDefinition(text, origin, keys, samples, method, seed, model, tuple(outputs))


def solve_sweep(
    sweep: SweepDefinition, out: Path, engine: ComputingSettings, show_progress: Callable[[str], None]
) -> Sweep:
    """Solve the missing samples of a sweep, write samples.csv, summary.json and the figures, and return the summary.

    ``out``: folder of the sweep; ``engine``: number of processes, or cluster, that solve the samples; ``show_progress``:
    function that is called with each line of progress. Raises InputError in the cases in which `solve_missing_samples`
    raises it.
    """
    records = solve_missing_samples(sweep, out, engine, show_progress)
    found = sweep_summary(sweep, records, out)
    with written_together():
        write_csv(out / "samples.csv", [_sample_as_row(sweep, records[n]) for n in sorted(records)])
        replace_file(
            out / "summary.json", json.dumps(found.to_dict(), indent=1, ensure_ascii=False, allow_nan=False) + "\n"
        )
        for figure in found.figures(converged_records(records)):
            write_figure(out / f"{figure.name}.svg", figure)
    return found


def _sample_as_row(sweep: SweepDefinition, record: many.Record) -> dict[str, Any]:
    """Return a sample as a row of samples.csv.

    The columns are the number of the sample, the values of the varied keys, the status, the outputs, and "at", which names
    the contact with the largest load.
    """
    values = {vary.key: value for vary, value in zip(sweep.keys, record["values"], strict=True)}
    answers = {name: record.get(name) for name in ("status", *sweep.wanted_outputs, "at")}
    return {"sample": record["sample"], **values, **answers}
