"""Figures of Liu et al. (2025) in the order of the source: computed curves, with the numbers that its text prints.

The curves are not printed as numbers; drawn errors differ from the source's, which are not printed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import cache

import numpy as np

from rollbench.compare.cases.liu import evidence as liu
from rollbench.compare.printed import value_of
from rollbench.lowfi.random_errors.chain import Chain, Ensemble, draw_errors, solve_chain, solve_ensemble
from rollbench.lowfi.random_errors.chain import Quantity as Spread
from rollbench.meshes.arrays import Array
from rollbench.meshes.section import screw_section
from rollbench.reports.content import Figure, Panel, Quantity, Row, Series, Table

#: Loads [N] of curves over the load, up to that of section 4 and of the test; drawn screws of a curve.
LOADS = (50.0, 100.0, 200.0, 350.0, 500.0, 750.0, 1000.0, 1500.0, 2137.0, 3000.0, 4000.0, 5000.0)

TEST_LOADS = (*LOADS, 7000.0, 9000.0, 10845.0)

CURVES = 1000

#: Screw outside the nut in the test [m].
FREE_LENGTH = 1e-3 * value_of("liu-3", "free_length")

BALLS = "ball number"


DRAWN = "Of the source's screw neither errors nor curves are printed: ours are of another draw of the same distribution."

SPREAD = f"Band and median: {CURVES} drawn screws."

NO_VALUES = "The text prints no value of this figure: ours alone."


def _errors(half_range: int, number: int = 0) -> Array:
    """Return the ball errors [m] of one drawn screw; ``number``: of the draw."""
    return np.asarray(draw_errors(liu.SEED + half_range, number, 1, liu.balls(), 1e-6 * half_range)[0])


def _over_balls(values: Array, label: str, *, emphasis: bool = False) -> Series:
    """Return values over the ball number as a line."""
    return Series(label, list(range(1, liu.balls() + 1)), [float(v) for v in values], "line", emphasis=emphasis)


def _load(errors: Array, force: float, chain: Chain | None = None) -> Array:
    return solve_chain(chain or liu.screw(), errors, force).load


def _printed(x: Sequence[float], y: Sequence[float], label: str = "printed") -> Series:
    return Series(label, x, y, "markers", emphasis=True)


@cache
def _ensemble(half_range: int) -> Ensemble:
    """Return the drawn screws of an error range, solved under all loads of the test."""
    return solve_ensemble(liu.screw(), 1e-6 * half_range, list(TEST_LOADS), CURVES, seed=liu.SEED + half_range)


def _spread(half_range: int, quantity: Spread, unit: float, loads: Sequence[float] = LOADS) -> list[Series]:
    """Return the median and the central 99 % of a quantity of the drawn screws over the load."""
    of = [_ensemble(half_range).values_at(quantity, f) / unit for f in loads]
    low, middle, high = ([float(np.quantile(x, q)) for x in of] for q in (liu.UNLIKELY, 0.5, 1.0 - liu.UNLIKELY))
    return [
        Series("ours, 99 % of draws", list(loads), low, "band", high),
        Series("ours, median", list(loads), middle, "line", emphasis=True),
    ]


def _without(value: Callable[[float], float], loads: Sequence[float] = LOADS) -> Series:
    """Return a quantity without errors over the load as a line."""
    return Series("no errors", list(loads), [value(f) for f in loads], "line")


def _free_of_errors(force: float) -> tuple[float, float]:
    """Return displacement [um] and stiffness [1e8 N/m] without errors under a force [N]."""
    state = solve_chain(liu.screw(), np.zeros(liu.balls()), force)
    return 1e6 * state.displacement, 1e-8 * state.stiffness


def deformation() -> Figure:
    """Draw Figure 11: approach of every ball with errors of +-2 um under three loads."""
    errors, panels = _errors(2), []
    for force in (2000.0, 1000.0, 500.0):
        load = _load(errors, force)
        approach = 1e6 * (load / liu.screw().stiffness) ** (2.0 / 3.0)
        title = f"{force:g} N: {int(np.count_nonzero(load == 0.0))} unloaded"
        panels.append(Panel(title, BALLS, "normal deformation / µm", (_over_balls(approach, "ours, one draw"),), zero=True))
    caption = (
        "Printed: no ball unloaded at 2000 N, one at 1500 N (in the caption 1000 N), 25 at 500 N; the table gives their "
        f"places among {liu.MEMBERS} draws. {DRAWN}"
    )
    title = "Liu (2025), Figure 11: normal deformation of the balls with random errors of ±2 µm"
    return Figure("liu-figure-11", title, panels, caption, columns=3, same_y=True)


def elongation(force: float) -> float:
    """Return the stretch [um] of the screw outside the nut under a force [N]; its section is that of scene liu-screw."""
    return 1e6 * force * FREE_LENGTH / screw_section(liu.liu_screw()).EA


def test_curve() -> Figure:
    """Draw Figure 13: displacement in the test, as the model predicts it."""
    found = _spread(3, "displacement_first_loaded", 1e-6, TEST_LOADS)
    free = [float(v) + elongation(f) for f, v in zip(TEST_LOADS, found[1].y, strict=True)]
    series = (
        *found,
        _without(lambda f: _free_of_errors(f)[0], TEST_LOADS),
        Series("median and free screw", list(TEST_LOADS), free, "line"),
    )
    stiff = (*_spread(3, "stiffness", 1e8, TEST_LOADS), _without(lambda f: _free_of_errors(f)[1], TEST_LOADS))
    panels = (
        Panel("displacement", "axial load / N", "axial displacement / µm", series, zero=True),
        Panel("stiffness of the nut", "axial load / N", "stiffness / 10⁸ N/m", stiff, zero=True),
    )
    caption = (
        "A prediction: the text prints no measured displacement, only that measured and calculated ones differ by at most "
        f"9.22 %, so none can be held against ours. Whether the {1e3 * FREE_LENGTH:g} mm of screw outside the nut stretch "
        f"within what is measured is not said: both readings are drawn. {SPREAD}"
    )
    return Figure(
        "liu-figure-13",
        "Liu (2025), Figure 13: displacement in the test, predicted for random errors of ±3 µm",
        panels,
        caption,
    )


def test_table() -> Table:
    """Return the values of Figure 13 as a table."""
    rows: list[Row] = []
    for force in (500.0, 1000.0, 3000.0, 5000.0, 7000.0, 9000.0, 10845.0):
        moved = 1e6 * _ensemble(3).values_at("displacement_first_loaded", force)
        low, middle, high = (float(np.quantile(moved, q)) for q in (liu.UNLIKELY, 0.5, 1.0 - liu.UNLIKELY))
        rows.append(
            {
                Quantity("load", "axial load", "N", "s"): f"{force:g}",
                Quantity("printed", "printed", "", "s"): "in a figure only",
                Quantity("middle", "±3 µm, median", "µm", ".2f"): middle,
                Quantity("low", "0.5 %", "µm", ".2f"): low,
                Quantity("high", "99.5 %", "µm", ".2f"): high,
                Quantity("none", "no errors", "µm", ".2f"): _free_of_errors(force)[0],
                Quantity("stretch", "screw outside the nut", "µm", ".2f"): elongation(force),
                Quantity("loaded", "loaded balls, median", "", ".0f"): float(
                    np.median(_ensemble(3).values_at("loaded", force))
                ),
            }
        )
    note = (
        "Displacement of the nut by (19), from where the first ball touches. The screw's section is assumed (scene "
        "liu-screw)."
    )
    return Table.of("liu-test", "Figure 13's test predicted: nothing measured is printed", rows, note)


def against_mei() -> Figure:
    """Draw Figure 14: ball loads by the source's model and by Mei's at 5000 N, without errors and with +-2 um."""
    force, panels = liu.calibration_load(), []
    for title, errors in (("no errors", np.zeros(liu.balls())), ("±2 µm, one draw", _errors(2))):
        ours, mei = (_load(errors, force, chain) for chain in (liu.screw(), liu.mei()))
        series = [_over_balls(ours, "implicit contact angle", emphasis=True), _over_balls(mei, "Mei, 45°")]
        if not errors.any():
            ends = [float(q[0]) * value_of("liu-4.1", key) for q, key in ((ours, "ratio"), (mei, "ratio_mei"))]
            series.append(_printed([liu.balls()] * 2, ends, "printed Q78/Q1 times our Q1"))
        panels.append(Panel(title, BALLS, "normal load / N", series))
    caption = f"No load of this figure is printed, only the ratios of the last to the first. {DRAWN}"
    return Figure(
        "liu-figure-14", "Liu (2025), Figure 14: contact loads by Liu's and by Mei's model under 5000 N", panels, caption
    )


def one_ball() -> Figure:
    """Draw Figure 15: loads of the balls with one too small or too large."""
    panels = []
    for sign, words in (("minus", "a: −2 µm"), ("plus", "b: +2 µm")):
        errors, series, at, printed = liu.one_error(-2e-6 if sign == "minus" else 2e-6), [], [], []
        for force in (liu.LIGHT, liu.HEAVY):
            load = _load(errors, force)
            series.append(_over_balls(load, f"ours, {force:g} N"))
            at += [33.0, float(liu.balls())]
            q33, ratio = (value_of("liu-4.2", f"{sign}_{key}_{force:.0f}") for key in ("Q33", "ratio"))
            printed += [q33, ratio * float(load[0])]
        panels.append(Panel(f"{words} at ball 33", BALLS, "normal load / N", (*series, _printed(at, printed)), zero=True))
    caption = (
        "Printed: Q33, and Q78 as the printed ratio times our Q1. The lighter load of panel a is not printed; 1000 N as in "
        "b. 124.55 N at 5000 N in b is 142.55 N with two digits exchanged."
    )
    return Figure(
        "liu-figure-15", "Liu (2025), Figure 15: contact loads with one ball too small or too large", panels, caption
    )


def _ranges(half_range: int, loads: Iterable[float]) -> list[Series]:
    """Return the ball loads of one drawn screw as lines, and the printed load ranges as markers."""
    series = []
    for force in loads:
        series.append(_over_balls(_load(_errors(half_range), force), f"ours, {force:g} N"))
        if half_range:
            ends = [value_of("liu-4.3", f"{end}_{half_range}_{force:.0f}") for end in ("min", "max")]
            series.append(_printed([0.0, 0.0], ends, f"printed range, {force:g} N"))
    return series


def loads_2() -> Figure:
    """Draw Figure 16: loads of the balls with errors of +-2 um."""
    panel = Panel("±2 µm", BALLS, "normal load / N", _ranges(2, (500.0, 1000.0, 5000.0)), zero=True)
    caption = f"Marks at the left: the smallest and largest loads that the text prints. {DRAWN}"
    return Figure(
        "liu-figure-16", "Liu (2025), Figure 16: contact loads with random errors of ±2 µm", (panel,), caption, columns=1
    )


def loads_by_range() -> Figure:
    """Draw Figure 17: loads of the balls for errors within 0 to 3 um."""
    panels = []
    for half_range, letter in enumerate("abcd"):
        title = f"{letter}: " + (f"±{half_range} µm" if half_range else "no errors")
        panels.append(Panel(title, BALLS, "normal load / N", _ranges(half_range, (1000.0, 5000.0)), zero=True))
    caption = f"Marks at the left: the smallest and largest loads that the text prints. {DRAWN}"
    title = "Liu (2025), Figure 17: contact loads for several ranges of the random errors"
    return Figure("liu-figure-17", title, panels, caption)


def loaded_balls(found: dict[str, float], words: str) -> Figure:
    """Draw Figure 18: loaded balls over the load, with the printed counts of 4.3; words: how these compare."""
    panels = []
    for h in liu.RANGES:
        keys = [k for k in found if k.startswith((f"loaded_{h}_", f"unloaded_{h}_"))]
        at = [float(k.split("_")[2]) for k in keys]
        counts = [liu.balls() - found[k] if k.startswith("un") else found[k] for k in keys]
        series = (*_spread(h, "loaded", 1.0, LOADS[:-2]), _printed(at, counts))
        panels.append(Panel(f"±{h} µm", "axial load / N", "loaded balls", series, zero=True))
    caption = f"Printed: the counts of the text; where it counts unloaded balls, 78 less them: {words} {SPREAD}"
    title = "Liu (2025), Figure 18: number of loaded balls over the axial load"
    return Figure("liu-figure-18", title, panels, caption, columns=3, same_y=True)


def displacement() -> Figure:
    """Draw Figure 19: displacement of the nut over the load."""
    free = _without(lambda f: _free_of_errors(f)[0])
    panels = [
        Panel(
            f"±{h} µm",
            "axial load / N",
            "displacement / µm",
            (*_spread(h, "displacement_first_loaded", 1e-6), free),
            zero=True,
        )
        for h in liu.RANGES
    ]
    title = "Liu (2025), Figure 19: displacement of the nut over the axial load"
    return Figure("liu-figure-19", title, panels, f"{NO_VALUES} {SPREAD}", columns=3)


def _printed_stiffness(found: dict[str, float], which: int | str, label: str) -> Series:
    """Return the printed stiffness values of one error range as markers over the load."""
    keys = [k for k in found if k.startswith(f"K_{which}_")]
    return _printed([float(k.split("_")[2]) for k in keys], [found[k] for k in keys], label)


def stiffness(found: dict[str, float], words: str) -> Figure:
    """Draw Figure 20: stiffness over the load, with the printed values of 4.4; words: how these compare."""
    free, panels = _without(lambda f: _free_of_errors(f)[1]), []
    for h in liu.RANGES:
        marks = [_printed_stiffness(found, h, "printed"), _printed_stiffness(found, 0, "printed, none")]
        series = (*_spread(h, "stiffness", 1e8), free, *marks)
        panels.append(Panel(f"±{h} µm", "axial load / N", "stiffness / 10⁸ N/m", series, zero=True))
    caption = (
        "Ours is the tangent; the step of load of (22) is not printed, and a secant lies above the tangent. "
        f"{words} {SPREAD}"
    )
    title = "Liu (2025), Figure 20: axial stiffness over the axial load"
    return Figure("liu-figure-20", title, panels, caption, columns=3, same_y=True)


def three_sets(found: dict[str, float]) -> Figure:
    """Draw Figure 21: stiffness of three draws of +-2 um, and how far three draws differ."""
    curves = []
    for i, name in enumerate(liu.SETS):
        values = [1e-8 * solve_chain(liu.screw(), _errors(2, i), f).stiffness for f in LOADS]
        curves.append(Series(f"ours, draw {i + 1}", list(LOADS), values, "line"))
        curves.append(_printed_stiffness(found, name, f"printed, set {name}"))
    loads, spread = (100.0, 1100.0, 2100.0), [liu.spreads(f) for f in (100.0, 1100.0, 2100.0)]
    low, middle, high = ([float(np.quantile(s, q)) for s in spread] for q in (liu.UNLIKELY, 0.5, 1.0 - liu.UNLIKELY))
    differ = (
        Series("central 99 % of drawn triples", loads, low, "band", high),
        Series("median", loads, middle, "line"),
        _printed(loads, [value_of("liu-4.4", f"spread_{f:.0f}") for f in loads]),
    )
    panels = (
        Panel("three draws of ±2 µm", "axial load / N", "stiffness / 10⁸ N/m", curves, zero=True),
        Panel("greatest less least of three", "axial load / N", "stiffness / 10⁸ N/m", differ, zero=True),
    )
    return Figure(
        "liu-figure-21", "Liu (2025), Figure 21: contact loads for three draws of the random errors", panels, DRAWN
    )
