"""Figures and their panels: labels, escapes, bytes, identifiers, what is refused."""

import math
import re
from dataclasses import replace
from xml.etree import ElementTree

import pytest
from tests.report_samples import figure

from rollbench.compare.scenes import catalogue
from rollbench.compare.sections.sketches import sketch_scene
from rollbench.reports import figures, pages
from rollbench.reports.content import Panel, Series
from rollbench.reports.sketch import FORCE, draw_sketch

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
