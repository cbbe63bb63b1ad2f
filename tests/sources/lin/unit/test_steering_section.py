"""Section of the report on lash and steering gear: what it says of the open inputs holds, figures can be drawn."""

import numpy as np
import pytest

from rollbench.compare.cases.lin.evidence import steering as evidence_steering
from rollbench.compare.cases.lin.evidence import steering as gear
from rollbench.compare.cases.lin.pages import steering
from rollbench.compare.scenes import catalogue
from rollbench.reports.content import Table
from rollbench.reports.figures import draw_figure

SCENE = catalogue.scene("lin-nominal-4p1")


@pytest.fixture(scope="module")
def points():
    return list(gear.load_ratios_of_all_layouts(evidence_steering.shipped_steering_gear()))


def test_ratios_span_the_printed_ones_so_that_they_identify_no_layout(points):
    for key, printed in (("screw", 3.32), ("bearing", 1.47)):
        values = np.array([getattr(p, key) for p in points])
        assert values.min() < 0.97 * printed
        assert values.max() > 1.3 * printed
        layouts = {
            (p.pinion_restraint, p.side_forces_opposed)
            for p, v in zip(points, values, strict=True)
            if abs(v / printed - 1.0) < 0.08
        }
        assert len(layouts) >= 2


def test_layouts_are_what_they_say():
    shipped = evidence_steering.shipped_steering_gear()
    (pinion,) = shipped.supports
    same = gear.change_gear_layout(shipped, pinion.at, "held but along the rack", 0.0)
    assert evidence_steering.load_ratios_at_18_degrees(same) == pytest.approx(
        evidence_steering.load_ratios_at_18_degrees(shipped), rel=1e-12
    )
    moved = gear.change_gear_layout(shipped, 0.5, "pinned across", 0.02)
    assert moved.sets[0] == shipped.sets[0]
    assert moved.sets[1].position == pytest.approx(shipped.sets[1].position + 0.02)
    assert moved.sets[1].parts.nut.position == moved.sets[1].position
    assert evidence_steering.solve_gear_at_tie_rod_angle(shipped, 0.0, side_forces_opposed=True).sets[
        0
    ].force == pytest.approx(evidence_steering.solve_gear_at_tie_rod_angle(shipped, 0.0).sets[0].force)
    held = gear.change_gear_layout(shipped, 0.55, "held but along the rack", 0.0)
    assert evidence_steering.load_ratios_at_18_degrees(held, side_forces_opposed=True) == pytest.approx(
        evidence_steering.load_ratios_at_18_degrees(held), rel=1e-9
    )


def test_bands_of_the_ratios_hold_the_shipped_ones_and_say_what_lies_in_them(points):
    shipped, bands = (
        evidence_steering.load_ratios_at_18_degrees(evidence_steering.shipped_steering_gear()),
        gear.load_ratio_ranges(evidence_steering.shipped_steering_gear()),
    )
    assert len(bands) >= 8
    for b in bands:
        for (low, high), value in zip((b.screw, b.bearing), shipped, strict=True):
            assert low - 1e-9 <= value <= high + 1e-9
        assert b.screw[1] > b.screw[0]
    rows = [{getattr(k, "key", k): v for k, v in row.items()} for row in steering.load_ratio_range_rows(points)]
    for row in rows:
        for key, printed in (("screw", 3.32), ("bearing", 1.47)):
            assert row[f"{key}_in"] == ("yes" if row[f"{key}_low"] <= printed <= row[f"{key}_high"] else "no")
    assert [rows[-1][f"{key}_in"] for key in ("screw", "bearing")] == ["yes", "yes"]
    assert {row["bearing_in"] for row in rows[:-1]} == {"no"}


def test_lash_tests_are_load_curves_of_the_screw():
    """A screw without play or preload: no lash, and more displacement under more load; a direction is its opposite."""
    screw = gear.arrange_balls_in_pattern(SCENE, "half-half")
    test = gear.solve_axial_lash_test(screw, "-200N:200N:3")
    moved = [p.displacement for p in test.points]
    assert (test.lash, gear.peak_to_peak_displacement(test)) == (0.0, moved[2] - moved[0])
    assert moved == sorted(moved)
    there, back = (
        gear.peak_to_peak_displacement(gear.solve_conical_lash_test(screw, angle, evidence_steering.REACH))
        for angle in (0.3, 0.3 + np.pi)
    )
    assert back == pytest.approx(there, rel=1e-6)


def test_figures_and_tables_are_whole(points):
    figure = steering.steering_gear_figure(points)
    assert [len(p.series) for p in figure.panels[:2]] == [4, 4]
    assert draw_figure(figure).startswith("<?xml")
    rows = steering.load_ratio_rows(points)
    assert len(rows) == len(gear.PINIONS) * len(gear.OFFSETS) * 3
    assert len(Table.from_rows("ratios", "", rows).columns) == 6
