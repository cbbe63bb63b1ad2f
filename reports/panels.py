"""A figure for a page: its panels one by one, with values for who points at them, in colours that the page sets."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any
from xml.etree import ElementTree

import numpy as np

from rollbench.reports.cells import micro
from rollbench.reports.content import Figure, Panel, Series
from rollbench.reports.figures import PALETTE, drawing

_SVG, _LINK = "http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink"
#: Colours of a drawing that a page may set, by the name of its variable.
THEME = {"#222222": "ink", "#8a8f98": "frame", "#dfe2e6": "grid", "#ffffff": "paper", "white": "paper"}
THEME |= {colour.lower(): f"c{number}" for number, colour in enumerate(PALETTE)}
#: Points of a curve that answer a pointer, at most.
MOST = 40
#: Room around a panel [points].
ROOM = 4.0


@dataclass(frozen=True)
class Drawing:
    """A figure's whole SVG document, and what a page shows of it: an SVG element for each panel, and for a legend that
    serves all of them (empty where there is none)."""

    whole: str
    panels: tuple[str, ...]
    legend: str


def draw_parts(figure: Figure) -> Drawing:
    """Draw a figure once, and take its panels apart. Raises ValueError as `reports.figures.draw`."""
    whole, canvas = drawing(figure)
    ElementTree.register_namespace("", _SVG)
    ElementTree.register_namespace("xlink", _LINK)
    root = ElementTree.fromstring(whole)
    groups = {g.get("id", ""): g for g in root.iter(f"{{{_SVG}}}g")}
    defs = [d for d in root if d.tag == f"{{{_SVG}}}defs"]
    prefix = re.sub(r"[^A-Za-z0-9_-]", "-", f"fig-{figure.name}-")
    canvas.set_dpi(72.0)  # a pixel of the drawing is a point of the document
    height = float(canvas.bbox.height)
    panels = []
    for number, (axes, panel) in enumerate(zip(canvas.axes, figure.panels, strict=True), start=1):
        box = axes.get_tightbbox()
        values = "".join(_values(axes, panel, height))
        panels.append(_element(groups[f"{prefix}axes_{number}"], defs, _view(box, height), panel.title, values))
        defs = []  # once in a page is enough
    legend = ""
    if canvas.legends:
        box = canvas.legends[0].get_tightbbox()
        legend = _element(groups[f"{prefix}legend_1"], [], _view(box, height), "legend", "")
    return Drawing(whole, tuple(panels), legend)


def themed(svg: str) -> str:
    """An SVG element whose ink, paper and curves take the colours of the page."""
    return re.sub(
        r"(#[0-9a-fA-F]{6}\b|(?<=fill: )white\b)",
        lambda found: f"var(--{THEME[found[1].lower()]}, {found[1]})" if found[1].lower() in THEME else found[1],
        svg,
    )


def _view(box: Any, height: float) -> tuple[float, float, float, float]:
    """Left, top, width and height [points] of a box of the drawing, with some room."""
    return box.x0 - ROOM, height - box.y1 - ROOM, box.width + 2.0 * ROOM, box.height + 2.0 * ROOM


def _element(group: Any, defs: Sequence[Any], view: tuple[float, ...], title: str, values: str) -> str:
    """One SVG element of a page."""
    inner = "".join(ElementTree.tostring(e, encoding="unicode") for e in (*defs, group))
    inner = re.sub(r' xmlns(:\w+)?="[^"]+"', "", inner).replace("xlink:href", "href")
    inner = re.sub(r"<[^>]*>", lambda tag: re.sub(r"(\.\d\d)\d+", r"\1", tag[0]), re.sub(r"\s*\n\s*", "\n", inner))
    box = " ".join(f"{v:.1f}" for v in view)
    size = f'width="{view[2] / 0.75:.0f}" height="{view[3] / 0.75:.0f}"'
    head = f'<svg xmlns="{_SVG}" viewBox="{box}" {size} role="img" aria-label="{escape(title)}">'
    return f"{head}{themed(inner)}{values}</svg>"


def _values(axes: Any, panel: Panel, height: float) -> Iterator[str]:
    """Unseen circles over the points of the curves, each with curve, abscissa and ordinate as the lines of its title."""
    box = axes.get_window_extent()
    names = f'data-x="{escape(micro(panel.xlabel))}" data-y="{escape(micro(panel.ylabel))}"'
    yield f'<g class="values" fill="transparent" {names}>'
    for series in panel.series:
        x, y = np.asarray(series.x, float), np.asarray(series.y, float)
        for k in _some(len(x), series):
            if not (np.isfinite(x[k]) and np.isfinite(y[k])):
                continue
            with np.errstate(all="ignore"):
                at = axes.transData.transform((x[k], y[k]))
            if not (box.x0 - 1.0 <= at[0] <= box.x1 + 1.0 and box.y0 - 1.0 <= at[1] <= box.y1 + 1.0):
                continue
            text = f"{_name(series, int(k))}\n{x[k]:.4g}\n{y[k]:.4g}{_bars(series, int(k))}"
            place = f'cx="{at[0]:.1f}" cy="{height - at[1]:.1f}"'
            yield f'<circle {place} r="4"><title>{escape(micro(text))}</title></circle>'
    yield "</g>"


def _some(count: int, series: Series) -> Any:
    """Numbers of the points that answer: all of a curve of single points, else some, evenly."""
    if series.style == "markers" or count <= MOST:
        return np.arange(count)
    return np.unique(np.linspace(0, count - 1, MOST).round().astype(int))


def _name(series: Series, k: int) -> str:
    return series.names[k] if series.names else series.label


def _bars(series: Series, k: int) -> str:
    if series.bars is not None:
        return f" ({series.bars[0][k]:.3g} to {series.bars[1][k]:.3g})"
    return f" to {series.y2[k]:.4g}" if series.y2 is not None else ""
