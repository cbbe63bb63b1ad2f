"""Sections 3.4 and 4.3 under varied assumptions: readings of Table 3.7, the whole run, bearings of Table 4.2, errors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from math import degrees, radians

import numpy as np

from rollbench.compare.cases.lin.evidence import source_cases
from rollbench.compare.cases.lin.evidence.screw import (
    AMPLITUDES,
    ANGLES,
    SCREWS,
    THETA,
    cut,
    increase,
    onset,
    screw_run,
    settled,
    variation,
)
from rollbench.compare.measure import error_percent
from rollbench.compare.models.study import Study
from rollbench.compare.printed.printed_data import value_of
from rollbench.lowfi.friction.as_source.run import simulate_by_root
from rollbench.lowfi.friction.bearing.pairs import DIAGONAL, OTHER, BallRow, BearingCase, torque_curve
from rollbench.lowfi.friction.screw.groove import Mode
from rollbench.lowfi.friction.screw.motion import Coupling
from rollbench.lowfi.friction.screw.pair import SHIFTED, Pair, PairMap, implied_load, oversize_map, solve_pair
from rollbench.lowfi.friction.screw.run import Run, RunSummary, equal_steps, summarise
from rollbench.lowfi.friction.screw.travel import History, groups
from rollbench.reports.content import Quantity, Row

#: Ends of the range [deg] that the ratio of torques of 4.3.1 is taken over.
ENDS = (10.0, 18.0, 30.0)
#: Steps and time [s] of the runs in the sensitivity table: one turn of the nut, 7.2 degrees a step.
SHORT = {"steps": 50, "duration": 1.0}
#: Velocities of unloaded balls over the nominal one.
IDLE = (0.0, 0.5, 0.9, 1.0)
#: Labels of rows that the introduction quotes.
AS_TEXT, UNCOUPLED = "text as it stands, friction moves the balls", "loads not coupled to friction"
AS_CASE, SOURCE_RULE = "as the case study", "the source's rule of contact"
#: Oversizes [m] and axial loads [N] of the maps of a pair.
OVERSIZE, AXIAL = tuple(np.linspace(-1e-6, 3e-6, 17)), (25.0, 50.0, 100.0, 200.0)


def oversize_text() -> str:
    """The inferred oversize in words."""
    return f"{1e6 * source_cases.inferred_oversize():g} µm"


def oversized() -> str:
    """Label of the inferred reading."""
    return f"{oversize_text()} oversize, not coupled"


def readings() -> list[tuple[str, str, Callable[[float], Pair]]]:
    """Readings of Table 3.7: kind, what is assumed, the pair of a theta [rad]."""

    def wide(make: Callable[[float], Pair], **changes: object) -> Callable[[float], Pair]:
        return lambda theta: replace(make(theta), **changes)  # type: ignore[arg-type]

    radial = wide(source_cases.plain, free="r", force=(100.0,), coupling="none")
    smaller, larger = 0.5 * source_cases.inferred_oversize(), 1.5 * source_cases.inferred_oversize()
    size = oversize_text()
    one, faulty = (1.0, 0.0, 0.0, 0.0), source_cases.table_3_6(hertz="as printed")
    return [
        ("plain", AS_TEXT, source_cases.plain),
        ("plain, varied", UNCOUPLED, wide(source_cases.plain, coupling="none")),
        ("plain, varied", "friction moves balls and screw", wide(source_cases.plain, coupling="ball and screw")),
        ("plain, varied", "50 N radially on each ball, not coupled", radial),
        ("inferred", oversized(), source_cases.inferred),
        ("inferred, varied", f"{size}, friction moves the balls", wide(source_cases.inferred, coupling="ball")),
        (
            "inferred, varied",
            f"{size}, friction moves balls and screw",
            wide(source_cases.inferred, coupling="ball and screw"),
        ),
        ("inferred, varied", "half the oversize", wide(source_cases.inferred, oversize=smaller)),
        ("inferred, varied", "one and a half times the oversize", wide(source_cases.inferred, oversize=larger)),
        ("inferred, varied", f"{size}, 25 N instead of 50 N", wide(source_cases.inferred, force=(25.0,))),
        ("inferred, varied", f"{size}, 100 N instead of 50 N", wide(source_cases.inferred, force=(100.0,))),
        ("inferred, varied", f"{size}, theta on one contact of the screw", wide(source_cases.inferred, pattern=(one, one))),
        (
            "inferred, varied",
            f"{size}, screw's groove shifted sideways",
            wide(source_cases.inferred, pattern=(SHIFTED, SHIFTED)),
        ),
        ("inferred, varied", f"{size}, Hertz constants of Table B.1", wide(source_cases.inferred, groove=faulty)),
    ]


def reading_rows() -> list[Row]:
    """Table 3.7 in each reading: force [N], increase [%], a ball's load [N], error of the force [%]."""
    rows = list[Row]()
    for kind, label, make in readings():
        row: Row = {Quantity("kind", "reading", "", "s"): kind, Quantity("reading", "assumptions", "", "s"): label}
        good = True
        for case, theta in THETA.items():
            r = solve_pair(make(radians(theta)))
            off = float(error_percent(r.force, value_of("lin-3.7", f"force_{case}")))
            row |= {
                Quantity(f"force_{case}", f"force, θ = {theta:g}°", "N", ".3f"): r.force,
                Quantity(f"error_{case}", f"against printed, θ = {theta:g}°", "%", ".1f"): off,
                Quantity(f"increase_{case}", f"increase, θ = {theta:g}°", "%", ".1f"): increase(r),
                Quantity(f"load_{case}", f"contact load a ball, θ = {theta:g}°", "N", ".0f"): float(r.load.mean()),
            }
            good = good and r.converged
        rows.append(row | {"status": "converged" if good else "not converged"})
    return rows


def implied_contact_load() -> float:
    """Contact load [N] of a ball that the printed force and increase of case a imply together."""
    force, increase = (value_of("lin-3.7", f"{what}_a") for what in ("force", "increase"))
    return implied_load(source_cases.inferred(radians(THETA["a"])), force, 1e-2 * increase)


@cache
def pair_map(case: str, coupling: Coupling) -> PairMap:
    """Force and increase of a case of Table 3.7 over ``OVERSIZE`` and ``AXIAL``."""
    return oversize_map(
        replace(source_cases.inferred(radians(THETA[case])), coupling=coupling), np.array(OVERSIZE), np.array(AXIAL)
    )


def run_changes() -> list[tuple[str, str, dict[str, object]]]:
    """What is varied in the whole run: assumption, label of its value, changes of the run."""
    changes: list[tuple[str, str, dict[str, object]]] = [("theta", "3°, 7.2° of the nut a step", {})]
    changes += [("theta", f"{a:g}°", {"amplitude": radians(a)}) for a in (1.0, 2.0, 2.5, 4.0)]
    changes += [("axial force", f"{f:g} N", {"force": (f,)}) for f in (500.0, 3000.0)]
    changes += [("oversize", f"{o:g} µm", {"oversize": 1e-6 * o}) for o in (0.0, 1.0, 2.5)]
    changes += [
        ("oversize and coupling", "0 µm, friction moves balls and screw", {"oversize": 0.0, "coupling": "ball and screw"}),
        ("coupling", f"{oversize_text()}, friction moves balls and screw", {"coupling": "ball and screw"}),
        ("phase of theta", "90°", {"phase": 0.5 * np.pi}),
        ("phase of theta", "180°", {"phase": np.pi}),
        ("pattern", "groove shifted sideways", {"pattern": SHIFTED}),
        ("first ball", "an eighth of a distance back", {"first": 0.375}),
        ("return tube", "one ball long", {"tube": source_cases.table_3_6().pair.spacing}),
        ("time step", "3.6° of the nut", {"steps": 100}),
    ]
    return changes


#: What a row on the whole run says.
RUN = (
    Quantity("assumption", "assumption", "", "s"),
    Quantity("value", "value", "", "s"),
    Quantity("largest", "largest ball-to-ball over groove torque", "%", ".1f"),
    Quantity("at", "at nut angle", "°", ".0f"),
    Quantity("none_at", "no contact at", "°", ".0f"),
    Quantity("groups", "groups at most", "", "s"),
    Quantity("variation", "variation of groove torque, from step 2", "%", ".1f"),
    Quantity("torque", "mean groove torque", "N mm", ".2f"),
    Quantity("steps", "steps converged", "", "s"),
)


def summary_row(label: str, value: str, r: History) -> Row:
    """Row of the sensitivity table."""
    s: RunSummary = summarise(r)
    touches = s.largest > 0.0
    at, none_at = s.at if touches else None, s.none_at if touches and np.isfinite(s.none_at) else None
    torque, steps = 1e3 * float(settled(r).mean()), f"{int(r.converged.sum())} of {r.converged.size}"
    values = label, value, 100.0 * s.largest, at, none_at, s.groups, 100.0 * variation(r), torque, steps
    return dict(zip(RUN, values, strict=True))


def source_run_row(run: Run) -> Row:
    """The same run by the method of the source: motions without contact decide what touches, gaps may become negative."""
    r = simulate_by_root(run)
    ratio, touching = r.ball_torque / r.groove_torque, r.ball_force > 0.0
    top, angle = int(np.argmax(ratio)), np.degrees(r.nut_angle)
    later = np.flatnonzero(~touching.any(axis=1) & (np.arange(angle.size) > top))
    torque, none_at = r.groove_torque[1:], float(angle[later[0]]) if later.size else None
    overlap = 100.0 * r.overlap / run.groove.pair.spacing
    value = f"as the case study, 3°; balls overlap in {r.overlapping} steps, by up to {overlap:.1f} % of their size"
    spread, steps = 100.0 * float(np.ptp(torque) / torque.mean()), f"{len(r.status) - r.failures} of {len(r.status)}"
    first = SOURCE_RULE, value, 100.0 * float(ratio[top]), float(angle[top]), none_at
    values = *first, int(np.max(groups(touching))), spread, 1e3 * float(torque.mean()), steps
    return dict(zip(RUN, values, strict=True))


def run_rows() -> list[Row]:
    """The whole run as the case study, by the source's rule of contact, and with one assumption changed at a time."""
    names = [f"theta of {a:g}°" for a in AMPLITUDES]
    rows = [
        summary_row(AS_CASE, f"{n}, {oversize_text()}, {screw_run(a).steps} steps", screw_run(a))
        for n, a in zip(names, AMPLITUDES, strict=True)
    ]
    rows.append(source_run_row(source_cases.lin_3_4_4()))
    rows += [
        summary_row(name, value, equal_steps(source_cases.lin_3_4_4(**(SHORT | new)))) for name, value, new in run_changes()
    ]
    return rows


def bearing_cases() -> list[tuple[str, str, BearingCase]]:
    """Bearings of 4.3.1 under varied assumptions."""
    face = (BallRow(-6e-3, DIAGONAL), BallRow(6e-3, OTHER))
    four = source_cases.four_point(tilt=True)
    faulty: Mode = "as printed"
    out = [
        ("four-point", "tilt free, no clearance", four),
        ("four-point", "tilt held", source_cases.four_point(tilt=False)),
    ]
    out += [
        ("four-point", f"ball {100 * p:.0f} % of a distance off the load's plane", replace(four, phase=p))
        for p in (0.25, 0.5)
    ]
    out += [("four-point", f"clearance {1e6 * c:g} µm", replace(four, clearance=c)) for c in (-1e-6, 2e-6, 5e-6)]
    out += [
        ("four-point", "Hertz constants as Table B.1", replace(four, groove=replace(four.groove, hertz=faulty))),
        ("four-point", "force 2 mm off the middle", replace(four, arm=2e-3)),
        ("double row", "tilt free, back to back", source_cases.double_row(tilt=True)),
        ("double row", "tilt held", source_cases.double_row(tilt=False)),
        ("double row", "tilt free, face to face", source_cases.double_row(tilt=True, rows=face)),
    ]
    return out


def bearing_rows() -> list[Row]:
    """Bearings of Table 4.2: torque [N mm] without angle, ratio of torques over ranges of the load's angle."""
    rows = list[Row]()
    for bearing, label, case in bearing_cases():
        found = torque_curve(case, ANGLES)
        torque = Quantity("torque", "torque at 0°", "N mm", ".1f")
        row: Row = {"bearing": bearing, "assumption": label, torque: 1e3 * float(found.torque[0])}
        row |= {
            Quantity(f"to_{end:g}", f"largest over smallest, 0 to {end:g}°", "", ".3f"): cut(found, end) for end in ENDS
        }
        upto = found.angle <= radians(18.0) * (1.0 + 1e-12)
        status = "converged" if found.converged.all() else "not converged"
        four = Quantity("four", "balls beyond two contacts, to 18°", "", "s")
        rows.append(row | {four: int(found.four[upto].max()), "status": status})
    return rows


def onset_rows(study: Study) -> list[Row]:
    """4.3.2: how soon balls meet, by kind of error and by how unloaded balls move."""
    rows = list[Row]()
    for errors in SCREWS:
        for idle in IDLE:
            o = onset(study, errors, idle)
            meet, first = int(np.isfinite(o.meeting).sum()), degrees(o.first) if np.isfinite(o.first) else None
            rows.append(
                {
                    "errors": errors,
                    Quantity("idle", "speed of unloaded balls over nominal", "", "g2"): idle,
                    Quantity("lost", "balls without load", "", "s"): int((o.loaded == 0.0).sum()),
                    Quantity("meet", "neighbours that close in", "", "s"): f"{meet} of {o.meeting.size}",
                    Quantity("first", "first meeting, nut angle", "°", "g4"): first,
                    "status": "converged" if o.converged else "not converged",
                }
            )
    return rows
