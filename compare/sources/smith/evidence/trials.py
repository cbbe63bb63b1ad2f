"""Smith, chapter 5: measurements on the axis, claims about them, and the reduced preload of 5.3."""

from __future__ import annotations

from rollbench.comparison.measure import error_percent
from rollbench.comparison.models.study import Study
from rollbench.comparison.sources.smith.evidence.case import (
    APPLIED,
    DEG_F,
    EXPANSION,
    INCH,
    POUND,
    POUND_PER_INCH,
    RPM,
    STRETCH,
    axis,
    bearing_set,
)
from rollbench.comparison.sources.smith.evidence.screw import (
    COUNTS,
    KINDS,
    LEAD,
    MOTOR,
    REDUCED,
    TRAVERSE,
    end_state,
    printed_loads,
    pull,
    topology,
)
from rollbench.comparison.wings.evidence.entries import Entries
from rollbench.comparison.wings.evidence.record import Evidence
from rollbench.lowfi.bearings.axis import angular_speed, support_loads, unloading_warming
from rollbench.lowfi.bearings.sets import lift_off_force


def _drive(e: Entries) -> None:
    """Section 5.1."""
    warming = unloading_warming(axis(), STRETCH, EXPANSION) / DEG_F
    e.numbers(
        {
            "lead": 1e3 * LEAD,
            "speed": 60.0 * TRAVERSE / INCH,
            "base": 35.0,
            "counts": COUNTS,
            "motor": MOTOR,
            "rpm": angular_speed(TRAVERSE, LEAD) / RPM,
            "resolution": 1e6 * LEAD / COUNTS / INCH,
            "preload_750": REDUCED / POUND,
        }
    )
    e.claim("five", 4.5 < warming < 5.0, f"{warming:.2f} degF")


def _torque(e: Entries) -> None:
    """Section 5.2.1: sums of printed parts against the tests."""
    theory = Entries("smith-4.3")
    off = {}
    for kind in KINDS:
        for when in ("start", "constant"):
            key = f"{when}_{kind}"
            predicted = theory.printed(key)
            off[key] = float(error_percent(predicted, e.printed(key)))
            e.number(key, predicted, "sum of the printed parts")
        e.number(f"used_{kind}", 100.0 * e.printed(f"start_{kind}") / MOTOR)
    words = ", ".join(f"{v:+.1f} %" for v in off.values())
    e.claim("torque_10", all(abs(v) <= 10.0 for v in off.values()), words)
    single = [float(error_percent(t.printed("M"), t.printed("M_test"))) for t in (Entries("smith-2.3"), Entries("smith-3"))]
    e.claim("torque_10_single", all(abs(v) <= 10.0 for v in single), ", ".join(f"{v:+.0f} %" for v in single))
    ball, taper = (t.printed("M_test") for t in (Entries("smith-2.3"), Entries("smith-3")))
    e.claim("four_times", 3.5 <= taper / ball <= 4.0, f"{taper / ball:.1f} times")
    e.number("disparity", 4.0 * 2.0 / 3.0, f"measured {2.0 * taper / (3.0 * ball):.2f}")


def _stiffness(e: Entries) -> None:
    """Section 5.2.2: the tests against the right topology, and the claim as it stands."""
    theory = Entries("smith-4.2")
    off = []
    for kind in KINDS:
        right = topology(end_state(kind, "left", "stretch").stiffness) / POUND_PER_INCH / 1e6
        measured, predicted = e.printed(f"S_{kind}"), theory.printed(f"total_{kind}")
        off.append(float(error_percent(predicted, measured)))
        words = f"printed prediction {off[-1]:+.2f} %, right topology {float(error_percent(right, measured)):+.0f} %"
        e.number(f"S_{kind}", right, words)
    e.claim("within_2.5", all(abs(v) <= 2.5 for v in off), ", ".join(f"{v:+.2f} %" for v in off))
    e.number("six", float(error_percent(e.printed("S_ball"), e.printed("S_taper"))))


def _heat(e: Entries) -> None:
    """Section 5.2.4."""
    torque = {
        "rise_ball": Entries("smith-2.3").printed("M_test_3"),
        "rise_nut": Entries("smith-4.3").printed("nut"),
        "rise_taper": Entries("smith-3").printed("M_test_2"),
    }
    a_pound = {key: e.printed(key) / value for key, value in torque.items()}
    spread = float(error_percent(max(a_pound.values()), min(a_pound.values())))
    e.claim("rise_order", spread < 15.0, f"degF per in-lb alike to {spread:.0f} %")
    ratio = e.printed("rise_taper") / e.printed("rise_ball")
    e.claim("three_times", 2.5 <= ratio <= 3.5, f"{ratio:.2f}")


def unseating_load(preload: float) -> float:
    """Load [N] on the carriage, in the middle, that takes the last load off the outer row of an end under stretch.

    The end must be pulled inwards beyond the tension by what its set still holds; half of a load in the middle goes to it.
    """
    share = support_loads(axis(), 0.5 * axis().length, 1.0)[0]
    return (lift_off_force(bearing_set("taper", "left", preload)) - pull()) / share


def _reduced(e: Entries) -> None:
    """Section 5.3."""
    for end in ("left", "right"):
        printed = printed_loads("taper", end, "stretch", (REDUCED / POUND,) * 2)
        ours = end_state("taper", end, "stretch", REDUCED)
        for i in range(2):
            e.number(f"{end}_stretch_{i + 1}", float(ours.loads[i]) / POUND, as_printed=printed[i])
        for load in ("750", "1500"):
            total = sum(e.printed(f"t{load}_{end}_{i}") for i in (1, 2))
            e.number(f"t{load}_{end}", total)
    e.number("rise_750", e.printed("t750_left") / e.printed("t1500_left") * 20.0)
    least = e.printed("left_stretch_1")
    words = f"load on the carriage in the middle; {APPLIED / POUND:.0f} lbf is applied in 4.2"
    e.number("unseat", unseating_load(REDUCED) / POUND, words, as_printed=2.0 * least)


def chapter_5(study: Study) -> tuple[Evidence, ...]:  # noqa: ARG001 - every table takes the study
    """Every entry of chapter 5."""
    e = Entries("smith-5")
    for fill in (_drive, _torque, _stiffness, _heat, _reduced):
        fill(e)
    return e.evidence()
