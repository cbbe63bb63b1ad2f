"""Lin 3.4 and 4.3 in the report: two balls of a ball screw, a whole screw in time, bearings in pairs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import degrees, radians

import numpy as np

from compare.evidence.registry import evidence
from compare.evidence.screw import (
    AMPLITUDES,
    ANGLES,
    ENDS,
    IDLE,
    SCREWS,
    SHORT,
    THETA,
    cut,
    increase,
    onset,
    run,
    settled,
    variation,
)
from compare.evidence.source_cases import double_row, four_point, inferred, inferred_oversize, lin_3_4_4, plain, table_3_6
from compare.measure import error_percent
from compare.models.study import Study
from compare.printed.printed_data import entry
from compare.sections.finding_table import printed_table
from compare.sections.friction_screw_figures import bearing_figure, map_figure, run_figure
from lowfi.as_source.run import simulate_by_root
from lowfi.friction.bearing.pairs import DIAGONAL, OTHER, BearingCase, Row, torque_curve
from lowfi.friction.screw.groove import Mode
from lowfi.friction.screw.pair import SHIFTED, Pair, implied_load, solve_pair
from lowfi.friction.screw.run import Run, RunResult, RunSummary, groups, simulate, summarise
from reports.records import Cell, Column, Section, Table, Text

# --- tables

TABLES = ("lin-3.6", "lin-3.7", "lin-3.4.4", "lin-4.2", "lin-4.3")
NOTES = {
    "lin-3.7": "Open: the load state behind the numbers is not printed, and the text as it stands gives others.",
    "lin-3.4.4": "Held against the band of the assumptions' results; the right value is that of theta = 3 deg.",
}


#: Labels of rows that the introduction quotes.
AS_TEXT, UNCOUPLED = "text as it stands, friction moves the balls", "loads not coupled to friction"
AS_CASE, SOURCE_RULE = "as the case study", "the source's rule of contact"


def table_of(study: Study, name: str) -> Table:
    """One printed table with what is computed for it."""
    short = name.removeprefix("lin-")
    title = f"Section {short}" if short in ("3.4.4", "4.3") else f"Table {short}"
    return printed_table(f"friction-{name}", f"{title}: printed and computed", evidence(study, name), NOTES.get(name, ""))


def oversize_text() -> str:
    """The inferred oversize in words."""
    return f"{1e6 * inferred_oversize():g} µm"


def oversized() -> str:
    """Label of the inferred reading."""
    return f"{oversize_text()} oversize, not coupled"


def readings() -> list[tuple[str, str, Callable[[float], Pair]]]:
    """Readings of Table 3.7: kind, what is assumed, the pair of a theta [rad]."""

    def wide(make: Callable[[float], Pair], **changes: object) -> Callable[[float], Pair]:
        return lambda theta: replace(make(theta), **changes)  # type: ignore[arg-type]

    radial = wide(plain, free="r", force=(100.0,), coupling="none")
    half, more = 0.5 * inferred_oversize(), 1.5 * inferred_oversize()
    size = oversize_text()
    one, faulty = (1.0, 0.0, 0.0, 0.0), table_3_6(hertz="as printed")
    return [
        ("plain", AS_TEXT, plain),
        ("plain, varied", UNCOUPLED, wide(plain, coupling="none")),
        ("plain, varied", "friction moves balls and screw", wide(plain, coupling="ball and screw")),
        ("plain, varied", "50 N radially on each ball, not coupled", radial),
        ("inferred", oversized(), inferred),
        ("inferred, varied", f"{size}, friction moves the balls", wide(inferred, coupling="ball")),
        ("inferred, varied", f"{size}, friction moves balls and screw", wide(inferred, coupling="ball and screw")),
        ("inferred, varied", "half the oversize", wide(inferred, oversize=half)),
        ("inferred, varied", "one and a half times the oversize", wide(inferred, oversize=more)),
        ("inferred, varied", f"{size}, 25 N instead of 50 N", wide(inferred, force=(25.0,))),
        ("inferred, varied", f"{size}, 100 N instead of 50 N", wide(inferred, force=(100.0,))),
        ("inferred, varied", f"{size}, theta on one contact of the screw", wide(inferred, pattern=(one, one))),
        ("inferred, varied", f"{size}, screw's groove shifted sideways", wide(inferred, pattern=(SHIFTED, SHIFTED))),
        ("inferred, varied", f"{size}, Hertz constants of Table B.1", wide(inferred, groove=faulty)),
    ]


def readings_table() -> Table:
    """Readings of Table 3.7 side by side."""
    rows = list[dict[str, Cell]]()
    for kind, label, make in readings():
        row: dict[str, Cell] = {"kind": kind, "reading": label}
        good = True
        for case, theta in THETA.items():
            r = solve_pair(make(radians(theta)))
            row |= {
                f"force_{case}": r.force,
                f"increase_{case}": increase(r),
                f"load_{case}": float(r.load.mean()),
                f"error_{case}": float(error_percent(r.force, entry("lin-3.7", f"force_{case}").value or np.nan)),
            }
            good = good and r.converged
        rows.append(row | {"status": "converged" if good else "not converged"})
    columns = [Column("kind", "reading", "", "s"), Column("reading", "assumptions", "", "s")]
    for case, theta in THETA.items():
        columns += [
            Column(f"force_{case}", f"force, θ = {theta:g}°", "N", ".3f"),
            Column(f"error_{case}", "against printed", "%", ".1f"),
            Column(f"increase_{case}", f"increase, θ = {theta:g}°", "%", ".1f"),
            Column(f"load_{case}", "contact load a ball", "N", ".0f"),
        ]
    columns.append(Column("status", "status", "", "s"))
    printed = {case: [entry("lin-3.7", f"{what}_{case}").printed for what in ("force", "increase")] for case in THETA}
    note = (
        f"Printed: {', '.join(f'{force} N and {more} % ({case})' for case, (force, more) in printed.items())}. "
        "Oversize is of the ball's radius; it was chosen so "
        "that the printed force and increase agree on the contact load, and is nowhere in the source."
    )
    return Table("friction-readings", "Table 3.7 in plain and inferred readings", columns, rows, note)


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
        ("return tube", "one ball long", {"tube": table_3_6().pair.spacing}),
        ("time step", "3.6° of the nut", {"steps": 100}),
    ]
    return changes


def summary_row(label: str, value: str, r: RunResult) -> dict[str, Cell]:
    """Row of the sensitivity table."""
    s: RunSummary = summarise(r)
    touches = s.largest > 0.0
    return {
        "assumption": label,
        "value": value,
        "largest": 100.0 * s.largest,
        "at": s.at if touches else None,
        "none_at": s.none_at if touches and np.isfinite(s.none_at) else None,
        "groups": s.groups,
        "variation": 100.0 * variation(r),
        "torque": 1e3 * float(settled(r).mean()),
        "steps": f"{int(r.converged.sum())} of {r.converged.size}",
    }


def source_run_row(run: Run) -> dict[str, Cell]:
    """The same run by the method of the source: motions without contact decide what touches, gaps may become negative."""
    r = simulate_by_root(run)
    ratio, touching = r.ball_torque / r.groove_torque, r.ball_force > 0.0
    top, angle = int(np.argmax(ratio)), np.degrees(r.nut_angle)
    later = np.flatnonzero(~touching.any(axis=1) & (np.arange(angle.size) > top))
    torque = r.groove_torque[1:]
    overlap = 100.0 * r.overlap / run.groove.pair.spacing
    return {
        "assumption": SOURCE_RULE,
        "value": f"as the case study, 3°; balls overlap in {r.overlapping} steps, by up to {overlap:.1f} % of their size",
        "largest": 100.0 * float(ratio[top]),
        "at": float(angle[top]),
        "none_at": float(angle[later[0]]) if later.size else None,
        "groups": int(np.max(groups(touching))),
        "variation": 100.0 * float(np.ptp(torque) / torque.mean()),
        "torque": 1e3 * float(torque.mean()),
        "steps": f"{run.steps - r.failures} of {run.steps}",
    }


def run_table() -> Table:
    """Sensitivity of the whole run to what 3.4.4 does not print."""
    names = [f"theta of {a:g}°" for a in AMPLITUDES]
    rows = [
        summary_row(AS_CASE, f"{n}, {oversize_text()}, {run(a).run.steps} steps", run(a))
        for n, a in zip(names, AMPLITUDES, strict=True)
    ]
    rows.append(source_run_row(lin_3_4_4()))
    rows += [summary_row(name, value, simulate(lin_3_4_4(**(SHORT | new)))) for name, value, new in run_changes()]
    columns = (
        Column("assumption", "assumption", "", "s"),
        Column("value", "value", "", "s"),
        Column("largest", "largest ball-to-ball over groove torque", "%", ".1f"),
        Column("at", "at nut angle", "°", ".0f"),
        Column("none_at", "no contact at", "°", ".0f"),
        Column("groups", "groups at most", "", "s"),
        Column("variation", "variation of groove torque, from step 2", "%", ".1f"),
        Column("torque", "mean groove torque", "N mm", ".2f"),
        Column("steps", "steps converged", "", "s"),
    )
    largest, at, none_at = (entry("lin-3.4.4", key).printed for key in ("largest", "largest_at", "none_at"))
    note = (
        f"Printed: {largest} % at {at}°, no contact at {none_at}°, four groups. The third row is the same run by root "
        "finding as in "
        "the source, where neighbours touch if they are near and close in when alone (3.77): overlapping balls that "
        "part count as free, and fewer forces are found. Below these rows one assumption at a time "
        f"is changed from theta = 3°, {lin_3_4_4().force[0]:g} N, {oversize_text()} oversize, loads not coupled, over one "
        "turn of the nut in steps of "
        "7.2°. A run that loses no contact within that turn has no entry there."
    )
    return Table("friction-run-sensitivity", "Whole screw: what the assumptions change", columns, rows, note)


def bearing_cases() -> list[tuple[str, str, BearingCase]]:
    """Bearings of 4.3.1 under varied assumptions."""
    face = (Row(-6e-3, DIAGONAL), Row(6e-3, OTHER))
    four = four_point(tilt=True)
    faulty: Mode = "as printed"
    out = [("four-point", "tilt free, no clearance", four), ("four-point", "tilt held", four_point(tilt=False))]
    out += [
        ("four-point", f"ball {100 * p:.0f} % of a distance off the load's plane", replace(four, phase=p))
        for p in (0.25, 0.5)
    ]
    out += [("four-point", f"clearance {1e6 * c:g} µm", replace(four, clearance=c)) for c in (-1e-6, 2e-6, 5e-6)]
    out += [
        ("four-point", "Hertz constants as Table B.1", replace(four, groove=replace(four.groove, hertz=faulty))),
        ("four-point", "force 2 mm off the middle", replace(four, arm=2e-3)),
        ("double row", "tilt free, back to back", double_row(tilt=True)),
        ("double row", "tilt held", double_row(tilt=False)),
        ("double row", "tilt free, face to face", double_row(tilt=True, rows=face)),
    ]
    return out


def bearing_table() -> Table:
    """Table 4.2's bearings: ratio of torques under varied assumptions."""
    rows = list[dict[str, Cell]]()
    for bearing, label, case in bearing_cases():
        found = torque_curve(case, ANGLES)
        row: dict[str, Cell] = {"bearing": bearing, "assumption": label, "torque": 1e3 * float(found.torque[0])}
        row |= {f"to_{end:g}": cut(found, end) for end in ENDS}
        upto = found.angle <= radians(18.0) * (1.0 + 1e-12)
        status = "converged" if found.converged.all() else "not converged"
        rows.append(row | {"four": int(found.four[upto].max()), "status": status})
    columns = (
        Column("bearing", "bearing", "", "s"),
        Column("assumption", "assumption", "", "s"),
        Column("torque", "torque at 0°", "N mm", ".1f"),
        *(Column(f"to_{end:g}", f"largest over smallest, 0 to {end:g}°", "", ".3f") for end in ENDS),
        Column("four", "balls beyond two contacts, to 18°", "", "s"),
        Column("status", "status", "", "s"),
    )
    note = (
        f"Printed for the four-point bearing: {entry('lin-4.3', 'ratio_4p').printed}. Friction coefficient "
        f"{four_point().groove.mu:g} and the freedom to tilt are assumed; the "
        "ratio does not depend on the friction coefficient. Range of load angles read off the source's figure."
    )
    return Table("friction-bearings", "Bearings of Table 4.2: torque over load angle", columns, rows, note)


def onset_table(study: Study) -> Table:
    """4.3.2: how soon balls meet, by kind of error and by how unloaded balls move."""
    rows = list[dict[str, Cell]]()
    for errors in SCREWS:
        for idle in IDLE:
            o = onset(study, errors, idle)
            rows.append(
                {
                    "errors": errors,
                    "idle": idle,
                    "lost": int((o.loaded == 0.0).sum()),
                    "meet": f"{int(np.isfinite(o.meeting).sum())} of {o.meeting.size}",
                    "first": degrees(o.first) if np.isfinite(o.first) else None,
                    "status": "converged" if o.converged else "not converged",
                }
            )
    columns = (
        Column("errors", "errors", "", "s"),
        Column("idle", "speed of unloaded balls over nominal", "", "g2"),
        Column("lost", "balls without load", "", "s"),
        Column("meet", "neighbours that close in", "", "s"),
        Column("first", "first meeting, nut angle", "°", "g4"),
        Column("status", "status", "", "s"),
    )
    note = (
        "Screw of Table 4.1, errors of 5 µm, 1000 N, evenly spread balls at the speeds of the moment. The conclusion "
        "of 4.3.2 rests on lost balls being slow: where they roll along at the nominal velocity it is gone."
    )
    return Table("friction-onset", "Pitch against roundness error: when balls meet (4.3.2)", columns, rows, note)


def introduction(pairs: Table, runs: Table) -> Text:
    """Text on the tables of readings and of the whole run."""
    return Text((_of_the_pair(pairs), _of_the_run(runs)))


def _of_the_pair(pairs: Table) -> str:
    rows = {str(row["reading"]): row for row in pairs.rows}
    loose, coupled = rows[UNCOUPLED], rows[AS_TEXT]
    part, more = (
        " and ".join(f"{100.0 + float(row[f'error_{case}'] or 0.0):.0f} %" for case in THETA) for row in (loose, coupled)
    )
    force, increase = (entry("lin-3.7", f"{what}_a").value or np.nan for what in ("force", "increase"))
    implied = implied_load(inferred(radians(THETA["a"])), force, 1e-2 * increase)
    return (
        f"The source does not print the load state of the pair in 3.4.3. As the text stands (no oversize, "
        f"{plain().force[0]:g} N along the axis) one diagonal carries nearly all: {part} of the printed forces "
        "(cases a and "
        f"b), {more} where friction moves the balls and loads a third contact. Printed force and increase together imply "
        f"{implied:.0f} N of contact load a ball, against {float(coupled['load_a'] or 0.0):.0f} N; "
        f"{oversize_text()} of oversize would give {float(rows[oversized()]['load_a'] or 0.0):.0f} N. The plain "
        "reading is held against the printed numbers; the inferred one is shown with it, labelled so, because its oversize "
        "was inferred from these numbers."
    )


def _of_the_run(runs: Table) -> str:
    own = [row for row in runs.rows if row["assumption"] == AS_CASE]
    source = next(row for row in runs.rows if row["assumption"] == SOURCE_RULE)
    at, none_at = (entry("lin-3.4.4", key).printed for key in ("largest_at", "none_at"))
    found = "; ".join(
        f"theta of {a:g}°: largest at {row['at']:.0f}°, none from {row['none_at']:.0f}°"
        for a, row in zip(AMPLITUDES, own, strict=True)
    )
    ratio = float(source["largest"] or 0.0) / float(own[-1]["largest"] or np.nan)
    return (
        "The run of 3.4.4 needs the amplitude, phase and pattern of theta, oversize, start and return tube too: all are "
        f"assumptions, varied below. Printed are {at}° for the largest torque and {none_at}° for the end of contact; "
        f"{found}. "
        f"The source's rule of what touches gives {ratio:.2f} of the largest torque ratio that complementarity gives "
        "at the "
        "same theta, with balls that overlap, which may be why the printed ratio is smaller; it does not bring the angles."
    )


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report."""
    step("printed numbers of 3.4 and 4.3")
    tables = {t: table_of(study, t) for t in TABLES}
    step("readings and maps of two balls")
    pairs = (readings_table(), map_figure())
    step("whole screw and what its assumptions change")
    whole = (run_figure(), run_table())
    step("bearings and errors")
    last = (bearing_figure(), bearing_table(), onset_table(study))
    return Section(
        "friction-screw",
        "Friction in a ball screw: two balls, a whole screw, and bearings in pairs",
        (
            introduction(pairs[0], whole[1]),
            tables["lin-3.6"],
            tables["lin-3.7"],
            *pairs,
            tables["lin-3.4.4"],
            *whole,
            tables["lin-4.2"],
            tables["lin-4.3"],
            *last,
        ),
    )
