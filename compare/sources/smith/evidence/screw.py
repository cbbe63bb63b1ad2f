"""Smith, chapters 4 and 5: the axis with its supports, and the tests of it."""

from __future__ import annotations

from functools import cache

import numpy as np

from rollbench.comparison.measure import error_percent
from rollbench.comparison.models.study import Study
from rollbench.comparison.scenes.units import parse
from rollbench.comparison.sources.smith.evidence import layouts
from rollbench.comparison.sources.smith.evidence.case import (
    APPLIED,
    DEG_F,
    DIRECTIONS,
    EXPANSION,
    INCH,
    INCH_POUND,
    NUT,
    POUND,
    POUND_PER_INCH,
    PRELOAD,
    PSI,
    STRETCH,
    axis,
    bearing_set,
)
from rollbench.comparison.wings.evidence.entries import Entries
from rollbench.comparison.wings.evidence.record import Evidence
from rollbench.lowfi.bearings import as_printed
from rollbench.lowfi.bearings.axis import (
    TorqueBudget,
    acceleration_torque,
    angular_speed,
    axis_stiffness,
    shaft_inertia,
    shaft_stiffness,
    support_loads,
    tension,
    unloading_warming,
)
from rollbench.lowfi.bearings.sets import SetState, equilibrium

#: Lead [m] and rapid traverse [m/s] of 5.1, counts a turn, torque of the motor [in-lbf], reduced preload of 5.3 [N].
LEAD, TRAVERSE = parse("14 mm", "length"), 800.0 * INCH / 60.0
COUNTS, MOTOR, REDUCED = 40000.0, 159.0, parse("750 lbf", "force")
#: Density of steel [kg/m^3], for the inertia that the source does not print.
STEEL = 7850.0
KINDS = ("ball", "taper")


def pull() -> float:
    """Tension [N] of the stretched screw between rigid supports: the load of either end."""
    return tension(axis(), STRETCH)


@cache
def end_state(kind: str, end: str, state: str, preload: float = PRELOAD) -> SetState:
    """Equilibrium of the set of an end: "preload", after the "stretch", or with the load "applied" at mid-screw."""
    rows = bearing_set(kind, end, preload)
    if state == "preload":
        return equilibrium(rows)
    force = pull() if state == "stretch" else _ends(pull())[end]
    return equilibrium(rows, force)


def _ends(tensile: float) -> dict[str, float]:
    """Thrust [N] of either end with the load of 4.2 on the nut in the middle, towards the left end."""
    left, right = support_loads(axis(), 0.5 * axis().length, -APPLIED, tensile)
    return {"left": left, "right": right}


def printed_loads(kind: str, end: str, state: str, preload: tuple[float, ...]) -> list[float]:
    """Loads [lbf] of the rows by the source's sharing from its preload [lbf]: half the stretch an end, all of it a side."""
    loads = as_printed.shared_loads(preload, DIRECTIONS[kind][end], 0.5 * round(pull() / POUND, -1))
    if state == "applied":
        sign = -1.0 if end == "left" else 1.0
        loads = as_printed.shared_loads(list(loads), DIRECTIONS[kind][end], sign * 0.5 * APPLIED / POUND)
    return [float(v) for v in loads]


# --- sections


def section_4_1(study: Study) -> tuple[Evidence, ...]:  # noqa: ARG001 - every table takes the study
    """Stretch and warming."""
    e = Entries("smith-4.1")
    a = axis()
    diameter = 2.0 * float(np.sqrt(a.area / np.pi))
    e.numbers(
        {
            "L": a.length / INCH,
            "d": diameter / INCH,
            "stretch": STRETCH / INCH,
            "expansion": EXPANSION * DEG_F,
            "E": a.young / PSI,
            "eps": STRETCH / a.length,
            "dT": unloading_warming(a, STRETCH, EXPANSION) / DEG_F,
        }
    )
    stiff = {kind: end_state(kind, "left", "stretch").stiffness for kind in KINDS}
    elastic = [tension(axis(k, k), STRETCH) / POUND for k in stiff.values()]
    words = f"{elastic[0]:.0f} and {elastic[1]:.0f} lbf if the stretch is of the ends and the bearings give way"
    e.number("F", pull() / POUND, words)
    e.number("F_end", pull() / POUND, as_printed=0.5 * round(pull() / POUND, -1))
    return e.evidence()


def section_4_2(study: Study) -> tuple[Evidence, ...]:
    """Loads and stiffness of the supports, stiffness of the axis."""
    e = Entries("smith-4.2")
    for kind in KINDS:
        for end in DIRECTIONS[kind]:
            _support(e, kind, end)
    a = axis()
    least = float(shaft_stiffness(a, 0.5 * a.length))
    e.numbers({"screw": least / POUND_PER_INCH / 1e6, "nut": NUT / POUND_PER_INCH / 1e6})
    e.number("package_ball", end_state("ball", "left", "stretch").stiffness / POUND_PER_INCH / 1e6)
    e.number("package_taper", 2.0 * e.printed("taper_left_stiffness_1"))
    for kind in KINDS:
        e.number(f"rows_{kind}", 2.0 * sum(len(rows) for rows in DIRECTIONS[kind].values()))
    _total(e, "ball", layouts.words(study, layouts.TRIPLEX))
    _total(e, "taper", layouts.words(study, layouts.TAPERED))
    places = np.linspace(0.0, a.length, 53)[1:-1]
    both_ends, one = shaft_stiffness(a, places), shaft_stiffness(axis(right=0.0), places)
    at = float(places[int(np.argmin(both_ends))] / a.length)
    e.claim("middle", abs(at - 0.5) < 0.01, f"least at {at:.2f} L")
    ratio = both_ends / one
    middle = float(ratio[ratio.size // 2])
    scenes = [layouts.by_scene(study, x, 0.5).stiffness for x in (layouts.TRIPLEX, layouts.SUPPORTED)]
    words = f"ratio {ratio.min():.2f} to {ratio.max():.0f}, {middle:.1f} in the middle"
    words += f"; as scenes, between triplex sets and with one, {scenes[0] / scenes[1]:.2f} in the middle"
    e.claim("supported", bool(np.all(ratio > 1.0)), words)
    return e.evidence()


def _support(e: Entries, kind: str, end: str) -> None:
    """Loads and stiffnesses of the rows of one end."""
    count = len(DIRECTIONS[kind][end])
    preload = tuple(e.printed(f"{kind}_{end}_preload_{i + 1}") for i in range(count))
    for state in ("preload", "stretch", "applied"):
        ours = end_state(kind, end, state)
        printed = None if state == "preload" else printed_loads(kind, end, state, preload)
        for i in range(count):
            key = f"{kind}_{end}_{state}_{i + 1}"
            e.number(key, float(ours.loads[i]) / POUND, as_printed=None if printed is None else printed[i])
    ours = end_state(kind, end, "applied")
    for i in range(count):
        e.number(f"{kind}_{end}_stiffness_{i + 1}", float(ours.row_stiffness[i]) / POUND_PER_INCH / 1e6)
    total = sum(e.printed(f"{kind}_{end}_stiffness_{i + 1}") for i in range(count))
    words = f"equilibrium gives {ours.stiffness / POUND_PER_INCH / 1e6:.2f}e6 lbf/in"
    e.number(f"{kind}_{end}_package", total, words)


def topology(supports: float) -> float:
    """Right stiffness [N/m] of the carriage in the middle, on equal supports [N/m]."""
    a = axis(supports, supports)
    return float(axis_stiffness(a, 0.5 * a.length, NUT))


def _total(e: Entries, kind: str, as_scenes: str) -> None:
    """Stiffness of the axis as printed, and in the right topology with the printed and with our bearings."""
    package, screw, nut = (e.printed(k) for k in (f"package_{kind}", "screw", "nut"))
    printed = as_printed.series_stiffness((package, package), screw, nut)
    right = topology(1e6 * package * POUND_PER_INCH) / POUND_PER_INCH / 1e6
    ours = topology(end_state(kind, "left", "stretch").stiffness) / POUND_PER_INCH / 1e6
    off = float(error_percent(printed, right))
    words = f"right topology, printed parts {right:.3f}, our bearings {ours:.3f}; the sum in series {off:+.0f} %"
    e.number(f"total_{kind}", right, f"{words}; {as_scenes}", as_printed=printed)


def section_4_3(study: Study) -> tuple[Evidence, ...]:  # noqa: ARG001 - every table takes the study
    """Torque budget."""
    e = Entries("smith-4.3")
    parts = Entries("smith-2.3"), Entries("smith-3")
    rows = {"ball": (3, parts[0].printed("M")), "taper": (2, parts[1].printed("M"))}
    e.number("nut", 18.0)
    shaft = shaft_inertia(STEEL, 2.0 * float(np.sqrt(axis().area / np.pi)), axis().length)
    alone = acceleration_torque([shaft], angular_speed(TRAVERSE, LEAD), 1.0) / INCH_POUND
    words = f"the screw's own inertia takes {alone:.2f} in-lb in 1 s; the rest is not printed"
    e.number("acceleration", None, words)
    for kind, (count, torque) in rows.items():
        ends = (count * torque,) * 2
        budget = TorqueBudget(e.printed("screw"), e.printed("nut"), ends, e.printed("acceleration"))
        e.number(f"bearings_{kind}", ends[0])
        e.number(f"constant_{kind}", budget.constant_speed)
        e.number(f"start_{kind}", budget.start_up)
    return e.evidence()
