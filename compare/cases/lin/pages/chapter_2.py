"""Lin's chapter 2 in the report, with Table B.1 and section 4.3.2; each function makes one section.

Case studies 1, 2 and 3 of 2.4.1: load distributions, centreline, claims, interpretations of the right end, modelling
choices. Geometric errors of 2.4.2, alone and combined, with random errors as bands over drawn screws. Hertz constants
as printed, with the source's faults repeated, and correct. Pitch against roundness errors (4.3.2) on two screws, and
how the claims depend on inputs that are not printed. The agreement of two solvers of the same equations, and the
measured difference between the two kinematic forms.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from rollbench.compare.cases.lin.evidence import chapter_2
from rollbench.compare.cases.lin.evidence.chapter_2 import SCREWS, TABLE_CONFORMITY, ratio, readings, spread, unloaded
from rollbench.compare.measure import error_percent, load_error
from rollbench.compare.models.load_cases import solve_one
from rollbench.compare.models.registry import DEFAULT, Options
from rollbench.compare.models.study import Study, with_groove
from rollbench.compare.printed import entry, value_of
from rollbench.compare.results.scene_json import case_json
from rollbench.compare.results.view import view_of
from rollbench.compare.sections.curves import lateral, load_panel, loads
from rollbench.compare.studies.members.ensemble import EnsembleResult, ensemble_of_study
from rollbench.lowfi.as_source import best_start
from rollbench.lowfi.statics.contacts import error_free_hertz, printed_sides
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.helix import lead_angle
from rollbench.meshes.parts import SIDES, Errors, Scene
from rollbench.reports.content import Figure, LoadedScrew, Panel, Quantity, Row, Section, Series, Table, Text


def reference_words(study: Study, name: str) -> str:
    """Return the text that says which 3D reference a scene has."""
    found = study.reference(name)
    return "none stored" if found is None else f"level {found.runs[-1].level}"


def readings_table(study: Study) -> Table:
    """Return the table of load extremes by interpretation of the right end, and changes against the first one."""
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
    """Return rows of the table of choices."""
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
    """Return loads of all cases and flanks, ball by ball."""
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
    """Return the table of largest and smallest load per flank, with balance and residual, of each case study."""
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
    """Return the largest load difference [N] between opposite contacts of a ball in all case studies."""
    return max(float(np.abs(study.solve(n).load[:, :2] - study.solve(n).load[:, :1:-1]).max()) for n in chapter_2.CASES)


def figures(study: Study) -> tuple[Figure, ...]:
    """Draw the load distributions of cases 1 to 3 and the centreline of case 1."""
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
    """Return the balls of a scene whose radii are off, in words."""
    return "; ".join(f"ball {ball} oversized by {1e6 * radius:g} µm" for ball, radius in scene.errors.balls.listed)


def offset_of(scene: Scene) -> float:
    """Return the largest displacement [m] that a support of a scene prescribes."""
    return max(abs(value) for support in scene.supports for freedom, value in support.fixed if freedom.startswith("u"))


def picture(scene: Scene, result: StaticResult, caption: str) -> LoadedScrew:
    """Return a 3D picture of a loaded screw."""
    held = result.load > 0.0
    arrows = result.contact_point[held], (result.force_direction * result.load[..., None])[held]
    title = "Case 3 with offset: contact loads on the balls"
    one = solve_one(scene, result.model, Options(discretisation=False))
    view = view_of(title, [one], case_json(one))
    return LoadedScrew("loaded-screw", title, scene, result.load, *arrows, caption, view)


def cases_section(study: Study, step: Callable[[str], None]) -> Section:
    """Return the report section on case studies 1, 2 and 3."""
    step("cases 1, 2, 3 on four models")
    step("what the open choices change")
    rows = choice_rows(study.once(chapter_2.choices))
    offset = study.solve("lin-case3-offset")
    return Section(
        "cases",
        "Case studies 1, 2, 3 (2.4.1)",
        (
            *figures(study),
            picture(
                study.scene("lin-case3-offset"),
                offset,
                "Arrows are the contact loads of all four flanks, balls are coloured by their largest contact load.",
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


def band(label: str, ensemble: EnsembleResult, side: int) -> Series:
    """Return the band from the 5th to the 95th percentile of a flank's loads over the ball number."""
    low, high = np.percentile(ensemble.loads[:, :, side], [5.0, 95.0], axis=0)
    balls = [float(i + 1) for i in range(low.size)]
    return Series(label, balls, [float(x) for x in low], "band", [float(x) for x in high])


def errors_section(study: Study, step: Callable[[str], None]) -> Section:
    """Return the report section on geometric errors."""
    step("profile and pitch errors")
    base, profile, pitch = (study.solve(n) for n in ("lin-case1", "lin-profile", "lin-pitch"))
    ensembles = {}
    for name in ("lin-random", "lin-combined"):
        step(f"{study.scene(name).members} drawn screws of {name}")
        ensembles[name] = ensemble_of_study(study, name)
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


def hertz_section(study: Study, step: Callable[[str], None]) -> Section:
    """Return the report section on Hertz constants."""
    step("Table B.1")
    case = study.scene("lin-case1")
    compared = [
        ("Table 2.1's groove, 3.254 mm", case),
        ("Table B.1's groove, 0.56 x diameter", with_groove(case, TABLE_CONFORMITY)),
    ]
    constants: list[Row] = []
    for label, scene in compared:
        right, faulty = error_free_hertz(scene), printed_sides(scene)
        for name, side, printed in zip(("screw", "nut"), (0, 3), faulty, strict=True):
            C = float(right.C[side])
            constants.append(
                {
                    "groove": label,
                    "side": name,
                    Quantity("right", "C, right", "m/N^(2/3)", "g5"): C,
                    Quantity("faulty", "C, as printed", "m/N^(2/3)", "g5"): printed.C,
                    Quantity("error", "as printed against right", "%", ".1f"): float(error_percent(printed.C, C)),
                    Quantity("approach", "approach", "µm", ".3f"): 1e6 * C * 225.0 ** (2 / 3),
                    Quantity("a", "semi-axis a", "mm", ".4f"): 1e3 * float(right.C_a[side]) * 225.0 ** (1 / 3),
                    Quantity("b", "semi-axis b", "mm", ".4f"): 1e3 * float(right.C_b[side]) * 225.0 ** (1 / 3),
                    Quantity("p0", "pole pressure", "MPa", ".1f"): 1e-6 * float(right.pressure(np.array(225.0))[side]),
                }
            )
    return Section(
        "hertz",
        "Hertz contact: Table B.1",
        (
            Text(
                (
                    "Table B.1 comes out to every printed digit when the source's faults are repeated: a groove radius "
                    "of 0.56 ball diameters instead of Table 2.1's 3.254 mm, eigenvalues of the second fundamental form "
                    "alone, a correction factor of 1, and the ratio of B.8 inverted against the table's labels. The "
                    "right values use I⁻¹ II and exact elliptic integrals with the same groove radius.",
                )
            ),
            Table.of(
                "hertz-grooves",
                "What the faults and the groove radius do to the Hertz constant, and the contact at 225 N",
                constants,
            ),
        ),
    )


def equivalent_errors(scene: Scene) -> Panel:
    """Return the panel of pitch and roundness errors along the nominal contact normal over azimuth (Lin 4.2, 4.4)."""
    phi = np.linspace(0.0, 2.0 * np.pi, 181)
    alpha, beta = lead_angle(scene.track), scene.track.contact_angle
    size = {key: value_of("lin-4.3.2", key) for key in ("e_p", "e_R")}
    pitch = size["e_p"] * np.cos(alpha) * np.sin(beta) * np.sin(phi)
    roundness = size["e_R"] * np.cos(beta) * np.sin(2.0 * phi)
    degrees = [float(x) for x in np.degrees(phi)]
    return Panel(
        "equivalent error along the contact normal",
        "azimuth / deg",
        "error / µm",
        (
            Series("pitch error", degrees, [float(x) for x in pitch], "line"),
            Series("roundness error", degrees, [float(x) for x in roundness], "line"),
        ),
    )


def manufacturing_section(study: Study, step: Callable[[str], None]) -> Section:
    """Return the report section on manufacturing errors (4.3.2)."""
    panels = [equivalent_errors(study.scene("lin-pitch-4p1"))]
    rows: list[Row] = []
    for screw, label in SCREWS.items():
        step(f"pitch and roundness errors on the screw of {label}")
        curves = []
        for kind in ("pitch", "roundness"):
            scene = study.scene(f"lin-{kind}-{screw}")
            curves.append(loads(f"{kind} error", study.solve(scene), 0, emphasis=True))
            for reading, variant in readings(scene):
                r = study.solve(variant)
                third = r.load[:, [1, 2]]
                rows.append(
                    {
                        "screw": label,
                        "error": kind,
                        "reading": reading,
                        Quantity("max", "max SL", "N", ".1f"): float(r.load[:, 0].max()),
                        Quantity("min", "min SL", "N", ".1f"): float(r.load[:, 0].min()),
                        Quantity("spread", "st. dev. / mean", "", ".3f"): spread(r),
                        Quantity("lost", "balls without contact", "", "s"): int(unloaded(r).sum()),
                        Quantity("third", "balls with a third contact", "", "s"): int((third > 0.0).any(axis=1).sum()),
                        Quantity("third_max", "largest third contact", "N", ".1f"): float(third.max()),
                        "status": r.status,
                    }
                )
        bare = replace(study.scene(f"lin-pitch-{screw}"), errors=Errors())
        curves.append(loads("no errors", study.solve(bare), 0))
        panels.append(Panel(f"screw of {label}, 1000 N: SL", "ball", "contact load / N", tuple(curves), integer_x=True))
    return Section(
        "manufacturing",
        "Steering gear (4.2), pitch against roundness errors (4.3.2)",
        (
            Figure("manufacturing-loads", "Errors and load distribution", tuple(panels), "", 3),
            Table.of(
                "manufacturing-readings",
                "How the findings depend on what is not printed",
                rows,
                "The source's statement of two-point contact needs clearance in the grooves, which it does not give.",
            ),
            Text(
                (
                    "The conclusion holds: roundness error unloads balls and pitch error does not. One cycle per turn "
                    "of pitch error is nearly a tilt of the screw, which the screw can follow; two cycles per turn are "
                    "not. The statement that all balls stay in two-point contact does not hold without clearance: "
                    f"a groove displaced by {entry('lin-4.3.2', 'e_p').printed} µm touches balls on their unloaded side.",
                )
            ),
        ),
    )


SCENES = (
    "lin-case1",
    "lin-case2",
    "lin-case3",
    "lin-case3-offset",
    "lin-case3-clamped",
    "lin-case3-offset-clamped",
    "lin-pitch",
    "lin-random",
    "lin-nominal-4p1",
)


def agreement(study: Study, name: str) -> Row:
    """Return the row of load differences between the source's and the energy solver on a scene [% of mean load]."""
    scene, by_energy = study.scene(name), study.solve(name)
    solver = by_energy.solver
    row: Row = {
        "scene": name,
        Quantity("iterations", "iterations, energy solver", "", "s"): solver.iterations,
        Quantity("residual", "residual", "", "g2"): solver.residual,
    }
    kinds: tuple[tuple[Literal["arc", "source"], str, str, str], ...] = (
        ("arc", "same equations", "g2", "iterations, source's Newton"),
        ("source", "source's own kinematics", "g3", "iterations"),
    )
    for kinematics, heading, form, counted in kinds:
        by_source = best_start(scene, kinematics)
        off = load_error(by_energy.load, by_source.load).max_percent if by_source.converged else None
        row[Quantity(kinematics, heading, "% of mean", form)] = off
        row[Quantity(f"{kinematics}_iterations", counted, "", "s")] = by_source.iterations
    for arm, heading in (("nominal", "arm frozen at nominal contact"), ("ball", "force at the ball's station")):
        frozen = study.solve(study.changed(name, arm=arm))
        row[Quantity(arm, heading, "% of mean", ".3f")] = load_error(frozen.load, by_energy.load).max_percent
    return row | {Quantity("source_status", "status of the source's Newton", "", "s"): by_source.status}


def formulations_section(study: Study, step: Callable[[str], None]) -> Section:
    """Return the report section on the two solvers and the two kinematic forms."""
    rows = []
    for name in SCENES:
        step(f"both solvers on {name}")
        rows.append(agreement(study, name))
    return Section(
        "formulations",
        "Two formulations of the same model",
        (
            Text(
                (
                    "The energy solver eliminates contact angles and ball centres and minimises a convex energy; the "
                    "source's own equations (2.25) keep them as unknowns and are solved by plain Newton (2.26), dense, "
                    "with a Jacobian of their own. On the same equations both agree to round-off.",
                    "The remaining difference between the two forms is kinematic. Here the groove's arc moves rigidly "
                    "with the section at the nominal contact, so that every contact load keeps its line of action "
                    "through the arc's centre. In the source's form the point of application, its lever arm and its "
                    "station follow the contact angle, and a linearised rotation stretches the arc by half the square "
                    "of the rotation. Freezing the lever arm at the nominal contact changes more than either.",
                )
            ),
            Table.of("formulations-agreement", "Differences of the loads", rows),
        ),
    )
