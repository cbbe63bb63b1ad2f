"""Stability of friction and ball motion at extremes: the source's root finding against least dissipation and chains.

Every case of ours is solved from its own start and from random ones; it must converge, balance power in and
dissipation, and give the same answer each time. The source's way is a root of the force balance under its sigmoid from
random starts: for one ball at the loads of the same case, for several as ``lowfi.as_source.starts`` does it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict

from compare.extremes.friction_balls import ball_rows
from compare.extremes.friction_chains import chain_rows
from compare.extremes.tally import CHAIN_STARTS, FAR, NEAR, STARTS, Record
from reports.records import Cell, Column, Table, Text


def rows() -> list[Record]:
    """The whole table."""
    return [*ball_rows(), *chain_rows()]


COLUMNS = (
    Column("group", "what is varied", "", "s"),
    Column("model", "model", "", "s"),
    Column("cases", "cases", "", "s"),
    Column("ours", "ours, solved from all starts", "", "s"),
    Column("energy", "power in over dissipation, less 1", "", "g2"),
    Column("spread", "spread over the starts", "", "g2"),
    Column("source", "source's root finding, solved", "", "s"),
    Column("note", "note", "", "s"),
)


def table_section_items(found: Sequence[Record] | None = None) -> tuple[Text | Table, ...]:
    """The table and what it says, for a section of the report; ``found``: rows made before."""
    found = rows() if found is None else found
    cells = list[dict[str, Cell]]()
    for r in found:
        theirs = "–" if r.source is None else f"{r.source} of {r.source_tries}"
        cells.append(asdict(r) | {"ours": f"{r.ours} of {r.tries}", "source": theirs})
    shown = [{c.key: row[c.key] for c in COLUMNS} for row in cells]
    tried = [r for r in found if r.source is not None]
    text = (
        f"Ours solved {sum(r.ours for r in found)} of {sum(r.tries for r in found)}; the source's root finding "
        f"{sum(r.source or 0 for r in tried)} of {sum(r.source_tries or 0 for r in tried)}. It fails most in rotary "
        "and linear bearings (from most starts, near two-point contact from nearly all) and in pairs of a screw with "
        "clearance. What touches, it decides from the motions apart (Lin 3.31, 3.77), so that most roots of longer "
        "chains let balls overlap; these do not count as solved.",
    )
    note = (
        "Each case is solved from the solver's own start and from random ones. Spread: of the loss of one ball, or of "
        "ball-to-ball forces over the largest friction bound. The source's way: a root of the force balance under its "
        "sigmoid, k_S = 100 unless varied, by MINPACK's hybrid method with a short first step, which finds more roots "
        f"than its default; one ball: {STARTS} starts within {FAR:.0%} of the solution unless said otherwise; pairs "
        f"and chains: rolling and {CHAIN_STARTS} starts within {FAR:.0%} ({NEAR:.0%} for chains of a screw). A chain "
        "of a screw that Newton does not reach from a random start is begun anew from the solver's own. Where friction "
        "between balls leaves more than one state (jammed or apart), the one is meant that develops as it rises from none; "
        "a ball of a screw that bears next to no load in clearance may also float or be wedged by its own friction, and "
        "where the search begins decides: there the restarts keep the loads that were found."
    )
    return (Text(text), Table("friction-extremes", "Friction and ball motion: extreme cases", COLUMNS, shown, note))
