"""Lin 3.4 and 4.3 in the report: two balls of a ball screw, a whole screw in time, bearings in pairs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from math import degrees, radians

import numpy as np

from compare.evidence.screw import (
    AMPLITUDES,
    ANGLES,
    ENDS,
    IDLE,
    SCREWS,
    SHORT,
    TABLES,
    THETA,
    Ours,
    cut,
    findings_of,
    increase,
    onset,
    ours,
    run,
    settled,
    variation,
)
from compare.measure import error_percent
from compare.models.study import Study
from compare.printed.findings import entry, sentences
from compare.sections.friction_screw_figures import bearing_figure, map_figure, run_figure
from lowfi.as_source.run import simulate_by_root
from lowfi.friction.bearing.pairs import DIAGONAL, OTHER, BearingCase, Row, double_row, four_point, torque_curve
from lowfi.friction.screw.groove import Mode
from lowfi.friction.screw.pair import INFERRED_OVERSIZE, SHIFTED, Pair, inferred, plain, solve_pair, table_3_6
from lowfi.friction.screw.run import Run, RunResult, RunSummary, groups, lin_3_4_4, simulate, summarise
from reports.records import Cell, Column, Section, Table, Text

# --- tables

COLUMNS = (
    Column("label", "quantity or claim", "", "s"),
    Column("printed", "printed", "", "s"),
    Column("as_printed", "inferred reading", "", "g5"),
    Column("right", "right (plain reading)", "", "g5"),
    Column("inferred_error", "inferred against printed", "%", ".2f"),
    Column("error", "error of the right value", "%", ".2f"),
    Column("class", "class", "", "s"),
    Column("verdict", "verdict", "", "s"),
    Column("remark", "remark", "", "s"),
)


def printed_rows(values: dict[str, dict[str, Ours]], table: str) -> list[dict[str, Cell]]:
    """Rows of a printed table; an entry from elsewhere in the text says where from."""
    rows: list[dict[str, Cell]] = []
    found = findings_of({table: values[table]})
    usual = Counter(f.printed.place for f in found).most_common(1)[0][0]
    for f in found:
        p, own = f.printed, values[table].get(f.printed.key, Ours())
        off = None if own.inferred is None or p.value is None else float(error_percent(own.inferred, p.value))
        error, where = f.error_percent, "" if p.place == usual else f" ({p.place.removeprefix('Lin (2019), ')})"
        rows.append(
            {
                "label": (p.claim or p.label) + where + (f" [{p.unit}]" if p.unit else ""),
                "printed": p.printed or "–",
                "as_printed": own.inferred,
                "right": own.value,
                "inferred_error": off,
                "error": None if error is None else round(error, 9) + 0.0,
                "class": p.cls,
                "verdict": f.verdict,
                "remark": sentences(own.evidence, p.remark, p.origin and f"Band: {p.origin}"),
            }
        )
    return rows


def printed_table(values: dict[str, dict[str, Ours]], table: str) -> Table:
    """One printed table with ours beside it."""
    rows, columns = printed_rows(values, table), list(COLUMNS)
    if all(row["as_printed"] is None for row in rows):
        labels = {"right": "right", "error": "error"}
        columns = [
            replace(c, label=labels.get(c.key, c.label)) for c in COLUMNS if c.key not in ("as_printed", "inferred_error")
        ]
        rows = [{c.key: row[c.key] for c in columns} for row in rows]
    notes = {
        "lin-3.7": "Open: the load state behind the numbers is not printed, and the text as it stands gives others.",
        "lin-3.4.4": "Held against the band of the assumptions' results; the right value is that of theta = 3 deg.",
    }
    name = table.removeprefix("lin-")
    title = f"Section {name}" if name in ("3.4.4", "4.3") else f"Table {name}"
    return Table(f"friction-{table}", f"{title}: printed and ours", columns, rows, notes.get(table, ""))


def readings() -> list[tuple[str, str, Callable[[float], Pair]]]:
    """Readings of Table 3.7: kind, what is assumed, the pair of a theta [rad]."""

    def wide(make: Callable[[float], Pair], **changes: object) -> Callable[[float], Pair]:
        return lambda theta: replace(make(theta), **changes)  # type: ignore[arg-type]

    radial = wide(plain, free="r", force=(100.0,), coupling="none")
    half, more = 0.5 * INFERRED_OVERSIZE, 1.5 * INFERRED_OVERSIZE
    one, faulty = (1.0, 0.0, 0.0, 0.0), table_3_6(hertz="as printed")
    return [
        ("plain", "text as it stands, friction moves the balls", plain),
        ("plain, varied", "loads not coupled to friction", wide(plain, coupling="none")),
        ("plain, varied", "friction moves balls and screw", wide(plain, coupling="ball and screw")),
        ("plain, varied", "50 N radially on each ball, not coupled", radial),
        ("inferred", "1.7 µm oversize, not coupled", inferred),
        ("inferred, varied", "1.7 µm, friction moves the balls", wide(inferred, coupling="ball")),
        ("inferred, varied", "1.7 µm, friction moves balls and screw", wide(inferred, coupling="ball and screw")),
        ("inferred, varied", "half the oversize", wide(inferred, oversize=half)),
        ("inferred, varied", "one and a half times the oversize", wide(inferred, oversize=more)),
        ("inferred, varied", "1.7 µm, 25 N instead of 50 N", wide(inferred, force=(25.0,))),
        ("inferred, varied", "1.7 µm, 100 N instead of 50 N", wide(inferred, force=(100.0,))),
        ("inferred, varied", "1.7 µm, theta on one contact of the screw", wide(inferred, pattern=(one, one))),
        ("inferred, varied", "1.7 µm, screw's groove shifted sideways", wide(inferred, pattern=(SHIFTED, SHIFTED))),
        ("inferred, varied", "1.7 µm, Hertz constants of Table B.1", wide(inferred, groove=faulty)),
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
    note = (
        "Printed: 1.92 N and 39.2 % (a), 2.89 N and 60.2 % (b). Oversize is of the ball's radius; it was chosen so "
        "that the printed force and increase agree on the contact load, and is nowhere in the source."
    )
    return Table("friction-readings", "Table 3.7 in plain and inferred readings", columns, rows, note)


def run_changes() -> list[tuple[str, str, dict[str, object]]]:
    """What is varied in the whole run: assumption, value in words, changes of the run."""
    changes: list[tuple[str, str, dict[str, object]]] = [("theta", "3°, 7.2° of the nut a step", {})]
    changes += [("theta", f"{a:g}°", {"amplitude": radians(a)}) for a in (1.0, 2.0, 2.5, 4.0)]
    changes += [("axial force", f"{f:g} N", {"force": (f,)}) for f in (500.0, 3000.0)]
    changes += [("oversize", f"{o:g} µm", {"oversize": 1e-6 * o}) for o in (0.0, 1.0, 2.5)]
    changes += [
        ("oversize and coupling", "0 µm, friction moves balls and screw", {"oversize": 0.0, "coupling": "ball and screw"}),
        ("coupling", "1.7 µm, friction moves balls and screw", {"coupling": "ball and screw"}),
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
    """The same run the source's way: what touches is decided from the motions apart, and gaps may become negative."""
    r = simulate_by_root(run)
    ratio, touching = r.ball_torque / r.groove_torque, r.ball_force > 0.0
    top, angle = int(np.argmax(ratio)), np.degrees(r.nut_angle)
    later = np.flatnonzero(~touching.any(axis=1) & (np.arange(angle.size) > top))
    torque = r.groove_torque[1:]
    overlap = 100.0 * r.overlap / run.groove.pair.spacing
    return {
        "assumption": "the source's rule of contact",
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
        summary_row("as the case study", f"{n}, 1.7 µm, {run(a).run.steps} steps", run(a))
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
    note = (
        "Printed: 49.6 % at 126°, no contact at 306°, four groups. The third row is the same run by root finding as in "
        "the source, where neighbours touch if they are near and close in when alone (3.77): overlapping balls that "
        "part count as free, and fewer forces are found. Below these rows one assumption at a time "
        "is changed from theta = 3°, 1500 N, 1.7 µm oversize, loads not coupled, over one turn of the nut in steps of "
        "7.2°. A run that loses no contact within that turn has no entry there."
    )
    return Table("friction-run-sensitivity", "Whole screw: what the assumptions change", columns, rows, note)


def bearing_cases() -> list[tuple[str, str, BearingCase]]:
    """Bearings of 4.3.1 under varied assumptions."""
    face = (Row(-6e-3, DIAGONAL), Row(6e-3, OTHER))
    four = four_point(tilt=True)
    faulty: Mode = "as printed"
    out = [("four-point", "tilt free, no clearance", four), ("four-point", "tilt held", four_point())]
    out += [
        ("four-point", f"ball {100 * p:.0f} % of a distance off the load's plane", replace(four, phase=p))
        for p in (0.25, 0.5)
    ]
    out += [("four-point", f"clearance {1e6 * c:g} µm", replace(four, clearance=c)) for c in (-1e-6, 2e-6, 5e-6)]
    out += [
        ("four-point", "Hertz constants as Table B.1", replace(four, groove=replace(four.groove, hertz=faulty))),
        ("four-point", "force 2 mm off the middle", replace(four, arm=2e-3)),
        ("double row", "tilt free, back to back", double_row(tilt=True)),
        ("double row", "tilt held", double_row()),
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
        "Printed for the four-point bearing: 5.69. Friction coefficient 0.1 and the freedom to tilt are assumed; the "
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


INTRODUCTION: Sequence[str] = (
    "The source does not print the load state of the pair in 3.4.3. Taken at its word (no oversize, 50 N along the "
    "axis) one diagonal carries nearly all: a quarter to a third of the printed forces, half of them where friction "
    "moves the balls and loads a third contact. Printed force and increase together imply nearly twice that contact "
    "load, which 1.7 µm of oversize would give. The plain reading is held against the "
    "printed numbers; the inferred one stands beside it, labelled so, because its oversize comes from these very "
    "numbers.",
    "The run of 3.4.4 needs the amplitude, phase and pattern of theta, oversize, start and return tube besides: all "
    "are assumptions, varied below. Torque ratio, groups and course in time come out within them. With amplitudes "
    "of 2 and 3 degrees both nut angles come earlier than printed; the largest torque comes later only where there is "
    "hardly any contact (1 µm of oversize, a longer return tube). The source's own rule of what touches gives about "
    "two thirds of the torque that complementarity gives, with balls that overlap: it may be why the printed ratio "
    "is smaller, but it does not bring the angles.",
)


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report."""
    step("printed numbers of 3.4 and 4.3")
    values = ours(study)
    tables = {t: printed_table(values, t) for t in TABLES}
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
            Text(INTRODUCTION),
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
