"""Records that `rollbench.ensemble`, `sweep` and `report` return, and their statistics."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from rollbench.compare.quantities import record_as_json
from rollbench.compare.results.base import JSON, Record, Row, TabularRecord, add_schema_version, values_in_words
from rollbench.meshes.arrays import Array
from rollbench.meshes.quantity import QuantityDescription, quantity_field, quantity_or_none, result_record
from rollbench.reports.content import Figure, Panel, Series

#: Probabilities of the quantiles of an output.
QUANTILES = (0.01, 0.05, 0.5, 0.95, 0.99)


@result_record(kw_only=True)
class Statistics:
    """Statistics of one output over the samples of a sweep or the specimens of an ensemble, in the output's unit."""

    members: int | None = quantity_or_none("members", "number of specimens for which the value exists")
    mean: float = quantity_field("mean", "mean over the specimens", error="`standard_error`")
    standard_error: float = quantity_field(
        "standard_error",
        "standard error of the mean: standard deviation divided by the square root of the number of specimens",
    )
    standard_deviation: float = quantity_field("standard_deviation", "standard deviation over the specimens")
    smallest: float = quantity_field("smallest", "smallest value of any specimen")
    largest: float = quantity_field("largest", "largest value of any specimen")
    quantiles: Mapping[float, float] = quantity_field(
        "quantiles",
        "probability, value of the quantile, and the limits of its 95 % confidence interval, low and high",
        parts="[].*",
        default_factory=dict,
    )
    """Quantiles of the output, by their probability: 0.01, 0.05, 0.5, 0.95, 0.99."""
    intervals: Mapping[float, tuple[float, float]] = field(default_factory=dict)
    """Ends of the 95 % confidence interval of each quantile, by its probability; empty for the samples of a sweep."""

    def as_json(self) -> dict[str, Any]:
        """Return the statistics as JSON values; quantiles are a list with intervals, or without these one key for each.

        Returns
        -------
        dict
            JSON values by key.
        """
        data = record_as_json(self, "quantiles", *(() if self.intervals else ("members",)))
        if not self.intervals:
            return data | {f"quantile_{level:g}": value for level, value in self.quantiles.items()}
        each = ((level, value, *self.intervals[level]) for level, value in self.quantiles.items())
        return data | {"quantiles": [dict(zip(("level", "value", "low", "high"), one, strict=True)) for one in each]}


def output_statistics(values: Array, *, intervals: bool = False) -> Statistics | None:
    """Compute the statistics of an output over samples or specimens.

    Parameters
    ----------
    values
        Values of one output, (M,); those that are not finite are left out.
    intervals
        Whether the number of values, and the 95 % confidence interval of each quantile, are given too.

    Returns
    -------
    Statistics or None
        Statistics in the unit of the values; None with fewer than two finite values.
    """
    y = values[np.isfinite(values)]
    if y.size < 2:
        return None
    deviation = float(y.std(ddof=1))
    return Statistics(
        members=int(y.size) if intervals else None,
        mean=float(y.mean()),
        standard_error=deviation / float(np.sqrt(y.size)),
        standard_deviation=deviation,
        smallest=float(y.min()),
        largest=float(y.max()),
        quantiles={level: float(np.quantile(y, level)) for level in QUANTILES},
        intervals={level: _quantile_interval(y, level) for level in QUANTILES} if intervals else {},
    )


def _quantile_interval(y: Array, level: float) -> tuple[float, float]:
    """Return the ends of the 95 % confidence interval of a quantile, from values ``y``; ``level``: probability."""
    y = np.sort(y)
    low, high = (_binomial_quantile(p, y.size, level) for p in (0.025, 0.975))
    return float(y[max(low - 1, 0)]), float(y[min(high, y.size - 1)])


def _binomial_quantile(probability: float, trials: int, chance: float) -> int:
    """Return a quantile of a binomial distribution: the smallest number of successes whose cumulative probability suffices.

    ``probability``: cumulative probability that it must at least have; ``trials``: number of trials; ``chance``:
    probability of success of each trial. Probabilities are summed within about fifteen standard deviations of the mean;
    scipy.special has such a function, too, but takes long to import.
    """
    mean, reach = trials * chance, 15.0 * (1.0 + np.sqrt(trials * chance * (1.0 - chance)))
    first = max(0, int(mean - reach))
    k = np.arange(first, min(trials, int(mean + reach)))
    grown = np.append(0.0, np.cumsum(np.log((trials - k) / (k + 1.0) * chance / (1.0 - chance))))
    below = np.cumsum(np.exp(grown - grown.max()))
    return first + int(np.searchsorted(below, (1.0 - 1e-12) * probability * below[-1]))  # less the round-off of the sum


def statistics_as_json(outputs: Mapping[str, Statistics | None]) -> dict[str, Any]:
    """Return the statistics of several outputs as JSON values by the name of the output; None where there are none."""
    return {name: None if x is None else x.as_json() for name, x in outputs.items()}


def statistics_rows(outputs: Mapping[str, Statistics | None]) -> list[dict[str, Any]]:
    """Return a row for each statistic, such as mean or a quantile, with a column for each output.

    ``outputs``: statistics by the name of the output, which ends with its unit. Statistics that no output has are left out.
    """
    known = {name: x for name, x in outputs.items() if x is not None}
    flat = {name: _flat_statistics(x) for name, x in known.items()}
    rows = dict.fromkeys(key for of in flat.values() for key in of)
    return [{"statistic": key, **{name: of.get(key) for name, of in flat.items()}} for key in rows]


def _flat_statistics(x: Statistics) -> dict[str, float]:
    """Return the values of statistics by their names, one value each; ends of intervals end with "low" and "high"."""
    out = {name: value for name, value in record_as_json(x, "quantiles").items() if value is not None}
    for level, value in x.quantiles.items():
        ends = dict(zip(("_low", "_high"), x.intervals.get(level, ()), strict=False))
        out |= {f"quantile_{level:g}{end}": number for end, number in ({"": value} | ends).items()}
    return out


@result_record(eq=False, repr=False, kw_only=True)
class Ensemble(TabularRecord):
    """Statistics of the results over many specimens of a scene with random geometric errors."""

    scene: str
    """Name of the scene."""
    model: str = ""
    """Name of the model; empty if the scene has load cases."""
    seed: int | Sequence[int | None] | None = None
    """Seed of the random errors, or that of each nut or bearing; None if the scene has load cases, or for rollers."""
    seconds: float = 0.0
    """Computing time of all specimens [s]."""
    members: int
    """Number of specimens in each load case."""
    converged: int
    """Number of specimens with an equilibrium; with load cases, the smallest such number of any case."""
    outputs: Mapping[str, Statistics | None] = field(default_factory=dict)
    """Statistics of each output, by its name; None if fewer than two specimens have a value. Empty if the scene has load
    cases."""
    failed: Mapping[int, str] = field(default_factory=dict)
    """For each specimen without equilibrium, by its number from 0, the reason why it has none. Empty if the scene has load
    cases."""
    sets: Mapping[str, Mapping[str, Statistics | None]] = field(default_factory=dict)
    """Statistics by the name of the nut or bearing and the name of the output; empty for a single nut or bearing."""
    contacts: tuple[Mapping[str, float | str], ...] = quantity_field(
        "balls",
        "for one contact: load without random errors; mean, standard deviation and quantiles of the load over the "
        "specimens; share of specimens in which the contact is loaded",
        QuantityDescription(
            "balls[].quantile_0",
            "quantile of this contact's load over the specimens",
            error="`band_resolution_N`",
            parts=".*",
        ),
        error="`band_resolution_N`",
        parts="[].*",
        default=(),
    )
    """Statistics of the load of every contact, in the units that the keys end with; empty if the scene has several nuts,
    bearings or load cases."""
    band_resolution: float | None = quantity_or_none(
        "band_resolution_N", "sampling error of the quantiles of the contact loads"
    )
    cases: Mapping[str, Ensemble] = field(default_factory=dict)
    """Statistics of each load case, by its name; empty without load cases."""

    def to_dict(self) -> dict[str, JSON]:
        """Return the ensemble as a dictionary, as ``rollbench solve --members --json`` prints it.

        Returns
        -------
        dict
            JSON values by key.
        """
        return add_schema_version(self.as_json())

    def as_json(self) -> dict[str, Any]:
        """Return the JSON values of `to_dict` without the version number of the format.

        Returns
        -------
        dict
            JSON values by key.
        """
        if self.cases:
            return {"scene": self.scene, "cases": [{"case": name} | one.as_json() for name, one in self.cases.items()]}
        data: dict[str, Any] = {"scene": self.scene, "model": self.model}
        data["seed"] = self.seed if isinstance(self.seed, int) or self.seed is None else list(self.seed)
        data |= {"members": self.members, "converged": self.converged}
        data["failed"] = [{"member": number, "status": status} for number, status in sorted(self.failed.items())]
        if self.sets:
            data["sets"] = [
                {"set": k, "name": name, "statistics": statistics_as_json(of)}
                for k, (name, of) in enumerate(self.sets.items(), 1)
            ]
        data |= {"statistics": statistics_as_json(self.outputs), "band_resolution_N": self.band_resolution}
        return data | {"balls": [dict(row) for row in self.contacts]}

    def frame_rows(self) -> Sequence[Mapping[str, Any]]:
        """Return a row for each statistic, with a column for each output; of each load case and each nut or bearing.

        Returns
        -------
        list
            Row of each line of the frame, by the names of its columns.
        """
        if self.cases:
            return [{"case": name} | dict(row) for name, one in self.cases.items() for row in one.frame_rows()]
        whole = statistics_rows(self.outputs)
        sets = [{"set": name} | row for name, of in self.sets.items() for row in statistics_rows(of)]
        return [*({"set": None} | row for row in whole), *sets] if sets else whole

    @property
    def _notes(self) -> tuple[str, ...]:
        """Line below the table: seed, numbers of specimens, and sampling error of the quantiles of the contact loads."""
        counts = {"seed": self.seed, "members": self.members, "converged": self.converged}
        return (values_in_words(counts | {"band_resolution_N": self.band_resolution}),)

    def figure(self) -> Figure | None:
        """Return the figure of the contact loads over the balls: median and 5 to 95 % of the specimens, a panel a flank.

        Returns
        -------
        reports.content.Figure or None
            The figure, as the report draws it; None if there is nothing to draw.
        """
        panels = list(self._load_panels(""))
        title = f"{self.scene}: contact loads of {self.members} specimens with random errors"
        return Figure(f"{self.scene}-members", title, panels, columns=2) if panels else None

    def _load_panels(self, case: str) -> Iterator[Panel]:
        """Yield a panel for each flank of each nut or bearing; ``case``: text on the load case, added to its title."""
        for name, one in self.cases.items():
            yield from one._load_panels(f", case {name}")
        groups: dict[tuple[Any, Any], list[Mapping[str, Any]]] = {}
        for row in self.contacts:
            groups.setdefault((row.get("set"), row["side"]), []).append(row)
        for (set_, side), rows in groups.items():
            at = [float(row["index"]) for row in rows]
            low, middle, high, bare = (
                [row[f"{key}_N"] for row in rows]
                for key in ("quantile_0.05", "quantile_0.5", "quantile_0.95", "without_random_errors")
            )
            series = (
                Series("5 to 95 % of the specimens", at, low, "band", upper_y=high),
                Series("median", at, middle, "line", bold=True),
                Series("without random errors", at, bare, "markers"),
            )
            where = f"set {set_}, {side}" if set_ is not None else str(side)
            yield Panel(f"{where}{case}", "number_of_ball", "contact_load", series, include_zero=True, integer_x=True)


@dataclass(frozen=True, eq=False, repr=False)
class Written(Record):
    """Path of a report that `rollbench.report` wrote, with the verdict that the report gives on the scene.

    It is true if the report passed (`passed`).
    """

    values: Mapping[str, JSON]
    """JSON values that the command prints, without the version number of the output."""
    notes: tuple[str, ...] = ()
    """Sentences printed below the table."""
    _: KW_ONLY
    page: Path
    """File of the report's first page."""
    passed: bool
    """False if a run of the 3D reference that was computed again for the report differs from the stored run, otherwise
    True."""
    verdict: str = ""
    """Sentence that judges the scene; empty for the report on all scenes."""

    def __bool__(self) -> bool:
        """Whether the report passed, for ``assert rollbench.report(...)``."""
        return self.passed

    def to_dict(self) -> dict[str, JSON]:
        """Return the result as a dictionary, as ``rollbench report --json`` prints it.

        Returns
        -------
        dict
            JSON values by key; the first key, ``schema``, has the version number of the JSON format.
        """
        return add_schema_version(self.values)

    def table(self) -> Sequence[Row]:
        """Return the rows of the table that notebooks and ``print`` show.

        Returns
        -------
        Sequence[Row]
            A row for each of `values`.
        """
        return [Row(name, str(value)) for name, value in self.values.items()]

    @property
    def _notes(self) -> tuple[str, ...]:
        """Sentences printed below the table."""
        return self.notes

    def __repr__(self) -> str:
        """Return the first five lines of the table."""
        return "\n".join(str(self).splitlines()[:5])
