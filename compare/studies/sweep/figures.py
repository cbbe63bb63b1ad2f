"""Figures of a sweep: main effects with Sobol indices, scatter, worst cases."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from rollbench.compare.studies.sweep.keys import Vary
from rollbench.compare.studies.sweep.outputs import MAIN, OUTPUTS
from rollbench.compare.studies.sweep.store import Record
from rollbench.compare.studies.sweep.summary import column, inputs
from rollbench.reports.content import Figure, Panel, Series

#: Most panels of a figure, and most points of a scatter.
PANELS, POINTS = 6, 2000
#: The key that tells one drawn screw from another.
SEED = "errors.seed"


def figures(name: str, keys: Sequence[Vary], found: Mapping[str, Any], rows: Sequence[Record]) -> list[Figure]:
    """Figures of a sweep by its summary and converged records; none with less than two of these."""
    if len(rows) < 2:
        return []
    shown, left = _shown(keys, found)
    return [*of_summary(name, keys, found), _scatter(name, keys, shown, rows, left)]


def of_summary(
    name: str, keys: Sequence[Vary], found: Mapping[str, Any], called: Callable[[Vary], str] = lambda vary: vary.name
) -> list[Figure]:
    """The figures that a summary gives by itself; ``called``: short names of the keys."""
    shown, left = _shown(keys, found)
    figures = [_effects(name, [keys[k] for k in shown], found, left, called), _worst(name, keys, found["worst"], called)]
    indices = _indices(name, keys, found["indices"], called)
    return figures if indices is None else [*figures, indices]


def _shown(keys: Sequence[Vary], found: Mapping[str, Any]) -> tuple[list[int], str]:
    """Keys of largest effect, as many as a figure has panels, and a sentence where some are left out. A seed has no
    order, so that nothing can be seen along it."""
    ordered = _ordered(keys)
    shown = sorted(ordered, key=lambda k: -_reach(found["main_effects"][keys[k].key]))[:PANELS]
    return shown, "" if len(shown) == len(ordered) else f" The {PANELS} keys of largest effect, of {len(ordered)}."


def _ordered(keys: Sequence[Vary]) -> list[int]:
    """Keys that have an order; where a seed is all, it."""
    return [k for k, vary in enumerate(keys) if vary.key != SEED] or list(range(len(keys)))


def _reach(groups: Sequence[Mapping[str, float]]) -> float:
    means = [g["mean"] for g in groups]
    return max(means) - min(means)


def _effects(name: str, keys: Sequence[Vary], found: Mapping[str, Any], left: str, called: Callable[[Vary], str]) -> Figure:
    panels = []
    for vary in keys:
        groups = found["main_effects"][vary.key]
        at, mean = [g["at"] for g in groups], [g["mean"] for g in groups]
        bars = [m - g["standard_error"] for m, g in zip(mean, groups, strict=True)]
        ends = [m + g["standard_error"] for m, g in zip(mean, groups, strict=True)]
        series = Series("mean", at, mean, "line+markers", bars=(bars, ends))
        short = called(vary)
        label = vary.label if short == vary.name or not vary.unit else f"{short} / {vary.unit}"
        panels.append(Panel(short, label, OUTPUTS[MAIN], (series,), integer_x=bool(vary.choices)))
    caption = "Mean over all samples in a part of the key's range; bars: its standard error." + left
    return Figure(f"{name}-effects", f"{name}: main effects", tuple(panels), caption, same_y=True)


def _scatter(name: str, keys: Sequence[Vary], shown: Sequence[int], rows: Sequence[Record], left: str) -> Figure:
    some = list(rows[:: max(1, len(rows) // POINTS)])
    x, y = inputs(keys, some), column(some, MAIN)
    panels = tuple(
        Panel(keys[k].name, keys[k].label, OUTPUTS[MAIN], (Series("samples", list(x[:, k]), list(y), "markers"),))
        for k in shown
    )
    return Figure(f"{name}-scatter", f"{name}: samples", panels, f"{len(some)} of {len(rows)} samples.{left}")


def _worst(name: str, keys: Sequence[Vary], worst: Sequence[Record], called: Callable[[Vary], str]) -> Figure:
    kept = _ordered(keys)
    x, keys = inputs(keys, worst)[:, kept], [keys[k] for k in kept]
    low = np.array([1.0 if v.choices else v.low for v in keys])
    high = np.array([float(len(v.choices)) if v.choices else v.high for v in keys])
    place = (x - low) / (high - low)
    number = [float(k) for k in range(1, len(keys) + 1)]
    series = tuple(
        Series(f"{row[MAIN]:.4g} N at {row['at']}", number, list(at)) for row, at in zip(worst[:5], place[:5], strict=True)
    )
    caption = "Place of each key in its range (0 to 1), of the samples with the largest loads."
    panel = Panel("worst samples", "", "place in its range", series, names=[called(v) for v in keys])
    return Figure(f"{name}-worst", f"{name}: worst samples", (panel,), caption)


def _indices(name: str, keys: Sequence[Vary], indices: Mapping[str, Any], called: Callable[[Vary], str]) -> Figure | None:
    main = indices.get("outputs", {}).get(MAIN)
    if main is None:
        return None
    keys = sorted(keys, key=lambda vary: -main[vary.key]["total"])
    number = [float(k) for k in range(1, len(keys) + 1)]
    series = []
    for kind, shift in (("first", -0.06), ("total", 0.06)):
        value, low, high = ([main[v.key][f"{kind}{end}"] for v in keys] for end in ("", "_low", "_high"))
        bars = ([min(a, b) for a, b in zip(low, value, strict=True)], [max(a, b) for a, b in zip(high, value, strict=True)])
        series.append(Series(kind, [n + shift for n in number], value, "markers", bars=bars))
    caption = (
        f"Sobol indices of the {OUTPUTS[MAIN].removesuffix(' / N')} from {indices['base_points']} base points, with "
        f"{100 * indices['confidence']:g} % intervals: first, of the key alone; total, with all that it does with others."
    )
    panel = Panel("Sobol indices", "", "share of the variance", tuple(series), zero=True, names=[called(v) for v in keys])
    return Figure(f"{name}-indices", f"{name}: Sobol indices", (panel,), caption)
