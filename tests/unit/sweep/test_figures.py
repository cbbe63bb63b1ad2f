"""Figures of a sweep: what stands on their axes."""

from rollbench.compare.sections.tolerances import short, stored
from rollbench.compare.studies.sweep.figures import figures, of_summary
from rollbench.compare.studies.sweep.keys import read_vary
from rollbench.reports.content import Figure, Panel, Series
from rollbench.reports.figures import draw, drawing

FOUND = stored()
KEYS = read_vary(FOUND["vary"])


def by_name(figures):
    return {figure.name.rpartition("-")[2]: figure for figure in figures}


def test_a_seed_has_no_axis_but_a_share_of_the_variance():
    figures = by_name(of_summary("x", KEYS, FOUND, short))
    orderly = {"ball grade", "pitch", "roundness", "misalignment"}
    assert {panel.title for panel in figures["effects"].panels} == orderly
    assert set(figures["worst"].panels[0].names) == orderly
    assert figures["indices"].panels[0].names == ["luck", "ball grade", "roundness", "misalignment", "pitch"]
    variances = FOUND["indices"]["outputs"]["largest_load_N"]
    assert figures["indices"].panels[0].series[1].y == sorted((row["total"] for row in variances.values()), reverse=True)
    worst, at = FOUND["worst"][0], [short(v) for v in KEYS].index("roundness")
    place = KEYS[at].number(worst["values"][at]) / KEYS[at].high  # its range begins at zero
    assert figures["worst"].panels[0].series[0].y[figures["worst"].panels[0].names.index("roundness")] == place


def test_a_sweep_of_seeds_alone_is_drawn_over_them():
    keys = read_vary(["errors.seed=1:100"])
    rows = [{"sample": n, "values": [1 + n], "largest_load_N": 1.0 + n, "at": "1 SL"} for n in range(4)]
    groups = [{"at": 1.0 + n, "mean": 1.0 + n, "standard_error": 0.1, "samples": 1} for n in range(4)]
    found = {"main_effects": {"errors.seed": groups}, "worst": rows, "indices": {}}
    assert [len(figure.panels) for figure in figures("x", keys, found, rows)] == [1, 1, 1]


def test_names_stand_on_the_axis_and_ordinates_are_of_one_scale():
    high = Panel("high", "", "y", (Series("a", [1.0, 2.0], [5.0, 90.0]),), names=("one way", "or another"))
    low = Panel("low", "", "y", (Series("a", [1.0, 2.0], [1.0, 2.0]),))
    figure = Figure("f", "f", (high, low), same_y=True)
    first, second = drawing(figure)[1].axes
    assert [text.get_text() for text in first.get_xticklabels()] == ["one way", "or another"]
    assert first.get_ylim() == second.get_ylim()
    assert drawing(Figure("f", "f", (high, low)))[1].axes[1].get_ylim()[1] < 3.0
    assert "or another" in draw(figure)
