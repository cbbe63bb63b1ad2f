"""Smith (1994), chapters 4 and 5: the axis with its supports, measurements, claims, the reduced preload of 5.3.

Its layouts are scenes over the nut's position, compared with closed formulas and with the sum in series.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from rollbench.compare.cases.smith.evidence import bearings
from rollbench.compare.evidence import Findings
from rollbench.compare.measure import error_percent
from rollbench.compare.models.registry import Options, run_model
from rollbench.compare.models.study import Study
from rollbench.compare.printed import value_of
from rollbench.compare.scenes import catalogue
from rollbench.lowfi.bearings import as_printed
from rollbench.lowfi.bearings.angular_contact import BallRow
from rollbench.lowfi.bearings.axis import (
    BearingSet,
    BearingSetState,
    TorqueBudget,
    acceleration_torque,
    angular_speed,
    axis_stiffness,
    equal_rows,
    equilibrium,
    lift_off_force,
    shaft_inertia,
    shaft_stiffness,
    shaft_tension,
    support_loads,
    unloading_warming,
)
from rollbench.meshes.axis import Assembly
from rollbench.meshes.numerics import brentq
from rollbench.meshes.units import parse

#: Station of the left end's middle [m], and positions of the nut over the length between the ends.
FIRST, PLACES = 2.0 * bearings.INCH, (0.1, 0.5, 0.9)


@dataclass(frozen=True)
class Layout:
    """A layout of the axis: scene, description, kind of bearing, row directions by end (none: the end slides)."""

    scene: str
    words: str
    kind: str
    left: tuple[int, ...]
    right: tuple[int, ...]

    def bearings_at(self, end: str) -> BearingSet:
        """Return the bearing rows of an end with their load-deflection laws."""
        directions = self.left if end == "left" else self.right
        if directions == bearings.DIRECTIONS[self.kind][end]:
            return bearings.bearing_set(self.kind, end)
        return equal_rows(BallRow(bearings.ball_bearing()), directions, 0.0)


TRIPLEX = Layout("smith-axis", "triplex, fixed-fixed", "ball", *bearings.DIRECTIONS["ball"].values())

SUPPORTED = Layout("smith-axis-supported", "triplex, fixed-supported", "ball", bearings.DIRECTIONS["ball"]["left"], ())

TANDEM = Layout("smith-axis-tandem", "tandem pairs, fixed-fixed", "ball", (1, 1), (1, 1))

TAPERED = Layout("smith-axis-taper", "two-row tapered, fixed-fixed", "taper", *bearings.DIRECTIONS["taper"].values())

LAYOUTS = TRIPLEX, SUPPORTED, TANDEM, TAPERED


@dataclass(frozen=True)
class Ends:
    """Thrust on both ends by the shaft's tension [N], and axial stiffness of shaft and supports at the nut [N/m]."""

    left: float
    right: float
    stiffness: float


@cache
def by_formulas(layout: Layout, place: float, applied: float = bearings.APPLIED) -> Ends:
    """Return end thrusts and stiffness by closed formulas, with all rows of an end at one position.

    The shaft is stretched as in the source, and the rows are preloaded.
    """
    a, first = bearings.axis(), layout.bearings_at("left")
    bars = np.array([place, 1.0 - place]) * a.length / (a.young * a.area)
    if not layout.right:
        k = equilibrium(first, -applied).stiffness
        return Ends(-applied, 0.0, 1.0 / (1.0 / k + float(bars[0])))
    second = layout.bearings_at("right")

    def gap(left: float) -> float:
        forces = left, left + applied
        moved = sum(equilibrium(rows, f).displacement for rows, f in zip((first, second), forces, strict=True))
        return moved + float(bars @ forces) - bearings.STRETCH

    low = 1e-3 if min(layout.left) > 0 else -2e4  # tandem rows carry tension only
    left = float(brentq(gap, low, 4e4, xtol=1e-6))
    ends = [equilibrium(rows, f).stiffness for rows, f in ((first, left), (second, left + applied))]
    return Ends(left, left + applied, sum(1.0 / (1.0 / k + float(b)) for k, b in zip(ends, bars, strict=True)))


def by_scene(study: Study, layout: Layout, place: float) -> Ends:
    """Return end thrusts and stiffness by the scene: beam, contacts, and rows at their positions."""
    return study.once(_by_scene, layout, place)


def _by_scene(study: Study, layout: Layout, place: float) -> Ends:  # noqa: ARG001 - kept by the study
    """Solve a layout's scene with the load at a place; raises AssertionError if it does not converge."""
    found = catalogue.shipped(layout.scene)
    if not isinstance(found, Assembly):
        raise AssertionError(f"{layout.scene} is an axis")
    at = FIRST + place * bearings.axis().length
    loads = tuple(replace(x, at=at, force=(0.0, 0.0, -bearings.APPLIED)) for x in found.loads)
    result = run_model(replace(found, loads=loads, stiffness_at=at), "lin", Options(engine="compiled"))
    if not result.converged or result.stiffness is None:
        raise AssertionError(f"{layout.scene}: {result.status}")
    thrust = {end: sum(float(s.force[2]) for s in result.sets if s.of.name.startswith(end)) for end in ("left", "right")}
    return Ends(-thrust["left"], thrust["right"], float(result.stiffness[2, 2]))


def in_series(layout: Layout) -> float:
    """Return the source's sum (4.6) of both ends and the whole screw between rigid walls, without the nut [N/m].

    nan for a fixed-supported screw, for which the source gives no sum.
    """
    if not layout.right:
        return float("nan")
    a, force = bearings.axis(), by_formulas(layout, 0.5, 0.0).left
    ends = [equilibrium(layout.bearings_at(end), force).stiffness for end in ("left", "right")]
    return as_printed.series_stiffness(ends, float(shaft_stiffness(a, 0.5 * a.length)), float("inf"))


def layout_words(study: Study, layout: Layout) -> str:
    """Return a sentence on end thrusts and stiffness with the load in the middle, by scene and by formulas."""
    scene, closed = by_scene(study, layout, 0.5), by_formulas(layout, 0.5)
    ends = [f"{x.left / bearings.POUND:.0f} and {x.right / bearings.POUND:.0f} lbf" for x in (scene, closed)]
    stiff = [f"{x.stiffness / bearings.POUND_PER_INCH / 1e6:.3f}e6 lbf/in" for x in (scene, closed)]
    return f"as a scene the ends carry {ends[0]} ({stiff[0]} without the nut), by formulas {ends[1]} ({stiff[1]})"


def every_place(study: Study) -> Iterator[tuple[Layout, float, Ends, Ends]]:
    """Yield each layout and place of the load, with the results by scene and by formulas."""
    for layout in LAYOUTS:
        for place in PLACES:
            yield layout, place, by_scene(study, layout, place), by_formulas(layout, place)


#: Lead [m] and rapid traverse [m/s] of 5.1, counts a turn, torque of the motor [in-lbf], reduced preload of 5.3 [N].
LEAD, TRAVERSE = parse("14 mm", "length"), 800.0 * bearings.INCH / 60.0

COUNTS, MOTOR, REDUCED = 40000.0, 159.0, parse("750 lbf", "force")

#: Density of steel [kg/m^3], for the inertia that the source does not print.
STEEL = 7850.0

KINDS = ("ball", "taper")


def pull() -> float:
    """Return the tension [N] of the stretched screw between rigid supports: the load of either end."""
    return shaft_tension(bearings.axis(), bearings.STRETCH)


@cache
def end_state(kind: str, end: str, state: str, preload: float = bearings.PRELOAD) -> BearingSetState:
    """Return the equilibrium of the bearings of an end under "preload", "stretch", or with the load "applied"."""
    rows = bearings.bearing_set(kind, end, preload)
    if state == "preload":
        return equilibrium(rows)
    force = pull() if state == "stretch" else _ends(pull())[end]
    return equilibrium(rows, force)


def _ends(tensile: float) -> dict[str, float]:
    """Return the thrust [N] of either end with the load of 4.2 on the nut in the middle, towards the left end."""
    left, right = support_loads(bearings.axis(), 0.5 * bearings.axis().length, -bearings.APPLIED, tensile)
    return {"left": left, "right": right}


def printed_loads(kind: str, end: str, state: str, preload: tuple[float, ...]) -> list[float]:
    """Return the row loads [lbf] by the source's rule: half of stretch and load at each end, in full on every row."""
    loads = as_printed.shared_loads(preload, bearings.DIRECTIONS[kind][end], 0.5 * round(pull() / bearings.POUND, -1))
    if state == "applied":
        sign = -1.0 if end == "left" else 1.0
        loads = as_printed.shared_loads(
            list(loads), bearings.DIRECTIONS[kind][end], sign * 0.5 * bearings.APPLIED / bearings.POUND
        )
    return [float(v) for v in loads]


def section_4_1(e: Findings, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """Compute stretch and warming."""
    a = bearings.axis()
    diameter = 2.0 * float(np.sqrt(a.area / np.pi))
    e.numbers(
        {
            "L": a.length / bearings.INCH,
            "d": diameter / bearings.INCH,
            "stretch": bearings.STRETCH / bearings.INCH,
            "expansion": bearings.EXPANSION * bearings.DEG_F,
            "E": a.young / bearings.PSI,
            "eps": bearings.STRETCH / a.length,
            "dT": unloading_warming(a, bearings.STRETCH, bearings.EXPANSION) / bearings.DEG_F,
        }
    )
    stiff = {kind: end_state(kind, "left", "stretch").stiffness for kind in KINDS}
    elastic = [shaft_tension(bearings.axis(k, k), bearings.STRETCH) / bearings.POUND for k in stiff.values()]
    words = f"{elastic[0]:.0f} and {elastic[1]:.0f} lbf if the stretch is of the ends and the bearings give way"
    e.number("F", pull() / bearings.POUND, words)
    e.number("F_end", pull() / bearings.POUND, as_printed=0.5 * round(pull() / bearings.POUND, -1))


def section_4_2(e: Findings, study: Study) -> None:
    """Compute loads and stiffness of the supports, stiffness of the axis."""
    for kind in KINDS:
        for end in bearings.DIRECTIONS[kind]:
            _support(e, kind, end)
    a = bearings.axis()
    least = float(shaft_stiffness(a, 0.5 * a.length))
    e.numbers({"screw": least / bearings.POUND_PER_INCH, "nut": bearings.NUT / bearings.POUND_PER_INCH})
    e.number("applied", bearings.APPLIED / bearings.POUND)
    e.number("package_ball", end_state("ball", "left", "stretch").stiffness / bearings.POUND_PER_INCH)
    e.number("package_taper", 2.0 * e.printed("taper_left_stiffness_1"))
    for kind in KINDS:
        e.number(f"rows_{kind}", 2.0 * sum(len(rows) for rows in bearings.DIRECTIONS[kind].values()))
    _total(e, "ball", layout_words(study, TRIPLEX))
    _total(e, "taper", layout_words(study, TAPERED))
    places = np.linspace(0.0, a.length, 53)[1:-1]
    both_ends, one = shaft_stiffness(a, places), shaft_stiffness(bearings.axis(right=0.0), places)
    at = float(places[int(np.argmin(both_ends))] / a.length)
    e.claim("middle", abs(at - 0.5) < 0.01, f"least at {at:.2f} L")
    ratio = both_ends / one
    middle = float(ratio[ratio.size // 2])
    scenes = [by_scene(study, x, 0.5).stiffness for x in (TRIPLEX, SUPPORTED)]
    words = f"ratio {ratio.min():.2f} to {ratio.max():.0f}, {middle:.1f} in the middle"
    words += f"; as scenes, between triplex sets and with one, {scenes[0] / scenes[1]:.2f} in the middle"
    e.claim("supported", bool(np.all(ratio > 1.0)), words)


def _support(e: Findings, kind: str, end: str) -> None:
    """Compute loads and stiffnesses of the rows of one end."""
    count = len(bearings.DIRECTIONS[kind][end])
    preload = tuple(e.printed(f"{kind}_{end}_preload_{i + 1}") for i in range(count))
    for state in ("preload", "stretch", "applied"):
        ours = end_state(kind, end, state)
        printed = None if state == "preload" else printed_loads(kind, end, state, preload)
        for i in range(count):
            key = f"{kind}_{end}_{state}_{i + 1}"
            e.number(key, float(ours.loads[i]) / bearings.POUND, as_printed=None if printed is None else printed[i])
    ours = end_state(kind, end, "applied")
    for i in range(count):
        e.number(f"{kind}_{end}_stiffness_{i + 1}", float(ours.row_stiffness[i]) / bearings.POUND_PER_INCH)
    total = sum(e.printed(f"{kind}_{end}_stiffness_{i + 1}") for i in range(count))
    words = f"equilibrium gives {ours.stiffness / bearings.POUND_PER_INCH / 1e6:.2f}e6 lbf/in"
    e.number(f"{kind}_{end}_package", total, words)


def topology(supports: float) -> float:
    """Return the correct stiffness [N/m] of the carriage at mid-length, with equal supports of a stiffness [N/m]."""
    a = bearings.axis(supports, supports)
    return float(axis_stiffness(a, 0.5 * a.length, bearings.NUT))


def _total(e: Findings, kind: str, as_scenes: str) -> None:
    """Compute the stiffness of the axis as printed, and in the right topology with printed and computed bearings."""
    package, screw, nut = (e.printed(k) for k in (f"package_{kind}", "screw", "nut"))
    printed = as_printed.series_stiffness((package, package), screw, nut)
    right = topology(package * bearings.POUND_PER_INCH) / bearings.POUND_PER_INCH
    ours = topology(end_state(kind, "left", "stretch").stiffness) / bearings.POUND_PER_INCH
    off = float(error_percent(printed, right))
    words = f"right topology, printed parts {1e-6 * right:.3f}e6, our bearings {1e-6 * ours:.3f}e6; "
    words += f"the sum in series {off:+.0f} %"
    e.number(f"total_{kind}", right, f"{words}; {as_scenes}", as_printed=printed)


def section_4_3(e: Findings, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """Compute the torque budget."""
    rows = {"ball": (3, value_of("smith-2.3", "M")), "taper": (2, value_of("smith-3", "M"))}
    e.number("nut", 18.0)
    shaft = shaft_inertia(STEEL, 2.0 * float(np.sqrt(bearings.axis().area / np.pi)), bearings.axis().length)
    alone = acceleration_torque([shaft], angular_speed(TRAVERSE, LEAD), 1.0) / bearings.INCH_POUND
    words = f"the screw's own inertia takes {alone:.2f} in-lb in 1 s; the rest is not printed"
    e.number("acceleration", None, words)
    for kind, (count, torque) in rows.items():
        ends = (count * torque,) * 2
        budget = TorqueBudget(e.printed("screw"), e.printed("nut"), ends, e.printed("acceleration"))
        e.number(f"bearings_{kind}", ends[0])
        e.number(f"constant_{kind}", budget.constant_speed)
        e.number(f"start_{kind}", budget.start_up)


# --- chapter 5


def _drive(e: Findings) -> None:
    """Compute the entries of section 5.1."""
    warming = unloading_warming(bearings.axis(), bearings.STRETCH, bearings.EXPANSION) / bearings.DEG_F
    e.numbers(
        {
            "lead": 1e3 * LEAD,
            "speed": 60.0 * TRAVERSE / bearings.INCH,
            "base": 35.0,
            "counts": COUNTS,
            "motor": MOTOR,
            "rpm": angular_speed(TRAVERSE, LEAD) / bearings.RPM,
            "resolution": 1e6 * LEAD / COUNTS / bearings.INCH,
            "preload_750": REDUCED / bearings.POUND,
        }
    )
    e.claim("five", 4.5 < warming < 5.0, f"{warming:.2f} degF")


def _torque_tests(e: Findings) -> None:
    """Compute the entries of section 5.2.1: sums of printed parts against the tests."""
    off = {}
    for kind in KINDS:
        for when in ("start", "constant"):
            key = f"{when}_{kind}"
            predicted = value_of("smith-4.3", key)
            off[key] = float(error_percent(predicted, e.printed(key)))
            e.number(key, predicted, "sum of the printed parts")
        e.number(f"used_{kind}", 100.0 * e.printed(f"start_{kind}") / MOTOR)
    words = ", ".join(f"{v:+.1f} %" for v in off.values())
    e.claim("torque_10", all(abs(v) <= 10.0 for v in off.values()), words)
    single = [float(error_percent(value_of(t, "M"), value_of(t, "M_test"))) for t in ("smith-2.3", "smith-3")]
    e.claim("torque_10_single", all(abs(v) <= 10.0 for v in single), ", ".join(f"{v:+.0f} %" for v in single))
    ball, taper = (value_of(t, "M_test") for t in ("smith-2.3", "smith-3"))
    e.claim("four_times", 3.5 <= taper / ball <= 4.0, f"{taper / ball:.1f} times")
    e.number("disparity", 4.0 * 2.0 / 3.0, f"measured {2.0 * taper / (3.0 * ball):.2f}")


def _stiffness_tests(e: Findings) -> None:
    """Compute the entries of section 5.2.2: the tests with the correct topology, and the claim as printed."""
    off = []
    for kind in KINDS:
        right = topology(end_state(kind, "left", "stretch").stiffness) / bearings.POUND_PER_INCH
        measured, predicted = e.printed(f"S_{kind}"), value_of("smith-4.2", f"total_{kind}")
        off.append(float(error_percent(predicted, measured)))
        words = f"printed prediction {off[-1]:+.2f} %, right topology {float(error_percent(right, measured)):+.0f} %"
        e.number(f"S_{kind}", right, words)
    e.claim("within_2.5", all(abs(v) <= 2.5 for v in off), ", ".join(f"{v:+.2f} %" for v in off))
    e.number("six", float(error_percent(e.printed("S_ball"), e.printed("S_taper"))))


def _heat(e: Findings) -> None:
    """Compute the entries of section 5.2.4."""
    torque = {
        "rise_ball": value_of("smith-2.3", "M_test_3"),
        "rise_nut": value_of("smith-4.3", "nut"),
        "rise_taper": value_of("smith-3", "M_test_2"),
    }
    a_pound = {key: e.printed(key) / value for key, value in torque.items()}
    spread = float(error_percent(max(a_pound.values()), min(a_pound.values())))
    e.claim("rise_order", spread < 15.0, f"degF per in-lb alike to {spread:.0f} %")
    ratio = e.printed("rise_taper") / e.printed("rise_ball")
    e.claim("three_times", 2.5 <= ratio <= 3.5, f"{ratio:.2f}")


def unseating_load(preload: float) -> float:
    """Return the load [N] on the carriage at mid-length that unloads the outer row of an end of a stretched screw.

    The end must be pulled inwards by more than the tension, by as much as its rows still carry. It takes half of the
    load.
    """
    share = support_loads(bearings.axis(), 0.5 * bearings.axis().length, 1.0)[0]
    return (lift_off_force(bearings.bearing_set("taper", "left", preload)) - pull()) / share


def _reduced(e: Findings) -> None:
    """Compute the entries of section 5.3."""
    for end in ("left", "right"):
        printed = printed_loads("taper", end, "stretch", (REDUCED / bearings.POUND,) * 2)
        ours = end_state("taper", end, "stretch", REDUCED)
        for i in range(2):
            e.number(f"{end}_stretch_{i + 1}", float(ours.loads[i]) / bearings.POUND, as_printed=printed[i])
        for load in ("750", "1500"):
            total = sum(e.printed(f"t{load}_{end}_{i}") for i in (1, 2))
            e.number(f"t{load}_{end}", total)
    e.number("rise_750", e.printed("t750_left") / e.printed("t1500_left") * 20.0)
    least = e.printed("left_stretch_1")
    words = f"load on the carriage in the middle; {bearings.APPLIED / bearings.POUND:.0f} lbf is applied in 4.2"
    e.number("unseat", unseating_load(REDUCED) / bearings.POUND, words, as_printed=2.0 * least)


def chapter_5(e: Findings, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """Compute all entries of chapter 5."""
    for fill in (_drive, _torque_tests, _stiffness_tests, _heat, _reduced):
        fill(e)
