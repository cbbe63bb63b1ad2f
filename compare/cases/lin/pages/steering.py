"""Report section on Lin 4.2: lash tests of a ball screw, loads of a steering gear, influence of unprinted inputs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from rollbench.compare.cases.lin.evidence import steering
from rollbench.compare.cases.lin.evidence.steering import RACK, REACH, SCREW, shipped_steering_gear
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.printed import printed_value
from rollbench.compare.results.load_curve import LoadCurve
from rollbench.meshes.parts import Scene
from rollbench.reports.content import Figure, Panel, Row, Section, Series, Table, Text

ABOUT = (
    "Lash: displacement of the screw under a force that reverses. Axial test: force along the axis at the end of the "
    "screw; conical test: lateral force at a distance from the nut. Difference of the ball patterns: (largest - "
    "smallest)/smallest of their peak-to-peak displacements at 200 N; Lin does not define it.",
    "For every choice of the unprinted inputs, the difference is smaller in the axial test than in the conical test "
    "for most directions of the lateral force, and always smaller than the largest of the conical test. Other distances "
    "of the force and other restraints change the differences by more than they deviate from the printed ones.",
    "Steering gear: the load ratios depend on place and restraint of the pinion, on the directions of the two lateral "
    "forces and on the place of the bearing. Several layouts come near one or both printed ratios, so that Lin's layout "
    "cannot be identified from these ratios.",
)
#: Note of the table of steering-gear layouts.
SENSE = (
    "A pinion that holds the rack against tilting keeps the lateral force on its other side away from the nut: the "
    "direction of this force then has no influence."
)


def lash_figure(scene: Scene) -> Figure:
    """Draw displacement over load in both lash tests for four ball patterns, and lash over the direction of the force.

    ``scene``: the ball screw.
    """
    around, course = np.linspace(0.0, 180.0, 13), "-200N:200N:17"
    degrees = [float(d) for d in around]
    axial, conical, peaks = [], [], []
    for pattern in steering.PATTERNS:
        screw = steering.arrange_balls_in_pattern(scene, pattern)
        axial.append(_lash_displacement_curve(pattern, steering.solve_axial_lash_test(screw, course)))
        conical.append(_lash_displacement_curve(pattern, steering.solve_conical_lash_test(screw, 0.0, REACH, course)))
        tests = (steering.solve_conical_lash_test(screw, float(np.radians(d)), REACH) for d in degrees)
        displaced = [steering.peak_to_peak_displacement(test) for test in tests]
        peaks.append(Series(pattern, degrees, [1e6 * x for x in displaced], "line"))
    spread = [steering.relative_range_percent([s.y[k] for s in peaks]) for k in range(len(degrees))]
    flat = steering.relative_range_percent([s.y[-1] - s.y[0] for s in axial])
    shown = (Series("conical", degrees, spread, "line"), Series("axial", degrees, [flat] * len(degrees), "line"))
    at = f"{1e3 * REACH:.0f} mm from the nut"
    panels = (
        Panel("axial test", "axial force / N", "displacement", axial),
        Panel("conical test, force along x", f"lateral force {at} / N", "displacement", conical),
        Panel("conical test: lash", "force_direction", "peak-to-peak displacement / µm", peaks, include_zero=True),
        Panel(
            "relative difference of the lash between ball patterns",
            "force_direction",
            "difference / %",
            shown,
            include_zero=True,
        ),
    )
    return Figure("lash", "Lash of a ball screw with its balls arranged in four patterns (Lin 4.2)", panels, ABOUT[0])


def _lash_displacement_curve(name: str, lash_test: LoadCurve) -> Series:
    """Return the curve of displacement [um] over load [N] of a lash test; ``name``: legend; ``lash_test``: load curve."""
    known = [(p.load, 1e6 * p.displacement) for p in lash_test.points if p.displacement is not None]
    return Series(name, [f for f, _ in known], [u for _, u in known], "line")


def lash_difference_rows(scene: Scene) -> list[Row]:
    """Return table rows of the lash differences between ball patterns, one input changed at a time that Lin does not print.

    ``scene``: the ball screw with the usual inputs.
    """
    return [
        {
            "varied_input": p.changed_input,
            "screw_diameter": 1e3 * p.screw_outer_diameter,
            "nut_position": 1e3 * p.nut_position,
            "lateral_force_distance": 1e3 * p.force_distance,
            "left_end_restraint": p.left_end_restraint,
            "axial_lash_difference": p.differences.axial_percent,
            "smallest_conical_lash_difference": min(p.differences.conical_percent),
            "largest_conical_lash_difference": max(p.differences.conical_percent),
            "directions_with_smaller_axial": _directions_with_smaller_axial_difference(p.differences),
        }
        for p in steering.lash_differences_by_changed_input(scene)
    ]


def _directions_with_smaller_axial_difference(found: steering.RelativeLashDifferences) -> str:
    """Return in words for how many directions of the lateral force the axial test's difference is the smaller one.

    ``found``: differences of the lash between ball patterns, by the axial test and by the conical test (lateral force).
    """
    count = sum(found.axial_percent < x for x in found.conical_percent)
    return f"{count} of {len(found.conical_percent)} directions"


def steering_gear_figure(layout_ratios: list[steering.GearLayoutLoadRatios]) -> Figure:
    """Draw load ratios of the steering gear over the pinion's position, and largest contact loads over the tie-rod angle.

    A load ratio is the largest contact load at a tie-rod angle of 18 deg over that at 0 deg. ``layout_ratios``: load ratios
    of all layouts.
    """
    gear = shipped_steering_gear()
    panels = []
    for key, words in (("screw", "ball screw"), ("bearing", "four-point bearing")):
        printed = printed_value("lin-4.2.1", f"ratio_{key}")
        stations = [1e3 * z for z in steering.PINIONS]
        series = [Series("printed", stations, [printed] * len(stations), "line", bold=True)]
        for (hold, opposed), layout in _group_ratios_by_layout(layout_ratios).items():
            label = hold + (", side forces opposed" if opposed else "")
            series.append(Series(label, stations, [getattr(p, key) for p in layout], "line"))
        x, y = "position of the pinion / mm", "load at 18 deg over that at 0 deg"
        panels.append(Panel(f"load ratio of the {words}", x, y, series, include_zero=True))
    loads = steering.largest_loads_over_tie_rod_angles(gear)
    for k, words in enumerate(("ball screw", "four-point bearing")):
        curve = Series("usual inputs", steering.ANGLES, [pair[k] for pair in loads])
        title, x = f"largest contact load of the {words}", "tie-rod angle / deg"
        panels.append(Panel(title, x, "contact_load", (curve,), include_zero=True))
    caption = (
        "Load ratio: largest contact load at a tie-rod angle of 18° divided by that at 0°. The four-point bearing is "
        "placed at the nut's centre."
    )
    title = "Steering gear (Lin 4.2): largest contact loads, plotted against pinion position and tie-rod angle"
    return Figure("rack", title, panels, caption)


def _group_ratios_by_layout(
    layout_ratios: list[steering.GearLayoutLoadRatios],
) -> dict[tuple[str, bool], list[steering.GearLayoutLoadRatios]]:
    """Group the steering gear's load ratios by restraint of the pinion and direction of the tie rods' lateral forces.

    The keys are pairs: restraint of the pinion; whether the lateral forces of both tie rods have opposite directions.
    ``layout_ratios``: load ratios of all layouts; only those with the bearing at the nut's centre are grouped.
    """
    out: dict[tuple[str, bool], list[steering.GearLayoutLoadRatios]] = {}
    for p in layout_ratios:
        if p.bearing_offset == 0.0:
            out.setdefault((p.pinion_restraint, p.side_forces_opposed), []).append(p)
    return out


def load_ratio_rows(layout_ratios: list[steering.GearLayoutLoadRatios]) -> list[Row]:
    """Return the table rows of the steering gear's load ratios, one for each layout in ``layout_ratios``.

    A load ratio is the largest contact load at a tie-rod angle of 18 deg over that at 0 deg.
    """
    return [
        {
            "pinion_restraint": p.pinion_restraint,
            "lateral_force_directions": "opposed" if p.side_forces_opposed else "alike",
            "bearing_distance": 1e3 * p.bearing_offset,
            "pinion_position": 1e3 * p.pinion_position,
            ("load_ratio_18_deg", "ball screw"): p.screw,
            ("load_ratio_18_deg", "bearing"): p.bearing,
        }
        for p in layout_ratios
    ]


def load_ratio_range_rows(layout_ratios: list[steering.GearLayoutLoadRatios]) -> list[Row]:
    """Return the table rows of the ranges of the steering gear's load ratios, one for each input that Lin does not print.

    A load ratio is the largest contact load at a tie-rod angle of 18 deg over that at 0 deg. ``layout_ratios``: load ratios
    of all layouts; the last row has their range.
    """
    rows = []
    for b in (*steering.load_ratio_ranges(shipped_steering_gear()), steering.load_ratio_range_over_layouts(layout_ratios)):
        row: Row = {"varied_input": b.changed_input, "input_range": b.input_range}
        for key, words in (("screw", "ball screw"), ("bearing", "bearing")):
            (low, high), printed = getattr(b, key), printed_value("lin-4.2.1", f"ratio_{key}")
            inside = steering.rounded_value_lies_in_range((low, high), printed)
            row |= {
                ("smallest_load_ratio_18_deg", words): low,
                ("largest_load_ratio_18_deg", words): high,
                ("contains_printed_load_ratio", f"{printed:g}", words): "yes" if inside else "no",
            }
        rows.append(row)
    return rows


def make_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the report's section on the lash tests and the steering gear of section 4.2 of Lin's thesis.

    ``cache``: gives the scenes included with rollbench; ``step``: function that receives a message before each step.
    """
    step("lash tests")
    scene = cache.built_in_scene(SCREW)
    cache.record_used_scenes((RACK, *steering.PATTERNS.values()))
    figures = [lash_figure(scene)]
    lash = lash_difference_rows(scene)
    step("steering gear")
    points = list(steering.load_ratios_of_all_layouts(shipped_steering_gear()))
    figures.append(steering_gear_figure(points))
    return Section(
        "steering",
        "Lin 4.2: lash tests of a ball screw, contact loads of a steering gear",
        (
            Text(ABOUT, bullets=True),
            figures[0],
            Table.from_rows(
                "lash-inputs",
                "Difference of lash between ball patterns (Lin 4.2), with one unprinted input changed at a time",
                lash,
            ),
            figures[1],
            Table.from_rows(
                "rack-bands",
                "Steering gear (Lin 4.2): range of the load ratio (largest load at 18° over that at 0°) by unprinted input",
                load_ratio_range_rows(points),
            ),
            Table.from_rows(
                "rack-layouts",
                "Steering gear (Lin 4.2): load ratio (largest load at 18° over that at 0°) for each layout",
                load_ratio_rows(points),
                SENSE,
            ),
        ),
    )
