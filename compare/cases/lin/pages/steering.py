"""Report section on Lin 4.2: lash tests of a ball screw, loads of a steering gear, influence of unprinted inputs."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from rollbench.compare.cases.lin.evidence import steering
from rollbench.compare.cases.lin.evidence.steering import RACK, REACH, SCREW, shipped_steering_gear
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.printed import printed_value
from rollbench.compare.results.load_curve import LoadCurve
from rollbench.meshes.parts import Scene
from rollbench.reports.content import Cell, Figure, Panel, Row, Section, Series, Table, Text

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


def steering_gear_figure(layout_ratios: Sequence[Row]) -> Figure:
    """Draw load ratios of the steering gear over the pinion's position, and largest contact loads over the tie-rod angle.

    A load ratio is the largest contact load at a tie-rod angle of 18 deg over that at 0 deg. ``layout_ratios``: table rows
    of the load ratios of all layouts; those with the bearing at the nut's centre are drawn.
    """
    gear = shipped_steering_gear()
    panels = []
    centred = [row for row in layout_ratios if row["bearing_distance"] == 0.0]
    for (key, part), words in zip(steering.PARTS.items(), ("ball screw", "four-point bearing"), strict=True):
        printed = printed_value("lin-4.2.1", f"ratio_{key}")
        stations = [1e3 * z for z in steering.PINIONS]
        series = [Series("printed", stations, [printed] * len(stations), "line", bold=True)]
        layouts: dict[tuple[Cell, Cell], list[float]] = {}
        for row in centred:
            layout = row["pinion_restraint"], row["lateral_force_directions"]
            layouts.setdefault(layout, []).append(float(row["load_ratio_18_deg", part] or 0.0))
        for (hold, directions), ratios in layouts.items():
            label = f"{hold}{', side forces opposed' if directions == 'opposed' else ''}"
            series.append(Series(label, stations, ratios, "line"))
        x, y = "position of the pinion / mm", "load at 18 deg over that at 0 deg"
        panels.append(Panel(f"load ratio of the {words}", x, y, series, include_zero=True))
    results = [steering.solve_gear_at_tie_rod_angle(gear, angle) for angle in steering.ANGLES]
    loads = [steering.largest_screw_and_bearing_loads(result) for result in results]
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


def load_ratio_range_rows(layout_ratios: Sequence[Row]) -> Iterator[Row]:
    """Yield the table rows of the ranges of the steering gear's load ratios, one for each input that Lin does not print.

    A load ratio is the largest contact load at a tie-rod angle of 18 deg over that at 0 deg. ``layout_ratios``: table rows
    of the load ratios of all layouts; the last row has their range.
    """
    every = [[float(row["load_ratio_18_deg", words] or 0.0) for row in layout_ratios] for words in steering.PARTS.values()]
    whole = "layout as a whole", "pinion position and restraint, force directions, bearing position, all combined"
    ranges = steering.load_ratio_ranges(shipped_steering_gear()) | {whole: tuple((min(of), max(of)) for of in every)}
    for (changed, over), bands in ranges.items():
        row: Row = {"varied_input": changed, "input_range": over}
        for (key, words), (low, high) in zip(steering.PARTS.items(), bands, strict=True):
            printed = printed_value("lin-4.2.1", f"ratio_{key}")
            inside = steering.rounded_value_lies_in_range((low, high), printed)
            row |= {
                ("smallest_load_ratio_18_deg", words): low,
                ("largest_load_ratio_18_deg", words): high,
                ("contains_printed_load_ratio", f"{printed:g}", words): "yes" if inside else "no",
            }
        yield row


def make_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the report's section on the lash tests and the steering gear of section 4.2 of Lin's thesis.

    ``cache``: gives the scenes included with rollbench; ``step``: function that receives a message before each step.
    """
    step("lash tests")
    scene = cache.built_in_scene(SCREW)
    cache.record_used_scenes((RACK, *steering.PATTERNS.values()))
    figures = [lash_figure(scene)]
    lash = steering.lash_difference_rows(scene)
    step("steering gear")
    points = steering.load_ratio_rows(shipped_steering_gear())
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
                points,
                SENSE,
            ),
        ),
    )
