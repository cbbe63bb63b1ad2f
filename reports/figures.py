"""Draw the diagrams of a report as SVG, legible in grey print; identical data give an identical file, byte by byte."""

from __future__ import annotations

import io
import math
import re
import textwrap
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import pairwise
from typing import Any

import matplotlib
import matplotlib.figure
import numpy as np
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter, ScalarFormatter
from matplotlib.transforms import ScaledTranslation
from numpy.typing import NDArray
from scipy.optimize import isotonic_regression

from rollbench.reports.cells import replace_um_by_micrometre
from rollbench.reports.content import Figure, Panel, PressureMap, PressurePanel, Series, axis_label

#: Colours of curves: the palette of Okabe and Ito, safe for colour blindness, without yellow and with dark tones first.
PALETTE = ("#0072B2", "#D55E00", "#009E73", "#7B4EA3", "#E69F00", "#333333", "#56B4E9", "#CC79A7")
#: Markers and line styles of curves, by the number of the curve.
MARKERS = ("o", "s", "^", "D", "v", "x", "P", "*")
DASHES: tuple[Any, ...] = ("-", (0, (5, 1.6)), (0, (1.4, 1.3)), (0, (6, 1.5, 1.4, 1.5)))
#: Colour map of fields such as the contact pressure: lightness grows with the value, also in grey print.
COLOURS = "viridis"
#: Permitted values of ``Series.style``, and of ``Panel.log_axes``.
STYLES, SCALES = ("line", "markers", "line+markers", "band", "steps", "bars"), ("", "x", "y", "xy")

#: Colours in an SVG that the web page can replace, and the name of the CSS variable of each.
THEME = {"#222222": "ink", "#8a8f98": "frame", "#dfe2e6": "grid", "#ffffff": "paper", "white": "paper"}
THEME |= {colour.lower(): f"c{number}" for number, colour in enumerate(PALETTE)}
#: Fonts used when the SVG is shown. The layout is computed with DejaVu Sans, which is wider than any of them.
FONTS = "'Helvetica Neue', Helvetica, Arial, 'Liberation Sans', sans-serif"

_WIDTH = {1: 7.6, 2: 10.0, 3: 10.4}  # width of a figure [inches of 96 pixels] by its number of panel columns
_HEIGHT = {1: 3.5, 2: 3.2, 3: 2.7}  # height of one row of panels [inches] by the number of panel columns
_INK, _FRAME, _GRID = "#222222", "#8a8f98", "#dfe2e6"
_RC = {
    "svg.fonttype": "none",
    "font.family": ["DejaVu Sans"],
    "font.size": 8.5,
    "text.color": _INK,
    "axes.titlesize": 9.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 8.5,
    "axes.labelcolor": _INK,
    "axes.edgecolor": _FRAME,
    "axes.linewidth": 0.7,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.unicode_minus": True,
    "grid.color": _GRID,
    "grid.linewidth": 0.6,
    "xtick.color": _FRAME,
    "ytick.color": _FRAME,
    "xtick.labelcolor": _INK,
    "ytick.labelcolor": _INK,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "legend.fontsize": 8.0,
    "legend.frameon": False,
    "path.simplify": False,
}
#: Vertical distance between neighbouring labels of data points, and distance of the labels from the points [1/72 inch].
LINE, AWAY = 10.0, 10.0
#: Approximate width of a letter in the labels of data points [1/72 inch].
LETTER = 4.1
#: Width of a tick label such as 10⁻³ on a logarithmic abscissa [1/72 inch].
TICK = 32.0
#: Width of a figure below which its legend has a single column [inches].
NARROW = 5.0
#: Largest number of names along an abscissa that are written nearly horizontally; more names are written steeply.
LEVEL_NAMES = 8
#: Height that each letter of a steeply written name needs below the abscissa [inches].
STEEP = 0.055
#: Width of a figure that a phone shows in its full width, with letters that can be read there [inches].
PHONE = 4.4
#: Points within this share of a panel's width, from its left end, have their labels on their left; others on the right.
LEFT = 0.4


def spread_label_heights(heights: Sequence[float], gap: float, low: float, high: float) -> NDArray[np.float64]:
    """Return the heights of text labels, moved as little as possible, so that neighbours are at least ``gap`` apart.

    The labels keep their vertical order, and stay between ``low`` and ``high`` if there is room for all.

    Parameters
    ----------
    heights
        Wanted heights of the labels.
    gap
        Smallest permitted distance of neighbours.
    low, high
        Lower and upper end of the permitted range.

    Returns
    -------
    Array
        Moved heights, in the order of ``heights``.

    Examples
    --------
    >>> spread_label_heights([1.0, 1.0, 5.0], 2.0, 0.0, 10.0).tolist()
    [0.0, 2.0, 5.0]
    """
    order = np.argsort(heights, kind="stable")
    rank = gap * np.arange(len(order))
    wanted = np.asarray(heights, float)[order] - rank
    rising = isotonic_regression(wanted).x if len(wanted) else wanted
    level = np.clip(rising, low, max(low, high - gap * (len(order) - 1)))
    out = np.empty(len(order))
    out[order] = level + rank
    return out


def write_point_labels(axes: Any, series: Sequence[Series]) -> None:
    """Write the texts of the data points in two columns, left and right of all points, with a thin line to each point.

    ``axes``: axes of matplotlib in which the curves ``series`` are already drawn. The range of the abscissa is extended
    until the texts have room.
    """
    points = [(x, y, text) for s in series for x, y, text in zip(s.x, s.y, s.point_labels, strict=False) if text]
    if not points:
        return
    spread = [float(x) for s in series for x in s.x]
    ends = [(min(spread), points[0][1], ""), (max(spread), points[0][1], "")]
    place, width, _ = _label_positions_in_panel(axes, [*points, *ends])
    left = place[:-2, 0] < LEFT * width
    long = np.array([LETTER * len(text) + 2.0 * AWAY for *_, text in points])
    room = np.array([long.max(initial=0.0, where=left), long.max(initial=0.0, where=~left)])
    _widen_abscissa_for_labels(axes, place[-2:, 0] / width, room / width, np.array([True, False]))
    place, width, height = _label_positions_in_panel(axes, [*points, *ends])
    if axes.get_xscale() == "log":  # the abscissa now has more decades
        axes.xaxis.set_major_locator(LogLocator(numticks=max(3, int(width / TICK))))
    for side, column, align in ((left, place[-2, 0] - AWAY, "right"), (~left, place[-1, 0] + AWAY, "left")):
        heights = spread_label_heights(place[:-2][side, 1].tolist(), LINE, 0.5 * LINE, height - 0.5 * LINE)
        for at, up in zip(np.flatnonzero(side), heights, strict=True):
            x, y, text = points[at]
            axes.annotate(
                text,
                (x, y),
                (column, up),
                textcoords="axes points",
                ha=align,
                va="center",
                fontsize=8.0,
                zorder=4.0,
                annotation_clip=False,
                in_layout=False,
                arrowprops={"arrowstyle": "-", "linewidth": 0.5, "color": "#8a8f98", "shrinkA": 0.0, "shrinkB": 2.0},
            )


def _label_positions_in_panel(
    axes: Any, labelled_points: Sequence[tuple[float, float, str]]
) -> tuple[NDArray[np.float64], float, float]:
    """Return the positions (n, 2) of data points within a panel, and the panel's width and height [1/72 inch].

    ``axes``: axes of matplotlib. ``labelled_points``: abscissa, ordinate and text of each point. Positions are measured
    from the panel's lower left corner.
    """
    scale, box = 72.0 / axes.figure.dpi, axes.get_window_extent()
    place = axes.transData.transform([(x, y) for x, y, _ in labelled_points]) - (box.x0, box.y0)
    return scale * place, scale * box.width, scale * box.height


def _widen_abscissa_for_labels(
    axes: Any, label_positions: NDArray[np.float64], label_widths: NDArray[np.float64], is_left: NDArray[np.bool_]
) -> None:
    """Extend the range of the abscissa until labels on the left and on the right of the data have room.

    ``axes``: axes of matplotlib. ``label_positions``: positions on the abscissa next to which labels are written.
    ``label_widths``: width of the labels there. Both are fractions of the panel's width, in arrays of equal length.
    ``is_left``: whether the labels are on the left of the position.
    """
    scale = axes.xaxis.get_transform()
    low, high = scale.transform(np.asarray(axes.get_xlim(), float))
    where = low + label_positions * (high - low)
    for _ in range(3):  # repeated, because extending one end reduces the room at the other
        ends = [(x - share * high) / (1.0 - share) for x, share in zip(where[is_left], label_widths[is_left], strict=True)]
        low = min([low, *ends])
        ends = [(x - share * low) / (1.0 - share) for x, share in zip(where[~is_left], label_widths[~is_left], strict=True)]
        high = max([high, *ends])
    axes.set_xlim(*scale.inverted().transform(np.array([low, high])))


@contextmanager
def report_plot_style(name: str) -> Iterator[None]:
    """Apply the report's matplotlib settings inside a ``with`` block, independent of the user's own settings.

    ``name``: name of the figure, from which matplotlib derives the identifiers in the SVG.
    """
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update({**_RC, "svg.hashsalt": f"rollbench-{name}"})
        yield


def phone_figure(figure: Figure) -> Figure:
    """Return a copy of a figure for a phone, `PHONE` inches wide, with panels in one column and long labels wrapped."""

    def wrap_label(text: str, length: int) -> str:
        return textwrap.fill(text, length, break_long_words=False)

    panels = [
        replace(
            panel,
            title=wrap_label(panel.title, 44),
            xlabel=wrap_label(axis_label(panel.xlabel), 44),
            ylabel=wrap_label(axis_label(panel.ylabel), 32),
            series=[replace(series, label=wrap_label(series.label, 40)) for series in panel.series],
        )
        for panel in figure.panels
    ]
    rows = max(len(panel.ordinate_names) for panel in panels)
    names = sum(max((len(name) for name in panel.abscissa_names), default=0) for panel in panels)
    labels = {series.label for panel in panels for series in panel.series if series.label}
    legend_lines = sum(label.count("\n") + 1 for label in labels)
    height = len(panels) * max(2.5, 0.26 * rows) + 0.07 * names + 0.17 * legend_lines + 0.3
    return replace(figure, panels=panels, columns=1, size=(PHONE, height))


def draw_panels_in_column(figure: Figure) -> str:
    """Return the SVG document of a figure whose panels are drawn below each other, each as wide as a phone.

    If there are several panels, the document has a view (element ``<view>``) of each, and one of their common legend, so
    that a page can show them side by side where there is room.
    """
    svg, canvas = draw_figure_and_canvas(phone_figure(figure))
    if len(figure.panels) == 1:
        return svg
    parts: list[Any] = [*canvas.axes, *canvas.legends]
    boxes = [part.get_tightbbox().transformed(canvas.transFigure.inverted()) for part in parts]
    ends = [1.0, *(0.5 * (above.y0 + below.y1) for above, below in pairwise(boxes)), 0.0]
    (width, height), prefix = 72.0 * canvas.get_size_inches(), _prefix_of_identifiers(figure.name)
    views = (
        f'<view id="{prefix}-view{k}" viewBox="0 {height * (1.0 - top):.2f} {width:.2f} {height * (top - low):.2f}"/>\n'
        for k, (top, low) in enumerate(pairwise(ends), start=1)
    )
    return svg.replace("</svg>", f"{''.join(views)}</svg>")


class Canvas(matplotlib.figure.Figure):
    """Figure of matplotlib that a notebook shows as a picture, without a back end of pyplot."""

    def _repr_svg_(self) -> str:
        """Return the SVG document of the figure, for notebooks."""
        stream = io.StringIO()
        self.savefig(stream, format="svg")
        return stream.getvalue()


def draw_figure(figure: Figure) -> str:
    """Return the SVG document of a figure; see `draw_figure_and_canvas`."""
    return draw_figure_and_canvas(figure)[0]


def draw_figure_and_canvas(figure: Figure) -> tuple[str, Canvas]:
    """Draw a figure; return its SVG document and the matplotlib figure.

    Parameters
    ----------
    figure
        Curves, labels and layout of the figure. Curves with equal labels have the same colour and marker in all panels.

    Returns
    -------
    str
        SVG document without date or version. Its identifiers begin with the figure's name, so that one page can contain
        several figures.
    Canvas
        The matplotlib figure that was drawn.

    Raises
    ------
    ValueError
        If there is no panel, or if the style of a curve or the scale of a panel is unknown.
    """
    if not figure.panels:
        raise ValueError(f"figure {figure.name!r} has no panel; give it at least one")
    for panel in figure.panels:
        odd = {series.style for series in panel.series} - set(STYLES)
        fault = f"unknown curve styles {sorted(odd)}; allowed: {', '.join(STYLES)}" if odd else ""
        if not odd and panel.log_axes not in SCALES:
            allowed = ", ".join(map(repr, SCALES))
            fault = f"unknown log {panel.log_axes!r} (which axes are logarithmic); allowed: {allowed}"
        if fault:
            raise ValueError(f"figure {figure.name!r}, panel {panel.title!r}: {fault}")
    columns = max(1, min(figure.columns, len(figure.panels), 3))
    rows = math.ceil(len(figure.panels) / columns)
    with report_plot_style(figure.name):
        canvas = Canvas(layout=ConstrainedLayoutEngine(w_pad=0.06, h_pad=0.05, wspace=0.03, hspace=0.05))
        svg = FigureCanvasSVG(canvas)
        orders = _style_numbers_of_curves(figure.panels)
        legends = 0
        narrow = figure.size is not None and figure.size[0] < NARROW
        shared = len(figure.panels) > 1 and _one_legend_is_enough(figure.panels, narrow)
        for number, (panel, order) in enumerate(zip(figure.panels, orders, strict=True), start=1):
            first = canvas.axes[0] if canvas.axes and figure.same_y else None
            axes = canvas.add_subplot(rows, columns, number, sharey=first)
            steep = narrow or len(panel.abscissa_names) > LEVEL_NAMES
            _draw_panel(axes, panel, order, steep=steep)
            if not shared:
                lower = STEEP * max(map(len, panel.abscissa_names), default=0) if steep else 0.0
                legends = max(legends, _draw_legend_below(axes, 1 if narrow else 2 if columns > 1 else 3, lower))
        if shared:
            found = [pair for axes in canvas.axes for pair in zip(*axes.get_legend_handles_labels(), strict=True)]
            labels = list(dict.fromkeys(label for _, label in found))
            if labels:
                handles = [next(handle for handle, label in found if label == name) for name in labels]
                place = "outside lower center"
                count = min(1 if narrow else 2 if max(map(len, labels)) > 34 else 4, len(labels))
                canvas.legend(handles, labels, loc=place, ncols=count, handlelength=3.2)
                legends = max(1, math.ceil(len(labels) / count) - 2)
        canvas.set_size_inches(*(figure.size or (_WIDTH[columns], rows * (_HEIGHT[columns] + 0.2 * legends))))
        if any(series.point_labels for panel in figure.panels for series in panel.series):
            canvas.draw_without_rendering()  # computes the positions of the axes, which the texts of the points need
            for axes, panel in zip(canvas.axes, figure.panels, strict=True):
                write_point_labels(axes, panel.series)
        stream = io.StringIO()
        # not savefig, which would draw everything twice
        svg.print_svg(stream, metadata={"Date": None, "Creator": None, "Title": figure.title})
    return _svg_for_web_page(stream.getvalue(), figure.name), canvas


def draw_pressure_map(item: PressureMap) -> str:
    """Return an SVG document with pressure contours of one to four contacts and the contact ellipse of each.

    ``item``: pressures and labels of the figure. The contours are embedded as an image, the axes and texts as vector
    graphics.
    """
    columns = max(1, min(item.columns, len(item.panels)))
    rows = math.ceil(len(item.panels) / columns)
    spans = [max(float(np.ptp(getattr(p, k))) for p in item.panels) for k in ("x", "y")]
    top = max(float(np.max(panel.values)) for panel in item.panels)
    levels = MaxNLocator(nbins=10, steps=[1, 2, 2.5, 5, 10]).tick_values(0.0, top)
    width = item.width or _WIDTH[columns]
    drawn = (width - 1.1) / columns - 0.7
    above = [textwrap.fill(panel.text_above, int(72.0 * drawn / LETTER)) for panel in item.panels]
    with report_plot_style(item.name):
        canvas = Canvas(layout=ConstrainedLayoutEngine(w_pad=0.06, h_pad=0.05, wspace=0.03, hspace=0.05))
        FigureCanvasSVG(canvas)
        filled: Any = None
        for number, panel in enumerate(item.panels, start=1):
            first = canvas.axes[0] if canvas.axes else None
            axes = canvas.add_subplot(rows, columns, number, sharex=first, sharey=first)
            filled = _draw_contours(axes, panel, levels, item)
            _write_above_panel(axes, panel.title, above[number - 1])
            axes.set_xlabel(item.xlabel)
            axes.set_ylabel(item.ylabel)
        canvas.colorbar(filled, ax=canvas.axes, label=item.colour_label, aspect=14 * rows, pad=0.02)
        legend = {
            name: handle for axes in canvas.axes for handle, name in zip(*axes.get_legend_handles_labels(), strict=True)
        }
        lines = len(legend) if width < NARROW else 1
        canvas.legend(list(legend.values()), list(legend), loc="outside lower center", ncols=math.ceil(len(legend) / lines))
        height = max(drawn * spans[1] / spans[0], 0.5) + 0.85 + 0.15 * max(text.count("\n") + 1 for text in above)
        canvas.set_size_inches(width, rows * height + 0.1 + 0.2 * lines)
        stream = io.StringIO()
        metadata = {"Date": None, "Creator": None, "Title": item.title}
        canvas.savefig(stream, format="svg", metadata=metadata, dpi=200)
    return _svg_for_web_page(stream.getvalue(), item.name)


def _svg_for_web_page(svg: str, name: str) -> str:
    """Return an SVG document for a web page: short, with identifiers unique to this figure, and um written as µm.

    ``svg``: document that matplotlib wrote. ``name``: name of the figure. No file is written.
    """
    svg = re.sub(r"\s*<metadata>.*?</metadata>", "", svg.replace("'DejaVu Sans'", FONTS), flags=re.DOTALL)
    svg = re.sub(r"<[^>]*>", lambda tag: _short_tag(tag[0]), _number_identifiers(svg, name))
    svg = _styles_as_classes(re.sub(r"\n\s+", "\n", svg), name)
    return re.sub(r">[^<]+<", lambda text: replace_um_by_micrometre(text[0]), svg)


def _short_tag(tag: str) -> str:
    """Return a tag of an SVG document in one line, with lengths rounded to a hundredth of a point."""
    tag = re.sub(r"\d+\.\d{3,}", lambda number: f"{float(number[0]):.2f}".rstrip("0").rstrip("."), re.sub(r"\s+", " ", tag))
    return re.sub(r'(?<= d=")[^"]*', lambda path: re.sub(r" ?([A-Za-z]) ?", r"\1", path[0]), tag)


def _styles_as_classes(svg: str, name: str) -> str:
    """Return an SVG document in which the styles of all elements are classes of a style sheet, for this document alone.

    ``svg``: document without identifier; ``name``: name of the figure.
    """
    styles = {style: f"s{k}" for k, style in enumerate(dict.fromkeys(re.findall(r' style="([^"]*)"', svg)))}
    svg = re.sub(r' style="([^"]*)"', lambda match: f' class="{styles[match[1]]}"', svg)
    place = _prefix_of_identifiers(name)
    sheet = "".join(f"\n#{place} .{short}{{{style}}}" for style, short in styles.items())
    return svg.replace("<svg ", f'<svg id="{place}" ', 1).replace("</style>", f"{sheet}</style>", 1)


def _draw_contours(axes: Any, panel: PressurePanel, levels: Any, item: PressureMap) -> Any:
    """Draw the pressure contours of one contact with the contact ellipse, the nodes, and arrows at nodes if there are any.

    ``axes``: axes of matplotlib. ``levels``: pressures at which contours are drawn, common to all contacts of the figure
    ``item``, which has the labels of the legend. Returns the contours, for the colour scale.
    """
    x, y = np.asarray(panel.x, float), np.asarray(panel.y, float)
    filled = axes.tricontourf(x, y, np.asarray(panel.values, float), levels=levels, cmap=COLOURS)
    filled.set_rasterized(True)
    axes.plot(x, y, ".", markersize=1.6, color="#ffffff", alpha=0.7, rasterized=True)
    if panel.marked_nodes is not None:
        at = np.asarray(panel.marked_nodes, bool)
        axes.plot(x[at], y[at], "s", markersize=4.0, markerfacecolor="none", color="#ff9db4", label=item.marked_label)
    if panel.arrows is not None:
        arrows = (np.asarray(values, float)[:: panel.arrow_step] for values in (x, y, *panel.arrows))
        axes.quiver(*arrows, color="#ffffff", angles="xy", pivot="mid", scale=24.0, width=0.003)
    x0, y0, a, b = panel.ellipse
    around = np.linspace(0.0, 2.0 * np.pi, 181)
    axes.plot(x0 + a * np.cos(around), y0 + b * np.sin(around), color="#ff5a36", linewidth=1.6, label=item.ellipse_label)
    axes.set_aspect("equal")
    axes.grid(visible=False)
    axes.set_facecolor("#eceef1")
    return filled


def _write_above_panel(axes: Any, title: str, text: str) -> None:
    """Write the title of a panel and below it a text, whose length does not change the width of the panel.

    ``axes``: axes of matplotlib. ``text``: lines of the text; empty: none.
    """
    axes.set_title(title, pad=9.0 + 11.0 * (text.count("\n") + 1) if text else 7.0)
    where: dict[str, Any] = {"xycoords": "axes fraction", "textcoords": "offset points", "va": "bottom"}
    axes.annotate(text, (0.0, 1.0), (0.0, 6.0), in_layout=False, **where)


def _style_numbers_of_curves(panels: Sequence[Panel]) -> list[dict[str, int]]:
    """Return, for each panel, a number for the label of each curve, which determines its colour, marker and line style.

    A label that occurs in several panels has the same number in all of them.
    """
    labels = [list(dict.fromkeys(series.label for series in panel.series)) for panel in panels]
    count = Counter(label for names in labels for label in names)
    fixed = {label: number for number, label in enumerate(label for label in count if count[label] > 1)}
    orders = []
    for names in labels:
        taken = {fixed[label] for label in names if label in fixed}
        free = (number for number in range(len(names) + len(fixed)) if number not in taken)
        orders.append({label: fixed[label] if label in fixed else next(free) for label in names})
    return orders


def _one_legend_is_enough(panels: Sequence[Panel], narrow: bool) -> bool:
    """Return whether all panels have one legend: if their labels are equal or, on a phone (``narrow``), some are common."""
    labels = [{series.label for series in panel.series if series.label} for panel in panels]
    in_several = len(set().union(*labels)) < sum(map(len, labels))
    return len({tuple(series.label for series in panel.series) for panel in panels}) == 1 or (narrow and in_several)


def _draw_panel(axes: Any, panel: Panel, style_numbers: dict[str, int], *, steep: bool = False) -> None:
    """Draw the curves, axis labels and scales of one panel.

    ``axes``: axes of matplotlib. ``style_numbers``: number of the colour and marker of each label. ``steep``: whether names
    along the abscissa are written steeply.
    """
    for series in panel.series:
        _draw_series(axes, series, style_numbers[series.label])
    axes.set_title(panel.title, pad=7)
    axes.set_xlabel(axis_label(panel.xlabel))
    axes.set_ylabel(axis_label(panel.ylabel))
    values = {
        "x": np.concatenate([[], *(np.asarray(series.x, float) for series in panel.series)]),
        "y": np.concatenate([[], *(np.asarray(y, float) for s in panel.series for y in (s.y, *(s.error_bars or ())))]),
    }
    for name, axis in (("x", axes.xaxis), ("y", axes.yaxis)):
        finite = values[name][np.isfinite(values[name])]
        if name in panel.log_axes and np.any(finite > 0.0):
            _make_axis_logarithmic(axes, axis, name, finite[finite > 0.0])
        else:
            formatter = ScalarFormatter(useOffset=False)
            formatter.set_powerlimits((-4, 6))
            axis.set_major_formatter(formatter)
    if panel.integer_x and "x" not in panel.log_axes:
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    if panel.abscissa_names:
        axes.set_xticks(
            range(1, len(panel.abscissa_names) + 1),
            panel.abscissa_names,
            rotation=60.0 if steep else 20.0,
            ha="right",
            rotation_mode="anchor",
        )
    if panel.ordinate_names:
        axes.set_yticks(range(1, len(panel.ordinate_names) + 1), panel.ordinate_names)
        axes.set_ylim(len(panel.ordinate_names) + 0.6, 0.4)
        axes.grid(visible=False, axis="y")
    if panel.include_zero and "y" not in panel.log_axes:
        _extend_ordinate_to_zero(axes, values["y"])
    if not np.any(np.isfinite(values["y"])):
        axes.text(0.5, 0.5, "no data", transform=axes.transAxes, ha="center", va="center", color=_FRAME)


def _draw_series(axes: Any, series: Series, style_number: int) -> None:
    """Draw one curve, band, histogram or bar chart with the colour, marker and line style of its number.

    ``axes``: axes of matplotlib. Raises ValueError if the number of texts, names or error bars differs from the number of
    points.
    """
    bars = zip(("lower error bars", "upper error bars"), series.error_bars or (), strict=False)
    for what, values in (("texts", series.point_labels), ("names", series.point_names), *bars):
        if len(values) not in (0, len(series.x)):
            allowed = f"one for each of the {len(series.x)} points"
            raise ValueError(f"curve {series.label!r} has {len(values)} {what}; allowed: {allowed}")
    x, y = np.asarray(series.x, float), np.asarray(series.y, float)
    colour = PALETTE[style_number % len(PALETTE)]
    marker = MARKERS[(style_number + style_number // len(PALETTE)) % len(MARKERS)]
    label = "_nolegend_" if series.pale or series.point_labels or not series.label else series.label
    if series.pale:
        drawn: dict[str, Any] = {"linewidth": 0.8} if series.style == "line" else {"linestyle": "none", "marker": "."}
        axes.plot(x, y, markersize=4.0, color=colour, alpha=0.35, label=label, zorder=1.8, **drawn)
        return
    if series.style == "steps":
        axes.stairs(series.y, x, fill=True, color=colour, alpha=0.22, label=label, zorder=1.5)
        axes.stairs(series.y, x, color=colour, linewidth=1.4)
        return
    if series.style == "bars":
        axes.barh(y, x, height=0.62, color=colour, alpha=0.8, label=label, zorder=2.0)
        return
    if series.style == "band":
        upper = np.asarray(series.upper_y, float)
        axes.fill_between(x, y, upper, color=colour, alpha=0.20, linewidth=0.0, label=label, zorder=1.5)
        axes.plot(x, y, color=colour, linewidth=0.5, alpha=0.6)
        axes.plot(x, upper, color=colour, linewidth=0.5, alpha=0.6)
        return
    if series.error_bars is not None:
        low, high = (np.asarray(ends, float) for ends in series.error_bars)
        axes.vlines(x, low, high, color=colour, linewidth=1.1, alpha=0.7, zorder=2.2)
    many = len(x) > 40
    axes.plot(
        x,
        y,
        label=label,
        color=colour,
        linestyle=DASHES[style_number % len(DASHES)] if series.style != "markers" else "none",
        linewidth=2.2 if series.bold else 1.2,
        marker=marker if series.style != "line" else "none",
        markersize=(3.0 if many and series.style == "markers" else 4.6) * (1.15 if series.bold else 1.0),
        markerfacecolor=colour if series.bold else "white",
        markeredgewidth=1.0,
        markevery=max(1, len(x) // 24) if many and series.style == "line+markers" else None,
        zorder=3.0 if series.bold else 2.5,
    )


def _make_axis_logarithmic(axes: Any, axis: Any, name: str, values: Any) -> None:
    """Make an axis logarithmic; ranges below two decades have labels at 1, 2 and 5, and long ranges at powers of ten.

    ``axes``: axes of matplotlib. ``axis``: its axis called ``name``, "x" or "y". ``values``: the positive data along this
    axis.
    """
    getattr(axes, f"set_{name}scale")("log", nonpositive="mask")
    low, high = float(np.min(values)), float(np.max(values))
    decades = math.log10(high / low)
    plain = low >= 1e-3 and high < 1e4
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)) if decades < 2.0 else LogLocator(numticks=8))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}" if plain else _power_of_ten_label(value)))
    axis.set_minor_formatter(NullFormatter())


def _power_of_ten_label(value: float) -> str:
    """Return a number as a label of the form ``5·10⁻³``, in plain characters that any font contains."""
    exponent = math.floor(math.log10(value) + 1e-9)
    mantissa = f"{value / 10.0**exponent:g}"
    power = "10" + str(exponent).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return power if mantissa == "1" else f"{mantissa}·{power}"


def _extend_ordinate_to_zero(axes: Any, y: Any) -> None:
    """Extend the range of the ordinate to zero; if there are values on both sides of zero, draw a line there instead.

    ``axes``: axes of matplotlib. ``y``: ordinates of all data in the panel.
    """
    finite = y[np.isfinite(y)]
    if finite.size and np.min(finite) < 0.0 < np.max(finite):
        axes.axhline(0.0, color=_FRAME, linewidth=0.9, zorder=1.2)
    elif finite.size and np.max(finite) <= 0.0:
        axes.set_ylim(min(axes.get_ylim()[0], 1.05 * np.min(finite, initial=0.0)), 0.0)
    else:
        axes.set_ylim(0.0, max(axes.get_ylim()[1], 1.05 * np.max(finite, initial=0.0)))


def _draw_legend_below(axes: Any, columns: int, lower: float = 0.0) -> int:
    """Draw the legend of a panel below its abscissa; return its number of rows, 0 without a legend.

    ``axes``: axes of matplotlib. ``columns``: largest number of columns of the legend. ``lower``: additional distance from
    the abscissa [inches].
    """
    handles, labels = axes.get_legend_handles_labels()
    if not labels or (len(labels) == 1 and labels[0] == axes.get_ylabel()):
        return 0
    columns = 1 if max(map(len, labels)) > 34 else min(columns, len(labels))
    down = 0.45 + lower + 0.14 * axes.get_xlabel().count("\n")
    axes.legend(
        handles,
        labels,
        loc="upper left",
        bbox_to_anchor=(-0.02, 0.0),
        bbox_transform=axes.transAxes + ScaledTranslation(0.0, -down, axes.figure.dpi_scale_trans),
        ncols=columns,
        handlelength=3.2,
        columnspacing=1.6,
        borderaxespad=0.0,
    )
    return math.ceil(len(labels) / columns)


def _number_identifiers(svg: str, name: str) -> str:
    """Return an SVG document whose identifiers are the figure's name and a number, without those that nothing refers to.

    ``svg``: document that matplotlib wrote. ``name``: name of the figure.
    """
    prefix = _prefix_of_identifiers(name)
    used = dict.fromkeys(re.findall(r'(?:href="#|url\(#)([^")]+)', svg))
    number = {old: f"{prefix}-{k}" for k, old in enumerate(used)}
    svg = re.sub(r' id="([^"]*)"', lambda match: f' id="{number[match[1]]}"' if match[1] in number else "", svg)
    return re.sub(r'(href="#|url\(#)([^")]+)', lambda match: match[1] + number[match[2]], svg)


def _prefix_of_identifiers(name: str) -> str:
    """Return the beginning of all identifiers in the SVG document of the figure ``name``."""
    return re.sub(r"[^A-Za-z0-9_-]", "-", f"fig-{name}")
