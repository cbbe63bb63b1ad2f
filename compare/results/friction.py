"""Records of the friction of a screw, bearing or shaft that `rollbench.friction` returns, and their JSON."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, is_dataclass, replace
from functools import reduce
from typing import TYPE_CHECKING, Any, TypeAlias

from rollbench.compare.models.friction_torques import FrictionTorques, fraction_in_percent
from rollbench.compare.quantities import json_number, quantities_of_instance, record_as_json
from rollbench.compare.results.base import HEADINGS, JSON, Row, TabularRecord, add_schema_version, json_rows, known_values
from rollbench.compare.results.friction_run import TransientRun, transient_simulation_as_json
from rollbench.compare.results.rows import group_rows, record_rows
from rollbench.lowfi.warned import ResultWarning, join_brief_warnings
from rollbench.meshes.quantity import (
    QuantityDescription,
    quantity_descriptions,
    quantity_field,
    quantity_or_none,
    result_record,
)
from rollbench.reports.content import Figure, Panel, Series

if TYPE_CHECKING:
    from rollbench.compare.models.load_cases import AxisDrive
    from rollbench.lowfi.bearings.torque import RollerBearingTorque


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class InOrderOfKeys:
    """Record whose JSON depends on the kind of the scene: it has those fields whose keys are listed."""

    keys: Sequence[str] = field(repr=False)
    """Keys of the JSON in their order, joined by dots: the quantities that exist for the kind of scene."""

    def as_json(self) -> dict[str, Any]:
        """Return the fields with these keys as JSON."""
        known, out = quantities_of_instance(self), dict[str, Any]()
        for key in self.keys:
            *tables, last = key.split(".")
            reduce(lambda at, name: at.setdefault(name, {}), tables, out)[last] = known[key].value(self)
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

    set: int | None = quantity_or_none("set")
    """Number of the nut or bearing on the shaft, from 1; None for a single one."""
    index: int = quantity_field("index")
    """Number of the ball along its track, from 1."""
    state: str | None = quantity_or_none("state")
    """Of two balls of a screw: "apart" for balls that are far apart, "touching" for balls that touch each other."""
    azimuth: float | None = quantity_or_none("azimuth_deg")
    """Azimuth of the ball's centre [rad]."""
    z: float | None = quantity_or_none("z_mm")
    """Position of the ball's centre along the axis [m]."""
    load: Flanks = quantity_field("load_N", default_factory=dict)
    """Contact load on each flank, with friction [N]."""
    angle: Flanks = quantity_field("contact_angle_deg", default_factory=dict)
    """Contact angle on each flank [rad]; None for a flank without load."""
    semi_axes_across: Flanks | None = quantity_or_none("semi_axis_across_um")
    """Semi-axes of the contact ellipses across the groove [m], of one ball of a bearing."""
    semi_axes_along: Flanks | None = quantity_or_none("semi_axis_along_um")
    """Semi-axes of the contact ellipses along the groove [m], of one ball of a bearing."""
    side_force_ratio: float | None = quantity_or_none("side_force_ratio")
    """Force on a ball of a linear bearing across the track over that on it towards the bearing."""
    velocity_apart: float | None = quantity_or_none("velocity_apart_mm_s")
    """Velocity of a ball of a linear bearing whose balls are far apart [m/s]."""
    deviation_apart: float | None = quantity_or_none("deviation_apart_percent", show=fraction_in_percent)
    """Difference of this velocity from half the carriage's, as a fraction of the latter."""
    velocity_touching: float | None = quantity_or_none("velocity_touching_mm_s")
    """Velocity of a ball of a linear bearing whose balls touch [m/s]."""
    deviation_touching: float | None = quantity_or_none("deviation_touching_percent", show=fraction_in_percent)
    """Difference of this velocity from half the carriage's, as a fraction of the latter."""
    orbit: float | None = quantity_or_none("orbit_rad_s", "speed of the ball's centre about the axis")
    rotation: Sequence[float | None] | None = quantity_or_none(
        "rotation_rad_s", "rotation of the ball about its centre: across, along, normal to its track", parts="[]"
    )
    closing: float | None = quantity_or_none("closing_mm_s", "speed at which the gap to the next ball closes")
    sliding: FlankPairs | None = quantity_or_none(
        "sliding_mm_s", "sliding speed at the contact's centre, across and along the groove", parts=".FLANK[]"
    )
    spin: Flanks | None = quantity_or_none("spin_rad_s", "rotation about the contact's normal", parts=".FLANK")
    force: FlankPairs | None = quantity_or_none(
        "friction_N", "friction force on the ball, across and along the groove", parts=".FLANK[]"
    )
    moment: Flanks | None = quantity_or_none("moment_Nmm", "friction moment about the contact's normal", parts=".FLANK")
    loss: Flanks | None = quantity_or_none("loss_mW", "power lost in the contact", parts=".FLANK")
    at_rest: Mapping[str, bool] | None = quantity_or_none("at_rest", "whether the contact sticks", parts=".FLANK")
    groove_loss: float | None = quantity_or_none("groove_loss_mW")
    """Power lost in all contacts of the ball with its grooves [W]."""
    status: str | None = quantity_or_none("status")
    """How its motion was found, "failed" if it was not."""


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
        note="coefficients {coefficients[0]} to {coefficients[1]}",
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
    has_errors: bool = field(kw_only=True, default=False)
    """Whether the scene has such errors."""


@result_record(kw_only=True)
class FrictionCases:
    """Largest and mean friction torque over all load cases of a duty cycle."""

    largest: float | None = quantity_field(
        "largest_friction_torque_Nmm",
        "largest friction torque of any load case",
        heading="largest friction torque of all load cases",
        form="g3",
        note="case {largest_friction_torque_case}",
    )
    case: str | None = quantity_field("largest_friction_torque_case", "load case with the largest friction torque")
    mean: float | None = quantity_field(
        "mean_friction_torque_Nmm",
        "work of friction over the duty cycle, divided by the angle of rotation",
        heading="mean friction torque over the duty cycle",
        form="g3",
    )
    words: str | None = quantity_field(
        "mean_words", "reason why no mean friction torque can be computed", heading="mean friction torque"
    )


@result_record(eq=False, repr=False, kw_only=True)
class FrictionOfSet(FrictionTorques):
    """Friction of one nut or ball bearing on a shaft."""

    set: int = quantity_field("set")
    """Number of the nut or bearing on the shaft, from 1."""
    name: str = quantity_field("name")
    """Name of the nut or bearing."""
    loss: float = quantity_field("loss_W")
    """Power lost in its contacts [W]."""

    def as_json(self) -> dict[str, Any]:
        """Return the record as JSON.

        Returns
        -------
        dict[str, Any]
            Number, name, torques, efficiencies and loss.
        """
        torques = self.torques_as_json()
        return {"set": self.set, "name": self.name, **torques, "loss_W": json_number(self.loss)}


@result_record(kw_only=True)
class FrictionOfRollers:
    """Friction torque of a row of tapered rollers on a shaft, by the formulas of makers."""

    set: int
    """Number of the row on the shaft, from 1."""
    name: str = quantity_field("name")
    """Name of the row."""
    torque: RollerBearingTorque
    """Its friction torque by each formula."""

    def as_json(self) -> dict[str, Any]:
        """Return number, name and torques as JSON."""
        return {"set": self.set, "name": self.name, **record_as_json(self.torque)}


@result_record(eq=False, repr=False, kw_only=True)
class FrictionAtCoefficients(FrictionTorques):
    """Torques and efficiencies for one pair of coefficients of friction."""

    screw: float = quantity_field("screw")
    """Coefficient of friction in the screw's groove."""
    nut: float
    """Coefficient of friction in the nut's groove."""
    keys: Sequence[str]
    """Keys of the torques that its JSON has."""

    def as_json(self) -> dict[str, Any]:
        """Return the record as JSON.

        Returns
        -------
        dict[str, Any]
            Coefficients and torques.
        """
        return {"screw": self.screw, "nut": self.nut, **self.torques_as_json(self.keys)}


@result_record
class FlankLosses:
    """Power lost on one groove flank of all balls, or on all flanks."""

    set: int | None = quantity_field("set", optional=True)
    """Number of the nut or bearing on the shaft, from 1; None for a single one."""
    contact: str = quantity_field("contact")
    """Name of the flank: SL, SR, NL, NR (screw left and right, nut left and right), or "sum" for all of them."""
    mean_load: float | None = quantity_field("mean_load_N", "mean load of the balls that press on the flank")
    bare_load: float | None = quantity_field(
        "mean_load_without_friction_N", "the same mean load if friction does not change the loads"
    )
    loss: float = quantity_field("loss_W", "power lost on the flank")
    sliding_across: float = quantity_field("sliding_across", "share of the power by sliding across the groove [W]")
    sliding_along: float = quantity_field("sliding_along", "share of the power by sliding along the groove [W]")
    spin: float = quantity_field("spin", "share of the power by spin [W]")
    curved: float | None = quantity_or_none(
        "with_curvature_W", "power lost if the contacts are curved across the groove", optional=True
    )
    """Power lost in curved contacts [W]; nan if no motion of such contacts was found, None if it was not computed."""


@result_record(kw_only=True)
class BallsTouching:
    """Forces between touching balls, and their effect on the friction torque."""

    pairs: int = quantity_field("pairs")
    """Number of pairs that touch."""
    gap: float = quantity_field("smallest_gap_um")
    """Smallest gap between neighbouring balls [m]."""
    force: Sequence[float] = quantity_field("force_on_next_N")
    """Force of each ball on the next one [N]."""
    loss: float = quantity_field("loss_W")
    """Power lost between the balls [W]."""
    torque_change: float | None = quantity_field("friction_torque_change_percent")
    """Change of the friction torque by these forces [%]."""


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
    model: str | None = quantity_or_none("model")
    """Model that computed the contact loads."""
    member: int | None = quantity_or_none("member")
    """Number of the specimen; None without random errors."""
    case: str | None = quantity_or_none("case")
    """Name of the load case."""
    share: float | None = quantity_or_none("share")
    """Share of the load case in all revolutions of its duty cycle."""
    converged: bool = quantity_field("converged")
    """Whether a motion was found in which the contact loads and the friction forces balance."""
    reason: str = quantity_field("status")
    """The word "converged", or the reason why the computation did not converge."""
    screw_coefficient: float | None = quantity_or_none("friction.screw", "coefficient of friction in the screw's groove")
    nut_coefficient: float | None = quantity_or_none("friction.nut", "coefficient of friction in the nut's groove")
    turns: str | None = quantity_or_none("motion.turns", "which part turns, such as screw or nut")
    speed: float | None = quantity_or_none(
        "motion.speed_rad_s",
        "speed of the part that turns",
        QuantityDescription("speed_rpm", show=lambda speed: speed and abs(speed)),
    )
    law: str | None = quantity_or_none("law")
    """Name of the law of friction."""
    coupled: bool | None = quantity_or_none("coupled")
    """Whether friction changes the contact loads."""
    loss: float | None = quantity_or_none(
        "losses.total_W",
        "power lost in all contacts",
        QuantityDescription("energy.loss_W", "power lost in all contacts"),
        heading="power lost",
        form="g3",
        note="at {speed_rpm} rpm",
    )
    by_contact: tuple[FlankLosses, ...] = quantity_field("losses.by_contact_W", default=())
    """Power lost on each flank; of a shaft, of each nut and ball bearing."""
    loss_between_balls: float | None = quantity_or_none("losses.between_balls_W", "power lost between balls")
    slip: float | None = quantity_or_none(
        "losses.heathcote_percent", "change of the power by Heathcote slip", show=fraction_in_percent
    )
    """Power lost in contacts that are curved over that in flat contacts, less 1; nan if one of them is not known."""
    input_power: float | None = quantity_or_none("energy.input_power_W", "power that the contacts take from screw and nut")
    power_balance: float | None = quantity_or_none(
        "energy.balance_W", "error of the balance: power that the contacts take, less the power lost"
    )
    power_balance_percent: float | None = quantity_or_none("energy.balance_percent")
    """Error of the balance [% of the power lost]; None if that power is round-off."""
    load_power: float | None = quantity_or_none("energy.axial_load_power_W", "power of the axial load")
    torque_power: float | None = quantity_or_none("energy.torque_power_W", "power of the driving torque")
    power_efficiency: float | None = quantity_or_none(
        "energy.efficiency_percent",
        "power that leaves by torque or axial load, divided by the power that enters by the other",
    )
    torque_without_feedback: float | None = quantity_or_none(
        "feedback.friction_torque_without_Nmm", "friction torque if friction did not move the balls in their grooves"
    )
    unsettled_balls: int | None = quantity_or_none(
        "feedback.unsettled_balls", "number of balls whose friction and position do not agree"
    )
    axial_friction: float | None = quantity_or_none(
        "feedback.axial_friction_on_screw_N", "force of friction on the screw along its axis"
    )
    touching: BallsTouching | None = quantity_or_none("feedback.balls_touching")
    """Forces between touching balls; None if they are not computed."""
    friction_over_load: float | None = quantity_or_none(
        "feedback.friction_over_load",
        "largest ratio of the friction on a ball across its groove to the largest load of this ball",
    )
    residual: float | None = quantity_or_none(
        "solver.static_residual", "residual of the static equilibrium with friction forces"
    )
    imbalance: float | None = quantity_or_none(
        "solver.friction_imbalance", "largest unbalanced force on a ball, friction included, divided by its load"
    )
    change: float | None = quantity_or_none(
        "solver.feedback_change", "change of the loads by friction in the last iteration"
    )
    jammed_balls: tuple[int, ...] | None = quantity_or_none("solver.second_states")
    """Numbers of the balls that have a second, jammed state; None if it was not searched for."""
    balls: tuple[FrictionBall, ...] = quantity_field("balls", show=rows_as_json, default=())
    """Motion and friction of each ball; empty if the scene has load cases, or if its kind has no results for each ball."""
    sets: tuple[FrictionOfSet, ...] | None = quantity_or_none("sets", show=rows_as_json)
    """Friction of each nut and ball bearing on a shaft."""
    drive: AxisDrive | None = quantity_or_none("drive")
    """Torques and moments of inertia at the motor of a feed axis."""
    band: FrictionBand | None = quantity_or_none("band")
    """Torques over the range of measured coefficients of friction, and drag torque by the makers' formula; None without."""
    onset: FrictionOnset | None = quantity_or_none("onset")
    """Prediction whether neighbouring balls come into contact; None if balls overlap or do not fit into their circuits,
    and for several nuts or bearings on one shaft."""
    play: FrictionPlay | None = quantity_or_none("play")
    """Effect of axial play; None if the scene states preload or play."""
    drag_unknown: str | None = quantity_or_none("drag_unknown")
    """Reason why no drag torque is known; None if it is known."""
    drag_note: str | None = quantity_or_none("drag_note")
    """Remark on the drag torque; None without."""
    over: tuple[FrictionAtCoefficients, ...] = quantity_field("over_friction", show=rows_as_json, default=())
    """Torques for each of the coefficients of friction that were asked for."""
    roller_torques: tuple[FrictionOfRollers, ...] = quantity_field("roller_torques", show=rows_as_json, default=())
    """Friction torques of the rows of tapered rollers on a shaft."""
    run: TransientRun | None = quantity_or_none(
        "run", show=lambda run: None if run is None else transient_simulation_as_json(run)
    )
    """Simulation over time; None if the scene has no table [time]."""
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
    together: FrictionCases | None = quantity_or_none("summary")
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
    def _notes(self) -> tuple[str, ...]:
        """Sentences printed below the table."""
        return self.warnings

    headings = HEADINGS

    def table(self) -> Sequence[Row]:
        """Return the rows of the table that notebooks and ``print`` show: all values of the whole scene.

        Returns
        -------
        Sequence[Row]
            A row for each quantity, such as the friction torque.
        """
        return self.rows(details=True)

    def rows(self, *, details: bool = False) -> list[Row]:
        """Return the rows of the table of results: of a whole screw or bearing, or of several on one shaft.

        Parameters
        ----------
        details
            Whether to include quantities that a designer seldom needs.

        Returns
        -------
        list[Row]
            The rows; those of single parts always have all quantities.
        """
        details = details or type(self) is not Friction
        whole = self if details or self.speed is not None else replace(self, loss=None)
        groups = {} if self.sets == () and not details else {"": whole}
        groups |= {x.key.split(".")[-1]: getattr(self, name) for name, x in quantity_descriptions(type(self)) if not x.show}
        records = {key: x for key, x in groups.items() if is_dataclass(x) and key != "drive"}
        rows = [row for key, record in records.items() for row in group_rows(record, key, details=details)]
        rows += record_rows({"drive": self.drive}, None, (self,), details=details)
        if self.run is None or not details:
            return rows
        return [*rows, *json_rows(transient_simulation_as_json(self.run), "over time")]

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
            return [known_values(record_as_json(ball)) for ball in self.balls]
        return [{f"{name}_Nmm": 1e3 * value for name, value in self._torques().items()}]

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
        panel = Panel("torques", "torque", "", (bars,), include_zero=True, ordinate_names=names)
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
                yield Panel(title, "number_of_ball", "power lost / mW", series, include_zero=True, integer_x=True)
