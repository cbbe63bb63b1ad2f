"""Records that `rollbench.friction`, `ensemble`, `mesh_study`, `sweep`, `survey` and `report` return."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from functools import reduce
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from rollbench.compare.models.friction_torques import FrictionTorques
from rollbench.compare.quantities import json_number, name_and_unit_of_key, quantities_of_record, record_as_json
from rollbench.compare.results.base import JSON, Record, TabularRecord, add_schema_version
from rollbench.lowfi.warned import ResultWarning, join_brief_warnings
from rollbench.meshes.arrays import Array
from rollbench.meshes.quantity import QuantityDescription, quantity_field, result_record
from rollbench.reports.content import Figure, Panel, Series

if TYPE_CHECKING:
    from rollbench.compare.models.load_cases import AxisDrive


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class InOrderOfKeys:
    """Record whose JSON depends on the kind of the scene: a list of keys, each with its value or that of a field."""

    entries: Mapping[str, Any] = field(repr=False)
    """Entries of the JSON in their order, by keys joined by dots; ``...`` stands for the field with this key."""

    def as_json(self) -> dict[str, Any]:
        """Return the entries as JSON."""
        kind: Any = type(self)
        known = quantities_of_record(kind)
        out: dict[str, Any] = {}
        for key, value in self.entries.items():
            *tables, last = key.split(".")
            inner = reduce(lambda at, name: at.setdefault(name, {}), tables, out)
            inner[last] = known[key].value(self) if value is ... else value
        return out


def rows_as_json(rows: Iterable[Any] | None) -> list[dict[str, Any]] | None:
    """Return the JSON of each of several records; None if there are none for the kind of scene."""
    return None if rows is None else [row.as_json() for row in rows]


#: A value for each groove flank of a ball, by the flank's name SL, SR, NL or NR; None without contact.
Flanks: TypeAlias = Mapping[str, float | None]
#: Two components, across and along the groove, for each groove flank of a ball, by the flank's name SL, SR, NL or NR.
FlankPairs: TypeAlias = Mapping[str, Sequence[float | None]]


@result_record(kw_only=True)
class FrictionBall(InOrderOfKeys):
    """Motion of one ball of a screw or bearing, and the friction in its contacts.

    A field is None if the quantity does not exist for this kind of scene.
    """

    set: int | None = quantity_field("set", default=None)
    """Number of the nut or bearing on the shaft, from 1; None for a single one."""
    index: int = quantity_field("index")
    """Number of the ball along its track, from 1."""
    orbit: float | None = quantity_field("orbit_rad_s", "speed of the ball's centre about the axis", default=None)
    rotation: Sequence[float | None] | None = quantity_field(
        "rotation_rad_s",
        "rotation of the ball about its centre: across, along, normal to its track",
        parts="[]",
        default=None,
    )
    closing: float | None = quantity_field("closing_mm_s", "speed at which the gap to the next ball closes", default=None)
    sliding: FlankPairs | None = quantity_field(
        "sliding_mm_s", "sliding speed at the contact's centre, across and along the groove", parts=".FLANK[]", default=None
    )
    spin: Flanks | None = quantity_field("spin_rad_s", "rotation about the contact's normal", parts=".FLANK", default=None)
    force: FlankPairs | None = quantity_field(
        "friction_N", "friction force on the ball, across and along the groove", parts=".FLANK[]", default=None
    )
    moment: Flanks | None = quantity_field(
        "moment_Nmm", "friction moment about the contact's normal", parts=".FLANK", default=None
    )
    loss: Flanks | None = quantity_field("loss_mW", "power lost in the contact", parts=".FLANK", default=None)
    at_rest: Mapping[str, bool] | None = quantity_field(
        "at_rest", "whether the contact sticks", parts=".FLANK", default=None
    )


@result_record(kw_only=True)
class FrictionBand:
    """Friction torques at the smallest and largest coefficient of sliding friction with lubricants, 0.03 and 0.1.

    Of several nuts on one shaft, only the preload and the drag torque by the makers' formula are known.
    """

    coefficients: Sequence[float] = quantity_field(
        "coefficients", "smallest and largest coefficient of sliding friction with lubricants, 0.03 and 0.1", parts="[]"
    )
    torque: Sequence[float | None] | None = quantity_field(
        "friction_torque_Nmm",
        "friction torque at the smallest and at the largest of these coefficients of friction",
        parts="[]",
        heading="friction torque, lubricated",
        form="g3",
        note="coefficients {least} to {most}",
    )
    drag_torque: Sequence[float | None] | None = quantity_field(
        "drag_torque_Nmm", "drag torque at the smallest and at the largest of these coefficients", parts="[]"
    )
    preload: float | None = quantity_field("preload_N", "preload force F in the makers' formula for the drag torque")
    makers: float | None = quantity_field(
        "makers_formula_Nmm",
        "drag torque by the formula of screw makers, 0.05/sqrt(tan beta) F l/(2 pi)",
        heading="drag torque by THK's formula",
        form="g3",
        note="preload {preload_N} N, any coefficient; ours rises faster than mu",
    )


@result_record(kw_only=True)
class FrictionPlay:
    """Effect of axial play on the friction torque of a screw whose scene states neither preload nor play.

    The play is given to the screw by reducing the radii of its balls.
    """

    smaller: float = quantity_field("smaller_by_um", "reduction of the ball radii that gives the play")
    torque: float | None = quantity_field("friction_torque_Nmm", "friction torque with this play")
    as_given: float | None = quantity_field("friction_torque_as_given_Nmm", "friction torque of the unchanged scene")


@result_record(kw_only=True)
class FrictionOnset:
    """Prediction whether neighbouring balls come into contact, from their speeds under the static loads.

    Balls without load are assumed to stand still, unless a field says otherwise.
    """

    touch: bool = quantity_field(
        "touch",
        "whether neighbours meet before the leading one leaves its loaded arc (of a bearing, before the balls have gone "
        "round once); unloaded balls stand still",
    )
    first: float | None = quantity_field(
        "first_meeting_deg",
        "rotation of the turning part at which the first two neighbouring balls meet; null if no gap closes",
    )
    ball: int | None = quantity_field("ball", "number of the ball at the smaller azimuth of the two that meet first")
    rolling: float | None = quantity_field(
        "first_meeting_rolling_deg",
        "rotation at which the first two neighbouring balls meet if unloaded balls roll at the nominal speed",
    )
    closing: int = quantity_field("closing_pairs", "number of pairs of neighbouring balls that approach each other")
    pairs: int = quantity_field("pairs", "number of pairs of neighbouring balls in all circuits")
    unloaded: int = quantity_field("balls_without_load", "number of balls without load")
    factor: float | None = quantity_field(
        "error_factor",
        "smallest factor by which the scene's geometric errors of grooves and single balls must be multiplied for "
        "neighbouring balls to touch; 0 if they touch without errors; null if the scene has no such errors, or if balls do "
        "not touch up to a factor of 16",
        error="3 %",
    )


@result_record(kw_only=True)
class FrictionCases:
    """Largest and mean friction torque over all load cases of a duty cycle."""

    largest: float | None = quantity_field("largest_friction_torque_Nmm", "largest friction torque of any load case")
    case: str | None = quantity_field("largest_friction_torque_case", "load case with the largest friction torque")
    mean: float | None = quantity_field(
        "mean_friction_torque_Nmm", "work of friction over the duty cycle, divided by the angle of rotation"
    )
    words: str | None = quantity_field("mean_words", "reason why no mean friction torque can be computed")


@result_record(eq=False, repr=False, kw_only=True)
class FrictionOfSet(FrictionTorques):
    """Friction of one nut or ball bearing on a shaft."""

    set: int
    """Number of the nut or bearing on the shaft, from 1."""
    name: str
    """Name of the nut or bearing."""
    loss: float
    """Power lost in its contacts [W]."""

    def as_json(self) -> dict[str, Any]:
        """Return number, name, torques, efficiencies and loss as JSON."""
        torques = self.torques_as_json()
        return {"set": self.set, "name": self.name, **torques, "loss_W": json_number(self.loss)}


@result_record(eq=False, repr=False, kw_only=True)
class Friction(InOrderOfKeys, FrictionTorques, TabularRecord):
    """Friction in a scene: motion of the balls, power losses [W], torques [N m] and efficiencies [1].

    A field is None if the quantity does not exist for this kind of scene. If no motion was found in which the contact loads
    and the friction forces balance (`converged` is false), values are those of the last iteration.

    Examples
    --------
    >>> import rollbench
    >>> found = rollbench.friction("lin-case1", model="lin")
    >>> round(found.loss, 2), len(found.balls), round(found.balls[0].orbit, 3)  # W, -, rad/s
    (5.27, 32, 2.763)
    """

    scene: str = quantity_field("scene")
    """Name of the scene."""
    title: str = quantity_field("title")
    """Title of the scene."""
    kind: str = quantity_field("kind")
    """Kind of the scene, such as ball screw or bearing."""
    model: str | None = quantity_field("model", default=None)
    """Model that computed the contact loads."""
    member: int | None = quantity_field("member", default=None)
    """Number of the specimen; None without random errors."""
    case: str | None = quantity_field("case", default=None)
    """Name of the load case."""
    share: float | None = quantity_field("share", default=None)
    """Share of the load case in all revolutions of its duty cycle."""
    converged: bool = quantity_field("converged")
    """Whether a motion was found in which the contact loads and the friction forces balance."""
    reason: str = quantity_field("status")
    """The word "converged", or the reason why the computation did not converge."""
    screw_coefficient: float | None = quantity_field(
        "friction.screw", "coefficient of friction in the screw's groove", default=None
    )
    nut_coefficient: float | None = quantity_field(
        "friction.nut", "coefficient of friction in the nut's groove", default=None
    )
    turns: str | None = quantity_field("motion.turns", "which part turns, such as screw or nut", default=None)
    speed: float | None = quantity_field("motion.speed_rad_s", "speed of the part that turns", default=None)
    loss: float | None = quantity_field(
        "losses.total_W",
        "power lost in all contacts",
        QuantityDescription("losses", "power lost between balls, and change of the power by Heathcote slip", parts=".*"),
        QuantityDescription(
            "losses.by_contact_W",
            "power lost on one groove flank, the shares of sliding across and along the groove and of spin, the power lost "
            "if the contacts are curved, and mean loads of the flank with and without friction",
            parts="[].*",
        ),
        QuantityDescription(
            "energy",
            "power of the driving torque, of the axial load and of the losses, and the error of their balance",
            parts=".*",
        ),
        QuantityDescription(
            "feedback",
            "friction torque if friction did not move the balls in their grooves, and the change due to that motion",
            parts=".*",
        ),
        QuantityDescription("energy.loss_W"),
        heading="power lost",
        form="g3",
        note="at {speed_rpm} rpm",
        default=None,
    )
    imbalance: float | None = quantity_field(
        "solver.friction_imbalance",
        "largest unbalanced force on a ball, friction included, divided by its load",
        QuantityDescription("solver.static_residual", "residual of the static equilibrium with friction forces"),
        QuantityDescription("solver.feedback_change", "change of the loads by friction in the last iteration"),
        default=None,
    )
    balls: tuple[FrictionBall, ...] = quantity_field("balls", show=rows_as_json, default=())
    """Motion and friction of each ball; empty if the scene has load cases, or if its kind has no results for each ball."""
    sets: tuple[FrictionOfSet, ...] | None = quantity_field("sets", show=rows_as_json, default=None)
    """Friction of each nut and ball bearing on a shaft."""
    drive: AxisDrive | None = quantity_field("drive", default=None)
    """Torques and moments of inertia at the motor of a feed axis."""
    band: FrictionBand | None = quantity_field("band", default=None)
    """Torques over the range of measured coefficients of friction, and drag torque by the makers' formula; None without."""
    onset: FrictionOnset | None = quantity_field("onset", default=None)
    """Prediction whether neighbouring balls come into contact; None if balls overlap or do not fit into their circuits,
    and for several nuts or bearings on one shaft."""
    play: FrictionPlay | None = quantity_field("play", default=None)
    """Effect of axial play; None if the scene states preload or play."""
    assumed: tuple[str, ...] = quantity_field("assumed", default=())
    """Assumptions of scene and model."""
    left_out: tuple[str, ...] = quantity_field("left_out", default=())
    """Neglected effects."""
    warnings: tuple[ResultWarning, ...] = quantity_field("warnings", default=())
    """Warnings about results outside the models' range of validity."""
    cases: Mapping[str, Friction] = quantity_field(
        "cases", show=lambda cases: rows_as_json(cases.values()), default_factory=dict
    )
    """Friction in each load case, by name; empty without load cases."""
    together: FrictionCases | None = quantity_field("summary", default=None)
    """Largest and mean friction torque over all load cases; None without load cases."""

    @property
    def warning(self) -> str:
        """Short text of all warnings, which is shown above the results; may be empty."""
        return join_brief_warnings(self.warnings)

    def to_dict(self) -> dict[str, JSON]:
        """Return the result as a dictionary, as ``rollbench friction --json`` prints it.

        Returns
        -------
        dict
            JSON values by key; the first key, ``schema``, has the version number of the JSON format.
        """
        return add_schema_version(self.as_json() | {"warning": self.warning or None})

    @property
    def _shown_path(self) -> str:
        """Key of the part of the JSON that the table shows; empty for the whole JSON."""
        return "torque" if any(key.startswith("torque.") for key in self.entries) else ""

    @property
    def _notes(self) -> tuple[str, ...]:
        """Sentences printed below the table."""
        return self.warnings

    def __repr__(self) -> str:
        """Return the first five lines of the table."""
        return "\n".join(str(self).splitlines()[:5])

    def frame_rows(self) -> Sequence[Mapping[str, Any]]:
        """Return a row for every ball, of each load case; without results for balls a row of the torques.

        Values on the four flanks have columns such as ``loss_mW_SL``, vectors such as ``rotation_rad_s_1``.

        Returns
        -------
        list
            Row of each line of the frame, by the names of its columns.
        """
        if self.cases:
            return [{"case": name} | dict(row) for name, one in self.cases.items() for row in one.frame_rows()]
        if self.balls:
            return [dict(_flat_columns(record_as_json(ball))) for ball in self.balls]
        return [{f"{name}_Nmm": 1e3 * value for name, value in self._torques().items()}]

    def units(self) -> dict[str, str]:
        """Return the unit of each column of `columns` by its name; columns without unit are left out.

        Returns
        -------
        dict
            Unit of each column, such as "mW", by the column's name.
        """
        bare = {name: re.sub(r"(_(SL|SR|NL|NR))?(_\d)?$", "", name) for name in self.columns()}
        found = {name: name_and_unit_of_key(key)[1] for name, key in bare.items()}
        return {name: unit.text for name, unit in found.items() if unit is not None}

    def figure(self) -> Figure | None:
        """Return the figure of the power lost by each ball on each flank, a panel a nut and load case; else of the torques.

        Returns
        -------
        reports.content.Figure or None
            The figure, as the report draws it; None if there is nothing to draw.
        """
        panels = [panel for name, one in (self.cases or {"": self}).items() for panel in one._loss_panels(name)]
        if panels:
            return Figure("friction", f"{self.scene}: friction of each ball", panels)
        torques = self._torques()
        if not torques:
            return None
        at = [float(k) for k in range(1, len(torques) + 1)]
        bars = Series("torque", [1e3 * value for value in torques.values()], at, "bars")
        names = [name.replace("_", " ") for name in torques]
        panel = Panel("torques", "torque / N mm", "", (bars,), include_zero=True, ordinate_names=names)
        return Figure("friction", f"{self.scene}: torques of friction", (panel,))

    def _torques(self) -> dict[str, float]:
        """Return the torques [N m] that are known, by the name of the field."""
        names = ("torque", "reverse_torque", "drag_torque", "forward_torque", "backward_torque", "driving_torque_on_screw")
        return {name: value for name in names if (value := getattr(self, name)) is not None}

    def _loss_panels(self, case: str) -> Iterator[Panel]:
        """Yield a panel of the power lost by each ball on each flank for each nut or bearing, all with the same flanks.

        ``case``: name of the load case.
        """
        names: dict[int | None, str] = {one.set: one.name for one in self.sets or ()}
        lost = [(ball.set, ball.index, ball.loss) for ball in self.balls if ball.loss is not None]
        sides = dict.fromkeys(side for _, _, loss in lost for side, value in loss.items() if value)
        for number in dict.fromkeys(number for number, _, _ in lost):
            here = [(float(index), loss) for one, index, loss in lost if one == number]
            series = [
                Series(side, [x for x, _ in here], [1e3 * (loss.get(side) or 0.0) for _, loss in here]) for side in sides
            ]
            title = ", ".join(filter(None, (case and f"case {case}", names.get(number)))) or "power lost on each flank"
            if series:
                yield Panel(title, "number of the ball", "power lost / mW", series, include_zero=True, integer_x=True)


def _flat_columns(row: Mapping[str, Any], start: str = "") -> Iterator[tuple[str, Any]]:
    """Yield name and value of each column of a JSON row, whose objects and lists have a column for each entry."""
    for key, value in row.items():
        if isinstance(value, Mapping):
            yield from _flat_columns(value, f"{start}{key}_")
        elif isinstance(value, list):
            yield from _flat_columns({str(k): x for k, x in enumerate(value, 1)}, f"{start}{key}_")
        elif value is not None:
            yield f"{start}{key}", value


#: Probabilities of the quantiles of an output.
QUANTILES = (0.01, 0.05, 0.5, 0.95, 0.99)


@result_record(kw_only=True)
class Statistics:
    """Statistics of one output over the samples of a sweep or the specimens of an ensemble, in the output's unit."""

    members: int | None = quantity_field("members", "number of specimens for which the value exists", default=None)
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
    band_resolution: float | None = quantity_field(
        "band_resolution_N", "sampling error of the quantiles of the contact loads", default=None
    )
    cases: Mapping[str, Ensemble] = field(default_factory=dict)
    """Statistics of each load case, by its name; empty without load cases."""

    @property
    def _shown_path(self) -> str:
        """Key of the part of the JSON that the table shows."""
        return "cases" if self.cases else "statistics"

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
            yield Panel(
                f"{where}{case}", "number of the ball", "contact load / N", series, include_zero=True, integer_x=True
            )


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

    @property
    def _notes(self) -> tuple[str, ...]:
        """Sentences printed below the table."""
        return self.notes

    def __repr__(self) -> str:
        """Return the first five lines of the table."""
        return "\n".join(str(self).splitlines()[:5])
