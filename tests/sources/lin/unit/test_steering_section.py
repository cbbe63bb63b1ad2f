"""Section of the report on lash and steering gear: what it says of the open inputs holds, figures can be drawn."""

import numpy as np
import pytest
from tests.section_items import drawn

from rollbench.compare.cases.lin.evidence import steering as gear
from rollbench.compare.cases.lin.pages import steering
from rollbench.compare.scenes import catalogue

pytestmark = pytest.mark.xdist_group("steering gear")
SHIPPED = gear.shipped_steering_gear()
PRINTED = (("screw", 3.32), ("bearing", 1.47))


@pytest.fixture(scope="module")
def points():
    return gear.load_ratio_rows(SHIPPED)


def test_ratios_span_the_printed_ones_so_that_they_identify_no_layout(points):
    for key, printed in PRINTED:
        values = np.array([row["load_ratio_18_deg", gear.PARTS[key]] for row in points])
        assert values.min() < 0.97 * printed
        assert values.max() > 1.3 * printed
        near = [row for row, value in zip(points, values, strict=True) if abs(value / printed - 1.0) < 0.08]
        assert len({(row["pinion_restraint"], row["lateral_force_directions"]) for row in near}) >= 2


def test_layouts_are_what_they_say():
    ratios, (pinion,) = gear.load_ratios_at_18_degrees, SHIPPED.supports
    same = gear.change_gear_layout(SHIPPED, pinion.at, "held but along the rack", 0.0)
    assert ratios(same) == pytest.approx(ratios(SHIPPED), rel=1e-12)
    moved = gear.change_gear_layout(SHIPPED, 0.5, "pinned across", 0.02)
    assert moved.sets[0] == SHIPPED.sets[0]
    assert moved.sets[1].position == pytest.approx(SHIPPED.sets[1].position + 0.02)
    assert moved.sets[1].parts.nut.position == moved.sets[1].position
    straight = (gear.solve_gear_at_tie_rod_angle(SHIPPED, 0.0, side_forces_opposed=way) for way in (True, False))
    opposed, alike = (found.sets[0].force for found in straight)
    assert opposed == pytest.approx(alike)
    held = gear.change_gear_layout(SHIPPED, 0.55, "held but along the rack", 0.0)
    assert ratios(held, side_forces_opposed=True) == pytest.approx(ratios(held), rel=1e-9)


def test_lash_tests_are_load_curves_of_the_screw():
    """A screw without play or preload: no lash, and more displacement under more load; a direction is its opposite."""
    screw = catalogue.scene("lin-lash-half-half")
    test = gear.solve_axial_lash_test(screw, "-200N:200N:3")
    moved = [p.displacement for p in test.points]
    assert (test.lash, gear.peak_to_peak_displacement(test)) == (0.0, moved[2] - moved[0])
    assert moved == sorted(moved)
    tests = (gear.solve_conical_lash_test(screw, angle, gear.REACH) for angle in (0.3, 0.3 + np.pi))
    there, back = map(gear.peak_to_peak_displacement, tests)
    assert back == pytest.approx(there, rel=1e-6)


def test_figures_and_tables_are_whole(points):
    drawn([steering.steering_gear_figure(points)])
    assert len(points) == len(gear.PINIONS) * len(gear.OFFSETS) * 3
