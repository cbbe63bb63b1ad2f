"""Figures of a sweep: what stands on their axes."""

from rollbench.reports.content import Figure, Panel, Series
from rollbench.reports.figures import draw_figure, draw_figure_and_canvas


def test_names_stand_on_the_axis_and_ordinates_are_of_one_scale():
    high = Panel("high", "", "y", (Series("a", [1.0, 2.0], [5.0, 90.0]),), abscissa_names=("one way", "or another"))
    low = Panel("low", "", "y", (Series("a", [1.0, 2.0], [1.0, 2.0]),))
    figure = Figure("f", "f", (high, low), same_y=True)
    first, second = draw_figure_and_canvas(figure)[1].axes
    assert [text.get_text() for text in first.get_xticklabels()] == ["one way", "or another"]
    assert first.get_ylim() == second.get_ylim()
    assert draw_figure_and_canvas(Figure("f", "f", (high, low)))[1].axes[1].get_ylim()[1] < 3.0
    assert "or another" in draw_figure(figure)
