"""Figures 11 to 21 of Liu et al. (2025), computed again, with the numbers that the publication's text prints.

The publication does not print its curves as numbers, nor the ball errors that it drew.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import cache

import numpy as np

from rollbench.compare.cases.liu import evidence as liu
from rollbench.compare.printed import printed_value
from rollbench.lowfi.as_source.liu import chain as ball_chain
from rollbench.lowfi.as_source.liu import ensemble as screw_ensemble
from rollbench.lowfi.as_source.liu.ensemble import Quantity as Spread
from rollbench.meshes.arrays import Array
from rollbench.meshes.section import screw_section
from rollbench.reports.content import Figure, Panel, Row, Series, Table

#: Axial loads [N] of the curves, up to the largest load of section 4, and up to that of the test; number of random screws.
LOADS = (50.0, 100.0, 200.0, 350.0, 500.0, 750.0, 1000.0, 1500.0, 2137.0, 3000.0, 4000.0, 5000.0)

TEST_LOADS = (*LOADS, 7000.0, 9000.0, 10845.0)

CURVES = 1000

#: Length of the screw outside the nut in the test [m].
FREE_LENGTH = 1e-3 * printed_value("liu-3", "free_length")

BALLS = "ball number"


DRAWN = (
    "Liu et al. print neither their random ball errors nor numbers for their curves: "
    "the curves here have other random errors of the same range."
)

SPREAD = f"Band: central 99 % of {CURVES} screws with random errors; line: their median."

NO_VALUES = "Liu's text prints no value of this figure."


def _random_ball_errors(half_range: int, number: int = 0) -> Array:
    """Return the errors of the ball diameters (78,) [m] of one randomly drawn screw.

    ``half_range``: the errors are uniform within plus and minus this range [um]; ``number``: number of
    the screw, from 0.
    """
    drawn = screw_ensemble.draw_uniform_errors(liu.SEED + half_range, number, 1, liu.ball_count(), 1e-6 * half_range)
    return np.asarray(drawn[0])


def _curve_over_balls(values: Array, label: str, *, emphasis: bool = False) -> Series:
    """Return the curve of a quantity over the number of the ball.

    ``values``: value of the quantity for each ball (78,); ``label``: legend; ``emphasis``: whether the curve is drawn bold.
    """
    return Series(label, list(range(1, liu.ball_count() + 1)), [float(v) for v in values], "line", bold=emphasis)


def _solve_ball_loads(errors: Array, force: float, chain: ball_chain.BallScrewChain | None = None) -> Array:
    """Return the contact load of each ball (78,) [N] under the axial force ``force`` [N].

    ``errors``: errors of the ball diameters (78,) [m]; ``chain``: axial model; None: Liu's calibrated model.
    """
    return ball_chain.solve_ball_screw(chain or liu.calibrated_model(), errors, force).load


def _printed_markers(x: Sequence[float], y: Sequence[float], label: str = "printed") -> Series:
    """Return printed values as markers of a figure, with abscissas ``x`` and ordinates ``y`` in the panel's units."""
    return Series(label, x, y, "markers", bold=True)


@cache
def _solve_random_screws(half_range: int) -> screw_ensemble.ScrewEnsemble:
    """Draw 1000 screws (`CURVES`) with random ball errors, and solve their contact loads under several axial loads.

    The loads are `TEST_LOADS`. ``half_range``: the errors of the ball diameters are uniform within plus and minus this
    range [um].
    """
    model, loads = liu.calibrated_model(), list(TEST_LOADS)
    return screw_ensemble.solve_ensemble(model, 1e-6 * half_range, loads, CURVES, seed=liu.SEED + half_range)


def _percentile_curves_over_load(
    half_range: int, quantity: Spread, unit: float, loads: Sequence[float] = LOADS
) -> list[Series]:
    """Return median and central 99 % of a quantity of randomly drawn screws, as curves over the axial load.

    ``half_range``: half range of the ball errors [um]; ``quantity``: name, such as "stiffness"; ``unit``: unit of the curve
    in SI, by which values are divided; ``loads``: axial loads [N].
    """
    of = [_solve_random_screws(half_range).values_at(quantity, f) / unit for f in loads]
    low, middle, high = ([float(np.quantile(x, q)) for x in of] for q in (liu.UNLIKELY, 0.5, 1.0 - liu.UNLIKELY))
    return [
        Series("computed, central 99 %", list(loads), low, "band", high),
        Series("computed, median", list(loads), middle, "line", bold=True),
    ]


def _error_free_response(force: float) -> tuple[float, float]:
    """Return axial displacement [um], then stiffness [1e8 N/m] of the screw without errors under an axial force [N]."""
    state = ball_chain.solve_ball_screw(liu.calibrated_model(), np.zeros(liu.ball_count()), force)
    return 1e6 * state.displacement, 1e-8 * state.stiffness


def _error_free_curves(loads: Sequence[float] = LOADS) -> tuple[Series, ...]:
    """Return displacement [um] and stiffness [1e8 N/m] of the screw without ball errors as curves over axial loads [N]."""
    responses = zip(*map(_error_free_response, loads), strict=True)
    return tuple(Series("no ball errors", list(loads), list(values), "line") for values in responses)


def _panels_by_error_range(
    quantity: Spread,
    unit: float,
    label: str,
    others_of_range: Callable[[int], Iterable[Series]],
    loads: Sequence[float] = LOADS,
) -> list[Panel]:
    """Return a panel for each range of ball errors, with curves of a quantity of random screws over the axial load.

    ``quantity``, ``unit``, ``loads``: as in `_percentile_curves_over_load`; ``label``: of the ordinate;
    ``others_of_range``: function that returns further curves for a half range of the errors [um].
    """
    return [
        Panel(
            f"ball errors of ±{h} µm",
            "axial_load",
            label,
            (*_percentile_curves_over_load(h, quantity, unit, loads), *others_of_range(h)),
            include_zero=True,
        )
        for h in liu.RANGES
    ]


def ball_deformation_figure() -> Figure:
    """Draw Liu's Figure 11: normal deformation of each ball under three axial loads, with random ball errors of ±2 um."""
    errors, panels = _random_ball_errors(2), []
    for force in (2000.0, 1000.0, 500.0):
        load = _solve_ball_loads(errors, force)
        approach = 1e6 * (load / liu.calibrated_model().stiffness) ** (2.0 / 3.0)
        title = f"axial load {force:g} N: {int(np.count_nonzero(load == 0.0))} unloaded balls"
        curve = _curve_over_balls(approach, "computed, one random screw")
        panels.append(Panel(title, BALLS, "normal deformation / µm", (curve,), include_zero=True))
    caption = (
        "Liu's text prints no unloaded ball at 2000 N, one at 1500 N (his caption: 1000 N) and 25 at 500 N. The table of "
        f"this section states at which percentile of {liu.MEMBERS} random screws each number lies. {DRAWN}"
    )
    title = "Liu (2025), Figure 11: normal deformation of the balls with random diameter errors of ±2 µm"
    return Figure("liu-figure-11", title, panels, caption, columns=3, same_y=True)


def elongation_outside_nut(force: float) -> float:
    """Return the elongation [um] of the part of the screw outside the nut in Liu's experiment, under an axial force [N].

    The cross section is not printed; it is taken from the scene liu-screw.
    """
    return 1e6 * force * FREE_LENGTH / screw_section(liu.liu_screw_scene()).EA


def displacement_test_figure() -> Figure:
    """Draw Liu's Figure 13: computed displacement and stiffness of the nut over the axial load of the experiment."""
    found = _percentile_curves_over_load(3, "displacement_first_loaded", 1e-6, TEST_LOADS)
    free_displacement, free_stiffness = _error_free_curves(TEST_LOADS)
    free = [float(v) + elongation_outside_nut(f) for f, v in zip(TEST_LOADS, found[1].y, strict=True)]
    series = (
        *found,
        free_displacement,
        Series("median, with elongation of the screw outside the nut", list(TEST_LOADS), free, "line"),
    )
    stiff = (*_percentile_curves_over_load(3, "stiffness", 1e8, TEST_LOADS), free_stiffness)
    panels = (
        Panel("displacement of the nut", "axial_load", "axial displacement / µm", series, include_zero=True),
        Panel("stiffness of the nut", "axial_load", "stiffness_1e8", stiff, include_zero=True),
    )
    caption = (
        "Computed curves only: Liu's text prints no measured displacement. It does not state whether the measured "
        f"displacement includes the stretch of the {1e3 * FREE_LENGTH:g} mm of screw outside the nut: both are drawn. "
        f"{SPREAD}"
    )
    title = "Liu (2025), Figure 13: displacement and stiffness predicted for Liu's test, random ball errors of ±3 µm"
    return Figure("liu-figure-13", title, panels, caption)


def displacement_test_table() -> Table:
    """Return the table of computed displacements for the experiment of Liu's Figure 13, at several axial loads."""
    rows: list[Row] = []
    for force in (500.0, 1000.0, 3000.0, 5000.0, 7000.0, 9000.0, 10845.0):
        screws, stretch = _solve_random_screws(3), elongation_outside_nut(force)
        moved = 1e6 * screws.values_at("displacement_first_loaded", force)
        loaded = float(np.median(screws.values_at("loaded", force)))
        row: Row = {"axial_load": f"{force:g}", "printed_displacement": "in a figure only"}
        for end, q in (("median", 0.5), ("p0_5", liu.UNLIKELY), ("p99_5", 1.0 - liu.UNLIKELY)):
            row[f"displacement_{end}"] = float(np.quantile(moved, q))
        row |= {"displacement_without_errors": _error_free_response(force)[0], "screw_elongation": stretch}
        rows.append(row | {"loaded_balls_median": loaded})
    note = (
        "Displacement of the nut by Liu's equation (19), counted from the first contact of a ball. The cross section of "
        "the screw is assumed (scene liu-screw)."
    )
    title = "Liu (2025), Figure 13: displacement predicted for Liu's test; measured values are not printed"
    return Table.from_rows("liu-test", title, rows, note)


def liu_and_mei_loads_figure() -> Figure:
    """Draw Liu's Figure 14: ball loads by Liu's and Mei's models at an axial load of 5000 N.

    Both without ball errors and with random errors of the ball diameters of up to +-2 um.
    """
    force, panels = liu.calibration_load(), []
    for title, errors in (
        ("no ball errors", np.zeros(liu.ball_count())),
        ("ball errors of ±2 µm, one random screw", _random_ball_errors(2)),
    ):
        ours, mei = (_solve_ball_loads(errors, force, chain) for chain in (liu.calibrated_model(), liu.mei_model()))
        series = [
            _curve_over_balls(ours, "Liu's model, implicit contact angle", emphasis=True),
            _curve_over_balls(mei, "Mei's model, 45°"),
        ]
        if not errors.any():
            ends = [float(q[0]) * printed_value("liu-4.1", key) for q, key in ((ours, "ratio"), (mei, "ratio_mei"))]
            series.append(_printed_markers([liu.ball_count()] * 2, ends, "printed Q78/Q1 times computed Q1"))
        panels.append(Panel(title, BALLS, "normal_load", series))
    caption = f"Of this figure only the ratios of the last ball's load to the first ball's are printed. {DRAWN}"
    title = "Liu (2025), Figure 14: contact loads by Liu's and by Mei's model at an axial load of 5000 N"
    return Figure("liu-figure-14", title, panels, caption)


def loads_with_one_faulty_ball_figure() -> Figure:
    """Draw Liu's Figure 15: loads of all balls, where ball 33 is too small or too large by 2 um."""
    panels = []
    for sign, words in (("minus", "a: −2 µm"), ("plus", "b: +2 µm")):
        errors, series, at, printed = liu.ball_errors_with_faulty_ball_33(-2e-6 if sign == "minus" else 2e-6), [], [], []
        for force in (liu.LIGHT, liu.HEAVY):
            load = _solve_ball_loads(errors, force)
            series.append(_curve_over_balls(load, f"computed, {force:g} N"))
            at += [33.0, float(liu.ball_count())]
            q33, ratio = (printed_value("liu-4.2", f"{sign}_{key}_{force:.0f}") for key in ("Q33", "ratio"))
            printed += [q33, ratio * float(load[0])]
        series.append(_printed_markers(at, printed))
        panels.append(Panel(f"{words} error of ball 33", BALLS, "normal_load", series, include_zero=True))
    caption = (
        "Markers: load Q33 of ball 33 that Liu prints, and load of ball 78, from the printed ratio Q78/Q1 of the loads of "
        "balls 78 and 1 and the computed load Q1. The lighter axial load of panel a is not printed; 1000 N is assumed, as "
        "in panel b. In panel b, at 5000 N, Liu prints Q33 = 124.55 N, a misprint of 142.55 N (two digits exchanged)."
    )
    title = "Liu (2025), Figure 15: contact loads with one ball too small or too large"
    return Figure("liu-figure-15", title, panels, caption)


def _load_curves_and_ranges(half_range: int, loads: Iterable[float]) -> list[Series]:
    """Return curves of the ball loads over the ball's number, with the printed smallest and largest loads as markers.

    The screw has random ball errors. ``half_range``: half range of these errors [um]; ``loads``: axial loads [N].
    """
    series = []
    for force in loads:
        load = _solve_ball_loads(_random_ball_errors(half_range), force)
        series.append(_curve_over_balls(load, f"computed, {force:g} N"))
        if half_range:
            ends = [printed_value("liu-4.3", f"{end}_{half_range}_{force:.0f}") for end in ("min", "max")]
            series.append(_printed_markers([0.0, 0.0], ends, f"printed range, {force:g} N"))
    return series


def loads_with_random_errors_figure() -> Figure:
    """Draw Liu's Figure 16: loads of all balls with random errors of +-2 um."""
    curves = _load_curves_and_ranges(2, (500.0, 1000.0, 5000.0))
    panel = Panel("ball errors of ±2 µm", BALLS, "normal_load", curves, include_zero=True)
    caption = f"Markers at the left: smallest and largest loads that Liu's text prints. {DRAWN}"
    title = "Liu (2025), Figure 16: contact loads with random ball errors of ±2 µm"
    return Figure("liu-figure-16", title, (panel,), caption, columns=1)


def loads_by_error_range_figure() -> Figure:
    """Draw Liu's Figure 17: loads of all balls with random errors of 0, +-1, +-2 and +-3 um."""
    panels = []
    for half_range, letter in enumerate("abcd"):
        title = f"{letter}: " + (f"ball errors of ±{half_range} µm" if half_range else "no ball errors")
        curves = _load_curves_and_ranges(half_range, (1000.0, 5000.0))
        panels.append(Panel(title, BALLS, "normal_load", curves, include_zero=True))
    caption = f"Markers at the left: smallest and largest loads that Liu's text prints. {DRAWN}"
    title = "Liu (2025), Figure 17: contact loads for several ranges of random ball errors"
    return Figure("liu-figure-17", title, panels, caption)


def loaded_balls_figure(found: dict[str, float], caption_end: str) -> Figure:
    """Draw Liu's Figure 18: number of loaded balls over the axial load, with the numbers printed in section 4.3.

    ``found``: printed values by key, such as "loaded_2_500" for ball errors within ±2 um and a load of 500 N;
    ``caption_end``: text that ends the caption.
    """

    def printed_counts(half_range: int) -> list[Series]:
        """Return the printed numbers of loaded balls for a half range of the ball errors [um] as markers."""
        keys = [k for k in found if k.startswith((f"loaded_{half_range}_", f"unloaded_{half_range}_"))]
        counts = [liu.ball_count() - found[k] if k.startswith("un") else found[k] for k in keys]
        return [_printed_markers([float(k.split("_")[2]) for k in keys], counts)]

    panels = _panels_by_error_range("loaded", 1.0, "number of loaded balls", printed_counts, LOADS[:-2])
    caption = (
        "Markers: number of loaded balls by Liu's text, which for some loads prints the number of unloaded balls, out of "
        f"78. {caption_end} {SPREAD}"
    )
    title = "Liu (2025), Figure 18: number of loaded balls, plotted against the axial load"
    return Figure("liu-figure-18", title, panels, caption, columns=3, same_y=True)


def displacement_figure() -> Figure:
    """Draw Liu's Figure 19: axial displacement of the nut over the axial load."""
    panels = _panels_by_error_range("displacement_first_loaded", 1e-6, "displacement", lambda _: _error_free_curves()[:1])
    title = "Liu (2025), Figure 19: displacement of the nut, plotted against the axial load"
    return Figure("liu-figure-19", title, panels, f"{NO_VALUES} {SPREAD}", columns=3)


def _printed_stiffness_markers(found: dict[str, float], error_range_or_screw: int | str, label: str) -> Series:
    """Return markers of the printed stiffness over the axial load.

    ``found``: printed values by key, such as "K_2_3000" for ball errors within ±2 um and a load of 3000 N;
    ``error_range_or_screw``: half range of the ball errors [um], or letter of one of the three printed screws; ``label``:
    legend.
    """
    keys = [k for k in found if k.startswith(f"K_{error_range_or_screw}_")]
    return _printed_markers([float(k.split("_")[2]) for k in keys], [found[k] for k in keys], label)


def stiffness_figure(found: dict[str, float], caption_end: str) -> Figure:
    """Draw Liu's Figure 20: axial stiffness over the axial load, with the values printed in section 4.4.

    ``found``: printed values by key, such as "K_2_3000" for ball errors within ±2 um and a load of 3000 N;
    ``caption_end``: text that ends the caption.
    """

    def others_of_range(half_range: int) -> tuple[Series, ...]:
        """Return curve without errors and printed stiffnesses for a half range of the ball errors [um]."""
        printed = {half_range: "printed", 0: "printed, no ball errors"}
        return (_error_free_curves()[1], *(_printed_stiffness_markers(found, h, words) for h, words in printed.items()))

    panels = _panels_by_error_range("stiffness", 1e8, "stiffness_1e8", others_of_range)
    caption = (
        "Computed: tangent stiffness. Liu's equation (22) is a secant, which lies above the tangent; its load step is not "
        f"printed. {caption_end} {SPREAD}"
    )
    title = "Liu (2025), Figure 20: axial stiffness, plotted against the axial load"
    return Figure("liu-figure-20", title, panels, caption, columns=3, same_y=True)


def stiffness_of_three_screws_figure(found: dict[str, float]) -> Figure:
    """Draw Liu's Figure 21: stiffness of three randomly drawn screws over the axial load, and their range.

    The ball errors are within ±2 um. ``found``: printed values by key, such as "K_a_1100" for screw a at 1100 N.
    """
    curves = []
    for i, name in enumerate(liu.SETS):
        model, errors = liu.calibrated_model(), _random_ball_errors(2, i)
        values = [1e-8 * ball_chain.solve_ball_screw(model, errors, f).stiffness for f in LOADS]
        curves.append(Series(f"computed, random screw {i + 1}", list(LOADS), values, "line"))
        curves.append(_printed_stiffness_markers(found, name, f"printed, set {name}"))
    loads, spread = (100.0, 1100.0, 2100.0), [liu.stiffness_spreads_of_triples(f) for f in (100.0, 1100.0, 2100.0)]
    low, middle, high = ([float(np.quantile(s, q)) for s in spread] for q in (liu.UNLIKELY, 0.5, 1.0 - liu.UNLIKELY))
    differ = (
        Series("computed, central 99 % of random triples", loads, low, "band", high),
        Series("computed, median", loads, middle, "line"),
        _printed_markers(loads, [printed_value("liu-4.4", f"spread_{f:.0f}") for f in loads]),
    )
    panels = (
        Panel("three random screws, ball errors of ±2 µm", "axial_load", "stiffness_1e8", curves, include_zero=True),
        Panel("largest minus smallest stiffness of three screws", "axial_load", "stiffness_1e8", differ, include_zero=True),
    )
    title = "Liu (2025), Figure 21: axial stiffness of three screws with random ball errors"
    return Figure("liu-figure-21", title, panels, DRAWN)
