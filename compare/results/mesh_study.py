"""Records that `rollbench.mesh_study` returns: results of the 3D reference on several mesh levels, with uncertainties."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from rollbench.compare.measure import error_percent
from rollbench.compare.quantities import record_as_json
from rollbench.compare.results.base import JSON, TabularRecord, add_schema_version, values_in_words
from rollbench.meshes.quantity import quantity_field, quantity_or_none, result_record
from rollbench.reports.content import Figure, Panel, Series


@result_record(kw_only=True)
class MeshLevel:
    """One mesh level of a mesh study of the 3D reference."""

    level: int = quantity_field("level")
    """Number of the level; 1 is the coarsest."""
    cell_size: float = quantity_field("cell_size")
    """Ratio of the cell size on this level to that on the finest level [1]."""
    unknowns: int = quantity_field("unknowns")
    """Number of unknowns (displacements of nodes) of the whole mesh."""
    seconds: float = quantity_field("seconds")
    """Computing time of the 3D reference on this mesh level, set-up and solution without cached parts [s]."""
    measured_with: str | None = quantity_or_none("measured_with", optional=True)
    """Under which conditions the time was measured; None for a single roller."""
    cells: int | None = quantity_or_none("cells", optional=True)
    """Number of cells of the meshes of a single roller and its races; None for whole scenes."""
    cpu_seconds: float | None = quantity_or_none("cpu_seconds", optional=True)
    """Processor time of a single roller [s]; None for whole scenes."""
    imbalance: float | None = quantity_or_none("imbalance_percent", optional=True)
    """Difference between load and contact pressure of a single roller [% of the load]; None for whole scenes."""
    difference: float = quantity_field("difference_percent")
    """Largest difference of a contact load from the finest level [% of the mean contact load]. For a single roller in 3D:
    difference of its elastic approach [%]."""
    enough_for: float | None = quantity_field("enough_for_percent")
    """Uncertainty of the contact loads [% of the mean contact load], estimated from this level and the coarser levels. For
    a single roller in 3D: uncertainty of its elastic approach [%]. None if there is only one level."""


@dataclass(frozen=True)
class MeshQuantity:
    """Values of one quantity, such as the load of one contact, on the levels of a mesh study."""

    name: str
    """Name of the quantity, such as ``largest load, SL``."""
    unit: str
    """Unit of the values."""
    levels: tuple[int, ...]
    """Numbers of the mesh levels, coarsest first."""
    values: tuple[float, ...]
    """Value on every mesh level, coarsest first [unit]."""
    order: float | None = None
    """Observed order of convergence [1]; None if the values do not converge monotonically (contact loads often do not)."""
    extrapolated: float | None = None
    """Value extrapolated to zero cell size [unit]; None if no order of convergence was observed."""
    uncertainty: float | None = None
    """Uncertainty of the value on the finest level [unit]; None with a single level."""
    kind: str = ""
    """How the values converge; empty with a single level, and for a single roller."""
    modelling_spread: float | None = None
    """Combined effect of the varied modelling choices [unit]; None if none was varied."""
    scene_choices: float | None = None
    """Largest change by a choice that the scene file must state [unit]; None if none was varied."""
    by_laws: Mapping[str, float | None] = field(default_factory=dict)
    """Value of a single roller by each low-order law, by the law's name [unit]; None where the law does not give it."""

    @property
    def on_levels(self) -> dict[str, float]:
        """Value on every mesh level by the heading of its column, coarsest first [unit]."""
        return {f"level {level}": value for level, value in zip(self.levels, self.values, strict=True)}

    @property
    def uncertainty_percent(self) -> float | None:
        """Uncertainty of the value on the finest level [% of it]; None without uncertainty, and for a value of zero."""
        if self.uncertainty is None or (self.values[-1] == 0.0 and self.uncertainty != 0.0):
            return None
        return float(error_percent(self.uncertainty, 0.0, self.values[-1]))

    @property
    def law_errors(self) -> dict[str, float | None]:
        """Error of each low-order law from the value on the finest level [%], by the law's name."""
        return {
            law: None if value is None else float(error_percent(value, self.values[-1]))
            for law, value in self.by_laws.items()
        }

    def as_json(self) -> dict[str, Any]:
        """Return the quantity as JSON values, a row of a table with a key for each mesh level.

        Returns
        -------
        dict
            JSON values by key.
        """
        row: dict[str, Any] = {"quantity": self.name, "unit": self.unit, **self.on_levels}
        if len(self.levels) > 1:
            row |= {"order": self.order, "extrapolated": self.extrapolated, "uncertainty": self.uncertainty}
        if self.kind:
            row |= {"uncertainty_percent": self.uncertainty_percent, "kind": self.kind}
        if (self.modelling_spread, self.scene_choices) != (None, None):
            row |= {"modelling_spread": self.modelling_spread, "scene_choices": self.scene_choices}
        for law, error in self.law_errors.items():
            row |= {law: self.by_laws[law], f"{law}_error_percent": error}
        return row


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class MeshStudy(TabularRecord):
    """Mesh study of a scene: contact loads and other results of the 3D reference on several mesh levels."""

    scene: str
    """Name of the scene."""
    set: str = ""
    """Names of the nut or bearing, or of the bearings with equal rollers; empty if the scene has only one."""
    load: float | None = None
    """Load of a single roller [N]; None for whole scenes."""
    levels: tuple[MeshLevel, ...] = ()
    """Mesh levels, coarsest first; empty if the scene has several nuts or bearings."""
    quantities: tuple[MeshQuantity, ...] = ()
    """Quantities that are compared between the levels; empty if the scene has several nuts or bearings."""
    profile: tuple[Mapping[str, float], ...] = ()
    """Line loads and pressures along a single roller, in the units that the keys end with; empty for whole scenes."""
    sets: Mapping[str, MeshStudy] = field(default_factory=dict)
    """Mesh study of each nut or bearing on a shaft with several, by name; empty for a single nut or bearing."""
    notes: tuple[str, ...] = ()
    """Sentences on the accuracy of each mesh level."""

    def to_dict(self) -> dict[str, JSON]:
        """Return the mesh study as a dictionary of JSON values.

        Returns
        -------
        dict
            JSON values by key; of several nuts or bearings a list ``sets`` with those of each.
        """
        return add_schema_version(self.as_json())

    def as_json(self) -> dict[str, Any]:
        """Return the JSON values of `to_dict` without the version number of the format.

        Returns
        -------
        dict
            JSON values by key.
        """
        data: dict[str, Any] = {"scene": self.scene}
        if self.sets:
            return data | {"sets": [one.as_json() for one in self.sets.values()]}
        data |= {} if self.load is None else {"set": self.set, "load_N": self.load}
        data |= {"levels": [record_as_json(x) for x in self.levels], "quantities": [x.as_json() for x in self.quantities]}
        data |= {"profile": [dict(row) for row in self.profile]} if self.profile else {}
        return data | ({"set": self.set} if self.set else {})

    def frame_rows(self) -> Sequence[Mapping[str, Any]]:
        """Return a row for each quantity, whose unit is in the column ``unit``; of each nut or bearing.

        Returns
        -------
        list
            Row of each line of the frame, by the names of its columns.
        """
        if self.sets:
            return [{"set": name} | dict(row) for name, one in self.sets.items() for row in one.frame_rows()]
        return [x.as_json() for x in self.quantities]

    def figure(self) -> Figure | None:
        """Return the figure of the convergence with the cell size; None for fewer than two mesh levels.

        Returns
        -------
        reports.content.Figure or None
            The figure, as the report draws it; None if there is nothing to draw.
        """
        panels = list(self._convergence_panels())
        if not panels:
            return None
        caption = "Bars: uncertainty of the finest mesh level. Thin lines to cell size zero: extrapolations by a power law."
        title = f"Convergence of contact loads and displacements of {self.scene} with the cell size"
        return Figure(f"mesh-study-{self.scene}", title, tuple(panels), caption)

    def _convergence_panels(self) -> Iterator[Panel]:
        """Yield the panels of loads and of displacements, of every nut or bearing: differences from the finest level."""
        for one in self.sets.values():
            yield from one._convergence_panels()
        if len(self.levels) < 2:
            return
        sizes = [x.cell_size for x in self.levels]
        for title, start in (("contact loads", ("largest load", "smallest load")), *DISPLACEMENTS):
            shown = [x for x in self.quantities if x.name.startswith(start)]
            scale = max((abs(x.values[-1]) for x in shown), default=0.0)
            series = [s for x in shown[:MOST] for s in _convergence_curve_and_power_law(x, sizes, scale)]
            if any(y for s in series for y in s.y):
                label = f"difference from the finest level / % of {scale:.3g} {shown[0].unit}"
                heading = f"{self.set}: {title}" if self.set else title
                yield Panel(heading, "cell size / cell size of the finest level", label, tuple(series))

    @property
    def _notes(self) -> tuple[str, ...]:
        """Lines below the table: one with the values of each mesh level, then the sentences on their accuracy."""
        return (*(values_in_words(record_as_json(x)) for x in self.levels), *self.notes)


#: Largest number of curves in one panel of the figure.
MOST = 8

#: Panels of displacements: title, and how the names of their quantities begin; whole scenes, then single rollers.
DISPLACEMENTS = (("displacement of the centreline", ("centreline",)), ("approach of the roller", ("approach",)))


def _convergence_curve_and_power_law(
    quantity: MeshQuantity, relative_cell_sizes: Sequence[float], scale: float
) -> list[Series]:
    """Return the curve of one quantity over the cell size, and the fitted power law to cell size zero if there is one.

    ``relative_cell_sizes``: cell sizes of the levels relative to the finest; ``scale``: value by which the differences from
    the finest level are divided; 0: no curve is returned.
    """
    finest, bar = quantity.values[-1], quantity.uncertainty or 0.0
    if scale == 0.0:
        return []

    def off(value: Any) -> Any:
        return error_percent(value, finest, scale)

    y = [float(off(value)) for value in quantity.values]
    ends = (*y[:-1], float(off(finest - bar))), (*y[:-1], float(off(finest + bar)))
    out = [Series(quantity.name, relative_cell_sizes, y, "line+markers", error_bars=ends)]
    if quantity.extrapolated is not None and quantity.order:
        h = np.linspace(0.0, 1.0, 21)
        line = off(quantity.extrapolated + (finest - quantity.extrapolated) * h**quantity.order)
        out.append(Series(quantity.name, h.tolist(), np.asarray(line, float).tolist(), "line", pale=True))
    return out
