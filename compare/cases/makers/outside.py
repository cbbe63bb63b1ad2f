"""Comparison of computed values with values that makers, other programs and textbooks publish; bias and scatter.

Makers' printed tables are read by `compare.scenes.makers`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from rollbench.compare.evidence import computations_with_function, evidence
from rollbench.compare.measure import error_percent
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.scenes.makers import MakerTable, half_step_of_last_digit
from rollbench.reports.content import Row, Table

MAKER, MEASURED, PROGRAM = "printed by a maker", "measured", "another program"


class ComputedBand(NamedTuple):
    """A computed value with the range of values that rounded or unprinted inputs allow; all three in the same unit."""

    value: float
    low: float
    high: float

    @classmethod
    def from_values(cls, values: Iterable[float], slack: float = 0.0) -> ComputedBand:
        """Return the first of several computed values, together with the range of all of them.

        ``values``: computed values, the most probable first; ``slack``: amount by which the range is widened at each end,
        in the unit of the values.
        """
        every = [float(x) for x in values]
        return cls(every[0], min(every) - slack, max(every) + slack)

    @classmethod
    def from_relative_half_width(cls, value: float, share: float) -> ComputedBand:
        """Return a computed value, together with a range of plus or minus a fraction of it.

        ``share``: half width of the range divided by the value.
        """
        return cls.from_values((value,), abs(value) * share)


@dataclass(frozen=True)
class PublishedValue:
    """One published value of a maker, program, textbook or measurement, with the computed value.

    ``quantity``: such as "rigidity"; ``law``: name of the model that computes the quantity; ``maker``: publisher; ``part``:
    screw, nut or bearing to which the value belongs; ``kind_of_source``: such as "measured"; ``origin``: file and line, or
    section, of the value in the publication. ``value``: published value in ``unit``; ``rounding``: half a step of its last
    digit, or half of a published range. ``computed``: computed value and its range in the same unit. ``scale``: value that
    errors in per cent refer to; 0: the published value. ``practice``: computed value reduced as makers reduce it (80 % of a
    nut's rigidity), or None. ``left``: why the value is not judged, such as a misprint; empty if it is judged.
    """

    quantity: str
    law: str
    maker: str
    part: str
    kind_of_source: str
    origin: str
    unit: str
    value: float
    rounding: float
    computed: ComputedBand
    scale: float = 0.0
    practice: float | None = None
    left: str = ""

    @property
    def group(self) -> str:
        """Name of the group that shares a row of the summary table: the maker, or "programs and textbooks"."""
        named = self.law != "the model of its table" or self.kind_of_source == MAKER
        return self.maker if named else "programs and textbooks"

    @property
    def verdict(self) -> str:
        """In words: whether the published value, with its rounding, lies in the computed range; or why it is not judged."""
        if self.left:
            return self.left
        if self.value + self.rounding < self.computed.low:
            return "below the band"
        return "above the band" if self.value - self.rounding > self.computed.high else "in the band"

    @property
    def error_percent(self) -> float:
        """Computed less published value, in per cent of the published value, or of ``scale`` unless that is 0."""
        return float(error_percent(self.computed.value, self.value, self.scale or None))


def value_of_table_entry(
    source: MakerTable,
    row: Mapping[str, str],
    line_column: str,
    column: str,
    quantity_model_part_unit: tuple[str, str, str, str],
    computed: ComputedBand,
    **others: Any,
) -> PublishedValue:
    """Return a number printed in a maker's table together with the computed value.

    ``source``: the table; ``row``: printed texts by column; ``line_column``: name of the column with the line number in the
    original file; ``column``: name of the column of the number. ``quantity_model_part_unit``: quantity, name of the model,
    screw or bearing, and unit of the number, in this order. ``computed``: computed value and range in that unit.
    ``others``: values of further fields of `PublishedValue`, by name.
    """
    quantity, law, item, unit = quantity_model_part_unit
    fields: dict[str, Any] = {"maker": source.header["maker"], "rounding": half_step_of_last_digit(row[column])} | others
    if source.is_listed_as_misprint(f"{item} {quantity}"):
        fields["left"] = "a misprint"
    fields |= {"quantity": quantity, "law": law, "part": item, "unit": unit, "kind_of_source": source.header["class"]}
    origin, value = f"{source.name}.csv, line {row[line_column]} of its origin", source.parse_number(row[column])
    return PublishedValue(origin=origin, value=value, computed=computed, **fields)


def error_statistics(found: Sequence[PublishedValue]) -> dict[str, Any] | None:
    """Return bias, scatter and number of the errors of all judged values, by table column; None if no value is judged.

    The columns are the number of values; mean (bias) and standard deviation (scatter) of the errors [%]; the number of
    published values in their computed ranges; the median width of these ranges [% of the computed value]; the mean error
    [%] of the computed values after reduction as makers reduce them, None without such values. ``found``: published values
    with the computed ones.
    """
    judged = [x for x in found if not x.left]
    if not judged:
        return None
    errors = np.array([x.error_percent for x in judged])
    widths = [float(error_percent(x.computed.high, x.computed.low, x.scale or x.computed.value)) for x in judged]
    after = [float(error_percent(x.practice, x.value)) for x in judged if x.practice is not None]
    return {
        "published_values": len(judged),
        "bias_f1": float(errors.mean()),
        "scatter_f1": float(errors.std()),
        "published_in_range": sum(x.verdict == "in the band" for x in judged),
        "range_width": float(np.median(widths)),
        "reduced_error": float(np.mean(after)) if after else None,
    }


def group_by_fields(found: Iterable[PublishedValue], *keys: str) -> dict[tuple[str, ...], list[PublishedValue]]:
    """Group published values by fields of `PublishedValue`; groups are in the order of their first value.

    ``keys``: names of these fields. Returns the published values of each group, by the tuple of the fields' values.
    ``found``: published values with the computed ones.
    """
    groups: dict[tuple[str, ...], list[PublishedValue]] = {}
    for one in found:
        groups.setdefault(tuple(getattr(one, key) for key in keys), []).append(one)
    return groups


def statistics_cells_by_quantity(found: Sequence[PublishedValue]) -> dict[str, Row]:
    """Return table cells with number, bias [%] and scatter [%] of the errors of all judged values, by quantity.

    ``found``: published values with the computed ones.
    """
    rows = {key: error_statistics(values) for (key,), values in group_by_fields(found, "quantity").items()}
    return {
        key: {"values": s["published_values"], "bias": s["bias_f1"], "scatter": s["scatter_f1"]}
        for key, s in rows.items()
        if s is not None
    }


def bias_and_scatter_table(found: Sequence[PublishedValue]) -> Table:
    """Return the table of bias and scatter of the computed values, with a row for each quantity, model and publisher.

    ``found``: published values with the computed ones.
    """
    rows: list[Row] = []
    without: list[str] = []
    for (quantity, law, group), values in group_by_fields(found, "quantity", "law", "group").items():
        left = [x.left for x in values if x.left]
        words = "; ".join(f"{left.count(why)}: {why}" for why in dict.fromkeys(left))
        s = error_statistics(values)
        if s is None:
            without.append(f"{quantity} of {group}, {words}")
            continue
        named: Row = {"quantity": quantity, "published_by": group, "computing_model": law}
        rows.append(named | s | {"values_left_out": words})
    note = (
        "Error: computed minus published value. Computed range (band): range of a computed value "
        "over the rounding of printed inputs and the usual range of unprinted ones. Errors of clearances are in per cent "
        "of the displacement under the measuring load, those of contact loads by CalculiX of the mean load. 0.8: factor by "
        f"which makers advise to reduce a computed nut rigidity. Not judged: {'; '.join(without)}."
    )
    title = "Mean and standard deviation of the errors against published values, by quantity and publisher"
    return Table.from_rows("outside-summary", title, rows, note)


def published_values_table(found: Sequence[PublishedValue]) -> Table:
    """Return the table of all published values, each with its computed value, band, error and verdict.

    ``found``: published values with the computed ones.
    """
    rows: list[Row] = [
        {
            "quantity": x.quantity,
            "published_by": x.maker,
            "source_kind": x.kind_of_source,
            "item": x.part,
            "published_value": x.value,
            "unit": x.unit,
            "computed_value": x.computed.value,
            "computed_low": x.computed.low,
            "computed_high": x.computed.high,
            "error_of_computed": x.error_percent,
            "in_computed_range": x.verdict,
            "computing_model": x.law,
            "file_and_line": x.origin,
        }
        for x in found
    ]
    note = (
        "Makers' tables stand in compare/scenes/maker_tables; the first lines of each name repository, commit and file "
        "of its origin."
    )
    title = "All published values of makers, measurements and programs, with the computed values"
    return replace(Table.from_rows("outside", title, rows, note), rows_csv_only=True)


#: Printed tables of the case `external` that are judged here: publisher and class. Tables of THK are judged with the nuts.
PRINTED = {
    "external-masta": ("MASTA", PROGRAM),
    "external-nsk": ("NSK's programs", PROGRAM),
    "external-contact": ("CONTACT", PROGRAM),
    "external-vm63": ("Ansys", PROGRAM),
    "external-harris": ("Jones and Harris", PROGRAM),
    "external-sjovall": ("NSK", MAKER),
    "external-gmn": ("GMN", MAKER),
}

#: Quantity of a published number, by its unit; numbers without a unit are ratios of loads.
QUANTITIES = {
    "um": "displacement",
    "mrad": "displacement",
    "mm": "contact patch",
    "deg": "contact patch",
    "MPa": "pressure",
    "N": "contact load",
    "": "contact load",
    "balls": "contact load",
    "N/um": "rigidity",
    "N mm": "contact patch",
    "1e6 rev": "life",
}

#: Quantity of published numbers whose unit does not tell it, by table and key.
OTHERS = {("external-contact", "approach"): "displacement"}


def published_values_of_external_case(cache: SceneResultCache) -> Iterator[PublishedValue]:
    """Yield every published number of the case ``external`` that has a computed value, together with this value.

    The printed tables of the case are listed in `PRINTED`. Numbers of class "open" (it is not printed how they were
    obtained) are yielded but not judged. ``cache``: gives the solved scenes.
    """
    for name, (maker, cls) in PRINTED.items():
        if name not in computations_with_function():
            continue
        for e in evidence(cache, name):
            p = e.printed
            if p.value is None or e.value is None:
                continue
            patch = "contact patch" if name == "external-contact" and not p.unit else QUANTITIES[p.unit]
            quantity = OTHERS.get((name, p.key), patch)
            band = max(p.value - (p.low or p.value), (p.high or p.value) - p.value)
            rounding = p.tolerance if p.entry_class == "hard" else band
            yield PublishedValue(
                quantity,
                "the model of its table",
                maker,
                f"{name}: {p.label}",
                cls,
                p.place,
                p.unit,
                p.value,
                rounding,
                ComputedBand.from_values((e.value,)),
                left="" if p.entry_class in ("hard", "band") else "open: what it rests on is not printed",
            )


def contact_loads_by_calculix(cache: SceneResultCache) -> Iterator[PublishedValue]:
    """Yield the contact loads [N] by the program CalculiX, each with the load by the 3D reference as the computed value.

    CalculiX's loads are extrapolated over its meshes. Errors are in per cent of the mean contact load. ``cache``: gives
    stored 3D references.
    """
    from rollbench.compare.studies.crosscheck.results import (
        compare_contact_loads,
        load_calculix_results,
        path_of_calculix_results,
        shipped_calculix_results_folder,
    )
    from rollbench.compare.studies.crosscheck.study import STUDIES

    folder = shipped_calculix_results_folder()
    for name in STUDIES:
        data, ours = load_calculix_results(folder, name), cache.stored_reference(name)
        if data is None or ours is None:
            continue
        mean = float(ours.mean)
        for row in compare_contact_loads(data, ours):
            off = 0.01 * row["ours_percent"] * mean
            words = ("contact load", "3D reference", "CalculiX", f"{name}: ball {row['ball']} {row['side']}", PROGRAM)
            file = f"stored run, compare/studies/crosscheck/{path_of_calculix_results(folder, name).name}"
            band = ComputedBand.from_values((row["ours"],), off)
            yield PublishedValue(*words, file, "N", row["theirs"], 0.01 * row["theirs_percent"] * mean, band, mean)
