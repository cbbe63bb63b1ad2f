"""Report sections on chapter 2, Table B.1 and section 4.3.2 of Lin's thesis.

Case studies 1, 2 and 3 of 2.4.1: contact loads, centreline, interpretations of the right end's support, modelling choices.
Geometric errors of 2.4.2: each kind of error, combined errors, random errors as percentiles of random screws. Constants of
Table B.1: as printed, with the thesis's faults, and correct. Pitch and roundness errors of 4.3.2 on two screws. Agreement
of two solvers and of two kinematic forms of the same model.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product
from typing import Literal

import numpy as np

from rollbench.compare.cases.lin.evidence import chapter_2
from rollbench.compare.measure import error_percent, load_error
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import DEFAULT
from rollbench.compare.models.study import SceneResultCache, with_conformity
from rollbench.compare.printed import printed_entry, printed_value
from rollbench.compare.results.solving import solve_with_results
from rollbench.compare.sections.curves import contact_load_curve, contact_load_panel, lateral_displacement_curves
from rollbench.compare.sections.curves import scale_to_python_floats as floats
from rollbench.compare.studies.members.ensemble import RandomDrawsResult, random_draws_of_built_in_scene
from rollbench.lowfi.as_source.newton import solve_lin_equations_with_fallback
from rollbench.lowfi.statics.contacts import hertz_without_errors, misprinted_hertz_of_flanks
from rollbench.meshes.helix import lead_angle
from rollbench.meshes.parts import SIDES, Errors, Scene
from rollbench.reports.content import Cell, ColumnKey, Figure, LoadedScrew, Panel, Row, Section, Series, Table, Text


def end_support_table(cache: SceneResultCache) -> Table:
    """Return the table of largest and smallest loads in Lin's case 3 for each interpretation of the right end's support.

    ``cache``: gives solved scenes and stored 3D references.
    """
    rows: list[Row] = []
    for reading in chapter_2.END_SUPPORTS:
        for which in ("plain_scene", "offset_scene"):
            name, first = (getattr(one, which) for one in (reading, chapter_2.END_SUPPORTS[0]))
            found = cache.stored_reference(name)
            row: Row = {"scene": name, "right_end_restraint": reading.restraint}
            row["stated_by_lin"] = "yes" if reading.is_stated_by_text else "no"
            row["finest_level"] = "none stored" if found is None else f"level {found.runs[-1].level}"
            for model, words in (("lin", "Lin's model"), (DEFAULT, "refined model")):
                result = cache.solve_once(name, model)
                e = load_error(result.load, cache.solve_once(first, model).load)
                where = f"{e.ball} {e.side}" if e.max_percent > 0.0 else "–"
                row |= {
                    ("largest_load_by", words): float(result.load.max()),
                    ("smallest_load_by", words): float(result.load.min()),
                    ("change_by_support", words): e.max_percent,
                    ("at_largest_change_by", words): where,
                }
            rows.append(row)
    note = (
        "Lin's text prescribes only the x-displacement of the last node (2.4.1.3). A bearing there would also restrain the "
        "y-displacement, and perhaps rotations. Changes are from "
        "the loads with the support in the first line, with the same displacement of the right end."
    )
    return Table.from_rows(
        "cases-readings",
        "Lin's case study 3: largest and smallest contact loads, for each interpretation of the support at the right end",
        rows,
        note,
    )


# --- case studies 1, 2, 3 of Lin 2.4.1: contact loads, centreline, influence of modelling choices


#: Words for the last parts of the names of case study 3's scenes, and for the flanks.
END_WORDS = {"offset": "right end offset", "ux": "end held laterally in x only", "clamped": "end clamped"}
SIDE_WORDS = dict(zip(SIDES, ("screw left", "screw right", "nut left", "nut right"), strict=True))


def _scene_in_words(name: str) -> str:
    """Return a scene of Lin's case studies in words, such as "case 3, right end offset" for "lin-case3-offset"."""
    case, *rest = name.removeprefix("lin-").split("-")
    return ", ".join([case.replace("case", "case "), *(END_WORDS[part] for part in rest)])


def contact_loads_table(cache: SceneResultCache) -> Table:
    """Return the table of the contact loads of all case studies, with a row for each ball and a column for each flank.

    ``cache``: gives the solved scenes.
    """
    columns: dict[ColumnKey, Sequence[Cell]] = {"ball": range(1, 33)}
    for name in chapter_2.CASES:
        loads = cache.solve_once(name).load[:32].T
        for side, load in zip(SIDES, loads, strict=True):
            if (load > 0.0).any():
                columns["load_in_case", _scene_in_words(name), SIDE_WORDS[side]] = load.tolist()
    return Table("cases-loads", "Lin's case studies: contact loads of every ball", columns)


def largest_and_smallest_loads_table(cache: SceneResultCache) -> Table:
    """Return the table of largest and smallest load on each flank, with sums of forces and moments, for all case studies.

    ``cache``: gives the solved scenes.
    """
    rows: list[Row] = []
    for name in chapter_2.CASES:
        r = cache.solve_once(name)
        sums = r.equilibrium
        assert sums is not None
        for s, side in enumerate(SIDES):
            load = r.load[:, s]
            if (load > 0.0).any():
                rows.append(
                    {
                        "scene": name,
                        "flank": side,
                        "largest_load": float(load.max()),
                        "smallest_load": float(load.min()),
                        "load_ratio": chapter_2.load_ratio(load),
                        "ball_of_largest_load": int(load.argmax()) + 1,
                        "residual": r.solver.residual,
                        "force_sum": sums.force_residual,
                        "moment_sum": sums.moment_residual,
                        "status": r.status,
                    }
                )
    note = "Sums of forces and moments: loads, reactions and contact forces on the screw; zero in exact equilibrium."
    title = "Lin's case studies: smallest and largest contact loads on each flank, and balance of forces"
    return Table.from_rows("cases-summary", title, rows, note)


def case_study_figures(cache: SceneResultCache) -> tuple[Figure, ...]:
    """Draw contact loads of Lin's case studies 1 to 3 and the screw's centreline of cases 1 and 3.

    ``cache``: gives the solved scenes.
    """
    case1, mei, nut = (cache.solve_once("lin-case1", m) for m in ("lin", "mei", "mei-nut"))
    coarse = cache.solve_once(cache.scene_with_options("lin-case1", partition="source", section="groove squared"))
    case2 = cache.solve_once("lin-case2")
    first = contact_load_panel(
        "case 1, flanks SL = NR",
        contact_load_curve("low-order model", case1, 0, emphasis=True),
        contact_load_curve("Lin's beam elements, C.8 without root", coarse, 0),
        contact_load_curve("Mei, rigid nut", mei, 0),
        contact_load_curve("Mei, nut as a bar", nut, 0),
    )
    ((ball, radius),) = cache.built_in_scene("lin-case2").errors.balls.listed
    title = f"case 2, flanks SL = NR: ball {ball} oversized by {1e6 * radius:g} µm"
    second = contact_load_panel(
        title, contact_load_curve("case 2", case2, 0, emphasis=True), contact_load_curve("case 1", case1, 0)
    )
    panels = []
    for reading in chapter_2.END_SUPPORTS:
        plain, offset = cache.solve_once(reading.plain_scene), cache.solve_once(reading.offset_scene)
        supports = cache.built_in_scene(reading.offset_scene).supports
        moved = f"offset {1e6 * dict(supports[-1].fixed)['ux']:g} µm"
        panels.append(
            contact_load_panel(
                f"case 3, {reading.restraint} at the right end"
                + (" (as the text says)" if reading.is_stated_by_text else ""),
                contact_load_curve(f"SL, {moved}", offset, 0, emphasis=True),
                contact_load_curve("SL, no offset", plain, 0),
                contact_load_curve(f"SR, {moved}", offset, 1, emphasis=True),
                contact_load_curve("SR, no offset", plain, 1),
            )
        )
    loads = [cache.solve_once(name).load for name in chapter_2.CASES]
    off = max(float(np.abs(load[:, :2] - load[:, :1:-1]).max()) for load in loads)  # of opposite contacts
    axes = "z / mm", "displacement / µm"
    straight = Series("Mei (both)", [0.0, 1e3 * float(case1.centreline_z[-1])], [0.0, 0.0], "line")
    title, three = "lateral displacement of the centreline", cache.solve_once(chapter_2.END_SUPPORTS[0].offset_scene)
    curves = (*lateral_displacement_curves(case1.centreline_z, case1.centreline), straight)
    line = Panel(f"case 1: {title}", *axes, curves)
    bend = Panel(f"case 3 with offset: {title}", *axes, lateral_displacement_curves(three.centreline_z, three.centreline))
    return (
        Figure("cases-12", "Lin's case studies 1 and 2: contact load of each ball", (first, second)),
        Figure(
            "cases-3",
            "Lin's case study 3: contact load of each ball, for each interpretation of the support at the right end",
            tuple(panels),
            "SL, SR: left and right flank of the screw; NL, NR: left and right flank of the nut. Opposite contacts (SL and "
            f"NR, SR and NL) have equal loads within {off:.2f} N.",
        ),
        Figure("cases-centreline", "Lin's case studies 1 and 3: displacement of the screw's centreline", (line, bend)),
    )


def cases_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the report's section on Lin's case studies 1, 2 and 3: contact loads and centreline of the screw.

    ``cache``: gives solved scenes and stored 3D references; ``step``: function that receives a message before each step.
    """
    step("cases 1, 2 and 3 by four models")
    step("case 1 under each modelling choice")
    offset = chapter_2.END_SUPPORTS[0].offset_scene
    scene, result = cache.built_in_scene(offset), cache.solve_once(offset)
    held, title = result.load > 0.0, "Lin's case study 3, right end displaced: contact loads on the balls"
    arrows = result.contact_point[held], (result.force_direction * result.load[..., None])[held]
    view = solve_with_results(scene, result.model, ModelOptions(estimate_beam_mesh_error=False)).scene_view()
    caption = "Arrows: contact loads on the four flanks. Colour of a ball: its largest contact load."
    return Section(
        "cases",
        "Lin 2.4.1: contact loads in case studies 1, 2 and 3",
        (
            *case_study_figures(cache),
            LoadedScrew("loaded-screw", title, scene, result.load, *arrows, caption, replace(view, title=title)),
            largest_and_smallest_loads_table(cache),
            end_support_table(cache),
            Table.from_rows(
                "cases-choices",
                "Lin's case study 1: change of the contact loads by each modelling choice, and by each fault of the thesis",
                chapter_2.model_choice_rows(cache),
                "Changes are against the first row, in per cent of its mean contact load.",
            ),
            contact_loads_table(cache),
            Text(
                (
                    "The printed errors against ANSYS refer to loads that only a figure shows: section "
                    "reconstruction discusses where these errors may come from, section reference compares with "
                    "this project's own 3D reference. The printed ratio of case 1 is compared with the "
                    f"spread over the choices that Lin's thesis leaves open: {chapter_2.load_ratio_range_in_words(cache)}.",
                )
            ),
        ),
    )


def load_percentile_band(label: str, ensemble: RandomDrawsResult, side: int) -> Series:
    """Return the 5th to 95th percentile of the contact load of each ball over randomly drawn screws, as a band of a figure.

    ``label``: legend; ``ensemble``: results of the randomly drawn screws; ``side``: index of the flank in `SIDES`.
    """
    low, high = np.percentile(ensemble.loads[:, :, side], [5.0, 95.0], axis=0)
    return Series(label, floats(np.arange(1, low.size + 1)), floats(low), "band", floats(high))


def errors_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the report's section on contact loads with geometric errors: section 2.4.2 of Lin's thesis.

    ``cache``: gives the solved scenes; ``step``: function that receives a message before each step.
    """
    step("profile and pitch errors")
    base, profile, pitch = (cache.solve_once(n) for n in ("lin-case1", "lin-profile", "lin-pitch"))
    ensembles = {}
    for name in ("lin-random", "lin-combined"):
        step(f"{cache.built_in_scene(name).members} drawn screws of {name}")
        ensembles[name] = cache.compute_once(random_draws_of_built_in_scene, name)
    random, combined = ensembles["lin-random"], ensembles["lin-combined"]
    one, all_three = cache.solve_once("lin-random"), cache.solve_once("lin-combined")
    left = contact_load_panel(
        "one kind of error at a time, flanks SL = NR",
        contact_load_curve("no errors (case 1)", base, 0, emphasis=True),
        contact_load_curve("profile errors", profile, 0),
        contact_load_curve("pitch errors", pitch, 0),
        contact_load_curve("random ball radii, one draw", one, 0),
        load_percentile_band("random, 5 to 95 %", random, 0),
    )
    right = contact_load_panel(
        "all three kinds of error together",
        contact_load_curve("SL, one draw", all_three, 0, emphasis=True),
        contact_load_curve("SR, one draw", all_three, 1),
        load_percentile_band("SL, 5 to 95 %", combined, 0),
        load_percentile_band("SR, 5 to 95 %", combined, 1),
    )
    rows: list[Row] = []
    for (name, e), s in product(ensembles.items(), (0, 1)):
        load = e.loads[:, :, s]
        row: Row = {"scene": name, "random_screws": len(load), "flank": SIDES[s]}
        for end, value in zip(("p5", "median", "p95"), np.percentile(load.max(axis=1), [5, 50, 95]), strict=True):
            row[f"largest_load_{end}"] = float(value)
        row["load_ratio_median"] = None if s else float(np.median([*map(chapter_2.load_ratio, load)]))
        row["unloaded_balls_mean"] = float((load == 0.0).sum(axis=1).mean())
        rows.append(row | {"random_screws_failed": sum(x != "converged" for x in e.statuses)})
    kinds = ("lin-case2", "lin-profile", "lin-pitch", "lin-random", "lin-combined")
    changes: list[Row] = [
        {
            "scene": name,
            "largest_load_f1": float(load.max()),
            "load_ratio_on_sl": chapter_2.load_ratio(load[:, 0]),
            "largest_change": e2.max_percent,
            "rms_change": e2.rms_percent,
            "at_largest_change": f"{e2.ball} {e2.side}",
            "balls_on_sr": int((load[:, 1] > 0).sum()),
        }
        for name, load in ((name, cache.solve_once(name).load) for name in kinds)
        for e2 in (load_error(load, base.load),)
    ]
    return Section(
        "errors",
        "Lin 2.4.2: contact loads with geometric errors",
        (
            Figure(
                "errors-loads",
                "Lin 2.4.2: contact load of each ball, with geometric errors of screw and balls",
                (left, right),
                f"Bands: 5th to 95th percentile of each ball's load over {len(random.loads)} random screws in the left "
                f"panel and {len(combined.loads)} in the right one.",
            ),
            Table.from_rows(
                "errors-changes",
                "Lin 2.4.2: change of the contact loads from case study 1 by each kind of geometric error",
                changes,
            ),
            Table.from_rows(
                "errors-bands",
                "Lin 2.4.2: largest contact load and number of unloaded balls of screws with random errors",
                rows,
            ),
        ),
    )


def hertz_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the report's section on the Hertz constants of Lin's Table B.1, as printed and correct.

    ``cache``: gives the scenes included with rollbench; ``step``: function that receives a message before each step.
    """
    step("Table B.1")
    case = cache.built_in_scene("lin-case1")
    compared = [
        ("Table 2.1's groove, 3.254 mm", case),
        ("Table B.1's groove, 0.56 x diameter", with_conformity(case, chapter_2.TABLE_CONFORMITY)),
    ]
    constants: list[Row] = []
    for label, scene in compared:
        right, faulty = hertz_without_errors(scene), misprinted_hertz_of_flanks(scene)
        for name, side, printed in zip(("screw", "nut"), (0, 3), faulty, strict=True):
            C, cube_root = float(right.C[side]), 225.0 ** (1 / 3)
            constants.append(
                {
                    "groove_radius": label,
                    "touching_body": name,
                    "hertz_constant": C,
                    "hertz_constant_lin": printed.C,
                    "hertz_constant_error": float(error_percent(printed.C, C)),
                    "approach_at_225_N": 1e6 * C * 225.0 ** (2 / 3),
                    "semi_axis_a_at_225_N": 1e3 * float(right.C_a[side]) * cube_root,
                    "semi_axis_b_at_225_N": 1e3 * float(right.C_b[side]) * cube_root,
                    "pressure_at_225_N": 1e-6 * float(right.pressure(np.array(225.0))[side]),
                }
            )
    return Section(
        "hertz",
        "Lin, Table B.1: Hertz constants, as printed and correct",
        (
            Text(
                (
                    "Table B.1 comes out to every printed digit when the thesis's faults are repeated: a groove radius "
                    "of 0.56 ball diameters instead of Table 2.1's 3.254 mm, eigenvalues of the second fundamental form "
                    "alone, a correction factor of 1, and the ratio of B.8 inverted against the table's labels. The "
                    "correct values use I⁻¹ II and exact elliptic integrals with the same groove radius.",
                )
            ),
            Table.from_rows(
                "hertz-grooves",
                "Hertz constant C, as printed and correct, for two groove radii; size and pressure of the contact at a "
                "load of 225 N",
                constants,
            ),
        ),
    )


def equivalent_errors_panel(scene: Scene) -> Panel:
    """Draw, over the azimuth, pitch and roundness errors along the contact normal (Lin's equations 4.2 and 4.4).

    ``scene``: screw whose lead and contact angle are used.
    """
    phi = np.linspace(0.0, 2.0 * np.pi, 181)
    alpha, beta = lead_angle(scene.track), scene.track.contact_angle
    size = {key: printed_value("lin-4.3.2", key) for key in ("e_p", "e_R")}
    pitch = size["e_p"] * np.cos(alpha) * np.sin(beta) * np.sin(phi)
    roundness = size["e_R"] * np.cos(beta) * np.sin(2.0 * phi)
    errors = {"pitch error": pitch, "roundness error": roundness}
    series = [Series(name, floats(np.degrees(phi)), floats(values), "line") for name, values in errors.items()]
    return Panel("equivalent error along the contact normal", "azimuth", "error / µm", series)


def manufacturing_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the report's section on contact loads with pitch and with roundness errors: section 4.3.2 of Lin's thesis.

    ``cache``: gives the solved scenes; ``step``: function that receives a message before each step.
    """
    panels = [equivalent_errors_panel(cache.built_in_scene("lin-pitch-4p1"))]
    rows: list[Row] = []
    for screw, label in chapter_2.SCREWS.items():
        step(f"pitch and roundness errors on the screw of {label}")
        curves = []
        for kind in ("pitch", "roundness"):
            scene = cache.built_in_scene(f"lin-{kind}-{screw}")
            curves.append(contact_load_curve(f"{kind} error", cache.solve_once(scene), 0, emphasis=True))
            for reading, variant in chapter_2.scenes_with_unprinted_inputs_varied(scene):
                r = cache.solve_once(variant)
                third = r.load[:, [1, 2]]
                rows.append(
                    {
                        "screw_of_thesis": label,
                        "geometric_error": kind,
                        "input_assumption": reading,
                        "largest_load_on_sl": float(r.load[:, 0].max()),
                        "smallest_load_on_sl": float(r.load[:, 0].min()),
                        "load_scatter_on_sl": chapter_2.relative_load_scatter(r),
                        "unloaded_balls": int(chapter_2.balls_without_load(r).sum()),
                        "balls_with_third_load": int((third > 0.0).any(axis=1).sum()),
                        "largest_third_load": float(third.max()),
                        "status": r.status,
                    }
                )
        bare = replace(cache.built_in_scene(f"lin-pitch-{screw}"), errors=Errors())
        curves.append(contact_load_curve("no errors", cache.solve_once(bare), 0))
        title = f"screw of {label}, 1000 N: contact loads on flank SL"
        panels.append(Panel(title, "ball", "contact_load", tuple(curves), integer_x=True))
    return Section(
        "manufacturing",
        "Lin 4.3.2: contact loads with pitch errors and with roundness errors",
        (
            Figure(
                "manufacturing-loads",
                "Pitch and roundness errors of a steering gear's ball screw, and their contact loads (Lin 4.3.2)",
                tuple(panels),
                "",
                3,
            ),
            Table.from_rows(
                "manufacturing-readings",
                "Contact loads with pitch or roundness errors (Lin 4.3.2), for each assumption on unprinted inputs",
                rows,
                "Lin states that all balls have two loaded contacts, here on SL and NR (left flank of the screw, right "
                "flank of the nut). This needs a clearance in the grooves, not printed.",
            ),
            Text(
                (
                    "The conclusion holds: roundness error unloads balls and pitch error does not. One cycle per turn "
                    "of pitch error is nearly a tilt of the screw, which the screw can follow; two cycles per turn are "
                    "not. The statement that all balls stay in two-point contact does not hold without clearance: "
                    f"a groove displaced by {printed_entry('lin-4.3.2', 'e_p').number_as_printed} µm touches balls on "
                    "their unloaded side.",
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


#: Equations to which Lin's Newton method is applied: those of the energy solver, and those of his thesis.
KINEMATICS: tuple[Literal["arc", "source"], ...] = ("arc", "source")


def solver_agreement_row(cache: SceneResultCache, name: str) -> Row:
    """Return the table row of a scene's load differences [% of mean load], Lin's Newton method against the energy solver.

    The row also has the numbers of iterations. ``cache``: gives the solved scenes; ``name``: name of the scene.
    """
    scene, by_energy = cache.built_in_scene(name), cache.solve_once(name)
    solver = by_energy.solver
    row: Row = {"scene": name, "energy_iterations": solver.iterations, "residual": solver.residual}
    for kinematics in KINEMATICS:
        by_source = solve_lin_equations_with_fallback(scene, kinematics)
        off = load_error(by_energy.load, by_source.contact_loads).max_percent if by_source.converged else None
        row[f"newton_difference_{kinematics}"] = off
        row[f"newton_iterations_{kinematics}"] = by_source.iterations
    for arm in ("nominal", "ball"):
        frozen = cache.solve_once(cache.scene_with_options(name, arm=arm))
        row[f"change_by_arm_{arm}"] = load_error(frozen.load, by_energy.load).max_percent
    return row | {"newton_status": by_source.status}


def formulations_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the report's section that compares Lin's Newton method with an energy solver, for two forms of his equations.

    ``cache``: gives the solved scenes; ``step``: function that receives a message before each step.
    """
    step("both solvers on every scene")
    return Section(
        "formulations",
        "Lin's static model: the same contact loads by his Newton method and by energy minimisation",
        (
            Text(
                (
                    "The energy solver eliminates contact angles and ball centres and minimises a convex energy; the "
                    "source's own equations (2.25) keep them as unknowns and are solved by plain Newton (2.26), dense, "
                    "with a Jacobian of their own. On the same equations both solvers agree to round-off.",
                    "The remaining difference between the two forms is kinematic. Here the groove's arc moves rigidly "
                    "with the section at the nominal contact, so that every contact load keeps its line of action "
                    "through the arc's centre. In Lin's form the point of application, its lever arm and its "
                    "station follow the contact angle, and a linearised rotation stretches the arc by half the square "
                    "of the rotation. A lever arm fixed at the nominal contact changes the loads by more.",
                )
            ),
            Table.from_rows(
                "formulations-agreement",
                "Difference of contact loads between Lin's Newton method and the energy solver, for each case",
                [solver_agreement_row(cache, name) for name in SCENES],
                "Load differences: Lin's Newton method against the energy solver. Load changes: energy solver; by default, "
                "contact forces act at the current contact points.",
            ),
        ),
    )
