"""Lin 3.4 and 4.3 in the report: two balls of a ball screw, a whole screw in time, bearings in pairs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from rollbench.comparison.models.study import Study
from rollbench.comparison.printed.printed_data import entry
from rollbench.comparison.sources.lin.evidence.assumptions_3_4 import (
    AS_CASE,
    AS_TEXT,
    SOURCE_RULE,
    UNCOUPLED,
    bearing_rows,
    implied_contact_load,
    onset_rows,
    oversize_text,
    oversized,
    reading_rows,
    run_rows,
)
from rollbench.comparison.sources.lin.evidence.screw import AMPLITUDES, THETA
from rollbench.comparison.sources.lin.evidence.source_cases import four_point, lin_3_4_4, plain
from rollbench.comparison.sources.lin.sections.friction_screw_figures import bearing_figure, map_figure, run_figure
from rollbench.comparison.wings.evidence.registry import evidence
from rollbench.comparison.wings.evidence.sections.finding_table import printed_table
from rollbench.reports.records import Section, Table, Text

# --- tables

TABLES = ("lin-3.6", "lin-3.7", "lin-3.4.4", "lin-4.2", "lin-4.3")
NOTES = {
    "lin-3.7": "Open: the load state behind the numbers is not printed, and the text as it stands gives others.",
    "lin-3.4.4": "Compared with the band that the assumptions give; the right value is that of theta = 3 deg.",
}


def table_of(study: Study, name: str) -> Table:
    """One printed table with what is computed for it."""
    short = name.removeprefix("lin-")
    title = f"Section {short}" if short in ("3.4.4", "4.3") else f"Table {short}"
    return printed_table(f"friction-{name}", f"{title}: printed and computed", evidence(study, name), NOTES.get(name, ""))


def readings_table() -> Table:
    """Readings of Table 3.7 side by side."""
    printed = {case: [entry("lin-3.7", f"{what}_{case}").printed for what in ("force", "increase")] for case in THETA}
    note = (
        f"Printed: {', '.join(f'{force} N and {increase} % ({case})' for case, (force, increase) in printed.items())}. "
        "Oversize is of the ball's radius; it was chosen so "
        "that the printed force and increase agree on the contact load, and is nowhere in the source."
    )
    return Table.of("friction-readings", "Table 3.7 in plain and inferred readings", reading_rows(), note)


def run_table() -> Table:
    """Sensitivity of the whole run to what 3.4.4 does not print."""
    largest, at, none_at = (entry("lin-3.4.4", key).printed for key in ("largest", "largest_at", "none_at"))
    note = (
        f"Printed: {largest} % at {at}°, no contact at {none_at}°, four groups. The third row is the same "
        "run by root finding as in the source, where neighbours touch if they are near and approach when "
        "alone (3.77): overlapping balls that separate count as free, and fewer forces are found. The rows "
        f"below change one assumption at a time from theta = 3°, {lin_3_4_4().force[0]:g} N, "
        f"{oversize_text()} oversize, loads not coupled, over one turn of the nut in steps of 7.2°. A run "
        "that loses no contact within that turn has no entry there."
    )
    return Table.of("friction-run-sensitivity", "Whole screw: what the assumptions change", run_rows(), note)


def bearing_table() -> Table:
    """Table 4.2's bearings: ratio of torques under varied assumptions."""
    note = (
        f"Printed for the four-point bearing: {entry('lin-4.3', 'ratio_4p').printed}. Friction coefficient "
        f"{four_point().groove.mu:g} and the freedom to tilt are assumed; the "
        "ratio does not depend on the friction coefficient. Range of load angles read off the source's figure."
    )
    return Table.of("friction-bearings", "Bearings of Table 4.2: torque over load angle", bearing_rows(), note)


def onset_table(study: Study) -> Table:
    """4.3.2: how soon balls meet, by kind of error and by how unloaded balls move."""
    note = (
        "Screw of Table 4.1, errors of 5 µm, 1000 N, evenly spaced balls at their instantaneous speeds. The "
        "conclusion of 4.3.2 depends on unloaded balls being slow: if they roll along at the nominal speed "
        "it no longer holds."
    )
    title = "Pitch against roundness error: when balls meet (4.3.2)"
    return Table.of("friction-onset", title, onset_rows(study), note)


def introduction(pairs: Table, runs: Table) -> Text:
    """Text on the tables of readings and of the whole run."""
    return Text((_of_the_pair(pairs), _of_the_run(runs)))


def _of_the_pair(pairs: Table) -> str:
    rows = {str(row["reading"]): row for row in pairs.rows}
    loose, coupled = rows[UNCOUPLED], rows[AS_TEXT]
    uncoupled, moved = (
        " and ".join(f"{100.0 + float(row[f'error_{case}'] or 0.0):.0f} %" for case in THETA) for row in (loose, coupled)
    )
    return (
        "The source does not print the load state of the pair in 3.4.3. Read literally (no oversize, "
        f"{plain().force[0]:g} N along the axis), one diagonal carries nearly all: {uncoupled} of the printed "
        f"forces (cases a and b), {moved} where friction moves the balls and loads a third contact. Printed "
        f"force and increase together imply a contact load of {implied_contact_load():.0f} N per ball, "
        f"against {float(coupled['load_a'] or 0.0):.0f} N here; {oversize_text()} of oversize would give "
        f"{float(rows[oversized()]['load_a'] or 0.0):.0f} N. The literal reading is compared with the "
        "printed numbers; the inferred one is shown with it and labelled so, because its oversize was "
        "inferred from these numbers."
    )


def _of_the_run(runs: Table) -> str:
    cases = [row for row in runs.rows if row["assumption"] == AS_CASE]
    source = next(row for row in runs.rows if row["assumption"] == SOURCE_RULE)
    at, none_at = (entry("lin-3.4.4", key).printed for key in ("largest_at", "none_at"))
    found = "; ".join(
        f"theta of {a:g}°: largest at {row['at']:.0f}°, none from {row['none_at']:.0f}°"
        for a, row in zip(AMPLITUDES, cases, strict=True)
    )
    ratio = float(source["largest"] or 0.0) / float(cases[-1]["largest"] or np.nan)
    return (
        "The run of 3.4.4 also needs amplitude, phase and pattern of theta, oversize, start and return "
        f"tube: all are assumptions, varied below. Printed are {at}° for the largest torque and {none_at}° "
        f"for the end of contact; {found}. With the source's rule for contact between balls the largest "
        f"torque ratio is {ratio:.2f} of the one by complementarity at the same theta, with balls that "
        "overlap. This may be why the printed ratio is smaller; it does not explain the angles."
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
