"""Plain records for the contents of a report, filled by the code that runs models and drawn by this package."""

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


#: A row of a table: values by column; a plain text as key is the heading of a column of texts.
Row = dict[Quantity | str, Cell]


@dataclass(frozen=True)
class Table:
    """A table of a report; ValueError for two columns with the same heading and unit."""

    #: Stem of its CSV file.
    name: str
    #: Title.
    title: str
    #: Columns.
    columns: Sequence[Quantity]
    #: Values by key of the column.
    rows: Sequence[Mapping[str, Cell]]
    #: Note below the table.
    note: str = ""
    #: Whether a page shows it open, however long it is.
    unfolded: bool = False
    #: Keys of columns that are in the CSV file only.
    csv_only: Sequence[str] = ()

    def __post_init__(self) -> None:
        """Raise ValueError for two columns with the same heading and unit, which a CSV file could not distinguish."""
        heads = [(column.label, column.unit) for column in self.columns]
        twice = {label for label, unit in heads if heads.count((label, unit)) > 1}
        if twice:
            raise ValueError(f"table {self.name!r}: more than one column headed {', '.join(map(repr, sorted(twice)))}")

    @classmethod
    def of(
        cls, name: str, title: str, rows: Iterable[Mapping[Quantity | str, Cell]], note: str = "", *, unfolded: bool = False
    ) -> Table:
        """Make a table from rows with quantities as keys; columns are in the order in which keys first appear."""
        listed = [{_quantity_of(q): value for q, value in row.items()} for row in rows]
        columns = tuple(dict.fromkeys(q for row in listed for q in row))
        return cls(name, title, columns, [{q.key: value for q, value in row.items()} for row in listed], note, unfolded)


def _quantity_of(named: Quantity | str) -> Quantity:
    """Return a column; a plain text becomes the heading of a column of texts."""
    return Quantity(named, named, format="s") if isinstance(named, str) else named


@dataclass(frozen=True)
class Series:
    """One curve, band, histogram or set of bars in a panel."""

    #: Label in the legend.
    label: str
    #: Abscissae.
    x: Sequence[float]
    #: Ordinates.
    y: Sequence[float]
    #: ``"line"``, ``"markers"``, ``"line+markers"``, ``"band"`` between y and y2, ``"steps"`` (histogram; x: edges
    #: of the bins, one more than y), or ``"bars"`` (horizontal, from zero to x at the heights y).
    style: str = "line+markers"
    #: Upper edge of a band.
    y2: Sequence[float] | None = None
    #: Whether it is drawn bold.
    emphasis: bool = False
    #: Lower and upper ends of error bars.
    bars: tuple[Sequence[float], Sequence[float]] | None = None
    #: Whether it is small and pale, and not in the legend.
    light: bool = False
    #: Texts next to the points, instead of a line in the legend.
    texts: Sequence[str] = ()
    #: Names of the points, shown under the pointer.
    names: Sequence[str] = ()


@dataclass(frozen=True)
class Panel:
    """One pair of axes with curves."""

    #: Title.
    title: str
    #: Label of the abscissa, with unit.
    xlabel: str
    #: Label of the ordinate, with unit.
    ylabel: str
    #: Curves.
    series: Sequence[Series]
    #: Logarithmic axes: ``""``, ``"x"``, ``"y"`` or ``"xy"``.
    log: str = ""
    #: Whether the ordinate extends to zero.
    zero: bool = False
    #: Whether the abscissa is labelled at integers only.
    integer_x: bool = False
    #: Labels of the abscissa instead of the numbers from 1 on.
    names: Sequence[str] = ()
    #: Labels of the ordinate instead of the numbers from 1 on, downwards.
    row_names: Sequence[str] = ()


@dataclass(frozen=True)
class Figure:
    """A figure of one to six panels."""

    #: Stem of its SVG file.
    name: str
    #: Title.
    title: str
    #: Panels.
    panels: Sequence[Panel]
    #: Caption.
    caption: str = ""
    #: Number of panels per row, at most 3.
    columns: int = 2
    #: Width and height [inches of 96 pixels]; None: by the number of panels.
    size: tuple[float, float] | None = None
    #: Whether all ordinates have one scale.
    same_y: bool = False


@dataclass(frozen=True)
class SetView:
    """Data of one set of a load case for the 3D view."""

    #: Name of the set.
    name: str
    #: Kind of the set.
    kind: str
    #: Balls with their grooves, or rollers.
    parts: Scene | RollerRow
    #: Axial position [m].
    position: float
    #: Direction of thrust, as of `meshes.axis.RollingSet`.
    thrust: str = "both"
    #: Contact points, (n, 4, 3) [m]; None of rollers and without equilibrium.
    points: NDArray[np.float64] | None = None
    #: Forces on the balls, (n, 4, 3) [N].
    forces: NDArray[np.float64] | None = None
    #: Label of the reference, its loads (n, 4) [N], their uncertainty (n, 4) [N], and the error of the loads (n, 4) [%]; or
    #: None.
    reference: tuple[str, NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]] | None = None
    #: Error of the loads to expect [N].
    expected: float | None = None
    #: By how much each contact is closer than with perfect parts, (n, 4) [m].
    closer: NDArray[np.float64] | None = None


@dataclass(frozen=True)
class CaseView:
    """Data of one load case for the 3D view."""

    #: Name of the load case; empty if there is only one.
    name: str
    #: Its sets.
    sets: Sequence[SetView]
    #: Shaft with several sets; None for a scene with one set.
    shaft: Assembly | None = None


@dataclass(frozen=True)
class View:
    """Data of a page that shows a solved scene in 3D and can be turned."""

    #: Title.
    title: str
    #: Line below the title.
    subtitle: str
    #: Load cases, in the order of the results.
    cases: Sequence[CaseView]
    #: JSON of ``solve --json``.
    results: Mapping[str, Any]


@dataclass(frozen=True)
class LoadedScrew:
    """3D picture of screw, nut and balls under contact loads."""

    #: Stem of its file.
    name: str
    #: Title.
    title: str
    #: The scene.
    scene: Scene
    #: Contact loads, (n, 4) [N]; the largest of a ball gives its colour.
    load: NDArray[np.float64]
    #: Contact points, (m, 3) [m].
    contact_points: NDArray[np.float64]
    #: Forces on the balls there, (m, 3) [N], drawn as arrows.
    contact_forces: NDArray[np.float64]
    #: Caption.
    caption: str = ""
    #: Page on which it can be turned, if any.
    view: View | None = None


@dataclass(frozen=True)
class Sketch:
    """Side view of a screw or bearing, with supports and loads."""

    #: Stem of its file.
    name: str
    #: Title.
    title: str
    #: The scene.
    scene: Scene
    #: Caption.
    caption: str = ""


@dataclass(frozen=True)
class MeshPart:
    """A mesh, or part of one, in a 3D picture."""

    #: Nodes, (n, 3) [m].
    points: Rows
    #: Nodes of the cells, in gmsh's order.
    cells: Rows
    #: ``"P1"``, ``"P2"`` (4, 10-node tetrahedra) or ``"Q2"`` (27-node hexahedra).
    kind: str
    #: Values of the nodes, (n,), for the colour; None: ``colour``.
    values: Numbers | None = None
    #: Colour without values.
    colour: str = "#c3c8ce"
    #: Whether edges of the cells are drawn.
    edges: bool = True
    #: Whether the rim of a section through it is drawn.
    outline: bool = False
    #: Width of the edges [pixels].
    line: float = 1.2


@dataclass(frozen=True)
class FieldPicture:
    """3D picture of meshes, of fields on them, or of a plane section."""

    #: Stem of its file.
    name: str
    #: Title.
    title: str
    #: Pieces of meshes.
    parts: Sequence[MeshPart]
    #: Direction from the picture to the viewer.
    sight: Sequence[float]
    #: Upward direction.
    up: Sequence[float]
    #: Point in the middle, (3,) [m].
    focus: Sequence[float]
    #: Visible height [m].
    height: float
    #: Planes (point, normal); cells whose middle lies in front of all of them are left out.
    cuts: Sequence[tuple[Sequence[float], Sequence[float]]] = ()
    #: Whether the plane section by the only cut is shown instead.
    section: bool = False
    #: Name of the values, with unit.
    label: str = ""
    #: Ends of the scale; None: from the data.
    limits: tuple[float, float] | None = None
    #: Whether the scale is logarithmic.
    log: bool = False
    #: Texts written into the picture, as (point, text).
    words: Sequence[tuple[Sequence[float], str]] = ()
    #: Length of a scale bar [m]; 0: none.
    scale_bar: float = 0.0
    #: Caption.
    caption: str = ""


@dataclass(frozen=True)
class PressurePanel:
    """Contours of the pressure in one contact, with Hertz' ellipse."""

    #: Title.
    title: str
    #: Abscissae of the nodes.
    x: Numbers
    #: Ordinates of the nodes.
    y: Numbers
    #: Values at the nodes.
    values: Numbers
    #: Ellipse drawn on it: centre x, y, semi-axes along x, y.
    ellipse: tuple[float, float, float, float]
    #: Note.
    note: str = ""
    #: Directions at the nodes (x, y).
    arrows: tuple[Numbers, Numbers] | None = None
    #: Arrows are drawn at every ``skip``-th node.
    skip: int = 1
    #: Nodes that are marked.
    marked: Sequence[bool] | None = None


@dataclass(frozen=True)
class PressureMap:
    """Figure with filled pressure contours of one to four contacts, on one colour scale."""

    #: Stem of its SVG file.
    name: str
    #: Title.
    title: str
    #: Contacts.
    panels: Sequence[PressurePanel]
    #: Label of the abscissa, with unit.
    xlabel: str
    #: Label of the ordinate, with unit.
    ylabel: str
    #: Label of the values, with unit.
    label: str
    #: Label of the ellipses.
    ellipse_label: str = "Hertz"
    #: Label of marked nodes.
    marked_label: str = ""
    #: Caption.
    caption: str = ""
    #: Number of panels per row.
    columns: int = 2
    #: Width [inches]; None: by the number of panels per row.
    width: float | None = None


@dataclass(frozen=True)
class Text:
    """Paragraphs of plain text."""

    #: The paragraphs.
    paragraphs: Sequence[str]
    #: Whether they are a list.
    bullets: bool = False
    #: Heading above them.
    heading: str = ""


@dataclass(frozen=True)
class Summary:
    """Contents of the report's first page: question, answer, figure, limits."""

    #: The question.
    question: str
    #: Its answer in one sentence.
    answer: str
    #: A figure of the answer.
    figure: Figure
    #: The same figure for a narrow screen.
    narrow: Figure
    #: Statements on what the answer covers.
    coverage: Sequence[str]
    #: Statements on its limits.
    limits: Sequence[str]
    #: Table for the printed report.
    table: Table | None = None
    #: Tables and figures below.
    items: Sequence[Table | Figure] = ()


@dataclass(frozen=True)
class Section:
    """A section of the report."""

    #: Name for ``--only``.
    name: str
    #: Title.
    title: str
    #: Texts, tables, figures and pictures.
    items: Sequence[Text | Table | Figure | Sketch | LoadedScrew | FieldPicture | PressureMap]
    #: One or two sentences with which its page begins.
    conclusion: str = ""
    #: First screen of the report, if it is here.
    summary: Summary | None = None


@dataclass(frozen=True)
class Page:
    """A page of the report."""

    #: Stem of its file.
    name: str
    #: Title.
    title: str
    #: Its sections.
    sections: Sequence[Section]
    #: Conclusion with which it begins.
    conclusion: str = ""


@dataclass(frozen=True)
class Report:
    """The whole report; the first `Summary` found in a section is its first page."""

    #: Title.
    title: str
    #: Line below the title.
    subtitle: str
    #: Facts on its origin, such as version and date.
    provenance: Mapping[str, str]
    #: Its pages.
    pages: Sequence[Page]
    #: Inputs of the report for its manifest, as plain data.
    origin: Mapping[str, object] = field(default_factory=dict)

    @property
    def sections(self) -> list[Section]:
        """Return the sections of all pages."""
        return [section for page in self.pages for section in page.sections]
