"""Geometric errors: the cases of Lin 2.4.2, alone and combined, random ones as ensembles with bands."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from rollbench.compare.cases.lin.evidence.chapter_2 import ratio
from rollbench.compare.evidence.computations import evidence
from rollbench.compare.measure import load_error
from rollbench.compare.models.study import Study
from rollbench.compare.sections.curves import load_panel, loads
from rollbench.compare.sections.verdicts import printed_table
from rollbench.compare.studies.members.ensemble import EnsembleResult, of_study
from rollbench.meshes.parts import SIDES
from rollbench.reports.content import Figure, Quantity, Row, Section, Series, Table


def band(label: str, ensemble: EnsembleResult, side: int) -> Series:
    """Band from the 5th to the 95th percentile of a side's loads over the ball number."""
    low, high = np.percentile(ensemble.loads[:, :, side], [5.0, 95.0], axis=0)
    balls = [float(i + 1) for i in range(low.size)]
    return Series(label, balls, [float(x) for x in low], "band", [float(x) for x in high])


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report."""
    step("profile and pitch errors")
    base, profile, pitch = (study.solve(n) for n in ("lin-case1", "lin-profile", "lin-pitch"))
    ensembles = {}
    for name in ("lin-random", "lin-combined"):
        step(f"{study.scene(name).members} drawn screws of {name}")
        ensembles[name] = of_study(study, name)
    random, combined = ensembles["lin-random"], ensembles["lin-combined"]
    one, all_three = study.solve("lin-random"), study.solve("lin-combined")
    left = load_panel(
        "one kind of error at a time, SL = NR",
        loads("no errors (case 1)", base, 0, emphasis=True),
        loads("profile errors", profile, 0),
        loads("pitch errors", pitch, 0),
        loads("random ball radii, one draw", one, 0),
        band("random, 5 to 95 %", random, 0),
    )
    right = load_panel(
        "all three together",
        loads("SL, one draw", all_three, 0, emphasis=True),
        loads("SR, one draw", all_three, 1),
        band("SL, 5 to 95 %", combined, 0),
        band("SR, 5 to 95 %", combined, 1),
    )
    rows: list[Row] = []
    for name, e in ensembles.items():
        for s in (0, 1):
            load = e.loads[:, :, s]
            largest = load.max(axis=1)
            low, mid, high = np.percentile(largest, [5, 50, 95])
            ratios = [ratio(one) for one in load]
            rows.append(
                {
                    "scene": name,
                    Quantity("members", "drawn screws", "", "s"): len(e.loads),
                    "side": SIDES[s],
                    Quantity("low", "largest load, 5 %", "N", ".1f"): float(low),
                    Quantity("mid", "median", "N", ".1f"): float(mid),
                    Quantity("high", "95 %", "N", ".1f"): float(high),
                    Quantity("ratio", "max/min, median", "", ".3f"): float(np.median(ratios)) if s == 0 else None,
                    Quantity("lost", "balls without load, mean", "", ".2f"): float((load == 0.0).sum(axis=1).mean()),
                    Quantity("bad", "not converged", "", "s"): sum(x != "converged" for x in e.statuses),
                }
            )
    changes: list[Row] = []
    for name in ("lin-case2", "lin-profile", "lin-pitch", "lin-random", "lin-combined"):
        r = study.solve(name)
        e2 = load_error(r.load, base.load)
        changes.append(
            {
                "scene": name,
                Quantity("max", "largest load", "N", ".1f"): float(r.load.max()),
                Quantity("ratio", "max/min on SL", "", ".3f"): ratio(r.load[:, 0]),
                Quantity("change", "largest change", "% of mean", ".2f"): e2.max_percent,
                Quantity("rms", "RMS change", "% of mean", ".2f"): e2.rms_percent,
                Quantity("ball", "at ball", "", "s"): f"{e2.ball} {e2.side}",
                Quantity("third", "balls loaded on SR", "", "s"): int((r.load[:, 1] > 0).sum()),
            }
        )
    return Section(
        "errors",
        "Geometric errors (2.4.2)",
        (
            printed_table("errors-claims", "Section 2.4.2: printed and computed", evidence(study, "lin-2.4.2")),
            Figure(
                "errors-loads",
                "Load distribution with geometric errors",
                (left, right),
                f"Bands: 5th to 95th percentile per ball, {len(random.loads)} and {len(combined.loads)} drawn screws.",
            ),
            Table.of("errors-changes", "Change against case 1 (random ones: the draw of the shipped seed)", changes),
            Table.of("errors-bands", "Random errors as ensembles", rows),
        ),
    )
