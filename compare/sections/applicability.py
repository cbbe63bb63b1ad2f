"""What was compared, drawn: a range for each descriptor, the compared scenes in it, and a scene's own place."""

from __future__ import annotations

from rollbench.compare.models.applicability import DESCRIPTORS, Descriptor, compared_values, places
from rollbench.compare.models.study import Study
from rollbench.meshes.parts import Scene
from rollbench.reports.content import Figure, Panel, Quantity, Row, Series, Table


def range_table(scene: Scene | None = None) -> Table:
    """Compared ranges, and the place of a scene where one is given."""
    rows: list[Row] = []
    placed = {} if scene is None else {p.descriptor.name: p for p in places(scene)}
    ring = scene is not None and scene.track.lead == 0.0
    for d in DESCRIPTORS:
        values = compared_values(d, ring=ring)
        row: Row = {
            Quantity("name", "what describes a scene", "", "s"): d.name,
            "unit": d.unit or "–",
            Quantity("low", "compared from", "", "g4"): min(values),
            Quantity("high", "to", "", "g4"): max(values),
        }
        if scene is not None and d.name in placed:
            place = placed[d.name]
            inside = place.low <= place.value <= place.high
            where = "inside" if inside else "OUTSIDE" if place.outside else "at the edge"
            row |= {Quantity("own", scene.name): place.value, Quantity("where", "where it lies", "", "s"): where}
        rows.append(row)
    kind = "rings" if ring else "screws"
    note = (
        f"Of {len(values)} {kind}, shipped or drawn, that were compared with the 3D reference. Beyond a range by less "
        "than its margin a scene still counts as covered; further out, a result says that its error is not covered."
    )
    return Table.of("applicability", "What was compared with the 3D reference", rows, note)


def range_figure(scene: Scene | None = None) -> Figure:
    """Compared scenes by pairs of descriptors, with a scene's own place."""
    pairs = ((0, 1), (2, 4), (6, 3), (5, 7))
    ring = scene is not None and scene.track.lead == 0.0
    panels = []
    for a, b in (tuple(DESCRIPTORS[k] for k in pair) for pair in pairs):
        series = [Series("compared", compared_values(a, ring=ring), compared_values(b, ring=ring), "markers")]
        if scene is not None:
            series.append(Series(scene.name, [a.of(scene)], [b.of(scene)], "markers", emphasis=True))
        panels.append(Panel("", _label(a), _label(b), tuple(series)))
    return Figure("applicability", "What was compared with the 3D reference", tuple(panels))


def _label(d: Descriptor) -> str:
    return f"{d.name} / {d.unit}" if d.unit else d.name


def items_of(study: Study) -> tuple[Table | Figure, ...]:  # noqa: ARG001 - as every part of a section
    """Table and figure without a scene of one's own."""
    return range_table(), range_figure()
