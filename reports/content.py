"""Records of the contents of a report: tables, figures, pictures and texts, without how they are drawn.

The code that runs the models fills them; other modules of this package turn them into HTML, SVG and CSV files.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rollbench.meshes.axis import Assembly, RollerRow
from rollbench.meshes.parts import Scene

#: Value of one cell of a table; None for an empty cell.
Cell = str | float | int | bool | None
#: One value per node or point, as a list or an array.
Numbers = Sequence[float] | NDArray[np.float64]
#: Several values per node or element, as nested lists or an array.
Rows = Sequence[Sequence[float]] | NDArray[np.float64] | NDArray[np.int64]


@dataclass(frozen=True)
class TableColumn:
    """Column of a report's table: the quantity it shows, with heading, unit and number format.

    Columns that tables share stand in ``columns.toml``. A table whose columns depend on its data makes its own.
    """

    #: Key of the column; of a column in ``columns.toml``, its name.
    key: str
    #: Heading of the column, without the unit.
    label: str
    #: Unit of the values; empty for texts and plain numbers.
    unit: str = ""
    #: Number format: ``"g4"`` for 4 significant digits, ``"s"`` for text, or a format of Python such as ``".2f"``.
    format: str = "g4"
    #: Which coloured label a page shows: ``"class"``, ``"verdict"``, or empty for none.
    mark: str = ""


#: Column of a table: its name in ``columns.toml``; where heading or format have places {}, a tuple of the name and the
#: texts that stand there; or a column that is not in this file.
ColumnKey = str | tuple[str, ...] | TableColumn
#: Row of a table: the value of each column.
Row = dict[ColumnKey, Any]


@cache
def _entries_of_columns() -> dict[str, dict[str, str]]:
    """Return the entries of ``columns.toml`` by name of the column: heading, and where stated unit, format and mark."""
    return tomllib.loads(resources.files("rollbench.reports").joinpath("columns.toml").read_text(encoding="utf-8"))


def table_column(key: ColumnKey) -> TableColumn:
    """Return heading, unit and format of a column from ``columns.toml``.

    ``key``: the column, as `ColumnKey`. Raises KeyError for a name that the file does not have.

    Examples
    --------
    >>> column = table_column("peak_pressure")
    >>> column.label, column.unit, column.format
    ('peak pressure', 'MPa', '.0f')
    """
    if isinstance(key, TableColumn):
        return key
    name, *places = (key,) if isinstance(key, str) else key
    entry = _entries_of_columns()[name]
    heading, number_format = (text.format(*places) for text in (entry["heading"], entry.get("format", "s")))
    return TableColumn(name, heading, entry.get("unit", ""), number_format, mark=entry.get("mark", ""))


def axis_label(axis: ColumnKey) -> str:
    """Return the label of a figure's axis: heading and unit of the column that it shows, as ``contact load / N``.

    ``axis``: the column, as `ColumnKey`; a text that does not look like a name in ``columns.toml`` is a label made from
    data. Raises KeyError for what looks like a name, but is none.

    Examples
    --------
    >>> axis_label("contact_load"), axis_label("load of ball 3 / N")
    ('contact load / N', 'load of ball 3 / N')
    """
    if isinstance(axis, str) and axis not in _entries_of_columns() and not re.fullmatch(r"[a-z]+(_[a-z0-9]+)+", axis):
        return axis
    column = table_column(axis)
    return f"{column.label} / {column.unit}" if column.unit else column.label


@dataclass(frozen=True)
class Table:
    """Table of a report, shown on a page and written as a CSV file: a title and columns of values.

    Raises KeyError for a column that ``columns.toml`` does not have, and ValueError for columns of different lengths or two
    columns with the same heading and unit, which a CSV file could not distinguish.
    """

    #: Name of the table's CSV file, without the ending.
    name: str
    #: Title of the table.
    title: str
    #: Values of each column, in the order of the columns.
    columns: Mapping[ColumnKey, Sequence[Cell]]
    #: Note printed below the table.
    note: str = ""
    #: Whether a page shows the table unfolded even if it is long.
    unfolded: bool = False
    #: Columns that are written to the CSV file but not shown on the page.
    csv_only: Sequence[ColumnKey] = ()
    #: Whether a page shows only title, note and link to the CSV file, and no rows.
    rows_csv_only: bool = False

    def __post_init__(self) -> None:
        """Raise ValueError for columns of different lengths, or two with the same heading and unit."""
        if len(set(map(len, self.columns.values()))) > 1:
            raise ValueError(f"table {self.name!r}: columns of different lengths; give each row a value or None")
        heads = [(column.label, column.unit) for column in self.heads.values()]
        twice = {label for label, unit in heads if heads.count((label, unit)) > 1}
        if twice:
            got = f"several columns have the heading {', '.join(map(repr, sorted(twice)))} and the same unit"
            raise ValueError(f"table {self.name!r}: {got}; give each column a heading of its own")

    @property
    def heads(self) -> dict[ColumnKey, TableColumn]:
        """Heading, unit and format of each column."""
        return {key: table_column(key) for key in self.columns}

    @property
    def rows(self) -> list[Row]:
        """Rows of the table: the value of each column."""
        return [dict(zip(self.columns, cells, strict=True)) for cells in zip(*self.columns.values(), strict=True)]

    @classmethod
    def from_rows(
        cls, name: str, title: str, rows: Iterable[Mapping[Any, Cell]], note: str = "", *, unfolded: bool = False
    ) -> Table:
        """Make a table from rows, each with values by column; the columns are in the order in which they first appear."""
        listed = list(rows)
        keys = dict.fromkeys(key for row in listed for key in row)
        return cls(name, title, {key: [row.get(key) for row in listed] for key in keys}, note, unfolded)


@dataclass(frozen=True)
class Series:
    """Curve, band, histogram or bar chart in one panel of a figure."""

    #: Label of the curve in the legend of its panel.
    label: str
    #: Abscissae of the points.
    x: Sequence[float]
    #: Ordinates of the points.
    y: Sequence[float]
    #: ``"line"``, ``"markers"``, ``"line+markers"``, ``"band"`` (area between y and upper_y), ``"steps"`` (histogram; x:
    #: edges of the bins, one more than y), or ``"bars"`` (horizontal bars from zero to x at the heights y).
    style: str = "line+markers"
    #: Ordinates of the upper limit of a band.
    upper_y: Sequence[float] | None = None
    #: Whether the curve is drawn bold.
    bold: bool = False
    #: Lower and upper ends of the error bars of the points.
    error_bars: tuple[Sequence[float], Sequence[float]] | None = None
    #: Whether the curve is thin and pale and has no entry in the legend.
    pale: bool = False
    #: Texts written next to the points; the curve then has no entry in the legend.
    point_labels: Sequence[str] = ()
    #: Names of the points; a web page shows the name of the point under the mouse pointer.
    point_names: Sequence[str] = ()


@dataclass(frozen=True)
class Panel:
    """Panel of a figure: one coordinate system with its curves."""

    #: Title of the panel.
    title: str
    #: Column that the abscissa shows, or its label (see `axis_label`).
    xlabel: ColumnKey
    #: Column that the ordinate shows, or its label.
    ylabel: ColumnKey
    #: Curves, bands and bars in the panel.
    series: Sequence[Series]
    #: Which axes are logarithmic: ``""``, ``"x"``, ``"y"`` or ``"xy"``.
    log_axes: str = ""
    #: Whether the range of the ordinate includes zero.
    include_zero: bool = False
    #: Whether the abscissa is labelled at integers only.
    integer_x: bool = False
    #: Names written at 1, 2, 3, ... of the abscissa in place of these numbers.
    abscissa_names: Sequence[str] = ()
    #: Names written at 1, 2, 3, ... of the ordinate in place of these numbers; the ordinate then points downwards.
    ordinate_names: Sequence[str] = ()


@dataclass(frozen=True)
class Figure:
    """Figure with one or more panels, written as an SVG file."""

    #: Name of the figure's SVG file, without the ending.
    name: str
    #: Title of the figure.
    title: str
    #: Panels, row by row.
    panels: Sequence[Panel]
    #: Caption below the figure.
    caption: str = ""
    #: Number of panels per row, at most 3.
    columns: int = 2
    #: Width and height [inches of 96 pixels]; None: chosen by the number of panels.
    size: tuple[float, float] | None = None
    #: Whether the ordinates of all panels have the same range.
    same_y: bool = False


@dataclass(frozen=True)
class NutOrBearingView:
    """Data of one ball nut or bearing row in one load case, for the 3D view of a page."""

    #: Name of the nut or bearing row in the scene file.
    name: str
    #: Kind: ball screw, or type of bearing.
    kind: str
    #: Geometry of the balls with their grooves, or of the rollers.
    parts: Scene | RollerRow
    #: Axial position of the row on the shaft [m].
    position: float
    #: Direction of the axial load that the row can carry, as in `meshes.axis.RollingSet`.
    thrust: str = "both"
    #: Contact points of n balls with four flanks (n, 4, 3) [m]; None for rollers, or if no equilibrium was found.
    points: NDArray[np.float64] | None = None
    #: Contact forces on n balls at their contacts with four flanks (n, 4, 3) [N]; None as for ``points``.
    forces: NDArray[np.float64] | None = None
    #: Reference solution: its label, its contact loads (n, 4) [N], their uncertainty (n, 4) [N], and the error of the
    #: model's loads (n, 4) [%]. None without a reference.
    reference: tuple[str, NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]] | None = None
    #: Error of the low-order model's contact loads to be expected from its errors on other scenes [N]; None: not known.
    expected: float | None = None
    #: Reduction of the clearance at each contact of n balls with four flanks by geometric errors of balls and grooves
    #: (n, 4) [m]; None: not shown.
    closer: NDArray[np.float64] | None = None


@dataclass(frozen=True)
class LoadCaseView:
    """Data of one load case for the 3D view of a scene."""

    #: Name of the load case; empty if there is only one.
    name: str
    #: Ball nuts and bearing rows.
    nuts_and_bearings: Sequence[NutOrBearingView]
    #: Shaft that carries several nuts or bearing rows; None for a single screw or bearing.
    shaft: Assembly | None = None


@dataclass(frozen=True)
class SceneView:
    """Data of a web page that shows a solved scene as a 3D model, which the reader can rotate."""

    #: Title of the page.
    title: str
    #: Line of text below the title of the page.
    subtitle: str
    #: Load cases, in the order of ``results``.
    load_cases: Sequence[LoadCaseView]
    #: Results as written by the command ``solve --json``.
    results: Mapping[str, Any]


@dataclass(frozen=True)
class LoadedScrew:
    """3D picture of a screw, its nut and its balls, with the contact forces as arrows."""

    #: Name of the picture's file, without the ending.
    name: str
    #: Title of the picture.
    title: str
    #: Geometry of the screw, nut and balls.
    scene: Scene
    #: Contact loads of n balls (n, 4) [N]; the largest load of a ball gives its colour.
    load: NDArray[np.float64]
    #: Points at which arrows are drawn (m, 3) [m].
    contact_points: NDArray[np.float64]
    #: Contact forces on the balls at the points ``contact_points`` (m, 3) [N], drawn as arrows.
    contact_forces: NDArray[np.float64]
    #: Caption below the picture.
    caption: str = ""
    #: Page with the same scene as a 3D model that can be rotated; None without such a page.
    view: SceneView | None = None


@dataclass(frozen=True)
class Sketch:
    """Sketch of a screw or bearing from the side, with its supports and loads."""

    #: Name of the sketch's file, without the ending.
    name: str
    #: Title of the sketch.
    title: str
    #: Geometry, supports and loads of the screw or bearing.
    scene: Scene
    #: Caption below the sketch.
    caption: str = ""


@dataclass(frozen=True)
class MeshPart:
    """Finite-element mesh, or part of one, in a 3D picture."""

    #: Coordinates of the nodes (n, 3) [m].
    points: Rows
    #: Node numbers of each element, in gmsh's order.
    cells: Rows
    #: Element type: ``"P1"``, ``"P2"`` (tetrahedra with 4 or 10 nodes) or ``"Q2"`` (hexahedra with 27 nodes).
    kind: str
    #: Values at the nodes (n,), which give the colour; None: the mesh has the colour ``colour``.
    values: Numbers | None = None
    #: Colour of a mesh without values.
    colour: str = "#c3c8ce"
    #: Whether the edges of the elements are drawn.
    edges: bool = True
    #: Whether the outline of a plane section through the mesh is drawn.
    outline: bool = False
    #: Width of the drawn element edges [pixels].
    line: float = 1.2


@dataclass(frozen=True)
class FieldPicture:
    """3D picture of finite-element meshes, of fields on them, or of a plane section through them."""

    #: Name of the picture's file, without the ending.
    name: str
    #: Title of the picture.
    title: str
    #: Meshes in the picture.
    parts: Sequence[MeshPart]
    #: Direction from the pictured body to the viewer.
    sight: Numbers
    #: Direction that points upwards in the picture.
    up: Numbers
    #: Point in the middle of the picture (3,) [m].
    focus: Numbers
    #: Height of the region that the picture shows [m].
    height: float
    #: Cutting planes, each as a point and a normal; elements whose centre lies on the normal's side of all planes are
    #: not drawn.
    cuts: Sequence[tuple[Numbers, Numbers]] = ()
    #: Whether the plane section by the only cutting plane is drawn, in place of the meshes.
    section: bool = False
    #: Name of the drawn field, with unit, at the colour scale.
    label: str = ""
    #: Ends of the colour scale; None: the range of the data.
    limits: tuple[float, float] | None = None
    #: Whether the colour scale is logarithmic.
    log: bool = False
    #: Texts written into the picture, as pairs of point [m] and text.
    words: Sequence[tuple[Numbers, str]] = ()
    #: Length of a scale bar [m]; 0 for none.
    scale_bar: float = 0.0
    #: Caption below the picture.
    caption: str = ""


@dataclass(frozen=True)
class Picture:
    """Picture that is drawn already."""

    #: Name of the picture's file, without the ending.
    name: str
    #: Title of the picture.
    title: str
    #: Bytes of the PNG file; those of two machines may differ.
    png: NDArray[np.uint8] = field(compare=False)
    #: Caption below the picture.
    caption: str = ""


@dataclass(frozen=True)
class PressurePanel:
    """Contour plot of the pressure in one contact, with the contact ellipse of Hertz's theory."""

    #: Title of the plot.
    title: str
    #: Abscissae of the contact's nodes, in the unit of the axis label.
    x: Numbers
    #: Ordinates of the contact's nodes, in the unit of the axis label.
    y: Numbers
    #: Pressure or other field at the contact's nodes, in the unit of the colour scale.
    values: Numbers
    #: Ellipse in the plot: x and y of its centre, semi-axes along x and y.
    ellipse: tuple[float, float, float, float]
    #: Text above the plot, such as load and largest pressure.
    text_above: str = ""
    #: Components (x, y) of an arrow at each node, such as the tangential traction; None: no arrows.
    arrows: tuple[Numbers, Numbers] | None = None
    #: Step of the nodes at which arrows are drawn: at every ``arrow_step``-th node.
    arrow_step: int = 1
    #: Whether each node is marked by a square; None: no node is marked.
    marked_nodes: Sequence[bool] | None = None


@dataclass(frozen=True)
class PressureMap:
    """Figure with pressure contours of one to four contacts, on one colour scale."""

    #: Name of the figure's SVG file, without the ending.
    name: str
    #: Title of the figure.
    title: str
    #: Contour plot of each contact.
    panels: Sequence[PressurePanel]
    #: Label of the abscissa, with unit.
    xlabel: str
    #: Label of the ordinate, with unit.
    ylabel: str
    #: Label of the colour scale, with unit.
    colour_label: str
    #: Label of the ellipses in the legend.
    ellipse_label: str = "contact ellipse by Hertz theory"
    #: Label of marked nodes in the legend.
    marked_label: str = ""
    #: Caption below the figure.
    caption: str = ""
    #: Number of panels per row.
    columns: int = 2
    #: Width [inches of 96 pixels]; None: chosen by the number of panels per row.
    width: float | None = None


@dataclass(frozen=True)
class Text:
    """Text of a section: paragraphs or a bulleted list."""

    #: Paragraphs of plain text.
    paragraphs: Sequence[str]
    #: Whether the paragraphs are items of a bulleted list.
    bullets: bool = False


@dataclass(frozen=True)
class Summary:
    """Contents of the report's first page: the question, its answer, a figure, and the limits of the answer."""

    #: Question that the report answers.
    question: str
    #: Answers, each with its heading.
    answers: Sequence[tuple[str, str]]
    #: Figure that shows the answer.
    figure: Figure
    #: Statements on what the answer covers.
    coverage: Sequence[str]
    #: Statements on the limits of the answer.
    limits: Sequence[str]
    #: Table with the numbers of the answer, for a printed report.
    table: Table | None = None
    #: Further tables and figures of the report's first page.
    items: Sequence[Table | Figure] = ()


#: What a section of a report may contain.
Item = Text | Table | Figure | Sketch | LoadedScrew | FieldPicture | Picture | PressureMap


@dataclass(frozen=True)
class Section:
    """Section of a report: a heading with texts, tables, figures and pictures."""

    #: Name by which the command ``report --only`` selects the section.
    name: str
    #: Title of the section.
    title: str
    #: Texts, tables, figures and pictures in the section.
    items: Sequence[Item]
    #: One or two sentences, with which the section's page begins.
    conclusion: str = ""
    #: Summary for the report's first page, if this section has one.
    summary: Summary | None = None


@dataclass(frozen=True)
class Page:
    """Web page of a report, with one or more sections."""

    #: Name of the page's file, without the ending.
    name: str
    #: Title of the page.
    title: str
    #: Sections of the page.
    sections: Sequence[Section]
    #: Conclusion with which the page begins.
    conclusion: str = ""


@dataclass(frozen=True)
class Report:
    """Complete report of several web pages; the first `Summary` in a section makes the report's first page."""

    #: Title of the report.
    title: str
    #: Line of text below the title of the report.
    subtitle: str
    #: Facts on the report's origin, such as version and date.
    provenance: Mapping[str, str]
    #: Web pages, in their order.
    pages: Sequence[Page]
    #: Inputs of the report, as plain data for its manifest file.
    origin: Mapping[str, object] = field(default_factory=dict)

    @property
    def sections(self) -> list[Section]:
        """Return the sections of all pages, in the order of the pages."""
        return [section for page in self.pages for section in page.sections]
