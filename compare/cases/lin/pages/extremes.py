"""Stability of friction and ball motion at extremes: the source's root finding against least dissipation and chains.

Every case is solved here from the solver's own start and from random ones; it must converge, balance power in and
dissipation, and give the same answer each time. The source's method is a root of the force balance under its sigmoid from
random starts: for one ball at the loads of the same case, for several as ``lowfi.friction.as_source.starts`` does it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict

from rollbench.compare.cases.lin.extremes import CHAIN_STARTS, FAR_START, NEAR_START, STARTS, Record, ball_rows, chain_rows
from rollbench.reports.content import Cell, Quantity, Table, Text


def rows() -> list[Record]:
    """The whole table."""
    return [*ball_rows(), *chain_rows()]


COLUMNS = (
    Quantity("group", "what is varied", "", "s"),
    Quantity("model", "model", "", "s"),
    Quantity("cases", "cases", "", "s"),
    Quantity("ours", "solved here from all starts", "", "s"),
    Quantity("energy", "relative excess of power in over dissipation", "", "g2"),
    Quantity("spread", "spread over the starts", "", "g2"),
    Quantity("source", "source's root finding, solved", "", "s"),
    Quantity("note", "note", "", "s"),
)


def by_model(tried: Sequence[Record]) -> str:
    """How many starts the source's root finding solves, model by model, the worst first."""
    counts: dict[str, tuple[int, int]] = {}
    for r in tried:
        solved, tries = counts.get(r.model, (0, 0))
        counts[r.model] = solved + (r.source or 0), tries + (r.source_tries or 0)
    worst_first = sorted(counts.items(), key=lambda item: item[1][0] / max(item[1][1], 1))
    return "; ".join(f"{model}: {solved} of {tries}" for model, (solved, tries) in worst_first)


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
        f"Solved here: {sum(r.ours for r in found)} of {sum(r.tries for r in found)}; the source's root finding "
        f"{sum(r.source or 0 for r in tried)} of {sum(r.source_tries or 0 for r in tried)}. Model by model, the worst "
        f"first: {by_model(tried)}. It decides which balls touch from their motions without contact (Lin 3.31, 3.77), so "
        "that roots of longer chains may let balls overlap; these do not count as solved.",
    )
    note = (
        "Each case is solved from the solver's own start and from random ones. Spread: of the loss of one ball, or of "
        "ball-to-ball forces over the largest friction bound. The source's method: a root of the force balance under its "
        "sigmoid, k_S = 100 unless varied, by MINPACK's hybrid method with a short first step, which finds more roots "
        f"than its default; one ball: {STARTS} starts within {FAR_START:.0%} of the solution unless said otherwise; pairs "
        f"and chains: rolling and {CHAIN_STARTS} starts within {FAR_START:.0%} ({NEAR_START:.0%} for chains of a screw). A "
        "chain of a screw that Newton does not reach from a random start is restarted from the solver's own. Where "
        "friction between balls leaves more than one state (jammed or apart), the branch reached by continuation from zero "
        "friction is reported; "
        "a ball of a screw that carries almost no load in clearance may also float or be wedged by its own friction, and "
        "where the search begins decides: there the restarts keep the loads that were found."
    )
    return (Text(text), Table("friction-extremes", "Friction and ball motion: extreme cases", COLUMNS, shown, note))
