"""Geometric errors: the cases of Lin 2.4.2, alone and combined, random ones as ensembles with bands."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from compare.measure import load_error
from compare.models.ensemble import EnsembleResult, run_ensemble
from compare.models.study import Study
from compare.printed.findings import Finding, collect, entry, share
from compare.sections.cases import FINDING_COLUMNS, finding_rows, loads, ratio
from meshes.parts import SIDES
from meshes.section import groove_section
from reports.records import Cell, Column, Figure, Panel, Section, Series, Table

#: Change of a load, in per cent of the mean load, from which a distribution counts as significantly changed: twice the
#: largest error that the source reports of its own model (5.38 %).
SIGNIFICANT = 2.0 * 5.38


def two_point(load: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> bool:
    """Every ball carries on SL and NR and nothing on SR and NL."""
    return bool(np.all(load[:, [0, 3]] > 0.0) and not np.any(load[:, [1, 2]] > 0.0))


def single_findings(study: Study) -> list[Finding]:
    """Numbers and claims of 2.4.2 that need no ensemble; the others stay open."""
    table = "lin-2.4.2"
    base = study.solve("lin-case1")
    groove = groove_section(study.scene("lin-case1"))
    profile, pitch = study.solve("lin-profile"), study.solve("lin-pitch")
    little, much = load_error(profile.load, base.load), load_error(pitch.load, base.load)
    found = {
        "gamma_low": Finding(entry(table, "gamma_low"), value=groove.gamma_1 / np.pi, evidence="Lin C.5"),
        "gamma_high": Finding(entry(table, "gamma_high"), value=groove.gamma_2 / np.pi, evidence="Lin C.5"),
        "profile_two_point": Finding(
            entry(table, "profile_two_point"),
            holds=two_point(profile.load),
            evidence=f"SL {share(profile.load[:, 0] > 0)}, SR {share(profile.load[:, 1] > 0)} loaded",
        ),
        "pitch_two_point": Finding(
            entry(table, "pitch_two_point"),
            holds=two_point(pitch.load),
            evidence=f"SL {share(pitch.load[:, 0] > 0)}, SR {share(pitch.load[:, 1] > 0)} loaded",
        ),
        "profile_little": Finding(
            entry(table, "profile_little"),
            holds=little.max_percent < SIGNIFICANT,
            evidence=f"largest change {little.max_percent:.2f} % of the mean load (pitch errors: {much.max_percent:.1f} %)",
        ),
        "pitch_much": Finding(
            entry(table, "pitch_much"),
            holds=much.max_percent > SIGNIFICANT,
            evidence=f"largest change {much.max_percent:.1f} % of the mean load, ball {much.ball} {much.side}",
        ),
    }
    return collect(table, found)


def findings(study: Study, random: EnsembleResult, combined: EnsembleResult) -> list[Finding]:
    """Numbers and claims of 2.4.2, random ones over the drawn screws."""
    table = "lin-2.4.2"
    base = study.solve("lin-case1")
    kept = np.array([two_point(load) for load in random.loads])
    changed = np.array([load_error(load, base.load).max_percent for load in random.loads])
    four = np.array([bool(np.any(load[:, [1, 2]] > 0.0)) for load in combined.loads])
    drawn = {
        "random_two_point": Finding(
            entry(table, "random_two_point"),
            holds=bool(kept.mean() > 0.05),
            evidence=f"holds in {share(kept)} drawn screws",
        ),
        "random_much": Finding(
            entry(table, "random_much"),
            holds=bool((changed > SIGNIFICANT).mean() > 0.05),
            evidence=f"largest change {np.percentile(changed, 5):.0f} to {np.percentile(changed, 95):.0f} % of the "
            f"mean load in nine of ten drawn screws; significant in {share(changed > SIGNIFICANT)}",
        ),
        "combined_four_point": Finding(
            entry(table, "combined_four_point"),
            holds=bool(four.mean() > 0.05),
            evidence=f"some ball carries on SR or NL in {share(four)} drawn screws",
        ),
    }
    return [drawn.get(f.printed.key, f) for f in single_findings(study)]


def band(label: str, ensemble: EnsembleResult, side: int) -> Series:
    """Band from the 5th to the 95th percentile of a side's loads over the ball number."""
    low, high = np.percentile(ensemble.loads[:, :, side], [5.0, 95.0], axis=0)
    balls = [float(i + 1) for i in range(low.size)]
    return Series(label, balls, [float(x) for x in low], "band", [float(x) for x in high])


def section_with_findings(study: Study, step: Callable[[str], None]) -> tuple[Section, list[Finding]]:
    """Section of the report, and the findings that its ensembles decide."""
    step("profile and pitch errors")
    base, profile, pitch = (study.solve(n) for n in ("lin-case1", "lin-profile", "lin-pitch"))
    ensembles = {}
    for name in ("lin-random", "lin-combined"):
        step(f"{study.scene(name).members} drawn screws of {name}")
        ensembles[name] = run_ensemble(study.scene(name))
    random, combined = ensembles["lin-random"], ensembles["lin-combined"]
    one, all_three = study.solve("lin-random"), study.solve("lin-combined")
    left = Panel(
        "one kind of error at a time, SL = NR",
        "ball",
        "contact load / N",
        (
            loads("no errors (case 1)", base, 0, emphasis=True),
            loads("profile errors", profile, 0),
            loads("pitch errors", pitch, 0),
            loads("random ball radii, one draw", one, 0),
            band("random, 5 to 95 %", random, 0),
        ),
        integer_x=True,
    )
    right = Panel(
        "all three together",
        "ball",
        "contact load / N",
        (
            loads("SL, one draw", all_three, 0, emphasis=True),
            loads("SR, one draw", all_three, 1),
            band("SL, 5 to 95 %", combined, 0),
            band("SR, 5 to 95 %", combined, 1),
        ),
        integer_x=True,
    )
    columns = (
        Column("scene", "scene", "", "s"),
        Column("members", "drawn screws", "", "s"),
        Column("side", "side", "", "s"),
        Column("low", "largest load, 5 %", "N", ".1f"),
        Column("mid", "median", "N", ".1f"),
        Column("high", "95 %", "N", ".1f"),
        Column("ratio", "max/min, median", "", ".3f"),
        Column("lost", "balls without load, mean", "", ".2f"),
        Column("bad", "not converged", "", "s"),
    )
    rows: list[dict[str, Cell]] = []
    for name, e in ensembles.items():
        for s in (0, 1):
            largest = e.loads[:, :, s].max(axis=1)
            low, mid, high = np.percentile(largest, [5, 50, 95])
            ratios = [ratio(load[:, s]) for load in e.loads]
            rows.append(
                {
                    "scene": name,
                    "members": len(e.loads),
                    "side": SIDES[s],
                    "low": float(low),
                    "mid": float(mid),
                    "high": float(high),
                    "ratio": float(np.median(ratios)) if s == 0 else None,
                    "lost": float((e.loads[:, :, s] == 0.0).sum(axis=1).mean()),
                    "bad": sum(x != "converged" for x in e.statuses),
                }
            )
    changes: list[dict[str, Cell]] = []
    for name in ("lin-case2", "lin-profile", "lin-pitch", "lin-random", "lin-combined"):
        r = study.solve(name)
        e2 = load_error(r.load, base.load)
        changes.append(
            {
                "scene": name,
                "max": float(r.load.max()),
                "ratio": ratio(r.load[:, 0]),
                "change": e2.max_percent,
                "rms": e2.rms_percent,
                "ball": f"{e2.ball} {e2.side}",
                "third": int((r.load[:, 1] > 0).sum()),
            }
        )
    found = findings(study, random, combined)
    section = Section(
        "errors",
        "Geometric errors (2.4.2)",
        (
            Table("errors-claims", "What 2.4.2 prints, and what we find", FINDING_COLUMNS, finding_rows(found)),
            Figure(
                "errors-loads",
                "Load distribution with geometric errors",
                (left, right),
                f"Bands: 5th to 95th percentile per ball, {len(random.loads)} and {len(combined.loads)} drawn screws.",
            ),
            Table(
                "errors-changes",
                "Change against case 1 (random ones: the draw of the shipped seed)",
                (
                    Column("scene", "scene", "", "s"),
                    Column("max", "largest load", "N", ".1f"),
                    Column("ratio", "max/min on SL", "", ".3f"),
                    Column("change", "largest change", "% of mean", ".2f"),
                    Column("rms", "RMS change", "% of mean", ".2f"),
                    Column("ball", "at ball", "", "s"),
                    Column("third", "balls loaded on SR", "", "s"),
                ),
                changes,
            ),
            Table("errors-bands", "Random errors as ensembles", columns, rows),
        ),
    )
    return section, found
