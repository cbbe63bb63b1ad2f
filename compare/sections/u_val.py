"""Validation uncertainty in the report: error beside u_val, bias and scatter of every model, stated bounds that held."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rollbench.compare.models.comparison import from_result
from rollbench.compare.models.model_form import SHARE
from rollbench.compare.models.modelling import RUNGS, Rung, ladder, left_out_one
from rollbench.compare.models.registry import DEFAULT
from rollbench.compare.models.study import Study
from rollbench.compare.models.uncertainty import (
    CONTACTS,
    INPUTS,
    QUANTITIES,
    Scatter,
    Validated,
    bound_shares,
    scatter,
    validated,
)
from rollbench.compare.reference.levels import LEVELS
from rollbench.compare.sections.applicability import items_of
from rollbench.compare.sections.grid_coverage import coverage
from rollbench.reports.content import Figure, Panel, Quantity, Row, Section, Series, Table, Text

#: Models whose rows are shown scene by scene; bias and scatter are of every one on the ladder.
SHOWN = (DEFAULT, "lin")


def rows_of(study: Study, rungs: Sequence[Rung]) -> list[Validated]:
    """Every rung on every quantity."""
    found = [validated(study, r.scene, r.model, q, from_result(r.result)) for r in rungs for q in QUANTITIES]
    return [row for row in found if row is not None]


def u_val_table(rows: Sequence[Validated]) -> Table:
    """Error and u_val per scene and quantity."""
    cells: list[Row] = []
    for row in rows:
        if row.model not in SHOWN:
            continue
        beyond = abs(row.error) > row.combined
        cells.append(
            {
                "scene": row.scene,
                "quantity": row.quantity,
                "model": row.model,
                Quantity("error", "error E", "%", "+.2f"): row.error,
                Quantity("grid", "grid", "%", ".2f"): row.grid,
                Quantity("choices", "modelling choices", "%", ".2f"): row.choices,
                Quantity("inputs", "input tolerances", "%", ".2f"): row.inputs,
                Quantity("u_val", "u_val", "%", ".2f"): row.combined,
                Quantity("says", "what E says", "", "s"): "E ± u_val is the model's" if beyond else "not told from u_val",
                Quantity("within", "values within u_val", "%", ".0f"): 100.0 * row.within,
                Quantity("varied", "choices varied on", "", "s"): row.varied or "–",
            }
        )
    note = (
        f"Of {CONTACTS}: the contact with the largest error, in per cent of the mean load; other quantities "
        "in per cent of the reference's value. Input tolerances are assumed: "
        f"{'; '.join(x.name for x in INPUTS)}; each is varied by itself, with the model lin. Choices were "
        "varied on two scenes; where the last column names another scene, its largest effect is used. As in "
        "ASME V&V 20, the parts are combined by the root of the sum of squares; nothing is deducted from an "
        "error."
    )
    return Table.of("u-val", "Error and validation uncertainty by scene and quantity", cells, note)


def scatter_table(found: Sequence[Scatter]) -> Table:
    """Bias and scatter by model and quantity."""
    cells: list[Row] = [
        {
            "model": s.model,
            "quantity": s.quantity,
            Quantity("scenes", "scenes", "", "g4"): s.scenes,
            Quantity("values", "values", "", "g4"): s.values,
            Quantity("bias", "bias", "%", "+.2f"): s.bias,
            Quantity("scatter", "scatter", "%", ".2f"): s.scatter,
            Quantity("within", "within u_val", "%", ".0f"): 100.0 * s.within,
            Quantity("within_own", "within grid and choices", "%", ".0f"): 100.0 * s.within_own,
        }
        for s in found
    ]
    note = (
        "Bias: relative deviation of the model from the reference, geometric mean. Scatter: relative "
        "standard deviation of the model without that of the grid. All scenes with a reference, contacts "
        "above a tenth of the mean load."
    )
    return Table.of("bias-scatter", "Bias and scatter of every model", cells, note)


def scatter_figure(found: Sequence[Scatter]) -> Figure:
    """Bias with its scatter, model by model, a panel for each quantity."""
    panels = []
    order = [m.name for m in RUNGS]
    for quantity in dict.fromkeys(s.quantity for s in found):
        of_quantity = [s for s in found if s.quantity == quantity]
        x = [float(order.index(s.model) + 1) for s in of_quantity]
        ends = ([s.bias - 2.0 * s.scatter for s in of_quantity], [s.bias + 2.0 * s.scatter for s in of_quantity])
        series = (
            Series("bias and two scatters", x, [s.bias for s in of_quantity], "markers", emphasis=True, bars=ends),
            Series("none", [min(x), max(x)], [0.0, 0.0], "line"),
        )
        panels.append(Panel(quantity, "", "relative deviation from the reference / %", series, names=order))
    return Figure("bias-scatter", "Bias and scatter of every model", tuple(panels))


def bounds_table(study: Study, rungs: Sequence[Rung]) -> Table:
    """Stated bounds and how many of them held."""
    rows = left_out_one(study, rungs)
    counts = [
        (f"largest error to expect, model {name}, scene left out", held, total)
        for name, (held, total) in bound_shares(rows).items()
    ]
    bars = [h for h in coverage(study) if h.level > min(LEVELS)]
    if bars:
        words = (
            f"discretisation of coarser levels, against the finest, contact loads of {len({h.scene for h in bars})} scenes"
        )
        counts.append((words, sum(h.held for h in bars), sum(h.contacts for h in bars)))
    cells: list[Row] = [
        {
            Quantity("bound", "stated bound", "", "s"): words,
            Quantity("share", "held", "", "s"): f"{held} of {total}",
            Quantity("part", "share", "%", ".0f"): 100.0 * held / (total or 1),
        }
        for words, held, total in counts
    ]
    note = (
        f"Expected errors are set so that each holds {SHARE:.0%} of the other scenes, which promises nothing for a new "
        "one: the count is what is known. A bar of discretisation is one of 95 % and should hold 19 times in 20."
    )
    return Table.of("bounds-held", "Stated bounds, and how many held", cells, note)


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report."""
    title = "How much of an error is the model's: u_val, bias and scatter, applicability"
    step("every rung on every scene with a reference")
    rungs = study.once(ladder)
    if not rungs:
        return Section("u-val", title, (Text(("No run of the 3D reference was found.",)),))
    step("grid, choices and input tolerances of every scene")
    rows = rows_of(study, rungs)
    found = scatter(rows)
    of_loads = {s.model: s for s in found if s.quantity == CONTACTS}
    words = [
        f"{name}: contact loads {s.bias:+.2f} % on average, scatter {s.scatter:.2f} %, {100.0 * s.within:.0f} % of them "
        f"within u_val and {100.0 * s.within_own:.0f} % within the reference's own part of it"
        for name, s in of_loads.items()
        if name in (*SHOWN, "condensed")
    ]
    text = (
        (
            "An error against the reference counts as the model's only as far as it exceeds what the reference, "
            "its choices and the inputs leave open. The three stand beside every error here, combined by the "
            "root of the sum of squares."
        ),
        f"{'; '.join(words)}.",
    )
    items: tuple[Text | Figure | Table, ...] = (
        Text(text),
        u_val_table(rows),
        scatter_table(found),
        scatter_figure(found),
        bounds_table(study, rungs),
        *items_of(study),
    )
    return Section("u-val", title, items)
