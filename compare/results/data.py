"""Records that `rollbench.friction`, `ensemble`, `mesh_study`, `sweep`, `survey` and `report` return."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from typing import Any, TypeAlias

from rollbench.compare.quantities import fields_from_json
from rollbench.compare.results.base import JSON, Record, add_schema_version
from rollbench.meshes.quantity import QuantityDescription, quantity_field, result_record


@dataclass(frozen=True, eq=False, repr=False)
class Data(Record):
    """Result of a library function; it contains the JSON output of the command of the same name."""

    values: Mapping[str, JSON]
    """JSON values that the command prints, without the version number of the output."""
    shown: str = ""
    """Key of the part of `values` that the table shows, such as ``torque``; if empty, the table shows all values."""
    notes: tuple[str, ...] = ()
    """Sentences printed below the table."""

    def to_dict(self) -> dict[str, JSON]:
        """Return the result as a dictionary, as the command of the same name prints it with ``--json``.

        Returns
        -------
        dict
            JSON values by key; the first key, ``schema``, has the version number of the JSON format.
        """
        return add_schema_version(self.values)

    @property
    def _shown_path(self) -> str:
        """Key of the part of the JSON that the table shows; empty for the whole JSON."""
        return self.shown

    @property
    def _notes(self) -> tuple[str, ...]:
        """Sentences printed below the table."""
        return self.notes

    def __repr__(self) -> str:
        """Return the first five lines of the table."""
        return "\n".join(str(self).splitlines()[:5])


#: A value for each groove flank of a ball, by the flank's name SL, SR, NL or NR; None without contact.
Flanks: TypeAlias = Mapping[str, float | None]
#: Two components, across and along the groove, for each groove flank of a ball, by the flank's name SL, SR, NL or NR.
FlankPairs: TypeAlias = Mapping[str, Sequence[float | None]]


@result_record(kw_only=True)
class FrictionBall:
    """Motion of one ball of a screw or bearing, and the friction in its contacts.

    A field is None if the quantity does not exist for this kind of scene.
    """

    index: int = quantity_field("index")
    """Number of the ball along its track, from 1."""
    orbit: float | None = quantity_field("orbit_rad_s", "speed of the ball's centre about the axis")
    rotation: Sequence[float] | None = quantity_field(
        "rotation_rad_s", "rotation of the ball about its centre: across, along, normal to its track", parts="[]"
    )
    closing: float | None = quantity_field("closing_mm_s", "speed at which the gap to the next ball closes")
    sliding: FlankPairs | None = quantity_field(
        "sliding_mm_s", "sliding speed at the contact's centre, across and along the groove", parts=".FLANK[]"
    )
    spin: Flanks | None = quantity_field("spin_rad_s", "rotation about the contact's normal", parts=".FLANK")
    force: FlankPairs | None = quantity_field(
        "friction_N", "friction force on the ball, across and along the groove", parts=".FLANK[]"
    )
    moment: Flanks | None = quantity_field("moment_Nmm", "friction moment about the contact's normal", parts=".FLANK")
    loss: Flanks | None = quantity_field("loss_mW", "power lost in the contact", parts=".FLANK")
    at_rest: Mapping[str, bool] | None = quantity_field("at_rest", "whether the contact sticks", parts=".FLANK")


@result_record(kw_only=True)
class FrictionBand:
    """Friction torques at the smallest and largest coefficient of sliding friction with lubricants, 0.03 and 0.1."""

    coefficients: Sequence[float] = quantity_field(
        "coefficients", "smallest and largest coefficient of sliding friction with lubricants, 0.03 and 0.1", parts="[]"
    )
    torque: Sequence[float | None] = quantity_field(
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
        "makers_formula_Nmm", "drag torque by the formula of screw makers, 0.05/sqrt(tan beta) F l/(2 pi)"
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
class Friction(Data):
    """Friction in a scene: motion of the balls, power losses [W], torques [N m] and efficiencies [1].

    A field is None if the quantity does not exist for this kind of scene, or if no motion was found in which the contact
    loads and the friction forces balance.

    Examples
    --------
    >>> import rollbench
    >>> found = rollbench.friction("lin-case1", model="lin")
    >>> round(found.loss, 2), len(found.balls), round(found.balls[0].orbit, 3)  # W, -, rad/s
    (5.27, 32, 2.763)
    """

    scene: str
    """Name of the scene."""
    kind: str
    """Kind of the scene, such as ball screw or bearing; empty if it has load cases."""
    converged: bool
    """Whether a motion was found in which the contact loads and the friction forces balance."""
    reason: str
    """The word "converged", or the reason why the computation did not converge."""
    torque: float | None = quantity_field(
        "torque.friction_torque_Nmm",
        "torque of the friction forces only; it opposes the motion",
        error="proportional to the coefficient",
        heading="friction torque",
        form="g3",
    )
    reverse_torque: float | None = quantity_field(
        "torque.reverse_friction_torque_Nmm",
        "torque of the friction forces in the reversed motion",
        error="that of the friction torque",
        heading="friction torque, reversed",
        form="g3",
    )
    torque_on_screw: float | None = quantity_field(
        "torque.friction_torque_on_screw_Nmm",
        "friction torque that acts on the screw, with sign",
        error="that of the friction torque",
    )
    torque_on_nut: float | None = quantity_field(
        "torque.friction_torque_on_nut_Nmm",
        "friction torque that acts on the nut, with sign",
        error="that of the friction torque",
    )
    drag_torque: float | None = quantity_field(
        "torque.drag_torque_Nmm",
        "friction torque without the scene's external loads, from the preload only",
        error="proportional to the coefficient",
        heading="drag torque",
        form="g3",
    )
    axial_load: float | None = quantity_field("torque.axial_load_N", "axial load against which the torque works")
    driving_torque_on_screw: float | None = quantity_field(
        "torque.driving_torque_on_screw_Nmm",
        "torque that drives the screw in the stated motion",
        error="friction's share of it",
    )
    driving_torque_on_nut: float | None = quantity_field(
        "torque.driving_torque_on_nut_Nmm",
        "torque that drives the nut in the stated motion",
        error="friction's share of it",
    )
    load_moves: str | None = quantity_field("torque.load_moves", "whether the motion is with or against the axial load")
    forward_torque: float | None = quantity_field(
        "torque.forward_torque_Nmm",
        "torque that moves the nut against the axial load: F l/(2 pi) + friction",
        error="friction's share of it",
        heading="torque against the load",
        form="g3",
    )
    backward_torque: float | None = quantity_field(
        "torque.backward_torque_Nmm",
        "torque that the axial load delivers when it drives the screw: F l/(2 pi) - friction",
        error="friction's share of it",
        heading="torque with the load",
        form="g3",
    )
    efficiency_forward: float | None = quantity_field(
        "torque.efficiency_forward_percent",
        "work done on the axial load, divided by the work of the driving torque",
        error="1 - efficiency is proportional to the coefficient",
        heading="efficiency against the load",
        form="g3",
    )
    efficiency_backward: float | None = quantity_field(
        "torque.efficiency_backward_percent",
        "work of the torque that the screw delivers, divided by the work of the axial load",
        error="1 - efficiency is proportional to the coefficient",
        heading="efficiency with the load",
        form="g3",
    )
    self_locking: bool | None = quantity_field(
        "torque.self_locking", "whether the screw is self-locking: the axial load cannot turn it", heading="self-locking"
    )
    screw_coefficient: float | None = quantity_field("friction.screw", "coefficient of friction in the screw's groove")
    nut_coefficient: float | None = quantity_field("friction.nut", "coefficient of friction in the nut's groove")
    turns: str | None = quantity_field("motion.turns", "which part turns, such as screw or nut")
    speed: float | None = quantity_field("motion.speed_rad_s", "speed of the part that turns")
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
        heading="power lost",
        form="g3",
        note="at {speed_rpm} rpm",
    )
    imbalance: float | None = quantity_field(
        "solver.friction_imbalance",
        "largest unbalanced force on a ball, friction included, divided by its load",
        QuantityDescription("solver.static_residual", "residual of the static equilibrium with friction forces"),
        QuantityDescription("solver.feedback_change", "change of the loads by friction in the last iteration"),
    )
    balls: tuple[FrictionBall, ...] = ()
    """Motion and friction of each ball; empty if the scene has load cases, or if its kind has no results for each ball."""
    band: FrictionBand | None = None
    """Torques over the range of measured coefficients of friction; None if they were not computed."""
    onset: FrictionOnset | None = None
    """Prediction whether neighbouring balls come into contact; None if balls overlap or do not fit into their circuits,
    and for several nuts or bearings on one shaft."""
    play: FrictionPlay | None = None
    """Effect of axial play; None if the scene states preload or play."""
    warnings: tuple[str, ...] = ()
    """Warnings about results outside the models' range of validity."""
    cases: Mapping[str, Friction] = field(default_factory=dict)
    """Friction in each load case, by name; empty without load cases."""
    together: FrictionCases | None = None
    """Largest and mean friction torque over all load cases; None without load cases."""


def friction_record_from_json(data: Mapping[str, Any]) -> Friction:
    """Convert the JSON of ``rollbench friction`` to a record.

    Parameters
    ----------
    data
        JSON of one scene, with the values of its load cases at the key ``cases``.

    Returns
    -------
    Friction
        The record, in SI units.
    """
    converged, warnings = bool(data.get("converged")), tuple(map(str, data.get("warnings", ())))
    known = fields_from_json(Friction, data if converged else {})
    for name in ("efficiency_forward", "efficiency_backward"):
        known[name] = None if known[name] is None else 1e-2 * known[name]
    if converged and known["loss"] is None:
        known["loss"] = (data.get("energy") or {}).get("loss_W")
    cases = {str(one["case"]): friction_record_from_json(one) for one in data.get("cases", ())}
    return Friction(
        values=data,
        shown="torque" if data.get("torque") else "",
        notes=warnings,
        scene=str(data["scene"]),
        kind=str(data.get("kind", "")),
        converged=converged,
        reason=str(data["status"]),
        **known,
        balls=tuple(FrictionBall(**fields_from_json(FrictionBall, row)) for row in data.get("balls", ()) if converged),
        band=None if not data.get("band") else FrictionBand(**fields_from_json(FrictionBand, data["band"])),
        onset=None if not data.get("onset") else FrictionOnset(**fields_from_json(FrictionOnset, data["onset"])),
        play=None if not data.get("play") else FrictionPlay(**fields_from_json(FrictionPlay, data["play"])),
        warnings=warnings,
        cases=cases,
        together=FrictionCases(**fields_from_json(FrictionCases, data.get("summary") or {})) if cases else None,
    )


@dataclass(frozen=True)
class MeshLevel:
    """One mesh level of a mesh study of the 3D reference."""

    level: int
    """Number of the level; 1 is the coarsest."""
    cell_size: float
    """Ratio of the cell size on this level to that on the finest level [1]."""
    unknowns: int
    """Number of unknowns (displacements of nodes) of the whole mesh."""
    seconds: float
    """Computing time of the 3D reference on this mesh level [s]."""
    difference: float
    """Largest difference of a contact load from the finest level [% of the mean contact load]."""
    enough_for: float | None
    """Uncertainty of the contact loads [% of the mean contact load], estimated from this level and the coarser levels. For
    a single roller in 3D: uncertainty of its elastic approach [%]. None if there is only one level."""


@dataclass(frozen=True)
class MeshQuantity:
    """Values of one quantity, such as the load of one contact, on the levels of a mesh study."""

    name: str
    """Name of the quantity, such as ``largest load, SL``."""
    unit: str
    """Unit of the values."""
    values: tuple[float, ...]
    """Value on every mesh level, coarsest first [unit]."""
    order: float | None
    """Observed order of convergence [1]; None if the values do not converge monotonically (contact loads often do not)."""
    extrapolated: float | None
    """Value extrapolated to zero cell size [unit]; None if no order of convergence was observed."""
    uncertainty: float | None
    """Uncertainty of the value on the finest level [unit]; None with a single level."""


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class MeshStudy(Data):
    """Mesh study of a scene: contact loads and other results of the 3D reference on several mesh levels."""

    scene: str
    """Name of the scene."""
    levels: tuple[MeshLevel, ...] = ()
    """Mesh levels, coarsest first; empty if the scene has several nuts or bearings."""
    quantities: tuple[MeshQuantity, ...] = ()
    """Quantities that are compared between the levels; empty if the scene has several nuts or bearings."""
    sets: Mapping[str, MeshStudy] = field(default_factory=dict)
    """Mesh study of each nut or bearing on a shaft with several, by name; empty for a single nut or bearing."""


def mesh_study_from_json(data: Mapping[str, Any], shown: str = "", notes: Sequence[str] = ()) -> MeshStudy:
    """Convert the JSON of ``rollbench mesh-study`` to a record.

    Parameters
    ----------
    data
        JSON of one scene, with the values of each nut or bearing at the key ``sets`` if it has several.
    shown
        Key of the part of the JSON that the table shows; if empty, the table shows all values.
    notes
        Sentences printed below the table.

    Returns
    -------
    MeshStudy
        The record.
    """
    rows = data.get("levels", ())
    levels = [
        MeshLevel(x["level"], x["cell_size"], x["unknowns"], x["seconds"], x["difference_percent"], x["enough_for_percent"])
        for x in rows
    ]
    quantities = [
        MeshQuantity(
            x["quantity"],
            x["unit"],
            tuple(x[f"level {row['level']}"] for row in rows),
            x.get("order"),
            x.get("extrapolated"),
            x.get("uncertainty"),
        )
        for x in data.get("quantities", ())
    ]
    return MeshStudy(
        values=data,
        shown=shown,
        notes=tuple(notes),
        scene=str(data["scene"]),
        levels=tuple(levels),
        quantities=tuple(quantities),
        sets={str(one["set"]): mesh_study_from_json(one, "levels") for one in data.get("sets", ())},
    )


@result_record
class Statistics:
    """Statistics of one output over the samples of a sweep or the specimens of an ensemble, in the output's unit."""

    mean: float = quantity_field("mean", "mean over the specimens", error="`standard_error`")
    standard_error: float = quantity_field(
        "standard_error",
        "standard error of the mean: standard deviation divided by the square root of the number of specimens",
    )
    standard_deviation: float = quantity_field("standard_deviation", "standard deviation over the specimens")
    smallest: float = quantity_field("smallest", "smallest value of any specimen")
    largest: float = quantity_field("largest", "largest value of any specimen")
    members: int | None = quantity_field("members", "number of specimens for which the value exists", default=None)
    quantiles: Mapping[float, float] = quantity_field(
        "quantiles",
        "probability, value of the quantile, and the limits of its 95 % confidence interval, low and high",
        parts="[].*",
        show=dict,
        default_factory=dict,
    )
    """Quantiles of the output, by their probability: 0.01, 0.05, 0.5, 0.95, 0.99."""


@result_record(eq=False, repr=False, kw_only=True)
class Ensemble(Data):
    """Statistics of the results over many specimens of a scene with random geometric errors."""

    scene: str
    """Name of the scene."""
    members: int
    """Number of specimens in each load case."""
    converged: int
    """Number of specimens with an equilibrium; with load cases, the smallest such number of any case."""
    outputs: Mapping[str, Statistics | None]
    """Statistics of each output, by its name; None if fewer than two specimens have a value. Empty if the scene has load
    cases."""
    failed: Mapping[int, str]
    """For each specimen without equilibrium, by its number from 0, the reason why it has none. Empty if the scene has load
    cases."""
    sets: Mapping[str, Mapping[str, Statistics | None]]
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
    cases: Mapping[str, Ensemble]
    """Statistics of each load case, by its name; empty without load cases."""


def ensemble_from_json(data: Mapping[str, Any]) -> Ensemble:
    """Convert the JSON of ``rollbench solve --members`` to a record.

    Parameters
    ----------
    data
        JSON of one scene, with the values of its load cases at the key ``cases``.

    Returns
    -------
    Ensemble
        The record.
    """
    cases = {str(one["case"]): ensemble_from_json(one) for one in data.get("cases", ())}
    return Ensemble(
        values=data,
        shown="cases" if cases else "statistics",
        scene=str(data["scene"]),
        members=data["members"] if not cases else min(one.members for one in cases.values()),
        converged=data["converged"] if not cases else min(one.converged for one in cases.values()),
        outputs=_output_statistics_from_json(data.get("statistics", {})),
        failed={one["member"]: one["status"] for one in data.get("failed", ())},
        sets={one["name"]: _output_statistics_from_json(one["statistics"]) for one in data.get("sets", ())},
        contacts=tuple(data.get("balls", ())),
        band_resolution=data.get("band_resolution_N"),
        cases=cases,
    )


def _output_statistics_from_json(each: Mapping[str, Any]) -> dict[str, Statistics | None]:
    """Convert the JSON statistics of several outputs to records; None for an output without statistics.

    ``each``: JSON statistics by the name of the output, such as ``largest_load_N``.
    """
    return {name: None if x is None else _statistics_from_json(x) for name, x in each.items()}


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Sweep(Data):
    """Statistics of a scene's results over sampled values of its parameters."""

    folder: Path
    """Folder with every sample (``samples.csv``) and the summary."""
    solved: int
    """Number of samples."""
    converged: int
    """Number of samples with an equilibrium."""
    outputs: Mapping[str, Statistics | None]
    """Statistics of each output, by its name; None if fewer than two samples have a value."""
    sobol: Mapping[str, Mapping[str, float]]
    """Total Sobol index [1], by the name of the output and the key of the parameter. Outputs that do not vary are left out;
    empty if the samples are no Sobol design, or too few."""


def sweep_from_json(data: Mapping[str, Any], folder: Path) -> Sweep:
    """Convert the JSON summary of a sweep to a record.

    Parameters
    ----------
    data
        JSON of the summary.
    folder
        Folder with the samples of the sweep.

    Returns
    -------
    Sweep
        The record.
    """
    indices = data["indices"].get("outputs", {})
    return Sweep(
        values=data,
        shown="outputs",
        notes=(f"{data['converged']} of {data['solved']} samples converged: {folder}",),
        folder=folder,
        solved=data["solved"],
        converged=data["converged"],
        outputs=_output_statistics_from_json(data["outputs"]),
        sobol={name: {key: x["total"] for key, x in of.items()} for name, of in indices.items() if of is not None},
    )


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Survey(Data):
    """Errors of models against stored runs of the 3D reference, on randomly drawn ball screws of catalogue dimensions.

    The error of a model on one screw is that of its worst contact load [% of the mean contact load].
    """

    screws: int
    """Number of randomly drawn screws for which a run of the 3D reference is stored."""
    median: Mapping[str, float]
    """Median of a model's errors on the screws that it solved [%], by the model's name."""
    largest: Mapping[str, float]
    """Largest of a model's errors on the screws that it solved [%], by the model's name."""
    rows: Mapping[str, tuple[Mapping[str, JSON], ...]]
    """Results of a model for every screw, by the model's name, in the units that the keys end with. ``status`` is
    "converged", or the reason why the screw was not solved."""


def survey_from_json(data: Mapping[str, Any]) -> Survey:
    """Convert the JSON of ``rollbench survey`` to a record.

    Parameters
    ----------
    data
        JSON of the survey.

    Returns
    -------
    Survey
        The record.
    """
    sizes = {
        name: [float(row["largest_percent"]) for row in rows if row["status"] == "converged"]
        for name, rows in data["models"].items()
    }
    return Survey(
        values=data,
        shown="summary",
        notes=(f"{data['screws']} of {data['of']} random screws have a stored reference, on level {data['level']}",),
        screws=data["screws"],
        median={name: median(x) for name, x in sizes.items() if x},
        largest={name: max(x) for name, x in sizes.items() if x},
        rows={name: tuple(rows) for name, rows in data["models"].items()},
    )


def _statistics_from_json(x: Mapping[str, Any]) -> Statistics:
    """Convert the JSON statistics of one output to a record.

    Quantiles are read from the keys ``quantile_0.05`` etc. of a sweep, or from the list ``quantiles`` of an ensemble.
    """
    quantiles = {float(k.removeprefix("quantile_")): v for k, v in x.items() if k.startswith("quantile_")}
    quantiles |= {float(one["level"]): one["value"] for one in x.get("quantiles", ())}
    return Statistics(**(fields_from_json(Statistics, x) | {"quantiles": quantiles}))


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Written(Data):
    """Path of a report that `rollbench.report` wrote, with the verdict that the report gives on the scene.

    It is true if the report passed (`passed`).
    """

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
