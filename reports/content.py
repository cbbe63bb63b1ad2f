"""Plain records that a report is made of. Whoever runs models fills them; this package draws them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rollbench.meshes.axis import Assembly, RollerRow
from rollbench.meshes.parts import Scene
from rollbench.reports.quantity import Quantity as Quantity

Cell = str | float | int | bool | None
Numbers = Sequence[float] | NDArray[np.float64]
Rows = Sequence[Sequence[float]] | NDArray[np.float64] | NDArray[np.int64]


#: A row of a table: values by what they are; a bare word is the heading of a column of texts.
Row = dict[Quantity | str, Cell]


@dataclass(frozen=True)
class Table:
    """A table: ``name`` is its CSV file's stem; rows are mappings from a quantity's key to its value; unfolded: a page
    shows it open however long it is. Raises ValueError for two columns of one heading and unit, which no reader of the
    CSV file could tell apart."""

    name: str
    title: str
    columns: Sequence[Quantity]
    rows: Sequence[Mapping[str, Cell]]
    note: str = ""
    unfolded: bool = False

    def __post_init__(self) -> None:
        """Check the headings."""
        heads = [(column.label, column.unit) for column in self.columns]
        twice = {label for label, unit in heads if heads.count((label, unit)) > 1}
        if twice:
            raise ValueError(f"table {self.name!r}: more than one column headed {', '.join(map(repr, sorted(twice)))}")

    @classmethod
    def of(
        cls, name: str, title: str, rows: Iterable[Mapping[Quantity | str, Cell]], note: str = "", *, unfolded: bool = False
    ) -> Table:
        """A table whose rows say what they hold: its columns are their quantities, in the order in which they appear."""
        listed = [{_quantity(q): value for q, value in row.items()} for row in rows]
        columns = tuple(dict.fromkeys(q for row in listed for q in row))
        return cls(name, title, columns, [{q.key: value for q, value in row.items()} for row in listed], note, unfolded)


def _quantity(named: Quantity | str) -> Quantity:
    return Quantity(named, named, format="s") if isinstance(named, str) else named


@dataclass(frozen=True)
class Series:
    """One curve: label, x, y, style (``"line"``, ``"markers"``, ``"line+markers"``, ``"band"`` up to y2); ``bars``: lower
    and upper ends of error bars; ``light``: small and pale, not in the legend; ``texts``: written beside the points, in
    place of a line in the legend; ``names``: of the points, for who points at them."""

    label: str
    x: Sequence[float]
    y: Sequence[float]
    style: str = "line+markers"
    y2: Sequence[float] | None = None
    emphasis: bool = False
    bars: tuple[Sequence[float], Sequence[float]] | None = None
    light: bool = False
    texts: Sequence[str] = ()
    names: Sequence[str] = ()


@dataclass(frozen=True)
class Panel:
    """One pair of axes: title, labels with units, curves.

    ``log`` is one of ``""``, ``"x"``, ``"y"``, ``"xy"``; ``zero`` extends the ordinate to zero; ``integer_x``
    labels the abscissa at whole numbers only; ``names`` stand there in place of the numbers from 1 on.
    """

    title: str
    xlabel: str
    ylabel: str
    series: Sequence[Series]
    log: str = ""
    zero: bool = False
    integer_x: bool = False
    names: Sequence[str] = ()


@dataclass(frozen=True)
class Figure:
    """A figure of one to six panels, ``columns`` (at most 3) per row; ``name`` is its SVG file's stem; ``size``: width and
    height in inches of 96 pixels, None for what suits the number of panels; ``same_y``: one scale of the ordinates."""

    name: str
    title: str
    panels: Sequence[Panel]
    caption: str = ""
    columns: int = 2
    size: tuple[float, float] | None = None
    same_y: bool = False


@dataclass(frozen=True)
class SetView:
    """One set of a load case. parts: balls with their grooves, or rollers; thrust: as of `meshes.axis.RollingSet`; points
    (n, 4, 3) [m] of the contacts and forces (n, 4, 3) [N] on the balls, None of rollers and without answers; reference:
    its label and its loads (n, 4) [N], their uncertainty (n, 4) [N], and the error of the loads (n, 4) [%] against it, or
    None; expected: error of the loads that is to be expected [N], or None; closer: by how much each contact is closer than
    in perfect parts, (n, 4) [m]."""

    name: str
    kind: str
    parts: Scene | RollerRow
    position: float
    thrust: str = "both"
    points: NDArray[np.float64] | None = None
    forces: NDArray[np.float64] | None = None
    reference: tuple[str, NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]] | None = None
    expected: float | None = None
    closer: NDArray[np.float64] | None = None


@dataclass(frozen=True)
class CaseView:
    """One load case: its name (empty: the only one), its sets, and the shaft that they stand on (None: that of the set)."""

    name: str
    sets: Sequence[SetView]
    shaft: Assembly | None = None


@dataclass(frozen=True)
class View:
    """Title, and what stands under it; load cases in the order of the results; results, JSON-ready, as of ``solve
    --json``."""

    title: str
    subtitle: str
    cases: Sequence[CaseView]
    results: Mapping[str, Any]


@dataclass(frozen=True)
class LoadedScrew:
    """A 3D picture of the screw, nut and balls of a scene under contact loads ``(n, 4)`` [N], whose largest colours a ball;
    contact points (m, 3) [m] with the forces on the balls there (m, 3) [N], which become arrows; ``view``: of a page on
    which it can be turned, if there is to be one."""

    name: str
    title: str
    scene: Scene
    load: NDArray[np.float64]
    contact_points: NDArray[np.float64]
    contact_forces: NDArray[np.float64]
    caption: str = ""
    view: View | None = None


@dataclass(frozen=True)
class Sketch:
    """A sketch of the screw or bearing of a scene from the side, with what holds and loads it."""

    name: str
    title: str
    scene: Scene
    caption: str = ""


@dataclass(frozen=True)
class MeshPart:
    """A piece of a mesh in a picture: points (n, 3) [m], cells of ``kind`` ``"P1"``, ``"P2"`` (4, 10-node tetrahedra) or
    ``"Q2"`` (27-node hexahedra), nodes in gmsh's order; ``values`` (n) colour it, else ``colour`` does; ``edges``: draw
    the cells' edges; ``outline``: draw the rim of a section through it;
    ``line``: width of the edges in pixels."""

    points: Rows
    cells: Rows
    kind: str
    values: Numbers | None = None
    colour: str = "#c3c8ce"
    edges: bool = True
    outline: bool = False
    line: float = 1.2


@dataclass(frozen=True)
class FieldPicture:
    """A 3D picture of meshes, of fields on them, or of a plane section.

    ``sight``: direction from the picture to the viewer; ``up``; ``focus`` (3) [m] in the middle; ``height`` [m] that is
    seen. ``cuts``: planes (point, normal); cells whose middle lies in front of all of them are left away. ``section``:
    show the plane section by the only cut instead. ``label``: of the values, with unit; ``limits``: ends of their
    scale (None: from the data); ``log``: scale by tens; ``words``: (point, text) written into the picture;
    ``scale_bar`` [m], 0 for none.
    """

    name: str
    title: str
    parts: Sequence[MeshPart]
    sight: Sequence[float]
    up: Sequence[float]
    focus: Sequence[float]
    height: float
    cuts: Sequence[tuple[Sequence[float], Sequence[float]]] = ()
    section: bool = False
    label: str = ""
    limits: tuple[float, float] | None = None
    log: bool = False
    words: Sequence[tuple[Sequence[float], str]] = ()
    scale_bar: float = 0.0
    caption: str = ""


@dataclass(frozen=True)
class PressurePanel:
    """One contact: nodes x, y, their values, the ellipse (centre x, y, semi-axes along x, y) drawn on it, a note; arrows:
    directions at the nodes (x, y), drawn at every ``skip``-th; marked: which nodes stand out."""

    title: str
    x: Numbers
    y: Numbers
    values: Numbers
    ellipse: tuple[float, float, float, float]
    note: str = ""
    arrows: tuple[Numbers, Numbers] | None = None
    skip: int = 1
    marked: Sequence[bool] | None = None


@dataclass(frozen=True)
class PressureMap:
    """Filled contours of one to four contacts to one scale; labels with units; ``name`` is its SVG file's stem;
    ``marked_label``: of nodes that stand out."""

    name: str
    title: str
    panels: Sequence[PressurePanel]
    xlabel: str
    ylabel: str
    label: str
    ellipse_label: str = "Hertz"
    marked_label: str = ""
    caption: str = ""
    columns: int = 2


@dataclass(frozen=True)
class Text:
    """Paragraphs of plain text, or a list of statements when ``bullets``; heading: stands above them."""

    paragraphs: Sequence[str]
    bullets: bool = False
    heading: str = ""


@dataclass(frozen=True)
class Summary:
    """The first screen: a question, its answer in one sentence, one figure of it and the same for a narrow screen, then
    what the answer covers and what limits it, as statements; items: tables and figures below; table: what the PDF shows
    beside them."""

    question: str
    answer: str
    figure: Figure
    narrow: Figure
    coverage: Sequence[str]
    limits: Sequence[str]
    table: Table | None = None
    items: Sequence[Table | Figure] = ()


@dataclass(frozen=True)
class Section:
    """A section of the report; ``name`` selects it with ``--only``; conclusion: one or two sentences that the page opens
    with; summary: the report's first screen."""

    name: str
    title: str
    items: Sequence[Text | Table | Figure | Sketch | LoadedScrew | FieldPicture | PressureMap]
    conclusion: str = ""
    summary: Summary | None = None


@dataclass(frozen=True)
class Page:
    """A page of the report: name of its file, title, the sections on it, the conclusion that it opens with."""

    name: str
    title: str
    sections: Sequence[Section]
    conclusion: str = ""


@dataclass(frozen=True)
class Report:
    """The whole report: title, subtitle, provenance, pages; the first summary of a section is its first screen; origin:
    what its manifest says of what it rests on, as plain data."""

    title: str
    subtitle: str
    provenance: Mapping[str, str]
    pages: Sequence[Page]
    origin: Mapping[str, object] = field(default_factory=dict)

    @property
    def sections(self) -> list[Section]:
        """The sections of all pages."""
        return [section for page in self.pages for section in page.sections]
