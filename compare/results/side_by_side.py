"""Records that `rollbench.side_by_side` returns: stiffness, torque and life of several scenes, computed by one model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from rollbench.compare.measure import error_percent
from rollbench.compare.models.stiffness import NutAndLoadPoint
from rollbench.compare.quantities import Quantity, json_number, quantities_of_record, record_as_json
from rollbench.compare.results.base import JSON, TabularRecord, add_schema_version, values_in_words
from rollbench.compare.results.solved import Result
from rollbench.lowfi.warned import ResultWarning
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Scene
from rollbench.meshes.quantity import QuantityDescription, quantity_field, result_record
from rollbench.reports.content import Figure, Panel, Series

#: Range of a quantity: its lower and upper limit.
Band = tuple[float, float]
#: Attributes of scenes whose equality is checked when scenes are compared, each with the text to show if they differ.
SHARED = {
    "loads": "loads",
    "housings": "housings and their loads",
    "supports": "supports",
    "segments": "segments of the shaft",
    "stiffness_at": "position of the stiffness",
    "thermal_strain": "thermal strain",
    **{name: f"[{name}]" for name in ("drive", "motion", "lubricant", "friction")},
}


@result_record(kw_only=True)
class Alternative(NutAndLoadPoint):
    """Results of one of several scenes that are compared side by side.

    A field is None if there is no equilibrium, or if the scene does not state the data that the quantity needs.
    """

    scene: str = quantity_field("scene")
    """Name of the scene."""
    status: str = quantity_field("status", "converged, or the reason why there is no equilibrium")
    radial_stiffness: float | None = quantity_field(
        "radial_stiffness_N_per_um",
        "smallest radial tangent stiffness of all directions, with all other degrees of freedom fixed: of a single nut or "
        "bearing at its centre without its shaft, of several with their shaft at the position that the scene states; null "
        "where scenes of both kinds stand side by side",
        heading="radial rigidity",
    )
    largest: float | None = quantity_field(
        "largest_load_N",
        "largest load of a contact or roller in any nut or bearing of the scene",
        heading="largest contact load",
    )
    pressure: float | None = quantity_field("pressure_MPa", "pressure of the worst contact", heading="peak pressure")
    safety: float | None = quantity_field("static_safety", "static safety of the worst contact")
    running: Band | None = quantity_field(
        "running_torque_Nmm",
        "torque that turns the shaft at constant speed, [low, high]: of an axis `drive.running_torque_Nmm`, of a bearing "
        "its friction torque, of a ball screw the torque that drives the screw",
        error="empirical; that of the coefficient of friction",
        parts="[]",
        heading="torque, running",
    )
    starting: Band | None = quantity_field(
        "starting_torque_Nmm",
        "torque that starts the shaft from rest, [low, high]",
        error="as the running torque",
        parts="[]",
        heading="torque from rest",
    )
    inertia: float | None = quantity_field(
        "inertia_kg_mm2",
        "moment of inertia of the axis at its motor, the motor's own included",
        heading="moment of inertia",
    )
    basic: float | None = quantity_field(
        "L10_million_revolutions",
        "life L10 (ISO 3408-5 of a nut, ISO 281 of a bearing) of all nuts and bearings of an axis as one system, or of a "
        "single nut or bearing; null if that of one is not known",
        error="that of the lives",
        heading="life L10",
    )
    life: float | None = quantity_field(
        "life_million_revolutions",
        "life by the contact loads (L10 of a nut, L10r of a bearing) of all nuts and bearings of an axis as one system, or "
        "of a single nut or bearing",
        error="that of the lives",
        heading="life by contact loads",
    )
    hours: float | None = quantity_field(
        "life_hours",
        "this life in hours, if the scene states a speed",
        error="that of the life in revolutions",
        heading="life by contact loads",
    )
    shortest: str | None = quantity_field("shortest_set", "nut or bearing of an axis with the shortest life")
    warnings: tuple[ResultWarning, ...] = quantity_field("warnings")
    """Warnings about results outside the model's range of validity."""


#: JSON keys of all numbers of an `Alternative`, for which differences are computed.
NUMBERS = [key for key, one in quantities_of_record(Alternative).items() if one.unit or key == "static_safety"]


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class SideBySide(TabularRecord):
    """Results of several scenes, computed by one model, and the list of input data in which the scenes differ.

    Examples
    --------
    >>> import rollbench
    >>> both = rollbench.side_by_side(["lin-case1", "lin-case2"], model="lin")
    >>> both.scenes[1].scene, round(both.scenes[1].largest), both.differ
    ('lin-case2', 282, ())
    """

    model: str
    """Name of the model that solved all scenes."""
    scenes: tuple[Alternative, ...]
    """Results of each scene, in the order in which the scenes were stated."""
    differ: tuple[str, ...]
    """Names of the data of shaft, loads and operation that differ between the scenes; empty for variants of one axis."""

    @property
    def converged(self) -> bool:
        """Whether every scene has an equilibrium."""
        return all(one.status == "converged" for one in self.scenes)

    @property
    def inputs_in_words(self) -> str:
        """Words on which data of shaft, loads and operation differ between the scenes."""
        if not self.differ:
            return "shaft, loads and operation are the same in all scenes"
        return f"not the same in all scenes: {', '.join(self.differ)}"

    @QuantityDescription(
        "difference_percent",
        "difference of a scene's number from that of the first scene, in per cent of the latter; for a torque, which has a "
        "range, between the middles of the ranges",
        parts=".*[]",
    )
    def difference_percent(self, key: str) -> tuple[float | None, ...]:
        """Return by how much a number of each scene differs from the same number of the first scene [% of the first].

        Parameters
        ----------
        key
            Key of the number in the JSON, such as ``"largest_load_N"``. For a torque, the middle of its range is compared.

        Returns
        -------
        tuple[float | None, ...]
            Difference for each scene [%]; None if the number is missing in this scene or in the first, or zero in the
            first.

        Examples
        --------
        >>> import rollbench
        >>> both = rollbench.side_by_side(["lin-case1", "lin-case2"], model="lin")
        >>> [round(x, 1) for x in both.difference_percent("nut_displacement_um")]
        [0.0, -0.6]
        """
        values = map(quantities_of_record(Alternative)[key].value, self.scenes)
        middles = [None if x is None else float(np.mean(x)) for x in values]
        first = middles[0]
        if first is None:
            return (None,) * len(middles)
        return tuple(None if x is None else json_number(float(error_percent(x, first))) for x in middles)

    @property
    def numbers(self) -> dict[str, Quantity]:
        """Quantities that at least one scene answers, by their JSON keys."""
        of = quantities_of_record(Alternative)
        return {key: of[key] for key in NUMBERS if any(of[key].value(one) is not None for one in self.scenes)}

    def frame_rows(self) -> Sequence[Mapping[str, Any]]:
        """Return a row for each scene; a range of torque has a column for each end.

        Returns
        -------
        list
            Row of each line of the frame, by the names of its columns.
        """
        rows = []
        for one in self.scenes:
            row: dict[str, Any] = {"scene": one.scene, "status": one.status}
            for key, quantity in self.numbers.items():
                value = quantity.value(one)
                if isinstance(value, list):
                    row |= {f"{end}_{key}": x for end, x in zip(("lowest", "highest"), value, strict=True)}
                else:
                    row[key] = value
            rows.append(row)
        return rows

    @property
    def _notes(self) -> tuple[str, ...]:
        """Lines below the table: which input differs, then the difference of each quantity from the first scene."""
        each = (values_in_words({x.label: list(self.difference_percent(key))}) for key, x in self.numbers.items())
        return (self.inputs_in_words, *(f"difference in per cent: {words}" for words in each))

    def figure(self) -> Figure | None:
        """Return the figure of every quantity's difference from the first scene, in per cent, by scene.

        Returns
        -------
        reports.content.Figure or None
            The figure, as the report draws it; None if there is nothing to draw.
        """
        shown = {key: self.difference_percent(key) for key in self.numbers}
        keys = [key for key, off in shown.items() if any(off)]
        if not keys:
            return None
        series = [
            Series(
                one.scene,
                [x for x in column if x is not None],
                [1.0 + y for y, x in enumerate(column) if x is not None],
                "markers",
                bold=True,
            )
            for one, column in zip(self.scenes, zip(*(shown[key] for key in keys), strict=True), strict=True)
        ]
        names = [self.numbers[key].label for key in keys]
        panel = Panel("", f"difference from {self.scenes[0].scene} / %", "", series, ordinate_names=names)
        title = f"Difference of each result from that of {self.scenes[0].scene}"
        return Figure("side-by-side", title, (panel,), columns=1, size=(7.6, 1.4 + 0.3 * len(keys)))

    def to_dict(self) -> dict[str, JSON]:
        """Return the comparison as a dictionary, as ``rollbench solve A B --json`` prints it.

        Returns
        -------
        dict
            JSON values by key.
        """
        off: dict[str, Any] = {key: list(self.difference_percent(key)) for key in NUMBERS}
        scenes = [record_as_json(one) for one in self.scenes]
        return add_schema_version(
            {"model": self.model, "scenes": scenes, "difference_percent": off, "not_shared": list(self.differ)}
        )


def compare_results_side_by_side(results: Sequence[Result], names: Sequence[str]) -> SideBySide:
    """Compare the results of several scenes; for a duty cycle, of the first load case, with the life over all load cases.

    Parameters
    ----------
    results
        Results of the scenes, all computed by the same model.
    names
        Names under which the scenes are listed.

    Returns
    -------
    SideBySide
        The comparison.
    """
    scenes = tuple(_alternative_of_result(one, name) for one, name in zip(results, names, strict=True))
    if len({isinstance(one.described, Assembly) for one in results}) > 1:  # the shaft is in one and not in the other
        scenes = tuple(replace(one, radial_stiffness=None) for one in scenes)
    first = [next(iter(one.cases.values()), one) for one in results]
    if len({x.nut.of.rstrip("s").split()[-1] for x in first if x.nut is not None}) > 1:  # a nut beside bearings
        scenes = tuple(replace(one, nut_tangent=None, nut_displacement=None) for one in scenes)
    if len({x.load_point.along for x in first if x.load_point is not None}) > 1:
        scenes = tuple(replace(one, load_point_tangent=None, load_point_displacement=None) for one in scenes)
    differ = _names_of_differing_inputs([one.described for one in results])
    return SideBySide(model=results[0].model, scenes=scenes, differ=tuple(differ))


def _alternative_of_result(result: Result, name: str) -> Alternative:
    """Return the results of one scene that are listed when several scenes are compared side by side.

    ``result``: results of the scene; of a duty cycle, the first load case is used, and the life over all cases. ``name``:
    name under which the scene is listed.
    """
    first = next(iter(result.cases.values()), result)
    K, worst, life, system = first.stiffness, first.worst, result.life, result.axis_life
    running, starting, inertia = _torque_ranges_and_inertia(first)
    across = None if K is None or not np.isfinite(K[:2, :2]).all() else float(np.linalg.eigvalsh(K[:2, :2])[0])
    nut, at_load = first.nut, first.load_point
    loads = [x.max() for x in (first.loads, *(s.roller_loads for s in first.sets.values())) if x is not None and x.size]
    revolutions = hours = None
    basic = None if life is None else life.revolutions
    if system is not None:
        revolutions, hours, basic = system.revolutions, system.hours, system.basic
    elif (reference := result.reference_life) is not None:
        revolutions, hours = reference.revolutions, reference.hours
    elif life is not None:
        revolutions, hours = life.revolutions, life.hours
    return Alternative(
        scene=name,
        status=result.status if result.converged else f"{result.status}: {result.reason}",
        nut_tangent=None if nut is None else nut.tangent,
        load_point_tangent=None if at_load is None else at_load.tangent,
        radial_stiffness=across,
        nut_displacement=None if nut is None else nut.displacement,
        load_point_displacement=None if at_load is None else at_load.displacement,
        largest=float(max(loads)) if loads else None,
        pressure=None if worst is None else worst.pressure,
        safety=None if worst is None else worst.safety,
        running=running,
        starting=starting,
        inertia=inertia,
        basic=basic,
        life=revolutions,
        hours=hours,
        shortest=None if system is None else system.shortest,
        warnings=result.warnings,
    )


def _torque_ranges_and_inertia(one: Result) -> tuple[Band | None, Band | None, float | None]:
    """Return running torque and starting torque (low, high) [N m], then inertia [kg m^2] of a scene; None if not known."""
    if one.drive is not None:
        return one.drive.running, one.drive.starting, one.drive.inertia
    if one.bearing_torque is not None:
        return one.bearing_torque.running, one.bearing_torque.starting, None
    sums = None if one.only is None else one.only.friction
    driving = None if sums is None else sums.driving_torque_on_screw
    return None if driving is None else (driving, driving), None, None


def _names_of_differing_inputs(scenes: Sequence[Scene | Assembly]) -> list[str]:
    """Return the names of the input data of shaft, loads and operation that differ between the scenes."""
    kinds = {isinstance(x, Assembly) for x in scenes}
    out = ["number of nuts and bearings (one, or several on a shaft)"] if len(kinds) > 1 else []
    shafts = [(x.screw.length, x.screw.outer_diameter, x.screw.bore, x.screw.material) for x in scenes]
    if any(x != shafts[0] for x in shafts[1:]):
        out.append("shaft")
    for name, words in SHARED.items():
        values = [getattr(x, name) for x in scenes if hasattr(x, name)]
        if any(x != values[0] for x in values[1:]):
            out.append(words)
    return out
