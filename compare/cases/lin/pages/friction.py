"""Lin 3.2 and 3.3 in the report: one ball in a rotary bearing, balls in contact in a linear bearing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import degrees

import numpy as np

from rollbench.compare.cases.lin.evidence.rotary_linear import (
    AXIAL,
    CASES,
    K_F,
    LINEAR,
    PRINTED_LAW,
    ROTARY,
    VERTICAL,
    as_printed,
    balance_rows,
    right,
    sensitivity_rows,
)
from rollbench.compare.cases.lin.extremes import pair_rows, root_rows
from rollbench.compare.evidence.computations import evidence
from rollbench.compare.measure import error_percent
from rollbench.compare.models.study import Study
from rollbench.compare.printed.printed_data import entry, value_of
from rollbench.compare.sections.curves import numbers
from rollbench.compare.sections.verdicts import printed_table
from rollbench.lowfi.friction.bearing import SIDES, Solution, sweep
from rollbench.lowfi.friction.linear.chain import BothModels, PairMaps, maps
from rollbench.reports.content import Figure, Panel, Section, Series, Table, Text

# --- tables

TABLES = ("lin-3.2", "lin-3.3", "lin-3.4", "lin-3.5", "lin-G")
#: Significant digits shown; Table 3.2 prints seven.
DIGITS = {"lin-3.2": 7}
NOTES = {
    "lin-3.2": (
        "As printed: Hertz constants by the method of Table B.1 (F = 1, second fundamental form alone), the sigmoid with "
        "k_S = 100, maps interpolated linearly. Right: exact Hertz constants, Coulomb friction, least dissipation. The "
        "error refers to the as-printed value in class as-printed, otherwise to the right one."
    ),
    "lin-3.5": "The times are those of the source's machine and are not compared.",
}


def table_of(study: Study, name: str) -> Table:
    """One printed table with what is computed for it."""
    title = {"lin-G": "Appendix G"}.get(name, f"Table {name.removeprefix('lin-')}")
    digits = DIGITS.get(name, 4)
    found = evidence(study, name)
    return printed_table(f"friction-{name}", f"{title}: printed and computed", found, NOTES.get(name, ""), digits=digits)


def balance_table() -> Table:
    """Cases I to III: torque, power in and out, contacts at rest, by three sets of assumptions."""
    table = Table.of("friction-balance", "Rotary bearing: balance of power", balance_rows())
    worst = max(table.rows, key=lambda row: abs(float(row["balance"] or 0.0)))
    off = float(error_percent(float(worst["loss"] or 0.0), float(worst["input"] or 0.0)))
    note = (
        "The source takes its torque from the dissipation (3.21); interpolation between its maps shifts "
        f"that by {off:+.1f} % from the friction moment in case {worst['case']}. In cases I and II the "
        "sigmoid moves a contact that is at rest under Coulomb friction: the sum of the losses stays, their "
        "distribution over the contacts does not."
    )
    return replace(table, note=note)


def sensitivity_table() -> Table:
    """The linear pair under each assumption on loads and on friction between the balls."""
    printed = entry("lin-3.5", "a_force_numerical")
    table = Table.of("friction-sensitivity", "Linear pair: what the load assumption changes", sensitivity_rows())
    target = printed.value or 0.0
    forces = [float(row["force"] or 0.0) for row in table.rows]
    inside = "lies within" if min(forces) <= target <= max(forces) else "lies outside"
    deviations = " and ".join(f"{entry('lin-3.4', f'a_eps{k}_numerical').printed} %" for k in (1, 2))
    note = (
        "diagonal: the text before (3.54); balanced: in equilibrium at the stated angles; elastic: angles follow the "
        f"loads. The printed force of {printed.printed} N {inside} the range of the assumptions, {min(forces):.2f} to "
        f"{max(forces):.2f} N; Table 3.4 prints deviations of {deviations} for the same case."
    )
    return replace(table, note=note)


# --- stability


def stability_table() -> Table:
    """Summary of the linear pair's extremes."""
    note = "Elastic loads; residual and spread over the largest friction bound of a ball."
    return Table.of("friction-stability", "Linear pair: extreme cases", pair_rows(), note)


def root_table() -> Table:
    """Root finding as printed against least dissipation."""
    note = (
        "At the loads as printed, sigmoid without maps; each of the three unknowns starts off at random. Least "
        "dissipation succeeds only if its loss is the one minimum; it uses Coulomb friction whatever k_S is."
    )
    return Table.of("friction-roots", "Rotary bearing: starts from which the motion is found", root_rows(), note)


# --- figures


def torque_figure() -> Figure:
    """Figure 3.7: forces, torque, losses and motion over the ring's radial displacement."""
    u = 1e-6 * np.concatenate([np.linspace(0.0, 4.0, 9), np.linspace(4.05, 6.0, 40), np.linspace(6.2, 10.0, 20)])
    true, printed = sweep(ROTARY, AXIAL, u), sweep(ROTARY, AXIAL, u, PRINTED_LAW)
    good = np.array([s.motion.status == "exact" for s in printed])
    x, label = numbers(u, 1e6), "u_y / µm"
    marks = [1e6 * v for v in CASES.values()]
    laws = (("right", true, np.ones(u.size, dtype=bool)), ("as printed", printed, good))

    def curves(pick: Callable[[Solution], float], key: str, factor: float = 1.0) -> tuple[Series, ...]:
        drawn = [
            Series(
                name, x, numbers(np.where(ok, [pick(s) for s in found], np.nan), factor), "line", emphasis=name == "right"
            )
            for name, found, ok in laws
        ]
        dots = [value_of("lin-3.2", f"{key}_{case}") for case in CASES]
        return (*drawn, Series("Table 3.2, cases I to III", marks, dots, "markers"))

    losses = [Series(side, x, [float(s.motion.friction.loss[i]) for s in true], "line") for i, side in enumerate(SIDES)]
    panels = (
        Panel("sum of contact forces", label, "force / N", curves(lambda s: s.load.force.sum(), "F_sum"), zero=True),
        Panel("friction torque", label, "torque / N mm", curves(lambda s: s.torque, "torque", 1e3), zero=True),
        Panel("right: friction loss of each contact", label, "loss / W", losses, zero=True),
        Panel("rotation of the ball, ω_x", label, "ω_x / rad/s", curves(lambda s: s.motion.q[1], "omega_x")),
    )
    missing = int(np.sum(~good))
    caption = (
        "Once four contacts carry load, torque rises several times faster than force: the light contacts first slide "
        "(steep part), then all spin (after the bend). With exact Hertz constants the bend comes earlier, so case II, "
        "which is just before it as printed, lies beyond it. The printed sum of forces of case III lies below the curve: "
        f"a misprint. Gaps: the source's root was not found at {missing} of {u.size} points."
    )
    return Figure("friction-torque", "Rotary bearing: forces, torque, losses and motion over u_y", panels, caption)


def velocity_panel(case: str, s: Solution, title: str) -> Panel:
    """Velocity of the ball against each loaded groove along the contact's major axis."""
    x = np.linspace(-1.0, 1.0, 3)
    curves = []
    for i in np.flatnonzero(s.load.force > 0.0):
        _, vz, spin = (float(v) for v in s.motion.motion[i])
        velocity = vz - spin * x * float(s.at.a[i])
        curves.append(Series(SIDES[i], numbers(x), numbers(velocity, 1e3), "line"))
    return Panel(f"case {case}, {title}", "x / a", "velocity / mm/s", curves)


def velocity_figure() -> Figure:
    """Figure 3.8 as curves: cases I to III, right and as printed."""
    panels = [velocity_panel(case, right(case), "right") for case in CASES]
    panels += [velocity_panel(case, as_printed(case), "as printed") for case in CASES]
    caption = (
        "A slope is spin, a zero the centre of rotation, an offset sliding. Case I: one contact rolls (at rest), the "
        "other spins about its centre. As printed, case II slides in IR and OL while OR is nearly at rest; with exact "
        "Hertz constants all four contacts already spin. Case III: all four spin."
    )
    return Figure("friction-velocity", "Velocity along the major axes of the contacts", panels, caption, 3)


def map_panels(m: PairMaps, both: BothModels, label: str) -> list[Panel]:
    """Numerical model, formula and their difference over rho, one curve per theta."""
    x = numbers(m.rho)
    parts = (("numerical", both.numerical), ("formula", both.formula), ("formula less numerical", both.error))
    panels = []
    for title, values in parts:
        curves = [
            Series(f"θ = {degrees(t):+.0f}°", x, numbers(row), "line") for t, row in zip(m.theta, values, strict=True)
        ]
        panels.append(Panel(title, "side force ratio ρ", label, curves))
    return panels


def map_figures() -> tuple[Figure, Figure]:
    """Figures 3.14 and 3.15 as families of curves."""
    m = maps(LINEAR, np.radians([-3.0, -1.0, 1.0, 2.0, 3.0]), np.linspace(-0.6, 0.6, 25), VERTICAL, K_F)
    short = np.abs(m.difference.error).max() / np.abs(m.difference.numerical).max()
    first = Figure(
        "friction-difference",
        "Velocity difference of two balls (Figure 3.14)",
        map_panels(m, m.difference, "ε₁ − ε₂"),
        "The balls close in where the curve is above zero: θ and ρ of opposite sign. The formula is nearly straight in "
        "ρ and falls short by up to "
        f"{short:.0%} of the largest value at the corners.",
        3,
    )
    second = Figure(
        "friction-force",
        "Ball-to-ball force and total over baseline loss (Figure 3.15)",
        [*map_panels(m, m.force, "force / N"), *map_panels(m, m.ratio, "loss ratio")],
        "No force where the balls separate. Where they approach, force and loss grow with both parameters, "
        f"up to {m.force.numerical.max():.2f} N and {100.0 * m.ratio.numerical.max():.1f} % of the baseline (printed as an "
        f"increase of {entry('lin-3.3', 'worst_ratio').printed} %). At the corners the formula's force is "
        f"too small by up to {-m.force.error.min():.2f} N; its ratio is wrong by up to "
        f"{np.abs(m.ratio.error).max():.2f} only, because its baseline is wrong too.",
        3,
    )
    return first, second


INTRODUCTION = (
    "Cases I to III of the rotary bearing come out to every printed digit, except one misprinted sum, when "
    "the source's faults are repeated: F = 1 with the second fundamental form alone in the Hertz constants, "
    "the sigmoid with k_S = 100 on the magnitude of the spin, and friction interpolated linearly between "
    f"maps. Radial displacements of {', '.join(f'{1000000.0 * u:g}' for u in CASES.values())} µm and the "
    "maps' step of 0.08 are not printed; they are inferred, and every number of a case follows from one of "
    "them. The right values use exact Hertz constants and Coulomb friction in closed form.",
    "For the linear pair the source, too, uses exact Hertz constants; misprints in its formulas (exponents "
    "of 3.51) are corrected here. The load state behind the printed "
    f"{entry('lin-3.5', 'a_force_numerical').printed} N stays open; see friction-sensitivity.",
)


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report."""
    step("printed numbers of 3.2, 3.3 and appendix G")
    evidence(study, *TABLES)
    step("torque and velocities of the rotary bearing")
    drawn = [torque_figure(), velocity_figure()]
    step("maps of the linear pair")
    drawn += map_figures()
    step("extreme cases and starts")
    checks = (stability_table(), root_table())
    tables = {t: table_of(study, t) for t in TABLES}
    return Section(
        "friction",
        "Friction and ball motion: one ball in a rotary bearing; balls in contact in a linear bearing",
        (
            Text(INTRODUCTION),
            tables["lin-3.2"],
            balance_table(),
            drawn[0],
            drawn[1],
            tables["lin-3.3"],
            tables["lin-3.4"],
            tables["lin-3.5"],
            sensitivity_table(),
            drawn[2],
            drawn[3],
            tables["lin-G"],
            *checks,
        ),
    )
