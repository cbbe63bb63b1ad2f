"""Results of `rollbench.friction`, `ensemble`, `mesh_study`, `sweep`, `survey` and `report`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from typing import Any, TypeAlias

from rollbench.compare.quantities import from_json
from rollbench.compare.results.base import JSON, Record, with_schema
from rollbench.meshes.quantity import Stated, quantity, record


@dataclass(frozen=True, eq=False, repr=False)
class Data(Record):
    """Result that is stored as the JSON of its command."""

    values: Mapping[str, JSON]
    """JSON of the command, without its version."""
    shown: str = ""
    """Path in the JSON of the part that tables show; empty: all."""
    notes: tuple[str, ...] = ()
    """Sentences below the table."""

    def to_dict(self) -> dict[str, JSON]:
        """Return the JSON that the command of the same name prints.

        Returns
        -------
        dict
            JSON values by key, the version first.
        """
        return with_schema(self.values)

    @property
    def _shown(self) -> str:
        return self.shown

    @property
    def _notes(self) -> tuple[str, ...]:
        return self.notes

    def __repr__(self) -> str:
        """Return the first five lines of the table."""
        return "\n".join(str(self).splitlines()[:5])


#: Values on the flanks SL, SR, NL, NR, by these names; None without contact.
Flanks: TypeAlias = Mapping[str, float | None]
#: Pairs of values across and along the groove, on the flanks SL, SR, NL, NR.
FlankPairs: TypeAlias = Mapping[str, Sequence[float | None]]


@record(kw_only=True)
class FrictionBall:
    """Motion and friction of one ball of a screw or bearing, and of its contacts.

    A field is None where this kind of scene has no such quantity.
    """

    index: int = quantity("index")
    orbit: float | None = quantity("orbit_rad_s", "speed of the ball's centre about the axis")
    rotation: Sequence[float] | None = quantity(
        "rotation_rad_s", "rotation of the ball about its centre: across, along, normal to its track", parts="[]"
    )
    closing: float | None = quantity("closing_mm_s", "speed at which the gap to the next ball closes")
    sliding: FlankPairs | None = quantity(
        "sliding_mm_s", "sliding at the contact's centre, across and along", parts=".FLANK[]"
    )
    spin: Flanks | None = quantity("spin_rad_s", "rotation about the contact's normal", parts=".FLANK")
    force: FlankPairs | None = quantity("friction_N", "friction force on the ball, across and along", parts=".FLANK[]")
    moment: Flanks | None = quantity("moment_Nmm", "friction moment about the normal", parts=".FLANK")
    loss: Flanks | None = quantity("loss_mW", "power lost in the contact", parts=".FLANK")
    at_rest: Mapping[str, bool] | None = quantity("at_rest", "whether the contact sticks", parts=".FLANK")


@record(kw_only=True)
class FrictionBand:
    """Friction torques at the least and largest coefficients of friction measured with lubricants, 0.003 and 0.1."""

    coefficients: Sequence[float] = quantity(
        "coefficients", "coefficients between which a lubricated screw lies, 0.003 to 0.1", parts="[]"
    )
    torque: Sequence[float | None] = quantity(
        "friction_torque_Nmm",
        "friction torque at both",
        parts="[]",
        heading="friction torque, lubricated",
        form="g3",
        note="coefficients {least} to {most}",
    )
    drag_torque: Sequence[float | None] | None = quantity("drag_torque_Nmm", "drag torque at both", parts="[]")
    preload: float | None = quantity("preload_N", "preload that the makers' formula takes")
    makers: float | None = quantity("makers_formula_Nmm", "0.05/sqrt(tan beta) F l/(2 pi), which makers print")


@record(kw_only=True)
class FrictionPlay:
    """Effect of axial play (by smaller balls) on the friction torque of a screw without stated preload or play."""

    smaller: float = quantity("smaller_by_um", "by how much the ball radii are made smaller to show what play does")
    torque: float | None = quantity("friction_torque_Nmm", "friction torque then")
    as_given: float | None = quantity("friction_torque_as_given_Nmm", "friction torque as the scene stands")


@record(kw_only=True)
class FrictionOnset:
    """Prediction whether neighbouring balls touch, from their speeds under the static loads.

    Balls without load stand still, unless a field says otherwise.
    """

    touch: bool = quantity(
        "touch",
        "whether neighbours meet before the leading one leaves its loaded arc (of a bearing, before the balls have gone "
        "round once); unloaded balls stand still",
    )
    first: float | None = quantity(
        "first_meeting_deg", "angle of the part that turns at which the first neighbours meet; null where none close in"
    )
    ball: int | None = quantity("ball", "the first of these two, at the smaller azimuth")
    rolling: float | None = quantity(
        "first_meeting_rolling_deg", "the same where unloaded balls roll along at the nominal speed"
    )
    closing: int = quantity("closing_pairs", "neighbours that close in")
    pairs: int = quantity("pairs", "neighbours in all circuits")
    unloaded: int = quantity("balls_without_load", "balls without load")
    factor: float | None = quantity(
        "error_factor",
        "factor on the scene's errors of grooves and of single balls from which on neighbours touch, 0 where they do "
        "without errors; null without errors, and where none is found up to 16",
        error="3 %",
    )


@record(kw_only=True)
class FrictionCases:
    """Friction over all load cases of a duty cycle."""

    largest: float | None = quantity("largest_friction_torque_Nmm", "friction torque of the case with the largest")
    case: str | None = quantity("largest_friction_torque_case", "its case")
    mean: float | None = quantity("mean_friction_torque_Nmm", "work of friction over the duty cycle, over the angle turned")
    words: str | None = quantity("mean_words", "why there is no mean")


@record(eq=False, repr=False, kw_only=True)
class Friction(Data):
    """Friction of a scene: ball motion, losses [W], torques [N m] and efficiencies [1].

    A field is None where this kind of scene has no such quantity, and where loads and friction do not balance.

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
    """Kind of the scene, such as ball screw or bearing; empty of load cases."""
    converged: bool
    """Whether loads and friction balance."""
    reason: str
    """Status: converged, or why not."""
    torque: float | None = quantity(
        "torque.friction_torque_Nmm",
        "torque of friction only, against the motion",
        error="proportional to the coefficient",
        heading="friction torque",
        form="g3",
    )
    torque_on_screw: float | None = quantity(
        "torque.friction_torque_on_screw_Nmm", "the same as it acts on the screw, with sign", error="as above"
    )
    torque_on_nut: float | None = quantity(
        "torque.friction_torque_on_nut_Nmm", "the same as it acts on the nut", error="as above"
    )
    drag_torque: float | None = quantity(
        "torque.drag_torque_Nmm",
        "friction torque without the scene's loads: by preload only",
        error="as above",
        heading="drag torque",
        form="g3",
    )
    axial_load: float | None = quantity("torque.axial_load_N", "axial load that the torque works against")
    driving_torque_on_screw: float | None = quantity(
        "torque.driving_torque_on_screw_Nmm",
        "torque that the screw must be given in the stated motion",
        error="friction's share of it",
    )
    driving_torque_on_nut: float | None = quantity(
        "torque.driving_torque_on_nut_Nmm", "the same for the nut", error="friction's share of it"
    )
    load_moves: str | None = quantity("torque.load_moves", "with or against the load")
    forward_torque: float | None = quantity(
        "torque.forward_torque_Nmm",
        "torque that moves the nut against the axial load: F l/(2 pi) + friction",
        error="friction's share of it",
        heading="torque against the load",
        form="g3",
    )
    backward_torque: float | None = quantity(
        "torque.backward_torque_Nmm",
        "torque that the load gives when it drives: F l/(2 pi) - friction",
        error="friction's share of it",
        heading="torque with the load",
        form="g3",
    )
    efficiency_forward: float | None = quantity(
        "torque.efficiency_forward_percent",
        "work on the load over work of the torque",
        error="1 - efficiency is proportional to the coefficient",
        heading="efficiency against the load",
        form="g3",
    )
    efficiency_backward: float | None = quantity(
        "torque.efficiency_backward_percent",
        "work of the torque over work of the load",
        error="as above",
        heading="efficiency with the load",
        form="g3",
    )
    self_locking: bool | None = quantity(
        "torque.self_locking", "whether the load cannot drive the screw", heading="self-locking"
    )
    screw_coefficient: float | None = quantity("friction.screw", "coefficient of friction in the screw's groove")
    nut_coefficient: float | None = quantity("friction.nut", "coefficient of friction in the nut's groove")
    turns: str | None = quantity("motion.turns", "which part turns")
    speed: float | None = quantity("motion.speed_rad_s", "its speed")
    loss: float | None = quantity(
        "losses.total_W",
        "power lost in all contacts",
        Stated("losses", "power lost between balls, and what Heathcote's slip would add", parts=".*"),
        Stated(
            "losses.by_contact_W",
            "power lost on one flank, and the shares of sliding across, along and of spin",
            parts="[].*",
        ),
        Stated("energy", "power of the driving torque, of the load, lost, and what is missing between them", parts=".*"),
        Stated(
            "feedback",
            "friction torque when friction does not move the balls in their grooves, and what that motion changes",
            parts=".*",
        ),
        heading="power lost",
        form="g3",
    )
    imbalance: float | None = quantity(
        "solver.friction_imbalance",
        "largest unbalanced force of a ball with friction over its load",
        Stated("solver.static_residual", "residual of the static solve under friction"),
        Stated("solver.feedback_change", "last change of the loads by friction"),
    )
    balls: tuple[FrictionBall, ...] = ()
    """Motion and friction of each ball; empty of load cases, and of kinds without such a list."""
    band: FrictionBand | None = None
    """Torques over the range of measured coefficients of friction; None where it was not computed."""
    onset: FrictionOnset | None = None
    """Contact of neighbouring balls; None if balls overlap or do not fit their circuits, and of several sets."""
    play: FrictionPlay | None = None
    """Effect of play; None if the scene states preload or play."""
    warnings: tuple[str, ...] = ()
    """Warnings where answers are outside the range of validity of the models."""
    cases: Mapping[str, Friction] = field(default_factory=dict)
    """Friction of each load case, by name; empty without load cases."""
    together: FrictionCases | None = None
    """Friction over all load cases; None without load cases."""


def friction_from_json(data: Mapping[str, Any]) -> Friction:
    """Convert the JSON of ``rollbench friction`` to a record.

    Parameters
    ----------
    data
        JSON of one scene, with its load cases under ``cases``.

    Returns
    -------
    Friction
        The record, in SI units.
    """
    converged, warnings = bool(data.get("converged")), tuple(map(str, data.get("warnings", ())))
    known = from_json(Friction, data if converged else {})
    for name in ("efficiency_forward", "efficiency_backward"):
        known[name] = None if known[name] is None else 1e-2 * known[name]
    if converged and known["loss"] is None:
        known["loss"] = (data.get("energy") or {}).get("loss_W")
    cases = {str(one["case"]): friction_from_json(one) for one in data.get("cases", ())}
    return Friction(
        values=data,
        shown="torque" if data.get("torque") else "",
        notes=warnings,
        scene=str(data["scene"]),
        kind=str(data.get("kind", "")),
        converged=converged,
        reason=str(data["status"]),
        **known,
        balls=tuple(FrictionBall(**from_json(FrictionBall, row)) for row in data.get("balls", ()) if converged),
        band=None if not data.get("band") else FrictionBand(**from_json(FrictionBand, data["band"])),
        onset=None if not data.get("onset") else FrictionOnset(**from_json(FrictionOnset, data["onset"])),
        play=None if not data.get("play") else FrictionPlay(**from_json(FrictionPlay, data["play"])),
        warnings=warnings,
        cases=cases,
        together=FrictionCases(**from_json(FrictionCases, data.get("summary") or {})) if cases else None,
    )


@dataclass(frozen=True)
class MeshLevel:
    """One mesh level of a mesh study of the 3D reference."""

    level: int
    """Number of the level; 1 is the coarsest."""
    cell_size: float
    """Size of the cells, relative to the finest level [1]."""
    unknowns: int
    """Number of unknowns of the whole mesh."""
    seconds: float
    """Run time [s]."""
    difference: float
    """Largest difference of a contact load from the finest level [% of the mean contact load]."""
    enough_for: float | None
    """Uncertainty of the contact loads, by this level and the coarser ones [% of the mean contact load]; of a
    roller in 3D of its approach, None with one level."""


@dataclass(frozen=True)
class MeshQuantity:
    """One quantity on the levels of a mesh study, such as the load of one contact."""

    name: str
    """Name of the quantity, such as ``largest load, SL``."""
    unit: str
    """Unit of the values."""
    values: tuple[float, ...]
    """Value on every level, coarsest first [unit]."""
    order: float | None
    """Observed order of convergence [1]; None if the values do not converge monotonically (contact loads scatter)."""
    extrapolated: float | None
    """Value extrapolated to zero cell size [unit]; None without order."""
    uncertainty: float | None
    """Uncertainty of the value on the finest level [unit]; None with a single level."""


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class MeshStudy(Data):
    """Results of the 3D reference on several mesh levels."""

    scene: str
    """Name of the scene."""
    levels: tuple[MeshLevel, ...] = ()
    """Mesh levels, coarsest first; empty of several sets."""
    quantities: tuple[MeshQuantity, ...] = ()
    """Quantities that are compared between the levels; empty of several sets."""
    sets: Mapping[str, MeshStudy] = field(default_factory=dict)
    """Studies of each of several sets on one shaft, by name; empty of one set."""


def mesh_study_of(data: Mapping[str, Any], shown: str = "", notes: Sequence[str] = ()) -> MeshStudy:
    """Convert the JSON of ``rollbench mesh-study`` to a record.

    Parameters
    ----------
    data
        JSON of one scene, with its sets under ``sets``.
    shown
        Path in the JSON of the part that tables show.
    notes
        Sentences below the table.

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
        sets={str(one["set"]): mesh_study_of(one, "levels") for one in data.get("sets", ())},
    )


@record
class Statistics:
    """Statistics of an output over the samples of a sweep or the specimens of an ensemble, in the output's unit."""

    mean: float = quantity("mean", "mean over the members", error="`standard_error`")
    standard_error: float = quantity(
        "standard_error", "of the mean: standard deviation over the root of the number of members"
    )
    standard_deviation: float = quantity("standard_deviation", "standard deviation over the members")
    smallest: float = quantity("smallest", "smallest value of a member")
    largest: float = quantity("largest", "largest value of a member")
    members: int | None = quantity("members", "members that have the value", default=None)
    quantiles: Mapping[float, float] = quantity(
        "quantiles", "level, value, and its 95 % interval, low and high", parts="[].*", show=dict, default_factory=dict
    )
    """Quantiles by probability: 0.01, 0.05, 0.5, 0.95, 0.99."""


@record(eq=False, repr=False, kw_only=True)
class Ensemble(Data):
    """Results over many specimens of a scene with random errors."""

    scene: str
    """Name of the scene."""
    members: int
    """Number of specimens, in each load case."""
    converged: int
    """Number of specimens with an equilibrium; of load cases the smallest."""
    outputs: Mapping[str, Statistics | None]
    """Statistics of each output by name; None with fewer than two values. Empty of load cases."""
    failed: Mapping[int, str]
    """Reason for each specimen without equilibrium, by its number from 0. Empty of load cases."""
    sets: Mapping[str, Mapping[str, Statistics | None]]
    """Statistics of each of several sets, by name of set and output; empty of one set."""
    contacts: tuple[Mapping[str, float | str], ...] = quantity(
        "balls",
        "of one contact over the members: load without random errors, mean, standard deviation, quantiles, share of "
        "members in which it is loaded",
        Stated(
            "balls[].quantile_0",
            "quantile of this contact's load over the members",
            error="`band_resolution_N`",
            parts=".*",
        ),
        error="`band_resolution_N`",
        parts="[].*",
        default=(),
    )
    """Statistics of every contact, in the units of the keys; empty of several sets and of load cases."""
    band_resolution: float | None = quantity("band_resolution_N", "sampling error of the bands below", default=None)
    cases: Mapping[str, Ensemble]
    """Ensemble of each load case, by name; empty without load cases."""


def ensemble_from_json(data: Mapping[str, Any]) -> Ensemble:
    """Convert the JSON of ``rollbench solve --members`` to a record.

    Parameters
    ----------
    data
        JSON of one scene, with its load cases under ``cases``.

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
        outputs=_outputs_from_json(data.get("statistics", {})),
        failed={one["member"]: one["status"] for one in data.get("failed", ())},
        sets={one["name"]: _outputs_from_json(one["statistics"]) for one in data.get("sets", ())},
        contacts=tuple(data.get("balls", ())),
        band_resolution=data.get("band_resolution_N"),
        cases=cases,
    )


def _outputs_from_json(each: Mapping[str, Any]) -> dict[str, Statistics | None]:
    """Return the statistics of outputs by name from JSON; None without statistics."""
    return {name: None if x is None else _statistics_from_json(x) for name, x in each.items()}


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Sweep(Data):
    """Results of a scene over sampled values of its keys."""

    folder: Path
    """Folder with every sample (``samples.csv``) and the summary."""
    solved: int
    """Number of samples."""
    converged: int
    """Number of samples with an equilibrium."""
    outputs: Mapping[str, Statistics | None]
    """Statistics of each output by name; None with fewer than two values."""
    sobol: Mapping[str, Mapping[str, float]]
    """Total Sobol index [1] by output and key; empty for other designs and with too few samples. Constant outputs are
    left out."""


def sweep_from_json(data: Mapping[str, Any], folder: Path) -> Sweep:
    """Convert the JSON summary of a sweep to a record.

    Parameters
    ----------
    data
        JSON of the summary.
    folder
        Folder of the sweep.

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
        outputs=_outputs_from_json(data["outputs"]),
        sobol={name: {key: x["total"] for key, x in of.items()} for name, of in indices.items() if of is not None},
    )


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Survey(Data):
    """Errors of models against stored 3D reference runs, on random ball screws within the range of catalogues."""

    screws: int
    """Number of screws with a stored reference."""
    median: Mapping[str, float]
    """Median over the solved screws of the error of the worst contact load [% of the mean load], by model."""
    largest: Mapping[str, float]
    """Largest error of the worst contact load over the solved screws [% of the mean load], by model."""
    rows: Mapping[str, tuple[Mapping[str, JSON], ...]]
    """Results of every screw by model, in the units of the keys; ``status`` is "converged" or says why there is none."""


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
        notes=(f"{data['screws']} of {data['of']} drawn screws have a stored reference, on level {data['level']}",),
        screws=data["screws"],
        median={name: median(x) for name, x in sizes.items() if x},
        largest={name: max(x) for name, x in sizes.items() if x},
        rows={name: tuple(rows) for name, rows in data["models"].items()},
    )


def _statistics_from_json(x: Mapping[str, Any]) -> Statistics:
    """Convert the JSON statistics of one output to a record."""
    quantiles = {float(k.removeprefix("quantile_")): v for k, v in x.items() if k.startswith("quantile_")}
    quantiles |= {float(one["level"]): one["value"] for one in x.get("quantiles", ())}
    return Statistics(**(from_json(Statistics, x) | {"quantiles": quantiles}))


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Written(Data):
    """Report that `rollbench.report` wrote."""

    page: Path
    """First page of the report."""
    passed: bool
    """False if a recomputed run of the 3D reference differs from the stored one."""
    verdict: str = ""
    """Verdict on the scene, in words; empty of a whole report."""
