"""What the samples of a sweep say together: counts, statistics, main effects, worst cases, Sobol indices."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import sobol_indices

from rollbench.compare.scenes.scene_file import scene_hash
from rollbench.compare.studies.sweep.design import base_points
from rollbench.compare.studies.sweep.keys import Vary
from rollbench.compare.studies.sweep.outputs import MAIN
from rollbench.compare.studies.sweep.run import Sweep
from rollbench.compare.studies.sweep.sample import CONVERGED
from rollbench.compare.studies.sweep.store import Record
from rollbench.meshes.arrays import Array

#: Worst samples listed, bins of a range in main effects, levels of the statistics.
WORST, BINS, LEVELS = 10, 8, (0.01, 0.05, 0.5, 0.95, 0.99)
#: Resamples of the confidence intervals, their level, and least base points of indices.
RESAMPLES, CONFIDENCE, LEAST = 200, 0.95, 8
#: Standard deviation over the mean below which an output is constant but for round-off.
CONSTANT = 1e-9


def summary(sweep: Sweep, records: Mapping[int, Record]) -> dict[str, Any]:
    """JSON-ready summary of the records, by number, of a sweep; a refusal, which names its sample's value, stands for all
    of its reason."""
    rows = [records[n] for n in sorted(records)]
    good = converged(records)
    failed = [row for row in rows if row["status"] != CONVERGED]
    reasons = Counter(row.get("reason", row["status"]) for row in failed)
    first = {
        row.get("reason", row["status"]): row["status"] for row in reversed(failed)
    }  # a refusal says its sample's value
    return {
        **{k: v for k, v in sweep.header().items() if k != "text"},
        "scene_hash": scene_hash(sweep.text),
        "solved": len(rows),
        "converged": len(good),
        "failures": [{"reason": first[reason], "samples": n} for reason, n in reasons.most_common()],
        "outputs": {name: statistics(column(good, name)) for name in sweep.wanted},
        "main_effects": main_effects(sweep.keys, good),
        "worst": sorted(good, key=lambda row: -row[MAIN])[:WORST],
        "indices": indices(sweep, records),
    }


def converged(records: Mapping[int, Record]) -> list[Record]:
    """Converged records in order."""
    return [records[n] for n in sorted(records) if records[n]["status"] == CONVERGED]


def column(rows: Sequence[Record], name: str) -> Array:
    """An output of all rows, nan where one has none, ``(k,)``."""
    return np.array([np.nan if row[name] is None else row[name] for row in rows], dtype=float)


def inputs(keys: Sequence[Vary], rows: Sequence[Record]) -> Array:
    """Values of the keys as numbers (see `Vary.number`), ``(k, d)``."""
    found = [[vary.number(v) for vary, v in zip(keys, row["values"], strict=True)] for row in rows]
    return np.array(found, dtype=float).reshape(len(rows), len(keys))


def statistics(values: Array) -> dict[str, float] | None:
    """Mean with its standard error, standard deviation, extremes and quantiles; None of less than two values."""
    y = values[np.isfinite(values)]
    if y.size < 2:
        return None
    sd = float(y.std(ddof=1))
    found = {"mean": float(y.mean()), "standard_error": sd / float(np.sqrt(y.size)), "standard_deviation": sd}
    found |= {"smallest": float(y.min()), "largest": float(y.max())}
    return found | {f"quantile_{level:g}": float(np.quantile(y, level)) for level in LEVELS}


def main_effects(keys: Sequence[Vary], rows: Sequence[Record]) -> dict[str, list[dict[str, float]]]:
    """Of each key: mean of `MAIN` over the samples in each part of its range, or at each value of its list, with its
    standard error; rows of ``at`` (in the key's unit), ``mean``, ``standard_error``, ``samples``."""
    x, y = inputs(keys, rows), column(rows, MAIN)
    return {vary.key: [_group(x[g, k], y[g]) for g in _groups(vary, x[:, k])] for k, vary in enumerate(keys)}


def _groups(vary: Vary, x: Array) -> list[NDArray[np.bool_]]:
    distinct = np.unique(x)
    if distinct.size <= BINS or vary.choices:
        return [x == value for value in distinct]
    bins = np.clip(((x - vary.low) / (vary.high - vary.low) * BINS).astype(int), 0, BINS - 1)
    return [bins == k for k in np.unique(bins)]


def _group(x: Array, y: Array) -> dict[str, float]:
    error = float(y.std(ddof=1) / np.sqrt(y.size)) if y.size > 1 else 0.0
    return {"at": float(x.mean()), "mean": float(y.mean()), "standard_error": error, "samples": int(y.size)}


def indices(sweep: Sweep, records: Mapping[int, Record]) -> dict[str, Any]:
    """Sobol indices of every output with `CONFIDENCE` intervals, or the reason why there are none.

    Of each output: key -> first, first_low, first_high, total, total_low, total_high; None where it is constant. From the
    base points all of whose samples converged, the first of them that make a power of two.
    """
    if sweep.method != "sobol":
        return {"none": f"a design by {sweep.method} gives no Sobol indices: sobol does"}
    d, n = len(sweep.keys), base_points(sweep.samples, len(sweep.keys))
    rows = [records.get(k) for k in range(n * (d + 2))]
    good = np.array([row is not None and row["status"] == CONVERGED for row in rows]).reshape(d + 2, n)
    whole = np.flatnonzero(good.all(axis=0))
    if whole.size < LEAST:
        return {"none": f"{whole.size} base points of {n} have all their samples; {LEAST} are needed"}
    kept = whole[: 2 ** int(np.log2(whole.size))]
    found: dict[str, Any] = {"base_points": int(kept.size), "of": n, "confidence": CONFIDENCE, "outputs": {}}
    for name in sweep.wanted:
        y = np.array([np.nan if row is None or row.get(name) is None else row[name] for row in rows], dtype=float)
        found["outputs"][name] = _indices_of(sweep.keys, y.reshape(d + 2, n)[:, kept], sweep.seed)
    return found


def _indices_of(keys: Sequence[Vary], y: Array, seed: int) -> dict[str, dict[str, float]] | None:
    if not np.all(np.isfinite(y)) or y[:2].std() <= CONSTANT * abs(y[:2].mean()):
        return None
    n = y.shape[1]
    rng = np.random.default_rng([seed, n])
    drawn = np.stack([np.stack(_sobol(y[:, rng.integers(0, n, n)])) for _ in range(RESAMPLES)])
    tail = 0.5 * (1.0 - CONFIDENCE)
    low, high = np.quantile(drawn, [tail, 1.0 - tail], axis=0)
    out = {}
    for k, vary in enumerate(keys):
        out[vary.key] = {
            f"{kind}{end}": float(value[i, k])
            for i, kind in enumerate(("first", "total"))
            for end, value in (("", np.stack(_sobol(y))), ("_low", low), ("_high", high))
        }
    return out


def _sobol(y: Array) -> tuple[Array, Array]:
    """First and total indices (d,) of outputs (d + 2, n): at A, at B, at the mixtures."""
    d = len(y) - 2
    mixtures = y[2:] if d > 1 else np.repeat(y[2:], 2, axis=0)  # scipy 1.17 fails for a single key: it is given twice
    found = sobol_indices(func={"f_A": y[:1], "f_B": y[1:2], "f_AB": mixtures[:, None, :]}, n=y.shape[1])
    return np.atleast_1d(found.first_order)[:d], np.atleast_1d(found.total_order)[:d]
