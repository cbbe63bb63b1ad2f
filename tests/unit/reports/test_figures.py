"""Figures and their panels: labels, escapes, bytes, identifiers, what is refused."""

import math
import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from tests.report_samples import figure

from rollbench.compare.scenes import catalogue
from rollbench.compare.sections.sketches import sketch_scene
from rollbench.reports import figures, pages
from rollbench.reports.content import Panel, PressureMap, PressurePanel, Series, Sketch
from rollbench.reports.sketch import FORCE, INK, WIDTH, draw_sketch

pytestmark = pytest.mark.xdist_group("a figure")

SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def svg():
    return figures.draw_figure(figure())


def words_of(svg):
    return {"".join(element.itertext()) for element in ElementTree.fromstring(svg).iter(f"{SVG}text")}


def ids_and_references(text):
    """Identifiers of a text, and those that it refers to."""
    return set(re.findall(r'\bid="([^"]+)"', text)), set(re.findall(r'(?:href="#|url\(#)([^")]+)', text))


REFUSED = [
    (Series("s", [1], [1], "dots"), "", r"styles \['dots'\]"),
    (Series("s", [1], [1]), "z", "log .z."),
    (Series("s", [1.0, 2.0], [1.0, 2.0], "markers", error_bars=([0.5], [1.5])), "", "error bars"),
]


class TestFigures:
    def test_same_data_same_bytes_without_date_and_version_and_other_data_others(self, svg):
        assert figures.draw_figure(figure()) == svg
        assert not re.search(r"dc:date|matplotlib\.org", svg)
        other = Panel("Case <1>", "ball number", "normal force [N]", [Series("computed", [1, 2], [1.0, 5.0])])
        assert figures.draw_figure(figure(panels=[other])) != svg

    def test_is_well_formed_and_shows_labels_escapes_and_the_letter_of_micrometres(self, svg):
        assert {"Case <1>", "normal force [N]", "computed", "printed", "source", "95 % band", "10⁻³"} <= words_of(svg)
        panel = Panel("", "oversize / um", "rigidity / (N/um)", [Series("a sum", [1, 2], [1.0, 5.0])])
        words = words_of(figures.draw_figure(figure(panels=[panel])))
        assert {"oversize / µm", "rigidity / (N/µm)"} <= words
        assert not any(re.search(r"\bum\b", word) for word in words)

    def test_a_notebook_shows_it_without_a_back_end_and_with_any_number_of_panels(self):
        drawn = [Series("", [1, 2], [4.0, 5.0])]
        panels = [Panel(f"panel {k}", "x", "y", drawn, include_zero=True) for k in range(7)]
        panels.append(
            Panel("band", "x", "y", [Series("", [1, 2], [4.0, 5.0], "band", upper_y=[6.0, 7.0])], include_zero=True)
        )
        canvas = figures.draw_figure_and_canvas(figure(panels=panels))[1]
        assert canvas._repr_svg_().count('id="axes_') == 8
        bottom, top = canvas.axes[0].get_ylim()
        assert (bottom, top > 5.2) == (0.0, True), "a point at the top is whole"
        assert canvas.axes[-1].get_ylim()[1] >= 7.0, "a band is whole"

    def test_identifiers_of_two_figures_do_not_meet_and_references_resolve(self, svg):
        ids, used = ids_and_references(svg)
        assert not ids & ids_and_references(figures.draw_figure(figure("other")))[0]
        assert used
        assert used <= ids

    @pytest.mark.parametrize("log", ["", "x", "y", "xy"])
    @pytest.mark.parametrize("values", [[], [math.nan, math.nan], [0.0, 0.0], [-1.0, -2.0], [3.0, 3.0]])
    def test_poor_data_are_drawn_without_warning(self, log, values):
        x = [float(number) for number in range(len(values))]
        panel = Panel("t", "x", "y", [Series("s", x, values)], log_axes=log, include_zero=True)
        ElementTree.fromstring(figures.draw_figure(figure(panels=[panel])))

    @pytest.mark.parametrize(("series", "log", "words"), REFUSED)
    def test_refuses_unknown_styles_and_scales_and_bars_of_another_length(self, series, log, words):
        with pytest.raises(ValueError, match=words):
            figures.draw_figure(figure(panels=[Panel("t", "x", "y", [series], log_axes=log)]))


class TestInAPage:
    def test_colours_are_the_page_s_to_set_and_references_resolve(self, svg):
        text = pages.svg_as_html_element(svg)
        colours = {"var(--ink, #222222)", "var(--paper, #ffffff)", "var(--c0, #0072b2)"}
        assert colours <= set(re.findall(r"var\([^)]*\)", text))
        assert "var(" not in svg
        ids, used = ids_and_references(text)
        assert used <= ids

    def test_texts_stand_beside_their_points_and_apart(self):
        x, y = [1.0, 1.1, 1.2, 90.0], [5.0, 5.01, 5.02, 0.1]
        named = Series("s", x, y, "markers", point_labels=["one", "two", "three", "far"], pale=False)
        panel = Panel("", "x", "y", [named], log_axes="xy")
        svg, canvas = figures.draw_figure_and_canvas(figure(panels=[panel], size=(5.0, 3.0)))
        root = ElementTree.fromstring(svg)
        found = {"".join(t.itertext()): t for t in root.iter(f"{SVG}text")}
        heights = sorted(_place(found[name])[1] for name in ("one", "two", "three"))
        assert min(np.diff(heights)) > 9.0
        canvas.set_dpi(72.0)  # a pixel of the canvas is a point of the document
        points = canvas.axes[0].transData.transform(list(zip(x, y, strict=True)))[:, 0]
        assert _place(found["one"])[0] < min(points)
        assert _place(found["far"])[0] > max(points)


def _place(text):
    """Where an SVG text stands."""
    if text.get("x"):
        return float(text.get("x")), float(text.get("y"))
    return tuple(float(v) for v in re.search(r"translate\(([-\d.]+)[ ,]+([-\d.]+)", text.get("transform"))[1:])


SVG = "{http://www.w3.org/2000/svg}"


def drawn(name: str) -> tuple[Sketch, ElementTree.Element]:
    sketch = sketch_scene(catalogue.scene(name), "s", "S")
    return sketch, ElementTree.fromstring(draw_sketch(sketch))


def test_a_screw_shows_nut_balls_support_and_load_with_their_words() -> None:
    sketch, root = drawn("lin-case3-offset")
    assert len(list(root.iter(f"{SVG}circle"))) == 32
    words = {"nut 54 mm, Ø 48", "screw 800 mm, Ø 32", "fixes ux uy rx ry rz", "fixes uy", "ux = 300 µm", "Fz 5 kN"}
    assert words < {str(t.text) for t in root.iter(f"{SVG}text")}
    assert re.search(r"lead 20 mm.*ball radii \+7 um", sketch.caption)


def test_arrows_point_where_loads_push() -> None:
    scene = catalogue.scene("lin-case1")
    heads = []
    for force in ((0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)):
        other = replace(scene, loads=(replace(scene.loads[0], force=force),))
        root = ElementTree.fromstring(draw_sketch(sketch_scene(other, "s", "S")))
        (head,) = (p.get("points", "") for p in root.iter(f"{SVG}polygon") if p.get("fill") == FORCE)
        (x, y), (x1, y1), (x2, y2) = (tuple(map(float, point.split(","))) for point in head.split())
        heads.append((x - (x1 + x2) / 2, y - (y1 + y2) / 2))
    assert heads == [pytest.approx(v, abs=0.11) for v in ((9.0, 0.0), (-9.0, 0.0), (0.0, -9.0), (0.0, 9.0))]


def test_nothing_leaves_the_drawing_and_inks_follow_the_page() -> None:
    for name in ("lin-case3-offset", "unseen-four-point", "unseen-63x20"):
        _, root = drawn(name)
        for text in root.iter(f"{SVG}text"):
            assert 0.0 < float(text.get("x", "")) < WIDTH
            assert text.get("fill") in (INK, FORCE)


def test_panels_on_a_phone_keep_their_height_above_one_legend_of_all():
    """Eight of nine labels stand in both panels: under each panel, their legends would leave no height to the curves."""
    panels = [
        Panel(f"panel {k}", "x", "y", [Series(f"model {n}", [1, 2], [n, k]) for n in range(k, 8 + k)]) for k in (0, 1)
    ]
    _, canvas = figures.draw_figure_and_canvas(figures.phone_figure(replace(figure(), panels=panels)))
    (legend,) = canvas.legends
    assert [text.get_text() for text in legend.get_texts()] == [f"model {n}" for n in range(9)]
    assert [axes.get_legend() for axes in canvas.axes] == [None, None]
    assert all(axes.get_position().height * canvas.get_size_inches()[1] > 1.5 for axes in canvas.axes)


def test_a_long_text_above_a_pressure_map_leaves_the_panel_its_width():
    """Counted in the layout, it took the width of the panel, and all of it on a phone."""
    x, y = (0.1 * axis.ravel() for axis in np.meshgrid(np.arange(-7.0, 8.0), np.arange(-3.0, 4.0)))
    text = "366.3 N; largest 3029 MPa, peak pressure by Hertz 3000 MPa"
    panel = PressurePanel("ball 32, SL", x, y, 3e3 - x**2, (0.0, 0.0, 0.5, 0.1), text)
    svg = figures.draw_pressure_map(PressureMap("p", "P", [panel] * 2, "x", "y", "p / MPa", columns=1, width=3.75))
    root = ElementTree.fromstring(svg)
    width = max(float(image.get("width")) for image in root.iter(f"{SVG}image"))
    assert width > 0.45 * float(root.get("width").removesuffix("pt"))
    assert "366.3 N; largest 3029 MPa, peak" in words_of(svg)
