"""Section 2.4.1, case studies 1, 2 and 3: printed numbers and claims, with the errors against ANSYS."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.comparison.measure import error_percent, load_error
from rollbench.comparison.models.comparison import PRINTED
from rollbench.comparison.models.study import Study
from rollbench.comparison.printed.printed_data import entry
from rollbench.comparison.sources.lin.reconstruction.combined import predicted
from rollbench.comparison.wings.evidence.record import Evidence, Sheet, count_of
from rollbench.meshes.arrays import Array
from rollbench.meshes.partition import fixed_partition


@dataclass(frozen=True)
class Reading:
    """One reading of the right end: words, its scenes without and with offset, and whether it is the text's own."""

    label: str
    plain: str
    offset: str
    of_text: bool = False


#: Readings of the right end; the others are measured against the first, which the 3D reference has.
READINGS = (
    Reading("ux and uy held", "lin-case3", "lin-case3-offset"),
    Reading("ux, uy and rotations held", "lin-case3-clamped", "lin-case3-offset-clamped"),
    Reading("only ux held", "lin-case3-ux", "lin-case3-offset-ux", of_text=True),
)


CASES = ("lin-case1", "lin-case2", *(name for r in READINGS for name in (r.plain, r.offset)))


def ratio(load: Array) -> float:
    """Largest over smallest load; infinite where a ball is not loaded."""
    return float(load.max() / load.min()) if load.min() > 0.0 else float("inf")


def two_point(load: Array) -> bool:
    """Whether every ball carries on SL and NR and nothing on SR and NL; load ``(n, 4)`` [N]."""
    return bool(np.all(load[:, [0, 3]] > 0.0) and not np.any(load[:, [1, 2]] > 0.0))


def spread_of_choices(study: Study) -> str:
    """Range of the ratio over the beam's partition and the readings of C.8."""
    variants = [
        study.changed("lin-case1", partition=p, section=s)
        for p in ("nodal", "source")
        for s in ("groove", "groove squared")
    ]
    ratios = [ratio(study.solve(v).load[:, 0]) for v in variants]
    return f"{min(ratios):.4f} to {max(ratios):.4f} with the beam's partition and the reading of C.8"


def section_2_4_1(study: Study) -> tuple[Evidence, ...]:
    """Numbers and claims of 2.4.1."""
    sheet = Sheet("lin-2.4.1")
    _case_1(study, sheet)
    _case_2(study, sheet)
    _case_3(study, sheet)
    _against_ansys(study, sheet)
    elements = fixed_partition(study.changed("lin-case1", partition="source")).size - 1
    sheet.number("elements", float(elements), "12 outside + 3 of 15 mm inside + 12 outside")
    times = {k: entry("lin-2.2", k).value or np.nan for k in ("time_ansys_1", "time_proposed_1")}
    sheet.number(
        "speed_ratio",
        times["time_ansys_1"] * 3600.0 / times["time_proposed_1"],
        "arithmetic of Table 2.2, case 1; run times of this project are in section timing",
    )
    return sheet.evidence()


def _case_1(study: Study, sheet: Sheet) -> None:
    load, line = study.solve("lin-case1").load, study.solve("lin-case1").centreline
    mei = study.solve("lin-case1", "mei").load[:, 0]
    lateral = 1e6 * float(np.hypot(line[:, 0], line[:, 1]).max())
    sheet.number("case1_ratio", ratio(load[:, 0]), spread_of_choices(study))
    falling = f"{mei[0]:.1f} N at ball 1 falling at every ball to {mei[-1]:.1f} N at ball 32"
    sheet.claim("case1_mei", bool(np.all(np.diff(mei) < 0.0)), falling)
    sheet.claim("case1_two_point", two_point(load), f"SL {count_of(load[:, 0] > 0)} loaded, SR {count_of(load[:, 1] > 0)}")
    words = f"largest lateral displacement of the centreline {lateral:.2f} um; 0 in the axial-only model"
    sheet.claim("case1_lateral", lateral > 0.1, words)


def _case_2(study: Study, sheet: Sheet) -> None:
    case1, case2 = (study.solve(name).load[:, 0] for name in ("lin-case1", "lin-case2"))
    change = error_percent(case2, case1, float(case1.mean()))
    most = float(np.abs(np.delete(change, 16)).max())
    words = f"ball 17 {change[16]:+.1f} % of the mean load, every other ball within {most:.2f} %"
    sheet.claim("case2_ball17", bool(change[16] > 5.0 * most), words)


def _case_3(study: Study, sheet: Sheet) -> None:
    smallest = [float(study.solve(name).load.min()) for name in CASES[2:]]
    words = f"smallest load of any contact in all readings {min(smallest):.1f} N"
    sheet.claim("case3_four_point", min(smallest) > 0.0, words)
    rise = [study.solve(r.offset).load - study.solve(r.plain).load for r in READINGS]
    last = [int(np.argsort(x[:, 1] + x[:, 2])[-3:].min()) + 1 for x in rise]
    places = ", ".join(f"{ball} and up ({r.label})" for ball, r in zip(last, READINGS, strict=True))
    sheet.claim("case3_last_balls", all(x >= 30 for x in last), f"the three largest rises of SR + NL are at balls {places}")


def _against_ansys(study: Study, sheet: Sheet) -> None:
    """The source's errors against ANSYS: those of its model against the 3D reference, and what readings of the text predict
    that also give its ratio."""
    readings = {p.key: p for p in predicted(study, "own")}
    for name, (largest, rms, _) in PRINTED.items():
        found = study.reference(name)
        if found is None:
            continue
        e = load_error(study.solve(name).load, found.load, found.contacts)
        for key, error, mean in ((largest, e.own_max_percent, e.max_percent), (rms, e.own_rms_percent, e.rms_percent)):
            words = (
                "computed here: the source's model against this project's 3D reference, in per cent of each load "
                f"({mean:.2f} % of the mean load); the source's ANSYS loads are not printed"
            )
            p = readings[key]
            inferred = (
                f"readings that also give the printed ratio: {p.nearest:.2f} %, with the scatter of the source's mesh "
                f"{p.meshed_low:.2f} to {p.meshed_high:.2f} % (section reconstruction; inference)"
            )
            sheet.number(key, error, f"{words}; {inferred}", reading=p.nearest, holds=p.comes_out)
