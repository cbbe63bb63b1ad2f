"""Record that `rollbench.solve` returns: contact loads, displacement, stiffness and life of a scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rollbench.compare.measure import error_percent, mean_load
from rollbench.compare.models import answers
from rollbench.compare.models.load_cases import AxisDrive, DutyCycleResults
from rollbench.compare.models.loading import LiftOff, LoadPath, Preload
from rollbench.compare.models.model_form import ExpectedError
from rollbench.compare.models.programs import model_title
from rollbench.compare.models.registry import has_random_errors
from rollbench.compare.models.set_results import Balls, SetResult, flank_load_summaries
from rollbench.compare.models.stiffness import LoadPointStiffness, NutStiffness, stiffness_together
from rollbench.compare.quantities import count_with_noun, json_number, record_as_json
from rollbench.compare.results.base import HEADINGS, JSON, Row, TabularRecord, add_schema_version, format_table_as_html
from rollbench.compare.results.rows import (
    bearing_and_nut_rows,
    duty_cycle_rows,
    expected_error_sentence,
    nested_records,
    record_rows,
    support_load_rows,
)
from rollbench.compare.scenes.duty_cycle import DutyCycle
from rollbench.lowfi.rating.catalogue_checks import ShaftLimits
from rollbench.lowfi.rating.contacts import WorstContact
from rollbench.lowfi.rating.life import Life
from rollbench.lowfi.statics.result import AxisResult, StaticResult, motion_in_um_and_mrad
from rollbench.lowfi.statics.tangent import TangentStiffness
from rollbench.lowfi.warned import ResultWarning, join_brief_warnings
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import SIDES, Scene
from rollbench.meshes.quantity import QuantityDescription, quantity_field, quantity_or_none, result_record, text_or_none

if TYPE_CHECKING:
    from rollbench.compare.reference.estimate import Reference
    from rollbench.lowfi.bearings.torque import BallBearingTorque
    from rollbench.lowfi.rating.iso_lives import ModifiedLife, ReferenceLife
    from rollbench.lowfi.rating.life import SystemLife
    from rollbench.reports.content import Figure, LoadCaseView, Panel, SceneView

#: JSON keys of a nut or bearing that are not repeated in the summary of the whole shaft.
OF_A_SET = (
    "sides",
    "nut",
    "preload",
    "starting_torque",
    "bearing_torque",
    "clearance",
    "roller_torque",
    "contact_lost",
    "shaft",
)


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


@result_record
class AxialResults:
    """Axial force [N] on a screw, bearing or shaft, and a stiffness of the model liu [N/m]."""

    force: float = quantity_field(
        "force_N",
        "axial force on the screw, from the external loads and the reactions; positive towards larger z",
        heading="axial force",
    )
    stiffness_over_load_step: float | None = quantity_or_none(
        "stepped_N_per_um",
        "stiffness by the model liu over the load step `ingredients.load_step`, at the first loaded ball (Liu, equations "
        "19 to 22)",
        error="not known: the model has not been compared with the 3D reference",
        heading="rigidity over the load step",
        optional=True,
    )


@result_record
class AxisPointDisplacement:
    """Displacement and rotation (6,) [m, rad] of a point on the screw's axis, at an axial position [m]."""

    z: float = quantity_field("z_mm", "axial position of a point on the screw's axis")
    motion: Array = quantity_field(
        "ux_um",
        "displacement of this point along x",
        QuantityDescription("uy_um", "displacement of this point along y", show=lambda motion: motion[1]),
        QuantityDescription("uz_um", "displacement of this point along z", show=lambda motion: motion[2]),
        show=lambda motion: motion[0],
    )


@result_record(eq=False, repr=False, kw_only=True)
class Result(TabularRecord, Balls):
    """Results of a low-order model for a scene: contact loads, displacement, stiffness, pressures and life.

    If there is no equilibrium, the results are None, and `status` and `reason` say why. `sets` has the results of each nut
    or bearing; the arrays list the balls of all, one nut or bearing after the other. With several load cases, `cases` has
    the result of each; `life` is then the life under all cases, and `worst` the worst contact of all.

    Examples
    --------
    >>> import rollbench
    >>> result = rollbench.solve("lin-case1", "lin")
    >>> result.converged, round(result.worst.pressure / 1e6), result.worst.element, result.worst.side
    (True, 2618, 12, 'SL')
    """

    described: Scene | Assembly
    """The solved scene; with load cases, that of the first."""
    solution: StaticResult | AxisResult
    """Solution of the model with status, warnings, equilibrium and centreline; the contact loads are those of `sets`."""
    sets: Mapping[str, SetResult] = field(default_factory=dict)
    """Results of each nut or bearing, by name; the name of the only one of a scene is empty."""
    axial: AxialResults | None = quantity_or_none("axial")
    """Axial force of the screw on the nut [N]; with several nuts or bearings on one shaft, the sum of the axial loads on
    shaft and housings."""
    load_point: LoadPointStiffness | None = quantity_or_none("load_point")
    """Displacement [m] and stiffness [N/m] of the point on which the load acts, to ground: shaft and supports included."""
    tangent_words: str = text_or_none("tangent_words")
    """Why there is no tangent stiffness; empty if there is one, or if the model never gives one."""
    displacement: Array | None = quantity_or_none(
        "displacement",
        "displacement and rotation, from the scene without loads, of the section or housing on which the load acts",
        show=lambda moved: None if moved is None else motion_in_um_and_mrad(moved),
        parts=".*",
    )
    """Displacement of the screw's cross-section or housing on which the load acts from its unloaded position, (6,)
    [m, rad], in the degrees of freedom ux, uy, uz, rx, ry, rz; without a force, at the nut's centre or ``stiffness_at``."""
    tangent: TangentStiffness | None = None
    """Tangent stiffness of the screw's cross-section at the nut's centre, or at ``stiffness_at``, with the nut fixed; None
    with several nuts or bearings on one shaft, and if it is not computed."""
    shaft: ShaftLimits | None = quantity_or_none("shaft")
    """Buckling load [N], critical speed [rad/s] and DN value [m rad/s] of the screw, of several nuts that of the one with
    the lowest allowed speed; None without a nut, and if no bearing holds the shaft laterally."""
    load_path: LoadPath | None = quantity_or_none("load_path")
    """How the supports and the contacts share the loads of the scene; None without loads."""
    drive: AxisDrive | None = quantity_or_none("drive")
    """Torques [N m] and moments of inertia [kg m^2] at the motor of an axis; None for a single nut or bearing."""
    axis_life: SystemLife | None = quantity_or_none("axis_life")
    """Life of all nuts and bearings of a shaft as one system, under all load cases; None for a single nut or bearing."""
    expected_error: ExpectedError | None = None
    """Error to expect of the model's results, or why it is not known; None with load cases: see each of `cases`."""
    cases: Mapping[str, Result] = field(default_factory=dict)
    """Results of each load case, by name; empty without load cases."""

    @property
    def scene(self) -> str:
        """Name of the scene."""
        return self.described.name

    @property
    def model(self) -> str:
        """Name of the model."""
        return self.solution.model

    @property
    def member(self) -> int:
        """Number of the specimen, from 0, in a scene with random errors."""
        return self.solution.member

    @property
    def status(self) -> Status:
        """Outcome of the solution; with load cases, the outcome of the first case that did not converge."""
        return Status(self.solution.status.kind)

    @property
    def reason(self) -> str:
        """Why there is no equilibrium; empty if there is one."""
        return self.solution.status.reason

    @property
    def warnings(self) -> tuple[ResultWarning, ...]:
        """Warnings about results outside the model's range of validity."""
        return self.solution.warnings

    @property
    def assumed(self) -> tuple[str, ...]:
        """Assumptions made by the scene and by the model."""
        return self.solution.assumed

    @property
    def left_out(self) -> tuple[str, ...]:
        """Effects that the model neglects in this scene."""
        return self.solution.left_out

    @property
    def only(self) -> SetResult | None:
        """Results of the nut or bearing of a scene with a single one; None with several on one shaft."""
        return self.sets.get("")

    @property
    def ball_sets(self) -> list[tuple[Scene, StaticResult]]:
        """Geometry and solution of each nut or bearing with balls."""
        return [pair for s in self.sets.values() for pair in s.ball_sets]

    @property
    def force(self) -> float | None:
        """Axial force of the screw on the nut [N]; of several nuts or bearings, sum of the loads on shaft and housings."""
        return None if self.axial is None else self.axial.force

    @property
    def stiffness(self) -> Array | None:
        """Tangent stiffness (6, 6) [N/m, N, N m] of the screw's cross-section, see `tangent`.

        With several nuts or bearings on one shaft: stiffness of the whole axis, nan in fixed degrees of freedom. None if
        the model gives no stiffness.
        """
        if isinstance(self.solution, AxisResult):
            return self.solution.stiffness
        return None if self.tangent is None or self.tangent.status != "converged" else self.tangent.matrix

    @property
    @QuantityDescription("nut")
    def nut(self) -> NutStiffness | None:
        """Displacement [m] and stiffness [N/m] of the nut or bearing between its two parts, without shaft and wind-up.

        Of several nuts, or bearings where there is no nut, together. None if there is no equilibrium.
        """
        each = [s.nut for s in self.sets.values() if s.nut is not None]
        return stiffness_together(each) if each else None

    @property
    def place_of_stiffness(self) -> str:
        """Place at which `stiffness` is taken, and what is held fixed, as text; empty without a stiffness."""
        if isinstance(self.solution, AxisResult):
            return f"at {self.solution.stiffness_at}, with the supports of the scene fixed"
        at = self.tangent
        return "" if at is None else f"of the screw's cross-section at {1e3 * at.station:.6g} mm, with the nut fixed"

    @property
    def worst_set(self) -> SetResult | None:
        """The nut or bearing whose highest pressure is the largest share of its allowed pressure; None without load."""
        return next((self.sets[name] for name in answers.names_by_pressure(self.sets)), None)

    @property
    @QuantityDescription(
        "worst_set", "nut or bearing row whose highest pressure is the largest share of its allowed pressure", optional=True
    )
    def number_of_worst_set(self) -> int | None:
        """Number (from 1) of `worst_set` on a shaft with several nuts or bearings."""
        return None if self.only or not self.worst_set else [*self.sets].index(self.worst_set.name) + 1

    @property
    def worst(self) -> WorstContact | None:
        """Contact with the highest pressure, or None if no contact is loaded.

        With several nuts or bearings on one shaft, the contact with the highest ratio of pressure to allowed pressure.
        """
        return None if self.worst_set is None else self.worst_set.worst

    @property
    def life(self) -> Life | None:
        """Life L10; None if no contact is loaded, and where `life_words` gives another reason.

        With several nuts or bearings on one shaft, the shortest of theirs, None if that of a loaded one is not known.
        """
        turning = [s for s in self.sets.values() if s.life is not None or s.reference_life is not None]
        lives = [s.life for s in turning if s.life is not None]
        return min(lives, key=lambda life: life.L10, default=None) if len(lives) == len(turning) else None

    @property
    def life_words(self) -> str:
        """Why a single nut or bearing has no life L10, such as a load that ISO 281 does not cover; else empty."""
        return "" if self.only is None else self.only.rating_refused or self.only.life_words

    @property
    def modified_life(self) -> ModifiedLife | None:
        """Life of a single nut or bearing, modified for reliability, lubricant and contamination [10^6 revolutions].

        None if the scene states none of the three.
        """
        return None if self.only is None else self.only.modified_life

    @property
    def reference_life(self) -> ReferenceLife | None:
        """Life of a single bearing by ISO/TS 16281 [10^6 revolutions]; None for screws, and if no contact is loaded."""
        return None if self.only is None else self.only.reference_life

    @property
    @QuantityDescription("contact_lost")
    def lift_off(self) -> LiftOff | None:
        """External load at which the first preloaded contact of all nuts and bearings opens; None without preload."""
        found = [s.lift_off for s in self.sets.values() if s.lift_off is not None]
        return min(found, key=lambda x: np.inf if x.factor is None else x.factor, default=None)

    @property
    def preload(self) -> Preload | None:
        """Contact loads without the loads of the scene; with several nuts or bearings, see each of `sets`."""
        return None if self.only is None else self.only.preload

    @property
    def bearing_torque(self) -> BallBearingTorque | None:
        """Friction torque of a single bearing [N m]; None for nuts, and if no contact is loaded."""
        return None if self.only is None else self.only.bearing_torque

    @property
    def discretisation_percent(self) -> float | None:
        """Error of the loads due to the length of the beam elements [% of the mean contact load]; None if not estimated."""
        change, one = self.solution.solver.discretisation, self.only
        if change is None or one is None or one.loads is None:
            return None
        return json_number(float(error_percent(change, 0.0, mean_load(one.loads, one.nominal_contacts))))

    @property
    def converged(self) -> bool:
        """Whether an equilibrium was found, in every load case."""
        return self.status is Status.CONVERGED

    def to_dict(self) -> dict[str, JSON]:
        """Return the result as a dictionary, as ``rollbench solve --json`` prints it, with the stiffness that it contains.

        Returns
        -------
        dict
            JSON values by key; the keys end with the unit, such as ``max_N``.
        """
        return add_schema_version(self.to_json())

    def to_json(self) -> dict[str, Any]:
        """Return the result as JSON values by key, without the version number of their format.

        Returns
        -------
        dict
            JSON values by key.
        """
        found, of_axis = self.solution, dict[str, Any]()
        numbered = [({} if self.only else {"set": k}, s) for k, s in enumerate(self.sets.values(), 1)]
        if isinstance(found, AxisResult):
            of_axis = {
                "kind": getattr(self.described, "kind", ""),
                "sets": [n | record_as_json(s.on_shaft) | {"summary": s.to_json()} for n, s in numbered if s.on_shaft],
                "rollers": [n | record_as_json(row) for n, s in numbered for row in s.roller_rows()],
                "housings": [record_as_json(housing) for housing in found.housings],
                "stiffness": self._stiffness_json(),
            }
        line = zip(found.centreline_z, found.centreline, strict=True)
        return {
            "scene": self.scene,
            "model": self.model,
            "member": self.member if has_random_errors(self.described) else None,
            "status": found.status,
            **of_axis,
            "balls": [n | record_as_json(row) for n, s in numbered for row in s.ball_rows()],
            "summary": self.summary() if found.converged else {},
            "centreline": [record_as_json(AxisPointDisplacement(z, motion)) for z, motion in line],
            "equilibrium": record_as_json(found.equilibrium),
            "solver": record_as_json(found.solver) | {"discretisation_percent": self.discretisation_percent},
            "model_form": record_as_json(self.expected_error),
            "assumed": list(self.assumed),
            "left_out": list(self.left_out),
            "warning": join_brief_warnings(found.warnings) or None,
            "warnings": list(self.warnings),
        }

    def summary(self) -> dict[str, Any]:
        """Return the results of the whole scene, and those of its only nut or bearing or of the worst one, as JSON.

        Returns
        -------
        dict
            JSON values by key.
        """
        stiffness = self._stiffness_json()
        if self.only is not None:
            extra = {} if stiffness is None else {"stiffness": stiffness}
            return self.only.to_json() | record_as_json(self, "drive", "axis_life") | extra
        worst = {} if self.worst_set is None else self.worst_set.to_json()
        loads = self.loads
        data: dict[str, Any] = {key: value for key, value in worst.items() if key not in OF_A_SET}
        if loads is not None:
            data["sides"] = {side: record_as_json(x) for side, x in flank_load_summaries(loads).items()}
        return data | record_as_json(self) | {"stiffness": stiffness}

    def _stiffness_json(self) -> dict[str, Any] | None:
        """Return the tangent stiffness with its place as JSON, null in fixed degrees of freedom; None if not computed."""
        found, K = self.solution, self.tangent
        if K is not None:
            return record_as_json(K)
        if not isinstance(found, AxisResult) or found.stiffness is None:
            return None
        station = np.nan if found.station is None else found.station
        of_axis = TangentStiffness(station=station, status=found.status, matrix=found.stiffness)
        return {"at": found.stiffness_at} | record_as_json(of_axis)

    def frame_rows(self) -> Sequence[Mapping[str, Any]]:
        """Return a row for every ball: number and position, then load, contact angle and pressure on each groove flank.

        Units are SI. With several nuts, bearings or load cases, the first columns have their names.

        Returns
        -------
        list
            Row of each line of the frame, by the names of its columns.
        """
        rows = []
        for s in self.sets.values():
            if s.loads is None or s.angles is None:
                continue
            head = {} if self.only else {"set": s.name}
            for ball, angles in zip(s.ball_rows(), s.angles, strict=True):
                values = (("load_{}_N", ball.load), ("angle_{}_rad", angles), ("pressure_{}_Pa", ball.pressure))
                sides = {name.format(side): x for name, of in values for side, x in zip(SIDES, of, strict=True)}
                rows.append(head | {"ball": float(ball.index), "azimuth_rad": ball.azimuth, "z_m": ball.z} | sides)
        return rows

    def columns(self) -> dict[str, Any]:
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
        found = super().columns()
        return {name: column if isinstance(column[0], str) else np.array(column) for name, column in found.items()}

    def figure(self) -> Figure | None:
        """Return the figure of the contact loads: a panel for each loaded flank of each nut, bearing and load case.

        Returns
        -------
        reports.content.Figure or None
            The figure, as the report draws it; None if there is nothing to draw.
        """
        from rollbench.reports.content import Figure

        panels = self._panels()
        title = f"{self.scene}: contact loads by {model_title(self.model)}"
        return Figure("loads", title, panels) if panels else None

    def _panels(self, case: str = "") -> list[Panel]:
        """Return the panels of `figure`; ``case``: name of the load case, before that of the nut or bearing."""
        from rollbench.reports.content import Panel, Series

        found = []
        for name, one in self.sets.items():
            loads = np.zeros((0, len(SIDES))) if one.loads is None else one.loads
            balls = list(range(1, len(loads) + 1))
            for j in np.flatnonzero((loads > 0.0).any(axis=0)):
                title = ", ".join(filter(None, (case, name, f"flank {SIDES[j]}")))
                series = (Series("", balls, loads[:, j].tolist()),)
                found.append(Panel(title, "number_of_ball", "contact_load", series, include_zero=True, integer_x=True))
        return found

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
        from rollbench.reports.view import viewer_page_html

        if not any(one.converged for one in self.cases.values() or [self]):
            raise ValueError(f"{self.scene}: no loads to draw ({self.status}, {self.reason})")
        return viewer_page_html(self.scene_view(stores))

    def scene_view(self, stores: Sequence[Path] | None = None, given: Reference | None = None) -> SceneView:
        """Return the data of the 3D view of the scene and its load cases.

        Parameters
        ----------
        stores
            Folders with runs of the 3D reference; None: the runs shipped with rollbench.
        given
            User's reference loads, shown instead of the stored runs; None: there are none.

        Returns
        -------
        reports.content.SceneView
            What the 3D view shows.
        """
        from rollbench.reports.content import SceneView

        each = [one._load_case_view(name, stores, given) for name, one in (self.cases or {"": self}).items()]
        words = [count_with_noun(len(self.cases), "load case")] if self.cases else []
        words += [count_with_noun(len(self.sets), "set")] if len(self.sets) > 1 else []
        subtitle = ", ".join([self.scene, f"model {self.model}", *words])
        return SceneView(self.described.title, subtitle, each, self.to_dict())

    def _load_case_view(self, name: str, stores: Sequence[Path] | None, given: Reference | None) -> LoadCaseView:
        """Return the data of the load case ``name`` for the 3D view; ``stores`` and ``given`` are those of `scene_view`."""
        from rollbench.compare.reference.estimate import reference_of_scene
        from rollbench.compare.results.view import view_of_ball_row
        from rollbench.reports.content import LoadCaseView, NutOrBearingView

        scene, sets = self.described, list[NutOrBearingView]()
        if isinstance(scene, Scene) and self.only is not None:
            known, error = given or reference_of_scene(scene, stores), None
            if self.expected_error is not None and self.expected_error.loads is not None and self.loads is not None:
                error = 0.01 * self.expected_error.loads * mean_load(self.loads, self.only.nominal_contacts)
            return LoadCaseView(name, [view_of_ball_row(self.only, known, error)])
        for s in self.sets.values():
            if s.ball_sets:
                sets.append(view_of_ball_row(s))
            elif s.on_shaft is not None:
                sets.append(NutOrBearingView(s.name, s.kind, s.parts, s.position, s.on_shaft.of.thrust))
        return LoadCaseView(name, sets, scene if isinstance(scene, Assembly) else None)

    headings = HEADINGS

    def table(self) -> Sequence[Row]:
        """Return the rows of the table that ``rollbench solve`` prints.

        Returns
        -------
        Sequence[Row]
            A row for each quantity, such as the largest load; with load cases, the quantities of all cases together.
        """
        return self.rows()

    def rows(self, *, details: bool = False) -> list[Row]:
        """Return the rows of the table of results; empty if there is no equilibrium.

        For several nuts or bearings on a shaft, the rows of the whole shaft come first, then the rows of the nut or bearing
        with the worst contact.

        Parameters
        ----------
        details
            Whether to include quantities that a designer seldom needs.

        Returns
        -------
        list
            Rows of the table: quantity, value, unit, error to expect and note.
        """
        if not self.converged:
            return []
        supports, errors, whole = [*support_load_rows(self.load_path)], self.expected_error, nested_records(self)
        if self.only is not None:
            both = nested_records(self.only) | whole
            return [*record_rows(both, errors, (self, self.only), details=details), *supports]
        head = [*record_rows(whole, errors, (self,), details=details), *supports]
        if (worst := self.worst_set) is None:
            return head
        rows = record_rows(nested_records(worst, *OF_A_SET), errors, (worst,), details=details)
        return [*head, Row("nut or bearing, worst contact", worst.name), *rows]

    def _repr_html_(self) -> str:
        """Return the table as HTML for a notebook, and a second table of nuts and bearings if there are several."""
        rows = [] if self.only or self.cases or not self.converged else bearing_and_nut_rows(self.sets)
        return super()._repr_html_() + (format_table_as_html([[*row.values()] for row in rows], [*rows[0]]) if rows else "")

    @property
    def _notes(self) -> tuple[str, ...]:
        """Lines below the table: scene, model and status, then the sentence on the expected error, then warnings."""
        status = f"{self.status}: {self.reason}" if self.reason else self.status
        worth = () if self.cases or not self.converged else (expected_error_sentence(self.expected_error),)
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


@result_record(eq=False, repr=False, kw_only=True)
class CycleResult(Result):
    """Results of a scene with load cases: those of each case in `cases`, extremes and lives over all of them."""

    cycle: DutyCycle
    """The load cases."""
    together: DutyCycleResults
    """Extremes and lives over all load cases."""

    @property
    def scene(self) -> str:
        """Name of the scene."""
        return self.cycle.name

    @property
    def status(self) -> Status:
        """Outcome of the first case that did not converge."""
        return next((one.status for one in self.cases.values() if not one.converged), Status.CONVERGED)

    @property
    def reason(self) -> str:
        """Why there is no equilibrium in some cases; empty if there is one in all."""
        return "; ".join(f"case {name}: {status}" for name, status in self.together.unsolved.items())

    def _of_all_cases(self, name: str) -> tuple[Any, ...]:
        """Return the texts of the property ``name`` of all cases, each once."""
        return tuple(dict.fromkeys(words for one in self.cases.values() for words in getattr(one, name)))

    @property
    def warnings(self) -> tuple[ResultWarning, ...]:
        """Warnings about results outside the model's range of validity."""
        return self._of_all_cases("warnings")

    @property
    def assumed(self) -> tuple[str, ...]:
        """Assumptions made by the scene and by the model."""
        return self._of_all_cases("assumed")

    @property
    def left_out(self) -> tuple[str, ...]:
        """Effects that the model neglects in this scene."""
        return self._of_all_cases("left_out")

    @property
    def stiffness(self) -> None:
        """None: see each of `cases`."""

    @property
    def worst(self) -> WorstContact | None:
        """Contact with the highest pressure of all cases; None if no contact is loaded."""
        worst = [one.worst for one in self.cases.values() if one.worst is not None]
        return max(worst, key=lambda w: w.pressure, default=None)

    @property
    def life(self) -> Life | None:
        """Life L10 under all cases, of several nuts and bearings the shortest."""
        return self.together.shortest_lives.life

    @property
    def life_words(self) -> str:
        """Why there is no life L10; else empty."""
        return self.together.shortest_lives.life_words

    @property
    def modified_life(self) -> ModifiedLife | None:
        """Life under all cases modified for reliability, lubricant and contamination [10^6 revolutions]."""
        return self.together.shortest_lives.modified

    @property
    def reference_life(self) -> ReferenceLife | None:
        """Life of a bearing under all cases by ISO/TS 16281 [10^6 revolutions]; None for screws."""
        return self.together.shortest_lives.reference

    def to_json(self) -> dict[str, Any]:
        """Return the result as JSON: the results of each load case, and the extremes and lives over all cases.

        Returns
        -------
        dict
            JSON values by key.
        """
        each = zip(self.cycle.cases, self.cases.values(), strict=True)
        return {
            "scene": self.scene,
            "model": self.model,
            "status": self.reason or "converged",
            "summary": self.summary(),
            "cases": [{"scene": ""} | record_as_json(case) | one.to_json() | {"scene": self.scene} for case, one in each],
        }

    def summary(self) -> dict[str, Any]:
        """Return the extremes over all load cases, and the lives over the duty cycle, as JSON.

        With several nuts or bearings, ``sets`` has the lives of each.

        Returns
        -------
        dict
            JSON values by key.
        """
        lives = self.together.lives
        if len(lives) == 1:
            return record_as_json(self.together, "life_set", "axis_life") | record_as_json(lives[0])
        sets = [{"name": x.set} | record_as_json(x) for x in lives]
        return record_as_json(self.together) | record_as_json(self.together.shortest_lives) | {"sets": sets}

    def frame_rows(self) -> Sequence[Mapping[str, Any]]:
        """Return the rows of each load case, with the name of the case.

        Returns
        -------
        list
            Row of each line of the frame, by the names of its columns.
        """
        return [{"case": name} | dict(row) for name, one in self.cases.items() for row in one.frame_rows()]

    def _panels(self, case: str = "") -> list[Panel]:
        """Return the panels of `figure`, those of all load cases."""
        return [p for name, one in self.cases.items() for p in one._panels(", ".join(filter(None, (case, name))))]

    def table(self) -> Sequence[Row]:
        """Return the rows of the table with the quantities of all load cases together.

        Returns
        -------
        list
            Rows of the table.
        """
        return duty_cycle_rows(self.together)
