"""Case studies 1, 2, 3 of Lin 2.4.1: load distributions, centreline, claims, readings of the right end, choices."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from rollbench.compare.cases.lin.evidence import chapter_2
from rollbench.compare.evidence.computations import evidence
from rollbench.compare.measure import load_error
from rollbench.compare.models.registry import DEFAULT
from rollbench.compare.models.study import Study
from rollbench.compare.sections.curves import lateral, load_panel, loads
from rollbench.compare.sections.verdicts import printed_table
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.parts import SIDES, Scene
from rollbench.reports.content import Figure, LoadedScrew, Panel, Quantity, Row, Section, Series, Table, Text


def reference_words(study: Study, name: str) -> str:
    """Text that says which 3D reference a scene has."""
    found = study.reference(name)
    return "none stored" if found is None else f"level {found.runs[-1].level}"


def readings_table(study: Study) -> Table:
    """Extremes of every reading and what it changes against the first, by the source's and the default model."""
    rows: list[Row] = []
    for reading in chapter_2.READINGS:
        for name, first in ((reading.plain, chapter_2.READINGS[0].plain), (reading.offset, chapter_2.READINGS[0].offset)):
            row: Row = {
                "scene": name,
                Quantity("held", "right end", "", "s"): reading.label,
                Quantity("text", "text's reading", "", "s"): "yes" if reading.of_text else "no",
                Quantity("reference", "3D reference", "", "s"): reference_words(study, name),
            }
            for model, words in (("lin", "source's model"), (DEFAULT, "refined model")):
                result = study.solve(name, model)
                e = load_error(result.load, study.solve(first, model).load)
                where = f"{e.ball} {e.side}" if e.max_percent > 0.0 else "–"
                row |= {
                    Quantity(f"{model}_max", f"max, {words}", "N", ".1f"): float(result.load.max()),
                    Quantity(f"{model}_min", f"min, {words}", "N", ".1f"): float(result.load.min()),
                    Quantity(f"{model}_change", f"largest change, {words}", "% of mean", ".2f"): e.max_percent,
                    Quantity(f"{model}_where", f"at ball, {words}", "", "s"): where,
                }
            rows.append(row)
    note = (
        "The text sets only the x-displacement of the last node (2.4.1.3). A bearing there holds the y-displacement too, "
        "which is what the 3D reference was computed for; whether it holds rotations is open. Changes are against the "
        "first reading."
    )
    return Table.of("cases-readings", "Case 3: readings of the right end", rows, note)


# --- case studies 1, 2, 3 of Lin 2.4.1: load distributions, centreline, claims, and what the open choices change


def choice_rows(found: Sequence[chapter_2.Choice]) -> list[Row]:
    """Rows of the table of choices."""
    return [
        {
            "choice": c.label,
            Quantity("max", "max", "N", ".2f"): float(c.result.load.max()),
            Quantity("min", "min", "N", ".2f"): float(c.result.load[:, 0].min()),
            Quantity("ratio", "max/min", "", ".4f"): chapter_2.ratio(c.result.load[:, 0]),
            Quantity("error", "largest change", "% of mean", ".3f"): c.change.max_percent,
            Quantity("rms", "RMS change", "% of mean", ".3f"): c.change.rms_percent,
            Quantity("uz", "axial displacement at the load", "µm", ".2f"): 1e6 * float(c.result.centreline[0, 2]),
            "status": c.result.status,
        }
        for c in found
    ]


def load_table(study: Study) -> Table:
    """Loads of all cases and sides, ball by ball."""
    rows: list[Row] = [{"ball": i + 1} for i in range(32)]
    for name in chapter_2.CASES:
        r = study.solve(name)
        short = name.removeprefix("lin-")
        for s in range(4):
            if not (r.load[:, s] > 0.0).any():
                continue
            load = Quantity(f"{short}-{SIDES[s]}", f"{short.replace('-', ' ')} {SIDES[s]}", "N", ".2f")
            for i, row in enumerate(rows):
                row[load] = float(r.load[i, s])
    return Table.of("cases-loads", "Contact loads of the case studies, ball by ball", rows)


def summary_table(study: Study) -> Table:
    """Largest and smallest load per side, balance and residual of each case."""
    rows: list[Row] = []
    for name in chapter_2.CASES:
        r = study.solve(name)
        assert r.equilibrium is not None
        for s, side in enumerate(SIDES):
            load = r.load[:, s]
            if (load > 0.0).any():
                rows.append(
                    {
                        Quantity("case", "scene", "", "s"): name,
                        "side": side,
                        Quantity("max", "max", "N", ".2f"): float(load.max()),
                        Quantity("min", "min", "N", ".2f"): float(load.min()),
                        Quantity("ratio", "max/min", "", ".4f"): chapter_2.ratio(load),
                        Quantity("ball", "ball of max", "", "s"): int(load.argmax()) + 1,
                        Quantity("residual", "residual", "", "g2"): r.solver.residual,
                        Quantity("force", "force balance", "", "g2"): r.equilibrium.force_residual,
                        Quantity("moment", "moment balance", "", "g2"): r.equilibrium.moment_residual,
                        "status": r.status,
                    }
                )
    note = "Relative to the largest force; the balances sum loads, reactions and forces at the contact points."
    return Table.of("cases-summary", "Case studies: extremes and balance", rows, note)


def pairs_apart(study: Study) -> float:
    """Largest difference of opposite contacts of a ball in all case studies [N]."""
    return max(float(np.abs(study.solve(n).load[:, :2] - study.solve(n).load[:, :1:-1]).max()) for n in chapter_2.CASES)


def figures(study: Study) -> tuple[Figure, ...]:
    """Load distributions of cases 1 to 3 and the centreline of case 1."""
    case1, mei, nut = (study.solve("lin-case1", m) for m in ("lin", "mei", "mei-nut"))
    coarse = study.solve(study.changed("lin-case1", partition="source", section="groove squared"))
    case2 = study.solve("lin-case2")
    first = load_panel(
        "case 1, SL = NR",
        loads("low-order model", case1, 0, emphasis=True),
        loads("source's partition, C.8 without root", coarse, 0),
        loads("Mei, rigid nut", mei, 0),
        loads("Mei, nut as a bar", nut, 0),
    )
    title = f"case 2, SL = NR: {oversized(study.scene('lin-case2'))}"
    second = load_panel(title, loads("case 2", case2, 0, emphasis=True), loads("case 1", case1, 0))
    panels = []
    for reading in chapter_2.READINGS:
        plain, offset = study.solve(reading.plain), study.solve(reading.offset)
        moved = f"offset {1e6 * offset_of(study.scene(reading.offset)):g} µm"
        panels.append(
            load_panel(
                f"case 3, {reading.label} at the right end" + (" (as the text says)" if reading.of_text else ""),
                loads(f"SL, {moved}", offset, 0, emphasis=True),
                loads("SL, no offset", plain, 0),
                loads(f"SR, {moved}", offset, 1, emphasis=True),
                loads("SR, no offset", plain, 1),
            )
        )
    axes = "z / mm", "displacement / µm"
    straight = Series("Mei (both)", [0.0, 1e3 * float(case1.centreline_z[-1])], [0.0, 0.0], "line")
    line = Panel(
        "case 1: lateral displacement of the centreline", *axes, (*lateral(case1.centreline_z, case1.centreline), straight)
    )
    three = study.solve("lin-case3-offset")
    bend = Panel("case 3 with offset", *axes, lateral(three.centreline_z, three.centreline))
    return (
        Figure("cases-12", "Load distribution, case studies 1 and 2", (first, second)),
        Figure(
            "cases-3",
            "Load distribution, case study 3, all readings of the right end",
            tuple(panels),
            f"NR follows SL and NL follows SR to within {pairs_apart(study):.2f} N.",
        ),
        Figure("cases-centreline", "Centreline of the screw", (line, bend)),
    )


def oversized(scene: Scene) -> str:
    """The balls of a scene whose radii are off, in words."""
    return "; ".join(f"ball {ball} oversized by {1e6 * radius:g} µm" for ball, radius in scene.errors.balls.listed)


def offset_of(scene: Scene) -> float:
    """Largest displacement [m] that a support of a scene prescribes."""
    return max(abs(value) for support in scene.supports for freedom, value in support.fixed if freedom.startswith("u"))


def picture(scene: Scene, result: StaticResult, caption: str) -> LoadedScrew:
    """3D picture of a loaded screw."""
    held = result.load > 0.0
    arrows = result.contact_point[held], (result.force_direction * result.load[..., None])[held]
    title = "Case 3 with offset: contact forces on the balls"
    return LoadedScrew("loaded-screw", title, scene, result.load, *arrows, caption, turns=True)


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report."""
    step("cases 1, 2, 3 on four models")
    found = evidence(study, "lin-2.4.1")
    step("what the open choices change")
    rows = choice_rows(study.once(chapter_2.choices))
    offset = study.solve("lin-case3-offset")
    return Section(
        "cases",
        "Case studies 1, 2, 3 (2.4.1)",
        (
            printed_table("cases-claims", "Section 2.4.1: printed and computed", found),
            *figures(study),
            picture(
                study.scene("lin-case3-offset"),
                offset,
                "Arrows are the contact forces of all four sides, balls are coloured by their largest contact load.",
            ),
            summary_table(study),
            readings_table(study),
            Table.of(
                "cases-choices",
                "Case 1: what each open choice and each fault changes",
                rows,
                "Changes are against the first row, in per cent of its mean contact load.",
            ),
            load_table(study),
            Text(
                (
                    "The printed errors against ANSYS refer to loads that only a figure shows: section "
                    "reconstruction discusses where they may come from, section reference compares with "
                    "this project's own 3D reference. The printed ratio of case 1 is compared with the "
                    f"spread over the choices that the source leaves open: {chapter_2.spread_of_choices(study)}.",
                )
            ),
        ),
    )
