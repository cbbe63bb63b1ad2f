"""Result of `rollbench.solve`: loads, displacement, stiffness and life of a scene, and their parts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rollbench.compare.models.answers import LoadAnswers, RollerAnswers, SetAnswers
from rollbench.compare.models.load_cases import CycleResults, Solved, SolvedAxis
from rollbench.compare.models.programs import title_of
from rollbench.compare.results.base import JSON, Record, Row, as_html, deprecated, with_schema
from rollbench.compare.results.rows import answer_rows, expected_words, set_rows, together_rows
from rollbench.compare.results.scene_json import case_json, cases_json, pole_pressure
from rollbench.compare.scenes.duty_cycle import DutyCycle
from rollbench.lowfi.rating.contacts import Contact
from rollbench.lowfi.statics.result import SetResult as SolvedSet
from rollbench.lowfi.statics.result import StaticResult
from rollbench.lowfi.statics.tangent import Tangent
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import SIDES, Scene
from rollbench.meshes.quantity import quantity, record

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

    from rollbench.compare.models import loading
    from rollbench.compare.models.drive import AxisDrive
    from rollbench.compare.models.model_form import ModelForm
    from rollbench.lowfi.bearings.rib import RibContact
    from rollbench.lowfi.bearings.roller_torque import RollerTorque
    from rollbench.lowfi.bearings.torque import BallTorque
    from rollbench.lowfi.rating import life as rating
    from rollbench.lowfi.rating.life import SystemLife
    from rollbench.lowfi.rating.modified import ModifiedLife
    from rollbench.lowfi.rating.reference import ReferenceLife
    from rollbench.lowfi.rating.shaft import ShaftLimits


class Status(StrEnum):
    """Outcome of the search for an equilibrium."""

    CONVERGED = "converged"
    """There is an equilibrium; all fields may be used."""
    NOT_HELD = "not held"
    """Supports and contacts cannot carry the loads: the screw would move freely."""
    NOT_CONVERGED = "not converged"
    """The iteration found no equilibrium."""
    STOPPED = "stopped"
    """The solver was interrupted, or reached its limit of steps."""


@dataclass(frozen=True)
class Life:
    """Basic rating life L10, which 90 % of equal parts reach, by the computed contact loads (ISO 281, ISO 3408-5)."""

    L10: float
    """Life [revolutions]."""
    distance: float | None
    """Travel of the nut in that life [m]; None for bearings."""
    seconds: float | None
    """Running time in that life [s] at the scene's speed; None without a speed."""
    rating: float
    """Basic dynamic load rating, computed from the geometry [N]: axial for screws and thrust bearings, else radial."""
    equivalent_load: float
    """Equivalent dynamic load [N]: the load for which the rating gives the same life."""
    standard: str
    """Standard whose formulas are used, such as ISO 3408-5."""


@dataclass(frozen=True)
class Preload:
    """Contact loads that are left when the loads of the scene are removed."""

    mean: float
    """Mean load of the loaded contacts [N]."""
    largest: float
    """Largest load of a contact [N]."""
    axial: float
    """Internal axial force [N]; of one of several sets, its axial force on the shaft."""
    contacts: int
    """Number of loaded contacts."""


@dataclass(frozen=True)
class WorstContact:
    """The contact with the highest pressure."""

    set: str
    """Name of the rolling set that it belongs to; empty if there is only one."""
    element: int
    """Number of the ball or roller, counted from 1."""
    side: str
    """Flank of a ball: SL, SR, NL, NR (screw or nut, left or right); race of a roller: inner, outer."""
    force: float
    """Contact load [N]."""
    pressure: float
    """Largest Hertz pressure, at the centre of the contact [Pa]."""
    safety: float
    """Static safety factor [1]: load at the allowed pressure (balls 4200 MPa, rollers 4000 MPa) over contact load."""
    angle: float | None
    """Contact angle [rad]; None of rollers."""
    approach: float | None
    """Approach of ball and groove [m]; None of rollers."""
    semi_axes: tuple[float, float] | None
    """Semi-axes of the contact ellipse, across and along the groove [m]; None of rollers."""


@record
class ExpectedError:
    """Error of the model to expect, estimated from its errors against the 3D reference on similar scenes.

    None: no similar scene was compared.
    """

    loads: float | None = quantity("expected_error_percent", "what `model_form` promised for the worst contact load")
    """Largest error of a contact load [% of the mean contact load]."""
    loads_rms: float | None
    """RMS error of the contact loads [% of the mean contact load]."""
    displacement: float | None = quantity("expected_displacement_error_percent", "the same for the displacement")
    """Error of the axial displacement [%]."""
    rigidity: float | None = quantity("expected_rigidity_error_percent", "the same for the rigidity")
    """Error of the axial rigidity [%]."""
    pressure: float | None = quantity("expected_pressure_error_percent", "the same for the pressure")
    """Error of the largest pressure [%]."""
    nearest: str
    """Name of the most similar scene that was compared."""
    words: tuple[str, ...]
    """Explanations: in what the scene differs from those compared, and why it is not covered."""


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Balls:
    """Positions of n balls and loads, angles and pressures of their contacts, in arrays with a row for each ball.

    Columns are the flanks SL, SR, NL, NR: screw or nut, left or right seen along +z. Fields are None for rollers; loads,
    angles and pressure also without an equilibrium.
    """

    azimuth: Array | None = None
    """Azimuth of every ball about the axis, (n,) [rad]."""
    z: Array | None = None
    """Axial position of every ball, (n,) [m]."""
    loads: Array | None = None
    """Contact loads, (n, 4) [N]; zero without contact."""
    angles: Array | None = None
    """Contact angles under load from the radial plane, (n, 4) [rad]; nan without contact."""
    pressure: Array | None = None
    """Largest pressure of every contact, by the model or by Hertz, (n, 4) [Pa]; zero without contact."""


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class SetResult(Balls):
    """One rolling set (nut, ball bearing or roller bearing) of several on a shaft."""

    name: str
    """Name of the set in the scene."""
    kind: str
    """Kind of the set: nut, bearing, rollers."""
    position: float
    """Axial position on the shaft [m]."""
    force: Array | None
    """Force of its balls or rollers on the shaft, (3,) [N]."""
    moment: Array | None
    """Moment of its balls or rollers on the shaft about the point of the axis at `position`, (3,) [N m]."""
    stiffness: Array | None
    """Tangent stiffness between shaft and fixed outer part, (6, 6) [N/m, N, N m]; freedoms ux, uy, uz, rx, ry, rz."""
    roller_loads: Array | None
    """Loads of the rollers, (count,) [N]; None of balls."""
    worst: WorstContact | None
    """Contact with the highest pressure; None without load."""
    life: Life | None
    """Life of the set; None without load, and outside the range of the formulas."""
    rib: RibContact | None
    """Contact of the most loaded roller with its rib; None of balls and without load."""
    torque: RollerTorque | None
    """Friction torque of a row of rollers [N m], by work and by Timken's formula; None of balls and without load."""
    preload: Preload | None
    """Contact loads without the loads of the scene; None if there is no equilibrium without them."""
    bearing_torque: BallTorque | None = None
    """Friction torque of a bearing [N m]; None of nuts and without load."""
    reference_life: ReferenceLife | None = None
    """Life of a bearing by ISO/TS 16281, in 10^6 revolutions; None of nuts and without load."""

    def __repr__(self) -> str:
        """Return name, kind and largest load of the set."""
        loads = self.loads if self.loads is not None else self.roller_loads
        return f"{self.name} ({self.kind}): " + ("no loads" if loads is None else f"largest load {loads.max():.5g} N")


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Result(Record, Balls):
    """Answers of a low-order model to a scene.

    Fields with answers are None where there is no equilibrium: see `status` and `reason`. Of several sets on one shaft the
    arrays of balls hold those of all sets in turn, and each set is in `sets`. Each load case is a result in `cases`; the
    whole has the life over all cases and the worst contact of all.

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
    """Number of the specimen of a scene with random errors, from 0."""
    status: Status
    """How the solution ended; of load cases that of the first that did not converge."""
    reason: str
    """Why there is no equilibrium; empty if there is one."""
    warnings: tuple[str, ...]
    """Warnings where answers are outside the range of validity of the model."""
    assumed: tuple[str, ...]
    """Assumptions of scene and model."""
    left_out: tuple[str, ...]
    """Effects that the model neglects in this scene."""
    force: float | None = None
    """Axial force of the screw on the nut; of several sets, the axial loads on shaft and housings [N]."""
    displacement: Array | None = None
    """Displacement of the screw's section at the nut's centre from its unloaded position, (6,) [m, rad]; freedoms ux, uy,
    uz, rx, ry, rz. Of several sets: of the station or housing that ``stiffness_at`` names, else of the one loaded first."""
    rigidity: float | None = None
    """Axial force over axial displacement [N/m]; None without axial force."""
    stiffness: Array | None = None
    """Tangent stiffness of the screw's section at the nut's centre, or at ``stiffness_at``, with the nut fixed, (6, 6)
    [N/m, N, N m]. Of several sets: of the whole axis, nan in fixed freedoms. None if the model gives no stiffness."""
    axial_stiffness: float | None = None
    """Axial tangent stiffness at the nut's centre [N/m]: rotation about the axis fixed, all else free; of several sets all
    other freedoms fixed."""
    worst: WorstContact | None = None
    """Contact with the highest pressure; of several sets with the highest share of the allowed one. None without load."""
    life: Life | None = None
    """Life by the contact loads; of several sets the shortest. None without load, and outside the range of the formulas."""
    modified_life: ModifiedLife | None = None
    """Life modified for reliability, lubricant and contamination [10^6 revolutions]; None if the scene states none of
    these, and of several sets."""
    reference_life: ReferenceLife | None = None
    """Life of a bearing of one set by ISO/TS 16281, in 10^6 revolutions; None of screws and without load."""
    shaft: ShaftLimits | None = None
    """Buckling load [N], critical speed [rad/s] and DN value [m rad/s] of the screw; None of bearings and several sets."""
    preload: Preload | None = None
    """Contact loads without the loads of the scene; of several sets see each of `sets`."""
    bearing_torque: BallTorque | None = None
    """Friction torque of a single bearing [N m]; None of nuts and without load."""
    drive: AxisDrive | None = None
    """Torques [N m] and moments of inertia [kg m^2] at the motor of an axis; None of one set."""
    axis_life: SystemLife | None = None
    """Life of all sets of a shaft as one system, over all load cases; None of one set."""
    expected_error: ExpectedError | None = None
    """Error of the model to expect; None of several sets (not known), and of load cases: see each of `cases`."""
    sets: Mapping[str, SetResult] = field(default_factory=dict)
    """Results of each of several sets on one shaft, by name; empty of one set."""
    cases: Mapping[str, Result] = field(default_factory=dict)
    """Results of each load case, by name; empty without load cases."""
    solved: tuple[Solved | SolvedAxis, ...] = ()
    """Records of the solver with further details: one, or one for each load case."""
    tangents: tuple[Tangent | None, ...] = ()
    """Stiffness at the station ``stiffness_at``, for each record of `solved`; None without such a station."""
    cycle: DutyCycle | None = None
    """Duty cycle of the scene; None without load cases."""
    together: CycleResults | None = None
    """Sums over the load cases; None without load cases."""

    @property
    def converged(self) -> bool:
        """Whether there is an equilibrium, in every load case."""
        return self.status is Status.CONVERGED

    @property
    def load(self) -> Array:
        """Contact loads, of load cases stacked; deprecated, use `loads`."""
        deprecated("result.load", "result.loads")
        each = [one.loads for one in self.cases.values() if one.loads is not None]
        return np.array(each) if each else np.zeros((0, 4)) if self.sets or self.loads is None else self.loads

    @property
    def angle(self) -> Array:
        """Contact angles [deg]; deprecated, use `angles`."""
        deprecated("result.angle", "result.angles, in rad")
        each = [one.angles for one in self.cases.values() if one.angles is not None]
        found = np.array(each) if each else np.zeros((0, 4)) if self.sets or self.angles is None else self.angles
        return np.degrees(found)

    def to_dict(self) -> dict[str, JSON]:
        """Return the JSON that ``rollbench solve --json`` prints.

        Returns
        -------
        dict
            JSON values by key; the keys end with the unit, such as ``max_N``.
        """
        if self.cycle is None or self.together is None:
            return with_schema(case_json(self.solved[0], self.tangents[0]))
        return with_schema(cases_json(self.cycle, self.solved, self.together, self.tangents))

    def to_dataframe(self) -> pandas.DataFrame:
        """Return a row for every ball as a data frame, which needs the package pandas.

        Returns
        -------
        pandas.DataFrame
            Number and place of the ball, then load, angle and pressure of each flank in SI units; of several sets and load
            cases with their names.

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
            Arrays or lists by name of the column, such as ``load_SL_N``; empty without an equilibrium.

        Examples
        --------
        >>> import rollbench
        >>> columns = rollbench.solve("lin-case1", "lin").columns()
        >>> list(columns)[:5], round(float(columns["load_SL_N"][0]))
        (['ball', 'azimuth_rad', 'z_m', 'load_SL_N', 'load_SR_N'], 234)
        """
        if self.cases:
            return _stack_arrays("case", {name: one.columns() for name, one in self.cases.items()})
        if self.sets:
            return _stack_arrays("set", {name: _contact_columns(one) for name, one in self.sets.items()})
        return _contact_columns(self)

    def plot(self) -> Figure:
        """Draw the contact loads over the number of the ball, in a panel for each set and load case.

        Returns
        -------
        matplotlib.figure.Figure
            Figure without pyplot: ``plot().savefig("loads.svg")``.

        Raises
        ------
        ValueError
            If there are no loads.
        ImportError
            If matplotlib is not installed.
        """
        from matplotlib.figure import Figure

        panels = list(self._panels(""))
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

    def _panels(self, case: str) -> Sequence[tuple[str, Array]]:
        """Return title and contact loads (n, 4) [N] of each panel of `plot`; ``case``: text for the titles."""
        if self.cases:
            return [panel for name, one in self.cases.items() for panel in one._panels(f", case {name}")]
        several = {f", {name}": one.loads for name, one in self.sets.items()}
        each = several or {"": self.loads}
        return [
            (f"{self.scene}{case}{of}, {title_of(self.model)}", loads) for of, loads in each.items() if loads is not None
        ]

    def view(self, path: str | Path) -> Path:
        """Write an HTML page with the loaded screw in 3D, to be turned in a browser, as ``rollbench view`` does.

        Parameters
        ----------
        path
            File to write.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        ValueError
            If there are no loads.
        """
        Path(path).write_text(self.view_page(), encoding="utf-8")
        return Path(path)

    def view_page(self, stores: Sequence[Path] | None = None) -> str:
        """Return the HTML text of the page that `view` writes.

        Parameters
        ----------
        stores
            Folders with runs of the 3D reference, whose loads are shown too; those of the package unless given.

        Returns
        -------
        str
            HTML.

        Raises
        ------
        ValueError
            If there are no loads.
        """
        from rollbench.compare.results.view import make_view
        from rollbench.reports.view import view_page

        if not any(one.answers for one in self.solved):
            raise ValueError(f"{self.scene}: no loads to draw ({self.status}, {self.reason})")
        title = (self.cycle or self.solved[0].scene).title
        return view_page(make_view(title, self.solved, self.to_dict(), [*self.cases], stores))

    def table(self) -> Sequence[Row]:
        """Return the rows that ``rollbench solve`` prints; for load cases the rows on all of them together.

        Returns
        -------
        Sequence[Row]
            The rows.
        """
        return together_rows(self.together) if self.together is not None else answer_rows(self.solved[0])

    def _repr_html_(self) -> str:
        """Return the table as HTML for a notebook; with several sets, a second table has a row for each."""
        rows = [row for one in self.solved if isinstance(one, SolvedAxis) and not self.cases for row in set_rows(one)]
        return super()._repr_html_() + (as_html([[*row.values()] for row in rows], [*rows[0]]) if rows else "")

    @property
    def _notes(self) -> tuple[str, ...]:
        status = f"{self.status}: {self.reason}" if self.reason else self.status
        worth = () if self.cases or not self.converged else (expected_words(self.solved[0].expected),)
        return (f"{self.scene}, {title_of(self.model)}: {status}", *worth, *self.warnings)

    def __repr__(self) -> str:
        """Return scene, model and status, then loads, displacement, pressure and life in a line each."""
        w, u = self.worst, self.displacement
        largest = None if self.loads is None or not self.loads.size else float(self.loads.max())
        lines = (
            ("loads", "largest", largest, "N"),
            ("displacement", "axial", None if u is None else 1e6 * float(u[2]), "um"),
            ("pressure", "largest", None if w is None else 1e-6 * w.pressure, "MPa"),
            ("life", "L10", None if self.life is None else 1e-6 * self.life.L10, "million revolutions"),
        )
        told = (f"{name}: none" if x is None else f"{name}: {what} {x:.5g} {unit}" for name, what, x, unit in lines)
        return "\n".join([self._notes[0], *told])


def make_result(
    solved: Sequence[Solved | SolvedAxis],
    tangents: Sequence[Tangent | None],
    at_nut: Sequence[Tangent | None],
    cycle: DutyCycle | None = None,
    together: CycleResults | None = None,
) -> Result:
    """Make the result of a solved scene, or of the load cases of a duty cycle.

    Parameters
    ----------
    solved
        Records of the solver, one for each load case.
    tangents
        Stiffness of each at the requested station; None without such a station.
    at_nut
        Stiffness of each at the nut's centre; None where it was not computed.
    cycle
        Duty cycle of the load cases; None for a single scene.
    together
        Sums over the load cases, such as their life; None for a single scene.

    Returns
    -------
    Result
        The result, with each load case in ``cases``.
    """
    each = [_of_one(*one) for one in zip(solved, tangents, at_nut, strict=True)]
    if cycle is None or together is None:
        return each[0]
    lost = next((one for one in each if not one.converged), each[0])
    unsolved = "; ".join(f"case {name}: {status}" for name, status in together.unsolved.items())
    worst = [one.worst for one in each if one.worst is not None]
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
        life=_life_result(together.least.life, together.speed),
        modified_life=together.least.modified,
        reference_life=together.least.reference,
        axis_life=together.axis_life,
        cases={case.name: one for case, one in zip(cycle.cases, each, strict=True)},
        solved=tuple(solved),
        tangents=tuple(tangents),
        cycle=cycle,
        together=together,
    )


def _of_one(one: Solved | SolvedAxis, tangent: Tangent | None, at_nut: Tangent | None) -> Result:
    """Make the result of one load case."""
    found = one.result
    head = Result(
        scene=one.scene.name,
        model=found.model,
        member=found.member,
        status=Status(found.status.kind),
        reason=found.status.reason,
        warnings=tuple(map(str, found.warnings)),
        assumed=found.assumed,
        left_out=found.left_out,
        solved=(one,),
        tangents=(tangent,),
    )
    return _of_set(head, one, tangent, at_nut) if isinstance(one, Solved) else _of_axis(head, one)


def _of_set(head: Result, one: Solved, tangent: Tangent | None, at_nut: Tangent | None) -> Result:
    """Return a result with the answers of a scene with one set filled in."""
    answers = one.answers
    balls = _ball_rows(one.scene, one.result, solved=answers is not None)
    if answers is None:
        return replace(head, azimuth=balls.azimuth, z=balls.z)
    speed = None if one.scene.motion is None else one.scene.motion.speed
    K = tangent if tangent is not None and tangent.status == "converged" else at_nut
    return replace(
        head,
        **vars(balls),
        force=answers.force,
        displacement=answers.motion,
        rigidity=None if answers.rigidities is None else answers.rigidities.unequal,
        stiffness=None if K is None else K.matrix,
        axial_stiffness=None if at_nut is None else at_nut.rigidity("uz"),
        worst=_worst_contact("", answers.loads),
        life=_life_result(answers.loads.life, speed),
        modified_life=answers.loads.modified,
        reference_life=answers.loads.reference,
        shaft=answers.shaft,
        preload=_preload_result(answers.preload),
        bearing_torque=answers.torque,
        expected_error=expected_error(one.expected),
    )


def _of_axis(head: Result, one: SolvedAxis) -> Result:
    """Return a result with the answers of several sets on one shaft filled in."""
    found, answers = one.result, one.answers
    speed = None if one.scene.motion is None else one.scene.motion.speed
    each = [None] * len(found.sets) if answers is None else [*answers.sets]
    sets = {s.of.name: _set_result(s, x, speed) for s, x in zip(found.sets, each, strict=True)}
    if answers is None:
        return replace(head, sets=sets)
    balls = [s for s in sets.values() if s.loads is not None]
    joined: dict[str, Any] = {
        name: np.concatenate([getattr(s, name) for s in balls]) if balls else None for name in vars(Balls())
    }
    worst = next((sets[found.sets[i].of.name].worst for i in answers.by_pressure), None)
    lives = [s.life for s in sets.values() if s.life is not None]
    moved = answers.displacement
    return replace(
        head,
        **joined,
        sets=sets,
        force=answers.force,
        displacement=answers.motion,
        rigidity=answers.force / moved if moved and answers.force else None,
        stiffness=found.stiffness,
        axial_stiffness=None if found.stiffness is None else float(found.stiffness[2, 2]),
        worst=worst,
        life=min(lives, key=lambda life: life.L10, default=None),
        drive=one.drive,
        axis_life=one.life,
    )


def _set_result(s: SolvedSet, answers: SetAnswers | None, speed: float | None) -> SetResult:
    """Make the result of one of several sets on a shaft."""
    known = answers is not None
    balls = (
        _ball_rows(answers.parts, s.balls, solved=True)
        if answers and s.balls and isinstance(answers.parts, Scene)
        else None
    )
    loads = None if answers is None else answers.loads
    return SetResult(
        **({} if balls is None else vars(balls)),
        name=s.of.name,
        kind=s.of.kind,
        position=s.of.position,
        force=s.force if known else None,
        moment=s.moment if known else None,
        stiffness=s.stiffness if known else None,
        roller_loads=s.roller_load if known else None,
        worst=None if loads is None else _worst_contact(s.of.name, loads),
        life=None if loads is None else _life_result(loads.life, speed),
        rib=loads.rib if isinstance(loads, RollerAnswers) else None,
        torque=loads.torque if isinstance(loads, RollerAnswers) else None,
        preload=None if answers is None else _preload_result(answers.preload),
        bearing_torque=None if answers is None else answers.torque,
        reference_life=None if loads is None else loads.reference,
    )


def _ball_rows(scene: Scene, found: StaticResult, *, solved: bool) -> Balls:
    """Return positions, loads, angles and pressures of the balls of a set; only positions unless ``solved``."""
    if not solved:
        return Balls(azimuth=found.azimuth, z=found.z)
    angles = np.where(found.load > 0.0, found.contact_angle, np.nan)
    pressure = pole_pressure(scene, found)
    return Balls(azimuth=found.azimuth, z=found.z, loads=found.load, angles=angles, pressure=pressure)


def _worst_contact(name: str, answers: LoadAnswers | RollerAnswers) -> WorstContact | None:
    """Return the contact with the highest pressure, under the name of its set; None without load."""
    w, safety = answers.worst, answers.safety
    if w is None or safety is None:
        return None
    if isinstance(w, Contact):
        return WorstContact(name, w.ball, w.side, w.force, w.pressure, safety.factor, w.angle, w.approach, (w.a, w.b))
    return WorstContact(name, w.roller, w.race, w.force, w.pressure, safety.factor, None, None, None)


def _life_result(known: rating.Life | None, speed: float | None) -> Life | None:
    """Convert a rated life to the record of the library; None without one."""
    if known is None:
        return None
    seconds = 3600.0 * known.hours(speed) if speed else None
    return Life(1e6 * known.revolutions, known.distance, seconds, known.rating, known.equivalent, known.standard)


def _preload_result(known: loading.Preload | None) -> Preload | None:
    """Convert a preload to the record of the library; None without one."""
    return None if known is None else Preload(known.mean, known.largest, known.axial, known.loaded)


def expected_error(m: ModelForm | None) -> ExpectedError | None:
    """Convert an estimate of the model's error to the record that results show.

    Parameters
    ----------
    m
        Estimate by `rollbench.compare.models.model_form`; None where there is none.

    Returns
    -------
    ExpectedError or None
        The record; None without an estimate.
    """
    if m is None:
        return None
    others = m.displacement_percent, m.rigidity_percent, m.pressure_percent
    return ExpectedError(m.percent, m.rms_percent, *others, m.nearest, m.words)


def _contact_columns(one: Balls) -> dict[str, Array | list[str]]:
    """Return the columns of `Result.columns` for the balls of one set; empty without loads."""
    if one.azimuth is None or one.z is None or one.loads is None or one.angles is None or one.pressure is None:
        return {}
    out: dict[str, Array | list[str]] = {"ball": np.arange(1.0, one.z.size + 1), "azimuth_rad": one.azimuth, "z_m": one.z}
    for name, values in (("load_{}_N", one.loads), ("angle_{}_rad", one.angles), ("pressure_{}_Pa", one.pressure)):
        out |= {name.format(side): column for side, column in zip(SIDES, values.T, strict=True)}
    return out


def _stack_arrays(key: str, each: Mapping[str, Mapping[str, Array | list[str]]]) -> dict[str, Array | list[str]]:
    """Stack columns of several sets or cases; the first column, ``key``, holds their names."""
    known = {name: columns for name, columns in each.items() if columns}
    names = [name for name, columns in known.items() for _ in columns["ball"]]
    out: dict[str, Array | list[str]] = {key: names} if known else {}
    for column in next(iter(known.values()), {}):
        parts = [columns[column] for columns in known.values()]
        out[column] = [x for part in parts for x in part] if isinstance(parts[0], list) else np.concatenate(parts)
    return out
