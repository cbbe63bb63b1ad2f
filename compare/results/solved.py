"""Records that `rollbench.solve` returns: contact loads, displacement, stiffness and life of a scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rollbench.compare.models.answers import LoadResults, NutOrBearingResults, RollerLoadResults
from rollbench.compare.models.load_cases import DutyCycleResults, SceneSolution, ShaftSolution
from rollbench.compare.models.programs import model_title
from rollbench.compare.models.stiffness import LoadPointStiffness, NutStiffness
from rollbench.compare.results.base import JSON, Record, Row, add_schema_version, format_table_as_html, warn_of_deprecation
from rollbench.compare.results.rows import bearing_and_nut_rows, duty_cycle_rows, expected_error_sentence, solution_rows
from rollbench.compare.results.scene_json import duty_cycle_json, solved_case_json
from rollbench.compare.scenes.duty_cycle import DutyCycle
from rollbench.lowfi.rating.contacts import BallContact, contact_pressures
from rollbench.lowfi.statics.result import SetResult as SolvedSet
from rollbench.lowfi.statics.result import StaticResult
from rollbench.lowfi.statics.tangent import TangentStiffness
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import SIDES, Scene
from rollbench.meshes.quantity import quantity_field, result_record

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

    from rollbench.compare.models import loading
    from rollbench.compare.models.load_cases import AxisDrive
    from rollbench.compare.models.model_form import ExpectedModelErrors
    from rollbench.lowfi.bearings.tapered_roller import RibContact
    from rollbench.lowfi.bearings.torque import BallBearingTorque, RollerBearingTorque
    from rollbench.lowfi.rating import life as rating
    from rollbench.lowfi.rating.catalogue_checks import ShaftLimits
    from rollbench.lowfi.rating.iso_lives import ModifiedLife, ReferenceLife
    from rollbench.lowfi.rating.life import SystemLife


class Status(StrEnum):
    """Outcome of the search for an equilibrium."""

    CONVERGED = "converged"
    """An equilibrium was found; all fields of the result may be used."""
    NOT_HELD = "not held"
    """The supports and contacts cannot carry the loads: the screw would move freely."""
    NOT_CONVERGED = "not converged"
    """The iteration found no equilibrium."""
    STOPPED = "stopped"
    """The solver was interrupted, or reached its limit of steps."""


@dataclass(frozen=True)
class Life:
    """Life L10, which 90 % of identical screws or bearings reach.

    Of a nut by its contact loads (ISO 3408-5), of a bearing (C/P)^p by the equivalent load P of ISO 281.
    """

    L10: float
    """Life L10 [revolutions]."""
    distance: float | None
    """Travel of the nut until the end of the life L10 [m]; None for bearings."""
    seconds: float | None
    """Running time until the end of the life L10 [s] at the scene's speed; None if the scene states no speed."""
    rating: float
    """Basic dynamic load rating [N], computed from the geometry: axial for screws and thrust bearings, otherwise radial."""
    equivalent_load: float
    """Equivalent dynamic load [N]: the constant load for which the basic dynamic load rating gives the same life."""
    standard: str
    """Standard whose formulas are used, such as ISO 3408-5."""
    by_maker: float | None = None
    """Life L10 with the maker's C of the scene in place of the computed one [revolutions]; None without such a C."""


@dataclass(frozen=True)
class Preload:
    """Contact loads that remain when all external loads of the scene are removed."""

    mean: float
    """Mean load of the loaded contacts [N]."""
    largest: float
    """Largest contact load [N]."""
    axial: float
    """Internal axial force [N]; for one of several nuts or bearings on a shaft, its axial force on the shaft."""
    contacts: int
    """Number of loaded contacts."""


@dataclass(frozen=True)
class WorstContact:
    """The contact of a rolling body with a raceway that has the highest pressure."""

    set: str
    """Name of the nut or bearing that the contact belongs to; empty if the scene has only one."""
    element: int
    """Number of the ball or roller, counted from 1."""
    side: str
    """Flank that a ball touches (SL, SR, NL, NR: screw or nut, left or right), or race of a roller (inner, outer)."""
    force: float
    """Contact load [N]."""
    pressure: float
    """Hertz pressure at the centre of the contact [Pa]."""
    safety: float
    """Static safety factor [1]: contact load at the allowed pressure (balls 4200 MPa, rollers 4000 MPa) divided by the
    contact load."""
    angle: float | None
    """Contact angle [rad]; None for rollers."""
    approach: float | None
    """Elastic approach of ball and groove [m]; None for rollers."""
    semi_axes: tuple[float, float] | None
    """Semi-axes of the contact ellipse, across and along the groove [m]; None for rollers."""


@result_record
class ExpectedError:
    """Error to expect of a model's results, estimated from its errors against the 3D reference on similar scenes.

    A field is None if no similar scene has been compared with the 3D reference.
    """

    loads: float | None = quantity_field(
        "expected_error_percent", "largest error of a contact load that `model_form` estimates for the model"
    )
    """Largest error of a contact load [% of the mean contact load]."""
    loads_rms: float | None
    """RMS error of the contact loads [% of the mean contact load]."""
    displacement: float | None = quantity_field(
        "expected_displacement_error_percent", "expected error of the displacement of the load's point, along z"
    )
    """Error of the axial displacement of the load's point [%]."""
    rigidity: float | None = quantity_field(
        "expected_rigidity_error_percent", "expected error of the tangent rigidity of the load's point, along z"
    )
    """Error of the axial tangent rigidity of the load's point [%]."""
    pressure: float | None = quantity_field("expected_pressure_error_percent", "expected error of the largest pressure")
    """Error of the largest pressure [%]."""
    nearest: str
    """Name of the most similar scene that was compared with the 3D reference."""
    words: tuple[str, ...]
    """Explanations: how the scene differs from the compared scenes, and why no error can be estimated."""


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Balls:
    """Positions of n balls, and the loads, angles and pressures of their contacts, as arrays with a row for each ball.

    The four columns are the groove flanks SL, SR, NL, NR (screw or nut, left or right, seen along +z). All fields are None
    for rollers. Without an equilibrium, loads, angles and pressure are None too.
    """

    azimuth: Array | None = None
    """Azimuth of every ball about the axis, (n,) [rad]."""
    z: Array | None = None
    """Axial position of every ball, (n,) [m]."""
    loads: Array | None = None
    """Contact loads of n balls on the four groove flanks, (n, 4) [N]; zero without contact."""
    angles: Array | None = None
    """Contact angles of n balls under load, from the radial plane, (n, 4) [rad]; nan without contact."""
    pressure: Array | None = None
    """Largest pressure in every contact of n balls, by the model or Hertz's theory, (n, 4) [Pa]; zero without contact."""


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class SetResult(Balls):
    """Results of one nut, ball bearing or roller bearing out of several on a shaft."""

    name: str
    """Name of the nut or bearing in the scene."""
    kind: str
    """Kind of machine element: nut, bearing (with balls) or rollers (a roller bearing)."""
    position: float
    """Axial position on the shaft [m]."""
    force: Array | None = None
    """Resultant force of the nut's or bearing's balls or rollers on the shaft, (3,) [N]."""
    moment: Array | None = None
    """Moment of the nut's or bearing's balls or rollers on the shaft, about the shaft's axis at `position`, (3,) [N m]."""
    stiffness: Array | None = None
    """Tangent stiffness between shaft and fixed outer part, (6, 6) [N/m, N, N m], in the degrees of freedom ux, uy, uz,
    rx, ry, rz."""
    nut: NutStiffness | None = None
    """Axial displacement [m] and stiffness [N/m] of this nut or bearing between its two parts, under the scene's loads."""
    roller_loads: Array | None = None
    """Loads of the rollers, (count,) [N]; None for balls."""
    worst: WorstContact | None = None
    """Contact with the highest pressure; None if no contact is loaded."""
    life: Life | None = None
    """Life L10; None if no contact is loaded, and where `life_words` gives another reason."""
    life_words: str = ""
    """Why there is no life L10, such as a load that ISO 281 does not cover, or rings that do not turn; else empty."""
    rib: RibContact | None = None
    """Contact of the most loaded roller with the rib of its ring; None for balls, and if no contact is loaded."""
    torque: RollerBearingTorque | None = None
    """Friction torque of a row of rollers [N m], from the work of friction and from Timken's formula; None for balls, and
    if no contact is loaded."""
    preload: Preload | None = None
    """Contact loads without the external loads of the scene; None if there is no equilibrium without external loads."""
    bearing_torque: BallBearingTorque | None = None
    """Friction torque of a ball bearing [N m]; None for nuts, and if no contact is loaded."""
    reference_life: ReferenceLife | None = None
    """Life of a bearing by ISO/TS 16281 [10^6 revolutions]; None for nuts, and if no contact is loaded."""

    def __repr__(self) -> str:
        """Return name, kind and largest contact load of the nut or bearing."""
        loads = self.loads if self.loads is not None else self.roller_loads
        return f"{self.name} ({self.kind}): " + ("no loads" if loads is None else f"largest load {loads.max():.5g} N")


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Result(Record, Balls):
    """Results of a low-order model for a scene: contact loads, displacement, stiffness, pressures and life.

    If there is no equilibrium, the results are None, and `status` and `reason` say why. With several nuts or bearings on
    one shaft, the arrays list the balls of all, one nut or bearing after the other, and `sets` has the results of each.
    With several load cases, `cases` has the result of each; `life` is then the life under all cases, and `worst` the worst
    contact of all.

    Examples
    --------
    >>> import rollbench
    >>> result = rollbench.solve("lin-case1", "lin")
    >>> result.converged, round(result.worst.pressure / 1e6), result.worst.element, result.worst.side
    (True, 2618, 12, 'SL')
    """

    scene: str
    """Name of the scene."""
    model: str
    """Name of the model."""
    member: int
    """Number of the specimen, from 0, in a scene with random errors."""
    status: Status
    """Outcome of the solution; with load cases, the outcome of the first case that did not converge."""
    reason: str
    """Why there is no equilibrium; empty if there is one."""
    warnings: tuple[str, ...]
    """Warnings about results outside the model's range of validity."""
    assumed: tuple[str, ...]
    """Assumptions made by the scene and by the model."""
    left_out: tuple[str, ...]
    """Effects that the model neglects in this scene."""
    force: float | None = None
    """Axial force of the screw on the nut [N]; with several nuts or bearings on one shaft, the sum of the axial loads on
    shaft and housings."""
    nut: NutStiffness | None = None
    """Displacement [m] and stiffness [N/m] of the nut or bearing between its two parts, without shaft and wind-up; of
    several nuts, or bearings where there is no nut, together."""
    load_point: LoadPointStiffness | None = None
    """Displacement [m] and stiffness [N/m] of the point on which the load acts, to ground: shaft and supports included."""
    displacement: Array | None = None
    """Displacement of the screw's cross-section or housing on which the load acts from its unloaded position, (6,)
    [m, rad], in the degrees of freedom ux, uy, uz, rx, ry, rz; without a force, at the nut's centre or ``stiffness_at``."""
    stiffness: Array | None = None
    """Tangent stiffness of the screw's cross-section at the nut's centre, or at ``stiffness_at``, with the nut fixed,
    (6, 6) [N/m, N, N m]. With several nuts or bearings on one shaft: stiffness of the whole axis, nan in fixed degrees of
    freedom. None if the model gives no stiffness."""
    worst: WorstContact | None = None
    """Contact with the highest pressure; with several nuts or bearings on one shaft, the contact with the highest ratio of
    pressure to allowed pressure. None if no contact is loaded."""
    life: Life | None = None
    """Life L10; with several nuts or bearings on one shaft, the shortest of theirs, None if that of a loaded one is not
    known. None if no contact is loaded, and where `life_words` gives another reason."""
    life_words: str = ""
    """Why there is no life L10, such as a load that ISO 281 does not cover; else empty."""
    modified_life: ModifiedLife | None = None
    """Life modified for reliability, lubricant and contamination [10^6 revolutions]; None if the scene states none of the
    three, and with several nuts or bearings on one shaft."""
    reference_life: ReferenceLife | None = None
    """Life of a single bearing by ISO/TS 16281 [10^6 revolutions]; None for screws, and if no contact is loaded."""
    shaft: ShaftLimits | None = None
    """Buckling load [N], critical speed [rad/s] and DN value [m rad/s] of the screw; None for bearings, and with several
    nuts or bearings on one shaft."""
    preload: Preload | None = None
    """Contact loads without the external loads of the scene; with several nuts or bearings, see each of `sets`."""
    bearing_torque: BallBearingTorque | None = None
    """Friction torque of a single bearing [N m]; None for nuts, and if no contact is loaded."""
    drive: AxisDrive | None = None
    """Torques [N m] and moments of inertia [kg m^2] at the motor of an axis; None for a single nut or bearing."""
    axis_life: SystemLife | None = None
    """Life of all nuts and bearings of a shaft as one system, under all load cases; None for a single nut or bearing."""
    expected_error: ExpectedError | None = None
    """Error to expect of the model's results. None with several nuts or bearings on one shaft, where it is not known, and
    with load cases: see each of `cases`."""
    sets: Mapping[str, SetResult] = field(default_factory=dict)
    """Results of each nut or bearing on a shaft with several, by name; empty for a single nut or bearing."""
    cases: Mapping[str, Result] = field(default_factory=dict)
    """Results of each load case, by name; empty without load cases."""
    solved: tuple[SceneSolution | ShaftSolution, ...] = ()
    """Records of the solver with further details; one for each load case."""
    tangents: tuple[TangentStiffness | None, ...] = ()
    """Stiffness at the axial position ``stiffness_at`` for each record of `solved`; None if no position was asked for."""
    cycle: DutyCycle | None = None
    """Duty cycle of the scene; None without load cases."""
    together: DutyCycleResults | None = None
    """Results over all load cases together, such as extremes and the life; None without load cases."""

    @property
    def converged(self) -> bool:
        """Whether an equilibrium was found, in every load case."""
        return self.status is Status.CONVERGED

    @property
    def load(self) -> Array:
        """Contact loads of n balls, (n, 4) [N], or with load cases (cases, n, 4); deprecated, use `loads`."""
        warn_of_deprecation("result.load", "result.loads")
        each = [one.loads for one in self.cases.values() if one.loads is not None]
        return np.array(each) if each else np.zeros((0, 4)) if self.sets or self.loads is None else self.loads

    @property
    def angle(self) -> Array:
        """Contact angles of n balls, (n, 4) [deg], or with load cases (cases, n, 4); deprecated, use `angles`, in rad."""
        warn_of_deprecation("result.angle", "result.angles, in rad")
        each = [one.angles for one in self.cases.values() if one.angles is not None]
        found = np.array(each) if each else np.zeros((0, 4)) if self.sets or self.angles is None else self.angles
        return np.degrees(found)

    def to_dict(self) -> dict[str, JSON]:
        """Return the result as a dictionary, as ``rollbench solve --json`` prints it.

        Returns
        -------
        dict
            JSON values by key; the keys end with the unit, such as ``max_N``.
        """
        if self.cycle is None or self.together is None:
            return add_schema_version(solved_case_json(self.solved[0], self.tangents[0]))
        return add_schema_version(duty_cycle_json(self.cycle, self.solved, self.together, self.tangents))

    def to_dataframe(self) -> pandas.DataFrame:
        """Return a pandas data frame with a row for every ball.

        Returns
        -------
        pandas.DataFrame
            Number and position of the ball, then contact load, contact angle and pressure on each groove flank in SI units.
            With several nuts, bearings or load cases, the first columns have their names.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        import pandas

        return pandas.DataFrame(self.columns())

    def columns(self) -> dict[str, Array | list[str]]:
        """Return the columns of `to_dataframe` without pandas.

        Returns
        -------
        dict
            Values of each column (array or list), by the name of the column, such as ``load_SL_N``; empty without an
            equilibrium.

        Examples
        --------
        >>> import rollbench
        >>> columns = rollbench.solve("lin-case1", "lin").columns()
        >>> list(columns)[:5], round(float(columns["load_SL_N"][0]))
        (['ball', 'azimuth_rad', 'z_m', 'load_SL_N', 'load_SR_N'], 234)
        """
        if self.cases:
            return _stack_columns("case", {name: one.columns() for name, one in self.cases.items()})
        if self.sets:
            return _stack_columns("set", {name: _ball_contact_columns(one) for name, one in self.sets.items()})
        return _ball_contact_columns(self)

    def plot(self) -> Figure:
        """Draw the contact loads over the ball number, in a panel for each nut or bearing and each load case.

        Returns
        -------
        matplotlib.figure.Figure
            Figure that is independent of pyplot; save it by ``plot().savefig("loads.svg")``.

        Raises
        ------
        ValueError
            If there are no loads.
        ImportError
            If matplotlib is not installed.
        """
        from matplotlib.figure import Figure

        panels = list(self._contact_loads_by_panel(""))
        if not panels:
            raise ValueError(f"{self.scene}: no loads to draw ({self.status}{f', {self.reason}' if self.reason else ''})")
        figure = Figure(figsize=(7.0, 3.2 * len(panels)), layout="constrained")
        for axes, (title, loads) in zip(figure.subplots(len(panels), squeeze=False)[:, 0], panels, strict=True):
            for side, load in zip(SIDES, loads.T, strict=True):
                if (load > 0.0).any():
                    axes.plot(np.arange(1, load.size + 1), load, ".-", label=side)
            axes.set(title=title, xlabel="ball", ylabel="contact load / N")
            axes.legend()
        return figure

    def _contact_loads_by_panel(self, case: str) -> Sequence[tuple[str, Array]]:
        """Return title and contact loads (n, 4) [N] of each panel of the figure that `plot` draws.

        There is a panel for each nut or bearing and each load case. ``case``: text on the load case, added to the titles.
        """
        if self.cases:
            return [panel for name, one in self.cases.items() for panel in one._contact_loads_by_panel(f", case {name}")]
        several = {f", {name}": one.loads for name, one in self.sets.items()}
        each, model = several or {"": self.loads}, model_title(self.model)
        return [(f"{self.scene}{case}{of}, {model}", loads) for of, loads in each.items() if loads is not None]

    def view(self, path: str | Path) -> Path:
        """Write an HTML page that shows the loaded screw in 3D in a browser, as ``rollbench view`` does.

        Parameters
        ----------
        path
            File to write.

        Returns
        -------
        Path
            Path of the written file.

        Raises
        ------
        ValueError
            If there are no loads.
        """
        from rollbench.compare.files import replace_file

        replace_file(Path(path), self.view_page())
        return Path(path)

    def view_page(self, stores: Sequence[Path] | None = None) -> str:
        """Return the HTML text of the page that `view` writes.

        Parameters
        ----------
        stores
            Folders with runs of the 3D reference whose loads are shown too; None: the runs shipped with rollbench.

        Returns
        -------
        str
            The text of the page.

        Raises
        ------
        ValueError
            If there are no loads.
        """
        from rollbench.compare.results.view import collect_view_data
        from rollbench.reports.view import viewer_page_html

        if not any(one.derived_results for one in self.solved):
            raise ValueError(f"{self.scene}: no loads to draw ({self.status}, {self.reason})")
        title = (self.cycle or self.solved[0].scene).title
        return viewer_page_html(collect_view_data(title, self.solved, self.to_dict(), [*self.cases], stores))

    def table(self) -> Sequence[Row]:
        """Return the rows of the table that ``rollbench solve`` prints.

        Returns
        -------
        Sequence[Row]
            A row for each quantity, such as the largest load; with load cases, the quantities of all cases together.
        """
        return duty_cycle_rows(self.together) if self.together is not None else solution_rows(self.solved[0])

    def _repr_html_(self) -> str:
        """Return the table as HTML for a notebook, and a second table of nuts and bearings if there are several."""
        shafts = [one for one in self.solved if isinstance(one, ShaftSolution) and not self.cases]
        rows = [row for one in shafts for row in bearing_and_nut_rows(one)]
        return super()._repr_html_() + (format_table_as_html([[*row.values()] for row in rows], [*rows[0]]) if rows else "")

    @property
    def _notes(self) -> tuple[str, ...]:
        """Lines below the table: scene, model and status, then the sentence on the expected error, then warnings."""
        status = f"{self.status}: {self.reason}" if self.reason else self.status
        worth = () if self.cases or not self.converged else (expected_error_sentence(self.solved[0].expected_errors),)
        return (f"{self.scene}, {model_title(self.model)}: {status}", *worth, *self.warnings)

    def __repr__(self) -> str:
        """Return five lines: scene with model and status, largest load, displacement, largest pressure, and life."""
        w, moved = self.worst, None if self.load_point is None else self.load_point.displacement
        largest = None if self.loads is None or not self.loads.size else float(self.loads.max())
        lines = [
            ("loads", "largest", largest, "N"),
            ("displacement", "load's point", None if moved is None else 1e6 * moved, "um"),
            ("pressure", "largest", None if w is None else 1e-6 * w.pressure, "MPa"),
            ("life", "L10", None if self.life is None else 1e-6 * self.life.L10, "million revolutions"),
        ]
        if self.reference_life is not None:
            lines.append(("life", "L10r", self.reference_life.revolutions, "million revolutions"))
        told = (f"{name}: none" if x is None else f"{name}: {what} {x:.5g} {unit}" for name, what, x, unit in lines)
        return "\n".join([self._notes[0], *told])


def result_from_solutions(
    solved: Sequence[SceneSolution | ShaftSolution],
    tangents: Sequence[TangentStiffness | None],
    at_nut: Sequence[TangentStiffness | None],
    cycle: DutyCycle | None = None,
    cycle_results: DutyCycleResults | None = None,
) -> Result:
    """Convert the solver's records of a scene, or of the load cases of a duty cycle, to a `Result`.

    Parameters
    ----------
    solved
        Records of the solver, one for each load case.
    tangents
        For each load case, the stiffness at the axial position that the user asked for; None if there is no such position.
    at_nut
        For each load case, the stiffness at the nut's centre; None if it was not computed.
    cycle
        Duty cycle to which the load cases belong; None for a scene without load cases.
    cycle_results
        Results over all load cases together, such as extremes and the life; None for a scene without load cases.

    Returns
    -------
    Result
        The result, with the result of each load case in ``cases``.
    """
    each = [_result_of_load_case(*one) for one in zip(solved, tangents, at_nut, strict=True)]
    if cycle is None or cycle_results is None:
        return each[0]
    lost = next((one for one in each if not one.converged), each[0])
    unsolved = "; ".join(f"case {name}: {status}" for name, status in cycle_results.unsolved.items())
    worst = [one.worst for one in each if one.worst is not None]
    lives = cycle_results.shortest_lives
    return Result(
        scene=cycle.name,
        model=each[0].model,
        member=each[0].member,
        status=lost.status,
        reason=unsolved,
        warnings=tuple(dict.fromkeys(words for one in each for words in one.warnings)),
        assumed=tuple(dict.fromkeys(words for one in each for words in one.assumed)),
        left_out=tuple(dict.fromkeys(words for one in each for words in one.left_out)),
        worst=max(worst, key=lambda w: w.pressure, default=None),
        life=_life_record(lives.life, cycle_results.speed),
        life_words=lives.life_words,
        modified_life=lives.modified,
        reference_life=lives.reference,
        axis_life=cycle_results.axis_life,
        cases={case.name: one for case, one in zip(cycle.cases, each, strict=True)},
        solved=tuple(solved),
        tangents=tuple(tangents),
        cycle=cycle,
        together=cycle_results,
    )


def _result_of_load_case(
    solved: SceneSolution | ShaftSolution, tangent: TangentStiffness | None, at_nut: TangentStiffness | None
) -> Result:
    """Convert the solver's record of one load case to a `Result`.

    ``tangent``: stiffness at the axial position that the user asked for. ``at_nut``: stiffness at the nut's centre. Both
    are None if they were not computed.
    """
    found = solved.result
    head = Result(
        scene=solved.scene.name,
        model=found.model,
        member=found.member,
        status=Status(found.status.kind),
        reason=found.status.reason,
        warnings=tuple(map(str, found.warnings)),
        assumed=found.assumed,
        left_out=found.left_out,
        solved=(solved,),
        tangents=(tangent,),
    )
    if isinstance(solved, SceneSolution):
        return _add_nut_or_bearing_results(head, solved, tangent, at_nut)
    return _add_shaft_results(head, solved)


def _add_nut_or_bearing_results(
    head: Result, solved: SceneSolution, tangent: TangentStiffness | None, at_nut: TangentStiffness | None
) -> Result:
    """Return the result of a scene with a single nut or bearing: ``head`` with all quantities filled in.

    ``head``: result with scene, model, status and warnings only. ``solved``: record of the solver. ``tangent``: stiffness
    at the axial position that the user asked for. ``at_nut``: stiffness at the nut's centre. Both are None if they were not
    computed. Without equilibrium only the positions of the balls are filled in.
    """
    answers = solved.derived_results
    if answers is None:
        return replace(head, azimuth=solved.result.azimuth, z=solved.result.z)
    speed = None if solved.scene.motion is None else solved.scene.motion.speed
    K = tangent if tangent is not None and tangent.status == "converged" else at_nut
    return replace(
        head,
        **_ball_fields(solved.scene, solved.result),
        force=answers.axial_force,
        nut=answers.stiffness.nut,
        load_point=answers.stiffness.load_point,
        displacement=None if np.isnan(answers.displacement).all() else answers.displacement,
        stiffness=None if K is None else K.matrix,
        worst=_worst_contact("", answers.load_results),
        life=_life_record(answers.load_results.life, speed),
        life_words=answers.load_results.words or answers.load_results.life_words,
        modified_life=answers.load_results.modified,
        reference_life=answers.load_results.reference,
        shaft=answers.shaft_limits,
        preload=_preload_record(answers.preload),
        bearing_torque=answers.bearing_torque,
        expected_error=expected_error_record(solved.expected_errors),
    )


def _add_shaft_results(head: Result, solved: ShaftSolution) -> Result:
    """Return the result of a shaft with several nuts or bearings: ``head`` with all quantities filled in.

    ``head``: result with scene, model, status and warnings only. ``solved``: record of the solver. Without equilibrium only
    the names and positions of the nuts and bearings are filled in.
    """
    found, answers = solved.result, solved.derived_results
    speed = None if solved.scene.motion is None else solved.scene.motion.speed
    each = [None] * len(found.sets) if answers is None else [*answers.set_results]
    sets = {s.of.name: _result_of_nut_or_bearing(s, x, speed) for s, x in zip(found.sets, each, strict=True)}
    if answers is None:
        return replace(head, sets=sets)
    balls = [s for s in sets.values() if s.loads is not None]
    joined: dict[str, Any] = {
        name: np.concatenate([getattr(s, name) for s in balls]) if balls else None for name in vars(Balls())
    }
    worst = next((sets[found.sets[i].of.name].worst for i in answers.set_indices_by_pressure), None)
    turning = [s for s in sets.values() if s.life is not None or s.reference_life is not None]
    lives = [s.life for s in turning if s.life is not None]
    return replace(
        head,
        **joined,
        sets=sets,
        force=answers.axial_load,
        nut=answers.stiffness.nut,
        load_point=answers.stiffness.load_point,
        displacement=answers.displacement,
        stiffness=found.stiffness,
        worst=worst,
        life=min(lives, key=lambda life: life.L10, default=None) if len(lives) == len(turning) else None,
        drive=solved.motor_torques,
        axis_life=solved.combined_life,
        expected_error=expected_error_record(solved.expected_errors),
    )


def _result_of_nut_or_bearing(solved_set: SolvedSet, answers: NutOrBearingResults | None, speed: float | None) -> SetResult:
    """Convert the solver's record of one nut or bearing on a shaft to a `SetResult`.

    ``answers``: pressure, life and other results from the contact loads of the nut or bearing; None without equilibrium.
    ``speed``: speed of rotation [rad/s], for the running time of the life; None if it is not known.
    """
    bare = SetResult(name=solved_set.of.name, kind=solved_set.of.kind, position=solved_set.of.position)
    if answers is None:
        return bare
    balls, loads = solved_set.balls, answers.load_results
    return replace(
        bare,
        **(_ball_fields(answers.parts, balls) if balls and isinstance(answers.parts, Scene) else {}),
        force=solved_set.force,
        moment=solved_set.moment,
        stiffness=solved_set.stiffness,
        nut=answers.stiffness,
        roller_loads=solved_set.roller_load,
        worst=_worst_contact(bare.name, loads),
        life=_life_record(loads.life, speed),
        life_words=loads.life_words or ("" if isinstance(loads, RollerLoadResults) else loads.words),
        rib=loads.rib_contact if isinstance(loads, RollerLoadResults) else None,
        torque=loads.torque if isinstance(loads, RollerLoadResults) else None,
        preload=_preload_record(answers.preload),
        bearing_torque=answers.friction_torque,
        reference_life=loads.reference,
    )


def _ball_fields(scene: Scene, result: StaticResult) -> dict[str, Any]:
    """Return positions, loads, angles and pressures of the balls of a nut or bearing: the fields of `Balls`, by name.

    ``result``: solution of the nut or bearing.
    """
    angles, pressure = np.where(result.load > 0.0, result.contact_angle, np.nan), contact_pressures(scene, result)
    return {"azimuth": result.azimuth, "z": result.z, "loads": result.load, "angles": angles, "pressure": pressure}


def _worst_contact(name: str, answers: LoadResults) -> WorstContact | None:
    """Return the contact with the highest pressure in one nut or bearing; None if no contact is loaded.

    ``name``: name of the nut or bearing. ``answers``: results from its contact loads.
    """
    w, safety = answers.worst_contact, answers.safety
    if w is None or safety is None:
        return None
    if isinstance(w, BallContact):
        return WorstContact(name, w.ball, w.side, w.force, w.pressure, safety.factor, w.angle, w.approach, (w.a, w.b))
    return WorstContact(name, w.roller, w.race, w.force, w.pressure, safety.factor, None, None, None)


def _life_record(known: rating.BasicRatingLife | None, speed: float | None) -> Life | None:
    """Convert a computed basic rating life to the record `Life` of a result; None if ``known`` is None.

    ``speed``: speed of rotation [rad/s], for the running time until the end of the life; None if it is not known.
    """
    if known is None:
        return None
    seconds = 3600.0 * known.hours(speed) if speed else None
    maker = None if known.by_maker is None else 1e6 * known.by_maker
    return Life(1e6 * known.revolutions, known.distance, seconds, known.rating, known.equivalent, known.standard, maker)


def _preload_record(known: loading.Preload | None) -> Preload | None:
    """Convert a computed preload to the record `Preload` of a result; None if ``known`` is None."""
    return None if known is None else Preload(known.mean, known.largest, known.axial, known.loaded)


def expected_error_record(model_form: ExpectedModelErrors | None) -> ExpectedError | None:
    """Convert the estimated error of a model to the record `ExpectedError` of a result.

    Parameters
    ----------
    model_form
        Estimate that `rollbench.compare.models.model_form` computed; None if no estimate was possible.

    Returns
    -------
    ExpectedError | None
        The record; None without an estimate.
    """
    if model_form is None:
        return None
    others = model_form.displacement_percent, model_form.rigidity_percent, model_form.pressure_percent
    return ExpectedError(model_form.percent, model_form.rms_percent, *others, model_form.nearest, model_form.words)


def _ball_contact_columns(one: Balls) -> dict[str, Array | list[str]]:
    """Return the columns of `Result.columns` for the balls of one nut or bearing; empty if there are no loads.

    The names of the columns end with their SI units.
    """
    if one.azimuth is None or one.z is None or one.loads is None or one.angles is None or one.pressure is None:
        return {}
    out: dict[str, Array | list[str]] = {"ball": np.arange(1.0, one.z.size + 1), "azimuth_rad": one.azimuth, "z_m": one.z}
    for name, values in (("load_{}_N", one.loads), ("angle_{}_rad", one.angles), ("pressure_{}_Pa", one.pressure)):
        out |= {name.format(side): column for side, column in zip(SIDES, values.T, strict=True)}
    return out


def _stack_columns(
    name_column: str, columns_by_name: Mapping[str, Mapping[str, Array | list[str]]]
) -> dict[str, Array | list[str]]:
    """Stack the columns of several nuts, bearings or load cases; a new first column has their names.

    ``name_column``: name of the first column. ``columns_by_name``: columns by their name, by name of the nut, bearing or
    load case. Those without columns are left out.
    """
    known = {name: columns for name, columns in columns_by_name.items() if columns}
    names = [name for name, columns in known.items() for _ in columns["ball"]]
    out: dict[str, Array | list[str]] = {name_column: names} if known else {}
    for column in next(iter(known.values()), {}):
        parts = [columns[column] for columns in known.values()]
        out[column] = [x for part in parts for x in part] if isinstance(parts[0], list) else np.concatenate(parts)
    return out
